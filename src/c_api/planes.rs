// SPDX-License-Identifier: MIT OR Apache-2.0
//! Plane walls against all owned particles in one call.

use super::growing::{given, growing, GivenArray};
use super::law::{check_type, EllgranLaws};
use super::particles::{
    hale_failure, history_failure, identifier, prepare, EllgranParticles, EllgranStep,
    EllgranWorkspace, Purpose,
};
use super::status::{
    at_border, required, required_mut, slice, slice_mut, Failure, ELLGRAN_ERROR_ARGUMENT,
};
use super::tallies::{add_preceding_half_step, borrow, Asked, EllgranTallies};
use crate::contact::ranges::{self, LARGEST_COORDINATE, LARGEST_VELOCITY};
use crate::geometry::Plane;
use crate::message::Numbers;
use crate::vector::Vector3;
use crate::walls::{compute_planes, MovingPlane};
use crate::walls::{PlanesError, WallArrays};

/// A plane wall: a half-space.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranPlane {
    /// `sizeof(EllgranPlane)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// A point of its surface; components up to 1e20.
    pub point: [f64; 3],
    /// Normal out of the wall, towards the particles. Need not have unit length, but not zero length.
    pub normal: [f64; 3],
    /// Velocity; components up to 1e25.
    pub velocity: [f64; 3],
}

growing!(EllgranPlane);

impl EllgranPlane {
    pub(super) fn to_core(self) -> Result<MovingPlane, Failure> {
        let fail = |what| Failure::new(ELLGRAN_ERROR_ARGUMENT, what);
        let normal = Vector3::from_array(self.normal)
            .direction()
            .ok_or_else(|| {
                fail(format!(
                    "plane: normal = {} must be finite and not zero",
                    Numbers(&self.normal)
                ))
            })?;
        Ok(MovingPlane {
            plane: Plane {
                point: ranges::vector(self.point, LARGEST_COORDINATE, "plane: point")
                    .map_err(fail)?,
                normal,
            },
            velocity: ranges::vector(self.velocity, LARGEST_VELOCITY, "plane: velocity")
                .map_err(fail)?,
        })
    }
}

/// Forces and torques between all owned particles and plane walls, added to the particles' arrays.
///
/// A contact has the law of the particle's type and `wall_type`. `masks` ([owned_count], or NULL for all particles) and
/// `group_mask` select the particles with `masks[i] & group_mask` != 0. `touching` is [owned_count][wall_count] and
/// `history` [owned_count][wall_count][history length] (both NULL if the history length is 0): set them to 0 before a
/// particle's first call, and carry them along with the particle when its index changes. The force on each wall is added to
/// `wall_forces`, [wall_count][3] or NULL.
///
/// All particles are checked first; on failure nothing is written.
///
/// # Safety
/// The pointers are as stated here and in `EllgranParticles` and `EllgranTallies`; `tallies` may be NULL.
#[no_mangle]
#[allow(clippy::too_many_arguments)]
pub unsafe extern "C" fn ellgran_compute_planes(
    laws: *const EllgranLaws,
    workspace: *mut EllgranWorkspace,
    particles: *const EllgranParticles,
    masks: *const i32,
    group_mask: i32,
    wall_type: i32,
    wall_count: usize,
    planes: *const EllgranPlane,
    touching: *mut i32,
    history: *mut f64,
    step: *const EllgranStep,
    wall_forces: *mut f64,
    tallies: *mut EllgranTallies,
) -> i32 {
    at_border("ellgran_compute_planes", || {
        // SAFETY: promised by the caller, for all of this function.
        let laws = &unsafe { required(laws, "laws") }?.laws;
        // SAFETY: `workspace` is NULL or valid for reads and writes, and not aliased, by this function's safety
        // section.
        let EllgranWorkspace {
            workspace,
            planes: walls,
            ..
        } = unsafe { required_mut(workspace, "workspace") }?;
        // SAFETY: `particles` is NULL or valid for reads, by this function's safety section.
        let p = &*unsafe { given(particles, "particles") }?;
        // SAFETY: `step` is NULL or valid for reads, by this function's safety section.
        let step = unsafe { given(step, "step") }?.to_core()?;
        let wall_type = check_type(laws, wall_type, "wall_type")?;
        walls.clear();
        // SAFETY: `planes` is NULL or valid for reads of `wall_count` structs, by this function's safety section.
        let planes = unsafe { GivenArray::new(planes, wall_count, "planes") }?;
        for k in 0..wall_count {
            walls.push(planes.get(k)?.to_core()?);
        }
        let owned = p.owned_count;
        let length = laws.layout().length;
        let slots = if length == 0 { 0 } else { owned * wall_count };
        let mask = if masks.is_null() {
            None
        } else {
            // SAFETY: `masks` is NULL or valid for reads of `owned` elements, by this function's safety section.
            Some(unsafe { slice(masks, owned, "masks") }?)
        };
        let acts_on = |k: usize| mask.is_none_or(|m| m[k] & group_mask != 0);
        let mut arrays = WallArrays {
            acts_on: &acts_on,
            // SAFETY: `touching` is NULL or valid for reads and writes of `slots` elements, and not aliased, by this
            // function's safety section.
            touching: unsafe { slice_mut(touching, slots, "touching") }?,
            // SAFETY: `history` is NULL or valid for reads and writes of `slots * length` elements, and not aliased,
            // by this function's safety section.
            history: unsafe { slice_mut(history, slots * length, "history") }?,
            // SAFETY: `forces` is NULL or valid for reads and writes of `owned` elements, and not aliased, as
            // `EllgranParticles` demands.
            forces: unsafe { slice_mut(p.forces.cast::<[f64; 3]>(), owned, "forces") }?,
            // SAFETY: `torques` is NULL or valid for reads and writes of `owned` elements, and not aliased, as
            // `EllgranParticles` demands.
            torques: unsafe { slice_mut(p.torques.cast::<[f64; 3]>(), owned, "torques") }?,
            wall_forces: if wall_forces.is_null() {
                &mut []
            } else {
                // SAFETY: `wall_forces` is NULL or valid for reads and writes of `wall_count` elements, and not
                // aliased, by this function's safety section.
                unsafe { slice_mut(wall_forces.cast::<[f64; 3]>(), wall_count, "wall_forces") }?
            },
        };
        // SAFETY: `tallies` and the arrays that it names are valid as `EllgranTallies` demands, by this function's
        // safety section.
        let mut asked = unsafe { Asked::new(tallies) }?;
        let mut sums = match &asked {
            // SAFETY: the arrays of `tallies` have an element for each particle, as `EllgranTallies` demands; they
            // are borrowed once.
            Some(asked) => Some(unsafe { borrow(&asked.given, owned) }?),
            None => None,
        };
        // SAFETY: the arrays of `particles` are NULL or as long as its counts say, as `EllgranParticles` demands.
        unsafe { prepare(p, owned, Some(laws), workspace, Purpose::SingleContacts) }?;
        compute_planes(
            laws,
            workspace.particles(),
            wall_type,
            walls,
            &mut arrays,
            &step,
            sums.as_mut(),
        )
        .map_err(|e| match e {
            PlanesError::Hale { i, ratio } => hale_failure(identifier(p, i), None, ratio),
            PlanesError::History { i, place, value } => {
                history_failure(identifier(p, i), None, place, value)
            }
        })?;
        if let (Some(asked), Some(mut sums)) = (&mut asked, sums) {
            // SAFETY: promised by the caller.
            unsafe { add_preceding_half_step(&mut sums, p, owned, &step) }?;
            asked.write(&sums);
        }
        Ok(())
    })
}
