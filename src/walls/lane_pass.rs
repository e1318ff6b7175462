// SPDX-License-Identifier: MIT OR Apache-2.0
//! The contacts of all particles with a wall, in lanes from the search to the sums: where a surface is found soon, most of the time would
//! go into carrying a contact from one place to the next.
//!
//! A particle that touches in more than one place, or whose contact the lanes hand back, is taken as `compute.rs` takes all. Forces are
//! computed in the frame of the world; what is remembered stays in that of the wall.

use super::compute::{add_forces_of_found, works_in_lanes, WallError, WallInput, WallOutput};
use super::contacts::{Frame, Places, Source};
use super::histories::WallHistoryLayout;
use super::lone_contacts::{LoneContact, LoneContacts};
use super::motion::Motion;
use super::part_in_lanes::{Axes, SearchInput, SurfaceInLanes};
use super::recalled::EndOfRecord;
use super::shape::{Shape, ShapeInLanes, WholePlane};
use super::touching_loads::TouchingLoads;
use super::wall::{Wall, WallLoad};
use crate::contact::forces::{ContactForces, MotionChange, Remembered};
use crate::contact::history;
use crate::contact::particle::{mass_of_inverse, response_to_torque};
use crate::contact::vectors_in_lanes::{load, put_in_lane, splat, Column, Columns};
use crate::contact::wall_batch::{BodyAtSurface, CurvedWall, ForcesAtSurface, PlacedAtSurface};
use crate::contact::{lane_law::constants_of, HistoryLayout, Laws, Step};
use crate::force::{largest_springs, PairLaw};
use crate::list::shapes::{Ellipsoids, Kind, Side, Spheroids};
use crate::list::{ParticleRecords, Shapes};
use crate::real::Real;
use crate::simd::{put, InstructionSet, Lanes, Line, Registers, Stage, MOST_LANES};
use crate::tallies::{InelasticLoad, Tallies};
use crate::vector::Vector3;
use core::marker::PhantomData;

/// What a call is given.
pub struct RecordsInput<'a> {
    /// The laws; a contact follows that of the particle's type and `wall_type`.
    pub laws: &'a Laws,
    /// The wall's type, counted from 1.
    pub wall_type: usize,
    /// The particles that may touch ([`Wall::near`]), in that order.
    pub near: ParticleRecords<'a>,
    /// Masses of all particles, where the engine keeps angular momenta.
    pub masses: Option<&'a [f64]>,
    /// Where the wall is and how it moves.
    pub motion: &'a Motion,
    /// The step.
    pub step: &'a Step,
    /// The instructions that it may use.
    pub instruction_set: InstructionSet,
}

impl Wall {
    /// Whether [`compute_wall_in_lanes`] serves. Lists of contacts, and energies of each particle, are made by
    /// [`compute_wall`](super::compute_wall) alone.
    pub fn is_taken_in_lanes(
        &self,
        laws: &Laws,
        wall_type: usize,
        set: InstructionSet,
        tallies: Option<&Tallies<'_>>,
    ) -> bool {
        let per_particle = |t: &Tallies<'_>| {
            t.particle_energies.is_some()
                || t.particle_virials.is_some()
                || t.inelastic_loads.is_some()
        };
        let asks_for_more =
            self.records_contacts || self.records_triangles || tallies.is_some_and(per_particle);
        !asks_for_more && (1..=laws.types()).all(|t| works_in_lanes(set, laws.get(t, wall_type)))
    }
}

/// All particles against a wall for which [`Wall::is_taken_in_lanes`] holds.
///
/// Where the wall keeps the loads that are not elastic, their torques answer to the engine's rotations: to angular momenta where there
/// are masses.
///
/// # Errors
/// Before anything is written.
pub fn compute_wall_in_lanes(
    wall: &mut Wall,
    input: &RecordsInput<'_>,
    output: &mut WallOutput<'_>,
    mut tallies: Option<&mut Tallies<'_>>,
) -> Result<WallLoad, WallError> {
    let layout = wall.histories(input.laws);
    let of_laws = input.laws.layout();
    wall.start_call();
    let mut pass = core::mem::take(&mut wall.lone);
    let places = SearchInput {
        near: input.near,
        indices: &wall.near,
        motion: input.motion,
        step: input.step,
    };
    pass.start(wall.shapes(), input.motion);
    // What this wall has written itself need not be looked at before anything is added.
    let is_own = layout.length() > 0 && wall.with_histories.are_written_in(layout);
    let in_place = EndOfRecord::of(&of_laws).filter(|_| is_own);
    // Where nothing has to be known of the contacts before, those with the only part are found as they are computed.
    let may_find = in_place.is_some() || layout.length() == 0;
    let only = match (pass.only_in_lanes(), &wall.parts[..]) {
        (Some(part), [shape]) if may_find => Some((part, &**shape)),
        _ => None,
    };
    if only.is_none() {
        pass.find(wall.shapes(), &places, input.instruction_set);
    }
    if in_place.is_some() {
        pass.last.clear();
    } else {
        let recalled = pass.recall(
            &wall.near,
            layout,
            &of_laws,
            output.histories,
            input.instruction_set,
        );
        if let Err(wrong) = recalled {
            wall.lone = pass;
            return Err(WallError::History(wrong));
        }
    }
    if let Some(t) = tallies.as_deref_mut() {
        t.start_step();
    }
    let mut load = WallLoad::default();
    AddForces {
        input,
        layout,
        of_laws: &of_laws,
        in_place,
        only,
        places: &places,
        near: &wall.near,
        part_forces: &mut wall.part_forces,
        touching_loads: (wall.keeps_inelastic_loads && tallies.is_some())
            .then_some(&mut wall.touching_loads),
        lone: &mut pass,
        histories: output.histories,
        forces: output.forces,
        torques: output.torques,
        tallies: tallies.as_deref_mut(),
        load: &mut load,
    }
    .run();
    pass.take_others(wall, input, output, tallies, &mut load);
    wall.remember(output.histories, output.acts_on, &pass.written);
    wall.lone = pass;
    load.crowded = wall.found.crowded();
    let motion = input.motion;
    load.power = load.force.dot(motion.velocity) + load.torque.dot(motion.angular_velocity);
    Ok(load)
}

