// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rigid walls of any shape against all owned particles in one call.

use super::growing::{given, growing, Output};
use super::law::{check_type, given_words, EllgranLaws};
use super::particles::{
    check_strides, hale_failure, handles, history_failure, identifier, prepare, shape_of,
    EllgranParticles, EllgranStep, EllgranWorkspace, Purpose,
};
use super::status::{
    at_border, required, required_mut, slice, slice_mut, Failure, ELLGRAN_ERROR_ARGUMENT,
    ELLGRAN_ERROR_NULL_POINTER, ELLGRAN_ERROR_TEXT,
};
use super::tallies::{
    add_half_step_at_wall, add_preceding_half_step, borrow, check_half_step,
    check_half_step_at_wall, respond_at_wall, Asked, EllgranTallies,
};
use crate::contact::ranges::{self, LARGEST_COORDINATE, LARGEST_VELOCITY};
use crate::contact::Laws;
use crate::geometry::triangles::Triangle;
use crate::list::{PreparedBy, Workspace};
use crate::message::{Number, Numbers};
use crate::tallies::Tallies;
use crate::vector::Vector3;
use crate::walls::{
    compute_wall, compute_wall_in_lanes, flatten_triangles, shape_has_axis, stl,
    write_triangle_loads, End, Mesh, Motion, PeriodicBox, RecordsInput, ShapeParameters,
    ShapeWords, Side, TriangleLoad, Wall, WallError, WallInput, WallOutput, WrongHistory,
};
use core::ffi::c_char;
use core::ffi::CStr;

/// The particles are on the side of a surface on which their centres are.
pub const ELLGRAN_SIDE_OF_CENTRE: i32 = 0;
/// The particles are within the shape; for a plane, on the side of its normal.
pub const ELLGRAN_SIDE_INSIDE: i32 = 1;
/// The particles are outside the shape; for a plane, on the side opposite to its normal.
pub const ELLGRAN_SIDE_OUTSIDE: i32 = 2;

/// The surface has no edge where it ends, or does not end.
pub const ELLGRAN_END_NONE: i32 = 0;
/// Ends in an edge: particles pass through, and over the edge.
pub const ELLGRAN_END_OPEN: i32 = 1;
/// Ends in a flat disc.
pub const ELLGRAN_END_CLOSED: i32 = 2;

/// A rigid wall: parts of any shape that move as one. Opaque; belongs to one thread at a time.
pub struct EllgranWall {
    pub(super) wall: Wall,
    /// What to call the particle of each contact that was found.
    pub(super) names: Vec<i64>,
}

impl EllgranWall {
    /// The wall itself. Public for the border of `gpu/driver`; no interface for others.
    #[doc(hidden)]
    pub fn parts(&self) -> &Wall {
        &self.wall
    }
}

/// A shape, described in the place where the wall has not yet moved. What a shape does not need is not read.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranWallShape {
    /// `sizeof(EllgranWallShape)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// "plane", "cylinder", "cone" or "sphere".
    pub name: *const c_char,
    /// A point of a plane, the centre of a sphere, a point of the axis of a cylinder or a cone; components up to 1e20.
    pub point: [f64; 3],
    /// Normal of a plane, axis of a cylinder or a cone; any length but zero.
    pub axis: [f64; 3],
    /// Radius of a sphere or a cylinder, the first; those of a cone at its two bounds.
    pub radii: [f64; 2],
    /// Where a cylinder or a cone begins and ends, along the axis from `point`. Both 0: a cylinder without ends.
    pub bounds: [f64; 2],
    /// How it ends there, `ELLGRAN_END_...`.
    pub ends: [i32; 2],
    /// Where the particles are, `ELLGRAN_SIDE_...`.
    pub side: i32,
    /// Must be 0.
    pub unused: i32,
}

growing!(EllgranWallShape);

/// Pose and motion of a wall. Zeros: at rest, where its shapes were described.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranWallMotion {
    /// `sizeof(EllgranWallMotion)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// The point about which the wall has turned, where it was when the shapes were described.
    pub origin: [f64; 3],
    /// How far that point has moved since.
    pub displacement: [f64; 3],
    /// Rotation of the wall since then, (w, x, y, z), of any length; zeros: none.
    pub quaternion: [f64; 4],
    /// Velocity of the point: over a step, its displacement in the step by the time step.
    pub velocity: [f64; 3],
    /// Angular velocity, world frame, likewise.
    pub angular_velocity: [f64; 3],
    /// Not 0 for a surface that moves along itself, as a cylinder that turns about its axis: its matter has these velocities, and it
    /// stays where it is. `displacement` and `quaternion` are then 0, and what is remembered of a contact is in the frame of the world.
    pub along_itself: i32,
    /// Must be 0.
    pub unused: i32,
    /// What the velocity of the point at the step, when forces are computed, has more than `velocity`. Read where particles come with
    /// `velocity_changes`, for the viscous forces, as these are. 0 where it is not known.
    pub velocity_change: [f64; 3],
    /// Likewise of the angular velocity.
    pub angular_velocity_change: [f64; 3],
}

growing!(EllgranWallMotion, angular_velocity: [f64; 3]);

/// What the particles of a call do to a wall.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranWallLoad {
    /// `sizeof(EllgranWallLoad)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// Force on the wall, world frame.
    pub force: [f64; 3],
    /// Torque on the wall about `origin + displacement` of its motion, world frame.
    pub torque: [f64; 3],
    /// Power that the particles give to the wall by its motion; minus it is the power of the wall on the particles.
    pub power: f64,
    /// Number of contacts.
    pub contact_count: i64,
    /// Sum over the contacts of a bound of their stiffness in any direction, force/length, friction without slip included: by at most
    /// that the force changes with a displacement of the wall.
    pub stiffness: f64,
    /// The same of their damping, force x time/length.
    pub damping: f64,
    /// 1 + index of a particle that touches the wall in more places than are remembered: at some of them friction begins anew in each
    /// step. 0 for none.
    pub crowded_particle: i64,
    /// With `ellgran_wall_keep_inelastic_loads`, else 0: the viscous force on the wall, which is a part of `force`.
    pub viscous_force: [f64; 3],
    /// Its torque about the same point; 0 where the wall does not turn.
    pub viscous_torque: [f64; 3],
    /// Likewise the tangential force without its viscous part.
    pub tangential_force: [f64; 3],
    /// Its torque.
    pub tangential_torque: [f64; 3],
}

