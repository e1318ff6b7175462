// SPDX-License-Identifier: MIT OR Apache-2.0
//! Volume and moments of inertia of solid ellipsoids.

use super::status::{at_border, slice, slice_mut, Failure, ELLGRAN_ERROR_PARTICLE};
use crate::contact::particle::describe;
use crate::geometry::Ellipsoid;

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
        for (k, own) in moments.iter_mut().enumerate() {
            let solid = solid(k, semi_axes[k])?;
            *own = solid.moments_of_inertia(masses[k]).to_array();
        }
        Ok(())
    })
}
