// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do contacts go on where grains are deleted? `delete_atoms` gives all others new IDs, if it is not told `compress no`, and so does
//! `fix insert/... compress_tags yes`, and contacts are remembered by ID. `delete_atoms` reads the neighbour list of the last run, also where
//! grains have left their places in it.

use crate::commands::{DISTRIBUTION, TEMPLATE};
use crate::harness::{crowd, run, Deck, Engine, Frame, Grain, Scene};
use crate::shapes::scale;

const HALF: u64 = 150;
/// Grains of the crowd that are deleted: neither first nor last, so that IDs change on either side of others that are kept.
const GONE: [&str; 2] = ["2 9:11", "40"];

/// Position and velocity of each grain, in an order that IDs do not decide.
type Grains = Vec<[f64; 6]>;

/// How the grains are deleted: in one command or in two, and what stands before the first and between.
struct Deletion {
    compress: &'static str,
    twice: bool,
    before: &'static [&'static str],
    between: &'static [&'static str],
}

const KEPT: Deletion = Deletion {
    compress: "no",
    twice: false,
    before: &[],
    between: &[],
};

fn end(engine: &Engine, scene: &Scene, plain: &Deck, deletion: &Deletion, ranks: usize) -> Grains {
    let compress = deletion.compress;
    // IDs of before the first of them
    let mut runs = vec![
        format!("run {HALF}"),
        format!("group first id {}", GONE[0]),
        format!("group second id {}", GONE[1]),
    ];
    runs.extend(deletion.before.iter().map(|c| (*c).to_string()));
    if deletion.twice {
        runs.push(format!("delete_atoms group first compress {compress}"));
        runs.extend(deletion.between.iter().map(|c| (*c).to_string()));
        runs.push(format!("delete_atoms group second compress {compress}"));
    } else {
        runs.push("group gone union first second".into());
        runs.push(format!("delete_atoms group gone compress {compress}"));
    }
    runs.push(format!("run {HALF}"));
    let deck = Deck {
        runs,
        ..plain.clone()
    };
    let outcome = run(engine, "deleted_grains", scene, &deck, ranks);
    grains_of(outcome.last())
}

fn grains_of(frame: &Frame) -> Grains {
    let mut grains: Grains = (frame.states.iter())
        .map(|s| {
            let (x, v) = (s.position, s.velocity);
            [x[0], x[1], x[2], v[0], v[1], v[2]]
        })
        .collect();
    grains.sort_by(|a, b| a[0].total_cmp(&b[0]));
    grains
}

/// The largest difference of positions or of velocities, over the largest of them.
fn apart(a: &Grains, b: &Grains) -> f64 {
    assert_eq!(a.len(), b.len());
    let largest =
        |values: &mut dyn Iterator<Item = f64>| values.fold(0.0f64, |m, x| m.max(x.abs()));
    [0, 3]
        .map(|first| {
            let of = first..first + 3;
            let scale = largest(&mut b.iter().flat_map(|g| g[of.clone()].to_vec()));
            let pairs = a.iter().zip(b);
            largest(
                &mut pairs.flat_map(|(a, b)| of.clone().map(|c| a[c] - b[c]).collect::<Vec<_>>()),
            ) / scale
        })
        .into_iter()
        .fold(0.0, f64::max)
}

/// Most grains touch another one, those whose places in the arrays change too.
fn dense() -> Scene {
    let mut scene = crowd(64);
    for grain in &mut scene.grains {
        grain.semi_axes = scale(1.2, grain.semi_axes);
    }
    scene
}

fn elastic(model: &str, integrator: &'static str) -> Deck {
    Deck {
        model: model.into(),
        time_step: 1e-5,
        steps: HALF,
        integrator,
        ..Deck::new([1e8, 0.3, 0.0, 0.0], 0.5)
    }
}

#[test]
fn contacts_go_on_where_grains_are_deleted() {
    let engine = Engine::from_environment();
    let scene = dense();
    let deck = elastic("nfd tangential tfd surface ellipsoid", "ellipsoid");
    let kept = end(&engine, &scene, &deck, &KEPT, 1);
    assert_eq!(kept.len(), 59);
    for (compress, twice, before, between, ranks) in [
        ("yes", false, &[][..], &[][..], 1),
        ("yes", false, &[][..], &[][..], 2),
        ("yes", true, &[][..], &[][..], 1),
        ("no", true, &[][..], &[][..], 1),
        // Grains go to other ranks, and those that are gone leave IDs to others twice.
        (
            "yes",
            true,
            &["write_restart first.restart"][..],
            &["write_restart second.restart"][..],
            4,
        ),
        (
            "no",
            false,
            &["write_restart first.restart"][..],
            &[][..],
            4,
        ),
    ] {
        let deletion = Deletion {
            compress,
            twice,
            before,
            between,
        };
        let found = end(&engine, &scene, &deck, &deletion, ranks);
        let apart = apart(&found, &kept);
        println!(
            "compress {compress}, twice {twice}, {before:?}, {ranks} ranks: apart by {apart:.1e}"
        );
        assert!(
            apart < 1e-10,
            "compress {compress}, twice {twice}, {before:?}, {ranks} ranks: {apart:e}"
        );
    }
}

