// SPDX-License-Identifier: MIT OR Apache-2.0
//! A scene: its laws, its neighbour list, its planes, and what it remembers.

use super::gpu::EllgranGpu;
use super::{slice, slice_mut};
use crate::arrays::{
    EllgranGpuCounts, EllgranGpuGrains, EllgranGpuHistories, EllgranGpuList, EllgranGpuTallies,
    ELLGRAN_GPU_ANY_SHAPES, ELLGRAN_GPU_DOUBLE, ELLGRAN_GPU_ELLIPSOIDS, ELLGRAN_GPU_MIXED,
    ELLGRAN_GPU_SPHERES, ELLGRAN_GPU_SPHEROIDS,
};
use crate::driver_library::Stream;
use crate::entries::{Precision, Shapes};
use crate::scene::Scene;
use core::ffi::c_void;
use ellgran::c_api::growing::{given, Output};
use ellgran::c_api::law::EllgranLaws;
use ellgran::c_api::particles::EllgranStep;
use ellgran::c_api::rigid_wall::EllgranWall;
use ellgran::c_api::status::{at_border, required, required_mut, Failure, ELLGRAN_ERROR_ARGUMENT};

/// What is kept of a scene in the memory of a GPU. Opaque; it belongs to one thread at a time.
///
/// All calls with a scene take the stream of the caller (a `CUstream` or `cudaStream_t`; NULL is the default stream) and start their
/// kernels on it, in the order of the calls. Calls with another stream must wait for the one before.
pub struct EllgranGpuScene {
    pub(super) scene: Scene,
}

/// Makes a scene with laws, which are copied. `shapes` is one of ELLGRAN_GPU_ANY_SHAPES, ELLGRAN_GPU_SPHERES, ELLGRAN_GPU_SPHEROIDS and
/// ELLGRAN_GPU_ELLIPSOIDS: it decides which kernels are used, those of simpler shapes having
/// fewer instructions.
///
/// Laws with `factors hale`, `viscosity memory`, `rolling` or `twisting` are refused: they have no kernel.
///
/// # Safety
/// `gpu` and `laws` are NULL or valid; `scene` is NULL or valid for writes.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_scene_new(
    gpu: *const EllgranGpu,
    laws: *const EllgranLaws,
    shapes: i32,
    scene: *mut *mut EllgranGpuScene,
) -> i32 {
    at_border("ellgran_gpu_scene_new", || {
        // SAFETY: NULL or valid, by this function's safety section.
        let (gpu, laws) = unsafe { (required(gpu, "gpu")?, required(laws, "laws")?) };
        // SAFETY: `scene` is NULL or valid for writes, by this function's safety section.
        let out = unsafe { required_mut(scene, "scene") }?;
        let shapes = match shapes {
            ELLGRAN_GPU_ANY_SHAPES => None,
            ELLGRAN_GPU_SPHERES => Some(Shapes::Spheres),
            ELLGRAN_GPU_SPHEROIDS => Some(Shapes::Spheroids),
            ELLGRAN_GPU_ELLIPSOIDS => Some(Shapes::Ellipsoids),
            _ => {
                return Err(Failure::new(
                    ELLGRAN_ERROR_ARGUMENT,
                    format!("shapes = {shapes} is none of its constants"),
                ))
            }
        };
        let scene = Scene::new(&gpu.device, laws.table(), shapes)?;
        *out = Box::into_raw(Box::new(EllgranGpuScene { scene }));
        Ok(())
    })
}

/// The precision in which pairs are computed from the next call on: ELLGRAN_GPU_DOUBLE, as with a new scene, or ELLGRAN_GPU_MIXED, for
/// a GPU that is slow with doubles. What is remembered is the same in each, and spheres and planes are computed in double precision in
/// each.
///
/// With ELLGRAN_GPU_MIXED the search runs in single precision. Where the bodies touch, their penetration, their law and their history
/// are computed in double precision. A pair that single precision cannot decide is computed as with ELLGRAN_GPU_DOUBLE: none is missed. docs/gpu.md has
/// the errors, and the speeds to be expected.
///
/// # Safety
/// `scene` is NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_scene_set_precision(
    scene: *mut EllgranGpuScene,
    precision: i32,
) -> i32 {
    at_border("ellgran_gpu_scene_set_precision", || {
        // SAFETY: NULL or valid, by this function's safety section.
        let scene = unsafe { required_mut(scene, "scene") }?;
        let precision = match precision {
            ELLGRAN_GPU_DOUBLE => Precision::Double,
            ELLGRAN_GPU_MIXED => Precision::Mixed,
            _ => {
                return Err(Failure::new(
                    ELLGRAN_ERROR_ARGUMENT,
                    format!("precision = {precision} is none of its constants"),
                ))
            }
        };
        scene.scene.set_precision(precision)
    })
}

