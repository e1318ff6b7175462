// SPDX-License-Identifier: MIT OR Apache-2.0
//! The pairs that are held against the reference with 60 digits: some drawn at random, those at which the paths differed most,
//! those of the slowest searches and all findings; and what each instruction set gives for them at rest.

use std::path::Path;

use serde::Serialize;

use super::block::{after, slack, with_unit_quaternions, Block, Given, Name, Rounding, CHANGED};
use super::counts::State;
use super::families::{Drawn, Family};
use crate::support::list::{instruction_sets, PairList};
use crate::support::scene::laws;
use ellgran::contact::{Body, Step};

/// Both bodies of this material.
pub const MATERIAL: [f64; 2] = [1e7, 0.3];

#[derive(Serialize)]
struct Case {
    family: &'static str,
    block: u64,
    pair: usize,
    step: usize,
    why: &'static str,
    bodies: [Numbers; 2],
    material: [f64; 2],
    /// What rounding of the input may do, for penetration, force and torque.
    allowed: [f64; 3],
    answers: Vec<Answer>,
}

#[derive(Serialize)]
struct Numbers {
    position: [f64; 3],
    quaternion: [f64; 4],
    semi_axes: [f64; 3],
}

#[derive(Serialize)]
struct Answer {
    instruction_set: &'static str,
    conservative: bool,
    touching: bool,
    normal: [f64; 3],
    force_j: [f64; 3],
    torque_i: [f64; 3],
    torque_j: [f64; 3],
}

fn numbers(b: &Body) -> Numbers {
    Numbers {
        position: b.position,
        quaternion: b.quaternion,
        semi_axes: b.semi_axes,
    }
}

fn case(
    family: Family,
    (block, pair, step): (u64, usize, usize),
    why: &'static str,
    seed: u64,
) -> Case {
    let drawn = Block::draw(Name {
        seed,
        family,
        number: block,
    })
    .pairs[pair];
    let (i, j) = after(&drawn, step);
    let at_rest = |b: Body| Body {
        velocity: [0.0; 3],
        angular_velocity: [0.0; 3],
        ..b
    };
    let now = (at_rest(i), at_rest(j));
    let mut answers = Vec::new();
    let mut allowed = [0.0f64; 3];
    for conservative in [false, true] {
        let word = if conservative { "yes" } else { "no" };
        let [modulus, ratio] = MATERIAL;
        let laws = laws(&[&format!("hertz {modulus:e} {ratio} conservative {word}")]);
        let still = Drawn {
            i: now.0,
            j: now.1,
            depth: drawn.depth,
        };
        let by_rounding = Rounding::new(&laws, &still, 0).of(CHANGED);
        allowed[1] = allowed[1].max(by_rounding[1]);
        allowed[2] = allowed[2].max(by_rounding[2]);
        for set in instruction_sets() {
            let mut list = PairList::new(&laws, set, 1);
            let step = Step {
                time_step: 1e-6,
                advance_history: true,
            };
            list.advance(&[now], &step).expect("within the ranges");
            let given = Given::of(&list, 0);
            let normal = if given.touching {
                given.normal().into()
            } else {
                [0.0; 3]
            };
            answers.push(Answer {
                instruction_set: set.name(),
                conservative,
                touching: given.touching,
                normal,
                force_j: given.loads[1],
                torque_i: given.loads[2],
                torque_j: given.loads[3],
            });
        }
    }
    let (i, j) = with_unit_quaternions(&now);
    allowed[0] = slack(&i, &j, 0.0);
    Case {
        family: family.name(),
        block,
        pair,
        step,
        why,
        bodies: [numbers(&now.0), numbers(&now.1)],
        material: MATERIAL,
        allowed,
        answers,
    }
}

/// Writes the cases of a run.
pub fn write(state: &State, file: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let mut cases = Vec::new();
    for family in Family::ALL {
        let Some(counts) = state.families.get(family.name()) else {
            continue;
        };
        let mut chosen: Vec<((u64, usize, usize), &'static str)> = Vec::new();
        for f in &counts.findings {
            chosen.push(((f.block, f.pair, f.step), "finding"));
        }
        for s in &counts.worst_sample {
            chosen.push(((s.block, s.pair, s.step), "worst"));
        }
        let [block, pair] = counts.slowest;
        chosen.push(((block, pair as usize, 0), "slowest"));
        for (_, s) in &counts.random_sample {
            chosen.push(((s.block, s.pair, s.step), "random"));
        }
        let mut seen = std::collections::BTreeSet::new();
        for (name, why) in chosen {
            if seen.insert(name) {
                cases.push(case(family, name, why, state.seed));
            }
        }
    }
    std::fs::write(file, serde_json::to_string(&cases)?)?;
    Ok(())
}
