// SPDX-License-Identifier: MIT OR Apache-2.0
//! Walls of every kind on tiles as on bricks; history of pairs and walls where other grains are deleted or carried away.

use std::f64::consts::TAU;

use crate::harness::{
    attempt_in, fresh_directory, largest_difference, run, Deck, Engine, Frame, Grain, Scene,
};
use crate::mesh_walls::{binary, Triangle};
use crate::moving_walls::{load, LAW};
use crate::shapes::{length, sub, Random};

/// A closed drum about x of 24 sides, as wide as the cylinder in their middles.
fn drum() -> Vec<Triangle> {
    let sides = 24;
    let outer = 0.03 / (0.5 * TAU / sides as f64).cos();
    let at = |x: f64, k: usize| {
        let (sin, cos) = (TAU * k as f64 / sides as f64).sin_cos();
        [x, outer * cos, outer * sin]
    };
    (0..sides)
        .flat_map(|k| {
            let [a, b, c, d] = [at(-0.02, k), at(0.02, k), at(0.02, k + 1), at(-0.02, k + 1)];
            let ends = [-0.02, 0.02].map(|x| [[x, 0.0, 0.0], at(x, k), at(x, k + 1)]);
            [[a, b, c], [a, c, d], ends[0], ends[1]]
        })
        .collect()
}

#[test]
fn both_versions_walls_are_the_same_on_tiles_and_bricks() {
    let engine = Engine::from_environment();
    let scene = load();
    let wall = |words: &str| format!("all wall/gran/ellipsoid {LAW} {words}");
    for (name, walls) in [
        (
            "planes and cylinder",
            vec![
                format!(
                    "fix shell {}",
                    wall("xcylinder 0.03 rotate 0 0 0 1 0 0 0.4")
                ),
                format!("fix ends {}", wall("xplane -0.02 0.02")),
            ],
        ),
        (
            "region",
            vec![
                "region drum cylinder x 0 0 0.03 -0.02 0.02".into(),
                format!("fix shell {}", wall("region drum rotate 0 0 0 1 0 0 0.4")),
            ],
        ),
        (
            "mesh",
            vec![format!(
                "fix shell {}",
                wall("mesh drum.stl rotate 0 0 0 1 0 0 0.4")
            )],
        ),
    ] {
        let frames = [("brick", 1), ("brick", 4), ("tiled", 4)].map(|(style, ranks)| {
            let mut fixes = walls.clone();
            fixes.push("fix fall all gravity 98.1 vector 0 0 -1".into());
            if ranks > 1 {
                let way = if style == "tiled" {
                    "rcb"
                } else {
                    "shift yz 5 1.05"
                };
                fixes.push(format!("fix even all balance 50 1.05 {way}"));
            }
            let deck = Deck {
                before_data: vec![format!("comm_style {style}")],
                fixes,
                time_step: 2e-5,
                steps: 800,
                skin: 1e-3,
                ..Deck::new(LAW)
            };
            let directory =
                fresh_directory(&format!("tiles_{}_{style}_{ranks}", name.replace(' ', "_")));
            std::fs::write(directory.join("drum.stl"), binary(&drum())).unwrap();
            let outcome = attempt_in(&engine, directory, &scene, &deck, ranks).succeeded();
            outcome.last().clone()
        });
        let moved = frames[0].states.iter().zip(&scene.grains);
        let moved = moved
            .filter(|(s, g)| length(sub(s.position, g.position)) > 1e-3)
            .count();
        for other in &frames[1..] {
            let (position, velocity) = largest_difference(&frames[0], other);
            println!("{name}: {moved} moved; position {position:.1e}, velocity {velocity:.1e}");
            assert!(position < 1e-9 && velocity < 1e-6, "{name}");
        }
        assert!(moved == scene.grains.len(), "{name}");
    }
}

/// Two heaps that slide on a plane with friction, far from each other; the odd ids are of the second.
fn heaps() -> Vec<Grain> {
    let mut random = Random(31);
    (0..24)
        .map(|k| {
            let (heap, m) = (k % 2, k / 2);
            let place = [m % 2, m / 2 % 2, m / 4].map(|c| c as f64);
            let x = if heap == 0 { -0.02 } else { 0.02 };
            Grain {
                density: 2500.0,
                ..Grain::new(
                    [4e-3, 3e-3, 2.5e-3],
                    [
                        x + 6.2e-3 * (place[0] - 0.5),
                        6.2e-3 * (place[1] - 0.5),
                        3.2e-3 + 6.2e-3 * place[2],
                    ],
                )
            }
            .turned(random.quaternion())
            .moving([0.0, 0.05, 0.0])
        })
        .collect()
}

/// Deleted, with ids given anew or not, or set far away: what is left goes on as if the others had never been there.
#[test]
fn both_versions_history_is_kept_where_other_grains_are_deleted_or_carried_away() {
    let engine = Engine::from_environment();
    let all = heaps();
    let first: Vec<Grain> = all.iter().step_by(2).cloned().collect();
    let deck = |change: &[&str]| {
        let mut runs = vec!["run 1500".to_string()];
        runs.extend(change.iter().map(|c| c.to_string()));
        runs.push("run 1500".into());
        Deck {
            fixes: vec![
                format!("fix floor all wall/gran/ellipsoid {LAW} zplane 0 NULL"),
                "fix fall all gravity 9.81 vector 0 0 -1".into(),
                "group right id 2:24:2".into(),
            ],
            time_step: 2e-5,
            dump_every: 3000,
            skin: 1e-3,
            runs,
            ..Deck::new(LAW)
        }
    };
    let mut alone = deck(&[]);
    alone.fixes.pop();
    let alone = run(&engine, "heap_alone", &Scene::open(0.06, first), &alone, 1);
    // a frame of the same grains, whatever their ids are
    let same = |frame: &Frame| Frame {
        step: frame.step,
        states: (alone.last().states.iter())
            .map(|a| {
                let gap = |s: &crate::harness::State| length(sub(s.position, a.position));
                let nearest = frame.states.iter().min_by(|s, t| gap(s).total_cmp(&gap(t)));
                nearest.unwrap().clone()
            })
            .collect(),
    };
    for (name, change) in [
        ("nothing", &[][..]),
        ("deleted", &["delete_atoms group right compress no"]),
        (
            "deleted and numbered anew",
            &["delete_atoms group right compress yes"],
        ),
        (
            "carried away",
            &["variable up atom z+0.04", "set group right z v_up"],
        ),
    ] {
        for ranks in [1, 2] {
            let scene = Scene::open(0.06, all.clone());
            let place = format!("heaps_{}_{ranks}", name.replace(' ', "_"));
            let outcome = run(&engine, &place, &scene, &deck(change), ranks);
            let (position, velocity) = largest_difference(&same(outcome.last()), alone.last());
            println!("{name} on {ranks}: position {position:.1e}, velocity {velocity:.1e}");
            assert!(position < 1e-9 && velocity < 1e-6, "{name} on {ranks}");
        }
    }
    // Without its history the heap goes on otherwise: what is compared above sees it.
    let forgetful = Deck {
        runs: vec![
            "run 1500".into(),
            "unfix floor".into(),
            format!("fix floor all wall/gran/ellipsoid {LAW} zplane 0 NULL"),
            "run 1500".into(),
        ],
        ..deck(&[])
    };
    let outcome = run(
        &engine,
        "heaps_forgetful",
        &Scene::open(0.06, all.clone()),
        &forgetful,
        1,
    );
    let (position, _) = largest_difference(&same(outcome.last()), alone.last());
    println!("without the history of the wall: position {position:.1e}");
    assert!(position > 1e-8);
}
