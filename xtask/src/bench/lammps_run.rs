// SPDX-License-Identifier: MIT OR Apache-2.0
//! One run of a benchmark deck in LAMMPS, and what its timing breakdown says.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{bail, Context, Result};

use crate::process::{find_program, output_of};
use crate::progress::say;
use crate::{lammps, mpi, plugin};

#[derive(Clone)]
pub struct Lammps {
    pub binary: PathBuf,
    pub plugin: PathBuf,
    /// The release, as LAMMPS spells it.
    pub release: String,
    /// Has it `pair_style granular/superellipsoid`, which came in 2026?
    pub superellipsoid: bool,
    taskset: Option<PathBuf>,
}

/// What a run printed about its last `run` of more than no steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    pub atoms: f64,
    pub steps: f64,
    /// Processor time of the pair style, s.
    pub pair: f64,
    /// Processor time of the whole step, s.
    pub step: f64,
    /// Wall-clock time of the pair style (mean over ranks), s.
    pub pair_wall: f64,
    /// Wall-clock time of the whole loop, s.
    pub wall: f64,
    /// Pairs in the neighbour list.
    pub pairs: f64,
    /// How often the list was built.
    pub builds: f64,
    /// LAMMPS alone says it.
    pub of_rank: Option<OfRank>,
}

/// Means over the ranks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OfRank {
    /// Images of atoms, of other ranks' and of periodic ones.
    pub ghosts: f64,
    /// Wall-clock time of communication, s.
    pub communication: f64,
    /// What LAMMPS counts of its memory, bytes.
    pub memory: f64,
}

impl Timing {
    /// Nanoseconds per grain and step.
    pub fn per_grain(&self, seconds: f64) -> f64 {
        1e9 * seconds / (self.atoms * self.steps)
    }
}

impl Lammps {
    /// Fetches and builds what is missing.
    pub fn prepare() -> Result<Self> {
        let source = lammps::source()?;
        let binary = source.binary()?;
        let plugin = plugin::plugin(&source)?;
        let help = help(&binary)?;
        Ok(Self::with(binary, plugin, source.spelled()?, &help))
    }

    /// One that is there already, with a plugin that fits it.
    pub fn given(binary: &Path, plugin: &Path) -> Result<Self> {
        let found = |option: &str, file: &Path| {
            file.canonicalize()
                .with_context(|| format!("{option} {}", file.display()))
        };
        let (binary, plugin) = (found("--lammps", binary)?, found("--plugin", plugin)?);
        let help = help(&binary)?;
        let release = release(&help)
            .with_context(|| format!("{} -help names no release", binary.display()))?
            .to_string();
        Ok(Self::with(binary, plugin, release, &help))
    }

    fn with(binary: PathBuf, plugin: PathBuf, release: String, help: &str) -> Self {
        let taskset = find_program("taskset");
        if taskset.is_none() {
            say("no taskset: runs are not pinned to a core");
        }
        Lammps {
            superellipsoid: help
                .split_whitespace()
                .any(|word| word == "granular/superellipsoid"),
            release,
            binary,
            plugin,
            taskset,
        }
    }

    /// Runs a deck of examples/lammps/bench on `ranks` ranks (one is pinned to a core); what it printed.
    pub fn run(
        &self,
        deck: &str,
        ranks: usize,
        instruction_set: Option<&str>,
        variables: &[(&str, String)],
    ) -> Result<String> {
        let directory = tempfile::tempdir()?;
        fs::write(directory.path().join(deck), text_of(deck)?)?;
        let plugin = copy_into(directory.path(), &self.plugin)?;
        let mut command = match ranks {
            1 => on_one_core(self.taskset.as_deref(), &self.binary),
            _ => {
                let mut command = Command::new(mpi::mpirun()?);
                command
                    .args(["-np", &ranks.to_string()])
                    .arg(&self.binary)
                    .envs(mpi::mpirun_environment());
                command
            }
        };
        command
            .current_dir(directory.path())
            .env("OMP_NUM_THREADS", "1")
            .args(["-nocite", "-log", "none", "-in", deck])
            .args(["-var", "plugin"])
            .arg(&plugin);
        match instruction_set {
            Some(set) => command.env("ELLGRAN_INSTRUCTION_SET", set),
            None => command.env_remove("ELLGRAN_INSTRUCTION_SET"),
        };
        for (name, value) in variables {
            command.args(["-var", name, value]);
        }
        output_of(&mut command).with_context(|| format!("LAMMPS stopped in {deck}"))
    }
}

