// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do the tests notice a changed formula? Each mutant of the contact law and of the geometry is compiled without the lanes and held against the
//! tests of the theory and of the properties, by cargo-mutants. A run can be stopped and gone on with; what came out is stored.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use anyhow::{bail, Context, Result};

use crate::process::{output_of, run_open};
use crate::progress::{human_time, say};
use crate::workspace::{cargo, root, target_directory};
use crate::{cache, demo::table::Table};

/// Of cargo-mutants.
const VERSION: &str = "27.1.0";

/// What is mutated.
const FILES: [&str; 2] = ["src/force/**", "src/geometry/**"];

/// The tests that may kill a mutant, and what of them needs lanes.
const TESTS: [&str; 2] = ["theory", "properties"];
const NEEDS_LANES: [&str; 5] = [
    "free_rotation",
    "global_minimum",
    "lone_contacts",
    "preparation",
    "walls_in_lanes",
];

/// Seconds after which a mutant is taken for one that never ends; the tests take a quarter of a minute.
const LONGEST: u32 = 120;

/// What can become of a mutant: the names of the lists that cargo-mutants writes.
const OUTCOMES: [&str; 4] = ["caught", "missed", "timeout", "unviable"];

#[derive(clap::Args)]
pub struct Options {
    /// How long; then the run stops, to be gone on with
    #[arg(long, default_value_t = 60.0)]
    minutes: f64,
    /// Mutants at a time
    #[arg(long, default_value_t = 1)]
    jobs: usize,
    /// Files to mutate [default: src/force/** and src/geometry/**]
    #[arg(long)]
    file: Vec<String>,
    /// Only those that were missed, since tests have been added
    #[arg(long)]
    missed: bool,
}

pub fn mutants(options: &Options) -> Result<()> {
    let started = Instant::now();
    let program = program()?;
    let files: Vec<String> = if options.file.is_empty() {
        FILES.map(str::to_string).into()
    } else {
        options.file.clone()
    };
    let all = list(&program, &FILES.map(str::to_string))?;
    let wanted = list(&program, &files)?;
    let mut stored = Stored::read(&all)?;
    let left: BTreeSet<String> = if options.missed {
        stored.take_missed(&wanted)
    } else {
        let untried = wanted.iter().filter(|m| !stored.has(m));
        untried.cloned().collect()
    };
    say(format!(
        "{} mutants, {} of them to be tried",
        wanted.len(),
        left.len()
    ));
    if !left.is_empty() {
        let output = target_directory()?.join("mutants");
        let _ = fs::remove_dir_all(&output);
        let tried: Vec<String> = wanted.difference(&left).cloned().collect();
        run(&program, &files, &tried, options, &output)?;
        stored.add(&output.join("mutants.out"))?;
        stored.write()?;
    }
    println!("{}", stored.table(&all).markdown());
    say(format!(
        "the lists are in validation/mutants; done in {}",
        human_time(started.elapsed())
    ));
    Ok(())
}

/// cargo-mutants, installed in the cache.
fn program() -> Result<PathBuf> {
    let _lock = cache::lock("cargo-mutants")?;
    let place = cache::directory()?.join(format!("cargo-mutants-{VERSION}"));
    let program = place.join("bin").join("cargo-mutants");
    if !program.is_file() {
        say(format!("installing cargo-mutants {VERSION}"));
        let version = format!("={VERSION}");
        let mut install = cargo();
        install.args([
            "install",
            "--quiet",
            "--locked",
            "cargo-mutants",
            "--version",
        ]);
        run_open(install.arg(version).arg("--root").arg(&place))?;
    }
    Ok(program)
}

fn command(program: &Path, files: &[String]) -> Command {
    let mut command = Command::new(program);
    command
        .current_dir(root())
        .args(["mutants", "--package", "ellgran", "--colors", "never"]);
    for file in files {
        command.args(["--file", file]);
    }
    command
}

/// All mutants of some files.
fn list(program: &Path, files: &[String]) -> Result<BTreeSet<String>> {
    let text = output_of(command(program, files).arg("--list"))?;
    Ok(text.lines().map(str::to_string).collect())
}

