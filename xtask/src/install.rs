// SPDX-License-Identifier: MIT OR Apache-2.0
//! The release library, its header, and its pkg-config and CMake files, put where C and C++ projects look for them.

mod prefix;

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{bail, Context, Result};

use self::prefix::Place;
use crate::progress::say;
use crate::workspace::{cargo, root, target_directory};
use crate::{library, process};

#[derive(clap::Args)]
pub struct Options {
    /// Where lib/ and include/ are to be, as /usr/local
    #[arg(long)]
    prefix: PathBuf,
    /// The directory of libraries below the prefix, as lib64 or lib/x86_64-linux-gnu
    #[arg(long, default_value = "lib")]
    libdir: PathBuf,
    /// The shared library libellgran.so too (Linux), linked by $CC or cc
    #[arg(long)]
    shared: bool,
}

pub fn install(options: &Options) -> Result<()> {
    let prefix = std::path::absolute(&options.prefix)?;
    fill(&Place::new(&prefix, &options.libdir)?, options.shared)?;
    let libraries = prefix.join(&options.libdir);
    say(format!(
        "installed into {}\n  pkg-config: PKG_CONFIG_PATH={}\n  CMake:      -Dellgran_DIR={}",
        prefix.display(),
        libraries.join("pkgconfig").display(),
        libraries.join("cmake").join("ellgran").display()
    ));
    Ok(())
}

/// Without the shared library.
pub fn into(prefix: &Path) -> Result<()> {
    fill(&Place::in_lib(prefix), false)
}

/// With the shared library.
pub fn with_shared(prefix: &Path) -> Result<()> {
    fill(&Place::in_lib(prefix), true)
}

fn fill(place: &Place, shared: bool) -> Result<()> {
    if shared && !cfg!(target_os = "linux") {
        bail!(
            "--shared is made for the linkers of Linux: leave it out, and link the static library"
        );
    }
    let system_libraries =
        prefix::system_libraries(&root(), &target_directory()?.join(prefix::TEST_PROFILE))?;
    let metadata: serde_json::Value = serde_json::from_str(&process::output_of(cargo().args([
        "metadata",
        "--format-version=1",
        "--no-deps",
        "--offline",
    ]))?)?;
    let package = metadata["packages"]
        .as_array()
        .and_then(|packages| packages.iter().find(|p| p["name"] == "ellgran"))
        .context("cargo metadata names no package ellgran")?;
    let text = |key: &str| {
        package[key]
            .as_str()
            .with_context(|| format!("Cargo.toml has no {key}"))
    };
    let package = prefix::Package {
        version: text("version")?,
        description: text("description")?,
        system_libraries: &system_libraries,
    };
    prefix::fill(place, &root(), &library::library()?, &package)?;
    if shared {
        let compiler = std::env::var_os("CC").unwrap_or_else(|| "cc".into());
        prefix::add_shared(place, &root(), &package, Command::new(compiler))?;
    }
    Ok(())
}
