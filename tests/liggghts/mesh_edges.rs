// SPDX-License-Identifier: MIT OR Apache-2.0
//! Edges and corners of a mesh: is a corner of three faces the three planes it is made of, does a convex edge push as Hertz says,
//! and does a grain pass over it without a jump of the force?

use std::f64::consts::PI;
use std::fmt::Write as _;
use std::fs;

use crate::harness::{
    fresh_directory, kinetic_energy, run_in, Deck, Engine, Grain, Outcome, Scene, ELASTIC,
};
use crate::shapes::{about, dot, length, scale, sub, unit, Vector};

/// Parallelograms `corner, u, v`, each cut into 2 n^2 triangles, as STL.
fn faces(all: &[(Vector, Vector, Vector)], cells: usize) -> String {
    let mut text = String::from("solid faces\n");
    for (corner, u, v) in all {
        let at = |i: usize, j: usize| -> Vector {
            let share = |k: usize| k as f64 / cells as f64;
            std::array::from_fn(|k| corner[k] + share(i) * u[k] + share(j) * v[k])
        };
        for i in 0..cells {
            for j in 0..cells {
                let p = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                for t in [[0, 1, 2], [0, 2, 3]] {
                    text.push_str(" facet normal 0 0 0\n  outer loop\n");
                    for [x, y, z] in t.map(|k: usize| p[k]) {
                        writeln!(text, "   vertex {x:e} {y:e} {z:e}").unwrap();
                    }
                    text.push_str("  endloop\n endfacet\n");
                }
            }
        }
    }
    text + "endsolid faces\n"
}

const SIDE: f64 = 0.05;

fn on_faces(engine: &Engine, name: &str, mesh: &str, scene: &Scene, deck: &Deck) -> Outcome {
    let directory = fresh_directory(name);
    fs::write(directory.join("faces.stl"), mesh).unwrap();
    let deck = Deck {
        before: vec!["fix faces all mesh/surface file faces.stl type 1".into()],
        walls: vec!["mesh n_meshes 1 meshes faces".into()],
        ..deck.clone()
    };
    run_in(engine, &directory, scene, &deck, 1)
}

#[test]
fn a_concave_corner_is_the_three_planes_it_is_made_of() {
    let engine = Engine::from_environment();
    let (x, y, z) = ([SIDE, 0.0, 0.0], [0.0, SIDE, 0.0], [0.0, 0.0, SIDE]);
    let corner = faces(&[([0.0; 3], x, y), ([0.0; 3], y, z), ([0.0; 3], z, x)], 5);
    let mut worst = 0.0f64;
    for (number, (axes, axis, angle)) in [
        ([5e-3, 2e-3, 2e-3], [0.3, 1.0, 0.2], 0.7),
        ([4e-3, 3e-3, 2e-3], [1.0, -0.4, 0.5], 1.9),
        ([1.2e-3, 4e-3, 4e-3], [0.1, 0.3, 1.0], 2.5),
    ]
    .into_iter()
    .enumerate()
    {
        let grain = Grain {
            density: 2500.0,
            ..Grain::new(axes, [7e-3, 8e-3, 6.5e-3])
        }
        .turned(about(axis, angle))
        .moving([-0.9, -1.0, -0.8])
        .spinning([20.0, -40.0, 30.0]);
        let scene = Scene::open(0.1, vec![grain]);
        let deck = Deck {
            time_step: 2e-6,
            steps: 8000,
            dump_every: 100,
            materials: vec![[1e7, 0.3, 100.0, 100.0]],
            walls: ["x", "y", "z"]
                .map(|k| format!("primitive type 1 {k}plane 0.0"))
                .to_vec(),
            ..Deck::new(ELASTIC, 0.5)
        };
        let planes = run_in(
            &engine,
            &fresh_directory(&format!("planes_{number}")),
            &scene,
            &deck,
            1,
        );
        let mesh = on_faces(&engine, &format!("mesh_{number}"), &corner, &scene, &deck);
        let several = planes
            .frames
            .iter()
            .filter(|f| (0..3).filter(|&k| f.states[0].force[k] > 0.0).count() >= 2)
            .count();
        let [p, q] = [&mesh, &planes].map(|o| o.last().states[0].clone());
        let velocity = length(sub(p.velocity, q.velocity)) / length(q.velocity);
        let spin = length(sub(p.angular_velocity, q.angular_velocity)) / length(q.angular_velocity);
        println!("grain {number}: velocities apart by {velocity:.1e}, spins by {spin:.1e}; {several} frames with several faces");
        assert!((0..3).all(|k| q.velocity[k] > 0.0), "it has not come out");
        worst = worst.max(velocity).max(spin);
    }
    assert!(worst < 1e-9);
}

