// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is the motion the same on one and four ranks, and is momentum kept across periodic boundaries?

use crate::harness::{run, Deck, Engine, Material};
use crate::lammps::{Frame, Grain, Scene};
use crate::shapes::{add, length, scale, sub, Random, Vector};

pub const MATERIAL: Material = [1e8, 0.3, 2000.0, 3000.0];

/// A crowd of ellipsoids in a periodic box, close enough to collide many times.
pub fn crowd(side: usize) -> Scene {
    let mut random = Random(64);
    let cell = 2.4e-2;
    let mut grains = vec![];
    for k in 0..side * side * side {
        let place = [k % side, k / side % side, k / side / side].map(|c| c as f64 + 0.5);
        let jitter: Vector = std::array::from_fn(|_| random.between(-0.05, 0.05));
        let mut axes = [1.5e-2, 1e-2, 0.8e-2];
        axes.rotate_left(k % 3);
        let axes = scale(random.between(0.75, 1.05), axes);
        let grain = Grain {
            density: 2500.0,
            ..Grain::new(axes, scale(cell, add(place, jitter))).turned(random.quaternion())
        };
        let velocity = scale(random.between(0.5, 1.5), random.direction());
        let spin = scale(random.between(5.0, 80.0), random.direction());
        grains.push(grain.moving(velocity).spinning(spin));
    }
    Scene::periodic([0.0; 3], [side as f64 * cell; 3], grains)
}

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

fn momentum_error(scene: &Scene, first: &Frame, last: &Frame) -> f64 {
    let sum = |frame: &Frame| {
        scene
            .grains
            .iter()
            .zip(&frame.states)
            .fold([0.0; 3], |m, (g, s)| add(m, scale(g.mass(), s.velocity)))
    };
    let size: f64 = scene
        .grains
        .iter()
        .zip(&first.states)
        .map(|(g, s)| g.mass() * length(s.velocity))
        .sum();
    length(sub(sum(last), sum(first))) / size
}

#[test]
fn ranks_do_not_change_the_motion_and_momentum_is_kept() {
    let engine = Engine::from_environment();
    let scene = crowd(4);
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
    let momentum = [&one, &four].map(|o| momentum_error(&scene, o.first(), o.last()));
    println!(
        "{changed} of {} grains have collided; velocities on four ranks and one apart by {apart:.1e}; momentum error {:.1e} and {:.1e}",
        scene.grains.len(), momentum[0], momentum[1]
    );
    assert!(apart < 1e-9);
    // with newton off a contact across a boundary is computed on both sides, from coordinates that were rounded apart
    assert!(momentum.iter().all(|m| *m < 1e-11));
}
