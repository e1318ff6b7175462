// SPDX-License-Identifier: MIT OR Apache-2.0
//! The LAMMPS plugin, built against one LAMMPS.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{bail, Context, Result};

use crate::lammps::Source;
use crate::library::library;
use crate::process::{ninja, run_logged};
use crate::{cache, setup, workspace};

/// Needs the engine's headers only, not its binary.
pub fn plugin(lammps: &Source) -> Result<PathBuf> {
    setup::setup()?;
    let library = library()?;
    let root = workspace::root();
    let build = workspace::target_directory()?
        .join("lammps-plugin")
        .join(&lammps.name);
    std::fs::create_dir_all(&build)?;
    let _lock = cache::lock(&format!("lammps-plugin-{}", lammps.name))?;
    let mut configure = Command::new("cmake");
    configure
        .arg("-S")
        .arg(root.join("lammps-plugin"))
        .arg("-B")
        .arg(&build)
        .args(["-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release"])
        .arg(define("LAMMPS_SOURCE_DIR", lammps.src()))
        .arg(define("ELLGRAN_LIBRARY", library))
        .arg(define("ELLGRAN_INCLUDE_DIR", root.join("include")));
    run_logged(&mut configure, &build.join("configure.log"), |_| {})
        .context("the plugin cannot be configured")?;
    ninja(
        &build,
        &[],
        &format!("Building the plugin for LAMMPS {}", lammps.spelled()?),
    )
    .context("the plugin cannot be built")?;
    let plugin = build.join("ellgranplugin.so");
    if !plugin.is_file() {
        bail!("the build left no {}", plugin.display());
    }
    Ok(plugin)
}

fn define(name: &str, path: PathBuf) -> String {
    format!("-D{name}={}", path.display())
}
