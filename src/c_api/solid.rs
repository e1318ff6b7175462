// SPDX-License-Identifier: MIT OR Apache-2.0
//! Volume, moments of inertia and rotation of solid ellipsoids.

use super::contact::EllgranBody;
use super::growing::given;
use super::status::{
    at_border, required, required_mut, slice, slice_mut, Failure, ELLGRAN_ERROR_ARGUMENT,
    ELLGRAN_ERROR_PARTICLE, ELLGRAN_ERROR_RESULT,
};
use crate::contact::particle::{angular_momentum, describe};
use crate::contact::ranges;
use crate::geometry::Ellipsoid;
use crate::message::Numbers;
use crate::motion::mean_angular_velocity;

const UNTURNED: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

fn solid(k: usize, semi_axes: [f64; 3]) -> Result<Ellipsoid, Failure> {
    Ellipsoid::new(semi_axes, UNTURNED).map_err(|error| {
        let what = describe(error, semi_axes, UNTURNED);
        Failure::new(ELLGRAN_ERROR_PARTICLE, format!("ellipsoid {k}: {what}"))
    })
}

/// Before anything is written, without allocating.
fn check(semi_axes: &[[f64; 3]]) -> Result<(), Failure> {
    for (k, a) in semi_axes.iter().enumerate() {
        solid(k, *a)?;
    }
    Ok(())
}

/// Volumes of ellipsoids. `semi_axes` is [count][3], with the ranges of `EllgranBody`; `volumes` is [count].
///
/// # Safety
/// The pointers are NULL or have these lengths.
#[no_mangle]
pub unsafe extern "C" fn ellgran_volumes(
    count: usize,
    semi_axes: *const f64,
    volumes: *mut f64,
) -> i32 {
    at_border("ellgran_volumes", || {
        // SAFETY: promised by the caller, for all of this function.
        let semi_axes = unsafe { slice(semi_axes.cast::<[f64; 3]>(), count, "semi_axes") }?;
        // SAFETY: `volumes` is NULL or has `count` entries, by this function's safety section.
        let volumes = unsafe { slice_mut(volumes, count, "volumes") }?;
        check(semi_axes)?;
        for (k, volume) in volumes.iter_mut().enumerate() {
            *volume = solid(k, semi_axes[k])?.volume();
        }
        Ok(())
    })
}

/// Principal moments of inertia of solid ellipsoids about their body axes, mass x length^2. `semi_axes` is [count][3], with the
/// ranges of `EllgranBody`, `masses` [count], INFINITY for a fixed body; `moments` is [count][3].
///
/// # Safety
/// The pointers are NULL or have these lengths.
#[no_mangle]
pub unsafe extern "C" fn ellgran_moments_of_inertia(
    count: usize,
    semi_axes: *const f64,
    masses: *const f64,
    moments: *mut f64,
) -> i32 {
    at_border("ellgran_moments_of_inertia", || {
        // SAFETY: promised by the caller, for all of this function.
        let semi_axes = unsafe { slice(semi_axes.cast::<[f64; 3]>(), count, "semi_axes") }?;
        // SAFETY: `masses` is NULL or has `count` entries, by this function's safety section.
        let masses = unsafe { slice(masses, count, "masses") }?;
        // SAFETY: `moments` is NULL or has `count` times three entries, by this function's safety section.
        let moments = unsafe { slice_mut(moments.cast::<[f64; 3]>(), count, "moments") }?;
        check(semi_axes)?;
        for (k, mass) in masses.iter().enumerate() {
            ranges::inverse_mass(*mass, "mass").map_err(|what| {
                Failure::new(ELLGRAN_ERROR_PARTICLE, format!("ellipsoid {k}: {what}"))
            })?;
        }
        for (k, own) in moments.iter_mut().enumerate() {
            let solid = solid(k, semi_axes[k])?;
            *own = solid.moments_of_inertia(masses[k]).to_array();
        }
        Ok(())
    })
}

