// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do the decks of examples/lammps with walls do what they say, in a short form?

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use crate::harness::{execute, fresh_directory, last_lines, parse_frames, Engine, State};

/// Runs a deck of examples/lammps with these variables; its output and the directory in which it ran.
fn run_deck(
    engine: &Engine,
    deck: &str,
    variables: &[(&str, &str)],
    ranks: usize,
) -> (String, PathBuf) {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/lammps");
    let mut text = format!(
        "variable plugin index {}\nvariable stl index {}\n",
        engine.plugin.display(),
        examples
            .join(if deck == "lifters.lmp" {
                "lifters.stl"
            } else {
                "paddle.stl"
            })
            .display()
    );
    for (name, value) in variables {
        text += &format!("variable {name} index {value}\n");
    }
    text += &std::fs::read_to_string(examples.join(deck)).unwrap();
    let directory = fresh_directory(deck);
    let (success, output) = execute(engine, &directory, &text, ranks);
    assert!(success, "{}", last_lines(&output));
    (output, directory)
}

/// Rows of thermo output of a deck of examples/lammps with these variables.
fn rows(
    engine: &Engine,
    deck: &str,
    variables: &[(&str, &str)],
    ranks: usize,
) -> Vec<HashMap<String, f64>> {
    let (output, _) = run_deck(engine, deck, variables, ranks);
    crate::engines::frames::thermo_rows(&output)
}

#[test]
fn both_versions_the_drum_drives_its_load_and_energies_add_up() {
    let engine = Engine::from_environment();
    let rows = rows(&engine, "drum.lmp", &[("steps", "7000")], 2);
    let last = rows.last().unwrap();
    let balance = last["c_energy[11]"] / last["v_dissipated"];
    println!(
        "work {:.3e} J, torque {:.3e} N m, mean y {:.3e} m, balance {balance:+.1e} of what is dissipated",
        last["c_energy[8]"], last["v_torque"], last["c_aside"]
    );
    assert!(last["c_energy[8]"] > 5e-5 && last["c_aside"] > 2e-3);
    assert!(balance.abs() < 1e-3);
}

/// The lifters carry grains up that a smooth drum lets slide, and the contacts of each grain are those of `compute pair`.
#[test]
fn both_versions_lifters_carry_grains_up() {
    let engine = Engine::from_environment();
    let rows = rows(&engine, "lifters.lmp", &[("steps", "14000")], 2);
    let last = rows.last().unwrap();
    println!(
        "work {:.3e} J, highest {:.4} m, {:.2} contacts a grain, balance {:+.1e} of what is dissipated",
        last["c_energy[8]"],
        last["c_highest"],
        last["c_touched"],
        last["c_energy[11]"] / last["v_dissipated"]
    );
    let lowest = rows
        .iter()
        .map(|row| row["c_highest"])
        .fold(f64::INFINITY, f64::min);
    // By then the drum has turned by 64 degrees.
    assert!(lowest < -0.01 && last["c_highest"] > lowest + 0.014);
    assert!(last["c_energy[8]"] > 3e-4);
    assert!(last["c_touched"] > 2.0 && last["c_touched"] < 4.0);
    assert!(last["c_energy[11]"].abs() < 1e-3 * last["v_dissipated"]);
}

#[test]
fn both_versions_the_hopper_empties_when_its_gate_slides_aside() {
    let engine = Engine::from_environment();
    let variables = [("fill", "6000"), ("flow", "6000")];
    let rows = rows(&engine, "hopper.lmp", &variables, 2);
    let above: Vec<f64> = rows.iter().map(|r| r["c_above"]).collect();
    println!("above the outlet: {above:?}");
    let (first, last) = (&rows[0], rows.last().unwrap());
    for row in &rows {
        if row["Step"] <= 6000.0 {
            assert_eq!(row["c_above"], first["Atoms"], "grains pass the gate");
            // half of the first step of its motion
            assert!(row["f_gate[21]"] < 1e-5);
        }
        assert_eq!(row["Atoms"], first["Atoms"], "grains are lost");
    }
    assert!((last["f_gate[21]"] - 0.024).abs() < 1e-5);
    assert!(last["c_above"] < above[0] - 10.0, "nothing flows");
    println!(
        "work of the gate {:.2e} J, balance {:+.1e} of what is dissipated",
        last["c_energy[8]"],
        last["c_energy[11]"] / last["v_dissipated"]
    );
    assert!(last["c_energy[8]"] > 1e-5);
    assert!(last["c_energy[11]"].abs() < 1e-3 * last["v_dissipated"]);
}

