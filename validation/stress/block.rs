// SPDX-License-Identifier: MIT OR Apache-2.0
//! A block: pairs of one family under one law, through a neighbour list on each instruction set that the machine has, and what
//! is wrong with the answers.
//!
//! The scalar path is the judge of the others. An answer is wrong if its penetration is deeper than what another path, or a
//! descent from very many directions, found; if it touches where the other does not; or if its forces, torques or history differ
//! from the scalar path's by more than rounding of the pair's own numbers can explain, which is measured: the scalar path is run
//! again with each number changed by one unit in the last place.

use std::hint::black_box;
use std::time::Instant;

use super::counts::{Counts, Finding, Kind, Sampled};
use super::families::{Drawn, Family};
use super::materials::{deck, set_in_motion, TIME_STEP};
use crate::support::brute_force::deepest;
use crate::support::list::{instruction_sets, overlap, PairList};
use crate::support::random::Stream;
use crate::support::scene::{laws, quaternion, rotation, size, Rotation, Vector};
use ellgran::contact::{one_contact, prepare_body, Body, Laws, Step};
use ellgran::geometry::{search, Outcome};
use ellgran::simd::InstructionSet;

/// Pairs of a block.
pub const PAIRS: usize = 64;
/// The first with nothing remembered, the others from the normal of the step before.
pub const STEPS: usize = 2;
/// Runs with changed numbers, to see what rounding of the input does.
pub const CHANGED: usize = 12;
/// So few are enough where they explain a difference many times over: more would explain more of it.
const CHANGED_FIRST: (usize, f64) = (1, 0.05);
/// And so many where these do not explain it.
const CHANGED_OFTEN: [usize; 2] = [100, 1000];
/// Units in the last place by which they are changed. The scalar search ends where the gradient is less than four of them: it would not
/// see one.
const UNITS: f64 = 8.0;
/// Times the largest change that was seen among them, for one unit.
const ALLOWED: f64 = 64.0;
/// A difference below this, relative to the largest number of its kind, is none: it needs no explanation.
const NO_DIFFERENCE: f64 = 1e-12;
/// A number below this is zero: a contact that is deeper than rounding has none so small, at whatever lengths.
const ZERO: f64 = 1e-100;
/// What counts as no difference is more by so much times the aspect ratio of the more slender body: the lanes leave the curvature off by as much as the normal may be
/// off before its last correction (`LARGEST_CORRECTION` in src/contact/lane_search.rs), times how fast it changes with the normal.
const CURVATURE: f64 = 1e-13;
/// Nor does one of a force or torque by this many roundings of the size of the bodies over the penetration: one of them changes a force,
/// which grows as a power of the penetration, by as much, and that is a small part of what is allowed.
const ROUNDINGS: f64 = 2.0;
/// One contact in so many is held against descents from very many directions, which take as long as the rest for all of them together.
const DESCENTS_EVERY: usize = 256;
/// And the search of one pair in so many is timed.
const TIMED_EVERY: usize = 8;
/// Minima as close as this, relative, the library does not tell apart (`RESOLUTION` in src/geometry/contact_search.rs).
pub const RESOLUTION: f64 = 1e-6;

/// Which block: with the seed of a run it says everything.
#[derive(Clone, Copy, Debug)]
pub struct Name {
    pub seed: u64,
    pub family: Family,
    pub number: u64,
}

impl Name {
    fn stream(self) -> Stream {
        let family = Family::ALL.iter().position(|f| *f == self.family);
        let family = family.expect("one of all") as u64;
        Stream::new(
            self.seed
                .wrapping_mul(0x9E37_79B9_7F4A_7C15)
                .wrapping_add(self.number.wrapping_mul(0xD6E8_FEB8_6659_FD93))
                .wrapping_add(family << 56),
        )
    }
}

pub struct Block {
    pub name: Name,
    pub deck: String,
    pub pairs: Vec<Drawn>,
    /// One contact in so many is held against descents from very many directions.
    pub descents_every: usize,
}

/// What a path gave for a pair in one step.
#[derive(Clone, Debug, PartialEq)]
pub struct Given {
    pub touching: bool,
    /// Force on `i` and on `j`, torque on `i` and on `j`.
    pub loads: [[f64; 3]; 4],
    pub history: Vec<f64>,
}

