// SPDX-License-Identifier: MIT OR Apache-2.0
//! What happens to a grain that touches one wall in very many places?

use std::fmt::Write as _;
use std::fs;

use crate::harness::{fresh_directory, run_in, Deck, Engine, Grain, Outcome, Scene, ELASTIC};
use crate::shapes::{add, cross, length, scale, sub, unit, Vector};

const TIPS: usize = 12;
const SPACING: f64 = 4e-3;

/// A tip that points against `outward`, as three triangles.
fn spike(text: &mut String, tip: Vector, outward: Vector, height: f64, width: f64) {
    let across = unit(cross(
        outward,
        if outward[0].abs() < 0.5 {
            [1.0, 0.0, 0.0]
        } else {
            [0.0, 1.0, 0.0]
        },
    ));
    let other = cross(outward, across);
    let foot: Vec<Vector> = (0..3)
        .map(|m| {
            let angle = std::f64::consts::TAU * m as f64 / 3.0;
            let aside = add(
                scale(width * angle.cos(), across),
                scale(width * angle.sin(), other),
            );
            add(tip, add(scale(height, outward), aside))
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

/// A row of spikes along x, too far apart to be one surface; the k-th is lower by that many micrometres.
fn spikes(count: usize) -> String {
    let mut text = String::from("solid spikes\n");
    for k in 0..count {
        let tip = [
            SPACING * (k as f64 - 0.5 * (TIPS - 1) as f64),
            0.0,
            -1e-6 * k as f64,
        ];
        spike(&mut text, tip, [0.0, 0.0, -1.0], 5e-3, 1e-3);
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
        assert!(!outcome.output.contains("more places"), "{count} spikes");
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

const RADIUS: f64 = 1e-2;

/// Where the k-th of many tips touches a sphere about the origin: two rings below its middle.
fn direction(k: usize) -> Vector {
    let (below, turn) = if k < 8 {
        (0.9f64, std::f64::consts::TAU * k as f64 / 8.0)
    } else {
        (0.4, std::f64::consts::TAU * (k as f64 + 0.3) / 4.0)
    };
    [
        below.sin() * turn.cos(),
        below.sin() * turn.sin(),
        -below.cos(),
    ]
}

/// How deep it reaches into the sphere: not in the order of the tips.
fn depth(k: usize) -> f64 {
    1e-6 + 1e-7 * ((5 * k) % TIPS) as f64
}

/// Tips whose patches of contact are apart push each for itself. Eight are remembered, and one warning says of more.
#[test]
fn all_separate_contacts_act() {
    let engine = Engine::from_environment();
    let modulus = ELASTIC[0] / (2.0 * (1.0 - ELASTIC[1] * ELASTIC[1]));
    for (count, ranks) in [(8, 1), (9, 1), (TIPS, 1), (TIPS, 2)] {
        let mut text = String::from("solid spikes\n");
        for k in 0..count {
            let outward = direction(k);
            spike(
                &mut text,
                scale(RADIUS - depth(k), outward),
                outward,
                2e-3,
                4e-4,
            );
        }
        let directory = fresh_directory(&format!("separate_{count}_{ranks}"));
        fs::write(directory.join("spikes.stl"), text + "endsolid spikes\n").unwrap();
        let sphere = |x: f64| Grain {
            density: 2500.0,
            ..Grain::sphere(RADIUS, [x, 0.0, 0.0])
        };
        // the second is far from the spikes, on another rank if there are two
        let scene = Scene {
            low: [-1.0, -0.1, -0.1],
            high: [1.0, 0.1, 0.1],
            ..Scene::open(1.0, vec![sphere(0.0), sphere(-0.5)])
        };
        let deck = Deck {
            before: vec![
                "fix spikes all mesh/surface file spikes.stl type 1 curvature 1e-5".into(),
            ],
            walls: vec!["mesh n_meshes 1 meshes spikes".into()],
            time_step: 1e-9,
            steps: 20,
            // a list built anew would have another chance to say it
            runs: vec!["run 10".into(), "run 10".into()],
            ..Deck::new(ELASTIC, 0.5)
        };
        let outcome = run_in(&engine, &directory, &scene, &deck, ranks);
        let expected = (0..count).fold([0.0; 3], |sum, k| {
            let size = 4.0 / 3.0 * modulus * RADIUS.sqrt() * depth(k).powf(1.5);
            add(sum, scale(-size, direction(k)))
        });
        let force = outcome.first().states[0].force;
        let off = length(sub(force, expected)) / length(expected);
        let said = outcome.output.matches("more places than are remembered");
        let said = said.count();
        println!("{count} tips, {ranks} ranks: off by {off:.1e}; said {said} times");
        assert!(off < 1e-6);
        assert_eq!(said, usize::from(count > 8));
        if count > 8 {
            assert!(outcome.output.contains("particle 1 touches the wall"));
        }
    }
}
