// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where does a rigid body that nothing acts on turn to within a time?
//!
//! The angular momentum in the world frame is constant, so the quaternion alone is sought: `q' = q w / 2` with the angular
//! velocity `w` in body axes.
//!
//! - A sphere turns about its angular momentum.
//! - A body of revolution precesses about its angular momentum `L` with `|L|/I_e` (`I_e` the moment about an equatorial axis)
//!   and spins about its own axis `e` with `(L.e)(1/I_p - 1/I_e)`; the two rotations follow each other in either order.
//! - For three different moments Euler's equations and that of the quaternion are expanded in powers of the time. Where
//!   `m` is the largest component of the angular velocity, the coefficients of `w_k` are at most `m^(n+1)`, since
//!   `y' = y^2` majorises Euler's equations: no difference of two moments exceeds the third. Those of the quaternion are at most
//!   `m^n` then. What order `n` leaves out is less than `(m t)^(n+1)/(1 - m t)`.

#[cfg(not(feature = "std"))]
use crate::real::Functions;
use crate::real::Real;
use crate::vector::Vector3;

/// Order of the expansion for three different moments.
const ORDER: usize = 7;

/// Largest component of the angular velocity, times the time, at which the expansion leaves out less than 7e-20, which ten million
/// steps may add up.
pub(super) const LARGEST_EXPANDED_TURN: f64 = 4e-3;

/// Largest half of the angle, for one of the two rotations of a body of revolution, at which [`rotation`] is exact to rounding.
pub(super) const LARGEST_HALF_ANGLE: f64 = 0.125;

/// Quaternion `(w, x, y, z)`.
pub(super) type Quaternion<T> = [T; 4];

/// The product `p q`: the rotation `q`, then `p`.
#[inline(always)]
fn product<T: Real>(p: Quaternion<T>, q: Quaternion<T>) -> Quaternion<T> {
    [
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3],
        p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1],
    ]
}

/// `q` with a change that leaves its length as it is but for rounding, brought to length 1 from a length that differs from it by rounding.
///
/// All is added at once, so that each component is rounded once: a factor that is 1 but for rounding rounds components up or down by
/// what they are, and a body turned so drifts by 1e-19 a step.
#[inline(always)]
fn changed<T: Real>(q: Quaternion<T>, change: Quaternion<T>) -> Quaternion<T> {
    let one = q[0].constant(1.0);
    let excess = q[3].multiply_add(
        q[3],
        q[2].multiply_add(q[2], q[1].multiply_add(q[1], q[0].multiply_add(q[0], -one))),
    );
    let half = excess * -0.5;
    [
        q[0] + half.multiply_add(q[0], change[0]),
        q[1] + half.multiply_add(q[1], change[1]),
        q[2] + half.multiply_add(q[2], change[2]),
        q[3] + half.multiply_add(q[3], change[3]),
    ]
}

/// The sum of two.
#[inline(always)]
fn sum<T: Real>(p: Quaternion<T>, q: Quaternion<T>) -> Quaternion<T> {
    [p[0] + q[0], p[1] + q[1], p[2] + q[2], p[3] + q[3]]
}

/// What the rotation whose axis and half angle (at most [`LARGEST_HALF_ANGLE`]) are direction and length of `h` is more than 1.
#[inline(always)]
fn rotation_less_one<T: Real>(h: Vector3<T>) -> Quaternion<T> {
    // The power that is left out is below 1e-19.
    const COSINE: [f64; 5] = [
        -1.0 / 2.0,
        1.0 / 24.0,
        -1.0 / 720.0,
        1.0 / 40_320.0,
        -1.0 / 3_628_800.0,
    ];
    const SINE: [f64; 6] = [
        1.0,
        -1.0 / 6.0,
        1.0 / 120.0,
        -1.0 / 5040.0,
        1.0 / 362_880.0,
        -1.0 / 39_916_800.0,
    ];
    let square = h.norm_squared();
    let (mut cosine, mut sine) = (square.constant(COSINE[4]), square.constant(SINE[5]));
    sine = sine.multiply_add(square, square.constant(SINE[4]));
    let mut k = 4;
    while k > 0 {
        k -= 1;
        cosine = cosine.multiply_add(square, square.constant(COSINE[k]));
        sine = sine.multiply_add(square, square.constant(SINE[k]));
    }
    [cosine * square, h.x * sine, h.y * sine, h.z * sine]
}

/// The same for any half angle.
fn rotation_by_any_angle_less_one(h: Vector3<f64>) -> Quaternion<f64> {
    let angle = h.norm();
    if angle <= LARGEST_HALF_ANGLE {
        return rotation_less_one(h);
    }
    let scale = angle.sin() / angle;
    [angle.cos() - 1.0, h.x * scale, h.y * scale, h.z * scale]
}

