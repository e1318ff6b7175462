// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contacts of all particles with a wall, for engines that keep their meshes, and whose own contact models compute the forces.

use super::growing::{given, growing, Output};
use super::particles::{identifier, EllgranParticles, EllgranWorkspace};
use super::rigid_wall::{
    chosen, motion_of, prepare_near, wall_history_failure, wrong, EllgranWall, EllgranWallMotion,
};
use super::staged::{checked_share, EllgranStagedContact, EllgranStagedGeometry};
use super::status::{at_border, required, required_mut, slice, slice_mut, Failure};
use crate::contact::Step;
use crate::vector::Vector3;
use crate::walls::{FoundContact, Frame, Places, StagedInWorld, Wall};

/// Triangles that an engine keeps and moves itself, as they are in this step: one part of a wall, after its others.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranLentTriangles {
    /// `sizeof(EllgranLentTriangles)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// Number of triangles.
    pub count: usize,
    /// [count][3][3]: their corners; components up to 1e20.
    pub corners: *const f64,
    /// [count][3][3]: velocities of the corners, up to 1e25; NULL for triangles at rest.
    pub velocities: *const f64,
    /// Number of particles that have a list of triangles near them, the first of all; the others are near none.
    pub particle_count: usize,
    /// [particle_count + 1]: where in `near` the list of a particle begins; the last is the length of `near`.
    pub near_starts: *const usize,
    /// Indices of triangles: all that a particle may touch, and those that meet them, since an edge whose other triangle is missing counts as
    /// free. The order in each list is that in which contacts are found. Of a flat piece that goes on, those to a distance of the largest semi-axis
    /// are to be lent to one particle at least: how wide it is is taken from all that are lent.
    pub near: *const u32,
    /// [count][3][3]: what the velocities of the corners at the step have more than `velocities`, up to 1e25, read where particles come with
    /// `velocity_changes`; NULL where they are the same.
    pub velocity_changes: *const f64,
}

growing!(EllgranLentTriangles, near: *const u32);

/// A contact that `ellgran_find_wall_contacts` found.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranFoundWallContact {
    /// `sizeof(EllgranFoundWallContact)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// Index of the particle.
    pub particle: usize,
    /// Index of the wall's part.
    pub part: usize,
    /// Index of the triangle of that part that represents the contact; 0 where it has none.
    pub triangle: usize,
    /// The point of the surface that lies deepest in the particle, world frame.
    pub point: [f64; 3],
    /// Velocity of the surface there.
    pub velocity: [f64; 3],
    /// 1 if the contact existed at the last step.
    pub touched: i32,
    /// 1 if it begins anew in each step, since the histories have no room for as many contacts of one particle.
    pub is_forgotten: i32,
    /// Normal from the particle into the wall at the last step, if `touched`.
    pub last_normal: [f64; 3],
    /// What the contact model keeps of it, `history_length` doubles, zeros for a new contact, to be changed in place; valid until the next
    /// call with this wall. NULL if there are none.
    pub history: *mut f64,
}

growing!(EllgranFoundWallContact);

/// Lends triangles to a wall in place of those before. Together they are one surface that acts to both sides, as that of
/// `ellgran_wall_add_triangles`. They are copied; all are described in the place where the wall has not yet moved.
///
/// # Safety
/// The pointers are NULL or valid; the arrays are as `EllgranLentTriangles` states.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_lend_triangles(
    wall: *mut EllgranWall,
    triangles: *const EllgranLentTriangles,
) -> i32 {
    at_border("ellgran_wall_lend_triangles", || {
        // SAFETY: promised by the caller, for all of this function.
        let wall = &mut unsafe { required_mut(wall, "wall") }?.wall;
        // SAFETY: `triangles` is NULL or valid for reads, by this function's safety section.
        let t = unsafe { given(triangles, "triangles") }?;
        let of_corners = |pointer: *const f64, count, name| {
            // SAFETY: `pointer` is one of the caller's arrays, NULL or with `count` entries, as its struct demands.
            unsafe { slice(pointer.cast::<[[f64; 3]; 3]>(), count, name) }
                .map(|all| all.iter().map(|t| t.map(Vector3::from_array)))
        };
        let corners = of_corners(t.corners, t.count, "corners")?;
        let moving = if t.velocities.is_null() { 0 } else { t.count };
        let velocities = of_corners(t.velocities, moving, "velocities")?;
        let changing = if t.velocity_changes.is_null() {
            0
        } else {
            t.count
        };
        let changes = of_corners(t.velocity_changes, changing, "velocity_changes")?;
        let starts = match t.particle_count {
            0 => &[],
            // SAFETY: `near_starts` is NULL or valid for reads of `count + 1` elements, as `EllgranLentTriangles`
            // demands.
            count => unsafe { slice(t.near_starts, count + 1, "near_starts") }?,
        };
        let length = starts.last().copied().unwrap_or(0);
        // SAFETY: `near` is NULL or valid for reads of `length` elements, as `EllgranLentTriangles` demands.
        let near = unsafe { slice(t.near, length, "near") }?;
        wall.lent_triangles()
            .set(corners, velocities, changes, starts, near)
            .map_err(wrong)
    })
}

