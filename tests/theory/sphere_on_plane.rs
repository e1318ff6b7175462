// SPDX-License-Identifier: MIT OR Apache-2.0
//! A solid sphere on a plane (section 6), stepped as an engine steps it: gross slip, sliding to rolling, rest.

use crate::support::motion::{Motion, Partner};
use crate::support::scene::{body, laws, wall, Rotation, Vector};
use ellgran::contact::{Body, Laws};

const MASS: f64 = 2.0;
const RADIUS: f64 = 0.5;
const NU: f64 = 0.3;

/// A sphere that has just touched the plane z = 0, with this velocity.
fn sphere(velocity: [f64; 3]) -> Body {
    let mut b = body(
        [RADIUS; 3],
        Vector::new(0.0, 0.0, RADIUS),
        Rotation::identity(),
    );
    b.mass = MASS;
    b.velocity = velocity;
    b
}

/// Impact at normal speed 1 and tangential speed `slide`; tangential velocity of the contact point and spin after it.
fn impact(laws: &Laws, slide: f64, steps: f64) -> (f64, f64) {
    let k = stiffness(STIFF);
    let contact_time = 3.2180654597190431 * (MASS * MASS / (k * k)).powf(0.2);
    let dt = contact_time / steps;
    let mut start = sphere([slide, 0.0, -1.0]);
    start.position[2] += 0.4 * dt;
    let mut motion = Motion::new(laws, start, Partner::Wall(wall(Vector::z())), dt);
    assert!(motion.collide(4 * steps as usize));
    let b = motion.i.body;
    let spin = b.angular_velocity[1];
    (b.velocity[0] - spin * RADIUS, spin)
}

/// `k` in `F = k delta^(3/2)`; the wall is of the sphere's material.
fn stiffness(youngs_modulus: f64) -> f64 {
    let effective = youngs_modulus / (2.0 * (1.0 - NU * NU));
    4.0 / 3.0 * effective * RADIUS.sqrt()
}

/// Stiff for the impacts: the closed forms neglect the penetration beside the radius.
const STIFF: f64 = 1e16;

const MU: f64 = 0.2;

fn kappa() -> f64 {
    (2.0 - NU) / (2.0 * (1.0 - NU))
}

fn sliding_laws(tangential: &str) -> Laws {
    laws(&[&format!(
        "hertz {STIFF:e} {NU} tangential {tangential} {MU} displacement incremental"
    )])
}

#[test]
fn gross_slip_loses_7_mu_v_n_and_spins_5_mu_v_n_over_r() {
    for tangential in ["mindlin", "tfd"] {
        let laws = sliding_laws(tangential);
        for over in [0.2, 3.0] {
            let slide = MU * (7.0 - kappa() + over);
            let mut last = f64::INFINITY;
            for steps in [500.0, 2000.0] {
                let (after, spin) = impact(&laws, slide, steps);
                let error = (after - (slide - 7.0 * MU))
                    .abs()
                    .max((spin * RADIUS / (5.0 * MU) - 1.0).abs());
                println!("{tangential}, {over} above the limit, {steps} steps: off by {error:.1e}");
                assert!(error < last);
                last = error;
            }
            assert!(last < 1e-5, "{tangential}: {last}");
        }
    }
}

#[test]
fn below_7_minus_kappa_it_sticks_at_the_end() {
    let laws = sliding_laws("mindlin");
    let slide = MU * (7.0 - kappa() - 1.0);
    let (after, _) = impact(&laws, slide, 2000.0);
    // Slower than gross slip would have left it, backwards.
    assert!((after - (slide - 7.0 * MU)).abs() > 1e-2 * MU, "{after}");
}

#[test]
fn rest_depth_is_m_g_over_k_to_the_2_thirds() {
    let damped = laws(&[&format!("hertz 1e7 {NU} damping restitution 0.1")]);
    let g = 9.81;
    let wanted = (MASS * g / stiffness(1e7)).powf(2.0 / 3.0);
    let mut start = sphere([0.0; 3]);
    start.position[2] -= 0.8 * wanted;
    // Period of small oscillations about rest.
    let period = std::f64::consts::TAU * (MASS / (1.5 * stiffness(1e7) * wanted.sqrt())).sqrt();
    let mut motion = Motion::new(
        &damped,
        start,
        Partner::Wall(wall(Vector::z())),
        period / 60.0,
    );
    motion.gravity = Vector::new(0.0, 0.0, -g);
    for _ in 0..3000 {
        motion.step();
    }
    let depth = motion.felt.expect("it lies there").geometry.penetration;
    assert!((depth / wanted - 1.0).abs() < 1e-9, "{depth} {wanted}");
}

#[test]
fn sliding_becomes_rolling_at_5_sevenths_after_2_v_over_7_mu_g() {
    for tangential in ["mindlin", "tfd"] {
        let laws = laws(&[&format!(
            "hertz 1e6 {NU} damping restitution 0.3 tangential {tangential} {MU}"
        )]);
        let (g, v) = (10.0, 1.0);
        let k = stiffness(1e6);
        let depth = (MASS * g / k).powf(2.0 / 3.0);
        let mut start = sphere([v, 0.0, 0.0]);
        start.position[2] -= depth;
        let period = std::f64::consts::TAU * (MASS / (1.5 * k * depth.sqrt())).sqrt();
        let dt = period / 60.0;
        let mut motion = Motion::new(&laws, start, Partner::Wall(wall(Vector::z())), dt);
        motion.gravity = Vector::new(0.0, 0.0, -g);
        let wanted = 2.0 * v / (7.0 * MU * g);
        let slip = |m: &Motion| m.i.body.velocity[0] - RADIUS * m.i.body.angular_velocity[1];
        let mut time = 0.0;
        while slip(&motion) > 0.0 && time < 2.0 * wanted {
            motion.step();
            time += dt;
        }
        println!(
            "{tangential}: rolls at {time:.5} (theory {wanted:.5}) with {:.5}",
            motion.i.body.velocity[0]
        );
        // The elastic displacement and the lever arm R - delta are what remains.
        let slack = 3.0 * depth / RADIUS + 3.0 * period / wanted;
        assert!(
            (time / wanted - 1.0).abs() < slack,
            "{time} {wanted} {slack}"
        );
        for _ in 0..((wanted / dt) as usize) {
            motion.step();
        }
        let speed = motion.i.body.velocity[0];
        assert!((speed / (5.0 / 7.0 * v) - 1.0).abs() < slack, "{speed}");
    }
}
