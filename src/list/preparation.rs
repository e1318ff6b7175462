// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is made of the particles once a step, in lanes: unit quaternions, and angular velocities of angular momenta.
//!
//! Particles that follow each other in the engine's arrays are taken a block at a time. A block in which anything looks wrong is
//! done again particle by particle, which finds out what. Particles that are chosen from anywhere are copied into lines first.

use super::arrays::{prepare_one, ParticleArrays, ParticleShapes, Rotation};
use super::candidates::{AskedFor, Candidates};
use super::records::{prepare_record, Record, Records, Shapes, OWN};
use crate::contact::forces::MotionChange;
use crate::contact::particle::Particle;
use crate::contact::ranges::{
    is_mass, LARGEST_COORDINATE, LARGEST_MASS, LARGEST_VELOCITY, LEAST_MASS,
};
use crate::geometry::ellipsoid::{
    rotation_columns, LARGEST_ASPECT_RATIO, LARGEST_SEMI_AXIS, LEAST_SEMI_AXIS,
};
use crate::real::Real;
use crate::simd::{
    components, double_components, first_numbers, lines, put, Lanes, Line, Registers, Stage,
    MOST_LANES,
};
use crate::vector::Vector3;

/// Particles between the one that is prepared and the one whose record is asked for.
const AHEAD: usize = 24;

/// What a preparation came to.
#[derive(Debug, Default)]
pub(super) struct Prepared {
    /// Whether a particle has moved too far for the candidates; then not all of them are prepared.
    pub moved: bool,
    /// Whether a particle has another type than before.
    pub types_changed: bool,
    /// The first invalid particle, and what is wrong with it.
    pub failure: Option<(usize, String)>,
}

/// Prepares the particles that take part in the candidates, as long as these hold; or all.
pub(super) struct Prepare<'p, 'a, A: ParticleShapes, I: Fn(usize) -> i64> {
    pub arrays: &'p ParticleArrays<'a, A, I>,
    pub candidates: Option<&'p Candidates>,
    /// Types that there are.
    pub types: usize,
    /// Of the length of the arrays.
    pub records: &'p mut Records,
    pub outcome: &'p mut Prepared,
}

impl<A: ParticleShapes, I: Fn(usize) -> i64> Stage for Prepare<'_, '_, A, I> {
    #[inline(always)]
    fn run<S: Registers>(self, registers: S) {
        // Two copies of the loop, so that scenes without changes of velocities pay nothing for them.
        if self.arrays.changes.is_empty() {
            self.prepare::<S, false>(registers);
        } else {
            self.prepare::<S, true>(registers);
        }
    }
}

impl<A: ParticleShapes, I: Fn(usize) -> i64> Prepare<'_, '_, A, I> {
    #[inline(always)]
    fn prepare<S: Registers, const CHANGES: bool>(mut self, registers: S) {
        let n = self.arrays.positions.len();
        let mut first = 0;
        while first < n {
            let count = S::LANES.min(n - first);
            if !self.block::<S, CHANGES>(registers, first, count) {
                return;
            }
            first += S::LANES;
        }
    }

