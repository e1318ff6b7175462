// SPDX-License-Identifier: MIT OR Apache-2.0
//! The deck that the README shows, run as it is printed there.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

use super::engine::Engine;
use super::heap::{self, Picture};
use super::table::Table;
use crate::{pages, workspace};

pub fn first_deck(engine: &Engine, output: &Path) -> Result<Table> {
    let page = fs::read_to_string(workspace::root().join("README.md"))?;
    let decks = pages::blocks(&page, "lammps");
    let deck = decks
        .first()
        .context("README.md has no block of LAMMPS commands")?;
    let copy = engine.path("first-deck.lmp");
    fs::write(&copy, deck).with_context(|| format!("cannot write {}", copy.display()))?;
    engine.run_at(&copy, "first-deck", &[])?;
    let grains = heap::read_dump(&engine.path("grains.dump"))?;
    heap::draw(
        &output.join("first-deck.svg"),
        &format!("{} ellipsoids at rest in a closed box", grains.len()),
        &[Picture {
            caption: "the deck of the README, as printed".into(),
            grains,
        }],
        None,
    )?;
    // step, energies of translation and rotation, potential and dissipated energy, their sum, contacts
    let rows: Vec<[f64; 7]> = engine.columns("first-deck.log")?;
    let (first, last) = (rows[0], rows[rows.len() - 1]);
    let mut table = Table::new("The deck of the README", &["quantity", "value"]);
    let mut row = |name: &str, value: String| table.row(vec![name.to_string(), value]);
    row("touching pairs at the end", format!("{:.0}", last[6]));
    row(
        "energy in motion at the end, over that of the fall",
        format!("{:.1e}", (last[1] + last[2]) / (first[3] - last[3])),
    );
    row(
        "energy balance, drift over energy dissipated",
        format!("{:.1e}", (last[5] - first[5]).abs() / last[4]),
    );
    Ok(table)
}
