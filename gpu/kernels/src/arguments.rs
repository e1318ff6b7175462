// SPDX-License-Identifier: MIT OR Apache-2.0
//! What each entry is called with, written once: the entries on a device read it as arrays ([`Memory`] says how), and the host that
//! starts them writes it as addresses and lengths.
//!
//! Every kernel takes the number of its threads that have something to do first, a `u32`, and then one of these.

use crate::candidates::Candidate;
use crate::meshes::{LargeRoom, SmallRoom};
use crate::shapes::{Grain, GrainChange};
use crate::terms::NUMBERS;
use crate::walls::WallMotion;
use core::sync::atomic::{AtomicU32, AtomicU64};
use ellgran::force::PairLaw;
use ellgran::geometry::box_tree::{Extent, Node};
use ellgran::geometry::triangles::Triangle;
use ellgran::vector::Vector3;
use ellgran::walls::parts::Part;
use ellgran::walls::Surface;

/// How arrays are held: as a pointer and a length on a device, as an address and a length on its host. Of 16 bytes, vectors of 32,
/// aligned to 8.
pub trait Memory {
    /// An array that all threads read.
    type Shared<T>;
    /// An array of which each thread has a part.
    type Parts<T>;
    /// Vectors of `N` numbers, rows or columns of an engine's arrays, that all threads read.
    type SharedVectors<const N: usize>;
    /// The same, of which each thread has some, or some components.
    type OwnVectors<const N: usize>;
}

/// Of the notes that the threads of all kernels leave: a grain has moved too far for the candidates.
pub const MOVED: usize = 0;
/// How often candidates have been selected.
pub const SELECTIONS: usize = 1;
/// Something is wrong with a grain.
pub const FAULT: usize = 2;
/// A grain is no sphere.
pub const NO_SPHERE: usize = 3;
/// A grain is no spheroid.
pub const NO_SPHEROID: usize = 4;
/// Entries of the list whose rows keep them.
pub const KEPT: usize = 5;
/// How many candidates there are.
pub const CANDIDATES: usize = 6;
/// How many candidates a selection that is under way has found.
pub const FOUND: usize = 7;
/// How many contacts of the step are marked.
pub const MARKED: usize = 8;
/// Number of notes.
pub const NOTES: usize = 9;

/// What all threads of a contact kernel read.
#[repr(C)]
pub struct SceneArguments<M: Memory> {
    /// Prepared grains, ghosts included.
    pub grains: M::Shared<Grain>,
    /// What their motion has more at the step; empty where velocities are those of the half step.
    pub changes: M::Shared<GrainChange>,
    /// Their types.
    pub types: M::Shared<u32>,
    /// Inverses of their masses; empty where no law reads masses.
    pub inverse_masses: M::Shared<f64>,
    /// Their identifiers.
    pub identifiers: M::Shared<i32>,
    /// The laws of all pairs of types, row by row.
    pub laws: M::Shared<PairLaw>,
    /// Time step.
    pub time_step: f64,
    /// Number of types.
    pub type_count: u32,
    /// 1 where histories advance, 0 in the set-up of a run.
    pub advance_history: u32,
    /// 1 where a history begins with a normal.
    pub cached_normal: u32,
    /// 1 where a history has a tangential part.
    pub tangential: u32,
    /// 1 where some law has `displacement rescaled`.
    pub rescaled: u32,
}

/// Shapes and attitudes in an engine's arrays. Those of grain `k` are at `places[owners[k]]`.
#[repr(C)]
pub struct BodyArguments<M: Memory> {
    /// The owned grain that each grain is, or is an image of; empty: each is its own.
    pub owners: M::Shared<u32>,
    /// Empty: each at its index. No two grains have the same place.
    pub places: M::Shared<u32>,
    /// Semi-axes.
    pub semi_axes: M::SharedVectors<3>,
    /// Quaternions.
    pub quaternions: M::SharedVectors<4>,
}

