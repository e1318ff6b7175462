// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does the deck of the README run as it is printed, and show what the text around it says?

use std::fs;

use crate::harness::{execute, fresh_directory, last_lines, Engine};
use crate::readme_deck;

/// The rows of numbers of LAMMPS' thermo output, under the first line that opens with `Step`.
fn thermo_rows(output: &str) -> Vec<Vec<f64>> {
    output
        .lines()
        .skip_while(|line| !line.trim_start().starts_with("Step"))
        .skip(1)
        .map_while(|line| {
            line.split_whitespace()
                .map(|word| word.parse().ok())
                .collect()
        })
        .collect()
}

#[test]
fn both_versions_the_deck_of_the_readme() {
    let engine = Engine::from_environment();
    // The command line of the README gives the plugin; a line before the first does the same here.
    let deck = format!(
        "variable plugin index {}\n{}",
        engine.plugin.display(),
        readme_deck::deck()
    );
    let directory = fresh_directory("readme");
    let (success, output) = execute(&engine, &directory, &deck, 1);
    assert!(success, "{}", last_lines(&output));
    let warnings: Vec<&str> = output.lines().filter(|l| l.contains("WARNING")).collect();
    assert!(warnings.is_empty(), "{warnings:?}");

    // step, energies of translation and rotation, potential energy, dissipated energy, their sum, contacts
    let rows = thermo_rows(&output);
    let (first, last) = (&rows[0], rows.last().unwrap());
    assert_eq!((rows.len(), first.len(), last[0]), (11, 7, 20_000.0));
    assert_eq!(first[6], 0.0, "no grain touches at first");
    assert!(last[6] > 500.0 && last[6] < 700.0, "{} contacts", last[6]);
    let fall = first[3] - last[3];
    let drift = (last[5] - first[5]).abs() / last[4];
    println!(
        "contacts {}, energy in motion over that of the fall {:e}, drift of the sum over the dissipated energy {drift:e}",
        last[6],
        (last[1] + last[2]) / fall
    );
    assert!(last[1] + last[2] < 1e-6 * fall, "the grains are at rest");
    assert!(drift < 1e-3, "the sum stays: {drift:e}");
    let frames = fs::read_to_string(directory.join("grains.dump")).expect("a dump");
    assert_eq!(frames.matches("ITEM: TIMESTEP").count(), 11);
}
