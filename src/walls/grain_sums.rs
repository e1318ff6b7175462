// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the contacts with a wall add to the sums of each particle.

use super::wall::Wall;
use crate::tallies::GrainSums;

impl Wall {
    /// Adds the contacts of the last call, if it recorded them, to the sums of their particles.
    pub fn add_to_grain_sums(&self, sums: &mut [GrainSums]) {
        for contact in self.contacts() {
            let of_particle = &mut sums[contact.particle];
            of_particle.wall_contacts += 1.0;
            of_particle.add(
                contact.normal,
                contact.forces.contact_point,
                -contact.forces.force,
            );
        }
    }
}
