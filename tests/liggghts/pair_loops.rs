// SPDX-License-Identifier: MIT OR Apache-2.0
//! The whole neighbour list in one call, and LIGGGHTS' own loop contact by contact: is the motion the same?
//!
//! Our loop leaves the steps to LIGGGHTS' own in which the virial is asked for, so that output of stresses chooses.

use crate::decomposition::{deck, difference};
use crate::harness::{crowd, run, Deck, Engine};

const STEPS: u64 = 300;

#[test]
fn both_loops_move_the_grains_alike() {
    let engine = Engine::from_environment();
    let mut scene = crowd(64);
    for (k, grain) in scene.grains.iter_mut().enumerate() {
        grain.kind = 1 + k % 2;
    }
    scene.kinds = 2;
    for model in [
        "nfd tangential tfd surface ellipsoid",
        "nfd surface ellipsoid",
    ] {
        let [seldom, sometimes, always] = [STEPS, 7, 1].map(|every| {
            let deck = Deck {
                model: model.into(),
                materials: vec![[1e8, 0.3, 2000.0, 3000.0], [3e7, 0.2, 500.0, 800.0]],
                fixes: vec![
                    "compute stress all stress/atom".into(),
                    "compute sum all reduce sum c_stress[1]".into(),
                ],
                thermo: "step ke c_sum".into(),
                // shapes that change between runs, with the neighbour list of before
                runs: vec![
                    format!("thermo {every}"),
                    format!("run {}", STEPS / 2),
                    "set type 2 shape 1.2e-2 1.1e-2 0.6e-2".into(),
                    format!("run {} pre no", STEPS / 2),
                ],
                ..deck(STEPS)
            };
            run(
                &engine,
                &format!("{model} {every}").replace(' ', "_"),
                &scene,
                &deck,
                1,
            )
        });
        let frames = [&sometimes, &always].map(|o| difference(o.last(), seldom.last()));
        println!(
            "{model}: velocities apart by {:.1e} and {:.1e}",
            frames[0], frames[1]
        );
        assert!(frames.iter().all(|apart| *apart < 1e-9), "{frames:?}");
    }
}
