// SPDX-License-Identifier: MIT OR Apache-2.0
//! A step of blocks of bodies in lanes, or of one body after the other: what the lanes cannot do exactly to rounding is left to single bodies.

use super::bodies::{Bodies, BodyArrays, Extrapolation, MotionError, Refusal, Selection, REVERSAL};
use super::free_rotation::{
    body_velocity, half_angles, of_a_sphere, of_revolution, of_three_moments, Quaternion,
    LARGEST_EXPANDED_TURN, LARGEST_HALF_ANGLE,
};
use super::one_body::{angular_velocity, finish_step_of_body, moments, start_step_of_body, UNIT};
use crate::geometry::ellipsoid::{rotation_columns, LARGEST_SEMI_AXIS, LEAST_SEMI_AXIS};
use crate::real::Real;
use crate::simd::{
    components, double_components, first_numbers, lines, put, put_components,
    put_double_components, Lanes, Line, Registers, Stage, MOST_LANES,
};
use crate::vector::Vector3;

/// Within the range of semi-axes, by a little: one at its very end is looked at by itself.
const BELOW_SEMI_AXES: f64 = LEAST_SEMI_AXIS * (1.0 + 1e-9);

const ABOVE_SEMI_AXES: f64 = LARGEST_SEMI_AXIS * (1.0 - 1e-9);

/// See [`super::start_step`].
pub(super) struct Turn<'p, 'a, B: Bodies> {
    pub arrays: &'p mut BodyArrays<'a, B>,
    pub selection: Selection<'p>,
    pub time_step: f64,
    pub outcome: &'p mut Result<(), MotionError>,
}

impl<B: Bodies> Turn<'_, '_, B> {
    pub fn one_by_one(mut self) {
        for k in 0..self.arrays.same_length() {
            if self.selection.takes(k) && !self.one(k) {
                return;
            }
        }
    }

    /// One body, in whatever state it is; whether it can be moved.
    #[cold]
    fn one(&mut self, k: usize) -> bool {
        match start_step_of_body(self.arrays, k, self.time_step) {
            Ok(()) => true,
            Err(why) => {
                *self.outcome = Err(why.of_body(k));
                false
            }
        }
    }
}

impl<B: Bodies> Stage for Turn<'_, '_, B> {
    #[inline(always)]
    fn run<S: Registers>(mut self, registers: S) {
        let n = self.arrays.same_length();
        let mut first = 0;
        while first < n {
            // Lanes of the last block that have no body of their own go along with copies of its first.
            let count = S::LANES.min(n - first);
            let moves = self.selection.lanes(first, count);
            #[cfg(feature = "std")]
            for k in first + AHEAD..first + AHEAD + count {
                if let Some(numbers) = self.arrays.bodies.place(k) {
                    registers.prefetch(numbers[0]);
                    registers.prefetch(numbers[1]);
                }
            }
            if moves != 0 && !self.block(registers, first, count, moves) {
                return;
            }
            first += S::LANES;
        }
    }
}

/// Rows of an array from `first` on as vectors.
#[inline(always)]
fn vectors<S: Registers>(
    registers: S,
    array: &[[f64; 3]],
    first: usize,
    count: usize,
) -> Vector3<Lanes<S>> {
    let [x, y, z] = components(registers, &array[first..], count);
    Vector3::new(x, y, z)
}

/// The reverse of [`vectors`], where the mask is set; else what was there before.
#[inline(always)]
fn put_vectors<S: Registers>(
    registers: S,
    (mask, v, before): (S::Mask, Vector3<Lanes<S>>, Vector3<Lanes<S>>),
    array: &mut [[f64; 3]],
    first: usize,
    count: usize,
) {
    let v = Vector3::select(mask, v, before);
    put_components(registers, [v.x, v.y, v.z], &mut array[first..], count);
}

/// Rows of two vectors each, from `first` on.
#[inline(always)]
fn two_vectors<S: Registers>(
    registers: S,
    array: &[[f64; 6]],
    first: usize,
    count: usize,
) -> [Vector3<Lanes<S>>; 2] {
    let [a, b] = double_components(registers, &array[first..], count);
    [
        Vector3::new(a[0], a[1], a[2]),
        Vector3::new(b[0], b[1], b[2]),
    ]
}