impl LoneContacts {
    /// The only part, if lanes find the contacts with it and no surface of it moves in the frame of the wall.
    fn only_in_lanes(&self) -> Option<ShapeInLanes> {
        match &self.parts[..] {
            [only] if !self.with_velocities => only.shape,
            _ => None,
        }
    }

    /// The particles that the lanes do not take.
    fn take_others(
        &mut self,
        wall: &mut Wall,
        input: &RecordsInput<'_>,
        output: &mut WallOutput<'_>,
        tallies: Option<&mut Tallies<'_>>,
        load: &mut WallLoad,
    ) {
        self.others.sort_unstable();
        self.particles.clear();
        self.indices.clear();
        for &near in &self.others {
            self.particles.push(input.near.particle(near as usize));
            self.indices.push(wall.near[near as usize]);
        }
        let as_others = WallInput {
            laws: input.laws,
            wall_type: input.wall_type,
            near: &self.particles,
            motion: input.motion,
            step: input.step,
            instruction_set: input.instruction_set,
        };
        let places = Places {
            near: &self.particles,
            motion: input.motion,
            step: input.step,
            frame: Frame::Wall,
        };
        let layout = wall.histories(input.laws);
        self.find_contacts(wall, &places, layout, output.histories);
        if self.others.is_empty() {
            return;
        }
        let before = wall.touching_loads.all().len();
        add_forces_of_found(wall, &as_others, output, tallies, load);
        if let Some(masses) = input.masses {
            for touching in &mut wall.touching_loads.all_mut()[before..] {
                let body = &self.particles[touching.near].body;
                let response = response_to_torque(body, masses[touching.particle]);
                touching.load.respond(response);
            }
        }
    }
}

impl LoneContacts {
    /// The contacts of these particles, some of which have been searched.
    fn find_contacts(
        &self,
        wall: &mut Wall,
        places: &Places<'_>,
        layout: WallHistoryLayout,
        histories: &[f64],
    ) {
        let length = layout.length();
        let mut found = core::mem::take(&mut wall.found);
        found.start(layout);
        let is_alone = wall.part_count() == 1;
        let mut searched = &self.searched[..];
        for (index, (i, &particle)) in places.near.iter().zip(&self.indices).enumerate() {
            let near = self.others[index] as usize;
            let own = searched.iter().take_while(|s| s.near == near).count();
            let (of_particle, rest) = searched.split_at(own);
            searched = rest;
            let from = if own > 0 {
                Source::Searched(of_particle)
            } else {
                let shapes = wall.shapes();
                Source::Shapes { is_alone, shapes }
            };
            let histories = &histories[particle * length..(particle + 1) * length];
            found.add(from, places, i, (particle, index), histories);
        }
        wall.found = found;
    }
}

/// Adds the forces of the contacts that were found, remembers them, and names those that the lanes hand back.
struct AddForces<'p, 'i, 't> {
    input: &'p RecordsInput<'i>,
    layout: WallHistoryLayout,
    of_laws: &'p HistoryLayout,
    /// Where what the contacts go on from is read in the histories.
    in_place: Option<EndOfRecord>,
    /// The only part and its shape, if the contacts with it are not yet found.
    only: Option<(ShapeInLanes, &'p dyn Shape)>,
    places: &'p SearchInput<'i>,
    near: &'p [usize],
    part_forces: &'p mut [Vector3],
    touching_loads: Option<&'p mut TouchingLoads>,
    lone: &'p mut LoneContacts,
    histories: &'p mut [f64],
    forces: &'p mut [[f64; 3]],
    torques: &'p mut [[f64; 3]],
    tallies: Option<&'p mut Tallies<'t>>,
    load: &'p mut WallLoad,
}

/// What the lanes load of a contact beside the records.
#[repr(C, align(64))]
struct Numbers {
    outwards: Columns,
    /// A point of the plane.
    point: Columns,
    inverse_mass: Column,
    mass: Column,
    /// The ends of the records that they go on from, where these are read in place.
    ends: [Line; MOST_LANES],
    /// Normals out of the wall, in its frame, of surfaces that are in no lines.
    outwards_in_wall: Columns,
}

/// What the lanes write of a contact, a line each.
#[repr(C, align(64))]
struct Results {
    /// Force and torque.
    action: [Line; MOST_LANES],
    /// What is remembered of it, as [`WallHistoryLayout::write_one`] wants it.
    place: [Line; MOST_LANES],
    history: [Line; MOST_LANES],
    /// [`Loads`].
    loads: [[Line; MOST_LANES]; 2],
}

