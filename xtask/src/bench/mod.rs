// SPDX-License-Identifier: MIT OR Apache-2.0
//! Speed: kernels, scenes in LAMMPS and LIGGGHTS beside the built-in styles, ranks and sizes; tables, CSV and pictures.

mod against;
mod bars;
pub mod contender;
mod force_error;
mod kernels;
pub mod lammps_run;
pub mod liggghts_run;
pub mod machine;
pub mod packing;
mod scaling;
pub mod scenes;
mod sizes;
pub mod statistics;
mod walls;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{bail, Context, Result};

use self::bars::Bar;
use self::contender::{Contender, Model};
use self::scenes::{Engines, Scene, QUICK_SCENES, SCENES};
use crate::chart::{GRANULAR, OURS, OURS_LIGHT, SUPERELLIPSOID, SUPERELLIPSOID_LIGHT};
use crate::demo::table::Table;
use crate::liggghts::Optimisation;
use crate::progress::{human_time, say};
use crate::{setup, workspace};

#[derive(clap::Args)]
pub struct Options {
    /// Small scenes, short runs: under two minutes once engines and packings are there
    #[arg(long)]
    quick: bool,
    /// Only this: kernels, walls, sizes, scaling, ranks (what scaling has of them), or a scene by its name (repeat for more)
    #[arg(long)]
    scene: Vec<String>,
    /// Only this engine's pair styles in the scenes [default: both; packings are always made by LAMMPS]
    #[arg(long)]
    engine: Option<Engine>,
    /// This LAMMPS in place of one that is built here: walls, sizes, scaling and ranks then need no checkout, no sources and no
    /// compilers
    #[arg(
        long,
        value_name = "FILE",
        requires = "plugin",
        conflicts_with = "against"
    )]
    lammps: Option<PathBuf>,
    /// The plugin for it
    #[arg(long, value_name = "FILE", requires = "lammps")]
    plugin: Option<PathBuf>,
    /// Of scaling and ranks no other round that is likely to end later than so many seconds after the first began
    #[arg(long, value_name = "SECONDS", conflicts_with = "against")]
    within: Option<u64>,
    /// Kernels and scenes in turns with this revision (any name that git knows), which is built in the cache when it is asked for the
    /// first time: the ratio of the times, and its scatter
    #[arg(long)]
    against: Option<String>,
    /// Where tables, CSV and pictures go [default: bench-output in the checkout]
    #[arg(long)]
    output: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
pub enum Engine {
    Lammps,
    Liggghts,
}

/// What is measured.
#[derive(Default)]
struct Choice<'a> {
    quick: bool,
    only: &'a [String],
    engine: Option<Engine>,
    /// LAMMPS and its plugin, where they are there already.
    given: Option<(&'a Path, &'a Path)>,
    within: Option<Duration>,
}

impl Choice<'_> {
    /// An error for a scene that is none of these, which are those `when`.
    fn refuse_unknown_scenes(&self, names: &[&str], when: &str) -> Result<()> {
        let known = |name: &&String| names.contains(&name.as_str());
        match self.only.iter().find(|name| !known(name)) {
            Some(unknown) => bail!("--scene {unknown}: there are {} ({when})", names.join(", ")),
            None => Ok(()),
        }
    }
}

/// How long measurements take.
pub struct Effort {
    pub quick: bool,
    /// Runs of each contender, in turns.
    pub rounds: usize,
    /// A run's wished length, s.
    pub seconds: f64,
    /// After which no round of scaling begins that would end later.
    pub within: Option<Duration>,
}

const KERNELS: &str = "kernels";
const WALLS: &str = "walls";
const SIZES: &str = "sizes";
const SCALING: &str = "scaling";
const RANKS: &str = "ranks";
const SCENES_FILE: &str = "scenes";
const SCENES_PICTURE: &str = "scenes.svg";
const GRAINS_PICTURE: &str = "grains.svg";

pub fn bench(options: &Options) -> Result<()> {
    let output = match &options.output {
        Some(output) => output.clone(),
        None => workspace::root().join("bench-output"),
    };
    let choice = Choice {
        quick: options.quick,
        only: &options.scene,
        engine: options.engine,
        given: options.lammps.as_deref().zip(options.plugin.as_deref()),
        within: options.within.map(Duration::from_secs),
    };
    match &options.against {
        Some(revision) => against::run(&output, &choice, revision),
        None => run(&output, &choice),
    }
}

