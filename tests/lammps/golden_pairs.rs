// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do force and torques of random pairs agree with the high-precision reference of `validation/reference`?

use std::collections::HashMap;

use crate::harness::{forces_of_many, Engine, Frame, Grain, Scene};
use crate::shapes::{
    about, add, compose, cross, length, rotate, scale, sub, Quaternion, Vector, IDENTITY,
};

pub const ASPECT_10: &str = include_str!("../../validation/reference/pairs_aspect_10.csv");
pub const ASPECT_100: &str = include_str!("../../validation/reference/pairs_aspect_100.csv");
const ASPECT_1000: &str = include_str!("../../validation/reference/pairs_aspect_1000.csv");

/// What must be reached where the rounding of the coordinates allows it.
const TOLERANCE: f64 = 1e-9;

pub struct Pair {
    pub case: String,
    pub grains: [Grain; 2],
    pub materials: [[f64; 2]; 2],
    pub delta: f64,
    pub normal: Vector,
    pub contact_point: Vector,
    /// A <= B
    pub curvatures: [f64; 2],
    /// Force on j, torque on i, torque on j: along the normal only, and the complete gradient.
    pub expected: [[Vector; 3]; 2],
}

impl Pair {
    /// The longest semi-axis, and that or the largest coordinate of a centre.
    pub fn size(&self) -> (f64, f64) {
        let largest =
            |numbers: [[f64; 3]; 2]| numbers.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
        let [i, j] = &self.grains;
        let arm = largest([i.semi_axes, j.semi_axes]);
        (arm, arm.max(largest([i.position, j.position])))
    }
}

pub fn read_pairs(text: &str) -> Vec<Pair> {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    lines
        .map(|line| {
            let row: HashMap<&str, &str> = names.iter().copied().zip(line.split(',')).collect();
            let number = |name: &str| row[name].parse::<f64>().unwrap();
            let vector = |stem: &str, ends: [&str; 3]| ends.map(|e| number(&format!("{stem}_{e}")));
            let xyz = ["x", "y", "z"];
            let grain = |body: &str| {
                let q = ["w", "x", "y", "z"].map(|c| number(&format!("quaternion_{body}_{c}")));
                Grain::new(
                    vector(&format!("semi_axis_{body}"), ["1", "2", "3"]),
                    vector(&format!("position_{body}"), xyz),
                )
                .turned(q)
            };
            let material = |body: &str| {
                [
                    number(&format!("youngs_modulus_{body}")),
                    number(&format!("poissons_ratio_{body}")),
                ]
            };
            let results = |prefix: &str| {
                ["force_j", "torque_i", "torque_j"].map(|r| vector(&format!("{prefix}{r}"), xyz))
            };
            Pair {
                case: row["case"].into(),
                grains: [grain("i"), grain("j")],
                materials: [material("i"), material("j")],
                delta: number("delta"),
                normal: vector("normal", xyz),
                contact_point: vector("contact_point", xyz),
                curvatures: [number("curvature_a"), number("curvature_b")],
                expected: [results(""), results("conservative_")],
            }
        })
        .collect()
}

struct Errors {
    force: f64,
    torque: f64,
    third_law: f64,
    moment: f64,
}

/// Relative to the force, and to the force times the largest semi-axis for torques.
fn errors(expected: &[Vector; 3], frame: &Frame, arm: f64) -> Errors {
    let [i, j] = [&frame.states[0], &frame.states[1]];
    let force = length(expected[0]);
    let moment = {
        let d = sub(j.position, i.position);
        let orbital = cross(d, j.force);
        add(orbital, add(i.torque, j.torque))
    };
    let torque = |got: Vector, wanted: Vector| {
        length(sub(got, wanted)) / length(wanted).max(1e-3 * force * arm)
    };
    Errors {
        force: length(sub(j.force, expected[0])) / force,
        torque: torque(i.torque, expected[1]).max(torque(j.torque, expected[2])),
        third_law: length(add(i.force, j.force)) / force,
        moment: length(moment) / (force * arm),
    }
}