/// What each lane sums up.
struct Sums<S: Registers> {
    force: Vector3<Lanes<S>>,
    torque: Vector3<Lanes<S>>,
    /// Bounds of stiffness and damping.
    springs: [Lanes<S>; 2],
    energies: [Lanes<S>; 2],
    powers: [Lanes<S>; 2],
    virial: [Lanes<S>; 6],
    /// The viscous force on the wall and the frictional one, and their torques about its centre where it turns.
    forces: [Vector3<Lanes<S>>; 2],
    torques: [Vector3<Lanes<S>>; 2],
}

impl<'i> AddForces<'_, 'i, '_> {
    fn law(&self, contact: &LoneContact) -> &'i PairLaw {
        let particle_type = self.input.near.types[contact.near as usize] as usize;
        self.input.laws.get(particle_type, self.input.wall_type)
    }
}

impl AddForces<'_, '_, '_> {
    fn run(&mut self) {
        // Planes that do not turn are the simplest and the most frequent surface: they have a kernel of their own.
        match (self.input.near.shapes, self.lone.planes.is_empty()) {
            (Shapes::Ellipsoids, true) => self.of_kind::<Ellipsoids, true>(),
            (Shapes::Ellipsoids, false) => self.of_kind::<Ellipsoids, false>(),
            (_, true) => self.of_kind::<Spheroids, true>(),
            (_, false) => self.of_kind::<Spheroids, false>(),
        }
    }

    fn of_kind<K: Kind, const SURFACES: bool>(&mut self) {
        let set = self.input.instruction_set;
        set.run(OfKind::<K, SURFACES>(self, PhantomData));
    }
}

/// [`AddForces`] with the closed form of one kind of shape. Each kernel is compiled as a function of its own.
struct OfKind<'q, 'p, 'i, 't, K, const SURFACES: bool>(
    &'q mut AddForces<'p, 'i, 't>,
    PhantomData<K>,
);

impl<K: Kind, const SURFACES: bool> Stage for OfKind<'_, '_, '_, '_, K, SURFACES> {
    #[inline(always)]
    fn run<S: Registers>(self, registers: S) {
        self.0.add::<S, K, SURFACES>(registers);
    }
}

impl<'i> AddForces<'_, 'i, '_> {
    #[inline(always)]
    fn add<S: Registers, K: Kind, const SURFACES: bool>(&mut self, registers: S) {
        let zero = Lanes::splat(registers, 0.0);
        let null = Vector3::new(zero, zero, zero);
        let mut sums = Sums {
            force: null,
            torque: null,
            springs: [zero; 2],
            energies: [zero; 2],
            powers: [zero; 2],
            virial: [zero; 6],
            forces: [null; 2],
            torques: [null; 2],
        };
        let axes = if SURFACES {
            Axes::of(registers, self.input.motion)
        } else {
            None
        };
        let none = [Line::ZERO; MOST_LANES];
        let mut numbers = Numbers {
            outwards: Columns::default(),
            point: Columns::default(),
            inverse_mass: Column::default(),
            mass: Column::default(),
            ends: none,
            outwards_in_wall: Columns::default(),
        };
        let mut results = Results {
            action: none,
            place: none,
            history: none,
            loads: [none; 2],
        };
        let mut next = Next::new(self.input.laws.get(1, self.input.wall_type));
        while let Some((side, surface, count)) = self.next::<S, K, SURFACES>(registers, &mut next) {
            self.batch::<S, K, SURFACES>(
                registers,
                side,
                surface,
                &next,
                count,
                &axes,
                &mut numbers,
                &mut results,
                &mut sums,
            );
        }
        self.lone.put_written_in_order(next.written);
        self.add_sums(&sums);
    }