growing!(EllgranWallLoad, damping);

/// One contact of a wall as it acted in the last call that recorded contacts.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranRecordedWallContact {
    /// `sizeof(EllgranRecordedWallContact)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// Index of the particle.
    pub particle: usize,
    /// Index of the wall's part.
    pub part: usize,
    /// Contact point, world frame.
    pub point: [f64; 3],
    /// Unit normal out of the wall, towards the particle, world frame.
    pub normal: [f64; 3],
    /// Penetration > 0.
    pub penetration: f64,
    /// Normal force, elastic and viscous; positive where it pushes the particle away.
    pub normal_force: f64,
    /// Tangential force on the particle, world frame.
    pub tangential_force: [f64; 3],
    /// Force on the particle, world frame.
    pub force: [f64; 3],
    /// Torque on the particle about its centre, world frame.
    pub torque: [f64; 3],
    /// Elastic energy of the normal and of the tangential deformation.
    pub elastic_energy: [f64; 2],
}

growing!(EllgranRecordedWallContact);

pub(super) fn wrong(what: impl Into<String>) -> Failure {
    Failure::new(ELLGRAN_ERROR_ARGUMENT, what)
}

fn check_part(wall: &Wall, part: usize) -> Result<(), Failure> {
    let count = wall.part_count();
    if part < count {
        return Ok(());
    }
    Err(wrong(format!(
        "part = {part} is not one of the {count} parts of the wall"
    )))
}

impl EllgranWallShape {
    fn add_to(self, wall: &mut Wall, name: &str) -> Result<(), Failure> {
        let parameters = self.to_core()?;
        // An unknown name is told of below.
        if parameters.axis == Vector3::ZERO && shape_has_axis(name) {
            return Err(wrong(format!(
                "wall shape '{name}': axis = 0 0 0 has no direction"
            )));
        }
        wall.add_shape(name, &parameters).map_err(wrong)
    }

    fn to_core(self) -> Result<ShapeParameters, Failure> {
        if self.unused != 0 {
            return Err(wrong("wall shape: unused must be 0"));
        }
        let end = |k: usize| match self.ends[k] {
            ELLGRAN_END_NONE => Ok(End::None),
            ELLGRAN_END_OPEN => Ok(End::Open),
            ELLGRAN_END_CLOSED => Ok(End::Closed),
            other => Err(wrong(format!(
                "wall shape: ends[{k}] = {other} is not one of ELLGRAN_END_..."
            ))),
        };
        let axis = Vector3::from_array(self.axis);
        let bounds = if self.bounds == [0.0; 2] {
            [f64::NEG_INFINITY, f64::INFINITY]
        } else {
            self.bounds
        };
        Ok(ShapeParameters {
            point: ranges::vector(self.point, LARGEST_COORDINATE, "wall shape: point")
                .map_err(wrong)?,
            axis: match axis.direction() {
                Some(axis) => axis,
                // not read by a sphere
                None if self.axis == [0.0; 3] => Vector3::ZERO,
                None => {
                    return Err(wrong(format!(
                        "wall shape: axis = {} has no direction",
                        Numbers(&self.axis)
                    )))
                }
            },
            radii: self.radii,
            bounds,
            ends: [end(0)?, end(1)?],
            side: match self.side {
                ELLGRAN_SIDE_OF_CENTRE => Side::OfCentre,
                ELLGRAN_SIDE_INSIDE => Side::Inside,
                ELLGRAN_SIDE_OUTSIDE => Side::Outside,
                other => {
                    return Err(wrong(format!(
                        "wall shape: side = {other} is not one of ELLGRAN_SIDE_..."
                    )))
                }
            },
        })
    }
}

impl EllgranWallMotion {
    fn to_core(self) -> Result<Motion, Failure> {
        let place = |v, name| ranges::vector(v, LARGEST_COORDINATE, name).map_err(wrong);
        let velocity = |v, name| ranges::vector(v, LARGEST_VELOCITY, name).map_err(wrong);
        let square: f64 = self.quaternion.iter().map(|q| q * q).sum();
        let axes = if self.quaternion == [0.0; 4] {
            None
        } else if (1e-200..=1e200).contains(&square) {
            Motion::axes_of(self.quaternion)
        } else {
            return Err(wrong(format!(
                "wall motion: quaternion = {} has no direction",
                Numbers(&self.quaternion)
            )));
        };
        if self.unused != 0 {
            return Err(wrong("wall motion: unused must be 0"));
        }
        let along_itself = self.along_itself != 0;
        if along_itself && (axes.is_some() || self.displacement != [0.0; 3]) {
            return Err(wrong(
                "wall motion: a wall with along_itself stays where it is: displacement and quaternion must be 0",
            ));
        }
        Ok(Motion {
            origin: place(self.origin, "wall motion: origin")?,
            displacement: place(self.displacement, "wall motion: displacement")?,
            axes,
            velocity: velocity(self.velocity, "wall motion: velocity")?,
            angular_velocity: velocity(self.angular_velocity, "wall motion: angular_velocity")?,
            velocity_change: velocity(self.velocity_change, "wall motion: velocity_change")?,
            angular_velocity_change: velocity(
                self.angular_velocity_change,
                "wall motion: angular_velocity_change",
            )?,
            along_itself,
        })
    }
}

/// A wall without parts.
///
/// # Safety
/// `wall` is NULL or valid for writes.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_new(wall: *mut *mut EllgranWall) -> i32 {
    at_border("ellgran_wall_new", || {
        // SAFETY: promised by the caller.
        let out = unsafe { required_mut(wall, "wall") }?;
        *out = Box::into_raw(Box::new(EllgranWall {
            wall: Wall::new(),
            names: Vec::new(),
        }));
        Ok(())
    })
}

/// Frees a wall; NULL is allowed.
///
/// # Safety
/// `wall` is NULL or came from `ellgran_wall_new` and is not used again.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_free(wall: *mut EllgranWall) {
    if !wall.is_null() {
        // SAFETY: promised by the caller.
        drop(unsafe { Box::from_raw(wall) });
    }
}