impl Given {
    pub fn of(list: &PairList, pair: usize) -> Given {
        let (touching, history) = list.remembered(pair);
        let (f, t) = (&list.forces[2 * pair..], &list.torques[2 * pair..]);
        Given {
            touching,
            loads: [f[0], f[1], t[0], t[1]],
            history: if touching {
                history.to_vec()
            } else {
                Vec::new()
            },
        }
    }

    fn is_finite(&self) -> bool {
        let mut all = self.loads.iter().flatten().chain(&self.history);
        all.all(|x| x.is_finite())
    }

    /// The remembered normal.
    pub fn normal(&self) -> Vector {
        Vector::from_column_slice(&self.history[..3]).normalize()
    }

    /// What is compared: vectors of one kind, each with its own scale.
    fn kinds(&self) -> [&[f64]; 6] {
        let h = &self.history;
        [
            self.loads[0].as_slice(),
            &self.loads[1],
            self.loads[2..].as_flattened(),
            h.get(..3).unwrap_or(&[]),
            h.get(3..6).unwrap_or(&[]),
            h.get(6..).unwrap_or(&[]),
        ]
    }

    /// Largest difference of each kind.
    fn differences(&self, other: &Given) -> [f64; 6] {
        let (a, b) = (self.kinds(), other.kinds());
        core::array::from_fn(|k| {
            if a[k].len() != b[k].len() {
                // One touches, the other does not.
                return largest(a[k]).max(largest(b[k]));
            }
            let pairs = a[k].iter().zip(b[k]);
            pairs.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
        })
    }

    /// Of each kind. Terms of forces and torques come of one another, with a lever of this length.
    fn sizes(&self, lever: f64) -> [f64; 6] {
        let mut sizes = self.kinds().map(largest);
        let torque = sizes[2] / lever;
        sizes[2] = sizes[2].max(sizes[0] * lever);
        sizes[0] = sizes[0].max(torque);
        sizes[1] = sizes[1].max(torque);
        sizes
    }
}

/// Aspect ratio of the more slender of the two.
fn most_slender(i: &Body, j: &Body) -> f64 {
    let of = |b: &Body| {
        let least = b.semi_axes.iter().fold(f64::INFINITY, |m, a| a.min(m));
        largest(&b.semi_axes) / least
    };
    of(i).max(of(j))
}

fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |m, x| m.max(x.abs()))
}

/// The bodies of a pair after some steps.
pub fn after(drawn: &Drawn, steps: usize) -> (Body, Body) {
    let moved = |b: &Body| {
        let mut b = *b;
        if steps > 0 {
            let time = TIME_STEP * steps as f64;
            for (x, v) in b.position.iter_mut().zip(b.velocity) {
                *x += v * time;
            }
            let length = largest(&b.quaternion);
            let turn = Rotation::from_scaled_axis(Vector::from(b.angular_velocity) * time)
                * rotation(b.quaternion.map(|q| q / length));
            b.quaternion = quaternion(turn).map(|q| q * length);
        }
        b
    };
    (moved(&drawn.i), moved(&drawn.j))
}

/// The same poses with quaternions of length one, for formulas that square them.
pub fn with_unit_quaternions((i, j): &(Body, Body)) -> (Body, Body) {
    let unit = |b: &Body| {
        let length = largest(&b.quaternion);
        Body {
            quaternion: quaternion(rotation(b.quaternion.map(|q| q / length))),
            ..*b
        }
    };
    (unit(i), unit(j))
}

/// What rounding may do to a penetration.
pub fn slack(i: &Body, j: &Body, penetration: f64) -> f64 {
    RESOLUTION * penetration + 64.0 * f64::EPSILON * size(i, j)
}

/// One contact alone, over the steps up to this one, with bodies that are changed before each.
fn alone(
    laws: &Laws,
    drawn: &Drawn,
    last: usize,
    mut change: impl FnMut(&mut Body, &mut Body),
) -> Given {
    alone_with_terms(laws, drawn, last, &mut change).0
}