    /// The next batch: the bodies, their surfaces where these are in no lines, and how many contacts it has.
    #[inline(always)]
    #[allow(clippy::type_complexity)]
    fn next<S: Registers, K: Kind, const SURFACES: bool>(
        &mut self,
        registers: S,
        next: &mut Next<'i>,
    ) -> Option<(Side<S, K>, Option<SurfaceInLanes<S>>, usize)> {
        let input = self.input;
        let near = &input.near;
        while let Some((part, shape)) = self.only {
            let first = next.near;
            if first == near.count() {
                break;
            }
            let present = S::LANES.min(near.count() - first);
            next.near += present;
            let mut of_lanes = [near.record(first); MOST_LANES];
            for (lane, record) in of_lanes[..present].iter_mut().enumerate() {
                *record = near.record(first + lane);
            }
            let side = K::load(registers, &of_lanes);
            let (touching, unsure, behind, surface) = if SURFACES {
                let lanes = (first, present);
                let found = part.find::<S, K>(registers, shape, self.places, lanes, &side);
                (found.touching, found.unsure, 0, Some(found.surface))
            } else {
                let (touching, behind, _) = self.lone.planes[0].touch::<S, K>(registers, &side);
                (touching & ((1 << present) - 1), 0, behind, None)
            };
            for (lane, contact) in next.contacts[..present].iter_mut().enumerate() {
                *contact = LoneContact {
                    near: (first + lane) as u32,
                    is_behind: behind >> lane & 1 != 0,
                    turns: SURFACES && part.turns(),
                    ..LoneContact::default()
                };
            }
            // Where nearly all of them touch, the others are computed with them; else those that do are gathered.
            let nearly_all = 8 * touching.count_ones() as usize >= 7 * S::LANES
                && self.laws_of(next, present) == present;
            let listed = if nearly_all { 0 } else { touching };
            let mut lines = [[Line::ZERO; MOST_LANES]; 2];
            if let Some(surface) = surface.as_ref().filter(|_| listed != 0) {
                surface.put(registers, &mut lines);
            }
            let mut left = listed | unsure;
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                if unsure >> lane & 1 != 0 {
                    let shapes = core::iter::once(shape);
                    self.lone.search_one(shapes, self.places, first + lane);
                    continue;
                }
                self.lone.contacts.push(next.contacts[lane]);
                if SURFACES {
                    self.lone.surfaces.push([lines[0][lane], lines[1][lane]]);
                }
            }
            if nearly_all {
                next.taken = touching;
                next.index = 0;
                return Some((side, surface, present));
            }
        }
        if next.of_list == 0 {
            next.written = self.lone.written.len();
        }
        let first = next.of_list;
        let left = &self.lone.contacts[first..];
        if left.is_empty() {
            return None;
        }
        let most = S::LANES.min(left.len());
        next.contacts[..most].copy_from_slice(&left[..most]);
        let count = self.laws_of(next, most);
        next.index = first;
        next.of_list += count;
        next.taken = (1 << count) - 1;
        let mut of_lanes = [near.record(next.contacts[0].near as usize); MOST_LANES];
        for (lane, record) in of_lanes[..S::LANES].iter_mut().enumerate() {
            *record = near.record(next.contacts[lane.min(count - 1)].near as usize);
        }
        Some((K::load(registers, &of_lanes), None, count))
    }

    /// Sets the laws of the next contacts; for how many of these their terms are the same.
    #[inline(always)]
    fn laws_of(&self, next: &mut Next<'i>, most: usize) -> usize {
        let law = self.law(&next.contacts[0]);
        next.laws = [law; MOST_LANES];
        next.only = true;
        if self.input.laws.types() == 1 {
            return most;
        }
        for lane in 1..most {
            let other = self.law(&next.contacts[lane]);
            if !core::ptr::eq(other, law) {
                if other.kinds != law.kinds {
                    return lane;
                }
                next.only = false;
            }
            next.laws[lane] = other;
        }
        most
    }
}

/// The contacts of the next batch, and how far the pass is.
struct Next<'a> {
    contacts: [LoneContact; MOST_LANES],
    laws: [&'a PairLaw; MOST_LANES],
    /// Whether these are one law.
    only: bool,
    /// Bits of the contacts that act.
    taken: u32,
    /// The place of the first of those contacts that have been listed.
    index: usize,
    /// The first particle among those that may touch, and the first listed contact, that are in no batch yet.
    near: usize,
    of_list: usize,
    /// How many particles had been written when the first of the listed contacts came.
    written: usize,
}

impl<'a> Next<'a> {
    fn new(any: &'a PairLaw) -> Self {
        Next {
            contacts: [LoneContact::default(); MOST_LANES],
            laws: [any; MOST_LANES],
            only: true,
            taken: 0,
            index: 0,
            near: 0,
            of_list: 0,
            written: 0,
        }
    }
}

