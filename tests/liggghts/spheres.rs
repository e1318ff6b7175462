// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do our models give the same collision of spheres under `surface default` and `surface ellipsoid`, and is LIGGGHTS' own
//! Hertz on our geometry the same as on its own spheres?

use crate::harness::{run, Deck, Engine, Frame, Grain, Material, Scene, ELASTIC};
use crate::shapes::{length, sub};

fn scene() -> Scene {
    let grain = |s: f64| {
        Grain {
            density: 2500.0,
            ..Grain::sphere(5e-3, [0.0, s * 2e-3, s * 4.6e-3])
        }
        .moving([0.0, 0.0, -0.25 * s])
        .spinning([5.0, 3.0, -4.0])
    };
    Scene::open(0.1, vec![grain(-1.0), grain(1.0)])
}

fn collide(model: &str, atom_style: &str, material: Material) -> Frame {
    let engine = Engine::from_environment();
    let deck = Deck {
        model: model.into(),
        atom_style: atom_style.into(),
        time_step: 5e-7,
        steps: 6000,
        ..Deck::new(material, 0.5)
    };
    let outcome = run(&engine, &model.replace(' ', "_"), &scene(), &deck, 1);
    outcome.last().clone()
}

fn hold(what: &str, a: &Frame, b: &Frame, tolerance: f64) {
    for k in 0..2 {
        let (p, q) = (&a.states[k], &b.states[k]);
        let v = length(sub(p.velocity, q.velocity)) / length(q.velocity);
        let w = length(sub(p.angular_velocity, q.angular_velocity)) / length(q.angular_velocity);
        println!("{what}: velocities {v:.1e}, spins {w:.1e}");
        let before = scene().grains[k].velocity;
        assert!(length(sub(q.velocity, before)) > 0.1, "no collision");
        assert!(v < tolerance && w < tolerance, "{what}");
    }
}

#[test]
fn our_models_under_either_surface() {
    let material = [1e7, 0.3, 400.0, 400.0];
    let ours = collide(
        "nfd tangential tfd surface ellipsoid",
        "superquadric",
        material,
    );
    let default = collide("nfd tangential tfd surface default", "sphere", material);
    hold("surface default", &default, &ours, 1e-6);
}

#[test]
fn the_engines_own_hertz_on_either_surface() {
    let ours = collide(
        "hertz tangential history surface ellipsoid",
        "superquadric",
        ELASTIC,
    );
    let default = collide(
        "hertz tangential history surface default",
        "sphere",
        ELASTIC,
    );
    hold("hertz", &ours, &default, 1e-3);
}
