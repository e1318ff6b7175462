// SPDX-License-Identifier: MIT OR Apache-2.0
//! A step of velocity Verlet for an engine's ellipsoids, in lanes: half a kick and the way in [`start_step`], the other half of
//! the kick, once the new forces are known, in [`finish_step`].
//!
//! Symplectic and reversible: the kicks and the free motion are each solved exactly.

use super::free_rotation::{
    body_velocity, half_angles, of_revolution, of_revolution_by_any_angle, of_three_moments,
    Quaternion, LARGEST_EXPANDED_TURN, LARGEST_HALF_ANGLE,
};
use crate::geometry::ellipsoid::{rotation_columns, LARGEST_SEMI_AXIS, LEAST_SEMI_AXIS};
use crate::message::Number;
#[cfg(not(feature = "std"))]
use crate::real::Functions;
use crate::real::Real;
use crate::simd::{InstructionSet, Lanes, Registers, Stage, MOST_LANES};
use crate::vector::Vector3;
#[cfg(not(feature = "std"))]
use alloc::string::String;

/// Largest angle, radian, by which a body may turn in a step: a contact sees nothing of what is faster.
const LARGEST_TURN: f64 = core::f64::consts::PI;

/// How far the square of a quaternion's length may be from 1 for the quaternion to be taken as it is.
const UNIT: f64 = 1e-12;

/// Within the range of semi-axes, by a little: one at its very end is looked at by itself.
const BELOW_SEMI_AXES: f64 = LEAST_SEMI_AXIS * (1.0 + 1e-9);
const ABOVE_SEMI_AXES: f64 = LARGEST_SEMI_AXIS * (1.0 - 1e-9);

/// More parts of a step than a turn of [`LARGEST_TURN`] needs.
const MOST_PARTS: usize = 100_000;

/// Shapes and attitudes of an engine's bodies.
pub trait Bodies {
    /// Semi-axes and quaternion `(w, x, y, z)`, body to world; `None` for what is no ellipsoid.
    fn shape(&self, k: usize) -> Option<([f64; 3], [f64; 4])>;
    /// A new quaternion for a body that has a shape.
    fn turn(&mut self, k: usize, quaternion: [f64; 4]);
}

/// An engine's arrays of bodies, of the same length; world frame.
pub struct BodyArrays<'a, B: Bodies> {
    /// Centres.
    pub positions: &'a mut [[f64; 3]],
    /// Velocities of the centres.
    pub velocities: &'a mut [[f64; 3]],
    /// Angular momenta of solid ellipsoids about their centres.
    pub angular_momenta: &'a mut [[f64; 3]],
    /// Forces.
    pub forces: &'a [[f64; 3]],
    /// Torques about the centres.
    pub torques: &'a [[f64; 3]],
    /// Masses.
    pub masses: &'a [f64],
    /// Shapes and attitudes.
    pub bodies: B,
    /// Where the forces are to see velocities of the step at which they are computed; `None`: those of the half step.
    pub extrapolation: Option<Extrapolation<'a>>,
}

/// What takes velocities and angular momenta from the half step to the end of the step, where the next forces are computed:
/// from the accelerations `a` of now and `a'` of the step before, half a step of `a + r (a - a')` with `r` the ratio of this
/// step to that one; nothing where `a` has turned against `a'`.
///
/// The forces then depend on velocities that are right to the second order, and the step stays explicit. The velocities
/// with which the bodies move, and without such forces the motion itself, are those of velocity Verlet. An overdamped mode
/// that the extrapolation would let grow (damping coefficient over mass times step above 1/2) changes the sign of its
/// acceleration in each step: there the velocities of the half step serve, so that the step may be as large as with these
/// (docs/theory.md, section 8).
pub struct Extrapolation<'a> {
    /// Written by [`start_step`]: what velocities and angular momenta have more than those of the half step; by
    /// [`finish_step`]: what those that the forces were computed with had more than those of the end of the step.
    pub changes: &'a mut [[f64; 6]],
    /// Forces and torques of the step before; overwritten by those of now. Not known where the first is infinite: those of
    /// now then stand for them, which is right for what moves freely before it touches.
    pub loads_before: &'a mut [[f64; 6]],
    /// This step over the one before.
    pub step_ratio: f64,
}