/// The contacts of a batch, and where the lanes find what they load of each. Lanes without a contact of their own compute the last one
/// again.
struct Batch<'b> {
    contacts: &'b [LoneContact],
    /// What each goes on from.
    lasts: [&'b Line; MOST_LANES],
    /// Bits of those that may go on from the record of which the end is known.
    continued: u32,
    /// Bits of those of which more is remembered than the lanes take.
    handed_over: u32,
    /// Its surface where that is in lines, and how fast it is in the frame of the wall; of a wall of planes alone not set.
    surfaces: [[&'b Line; MOST_LANES]; 2],
    velocities: [&'b Line; MOST_LANES],
    /// Whether one of the surfaces turns with the body's motion.
    turns: bool,
    /// The only plane of a wall that acts on one side.
    one_side: Option<&'b WholePlane>,
}

impl AddForces<'_, '_, '_> {
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    fn batch<S: Registers, K: Kind, const SURFACES: bool>(
        &mut self,
        registers: S,
        side: Side<S, K>,
        surface: Option<SurfaceInLanes<S>>,
        next: &Next<'_>,
        count: usize,
        axes: &Option<Axes<S>>,
        numbers: &mut Numbers,
        results: &mut Results,
        sums: &mut Sums<S>,
    ) {
        let input = self.input;
        let laws = &next.laws;
        let contacts = &next.contacts[..count];
        if let Some(surface) = surface.as_ref().filter(|_| SURFACES) {
            let n = surface.outwards_in_wall;
            n.x.store(&mut numbers.outwards_in_wall[0]);
            n.y.store(&mut numbers.outwards_in_wall[1]);
            n.z.store(&mut numbers.outwards_in_wall[2]);
        }
        let in_lines = surface.is_none();
        let batch = self.gather::<S, SURFACES>(contacts, (next.index, in_lines), numbers);
        let surface = match surface {
            Some(surface) if SURFACES => surface,
            _ if SURFACES => {
                SurfaceInLanes::read(registers, &batch.surfaces, batch.turns || axes.is_some())
            }
            _ => surface_of_planes(registers, &batch, numbers, side.centre),
        };
        let outwards = surface.outwards;
        let from_centre = side.centre - splat(registers, input.motion.centre());
        let mut seen = SeenFromWall {
            velocity: side.velocity - splat(registers, input.motion.velocity),
            omega: side.omega,
            change: change_of(registers, input, batch.contacts, side.centre),
        };
        let spins = SURFACES && input.motion.spins();
        if spins && !input.motion.along_itself {
            seen = seen.turning(registers, input.motion, input.step, from_centre);
        }
        let mut placed = PlacedAtSurface::new(
            registers,
            BodyAtSurface {
                body: side.body,
                outwards,
                height: surface.height,
                velocity: seen.velocity,
                omega: seen.omega,
                change: seen.change,
                effective_mass: masses_of(registers, &input.near, numbers),
            },
        );
        if spins && input.motion.along_itself {
            let spin = splat(registers, input.motion.angular_velocity);
            let more = splat(registers, input.motion.angular_velocity_change);
            let arm = from_centre + placed.point();
            placed.take_off(spin.cross(arm));
            placed.take_off_change(more.cross(arm));
        }
        if SURFACES && !self.lone.velocities.is_empty() {
            let v = Lanes::all(registers, registers.columns(&batch.velocities));
            placed.take_off(Vector3::new(v[0], v[1], v[2]));
            placed.take_off_change(Vector3::new(v[3], v[4], v[5]));
        }
        let remembered = match self.in_place {
            Some(end) => {
                let last = end.read(registers, &numbers.ends);
                recall_in_place(registers, last, batch.continued, axes, outwards, input.step)
            }
            None => recall(registers, &batch.lasts, axes, outwards, input.step),
        };
        let constants = constants_of(registers, laws, next.only.then_some(laws[0]));
        let kinds = &laws[0].kinds;
        let ForcesAtSurface { forces: f, hard } = if SURFACES && batch.turns {
            let wall = CurvedWall {
                direction: surface.direction,
                curvatures: surface.curvatures,
                turning_radii: surface.turning_radii,
            };
            placed.forces_at_curved(
                registers,
                kinds,
                &constants,
                &wall,
                true,
                &remembered,
                input.step,
            )
        } else {
            placed.forces(registers, kinds, &constants, &remembered, input.step)
        };

        let touching = registers.bits(placed.touching) & next.taken;
        let hard = touching & (registers.bits(hard) | batch.handed_over);
        let sound = touching & !hard;
        let mask = registers.mask(sound);
        let mass = placed.effective_mass();
        let springs = largest_springs(kinds, &constants, f.stiffness, mass);
        add_where(mask, &mut sums.springs[0], springs.0);
        add_where(mask, &mut sums.springs[1], springs.1);
        sums.add_load(mask, &f, from_centre);
        put_action(registers, &f, &mut results.action);
        if self.layout.length() > 0 {
            let mut place = [placed.point(), outwards, f.memory];
            if let (true, Some(axes)) = (SURFACES, axes) {
                place = [
                    axes.to_wall(place[0]),
                    surface.outwards_in_wall,
                    axes.to_wall(place[2]),
                ];
            }
            put_remembered(registers, self.of_laws, &f, place, results);
        }
        if self.tallies.is_some() {
            let with_loads = self.touching_loads.is_some();
            sums.add_energies(mask, &f);
            if with_loads && spins {
                sums.add_torques(mask, &f, from_centre);
            }
            if with_loads {
                let mut loads = Loads::of(&f);
                if input.masses.is_some() {
                    let mass = Lanes::load(registers, &numbers.mass);
                    loads = loads.respond::<K>(placed.body(), mass);
                }
                loads.put(registers, &mut results.loads);
            } else {
                add_where(mask, &mut sums.powers[0], f.viscous_power);
                add_where(mask, &mut sums.powers[1], f.tangential_power);
            }
        }
        self.scatter(contacts, [sound, hard], results);
    }

    /// Where the lanes find what they load of these contacts; numbers that do not stand in lines are written to `numbers`.
    #[inline(always)]
    fn gather<'b, S: Registers, const SURFACES: bool>(
        &'b self,
        contacts: &'b [LoneContact],
        (first, in_lines): (usize, bool),
        numbers: &mut Numbers,
    ) -> Batch<'b> {
        let near = &self.input.near;
        let lone = &*self.lone;
        let length = self.layout.length();
        let range = first..first + contacts.len();
        let last = lone.last.get(range.clone()).unwrap_or(&[]);
        let velocities = lone.velocities.get(range.clone()).unwrap_or(&[]);
        let surfaces = if SURFACES && in_lines {
            &lone.surfaces[range]
        } else {
            &[]
        };
        let masses = self.input.masses.filter(|_| self.touching_loads.is_some());
        let one_side = match &lone.planes[..] {
            [plane] if !SURFACES && !plane.both_sides => Some(plane),
            _ => None,
        };
        let mut batch = Batch {
            contacts,
            lasts: [&Line::ZERO; MOST_LANES],
            continued: 0,
            handed_over: 0,
            surfaces: [[&Line::ZERO; MOST_LANES]; 2],
            velocities: [&Line::ZERO; MOST_LANES],
            turns: false,
            one_side,
        };
        for lane in 0..S::LANES {
            let index = lane.min(contacts.len() - 1);
            let contact = &contacts[index];
            let place = contact.near as usize;
            if let Some(line) = last.get(index) {
                batch.lasts[lane] = line;
            }
            if self.in_place.is_some() {
                let k = self.near[place];
                let row = &self.histories[k * length..(k + 1) * length];
                // Of several contacts with one part the nearest is meant.
                batch.handed_over |= u32::from(SURFACES && row[0] > 1.0) << lane;
                let inwards = || {
                    if SURFACES && !in_lines {
                        let [x, y, z] = &numbers.outwards_in_wall;
                        return -Vector3::new(x[index], y[index], z[index]);
                    }
                    -lone.outwards_of(contact, surfaces.get(index))
                };
                let end = (self.layout).end_of_record(row, contact.part as usize, inwards);
                batch.continued |= u32::from(end.is_some()) << lane;
                numbers.ends[lane] = end.map_or(Line::ZERO, |end| Line(*end));
            }
            if SURFACES {
                if let Some([a, b]) = surfaces.get(index) {
                    batch.surfaces[0][lane] = a;
                    batch.surfaces[1][lane] = b;
                }
                batch.turns |= contact.turns;
                if let Some(line) = velocities.get(index) {
                    batch.velocities[lane] = line;
                }
            } else if one_side.is_none() {
                let plane = &lone.planes[contact.part as usize];
                put_in_lane(&mut numbers.outwards, lane, plane.outwards(contact));
                put_in_lane(&mut numbers.point, lane, plane.point);
            }
            if let Some(inverse_mass) = near.inverse_masses.get(place) {
                numbers.inverse_mass[lane] = *inverse_mass;
            }
            if let Some(masses) = masses {
                numbers.mass[lane] = masses[self.near[place]];
            }
        }
        batch
    }

    /// From the lines of a batch to the arrays of the engine.
    #[inline(always)]
    fn scatter(&mut self, contacts: &[LoneContact], [sound, hard]: [u32; 2], results: &Results) {
        let length = self.layout.length();
        for (lane, contact) in contacts.iter().enumerate() {
            if hard >> lane & 1 != 0 {
                self.lone.others.push(contact.near);
            }
            if sound >> lane & 1 == 0 {
                continue;
            }
            let k = self.near[contact.near as usize];
            self.load.contacts += 1;
            let acting = &results.action[lane].0;
            for axis in 0..3 {
                self.forces[k][axis] -= acting[axis];
                self.torques[k][axis] += acting[3 + axis];
            }
            let part = contact.part as usize;
            if self.part_forces.len() > 1 {
                let force = Vector3::new(acting[0], acting[1], acting[2]);
                self.part_forces[part] = self.part_forces[part] + force;
            }
            if length > 0 {
                let histories = &mut self.histories[k * length..(k + 1) * length];
                let (place, history) = (&results.place[lane].0, &results.history[lane].0);
                self.layout.write_one(histories, part, place, history);
                self.lone.written.push(k);
            }
            if let Some(loads) = self.touching_loads.as_deref_mut() {
                let [c, d] = [0, 1].map(|k| &results.loads[k][lane].0);
                loads.push(
                    k,
                    contact.near as usize,
                    InelasticLoad {
                        viscous_force: [c[0], c[1], c[2]],
                        viscous_torque: [c[3], c[4], c[5]],
                        tangential_force: [c[6], c[7], d[0]],
                        tangential_torque: [d[1], d[2], d[3]],
                    },
                );
            }
        }
    }

    /// What the lanes have summed up, at the end.
    #[inline(always)]
    fn add_sums<S: Registers>(&mut self, sums: &Sums<S>) {
        let load = &mut *self.load;
        load.force = load.force + total_vector(sums.force);
        load.torque = load.torque + total_vector(sums.torque);
        load.stiffness += total(sums.springs[0]);
        load.damping += total(sums.springs[1]);
        if let [only] = self.part_forces {
            *only = *only + load.force;
        }
        let Some(t) = self.tallies.as_deref_mut() else {
            return;
        };
        t.touching += load.contacts as f64;
        t.pairs += load.contacts as u64;
        t.normal_elastic_energy += total(sums.energies[0]);
        t.tangential_elastic_energy += total(sums.energies[1]);
        for k in 0..6 {
            t.virial[k] += total(sums.virial[k]);
        }
        if self.touching_loads.is_some() {
            let motion = self.input.motion;
            for (k, power) in t.wall_powers.iter_mut().enumerate() {
                let [force, torque] = [sums.forces[k], sums.torques[k]].map(total_vector);
                *power += force.dot(motion.velocity) + torque.dot(motion.angular_velocity);
                let sum = &mut load.inelastic[k];
                sum.force = sum.force + force;
                sum.torque = sum.torque + torque;
            }
        } else {
            let time = self.input.step.elapsed();
            t.viscous_dissipation += time * total(sums.powers[0]);
            t.tangential_work += time * total(sums.powers[1]);
        }
    }
}