/// Frees a scene and its memory on the GPU, once all that was started is done; NULL is allowed.
///
/// # Safety
/// `scene` is NULL or came from `ellgran_gpu_scene_new` and is not used again.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_scene_free(scene: *mut EllgranGpuScene) {
    if !scene.is_null() {
        // SAFETY: made by `Box::into_raw`, and not freed before, by this function's safety section.
        drop(unsafe { Box::from_raw(scene) });
    }
}

/// Begins with a new neighbour list, which replaces the one before; before the first step too. The order of the grains and their number
/// may have changed.
///
/// - What is remembered of pairs that both lists have, and of grains with planes, is carried over on the GPU, by the identifiers of the
///   grains. Of other pairs nothing is remembered, nor of an owned grain that was not in the list before, except with those that had it
///   as a ghost: ranks that exchange grains give what they remember to `ellgran_gpu_write_histories`.
/// - Memory is allocated as needed. No other call allocates any.
/// - Grains are prepared and candidates selected: `ellgran_gpu_compute_pairs` may follow at once.
/// - The call waits for what was started before, and for its own checks: a grain or a row with which something is wrong is an
///   ELLGRAN_ERROR_PARTICLE that names it. What was remembered is then still there, and the call can be made again.
///
/// # Safety
/// `scene` is NULL or valid; `grains` and `list` are NULL or valid, and their pointers are to memory of the GPU as they state.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_new_list(
    scene: *mut EllgranGpuScene,
    grains: *const EllgranGpuGrains,
    list: *const EllgranGpuList,
    stream: *mut c_void,
) -> i32 {
    at_border("ellgran_gpu_new_list", || {
        // SAFETY: NULL or valid, by this function's safety section.
        let (scene, grains, list) = unsafe {
            (
                required_mut(scene, "scene")?,
                given(grains, "grains")?,
                given(list, "list")?,
            )
        };
        scene.scene.new_list(&grains, &list, Stream(stream))
    })
}

/// Adds a plane wall to a scene and writes its number, counted from 0, to `plane`. The scene keeps the histories of its contacts; where
/// it is and how it moves is told in each step.
///
/// # Safety
/// `scene` is NULL or valid; `plane` is NULL or valid for writes.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_add_plane(
    scene: *mut EllgranGpuScene,
    stream: *mut c_void,
    plane: *mut i32,
) -> i32 {
    at_border("ellgran_gpu_add_plane", || {
        // SAFETY: NULL or valid, by this function's safety section.
        let (scene, out) =
            unsafe { (required_mut(scene, "scene")?, required_mut(plane, "plane")?) };
        *out = scene.scene.add_plane(Stream(stream))? as i32;
        Ok(())
    })
}

/// Adds a wall of any shapes to a scene: planes, cylinders, cones and spheres, with their ends, as
/// `ellgran_wall_add_shape` and `ellgran_wall_add_shape_words` have added them, and triangles, as `ellgran_wall_add_triangles` and
/// `ellgran_wall_add_stl` have. Writes its number, counted from 0 over planes and walls, to
/// `number`. The parts are copied: what is added to `wall` later, or done with it, is not seen. The scene keeps the histories of
/// its contacts; where it is and how it moves is told in each step.
///
/// A wall with triangles that an engine lends is refused: ELLGRAN_ERROR_ARGUMENT, with the number of the part.
///
/// # Safety
/// `scene` and `wall` are NULL or valid; `number` is NULL or valid for writes.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_add_wall(
    scene: *mut EllgranGpuScene,
    wall: *const EllgranWall,
    stream: *mut c_void,
    number: *mut i32,
) -> i32 {
    at_border("ellgran_gpu_add_wall", || {
        // SAFETY: NULL or valid, by this function's safety section.
        let (scene, wall, out) = unsafe {
            (
                required_mut(scene, "scene")?,
                required(wall, "wall")?,
                required_mut(number, "number")?,
            )
        };
        *out = scene.scene.add_wall(wall.parts(), Stream(stream))? as i32;
        Ok(())
    })
}

/// Waits for all that was started on the stream, and tells of the first grain with which something was wrong since the last call of
/// this or of `ellgran_gpu_new_list`: ELLGRAN_ERROR_PARTICLE, and a message that names it and the value it has now. `grains` are those
/// of the steps since then.
///
/// A grain that cannot be prepared keeps the state in which it last could, one that cannot be moved its attitude: forces are wrong from
/// then on. It need not be called in each step.
///
/// # Safety
/// `scene` is NULL or valid; `grains` is NULL or valid, and its pointers are to memory of the GPU as it states.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_check(
    scene: *mut EllgranGpuScene,
    grains: *const EllgranGpuGrains,
    stream: *mut c_void,
) -> i32 {
    at_border("ellgran_gpu_check", || {
        // SAFETY: NULL or valid, by this function's safety section.
        let (scene, grains) = unsafe { (required_mut(scene, "scene")?, given(grains, "grains")?) };
        scene.scene.check(&grains, Stream(stream))
    })
}

