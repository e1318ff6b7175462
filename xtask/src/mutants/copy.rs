// SPDX-License-Identifier: MIT OR Apache-2.0
//! A copy of the sources that holds all mutants, and the tests compiled with it.
//!
//! What rustc says against a line of a mutant takes that mutant out; what it says against the place itself takes the place out.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{bail, Context, Result};
use serde_json::Value;

use super::examples::examples_of;
use super::list::Mutant;
use super::schemata::{changed, owner, Owner, Schemata};
use crate::process::output_of;
use crate::progress::say;
use crate::workspace::{cargo, root};

/// The tests that may kill a mutant, beside those within the library.
const TESTS: [&str; 4] = ["theory", "properties", "c_abi", EXAMPLES];
/// Made of the documentation.
const EXAMPLES: &str = "examples_of_the_documentation";

/// What the library does in the place of lanes where it is compiled without them.
const NO_LANES: &str = "panic!(\"compiled without lanes\");";

/// Files that are changed beside those with mutants.
const LANES: &str = "src/simd/mod.rs";
const LIBRARY: &str = "src/lib.rs";
const SWITCHES: &str = "\n#[doc(hidden)]\npub mod switches;\n";

/// Rounds of compilation after which something else is wrong: rustc looks at names, types and lifetimes one after the other.
const MOST_ROUNDS: usize = 20;

/// How a mutant is turned on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Switch {
    pub place: usize,
    pub choice: usize,
}

/// A program of tests.
pub struct Program {
    /// Of the target: `theory`.
    pub name: String,
    pub path: PathBuf,
}

pub struct Copy {
    sources: PathBuf,
    build: PathBuf,
    /// Each file as it was.
    texts: BTreeMap<String, String>,
    /// The mutants that can be switched.
    pub switches: BTreeMap<usize, Switch>,
    /// Those that rustc refuses.
    pub unviable: BTreeSet<usize>,
    /// Those that cannot be switched.
    pub fixed: BTreeSet<usize>,
}

impl Copy {
    /// Copies what git knows, and what it does not ignore. Compiled in `build`, with the lanes of one set of instructions or none.
    pub fn make(sources: PathBuf, build: PathBuf, mutants: &[Mutant], lanes: bool) -> Result<Self> {
        let mut list = Command::new("git");
        list.current_dir(root()).args([
            "ls-files",
            "-z",
            "--cached",
            "--others",
            "--exclude-standard",
        ]);
        // One that was deleted is still in the index.
        let listed = output_of(&mut list)?;
        let names: BTreeSet<&str> = listed
            .split('\0')
            .filter(|name| !name.is_empty() && root().join(name).is_file())
            .collect();
        let copied = sources.with_extension("copied");
        for gone in fs::read_to_string(&copied).unwrap_or_default().lines() {
            if !names.contains(gone) {
                let _ = fs::remove_file(sources.join(gone));
            }
        }
        let mutated: BTreeSet<&str> = mutants.iter().map(|m| m.file.as_str()).collect();
        for name in names.iter().filter(|name| !mutated.contains(*name)) {
            let mut text = fs::read(root().join(name))?;
            match *name {
                LIBRARY => text.extend(SWITCHES.as_bytes()),
                LANES if lanes => {
                    // The kernels of the set that every machine has take minutes to compile, those of all sets many times that.
                    let original = String::from_utf8(text)?;
                    if original.matches(NO_LANES).count() != 1 {
                        bail!("{LANES} does not refuse lanes as it did");
                    }
                    text = original
                        .replace(NO_LANES, "return run_on_baseline(stage);")
                        .into_bytes();
                }
                _ => {}
            }
            write(&sources.join(name), &text)?;
        }
        let names: Vec<&str> = names.into_iter().collect();
        fs::write(&copied, names.join("\n"))?;
        let mut texts = BTreeMap::new();
        for mutant in mutants {
            if !texts.contains_key(&mutant.file) {
                let text = fs::read_to_string(root().join(&mutant.file))?;
                texts.insert(mutant.file.clone(), text);
            }
        }
        Ok(Copy {
            sources,
            build,
            texts,
            switches: BTreeMap::new(),
            unviable: BTreeSet::new(),
            fixed: BTreeSet::new(),
        })
    }