/// Of `ellgran_prepare_*`: an engine's arrays, and what becomes of them.
#[repr(C)]
pub struct PrepareArguments<M: Memory> {
    /// Centres.
    pub positions: M::SharedVectors<3>,
    /// Velocities, those of images at their owners.
    pub velocities: M::SharedVectors<3>,
    /// Angular momenta, likewise.
    pub angular_momenta: M::SharedVectors<3>,
    /// What velocities and angular momenta have more than those of the half step, likewise; empty where they are these.
    pub changes: M::Shared<[f64; 6]>,
    /// Masses, likewise.
    pub masses: M::Shared<f64>,
    /// Shapes and attitudes.
    pub bodies: BodyArguments<M>,
    /// Types.
    pub types: M::Shared<u32>,
    /// Written: prepared grains.
    pub grains: M::Parts<Grain>,
    /// Written: what their motion has more at the step; may be empty.
    pub motion_changes: M::Parts<GrainChange>,
    /// Written: inverses of masses; may be empty.
    pub inverse_masses: M::Parts<f64>,
    /// Poses in which candidates were selected; empty where these will be anyway.
    pub poses: M::Shared<[f64; 8]>,
    /// The first fault of each grain stays here until the host has read it.
    pub faults: M::Parts<u32>,
    /// [`FAULT`] is left, and [`MOVED`] where a grain has moved too far for the candidates.
    pub notes: M::Shared<AtomicU32>,
    /// That of the candidates.
    pub margin: f64,
    /// Number of types.
    pub type_count: u32,
}

/// Of `ellgran_candidates_*`. Row `k` of the full neighbour list is from `starts[k]` up to `starts[k + 1]`.
#[repr(C)]
pub struct CandidateArguments<M: Memory> {
    /// The scene.
    pub scene: SceneArguments<M>,
    /// One more than there are rows.
    pub starts: M::Shared<u32>,
    /// Indices of the neighbours.
    pub neighbours: M::Shared<u32>,
    /// Written: places in row `k` of the candidates that it keeps, from `starts[k]` on.
    pub places: M::Parts<u32>,
    /// One state per neighbour.
    pub states: M::Parts<u32>,
    /// One history per neighbour.
    pub histories: M::Parts<f64>,
    /// Written: how many candidates each row keeps.
    pub counts: M::Parts<u32>,
    /// [`MOVED`] is read.
    pub notes: M::Shared<AtomicU32>,
    /// The sum of the ways of two grains for which candidates remain valid.
    pub margin: f64,
    /// 0: they are selected where [`MOVED`] is left.
    pub always: u32,
}

/// Rows of which one thread numbers the candidates: those that are close in memory have numbers that are.
pub const ROWS_NUMBERED: usize = 128;

/// Of `ellgran_number_candidates`.
#[repr(C)]
pub struct NumberArguments<M: Memory> {
    /// How many candidates each row keeps.
    pub counts: M::Shared<u32>,
    /// Written: the number of the first candidate of each row; the others of the row follow it.
    pub firsts: M::Parts<u32>,
    /// [`MOVED`] is read, [`FOUND`] counted.
    pub notes: M::Shared<AtomicU32>,
    /// 0: they are numbered where [`MOVED`] is left.
    pub always: u32,
}

/// Of `ellgran_terms`.
#[repr(C)]
pub struct TermArguments<M: Memory> {
    /// Identifiers of all grains.
    pub identifiers: M::Shared<i32>,
    /// Their types.
    pub types: M::Shared<u32>,
    /// Rows.
    pub starts: M::Shared<u32>,
    /// Their neighbours.
    pub neighbours: M::Shared<u32>,
    /// Places of the candidates in their rows.
    pub places: M::Shared<u32>,
    /// The number of the first candidate of each row.
    pub firsts: M::Shared<u32>,
    /// How many there are of each row.
    pub counts: M::Shared<u32>,
    /// Written: candidates, by their numbers.
    pub candidates: M::Parts<Candidate>,
    /// Written: the terms of row `k` from `starts[k]` on.
    pub terms: M::Parts<u32>,
    /// Written: how many each row has.
    pub term_counts: M::Parts<u32>,
    /// [`MOVED`] is read.
    pub notes: M::Shared<AtomicU32>,
    /// Number of types.
    pub type_count: u32,
    /// 0: they are written where [`MOVED`] is left.
    pub always: u32,
}

