// SPDX-License-Identifier: MIT OR Apache-2.0
//! A grain on a plane wall: rebound, sliding into rolling, rest depth.

use crate::harness::{kinetic_energy, run, Deck, Engine, Frame, Grain, Outcome, Scene};
use crate::normal_motion::{converge, vertex, HERTZ_TIME};
use crate::shapes::{
    about, cross, hertz_stiffness, inertia, rotate, surface_point, unrotate, IDENTITY,
};

const RADIUS: f64 = 1e-2;
const DENSITY: f64 = 2500.0;
const MODULUS: f64 = 1e7;
const POISSON: f64 = 0.3;
const GRAVITY: f64 = 9.81;

/// The words of the wall fix are the constants of both sides.
fn stiffness(poisson: f64) -> f64 {
    4.0 / 3.0 * MODULUS / (2.0 * (1.0 - poisson * poisson)) * RADIUS.sqrt()
}

fn ball() -> Grain {
    Grain {
        density: DENSITY,
        ..Grain::sphere(RADIUS, [0.0, 0.0, RADIUS])
    }
}

fn deck(law: &str, time_step: f64, steps: u64) -> Deck {
    Deck {
        fixes: vec![format!(
            "fix floor all wall/gran/ellipsoid {law} zplane 0.0 NULL"
        )],
        time_step,
        steps,
        skin: 1e-3,
        ..Deck::new(&format!("hertz {MODULUS} {POISSON}"))
    }
}

fn spin(grain: &Grain, frame: &Frame) -> f64 {
    frame.states[0].angular_momentum[1] / inertia(grain.mass(), grain.semi_axes)[0]
}

/// Ball thrown at the floor with a small overlap; the first step is first touch.
fn throw(
    engine: &Engine,
    law: &str,
    poisson: f64,
    down: f64,
    along: f64,
    steps: f64,
) -> (Outcome, f64) {
    let (m, k) = (ball().mass(), stiffness(poisson));
    let time = HERTZ_TIME * (5.0 * m * down * down / (4.0 * k)).powf(0.4) / down;
    let scene = Scene::open(0.1, vec![ball().moving([along, 0.0, -down])]);
    let deck = Deck {
        dump_every: 1,
        ..deck(law, time / steps, (1.2 * steps) as u64)
    };
    let outcome = run(engine, "throw", &scene, &deck, 1);
    assert_eq!(outcome.last().states[0].force, [0.0; 3], "still in contact");
    (outcome, time)
}

#[test]
fn both_versions_hertz_rebound_from_a_plane() {
    let engine = Engine::from_environment();
    let down: f64 = 0.1;
    let (m, k) = (ball().mass(), stiffness(POISSON));
    let depth = (5.0 * m * down * down / (4.0 * k)).powf(0.4);
    let time = 3.218_065_459_719_043 * (m * m / (k * k * down)).powf(0.2);
    let law = format!("hertz {MODULUS} {POISSON}");
    let measure = |steps: f64| {
        let (outcome, _) = throw(&engine, &law, POISSON, down, 0.0, steps);
        let depths: Vec<f64> = outcome
            .frames
            .iter()
            .map(|f| RADIUS - f.states[0].position[2])
            .collect();
        let last = outcome.last();
        let velocity = last.states[0].velocity[2];
        let duration =
            last.step as f64 * time / steps - (last.states[0].position[2] - RADIUS) / velocity;
        (duration, vertex(&depths), velocity / down)
    };
    converge("contact time with a plane", time, 2, 1e-6, |s| measure(s).0);
    converge("greatest overlap with a plane", depth, 2, 1e-6, |s| {
        measure(s).1
    });
    converge("restitution from a plane", 1.0, 2, 1e-7, |s| measure(s).2);
}

/// Ratio of the surface velocities at the contact, across the normal.
#[test]
fn both_versions_no_slip_rebound_from_a_plane() {
    let engine = Engine::from_environment();
    let down = 1e-6;
    for (poisson, expected) in [(0.3, 0.954847528103), (0.25, 1.0)] {
        let law =
            format!("hertz {MODULUS} {poisson} tangential mindlin 1e6 displacement incremental");
        converge(
            &format!("no-slip rebound from a plane, nu {poisson}"),
            expected,
            2,
            2e-5,
            |s| {
                let (outcome, _) = throw(&engine, &law, poisson, down, 0.1 * down, s);
                let last = outcome.last();
                ((last.states[0].velocity[0] - RADIUS * spin(&ball(), last)) / (0.1 * down)).abs()
            },
        );
    }
}

