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
