// SPDX-License-Identifier: MIT OR Apache-2.0
//! Python environments of our own, in the cache: one for each list of pinned packages.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::process::run_logged;
use crate::progress::Progress;
use crate::{cache, setup};

/// The interpreter of the environment with the packages of this file, which is made when it is not there.
pub fn environment(title: &str, requirements: &Path) -> Result<PathBuf> {
    setup::python()?;
    let list = fs::read_to_string(requirements)
        .with_context(|| format!("cannot read {}", requirements.display()))?;
    let version = crate::process::output_of(Command::new("python3").arg("--version"))?;
    let name = format!("python-{}", cache::key(&[&list, &version]));
    let directory = cache::directory()?.join(&name);
    let interpreter = directory.join("bin").join("python");
    let _lock = cache::lock(&name)?;
    if cache::stamp(&directory).is_file() {
        return Ok(interpreter);
    }
    if directory.exists() {
        fs::remove_dir_all(&directory)?;
    }
    cache::need_space(&cache::directory()?, 1500)?;
    let progress = Progress::start(title);
    let logs = cache::directory()?;
    let log = |step: &str| logs.join(format!("{name}.{step}.log"));
    let made = run_logged(
        Command::new("python3").args(["-m", "venv"]).arg(&directory),
        &log("venv"),
        |_| (),
    )
    .and_then(|()| {
        run_logged(
            Command::new(&interpreter)
                .args(["-m", "pip", "install", "--disable-pip-version-check"])
                .arg("--requirement")
                .arg(requirements),
            &log("pip"),
            |_| (),
        )
    });
    match made {
        Ok(()) => progress.finish(),
        Err(_) => progress.clear(),
    }
    made?;
    fs::write(cache::stamp(&directory), "")?;
    Ok(interpreter)
}
