// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do compute pair/gran/local and wall/gran/local tell what a contact of ellipsoids has, under every option and in any order of them?

use std::collections::HashMap;
use std::fs;

use ellgran::contact::{one_contact, Body, Laws, Step};
use ellgran::contact::{prepare_body, OneContact};
use ellgran::force::syntax;

use crate::harness::{
    fresh_directory, last_rows, run_in, Deck, Engine, Grain, Outcome, Scene, ELASTIC,
};
use crate::meshes::sheet;
use crate::shapes::{about, cross, dot, length, scale, sub, Vector};

/// Every option but those that need a fix heat/gran/conduction or fix multisphere, as LIGGGHTS names them, in the order of its columns.
const OPTIONS: [(&str, usize); 12] = [
    ("pos", 6),
    ("vel", 6),
    ("id", 3),
    ("force", 3),
    ("force_normal", 3),
    ("force_tangential", 3),
    ("torque", 3),
    ("torque_normal", 3),
    ("torque_tangential", 3),
    ("contactArea", 1),
    ("delta", 1),
    ("contactPoint", 3),
];

type Row = HashMap<&'static str, Vec<f64>>;

/// The rows of the last table of a compute with these options.
fn rows(
    scene: &Scene,
    deck: Deck,
    compute: &str,
    options: &[&str],
    name: &str,
    ranks: usize,
) -> (Outcome, Vec<Row>) {
    let engine = Engine::from_environment();
    let directory = fresh_directory(&name.replace(' ', "_"));
    fs::write(directory.join("sheet.stl"), sheet(8)).unwrap();
    let columns: Vec<_> = OPTIONS
        .iter()
        .filter(|(word, _)| options.contains(word))
        .collect();
    let count: usize = columns.iter().map(|(_, width)| width).sum();
    let numbers: String = (1..=count).map(|k| format!(" c_local[{k}]")).collect();
    let mut deck = deck;
    deck.steps = 1;
    deck.fixes.extend([
        format!("compute local all {compute} {}", options.join(" ")),
        format!("dump local all local 1 local{numbers}"),
        format!(
            "dump_modify local format \"{}\"",
            "%.17g ".repeat(count).trim_end()
        ),
    ]);
    let outcome = run_in(&engine, &directory, scene, &deck, ranks);
    let rows = last_rows(&directory.join("local"))
        .iter()
        .map(|values| {
            assert_eq!(values.len(), count);
            let mut at = 0;
            columns
                .iter()
                .map(|(word, width)| {
                    at += width;
                    (*word, values[at - width..at].to_vec())
                })
                .collect()
        })
        .collect();
    (outcome, rows)
}

fn vector(values: &[f64]) -> Vector {
    [values[0], values[1], values[2]]
}

fn oblique() -> Scene {
    let grain = |x: f64, y: f64, z: f64| Grain {
        density: 2500.0,
        ..Grain::new([5e-3, 4e-3, 2.5e-3], [x, y, z])
    };
    Scene::open(
        0.1,
        vec![
            grain(0.0, 0.0, 0.0)
                .turned(about([0.3, 1.0, 0.2], 0.4))
                .moving([0.1, 0.0, 0.05]),
            grain(3e-3, 2e-3, 4.2e-3).turned(about([1.0, 0.1, 0.5], -0.3)),
        ],
    )
}

/// The contact of the first two grains, by the library itself.
fn reference(scene: &Scene) -> OneContact {
    let (parameters, _) = syntax::parse(&["hertz", "1e7", "0.3"]).unwrap();
    let laws = Laws::new(1, &[Some(parameters)], true).unwrap();
    let body = |g: &Grain| {
        prepare_body(
            &Body {
                position: g.position,
                quaternion: g.quaternion,
                semi_axes: g.semi_axes,
                velocity: [0.0; 3],
                angular_velocity: [0.0; 3],
                mass: 1.0,
                particle_type: 1,
                identifier: 1,
            },
            Some(1),
        )
        .unwrap()
    };
    let step = Step {
        time_step: 1e-6,
        advance_history: false,
    };
    let mut history = vec![0.0; laws.layout().length];
    one_contact(
        &laws,
        &body(&scene.grains[0]),
        &body(&scene.grains[1]),
        &step,
        &mut false,
        &mut history,
    )
    .unwrap()
    .expect("they touch")
    .0
}

