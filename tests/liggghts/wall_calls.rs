// SPDX-License-Identifier: MIT OR Apache-2.0
//! All contacts with a wall in one call, to their forces, and LIGGGHTS' own contact model contact by contact: is the motion the same?
//!
//! A fix that stores the forces of its wall leaves the contacts to LIGGGHTS' own model.

use std::fs;

use crate::decomposition::difference;
use crate::harness::{fresh_directory, run_in, Deck, Engine, Grain, Outcome, Scene, ELASTIC};
use crate::meshes::sheet;
use crate::shapes::{add, scale, Random, Vector};

/// Grains that do not meet, thrown down on the plane z = 0, in places of a square of 0.1 m.
fn thrown(turn: impl Fn(Vector) -> Vector) -> Scene {
    let mut random = Random(5);
    let mut grains = vec![];
    for k in 0..16 {
        let place = [(k % 4) as f64 - 1.5, (k / 4) as f64 - 1.5, 0.0];
        let mut axes = [6e-3, 4e-3, 3e-3];
        axes.rotate_left(k % 3);
        if k % 4 == 0 {
            axes = [5e-3, 3e-3, 3e-3];
        }
        let place = add(scale(0.024, place), [0.001, 0.002, 6.5e-3]);
        let grain = Grain {
            density: 2500.0,
            kind: 1 + k % 2,
            ..Grain::new(axes, turn(place)).turned(random.quaternion())
        };
        let down = turn([random.between(-0.3, 0.3), random.between(-0.3, 0.3), -1.0]);
        let spin = scale(random.between(5.0, 40.0), random.direction());
        grains.push(grain.moving(down).spinning(spin));
    }
    Scene {
        kinds: 2,
        ..Scene::open(0.2, grains)
    }
}

fn deck(model: &str, wall: &str) -> Deck {
    Deck {
        model: model.into(),
        time_step: 4e-6,
        steps: 2000,
        dump_every: 500,
        materials: vec![[1e7, 0.3, 100.0, 150.0], [3e6, 0.2, 50.0, 30.0]],
        walls: vec![wall.into()],
        fixes: vec!["fix weight all gravity 200 vector 0 0 -1".into()],
        ..Deck::new(ELASTIC, 0.5)
    }
}

/// Runs a deck in one call a step, and with the contacts one by one; the largest difference of velocities in a frame.
fn apart(engine: &Engine, name: &str, scene: &Scene, deck: &Deck) -> (f64, Outcome) {
    let directory = fresh_directory(name);
    fs::write(directory.join("sheet.stl"), sheet(12)).unwrap();
    fs::write(directory.join("coarse.stl"), sheet(3)).unwrap();
    let stored = Deck {
        walls: deck
            .walls
            .iter()
            .map(|w| format!("{w} store_force yes"))
            .collect(),
        ..deck.clone()
    };
    let one_call = run_in(engine, &directory, scene, deck, 1);
    let one_by_one = run_in(engine, &directory, scene, &stored, 1);
    let touched = |o: &Outcome| {
        let states = o.last().states.iter().zip(&scene.grains);
        states
            .filter(|(s, g)| s.angular_velocity != crate::harness::angular_velocity(g))
            .count()
    };
    assert!(touched(&one_call) >= 12, "{name}: too few have touched");
    let frames = one_call.frames.iter().zip(&one_by_one.frames);
    let worst = frames.map(|(a, b)| difference(a, b)).fold(0.0, f64::max);
    println!(
        "{name}: {} grains have touched; velocities apart by {worst:.1e}",
        touched(&one_call)
    );
    (worst, one_call)
}

/// Bounces make rounding grow: to 3e-13 in these.
const TOLERANCE: f64 = 1e-11;