/// The same, and the size of the terms of which its force is the sum.
fn alone_with_terms(
    laws: &Laws,
    drawn: &Drawn,
    last: usize,
    change: &mut dyn FnMut(&mut Body, &mut Body),
) -> (Given, f64) {
    let (mut touching, mut history) = (false, vec![0.0; laws.layout().length]);
    let (mut loads, mut terms) = ([[0.0; 3]; 4], 0.0);
    for step in 0..=last {
        let (mut i, mut j) = after(drawn, step);
        change(&mut i, &mut j);
        let [i, j] = [i, j].map(|b| prepare_body(&b, Some(1)).expect("within the ranges"));
        let found = one_contact(laws, &i, &j, &STEP, &mut touching, &mut history)
            .expect("exact factors do not break");
        // Stiffness times penetration, and the elastic force: Ting's receding contact takes most of that, and its stiffness is that of the
        // area that is left.
        terms = (found.as_ref()).map_or(0.0, |(contact, f)| {
            let elastic = 2.5 * f.elastic_energy / contact.penetration;
            elastic.max(f.stiffness * contact.penetration)
        });
        loads = found.map_or([[0.0; 3]; 4], |(_, f)| {
            [-f.force, f.force, f.torque_i, f.torque_j].map(|v| v.to_array())
        });
    }
    if !touching {
        history.clear();
    }
    let given = Given {
        touching,
        loads,
        history,
    };
    (given, terms)
}

const STEP: Step = Step {
    time_step: TIME_STEP,
    advance_history: true,
};

/// By how much each kind of number changes when the last places of the pair's numbers do, the largest of so many times.
pub struct Rounding<'a> {
    laws: &'a Laws,
    drawn: &'a Drawn,
    last: usize,
    base: Given,
    stream: Stream,
    times: usize,
    most: [f64; 6],
}

impl<'a> Rounding<'a> {
    pub fn new(laws: &'a Laws, drawn: &'a Drawn, last: usize) -> Self {
        Rounding {
            laws,
            drawn,
            last,
            base: alone(laws, drawn, last, |_, _| ()),
            stream: Stream::new(7),
            times: 0,
            most: [0.0; 6],
        }
    }

    /// Of so many times, those of earlier calls among them; for a change of one unit in the last place.
    pub fn of(&mut self, times: usize) -> [f64; 6] {
        while self.times < times {
            self.times += 1;
            let stream = &mut self.stream;
            let changed = alone(self.laws, self.drawn, self.last, |i, j| {
                change_last_places(stream, i, j);
            });
            for (m, d) in self.most.iter_mut().zip(changed.differences(&self.base)) {
                *m = m.max(d / UNITS);
            }
            if changed.touching != self.base.touching {
                // Whether they touched before is rounding, and with it all that is remembered but the normal.
                self.most[4..].fill(f64::INFINITY);
            }
        }
        self.most
    }
}

/// Each number by up to [`UNITS`] units in the last place, in each step anew, as an engine rounds them.
fn change_last_places(stream: &mut Stream, i: &mut Body, j: &mut Body) {
    let reach = size(i, j);
    for body in [i, j] {
        let mut some = || UNITS * f64::EPSILON * stream.uniform(-1.0, 1.0);
        let length = largest(&body.quaternion);
        for numbers in [
            &mut body.semi_axes,
            &mut body.velocity,
            &mut body.angular_velocity,
        ] {
            for x in numbers {
                *x *= 1.0 + some();
            }
        }
        for q in &mut body.quaternion {
            *q += length * some();
        }
        for x in &mut body.position {
            *x += reach * some();
        }
    }
}

impl Block {
    pub fn draw(name: Name) -> Block {
        let mut stream = name.stream();
        let deck = deck(&mut stream);
        let revolution = stream.uniform(0.0, 1.0) < 0.4;
        let pairs = (0..PAIRS)
            .map(|_| {
                let mut drawn = name.family.draw(&mut stream, revolution);
                set_in_motion(&mut stream, &mut drawn);
                drawn
            })
            .collect();
        Block {
            name,
            deck,
            pairs,
            descents_every: DESCENTS_EVERY,
        }
    }

