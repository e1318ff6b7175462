// SPDX-License-Identifier: MIT OR Apache-2.0
//! A directory to be carried to a machine that has a GPU and no compiler: programs, packings, decks and scripts.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use super::bench::{packings, words, TIMED};
use crate::bench::lammps_run::Lammps;
use crate::bench::packing::{Kind, Packing};
use crate::process::output_of;
use crate::progress::say;
use crate::workspace::root;
use crate::{lammps, lammps_kokkos_cuda};

/// The scenes of LAMMPS.
const DECKS: &str = "tests/lammps_on_gpu";
/// What they read of examples/lammps.
const SURFACES: [&str; 2] = ["lifters.stl", "paddle.stl"];

/// Puts into a directory what a machine with a GPU and without a compiler needs: the packings, the program that times them, and the
/// tests that compare each step with the host.
pub fn pack(directory: &Path, with_lammps: bool) -> Result<()> {
    let of_host = packings(directory)?;
    if with_lammps {
        lammps_scenes(directory, &of_host)?;
    }
    for (kind, name) in [("--bench", "whole_step"), ("--test", "steps")] {
        let mut cargo = Command::new("cargo");
        cargo
            .args(["build", "--release", "-p", "ellgran-gpu", kind, name])
            .args(["--message-format", "json-render-diagnostics"])
            .current_dir(root());
        let messages = output_of(&mut cargo)?;
        let program = executable(&messages, name)
            .with_context(|| format!("cargo has built no program of {name}"))?;
        copy(&program, &directory.join(name))?;
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

/// LAMMPS for a GPU, and what its scenes read.
fn lammps_scenes(directory: &Path, of_host: &Lammps) -> Result<()> {
    let to = directory.join("lammps");
    fs::create_dir_all(&to).with_context(|| format!("cannot make {}", to.display()))?;
    let decks = root().join(DECKS);
    for file in fs::read_dir(&decks)? {
        let path = file?.path();
        if let Some(name) = path.file_name().filter(|_| path.is_file()) {
            copy(&path, &to.join(name))?;
        }
    }
    for name in SURFACES {
        copy(&root().join("examples/lammps").join(name), &to.join(name))?;
    }
    for timed in &TIMED {
        let name = Path::new(timed.name).with_extension("data");
        copy(&directory.join(&name), &to.join(&name))?;
    }
    let packing = Packing {
        kind: Kind::Dense,
        lattice: [16, 16, 16],
        spheres: true,
    };
    output_of(
        Command::new(&of_host.binary)
            .args(["-log", "none", "-screen", "none", "-in", "make_spheres.lmp"])
            .args(["-var", "packing"])
            .arg(packing.file(of_host)?)
            .current_dir(&to),
    )
    .context("LAMMPS cannot make the packing of spheres")?;
    let binary = to.join("lmp");
    copy(&lammps_kokkos_cuda::binary(&lammps::source()?)?, &binary)?;
    output_of(Command::new("strip").arg(&binary))?;
    say(format!(
        "LAMMPS on a GPU, where there is the MPI that it was built with: `bash {}/run.sh`",
        to.display()
    ));
    Ok(())
}

fn copy(from: &Path, to: &Path) -> Result<()> {
    fs::copy(from, to)
        .with_context(|| format!("cannot copy {} to {}", from.display(), to.display()))?;
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
