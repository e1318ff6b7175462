// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does the deck of the README run as it is printed, and show what the text around it says?

use std::fs;

use crate::engines::printed::{blocks, page};
use crate::harness::{execute, fresh_directory, last_lines, parse_frames, thermo_rows, Engine};

#[test]
fn both_versions_the_deck_of_the_readme() {
    let engine = Engine::from_environment();
    // The command line of the README gives the plugin; a line before the first does the same here.
    let deck = format!(
        "variable plugin index {}\n{}",
        engine.plugin.display(),
        blocks(&page("README.md"), "lammps")[0]
    );
    let directory = fresh_directory("readme");
    let (success, output) = execute(&engine, &directory, &deck, 1);
    assert!(success, "{}", last_lines(&output));
    let warnings: Vec<&str> = output.lines().filter(|l| l.contains("WARNING")).collect();
    assert!(warnings.is_empty(), "{warnings:?}");

    let rows = thermo_rows(&output);
    let (first, last) = (&rows[0], rows.last().unwrap());
    assert_eq!((rows.len(), first.len(), last["Step"]), (11, 7, 20_000.0));
    let [contacts, dissipated] = ["c_contacts[4]", "v_dissipated"].map(|name| last[name]);
    assert_eq!(first["c_contacts[4]"], 0.0, "no grain touches at first");
    assert!(contacts > 500.0 && contacts < 700.0, "{contacts} contacts");
    let fall = first["PotEng"] - last["PotEng"];
    let motion = last["KinEng"] + last["c_spin"];
    let drift = (last["v_sum"] - first["v_sum"]).abs() / dissipated;
    println!(
        "contacts {contacts}, energy in motion over that of the fall {:e}, drift of the sum over the dissipated energy {drift:e}",
        motion / fall
    );
    // Where the last grain still rocks differs with the order of rounding: on the instruction sets from 5e-8 to 3.5e-6 of the fall.
    assert!(motion < 1e-5 * fall, "the grains are at rest");
    assert!(drift < 1e-3, "the sum stays: {drift:e}");
    let dump = fs::read_to_string(directory.join("grains.dump")).expect("a dump");
    assert_eq!(parse_frames(&dump).len(), 11);
}
