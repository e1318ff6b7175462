// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does each fragment of a deck that a page prints run as it is printed?
//!
//! The page of the LIGGGHTS commands prints one deck that is whole. Every other fragment stands in it: what has a `pair_style` in
//! place of the deck's, the rest before the run.

use std::fs;

use crate::engines::printed::{all_blocks, page, Block};
use crate::harness::{execute, fresh_directory, last_lines, Engine};
use crate::meshes::sheet;

const PAGES: [&str; 3] = [
    "liggghts-patch/README.md",
    "README.md",
    "examples/liggghts/README.md",
];

/// Blocks of commands to LIGGGHTS. Those under *Syntax* are forms with words to be replaced.
fn is_fragment(block: &Block) -> bool {
    let shown = block.language == "text" && block.heading != "Syntax";
    let commands = ["surface ellipsoid", "property/global", "wall/gran"];
    let has = |words: &&str| block.text.contains(words);
    block.language == "liggghts" || (shown && commands.iter().any(has))
}

fn fragments() -> Vec<(String, String)> {
    let mut found = Vec::new();
    for name in PAGES {
        for block in all_blocks(&page(name)).into_iter().filter(is_fragment) {
            found.push((name.to_owned(), block.text));
        }
    }
    found
}

/// The whole deck with a fragment in it.
fn with(whole: &str, fragment: &str) -> String {
    let (before, pair_style, after) = {
        let at = whole.find("pair_style").expect("pair_style");
        let end = at + whole[at..].find('\n').unwrap() + 1;
        (&whole[..at], &whole[at..end], &whole[end..])
    };
    let (set_up, run) = after.split_at(after.find("run ").expect("run"));
    // Meshes that the fragment's walls name, if it does not make them itself.
    let words: Vec<&str> = fragment.split_whitespace().collect();
    let named = words.iter().skip_while(|word| **word != "meshes").nth(1);
    let mesh = named.filter(|name| !fragment.contains(&format!("file {name}.stl")));
    let mesh = mesh.map_or(String::new(), |name| {
        format!("fix {name} all mesh/surface file {name}.stl type 1\n")
    });
    // A fragment with an integrator has it in place of the deck's.
    let integrator = "fix move all nve/superquadric\n";
    assert!(set_up.contains(integrator));
    let set_up = if fragment.contains(" nve/") {
        set_up.replace(integrator, "")
    } else {
        set_up.to_owned()
    };
    if !fragment.contains("pair_style") {
        return format!("{before}{pair_style}{set_up}{mesh}{fragment}{run}");
    }
    let deck = format!("{before}{mesh}{fragment}{set_up}{run}");
    if !fragment.contains("surface default") {
        return deck;
    }
    // Spheres, for the models of spheres.
    deck.replace("superquadric", "sphere")
        .replace("set group all blockiness 2 2\n", "")
        .replace("shape 0.004 0.002 0.002", "diameter 0.004")
}

#[test]
fn every_printed_fragment_runs() {
    let engine = Engine::from_environment();
    let fragments = fragments();
    let (whole, parts): (Vec<_>, Vec<_>) = fragments
        .iter()
        .partition(|(_, text)| text.contains("create_box"));
    assert_eq!(whole.len(), 1, "decks that are whole");
    let whole = &whole[0].1;
    // pair styles, a friction without viscosities, dumps, walls and a setting of the neighbour lists; the wall of the README
    assert!(parts.len() >= 8, "{} fragments", parts.len());
    let decks = parts.iter().map(|(name, part)| (name, with(whole, part)));
    let first = (&PAGES[0].to_owned(), whole.clone());
    for (number, (name, deck)) in std::iter::once(first).chain(decks).enumerate() {
        if deck.contains("/vtk") && crate::vtk::headers().is_none() {
            continue;
        }
        let directory = fresh_directory(&number.to_string());
        for mesh in ["hull", "drum", "lid", "hopper"] {
            let above = format!(" {}\n", if mesh == "lid" { 1e-2 } else { -1.9e-3 });
            let sheet = sheet(1).replace("6e-2", "1.5e-2").replace(" 0\n", &above);
            fs::write(directory.join(format!("{mesh}.stl")), sheet).unwrap();
        }
        let (success, output) = execute(&engine, &directory, &deck, 1);
        assert!(success, "{name}:\n{deck}\n{}", last_lines(&output));
        let rows = crate::harness::thermo_rows(&output);
        let (first, last) = (&rows[0], rows.last().expect("rows"));
        println!("{name}, {number}: kinetic energy {:e}", last["KinEng"]);
        assert_eq!((first["Step"], last["Step"]), (0.0, 100.0), "{deck}");
        assert!(last["KinEng"] > 0.0, "the grains do not touch:\n{deck}");
    }
}
