// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do the decks of examples/lammps with walls do what they say, in a short form?

use std::collections::HashMap;
use std::path::Path;

use crate::harness::{execute, fresh_directory, last_lines, Engine};

/// Rows of thermo output of a deck of examples/lammps with these variables.
fn rows(
    engine: &Engine,
    deck: &str,
    variables: &[(&str, &str)],
    ranks: usize,
) -> Vec<HashMap<String, f64>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("examples/lammps")
        .join(deck);
    let mut text = format!("variable plugin index {}\n", engine.plugin.display());
    for (name, value) in variables {
        text += &format!("variable {name} index {value}\n");
    }
    text += &std::fs::read_to_string(path).unwrap();
    let directory = fresh_directory(deck);
    let (success, output) = execute(engine, &directory, &text, ranks);
    assert!(success, "{}", last_lines(&output));
    crate::engines::frames::thermo_rows(&output)
}

#[test]
fn both_versions_the_drum_drives_its_load_and_energies_add_up() {
    let engine = Engine::from_environment();
    let rows = rows(&engine, "drum.lmp", &[("steps", "7000")], 2);
    let last = rows.last().unwrap();
    let balance = last["v_sum"] / last["v_dissipated"];
    println!(
        "work {:.3e} J, torque {:.3e} N m, mean y {:.3e} m, balance {balance:+.1e} of what is dissipated",
        last["f_drum[13]"], last["v_torque"], last["c_aside"]
    );
    assert!(last["f_drum[13]"] > 5e-5 && last["c_aside"] > 2e-3);
    assert!(balance.abs() < 1e-3);
}

#[test]
fn both_versions_the_hopper_empties_when_its_gate_is_gone() {
    let engine = Engine::from_environment();
    let rows = rows(
        &engine,
        "hopper.lmp",
        &[("fill", "4000"), ("flow", "4000")],
        2,
    );
    let above: Vec<f64> = rows.iter().map(|r| r["c_above"]).collect();
    println!("above the outlet: {above:?}");
    let (first, last) = (above[0], above[above.len() - 1]);
    let filled = rows.iter().filter(|r| r.contains_key("f_gate[16]")).count();
    assert!(
        above[..filled].iter().all(|n| *n == first),
        "grains pass the gate"
    );
    assert!(last < first - 10.0, "nothing flows");
    assert!(rows.iter().all(|r| r["Atoms"] == first), "grains are lost");
}

#[test]
fn both_versions_a_poured_heap_has_an_angle() {
    let engine = Engine::from_environment();
    let rows = rows(
        &engine,
        "heap.lmp",
        &[("pour", "15000"), ("rest", "5000")],
        2,
    );
    let last = rows.last().unwrap();
    let poured = rows
        .iter()
        .filter_map(|row| row.get("f_pour"))
        .fold(0.0f64, |most, n| most.max(*n));
    println!(
        "{poured} grains poured, {} stay, angle {:.1} degrees",
        last["Atoms"], last["v_angle"]
    );
    assert!(poured > 100.0);
    assert!(last["Atoms"] > 50.0 && last["Atoms"] < poured);
    assert!(last["v_angle"] > 5.0 && last["v_angle"] < 45.0);
}
