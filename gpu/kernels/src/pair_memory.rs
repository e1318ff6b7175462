// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is remembered of pairs and of walls goes from one neighbour list to the next by the identifiers of the grains: an engine may
//! have brought its grains into another order.

use crate::candidates::keeps;
use core::sync::atomic::{AtomicU64, Ordering};

/// Of a row: it does not lie within the list. A number of the same kind as [`crate::preparation::Fault`].
pub const WRONG_ROW: u32 = 101;
/// Of a row: it names no grain, or its own.
pub const WRONG_NEIGHBOUR: u32 = 102;
/// Of a row: it names an owned grain whose row does not name this one.
pub const HALF_LIST: u32 = 103;
/// Of a row: it names a neighbour twice.
pub const NAMED_TWICE: u32 = 104;

/// What a slot holds: identifier and index + 1. 0 is none.
fn entry(identifier: i32, index: u32) -> u64 {
    u64::from(identifier as u32) << 32 | u64::from(index + 1)
}

/// Where to look for an identifier first, among a number of slots that is a power of two.
fn first_slot(identifier: i32, slots: usize) -> usize {
    // Knuth's multiplier spreads identifiers that follow each other.
    let spread = (identifier as u32).wrapping_mul(0x9e37_79b9);
    (spread ^ spread >> 16) as usize & (slots - 1)
}

/// How many slots serve so many grains: a power of two, at most half of them taken.
pub fn slots_for(grains: usize) -> usize {
    (2 * grains).next_power_of_two()
}

/// Files where a grain is. All threads do so at the same time; what is found later does not depend on their order. The slots, as many
/// as [`slots_for`] says, were zeros before.
#[inline(always)]
pub fn file(slots: &[AtomicU64], identifier: i32, index: u32) {
    let mut at = first_slot(identifier, slots.len());
    let new = entry(identifier, index);
    // As many looks as there are slots: there is a free one.
    for _ in 0..slots.len() {
        let free = slots[at].compare_exchange(0, new, Ordering::Relaxed, Ordering::Relaxed);
        if free.is_ok() {
            return;
        }
        at = (at + 1) & (slots.len() - 1);
    }
}

/// Where a grain was, if it was filed.
#[inline(always)]
pub fn find(slots: &[AtomicU64], identifier: i32) -> Option<usize> {
    let mut at = first_slot(identifier, slots.len());
    for _ in 0..slots.len() {
        let found = slots[at].load(Ordering::Relaxed);
        if found == 0 {
            return None;
        }
        if (found >> 32) as u32 == identifier as u32 {
            return Some((found as u32 - 1) as usize);
        }
        at = (at + 1) & (slots.len() - 1);
    }
    None
}

/// Pairs of the list before.
#[derive(Clone, Copy, Debug)]
pub struct PairsBefore<'a> {
    /// Row `k` is from `starts[k]` up to `starts[k + 1]`.
    pub starts: &'a [u32],
    /// Identifiers of the neighbours.
    pub partners: &'a [i32],
    /// States.
    pub states: &'a [u32],
    /// Histories.
    pub histories: &'a [f64],
}

/// The row of one grain in the new list.
#[derive(Debug)]
pub struct CarriedRow<'a> {
    /// Indices of the neighbours.
    pub neighbours: &'a [u32],
    /// Written: their identifiers.
    pub partners: &'a mut [i32],
    /// Written.
    pub states: &'a mut [u32],
    /// Written, `length` doubles each.
    pub histories: &'a mut [f64],
}

/// What is wrong with the row of grain `k`; 0 is nothing. That a pair is missing in a row which is wrong itself is told of that row.
#[inline(always)]
pub fn fault_of_row(k: usize, starts: &[u32], all_neighbours: &[u32], grains: usize) -> u32 {
    let row = |k: usize| all_neighbours.get(starts[k] as usize..starts[k + 1] as usize);
    let names_none = |k: usize, other: u32| other as usize >= grains || other as usize == k;
    let Some(own) = row(k) else {
        return WRONG_ROW;
    };
    if own.iter().any(|&other| names_none(k, other)) {
        return WRONG_NEIGHBOUR;
    }
    for (place, &other) in own.iter().enumerate() {
        if own[..place].contains(&other) {
            return NAMED_TWICE;
        }
        let other = other as usize;
        let Some(theirs) = (other + 1 < starts.len()).then(|| row(other)).flatten() else {
            continue;
        };
        let named = theirs.contains(&(k as u32));
        if !named && !theirs.iter().any(|&third| names_none(other, third)) {
            return HALF_LIST;
        }
    }
    0
}

