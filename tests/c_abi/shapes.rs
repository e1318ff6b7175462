// SPDX-License-Identifier: MIT OR Apache-2.0
//! Lists of one kind of shapes have closed forms of their own: they give the numbers of one contact at a time, which knows
//! of triaxial ellipsoids alone.

use ellgran::c_api::contact::EllgranBody;

use crate::comparison::{Comparison, Seen};
use crate::scene::*;

/// Laws whose kernels differ, of two materials each.
const DECKS: [[&str; 2]; 6] = [
    [
        "nfd 1e4 0.3 40 60 tangential tfd 0.4",
        "nfd 3e4 0.2 90 30 tangential tfd 0.2",
    ],
    [
        "nfd 1e4 0.3 40 60 conservative no",
        "nfd 3e4 0.2 90 30 conservative no",
    ],
    ["hertz 1e4 0.3", "hertz 3e4 0.2"],
    [
        "hertz 1e4 0.3 conservative no tangential tfd 0.4",
        "hertz 3e4 0.2 conservative no tangential tfd 0.2",
    ],
    [
        "hertz 1e4 0.3 damping restitution 0.5 tangential mindlin 0.4 displacement rescaled",
        "hertz 1e4 0.3 damping restitution 0.9 tangential mindlin 0.2 displacement rescaled",
    ],
    [
        "nfd 1e4 0.3 40 60 tangential tfd 0.4 displacement rescaled limit_force yes",
        "nfd 3e4 0.2 90 30 tangential tfd 0.2 displacement rescaled limit_force yes",
    ],
];

/// A spheroid with its axis of revolution along this axis of the body.
fn spheroid(polar_axis: usize, polar: f64, equatorial: f64) -> [f64; 3] {
    let mut semi_axes = [equatorial; 3];
    semi_axes[polar_axis % 3] = polar;
    semi_axes
}

fn prolate(random: &mut Random, polar_axis: usize) -> [f64; 3] {
    spheroid(
        polar_axis,
        random.between(1.15, 1.5),
        random.between(0.8, 1.0),
    )
}

fn oblate(random: &mut Random, polar_axis: usize) -> [f64; 3] {
    spheroid(
        polar_axis,
        random.between(0.65, 0.85),
        random.between(1.05, 1.3),
    )
}

/// The scene of triaxial grains, with other shapes.
fn grains(shape: impl Fn(&mut Random, usize) -> [f64; 3]) -> Vec<EllgranBody> {
    let mut random = Random(17);
    let mut bodies = random_bodies(5);
    for (k, body) in bodies.iter_mut().enumerate() {
        body.semi_axes = shape(&mut random, k);
    }
    bodies
}

pub fn spheres() -> Vec<EllgranBody> {
    grains(|random, _| [random.between(0.9, 1.15); 3])
}

/// Of all kinds, the axis of revolution each of the three.
pub fn mixture() -> Vec<EllgranBody> {
    grains(|random, k| match k / 3 % 3 {
        0 => prolate(random, k),
        1 => oblate(random, k),
        _ => [random.between(0.9, 1.15); 3],
    })
}

/// A mixture of spheroids, and one grain that is none.
fn one_triaxial(which: usize) -> Vec<EllgranBody> {
    let mut bodies = mixture();
    bodies[which].semi_axes = [0.85, 1.3, 1.05];
    bodies
}

/// A face-centred packing of spheres, stretched thirtyfold along some axes.
pub fn slender(stretch: [f64; 3]) -> Vec<EllgranBody> {
    let mut random = Random(23);
    let mut bodies = random_bodies(5);
    for (k, body) in bodies.iter_mut().enumerate() {
        let [i, j, layer] = [k % 4, k / 4 % 4, k / 16].map(|c| c as f64);
        let shift = layer % 2.0;
        let place = [2.0 * i + shift, 2.0 * j + shift, 2f64.sqrt() * layer];
        body.semi_axes = stretch;
        for c in 0..3 {
            body.position[c] = stretch[c] * (0.985 * place[c] + random.between(-0.015, 0.015));
        }
        // The ends of the grains move about as far as their middles.
        let turned: [f64; 3] = random.vector(-1e-3, 1e-3);
        body.quaternion = [1.0, turned[0], turned[1], turned[2]];
        body.angular_velocity = random.vector(-0.03, 0.03);
    }
    bodies
}

