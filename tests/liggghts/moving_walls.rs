// SPDX-License-Identifier: MIT OR Apache-2.0
//! Walls that move: is a moving wall the same as a resting one seen by whoever moves along, and does a turning one rub along its way?

use std::fs;

use crate::decomposition::difference;
use crate::harness::{
    attempt_in, fresh_directory, run_in, Deck, Engine, Grain, Outcome, Scene, ELASTIC,
};
use crate::mesh_ranks::{on_a_sheet, sheet_deck};
use crate::meshes::sheet;
use crate::shapes::{about, add, compose, cross, dot, length, rotate, scale, sub, unit, Vector};

const FRICTION: f64 = 0.5;

fn grain(position: Vector) -> Grain {
    Grain {
        density: 2500.0,
        ..Grain::new([5e-3, 3e-3, 2e-3], position)
    }
}

fn deck(wall: &str) -> Deck {
    Deck {
        time_step: 2e-6,
        steps: 6000,
        dump_every: 200,
        materials: vec![[1e7, 0.3, 100.0, 100.0]],
        walls: vec![wall.into()],
        ..Deck::new(ELASTIC, FRICTION)
    }
}

fn run(engine: &Engine, name: &str, scene: &Scene, deck: &Deck) -> Outcome {
    let directory = fresh_directory(name);
    fs::write(directory.join("sheet.stl"), sheet(24)).unwrap();
    run_in(engine, &directory, scene, deck, 1)
}

/// Runs a grain against a wall that moves with `speed`, and against the wall at rest with the grain moving the other way: the
/// largest difference of velocities and spins, over the largest speed and spin.
fn as_seen_from_the_wall(
    name: &str,
    scene: &Scene,
    speed: Vector,
    moving: &Deck,
    resting: &Deck,
) -> f64 {
    let engine = Engine::from_environment();
    let mut other = scene.clone();
    for grain in &mut other.grains {
        grain.velocity = sub(grain.velocity, speed);
    }
    let moving = run(&engine, &format!("{name}_moving"), scene, moving);
    let resting = run(&engine, &format!("{name}_resting"), &other, resting);
    let mut worst = 0.0f64;
    let mut changes = 0.0f64;
    let start = moving.first().states[0].velocity;
    let size = resting
        .frames
        .iter()
        .map(|f| length(f.states[0].angular_velocity))
        .fold(0.0, f64::max);
    for (a, b) in moving.frames.iter().zip(&resting.frames) {
        let (p, q) = (&a.states[0], &b.states[0]);
        let velocity = length(sub(sub(p.velocity, speed), q.velocity)) / length(speed);
        let spin = length(sub(p.angular_velocity, q.angular_velocity)) / size;
        worst = worst.max(velocity).max(spin);
        changes = changes.max(length(sub(p.velocity, start)));
    }
    println!("{name}: velocity changed by {changes:.2} m/s; moving and resting wall apart by {worst:.1e}");
    assert!(changes > 0.2, "{name}: no contact");
    worst
}

fn falling() -> Scene {
    let grain = grain([0.001, 0.002, 6e-3])
        .turned(about([0.3, 1.0, 0.2], 0.9))
        .moving([0.2, -0.1, -0.6])
        .spinning([10.0, -20.0, 30.0]);
    Scene::open(0.2, vec![grain])
}

#[test]
fn a_mesh_that_moves_straight() {
    let mesh = Deck {
        before: vec!["fix sheet all mesh/surface file sheet.stl type 1".into()],
        ..deck("mesh n_meshes 1 meshes sheet")
    };
    for (name, speed) in [
        ("along", [0.5, 0.3, 0.0]),
        ("across", [0.2, 0.1, 0.4]),
        ("away", [-0.3, 0.0, -0.3]),
    ] {
        let [x, y, z] = speed;
        let moving = Deck {
            fixes: vec![format!(
                "fix moved all move/mesh mesh sheet linear {x} {y} {z}"
            )],
            ..mesh.clone()
        };
        let apart = as_seen_from_the_wall(name, &falling(), speed, &moving, &mesh);
        // places are rounded apart, and a bounce makes the difference grow
        assert!(apart < 1e-9, "{name}");
    }
}

