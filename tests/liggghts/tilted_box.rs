// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is a periodic box that is a prism the lattice of grains that it stands for? A box tilted by half its length is, stacked twice, an upright one.

use std::fs;

use crate::decomposition::{deck, difference};
use crate::harness::{
    crowd, data, execute, fresh_directory, run_in, Deck, Engine, Frame, Outcome, Scene,
};
use crate::shapes::add;

const STEPS: u64 = 300;

/// `scene` in a box with these tilts xy, xz, yz.
fn tilted(engine: &Engine, scene: &Scene, deck: &Deck, tilt: [f64; 3], ranks: usize) -> Outcome {
    let directory = fresh_directory("tilted");
    let [xy, xz, yz] = tilt;
    let text = data(scene, "superquadric").replace(
        " zlo zhi\n",
        &format!(" zlo zhi\n{xy:e} {xz:e} {yz:e} xy xz yz\n"),
    );
    fs::write(directory.join("scene.data"), text).unwrap();
    let text = deck.text(scene, "scene.data", "frames");
    let (success, output) = execute(engine, &directory, &text, ranks);
    let first = Outcome::read(directory.clone(), success, output).succeeded();
    assert!(first.output.contains("triclinic box"));
    let rest = Deck {
        source: vec!["read_restart half".into()],
        runs: vec![format!("run {}", STEPS / 2)],
        ..deck.clone()
    };
    run_in(engine, &directory, scene, &rest, 3 - ranks)
}

#[test]
fn a_tilted_box_is_the_lattice_that_it_stands_for() {
    let engine = Engine::from_environment();
    let once = crowd(27);
    let [x, y, z] = once.high;
    for (axis, tilt) in [
        (1, [0.5 * x, 0.0, 0.0]),
        (2, [0.0, 0.5 * x, 0.0]),
        (2, [0.0, 0.5 * x, 0.5 * y]),
    ] {
        let [xy, xz, yz] = tilt;
        let shift = if axis == 1 { [xy, y, 0.0] } else { [xz, yz, z] };
        let mut stacked = once.clone();
        stacked.high[axis] *= 2.0;
        for grain in &once.grains {
            let mut copy = grain.clone();
            copy.position = add(copy.position, shift);
            for (place, high) in copy.position.iter_mut().zip(stacked.high) {
                *place %= high;
            }
            stacked.grains.push(copy);
        }
        let runs = vec![
            format!("run {}", STEPS / 2),
            "write_restart half".into(),
            format!("run {}", STEPS / 2),
        ];
        let deck = Deck {
            runs,
            ..deck(STEPS)
        };
        let upright = run_in(&engine, &fresh_directory("upright"), &stacked, &deck, 1);
        let mut expected: Frame = upright.last().clone();
        let copies = expected.states.split_off(once.grains.len());
        let copies = Frame {
            step: STEPS,
            states: copies,
        };
        assert!(difference(&copies, &expected) < 1e-9);
        for ranks in [1, 2] {
            let outcome = tilted(&engine, &once, &deck, tilt, ranks);
            let apart = difference(outcome.last(), &expected);
            println!("tilt {tilt:?}, {ranks} ranks, then another number: velocities apart by {apart:.1e}");
            assert_eq!(outcome.last().step, STEPS);
            assert!(apart < 1e-9);
        }
    }
}
