// SPDX-License-Identifier: MIT OR Apache-2.0
//! Are the forces that a wall stores contact by contact those of the same sphere in LIGGGHTS' own words, and does the motion not
//! know of them?

use std::fs;

use crate::decomposition::difference;
use crate::harness::{
    fresh_directory, last_rows, run_in, Deck, Engine, Grain, Outcome, Scene, ELASTIC,
};
use crate::mesh_ranks::{on_a_sheet, sheet_deck};
use crate::meshes::sheet;
use crate::shapes::{about, add, length, sub, Vector};

fn on_a_mesh(name: &str, scene: &Scene, deck: &Deck, ranks: usize) -> Outcome {
    let engine = Engine::from_environment();
    let directory = fresh_directory(name);
    fs::write(directory.join("sheet.stl"), sheet(8)).unwrap();
    run_in(&engine, &directory, scene, deck, ranks)
}

#[test]
fn storing_does_not_change_the_motion() {
    for ranks in [1, 4] {
        let run = |words: &str| {
            let mut deck = sheet_deck();
            deck.steps = 60;
            deck.walls[0] += words;
            let name = format!("{ranks}{}", words.replace(' ', "_"));
            on_a_mesh(&name, &on_a_sheet(), &deck, ranks)
        };
        let plain = run("");
        // The contacts are taken one by one, which rounds apart from the one call without a store.
        let first = run(" store_force_contact yes");
        for (a, b) in first.frames.iter().zip(&plain.frames) {
            assert!(difference(a, b) < 1e-13, "{ranks} ranks");
        }
        assert_eq!(first.frames.len(), plain.frames.len());
        for words in [
            " store_force_contact_every 3",
            " store_force_contact_stress yes",
            " store_force yes store_force_contact yes store_force_contact_stress yes",
        ] {
            let stored = run(words);
            for (a, b) in stored.frames.iter().zip(&first.frames) {
                assert_eq!(a.states, b.states, "{ranks} ranks:{words}");
            }
            assert_eq!(stored.frames.len(), plain.frames.len());
        }
    }
}

/// In a box around a floor at z = 0.
fn on_the_floor(grains: Vec<Grain>) -> Scene {
    Scene {
        low: [-0.07, -0.07, -0.02],
        high: [0.07, 0.07, 0.03],
        ..Scene::open(1.0, grains)
    }
}

/// fix continuum/weighted reads what the pairs and the walls store.
#[test]
fn stresses_of_spheres_as_in_the_engines_own_words() {
    let sphere = |x: f64, z: f64| Grain {
        density: 2500.0,
        ..Grain::sphere(5e-3, [x, 0.0113, z])
    };
    let scene = on_the_floor(vec![
        sphere(0.0, 4.98e-3),
        sphere(0.006, 0.0128),
        sphere(0.03, 4.99e-3),
    ]);
    for wall in [
        "primitive type 1 zplane 0.0",
        "mesh n_meshes 1 meshes sheet",
    ] {
        let stresses = |ours: bool, ranks: usize| {
            let mut deck = Deck {
                model: if ours {
                    "nfd surface ellipsoid"
                } else {
                    "hertz"
                }
                .into(),
                atom_style: if ours { "superquadric" } else { "sphere" }.into(),
                wall_fix: if ours {
                    "wall/gran/ellipsoid"
                } else {
                    "wall/gran"
                }
                .into(),
                // the wall comes after the fix that wants its forces, so it cannot stand among the walls
                ..Deck::new(ELASTIC, 0.5)
            };
            if wall.contains("mesh") {
                deck.before = vec!["fix sheet all mesh/surface file sheet.stl type 1".into()];
            }
            deck.fixes = vec![
                "fix continuum all continuum/weighted kernel_radius 0.012 kernel_type Wendland compute stress".into(),
                format!("fix wall all {} model {} {wall}", deck.wall_fix, deck.model),
                "dump stress all custom 1 stress id f_stressTensor_[1] f_stressTensor_[5] f_stressTensor_[9] f_stressTensor_[3]".into(),
                "dump_modify stress sort id format \"%d %.17g %.17g %.17g %.17g\"".into(),
            ];
            deck.steps = 1;
            deck.time_step = 1e-9;
            let name = format!("{ours} {ranks} {}", &wall[..4]).replace(' ', "_");
            let outcome = on_a_mesh(&name, &scene, &deck, ranks);
            last_rows(&outcome.directory.join("stress"))
        };
        let theirs = stresses(false, 1);
        let largest = theirs
            .iter()
            .flat_map(|row| row[1..].iter())
            .fold(0.0f64, |m, v| m.max(v.abs()));
        assert!(largest > 1.0);
        for ranks in [1, 2] {
            let ours = stresses(true, ranks);
            assert_eq!(ours.len(), 3);
            let mut worst = 0.0f64;
            for (a, b) in ours.iter().zip(&theirs) {
                for k in 1..5 {
                    worst = worst.max((a[k] - b[k]).abs() / largest);
                }
            }
            println!("{wall}, {ranks} ranks: stresses apart by {worst:.1e} of {largest:.3e}");
            assert!(worst < 1e-6);
        }
    }
}