/// Runs those that have not been tried, for so long.
fn run(
    program: &Path,
    files: &[String],
    tried: &[String],
    options: &Options,
    output: &Path,
) -> Result<()> {
    // What cargo-mutants leaves out are those that an earlier run of its own has caught.
    let lists = output.join("mutants.out");
    fs::create_dir_all(&lists)?;
    fs::write(lists.join("caught.txt"), lines(tried))?;
    for other in ["missed", "timeout", "unviable"] {
        fs::write(lists.join(format!("{other}.txt")), "")?;
    }
    fs::write(lists.join("outcomes.json"), "{\"outcomes\":[]}")?;
    let mut command = command(program, files);
    command
        .env("RUSTFLAGS", "--cfg ellgran_without_lanes")
        .env_remove("CARGO_TARGET_DIR")
        .args([
            "--iterate",
            "--shuffle",
            "--no-times",
            "--cap-lints",
            "true",
        ])
        .args(["--profile", "mutants", "--timeout", &LONGEST.to_string()])
        .args(["--jobs", &options.jobs.to_string(), "--output"])
        .arg(output)
        .arg("--");
    for test in TESTS {
        command.args(["--test", test]);
    }
    command.arg("--");
    for test in NEEDS_LANES {
        command.args(["--skip", test]);
    }
    let mut child = command.spawn().context("cannot start cargo-mutants")?;
    let end = Instant::now() + Duration::from_secs_f64(60.0 * options.minutes);
    loop {
        if let Some(status) = child.try_wait()? {
            // 2: some were missed, 3: some never ended.
            return match status.code() {
                Some(0 | 2 | 3) => Ok(()),
                _ => bail!("cargo-mutants: {status}"),
            };
        }
        if Instant::now() > end {
            // It takes an interrupt for the end, and writes each outcome at once.
            let identifier = child.id().to_string();
            run_open(Command::new("kill").args(["-INT", &identifier]))?;
            child.wait()?;
            return Ok(());
        }
        std::thread::sleep(Duration::from_secs(1));
    }
}

fn lines<'a>(names: impl IntoIterator<Item = &'a String>) -> String {
    names.into_iter().map(|name| format!("{name}\n")).collect()
}

/// What became of the mutants of the present sources.
struct Stored {
    by_outcome: BTreeMap<&'static str, BTreeSet<String>>,
}

impl Stored {
    fn file(outcome: &str) -> PathBuf {
        root()
            .join("validation/mutants")
            .join(format!("{outcome}.txt"))
    }

    /// Outcomes of mutants that there still are; a file that was changed has new ones.
    fn read(all: &BTreeSet<String>) -> Result<Stored> {
        let mut by_outcome = BTreeMap::new();
        for outcome in OUTCOMES {
            let text = fs::read_to_string(Self::file(outcome)).unwrap_or_default();
            let names = text.lines().map(str::to_string);
            by_outcome.insert(outcome, names.filter(|name| all.contains(name)).collect());
        }
        Ok(Stored { by_outcome })
    }

    fn has(&self, name: &str) -> bool {
        self.by_outcome.values().any(|names| names.contains(name))
    }

    /// Takes out those that were missed among these. What a run does not come to is then as if it had never been tried.
    fn take_missed(&mut self, of: &BTreeSet<String>) -> BTreeSet<String> {
        let missed = self.by_outcome.entry("missed").or_default();
        let (taken, kept) = missed.iter().cloned().partition(|name| of.contains(name));
        *missed = kept;
        taken
    }

    fn add(&mut self, lists: &Path) -> Result<()> {
        for outcome in OUTCOMES {
            let file = lists.join(format!("{outcome}.txt"));
            let text = fs::read_to_string(&file)
                .with_context(|| format!("cannot read {}", file.display()))?;
            for name in text.lines().filter(|name| !name.is_empty()) {
                if !self.has(name) {
                    let names = self.by_outcome.entry(outcome).or_default();
                    names.insert(name.to_string());
                }
            }
        }
        Ok(())
    }

    fn write(&self) -> Result<()> {
        for (outcome, names) in &self.by_outcome {
            let file = Self::file(outcome);
            fs::create_dir_all(file.parent().context("no folder")?)?;
            fs::write(&file, lines(names))
                .with_context(|| format!("cannot write {}", file.display()))?;
        }
        Ok(())
    }

    fn table(&self, all: &BTreeSet<String>) -> Table {
        let mut table = Table::new(
            "Mutants of the contact law and of the geometry",
            &[
                "file",
                "mutants",
                "tried",
                "caught",
                "never end",
                "cannot be compiled",
                "missed",
            ],
        );
        let file_of = |name: &str| name.split(':').next().unwrap_or_default().to_string();
        let files: BTreeSet<String> = all.iter().map(|name| file_of(name)).collect();
        for file in &files {
            let of = |outcome: &str| {
                let names = &self.by_outcome[outcome];
                names.iter().filter(|name| file_of(name) == *file).count()
            };
            let counts = OUTCOMES.map(of);
            let [caught, missed, never_end, cannot] = counts;
            let there_are = all.iter().filter(|name| file_of(name) == *file).count();
            let numbers = [
                there_are,
                counts.iter().sum(),
                caught,
                never_end,
                cannot,
                missed,
            ];
            let mut row = vec![file.clone()];
            row.extend(numbers.map(|n| n.to_string()));
            table.row(row);
        }
        table
    }
}
