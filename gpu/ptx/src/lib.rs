// SPDX-License-Identifier: MIT OR Apache-2.0
//! The kernels as a device calls them: each entry takes arrays, and hands the part of this thread to a function of
//! `ellgran-kernels`. No formula is here, and `unsafe` is in `memory` alone.

#![no_std]
#![feature(abi_ptx, stdarch_nvptx)]

extern crate alloc;

mod entries;
mod memory;
