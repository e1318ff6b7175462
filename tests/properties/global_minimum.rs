// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is the penetration the global minimum of `f(n)`, in a list on each instruction set and alone, from nothing and from
//! whatever normal is remembered?
//!
//! `ELLGRAN_STRESS_PAIRS` is the number of random pairs of each class (300 without it); every class prints its counts.

use crate::support::brute_force::deepest;
use crate::support::list::{instruction_sets, overlap, PairList};
use crate::support::random::Stream;
use crate::support::scene::{
    advance, body, laws, quaternion, rotation, size, touch, vector, Memory, Rotation, Vector,
};
use ellgran::contact::{Body, Laws};

/// What rounding may do to a penetration: a part in 1e9, and a few units in the last place of the bodies' size.
fn slack(i: &Body, j: &Body, penetration: f64) -> f64 {
    1e-9 * penetration + 64.0 * f64::EPSILON * size(i, j)
}

fn elastic() -> Laws {
    laws(&["hertz 1e6 0.3"])
}

fn alone(laws: &Laws, i: &Body, j: &Body) -> f64 {
    touch(laws, i, j).map_or(0.0, |f| f.geometry.penetration)
}

/// Two thin discs of which a list found a minimum 1.4 times as deep as the global one.
fn two_discs() -> (Body, Body) {
    let turn = |q| rotation(q);
    let i = body(
        [7.958451944256717, 7.958451944256717, 0.03689404149576194],
        Vector::zeros(),
        turn([
            -0.14985865036299906,
            -0.3622107583278432,
            -0.5455315268210758,
            -0.7407705933521677,
        ]),
    );
    let j = body(
        [
            0.007592568159449963,
            0.0075924096884320775,
            2.9961394707448172,
        ],
        Vector::new(-3.51272946749222, 7.236139635184148, 2.7506295735496704),
        turn([
            -0.1498655622829295,
            -0.36224245402151456,
            -0.5455272824109155,
            -0.7407568439720644,
        ]),
    );
    (i, j)
}

#[test]
fn a_disc_and_a_needle_new_to_a_list() {
    let laws = laws(&["hertz 1e8 0.45"]);
    let (i, j) = two_discs();
    let (wanted, _) = deepest(&i, &j, 2000);
    assert!((wanted - 0.00182759).abs() < 1e-8, "{wanted}");
    let near = |found: f64| assert!((found - wanted).abs() <= slack(&i, &j, wanted), "{found}");
    near(alone(&laws, &i, &j));
    for set in instruction_sets() {
        // With other pairs in the lanes beside it, and for some steps.
        let pairs = vec![(i, j); 21];
        let mut list = PairList::new(&laws, set, pairs.len());
        for _ in 0..4 {
            for found in list.step(&pairs) {
                near(found.unwrap());
            }
        }
    }
}

#[derive(Clone, Copy, Debug)]
enum Shapes {
    Any,
    Discs,
    Needles,
}

impl Shapes {
    fn semi_axes(self, stream: &mut Stream, aspect: f64) -> [f64; 3] {
        let thin = stream.log_uniform(1.0 / aspect, 1.0);
        match self {
            Shapes::Any => stream.semi_axes(aspect),
            Shapes::Discs => [1.0, 1.0, thin],
            Shapes::Needles => [1.0, thin, thin],
        }
    }
}

#[derive(Clone, Copy, Debug)]
enum Place {
    /// A random direction is a common normal, and the overlap along it this many of the smallest semi-axis, log-uniform. Whether it is the
    /// least is another matter.
    Overlap(f64, f64),
    /// Anywhere.
    Anywhere,
    /// At the same place.
    Coincident,
}

fn smallest(i: &Body, j: &Body) -> f64 {
    let axes = i.semi_axes.iter().chain(&j.semi_axes);
    axes.fold(f64::INFINITY, |a, b| a.min(*b))
}

