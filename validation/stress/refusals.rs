// SPDX-License-Identifier: MIT OR Apache-2.0
//! Input out of range: the list must refuse it on each instruction set in words that name the particle and the value.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::families::Family;
use crate::support::list::{instruction_sets, PairList};
use crate::support::random::Stream;
use crate::support::scene::laws;
use ellgran::contact::{Body, Step};

/// What was refused in which words.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Refusals {
    /// Inputs out of range, each on each instruction set.
    pub tried: u64,
    /// How often which words came, without their numbers.
    pub words: BTreeMap<String, u64>,
    /// What was not refused, or not in words that name particle and value.
    pub wrong: Vec<String>,
}

/// What no number of a body may be.
const NEVER: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
type Spoil = (&'static str, fn(&mut Body) -> &mut [f64], &'static [f64]);

const SPOILED: [Spoil; 6] = [
    ("position", |b| &mut b.position, &[1e21, -1e300]),
    (
        "semi-axis",
        |b| &mut b.semi_axes,
        &[0.0, -1.0, 1e-21, 5e-324, 1e21, 1e300],
    ),
    ("quaternion", |b| &mut b.quaternion, &[]),
    ("velocity", |b| &mut b.velocity, &[1e26, -1e300]),
    (
        "angular velocity",
        |b| &mut b.angular_velocity,
        &[1e26, -1e300],
    ),
    (
        "mass",
        |b| core::slice::from_mut(&mut b.mass),
        &[0.0, -1.0, 1e-60, 1e60, 5e-324],
    ),
];

impl Refusals {
    /// Each number of a body of one pair among others, out of range in each way.
    pub fn run(seed: u64) -> Refusals {
        let mut refusals = Refusals::default();
        let laws = laws(&["hertz 1e6 0.3 damping restitution 0.5 tangential tfd 0.5"]);
        let mut stream = Stream::new(seed);
        for (name, field, values) in SPOILED {
            for value in NEVER.iter().chain(values) {
                if name == "mass" && *value == f64::INFINITY {
                    // A fixed body.
                    continue;
                }
                for place in 0..field(&mut Family::AnyShape.draw(&mut stream, false).i).len() {
                    let mut pairs: Vec<(Body, Body)> = (0..9)
                        .map(|_| Family::AnyShape.draw(&mut stream, false))
                        .map(|d| (d.i, d.j))
                        .collect();
                    let spoiled = &mut pairs[5].1;
                    spoiled.identifier = 4711;
                    field(spoiled)[place] = *value;
                    for set in instruction_sets() {
                        refusals.tried += 1;
                        let mut list = PairList::new(&laws, set, pairs.len());
                        let step = Step {
                            time_step: 1e-6,
                            advance_history: true,
                        };
                        let said = list.advance(&pairs, &step);
                        refusals.heard(
                            said,
                            &format!("{name} {value:e} on {}", set.name()),
                            *value,
                        );
                    }
                }
            }
        }
        refusals
    }

    fn heard(&mut self, said: Result<(), String>, what: &str, value: f64) {
        match said {
            Ok(()) => self.wrong.push(format!("{what}: not refused")),
            Err(words) => {
                let shown = [format!("{value}"), format!("{value:e}")];
                if !words.contains("particle 4711") || !shown.iter().any(|v| words.contains(v)) {
                    self.wrong.push(format!("{what}: {words}"));
                }
                *self.words.entry(without_numbers(&words)).or_default() += 1;
            }
        }
    }
}

/// The words with each number that is not one of the ranges as an ellipsis.
fn without_numbers(words: &str) -> String {
    let number = |word: &str| {
        let bare = word.trim_matches(|c: char| "(),;".contains(c));
        bare.parse::<f64>().is_ok() || bare == "-inf"
    };
    let mut shown: Vec<&str> = Vec::new();
    let mut after_range = false;
    for word in words.split_whitespace() {
        let range = after_range && number(word);
        let ellipsis = number(word) && !range;
        if !(ellipsis && shown.last() == Some(&"…")) {
            shown.push(if ellipsis { "…" } else { word });
        }
        after_range = matches!(word, "from" | "to" | "between" | "and" | "than" | "be");
    }
    shown.join(" ")
}
