// SPDX-License-Identifier: MIT OR Apache-2.0
//! The larger example decks, run whole, with a shaded picture of each: grains, walls, and a colour that tells something.

use std::collections::HashMap;
use std::f64::consts::{FRAC_1_SQRT_2, PI};
use std::path::Path;
use std::time::Instant;

use anyhow::{ensure, Context, Result};

use super::engine::Engine;
use super::heap::Grain;
use super::scene::{Scene, Wall};
use super::table::Table;
use super::{deck, heap};
use crate::shapes::{add, compose, rotate, scale, Quaternion, Vector};
use crate::{dump, setup, workspace};

/// What the colour of a grain tells.
enum Colour {
    /// How high it was in the first frame.
    HeightAtStart,
    /// Its type, 1 or 2.
    Type,
    /// Its place in the order in which grains came.
    OrderOfPouring,
}

struct Deck {
    name: &'static str,
    colour: Colour,
    /// Of which step the picture is; default: the last of the dump.
    step: Option<u64>,
    /// Corners of what the picture shows.
    low: Vector,
    high: Vector,
    /// A quarter turn about z comes before all else, so that what lies along x lies along the line of sight.
    turned: bool,
    /// Whether the scene repeats along x and y, from `low` to `high`.
    periodic: bool,
}

const DECKS: [Deck; 8] = [
    Deck {
        name: "drum",
        colour: Colour::HeightAtStart,
        step: None,
        low: [-0.03, -0.0165, -0.03],
        high: [0.03, 0.0165, 0.03],
        turned: true,
        periodic: false,
    },
    Deck {
        name: "lifters",
        colour: Colour::HeightAtStart,
        // before the highest grains fall
        step: Some(17_000),
        low: [-0.03, -0.0165, -0.03],
        high: [0.03, 0.0165, 0.03],
        turned: true,
        periodic: false,
    },
    Deck {
        name: "hopper",
        colour: Colour::HeightAtStart,
        // the gate slides from step 10000 to 14000
        step: Some(16_000),
        low: [-0.03, -0.03, -0.08],
        high: [0.03, 0.03, 0.05],
        turned: false,
        periodic: false,
    },
    Deck {
        name: "heap",
        colour: Colour::OrderOfPouring,
        step: None,
        low: [-0.032, -0.032, -0.006],
        high: [0.032, 0.032, 0.024],
        turned: false,
        periodic: false,
    },
    Deck {
        name: "mixer",
        colour: Colour::Type,
        step: None,
        low: [-0.026, -0.026, 0.0],
        high: [0.026, 0.026, 0.036],
        turned: false,
        periodic: false,
    },
    Deck {
        name: "triaxial",
        colour: Colour::HeightAtStart,
        step: None,
        low: [-0.034, -0.034, -0.034],
        high: [0.018, 0.018, 0.018],
        turned: false,
        periodic: false,
    },
    Deck {
        name: "vibrated_bed",
        colour: Colour::HeightAtStart,
        step: None,
        low: [0.0, 0.0, -0.001],
        high: [0.03, 0.03, 0.03],
        turned: false,
        periodic: true,
    },
    Deck {
        name: "size_mixture",
        colour: Colour::Type,
        step: None,
        low: [0.0, 0.0, 0.0],
        high: [0.045, 0.045, 0.045],
        turned: false,
        periodic: true,
    },
];

