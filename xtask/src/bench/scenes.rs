// SPDX-License-Identifier: MIT OR Apache-2.0
//! Scenes in both engines: ours beside the built-in pair styles and contact models, in turns, on one core.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use super::contender::{Contender, Model, Velocities};
use super::force_error::{ForceError, Reference};
use super::lammps_run::{path_word, timing, touching, Lammps, Timing};
use super::liggghts_run::{Files, Liggghts};
use super::packing::{for_superellipsoids, Kind, Packing};
use super::statistics::{short, Measured};
use super::Effort;
use crate::demo::table::Table;
use crate::liggghts::Optimisation;
use crate::progress::{say, Progress};

/// Grains from which a run is long enough for fewer of everything.
const LARGE: usize = 50_000;

#[derive(Clone, Copy)]
pub struct Scene {
    /// What `--scene` names it by.
    pub name: &'static str,
    kind: Kind,
    lattice: [usize; 3],
    /// Copies in each direction.
    copies: usize,
    /// Are spheres of the same solid fraction a comparison?
    spheres: bool,
}

pub const SCENES: [Scene; 6] = [
    scene("dense-4096", Kind::Dense, 16, 1),
    scene("dense-110592", Kind::Dense, 16, 3),
    Scene {
        // Spheres as dilute as a packing of needles hardly touch.
        spheres: false,
        lattice: [16, 8, 8],
        ..scene("needles", Kind::Needles, 0, 1)
    },
    scene("mixture", Kind::Mixture, 18, 1),
    scene("gas", Kind::Gas, 16, 1),
    scene("flow", Kind::Flow, 16, 1),
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
        lattice: [side; 3],
        copies,
        spheres: true,
    }
}

/// The engines that take part.
pub struct Engines {
    /// Makes the packings too.
    pub lammps: Lammps,
    /// Are the pair styles of LAMMPS timed?
    pub time_lammps: bool,
    pub liggghts: Option<Liggghts>,
}

/// One contender on one scene.
pub struct Row {
    pub scene: Scene,
    pub grains: f64,
    pub contender: Contender,
    pub newton: bool,
    /// Entries of the neighbour list per grain.
    pub pairs: f64,
    /// Contacts per grain, each counted once; nobody counts those of the spheres of LIGGGHTS alone.
    pub contacts: Option<f64>,
    /// Nanoseconds per grain and step.
    pub pair: Measured,
    pub step: Measured,
    pub error: Option<ForceError>,
}

impl Row {
    fn per_pair(&self) -> Measured {
        self.pair.scaled(1.0 / self.pairs.max(1e-300))
    }

    fn per_contact(&self) -> Option<Measured> {
        // Where hardly any pair touches the time is not theirs.
        let contacts = self.contacts.filter(|count| *count > 0.005 * self.pairs)?;
        Some(self.pair.scaled(1.0 / contacts))
    }
}