    /// The particles from `first` on; whether the preparation goes on.
    #[inline(always)]
    fn block<S: Registers, const CHANGES: bool>(
        &mut self,
        registers: S,
        first: usize,
        count: usize,
    ) -> bool {
        let arrays = self.arrays;
        let here = (1u32 << count) - 1;
        let end = first + count;
        for k in first + AHEAD..end + AHEAD {
            // Of those that touch nothing no record is made.
            let has_record = match self.candidates {
                Some(candidates) => candidates.has_record(k),
                None => true,
            };
            if has_record {
                if let Some(ahead) = self.records.records.get(k) {
                    registers.prefetch(&ahead.pose.0[0]);
                    registers.prefetch(&ahead.motion.0[0]);
                }
                if CHANGES {
                    if let Some(ahead) = self.records.changes.get(k) {
                        registers.prefetch(&ahead.0[0]);
                    }
                }
            }
            if let Some(numbers) = arrays.shape.place(k) {
                registers.prefetch(numbers[0]);
                registers.prefetch(numbers[1]);
            }
        }
        let mut lines = [Line([1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0]); MOST_LANES];
        let mut has_shape = 0;
        for (lane, line) in lines[..count].iter_mut().enumerate() {
            if let Some((a, q)) = arrays.shape.of(first + lane) {
                *line = Line([a[0], a[1], a[2], q[0], q[1], q[2], q[3], 1.0]);
                has_shape |= 1 << lane;
            }
        }
        let shapes = Lanes::all(registers, registers.columns(&lines!(&lines)));
        let x = components(registers, &arrays.positions[first..], count);
        let mut chosen = here;
        if let Some(candidates) = self.candidates {
            let (hold, with_records) = candidates.hold_for(registers, first, count, x, &shapes);
            if hold & has_shape & here != here {
                self.outcome.moved = true;
                return false;
            }
            chosen = with_records;
            if chosen == 0 {
                return true;
            }
        }
        let (sound, poses, motions, changes) =
            self.records_of::<S, CHANGES>(registers, first, count, x, &shapes);
        let mut right = sound & has_shape;
        for (lane, particle_type) in arrays.types[first..end].iter().enumerate() {
            let exists = *particle_type >= 1 && *particle_type as usize <= self.types;
            right &= !(u32::from(!exists) << lane);
        }
        if !self.records.inverse_masses.is_empty() {
            for (lane, mass) in arrays.contact_masses[first..end].iter().enumerate() {
                right &= !(u32::from(!is_mass(*mass)) << lane);
            }
        }
        if right & chosen != chosen {
            return self.one_by_one(first, chosen);
        }
        for lane in 0..count {
            if chosen >> lane & 1 == 0 {
                continue;
            }
            let k = first + lane;
            self.records.records[k] = Record {
                pose: poses[lane],
                motion: motions[lane],
            };
            if CHANGES {
                self.records.changes[k] = changes[lane];
            }
            let particle_type = arrays.types[k] as u32;
            self.outcome.types_changed |= self.records.types[k] != particle_type;
            self.records.types[k] = particle_type;
            if let Some(inverse) = self.records.inverse_masses.get_mut(k) {
                *inverse = 1.0 / arrays.contact_masses[k];
            }
        }
        true
    }

    /// Records of a block, of which those are right whose bit is set: poses, motions, and what these have more at the step.
    #[inline(always)]
    #[allow(clippy::type_complexity)]
    fn records_of<S: Registers, const CHANGES: bool>(
        &self,
        registers: S,
        first: usize,
        count: usize,
        x: [Lanes<S>; 3],
        shapes: &[Lanes<S>; 8],
    ) -> (
        u32,
        [Line; MOST_LANES],
        [Line; MOST_LANES],
        [Line; MOST_LANES],
    ) {
        let arrays = self.arrays;
        let mut v = components(registers, &arrays.velocities[first..], count);
        let (mut spin, mass) = match arrays.rotation {
            Rotation::Velocity(omega) => {
                let spin = components(registers, &omega[first..], count);
                (spin, Lanes::splat(registers, 1.0))
            }
            Rotation::Momentum(momenta, masses) => (
                components(registers, &momenta[first..], count),
                first_numbers(registers, &masses[first..], count),
            ),
        };
        let zero = Lanes::splat(registers, 0.0);
        let mut change = [[zero; 3]; 2];
        if CHANGES {
            change = double_components(registers, &arrays.changes[first..], count);
            v = [
                v[0] - change[0][0],
                v[1] - change[0][1],
                v[2] - change[0][2],
            ];
            spin = [
                spin[0] - change[1][0],
                spin[1] - change[1][1],
                spin[2] - change[1][2],
            ];
        }
        let raw = Raw {
            x,
            a: [shapes[0], shapes[1], shapes[2]],
            q: [shapes[3], shapes[4], shapes[5], shapes[6]],
            v,
            spin: Vector3::new(spin[0], spin[1], spin[2]),
            mass,
            change,
        };
        let from_momenta = matches!(arrays.rotation, Rotation::Momentum(..));
        let (sound, finished) =
            finished::<S, CHANGES>(registers, &raw, from_momenta, self.records.shapes);
        let mut lines = [[Line::ZERO; MOST_LANES]; 3];
        put(registers, finished[0], &mut lines[0]);
        put(registers, finished[1], &mut lines[1]);
        if CHANGES {
            let change = at_origin(finished[2], Vector3::new(x[0], x[1], x[2]));
            put(registers, change, &mut lines[2]);
        }
        let [poses, motions, changes] = lines;
        (registers.bits(sound), poses, motions, changes)
    }

