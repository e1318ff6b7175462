// SPDX-License-Identifier: MIT OR Apache-2.0
//! A library that has the functions of NVIDIA's driver that `gpu/driver` calls, and no GPU: for tests.
//!
//! It is as strict as a device, and stricter where a mistake would go unnoticed there:
//! - addresses of its memory are none of the host's: whoever follows one on the host ends at once;
//! - new memory is full of ones, which are no number;
//! - an address that a kernel, a copy or a fill is given must lie within one allocation, with all its elements;
//! - a kernel of the module must have the parameters that the compiler for the device has found, in size and alignment;
//! - kernels run when they are started, thread by thread, in rising and in falling order by turns;
//! - a kernel that panics, or leaves the memory, ends as one on a device, and all that follows fails.
//!
//! What it refuses, environment variables say: `src/settings.rs`.

// The kernels' own text, with the memory of this host.
#[path = "../../ptx/src/entries.rs"]
mod entries;
mod functions;
mod memory;
#[path = "../../ptx/src/mesh_entries.rs"]
mod mesh_entries;
mod modules;
#[path = "../../ptx/src/scene.rs"]
mod scene;
mod settings;
mod tally;
#[path = "../../ptx/src/tally_entries.rs"]
mod tally_entries;
#[path = "../../ptx/src/wall_entries.rs"]
mod wall_entries;
