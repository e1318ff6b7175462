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

/// The candidates of all rows.
#[derive(Clone, Copy, Debug)]
pub struct AllCandidates<'a> {
    /// By their numbers.
    pub candidates: &'a [Candidate],
    /// The number of the first candidate of each row; the others of the row follow it.
    pub firsts: &'a [u32],
    /// How many candidates each row keeps.
    pub counts: &'a [u32],
}

impl AllCandidates<'_> {
    /// Numbers of those of a row.
    #[inline(always)]
    fn of_row(&self, k: usize) -> core::ops::Range<usize> {
        let first = self.firsts[k] as usize;
        first..first + self.counts[k] as usize
    }
}

/// Writes the terms of grain `k`, those that its row keeps first: how many there are.
#[inline(always)]
pub fn terms_of_grain(
    k: usize,
    identifiers: &[i32],
    row: &[u32],
    all: &AllCandidates<'_>,
    terms: &mut [u32],
) -> usize {
    let owned = all.counts.len();
    let neighbour = |number: usize| all.candidates[number].other as usize;
    let mut count = 0;
    for number in all.of_row(k) {
        terms[count] = term(number, comes_first(identifiers, k, neighbour(number)));
        count += 1;
    }
    for &other in row {
        let other = other as usize;
        if keeps(identifiers, owned, k, other) {
            continue;
        }
        // It comes first, as its row keeps the pair.
        if let Some(number) = all.of_row(other).find(|&number| neighbour(number) == k) {
            terms[count] = term(number, false);
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
