// SPDX-License-Identifier: MIT OR Apache-2.0
//! What must hold through a real LIGGGHTS. One question per file.
//!
//! ELLGRAN_TEST_LIGGGHTS names the patched binary (`cargo xtask path liggghts`), ELLGRAN_TEST_MPIRUN the launcher,
//! ELLGRAN_TEST_LIGGGHTS_SOURCE an untouched source tree and ELLGRAN_TEST_LIGGGHTS_VTK the headers of VTK. One test also runs LAMMPS, see
//! `tests/lammps`.

#[path = "../support/engines/mod.rs"]
mod engines;
mod harness;
#[path = "../support/hills.rs"]
mod hills;
#[allow(dead_code)]
#[path = "../lammps/harness.rs"]
mod lammps;
#[path = "../support/mod.rs"]
mod support;

use engines::shapes;

mod bounce;
mod closed_forms;
mod commands;
mod crowded;
mod cylinder;
mod data_files;
mod decomposition;
mod deleted_grains;
mod elastic_collision;
mod examples;
mod golden_pairs;
mod insertion;
mod installer;
mod kept_histories;
mod local_output;
mod make_auto;
mod many_triangles;
mod mesh_edges;
mod mesh_folds;
mod mesh_ranks;
mod meshes;
mod misuse;
mod moving_walls;
mod pages;
mod pair_loops;
mod replicated;
mod restart;
mod restart_files;
mod rolling;
mod same_motion;
mod servo;
mod spheres;
mod stored_collision;
mod stored_forces;
mod tilted_box;
mod time_step;
mod twins;
mod velocities_of_the_step;
mod vtk;
mod wall_calls;
mod wall_histories;
mod wall_outputs;
mod wall_shapes;
