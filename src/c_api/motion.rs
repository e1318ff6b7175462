// SPDX-License-Identifier: MIT OR Apache-2.0
//! A step of an engine's ellipsoids under given forces: velocity Verlet.

use super::growing::{given, growing};
use super::particles::{check_strides, entry_of, shape_place, EllgranWorkspace};
use super::status::{
    at_border, required, slice, slice_mut, Failure, ELLGRAN_ERROR_ARGUMENT, ELLGRAN_ERROR_PARTICLE,
};
use crate::contact::ranges::LONGEST_TIME_STEP;
use crate::message::Number;
use crate::motion::{
    angular_velocities, finish_step, start_step, Bodies, BodyArrays, Extrapolation, MotionError,
    Selection,
};
use core::ffi::c_void;

/// Pointers to an engine's own arrays of rigid bodies that are solid ellipsoids. World frame; any consistent units.
///
/// The arrays are read and written during a call and not kept after it. No two of them overlap.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranMotion {
    /// `sizeof(EllgranMotion)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// Number of bodies.
    pub count: usize,
    /// Centres, [count][3]; written by `ellgran_start_step`.
    pub positions: *mut f64,
    /// Velocities of the centres, [count][3]; written.
    pub velocities: *mut f64,
    /// Angular momenta about the centres, [count][3]; written.
    pub angular_momenta: *mut f64,
    /// Forces, [count][3].
    pub forces: *const f64,
    /// Torques about the centres, [count][3].
    pub torques: *const f64,
    /// Masses, [count], finite and greater than 0.
    pub masses: *const f64,
    /// Index of each body into `semi_axes` and `quaternions`, [count]; negative: not an ellipsoid, an error if it is to move.
    /// NULL: the body's own index.
    pub shape_indices: *const i32,
    /// Semi-axes, 3 doubles an entry, from 1e-20 to 1e20; two or three that are equal bit for bit make a body of revolution or a sphere.
    pub semi_axes: *const f64,
    /// Bytes from one entry of `semi_axes` to the next, 24 or more.
    pub semi_axes_stride: usize,
    /// Quaternions (w, x, y, z), body to world, 4 doubles an entry; of any length but zero. `ellgran_start_step` writes them
    /// with length 1.
    pub quaternions: *mut f64,
    /// Bytes from one entry of `quaternions` to the next, 32 or more.
    pub quaternions_stride: usize,
    /// Group bits of each body, [count], or NULL: all bodies move.
    pub masks: *const i32,
    /// Bodies with `masks[i] & group_mask` not zero move.
    pub group_mask: i32,
    /// Bytes of an entry of `identifiers`: 4 or 8.
    pub identifier_bytes: i32,
    /// What to call a body in a message, [count] integers, or NULL: index + 1.
    pub identifiers: *const c_void,
    /// NULL: `ellgran_start_step` leaves velocities and angular momenta of the half step. Else [count][6]: it leaves those of
    /// the end of the step, extrapolated, for forces that depend on them, and writes here what they have more than those of
    /// the half step. `ellgran_finish_step` writes what they had more than those that it leaves, so that between steps the
    /// sum of velocities and changes is what the last forces were computed with.
    pub velocity_changes: *mut f64,
    /// Forces and torques of the step before, [count][6]; read and written by `ellgran_start_step` with `velocity_changes`.
    /// Where the first component of a body is INFINITY they are not known: the present forces stand for them.
    pub loads_before: *mut f64,
    /// Time step of the step before, for the extrapolation; 0: the same as the present one.
    pub time_step_before: f64,
}

growing!(EllgranMotion, identifiers: *const c_void);

/// Shapes and attitudes as the engine has them.
struct Entries<'a> {
    motion: &'a EllgranMotion,
    indices: Option<&'a [i32]>,
}

impl Entries<'_> {
    /// # Safety
    /// There is such an entry.
    #[inline(always)]
    unsafe fn quaternion(&self, entry: usize) -> *mut [f64; 4] {
        let offset = entry * self.motion.quaternions_stride;
        // SAFETY: promised by the caller.
        unsafe { self.motion.quaternions.byte_add(offset).cast() }
    }
}

