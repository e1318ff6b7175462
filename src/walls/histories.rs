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

use crate::contact::ranges::LARGEST_DISPLACEMENT;
use crate::contact::staged::WallSurface;
use crate::contact::HistoryLayout;
use crate::vector::Vector3;

/// Length of a record before the tangential memory.
const HEAD: usize = 7;

/// Histories that hold a number which no call has written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WrongHistory {
    /// The particle's index.
    pub particle: usize,
    /// Place in the particle's histories.
    pub place: usize,
    /// What stands there.
    pub value: f64,
}

/// How the histories of one particle are laid out: those of its contacts with a wall, by part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WallHistoryLayout {
    /// Doubles of the contact model's history.
    pub history: usize,
    /// Records of a particle.
    pub records: usize,
    /// Doubles of a record.
    pub record: usize,
}

impl WallHistoryLayout {
    /// Of so many records at most, with so long a history of the contact model. Without a history there is nothing to remember.
    /// Public for `gpu/`; no interface for others.
    #[doc(hidden)]
    pub fn new(history: usize, records: usize) -> Self {
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
            // A count that no call has written may be any number.
            Some(count) if *count > 0.0 => 1 + (*count as usize).min(self.records) * self.record,
            _ => 0,
        }
    }

    /// Whether the histories of a particle, among those of all, are such as calls have written. `of_laws` is the layout of the library's
    /// own histories, `None` for those of an engine.
    ///
    /// # Errors
    /// The first number that is not.
    pub(super) fn check(
        &self,
        particle: usize,
        histories: &[f64],
        parts: usize,
        of_laws: Option<&HistoryLayout>,
    ) -> Result<(), WrongHistory> {
        let length = self.length();
        let histories = &histories[particle * length..(particle + 1) * length];
        match self.first_wrong(histories, parts, of_laws) {
            None => Ok(()),
            Some((place, value)) => Err(WrongHistory {
                particle,
                place,
                value,
            }),
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
        if count == 0.0 {
            return None;
        }
        if !is_whole(count, 1, self.records) {
            return Some((0, count));
        }
        for index in 0..count as usize {
            let at = 1 + index * self.record;
            let record = &histories[at..at + self.record];
            // One look at all numbers, since almost always nothing is wrong: none of their ranges is narrower.
            let within = is_whole(record[0], 1, parts) && are_within_range(&record[1..]);
            if within {
                continue;
            }
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

    /// Normal and history of a record.
    #[inline(always)]
    pub(super) fn parts_of<'h>(&self, record: &'h [f64]) -> (Vector3, &'h [f64]) {
        (vector(&record[4..]), &record[HEAD..])
    }

    /// The record from which a contact goes on with a part that a particle touches in one place at most; `None` for a new contact.
    /// `normal` is the present one, from the particle into the wall.
    #[inline(always)]
    pub(super) fn record_of<'h>(
        &self,
        histories: &'h [f64],
        part: usize,
        normal: Vector3,
    ) -> Option<&'h [f64]> {
        let count = *histories.first()?;
        let own = (part + 1) as f64;
        let mut at = 1;
        // Numbers below `count` are as many as there are records.
        let mut number = 0.0;
        while number < count {
            let record = &histories[at..at + self.record];
            if record[0] == own && vector(&record[4..]).dot(normal) >= 0.5 {
                return Some(record);
            }
            at += self.record;
            number += 1.0;
        }
        None
    }

    /// The last numbers of the record from which a contact goes on with a part that a particle touches in one place at most; `None` for
    /// a contact that is new but for its normal, which is not looked at where there is but one record. The numbers end with the history.
    #[inline(always)]
    pub(super) fn end_of_record<'h>(
        &self,
        histories: &'h [f64],
        part: usize,
        normal: impl FnOnce() -> Vector3,
    ) -> Option<&'h [f64; 8]> {
        let record = if histories[0] <= 1.0 {
            let own = (part + 1) as f64;
            let record = &histories[1..1 + self.record];
            (histories[0] == 1.0 && record[0] == own).then_some(record)?
        } else {
            self.record_of(histories, part, normal())?
        };
        record.last_chunk()
    }

    /// Writes the record of the only contact of a particle: `place` is 1, any number, point and normal; the history begins with the numbers of
    /// `history`, and goes on with zeros.
    #[inline(always)]
    pub(super) fn write_one(
        &self,
        histories: &mut [f64],
        part: usize,
        place: &[f64; 1 + HEAD],
        history: &[f64; 8],
    ) {
        let end = 1 + self.record;
        if histories[0] > 1.0 {
            let used = self.used(histories);
            histories[end..used].fill(0.0);
        }
        let (head, rest) = histories[..end].split_at_mut(1 + HEAD);
        head.copy_from_slice(place);
        head[1] = (part + 1) as f64;
        // Copies of a length known here, which most are, are no calls.
        macro_rules! copy {
            ($($length:literal)*) => {
                match rest.len() {
                    $($length => rest.copy_from_slice(&history[..$length]),)*
                    _ => {
                        let count = rest.len().min(history.len());
                        rest[..count].copy_from_slice(&history[..count]);
                        rest[count..].fill(0.0);
                    }
                }
            };
        }
        copy!(3 4 6 7);
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

/// Whether no number is larger than [`LARGEST_DISPLACEMENT`] in size, or not finite. As whole numbers the sizes stand in the same order,
/// and a sum of them that passes the highest bit needs no branch.
fn are_within_range(numbers: &[f64]) -> bool {
    const SIZE: u64 = i64::MAX as u64;
    let to_highest_bit = SIZE - LARGEST_DISPLACEMENT.to_bits();
    let mut sums = 0;
    for number in numbers {
        sums |= (number.to_bits() & SIZE) + to_highest_bit;
    }
    sums >> 63 == 0
}

/// Whether a number is a whole one of this range. (`fract` is a call where the processor's rounding may not be used.)
fn is_whole(number: f64, least: usize, most: usize) -> bool {
    // Most often it is that.
    if number == least as f64 && least <= most {
        return true;
    }
    let whole = number as usize;
    whole as f64 == number && (least..=most).contains(&whole)
}

fn vector(v: &[f64]) -> Vector3 {
    Vector3::new(v[0], v[1], v[2])
}
