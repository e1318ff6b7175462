// SPDX-License-Identifier: MIT OR Apache-2.0
//! One particle against the surfaces of a wall, with no memory but that of its contacts: what a thread of a device does.

use super::contact_history::{effective_mass, recalled, write_history};
use super::histories::WallHistoryLayout;
use super::motion::Motion;
use super::parts::{LentRoom, Part, Parts};
use super::shape::Grain;
use super::surface::Surface;
use super::touched::{Found, Touched, NO_CONTACT};
use super::triangle_contacts::surface as surface_of;
use crate::contact::staged::{StagedContact, StagedHistory};
use crate::contact::{HistoryLayout, Particle, Step};
use crate::force::PairLaw;
use crate::vector::Vector3;

/// Contacts of one particle with one wall without triangles, at most.
#[doc(hidden)]
pub const MOST_CONTACTS: usize = 8;

#[doc(hidden)]
pub use super::touched::LONGEST_HISTORY;

/// A wall as a particle meets it in a step.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct WallInMotion<'a> {
    /// Where it is and how it moves.
    pub motion: &'a Motion,
    /// How the histories of a particle are laid out.
    pub layout: WallHistoryLayout,
    /// How that of one contact is, by the laws.
    pub of_laws: HistoryLayout,
    /// The step.
    pub step: Step,
}

/// What a wall does to a particle.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParticleLoad {
    /// Force on the particle, world frame.
    pub force: Vector3,
    /// Torque about its centre.
    pub torque: Vector3,
    /// How many contacts are remembered as such; 0 where the particle does not touch.
    pub contacts: usize,
}

/// There are more contacts, or more triangles, than there is room for.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLittleRoom;