#[test]
fn both_versions_gross_slip_on_a_plane() {
    let engine = Engine::from_environment();
    let (down, friction) = (1e-6, 0.25);
    let along = 10.0 * friction * down;
    for tangential in ["tfd", "mindlin"] {
        let law = format!("hertz {MODULUS} {POISSON} tangential {tangential} {friction}");
        let (outcome, _) = throw(&engine, &law, POISSON, down, along, 4000.0);
        let last = outcome.last();
        let surface = last.states[0].velocity[0] - RADIUS * spin(&ball(), last);
        let (expected, turning) = (along - 7.0 * friction * down, 5.0 * friction * down);
        println!(
            "gross slip on a plane, {tangential}: surface velocity {:.8} of the expected, spin {:.8}",
            surface / expected,
            RADIUS * spin(&ball(), last) / turning
        );
        assert!((surface / expected - 1.0).abs() < 5e-4);
        assert!((RADIUS * spin(&ball(), last) / turning - 1.0).abs() < 2e-4);
    }
}

/// A ball set down with v0 and no spin rolls from t = 2 v0/(7 mu g) on, at 5 v0/7.
#[test]
fn both_versions_sliding_into_rolling() {
    let engine = Engine::from_environment();
    let (friction, speed) = (0.3, 0.2);
    // so stiff that the lever arm is the radius: rest depth 1.3e-4 R
    let modulus = 1e9;
    let (m, k) = (ball().mass(), stiffness(POISSON) * modulus / MODULUS);
    let depth = (m * GRAVITY / k).powf(2.0 / 3.0);
    let mut grain = ball().moving([speed, 0.0, 0.0]);
    grain.position = [-0.05, 0.0, RADIUS - depth];
    let scene = Scene::open(0.1, vec![grain.clone()]);
    // the tangential spring would swing for long after the ball has begun to roll: damp it
    let relaxation = 1e-4;
    let (shear, bulk) = (
        relaxation * modulus / (1.0 + POISSON),
        relaxation * modulus / (3.0 * (1.0 - 2.0 * POISSON)),
    );
    let law = format!("nfd {modulus} {POISSON} {shear:e} {bulk:e} tangential tfd {friction}");
    let expected = 2.0 * speed / (7.0 * friction * GRAVITY);
    let (steps, every) = (60000, 20);
    let time_step = 2.0 * expected / steps as f64;
    let mut deck = deck(&law, time_step, steps);
    deck.fixes
        .push(format!("fix fall all gravity {GRAVITY} vector 0 0 -1"));
    deck.dump_every = every;
    let outcome = run(&engine, "rolling", &scene, &deck, 1);
    let slip = |f: &Frame| f.states[0].velocity[0] - RADIUS * spin(&grain, f);
    let at = |t: f64| &outcome.frames[(t / time_step).round() as usize / every as usize];
    // while the ball slides the slip falls linearly
    let (a, b) = (at(0.3 * expected), at(0.6 * expected));
    let rate = (slip(b) - slip(a)) / ((b.step - a.step) as f64 * time_step);
    let start = a.step as f64 * time_step - slip(a) / rate;
    let last = outcome.last();
    let rolling = last.states[0].velocity[0] / (5.0 * speed / 7.0);
    println!(
        "sliding into rolling: rest depth {:.1e} R; slip ends at {:.6} of 2 v0/(7 mu g); rolls at {rolling:.7} of 5 v0/7, slip left {:.1e} v0",
        depth / RADIUS,
        start / expected,
        slip(last) / speed
    );
    assert!((start / expected - 1.0).abs() < 2e-4);
    assert!((rolling - 1.0).abs() < 2e-4);
    assert!(slip(last).abs() < 2e-4 * speed);
    // the spring swings once the ball rolls, by less than mu g over its frequency
    let swing = outcome
        .frames
        .iter()
        .filter(|f| f.step as f64 * time_step > 1.01 * expected)
        .map(|f| slip(f).abs())
        .fold(0.0, f64::max);
    assert!(
        swing < 0.03 * speed,
        "slip up to {swing} after the ball should roll"
    );
}

