// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does the search agree with the contact function of Perram and Wertheim on what touches? No missed and no false contact.

use crate::support::perram_wertheim::contact_function;
use crate::support::random::Stream;
use crate::support::scene::{advance, body, laws, Memory, Rotation, Vector};
use ellgran::pairs::{Body, Laws};

/// Outside this band around 1 the contact function in double precision is sure.
fn band(i: &Body, j: &Body) -> f64 {
    let ratio = |b: &Body| {
        let a = b.semi_axes;
        let largest = a.into_iter().fold(0.0, f64::max);
        let smallest = a.into_iter().fold(f64::INFINITY, f64::min);
        largest / smallest
    };
    16.0 * f64::EPSILON * ratio(i).max(ratio(j)).powi(2)
}

#[derive(Default, Debug)]
struct Count {
    touching: usize,
    separated: usize,
    unsure: usize,
}

impl Count {
    fn check(&mut self, laws: &Laws, i: &Body, j: &Body) {
        let wanted = contact_function(i, j);
        let mut memory = Memory::new(laws);
        let cold = advance(laws, i, j, 0.0, &mut memory).is_some();
        let warm = advance(laws, i, j, 0.0, &mut memory).is_some();
        if (wanted - 1.0).abs() <= band(i, j) {
            self.unsure += 1;
            return;
        }
        let touching = wanted < 1.0;
        assert!(
            cold == touching && warm == touching,
            "contact function {wanted}, cold {cold}, warm {warm}: {i:?} {j:?}"
        );
        if touching {
            self.touching += 1;
        } else {
            self.separated += 1;
        }
    }
    fn show(&self, name: &str) {
        println!("{name}: {self:?}");
        assert!(
            self.touching > 10 && self.separated > 10,
            "{name}: {self:?}"
        );
        assert_eq!(self.unsure, 0, "{name}");
    }
}

/// The law does not matter.
fn elastic() -> Laws {
    laws(&["hertz 1e6 0.3"])
}

/// Scales the distance so that the contact function is `wanted`: it grows as the square of the distance.
fn at(mut j: Body, i: &Body, wanted: f64) -> Body {
    let now = contact_function(i, &j);
    let factor = (wanted / now).sqrt();
    j.position = j.position.map(|x| x * factor);
    j
}

/// Contact function values on both sides of 1, from far to a hair.
const MARGINS: [f64; 11] = [
    0.5, 0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10, 1e-11, 1e-12,
];

/// At every margin that double precision can tell.
fn around(count: &mut Count, laws: &Laws, i: &Body, j: Body) {
    for margin in MARGINS.into_iter().filter(|m| *m > 2.0 * band(i, &j)) {
        for sign in [-1.0, 1.0] {
            count.check(laws, i, &at(j, i, 1.0 + sign * margin));
        }
    }
}

#[test]
fn random_pairs_of_aspect_ratio_up_to_100() {
    let laws = elastic();
    let mut stream = Stream::new(11);
    for aspect in [2.0, 10.0, 100.0] {
        let mut count = Count::default();
        for _ in 0..600 {
            let i = body(stream.semi_axes(aspect), Vector::zeros(), stream.rotation());
            let j = body(
                stream.semi_axes(aspect),
                stream.direction(),
                stream.rotation(),
            );
            around(&mut count, &laws, &i, j);
        }
        count.show(&format!("random, aspect ratio up to {aspect}"));
    }
}

#[test]
fn parallel_needles_side_by_side_end_to_end_and_shifted() {
    let laws = elastic();
    let mut stream = Stream::new(12);
    for aspect in [2.0, 10.0, 100.0] {
        for (name, direction) in [
            ("end to end", Vector::new(1.0, 0.0, 0.0)),
            ("side by side", Vector::new(0.0, 1.0, 0.0)),
            ("shifted along", Vector::new(0.7, 1.0 / aspect, 0.0)),
            (
                "half overlapping",
                Vector::new(1.0, 2.0 / aspect, 1.0 / aspect),
            ),
        ] {
            let mut count = Count::default();
            for k in 0..12 {
                // Exactly along the axes first, then turned as one.
                let turn = if k == 0 {
                    Rotation::identity()
                } else {
                    stream.rotation()
                };
                let a = [1.0, 1.0 / aspect, 1.0 / aspect];
                let i = body(a, Vector::zeros(), turn);
                let j = body(a, turn * direction, turn);
                around(&mut count, &laws, &i, j);
            }
            count.show(&format!("parallel needles {name}, aspect ratio {aspect}"));
        }
    }
}

