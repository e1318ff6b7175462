// SPDX-License-Identifier: MIT OR Apache-2.0
//! The collision and the settling through LIGGGHTS, beside its own superquadrics on the same decks.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result};

use super::contacts::impact;
use super::deck;
use super::heap::{self, Picture};
use super::table::Table;
use crate::chart::{self, Panel, Series, OURS, SUPERELLIPSOID};
use crate::{liggghts, workspace};

/// A choice of contact models and of the fix that makes walls of them.
struct Contender {
    name: &'static str,
    label: &'static str,
    model: &'static str,
    wall: &'static str,
    colour: plotters::style::RGBColor,
}

const CONTENDERS: [Contender; 2] = [
    Contender {
        name: "ellipsoid",
        label: "nfd, tfd, surface ellipsoid",
        model: "nfd tangential tfd surface ellipsoid",
        wall: "wall/gran/ellipsoid",
        colour: OURS,
    },
    Contender {
        name: "superquadric",
        label: "LIGGGHTS' own hertz, history, surface superquadric",
        model: "hertz tangential history surface superquadric",
        wall: "wall/gran",
        colour: SUPERELLIPSOID,
    },
];

pub struct Engine {
    binary: PathBuf,
    data: PathBuf,
}

impl Engine {
    /// Fetches and builds what is missing.
    pub fn prepare(data: &Path) -> Result<Self> {
        let binary = liggghts::binary()?;
        fs::create_dir_all(data)?;
        Ok(Engine {
            binary,
            data: data.canonicalize()?,
        })
    }

    fn run(&self, deck: &str, name: &str, variables: &[(&str, &str)]) -> Result<()> {
        let deck = workspace::root().join("examples/liggghts").join(deck);
        let mut command = Command::new(&self.binary);
        deck::run(&mut command, &deck, name, &self.data, variables)
    }
}

pub fn collision(engine: &Engine, output: &Path) -> Result<Table> {
    let mut table = Table::new(
        "An oblique collision of two ellipsoids of aspect ratio 2 with friction, 0.56 m/s",
        &[
            "contact models",
            "peak force (N)",
            "contact time (ms)",
            "kinetic energy kept",
        ],
    );
    let mut curves = Vec::new();
    for contender in &CONTENDERS {
        let name = format!("liggghts-collision-{}", contender.name);
        let data = engine.data.join(format!("{name}.dat"));
        engine.run(
            "collision.lig",
            &name,
            &[("model", contender.model), ("out", deck::text(&data)?)],
        )?;
        let rows: Vec<[f64; 3]> = deck::columns(&data)?;
        let (row, force) = impact(contender.label, &rows).context(name)?;
        table.row(row);
        curves.push(Series::curve(
            contender.label,
            force,
            contender.colour,
            false,
        ));
    }
    chart::draw(
        &output.join("liggghts-collision.svg"),
        "LIGGGHTS' own damping jumps in and pulls out; ours does not",
        &[vec![Panel::of_curves(
            "Two ellipsoids of aspect ratio 2, oblique, with friction",
            "time since touch (ms)",
            "force (N)",
            curves,
        )]],
    )?;
    Ok(table)
}

pub fn settling(engine: &Engine, output: &Path) -> Result<Table> {
    let mut table = Table::new(
        "Ellipsoids of aspect ratio 2 fall into a box of five planes",
        &[
            "contact models",
            "grains at first",
            "grains at the end",
            "mean height (mm)",
            "run time (s)",
        ],
    );
    let mut pictures: Vec<Picture> = Vec::new();
    for contender in &CONTENDERS {
        let name = format!("liggghts-settling-{}", contender.name);
        let dump = engine.data.join(format!("{name}.dump"));
        let started = Instant::now();
        engine.run(
            "settling.lig",
            &name,
            &[
                ("model", contender.model),
                ("wall", contender.wall),
                ("dump", deck::text(&dump)?),
            ],
        )?;
        let seconds = started.elapsed().as_secs_f64();
        let frames = heap::read_tables(&dump)?;
        let grains = heap::read_dump(&dump)?;
        let (first, last) = (frames[0].rows.len(), grains.len());
        let height = grains.iter().map(|grain| grain.centre[2]).sum::<f64>() / grains.len() as f64;
        table.row(vec![
            contender.label.to_string(),
            first.to_string(),
            last.to_string(),
            format!("{:.2}", 1e3 * height),
            format!("{seconds:.1}"),
        ]);
        let caption = format!("surface {}: {last} of {first} grains", contender.name);
        pictures.push(Picture { caption, grains });
    }
    heap::draw(
        &output.join("liggghts-heap.svg"),
        "LIGGGHTS: ellipsoids settled between five planes",
        &pictures,
        None,
    )?;
    Ok(table)
}
