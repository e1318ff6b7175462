// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is energy kept when an elastic, frictionless ellipsoid bounces off a wall?

use std::fs;

use crate::harness::{fresh_directory, run_in, Deck, Engine, Grain, Scene, ELASTIC};
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
