// SPDX-License-Identifier: MIT OR Apache-2.0
//! How other programs are run: their output to a log file, the end of that log shown when they fail.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{bail, Context, Result};

use crate::progress::{ninja_progress, Progress};

const TAIL_LINES: usize = 40;

/// Runs with standard output and error joined, every line into `log` and to `on_line`.
pub fn run_logged(command: &mut Command, log: &Path, mut on_line: impl FnMut(&str)) -> Result<()> {
    let (reader, writer) = std::io::pipe()?;
    command
        .stdin(Stdio::null())
        .stdout(writer.try_clone()?)
        .stderr(writer);
    let described = describe(command);
    let mut child = command
        .spawn()
        .with_context(|| format!("cannot start: {described}"))?;
    // The command still holds the writing ends: without this the reader would never see the end.
    command.stdout(Stdio::null()).stderr(Stdio::null());
    if let Some(parent) = log.parent() {
        std::fs::create_dir_all(parent)?;
    }
    let mut file = File::create(log).with_context(|| format!("cannot write {}", log.display()))?;
    writeln!(file, "$ {described}")?;
    let mut tail = VecDeque::with_capacity(TAIL_LINES);
    let mut reader = BufReader::new(reader);
    let mut bytes = Vec::new();
    loop {
        bytes.clear();
        if reader.read_until(b'\n', &mut bytes)? == 0 {
            break;
        }
        file.write_all(&bytes)?;
        let line = String::from_utf8_lossy(&bytes).trim_end().to_string();
        on_line(&line);
        if tail.len() == TAIL_LINES {
            tail.pop_front();
        }
        tail.push_back(line);
    }
    let status = child.wait()?;
    if !status.success() {
        for line in &tail {
            eprintln!("  | {line}");
        }
        bail!(
            "{status}: {described}\nthe whole output is in {}",
            log.display()
        );
    }
    Ok(())
}

/// Builds a configured tree with ninja, its `[n/m]` shown as progress.
pub fn ninja(build: &Path, targets: &[&str], title: &str) -> Result<()> {
    ninja_by(Command::new("ninja"), build, targets, title)
}

/// The same with a ninja that has an environment of its own.
pub fn ninja_by(mut command: Command, build: &Path, targets: &[&str], title: &str) -> Result<()> {
    let mut progress = Progress::start(title);
    command
        .arg("-C")
        .arg(build)
        .arg(format!("-j{}", jobs()))
        .args(targets)
        .env_remove("NINJA_STATUS");
    let result = run_logged(&mut command, &build.join("build.log"), |line| {
        if let Some((done, total)) = ninja_progress(line) {
            progress.update(
                Some(done as f64 / total.max(1) as f64),
                &format!("{done} of {total} files"),
            );
        }
    });
    match result {
        Ok(()) => progress.finish(),
        Err(_) => progress.clear(),
    }
    result
}

/// Runs with the terminal's own input closed and its output on standard error, where progress belongs.
pub fn run_visible(command: &mut Command) -> Result<()> {
    run_open(command.stdout(std::io::stderr()))
}

/// Runs with its output as our own, for programs whose output is the result.
pub fn run_open(command: &mut Command) -> Result<()> {
    let described = describe(command);
    let status = command
        .stdin(Stdio::null())
        .status()
        .with_context(|| format!("cannot start: {described}"))?;
    if !status.success() {
        bail!("{status}: {described}");
    }
    Ok(())
}

/// Standard output of a program that must succeed.
pub fn output_of(command: &mut Command) -> Result<String> {
    let described = describe(command);
    let output = command
        .stdin(Stdio::null())
        .output()
        .with_context(|| format!("cannot start: {described}"))?;
    if !output.status.success() {
        // Engines say what is wrong on standard output.
        let said = String::from_utf8_lossy(&output.stdout);
        let last: Vec<&str> = said.lines().rev().take(TAIL_LINES).collect();
        bail!(
            "{}: {described}\n{}{}",
            output.status,
            last.into_iter()
                .rev()
                .filter(|line| line.starts_with("ERROR"))
                .map(|line| format!("{line}\n"))
                .collect::<String>(),
            String::from_utf8_lossy(&output.stderr).trim_end()
        );
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// The program of that name on `PATH`.
pub fn find_program(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path)
        .map(|directory| directory.join(name))
        .find(|candidate| candidate.is_file())
}

pub fn jobs() -> usize {
    std::thread::available_parallelism().map_or(2, usize::from)
}

fn describe(command: &Command) -> String {
    std::iter::once(command.get_program())
        .chain(command.get_args())
        .map(|word| word.to_string_lossy().into_owned())
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_streams_reach_the_log_and_the_failure_is_told() {
        let directory = tempfile::tempdir().unwrap();
        let log = directory.path().join("log");
        let mut lines = Vec::new();
        let mut command = Command::new("sh");
        command.args(["-c", "echo out; echo err >&2; exit 3"]);
        let error = run_logged(&mut command, &log, |line| lines.push(line.to_string()))
            .unwrap_err()
            .to_string();
        assert_eq!(lines, ["out", "err"]);
        assert!(error.contains("exit status: 3"), "{error}");
        assert!(std::fs::read_to_string(&log)
            .unwrap()
            .contains("out\nerr\n"));
    }
}
