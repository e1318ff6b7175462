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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;
    use crate::geometry::Ellipsoid;
    use crate::vector::Vector3;

    fn difference(p: [f64; 4], q: [f64; 4]) -> f64 {
        let parts = core::array::from_fn(|k| (q[k] - p[k]) * (q[k] - p[k]));
        let parts: [f64; 4] = parts;
        parts.iter().sum()
    }

    #[test]
    fn the_way_and_the_change_of_the_quaternion() {
        let (x, y) = ([1.0, -2.0, 0.5], [1.5, 1.0, -1.5]);
        let (p, q) = ([0.1, 0.2, -0.3, 0.4], [0.2, -0.2, 0.5, 1.6]);
        let (way, turn) = way_and_turn(x, y, p, q);
        assert!((way - (0.25 + 9.0 + 4.0)).abs() < 1e-14);
        assert!((turn - (0.01 + 0.16 + 0.64 + 1.44)).abs() < 1e-14);
        assert!((allowed_way(0.4).sqrt() - 0.1).abs() < 1e-15);
    }

    /// A body turns by as much as is allowed: its support function changes by no more than a quarter of the margin in any direction, and by
    /// nearly as much where it turns about the axis across the longest and the shortest one.
    #[test]
    fn a_turn_that_is_allowed_keeps_to_its_quarter_of_the_margin() {
        let mut random = Random::new(3);
        for k in 0..200 {
            let semi_axes = [0; 3].map(|_| random.of_any_size(0.1, 1.0));
            let size = random.of_any_size(0.1, 10.0);
            let q = random.quaternion().map(|c| c * size);
            let margin = random.of_any_size(1e-4, 1e-2);
            let per_margin = allowed_turn_per_margin(semi_axes, q);
            let allowed = allowed_turn(per_margin, margin * margin, &q);
            let before = Ellipsoid::new(semi_axes, q).unwrap();
            let order = |a: &usize, b: &usize| semi_axes[*a].total_cmp(&semi_axes[*b]);
            let longest = (0..3).max_by(order).unwrap();
            let shortest = (0..3).min_by(order).unwrap();
            let [long, short] = [longest, shortest].map(|m| before.axes[m]);
            let axis = if k % 2 == 0 {
                long.cross(short)
            } else {
                random.direction()
            };
            // The quaternion of the whole turn, and by bisection the part of it that changes this one by as much.
            let turned = |angle: f64| {
                let (sin, cos) = (0.5 * angle).sin_cos();
                let [w, x, y, z] = q;
                let v = Vector3::new(x, y, z);
                let vector = v * cos + axis * (w * sin) + axis.cross(v) * sin;
                let [x, y, z] = vector.to_array();
                [w * cos - sin * axis.dot(v), x, y, z]
            };
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if difference(q, turned(middle)) < allowed {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            let after = Ellipsoid::new(semi_axes, turned(low)).unwrap();
            let change = |n: Vector3| (after.support(n).h - before.support(n).h).abs();
            let most = if k % 2 == 0 {
                (0..200)
                    .map(|m| (0.005 * f64::from(m) * core::f64::consts::PI).sin_cos())
                    .map(|(sin, cos)| change(long * cos + short * sin))
                    .fold(0.0, f64::max)
            } else {
                (0..100)
                    .map(|_| change(random.direction()))
                    .fold(0.0, f64::max)
            };
            assert!(most < 0.25 * margin, "{semi_axes:?} {q:?} {margin}");
            assert!(k % 2 == 1 || most > 0.92 * 0.25 * margin, "{most} {margin}");
        }
    }

    #[test]
    fn bounds_of_a_turn() {
        let q = [1.5, -2.0, 0.5, 3.0];
        let square = 15.5;
        // A sphere, and quaternions without a square.
        assert_eq!(allowed_turn_per_margin([2.0; 3], q), f64::INFINITY);
        assert_eq!(allowed_turn(f64::INFINITY, 1e-8, &q), f64::INFINITY);
        for size in [1e-105, 1e101] {
            let q = q.map(|c| c * size);
            let per_margin = allowed_turn_per_margin([1.0, 2.0, 3.0], q);
            assert_eq!(per_margin, -1.0);
            assert!(allowed_turn(per_margin, 1.0, &q) < 0.0);
        }
        // With any margin no more than by one radian: 2 sin(1/4) of the length.
        let per_margin = allowed_turn_per_margin([1.0, 1.1, 1.2], q);
        let most = allowed_turn(per_margin, 1e6, &q);
        assert!((most / (0.2 * square) - 1.0).abs() < 1e-14);
        assert!(most < square * (2.0 * 0.25f64.sin()).powi(2));
    }
}
