// SPDX-License-Identifier: MIT OR Apache-2.0
//! The entries: what a thread does with which arrays. One thread for each grain, in a grid of one dimension. Every kernel takes the
//! number of grains first; arrays are a pointer and a length in elements.

use crate::memory::{entries, Parts, Shared, Thread};
use ellgran::contact::history::Remembers;
use ellgran::contact::{HistoryLayout, MotionChange, Step};
use ellgran::force::PairLaw;
use ellgran::geometry::Plane;
use ellgran::motion::Refusal;
use ellgran::vector::Vector3;
use ellgran_kernels::candidates::{candidates_of_grain, NewRow};
use ellgran_kernels::contacts::{contacts_of_grain, marked_contacts_of_grain, Load, Row, Scene};
use ellgran_kernels::integration::{finish_step_of_grain, start_step_of_grain, Moving};
use ellgran_kernels::planes::{contact_with_plane, MovingPlane};
use ellgran_kernels::preparation::{prepare_grain, EngineArrays};
use ellgran_kernels::shapes::{Ellipsoids, Grain, Spheres, Spheroids};

/// What all threads of a contact kernel read.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct SceneArrays {
    grains: Shared<Grain>,
    changes: Shared<MotionChange>,
    types: Shared<u32>,
    inverse_masses: Shared<f64>,
    identifiers: Shared<i32>,
    laws: Shared<PairLaw>,
    time_step: f64,
    type_count: u32,
    /// 1 where histories advance, 0 in the set-up of a run.
    advance_history: u32,
    /// 1 where a history begins with a normal.
    cached_normal: u32,
    /// 1 where some law has `displacement rescaled`.
    rescaled: u32,
}

impl SceneArrays {
    #[inline(always)]
    fn scene(&self, friction: bool) -> Scene<'_> {
        Scene {
            grains: self.grains.all(),
            changes: self.changes.all(),
            types: self.types.all(),
            inverse_masses: self.inverse_masses.all(),
            identifiers: self.identifiers.all(),
            laws: self.laws.all(),
            type_count: self.type_count,
            layout: HistoryLayout::new(Remembers {
                normal: self.cached_normal != 0,
                tangential: friction,
                energy: self.rescaled != 0,
                ..Remembers::default()
            }),
            step: Step {
                time_step: self.time_step,
                advance_history: self.advance_history != 0,
            },
        }
    }
}

/// Rows of a full neighbour list: row `k` is from `starts[k]` up to `starts[k + 1]`.
#[repr(C)]
pub struct RowArrays {
    starts: Shared<u32>,
    neighbours: Shared<u32>,
    /// Candidates of row `k` from `starts[k]` on, as many as `candidate_counts[k]`.
    candidates: Parts<u32>,
    candidate_counts: Parts<u32>,
    states: Parts<u32>,
    histories: Parts<f64>,
}

impl RowArrays {
    /// The thread's row with the candidates that were selected; `length` doubles a history.
    #[inline(always)]
    fn selected<'t>(&'t mut self, thread: &'t Thread, length: usize) -> Row<'t> {
        let (starts, k) = (self.starts.all(), thread.index());
        let count = *self.candidate_counts.one(thread) as usize;
        Row {
            neighbours: &self.neighbours.all()[starts[k] as usize..starts[k + 1] as usize],
            candidates: &self.candidates.row(thread, starts, 1)[..count],
            states: self.states.row(thread, starts, 1),
            histories: self.histories.row(thread, starts, length),
        }
    }
}

macro_rules! prepare {
    ($($name:ident: $kind:ty;)*) => {
        entries! {$(
            /// Prepares grains. `faults` gets 0, or the number of what is wrong.
            fn $name(
                thread,
                arrays: EngineNumbers,
                grains: Parts<Grain>,
                changes: Parts<MotionChange>,
                faults: Parts<u32>,
            ) {
                let (mut grains, mut changes, mut faults) = (grains, changes, faults);
                *faults.one(&thread) = match prepare_grain::<$kind>(thread.index(), &arrays.lent()) {
                    Ok((grain, change)) => {
                        *grains.one(&thread) = grain;
                        if !changes.is_empty() {
                            *changes.one(&thread) = change;
                        }
                        0
                    }
                    Err(fault) => fault as u32,
                };
            }
        )*}
    };
}

