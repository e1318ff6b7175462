// SPDX-License-Identifier: MIT OR Apache-2.0
//! What does each of the lone contacts go on from, and is it such as calls have written? Almost always it is, and lanes see that.

use super::histories::{WallHistoryLayout, WrongHistory};
use super::lone_contacts::LoneContacts;
use crate::contact::ranges::LARGEST_DISPLACEMENT;
use crate::contact::vectors_in_lanes::{load, put_in_lane, splat, Columns};
use crate::contact::HistoryLayout;
use crate::real::Real;
use crate::simd::{lines, InstructionSet, Lanes, Line, Registers, Stage, MOST_LANES};
use crate::vector::Vector3;
use core::ops::Range;

/// In the last place of a line, which is 0 for a new contact and 1 for one that goes on: what it goes on from has to be looked for.
const DOUBTFUL: f64 = 2.0;
/// There: a contact that lanes do not take.
const HANDED_OVER: f64 = 3.0;
/// Contacts that are read and then looked at: what they need stays in the nearest cache meanwhile. A multiple of all numbers of lanes.
const TOGETHER: usize = 64;

impl LoneContacts {
    /// Finds what the contacts go on from, and whether it is such as calls have written. `near` are the indices of the particles that may
    /// touch.
    ///
    /// # Errors
    /// The first number that is not.
    pub(super) fn recall(
        &mut self,
        near: &[usize],
        layout: WallHistoryLayout,
        of_laws: &HistoryLayout,
        histories: &[f64],
        instruction_set: InstructionSet,
    ) -> Result<(), WrongHistory> {
        self.last.clear();
        let length = layout.length();
        let Some(memory) = of_laws.memory.filter(|_| length > 0) else {
            return Ok(());
        };
        let energy = of_laws.energy;
        // What resists rolling is not in the lanes, which leave zeros there.
        let resistance = of_laws.resistance();
        self.doubtful.clear();
        for first in (0..self.contacts.len()).step_by(TOGETHER) {
            let last = self.contacts.len().min(first + TOGETHER);
            let contacts = &self.contacts[first..last];
            self.last.extend(contacts.iter().map(|contact| {
                let particle = near[contact.near as usize];
                let row = &histories[particle * length..(particle + 1) * length];
                if row[0] == 0.0 {
                    return Line::ZERO;
                }
                let (normal, history) = layout.parts_of(&row[1..1 + layout.record]);
                let mut is_own = row[0] == 1.0 && row[1] == f64::from(contact.part + 1);
                for number in &history[resistance..] {
                    is_own &= *number == 0.0;
                }
                let mark = if is_own { 1.0 } else { DOUBTFUL };
                line_of(normal, history, memory, energy, mark)
            }));
            instruction_set.run(FindDoubtful {
                contacts: self,
                range: first..last,
            });
        }
        let doubtful = core::mem::take(&mut self.doubtful);
        let recalled = self.recall_doubtful(&doubtful, near, layout, of_laws, histories);
        self.doubtful = doubtful;
        recalled?;
        let parts = self.parts.len();
        for other in &self.others {
            let particle = near[*other as usize];
            layout.check(particle, histories, parts, Some(of_laws))?;
        }
        Ok(())
    }

    /// The same of contacts whose particle touched other parts too, or that go on from numbers which no call may have written.
    fn recall_doubtful(
        &mut self,
        doubtful: &[u32],
        near: &[usize],
        layout: WallHistoryLayout,
        of_laws: &HistoryLayout,
        histories: &[f64],
    ) -> Result<(), WrongHistory> {
        let (length, parts) = (layout.length(), self.parts.len());
        let memory = of_laws.memory.unwrap_or(0);
        let mut handed_over = false;
        for &index in doubtful {
            let index = index as usize;
            let contact = self.contacts[index];
            let particle = near[contact.near as usize];
            let row = &histories[particle * length..(particle + 1) * length];
            layout.check(particle, histories, parts, Some(of_laws))?;
            if row[0] > 1.0 && !self.surfaces.is_empty() {
                // Of several contacts with one part the nearest is meant.
                self.last[index].0[7] = HANDED_OVER;
                handed_over = true;
                continue;
            }
            let inwards = -self.outwards(index);
            let line = match layout.record_of(row, contact.part as usize, inwards) {
                None => Line::ZERO,
                Some(record) => {
                    let (normal, history) = layout.parts_of(record);
                    let normal = if normal.is_unit() { normal } else { inwards };
                    line_of(normal, history, memory, of_laws.energy, 1.0)
                }
            };
            self.last[index] = line;
        }
        if handed_over {
            self.hand_over();
        }
        Ok(())
    }