/// Writes where the histories of pairs are in the memory of the GPU, those of row `k` from `starts[k]` on, or with `plane` 0 or greater
/// those of that plane or wall. `plane` = -1: of pairs. Those of a grain with a wall are laid out as `ellgran_compute_wall` has them on the
/// host, for 8 contacts at most, for 8 of each mesh, and `touching` is how many there are.
///
/// # Safety
/// `scene` is NULL or valid; `histories` is NULL or valid for writes of its `size` bytes.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_histories(
    scene: *const EllgranGpuScene,
    plane: i32,
    histories: *mut EllgranGpuHistories,
) -> i32 {
    at_border("ellgran_gpu_histories", || {
        // SAFETY: NULL or valid, by this function's safety section.
        let (scene, mut out) = unsafe {
            (
                required(scene, "scene")?,
                Output::new(histories, "histories")?,
            )
        };
        let plane = (plane != -1).then_some(plane);
        out.write(&scene.scene.histories(plane)?);
        Ok(())
    })
}

/// Copies what `ellgran_gpu_histories` tells of to arrays of the host: to `touching`, [count], and `histories`, [count][length]. Waits for
/// what was started on the stream. `plane` = -1: of pairs.
///
/// # Safety
/// `scene` is NULL or valid; `touching` is NULL or valid for `count` writes, `histories` for `count * length`; those arrays do not overlap.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_read_histories(
    scene: *const EllgranGpuScene,
    plane: i32,
    touching: *mut u32,
    histories: *mut f64,
    stream: *mut c_void,
) -> i32 {
    at_border("ellgran_gpu_read_histories", || {
        // SAFETY: NULL or valid, by this function's safety section.
        let scene = unsafe { required(scene, "scene")? };
        let plane = (plane != -1).then_some(plane);
        let held = scene.scene.histories(plane)?;
        // SAFETY: NULL or so long, by this function's safety section.
        let (touching, histories) = unsafe {
            (
                slice_mut(touching, held.count, "touching")?,
                slice_mut(histories, held.count * held.length, "histories")?,
            )
        };
        let stream = Stream(stream);
        scene
            .scene
            .read_histories(plane, touching, histories, stream)
    })
}

/// Takes what is remembered from arrays of the host, as `ellgran_gpu_read_histories` writes them, in place of all that was remembered
/// of pairs (`plane` = -1) or of that plane: after a restart, or when grains have come from other ranks. Follows `ellgran_gpu_new_list`,
/// with the same `grains`. Entries of which nothing is remembered, and the entry of a pair of two owned grains in the row of the one with
/// the higher identifier, have 0 in both arrays. What a pair remembers that cannot touch is forgotten.
///
/// # Safety
/// `scene` is NULL or valid; `grains` is NULL or valid, and its pointers are to memory of the GPU as it states; `touching` is NULL or valid
/// for `count` reads, `histories` for `count * length`.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_write_histories(
    scene: *mut EllgranGpuScene,
    grains: *const EllgranGpuGrains,
    plane: i32,
    touching: *const u32,
    histories: *const f64,
    stream: *mut c_void,
) -> i32 {
    at_border("ellgran_gpu_write_histories", || {
        // SAFETY: NULL or valid, by this function's safety section.
        let (scene, grains) = unsafe { (required_mut(scene, "scene")?, given(grains, "grains")?) };
        let plane = (plane != -1).then_some(plane);
        let held = scene.scene.histories(plane)?;
        // SAFETY: NULL or so long, by this function's safety section.
        let (touching, histories) = unsafe {
            (
                slice(touching, held.count, "touching")?,
                slice(histories, held.count * held.length, "histories")?,
            )
        };
        let stream = Stream(stream);
        scene
            .scene
            .write_histories(&grains, plane, touching, histories, stream)
    })
}

