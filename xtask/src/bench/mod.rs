// SPDX-License-Identifier: MIT OR Apache-2.0
//! Speed: kernels, scenes in LAMMPS beside the built-in styles, ranks and sizes; tables, CSV and pictures.

mod bars;
mod contender;
mod kernels;
mod lammps_run;
mod machine;
mod packing;
mod scaling;
mod scenes;
mod statistics;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{bail, Context, Result};

use self::bars::Bar;
use self::contender::Contender;
use self::scenes::{Scene, QUICK_SCENES, SCENES};
use crate::demo::chart::{GRANULAR, OURS, OURS_LIGHT, SUPERELLIPSOID};
use crate::demo::table::Table;
use crate::progress::{human_time, say};
use crate::{setup, workspace};

#[derive(clap::Args)]
pub struct Options {
    /// Small scenes, short runs: under two minutes once engine and packings are there
    #[arg(long)]
    quick: bool,
    /// Only this: kernels, scaling, or a scene by its name (repeat for more)
    #[arg(long)]
    scene: Vec<String>,
    /// Where tables, CSV and pictures go [default: bench-output in the checkout]
    #[arg(long)]
    output: Option<PathBuf>,
}

/// How long measurements take.
pub struct Effort {
    pub quick: bool,
    /// Runs of each pair style, in turns.
    pub rounds: usize,
    /// A run's wished length, s.
    pub seconds: f64,
}

const KERNELS: &str = "kernels";
const SCALING: &str = "scaling";

pub fn bench(options: &Options) -> Result<()> {
    let output = match &options.output {
        Some(output) => output.clone(),
        None => workspace::root().join("bench-output"),
    };
    run(&output, options.quick, &options.scene)
}

/// The kernels alone, shortly: for the tests.
pub fn quick_kernels(output: &Path) -> Result<()> {
    run(output, true, &[KERNELS.to_string()])?;
    let table = fs::read_to_string(output.join("table.md"))?;
    for word in ["full law", "elastic, no friction", "one contact at a time"] {
        if !table.contains(word) {
            bail!("the table has no '{word}'");
        }
    }
    Ok(())
}

fn run(output: &Path, quick: bool, only: &[String]) -> Result<()> {
    let started = std::time::Instant::now();
    let effort = if quick {
        Effort {
            quick,
            rounds: 2,
            seconds: 0.3,
        }
    } else {
        Effort {
            quick,
            rounds: 5,
            seconds: 1.0,
        }
    };
    let all: &[Scene] = if quick { &QUICK_SCENES } else { &SCENES };
    let names: Vec<&str> = [KERNELS, SCALING]
        .into_iter()
        .chain(all.iter().map(|scene| scene.name))
        .collect();
    if let Some(unknown) = only.iter().find(|name| !names.contains(&name.as_str())) {
        bail!(
            "--scene {unknown}: there are {} (others with or without --quick)",
            names.join(", ")
        );
    }
    let wanted = |name: &str| only.is_empty() || only.iter().any(|one| one == name);
    fs::create_dir_all(output).with_context(|| format!("cannot make {}", output.display()))?;
    let output = output.canonicalize()?;
    let command = format!(
        "cargo xtask bench{}{}",
        if quick { " --quick" } else { "" },
        only.iter()
            .map(|name| format!(" --scene {name}"))
            .collect::<String>()
    );
    let mut text = format!("## Speed\n\n`{command}`\n\n");
    let busy = machine::load().unwrap_or(0.0) > 0.5;
    if busy {
        say("this machine is busy: times are processor times, but caches and ranks are disturbed");
    }
    for line in machine::describe() {
        text += &format!("- {line}\n");
    }
    text += "\nTimes of one rank are processor times; after ± half the distance between the smallest and the largest of the \
             runs, for kernels the median absolute deviation.\n";

    let mut written = Vec::new();
    let mut add = |name: &str, tables: &[Table], csv: String, text: &mut String| -> Result<()> {
        for table in tables {
            *text += "\n";
            *text += &table.markdown();
        }
        let file = format!("{name}.csv");
        fs::write(output.join(&file), csv)?;
        written.push(file);
        Ok(())
    };
    if wanted(KERNELS) {
        let rows = kernels::run(&output, &effort)?;
        add(
            KERNELS,
            &kernels::tables(&rows),
            kernels::csv(&rows),
            &mut text,
        )?;
    }
    let scenes: Vec<Scene> = all
        .iter()
        .filter(|scene| wanted(scene.name))
        .copied()
        .collect();
    let mut pictures = Vec::new();
    if !scenes.is_empty() || wanted(SCALING) {
        setup::setup()?;
        let lammps = lammps_run::Lammps::prepare()?;
        scenes::announce(&lammps);
        text += &format!(
            "\nLAMMPS {}, one core, newton off unless it says otherwise.\n",
            lammps.release
        );
        if !scenes.is_empty() {
            let rows = scenes::run(&lammps, &scenes, &effort)?;
            add(
                "scenes",
                &scenes::tables(&rows),
                scenes::csv(&rows),
                &mut text,
            )?;
            draw_scenes(&output.join("scenes.svg"), &rows)?;
            pictures.push("scenes.svg");
        }
        if wanted(SCALING) {
            let found = scaling::run(&lammps, &effort)?;
            add(
                SCALING,
                &scaling::tables(&found),
                scaling::csv(&found),
                &mut text,
            )?;
            scaling::picture(&output.join("grains.svg"), &found)?;
            pictures.push("grains.svg");
        }
    }
    text += "\n";
    for picture in &pictures {
        text += &format!("![{picture}]({picture})\n");
    }
    if let Some(load) = machine::load() {
        text += &format!(
            "\nTaken in {}; load at the end {load}.\n",
            human_time(started.elapsed())
        );
    }
    fs::write(output.join("table.md"), &text)?;
    println!("{text}");
    say(format!(
        "tables, {} and pictures are in {}",
        written.join(", "),
        output.display()
    ));
    Ok(())
}

fn draw_scenes(path: &Path, rows: &[scenes::Row]) -> Result<()> {
    let bars: Vec<Bar> = rows
        .iter()
        .filter(|row| !row.newton)
        .map(|row| Bar {
            group: row.scene.name.into(),
            label: row.contender.label(),
            value: row.pair.median,
            colour: match row.contender {
                Contender::Ours("scalar") => OURS_LIGHT,
                Contender::Ours(_) => OURS,
                Contender::Superellipsoid => SUPERELLIPSOID,
                Contender::Spheres => GRANULAR,
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