/// Of `ellgran_remember_poses`.
#[repr(C)]
pub struct PoseArguments<M: Memory> {
    /// Centres.
    pub positions: M::SharedVectors<3>,
    /// Shapes and attitudes.
    pub bodies: BodyArguments<M>,
    /// Written.
    pub poses: M::Parts<[f64; 8]>,
    /// [`MOVED`] is read, [`SELECTIONS`] counted, [`CANDIDATES`] left.
    pub notes: M::Shared<AtomicU32>,
    /// That of the candidates.
    pub margin: f64,
    /// 0: they are written where [`MOVED`] is left.
    pub always: u32,
}

/// Of `ellgran_contacts_*` and `ellgran_marked_contacts_*`.
#[repr(C)]
pub struct ContactArguments<M: Memory> {
    /// The scene.
    pub scene: SceneArguments<M>,
    /// Candidates: no two of the same entry.
    pub candidates: M::Shared<Candidate>,
    /// One state per neighbour.
    pub states: M::Parts<u32>,
    /// One history per neighbour.
    pub histories: M::Parts<f64>,
    /// Written, one per candidate.
    pub contact_loads: M::OwnVectors<NUMBERS>,
    /// Numbers of the candidates that the first has marked; each once.
    pub marked: M::Parts<u32>,
    /// [`CANDIDATES`] is read, [`MARKED`] counted by the first and read by the second.
    pub notes: M::Shared<AtomicU32>,
}

/// Of `ellgran_tally_*`, which have some threads, each with some of the candidates.
#[repr(C)]
pub struct TallyArguments<M: Memory> {
    /// The scene.
    pub scene: SceneArguments<M>,
    /// Candidates: no two of the same entry.
    pub candidates: M::Shared<Candidate>,
    /// One state per neighbour.
    pub states: M::Shared<u32>,
    /// One history per neighbour.
    pub histories: M::Shared<f64>,
    /// [`CANDIDATES`] is read.
    pub notes: M::Shared<AtomicU32>,
    /// Written: [`TALLIES`](crate::tallies::TALLIES) sums of each thread.
    pub sums: M::Parts<f64>,
    /// How many threads there are.
    pub threads: u32,
    /// How many grains are owned.
    pub owned: u32,
}

/// Of `ellgran_sum_contacts`, which has [`COMPONENTS`](crate::terms::COMPONENTS) threads for each grain.
#[repr(C)]
pub struct SumArguments<M: Memory> {
    /// Rows.
    pub starts: M::Shared<u32>,
    /// The terms of row `k` from `starts[k]` on.
    pub terms: M::Shared<u32>,
    /// How many each row has.
    pub term_counts: M::Shared<u32>,
    /// One per candidate.
    pub contact_loads: M::SharedVectors<NUMBERS>,
    /// Written: the force on each grain.
    pub forces: M::OwnVectors<3>,
    /// Written: the torque on each grain.
    pub torques: M::OwnVectors<3>,
    /// [`MARKED`] begins anew.
    pub notes: M::Shared<AtomicU32>,
    /// 1 where forces and torques are added to those that are there.
    pub add: u32,
}

