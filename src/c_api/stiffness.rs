// SPDX-License-Identifier: MIT OR Apache-2.0
//! Stiffness of a contact, its largest stable time step, how long a collision lasts and a wave through a grain.

use super::contact::EllgranBody;
use super::growing::{given, growing, Output};
use super::law::{EllgranLawParameters, EllgranLaws};
use super::particles::hale_failure;
use super::status::{at_border, required, required_mut, Failure, ELLGRAN_ERROR_ARGUMENT};
use crate::contact::stability::{
    collision, contact_stiffness, rayleigh_time, two_grain_limits, ContactStiffness,
};

/// Springs and dashpots that are equivalent to a contact for small motions about its present state. Where the bodies do not
/// touch, all are zero and the critical step is INFINITY.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranContactStiffness {
    /// `sizeof(EllgranContactStiffness)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// Derivative of the normal force by the penetration, force/length.
    pub normal_stiffness: f64,
    /// Stiffness of the tangential spring along the major and the minor semi-axis of the contact ellipse, before any slip,
    /// force/length.
    pub tangential_stiffness: [f64; 2],
    /// Coefficient of the normal dashpot while the bodies approach, force x time/length.
    pub normal_damping: f64,
    /// Coefficient of the tangential dashpot along the major and the minor semi-axis, before any slip, force x time/length.
    pub tangential_damping: [f64; 2],
    /// The largest time step at which velocity Verlet is stable for this contact alone, rotations and damping included;
    /// INFINITY for two fixed bodies.
    pub critical_step: f64,
}

growing!(EllgranContactStiffness);

/// Stiffness of the contact of two ellipsoids at their present penetration, and its largest stable time step. Masses are those
/// of the bodies, moments of inertia those of solid ellipsoids; velocities are not read.
///
/// With `K` and `C` stiffness and damping in the frame of the contact and `A` the acceleration of the contact points
/// relative to one another by a unit force, `sum 1/m + [r]x^T I^-1 [r]x`, the critical step is where the largest eigenvalue
/// of `A (dt^2 K + 2 dt C)` is 4; without damping `2/sqrt(lambda(A K))`. The stiffness that comes from the rotation of the
/// normal is left out; it is smaller than `K` by the ratio of penetration to radius of curvature. `ellgran_stable_step` has the
/// step of particles with many contacts. The stiffness grows with the penetration: evaluate it at the largest one that you
/// expect.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_contact_stiffness(
    laws: *const EllgranLaws,
    i: *const EllgranBody,
    j: *const EllgranBody,
    stiffness: *mut EllgranContactStiffness,
) -> i32 {
    at_border("ellgran_contact_stiffness", || {
        // SAFETY: promised by the caller, for all of this function.
        let laws = &unsafe { required(laws, "laws") }?.laws;
        // SAFETY: `i` and `j` are NULL or valid for reads, by this function's safety section.
        let (bi, bj) = unsafe { (given(i, "i")?, given(j, "j")?) };
        let types = Some(laws.types());
        let (i, j) = (bi.to_core(types)?, bj.to_core(types)?);
        // SAFETY: `stiffness` is NULL or valid for reads and writes, and not aliased, by this function's safety
        // section.
        let mut out = unsafe { Output::new(stiffness, "stiffness") }?;
        let found = contact_stiffness(laws, &i, &j)
            .map_err(|e| hale_failure(bi.identifier, Some(bj.identifier), e.0))?
            .unwrap_or(ContactStiffness::NONE);
        out.write(&EllgranContactStiffness {
            size: size_of::<EllgranContactStiffness>(),
            normal_stiffness: found.normal_stiffness,
            tangential_stiffness: found.tangential_stiffness,
            normal_damping: found.normal_damping,
            tangential_damping: found.tangential_damping,
            critical_step: found.critical_step,
        });
        Ok(())
    })
}

