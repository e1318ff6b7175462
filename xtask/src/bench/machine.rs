// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the numbers were taken on, and whether it was busy.

use std::process::Command;

use crate::process::{jobs, output_of};

/// One line a fact; what the machine does not tell is left out.
pub fn describe() -> Vec<String> {
    let mut lines = vec![format!("cores: {}", jobs())];
    if let Some(model) = field("/proc/cpuinfo", "model name") {
        lines.insert(0, format!("processor: {model}"));
    }
    if let Some(load) = load() {
        lines.push(format!("load (mean over one minute): {load}"));
    }
    if let Ok(date) = output_of(Command::new("date").args(["-u", "+%Y-%m-%d %H:%M UTC"])) {
        lines.push(format!("date: {}", date.trim()));
    }
    if let Ok(rustc) = output_of(Command::new("rustc").arg("--version")) {
        lines.push(rustc.trim().to_string());
    }
    lines
}

pub fn load() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/loadavg").ok()?;
    text.split_whitespace().next()?.parse().ok()
}

fn field(path: &str, name: &str) -> Option<String> {
    let text = std::fs::read_to_string(path).ok()?;
    let line = text.lines().find(|line| line.starts_with(name))?;
    Some(line.split_once(':')?.1.trim().to_string())
}
