// SPDX-License-Identifier: MIT OR Apache-2.0
//! Gaps and elastic energies of many pairs in one call, for overlap checks, insertion and Monte Carlo moves.

use super::growing::given;
use super::law::EllgranLaws;
use super::particles::{
    hale_failure, identifier, prepare, EllgranParticles, EllgranWorkspace, Purpose,
};
use super::status::{
    at_border, required, required_mut, slice, slice_mut, Failure, ELLGRAN_ERROR_ARGUMENT,
};
use crate::contact::without_history::{elastic_energy, gap};
use crate::contact::Laws;
use crate::contact::Particle;
use crate::list::Workspace;

/// Prepares all particles and reads the pairs, checked.
///
/// # Safety
/// The arrays of `particles` are as [`EllgranParticles`] states; `pairs` is NULL or has `count` entries, for the lifetime
/// that the caller gives it.
pub(super) unsafe fn checked<'a>(
    laws: Option<&Laws>,
    workspace: &'a mut Workspace,
    particles: &EllgranParticles,
    count: usize,
    pairs: *const i32,
) -> Result<(&'a [Particle], &'a [[i32; 2]]), Failure> {
    // SAFETY: promised by the caller, for all of this function.
    let pairs = unsafe { slice(pairs.cast::<[i32; 2]>(), count, "pairs") }?;
    // SAFETY: the arrays of `particles` are NULL or as long as its counts say, as `EllgranParticles` demands.
    unsafe {
        prepare(
            particles,
            particles.count,
            laws,
            workspace,
            Purpose::SingleContacts,
        )
    }?;
    let known = |k: &i32| usize::try_from(*k).is_ok_and(|k| k < particles.count);
    for (number, pair) in pairs.iter().enumerate() {
        if let Some(wrong) = pair.iter().find(|k| !known(k)) {
            return Err(Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!(
                    "pairs[{number}] names particle {wrong}, which is not one of {}",
                    particles.count
                ),
            ));
        }
        if pair[0] == pair[1] {
            return Err(Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!("pairs[{number}] names particle {} twice", pair[0]),
            ));
        }
    }
    Ok((workspace.particles(), pairs))
}

/// Gaps of pairs of particles: minus the penetration where they overlap. `pairs` is [pair_count][2], indices from 0; `gaps`
/// is [pair_count]; `normals`, [pair_count][3] or NULL, receives the unit normals from the first to the second particle
/// along which the gaps are measured. No law and no history are needed. Forces, torques, masses and types are not read;
/// velocities are checked and not used.
///
/// # Safety
/// The pointers are as stated here and in `EllgranParticles`.
#[no_mangle]
pub unsafe extern "C" fn ellgran_pair_gaps(
    workspace: *mut EllgranWorkspace,
    particles: *const EllgranParticles,
    pair_count: usize,
    pairs: *const i32,
    gaps: *mut f64,
    normals: *mut f64,
) -> i32 {
    at_border("ellgran_pair_gaps", || {
        // SAFETY: promised by the caller, for all of this function.
        let workspace = &mut unsafe { required_mut(workspace, "workspace") }?.workspace;
        // SAFETY: `particles` is NULL or valid for reads, by this function's safety section.
        let p = unsafe { given(particles, "particles") }?;
        // SAFETY: `gaps` is NULL or valid for reads and writes of `pair_count` elements, and not aliased, by this
        // function's safety section.
        let gaps = unsafe { slice_mut(gaps, pair_count, "gaps") }?;
        let mut normals = if normals.is_null() {
            None
        } else {
            // SAFETY: `normals` is NULL or valid for reads and writes of `pair_count` elements, and not aliased, by
            // this function's safety section.
            Some(unsafe { slice_mut(normals.cast::<[f64; 3]>(), pair_count, "normals") }?)
        };
        // SAFETY: the arrays of `particles` and `pairs` are NULL or as long as their counts say, by this function's
        // safety section.
        let (all, pairs) = unsafe { checked(None, workspace, &p, pair_count, pairs) }?;
        for (k, [i, j]) in pairs.iter().enumerate() {
            let (gap, normal) = gap(&all[*i as usize], &all[*j as usize]);
            gaps[k] = gap;
            if let Some(normals) = normals.as_deref_mut() {
                normals[k] = normal.to_array();
            }
        }
        Ok(())
    })
}

/// Elastic energies of the normal deformation of pairs of particles, 0 where they do not touch. `pairs` is [pair_count][2],
/// indices from 0; `energies` is [pair_count]. The energy of tangential displacements is not included, and no history is
/// needed. Forces and torques are not read; velocities are checked and not used. On failure nothing is written, except
/// where `factors hale` is not defined at a contact: then the energies before it have been written.
///
/// # Safety
/// The pointers are as stated here and in `EllgranParticles`.
#[no_mangle]
pub unsafe extern "C" fn ellgran_pair_energies(
    laws: *const EllgranLaws,
    workspace: *mut EllgranWorkspace,
    particles: *const EllgranParticles,
    pair_count: usize,
    pairs: *const i32,
    energies: *mut f64,
) -> i32 {
    at_border("ellgran_pair_energies", || {
        // SAFETY: promised by the caller, for all of this function.
        let laws = &unsafe { required(laws, "laws") }?.laws;
        // SAFETY: `workspace` is NULL or valid for reads and writes, and not aliased, by this function's safety
        // section.
        let workspace = &mut unsafe { required_mut(workspace, "workspace") }?.workspace;
        // SAFETY: `particles` is NULL or valid for reads, by this function's safety section.
        let p = unsafe { given(particles, "particles") }?;
        // SAFETY: `energies` is NULL or valid for reads and writes of `pair_count` elements, and not aliased, by this
        // function's safety section.
        let energies = unsafe { slice_mut(energies, pair_count, "energies") }?;
        // SAFETY: the arrays of `particles` and `pairs` are NULL or as long as their counts say, by this function's
        // safety section.
        let (all, pairs) = unsafe { checked(Some(laws), workspace, &p, pair_count, pairs) }?;
        for (energy, [i, j]) in energies.iter_mut().zip(pairs) {
            let (i, j) = (*i as usize, *j as usize);
            *energy = elastic_energy(laws, &all[i], &all[j])
                .map_err(|e| hale_failure(identifier(&p, i), Some(identifier(&p, j)), e.0))?;
        }
        Ok(())
    })
}
