// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contact forces between viscoelastic ellipsoids: elliptical Hertz, the viscoelastic normal law NFD and the
//! frictional tangential law TFD, from material constants, for discrete element codes.
//!
//! Any consistent system of units. World frame throughout; quaternions are `(w, x, y, z)` and turn body axes into
//! world axes; the contact normal points from body `i` to body `j`; the force on `j` is `+F n`.
//!
//! Data flows one way: [`c_api`] -> [`pairs`] -> [`geometry`] -> [`force`] and back.
//!
//! - [`geometry`]: bodies by their support function, the contact search, curvature. No force.
//! - [`force`]: material constants to laws; laws to force. No search.
//! - [`pairs`]: one contact, a neighbour list, plane walls; history.
//! - [`walls`]: rigid walls of any shape, in motion, against all particles.
//! - [`c_api`]: everything `extern "C"`.

#![deny(unsafe_code)]
#![warn(missing_docs)]

pub mod c_api;
pub mod force;
pub mod geometry;
mod message;
pub mod pairs;
pub mod real;
pub mod walls;

/// The Rust snippets of the README are run as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
