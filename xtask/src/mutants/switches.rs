// SPDX-License-Identifier: MIT OR Apache-2.0
//! Part of the copy of the library that holds all mutants: which of them is on. `cargo xtask mutants` adds this file to the copy.
//!
//! `ELLGRAN_MUTANT=place:choice` turns one of them on. With `ELLGRAN_MUTANTS_SEEN=file` each place that is reached, and each
//! mutant that gives another value there, is written to the file once.

#![allow(unsafe_code)]

use std::fs::File;
use std::io::Write;
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::sync::atomic::{AtomicU64, AtomicU8, Ordering::Relaxed};
use std::sync::Mutex;

const PLACES: usize = PLACES_OF_THE_COPY;

/// Of a place whose mutants are being watched; no place has as many mutants.
const WATCHED: u8 = 255;

/// The mutant of each place that is on, 0 for none. A byte at a fixed address: a place costs one comparison.
static STATE: [AtomicU8; PLACES] = [const { AtomicU8::new(0) }; PLACES];
/// Bit 0: reached. The others: another value was seen.
static SEEN: [AtomicU64; PLACES] = [const { AtomicU64::new(0) }; PLACES];
static OUTPUT: Mutex<Option<File>> = Mutex::new(None);

/// Runs before `main`, so that no place has to ask whether the environment was read.
#[used]
#[link_section = ".init_array"]
static START: extern "C" fn() = start;

extern "C" fn start() {
    if let Ok(chosen) = std::env::var("ELLGRAN_MUTANT") {
        let (place, choice) = chosen.split_once(':').expect("place:choice");
        let place: usize = place.parse().expect("a place");
        STATE[place].store(choice.parse().expect("a choice"), Relaxed);
    } else if let Ok(name) = std::env::var("ELLGRAN_MUTANTS_SEEN") {
        let file = File::create(name).expect("a file that can be written");
        *OUTPUT.lock().expect("no other thread") = Some(file);
        for state in &STATE {
            state.store(WATCHED, Relaxed);
        }
    }
}

/// Which mutant is on here; `WATCHED` is for [`compare`].
#[inline(always)]
pub fn at(place: usize) -> u8 {
    STATE[place].load(Relaxed)
}

/// Which mutant is on here, where reaching the place is all that can be seen.
#[inline(always)]
pub fn choice(place: usize) -> u8 {
    let state = STATE[place].load(Relaxed);
    if state == WATCHED {
        note(place, 0);
        STATE[place].store(0, Relaxed);
        return 0;
    }
    state
}

/// The value of the original, having looked whether the mutants give another one.
#[cold]
pub fn compare<V>(place: usize, choices: &[u8], original: V, mutated: impl Fn(u8) -> V) -> V {
    note(place, 0);
    let mut all = true;
    for choice in choices {
        if SEEN[place].load(Relaxed) & (1 << choice) == 0 {
            // A mutant that panics differs.
            let differs = catch_unwind(AssertUnwindSafe(|| {
                let value = mutated(*choice);
                bytes(&value) != bytes(&original)
            }));
            if differs.unwrap_or(true) {
                note(place, *choice);
            } else {
                all = false;
            }
        }
    }
    if all {
        STATE[place].store(0, Relaxed);
    }
    original
}

/// Numbers without a comparison of their own have bytes. What pads them may differ: then a mutant is tried for nothing.
fn bytes<V>(value: &V) -> &[u8] {
    // SAFETY: reads the value itself.
    // SAFETY: a value that is borrowed has as many bytes as its type. Those that pad it are looked at in the copy alone, where no result but
    // "tried for nothing" follows from them.
    unsafe { std::slice::from_raw_parts((value as *const V).cast(), std::mem::size_of::<V>()) }
}

#[cold]
fn note(place: usize, choice: u8) {
    let bit = 1 << choice;
    if SEEN[place].fetch_or(bit, Relaxed) & bit == 0 {
        let mut output = OUTPUT.lock().unwrap_or_else(|e| e.into_inner());
        if let Some(file) = output.as_mut() {
            writeln!(file, "{place}:{choice}").expect("a file that can be written");
        }
    }
}