/// Which bodies move: those whose number shares a bit with `bits`; all where there are no numbers.
#[derive(Clone, Copy)]
pub struct Selection<'a> {
    /// A number for each body, or none at all.
    pub groups: &'a [i32],
    /// Bits of the groups that move.
    pub bits: i32,
}

impl Selection<'_> {
    #[inline(always)]
    fn takes(&self, k: usize) -> bool {
        self.groups
            .get(k)
            .is_none_or(|group| group & self.bits != 0)
    }
}

/// A body that cannot be moved.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionError {
    /// Its index.
    pub body: usize,
    /// What is wrong.
    pub what: String,
}

/// Half a kick, then the way of a whole step: velocities and angular momenta become those of the half step (or, with an
/// [`Extrapolation`], of its end), positions and quaternions those of the end of the step. Quaternions come out with length 1.
///
/// # Errors
/// The first body, in the order of the arrays' chunks, that is no ellipsoid, that has a semi-axis or a mass out of range, or
/// that would turn by more than half a circle. Other bodies may have been moved then.
///
/// # Example
/// A free grain that turns about its long axis, by a quarter of a circle in one step; any consistent units:
/// ```
/// use ellgran::motion::{finish_step, start_step, Bodies, BodyArrays, Selection};
/// use ellgran::simd::InstructionSet;
///
/// struct Grain([f64; 4]);
/// impl Bodies for Grain {
///     fn shape(&self, _: usize) -> Option<([f64; 3], [f64; 4])> {
///         Some(([2.0, 1.0, 1.0], self.0))
///     }
///     fn turn(&mut self, _: usize, quaternion: [f64; 4]) {
///         self.0 = quaternion;
///     }
/// }
///
/// // Moment of inertia m (b^2 + c^2)/5 = 0.4 for mass 1.
/// let quarter = core::f64::consts::FRAC_PI_2;
/// let mut grain = BodyArrays {
///     positions: &mut [[0.0; 3]],
///     velocities: &mut [[3.0, 0.0, 0.0]],
///     angular_momenta: &mut [[0.4 * quarter, 0.0, 0.0]],
///     forces: &[[0.0; 3]],
///     torques: &[[0.0; 3]],
///     masses: &[1.0],
///     bodies: Grain([1.0, 0.0, 0.0, 0.0]),
///     extrapolation: None,
/// };
/// let all = Selection { groups: &[], bits: 0 };
/// start_step(InstructionSet::choose()?, &mut grain, all, 1.0).expect("it can be moved");
/// finish_step(&mut grain, all, 1.0);
/// assert_eq!(grain.positions[0], [3.0, 0.0, 0.0]);
/// assert!((grain.bodies.0[1] - (quarter / 2.0).sin()).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn start_step<B: Bodies>(
    set: InstructionSet,
    arrays: &mut BodyArrays<'_, B>,
    selection: Selection<'_>,
    time_step: f64,
) -> Result<(), MotionError> {
    let mut outcome = Ok(());
    let turn = Turn {
        arrays,
        selection,
        time_step,
        outcome: &mut outcome,
    };
    if set == InstructionSet::Scalar {
        turn.one_by_one();
    } else {
        set.run(turn);
    }
    outcome
}

