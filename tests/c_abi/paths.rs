// SPDX-License-Identifier: MIT OR Apache-2.0
//! A whole neighbour list and one contact at a time give the same numbers, with every combination of laws.

use ellgran::c_api::law::ELLGRAN_OPTION_NO_WARM_START;

use crate::comparison::{Comparison, Seen};
use crate::scene::random_bodies;

/// Normal laws of two materials, with what goes with them.
fn normal_laws() -> Vec<[String; 2]> {
    let both = |law: &str, one: &str, other: &str, words: &str| {
        [one, other].map(|constants| format!("{law} {constants} {words}"))
    };
    let hertz = |words: &str| both("hertz", "1e4 0.3", "3e4 0.2", words);
    let mut laws = vec![hertz("")];
    laws.push(["0.5", "0.9"].map(|e| format!("{} damping restitution {e}", hertz("")[0])));
    for unloading in ["ting", "first_order"] {
        laws.push(["5e-3", "2e-2"].map(|a| {
            format!(
                "{} damping relaxation {a} unloading {unloading}",
                hertz("")[1]
            )
        }));
        for closure in ["energy", "surface", "brilliantov"] {
            let words = format!("closure {closure} unloading {unloading}");
            laws.push(both("nfd", "1e4 0.3 40 60", "3e4 0.2 90 30", &words));
        }
    }
    laws.push(both("lsd", "2e3 3", "5e3 2", ""));
    laws
}

/// Tangential laws of the same two materials.
fn tangential_laws() -> Vec<[String; 2]> {
    let mut laws = vec![["tangential none", "tangential none"].map(str::to_owned)];
    for (name, one, other) in [
        ("tfd", "0.4", "0.2"),
        ("mindlin", "0.4", "0.2"),
        ("linear", "500 1 0.4", "900 2 0.2"),
    ] {
        for displacement in ["total", "incremental", "rescaled"] {
            laws.push(
                [one, other].map(|c| format!("tangential {name} {c} displacement {displacement}")),
            );
        }
    }
    laws
}

fn combinations() -> Vec<[String; 2]> {
    let mut all = Vec::new();
    for normal in normal_laws() {
        for tangential in tangential_laws() {
            let elastic = ["tfd", "mindlin"].iter().any(|t| tangential[0].contains(t));
            if normal[0].starts_with("lsd") && elastic {
                continue;
            }
            for form in [
                "factors exact conservative yes",
                "factors exact conservative no",
                "factors hale conservative no",
            ] {
                for limit in ["yes", "no"] {
                    all.push([0, 1].map(|k| {
                        format!("{} {} {form} limit_force {limit}", normal[k], tangential[k])
                    }));
                }
            }
        }
    }
    all
}

fn compare(decks: &[String; 2], options: u32, newton: bool, steps: usize, seen: &mut Seen) {
    let comparison = Comparison {
        options,
        newton,
        steps,
        ..Comparison::new(decks, random_bodies(5))
    };
    comparison.run(seen);
}

/// Every combination whose normal law has these words and none of the others; without Newton's third law for ghosts too.
fn every_combination(with: &str, without: &str, count: usize) {
    let mut decks = combinations();
    decks
        .retain(|[deck, _]| deck.contains(with) && (without.is_empty() || !deck.contains(without)));
    assert_eq!(decks.len(), count);
    for newton in [true, false] {
        let mut seen = Seen::default();
        for decks in &decks {
            compare(decks, 0, newton, 10, &mut seen);
        }
        seen.check(160 * count);
    }
}

#[test]
fn elastic_hertz_with_every_tangential_law() {
    every_combination("hertz", "damping", 60);
}

#[test]
fn restitution_damping_with_every_tangential_law() {
    every_combination("damping restitution", "", 60);
}

#[test]
fn relaxation_damping_with_every_tangential_law() {
    every_combination("damping relaxation", "", 120);
}

#[test]
fn nfd_with_every_tangential_law_unloading_ting() {
    every_combination("nfd", "unloading first_order", 180);
}

#[test]
fn nfd_with_every_tangential_law_unloading_first_order() {
    every_combination("nfd", "unloading ting", 180);
}

#[test]
fn lsd_with_every_tangential_law_that_it_may_have() {
    every_combination("lsd", "", 24);
}

/// Forces that see velocities of the step: elastic laws then take the mean of the tangential stiffness over the step, as viscous ones do.
#[test]
fn velocities_of_the_step_with_every_law() {
    let decks = combinations();
    let mut seen = Seen::default();
    for decks in &decks {
        let mut bodies = random_bodies(5);
        for body in &mut bodies {
            body.velocities_of_step = 1;
            body.velocity_change = body.velocity.map(|v| 0.1 * v);
            body.angular_velocity_change = body.angular_velocity.map(|w| -0.2 * w);
        }
        Comparison::new(decks, bodies).run(&mut seen);
    }
    seen.check(160 * decks.len());
}