/// Of `ellgran_plane_*`. States and histories are the grains' own with this wall.
#[repr(C)]
pub struct PlaneArguments<M: Memory> {
    /// The scene.
    pub scene: SceneArguments<M>,
    /// A point of the plane.
    pub point: Vector3,
    /// Its normal, of length 1.
    pub normal: Vector3,
    /// How fast it moves.
    pub velocity: Vector3,
    /// What its velocity at the step has more.
    pub velocity_change: Vector3,
    /// One state per grain.
    pub states: M::Parts<u32>,
    /// One history per grain.
    pub histories: M::Parts<f64>,
    /// Added to.
    pub forces: M::OwnVectors<3>,
    /// Added to.
    pub torques: M::OwnVectors<3>,
    /// Type of the wall.
    pub wall_type: u32,
}

/// Of `ellgran_wall`. States and histories are the grains' own with this wall.
#[repr(C)]
pub struct WallArguments<M: Memory> {
    /// The scene.
    pub scene: SceneArguments<M>,
    /// The parts of the wall.
    pub surfaces: M::Shared<Surface>,
    /// Where it is and how it moves.
    pub motion: WallMotion,
    /// One per grain: how many contacts it has.
    pub states: M::Parts<u32>,
    /// Those of each grain.
    pub histories: M::Parts<f64>,
    /// Added to.
    pub forces: M::OwnVectors<3>,
    /// Added to.
    pub torques: M::OwnVectors<3>,
    /// The first fault of each grain stays here until the host has read it.
    pub faults: M::Parts<u32>,
    /// [`FAULT`] is left.
    pub notes: M::Shared<AtomicU32>,
    /// 1 where grains are ellipsoids, 0 where they are spheroids.
    pub ellipsoids: u32,
    /// Type of the wall.
    pub wall_type: u32,
    /// Contacts of a grain that are remembered.
    pub records: u32,
}

/// Of `ellgran_near_mesh_*`, and then of `ellgran_mesh` twice. States and histories are the grains' own with this wall.
#[repr(C)]
pub struct MeshArguments<M: Memory> {
    /// The scene.
    pub scene: SceneArguments<M>,
    /// The parts of the wall.
    pub parts: M::Shared<Part>,
    /// The triangles of all of them.
    pub triangles: M::Shared<Triangle>,
    /// Of each triangle.
    pub boxes: M::Shared<Extent>,
    /// How wide the flat piece is of which each triangle is a part.
    pub widths: M::Shared<f64>,
    /// Of the trees of all meshes.
    pub nodes: M::Shared<Node>,
    /// Those of the triangles that belong to a node.
    pub order: M::Shared<usize>,
    /// Where it is and how it moves.
    pub motion: WallMotion,
    /// One per grain: how many contacts it has.
    pub states: M::Parts<u32>,
    /// Those of each grain.
    pub histories: M::Parts<f64>,
    /// Added to.
    pub forces: M::OwnVectors<3>,
    /// Added to.
    pub torques: M::OwnVectors<3>,
    /// The first fault of each grain stays here until the host has read it.
    pub faults: M::Parts<u32>,
    /// [`FAULT`] is left.
    pub notes: M::Shared<AtomicU32>,
    /// Grains that are near the wall; each once.
    pub near: M::Parts<u32>,
    /// Those of them that need large room; each once.
    pub crowded: M::Parts<u32>,
    /// How many they are ([`crate::meshes::NEAR`] and the other); zeros before.
    pub counts: M::Shared<AtomicU32>,
    /// One for each thread that looks for contacts, those of listed grains.
    pub rooms: M::Parts<SmallRoom>,
    /// One for each thread that looks for those of grains that need it.
    pub large_rooms: M::Parts<LargeRoom>,
    /// Bytes of such a room, as the host has set them aside.
    pub room_bytes: u64,
    /// See `room_bytes`.
    pub large_room_bytes: u64,
    /// 1 where grains are ellipsoids, 0 where they are spheroids.
    pub ellipsoids: u32,
    /// 1 for those that need large room, 0 for those that are near.
    pub is_crowded: u32,
    /// Type of the wall.
    pub wall_type: u32,
    /// Contacts of a grain that are remembered.
    pub records: u32,
}

