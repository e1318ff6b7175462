// SPDX-License-Identifier: MIT OR Apache-2.0
//! One run of the benchmark deck in LIGGGHTS, and what its timing breakdown says.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{bail, Context, Result};

use super::contender::Model;
use super::lammps_run::{copy_into, on_one_core, path_word, Timing};
use crate::liggghts::{self, Optimisation};
use crate::packed_grains::PackedGrains;
use crate::process::{find_program, output_of};
use crate::workspace;

pub struct Liggghts {
    binaries: Vec<(Optimisation, PathBuf)>,
    taskset: Option<PathBuf>,
}

/// A packing as LIGGGHTS reads it.
#[derive(Clone)]
pub struct Files {
    data: PathBuf,
    orientations: PathBuf,
}

impl Files {
    /// Beside the data file of LAMMPS, made when missing.
    pub fn of(packing: &Path) -> Result<Self> {
        let files = Files {
            data: packing.with_extension("liggghts.data"),
            orientations: packing.with_extension("orientations"),
        };
        if !files.data.is_file() || !files.orientations.is_file() {
            let text = fs::read_to_string(packing)
                .with_context(|| format!("cannot read {}", packing.display()))?;
            let grains = PackedGrains::read(&text)
                .with_context(|| format!("{} is not understood", packing.display()))?;
            let orientations = if grains.spheres {
                "# spheres\n".to_string()
            } else {
                grains.liggghts_orientations()
            };
            fs::write(&files.orientations, orientations)?;
            fs::write(&files.data, grains.liggghts_data())?;
        }
        Ok(files)
    }
}

impl Liggghts {
    /// Fetches and builds what is missing.
    pub fn prepare(optimisations: &[Optimisation]) -> Result<Self> {
        Ok(Liggghts {
            binaries: optimisations
                .iter()
                .map(|&optimisation| Ok((optimisation, liggghts::binary_with(optimisation)?)))
                .collect::<Result<_>>()?,
            taskset: find_program("taskset"),
        })
    }

    pub fn optimisations(&self) -> impl Iterator<Item = Optimisation> + '_ {
        self.binaries.iter().map(|(optimisation, _)| *optimisation)
    }

    pub fn binary(&self, optimisation: Optimisation) -> Result<&Path> {
        self.binaries
            .iter()
            .find(|(one, _)| *one == optimisation)
            .map(|(_, binary)| binary.as_path())
            .with_context(|| format!("no LIGGGHTS was built with {}", optimisation.flag()))
    }

    /// Runs the packing; times are processor times, as nearly as they can be told.
    pub fn run(
        &self,
        optimisation: Optimisation,
        model: Model,
        files: &Files,
        warm: usize,
        steps: usize,
    ) -> Result<Timing> {
        let deck = workspace::root().join("examples/liggghts/bench/run.lig");
        let directory = tempfile::tempdir()?;
        let binary = copy_into(directory.path(), self.binary(optimisation)?)?;
        let mut command = on_one_core(self.taskset.as_deref(), &binary);
        command
            .current_dir(directory.path())
            .args(["-log", "none", "-in"])
            .arg(&deck);
        let mut variables = model.variables();
        variables.extend([
            ("data", path_word(&files.data)?),
            ("orientations", path_word(&files.orientations)?),
            ("warm", warm.to_string()),
            ("steps", steps.to_string()),
        ]);
        for (name, value) in variables {
            command.args(["-var", name, &value]);
        }
        let (before, started) = (children_seconds(), Instant::now());
        let output = output_of(&mut command)
            .with_context(|| format!("LIGGGHTS stopped in {}", deck.display()))?;
        let elapsed = started.elapsed().as_secs_f64();
        // Its breakdown is of wall-clock times. The whole process' share of the processor stands for that of each part.
        let share = match (before, children_seconds()) {
            (Some(before), Some(after)) => ((after - before) / elapsed).clamp(0.0, 1.0),
            _ => 1.0,
        };
        timing(&output, share)
    }
}

/// Processor time of all programs that this one has run to their end; where there is no /proc nobody knows.
fn children_seconds() -> Option<f64> {
    let text = fs::read_to_string("/proc/self/stat").ok()?;
    // After the name in parentheses, which may hold anything.
    let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks: f64 = fields.get(13)?.parse::<f64>().ok()? + fields.get(14)?.parse::<f64>().ok()?;
    let output = output_of(Command::new("getconf").arg("CLK_TCK")).ok()?;
    Some(ticks / output.trim().parse::<f64>().ok()?)
}

fn timing(output: &str, share: f64) -> Result<Timing> {
    let lines: Vec<&str> = output.lines().collect();
    for (at, line) in lines.iter().enumerate().rev() {
        // Loop time of 0.478 on 1 procs for 50 steps with 512 atoms, finish time ...
        let words: Vec<&str> = line.split_whitespace().collect();
        if !line.starts_with("Loop time of") || words.len() < 12 {
            continue;
        }
        let number = |k: usize| -> Result<f64> { Ok(words[k].parse::<f64>()?) };
        let (wall, steps, atoms) = (number(3)?, number(8)?, number(11)?);
        let after = |title: &str| {
            lines[at..]
                .iter()
                .find_map(|line| line.strip_prefix(title)?.split_once('='))
                .and_then(|(_, rest)| rest.split_whitespace().next())
                .with_context(|| format!("LIGGGHTS printed no '{title}'"))?
                .parse::<f64>()
                .with_context(|| format!("'{title}' is followed by no number"))
        };
        let pair = after("Pair ")?;
        return Ok(Timing {
            atoms,
            steps,
            pair: pair * share,
            step: wall * share,
            pair_wall: pair,
            wall,
            pairs: after("Total # of neighbors ")?,
            builds: after("Neighbor list builds ")?,
            of_rank: None,
        });
    }
    bail!("LIGGGHTS printed no 'Loop time'")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_breakdown_is_scaled_to_processor_time() {
        let output = "Loop time of 2 on 1 procs for 400 steps with 500 atoms, finish time now\n\nPair  time (%) = 1.5 (75)\nNeigh time (%) = 0 (0)\nTotal # of neighbors = 7675\nAve neighs/atom = 15\nNeighbor list builds = 3\n";
        let found = timing(output, 0.5).unwrap();
        assert_eq!(found.atoms, 500.0);
        assert_eq!(found.steps, 400.0);
        assert_eq!(found.pair, 0.75);
        assert_eq!(found.pair_wall, 1.5);
        assert_eq!(found.step, 1.0);
        assert_eq!(found.pairs, 7675.0);
        assert_eq!(found.builds, 3.0);
        assert!(timing("nothing", 1.0).is_err());
    }
}
