// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rolling and twisting on a plane against closed forms: a heavy body comes to rest as the mechanics of rigid bodies says.

use crate::support::motion::{Motion, Partner};
use crate::support::scene::{body, laws, wall, Rotation, Vector};
use ellgran::contact::Body;
use ellgran::force::hertz_factors::{contact_ellipse, exact};
use ellgran::force::twisting::{mean_radius, squared_semi_axes};
use ellgran::force::{rolling_force, twisting_torque, RollingConstants, TwistSpring};
use ellgran::vector::{Symmetric2, Vector2};

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

/// About the normal: `mu_twist m g/I`, with `marshall` the mean distance of the points of the contact ellipse times `mu`, with `lubkin` that of
/// points that are pressed after Hertz.
#[test]
fn a_spinning_body_comes_to_rest() {
    for (words, semi_axes) in [
        ("twisting sds 1e3 1 0.01", [1.0; 3]),
        ("twisting marshall", [1.0; 3]),
        ("twisting marshall", [1.0, 2.0, 1.0]),
        ("twisting lubkin", [1.0; 3]),
        ("twisting lubkin", [1.0, 2.0, 1.0]),
    ] {
        let springs = words.contains("lubkin");
        let tangential = if springs {
            "tfd 0.5 displacement hysteretic"
        } else {
            "mindlin 0.5"
        };
        let laws = laws(&[&format!(
            "hertz {MODULUS} 0.3 damping restitution 0.3 tangential {tangential} {words}"
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
            let of_pressure = if springs {
                9.0 / 32.0 * std::f64::consts::PI
            } else {
                1.0
            };
            0.5 * of_pressure * mean_radius_by_integral(a, b)
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

/// The matrix that `marshall` reads has the semi-axes of Hertz' theory, whatever the tangent basis.
#[test]
fn the_contact_ellipse_without_eigenvectors_is_that_of_hertz() {
    for ratio in [1.0, 1.3, 4.0, 100.0, 1e4] {
        let (a, b) = (2.0, 2.0 * ratio);
        for angle in [0.0f64, 0.4, 2.0] {
            let (c, s) = (angle.cos(), angle.sin());
            let m = Symmetric2::new(
                a * c * c + b * s * s,
                (a - b) * c * s,
                a * s * s + b * c * c,
            );
            let sigma = exact(m.trace(), m.determinant(), true).sigma;
            let found = squared_semi_axes(1e-3, sigma, m);
            let e = contact_ellipse(ratio);
            let product = 0.5 / (a * b).sqrt() * 1e-3 * e.f1 * e.f1 / e.f2;
            let (major, minor) = (product / e.axis_ratio, product * e.axis_ratio);
            let along = found.uu * c * c + 2.0 * found.uv * c * s + found.vv * s * s;
            for (found, expected) in [
                (found.determinant().sqrt(), product),
                (found.trace(), major + minor),
                (along, major),
            ] {
                let error = (found / expected - 1.0).abs();
                assert!(error < 1e-8, "B/A {ratio}, {angle}: {error:e}");
            }
        }
    }
}

/// The mean distance of an ellipse's points from its centre, against an integral.
#[test]
fn the_mean_radius_of_an_ellipse() {
    for b in [1.0, 0.7, 0.3, 0.05, 0.0] {
        let found = mean_radius(Symmetric2::new(1.0, 0.0, b * b));
        let error = (found / mean_radius_by_integral(1.0, b) - 1.0).abs();
        println!("b/a {b}: {error:.1e}");
        let bound = if b == 1.0 { 1e-12 } else { 5e-4 };
        assert!(error < bound, "{b}: {error:e}");
    }
}

fn mean_radius_by_integral(a: f64, b: f64) -> f64 {
    let steps = 20_000;
    let sum: f64 = (0..steps)
        .map(|k| {
            let angle = (k as f64 + 0.5) / steps as f64 * std::f64::consts::TAU;
            (a * angle.cos()).hypot(b * angle.sin())
        })
        .sum();
    2.0 / 3.0 * sum / steps as f64
}

/// Spring, dashpot and slider of rolling by numbers: the way it holds, its force and its energy, below the limit and above it.
#[test]
fn the_spring_of_rolling() {
    let c = RollingConstants {
        stiffness: 300.0,
        damping: 4.0,
        friction: 0.1,
    };
    let still = Vector2::new(0.0, 0.0);
    let is = |found: Vector2, u: f64, v: f64| {
        (found.u - u).abs().max((found.v - v).abs()) < 1e-14 * (1.0 + u.abs() + v.abs())
    };
    // 300 * (0.03, 0.04) is a force of 15, 0.1 * 200 the limit.
    let (way, by) = (Vector2::new(0.02, 0.01), Vector2::new(0.01, 0.03));
    let t = rolling_force(&c, 200.0, way, by, still, true);
    assert!(
        is(t.force, -9.0, -12.0) && is(t.elastic, -9.0, -12.0),
        "{t:?}"
    );
    assert!(is(t.way, 0.03, 0.04) && (t.energy - 0.375).abs() < 1e-14);
    // The dashpot adds to it: (9, 12) + 4 (0.5, 0) is a force of 16.3.
    let t = rolling_force(&c, 200.0, way, by, Vector2::new(0.5, 0.0), true);
    assert!(
        is(t.force, -11.0, -12.0) && is(t.elastic, -9.0, -12.0),
        "{t:?}"
    );
    // A limit of 5: the spring is cut, and its energy with it; the dashpot adds nothing.
    for velocity in [still, Vector2::new(0.3, 0.4)] {
        let t = rolling_force(&c, 50.0, way, by, velocity, true);
        assert!(
            is(t.force, -3.0, -4.0) && is(t.elastic, -3.0, -4.0),
            "{t:?}"
        );
        assert!(is(t.way, 0.01, 4.0 / 300.0) && (t.energy - 25.0 / 600.0).abs() < 1e-14);
    }
    // Where no time passes nothing of the way is given up, and the force is within the limit.
    let t = rolling_force(&c, 50.0, Vector2::new(0.03, 0.04), still, still, false);
    assert!(is(t.force, -3.0, -4.0) && is(t.way, 0.03, 0.04), "{t:?}");
    assert!((t.energy - 0.375).abs() < 1e-14);
    // Without a spring there is only the dashpot, and nothing to remember.
    let c = RollingConstants {
        stiffness: 0.0,
        ..c
    };
    let t = rolling_force(&c, 200.0, way, by, Vector2::new(0.5, 0.0), true);
    assert!(is(t.force, -2.0, 0.0) && is(t.elastic, 0.0, 0.0), "{t:?}");
    assert!(is(t.way, 0.0, 0.0) && t.energy == 0.0);
    // None at all at a force that draws the bodies together.
    let t = rolling_force(&c, -3.0, still, by, Vector2::new(0.5, 0.0), true);
    assert!(is(t.force, 0.0, 0.0), "{t:?}");
}

/// Spring, dashpot and slider of twisting by numbers: torque, what is remembered and its energy, where the contact stays as it was, shrinks and
/// grows.
#[test]
fn the_spring_of_twisting() {
    let spring = |stiffness: f64| TwistSpring {
        stiffness,
        damping: 3.0,
        friction: 0.1,
    };
    let check = |(stiffness, normal_force): (f64, f64),
                 (held, increment, velocity): ([f64; 2], f64, f64),
                 passes: bool,
                 wanted: [f64; 5]| {
        for sign in [1.0, -1.0] {
            let t = twisting_torque(
                &spring(stiffness),
                normal_force,
                held.map(|x| sign * x),
                sign * increment,
                sign * velocity,
                passes,
            );
            let found = [-t.torque, -t.elastic, t.held[0], t.held[1]].map(|x| sign * x);
            for (found, wanted) in found.iter().chain([&t.energy]).zip(wanted) {
                assert!((found - wanted).abs() < 1e-14, "{t:?}, wanted {wanted}");
            }
        }
    };
    let at_rest = ([4.0, 0.02], 0.01, 0.0);
    // The same contact; one of half the stiffness gives up half; a stiffer one keeps the torque.
    check((200.0, 100.0), at_rest, true, [6.0, 6.0, 6.0, 0.03, 0.09]);
    check((100.0, 100.0), at_rest, true, [3.0, 3.0, 3.0, 0.03, 0.045]);
    check((400.0, 100.0), at_rest, true, [8.0, 8.0, 8.0, 0.02, 0.08]);
    // With the dashpot, up to the limit of 10.
    let turning = |velocity| ([4.0, 0.02], 0.01, velocity);
    check(
        (200.0, 100.0),
        turning(1.0),
        true,
        [9.0, 6.0, 6.0, 0.03, 0.09],
    );
    check(
        (200.0, 100.0),
        turning(5.0),
        true,
        [10.0, 6.0, 6.0, 0.03, 0.09],
    );
    // The spring slides.
    check(
        (200.0, 100.0),
        ([4.0, 0.02], 0.1, 2.0),
        true,
        [10.0, 10.0, 10.0, 0.05, 0.25],
    );
    // Where no time passes all is kept, whatever the stiffness.
    check(
        (100.0, 100.0),
        ([4.0, 0.02], 0.0, 0.0),
        false,
        [4.0, 4.0, 4.0, 0.02, 0.04],
    );
    // Without a spring nothing is remembered; without a load nothing resists.
    check(
        (0.0, 100.0),
        ([0.0; 2], 0.01, 2.0),
        true,
        [6.0, 0.0, 0.0, 0.0, 0.0],
    );
    check((200.0, -1.0), ([0.0; 2], 0.01, 2.0), true, [0.0; 5]);
}
