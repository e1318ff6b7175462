// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is remembered of the contacts of a particle with a wall, and which contact of this step goes on from which.
//!
//! ```text
//! [ count ]           how many records are in use; once per particle
//! [ part ]            1 + index of the wall's part
//! [ point x y z ]     the surface's deepest point, from the particle's centre
//! [ normal x y z ]    from the particle into the wall
//! [ ... ]             the history of the contact model: the library's own as `HistoryLayout` says, or an engine's
//! ```
//!
//! in the wall's frame, but for an engine's history; from `part` on as often as the wall's parts ask for. All zeros is "nothing
//! remembered". A contact goes on from the one of the same part that was nearest to it, with a normal less than 60 degrees off: a
//! contact moves over the surface, but it does not jump. Faces of a mesh that share a contact may go on from the same: what is
//! remembered belongs to the contact as a whole, of which each face takes its share, so that friction goes on from one face to the
//! next.

use crate::contact::staged::WallSurface;
use crate::contact::HistoryLayout;
use crate::vector::Vector3;

/// Length of a record before the tangential memory.
const HEAD: usize = 7;

/// How the histories of one particle are laid out: those of its contacts with a wall, by part.
#[derive(Clone, Copy, Debug, Default)]
pub struct WallHistoryLayout {
    /// Doubles of the contact model's history.
    pub history: usize,
    /// Records of a particle.
    pub records: usize,
    /// Doubles of a record.
    pub record: usize,
}

impl WallHistoryLayout {
    /// Without a history there is nothing to remember.
    pub(super) fn new(history: usize, records: usize) -> Self {
        WallHistoryLayout {
            history,
            records: if history > 0 { records } else { 0 },
            record: HEAD + history,
        }
    }

    /// Doubles of a particle.
    pub fn length(&self) -> usize {
        if self.records == 0 {
            0
        } else {
            1 + self.records * self.record
        }
    }

    /// Doubles of a particle's histories that are in use; the rest need not be kept or carried. 0 where nothing is remembered.
    pub fn used(&self, histories: &[f64]) -> usize {
        match histories.first() {
            Some(count) if *count > 0.0 => (1 + *count as usize * self.record).min(self.length()),
            _ => 0,
        }
    }

    /// The first number that no call has written: its place and its value. `of_laws` is the layout of the library's own histories;
    /// those of an engine are its own.
    pub(super) fn first_wrong(
        &self,
        histories: &[f64],
        parts: usize,
        of_laws: Option<&HistoryLayout>,
    ) -> Option<(usize, f64)> {
        let count = *histories.first()?;
        if !is_whole(count, 0, self.records) {
            return Some((0, count));
        }
        for index in 0..count as usize {
            let at = 1 + index * self.record;
            let record = &histories[at..at + self.record];
            if !is_whole(record[0], 1, parts) {
                return Some((at, record[0]));
            }
            if let Some(k) = (1..HEAD).find(|k| !record[*k].is_finite()) {
                return Some((at + k, record[k]));
            }
            if let Some((k, value)) = of_laws.and_then(|l| l.first_wrong(&record[HEAD..])) {
                return Some((at + HEAD + k, value));
            }
        }
        None
    }

    /// Copies to `history` what a contact of this step goes on from, among the records `before` of the last step, and gives the
    /// normal that it had; `None`, and zeros, for a new contact. A record that has been gone on from is marked in `taken`.
    pub(super) fn recall(
        &self,
        before: &[f64],
        taken: &mut [bool],
        part: usize,
        surface: &WallSurface,
        centre: Vector3,
        history: &mut [f64],
    ) -> Option<Vector3> {
        let point = surface.point - centre;
        let alone = surface.share.value == 1.0;
        let own = (part + 1) as f64;
        let mut best: Option<(f64, usize)> = None;
        let mut at = 1;
        for (index, taken) in taken.iter().enumerate() {
            let Some(record) = before.get(at..at + HEAD) else {
                break;
            };
            at += self.record;
            if record[0] != own || (alone && *taken) {
                continue;
            }
            if vector(&record[4..]).dot(-surface.normal) < 0.5 {
                continue;
            }
            let distance = (vector(&record[1..]) - point).norm_squared();
            if best.is_none_or(|(least, _)| distance < least) {
                best = Some((distance, index));
            }
        }
        let Some((_, index)) = best else {
            history.fill(0.0);
            return None;
        };
        taken[index] = true;
        let record = &before[1 + index * self.record..1 + (index + 1) * self.record];
        history.copy_from_slice(&record[HEAD..]);
        Some(vector(&record[4..]))
    }

    /// Writes the record of a contact.
    pub(super) fn remember(
        &self,
        record: &mut [f64],
        part: usize,
        surface: &WallSurface,
        centre: Vector3,
        history: &[f64],
    ) {
        record[0] = (part + 1) as f64;
        record[1..4].copy_from_slice(&(surface.point - centre).to_array());
        record[4..7].copy_from_slice(&(-surface.normal).to_array());
        record[HEAD..].copy_from_slice(history);
    }
}

/// Whether a number is a whole one of this range. (`fract` is a call where the processor's rounding may not be used.)
fn is_whole(number: f64, least: usize, most: usize) -> bool {
    let whole = number as usize;
    whole as f64 == number && (least..=most).contains(&whole)
}

fn vector(v: &[f64]) -> Vector3 {
    Vector3::new(v[0], v[1], v[2])
}