    /// Adds to the counts of its family.
    pub fn run(&self, counts: &mut Counts) {
        let laws = laws(&[&self.deck]);
        let sets: Vec<InstructionSet> = instruction_sets().collect();
        assert_eq!(sets[0], InstructionSet::Scalar);
        let mut lists: Vec<PairList> = sets
            .iter()
            .map(|set| PairList::new(&laws, *set, PAIRS))
            .collect();
        counts.pairs += PAIRS as u64;
        // Whether two paths took different ones of equal minima: what they remember differs from then on.
        let mut parted = [false; PAIRS];
        for step in 0..STEPS {
            let now: Vec<(Body, Body)> = self.pairs.iter().map(|d| after(d, step)).collect();
            for (set, list) in sets.iter().zip(&mut lists) {
                if let Err(words) = list.advance(&now, &STEP) {
                    let words = format!("{}: {words}", set.name());
                    counts.found(self.finding(Kind::Refused, 0, step, words, f64::MAX));
                    return;
                }
            }
            for pair in 0..PAIRS {
                let given: Vec<Given> = lists.iter().map(|l| Given::of(l, pair)).collect();
                parted[pair] |= self.judge(
                    counts,
                    &laws,
                    &sets,
                    &given,
                    &now[pair],
                    (pair, step, parted[pair]),
                );
                if step == 0 && self.turn(pair, TIMED_EVERY) {
                    self.time_search(counts, pair, &now[pair]);
                }
            }
        }
    }

    /// Whether it is the turn of this one, of so many: another one in each block.
    fn turn(&self, number: usize, of: usize) -> bool {
        (number + 97 * self.name.number as usize).is_multiple_of(of)
    }

    fn finding(
        &self,
        kind: Kind,
        pair: usize,
        step: usize,
        words: String,
        severity: f64,
    ) -> Finding {
        Finding {
            kind,
            block: self.name.number,
            pair,
            step,
            deck: self.deck.clone(),
            words,
            severity,
        }
    }