    /// Takes the marked contacts out.
    fn hand_over(&mut self) {
        let mut kept = 0;
        for index in 0..self.contacts.len() {
            if self.last[index].0[7] == HANDED_OVER {
                self.others.push(self.contacts[index].near);
                continue;
            }
            self.contacts[kept] = self.contacts[index];
            self.surfaces[kept] = self.surfaces[index];
            if self.with_velocities {
                self.velocities[kept] = self.velocities[index];
            }
            self.last[kept] = self.last[index];
            kept += 1;
        }
        self.contacts.truncate(kept);
        self.surfaces.truncate(kept);
        self.velocities.truncate(kept);
        self.last.truncate(kept);
    }
}

/// What ends a record of which the lanes read `[ .. normal, memory, energy]` where it stands, the energy where it is remembered: records
/// that calls have written need not be looked at first.
#[derive(Clone, Copy, Debug)]
pub(super) struct EndOfRecord {
    with_energy: bool,
}

impl EndOfRecord {
    /// Of records with histories of these laws; `None` where they end with something else.
    pub(super) fn of(laws: &HistoryLayout) -> Option<Self> {
        let memory = laws.memory?;
        let with_energy = laws.energy == Some(memory + 3);
        let end = memory + 3 + usize::from(with_energy);
        // The normal before the memory is that of the history or, where this begins with the memory, the record's.
        let follows_normal = memory == laws.normal.map_or(0, |normal| normal + 3);
        (follows_normal && end == laws.length).then_some(EndOfRecord { with_energy })
    }

    /// Normals, memories and energies.
    #[inline(always)]
    pub(super) fn read<S: Registers>(
        self,
        registers: S,
        ends: &[Line; MOST_LANES],
    ) -> (Vector3<Lanes<S>>, Vector3<Lanes<S>>, Lanes<S>) {
        let [_, a, b, c, d, e, f, g] = Lanes::all(registers, registers.columns(&lines!(ends)));
        if self.with_energy {
            (Vector3::new(a, b, c), Vector3::new(d, e, f), g)
        } else {
            let zero = a.constant(0.0);
            (Vector3::new(b, c, d), Vector3::new(e, f, g), zero)
        }
    }
}

#[inline(always)]
fn line_of(
    normal: Vector3,
    history: &[f64],
    memory: usize,
    energy: Option<usize>,
    mark: f64,
) -> Line {
    let m = &history[memory..memory + 3];
    let energy = energy.map_or(0.0, |at| history[at]);
    Line([normal.x, normal.y, normal.z, m[0], m[1], m[2], energy, mark])
}

/// Names the contacts whose lines are marked so, or are not what a call has written: normals of the last step and histories that may be that
/// all the same.
struct FindDoubtful<'a> {
    contacts: &'a mut LoneContacts,
    range: Range<usize>,
}

impl Stage for FindDoubtful<'_> {
    #[inline(always)]
    fn run<S: Registers>(self, registers: S) {
        let lone = self.contacts;
        let largest = Lanes::splat(registers, LARGEST_DISPLACEMENT);
        let half = Lanes::splat(registers, 0.5);
        let one_side = match &lone.planes[..] {
            [plane] if !plane.both_sides => Some(splat(registers, plane.normal)),
            _ => None,
        };
        let mut normals: Columns = Default::default();
        let end = self.range.end;
        for first in self.range.step_by(S::LANES) {
            let present = S::LANES.min(end - first);
            let of_batch = &lone.last[first..first + present];
            let mut lines = [&of_batch[0]; MOST_LANES];
            for (of_lane, line) in lines.iter_mut().zip(of_batch) {
                *of_lane = line;
            }
            let outwards = match one_side {
                Some(normal) => normal,
                None if lone.surfaces.is_empty() => {
                    for lane in 0..present {
                        put_in_lane(&mut normals, lane, lone.outwards(first + lane));
                    }
                    load(registers, &normals)
                }
                None => {
                    let of_batch = &lone.surfaces[first..first + present];
                    let mut surfaces = [&of_batch[0][1]; MOST_LANES];
                    for (of_lane, [_, b]) in surfaces.iter_mut().zip(of_batch) {
                        *of_lane = b;
                    }
                    let b = Lanes::all(registers, registers.columns(&surfaces));
                    Vector3::new(b[4], b[5], b[6])
                }
            };
            let l = Lanes::all(registers, registers.columns(&lines));
            let normal = Vector3::new(l[0], l[1], l[2]);
            let mut sound = registers.and(normal.is_unit(), half.less(-normal.dot(outwards)));
            for number in &l[3..7] {
                sound = registers.and(sound, number.abs().less(largest));
            }
            let goes_on = half.less(l[7]);
            let is_marked = (half + 1.0).less(l[7]);
            let doubtful = registers.or(is_marked, registers.and_not(goes_on, sound));
            let mut left = registers.bits(doubtful) & ((1 << present) - 1);
            while left != 0 {
                lone.doubtful.push(first as u32 + left.trailing_zeros());
                left &= left - 1;
            }
        }
    }
}
