// SPDX-License-Identifier: MIT OR Apache-2.0
//! One run of a LAMMPS deck, and the columns of numbers that it leaves.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::process::{output_of, run_logged};
use crate::progress::Progress;
use crate::{lammps, plugin, workspace};

pub struct Engine {
    binary: PathBuf,
    plugin: PathBuf,
    /// The release, as LAMMPS spells it.
    pub release: String,
    /// Has it `pair_style granular/superellipsoid`, which came in 2026?
    pub superellipsoid: bool,
    /// Where runs write.
    pub data: PathBuf,
}

impl Engine {
    /// Fetches and builds what is missing.
    pub fn prepare(data: &Path) -> Result<Self> {
        let source = lammps::source()?;
        let binary = source.binary()?;
        let plugin = plugin::plugin(&source)?;
        fs::create_dir_all(data)?;
        let help = output_of(Command::new(&binary).arg("-help"))?;
        Ok(Engine {
            superellipsoid: help
                .split_whitespace()
                .any(|word| word == "granular/superellipsoid"),
            release: source.spelled()?,
            binary,
            plugin,
            data: data.canonicalize()?,
        })
    }

    /// Runs `deck`, a path below examples/lammps, with the plugin and the given variables. `name` is the log's.
    pub fn run(&self, deck: &str, name: &str, variables: &[(&str, &str)]) -> Result<()> {
        let deck = workspace::root().join("examples/lammps").join(deck);
        // One rank: ranks wait for each other by spinning, which stands still on a busy machine.
        let mut command = Command::new(&self.binary);
        // Decks include files that stand beside them by their bare names.
        let directory = deck.parent().context("a deck has a directory")?;
        command
            .current_dir(directory)
            .env("OMP_NUM_THREADS", "1")
            .args(["-nocite", "-log", "none", "-in"])
            .arg(&deck)
            .args(["-var", "plugin"])
            .arg(&self.plugin);
        for (name, value) in variables {
            command.args(["-var", name, value]);
        }
        let mut progress = Progress::start(format!("Running {name}"));
        let log = self.data.join(format!("{name}.log"));
        let result = run_logged(&mut command, &log, |line| {
            if let Some(step) = thermo_step(line) {
                progress.update(None, &format!("step {step}"));
            }
        });
        match &result {
            Ok(()) => progress.finish(),
            Err(_) => progress.clear(),
        }
        result.with_context(|| format!("LAMMPS stopped in {}", deck.display()))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.data.join(name)
    }

    /// The columns of a file that a deck wrote: rows of numbers under lines that are not.
    pub fn columns<const N: usize>(&self, name: &str) -> Result<Vec<[f64; N]>> {
        let path = self.path(name);
        let text = fs::read_to_string(&path)
            .with_context(|| format!("the deck left no {}", path.display()))?;
        let rows = rows(&text);
        anyhow::ensure!(
            !rows.is_empty(),
            "no rows of {N} numbers in {}",
            path.display()
        );
        Ok(rows)
    }
}

fn rows<const N: usize>(text: &str) -> Vec<[f64; N]> {
    text.lines()
        .filter_map(|line| {
            let values: Option<Vec<f64>> = line
                .split_whitespace()
                .map(|word| word.parse().ok())
                .collect();
            <[f64; N]>::try_from(values?).ok()
        })
        .collect()
}

/// The step number that opens a line of thermodynamic output.
fn thermo_step(line: &str) -> Option<u64> {
    let mut words = line.split_whitespace();
    let step = words.next()?.parse().ok()?;
    words.next()?.parse::<f64>().ok()?;
    Some(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_the_lines_of_as_many_numbers() {
        let text = "# a b\n1 2\nstep 3\n4 5 6\n7e-1 -8\n";
        assert_eq!(rows::<2>(text), [[1.0, 2.0], [0.7, -8.0]]);
    }

    #[test]
    fn thermo_lines_open_with_the_step() {
        assert_eq!(thermo_step("     13000   9.5e+11  0"), Some(13000));
        assert_eq!(thermo_step("300 atoms"), None);
        assert_eq!(thermo_step("Step Temp"), None);
    }
}