/// The walls of a deck as they stand at `time`, before the turn of the picture.
fn walls(name: &str, time: f64) -> Result<Vec<Wall>> {
    let upright = |low: f64, high: f64| [[0.0, 0.0, low], [0.0, 0.0, high]];
    Ok(match name {
        // after the turn of the picture
        "drum" => vec![Wall::Shell {
            ends: [[0.0, -0.0165, 0.0], [0.0, 0.0165, 0.0]],
            radii: [0.03; 2],
        }],
        // after the turn of the picture
        "lifters" => vec![Wall::Triangles(lifters(time)?)],
        "triaxial" => vec![Wall::Floor(-0.034)],
        "hopper" => vec![
            // the gate, where it has slid to
            Wall::Triangles(plate(0.3 * (time - 0.2).clamp(0.0, 0.08))),
            Wall::Shell {
                ends: upright(0.0, 0.05),
                radii: [0.024; 2],
            },
            Wall::Shell {
                ends: upright(-0.02, 0.0),
                radii: [0.009, 0.024],
            },
            Wall::Floor(-0.08),
        ],
        "heap" => vec![Wall::Cylinder {
            ends: upright(-0.006, 0.0),
            radius: 0.03,
        }],
        "mixer" => vec![
            Wall::Shell {
                ends: upright(0.0, 0.036),
                radii: [0.025; 2],
            },
            Wall::Floor(0.0),
            Wall::Triangles(paddle(time)?),
        ],
        // amplitude and period of its `wiggle`, which begins with the second run
        "vibrated_bed" => vec![Wall::Floor(
            1e-3 * (1.0 - (2.0 * PI * (time - 10_000.0 * 2e-5) / 0.035).cos()),
        )],
        _ => vec![Wall::Floor(0.0)],
    })
}

/// The triangles of a mesh of the examples, in metres, each corner moved to its place.
fn mesh(file: &str, place: impl Fn(Vector) -> Vector) -> Result<Vec<[Vector; 3]>> {
    let path = workspace::root().join("examples/lammps").join(file);
    let mut stream = std::fs::File::open(&path)?;
    let mesh = stl_io::read_stl(&mut stream).with_context(|| format!("in {}", path.display()))?;
    let corner = |index: usize| {
        let vertex = mesh.vertices[index];
        place(scale(1e-3, [0, 1, 2].map(|k| f64::from(vertex[k]))))
    };
    Ok(mesh.faces.iter().map(|f| f.vertices.map(corner)).collect())
}

/// The paddle of the mixer: it turns twice a second about z once the grains have settled.
fn paddle(time: f64) -> Result<Vec<[Vector; 3]>> {
    let half = 0.5 * 4.0 * PI * (time - 8000.0 * 2e-5);
    let turn = [half.cos(), 0.0, 0.0, half.sin()];
    mesh("paddle.stl", |corner| {
        rotate(turn, add(corner, [0.0, 0.0, 0.009]))
    })
}

/// The drum with lifters, which turns about x once in 1.57 s, after the turn of the picture; the half behind, seen from within, and cut at the ends.
fn lifters(time: f64) -> Result<Vec<[Vector; 3]>> {
    let half = 0.5 * 2.0 * PI * time / 1.57;
    let about_x = [half.cos(), half.sin(), 0.0, 0.0];
    let quarter: Quaternion = [FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2];
    mesh("lifters.stl", |mut corner| {
        corner[0] = corner[0].clamp(-0.0165, 0.0165);
        rotate(quarter, rotate(about_x, corner))
    })
}

/// The top of the hopper's gate, when it has slid so far.
fn plate(way: f64) -> Vec<[Vector; 3]> {
    let corner = |x: f64, y: f64| [0.0115 * x + way, 0.0115 * y, -0.0202];
    let [a, b, c, d] = [
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ];
    vec![[a, b, c], [a, c, d]]
}

