// SPDX-License-Identifier: MIT OR Apache-2.0
//! The release library, its header, and its pkg-config and CMake files, put where C and C++ projects look for them.

pub mod prefix;

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{bail, Context, Result};

use self::prefix::Place;
use crate::progress::say;
use crate::workspace::{cargo, root, target_directory};
use crate::{aarch64, library, process};

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
    /// The library libellgran_gpu.a and its header too, which start kernels on a GPU (docs/gpu.md)
    #[arg(long)]
    gpu: bool,
}

/// What a prefix may have beside the static library.
#[derive(Default)]
struct Beside {
    /// The compiler that links the shared library.
    shared_by: Option<Command>,
    /// The library for GPUs.
    gpu: Option<PathBuf>,
}

impl Beside {
    fn shared(compiler: Command) -> Self {
        Beside {
            shared_by: Some(compiler),
            gpu: None,
        }
    }
}

pub fn install(options: &Options) -> Result<()> {
    let prefix = std::path::absolute(&options.prefix)?;
    let place = Place::new(&prefix, &options.libdir)?;
    let library = library::library()?;
    let beside = Beside {
        shared_by: options.shared.then(c_compiler),
        gpu: options.gpu.then(library::for_gpus).transpose()?,
    };
    fill(None, &place, &library, beside)?;
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
    let library = library::library()?;
    fill(None, &Place::in_lib(prefix), &library, Beside::default())
}

/// With the shared library.
pub fn with_shared(prefix: &Path) -> Result<()> {
    let library = library::library()?;
    let beside = Beside::shared(c_compiler());
    fill(None, &Place::in_lib(prefix), &library, beside)
}

/// The same for AArch64, on another machine; `library` is the static one.
pub fn of_aarch64_with_shared(prefix: &Path, library: &Path) -> Result<()> {
    let beside = Beside::shared(Command::new(aarch64::C_COMPILER));
    let place = Place::in_lib(prefix);
    fill(Some(aarch64::TARGET), &place, library, beside)
}

fn c_compiler() -> Command {
    Command::new(std::env::var_os("CC").unwrap_or_else(|| "cc".into()))
}

/// `target` is another machine's, where it is for one.
fn fill(target: Option<&str>, place: &Place, library: &Path, beside: Beside) -> Result<()> {
    if beside.shared_by.is_some() && !cfg!(target_os = "linux") {
        bail!(
            "--shared is made for the linkers of Linux: leave it out, and link the static library"
        );
    }
    let scratch = target_directory()?.join("system-libraries");
    let system_libraries = prefix::system_libraries_of_an_empty_library(&root(), &scratch, target)?;
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
    prefix::fill(place, &root(), library, &package)?;
    if let Some(library) = beside.gpu {
        prefix::add_gpu(place, &root(), &library, &package)?;
    }
    if let Some(compiler) = beside.shared_by {
        prefix::add_shared(place, &root(), &package, compiler)?;
    }
    Ok(())
}