/// Doubles that a caller keeps for each particle of what is remembered of its contacts with a wall, where a contact model of the
/// engine keeps `history_length` doubles of each contact; 0 for NULL and without a history.
///
/// # Safety
/// `wall` is NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_found_histories_length(
    wall: *const EllgranWall,
    history_length: usize,
) -> usize {
    // SAFETY: promised by the caller.
    unsafe { wall.as_ref() }.map_or(0, |w| w.wall.histories_of(history_length).length())
}

/// Finds the contacts of all owned particles with a wall, and what is remembered of each: what `ellgran_compute_wall` does before it
/// computes forces. Then `ellgran_wall_found` describes each of them, `ellgran_staged_found` prepares it for the force, and
/// `ellgran_remember_wall_contacts` writes the histories.
///
/// Masses and forces of the particles are not read; types are any from 1. `masks`, `group_mask` and `motion` are those of
/// `ellgran_compute_wall`. `histories` is [owned_count][`ellgran_wall_found_histories_length`] (NULL if that is 0), set to 0 by the caller
/// before a particle's first call, and is not written here. The histories are the engine's own: where the wall turns, it is the engine that turns
/// them.
///
/// # Safety
/// The pointers are NULL or valid; the arrays are as stated here and in `EllgranParticles`.
#[no_mangle]
#[allow(clippy::too_many_arguments)]
pub unsafe extern "C" fn ellgran_find_wall_contacts(
    workspace: *mut EllgranWorkspace,
    wall: *mut EllgranWall,
    particles: *const EllgranParticles,
    masks: *const i32,
    group_mask: i32,
    motion: *const EllgranWallMotion,
    history_length: usize,
    histories: *const f64,
) -> i32 {
    at_border("ellgran_find_wall_contacts", || {
        // SAFETY: promised by the caller, for all of this function.
        let workspace = &mut unsafe { required_mut(workspace, "workspace") }?.workspace;
        // SAFETY: `wall` is NULL or valid for reads and writes, and not aliased, by this function's safety section.
        let EllgranWall { wall, names } = unsafe { required_mut(wall, "wall") }?;
        names.clear();
        // SAFETY: `particles` is NULL or valid for reads, by this function's safety section.
        let p = &EllgranParticles {
            // It speaks of the last call of `ellgran_compute_wall`.
            unchanged: 0,
            ..*unsafe { given(particles, "particles") }?
        };
        // SAFETY: `motion` is NULL or valid for reads, by this function's safety section.
        let motion = unsafe { motion_of(motion) }?;
        // SAFETY: `masks` is NULL or has an element for each owned particle, by this function's safety section.
        let acts_on = unsafe { chosen(masks, group_mask, p.owned_count) }?;
        let layout = wall.histories_of(history_length);
        // SAFETY: `histories` is NULL or valid for reads of `p.owned_count * layout.length()` elements, by this
        // function's safety section.
        let histories = unsafe { slice(histories, p.owned_count * layout.length(), "histories") }?;
        // SAFETY: the arrays of `particles` are NULL or as long as its counts say, as `EllgranParticles` demands.
        let prepared = unsafe { prepare_near(p, wall, workspace, None, &motion, &acts_on, None) };
        // The particles of this call need not be those of `ellgran_compute_wall`.
        wall.forget_particles();
        prepared?;
        let places = Places {
            near: workspace.particles(),
            motion: &motion,
            // places alone are asked for
            step: &Step {
                time_step: 0.0,
                advance_history: false,
            },
            frame: Frame::World,
        };
        wall.check_histories(layout, None, histories)
            .map_err(|e| wall_history_failure(p, &e))?;
        wall.find_contacts(&places, layout, histories);
        names.extend(wall.found().all().iter().map(|c| identifier(p, c.particle)));
        Ok(())
    })
}

