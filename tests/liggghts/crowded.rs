// SPDX-License-Identifier: MIT OR Apache-2.0
//! What happens to a grain under which one wall has very many corners?

use std::fmt::Write as _;
use std::fs;

use crate::harness::{fresh_directory, run_in, Deck, Engine, Grain, Outcome, Scene, ELASTIC};

const TIPS: usize = 12;
const SPACING: f64 = 4e-3;

/// A row of spikes along x, too far apart to be one surface; the k-th is lower by that many micrometres.
fn spikes(count: usize) -> String {
    let mut text = String::from("solid spikes\n");
    for k in 0..count {
        let tip = [
            SPACING * (k as f64 - 0.5 * (TIPS - 1) as f64),
            0.0,
            -1e-6 * k as f64,
        ];
        let foot: Vec<[f64; 3]> = (0..3)
            .map(|m| {
                let angle = std::f64::consts::TAU * m as f64 / 3.0;
                [
                    tip[0] + 1e-3 * angle.cos(),
                    1e-3 * angle.sin(),
                    tip[2] - 5e-3,
                ]
            })
            .collect();
        for m in 0..3 {
            text.push_str(" facet normal 0 0 1\n  outer loop\n");
            for [x, y, z] in [foot[m], foot[(m + 1) % 3], tip] {
                writeln!(text, "   vertex {x:e} {y:e} {z:e}").unwrap();
            }
            text.push_str("  endloop\n endfacet\n");
        }
    }
    text + "endsolid spikes\n"
}

/// A long grain, nearly straight along x, on the spikes.
fn lying(count: usize, ranks: usize) -> Outcome {
    let engine = Engine::from_environment();
    let directory = fresh_directory(&format!("{count}_{ranks}"));
    fs::write(directory.join("spikes.stl"), spikes(count)).unwrap();
    let grain = |y: f64| Grain {
        density: 2500.0,
        ..Grain::new([0.5, 2e-3, 2e-3], [0.0, y, 2e-3 - 1e-4])
    };
    // the second is far from the spikes, on another rank if there are two
    let scene = Scene {
        low: [-1.0, -1.0, -0.1],
        high: [1.0, 1.0, 0.1],
        ..Scene::open(1.0, vec![grain(0.0), grain(0.5)])
    };
    let deck = Deck {
        model: "nfd surface ellipsoid".into(),
        before: vec!["fix spikes all mesh/surface file spikes.stl type 1 curvature 1e-5".into()],
        walls: vec!["mesh n_meshes 1 meshes spikes".into()],
        time_step: 1e-8,
        steps: 20,
        ..Deck::new(ELASTIC, 0.5)
    };
    run_in(&engine, &directory, &scene, &deck, ranks)
}

/// Spikes under one patch of contact share it, however many they are: they push as one surface does, and the run goes on.
#[test]
fn any_number_of_spikes_push_as_one_surface() {
    let pushed = |count: usize, ranks: usize| {
        let outcome = lying(count, ranks);
        assert!(!outcome.output.contains("deepest"), "{count} spikes");
        outcome.first().states[0].force[2]
    };
    let (one, eight, nine) = (pushed(1, 1), pushed(8, 1), pushed(9, 1));
    let all = [1, 2].map(|ranks| pushed(TIPS, ranks));
    println!("1 spike pushes with {one:e}, 8 with {eight:e}, 9 with {nine:e}, {TIPS} with {all:?}");
    assert!(eight > 0.0 && eight < one * 1.1);
    for force in [nine, all[0], all[1]] {
        assert!((force - eight).abs() < 0.1 * eight);
    }
}
