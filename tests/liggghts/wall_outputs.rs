// SPDX-License-Identifier: MIT OR Apache-2.0
//! What LIGGGHTS tells of the forces between a mesh and grains: is it what moves the grains, on one rank and on four?

use std::fs;

use crate::harness::{fresh_directory, last_rows, run_in, Deck, Engine, Grain, Scene, ELASTIC};
use crate::mesh_ranks::{on_a_sheet, sheet_deck, WEIGHT};
use crate::meshes::sheet;
use crate::shapes::{add, cross, length, sub, Vector};

const STEPS: u64 = 120;

fn deck() -> Deck {
    Deck {
        steps: STEPS,
        dump_every: STEPS,
        ..sheet_deck()
    }
}

fn vector(numbers: &[f64]) -> Vector {
    std::array::from_fn(|k| numbers[k])
}

#[test]
fn the_force_on_a_mesh_and_the_stored_forces() {
    let engine = Engine::from_environment();
    let scene = on_a_sheet();
    for ranks in [1, 4] {
        let directory = fresh_directory(&format!("{ranks}"));
        fs::write(directory.join("sheet.stl"), sheet(8)).unwrap();
        let mut deck = Deck {
            before: vec![
                "fix sheet all mesh/surface/stress file sheet.stl type 1 reference_point 0. 0. 0."
                    .into(),
            ],
            thermo: "step f_sheet[1] f_sheet[2] f_sheet[3] f_sheet[4] f_sheet[5] f_sheet[6]".into(),
            ..deck()
        };
        deck.walls[0] += " store_force yes";
        deck.fixes.extend([
            format!("dump stored all custom {STEPS} stored id f_force_wall0[1] f_force_wall0[2] f_force_wall0[3]"),
            "dump_modify stored sort id format \"%d %.17g %.17g %.17g\"".into(),
        ]);
        let outcome = run_in(&engine, &directory, &scene, &deck, ranks);
        let stored = last_rows(&directory.join("stored"));
        let (mut force, mut torque) = ([0.0; 3], [0.0; 3]);
        let mut worst = 0.0f64;
        for ((grain, state), row) in scene.grains.iter().zip(&outcome.last().states).zip(&stored) {
            let wall = sub(state.force, [0.0, 0.0, -WEIGHT * grain.mass()]);
            worst = worst.max(length(sub(vector(&row[1..]), wall)) / length(wall));
            force = add(force, wall);
            torque = add(torque, add(cross(state.position, wall), state.torque));
        }
        let rows = outcome.thermo();
        let told = |from: usize| -> Vector {
            std::array::from_fn(|k| rows[rows.len() - 1][&format!("sheet[{}]", from + k)])
        };
        let (f, t) = (
            length(add(told(1), force)) / length(force),
            length(add(told(4), torque)) / length(torque),
        );
        println!("{ranks} ranks: stored forces off by {worst:.1e}, force on the mesh by {f:.1e}, its torque by {t:.1e}");
        assert_eq!(stored.len(), 4);
        assert!(worst < 1e-12 && f < 1e-12);
        // LIGGGHTS takes a force at a point, which has no torque along the force
        assert!(t < 1e-5);
    }
}

#[test]
fn contacts_with_a_mesh_one_by_one() {
    let engine = Engine::from_environment();
    let scene = on_a_sheet();
    for ranks in [1, 4] {
        let directory = fresh_directory(&format!("{ranks}"));
        fs::write(directory.join("sheet.stl"), sheet(8)).unwrap();
        let mut deck = deck();
        let columns: String = (1..=12).map(|k| format!(" c_contacts[{k}]")).collect();
        deck.fixes.extend([
            "compute contacts all wall/gran/local pos id force".into(),
            format!("dump contacts all local {STEPS} contacts{columns}"),
        ]);
        let outcome = run_in(&engine, &directory, &scene, &deck, ranks);
        let contacts = last_rows(&directory.join("contacts"));
        assert_eq!(contacts.len(), 4);
        for contact in contacts {
            let k = contact[8] as usize - 1;
            let state = &outcome.last().states[k];
            let wall = sub(state.force, [0.0, 0.0, -WEIGHT * scene.grains[k].mass()]);
            // the compute takes the velocities of the end of the step, the step those of its middle
            let force = length(sub(vector(&contact[9..]), wall)) / length(wall);
            println!("{ranks} ranks, grain {}: force off by {force:.1e}", k + 1);
            assert!(force < 1e-2 && contact[2].abs() < 1e-9);
            assert!(length(sub(vector(&contact[3..]), state.position)) < 1e-6);
        }
    }
}

/// LIGGGHTS had walls warm spheres within a hundredth of their radius, which models that look at contacts before they begin ask it to look at, and by
/// the root of an area below zero.
#[test]
fn a_wall_warms_what_it_touches_alone() {
    let engine = Engine::from_environment();
    let warmed = |wall: &str, area: &str, height: f64| {
        let ball = Grain {
            density: 2500.0,
            ..Grain::sphere(5e-3, [1e-3, 2e-3, height])
        };
        let deck = Deck {
            model: "nfd tangential tfd surface default".into(),
            atom_style: "sphere".into(),
            wall_fix: "wall/gran".into(),
            walls: vec![format!("{wall} {area}")],
            before: [
                "fix k all property/global thermalConductivity peratomtype 50.",
                "fix c all property/global thermalCapacity peratomtype 0.01",
                "fix sheet all mesh/surface file sheet.stl type 1 temperature 500.",
            ]
            .map(String::from)
            .to_vec(),
            fixes: [
                "fix heat all heat/gran/conduction initial_temperature 300.",
                "compute warmest all reduce max f_Temp",
            ]
            .map(String::from)
            .to_vec(),
            time_step: 1e-7,
            steps: 20,
            thermo: "step c_warmest".into(),
            ..Deck::new(ELASTIC, 0.5)
        };
        let directory = fresh_directory("warm");
        fs::write(directory.join("sheet.stl"), sheet(8)).unwrap();
        let outcome = run_in(&engine, &directory, &Scene::open(0.2, vec![ball]), &deck, 1);
        outcome.thermo().last().unwrap()["warmest"] - 300.0
    };
    for wall in [
        "primitive type 1 zplane 0.0 temperature 500.",
        "mesh n_meshes 1 meshes sheet",
    ] {
        for area in ["", "contact_area constant 1e-6"] {
            let apart = warmed(wall, area, 5.02e-3);
            let touching = warmed(wall, area, 4.99e-3);
            println!("{wall} {area}: warmer by {apart:.3}, touching by {touching:.3}");
            assert_eq!(apart, 0.0, "{wall} {area}");
            assert!(touching > 0.1, "{wall} {area}: {touching}");
        }
    }
}