/// Variables of a run of some copies of a packing.
pub fn run_variables(
    file: &Path,
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

/// As many steps as take about so many seconds, if a step of a grain costs what is guessed.
pub fn steps_for(contender: Contender, kind: Kind, grains: usize, seconds: f64) -> usize {
    let step = contender.cost() * kind.weight() * grains as f64;
    ((seconds / step) as usize).clamp(10, 500)
}

/// Contenders, and whether Newton's third law holds across ranks.
fn contenders(engines: &Engines, scene: &Scene) -> Vec<(Contender, bool)> {
    let mut list: Vec<(Contender, bool)> = Vec::new();
    if engines.time_lammps {
        let sets = Contender::instruction_sets();
        let widest = sets[sets.len() - 1];
        list.extend(sets.iter().map(|set| (Contender::Ours(set), false)));
        list.extend(Velocities::ALL.map(|v| (Contender::OursMoved(widest, v), false)));
        if engines.lammps.superellipsoid {
            list.push((Contender::Superellipsoid, false));
        }
        if scene.spheres {
            list.push((Contender::Spheres, false));
        }
        // granular/superellipsoid cannot have it.
        if scene.kind == Kind::Dense {
            list.push((Contender::Ours(widest), true));
            list.push((Contender::Spheres, true));
        }
    }
    // Its quaternions are set by a command each, which is too slow for large scenes.
    if let Some(liggghts) = engines.liggghts.as_ref().filter(|_| scene.copies == 1) {
        for optimisation in liggghts.optimisations() {
            let mut models = vec![Model::Nfd, Model::HertzOnEllipsoids, Model::Superquadric];
            if optimisation == Optimisation::O2 {
                models.extend(Velocities::ALL.map(Model::NfdMoved));
                models.extend([Model::MeanCurvature, Model::GaussianCurvature]);
            }
            if scene.spheres {
                models.push(Model::Spheres);
            }
            list.extend(
                models
                    .into_iter()
                    .map(|model| (Contender::Liggghts(model, optimisation), false)),
            );
        }
    }
    list
}

/// The packing of a scene in the words of each reader.
struct Inputs {
    ellipsoids: PathBuf,
    superellipsoids: PathBuf,
    spheres: PathBuf,
    liggghts: Option<[Files; 2]>,
}

impl Inputs {
    fn prepare(engines: &Engines, scene: &Scene) -> Result<Self> {
        let file = |spheres: bool| {
            Packing {
                kind: scene.kind,
                lattice: scene.lattice,
                spheres,
            }
            .file(&engines.lammps)
        };
        let ellipsoids = file(false)?;
        let spheres = if scene.spheres {
            file(true)?
        } else {
            ellipsoids.clone()
        };
        Ok(Inputs {
            superellipsoids: if engines.lammps.superellipsoid {
                for_superellipsoids(&ellipsoids)?
            } else {
                ellipsoids.clone()
            },
            liggghts: match &engines.liggghts {
                Some(_) => Some([Files::of(&ellipsoids)?, Files::of(&spheres)?]),
                None => None,
            },
            ellipsoids,
            spheres,
        })
    }

    fn of_lammps(&self, contender: Contender) -> &Path {
        match contender {
            Contender::Superellipsoid => &self.superellipsoids,
            Contender::Spheres => &self.spheres,
            Contender::Ours(_) | Contender::OursMoved(..) | Contender::Liggghts(..) => {
                &self.ellipsoids
            }
        }
    }
}

fn run_once(
    engines: &Engines,
    scene: &Scene,
    inputs: &Inputs,
    (contender, newton): (Contender, bool),
    seconds: f64,
) -> Result<Timing> {
    let grains = scene.lattice.iter().product::<usize>() * scene.copies.pow(3);
    let steps = steps_for(contender, scene.kind, grains, seconds);
    let warm = if grains > LARGE { 4 } else { 20 };
    if let Contender::Liggghts(model, optimisation) = contender {
        let files = inputs
            .liggghts
            .as_ref()
            .map(|[ellipsoids, spheres]| match model {
                Model::Spheres => spheres,
                _ => ellipsoids,
            })
            .context("no input was made for LIGGGHTS")?;
        let engine = engines.liggghts.as_ref().context("LIGGGHTS is not there")?;
        return engine.run(optimisation, model, files, warm, steps);
    }
    let mut words = run_variables(
        inputs.of_lammps(contender),
        contender,
        [scene.copies; 3],
        warm,
        steps,
    )?;
    words.push(("newton", if newton { "on" } else { "off" }.to_string()));
    let output = engines
        .lammps
        .run("run.lmp", 1, contender.instruction_set(), &words)?;
    timing(&output)
}

/// What times a scene's pairs once, with the engines that it is given: nanoseconds a step. `engines` make the packing.
pub fn pair_time<'a>(
    engines: &Engines,
    scene: &'a Scene,
    contender: Contender,
    seconds: f64,
) -> Result<impl Fn(&Engines) -> Result<f64> + 'a> {
    let inputs = Inputs::prepare(engines, scene)?;
    Ok(move |engines: &Engines| {
        let timing = run_once(engines, scene, &inputs, (contender, false), seconds)?;
        Ok(1e9 * timing.pair / timing.steps)
    })
}