/// The decks of examples/lammps/bench, within this program: it measures also where no checkout is.
const DECKS: [(&str, &str); 4] = [
    (
        "layer.lmp",
        include_str!("../../../examples/lammps/bench/layer.lmp"),
    ),
    (
        "make.lmp",
        include_str!("../../../examples/lammps/bench/make.lmp"),
    ),
    (
        "run.lmp",
        include_str!("../../../examples/lammps/bench/run.lmp"),
    ),
    (
        "sizes.lmp",
        include_str!("../../../examples/lammps/bench/sizes.lmp"),
    ),
];

/// What a deck of examples/lammps/bench says.
pub fn text_of(deck: &str) -> Result<&'static str> {
    DECKS
        .iter()
        .find_map(|(name, text)| (*name == deck).then_some(*text))
        .with_context(|| format!("no {deck} in examples/lammps/bench"))
}

/// Where the pages of a file lie in memory changes the time of the code in it by several per cent, the same in each run for as long as they lie there. With
/// a copy for each run the median is over such places.
pub fn copy_into(directory: &Path, file: &Path) -> Result<PathBuf> {
    let name = file.file_name().context("no file")?;
    let copy = directory.join(name);
    fs::copy(file, &copy).with_context(|| format!("{} cannot be copied", file.display()))?;
    Ok(copy)
}

fn help(binary: &Path) -> Result<String> {
    output_of(Command::new(binary).arg("-help"))
        .with_context(|| format!("{} does not run", binary.display()))
}

/// As LAMMPS spells it, from what it prints for `-help`: ... Massively Parallel Simulator - 4 Jul 2026 - Update 1
fn release(help: &str) -> Option<&str> {
    help.lines()
        .find_map(|line| line.split_once("Parallel Simulator - "))
        .map(|(_, rest)| rest.split(" - ").next().unwrap_or(rest).trim())
}

/// Pinned to a core with `taskset`, where there is one.
pub fn on_one_core(taskset: Option<&Path>, binary: &Path) -> Command {
    let (Some(taskset), Some(core)) = (taskset, quiet_core()) else {
        return Command::new(binary);
    };
    let mut command = Command::new(taskset);
    command.args(["-c", &core.to_string()]).arg(binary);
    command
}

/// Of the cores that this process may use the second: the first of a machine serves most interrupts.
fn quiet_core() -> Option<usize> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let list = status
        .lines()
        .find_map(|line| line.strip_prefix("Cpus_allowed_list:"))?;
    let cores = cores_of(list);
    cores.get(1).or(cores.first()).copied()
}

/// Of a list such as `0-3,8`.
fn cores_of(list: &str) -> Vec<usize> {
    list.trim()
        .split(',')
        .filter_map(|range| {
            let (first, last) = range.split_once('-').unwrap_or((range, range));
            Some(first.parse().ok()?..=last.parse().ok()?)
        })
        .flatten()
        .collect()
}

/// The words of variables that name a file.
pub fn path_word(path: &Path) -> Result<String> {
    Ok(path
        .to_str()
        .with_context(|| format!("{} is not UTF-8", path.display()))?
        .to_string())
}