/// Of `ellgran_start_step` and `ellgran_finish_step`.
#[repr(C)]
pub struct MotionArguments<M: Memory> {
    /// Centres.
    pub positions: M::OwnVectors<3>,
    /// Velocities.
    pub velocities: M::OwnVectors<3>,
    /// Angular momenta.
    pub angular_momenta: M::OwnVectors<3>,
    /// Where quaternions and semi-axes are, as in [`BodyArguments`].
    pub places: M::Shared<u32>,
    /// Quaternions.
    pub quaternions: M::OwnVectors<4>,
    /// Semi-axes.
    pub semi_axes: M::SharedVectors<3>,
    /// Masses.
    pub masses: M::Shared<f64>,
    /// Forces.
    pub forces: M::SharedVectors<3>,
    /// Torques.
    pub torques: M::SharedVectors<3>,
    /// Empty where velocities are not extrapolated.
    pub changes: M::Parts<[f64; 6]>,
    /// Forces and torques of the step before; read with `changes`.
    pub loads_before: M::Parts<[f64; 6]>,
    /// The first fault of each grain stays here until the host has read it.
    pub faults: M::Parts<u32>,
    /// [`FAULT`] is left.
    pub notes: M::Shared<AtomicU32>,
    /// This step over the one before.
    pub step_ratio: f64,
    /// Time step.
    pub time_step: f64,
}

/// Of `ellgran_find_shapes`.
#[repr(C)]
pub struct ShapeArguments<M: Memory> {
    /// Shapes.
    pub bodies: BodyArguments<M>,
    /// [`NO_SPHERE`] and [`NO_SPHEROID`] are left.
    pub notes: M::Shared<AtomicU32>,
}

/// Of `ellgran_file_identifiers`.
#[repr(C)]
pub struct FileArguments<M: Memory> {
    /// Identifiers of the grains of the list before.
    pub identifiers: M::Shared<i32>,
    /// Zeros before; see [`crate::pair_memory::file`].
    pub slots: M::Shared<AtomicU64>,
}

/// Of `ellgran_carry_pairs`: from the list before to a new one.
#[repr(C)]
pub struct CarryPairsArguments<M: Memory> {
    /// Identifiers of all present grains.
    pub identifiers: M::Shared<i32>,
    /// Present rows.
    pub starts: M::Shared<u32>,
    /// Their neighbours.
    pub neighbours: M::Shared<u32>,
    /// Where grains were in the list before.
    pub slots: M::Shared<AtomicU64>,
    /// Rows of the list before.
    pub starts_before: M::Shared<u32>,
    /// Identifiers of their neighbours.
    pub partners_before: M::Shared<i32>,
    /// Their states.
    pub states_before: M::Shared<u32>,
    /// Their histories.
    pub histories_before: M::Shared<f64>,
    /// Written: identifiers of the present neighbours.
    pub partners: M::Parts<i32>,
    /// Written.
    pub states: M::Parts<u32>,
    /// Written.
    pub histories: M::Parts<f64>,
    /// What is wrong with a row.
    pub faults: M::Parts<u32>,
    /// [`FAULT`] is left, [`KEPT`] counted.
    pub notes: M::Shared<AtomicU32>,
    /// Doubles of a history.
    pub length: u32,
}

/// Of `ellgran_carry_wall`: the histories of one wall.
#[repr(C)]
pub struct CarryWallArguments<M: Memory> {
    /// Identifiers of the present grains.
    pub identifiers: M::Shared<i32>,
    /// Where grains were in the list before.
    pub slots: M::Shared<AtomicU64>,
    /// Their states.
    pub states_before: M::Shared<u32>,
    /// Their histories.
    pub histories_before: M::Shared<f64>,
    /// Written.
    pub states: M::Parts<u32>,
    /// Written.
    pub histories: M::Parts<f64>,
    /// Doubles of a history.
    pub length: u32,
}
