// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rebound of two spheres under friction: the no-slip and the gross-slip limits, and that nothing is gained in between.

use std::f64::consts::PI;

use crate::harness::{kinetic_energy, largest_difference, run, Deck, Engine, Frame, Grain, Scene};
use crate::normal_motion::{converge, greatest_overlap, hertz_time, DENSITY, MODULUS, RADIUS};
use crate::shapes::{inertia, scale, Vector};

/// Slow enough that the lever arm, the radius less half the overlap, is the radius: overlap 1e-6 of the radius.
const SPEED: f64 = 1e-6;

struct Rebound {
    /// Relative velocity of the surfaces at the contact, across the normal, over its initial value.
    surface: f64,
    /// Spin of each sphere after the collision times R.
    spin: f64,
    /// Final over initial kinetic energy.
    energy: f64,
}

fn rebound(engine: &Engine, law: &str, poisson: f64, surface_speed: f64, steps: f64) -> Rebound {
    let grain = |s: f64| Grain {
        density: DENSITY,
        ..Grain::sphere(RADIUS, [s * RADIUS, 0.0, 0.0]).moving([
            -s * 0.5 * SPEED,
            s * 0.5 * surface_speed,
            0.0,
        ])
    };
    let scene = Scene::open(0.1, vec![grain(-1.0), grain(1.0)]);
    // the contact time scales with E*^(-2/5)
    let time = hertz_time(SPEED) * ((1.0 - poisson * poisson) / (1.0 - 0.09)).powf(0.4);
    let time_step = time / steps;
    let deck = Deck {
        time_step,
        steps: (1.2 * steps) as u64,
        skin: 1e-3,
        ..Deck::new(law)
    };
    let outcome = run(engine, "rebound", &scene, &deck, 1);
    let [i, j] = [&outcome.last().states[0], &outcome.last().states[1]];
    assert_eq!(j.force, [0.0; 3], "still in contact");
    let moment = inertia(scene.grains[0].mass(), scene.grains[0].semi_axes)[0];
    let spin = |s: Vector| scale(RADIUS / moment, s)[2];
    let (wi, wj) = (spin(i.angular_momentum), spin(j.angular_momentum));
    let energy = |states: &[crate::harness::State]| {
        scene
            .grains
            .iter()
            .zip(states)
            .map(|(g, s)| kinetic_energy(g, s))
            .sum::<f64>()
    };
    Rebound {
        surface: (j.velocity[1] - wj - i.velocity[1] - wi) / surface_speed,
        spin: wj,
        energy: energy(&outcome.last().states) / energy(&outcome.first().states),
    }
}

/// v_t'/v_t = cos(pi sqrt(1/100 + 6 L/5))/cos(pi/10), L = 7/(2 kappa): incremental form, no slip.
#[test]
fn both_versions_no_slip_rebound() {
    let engine = Engine::from_environment();
    for (poisson, magnitude) in [(0.3f64, 0.954847528103f64), (0.25, 1.0)] {
        let kappa = (2.0 - poisson) / (2.0 * (1.0 - poisson));
        let expected =
            (PI * (0.01 + 6.0 / 5.0 * 7.0 / (2.0 * kappa)).sqrt()).cos() / (PI / 10.0).cos();
        assert!((expected.abs() - magnitude).abs() < 1e-11);
        let law =
            format!("hertz {MODULUS} {poisson} tangential mindlin 1e6 displacement incremental");
        converge(
            &format!("no-slip rebound, nu {poisson}"),
            expected,
            NO_SLIP_ORDER,
            2e-5,
            |s| rebound(&engine, &law, poisson, 0.1 * SPEED, s).surface,
        );
    }
}

const NO_SLIP_ORDER: i32 = 2;

/// v_t' = v_t - 7 mu v_n and spin 5 mu v_n/R of a sphere on a plane; two spheres share the spin.
#[test]
fn both_versions_gross_slip() {
    let engine = Engine::from_environment();
    let friction = 0.2;
    let kappa = 1.7 / 1.4;
    for over in [1.5, 3.0] {
        let surface_speed = over * (7.0 - kappa) * friction * SPEED;
        for tangential in ["tfd", "mindlin", "linear"] {
            let words = match tangential {
                "linear" => format!(
                    "linear {:e} 0 {friction}",
                    1e6 * greatest_overlap(SPEED).sqrt()
                ),
                other => format!("{other} {friction}"),
            };
            let law = format!("hertz {MODULUS} 0.3 tangential {words}");
            let r = rebound(&engine, &law, 0.3, surface_speed, 4000.0);
            let surface = 1.0 - 7.0 * friction * SPEED / surface_speed;
            let spin = -2.5 * friction * SPEED;
            println!(
                "gross slip, {tangential}, v_t {over} times the limit: surface velocity {:.8} (expected {surface:.8}), spin {:.8} (expected 1)",
                r.surface,
                r.spin.abs() / spin.abs()
            );
            assert!((r.surface - surface).abs() < 2e-4, "{tangential}");
            assert!(
                (r.spin.abs() / spin.abs() - 1.0).abs() < 2e-4,
                "{tangential}"
            );
        }
    }
}

/// Between the limits elastic friction takes energy and gives none.
#[test]
fn both_versions_oblique_impacts_gain_no_energy() {
    let engine = Engine::from_environment();
    for words in [
        "tfd 0.3",
        "mindlin 0.3",
        "mindlin 0.3 displacement incremental",
    ] {
        for angle in [0.1, 0.5, 1.0, 1.5, 3.0] {
            let r = rebound(
                &engine,
                &format!("hertz {MODULUS} 0.3 tangential {words}"),
                0.3,
                angle * SPEED,
                2000.0,
            );
            println!(
                "{words}, v_t/v_n {angle}: surface velocity {:.6}, energy {:.8}",
                r.surface, r.energy
            );
            assert!(
                r.energy < 1.0 + 1e-5,
                "{words} at v_t/v_n {angle}: energy {}",
                r.energy
            );
        }
    }
}

/// The state after an oblique impact of spinning ellipsoids under friction without slip converges with the step.
#[test]
fn both_versions_oblique_impact_of_ellipsoids_converges() {
    let engine = Engine::from_environment();
    let scene = crate::decomposition::meeting_at([0.0625; 3]);
    // three halvings: second order gives 64, first order 8; the incremental form takes the stiffness at the end of each step
    let cases = [
        ("hertz 1e8 0.3", 25.0),
        (
            "hertz 1e8 0.3 tangential mindlin 1e6 displacement total",
            15.0,
        ),
        (
            "hertz 1e8 0.3 tangential mindlin 1e6 displacement incremental",
            3.0,
        ),
    ];
    for (law, falls) in cases {
        let finals: Vec<Frame> = [1.0, 2.0, 4.0, 8.0, 16.0]
            .map(|finer: f64| {
                let deck = Deck {
                    time_step: 4e-6 / finer,
                    steps: (150.0 * finer) as u64,
                    skin: 2e-3,
                    ..Deck::new(law)
                };
                run(&engine, "converging", &scene, &deck, 1).last().clone()
            })
            .into();
        let differences: Vec<f64> = finals
            .windows(2)
            .map(|w| largest_difference(&w[0], &w[1]).1)
            .collect();
        println!(
            "{law}: velocities change from step to half the step by {}",
            differences
                .iter()
                .map(|d| format!("{d:.2e} "))
                .collect::<String>()
        );
        assert!(
            differences[3] < differences[0] / falls,
            "{law}: {differences:?}"
        );
    }
}