// Functions that are always inlined, and no closures: arithmetic in a function of its own does not have the kernel's instructions.

/// Sum of the lanes.
#[inline(always)]
fn total<S: Registers>(a: Lanes<S>) -> f64 {
    let mut numbers = [0.0; MOST_LANES];
    a.store(&mut numbers);
    let mut sum = 0.0;
    for number in &numbers[..S::LANES] {
        sum += number;
    }
    sum
}

/// The same of a vector.
#[inline(always)]
fn total_vector<S: Registers>(a: Vector3<Lanes<S>>) -> Vector3 {
    Vector3::new(total(a.x), total(a.y), total(a.z))
}

/// Adds where the mask holds.
#[inline(always)]
fn add_where<S: Registers>(mask: S::Mask, sum: &mut Lanes<S>, a: Lanes<S>) {
    *sum = *sum + Lanes::select(mask, a, a.constant(0.0));
}

/// The same of a vector.
#[inline(always)]
fn add_vector_where<S: Registers>(
    mask: S::Mask,
    sum: &mut Vector3<Lanes<S>>,
    a: Vector3<Lanes<S>>,
) {
    add_where(mask, &mut sum.x, a.x);
    add_where(mask, &mut sum.y, a.y);
    add_where(mask, &mut sum.z, a.z);
}

