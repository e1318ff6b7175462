// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the law takes from the history of a contact with a wall, and what it leaves there.

use crate::contact::history;
use crate::contact::particle;
use crate::contact::staged::{StagedHistory, WallSurface};
use crate::contact::{HistoryLayout, Particle};
use crate::force::memory::MOST_PARTS;
use crate::vector::Vector3;

/// The mass of a particle against a wall that nothing moves.
pub(super) fn effective_mass(i: &Particle) -> f64 {
    particle::effective_mass(i.inverse_mass, 0.0)
}

/// What is remembered of a contact with this surface; `last_normal` is its normal of the last step, `None` for a new contact.
pub(super) fn recalled(
    layout: &HistoryLayout,
    last_normal: Option<Vector3>,
    surface: &WallSurface,
    history: &[f64],
) -> StagedHistory {
    let (memory, energy) = layout.tangential(history);
    StagedHistory {
        touched: last_normal.is_some(),
        normal: last_normal.unwrap_or(-surface.normal),
        memory,
        energy,
        rests: {
            let mut rests = [0.0; MOST_PARTS];
            if let Some(at) = layout.rests {
                rests[..layout.rest_count].copy_from_slice(&history[at..at + layout.rest_count]);
            }
            rests
        },
        springs: layout.springs_of(history),
        torques: layout.torques_of(history),
    }
}

/// Tangential memory, its energy, penetrations of rest.
pub(super) type ToRemember<'a> = (Vector3, f64, &'a [f64; MOST_PARTS]);

/// Writes what is to be remembered of a contact with this surface.
pub(super) fn write_history(
    layout: &HistoryLayout,
    surface: &WallSurface,
    (memory, energy, rests): ToRemember<'_>,
    history: &mut [f64],
) {
    // Without a tangential memory there is no history.
    if layout.memory.is_some() {
        history::write(layout, history, (-surface.normal, memory, energy));
    }
    if let Some(at) = layout.rests {
        history[at..at + layout.rest_count].copy_from_slice(&rests[..layout.rest_count]);
    }
}
