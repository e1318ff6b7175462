// SPDX-License-Identifier: MIT OR Apache-2.0
//! Energies, virial and counts that a caller may ask for.

use super::growing::{given, growing, Output};
use super::particles::{changes, identifier, shape_of, EllgranParticles, EllgranStep};
use super::status::{
    at_border, slice, slice_mut, Failure, ELLGRAN_ERROR_ARGUMENT, ELLGRAN_ERROR_NULL_POINTER,
    ELLGRAN_ERROR_PARTICLE,
};
use crate::contact::particle::{angular_velocity, response_to_torque};
use crate::contact::{ranges, Particle, Step};
use crate::geometry::Ellipsoid;
use crate::tallies::InelasticLoad;
use crate::tallies::Tallies;
use crate::vector::Vector3;
use crate::walls::Wall;

/// Requested quantities, and their sums over the contacts of a call. NULL: nothing is requested, and nothing is computed
/// for it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranTallies {
    /// `sizeof(EllgranTallies)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// In: [count] or NULL; elastic energy per particle, added to, half to each body.
    pub particle_energies: *mut f64,
    /// In: [count][6] (xx yy zz xy xz yz) or NULL; virial per particle, added to, half to each body.
    pub particle_virials: *mut f64,
    /// Out: [count][12] or NULL; the loads on each particle that are not the gradient of the normal elastic energy: viscous
    /// force (3) and its torque (3), tangential force without its viscous part (3) and its torque (3). Where
    /// `angular_momenta` are given, the torques are multiplied by the inverse inertia. Overwritten.
    ///
    /// It makes the balance of energies second order in the time step. Velocity Verlet moves particles with velocities of
    /// half steps: a force does half of its work with the velocity before it, and half with the velocity after it. With
    /// this array each call adds the first half, and `ellgran_tally_following_half_step` adds the second. Without it each
    /// call takes the given velocities for the whole step, and the sum of kinetic, elastic and dissipated energy has an
    /// error of first order.
    pub inelastic_loads: *mut f64,
    /// Out: with `inelastic_loads`, power of the viscous and of the tangential forces on moving walls, for the second half.
    pub wall_powers: [f64; 2],
    /// In/out: energy that viscous forces dissipated. Set it to 0 before the first step and keep it between steps.
    pub viscous_dissipation: f64,
    /// In/out: work done against the tangential forces without their viscous part, stored or dissipated. Set it to 0 before
    /// the first step and keep it between steps.
    pub tangential_work: f64,
    /// Out: energy dissipated by friction since `tangential_work` was 0: `tangential_work` minus
    /// `tangential_elastic_energy`. With `displacement total` it may be negative, since that law can create energy.
    pub frictional_dissipation: f64,
    /// Out: energy dissipated: by viscosity and by friction.
    pub dissipated_energy: f64,
    /// Out: elastic energy of the normal deformation.
    pub normal_elastic_energy: f64,
    /// Out: elastic energy of the tangential deformation, of rolling and of twisting.
    pub tangential_elastic_energy: f64,
    /// Out: sum of d (x) F over pairs, d from i to j, F the force on j: xx yy zz xy xz yz.
    pub virial: [f64; 6],
    /// Out: number of touching pairs; a pair that another rank lists too counts one half.
    pub touching_count: f64,
    /// Out: number of listed pairs.
    pub pair_count: i64,
}

growing!(EllgranTallies);

/// # Safety
/// The arrays of `t` are NULL or have `count` entries.
pub(super) unsafe fn borrow<'a>(t: &EllgranTallies, count: usize) -> Result<Tallies<'a>, Failure> {
    for (value, name) in [
        (t.viscous_dissipation, "viscous_dissipation"),
        (t.tangential_work, "tangential_work"),
    ] {
        if !value.is_finite() {
            return Err(Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!("{name} = {value} of the tallies must be finite: set it to 0 before the first step"),
            ));
        }
    }
    // SAFETY: promised by the caller; NULL is not asked for.
    let particle_energies = if t.particle_energies.is_null() {
        None
    } else {
        // SAFETY: `particle_energies` is NULL or valid for reads and writes of `count` elements, and not aliased, as
        // `EllgranTallies` demands.
        Some(unsafe { slice_mut(t.particle_energies, count, "particle_energies") }?)
    };
    // SAFETY: as above.
    let particle_virials = if t.particle_virials.is_null() {
        None
    } else {
        // SAFETY: `particle_virials` is NULL or valid for reads and writes of 6 values for each of `count` particles,
        // and not aliased, as `EllgranTallies` demands.
        Some(unsafe {
            slice_mut(
                t.particle_virials.cast::<[f64; 6]>(),
                count,
                "particle_virials",
            )
        }?)
    };
    // SAFETY: as above.
    let inelastic_loads = unsafe { loads(t, count) }?;
    Ok(Tallies {
        particle_energies,
        particle_virials,
        inelastic_loads,
        viscous_dissipation: t.viscous_dissipation,
        tangential_work: t.tangential_work,
        wall_powers: t.wall_powers,
        ..Tallies::default()
    })
}

