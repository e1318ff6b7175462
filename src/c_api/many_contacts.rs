// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contacts, stiffnesses and collisions of many pairs in one call, each quantity into an array of its own.

use super::contact::{contact_of_two, EllgranContactForce, EllgranContactGeometry, Wanted};
use super::growing::{given, growing, GivenArray};
use super::law::{EllgranLawParameters, EllgranLaws};
use super::particles::{
    hale_failure, identifier, shape_of, EllgranParticles, EllgranStep, EllgranWorkspace,
};
use super::status::{
    at_border, required, required_mut, slice, slice_mut, Failure, ELLGRAN_ERROR_ARGUMENT,
    ELLGRAN_ERROR_PARTICLE,
};
use super::without_history::checked;
use crate::contact::prepare_body;
use crate::contact::ranges;
use crate::contact::stability::{collision, contact_stiffness, rayleigh_time, ContactStiffness};
use crate::contact::Body;
use crate::contact::Particle;
use crate::message::Number;

/// Output arrays of many contacts: one for each field of `EllgranContactGeometry` and `EllgranContactForce`, with the same
/// name and meaning, NULL where it is not wanted. [count] is the number of pairs.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranContactArrays {
    /// `sizeof(EllgranContactArrays)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// [count]; minus the gap where the bodies are apart. Gaps are computed if this or one of the next six is wanted.
    pub penetration: *mut f64,
    /// [count][3]
    pub normal: *mut f64,
    /// [count][3]
    pub contact_point: *mut f64,
    /// [count][3]
    pub witness_i: *mut f64,
    /// [count][3]
    pub witness_j: *mut f64,
    /// [count][2]: `curvature_a` and `curvature_b`.
    pub curvatures: *mut f64,
    /// [count][3]
    pub major_direction: *mut f64,
    /// [count][2]
    pub contact_semi_axes: *mut f64,
    /// [count][3]
    pub force: *mut f64,
    /// [count][3]
    pub torque_i: *mut f64,
    /// [count][3]
    pub torque_j: *mut f64,
    /// [count]
    pub normal_force: *mut f64,
    /// [count][3]
    pub tangential_force: *mut f64,
    /// [count][3]
    pub displacement: *mut f64,
    /// [count]
    pub penetration_rate: *mut f64,
    /// [count]
    pub elastic_energy: *mut f64,
    /// [count]
    pub tangential_energy: *mut f64,
    /// [count][3]
    pub viscous_force: *mut f64,
    /// [count][3]
    pub frictional_force: *mut f64,
    /// [count]
    pub viscous_power: *mut f64,
    /// [count]
    pub tangential_power: *mut f64,
    /// [count][3]
    pub frictional_couple: *mut f64,
    /// [count][3]
    pub viscous_couple: *mut f64,
}

growing!(EllgranContactArrays, tangential_power: *mut f64);

/// Output arrays of the stiffnesses of many contacts: one for each field of `EllgranContactStiffness`, with the same name
/// and meaning, NULL where it is not wanted. [count] is the number of pairs.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranStiffnessArrays {
    /// `sizeof(EllgranStiffnessArrays)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// [count]
    pub normal_stiffness: *mut f64,
    /// [count][2]
    pub tangential_stiffness: *mut f64,
    /// [count]
    pub normal_damping: *mut f64,
    /// [count][2]
    pub tangential_damping: *mut f64,
    /// [count]
    pub critical_step: *mut f64,
}

growing!(EllgranStiffnessArrays);

/// An array of a caller's, `N` numbers a contact, or none.
struct Column<'a, const N: usize>(Option<&'a mut [[f64; N]]>);

