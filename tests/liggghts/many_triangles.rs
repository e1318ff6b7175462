// SPDX-License-Identifier: MIT OR Apache-2.0
//! A long grain near more triangles than LIGGGHTS' lists have room for: is the message that of the page, and does its cure work?

use std::fs;

use crate::harness::{attempt_in, fresh_directory, Deck, Engine, Grain, Outcome, Scene, ELASTIC};
use crate::meshes::sheet;

const PAGE: &str = include_str!("../../liggghts-patch/README.md");
const MESSAGE: &str = "mesh neighbor list overflow, boost neigh_modify one and/or page";
const CURE: &str = "neigh_modify delay 0 one 8000 page 100000";

/// A needle whose bounding sphere reaches over some 6000 triangles.
fn needle(lists: &[&str], name: &str) -> Outcome {
    let engine = Engine::from_environment();
    let directory = fresh_directory(name);
    fs::write(directory.join("sheet.stl"), sheet(64)).unwrap();
    let grain = Grain {
        density: 2500.0,
        ..Grain::new([3e-2, 1e-3, 1e-3], [1e-3, 1.3e-3, 0.99e-3])
    };
    let mut before = vec!["fix sheet all mesh/surface file sheet.stl type 1".to_string()];
    before.extend(lists.iter().map(|line| line.to_string()));
    let deck = Deck {
        before,
        walls: vec!["mesh n_meshes 1 meshes sheet".into()],
        steps: 5,
        ..Deck::new(ELASTIC, 0.5)
    };
    attempt_in(
        &engine,
        &directory,
        &Scene::open(0.1, vec![grain]),
        &deck,
        1,
    )
}

#[test]
fn the_message_and_its_cure() {
    assert!(PAGE.contains(MESSAGE) && PAGE.contains(CURE));
    let without = needle(&[], "without");
    assert!(!without.success && without.output.contains(MESSAGE));
    let with = needle(&[CURE], "with").succeeded();
    assert!(with.first().states[0].force[2] > 0.0);
}