/// Number of contacts that were found last; 0 for NULL.
///
/// # Safety
/// `wall` is NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_found_count(wall: *const EllgranWall) -> usize {
    // SAFETY: promised by the caller.
    unsafe { wall.as_ref() }.map_or(0, |w| w.names.len())
}

fn contact(
    wall: &Wall,
    index: usize,
    count: usize,
) -> Result<(&FoundContact, &StagedInWorld), Failure> {
    let found = wall.found();
    let of_index = found.all().get(index).zip(found.staged().get(index));
    of_index
        .filter(|_| index < count)
        .ok_or_else(|| wrong(format!("index = {index} is not one of {count} contacts")))
}

/// One of the contacts that were found last, in the order of the particles.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_found(
    wall: *mut EllgranWall,
    index: usize,
    found: *mut EllgranFoundWallContact,
) -> i32 {
    at_border("ellgran_wall_found", || {
        // SAFETY: promised by the caller, for all of this function.
        let EllgranWall { wall, names } = unsafe { required_mut(wall, "wall") }?;
        // SAFETY: `found` is NULL or valid for reads and writes, and not aliased, by this function's safety section.
        let mut out = unsafe { Output::new(found, "found") }?;
        let (c, staged) = contact(wall, index, names.len())?;
        let (c, surface) = (*c, staged.surface);
        let history = wall.found_mut().history(index);
        out.write(&EllgranFoundWallContact {
            size: size_of::<EllgranFoundWallContact>(),
            particle: c.particle,
            part: c.part,
            triangle: c.triangle,
            point: surface.point.to_array(),
            velocity: surface.velocity.to_array(),
            touched: i32::from(c.last_normal.is_some()),
            is_forgotten: i32::from(
                !c.is_remembered && !history.is_empty() && c.surface.share.value == 1.0,
            ),
            last_normal: c.last_normal.unwrap_or_default().to_array(),
            history: if history.is_empty() {
                core::ptr::null_mut()
            } else {
                history.as_mut_ptr()
            },
        });
        Ok(())
    })
}

/// First stage, a contact that `ellgran_find_wall_contacts` found; otherwise like `ellgran_staged_pair`.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_staged_found(
    staged: *mut EllgranStagedContact,
    wall: *const EllgranWall,
    index: usize,
    share_i: f64,
    geometry: *mut EllgranStagedGeometry,
) -> i32 {
    at_border("ellgran_staged_found", || {
        // SAFETY: promised by the caller, for all of this function.
        let staged = unsafe { required_mut(staged, "staged") }?;
        // SAFETY: `wall` is NULL or valid for reads, by this function's safety section.
        let EllgranWall { wall, names } = unsafe { required(wall, "wall") }?;
        // SAFETY: `geometry` is NULL or valid for reads and writes, and not aliased, by this function's safety
        // section.
        let mut out = unsafe { Output::new(geometry, "geometry") }?;
        let share_i = checked_share(share_i)?;
        let (_, found) = contact(wall, index, names.len())?;
        staged.contact = Some(found.contact);
        staged.identifiers = (names[index], None);
        staged.write(found.position, share_i, &mut out);
        Ok(())
    })
}

/// Writes the histories of the contacts that were found last, as the contact model has changed them, to `histories`. The particles, `masks`
/// and `group_mask` are those of that call. The histories of particles that do not touch become 0.
///
/// # Safety
/// The pointers are NULL or valid; `histories` has `owned_count` times as many doubles as in `ellgran_find_wall_contacts`.
#[no_mangle]
pub unsafe extern "C" fn ellgran_remember_wall_contacts(
    wall: *const EllgranWall,
    owned_count: usize,
    masks: *const i32,
    group_mask: i32,
    histories: *mut f64,
) -> i32 {
    at_border("ellgran_remember_wall_contacts", || {
        // SAFETY: promised by the caller, for all of this function.
        let found = unsafe { required(wall, "wall") }?.wall.found();
        // SAFETY: `masks` is NULL or has an element for each owned particle, by this function's safety section.
        let acts_on = unsafe { chosen(masks, group_mask, owned_count) }?;
        let length = owned_count * found.histories_length();
        if let Some(c) = found.all().last().filter(|c| c.particle >= owned_count) {
            return Err(wrong(format!(
                "owned_count = {owned_count}: there is a contact of particle {}",
                c.particle
            )));
        }
        // SAFETY: `histories` is NULL or valid for reads and writes of `length` elements, and not aliased, by this
        // function's safety section.
        found.remember(
            unsafe { slice_mut(histories, length, "histories") }?,
            &acts_on,
        );
        Ok(())
    })
}
