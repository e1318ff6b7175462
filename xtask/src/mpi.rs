// SPDX-License-Identifier: MIT OR Apache-2.0
//! How several ranks of an engine are run here.

use crate::process::{find_program, output_of};
use crate::workspace::target_directory;
use anyhow::{Context, Result};
use std::fs;
use std::path::PathBuf;
use std::process::Command;

/// The launcher of parallel runs.
pub fn mpirun() -> Result<PathBuf> {
    find_program("mpirun").context("mpirun is not on PATH")
}

/// Open MPI refuses to run as root, and more ranks than cores, unless told otherwise; others ignore these.
pub fn mpirun_environment() -> [(&'static str, &'static str); 4] {
    [
        ("OMPI_ALLOW_RUN_AS_ROOT", "1"),
        ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"),
        ("OMPI_MCA_rmaps_base_oversubscribe", "1"),
        ("PRTE_MCA_rmaps_default_mapping_policy", ":oversubscribe"),
    ]
}

/// For a command whose ranks may outnumber the cores: that of the launcher, and that a rank gives its core away while it waits for a
/// message (waiting_ranks.c). Not for timings.
pub fn let_ranks_share_cores(command: &mut Command) -> Result<&mut Command> {
    command
        .envs(mpirun_environment())
        .env("OMPI_MCA_mpi_yield_when_idle", "1");
    if cfg!(target_os = "linux") {
        let mut preload = waiting_ranks()?.into_os_string();
        if let Some(others) = std::env::var_os("LD_PRELOAD").filter(|others| !others.is_empty()) {
            preload.push(":");
            preload.push(others);
        }
        command.env("LD_PRELOAD", preload);
    }
    Ok(command)
}

fn waiting_ranks() -> Result<PathBuf> {
    let directory = target_directory()?.join("waiting-ranks");
    fs::create_dir_all(&directory)?;
    let source = directory.join("waiting_ranks.c");
    fs::write(&source, include_str!("waiting_ranks.c"))?;
    // Another command may be making it, or running with it.
    let made = tempfile::NamedTempFile::new_in(&directory)?.into_temp_path();
    output_of(
        Command::new(std::env::var_os("CC").unwrap_or_else(|| "cc".into()))
            .args(["-O2", "-shared", "-fPIC", "-o"])
            .arg(&made)
            .arg(&source)
            .arg("-ldl"),
    )?;
    let library = directory.join("waiting_ranks.so");
    made.persist(&library)?;
    Ok(library)
}
