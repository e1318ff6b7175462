// SPDX-License-Identifier: MIT OR Apache-2.0
//! The numbers of the theory, each by name, held against the core.

// The numbers stand as the theory prints them.
#![allow(clippy::excessive_precision)]

#[path = "../support/mod.rs"]
mod support;

mod closures;
mod compliance;
mod critical_step;
mod factor_fit;
mod free_rotation;
#[cfg(reference_pairs)]
mod golden_pairs;
mod hale;
mod hertz_collision;
mod hertz_factors;
mod integrate;
mod law_kinds;
mod memory;
mod mixing;
mod oblique_loading;
mod partial_slip;
mod principal_curvatures;
mod relative_curvature;
mod restitution;
mod rolling_and_twisting;
mod sphere_on_plane;
mod spring_bed;
mod stable_step;
mod tangential_energy;
mod tangential_rebound;
mod twisting_bed;
mod velocities_of_the_step;