#[test]
fn crossed_needles() {
    let laws = elastic();
    let mut stream = Stream::new(13);
    for aspect in [2.0, 10.0, 100.0] {
        let mut count = Count::default();
        for k in 0..40 {
            let a = [1.0, 1.0 / aspect, 1.0 / aspect];
            let turn = if k == 0 {
                Rotation::identity()
            } else {
                stream.rotation()
            };
            // Crossed at any angle, k = 0 and 1 at a right one, over any place of each.
            let angle = if k < 2 {
                std::f64::consts::FRAC_PI_2
            } else {
                stream.uniform(0.01, 1.57)
            };
            let cross = Rotation::from_axis_angle(&Vector::z_axis(), angle);
            let along = if k < 2 {
                [0.0, 0.0]
            } else {
                [stream.uniform(-0.6, 0.6), stream.uniform(-0.6, 0.6)]
            };
            let d = Vector::new(along[0], 0.0, 0.0)
                + cross * Vector::new(along[1], 0.0, 0.0)
                + Vector::new(0.0, 0.0, 2.0 / aspect);
            let i = body(a, Vector::zeros(), turn);
            let j = body(a, turn * d, turn * cross);
            around(&mut count, &laws, &i, j);
        }
        count.show(&format!("crossed needles, aspect ratio {aspect}"));
    }
}

#[test]
fn sizes_1_to_100() {
    let laws = elastic();
    let mut stream = Stream::new(14);
    for aspect in [1.0, 3.0, 30.0] {
        let mut count = Count::default();
        for _ in 0..150 {
            let i = body(stream.semi_axes(aspect), Vector::zeros(), stream.rotation());
            let small = stream.semi_axes(aspect).map(|a| 0.01 * a);
            let j = body(small, stream.direction(), stream.rotation());
            around(&mut count, &laws, &i, j);
            // And the other way round.
            let j = body(i.semi_axes, stream.direction(), rotation_of(&i));
            let i = body(small, Vector::zeros(), stream.rotation());
            around(&mut count, &laws, &i, j);
        }
        count.show(&format!("sizes 1:100, aspect ratio up to {aspect}"));
    }
}

fn rotation_of(b: &Body) -> Rotation {
    crate::support::scene::rotation(b.quaternion)
}

#[test]
fn coincident_centres_always_touch() {
    let laws = elastic();
    let mut stream = Stream::new(15);
    for aspect in [1.0, 10.0, 1000.0] {
        for _ in 0..200 {
            let i = body(stream.semi_axes(aspect), Vector::zeros(), stream.rotation());
            let j = body(stream.semi_axes(aspect), Vector::zeros(), stream.rotation());
            assert!(advance(&laws, &i, &j, 0.0, &mut Memory::new(&laws)).is_some());
        }
    }
}

#[test]
fn a_remembered_normal_from_another_place_misleads_nobody() {
    let laws = elastic();
    let mut stream = Stream::new(16);
    for _ in 0..4000 {
        let i = body(stream.semi_axes(30.0), Vector::zeros(), stream.rotation());
        let j = body(
            stream.semi_axes(30.0),
            stream.direction(),
            stream.rotation(),
        );
        let j = at(j, &i, stream.uniform(0.3, 1.7));
        let mut memory = Memory::new(&laws);
        let n = stream.direction();
        memory.history[..3].copy_from_slice(&[n.x, n.y, n.z]);
        let found = advance(&laws, &i, &j, 0.0, &mut memory).is_some();
        assert_eq!(found, contact_function(&i, &j) < 1.0);
    }
}
