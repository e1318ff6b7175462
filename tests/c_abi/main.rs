// SPDX-License-Identifier: MIT OR Apache-2.0
//! The C interface, called as C calls it.

#![allow(unsafe_code)]

mod dissipation;
#[path = "../support/emulator.rs"]
mod emulator;
mod engine_walls;
mod errors;
mod extreme_values;
mod friction;
mod growing;
mod instruction_sets;
mod kept_history;
mod list_changes;
mod lists;
mod many_contacts;
mod materials;
mod measures;
mod motion;
mod null_pointers;
mod paths;
mod recorded;
mod scene;
mod shapes;
mod stages;
mod threads;
mod unchanged;
