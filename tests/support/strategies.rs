// SPDX-License-Identifier: MIT OR Apache-2.0
//! Random rotations, shapes and touching pairs for property tests.

use super::scene::{body, Rotation, Vector};
use ellgran::contact::Body;
use nalgebra::{Matrix3, Matrix3x2};
use proptest::prelude::*;

/// A unit vector, uniform.
pub fn direction() -> impl Strategy<Value = Vector> {
    (-1.0..1.0f64, 0.0..std::f64::consts::TAU).prop_map(|(z, angle)| {
        let r = (1.0 - z * z).sqrt();
        Vector::new(r * angle.cos(), r * angle.sin(), z)
    })
}

/// A rotation: uniform axis, uniform angle.
pub fn turn() -> impl Strategy<Value = Rotation> {
    (direction(), 0.0..std::f64::consts::TAU).prop_map(|(axis, angle)| {
        Rotation::from_axis_angle(&nalgebra::Unit::new_normalize(axis), angle)
    })
}

/// A vector with components up to `most`.
pub fn vector(most: f64) -> impl Strategy<Value = Vector> {
    prop::array::uniform3(-most..most).prop_map(Vector::from)
}

/// Semi-axes, log-uniform between `1/aspect` and 1.
pub fn semi_axes(aspect: f64) -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-(aspect.ln())..=0.0).prop_map(|l| l.map(f64::exp))
}

/// Two ellipsoids that touch.
#[derive(Clone, Debug)]
pub struct TouchingPair {
    pub i: Body,
    pub j: Body,
    /// The common normal by construction, from `i` to `j`.
    pub normal: Vector,
    /// The penetration by construction.
    pub penetration: f64,
    /// The smallest combined radius of curvature there, or half the combined thickness along the normal where that is
    /// less: up to about this depth no other normal is nearer.
    pub radius: f64,
}

impl TouchingPair {
    /// Body `j` is put where the two have `normal` in common and overlap by `depth` times `radius`.
    pub fn new(
        shapes: [[f64; 3]; 2],
        turns: [Rotation; 2],
        normal: Vector,
        depth: f64,
    ) -> TouchingPair {
        let witness = |k: usize| {
            let r = *turns[k].to_rotation_matrix().matrix();
            let a = Vector::from(shapes[k]);
            let z = a.component_mul(&r.tr_mul(&normal));
            let h = z.norm();
            let s = r * a.component_mul(&z) / h;
            let matrix = r * Matrix3::from_diagonal(&a.component_mul(&a)) * r.transpose();
            // Of the chord from the witness along the inward normal.
            let half = 1.0 / (h * r.tr_mul(&normal).component_div(&a).norm_squared());
            (s, (matrix - s * s.transpose()) / h, half)
        };
        let ((si, hi, half_i), (sj, hj, half_j)) = (witness(0), witness(1));
        let u = if normal.x.abs() < 0.6 {
            Vector::x()
        } else {
            Vector::y()
        };
        let u = (u - normal * normal.dot(&u)).normalize();
        let t = Matrix3x2::from_columns(&[u, normal.cross(&u)]);
        let radii = t.transpose() * (hi + hj) * t;
        let radius = radii.symmetric_eigenvalues().min().min(half_i + half_j);
        let penetration = depth * radius;
        TouchingPair {
            i: body(shapes[0], Vector::zeros(), turns[0]),
            j: body(shapes[1], si + sj - normal * penetration, turns[1]),
            normal,
            penetration,
            radius,
        }
    }
}

/// Touching pairs of aspect ratio up to `aspect`, `depth` (a range, log-uniform) times their `radius` deep, with random velocities up to 1 and spins up to 1.
pub fn touching_pair(
    aspect: f64,
    depth: std::ops::Range<f64>,
) -> impl Strategy<Value = TouchingPair> {
    (
        prop::array::uniform2(semi_axes(aspect)),
        prop::array::uniform2(turn()),
        direction(),
        depth.start.ln()..depth.end.ln(),
        prop::array::uniform4(vector(1.0)),
        prop::array::uniform2(0.1..10.0f64),
    )
        .prop_map(|(shapes, turns, normal, depth, motion, masses)| {
            let mut pair = TouchingPair::new(shapes, turns, normal, depth.exp());
            for (k, b) in [&mut pair.i, &mut pair.j].into_iter().enumerate() {
                b.velocity = motion[2 * k].into();
                b.angular_velocity = motion[2 * k + 1].into();
                b.mass = masses[k];
                b.identifier = k as i64 + 1;
            }
            pair
        })
}

/// The laws whose tangential and viscous parts are all there: words of a deck.
pub fn deck() -> impl Strategy<Value = &'static str> {
    prop::sample::select(vec![
        "hertz 1e5 0.3",
        "hertz 1e5 0.3 conservative no",
        "hertz 1e5 0.3 tangential tfd 0.3",
        "hertz 1e5 0.1 damping restitution 0.8 tangential tfd 0.5 displacement rescaled",
        "hertz 1e5 0.3 damping restitution 0.6 tangential mindlin 0.4",
        "hertz 1e5 0.2 damping relaxation 1e-3 tangential tfd 0.5",
        "nfd 1e5 0.3 30 50 tangential tfd 0.3",
        "nfd 1e5 0.3 30 50 tangential tfd 0.3 displacement incremental unloading first_order",
        "hertz 1e5 0.3 tangential tfd 0.3 displacement hysteretic",
        "nfd 1e5 0.3 30 500 viscosity memory tangential tfd 0.4 displacement hysteretic rolling sds 1e3 0.5 0.1",
        "nfd 1e5 0.4 30 50 closure surface tangential mindlin 0.3 displacement total",
        "nfd 1e5 0.4 30 50 closure brilliantov tangential tfd 0.3 displacement rescaled",
        "lsd 1e3 3 tangential linear 800 2 0.3",
        "nfd 1e5 0.3 30 500 viscosity memory tangential tfd 0.3",
        "nfd 1e5 0.1 0 50 viscosity memory conservative no",
        "hertz 1e5 0.3 rolling sds 1e3 0.5 0.1 twisting sds 10 0.01 0.05",
        "hertz 1e5 0.3 damping relaxation 1e-3 tangential tfd 0.3 rolling sds 1e3 0.5 0.1 twisting marshall",
        "lsd 1e3 3 tangential linear 800 2 0.3 rolling sds 1e3 0 0.1 twisting marshall",
        "nfd 1e5 0.3 30 50 tangential tfd 0.3 displacement hysteretic rolling sds 1e3 0.5 0.1 twisting lubkin",
    ])
}