    /// Finds out what is wrong, if anything is: the lanes look at lengths, where the ranges are those of components.
    #[cold]
    fn one_by_one(&mut self, first: usize, chosen: u32) -> bool {
        for lane in 0..MOST_LANES {
            if chosen >> lane & 1 == 0 {
                continue;
            }
            let k = first + lane;
            match prepare_record(self.arrays, k, self.types, self.records.shapes) {
                Ok((record, change, particle_type, inverse_mass)) => {
                    self.records.records[k] = record;
                    if let Some(place) = self.records.changes.get_mut(k) {
                        *place = change;
                    }
                    self.outcome.types_changed |= self.records.types[k] != particle_type;
                    self.records.types[k] = particle_type;
                    if let Some(inverse) = self.records.inverse_masses.get_mut(k) {
                        *inverse = inverse_mass;
                    }
                }
                Err(what) => {
                    self.outcome.failure = Some((k, what));
                    return false;
                }
            }
        }
        true
    }
}

/// Particles on their way into the lanes.
struct Chunk {
    particles: [usize; MOST_LANES],
    /// Where their records go.
    places: [usize; MOST_LANES],
    length: usize,
    /// What will be the records, and what the motions have more at the step.
    lines: [[Line; MOST_LANES]; 3],
    masses: [f64; MOST_LANES],
    /// Whether nothing looks wrong.
    sound: bool,
}

impl Chunk {
    fn new() -> Self {
        Chunk {
            particles: [0; MOST_LANES],
            places: [0; MOST_LANES],
            length: 0,
            lines: [[Line::ZERO; MOST_LANES]; 3],
            masses: [1.0; MOST_LANES],
            sound: true,
        }
    }

    /// One particle more; false for one without a shape, which is not sound.
    #[inline(always)]
    fn copy<const CHANGES: bool, A: ParticleShapes, I: Fn(usize) -> i64>(
        &mut self,
        arrays: &ParticleArrays<'_, A, I>,
        k: usize,
        types: usize,
    ) -> bool {
        let lane = self.length;
        self.particles[lane] = k;
        self.length = lane + 1;
        let (x, v) = (&arrays.positions[k], &arrays.velocities[k]);
        let spin = match arrays.rotation {
            Rotation::Velocity(omega) => &omega[k],
            Rotation::Momentum(momenta, masses) => {
                self.masses[lane] = masses[k];
                &momenta[k]
            }
        };
        let Some((a, q)) = arrays.shape.of(k) else {
            self.sound = false;
            return false;
        };
        self.lines[0][lane] = Line([x[0], x[1], x[2], q[0], q[1], q[2], q[3], a[0]]);
        self.lines[1][lane] = Line([a[1], a[2], v[0], v[1], v[2], spin[0], spin[1], spin[2]]);
        if CHANGES {
            let [x, y, z, a, b, c] = arrays.changes[k];
            let before = &mut self.lines[1][lane].0;
            for (value, change) in before[2..].iter_mut().zip([x, y, z, a, b, c]) {
                *value -= change;
            }
            self.lines[2][lane] = Line([x, y, z, a, b, c, 0.0, 0.0]);
        }
        let particle_type = arrays.types[k];
        self.sound &= particle_type >= 1 && particle_type as usize <= types;
        true
    }

    /// Lanes without a particle of their own repeat the first.
    fn repeat_first(&mut self, lanes: usize) {
        for lane in self.length..lanes {
            for lines in &mut self.lines {
                lines[lane] = lines[0];
            }
            self.masses[lane] = self.masses[0];
        }
    }
}

/// Prepares chosen particles, each of which then is whole by itself.
pub(super) struct PrepareChosen<'p, 'a, A: ParticleShapes, I: Fn(usize) -> i64> {
    pub arrays: &'p ParticleArrays<'a, A, I>,
    pub chosen: &'p [usize],
    /// Types that there are.
    pub types: usize,
    /// One for each that is chosen.
    pub particles: &'p mut [Particle],
    /// The first invalid particle, and what is wrong with it.
    pub failure: &'p mut Option<(usize, String)>,
}