/// The other half of the kick, with the forces of the end of the step, on the velocities of the half step.
pub fn finish_step<B: Bodies>(
    arrays: &mut BodyArrays<'_, B>,
    selection: Selection<'_>,
    time_step: f64,
) {
    if arrays.extrapolation.is_some() {
        for k in 0..arrays.same_length() {
            if selection.takes(k) {
                kick_from_extrapolated(arrays, k, 0.5 * time_step);
            }
        }
        return;
    }
    for k in 0..arrays.same_length() {
        if selection.takes(k) {
            kick(arrays, k, 0.5 * time_step);
        }
    }
}

/// The angular velocities, world frame, that go with the angular momenta and attitudes of now, of the bodies that move; the
/// others' are left as they are.
///
/// # Errors
/// The first body that is no ellipsoid, whose quaternion has no length, or whose semi-axes or mass are out of range.
pub fn angular_velocities<B: Bodies>(
    arrays: &BodyArrays<'_, B>,
    selection: Selection<'_>,
    found: &mut [[f64; 3]],
) -> Result<(), MotionError> {
    for (k, found) in found.iter_mut().enumerate() {
        if !selection.takes(k) {
            continue;
        }
        let wrong = |why: Refusal| why.of_body(k);
        let (semi_axes, q) = arrays
            .bodies
            .shape(k)
            .ok_or_else(|| wrong(Refusal::Shape))?;
        let square: f64 = q.iter().map(|x| x * x).sum();
        // Those of `start_step` are.
        let q = if (square - 1.0).abs() < UNIT {
            q
        } else {
            normalised(q).map_err(wrong)?
        };
        let mass = checked_mass(arrays.masses[k]).map_err(wrong)?;
        check_shape(semi_axes).map_err(wrong)?;
        let axes = rotation_columns(q, 2.0);
        let momentum = Vector3::from_array(arrays.angular_momenta[k]);
        let own = body_velocity(axes, momentum, moments(mass, semi_axes).0);
        *found = (axes[0] * own.x + axes[1] * own.y + axes[2] * own.z).to_array();
    }
    Ok(())
}

/// Why a body cannot be moved.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal {
    /// It is no ellipsoid.
    Shape,
    /// A semi-axis of its.
    SemiAxis(f64),
    /// Length of its quaternion.
    Quaternion(f64),
    /// Its mass.
    Mass(f64),
    /// By how much it would turn, radian, and in which time.
    Turn(f64, f64),
    /// Its rotation grows within the step.
    Rotation,
}

impl Refusal {
    fn describe(self) -> String {
        match self {
            Refusal::Shape => {
                "it has no shape: every body that is moved must be an ellipsoid".into()
            }
            Refusal::SemiAxis(length) => format!(
                "semi-axis = {} must be from {LEAST_SEMI_AXIS:e} to {LARGEST_SEMI_AXIS:e}",
                Number(length)
            ),
            Refusal::Quaternion(length) => {
                format!("its quaternion has length {}", Number(length))
            }
            Refusal::Mass(mass) => format!(
                "mass = {} must be a finite number greater than 0",
                Number(mass)
            ),
            Refusal::Turn(turn, time) => format!(
                "it would turn by {} radian in a step of {}, more than half a circle: the time step is too large, or a \
                 force has grown without bound",
                Number(turn),
                Number(time)
            ),
            Refusal::Rotation => {
                "its rotation has grown too fast to be followed within a step".into()
            }
        }
    }

    fn of_body(self, body: usize) -> MotionError {
        MotionError {
            body,
            what: self.describe(),
        }
    }
}

fn normalised(q: [f64; 4]) -> Result<[f64; 4], Refusal> {
    let length = q.iter().fold(0.0, |sum: f64, x| sum.hypot(*x));
    if length > 0.0 && length.is_finite() {
        Ok(q.map(|x| x / length))
    } else {
        Err(Refusal::Quaternion(length))
    }
}

fn checked_mass(mass: f64) -> Result<f64, Refusal> {
    if mass > 0.0 && mass.is_finite() {
        Ok(mass)
    } else {
        Err(Refusal::Mass(mass))
    }
}

