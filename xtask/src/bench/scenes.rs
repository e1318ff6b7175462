// SPDX-License-Identifier: MIT OR Apache-2.0
//! Scenes in LAMMPS: our pair style on each instruction set beside the built-in ones, in turns, on one core.

use anyhow::{Context, Result};

use super::contender::Contender;
use super::lammps_run::{path_word, timing, touching, Lammps, Timing};
use super::packing::{for_superellipsoids, Kind, Packing};
use super::statistics::{short, Measured};
use super::Effort;
use crate::demo::table::Table;
use crate::progress::{say, Progress};

/// Grains from which a run is long enough for fewer of everything.
const LARGE: usize = 50_000;

#[derive(Clone, Copy)]
pub struct Scene {
    /// What `--scene` names it by.
    pub name: &'static str,
    kind: Kind,
    side: usize,
    /// Copies in each direction.
    copies: [usize; 3],
    /// Are spheres of the same solid fraction a comparison?
    spheres: bool,
}

pub const SCENES: [Scene; 5] = [
    scene("dense-4096", Kind::Dense, 16, 1),
    scene("dense-110592", Kind::Dense, 16, 3),
    Scene {
        // Spheres as dilute as a packing of needles hardly touch.
        spheres: false,
        side: 10,
        ..scene("needles", Kind::Needles, 10, 1)
    },
    scene("mixture", Kind::Mixture, 18, 1),
    scene("gas", Kind::Gas, 16, 1),
];

/// What a test can wait for.
pub const QUICK_SCENES: [Scene; 2] = [
    scene("dense-512", Kind::Dense, 8, 1),
    scene("gas-512", Kind::Gas, 8, 1),
];

const fn scene(name: &'static str, kind: Kind, side: usize, copies: usize) -> Scene {
    Scene {
        name,
        kind,
        side,
        copies: [copies; 3],
        spheres: true,
    }
}

/// One pair style on one scene.
pub struct Row {
    pub scene: Scene,
    pub grains: f64,
    pub contender: Contender,
    pub newton: bool,
    /// Entries of the neighbour list per grain.
    pub pairs: f64,
    /// Share of the entries that touch.
    pub touching: Option<f64>,
    /// Nanoseconds per grain and step.
    pub pair: Measured,
    pub step: Measured,
}

impl Row {
    fn per_pair(&self) -> Measured {
        self.pair.scaled(1.0 / self.pairs.max(1e-300))
    }

    fn per_touching(&self) -> Option<Measured> {
        // Where hardly any pair touches the time is not theirs.
        let touching = self.touching.filter(|share| *share > 0.02)?;
        Some(self.per_pair().scaled(1.0 / touching))
    }
}

/// Variables of a run of some copies of a packing.
pub fn run_variables(
    file: &std::path::Path,
    contender: Contender,
    copies: [usize; 3],
    warm: usize,
    steps: usize,
) -> Result<Vec<(&'static str, String)>> {
    let mut words = contender.variables();
    words.extend([
        ("data", path_word(file)?),
        (
            "replicate",
            format!("{} {} {}", copies[0], copies[1], copies[2]),
        ),
        ("warm", warm.to_string()),
        ("steps", steps.to_string()),
    ]);
    Ok(words)
}

/// As many steps as take about so many seconds, if a step of a grain costs what is guessed here.
pub fn steps_for(contender: Contender, grains: usize, seconds: f64) -> usize {
    let guess = match contender {
        Contender::Ours("scalar") => 2.5e-6,
        Contender::Ours(_) => 1e-6,
        Contender::Superellipsoid => 15e-6,
        Contender::Spheres => 0.5e-6,
    };
    ((seconds / (guess * grains as f64)) as usize).clamp(10, 500)
}

pub fn run(lammps: &Lammps, scenes: &[Scene], effort: &Effort) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for scene in scenes {
        rows.extend(one(lammps, scene, effort)?);
    }
    Ok(rows)
}

fn contenders(lammps: &Lammps, scene: &Scene) -> Vec<(Contender, bool)> {
    let sets = Contender::instruction_sets();
    let widest = sets[sets.len() - 1];
    let mut list: Vec<(Contender, bool)> = sets
        .iter()
        .map(|set| (Contender::Ours(set), false))
        .collect();
    if lammps.superellipsoid {
        list.push((Contender::Superellipsoid, false));
    }
    if scene.spheres {
        list.push((Contender::Spheres, false));
    }
    // Newton's third law across ranks, which granular/superellipsoid cannot have.
    if scene.kind == Kind::Dense {
        list.push((Contender::Ours(widest), true));
        list.push((Contender::Spheres, true));
    }
    list
}