    /// Writes all mutants into the copy, and takes out what cannot be compiled.
    pub fn switch(&mut self, mutants: &[Mutant]) -> Result<()> {
        let texts = std::mem::take(&mut self.texts);
        let mut files = Vec::new();
        for (file, text) in &texts {
            let of_file: Vec<usize> = (0..mutants.len())
                .filter(|k| mutants[*k].file == *file)
                .collect();
            let schemata = Schemata::find(text, mutants, &of_file)
                .with_context(|| format!("cannot read {file}"))?;
            files.push((file, schemata));
        }
        let mut first = 0;
        let mut places = Vec::new();
        for (_, schemata) in &files {
            for place in schemata.places() {
                for (at, mutant) in place.mutants.iter().enumerate() {
                    let choice = at + 1;
                    let place = first;
                    self.switches.insert(*mutant, Switch { place, choice });
                }
                places.push(place.mutants.clone());
                first += 1;
            }
        }
        self.fixed = (0..mutants.len())
            .filter(|k| !self.switches.contains_key(k))
            .collect();
        let switches =
            include_str!("switches.rs").replace("PLACES_OF_THE_COPY", &places.len().to_string());
        write(&self.sources.join("src/switches.rs"), switches.as_bytes())?;
        let examples = self.sources.join("tests").join(format!("{EXAMPLES}.rs"));
        write(&examples, examples_of(&root().join("src"))?.as_bytes())?;
        // What rustc refused last time it will refuse again.
        let kept = self.sources.with_extension("refused");
        for line in fs::read_to_string(&kept).unwrap_or_default().lines() {
            let (alone, name) = line.split_once(' ').unwrap_or_default();
            if let Some(mutant) = mutants.iter().position(|m| m.name == name) {
                let refused = if alone == "fixed" {
                    &mut self.fixed
                } else {
                    &mut self.unviable
                };
                refused.insert(mutant);
            }
        }
        for _ in 0..MOST_ROUNDS {
            let left_out = &self.unviable | &self.fixed;
            let mut first = 0;
            for (file, schemata) in &files {
                let text = schemata.write(first, &left_out);
                write(&self.sources.join(file), text.as_bytes())?;
                first += schemata.places().len();
            }
            let refused = self.check()?;
            if refused.is_empty() {
                self.texts = texts;
                for mutant in &left_out {
                    self.switches.remove(mutant);
                }
                let line = |of: &str, k: &usize| format!("{of} {}\n", mutants[*k].name);
                let fixed = self.fixed.iter().map(|k| line("fixed", k));
                let unviable = self.unviable.iter().map(|k| line("unviable", k));
                fs::write(&kept, fixed.chain(unviable).collect::<String>())?;
                return Ok(());
            }
            let known = left_out.len();
            for owner in refused {
                match owner {
                    Owner::Mutant(mutant) => drop(self.unviable.insert(mutant)),
                    Owner::Place(place) => {
                        let viable = places[place].iter().filter(|m| !self.unviable.contains(m));
                        self.fixed.extend(viable);
                    }
                }
            }
            if (&self.unviable | &self.fixed).len() == known {
                bail!("rustc refuses what has been taken out already");
            }
        }
        bail!("the copy with the mutants does not become one that can be compiled")
    }

    /// Writes one mutant alone.
    pub fn write_alone(&self, mutant: &Mutant) -> Result<()> {
        let text = changed(&self.texts[&mutant.file], mutant)?;
        write(&self.sources.join(&mutant.file), text.as_bytes())
    }

