// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contact forces between viscoelastic ellipsoids: elliptical Hertz, the viscoelastic normal law NFD and the
//! frictional tangential law TFD, from material constants, for discrete element codes.
//!
//! Any consistent system of units. World frame throughout; quaternions are `(w, x, y, z)` and turn body axes into
//! world axes; the contact normal points from body `i` to body `j`; the force on `j` is `+F n`.
//!
//! - [`geometry`]: bodies by their support function, the contact search, curvature. No force.
//! - [`force`]: material constants to laws; laws to force. No search.
//! - [`contact`]: one contact, with its history.
//! - [`list`]: a whole neighbour list in one call, in vector registers ([`simd`]).
//! - [`walls`]: rigid walls of any shape, in motion, against all particles.
//! - [`motion`]: velocity Verlet for rigid ellipsoids, with the free rotation solved exactly.
//! - [`tallies`]: energies, dissipation and virial of a call.
//! - [`c_api`]: everything `extern "C"`.

//!
//! The feature `std` is on by default. Without it the library has no list, no walls with triangles and no C interface: what is left, one
//! contact, one particle at the surfaces of a wall and the motion of one body, is what a device takes from it (`gpu/` in the repository).

#![cfg_attr(not(feature = "std"), no_std)]
#![cfg_attr(
    target_arch = "nvptx64",
    feature(core_float_math, link_llvm_intrinsics)
)]
// Some of what is left is for lists, walls and engines alone.
#![cfg_attr(not(feature = "std"), allow(dead_code, unused_imports, unused_macros))]
#![deny(unsafe_code)]

#[cfg(not(feature = "std"))]
#[macro_use]
extern crate alloc;

#[cfg(feature = "std")]
pub mod c_api;
pub mod contact;
pub mod force;
pub mod geometry;
#[cfg(feature = "std")]
pub mod list;
mod message;
pub mod motion;
pub mod real;
pub mod simd;
#[cfg(feature = "std")]
pub mod tallies;
pub mod vector;
pub mod walls;

/// The Rust snippets of the README are run as tests.
#[cfg(all(doctest, feature = "std"))]
#[doc = include_str!("../README.md")]
struct Readme;
