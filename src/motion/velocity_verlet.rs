// SPDX-License-Identifier: MIT OR Apache-2.0
//! A step of velocity Verlet for an engine's ellipsoids, in lanes: half a kick and the way in [`start_step`], the other half of
//! the kick, once the new forces are known, in [`finish_step`].
//!
//! Symplectic and reversible: the kicks and the free motion are each solved exactly.

use super::free_rotation::{
    body_velocity, half_angles, of_a_sphere, of_revolution, of_revolution_by_any_angle,
    of_three_moments, Quaternion, LARGEST_EXPANDED_TURN, LARGEST_HALF_ANGLE,
};
use crate::geometry::ellipsoid::{rotation_columns, LARGEST_SEMI_AXIS, LEAST_SEMI_AXIS};
use crate::message::Number;
#[cfg(not(feature = "std"))]
use crate::real::Functions;
use crate::real::Real;
use crate::simd::{
    components, double_components, first_numbers, lines, put, put_components,
    put_double_components, InstructionSet, Lanes, Line, Registers, Stage, MOST_LANES,
};
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
/// from the present accelerations `a` and `a'` of the step before, half a step of `a + r (a - a')` with `r` the ratio of this
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
    /// Forces and torques of the step before; overwritten by the present ones. Not known where the first is infinite: the
    /// present ones then stand for them, which is right for what moves freely before it touches.
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

    /// Bits of the bodies from `first` on that it takes.
    #[inline(always)]
    fn lanes(&self, first: usize, count: usize) -> u32 {
        if self.groups.is_empty() {
            return (1 << count) - 1;
        }
        let mut bits = 0;
        for lane in 0..count {
            bits |= u32::from(self.takes(first + lane)) << lane;
        }
        bits
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
/// let set = InstructionSet::choose()?;
/// start_step(set, &mut grain, all, 1.0).expect("it can be moved");
/// finish_step(set, &mut grain, all, 1.0);
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

/// The other half of the kick, with the forces of the end of the step, on the velocities of the half step (or, with an
/// [`Extrapolation`], on those that [`start_step`] left).
pub fn finish_step<B: Bodies>(
    set: InstructionSet,
    arrays: &mut BodyArrays<'_, B>,
    selection: Selection<'_>,
    time_step: f64,
) {
    arrays.same_length();
    let kick = Kick {
        arrays,
        selection,
        time: 0.5 * time_step,
    };
    if set == InstructionSet::Scalar {
        kick.one_by_one();
    } else {
        set.run(kick);
    }
}

/// [`finish_step`] of one body. Public for the kernels in `gpu/`; no interface for others.
#[doc(hidden)]
#[inline(always)]
pub fn finish_step_of_body<B: Bodies>(arrays: &mut BodyArrays<'_, B>, k: usize, time_step: f64) {
    if arrays.extrapolation.is_some() {
        kick_from_extrapolated(arrays, k, 0.5 * time_step);
    } else {
        kick(arrays, k, 0.5 * time_step);
    }
}

/// The angular velocities, world frame, that go with the present angular momenta and attitudes, of the bodies that move; the
/// others' are left as they are.
///
/// # Errors
/// The first body that is no ellipsoid, whose quaternion has no length, or whose semi-axes or mass are out of range.
///
/// # Example
/// ```
/// use ellgran::motion::{angular_velocities, finish_step, start_step, Bodies, BodyArrays, Extrapolation, Selection};
/// use ellgran::simd::InstructionSet;
///
/// struct Disc([f64; 4]);
/// impl Bodies for Disc {
///     fn shape(&self, _: usize) -> Option<([f64; 3], [f64; 4])> {
///         Some(([1.0, 1.0, 0.5], self.0))
///     }
///     fn turn(&mut self, _: usize, quaternion: [f64; 4]) {
///         self.0 = quaternion;
///     }
/// }
///
/// // A disc of 5 kg falls at 10 m/s^2 and spins at 3 rad/s about its axis: moment of inertia m (a^2 + b^2)/5 = 2.
/// let (mut changes, mut loads_before) = ([[0.0; 6]], [[f64::INFINITY; 6]]);
/// let mut disc = BodyArrays {
///     positions: &mut [[0.0; 3]],
///     velocities: &mut [[0.0; 3]],
///     angular_momenta: &mut [[0.0, 0.0, 6.0]],
///     forces: &[[0.0, 0.0, -50.0]],
///     torques: &[[0.0; 3]],
///     masses: &[5.0],
///     bodies: Disc([1.0, 0.0, 0.0, 0.0]),
///     extrapolation: Some(Extrapolation {
///         changes: &mut changes,
///         loads_before: &mut loads_before,
///         step_ratio: 1.0,
///     }),
/// };
/// let (all, set) = (Selection { groups: &[], bits: 0 }, InstructionSet::choose()?);
/// let mut spins = [[0.0; 3]];
/// angular_velocities(set, &mut disc, all, &mut spins).expect("an ellipsoid");
/// assert!((spins[0][2] - 3.0).abs() < 1e-15);
/// // The velocity that forces see is that of the end of the step: 0.1 s, 1 m/s.
/// start_step(set, &mut disc, all, 0.1).expect("it can be moved");
/// assert!((disc.velocities[0][2] + 1.0).abs() < 1e-15);
/// finish_step(set, &mut disc, all, 0.1);
/// assert!((disc.velocities[0][2] + 1.0).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn angular_velocities<B: Bodies>(
    set: InstructionSet,
    arrays: &mut BodyArrays<'_, B>,
    selection: Selection<'_>,
    found: &mut [[f64; 3]],
) -> Result<(), MotionError> {
    let n = arrays.same_length();
    let mut outcome = Ok(());
    let spin = Spin {
        arrays,
        selection,
        found: &mut found[..n],
        outcome: &mut outcome,
    };
    if set == InstructionSet::Scalar {
        spin.one_by_one();
    } else {
        set.run(spin);
    }
    outcome
}