/// # Safety
/// The array is NULL or has `count` entries.
unsafe fn loads<'a>(
    t: &EllgranTallies,
    count: usize,
) -> Result<Option<&'a mut [InelasticLoad]>, Failure> {
    if t.inelastic_loads.is_null() {
        return Ok(None);
    }
    let entries = t.inelastic_loads.cast::<InelasticLoad>();
    // SAFETY: promised by the caller; an entry is 12 doubles and nothing else.
    unsafe { slice_mut(entries, count, "inelastic_loads") }.map(Some)
}

/// Of the particles that loads may act on: which velocities and rotations move them.
///
/// # Safety
/// The arrays of `p` have the lengths that [`EllgranParticles`] states.
unsafe fn motion<'a>(
    p: &'a EllgranParticles,
    count: usize,
) -> Result<impl Fn(usize) -> ([f64; 3], [f64; 3]) + 'a, Failure> {
    let (rotation, name) = if p.angular_velocities.is_null() {
        (p.angular_momenta, "angular_momenta (or angular_velocities)")
    } else {
        (p.angular_velocities, "angular_velocities")
    };
    // SAFETY: promised by the caller.
    let (velocities, rotations) = unsafe {
        (
            slice(p.velocities.cast::<[f64; 3]>(), count, "velocities")?,
            slice(rotation.cast::<[f64; 3]>(), count, name)?,
        )
    };
    // SAFETY: promised by the caller.
    let changes = unsafe { changes(p, count) };
    Ok(move |k: usize| {
        let (mut velocity, mut rotation) = (velocities[k], rotations[k]);
        if let Some(change) = changes.get(k) {
            for axis in 0..3 {
                velocity[axis] -= change[axis];
                rotation[axis] -= change[3 + axis];
            }
        }
        (velocity, rotation)
    })
}

/// Refuses a velocity or a rotation that a particle cannot have, as a call that prepares particles does. `turns` makes an angular velocity of a
/// rotation, of which otherwise only its range is known.
fn check_motion(
    p: &EllgranParticles,
    k: usize,
    (velocity, rotation): ([f64; 3], [f64; 3]),
    turns: impl Fn(Vector3) -> Vector3,
) -> Result<(), Failure> {
    let check = || {
        ranges::velocity(velocity)?;
        if !p.angular_velocities.is_null() {
            return ranges::angular_velocity(rotation);
        }
        let momentum = ranges::vector(rotation, f64::MAX, "angular momentum")?;
        ranges::vector(
            turns(momentum).to_array(),
            ranges::LARGEST_VELOCITY,
            "angular velocity (from the angular momentum)",
        )
    };
    check().map(|_| ()).map_err(|what| {
        Failure::new(
            ELLGRAN_ERROR_PARTICLE,
            format!("particle {}: {what}", identifier(p, k)),
        )
    })
}

/// Checks the half-step velocities of particles that were prepared with those of the step alone, as without friction, and whose work will be
/// added with them. What [`prepare`](super::particles::prepare) has read of them with friction it has checked.
///
/// # Safety
/// The arrays of `p` have the lengths that [`EllgranParticles`] states, and `count` of each were checked in this call.
pub(super) unsafe fn check_half_step(
    p: &EllgranParticles,
    count: usize,
    particles: impl IntoIterator<Item = usize>,
) -> Result<(), Failure> {
    if p.velocity_changes.is_null() {
        return Ok(());
    }
    // SAFETY: promised by the caller.
    let motion = unsafe { motion(p, count) }?;
    for k in particles {
        check_motion(p, k, motion(k), |momentum| {
            // SAFETY: promised by the caller; a particle that was prepared has a shape and a mass.
            let (shape, mass) = unsafe { (shape_of(p, k), *p.masses.add(k)) };
            let body = shape.and_then(|(a, q)| Ellipsoid::new(a, q).ok());
            body.map_or(momentum, |body| angular_velocity(&body, mass, momentum))
        })?;
    }
    Ok(())
}

