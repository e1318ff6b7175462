// SPDX-License-Identifier: MIT OR Apache-2.0
//! The C interface, called as C calls it.

#![allow(unsafe_code)]
// Each block is one call of the C interface with pointers to locals that outlive it; tests of invalid pointers say what they
// rely on.
#![allow(clippy::undocumented_unsafe_blocks)]

mod comparison;
mod dissipation;
#[path = "../support/emulator.rs"]
mod emulator;
mod engine_walls;
mod errors;
mod extreme_values;
mod flat_pieces;
#[allow(dead_code)]
#[path = "../support/shapes.rs"]
mod formulas;
mod friction;
mod growing;
#[path = "../support/hills.rs"]
mod hills;
mod instruction_sets;
mod kept_history;
mod list_changes;
mod lists;
mod many_contacts;
mod materials;
mod measures;
mod missing_images;
mod motion;
mod null_pointers;
mod paths;
mod planes_in_lanes;
mod prepared_by_pairs;
mod recorded;
mod scene;
mod shapes;
mod stable_step;
mod stages;
mod threads;
mod unchanged;
mod wall_planes;