fn deck(model: &str) -> Deck {
    Deck {
        model: model.into(),
        materials: vec![[1e7, 0.3, 50.0, 50.0]],
        time_step: 1e-12,
        before: vec![
            "fix roll all property/global coefficientRollingFriction peratomtypepair 1 0.1".into(),
        ],
        ..Deck::new(ELASTIC, 0.5)
    }
}

#[test]
fn a_pair_under_every_option() {
    let scene = oblique();
    let truth = reference(&scene);
    let normal = truth.normal.to_array();
    let area =
        std::f64::consts::PI * truth.penetration / (truth.curvature_a * truth.curvature_b).sqrt();
    let all: Vec<&str> = OPTIONS.iter().map(|(word, _)| *word).collect();
    for model in [
        "nfd tangential tfd surface ellipsoid",
        "nfd tangential tfd rolling_friction cdt surface ellipsoid",
        "hertz tangential history surface ellipsoid",
    ] {
        let (outcome, found) = rows(&scene, deck(model), "pair/gran/local", &all, model, 1);
        assert_eq!(found.len(), 1, "{model}");
        let row = &found[0];
        let near = |word: &str, truth: &[f64], size: f64| {
            for (a, b) in row[word].iter().zip(truth) {
                assert!(
                    (a - b).abs() < 1e-6 * size,
                    "{model}, {word}: {:?}, {truth:?}",
                    row[word]
                );
            }
        };
        near("delta", &[truth.penetration], truth.penetration);
        near("contactPoint", &truth.contact_point.to_array(), 1e-3);
        near("contactArea", &[area], area);
        // force and torque are those on the particle that the row names first
        let first = row["id"][0] as usize - 1;
        let state = &outcome.last().states[first];
        let (force, torque) = (vector(&row["force"]), vector(&row["torque"]));
        assert!(
            length(sub(force, state.force)) < 1e-2 * length(force),
            "{model}"
        );
        assert!(
            length(sub(torque, state.torque)) < 1e-2 * length(torque),
            "{model}"
        );
        for (whole, along, across) in [
            (force, "force_normal", "force_tangential"),
            (torque, "torque_normal", "torque_tangential"),
        ] {
            let part = scale(dot(whole, normal), normal);
            near(along, &part, length(whole));
            near(across, &sub(whole, part), length(whole));
        }
        // the moment of the force at the contact point is the torque, but for rolling friction
        if model.contains("history") && !model.contains("rolling") {
            let arm = sub(vector(&row["contactPoint"]), scene.grains[first].position);
            assert!(length(sub(cross(arm, force), torque)) < 1e-5 * length(torque));
        }
        assert_eq!(
            vector(&row["pos"]).map(|v| (v * 1e9).round()),
            scene.grains[first].position.map(|v| (v * 1e9).round())
        );
    }
}

/// One option alone and pairs of them, which LIGGGHTS read from outside the history.
#[test]
fn few_options() {
    let scene = oblique();
    let truth = reference(&scene);
    for options in [
        vec!["delta"],
        vec!["contactPoint"],
        vec!["contactPoint", "delta"],
        vec!["delta", "force_normal"],
    ] {
        for model in [
            "nfd surface ellipsoid",
            "nfd tangential tfd surface ellipsoid",
        ] {
            let name = format!("{model} {}", options.join("_"));
            let (_, found) = rows(&scene, deck(model), "pair/gran/local", &options, &name, 1);
            assert_eq!(found.len(), 1);
            if let Some(delta) = found[0].get("delta") {
                assert!((delta[0] - truth.penetration).abs() < 1e-6 * truth.penetration);
            }
            if let Some(point) = found[0].get("contactPoint") {
                let point = sub(vector(point), truth.contact_point.to_array());
                assert!(length(point) < 1e-9);
            }
        }
    }
}