impl<A: ParticleShapes, I: Fn(usize) -> i64> Stage for PrepareChosen<'_, '_, A, I> {
    #[inline(always)]
    fn run<S: Registers>(self, registers: S) {
        if self.arrays.changes.is_empty() {
            self.prepare::<S, false>(registers);
        } else {
            self.prepare::<S, true>(registers);
        }
    }
}

impl<A: ParticleShapes, I: Fn(usize) -> i64> PrepareChosen<'_, '_, A, I> {
    #[inline(always)]
    fn prepare<S: Registers, const CHANGES: bool>(self, registers: S) {
        let arrays = self.arrays;
        let from_momenta = matches!(arrays.rotation, Rotation::Momentum(..));
        let mut chunk = Chunk::new();
        let mut poses = [[Line::ZERO; MOST_LANES]; 2];
        let chunks = self.chosen.chunks(S::LANES);
        for (chosen, particles) in chunks.zip(self.particles.chunks_mut(S::LANES)) {
            chunk.length = 0;
            chunk.sound = true;
            for &k in chosen {
                chunk.copy::<CHANGES, A, I>(arrays, k, self.types);
                let mass = arrays.contact_masses.get(k);
                chunk.sound &= mass.is_none_or(|mass| is_mass(*mass));
            }
            chunk.repeat_first(S::LANES);
            let masses = &chunk.masses;
            let is_sound = chunk.sound
                && finish::<S, CHANGES, false>(
                    registers,
                    &mut chunk.lines,
                    masses,
                    from_momenta,
                    Shapes::Ellipsoids,
                );
            if !is_sound {
                for (&k, particle) in chosen.iter().zip(particles) {
                    if let Err(what) = prepare_one(arrays, k, self.types, particle) {
                        *self.failure = Some((k, what));
                        return;
                    }
                }
                continue;
            }
            turn(registers, &chunk.lines, &mut poses);
            for (lane, (&k, particle)) in chosen.iter().zip(particles).enumerate() {
                let [pose, motion, change] = [0, 1, 2].map(|line| &chunk.lines[line][lane].0);
                let [axes, more] = [&poses[0][lane].0, &poses[1][lane].0];
                let vector = |v: &[f64; 8], at: usize| Vector3::new(v[at], v[at + 1], v[at + 2]);
                particle.position = vector(pose, 0);
                particle.body.axes = [
                    vector(axes, 0),
                    vector(axes, 3),
                    Vector3::new(axes[6], axes[7], more[0]),
                ];
                particle.body.semi_axes = Vector3::new(pose[7], motion[0], motion[1]);
                particle.body.inverse_semi_axes = vector(more, 1);
                particle.radius = more[4];
                particle.sphere = pose[7] == motion[0] && motion[0] == motion[1];
                particle.velocity = vector(motion, 2);
                particle.omega = vector(motion, 5);
                particle.particle_type = arrays.types[k] as u32;
                let mass = arrays.contact_masses.get(k);
                particle.inverse_mass = mass.map_or(0.0, |mass| 1.0 / mass);
                particle.change = arrays.of_step.then(|| {
                    if CHANGES {
                        MotionChange {
                            velocity: vector(change, 0),
                            omega: vector(change, 3),
                        }
                    } else {
                        MotionChange::NONE
                    }
                });
            }
        }
    }
}

/// Records that were prepared for the pairs of a list in this step.
#[derive(Clone, Copy)]
pub(super) struct PreparedForPairs<'a> {
    records: &'a Records,
    /// Particles whose records are those of this step.
    with_records: &'a [bool],
    asked_for: &'a AskedFor,
}

impl<'a> PreparedForPairs<'a> {
    pub fn new(
        records: &'a Records,
        (with_records, asked_for): (&'a [bool], &'a AskedFor),
    ) -> Self {
        PreparedForPairs {
            records,
            with_records,
            asked_for,
        }
    }

    /// The shapes for which they were made.
    pub fn shapes(&self) -> Shapes {
        self.records.shapes
    }

