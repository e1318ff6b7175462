// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tests in a process of their own, with one mutant on or none.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};

use super::copy::{Program, Switch};

/// Address space of a test, kB: a mutant that never ends may also fill the memory.
const MOST_MEMORY: u64 = 6_000_000;

/// Of a processor: what a mutant may take at least, and how many times that of the original. A slow machine does not change it.
const LEAST_LIMIT: f64 = 0.5;
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

/// Some tests of one program, one after the other. The same random cases each time, and no search for the simplest one that
/// fails: that it fails is all that counts.
fn command(tests: &[&Test], limit: f64) -> Command {
    let mut command = Command::new("sh");
    command
        .args(["-c", "ulimit -t $0; ulimit -v $1; shift; exec \"$@\""])
        .arg((limit.ceil() as u64).to_string())
        .arg(MOST_MEMORY.to_string())
        .arg(&tests[0].program)
        .args(["--exact", "--test-threads", "1"])
        .args(tests.iter().map(|test| &test.name))
        .env("PROPTEST_RNG_SEED", "1")
        .env("PROPTEST_MAX_SHRINK_ITERS", "0")
        .env("PROPTEST_DISABLE_FAILURE_PERSISTENCE", "true")
        .env("RUST_BACKTRACE", "0")
        .env_remove("ELLGRAN_MUTANT")
        .env_remove("ELLGRAN_MUTANTS_SEEN")
        .stdin(Stdio::null());
    command
}

impl Test {
    /// The original, watched where a file is given: seconds of the processor, whether it passes, what it says.
    pub fn original(&self, seen: Option<&Path>) -> Result<(f64, bool, String)> {
        let mut command = command(&[self], LONGEST_WAIT);
        if let Some(seen) = seen {
            command.env("ELLGRAN_MUTANTS_SEEN", seen);
        }
        let (started, before) = (Instant::now(), of_children());
        let output = command.output().context("cannot start a test")?;
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        let by_the_clock = started.elapsed().as_secs_f64();
        // Of the processor: on a machine with other work the clock makes short tests long ones.
        let seconds = match (before, of_children()) {
            (Some(before), Some(after)) => by_the_clock.min(after - before + TICK),
            _ => by_the_clock,
        };
        Ok((seconds, output.status.success(), said))
    }
}

/// In which Linux counts the time of processes, seconds.
const TICK: f64 = 0.01;

/// Seconds of the processor that the processes took which this one has started and waited for; not known beyond Linux.
fn of_children() -> Option<f64> {
    let text = fs::read_to_string("/proc/self/stat").ok()?;
    // The name of the program, in brackets, may hold anything.
    let (_, after_name) = text.rsplit_once(')')?;
    let mut fields = after_name.split_whitespace().skip(13);
    let mut ticks = || fields.next()?.parse::<f64>().ok();
    Some((ticks()? + ticks()?) * TICK)
}

/// Tests of one program with a mutant; the originals take so many seconds. Without a switch the program itself is the mutant.
/// What they say goes to a file; the name of the first that fails is in it.
pub fn mutated(
    tests: &[&Test],
    mutant: Option<Switch>,
    seconds: f64,
    said: &Path,
) -> Result<(Verdict, Option<String>)> {
    let mut command = command(tests, LEAST_LIMIT + TIMES_THE_ORIGINAL * seconds);
    command.stdout(File::create(said)?).stderr(Stdio::null());
    if let Some(Switch { place, choice }) = mutant {
        command.env("ELLGRAN_MUTANT", format!("{place}:{choice}"));
    }
    let child = command.spawn().context("cannot start a test")?;
    let verdict = wait(child)?;
    let text = fs::read(said).unwrap_or_default();
    Ok((verdict, first_failed(&String::from_utf8_lossy(&text))))
}

fn first_failed(said: &str) -> Option<String> {
    let failed = said.lines().find_map(|line| {
        let name = line.strip_prefix("test ")?;
        // One that does not come back has no end of its line.
        let (name, end) = name.split_once(" ... ")?;
        (end != "ok" && end != "ignored").then_some(name)
    });
    failed.map(str::to_string)
}

/// SIGKILL and SIGXCPU: more time than the limit, which the shell sets.
#[cfg(unix)]
fn took_too_long(status: ExitStatus) -> bool {
    use std::os::unix::process::ExitStatusExt;
    matches!(status.signal(), Some(9 | 24))
}

#[cfg(not(unix))]
fn took_too_long(_: ExitStatus) -> bool {
    false
}

fn wait(mut child: Child) -> Result<Verdict> {
    let end = Instant::now() + Duration::from_secs_f64(LONGEST_WAIT);
    let mut pause = Duration::from_micros(500);
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(match status.success() {
                true => Verdict::Passed,
                false if took_too_long(status) => Verdict::NeverEnds,
                false => Verdict::Failed,
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

#[cfg(test)]
mod tests {
    use super::first_failed;

    #[test]
    fn the_test_that_fails_is_named() {
        let said = "running 2 tests\ntest a::b ... ok\ntest a::c ... FAILED\ntest a::d ... ok\n";
        assert_eq!(first_failed(said).as_deref(), Some("a::c"));
        assert_eq!(
            first_failed("test a ... ok\ntest b ... ").as_deref(),
            Some("b")
        );
        assert_eq!(first_failed("test a ... ok\n"), None);
    }
}
