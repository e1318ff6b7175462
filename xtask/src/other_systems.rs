// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does everything written in Rust compile for Windows and macOS? Nothing is linked or run, so neither system is needed.

use anyhow::Result;

use crate::process::run_open;
use crate::rust_target;
use crate::workspace::cargo;

const TARGETS: [&str; 2] = ["x86_64-pc-windows-gnu", "aarch64-apple-darwin"];

/// Installs the standard libraries that are missing, and checks.
pub fn other_systems() -> Result<()> {
    for target in TARGETS {
        rust_target::install(target)?;
        lints(target)?;
    }
    Ok(())
}

/// Checks what this machine's Rust can compile for, and gives the targets that it cannot: a test does not change which there are.
pub fn those_installed() -> Result<Vec<&'static str>> {
    let mut lacking = Vec::new();
    for target in TARGETS {
        if rust_target::is_installed(target)? {
            lints(target)?;
        } else {
            lacking.push(target);
        }
    }
    Ok(lacking)
}

/// Without tests and benchmarks, some of whose crates compile C.
fn lints(target: &str) -> Result<()> {
    let mut clippy = cargo();
    clippy.args(["clippy", "--workspace", "--target", target]);
    run_open(clippy.args(["--", "-Dwarnings"]))
}
