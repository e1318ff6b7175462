// SPDX-License-Identifier: MIT OR Apache-2.0
//! The collision and the settling through LIGGGHTS, beside its own superquadrics on the same decks.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result};

use super::chart::{self, Curve, Panel, OURS, SUPERELLIPSOID};
use super::deck;
use super::heap::{self, Grain, Picture};
use super::table::Table;
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
        let contact: Vec<&[f64; 3]> = rows.iter().filter(|row| row[1] > 0.0).collect();
        let (Some(first), Some(last)) = (contact.first(), contact.last()) else {
            anyhow::bail!("{name}: the grains missed each other");
        };
        let peak = contact.iter().map(|row| row[1]).fold(0.0, f64::max);
        table.row(vec![
            contender.label.to_string(),
            format!("{peak:.3}"),
            format!("{:.3}", 1e3 * (last[0] - first[0])),
            format!("{:.4}", rows[rows.len() - 1][2] / rows[0][2]),
        ]);
        curves.push(Curve {
            label: contender.label.to_string(),
            points: contact
                .iter()
                .map(|row| (1e3 * (row[0] - first[0]), row[1]))
                .collect(),
            colour: contender.colour,
            dashed: false,
        });
    }
    chart::draw(
        &output.join("liggghts-collision.svg"),
        "LIGGGHTS' own damping jumps in and pulls out; ours does not",
        &[Panel {
            title: "Two ellipsoids of aspect ratio 2, oblique, with friction".into(),
            x_label: "time since touch (ms)".into(),
            y_label: "force (N)".into(),
            curves,
        }],
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
    let mut heaps: Vec<(String, Vec<Grain>)> = Vec::new();
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
        let counts = grain_counts(&fs::read_to_string(&dump)?);
        let (first, last) = (
            counts.first().context("the dump holds no frame")?,
            counts.last().context("the dump holds no frame")?,
        );
        let grains = heap::read_dump(&dump)?;
        let height = grains.iter().map(|grain| grain.centre[2]).sum::<f64>() / grains.len() as f64;
        table.row(vec![
            contender.label.to_string(),
            first.to_string(),
            last.to_string(),
            format!("{:.2}", 1e3 * height),
            format!("{seconds:.1}"),
        ]);
        heaps.push((
            format!("surface {}: {last} of {first} grains", contender.name),
            grains,
        ));
    }
    let pictures: Vec<Picture> = heaps
        .iter()
        .map(|(caption, grains)| Picture {
            caption: caption.clone(),
            grains,
        })
        .collect();
    heap::draw(
        &output.join("liggghts-heap.svg"),
        "LIGGGHTS: ellipsoids settled between five planes",
        &pictures,
        None,
    )?;
    Ok(table)
}

/// How many grains each frame of a dump holds.
fn grain_counts(dump: &str) -> Vec<usize> {
    dump.split("ITEM: NUMBER OF ATOMS\n")
        .skip(1)
        .filter_map(|frame| frame.lines().next()?.trim().parse().ok())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::grain_counts;

    #[test]
    fn every_frame_is_counted() {
        let text = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n95\nITEM: BOX BOUNDS\nITEM: TIMESTEP\n9\nITEM: NUMBER OF ATOMS\n93\n";
        assert_eq!(grain_counts(text), [95, 93]);
    }
}
