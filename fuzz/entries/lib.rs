// SPDX-License-Identifier: MIT OR Apache-2.0
//! Arbitrary bytes through the C interface. Each entry reads a scene from the bytes, within what the header demands of pointers and
//! lengths but with any numbers, and panics where the interface does not keep its word: an internal error, an error without
//! words, output of a call that failed, a number that is not finite from a call that succeeded.

pub mod chosen_pairs;
pub mod engine_walls;
pub mod histories;
pub mod motion;
pub mod neighbour_list;
pub mod one_contact;
mod scene;
pub mod walls;
pub mod words;

/// What an entry does with bytes.
pub type Entry = fn(&[u8]);

/// All entries, with the name of each in fuzz/seeds and of its program.
pub const ENTRIES: [(&str, Entry); 8] = [
    ("chosen_pairs", chosen_pairs::run),
    ("engine_walls", engine_walls::run),
    ("histories", histories::run),
    ("motion", motion::run),
    ("neighbour_list", neighbour_list::run),
    ("one_contact", one_contact::run),
    ("walls", walls::run),
    ("words", words::run),
];
