// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the recorded contacts of each particle add up to: coordination, fabric and stress.

use super::growing::given;
use super::particles::{EllgranParticles, EllgranWorkspace};
use super::rigid_wall::EllgranWall;
use super::status::{at_border, required, slice, slice_mut, Failure, ELLGRAN_ERROR_ARGUMENT};
use crate::tallies::GrainSums;
use crate::vector::Vector3;

/// Doubles that `ellgran_add_recorded_to_grain_sums` and `ellgran_add_wall_recorded_to_grain_sums` keep of each particle: the number of
/// particles that it touches; the number of its contacts with walls; the sum of n (x) n over all of them, n the unit normal (xx yy zz xy
/// xz yz); and the sum of l (x) F over all of them, its symmetric part, l from the centre of the particle to the contact and F the
/// force on the particle (xx yy zz xy xz yz), negative under pressure. The last is the mean stress in the particle times a volume.
pub const ELLGRAN_GRAIN_SUMS_LENGTH: usize = 14;

const _: () = assert!(ELLGRAN_GRAIN_SUMS_LENGTH * size_of::<f64>() == size_of::<GrainSums>());

fn beyond(index: usize, count: usize) -> Failure {
    Failure::new(
        ELLGRAN_ERROR_ARGUMENT,
        format!(
            "count = {count}: there is a recorded contact of particle {index}: give the particles of the call that recorded it"
        ),
    )
}

/// Adds the contacts that `ellgran_compute_pairs` recorded last with this workspace (`record_contacts` of the list) to the sums of their
/// particles. `particles` are those of that call, of which positions are read.
///
/// `newton` is that of the list. With 1 the sums of ghosts are written too, and the caller adds them to those of their owners; with 0
/// another rank, or another image, lists the same contact, and nothing is added to ghosts.
///
/// # Safety
/// The pointers are NULL or valid; `sums` is [count][`ELLGRAN_GRAIN_SUMS_LENGTH`], added to.
#[no_mangle]
pub unsafe extern "C" fn ellgran_add_recorded_to_grain_sums(
    workspace: *const EllgranWorkspace,
    particles: *const EllgranParticles,
    newton: i32,
    sums: *mut f64,
) -> i32 {
    at_border("ellgran_add_recorded_to_grain_sums", || {
        // SAFETY: promised by the caller, for all of this function.
        let contacts = &unsafe { required(workspace, "workspace") }?
            .workspace
            .contacts;
        // SAFETY: `particles` is NULL or valid for reads, by this function's safety section.
        let p = &*unsafe { given(particles, "particles") }?;
        // SAFETY: `positions` is NULL or has 3 numbers for each of `count` particles, as `EllgranParticles` demands.
        let positions = unsafe { slice(p.positions.cast::<[f64; 3]>(), p.count, "positions") }?;
        // SAFETY: `sums` is NULL or valid for reads and writes of `ELLGRAN_GRAIN_SUMS_LENGTH` numbers for each of `count` particles, and
        // not aliased, by this function's safety section; `GrainSums` is as many numbers and nothing else.
        let sums = unsafe { slice_mut(sums.cast::<GrainSums>(), p.count, "sums") }?;
        let indices = contacts.as_slice().iter().flat_map(|c| [c.i, c.j]);
        if let Some(index) = indices.max().filter(|index| *index >= p.count) {
            return Err(beyond(index, p.count));
        }
        contacts.add_to_grain_sums(
            |k| Vector3::from_array(positions[k]),
            |k| newton != 0 || k < p.owned_count,
            sums,
        );
        Ok(())
    })
}

/// Adds the contacts that `ellgran_compute_wall` recorded last (`ellgran_wall_record_contacts`) to the sums of their particles. A particle
/// that touches a wall in several places has as many contacts.
///
/// # Safety
/// The pointers are NULL or valid; `sums` is [owned_count][`ELLGRAN_GRAIN_SUMS_LENGTH`], added to, of the particles of that call.
#[no_mangle]
pub unsafe extern "C" fn ellgran_add_wall_recorded_to_grain_sums(
    wall: *const EllgranWall,
    owned_count: usize,
    sums: *mut f64,
) -> i32 {
    at_border("ellgran_add_wall_recorded_to_grain_sums", || {
        // SAFETY: promised by the caller, for all of this function.
        let wall = &unsafe { required(wall, "wall") }?.wall;
        // SAFETY: `sums` is NULL or valid for reads and writes of `ELLGRAN_GRAIN_SUMS_LENGTH` numbers for each of `owned_count` particles,
        // and not aliased, by this function's safety section; `GrainSums` is as many numbers and nothing else.
        let sums = unsafe { slice_mut(sums.cast::<GrainSums>(), owned_count, "sums") }?;
        let indices = wall.contacts().iter().map(|c| c.particle);
        if let Some(index) = indices.max().filter(|index| *index >= owned_count) {
            return Err(beyond(index, owned_count));
        }
        wall.add_to_grain_sums(sums);
        Ok(())
    })
}
