// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is the motion the same on one and four ranks, and is momentum kept across periodic boundaries?

use crate::harness::{
    attempt, crowd, last_lines, momentum_error, run, Deck, Engine, Frame, Grain, Material, Scene,
};
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

/// Two grains that touch each other on both sides of a short periodic box, and one that touches itself: contacts are remembered by ID, so
/// that friction of the two would be mixed up. Without friction, and where they touch once, they may.
#[test]
fn two_contacts_of_the_same_grains_are_refused_with_friction() {
    let engine = Engine::from_environment();
    let edge = 1.98e-2;
    let alone = vec![Grain::new([1e-2, 5e-3, 5e-3], [1e-2, 2e-2, 2e-2])];
    let two = |shift: f64| {
        vec![
            Grain::new([5e-3, 4e-3, 3e-3], [0.25 * edge, 2e-2, 2e-2]),
            Grain::new([5e-3, 4e-3, 3e-3], [0.75 * edge + shift, 2e-2, 2e-2]),
        ]
    };
    let friction = "nfd tangential tfd surface ellipsoid";
    let own_friction = "hertz tangential history surface ellipsoid";
    let none = "nfd tangential off surface ellipsoid";
    let twice = Some("particle 1 touches particle 2 in two places");
    for (name, grains, model, refusal) in [
        ("twice", two(0.0), friction, twice),
        ("twice_own", two(0.0), own_friction, twice),
        (
            "itself",
            alone.clone(),
            friction,
            Some("particle 1 touches itself"),
        ),
        ("once", two(1.5e-4), friction, None),
        ("twice_without", two(0.0), none, None),
        ("itself_without", alone, none, None),
    ] {
        let mut scene = Scene::open(4e-2, grains);
        (scene.low, scene.high) = ([0.0; 3], [edge, 4e-2, 4e-2]);
        scene.boundary = "p f f".into();
        let deck = Deck {
            model: model.into(),
            steps: 10,
            skin: 5e-4,
            before: vec!["neigh_modify delay 0 every 5 check no".into()],
            ..Deck::new(MATERIAL, 0.5)
        };
        let outcome = attempt(&engine, name, &scene, &deck, 1);
        let Some(words) = refusal else {
            outcome.succeeded();
            continue;
        };
        assert!(!outcome.success, "{name} was accepted");
        for word in [words, "periodic box"] {
            let output = &outcome.output;
            assert!(output.contains(word), "{name}: {}", last_lines(output));
        }
    }
}