/// The reverse of [`two_vectors`].
#[inline(always)]
fn put_two_vectors<S: Registers>(
    registers: S,
    [a, b]: [Vector3<Lanes<S>>; 2],
    array: &mut [[f64; 6]],
    first: usize,
    count: usize,
) {
    let both = [[a.x, a.y, a.z], [b.x, b.y, b.z]];
    put_double_components(registers, both, &mut array[first..], count);
}

/// Half the time of a step over the masses, and where these are in the range in which lanes divide.
#[inline(always)]
fn over_masses<S: Registers>(
    registers: S,
    masses: &[f64],
    first: usize,
    count: usize,
    time: f64,
) -> (Lanes<S>, S::Mask) {
    let mass = first_numbers(registers, &masses[first..], count);
    let inside = registers.and(
        mass.constant(DIVIDED[0]).less(mass),
        mass.less(mass.constant(DIVIDED[1])),
    );
    (mass.constant(time) / mass, inside)
}

/// So many bodies ahead shapes and attitudes are asked for.
#[cfg(feature = "std")]
const AHEAD: usize = 24;
/// Masses by which lanes divide exactly to rounding, whatever the instruction set; others are left to single bodies.
const DIVIDED: [f64; 2] = [1e-290, 1e290];

/// Shapes and attitudes of a block, and which of its bodies are spheres and of revolution.
struct BlockShapes<S: Registers> {
    semi_axes: [Lanes<S>; 3],
    quaternion: Quaternion<Lanes<S>>,
    mass: Lanes<S>,
    all_spheres: bool,
    triaxial: u32,
}

impl<B: Bodies> Turn<'_, '_, B> {
    /// Bodies from `first` on, of which those move whose bits are set in `moves`; whether all of them can be.
    #[inline(always)]
    fn block<S: Registers>(
        &mut self,
        registers: S,
        first: usize,
        count: usize,
        moves: u32,
    ) -> bool {
        let half = 0.5 * self.time_step;
        let shapes = match shapes_of(registers, self.arrays, first, count, moves) {
            Ok(shapes) => shapes,
            Err(k) => {
                *self.outcome = Err(Refusal::Shape.of_body(k));
                return false;
            }
        };
        let a = &mut *self.arrays;
        let (over_mass, divided) = over_masses(registers, a.masses, first, count, half);
        let f = vectors(registers, a.forces, first, count);
        let t = vectors(registers, a.torques, first, count);
        let v_before = vectors(registers, a.velocities, first, count);
        let l_before = vectors(registers, a.angular_momenta, first, count);
        let v = f.scale_add(over_mass, v_before);
        let l = t.scale_add(over_mass.constant(half), l_before);
        let (turned, good) = turn_block(registers, &shapes, l, self.time_step);
        let good = registers.and(good, divided);
        let sound = registers.bits(good) & moves;
        let writes = registers.mask(sound);

        let x_before = vectors(registers, a.positions, first, count);
        let x = v.scale_add(over_mass.constant(self.time_step), x_before);
        put_vectors(registers, (writes, x, x_before), a.positions, first, count);
        let [v, l] = match &mut a.extrapolation {
            None => [v, l],
            Some(extrapolation) => extrapolated(
                registers,
                extrapolation,
                (first, count),
                writes,
                ([f, t], [v, l]),
                [over_mass, over_mass.constant(half)],
            ),
        };
        put_vectors(registers, (writes, v, v_before), a.velocities, first, count);
        put_vectors(
            registers,
            (writes, l, l_before),
            a.angular_momenta,
            first,
            count,
        );
        let zero = Lanes::splat(registers, 0.0);
        let mut lines = [Line::ZERO; MOST_LANES];
        let [w, x, y, z] = turned;
        put(registers, [w, x, y, z, zero, zero, zero, zero], &mut lines);
        for (lane, line) in lines[..count].iter().enumerate() {
            if sound >> lane & 1 != 0 {
                let [w, x, y, z, ..] = line.0;
                a.bodies.turn(first + lane, [w, x, y, z]);
            }
        }
        let mut hard = moves & !sound;
        while hard != 0 {
            let lane = hard.trailing_zeros() as usize;
            hard &= hard - 1;
            if !self.one(first + lane) {
                return false;
            }
        }
        true
    }
}

