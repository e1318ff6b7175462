// SPDX-License-Identifier: MIT OR Apache-2.0
//! What each thread of a GPU does: plain functions of an index, of numbers that all threads read, and of those that this one
//! alone writes. They hold no formula of their own: geometry, law and motion are the library's.
//!
//! A host runs them index by index (`tests/`), a device through the entries in `gpu/ptx`.
//!
//! - [`preparation`]: an engine's arrays become [`Grain`](shapes::Grain)s.
//! - [`candidates`]: the pairs that may touch before a grain has moved by half of a margin, each of them once.
//! - [`contacts`]: force and torques of one of them, and its history.
//! - [`mixed`]: the same with the search in single precision.
//! - [`terms`]: which contacts add to the load of a grain, and their sum.
//! - [`tallies`]: energies and virial of the same contacts.
//! - [`planes`]: the same of one grain's contact with a plane.
//! - [`walls`]: the same of its contacts with a wall of planes, cylinders, cones and spheres.
//! - [`meshes`]: the same with a wall of which parts are triangles.
//! - [`integration`]: the two halves of a step of velocity Verlet.
//! - [`poses`]: has a grain moved too far for the present candidates.
//! - [`pair_memory`]: histories go from one neighbour list to the next.
//! - [`arguments`]: what each entry is called with.
//!
//! Each pair is computed once, by one thread, and each grain then sums the loads of its contacts: no sum needs an atomic operation, and
//! its order is that of the neighbours, the same in every run. The grain with the lower identifier is the first of a pair, as on
//! the host.

#![cfg_attr(not(test), no_std)]
#![cfg_attr(target_arch = "nvptx64", feature(core_float_math))]

#[cfg(target_arch = "nvptx64")]
extern crate ellgran_core as ellgran;

pub mod arguments;
pub mod candidates;
pub mod contacts;
pub mod integration;
pub mod meshes;
pub mod mixed;
pub mod one_lane;
pub mod one_single;
pub mod pair_memory;
pub mod planes;
pub mod poses;
pub mod preparation;
pub mod shapes;
pub mod tallies;
pub mod terms;
pub mod walls;
