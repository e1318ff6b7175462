// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does LIGGGHTS' rolling friction brake an ellipsoid that is a sphere as it brakes LIGGGHTS' own spheres, and another ellipsoid by
//! the radius that the page names?

use std::fs;

use crate::harness::{fresh_directory, run_in, Deck, Engine, Grain, Scene, State, ELASTIC};
use crate::meshes::sheet;
use crate::shapes::{length, sub, Vector};

const ROLLING: [&str; 4] = ["cdt", "epsd", "epsd2", "epsd3"];
const RADIUS: f64 = 5e-3;
const SPIN: f64 = 100.0;
const WEIGHT: f64 = 16.0;

fn properties() -> Vec<String> {
    [
        "coefficientRollingFriction peratomtypepair 1 0.1",
        "coefficientRollingViscousDamping peratomtypepair 1 0.3",
        "rollingStiffness scalar 2.25",
    ]
    .iter()
    .enumerate()
    .map(|(k, words)| format!("fix rolling{k} all property/global {words}"))
    .collect()
}

/// The last states of a run under a contact model with and without `surface ellipsoid`.
fn states(name: &str, model: &str, wall: Option<&str>, scene: &Scene, steps: u64) -> Vec<State> {
    let engine = Engine::from_environment();
    let directory = fresh_directory(&name.replace(' ', "_"));
    fs::write(directory.join("sheet.stl"), sheet(8)).unwrap();
    let ours = model.contains("ellipsoid");
    let mut before = properties();
    if wall.is_some_and(|wall| wall.contains("mesh")) {
        before.push("fix sheet all mesh/surface file sheet.stl type 1".into());
    }
    let deck = Deck {
        model: model.into(),
        atom_style: if ours { "superquadric" } else { "sphere" }.into(),
        wall_fix: if ours {
            "wall/gran/ellipsoid"
        } else {
            "wall/gran"
        }
        .into(),
        walls: wall.iter().map(|wall| wall.to_string()).collect(),
        before,
        fixes: if wall.is_some() {
            vec![format!("fix weight all gravity {WEIGHT} vector 0 0 -1")]
        } else {
            vec![]
        },
        // the models of this project have no such damping
        settings: if model.starts_with("hertz") {
            "tangential_damping off"
        } else {
            ""
        }
        .into(),
        time_step: 1e-5,
        steps,
        ..Deck::new(ELASTIC, 0.5)
    };
    let outcome = run_in(&engine, &directory, scene, &deck, 1);
    outcome.last().states.clone()
}

/// The angular velocities in the end.
fn spins(name: &str, model: &str, wall: Option<&str>, scene: &Scene, steps: u64) -> Vec<Vector> {
    let states = states(name, model, wall, scene, steps);
    states.iter().map(|s| s.angular_velocity).collect()
}

/// The spin with which the sphere rolls in the end: that of its moment of momentum about the point of contact. Its spin itself
/// swings about this one, since LIGGGHTS' tangential spring has no damping here, and that of `tfd` little; the amplitude is 3 %.
fn rolling_spin(name: &str, model: &str, wall: &str) -> f64 {
    let state = &states(name, model, Some(wall), &rolling_sphere(), 20_000)[0];
    (0.4 * state.angular_velocity[1] + state.velocity[0] / RADIUS) / 1.4
}

/// A sphere that rests on the wall, as deep as its weight presses it, and rolls along x.
fn rolling_sphere() -> Scene {
    let mut sphere = Grain {
        density: 2500.0,
        ..Grain::sphere(RADIUS, [-0.05, 0.013, RADIUS])
    };
    let modulus = 0.5 * ELASTIC[0] / (1.0 - ELASTIC[1] * ELASTIC[1]);
    sphere.position[2] -=
        (0.75 * sphere.mass() * WEIGHT / (modulus * RADIUS.sqrt())).powf(2.0 / 3.0);
    Scene::open(
        0.1,
        vec![sphere
            .moving([SPIN * RADIUS, 0.0, 0.0])
            .spinning([0.0, SPIN, 0.0])],
    )
}