/// Place of an entry of the list before, from the row of grain `k`, whose partner this is. Lists are often built in the same order: it is
/// looked for from `next` on, which becomes the place behind it.
#[inline(always)]
fn place(pairs: &PairsBefore<'_>, k: usize, partner: i32, next: &mut usize) -> Option<usize> {
    let (from, to) = (pairs.starts[k] as usize, pairs.starts[k + 1] as usize);
    let row = &pairs.partners[from..to];
    for look in 0..row.len() {
        let at = *next + look;
        let at = if at < row.len() { at } else { at - row.len() };
        if row[at] == partner {
            *next = if at + 1 < row.len() { at + 1 } else { 0 };
            return Some(from + at);
        }
    }
    None
}

/// Where the pair of two grains was remembered: in the row that kept it, of the one with the lower identifier if that had a row. Of pairs
/// that neither had nothing is remembered.
#[inline(always)]
fn place_before(
    slots: &[AtomicU64],
    pairs: &PairsBefore<'_>,
    own: Option<usize>,
    [identifier, partner]: [i32; 2],
    next: &mut usize,
) -> Option<usize> {
    let theirs = match own {
        Some(own) if identifier <= partner => return place(pairs, own, partner, next),
        _ => find(slots, partner),
    };
    match (theirs, own) {
        (Some(theirs), _) => place(pairs, theirs, identifier, &mut 0),
        (None, Some(own)) => place(pairs, own, partner, next),
        (None, None) => None,
    }
}

/// What is remembered of the pairs that the row of grain `k` keeps, of `owned` rows: how many these are. Where a grain is a neighbour of
/// another with two of its images, what each of them gets is of one of the two.
#[inline(always)]
pub fn carry_pairs(
    k: usize,
    owned: usize,
    slots: &[AtomicU64],
    pairs: &PairsBefore<'_>,
    identifiers: &[i32],
    length: usize,
    row: &mut CarriedRow<'_>,
) -> u32 {
    let own = find(slots, identifiers[k]);
    let (mut next, mut kept) = (0, 0);
    for (entry, &other) in row.neighbours.iter().enumerate() {
        let partner = identifiers[other as usize];
        row.partners[entry] = partner;
        let keeps = keeps(identifiers, owned, k, other as usize);
        kept += u32::from(keeps);
        let found = if keeps {
            place_before(slots, pairs, own, [identifiers[k], partner], &mut next)
        } else {
            None
        };
        let history = &mut row.histories[entry * length..(entry + 1) * length];
        match found {
            Some(at) => {
                row.states[entry] = pairs.states[at];
                history.copy_from_slice(&pairs.histories[at * length..(at + 1) * length]);
            }
            None => {
                row.states[entry] = 0;
                history.fill(0.0);
            }
        }
    }
    kept
}