    /// Whether they say of a motion what these arrays would.
    pub fn are_of<A: ParticleShapes, I: Fn(usize) -> i64>(
        &self,
        arrays: &ParticleArrays<'_, A, I>,
    ) -> bool {
        self.records.of_step == arrays.of_step
            && self.records.changes.is_empty() == arrays.changes.is_empty()
    }

    /// Whether there is a record of a particle, with its position and its velocity. If there is none, there will be in the next step.
    #[inline(always)]
    fn has<A: ParticleShapes, I: Fn(usize) -> i64>(
        &self,
        arrays: &ParticleArrays<'_, A, I>,
        k: usize,
    ) -> bool {
        if !self.with_records.get(k).is_some_and(|t| *t) {
            self.asked_for.ask(k);
            return false;
        }
        let Some(record) = self.records.records.get(k) else {
            return false;
        };
        let [v, _] = record.velocities(self.records.shapes);
        let mut velocity = arrays.velocities[k];
        if let Some(change) = arrays.changes.get(k) {
            for axis in 0..3 {
                velocity[axis] -= change[axis];
            }
        }
        record.position().to_array() == arrays.positions[k] && v.to_array() == velocity
    }
}

/// Prepares the records of chosen particles, in that order. Where one of them has another shape than the records are made for, nothing is
/// prepared.
pub(super) struct PrepareChosenRecords<'p, 'a, A: ParticleShapes, I: Fn(usize) -> i64> {
    pub arrays: &'p ParticleArrays<'a, A, I>,
    pub chosen: &'p [usize],
    /// Records of particles that need not be prepared again, of the same form.
    pub prepared: Option<PreparedForPairs<'p>>,
    /// Types that there are.
    pub types: usize,
    /// With room for one for each that is chosen.
    pub records: &'p mut Records,
    /// The simplest form that serves all of them, or one before it.
    pub shapes: &'p mut Shapes,
    /// The first invalid particle, and what is wrong with it.
    pub failure: &'p mut Option<(usize, String)>,
}

impl<A: ParticleShapes, I: Fn(usize) -> i64> Stage for PrepareChosenRecords<'_, '_, A, I> {
    #[inline(always)]
    fn run<S: Registers>(mut self, registers: S) {
        if self.arrays.changes.is_empty() {
            self.prepare::<S, false>(registers);
        } else {
            self.prepare::<S, true>(registers);
        }
    }
}

impl<A: ParticleShapes, I: Fn(usize) -> i64> PrepareChosenRecords<'_, '_, A, I> {
    #[inline(always)]
    fn prepare<S: Registers, const CHANGES: bool>(&mut self, registers: S) {
        let arrays = self.arrays;
        let mut chunk = Chunk::new();
        for (n, &k) in self.chosen.iter().enumerate() {
            let r = &mut *self.records;
            let particle_type = arrays.types[k];
            let mut is_sound = particle_type >= 1 && particle_type as usize <= self.types;
            r.types[n] = particle_type as u32;
            if let Some(inverse) = r.inverse_masses.get_mut(n) {
                let mass = arrays.contact_masses[k];
                is_sound &= is_mass(mass);
                *inverse = 1.0 / mass;
            }
            if let Some(prepared) = &self.prepared {
                let stands_there = is_sound && prepared.has(arrays, k);
                r.places.push(if stands_there { k as u32 } else { OWN });
                if stands_there {
                    continue;
                }
            }
            chunk.places[chunk.length] = n;
            chunk.copy::<CHANGES, A, I>(arrays, k, self.types);
            chunk.sound &= is_sound;
            if chunk.length == S::LANES && !self.finish::<S, CHANGES>(registers, &mut chunk) {
                return;
            }
        }
        if chunk.length > 0 {
            self.finish::<S, CHANGES>(registers, &mut chunk);
        }
    }

