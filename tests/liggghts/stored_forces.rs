// SPDX-License-Identifier: MIT OR Apache-2.0
//! Are the forces that a wall stores contact by contact those of the same sphere in LIGGGHTS' own words, and does the motion not
//! know of them?

use std::fs;

use crate::harness::{fresh_directory, run_in, Deck, Engine, Grain, Outcome, Scene, ELASTIC};
use crate::mesh_ranks::{on_a_sheet, sheet_deck};
use crate::meshes::sheet;

fn on_a_mesh(name: &str, scene: &Scene, deck: &Deck, ranks: usize) -> Outcome {
    let engine = Engine::from_environment();
    let directory = fresh_directory(name);
    fs::write(directory.join("sheet.stl"), sheet(8)).unwrap();
    run_in(&engine, &directory, scene, deck, ranks)
}

#[test]
fn storing_does_not_change_the_motion() {
    for ranks in [1, 4] {
        let run = |words: &str| {
            let mut deck = sheet_deck();
            deck.steps = 60;
            deck.walls[0] += words;
            let name = format!("{ranks}{}", words.replace(' ', "_"));
            on_a_mesh(&name, &on_a_sheet(), &deck, ranks)
        };
        let plain = run("");
        for words in [
            " store_force_contact yes",
            " store_force_contact_every 3",
            " store_force_contact_stress yes",
            " store_force yes store_force_contact yes store_force_contact_stress yes",
        ] {
            let stored = run(words);
            for (a, b) in stored.frames.iter().zip(&plain.frames) {
                assert_eq!(a.states, b.states, "{ranks} ranks:{words}");
            }
            assert_eq!(stored.frames.len(), plain.frames.len());
        }
    }
}

/// The columns of the last table of a dump.
fn table(outcome: &Outcome, file: &str) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(outcome.directory.join(file)).unwrap();
    let last = text.rsplit("ITEM: ATOMS").next().unwrap();
    last.lines()
        .skip(1)
        .map(|line| {
            line.split_whitespace()
                .map(|w| w.parse().unwrap())
                .collect()
        })
        .collect()
}

/// fix continuum/weighted reads what the pairs and the walls store.
#[test]
fn stresses_of_spheres_as_in_the_engines_own_words() {
    let sphere = |x: f64, z: f64| Grain {
        density: 2500.0,
        ..Grain::sphere(5e-3, [x, 0.0113, z])
    };
    let scene = Scene {
        low: [-0.07, -0.07, -0.02],
        high: [0.07, 0.07, 0.03],
        ..Scene::open(
            1.0,
            vec![
                sphere(0.0, 4.98e-3),
                sphere(0.006, 0.0128),
                sphere(0.03, 4.99e-3),
            ],
        )
    };
    for wall in [
        "primitive type 1 zplane 0.0",
        "mesh n_meshes 1 meshes sheet",
    ] {
        let stresses = |ours: bool, ranks: usize| {
            let mut deck = Deck {
                model: if ours {
                    "nfd surface ellipsoid"
                } else {
                    "hertz"
                }
                .into(),
                atom_style: if ours { "superquadric" } else { "sphere" }.into(),
                wall_fix: if ours {
                    "wall/gran/ellipsoid"
                } else {
                    "wall/gran"
                }
                .into(),
                // the wall comes after the fix that wants its forces, so it cannot stand among the walls
                ..Deck::new(ELASTIC, 0.5)
            };
            if wall.contains("mesh") {
                deck.before = vec!["fix sheet all mesh/surface file sheet.stl type 1".into()];
            }
            deck.fixes = vec![
                "fix continuum all continuum/weighted kernel_radius 0.012 kernel_type Wendland compute stress".into(),
                format!("fix wall all {} model {} {wall}", deck.wall_fix, deck.model),
                "dump stress all custom 1 stress id f_stressTensor_[1] f_stressTensor_[5] f_stressTensor_[9] f_stressTensor_[3]".into(),
                "dump_modify stress sort id format \"%d %.17g %.17g %.17g %.17g\"".into(),
            ];
            deck.steps = 1;
            deck.time_step = 1e-9;
            let name = format!("{ours} {ranks} {}", &wall[..4]).replace(' ', "_");
            let outcome = on_a_mesh(&name, &scene, &deck, ranks);
            table(&outcome, "stress")
        };
        let theirs = stresses(false, 1);
        let largest = theirs
            .iter()
            .flat_map(|row| row[1..].iter())
            .fold(0.0f64, |m, v| m.max(v.abs()));
        assert!(largest > 1.0);
        for ranks in [1, 2] {
            let ours = stresses(true, ranks);
            assert_eq!(ours.len(), 3);
            let mut worst = 0.0f64;
            for (a, b) in ours.iter().zip(&theirs) {
                for k in 1..5 {
                    worst = worst.max((a[k] - b[k]).abs() / largest);
                }
            }
            println!("{wall}, {ranks} ranks: stresses apart by {worst:.1e} of {largest:.3e}");
            assert!(worst < 1e-6);
        }
    }
}
