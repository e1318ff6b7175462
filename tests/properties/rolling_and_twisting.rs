// SPDX-License-Identifier: MIT OR Apache-2.0
//! What resists rolling and twisting: a couple without a force, that never gives more energy than it took.

use crate::support::random::Stream;
use crate::support::scene::{advance, body, force_scale, laws, size, Memory, Rotation, Vector};
use crate::support::strategies::{touching_pair, TouchingPair};
use ellgran::contact::Body;
use proptest::prelude::*;

const RESISTANCES: [&str; 4] = [
    "rolling sds 1e3 0.5 0.1",
    "twisting sds 10 0.01 0.05",
    "rolling sds 1e3 0 0.1 twisting marshall",
    "rolling sds 0 2 0.3 twisting sds 0 0.1 0.2",
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Forces stay as they are, and the torques on the two bodies are opposite: linear and angular momentum are kept.
    #[test]
    fn it_is_a_couple(
        pair in touching_pair(10.0, 1e-4..0.3),
        which in 0..RESISTANCES.len(),
        time_step in 1e-7..1e-3f64,
    ) {
        let normal = "hertz 1e5 0.3 tangential mindlin 0.4";
        let with = laws(&[&format!("{normal} {}", RESISTANCES[which])]);
        let without = laws(&[normal]);
        let (mut memory, mut other) = (Memory::new(&with), Memory::new(&without));
        for _ in 0..3 {
            let a = advance(&with, &pair.i, &pair.j, time_step, &mut memory).expect("touching");
            let b = advance(&without, &pair.i, &pair.j, time_step, &mut other).expect("touching");
            prop_assert_eq!(a.force, b.force);
            let (on_i, on_j) = (a.torque_i - b.torque_i, a.torque_j - b.torque_j);
            let scale = force_scale(&a) * size(&pair.i, &pair.j) + on_i.norm();
            prop_assert!((on_i + on_j).norm() <= 4.0 * f64::EPSILON * scale);
            let relative = Vector::from(pair.i.angular_velocity) - Vector::from(pair.j.angular_velocity);
            // Nothing is held yet that could drive the motion.
            prop_assert!(on_i.dot(&relative) <= 4.0 * f64::EPSILON * scale * relative.norm());
        }
    }

    /// A pair that flies and turns as one rigid body neither rolls nor twists.
    #[test]
    fn rigid_motion_rolls_and_twists_nowhere(
        pair in touching_pair(10.0, 1e-3..0.3),
        which in 0..RESISTANCES.len(),
        spin in crate::support::strategies::vector(1.0),
    ) {
        let laws = laws(&[&format!("hertz 1e5 0.3 tangential mindlin 0.4 {}", RESISTANCES[which])]);
        let layout = laws.layout();
        let mut memory = Memory::new(&laws);
        let rigid = |b: &Body| Body {
            velocity: spin.cross(&Vector::from(b.position)).into(),
            angular_velocity: spin.into(),
            ..*b
        };
        advance(&laws, &rigid(&pair.i), &rigid(&pair.j), 1e-3, &mut memory).expect("touching");
        for at in [layout.rolling, layout.twisting].into_iter().flatten() {
            prop_assert_eq!(&memory.history[at..at + 2], &[0.0; 2][..]);
        }
    }
}

