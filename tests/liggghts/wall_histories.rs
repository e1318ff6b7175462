// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a wall remembers of its contacts: does LIGGGHTS warn of it?

use std::fs;

use crate::harness::{fresh_directory, run_in, Engine};
use crate::mesh_ranks::{on_a_sheet, sheet_deck};
use crate::meshes::sheet;

#[test]
fn no_warning_comes_of_it() {
    let engine = Engine::from_environment();
    for (name, wall) in [
        ("plane", "primitive type 1 zplane 0.0"),
        ("cylinder", "primitive type 1 xcylinder 0.08 0.0 0.08"),
        ("mesh", "mesh n_meshes 1 meshes sheet"),
    ] {
        for ranks in [1, 2] {
            let directory = fresh_directory(&format!("{name}_{ranks}"));
            fs::write(directory.join("sheet.stl"), sheet(8)).unwrap();
            let mut deck = sheet_deck();
            deck.steps = 20;
            deck.walls = vec![wall.into()];
            let outcome = run_in(&engine, &directory, &on_a_sheet(), &deck, ranks);
            let warnings: Vec<&str> = outcome
                .output
                .lines()
                .filter(|line| line.contains("WARNING"))
                .collect();
            assert!(warnings.is_empty(), "{name}, {ranks} ranks: {warnings:?}");
        }
    }
}