pub fn run(engines: &Engines, scene: &Scene, effort: &Effort) -> Result<Vec<Row>> {
    let inputs = Inputs::prepare(engines, scene)?;
    let list = contenders(engines, scene);
    let mut progress = Progress::start(format!("Scene {}", scene.name));
    progress.update(None, "contacts");
    let contacts = |contender: Contender| -> Result<f64> {
        // Every pair once: with Newton's third law on.
        let mut words = run_variables(inputs.of_lammps(contender), contender, [1; 3], 5, 20)?;
        words.extend([("count", "1".to_string()), ("newton", "on".to_string())]);
        let output = engines.lammps.run("run.lmp", 1, None, &words)?;
        Ok(touching(&output)? / timing(&output)?.atoms)
    };
    let of_ellipsoids = contacts(Contender::Ours("scalar"))?;
    let of_spheres = if scene.spheres {
        Some(contacts(Contender::Spheres)?)
    } else {
        None
    };
    progress.update(None, "forces");
    let reference = Reference::of(&inputs.ellipsoids, &engines.lammps, effort)?;
    let errors = list
        .iter()
        .map(|(contender, _)| reference.error_of(*contender, engines))
        .collect::<Result<Vec<_>>>()?;
    let mut taken: Vec<Vec<Timing>> = list.iter().map(|_| Vec::new()).collect();
    let large = scene.copies > 1;
    for round in 0..effort.rounds {
        for (k, contender) in list.iter().enumerate() {
            // LIGGGHTS has many models here, and its runs vary little.
            let of_liggghts = matches!(contender.0, Contender::Liggghts(..));
            if round >= 3 && (large || of_liggghts) {
                continue;
            }
            progress.update(
                Some((round * list.len() + k) as f64 / (effort.rounds * list.len()) as f64),
                &contender.0.label(),
            );
            taken[k].push(run_once(
                engines,
                scene,
                &inputs,
                *contender,
                effort.seconds,
            )?);
        }
    }
    progress.finish();
    list.iter()
        .zip(&taken)
        .zip(errors)
        .map(|(((contender, newton), times), error)| {
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
                contacts: if contender.spheres() {
                    of_spheres
                } else {
                    Some(of_ellipsoids)
                },
                pair: of(&|t| t.pair)?,
                step: of(&|t| t.step)?,
                error,
            })
        })
        .collect()
}

/// One scene's.
pub fn table(rows: &[Row]) -> Option<Table> {
    let first = rows.first()?;
    let mut table = Table::new(
        &format!(
            "{}: {} grains, solid fraction {}, {} contacts per grain",
            first.scene.kind.title(),
            first.grains,
            first.scene.kind.fraction(),
            rows.iter()
                .find(|row| !row.contender.spheres())
                .and_then(|row| row.contacts)
                .map_or(String::new(), short),
        ),
        &[
            "pair style or contact models",
            "pair time per grain and step (ns)",
            "pairs listed per grain",
            "ns per listed pair",
            "ns per contact",
            "whole step per grain (ns)",
            "force error, median (%)",
            "95 % below (%)",
            "pair time over that of LAMMPS' spheres",
            "granular/superellipsoid takes",
            "LIGGGHTS superquadrics take",
        ],
    );
    for row in rows {
        let other = |contender: Contender, newton: bool| time_of(rows, contender, newton);
        let superquadric =
            |o: Optimisation| other(Contender::Liggghts(Model::Superquadric, o), false);
        let over_spheres = match row.contender {
            Contender::Spheres => None,
            _ => other(Contender::Spheres, row.newton),
        };
        let superellipsoid = match row.contender {
            Contender::Superellipsoid => None,
            _ => other(Contender::Superellipsoid, false),
        };
        // The same compiler options against each other; LAMMPS against the faster.
        let superquadrics = match row.contender {
            Contender::Liggghts(Model::Superquadric, _) => None,
            Contender::Liggghts(_, optimisation) => superquadric(optimisation),
            _ => fastest_superquadric(rows),
        };
        let own = row.pair.median;
        let newton = if row.newton { ", newton on" } else { "" };
        let optional = |cell: Option<String>| cell.unwrap_or_default();
        table.row(vec![
            format!("{}{newton}", row.contender.label()),
            row.pair.show(),
            short(row.pairs),
            row.per_pair().show(),
            optional(row.per_contact().map(|m| m.show())),
            row.step.show(),
            optional(row.error.map(|error| percent(error.median))),
            optional(row.error.map(|error| percent(error.high))),
            optional(over_spheres.map(|time| times(own / time))),
            optional(superellipsoid.map(|time| times(time / own))),
            optional(superquadrics.map(|time| times(time / own))),
        ]);
    }
    Some(table)
}

fn times(value: f64) -> String {
    format!("{} times", short(value))
}

fn time_of(rows: &[Row], contender: Contender, newton: bool) -> Option<f64> {
    rows.iter()
        .find(|row| row.contender == contender && row.newton == newton)
        .map(|row| row.pair.median)
}

