// SPDX-License-Identifier: MIT OR Apache-2.0
//! What became of the mutants of the present sources: one list of names for each outcome, in `validation/mutants`.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};

use crate::demo::table::Table;
use crate::workspace::root;

/// In the order of how much the tests notice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// A test fails.
    Caught,
    /// A test takes many times as long, or never ends.
    NeverEnds,
    /// The tests see another value, and pass.
    Missed,
    /// No test makes it give another value.
    Same,
    /// No test comes to it.
    Unreached,
    /// rustc refuses it.
    Unviable,
}

impl Outcome {
    const ALL: [(Outcome, &'static str); 6] = [
        (Outcome::Caught, "caught"),
        (Outcome::NeverEnds, "never_ends"),
        (Outcome::Missed, "missed"),
        (Outcome::Same, "same_value"),
        (Outcome::Unreached, "not_reached"),
        (Outcome::Unviable, "unviable"),
    ];

    /// Whether the mutant lives.
    pub fn survived(self) -> bool {
        matches!(self, Outcome::Missed | Outcome::Same | Outcome::Unreached)
    }
}

pub struct Stored {
    by_name: BTreeMap<String, Outcome>,
}

impl Stored {
    fn file(list: &str) -> PathBuf {
        root()
            .join("validation/mutants")
            .join(format!("{list}.txt"))
    }

    /// Outcomes of mutants that there still are; a file that was changed has new ones.
    pub fn read(all: &BTreeSet<&str>) -> Stored {
        let mut by_name = BTreeMap::new();
        for (outcome, list) in Outcome::ALL {
            let text = fs::read_to_string(Self::file(list)).unwrap_or_default();
            let names = text.lines().filter(|name| all.contains(name));
            by_name.extend(names.map(|name| (name.to_string(), outcome)));
        }
        Stored { by_name }
    }

    pub fn of(&self, name: &str) -> Option<Outcome> {
        self.by_name.get(name).copied()
    }

    pub fn set(&mut self, name: &str, outcome: Outcome) {
        self.by_name.insert(name.to_string(), outcome);
    }

    /// Of one that survived other tests too: it is as near to being caught as in the best of them.
    pub fn set_unless_less(&mut self, name: &str, outcome: Outcome) {
        let before = self.of(name).filter(|before| before.survived());
        let outcome = before.map_or(outcome, |before| before.min(outcome));
        self.set(name, outcome);
    }

    pub fn write(&self) -> Result<()> {
        for (outcome, list) in Outcome::ALL {
            let file = Self::file(list);
            let mut text = String::new();
            for (name, _) in self.by_name.iter().filter(|(_, o)| **o == outcome) {
                text += &format!("{name}\n");
            }
            fs::create_dir_all(file.parent().context("no folder")?)?;
            fs::write(&file, text).with_context(|| format!("cannot write {}", file.display()))?;
        }
        Ok(())
    }

    pub fn table(&self, all: &BTreeSet<&str>) -> Table {
        let mut table = Table::new(
            "Mutants of the contact law and of the geometry",
            &[
                "file",
                "mutants",
                "caught",
                "never end",
                "missed",
                "same value in all tests",
                "reached by no test",
                "cannot be compiled",
                "not tried",
            ],
        );
        let file_of = |name: &str| name.split(':').next().unwrap_or_default().to_string();
        let files: BTreeSet<String> = all.iter().map(|name| file_of(name)).collect();
        let mut row = |title: &str, names: &[&str]| {
            let count = |outcome| {
                let of = names.iter().filter(|name| self.of(name) == outcome);
                of.count().to_string()
            };
            let mut cells = vec![title.to_string(), names.len().to_string()];
            cells.extend(Outcome::ALL.map(|(outcome, _)| count(Some(outcome))));
            cells.push(count(None));
            table.row(cells);
        };
        for file in &files {
            let names = all.iter().copied().filter(|name| file_of(name) == *file);
            row(file, &names.collect::<Vec<_>>());
        }
        row("all", &all.iter().copied().collect::<Vec<_>>());
        table
    }
}
