// SPDX-License-Identifier: MIT OR Apache-2.0
//! The search of `support_newton` in the lanes of an instruction set: so many steps from the last normal, without a question
//! asked in between. The bodies lie in the order of the registers already.

use std::hint::black_box;

use ellgran::geometry::Ellipsoid;
use ellgran::simd::InstructionSet;
use ellgran::simd::Lanes;
use ellgran::simd::Stage;
use ellgran::simd::{Registers, MOST_LANES};
use ellgran::vector::Vector3;

use crate::contact_search::{Finding, Pair};
use crate::support_newton::{overlap, step};
use crate::timing::{nanoseconds, Nanoseconds};
use crate::Effort;

/// Numbers of a pair: axes, semi-axes and their inverses of both bodies, `d`, and the start.
const COLUMNS: usize = 36;

/// One number of all lanes.
type Numbers = [f64; MOST_LANES];
type Block = [Numbers; COLUMNS];

fn blocks(pairs: &[(Pair, Vector3)], lanes: usize) -> Vec<Block> {
    pairs
        .chunks_exact(lanes)
        .map(|chunk| {
            let mut block = [[1.0; MOST_LANES]; COLUMNS];
            for (lane, (pair, start)) in chunk.iter().enumerate() {
                let vectors = [pair.i, pair.j]
                    .into_iter()
                    .flat_map(|b| {
                        [
                            b.axes[0],
                            b.axes[1],
                            b.axes[2],
                            b.semi_axes,
                            b.inverse_semi_axes,
                        ]
                    })
                    .chain([pair.d, *start]);
                for (at, number) in vectors.flat_map(|v| v.to_array()).enumerate() {
                    block[at][lane] = number;
                }
            }
            block
        })
        .collect()
}

struct Search<'a> {
    blocks: &'a [Block],
    steps: usize,
    found: &'a mut [[Numbers; 4]],
}

impl Stage for Search<'_> {
    #[inline(always)]
    fn run<S: Registers>(self, registers: S) {
        for (block, found) in self.blocks.iter().zip(self.found) {
            macro_rules! vector {
                ($at:expr) => {
                    Vector3::new(
                        Lanes::load(registers, &block[$at]),
                        Lanes::load(registers, &block[$at + 1]),
                        Lanes::load(registers, &block[$at + 2]),
                    )
                };
            }
            macro_rules! body {
                ($at:expr) => {
                    Ellipsoid {
                        axes: [vector!($at), vector!($at + 3), vector!($at + 6)],
                        semi_axes: vector!($at + 9),
                        inverse_semi_axes: vector!($at + 12),
                    }
                };
            }
            let (i, j, d) = (body!(0), body!(15), vector!(30));
            let mut n = vector!(33);
            for _ in 0..self.steps {
                n = step(&i, &j, d, n).1;
            }
            n.x.store(&mut found[0]);
            n.y.store(&mut found[1]);
            n.z.store(&mut found[2]);
            overlap(&i, &j, d, n).store(&mut found[3]);
        }
    }
}

/// On each instruction set of this machine: its name, how many steps, time and findings.
pub fn each(
    effort: &Effort,
    pairs: &[(Pair, Vector3)],
    mut take: impl FnMut(&'static str, usize, Nanoseconds, Vec<Finding>),
) {
    for steps in 1..=3 {
        for (set, name) in [
            (InstructionSet::Avx2, "support avx2"),
            (InstructionSet::Avx512, "support avx512"),
        ] {
            if set.is_available() {
                let lanes = set.lanes();
                let (time, found) = one(effort, pairs, lanes, steps, |work| set.run(work));
                take(name, steps, time, found);
            }
        }
    }
}

fn one(
    effort: &Effort,
    pairs: &[(Pair, Vector3)],
    lanes: usize,
    steps: usize,
    run: impl Fn(Search),
) -> (Nanoseconds, Vec<Finding>) {
    let blocks = blocks(pairs, lanes);
    let mut found = vec![[[0.0; MOST_LANES]; 4]; blocks.len()];
    let time = nanoseconds(effort, blocks.len() * lanes, || {
        run(Search {
            blocks: black_box(&blocks),
            steps,
            found: &mut found,
        });
        black_box(&mut found);
    });
    let findings = found
        .iter()
        .flat_map(|block| {
            (0..lanes).map(|lane| {
                let n = Vector3::new(block[0][lane], block[1][lane], block[2][lane]);
                Some((n, block[3][lane]))
            })
        })
        .collect();
    (time, findings)
}