/// The last breakdown of a run of more than no steps.
pub fn timing(output: &str) -> Result<Timing> {
    let lines: Vec<&str> = output.lines().collect();
    for (at, line) in lines.iter().enumerate().rev() {
        // Loop time of 0.478 on 1 procs for 50 steps with 512 atoms
        let words: Vec<&str> = line.split_whitespace().collect();
        if !line.starts_with("Loop time of") || words.len() < 12 {
            continue;
        }
        let number = |k: usize| -> Result<f64> { Ok(words[k].parse::<f64>()?) };
        let (wall, steps, atoms) = (number(3)?, number(8)?, number(11)?);
        if steps == 0.0 {
            continue;
        }
        let rest = &lines[at..];
        let share = rest
            .iter()
            .find_map(|line| line.split_once("% CPU use").map(|(share, _)| share.trim()))
            .context("LAMMPS printed no '% CPU use'")?
            .parse::<f64>()?;
        let section = |name: &str| -> Result<Vec<f64>> {
            let cells: Vec<f64> = rest
                .iter()
                .find(|line| line.starts_with(name))
                .with_context(|| format!("LAMMPS printed no '{name}' line"))?
                .split('|')
                .skip(1)
                .filter_map(|cell| cell.trim().parse().ok())
                .collect();
            // min, avg, max, variation, % CPU, % total: with `timer full` only.
            if cells.len() != 6 {
                bail!(
                    "the '{name}' line of LAMMPS has {} numbers, not 6",
                    cells.len()
                );
            }
            Ok(cells)
        };
        let pair = section("Pair ")?;
        // ... (min/avg/max) = 11.97 | 11.97 | 11.97 Mbytes
        let memory = lines[..at]
            .iter()
            .rev()
            .find(|line| line.starts_with("Per MPI rank memory allocation"))
            .and_then(|line| line.split('|').nth(1)?.trim().parse::<f64>().ok())
            .context("LAMMPS printed no 'Per MPI rank memory allocation'")?;
        let after = |title: &str| {
            rest.iter()
                .find_map(|line| line.strip_prefix(title))
                .with_context(|| format!("LAMMPS printed no '{title}'"))?
                .split_whitespace()
                .next()
                .unwrap_or_default()
                .parse::<f64>()
                .with_context(|| format!("'{title}' is followed by no number"))
        };
        return Ok(Timing {
            atoms,
            steps,
            pair: pair[1] * pair[4] / 100.0,
            step: wall * share / 100.0,
            pair_wall: pair[1],
            wall,
            pairs: after("Total # of neighbors =")?,
            builds: after("Neighbor list builds =")?,
            of_rank: Some(OfRank {
                ghosts: after("Nghost:")?,
                communication: section("Comm ")?[1],
                memory: memory * 1024.0 * 1024.0,
            }),
        });
    }
    bail!("LAMMPS printed no 'Loop time'")
}

/// Seconds a step in the quiet intervals of the last run, of which a line each says step and time: four of five took longer. Other work on the
/// machine makes intervals longer, never shorter: a mean over all of them scatters by far more.
pub fn quiet_step(output: &str) -> Result<f64> {
    let lines: Vec<&str> = output.lines().collect();
    let end = lines
        .iter()
        .rposition(|line| line.starts_with("Loop time of") && !line.contains(" for 0 steps "))
        .context("LAMMPS printed no 'Loop time'")?;
    let begin = lines[..end]
        .iter()
        .rposition(|line| line.split_whitespace().eq(["Step", "CPU"]))
        .context("LAMMPS printed no 'Step CPU'")?;
    let points = lines[begin + 1..end]
        .iter()
        .filter_map(|line| {
            let mut words = line.split_whitespace().map(str::parse::<f64>);
            Some([words.next()?.ok()?, words.next()?.ok()?])
        })
        .collect::<Vec<_>>();
    let mut steps: Vec<f64> = points
        .windows(2)
        .map(|pair| (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0]))
        .collect();
    steps.sort_by(f64::total_cmp);
    steps
        .get(steps.len() / 5)
        .copied()
        .context("LAMMPS printed no two lines with a time")
}

/// The number after `touching pairs`.
pub fn touching(output: &str) -> Result<f64> {
    output
        .lines()
        .rev()
        .find_map(|line| line.strip_prefix("touching pairs "))
        .context("the deck printed no 'touching pairs'")?
        .trim()
        .parse()
        .context("'touching pairs' is followed by no number")
}

