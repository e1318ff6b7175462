// SPDX-License-Identifier: MIT OR Apache-2.0
//! The entries: what a thread does with which arrays. One thread for each grain, each of its components, some contacts or some rows, in a
//! grid of one dimension. Every
//! kernel takes the number of threads first, and then one struct of `ellgran_kernels::arguments`.
//!
//! This file is compiled twice: for a device, and for a host that stands in for one in tests, each with a `memory` of its own.

use crate::memory::{entries, Here, Own, Thread};
use crate::scene::{add, is_noted, note, scene_of};
use core::sync::atomic::Ordering;
use ellgran::geometry::Plane;
use ellgran::motion::Refusal;
use ellgran::vector::Vector3;
use ellgran_kernels::arguments::{
    BodyArguments, CandidateArguments, CarryPairsArguments, CarryWallArguments, ContactArguments,
    FileArguments, MotionArguments, NumberArguments, PlaneArguments, PoseArguments,
    PrepareArguments, ShapeArguments, SumArguments, TermArguments, CANDIDATES, FAULT, FOUND, KEPT,
    MARKED, MOVED, NO_SPHERE, NO_SPHEROID, ROWS_NUMBERED, SELECTIONS,
};
use ellgran_kernels::candidates::{candidates_of_grain, Candidate, NewRow};
use ellgran_kernels::contacts::{contact_of_pair, marked_contact_of_pair, Load};
use ellgran_kernels::integration::{finish_step_of_grain, start_step_of_grain, Moving};
use ellgran_kernels::mixed::mixed_contact_of_pair;
use ellgran_kernels::pair_memory::{
    carry_pairs, carry_wall, fault_of_row, file, find, CarriedRow, PairsBefore,
};
use ellgran_kernels::planes::{contact_with_plane, MovingPlane};
use ellgran_kernels::poses::{has_moved, remembered_pose};
use ellgran_kernels::preparation::{prepare_grain, EngineGrain, Fault};
use ellgran_kernels::shapes::{Ellipsoids, Kind, Spheres, Spheroids};
use ellgran_kernels::terms::{
    component_of_load, number_rows, terms_of_grain, Candidates, Names, COMPONENTS,
};

/// What a table has for a number; without a table, the number itself.
#[inline(always)]
fn named(table: &[u32], number: usize) -> usize {
    if table.is_empty() {
        number
    } else {
        table[number] as usize
    }
}

/// The grain that a grain is, or is an image of.
#[inline(always)]
fn owner(bodies: &BodyArguments<Here>, k: usize) -> usize {
    named(bodies.owners.all(), k)
}

/// Whether shape and attitude of a grain are anywhere.
#[inline(always)]
fn has_body(bodies: &BodyArguments<Here>, k: usize) -> bool {
    let (places, owner) = (bodies.places.all(), owner(bodies, k));
    let count = bodies.quaternions.len();
    if places.is_empty() {
        owner < count
    } else {
        owner < places.len() && (places[owner] as usize) < count
    }
}

/// Semi-axes and quaternion of a grain.
#[inline(always)]
fn body(bodies: &BodyArguments<Here>, k: usize) -> ([f64; 3], [f64; 4]) {
    let place = named(bodies.places.all(), owner(bodies, k));
    (bodies.semi_axes.get(place), bodies.quaternions.get(place))
}

/// The grain as the engine has it.
#[inline(always)]
fn engine_grain(a: &PrepareArguments<Here>, k: usize) -> Result<EngineGrain, Fault> {
    if !has_body(&a.bodies, k) {
        return Err(Fault::Place);
    }
    let owner = owner(&a.bodies, k);
    let (semi_axes, quaternion) = body(&a.bodies, k);
    let changes = a.changes.all();
    Ok(EngineGrain {
        position: a.positions.get(k),
        velocity: a.velocities.get(owner),
        angular_momentum: a.angular_momenta.get(owner),
        change: if changes.is_empty() {
            [0.0; 6]
        } else {
            changes[owner]
        },
        mass: a.masses.all()[owner],
        semi_axes,
        quaternion,
        particle_type: a.types.all()[k],
        type_count: a.type_count,
    })
}

