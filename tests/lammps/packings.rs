// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do small random packings, made by the decks of validation/packings, have the known solid fraction and coordination?

use std::path::Path;

use crate::harness::{execute, fresh_directory, last_lines, Engine};

/// Solid fraction and contacts per grain of 200 grains with these axes, compressed.
fn compressed(axes: [f64; 3], friction: f64) -> [f64; 2] {
    let engine = Engine::from_environment();
    let deck = Path::new(env!("CARGO_MANIFEST_DIR")).join("validation/packings/compress.lmp");
    let mut text = format!("variable plugin index {}\n", engine.plugin.display());
    for (name, value) in ["dx", "dy", "dz"].iter().zip(axes) {
        text += &format!("variable {name} index {value:.15}\n");
    }
    text += &format!("variable grains index 200\nvariable friction index {friction}\n");
    text += &std::fs::read_to_string(&deck).unwrap();
    let (success, output) = execute(&engine, &fresh_directory("packing"), &text, 1);
    assert!(success, "{}", last_lines(&output));
    let line = output
        .lines()
        .rev()
        .find(|line| line.starts_with("solid fraction"))
        .expect("the deck prints its solid fraction");
    let numbers: Vec<f64> = line
        .split([' ', ','])
        .filter_map(|word| word.parse().ok())
        .collect();
    println!("axes {axes:.3?}, friction {friction}: {line}");
    [numbers[0], numbers[1]]
}

/// Known without friction: 0.64 and 6 for spheres; 0.70 to 0.71 at aspect ratio 1.5; fewer than twice the degrees of freedom, 10.
/// Rattlers count here, and 200 grains pack a little more loosely than many.
#[test]
fn ellipsoids_pack_more_densely_than_spheres_and_friction_loosens() {
    let (long, short) = (1.5f64.powf(2.0 / 3.0), 1.5f64.powf(-1.0 / 3.0));
    let spheres = compressed([1.0; 3], 0.0);
    let ellipsoids = compressed([long, short, short], 0.0);
    let rough = compressed([long, short, short], 0.5);
    assert!((0.61..0.66).contains(&spheres[0]), "{spheres:?}");
    assert!((5.6..6.4).contains(&spheres[1]), "{spheres:?}");
    assert!(ellipsoids[0] > spheres[0] + 0.04, "{ellipsoids:?}");
    assert!(ellipsoids[0] < 0.74, "{ellipsoids:?}");
    assert!((8.0..10.2).contains(&ellipsoids[1]), "{ellipsoids:?}");
    assert!(rough[0] < ellipsoids[0] - 0.02, "{rough:?}");
    assert!(rough[1] < ellipsoids[1] - 1.5, "{rough:?}");
}