#[cfg(test)]
mod tests {
    use super::*;

    const OUTPUT: &str = "\
Per MPI rank memory allocation (min/avg/max) = 3 | 4.5 | 6 Mbytes
Loop time of 2 on 1 procs for 400 steps with 500 atoms

50.0% CPU use with 1 MPI tasks x 1 OpenMP threads

MPI task timing breakdown:
Section |  min time  |  avg time  |  max time  |%varavg|  %CPU | %total
---------------------------------------------------------------
Pair    | 1.0        | 1.0        | 1.0        |   0.0 |  40.0 | 50.00
Neigh   | 0          | 0          | 0          |   0.0 | 100.0 |  0.00
Comm    | 0.2        | 0.3        | 0.4        |   0.0 | 100.0 | 15.00
Nghost:            184.5 ave         190 max         179 min
Total # of neighbors = 7675
Ave neighs/atom = 14.990234
Neighbor list builds = 3
Per MPI rank memory allocation (min/avg/max) = 7 | 7 | 7 Mbytes
Loop time of 5.69e-07 on 1 procs for 0 steps with 500 atoms
touching pairs 2039.0
";

    #[test]
    fn the_breakdown_is_that_of_the_last_run_with_steps() {
        let found = timing(OUTPUT).unwrap();
        assert_eq!(found.atoms, 500.0);
        assert_eq!(found.pair, 0.4);
        assert_eq!(found.step, 1.0);
        assert_eq!(found.pairs, 7675.0);
        assert_eq!(found.builds, 3.0);
        let of_rank = OfRank {
            ghosts: 184.5,
            communication: 0.3,
            memory: 4.5 * 1024.0 * 1024.0,
        };
        assert_eq!(found.of_rank, Some(of_rank));
        assert!((found.per_grain(found.pair) - 2000.0).abs() < 1e-9);
        assert_eq!(touching(OUTPUT).unwrap(), 2039.0);
        assert!(timing("nothing").is_err());
    }

    #[test]
    fn quiet_intervals_count() {
        let output = |rows: &str| {
            format!(
                "Step CPU\n0 0\n10 9\nLoop time of 9 on 1 procs for 10 steps with 5 atoms\n   Step          CPU      \n{rows}\
                 Loop time of 7 on 1 procs for 50 steps with 5 atoms\nLoop time of 0 on 1 procs for 0 steps with 5 atoms\n"
            )
        };
        // 0.3, 0.2, 0.1, 0.5, 0.6, of which the second smallest
        let found = quiet_step(&output(
            "10 0\n20 3\n30 5\nWARNING: of a fix\n40 6\n50 11\n60 17\n",
        ))
        .unwrap();
        assert!((found - 0.2).abs() < 1e-12, "{found}");
        assert!(quiet_step(&output("10 0\n")).is_err());
        assert!(quiet_step("nothing").is_err());
    }

    #[test]
    fn the_release_is_read_from_the_help() {
        let help = |end: &str| {
            format!(
                "\nLarge-scale Atomic/Molecular Massively Parallel Simulator - {end}\n\nUsage\n"
            )
        };
        assert_eq!(release(&help("4 Jul 2026")), Some("4 Jul 2026"));
        let updated = help("29 Aug 2024 - Update 1");
        assert_eq!(release(&updated), Some("29 Aug 2024"));
        assert_eq!(release("Usage: lmp"), None);
    }

    #[test]
    fn a_process_may_have_any_cores() {
        assert_eq!(cores_of("\t0-3\n"), [0, 1, 2, 3]);
        assert_eq!(cores_of("\t16-17,40\n"), [16, 17, 40]);
        assert_eq!(cores_of("5"), [5]);
        assert!(cores_of("").is_empty());
    }

    #[test]
    fn every_deck_is_within_the_program() {
        let directory = crate::workspace::root().join("examples/lammps/bench");
        for entry in fs::read_dir(directory).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap();
            assert_eq!(text_of(name).unwrap(), fs::read_to_string(&path).unwrap());
        }
        assert!(text_of("none.lmp").is_err());
    }
}