/// What the bodies of a block are.
///
/// # Errors
/// The first one that moves and is no ellipsoid.
#[inline(always)]
fn shapes_of<S: Registers, B: Bodies>(
    registers: S,
    arrays: &BodyArrays<'_, B>,
    first: usize,
    count: usize,
    moves: u32,
) -> Result<BlockShapes<S>, usize> {
    // Of a body that does not move nothing is used.
    let mut lines = [Line([1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0]); MOST_LANES];
    let (mut triaxial, mut all_spheres) = (0, true);
    for (lane, line) in lines[..count].iter_mut().enumerate() {
        if moves >> lane & 1 == 0 {
            continue;
        }
        let Some((a, q)) = arrays.bodies.shape(first + lane) else {
            return Err(first + lane);
        };
        all_spheres &= a[0] == a[1] && a[1] == a[2];
        let is_triaxial = a[0] != a[1] && a[1] != a[2] && a[0] != a[2];
        triaxial |= u32::from(is_triaxial) << lane;
        let mass = arrays.masses[first + lane];
        *line = Line([a[0], a[1], a[2], q[0], q[1], q[2], q[3], mass]);
    }
    let n = Lanes::all(registers, registers.columns(&lines!(&lines)));
    Ok(BlockShapes {
        semi_axes: [n[0], n[1], n[2]],
        quaternion: [n[3], n[4], n[5], n[6]],
        mass: n[7],
        all_spheres,
        triaxial,
    })
}

/// Where quaternions have length 1 and semi-axes are within their range.
#[inline(always)]
fn are_usual<S: Registers>(registers: S, shapes: &BlockShapes<S>) -> S::Mask {
    let (q, a) = (shapes.quaternion, shapes.semi_axes);
    let square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    let unit = (square - 1.0).abs().less(square.constant(UNIT));
    // One that is not a number makes all that follows none.
    let [largest, least] = [
        a[0].max(a[1])
            .max(a[2])
            .less(square.constant(ABOVE_SEMI_AXES)),
        square
            .constant(BELOW_SEMI_AXES)
            .less(a[0].min(a[1]).min(a[2])),
    ];
    registers.and(unit, registers.and(largest, least))
}

/// See [`super::angular_velocities`].
pub(super) struct Spin<'p, 'a, B: Bodies> {
    pub arrays: &'p BodyArrays<'a, B>,
    pub selection: Selection<'p>,
    pub found: &'p mut [[f64; 3]],
    pub outcome: &'p mut Result<(), MotionError>,
}

impl<B: Bodies> Spin<'_, '_, B> {
    pub fn one_by_one(mut self) {
        for k in 0..self.found.len() {
            if self.selection.takes(k) && !self.one(k) {
                return;
            }
        }
    }

    #[cold]
    fn one(&mut self, k: usize) -> bool {
        match angular_velocity(self.arrays, k) {
            Ok(omega) => {
                self.found[k] = omega;
                true
            }
            Err(why) => {
                *self.outcome = Err(why.of_body(k));
                false
            }
        }
    }
}

impl<B: Bodies> Stage for Spin<'_, '_, B> {
    #[inline(always)]
    fn run<S: Registers>(mut self, registers: S) {
        let n = self.found.len();
        let mut first = 0;
        while first < n {
            let count = S::LANES.min(n - first);
            let moves = self.selection.lanes(first, count);
            let mut hard = moves;
            // One without a shape is named by what takes bodies one by one.
            if let Ok(shapes) = shapes_of(registers, self.arrays, first, count, moves) {
                let (omega, sound) = spins(registers, self.arrays, &shapes, first, count);
                let sound = registers.bits(sound) & moves;
                let before = vectors(registers, self.found, first, count);
                let found = (registers.mask(sound), omega, before);
                put_vectors(registers, found, self.found, first, count);
                hard &= !sound;
            }
            while hard != 0 {
                let lane = hard.trailing_zeros() as usize;
                hard &= hard - 1;
                if !self.one(first + lane) {
                    return;
                }
            }
            first += S::LANES;
        }
    }
}