/// With `fix balance` four ranks have as many grains each, and what happens is the same.
#[test]
fn both_versions_a_balanced_hopper_is_the_same() {
    let engine = Engine::from_environment();
    let run = |balance: &str, ranks: usize| {
        let variables = [("fill", "3500"), ("flow", "0"), ("balance", balance)];
        let (output, _) = run_deck(&engine, "hopper.lmp", &variables, ranks);
        // ave, max, min
        let shares = output
            .lines()
            .find_map(|line| line.strip_prefix("Nlocal:"))
            .expect("a run");
        let numbers: Vec<f64> = shares
            .split_whitespace()
            .filter_map(|word| word.parse().ok())
            .collect();
        let row = crate::engines::frames::thermo_rows(&output).pop().unwrap();
        (numbers[1] / numbers[0], row)
    };
    let (_, alone) = run("no", 1);
    let (unbalanced, _) = run("no", 4);
    let (balanced, shared) = run("yes", 4);
    println!("imbalance {unbalanced:.2} without, {balanced:.2} with");
    // Grains fall between two shares: at rest it is 4 and 1.
    assert!(unbalanced > 2.0 && balanced < 1.5);
    for name in ["c_energy[1]", "v_dissipated", "f_cone[16]"] {
        let off = (shared[name] / alone[name] - 1.0).abs();
        // What is printed has eight digits.
        assert!(alone[name] != 0.0 && off < 1e-7, "{name}: off by {off}");
    }
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
    println!(
        "brought {:.2e} J, balance {:+.1e} of what is dissipated",
        last["c_energy[10]"],
        last["c_energy[11]"] / last["v_dissipated"]
    );
    assert!(last["c_energy[10]"] > last["v_dissipated"]);
    assert!(last["c_energy[11]"].abs() < 1e-3 * last["v_dissipated"]);
}

/// In each period the floor throws the bed up, and what the floor gives is dissipated.
#[test]
fn both_versions_a_vibrated_bed_is_thrown_up() {
    let engine = Engine::from_environment();
    let variables = [("settle", "5000"), ("shake", "5000")];
    let rows = rows(&engine, "vibrated_bed.lmp", &variables, 1);
    let settled = rows.iter().position(|r| r["Step"] == 5000.0).unwrap();
    let shaken = &rows[settled + 1..];
    let last = shaken.last().unwrap();
    let used = last["c_energy[6]"] + last["c_energy[7]"];
    let loads: Vec<f64> = shaken.iter().map(|r| r["v_load"]).collect();
    println!(
        "load on the floor {loads:.2?}, work {:.2e} J, left over {:.1e} of {used:.2e} J dissipated",
        last["c_energy[8]"],
        last["c_energy[11]"] / used
    );
    assert!((rows[settled]["v_load"] - 1.0).abs() < 0.5);
    assert!(loads.contains(&0.0), "the bed stays on the floor");
    assert!(loads.iter().any(|load| *load > 2.0), "no impact");
    assert!(last["c_energy[8]"] > 2.0 * last["v_motion"]);
    assert!(last["c_energy[11]"].abs() < 1e-3 * used);
}

/// Lists by type miss no contact: positions, forces and torques are those of plain lists, after a while too.
#[test]
fn both_versions_lists_by_type_of_a_mixture_miss_nothing() {
    let engine = Engine::from_environment();
    let frame = |lists: &str, ranks: usize| {
        let variables = [("lists", lists), ("steps", "3000")];
        let (output, directory) = run_deck(&engine, "size_mixture.lmp", &variables, ranks);
        let rows = crate::engines::frames::thermo_rows(&output);
        let text = std::fs::read_to_string(directory.join("size_mixture.dump")).unwrap();
        let frame = parse_frames(&text).pop().expect("no frame");
        (rows.last().unwrap().clone(), frame)
    };
    let (row, multi) = frame("multi", 2);
    let (_, bin) = frame("bin", 1);
    assert!(row["v_touching"] > 10.0 && row["c_energy[11]"].abs() < 1e-3 * row["v_motion"]);
    assert_eq!(multi.states.len(), bin.states.len());
    let mut worst = 0.0f64;
    for of in [
        |s: &State| s.position,
        |s: &State| s.force,
        |s: &State| s.torque,
    ] {
        let largest = bin
            .states
            .iter()
            .flat_map(of)
            .fold(0.0, |m: f64, x| m.max(x.abs()));
        assert!(largest > 0.0);
        for (a, b) in multi.states.iter().zip(&bin.states) {
            for k in 0..3 {
                worst = worst.max((of(a)[k] - of(b)[k]).abs() / largest);
            }
        }
    }
    println!("{} touching, apart by {worst:.1e}", row["v_touching"]);
    assert!(worst < 1e-9);
}

