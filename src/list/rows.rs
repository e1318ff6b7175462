// SPDX-License-Identifier: MIT OR Apache-2.0
//! An engine's neighbour list, where its forces go, and what may be wrong with it.

use crate::contact::HistoryLayout;

/// The neighbours of one central particle, and what is remembered of its pairs.
pub struct NeighbourRow<'a> {
    /// Index of the central particle.
    pub central: usize,
    /// Entries of the engine's list; [`Entries::index`] makes an index of one.
    pub neighbours: &'a [i32],
    /// One flag per neighbour, written: 1 for a contact. Empty without history.
    pub touching: &'a mut [i32],
    /// [`HistoryLayout::length`] doubles per neighbour. Empty without history.
    pub history: &'a mut [f64],
}

/// An engine's neighbour list.
pub trait NeighbourRows {
    /// Number of central particles.
    fn count(&self) -> usize;
    /// The row of the `k`-th central particle.
    fn row(&mut self, k: usize) -> NeighbourRow<'_>;
    /// What is remembered of one pair: its flag (`None` without history) and its doubles, by the index of the central
    /// particle and the place in its row.
    fn pair(&mut self, central: usize, entry: usize) -> (Option<&mut i32>, &mut [f64]);
    /// How to read an entry.
    fn entries(&self) -> Entries;
}

/// How an engine writes a neighbour: the particle's index, and bits above it that may exclude the pair.
#[derive(Clone, Copy, Debug)]
pub struct Entries {
    /// Bits that are the index.
    pub mask: i32,
    /// The two bits above this one choose one of `excluded`.
    pub shift: u32,
    /// Whether the engine excludes such a pair.
    pub excluded: [bool; 4],
}

impl Entries {
    /// Entries that are indices and nothing else.
    pub const PLAIN: Entries = Entries {
        mask: -1,
        shift: 0,
        excluded: [false; 4],
    };

    /// Index of the particle that an entry names, or `None` for a pair that the engine excludes.
    #[inline(always)]
    pub fn index(&self, entry: i32) -> Option<usize> {
        let special = (entry as u32 >> self.shift) & 3;
        if self.excluded[special as usize] {
            return None;
        }
        Some((entry & self.mask) as usize)
    }
}

/// Where forces go.
pub struct Accumulators<'a> {
    /// Forces, added to.
    pub forces: &'a mut [[f64; 3]],
    /// Torques, added to.
    pub torques: &'a mut [[f64; 3]],
    /// Particles below this index get the reaction; with Newton's third law on, all of them.
    pub reaction_below: usize,
    /// Particles below this index are owned by the caller.
    pub owned: usize,
}

/// Hale's form broke at a contact: the pair and the curvature ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HaleBroke {
    /// First particle's index.
    pub i: usize,
    /// Second particle's index.
    pub j: usize,
    /// `B/A`.
    pub ratio: f64,
}

/// Why a list was not computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ListError {
    /// Hale's form broke at a contact.
    Hale(HaleBroke),
    /// An entry that is not the index of a particle, or is that of the row's own particle.
    Entry {
        /// The particle of the row.
        central: usize,
        /// Place in the row.
        place: usize,
        /// What stands there.
        entry: i32,
    },
    /// A history of a touching pair that holds a number which no call has written.
    History {
        /// First particle's index.
        i: usize,
        /// Second particle's index.
        j: usize,
        /// Place in the pair's history.
        place: usize,
        /// What stands there.
        value: f64,
    },
}

/// Refuses the history of a touching pair that no call has written.
pub(super) fn check_history(
    layout: &HistoryLayout,
    history: &[f64],
    i: usize,
    j: usize,
) -> Result<(), ListError> {
    match layout.first_wrong(history) {
        None => Ok(()),
        Some((place, value)) => Err(ListError::History { i, j, place, value }),
    }
}
