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

/// What is timed: as the scenes of `cargo xtask bench` are.
const PACKINGS: [(&str, Kind, [usize; 3]); 4] = [
    ("dense", Kind::Dense, [16, 16, 16]),
    ("needles", Kind::Needles, [16, 8, 8]),
    ("mixture", Kind::Mixture, [18, 18, 18]),
    ("gas", Kind::Gas, [16, 16, 16]),
];

/// Makes the packings, and times them on the GPU of this machine.
pub fn bench() -> Result<()> {
    let directory = root().join("bench-output/gpu");
    let files = packings(&directory)?;
    let results = output_of(
        Command::new("cargo")
            .args(["bench", "-p", "ellgran-gpu", "--bench", "whole_step", "--"])
            .args(&files)
            .current_dir(root()),
    )?;
    print!("{results}");
    let to = directory.join("whole_step.csv");
    fs::write(&to, results).with_context(|| format!("cannot write {}", to.display()))?;
    say(format!(
        "results are in {}; docs/gpu.md shows those in docs/bench/gpu",
        to.display()
    ));
    Ok(())
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
    say(format!(
        "on a machine with a GPU, in {}: `ELLGRAN_TEST_GPU_DRIVER=libcuda.so.1 ./steps`, and \
         `ELLGRAN_TEST_GPU_DRIVER=libcuda.so.1 ./whole_step *.data`",
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

fn packings(directory: &Path) -> Result<Vec<PathBuf>> {
    fs::create_dir_all(directory)
        .with_context(|| format!("cannot make {}", directory.display()))?;
    let lammps = Lammps::prepare()?;
    let mut files = Vec::new();
    for (name, kind, lattice) in PACKINGS {
        let packing = Packing {
            kind,
            lattice,
            spheres: false,
        };
        let to = directory.join(name).with_extension("data");
        let made = packing.file(&lammps)?;
        fs::copy(&made, &to).with_context(|| format!("cannot write {}", to.display()))?;
        files.push(to);
    }
    Ok(files)
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
