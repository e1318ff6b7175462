// SPDX-License-Identifier: MIT OR Apache-2.0
//! From a fresh machine to real decks run, with a table and pictures of what they show.

mod chart;
mod contacts;
mod engine;
mod heap;
mod heaps;
mod material;
mod table;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::progress::{human_time, say};
use crate::{setup, workspace};

#[derive(clap::Args)]
pub struct Options {
    /// Where the table and the pictures go [default: demo-output in the checkout]
    #[arg(long)]
    output: Option<PathBuf>,
}

/// What the demo must leave behind.
const PICTURES: [&str; 5] = [
    "normal-force.svg",
    "tangential-force.svg",
    "collision.svg",
    "heap.svg",
    "heap-compared.svg",
];

pub fn demo(options: &Options) -> Result<()> {
    let output = match &options.output {
        Some(output) => output.clone(),
        None => workspace::root().join("demo-output"),
    };
    run(&output)
}

/// Runs every scene; the table goes to standard output and, with the pictures, to `output`.
pub fn run(output: &Path) -> Result<()> {
    let started = std::time::Instant::now();
    setup::setup()?;
    fs::create_dir_all(output).with_context(|| format!("cannot make {}", output.display()))?;
    let engine = engine::Engine::prepare(&output.join("data"))?;
    let ready = started.elapsed();
    if !engine.superellipsoid {
        say(format!(
            "LAMMPS {} has no granular/superellipsoid: it is left out",
            engine.release
        ));
    }
    let mut tables = vec![
        contacts::normal_force(&engine, output)?,
        contacts::tangential_force(&engine, output)?,
        contacts::collision(&engine, output)?,
    ];
    tables.extend(heaps::heaps(&engine, output)?);
    let mut text = format!(
        "## ellgran in LAMMPS {}\n\nReady after {}, everything run after {}.\n",
        engine.release,
        human_time(ready),
        human_time(started.elapsed())
    );
    for table in &tables {
        text += "\n";
        text += &table.markdown();
    }
    text += "\nPictures:\n\n";
    for picture in PICTURES {
        anyhow::ensure!(output.join(picture).is_file(), "no {picture} was drawn");
        text += &format!("![{picture}]({picture})\n");
    }
    fs::write(output.join("table.md"), &text)?;
    println!("{text}");
    say(format!("table and pictures are in {}", output.display()));
    Ok(())
}