/// Adds a shape to a wall. A cylinder or a cone is one part, with parts of their own for its flat ends and then for the rims of its
/// ends; as a solid with a flat end, particles outside, it is one part in all. After it, histories that a caller keeps are those of another wall: set them to 0.
///
/// # Safety
/// The pointers are NULL or valid; `shape->name` ends with NUL.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_add_shape(
    wall: *mut EllgranWall,
    shape: *const EllgranWallShape,
) -> i32 {
    at_border("ellgran_wall_add_shape", || {
        // SAFETY: promised by the caller, for all of this function.
        let wall = &mut unsafe { required_mut(wall, "wall") }?.wall;
        // SAFETY: `shape` is NULL or valid for reads, by this function's safety section.
        let shape = unsafe { given(shape, "shape") }?;
        // SAFETY: `shape.name` is NULL or a text that ends with NUL, by this function's safety section.
        let name = unsafe { text(shape.name, "wall shape: name") }?;
        shape.add_to(wall, name)
    })
}

/// Adds a shape to a wall that the words of a deck describe, those that follow `shape`: its name, then in any order
///
/// - `point x y z`
/// - `axis ax ay az`
/// - `radius r`
/// - `radii r1 r2`
/// - `bounds lo hi`
/// - `ends`, and for each of two ends `none`, `open` or `closed`
/// - `side`, and `inside`, `outside` or `centre`
///
/// The fields of `EllgranWallShape` by their names; `axis` is z where it is not given. Reading ends at the first word that is none of these:
/// `consumed` receives how many were read.
///
/// # Safety
/// The pointers are NULL or valid; `words` points to `word_count` strings that end with NUL.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_add_shape_words(
    wall: *mut EllgranWall,
    word_count: usize,
    words: *const *const c_char,
    consumed: *mut usize,
) -> i32 {
    at_border("ellgran_wall_add_shape_words", || {
        // SAFETY: promised by the caller, for all of this function.
        let wall = &mut unsafe { required_mut(wall, "wall") }?.wall;
        // SAFETY: `consumed` is NULL or valid for writes, and not aliased, by this function's safety section.
        let consumed = unsafe { required_mut(consumed, "consumed") }?;
        // SAFETY: `words` has `word_count` strings, by this function's safety section.
        let texts = unsafe { given_words(words, word_count) }?;
        let (given, read) = ShapeWords::read(&texts).map_err(wrong)?;
        let shape = EllgranWallShape {
            size: size_of::<EllgranWallShape>(),
            name: core::ptr::null(),
            point: given.point,
            axis: given.axis,
            radii: given.radii,
            bounds: given.bounds,
            ends: given.ends,
            side: given.side,
            unused: 0,
        };
        shape.add_to(wall, given.name)?;
        *consumed = read;
        Ok(())
    })
}

/// Adds a surface of triangles, one part, that acts to both sides: the side is that of a particle's centre. Triangles that
/// meet, wherever their corners are, are one surface; at a concave fold faces act by their shares, and convex edges and corners act by
/// themselves. `corners` is [count][3][3].
///
/// # Safety
/// The pointers are NULL or valid; `corners` has `count * 9` doubles.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_add_triangles(
    wall: *mut EllgranWall,
    count: usize,
    corners: *const f64,
) -> i32 {
    at_border("ellgran_wall_add_triangles", || {
        // SAFETY: promised by the caller, for all of this function.
        let wall = &mut unsafe { required_mut(wall, "wall") }?.wall;
        // SAFETY: `corners` is NULL or valid for reads of `count` elements, by this function's safety section.
        let corners = unsafe { slice(corners.cast::<[[f64; 3]; 3]>(), count, "corners") }?;
        let triangles = corners.iter().map(|t| t.map(Vector3::from_array)).collect();
        wall.add_mesh(Mesh::new(triangles).map_err(wrong)?);
        Ok(())
    })
}

/// Makes flat pieces of triangles flat again whose corners were rounded, as they are read from a file of few digits; [`ellgran_wall_add_stl`] does so
/// itself. Each edge between many triangles of a plane is a fold after rounding, and at such folds between convex and concave edges a grain is pushed by the
/// wrong ones. `corners` is [count][3][3], and changed: corners move by about the rounding, and where planes meet at small angles by up to a
/// twentieth of an edge along them; equal ones stay equal. Nothing is done to corners of more than nine decimal digits. The largest motion goes to
/// `largest_motion`, which may be NULL; 0 if there is none. The call allocates: it belongs to a set-up.
///
/// # Safety
/// The pointers are NULL or valid; `corners` has `count * 9` doubles.
#[no_mangle]
pub unsafe extern "C" fn ellgran_flatten_triangles(
    count: usize,
    corners: *mut f64,
    largest_motion: *mut f64,
) -> i32 {
    at_border("ellgran_flatten_triangles", || {
        // SAFETY: `corners` is NULL or valid for reads and writes of `count` elements, by this function's safety section.
        let corners = unsafe { slice_mut(corners.cast::<[[f64; 3]; 3]>(), count, "corners") }?;
        let mut triangles: Vec<Triangle> = (corners.iter())
            .map(|t| t.map(Vector3::from_array))
            .collect();
        let largest = flatten_triangles(&mut triangles).map_err(wrong)?;
        for (own, flat) in corners.iter_mut().zip(triangles) {
            *own = flat.map(Vector3::to_array);
        }
        // SAFETY: `largest_motion` is NULL or valid for writes, by this function's safety section.
        if let Some(place) = unsafe { largest_motion.as_mut() } {
            *place = largest;
        }
        Ok(())
    })
}

/// Adds a block along the axes of the wall from without, one part: its faces, edges and corners act as those of triangles. A particle whose centre is in the
/// block, or that is so deep in it that no face, edge or corner by itself acts, is pressed out the shortest way. `low` and `high` are [3].
///
/// # Safety
/// The pointers are NULL or valid; `low` and `high` have 3 doubles.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_add_block(
    wall: *mut EllgranWall,
    low: *const f64,
    high: *const f64,
) -> i32 {
    at_border("ellgran_wall_add_block", || {
        // SAFETY: promised by the caller, for all of this function.
        let wall = &mut unsafe { required_mut(wall, "wall") }?.wall;
        // SAFETY: `low` is NULL or valid for reads of 3 values, by this function's safety section.
        let low = unsafe { required(low.cast::<[f64; 3]>(), "low") }?;
        // SAFETY: `high` is NULL or valid for reads of 3 values, by this function's safety section.
        let high = unsafe { required(high.cast::<[f64; 3]>(), "high") }?;
        wall.add_block(*low, *high).map_err(wrong)
    })
}

