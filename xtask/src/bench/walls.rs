// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a wall costs in LAMMPS: a layer of grains on it, and high above it, beside the same grains without a wall and beside the pairs of a
//! dense packing, in turns, on one core.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

use super::contender::Contender;
use super::lammps_run::{path_word, quiet_step, timing, touching, Lammps};
use super::packing::{Kind, Packing};
use super::scenes::run_variables;
use super::statistics::{short, Measured};
use super::Effort;
use crate::demo::table::Table;
use crate::progress::Progress;

/// Far above the wall, m: many grains.
const FAR: &str = "0.02";
/// Squares of two triangles along a side of a mesh, and their size, m: five of the grains' short axes.
const SQUARES: usize = 41;
const SQUARE: f64 = 0.008;
/// Two floors of larger squares, the same under the layer: one as large as it, and one a thousand times as large.
const FEW: usize = 7;
const MANY: usize = 224;
const LARGE_SQUARE: f64 = SQUARE * SQUARES as f64 / FEW as f64;

/// Layers of a bed, and walls under it in the same place: what one more takes, the grains of which touch others too.
const LAYERS: usize = 2;
const FLOORS: [usize; 2] = [1, 3];
const BEDS: [&str; 3] = ["plane", "cylinder", "mesh"];

/// Parts of a run, of which the quiet ones count.
const INTERVALS: usize = 25;

/// A layer, by the words of the deck.
#[derive(Clone, Copy, PartialEq)]
struct Case {
    surface: &'static str,
    far: bool,
    /// Whether the fix sums up what contacts store and dissipate, as it does where a compute asks for that.
    energies: bool,
}

/// Faces of the closed mesh.
const FACES: usize = 6;

const CASES: [Case; 15] = [
    on("none", false),
    on("plane", false),
    on("plane", true),
    far_from("plane"),
    on("cylinder", false),
    on("cylinder", true),
    far_from("cylinder"),
    on("mesh", false),
    on("mesh", true),
    on("bent mesh", false),
    on("bent mesh", true),
    on("few triangles", false),
    on("many triangles", false),
    far_from("mesh"),
    far_from("closed mesh"),
];

const fn on(surface: &'static str, energies: bool) -> Case {
    Case {
        surface,
        far: false,
        energies,
    }
}

const fn far_from(surface: &'static str) -> Case {
    Case {
        surface,
        far: true,
        energies: false,
    }
}

/// Nanoseconds.
pub struct Costs {
    /// Grains of the layer.
    grains: f64,
    walls: Vec<Cost>,
    beds: Vec<Bed>,
    /// Of the pair style, per touching pair of the dense packing.
    pair: Measured,
}

struct Cost {
    case: Case,
    /// Per grain and step, above the step without a wall.
    per_grain: Measured,
    /// Contacts with the wall per grain.
    contacts: f64,
}

/// A wall under a bed.
struct Bed {
    surface: &'static str,
    /// Per contact with it.
    per_contact: Measured,
    /// Such contacts per grain of the bed.
    contacts: f64,
}