fn check_shape(semi_axes: [f64; 3]) -> Result<(), Refusal> {
    let range = LEAST_SEMI_AXIS..=LARGEST_SEMI_AXIS;
    match semi_axes.into_iter().find(|a| !range.contains(a)) {
        Some(a) => Err(Refusal::SemiAxis(a)),
        None => Ok(()),
    }
}

impl<B: Bodies> BodyArrays<'_, B> {
    /// Cuts the arrays to the length of the first, so that one test of an index serves all of them.
    #[inline(always)]
    fn same_length(&mut self) -> usize {
        let n = self.positions.len();
        let velocities = core::mem::take(&mut self.velocities);
        self.velocities = &mut velocities[..n];
        let momenta = core::mem::take(&mut self.angular_momenta);
        self.angular_momenta = &mut momenta[..n];
        self.forces = &self.forces[..n];
        self.torques = &self.torques[..n];
        self.masses = &self.masses[..n];
        if let Some(Extrapolation {
            changes,
            loads_before,
            ..
        }) = &mut self.extrapolation
        {
            *changes = &mut core::mem::take(changes)[..n];
            *loads_before = &mut core::mem::take(loads_before)[..n];
        }
        n
    }
}

/// Half a kick of one body.
#[inline(always)]
fn kick<B: Bodies>(arrays: &mut BodyArrays<'_, B>, k: usize, time: f64) {
    let over_mass = time / arrays.masses[k];
    let (v, f) = (&mut arrays.velocities[k], &arrays.forces[k]);
    let (l, t) = (&mut arrays.angular_momenta[k], &arrays.torques[k]);
    for axis in 0..3 {
        v[axis] += over_mass * f[axis];
        l[axis] += time * t[axis];
    }
}

/// Takes the velocities of a body to the end of the step, once it has moved with those of the half step.
#[inline(always)]
fn extrapolate<B: Bodies>(arrays: &mut BodyArrays<'_, B>, k: usize, half: f64) {
    let Some(extrapolation) = &mut arrays.extrapolation else {
        return;
    };
    let (change, before) = (
        &mut extrapolation.changes[k],
        &mut extrapolation.loads_before[k],
    );
    let (v, f) = (&mut arrays.velocities[k], &arrays.forces[k]);
    let (l, t) = (&mut arrays.angular_momenta[k], &arrays.torques[k]);
    let over_mass = half / arrays.masses[k];
    // Not known before: no change of the load.
    let ratio = if before[0] == f64::INFINITY {
        *before = [f[0], f[1], f[2], t[0], t[1], t[2]];
        0.0
    } else {
        extrapolation.step_ratio
    };
    let dot = |a: &[f64], b: &[f64]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let steady = |same_way: f64, factor: f64| if same_way < 0.0 { 0.0 } else { factor };
    let over_mass = steady(dot(f, &before[..3]), over_mass);
    let half = steady(dot(t, &before[3..]), half);
    for axis in 0..3 {
        let force = f[axis] + ratio * (f[axis] - before[axis]);
        let torque = t[axis] + ratio * (t[axis] - before[3 + axis]);
        change[axis] = over_mass * force;
        change[3 + axis] = half * torque;
        v[axis] += change[axis];
        l[axis] += change[3 + axis];
        before[axis] = f[axis];
        before[3 + axis] = t[axis];
    }
}

/// Half a kick of one body whose velocities are the extrapolated ones.
#[inline(always)]
fn kick_from_extrapolated<B: Bodies>(arrays: &mut BodyArrays<'_, B>, k: usize, half: f64) {
    let Some(extrapolation) = &mut arrays.extrapolation else {
        return;
    };
    let change = &mut extrapolation.changes[k];
    let over_mass = half / arrays.masses[k];
    let (v, f) = (&mut arrays.velocities[k], &arrays.forces[k]);
    let (l, t) = (&mut arrays.angular_momenta[k], &arrays.torques[k]);
    for axis in 0..3 {
        // What differs is remembered, not the velocity: something else may change that in between.
        change[axis] -= over_mass * f[axis];
        change[3 + axis] -= half * t[axis];
        v[axis] -= change[axis];
        l[axis] -= change[3 + axis];
    }
}