/// Half angles of the two rotations of a body of revolution: about the angular momentum, world frame, and about its own axis.
#[inline(always)]
pub(super) fn half_angles<T: Real>(
    axis: Vector3<T>,
    momentum: Vector3<T>,
    inverse_polar: T,
    inverse_equatorial: T,
    time: f64,
) -> (Vector3<T>, T) {
    (
        momentum * (inverse_equatorial * (0.5 * time)),
        axis.dot(momentum) * (inverse_polar - inverse_equatorial) * (0.5 * time),
    )
}

/// A sphere, by half an angle about its angular momentum.
#[inline(always)]
pub(super) fn of_a_sphere<T: Real>(q: Quaternion<T>, precession: Vector3<T>) -> Quaternion<T> {
    changed(q, product(rotation_less_one(precession), q))
}

/// `(1 + world) q (1 + own)`.
#[inline(always)]
fn by_both<T: Real>(q: Quaternion<T>, world: Quaternion<T>, own: Quaternion<T>) -> Quaternion<T> {
    let precessed = product(world, q);
    let spun = product(sum(q, precessed), own);
    changed(q, sum(precessed, spun))
}

/// A body of revolution, or a sphere: `own_axis` is the unit vector of its axis in body axes.
#[inline(always)]
pub(super) fn of_revolution<T: Real>(
    q: Quaternion<T>,
    own_axis: Vector3<T>,
    (precession, spin): (Vector3<T>, T),
) -> Quaternion<T> {
    by_both(
        q,
        rotation_less_one(precession),
        rotation_less_one(own_axis * spin),
    )
}

/// The same for any angle.
pub(super) fn of_revolution_by_any_angle(
    q: Quaternion<f64>,
    own_axis: Vector3<f64>,
    (precession, spin): (Vector3<f64>, f64),
) -> Quaternion<f64> {
    by_both(
        q,
        rotation_by_any_angle_less_one(precession),
        rotation_by_any_angle_less_one(own_axis * spin),
    )
}

/// Three different moments of inertia, within a time in which no component of the angular velocity in body axes, `omega`, turns
/// the body by more than [`LARGEST_EXPANDED_TURN`]. `ratios` are `(I_y - I_z)/I_x` and so on, cyclically.
#[inline(always)]
pub(super) fn of_three_moments<T: Real>(
    q: Quaternion<T>,
    omega: Vector3<T>,
    ratios: Vector3<T>,
    time: f64,
) -> Quaternion<T> {
    let first = omega * omega.x.constant(time);
    let zero = first.x.constant(0.0);
    let none = Vector3::new(zero, zero, zero);
    // Coefficients of the powers of the time, which is 1 now.
    let mut turn = [none; ORDER];
    let mut scalar = [zero; ORDER + 1];
    let mut vector = [none; ORDER + 1];
    turn[0] = first;
    scalar[0] = zero.constant(1.0);
    let mut k = 0;
    while k < ORDER {
        let (mut s, mut v) = (zero, none);
        let mut j = 0;
        while j <= k {
            let w = turn[k - j];
            s = s + vector[j].dot(w);
            v = v + vector[j].cross(w) + w * scalar[j];
            j += 1;
        }
        let factor = 0.5 / (k + 1) as f64;
        scalar[k + 1] = -(s * factor);
        vector[k + 1] = v * zero.constant(factor);
        if k + 1 < ORDER {
            let mut rate = none;
            let mut j = 0;
            while j <= k {
                let (a, b) = (turn[j], turn[k - j]);
                rate = Vector3::new(
                    a.y.multiply_add(b.z, rate.x),
                    a.z.multiply_add(b.x, rate.y),
                    a.x.multiply_add(b.y, rate.z),
                );
                j += 1;
            }
            turn[k + 1] = rate.componentwise(ratios) * zero.constant(1.0 / (k + 1) as f64);
        }
        k += 1;
    }
    // The small terms first.
    let (mut s, mut v) = (zero, none);
    let mut k = ORDER;
    while k > 0 {
        s = s + scalar[k];
        v = v + vector[k];
        k -= 1;
    }
    // `q (1 + r)`
    changed(q, product(q, [s, v.x, v.y, v.z]))
}

/// The angular velocity in body axes, of an angular momentum in the world frame.
#[inline(always)]
pub(super) fn body_velocity<T: Real>(
    axes: [Vector3<T>; 3],
    momentum: Vector3<T>,
    inverse_moments: Vector3<T>,
) -> Vector3<T> {
    Vector3::new(
        axes[0].dot(momentum),
        axes[1].dot(momentum),
        axes[2].dot(momentum),
    )
    .componentwise(inverse_moments)
}
