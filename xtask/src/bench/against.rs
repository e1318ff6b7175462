// SPDX-License-Identifier: MIT OR Apache-2.0
//! This checkout and another revision, in turns in one run on one core: the kernels through the C interface of each, and the scenes in
//! LAMMPS with the plugin of each.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Stdio};

use anyhow::{bail, Context, Result};

use super::contender::Contender;
use super::lammps_run::{on_one_core, Lammps};
use super::scenes::{self, Engines};
use super::statistics::short;
use super::{Choice, KERNELS, QUICK_SCENES, SCENES};
use crate::demo::table::Table;
use crate::process::find_program;
use crate::progress::{say, Progress};
use crate::revisions::kinds::cases::{Case, CASES};
use crate::revisions::kinds::layer;
use crate::revisions::kinds::packing::{types, Frame, Packing, APART, DENSE, TIME_STEP};
use crate::revisions::scene::{surface, Scene};
use crate::revisions::Revision;
use crate::{lammps, plugin, setup};

const CSV: &str = "against.csv";
const NEEDLES: [f64; 3] = [10.0, 1.0, 1.0];

/// How many turns, and how long a turn of a kernel is, ns.
struct Effort {
    turns: usize,
    length: f64,
    engine_turns: usize,
    engine_seconds: f64,
}

/// The times of the two in each turn.
struct Pairing {
    name: String,
    set: &'static str,
    here: Vec<f64>,
    there: Vec<f64>,
}

/// Median, and half the distance between the quartiles.
fn middle(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let place = share * (sorted.len() - 1) as f64;
        let (low, high) = (
            sorted[place.floor() as usize],
            sorted[place.ceil() as usize],
        );
        low + (high - low) * place.fract()
    };
    (at(0.5), 0.5 * (at(0.75) - at(0.25)))
}

impl Pairing {
    /// The time of this checkout over that of the other in the same turn.
    fn ratio(&self) -> (f64, f64) {
        middle(self.here.iter().zip(&self.there).map(|(a, b)| a / b))
    }
}

pub(super) fn run(output: &Path, choice: &Choice, revision: &str) -> Result<()> {
    let quick = choice.quick;
    let effort = if quick {
        Effort {
            turns: 5,
            length: 2e6,
            engine_turns: 3,
            engine_seconds: 0.2,
        }
    } else {
        Effort {
            turns: 40,
            length: 2e7,
            engine_turns: 10,
            engine_seconds: 1.0,
        }
    };
    let all: &[scenes::Scene] = if quick { &QUICK_SCENES } else { &SCENES };
    let names: Vec<&str> = [KERNELS]
        .into_iter()
        .chain(all.iter().map(|scene| scene.name))
        .collect();
    choice.refuse_unknown_scenes(&names, "those that --against has")?;
    if choice
        .engine
        .is_some_and(|engine| engine != super::Engine::Lammps)
    {
        bail!("with --against the scenes run in LAMMPS alone");
    }
    let wanted = |name: &str| choice.only.is_empty() || choice.only.iter().any(|one| one == name);
    setup::setup()?;
    let (here, there) = (Revision::here()?, Revision::of(revision)?);
    let mut rows = Vec::new();
    if wanted(KERNELS) && choice.engine.is_none() {
        rows.extend(kernels(&here, &there, &effort)?);
    }
    let scenes: Vec<&scenes::Scene> = all.iter().filter(|scene| wanted(scene.name)).collect();
    if !scenes.is_empty() {
        rows.extend(in_lammps(&there, &scenes, &effort)?);
    }
    fs::create_dir_all(output).with_context(|| format!("cannot make {}", output.display()))?;
    let path = output.join(CSV);
    fs::write(&path, csv(&rows)).with_context(|| format!("cannot write {}", path.display()))?;
    println!("{}", table(&rows, &there).markdown());
    say(format!("the numbers are in {}", path.display()));
    Ok(())
}

fn table(rows: &[Pairing], there: &Revision) -> Table {
    let mut table = Table::new(
        &format!("This checkout and {}, in turns on one core", there.name),
        &[
            "scene",
            "instruction set",
            "this checkout (µs per step)",
            "the other (µs per step)",
            "ratio of a turn, median",
            "± half the distance of the quartiles",
        ],
    );
    for row in rows {
        let (ratio, scatter) = row.ratio();
        let time = |values: &[f64]| short(1e-3 * middle(values.iter().copied()).0);
        table.row(vec![
            row.name.clone(),
            row.set.into(),
            time(&row.here),
            time(&row.there),
            format!("{ratio:.3}"),
            format!("{scatter:.3}"),
        ]);
    }
    table
}

fn csv(rows: &[Pairing]) -> String {
    let mut text = String::from("scene,instruction_set,turn,here_ns_per_step,there_ns_per_step\n");
    for row in rows {
        for (turn, (here, there)) in row.here.iter().zip(&row.there).enumerate() {
            text += &format!("\"{}\",{},{turn},{here:.1},{there:.1}\n", row.name, row.set);
        }
    }
    text
}

