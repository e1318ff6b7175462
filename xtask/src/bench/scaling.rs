// SPDX-License-Identifier: MIT OR Apache-2.0
//! Our pair style in LAMMPS over ranks, and over the number of grains.

use std::path::Path;

use anyhow::{Context, Result};

use super::contender::Contender;
use super::lammps_run::{timing, Lammps};
use super::packing::{Kind, Packing};
use super::scenes::{run_variables, steps_for};
use super::statistics::{short, Measured};
use super::Effort;
use crate::chart::{draw, Panel, Series, GRANULAR, OURS};
use crate::demo::table::Table;
use crate::process::jobs;
use crate::progress::{say, Progress};

/// A run of copies of a packing on some ranks.
struct Point {
    what: &'static str,
    /// Lattice points of the packing along each side.
    side: usize,
    copies: [usize; 3],
    ranks: usize,
    spheres: bool,
}

pub struct Found {
    what: &'static str,
    ranks: usize,
    spheres: bool,
    grains: f64,
    /// Wall-clock milliseconds per step.
    step: Measured,
    /// Wall-clock nanoseconds of the pair style per grain and step, mean over ranks.
    pair: Measured,
}

const STRONG: &str = "strong";
const WEAK: &str = "weak";
const SIZE: &str = "size";

fn points(effort: &Effort) -> Vec<Point> {
    let point = |what, side, copies, ranks| Point {
        what,
        side,
        copies,
        ranks,
        spheres: false,
    };
    let mut list = Vec::new();
    for ranks in [1, 2, 4] {
        if ranks > jobs() {
            say(format!("{} cores: {ranks} ranks are left out", jobs()));
            continue;
        }
        if effort.quick {
            list.push(point(STRONG, 8, [2, 2, 2], ranks));
        } else {
            list.push(point(STRONG, 16, [3, 3, 3], ranks));
            list.push(point(WEAK, 16, [2 * ranks, 2, 2], ranks));
        }
    }
    let sizes: &[(usize, [usize; 3])] = if effort.quick {
        &[(8, [1, 1, 1]), (8, [2, 2, 2])]
    } else {
        &[
            (8, [1, 1, 1]),
            (16, [1, 1, 1]),
            (16, [2, 2, 2]),
            (16, [3, 3, 3]),
            (16, [5, 5, 4]),
        ]
    };
    for (side, copies) in sizes {
        for spheres in [false, true] {
            list.push(Point {
                spheres,
                ..point(SIZE, *side, *copies, 1)
            });
        }
    }
    list
}

/// Steps before the timed ones, and timed ones.
const WARM_STEPS: usize = 40;
const STEPS: usize = 100;

pub fn run(lammps: &Lammps, effort: &Effort) -> Result<Vec<Found>> {
    let sets = Contender::instruction_sets();
    let widest = sets[sets.len() - 1];
    let list = points(effort);
    let mut taken: Vec<Vec<(f64, f64)>> = list.iter().map(|_| Vec::new()).collect();
    let mut grains = vec![0.0; list.len()];
    let files: Vec<_> = list
        .iter()
        .map(|point| {
            Packing {
                kind: Kind::Dense,
                lattice: [point.side; 3],
                spheres: point.spheres,
            }
            .file(lammps)
        })
        .collect::<Result<_>>()?;
    let mut progress = Progress::start("Scaling over ranks and grains");
    for round in 0..effort.rounds.min(3) {
        for (k, point) in list.iter().enumerate() {
            let contender = if point.spheres {
                Contender::Spheres
            } else {
                Contender::Ours(widest)
            };
            let count = point.side.pow(3) * point.copies.iter().product::<usize>();
            progress.update(
                Some((round * list.len() + k) as f64 / (effort.rounds.min(3) * list.len()) as f64),
                &format!("{count} grains, {} ranks", point.ranks),
            );
            // The same steps of the same motion for all sizes: how often candidates and neighbours are found anew depends
            // on them, and is part of the cost.
            let (warm, steps) = if effort.quick {
                (
                    5,
                    steps_for(contender, Kind::Dense, count, 2.0 * effort.seconds),
                )
            } else {
                (WARM_STEPS, STEPS)
            };
            let mut words = run_variables(&files[k], contender, point.copies, warm, steps)?;
            words.push(("newton", "on".to_string()));
            let output = lammps.run("run.lmp", point.ranks, contender.instruction_set(), &words)?;
            let time = timing(&output)?;
            grains[k] = time.atoms;
            // On one rank the processor's time, which other programs do not disturb.
            let (wall, pair) = if point.ranks == 1 && point.what == SIZE {
                (time.step, time.pair)
            } else {
                (time.wall, time.pair_wall)
            };
            taken[k].push((1e3 * wall / time.steps, time.per_grain(pair)));
        }
    }
    progress.finish();
    list.iter()
        .enumerate()
        .map(|(k, point)| {
            let step: Vec<f64> = taken[k].iter().map(|t| t.0).collect();
            let pair: Vec<f64> = taken[k].iter().map(|t| t.1).collect();
            Ok(Found {
                what: point.what,
                ranks: point.ranks,
                spheres: point.spheres,
                grains: grains[k],
                step: Measured::of(&step).context("no round was run")?,
                pair: Measured::of(&pair).context("no round was run")?,
            })
        })
        .collect()
}

