// SPDX-License-Identifier: MIT OR Apache-2.0
//! What has been tried and what came out, family by family; kept in a file, from which a run goes on.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

use serde::{Deserialize, Serialize};

/// Findings that are kept of each family, the worst.
const MOST_FINDINGS: usize = 20;
/// Pairs of each family for the reference: drawn at random, and those at which the paths differed most.
const RANDOM_SAMPLE: usize = 12;
const WORST_SAMPLE: usize = 8;

/// What is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Kind {
    /// A pair within all ranges was refused.
    Refused,
    /// A number that is none.
    NotFinite,
    /// The penetration is not the global minimum.
    NotTheLeast,
    /// Force, torque or history differ by more than rounding of the input explains.
    Differs,
}

/// One wrong answer, and how to have it again.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Finding {
    pub kind: Kind,
    pub block: u64,
    pub pair: usize,
    pub step: usize,
    pub deck: String,
    pub words: String,
    /// Times what is allowed; the largest number where nothing is.
    pub severity: f64,
}

/// A pair for the reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sampled {
    pub block: u64,
    pub pair: usize,
    pub step: usize,
    /// Difference of the paths in what rounding explains.
    pub weight: f64,
}

/// Of one family.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Counts {
    /// Blocks that are done: those with smaller numbers.
    pub blocks: u64,
    pub pairs: u64,
    /// Contacts, steps counted one by one.
    pub touching: u64,
    pub wrong: BTreeMap<String, u64>,
    /// Contacts whose differences had to be explained by rounding, and were.
    pub at_rounding: u64,
    /// Contacts for which two paths found different normals of the same penetration.
    pub equal_minima: u64,
    /// Contacts whose minimum is flat in one direction: a ring, a valley.
    pub not_isolated: u64,
    pub by_brute_force: u64,
    pub slowest_nanoseconds: u64,
    /// Block and pair.
    pub slowest: [u64; 2],
    pub findings: Vec<Finding>,
    /// By the number that was drawn for each.
    pub random_sample: Vec<(u64, Sampled)>,
    pub worst_sample: Vec<Sampled>,
}

impl Counts {
    pub fn found(&mut self, finding: Finding) {
        *self.wrong.entry(format!("{:?}", finding.kind)).or_default() += 1;
        self.findings.push(finding);
        self.trim();
    }

    pub fn sample(&mut self, sampled: Sampled, drawn: u64) {
        let random = &mut self.random_sample;
        if random.len() < RANDOM_SAMPLE || drawn < random[random.len() - 1].0 {
            random.push((drawn, sampled));
        }
        let worst = &mut self.worst_sample;
        let least = worst.last().map_or(0.0, |s| s.weight);
        if sampled.weight > 0.0 && (worst.len() < WORST_SAMPLE || sampled.weight > least) {
            worst.push(sampled);
        }
        self.trim();
    }

    /// What came out of more blocks.
    pub fn add(&mut self, part: Counts) {
        self.pairs += part.pairs;
        self.touching += part.touching;
        for (kind, number) in part.wrong {
            *self.wrong.entry(kind).or_default() += number;
        }
        self.at_rounding += part.at_rounding;
        self.equal_minima += part.equal_minima;
        self.not_isolated += part.not_isolated;
        self.by_brute_force += part.by_brute_force;
        if part.slowest_nanoseconds > self.slowest_nanoseconds {
            self.slowest_nanoseconds = part.slowest_nanoseconds;
            self.slowest = part.slowest;
        }
        self.findings.extend(part.findings);
        self.random_sample.extend(part.random_sample);
        self.worst_sample.extend(part.worst_sample);
        self.trim();
    }