fn one(lammps: &Lammps, scene: &Scene, effort: &Effort) -> Result<Vec<Row>> {
    let file = |spheres: bool| {
        Packing {
            kind: scene.kind,
            side: scene.side,
            spheres,
        }
        .file(lammps)
    };
    let ellipsoids = file(false)?;
    let spheres = if scene.spheres {
        file(true)?
    } else {
        ellipsoids.clone()
    };
    let exponents = if lammps.superellipsoid {
        for_superellipsoids(&ellipsoids)?
    } else {
        ellipsoids.clone()
    };
    let of = |contender: Contender| match contender {
        Contender::Ours(_) => &ellipsoids,
        Contender::Superellipsoid => &exponents,
        Contender::Spheres => &spheres,
    };
    let list = contenders(lammps, scene);
    let mut progress = Progress::start(format!("Scene {}", scene.name));
    let share = |contender: Contender| -> Result<f64> {
        // Every pair once: with Newton's third law on.
        let mut words = run_variables(of(contender), contender, [1; 3], 5, 20)?;
        words.extend([("count", "1".to_string()), ("newton", "on".to_string())]);
        let output = lammps.run("run.lmp", 1, None, &words)?;
        Ok(touching(&output)? / timing(&output)?.pairs)
    };
    let ours = share(Contender::Ours("scalar"))?;
    let theirs = if scene.spheres {
        Some(share(Contender::Spheres)?)
    } else {
        None
    };
    let grains = scene.side.pow(3) * scene.copies.iter().product::<usize>();
    let mut taken: Vec<Vec<Timing>> = list.iter().map(|_| Vec::new()).collect();
    let rounds = if grains > LARGE {
        effort.rounds.min(3)
    } else {
        effort.rounds
    };
    for round in 0..rounds {
        for (k, (contender, newton)) in list.iter().enumerate() {
            let done = (round * list.len() + k) as f64 / (rounds * list.len()) as f64;
            progress.update(Some(done), &contender.label());
            let steps = steps_for(*contender, grains, effort.seconds);
            let warm = if grains > LARGE { 4 } else { 20 };
            let mut words = run_variables(of(*contender), *contender, scene.copies, warm, steps)?;
            words.push(("newton", if *newton { "on" } else { "off" }.to_string()));
            let output = lammps.run("run.lmp", 1, contender.instruction_set(), &words)?;
            taken[k].push(timing(&output)?);
        }
    }
    progress.finish();
    list.iter()
        .zip(&taken)
        .map(|((contender, newton), times)| {
            let of = |seconds: &dyn Fn(&Timing) -> f64| {
                let values: Vec<f64> = times.iter().map(|t| t.per_grain(seconds(t))).collect();
                Measured::of(&values).context("no round was run")
            };
            let last = times.last().context("no round was run")?;
            Ok(Row {
                scene: *scene,
                grains: last.atoms,
                contender: *contender,
                newton: *newton,
                pairs: last.pairs / last.atoms,
                touching: if contender.spheres() {
                    theirs
                } else {
                    Some(ours)
                },
                pair: of(&|t| t.pair)?,
                step: of(&|t| t.step)?,
            })
        })
        .collect()
}

/// One table a scene.
pub fn tables(rows: &[Row]) -> Vec<Table> {
    let mut tables: Vec<Table> = Vec::new();
    let mut name = "";
    for row in rows {
        if row.scene.name != name {
            name = row.scene.name;
            tables.push(Table::new(
                &format!(
                    "{}: {} grains, solid fraction {}",
                    row.scene.kind.title(),
                    row.grains,
                    row.scene.kind.fraction()
                ),
                &[
                    "pair style",
                    "pair time per grain and step (ns)",
                    "pairs listed per grain",
                    "of them touch (%)",
                    "ns per listed pair",
                    "ns per touching pair",
                    "whole step per grain (ns)",
                    "pair time over that of spheres",
                    "granular/superellipsoid takes",
                ],
            ));
        }
        let Some(table) = tables.last_mut() else {
            continue;
        };
        let other = |contender: Contender| {
            rows.iter().find(|other| {
                other.scene.name == row.scene.name
                    && other.contender == contender
                    && other.newton == row.newton
            })
        };
        let ratio = |other: Option<&Row>, inverse: bool| match other {
            Some(other) if other.contender != row.contender => {
                let ratio = row.pair.median / other.pair.median;
                format!("{} times", short(if inverse { 1.0 / ratio } else { ratio }))
            }
            _ => String::new(),
        };
        let newton = if row.newton { ", newton on" } else { "" };
        table.row(vec![
            format!("{}{newton}", row.contender.label()),
            row.pair.show(),
            short(row.pairs),
            row.touching.map_or(String::new(), |t| short(100.0 * t)),
            row.per_pair().show(),
            row.per_touching().map_or(String::new(), |m| m.show()),
            row.step.show(),
            ratio(other(Contender::Spheres), false),
            ratio(other(Contender::Superellipsoid), true),
        ]);
    }
    tables
}

pub fn csv(rows: &[Row]) -> String {
    let mut text = String::from(
        "scene,grains,pair_style,newton,pairs_per_grain,touching_share,pair_ns_per_grain_step,spread,ns_per_pair,ns_per_touching_pair,step_ns_per_grain,step_spread\n",
    );
    for row in rows {
        let per_touching = row.per_touching().map(|m| m.median);
        let optional = |value: Option<f64>| value.map_or(String::new(), |v| format!("{v:.5}"));
        text += &format!(
            "{},{},\"{}\",{},{:.4},{},{:.2},{:.2},{:.3},{},{:.2},{:.2}\n",
            row.scene.name,
            row.grains,
            row.contender.label(),
            if row.newton { "on" } else { "off" },
            row.pairs,
            optional(row.touching),
            row.pair.median,
            row.pair.spread,
            row.per_pair().median,
            optional(per_touching),
            row.step.median,
            row.step.spread
        );
    }
    text
}

/// Says what is not there.
pub fn announce(lammps: &Lammps) {
    if !lammps.superellipsoid {
        say(format!(
            "LAMMPS {} has no granular/superellipsoid: it is left out",
            lammps.release
        ));
    }
}