/// Adds the triangles of an STL file, binary or ASCII, as `ellgran_wall_add_triangles` does. They are scaled by `scale`, turned by
/// `quaternion` (w, x, y, z) about the file's origin, and moved by `translation`; both may be NULL. Coordinates in the file have single
/// precision, also in ASCII, and flat pieces are made flat as by [`ellgran_flatten_triangles`]. The number of triangles goes to `triangle_count`, which may be NULL. The call reads a file and allocates: it belongs to a set-up.
///
/// # Safety
/// The pointers are NULL or valid; `path` ends with NUL.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_add_stl(
    wall: *mut EllgranWall,
    path: *const c_char,
    scale: f64,
    quaternion: *const f64,
    translation: *const f64,
    triangle_count: *mut usize,
) -> i32 {
    at_border("ellgran_wall_add_stl", || {
        // SAFETY: promised by the caller, for all of this function.
        let wall = &mut unsafe { required_mut(wall, "wall") }?.wall;
        // SAFETY: `path` is NULL or a text that ends with NUL, by this function's safety section.
        let path = unsafe { text(path, "path") }?;
        // SAFETY: `quaternion` is NULL or valid for reads of 4 values, by this function's safety section.
        let quaternion = unsafe { quaternion.cast::<[f64; 4]>().as_ref() };
        // SAFETY: `translation` is NULL or valid for reads of 3 values, by this function's safety section.
        let translation = unsafe { translation.cast::<[f64; 3]>().as_ref() };
        if !(scale.is_finite() && scale > 0.0) {
            return Err(wrong(format!(
                "scale = {} must be a finite number greater than 0",
                Number(scale)
            )));
        }
        let placed = EllgranWallMotion {
            size: size_of::<EllgranWallMotion>(),
            origin: [0.0; 3],
            displacement: translation.copied().unwrap_or_default(),
            quaternion: quaternion.copied().unwrap_or_default(),
            velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
            along_itself: 0,
            velocity_change: [0.0; 3],
            angular_velocity_change: [0.0; 3],
            unused: 0,
        }
        .to_core()?;
        let triangles = stl::read(path.as_ref()).map_err(wrong)?;
        let triangles = triangles
            .iter()
            .map(|t| t.map(|p| placed.point_to_world(p * scale)))
            .collect();
        let mesh =
            Mesh::new(triangles).map_err(|what| wrong(format!("STL file {path}: {what}")))?;
        // SAFETY: promised by the caller.
        if let Some(count) = unsafe { triangle_count.as_mut() } {
            *count = mesh.triangle_count();
        }
        wall.add_mesh(mesh);
        Ok(())
    })
}

/// Number of parts of a wall; 0 for NULL.
///
/// # Safety
/// `wall` is NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_part_count(wall: *const EllgranWall) -> usize {
    // SAFETY: promised by the caller.
    unsafe { wall.as_ref() }.map_or(0, |w| w.wall.part_count())
}

/// Doubles that a caller keeps for each particle of what is remembered of its contacts with a wall; 0 for NULL, and where the
/// laws remember nothing.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_histories_length(
    wall: *const EllgranWall,
    laws: *const EllgranLaws,
) -> usize {
    // SAFETY: promised by the caller.
    match unsafe { (wall.as_ref(), laws.as_ref()) } {
        (Some(wall), Some(laws)) => wall.wall.histories(&laws.laws).length(),
        _ => 0,
    }
}

/// How many of the doubles of one particle, from the first on, are in use: what a caller needs to carry along with the particle, the
/// rest is zero. 0 for NULL.
///
/// # Safety
/// The pointers are NULL or valid; `histories` has `ellgran_wall_histories_length` doubles.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_histories_used(
    wall: *const EllgranWall,
    laws: *const EllgranLaws,
    histories: *const f64,
) -> usize {
    // SAFETY: promised by the caller.
    match unsafe { (wall.as_ref(), laws.as_ref(), histories.is_null()) } {
        (Some(wall), Some(laws), false) => {
            let layout = wall.wall.histories(&laws.laws);
            // SAFETY: promised by the caller.
            let histories = unsafe { core::slice::from_raw_parts(histories, layout.length()) };
            layout.used(histories)
        }
        _ => 0,
    }
}

/// Where a wall is and how it moves: NULL is at rest. Public for the border of `gpu/driver`; no interface for others.
///
/// # Errors
/// Numbers out of range.
///
/// # Safety
/// `motion` is NULL or valid.
#[doc(hidden)]
pub unsafe fn motion_of(motion: *const EllgranWallMotion) -> Result<Motion, Failure> {
    if motion.is_null() {
        return Ok(Motion::REST);
    }
    // SAFETY: promised by the caller.
    unsafe { given(motion, "motion") }?.to_core()
}

/// On which particles a wall acts.
///
/// # Safety
/// `masks` is NULL or has `owned` entries, for the lifetime that the caller gives them.
pub(super) unsafe fn chosen<'a>(
    masks: *const i32,
    group_mask: i32,
    owned: usize,
) -> Result<impl Fn(usize) -> bool + 'a, Failure> {
    let mask = if masks.is_null() {
        None
    } else {
        // SAFETY: promised by the caller.
        Some(unsafe { slice(masks, owned, "masks") }?)
    };
    Ok(move |k: usize| mask.is_none_or(|m| m[k] & group_mask != 0))
}

