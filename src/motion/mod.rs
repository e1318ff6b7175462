// SPDX-License-Identifier: MIT OR Apache-2.0
//! The motion of rigid ellipsoids under given forces: velocity Verlet, with the free rotation solved exactly
//! (docs/theory.md, section 8).

mod free_rotation;
mod mean_rotation;
mod velocity_verlet;

pub use mean_rotation::mean_angular_velocity;
pub use velocity_verlet::{
    angular_velocities, finish_step, start_step, Bodies, BodyArrays, Extrapolation, MotionError,
    Selection,
};
#[doc(hidden)]
pub use velocity_verlet::{finish_step_of_body, start_step_of_body, Refusal};