    /// Whether two paths took different ones of equal minima.
    fn judge(
        &self,
        counts: &mut Counts,
        laws: &Laws,
        sets: &[InstructionSet],
        given: &[Given],
        now: &(Body, Body),
        (pair, step, parted): (usize, usize, bool),
    ) -> bool {
        let scalar = &given[0];
        counts.touching += u64::from(scalar.touching);
        let finding = |kind, words, severity| self.finding(kind, pair, step, words, severity);
        for (set, given) in sets.iter().zip(given) {
            if !given.is_finite() {
                let words = format!("{}: {given:?}", set.name());
                counts.found(finding(Kind::NotFinite, words, f64::MAX));
                return false;
            }
        }
        // Penetrations by the normals that were found, by a formula of the test's own.
        let unit = with_unit_quaternions(now);
        let (i, j) = &unit;
        let depths: Vec<f64> = given
            .iter()
            .map(|g| {
                if g.touching {
                    overlap(i, j, &g.normal())
                } else {
                    0.0
                }
            })
            .collect();
        let mut least = depths.iter().fold(f64::INFINITY, |a, b| a.min(*b));
        if self.turn(STEPS * pair + step, self.descents_every) {
            counts.by_brute_force += 1;
            least = least.min(deepest(i, j, 100).0).max(0.0);
        }
        for (set, depth) in sets.iter().zip(&depths) {
            let excess = (depth - least) / slack(i, j, least);
            if excess > 1.0 {
                let words = format!("{}: penetration {depth:e}, not {least:e}", set.name());
                counts.found(finding(Kind::NotTheLeast, words, excess));
                return false;
            }
        }
        if parted {
            return true;
        }
        let mut severity: f64 = 0.0;
        let (mut rounding, mut at_rounding) = (None::<Rounding>, false);
        for (set, other) in sets.iter().zip(given).skip(1) {
            if scalar.touching != other.touching {
                // By less than rounding of the bodies' size, as was seen above.
                at_rounding = true;
                continue;
            }
            let differences = other.differences(scalar);
            let mut sizes = scalar.sizes(size(i, j));
            let no_difference = NO_DIFFERENCE + CURVATURE * most_slender(i, j);
            let of_depth =
                ROUNDINGS * f64::EPSILON * size(i, j) / depths[0].max(f64::EPSILON * size(i, j));
            let none = |k: usize, sizes: &[f64; 6]| {
                let relative = no_difference + if k < 3 { of_depth } else { 0.0 };
                differences[k] <= relative * sizes[k] + ZERO
            };
            if (0..6).all(|k| none(k, &sizes)) {
                continue;
            }
            // A force that damping takes to nearly nothing is as exact as the terms that make it up.
            let (_, terms) = alone_with_terms(laws, &self.pairs[pair], step, &mut |_, _| ());
            for (size_of_kind, lever) in sizes.iter_mut().zip([1.0, 1.0, size(i, j)]) {
                *size_of_kind = size_of_kind.max(terms * lever);
            }
            if (0..6).all(|k| none(k, &sizes)) {
                continue;
            }
            let mut worst = |times: usize| {
                let rounding = rounding
                    .get_or_insert_with(|| Rounding::new(laws, &self.pairs[pair], step))
                    .of(times);
                (0..6)
                    .filter(|k| differences[*k] > 0.0)
                    .map(|k| {
                        (
                            k,
                            differences[k]
                                / (ALLOWED * rounding[k] + no_difference * sizes[k] + ZERO),
                        )
                    })
                    .max_by(|a, b| a.1.total_cmp(&b.1))
                    .expect("some kind differs")
            };
            let (few, enough) = CHANGED_FIRST;
            let (mut kind, mut ratio) = worst(few);
            if ratio > enough {
                (kind, ratio) = worst(CHANGED);
            }
            for times in CHANGED_OFTEN {
                if ratio > 1.0 {
                    (kind, ratio) = worst(times);
                }
            }
            let apart = scalar.touching && (other.normal() - scalar.normal()).norm() > 1e-6;
            if apart {
                // The penetrations are equal, as was seen above: other minima of the same depth, or a flat one.
                counts.equal_minima += 1;
                return true;
            }
            severity = severity.max(ratio);
            if ratio <= 1.0 {
                continue;
            }
            let of = [
                "force on i",
                "force on j",
                "torques",
                "normal",
                "memory",
                "energy",
            ][kind];
            let words = format!(
                "{}: {of} differs by {:e} of {:e}, {ratio:.1} times what rounding explains; penetration {:e}",
                set.name(),
                differences[kind],
                sizes[kind],
                depths[0]
            );
            counts.found(finding(Kind::Differs, words, ratio.min(f64::MAX)));
            return false;
        }
        counts.at_rounding += u64::from(at_rounding || rounding.is_some());
        if scalar.touching {
            let sampled = Sampled {
                block: self.name.number,
                pair,
                step,
                weight: severity,
            };
            counts.sample(sampled, self.name.lot(pair));
        }
        false
    }

    /// How long the longest search from nothing takes, and whether it ended at an isolated minimum.
    fn time_search(&self, counts: &mut Counts, pair: usize, (i, j): &(Body, Body)) {
        let [i, j] = [i, j].map(|b| prepare_body(b, None).expect("within the ranges"));
        let d = j.position - i.position;
        let once = || {
            let started = Instant::now();
            let outcome = black_box(search(&i.body, &j.body, black_box(d), None));
            (started.elapsed().as_nanos() as u64, outcome)
        };
        let (mut time, outcome) = once();
        if let Outcome::Touching(found) = outcome {
            if !found.converged {
                counts.not_isolated += 1;
            }
        }
        if time > counts.slowest_nanoseconds {
            // Another program may have had the processor: the shortest of some.
            for _ in 0..5 {
                time = time.min(once().0);
            }
            if time > counts.slowest_nanoseconds {
                counts.slowest_nanoseconds = time;
                counts.slowest = [self.name.number, pair as u64];
            }
        }
    }
}

impl Name {
    /// A number for one pair of the block, by which a sample is drawn.
    fn lot(self, pair: usize) -> u64 {
        let mut stream = Stream::new(self.number.wrapping_mul(1021) + pair as u64);
        (stream.uniform(0.0, 1.0) * 1e15) as u64
    }
}
