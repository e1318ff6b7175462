// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a grain slide over the edges and corners of a mesh without a jump of its force, and with its energy?

use crate::harness::{attempt_in, fresh_directory, Deck, Engine, Frame, Grain, Scene};
use crate::mesh_walls::{binary, square, Triangle};
use crate::shapes::{about, length, sub, Vector};

const GRAVITY: f64 = 9.81;

/// A ball and two ellipsoids, the last one slender, that press on the plane z = 0 as they lie.
fn grains() -> Vec<Grain> {
    let lying = |axes: Vector, turn: f64| Grain {
        quaternion: about([0.0, 0.0, 1.0], turn),
        ..Grain::new(axes, [0.0, 0.0, axes[2]])
    };
    vec![
        lying([0.1, 0.1, 0.1], 0.0),
        lying([0.12, 0.08, 0.06], 0.4),
        lying([0.2, 0.03, 0.02], 1.0),
    ]
}

/// Frames of all steps, and the total energies.
fn slid(
    engine: &Engine,
    wall: &str,
    surface: &[Triangle],
    grain: &Grain,
    law: &str,
    [time, step]: [f64; 2],
) -> (Vec<Frame>, Vec<f64>) {
    let steps = (time / step).round() as u64;
    let deck = Deck {
        fixes: vec![
            format!("fix fall all gravity {GRAVITY} vector 0 0 -1"),
            format!("fix wall all wall/gran/ellipsoid {law} {wall} energies yes"),
            "compute turning all erotate/asphere".into(),
            "compute moving all ke".into(),
        ],
        integrate: false,
        time_step: step,
        steps,
        dump_every: 1,
        thermo_every: 1,
        thermo_columns: "step c_moving c_turning f_wall f_fall".into(),
        ..Deck::new(law)
    };
    let mut deck = deck;
    deck.fixes.push("fix move all nve/ellipsoid".into());
    let directory = fresh_directory("slid");
    std::fs::write(directory.join("wall.stl"), binary(surface)).unwrap();
    let scene = Scene::open(3.0, vec![grain.clone()]);
    let outcome = attempt_in(engine, directory, &scene, &deck, 1).succeeded();
    let rows = outcome.thermo();
    let energies = rows.iter().map(|row| {
        let columns = ["c_moving", "c_turning", "f_wall", "f_fall"];
        columns.iter().map(|c| row[*c]).sum()
    });
    let energies = energies.collect();
    (outcome.frames, energies)
}

/// The largest change of the force from one step to the next.
fn largest_jump(frames: &[Frame]) -> f64 {
    let forces = frames.windows(2).map(|pair| {
        let [a, b] = [&pair[0].states[0], &pair[1].states[0]];
        length(sub(a.force, b.force)).max(length(sub(a.torque, b.torque)) / 0.1)
    });
    forces.fold(0.0, f64::max)
}

/// How deep a grain must be for the wall to bear its weight, nearly.
fn pressed(grain: &Grain) -> Grain {
    let mut grain = grain.clone();
    grain.position[2] -= 7e-4;
    grain
}

/// Where the triangles are in one plane, their edges and corners are not there: with friction, rolling and spin.
#[test]
fn both_versions_over_coplanar_triangles_as_over_a_plane() {
    let engine = Engine::from_environment();
    let law = "nfd 1e7 0.3 500 500 tangential mindlin 0.3";
    let flat = square(2, 0.0, 8);
    for grain in grains() {
        // along a row of edges, along the diagonals of the squares through their corners, and across all
        for direction in [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.8, 0.37, 0.0]] {
            let mut grain = pressed(&grain).moving(direction).spinning([3.0, 1.0, 5.0]);
            grain.position[0] = -0.5;
            grain.position[1] = if direction[1] == 1.0 { -0.5 } else { 0.0 };
            let times = [0.6, 2e-4];
            let (on_plane, _) = slid(&engine, "zplane 0 NULL", &flat, &grain, law, times);
            let (on_mesh, _) = slid(&engine, "mesh wall.stl", &flat, &grain, law, times);
            let largest = on_plane
                .iter()
                .map(|f| length(f.states[0].force))
                .fold(0.0, f64::max);
            let apart = on_plane
                .iter()
                .zip(&on_mesh)
                .map(|(a, b)| {
                    let (a, b) = (&a.states[0], &b.states[0]);
                    let force = length(sub(a.force, b.force));
                    force.max(length(sub(a.torque, b.torque)) / 0.1) / largest
                })
                .fold(0.0, f64::max);
            let way = on_plane.last().unwrap().states[0].position[0] + 0.5;
            println!(
                "axes {:?} along {direction:?}: {way:.2} m, forces apart by {apart:.1e}",
                grain.semi_axes
            );
            assert!(way > 0.1 && apart < 1e-9);
        }
    }
}

/// Over ridges and valleys, and over the corner where four facets meet: between a step and a quarter of it the largest change of the force
/// in a step falls as the step, as that of a continuous force does, and the error of the energy as its square.
#[test]
fn both_versions_over_folds_and_corners_without_a_jump() {
    let engine = Engine::from_environment();
    let law = "hertz 1e7 0.3";
    type Height = fn(f64, f64) -> f64;
    let surfaces: [(&str, Height); 5] = [
        ("ridge", |x, _| -0.03 * x.abs()),
        ("valley", |x, _| 0.03 * x.abs()),
        ("pyramid", |x, y| -0.02 * (x.abs() + y.abs())),
        ("pit", |x, y| 0.02 * (x.abs() + y.abs())),
        ("saddle", |x, y| 0.02 * (x.abs() - y.abs())),
    ];
    let mut faults = vec![];
    for (name, height) in surfaces {
        let triangles: Vec<Triangle> = square(2, 0.0, 6)
            .iter()
            .map(|t| t.map(|[x, y, _]| [x, y, height(x, y)]))
            .collect();
        for grain in grains() {
            let start = [-0.3, -0.11];
            let mut grain = pressed(&grain).moving([0.8, 0.3, 0.0]);
            grain.position[0] = start[0];
            grain.position[1] = start[1];
            // above the highest point below it
            grain.position[2] += height(start[0], start[1]) + 0.003;
            let runs = [2e-4, 5e-5].map(|step| {
                slid(
                    &engine,
                    "mesh wall.stl",
                    &triangles,
                    &grain,
                    law,
                    [0.8, step],
                )
            });
            let [coarse, fine] = runs.map(|(frames, energies)| {
                let size = energies[0] + 0.5;
                let error = energies.iter().map(|e| (e - energies[0]).abs());
                let way = frames.last().unwrap().states[0].position[0] - start[0];
                let most = frames
                    .iter()
                    .map(|f| length(f.states[0].force))
                    .fold(0.0, f64::max);
                (
                    largest_jump(&frames) / most,
                    error.fold(0.0, f64::max) / size,
                    way,
                )
            });
            println!(
                "{name}, axes {:?}: {:.2} m; largest change of force {:.1e}, {:.1e}; energy off by {:.1e}, {:.1e}",
                grain.semi_axes, fine.2, coarse.0, fine.0, coarse.1, fine.1
            );
            let continuous = fine.0 < 0.4 * coarse.0;
            let energy = fine.1 < 0.15 * coarse.1 || fine.1 < 1e-7;
            if !continuous || !energy || fine.2 < 0.2 {
                faults.push(format!(
                    "{name}, axes {:?}: {coarse:?}, {fine:?}",
                    grain.semi_axes
                ));
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}
