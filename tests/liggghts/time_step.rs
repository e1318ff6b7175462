// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does `fix check/timestep/ellipsoid` say what `compute timestep/ellipsoid` of the LAMMPS plugin says, and what does it do with a step that
//! is too long?

use std::fs;

use crate::engines::pressed::{pressed, CELL};
use crate::harness::{attempt, attempt_in, fresh_directory, run, Deck, Engine, Material, Scene};
use crate::lammps;

const VISCOUS: Material = [1e6, 0.3, 20.0, 20.0];
const SIDE: usize = 3;

fn planes() -> Vec<String> {
    let edge = SIDE as f64 * CELL;
    ["x", "y", "z"]
        .iter()
        .flat_map(|axis| [0.0, edge].map(|at| format!("primitive type 1 {axis}plane {at}")))
        .collect()
}

fn checked(words: &str) -> Deck {
    Deck {
        walls: planes(),
        fixes: vec![format!("fix step all check/timestep/ellipsoid {words}")],
        thermo: "step f_step[1] f_step[2] f_step[3] f_step[4] f_step[5]".into(),
        time_step: 1e-9,
        steps: 1,
        ..Deck::new(VISCOUS, 0.5)
    }
}

fn scene() -> Scene {
    pressed(SIDE, 0.05)
}

fn values(row: &std::collections::HashMap<String, f64>, name: &str) -> [f64; 5] {
    std::array::from_fn(|k| row[&format!("{name}[{}]", k + 1)])
}

/// Two triangles at z = 0 that reach beyond the grains and not beyond the box.
fn floor() -> String {
    let (low, high) = (-0.9 * CELL, (SIDE as f64 + 0.9) * CELL);
    let corners = [[low, low], [high, low], [high, high], [low, high]];
    let mut text = String::from("solid sheet\n");
    for triangle in [[0, 1, 2], [0, 2, 3]] {
        text += "facet normal 0 0 1\nouter loop\n";
        for [x, y] in triangle.map(|k| corners[k]) {
            text += &format!("vertex {x:e} {y:e} 0\n");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid sheet\n"
}

#[test]
fn the_same_as_in_lammps_on_planes_and_on_meshes_on_any_ranks() {
    let engine = Engine::from_environment();
    let other = lammps::Engine::from_environment();
    let [e, nu, eta1, eta2] = VISCOUS;
    let law = format!("nfd {e} {nu} {eta1} {eta2} tangential tfd 0.5");
    let edge = SIDE as f64 * CELL;
    let mut fixes = vec!["compute step all timestep/ellipsoid energy_error 1e-2".to_string()];
    for axis in ["x", "y", "z"] {
        fixes.push(format!(
            "fix {axis}walls all wall/gran/ellipsoid {law} {axis}plane 0 {edge}"
        ));
    }
    let in_lammps = lammps::run(
        &other,
        "step_beside",
        &scene(),
        &lammps::Deck {
            time_step: 1e-9,
            steps: 1,
            thermo_every: 1,
            thermo_columns: "step c_step[*]".into(),
            skin: 2e-3,
            newton: false,
            fixes,
            ..lammps::Deck::new(&law)
        },
        1,
    );
    let expected = values(in_lammps.thermo().last().unwrap(), "c_step");
    println!("LAMMPS {expected:?}");
    assert!(expected.iter().all(|v| *v > 0.0 && v.is_finite()));

    let same = |name: &str, found: [f64; 5]| {
        println!("{name} {found:?}");
        for (k, (a, b)) in found.iter().zip(&expected).enumerate() {
            assert!(
                (a / b - 1.0).abs() < 1e-6,
                "{name}, value {}: {a} {b}",
                k + 1
            );
        }
    };
    for ranks in [1, 4] {
        let name = format!("step_planes_{ranks}");
        let outcome = run(
            &engine,
            &name,
            &scene(),
            &checked("1 1.0 energy_error 1e-2"),
            ranks,
        );
        same(&name, values(outcome.thermo().last().unwrap(), "step"));
    }

    // the floor of triangles in place of the lower plane along z
    let directory = fresh_directory("step_mesh");
    fs::write(directory.join("sheet.stl"), floor()).unwrap();
    let mut deck = checked("1 1.0 energy_error 1e-2");
    deck.before = vec!["fix sheet all mesh/surface file sheet.stl type 1".into()];
    deck.walls[4] = "mesh n_meshes 1 meshes sheet".into();
    let outcome = attempt_in(&engine, &directory, &scene(), &deck, 1).succeeded();
    same(
        "step_mesh",
        values(outcome.thermo().last().unwrap(), "step"),
    );
}

#[test]
fn a_longer_step_is_warned_of_once_or_refused() {
    let engine = Engine::from_environment();
    const TEXT: &str = "the largest with which the contacts that exist now are stable";
    let first = run(&engine, "step_ask", &scene(), &checked("1 1.0"), 1);
    assert!(!first.output.contains(TEXT));
    let step = values(first.thermo().last().unwrap(), "step")[0];
    let with = |name: &str, words: &str, factor: f64| {
        let deck = Deck {
            time_step: factor * step,
            steps: 3,
            ..checked(words)
        };
        attempt(&engine, name, &pressed(SIDE, 0.0), &deck, 2)
    };
    let warned = with("step_long", "1 1.0", 1.2);
    assert!(warned.success);
    assert_eq!(warned.output.matches(TEXT).count(), 1, "{}", warned.output);
    let silent = with("step_silent", "1 1.0 warn no", 1.2);
    assert!(silent.success && !silent.output.contains(TEXT));
    let short = with("step_fraction", "1 0.5 error yes", 0.6);
    assert!(
        !short.success
            && short.output.contains(TEXT)
            && short.output.contains("check/timestep/ellipsoid")
    );
    assert!(with("step_within", "1 0.5 error yes", 0.4).success);
}