impl<const N: usize> Column<'_, N> {
    /// # Safety
    /// `pointer` is NULL or valid for reads and writes of `count` entries, and not aliased, for the lifetime that the caller
    /// gives it.
    unsafe fn new(pointer: *mut f64, count: usize) -> Result<Self, Failure> {
        if pointer.is_null() {
            return Ok(Column(None));
        }
        // SAFETY: promised by the caller.
        unsafe { slice_mut(pointer.cast::<[f64; N]>(), count, "") }.map(|all| Column(Some(all)))
    }

    fn is_wanted(&self) -> bool {
        self.0.is_some()
    }

    #[inline]
    fn set(&mut self, k: usize, value: [f64; N]) {
        if let Some(all) = &mut self.0 {
            all[k] = value;
        }
    }
}

struct Columns<'a> {
    penetration: Column<'a, 1>,
    normal: Column<'a, 3>,
    contact_point: Column<'a, 3>,
    witness_i: Column<'a, 3>,
    witness_j: Column<'a, 3>,
    curvatures: Column<'a, 2>,
    major_direction: Column<'a, 3>,
    contact_semi_axes: Column<'a, 2>,
    force: Column<'a, 3>,
    torque_i: Column<'a, 3>,
    torque_j: Column<'a, 3>,
    normal_force: Column<'a, 1>,
    tangential_force: Column<'a, 3>,
    displacement: Column<'a, 3>,
    penetration_rate: Column<'a, 1>,
    elastic_energy: Column<'a, 1>,
    tangential_energy: Column<'a, 1>,
    viscous_force: Column<'a, 3>,
    frictional_force: Column<'a, 3>,
    viscous_power: Column<'a, 1>,
    tangential_power: Column<'a, 1>,
    frictional_couple: Column<'a, 3>,
    viscous_couple: Column<'a, 3>,
}

impl Columns<'_> {
    /// # Safety
    /// The arrays are as [`EllgranContactArrays`] states, and no two of them overlap, for the lifetime that the caller gives
    /// them.
    unsafe fn new(a: &EllgranContactArrays, count: usize) -> Result<Self, Failure> {
        // SAFETY: promised by the caller, for all of them.
        unsafe {
            Ok(Columns {
                penetration: Column::new(a.penetration, count)?,
                normal: Column::new(a.normal, count)?,
                contact_point: Column::new(a.contact_point, count)?,
                witness_i: Column::new(a.witness_i, count)?,
                witness_j: Column::new(a.witness_j, count)?,
                curvatures: Column::new(a.curvatures, count)?,
                major_direction: Column::new(a.major_direction, count)?,
                contact_semi_axes: Column::new(a.contact_semi_axes, count)?,
                force: Column::new(a.force, count)?,
                torque_i: Column::new(a.torque_i, count)?,
                torque_j: Column::new(a.torque_j, count)?,
                normal_force: Column::new(a.normal_force, count)?,
                tangential_force: Column::new(a.tangential_force, count)?,
                displacement: Column::new(a.displacement, count)?,
                penetration_rate: Column::new(a.penetration_rate, count)?,
                elastic_energy: Column::new(a.elastic_energy, count)?,
                tangential_energy: Column::new(a.tangential_energy, count)?,
                viscous_force: Column::new(a.viscous_force, count)?,
                frictional_force: Column::new(a.frictional_force, count)?,
                viscous_power: Column::new(a.viscous_power, count)?,
                tangential_power: Column::new(a.tangential_power, count)?,
                frictional_couple: Column::new(a.frictional_couple, count)?,
                viscous_couple: Column::new(a.viscous_couple, count)?,
            })
        }
    }

    fn wanted(&self) -> Wanted {
        Wanted {
            geometry: self.penetration.is_wanted()
                || self.normal.is_wanted()
                || self.contact_point.is_wanted()
                || self.witness_i.is_wanted()
                || self.witness_j.is_wanted()
                || self.curvatures.is_wanted()
                || self.major_direction.is_wanted(),
            ellipse: self.contact_semi_axes.is_wanted(),
        }
    }

    #[inline]
    fn set_geometry(&mut self, k: usize, g: &EllgranContactGeometry) {
        self.penetration.set(k, [g.penetration]);
        self.normal.set(k, g.normal);
        self.contact_point.set(k, g.contact_point);
        self.witness_i.set(k, g.witness_i);
        self.witness_j.set(k, g.witness_j);
        self.curvatures.set(k, [g.curvature_a, g.curvature_b]);
        self.major_direction.set(k, g.major_direction);
    }

    #[inline]
    fn set_force(&mut self, k: usize, f: &EllgranContactForce) {
        self.contact_semi_axes.set(k, f.contact_semi_axes);
        self.force.set(k, f.force);
        self.torque_i.set(k, f.torque_i);
        self.torque_j.set(k, f.torque_j);
        self.normal_force.set(k, [f.normal_force]);
        self.tangential_force.set(k, f.tangential_force);
        self.displacement.set(k, f.displacement);
        self.penetration_rate.set(k, [f.penetration_rate]);
        self.elastic_energy.set(k, [f.elastic_energy]);
        self.tangential_energy.set(k, [f.tangential_energy]);
        self.viscous_force.set(k, f.viscous_force);
        self.frictional_force.set(k, f.frictional_force);
        self.viscous_power.set(k, [f.viscous_power]);
        self.tangential_power.set(k, [f.tangential_power]);
        self.frictional_couple.set(k, f.frictional_couple);
        self.viscous_couple.set(k, f.viscous_couple);
    }
}

