// SPDX-License-Identifier: MIT OR Apache-2.0
//! Our pair style in LAMMPS over ranks, and over the number of grains; what a billion grains would cost by that.

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};

use super::contender::{Contender, Velocities};
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
    contender: Contender,
}

pub struct Found {
    what: &'static str,
    ranks: usize,
    contender: Contender,
    rounds: usize,
    grains: f64,
    /// Wall-clock milliseconds per step.
    step: Measured,
    /// Wall-clock nanoseconds of the pair style per grain and step, mean over ranks.
    pair: Measured,
    /// Images on a rank.
    ghosts: f64,
    /// Communication, as a share of the step.
    communication: Measured,
    /// Bytes of a rank, as LAMMPS counts them.
    memory: f64,
}

const STRONG: &str = "strong";
const WEAK: &str = "weak";
const SIZE: &str = "size";

fn points(effort: &Effort, sizes: bool) -> Vec<Point> {
    let sets = Contender::instruction_sets();
    let widest = sets[sets.len() - 1];
    let mut list = Vec::new();
    say(format!(
        "{0} cores: up to {0} ranks, so that none waits for a core",
        jobs()
    ));
    for ranks in rank_counts(jobs()) {
        for contender in [
            // Its velocities of the step are sent too.
            Contender::OursMoved(widest, Velocities::Step),
            Contender::Spheres,
        ] {
            let mut push = |what, side, copies| {
                list.push(Point {
                    what,
                    side,
                    copies,
                    ranks,
                    contender,
                });
            };
            if effort.quick {
                push(STRONG, 8, [2, 2, 2]);
            } else {
                push(STRONG, 16, [3, 3, 3]);
                push(WEAK, 16, [2 * ranks, 2, 2]);
            }
        }
    }
    if !sizes {
        return list;
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
        for contender in [Contender::Ours(widest), Contender::Spheres] {
            list.push(Point {
                what: SIZE,
                side: *side,
                copies: *copies,
                ranks: 1,
                contender,
            });
        }
    }
    list
}

/// Powers of two, and all cores.
fn rank_counts(cores: usize) -> Vec<usize> {
    let mut counts: Vec<usize> = (0..)
        .map(|k| 1 << k)
        .take_while(|ranks| *ranks <= cores)
        .collect();
    if counts.last() != Some(&cores) {
        counts.push(cores);
    }
    counts
}

/// Steps before the timed ones, and timed ones.
const WARM_STEPS: usize = 40;
const STEPS: usize = 100;

/// Ranks, and with `sizes` numbers of grains.
pub fn run(lammps: &Lammps, effort: &Effort, sizes: bool) -> Result<Vec<Found>> {
    let list = points(effort, sizes);
    let mut taken: Vec<Vec<(f64, f64, f64)>> = list.iter().map(|_| Vec::new()).collect();
    // Of grains, of images on a rank, bytes of a rank.
    let mut counted = vec![[0.0; 3]; list.len()];
    let files: Vec<_> = list
        .iter()
        .map(|point| {
            Packing {
                kind: Kind::Dense,
                lattice: [point.side; 3],
                spheres: point.contender.spheres(),
            }
            .file(lammps)
        })
        .collect::<Result<_>>()?;
    let mut progress = Progress::start("Scaling over ranks and grains");
    let started = Instant::now();
    let mut longest = Duration::ZERO;
    for round in 0..effort.rounds.min(3) {
        let begun = Instant::now();
        if let Some(within) = effort.within.filter(|_| round > 0) {
            if started.elapsed() + longest > within {
                say(format!(
                    "{round} of {} rounds: another would not end within {} s",
                    effort.rounds.min(3),
                    within.as_secs()
                ));
                break;
            }
        }
        for (k, point) in list.iter().enumerate() {
            let contender = point.contender;
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
            let of_rank = time.of_rank.context("LAMMPS says it")?;
            counted[k] = [time.atoms, of_rank.ghosts, of_rank.memory];
            // On one rank the processor's time, which other programs do not disturb.
            let (wall, pair) = if point.ranks == 1 && point.what == SIZE {
                (time.step, time.pair)
            } else {
                (time.wall, time.pair_wall)
            };
            taken[k].push((
                1e3 * wall / time.steps,
                time.per_grain(pair),
                of_rank.communication / time.wall,
            ));
        }
        longest = longest.max(begun.elapsed());
    }
    progress.finish();
    list.iter()
        .enumerate()
        .map(|(k, point)| {
            let step: Vec<f64> = taken[k].iter().map(|t| t.0).collect();
            let pair: Vec<f64> = taken[k].iter().map(|t| t.1).collect();
            let communication: Vec<f64> = taken[k].iter().map(|t| t.2).collect();
            let [grains, ghosts, memory] = counted[k];
            Ok(Found {
                what: point.what,
                ranks: point.ranks,
                contender: point.contender,
                rounds: step.len(),
                grains,
                step: Measured::of(&step).context("no round was run")?,
                pair: Measured::of(&pair).context("no round was run")?,
                ghosts,
                communication: Measured::of(&communication).context("no round was run")?,
                memory,
            })
        })
        .collect()
}