/// The surfaces of a batch at planes.
#[inline(always)]
fn surface_of_planes<S: Registers>(
    registers: S,
    batch: &Batch<'_>,
    numbers: &Numbers,
    centre: Vector3<Lanes<S>>,
) -> SurfaceInLanes<S> {
    let (outwards, point) = match batch.one_side {
        Some(plane) => (
            splat(registers, plane.normal),
            splat(registers, plane.point),
        ),
        None => (
            load(registers, &numbers.outwards),
            load(registers, &numbers.point),
        ),
    };
    let height = outwards.dot(centre - point);
    SurfaceInLanes::flat(registers, outwards, height, outwards)
}

/// The masses of the particles against a wall that nothing moves; 0 where no law reads them.
#[inline(always)]
fn masses_of<S: Registers>(
    registers: S,
    near: &ParticleRecords<'_>,
    numbers: &Numbers,
) -> Lanes<S> {
    let zero = Lanes::splat(registers, 0.0);
    if near.inverse_masses.is_empty() {
        return zero;
    }
    mass_of_inverse(Lanes::load(registers, &numbers.inverse_mass))
}

/// What the motions of the particles have more at the step, where forces see velocities of the step, less that of the wall's velocity.
#[inline(always)]
fn change_of<S: Registers>(
    registers: S,
    input: &RecordsInput<'_>,
    contacts: &[LoneContact],
    centre: Vector3<Lanes<S>>,
) -> Option<MotionChange<Lanes<S>>> {
    let near = &input.near;
    if !near.of_step {
        return None;
    }
    let zero = Lanes::splat(registers, 0.0);
    let null = Vector3::new(zero, zero, zero);
    let mut own = MotionChange {
        velocity: null,
        omega: null,
    };
    if !near.changes.is_empty() {
        let mut changes = [&Line::ZERO; MOST_LANES];
        for lane in 0..S::LANES {
            let contact = &contacts[lane.min(contacts.len() - 1)];
            if let Some(change) = near.line_of_change(contact.near as usize) {
                changes[lane] = change;
            }
        }
        let c = Lanes::all(registers, registers.columns(&changes));
        own.velocity = Vector3::new(c[0], c[1], c[2]);
        own.omega = Vector3::new(c[3], c[4], c[5]);
        own.velocity = own.at(centre);
    }
    own.velocity = own.velocity - splat(registers, input.motion.velocity_change);
    Some(own)
}

/// What the contacts go on from, in the frame of the world; `axes` are those of a wall that has turned.
#[inline(always)]
fn recall<S: Registers>(
    registers: S,
    lasts: &[&Line; MOST_LANES],
    axes: &Option<Axes<S>>,
    outwards: Vector3<Lanes<S>>,
    step: &Step,
) -> Remembered<Lanes<S>> {
    let zero = Lanes::splat(registers, 0.0);
    let l = Lanes::all(registers, registers.columns(lasts));
    let continued = zero.less(l[7]);
    let mut normal = Vector3::new(l[0], l[1], l[2]);
    let mut memory = Vector3::new(l[3], l[4], l[5]);
    if let Some(axes) = axes {
        normal = axes.to_world(normal);
        memory = axes.to_world(memory);
    }
    let time = Lanes::splat(registers, step.elapsed());
    // A law that remembers what relaxes is taken one contact at a time.
    Remembered::of(continued, -outwards, (normal, memory, l[6]), time)
}

/// The same from numbers that calls have written, of the contacts whose bit is set.
#[inline(always)]
fn recall_in_place<S: Registers>(
    registers: S,
    (mut normal, mut memory, energy): (Vector3<Lanes<S>>, Vector3<Lanes<S>>, Lanes<S>),
    continued: u32,
    axes: &Option<Axes<S>>,
    outwards: Vector3<Lanes<S>>,
    step: &Step,
) -> Remembered<Lanes<S>> {
    if let Some(axes) = axes {
        normal = axes.to_world(normal);
        memory = axes.to_world(memory);
    }
    // A contact moves over the surface, but it does not jump.
    let least = energy.constant(0.5);
    let is_same = registers.not((-normal.dot(outwards)).less(least));
    let continued = registers.and(registers.mask(continued), is_same);
    let time = Lanes::splat(registers, step.elapsed());
    Remembered::of(continued, -outwards, (normal, memory, energy), time)
}

/// The motion of the bodies relative to a wall, and what it has more at the step, in the frame of the world
/// ([`Motion::seen_from_wall`]).
struct SeenFromWall<S: Registers> {
    velocity: Vector3<Lanes<S>>,
    omega: Vector3<Lanes<S>>,
    change: Option<MotionChange<Lanes<S>>>,
}