/// Bodies that are held and turned at random while they are pressed together more and less: the work of the couple is never less than
/// what it stores. The step errs in proportion to itself; three steps show that nothing else is left.
#[test]
fn random_turns_under_a_changing_load_take_work() {
    let lost = |words: &str, sphere: bool, steps: usize| {
        let mut stream = Stream::new(93);
        let mut worst: f64 = f64::INFINITY;
        for _ in 0..20 {
            let laws = laws(&[&format!("hertz 1e5 0.3 tangential mindlin 0.5 {words}")]);
            let none = crate::support::scene::laws(&["hertz 1e5 0.3 tangential mindlin 0.5"]);
            let shape = if sphere {
                [1.0; 3]
            } else {
                stream.semi_axes(3.0)
            };
            let n = stream.direction();
            let pair = TouchingPair::new(
                [shape, shape],
                [stream.rotation(), stream.rotation()],
                n,
                0.02,
            );
            // Sums of three frequencies.
            let waves: Vec<[f64; 4]> = (0..12)
                .map(|_| [0; 4].map(|_| stream.uniform(-1.0, 1.0)))
                .collect();
            let wave = |k: usize, t: f64| -> f64 {
                (0..3)
                    .map(|m| {
                        let [a, b, c, d] = waves[3 * k + m];
                        a * (t * (2.0 + 6.0 * b.abs()) + 3.0 * c).sin() * (1.0 + d)
                    })
                    .sum()
            };
            let dt = 1.0 / steps as f64;
            let (mut memory, mut other) = (Memory::new(&laws), Memory::new(&none));
            let (mut work, mut taken) = (0.0, 0.0);
            let mut before: Option<Vector> = None;
            let mut least = f64::INFINITY;
            let energy = |f: &ellgran::contact::ContactForces| f.tangential_energy;
            for k in 0..(3 * steps) {
                let t = k as f64 * dt;
                let spin = Vector::new(
                    wave(0, t - 0.5 * dt),
                    wave(1, t - 0.5 * dt),
                    wave(2, t - 0.5 * dt),
                ) * 0.3;
                let (mut i, mut j) = (pair.i, pair.j);
                i.velocity = [0.0; 3];
                j.velocity = [0.0; 3];
                i.angular_velocity = spin.into();
                j.angular_velocity = [0.0; 3];
                let nearer = 0.4 * pair.penetration * wave(3, t).tanh();
                j.position = (Vector::from(j.position) - n * nearer).into();
                let f = advance(&laws, &i, &j, dt, &mut memory).expect("touching");
                let g = advance(&none, &i, &j, dt, &mut other).expect("touching");
                let torque = f.torque_i - g.torque_i;
                let held = energy(&f.forces) - energy(&g.forces);
                if let Some(before) = before {
                    let power = -0.5 * (torque + before).dot(&spin) * dt;
                    work += power;
                    taken += power.abs();
                }
                before = Some(torque);
                least = least.min(work - held);
            }
            worst = worst.min(least / taken);
        }
        worst
    };
    for words in RESISTANCES {
        for sphere in [true, false] {
            let [coarse, fine] = [400, 1600].map(|steps| lost(words, sphere, steps));
            println!("{words}, sphere {sphere}: least of work less energy held, over the work done and undone: {coarse:.1e} at 400 steps, {fine:.1e} at 1600");
            assert!(
                fine > -1e-3 && fine > 0.5 * coarse - 1e-5,
                "{words}: {coarse:e} {fine:e}"
            );
        }
    }
}

/// `marshall`: loaded deep and turned, unloaded to a quarter and turned back at that depth: what comes back is less.
#[test]
fn a_cycle_of_load_and_twist_gives_no_energy() {
    let laws = laws(&["hertz 1e6 0.3 tangential mindlin 100 twisting marshall"]);
    let i = body([1.0; 3], Vector::zeros(), Rotation::identity());
    let mut work = 0.0;
    let mut loaded = 0.0;
    for (deep, shallow) in [(0.01, 0.0025), (0.0025, 0.01)] {
        let mut memory = Memory::new(&laws);
        let steps = 500;
        let dt = 1.0 / steps as f64;
        let mut cycle = 0.0;
        for (part, from, to, turn) in [
            (0, deep, deep, 1e-3),
            (1, deep, shallow, 0.0),
            (2, shallow, shallow, -1e-3),
        ] {
            for k in 1..=steps {
                let depth = from + (to - from) * k as f64 * dt;
                let mut j = body(
                    [1.0; 3],
                    Vector::new(2.0 - depth, 0.0, 0.0),
                    Rotation::identity(),
                );
                j.velocity = [-(to - from), 0.0, 0.0];
                j.angular_velocity = [turn, 0.0, 0.0];
                let f = advance(&laws, &i, &j, dt, &mut memory).expect("touching");
                let power = -f.torque_j.x * turn * dt;
                cycle += power;
                if part == 0 {
                    loaded += power;
                }
            }
        }
        println!("from {deep} to {shallow}: work {cycle:e}");
        work = f64::min(work, cycle);
    }
    assert!(loaded > 0.0);
    // The forces at the ends of the steps err by a step.
    assert!(work > -1e-2 * loaded, "{work:e} of {loaded:e}");
}
