// SPDX-License-Identifier: MIT OR Apache-2.0
//! Stiff and extreme: random and adversarial pairs through the list path on each instruction set (validation/stress), a sample of them
//! against the reference with 60 digits, steps up to and beyond stability, and the page of it.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result};

use crate::bench::machine;
use crate::process::{jobs, run_open};
use crate::progress::{human_time, say};
use crate::python_environment::Environment;
use crate::workspace::{cargo, root};

/// Where nothing is said: long enough for some ten thousand pairs of each family.
const MINUTES: f64 = 5.0;
const NIGHT: f64 = 10.0 * 60.0;

#[derive(clap::Args)]
pub struct Options {
    /// Until so many pairs are done, those of earlier parts of the run among them
    #[arg(long, conflicts_with_all = ["minutes", "hours", "night"])]
    pairs: Option<u64>,
    /// So many minutes more [default: 5]
    #[arg(long, conflicts_with_all = ["hours", "night"])]
    minutes: Option<f64>,
    /// So many hours more
    #[arg(long, conflicts_with = "night")]
    hours: Option<f64>,
    /// Ten hours more
    #[arg(long)]
    night: bool,
    /// Threads [default: all cores]
    #[arg(long)]
    threads: Option<usize>,
    /// What the pairs are drawn from; another one is another run, and needs another --state
    #[arg(long, default_value_t = 2013)]
    seed: u64,
    /// Go on with the run that is stored in validation/stress, with the instruction sets of this machine
    #[arg(long, conflicts_with = "seed")]
    stored: bool,
    /// The directory that the run is kept in, and gone on from [default: stress-output in the checkout]
    #[arg(long)]
    state: Option<PathBuf>,
}

pub fn stress(options: &Options) -> Result<()> {
    let started = Instant::now();
    let directory = options
        .state
        .clone()
        .unwrap_or_else(|| root().join("stress-output"));
    std::fs::create_dir_all(&directory)
        .with_context(|| format!("cannot make {}", directory.display()))?;
    let directory = directory.canonicalize()?;
    let file = |name: &str| directory.join(name);
    let environment = Environment::pinned(&root().join("validation/reference/requirements.txt"))
        .context("the reference needs packages for this Python")?;
    let seed = if options.stored {
        go_on_with_stored(&file("state.json"))?
    } else {
        options.seed
    };
    let seed = seed.to_string();
    let state = [Path::new("--state"), &file("state.json")].map(|p| p.as_os_str().to_owned());
    let threads = options.threads.unwrap_or_else(jobs).to_string();
    let minutes = match (options.minutes, options.hours, options.night) {
        (Some(minutes), ..) => minutes,
        (_, Some(hours), _) => 60.0 * hours,
        (.., true) => NIGHT,
        _ => MINUTES,
    };
    let length = match options.pairs {
        Some(pairs) => ["--pairs".to_string(), pairs.to_string()],
        None => ["--seconds".to_string(), (60.0 * minutes).to_string()],
    };
    say("== pairs (the program is built first when it changed)");
    run_open(program().arg("run").args(&length).args(&state).args([
        "--seed",
        &seed,
        "--threads",
        &threads,
    ]))?;
    say("== a sample against the reference with 60 digits");
    run_open(
        program()
            .arg("sample")
            .args(&state)
            .args(["--seed", &seed, "--to"])
            .arg(file("sample.json")),
    )?;
    run_open(
        environment
            .python()
            .arg(folder().join("reference.py"))
            .args([file("sample.json"), file("reference.csv")]),
    )?;
    say("== steps up to and beyond stability");
    run_open(
        program()
            .args(["stability", "--to"])
            .arg(file("stability.csv")),
    )?;
    let origin = serde_json::json!({
        "command": said_as(options),
        "machine": machine::describe(),
        "version": env!("CARGO_PKG_VERSION"),
    });
    std::fs::write(
        file("origin.json"),
        serde_json::to_string_pretty(&origin)? + "\n",
    )?;
    run_open(
        environment
            .python()
            .arg(folder().join("page.py"))
            .arg(&directory),
    )?;
    say(format!("done in {}", human_time(started.elapsed())));
    Ok(())
}

/// Takes the stored run for the one that is gone on with, if that has none yet; its seed.
fn go_on_with_stored(state: &Path) -> Result<u64> {
    let stored = folder().join("state.json");
    if !state.exists() {
        std::fs::copy(&stored, state)
            .with_context(|| format!("cannot copy {}", stored.display()))?;
    }
    let text = std::fs::read_to_string(&stored)?;
    let read: serde_json::Value = serde_json::from_str(&text)?;
    read["seed"]
        .as_u64()
        .with_context(|| format!("{} has no seed", stored.display()))
}

fn folder() -> PathBuf {
    root().join("validation").join("stress")
}

fn program() -> Command {
    let mut command = cargo();
    command.args([
        "bench",
        "--quiet",
        "--package",
        "ellgran",
        "--bench",
        "stress",
        "--",
    ]);
    command
}

/// The command line of these options.
fn said_as(options: &Options) -> String {
    let mut command = String::from("cargo xtask stress");
    let mut add = |name: &str, value: Option<String>| {
        if let Some(value) = value {
            command += &format!(" --{name} {value}");
        }
    };
    add("pairs", options.pairs.map(|n| n.to_string()));
    add("minutes", options.minutes.map(|m| m.to_string()));
    add("hours", options.hours.map(|h| h.to_string()));
    add("threads", options.threads.map(|n| n.to_string()));
    add(
        "seed",
        (options.seed != 2013).then(|| options.seed.to_string()),
    );
    for (is_given, word) in [(options.stored, " --stored"), (options.night, " --night")] {
        if is_given {
            command += word;
        }
    }
    command
}