#[test]
fn a_sphere_on_a_plane_and_on_a_mesh() {
    for wall in [
        "primitive type 1 zplane 0.0",
        "mesh n_meshes 1 meshes sheet",
    ] {
        let kind = &wall[..4];
        let free = rolling_spin(
            &format!("free {kind}"),
            "nfd tangential tfd surface ellipsoid",
            wall,
        );
        for rolling in ROLLING {
            let theirs = rolling_spin(
                &format!("theirs {rolling} {kind}"),
                &format!("hertz tangential history rolling_friction {rolling}"),
                wall,
            );
            for tangential in ["tfd", "history"] {
                let ours = rolling_spin(
                    &format!("{tangential} {rolling} {kind}"),
                    &format!(
                        "nfd tangential {tangential} rolling_friction {rolling} surface ellipsoid"
                    ),
                    wall,
                );
                println!("{kind}, {rolling}, {tangential}: {ours:.4}, hertz of spheres {theirs:.4}, without {free:.3}");
                assert!((free - SPIN).abs() < 0.02 * SPIN, "rolls without friction");
                assert!(theirs < 0.8 * free, "the rolling friction does something");
                assert!((ours - theirs).abs() < 2e-4 * theirs);
            }
        }
    }
}

/// Two spheres pressed together spin one against the other; the torque is on both.
#[test]
fn two_spheres() {
    let sphere = |z: f64, spin: f64| {
        Grain {
            density: 2500.0,
            ..Grain::sphere(RADIUS, [0.0, 0.0, z])
        }
        .spinning([0.0, spin, 0.0])
    };
    // frictionless, so that rolling friction alone acts
    let scene = Scene::open(
        0.1,
        vec![
            sphere(-0.995 * RADIUS, SPIN),
            sphere(0.995 * RADIUS, -0.5 * SPIN),
        ],
    );
    for rolling in ROLLING {
        let theirs = spins(
            &format!("theirs {rolling}"),
            &format!("hertz rolling_friction {rolling}"),
            None,
            &scene,
            12,
        );
        let ours = spins(
            &format!("ours {rolling}"),
            &format!("nfd rolling_friction {rolling} surface ellipsoid"),
            None,
            &scene,
            12,
        );
        for (k, start) in [SPIN, -0.5 * SPIN].iter().enumerate() {
            let (changed, apart) = (
                length(sub(theirs[k], [0.0, *start, 0.0])),
                length(sub(ours[k], theirs[k])),
            );
            println!("{rolling}, sphere {k}: spin changed by {changed:.4}, apart by {apart:.1e}");
            assert!(changed > 0.01);
            assert!(apart < 2e-2 * changed);
        }
    }
}

/// Constant torque is the coefficient times the elastic force times `Re F2^-3`, which for an ellipsoid of revolution on its
/// pole is the radius of curvature there.
#[test]
fn the_radius_of_an_ellipsoid_at_its_pole() {
    let engine = Engine::from_environment();
    let axes = [4e-3, 4e-3, 2e-3];
    let overlap = 1e-5;
    let grain = Grain {
        density: 2500.0,
        ..Grain::new(axes, [0.0, 0.0, axes[2] - overlap])
    }
    .spinning([0.0, SPIN, 0.0]);
    let deck = Deck {
        model: "nfd rolling_friction cdt surface ellipsoid".into(),
        walls: vec!["primitive type 1 zplane 0.0".into()],
        before: properties(),
        time_step: 1e-9,
        ..Deck::new(ELASTIC, 0.5)
    };
    let directory = fresh_directory("pole");
    let outcome = run_in(
        &engine,
        &directory,
        &Scene::open(0.1, vec![grain]),
        &deck,
        1,
    );
    let state = &outcome.first().states[0];
    let radius = axes[0] * axes[0] / axes[2];
    let expected = -0.1 * state.force[2] * radius;
    println!("torque {:e}, expected {expected:e}", state.torque[1]);
    assert!((state.torque[1] - expected).abs() < 1e-9 * expected.abs());
}
