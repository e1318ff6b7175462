// SPDX-License-Identifier: MIT OR Apache-2.0
//! Are walls read from STL files the surfaces that they describe, however they are cut into triangles?

use std::fmt::Write as _;
use std::fs;

use crate::harness::{
    attempt_in, fresh_directory, run, Deck, Engine, Frame, Grain, Outcome, Scene,
};
use crate::hills::{divided, grains_on, hills, unevenly_divided};
use crate::shapes::{length, sub, unit, Random, Vector};

const LAW: &str = "hertz 1e7 0.3 tangential mindlin 0.5";

pub type Triangle = [Vector; 3];

fn ascii(triangles: &[Triangle]) -> Vec<u8> {
    let mut text = String::from("solid wall\n");
    for t in triangles {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in t {
            writeln!(text, "vertex {x} {y} {z}").unwrap();
        }
        text += "endloop\nendfacet\n";
    }
    (text + "endsolid wall\n").into_bytes()
}

pub fn binary(triangles: &[Triangle]) -> Vec<u8> {
    let mut bytes = vec![0u8; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for t in triangles {
        bytes.extend([0u8; 12]);
        for x in t.iter().flatten() {
            bytes.extend((*x as f32).to_le_bytes());
        }
        bytes.extend([0u8; 2]);
    }
    bytes
}

/// A square of `cells` by `cells`, two triangles each, at `at` along axis `normal`, from -1 to 1 across.
pub fn square(normal: usize, at: f64, cells: usize) -> Vec<Triangle> {
    let corner = |i: usize, j: usize| {
        let mut p = [0.0; 3];
        p[normal] = at;
        p[(normal + 1) % 3] = -1.0 + 2.0 * i as f64 / cells as f64;
        p[(normal + 2) % 3] = -1.0 + 2.0 * j as f64 / cells as f64;
        p
    };
    (0..cells * cells)
        .flat_map(|k| {
            let (i, j) = (k % cells, k / cells);
            [
                [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)],
                [corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)],
            ]
        })
        .collect()
}

pub fn cube(cells: usize) -> Vec<Triangle> {
    (0..6)
        .flat_map(|k| square(k / 2, if k % 2 == 0 { -1.0 } else { 1.0 }, cells))
        .collect()
}

/// Grains of aspect ratio 1 to 30 that slide along the walls of a cube, away from its edges.
fn grains() -> Vec<Grain> {
    let mut random = Random(3);
    (0..24)
        .map(|k| {
            let aspect = [1.0, 3.0, 10.0, 30.0][k % 4];
            let axes = [0.2, 0.2 / aspect, 0.25 / aspect];
            let (side, out) = (k / 2 % 3, if k % 2 == 0 { -1.0 } else { 1.0 });
            let mut normal = [0.0; 3];
            normal[side] = out;
            let grain = Grain::new(axes, [0.0; 3]).turned(random.quaternion());
            let low = crate::shapes::surface_point(axes, grain.quaternion, normal);
            let mut position: Vector = std::array::from_fn(|_| random.between(-0.5, 0.5));
            position[side] = out * (1.0 + 1e-4 / aspect) - low[side];
            // along the wall: away from it, the slender ones would leave within the run
            let mut velocity = [0.3, 0.7, -0.5];
            velocity[side] = 0.0;
            Grain { position, ..grain }.moving(unit(velocity))
        })
        .collect()
}

fn deck(words: &str) -> Deck {
    Deck {
        fixes: vec![
            "neigh_modify exclude group all all".into(),
            format!("fix wall all wall/gran/ellipsoid {LAW} {words}"),
        ],
        time_step: 1e-6,
        steps: 40,
        ..Deck::new(LAW)
    }
}

pub fn in_mesh(
    engine: &Engine,
    name: &str,
    files: &[(&str, Vec<u8>)],
    scene: &Scene,
    deck: &Deck,
    ranks: usize,
) -> Outcome {
    let directory = fresh_directory(name);
    for (file, bytes) in files {
        fs::write(directory.join(file), bytes).unwrap();
    }
    attempt_in(engine, directory, scene, deck, ranks).succeeded()
}

fn difference(a: &Frame, b: &Frame) -> f64 {
    let largest = b.states.iter().map(|s| length(s.force)).fold(0.0, f64::max);
    a.states
        .iter()
        .zip(&b.states)
        .flat_map(|(s, t)| {
            [
                length(sub(s.force, t.force)),
                length(sub(s.torque, t.torque)),
            ]
        })
        .fold(0.0, f64::max)
        / largest
}

