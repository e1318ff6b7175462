// SPDX-License-Identifier: MIT OR Apache-2.0
//! The candidates in batches of as many pairs as there are lanes, with what is remembered of them as the lanes load it.
//!
//! A batch stays as it is until the candidates are chosen anew: a step reads and writes its histories in the order in
//! which it goes through them, and looks nothing up. The engine's own arrays are brought up to date in every step, or,
//! where the caller asks for it, only when it needs them.

use super::memory::{reserve, Allocated};
use super::rows::NeighbourRows;
use crate::contact::history::{cached_normal, Remembers};
use crate::contact::HistoryLayout;
use crate::vector::Vector3;

/// Doubles of a cache line.
const LINE: usize = 8;

/// A pair of the list.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    /// Central particle.
    pub i: u32,
    /// Place in its row.
    pub entry: u32,
    /// Its neighbour.
    pub j: u32,
    /// Where its law stands among all laws.
    pub law: u32,
}

/// In the place of a law where the pairs of a batch have several.
const SEVERAL: u32 = u32::MAX;

/// Which lanes of a batch hold a pair, and which of these touch.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LaneBits {
    /// Lanes with a pair; the others repeat the last one.
    pub present: u16,
    /// Lanes whose pair touched at the last step.
    pub touching: u16,
}

/// All batches.
#[derive(Debug)]
pub(super) struct Batches {
    /// Pairs of a batch.
    lanes: usize,
    /// First and second particles and places in the rows, `lanes` a batch.
    i: Vec<u32>,
    j: Vec<u32>,
    entries: Vec<u32>,
    /// Where their laws stand among all: a step looks up no types, which would be anywhere in memory.
    laws: Vec<u32>,
    bits: Vec<LaneBits>,
    /// For each batch the law of all its pairs, or [`SEVERAL`].
    common_laws: Vec<u32>,
    /// For each batch the least particle that a later one adds to.
    later: Vec<u32>,
    /// Numbers of each pair that are remembered here: those of the engine's layout, and always the normal of a pair that
    /// is searched.
    here: HistoryLayout,
    /// The layout of the engine's arrays.
    there: HistoryLayout,
    /// Batch after batch, within it number after number, within these lane after lane; from `first` on, where a cache
    /// line begins.
    numbers: Vec<f64>,
    first: usize,
    /// Whether the engine's arrays are behind.
    unwritten: bool,
    /// Is told of large memory just allocated.
    pub allocated: Allocated,
}

impl Default for Batches {
    fn default() -> Self {
        let none = HistoryLayout::new(Remembers::default());
        Batches {
            lanes: 1,
            i: Vec::new(),
            j: Vec::new(),
            entries: Vec::new(),
            laws: Vec::new(),
            bits: Vec::new(),
            common_laws: Vec::new(),
            later: Vec::new(),
            here: none,
            there: none,
            numbers: Vec::new(),
            first: 0,
            unwritten: false,
            allocated: |_, _| (),
        }
    }
}

impl Batches {
    /// None, of this many lanes, with the normals remembered where they are searched for.
    pub fn begin(&mut self, lanes: usize, there: HistoryLayout, searched: bool) {
        self.lanes = lanes;
        self.there = there;
        self.here = HistoryLayout::new(Remembers {
            normal: searched || there.normal.is_some(),
            ..there.remembers()
        });
        self.i.clear();
        self.j.clear();
        self.entries.clear();
        self.laws.clear();
        self.bits.clear();
        self.common_laws.clear();
        self.later.clear();
        self.numbers.clear();
        self.align();
        self.unwritten = false;
    }

    /// Room for twice as many pairs as there are, of at most `listed`, so that nothing is allocated when others touch.
    pub fn reserve(&mut self, listed: usize) {
        let batches = (2 * self.i.len()).min(listed + self.lanes) / self.lanes + 1;
        reserve(&mut self.i, batches * self.lanes, self.allocated);
        reserve(&mut self.j, batches * self.lanes, self.allocated);
        reserve(&mut self.entries, batches * self.lanes, self.allocated);
        reserve(&mut self.laws, batches * self.lanes, self.allocated);
        reserve(&mut self.bits, batches, self.allocated);
        reserve(&mut self.common_laws, batches, self.allocated);
        reserve(&mut self.later, batches, self.allocated);
        let numbers = LINE + batches * self.here.length * self.lanes;
        reserve(&mut self.numbers, numbers, self.allocated);
        self.align();
    }

    /// Once all pairs are there: which sums are whole after which batch, and which batch has one law.
    pub fn end(&mut self) {
        let of_batches = self.laws.chunks(self.lanes);
        self.common_laws.extend(of_batches.map(|laws| {
            let same = laws.iter().all(|law| *law == laws[0]);
            if same {
                laws[0]
            } else {
                SEVERAL
            }
        }));
        self.later.resize(self.bits.len(), u32::MAX);
        let mut least = u32::MAX;
        for (batch, later) in self.later.iter_mut().enumerate().rev() {
            *later = least;
            for k in batch * self.lanes..(batch + 1) * self.lanes {
                least = least.min(self.i[k]).min(self.j[k]);
            }
        }
    }