    /// The records of a chunk, which is empty then; whether the preparation goes on.
    #[inline(always)]
    fn finish<S: Registers, const CHANGES: bool>(
        &mut self,
        registers: S,
        chunk: &mut Chunk,
    ) -> bool {
        let arrays = self.arrays;
        let r = &mut *self.records;
        chunk.repeat_first(S::LANES);
        let from_momenta = matches!(arrays.rotation, Rotation::Momentum(..));
        let is_sound = chunk.sound
            && finish::<S, CHANGES, true>(
                registers,
                &mut chunk.lines,
                &chunk.masses,
                from_momenta,
                r.shapes,
            );
        if !is_sound {
            let particles = &chunk.particles[..chunk.length];
            let of_chunk = particles.iter().filter_map(|k| arrays.shape.of(*k));
            let of_chunk = of_chunk.map(|(a, _)| Shapes::of(&a)).max();
            if let Some(of_chunk) = of_chunk.filter(|of_chunk| *of_chunk > r.shapes) {
                *self.shapes = of_chunk;
                return false;
            }
        }
        for lane in 0..chunk.length {
            let (k, n) = (chunk.particles[lane], chunk.places[lane]);
            if is_sound {
                r.records[n] = Record {
                    pose: chunk.lines[0][lane],
                    motion: chunk.lines[1][lane],
                };
                if CHANGES {
                    r.changes[n] = chunk.lines[2][lane];
                }
                continue;
            }
            match prepare_record(arrays, k, self.types, r.shapes) {
                Ok((record, change, _, inverse_mass)) => {
                    r.records[n] = record;
                    if let Some(place) = r.changes.get_mut(n) {
                        *place = change;
                    }
                    if let Some(inverse) = r.inverse_masses.get_mut(n) {
                        *inverse = inverse_mass;
                    }
                }
                Err(what) => {
                    *self.failure = Some((k, what));
                    return false;
                }
            }
        }
        chunk.length = 0;
        chunk.sound = true;
        true
    }
}

/// Axes (9 numbers), inverse semi-axes (3) and the largest semi-axis of records.
#[inline(always)]
fn turn<S: Registers>(
    registers: S,
    lines: &[[Line; MOST_LANES]; 3],
    poses: &mut [[Line; MOST_LANES]; 2],
) {
    let p = Lanes::all(registers, registers.columns(&lines!(&lines[0])));
    let m = Lanes::all(registers, registers.columns(&lines!(&lines[1])));
    let one = Lanes::splat(registers, 1.0);
    let (a, zero) = ([p[7], m[0], m[1]], one * 0.0);
    let [x, y, z] = rotation_columns([p[3], p[4], p[5], p[6]], one * 2.0);
    put(
        registers,
        [x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y],
        &mut poses[0],
    );
    let largest = a[0].max(a[1]).max(a[2]);
    let inverse = [one / a[0], one / a[1], one / a[2]];
    put(
        registers,
        [
            z.z, inverse[0], inverse[1], inverse[2], largest, zero, zero, zero,
        ],
        &mut poses[1],
    );
}

// Functions that are always inlined, and no closures: one that the compiler leaves as it is does not have the kernel's instructions, and
// its arithmetic becomes calls.

/// Whether numbers lie between two.
#[inline(always)]
fn within<S: Registers>(registers: S, a: Lanes<S>, low: f64, high: f64) -> S::Mask {
    registers.and(a.constant(low).less(a), a.less(a.constant(high)))
}

/// Where an angular velocity is not too large.
#[inline(always)]
fn are_slow<S: Registers>(omega: Vector3<Lanes<S>>) -> S::Mask {
    let square = omega.norm_squared();
    square.less(square.constant(LARGEST_VELOCITY * LARGEST_VELOCITY))
}

/// Angular velocities of angular momenta, from the inverse moments of inertia about the axes.
#[inline(always)]
fn angular_velocity<S: Registers>(
    axes: &[Vector3<Lanes<S>>; 3],
    inverses: [Lanes<S>; 3],
    momentum: Vector3<Lanes<S>>,
) -> Vector3<Lanes<S>> {
    axes[0] * (axes[0].dot(momentum) * inverses[0])
        + axes[1] * (axes[1].dot(momentum) * inverses[1])
        + axes[2] * (axes[2].dot(momentum) * inverses[2])
}

/// The third where the first mask is set, else the second where the second is, else the first.
#[inline(always)]
fn choose<S: Registers>(
    [third, second]: [S::Mask; 2],
    x: Lanes<S>,
    y: Lanes<S>,
    z: Lanes<S>,
) -> Lanes<S> {
    Lanes::select(third, z, Lanes::select(second, y, x))
}

