// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do LIGGGHTS' VTK dumps show ellipsoids as they are, and the stress on meshes that they cause, on one rank and on two?

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::engines::process::from_environment;
use crate::harness::{fresh_directory, run_in, Deck, Engine, Grain, Outcome, Scene, ELASTIC};
use crate::meshes::{sheet, HALF};
use crate::shapes::{about, length, rotate, sub, surface_point, Vector};

/// Triangles of the sheet along an edge.
const CELLS: usize = 4;

/// VTK's headers, if there are any. `cargo xtask test` says `no` where no VTK was to be had for the LIGGGHTS that it built.
pub fn headers() -> Option<PathBuf> {
    let found = from_environment(
        "ELLGRAN_TEST_LIGGGHTS_VTK",
        "the headers of the VTK that LIGGGHTS was built with, or `no`; `cargo xtask path liggghts-vtk` prints them",
    );
    if found == Path::new("no") {
        println!("NOT TESTED: this LIGGGHTS has no VTK");
        return None;
    }
    Some(found)
}

/// Three ellipsoids, two of which slide on triangles of their own; the third floats.
fn scene() -> Scene {
    let grain = |axes: Vector, [x, y]: [f64; 2], axis: Vector, angle: f64, gap: f64| {
        let turn = about(axis, angle);
        let deepest = surface_point(axes, turn, [0.0, 0.0, -1.0]);
        Grain {
            density: 2500.0,
            ..Grain::new(axes, [x - deepest[0], y - deepest[1], gap - deepest[2]]).turned(turn)
        }
    };
    let cell = 2.0 * HALF / CELLS as f64;
    // longest along x, so that two ranks part the grains
    Scene {
        low: [-0.4, -0.2, -0.2],
        high: [0.4, 0.2, 0.2],
        ..Scene::open(
            0.2,
            vec![
                grain(
                    [4e-3, 3e-3, 2e-3],
                    [0.7 * cell, 0.3 * cell],
                    [1.0, 0.3, 0.2],
                    0.9,
                    -1e-5,
                )
                .moving([0.2, 0.1, 0.0]),
                grain(
                    [6e-3, 1e-3, 2.5e-3],
                    [-0.3 * cell, 0.6 * cell],
                    [0.2, 1.0, -0.4],
                    2.1,
                    5e-3,
                ),
                grain(
                    [2e-3, 5e-3, 3e-3],
                    [-1.3 * cell, -0.7 * cell],
                    [0.1, 0.2, 1.0],
                    0.5,
                    -2e-5,
                )
                .moving([0.0, -0.3, 0.0]),
            ],
        )
    }
}

fn outcome(name: &str, dumps: &[&str], ranks: usize) -> Outcome {
    let engine = Engine::from_environment();
    let directory = fresh_directory(&format!("{name}_{ranks}"));
    fs::write(directory.join("sheet.stl"), sheet(CELLS)).unwrap();
    let mut fixes = vec!["group one id 2".to_string()];
    fixes.extend(dumps.iter().map(|dump| dump.to_string()));
    let deck = Deck {
        before: vec!["fix sheet all mesh/surface/stress file sheet.stl type 1".into()],
        walls: vec!["mesh n_meshes 1 meshes sheet".into()],
        fixes,
        time_step: 1e-6,
        steps: 5,
        ..Deck::new(ELASTIC, 0.5)
    };
    run_in(&engine, &directory, &scene(), &deck, ranks)
}

