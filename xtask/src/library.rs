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