#[test]
fn both_versions_a_cube_from_a_file_is_six_planes() {
    let engine = Engine::from_environment();
    let scene = Scene::open(3.0, grains());
    let planes = Deck {
        fixes: vec![
            "neigh_modify exclude group all all".into(),
            "region cube block -1 1 -1 1 -1 1".into(),
            format!("fix wall all wall/gran/ellipsoid {LAW} region cube"),
        ],
        ..deck("")
    };
    let planes = run(&engine, "mesh_planes", &scene, &planes, 1);
    assert!(planes.last().states.iter().all(|s| length(s.force) > 0.0));
    // Turned by a quarter about z, a file in half the size, moved: the same cube.
    let half: Vec<Triangle> = cube(2)
        .iter()
        .map(|t| t.map(|p| [0.5 * p[0] + 1.0, 0.5 * p[1], 0.5 * p[2]]))
        .collect();
    for (name, bytes, words, ranks) in [
        ("ascii", ascii(&cube(1)), "", 1),
        ("binary", binary(&cube(1)), "", 1),
        ("in many pieces", binary(&cube(32)), "", 3),
        (
            "placed",
            binary(&half),
            "scale 2 turn 90 0 0 1 move 0 -2 0",
            1,
        ),
    ] {
        let deck = deck(&format!("mesh wall.stl {words}"));
        let mesh = in_mesh(
            &engine,
            "mesh_cube",
            &[("wall.stl", bytes)],
            &scene,
            &deck,
            ranks,
        );
        let error = difference(mesh.last(), planes.last());
        println!("{name}: {error:.1e} of the largest force");
        // rounding of the coordinates, over the overlap
        assert!(error < 1e-10, "{name}");
    }
}

/// A mesh that moves and turns carries its surface along: seen from it, grains feel what they feel at rest.
#[test]
fn both_versions_a_mesh_moves_and_turns() {
    let engine = Engine::from_environment();
    let scene = Scene::open(3.0, grains());
    let motion = "velocity 1 -2 0.5 rotate 0.1 0.2 0 1 2 3 0.05";
    let moving = |words: &str, before: Vec<String>| {
        let mut deck = deck(&format!("{words} {motion}"));
        deck.steps = 400;
        deck.fixes.splice(1..1, before);
        deck
    };
    let planes = moving(
        "region cube",
        vec!["region cube block -1 1 -1 1 -1 1".into()],
    );
    let planes = run(&engine, "mesh_moving_planes", &scene, &planes, 1);
    let files = [("wall.stl", binary(&cube(3)))];
    let mesh = in_mesh(
        &engine,
        "mesh_moving",
        &files,
        &scene,
        &moving("mesh wall.stl", vec![]),
        2,
    );
    let error = difference(mesh.last(), planes.last());
    println!("in motion: {error:.1e} of the largest force");
    assert!(error < 1e-9);
    assert!(
        difference(planes.first(), planes.last()) > 0.1,
        "nothing has changed"
    );
}

/// Two fixes, each with a law of its own; the columns of a contact add up to the forces.
#[test]
fn both_versions_meshes_have_laws_and_columns_of_their_own() {
    let engine = Engine::from_environment();
    let scene = Scene::open(3.0, vec![Grain::sphere(1.0005, [0.0; 3])]);
    let low = square(2, -1.0, 4);
    let high = square(2, 1.0, 4);
    let deck = Deck {
        fixes: vec![
            "fix low all wall/gran/ellipsoid hertz 1e7 0.3 mesh low.stl contacts".into(),
            "fix high all wall/gran/ellipsoid hertz 2e7 0.3 mesh high.stl contacts".into(),
            "dump low all local 1 low.dump f_low[1] f_low[9] f_low[16]".into(),
            "dump high all local 1 high.dump f_high[1] f_high[9] f_high[16]".into(),
        ],
        time_step: 1e-9,
        thermo_columns: "step f_low[16] f_high[16]".into(),
        ..Deck::new(LAW)
    };
    let files = [("low.stl", binary(&low)), ("high.stl", ascii(&high))];
    let outcome = in_mesh(&engine, "mesh_laws", &files, &scene, &deck, 1);
    let row = &outcome.thermo()[0];
    let (low, high) = (row["f_low[16]"], row["f_high[16]"]);
    assert!(low < 0.0 && (high / low + 2.0).abs() < 1e-9, "{low} {high}");
    for (file, force) in [("low.dump", -low), ("high.dump", -high)] {
        let text = fs::read_to_string(outcome.directory.join(file)).unwrap();
        let last = text.lines().last().unwrap();
        let columns: Vec<f64> = last
            .split_whitespace()
            .map(|w| w.parse().unwrap())
            .collect();
        println!("{file}: {columns:?}");
        assert_eq!(columns[0], 1.0);
        assert!((columns[1] - 5e-4).abs() < 1e-6);
        assert!(
            (columns[2] / force - 1.0).abs() < 1e-4,
            "{columns:?}, {force}"
        );
    }
}

/// A hilly floor of sixteen times as many triangles, in the single precision of its file. The edges between these are folds in it, at which planes went on
/// beyond their borders. And one whose triangles have their corners on their neighbours' sides.
#[test]
fn both_versions_a_fine_division_of_a_file_is_the_same_wall() {
    let engine = Engine::from_environment();
    let size = 0.04;
    let grains = grains_on(size).into_iter();
    let grains = grains.map(|(axes, position)| Grain::new(axes, position));
    let scene = Scene::open(0.6, grains.collect());
    let deck = Deck {
        time_step: 1e-9,
        steps: 1,
        ..deck("mesh wall.stl")
    };
    let floor = hills(12, size, 0.003);
    let forces = |triangles: &[Triangle], ranks| {
        let files = [("wall.stl", binary(triangles))];
        let outcome = in_mesh(&engine, "mesh_division", &files, &scene, &deck, ranks);
        outcome.first().clone()
    };
    let whole = forces(&floor, 1);
    for finer in [divided(&floor), unevenly_divided(&floor)] {
        for ranks in [1, 2] {
            let error = difference(&forces(&finer, ranks), &whole);
            println!("{ranks} ranks: {error:.1e} of the largest force");
            assert!(error < 1e-6);
        }
    }
}

