// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does the search agree with the contact function of Perram and Wertheim on what touches? No missed and no false contact.

use crate::support::perram_wertheim::contact_function;
use crate::support::random::Stream;
use crate::support::scene::{advance, body, laws, Memory, Rotation, Vector};
use ellgran::contact::one_contact::{self, one_contact_or_gap};
use ellgran::contact::prepare_body;
use ellgran::contact::Particle;
use ellgran::contact::{Body, Laws, Step};
use ellgran::geometry::contact_search::gap;
use ellgran::geometry::{search, Outcome};

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

/// Thin discs and needles beside each other, where a search has many minima, and grains of any shape.
fn long_and_flat(stream: &mut Stream, kind: usize) -> [Body; 2] {
    let mut shape = |kind: usize| {
        let thin = stream.log_uniform(1e-3, 0.3);
        match kind {
            0 => [1.0, 1.0, thin],
            1 => [1.0, thin, thin],
            _ => [1.0, stream.log_uniform(thin, 1.0), thin],
        }
    };
    let shapes = [shape(kind % 3), shape(kind / 3 % 3)];
    let turn = stream.rotation();
    // Half of the pairs are nearly aligned.
    let other = if kind.is_multiple_of(2) {
        let axis = nalgebra::Unit::new_normalize(stream.direction());
        turn * Rotation::from_axis_angle(&axis, stream.log_uniform(1e-6, 0.1))
    } else {
        stream.rotation()
    };
    [
        body(shapes[0], Vector::zeros(), turn),
        body(shapes[1], stream.direction(), other),
    ]
}

/// Pairs that barely touch or barely do not: the flag, the geometry that comes with it, and the geometry that is asked for
/// alone say the same of each pair, with a remembered normal and without one.
#[test]
fn flag_and_geometry_agree() {
    let laws = elastic();
    let step = Step {
        time_step: 0.0,
        advance_history: false,
    };
    let mut stream = Stream::new(17);
    let (mut touching, mut apart) = (0, 0);
    for k in 0..20_000 {
        let [i, j] = long_and_flat(&mut stream, k % 9);
        // Closer to touching than a search from the wrong start can tell, on both sides.
        let margin = stream.log_uniform(1e-15, 1e-3) * if k % 4 == 0 { -1.0 } else { 1.0 };
        let j = at(j, &i, 1.0 + margin);
        let mut further = j;
        further.position = j.position.map(|x| 1.01 * x);
        let (i, j, further) = (particle(&i), particle(&j), particle(&further));
        // The normal of the step before, when they were further apart; and none.
        let before = one_contact::geometry(&i, &further, 0.5, None).normal;
        for start in [None, Some(before)] {
            let (mut flag, mut history) = (false, [0.0; 3]);
            if let Some(n) = start {
                history = n.to_array();
            }
            let (found, forces) =
                one_contact_or_gap(&laws, &i, &j, &step, &mut flag, &mut history).unwrap();
            let case = || format!("{k} {margin:e} {i:?} {j:?}");
            assert_eq!(forces.is_some(), flag, "{}", case());
            assert_eq!(found.touching, flag, "{}", case());
            assert_eq!(found.penetration > 0.0, flag, "{}", case());
            let alone = one_contact::geometry(&i, &j, 0.5, start);
            assert_eq!(alone.touching, flag, "{}", case());
            assert_eq!(alone.penetration, found.penetration, "{}", case());
            if flag {
                touching += 1;
            } else {
                apart += 1;
                // No plane separates them by more than the gap: not that of before either.
                let n = before;
                let d = j.position - i.position;
                let width = n.dot(d) - i.body.support(n).h - j.body.support(n).h;
                assert!(-found.penetration >= width - 1e-15, "{} {width:e}", case());
            }
        }
    }
    println!("{touching} touching, {apart} apart");
    assert!(touching > 5000 && apart > 5000);
}

/// A start from which a descent ends in a minimum that is not the gap: the certificate of the search leads to it.
#[test]
fn a_plane_between_the_bodies_leads_to_the_gap() {
    let mut stream = Stream::new(18);
    let mut misled = 0;
    for k in 0..6000 {
        let [i, j] = long_and_flat(&mut stream, k % 9);
        let j = at(j, &i, 1.0 + stream.log_uniform(1e-12, 1e-2));
        let wanted = one_contact::geometry(&particle(&i), &particle(&j), 0.5, None);
        if wanted.touching {
            continue;
        }
        let (i, j) = (particle(&i), particle(&j));
        let d = j.position - i.position;
        // Another plane between them, found from any start: the same gap.
        for _ in 0..3 {
            let start = crate::support::scene::plain(stream.direction());
            match search(&i.body, &j.body, d, Some(start)) {
                Outcome::Separated(n) => {
                    let found = gap(&i.body, &j.body, d, n);
                    let error = (found.penetration - wanted.penetration).abs();
                    assert!(error < 1e-14, "{error:e}");
                }
                Outcome::Touching(_) => misled += 1,
            }
        }
    }
    // What the gap must not be looked for from.
    println!("{misled} descents from any start ended where the bodies seem to touch");
}

fn particle(b: &Body) -> Particle {
    prepare_body(b, Some(1)).unwrap()
}
