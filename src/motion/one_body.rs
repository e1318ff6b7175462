// SPDX-License-Identifier: MIT OR Apache-2.0
//! A step of one body: kicks and free motion, its angular velocity, and what must hold for it to be moved.

use super::bodies::{Bodies, BodyArrays, Refusal, REVERSAL};
use super::free_rotation::{
    body_velocity, half_angles, of_revolution_by_any_angle, of_three_moments, LARGEST_EXPANDED_TURN,
};
use crate::geometry::ellipsoid::{rotation_columns, LARGEST_SEMI_AXIS, LEAST_SEMI_AXIS};
#[cfg(not(feature = "std"))]
use crate::real::Functions;
use crate::real::Real;
use crate::vector::Vector3;

/// Largest angle, radian, by which a body may turn in a step: a contact sees nothing of what is faster.
const LARGEST_TURN: f64 = core::f64::consts::PI;

/// How far the square of a quaternion's length may be from 1 for the quaternion to be taken as it is.
pub(super) const UNIT: f64 = 1e-12;

/// More parts of a step than a turn of [`LARGEST_TURN`] needs.
const MOST_PARTS: usize = 100_000;

/// [`super::finish_step`] of one body. Public for the kernels in `gpu/`; no interface for others.
#[doc(hidden)]
#[inline(always)]
pub fn finish_step_of_body<B: Bodies>(arrays: &mut BodyArrays<'_, B>, k: usize, time_step: f64) {
    if arrays.extrapolation.is_some() {
        kick_from_extrapolated(arrays, k, 0.5 * time_step);
    } else {
        kick(arrays, k, 0.5 * time_step);
    }
}

/// The angular velocity of one body.
pub(super) fn angular_velocity<B: Bodies>(
    arrays: &BodyArrays<'_, B>,
    k: usize,
) -> Result<[f64; 3], Refusal> {
    let (semi_axes, q) = arrays.bodies.shape(k).ok_or(Refusal::Shape)?;
    let square: f64 = q.iter().map(|x| x * x).sum();
    // Those of `start_step` are.
    let q = if (square - 1.0).abs() < UNIT {
        q
    } else {
        normalised(q)?
    };
    let mass = checked_mass(arrays.masses[k])?;
    check_shape(semi_axes)?;
    let axes = rotation_columns(q, 2.0);
    let momentum = Vector3::from_array(arrays.angular_momenta[k]);
    let own = body_velocity(axes, momentum, moments(mass, semi_axes).0);
    Ok((axes[0] * own.x + axes[1] * own.y + axes[2] * own.z).to_array())
}

fn normalised(q: [f64; 4]) -> Result<[f64; 4], Refusal> {
    let length = q.iter().fold(0.0, |sum: f64, x| sum.hypot(*x));
    if length > 0.0 && length.is_finite() {
        Ok(q.map(|x| x / length))
    } else {
        Err(Refusal::Quaternion(length))
    }
}

fn checked_mass(mass: f64) -> Result<f64, Refusal> {
    if mass > 0.0 && mass.is_finite() {
        Ok(mass)
    } else {
        Err(Refusal::Mass(mass))
    }
}

fn check_shape(semi_axes: [f64; 3]) -> Result<(), Refusal> {
    let range = LEAST_SEMI_AXIS..=LARGEST_SEMI_AXIS;
    match semi_axes.into_iter().find(|a| !range.contains(a)) {
        Some(a) => Err(Refusal::SemiAxis(a)),
        None => Ok(()),
    }
}

/// Half a kick of one body.
#[inline(always)]
fn kick<B: Bodies>(arrays: &mut BodyArrays<'_, B>, k: usize, time: f64) {
    let over_mass = time / arrays.masses[k];
    let (v, f) = (&mut arrays.velocities[k], &arrays.forces[k]);
    let (l, t) = (&mut arrays.angular_momenta[k], &arrays.torques[k]);
    for axis in 0..3 {
        v[axis] += over_mass * f[axis];
        l[axis] += time * t[axis];
    }
}

/// Takes the velocities of a body to the end of the step, once it has moved with those of the half step.
#[inline(always)]
fn extrapolate<B: Bodies>(arrays: &mut BodyArrays<'_, B>, k: usize, half: f64) {
    let Some(extrapolation) = &mut arrays.extrapolation else {
        return;
    };
    let (change, before) = (
        &mut extrapolation.changes[k],
        &mut extrapolation.loads_before[k],
    );
    let (v, f) = (&mut arrays.velocities[k], &arrays.forces[k]);
    let (l, t) = (&mut arrays.angular_momenta[k], &arrays.torques[k]);
    let over_mass = half / arrays.masses[k];
    // Not known before: no change of the load.
    let ratio = if before[0] == f64::INFINITY {
        *before = [f[0], f[1], f[2], t[0], t[1], t[2]];
        0.0
    } else {
        extrapolation.step_ratio
    };
    let dot = |a: &[f64], b: &[f64]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let steady = |now: &[f64], before: &[f64], factor: f64| {
        let rounding = REVERSAL * (dot(now, now) + dot(before, before));
        if dot(now, before) < -rounding {
            0.0
        } else {
            factor
        }
    };
    let over_mass = steady(f, &before[..3], over_mass);
    let half = steady(t, &before[3..], half);
    for axis in 0..3 {
        let force = f[axis] + ratio * (f[axis] - before[axis]);
        let torque = t[axis] + ratio * (t[axis] - before[3 + axis]);
        change[axis] = over_mass * force;
        change[3 + axis] = half * torque;
        v[axis] += change[axis];
        l[axis] += change[3 + axis];
        before[axis] = f[axis];
        before[3 + axis] = t[axis];
    }
}