/// A hundred thousand triangles far from the grains change nothing.
#[test]
fn both_versions_a_mesh_of_a_hundred_thousand_triangles() {
    let engine = Engine::from_environment();
    let scene = Scene::open(3.0, grains());
    let deck = deck("mesh wall.stl");
    let mut large = cube(3);
    let far = square(2, -1.0, 224);
    large.extend(
        far.iter()
            .map(|t| t.map(|[x, y, z]| [30.0 * x, 30.0 * y, z - 1.0])),
    );
    assert!(large.len() > 100_000);
    let frames: Vec<Frame> = [cube(3), large]
        .iter()
        .map(|triangles| {
            let files = [("wall.stl", binary(triangles))];
            let outcome = in_mesh(&engine, "mesh_large", &files, &scene, &deck, 1);
            outcome.last().clone()
        })
        .collect();
    assert_eq!(difference(&frames[1], &frames[0]), 0.0);
}

/// A wall has no periodic images. Inclined grains whose lowest point is across the boundary: over a floor that ends there the force is not that of
/// the floor, and a warning says so once; over one that goes on by the largest semi-axis it is, and there is none.
#[test]
fn both_versions_a_mesh_that_ends_at_a_periodic_boundary() {
    let engine = Engine::from_environment();
    let axes = [0.2, 0.1, 0.1];
    // one beside each end of the box, and one far from both
    let grains = [(-1.0, -0.6), (1.0, 0.6), (0.0, 0.6)].map(|(end, angle)| {
        let quaternion = crate::shapes::about([0.0, 1.0, 0.0], angle);
        let low = crate::shapes::surface_point(axes, quaternion, [0.0, 0.0, -1.0]);
        assert!(low[0] * end >= 0.0, "{low:?}");
        Grain::new(axes, [end - 0.5 * low[0], 0.5 * end, -0.002 - low[2]]).turned(quaternion)
    });
    let mut scene = Scene::open(1.0, grains.into());
    scene.boundary = "p f f".into();
    let of_floor = |x: f64| -> Vec<u8> {
        let floor = square(2, 0.0, 4);
        binary(
            &floor
                .iter()
                .map(|t| t.map(|p| [x * p[0], 2.0 * p[1], p[2]]))
                .collect::<Vec<_>>(),
        )
    };
    let still = |words: &str, runs: &[&str]| Deck {
        time_step: 1e-9,
        steps: 1,
        runs: runs.iter().map(|r| (*r).into()).collect(),
        ..deck(words)
    };
    let plane = run(
        &engine,
        "mesh_end_plane",
        &scene,
        &still("zplane 0 NULL", &[]),
        1,
    );
    let said = |outcome: &Outcome| {
        outcome
            .output
            .matches("the mesh ends at the periodic boundary in x")
            .count()
    };
    for (name, length_of_floor, ends) in [("ends", 1.0, true), ("goes on", 1.2, false)] {
        let files = [("wall.stl", of_floor(length_of_floor))];
        for ranks in [1, 2] {
            let deck = still("mesh wall.stl", &["run 0", "run 1"]);
            let mesh = in_mesh(&engine, "mesh_end", &files, &scene, &deck, ranks);
            let error = difference(mesh.first(), plane.first());
            println!("{name}, {ranks} ranks: {error:.1e} of the largest force");
            assert_eq!(said(&mesh), usize::from(ends), "{name}");
            if ends {
                assert!(mesh.output.contains("semi-axis, 0.2"), "{}", mesh.output);
                assert!(error > 0.1, "{name}: {error}");
            } else {
                assert!(error < 1e-9, "{name}: {error}");
            }
        }
    }
    // A mesh that comes to the boundary in the first run is told of in the second.
    let pebble = binary(
        &cube(1)
            .iter()
            .map(|t| t.map(|p| [0.1 * p[0], 0.1 * p[1], 0.1 * p[2] - 0.5]))
            .collect::<Vec<_>>(),
    );
    let moving = Deck {
        time_step: 1e-3,
        ..still(
            "mesh wall.stl velocity 1 0 0",
            &["run 1", "print \"second run\"", "run 900", "run 0"],
        )
    };
    let outcome = in_mesh(
        &engine,
        "mesh_comes",
        &[("wall.stl", pebble)],
        &scene,
        &moving,
        1,
    );
    assert_eq!(said(&outcome), 1);
    let (before, _) = outcome.output.split_once("the mesh ends").unwrap();
    assert!(before.contains("second run"));
}
