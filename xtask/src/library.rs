// SPDX-License-Identifier: MIT OR Apache-2.0
//! The Rust core as the static library that engines link.

use std::path::PathBuf;

use anyhow::{bail, Result};

use crate::{process, workspace};

pub fn library() -> Result<PathBuf> {
    process::run_visible(workspace::cargo().args([
        "build",
        "--release",
        "--package",
        "ellgran",
        "--lib",
    ]))?;
    let library = workspace::target_directory()?
        .join("release")
        .join("libellgran.a");
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
        let list = process::output_of(workspace::cargo().args([
            "tree",
            "--offline",
            "--package=ellgran",
            "--edges=normal",
            "--prefix=none",
            "--format={p} = {l}",
        ]))
        .unwrap();
        assert!(list.lines().count() > 3, "{list}");
        for line in list.lines() {
            let (name, licence) = line.split_once(" = ").expect(line);
            let mut choices = licence.trim_end_matches(" (*)").split(['/', ' ']);
            assert!(
                choices.any(|choice| choice == "MIT") && !licence.contains("AND"),
                "{name}: {licence}"
            );
        }
    }
}
