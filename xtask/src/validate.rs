// SPDX-License-Identifier: MIT OR Apache-2.0
//! The theory held against the full problem: boundary and finite elements in Python (validation/), whose results are stored, and
//! the pages and pictures of docs/report made of them. What is published about many grains and single impacts is compared in the same
//! way, with LAMMPS.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result};

use crate::progress::{human_time, say};
use crate::python_environment::Environment;
use crate::workspace::root;
use crate::{lammps, liggghts, mpi, plugin, process, python};

#[derive(clap::Args)]
pub struct Options {
    /// Only this comparison [default: all]
    comparison: Vec<Comparison>,
    /// Make page and picture of the stored results alone, in seconds
    #[arg(long)]
    page: bool,
    /// Hold the stored results against new coarse computations, in seconds, and write nothing
    #[arg(long, conflicts_with_all = ["comparison", "page"])]
    check: bool,
    /// Words for the program of the comparison: `packings -- --grains 1000 --realisations 3`, or `packings -- --go-on`
    #[arg(last = true, requires = "comparison")]
    words: Vec<String>,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
pub enum Comparison {
    /// The elastic normal force: boundary elements, exact shapes, whole bodies by finite elements
    #[value(name = "elastic-contact")]
    Elastic,
    /// Friction: partial slip by boundary elements, in cycles
    #[value(name = "tangential-contact")]
    Tangential,
    /// Viscosity: the Kelvin-Voigt half-space with its exact memory
    #[value(name = "viscoelastic-contact")]
    Viscoelastic,
    /// Collisions of two ellipsoids by finite elements with inertia: force over time, rebound, spin, vibration; and through LAMMPS and
    /// LIGGGHTS, by their own laws too, where they can be had
    #[value(name = "collisions")]
    Collisions,
    /// Random packings against shape, with LAMMPS: solid fraction and coordination
    #[value(name = "packings")]
    Packings,
    /// Single grains, with LAMMPS: the tests of Chung and Ooi, and impacts that were measured
    #[value(name = "single-grains")]
    SingleGrains,
    /// A drum and a hopper of 5 000 grains to their end, with LAMMPS and LIGGGHTS: balance of energies, ranks, restart, discharge
    #[value(name = "scenes")]
    Scenes,
}

impl Comparison {
    const ALL: [Comparison; 7] = [
        Comparison::Elastic,
        Comparison::Tangential,
        Comparison::Viscoelastic,
        Comparison::Collisions,
        Comparison::Packings,
        Comparison::SingleGrains,
        Comparison::Scenes,
    ];

    /// Its folder in validation.
    fn folder(self) -> &'static str {
        match self {
            Comparison::Elastic => "elastic_contact",
            Comparison::Tangential => "tangential_contact",
            Comparison::Viscoelastic => "viscoelastic_contact",
            Comparison::Collisions => "collisions",
            Comparison::Packings => "packings",
            Comparison::SingleGrains => "single_grains",
            Comparison::Scenes => "scenes",
        }
    }

    fn needs_lammps(self) -> bool {
        matches!(
            self,
            Comparison::Packings | Comparison::SingleGrains | Comparison::Scenes
        )
    }

    fn needs_liggghts(self) -> bool {
        matches!(self, Comparison::Scenes)
    }

    /// Its main part does without engines.
    fn takes_engines_where_they_are(self) -> bool {
        matches!(self, Comparison::Collisions)
    }
}

pub fn validate(options: &Options) -> Result<()> {
    if options.check {
        return check(environment()?);
    }
    if options.comparison.is_empty() {
        make(&Comparison::ALL, options.page, &[])
    } else {
        make(&options.comparison, options.page, &options.words)
    }
}