    /// Writes a file as it was.
    pub fn write_original(&self, file: &str) -> Result<()> {
        write(&self.sources.join(file), self.texts[file].as_bytes())
    }

    fn cargo(&self, what: &str) -> Command {
        let mut cargo = cargo();
        cargo
            .current_dir(&self.sources)
            // Without lanes a compilation takes seconds, and the tests without them hold the same text.
            .env("RUSTFLAGS", "--cfg ellgran_without_lanes --cap-lints allow")
            .env_remove("CARGO_TARGET_DIR")
            .args([what, "--package", "ellgran", "--profile", "mutants"])
            .args(["--message-format", "json", "--target-dir"])
            .arg(&self.build);
        cargo
    }

    /// To whom the lines belong that rustc refuses.
    fn check(&self) -> Result<Vec<Owner>> {
        let mut command = self.cargo("check");
        let mut refused = Vec::new();
        let mut nobodys = String::new();
        let mut texts = BTreeMap::new();
        for message in messages(command.arg("--lib"))? {
            let message = &message["message"];
            if message["level"] != "error" {
                continue;
            }
            let spans = message["spans"].as_array().cloned().unwrap_or_default();
            // That rustc stops is told as an error too.
            if spans.is_empty() {
                continue;
            }
            let mut owners = Vec::new();
            for primary in [true, false] {
                for span in spans.iter().filter(|s| s["is_primary"] == primary) {
                    let file = span["file_name"].as_str().unwrap_or_default().to_string();
                    let line = span["line_start"].as_u64().unwrap_or(1) as usize;
                    let path = self.sources.join(&file);
                    let text = texts
                        .entry(file)
                        .or_insert_with(|| fs::read_to_string(path).unwrap_or_default());
                    owners.extend(text.lines().nth(line - 1).and_then(owner));
                }
            }
            match owners.into_iter().next() {
                Some(owner) => refused.push(owner),
                None => nobodys += message["rendered"].as_str().unwrap_or_default(),
            }
        }
        // It may follow from what else is refused.
        if refused.is_empty() && !nobodys.is_empty() {
            bail!("rustc refuses what is nobody's:\n{nobodys}");
        }
        Ok(refused)
    }

    /// The programs of the tests; none where something cannot be compiled.
    pub fn tests(&self) -> Result<Option<Vec<Program>>> {
        let mut command = self.cargo("test");
        command.args(["--no-run", "--lib"]);
        for test in TESTS {
            command.args(["--test", test]);
        }
        let mut programs = Vec::new();
        for message in messages(&mut command)? {
            if message["message"]["level"] == "error" {
                return Ok(None);
            }
            if let Some(path) = message["executable"].as_str() {
                let name = message["target"]["name"].as_str().unwrap_or_default();
                programs.push(Program {
                    name: name.to_string(),
                    path: path.into(),
                });
            }
        }
        if programs.len() != TESTS.len() + 1 {
            bail!("cargo made {} programs of tests", programs.len());
        }
        Ok(Some(programs))
    }
}

/// Leaves a file of the same bytes alone, so that cargo need not compile it again.
fn write(file: &Path, text: &[u8]) -> Result<()> {
    if fs::read(file).is_ok_and(|there| there == text) {
        return Ok(());
    }
    fs::create_dir_all(file.parent().context("no folder")?)?;
    fs::write(file, text).with_context(|| format!("cannot write {}", file.display()))
}

/// What cargo says, a JSON object a line.
fn messages(command: &mut Command) -> Result<Vec<Value>> {
    command.stdin(Stdio::null());
    let output = command.output().context("cannot start cargo")?;
    let text = String::from_utf8_lossy(&output.stdout);
    let messages: Vec<Value> = text
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok())
        .collect();
    if !output.status.success() && !messages.iter().any(|m| m["message"]["level"] == "error") {
        say(String::from_utf8_lossy(&output.stderr));
        bail!("cargo: {}", output.status);
    }
    Ok(messages)
}
