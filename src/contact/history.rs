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

use super::forces::{ContactForces, Remembered};
use super::ranges::{LARGEST_DISPLACEMENT, LARGEST_TANGENTIAL_ENERGY, LARGEST_TANGENTIAL_FORCE};
use crate::vector::Vector3;

/// Time step and whether the history is advanced.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Time step, the interval over which the velocities moved the bodies to where they are.
    pub time_step: f64,
    /// False in the set-up of a run: forces from the history as it stands.
    pub advance_history: bool,
}

impl Step {
    /// Time over which the history advances.
    #[inline(always)]
    pub fn elapsed(&self) -> f64 {
        if self.advance_history {
            self.time_step
        } else {
            0.0
        }
    }
}

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

    /// The first invalid number of the history of a touching contact: its place and its value. A normal that is not a unit
    /// vector is not used, and not looked at.
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

/// Reads what is remembered of a pair.
#[doc(hidden)]
#[inline(always)]
pub fn recall(
    layout: &HistoryLayout,
    history: &[f64],
    touching: bool,
    step: &Step,
    normal_now: Vector3,
    normal_before: Vector3,
) -> Remembered {
    let read = |at: usize| Vector3::new(history[at], history[at + 1], history[at + 2]);
    Remembered {
        continued: touching,
        normal: if touching { normal_before } else { normal_now },
        memory: match layout.memory {
            Some(at) if touching => read(at),
            _ => Vector3::ZERO,
        },
        energy: match layout.energy {
            Some(at) if touching => history[at],
            _ => 0.0,
        },
        time: step.elapsed(),
    }
}

/// Writes what is remembered of a touching pair.
#[doc(hidden)]
#[inline(always)]
pub fn remember(
    layout: &HistoryLayout,
    history: &mut [f64],
    normal: Vector3,
    forces: &ContactForces,
) {
    let mut write = |at: usize, v: Vector3| history[at..at + 3].copy_from_slice(&v.to_array());
    if let Some(at) = layout.normal {
        write(at, normal);
    }
    if let Some(at) = layout.memory {
        write(at, forces.memory);
    }
    if let Some(at) = layout.energy {
        history[at] = forces.tangential_energy;
    }
}

/// Forgets the tangential part; the cached normal stays, the start of the next search.
#[doc(hidden)]
#[inline(always)]
pub fn forget(layout: &HistoryLayout, history: &mut [f64]) {
    let from = layout.memory.unwrap_or(layout.length);
    history[from..].fill(0.0);
}

/// The cached normal, if there is one.
#[doc(hidden)]
#[inline(always)]
pub fn cached_normal(layout: &HistoryLayout, history: &[f64]) -> Option<Vector3> {
    let at = layout.normal?;
    let n = Vector3::new(history[at], history[at + 1], history[at + 2]);
    // Zero: nothing cached yet. Anything else that is no unit vector came from elsewhere and is not used.
    n.is_unit().then_some(n)
}