/// The surface point with outward normal `n`, from the centre.
fn witness(b: &Body, n: &Vector) -> Vector {
    let turn = rotation(b.quaternion);
    let a = Vector::from(b.semi_axes);
    let z = a.component_mul(&(turn.inverse() * n));
    turn * a.component_mul(&z) / z.norm()
}

fn random_pair(stream: &mut Stream, shapes: Shapes, aspect: f64, place: Place) -> (Body, Body) {
    let mut one = || {
        let a = shapes.semi_axes(stream, aspect);
        body(a, Vector::zeros(), stream.rotation())
    };
    let (i, mut j) = (one(), one());
    j.position = match place {
        Place::Overlap(least, most) => {
            // Half of the normals evenly over the surface of a body stretched to a ball: flat sides are not met by chance.
            let n = stream.direction();
            let flat = rotation(i.quaternion) * n.component_div(&Vector::from(i.semi_axes));
            let n = if stream.uniform(0.0, 1.0) < 0.5 {
                n
            } else {
                flat.normalize()
            };
            let depth = smallest(&i, &j) * stream.log_uniform(least, most);
            witness(&i, &n) + witness(&j, &n) - n * depth
        }
        Place::Anywhere => stream.direction() * stream.uniform(0.0, 1.5),
        Place::Coincident => Vector::zeros(),
    }
    .into();
    (i, j)
}

/// Pairs of each class.
fn stress_pairs() -> usize {
    std::env::var("ELLGRAN_STRESS_PAIRS").map_or(300, |n| n.parse().expect("a number of pairs"))
}

#[test]
fn random_pairs_in_lists_and_alone() {
    let laws = elastic();
    let number = stress_pairs();
    let mut total = [0usize; 2];
    for shapes in [Shapes::Any, Shapes::Discs, Shapes::Needles] {
        for aspect in [2.0, 10.0, 100.0, 1000.0] {
            for place in [
                Place::Overlap(1e-6, 1e-2),
                Place::Overlap(1e-2, 0.1),
                Place::Overlap(0.1, 2.0),
                Place::Anywhere,
                Place::Coincident,
            ] {
                let mut stream = Stream::new(total[0] as u64 + 77);
                let mut left = number;
                let (mut touching, mut wrong) = (0, 0);
                while left > 0 {
                    let block = left.min(1000);
                    left -= block;
                    let pairs: Vec<_> = (0..block)
                        .map(|_| random_pair(&mut stream, shapes, aspect, place))
                        .collect();
                    let lists: Vec<Vec<Option<f64>>> = instruction_sets()
                        .map(|set| PairList::new(&laws, set, block).step(&pairs))
                        .collect();
                    for (k, (i, j)) in pairs.iter().enumerate() {
                        let mut found: Vec<f64> =
                            lists.iter().map(|list| list[k].unwrap_or(0.0)).collect();
                        found.push(alone(&laws, i, j));
                        // From a normal that has nothing to do with the contact, or is opposite to it.
                        let mut memory = Memory::new(&laws);
                        let n = stream.direction();
                        memory.history[..3].copy_from_slice(n.as_slice());
                        let warm = advance(&laws, i, j, 0.0, &mut memory);
                        found.push(warm.as_ref().map_or(0.0, |f| f.geometry.penetration));
                        let mut least = found.iter().fold(f64::INFINITY, |a, b| a.min(*b));
                        if k % 25 == 0 {
                            least = least.min(deepest(i, j, 100).0).max(0.0);
                        }
                        touching += usize::from(least > 0.0);
                        let excess = found.iter().fold(0.0f64, |a, b| a.max(b - least));
                        if excess > slack(i, j, least) {
                            wrong += 1;
                            if wrong < 4 {
                                println!("{least} found as {found:?}: {i:?} {j:?}");
                            }
                        }
                    }
                }
                println!(
                    "{shapes:?}, aspect ratio {aspect}, {place:?}: {wrong} of {touching} wrong"
                );
                total[0] += touching;
                total[1] += wrong;
            }
        }
    }
    println!("{} of {} wrong", total[1], total[0]);
    assert_eq!(total[1], 0);
}

