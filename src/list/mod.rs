// SPDX-License-Identifier: MIT OR Apache-2.0
//! A whole neighbour list in one call: an engine's arrays, the pairs that may touch, their contacts in lanes, and the scatter.

pub mod arrays;
mod batch;
mod batches;
mod candidates;
pub mod contact_records;
mod lane_pass;
mod memory;
pub mod neighbour_list;
mod preparation;
mod records;
pub mod rows;
mod scalar_pass;
pub(crate) mod shapes;
mod step_sums;
pub mod workspace;

pub use arrays::{ParticleArrays, ParticleShapes, Rotation};
pub use contact_records::{ContactRecord, ContactRecords};
pub use neighbour_list::compute_pairs;
pub use records::ParticleRecords;
pub(crate) use records::Shapes;
pub use rows::{Accumulators, Entries, HaleBroke, ListError, NeighbourRow, NeighbourRows};
pub use step_sums::add_pairs_to_step_sums;
pub use workspace::{PreparedBy, Workspace};