/// Of LIGGGHTS' compiler options.
fn fastest_superquadric(rows: &[Row]) -> Option<f64> {
    [Optimisation::O2, Optimisation::O3]
        .into_iter()
        .filter_map(|o| time_of(rows, Contender::Liggghts(Model::Superquadric, o), false))
        .min_by(f64::total_cmp)
}

/// A line a scene: the ratios that matter. `rows` of any number of scenes.
pub fn summary(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "In short: pair times, and whole steps with fix nve/ellipsoid",
        &[
            "scene",
            "granular/superellipsoid over gran/ellipsoid, widest lanes",
            "the same over gran/ellipsoid with SSE2 alone",
            "LIGGGHTS superquadrics over gran/ellipsoid, widest lanes",
            "gran/ellipsoid, widest lanes, over LAMMPS' spheres",
            "whole step, velocities step, over LAMMPS' spheres with nve/sphere",
            "whole step, velocities half, over the same",
            "in LIGGGHTS -O2: superquadric over nfd",
            "in LIGGGHTS -O3: superquadric over nfd",
        ],
    );
    let sets = Contender::instruction_sets();
    let widest = Contender::Ours(sets[sets.len() - 1]);
    for scene in rows.chunk_by(|a, b| a.scene.name == b.scene.name) {
        let of = |contender: Contender| time_of(scene, contender, false);
        let ratio = |above: Option<f64>, below: Option<f64>| match (above, below) {
            (Some(above), Some(below)) => times(above / below),
            _ => String::new(),
        };
        let whole_step = |contender: Contender| {
            let row = scene.iter().find(|r| r.contender == contender && !r.newton);
            row.map(|r| r.step.median)
        };
        let over_spheres = |velocities: Velocities| {
            let ours = Contender::OursMoved(sets[sets.len() - 1], velocities);
            ratio(whole_step(ours), whole_step(Contender::Spheres))
        };
        let in_liggghts = |o: Optimisation| {
            ratio(
                of(Contender::Liggghts(Model::Superquadric, o)),
                of(Contender::Liggghts(Model::Nfd, o)),
            )
        };
        table.row(vec![
            scene[0].scene.name.into(),
            ratio(of(Contender::Superellipsoid), of(widest)),
            ratio(
                of(Contender::Superellipsoid),
                of(Contender::Ours("baseline")),
            ),
            ratio(fastest_superquadric(scene), of(widest)),
            ratio(of(widest), of(Contender::Spheres)),
            over_spheres(Velocities::Step),
            over_spheres(Velocities::Half),
            in_liggghts(Optimisation::O2),
            in_liggghts(Optimisation::O3),
        ]);
    }
    table
}

/// Of a share; what is nothing but rounding reads as a power of ten.
fn percent(share: f64) -> String {
    let value = 100.0 * share;
    if value > 0.0 && value < 0.005 {
        format!("{value:.0e}")
    } else {
        short(value)
    }
}

pub fn csv(rows: &[Row]) -> String {
    let mut text = String::from(
        "scene,grains,pair_style,newton,pairs_per_grain,contacts_per_grain,pair_ns_per_grain_step,spread,ns_per_pair,ns_per_contact,step_ns_per_grain,step_spread,force_error_median,force_error_95\n",
    );
    for row in rows {
        let optional = |value: Option<f64>| value.map_or(String::new(), |v| format!("{v:.5}"));
        let error = |value: Option<f64>| value.map_or(String::new(), |v| format!("{v:.3e}"));
        text += &format!(
            "{},{},\"{}\",{},{:.4},{},{:.2},{:.2},{:.3},{},{:.2},{:.2},{},{}\n",
            row.scene.name,
            row.grains,
            row.contender.label(),
            if row.newton { "on" } else { "off" },
            row.pairs,
            optional(row.contacts),
            row.pair.median,
            row.pair.spread,
            row.per_pair().median,
            optional(row.per_contact().map(|m| m.median)),
            row.step.median,
            row.step.spread,
            error(row.error.map(|e| e.median)),
            error(row.error.map(|e| e.high)),
        );
    }
    text
}

/// Says what is not there.
pub fn announce(engines: &Engines) {
    if engines.time_lammps && !engines.lammps.superellipsoid {
        say(format!(
            "LAMMPS {} has no granular/superellipsoid: it is left out",
            engines.lammps.release
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::percent;

    #[test]
    fn rounding_reads_as_a_power_of_ten() {
        assert_eq!(percent(0.1234), "12.3");
        assert_eq!(percent(0.0), "0");
        assert_eq!(percent(1e-12), "1e-10");
    }
}