macro_rules! prepare {
    ($($name:ident: $kind:ty;)*) => {
        entries! {$(
            /// Prepares grains.
            fn $name(thread, arguments: PrepareArguments<Here>) {
                let k = thread.index();
                let outcome = engine_grain(&arguments, k).and_then(|given| {
                    let poses = arguments.poses.all();
                    let (x, q) = (given.position, given.quaternion);
                    if !poses.is_empty() && has_moved(&poses[k], x, q, arguments.margin) {
                        note(arguments.notes.all(), MOVED);
                    }
                    let (grain, change) = prepare_grain::<$kind>(&given)?;
                    Ok((grain, change, 1.0 / given.mass))
                });
                let PrepareArguments {
                    mut grains,
                    mut motion_changes,
                    mut inverse_masses,
                    mut faults,
                    notes,
                    ..
                } = arguments;
                match outcome {
                    Ok((grain, change, inverse_mass)) => {
                        *grains.at(&thread) = grain;
                        if !motion_changes.is_empty() {
                            *motion_changes.at(&thread) = change;
                        }
                        if !inverse_masses.is_empty() {
                            *inverse_masses.at(&thread) = inverse_mass;
                        }
                    }
                    Err(fault) => {
                        let first = faults.at(&thread);
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
                let owned = starts.len() - 1;
                for own in thread.numbers(owned) {
                    let k = own.number();
                    let (from, to) = (starts[k] as usize, starts[k + 1] as usize);
                    let mut row = NewRow {
                        neighbours: &neighbours.all()[from..to],
                        places: places.row(&own, starts, 1),
                        states: states.row(&own, starts, 1),
                        histories: histories.row(&own, starts, length),
                    };
                    let found = candidates_of_grain::<$kind>(k, &scene, owned, margin, &mut row);
                    *counts.at(&own) = found as u32;
                }
            }
        )*}
    };
}

candidates! {
    ellgran_candidates_spheres: Spheres;
    ellgran_candidates_spheroids: Spheroids;
    ellgran_candidates_ellipsoids: Ellipsoids;
}

/// The candidate of a number, and the number of its pair in the list: each pair is one candidate.
#[inline(always)]
fn pair_of(candidates: &[Candidate], own: &Own) -> (Candidate, Own) {
    let candidate = candidates[own.number()];
    (candidate, own.within(|_| candidate.entry))
}

macro_rules! contacts {
    ($of_pair:ident: $($name:ident: $kind:ty, $friction:literal, $conservative:literal;)*) => {
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
                    let (candidate, entry) = pair_of(candidates, &own);
                    let found = $of_pair::<$kind, $friction, true, $conservative>(
                        &scene,
                        &candidate,
                        states.at(&entry),
                        histories.part(&entry, length),
                    );
                    match found {
                        Some(load) => contact_loads.write(&own, load.values()),
                        None => marked.taken(&notes[MARKED], 1).1[0] = own.number() as u32,
                    }
                }
            }
        )*}
    };
}

// A kernel serves all laws that have no other terms than its own. On spheres the conservative terms vanish.
contacts! {
    contact_of_pair:
    ellgran_contacts_spheres: Spheres, false, false;
    ellgran_contacts_spheres_friction: Spheres, true, false;
    ellgran_contacts_spheroids_conservative: Spheroids, false, true;
    ellgran_contacts_spheroids_friction: Spheroids, true, false;
    ellgran_contacts_spheroids_friction_conservative: Spheroids, true, true;
    ellgran_contacts_ellipsoids_conservative: Ellipsoids, false, true;
    ellgran_contacts_ellipsoids_friction: Ellipsoids, true, false;
    ellgran_contacts_ellipsoids_friction_conservative: Ellipsoids, true, true;
}

// Two spheres have no search.
contacts! {
    mixed_contact_of_pair:
    ellgran_contacts_mixed_spheroids_conservative: Spheroids, false, true;
    ellgran_contacts_mixed_spheroids_friction: Spheroids, true, false;
    ellgran_contacts_mixed_spheroids_friction_conservative: Spheroids, true, true;
    ellgran_contacts_mixed_ellipsoids_conservative: Ellipsoids, false, true;
    ellgran_contacts_mixed_ellipsoids_friction: Ellipsoids, true, false;
    ellgran_contacts_mixed_ellipsoids_friction_conservative: Ellipsoids, true, true;
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
                    let (candidate, entry) = pair_of(candidates, &own);
                    let load = marked_contact_of_pair::<$kind>(
                        &scene,
                        &candidate,
                        states.at(&entry),
                        histories.part(&entry, length),
                    );
                    contact_loads.write(&own, load.values());
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
                    velocity_change,
                    mut states,
                    mut histories,
                    mut forces,
                    mut torques,
                    wall_type,
                } = arguments;
                let scene = scene_of(&scene, $friction);
                let wall = MovingPlane {
                    plane: Plane { point, normal },
                    velocity,
                    velocity_change,
                    wall_type,
                };
                let length = scene.layout.length;
                let state = states.at(&thread);
                let load = contact_with_plane::<$kind, $friction, true, $conservative>(
                    thread.index(),
                    &scene,
                    &wall,
                    state,
                    histories.part(&thread, length),
                );
                if *state != 0 {
                    add(&mut forces, &thread, load.force);
                    add(&mut torques, &thread, load.torque);
                }
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

