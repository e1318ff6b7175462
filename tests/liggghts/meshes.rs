// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is an ellipsoid on a mesh of coplanar triangles pushed as by the plane, wherever it lies?

use std::fmt::Write as _;
use std::fs;

use crate::harness::{fresh_directory, run_in, Deck, Engine, Grain, Scene, ELASTIC};
use crate::shapes::{about, length, sub, surface_point, Quaternion, IDENTITY};

pub const HALF: f64 = 0.06;

/// A square sheet at z = 0 of 2 n^2 triangles, as STL.
pub fn sheet(cells: usize) -> String {
    let at = |k: usize| HALF * (2.0 * k as f64 / cells as f64 - 1.0);
    let mut text = String::from("solid sheet\n");
    for i in 0..cells {
        for j in 0..cells {
            let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            for t in [[0, 1, 2], [0, 2, 3]] {
                text.push_str(" facet normal 0 0 1\n  outer loop\n");
                for k in t {
                    let (x, y) = corners[k];
                    writeln!(text, "   vertex {:e} {:e} 0", at(x), at(y)).unwrap();
                }
                text.push_str("  endloop\n endfacet\n");
            }
        }
    }
    text + "endsolid sheet\n"
}

fn on_wall(wall: &str, cells: usize) -> Deck {
    let mut deck = Deck {
        time_step: 1e-9,
        walls: vec![wall.into()],
        ..Deck::new(ELASTIC, 0.5)
    };
    if cells > 0 {
        deck.before = vec!["fix sheet all mesh/surface file sheet.stl type 1".into()];
    }
    deck
}

/// All places at once in one run would let the grains touch each other: one grain a run.
fn hold(aspects: &[f64]) {
    let engine = Engine::from_environment();
    let poses: [(&str, Quaternion); 3] = [
        ("lying", IDENTITY),
        (
            "standing",
            about([0.0, 1.0, 0.0], std::f64::consts::FRAC_PI_2),
        ),
        ("tilted", about([0.3, 1.0, 0.2], 0.7)),
    ];
    let down = [0.0, 0.0, -1.0];
    let cell = 2.0 * HALF / 48.0;
    let places = [
        ("face", [0.0113, 0.0071]),
        ("edge", [cell, 0.4 * cell]),
        ("vertex", [cell, cell]),
    ];
    let mut worst = 0.0f64;
    for &aspect in aspects {
        let axes = [1e-3 * aspect, 1e-3, 1e-3];
        for (pose, turn) in poses {
            let deepest = surface_point(axes, turn, down);
            for (place, [x, y]) in places {
                let position = [x - deepest[0], y - deepest[1], -deepest[2] - 1e-5];
                let grain = Grain {
                    density: 2500.0,
                    ..Grain::new(axes, position).turned(turn)
                };
                let scene = Scene::open(0.2, vec![grain]);
                let name = format!("{aspect}_{pose}_{place}");
                let measure = |cells: usize| {
                    let directory = fresh_directory(&format!("{name}_{cells}"));
                    let wall = if cells == 0 {
                        "primitive type 1 zplane 0.0"
                    } else {
                        fs::write(directory.join("sheet.stl"), sheet(cells)).unwrap();
                        "mesh n_meshes 1 meshes sheet"
                    };
                    let outcome = run_in(&engine, &directory, &scene, &on_wall(wall, cells), 1);
                    outcome.last().states[0].clone()
                };
                let plane = measure(0);
                let size = length(plane.force);
                assert!(size > 0.0);
                for cells in [1, 4, 48] {
                    let mesh = measure(cells);
                    let force = length(sub(mesh.force, plane.force)) / size;
                    let torque = length(sub(mesh.torque, plane.torque)) / (size * axes[0]);
                    worst = worst.max(force).max(torque);
                    assert!(
                        force < 1e-6 && torque < 1e-6,
                        "{name}, {} triangles: force {force:.1e}, torque {torque:.1e}",
                        2 * cells * cells
                    );
                }
            }
        }
    }
    println!("aspect ratios {aspects:?}: largest difference {worst:.1e}");
}

#[test]
fn a_mesh_pushes_like_the_plane_it_lies_in() {
    hold(&[1.0, 2.0]);
}

#[test]
fn a_mesh_pushes_needles_like_the_plane_it_lies_in() {
    hold(&[10.0, 30.0]);
}

#[test]
fn sliding_over_triangles_is_sliding_on_a_plane() {
    let engine = Engine::from_environment();
    let axes = [5e-3, 2e-3, 2e-3];
    let grain = Grain {
        density: 2500.0,
        ..Grain::new(axes, [0.0, 0.0, 2e-3])
    }
    .moving([0.3, 0.1, 0.0]);
    let scene = Scene::open(0.2, vec![grain]);
    let slide = |cells: usize| {
        let directory = fresh_directory(&format!("slide_{cells}"));
        let wall = if cells == 0 {
            "primitive type 1 zplane 0.0"
        } else {
            fs::write(directory.join("sheet.stl"), sheet(cells)).unwrap();
            "mesh n_meshes 1 meshes sheet"
        };
        let deck = Deck {
            time_step: 2e-6,
            steps: 20000,
            materials: vec![[1e7, 0.3, 400.0, 400.0]],
            fixes: vec!["fix weight all gravity 9.81 vector 0 0 -1".into()],
            ..on_wall(wall, cells)
        };
        let outcome = run_in(&engine, &directory, &scene, &deck, 1);
        let start = outcome.first().states[0].position;
        (outcome.last().states[0].clone(), start)
    };
    let ((plane, start), (mesh, _)) = (slide(0), slide(48));
    let way = length(sub(plane.position, start));
    let apart = length(sub(plane.position, mesh.position)) / way;
    let speed = length(sub(plane.velocity, mesh.velocity)) / length(plane.velocity);
    println!("slid {way:.4} m over {:.0} triangles' width; positions apart by {apart:.1e}, velocities by {speed:.1e}", way / (2.0 * HALF / 48.0));
    assert!(way > 3.0 * 2.0 * HALF / 48.0);
    // what a triangle forgets of the tangential displacement shows at 1e-7
    assert!(apart < 1e-11 && speed < 1e-11);
}
