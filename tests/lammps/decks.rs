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

/// Servo walls hold a given stress to 1 % through a triaxial test; a dense packing has a peak of its strength and dilates, a loose
/// one contracts first and has none.
#[test]
fn both_versions_triaxial_compression_of_a_dense_and_a_loose_packing() {
    let engine = Engine::from_environment();
    let stress = 2000.0;
    let curve = |packing: &str| {
        let variables = [
            ("packing", packing),
            ("cells", "6"),
            ("compact", "5000"),
            ("shear", "8000"),
        ];
        let rows = rows(&engine, "triaxial.lmp", &variables, 1);
        let rows: Vec<_> = rows
            .into_iter()
            .filter(|r| r.contains_key("v_strain"))
            .collect();
        let off = rows
            .iter()
            .map(|r| (r["v_lateral"] / stress - 1.0).abs())
            .fold(0.0, f64::max);
        let (peak, at) = rows.iter().fold((0.0, 0.0), |best, r| {
            if r["v_ratio"] > best.0 {
                (r["v_ratio"], r["v_strain"])
            } else {
                best
            }
        });
        let last = rows.last().unwrap();
        let least = rows
            .iter()
            .map(|r| r["v_dilation"])
            .fold(f64::INFINITY, f64::min);
        println!(
            "{packing}: solid fraction {:.3}, lateral stress off by {off:.1e}, ratio {peak:.2} at strain {at:.3}, {:.2} at the end; volume \
             {least:+.3} at its least, {:+.3} at the end",
            rows[0]["v_solid"], last["v_ratio"], last["v_dilation"]
        );
        assert!(off < 0.01, "{packing}: the lateral stress is off by {off}");
        (
            rows[0]["v_solid"],
            peak,
            at,
            last["v_ratio"],
            last["v_dilation"],
        )
    };
    let (dense, loose) = (curve("dense"), curve("loose"));
    assert!(dense.0 > loose.0 + 0.05, "the same solid fraction");
    assert!(dense.1 > 1.2 * dense.3 && dense.2 < 0.1, "no peak");
    assert!(dense.4 > 0.05, "no dilation");
    assert!(
        loose.1 < 1.15 * loose.3 && loose.2 > 0.1,
        "a peak of the loose packing"
    );
    assert!(loose.4 < -0.01, "the loose packing does not contract");
    // both come to the same strength
    assert!(dense.1 > 1.3 * loose.1);
    assert!((dense.3 / loose.3 - 1.0).abs() < 0.25);
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