    /// The particles below this one get nothing from any batch after this one.
    #[inline(always)]
    pub fn whole_below(&self, batch: usize) -> u32 {
        self.later[batch]
    }

    /// Moves the numbers to where a cache line begins.
    fn align(&mut self) {
        let used = self.first..self.numbers.len().max(self.first);
        let length = used.len();
        // An offset that cannot be told costs speed alone.
        let first = self.numbers.as_ptr().align_offset(LINE * size_of::<f64>()) % LINE;
        self.numbers.resize((first + length).max(used.end), 0.0);
        if length > 0 {
            self.numbers.copy_within(used, first);
        }
        self.numbers.truncate(first + length);
        self.first = first;
    }

    /// One pair more, in a new batch if `apart`. `history` is what the engine remembers of it; `start` is the normal to
    /// begin with where that is none.
    pub fn push(
        &mut self,
        pair: Candidate,
        touching: bool,
        history: &[f64],
        start: [f64; 3],
        apart: bool,
    ) {
        let last = self.bits.len().wrapping_sub(1);
        let full = match self.bits.get(last) {
            Some(bits) => apart || bits.present >> (self.lanes - 1) & 1 != 0,
            None => true,
        };
        let (batch, lane) = if full {
            self.bits.push(LaneBits::default());
            // Lanes without a pair of their own compute the first one again.
            let lanes = self.i.len() + self.lanes;
            self.i.resize(lanes, pair.i);
            self.j.resize(lanes, pair.j);
            self.entries.resize(lanes, pair.entry);
            self.laws.resize(lanes, pair.law);
            let length = self.numbers.len() + self.here.length * self.lanes;
            reserve(&mut self.numbers, length, self.allocated);
            self.numbers.resize(length, 0.0);
            (self.bits.len() - 1, 0)
        } else {
            (last, self.bits[last].present.trailing_ones() as usize)
        };
        let at = batch * self.lanes + lane;
        (self.i[at], self.j[at], self.entries[at]) = (pair.i, pair.j, pair.entry);
        self.laws[at] = pair.law;
        let bits = &mut self.bits[batch];
        bits.present |= 1 << lane;
        bits.touching |= u16::from(touching) << lane;
        let (here, there) = (self.here, self.there);
        if let Some(at) = here.normal {
            let n = cached_normal(&there, history).map_or(start, Vector3::to_array);
            let lanes = if lane == 0 {
                0..self.lanes
            } else {
                lane..lane + 1
            };
            for lane in lanes {
                for (k, n) in n.into_iter().enumerate() {
                    *self.number(batch, lane, at + k) = n;
                }
            }
        }
        if touching {
            let tangential = there.memory.unwrap_or(there.length)..there.length;
            let to = here.memory.unwrap_or(here.length);
            for (k, from) in tangential.enumerate() {
                *self.number(batch, lane, to + k) = history[from];
            }
        }
    }

    fn number(&mut self, batch: usize, lane: usize, k: usize) -> &mut f64 {
        let at = (batch * self.here.length + k) * self.lanes + lane;
        &mut self.numbers[self.first + at]
    }

    /// What is remembered here of one pair.
    fn remembered(&self, batch: usize, lane: usize, k: usize) -> f64 {
        let at = (batch * self.here.length + k) * self.lanes + lane;
        self.numbers[self.first + at]
    }