/// Finds the particles that may touch a wall, and prepares them in `workspace`: records of them for the lanes, or
/// to be taken one at a time.
///
/// # Safety
/// The arrays are as `EllgranParticles` states.
pub(super) unsafe fn prepare_near(
    p: &EllgranParticles,
    wall: &mut Wall,
    workspace: &mut Workspace,
    laws: Option<&Laws>,
    motion: &Motion,
    acts_on: &impl Fn(usize) -> bool,
    as_records: Option<PreparedBy<'_>>,
) -> Result<(), Failure> {
    let owned = p.owned_count;
    // SAFETY: promised by the caller, for all of this function.
    let positions = unsafe { slice(p.positions.cast::<[f64; 3]>(), owned, "positions") }?;
    if owned > 0 {
        // SAFETY: the arrays of shapes are NULL or valid for reads, as `EllgranParticles` demands.
        unsafe { required(p.semi_axes, "semi_axes") }?;
        // SAFETY: the arrays of shapes are NULL or valid for reads, as `EllgranParticles` demands.
        unsafe { required(p.quaternions, "quaternions") }?;
        check_strides(p.semi_axes_stride, p.quaternions_stride)?;
    }
    let centre_and_reach = |k: usize| {
        if !acts_on(k) {
            return None;
        }
        // SAFETY: `k` is one of the particles. One without a shape is looked at, and refused, with those near the wall.
        let shape = unsafe { shape_of(p, k) };
        let reach = shape.map_or(f64::NAN, |([a, b, c], _)| {
            // NaN in any of them stays
            let largest = if a >= b { a } else { b };
            if largest >= c {
                largest
            } else {
                c
            }
        });
        Some((Vector3::from_array(positions[k]), reach))
    };
    let found_again = p.unchanged != 0 && wall.find_near_again(motion, positions).is_some();
    if !found_again {
        wall.find_near(motion, owned, centre_and_reach);
    }
    let purpose = match as_records {
        Some(prepared_by) => Purpose::ChosenRecords(wall.near(), prepared_by),
        None => Purpose::Chosen(wall.near()),
    };
    // SAFETY: the arrays of `particles` are NULL or as long as its counts say, as `EllgranParticles` demands.
    unsafe { prepare(p, owned, laws, workspace, purpose) }
}

/// The message of histories that hold what no call has written.
pub(super) fn wall_history_failure(p: &EllgranParticles, wrong: &WrongHistory) -> Failure {
    history_failure(
        identifier(p, wrong.particle),
        None,
        wrong.place,
        wrong.value,
    )
}

/// Forces and torques between all owned particles and a wall, added to the particles' arrays.
///
/// Every place where a particle touches is a contact: a needle across a cylinder has two, a grain in the corner of a box three.
/// The curvature of the wall is in the contact ellipse, negative in a cavity. Contacts follow the law between the particle's
/// type and `wall_type`. `masks` ([owned_count], or NULL for all) and `group_mask` select particles: those with `masks[i] &
/// group_mask` not zero. `histories` is [owned_count][`ellgran_wall_histories_length`] (NULL if that is 0): set to 0 by the caller
/// before a particle's first call, and to be carried along with the particle when its index changes. `motion` may be NULL for
/// a wall at rest; its velocities are those of the half step, as the particles' are, and may have changes likewise. `load` and `tallies` may be NULL.
///
/// All particles that the wall may reach are checked first; on failure nothing is written.
///
/// # Safety
/// The pointers are as stated here and in `EllgranParticles` and `EllgranTallies`.
#[no_mangle]
#[allow(clippy::too_many_arguments)]
pub unsafe extern "C" fn ellgran_compute_wall(
    laws: *const EllgranLaws,
    workspace: *mut EllgranWorkspace,
    wall: *mut EllgranWall,
    particles: *const EllgranParticles,
    masks: *const i32,
    group_mask: i32,
    wall_type: i32,
    motion: *const EllgranWallMotion,
    histories: *mut f64,
    step: *const EllgranStep,
    load: *mut EllgranWallLoad,
    tallies: *mut EllgranTallies,
) -> i32 {
    at_border("ellgran_compute_wall", || {
        let own = workspace.cast_const();
        // SAFETY: promised by the caller, for all of this function.
        let (laws, workspace) = unsafe { handles(laws, workspace) }?;
        // SAFETY: `wall` is NULL or valid for reads and writes, and not aliased, by this function's safety section.
        let wall = &mut unsafe { required_mut(wall, "wall") }?.wall;
        // SAFETY: `particles` is NULL or valid for reads, by this function's safety section.
        let p = &*unsafe { given(particles, "particles") }?;
        // SAFETY: `step` is NULL or valid for reads, by this function's safety section.
        let step = unsafe { given(step, "step") }?.to_core()?;
        let wall_type = check_type(laws, wall_type, "wall_type")?;
        // SAFETY: `motion` is NULL or valid for reads, by this function's safety section.
        let motion = unsafe { motion_of(motion) }?;
        // SAFETY: `load` is NULL or valid for reads and writes, and not aliased, by this function's safety section.
        let mut of_load = unsafe { Output::optional(load, "load") }?;
        let owned = p.owned_count;
        let length = wall.histories(laws).length();
        // SAFETY: `masks` is NULL or has an element for each owned particle, by this function's safety section.
        let acts_on = unsafe { chosen(masks, group_mask, owned) }?;
        // SAFETY: `tallies` and the arrays that it names are valid as `EllgranTallies` demands, by this function's
        // safety section.
        let mut asked = unsafe { Asked::new(tallies) }?;
        let mut sums = match &asked {
            // SAFETY: the arrays of `tallies` have an element for each particle, as `EllgranTallies` demands; they
            // are borrowed once.
            Some(asked) => Some(unsafe { borrow(&asked.given, owned) }?),
            None => None,
        };
        let instruction_set = workspace.instruction_set;
        let in_lanes = wall.is_taken_in_lanes(laws, wall_type, instruction_set, sums.as_ref());
        let prepared_by = if p.prepared_by == own {
            PreparedBy::Itself
        } else {
            // SAFETY: `prepared_by` is NULL or valid, and nobody writes to it during the call, as `EllgranParticles` demands; it is not the
            // workspace that is borrowed here.
            let other = unsafe { p.prepared_by.as_ref() };
            other.map_or(PreparedBy::Nobody, |w| PreparedBy::Other(&w.workspace))
        };
        let as_records = in_lanes.then_some(prepared_by);
        // SAFETY: the arrays of `particles` are NULL or as long as its counts say, as `EllgranParticles` demands.
        unsafe {
            prepare_near(
                p,
                wall,
                workspace,
                Some(laws),
                &motion,
                &acts_on,
                as_records,
            )
        }?;
        let work_is_added =
            |s: &Tallies<'_>| s.inelastic_loads.is_some() || wall.keeps_inelastic_loads;
        if sums.as_ref().is_some_and(work_is_added)
            && step.advance_history
            && !laws.features().friction
        {
            // SAFETY: promised by the caller; the arrays were checked as the particles were prepared.
            unsafe { check_half_step(p, owned, wall.near().iter().copied()) }?;
        }
        let mut output = WallOutput {
            acts_on: &acts_on,
            // SAFETY: `histories` is NULL or valid for reads and writes of `owned * length` elements, and not aliased,
            // by this function's safety section.
            histories: unsafe { slice_mut(histories, owned * length, "histories") }?,
            // SAFETY: `forces` is NULL or valid for reads and writes of `owned` elements, and not aliased, as
            // `EllgranParticles` demands.
            forces: unsafe { slice_mut(p.forces.cast::<[f64; 3]>(), owned, "forces") }?,
            // SAFETY: `torques` is NULL or valid for reads and writes of `owned` elements, and not aliased, as
            // `EllgranParticles` demands.
            torques: unsafe { slice_mut(p.torques.cast::<[f64; 3]>(), owned, "torques") }?,
        };
        let found = if in_lanes {
            let masses = if p.angular_velocities.is_null() && owned > 0 {
                // SAFETY: `masses` is valid for reads of `owned` elements where there are angular momenta, as
                // `EllgranParticles` demands.
                Some(unsafe { slice(p.masses, owned, "masses") }?)
            } else {
                None
            };
            let input = RecordsInput {
                laws,
                wall_type,
                near: workspace.chosen_records(prepared_by),
                masses,
                motion: &motion,
                step: &step,
                instruction_set,
            };
            compute_wall_in_lanes(wall, &input, &mut output, sums.as_mut())
        } else {
            let input = WallInput {
                laws,
                wall_type,
                near: workspace.particles(),
                motion: &motion,
                step: &step,
                instruction_set,
            };
            compute_wall(wall, &input, &mut output, sums.as_mut())
        };
        let found = found.map_err(|e| match e {
            WallError::Hale { particle, ratio } => {
                hale_failure(identifier(p, particle), None, ratio)
            }
            WallError::History(wrong) => wall_history_failure(p, &wrong),
        })?;
        if let (Some(asked), Some(mut sums)) = (&mut asked, sums) {
            // SAFETY: promised by the caller.
            unsafe { add_preceding_half_step(&mut sums, p, owned, &step) }?;
            if !in_lanes {
                let near = workspace.particles();
                // SAFETY: promised by the caller.
                unsafe { respond_at_wall(p, wall, near) };
            }
            // SAFETY: promised by the caller.
            unsafe { add_half_step_at_wall(&mut sums, p, wall, &step) }?;
            asked.write(&sums);
        }
        if let Some(out) = &mut of_load {
            let [viscous, tangential] = found.inelastic;
            out.write(&EllgranWallLoad {
                size: size_of::<EllgranWallLoad>(),
                force: found.force.to_array(),
                torque: found.torque.to_array(),
                power: found.power,
                contact_count: found.contacts as i64,
                stiffness: found.stiffness,
                damping: found.damping,
                crowded_particle: found.crowded.map_or(0, |particle| particle as i64 + 1),
                viscous_force: viscous.force.to_array(),
                viscous_torque: viscous.torque.to_array(),
                tangential_force: tangential.force.to_array(),
                tangential_torque: tangential.torque.to_array(),
            });
        }
        Ok(())
    })
}

