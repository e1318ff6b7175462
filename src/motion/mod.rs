// SPDX-License-Identifier: MIT OR Apache-2.0
//! The motion of rigid ellipsoids under given forces: velocity Verlet, with the free rotation solved exactly
//! (docs/theory.md, section 8).

mod bodies;
mod body_blocks;
mod free_rotation;
mod mean_rotation;
mod one_body;
mod velocity_verlet;

#[doc(hidden)]
pub use bodies::Refusal;
pub use bodies::{Bodies, BodyArrays, Extrapolation, MotionError, Selection};
pub use mean_rotation::mean_angular_velocity;
#[doc(hidden)]
pub use one_body::{finish_step_of_body, start_step_of_body};
pub use velocity_verlet::{angular_velocities, finish_step, start_step};