#[test]
fn planes_and_cylinders_with_shear_along_themselves() {
    for (name, wall, shear, speed) in [
        ("plane_x", "zplane 0.0", "x 0.5", [0.5, 0.0, 0.0]),
        ("plane_y", "zplane 0.0", "y -0.4", [0.0, -0.4, 0.0]),
        (
            "cylinder_x",
            "xcylinder 0.02 0.001 0.0205",
            "x 0.5",
            [0.5, 0.0, 0.0],
        ),
        (
            "cylinder_y",
            "ycylinder 0.02 0.0205 0.002",
            "y 0.5",
            [0.0, 0.5, 0.0],
        ),
    ] {
        let wall = format!("primitive type 1 {wall}");
        let apart = as_seen_from_the_wall(
            name,
            &falling(),
            speed,
            &deck(&format!("{wall} shear {shear}")),
            &deck(&wall),
        );
        assert!(apart < 1e-9, "{name}");
    }
}

/// Force of friction of a grain that is pressed against a wall which has turned past it from the start: over the normal force, and
/// its direction beside that of the wall's velocity at the contact.
fn rubbed(outcome: &Outcome, normal: Vector, weight: Vector, velocity: Vector) -> (f64, f64) {
    let wall = sub(outcome.last().states[0].force, weight);
    let along = dot(wall, normal);
    let friction = sub(wall, scale(along, normal));
    (
        length(friction) / along,
        dot(unit(friction), unit(velocity)),
    )
}

#[test]
fn a_turning_mesh_rubs_along_its_way() {
    let engine = Engine::from_environment();
    let (x, y) = (0.02, -0.03);
    let grain = grain([x, y, 2e-3]);
    let weight = [0.0, 0.0, -9.81 * grain.mass()];
    let scene = Scene::open(0.2, vec![grain]);
    let turning = Deck {
        before: vec!["fix sheet all mesh/surface file sheet.stl type 1".into()],
        fixes: vec![
            "fix weight all gravity 9.81 vector 0 0 -1".into(),
            "fix turned all move/mesh mesh sheet rotate origin 0. 0. 0. axis 0. 0. 1. period 0.5"
                .into(),
        ],
        steps: 1500,
        ..deck("mesh n_meshes 1 meshes sheet")
    };
    let outcome = run(&engine, "turning", &scene, &turning);
    let (coefficient, direction) = rubbed(
        &outcome,
        [0.0, 0.0, 1.0],
        weight,
        cross([0.0, 0.0, 1.0], [x, y, 0.0]),
    );
    println!("turning mesh: friction {coefficient:.6} of the normal force, cosine to its way {direction:.6}");
    assert!((coefficient - FRICTION).abs() < 1e-6 && direction > 0.999);
}

/// The same drum about x, y and z: a grain on its wall, pressed against it, dragged along by it.
#[test]
fn a_turning_cylinder_drags_along_whatever_its_axis() {
    let engine = Engine::from_environment();
    let third = std::f64::consts::TAU / 3.0;
    let mut forces: Vec<Vector> = vec![];
    let mut torques: Vec<Vector> = vec![];
    for (k, (style, shear)) in [("zcylinder", "x"), ("xcylinder", "y"), ("ycylinder", "z")]
        .into_iter()
        .enumerate()
    {
        // x to y, y to z, z to x, as many times as the axis asks for
        let turn = about([1.0, 1.0, 1.0], third * k as f64);
        let axis = rotate(turn, [0.0, 0.0, 1.0]);
        let centre = [0.002, -0.003, 0.0];
        let down = [0.6, 0.8, 0.0];
        let place = add(centre, add(scale(0.018 + 1e-7, down), [0.0, 0.0, 0.004]));
        let own = grain(rotate(turn, place)).turned(compose(
            turn,
            // its shortest axis across the wall, its longest along the drum
            compose(
                about([0.0, 0.0, 1.0], down[1].atan2(down[0])),
                about([0.0, 1.0, 0.0], std::f64::consts::FRAC_PI_2),
            ),
        ));
        let push = scale(9.81, rotate(turn, down));
        let weight = scale(own.mass(), push);
        let [a, b, c] = push;
        let scene = Scene::open(0.1, vec![own]);
        let turning = Deck {
            fixes: vec![format!(
                "fix weight all gravity {} vector {a:e} {b:e} {c:e}",
                length(push)
            )],
            steps: 1500,
            ..deck(&format!(
                "primitive type 1 {style} 0.02 {} {} shear {shear} 20.0",
                centre[0], centre[1]
            ))
        };
        let outcome = run(&engine, style, &scene, &turning);
        let inwards = rotate(turn, scale(-1.0, down));
        let (coefficient, direction) =
            rubbed(&outcome, inwards, weight, cross(axis, rotate(turn, down)));
        println!("{style}: friction {coefficient:.6} of the normal force, cosine to the wall's way {direction:.6}");
        assert!((coefficient - FRICTION).abs() < 2e-3 && direction > 0.999);
        let back = |v: Vector| crate::shapes::unrotate(turn, v);
        forces.push(back(outcome.last().states[0].force));
        torques.push(back(outcome.last().states[0].torque));
    }
    for all in [&forces, &torques] {
        for other in &all[1..] {
            let apart = length(sub(*other, all[0])) / length(all[0]);
            println!("about another axis: apart by {apart:.1e}");
            assert!(apart < 1e-6);
        }
    }
}