/// Angular velocities of a block, world frame, and where they are right.
#[inline(always)]
fn spins<S: Registers, B: Bodies>(
    registers: S,
    arrays: &BodyArrays<'_, B>,
    shapes: &BlockShapes<S>,
    first: usize,
    count: usize,
) -> (Vector3<Lanes<S>>, S::Mask) {
    let momentum = vectors(registers, arrays.angular_momenta, first, count);
    let mass = shapes.mass;
    let axes = rotation_columns(shapes.quaternion, mass.constant(2.0));
    let own = body_velocity(axes, momentum, moments(mass, shapes.semi_axes).0);
    let omega = axes[2].scale_add(own.z, axes[1].scale_add(own.y, axes[0] * own.x));
    let divided = registers.and(
        mass.constant(DIVIDED[0]).less(mass),
        mass.less(mass.constant(DIVIDED[1])),
    );
    (omega, registers.and(divided, are_usual(registers, shapes)))
}

/// Where a block turns to within the time, and where that is exact to rounding.
#[inline(always)]
fn turn_block<S: Registers>(
    registers: S,
    shapes: &BlockShapes<S>,
    momentum: Vector3<Lanes<S>>,
    time: f64,
) -> (Quaternion<Lanes<S>>, S::Mask) {
    let (q, mass, a) = (shapes.quaternion, shapes.mass, shapes.semi_axes);
    let (mut turned, mut good) = if shapes.all_spheres {
        by_one_rotation(q, momentum, mass, a[0], time)
    } else {
        by_two_rotations(registers, q, momentum, mass, a, time)
    };
    if shapes.triaxial != 0 {
        // A body of three different semi-axes costs more than one of revolution: blocks without any do not pay for it.
        let (expanded, exact) = in_expansion(registers, q, momentum, mass, a, time);
        let triaxial = registers.mask(shapes.triaxial);
        turned = [
            Lanes::select(triaxial, expanded[0], turned[0]),
            Lanes::select(triaxial, expanded[1], turned[1]),
            Lanes::select(triaxial, expanded[2], turned[2]),
            Lanes::select(triaxial, expanded[3], turned[3]),
        ];
        good = registers.or(
            registers.and(triaxial, exact),
            registers.and_not(good, triaxial),
        );
    }
    // One that is not a number makes the turn none, which is not good.
    (turned, registers.and(good, are_usual(registers, shapes)))
}

/// One for the centres and one for the rotations.
type TwoVectors<S> = [Vector3<Lanes<S>>; 2];

/// `extrapolate` of `one_body.rs` of a block; `factors` are half the time over the masses, and half the time.
#[inline(always)]
fn extrapolated<S: Registers>(
    registers: S,
    extrapolation: &mut Extrapolation<'_>,
    (first, count): (usize, usize),
    writes: S::Mask,
    (loads, velocities): (TwoVectors<S>, TwoVectors<S>),
    factors: [Lanes<S>; 2],
) -> TwoVectors<S> {
    let zero = Lanes::splat(registers, 0.0);
    let mut before = two_vectors(registers, extrapolation.loads_before, first, count);
    let were = before;
    let known = before[0].x.less(zero.constant(f64::INFINITY));
    let ratio = Lanes::select(known, zero.constant(extrapolation.step_ratio), zero);
    let (mut changes, mut found) = (velocities, velocities);
    for k in 0..2 {
        before[k] = Vector3::select(known, before[k], loads[k]);
        let rounding =
            (loads[k].norm_squared() + before[k].norm_squared()) * zero.constant(REVERSAL);
        let turned = loads[k].dot(before[k]).less(zero - rounding);
        let steady = Lanes::select(turned, zero, factors[k]);
        let load = (loads[k] - before[k]).scale_add(ratio, loads[k]);
        changes[k] = load * steady;
        found[k] = velocities[k] + changes[k];
    }
    let kept = registers.all(writes);
    let now = if kept {
        loads
    } else {
        [
            Vector3::select(writes, loads[0], were[0]),
            Vector3::select(writes, loads[1], were[1]),
        ]
    };
    put_two_vectors(registers, now, extrapolation.loads_before, first, count);
    if !kept {
        let were = two_vectors(registers, extrapolation.changes, first, count);
        changes = [
            Vector3::select(writes, changes[0], were[0]),
            Vector3::select(writes, changes[1], were[1]),
        ];
    }
    put_two_vectors(registers, changes, extrapolation.changes, first, count);
    found
}

