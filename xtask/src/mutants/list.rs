// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which mutants are there? cargo-mutants says.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use serde_json::Value;

use crate::cache;
use crate::process::{output_of, run_open};
use crate::progress::say;
use crate::workspace::{cargo, root};

/// Of cargo-mutants.
const VERSION: &str = "27.1.0";

/// Where something is in a file, as compilers count: lines and columns of characters from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position {
    pub line: usize,
    pub column: usize,
}

/// What kind of change a mutant is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Genre {
    /// Another operator between two operands, `+=` and its like among them.
    BinaryOperator,
    /// No `-` or `!`.
    UnaryOperator,
    /// A function that returns something else.
    FunctionValue,
    /// The condition of an arm of a `match`.
    ArmGuard,
    /// An arm of a `match` less.
    Arm,
    /// A field less, which then is as in the struct after `..`.
    Field,
}

#[derive(Clone, Debug)]
pub struct Mutant {
    /// File, line, column and what is changed.
    pub name: String,
    pub file: String,
    pub genre: Genre,
    pub start: Position,
    pub end: Position,
    pub replacement: String,
}

/// cargo-mutants, installed in the cache.
pub fn program() -> Result<PathBuf> {
    let _lock = cache::lock("cargo-mutants")?;
    let place = cache::directory()?.join(format!("cargo-mutants-{VERSION}"));
    let program = place.join("bin").join("cargo-mutants");
    if !program.is_file() {
        say(format!("installing cargo-mutants {VERSION}"));
        let version = format!("={VERSION}");
        let mut install = cargo();
        install.args([
            "install",
            "--quiet",
            "--locked",
            "cargo-mutants",
            "--version",
        ]);
        run_open(install.arg(version).arg("--root").arg(&place))?;
    }
    Ok(program)
}

/// All mutants of some files.
pub fn mutants_of(program: &Path, files: &[String]) -> Result<Vec<Mutant>> {
    let mut command = Command::new(program);
    command
        .current_dir(root())
        .args(["mutants", "--package", "ellgran", "--list", "--json"]);
    for file in files {
        command.args(["--file", file]);
    }
    let found: Value = serde_json::from_str(&output_of(&mut command)?)?;
    let found = found.as_array().context("cargo-mutants lists no array")?;
    found.iter().map(read).collect()
}

fn read(value: &Value) -> Result<Mutant> {
    let word = |name: &str| {
        let word = value[name].as_str().map(str::to_string);
        word.with_context(|| format!("cargo-mutants gives no {name}"))
    };
    let position = |of: &str| {
        let number = |name: &str| {
            let number = value["span"][of][name].as_u64();
            number.context("cargo-mutants gives no position")
        };
        anyhow::Ok(Position {
            line: number("line")? as usize,
            column: number("column")? as usize,
        })
    };
    let genre = match word("genre")?.as_str() {
        "BinaryOperator" => Genre::BinaryOperator,
        "UnaryOperator" => Genre::UnaryOperator,
        "FnValue" => Genre::FunctionValue,
        "MatchArmGuard" => Genre::ArmGuard,
        "MatchArm" => Genre::Arm,
        "StructField" => Genre::Field,
        other => {
            anyhow::bail!("cargo-mutants has a genre of mutants that is not known here: {other}")
        }
    };
    Ok(Mutant {
        name: word("name")?,
        file: word("file")?,
        genre,
        start: position("start")?,
        end: position("end")?,
        replacement: word("replacement")?,
    })
}
