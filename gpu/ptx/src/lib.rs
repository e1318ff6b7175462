// SPDX-License-Identifier: MIT OR Apache-2.0
//! The kernels as a device calls them: each entry takes arrays, and hands the part of this thread to a function of
//! `ellgran-kernels`. No formula is here, and `unsafe` is in `memory` alone.
//!
//! They are four modules, each made of one feature: `grains`, `walls`, `meshes` for walls with triangles, and `tallies` for energies and virial.

#![no_std]
#![feature(abi_ptx, stdarch_nvptx)]

extern crate alloc;

#[cfg(feature = "grains")]
mod entries;
// Each module of kernels needs a part of it.
#[allow(dead_code)]
mod memory;
#[cfg(feature = "meshes")]
mod mesh_entries;
// As `memory`.
#[allow(dead_code)]
mod scene;
#[cfg(feature = "tallies")]
mod tally_entries;
#[cfg(feature = "walls")]
mod wall_entries;
