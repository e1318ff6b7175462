// SPDX-License-Identifier: MIT OR Apache-2.0
//! An engine's bodies: their arrays, which of them move, and why one cannot be moved.

use crate::geometry::ellipsoid::{LARGEST_SEMI_AXIS, LEAST_SEMI_AXIS};
use crate::message::Number;
#[cfg(not(feature = "std"))]
use alloc::string::String;

/// Shapes and attitudes of an engine's bodies.
pub trait Bodies {
    /// Semi-axes and quaternion `(w, x, y, z)`, body to world; `None` for what is no ellipsoid.
    fn shape(&self, k: usize) -> Option<([f64; 3], [f64; 4])>;
    /// Numbers that are read for it, the first and the last, where they are known without being read. An engine that sorts its bodies leaves
    /// shapes where they are: they are read in no order that a processor foresees.
    #[cfg(feature = "std")]
    #[inline(always)]
    fn place(&self, _: usize) -> Option<[&f64; 2]> {
        None
    }
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

/// An acceleration has turned against the one before where their product is below minus this part of the sum of their squares. Where one
/// of the two is nothing but rounding, as the torque of a contact of a smooth sphere, its sign is chance, and decides nothing.
pub(super) const REVERSAL: f64 = 1e-8;

/// What takes velocities and angular momenta from the half step to the end of the step, where the next forces are computed:
/// from the present accelerations `a` and `a'` of the step before, half a step of `a + r (a - a')` with `r` the ratio of this
/// step to that one; nothing where `a` has turned against `a'` by more than rounding.
///
/// The forces then depend on velocities that are right to the second order, and the step stays explicit. The velocities
/// with which the bodies move, and without such forces the motion itself, are those of velocity Verlet. An overdamped mode
/// that the extrapolation would let grow (damping coefficient over mass times step above 1/2) changes the sign of its
/// acceleration in each step: there the velocities of the half step serve, so that the step may be as large as with these
/// (docs/theory.md, section 8).
pub struct Extrapolation<'a> {
    /// Written by [`start_step`](super::start_step): what velocities and angular momenta have more than those of the half
    /// step; by [`finish_step`](super::finish_step): what those that the forces were computed with had more than those of
    /// the end of the step.
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
    pub(super) fn takes(&self, k: usize) -> bool {
        self.groups
            .get(k)
            .is_none_or(|group| group & self.bits != 0)
    }

    /// Bits of the bodies from `first` on that it takes.
    #[inline(always)]
    pub(super) fn lanes(&self, first: usize, count: usize) -> u32 {
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

    pub(super) fn of_body(self, body: usize) -> MotionError {
        MotionError {
            body,
            what: self.describe(),
        }
    }
}

impl<B: Bodies> BodyArrays<'_, B> {
    /// Cuts the arrays to the length of the first, so that one test of an index serves all of them.
    #[inline(always)]
    pub(super) fn same_length(&mut self) -> usize {
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