/// See [`super::finish_step`].
pub(super) struct Kick<'p, 'a, B: Bodies> {
    pub arrays: &'p mut BodyArrays<'a, B>,
    pub selection: Selection<'p>,
    /// Half the time step.
    pub time: f64,
}

impl<B: Bodies> Kick<'_, '_, B> {
    pub fn one_by_one(self) {
        for k in 0..self.arrays.positions.len() {
            if self.selection.takes(k) {
                finish_step_of_body(self.arrays, k, 2.0 * self.time);
            }
        }
    }
}

impl<B: Bodies> Stage for Kick<'_, '_, B> {
    #[inline(always)]
    fn run<S: Registers>(self, registers: S) {
        let n = self.arrays.positions.len();
        let mut first = 0;
        while first < n {
            let count = S::LANES.min(n - first);
            let moves = self.selection.lanes(first, count);
            if moves != 0 {
                kick_block(registers, self.arrays, first, count, moves, self.time);
            }
            first += S::LANES;
        }
    }
}

/// Half a kick of a block of bodies.
#[inline(always)]
fn kick_block<S: Registers, B: Bodies>(
    registers: S,
    a: &mut BodyArrays<'_, B>,
    first: usize,
    count: usize,
    moves: u32,
    time: f64,
) {
    let (over_mass, divided) = over_masses(registers, a.masses, first, count, time);
    let sound = registers.bits(divided) & moves;
    let writes = registers.mask(sound);
    let half = over_mass.constant(time);
    let f = vectors(registers, a.forces, first, count);
    let t = vectors(registers, a.torques, first, count);
    let v_before = vectors(registers, a.velocities, first, count);
    let l_before = vectors(registers, a.angular_momenta, first, count);
    let [v, l] = match &mut a.extrapolation {
        None => [
            f.scale_add(over_mass, v_before),
            t.scale_add(half, l_before),
        ],
        Some(extrapolation) => {
            // What differs is remembered, not the velocity: something else may change that in between.
            let were = two_vectors(registers, extrapolation.changes, first, count);
            let changes = [were[0] - f * over_mass, were[1] - t * half];
            let kept = [
                Vector3::select(writes, changes[0], were[0]),
                Vector3::select(writes, changes[1], were[1]),
            ];
            put_two_vectors(registers, kept, extrapolation.changes, first, count);
            [v_before - changes[0], l_before - changes[1]]
        }
    };
    put_vectors(registers, (writes, v, v_before), a.velocities, first, count);
    put_vectors(
        registers,
        (writes, l, l_before),
        a.angular_momenta,
        first,
        count,
    );
    let mut hard = moves & !sound;
    while hard != 0 {
        let lane = hard.trailing_zeros() as usize;
        hard &= hard - 1;
        finish_step_of_body(a, first + lane, 2.0 * time);
    }
}

/// Spheres, and where the result is exact to rounding.
#[inline(always)]
fn by_one_rotation<S: Registers>(
    q: Quaternion<Lanes<S>>,
    momentum: Vector3<Lanes<S>>,
    mass: Lanes<S>,
    radius: Lanes<S>,
    time: f64,
) -> (Quaternion<Lanes<S>>, S::Mask) {
    // In the words of `by_two_rotations`, so that a sphere turns the same whatever is beside it.
    let across = (mass * radius.multiply_add(radius, radius * radius)).reciprocal() * 5.0;
    let angle = momentum * (across * (0.5 * time));
    let largest = mass.constant(LARGEST_HALF_ANGLE * LARGEST_HALF_ANGLE);
    let good = angle.norm_squared().less(largest);
    (of_a_sphere(q, angle), good)
}