/// With how many steps are taken: nearly all slender grains are in reach of each other.
fn kinds() -> [(&'static str, usize, Vec<EllgranBody>); 8] {
    [
        ("spheres", 10, spheres()),
        ("prolate", 10, grains(|random, _| prolate(random, 0))),
        ("oblate", 10, grains(|random, _| oblate(random, 2))),
        ("mixture", 10, mixture()),
        ("one triaxial grain", 10, one_triaxial(30)),
        ("a triaxial ghost", 10, one_triaxial(50)),
        ("needles", 4, slender([30.0, 1.0, 1.0])),
        ("discs", 4, slender([1.0, 30.0, 30.0])),
    ]
}

#[test]
fn lists_of_each_kind() {
    for (name, steps, bodies) in kinds() {
        let mut seen = Seen::default();
        for (k, decks) in DECKS.iter().enumerate() {
            // With the full law and with the one that reads masses, from angular momenta too.
            let momenta: &[bool] = if k == 0 || k == 4 {
                &[false, true]
            } else {
                &[false]
            };
            for &momenta in momenta {
                let comparison = Comparison {
                    newton: (k % 2 == 0) != momenta,
                    momenta,
                    steps,
                    ..Comparison::new(&decks.map(str::to_owned), bodies.clone())
                };
                comparison.run(&mut seen);
            }
        }
        println!("{name}: {seen:?}");
        seen.check(3_000);
    }
}

/// The list stays; or it is said to be another one when the shapes change.
const UNCHANGED: [fn(usize) -> bool; 2] = [|step| step > 0, |step| step % 4 != 0];

/// Every fourth step the list has shapes of another kind; whatever is kept of the last one is carried over.
#[test]
fn lists_that_change_kind() {
    type Change = fn(usize, &mut [EllgranBody]);
    let one_grain: Change = |step, bodies| match step {
        4 | 12 => bodies[21].semi_axes = [0.85, 1.3, 1.05],
        8 => bodies[21].semi_axes = [0.85, 1.3, 1.3],
        _ => (),
    };
    let all_grains: Change = |step, bodies| {
        for (k, body) in bodies.iter_mut().enumerate() {
            let [a, b, _] = body.semi_axes;
            body.semi_axes = match step {
                // Spheres, spheroids, ellipsoids, spheres.
                4 => spheroid(k, 1.1 * a, 0.95 * a),
                8 => [0.95 * a, a, 1.05 * b],
                12 => [a.max(0.95); 3],
                _ => continue,
            };
        }
    };
    let a_ghost: Change = |step, bodies| match step {
        4 => bodies[50].semi_axes = spheroid(1, 1.25, 0.9),
        8 => bodies[50].semi_axes = [0.9, 1.2, 1.1],
        12 => bodies[50].semi_axes = [1.05; 3],
        _ => (),
    };
    for (name, bodies, change) in [
        ("a spheroid becomes triaxial", mixture(), one_grain),
        ("spheres become spheroids", spheres(), all_grains),
        (
            "a sphere among ghosts becomes a spheroid",
            spheres(),
            a_ghost,
        ),
    ] {
        let mut seen = Seen::default();
        for decks in [DECKS[0], DECKS[4]] {
            for unchanged in UNCHANGED {
                for keeps_history in [false, true] {
                    let comparison = Comparison {
                        steps: 15,
                        momenta: keeps_history,
                        keeps_history,
                        unchanged,
                        change,
                        ..Comparison::new(&decks.map(str::to_owned), bodies.clone())
                    };
                    comparison.run(&mut seen);
                }
            }
        }
        println!("{name}: {seen:?}");
        seen.check(1_000);
    }
}