/// A packing under a law, as the kernel benchmark has it.
fn packed(case: &Case, packing: &Packing) -> Scene {
    let words = case.words();
    Scene {
        grains: types(packing.count(), words.len())
            .into_iter()
            .map(|grain_type| (grain_type, packing.semi_axes, 1.0))
            .collect(),
        laws: words,
        normals_are_kept: case.normals_are_kept(),
        wall_type: 0,
        shapes: Vec::new(),
        triangles: Vec::new(),
        frames: packing.frames.clone(),
        rows: packing
            .starts
            .windows(2)
            .map(|ends| packing.neighbours[ends[0]..ends[1]].to_vec())
            .collect(),
        time_step: TIME_STEP,
        pull: 0.0,
        tallied: case.energies,
        cold: false,
        single: false,
    }
}

/// A layer of grains on a wall, or far from it.
fn layered(case: &layer::Case) -> Scene {
    let full = &CASES[0];
    let (positions, quaternions) = layer::grains(case, full.semi_axes);
    let (shapes, triangles) = surface(case.surface);
    let still = vec![layer::VELOCITY; positions.len()];
    Scene {
        laws: full.words(),
        normals_are_kept: true,
        wall_type: 1,
        shapes,
        triangles,
        grains: vec![(1, full.semi_axes, 1.0); positions.len()],
        rows: vec![Vec::new(); positions.len()],
        frames: vec![Frame {
            positions,
            velocities: still.clone(),
            rotations: still,
            quaternions,
        }],
        time_step: TIME_STEP,
        pull: 0.0,
        tallied: false,
        cold: false,
        single: false,
    }
}

/// The kernel benchmark's, and needles; a scene is made when it is its turn. Whether it is timed on all instruction sets.
type Maker = Box<dyn Fn() -> Scene>;

fn makers() -> Vec<(String, bool, Maker)> {
    let full = &CASES[0];
    let mut makers: Vec<(String, bool, Maker)> = Vec::new();
    for case in CASES {
        let make = move || packed(case, &Packing::new(case.semi_axes, DENSE));
        makers.push((format!("pairs, {}", case.name), true, Box::new(make)));
    }
    makers.push((
        "pairs, needles of aspect ratio 10, full law".into(),
        true,
        Box::new(move || packed(full, &Packing::new(NEEDLES, DENSE))),
    ));
    for (name, spacing, cold) in [
        ("rejected, cached normal", APART, false),
        ("rejected, cold start", APART, true),
        ("dense, cold start", DENSE, true),
    ] {
        let make = move || Scene {
            cold,
            ..packed(full, &Packing::new(full.semi_axes, spacing))
        };
        makers.push((name.into(), true, Box::new(make)));
    }
    let single = move || Scene {
        single: true,
        ..packed(full, &Packing::new(full.semi_axes, DENSE))
    };
    makers.push(("one contact at a time".into(), false, Box::new(single)));
    for case in layer::CASES {
        makers.push((case.name.into(), false, Box::new(move || layered(case))));
    }
    makers
}