/// The kernels alone, shortly: for the tests.
pub fn quick_kernels(output: &Path) -> Result<()> {
    run(
        output,
        &Choice {
            quick: true,
            only: &[KERNELS.to_string()],
            ..Choice::default()
        },
    )?;
    holds_words(
        output,
        &["full law", "elastic, no friction", "one contact at a time"],
    )
}

/// A small dense scene through both engines, walls, and sizes, shortly: for the tests.
pub fn quick_scene(output: &Path) -> Result<()> {
    run(
        output,
        &Choice {
            quick: true,
            only: &[QUICK_SCENES[0].name, WALLS, SIZES].map(str::to_string),
            ..Choice::default()
        },
    )?;
    holds_words(
        output,
        &[
            "gran/ellipsoid, scalar",
            "nve/ellipsoid velocities step",
            "granular, spheres",
            "superquadric",
            "far from a plane",
            "on a cylinder",
            "far from a closed mesh",
            "the small ones alone",
        ],
    )?;
    let csv = fs::read_to_string(output.join("scenes.csv"))?;
    check_errors(&csv)
}

/// What claims to be exact must be.
fn check_errors(csv: &str) -> Result<()> {
    const EXACT: f64 = 1e-6;
    let mut checked = 0;
    for line in csv.lines() {
        if !line.contains("gran/ellipsoid") && !line.contains("surface ellipsoid") {
            continue;
        }
        let error: f64 = line
            .rsplit(',')
            .next()
            .and_then(|word| word.parse().ok())
            .with_context(|| format!("no force error in {line}"))?;
        if error.is_nan() || error >= EXACT {
            bail!("a force error of {error} where {EXACT} is allowed: {line}");
        }
        checked += 1;
    }
    if checked == 0 {
        bail!("no force error was found");
    }
    Ok(())
}

fn holds_words(output: &Path, words: &[&str]) -> Result<()> {
    let table = fs::read_to_string(output.join(Report::TEXT))?;
    for word in words {
        if !table.contains(word) {
            bail!("the table has no '{word}'");
        }
    }
    Ok(())
}

/// What is written, again after every part, so that a run that is cut short leaves what it has.
struct Report {
    directory: PathBuf,
    head: String,
    summary: Option<Table>,
    tables: Vec<Table>,
    pictures: Vec<&'static str>,
    started: Instant,
}

impl Report {
    const TEXT: &str = "table.md";

    /// Adds tables, and (over)writes the numbers they come from.
    fn add(
        &mut self,
        name: &str,
        tables: impl IntoIterator<Item = Table>,
        csv: &str,
    ) -> Result<()> {
        self.tables.extend(tables);
        let file = self.directory.join(format!("{name}.csv"));
        fs::write(&file, csv).with_context(|| format!("cannot write {}", file.display()))?;
        self.write()
    }

    fn picture(&mut self, name: &'static str) -> PathBuf {
        if !self.pictures.contains(&name) {
            self.pictures.push(name);
        }
        self.directory.join(name)
    }

    fn write(&self) -> Result<()> {
        let mut text = self.head.clone();
        for table in self.summary.iter().chain(&self.tables) {
            text += "\n";
            text += &table.markdown();
        }
        text += "\n";
        for picture in &self.pictures {
            text += &format!("![{picture}]({picture})\n");
        }
        text += &format!("\nTaken in {}", human_time(self.started.elapsed()));
        if let Some(load) = machine::load() {
            text += &format!("; load at the end {load}");
        }
        text += ".\n";
        let path = self.directory.join(Self::TEXT);
        fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))
    }
}

