// SPDX-License-Identifier: MIT OR Apache-2.0
//! A step of velocity Verlet for an engine's ellipsoids, in lanes: half a kick and the way in [`start_step`], the other half of
//! the kick, once the new forces are known, in [`finish_step`].
//!
//! Symplectic and reversible: the kicks and the free motion are each solved exactly.

use super::bodies::{Bodies, BodyArrays, MotionError, Selection};
use super::body_blocks::{Kick, Spin, Turn};
use crate::simd::InstructionSet;

/// Half a kick, then the way of a whole step: velocities and angular momenta become those of the half step (or, with an
/// [`super::Extrapolation`], of its end), positions and quaternions those of the end of the step. Quaternions come out with length 1.
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
/// [`super::Extrapolation`], on those that [`start_step`] left).
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