/// Adds what grains remember of wall `number` of the scene to `histories`, in the form in which `ellgran_compute_wall` keeps it of
/// `wall` under `laws`: [`owned_count` of the list][`ellgran_wall_histories_length`], of each grain as many records as it has contacts,
/// behind those that there are; set to 0 by the caller. `wall` is the one that was given to `ellgran_gpu_add_wall`; a plane of the scene is
/// its part `part`, counted from 0, which must be a plane without an end, and `part` is not read for other walls. `laws` may
/// be others than those of the scene, and remember less: what they have no place for is left out. Waits for what was started on the
/// stream.
///
/// # Safety
/// `scene`, `wall` and `laws` are NULL or valid; `histories` is NULL or valid for writes of so many doubles.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_read_wall_histories(
    scene: *const EllgranGpuScene,
    number: i32,
    wall: *const EllgranWall,
    laws: *const EllgranLaws,
    part: i32,
    histories: *mut f64,
    stream: *mut c_void,
) -> i32 {
    at_border("ellgran_gpu_read_wall_histories", || {
        // SAFETY: NULL or valid, by this function's safety section.
        let (scene, wall, laws) = unsafe {
            (
                required(scene, "scene")?,
                required(wall, "wall")?,
                required(laws, "laws")?,
            )
        };
        let scene = &scene.scene;
        let host = (wall.parts(), laws.table());
        let forms = scene.wall_histories(number, host, part)?;
        let length = scene.owned()? * forms.length();
        // SAFETY: NULL or so long, by this function's safety section.
        let histories = unsafe { slice_mut(histories, length, "histories")? };
        scene.read_wall_histories(number, &forms, histories, Stream(stream))
    })
}

/// Takes what grains remember of wall `number` of the scene from `histories`, as `ellgran_gpu_read_wall_histories` and `ellgran_compute_wall` write
/// them, in place of all that was remembered of it. Follows `ellgran_gpu_new_list`, with the same `grains`. What the laws of the scene
/// remember and `laws` do not begins with 0.
///
/// A number that no call writes is refused: ELLGRAN_ERROR_ARGUMENT, with its place.
///
/// # Safety
/// `scene`, `wall` and `laws` are NULL or valid; `grains` is NULL or valid, and its pointers are to memory of the GPU as it states;
/// `histories` is NULL or valid for reads of so many doubles.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_write_wall_histories(
    scene: *mut EllgranGpuScene,
    grains: *const EllgranGpuGrains,
    number: i32,
    wall: *const EllgranWall,
    laws: *const EllgranLaws,
    part: i32,
    histories: *const f64,
    stream: *mut c_void,
) -> i32 {
    at_border("ellgran_gpu_write_wall_histories", || {
        // SAFETY: NULL or valid, by this function's safety section.
        let (scene, grains, wall, laws) = unsafe {
            (
                required_mut(scene, "scene")?,
                given(grains, "grains")?,
                required(wall, "wall")?,
                required(laws, "laws")?,
            )
        };
        let scene = &mut scene.scene;
        let host = (wall.parts(), laws.table());
        let forms = scene.wall_histories(number, host, part)?;
        let length = scene.owned()? * forms.length();
        // SAFETY: NULL or so long, by this function's safety section.
        let histories = unsafe { slice(histories, length, "histories")? };
        scene.write_wall_histories(&grains, number, &forms, histories, Stream(stream))
    })
}

/// Writes elastic energies and virial of the touching pairs. Follows `ellgran_gpu_prepare` or `ellgran_gpu_new_list`, before
/// `ellgran_gpu_compute_pairs`, of what that is about to compute contacts from; it changes nothing. A pair of which a grain is no owned
/// one counts one half. Waits; the first call of a GPU has the driver assemble kernels of their own.
///
/// The same calls with the same numbers in the same order give the same bits.
///
/// # Safety
/// `scene` is NULL or valid; `grains` and `step` are NULL or valid; the pointers of `grains` are to memory of the GPU as stated; `tallies` is
/// NULL or valid for writes of its `size` bytes.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_tally_pairs(
    scene: *mut EllgranGpuScene,
    grains: *const EllgranGpuGrains,
    step: *const EllgranStep,
    tallies: *mut EllgranGpuTallies,
    stream: *mut c_void,
) -> i32 {
    at_border("ellgran_gpu_tally_pairs", || {
        // SAFETY: NULL or valid, by this function's safety section.
        let (scene, grains, step, mut out) = unsafe {
            (
                required_mut(scene, "scene")?,
                given(grains, "grains")?,
                given(step, "step")?,
                Output::new(tallies, "tallies")?,
            )
        };
        let found = (scene.scene).tally_pairs(&grains, &step.to_core()?, Stream(stream))?;
        out.write(&found);
        Ok(())
    })
}

/// Writes what a scene has done and holds. Waits for what was started on the stream.
///
/// # Safety
/// `scene` is NULL or valid; `counts` is NULL or valid for writes of its `size` bytes.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_counts(
    scene: *const EllgranGpuScene,
    stream: *mut c_void,
    counts: *mut EllgranGpuCounts,
) -> i32 {
    at_border("ellgran_gpu_counts", || {
        // SAFETY: NULL or valid, by this function's safety section.
        let (scene, mut out) =
            unsafe { (required(scene, "scene")?, Output::new(counts, "counts")?) };
        out.write(&scene.scene.counts(Stream(stream))?);
        Ok(())
    })
}
