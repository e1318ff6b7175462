// SPDX-License-Identifier: MIT OR Apache-2.0
//! The entries: what a thread does with which arrays. One thread for each grain, each of its components, some contacts or some rows, in a
//! grid of one dimension. Every
//! kernel takes the number of threads first, and then one struct of `ellgran_kernels::arguments`.
//!
//! This file is compiled twice: for a device, and for a host that stands in for one in tests, each with a `memory` of its own.

use crate::memory::{entries, Here};
use core::sync::atomic::{AtomicU32, Ordering};
use ellgran::contact::history::Remembers;
use ellgran::contact::{HistoryLayout, Step};
use ellgran::geometry::Plane;
use ellgran::motion::Refusal;
use ellgran_kernels::arguments::{
    CandidateArguments, CarryPairsArguments, CarryWallArguments, ContactArguments, FileArguments,
    MotionArguments, MovedArguments, NumberArguments, PlaneArguments, PoseArguments,
    PrepareArguments, SceneArguments, ShapeArguments, SumArguments, TermArguments, CANDIDATES,
    FAULT, FOUND, KEPT, MARKED, MOVED, NO_SPHERE, NO_SPHEROID, ROWS_NUMBERED, SELECTIONS,
};
use ellgran_kernels::candidates::{candidates_of_grain, NewRow};
use ellgran_kernels::contacts::{contact_of_pair, marked_contact_of_pair, Scene};
use ellgran_kernels::integration::{finish_step_of_grain, start_step_of_grain, Moving};
use ellgran_kernels::pair_memory::{
    carry_pairs, carry_wall, fault_of_row, file, find, CarriedRow, PairsBefore,
};
use ellgran_kernels::planes::{contact_with_plane, MovingPlane};
use ellgran_kernels::poses::{has_moved, remembered_pose};
use ellgran_kernels::preparation::{inverse_mass, prepare_grain, EngineArrays};
use ellgran_kernels::shapes::{Ellipsoids, Kind, Spheres, Spheroids};
use ellgran_kernels::terms::{
    component_of_load, number_rows, terms_of_grain, Candidates, COMPONENTS,
};

/// Leaves a note. Many threads may leave the same one.
#[inline(always)]
fn note(notes: &[AtomicU32], which: usize) {
    notes[which].store(1, Ordering::Relaxed);
}

#[inline(always)]
fn is_noted(notes: &[AtomicU32], which: usize) -> bool {
    notes[which].load(Ordering::Relaxed) != 0
}

/// What all threads of a contact kernel read; `friction` says whether histories have a tangential part.
#[inline(always)]
fn scene_of(arrays: &SceneArguments<Here>, friction: bool) -> Scene<'_> {
    Scene {
        grains: arrays.grains.all(),
        changes: arrays.changes.all(),
        types: arrays.types.all(),
        inverse_masses: arrays.inverse_masses.all(),
        identifiers: arrays.identifiers.all(),
        laws: arrays.laws.all(),
        type_count: arrays.type_count,
        layout: HistoryLayout::new(Remembers {
            normal: arrays.cached_normal != 0,
            tangential: friction,
            energy: arrays.rescaled != 0,
            ..Remembers::default()
        }),
        step: Step {
            time_step: arrays.time_step,
            advance_history: arrays.advance_history != 0,
        },
    }
}

macro_rules! prepare {
    ($($name:ident: $kind:ty;)*) => {
        entries! {$(
            /// Prepares grains.
            fn $name(thread, arguments: PrepareArguments<Here>) {
                let a = &arguments;
                let arrays = EngineArrays {
                    positions: a.positions.all(),
                    velocities: a.velocities.all(),
                    angular_momenta: a.angular_momenta.all(),
                    changes: a.changes.all(),
                    masses: a.masses.all(),
                    semi_axes: a.semi_axes.all(),
                    quaternions: a.quaternions.all(),
                    types: a.types.all(),
                    type_count: a.type_count,
                };
                let outcome = prepare_grain::<$kind>(thread.index(), &arrays);
                let inverse_mass = inverse_mass(thread.index(), &arrays);
                let PrepareArguments {
                    mut grains,
                    mut motion_changes,
                    mut inverse_masses,
                    mut faults,
                    notes,
                    ..
                } = arguments;
                match outcome {
                    Ok((grain, change)) => {
                        *grains.one(&thread) = grain;
                        if !motion_changes.is_empty() {
                            *motion_changes.one(&thread) = change;
                        }
                        if !inverse_masses.is_empty() {
                            *inverse_masses.one(&thread) = inverse_mass;
                        }
                    }
                    Err(fault) => {
                        let first = faults.one(&thread);
                        if *first == 0 {
                            *first = fault as u32;
                        }
                        note(notes.all(), FAULT);
                    }
                }
            }
        )*}
    };
}

