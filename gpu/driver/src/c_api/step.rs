// SPDX-License-Identifier: MIT OR Apache-2.0
//! The calls of a step: nothing is allocated, copied or waited for.

use super::scene::EllgranGpuScene;
use crate::arrays::{EllgranGpuGrains, EllgranGpuLoads, EllgranGpuMotion};
use crate::driver_library::Stream;
use core::ffi::c_void;
use ellgran::c_api::growing::given;
use ellgran::c_api::particles::EllgranStep;
use ellgran::c_api::plane::EllgranPlane;
use ellgran::c_api::rigid_wall::{motion_of, EllgranWallMotion};
use ellgran::c_api::status::{at_border, required_mut};

/// Starts the first half of a step of velocity Verlet, as `ellgran_start_step` on the host. A grain that cannot be moved is told of by
/// `ellgran_gpu_check`.
///
/// # Safety
/// `scene` is NULL or valid; `motion` is NULL or valid, and its pointers are to memory of the GPU as it states.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_start_step(
    scene: *mut EllgranGpuScene,
    motion: *const EllgranGpuMotion,
    time_step: f64,
    stream: *mut c_void,
) -> i32 {
    at_border("ellgran_gpu_start_step", || {
        // SAFETY: NULL or valid, by this function's safety section.
        let (scene, motion) = unsafe { (required_mut(scene, "scene")?, given(motion, "motion")?) };
        scene.scene.start_step(&motion, time_step, Stream(stream))
    })
}

/// Starts the preparation of the present grains for the forces of a step. Candidates are selected anew where a grain has moved by half
/// of the list's margin, which the GPU finds by itself.
///
/// # Safety
/// `scene` is NULL or valid; `grains` is NULL or valid, and its pointers are to memory of the GPU as it states.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_prepare(
    scene: *mut EllgranGpuScene,
    grains: *const EllgranGpuGrains,
    stream: *mut c_void,
) -> i32 {
    at_border("ellgran_gpu_prepare", || {
        // SAFETY: NULL or valid, by this function's safety section.
        let (scene, grains) = unsafe { (required_mut(scene, "scene")?, given(grains, "grains")?) };
        scene.scene.prepare(&grains, Stream(stream))
    })
}

/// Starts the forces of all touching pairs: writes forces and torques of owned grains. Follows `ellgran_gpu_prepare` or `ellgran_gpu_new_list`.
///
/// The same calls with the same numbers in the same order give the same bits. They differ by rounding from those of
/// `ellgran_compute_pairs`.
///
/// # Safety
/// `scene` is NULL or valid; `grains`, `step` and `loads` are NULL or valid; the pointers of `grains` and `loads` are to memory of the
/// GPU as stated.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_compute_pairs(
    scene: *mut EllgranGpuScene,
    grains: *const EllgranGpuGrains,
    step: *const EllgranStep,
    loads: *const EllgranGpuLoads,
    stream: *mut c_void,
) -> i32 {
    at_border("ellgran_gpu_compute_pairs", || {
        // SAFETY: NULL or valid, by this function's safety section.
        let (scene, grains, step, loads) = unsafe {
            (
                required_mut(scene, "scene")?,
                given(grains, "grains")?,
                given(step, "step")?,
                given(loads, "loads")?,
            )
        };
        let step = step.to_core()?;
        scene
            .scene
            .compute_pairs(&grains, &step, &loads, Stream(stream))
    })
}

/// Starts the forces of a plane wall: adds to forces and torques, as `ellgran_gpu_compute_pairs` wrote them. `plane` is the number that
/// `ellgran_gpu_add_plane` wrote, `at` where the plane is, `wall_type` its type in the laws.
///
/// # Safety
/// `scene` is NULL or valid; `grains`, `at`, `step` and `loads` are NULL or valid; the pointers of `grains` and `loads` are to memory of
/// the GPU as stated.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_compute_plane(
    scene: *mut EllgranGpuScene,
    grains: *const EllgranGpuGrains,
    plane: i32,
    at: *const EllgranPlane,
    wall_type: i32,
    step: *const EllgranStep,
    loads: *const EllgranGpuLoads,
    stream: *mut c_void,
) -> i32 {
    at_border("ellgran_gpu_compute_plane", || {
        // SAFETY: NULL or valid, by this function's safety section.
        let (scene, grains, at, step, loads) = unsafe {
            (
                required_mut(scene, "scene")?,
                given(grains, "grains")?,
                given(at, "at")?,
                given(step, "step")?,
                given(loads, "loads")?,
            )
        };
        let (at, step) = (at.to_core()?, step.to_core()?);
        let stream = Stream(stream);
        scene
            .scene
            .compute_plane(&grains, plane, &at, wall_type, &step, &loads, stream)
    })
}

/// Starts the forces of a wall: adds to forces and torques, as `ellgran_gpu_compute_pairs` wrote them. `wall` is the number that
/// `ellgran_gpu_add_wall` wrote, `motion` where the wall is and how it moves, as for `ellgran_compute_wall` on the host (NULL: at
/// rest), `wall_type` its type in the laws.
///
/// A grain that touches the wall in more than 8 places gets no force of it, and `ellgran_gpu_check` tells of it.
///
/// # Safety
/// `scene` is NULL or valid; `grains`, `motion`, `step` and `loads` are NULL or valid; the pointers of `grains` and `loads` are to memory
/// of the GPU as stated.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_compute_wall(
    scene: *mut EllgranGpuScene,
    grains: *const EllgranGpuGrains,
    wall: i32,
    motion: *const EllgranWallMotion,
    wall_type: i32,
    step: *const EllgranStep,
    loads: *const EllgranGpuLoads,
    stream: *mut c_void,
) -> i32 {
    at_border("ellgran_gpu_compute_wall", || {
        // SAFETY: NULL or valid, by this function's safety section.
        let (scene, grains, motion, step, loads) = unsafe {
            (
                required_mut(scene, "scene")?,
                given(grains, "grains")?,
                motion_of(motion)?,
                given(step, "step")?,
                given(loads, "loads")?,
            )
        };
        let step = step.to_core()?;
        let stream = Stream(stream);
        scene
            .scene
            .compute_wall(&grains, wall, &motion, wall_type, &step, &loads, stream)
    })
}

/// Starts the second half of a step of velocity Verlet, with the loads of its end, as `ellgran_finish_step` on the host.
///
/// # Safety
/// `scene` is NULL or valid; `motion` is NULL or valid, and its pointers are to memory of the GPU as it states.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_finish_step(
    scene: *mut EllgranGpuScene,
    motion: *const EllgranGpuMotion,
    time_step: f64,
    stream: *mut c_void,
) -> i32 {
    at_border("ellgran_gpu_finish_step", || {
        // SAFETY: NULL or valid, by this function's safety section.
        let (scene, motion) = unsafe { (required_mut(scene, "scene")?, given(motion, "motion")?) };
        scene.scene.finish_step(&motion, time_step, Stream(stream))
    })
}
