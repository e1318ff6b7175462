// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rolling and twisting on a plane against closed forms: a heavy body comes to rest as the mechanics of rigid bodies says.

use crate::support::motion::{Motion, Partner};
use crate::support::scene::{body, laws, wall, Rotation, Vector};
use ellgran::contact::Body;

const GRAVITY: f64 = 10.0;
const MODULUS: f64 = 1e8;

/// A body of mass 1 that lies on the plane z = 0, in equilibrium under its weight.
fn at_rest(semi_axes: [f64; 3], radius: f64) -> Body {
    // F = 4/3 E* sqrt(R) delta^(3/2) F2^(-3/2): near enough, the rest is damped.
    let modulus = MODULUS / (2.0 * (1.0 - 0.09));
    let depth = (GRAVITY / (4.0 / 3.0 * modulus * radius.sqrt())).powf(2.0 / 3.0);
    body(
        semi_axes,
        Vector::new(0.0, 0.0, semi_axes[2] - depth),
        Rotation::identity(),
    )
}

fn moving<'a>(laws: &'a ellgran::contact::Laws, body: Body) -> Motion<'a> {
    let plane = wall(Vector::new(0.0, 0.0, 1.0));
    let mut motion = Motion::new(laws, body, Partner::Wall(plane), 2e-5);
    motion.gravity = Vector::new(0.0, 0.0, -GRAVITY);
    motion
}

/// Rolling without slip, `5/7 mu_roll g`: a sphere, and a spheroid that rolls about its axis. Then it stays where it is.
#[test]
fn a_rolling_body_comes_to_rest() {
    for semi_axes in [[1.0; 3], [1.0, 2.0, 1.0], [1.0, 0.5, 1.0]] {
        let laws = laws(&[&format!(
            "hertz {MODULUS} 0.3 damping relaxation 1e-3 tangential mindlin 0.8 rolling sds 1e6 1e2 0.05"
        )]);
        let mut b = at_rest(semi_axes, 1.0);
        let speed = 0.5;
        b.velocity = [speed, 0.0, 0.0];
        b.angular_velocity = [0.0, speed, 0.0];
        let mut motion = moving(&laws, b);
        let expected = 5.0 / 7.0 * 0.05 * GRAVITY;
        let (mut start, mut end) = ((0.0, 0.0), (0.0, 0.0));
        // The spring of rolling is loaded at first.
        for k in 0..40_000 {
            motion.step();
            let point = (k as f64 * motion.time_step, motion.i.body.velocity[0]);
            if k == 10_000 {
                start = point;
            }
            end = point;
        }
        let found = (start.1 - end.1) / (end.0 - start.0);
        println!("{semi_axes:?}: {found} of {expected}");
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
        for _ in 0..100_000 {
            motion.step();
        }
        let place = motion.i.body.position[0];
        assert!(
            motion.i.body.velocity[0].abs() < 1e-4,
            "{:?}",
            motion.i.body.velocity
        );
        for _ in 0..20_000 {
            motion.step();
        }
        let crept = (motion.i.body.position[0] - place).abs();
        assert!(crept < 1e-5, "{crept:e}");
    }
}

/// On a slope a sphere stays if its tangent is below `mu_roll`, and rolls down with `5/7 g (sin - mu_roll cos)` if it is above.
#[test]
fn a_sphere_on_a_slope_stays_or_rolls() {
    let laws = laws(&[&format!(
        "hertz {MODULUS} 0.3 damping relaxation 1e-3 tangential mindlin 0.8 rolling sds 1e6 1e2 0.1"
    )]);
    for (tangent, rolls) in [(0.08f64, false), (0.15, true)] {
        let angle = tangent.atan();
        let mut motion = moving(&laws, at_rest([1.0; 3], 1.0));
        motion.gravity = Vector::new(angle.sin(), 0.0, -angle.cos()) * GRAVITY;
        for _ in 0..25_000 {
            motion.step();
        }
        let before = motion.i.body.velocity[0];
        for _ in 0..25_000 {
            motion.step();
        }
        let acceleration = (motion.i.body.velocity[0] - before) / (25_000.0 * motion.time_step);
        let expected = if rolls {
            5.0 / 7.0 * GRAVITY * (angle.sin() - 0.1 * angle.cos())
        } else {
            0.0
        };
        println!("tangent {tangent}: {acceleration}, expected {expected}");
        assert!((acceleration - expected).abs() < 1e-3 * GRAVITY);
    }
}

/// About the normal: `mu_twist m g/I`, with `marshall` the mean distance of the points of the contact ellipse times `mu`.
#[test]
fn a_spinning_body_comes_to_rest() {
    for (words, semi_axes) in [
        ("twisting sds 1e3 1 0.01", [1.0; 3]),
        ("twisting marshall", [1.0; 3]),
        ("twisting marshall", [1.0, 2.0, 1.0]),
    ] {
        let laws = laws(&[&format!(
            "hertz {MODULUS} 0.3 damping restitution 0.3 tangential mindlin 0.5 {words}"
        )]);
        let mut b = at_rest(semi_axes, 1.0);
        b.angular_velocity = [0.0, 0.0, 0.2];
        let mut motion = moving(&laws, b);
        for _ in 0..20_000 {
            motion.step();
        }
        let arm = if words.contains("sds") {
            0.01
        } else {
            let felt = motion.felt.as_ref().expect("touching");
            let [a, b] = felt.geometry.contact_semi_axes();
            // Circumference over 3 pi, by its integral.
            let steps = 1000;
            let mean: f64 = (0..steps)
                .map(|k| {
                    let angle = (k as f64 + 0.5) / steps as f64 * std::f64::consts::TAU;
                    2.0 / 3.0 * (a * angle.cos()).hypot(b * angle.sin())
                })
                .sum::<f64>()
                / steps as f64;
            0.5 * mean
        };
        let inertia = (semi_axes[0].powi(2) + semi_axes[1].powi(2)) / 5.0;
        let before = motion.i.body.angular_velocity[2];
        for _ in 0..10_000 {
            motion.step();
        }
        let found = (before - motion.i.body.angular_velocity[2]) / (10_000.0 * motion.time_step);
        let expected = arm * GRAVITY / inertia;
        println!("{words}, {semi_axes:?}: {found} of {expected}");
        assert!((found / expected - 1.0).abs() < 6e-3, "{found} {expected}");
    }
}
