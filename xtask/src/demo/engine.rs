// SPDX-License-Identifier: MIT OR Apache-2.0
//! LAMMPS with the plugin, ready to run decks.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Result;

use super::deck;
use crate::process::output_of;
use crate::{lammps, plugin, workspace};

pub struct Engine {
    binary: PathBuf,
    plugin: PathBuf,
    /// The release, as LAMMPS spells it.
    pub release: String,
    /// Has it `pair_style granular/superellipsoid`, which came in 2026?
    pub superellipsoid: bool,
    /// Where runs write.
    pub data: PathBuf,
}

impl Engine {
    /// Fetches and builds what is missing.
    pub fn prepare(data: &Path) -> Result<Self> {
        let source = lammps::source()?;
        let binary = source.binary()?;
        let plugin = plugin::plugin(&source)?;
        fs::create_dir_all(data)?;
        let help = output_of(Command::new(&binary).arg("-help"))?;
        Ok(Engine {
            superellipsoid: help
                .split_whitespace()
                .any(|word| word == "granular/superellipsoid"),
            release: source.spelled()?,
            binary,
            plugin,
            data: data.canonicalize()?,
        })
    }

    /// Runs `deck`, a path below examples/lammps, with the plugin and the given variables. `name` is the log's.
    pub fn run(&self, deck: &str, name: &str, variables: &[(&str, &str)]) -> Result<()> {
        self.run_at(
            &workspace::root().join("examples/lammps").join(deck),
            name,
            variables,
        )
    }

    /// The same for a deck anywhere.
    pub fn run_at(&self, deck: &Path, name: &str, variables: &[(&str, &str)]) -> Result<()> {
        let mut command = Command::new(&self.binary);
        command
            .arg("-nocite")
            .args(["-var", "plugin"])
            .arg(&self.plugin);
        deck::run(&mut command, deck, name, &self.data, variables)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.data.join(name)
    }

    pub fn columns<const N: usize>(&self, name: &str) -> Result<Vec<[f64; N]>> {
        deck::columns(&self.path(name))
    }
}