/// Checks the velocities and rotations that the work of these loads is added with.
fn check_loaded<'l>(
    p: &EllgranParticles,
    loads: impl IntoIterator<Item = (usize, &'l InelasticLoad)>,
    motion: impl Fn(usize) -> ([f64; 3], [f64; 3]),
) -> Result<(), Failure> {
    let mut loaded = loads.into_iter().filter(|(_, load)| !load.is_zero());
    // Shapes are not read where half a step follows.
    loaded.try_for_each(|(k, _)| check_motion(p, k, motion(k), |_| Vector3::ZERO))
}

/// Ends a call that tallied the loads of the first `count` particles: makes of their torques what answers to
/// the engine's rotations, and adds the work of the half step before. Does nothing without loads.
///
/// # Safety
/// The arrays of `p` have the lengths that [`EllgranParticles`] states, and were checked in this call, as was the half step.
pub(super) unsafe fn add_preceding_half_step(
    sums: &mut Tallies<'_>,
    p: &EllgranParticles,
    count: usize,
    step: &Step,
) -> Result<(), Failure> {
    let Some(loads) = sums.inelastic_loads.take() else {
        return Ok(());
    };
    if p.angular_velocities.is_null() {
        for (k, load) in loads.iter_mut().enumerate().filter(|(_, l)| !l.is_zero()) {
            // SAFETY: promised by the caller; a particle with a load was found to have shape and mass.
            let (shape, mass) = unsafe { (shape_of(p, k), *p.masses.add(k)) };
            let body = shape.and_then(|(a, q)| Ellipsoid::new(a, q).ok());
            if let Some(body) = body {
                load.respond(response_to_torque(&body, mass));
            }
        }
    }
    if step.advance_history {
        // SAFETY: promised by the caller.
        let motion = unsafe { motion(p, count) }?;
        sums.add_half_step(
            0.5 * step.time_step,
            loads[..count].iter().enumerate(),
            motion,
        );
    }
    Ok(())
}

/// Makes of the torques of the loads that a wall keeps what answers to the engine's rotations; `near` are the particles that might
/// touch it, as they were prepared.
///
/// # Safety
/// As for [`add_preceding_half_step`].
pub(super) unsafe fn respond_at_wall(p: &EllgranParticles, wall: &mut Wall, near: &[Particle]) {
    if !p.angular_velocities.is_null() {
        return;
    }
    for touching in wall.touching_loads_mut() {
        // SAFETY: promised by the caller; a particle with a load was found to have a mass.
        let mass = unsafe { *p.masses.add(touching.particle) };
        let response = response_to_torque(&near[touching.near].body, mass);
        touching.load.respond(response);
    }
}

/// Checks the velocities and rotations with which [`add_half_step_at_wall`] will add work after a half step.
///
/// # Safety
/// The arrays of `p` have the lengths that [`EllgranParticles`] states.
pub(super) unsafe fn check_half_step_at_wall(
    p: &EllgranParticles,
    wall: &Wall,
    step: &Step,
) -> Result<(), Failure> {
    if !step.advance_history || wall.touching_loads().is_empty() {
        return Ok(());
    }
    // SAFETY: promised by the caller.
    let motion = unsafe { motion(p, p.owned_count) }?;
    let loads = wall.touching_loads().iter().map(|t| (t.particle, &t.load));
    check_loaded(p, loads, motion)
}

/// Adds the work of the loads that a wall keeps over half a step.
///
/// # Safety
/// The arrays of `p` have the lengths that [`EllgranParticles`] states.
pub(super) unsafe fn add_half_step_at_wall(
    sums: &mut Tallies<'_>,
    p: &EllgranParticles,
    wall: &Wall,
    step: &Step,
) -> Result<(), Failure> {
    if !step.advance_history || wall.touching_loads().is_empty() {
        return Ok(());
    }
    // SAFETY: promised by the caller.
    let motion = unsafe { motion(p, p.owned_count) }?;
    let loads = wall.touching_loads().iter().map(|t| (t.particle, &t.load));
    sums.add_half_step(0.5 * step.time_step, loads, motion);
    Ok(())
}

