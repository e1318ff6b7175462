// SPDX-License-Identifier: MIT OR Apache-2.0
//! The CSV files that measurements leave, and the program that takes them.

use std::fs;
use std::path::Path;

use anyhow::{bail, Context, Result};

use crate::process::run_logged;
use crate::progress::Progress;
use crate::workspace;

/// Takes one section's measurements into `directory`: built like a release, one run.
pub fn take(section: &str, directory: &Path, quick: bool, input: &[&str]) -> Result<()> {
    let mut command = workspace::cargo();
    command.args(["bench", "--package", "ellgran", "--bench", "report", "--"]);
    if quick {
        command.arg("--quick");
    }
    command.arg(section).arg(directory).args(input);
    let logs = tempfile::tempdir()?;
    let progress = Progress::start(format!(
        "Measuring: {section} (built first when it changed)"
    ));
    let result = run_logged(&mut command, &logs.path().join("log"), |_| {});
    match &result {
        Ok(()) => progress.finish(),
        Err(_) => progress.clear(),
    }
    result.with_context(|| format!("the measurement of {section} failed"))
}

/// A table with a line of names.
pub struct Table {
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    pub fn read(path: &Path) -> Result<Table> {
        let text =
            fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
        Table::parse(&text).with_context(|| format!("in {}", path.display()))
    }

    fn parse(text: &str) -> Result<Table> {
        let split = |line: &str| line.split(',').map(str::to_string).collect::<Vec<_>>();
        let mut lines = text.lines().map(split);
        let names = lines.next().context("empty")?;
        let rows: Vec<Vec<String>> = lines.collect();
        if let Some(row) = rows.iter().find(|row| row.len() != names.len()) {
            bail!("{} values under {} names", row.len(), names.len());
        }
        Ok(Table { names, rows })
    }

    pub fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.rows.iter().map(move |values| Row {
            names: &self.names,
            values,
        })
    }

    /// Rows where each named column has the value.
    pub fn of(&self, wanted: &[(&str, &str)]) -> Vec<Row<'_>> {
        self.rows()
            .filter(|row| wanted.iter().all(|(name, value)| row.word(name) == *value))
            .collect()
    }

    /// One number of the only row where each named column has the value.
    pub fn number(&self, wanted: &[(&str, &str)], name: &str) -> Result<f64> {
        let rows = self.of(wanted);
        let row = rows
            .first()
            .with_context(|| format!("no row with {wanted:?}"))?;
        let number = row.number(name);
        if !number.is_finite() {
            bail!("{name} is {number} for {wanted:?}");
        }
        Ok(number)
    }
}

#[derive(Clone, Copy)]
pub struct Row<'a> {
    names: &'a [String],
    values: &'a [String],
}

impl<'a> Row<'a> {
    /// Empty for a name that is none.
    pub fn word(&self, name: &str) -> &'a str {
        let at = self.names.iter().position(|one| one == name);
        at.map_or("", |at| self.values[at].as_str())
    }

    /// Not a number where there is none.
    pub fn number(&self, name: &str) -> f64 {
        self.word(name).parse().unwrap_or(f64::NAN)
    }
}

/// `1.2e-5` for tables.
pub fn scientific(value: f64) -> String {
    format!("{value:.1e}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_found_by_their_words() {
        let table = Table::parse("method,ns\nours,1.5\ntheirs,3\n").unwrap();
        assert_eq!(table.number(&[("method", "ours")], "ns").unwrap(), 1.5);
        assert!(table.number(&[("method", "nobody")], "ns").is_err());
        assert!(table.rows().next().unwrap().number("colour").is_nan());
        assert!(Table::parse("a,b\n1\n").is_err());
    }
}
