// SPDX-License-Identifier: MIT OR Apache-2.0
//! The kernel benchmark: run through cargo, its times read from what criterion leaves, divided by pairs.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

use super::contender::Contender;
use super::statistics::{short, Measured};
use super::Effort;
use crate::demo::table::Table;
use crate::process::{find_program, run_logged};
use crate::progress::Progress;
use crate::workspace;

/// One benchmark: what it counted, and nanoseconds a run of it.
pub struct Row {
    /// `group/instruction set`, or a name alone.
    name: String,
    history_bytes: f64,
    particles: f64,
    pairs: f64,
    touching: f64,
    particle_bytes: f64,
    time: Measured,
}

impl Row {
    fn group(&self) -> &str {
        self.name.split('/').next().unwrap_or(&self.name)
    }
}

pub fn run(effort: &Effort) -> Result<Vec<Row>> {
    // What criterion leaves is nothing for a reader.
    let output = workspace::target_directory()?.join("bench");
    fs::create_dir_all(&output)?;
    let facts = output.join("kernel-facts.csv");
    let home = output.join("criterion");
    // Nothing of an earlier run may be taken for this one's.
    if home.is_dir() {
        fs::remove_dir_all(&home)?;
    }
    let mut command = workspace::cargo();
    command.args(["bench", "--package", "ellgran", "--bench", "kernels", "--"]);
    command.args(["--noplot", "--sample-size", "20"]);
    if effort.quick {
        command.args(["--warm-up-time", "0.05", "--measurement-time", "0.2"]);
    }
    command
        .env("ELLGRAN_BENCH_FACTS", &facts)
        .env("CRITERION_HOME", &home);
    let mut progress = Progress::start(if find_program("rustc").is_some() {
        "Kernels (built first when they changed)"
    } else {
        "Kernels"
    });
    let result = run_logged(&mut command, &output.join("kernels.log"), |line| {
        if let Some(name) = line.strip_prefix("Benchmarking ") {
            progress.update(None, name.split(": ").next().unwrap_or(name));
        }
    });
    match &result {
        Ok(()) => progress.finish(),
        Err(_) => progress.clear(),
    }
    result.context("the kernel benchmark failed")?;
    let text = fs::read_to_string(&facts)
        .with_context(|| format!("the benchmark left no {}", facts.display()))?;
    fs::remove_file(&facts)?;
    text.lines().map(|line| read(line, &home)).collect()
}

fn read(line: &str, home: &Path) -> Result<Row> {
    let (name, rest) = line
        .strip_prefix('"')
        .and_then(|line| line.split_once("\","))
        .with_context(|| format!("not a line of facts: {line}"))?;
    let numbers: Vec<f64> = rest
        .split(',')
        .map(str::parse)
        .collect::<Result<_, _>>()
        .with_context(|| format!("not numbers: {rest}"))?;
    let [history_bytes, particles, pairs, touching, particle_bytes] = numbers[..] else {
        anyhow::bail!("not five numbers: {rest}");
    };
    let directory = name
        .split('/')
        .fold(home.to_path_buf(), |path, part| path.join(part));
    let path = directory.join("new/estimates.json");
    let text = fs::read_to_string(&path)
        .with_context(|| format!("criterion left no {}", path.display()))?;
    let estimates: serde_json::Value = serde_json::from_str(&text)?;
    let estimate = |of: &str| {
        estimates[of]["point_estimate"]
            .as_f64()
            .with_context(|| format!("{} has no {of}", path.display()))
    };
    Ok(Row {
        name: name.to_string(),
        history_bytes,
        particles,
        pairs,
        touching,
        particle_bytes,
        time: Measured {
            median: estimate("median")?,
            spread: estimate("median_abs_dev")?,
        },
    })
}

pub fn tables(rows: &[Row]) -> Vec<Table> {
    vec![laws(rows), parts(rows)]
}

/// Law by law, a column of each instruction set.
fn laws(rows: &[Row]) -> Table {
    const PREFIX: &str = "pairs, ";
    let sets = Contender::instruction_sets();
    let mut head = vec!["law".to_string(), "history per contact (bytes)".to_string()];
    for set in &sets {
        head.push(format!("{set} (ns per touching pair)"));
        head.push(format!("{set}, saved (%)"));
    }
    let (touch, all) = rows
        .first()
        .map_or((0.0, 1.0), |row| (row.touching, row.pairs));
    let mut table = Table::new(
        &format!(
            "Laws: ns per touching pair of a dense packing ({} grains, {:.0} % of the listed pairs touch), the other pairs' rejection in it",
            rows.first().map_or(0.0, |row| row.particles),
            100.0 * touch / all
        ),
        &head.iter().map(String::as_str).collect::<Vec<_>>(),
    );
    let mut groups: Vec<&str> = Vec::new();
    for row in rows {
        if row.name.starts_with(PREFIX) && !groups.contains(&row.group()) {
            groups.push(row.group());
        }
    }
    let cell = |group: &str, set: &str| {
        rows.iter()
            .find(|row| row.name == format!("{group}/{set}"))
            .map(|row| (row.history_bytes, row.time.scaled(1.0 / row.touching)))
    };
    for group in &groups {
        let mut line = vec![group[PREFIX.len()..].to_string()];
        line.push(cell(group, sets[0]).map_or(String::new(), |(bytes, _)| bytes.to_string()));
        for set in &sets {
            let own = cell(group, set).map(|(_, time)| time);
            let full = cell(groups[0], set).map(|(_, time)| time.median);
            line.push(own.map_or(String::new(), |time| time.show()));
            line.push(match (own, full) {
                (Some(own), Some(full)) if group != &groups[0] => {
                    format!("{:.0}", 100.0 * (1.0 - own.median / full))
                }
                _ => String::new(),
            });
        }
        table.row(line);
    }
    table
}

/// What is not a law.
fn parts(rows: &[Row]) -> Table {
    let mut table = Table::new("Parts", &["part", "instruction set", "time (ns)", "per"]);
    for row in rows {
        let (group, set) = row.name.split_once('/').unwrap_or((&row.name, ""));
        if group.starts_with("pairs, ") {
            continue;
        }
        let (count, per) = if group.starts_with("rejected") {
            (row.pairs, "listed pair")
        } else if group.starts_with("preparation") || group.starts_with("wall, far") {
            (row.particles, "grain and step")
        } else if group.starts_with("Hertz") {
            (row.pairs, "contact")
        } else if group.starts_with("wall, ") {
            (row.touching, "contact with a wall")
        } else {
            (row.touching, "touching pair")
        };
        table.row(vec![
            group.into(),
            set.into(),
            row.time.scaled(1.0 / count).show(),
            per.into(),
        ]);
    }
    if let Some(row) = rows.first() {
        table.row(vec![
            "memory".into(),
            String::new(),
            short(row.particle_bytes),
            "bytes per grain".into(),
        ]);
    }
    table
}

pub fn csv(rows: &[Row]) -> String {
    let mut text = String::from(
        "benchmark,history_bytes_per_pair,grains,pairs,touching,bytes_per_grain,ns,median_absolute_deviation_ns,ns_per_touching_pair\n",
    );
    for row in rows {
        text += &format!(
            "\"{}\",{},{},{},{},{},{:.1},{:.1},{:.3}\n",
            row.name,
            row.history_bytes,
            row.particles,
            row.pairs,
            row.touching,
            row.particle_bytes,
            row.time.median,
            row.time.spread,
            row.time.median / row.touching.max(1.0)
        );
    }
    text
}
