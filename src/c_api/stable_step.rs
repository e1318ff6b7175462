// SPDX-License-Identifier: MIT OR Apache-2.0
//! The time step that all contacts of a scene allow.

use super::growing::{given, growing, Output};
use super::law::EllgranLaws;
use super::neighbour_list::{list_failure, pairs_of, EllgranNeighbourList};
use super::particles::{
    hale_failure, handles, identifier, prepare, EllgranParticles, EllgranWorkspace, Purpose,
};
use super::rigid_wall::EllgranWall;
use super::status::{
    at_border, required, required_mut, slice, slice_mut, Failure, ELLGRAN_ERROR_ARGUMENT,
    ELLGRAN_ERROR_PARTICLE,
};
use crate::contact::ranges;
use crate::contact::stable_step::{
    least_stable_step, step_for_error, CollisionThrough, ContactExtremes, StepSums, SUMS,
};
use crate::contact::Laws;
use crate::list::add_pairs_to_step_sums;
use crate::message::Number;
use crate::walls::WallMasses;

/// Doubles that `ellgran_add_pairs_to_step_sums` and `ellgran_add_wall_to_step_sums` keep of each particle.
pub const ELLGRAN_STEP_SUMS_LENGTH: usize = 42;

const _: () = assert!(ELLGRAN_STEP_SUMS_LENGTH == SUMS);

/// What a set of contacts has in common. Zero before the first contact; each call that is given it adds its contacts.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranContactExtremes {
    /// `sizeof(EllgranContactExtremes)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// Number of contacts that were added.
    pub touching_count: i64,
    /// The duration of the shortest elastic collision, of those that pass through a contact with its present penetration and its present
    /// speed along the normal; damping makes it longer. 0: there is none.
    pub shortest_collision: f64,
    /// Speed along the normal with which that collision begins.
    pub collision_speed: f64,
    /// Normal stiffness of that contact at a penetration of one unit of length, force/length.
    pub collision_stiffness: f64,
    /// Acceleration of its penetration by a unit force, rotations included, 1/mass.
    pub collision_inverse_mass: f64,
    /// The effective mass that its damping with a coefficient of restitution reads; 0 where no law reads it.
    pub collision_effective_mass: f64,
    /// Identifiers of its particles; the second is 0 for a wall.
    pub collision_identifiers: [i64; 2],
    /// Their types.
    pub collision_types: [i32; 2],
    /// The largest penetration over the least semi-axis of the two particles, or of the one at a wall.
    pub deepest_overlap: f64,
    /// Identifiers of the particles of that contact; the second is 0 for a wall.
    pub deepest_identifiers: [i64; 2],
}

growing!(EllgranContactExtremes);

fn argument(what: String) -> Failure {
    Failure::new(ELLGRAN_ERROR_ARGUMENT, what)
}

impl EllgranContactExtremes {
    fn collision(&self) -> CollisionThrough {
        CollisionThrough {
            time: self.shortest_collision,
            speed: self.collision_speed,
            stiffness: self.collision_stiffness,
            inverse_mass: self.collision_inverse_mass,
            effective_mass: self.collision_effective_mass,
        }
    }

    fn to_core(self) -> ContactExtremes {
        ContactExtremes {
            shortest: (self.shortest_collision > 0.0).then(|| {
                (
                    self.collision(),
                    self.collision_identifiers,
                    self.collision_types.map(|t| t.max(1) as usize),
                )
            }),
            deepest: (self.deepest_overlap, self.deepest_identifiers),
            touching: self.touching_count.max(0) as u64,
        }
    }

    fn of(found: &ContactExtremes) -> Self {
        let mut extremes = EllgranContactExtremes {
            size: size_of::<Self>(),
            touching_count: found.touching as i64,
            shortest_collision: 0.0,
            collision_speed: 0.0,
            collision_stiffness: 0.0,
            collision_inverse_mass: 0.0,
            collision_effective_mass: 0.0,
            collision_identifiers: [0; 2],
            collision_types: [0; 2],
            deepest_overlap: found.deepest.0,
            deepest_identifiers: found.deepest.1,
        };
        if let Some((c, identifiers, types)) = &found.shortest {
            extremes.shortest_collision = c.time;
            extremes.collision_speed = c.speed;
            extremes.collision_stiffness = c.stiffness;
            extremes.collision_inverse_mass = c.inverse_mass;
            extremes.collision_effective_mass = c.effective_mass;
            extremes.collision_identifiers = *identifiers;
            extremes.collision_types = types.map(|t| t as i32);
        }
        extremes
    }
}

