// SPDX-License-Identifier: MIT OR Apache-2.0
//! What does each test see of the mutants? Each is run once as it is, and once with all places watched.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{bail, Context, Result};
use serde_json::{json, Value};
use sha2::{Digest, Sha256};

use super::copy::{Program, Switch};
use super::trial::{tests_of, Test};
use crate::progress::Progress;

/// What a test says that needs lanes.
const WITHOUT_LANES: &str = "compiled without lanes";

pub struct Watched {
    /// The program of tests, as cargo names it.
    pub of: String,
    pub test: Test,
    /// How long the original takes.
    pub seconds: f64,
    /// Places that are reached (choice 0) and mutants that have another value.
    pub seen: BTreeSet<Switch>,
}

impl Watched {
    /// Whether the test comes to the mutant's place.
    pub fn reaches(&self, mutant: Switch) -> bool {
        let choice = 0;
        self.seen.contains(&Switch { choice, ..mutant })
    }

    /// Whether the mutant has another value there; where only reaching can be watched, whether it is reached.
    pub fn sees(&self, mutant: Switch, compared: bool) -> bool {
        if compared {
            self.seen.contains(&mutant)
        } else {
            self.reaches(mutant)
        }
    }
}

/// All tests of the programs that run without lanes, or those of them with one of these words in their name. What a program of the same
/// bytes has shown is kept where all were watched.
pub fn watch(programs: &[Program], place: &Path, words: &[String]) -> Result<Vec<Watched>> {
    let wanted = |name: &str| words.is_empty() || words.iter().any(|word| name.contains(word));
    let mut all = Vec::new();
    for program in programs {
        let digest = Sha256::digest(fs::read(&program.path)?);
        let digest: String = digest.iter().map(|b| format!("{b:02x}")).collect();
        let kept = kept(place, &program.name);
        let mut found = fs::read_to_string(&kept)
            .ok()
            .and_then(|text| serde_json::from_str::<Value>(&text).ok())
            .filter(|value| value["program"] == digest.as_str());
        if found.is_none() {
            let value = watch_program(program, &digest, &place.join("seen"), &wanted)?;
            if words.is_empty() {
                fs::write(&kept, value.to_string())?;
            }
            found = Some(value);
        }
        let found = found.context("nothing was watched")?;
        let tests = found["tests"].as_object().context("no tests")?;
        for (name, test) in tests.iter().filter(|(name, _)| wanted(name)) {
            all.push(read(program, name, test)?);
        }
    }
    Ok(all)
}

fn watch_program(
    program: &Program,
    digest: &str,
    output: &Path,
    wanted: &dyn Fn(&str) -> bool,
) -> Result<Value> {
    let mut progress = Progress::start(format!("what the tests of {} see", program.name));
    let mut tests = tests_of(program)?;
    tests.retain(|test| wanted(&test.name));
    let mut shown = serde_json::Map::new();
    for (k, test) in tests.iter().enumerate() {
        progress.update(Some(k as f64 / tests.len() as f64), &test.name);
        let (seconds, passed, said) = test.original(None)?;
        if !passed {
            if said.contains(WITHOUT_LANES) {
                continue;
            }
            bail!("{} fails without a mutant:\n{said}", test.name);
        }
        let _ = fs::remove_file(output);
        let (_, passed, said) = test.original(Some(output))?;
        if !passed {
            bail!("{} fails where it is watched:\n{said}", test.name);
        }
        let mut seen = BTreeMap::<usize, Vec<usize>>::new();
        for line in fs::read_to_string(output).unwrap_or_default().lines() {
            let (place, choice) = line.split_once(':').context("place:choice")?;
            seen.entry(place.parse()?)
                .or_default()
                .push(choice.parse()?);
        }
        let seen: Vec<_> = seen.into_iter().collect();
        shown.insert(
            test.name.clone(),
            json!({ "seconds": seconds, "seen": seen }),
        );
    }
    progress.finish();
    Ok(json!({ "program": digest, "tests": shown }))
}

fn kept(place: &Path, program: &str) -> PathBuf {
    place.join(format!("watched-{program}.json"))
}

/// The tests of a program that ran when it was last watched.
pub fn names_kept(place: &Path, program: &str) -> BTreeSet<String> {
    let text = fs::read_to_string(kept(place, program)).unwrap_or_default();
    let value: Value = serde_json::from_str(&text).unwrap_or_default();
    let tests = value["tests"].as_object();
    tests
        .into_iter()
        .flatten()
        .map(|(name, _)| name.clone())
        .collect()
}

fn read(program: &Program, name: &str, test: &Value) -> Result<Watched> {
    let mut seen = BTreeSet::new();
    let places: Vec<(usize, Vec<usize>)> = serde_json::from_value(test["seen"].clone())?;
    for (place, choices) in places {
        seen.extend(choices.iter().map(|&choice| Switch { place, choice }));
    }
    Ok(Watched {
        of: program.name.clone(),
        test: Test {
            program: program.path.clone(),
            name: name.to_string(),
        },
        seconds: test["seconds"].as_f64().context("no seconds")?,
        seen,
    })
}