    /// Holds the findings against those that their blocks have now.
    pub fn try_again(&mut self, findings_of: impl Fn(u64) -> Vec<Finding>) {
        let before = std::mem::take(&mut self.findings);
        let blocks: std::collections::BTreeSet<u64> = before.iter().map(|f| f.block).collect();
        for finding in &before {
            let kind = format!("{:?}", finding.kind);
            let number = self.wrong.get_mut(&kind).expect("it was counted");
            *number -= 1;
            println!(
                "block {}, pair {}: {}",
                finding.block, finding.pair, finding.words
            );
        }
        for finding in blocks.into_iter().flat_map(findings_of) {
            println!(
                "still: block {}, pair {}: {}",
                finding.block, finding.pair, finding.words
            );
            self.found(finding);
        }
    }

    fn trim(&mut self) {
        self.findings.sort_by(|a, b| {
            let by_kind = a.kind.cmp(&b.kind);
            let by_severity = b.severity.total_cmp(&a.severity);
            let by_name = (a.block, a.pair, a.step).cmp(&(b.block, b.pair, b.step));
            by_kind.then(by_severity).then(by_name)
        });
        self.findings.truncate(MOST_FINDINGS);
        self.random_sample
            .sort_by_key(|(drawn, s)| (*drawn, s.block, s.pair, s.step));
        self.random_sample.truncate(RANDOM_SAMPLE);
        self.worst_sample.sort_by(|a, b| {
            let by_name = (a.block, a.pair, a.step).cmp(&(b.block, b.pair, b.step));
            b.weight.total_cmp(&a.weight).then(by_name)
        });
        self.worst_sample.truncate(WORST_SAMPLE);
    }

    pub fn wrong_answers(&self) -> u64 {
        self.wrong.values().sum()
    }
}

/// A run, as it stands in its file.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct State {
    /// Of the library: another one may answer otherwise.
    pub version: String,
    pub seed: u64,
    /// How many of the pairs went through each instruction set: a run may go on on a machine that has others.
    pub pairs_by_instruction_set: BTreeMap<String, u64>,
    /// Processor time so far, all threads together.
    pub seconds: f64,
    pub families: BTreeMap<String, Counts>,
    pub refusals: super::refusals::Refusals,
}

impl State {
    /// Of the file, or a new one where there is none.
    ///
    /// # Errors
    /// A file that is of another version or seed.
    pub fn begin(file: &Path, seed: u64) -> Result<State, Box<dyn std::error::Error>> {
        let new = State {
            version: env!("CARGO_PKG_VERSION").into(),
            seed,
            pairs_by_instruction_set: BTreeMap::new(),
            seconds: 0.0,
            families: BTreeMap::new(),
            refusals: super::refusals::Refusals::default(),
        };
        if !file.exists() {
            return Ok(new);
        }
        let old: State = serde_json::from_str(&std::fs::read_to_string(file)?)
            .map_err(|e| format!("{} is not the state of a run: {e}", file.display()))?;
        if old.version != new.version || old.seed != new.seed {
            return Err(format!(
                "{} is of version {}, seed {}: remove it, or name another file with --state",
                file.display(),
                old.version,
                old.seed
            )
            .into());
        }
        Ok(old)
    }

    /// All of it or nothing: a run may be stopped at any time.
    pub fn write(&self, file: &Path) -> Result<(), Box<dyn std::error::Error>> {
        let next = file.with_extension("next");
        let mut out = std::fs::File::create(&next)?;
        out.write_all(serde_json::to_string_pretty(self)?.as_bytes())?;
        out.sync_all()?;
        std::fs::rename(next, file)?;
        Ok(())
    }

    /// So many more pairs went through each instruction set of this machine.
    pub fn count_for_each_set(&mut self, pairs: u64) {
        for set in crate::support::list::instruction_sets() {
            let name = set.name().to_string();
            *self.pairs_by_instruction_set.entry(name).or_default() += pairs;
        }
    }

    pub fn pairs(&self) -> u64 {
        self.families.values().map(|c| c.pairs).sum()
    }

    pub fn wrong(&self) -> u64 {
        let wrong = self.families.values().map(Counts::wrong_answers);
        wrong.sum::<u64>() + self.refusals.wrong.len() as u64
    }
}