/// What an engine has of particles.
struct Raw<S: Registers> {
    x: [Lanes<S>; 3],
    a: [Lanes<S>; 3],
    /// Of any length.
    q: [Lanes<S>; 4],
    v: [Lanes<S>; 3],
    /// Angular velocity or momentum.
    spin: Vector3<Lanes<S>>,
    mass: Lanes<S>,
    /// What velocity and angular velocity or momentum have more at the step.
    change: [[Lanes<S>; 3]; 2],
}

/// Makes records of copies of the engine's numbers; whether all of them can be. What motions have more is that of the centres, or `AT_ORIGIN`.
#[inline(always)]
fn finish<S: Registers, const CHANGES: bool, const AT_ORIGIN: bool>(
    registers: S,
    lines: &mut [[Line; MOST_LANES]; 3],
    masses: &[f64; MOST_LANES],
    from_momenta: bool,
    shapes: Shapes,
) -> bool {
    let p = Lanes::all(registers, registers.columns(&lines!(&lines[0])));
    let m = Lanes::all(registers, registers.columns(&lines!(&lines[1])));
    let c = Lanes::all(registers, registers.columns(&lines!(&lines[2])));
    let raw = Raw {
        x: [p[0], p[1], p[2]],
        a: [p[7], m[0], m[1]],
        q: [p[3], p[4], p[5], p[6]],
        v: [m[2], m[3], m[4]],
        spin: Vector3::new(m[5], m[6], m[7]),
        mass: Lanes::load(registers, masses),
        change: [[c[0], c[1], c[2]], [c[3], c[4], c[5]]],
    };
    let (sound, finished) = finished::<S, CHANGES>(registers, &raw, from_momenta, shapes);
    if !registers.all(sound) {
        return false;
    }
    put(registers, finished[0], &mut lines[0]);
    put(registers, finished[1], &mut lines[1]);
    if CHANGES {
        let mut change = finished[2];
        if AT_ORIGIN {
            change = at_origin(change, Vector3::new(raw.x[0], raw.x[1], raw.x[2]));
        }
        put(registers, change, &mut lines[2]);
    }
    true
}

