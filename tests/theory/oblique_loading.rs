// SPDX-License-Identifier: MIT OR Apache-2.0
//! A contact that is pressed and sheared at once, with velocities of the step: which tangential force has it after one step or many? The
//! stiffness goes with the root of the penetration, so that the force is an integral with a closed form (docs/theory.md, section 8).

use crate::support::scene::{advance_at_step, body, laws, Memory, Rotation, Vector};
use ellgran::contact::{Body, Laws, MotionChange};

const MODULUS: f64 = 1e7;
const NU: f64 = 0.3;
/// Of the deepest contact. The normal turns by half of the displacement, which is so small that this makes 1e-6 of it.
const DEPTH: f64 = 1e-6;
/// Nothing slips at a coefficient of friction of 1e6.
const WAY: f64 = 1e-3 * DEPTH;

/// Two unit spheres without slip: `4 G a/(2 - nu)`, `a` the radius of the contact.
fn stiffness(depth: f64) -> f64 {
    let shear_modulus = MODULUS / (2.0 * (1.0 + NU));
    4.0 * shear_modulus * (0.5 * depth).sqrt() / (2.0 - NU)
}

/// From one penetration to another along a straight way in equal steps, sheared by `WAY` meanwhile.
fn sheared(laws: &Laws, (from, to): (f64, f64), steps: usize) -> f64 {
    let mut memory = Memory::new(laws);
    let at = |depth: f64, across: f64| -> [Body; 2] {
        let i = body([1.0; 3], Vector::zeros(), Rotation::identity());
        let j = Vector::new(2.0 - depth, across, 0.0);
        [i, body([1.0; 3], j, Rotation::identity())]
    };
    let mut advance = |[i, j]: [Body; 2]| {
        let steady = Some(MotionChange::NONE);
        let time_step = 1.0;
        advance_at_step(laws, (&i, steady), (&j, steady), time_step, &mut memory)
    };
    if from > 0.0 {
        advance(at(from, 0.0));
    }
    let mut force = 0.0;
    for k in 1..=steps {
        let part = k as f64 / steps as f64;
        let depth = from + (to - from) * part;
        let [i, mut j] = at(depth, WAY * part);
        j.velocity = [(from - to) / steps as f64, WAY / steps as f64, 0.0];
        force = advance([i, j]).map_or(0.0, |felt| -felt.tangential.y);
    }
    force
}

/// The mean of the root of the penetration along the way, over its root at the end.
fn mean_root(from: f64, to: f64) -> f64 {
    let from = from.max(0.0);
    2.0 / 3.0 * (to.powf(1.5) - from.powf(1.5)) / ((to - from) * to.sqrt())
}

fn check(words: &str, ways: &[(f64, f64)], wanted: impl Fn(f64, f64) -> f64) {
    let laws = laws(&[&format!("hertz {MODULUS:e} {NU} tangential {words}")]);
    for &(from, to) in ways {
        for steps in [1, 2, 7] {
            let found = sheared(&laws, (from, to), steps);
            // Of the way only what lies after the first touch counts.
            let touching = ((to - from.max(0.0)) / (to - from)).min(1.0);
            let wanted = wanted(from, to) * WAY * touching;
            let error = (found / wanted - 1.0).abs();
            assert!(
                error < 1e-5,
                "{words}, {from:e} to {to:e} in {steps} steps: {found:e} {wanted:e}"
            );
        }
    }
}

/// From first touch, from within a gap, and on from a contact that is there.
const GROWING: [(f64, f64); 4] = [
    (0.0, DEPTH),
    (-0.5 * DEPTH, DEPTH),
    (0.2 * DEPTH, DEPTH),
    (0.9 * DEPTH, DEPTH),
];
const SHRINKING: [(f64, f64); 3] = [
    (DEPTH, 0.9 * DEPTH),
    (DEPTH, 0.3 * DEPTH),
    (DEPTH, 0.01 * DEPTH),
];

#[test]
fn a_force_that_is_summed_up_is_the_integral_while_the_contact_grows() {
    for words in [
        "mindlin 1e6",
        "tfd 1e6",
        "mindlin 1e6 displacement incremental",
        "tfd 1e6 displacement hysteretic",
    ] {
        check(words, &GROWING, |from, to| {
            stiffness(to) * mean_root(from, to)
        });
    }
}

#[test]
fn a_force_that_is_kept_is_the_integral_while_the_contact_shrinks() {
    let words = "mindlin 1e6 displacement incremental";
    check(words, &SHRINKING, |from, to| {
        stiffness(to) * mean_root(from, to)
    });
}

/// What shrinks with the contact is at the end what the whole displacement makes there.
#[test]
fn a_force_that_shrinks_with_the_contact_is_that_of_its_end() {
    for words in ["mindlin 1e6", "tfd 1e6", "tfd 1e6 displacement hysteretic"] {
        check(words, &SHRINKING, |_, to| stiffness(to));
    }
}

#[test]
fn a_displacement_that_is_remembered_has_the_stiffness_of_the_end() {
    let words = "mindlin 1e6 displacement total";
    for ways in [&GROWING[..], &SHRINKING] {
        check(words, ways, |_, to| stiffness(to));
    }
}

#[test]
fn a_constant_stiffness_is_its_own_mean() {
    for displacement in ["rescaled", "incremental", "total"] {
        let words = format!("linear 1e3 0 1e6 displacement {displacement}");
        for ways in [&GROWING[..], &SHRINKING] {
            check(&words, ways, |_, _| 1e3);
        }
    }
}