impl WallInMotion<'_> {
    /// Forgets the contacts of a particle that touches no more.
    #[doc(hidden)]
    pub fn forget(&self, histories: &mut [f64]) {
        let used = self.layout.used(histories);
        histories[..used].fill(0.0);
    }

    /// The load of a particle by surfaces, under a law without Hale's factors, without springs, memories and resistance to rolling and
    /// twisting. `histories` are the particle's own.
    ///
    /// # Errors
    /// Too many contacts. Nothing is written then.
    #[doc(hidden)]
    pub fn load_by_surfaces(
        &self,
        surfaces: &[Surface],
        law: &PairLaw,
        i: &Particle,
        histories: &mut [f64],
    ) -> Result<ParticleLoad, TooLittleRoom> {
        let (mut all, mut taken) = ([NO_CONTACT; MOST_CONTACTS], [false; MOST_CONTACTS]);
        let search = |grain: &Grain<'_>, found: &mut Found<'_>| {
            let ball = grain.ball();
            for (part, surface) in surfaces.iter().enumerate() {
                if surface.is_near(&ball) {
                    found.on_surface(part, surface, grain);
                }
            }
            true
        };
        self.load(law, i, (&mut all, &mut taken), search, histories)
    }

    /// The same by parts of which some are triangles.
    ///
    /// # Errors
    /// Too many triangles or contacts for the room. Nothing is written then.
    #[doc(hidden)]
    pub fn load_by_parts(
        &self,
        parts: &Parts<'_>,
        law: &PairLaw,
        i: &Particle,
        room: LentRoom<'_>,
        histories: &mut [f64],
    ) -> Result<ParticleLoad, TooLittleRoom> {
        let LentRoom {
            mut search,
            contacts,
            taken,
        } = room;
        let search = |grain: &Grain<'_>, found: &mut Found<'_>| {
            let ball = grain.ball();
            for (part, shape) in parts.parts.iter().enumerate() {
                match shape {
                    Part::Surface(surface) => {
                        if surface.is_near(&ball) {
                            found.on_surface(part, surface, grain);
                        }
                    }
                    Part::Triangles(of, nodes) => {
                        for contact in search.touch(parts, (of, nodes), grain) {
                            found.add(part, &surface_of(contact));
                        }
                    }
                }
            }
            !search.lacks_room()
        };
        self.load(law, i, (contacts, taken), search, histories)
    }

    /// `search` finds the contacts of a body, and tells whether these are all.
    #[inline(always)]
    fn load(
        &self,
        law: &PairLaw,
        i: &Particle,
        (all, taken): (&mut [Touched], &mut [bool]),
        search: impl FnOnce(&Grain<'_>, &mut Found<'_>) -> bool,
        histories: &mut [f64],
    ) -> Result<ParticleLoad, TooLittleRoom> {
        let WallInMotion {
            motion,
            layout,
            of_laws,
            ..
        } = self;
        let seen = if motion.is_none() {
            *i
        } else {
            motion.seen_from_wall(i, &self.step)
        };
        let count = self.find(&seen, all, search)?;
        let all = &mut all[..count];
        self.recall(&seen, all, taken, histories);
        let mut load = ParticleLoad {
            force: Vector3::ZERO,
            torque: Vector3::ZERO,
            contacts: 0,
        };
        for c in all.iter_mut() {
            let Some(contact) = StagedContact::of_wall(&seen, &c.surface) else {
                c.is_remembered = false;
                continue;
            };
            let history = &mut c.history[..layout.history];
            let mut remembered = recalled(of_laws, c.last_normal, &c.surface, history);
            let friction = law.constants.tangential.friction;
            let mass = effective_mass(i);
            // Only with Hale's factors is there an error.
            let Ok(f) = contact.whole_force(law, friction, mass, &self.step, &mut remembered)
            else {
                c.is_remembered = false;
                continue;
            };
            let StagedHistory {
                memory,
                energy,
                rests,
                ..
            } = &remembered;
            if layout.history > 0 {
                write_history(of_laws, &c.surface, (*memory, *energy, rests), history);
            }
            load.contacts += 1;
            load.force = load.force - motion.to_world(f.force);
            load.torque = load.torque + motion.to_world(f.torque_i);
        }
        self.remember(&seen, all, histories);
        Ok(load)
    }

    /// How many contacts a particle has.
    fn find(
        &self,
        seen: &Particle,
        all: &mut [Touched],
        search: impl FnOnce(&Grain<'_>, &mut Found<'_>) -> bool,
    ) -> Result<usize, TooLittleRoom> {
        let grain = Grain {
            particle: 0,
            body: &seen.body,
            centre: seen.position,
        };
        let mut found = Found::new(self.motion, all);
        let has_all = search(&grain, &mut found);
        match found.count() {
            Some(count) if has_all => Ok(count),
            _ => Err(TooLittleRoom),
        }
    }

    /// What the contacts go on from.
    fn recall(&self, seen: &Particle, all: &mut [Touched], taken: &mut [bool], histories: &[f64]) {
        let layout = &self.layout;
        let before = &histories[..layout.used(histories)];
        let possible = layout.records.min(taken.len());
        let taken = &mut taken[..possible];
        taken.fill(false);
        let mut records = 0;
        // As on the host (`contacts.rs`): faces that share a contact find what is remembered with each other.
        for alone in [true, false] {
            for c in all.iter_mut() {
                if (c.surface.share.value == 1.0) != alone {
                    continue;
                }
                let history = &mut c.history[..layout.history];
                c.last_normal =
                    layout.recall(before, taken, c.part, &c.surface, seen.position, history);
                c.is_remembered = records < possible;
                records += 1;
            }
        }
    }

    /// Writes what is remembered of the contacts.
    fn remember(&self, seen: &Particle, all: &[Touched], histories: &mut [f64]) {
        let layout = &self.layout;
        if layout.records == 0 {
            return;
        }
        let used_before = layout.used(histories);
        let (mut used, mut count) = (1, 0);
        for c in all.iter().filter(|c| c.is_remembered) {
            let record = &mut histories[used..used + layout.record];
            let history = &c.history[..layout.history];
            layout.remember(record, c.part, &c.surface, seen.position, history);
            used += layout.record;
            count += 1;
        }
        histories[0] = f64::from(count);
        if used < used_before {
            histories[used..used_before].fill(0.0);
        }
    }
}