/// A torque of rolling friction is no part of the stress: the same grains have that of a plane beside a mesh of it.
#[test]
fn stresses_beside_a_mesh_are_those_beside_its_plane() {
    let grain = |x: f64, axes: Vector, turn: f64| {
        Grain {
            density: 2500.0,
            ..Grain::new(axes, [x, 0.0113, axes[2] - 2e-5]).turned(about([0.0, 0.0, 1.0], turn))
        }
        .moving([0.3, 0.1, -0.05])
        .spinning([30.0, 50.0, 5.0])
    };
    let scene = on_the_floor(vec![
        grain(0.0, [6e-3, 4e-3, 3e-3], 0.4),
        grain(0.02, [4e-3; 3], 0.0),
        grain(-0.02, [3e-3, 5e-3, 4e-3], 1.1),
    ]);
    for model in [
        "nfd tangential tfd surface ellipsoid",
        "hertz tangential history rolling_friction cdt surface ellipsoid",
    ] {
        let [plane, mesh] = [
            "primitive type 1 zplane 0.0",
            "mesh n_meshes 1 meshes sheet",
        ]
        .map(|wall| {
            let deck = Deck {
                model: model.into(),
                before: vec![
                    "fix sheet all mesh/surface file sheet.stl type 1".into(),
                    "fix c1 all property/global coefficientRollingFriction peratomtypepair 1 0.3".into(),
                ],
                fixes: vec![
                    "fix continuum all continuum/weighted kernel_radius 0.012 kernel_type Wendland compute stress".into(),
                    format!("fix wall all wall/gran/ellipsoid model {model} {wall}"),
                    "dump stress all custom 20 stress id f_stressTensor_[1] f_stressTensor_[5] f_stressTensor_[9] f_stressTensor_[3]".into(),
                    "dump_modify stress sort id format \"%d %.17g %.17g %.17g %.17g\"".into(),
                ],
                steps: 20,
                ..Deck::new(ELASTIC, 0.5)
            };
            let name = format!("stress {} {}", &model[..4], &wall[..4]).replace(' ', "_");
            let outcome = on_a_mesh(&name, &scene, &deck, 1);
            last_rows(&outcome.directory.join("stress"))
        });
        let largest = plane
            .iter()
            .flat_map(|row| row[1..].iter())
            .fold(0.0f64, |m, v| m.max(v.abs()));
        let worst = plane
            .iter()
            .zip(&mesh)
            .flat_map(|(a, b)| a[1..].iter().zip(&b[1..]))
            .fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        println!("{model}: stresses apart by {worst:.1e} of {largest:.3e}");
        assert!(plane.len() == 3 && mesh.len() == 3 && largest > 1.0);
        // the same contacts: rounding
        assert!(worst < 1e-9 * largest);
    }
}

