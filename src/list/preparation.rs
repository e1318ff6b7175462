// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is made of the particles once a step, in lanes: unit quaternions, and angular velocities of angular momenta.
//!
//! The engine's numbers are copied into the records as they are; a handful of records at a time is then checked and
//! finished in place. A handful in which anything looks wrong is done again particle by particle, which finds out what.

use super::arrays::{ParticleArrays, Rotation};
use super::candidates::Candidates;
use super::records::{prepare_record, Record, Records, Shapes};
use crate::contact::ranges::{
    is_mass, LARGEST_COORDINATE, LARGEST_MASS, LARGEST_VELOCITY, LEAST_MASS,
};
use crate::geometry::ellipsoid::{
    rotation_columns, LARGEST_ASPECT_RATIO, LARGEST_SEMI_AXIS, LEAST_SEMI_AXIS,
};
use crate::real::Real;
use crate::simd::{lines, put, Lanes, Line, Registers, Stage, MOST_LANES};
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
pub(super) struct Prepare<'p, 'a, A: Fn(usize) -> Option<([f64; 3], [f64; 4])>, I: Fn(usize) -> i64>
{
    pub arrays: &'p ParticleArrays<'a, A, I>,
    pub candidates: Option<&'p Candidates>,
    /// Types that there are.
    pub types: usize,
    /// Of the length of the arrays.
    pub records: &'p mut Records,
    pub outcome: &'p mut Prepared,
}

