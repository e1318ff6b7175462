// SPDX-License-Identifier: MIT OR Apache-2.0
//! One contact: geometry and motion in; force, torques and what is to be remembered out.

pub(crate) mod couple;
pub mod forces;
pub mod history;
#[cfg(feature = "std")]
pub(crate) mod lane_law;
// Public for the kernels in `gpu/`; no interface for others.
#[doc(hidden)]
pub mod lane_search;
pub mod laws;
pub mod one_contact;
pub mod pair;
pub mod particle;
pub mod ranges;
#[cfg(feature = "std")]
pub mod stability;
#[cfg(feature = "std")]
pub mod stable_step;
pub mod staged;
mod turning_normal;
#[cfg(feature = "std")]
pub(crate) mod vectors_in_lanes;
#[cfg(feature = "std")]
pub(crate) mod wall_batch;
#[cfg(feature = "std")]
pub mod without_history;

pub use forces::{Contact, ContactForces, MotionChange};
pub use history::{HistoryLayout, Step};
pub use laws::Laws;
pub use one_contact::{one_contact, OneContact};
pub use particle::{prepare_body, Body, Particle, ParticleError};