/// Angular momentum of a solid ellipsoid with `angular_velocity`, 3 doubles each, both in the world frame. Semi-axes, quaternion and
/// mass, which must be finite, are those of `body`; its own angular velocity is not used.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_angular_momentum(
    body: *const EllgranBody,
    angular_velocity: *const f64,
    angular_momentum: *mut f64,
) -> i32 {
    at_border("ellgran_angular_momentum", || {
        // Any type is right.
        // SAFETY: promised by the caller, for all of this function.
        let body = unsafe { given(body, "body") }?;
        let solid = body.to_core(Some(usize::MAX))?;
        let omega = angular_velocity.cast::<[f64; 3]>();
        // SAFETY: `angular_velocity` is NULL or has three doubles, by this function's safety section.
        let omega = unsafe { required(omega, "angular_velocity") }?;
        // SAFETY: `angular_momentum` is NULL or has three doubles, by this function's safety section.
        let found =
            unsafe { required_mut(angular_momentum.cast::<[f64; 3]>(), "angular_momentum") }?;
        let omega = ranges::angular_velocity(*omega)
            .map_err(|what| Failure::new(ELLGRAN_ERROR_ARGUMENT, what))?;
        if body.mass == f64::INFINITY {
            return Err(Failure::new(
                ELLGRAN_ERROR_PARTICLE,
                format!(
                    "particle {}: mass = inf: a fixed body has no angular momentum",
                    body.identifier
                ),
            ));
        }
        *found = self::angular_momentum(&solid.body, body.mass, omega).to_array();
        Ok(())
    })
}

/// The steady angular velocity, world frame, that turns a body from one quaternion (w, x, y, z) to another within `time` > 0, by the
/// shorter way: `from` and `to` are 4 doubles each, of any length but zero, `angular_velocity` 3 doubles.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_mean_angular_velocity(
    from: *const f64,
    to: *const f64,
    time: f64,
    angular_velocity: *mut f64,
) -> i32 {
    at_border("ellgran_mean_angular_velocity", || {
        // SAFETY: promised by the caller, for all of this function.
        let from = unsafe { required(from.cast::<[f64; 4]>(), "from") }?;
        // SAFETY: `to` is NULL or has four doubles, by this function's safety section.
        let to = unsafe { required(to.cast::<[f64; 4]>(), "to") }?;
        // SAFETY: `angular_velocity` is NULL or has three doubles, by this function's safety section.
        let found =
            unsafe { required_mut(angular_velocity.cast::<[f64; 3]>(), "angular_velocity") }?;
        let invalid = |what: String| Err(Failure::new(ELLGRAN_ERROR_ARGUMENT, what));
        for (name, quaternion) in [("from", from), ("to", to)] {
            let largest = quaternion.iter().fold(0.0f64, |m, c| m.max(c.abs()));
            if !(largest > 0.0 && quaternion.iter().all(|c| c.is_finite())) {
                let numbers = Numbers(quaternion);
                return invalid(format!(
                    "{name} = {numbers} must be a quaternion of finite length, not zero"
                ));
            }
        }
        if !(time > 0.0 && time.is_finite()) {
            return invalid(format!(
                "time = {time} must be a finite number greater than 0"
            ));
        }
        // Products of other lengths leave double precision; those of these stay bit for bit.
        let scaled = |q: &[f64; 4]| {
            if (1e-100..=1e100).contains(&q.iter().map(|c| c * c).sum::<f64>()) {
                return *q;
            }
            let largest = q.iter().fold(0.0f64, |m, c| m.max(c.abs()));
            q.map(|c| c / largest)
        };
        let omega = mean_angular_velocity(scaled(from), scaled(to), time).to_array();
        if !omega.iter().all(|c| c.is_finite()) {
            return Err(Failure::new(
                ELLGRAN_ERROR_RESULT,
                format!("time = {time} is too short: the angular velocity is out of the range of double precision"),
            ));
        }
        *found = omega;
        Ok(())
    })
}
