// SPDX-License-Identifier: MIT OR Apache-2.0
//! How a program of the machine that the tests are built for is run on the one that they are built on.

use std::env;
use std::path::Path;
use std::process::Command;

/// The program, behind the runner that cargo was told of for the target (`cargo xtask aarch64` names an emulator).
pub fn program(path: &Path) -> Command {
    let runner = env::var("CARGO_BUILD_TARGET")
        .map(|target| target.to_uppercase().replace('-', "_"))
        .and_then(|target| env::var(format!("CARGO_TARGET_{target}_RUNNER")))
        .unwrap_or_default();
    let mut words = runner.split_whitespace();
    match words.next() {
        None => Command::new(path),
        Some(emulator) => {
            let mut command = Command::new(emulator);
            command.args(words).arg(path);
            command
        }
    }
}