pub fn tables(found: &[Found]) -> Vec<Table> {
    let mut ranks = Table::new(
        "Ranks: gran/ellipsoid, dense, AR 2, newton on",
        &[
            "scaling",
            "ranks",
            "grains",
            "wall-clock time of a step (ms)",
            "pair time per grain and step (ns)",
            "times as fast as one rank",
        ],
    );
    for row in found.iter().filter(|row| row.what != SIZE) {
        let one = found
            .iter()
            .find(|other| other.what == row.what && other.ranks == 1)
            .unwrap_or(row);
        let speed = (one.step.median / one.grains) / (row.step.median / row.grains);
        ranks.row(vec![
            row.what.into(),
            row.ranks.to_string(),
            row.grains.to_string(),
            row.step.show(),
            row.pair.show(),
            short(speed),
        ]);
    }
    let mut sizes = Table::new(
        "Number of grains: dense, one rank, newton on",
        &[
            "pair style",
            "grains",
            "pair time per grain and step (ns)",
            "whole step per grain (ns)",
            "pair time against the second size (%)",
        ],
    );
    for row in found.iter().filter(|row| row.what == SIZE) {
        // The smallest fits into the innermost caches.
        let base = found
            .iter()
            .filter(|other| other.what == SIZE && other.spheres == row.spheres)
            .nth(1)
            .unwrap_or(row);
        sizes.row(vec![
            label(row.spheres).into(),
            row.grains.to_string(),
            row.pair.show(),
            row.step.scaled(1e6 / row.grains).show(),
            format!("{:+.0}", 100.0 * (row.pair.median / base.pair.median - 1.0)),
        ]);
    }
    vec![ranks, sizes]
}

fn label(spheres: bool) -> &'static str {
    if spheres {
        "granular, spheres"
    } else {
        "gran/ellipsoid"
    }
}

pub fn csv(found: &[Found]) -> String {
    let mut text = String::from(
        "what,pair_style,ranks,grains,step_ms,step_spread,pair_ns_per_grain_step,pair_spread\n",
    );
    for row in found {
        text += &format!(
            "{},\"{}\",{},{},{:.4},{:.4},{:.2},{:.2}\n",
            row.what,
            label(row.spheres),
            row.ranks,
            row.grains,
            row.step.median,
            row.step.spread,
            row.pair.median,
            row.pair.spread
        );
    }
    text
}

pub fn picture(path: &Path, found: &[Found]) -> Result<()> {
    let curve = |spheres: bool, colour, of: &dyn Fn(&Found) -> f64| {
        let rows = found
            .iter()
            .filter(|row| row.what == SIZE && row.spheres == spheres);
        let points = rows.map(|row| (row.grains.log10(), of(row))).collect();
        Series::curve(label(spheres), points, colour, spheres)
    };
    let panel = |title: &str, y_label: &str, of: &dyn Fn(&Found) -> f64| {
        let curves = vec![curve(false, OURS, of), curve(true, GRANULAR, of)];
        Panel::of_curves(title, "log10 of the number of grains", y_label, curves)
    };
    draw(
        path,
        "Cost of a grain and step against the number of grains",
        &[vec![
            panel("pair style", "ns per grain and step", &|row| {
                row.pair.median
            }),
            panel("whole step", "ns per grain and step", &|row| {
                1e6 * row.step.median / row.grains
            }),
        ]],
    )
}