fn at_pair(k: usize) -> impl Fn(Failure) -> Failure {
    move |failure| Failure::new(failure.status, format!("pairs[{k}]: {}", failure.message))
}

/// Many contacts of ellipsoids in one call. The results are those of `ellgran_contact` for each pair, bit for bit. `pairs`
/// is [pair_count][2], indices from 0; the first of a pair is body i of geometry and force. Forces and torques of
/// `particles` are neither read nor written. For whole neighbour lists `ellgran_compute_pairs` is faster, since it uses
/// vector instructions.
///
/// `touching`, [pair_count], and `history`, [pair_count][ellgran_laws_history_length], are the state of the pairs: set them
/// to 0 before the first call, keep them from step to step. Both may be NULL if that length is 0. The output arrays must
/// not overlap.
///
/// Invalid particles, pairs and arguments are refused before anything is written. If a contact fails after that, the
/// message names its number in `pairs` and both particles, and the contacts before it have been written.
///
/// # Safety
/// The pointers are as stated here, in `EllgranParticles` and in `EllgranContactArrays`.
#[no_mangle]
#[allow(clippy::too_many_arguments)]
pub unsafe extern "C" fn ellgran_pair_contacts(
    laws: *const EllgranLaws,
    workspace: *mut EllgranWorkspace,
    particles: *const EllgranParticles,
    step: *const EllgranStep,
    pair_count: usize,
    pairs: *const i32,
    touching: *mut i32,
    history: *mut f64,
    arrays: *const EllgranContactArrays,
) -> i32 {
    at_border("ellgran_pair_contacts", || {
        // SAFETY: promised by the caller, for all of this function.
        let laws = &unsafe { required(laws, "laws") }?.laws;
        // SAFETY: `workspace` is NULL or valid for reads and writes, and not aliased, by this function's safety
        // section.
        let workspace = &mut unsafe { required_mut(workspace, "workspace") }?.workspace;
        // SAFETY: `particles` is NULL or valid for reads, by this function's safety section.
        let p = unsafe { given(particles, "particles") }?;
        // SAFETY: `step` is NULL or valid for reads, by this function's safety section.
        let step = unsafe { given(step, "step") }?.to_core()?;
        let length = laws.layout().length;
        let mut touching = if touching.is_null() && length == 0 {
            None
        } else {
            // SAFETY: `touching` is NULL or valid for reads and writes of `pair_count` elements, and not aliased, by
            // this function's safety section.
            Some(unsafe { slice_mut(touching, pair_count, "touching") }?)
        };
        let numbers = pair_count.checked_mul(length).ok_or_else(|| {
            Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!("pair_count = {pair_count} is too large: its histories exceed the address space"),
            )
        })?;
        // SAFETY: `history` is NULL or valid for reads and writes of `numbers` elements, and not aliased, by this
        // function's safety section.
        let history = unsafe { slice_mut(history, numbers, "history") }?;
        // SAFETY: `arrays` is NULL or valid for reads, by this function's safety section.
        let arrays = unsafe { given(arrays, "arrays") }?;
        // SAFETY: each array is NULL or has a row for each pair, and none is aliased, by this function's safety
        // section.
        let mut columns = unsafe { Columns::new(&arrays, pair_count) }?;
        let wanted = columns.wanted();
        // SAFETY: the arrays of `particles` and `pairs` are NULL or as long as their counts say, by this function's
        // safety section.
        let (all, pairs) = unsafe { checked(Some(laws), workspace, &p, pair_count, pairs) }?;
        for (k, [i, j]) in pairs.iter().enumerate() {
            let (i, j) = (*i as usize, *j as usize);
            let names = [identifier(&p, i), identifier(&p, j)];
            let mut none = 0;
            let touches = touching.as_deref_mut().map_or(&mut none, |t| &mut t[k]);
            let kept = &mut history[k * length..(k + 1) * length];
            let (geometry, force) = contact_of_two(
                laws,
                [&all[i], &all[j]],
                names,
                &step,
                wanted,
                touches,
                kept,
            )
            .map_err(at_pair(k))?;
            if let Some(geometry) = &geometry {
                columns.set_geometry(k, geometry);
            }
            columns.set_force(k, &force);
        }
        Ok(())
    })
}