/// Runs each deck, or those with these names, and draws it.
pub fn decks(engine: &Engine, output: &Path, only: &[String]) -> Result<Table> {
    for name in only {
        let known = DECKS.map(|deck| deck.name);
        ensure!(
            known.contains(&name.as_str()),
            "--only {name}: the decks are {}",
            known.join(", ")
        );
    }
    setup::renderer().context("the pictures need the renderer")?;
    let mut table = Table::new(
        "Example decks on one core",
        &["deck", "grains", "seconds", "picture"],
    );
    let chosen = |deck: &&Deck| only.is_empty() || only.iter().any(|name| name == deck.name);
    for deck in DECKS.iter().filter(chosen) {
        let dump = engine.path(&format!("{}.dump", deck.name));
        let mut variables = vec![("dump", deck::text(&dump)?)];
        let file = match deck.name {
            "mixer" => Some("paddle.stl"),
            "lifters" => Some("lifters.stl"),
            _ => None,
        };
        let stl = file.map(|name| workspace::root().join("examples/lammps").join(name));
        if let Some(stl) = &stl {
            variables.push(("stl", deck::text(stl)?));
        }
        let begin = Instant::now();
        engine.run(&format!("{}.lmp", deck.name), deck.name, &variables)?;
        let seconds = begin.elapsed().as_secs_f64();
        let picture = format!("{}-deck.webp", deck.name);
        let grains = draw(deck, &dump, &output.join(&picture))?;
        table.row(vec![
            format!("{}.lmp", deck.name),
            grains.to_string(),
            format!("{seconds:.0}"),
            picture,
        ]);
    }
    Ok(table)
}

/// Draws a frame of the dump; how many grains there were.
fn draw(of: &Deck, path: &Path, picture: &Path) -> Result<usize> {
    let tables = heap::read_tables(path)?;
    let chosen = match of.step {
        Some(step) => tables.iter().find(|table| table.step == step),
        None => tables.last(),
    };
    let chosen = chosen.with_context(|| format!("no such step in {}", path.display()))?;
    let (mut grains, identifiers) = heap::frame(chosen, "id")?;
    let (values, most, quantity, written) = colours(of, &tables[0], &grains, &identifiers)?;
    for grain in &mut grains {
        if of.periodic {
            for k in 0..2 {
                let width = of.high[k] - of.low[k];
                grain.centre[k] = of.low[k] + (grain.centre[k] - of.low[k]).rem_euclid(width);
            }
        }
        if of.turned {
            turn(grain);
        }
    }
    Scene {
        low: of.low,
        high: of.high,
        walls: walls(of.name, chosen.step as f64 * 2e-5)?,
        quantity: quantity.into(),
        most,
        written,
    }
    .picture((&grains, &values), picture)?;
    Ok(grains.len())
}

/// The values of the grains from 0 on, the largest, what they are, and how the ends of the scale are written.
fn colours(
    of: &Deck,
    first: &dump::Table,
    grains: &[Grain],
    identifiers: &[f64],
) -> Result<(Vec<f64>, f64, &'static str, [String; 2])> {
    Ok(match of.colour {
        Colour::Type => (
            grains.iter().map(|g| f64::from(g.kind - 1)).collect(),
            1.0,
            "type",
            ["1".into(), "2".into()],
        ),
        Colour::OrderOfPouring => (
            identifiers.to_vec(),
            identifiers.iter().fold(1.0, |m: f64, &k| m.max(k)),
            "poured",
            ["first".into(), "last".into()],
        ),
        Colour::HeightAtStart => {
            let (first, first_identifiers) = heap::frame(first, "id")?;
            let heights: HashMap<u64, f64> = first
                .iter()
                .zip(first_identifiers)
                .map(|(grain, identifier)| (identifier as u64, grain.centre[2]))
                .collect();
            let low = heights.values().copied().fold(f64::INFINITY, f64::min);
            let high = heights.values().copied().fold(f64::NEG_INFINITY, f64::max);
            let values: Option<Vec<f64>> = identifiers
                .iter()
                .map(|&identifier| Some(heights.get(&(identifier as u64))? - low))
                .collect();
            ensure!(high > low, "{}: all grains began at one height", of.name);
            (
                values.context("a grain that was not there at the start")?,
                high - low,
                "start height",
                ["0".into(), format!("{:.0} mm", 1e3 * (high - low))],
            )
        }
    })
}

/// A quarter turn about z: x to y.
fn turn(grain: &mut Grain) {
    let quarter: Quaternion = [FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2];
    grain.centre = rotate(quarter, grain.centre);
    grain.attitude = compose(quarter, grain.attitude);
}
