// SPDX-License-Identifier: MIT OR Apache-2.0
//! How often what was done, for tests to read.

use std::sync::atomic::{AtomicU64, Ordering};

/// What is counted; the numbers are those that a test asks for.
#[derive(Clone, Copy)]
#[repr(u32)]
pub enum What {
    Allocations = 0,
    Frees = 1,
    Launches = 2,
    BytesIn = 3,
    BytesOut = 4,
    BytesWithin = 5,
    OnDefaultStream = 6,
    Waits = 7,
}

const KINDS: usize = 8;

static TALLIES: [AtomicU64; KINDS] = [const { AtomicU64::new(0) }; KINDS];

pub fn add(what: What, amount: usize) {
    TALLIES[what as usize].fetch_add(amount as u64, Ordering::Relaxed);
}

/// How often; [`What`] has the numbers.
#[allow(unsafe_code)]
// SAFETY: no other library has this name.
#[no_mangle]
pub extern "C" fn ellgran_stand_in_tally(what: u32) -> u64 {
    TALLIES
        .get(what as usize)
        .map_or(u64::MAX, |tally| tally.load(Ordering::Relaxed))
}