fn run(output: &Path, choice: &Choice) -> Result<()> {
    let quick = choice.quick;
    let effort = Effort {
        quick,
        rounds: if quick { 2 } else { 5 },
        seconds: if quick { 0.2 } else { 1.0 },
        within: choice.within,
    };
    let all: &[Scene] = if quick { &QUICK_SCENES } else { &SCENES };
    let names: Vec<&str> = [KERNELS, WALLS, SIZES, SCALING, RANKS]
        .into_iter()
        .chain(all.iter().map(|scene| scene.name))
        .collect();
    choice.refuse_unknown_scenes(&names, "others with or without --quick")?;
    let named = |name: &str| choice.only.iter().any(|one| one == name);
    let wanted = |name: &str| choice.only.is_empty() || named(name);
    fs::create_dir_all(output).with_context(|| format!("cannot make {}", output.display()))?;
    remove_earlier(output)?;
    let mut report = Report {
        directory: output.canonicalize()?,
        head: head(choice),
        summary: None,
        tables: Vec::new(),
        pictures: Vec::new(),
        started: Instant::now(),
    };
    if named(KERNELS) || (wanted(KERNELS) && choice.engine.is_none()) {
        let rows = kernels::run(&effort)?;
        report.add(KERNELS, kernels::tables(&rows), &kernels::csv(&rows))?;
    }
    let scenes: Vec<&Scene> = all.iter().filter(|scene| wanted(scene.name)).collect();
    let scaling = wanted(SCALING) && choice.engine != Some(Engine::Liggghts);
    let walls = wanted(WALLS) && choice.engine != Some(Engine::Liggghts);
    let sizes = wanted(SIZES) && choice.engine != Some(Engine::Liggghts);
    // Of which `scaling` has the same.
    let ranks = named(RANKS) && !scaling && choice.engine != Some(Engine::Liggghts);
    if !scenes.is_empty() || walls || sizes || scaling || ranks {
        let engines = engines(choice, !scenes.is_empty())?;
        scenes::announce(&engines);
        report.head += &about_engines(&engines);
        let mut rows = Vec::new();
        for scene in scenes {
            let found = scenes::run(&engines, scene, &effort)?;
            let table = scenes::table(&found);
            rows.extend(found);
            report.summary = Some(scenes::summary(&rows));
            draw_scenes(&report.picture(SCENES_PICTURE), &rows)?;
            report.add(SCENES_FILE, table, &scenes::csv(&rows))?;
        }
        if walls {
            let found = walls::run(&engines.lammps, &effort)?;
            report.add(WALLS, [walls::table(&found)], &walls::csv(&found))?;
        }
        if sizes {
            let found = sizes::run(&engines.lammps, &effort)?;
            report.add(SIZES, [sizes::table(&found)], &sizes::csv(&found))?;
        }
        if scaling {
            let found = scaling::run(&engines.lammps, &effort, true)?;
            scaling::picture(&report.picture(GRAINS_PICTURE), &found)?;
            report.add(SCALING, scaling::tables(&found), &scaling::csv(&found))?;
        }
        if ranks {
            let found = scaling::run(&engines.lammps, &effort, false)?;
            report.add(RANKS, scaling::tables(&found), &scaling::csv(&found))?;
        }
    }
    let path = report.directory.join(Report::TEXT);
    println!("{}", fs::read_to_string(&path)?);
    say(format!(
        "tables, CSV and pictures are in {}",
        report.directory.display()
    ));
    Ok(())
}

/// Nothing of an earlier run may stand beside this one's.
fn remove_earlier(output: &Path) -> Result<()> {
    let csv =
        [KERNELS, SCENES_FILE, WALLS, SIZES, SCALING, RANKS].map(|name| format!("{name}.csv"));
    let names = csv.iter().map(String::as_str);
    for name in names.chain([Report::TEXT, SCENES_PICTURE, GRAINS_PICTURE]) {
        let path = output.join(name);
        if path.is_file() {
            fs::remove_file(&path).with_context(|| format!("cannot remove {}", path.display()))?;
        }
    }
    Ok(())
}

/// Command, machine, and how to read the numbers.
fn head(choice: &Choice) -> String {
    let mut text = String::from("## Speed\n\n`cargo xtask bench");
    if choice.quick {
        text += " --quick";
    }
    for name in choice.only {
        text += &format!(" --scene {name}");
    }
    text += match choice.engine {
        None => "",
        Some(Engine::Lammps) => " --engine lammps",
        Some(Engine::Liggghts) => " --engine liggghts",
    };
    if choice.given.is_some() {
        text += " --lammps FILE --plugin FILE";
    }
    if let Some(within) = choice.within {
        text += &format!(" --within {}", within.as_secs());
    }
    text += "`\n\n";
    if machine::load().unwrap_or(0.0) > 0.5 {
        say("this machine is busy: times are processor times, but caches and ranks are disturbed");
    }
    for line in machine::describe() {
        text += &format!("- {line}\n");
    }
    text += "\nTimes of one rank are processor times; after ± half the distance between the smallest and the largest of the \
             runs, for kernels the median absolute deviation. Each run has its own copy of the plugin, or of LIGGGHTS: where its pages lie in memory \
             changes times.\n";
    text
}

