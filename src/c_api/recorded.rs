// SPDX-License-Identifier: MIT OR Apache-2.0
//! The touching pairs of a neighbour list one by one, as the last call computed them.

use super::contact::{force_of, EllgranContactForce, EllgranContactGeometry};
use super::growing::{growing, Output};
use super::particles::EllgranWorkspace;
use super::status::{at_border, required, required_mut, Failure, ELLGRAN_ERROR_ARGUMENT};

/// Place of a recorded contact in the neighbour list.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranContactPlace {
    /// `sizeof(EllgranContactPlace)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// Index of the central particle: body i of geometry and force.
    pub i: i32,
    /// Index of its neighbour, without the bits above `index_mask`.
    pub j: i32,
    /// Place of the neighbour in the row of the central particle.
    pub entry: usize,
}

growing!(EllgranContactPlace);

/// Number of contacts that the last call of `ellgran_compute_pairs` with this workspace recorded: all touching pairs of the
/// list if its `record_contacts` was 1. 0 otherwise, after a call that failed, and for NULL.
///
/// # Safety
/// `workspace` is NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_recorded_count(workspace: *const EllgranWorkspace) -> usize {
    // SAFETY: promised by the caller.
    unsafe { workspace.as_ref() }.map_or(0, |w| w.workspace.contacts.as_slice().len())
}

/// A recorded contact, by its number from 0: its place in the list, its geometry, and the force that acted. Each of the
/// three may be NULL. Contacts are sorted by the index of the central particle, then by their place in its row, on every
/// instruction set.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_recorded_contact(
    workspace: *const EllgranWorkspace,
    number: usize,
    place: *mut EllgranContactPlace,
    geometry: *mut EllgranContactGeometry,
    force: *mut EllgranContactForce,
) -> i32 {
    at_border("ellgran_recorded_contact", || {
        // SAFETY: promised by the caller, for all of this function.
        let workspace = &unsafe { required(workspace, "workspace") }?.workspace;
        // SAFETY: `place` is NULL or valid for reads and writes, and not aliased, by this function's safety section.
        let place = unsafe { Output::optional(place, "place") }?;
        // SAFETY: `geometry` is NULL or valid for reads and writes, and not aliased, by this function's safety
        // section.
        let geometry = unsafe { Output::optional(geometry, "geometry") }?;
        // SAFETY: `force` is NULL or valid for reads and writes, and not aliased, by this function's safety section.
        let force = unsafe { Output::optional(force, "force") }?;
        let all = workspace.contacts.as_slice();
        let record = all.get(number).ok_or_else(|| {
            Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!(
                    "number = {number} is not one of {} recorded contacts",
                    all.len()
                ),
            )
        })?;
        if let Some(mut place) = place {
            place.write(&EllgranContactPlace {
                size: size_of::<EllgranContactPlace>(),
                // Indices came as i32.
                i: record.i as i32,
                j: record.j as i32,
                entry: record.entry,
            });
        }
        if let Some(mut geometry) = geometry {
            geometry.write(&EllgranContactGeometry::from(&record.geometry));
        }
        if let Some(mut force) = force {
            let of_ellipse = record.elliptical.then_some(&record.geometry);
            force.write(&force_of(of_ellipse, &record.forces));
        }
        Ok(())
    })
}

/// The number of the recorded contact of two particles, given in either order; -1 if they do not touch or nothing was
/// recorded. The time of a call grows with the logarithm of the number of contacts.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_recorded_find(
    workspace: *const EllgranWorkspace,
    i: i32,
    j: i32,
    number: *mut i64,
) -> i32 {
    at_border("ellgran_recorded_find", || {
        // SAFETY: promised by the caller, for all of this function.
        let workspace = &unsafe { required(workspace, "workspace") }?.workspace;
        // SAFETY: `number` is NULL or valid for reads and writes, and not aliased, by this function's safety section.
        let out = unsafe { required_mut(number, "number") }?;
        let found = match (usize::try_from(i), usize::try_from(j)) {
            (Ok(i), Ok(j)) => workspace.contacts.find(i, j),
            _ => None,
        };
        *out = found.map_or(-1, |at| at as i64);
        Ok(())
    })
}
