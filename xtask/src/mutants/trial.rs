// SPDX-License-Identifier: MIT OR Apache-2.0
//! One test in a process of its own, with one mutant on or none.

use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};

use super::copy::{Program, Switch};

/// Address space of a test, kB: a mutant that never ends may also fill the memory.
const MOST_MEMORY: u64 = 6_000_000;

/// Of a processor: what a mutant may take at least, and how many times that of the original. A slow machine does not change it.
const LEAST_LIMIT: f64 = 2.0;
const TIMES_THE_ORIGINAL: f64 = 5.0;

/// Seconds by the clock, for one that waits and never ends.
const LONGEST_WAIT: f64 = 600.0;

#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Test {
    pub program: PathBuf,
    pub name: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    Passed,
    Failed,
    /// It took many times as long as the original.
    NeverEnds,
}

/// The tests of a program, by name.
pub fn tests_of(program: &Program) -> Result<Vec<Test>> {
    let mut command = Command::new(&program.path);
    let text = crate::process::output_of(command.args(["--list", "--format", "terse"]))?;
    let names = text.lines().filter_map(|line| line.strip_suffix(": test"));
    Ok(names
        .map(|name| Test {
            program: program.path.clone(),
            name: name.to_string(),
        })
        .collect())
}

impl Test {
    /// The same random cases each time, and no search for the simplest one that fails: that it fails is all that counts.
    fn command(&self, limit: f64) -> Command {
        let mut command = Command::new("sh");
        command
            .args(["-c", "ulimit -t $0; ulimit -v $1; shift; exec \"$@\""])
            .arg((limit.ceil() as u64).to_string())
            .arg(MOST_MEMORY.to_string())
            .arg(&self.program)
            .args(["--exact", &self.name, "--test-threads", "1"])
            .env("PROPTEST_RNG_SEED", "1")
            .env("PROPTEST_MAX_SHRINK_ITERS", "0")
            .env("PROPTEST_DISABLE_FAILURE_PERSISTENCE", "true")
            .env("RUST_BACKTRACE", "0")
            .env_remove("ELLGRAN_MUTANT")
            .env_remove("ELLGRAN_MUTANTS_SEEN")
            .stdin(Stdio::null());
        command
    }

    /// The original, watched where a file is given: seconds, whether it passes, what it says.
    pub fn original(&self, seen: Option<&std::path::Path>) -> Result<(f64, bool, String)> {
        let mut command = self.command(LONGEST_WAIT);
        if let Some(seen) = seen {
            command.env("ELLGRAN_MUTANTS_SEEN", seen);
        }
        let started = Instant::now();
        let output = command.output().context("cannot start a test")?;
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        let seconds = started.elapsed().as_secs_f64();
        Ok((seconds, output.status.success(), said))
    }

    /// With a mutant; the original takes so many seconds. Without a switch the program itself is the mutant.
    pub fn mutated(&self, mutant: Option<Switch>, seconds: f64) -> Result<Verdict> {
        let limit = LEAST_LIMIT + TIMES_THE_ORIGINAL * seconds;
        let mut command = self.command(limit);
        command.stdout(Stdio::null()).stderr(Stdio::null());
        if let Some(Switch { place, choice }) = mutant {
            command.env("ELLGRAN_MUTANT", format!("{place}:{choice}"));
        }
        let child = command.spawn().context("cannot start a test")?;
        wait(child)
    }
}

fn wait(mut child: Child) -> Result<Verdict> {
    use std::os::unix::process::ExitStatusExt;
    let end = Instant::now() + Duration::from_secs_f64(LONGEST_WAIT);
    let mut pause = Duration::from_micros(500);
    loop {
        if let Some(status) = child.try_wait()? {
            // SIGKILL and SIGXCPU: more time than the limit.
            return Ok(match (status.success(), status.signal()) {
                (true, _) => Verdict::Passed,
                (_, Some(9 | 24)) => Verdict::NeverEnds,
                _ => Verdict::Failed,
            });
        }
        if Instant::now() > end {
            child.kill()?;
            child.wait()?;
            return Ok(Verdict::NeverEnds);
        }
        std::thread::sleep(pause);
        pause = (pause * 5 / 4).min(Duration::from_millis(50));
    }
}
