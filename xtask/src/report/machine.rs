// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the numbers were taken on: no name of the machine, no path.

use std::process::Command;

use crate::bench::machine;
use crate::process::output_of;

/// One line a fact; `before` is the load when the measurements began.
pub fn describe(before: Option<f64>) -> Vec<String> {
    let mut lines: Vec<String> = machine::describe()
        .into_iter()
        .filter(|line| !line.starts_with("load"))
        .collect();
    if let (Some(before), Some(after)) = (before, machine::load()) {
        lines.push(format!(
            "load (mean over one minute): {before} before the measurements, {after} after them"
        ));
    }
    for compiler in ["cc", "c++"] {
        if let Ok(text) = output_of(Command::new(compiler).arg("--version")) {
            if let Some(first) = text.lines().next() {
                lines.push(format!("{compiler}: {first}"));
            }
        }
    }
    lines
}