/// LIGGGHTS' own models on ellipsoids, and ours on spheres.
#[test]
fn contacts_of_other_models_go_on() {
    let engine = Engine::from_environment();
    let renumbered = Deletion {
        compress: "yes",
        ..KEPT
    };
    let ellipsoids = dense();
    let mut spheres = ellipsoids.clone();
    for grain in &mut spheres.grains {
        grain.semi_axes = [1.3e-2; 3];
    }
    for (scene, deck) in [
        (
            &ellipsoids,
            elastic("hertz tangential history surface ellipsoid", "superquadric"),
        ),
        (
            &spheres,
            Deck {
                atom_style: "sphere".into(),
                ..elastic("nfd tangential tfd surface default", "")
            },
        ),
    ] {
        let [found, kept] = [&renumbered, &KEPT].map(|d| end(&engine, scene, &deck, d, 1));
        let apart = apart(&found, &kept);
        println!("{}: apart by {apart:.1e}", deck.model);
        assert!(apart < 1e-10, "{}: {apart:e}", deck.model);
    }
}

/// Grains that come while others touch, and give all of them other IDs in the middle of a run.
#[test]
fn contacts_go_on_where_grains_are_inserted() {
    let engine = Engine::from_environment();
    let mut scene = dense();
    scene.boundary = "p p f".into();
    scene.low[2] -= 0.03;
    scene.high[2] += 0.06;
    let end = |tags: &str, ranks: usize| {
        let insertion = format!(
            "fix ins all insert/rate/region seed 32452843 distributiontemplate pd nparticles 40 particlerate 20000 insert_every 50 overlapcheck yes orientation random vel constant 0 0 0.5 compress_tags {tags} all_in yes region fill"
        );
        let region = "region fill block 0 0.096 0 0.096 0.135 0.15 units box";
        let deck = Deck {
            fixes: [TEMPLATE, DISTRIBUTION, region, &insertion]
                .map(String::from)
                .into(),
            steps: 2 * HALF,
            ..elastic("nfd tangential tfd surface ellipsoid", "ellipsoid")
        };
        grains_of(run(&engine, "inserted_grains", &scene, &deck, ranks).last())
    };
    let kept = end("no", 2);
    assert_eq!(kept.len(), 64 + 40);
    let apart = apart(&end("yes", 2), &kept);
    println!("apart by {apart:.1e}");
    assert!(apart < 1e-10, "{apart:e}");
}

/// A grain that comes between two runs gets the ID of one that is gone, if that was the largest. It has touched nothing yet.
#[test]
fn a_new_grain_does_not_remember_what_one_of_its_id_did() {
    let engine = Engine::from_environment();
    let place = [0.0, 0.0, 2.95e-3];
    let grain = |z: f64| Grain {
        density: 2500.0,
        ..Grain::new([5e-3, 4e-3, 3e-3], [0.0, 0.0, z])
    };
    let scene = Scene::open(
        0.1,
        vec![grain(-place[2]), grain(place[2]).moving([0.5, 0.0, 0.0])],
    );
    let force = |before: &[&str]| {
        let mut runs = vec![
            "run 20",
            "group two id 2",
            "delete_atoms group two compress no",
        ];
        runs.extend(before);
        runs.extend([
            "create_atoms 1 single 0 0 2.95e-3 units box",
            "group new id 2 3",
            "set group new blockiness 2 2",
            "set group new shape 5e-3 4e-3 3e-3",
            "set group new density 2500",
            "run 1",
        ]);
        let deck = Deck {
            runs: runs.into_iter().map(String::from).collect(),
            time_step: 1e-6,
            steps: 20,
            dump_every: 1,
            ..elastic("nfd tangential tfd surface ellipsoid", "ellipsoid")
        };
        run(&engine, "new_grain", &scene, &deck, 1).last().states[0].force
    };
    // One that is far away takes the ID.
    let [taken, other] = [&[][..], &["create_atoms 1 single 0.05 0.05 0.05 units box"]].map(force);
    println!("{taken:?} {other:?}");
    assert!(other[2] < 0.0);
    assert!((0..3).all(|k| (taken[k] - other[k]).abs() < 1e-9 * other[2].abs()));
}