/// The plane without an end that a part of a wall is: its unit normal, where the wall has not yet moved, goes to `normal`, 3 doubles, and
/// whether it acts on both its sides, 1 or 0, to `both_sides`, which may be NULL. The normal is towards the particles, or along the `axis` of the
/// description where the plane acts on both sides. Such parts are a shape "plane", and the closed ends of a cylinder or a cone around the
/// particles, which go on beyond their edges. Zeros for any other part. The parts are numbered in the order in which they were added.
///
/// # Safety
/// The pointers are NULL or valid; `normal` has 3 doubles.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_part_plane(
    wall: *const EllgranWall,
    part: usize,
    normal: *mut f64,
    both_sides: *mut i32,
) -> i32 {
    at_border("ellgran_wall_part_plane", || {
        // SAFETY: promised by the caller, for all of this function.
        let wall = &unsafe { required(wall, "wall") }?.wall;
        // SAFETY: `normal` is NULL or valid for reads and writes, and not aliased, by this function's safety section.
        let out = unsafe { required_mut(normal.cast::<[f64; 3]>(), "normal") }?;
        check_part(wall, part)?;
        let plane = wall.whole_plane(part);
        *out = (plane.as_ref())
            .map_or(Vector3::ZERO, |plane| plane.normal)
            .to_array();
        // SAFETY: as above.
        if let Some(both_sides) = unsafe { both_sides.as_mut() } {
            *both_sides = i32::from(plane.is_some_and(|plane| plane.both_sides));
        }
        Ok(())
    })
}

/// Force on a part of a wall in the last call, world frame, to `force`, 3 doubles.
///
/// # Safety
/// The pointers are NULL or valid; `force` has 3 doubles.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_part_force(
    wall: *const EllgranWall,
    part: usize,
    force: *mut f64,
) -> i32 {
    at_border("ellgran_wall_part_force", || {
        // SAFETY: promised by the caller, for all of this function.
        let wall = &unsafe { required(wall, "wall") }?.wall;
        // SAFETY: `force` is NULL or valid for reads and writes, and not aliased, by this function's safety section.
        let out = unsafe { required_mut(force.cast::<[f64; 3]>(), "force") }?;
        check_part(wall, part)?;
        // none before the first call
        *out = wall
            .part_forces()
            .get(part)
            .copied()
            .unwrap_or_default()
            .to_array();
        Ok(())
    })
}

/// Whether `ellgran_compute_wall` records its contacts, which `ellgran_wall_recorded` then gives.
///
/// # Safety
/// `wall` is NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_record_contacts(wall: *mut EllgranWall, record: i32) -> i32 {
    at_border("ellgran_wall_record_contacts", || {
        // SAFETY: promised by the caller.
        unsafe { required_mut(wall, "wall") }?.wall.records_contacts = record != 0;
        Ok(())
    })
}