/// Steps of pairs that are pushed into each other and out again while they turn, in a list of each instruction set and one by
/// one, against the contact alone without a past. `depth` in smallest semi-axes.
fn push(pairs: &[(Body, Body)], depth: f64, steps: usize, seed: u64) -> [usize; 2] {
    let laws = elastic();
    let mut stream = Stream::new(seed);
    let paths: Vec<_> = pairs
        .iter()
        .map(|(i, j)| {
            // Where they just touch along a random direction, and from there on inwards.
            let n = deepest(i, j, 8).1;
            let touch = witness(i, &n) + witness(j, &n);
            (
                touch,
                n,
                stream.direction() * stream.uniform(0.0, 0.2 / steps as f64),
            )
        })
        .collect();
    let mut lists: Vec<_> = instruction_sets()
        .map(|set| PairList::new(&laws, set, pairs.len()))
        .collect();
    let mut memories = vec![Memory::new(&laws); pairs.len()];
    let mut count = [0; 2];
    for step in 0..steps {
        let share = (step as f64 + 0.5) / steps as f64;
        let into = depth * (1.0 - (2.0 * share - 1.0).abs()) - 0.01;
        let now: Vec<_> = pairs
            .iter()
            .zip(&paths)
            .map(|((i, j), (touch, n, spin))| {
                let mut j = *j;
                j.position = (touch - n * (into * smallest(i, &j))).into();
                let turn = Rotation::from_scaled_axis(spin * step as f64) * rotation(j.quaternion);
                j.quaternion = quaternion(turn);
                (*i, j)
            })
            .collect();
        let in_lists: Vec<_> = lists.iter_mut().map(|list| list.step(&now)).collect();
        for (k, (i, j)) in now.iter().enumerate() {
            let wanted = alone(&laws, i, j);
            let warm = advance(&laws, i, j, 1e-6, &mut memories[k]);
            let mut found: Vec<f64> = in_lists.iter().map(|l| l[k].unwrap_or(0.0)).collect();
            found.push(warm.as_ref().map_or(0.0, |f| f.geometry.penetration));
            count[0] += usize::from(wanted > 0.0);
            if found
                .iter()
                .any(|f| (f - wanted).abs() > slack(i, j, wanted))
            {
                count[1] += 1;
                if count[1] < 4 {
                    println!("{wanted} found as {found:?}: {i:?} {j:?}");
                }
            }
            if let Some(f) = warm {
                // The normal belongs to the penetration.
                let value = overlap(i, j, &vector(f.geometry.normal));
                assert!((value - f.geometry.penetration).abs() <= slack(i, j, value));
            }
        }
    }
    count
}

#[test]
fn no_way_into_a_contact_changes_it() {
    let mut stream = Stream::new(5);
    let mut any = |shapes: Shapes, aspect: f64, number: usize| -> Vec<(Body, Body)> {
        (0..number)
            .map(|_| random_pair(&mut stream, shapes, aspect, Place::Overlap(1e-6, 1e-5)))
            .collect()
    };
    let cases = [
        (
            "any, aspect ratio up to 10",
            any(Shapes::Any, 10.0, 40),
            2.0,
        ),
        (
            "any, aspect ratio up to 1000",
            any(Shapes::Any, 1000.0, 20),
            2.0,
        ),
        ("discs, up to 100", any(Shapes::Discs, 100.0, 40), 1.9),
        ("needles, up to 100", any(Shapes::Needles, 100.0, 40), 1.0),
    ];
    for (name, pairs, depth) in cases {
        let [contacts, different] = push(&pairs, depth, 60, 9);
        println!("{name}: {different} of {contacts} contacts differ from one without a past");
        assert!(contacts > 20 * pairs.len(), "{name}: {contacts}");
        assert_eq!(different, 0, "{name}");
    }
}