impl Bodies for Entries<'_> {
    #[inline(always)]
    fn shape(&self, k: usize) -> Option<([f64; 3], [f64; 4])> {
        let entry = entry_of(self.indices, k)?;
        let offset = entry * self.motion.semi_axes_stride;
        // SAFETY: by the contract of `EllgranMotion` there is an entry for every index that is named.
        unsafe {
            let semi_axes = self.motion.semi_axes.byte_add(offset).cast::<[f64; 3]>();
            Some((
                semi_axes.read_unaligned(),
                self.quaternion(entry).read_unaligned(),
            ))
        }
    }

    #[inline(always)]
    fn place(&self, k: usize) -> Option<[&f64; 2]> {
        let entry = (k < self.motion.count).then(|| entry_of(self.indices, k))??;
        let offset = entry * self.motion.semi_axes_stride;
        // SAFETY: as above; nothing writes while `self` is borrowed.
        unsafe {
            shape_place(
                self.motion.semi_axes.byte_add(offset),
                self.quaternion(entry).cast(),
            )
        }
    }

    #[inline(always)]
    fn turn(&mut self, k: usize, quaternion: [f64; 4]) {
        if let Some(entry) = entry_of(self.indices, k) {
            // SAFETY: as above; nothing else of this call refers to the quaternions.
            unsafe { self.quaternion(entry).write_unaligned(quaternion) }
        }
    }
}

fn identifier(motion: &EllgranMotion, k: usize) -> i64 {
    if motion.identifiers.is_null() {
        return k as i64 + 1;
    }
    // SAFETY: the array has `count` entries of `identifier_bytes` bytes, by the contract of the struct.
    unsafe {
        if motion.identifier_bytes == 8 {
            motion.identifiers.cast::<i64>().add(k).read_unaligned()
        } else {
            i64::from(motion.identifiers.cast::<i32>().add(k).read_unaligned())
        }
    }
}

fn failure(motion: &EllgranMotion, error: MotionError) -> Failure {
    Failure::new(
        ELLGRAN_ERROR_PARTICLE,
        format!(
            "particle {}: {}",
            identifier(motion, error.body),
            error.what
        ),
    )
}

/// The arrays of a call, which its checks have passed.
///
/// # Safety
/// The arrays are as [`EllgranMotion`] states.
unsafe fn arrays(
    motion: &EllgranMotion,
    time_step: f64,
) -> Result<(BodyArrays<'_, Entries<'_>>, Selection<'_>), Failure> {
    if !(0.0..=LONGEST_TIME_STEP).contains(&time_step) {
        return Err(Failure::new(
            ELLGRAN_ERROR_ARGUMENT,
            format!(
                "time_step = {} must be a finite number, 0 or greater, at most {LONGEST_TIME_STEP:e}",
                Number(time_step)
            ),
        ));
    }
    if motion.identifier_bytes != 4 && motion.identifier_bytes != 8 && !motion.identifiers.is_null()
    {
        return Err(Failure::new(
            ELLGRAN_ERROR_ARGUMENT,
            format!(
                "identifier_bytes = {} must be 4 or 8",
                motion.identifier_bytes
            ),
        ));
    }
    let n = motion.count;
    if n > 0 {
        required_pointer(motion.semi_axes, "semi_axes")?;
        required_pointer(motion.quaternions.cast_const(), "quaternions")?;
        check_strides(motion.semi_axes_stride, motion.quaternions_stride)?;
    }
    let rows = |pointer: *const f64, name: &str| {
        // SAFETY: promised by the caller.
        unsafe { slice(pointer.cast::<[f64; 3]>(), n, name) }
    };
    let written = |pointer: *mut f64, name: &str| {
        // SAFETY: promised by the caller.
        unsafe { slice_mut(pointer.cast::<[f64; 3]>(), n, name) }
    };
    let indices = if motion.shape_indices.is_null() {
        None
    } else {
        // SAFETY: promised by the caller.
        Some(unsafe { slice(motion.shape_indices, n, "shape_indices") }?)
    };
    let groups = if motion.masks.is_null() {
        &[][..]
    } else {
        // SAFETY: promised by the caller.
        unsafe { slice(motion.masks, n, "masks") }?
    };
    let selection = Selection {
        groups,
        bits: motion.group_mask,
    };
    let extrapolation = if motion.velocity_changes.is_null() {
        None
    } else {
        let time_step_before = if motion.time_step_before == 0.0 {
            time_step
        } else {
            motion.time_step_before
        };
        if !(time_step_before > 0.0 || time_step == 0.0) || time_step_before > LONGEST_TIME_STEP {
            return Err(Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!(
                    "time_step_before = {} must be a finite number, 0 or greater, at most {LONGEST_TIME_STEP:e}",
                    Number(time_step_before)
                ),
            ));
        }
        // SAFETY: promised by the caller.
        let (changes, loads_before) = unsafe {
            (
                slice_mut(motion.velocity_changes.cast(), n, "velocity_changes")?,
                slice_mut(motion.loads_before.cast(), n, "loads_before")?,
            )
        };
        Some(Extrapolation {
            changes,
            loads_before,
            step_ratio: if time_step > 0.0 {
                time_step / time_step_before
            } else {
                1.0
            },
        })
    };
    let arrays = BodyArrays {
        extrapolation,
        positions: written(motion.positions, "positions")?,
        velocities: written(motion.velocities, "velocities")?,
        angular_momenta: written(motion.angular_momenta, "angular_momenta")?,
        forces: rows(motion.forces, "forces")?,
        torques: rows(motion.torques, "torques")?,
        // SAFETY: promised by the caller.
        masses: unsafe { slice(motion.masses, n, "masses") }?,
        bodies: Entries { motion, indices },
    };
    Ok((arrays, selection))
}