/// Whether `ellgran_compute_wall` keeps the loads that are not elastic of the particles that touch the wall, where its `tallies` have
/// no array for them. Each call then adds the work of half a step, and `ellgran_wall_tally_following_half_step` adds the other half
/// (`inelastic_loads` of `EllgranTallies` says why). It takes the time of the particles that touch, where the array
/// takes that of all.
///
/// The other half of the work on the wall itself is reckoned with the velocity that the wall had in the step before, which is all that is known
/// then. A caller whose walls change their velocity sets `wall_powers` of the tallies to 0 before the other half, and takes the work of
/// `viscous_force` and `tangential_force` of `EllgranWallLoad` in half a step of the wall's next motion, and that of their torques, off
/// `viscous_dissipation` and `tangential_work` himself.
///
/// # Safety
/// `wall` is NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_keep_inelastic_loads(
    wall: *mut EllgranWall,
    keep: i32,
) -> i32 {
    at_border("ellgran_wall_keep_inelastic_loads", || {
        // SAFETY: promised by the caller.
        unsafe { required_mut(wall, "wall") }?
            .wall
            .keeps_inelastic_loads = keep != 0;
        Ok(())
    })
}

/// Adds the work that the loads which a wall keeps since the last call of `ellgran_compute_wall`
/// (`ellgran_wall_keep_inelastic_loads`) do in the half step after it, to `viscous_dissipation` and `tangential_work` of its
/// `tallies`. Otherwise like `ellgran_tally_following_half_step`; `inelastic_loads` is not read.
///
/// # Safety
/// The pointers are as `EllgranParticles` and `EllgranTallies` state; `wall` is NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_tally_following_half_step(
    wall: *const EllgranWall,
    particles: *const EllgranParticles,
    step: *const EllgranStep,
    tallies: *mut EllgranTallies,
) -> i32 {
    at_border("ellgran_wall_tally_following_half_step", || {
        // SAFETY: promised by the caller, for all of this function.
        let wall = &unsafe { required(wall, "wall") }?.wall;
        // SAFETY: `particles` is NULL or valid for reads, by this function's safety section.
        let p = &*unsafe { given(particles, "particles") }?;
        // SAFETY: `step` is NULL or valid for reads, by this function's safety section.
        let step = unsafe { given(step, "step") }?.to_core()?;
        // SAFETY: `tallies` and the arrays that it names are valid as `EllgranTallies` demands, by this function's
        // safety section.
        let mut asked = unsafe { Asked::new(tallies) }?
            .ok_or_else(|| Failure::new(ELLGRAN_ERROR_NULL_POINTER, "tallies must not be NULL"))?;
        let last = wall.touching_loads().iter().map(|t| t.particle).max();
        if let Some(last) = last.filter(|last| *last >= p.owned_count) {
            return Err(Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!(
                    "owned_count = {}: the wall keeps a load of the particle with index {last}",
                    p.owned_count
                ),
            ));
        }
        let mut sums = asked.carried();
        // SAFETY: the arrays of `particles` are NULL or as long as its counts say, as `EllgranParticles` demands.
        unsafe { check_half_step_at_wall(p, wall, &step) }?;
        // SAFETY: as above.
        unsafe { add_half_step_at_wall(&mut sums, p, wall, &step) }?;
        asked.write_carried(&sums);
        Ok(())
    })
}

/// Number of recorded contacts of the last call; 0 for NULL.
///
/// # Safety
/// `wall` is NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_recorded_count(wall: *const EllgranWall) -> usize {
    // SAFETY: promised by the caller.
    unsafe { wall.as_ref() }.map_or(0, |w| w.wall.contacts().len())
}

/// A contact of the last call that recorded contacts, in the order of the particles.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_recorded(
    wall: *const EllgranWall,
    index: usize,
    contact: *mut EllgranRecordedWallContact,
) -> i32 {
    at_border("ellgran_wall_recorded", || {
        // SAFETY: promised by the caller, for all of this function.
        let all = unsafe { required(wall, "wall") }?.wall.contacts();
        // SAFETY: `contact` is NULL or valid for reads and writes, and not aliased, by this function's safety
        // section.
        let mut out = unsafe { Output::new(contact, "contact") }?;
        let c = all.get(index).ok_or_else(|| {
            wrong(format!(
                "index = {index} is not one of {} recorded contacts",
                all.len()
            ))
        })?;
        let f = &c.forces;
        out.write(&EllgranRecordedWallContact {
            size: size_of::<EllgranRecordedWallContact>(),
            particle: c.particle,
            part: c.part,
            point: c.point.to_array(),
            normal: c.normal.to_array(),
            penetration: c.penetration,
            normal_force: f.normal_force,
            tangential_force: (-f.tangential_force).to_array(),
            force: (-f.force).to_array(),
            torque: f.torque_i.to_array(),
            elastic_energy: [f.elastic_energy, f.tangential_energy],
        });
        Ok(())
    })
}

/// Whether `ellgran_compute_wall` records the loads of triangles, which `ellgran_wall_triangle_loads` then gives.
///
/// # Safety
/// `wall` is NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_record_triangles(wall: *mut EllgranWall, record: i32) -> i32 {
    at_border("ellgran_wall_record_triangles", || {
        // SAFETY: promised by the caller.
        unsafe { required_mut(wall, "wall") }?
            .wall
            .records_triangles = record != 0;
        Ok(())
    })
}

/// Number of triangles of all parts of a wall; 0 for NULL.
///
/// # Safety
/// `wall` is NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_triangle_count(wall: *const EllgranWall) -> usize {
    // SAFETY: promised by the caller.
    unsafe { wall.as_ref() }.map_or(0, |w| w.wall.triangles().count())
}

/// What acted on each triangle in the last call of `ellgran_compute_wall`, to `loads`, [`ellgran_wall_triangle_count`][4], in the order in
/// which triangles were added: the force on it, world frame, and the sum of the forces that press on its plane, each from
/// the side of its particle. A contact counts with the triangle that is deepest in the particle. Zeros where the last call did not
/// record them. Loads of ranks add.
///
/// # Safety
/// The pointers are NULL or valid; `loads` has four doubles for each triangle.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_triangle_loads(
    wall: *const EllgranWall,
    loads: *mut f64,
) -> i32 {
    at_border("ellgran_wall_triangle_loads", || {
        // SAFETY: promised by the caller, for all of this function.
        let wall = &unsafe { required(wall, "wall") }?.wall;
        let count = wall.triangles().count();
        // SAFETY: `loads` is NULL or has four doubles for each triangle, by this function's safety section.
        let out = unsafe { slice_mut(loads.cast::<[f64; 4]>(), count, "loads") }?;
        out.fill([0.0; 4]);
        for (out, load) in out.iter_mut().zip(wall.triangle_loads()) {
            let [x, y, z] = load.force.to_array();
            *out = [x, y, z, load.pressing];
        }
        Ok(())
    })
}

