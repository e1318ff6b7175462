// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is the motion the same on one and four ranks, and is momentum kept across periodic boundaries?

use crate::harness::{crowd, momentum_error, run, Deck, Engine, Frame, Material};
use crate::shapes::{length, sub};

pub const MATERIAL: Material = [1e8, 0.3, 2000.0, 3000.0];

pub fn deck(steps: u64) -> Deck {
    Deck {
        time_step: 1e-5,
        steps,
        ..Deck::new(MATERIAL, 0.5)
    }
}

/// Largest difference of velocities, over the largest velocity.
pub fn difference(a: &Frame, b: &Frame) -> f64 {
    let largest = b
        .states
        .iter()
        .map(|s| length(s.velocity))
        .fold(0.0, f64::max);
    a.states
        .iter()
        .zip(&b.states)
        .map(|(p, q)| length(sub(p.velocity, q.velocity)) / largest)
        .fold(0.0, f64::max)
}

#[test]
fn ranks_do_not_change_the_motion_and_momentum_is_kept() {
    let engine = Engine::from_environment();
    let scene = crowd(64);
    let one = run(&engine, "one", &scene, &deck(300), 1);
    let changed = scene
        .grains
        .iter()
        .zip(&one.last().states)
        .filter(|(g, s)| length(sub(s.velocity, g.velocity)) > 1e-2 * length(g.velocity))
        .count();
    assert!(changed > 25, "{changed} grains have collided");
    let four = run(&engine, "four", &scene, &deck(300), 4);
    let apart = difference(four.last(), one.last());
    let momentum = [&one, &four].map(|o| momentum_error(&scene.grains, o.first(), o.last()));
    println!(
        "{changed} of {} grains have collided; velocities on four ranks and one apart by {apart:.1e}; momentum error {:.1e} and {:.1e}",
        scene.grains.len(), momentum[0], momentum[1]
    );
    assert!(apart < 1e-9);
    // with newton off a contact across a boundary is computed on both sides, from coordinates that were rounded apart
    assert!(momentum.iter().all(|m| *m < 1e-11));
}
