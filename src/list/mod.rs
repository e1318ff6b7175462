// SPDX-License-Identifier: MIT OR Apache-2.0
//! Geometry and force brought together: one contact, a whole neighbour list, plane walls; the history of a contact.

mod batch;
mod batches;
mod candidates;
pub mod contact;
pub mod contact_record;
pub mod history;
pub mod instruction_set;
mod lane_pass;
pub mod lanes;
pub mod laws;
pub mod neighbour_list;
pub mod one_contact;
pub mod particles;
pub mod planes;
mod preparation;
pub mod ranges;
pub mod registers;
mod shapes;
pub mod stability;
pub mod staged;
pub mod tallies;
pub mod without_history;

pub use contact::{Contact, ContactForces};
pub use contact_record::{ContactRecord, ContactRecords};
pub use history::HistoryLayout;
pub use instruction_set::InstructionSet;
pub use laws::Laws;
pub use neighbour_list::{compute_pairs, ListError, NeighbourRow, NeighbourRows};
pub use one_contact::{one_contact, one_contact_with_plane, Body, OneContact};
pub use particles::{ParticleArrays, ParticleError, Workspace};
pub use planes::{compute_planes, MovingPlane};
pub use tallies::Tallies;

/// Time step and whether the history is advanced.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Time step, the interval over which the velocities moved the bodies to where they are.
    pub time_step: f64,
    /// False in the set-up of a run: forces from the history as it stands.
    pub advance_history: bool,
}
