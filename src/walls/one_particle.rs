// SPDX-License-Identifier: MIT OR Apache-2.0
//! One particle against the surfaces of a wall, with no memory but that of its contacts: what a thread of a device does.

use super::contact_history::{effective_mass, recalled, write_history};
use super::histories::WallHistoryLayout;
use super::motion::Motion;
use super::plane::flat_along;
use super::shape::Grain;
use super::surface::Surface;
use crate::contact::staged::{StagedContact, StagedHistory, WallSurface};
use crate::contact::{HistoryLayout, Particle, Step};
use crate::force::PairLaw;
use crate::vector::Vector3;

/// Contacts of one particle with one wall, at most.
#[doc(hidden)]
pub const MOST_CONTACTS: usize = 8;
/// Doubles of the history of one of them, at most: of laws without springs, memories and resistance to rolling and twisting.
#[doc(hidden)]
pub const LONGEST_HISTORY: usize = 7;

/// A wall whose parts have no memory of their own.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct SurfacesInMotion<'a> {
    /// Its parts.
    pub surfaces: &'a [Surface],
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

/// More contacts than [`MOST_CONTACTS`].
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooManyContacts;

/// One of them.
#[derive(Clone, Copy)]
struct Touched {
    part: usize,
    surface: WallSurface,
    last_normal: Option<Vector3>,
    history: [f64; LONGEST_HISTORY],
    touches: bool,
}

impl Touched {
    const NONE: Touched = Touched {
        part: 0,
        surface: flat_along(Vector3::ZERO, Vector3::ZERO, Vector3::ZERO),
        last_normal: None,
        history: [0.0; LONGEST_HISTORY],
        touches: false,
    };
}

impl SurfacesInMotion<'_> {
    /// Forgets the contacts of a particle that touches no more.
    #[doc(hidden)]
    pub fn forget(&self, histories: &mut [f64]) {
        let used = self.layout.used(histories);
        histories[..used].fill(0.0);
    }

    /// The load of a particle under a law without Hale's factors, without springs, memories and resistance to rolling and twisting. `histories`
    /// are the particle's own.
    ///
    /// # Errors
    /// Too many contacts. Nothing is written then.
    #[doc(hidden)]
    pub fn load(
        &self,
        law: &PairLaw,
        i: &Particle,
        histories: &mut [f64],
    ) -> Result<ParticleLoad, TooManyContacts> {
        let SurfacesInMotion {
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
        let mut all = [Touched::NONE; MOST_CONTACTS];
        let count = self.find(&seen, &mut all)?;
        let all = &mut all[..count];
        self.recall(&seen, all, histories);
        let mut load = ParticleLoad {
            force: Vector3::ZERO,
            torque: Vector3::ZERO,
            contacts: 0,
        };
        for c in all.iter_mut() {
            let Some(contact) = StagedContact::of_wall(&seen, &c.surface) else {
                continue;
            };
            let history = &mut c.history[..layout.history];
            let mut remembered = recalled(of_laws, c.last_normal, &c.surface, history);
            let friction = law.constants.tangential.friction;
            let mass = effective_mass(i);
            // Only with Hale's factors is there an error.
            let Ok(f) = contact.whole_force(law, friction, mass, &self.step, &mut remembered)
            else {
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
            c.touches = true;
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
        all: &mut [Touched; MOST_CONTACTS],
    ) -> Result<usize, TooManyContacts> {
        let grain = Grain {
            particle: 0,
            body: &seen.body,
            centre: seen.position,
        };
        let ball = grain.ball();
        let mut count = 0;
        for (part, surface) in self.surfaces.iter().enumerate() {
            if !surface.is_near(&ball) {
                continue;
            }
            surface.contacts(&grain, |found| {
                if let Some(c) = all.get_mut(count) {
                    c.part = part;
                    c.surface = self.motion.in_its_frame(found);
                }
                count += 1;
            });
        }
        if count > MOST_CONTACTS {
            return Err(TooManyContacts);
        }
        Ok(count)
    }

    /// What the contacts go on from.
    fn recall(&self, seen: &Particle, all: &mut [Touched], histories: &[f64]) {
        let layout = &self.layout;
        let before = &histories[..layout.used(histories)];
        let mut taken = [false; MOST_CONTACTS];
        let taken = &mut taken[..layout.records.min(MOST_CONTACTS)];
        for c in all {
            let history = &mut c.history[..layout.history];
            c.last_normal =
                layout.recall(before, taken, c.part, &c.surface, seen.position, history);
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
        for c in all.iter().take(layout.records).filter(|c| c.touches) {
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