/// Half the kick, and the way of the centre. The shape and attitude, if there is one.
#[inline(always)]
fn move_centre<B: Bodies>(
    arrays: &mut BodyArrays<'_, B>,
    k: usize,
    time_step: f64,
) -> Option<([f64; 3], [f64; 4])> {
    let shape = arrays.bodies.shape(k)?;
    kick(arrays, k, 0.5 * time_step);
    let (x, v) = (&mut arrays.positions[k], &arrays.velocities[k]);
    for axis in 0..3 {
        x[axis] += time_step * v[axis];
    }
    Some(shape)
}

/// [`start_step`] of one body. Public for the kernels in `gpu/`; no interface for others.
///
/// # Errors
/// What is wrong with the body.
#[doc(hidden)]
#[inline(always)]
pub fn start_step_of_body<B: Bodies>(
    arrays: &mut BodyArrays<'_, B>,
    k: usize,
    time_step: f64,
) -> Result<(), Refusal> {
    let (semi_axes, q) = move_centre(arrays, k, time_step).ok_or(Refusal::Shape)?;
    let (l, mass) = (arrays.angular_momenta[k], arrays.masses[k]);
    extrapolate(arrays, k, 0.5 * time_step);
    let new = turned(q, Vector3::from_array(l), mass, semi_axes, time_step)?;
    arrays.bodies.turn(k, new);
    Ok(())
}

/// See [`start_step`].
struct Turn<'p, 'a, B: Bodies> {
    arrays: &'p mut BodyArrays<'a, B>,
    selection: Selection<'p>,
    time_step: f64,
    outcome: &'p mut Result<(), MotionError>,
}

/// Numbers of each body on its way into the lanes: angular momentum, quaternion, mass, semi-axes.
const NUMBERS: usize = 11;

/// Bodies on their way into the lanes, a row for each of their numbers.
struct Chunk {
    bodies: [usize; MOST_LANES],
    length: usize,
    rows: [[f64; MOST_LANES]; NUMBERS],
}

impl Chunk {
    const EMPTY: Chunk = Chunk {
        bodies: [0; MOST_LANES],
        length: 0,
        rows: [[0.0; MOST_LANES]; NUMBERS],
    };

    /// One body more.
    #[inline(always)]
    fn push(&mut self, body: usize, numbers: [f64; NUMBERS]) {
        let lane = self.length % MOST_LANES;
        self.bodies[lane] = body;
        for (row, number) in self.rows.iter_mut().zip(numbers) {
            row[lane] = number;
        }
        self.length = lane + 1;
    }
}

impl<B: Bodies> Stage for Turn<'_, '_, B> {
    #[inline(always)]
    fn run<S: Registers>(mut self, registers: S) {
        // A body of three different semi-axes costs more than one of revolution: they do not share registers.
        let (mut of_revolution, mut triaxial) = (Chunk::EMPTY, Chunk::EMPTY);
        for k in 0..self.arrays.same_length() {
            if !self.selection.takes(k) {
                continue;
            }
            let Some((a, q)) = self.move_centre(k) else {
                return;
            };
            let is_triaxial = a[0] != a[1] && a[1] != a[2] && a[0] != a[2];
            let chunk = if is_triaxial {
                &mut triaxial
            } else {
                &mut of_revolution
            };
            let l = &self.arrays.angular_momenta[k];
            let mass = self.arrays.masses[k];
            chunk.push(
                k,
                [
                    l[0], l[1], l[2], q[0], q[1], q[2], q[3], mass, a[0], a[1], a[2],
                ],
            );
            // The chunk has the momentum of the half step, by which the body turns.
            extrapolate(self.arrays, k, 0.5 * self.time_step);
            if chunk.length == S::LANES && !self.turn(registers, chunk, is_triaxial) {
                return;
            }
        }
        for (chunk, is_triaxial) in [(&mut of_revolution, false), (&mut triaxial, true)] {
            if chunk.length == 0 {
                continue;
            }
            // Lanes without a body of their own repeat the first.
            for row in &mut chunk.rows {
                let first = row[0];
                row[chunk.length..].fill(first);
            }
            if !self.turn(registers, chunk, is_triaxial) {
                return;
            }
        }
    }
}