/// Duration and largest penetration of an elastic collision of two ellipsoids that approach with `speed` > 0 along the
/// normal. Normal, curvatures and lever arms are those of the given positions, touching or apart. For a central impact the
/// time is that of Hertz, `2.9433 penetration/speed` (Landau and Lifshitz, Theory of Elasticity, section 9), or `pi
/// sqrt(m/kn)` for the linear law. Damping makes a collision longer and less deep. Both are INFINITY for two fixed bodies.
///
/// # Safety
/// The pointers are NULL or valid; `penetration` may be NULL.
#[no_mangle]
pub unsafe extern "C" fn ellgran_collision(
    laws: *const EllgranLaws,
    i: *const EllgranBody,
    j: *const EllgranBody,
    speed: f64,
    time: *mut f64,
    penetration: *mut f64,
) -> i32 {
    at_border("ellgran_collision", || {
        // SAFETY: promised by the caller, for all of this function.
        let laws = &unsafe { required(laws, "laws") }?.laws;
        // SAFETY: `i` and `j` are NULL or valid for reads, by this function's safety section.
        let (bi, bj) = unsafe { (given(i, "i")?, given(j, "j")?) };
        let types = Some(laws.types());
        let (i, j) = (bi.to_core(types)?, bj.to_core(types)?);
        // SAFETY: `time` is NULL or valid for reads and writes, and not aliased, by this function's safety section.
        let time = unsafe { required_mut(time, "time") }?;
        if !(speed > 0.0 && speed.is_finite()) {
            return Err(Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!("speed = {speed} must be greater than 0"),
            ));
        }
        let found = collision(laws, &i, &j, speed)
            .map_err(|e| hale_failure(bi.identifier, Some(bj.identifier), e.0))?;
        *time = found.time;
        // SAFETY: promised by the caller.
        if let Some(penetration) = unsafe { penetration.as_mut() } {
            *penetration = found.penetration;
        }
        Ok(())
    })
}

/// Limits of the time step by contacts of two grains that meet at `speed` >= 0, flat side on flat side, where a contact is stiffest,
/// before any contact is known: how long their collision takes to `collision_time` (INFINITY at speed 0), and the largest time step
/// at which velocity Verlet is stable for a contact of theirs to `critical_step`, at the deepest overlap of that collision, of 1 % of
/// the smaller least semi-axis at least and of a quarter of the distance of the centres at most. Places, rotations and velocities of
/// the bodies are not used, but must be in their ranges. Both are INFINITY for two fixed bodies.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_two_grain_limits(
    laws: *const EllgranLaws,
    i: *const EllgranBody,
    j: *const EllgranBody,
    speed: f64,
    collision_time: *mut f64,
    critical_step: *mut f64,
) -> i32 {
    at_border("ellgran_two_grain_limits", || {
        // SAFETY: promised by the caller, for all of this function.
        let laws = &unsafe { required(laws, "laws") }?.laws;
        // SAFETY: `i` and `j` are NULL or valid for reads, by this function's safety section.
        let (bi, bj) = unsafe { (given(i, "i")?, given(j, "j")?) };
        let types = Some(laws.types());
        let (i, j) = (bi.to_core(types)?, bj.to_core(types)?);
        // SAFETY: `collision_time` is NULL or valid for writes, and not aliased, by this function's safety section.
        let collision_time = unsafe { required_mut(collision_time, "collision_time") }?;
        // SAFETY: `critical_step` is NULL or valid for writes, and not aliased, by this function's safety section.
        let critical_step = unsafe { required_mut(critical_step, "critical_step") }?;
        if !(speed >= 0.0 && speed.is_finite()) {
            return Err(Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!("speed = {speed} must be 0 or greater"),
            ));
        }
        let found = two_grain_limits(laws, [&i, &j], speed)
            .map_err(|e| hale_failure(bi.identifier, Some(bj.identifier), e.0))?;
        *collision_time = found.collision;
        *critical_step = found.critical_step;
        Ok(())
    })
}

/// Rayleigh's time of a grain: the time in which a surface wave travels from pole to pole of a sphere whose radius is the
/// smallest semi-axis, `pi r sqrt(rho/G)/(0.1631 nu + 0.8766)` with the density of the solid grain (C. Thornton and C.W.
/// Randall, Micromechanics of Granular Materials, 1988). Time steps are commonly a fifth of it or less. INFINITY for the
/// linear law, which has no elastic constants.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_rayleigh_time(
    parameters: *const EllgranLawParameters,
    grain: *const EllgranBody,
    time: *mut f64,
) -> i32 {
    at_border("ellgran_rayleigh_time", || {
        // SAFETY: promised by the caller, for all of this function.
        let parameters = unsafe { given(parameters, "parameters") }?.to_core()?;
        // Any type is right.
        // SAFETY: `grain` is NULL or valid for reads, by this function's safety section.
        let grain = unsafe { given(grain, "grain") }?.to_core(Some(usize::MAX))?;
        // SAFETY: `time` is NULL or valid for reads and writes, and not aliased, by this function's safety section.
        let time = unsafe { required_mut(time, "time") }?;
        *time = rayleigh_time(&parameters, &grain);
        Ok(())
    })
}
