// SPDX-License-Identifier: MIT OR Apache-2.0
//! Errors of memory in LAMMPS with the plugin, found by valgrind: a short run through insertion, pairs, walls, a mesh, output and a
//! restart. Not part of `cargo xtask test`.

use std::path::PathBuf;
use std::process::Command;

use anyhow::Result;

use crate::process::run_open;
use crate::workspace::root;
use crate::{lammps, plugin, setup};

/// Fails with any error, and with any block of memory to which no pointer is left. Nothing is suppressed.
pub fn sanitize() -> Result<()> {
    setup::setup()?;
    setup::valgrind()?;
    let source = lammps::source()?;
    let (program, plugin) = (source.binary()?, plugin::plugin(&source)?);
    let directory = tempfile::tempdir()?;
    let variable = |name: &str, value: PathBuf| {
        ["-var".into(), name.into(), value.display().to_string()] as [String; 3]
    };
    run_open(
        Command::new("valgrind")
            .args(["--error-exitcode=9", "--keep-debuginfo=yes"])
            .args(["--leak-check=full", "--errors-for-leak-kinds=definite"])
            .args(["--show-leak-kinds=definite", "--num-callers=30"])
            .arg(program)
            .args(["-nocite", "-log", "none", "-in"])
            .arg(root().join("tests/sanitize/pairs_walls_mesh_insertion.lmp"))
            .args(variable("plugin", plugin))
            .args(variable("stl", root().join("examples/lammps/paddle.stl")))
            .env("OMP_NUM_THREADS", "1")
            .current_dir(directory.path()),
    )
}