/// The arrays of a legacy file in ASCII, each a list of tuples; the points under `POINTS`.
fn legacy(file: &Path) -> HashMap<String, Vec<Vec<f64>>> {
    let text = fs::read_to_string(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let words: Vec<&str> = text.split_whitespace().collect();
    let mut arrays = HashMap::new();
    for (k, window) in words.windows(4).enumerate() {
        let (name, components, tuples) = match *window {
            ["POINTS", count, "float" | "double", _] => ("POINTS", 3, count.parse().ok()),
            [name, components, tuples, "float" | "double" | "int"] => {
                (name, components.parse().unwrap_or(0), tuples.parse().ok())
            }
            _ => continue,
        };
        let Some(tuples) = tuples.filter(|_: &usize| components > 0) else {
            continue;
        };
        let from = k + if name == "POINTS" { 3 } else { 4 };
        let Some(numbers) = words[from..]
            .iter()
            .take(components * tuples)
            .map(|word| word.parse().ok())
            .collect::<Option<Vec<f64>>>()
        else {
            continue;
        };
        let rows = numbers.chunks(components).map(<[f64]>::to_vec).collect();
        arrays.insert(name.to_string(), rows);
    }
    arrays
}

#[test]
fn axes_and_orientations_of_ellipsoids() {
    if headers().is_none() {
        return;
    }
    let columns = "id type x y z shapex shapey shapez quat1 quat2 quat3 quat4 fx fy fz";
    let dumps = [
        format!("dump all all custom/vtk 5 all_*.vtk {columns}"),
        format!("dump one one custom/vtk 5 one_*.vtk {columns}"),
        format!("dump set all custom/vtk 5 set_*.pvtu {columns}"),
    ];
    let dumps: Vec<&str> = dumps.iter().map(String::as_str).collect();
    let scene = scene();
    for ranks in [1, 2] {
        let outcome = outcome("shapes", &dumps, ranks);
        for (file, count) in [("all_0.vtk", 3), ("one_0.vtk", 1)] {
            let arrays = legacy(&outcome.directory.join(file));
            let ids = &arrays["id"];
            assert_eq!(ids.len(), count, "{file}");
            for (k, id) in ids.iter().enumerate() {
                let n = id[0] as usize - 1;
                assert!(count == 3 || n == 1, "{file} has grain {}", n + 1);
                let grain = &scene.grains[n];
                // points are in single precision
                let at: Vec<f64> = arrays["POINTS"][k].clone();
                assert!((0..3).all(|m| (at[m] - grain.position[m]).abs() < 1e-7));
                for (m, name) in ["shapex", "shapey", "shapez"].iter().enumerate() {
                    let axis = arrays[*name][k][0];
                    assert!(
                        (axis - grain.semi_axes[m]).abs() < 1e-12,
                        "{file}: {name} = {axis}"
                    );
                }
                // rotation from the frame of the ellipsoid to that of space, row by row
                let turned = &arrays["TENSOR"][k];
                for m in 0..3 {
                    let mut unit = [0.0; 3];
                    unit[m] = 1.0;
                    let axis = rotate(grain.quaternion, unit);
                    let told: Vector = std::array::from_fn(|row| turned[3 * row + m]);
                    let apart = length(sub(told, axis));
                    println!(
                        "{file}, {ranks} ranks, grain {}, axis {m}: off by {apart:.1e}",
                        n + 1
                    );
                    assert!(apart < 1e-10);
                }
            }
        }
        // One file a rank, and one that names them all.
        let index = fs::read_to_string(outcome.directory.join("set_5.pvtu")).unwrap();
        let pieces: Vec<&str> = index
            .split("Source=\"")
            .skip(1)
            .filter_map(|rest| rest.split('"').next())
            .collect();
        assert_eq!(pieces.len(), ranks, "{index}");
        let points: usize = pieces
            .iter()
            .map(|piece| {
                let text = fs::read_to_string(outcome.directory.join(piece)).unwrap();
                let count = text.split("NumberOfPoints=\"").nth(1).unwrap();
                count.split('"').next().unwrap().parse::<usize>().unwrap()
            })
            .sum();
        assert_eq!(points, 3);
    }
}

#[test]
fn stress_on_the_triangles_of_a_mesh() {
    if headers().is_none() {
        return;
    }
    let area = 0.5 * (2.0 * HALF / CELLS as f64).powi(2);
    for ranks in [1, 2] {
        let outcome = outcome(
            "stress",
            &["dump walls all mesh/vtk 5 walls_*.vtk stress stresscomponents id"],
            ranks,
        );
        let arrays = legacy(&outcome.directory.join("walls_5.vtk"));
        let stress = &arrays["stress"];
        assert_eq!(stress.len(), 2 * CELLS * CELLS, "{ranks} ranks");
        let loaded: Vec<usize> = (0..stress.len())
            .filter(|&k| stress[k].iter().any(|v| *v != 0.0))
            .collect();
        assert_eq!(loaded.len(), 2, "{ranks} ranks");
        let states = &outcome.last().states;
        for n in [0, 2] {
            let expected: Vector = std::array::from_fn(|m| -states[n].force[m] / area);
            let (normal, shear) = (-expected[2], expected[0].hypot(expected[1]));
            let size = length(expected);
            assert!(size > 0.0 && shear > 1e-3 * normal);
            let best = loaded
                .iter()
                .map(|&k| {
                    let told: Vector = std::array::from_fn(|m| stress[k][m]);
                    let apart = [
                        length(sub(told, expected)),
                        (arrays["normal_stress_average"][k][0] - normal).abs(),
                        (arrays["shear_stress_average"][k][0] - shear).abs(),
                    ];
                    apart.into_iter().fold(0.0, f64::max) / size
                })
                .fold(f64::INFINITY, f64::min);
            println!(
                "{ranks} ranks, grain {}: stress {expected:.4?}, off by {best:.1e}",
                n + 1
            );
            assert!(best < 1e-10);
        }
    }
}
