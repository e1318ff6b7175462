// SPDX-License-Identifier: MIT OR Apache-2.0
//! Motions so small that a body's support function changes by no more than a given length: what is known of a pair's gap holds on.

use crate::real::Real;

/// Squares of the way of the centre from `x` to `y`, and of the change of the quaternion from `p` to `q`.
#[inline(always)]
pub fn way_and_turn<T: Real>(x: [T; 3], y: [T; 3], p: [T; 4], q: [T; 4]) -> (T, T) {
    let (dx, dy, dz) = (y[0] - x[0], y[1] - x[1], y[2] - x[2]);
    let (d0, d1, d2, d3) = (q[0] - p[0], q[1] - p[1], q[2] - p[2], q[3] - p[3]);
    (
        dx * dx + dy * dy + dz * dz,
        d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3,
    )
}

/// Square of the way by which a body may move where its share of a `margin` is half of it: the other half of that share is for its
/// rotation.
#[inline(always)]
pub fn allowed_way(margin: f64) -> f64 {
    margin * margin * (1.0 / 16.0)
}

/// Square of the change of a quaternion, over the square of the margin, by which the support function of the body changes by a quarter of
/// the margin at most. Infinite for a sphere, negative where the quaternion is too short or too long for the change to have a square.
#[inline(always)]
pub fn allowed_turn_per_margin(a: [f64; 3], q: [f64; 4]) -> f64 {
    // The support function of a body that turns by an angle changes by at most the angle times this.
    let spread = a[0].max(a[1]).max(a[2]) - a[0].min(a[1]).min(a[2]);
    // A rotation by an angle t changes a quaternion of length L by 2 L sin(t/4): t <= 2.1 |change|/L up to t = 1.
    let length = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if spread == 0.0 {
        f64::INFINITY
    } else if (1e-200..1e200).contains(&length) {
        let quarter = 4.0 * 2.1 * spread;
        length / (quarter * quarter)
    } else {
        -1.0
    }
}

/// The same for a margin, which is given by its square: at most a rotation by one radian. A sphere may turn as it likes.
#[inline(always)]
pub fn allowed_turn(per_margin: f64, margin_squared: f64, q: &[f64]) -> f64 {
    if !per_margin.is_finite() {
        return f64::INFINITY;
    }
    let length = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    (per_margin * margin_squared).min(length * 0.2)
}