/// Forces and torques by the number of the triangle (0 for a primitive wall), out of a restart file: the one place where LIGGGHTS
/// shows what `store_force_contact` keeps. A record is its length, the number of entries, and for each the triangle and six numbers.
fn stored(file: &std::path::Path) -> Vec<(i64, [f64; 6])> {
    let bytes = fs::read(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let word = |at: usize| -> Option<[u8; 8]> { bytes.get(at..at + 8)?.try_into().ok() };
    let number = |at: usize| word(at).map(f64::from_le_bytes);
    let whole = |at: usize| word(at).map(i64::from_le_bytes);
    let record = |at: usize| -> Option<Vec<(i64, [f64; 6])>> {
        let count = whole(at + 8).filter(|count| (1..10).contains(count))?;
        if number(at)? != (7 * count + 2) as f64 {
            return None;
        }
        (0..count as usize)
            .map(|k| {
                let from = at + 16 + 56 * k;
                let triangle = whole(from).filter(|n| (0..100).contains(n))?;
                let values: Vec<f64> = (1..7)
                    .map(|m| number(from + 8 * m).filter(|v| v.abs() < 1e3))
                    .collect::<Option<_>>()?;
                Some((triangle, values.try_into().ok()?))
            })
            .collect()
    };
    (0..bytes.len())
        .filter_map(record)
        .find(|entries| entries.iter().any(|(_, v)| v.iter().any(|v| *v != 0.0)))
        .expect("no stored forces in the restart file")
}

/// A needle across a cylinder touches it with both tips, one grain in a corner of a mesh two triangles: what is stored adds up to
/// what moved the grain.
#[test]
fn stored_forces_of_two_contacts_add_up() {
    let needle = Grain {
        density: 2500.0,
        ..Grain::new([0.01002, 1e-3, 1e-3], [4e-6, 1e-6, 2e-3]).turned(about([0.0, 0.2, 1.0], 0.3))
    };
    let in_a_corner = Grain {
        density: 2500.0,
        ..Grain::new([4e-3, 3e-3, 2e-3], [0.0; 3]).turned(about([0.0, 0.0, 1.0], 0.5))
    };
    // half widths of an ellipsoid along x and along z, after its turn about z
    let [along_x, along_z] = [(4e-3f64 * 0.5f64.cos()).hypot(3e-3 * 0.5f64.sin()), 2e-3];
    let in_a_corner = Grain {
        position: [along_x - 2e-5, 1e-3, along_z - 1e-5],
        ..in_a_corner
    };
    let corner = "solid corner
 facet normal 0 0 1
  outer loop
   vertex 0 -0.05 0
   vertex 0.05 0 0
   vertex 0 0.05 0
  endloop
 endfacet
 facet normal 1 0 0
  outer loop
   vertex 0 -0.05 0
   vertex 0 0.05 0
   vertex 0 0 0.05
  endloop
 endfacet
endsolid corner
";
    for (name, grain, wall, entries) in [
        (
            "cylinder",
            needle,
            "primitive type 1 zcylinder 0.01 0.0 0.0",
            1,
        ),
        ("corner", in_a_corner, "mesh n_meshes 1 meshes corner", 2),
    ] {
        for ranks in [1, 2] {
            let mut deck = Deck {
                time_step: 1e-9,
                walls: vec![format!("{wall} store_force_contact yes")],
                fixes: vec!["restart 1 stored.*".into()],
                steps: 1,
                ..Deck::new(ELASTIC, 0.5)
            };
            if wall.contains("mesh") {
                deck.before = vec!["fix corner all mesh/surface file corner.stl type 1".into()];
            }
            let engine = Engine::from_environment();
            let directory = fresh_directory(&format!("{name}_{ranks}"));
            fs::write(directory.join("corner.stl"), corner).unwrap();
            let scene = Scene::open(0.1, vec![grain.clone()]);
            let outcome = run_in(&engine, &directory, &scene, &deck, ranks);
            let stored = stored(&directory.join("stored.1"));
            assert_eq!(stored.len(), entries, "{name}: {stored:?}");
            let sum = |from: usize| {
                stored.iter().fold([0.0; 3], |sum, (_, v)| {
                    add(sum, std::array::from_fn::<f64, 3, _>(|k| v[from + k]))
                })
            };
            let state = &outcome.last().states[0];
            let (force, torque): (Vector, Vector) = (sum(0), sum(3));
            let one = length(std::array::from_fn(|k| stored[0].1[k]));
            println!(
                "{name}, {ranks} ranks: {} entries, first {one:.3e} N, sum {:.3e} N; off by {:.1e}, torque by {:.1e}",
                stored.len(),
                length(force),
                length(sub(force, state.force)) / length(state.force),
                length(sub(torque, state.torque)) / length(state.torque)
            );
            assert!(length(sub(force, state.force)) < 1e-12 * length(state.force));
            assert!(length(sub(torque, state.torque)) < 1e-12 * length(state.torque));
        }
    }
}