/// Moves the thread's grain; of what it reads, it writes the motion, and with `TURNS` the place and the attitude.
#[inline(always)]
fn moved<const TURNS: bool, R>(
    arrays: &mut MotionArguments<Here>,
    thread: &Thread,
    act: impl FnOnce(Moving<'_>, f64) -> R,
) -> R {
    let k = thread.index();
    let body = thread.within(|k| named(arrays.places.all(), k) as u32);
    let mut position = arrays.positions.read(thread);
    let mut velocity = arrays.velocities.read(thread);
    let mut angular_momentum = arrays.angular_momenta.read(thread);
    let mut quaternion = arrays.quaternions.read(&body);
    let outcome = act(
        Moving {
            position: &mut position,
            velocity: &mut velocity,
            angular_momentum: &mut angular_momentum,
            quaternion: &mut quaternion,
            semi_axes: arrays.semi_axes.get(body.number()),
            mass: arrays.masses.all()[k],
            load: Load {
                force: Vector3::from_array(arrays.forces.get(k)),
                torque: Vector3::from_array(arrays.torques.get(k)),
            },
            extrapolation: if arrays.changes.is_empty() {
                None
            } else {
                Some((
                    arrays.changes.at(thread),
                    arrays.loads_before.at(thread),
                    arrays.step_ratio,
                ))
            },
        },
        arrays.time_step,
    );
    arrays.velocities.write(thread, velocity);
    arrays.angular_momenta.write(thread, angular_momentum);
    if TURNS {
        arrays.positions.write(thread, position);
        arrays.quaternions.write(&body, quaternion);
    }
    outcome
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
            types,
            type_count,
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
        let names = Names {
            identifiers: identifiers.all(),
            types: types.all(),
            type_count,
        };
        for row in thread.numbers(all.counts.len()) {
            let own = candidates.range(&row, all.firsts, all.counts);
            let terms = terms.row(&row, all.starts, 1);
            let found = terms_of_grain(row.number(), &names, &all, own, terms);
            *term_counts.at(&row) = found as u32;
        }
    }

    /// The loads of all contacts of each grain.
    fn ellgran_sum_contacts(thread, arguments: SumArguments<Here>) {
        let SumArguments {
            starts,
            terms,
            term_counts,
            contact_loads,
            mut forces,
            mut torques,
            notes,
            add,
        } = arguments;
        let own = thread.component_of(COMPONENTS);
        let k = own.vector();
        let from = starts.all()[k] as usize;
        let terms = &terms.all()[from..from + term_counts.all()[k] as usize];
        let read = |contact, number| contact_loads.component_of(contact, number);
        let sum = component_of_load(terms, read, own.component());
        let own_torque;
        let to = if own.component() < 3 {
            forces.component(&own)
        } else {
            own_torque = own.from(3);
            torques.component(&own_torque)
        };
        *to = if add == 0 { sum } else { *to + sum };
        if thread.index() == 0 {
            notes.all()[MARKED].store(0, Ordering::Relaxed);
        }
    }

    /// The first half of a step. `faults` gets what is wrong: 1 shape, 2 quaternion, 3 mass, 4 a turn of more than half a
    /// circle, 5 a rotation that grows within the step, 6 a semi-axis.
    fn ellgran_start_step(thread, arguments: MotionArguments<Here>) {
        let mut arrays = arguments;
        let outcome = moved::<true, _>(&mut arrays, &thread, start_step_of_grain);
        let fault = match outcome {
            Ok(()) => return,
            Err(Refusal::Shape) => 1,
            Err(Refusal::Quaternion(_)) => 2,
            Err(Refusal::Mass(_)) => 3,
            Err(Refusal::Turn(..)) => 4,
            Err(Refusal::Rotation) => 5,
            Err(Refusal::SemiAxis(_)) => 6,
        };
        let first = arrays.faults.at(&thread);
        if *first == 0 {
            *first = fault;
        }
        note(arrays.notes.all(), FAULT);
    }

    /// The second half of a step.
    fn ellgran_finish_step(thread, arguments: MotionArguments<Here>) {
        let mut arrays = arguments;
        moved::<false, _>(&mut arrays, &thread, finish_step_of_grain);
    }

    /// Remembers the poses in which candidates were selected.
    fn ellgran_remember_poses(thread, arguments: PoseArguments<Here>) {
        let PoseArguments { positions, bodies, mut poses, notes, margin, always } = arguments;
        let notes = notes.all();
        if always == 0 && !is_noted(notes, MOVED) {
            return;
        }
        for own in thread.numbers(poses.len()) {
            let k = own.number();
            let (semi_axes, quaternion) = body(&bodies, k);
            *poses.at(&own) = remembered_pose(positions.get(k), quaternion, semi_axes, margin);
        }
        if thread.index() == 0 {
            notes[SELECTIONS].fetch_add(1, Ordering::Relaxed);
            notes[CANDIDATES].store(notes[FOUND].swap(0, Ordering::Relaxed), Ordering::Relaxed);
        }
    }

    /// Notes what the grains are not.
    fn ellgran_find_shapes(thread, arguments: ShapeArguments<Here>) {
        let ShapeArguments { bodies, notes } = arguments;
        // Preparation tells of it.
        if !has_body(&bodies, thread.index()) {
            return;
        }
        let (shape, _) = body(&bodies, thread.index());
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
            *faults.at(&thread) = fault;
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
            states.at(&thread),
            histories.part(&thread, length as usize),
        );
    }
}