fn required_pointer(pointer: *const f64, name: &str) -> Result<(), Failure> {
    // SAFETY: only asked whether it is NULL; the reference is not used.
    unsafe { required(pointer, name) }.map(|_| ())
}

/// First half of a step of velocity Verlet: velocities and angular momenta of the half step (or those extrapolated to its end,
/// see `velocity_changes`), positions and quaternions of its end. The way in between is that of a free body: exact to rounding for any shape (docs/theory.md, section 8).
///
/// The workspace names the instruction set; nothing in it is read or written otherwise. On failure some bodies have been
/// moved and others have not: the state is lost. An error names the body: it is no ellipsoid, a semi-axis is out of range,
/// its mass is not a positive finite number, or it would turn by more than half a circle.
///
/// # Safety
/// `workspace` is valid, and the pointers are as stated in `EllgranMotion`.
#[no_mangle]
pub unsafe extern "C" fn ellgran_start_step(
    workspace: *const EllgranWorkspace,
    motion: *const EllgranMotion,
    time_step: f64,
) -> i32 {
    at_border("ellgran_start_step", || {
        // SAFETY: promised by the caller, for all of this function.
        let set = unsafe { required(workspace, "workspace") }?
            .workspace
            .instruction_set;
        // SAFETY: `motion` is NULL or valid for reads, by this function's safety section.
        let motion = &*unsafe { given(motion, "motion") }?;
        // SAFETY: the arrays of `motion` are NULL or as long as its count says, by this function's safety section.
        let (mut arrays, selection) = unsafe { arrays(motion, time_step) }?;
        start_step(set, &mut arrays, selection, time_step).map_err(|error| failure(motion, error))
    })
}

/// Second half of the step, with the forces and torques at its end: velocities and angular momenta of the end of the step.
///
/// The workspace names the instruction set, as for `ellgran_start_step`.
///
/// # Safety
/// `workspace` is valid, and the pointers are as stated in `EllgranMotion`.
#[no_mangle]
pub unsafe extern "C" fn ellgran_finish_step(
    workspace: *const EllgranWorkspace,
    motion: *const EllgranMotion,
    time_step: f64,
) -> i32 {
    at_border("ellgran_finish_step", || {
        // SAFETY: promised by the caller, for all of this function.
        let set = unsafe { required(workspace, "workspace") }?
            .workspace
            .instruction_set;
        // SAFETY: `motion` is NULL or valid for reads, by this function's safety section.
        let motion = &*unsafe { given(motion, "motion") }?;
        // SAFETY: the arrays of `motion` are NULL or as long as its count says, by this function's safety section.
        let (mut arrays, selection) = unsafe { arrays(motion, time_step) }?;
        finish_step(set, &mut arrays, selection, time_step);
        Ok(())
    })
}

/// Angular velocities, world frame, that go with the present angular momenta and quaternions, for an engine that keeps both:
/// `angular_velocities` is [count][3], and overlaps with no array of `motion`. Those of bodies that do not move are left as they are.
///
/// An error names the body: it is no ellipsoid, a semi-axis is out of range, its quaternion has no length, or its mass is not a
/// positive finite number.
///
/// The workspace names the instruction set, as for `ellgran_start_step`.
///
/// # Safety
/// `workspace` is valid, and the pointers are as stated in `EllgranMotion`; `angular_velocities` is NULL or as long as stated.
#[no_mangle]
pub unsafe extern "C" fn ellgran_angular_velocities(
    workspace: *const EllgranWorkspace,
    motion: *const EllgranMotion,
    angular_velocities: *mut f64,
) -> i32 {
    at_border("ellgran_angular_velocities", || {
        // SAFETY: promised by the caller, for all of this function.
        let set = unsafe { required(workspace, "workspace") }?
            .workspace
            .instruction_set;
        // SAFETY: `motion` is NULL or valid for reads, by this function's safety section.
        let motion = &*unsafe { given(motion, "motion") }?;
        // SAFETY: the arrays of `motion` are NULL or as long as its count says, by this function's safety section.
        let (mut arrays, selection) = unsafe { arrays(motion, 0.0) }?;
        let found = angular_velocities.cast::<[f64; 3]>();
        // SAFETY: `angular_velocities` is NULL or has `count` times three entries, by this function's safety section.
        let found = unsafe { slice_mut(found, motion.count, "angular_velocities") }?;
        self::angular_velocities(set, &mut arrays, selection, found)
            .map_err(|error| failure(motion, error))
    })
}
