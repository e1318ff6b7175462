// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do the same collisions of two grains end with the same velocities and spins in LIGGGHTS and in LAMMPS?

use crate::harness::{run, Deck, Engine, Grain, Material, Scene, ELASTIC};
use crate::lammps;
use crate::shapes::{add, length, scale, sub, surface_point, unit, Random, Vector};

/// Two grains of this aspect ratio that are about to touch at random surface points.
fn about_to_touch(aspect: f64, seed: u64) -> Scene {
    let mut random = Random(seed);
    let short = 5e-3;
    let axes = [
        [aspect * short, short, short],
        [short, aspect * short, short],
    ];
    let n = random.direction();
    let turns = [random.quaternion(), random.quaternion()];
    // centres so that the two surface points of the common normal n are a small gap apart
    let reach = [
        surface_point(axes[0], turns[0], n),
        surface_point(axes[1], turns[1], scale(-1.0, n)),
    ];
    let apart = add(sub(reach[0], reach[1]), scale(1e-5, n));
    let along = unit(add(scale(-1.0, n), scale(0.6, random.direction())));
    let grain = |k: usize, place: Vector, velocity: Vector, spin: Vector| {
        Grain {
            density: 2500.0,
            ..Grain::new(axes[k], place).turned(turns[k])
        }
        .moving(velocity)
        .spinning(spin)
    };
    let spins = [
        scale(10.0, random.direction()),
        scale(10.0, random.direction()),
    ];
    Scene::open(
        0.3,
        vec![
            grain(0, scale(-0.5, apart), scale(-0.25, along), spins[0]),
            grain(1, scale(0.5, apart), scale(0.25, along), spins[1]),
        ],
    )
}

const VISCOUS: Material = [1e7, 0.3, 400.0, 400.0];

/// The largest relative difference of velocities and angular momenta after collisions, each engine with an integrator.
fn largest_difference(what: &str, ours: &'static str, theirs: &str) -> f64 {
    let engine = Engine::from_environment();
    let other = lammps::Engine::from_environment();
    let integrators = what;
    let mut worst = 0.0f64;
    for aspect in [2.0, 5.0, 10.0] {
        for seed in [1, 2] {
            for (what, [e, nu, eta1, eta2], mu) in [
                ("elastic", ELASTIC, 0.0),
                ("viscoelastic", VISCOUS, 0.0),
                ("frictional", VISCOUS, 0.5),
            ] {
                let scene = about_to_touch(aspect, seed);
                let (time_step, steps) = (5e-7, 8000);
                let deck = Deck {
                    time_step,
                    steps,
                    integrator: ours,
                    ..Deck::new([e, nu, eta1, eta2], mu)
                };
                let name = format!("{integrators}_{aspect}_{seed}_{what}");
                let in_liggghts = run(&engine, &name, &scene, &deck, 1);
                let tangential = if mu > 0.0 {
                    format!("tfd {mu}")
                } else {
                    "none".into()
                };
                let law = format!("nfd {e} {nu} {eta1} {eta2} tangential {tangential}");
                let in_lammps = lammps::run(
                    &other,
                    &name,
                    &scene,
                    &lammps::Deck {
                        time_step,
                        steps,
                        skin: 2e-3,
                        newton: false,
                        integrate: false,
                        fixes: vec![format!("fix move all {theirs}")],
                        ..lammps::Deck::new(&law)
                    },
                    1,
                );
                let (a, b) = (in_liggghts.last(), in_lammps.last());
                let mut errors = [0.0f64; 2];
                let mut change = 0.0f64;
                for (k, g) in scene.grains.iter().enumerate() {
                    let (p, q) = (&a.states[k], &b.states[k]);
                    errors[0] =
                        errors[0].max(length(sub(p.velocity, q.velocity)) / length(q.velocity));
                    errors[1] = errors[1].max(
                        length(sub(p.angular_momentum, q.angular_momentum))
                            / length(q.angular_momentum),
                    );
                    change = change.max(length(sub(q.velocity, g.velocity)) / 0.25);
                }
                println!(
                    "aspect ratio {aspect}, pose {seed}, {what}: velocities {:.1e}, angular momenta {:.1e}",
                    errors[0], errors[1]
                );
                assert!(change > 0.1, "{name}: the grains did not collide");
                worst = worst.max(errors[0]).max(errors[1]);
            }
        }
    }
    println!("{integrators}: largest relative difference {worst:.1e}");
    worst
}

#[test]
fn collisions_end_as_in_lammps() {
    let worst = largest_difference("their_own", "superquadric", "nve/asphere");
    assert!(worst < 1e-6);
}

/// The same integrator in both, with forces of the velocities of the half step: what is left is rounding.
#[test]
fn collisions_under_nve_ellipsoid_end_as_in_lammps_to_rounding() {
    let half = "nve/ellipsoid velocities half";
    let worst = largest_difference("nve_ellipsoid", "ellipsoid", half);
    assert!(worst < 1e-9);
}