/// Which particles are within the ranges, and the columns of their records and of what their motions have more at the step.
#[inline(always)]
fn finished<S: Registers, const CHANGES: bool>(
    registers: S,
    raw: &Raw<S>,
    from_momenta: bool,
    shapes: Shapes,
) -> (S::Mask, [[Lanes<S>; 8]; 3]) {
    let zero = Lanes::splat(registers, 0.0);
    let one = Lanes::splat(registers, 1.0);
    let &Raw {
        x,
        a,
        q,
        v,
        spin,
        mass,
        change,
    } = raw;
    let square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    // Not a number is not less than anything, and an infinite square neither.
    // (Calls one by one: a closure that the standard library calls does not get the kernel's instruction set.)
    let way = Vector3::new(x[0], x[1], x[2]).norm_squared();
    let speed = Vector3::new(v[0], v[1], v[2]).norm_squared();
    let near = registers.and(
        way.less(zero.constant(LARGEST_COORDINATE * LARGEST_COORDINATE)),
        speed.less(zero.constant(LARGEST_VELOCITY * LARGEST_VELOCITY)),
    );
    // The larger of two may hide one that is not a number: the inertia, of which each is a factor, shows it.
    let (least, most) = (a[2].min(a[1]).min(a[0]), a[2].max(a[1]).max(a[0]));
    let shape = registers.and(
        registers.and(
            within(registers, least, LEAST_SEMI_AXIS, LARGEST_SEMI_AXIS),
            within(registers, most, LEAST_SEMI_AXIS, LARGEST_SEMI_AXIS),
        ),
        registers.and(
            most.less(least * LARGEST_ASPECT_RATIO),
            within(registers, square, 1e-280, 1e280),
        ),
    );
    let (xx, yy, zz) = (a[0] * a[0], a[1] * a[1], a[2] * a[2]);
    let (yz, xz, xy) = (yy + zz, xx + zz, xx + yy);
    let inertia = mass * yz * xz * xy;
    let heavy = registers.and(
        within(registers, inertia, 1e-280, 1e280),
        within(registers, mass, LEAST_MASS, LARGEST_MASS),
    );
    let sound = registers.and(registers.and(near, shape), heavy);
    let scale = square.reciprocal_sqrt();
    let q = [q[0] * scale, q[1] * scale, q[2] * scale, q[3] * scale];
    let turn_change = Vector3::new(change[1][0], change[1][1], change[1][2]);
    let axes = rotation_columns(q, one * 2.0);
    if shapes == Shapes::Ellipsoids {
        // L = (m/5) diag(yz, xz, xy) omega in body axes.
        let inverse = one * 5.0 / inertia;
        let inverses = [xz * xy * inverse, yz * xy * inverse, yz * xz * inverse];
        let (mut omega, mut w) = (spin, turn_change);
        if from_momenta {
            omega = angular_velocity(&axes, inverses, spin);
            if CHANGES {
                w = angular_velocity(&axes, inverses, turn_change);
            }
        }
        return (
            registers.and(sound, are_slow(omega)),
            [
                [x[0], x[1], x[2], q[0], q[1], q[2], q[3], a[0]],
                [a[1], a[2], v[0], v[1], v[2], omega.x, omega.y, omega.z],
                columns_of_change(change, w),
            ],
        );
    }
    // The axis of revolution: the third where the first two semi-axes are the same, else the one that stands apart.
    let first_two = registers.or(a[0].less(a[1]), a[1].less(a[0]));
    let third = registers.not(first_two);
    let second = registers.or(a[1].less(a[2]), a[2].less(a[1]));
    let axis = Vector3::new(
        choose([third, second], axes[0].x, axes[1].x, axes[2].x),
        choose([third, second], axes[0].y, axes[1].y, axes[2].y),
        choose([third, second], axes[0].z, axes[1].z, axes[2].z),
    );
    let (polar, equatorial) = (
        choose([third, second], a[0], a[1], a[2]),
        choose([third, second], a[1], a[2], a[0]),
    );
    let (mut omega, mut w) = (spin, turn_change);
    if from_momenta {
        let (polar_square, equatorial_square) = (polar * polar, equatorial * equatorial);
        let across = (mass * (polar_square + equatorial_square)).reciprocal() * 5.0;
        let along = (mass * equatorial_square).reciprocal() * 2.5;
        let more = along - across;
        omega = axis.scale_add(axis.dot(spin) * more, spin * across);
        if CHANGES {
            w = axis.scale_add(axis.dot(turn_change) * more, turn_change * across);
        }
    }
    // One pair of the semi-axes is the same: else the closed form does not serve.
    let different = registers.or(a[2].less(a[0]), a[0].less(a[2]));
    let is_of_revolution =
        registers.not(registers.and(first_two, registers.and(second, different)));
    let sound = registers.and(sound, is_of_revolution);
    (
        registers.and(sound, are_slow(omega)),
        [
            [x[0], x[1], x[2], axis.x, axis.y, axis.z, polar, equatorial],
            [
                v[0],
                v[1],
                v[2],
                omega.x,
                omega.y,
                omega.z,
                polar.reciprocal(),
                equatorial.reciprocal(),
            ],
            columns_of_change(change, w),
        ],
    )
}

/// Columns of what motions have more at the step: of the velocity and the angular velocity.
#[inline(always)]
fn columns_of_change<S: Registers>(
    [v, _]: [[Lanes<S>; 3]; 2],
    w: Vector3<Lanes<S>>,
) -> [Lanes<S>; 8] {
    let zero = v[0].constant(0.0);
    [v[0], v[1], v[2], w.x, w.y, w.z, zero, zero]
}

/// The same as records have it ([`super::records::line_of_change`]).
#[inline(always)]
fn at_origin<S: Registers>(
    [x, y, z, a, b, c, ..]: [Lanes<S>; 8],
    position: Vector3<Lanes<S>>,
) -> [Lanes<S>; 8] {
    let change = MotionChange {
        velocity: Vector3::new(x, y, z),
        omega: Vector3::new(a, b, c),
    };
    let v = change.at(-position);
    let zero = x.constant(0.0);
    [v.x, v.y, v.z, a, b, c, zero, zero]
}