/// Thin discs of aspect ratio 20 on flatter ones, pressed together to 1.9 times the thin semi-axis.
#[test]
fn thin_discs_pressed_together() {
    let mut stream = Stream::new(6);
    let pairs: Vec<_> = (0..40)
        .map(|_| {
            let mut disc = |thin: f64| body([1.0, 1.0, thin], Vector::zeros(), stream.rotation());
            let (i, j) = (disc(0.05), disc(0.02));
            (
                i,
                Body {
                    position: stream.direction().into(),
                    ..j
                },
            )
        })
        .collect();
    let [contacts, different] = push(&pairs, 1.9, 60, 10);
    println!("{different} of {contacts} contacts of discs differ from one without a past");
    assert_eq!(different, 0);
}

/// Equal needles in one another, parallel, with centres that are apart across them by so little that the penetrations along all
/// directions across differ by less than rounding of the Hessian shows. The deepest of those directions is known: it is that of the
/// centres.
#[test]
fn needles_in_one_another() {
    let laws = elastic();
    let mut stream = Stream::new(2014);
    let (number, mut worst) = (4000, 0.0f64);
    for _ in 0..number {
        let thin = stream.log_uniform(1e-3, 1e-2);
        let turn = stream.rotation();
        let across = |angle: f64| turn * Vector::new(0.0, angle.cos(), angle.sin());
        let (direction, remembered) = (
            across(stream.uniform(0.0, 2.0 * std::f64::consts::PI)),
            across(stream.uniform(0.0, 2.0 * std::f64::consts::PI)),
        );
        let apart = thin * stream.log_uniform(1e-7, 1e-3);
        let i = body([1.0, thin, thin], Vector::zeros(), turn);
        let j = Body {
            position: (direction * apart).into(),
            ..i
        };
        let wanted = 2.0 * thin - apart;
        let mut memory = Memory::new(&laws);
        memory.history[..3].copy_from_slice(remembered.as_slice());
        let warm = advance(&laws, &i, &j, 0.0, &mut memory).expect("they overlap");
        for found in [warm.geometry.penetration, alone(&laws, &i, &j)] {
            worst = worst.max((found - wanted).abs() / slack(&i, &j, wanted));
        }
    }
    println!("{number} pairs: at most {worst} times what rounding may do");
    assert!(worst < 1.0, "{worst}");
}

/// Crossed blades that the line between their centres leads into a valley that curves downwards a little, over its whole length.
#[test]
fn a_long_valley_is_followed_to_its_end() {
    let laws = elastic();
    let half = 0.5f64.sqrt();
    let i = body(
        [1.0, 0.0013130564228458256, 0.043699183993689265],
        Vector::zeros(),
        Rotation::identity(),
    );
    let j = body(
        [1.0, 0.0013793028137081892, 0.516178531165505],
        Vector::new(
            1.2992030317335048,
            -5.706054315811349e-8,
            0.8155471609086992,
        ),
        rotation([half, 0.0, half, 0.0]),
    );
    let between = Vector::from(j.position).normalize();
    let wanted = touch(&laws, &i, &j).expect("they overlap").normal;
    let mut stream = Stream::new(2015);
    for k in 0..200 {
        let remembered = between + stream.direction() * (1e-5 * f64::from(k));
        let mut memory = Memory::new(&laws);
        memory.history[..3].copy_from_slice(remembered.normalize().as_slice());
        let warm = advance(&laws, &i, &j, 0.0, &mut memory).expect("they overlap");
        // Each way ends to the side of the blades' plane that it is on.
        let found = warm.normal;
        let off = (found - wanted)
            .norm()
            .min((found - Vector::new(wanted.x, -wanted.y, wanted.z)).norm());
        assert!(off < 1e-9, "start {k}: off by {off:e}");
    }
}