/// A particle with its mass, which laws need not read.
///
/// # Safety
/// The arrays of `p` are as [`EllgranParticles`] states, and `k` is one of its particles.
unsafe fn with_mass(p: &EllgranParticles, all: &[Particle], k: usize) -> Result<Particle, Failure> {
    let masses = if p.contact_masses.is_null() {
        p.masses
    } else {
        p.contact_masses
    };
    // SAFETY: promised by the caller.
    let masses = unsafe { slice(masses, p.count, "masses (or contact_masses)") }?;
    let inverse_mass = ranges::inverse_mass(masses[k], "mass").map_err(|what| {
        Failure::new(
            ELLGRAN_ERROR_PARTICLE,
            format!("particle {}: {what}", identifier(p, k)),
        )
    })?;
    Ok(Particle {
        inverse_mass,
        ..all[k]
    })
}

/// Stiffnesses and largest stable time steps of many contacts in one call: what `ellgran_contact_stiffness` gives for each
/// pair. `pairs` is [pair_count][2], indices from 0. Masses are read from `contact_masses` or, where that is NULL, `masses`;
/// forces and torques are not read.
///
/// On failure the contacts before the one that the message names may have been written.
///
/// # Safety
/// The pointers are as stated here, in `EllgranParticles` and in `EllgranStiffnessArrays`.
#[no_mangle]
pub unsafe extern "C" fn ellgran_pair_stiffnesses(
    laws: *const EllgranLaws,
    workspace: *mut EllgranWorkspace,
    particles: *const EllgranParticles,
    pair_count: usize,
    pairs: *const i32,
    arrays: *const EllgranStiffnessArrays,
) -> i32 {
    at_border("ellgran_pair_stiffnesses", || {
        // SAFETY: promised by the caller, for all of this function.
        let laws = &unsafe { required(laws, "laws") }?.laws;
        // SAFETY: `workspace` is NULL or valid for reads and writes, and not aliased, by this function's safety
        // section.
        let workspace = &mut unsafe { required_mut(workspace, "workspace") }?.workspace;
        // SAFETY: `particles` is NULL or valid for reads, by this function's safety section.
        let p = unsafe { given(particles, "particles") }?;
        // SAFETY: `arrays` is NULL or valid for reads, by this function's safety section.
        let a = unsafe { given(arrays, "arrays") }?;
        // SAFETY: each array is NULL or has a row for each pair, and none is aliased, by this function's safety
        // section.
        let (mut normal, mut tangential, mut damping, mut tangential_damping, mut step) = unsafe {
            (
                Column::new(a.normal_stiffness, pair_count)?,
                Column::new(a.tangential_stiffness, pair_count)?,
                Column::new(a.normal_damping, pair_count)?,
                Column::new(a.tangential_damping, pair_count)?,
                Column::new(a.critical_step, pair_count)?,
            )
        };
        // SAFETY: the arrays of `particles` and `pairs` are NULL or as long as their counts say, by this function's
        // safety section.
        let (all, pairs) = unsafe { checked(Some(laws), workspace, &p, pair_count, pairs) }?;
        for (k, [i, j]) in pairs.iter().enumerate() {
            let (i, j) = (*i as usize, *j as usize);
            // SAFETY: `checked` has compared `i` and `j` with the number of particles, and their masses are as long
            // as that.
            let both = unsafe { [with_mass(&p, all, i)?, with_mass(&p, all, j)?] };
            let found = contact_stiffness(laws, &both[0], &both[1])
                .map_err(|e| hale_failure(identifier(&p, i), Some(identifier(&p, j)), e.0))
                .map_err(at_pair(k))?
                .unwrap_or(ContactStiffness::NONE);
            normal.set(k, [found.normal_stiffness]);
            tangential.set(k, found.tangential_stiffness);
            damping.set(k, [found.normal_damping]);
            tangential_damping.set(k, found.tangential_damping);
            step.set(k, [found.critical_step]);
        }
        Ok(())
    })
}

