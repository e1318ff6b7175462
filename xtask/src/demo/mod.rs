// SPDX-License-Identifier: MIT OR Apache-2.0
//! From a fresh machine to real decks run, with a table and pictures of what they show.

mod contacts;
mod deck;
mod decks;
mod engine;
mod first_deck;
mod heap;
mod heaps;
mod liggghts;
mod linear_spring;
pub mod material;
mod scene;
pub mod table;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};

use self::table::Table;
use crate::progress::{human_time, say};
use crate::{setup, workspace};

#[derive(clap::Args)]
pub struct Options {
    /// Which engine runs the decks
    #[arg(long, value_enum, default_value_t = Which::Lammps)]
    engine: Which,
    /// Instead of the short scenes, the larger example decks of LAMMPS, with a shaded picture of each: some six minutes
    #[arg(long, conflicts_with = "engine")]
    decks: bool,
    /// Of these decks the ones with these names alone, with commas between them
    #[arg(long, requires = "decks", value_delimiter = ',')]
    only: Vec<String>,
    /// Where the table and the pictures go [default: demo-output in the checkout]
    #[arg(long)]
    output: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
pub enum Which {
    Lammps,
    Liggghts,
}

/// What an engine's scenes gave.
struct Outcome {
    heading: String,
    tables: Vec<Table>,
    shaded: &'static [&'static str],
    pictures: &'static [&'static str],
}

pub fn demo(options: &Options) -> Result<()> {
    let output = match &options.output {
        Some(output) => output.clone(),
        None => workspace::root().join("demo-output"),
    };
    if options.decks {
        return example_decks(&output, &options.only);
    }
    run(options.engine, &output)
}

/// The larger example decks; the table goes to standard output, the pictures to `output`.
fn example_decks(output: &Path, only: &[String]) -> Result<()> {
    setup::setup()?;
    fs::create_dir_all(output).with_context(|| format!("cannot make {}", output.display()))?;
    let engine = engine::Engine::prepare(&output.join("data"))?;
    println!("{}", decks::decks(&engine, output, only)?.markdown());
    say(format!("pictures are in {}", output.display()));
    Ok(())
}

/// Runs every scene; the tables go to standard output and, with the pictures, to `output`.
pub fn run(which: Which, output: &Path) -> Result<()> {
    let started = Instant::now();
    setup::setup()?;
    fs::create_dir_all(output).with_context(|| format!("cannot make {}", output.display()))?;
    let (outcome, file) = match which {
        Which::Lammps => (lammps_scenes(output)?, "table.md"),
        Which::Liggghts => (liggghts_scenes(output)?, "liggghts-table.md"),
    };
    let mut text = format!("## {}\n", outcome.heading);
    for table in &outcome.tables {
        text += "\n";
        text += &table.markdown();
    }
    text += "\nPictures:\n\n";
    // Shaded ones are there where the renderer could be installed.
    for picture in outcome.shaded {
        if output.join(picture).is_file() {
            text += &format!("![{picture}]({picture})\n");
        }
    }
    for picture in outcome.pictures {
        anyhow::ensure!(output.join(picture).is_file(), "no {picture} was drawn");
        text += &format!("![{picture}]({picture})\n");
    }
    fs::write(output.join(file), &text)?;
    println!("{text}");
    say(format!(
        "table and pictures are in {}, after {}",
        output.display(),
        human_time(started.elapsed())
    ));
    Ok(())
}

fn lammps_scenes(output: &Path) -> Result<Outcome> {
    let engine = engine::Engine::prepare(&output.join("data"))?;
    if !engine.superellipsoid {
        say(format!(
            "LAMMPS {} has no granular/superellipsoid: it is left out",
            engine.release
        ));
    }
    let mut tables = vec![
        first_deck::first_deck(&engine, output)?,
        contacts::normal_force(&engine, output)?,
        contacts::tangential_force(&engine, output)?,
        contacts::collision(&engine, output)?,
        linear_spring::linear_spring(&engine, output)?,
    ];
    tables.extend(heaps::heaps(&engine, output)?);
    Ok(Outcome {
        heading: format!("ellgran in LAMMPS {}", engine.release),
        tables,
        shaded: &["heap.webp", "settling.webp"],
        pictures: &[
            "first-deck.svg",
            "normal-force.svg",
            "tangential-force.svg",
            "collision.svg",
            "linear-spring.svg",
            "heap.svg",
            "heap-compared.svg",
        ],
    })
}

fn liggghts_scenes(output: &Path) -> Result<Outcome> {
    let engine = liggghts::Engine::prepare(&output.join("data"))?;
    Ok(Outcome {
        heading: "ellgran in LIGGGHTS-PUBLIC 3.8.0".to_string(),
        tables: vec![
            liggghts::collision(&engine, output)?,
            liggghts::settling(&engine, output)?,
        ],
        shaded: &[],
        pictures: &["liggghts-collision.svg", "liggghts-heap.svg"],
    })
}
