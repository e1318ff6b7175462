// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is energy kept when an elastic, frictionless ellipsoid bounces off a wall? Is a coefficient of restitution what comes out?

use std::fs;

use crate::harness::{fresh_directory, run, run_in, Deck, Engine, Grain, Scene, ELASTIC};
use crate::meshes::sheet;
use crate::shapes::{about, Vector};

#[test]
fn energy_is_kept_to_the_order_of_the_integrator() {
    let engine = Engine::from_environment();
    let cases: [(&str, &str, Vector, Vector); 5] = [
        (
            "plane",
            "primitive type 1 zplane 0.0",
            [0.0, 0.0, 3.5e-3],
            [0.1, 0.05, -0.5],
        ),
        (
            "mesh",
            "mesh n_meshes 1 meshes sheet",
            [0.001, 0.002, 3.5e-3],
            [0.1, 0.05, -0.5],
        ),
        (
            "cylinder",
            "primitive type 1 zcylinder 0.01 0.0 0.0",
            [0.004, 0.003, 0.0],
            [0.4, -0.2, 0.1],
        ),
        (
            "narrow",
            "primitive type 1 zcylinder 0.0052 0.0 0.0",
            [0.0, 0.0005, 0.0],
            [0.1, -0.4, 0.1],
        ),
        (
            "pillar",
            "primitive type 1 zcylinder 0.006 0.0 0.0",
            [0.011, 0.001, 0.0],
            [-0.4, 0.05, 0.1],
        ),
    ];
    for (name, wall, position, velocity) in cases {
        let grain = Grain {
            density: 2500.0,
            ..Grain::new([5e-3, 2e-3, 1e-3], position)
        }
        .turned(about([0.1, 0.2, 0.05], 0.46))
        .moving(velocity);
        let scene = Scene::open(0.2, vec![grain]);
        let error = |time_step: f64| {
            let directory = fresh_directory(&format!("{name}_{time_step:e}"));
            let mut deck = Deck {
                time_step,
                steps: (0.016 / time_step) as u64,
                walls: vec![wall.into()],
                thermo: "step ke c_spin".into(),
                fixes: vec!["compute spin all erotate/superquadric".into()],
                ..Deck::new(ELASTIC, 0.0)
            };
            if name == "mesh" {
                fs::write(directory.join("sheet.stl"), sheet(4)).unwrap();
                deck.before = vec!["fix sheet all mesh/surface file sheet.stl type 1".into()];
            }
            let outcome = run_in(&engine, &directory, &scene, &deck, 1);
            let last = outcome.last().states[0].clone();
            assert!(
                last.force == [0.0; 3] && last.velocity != velocity,
                "{name}: no complete bounce"
            );
            let rows = outcome.thermo();
            let energy = |k: usize| rows[k]["KinEng"] + rows[k]["spin"];
            energy(rows.len() - 1) / energy(0) - 1.0
        };
        let (coarse, fine) = (error(8e-7), error(2e-7));
        println!("{name}: energy error {coarse:.1e} at 0.8 us, {fine:.1e} at 0.2 us");
        assert!(fine.abs() < 1e-7 && coarse.abs() < 4e-6, "{name}");
    }
}

/// `restitutionDamping on`: the coefficient of each pair of types, of grains and of a wall, head-on; in one call of the library
/// for the whole list and contact by contact. Viscosities are not asked for.
#[test]
fn restitution_of_each_pair_of_types_is_that_given() {
    let engine = Engine::from_environment();
    let speed = 0.1;
    let kinds = [(1, 1, 0.9), (1, 2, 0.5), (2, 2, 0.3)];
    for (what, every) in [("whole list", ""), ("contact by contact", "stress")] {
        // three head-on pairs, far from each other, and a grain of type 2 above a wall of type 1
        let mut grains = Vec::new();
        for (k, (a, b, _)) in kinds.into_iter().enumerate() {
            for (s, kind) in [(-1.0, a), (1.0, b)] {
                let mut grain = Grain {
                    density: 2500.0,
                    ..Grain::new([2e-3, 4e-3, 1e-3], [s * 2e-3, 0.03 * k as f64 - 0.03, 0.0])
                }
                .moving([-s * 0.5 * speed, 0.0, 0.0]);
                grain.kind = kind;
                grains.push(grain);
            }
        }
        let mut falling = Grain {
            density: 2500.0,
            ..Grain::new([2e-3, 4e-3, 1e-3], [0.03, 0.0, -0.05 + 1e-3])
        }
        .moving([0.0, 0.0, -speed]);
        falling.kind = 2;
        grains.push(falling);
        let mut scene = Scene::open(0.1, grains);
        scene.kinds = 2;
        let mut deck = Deck {
            settings: "restitutionDamping on".into(),
            walls: vec!["primitive type 1 zplane -0.05".into()],
            time_step: 2e-7,
            steps: 60_000,
            ..Deck::new(ELASTIC, 0.0)
        };
        deck.materials = vec![ELASTIC, [3.0 * ELASTIC[0], 0.2, 0.0, 0.0]];
        deck.restitution = vec![0.9, 0.5, 0.5, 0.3];
        if every == "stress" {
            deck.fixes = vec![
                "compute stress all stress/atom".into(),
                "fix often all ave/atom 1 1 1 c_stress[1]".into(),
            ];
        }
        let outcome = run(&engine, &format!("restitution_{every}"), &scene, &deck, 1);
        let last = outcome.last();
        for (k, (a, b, e)) in kinds.into_iter().enumerate() {
            let v = |k: usize| last.states[k].velocity[0];
            let got = (v(2 * k + 1) - v(2 * k)) / speed;
            println!("{what}, types {a} and {b}: {got:.6}, asked for {e}");
            assert!((got - e).abs() < 1e-3, "{what}, types {a} and {b}: {got}");
        }
        let got = last.states[6].velocity[2] / speed;
        println!("{what}, type 2 on a wall of type 1: {got:.6}, asked for 0.5");
        assert!((got - 0.5).abs() < 1e-3, "{what}, wall: {got}");
    }
}