/// Durations and depths of many elastic collisions in one call: what `ellgran_collision` gives for each pair. `pairs` is
/// [pair_count][2], indices from 0; `speeds`, `times` and `penetrations` are [pair_count]; `penetrations` may be NULL.
/// Masses are read from `contact_masses` or, where that is NULL, `masses`; forces and torques are not read.
///
/// On failure the collisions before the one that the message names may have been written.
///
/// # Safety
/// The pointers are as stated here and in `EllgranParticles`.
#[no_mangle]
#[allow(clippy::too_many_arguments)]
pub unsafe extern "C" fn ellgran_pair_collisions(
    laws: *const EllgranLaws,
    workspace: *mut EllgranWorkspace,
    particles: *const EllgranParticles,
    pair_count: usize,
    pairs: *const i32,
    speeds: *const f64,
    times: *mut f64,
    penetrations: *mut f64,
) -> i32 {
    at_border("ellgran_pair_collisions", || {
        // SAFETY: promised by the caller, for all of this function.
        let laws = &unsafe { required(laws, "laws") }?.laws;
        // SAFETY: `workspace` is NULL or valid for reads and writes, and not aliased, by this function's safety
        // section.
        let workspace = &mut unsafe { required_mut(workspace, "workspace") }?.workspace;
        // SAFETY: `particles` is NULL or valid for reads, by this function's safety section.
        let p = unsafe { given(particles, "particles") }?;
        // SAFETY: `speeds` is NULL or valid for reads of `pair_count` elements, by this function's safety section.
        let speeds = unsafe { slice(speeds, pair_count, "speeds") }?;
        // SAFETY: `times` is NULL or valid for reads and writes of `pair_count` elements, and not aliased, by this
        // function's safety section.
        let times = unsafe { slice_mut(times, pair_count, "times") }?;
        // SAFETY: each array is NULL or has a row for each pair, and none is aliased, by this function's safety
        // section.
        let mut penetrations = unsafe { Column::<1>::new(penetrations, pair_count) }?;
        // SAFETY: the arrays of `particles` and `pairs` are NULL or as long as their counts say, by this function's
        // safety section.
        let (all, pairs) = unsafe { checked(Some(laws), workspace, &p, pair_count, pairs) }?;
        for (k, [i, j]) in pairs.iter().enumerate() {
            let (i, j) = (*i as usize, *j as usize);
            if !(speeds[k] > 0.0 && speeds[k].is_finite()) {
                return Err(Failure::new(
                    ELLGRAN_ERROR_ARGUMENT,
                    format!("speeds[{k}] = {} must be greater than 0", Number(speeds[k])),
                ));
            }
            // SAFETY: `checked` has compared `i` and `j` with the number of particles, and their masses are as long
            // as that.
            let both = unsafe { [with_mass(&p, all, i)?, with_mass(&p, all, j)?] };
            let found = collision(laws, &both[0], &both[1], speeds[k])
                .map_err(|e| hale_failure(identifier(&p, i), Some(identifier(&p, j)), e.0))
                .map_err(at_pair(k))?;
            times[k] = found.time;
            penetrations.set(k, [found.penetration]);
        }
        Ok(())
    })
}