/// Many contacts over several ranks: each has its own row, which its identifiers name.
#[test]
fn rows_belong_to_their_contacts() {
    let mut scene = crate::harness::crowd(27);
    for grain in &mut scene.grains {
        grain.velocity = [0.0; 3];
        grain.angular_momentum = [0.0; 3];
        grain.semi_axes = scale(1.25, grain.semi_axes);
    }
    let options = ["id", "force", "force_normal", "delta", "contactArea"];
    let by_pair = |ranks: usize| {
        let mut deck = deck("nfd surface ellipsoid");
        deck.materials = vec![ELASTIC];
        let (outcome, found) = rows(
            &scene,
            deck,
            "pair/gran/local",
            &options,
            &format!("{ranks}"),
            ranks,
        );
        let mut sums = vec![[0.0; 3]; scene.grains.len()];
        let mut pairs = vec![];
        for row in &found {
            let (i, j) = (row["id"][0] as usize, row["id"][1] as usize);
            let force = vector(&row["force"]);
            // frictionless and elastic: nearly all along the normal, but for the gradient's terms through the curvatures
            let rest = length(sub(force, vector(&row["force_normal"])));
            assert!(
                rest < 0.3 * length(force),
                "{rest:e} of {:e}",
                length(force)
            );
            for k in 0..3 {
                sums[i - 1][k] += force[k];
                sums[j - 1][k] -= force[k];
            }
            pairs.push((i.min(j), i.max(j), row["delta"][0], row["contactArea"][0]));
        }
        for (sum, state) in sums.iter().zip(&outcome.last().states) {
            assert!(length(sub(*sum, state.force)) < 1e-6 * (1.0 + length(state.force)));
        }
        pairs.sort_by(|a, b| (a.0, a.1, a.2).partial_cmp(&(b.0, b.1, b.2)).unwrap());
        pairs
    };
    let one = by_pair(1);
    assert!(one.len() > 20, "{} contacts", one.len());
    let two = by_pair(2);
    assert_eq!(one.len(), two.len());
    for (a, b) in one.iter().zip(&two) {
        assert_eq!((a.0, a.1), (b.0, b.1));
        assert!((a.2 - b.2).abs() < 1e-12 && (a.3 - b.3).abs() < 1e-9 * a.3);
    }
}

#[test]
fn a_wall_under_every_option() {
    let axes = [4e-3, 3e-3, 2e-3];
    let overlap = 2e-5;
    let grain = Grain {
        density: 2500.0,
        ..Grain::new(axes, [0.0113, 0.0071, axes[2] - overlap])
    }
    .moving([0.1, 0.0, 0.0]);
    let scene = Scene::open(0.2, vec![grain.clone()]);
    let mut deck = deck("nfd tangential tfd surface ellipsoid");
    deck.before
        .push("fix sheet all mesh/surface file sheet.stl type 1".into());
    deck.walls = vec!["mesh n_meshes 1 meshes sheet".into()];
    let all: Vec<&str> = OPTIONS.iter().map(|(word, _)| *word).collect();
    let (outcome, found) = rows(&scene, deck, "wall/gran/local", &all, "wall", 1);
    assert_eq!(found.len(), 1);
    let row = &found[0];
    let close = |a: f64, b: f64, size: f64| assert!((a - b).abs() < 1e-6 * size, "{a:e}, {b:e}");
    close(row["delta"][0], overlap, overlap);
    let area = 2.0 * std::f64::consts::PI * overlap * axes[0] * axes[1] / axes[2];
    close(row["contactArea"][0], area, area);
    // equal moduli share the penetration
    for (a, b) in row["contactPoint"]
        .iter()
        .zip([0.0113, 0.0071, -0.5 * overlap])
    {
        close(*a, b, 1e-3);
    }
    let (force, state) = (vector(&row["force"]), &outcome.last().states[0]);
    assert!(length(sub(force, state.force)) < 1e-2 * length(force));
    close(row["force_normal"][2], force[2], force[2]);
    close(
        length(vector(&row["force_tangential"])),
        force[0].hypot(force[1]),
        force[2],
    );
    close(row["torque_normal"][2], row["torque"][2], force[2] * 1e-3);
}
