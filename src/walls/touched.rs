// SPDX-License-Identifier: MIT OR Apache-2.0
//! The contacts of one particle as they are found, in room that is lent.

use super::motion::Motion;
use super::plane::flat_along;
use super::shape::Grain;
use super::surface::Surface;
use crate::contact::staged::WallSurface;
use crate::vector::Vector3;

/// Doubles of the history of one contact, at most: of laws without springs, memories and resistance to rolling and twisting.
#[doc(hidden)]
pub const LONGEST_HISTORY: usize = 7;

/// A contact of a particle.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Touched {
    pub(super) part: usize,
    pub(super) surface: WallSurface,
    pub(super) last_normal: Option<Vector3>,
    pub(super) history: [f64; LONGEST_HISTORY],
    pub(super) is_remembered: bool,
}

/// No contact.
pub(super) const NO_CONTACT: Touched = Touched {
    part: 0,
    surface: flat_along(Vector3::ZERO, Vector3::ZERO, Vector3::ZERO),
    last_normal: None,
    history: [0.0; LONGEST_HISTORY],
    is_remembered: false,
};

/// Those that were found so far.
pub(super) struct Found<'a> {
    motion: &'a Motion,
    all: &'a mut [Touched],
    count: usize,
}

impl<'a> Found<'a> {
    /// None yet, in such room.
    pub(super) fn new(motion: &'a Motion, all: &'a mut [Touched]) -> Self {
        Found {
            motion,
            all,
            count: 0,
        }
    }

    /// How many; `None` where there was no room for all.
    pub(super) fn count(&self) -> Option<usize> {
        (self.count <= self.all.len()).then_some(self.count)
    }

    /// One with this part.
    pub(super) fn add(&mut self, part: usize, surface: &WallSurface) {
        if let Some(contact) = self.all.get_mut(self.count) {
            contact.part = part;
            contact.surface = self.motion.in_its_frame(surface);
        }
        self.count += 1;
    }

    /// All with this surface, which is this part. One function for all walls: it is long.
    #[inline(never)]
    pub(super) fn on_surface(&mut self, part: usize, surface: &Surface, grain: &Grain<'_>) {
        surface.contacts(grain, |contact| self.add(part, contact));
    }
}