/// The masses of the first `count` particles.
struct Masses<'a> {
    own: &'a [f64],
    of_contacts: &'a [f64],
}

impl<'a> Masses<'a> {
    /// # Safety
    /// `masses` and `contact_masses` are NULL or have `count` entries, for the lifetime that the caller gives them.
    unsafe fn new(p: &EllgranParticles, count: usize) -> Result<Self, Failure> {
        // SAFETY: promised by the caller.
        let own = unsafe { slice(p.masses, count, "masses") }?;
        let of_contacts = if p.contact_masses.is_null() {
            own
        } else {
            // SAFETY: promised by the caller.
            unsafe { slice(p.contact_masses, count, "contact_masses") }?
        };
        for (masses, name) in [(own, "mass"), (of_contacts, "contact mass")] {
            for (k, mass) in masses.iter().enumerate() {
                ranges::inverse_mass(*mass, name).map_err(|what| {
                    Failure::new(
                        ELLGRAN_ERROR_PARTICLE,
                        format!("particle {}: {what}", identifier(p, k)),
                    )
                })?;
            }
        }
        Ok(Masses { own, of_contacts })
    }

    /// Inverse of the mass that moves; 0 for a fixed particle.
    fn inverse(&self, k: usize) -> f64 {
        if self.of_contacts[k].is_finite() {
            1.0 / self.own[k]
        } else {
            0.0
        }
    }

    /// The mass against a wall, 0 for a fixed particle.
    fn at_wall(&self, k: usize) -> f64 {
        Some(self.of_contacts[k])
            .filter(|m| m.is_finite())
            .unwrap_or(0.0)
    }
}

/// Adds what the touching pairs of a neighbour list contribute to a bound of the stable step of their particles to `sums`,
/// [count][ELLGRAN_STEP_SUMS_LENGTH], and what is extreme among them to `extremes`, which may be NULL.
///
/// Zero the sums before the first call for a step; those of several lists and of walls add. With `newton` = 1 add the sums of ghosts to
/// those of their owners; with `newton` = 0 ignore them. Then ask `ellgran_stable_step`.
///
/// `masses` are needed: each particle moves as a solid ellipsoid of this mass. INFINITY in `masses` or in `contact_masses` makes a particle
/// fixed. Other `contact_masses` are read by the law alone. So a particle in a rigid body counts here with its own mass, which is safe: the
/// rigid body is slower. Forces, histories and the step are not read. The call allocates when a workspace is used for the first time;
/// do not use one that keeps histories of a list.
///
/// # Safety
/// The pointers are NULL or valid; the arrays are as `EllgranParticles`, `EllgranNeighbourList` and this comment state.
#[no_mangle]
pub unsafe extern "C" fn ellgran_add_pairs_to_step_sums(
    laws: *const EllgranLaws,
    workspace: *mut EllgranWorkspace,
    particles: *const EllgranParticles,
    list: *const EllgranNeighbourList,
    sums: *mut f64,
    extremes: *mut EllgranContactExtremes,
) -> i32 {
    at_border("ellgran_add_pairs_to_step_sums", || {
        // SAFETY: promised by the caller, for all of this function.
        let (laws, workspace) = unsafe { handles(laws, workspace) }?;
        // SAFETY: `particles` is NULL or valid for reads, by this function's safety section.
        let p = &*unsafe { given(particles, "particles") }?;
        // SAFETY: `list` is NULL or valid for reads, by this function's safety section.
        let list = &*unsafe { given(list, "list") }?;
        // SAFETY: `extremes` is NULL or valid for reads and writes, and not aliased, by this function's safety section.
        let (mut found, mut out) = unsafe { asked(extremes) }?;
        // SAFETY: `sums` is NULL or has so many doubles for each particle, and is not aliased, by this function's safety section.
        let sums = unsafe { slice_mut(sums.cast::<StepSums>(), p.count, "sums") }?;
        if workspace.has_unwritten_history() {
            return Err(argument(
                "the workspace keeps histories of a list: give this call a workspace of its own"
                    .into(),
            ));
        }
        // SAFETY: the arrays are as `EllgranParticles` demands.
        let masses = unsafe { Masses::new(p, p.count) }?;
        // SAFETY: the arrays are as `EllgranNeighbourList` demands.
        let mut rows = unsafe { pairs_of(list, p.count) }?;
        // SAFETY: the arrays of `particles` are NULL or as long as its counts say, as `EllgranParticles` demands.
        unsafe { prepare(p, p.count, Some(laws), workspace, Purpose::SingleContacts) }?;
        add_pairs_to_step_sums(
            laws,
            workspace.particles(),
            &|k| masses.inverse(k),
            &|k| identifier(p, k),
            &mut rows,
            sums,
            &mut found,
        )
        .map_err(|e| list_failure(p, list, e))?;
        if let Some(out) = &mut out {
            out.write(&EllgranContactExtremes::of(&found));
        }
        Ok(())
    })
}

