// SPDX-License-Identifier: MIT OR Apache-2.0
//! The two halves of a step of velocity Verlet for one grain, as `fix nve/ellipsoid` takes them.

use crate::contacts::Load;
use ellgran::motion::{
    finish_step_of_body, start_step_of_body, Bodies, BodyArrays, Extrapolation, Refusal,
};

/// The numbers of one grain that motion reads and writes; world frame.
#[derive(Debug)]
pub struct Moving<'a> {
    /// Centre.
    pub position: &'a mut [f64; 3],
    /// Velocity.
    pub velocity: &'a mut [f64; 3],
    /// Angular momentum of a solid ellipsoid about its centre.
    pub angular_momentum: &'a mut [f64; 3],
    /// Quaternion `(w, x, y, z)`, body to world.
    pub quaternion: &'a mut [f64; 4],
    /// Semi-axes.
    pub semi_axes: [f64; 3],
    /// Mass.
    pub mass: f64,
    /// Force and torque.
    pub load: Load,
    /// Where velocities are extrapolated to the step: what they have more, the load of the step before, and this step over the one
    /// before.
    pub extrapolation: Option<(&'a mut [f64; 6], &'a mut [f64; 6], f64)>,
}

struct OneBody<'a> {
    semi_axes: [f64; 3],
    quaternion: &'a mut [f64; 4],
}

impl Bodies for OneBody<'_> {
    #[inline(always)]
    fn shape(&self, _: usize) -> Option<([f64; 3], [f64; 4])> {
        Some((self.semi_axes, *self.quaternion))
    }
    #[inline(always)]
    fn turn(&mut self, _: usize, quaternion: [f64; 4]) {
        *self.quaternion = quaternion;
    }
}

/// Calls a function with the arrays of this one body.
#[inline(always)]
fn with_arrays<R>(grain: Moving<'_>, act: impl FnOnce(&mut BodyArrays<'_, OneBody<'_>>) -> R) -> R {
    use core::slice::{from_mut, from_ref};
    let (force, torque) = (grain.load.force.to_array(), grain.load.torque.to_array());
    act(&mut BodyArrays {
        positions: from_mut(grain.position),
        velocities: from_mut(grain.velocity),
        angular_momenta: from_mut(grain.angular_momentum),
        forces: from_ref(&force),
        torques: from_ref(&torque),
        masses: from_ref(&grain.mass),
        bodies: OneBody {
            semi_axes: grain.semi_axes,
            quaternion: grain.quaternion,
        },
        extrapolation: grain
            .extrapolation
            .map(|(changes, loads_before, step_ratio)| Extrapolation {
                changes: from_mut(changes),
                loads_before: from_mut(loads_before),
                step_ratio,
            }),
    })
}

/// Half a kick, then the way of a whole step: [`ellgran::motion::start_step`].
///
/// # Errors
/// What is wrong with the body.
#[inline(always)]
pub fn start_step_of_grain(grain: Moving<'_>, time_step: f64) -> Result<(), Refusal> {
    with_arrays(grain, |arrays| start_step_of_body(arrays, 0, time_step))
}

/// The other half of the kick: [`ellgran::motion::finish_step`].
#[inline(always)]
pub fn finish_step_of_grain(grain: Moving<'_>, time_step: f64) {
    with_arrays(grain, |arrays| finish_step_of_body(arrays, 0, time_step));
}