/// Makes these comparisons, with `words` for their programs, or of what is stored `pages` alone.
pub fn make(chosen: &[Comparison], pages: bool, words: &[String]) -> Result<()> {
    let programs = Programs::with(environment()?)?;
    for comparison in chosen {
        let folder = directory().join(comparison.folder());
        let started = Instant::now();
        if !pages {
            say(format!("== {}", comparison.folder()));
            let mut compare = programs.python();
            if comparison.needs_lammps() {
                with_lammps(&mut compare)?;
                mpi::let_ranks_share_cores(&mut compare)?;
            }
            if comparison.needs_liggghts() {
                with_liggghts(&mut compare)?;
            }
            if comparison.takes_engines_where_they_are() {
                // The program says what it leaves out.
                for (engine, found) in [
                    ("LAMMPS", with_lammps(&mut compare)),
                    ("LIGGGHTS", with_liggghts(&mut compare)),
                ] {
                    if let Err(error) = found {
                        say(format!("NO {engine}: {error:#}"));
                    }
                }
            }
            process::run_open(compare.arg(folder.join("compare.py")).args(words))?;
        }
        process::run_open(programs.python().arg(folder.join("page.py")))?;
        say(format!(
            "{} in {}",
            comparison.folder(),
            human_time(started.elapsed())
        ));
    }
    Ok(())
}

fn with_lammps(compare: &mut Command) -> Result<()> {
    let source = lammps::source()?;
    compare
        .env("ELLGRAN_LAMMPS", source.binary()?)
        .env("ELLGRAN_LAMMPS_PLUGIN", plugin::plugin(&source)?)
        .env("ELLGRAN_LAMMPS_VERSION", source.spelled()?);
    Ok(())
}

fn with_liggghts(compare: &mut Command) -> Result<()> {
    compare.env("ELLGRAN_LIGGGHTS", liggghts::binary()?);
    Ok(())
}

/// The stored results against the present law and coarse computations.
pub fn check(environment: Environment) -> Result<()> {
    process::run_open(
        Programs::with(environment)?
            .python()
            .args(["-m", "pytest", "-q", "-p", "no:cacheprovider"])
            .arg(directory().join("tests")),
    )
}

fn directory() -> PathBuf {
    root().join("validation")
}

/// The packages of validation/requirements.txt, installed when missing.
pub fn environment() -> Result<Environment> {
    Environment::pinned(&directory().join("requirements.txt"))
        .context("the comparisons with the full problem need packages for this Python")
}

/// These packages, and the shared library of this checkout.
struct Programs {
    environment: Environment,
    prefix: tempfile::TempDir,
}

impl Programs {
    fn with(environment: Environment) -> Result<Self> {
        Ok(Programs {
            environment,
            prefix: python::library()?,
        })
    }

    /// One thread a program, so that a result does not depend on how many cores there are.
    fn python(&self) -> Command {
        let mut command = self.environment.python();
        command
            .current_dir(directory())
            .env("ELLGRAN_LIBRARY", library_in(self.prefix.path()))
            .env("PYTHONPATH", python_path())
            .env("PYTHONDONTWRITEBYTECODE", "1")
            .env("MPLBACKEND", "svg")
            .env("OMP_NUM_THREADS", "1")
            .env("OPENBLAS_NUM_THREADS", "1");
        command
    }
}

fn library_in(prefix: &Path) -> PathBuf {
    prefix.join("lib").join("libellgran.so")
}

fn python_path() -> std::ffi::OsString {
    std::env::join_paths([root().join("python"), directory()])
        .expect("the checkout's path holds no colon")
}

#[cfg(test)]
mod tests {
    use super::{directory, Comparison};

    #[test]
    fn each_comparison_has_its_programs_and_its_page() {
        for comparison in Comparison::ALL {
            let folder = directory().join(comparison.folder());
            for file in ["compare.py", "page.py", "origin.json"] {
                assert!(folder.join(file).is_file(), "{}/{file}", folder.display());
            }
            let page = comparison.folder().replace('_', "-");
            let page = crate::workspace::root().join(format!("docs/report/{page}.md"));
            assert!(page.is_file(), "{}", page.display());
        }
    }
}
