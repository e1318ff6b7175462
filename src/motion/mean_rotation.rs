// SPDX-License-Identifier: MIT OR Apache-2.0
//! With which angular velocity does a body turn that is seen at two times?

#[cfg(not(feature = "std"))]
use crate::real::Functions;
use crate::vector::Vector3;

/// The steady angular velocity, world frame, that turns a body from one attitude to another within a time > 0, by the shorter way.
/// Quaternions `(w, x, y, z)`, of any length but zero.
///
/// # Example
/// A quarter of a turn about z in 2 s:
/// ```
/// use ellgran::motion::mean_angular_velocity;
///
/// let half = 0.5f64.sqrt();
/// let omega = mean_angular_velocity([1.0, 0.0, 0.0, 0.0], [half, 0.0, 0.0, half], 2.0);
/// assert!((omega.z - core::f64::consts::FRAC_PI_4).abs() < 1e-15 && omega.x == 0.0);
/// ```
pub fn mean_angular_velocity(from: [f64; 4], to: [f64; 4], time: f64) -> Vector3 {
    let [w, x, y, z] = to;
    let back = Vector3::new(-from[1], -from[2], -from[3]);
    let end = Vector3::new(x, y, z);
    // The product of `to` and the conjugate of `from`.
    let real = w * from[0] - end.dot(back);
    let axis = back * w + end * from[0] + end.cross(back);
    // q and -q are the same rotation: the one of at most half a turn.
    let axis = if real < 0.0 { axis * -1.0 } else { axis };
    let sine = axis.norm();
    if sine > 0.0 {
        axis * (2.0 * sine.atan2(real.abs()) / (sine * time))
    } else {
        Vector3::ZERO
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_length_and_the_sign_of_quaternions_are_of_no_account() {
        let (from, to) = ([0.9, 0.1, -0.3, 0.2], [0.5, -0.4, 0.3, 0.7]);
        let expected = mean_angular_velocity(from, to, 0.25);
        let scaled = |q: [f64; 4], by: f64| q.map(|c| by * c);
        let found = mean_angular_velocity(scaled(from, -3.0), scaled(to, 7.0), 0.25);
        assert!((found - expected).norm() < 1e-14 * expected.norm());
        assert!(expected.norm() * 0.25 <= core::f64::consts::PI);
        assert_eq!(mean_angular_velocity(from, from, 1.0), Vector3::ZERO);
        assert_eq!(
            mean_angular_velocity(from, scaled(from, -1.0), 1.0),
            Vector3::ZERO
        );
    }

    /// Against the rotation by a known vector, composed on the left: world frame.
    #[test]
    fn a_rotation_in_the_world_is_found() {
        let (omega, time) = (Vector3::new(0.3, -1.2, 2.1), 0.7);
        let half = 0.5 * time * omega.norm();
        let n = omega * (half.sin() / omega.norm());
        let (w, x, y, z) = (half.cos(), n.x, n.y, n.z);
        let [a, b, c, d] = [0.9f64, 0.1, -0.3, 0.2];
        let to = [
            w * a - x * b - y * c - z * d,
            w * b + x * a + y * d - z * c,
            w * c - x * d + y * a + z * b,
            w * d + x * c - y * b + z * a,
        ];
        let found = mean_angular_velocity([a, b, c, d], to, time);
        assert!((found - omega).norm() < 1e-14, "{found:?}");
    }
}