/// Half a kick of one body whose velocities are the extrapolated ones.
#[inline(always)]
fn kick_from_extrapolated<B: Bodies>(arrays: &mut BodyArrays<'_, B>, k: usize, half: f64) {
    let Some(extrapolation) = &mut arrays.extrapolation else {
        return;
    };
    let change = &mut extrapolation.changes[k];
    let over_mass = half / arrays.masses[k];
    let (v, f) = (&mut arrays.velocities[k], &arrays.forces[k]);
    let (l, t) = (&mut arrays.angular_momenta[k], &arrays.torques[k]);
    for axis in 0..3 {
        // What differs is remembered, not the velocity: something else may change that in between.
        change[axis] -= over_mass * f[axis];
        change[3 + axis] -= half * t[axis];
        v[axis] -= change[axis];
        l[axis] -= change[3 + axis];
    }
}

/// Half the kick, and the way of the centre. The shape and attitude, if there is one.
#[inline(always)]
fn move_centre<B: Bodies>(
    arrays: &mut BodyArrays<'_, B>,
    k: usize,
    time_step: f64,
) -> Option<([f64; 3], [f64; 4])> {
    let shape = arrays.bodies.shape(k)?;
    kick(arrays, k, 0.5 * time_step);
    let (x, v) = (&mut arrays.positions[k], &arrays.velocities[k]);
    for axis in 0..3 {
        x[axis] += time_step * v[axis];
    }
    Some(shape)
}

/// [`super::start_step`] of one body. Public for the kernels in `gpu/`; no interface for others.
///
/// # Errors
/// What is wrong with the body.
#[doc(hidden)]
#[inline(always)]
pub fn start_step_of_body<B: Bodies>(
    arrays: &mut BodyArrays<'_, B>,
    k: usize,
    time_step: f64,
) -> Result<(), Refusal> {
    let (semi_axes, q) = move_centre(arrays, k, time_step).ok_or(Refusal::Shape)?;
    let (l, mass) = (arrays.angular_momenta[k], arrays.masses[k]);
    extrapolate(arrays, k, 0.5 * time_step);
    let new = turned(q, Vector3::from_array(l), mass, semi_axes, time_step)?;
    arrays.bodies.turn(k, new);
    Ok(())
}

/// Inverses of the moments of inertia of a solid ellipsoid, and `(I_y - I_z)/I_x` and so on, cyclically.
#[inline(always)]
pub(super) fn moments<T: Real>(mass: T, [a, b, c]: [T; 3]) -> (Vector3<T>, Vector3<T>) {
    let (xx, yy, zz) = (a * a, b * b, c * c);
    let inverse = Vector3::new(
        (yy + zz).reciprocal(),
        (xx + zz).reciprocal(),
        (xx + yy).reciprocal(),
    );
    let ratios = Vector3::new(
        (c - b) * (c + b) * inverse.x,
        (a - c) * (a + c) * inverse.y,
        (b - a) * (b + a) * inverse.z,
    );
    (inverse * (mass.reciprocal() * 5.0), ratios)
}

/// The quaternion of one body at the end of a step in which nothing acts on it.
fn turned(
    q: [f64; 4],
    momentum: Vector3,
    mass: f64,
    semi_axes: [f64; 3],
    time: f64,
) -> Result<[f64; 4], Refusal> {
    let mut q = normalised(q)?;
    let mass = checked_mass(mass)?;
    check_shape(semi_axes)?;
    let (inverse_moments, ratios) = moments(mass, semi_axes);
    let omega_of = |q: [f64; 4]| body_velocity(rotation_columns(q, 2.0), momentum, inverse_moments);
    let turn = omega_of(q).norm() * time;
    if !(turn <= LARGEST_TURN) {
        return Err(Refusal::Turn(turn, time));
    }
    let [a, b, c] = semi_axes;
    if a == b || b == c || a == c {
        let polar = match (a == b, b == c) {
            (true, _) => 2,
            (_, true) => 0,
            _ => 1,
        };
        let mut own_axis = [0.0; 3];
        own_axis[polar] = 1.0;
        let inverse = inverse_moments.to_array();
        let angles = half_angles(
            rotation_columns(q, 2.0)[polar],
            momentum,
            inverse[polar],
            inverse[(polar + 1) % 3],
            time,
        );
        return Ok(of_revolution_by_any_angle(
            q,
            Vector3::from_array(own_axis),
            angles,
        ));
    }
    let mut left = time;
    for _ in 0..MOST_PARTS {
        let omega = omega_of(q);
        let largest = omega.x.abs().max(omega.y.abs()).max(omega.z.abs());
        if largest * left <= LARGEST_EXPANDED_TURN {
            return Ok(of_three_moments(q, omega, ratios, left));
        }
        let part = LARGEST_EXPANDED_TURN / largest;
        q = of_three_moments(q, omega, ratios, part);
        left -= part;
    }
    Err(Refusal::Rotation)
}
