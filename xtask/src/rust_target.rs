// SPDX-License-Identifier: MIT OR Apache-2.0
//! Other systems that this machine's Rust compiles for.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{bail, Context, Result};

use crate::process::{find_program, output_of, run_visible};
use crate::workspace::root;

/// Whether rustc can compile for a target: has its standard library.
pub fn is_installed(target: &str) -> Result<bool> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let printed = output_of(
        Command::new(rustc)
            .args(["--print", "target-libdir", "--target", target])
            .current_dir(root()),
    )?;
    Ok(PathBuf::from(printed.trim_end()).is_dir())
}

/// Installs that when it is missing.
pub fn install(target: &str) -> Result<()> {
    if is_installed(target)? {
        return Ok(());
    }
    if find_program("rustup").is_none() {
        bail!("rustc has no standard library for {target}, and there is no rustup here: install this system's own package of it");
    }
    run_visible(
        Command::new("rustup")
            .args(["target", "add", target])
            .current_dir(root()),
    )
    .with_context(|| {
        format!("rustc has no standard library for {target}. Run\n  rustup target add {target}\nwhere the network allows it")
    })
}