impl<B: Bodies> Turn<'_, '_, B> {
    fn one_by_one(self) {
        for k in 0..self.arrays.same_length() {
            if !self.selection.takes(k) {
                continue;
            }
            if let Err(why) = start_step_of_body(self.arrays, k, self.time_step) {
                *self.outcome = Err(why.of_body(k));
                return;
            }
        }
    }

    /// Half the kick, and the way of the centre. The shape and attitude, if there is one.
    #[inline(always)]
    fn move_centre(&mut self, k: usize) -> Option<([f64; 3], [f64; 4])> {
        let shape = move_centre(self.arrays, k, self.time_step);
        if shape.is_none() {
            *self.outcome = Err(Refusal::Shape.of_body(k));
        }
        shape
    }

    /// Turns a chunk; whether all of its bodies can be.
    #[inline(always)]
    fn turn<S: Registers>(&mut self, registers: S, chunk: &mut Chunk, is_triaxial: bool) -> bool {
        let row = |k: usize| Lanes::load(registers, &chunk.rows[k]);
        let momentum = Vector3::new(row(0), row(1), row(2));
        let (q, mass) = ([row(3), row(4), row(5), row(6)], row(7));
        let a = [row(8), row(9), row(10)];
        let (turned, good) = if is_triaxial {
            in_expansion(registers, q, momentum, mass, a, self.time_step)
        } else {
            by_two_rotations(registers, q, momentum, mass, a, self.time_step)
        };
        let square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
        let unit = (square - 1.0).abs().less(square.constant(UNIT));
        // One that is not a number makes the turn none, which is not good.
        let [largest, least] = [
            a[0].max(a[1])
                .max(a[2])
                .less(mass.constant(ABOVE_SEMI_AXES)),
            mass.constant(BELOW_SEMI_AXES)
                .less(a[0].min(a[1]).min(a[2])),
        ];
        let good = registers.and(good, registers.and(largest, least));
        let good = registers.bits(registers.and(good, unit));
        let mut new = [[0.0; MOST_LANES]; 4];
        turned[0].store(&mut new[0]);
        turned[1].store(&mut new[1]);
        turned[2].store(&mut new[2]);
        turned[3].store(&mut new[3]);
        let length = chunk.length;
        chunk.length = 0;
        for lane in 0..length {
            let k = chunk.bodies[lane];
            if good >> lane & 1 != 0 {
                let new = [new[0][lane], new[1][lane], new[2][lane], new[3][lane]];
                self.arrays.bodies.turn(k, new);
                continue;
            }
            let mut numbers = [0.0; NUMBERS];
            for (number, row) in numbers.iter_mut().zip(&chunk.rows) {
                *number = row[lane];
            }
            let [lx, ly, lz, w, x, y, z, mass, a, b, c] = numbers;
            if !self.turn_one(k, [a, b, c], [w, x, y, z], [lx, ly, lz], mass) {
                return false;
            }
        }
        true
    }

