// SPDX-License-Identifier: MIT OR Apache-2.0
//! The deck that the README shows.

// Each test target takes what it needs.
#![allow(dead_code)]

use std::fs;
use std::path::Path;

/// As it is printed.
pub fn deck() -> String {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md");
    let page = fs::read_to_string(page).expect("README.md");
    let (_, rest) = page.split_once("\n```lammps\n").expect("a deck");
    let (deck, _) = rest.split_once("```").expect("the end of the deck");
    deck.to_string()
}

/// Without its line that loads the plugin, for LAMMPS that finds the plugin by itself.
pub fn deck_without_plugin() -> String {
    let deck = deck();
    let kept: Vec<&str> = deck
        .lines()
        .filter(|line| !line.starts_with("plugin load"))
        .collect();
    assert_eq!(kept.len() + 1, deck.lines().count(), "one plugin load");
    kept.join("\n") + "\n"
}