/// The same of a grain and a wall.
#[inline(always)]
pub fn carry_wall(
    before: Option<usize>,
    states_before: &[u32],
    histories_before: &[f64],
    state: &mut u32,
    history: &mut [f64],
) {
    let length = history.len();
    match before {
        Some(k) => {
            *state = states_before[k];
            history.copy_from_slice(&histories_before[k * length..(k + 1) * length]);
        }
        None => {
            *state = 0;
            history.fill(0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filed(identifiers: &[i32]) -> Vec<AtomicU64> {
        let slots: Vec<AtomicU64> = (0..slots_for(identifiers.len()))
            .map(|_| AtomicU64::new(0))
            .collect();
        for (k, &identifier) in identifiers.iter().enumerate() {
            file(&slots, identifier, k as u32);
        }
        slots
    }

    #[test]
    fn a_grain_is_found_by_its_identifier() {
        let identifiers: Vec<i32> = (0..1000).map(|k| k * k - 7000).collect();
        let slots = filed(&identifiers);
        for (k, &identifier) in identifiers.iter().enumerate() {
            assert_eq!(find(&slots, identifier), Some(k));
        }
        assert_eq!(find(&slots, 3), None);
        assert_eq!(find(&filed(&[]), 3), None);
    }

    /// Before: grains 10, 20 and 30, and the ghost 40, which touches 30. Each pair is remembered by one row.
    const BEFORE: PairsBefore<'static> = PairsBefore {
        starts: &[0, 2, 3, 5],
        partners: &[20, 30, 10, 10, 40],
        states: &[0, 1, 0, 0, 1],
        histories: &[1.0, 2.0, 0.0, 0.0, 4.0],
    };

    /// What is remembered of the pairs of grain `k`, of `owned`, after lists with these identifiers: partners, states, histories, and how
    /// many pairs its row keeps.
    fn carried(
        k: usize,
        owned: usize,
        identifiers: &[i32],
        neighbours: &[u32],
    ) -> (Vec<i32>, Vec<u32>, Vec<f64>, u32) {
        let slots = filed(&[10, 20, 30]);
        let n = neighbours.len();
        let (mut partners, mut states, mut histories) = (vec![0; n], vec![7; n], vec![9.0; n]);
        let mut row = CarriedRow {
            neighbours,
            partners: &mut partners,
            states: &mut states,
            histories: &mut histories,
        };
        let kept = carry_pairs(k, owned, &slots, &BEFORE, identifiers, 1, &mut row);
        (partners, states, histories, kept)
    }

    /// In the order 30, 50, 10 all three are owned: the row of 10 keeps its pair with 30, and that of 30 the one with 50.
    #[test]
    fn what_is_remembered_follows_the_identifiers() {
        let identifiers = [30, 50, 10];
        let found = carried(2, 3, &identifiers, &[1, 0]);
        assert_eq!(found, (vec![50, 30], vec![0, 1], vec![0.0, 2.0], 2));
        let found = carried(0, 3, &identifiers, &[1, 2]);
        assert_eq!(found, (vec![50, 10], vec![0, 0], vec![0.0, 0.0], 1));
    }

    /// A ghost that becomes a grain of one's own, and a grain of one's own that becomes a ghost: another row keeps the pair then.
    #[test]
    fn what_another_row_has_kept_is_found() {
        let found = carried(0, 1, &[40, 30, 20], &[1, 2]);
        assert_eq!(found, (vec![30, 20], vec![1, 0], vec![4.0, 0.0], 2));
        let found = carried(0, 1, &[30, 10], &[1]);
        assert_eq!(found, (vec![10], vec![1], vec![2.0], 1));
    }

    #[test]
    fn what_is_wrong_with_a_row_is_found() {
        let fault = |k, starts: &[u32], neighbours: &[u32]| fault_of_row(k, starts, neighbours, 4);
        let starts = [0, 2, 4];
        assert_eq!(fault(0, &starts, &[1, 3, 0, 2]), 0);
        assert_eq!(fault(1, &starts, &[1, 3, 0, 2]), 0);
        assert_eq!(fault(1, &starts, &[1, 3, 1, 2]), WRONG_NEIGHBOUR);
        assert_eq!(fault(1, &starts, &[1, 3, 4, 2]), WRONG_NEIGHBOUR);
        assert_eq!(fault(0, &starts, &[1, 3, 3, 2]), HALF_LIST);
        assert_eq!(fault(0, &starts, &[3, 3, 0, 2]), NAMED_TWICE);
        // The other's row is wrong itself.
        assert_eq!(fault(0, &starts, &[1, 3, 4, 2]), 0);
        assert_eq!(fault(0, &[0, 2, 9], &[1, 3, 3, 2]), 0);
        assert_eq!(fault(1, &[0, 2, 5], &[1, 3, 0, 2]), WRONG_ROW);
        assert_eq!(fault(1, &[0, 2, 1], &[1, 3, 0, 2]), WRONG_ROW);
        assert_eq!(fault(1, &[0, 9, 4], &[1, 3, 0, 2]), WRONG_ROW);
    }
}
