// SPDX-License-Identifier: MIT OR Apache-2.0
//! Stiff and extreme: random and adversarial pairs through the neighbour-list path on each instruction set of the machine, with
//! counts of what is wrong. `cargo xtask stress` runs it, holds a sample against the reference with 60 digits, and writes the
//! page.
//!
//! - `cargo bench --bench stress -- run (--pairs N | --seconds S) --state FILE [--seed N] [--threads N]` begins a run, or goes on
//!   with the one of the file.
//! - `... -- sample --state FILE --to FILE` writes the pairs for the reference.
//! - `... -- stability --to FILE` finds the largest stable steps.
//! - `... -- pair FAMILY BLOCK PAIR [--seed N]` prints one pair; the family by its number, counted from 0 in the order of
//!   `Family::ALL`.
//! - `... -- again --state FILE [--seed N]` tries the blocks of all findings again, after the library or this program was mended, and takes
//!   those out of the run that hold now.
//! - `... -- block FAMILY BLOCK [--seed N]` has a block again, each contact held against descents from very many directions, and fails
//!   where something is wrong.

mod block;
mod counts;
mod families;
mod materials;
mod refusals;
mod run;
mod sample;
mod stability;

#[path = "../../tests/support/mod.rs"]
mod support;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use block::{Block, Name};
use counts::{Counts, State};
use families::Family;
use run::{go_on, Length};

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// Of a run where none is given.
const SEED: u64 = 2013;

fn main() -> ExitCode {
    match work() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("stress: {error}");
            ExitCode::FAILURE
        }
    }
}

/// The words of the command line: the options with their values, and the others.
struct Words {
    options: Vec<(String, String)>,
    others: Vec<String>,
}

impl Words {
    fn read() -> Result<Words, Box<dyn std::error::Error>> {
        let mut words = Words {
            options: Vec::new(),
            others: Vec::new(),
        };
        let mut given = std::env::args().skip(1);
        while let Some(word) = given.next() {
            match word.strip_prefix("--") {
                // cargo's own.
                Some("bench") => {}
                Some(name) => {
                    let value = given.next().ok_or(format!("--{name} needs a value"))?;
                    words.options.push((name.into(), value));
                }
                None => words.others.push(word),
            }
        }
        Ok(words)
    }

    fn option(&self, name: &str) -> Option<&str> {
        let found = self.options.iter().find(|(n, _)| n == name);
        found.map(|(_, value)| value.as_str())
    }

    fn file(&self, name: &str) -> Result<PathBuf, Box<dyn std::error::Error>> {
        Ok(self
            .option(name)
            .ok_or(format!("--{name} FILE is wanted"))?
            .into())
    }

    fn number<T: std::str::FromStr>(
        &self,
        name: &str,
    ) -> Result<Option<T>, Box<dyn std::error::Error>> {
        let read = |value: &str| {
            let number = value.parse();
            number.map_err(|_| format!("--{name} {value}: a number is wanted"))
        };
        Ok(self.option(name).map(read).transpose()?)
    }
}

fn work() -> Outcome {
    let words = Words::read()?;
    let others: Vec<&str> = words.others.iter().map(String::as_str).collect();
    let seed = words.number("seed")?.unwrap_or(SEED);
    match others[..] {
        ["run"] => {
            let file = words.file("state")?;
            let length = match (words.number("pairs")?, words.number("seconds")?) {
                (Some(pairs), None) => Length::Pairs(pairs),
                (None, Some(seconds)) => Length::Time(Duration::from_secs_f64(seconds)),
                _ => return Err("either --pairs N or --seconds S is wanted".into()),
            };
            let threads = words.number("threads")?.unwrap_or(1);
            let mut state = State::begin(&file, seed)?;
            go_on(&mut state, length, threads, Some(&file), |state, share| {
                eprintln!(
                    "{:3.0} %, {} pairs in {:.0} s of processor time, {} wrong",
                    100.0 * share,
                    state.pairs(),
                    state.seconds,
                    state.wrong()
                );
            })
        }
        ["sample"] => {
            let file = words.file("state")?;
            let state = State::begin(&file, seed)?;
            sample::write(&state, &words.file("to")?)
        }
        ["again"] => {
            let file = words.file("state")?;
            let mut state = State::begin(&file, seed)?;
            for (name, counts) in &mut state.families {
                let family = Family::ALL.into_iter().find(|f| f.name() == name);
                let family = family.ok_or("no such family")?;
                counts.try_again(|number| {
                    let mut now = Counts::default();
                    Block::draw(Name {
                        seed,
                        family,
                        number,
                    })
                    .run(&mut now);
                    now.findings
                });
            }
            state.write(&file)
        }
        ["stability"] => stability::write(&words.file("to")?),
        ["pair", family, block, pair] => {
            let block = named(seed, family, block)?;
            let pair = block.pairs.get(pair.parse::<usize>()?);
            println!("{}\n{:#?}", block.deck, pair.ok_or("no such pair")?);
            Ok(())
        }
        ["block", family, block] => {
            let mut block = named(seed, family, block)?;
            block.descents_every = 1;
            let mut counts = Counts::default();
            block.run(&mut counts);
            println!(
                "{} contacts, {} held against descents, wrong: {:#?}",
                counts.touching, counts.by_brute_force, counts.findings
            );
            match counts.wrong_answers() {
                0 => Ok(()),
                wrong => Err(format!("{wrong} wrong").into()),
            }
        }
        _ => Err("wanted: run, sample, again, stability, pair or block".into()),
    }
}

fn named(seed: u64, family: &str, number: &str) -> Result<Block, Box<dyn std::error::Error>> {
    let family: usize = family.parse()?;
    Ok(Block::draw(Name {
        seed,
        family: *Family::ALL.get(family).ok_or("no such family")?,
        number: number.parse()?,
    }))
}