/// Runs the pairs scaled and rotated and holds every one to the tolerance.
fn hold(name: &str, text: &str, factor: f64, turn: Quaternion, atom_style: &str) {
    let engine = Engine::from_environment();
    let pairs: Vec<Pair> = read_pairs(text).into_iter().collect();
    let mut scenes = vec![];
    let mut laws = vec![];
    for pair in &pairs {
        let grains = pair
            .grains
            .iter()
            .enumerate()
            .map(|(k, g)| {
                let mut g = g.clone();
                g.kind = k + 1;
                g.semi_axes = scale(factor, g.semi_axes);
                g.position = scale(
                    factor,
                    if turn == IDENTITY {
                        g.position
                    } else {
                        rotate(turn, g.position)
                    },
                );
                if turn != IDENTITY {
                    g.quaternion = compose(turn, g.quaternion);
                }
                g
            })
            .collect();
        scenes.push(Scene::open(8.0 * factor, grains));
        laws.push(
            ["no", "yes"]
                .map(|conservative| {
                    let constants =
                        |k: usize| format!("{:e} {:e}", pair.materials[k][0], pair.materials[k][1]);
                    (0..2)
                        .map(|k| {
                            format!(
                                "{0} {0} hertz {1} conservative {conservative}",
                                k + 1,
                                constants(k)
                            )
                        })
                        .collect()
                })
                .to_vec(),
        );
    }
    let frames = forces_of_many(&engine, name, &scenes, &laws, atom_style);
    let mut worst = [(0.0, String::new()), (0.0, String::new())];
    let (mut largest, mut failures) = ([0.0f64; 5], vec![]);
    for (pair, frames) in pairs.iter().zip(&frames) {
        let (arm, extent) = pair.size();
        let allowed = TOLERANCE.max(8.0 * f64::EPSILON * extent / pair.delta);
        for (law, frame) in frames.iter().enumerate() {
            let [f, ti, tj] = pair.expected[law].map(|v| rotate(turn, v));
            let expected = [
                scale(factor.powi(2), f),
                scale(factor.powi(3), ti),
                scale(factor.powi(3), tj),
            ];
            let e = errors(&expected, frame, arm * factor);
            let error = if e.force.is_nan() || e.torque.is_nan() {
                f64::INFINITY
            } else {
                e.force.max(e.torque)
            };
            if error / allowed > worst[law].0 {
                worst[law] = (error / allowed, pair.case.clone());
            }
            for (slot, value) in largest.iter_mut().zip([
                e.force,
                e.torque,
                e.third_law,
                e.moment,
                if allowed == TOLERANCE { error } else { 0.0 },
            ]) {
                *slot = slot.max(value);
            }
            if !(error <= allowed && e.third_law < 1e-14 && e.moment < 1e-12) {
                failures.push(format!(
                    "case {}, conservative {}: force {:.2e}, torque {:.2e}, allowed {allowed:.2e}, third law {:.1e}, moment {:.1e}",
                    pair.case,
                    ["no", "yes"][law],
                    e.force,
                    e.torque,
                    e.third_law,
                    e.moment
                ));
            }
        }
    }
    println!(
        "{name}: {} pairs; largest error: {:.1e} where rounding permits {TOLERANCE:.0e}; all: force {:.2e}, torque {:.2e}, third law {:.1e}, balance of moments {:.1e}; \
         largest share of the allowance: conservative no {:.3} (case {}), yes {:.3} (case {})",
        pairs.len(),
        largest[4],
        largest[0],
        largest[1],
        largest[2],
        largest[3],
        worst[0].0,
        worst[0].1,
        worst[1].0,
        worst[1].1
    );
    assert!(
        failures.is_empty(),
        "{} of {}:\n{}",
        failures.len(),
        2 * pairs.len(),
        failures.join("\n")
    );
}

#[test]
fn both_versions_golden_pairs_aspect_10() {
    hold("golden_10", ASPECT_10, 1.0, IDENTITY, "ellipsoid");
}

#[test]
fn both_versions_golden_pairs_aspect_100() {
    hold("golden_100", ASPECT_100, 1.0, IDENTITY, "ellipsoid");
}

#[test]
fn both_versions_golden_pairs_aspect_1000() {
    hold("golden_1000", ASPECT_1000, 1.0, IDENTITY, "ellipsoid");
}

#[test]
fn golden_pairs_in_the_superellipsoid_atom_style() {
    hold(
        "golden_super_10",
        ASPECT_10,
        1.0,
        IDENTITY,
        "ellipsoid superellipsoid",
    );
    hold(
        "golden_super_100",
        ASPECT_100,
        1.0,
        IDENTITY,
        "ellipsoid superellipsoid",
    );
}

/// Powers of two keep every double: 2^-20, 2^-10, 2^10, 2^20, beside 1 in the tests above.
#[test]
fn golden_pairs_at_five_length_scales() {
    for exponent in [-20, -10, 10, 20] {
        let name = format!("golden_scale_{exponent}");
        hold(&name, ASPECT_10, 2f64.powi(exponent), IDENTITY, "ellipsoid");
        hold(
            &name,
            ASPECT_100,
            2f64.powi(exponent),
            IDENTITY,
            "ellipsoid",
        );
    }
}

#[test]
fn golden_pairs_under_a_rotation_of_the_scene() {
    let turn = about([0.3, -0.8, 0.5], 2.1);
    hold("golden_turned_10", ASPECT_10, 1.0, turn, "ellipsoid");
    hold("golden_turned_100", ASPECT_100, 1.0, turn, "ellipsoid");
    hold(
        "golden_turned_small",
        ASPECT_10,
        2f64.powi(-20),
        turn,
        "ellipsoid",
    );
}
