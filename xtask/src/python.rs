// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tests of the Python module, in virtual environments of the cache, against the shared library of this checkout.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Result;

use crate::progress::say;
use crate::python_environment::Environment;
use crate::workspace::root;
use crate::{install, process, setup};

#[derive(clap::Args)]
pub struct Options {
    /// Run only the tests whose name contains this
    #[arg(long)]
    filter: Option<String>,
    /// Print what the vectorised law costs beside the C call, in place of the tests
    #[arg(long)]
    cost: bool,
}

/// A LAMMPS binary and the plugin built for it.
pub type Engine<'a> = (&'a Path, &'a Path);

/// `cargo xtask python`
pub fn python(options: &Options) -> Result<()> {
    if options.cost {
        let prefix = library()?;
        let interpreter = environment("requirements.txt")?;
        let script = directory().join("benchmarks").join("cost_of_arrays.py");
        return process::run_open(in_environment(&interpreter, prefix.path()).arg(script));
    }
    run(options.filter.as_deref(), None)
}

/// All tests; those that run a deck need an engine, and say so where there is none.
pub fn test(engine: Option<Engine>) -> Result<()> {
    run(None, engine)
}

fn run(filter: Option<&str>, engine: Option<Engine>) -> Result<()> {
    let prefix = library()?;
    // The oldest numpy that is supported has no wheel for a Python that came after it.
    let oldest = match environment("requirements-oldest.txt") {
        Ok(interpreter) => Some(interpreter),
        Err(error) => {
            say(format!(
                "NOT TESTED: Python with the oldest numpy: {error:#}"
            ));
            None
        }
    };
    let newest = environment("requirements.txt")?;
    for interpreter in oldest.into_iter().chain([newest]) {
        let mut command = in_environment(&interpreter, prefix.path());
        command
            .args(["-m", "pytest", "-q", "-p", "no:cacheprovider"])
            .arg(directory().join("tests"));
        if let Some(words) = filter {
            command.args(["-k", words]);
        }
        if let Some((lammps, plugin)) = engine {
            command
                .env("ELLGRAN_TEST_LAMMPS", lammps)
                .env("ELLGRAN_TEST_LAMMPS_PLUGIN", plugin)
                .envs(setup::mpirun_environment());
        }
        process::run_open(&mut command)?;
    }
    Ok(())
}

fn directory() -> PathBuf {
    root().join("python")
}

/// A prefix with the shared library of this checkout.
pub fn library() -> Result<tempfile::TempDir> {
    let prefix = tempfile::tempdir()?;
    install::with_shared(prefix.path())?;
    Ok(prefix)
}

fn in_environment(interpreter: &Path, prefix: &Path) -> Command {
    let mut command = Command::new(interpreter);
    command
        .current_dir(directory())
        .env("ELLGRAN_LIBRARY", prefix.join("lib").join("libellgran.so"))
        .env("ELLGRAN_INCLUDE", root().join("include"))
        .env("PYTHONPATH", directory())
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("PYTHONWARNINGS", "error::DeprecationWarning:ellgran");
    command
}

/// The interpreter of a virtual environment with the packages that a file in python/tests names.
fn environment(requirements: &str) -> Result<PathBuf> {
    let file = directory().join("tests").join(requirements);
    Ok(Environment::pinned(&file)?.program("python"))
}