/// Rayleigh's times of many grains in one call: what `ellgran_rayleigh_time` gives for each. `parameters` is [type_count],
/// those of the types from 1 on; of `particles` are read shapes, types and `masses`; `times` is [count] of the particles.
///
/// On failure the times before that of the particle that the message names may have been written.
///
/// # Safety
/// The pointers are as stated here and in `EllgranParticles`.
#[no_mangle]
pub unsafe extern "C" fn ellgran_rayleigh_times(
    type_count: usize,
    parameters: *const EllgranLawParameters,
    particles: *const EllgranParticles,
    times: *mut f64,
) -> i32 {
    at_border("ellgran_rayleigh_times", || {
        // SAFETY: promised by the caller, for all of this function.
        let given_parameters = unsafe { GivenArray::new(parameters, type_count, "parameters") }?;
        let of_types = (0..type_count)
            .map(|k| given_parameters.get(k)?.to_core())
            .collect::<Result<Vec<_>, _>>()?;
        // SAFETY: `particles` is NULL or valid for reads, by this function's safety section.
        let p = unsafe { given(particles, "particles") }?;
        let count = p.count;
        // SAFETY: `types` is NULL or valid for reads of `count` elements, as `EllgranParticles` demands.
        let types = unsafe { slice(p.types, count, "types") }?;
        // SAFETY: `masses` is NULL or valid for reads of `count` elements, as `EllgranParticles` demands.
        let masses = unsafe { slice(p.masses, count, "masses") }?;
        // SAFETY: `times` is NULL or valid for reads and writes of `count` elements, and not aliased, by this
        // function's safety section.
        let times = unsafe { slice_mut(times, count, "times") }?;
        if count > 0 {
            // SAFETY: the arrays of shapes are NULL or valid for reads, as `EllgranParticles` demands.
            unsafe {
                required(p.semi_axes, "semi_axes")?;
                required(p.quaternions, "quaternions")?;
            }
        }
        for (k, time) in times.iter_mut().enumerate() {
            let identifier = identifier(&p, k);
            let wrong = |what: &str| {
                Failure::new(
                    ELLGRAN_ERROR_PARTICLE,
                    format!("particle {identifier}: {what}"),
                )
            };
            // SAFETY: `k` is below `count`, and the arrays of shapes are not NULL and as long as `EllgranParticles`
            // demands.
            let (semi_axes, quaternion) = unsafe { shape_of(&p, k) }
                .ok_or_else(|| wrong("it has no shape: every particle must be an ellipsoid"))?;
            let body = Body {
                position: [0.0; 3],
                quaternion,
                semi_axes,
                velocity: [0.0; 3],
                angular_velocity: [0.0; 3],
                mass: masses[k],
                particle_type: types[k],
                identifier,
            };
            let grain = prepare_body(&body, Some(type_count))
                .map_err(|e| Failure::new(ELLGRAN_ERROR_PARTICLE, e.to_string()))?;
            *time = rayleigh_time(&of_types[grain.particle_type as usize - 1], &grain);
        }
        Ok(())
    })
}
