// SPDX-License-Identifier: MIT OR Apache-2.0
//! The loads that are not elastic of the particles that touch a wall, for the half step after: as many as touch, where an array of
//! all particles would be cleared and read in each step.

use crate::tallies::InelasticLoad;

/// One particle, and what acts on it.
#[derive(Clone, Copy, Debug)]
pub struct TouchingLoad {
    /// Index of the particle.
    pub particle: usize,
    /// Its place among the particles that might touch.
    pub near: usize,
    /// Forces and torques.
    pub load: InelasticLoad,
}

/// Those of the last call.
#[derive(Debug, Default)]
pub(super) struct TouchingLoads {
    all: Vec<TouchingLoad>,
}

impl TouchingLoads {
    pub(super) fn clear(&mut self) {
        self.all.clear();
    }

    /// A particle that has none yet.
    pub(super) fn push(&mut self, particle: usize, near: usize, load: InelasticLoad) {
        self.all.push(TouchingLoad {
            particle,
            near,
            load,
        });
    }

    /// The load of a particle. The contacts of one come one after the other, so that a load that is there is the last.
    pub(super) fn of(&mut self, particle: usize, near: usize) -> &mut InelasticLoad {
        if self.all.last().is_none_or(|last| last.particle != particle) {
            self.push(particle, near, InelasticLoad::default());
        }
        let last = self.all.len() - 1;
        &mut self.all[last].load
    }

    pub(super) fn all(&self) -> &[TouchingLoad] {
        &self.all
    }

    pub(super) fn all_mut(&mut self) -> &mut [TouchingLoad] {
        &mut self.all
    }
}
