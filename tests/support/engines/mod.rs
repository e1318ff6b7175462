// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the tests through LAMMPS and through LIGGGHTS share: scenes, runs, and what they wrote.

// Each test target takes what it needs.
#![allow(dead_code)]

pub mod closed_forms;
pub mod curved_walls;
#[path = "../dump.rs"]
pub mod dump;
pub mod frames;
pub mod pressed;
pub mod printed;
pub mod process;
pub mod restart_files;
pub mod scene;
#[path = "../shapes.rs"]
pub mod shapes;
pub mod stored_collision;