/// What motions have more at the step is summed up about the origin of coordinates in lanes: far from it rounding is that of coordinates, of
/// which a hundred thousand radii leave eleven digits of a radius.
#[test]
fn velocities_of_the_step_far_from_the_origin() {
    let decks = combinations();
    let mut seen = Seen::default();
    for decks in decks.iter().step_by(5) {
        let mut bodies = random_bodies(5);
        for body in &mut bodies {
            for (x, far) in body.position.iter_mut().zip([1e5, -2e5, 3e5]) {
                *x += far;
            }
            body.velocities_of_step = 1;
            body.velocity_change = body.velocity.map(|v| 0.1 * v);
            body.angular_velocity_change = body.angular_velocity.map(|w| -0.2 * w);
        }
        Comparison {
            wider: 1e5,
            ..Comparison::new(decks, bodies)
        }
        .run(&mut seen);
    }
    seen.check(160 * decks.len() / 5);
}

#[test]
fn the_groups_above_are_all_combinations() {
    assert_eq!(combinations().len(), 60 + 60 + 120 + 180 + 180 + 24);
}

#[test]
fn a_longer_history() {
    let mut seen = Seen::default();
    let nfd = ["nfd 1e4 0.3 40 60", "nfd 3e4 0.2 90 30"];
    for tangential in tangential_laws() {
        let decks = [0, 1].map(|k| format!("{} {}", nfd[k], tangential[k]));
        for newton in [true, false] {
            compare(&decks, 0, newton, 40, &mut seen);
        }
    }
    seen.check(10_000);
}

#[test]
fn without_the_cached_normal() {
    let mut seen = Seen::default();
    for tangential in tangential_laws() {
        let decks = [0, 1].map(|k| {
            format!(
                "{} {}",
                ["hertz 1e4 0.3", "hertz 3e4 0.2"][k],
                tangential[k]
            )
        });
        for newton in [true, false] {
            compare(&decks, ELLGRAN_OPTION_NO_WARM_START, newton, 20, &mut seen);
        }
    }
    seen.check(10_000);
}

/// The memory of the normal force is computed by the kernel that records: of one relaxing part in one material, of three between two,
/// and between one that has no memory and one that has.
#[test]
fn viscosity_with_memory() {
    let mut seen = Seen::default();
    let materials = [
        ["1e4 0.3 40 60", "3e4 0.2 90 30"],
        ["1e4 0.3 0 60", "3e4 0.2 90 0"],
        ["1e4 0.3 0 0", "3e4 0.2 90 30"],
        ["1e4 0.1 3000 9000", "1e4 0.45 30 9000"],
    ];
    for (k, tangential) in tangential_laws().iter().enumerate() {
        let conservative = ["yes", "no"][k % 2];
        let more = ["", "rolling sds 500 1 0.1"][k / 2 % 2];
        let decks = [0, 1].map(|i| {
            let material = materials[k % materials.len()][i];
            format!(
                "nfd {material} viscosity memory {} conservative {conservative} {more}",
                tangential[i]
            )
        });
        for newton in [true, false] {
            for options in [0, ELLGRAN_OPTION_NO_WARM_START] {
                compare(&decks, options, newton, 30, &mut seen);
            }
        }
    }
    seen.check(10_000);
}

/// What resists rolling and twisting is computed after the lanes, from what they record: with and without all that they may have
/// beside it.
#[test]
fn rolling_and_twisting() {
    let mut seen = Seen::default();
    for [one, other] in [
        ["hertz 1e4 0.3 rolling sds 500 1 0.1", "hertz 3e4 0.2 rolling sds 200 2 0.2"],
        ["hertz 1e4 0.3 twisting sds 2 0.01 0.05", "hertz 3e4 0.2 twisting sds 5 0.02 0.02"],
        [
            "hertz 1e4 0.3 tangential tfd 0.4 rolling sds 500 1 0.1 twisting marshall",
            "hertz 3e4 0.2 tangential tfd 0.2 rolling sds 200 2 0.2 twisting marshall",
        ],
        [
            "nfd 1e4 0.3 40 60 tangential mindlin 0.4 displacement total rolling sds 500 0 0.1 twisting sds 2 0 0.05",
            "nfd 3e4 0.2 90 30 tangential mindlin 0.2 displacement total rolling sds 200 0 0.2 twisting sds 5 0 0.02",
        ],
        [
            "lsd 2e3 3 tangential linear 500 1 0.4 twisting marshall conservative no",
            "lsd 5e3 2 tangential linear 900 2 0.2 twisting marshall conservative no",
        ],
        [
            "nfd 1e4 0.3 40 60 tangential tfd 0.4 displacement hysteretic twisting lubkin",
            "nfd 3e4 0.2 90 30 tangential tfd 0.2 displacement hysteretic twisting lubkin",
        ],
        [
            "hertz 1e4 0.3 tangential tfd 0.4 displacement hysteretic rolling sds 500 1 0.1 twisting lubkin",
            "hertz 3e4 0.2 tangential tfd 0 displacement hysteretic rolling sds 200 2 0.2 twisting lubkin",
        ],
        [
            "hertz 1e4 0.3 factors hale tangential mindlin 0.4 rolling sds 500 1 0.1 twisting marshall",
            "hertz 3e4 0.2 factors hale tangential mindlin 0.2 rolling sds 200 2 0.2 twisting marshall",
        ],
    ] {
        let decks = [one, other].map(str::to_owned);
        for newton in [true, false] {
            for options in [0, ELLGRAN_OPTION_NO_WARM_START] {
                compare(&decks, options, newton, 30, &mut seen);
            }
        }
    }
    seen.check(10_000);
}