/// Forces see the mesh move when a run begins: one that is split, and one that goes on from a file of the middle of a run.
#[test]
fn meshes_move_on_where_a_run_begins() {
    let engine = Engine::from_environment();
    let scene = on_a_sheet();
    let wiggle = "fix m1 all move/mesh mesh sheet wiggle amplitude 0 0 2e-4 period 0.005";
    let turn = "fix m2 all move/mesh mesh sheet rotate origin 0 0 0 axis 0 0 1 period 0.05";
    // which carries along the point about which the other turns
    let away = "fix m0 all move/mesh mesh sheet linear 0.5 0.2 0";
    for (name, moves) in [
        ("carried", &[away, turn][..]),
        ("wiggle", &[wiggle]),
        ("turn", &[turn]),
        ("both", &[wiggle, turn]),
    ] {
        for before_the_wall in [true, false] {
            for (ranks, then) in [(1, 1), (1, 2), (2, 1)] {
                let directory =
                    fresh_directory(&format!("{name}_{before_the_wall}_{ranks}_{then}"));
                fs::write(directory.join("sheet.stl"), sheet(8)).unwrap();
                let run = |source: &[&str], runs: &[&str], ranks: usize| {
                    let mut deck = Deck {
                        integrator: "ellipsoid",
                        source: source.iter().map(|line| line.to_string()).collect(),
                        runs: runs.iter().map(|line| line.to_string()).collect(),
                        ..sheet_deck()
                    };
                    let lines = moves.iter().map(|line| line.to_string());
                    if before_the_wall {
                        deck.before.extend(lines);
                    } else {
                        deck.fixes.extend(lines);
                    }
                    run_in(&engine, &directory, &scene, &deck, ranks)
                };
                let through = run(&[], &["restart 50 middle.*", "run 200"], ranks);
                let split = run(&[], &["run 50", "run 150"], ranks);
                let again = run(&["read_restart middle.50"], &["run 150"], then);
                let apart = [&split, &again].map(|outcome| {
                    assert_eq!(outcome.last().step, 200);
                    difference(outcome.last(), through.last())
                });
                println!(
                    "{name}, before the wall {before_the_wall}, {ranks} ranks, then {then}: apart by {:.1e} split, {:.1e} restarted",
                    apart[0], apart[1]
                );
                assert!(
                    apart.iter().all(|apart| *apart < 1e-10),
                    "{name}: {apart:?}"
                );
            }
        }
    }
}

/// A restart file with what the fix of a moving mesh wrote in its format 1: without the points of motions.
fn in_format_1(file: &[u8]) -> Vec<u8> {
    let number = |at: usize| f64::from_le_bytes(file[at..at + 8].try_into().unwrap());
    let begins = |at: &usize| {
        let size = i32::from_le_bytes(file[*at..*at + 4].try_into().unwrap());
        let [format, triangles, points] = [4, 12, 20].map(|k| number(at + k));
        let values = 3.0 + 10.0 * triangles + 3.0 * points;
        format == 2.0 && triangles > 0.0 && points > 0.0 && f64::from(size) == 8.0 * values
    };
    let places: Vec<usize> = (0..file.len() - 28).filter(begins).collect();
    let [at] = places[..] else {
        panic!("{} places", places.len())
    };
    let triangles = at + 28;
    let points = triangles + 80 * number(at + 12) as usize;
    let size = (16 + points - triangles) as i32;
    [
        &file[..at],
        &size.to_le_bytes(),
        &1f64.to_le_bytes(),
        &file[at + 12..at + 20],
        &file[triangles..points],
        &file[points + 24 * number(at + 20) as usize..],
    ]
    .concat()
}

