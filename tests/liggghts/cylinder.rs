// SPDX-License-Identifier: MIT OR Apache-2.0
//! Inside a cylinder: force and torque of transverse and oblique needles, against a reference that shares no code with the
//! library: the surface of the ellipsoid is searched for its greatest distances from the axis, curvatures are differences.

use crate::harness::{run, Deck, Engine, Grain, Scene, ELASTIC};
use crate::shapes::{
    about, add, cross, dot, force_factor, length, rotate, scale, sub, unit, unrotate, Quaternion,
    Vector,
};

const RADIUS: f64 = 0.01;

fn point(axes: Vector, turn: Quaternion, centre: Vector, n: Vector) -> Vector {
    let local = unrotate(turn, n);
    let z: Vector = std::array::from_fn(|k| axes[k] * local[k]);
    let h = length(z);
    add(
        centre,
        rotate(turn, std::array::from_fn(|k| axes[k] * z[k] / h)),
    )
}

/// Force and torque on the needle, Hertz along the normal, at every place where the distance from the z axis is a local
/// maximum greater than the radius; with them the sizes of these forces.
fn reference(axes: Vector, turn: Quaternion, centre: Vector) -> (Vector, Vector, Vec<f64>) {
    let direction = |angle: f64| [angle.cos(), angle.sin(), 0.0];
    let reach = |angle: f64| {
        let u = direction(angle);
        dot(u, point(axes, turn, centre, u))
    };
    let count = 20000;
    let step = std::f64::consts::TAU / count as f64;
    let mut total = ([0.0; 3], [0.0; 3], vec![]);
    for k in 0..count {
        let angle = k as f64 * step;
        if !(reach(angle) > reach(angle - step) && reach(angle) >= reach(angle + step)) {
            continue;
        }
        // golden section
        let (mut low, mut high) = (angle - step, angle + step);
        let ratio = 0.5 * (5f64.sqrt() - 1.0);
        while high - low > 1e-9 {
            let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
            if reach(a) > reach(b) {
                high = b;
            } else {
                low = a;
            }
        }
        let angle = 0.5 * (low + high);
        let delta = reach(angle) - RADIUS;
        if delta <= 0.0 {
            continue;
        }
        let n = direction(angle);
        let t = [-n[1], n[0], 0.0];
        let z = [0.0, 0.0, 1.0];
        // radii of curvature: how far the surface point moves as the normal turns
        let eps = 1e-5;
        let moved = |e: Vector| {
            let plus = point(axes, turn, centre, unit(add(n, scale(eps, e))));
            let minus = point(axes, turn, centre, unit(sub(n, scale(eps, e))));
            let d = scale(0.5 / eps, sub(plus, minus));
            [dot(d, t), dot(d, z)]
        };
        let ([a, b], [_, d]) = (moved(t), moved(z));
        let determinant = a * d - b * b;
        let m = [
            0.5 * (d / determinant - 1.0 / RADIUS),
            -0.5 * b / determinant,
            0.5 * a / determinant,
        ];
        let mean = 0.5 * (m[0] + m[2]);
        let spread = (0.25 * (m[0] - m[2]).powi(2) + m[1] * m[1]).sqrt();
        let (small, large) = (mean - spread, mean + spread);
        let modulus = ELASTIC[0] / (2.0 * (1.0 - ELASTIC[1] * ELASTIC[1]));
        let size = 4.0 / 3.0
            * modulus
            * (0.5 / (small * large).sqrt()).sqrt()
            * force_factor(large / small)
            * delta.powf(1.5);
        let force = scale(-size, n);
        let arm = sub(point(axes, turn, centre, n), centre);
        total.0 = add(total.0, force);
        total.1 = add(total.1, cross(arm, force));
        total.2.push(size);
    }
    total
}

#[test]
fn needles_inside_a_cylinder_feel_every_tip() {
    let engine = Engine::from_environment();
    let needle = [0.01002, 1e-3, 1e-3];
    let short = [4e-3, 1e-3, 1.5e-3];
    let cases: [(&str, Vector, Quaternion, Vector); 6] = [
        ("transverse", needle, about([0.0, 0.0, 1.0], 0.3), [0.0; 3]),
        (
            "transverse, beside the axis",
            [0.009, 1e-3, 1e-3],
            about([0.0, 0.0, 1.0], 0.0),
            [0.0, 0.0045, 0.002],
        ),
        (
            "transverse, one tip",
            needle,
            about([0.0, 0.0, 1.0], 1.0),
            [1e-4, 0.0, 0.0],
        ),
        (
            "oblique",
            [0.02, 1e-3, 2e-3],
            about([0.0, 1.0, 0.0], 1.04731),
            [0.0, 0.0, 0.0],
        ),
        (
            "oblique, aside",
            short,
            about([0.4, 1.0, 0.3], 0.6),
            [0.0, 0.00882, 0.0],
        ),
        (
            "along",
            short,
            about([0.0, 1.0, 0.0], std::f64::consts::FRAC_PI_2),
            [0.0, 0.00901, 0.0],
        ),
    ];
    for (name, axes, turn, centre) in cases {
        let grain = Grain {
            density: 2500.0,
            ..Grain::new(axes, centre).turned(turn)
        };
        let deck = Deck {
            time_step: 1e-12,
            settings: "conservative off".into(),
            walls: vec![format!("primitive type 1 zcylinder {RADIUS} 0.0 0.0")],
            ..Deck::new(ELASTIC, 0.0)
        };
        let outcome = run(&engine, name, &Scene::open(0.1, vec![grain]), &deck, 1);
        let state = &outcome.last().states[0];
        let (force, torque, sizes) = reference(axes, turn, centre);
        assert!(!sizes.is_empty(), "{name}: the reference has no contact");
        // opposite tips cancel: their forces apart are the measure
        let measure: f64 = sizes.iter().sum();
        let (f, t) = (
            length(sub(state.force, force)) / measure,
            length(sub(state.torque, torque)) / (measure * axes[0]),
        );
        println!("{name}: forces {sizes:?} N; difference {f:.1e}, torque {t:.1e}");
        assert!(f < 1e-5 && t < 1e-5, "{name}");
    }
}

/// From without: a sphere, for which Hertz' law with the curvatures of the two is known in closed form.
#[test]
fn a_sphere_beside_a_cylinder_is_pushed_as_hertz_says() {
    let engine = Engine::from_environment();
    let (radius, depth) = (3e-3, 1e-5);
    for across in [2e-3, RADIUS] {
        let away: Vector = [0.6, 0.8, 0.0];
        let position = add(scale(across + radius - depth, away), [0.0, 0.0, 0.001]);
        let deck = Deck {
            time_step: 1e-12,
            walls: vec![format!("primitive type 1 zcylinder {across} 0.0 0.0")],
            ..Deck::new(ELASTIC, 0.0)
        };
        let scene = Scene::open(0.1, vec![Grain::sphere(radius, position)]);
        let outcome = run(&engine, &format!("{across}"), &scene, &deck, 1);
        let (small, large) = (0.5 / radius, 0.5 / radius + 0.5 / across);
        let modulus = ELASTIC[0] / (2.0 * (1.0 - ELASTIC[1] * ELASTIC[1]));
        let size = 4.0 / 3.0
            * modulus
            * (0.5 / (small * large).sqrt()).sqrt()
            * force_factor(large / small)
            * depth.powf(1.5);
        let error = length(sub(outcome.last().states[0].force, scale(size, away))) / size;
        println!("cylinder of radius {across} m: force {size:.6} N, off by {error:.1e}");
        // the reference's factor is good to 1e-6
        assert!(error < 1e-6);
    }
}
