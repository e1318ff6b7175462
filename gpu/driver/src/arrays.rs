// SPDX-License-Identifier: MIT OR Apache-2.0
//! The structs of the C interface: pointers to memory of the device, which are not followed here.

/// Vectors of grains in the memory of the GPU: component `c` of grain `k` is `first[k * per_grain + c * per_component]`. Both distances
/// 0: one vector after the other, [count][3], of quaternions [count][4]. Columns, one array for each component: `per_grain` 1,
/// `per_component` the length of a column. No two components may be at the same place.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranGpuVectors {
    /// The first component of the first grain.
    pub first: *mut f64,
    /// Distance in doubles from a grain to the next.
    pub per_grain: usize,
    /// Distance in doubles from a component to the next.
    pub per_component: usize,
}

/// Pointers to an engine's own arrays of grains in the memory of the GPU: owned grains first, then ghosts. World frame; any consistent
/// units. Every array has `count` entries, unless it says otherwise.
///
/// The arrays are read while what a call has started runs on its stream, and may move between calls. Values out of their range, which
/// are those of `EllgranParticles`, are found on the GPU: `ellgran_gpu_check` tells of them.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranGpuGrains {
    /// `sizeof(EllgranGpuGrains)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// Grains that the caller owns: forces are computed for these, and these move.
    pub owned_count: usize,
    /// All grains, ghosts included; below 2^31.
    pub count: usize,
    /// Centres.
    pub positions: EllgranGpuVectors,
    /// Velocities of the centres: those of the half step, or those of the step with `velocity_changes`.
    pub velocities: EllgranGpuVectors,
    /// Angular momenta of solid ellipsoids about their centres; of the same time.
    pub angular_momenta: EllgranGpuVectors,
    /// NULL, or what velocities and angular momenta have more than those of the half step, [count][6], as
    /// `ellgran_gpu_start_step` writes it. NULL or not is decided with `ellgran_gpu_new_list`.
    pub velocity_changes: *const f64,
    /// Masses, [count].
    pub masses: *const f64,
    /// Semi-axes. They change with `ellgran_gpu_new_list` alone.
    pub semi_axes: EllgranGpuVectors,
    /// Quaternions (w, x, y, z), body to world.
    pub quaternions: EllgranGpuVectors,
    /// Types, counted from 1, [count]. They change with `ellgran_gpu_new_list` alone.
    pub types: *const i32,
    /// Identifiers, [count]: they order the two grains of a pair, and carry its history from list to list. A ghost has that of its
    /// grain.
    pub identifiers: *const i32,
    /// NULL, or the owned grain that each grain is, or is an image of, [count]. Velocities, angular momenta, changes, masses,
    /// semi-axes and quaternions of images are then those of these grains, and need entries for owned grains alone. It changes with
    /// `ellgran_gpu_new_list` alone.
    pub owners: *const i32,
    /// NULL, or where in `semi_axes` and `quaternions` each grain is, each place once: for an engine that has these beside its other
    /// arrays. Of `count` entries, with `owners` of `owned_count`. It changes with `ellgran_gpu_new_list` alone.
    pub body_places: *const i32,
    /// How many places there are in `semi_axes` and `quaternions`; read with `body_places`.
    pub body_count: usize,
}

/// Where forces and torques are written in the memory of the GPU, of owned grains.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranGpuLoads {
    /// `sizeof(EllgranGpuLoads)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// Forces.
    pub forces: EllgranGpuVectors,
    /// Torques about the centres.
    pub torques: EllgranGpuVectors,
    /// 0: what is there is overwritten with the loads of pairs. 1: these are added to it. Those of planes are always added.
    pub add: i64,
}

/// An engine's full neighbour list in the memory of the GPU: each pair of owned grains twice, once in the row of either.
/// Another list is an ELLGRAN_ERROR_PARTICLE that names a grain.
///
/// The list must hold each pair whose centres are closer than the sum of their two largest semi-axes plus a margin of the engine's. It
/// can be used until a grain has moved by half of that margin. The arrays must stay as they are, and where they are, until the next
/// call of `ellgran_gpu_new_list`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranGpuList {
    /// `sizeof(EllgranGpuList)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// Where the row of each owned grain begins in `neighbours`, [owned_count + 1]; the last is the number of all entries. NULL where no
    /// grain is owned.
    pub starts: *const u32,
    /// Indices of the neighbours.
    pub neighbours: *const u32,
    /// A length: pairs with a wider gap are left out until a grain has moved by half of it, which is found on the GPU. It changes no
    /// result. On the host the margin settles between a thousandth and a fifth of the mean smallest semi-axis, the faster the motion the
    /// wider.
    pub margin: f64,
}