/// The block x < 0, z < 0: its top and its side.
fn block() -> String {
    let back = [0.0, -SIDE / 2.0, 0.0];
    faces(
        &[
            (back, [0.0, SIDE, 0.0], [-SIDE, 0.0, 0.0]),
            (back, [0.0, 0.0, -SIDE], [0.0, SIDE, 0.0]),
        ],
        5,
    )
}

/// A sphere of radius `r` at a penetration of `depth` against something flat, both of `ELASTIC`.
fn hertz(r: f64, depth: f64) -> f64 {
    let modulus = ELASTIC[0] / (2.0 * (1.0 - ELASTIC[1] * ELASTIC[1]));
    4.0 / 3.0 * modulus * r.sqrt() * depth.powf(1.5)
}

#[test]
fn a_convex_edge_pushes_a_sphere_away_from_itself() {
    let engine = Engine::from_environment();
    let (r, depth) = (3e-3, 2e-5);
    let place = 0.0031;
    for degrees in [10.0f64, 45.0, 80.0] {
        // out of the edge, between the normals of the two faces
        let out = [
            (degrees * PI / 180.0).sin(),
            0.0,
            (degrees * PI / 180.0).cos(),
        ];
        let mut position = scale(r - depth, out);
        position[1] = place;
        let scene = Scene::open(0.1, vec![Grain::sphere(r, position)]);
        let deck = Deck {
            time_step: 1e-9,
            ..Deck::new(ELASTIC, 0.5)
        };
        let outcome = on_faces(&engine, &format!("{degrees}"), &block(), &scene, &deck);
        let force = outcome.last().states[0].force;
        let error = length(sub(force, scale(hertz(r, depth), out))) / hertz(r, depth);
        println!("{degrees} degrees: force off by {error:.1e}");
        assert!(error < 1e-9);
    }
}

/// Rolled and pushed over the edge: the largest change of the force within a step, over its largest value, and the change of the
/// energy of an elastic grain. A jump does not become smaller with the time step.
fn over_the_edge(engine: &Engine, name: &str, friction: f64, settings: &str) -> [(f64, f64); 2] {
    [2e-6, 5e-7].map(|time_step| {
        // from above, across the edge of the block, and down beside it
        let grain = Grain {
            density: 2500.0,
            ..Grain::new([5e-3, 3e-3, 2e-3], [-0.8e-3, 0.0011, 5.4e-3])
        }
        .turned(about([0.1, 1.0, 0.05], 1.1))
        .moving([0.25, 0.02, -0.6])
        .spinning([0.0, 150.0, 10.0]);
        let scene = Scene::open(0.1, vec![grain.clone()]);
        let deck = Deck {
            time_step,
            steps: (0.008 / time_step) as u64,
            dump_every: 1,
            settings: settings.into(),
            ..Deck::new(ELASTIC, friction)
        };
        let outcome = on_faces(
            engine,
            &format!("{name}_{time_step:e}"),
            &block(),
            &scene,
            &deck,
        );
        let forces: Vec<Vector> = outcome.frames.iter().map(|f| f.states[0].force).collect();
        let largest = forces.iter().map(|f| length(*f)).fold(0.0, f64::max);
        let jump = forces
            .windows(2)
            .map(|w| length(sub(w[1], w[0])))
            .fold(0.0, f64::max);
        let oblique = forces
            .iter()
            .filter(|f| length(**f) > 0.05 * largest)
            .map(|f| unit(*f))
            .filter(|n| n[0] > 0.1 && n[2] > 0.1)
            .count();
        assert!(oblique > 20, "{name}: the edge itself has not acted");
        let last = outcome.last().states[0].clone();
        assert!(dot(last.force, last.force) == 0.0, "{name}: still touching");
        let spin = |s: &crate::harness::State| dot(s.angular_momentum, s.angular_velocity) / 2.0;
        let energy =
            |s: &crate::harness::State| 0.5 * grain.mass() * dot(s.velocity, s.velocity) + spin(s);
        let first = &outcome.first().states[0];
        assert!(kinetic_energy(&grain, first) > 0.0);
        (jump / largest, energy(&last) / energy(first) - 1.0)
    })
}

#[test]
fn a_grain_goes_over_a_convex_edge_without_a_jump() {
    let engine = Engine::from_environment();
    for (name, friction, settings) in [
        ("smooth", 0.0, ""),
        ("smooth_along_the_normal", 0.0, "conservative off"),
        ("rough", 0.5, ""),
    ] {
        let [coarse, fine] = over_the_edge(&engine, name, friction, settings);
        println!(
            "{name}: largest change of the force in a step {:.1e} and {:.1e}; energy {:.1e} and {:.1e}",
            coarse.0, fine.0, coarse.1, fine.1
        );
        assert!(fine.0 < 0.35 * coarse.0, "{name}: the force jumps");
        if name == "smooth" {
            assert!(fine.1.abs() < 1e-6, "{name}: energy is not kept");
        }
    }
}
