// SPDX-License-Identifier: MIT OR Apache-2.0
//! One run of a deck, whichever the engine, and the columns of numbers that it leaves.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};

use crate::process::run_logged;
use crate::progress::Progress;

/// Runs `engine -in deck -var name value ...` in the deck's own directory, since decks include files that stand
/// beside them by their bare names. `name` is shown, and is the log's.
pub fn run(
    engine: &mut Command,
    deck: &Path,
    name: &str,
    data: &Path,
    variables: &[(&str, &str)],
) -> Result<()> {
    let directory = deck.parent().context("a deck has a directory")?;
    // One rank and one thread: ranks wait for each other by spinning, which stands still on a busy machine.
    engine
        .current_dir(directory)
        .env("OMP_NUM_THREADS", "1")
        .args(["-log", "none", "-in"])
        .arg(deck);
    for (name, value) in variables {
        engine.args(["-var", name, value]);
    }
    let mut progress = Progress::start(format!("Running {name}"));
    let result = run_logged(engine, &data.join(format!("{name}.log")), |line| {
        if let Some(step) = thermo_step(line) {
            progress.update(None, &format!("step {step}"));
        }
    });
    match &result {
        Ok(()) => progress.finish(),
        Err(_) => progress.clear(),
    }
    result.with_context(|| format!("the engine stopped in {}", deck.display()))
}

/// The columns of a file that a deck wrote: rows of numbers under lines that are not.
pub fn columns<const N: usize>(path: &Path) -> Result<Vec<[f64; N]>> {
    let text =
        fs::read_to_string(path).with_context(|| format!("the deck left no {}", path.display()))?;
    let rows = rows(&text);
    anyhow::ensure!(
        !rows.is_empty(),
        "no rows of {N} numbers in {}",
        path.display()
    );
    Ok(rows)
}

pub fn text(path: &Path) -> Result<&str> {
    path.to_str()
        .with_context(|| format!("{} is not UTF-8", path.display()))
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
