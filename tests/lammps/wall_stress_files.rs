// SPDX-License-Identifier: MIT OR Apache-2.0
//! Are the files with the stress on each triangle of a mesh the forces on it?

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use crate::harness::{attempt_in, fresh_directory, Deck, Engine, Grain, Scene};
use crate::hills::unevenly_divided;
use crate::mesh_walls::{binary, square};
use crate::shapes::{cross, dot, length, scale, sub, unit, Random, Vector};

const LAW: &str = "hertz 1e7 0.3 tangential mindlin 0.5";

/// What a legacy VTK file of polygons holds, read without the writer's code.
struct Polygons {
    triangles: Vec<[Vector; 3]>,
    forces: Vec<Vector>,
    scalars: HashMap<String, Vec<f64>>,
}

fn read(path: &Path) -> Polygons {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("# vtk DataFile Version 3.0"));
    lines.next();
    assert_eq!(lines.next(), Some("ASCII"));
    let mut words = lines.flat_map(str::split_whitespace);
    let mut next = || words.next().unwrap().to_string();
    let expect = |wanted: &[&str], next: &mut dyn FnMut() -> String| {
        for w in wanted {
            assert_eq!(next(), *w);
        }
    };
    expect(&["DATASET", "POLYDATA", "POINTS"], &mut next);
    let points: usize = next().parse().unwrap();
    expect(&["double"], &mut next);
    let vector = |next: &mut dyn FnMut() -> String| -> Vector {
        std::array::from_fn(|_| next().parse().unwrap())
    };
    let points: Vec<Vector> = (0..points).map(|_| vector(&mut next)).collect();
    expect(&["POLYGONS"], &mut next);
    let count: usize = next().parse().unwrap();
    assert_eq!(next(), (4 * count).to_string());
    let triangles = (0..count)
        .map(|_| {
            assert_eq!(next(), "3");
            std::array::from_fn(|_| points[next().parse::<usize>().unwrap()])
        })
        .collect();
    expect(&["CELL_DATA"], &mut next);
    assert_eq!(next(), count.to_string());
    expect(&["VECTORS", "force", "double"], &mut next);
    let forces = (0..count).map(|_| vector(&mut next)).collect();
    let mut scalars = HashMap::new();
    for name in ["area", "normal_stress", "shear_stress"] {
        expect(
            &["SCALARS", name, "double", "1", "LOOKUP_TABLE", "default"],
            &mut next,
        );
        let values = (0..count).map(|_| next().parse().unwrap()).collect();
        scalars.insert(name.to_string(), values);
    }
    Polygons {
        triangles,
        forces,
        scalars,
    }
}

/// Grains that slide on a floor of triangles that moves and turns, and on one with corners in the middle of other triangles' sides: the triangles are
/// those of the file.
#[test]
fn both_versions_forces_on_triangles_add_up_to_that_of_the_wall() {
    let engine = Engine::from_environment();
    let mut random = Random(5);
    let grains = (0..16)
        .map(|k| {
            let axes = [0.1, 0.06, 0.05];
            let grain = Grain::new(axes, [0.0; 3]).turned(random.quaternion());
            let low = crate::shapes::surface_point(axes, grain.quaternion, [0.0, 0.0, -1.0]);
            let place = [-0.6 + 0.4 * f64::from(k % 4), -0.6 + 0.4 * f64::from(k / 4)];
            Grain {
                position: [place[0], place[1], -1e-3 - low[2]],
                ..grain
            }
            .moving([0.3, 0.2, -0.1])
        })
        .collect();
    let scene = Scene::open(3.0, grains);
    let turning = "velocity 0.1 0 0 rotate 0 0 0 0 0 1 0.5";
    let [even, uneven] = [square(2, 0.0, 5), unevenly_divided(&square(2, 0.0, 2))];
    for (ranks, motion, floor) in [
        (1, "", &even),
        (4, turning, &even),
        (1, "", &uneven),
        (4, turning, &uneven),
    ] {
        let deck = Deck {
            fixes: vec![format!(
                "fix floor all wall/gran/ellipsoid {LAW} mesh floor.stl {motion} vtk 20 floor.*.vtk"
            )],
            time_step: 1e-5,
            steps: 40,
            thermo_every: 20,
            thermo_columns: "step f_floor[14] f_floor[15] f_floor[16]".into(),
            ..Deck::new(LAW)
        };
        let directory = fresh_directory("stress_files");
        fs::write(directory.join("floor.stl"), binary(floor)).unwrap();
        let outcome = attempt_in(&engine, directory.clone(), &scene, &deck, ranks).succeeded();
        let mut written = 0;
        for row in outcome.thermo() {
            let step = row["Step"] as u64;
            let file = read(&directory.join(format!("floor.{step}.vtk")));
            let wall = [14, 15, 16].map(|k| row[&format!("f_floor[{k}]")]);
            let sum = file
                .forces
                .iter()
                .fold([0.0; 3], |s, f| crate::shapes::add(s, *f));
            let off = length(sub(sum, wall)) / length(wall);
            let loaded = file.forces.iter().filter(|f| length(**f) > 0.0).count();
            println!(
                "step {step}, {ranks} ranks: {loaded} triangles carry load, sum off by {off:.1e}"
            );
            assert_eq!(file.triangles.len(), floor.len());
            assert!(off < 1e-13);
            assert!(loaded > 8, "one triangle carries all");
            for (k, t) in file.triangles.iter().enumerate() {
                let normal = cross(sub(t[1], t[0]), sub(t[2], t[0]));
                let (area, normal) = (0.5 * length(normal), unit(normal));
                let value = |name: &str| file.scalars[name][k];
                assert!((value("area") / area - 1.0).abs() < 1e-12);
                // grains are on one side of it
                let along = dot(file.forces[k], normal);
                let across = sub(file.forces[k], scale(along, normal));
                let stress = along.abs() / area;
                let close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * stress;
                assert!(value("normal_stress") >= 0.0);
                assert!(close(value("normal_stress"), stress), "triangle {k}");
                assert!(
                    close(value("shear_stress"), length(across) / area),
                    "triangle {k}"
                );
            }
            written += 1;
        }
        assert_eq!(written, 3);
        assert!(!directory.join("floor.10.vtk").exists());
    }
}

