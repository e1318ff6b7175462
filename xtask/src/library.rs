// SPDX-License-Identifier: MIT OR Apache-2.0
//! The Rust core as the static library that engines link.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{bail, Result};

use crate::{aarch64, process, workspace};

pub fn library() -> Result<PathBuf> {
    let mut cargo = workspace::cargo();
    cargo.args(["build", "--package", "ellgran"]);
    built(cargo, &workspace::target_directory()?, "libellgran.a")
}

/// The one that starts kernels on a GPU.
pub fn for_gpus() -> Result<PathBuf> {
    let mut cargo = workspace::cargo();
    cargo.args(["build", "--package", "ellgran-gpu"]);
    built(cargo, &workspace::target_directory()?, "libellgran_gpu.a")
}

/// The same for AArch64, on another machine.
pub fn of_aarch64() -> Result<PathBuf> {
    let directory = workspace::target_directory()?.join(aarch64::TARGET);
    built(aarch64::cross_cargo("build")?, &directory, "libellgran.a")
}

fn built(mut cargo: Command, directory: &Path, name: &str) -> Result<PathBuf> {
    process::run_visible(cargo.args(["--release", "--lib"]))?;
    let library = directory.join("release").join(name);
    if !library.is_file() {
        bail!("cargo built no {}", library.display());
    }
    Ok(library)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// A crate under Apache-2.0 alone could not be distributed in one binary with LAMMPS, which is GPL-2.0-only.
    #[test]
    fn every_crate_in_the_library_may_be_taken_under_mit() {
        every_crate_may_be_taken_under("ellgran", &["MIT"]);
    }

    /// The ISC licence asks for the same as MIT's, in other words.
    #[test]
    fn every_crate_in_the_library_for_gpus_may_be_taken_under_mit_or_isc() {
        every_crate_may_be_taken_under("ellgran-gpu", &["MIT", "ISC"]);
    }

    /// Else the benches and the report compile a library of their own, which takes minutes.
    #[test]
    fn engines_and_benches_share_one_library() {
        let crates = |edges: &str| {
            let list = process::output_of(
                workspace::cargo()
                    .args(["tree", "--offline", "--package=ellgran", "--prefix=none"])
                    .args(["--format={p} [{f}]", &format!("--edges={edges}")]),
            );
            let lines = list.unwrap();
            let lines = lines.lines().map(|line| line.trim_end_matches(" (*)"));
            lines.map(String::from).collect::<BTreeSet<_>>()
        };
        let (of_engines, of_benches) = (crates("normal"), crates("normal,dev"));
        assert!(of_engines.len() > 5);
        let others: Vec<_> = of_engines.difference(&of_benches).collect();
        assert!(others.is_empty(), "with other features: {others:?}");
    }

    fn every_crate_may_be_taken_under(package: &str, licences: &[&str]) {
        let list = process::output_of(
            workspace::cargo()
                .args(["tree", "--offline", "--package", package])
                .args(["--edges=normal", "--prefix=none", "--format={p} = {l}"]),
        )
        .unwrap();
        assert!(list.lines().count() > 3, "{list}");
        for line in list.lines() {
            let (name, licence) = line.split_once(" = ").expect(line);
            let mut choices = licence.trim_end_matches(" (*)").split(['/', ' ']);
            assert!(
                choices.any(|choice| licences.contains(&choice)) && !licence.contains("AND"),
                "{name}: {licence}"
            );
        }
    }
}