prepare! {
    ellgran_prepare_spheres: Spheres;
    ellgran_prepare_spheroids: Spheroids;
    ellgran_prepare_ellipsoids: Ellipsoids;
}

macro_rules! candidates {
    ($($name:ident: $kind:ty;)*) => {
        entries! {$(
            /// Selects the candidates that each row keeps.
            fn $name(thread, arguments: CandidateArguments<Here>) {
                let CandidateArguments {
                    scene,
                    starts,
                    neighbours,
                    mut places,
                    mut states,
                    mut histories,
                    mut counts,
                    notes,
                    margin,
                    always,
                } = arguments;
                if always == 0 && !is_noted(notes.all(), MOVED) {
                    return;
                }
                let scene = scene_of(&scene, scene.tangential != 0);
                let length = scene.layout.length;
                let starts = starts.all();
                let k = thread.index();
                let (from, to) = (starts[k] as usize, starts[k + 1] as usize);
                let mut row = NewRow {
                    neighbours: &neighbours.all()[from..to],
                    places: places.row(&thread, starts, 1),
                    states: states.row(&thread, starts, 1),
                    histories: histories.row(&thread, starts, length),
                };
                let owned = starts.len() - 1;
                let found = candidates_of_grain::<$kind>(k, &scene, owned, margin, &mut row);
                *counts.one(&thread) = found as u32;
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
            /// Writes the loads of all contacts but those that it marks.
            fn $name(thread, arguments: ContactArguments<Here>) {
                let ContactArguments {
                    scene,
                    candidates,
                    mut states,
                    mut histories,
                    mut contact_loads,
                    mut marked,
                    notes,
                } = arguments;
                let scene = scene_of(&scene, $friction);
                let (length, notes) = (scene.layout.length, notes.all());
                let candidates = candidates.all();
                let count = notes[CANDIDATES].load(Ordering::Relaxed) as usize;
                for own in thread.numbers(count) {
                    let candidate = candidates[own.number()];
                    let entry = own.within(|_| candidate.entry);
                    let found = contact_of_pair::<$kind, $friction, true, $conservative>(
                        &scene,
                        scene.in_order(candidate.grain as usize, candidate.other as usize),
                        states.at(&entry),
                        histories.part(&entry, length),
                    );
                    match found {
                        Some(load) => *contact_loads.at(&own) = load,
                        None => marked.taken(&notes[MARKED], 1).1[0] = own.number() as u32,
                    }
                }
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
            /// Writes the loads of the contacts that are marked.
            fn $name(thread, arguments: ContactArguments<Here>) {
                let ContactArguments {
                    scene,
                    candidates,
                    mut states,
                    mut histories,
                    mut contact_loads,
                    mut marked,
                    notes,
                } = arguments;
                let scene = scene_of(&scene, scene.tangential != 0);
                let (length, notes) = (scene.layout.length, notes.all());
                let candidates = candidates.all();
                let count = notes[MARKED].load(Ordering::Relaxed) as usize;
                for place in thread.numbers(count) {
                    let number = *marked.at(&place);
                    let own = place.within(|_| number);
                    let candidate = candidates[own.number()];
                    let entry = own.within(|_| candidate.entry);
                    *contact_loads.at(&own) = marked_contact_of_pair::<$kind>(
                        &scene,
                        scene.in_order(candidate.grain as usize, candidate.other as usize),
                        states.at(&entry),
                        histories.part(&entry, length),
                    );
                }
            }
        )*}
    };
}

// Spheres are spheroids to these.
marked_contacts! {
    ellgran_marked_contacts_spheroids: Spheroids;
    ellgran_marked_contacts_ellipsoids: Ellipsoids;
}

macro_rules! planes {
    ($($name:ident: $kind:ty, $friction:literal, $conservative:literal;)*) => {
        entries! {$(
            /// Adds the loads of a plane wall.
            fn $name(thread, arguments: PlaneArguments<Here>) {
                let PlaneArguments {
                    scene,
                    point,
                    normal,
                    velocity,
                    mut states,
                    mut histories,
                    mut loads,
                    wall_type,
                } = arguments;
                let scene = scene_of(&scene, $friction);
                let wall = MovingPlane {
                    plane: Plane { point, normal },
                    velocity,
                    wall_type,
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
    /// Numbers the candidates of some rows.
    fn ellgran_number_candidates(thread, arguments: NumberArguments<Here>) {
        let NumberArguments { counts, mut firsts, notes, always } = arguments;
        let notes = notes.all();
        if always == 0 && !is_noted(notes, MOVED) {
            return;
        }
        let from = thread.index() * ROWS_NUMBERED;
        let firsts = firsts.chunk(&thread, ROWS_NUMBERED);
        let counts = &counts.all()[from..from + firsts.len()];
        let found = counts.iter().sum();
        number_rows(counts, notes[FOUND].fetch_add(found, Ordering::Relaxed), firsts);
    }

    /// The candidates by their numbers, and which contacts add to the load of each grain.
    fn ellgran_terms(thread, arguments: TermArguments<Here>) {
        let TermArguments {
            identifiers,
            starts,
            neighbours,
            places,
            firsts,
            counts,
            mut candidates,
            mut terms,
            mut term_counts,
            notes,
            always,
        } = arguments;
        if always == 0 && !is_noted(notes.all(), MOVED) {
            return;
        }
        let all = Candidates {
            starts: starts.all(),
            neighbours: neighbours.all(),
            places: places.all(),
            firsts: firsts.all(),
            counts: counts.all(),
        };
        let own = candidates.range(&thread, all.firsts, all.counts);
        let terms = terms.row(&thread, all.starts, 1);
        let found = terms_of_grain(thread.index(), identifiers.all(), &all, own, terms);
        *term_counts.one(&thread) = found as u32;
    }

    /// The loads of all contacts of each grain.
    fn ellgran_sum_contacts(thread, arguments: SumArguments<Here>) {
        let SumArguments {
            starts,
            terms,
            term_counts,
            contact_loads,
            mut loads,
            notes,
        } = arguments;
        let (k, component) = (thread.index() / COMPONENTS, thread.index() % COMPONENTS);
        let from = starts.all()[k] as usize;
        let terms = &terms.all()[from..from + term_counts.all()[k] as usize];
        *loads.one(&thread) = component_of_load(terms, contact_loads.all(), component);
        if thread.index() == 0 {
            notes.all()[MARKED].store(0, Ordering::Relaxed);
        }
    }

    /// The first half of a step. `faults` gets what is wrong: 1 shape, 2 quaternion, 3 mass, 4 a turn of more than half a
    /// circle, 5 a rotation that grows within the step, 6 a semi-axis.
    fn ellgran_start_step(thread, arguments: MotionArguments<Here>) {
        let mut arrays = arguments;
        let time_step = arrays.time_step;
        let outcome = start_step_of_grain(moving!(arrays, thread), time_step);
        let fault = match outcome {
            Ok(()) => return,
            Err(Refusal::Shape) => 1,
            Err(Refusal::Quaternion(_)) => 2,
            Err(Refusal::Mass(_)) => 3,
            Err(Refusal::Turn(..)) => 4,
            Err(Refusal::Rotation) => 5,
            Err(Refusal::SemiAxis(_)) => 6,
        };
        let first = arrays.faults.one(&thread);
        if *first == 0 {
            *first = fault;
        }
        note(arrays.notes.all(), FAULT);
    }

    /// The second half of a step.
    fn ellgran_finish_step(thread, arguments: MotionArguments<Here>) {
        let mut arrays = arguments;
        let time_step = arrays.time_step;
        finish_step_of_grain(moving!(arrays, thread), time_step);
    }

    /// Notes whether a grain has moved too far for the candidates.
    fn ellgran_has_moved(thread, arguments: MovedArguments<Here>) {
        let MovedArguments { positions, quaternions, poses, notes, margin } = arguments;
        let k = thread.index();
        if has_moved(&poses.all()[k], positions.all()[k], quaternions.all()[k], margin) {
            note(notes.all(), MOVED);
        }
    }

    /// Remembers the poses in which candidates were selected.
    fn ellgran_remember_poses(thread, arguments: PoseArguments<Here>) {
        let PoseArguments { positions, quaternions, semi_axes, mut poses, notes, margin, always } = arguments;
        let notes = notes.all();
        if always == 0 && !is_noted(notes, MOVED) {
            return;
        }
        let k = thread.index();
        *poses.one(&thread) =
            remembered_pose(positions.all()[k], quaternions.all()[k], semi_axes.all()[k], margin);
        if k == 0 {
            notes[SELECTIONS].fetch_add(1, Ordering::Relaxed);
            notes[CANDIDATES].store(notes[FOUND].swap(0, Ordering::Relaxed), Ordering::Relaxed);
        }
    }

    /// Notes what the grains are not.
    fn ellgran_find_shapes(thread, arguments: ShapeArguments<Here>) {
        let ShapeArguments { semi_axes, notes } = arguments;
        let shape = semi_axes.all()[thread.index()];
        if !Spheres::takes(shape) {
            note(notes.all(), NO_SPHERE);
        }
        if !Spheroids::takes(shape) {
            note(notes.all(), NO_SPHEROID);
        }
    }

    /// Files where the grains of the list before were.
    fn ellgran_file_identifiers(thread, arguments: FileArguments<Here>) {
        let FileArguments { identifiers, slots } = arguments;
        let k = thread.index();
        file(slots.all(), identifiers.all()[k], k as u32);
    }

    /// Carries over what is remembered of pairs, and checks the rows. `faults` gets what is wrong with one.
    fn ellgran_carry_pairs(thread, arguments: CarryPairsArguments<Here>) {
        let CarryPairsArguments {
            identifiers,
            starts,
            neighbours,
            slots,
            starts_before,
            partners_before,
            states_before,
            histories_before,
            mut partners,
            mut states,
            mut histories,
            mut faults,
            notes,
            length,
        } = arguments;
        let (k, length, notes) = (thread.index(), length as usize, notes.all());
        let (identifiers, starts, neighbours) = (identifiers.all(), starts.all(), neighbours.all());
        let fault = fault_of_row(k, starts, neighbours, identifiers.len());
        if fault != 0 {
            *faults.one(&thread) = fault;
            note(notes, FAULT);
            return;
        }
        let pairs = PairsBefore {
            starts: starts_before.all(),
            partners: partners_before.all(),
            states: states_before.all(),
            histories: histories_before.all(),
        };
        let mut row = CarriedRow {
            neighbours: &neighbours[starts[k] as usize..starts[k + 1] as usize],
            partners: partners.row(&thread, starts, 1),
            states: states.row(&thread, starts, 1),
            histories: histories.row(&thread, starts, length),
        };
        let owned = starts.len() - 1;
        let kept = carry_pairs(k, owned, slots.all(), &pairs, identifiers, length, &mut row);
        notes[KEPT].fetch_add(kept, Ordering::Relaxed);
    }

    /// Carries over what is remembered of a wall.
    fn ellgran_carry_wall(thread, arguments: CarryWallArguments<Here>) {
        let CarryWallArguments {
            identifiers,
            slots,
            states_before,
            histories_before,
            mut states,
            mut histories,
            length,
        } = arguments;
        let before = find(slots.all(), identifiers.all()[thread.index()]);
        carry_wall(
            before,
            states_before.all(),
            histories_before.all(),
            states.one(&thread),
            histories.of(&thread, length as usize),
        );
    }
}