/// Rest depth (m g/k)^(2/3): a ball, and an ellipsoid lying on each of its three sides.
#[test]
fn both_versions_rest_depth_on_a_plane() {
    let engine = Engine::from_environment();
    let axes = [1.5e-2, 1e-2, 0.8e-2];
    let poses = [
        ("ball", [RADIUS; 3], IDENTITY, RADIUS),
        ("ellipsoid on its flat side", axes, IDENTITY, axes[2]),
        (
            "ellipsoid on its narrow side",
            axes,
            about([1.0, 0.0, 0.0], std::f64::consts::FRAC_PI_2),
            axes[1],
        ),
    ];
    for (what, semi_axes, quaternion, height) in poses {
        let mut grain = Grain {
            density: DENSITY,
            ..Grain::new(semi_axes, [0.0, 0.0, height]).turned(quaternion)
        };
        let modulus = MODULUS / (2.0 * (1.0 - POISSON * POISSON));
        let flat = ([1e6; 3], IDENTITY);
        let k = hertz_stiffness(modulus, (semi_axes, quaternion), flat, [0.0, 0.0, -1.0]);
        let depth = (grain.mass() * GRAVITY / k).powf(2.0 / 3.0);
        grain.position[2] = height - 0.9 * depth;
        let scene = Scene::open(0.2, vec![grain]);
        let period = 2.0 * std::f64::consts::PI * (2.0 * depth / (3.0 * GRAVITY)).sqrt();
        let law = format!(
            "hertz {MODULUS} {POISSON} damping relaxation {:e}",
            0.2 * period
        );
        let mut deck = deck(&law, period / 200.0, 4000);
        deck.fixes
            .push(format!("fix fall all gravity {GRAVITY} vector 0 0 -1"));
        let outcome = run(&engine, "rest", &scene, &deck, 1);
        let state = &outcome.last().states[0];
        let reached = height - state.position[2];
        println!(
            "rest depth, {what}: {:.10} of the expected {depth:.3e}",
            reached / depth
        );
        assert!((reached / depth - 1.0).abs() < 1e-6, "{what}");
        // up is still up
        assert!(
            (rotate(
                state.quaternion,
                rotate(
                    [
                        quaternion[0],
                        -quaternion[1],
                        -quaternion[2],
                        -quaternion[3]
                    ],
                    [0.0, 0.0, 1.0]
                )
            )[2] - 1.0)
                .abs()
                < 1e-9
        );
    }
}

/// A tilted spinning ellipsoid thrown at the floor keeps its energy, and does not with `conservative no`.
#[test]
fn both_versions_elastic_rebound_of_an_ellipsoid_keeps_its_energy() {
    let engine = Engine::from_environment();
    for aspect in [2.0, 10.0] {
        let axes = [aspect * RADIUS, 1.4 * RADIUS, RADIUS];
        let pose = about([0.3, 1.0, 0.2], 0.4);
        let down = [0.0, 0.0, -1.0];
        let low = surface_point(axes, pose, down);
        let mut grain = Grain {
            density: DENSITY,
            ..Grain::new(axes, [0.0, 0.0, -low[2]]).turned(pose)
        };
        let arm = cross(low, down);
        let turned = unrotate(pose, arm);
        let moments = inertia(grain.mass(), axes);
        let mass = 1.0
            / (1.0 / grain.mass()
                + (0..3)
                    .map(|k| turned[k] * turned[k] / moments[k])
                    .sum::<f64>());
        let k = hertz_stiffness(
            MODULUS / (2.0 * (1.0 - POISSON * POISSON)),
            (axes, pose),
            ([1e6; 3], IDENTITY),
            down,
        );
        let depth = 0.05 * RADIUS;
        let speed = (4.0 * k * depth.powf(2.5) / (5.0 * mass)).sqrt();
        let time = HERTZ_TIME * depth / speed;
        grain.velocity = [0.2 * speed, 0.0, -speed];
        let scene = Scene::open(1.0, vec![grain.clone()]);
        let error = |conservative: &str, steps: f64| {
            let law = format!("hertz {MODULUS} {POISSON} conservative {conservative}");
            let mut times = 1.6;
            loop {
                let outcome = run(
                    &engine,
                    "rebound",
                    &scene,
                    &deck(&law, time / steps, (times * steps) as u64),
                    1,
                );
                if outcome.last().states[0].force == [0.0; 3] {
                    return kinetic_energy(&grain, &outcome.last().states[0])
                        / kinetic_energy(&grain, &outcome.first().states[0])
                        - 1.0;
                }
                times *= 1.5;
                assert!(times < 50.0, "the ellipsoid stays on the floor");
            }
        };
        let (coarse, fine, other) = (
            error("yes", 200.0),
            error("yes", 1000.0),
            error("no", 1000.0),
        );
        println!("aspect {aspect}: energy error {coarse:+.1e} at T/200, {fine:+.1e} at T/1000; conservative no {other:+.1e}");
        assert!(coarse.abs() < 5e-6 && fine.abs() < 5e-7, "aspect {aspect}");
        assert!(other.abs() > 100.0 * fine.abs(), "aspect {aspect}");
    }
}