/// A point turned about an axis of any length through the origin, after Rodrigues.
fn turned(point: Vector, axis: Vector, angle: f64) -> Vector {
    let largest = axis.iter().fold(0.0, |m: f64, a| m.max(a.abs()));
    let n = unit(axis.map(|a| a / largest));
    let (sine, cosine) = angle.sin_cos();
    let across = cross(n, point);
    std::array::from_fn(|k| {
        cosine * point[k] + sine * across[k] + (1.0 - cosine) * dot(n, point) * n[k]
    })
}

/// Triangles stand where scale, *turn* and *move*, and then *omega* or *rotate* and *velocity*, put them, in closed form. Axes of any length.
#[test]
fn both_versions_triangles_stand_where_turn_and_omega_put_them() {
    let engine = Engine::from_environment();
    let scene = Scene::open(3.0, vec![Grain::new([0.1, 0.06, 0.05], [2.0, 2.0, 2.0])]);
    let (time_step, every) = (1e-4, 150);
    let (centre, shift, speed) = ([0.1, 0.2, -0.3], [0.25, -0.5, 0.125], [0.1, 0.0, -0.2]);
    let all = |v: Vector| v.map(|x| format!("{x:e}")).join(" ");
    let flat = square(2, 0.0, 2);
    for size in [1.0, 1e300, 1e-300] {
        for (direction, motion, rate) in [
            ([1.0, -2.0, 2.0], "omega", -7.5),
            ([0.0, 0.3, 1.0], "rotate", 0.5),
        ] {
            let axis = scale(size, direction);
            let deck = Deck {
                fixes: vec![format!(
                    "fix fan all wall/gran/ellipsoid {LAW} mesh fan.stl scale 0.25 turn 33 {} move {} velocity {} {motion} {} {} {rate} vtk {every} fan.*.vtk",
                    all(axis), all(shift), all(speed), all(centre), all(axis)
                )],
                time_step,
                steps: 2 * every,
                ..Deck::new(LAW)
            };
            let directory = fresh_directory("turned_triangles");
            fs::write(directory.join("fan.stl"), binary(&flat)).unwrap();
            attempt_in(&engine, directory.clone(), &scene, &deck, 1).succeeded();
            let mut worst = 0.0f64;
            for step in [0, every, 2 * every] {
                let time = time_step * step as f64;
                let angle = match motion {
                    "omega" => rate * time,
                    _ => 2.0 * std::f64::consts::PI * time / rate,
                };
                let file = read(&directory.join(format!("fan.{step}.vtk")));
                assert_eq!(file.triangles.len(), flat.len());
                for (found, given) in file.triangles.iter().zip(&flat) {
                    for (found, given) in found.iter().zip(given) {
                        // STL files have single precision.
                        let corner = given.map(|x| 0.25 * f64::from(x as f32));
                        let placed =
                            crate::shapes::add(turned(corner, axis, 33f64.to_radians()), shift);
                        let carried = crate::shapes::add(
                            turned(sub(placed, centre), axis, angle),
                            crate::shapes::add(centre, scale(time, speed)),
                        );
                        worst = worst.max(length(sub(*found, carried)));
                    }
                }
            }
            println!("{motion}, axis of {size:e}: off by {worst:.1e}");
            assert!(worst < 1e-14, "{motion}: {worst:e}");
        }
    }
}