/// A program that waits to be asked for steps.
struct Player {
    child: Child,
    questions: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Player {
    fn start(command: &Path, scene: &Path, set: &str) -> Result<Self> {
        let mut child = on_one_core(find_program("taskset").as_deref(), command)
            .arg(scene)
            .arg("time")
            .env("ELLGRAN_INSTRUCTION_SET", set)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .with_context(|| format!("cannot start {}", command.display()))?;
        let questions = child.stdin.take().context("a pipe was asked for")?;
        let answers = BufReader::new(child.stdout.take().context("a pipe was asked for")?);
        let mut player = Player {
            child,
            questions,
            answers,
        };
        // How many contacts there are: it is ready.
        player.answer()?;
        Ok(player)
    }

    fn answer(&mut self) -> Result<f64> {
        let mut line = String::new();
        self.answers.read_line(&mut line)?;
        line.trim()
            .parse()
            .context("a revision stopped playing; what it said is above")
    }

    /// Processor time of so many steps, ns.
    fn steps(&mut self, count: usize) -> Result<f64> {
        writeln!(self.questions, "{count}")?;
        self.questions.flush()?;
        self.answer()
    }
}

impl Drop for Player {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// In turns, of which every other one begins with the other.
fn in_turns(
    turns: usize,
    mut here: impl FnMut() -> Result<f64>,
    mut there: impl FnMut() -> Result<f64>,
) -> Result<(Vec<f64>, Vec<f64>)> {
    let (mut of_here, mut of_there) = (Vec::new(), Vec::new());
    for turn in 0..turns {
        if turn % 2 == 0 {
            of_here.push(here()?);
            of_there.push(there()?);
        } else {
            of_there.push(there()?);
            of_here.push(here()?);
        }
    }
    Ok((of_here, of_there))
}

fn kernels(here: &Revision, there: &Revision, effort: &Effort) -> Result<Vec<Pairing>> {
    let scratch = tempfile::tempdir()?;
    let program = |revision: &Revision, name: &str| -> Result<PathBuf> {
        let directory = scratch.path().join(name);
        fs::create_dir_all(&directory)?;
        revision.player(&directory)
    };
    let programs = [program(here, "here")?, program(there, "there")?];
    let file = scratch.path().join("scene");
    let sets = Contender::instruction_sets();
    let makers = makers();
    let mut rows = Vec::new();
    let mut progress = Progress::start("Kernels of both");
    for (k, (name, on_all, make)) in makers.iter().enumerate() {
        fs::write(&file, make().text())?;
        let sets = if *on_all {
            &sets[..]
        } else {
            &sets[sets.len() - 1..]
        };
        for set in sets {
            progress.update(
                Some(k as f64 / makers.len() as f64),
                &format!("{name}, {set}"),
            );
            let [mut first, mut second] =
                [&programs[0], &programs[1]].map(|program| Player::start(program, &file, set));
            let ([first, second], steps) = match (&mut first, &mut second) {
                (Ok(first), Ok(second)) => {
                    let one = first.steps(4)?.min(second.steps(4)?) / 4.0;
                    ([first, second], ((effort.length / one) as usize).max(1))
                }
                (Err(why), _) | (_, Err(why)) => {
                    say(format!("{name}, {set} is left out: {why:#}"));
                    continue;
                }
            };
            let per_step = |player: &mut Player| Ok(player.steps(steps)? / steps as f64);
            let (here, there) = in_turns(effort.turns, || per_step(first), || per_step(second))?;
            rows.push(Pairing {
                name: name.clone(),
                set,
                here,
                there,
            });
        }
    }
    progress.finish();
    Ok(rows)
}

/// Pair times of the scenes of the benchmark, on the widest lanes.
fn in_lammps(there: &Revision, scenes: &[&scenes::Scene], effort: &Effort) -> Result<Vec<Pairing>> {
    let lammps = Lammps::prepare()?;
    let source = lammps::source()?;
    let mut other = lammps.clone();
    other.plugin = plugin::of_revision(&source, there)?;
    let engines = [lammps, other].map(|lammps| Engines {
        lammps,
        time_lammps: true,
        liggghts: None,
    });
    let sets = Contender::instruction_sets();
    let set = sets[sets.len() - 1];
    let mut progress = Progress::start("Scenes in LAMMPS with both");
    let mut rows = Vec::new();
    for (k, scene) in scenes.iter().enumerate() {
        progress.update(Some(k as f64 / scenes.len() as f64), scene.name);
        let run = scenes::pair_time(
            &engines[0],
            scene,
            Contender::Ours(set),
            effort.engine_seconds,
        )?;
        let (here, there) = in_turns(
            effort.engine_turns,
            || run(&engines[0]),
            || run(&engines[1]),
        )?;
        rows.push(Pairing {
            name: format!("{}, pair time in LAMMPS", scene.name),
            set,
            here,
            there,
        });
    }
    progress.finish();
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ratio_is_that_of_turns_and_its_scatter_that_of_the_middle_half() {
        let row = Pairing {
            name: "scene".into(),
            set: "avx2",
            here: vec![1.0, 2.2, 3.0, 4.0, 500.0],
            there: vec![1.0, 2.0, 3.0, 4.0, 5.0],
        };
        let (ratio, scatter) = row.ratio();
        assert!(
            (ratio - 1.0).abs() < 1e-15 && (scatter - 0.05).abs() < 1e-15,
            "{ratio} {scatter}"
        );
        assert!(csv(&[row]).contains("\"scene\",avx2,1,2.2,2.0\n"));
    }

    #[test]
    fn every_other_turn_begins_with_the_other() {
        let order = std::cell::RefCell::new(String::new());
        let call = |name: char, time: f64| {
            order.borrow_mut().push(name);
            Ok(time)
        };
        let (here, there) = in_turns(3, || call('a', 1.0), || call('b', 2.0)).unwrap();
        assert_eq!(order.into_inner(), "abbaab");
        assert_eq!((here, there), (vec![1.0; 3], vec![2.0; 3]));
    }

    /// A build against itself: scenes of pairs and of a wall are timed, step for step.
    #[test]
    fn a_build_is_timed_against_itself() {
        let directory = tempfile::tempdir().unwrap();
        let program = crate::revisions::test_player(directory.path());
        let file = directory.path().join("scene");
        let set = "baseline";
        for scene in [layered(&layer::CASES[0]), layered(&layer::CASES[2])] {
            fs::write(&file, scene.text()).unwrap();
            let mut players = [(); 2].map(|()| Player::start(&program, &file, set).unwrap());
            let [first, second] = &mut players;
            let (here, there) = in_turns(2, || first.steps(3), || second.steps(3)).unwrap();
            assert!(here.iter().chain(&there).all(|time| *time > 0.0));
        }
        fs::write(&file, "types 1\nlaw nonsense\n").unwrap();
        assert!(Player::start(&program, &file, set).is_err());
    }
}
