// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which contacts add to the load of a grain, and their sum.
//!
//! Each grain adds up its own contacts, in an order that its row gives: no atomic operation on loads is needed, and two runs give the same
//! bits, whatever numbers the candidates have.

use crate::candidates::{keeps, Candidate};
use crate::contacts::{comes_first, law_of_types};
use ellgran::contact::ContactForces;

/// Numbers of a [`Load`](crate::contacts::Load): force, then torque.
pub const COMPONENTS: usize = 6;

/// Numbers of a [`ContactLoad`].
pub const NUMBERS: usize = 9;

/// What a contact does to its two grains, world frame: the force on the second grain, the torque on the first about its centre, that on the
/// second about its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct ContactLoad {
    values: [f64; NUMBERS],
}

impl ContactLoad {
    /// Of a pair that does not touch.
    pub const NONE: ContactLoad = ContactLoad {
        values: [0.0; NUMBERS],
    };

    /// Its numbers.
    #[inline(always)]
    pub fn values(&self) -> [f64; NUMBERS] {
        self.values
    }
}

/// Which number of a [`ContactLoad`] is added to a component of the load of one of its grains, and whether it is taken away instead.
#[inline(always)]
fn part_of(is_first: bool, component: usize) -> (usize, bool) {
    let is_force = component < 3;
    let number = if is_force || is_first {
        component
    } else {
        component + 3
    };
    (number, is_force && is_first)
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

    /// The entry of the candidate `place` of those that row `k` keeps, and the other grain.
    #[inline(always)]
    fn kept(&self, k: usize, place: usize) -> (u32, usize) {
        let from = self.starts[k];
        let entry = from + self.places[from as usize + place];
        (entry, self.neighbours[entry as usize] as usize)
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

/// What tells which grain of a pair is the first, and which law they have.
#[derive(Clone, Copy, Debug)]
pub struct Names<'a> {
    /// Identifiers of all grains.
    pub identifiers: &'a [i32],
    /// Their types, counted from 1.
    pub types: &'a [u32],
    /// Number of types.
    pub type_count: u32,
}

/// Writes the candidates that the row of grain `k` keeps, which are `own`, and the terms of the grain, those first: how many terms there
/// are.
#[inline(always)]
pub fn terms_of_grain(
    k: usize,
    names: &Names<'_>,
    all: &Candidates<'_>,
    own: &mut [Candidate],
    terms: &mut [u32],
) -> usize {
    let (owned, identifiers) = (all.counts.len(), names.identifiers);
    let first = all.firsts[k] as usize;
    let mut count = 0;
    for candidate in own {
        let (entry, other) = all.kept(k, count);
        let is_first = comes_first(identifiers, k, other);
        let [i, j] = if is_first { [k, other] } else { [other, k] };
        *candidate = Candidate {
            grains: [i as u32, j as u32],
            entry,
            law: law_of_types(names.types[i], names.types[j], names.type_count) as u32,
        };
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
        if let Some(place) = theirs.find(|&p| all.kept(other, p).1 == k) {
            terms[count] = term(all.firsts[other] as usize + place, false);
            count += 1;
        }
    }
    count
}

/// A component of the load of a grain, from its terms; `contact` reads a number of a contact's load, by the contact's number and its own.
/// A device has one thread for each component.
#[inline(always)]
pub fn component_of_load(
    terms: &[u32],
    contact: impl Fn(usize, usize) -> f64,
    component: usize,
) -> f64 {
    let mut sum = 0.0;
    for &term in terms {
        let (number, away) = part_of(term & 1 == 0, component);
        let value = contact((term >> 1) as usize, number);
        sum += if away { -value } else { value };
    }
    sum
}
