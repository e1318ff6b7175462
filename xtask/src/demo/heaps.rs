// SPDX-License-Identifier: MIT OR Apache-2.0
//! The scenes of many grains: settling in a box, and on the same floor under each pair style.

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};

use super::deck;
use super::engine::Engine;
use super::heap::{self, Grain, Picture};
use super::material::Material;
use super::scene::{self, Frame, Scene, Wall};
use super::table::Table;
use crate::progress::say;
use crate::setup;

/// Softer than the grains of the collision, so that some ten thousand steps settle them.
const MATERIAL: Material = Material {
    youngs_modulus: 2e6,
    poissons_ratio: 0.3,
    viscosity: 100.0,
    density: 2500.0,
    friction: 0.5,
};
/// Grains of heap.lmp, and spheres of their volume.
const SEMI_AXES: [f64; 3] = [1.5874e-3, 0.7937e-3, 0.7937e-3];
const FALLING: i32 = 1;
const FROZEN: i32 = 2;
/// Floor area of heap.lmp.
const AREA: f64 = 16e-3 * 16e-3;

pub fn heaps(engine: &Engine, output: &Path) -> Result<Vec<Table>> {
    let in_box = settle_in_box(engine, output)?;
    let on_floor = settle_on_floor(engine, output)?;
    Ok(vec![in_box, on_floor])
}

/// The example deck: walls, friction, viscosity.
fn settle_in_box(engine: &Engine, output: &Path) -> Result<Table> {
    let dump = engine.path("settling.dump");
    let data = engine.path("settling.dat");
    engine.run(
        "settling.lmp",
        "settling",
        &[("dump", deck::text(&dump)?), ("out", deck::text(&data)?)],
    )?;
    // time kinetic rotation elastic gravity dissipated sum contacts floor_force
    let rows: Vec<[f64; 9]> = engine.columns("settling.dat")?;
    let (first, last) = (rows[0], rows[rows.len() - 1]);
    let grains = heap::read_dump(&dump)?;
    let weight: f64 = grains
        .iter()
        .map(|grain| 2500.0 * 9.81 * grain.volume())
        .sum();
    let mut table = Table::new(
        &format!("{} ellipsoids settled in a box", grains.len()),
        &["quantity", "value"],
    );
    let mut row = |name: &str, value: String| table.row(vec![name.to_string(), value]);
    row("time simulated (s)", format!("{:.2}", last[0]));
    row(
        "energy in motion at the end (J)",
        format!("{:.2e}", last[1] + last[2]),
    );
    row("energy dissipated (J)", format!("{:.4e}", last[5]));
    row(
        "energy balance, drift over energy dissipated",
        format!("{:.1e}", (last[6] - first[6]).abs() / last[5]),
    );
    row(
        "contacts per grain",
        format!("{:.2}", 2.0 * last[7] / grains.len() as f64),
    );
    row(
        "force on the floor over weight (walls carry the rest)",
        format!("{:.3}", last[8] / weight),
    );
    heap::draw(
        &output.join("heap.svg"),
        &format!(
            "{} viscoelastic ellipsoids with friction, settled",
            grains.len()
        ),
        &[Picture {
            caption: "gran/ellipsoid and wall/gran/ellipsoid".into(),
            grains,
        }],
        None,
    )?;
    match setup::renderer() {
        Ok(()) => rendered(&dump, output)?,
        Err(why) => say(format!("no shaded pictures, only plain ones: {why:#}")),
    }
    Ok(table)
}

/// The heap and its making, shaded, coloured by the pressure that the contacts put on each grain.
fn rendered(dump: &Path, output: &Path) -> Result<()> {
    let frames = heap::read_frames(dump, "v_pressure")?;
    let (low, high) = scene::box_of(dump)?;
    let mut scene = Scene {
        low,
        high,
        walls: vec![Wall::OpenBox],
        quantity: "pressure".into(),
        most: 500.0,
        written: ["0".into(), "0.5 kPa".into()],
    };
    let frames: Vec<Frame> = frames
        .iter()
        .map(|(grains, pressures)| (grains.as_slice(), pressures.as_slice()))
        .collect();
    scene.animation(&frames, &output.join("settling.webp"))?;
    // The walls of the picture end where there is nothing more to see.
    let last = frames[frames.len() - 1];
    scene.high[2] = low[2] + (high[0] - low[0]);
    scene.picture(last, &output.join("heap.webp"))
}