#[test]
fn one_call_moves_the_grains_as_one_contact_after_the_other() {
    let engine = Engine::from_environment();
    let floor = thrown(|v| v);
    let mesh = |fix: &str| Deck {
        before: vec!["fix sheet all mesh/surface file sheet.stl type 1".into()],
        fixes: vec![
            "fix weight all gravity 200 vector 0 0 -1".into(),
            fix.into(),
        ],
        ..deck(MODEL, "mesh n_meshes 1 meshes sheet")
    };
    const MODEL: &str = "nfd tangential tfd surface ellipsoid";
    const DRUM: &str = "primitive type 2 ycylinder 0.05 0.044 0.0";
    let no_friction = "nfd surface ellipsoid";
    let restitution = Deck {
        settings: "restitutionDamping on".into(),
        restitution: vec![0.8, 0.7, 0.7, 0.6],
        ..deck(MODEL, "primitive type 2 zplane 0.0")
    };
    let total = Deck {
        settings: "totalDisplacement on".into(),
        ..deck(MODEL, "primitive type 1 zplane 0.0")
    };
    let step_velocities = Deck {
        integrator: "ellipsoid",
        ..deck(MODEL, "primitive type 1 zplane 0.0")
    };
    let drum_of_step = Deck {
        integrator: "ellipsoid",
        ..deck(MODEL, &format!("{DRUM} shear x 20.0"))
    };
    let decks = [
        ("plane", deck(MODEL, "primitive type 2 zplane 0.0")),
        ("no_friction", deck(no_friction, "primitive type 2 zplane 0.0")),
        ("shear", deck(MODEL, "primitive type 1 zplane 0.0 shear x 0.7")),
        ("restitution", restitution),
        ("total", total),
        ("step", step_velocities),
        ("drum", deck(MODEL, DRUM)),
        ("turning_drum", deck(MODEL, &format!("{DRUM} shear x 20.0"))),
        ("turning_drum_step", drum_of_step),
        ("drum_along_itself", deck(MODEL, &format!("{DRUM} shear y 0.5"))),
        ("rod", deck(MODEL, "primitive type 1 ycylinder 0.05 -0.05 0.0 shear x 20.0")),
        ("mesh", mesh("")),
        ("mesh_in_motion", mesh("fix moved all move/mesh mesh sheet linear 0.3 0.2 0.1")),
        (
            "turning_mesh",
            mesh("fix turned all move/mesh mesh sheet rotate origin 0. 0. 0. axis 0. 0. 1. period 0.1"),
        ),
    ];
    for (name, deck) in decks {
        let (worst, _) = apart(&engine, name, &floor, &deck);
        assert!(worst < TOLERANCE, "{name}");
        // Two ways that round apart: were the bits the same it would be one.
        assert!(worst > 0.0, "{name}: the same way twice");
    }
}

/// On four ranks, and over a restart, in which the other way may go on.
#[test]
fn ranks_and_restarts_go_on_either_way() {
    let engine = Engine::from_environment();
    let scene = thrown(|v| v);
    const MODEL: &str = "nfd tangential tfd surface ellipsoid";
    let two_meshes = Deck {
        before: vec![
            "fix sheet all mesh/surface file sheet.stl type 2".into(),
            "fix coarse all mesh/surface file coarse.stl type 2 move 0. 0. -0.001".into(),
        ],
        ..deck(MODEL, "mesh n_meshes 2 meshes sheet coarse")
    };
    let decks = [
        (
            "of_plane",
            deck(MODEL, "primitive type 1 zplane 0.0 shear x 0.7"),
        ),
        (
            "of_drum",
            deck(
                MODEL,
                "primitive type 2 ycylinder 0.05 0.044 0.0 shear x 20.0",
            ),
        ),
        ("of_meshes", two_meshes),
    ];
    for (name, deck) in decks {
        let (_, through) = apart(&engine, name, &scene, &deck);
        let directory = &through.directory;
        let four = run_in(&engine, directory, &scene, &deck, 4);
        let over_ranks = difference(four.last(), through.last());
        println!("{name}: four ranks and one apart by {over_ranks:.1e}");
        assert!(over_ranks < 1e-12, "{name}");
        let halves = Deck {
            runs: vec![
                "run 1000".into(),
                "write_restart half".into(),
                "run 1000".into(),
            ],
            ..deck.clone()
        };
        let whole = run_in(&engine, directory, &scene, &halves, 1);
        for store in ["no", "yes"] {
            let rest = Deck {
                source: vec!["read_restart half".into()],
                walls: vec![format!("{} store_force {store}", deck.walls[0])],
                runs: vec!["run 1000".into()],
                ..deck.clone()
            };
            let again = run_in(&engine, directory, &scene, &rest, 1);
            let after = difference(again.last(), whole.last());
            println!("{name}: after a restart apart by {after:.1e}");
            assert!(
                after < if store == "no" { 1e-12 } else { TOLERANCE },
                "{name}"
            );
        }
    }
}