/// An engine's arrays.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct EngineNumbers {
    positions: Shared<[f64; 3]>,
    velocities: Shared<[f64; 3]>,
    angular_momenta: Shared<[f64; 3]>,
    changes: Shared<[f64; 6]>,
    masses: Shared<f64>,
    semi_axes: Shared<[f64; 3]>,
    quaternions: Shared<[f64; 4]>,
    types: Shared<u32>,
    type_count: u32,
}

impl EngineNumbers {
    #[inline(always)]
    fn lent(&self) -> EngineArrays<'_> {
        EngineArrays {
            positions: self.positions.all(),
            velocities: self.velocities.all(),
            angular_momenta: self.angular_momenta.all(),
            changes: self.changes.all(),
            masses: self.masses.all(),
            semi_axes: self.semi_axes.all(),
            quaternions: self.quaternions.all(),
            types: self.types.all(),
            type_count: self.type_count,
        }
    }
}

prepare! {
    ellgran_prepare_spheres: Spheres;
    ellgran_prepare_spheroids: Spheroids;
    ellgran_prepare_ellipsoids: Ellipsoids;
}

macro_rules! candidates {
    ($($name:ident: $kind:ty;)*) => {
        entries! {$(
            /// Selects the candidates. `friction` is 1 where histories have a tangential part.
            fn $name(thread, scene: SceneArrays, rows: RowArrays, margin: f64, friction: u32) {
                let mut rows = rows;
                let scene = scene.scene(friction != 0);
                let length = scene.layout.length;
                let starts = rows.starts.all();
                let k = thread.index();
                let neighbours = &rows.neighbours.all()[starts[k] as usize..starts[k + 1] as usize];
                let mut row = NewRow {
                    neighbours,
                    candidates: rows.candidates.row(&thread, starts, 1),
                    states: rows.states.row(&thread, starts, 1),
                    histories: rows.histories.row(&thread, starts, length),
                };
                let found = candidates_of_grain::<$kind>(k, &scene, margin, &mut row);
                *rows.candidate_counts.one(&thread) = found as u32;
            }
        )*}
    };
}

candidates! {
    ellgran_candidates_spheres: Spheres;
    ellgran_candidates_spheroids: Spheroids;
    ellgran_candidates_ellipsoids: Ellipsoids;
}

macro_rules! contacts {
    ($($name:ident: $kind:ty, $friction:literal, $conservative:literal;)*) => {
        entries! {$(
            /// Writes the loads of all contacts but those that are marked.
            fn $name(thread, scene: SceneArrays, rows: RowArrays, loads: Parts<Load>) {
                let (mut rows, mut loads) = (rows, loads);
                let scene = scene.scene($friction);
                let mut row = rows.selected(&thread, scene.layout.length);
                *loads.one(&thread) =
                    contacts_of_grain::<$kind, $friction, true, $conservative>(thread.index(), &scene, &mut row);
            }
        )*}
    };
}

// A kernel serves all laws that have no other terms than its own. On spheres the conservative terms vanish.
contacts! {
    ellgran_contacts_spheres: Spheres, false, false;
    ellgran_contacts_spheres_friction: Spheres, true, false;
    ellgran_contacts_spheroids_conservative: Spheroids, false, true;
    ellgran_contacts_spheroids_friction: Spheroids, true, false;
    ellgran_contacts_spheroids_friction_conservative: Spheroids, true, true;
    ellgran_contacts_ellipsoids_conservative: Ellipsoids, false, true;
    ellgran_contacts_ellipsoids_friction: Ellipsoids, true, false;
    ellgran_contacts_ellipsoids_friction_conservative: Ellipsoids, true, true;
}

macro_rules! marked_contacts {
    ($($name:ident: $kind:ty;)*) => {
        entries! {$(
            /// Adds the loads of the contacts that are marked.
            fn $name(thread, scene: SceneArrays, rows: RowArrays, loads: Parts<Load>, friction: u32) {
                let (mut rows, mut loads) = (rows, loads);
                let scene = scene.scene(friction != 0);
                let mut row = rows.selected(&thread, scene.layout.length);
                let added = marked_contacts_of_grain::<$kind>(thread.index(), &scene, &mut row);
                *loads.one(&thread) += added;
            }
        )*}
    };
}