/// A chunk of bodies of revolution, and where the result is exact to rounding.
#[inline(always)]
fn by_two_rotations<S: Registers>(
    registers: S,
    q: Quaternion<Lanes<S>>,
    momentum: Vector3<Lanes<S>>,
    mass: Lanes<S>,
    a: [Lanes<S>; 3],
    time: f64,
) -> (Quaternion<Lanes<S>>, S::Mask) {
    // The axis of revolution: the third where the first two semi-axes are the same, else the one that stands apart.
    let (zero, one) = (mass.constant(0.0), mass.constant(1.0));
    let third = registers.not(registers.or(a[0].less(a[1]), a[1].less(a[0])));
    let second = registers.or(a[1].less(a[2]), a[2].less(a[1]));
    let choose = |x: Lanes<S>, y: Lanes<S>, z: Lanes<S>| {
        Lanes::select(third, z, Lanes::select(second, y, x))
    };
    let own_axis = Vector3::new(
        choose(one, zero, zero),
        choose(zero, one, zero),
        choose(zero, zero, one),
    );
    let axes = rotation_columns(q, one * 2.0);
    let axis = Vector3::new(
        choose(axes[0].x, axes[1].x, axes[2].x),
        choose(axes[0].y, axes[1].y, axes[2].y),
        choose(axes[0].z, axes[1].z, axes[2].z),
    );
    let (polar, equatorial) = (choose(a[0], a[1], a[2]), choose(a[1], a[2], a[0]));
    let equatorial_square = equatorial * equatorial;
    let across = (mass * polar.multiply_add(polar, equatorial_square)).reciprocal() * 5.0;
    let along = (mass * equatorial_square).reciprocal() * 2.5;
    let (precession, spin) = half_angles(axis, momentum, along, across, time);
    // A sphere does not spin about an axis of its own.
    let sphere = registers.and_not(third, second);
    let angles = (precession, Lanes::select(sphere, zero, spin));
    let largest = one.constant(LARGEST_HALF_ANGLE * LARGEST_HALF_ANGLE);
    let good = registers.and(
        angles.0.norm_squared().less(largest),
        (angles.1 * angles.1).less(largest),
    );
    (of_revolution(q, own_axis, angles), good)
}

/// Where one step of the expansion is exact to rounding.
#[inline(always)]
fn is_slow<S: Registers>(registers: S, omega: Vector3<Lanes<S>>, time: f64) -> S::Mask {
    // One that is not a number is not less than anything, but may hide behind the larger of two: the sum shows it.
    let largest = omega.x.abs().max(omega.y.abs()).max(omega.z.abs()) * time;
    let sum = (omega.x.abs() + omega.y.abs() + omega.z.abs()) * time;
    let limit = largest.constant(LARGEST_EXPANDED_TURN);
    registers.and(largest.less(limit), sum.less(limit * 4.0))
}

/// Parts of a step that the lanes take one after the other where one of them turns too fast for the whole: most that turn too fast
/// turn a little too fast.
const PARTS_IN_LANES: usize = 4;

/// A chunk of bodies with three different semi-axes, and where the result is exact to rounding.
#[inline(always)]
fn in_expansion<S: Registers>(
    registers: S,
    q: Quaternion<Lanes<S>>,
    momentum: Vector3<Lanes<S>>,
    mass: Lanes<S>,
    a: [Lanes<S>; 3],
    time: f64,
) -> (Quaternion<Lanes<S>>, S::Mask) {
    let (inverse_moments, ratios) = moments(mass, a);
    // Every lane.
    let all = mass.constant(0.0).less(mass.constant(1.0));
    let (mut q, mut parts, mut good) = (q, 1, all);
    let mut part = 0;
    while part < parts {
        let omega = body_velocity(
            rotation_columns(q, mass.constant(2.0)),
            momentum,
            inverse_moments,
        );
        if part == 0 && !registers.all(is_slow(registers, omega, time)) {
            parts = PARTS_IN_LANES;
        }
        let share = time / parts as f64;
        good = registers.and(good, is_slow(registers, omega, share));
        q = of_three_moments(q, omega, ratios, share);
        part += 1;
    }
    (q, good)
}