/// The same for the contacts with a wall that `ellgran_find_wall_contacts` found in the last call with this workspace and these particles.
/// `wall_types` has the type of the wall at each of them, [ellgran_wall_found_count]; `sums` are those of the owned particles,
/// [owned_count][ELLGRAN_STEP_SUMS_LENGTH]. The motion of the wall is prescribed: forces do not change it.
///
/// # Safety
/// The pointers are NULL or valid; the arrays are as stated here and in `EllgranParticles`.
#[no_mangle]
pub unsafe extern "C" fn ellgran_add_wall_to_step_sums(
    laws: *const EllgranLaws,
    workspace: *mut EllgranWorkspace,
    wall: *const EllgranWall,
    particles: *const EllgranParticles,
    wall_types: *const i32,
    sums: *mut f64,
    extremes: *mut EllgranContactExtremes,
) -> i32 {
    at_border("ellgran_add_wall_to_step_sums", || {
        // SAFETY: promised by the caller, for all of this function.
        let (laws, workspace) = unsafe { handles(laws, workspace) }?;
        // SAFETY: `wall` is NULL or valid for reads, by this function's safety section.
        let EllgranWall { wall, names } = unsafe { required(wall, "wall") }?;
        // SAFETY: `particles` is NULL or valid for reads, by this function's safety section.
        let p = &*unsafe { given(particles, "particles") }?;
        // SAFETY: `extremes` is NULL or valid for reads and writes, and not aliased, by this function's safety section.
        let (mut found, mut out) = unsafe { asked(extremes) }?;
        let owned = p.owned_count;
        // SAFETY: `sums` is NULL or has so many doubles for each owned particle, and is not aliased, by this function's safety section.
        let sums = unsafe { slice_mut(sums.cast::<StepSums>(), owned, "sums") }?;
        let count = names.len();
        // SAFETY: `wall_types` is NULL or has a type for each contact, by this function's safety section.
        let types = unsafe { slice(wall_types, count, "wall_types") }?;
        let near = workspace.particles();
        let all = wall.found().all();
        if all.len() != count
            || all
                .iter()
                .any(|c| c.particle >= owned || c.near >= near.len())
        {
            return Err(argument(
                "the contacts of the wall were not found with these particles: call ellgran_find_wall_contacts first".into(),
            ));
        }
        for t in types {
            in_table(*t, laws, "wall_types has")?;
        }
        for c in all {
            in_table(
                near[c.near].particle_type as i32,
                laws,
                "a particle at the wall has",
            )?;
        }
        // SAFETY: the arrays are as `EllgranParticles` demands.
        let masses = unsafe { Masses::new(p, owned) }?;
        wall.add_to_step_sums(
            laws,
            near,
            &|number| types[number] as usize,
            &|k| WallMasses {
                inverse_mass: masses.inverse(k),
                effective_mass: masses.at_wall(k),
            },
            &|k| identifier(p, k),
            sums,
            &mut found,
        )
        .map_err(|(k, ratio)| hale_failure(identifier(p, k), None, ratio))?;
        if let Some(out) = &mut out {
            out.write(&EllgranContactExtremes::of(&found));
        }
        Ok(())
    })
}

fn in_table(particle_type: i32, laws: &Laws, what: &str) -> Result<(), Failure> {
    if (1..=laws.types() as i32).contains(&particle_type) {
        return Ok(());
    }
    Err(argument(format!(
        "{what} type {particle_type}, which is not between 1 and {}",
        laws.types()
    )))
}

