// SPDX-License-Identifier: MIT OR Apache-2.0
//! A Python of AArch64 that runs in an emulator: Debian's packages, unpacked in the cache. Nothing is installed, and the machine's
//! own apt learns of no other architecture.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::apt_source::Packages;
use crate::process::output_of;
use crate::progress::say;
use crate::{cache, setup};

/// Python, what its modules need, and the wheel of pip.
const PACKAGES: [&str; 3] = ["python3-minimal", "libpython3-stdlib", "python3-pip-whl"];

/// Libraries that packages of the index take for granted.
const LIBRARIES: [&str; 2] = ["libstdc++6", "libgcc-s1"];

/// Python, and the directory that is the emulator's root for libraries.
pub struct Interpreter {
    root: PathBuf,
}

impl Interpreter {
    /// Fetched once; an error says why there is none here.
    pub fn had() -> Result<Self> {
        setup::aarch64()?;
        let _lock = cache::lock("python-aarch64")?;
        let home = cache::directory()?;
        let root = home.join("debian-aarch64");
        if !cache::stamp(&root).is_file() {
            cache::need_space(&home, 300)?;
            let scratch = tempfile::Builder::new()
                .prefix("aarch64-")
                .tempdir_in(&home)?;
            say("Fetching a Python for AArch64 from Debian");
            let wanted: Vec<&str> = PACKAGES.into_iter().chain(LIBRARIES).collect();
            Packages::of_architecture("arm64")
                .and_then(|packages| packages.unpack_with_dependencies(&wanted, scratch.path()))
                .context("a Python for AArch64 cannot be had")?;
            let _ = fs::remove_dir_all(&root);
            fs::rename(scratch.path(), &root)?;
            fs::write(cache::stamp(&root), "")?;
        }
        Ok(Interpreter { root })
    }

    /// The emulator's root for libraries.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// A program of AArch64, run in the emulator.
    pub fn command(&self, program: &Path) -> Command {
        let mut command = Command::new("qemu-aarch64");
        command.arg(program).env("QEMU_LD_PREFIX", &self.root);
        command
    }

    /// A virtual environment with pip. `python -m venv` alone would start its own Python, which this machine cannot.
    pub fn make_environment(&self, directory: &Path) -> Result<()> {
        output_of(
            self.command(&self.root.join("usr/bin/python3"))
                .args(["-m", "venv", "--without-pip"])
                .arg(directory),
        )?;
        let wheels = self.root.join("usr/share/python-wheels");
        let pip = fs::read_dir(&wheels)
            .with_context(|| format!("{}", wheels.display()))?
            .filter_map(|entry| Some(entry.ok()?.path()))
            .find(|path| {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                name.starts_with("pip-") && name.ends_with(".whl")
            })
            .with_context(|| format!("{} has no pip", wheels.display()))?;
        output_of(
            self.command(&directory.join("bin/python"))
                .arg(pip.join("pip"))
                .args(["install", "--no-index", "--disable-pip-version-check"])
                .arg(&pip),
        )?;
        Ok(())
    }
}
