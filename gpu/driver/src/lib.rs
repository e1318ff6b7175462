// SPDX-License-Identifier: MIT OR Apache-2.0
//! The kernels of `gpu/` on a device of NVIDIA: a scene of device pointers, kept from step to step.
//!
//! - [`driver_library`]: the driver's functions, loaded when a device is asked for.
//! - [`device`]: a device with the module of all kernels on it, and its memory.
//! - [`entries`]: which kernel serves which shapes and laws.
//! - [`scene`]: what a scene holds on the device, and what is started in a step.
//! - [`wall_histories`]: what is remembered of walls, as the host keeps it.
//! - [`arrays`]: the structs of the C interface.
//! - [`c_api`]: everything `extern "C"`.
//!
//! `unsafe` is in [`c_api`], towards the caller, and in [`driver_library`], towards the driver.

#![allow(rustdoc::broken_intra_doc_links)]

pub mod arrays;
pub mod c_api;
pub mod device;
pub mod driver_library;
pub mod entries;
pub mod scene;
pub mod status;
pub mod wall_histories;