/// What was added to extremes before, and where to write them.
///
/// # Safety
/// `extremes` is NULL or valid for reads and writes, and not aliased, for the lifetime that the caller gives it.
unsafe fn asked<'a>(
    extremes: *mut EllgranContactExtremes,
) -> Result<(ContactExtremes, Option<Output<'a, EllgranContactExtremes>>), Failure> {
    if extremes.is_null() {
        return Ok((ContactExtremes::default(), None));
    }
    // SAFETY: promised by the caller; what is read is copied before it is written.
    unsafe {
        let before = (*given(extremes, "extremes")?).to_core();
        Ok((before, Output::optional(extremes, "extremes")?))
    }
}

/// The largest time step that is stable by the sums of all contacts, [count][ELLGRAN_STEP_SUMS_LENGTH], and to `limiting` (which may be
/// NULL) the index of the particle that limits it. INFINITY, and -1, where nothing touches. The minimum of several ranks is that of the whole.
///
/// With it, velocity Verlet with damping by the velocities of the half step does not let small motions about the present state grow, friction
/// that does not slip, rotations, lever arms and viscosity included. It is exact at walls and for two equal bodies that meet in their
/// stiffest directions, and below the true limit elsewhere: by a tenth to a fifth in packings, by up to a third for overdamped contacts
/// (docs/theory.md, section 8). Left out are the rotation of the normal, smaller by the penetration over the radii of curvature; that
/// contacts become deeper, and so stiffer; and contacts that slide.
///
/// # Safety
/// The pointers are NULL or valid; `sums` has so many doubles.
#[no_mangle]
pub unsafe extern "C" fn ellgran_stable_step(
    sums: *const f64,
    count: usize,
    step: *mut f64,
    limiting: *mut i64,
) -> i32 {
    at_border("ellgran_stable_step", || {
        // SAFETY: `sums` is NULL or has so many doubles for each particle, by this function's safety section.
        let sums = unsafe { slice(sums.cast::<StepSums>(), count, "sums") }?;
        // SAFETY: `step` is NULL or valid for writes, and not aliased, by this function's safety section.
        let step = unsafe { required_mut(step, "step") }?;
        for (k, of_particle) in sums.iter().enumerate() {
            if let Some((place, value)) = of_particle
                .iter()
                .enumerate()
                .find(|(_, value)| !value.is_finite())
            {
                return Err(argument(format!(
                    "sums[{k}][{place}] = {} is not finite",
                    Number(*value)
                )));
            }
        }
        let (least, index) = least_stable_step(sums);
        *step = least;
        // SAFETY: `limiting` is NULL or valid for writes, and not aliased, by this function's safety section.
        if let Some(limiting) = unsafe { limiting.as_mut() } {
            *limiting = index.map_or(-1, |k| k as i64);
        }
        Ok(())
    })
}

/// The longest time step with which the shortest collision of `extremes` ends with the right kinetic energy to `error`, from 1e-6 to 0.5, as a
/// part of the energy with which it began: the root of the mean square over first touches anywhere within a step, of a central impact by
/// velocity Verlet with velocities of the half step, which this call integrates. INFINITY where there is no collision. Friction and rotation are not
/// in it: a collision with friction errs by up to a few times as much. The call takes some milliseconds where `error` is small.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_step_for_error(
    laws: *const EllgranLaws,
    extremes: *const EllgranContactExtremes,
    error: f64,
    step: *mut f64,
) -> i32 {
    at_border("ellgran_step_for_error", || {
        // SAFETY: promised by the caller, for all of this function.
        let laws = &unsafe { required(laws, "laws") }?.laws;
        // SAFETY: `extremes` is NULL or valid for reads, by this function's safety section.
        let extremes = unsafe { given(extremes, "extremes") }?;
        // SAFETY: `step` is NULL or valid for writes, and not aliased, by this function's safety section.
        let step = unsafe { required_mut(step, "step") }?;
        if !(1e-6..=0.5).contains(&error) {
            return Err(argument(format!(
                "error = {} must be from 1e-6 to 0.5",
                Number(error)
            )));
        }
        let c = extremes.collision();
        if c.time == 0.0 {
            *step = f64::INFINITY;
            return Ok(());
        }
        for value in [c.time, c.speed, c.stiffness, c.inverse_mass] {
            if !(value.is_finite() && value > 0.0) {
                return Err(argument(format!(
                    "the shortest collision of extremes has {}, which must be finite and greater than 0",
                    Number(value)
                )));
            }
        }
        let [i, j] = extremes.collision_types;
        for t in [i, j] {
            in_table(t, laws, "collision_types has")?;
        }
        *step = step_for_error(laws.get(i as usize, j as usize), &c, error);
        Ok(())
    })
}