/// Pointers to what moves, in the memory of the GPU, `count` each; all owned grains move.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranGpuMotion {
    /// `sizeof(EllgranGpuMotion)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// Number of grains: the owned ones of the list.
    pub count: usize,
    /// Centres; written by `ellgran_gpu_start_step`.
    pub positions: EllgranGpuVectors,
    /// Velocities; written.
    pub velocities: EllgranGpuVectors,
    /// Angular momenta; written.
    pub angular_momenta: EllgranGpuVectors,
    /// Quaternions; `ellgran_gpu_start_step` writes them with length 1.
    pub quaternions: EllgranGpuVectors,
    /// Semi-axes.
    pub semi_axes: EllgranGpuVectors,
    /// Masses, [count].
    pub masses: *const f64,
    /// Forces.
    pub forces: EllgranGpuVectors,
    /// Torques about the centres.
    pub torques: EllgranGpuVectors,
    /// As of `EllgranMotion`: NULL, or what velocities and angular momenta have more than those of the half step, [count][6]; written.
    pub velocity_changes: *mut f64,
    /// As of `EllgranMotion`: forces and torques of the step before, [count][6]; read and written with `velocity_changes`.
    pub loads_before: *mut f64,
    /// As of `EllgranMotion`: time step of the step before; 0: the present one.
    pub time_step_before: f64,
    /// As of `EllgranGpuGrains`: NULL, or where in `semi_axes` and `quaternions` each grain is, [count].
    pub body_places: *const i32,
    /// As of `EllgranGpuGrains`.
    pub body_count: usize,
}

/// What a scene remembers, in the memory of the GPU. It may be read, and written for a restart, until the next call of
/// `ellgran_gpu_new_list`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranGpuHistories {
    /// `sizeof(EllgranGpuHistories)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// Entries of the neighbour list, or owned grains of a wall.
    pub count: usize,
    /// `ellgran_laws_history_length` of the laws.
    pub length: usize,
    /// 1 where a pair touches, else 0, [count]. A pair of two owned grains is in the row of the one with the lower identifier; in the
    /// other's row, 0.
    pub touching: *mut u32,
    /// [count][length]. Of a pair: as of the pair whose first grain has the lower identifier; where `touching` says it.
    pub histories: *mut f64,
}

/// What a scene has done, and what it holds.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranGpuCounts {
    /// `sizeof(EllgranGpuCounts)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// How often candidates were selected.
    pub selections: u64,
    /// Bytes of the GPU's memory that the scene holds.
    pub bytes: u64,
    /// ELLGRAN_GPU_SPHERES, ELLGRAN_GPU_SPHEROIDS or ELLGRAN_GPU_ELLIPSOIDS, by which kernels are chosen; 0 before the first list.
    pub shapes: i64,
}

/// Sums over the contacts of pairs, as in `EllgranTallies`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranGpuTallies {
    /// `sizeof(EllgranGpuTallies)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// Elastic energy of the normal deformation.
    pub normal_elastic_energy: f64,
    /// Elastic energy of the tangential deformation.
    pub tangential_elastic_energy: f64,
    /// Sum of d (x) F over pairs, d from i to j, F the force on j: xx yy zz xy xz yz.
    pub virial: [f64; 6],
}

/// Of `ellgran_gpu_scene_new`: each new list is looked through.
pub const ELLGRAN_GPU_ANY_SHAPES: i32 = 0;
/// All grains are spheres.
pub const ELLGRAN_GPU_SPHERES: i32 = 1;
/// All grains are spheroids or spheres.
pub const ELLGRAN_GPU_SPHEROIDS: i32 = 2;
/// Grains of any semi-axes.
pub const ELLGRAN_GPU_ELLIPSOIDS: i32 = 3;

/// Of `ellgran_gpu_scene_set_precision`: contacts in double precision, to 1e-12 of those of the host.
pub const ELLGRAN_GPU_DOUBLE: i32 = 0;
/// Their search in single precision: the force of a contact to 6e-7, up to an aspect ratio of 5 (docs/gpu.md).
pub const ELLGRAN_GPU_MIXED: i32 = 1;