    /// Batches.
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.bits.len()
    }

    /// The pair of one lane.
    pub fn pair(&self, batch: usize, lane: usize) -> Candidate {
        let at = batch * self.lanes + lane;
        Candidate {
            i: self.i[at],
            entry: self.entries[at],
            j: self.j[at],
            law: self.laws[at],
        }
    }

    /// The pair that came last.
    pub fn last(&self) -> Option<Candidate> {
        let lane = self.bits.last()?.present.trailing_ones() as usize - 1;
        Some(self.pair(self.bits.len() - 1, lane))
    }

    /// The particles of all lanes of all batches, those of lanes without a pair of their own too.
    pub fn particles(&self) -> impl Iterator<Item = u32> + '_ {
        self.i.iter().chain(&self.j).copied()
    }

    /// Central particles and places in their rows of all pairs.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.bits.iter().enumerate().flat_map(move |(batch, bits)| {
            (0..bits.present.count_ones() as usize).map(move |lane| {
                let pair = self.pair(batch, lane);
                (pair.i as usize, pair.entry as usize)
            })
        })
    }

    /// First particles, second particles (from this batch on), bits and numbers of one batch.
    #[inline(always)]
    pub fn batch(&mut self, batch: usize) -> (&[u32], &[u32], &mut LaneBits, Numbers<'_>) {
        let length = self.here.length * self.lanes;
        let at = self.first + batch * length;
        (
            &self.i[batch * self.lanes..(batch + 1) * self.lanes],
            &self.j[batch * self.lanes..],
            &mut self.bits[batch],
            Numbers {
                layout: self.here,
                numbers: &mut self.numbers[at..at + length],
            },
        )
    }

    /// Where the law of all pairs of a batch stands, if they have one.
    #[inline(always)]
    pub fn common_law(&self, batch: usize) -> Option<u32> {
        let law = self.common_laws[batch];
        (law != SEVERAL).then_some(law)
    }

    /// Where the laws of the lanes of a batch stand.
    #[inline(always)]
    pub fn laws_of(&self, batch: usize) -> &[u32] {
        &self.laws[batch * self.lanes..(batch + 1) * self.lanes]
    }

    /// What is remembered of a batch; nothing of one that there is not.
    #[inline(always)]
    pub fn numbers_of(&self, batch: usize) -> &[f64] {
        let length = self.here.length * self.lanes;
        let at = self.first + batch * length;
        self.numbers.get(at..at + length).unwrap_or(&[])
    }

    /// Lanes of all batches that hold no pair that touches.
    pub fn idle(&self) -> usize {
        let touching: u32 = self.bits.iter().map(|b| b.touching.count_ones()).sum();
        self.i.len() - touching as usize
    }

    /// Writes what is remembered of one pair to the engine's arrays.
    pub fn write_one<R: NeighbourRows + ?Sized>(&self, rows: &mut R, batch: usize, lane: usize) {
        let pair = self.pair(batch, lane);
        let (touching, history) = rows.pair(pair.i as usize, pair.entry as usize);
        if let Some(touching) = touching {
            *touching = i32::from(self.bits[batch].touching >> lane & 1);
        }
        let offset = self.here.length - self.there.length;
        for (k, to) in history.iter_mut().enumerate() {
            *to = self.remembered(batch, lane, offset + k);
        }
    }

    /// The reverse of [`Batches::write_one`].
    pub fn read_one(&mut self, rows: &mut dyn NeighbourRows, batch: usize, lane: usize) {
        let pair = self.pair(batch, lane);
        let (touching, history) = rows.pair(pair.i as usize, pair.entry as usize);
        if let Some(touching) = touching {
            let bits = &mut self.bits[batch].touching;
            *bits = *bits & !(1 << lane) | u16::from(*touching != 0) << lane;
        }
        let offset = self.here.length - self.there.length;
        for (k, from) in history.iter().enumerate() {
            *self.number(batch, lane, offset + k) = *from;
        }
    }

    /// Brings the engine's arrays up to date, if they are behind.
    pub fn write<R: NeighbourRows>(&mut self, rows: &mut R) {
        if !self.unwritten {
            return;
        }
        self.unwritten = false;
        if self.there.length == 0 {
            return;
        }
        for batch in 0..self.bits.len() {
            for lane in 0..self.bits[batch].present.count_ones() as usize {
                self.write_one(rows, batch, lane);
            }
        }
    }

    /// A step has gone by: the engine's arrays are behind.
    pub fn advanced(&mut self) {
        // An engine without pairs may have no arrays either.
        self.unwritten = !self.bits.is_empty();
    }

    /// What is remembered here will not be written.
    pub fn discard(&mut self) {
        self.unwritten = false;
    }

    /// Whether the engine has arrays, and they are behind.
    pub fn are_unwritten(&self) -> bool {
        self.unwritten && self.there.length > 0
    }

    /// Doubles that the engine's arrays have for a pair.
    pub fn written_length(&self) -> usize {
        self.there.length
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let of_pairs =
            self.i.capacity() + self.j.capacity() + self.entries.capacity() + self.laws.capacity();
        (of_pairs + self.common_laws.capacity()) * size_of::<u32>()
            + self.bits.capacity() * size_of::<LaneBits>()
            + self.later.capacity() * size_of::<u32>()
            + self.numbers.capacity() * size_of::<f64>()
    }
}

/// The numbers of one batch.
pub(super) struct Numbers<'a> {
    pub layout: HistoryLayout,
    numbers: &'a mut [f64],
}

impl Numbers<'_> {
    /// Number `k` of all lanes, and what comes after it.
    #[inline(always)]
    pub fn get(&self, k: usize, lanes: usize) -> &[f64] {
        &self.numbers[k * lanes..]
    }

    /// See [`Numbers::get`].
    #[inline(always)]
    pub fn get_mut(&mut self, k: usize, lanes: usize) -> &mut [f64] {
        &mut self.numbers[k * lanes..]
    }
}