pub fn run(lammps: &Lammps, effort: &Effort) -> Result<Costs> {
    let directory = tempfile::tempdir()?;
    let [floor, bent, closed, few, many] = ["floor", "bent", "box", "few", "many"]
        .map(|name| directory.path().join(format!("{name}.stl")));
    let flat: [([usize; 3], f64); 1] = [([0, 1, 2], 0.0)];
    let squares = (SQUARES, SQUARE);
    write_squares(&floor, squares, &flat, |_| 0.0)?;
    write_squares(&bent, squares, &flat, |x| 1.0 - (1.0 - x * x).sqrt())?;
    write_squares(&few, (FEW, LARGE_SQUARE), &flat, |_| 0.0)?;
    write_squares(&many, (MANY, LARGE_SQUARE), &flat, |_| 0.0)?;
    let half = 0.5 * SQUARE * SQUARES as f64;
    let faces = [[0, 1, 2], [1, 2, 0], [2, 0, 1]].map(|axes| [(axes, half), (axes, -half)]);
    write_squares(&closed, squares, faces.as_flattened(), |_| 0.0)?;
    let (side, steps) = if effort.quick { (16, 100) } else { (64, 500) };
    let interval = steps / INTERVALS;
    let lattice = if effort.quick { 8 } else { 16 };
    let packing = Packing {
        kind: Kind::Dense,
        lattice: [lattice; 3],
        spheres: false,
    }
    .file(lammps)?;
    let sets = Contender::instruction_sets();
    let ours = Contender::Ours(sets[sets.len() - 1]);
    let mut progress = Progress::start("Walls");
    let mut layers: Vec<Vec<f64>> = CASES.iter().map(|_| Vec::new()).collect();
    let (mut contacts, mut pairs) = (vec![0.0; CASES.len()], Vec::new());
    let mut of_beds = BEDS.map(|_| (Vec::new(), 0.0));
    let mut grains = 0.0;
    for round in 0..effort.rounds {
        progress.update(Some(round as f64 / effort.rounds as f64), "layers");
        for (k, case) in CASES.iter().enumerate() {
            let (surface, mesh) = match case.surface {
                "closed mesh" => ("mesh", &closed),
                "bent mesh" => ("mesh", &bent),
                "few triangles" => ("mesh", &few),
                "many triangles" => ("mesh", &many),
                surface => (surface, &floor),
            };
            let words = [
                ("surface", surface.to_string()),
                ("height", if case.far { FAR } else { "0" }.to_string()),
                ("mesh", path_word(mesh)?),
                ("bent", if mesh == &bent { "yes" } else { "no" }.to_string()),
                ("side", side.to_string()),
                ("steps", steps.to_string()),
                ("interval", interval.to_string()),
                (
                    "energies",
                    if case.energies { "yes" } else { "no" }.to_string(),
                ),
            ];
            let output = lammps.run("layer.lmp", 1, None, &words)?;
            grains = timing(&output)?.atoms;
            layers[k].push(1e9 * quiet_step(&output)? / grains);
            contacts[k] = touching(&output)? / grains;
        }
        for (surface, (times, contacts)) in BEDS.into_iter().zip(&mut of_beds) {
            let step_and_contacts = |floors: usize| -> Result<(f64, f64)> {
                let words = [
                    ("surface", surface.to_string()),
                    ("mesh", path_word(&floor)?),
                    ("layers", LAYERS.to_string()),
                    ("floors", floors.to_string()),
                    ("side", side.to_string()),
                    ("settle", "3000".to_string()),
                    ("steps", steps.to_string()),
                    ("interval", interval.to_string()),
                ];
                let output = lammps.run("layer.lmp", 1, None, &words)?;
                let grains = timing(&output)?.atoms;
                // With the first of the walls.
                let contacts = touching(&output)? / grains;
                Ok((1e9 * quiet_step(&output)? / grains, contacts))
            };
            let (one, _) = step_and_contacts(FLOORS[0])?;
            let (all, touching) = step_and_contacts(FLOORS[1])?;
            *contacts = touching;
            times.push((all - one) / (FLOORS[1] - FLOORS[0]) as f64 / touching);
        }
        let mut words = run_variables(&packing, ours, [1; 3], 20, steps)?;
        // Every pair once.
        words.extend([
            ("count", "1".to_string()),
            ("newton", "on".to_string()),
            ("interval", interval.to_string()),
        ]);
        let output = lammps.run("run.lmp", 1, None, &words)?;
        // The share of the pair style in the whole run, of a quiet step.
        let found = timing(&output)?;
        let of_pairs = quiet_step(&output)? * found.pair_wall / found.wall;
        pairs.push(1e9 * of_pairs / touching(&output)?);
    }
    progress.finish();
    let walls = (1..CASES.len())
        .map(|k| {
            // Of one round each, so that what disturbs a round is in both.
            let above: Vec<f64> = layers[k]
                .iter()
                .zip(&layers[0])
                .map(|(with, without)| with - without)
                .collect();
            Ok(Cost {
                case: CASES[k],
                per_grain: Measured::of(&above).context("no round was run")?,
                contacts: contacts[k],
            })
        })
        .collect::<Result<_>>()?;
    Ok(Costs {
        grains,
        walls,
        beds: BEDS
            .into_iter()
            .zip(of_beds)
            .map(|(surface, (times, contacts))| {
                Ok(Bed {
                    surface,
                    per_contact: Measured::of(&times).context("no round was run")?,
                    contacts,
                })
            })
            .collect::<Result<_>>()?,
        pair: Measured::of(&pairs).context("no round was run")?,
    })
}

