// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the contacts with a wall add to the bound of the stable step of the particles.

use super::wall::Wall;
use crate::contact::pair::HaleRatio;
use crate::contact::stable_step::{ContactExtremes, StepContact, StepSums};
use crate::contact::{Laws, Particle};

/// The masses of a particle at a wall.
#[derive(Clone, Copy, Debug)]
pub struct WallMasses {
    /// Inverse of that of its inertia, 0 for a fixed particle.
    pub inverse_mass: f64,
    /// That which the law reads, 0 for a fixed particle.
    pub effective_mass: f64,
}

impl Wall {
    /// Adds the contacts that were found last ([`Wall::find_contacts`], in the frame of the world) to the sums of their particles.
    /// `near` are the particles of that call, `wall_type` gives the type of the wall at a contact, by its number. Of faces that share a
    /// contact each counts with its share.
    ///
    /// # Errors
    /// With `factors hale`: the particle and the ratio, before anything is added.
    #[allow(clippy::too_many_arguments)]
    pub fn add_to_step_sums(
        &self,
        laws: &Laws,
        near: &[Particle],
        wall_type: &dyn Fn(usize) -> usize,
        masses: &dyn Fn(usize) -> WallMasses,
        identifier: &dyn Fn(usize) -> i64,
        sums: &mut [StepSums],
        extremes: &mut ContactExtremes,
    ) -> Result<(), (usize, f64)> {
        let all = self.found().all();
        let staged = self.found().staged();
        let look = |number: usize| {
            let c = &all[number];
            let i = &near[c.near];
            let m = masses(c.particle);
            StepContact::of_wall(
                laws.get(i.particle_type as usize, wall_type(number)),
                i,
                &staged[number].contact,
                m.inverse_mass,
                m.effective_mass,
            )
            .map_err(|HaleRatio(ratio)| (c.particle, ratio))
        };
        if laws.features().hale {
            for number in 0..staged.len() {
                look(number)?;
            }
        }
        for (number, c) in all.iter().enumerate().take(staged.len()) {
            let contact = look(number)?;
            contact.add_to_first(&mut sums[c.particle]);
            let types = [near[c.near].particle_type as usize, wall_type(number)];
            extremes.add(&contact, [identifier(c.particle), 0], types);
        }
        Ok(())
    }
}
