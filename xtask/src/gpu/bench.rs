// SPDX-License-Identifier: MIT OR Apache-2.0
//! Whole steps on a GPU: the packings of the benchmark of engines, and the program that times them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::bench::lammps_run::Lammps;
use crate::bench::packing::{Kind, Packing};
use crate::process::output_of;
use crate::progress::say;
use crate::workspace::root;

/// A packing, as the scenes of `cargo xtask bench` are, with the numbers of its copies in each direction, and the margin of candidates in
/// parts of the smallest semi-axis: wide where grains are fast, or their ends.
struct Timed {
    name: &'static str,
    kind: Kind,
    lattice: [usize; 3],
    copies: &'static str,
    margin: &'static str,
}

const TIMED: [Timed; 4] = [
    Timed {
        name: "dense",
        kind: Kind::Dense,
        lattice: [16, 16, 16],
        copies: "1,2,3,6,10,13",
        margin: "0.02",
    },
    Timed {
        name: "needles",
        kind: Kind::Needles,
        lattice: [16, 8, 8],
        copies: "2,5",
        margin: "0.2",
    },
    Timed {
        name: "mixture",
        kind: Kind::Mixture,
        lattice: [18, 18, 18],
        copies: "2,5",
        margin: "0.02",
    },
    Timed {
        name: "gas",
        kind: Kind::Gas,
        lattice: [16, 16, 16],
        copies: "2,5,10",
        margin: "0.2",
    },
];

/// The program that times a packing, and its words.
fn words(timed: &Timed, file: &Path) -> [String; 5] {
    let file = file.display().to_string();
    [
        file,
        "--copies".into(),
        timed.copies.into(),
        "--margin".into(),
        timed.margin.into(),
    ]
}

/// Makes the packings, and times them on the GPU of this machine.
pub fn bench() -> Result<()> {
    let directory = root().join("bench-output/gpu");
    packings(&directory)?;
    let mut results = String::new();
    for timed in &TIMED {
        let file = directory.join(timed.name).with_extension("data");
        let output = output_of(
            Command::new("cargo")
                .args(["bench", "-p", "ellgran-gpu", "--bench", "whole_step", "--"])
                .args(words(timed, &file))
                .env("ELLGRAN_TEST_GPU_DRIVER", driver())
                .env("ELLGRAN_GPU_DRIVER", driver())
                .current_dir(root()),
        )?;
        print!("{output}");
        // What it is about, and the names of the columns, once.
        let skipped = if results.is_empty() { 0 } else { 2 };
        for line in output.lines().skip(skipped) {
            results += line;
            results.push('\n');
        }
    }
    let to = directory.join("whole_step.csv");
    fs::write(&to, results).with_context(|| format!("cannot write {}", to.display()))?;
    say(format!(
        "results are in {}; docs/gpu.md shows those in docs/bench/gpu",
        to.display()
    ));
    Ok(())
}

/// NVIDIA's driver.
fn driver() -> std::ffi::OsString {
    std::env::var_os("ELLGRAN_GPU_DRIVER").unwrap_or_else(|| "libcuda.so.1".into())
}

/// Puts into a directory what a machine with a GPU and without a compiler needs: the packings, the program that times them, and the
/// tests that compare each step with the host.
pub fn pack(directory: &Path) -> Result<()> {
    packings(directory)?;
    for (kind, name) in [("--bench", "whole_step"), ("--test", "steps")] {
        let mut cargo = Command::new("cargo");
        cargo
            .args(["build", "--release", "-p", "ellgran-gpu", kind, name])
            .args(["--message-format", "json-render-diagnostics"])
            .current_dir(root());
        let messages = output_of(&mut cargo)?;
        let program = executable(&messages, name)
            .with_context(|| format!("cargo has built no program of {name}"))?;
        let to = directory.join(name);
        fs::copy(&program, &to).with_context(|| format!("cannot write {}", to.display()))?;
    }
    let mut script = String::from(
        "#!/bin/sh\n# What `cargo xtask gpu --bench` times, and the tests, on a machine with a GPU and without a compiler.\n\
         export ELLGRAN_TEST_GPU_DRIVER=libcuda.so.1 ELLGRAN_GPU_DRIVER=libcuda.so.1\n\
         cd \"$(dirname \"$0\")\" || exit\n./steps --test-threads=1 || exit\n",
    );
    for timed in &TIMED {
        let file = PathBuf::from(timed.name).with_extension("data");
        script += &format!("./whole_step {}\n", words(timed, &file).join(" "));
    }
    let to = directory.join("run.sh");
    fs::write(&to, script).with_context(|| format!("cannot write {}", to.display()))?;
    say(format!(
        "on a machine with a GPU: `sh {}/run.sh`",
        directory.display()
    ));
    Ok(())
}

/// The program of a target in the messages of cargo.
fn executable(messages: &str, target: &str) -> Option<PathBuf> {
    messages.lines().find_map(|line| {
        let message: serde_json::Value = serde_json::from_str(line).ok()?;
        let is_it = message["target"]["name"] == target;
        is_it.then(|| message["executable"].as_str().map(PathBuf::from))?
    })
}

fn packings(directory: &Path) -> Result<()> {
    fs::create_dir_all(directory)
        .with_context(|| format!("cannot make {}", directory.display()))?;
    let lammps = Lammps::prepare()?;
    for timed in &TIMED {
        let packing = Packing {
            kind: timed.kind,
            lattice: timed.lattice,
            spheres: false,
        };
        let to = directory.join(timed.name).with_extension("data");
        let made = packing.file(&lammps)?;
        fs::copy(&made, &to).with_context(|| format!("cannot write {}", to.display()))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_is_found_by_its_target() {
        let messages = "{\"reason\":\"compiler-artifact\",\"target\":{\"name\":\"other\"},\"executable\":\"/a\"}\n\
                        {\"reason\":\"compiler-artifact\",\"target\":{\"name\":\"steps\"},\"executable\":\"/b/steps-1\"}\n\
                        {\"reason\":\"build-finished\",\"success\":true}\n";
        assert_eq!(
            executable(messages, "steps"),
            Some(PathBuf::from("/b/steps-1"))
        );
        assert_eq!(executable(messages, "none"), None);
    }
}