impl<S: Registers> SeenFromWall<S> {
    /// The same where the wall turns; until here its velocity alone was taken off.
    #[inline(always)]
    fn turning(
        self,
        registers: S,
        motion: &Motion,
        step: &Step,
        from_centre: Vector3<Lanes<S>>,
    ) -> Self {
        let half = Motion::half_step(step, self.change.is_some());
        let half = Lanes::splat(registers, half);
        let spin = splat(registers, motion.angular_velocity);
        let SeenFromWall {
            velocity,
            omega,
            change,
        } = self;
        let moved = velocity - spin.cross(from_centre - velocity * half);
        let turned = omega - spin;
        let moved = spin.cross(moved).scale_add(half, moved);
        let turned_half = spin.cross(turned).scale_add(half, turned);
        let mut seen = SeenFromWall {
            velocity: moved,
            omega: turned_half,
            change: None,
        };
        if let Some(change) = change {
            let more = splat(registers, motion.angular_velocity_change);
            let spin_at_step = spin + more;
            let velocity_at_step = velocity + change.velocity - spin_at_step.cross(from_centre);
            let omega_at_step = turned + change.omega - more;
            seen.change = Some(MotionChange {
                velocity: velocity_at_step - moved,
                omega: omega_at_step - turned_half,
            });
        }
        seen
    }
}

impl<S: Registers> Sums<S> {
    /// Adds what acts on the wall.
    #[inline(always)]
    fn add_load(
        &mut self,
        sound: S::Mask,
        f: &ContactForces<Lanes<S>>,
        from_centre: Vector3<Lanes<S>>,
    ) {
        add_vector_where(sound, &mut self.force, f.force);
        let torque = from_centre.cross(f.force) - f.torque_i;
        add_vector_where(sound, &mut self.torque, torque);
    }

    /// Adds energies, virial, and the forces on the wall that are not elastic.
    #[inline(always)]
    fn add_energies(&mut self, sound: S::Mask, f: &ContactForces<Lanes<S>>) {
        add_where(sound, &mut self.energies[0], f.elastic_energy);
        add_where(sound, &mut self.energies[1], f.tangential_energy);
        let d = f.contact_point;
        add_where(sound, &mut self.virial[0], d.x * f.force.x);
        add_where(sound, &mut self.virial[1], d.y * f.force.y);
        add_where(sound, &mut self.virial[2], d.z * f.force.z);
        add_where(sound, &mut self.virial[3], d.x * f.force.y);
        add_where(sound, &mut self.virial[4], d.x * f.force.z);
        add_where(sound, &mut self.virial[5], d.y * f.force.z);
        add_vector_where(sound, &mut self.forces[0], f.viscous_force);
        add_vector_where(sound, &mut self.forces[1], f.frictional_force);
    }

    /// Adds the torques of the forces on the wall that are not elastic, about its centre.
    #[inline(always)]
    fn add_torques(
        &mut self,
        sound: S::Mask,
        f: &ContactForces<Lanes<S>>,
        from_centre: Vector3<Lanes<S>>,
    ) {
        let arm = from_centre + f.contact_point;
        add_vector_where(sound, &mut self.torques[0], arm.cross(f.viscous_force));
        add_vector_where(sound, &mut self.torques[1], arm.cross(f.frictional_force));
    }
}

/// Forces on the bodies that are not elastic, the viscous one first, and their torques.
struct Loads<S: Registers> {
    forces: [Vector3<Lanes<S>>; 2],
    torques: [Vector3<Lanes<S>>; 2],
}

impl<S: Registers> Loads<S> {
    #[inline(always)]
    fn of(f: &ContactForces<Lanes<S>>) -> Self {
        let forces = [-f.viscous_force, -f.frictional_force];
        let torques = [
            f.contact_point.cross(forces[0]),
            f.contact_point.cross(forces[1]),
        ];
        Loads { forces, torques }
    }

    /// The same with the inverse inertia of solid ellipsoids times the torques.
    #[inline(always)]
    fn respond<K: Kind>(self, body: &K::Body<S>, mass: Lanes<S>) -> Self {
        let torques = [
            K::response(body, mass, self.torques[0]),
            K::response(body, mass, self.torques[1]),
        ];
        Loads { torques, ..self }
    }

    #[inline(always)]
    fn put(&self, registers: S, [a, b]: &mut [[Line; MOST_LANES]; 2]) {
        let ([v, t], [of_v, of_t]) = (&self.forces, &self.torques);
        let zero = v.x.constant(0.0);
        let first = [v.x, v.y, v.z, of_v.x, of_v.y, of_v.z, t.x, t.y];
        put(registers, first, a);
        let second = [t.z, of_t.x, of_t.y, of_t.z, zero, zero, zero, zero];
        put(registers, second, b);
    }
}

/// Writes force and torque.
#[inline(always)]
fn put_action<S: Registers>(
    registers: S,
    f: &ContactForces<Lanes<S>>,
    lines: &mut [Line; MOST_LANES],
) {
    let (a, b) = (f.force, f.torque_i);
    let zero = a.x.constant(0.0);
    put(registers, [a.x, a.y, a.z, b.x, b.y, b.z, zero, zero], lines);
}

/// Writes what is remembered.
#[inline(always)]
fn put_remembered<S: Registers>(
    registers: S,
    layout: &HistoryLayout,
    f: &ContactForces<Lanes<S>>,
    [p, outwards, m]: [Vector3<Lanes<S>>; 3],
    results: &mut Results,
) {
    let zero = p.x.constant(0.0);
    let n = -outwards;
    let place = [zero.constant(1.0), zero, p.x, p.y, p.z, n.x, n.y, n.z];
    put(registers, place, &mut results.place);
    let mut history = [zero; 8];
    history::write(layout, &mut history, (n, m, f.tangential_energy));
    put(registers, history, &mut results.history);
}
