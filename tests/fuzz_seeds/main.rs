// SPDX-License-Identifier: MIT OR Apache-2.0
//! The seeds of fuzz/, each input that once was a finding among them, through the same entries, on a stable compiler and on any machine;
//! and inputs with bytes of the seeds changed.
//!
//! `ELLGRAN_FUZZ_INPUTS` is the number of these for each entry (3000 without it), `ELLGRAN_FUZZ_SEED` what they are drawn from.

#![allow(unsafe_code)]

#[path = "../../fuzz/entries/lib.rs"]
mod entries;
#[allow(dead_code)]
#[path = "../support/shapes.rs"]
mod shapes;

use std::fs;
use std::path::{Path, PathBuf};

/// How many inputs are made from the seeds of an entry.
const CHANGED: u64 = 3000;
const SEED: u64 = 2013;

fn number(variable: &str, without: u64) -> u64 {
    std::env::var(variable).map_or(without, |n| n.parse().expect("a number"))
}

/// An input that is at work; it is said if that fails.
struct AtWork<'a>(&'a [u8]);

impl Drop for AtWork<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            println!("{:?}", self.0);
        }
    }
}

fn seeds(name: &str) -> Vec<PathBuf> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fuzz/seeds")
        .join(name);
    let mut files: Vec<_> = fs::read_dir(&directory)
        .unwrap_or_else(|e| panic!("{}: {e}", directory.display()))
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    assert!(files.len() > 3, "{}", directory.display());
    files
}

fn all_through(name: &str) {
    let (_, run) = entries::ENTRIES
        .into_iter()
        .find(|(entry, _)| *entry == name)
        .expect("an entry");
    let mut read = Vec::new();
    for file in seeds(name) {
        println!("{}", file.display());
        let bytes = fs::read(&file).unwrap();
        run(&bytes);
        read.push(bytes);
    }
    let mut random = shapes::Random(number("ELLGRAN_FUZZ_SEED", SEED));
    let mut below = |count: usize| random.between(0.0, count as f64) as usize % count;
    let inputs = number("ELLGRAN_FUZZ_INPUTS", CHANGED);
    for k in 0..inputs {
        let mut bytes = read[below(read.len())].clone();
        if bytes.is_empty() {
            continue;
        }
        for _ in 0..=below(8) {
            let place = below(bytes.len());
            bytes[place] = below(256) as u8;
        }
        if k % 1000 == 0 {
            println!("{name}: input {k} of {inputs}");
        }
        let at_work = AtWork(&bytes);
        run(at_work.0);
    }
}

macro_rules! tests {
    ($($name:ident)+) => {
        $(
            #[test]
            fn $name() {
                all_through(stringify!($name));
            }
        )+

        #[test]
        fn every_entry_is_tested() {
            let names = entries::ENTRIES.map(|(name, _)| name);
            assert_eq!(names.as_slice(), [$(stringify!($name)),+]);
        }
    };
}

tests! {
    chosen_pairs
    engine_walls
    histories
    motion
    neighbour_list
    one_contact
    walls
    words
}