impl<A: Fn(usize) -> Option<([f64; 3], [f64; 4])>, I: Fn(usize) -> i64> Stage
    for Prepare<'_, '_, A, I>
{
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

impl<A: Fn(usize) -> Option<([f64; 3], [f64; 4])>, I: Fn(usize) -> i64> Prepare<'_, '_, A, I> {
    #[inline(always)]
    fn prepare<S: Registers, const CHANGES: bool>(mut self, registers: S) {
        let mut chunk = Chunk {
            particles: [0; MOST_LANES],
            length: 0,
            lines: [[Line::ZERO; MOST_LANES]; 3],
            masses: [1.0; MOST_LANES],
            sound: true,
        };
        for k in 0..self.arrays.positions.len() {
            if let Some(ahead) = self.records.records.get(k + AHEAD) {
                registers.prefetch(&ahead.pose.0[0]);
                registers.prefetch(&ahead.motion.0[0]);
            }
            // One look at each number, for the candidates and for the record.
            let shape = (self.arrays.shape)(k);
            if let Some(candidates) = self.candidates {
                let Some((a, q)) = &shape else {
                    self.outcome.moved = true;
                    return;
                };
                let (holds, takes_part) = candidates.hold_for(k, &self.arrays.positions[k], a, q);
                if !holds {
                    self.outcome.moved = true;
                    return;
                }
                if !takes_part {
                    continue;
                }
            }
            self.copy::<CHANGES>(k, shape, &mut chunk);
            if chunk.length == S::LANES && !self.finish::<S, CHANGES>(registers, &mut chunk) {
                return;
            }
        }
        if chunk.length > 0 {
            // Lanes without a particle of their own repeat the first.
            for lane in chunk.length..S::LANES {
                chunk.lines[0][lane] = chunk.lines[0][0];
                chunk.lines[1][lane] = chunk.lines[1][0];
                chunk.lines[2][lane] = chunk.lines[2][0];
                chunk.masses[lane] = chunk.masses[0];
            }
            self.finish::<S, CHANGES>(registers, &mut chunk);
        }
    }

    /// One particle more.
    #[inline(always)]
    fn copy<const CHANGES: bool>(
        &mut self,
        k: usize,
        shape: Option<([f64; 3], [f64; 4])>,
        chunk: &mut Chunk,
    ) {
        let arrays = self.arrays;
        let lane = chunk.length;
        chunk.particles[lane] = k;
        chunk.length = lane + 1;
        let Some((a, q)) = shape else {
            chunk.sound = false;
            return;
        };
        let (x, v) = (&arrays.positions[k], &arrays.velocities[k]);
        let spin = match arrays.rotation {
            Rotation::Velocity(omega) => &omega[k],
            Rotation::Momentum(momenta, masses) => {
                chunk.masses[lane] = masses[k];
                &momenta[k]
            }
        };
        chunk.lines[0][lane] = Line([x[0], x[1], x[2], q[0], q[1], q[2], q[3], a[0]]);
        chunk.lines[1][lane] = Line([a[1], a[2], v[0], v[1], v[2], spin[0], spin[1], spin[2]]);
        if CHANGES {
            let [x, y, z, a, b, c] = arrays.changes[k];
            let before = &mut chunk.lines[1][lane].0;
            for (value, change) in before[2..].iter_mut().zip([x, y, z, a, b, c]) {
                *value -= change;
            }
            chunk.lines[2][lane] = Line([x, y, z, a, b, c, 0.0, 0.0]);
        }
        let particle_type = arrays.types[k];
        chunk.sound &= particle_type >= 1 && particle_type as usize <= self.types;
        self.outcome.types_changed |= self.records.types[k] != particle_type as u32;
        self.records.types[k] = particle_type as u32;
        if let Some(inverse) = self.records.inverse_masses.get_mut(k) {
            let mass = arrays.contact_masses[k];
            chunk.sound &= is_mass(mass);
            *inverse = 1.0 / mass;
        }
    }

    /// Makes the records; whether all particles can be.
    #[inline(always)]
    fn finish<S: Registers, const CHANGES: bool>(
        &mut self,
        registers: S,
        chunk: &mut Chunk,
    ) -> bool {
        let from_momenta = matches!(self.arrays.rotation, Rotation::Momentum(..));
        let particles = &chunk.particles[..chunk.length];
        let sound = chunk.sound;
        chunk.length = 0;
        chunk.sound = true;
        if !sound
            || !finish::<S, CHANGES>(
                registers,
                &mut chunk.lines,
                &chunk.masses,
                from_momenta,
                self.records.shapes,
            )
        {
            return self.one_by_one(particles);
        }
        for (lane, &k) in particles.iter().enumerate() {
            self.records.records[k] = Record {
                pose: chunk.lines[0][lane],
                motion: chunk.lines[1][lane],
            };
            if CHANGES {
                self.records.changes[k] = chunk.lines[2][lane];
            }
        }
        true
    }

    /// Finds out what is wrong, if anything is: the lanes look at lengths, where the ranges are those of components.
    #[cold]
    fn one_by_one(&mut self, chunk: &[usize]) -> bool {
        for &k in chunk {
            match prepare_record(self.arrays, k, self.types, self.records.shapes) {
                Ok((record, change, particle_type, inverse_mass)) => {
                    self.records.records[k] = record;
                    if let Some(place) = self.records.changes.get_mut(k) {
                        *place = change;
                    }
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
    length: usize,
    /// What will be the records, and what the motions have more at the step.
    lines: [[Line; MOST_LANES]; 3],
    masses: [f64; MOST_LANES],
    /// Whether nothing looks wrong.
    sound: bool,
}

/// Makes records of copies of the engine's numbers; whether all of them can be.
#[inline(always)]
fn finish<S: Registers, const CHANGES: bool>(
    registers: S,
    lines: &mut [[Line; MOST_LANES]; 3],
    masses: &[f64; MOST_LANES],
    from_momenta: bool,
    shapes: Shapes,
) -> bool {
    let p = Lanes::all(registers, registers.columns(&lines!(&lines[0])));
    let m = Lanes::all(registers, registers.columns(&lines!(&lines[1])));
    let zero = Lanes::splat(registers, 0.0);
    let one = Lanes::splat(registers, 1.0);
    let (x, q, a) = (
        [p[0], p[1], p[2]],
        [p[3], p[4], p[5], p[6]],
        [p[7], m[0], m[1]],
    );
    let (v, spin) = ([m[2], m[3], m[4]], Vector3::new(m[5], m[6], m[7]));
    let square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    let mass = Lanes::load(registers, masses);
    // Not a number is not less than anything, and an infinite square neither.
    // (Calls one by one: a closure that the standard library calls does not get the kernel's instruction set.)
    let way = Vector3::new(x[0], x[1], x[2]).norm_squared();
    let speed = Vector3::new(v[0], v[1], v[2]).norm_squared();
    let near = registers.and(
        way.less(zero.constant(LARGEST_COORDINATE * LARGEST_COORDINATE)),
        speed.less(zero.constant(LARGEST_VELOCITY * LARGEST_VELOCITY)),
    );
    let within = |a: Lanes<S>, low: f64, high: f64| {
        registers.and(zero.constant(low).less(a), a.less(zero.constant(high)))
    };
    // The larger of two may hide one that is not a number: the inertia, of which each is a factor, shows it.
    let (least, most) = (a[2].min(a[1]).min(a[0]), a[2].max(a[1]).max(a[0]));
    let shape = registers.and(
        registers.and(
            within(least, LEAST_SEMI_AXIS, LARGEST_SEMI_AXIS),
            within(most, LEAST_SEMI_AXIS, LARGEST_SEMI_AXIS),
        ),
        registers.and(
            most.less(least * LARGEST_ASPECT_RATIO),
            within(square, 1e-280, 1e280),
        ),
    );
    let (xx, yy, zz) = (a[0] * a[0], a[1] * a[1], a[2] * a[2]);
    let (yz, xz, xy) = (yy + zz, xx + zz, xx + yy);
    let inertia = mass * yz * xz * xy;
    let heavy = registers.and(
        within(inertia, 1e-280, 1e280),
        within(mass, LEAST_MASS, LARGEST_MASS),
    );
    let sound = registers.and(registers.and(near, shape), heavy);
    if !registers.all(sound) {
        return false;
    }
    let slow = |omega: Vector3<Lanes<S>>| {
        let square = omega.norm_squared();
        let slow = square.less(square.constant(LARGEST_VELOCITY * LARGEST_VELOCITY));
        registers.all(slow)
    };
    let scale = square.reciprocal_sqrt();
    let q = [q[0] * scale, q[1] * scale, q[2] * scale, q[3] * scale];
    // L = (m/5) diag(yz, xz, xy) omega in body axes.
    let inverse = one * 5.0 / inertia;
    if shapes == Shapes::Ellipsoids {
        let axes = rotation_columns(q, one * 2.0);
        let omega_of = |spin: Vector3<Lanes<S>>| {
            axes[0] * (axes[0].dot(spin) * (xz * xy * inverse))
                + axes[1] * (axes[1].dot(spin) * (yz * xy * inverse))
                + axes[2] * (axes[2].dot(spin) * (yz * xz * inverse))
        };
        let omega = if from_momenta { omega_of(spin) } else { spin };
        if !slow(omega) {
            return false;
        }
        if CHANGES && from_momenta {
            let c = Lanes::all(registers, registers.columns(&lines!(&lines[2])));
            let w = omega_of(Vector3::new(c[3], c[4], c[5]));
            put(
                registers,
                [c[0], c[1], c[2], w.x, w.y, w.z, zero, zero],
                &mut lines[2],
            );
        }
        put(
            registers,
            [x[0], x[1], x[2], q[0], q[1], q[2], q[3], a[0]],
            &mut lines[0],
        );
        put(
            registers,
            [a[1], a[2], v[0], v[1], v[2], omega.x, omega.y, omega.z],
            &mut lines[1],
        );
        return true;
    }
    // The axis of revolution: the third where the first two semi-axes are the same, else the one that stands apart.
    let axes = rotation_columns(q, one * 2.0);
    let third = registers.not(registers.or(a[0].less(a[1]), a[1].less(a[0])));
    let second = registers.or(a[1].less(a[2]), a[2].less(a[1]));
    let choose = |x: Lanes<S>, y: Lanes<S>, z: Lanes<S>| {
        Lanes::select(third, z, Lanes::select(second, y, x))
    };
    let axis = Vector3::new(
        choose(axes[0].x, axes[1].x, axes[2].x),
        choose(axes[0].y, axes[1].y, axes[2].y),
        choose(axes[0].z, axes[1].z, axes[2].z),
    );
    let (polar, equatorial) = (choose(a[0], a[1], a[2]), choose(a[1], a[2], a[0]));
    let omega = if from_momenta {
        let (polar_square, equatorial_square) = (polar * polar, equatorial * equatorial);
        let across = (mass * (polar_square + equatorial_square)).reciprocal() * 5.0;
        let along = (mass * equatorial_square).reciprocal() * 2.5;
        if CHANGES {
            let c = Lanes::all(registers, registers.columns(&lines!(&lines[2])));
            let spin = Vector3::new(c[3], c[4], c[5]);
            let w = axis.scale_add(axis.dot(spin) * (along - across), spin * across);
            put(
                registers,
                [c[0], c[1], c[2], w.x, w.y, w.z, zero, zero],
                &mut lines[2],
            );
        }
        axis.scale_add(axis.dot(spin) * (along - across), spin * across)
    } else {
        spin
    };
    if !slow(omega) {
        return false;
    }
    put(
        registers,
        [x[0], x[1], x[2], axis.x, axis.y, axis.z, polar, equatorial],
        &mut lines[0],
    );
    put(
        registers,
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
        &mut lines[1],
    );
    true
}
