// SPDX-License-Identifier: MIT OR Apache-2.0
//! What C, C++, CMake and pkg-config projects see of an installed library: they are built and run.

#[path = "../support/emulator.rs"]
mod emulator;
mod examples;
mod harness;
mod layout;
mod packages;
#[path = "../support/pages.rs"]
mod pages;
// The library for GPUs is installed by the tests of gpu/driver.
#[allow(dead_code)]
#[path = "../../xtask/src/install/prefix.rs"]
mod prefix;
mod sanitizer;
mod shared;
#[path = "../../examples/rust/two_grains.rs"]
mod two_grains;