// Spheres are spheroids to these.
marked_contacts! {
    ellgran_marked_contacts_spheroids: Spheroids;
    ellgran_marked_contacts_ellipsoids: Ellipsoids;
}

/// A plane wall.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct PlaneNumbers {
    point: Vector3,
    normal: Vector3,
    velocity: Vector3,
    wall_type: u32,
}

macro_rules! planes {
    ($($name:ident: $kind:ty, $friction:literal, $conservative:literal;)*) => {
        entries! {$(
            /// Adds the loads of a plane wall. States and histories are the grains' own with this wall.
            fn $name(
                thread,
                scene: SceneArrays,
                wall: PlaneNumbers,
                states: Parts<u32>,
                histories: Parts<f64>,
                loads: Parts<Load>,
            ) {
                let (mut states, mut histories, mut loads) = (states, histories, loads);
                let scene = scene.scene($friction);
                let wall = MovingPlane {
                    plane: Plane { point: wall.point, normal: wall.normal },
                    velocity: wall.velocity,
                    wall_type: wall.wall_type,
                };
                let length = scene.layout.length;
                let added = contact_with_plane::<$kind, $friction, true, $conservative>(
                    thread.index(),
                    &scene,
                    &wall,
                    states.one(&thread),
                    histories.of(&thread, length),
                );
                *loads.one(&thread) += added;
            }
        )*}
    };
}

// Spheres are spheroids to these, and laws without friction have histories without a tangential part.
planes! {
    ellgran_plane_spheroids_conservative: Spheroids, false, true;
    ellgran_plane_spheroids_friction_conservative: Spheroids, true, true;
    ellgran_plane_ellipsoids_conservative: Ellipsoids, false, true;
    ellgran_plane_ellipsoids_friction_conservative: Ellipsoids, true, true;
}

/// What motion reads and writes.
#[repr(C)]
pub struct MotionArrays {
    positions: Parts<[f64; 3]>,
    velocities: Parts<[f64; 3]>,
    angular_momenta: Parts<[f64; 3]>,
    quaternions: Parts<[f64; 4]>,
    semi_axes: Shared<[f64; 3]>,
    masses: Shared<f64>,
    loads: Shared<Load>,
    /// Empty where velocities are not extrapolated.
    changes: Parts<[f64; 6]>,
    loads_before: Parts<[f64; 6]>,
    step_ratio: f64,
    time_step: f64,
}

macro_rules! moving {
    ($arrays:ident, $thread:ident) => {{
        let k = $thread.index();
        Moving {
            position: $arrays.positions.one(&$thread),
            velocity: $arrays.velocities.one(&$thread),
            angular_momentum: $arrays.angular_momenta.one(&$thread),
            quaternion: $arrays.quaternions.one(&$thread),
            semi_axes: $arrays.semi_axes.all()[k],
            mass: $arrays.masses.all()[k],
            load: $arrays.loads.all()[k],
            extrapolation: if $arrays.changes.is_empty() {
                None
            } else {
                Some((
                    $arrays.changes.one(&$thread),
                    $arrays.loads_before.one(&$thread),
                    $arrays.step_ratio,
                ))
            },
        }
    }};
}

entries! {
    /// The first half of a step. `faults` gets 0, or what is wrong: 1 shape, 2 quaternion, 3 mass, 4 a turn of more than half a
    /// circle, 5 a rotation that grows within the step, 6 a semi-axis.
    fn ellgran_start_step(thread, arrays: MotionArrays, faults: Parts<u32>) {
        let (mut arrays, mut faults) = (arrays, faults);
        let time_step = arrays.time_step;
        let outcome = start_step_of_grain(moving!(arrays, thread), time_step);
        *faults.one(&thread) = match outcome {
            Ok(()) => 0,
            Err(Refusal::Shape) => 1,
            Err(Refusal::Quaternion(_)) => 2,
            Err(Refusal::Mass(_)) => 3,
            Err(Refusal::Turn(..)) => 4,
            Err(Refusal::Rotation) => 5,
            Err(Refusal::SemiAxis(_)) => 6,
        };
    }

    /// The second half of a step.
    fn ellgran_finish_step(thread, arrays: MotionArrays) {
        let mut arrays = arrays;
        let time_step = arrays.time_step;
        finish_step_of_grain(moving!(arrays, thread), time_step);
    }
}
