// SPDX-License-Identifier: MIT OR Apache-2.0
//! NVIDIA's compiler for GPUs, as `nvcc` and CMake expect it: from the package index, without root and without a GPU.

use std::fs;
#[cfg(unix)]
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{bail, Context, Result};

use crate::process::output_of;
use crate::python_environment::Environment;
use crate::workspace::root;

/// What Kokkos calls of NVIDIA's driver, which a machine without a GPU has not: to link with.
const OF_THE_DRIVER: [&str; 3] = ["cuStreamGetCtx", "cuCtxPushCurrent_v2", "cuCtxGetDevice"];

/// CUDA_ERROR_STUB_LIBRARY
const NO_DRIVER: u32 = 34;

/// The directory with `bin/nvcc`.
pub fn toolkit() -> Result<PathBuf> {
    let environment = Environment::pinned(&root().join("xtask/src/cuda_requirements.txt"))?;
    let place = output_of(environment.python().args([
        "-c",
        "import sysconfig; print(sysconfig.get_paths()['purelib'])",
    ]))?;
    let home = Path::new(place.trim()).join("nvidia/cu13");
    if !home.join("bin/nvcc").is_file() {
        bail!("the packages have no {}", home.join("bin/nvcc").display());
    }
    complete(&home)?;
    Ok(home)
}

#[cfg(not(unix))]
fn symlink(_: &str, _: &Path) -> std::io::Result<()> {
    Err(std::io::Error::other(
        "NVIDIA's compiler is set up on Linux alone",
    ))
}

/// The names by which a linker looks for what the packages have.
fn complete(home: &Path) -> Result<()> {
    for (target, name) in [("lib", "lib64"), ("libcudart.so.13", "lib/libcudart.so")] {
        let link = home.join(name);
        if fs::symlink_metadata(&link).is_err() {
            symlink(target, &link).with_context(|| format!("cannot make {}", link.display()))?;
        }
    }
    let stubs = home.join("lib/stubs");
    let library = stubs.join("libcuda.so");
    if library.is_file() {
        return Ok(());
    }
    fs::create_dir_all(&stubs)?;
    let source = stubs.join("libcuda.c");
    let functions: String = OF_THE_DRIVER
        .iter()
        .map(|name| format!("int {name}(void) {{ return {NO_DRIVER}; }}\n"))
        .collect();
    fs::write(&source, functions)?;
    output_of(
        Command::new("cc")
            .args(["-shared", "-fPIC", "-Wl,-soname,libcuda.so.1", "-o"])
            .arg(&library)
            .arg(&source),
    )?;
    Ok(())
}
