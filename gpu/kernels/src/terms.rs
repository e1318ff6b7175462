// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which contacts add to the load of a grain, and their sum.
//!
//! Each grain adds up its own contacts, in an order that its row gives: no atomic operation on loads is needed, and two runs give the same
//! bits, whatever numbers the candidates have.

use crate::candidates::{keeps, Candidate};
use crate::contacts::comes_first;
use ellgran::contact::ContactForces;

/// Numbers of a [`Load`](crate::contacts::Load): force, then torque.
pub const COMPONENTS: usize = 6;

/// What a contact does to its two grains, world frame: the force on the second grain, the torque on the first about its centre, that on the
/// second about its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct ContactLoad {
    values: [f64; 9],
}

impl ContactLoad {
    /// Of a pair that does not touch.
    pub const NONE: ContactLoad = ContactLoad { values: [0.0; 9] };

    /// What it adds to a component of the load of one of its grains.
    #[inline(always)]
    fn component(&self, is_first: bool, component: usize) -> f64 {
        let is_force = component < 3;
        let value = self.values[if is_force || is_first {
            component
        } else {
            component + 3
        }];
        if is_force && is_first {
            -value
        } else {
            value
        }
    }
}

impl From<ContactForces> for ContactLoad {
    #[inline(always)]
    fn from(f: ContactForces) -> Self {
        let (force, i, j) = (f.force, f.torque_i, f.torque_j);
        ContactLoad {
            values: [force.x, force.y, force.z, i.x, i.y, i.z, j.x, j.y, j.z],
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

/// A component of the load of a grain, from its terms. A device has one thread for each: those of a grain read a contact side by side.
#[inline(always)]
pub fn component_of_load(terms: &[u32], contacts: &[ContactLoad], component: usize) -> f64 {
    let mut sum = 0.0;
    for &term in terms {
        sum += contacts[(term >> 1) as usize].component(term & 1 == 0, component);
    }
    sum
}
