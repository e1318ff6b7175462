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
fn in_tilted_box(
    engine: &Engine,
    scene: &Scene,
    deck: &Deck,
    tilt: [f64; 3],
    ranks: usize,
) -> Outcome {
    let directory = fresh_directory("tilted");
    let [xy, xz, yz] = tilt;
    let text = data(scene, "superquadric").replace(
        " zlo zhi\n",
        &format!(" zlo zhi\n{xy:e} {xz:e} {yz:e} xy xz yz\n"),
    );
    fs::write(directory.join("scene.data"), text).unwrap();
    let text = deck.text(scene, "scene.data", "frames");
    let (success, output) = execute(engine, &directory, &text, ranks);
    let outcome = Outcome::read(directory, success, output).succeeded();
    assert!(outcome.output.contains("triclinic box"));
    outcome
}

/// The second half of it, from a restart file and on another number of ranks.
fn tilted(engine: &Engine, scene: &Scene, deck: &Deck, tilt: [f64; 3], ranks: usize) -> Outcome {
    let directory = in_tilted_box(engine, scene, deck, tilt, ranks).directory;
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

/// `replicate` itself put copies where those of an upright box are.
#[test]
fn copies_of_a_tilted_box_go_on_as_the_box_alone() {
    let engine = Engine::from_environment();
    let scene = crowd(27);
    let [x, y, z] = scene.high;
    let runs = |between: &[String]| {
        let half = [format!("run {}", STEPS / 2)];
        [&half[..], between, &half[..]].concat()
    };
    for (tilt, [nx, ny, nz]) in [
        ([-0.4 * x, 0.0, 0.0], [2, 2, 1]),
        ([0.0, 0.4 * x, 0.0], [2, 1, 2]),
        ([0.3 * x, -0.2 * x, 0.4 * y], [2, 2, 2]),
    ] {
        let end = |between: &[String]| {
            let deck = Deck {
                runs: runs(between),
                ..deck(STEPS)
            };
            let outcome = in_tilted_box(&engine, &scene, &deck, tilt, 1);
            outcome.last().clone()
        };
        let alone = end(&[]);
        let mut copies = end(&[format!(
            "replicate {nx} {ny} {nz} offset {x} {y} {z} shift 0 0 0"
        )]);
        assert_eq!(copies.states.len(), nx * ny * nz * scene.grains.len());
        while !copies.states.is_empty() {
            let rest = copies.states.split_off(scene.grains.len());
            let apart = difference(&copies, &alone);
            println!("tilt {tilt:?}: velocities of a copy apart by {apart:.1e}");
            assert!(apart < 1e-9, "tilt {tilt:?}: {apart:e}");
            copies.states = rest;
        }
    }
}