/// Nothing carries the point of this mesh along, which files of format 1 do not have.
#[test]
fn meshes_move_on_from_files_of_format_1() {
    let engine = Engine::from_environment();
    let scene = on_a_sheet();
    let directory = fresh_directory("format_1");
    fs::write(directory.join("sheet.stl"), sheet(8)).unwrap();
    let run = |source: &[&str], runs: &[&str], ranks: usize| {
        let mut deck = Deck {
            integrator: "ellipsoid",
            source: source.iter().map(|line| line.to_string()).collect(),
            runs: runs.iter().map(|line| line.to_string()).collect(),
            ..sheet_deck()
        };
        deck.fixes.push(
            "fix m2 all move/mesh mesh sheet rotate origin 0 0 0 axis 0 0 1 period 0.05".into(),
        );
        run_in(&engine, &directory, &scene, &deck, ranks)
    };
    let through = run(&[], &["restart 50 middle.*", "run 200"], 1);
    let file = fs::read(directory.join("middle.50")).unwrap();
    fs::write(directory.join("older"), in_format_1(&file)).unwrap();
    for ranks in [1, 2] {
        let again = run(&["read_restart older"], &["run 150"], ranks);
        let apart = difference(again.last(), through.last());
        println!("{ranks} ranks: apart by {apart:.1e}");
        assert!(apart < 1e-10, "{apart:e}");
    }
}

/// LIGGGHTS turns the images of a mesh about the axis of the mesh itself: until lists are built anew they are not where they should be, and a grain on one
/// fell through it.
#[test]
fn a_mesh_that_turns_across_a_periodic_boundary_is_refused() {
    let engine = Engine::from_environment();
    // the sheet, of half width 0.06, reaches a little across a boundary at 0.059, near which is the grain
    let grain = grain([0.004, 0.0585, 1.95e-3]).moving([0.0, 0.0, -0.05]);
    let scene = |boundary: &str| {
        let y = if boundary == "f f f" { 0.12 } else { 0.059 };
        Scene {
            low: [-0.12, -y, -0.02],
            high: [0.12, y, 0.02],
            boundary: boundary.into(),
            ..Scene::open(1.0, vec![grain.clone()])
        }
    };
    let deck = |axis: &str, lists: &str| Deck {
        before: vec![
            "fix sheet all mesh/surface file sheet.stl type 1".into(),
            lists.into(),
        ],
        fixes: vec![format!(
            "fix turned all move/mesh mesh sheet rotate origin 0 0 0 axis {axis} period 0.1"
        )],
        steps: 300,
        dump_every: 0,
        ..deck("mesh n_meshes 1 meshes sheet")
    };
    let end = |name: &str, boundary: &str, deck: &Deck, ranks: usize| {
        let directory = fresh_directory(name);
        fs::write(directory.join("sheet.stl"), sheet(24)).unwrap();
        attempt_in(&engine, &directory, &scene(boundary), deck, ranks)
    };
    let default = "neigh_modify delay 0";
    for (boundary, axis, ranks) in [("p p f", "0 0 1", 1), ("f p f", "0.1 0 1", 2)] {
        let outcome = end("across", boundary, &deck(axis, default), ranks);
        assert!(!outcome.success, "{boundary}, {axis}");
        for words in ["mesh sheet turns", "periodic boundary in y", "'boundary'"] {
            assert!(outcome.output.contains(words), "{}", outcome.output);
        }
    }
    for (boundary, axis) in [("f p f", "0 1 0"), ("f f f", "0 0 1")] {
        let [rarely, always] = [default, "neigh_modify every 1 delay 0 check no"].map(|lists| {
            let outcome = end("along", boundary, &deck(axis, lists), 1);
            outcome.succeeded().last().clone()
        });
        let apart = difference(&rarely, &always);
        println!("{boundary}, {axis}: apart by {apart:.1e}");
        assert!(apart < 1e-9, "{boundary}, {axis}: {apart:e}");
        let change = sub(rarely.states[0].velocity, [0.0, 0.0, -0.05]);
        assert!(length(change) > 1e-3, "no contact");
    }
}
