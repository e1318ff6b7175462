// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a deck reach every shape of the library by its name, and do they push grains as they should? The reference is that of the same walls
//! in LAMMPS.

use crate::engines::curved_walls::{
    errors, shapes, tolerance, touching_once, touching_twice, MODULUS, POISSON,
};
use crate::harness::{attempt, run, Deck, Engine, Grain, Scene};
use crate::shapes::Random;

fn deck(words: &str) -> Deck {
    Deck {
        model: "nfd surface ellipsoid".into(),
        walls: vec![format!("primitive type 1 {words}")],
        fixes: vec!["neigh_modify exclude group all all".into()],
        time_step: 1e-9,
        ..Deck::new([MODULUS, POISSON, 0.0, 0.0], 0.0)
    }
}

#[test]
fn shapes_by_name_push_as_their_deepest_places_say() {
    let engine = Engine::from_environment();
    let mut random = Random(12);
    for wall in shapes() {
        let mut grains = touching_once(&wall, &mut random);
        if wall.name.starts_with("in a") {
            grains.extend(touching_twice(&mut random));
        }
        let name = format!("shape_{}", wall.name.replace([' ', '\''], "_"));
        let scene = Scene::open(10.0, grains.clone());
        let found = |words: &str| {
            let outcome = run(&engine, &name, &scene, &deck(words), 1);
            let states = &outcome.last().states;
            Vec::from_iter(states.iter().map(|s| (s.force, s.torque)))
        };
        // in one call for all contacts, and one by one
        for words in [&wall.words, &format!("{} store_force yes", wall.words)] {
            let (worst, most) = errors(&wall, &grains, &found(words));
            let tolerance = tolerance(&wall);
            assert!(
                worst.iter().all(|e| *e < tolerance),
                "{}: {worst:?}",
                wall.name
            );
            if wall.name.starts_with("in a") {
                assert!(most >= 2, "{}: no grain touches twice", wall.name);
            }
        }
    }
}

/// Several shapes make one wall: a grain in the corner between two planes has the forces of both.
#[test]
fn shapes_one_after_the_other_are_one_wall() {
    let engine = Engine::from_environment();
    let grain = Grain::new([0.3, 0.2, 0.25], [0.199, 0.05, 0.249]);
    let scene = Scene::open(
        10.0,
        vec![grain.turned([0.5f64.sqrt(), 0.0, 0.0, 0.5f64.sqrt()])],
    );
    let (floor, side) = (
        "shape plane axis 0 0 1 side inside",
        "shape plane axis 1 0 0 side inside",
    );
    let force = |words: &str| {
        let outcome = run(&engine, "corner", &scene, &deck(words), 1);
        outcome.last().states[0].force
    };
    let both = force(&format!("{floor} {side}"));
    let (a, b) = (force(floor), force(side));
    assert!(a[2] > 0.0 && b[0] > 0.0);
    for k in 0..3 {
        assert!((both[k] - a[k] - b[k]).abs() < 1e-12 * (a[2] + b[0]));
    }
}

#[test]
fn wrong_words_are_named() {
    let engine = Engine::from_environment();
    let scene = Scene::open(10.0, vec![Grain::sphere(0.1, [0.0; 3])]);
    let cases: [(&str, &[&str]); 7] = [
        ("shape", &["'shape' needs a name"]),
        ("shape torus", &["torus", "plane, cylinder, cone, sphere"]),
        ("shape sphere radius", &["'radius'", "1 value"]),
        ("shape sphere radius 1 radius 2", &["radius", "twice"]),
        ("shape cone radii 1 2 bounds 3 2", &["lower bound"]),
        ("shape plane side left", &["side", "'left'"]),
        ("shape plane axis 0 0 1 shear x 1.0", &["shear", "mesh"]),
    ];
    for (words, named) in cases {
        let outcome = attempt(&engine, "wrong", &scene, &deck(words), 1);
        let output = &outcome.output;
        assert!(!outcome.success, "{words}");
        for word in named {
            assert!(output.contains(word), "{words}: {word} in {output}");
        }
    }
}