/// Adds the work that the loads of the last call of `ellgran_compute_pairs` or `ellgran_compute_wall` do in the half step
/// after it to `viscous_dissipation` and `tangential_work` of its `tallies`.
///
/// Call it once in each step, when the velocities and angular momenta (or angular velocities) are those of the half step
/// after that call and the order of the particles is still the same: in velocity Verlet before or after the positions move.
/// The first `owned_count` velocities and rotations of `particles` are read. With `newton` = 1 of the list, first add the
/// loads of the ghosts to those of their owners. `step` is that of the half step; where `advance_history` is 0 nothing is
/// added.
///
/// # Safety
/// The pointers are as `EllgranParticles` and `EllgranTallies` state.
#[no_mangle]
pub unsafe extern "C" fn ellgran_tally_following_half_step(
    particles: *const EllgranParticles,
    step: *const EllgranStep,
    tallies: *mut EllgranTallies,
) -> i32 {
    at_border("ellgran_tally_following_half_step", || {
        // SAFETY: promised by the caller, for all of this function.
        let p = &*unsafe { given(particles, "particles") }?;
        // SAFETY: `step` is NULL or valid for reads, by this function's safety section.
        let step = unsafe { given(step, "step") }?.to_core()?;
        // SAFETY: `tallies` and the arrays that it names are valid as `EllgranTallies` demands, by this function's
        // safety section.
        let mut asked = unsafe { Asked::new(tallies) }?
            .ok_or_else(|| Failure::new(ELLGRAN_ERROR_NULL_POINTER, "tallies must not be NULL"))?;
        let t = asked.given;
        if p.owned_count > p.count {
            return Err(Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!(
                    "owned_count = {} is greater than count = {}",
                    p.owned_count, p.count
                ),
            ));
        }
        let count = p.owned_count;
        // SAFETY: `inelastic_loads` is NULL or has 12 values for each of `count` particles, as `EllgranTallies`
        // demands.
        let loads = unsafe { loads(&t, count) }?.ok_or_else(|| {
            Failure::new(
                ELLGRAN_ERROR_NULL_POINTER,
                "inelastic_loads must not be NULL",
            )
        })?;
        if step.advance_history {
            let mut sums = asked.carried();
            // SAFETY: the arrays of `particles` are NULL or as long as its counts say, as `EllgranParticles` demands.
            let motion = unsafe { motion(p, count) }?;
            check_loaded(p, loads.iter().enumerate(), &motion)?;
            sums.add_half_step(0.5 * step.time_step, loads.iter().enumerate(), motion);
            asked.write_carried(&sums);
        }
        Ok(())
    })
}

/// What the caller asks for, and where it goes.
pub(super) struct Asked<'a> {
    pub given: EllgranTallies,
    output: Output<'a, EllgranTallies>,
}

impl Asked<'_> {
    /// # Safety
    /// `tallies` is NULL (then nothing is asked for) or valid, as long as the size in it says, for the lifetime that the
    /// caller gives it.
    pub(super) unsafe fn new(tallies: *mut EllgranTallies) -> Result<Option<Self>, Failure> {
        if tallies.is_null() {
            return Ok(None);
        }
        // SAFETY: promised by the caller; the reference ends before anything is written.
        let given = *unsafe { given(tallies.cast_const(), "tallies") }?;
        // SAFETY: promised by the caller.
        let output = unsafe { Output::new(tallies, "tallies") }?;
        Ok(Some(Asked { given, output }))
    }

    /// The sums that are carried between steps.
    pub(super) fn carried(&self) -> Tallies<'static> {
        Tallies {
            viscous_dissipation: self.given.viscous_dissipation,
            tangential_work: self.given.tangential_work,
            wall_powers: self.given.wall_powers,
            ..Tallies::default()
        }
    }

    /// Writes these alone.
    pub(super) fn write_carried(&mut self, sums: &Tallies<'_>) {
        self.output.write(&EllgranTallies {
            viscous_dissipation: sums.viscous_dissipation,
            tangential_work: sums.tangential_work,
            ..self.given
        });
    }

    pub(super) fn write(&mut self, sums: &Tallies<'_>) {
        self.output.write(&EllgranTallies {
            wall_powers: sums.wall_powers,
            viscous_dissipation: sums.viscous_dissipation,
            tangential_work: sums.tangential_work,
            frictional_dissipation: sums.frictional_dissipation(),
            dissipated_energy: sums.viscous_dissipation + sums.frictional_dissipation(),
            normal_elastic_energy: sums.normal_elastic_energy,
            tangential_elastic_energy: sums.tangential_elastic_energy,
            virial: sums.virial,
            touching_count: sums.touching,
            pair_count: sums.pairs as i64,
            ..self.given
        });
    }
}
