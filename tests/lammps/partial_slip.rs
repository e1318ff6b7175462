// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a contact under `displacement hysteretic` follow the loop of Mindlin and Deresiewicz, between grains and at a wall?
//!
//! Grains that overlap are held where they are while their velocities stay: every step adds the same tangential displacement.

use crate::harness::{run, Deck, Engine, Grain, Scene};

const MODULUS: f64 = 1e7;
const POISSON: f64 = 0.3;
const FRICTION: f64 = 0.5;
const RADIUS: f64 = 1e-2;
const OVERLAP: f64 = 1e-3 * RADIUS;
/// Largest displacement over that of sliding, and steps from the middle to it.
const AMPLITUDE: f64 = 0.8;
const STEPS: usize = 100;
const TIME_STEP: f64 = 1e-6;

/// Force over Coulomb's limit by displacement over that of sliding.
fn cattaneo_mindlin(s: f64) -> f64 {
    1.0 - (1.0 - s.clamp(0.0, 1.0)).powf(1.5)
}

/// Out, back to the other side, and out again.
fn wanted() -> Vec<f64> {
    let top = cattaneo_mindlin(AMPLITUDE);
    let branch = |k: usize| 2.0 * cattaneo_mindlin(0.5 * AMPLITUDE * k as f64 / STEPS as f64);
    let out = (0..=STEPS).map(|k| cattaneo_mindlin(AMPLITUDE * k as f64 / STEPS as f64));
    let back = (1..=2 * STEPS).map(|k| top - branch(k));
    let again = (1..=2 * STEPS).map(|k| -top + branch(k));
    out.chain(back).chain(again).collect()
}

/// Work done in the closed cycle, in units of Coulomb's limit times the displacement of sliding.
fn lost(forces: &[f64]) -> f64 {
    let step = AMPLITUDE / STEPS as f64;
    let mean = |k: usize| 0.5 * (forces[k] + forces[k - 1]);
    let back: f64 = (STEPS + 1..=3 * STEPS).map(mean).sum();
    let again: f64 = (3 * STEPS + 1..=5 * STEPS).map(mean).sum();
    (again - back) * step
}

/// Tangential forces on the moved grain after each step, over Coulomb's limit.
fn forces(engine: &Engine, name: &str, scene: &Scene, law: &str, wall: bool) -> Vec<f64> {
    let kappa = (2.0 - POISSON) / (2.0 * (1.0 - POISSON));
    let sliding = FRICTION * kappa * OVERLAP;
    let velocity = AMPLITUDE * sliding / (STEPS as f64 * TIME_STEP);
    let leg = |velocity: f64, steps: usize| {
        [
            format!("velocity moved set {velocity:e} 0 0"),
            format!("run {steps}"),
        ]
    };
    let mut fixes = vec![format!("group moved id {}", scene.grains.len())];
    if wall {
        fixes.push(format!(
            "fix floor all wall/gran/ellipsoid {law} zplane 0.0 NULL"
        ));
    }
    let deck = Deck {
        time_step: TIME_STEP,
        integrate: false,
        skin: 1e-3,
        fixes,
        dump_every: 1,
        runs: [
            leg(velocity, STEPS),
            leg(-velocity, 2 * STEPS),
            leg(velocity, 2 * STEPS),
        ]
        .concat(),
        ..Deck::new(law)
    };
    let outcome = run(engine, name, scene, &deck, 1);
    let moved = scene.grains.len() - 1;
    let forces: Vec<f64> = outcome
        .frames
        .iter()
        .map(|frame| frame.states[moved].force)
        .map(|f| -f[0] / (FRICTION * f[2]))
        .collect();
    assert_eq!(forces.len(), 5 * STEPS + 1, "{name}");
    forces
}

#[test]
fn both_versions_a_cycle_below_sliding_has_its_loop() {
    let engine = Engine::from_environment();
    let grain = |z: f64| Grain {
        density: 2500.0,
        ..Grain::sphere(RADIUS, [0.0, 0.0, z])
    };
    let pair = Scene::open(0.1, vec![grain(0.0), grain(2.0 * RADIUS - OVERLAP)]);
    let floor = Scene::open(0.1, vec![grain(RADIUS - OVERLAP)]);
    let wanted = wanted();
    for (name, scene, wall) in [
        ("loop_of_pair", &pair, false),
        ("loop_at_wall", &floor, true),
    ] {
        let law = format!(
            "hertz {MODULUS:e} {POISSON} tangential tfd {FRICTION} displacement hysteretic"
        );
        let got = forces(&engine, name, scene, &law, wall);
        let worst = got
            .iter()
            .zip(&wanted)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        let (loss, all) = (lost(&got), lost(&wanted));
        println!("{name}: off by {worst:.4} of the limit, lost {loss:.4} of {all:.4}");
        assert!(worst < 0.01, "{name}: {worst}");
        assert!((loss / all - 1.0).abs() < 0.03, "{name}: {loss} {all}");
        // What goes back the way it came loses nothing.
        let rescaled = forces(
            &engine,
            name,
            scene,
            &law.replace("hysteretic", "rescaled"),
            wall,
        );
        assert!(
            lost(&rescaled).abs() < 1e-3 * all,
            "{name}: {}",
            lost(&rescaled)
        );
    }
}
