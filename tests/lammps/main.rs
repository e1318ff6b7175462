// SPDX-License-Identifier: MIT OR Apache-2.0
//! What must hold through a real LAMMPS. One question per file.
//!
//! `cargo xtask test` builds LAMMPS and the plugin and names them in the environment; see `harness`.
//! Tests whose name begins with `both_versions_` use nothing that LAMMPS 4 Feb 2025 lacks and are run against it too.
//! Those in `kokkos` and `styles_for_a_gpu` need a LAMMPS with its KOKKOS package as well, and are run apart.

#[path = "../support/engines/mod.rs"]
mod engines;
mod harness;
#[path = "../support/hills.rs"]
mod hills;

use engines::shapes;

mod accelerating_walls;
mod after_reading;
mod changing_box;
mod closed_forms;
mod conservation;
mod contact_or_not;
mod curved_walls;
mod decks;
mod decomposition;
mod deep_in_solids;
mod deleted_grains;
mod energy_balance;
mod energy_compute;
mod engine_commands;
mod golden_pairs;
mod grain_outputs;
mod granular_suite;
mod grown_and_moved;
mod insertion;
mod insertion_errors;
mod kokkos;
mod linear_spring;
mod mesh_sliding;
mod mesh_walls;
mod misuse;
mod moving_walls;
mod normal_motion;
mod nve_ellipsoid;
mod other_builds;
mod other_laws;
mod outputs;
mod packings;
mod pages;
mod partial_slip;
mod plane_motion;
mod plugin_file;
mod readme;
mod refusal;
mod region_walls;
mod restart;
mod restart_files;
mod rolling_and_twisting;
mod servo_walls;
mod set_up;
mod size_ratio;
mod spheres;
mod stored_collision;
mod styles_for_a_gpu;
mod tangential_force;
mod tangential_motion;
mod time_step;
mod too_new;
mod velocities_in_company;
mod velocities_of_the_step;
mod wall_contacts;
mod wall_material;
mod wall_stress_files;
