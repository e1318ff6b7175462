// SPDX-License-Identifier: MIT OR Apache-2.0
//! Properties that every contact law is held to, on random contacts; cases that once failed are kept in
//! `tests/proptest-regressions` and run first.

#[path = "../support/mod.rs"]
mod support;

mod attraction;
mod coulomb_limit;
mod curved_walls;
mod deepest_normal;
mod elastic_collision;
mod energy_gradient;
mod exchange_of_bodies;
mod extremes;
mod faceted_walls;
mod first_touch;
mod gap;
mod global_minimum;
mod lone_contacts;
mod mesh_corners;
mod mesh_divisions;
mod mesh_hanging_corners;
mod momentum;
mod near_walls;
mod passivity;
mod periodic_meshes;
mod preparation;
mod relabelling;
mod rigid_motion;
mod rolling_and_twisting;
mod round_edges;
mod round_solids;
mod slender;
mod spheres;
mod touching_or_not;
mod transported_history;
mod units;
mod walls_in_lanes;
mod warm_start;
