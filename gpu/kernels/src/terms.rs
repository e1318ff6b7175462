// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which contacts add to the load of a grain, and their sum.
//!
//! Each grain adds up its own contacts, in an order that its row gives: no atomic operation on loads is needed, and two runs give the same
//! bits, whatever numbers the candidates have.

use crate::candidates::{keeps, Candidate};
use crate::contacts::{comes_first, Load};
use ellgran::contact::ContactForces;
use ellgran::vector::Vector3;

/// What a contact does to its two grains; world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct ContactLoad {
    /// Force on the second grain.
    pub force: Vector3,
    /// Torque on the first grain about its centre.
    pub torque_i: Vector3,
    /// Torque on the second grain about its centre.
    pub torque_j: Vector3,
}

impl ContactLoad {
    /// Of a pair that does not touch.
    pub const NONE: ContactLoad = ContactLoad {
        force: Vector3::ZERO,
        torque_i: Vector3::ZERO,
        torque_j: Vector3::ZERO,
    };
}

impl From<ContactForces> for ContactLoad {
    #[inline(always)]
    fn from(f: ContactForces) -> Self {
        ContactLoad {
            force: f.force,
            torque_i: f.torque_i,
            torque_j: f.torque_j,
        }
    }
}

/// A candidate in the sum of a grain: its number, and whether the grain is the first of the pair.
#[inline(always)]
fn term(number: usize, is_first: bool) -> u32 {
    (number as u32) << 1 | u32::from(!is_first)
}

/// The candidates of all rows of a full neighbour list.
#[derive(Clone, Copy, Debug)]
pub struct Candidates<'a> {
    /// Row `k` is from `starts[k]` up to `starts[k + 1]`.
    pub starts: &'a [u32],
    /// Indices of the neighbours.
    pub neighbours: &'a [u32],
    /// Places in row `k` of those that it keeps, from `starts[k]` on.
    pub places: &'a [u32],
    /// The number of the first candidate of each row; the others of the row follow it.
    pub firsts: &'a [u32],
    /// How many candidates each row keeps.
    pub counts: &'a [u32],
}

impl Candidates<'_> {
    /// Neighbours of row `k`.
    #[inline(always)]
    fn row(&self, k: usize) -> &[u32] {
        &self.neighbours[self.starts[k] as usize..self.starts[k + 1] as usize]
    }

    /// The candidate `place` of those that row `k` keeps.
    #[inline(always)]
    fn candidate(&self, k: usize, place: usize) -> Candidate {
        let from = self.starts[k];
        let entry = from + self.places[from as usize + place];
        Candidate {
            grain: k as u32,
            other: self.neighbours[entry as usize],
            entry,
        }
    }
}

/// Numbers the candidates of some rows one after the other: `first` is the number of the first.
#[inline(always)]
pub fn number_rows(counts: &[u32], first: u32, firsts: &mut [u32]) {
    let mut next = first;
    for (first, count) in firsts.iter_mut().zip(counts) {
        *first = next;
        next += count;
    }
}

/// Writes the candidates that the row of grain `k` keeps, which are `own`, and the terms of the grain, those first: how many terms there
/// are.
#[inline(always)]
pub fn terms_of_grain(
    k: usize,
    identifiers: &[i32],
    all: &Candidates<'_>,
    own: &mut [Candidate],
    terms: &mut [u32],
) -> usize {
    let owned = all.counts.len();
    let first = all.firsts[k] as usize;
    let mut count = 0;
    for candidate in own {
        *candidate = all.candidate(k, count);
        let is_first = comes_first(identifiers, k, candidate.other as usize);
        terms[count] = term(first + count, is_first);
        count += 1;
    }
    for &other in all.row(k) {
        let other = other as usize;
        if keeps(identifiers, owned, k, other) {
            continue;
        }
        let mut theirs = 0..all.counts[other] as usize;
        // It comes first, as its row keeps the pair.
        if let Some(place) = theirs.find(|&p| all.candidate(other, p).other as usize == k) {
            terms[count] = term(all.firsts[other] as usize + place, false);
            count += 1;
        }
    }
    count
}

/// The load of a grain, from its terms.
#[inline(always)]
pub fn sum_of_terms(terms: &[u32], contacts: &[ContactLoad]) -> Load {
    let mut load = Load::NONE;
    for &term in terms {
        let contact = &contacts[(term >> 1) as usize];
        load += if term & 1 == 0 {
            Load {
                force: -contact.force,
                torque: contact.torque_i,
            }
        } else {
            Load {
                force: contact.force,
                torque: contact.torque_j,
            }
        };
    }
    load
}