#[test]
fn both_versions_a_paddle_mixes() {
    let engine = Engine::from_environment();
    let variables = [("settle", "5000"), ("turn", "4000")];
    let rows = rows(&engine, "mixer.lmp", &variables, 1);
    let (first, last) = (&rows[0], rows.last().unwrap());
    println!(
        "after {:.0} degrees: {:.2e} J of work, centres of the types apart by {:.4} m of {:.4} m, left over {:.1e} of {:.2e} J dissipated",
        last["v_angle"],
        last["c_energy[8]"],
        last["v_apart"],
        first["v_apart"],
        last["c_energy[11]"] / last["v_used"],
        last["v_used"]
    );
    assert!((last["v_angle"] - 57.6).abs() < 1e-6);
    assert!(last["c_energy[8]"] > 0.2 * last["v_used"]);
    assert!(last["v_apart"] < 0.95 * first["v_apart"]);
    assert!(last["c_energy[11]"].abs() < 2e-3 * last["v_used"]);
}

type Variables = &'static [(&'static str, &'static str)];
type Printed = (&'static str, Variables, usize, f64);

/// Decks of the page with the variables of a short form, ranks, and how near their rows are. Atom-style `random` depends on the ranks.
const PRINTED: [Printed; 10] = [
    ("drum.lmp", &[("steps", "4000")], 2, 0.01),
    ("lifters.lmp", &[("steps", "4000")], 2, 0.01),
    ("hopper.lmp", &[("fill", "4000"), ("flow", "0")], 2, 0.01),
    ("heap.lmp", &[("pour", "5000"), ("rest", "0")], 2, 0.01),
    ("triaxial.lmp", &[("shear", "3000")], 2, 0.05),
    (
        "vibrated_bed.lmp",
        &[("settle", "4000"), ("shake", "0")],
        2,
        0.01,
    ),
    ("mixer.lmp", &[("settle", "4000"), ("turn", "0")], 2, 0.01),
    ("size_mixture.lmp", &[("steps", "4000")], 2, 0.01),
    ("settling.lmp", &[("steps", "4000")], 1, 0.01),
    ("collision.lmp", &[], 2, 0.01),
];

/// The rows that the page prints, on two ranks where they were printed on one.
#[test]
fn the_rows_of_the_page_are_printed() {
    let engine = Engine::from_environment();
    let page = crate::engines::printed::page("examples/lammps/README.md");
    let mut others = Vec::new();
    for (deck, variables, ranks, tolerance) in PRINTED {
        let (_, section) = page
            .split_once(&format!("\n### {deck}\n"))
            .unwrap_or_else(|| panic!("the page has no section of {deck}"));
        let section = section.split("\n##").next().unwrap();
        let printed = crate::engines::printed::blocks(section, "text");
        assert!(!printed.is_empty(), "{deck}");
        let found = rows(&engine, deck, variables, ranks);
        for block in printed {
            let mut lines = block.lines();
            // Thermo's own columns have other names in its header.
            let names: Vec<String> = lines
                .next()
                .unwrap()
                .split_whitespace()
                .map(|name| match name {
                    "step" => "Step".into(),
                    "atoms" => "Atoms".into(),
                    "ke" => "KinEng".into(),
                    "pe" => "PotEng".into(),
                    other => other.to_string(),
                })
                .collect();
            let said: Vec<Vec<f64>> = lines
                .map(|line| {
                    line.split_whitespace()
                        .map(|x| x.parse().unwrap())
                        .collect()
                })
                .collect();
            assert!(!said.is_empty(), "{deck}");
            let mut worst = (0.0f64, "");
            for row in &said {
                let of_step = found
                    .iter()
                    .find(|r| r["Step"] == row[0] && names.iter().all(|name| r.contains_key(name)))
                    .unwrap_or_else(|| panic!("{deck} prints no row {} of {names:?}", row[0]));
                for (k, name) in names.iter().enumerate() {
                    let largest = said.iter().map(|r| r[k].abs()).fold(0.0, f64::max);
                    let off =
                        (of_step[name] - row[k]).abs() / if largest > 0.0 { largest } else { 1.0 };
                    if off > worst.0 {
                        worst = (off, name);
                    }
                }
            }
            println!(
                "{deck}: {} rows, off by {:.1e} in {}",
                said.len(),
                worst.0,
                worst.1
            );
            if worst.0 >= tolerance {
                others.push(format!("{deck}: off by {:.1e} in {}", worst.0, worst.1));
            }
        }
    }
    assert!(others.is_empty(), "{}", others.join("\n"));
}
