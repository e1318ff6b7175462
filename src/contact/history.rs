// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is remembered of a contact, and where: no longer than the laws of a scene need.
//!
//! ```text
//! [ normal x y z ]         cached normal, from i to j        unless the scene is told to go without
//! [ memory x y z ]         xi or zeta, world frame           with friction
//! [ energy ]               elastic energy of the memory      with friction and `displacement rescaled`
//! ```
//!
//! All zeros is "nothing remembered". The contact `(j, i)` remembers the opposite normal and memory.

use super::ranges::{LARGEST_DISPLACEMENT, LARGEST_TANGENTIAL_ENERGY, LARGEST_TANGENTIAL_FORCE};

/// Offsets, in doubles, of the parts of a contact's history.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HistoryLayout {
    /// Where the cached normal stands.
    pub normal: Option<usize>,
    /// Where the tangential memory stands.
    pub memory: Option<usize>,
    /// Where the elastic energy of the memory stands.
    pub energy: Option<usize>,
    /// Doubles per contact.
    pub length: usize,
    /// Whether some memory is a displacement, not a force.
    pub of_displacements: bool,
}

impl HistoryLayout {
    /// Doubles per contact of the longest layout.
    pub(crate) const LONGEST: usize = 7;

    /// The layout for a scene.
    pub fn new(cached_normal: bool, friction: bool, rescaled: bool) -> Self {
        let mut length = 0;
        let mut take = |wanted: bool, doubles: usize| {
            wanted.then(|| {
                let at = length;
                length += doubles;
                at
            })
        };
        let normal = take(cached_normal, 3);
        let memory = take(friction, 3);
        let energy = take(friction && rescaled, 1);
        HistoryLayout {
            normal,
            memory,
            energy,
            length,
            of_displacements: false,
        }
    }

    /// The first number of a touching contact that no call has written: its place and its value. A normal that is none is
    /// not used, and not looked at.
    pub fn first_wrong(&self, history: &[f64]) -> Option<(usize, f64)> {
        let at = self.memory?;
        let wrong = |k: &usize| {
            let largest = if Some(*k) == self.energy {
                LARGEST_TANGENTIAL_ENERGY
            } else if self.of_displacements {
                LARGEST_DISPLACEMENT
            } else {
                LARGEST_TANGENTIAL_FORCE
            };
            !(history[*k].abs() <= largest)
        };
        (at..self.length).find(wrong).map(|k| (k, history[k]))
    }

    /// Writes the history of `(j, i)` from that of `(i, j)`.
    ///
    /// # Panics
    /// If either slice is shorter than the layout.
    pub fn swap(&self, source: &[f64], target: &mut [f64]) {
        for (k, (t, s)) in target[..self.length]
            .iter_mut()
            .zip(&source[..self.length])
            .enumerate()
        {
            *t = if Some(k) == self.energy { *s } else { -s };
        }
    }
}