    /// Turns one body, by whatever angle; whether it can be.
    #[cold]
    fn turn_one(
        &mut self,
        k: usize,
        semi_axes: [f64; 3],
        q: [f64; 4],
        momentum: [f64; 3],
        mass: f64,
    ) -> bool {
        match turned(
            q,
            Vector3::from_array(momentum),
            mass,
            semi_axes,
            self.time_step,
        ) {
            Ok(new) => {
                self.arrays.bodies.turn(k, new);
                true
            }
            Err(why) => {
                *self.outcome = Err(why.of_body(k));
                false
            }
        }
    }
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
    let angles = half_angles(axis, momentum, along, across, time);
    let largest = one.constant(LARGEST_HALF_ANGLE * LARGEST_HALF_ANGLE);
    let good = registers.and(
        angles.0.norm_squared().less(largest),
        (angles.1 * angles.1).less(largest),
    );
    (of_revolution(q, own_axis, angles), good)
}

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
    let axes = rotation_columns(q, mass.constant(2.0));
    let omega = body_velocity(axes, momentum, inverse_moments);
    // One that is not a number is not less than anything, but may hide behind the larger of two: the sum shows it.
    let largest = omega.x.abs().max(omega.y.abs()).max(omega.z.abs()) * time;
    let sum = (omega.x.abs() + omega.y.abs() + omega.z.abs()) * time;
    let limit = mass.constant(LARGEST_EXPANDED_TURN);
    let good = registers.and(largest.less(limit), sum.less(limit * 4.0));
    (of_three_moments(q, omega, ratios, time), good)
}

/// Inverses of the moments of inertia of a solid ellipsoid, and `(I_y - I_z)/I_x` and so on, cyclically.
#[inline(always)]
fn moments<T: Real>(mass: T, [a, b, c]: [T; 3]) -> (Vector3<T>, Vector3<T>) {
    let (xx, yy, zz) = (a * a, b * b, c * c);
    let inverse = Vector3::new(
        (yy + zz).reciprocal(),
        (xx + zz).reciprocal(),
        (xx + yy).reciprocal(),
    );
    let ratios = Vector3::new(
        (c - b) * (c + b) * inverse.x,
        (a - c) * (a + c) * inverse.y,
        (b - a) * (b + a) * inverse.z,
    );
    (inverse * (mass.reciprocal() * 5.0), ratios)
}

/// The quaternion of one body at the end of a step in which nothing acts on it.
fn turned(
    q: [f64; 4],
    momentum: Vector3,
    mass: f64,
    semi_axes: [f64; 3],
    time: f64,
) -> Result<[f64; 4], Refusal> {
    let mut q = normalised(q)?;
    let mass = checked_mass(mass)?;
    check_shape(semi_axes)?;
    let (inverse_moments, ratios) = moments(mass, semi_axes);
    let omega_of = |q: [f64; 4]| body_velocity(rotation_columns(q, 2.0), momentum, inverse_moments);
    let turn = omega_of(q).norm() * time;
    if !(turn <= LARGEST_TURN) {
        return Err(Refusal::Turn(turn, time));
    }
    let [a, b, c] = semi_axes;
    if a == b || b == c || a == c {
        let polar = match (a == b, b == c) {
            (true, _) => 2,
            (_, true) => 0,
            _ => 1,
        };
        let mut own_axis = [0.0; 3];
        own_axis[polar] = 1.0;
        let inverse = inverse_moments.to_array();
        let angles = half_angles(
            rotation_columns(q, 2.0)[polar],
            momentum,
            inverse[polar],
            inverse[(polar + 1) % 3],
            time,
        );
        return Ok(of_revolution_by_any_angle(
            q,
            Vector3::from_array(own_axis),
            angles,
        ));
    }
    let mut left = time;
    for _ in 0..MOST_PARTS {
        let omega = omega_of(q);
        let largest = omega.x.abs().max(omega.y.abs()).max(omega.z.abs());
        if largest * left <= LARGEST_EXPANDED_TURN {
            return Ok(of_three_moments(q, omega, ratios, left));
        }
        let part = LARGEST_EXPANDED_TURN / largest;
        q = of_three_moments(q, omega, ratios, part);
        left -= part;
    }
    Err(Refusal::Rotation)
}