pub fn tables(found: &[Found]) -> Vec<Table> {
    let rounds = found.first().map_or(0, |row| row.rounds);
    let mut ranks = Table::new(
        &format!("Ranks: dense, AR 2, newton on, rounds: {rounds}"),
        &[
            "scaling",
            "pair style",
            "ranks",
            "grains",
            "wall-clock time of a step (ms)",
            "pair time per grain and step (ns)",
            "times as fast as one rank",
            "communication (% of the step)",
            "images on a rank, per grain of it",
        ],
    );
    for row in found.iter().filter(|row| row.what != SIZE) {
        let one = found
            .iter()
            .find(|other| {
                other.what == row.what && other.ranks == 1 && other.contender == row.contender
            })
            .unwrap_or(row);
        let speed = (one.step.median / one.grains) / (row.step.median / row.grains);
        ranks.row(vec![
            row.what.into(),
            label(row.contender).into(),
            row.ranks.to_string(),
            row.grains.to_string(),
            row.step.show(),
            row.pair.show(),
            short(speed),
            row.communication.scaled(100.0).show(),
            short(row.ghosts * row.ranks as f64 / row.grains),
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
            "memory of LAMMPS per grain (bytes)",
            "images per grain",
        ],
    );
    for row in found.iter().filter(|row| row.what == SIZE) {
        // The smallest fits into the innermost caches.
        let base = found
            .iter()
            .filter(|other| other.what == SIZE && other.contender == row.contender)
            .nth(1)
            .unwrap_or(row);
        sizes.row(vec![
            label(row.contender).into(),
            row.grains.to_string(),
            row.pair.show(),
            row.step.scaled(1e6 / row.grains).show(),
            format!("{:+.0}", 100.0 * (row.pair.median / base.pair.median - 1.0)),
            short(row.memory / row.grains),
            short(row.ghosts / row.grains),
        ]);
    }
    let mut tables = vec![ranks];
    if found.iter().any(|row| row.what == SIZE) {
        tables.push(sizes);
    }
    tables.extend(billion(found));
    tables
}

/// Grains of the prediction, and ranks.
const BILLION: f64 = 1e9;
const MANY_RANKS: f64 = 1e4;
/// Doubles that LAMMPS sends of an image in each step, there and back: position, orientation, velocity and angular momentum, then
/// with `fix nve/ellipsoid velocities step` what these have more at the step; force and torque.
const FORWARD: f64 = 13.0;
const OF_STEP: f64 = 6.0;
const BACK: f64 = 6.0;
/// Bytes a second that a rank is taken to send, of a node with 25 GB/s and 64 ranks.
const BANDWIDTH: f64 = 25e9 / 64.0;
/// Bytes of an atom in a dump of identifier, type, position, orientation and shape with eight digits, and in a restart file.
const DUMPED: f64 = 120.0;
/// What a bit for a neighbour's weight leaves of 32, for the atoms and images of a rank.
const MOST_ON_A_RANK: f64 = (1 << 29) as f64;
/// Of LAMMPS' identifiers in 32 bits.
const MOST_IDENTIFIERS: f64 = i32::MAX as f64;

/// What follows for a billion grains from one rank with as many grains as each would have: periodic on all sides, it has as many
/// images too. Ranks side by side on this machine tell what it costs that they share its memory.
fn billion(found: &[Found]) -> Option<Table> {
    let moved = |row: &&Found| matches!(row.contender, Contender::OursMoved(..));
    let row = found
        .iter()
        .filter(moved)
        .find(|row| row.what == STRONG && row.ranks == 1 && row.grains > 1e5)?;
    let beside = found
        .iter()
        .filter(moved)
        .filter(|row| row.what == WEAK && row.ranks > 1)
        .max_by_key(|row| row.ranks);
    let of_rank = BILLION / MANY_RANKS;
    let alone = row.step.median * 1e-3 * of_rank / row.grains;
    let step_of = |row: &Found| row.step.median * 1e-3 * of_rank * row.ranks as f64 / row.grains;
    let step = beside.map_or(alone, |row| alone.max(step_of(row)));
    // A surface: images go with the power of two thirds.
    let images = row.ghosts * (of_rank / row.grains).powf(2.0 / 3.0);
    let sent = 8.0 * images * (FORWARD + OF_STEP + BACK);
    let transfer = sent / BANDWIDTH;
    let memory = row.memory * of_rank / row.grains;
    let mut table = Table::new(
        &format!(
            "A billion grains on 10 000 ranks, dense, AR 2: predicted from {} grains on one rank, not run",
            row.grains
        ),
        &["what", "value", "from"],
    );
    let mut line = |what: &str, value: String, from: &str| {
        table.row(vec![what.into(), value, from.into()]);
    };
    line(
        "grains and images on a rank",
        format!("{of_rank:.0} and {images:.0}"),
        "measured, by volume and surface",
    );
    line(
        "time of a step without messages",
        format!("{} ms", short(1e3 * alone)),
        "measured: on a core that has the memory to itself; 64 ranks on a node share it",
    );
    if let Some(row) = beside {
        line(
            "time of a step that shares the memory",
            format!("{} ms", short(1e3 * step_of(row))),
            &format!(
                "measured: {} ranks of {} grains side by side, with the messages between them",
                row.ranks,
                row.grains / row.ranks as f64
            ),
        );
    }
    line(
        "sent and received by a rank in a step",
        format!("{} MB", short(1e-6 * sent)),
        "25 doubles an image: 13 and 6 there, 6 back",
    );
    line(
        "time of these messages",
        format!("{} ms", short(1e3 * transfer)),
        "assumed: 25 GB/s a node of 64 ranks",
    );
    line(
        "memory of a rank, and of all",
        format!(
            "{} MB, {} TB",
            short(1e-6 * memory),
            short(1e-12 * memory * MANY_RANKS)
        ),
        "measured, as LAMMPS counts it: histories of contacts and neighbour lists included",
    );
    line(
        "one million steps",
        format!("{} days", short(1e6 * (step + transfer) / 86400.0)),
        "the longer step and the time of the messages",
    );
    line(
        "a dump of all grains",
        format!("{} GB", short(1e-9 * DUMPED * BILLION)),
        "120 bytes a grain in text: the first thing to break; write one file a group of ranks (`%` in its name), or binary",
    );
    line(
        "identifiers",
        format!("to {MOST_IDENTIFIERS:.1e} grains"),
        "32 bits; beyond, LAMMPS built with LAMMPS_BIGBIG (64 bits), which the plugin takes",
    );
    line(
        "grains and images on one rank",
        format!("to {MOST_ON_A_RANK:.1e}"),
        "29 bits of an entry of a neighbour list",
    );
    Some(table)
}

fn label(contender: Contender) -> &'static str {
    match contender {
        Contender::Spheres => "granular, spheres",
        Contender::OursMoved(..) => "gran/ellipsoid, nve/ellipsoid",
        _ => "gran/ellipsoid",
    }
}

pub fn csv(found: &[Found]) -> String {
    let mut text = String::from(
        "what,pair_style,ranks,grains,step_ms,step_spread,pair_ns_per_grain_step,pair_spread,communication_share,images_per_rank,bytes_per_rank\n",
    );
    for row in found {
        text += &format!(
            "{},\"{}\",{},{},{:.4},{:.4},{:.2},{:.2},{:.4},{:.0},{:.0}\n",
            row.what,
            label(row.contender),
            row.ranks,
            row.grains,
            row.step.median,
            row.step.spread,
            row.pair.median,
            row.pair.spread,
            row.communication.median,
            row.ghosts,
            row.memory
        );
    }
    text
}

pub fn picture(path: &Path, found: &[Found]) -> Result<()> {
    let curve = |spheres: bool, colour, of: &dyn Fn(&Found) -> f64| {
        let rows: Vec<&Found> = found
            .iter()
            .filter(|row| row.what == SIZE && row.contender.spheres() == spheres)
            .collect();
        let points = rows
            .iter()
            .map(|row| (row.grains.log10(), of(row)))
            .collect();
        let title = rows.first().map_or("", |row| label(row.contender));
        Series::curve(title, points, colour, spheres)
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