/// Faces of so many squares along a side, of this size, about the origin: the first two axes span each, the third is its normal, along which it lies so far; `rise` more, which
/// depends on the place along the first.
fn write_squares(
    path: &Path,
    (squares, size): (usize, f64),
    faces: &[([usize; 3], f64)],
    rise: impl Fn(f64) -> f64,
) -> Result<()> {
    let at = |k: usize| size * (k as f64 - 0.5 * squares as f64);
    let mut text = String::from("solid squares\n");
    for (axes, height) in faces {
        for k in 0..squares * squares {
            let (i, j) = (k % squares, k / squares);
            let [a, b] = [(at(i), at(j)), (at(i + 1), at(j))];
            let [c, d] = [(at(i + 1), at(j + 1)), (at(i), at(j + 1))];
            for corners in [[a, b, c], [a, c, d]] {
                // Readers take the normal from the corners.
                text += "facet normal 0 0 0\nouter loop\n";
                for (u, v) in corners {
                    let mut place = [0.0; 3];
                    for (axis, value) in axes.iter().zip([u, v, height + rise(u)]) {
                        place[*axis] = value;
                    }
                    let [x, y, z] = place;
                    writeln!(text, "vertex {x:.9} {y:.9} {z:.9}")?;
                }
                text += "endloop\nendfacet\n";
            }
        }
    }
    text += "endsolid squares\n";
    fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

/// A surface in words.
fn surface_title(surface: &str) -> String {
    match surface {
        "plane" => "a plane".to_string(),
        "cylinder" => "a cylinder, within it".to_string(),
        "mesh" => format!("a flat mesh of {} triangles", 2 * SQUARES * SQUARES),
        "few triangles" => format!("a flat mesh of {} large triangles", 2 * FEW * FEW),
        "many triangles" => format!(
            "one of {} triangles, the same under the layer",
            2 * MANY * MANY
        ),
        "bent mesh" => format!(
            "a mesh of {} triangles along a cylinder, within it",
            2 * SQUARES * SQUARES
        ),
        _ => format!(
            "a closed mesh of {} triangles, within it",
            2 * FACES * SQUARES * SQUARES
        ),
    }
}

impl Case {
    fn title(self) -> String {
        let surface = surface_title(self.surface);
        let place = if self.far { "far from" } else { "on" };
        let energies = if self.energies {
            ", *energies yes*"
        } else {
            ""
        };
        format!("{place} {surface}{energies}")
    }
}

pub fn table(costs: &Costs) -> Table {
    let title = format!(
        "Walls in LAMMPS: what a step of {} grains takes more than without the wall; a touching pair of a dense packing takes {} ns. Wall-clock times of the quiet parts of each run: four of five parts took longer",
        costs.grains,
        costs.pair.show()
    );
    let mut table = Table::new(
        &title,
        &[
            "a layer of grains, AR 2",
            "contacts with the wall per grain",
            "ns per grain and step",
            "ns per contact",
            "over a touching pair",
        ],
    );
    for cost in &costs.walls {
        let [per_contact, ratio] = if cost.contacts > 0.0 {
            let per_contact = cost.per_grain.scaled(1.0 / cost.contacts);
            let ratio = per_contact.median / costs.pair.median;
            [per_contact.show(), short(ratio)]
        } else {
            [String::new(), String::new()]
        };
        table.row(vec![
            cost.case.title(),
            short(cost.contacts),
            cost.per_grain.show(),
            per_contact,
            ratio,
        ]);
    }
    for bed in &costs.beds {
        let surface = surface_title(bed.surface);
        table.row(vec![
            format!("a bed of {LAYERS} layers on {surface}, the grains of which touch others too: one more such wall"),
            short(bed.contacts),
            bed.per_contact.scaled(bed.contacts).show(),
            bed.per_contact.show(),
            short(bed.per_contact.median / costs.pair.median),
        ]);
    }
    table
}

pub fn csv(costs: &Costs) -> String {
    let mut text =
        String::from("surface,far,contacts_per_grain,ns_per_grain,spread,pair_ns_per_contact\n");
    for cost in &costs.walls {
        text += &format!(
            "{},{},{},{},{},{}\n",
            cost.case.surface,
            cost.case.far,
            cost.contacts,
            cost.per_grain.median,
            cost.per_grain.spread,
            costs.pair.median
        );
    }
    for bed in &costs.beds {
        let of_grain = bed.per_contact.scaled(bed.contacts);
        text += &format!(
            "bed on a {},false,{},{},{},{}\n",
            bed.surface, bed.contacts, of_grain.median, of_grain.spread, costs.pair.median
        );
    }
    text
}