fn engines(choice: &Choice, scenes: bool) -> Result<Engines> {
    let lammps = match choice.given {
        Some((binary, plugin)) => lammps_run::Lammps::given(binary, plugin)?,
        None => {
            setup::setup()?;
            lammps_run::Lammps::prepare()?
        }
    };
    let both = [Optimisation::O2, Optimisation::O3];
    let liggghts = if scenes && choice.engine != Some(Engine::Lammps) {
        setup::setup()?;
        // A second build of five minutes is too much for a quick look.
        let optimisations = if choice.quick { &both[..1] } else { &both };
        Some(liggghts_run::Liggghts::prepare(optimisations)?)
    } else {
        None
    };
    Ok(Engines {
        lammps,
        time_lammps: choice.engine != Some(Engine::Liggghts),
        liggghts,
    })
}

fn about_engines(engines: &Engines) -> String {
    let mut text = format!(
        "\nLAMMPS {}, one core, newton off unless it says otherwise.",
        engines.lammps.release
    );
    if engines.liggghts.is_some() {
        text += &format!(
            " LIGGGHTS-PUBLIC {}, built with each compiler option that a row names, newton off; its wall-clock times are \
             scaled to processor time by the share of the processor that the process had.",
            crate::liggghts::VERSION
        );
    }
    text += " Pair times are the engine's own. A contact across a periodic boundary counts once, though newton off computes it \
             twice. The grains are moved by the engine's own integrator where a row names none. The force error is of the elastic force without friction, as a vector, against elliptical Hertz, over \
             contacts of the packing; a contact that is missed counts as 100 %.\n";
    text
}

/// The others differ little from these; the table has them.
fn in_picture(contender: Contender) -> bool {
    use self::contender::Model::{GaussianCurvature, MeanCurvature};
    !matches!(
        contender,
        Contender::Liggghts(_, Optimisation::O3)
            | Contender::Liggghts(MeanCurvature | GaussianCurvature | Model::NfdMoved(_), _)
            | Contender::OursMoved(..)
    )
}

fn draw_scenes(path: &Path, rows: &[scenes::Row]) -> Result<()> {
    let bars: Vec<Bar> = rows
        .iter()
        .filter(|row| !row.newton && in_picture(row.contender))
        .map(|row| Bar {
            group: row.scene.name.into(),
            label: row.contender.label(),
            value: row.pair.median,
            colour: match row.contender {
                Contender::Ours("scalar" | "baseline") => OURS_LIGHT,
                Contender::Ours(_) | Contender::OursMoved(..) => OURS,
                Contender::Liggghts(
                    Model::Nfd | Model::NfdMoved(_) | Model::HertzOnEllipsoids,
                    _,
                ) => OURS_LIGHT,
                Contender::Superellipsoid => SUPERELLIPSOID,
                Contender::Spheres | Contender::Liggghts(Model::Spheres, _) => GRANULAR,
                Contender::Liggghts(..) => SUPERELLIPSOID_LIGHT,
            },
        })
        .collect();
    bars::draw(
        path,
        "Pair time of a grain and step, one core",
        "ns per grain and step",
        &bars,
    )
}

#[cfg(test)]
mod tests {
    use super::check_errors;

    #[test]
    fn an_error_that_is_none_must_not_be_seen() {
        let csv = |error: &str| {
            format!("scene,force_error_95\nx,\"gran/ellipsoid, avx2\",{error}\nx,\"superquadric\",0.2\n")
        };
        assert!(check_errors(&csv("1e-12")).is_ok());
        assert!(check_errors(&csv("1e-3")).is_err());
        assert!(check_errors(&csv("nan")).is_err());
        assert!(check_errors(&csv("")).is_err());
        assert!(check_errors("x,\"superquadric\",0.2\n").is_err());
    }
}