/// The angular velocity of one body.
fn angular_velocity<B: Bodies>(arrays: &BodyArrays<'_, B>, k: usize) -> Result<[f64; 3], Refusal> {
    let (semi_axes, q) = arrays.bodies.shape(k).ok_or(Refusal::Shape)?;
    let square: f64 = q.iter().map(|x| x * x).sum();
    // Those of `start_step` are.
    let q = if (square - 1.0).abs() < UNIT {
        q
    } else {
        normalised(q)?
    };
    let mass = checked_mass(arrays.masses[k])?;
    check_shape(semi_axes)?;
    let axes = rotation_columns(q, 2.0);
    let momentum = Vector3::from_array(arrays.angular_momenta[k]);
    let own = body_velocity(axes, momentum, moments(mass, semi_axes).0);
    Ok((axes[0] * own.x + axes[1] * own.y + axes[2] * own.z).to_array())
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

impl<B: Bodies> Turn<'_, '_, B> {
    fn one_by_one(mut self) {
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

/// See [`angular_velocities`].
struct Spin<'p, 'a, B: Bodies> {
    arrays: &'p BodyArrays<'a, B>,
    selection: Selection<'p>,
    found: &'p mut [[f64; 3]],
    outcome: &'p mut Result<(), MotionError>,
}

impl<B: Bodies> Spin<'_, '_, B> {
    fn one_by_one(mut self) {
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

/// [`extrapolate`] of a block; `factors` are half the time over the masses, and half the time.
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
        let steady = Lanes::select(loads[k].dot(before[k]).less(zero), zero, factors[k]);
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

/// See [`finish_step`].
struct Kick<'p, 'a, B: Bodies> {
    arrays: &'p mut BodyArrays<'a, B>,
    selection: Selection<'p>,
    /// Half the time step.
    time: f64,
}

impl<B: Bodies> Kick<'_, '_, B> {
    fn one_by_one(self) {
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