/// Writes the triangles of a wall, where `motion` has brought them (NULL: where they were described), and these loads of them
/// ([`ellgran_wall_triangle_count`][4], as `ellgran_wall_triangle_loads` gives them) to a file of the legacy VTK format, which ParaView
/// reads: for each triangle `force`, `area`, `normal_stress`, positive where particles press, and `shear_stress`, the magnitude of
/// the force in its plane over its area. The call writes a file and allocates.
///
/// # Safety
/// The pointers are NULL or valid; `loads` has four doubles for each triangle; `path` ends with NUL.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_write_triangle_loads(
    wall: *const EllgranWall,
    motion: *const EllgranWallMotion,
    loads: *const f64,
    path: *const c_char,
) -> i32 {
    at_border("ellgran_wall_write_triangle_loads", || {
        // SAFETY: promised by the caller, for all of this function.
        let wall = &unsafe { required(wall, "wall") }?.wall;
        // SAFETY: `path` is NULL or ends with NUL, by this function's safety section.
        let path = unsafe { text(path, "path") }?;
        let motion = if motion.is_null() {
            Motion::REST
        } else {
            // SAFETY: `motion` is valid for reads: it is not NULL here, by this function's safety section.
            unsafe { given(motion, "motion") }?.to_core()?
        };
        let triangles: Vec<_> = wall.triangles().copied().collect();
        // SAFETY: `loads` is NULL or has four doubles for each triangle, by this function's safety section.
        let loads = unsafe { slice(loads.cast::<[f64; 4]>(), triangles.len(), "loads") }?;
        let loads: Vec<TriangleLoad> = loads
            .iter()
            .map(|[x, y, z, pressing]| TriangleLoad {
                force: Vector3::new(*x, *y, *z),
                pressing: *pressing,
            })
            .collect();
        write_triangle_loads(path.as_ref(), &triangles, &motion, &loads).map_err(wrong)
    })
}

/// Whether the surfaces of triangles of a wall go on where a box does that repeats: a wall has no periodic images. `low` and `high` are the
/// least and the greatest coordinates of the box, `is_periodic` is not 0 for the axes along which it repeats, 3 values each. `reach` is
/// the largest semi-axis of the particles; where it is not above 0, nothing is missing. `motion` may be NULL for a wall that has not moved.
///
/// `axis` receives -1 where they go on, or do not come within `reach` of such a boundary. Else it receives 0, 1 or 2, `triangle` the
/// number of a triangle in the box, from 0, in the order in which they were added, and `place`, 3 doubles, a place beyond the boundary
/// along that axis where its image is missing, within `reach`: particles touch nothing there, and what they touch on the other side of the
/// box. `triangle` and `place` may be NULL. The call allocates: it belongs to a set-up.
///
/// # Safety
/// The pointers are NULL or valid, with 3 values where that is said.
#[no_mangle]
#[allow(clippy::too_many_arguments)]
pub unsafe extern "C" fn ellgran_wall_missing_image(
    wall: *const EllgranWall,
    motion: *const EllgranWallMotion,
    low: *const f64,
    high: *const f64,
    is_periodic: *const i32,
    reach: f64,
    axis: *mut i32,
    triangle: *mut usize,
    place: *mut f64,
) -> i32 {
    at_border("ellgran_wall_missing_image", || {
        // SAFETY: promised by the caller, for all of this function.
        let wall = &unsafe { required(wall, "wall") }?.wall;
        // SAFETY: `motion` is NULL or valid for reads, by this function's safety section.
        let motion = unsafe { motion_of(motion) }?;
        // SAFETY: `low` is NULL or valid for reads of 3 values, by this function's safety section.
        let low = *unsafe { required(low.cast::<[f64; 3]>(), "low") }?;
        // SAFETY: `high` is NULL or valid for reads of 3 values, by this function's safety section.
        let high = *unsafe { required(high.cast::<[f64; 3]>(), "high") }?;
        // SAFETY: `is_periodic` is NULL or valid for reads of 3 values, by this function's safety section.
        let periodic = *unsafe { required(is_periodic.cast::<[i32; 3]>(), "is_periodic") }?;
        // SAFETY: `axis` is NULL or valid for writes, and not aliased, by this function's safety section.
        let axis = unsafe { required_mut(axis, "axis") }?;
        let domain = PeriodicBox {
            low: ranges::vector(low, LARGEST_COORDINATE, "low")
                .map_err(wrong)?
                .to_array(),
            high: ranges::vector(high, LARGEST_COORDINATE, "high")
                .map_err(wrong)?
                .to_array(),
            is_periodic: periodic.map(|p| p != 0),
        };
        for k in (0..3).filter(|k| domain.is_periodic[*k]) {
            if domain.low[k] >= domain.high[k] {
                return Err(wrong(format!(
                    "low[{k}] = {} must be below high[{k}] = {} where the box repeats",
                    Number(domain.low[k]),
                    Number(domain.high[k])
                )));
            }
        }
        *axis = -1;
        if let Some(missing) = wall.missing_image(&motion, &domain, reach) {
            *axis = missing.axis as i32;
            // SAFETY: promised by the caller.
            if let Some(triangle) = unsafe { triangle.as_mut() } {
                *triangle = missing.triangle;
            }
            // SAFETY: promised by the caller.
            if let Some(place) = unsafe { place.cast::<[f64; 3]>().as_mut() } {
                *place = missing.place.to_array();
            }
        }
        Ok(())
    })
}

/// # Safety
/// `pointer` is NULL or ends with NUL.
unsafe fn text<'a>(pointer: *const c_char, name: &str) -> Result<&'a str, Failure> {
    if pointer.is_null() {
        return Err(Failure::new(
            ELLGRAN_ERROR_NULL_POINTER,
            format!("{name} must not be NULL"),
        ));
    }
    // SAFETY: promised by the caller.
    unsafe { CStr::from_ptr(pointer) }
        .to_str()
        .map_err(|_| Failure::new(ELLGRAN_ERROR_TEXT, format!("{name} is not UTF-8")))
}