/// The same fall under each pair style, on a floor of frozen grains.
fn settle_on_floor(engine: &Engine, output: &Path) -> Result<Table> {
    let mass = MATERIAL.mass(4.0 / 3.0 * std::f64::consts::PI * SEMI_AXES.iter().product::<f64>());
    // Of spheres of 1 mm at 1 % overlap.
    let contact_radius = (0.5f64 * 1e-3 * 1e-5).sqrt();
    let mut runs = vec![(
        "heap-ellgran",
        "gran/ellipsoid",
        "ellipsoid",
        "gran/ellipsoid",
        MATERIAL.with_friction(&MATERIAL.viscoelastic()),
    )];
    if engine.superellipsoid {
        runs.push((
            "heap-superellipsoid",
            "granular/superellipsoid, fitted constants",
            "superellipsoid",
            "granular/superellipsoid",
            MATERIAL.superellipsoid(Some(mass), MATERIAL.friction, contact_radius),
        ));
    }
    runs.push((
        "heap-granular",
        "granular, spheres of the same volume",
        "sphere",
        "granular",
        MATERIAL.granular(Some(mass), MATERIAL.friction),
    ));
    let mut table = Table::new(
        "The same fall under each pair style, on a floor of frozen grains",
        &[
            "pair style",
            "solid fraction",
            "mean height (mm)",
            "energy in motion (J)",
            "run time (s)",
        ],
    );
    let mut pictures: Vec<Picture> = Vec::new();
    for (name, label, atoms, style, law) in &runs {
        let stem = engine.path(name);
        let started = Instant::now();
        engine.run(
            "compare/heap.lmp",
            name,
            &[
                ("atoms", atoms),
                ("style", style),
                ("law", law),
                ("output", deck::text(&stem)?),
            ],
        )?;
        let seconds = started.elapsed().as_secs_f64();
        let grains = heap::read_dump(&engine.path(&format!("{name}.dump")))?;
        let energy: Vec<[f64; 2]> = engine.columns(&format!("{name}.txt"))?;
        let packing = packing(&grains).context("no falling grains in the dump")?;
        table.row(vec![
            label.to_string(),
            format!("{:.3}", packing.solid_fraction),
            format!("{:.2}", 1e3 * packing.mean_height),
            format!("{:.1e}", energy[energy.len() - 1][1]),
            format!("{seconds:.1}"),
        ]);
        let caption = label.to_string();
        pictures.push(Picture { caption, grains });
    }
    heap::draw(
        &output.join("heap-compared.svg"),
        "The same fall under each pair style: ellipsoids lie flat and close, spheres of their volume stand higher",
        &pictures,
        Some(FROZEN),
    )?;
    Ok(table)
}

struct Packing {
    solid_fraction: f64,
    mean_height: f64,
}

/// Between the heights of the first and the last tenth of the grains, so that floor and surface do not count.
fn packing(grains: &[Grain]) -> Option<Packing> {
    let mut falling: Vec<&Grain> = grains.iter().filter(|g| g.kind == FALLING).collect();
    if falling.len() < 10 {
        return None;
    }
    falling.sort_by(|a, b| a.centre[2].total_cmp(&b.centre[2]));
    let (low, high) = (falling.len() / 10, falling.len() - 1 - falling.len() / 10);
    let volume: f64 = falling[low..high].iter().map(|grain| grain.volume()).sum();
    let height = falling[high].centre[2] - falling[low].centre[2];
    let mean = falling.iter().map(|g| g.centre[2]).sum::<f64>() / falling.len() as f64;
    Some(Packing {
        solid_fraction: volume / (AREA * height),
        mean_height: mean,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_of_known_packing() {
        // One grain of volume v a layer of height h.
        let radius = 1e-3;
        let grains: Vec<Grain> = (0..100)
            .map(|k| Grain {
                kind: FALLING,
                centre: [0.0, 0.0, 1e-4 * k as f64],
                semi_axes: [radius; 3],
                attitude: [1.0, 0.0, 0.0, 0.0],
            })
            .collect();
        let found = packing(&grains).unwrap();
        let expected = grains[0].volume() / (AREA * 1e-4);
        assert!((found.solid_fraction / expected - 1.0).abs() < 1e-12);
        assert!((found.mean_height - 4.95e-3).abs() < 1e-12);
        assert!(packing(&grains[..5]).is_none());
    }
}
