// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do grains of a data file begin as it says, and do commands that take its words back say so?

use std::fs;

use crate::harness::{
    attempt_in, fresh_directory, last_rows, Deck, Engine, Outcome, Scene, ELASTIC,
};
use crate::shapes::{length, sub, Vector};

const SPIN: [Vector; 2] = [[10.0, 20.0, 30.0], [0.0, -40.0, 100.0]];

fn data() -> String {
    let mut text = String::from(
        "two grains\n\n2 atoms\n1 atom types\n-0.02 0.02 xlo xhi\n-0.02 0.02 ylo yhi\n-0.02 0.02 zlo zhi\n\nAtoms\n\n\
         1 1 2500 0.004 0.003 0.002 2 2 0 0 0\n2 1 2500 0.004 0.003 0.002 2 2 1.5e-2 2e-3 -5e-3\n\nVelocities\n\n",
    );
    for (k, [x, y, z]) in SPIN.iter().enumerate() {
        text += &format!("{} 0 0 0 {x} {y} {z}\n", k + 1);
    }
    text
}

fn deck(integrator: &'static str) -> Deck {
    Deck {
        source: vec![
            "read_data grains.data".into(),
            "set atom 2 quat_direct 0.6 0 0.8 0".into(),
        ],
        integrator,
        time_step: 1e-9,
        steps: 10,
        ..Deck::new(ELASTIC, 0.5)
    }
}

fn run(name: &str, deck: &Deck, ranks: usize) -> Outcome {
    let directory = fresh_directory(name);
    fs::write(directory.join("grains.data"), data()).unwrap();
    let scene = Scene {
        boundary: "p p p".into(),
        ..Scene::open(0.02, vec![])
    };
    attempt_in(&Engine::from_environment(), &directory, &scene, deck, ranks)
}

fn spins(outcome: &Outcome, file: &str) -> Vec<Vector> {
    last_rows(&outcome.directory.join(file))
        .iter()
        .map(|row| [row[1], row[2], row[3]])
        .collect()
}

fn deck_that_dumps(integrator: &'static str) -> Deck {
    let mut deck = deck(integrator);
    deck.fixes.extend([
        "dump spins all custom 10 spins id omegax omegay omegaz".into(),
        "dump_modify spins sort id format \"%d %.17g %.17g %.17g\"".into(),
    ]);
    deck
}

#[test]
fn grains_turn_with_the_angular_velocities_of_the_file() {
    for integrator in ["ellipsoid", "ellipsoid velocities half", "superquadric"] {
        for ranks in [1, 2] {
            let outcome = run("spins", &deck_that_dumps(integrator), ranks).succeeded();
            let spins = spins(&outcome, "spins");
            let apart = spins.iter().zip(&SPIN).map(|(a, b)| length(sub(*a, *b)));
            let worst = apart.fold(0.0, f64::max);
            println!("nve/{integrator}, {ranks} ranks: angular velocities apart by {worst:.1e}");
            assert_eq!(spins.len(), 2);
            assert!(worst < 1e-4, "{spins:?}");
            assert!(!outcome.output.contains("angular velocity does not belong"));
        }
    }
}

/// 'velocity' stops grains by their angular momenta alone, between two runs and after a restart.
#[test]
fn grains_that_were_stopped_stay_stopped() {
    let stop = "velocity all setAngular 0 0 0";
    let mut split = deck_that_dumps("superquadric");
    split.runs = ["run 5", "write_restart stopped", stop, "run 5"]
        .map(String::from)
        .to_vec();
    let outcome = run("stopped", &split, 1).succeeded();
    assert_eq!(spins(&outcome, "spins"), vec![[0.0; 3]; 2]);

    let mut restarted = deck_that_dumps("superquadric");
    restarted.source = ["read_restart stopped", stop].map(String::from).to_vec();
    restarted.steps = 5;
    let again = attempt_in(
        &Engine::from_environment(),
        &outcome.directory,
        &Scene::open(0.02, vec![]),
        &restarted,
        1,
    )
    .succeeded();
    assert_eq!(spins(&again, "spins"), vec![[0.0; 3]; 2]);
}

/// What is written of a coordinate before its point or exponent is no image flag.
#[test]
fn coordinates_are_no_image_flags() {
    let mut deck = deck("ellipsoid");
    deck.fixes = vec!["compute mid all com".into()];
    deck.thermo = "step c_mid[1] c_mid[2] c_mid[3]".into();
    let outcome = run("images", &deck, 1).succeeded();
    for (state, position) in outcome
        .first()
        .states
        .iter()
        .zip([[0.0; 3], [1.5e-2, 2e-3, -5e-3]])
    {
        assert!(length(sub(state.position, position)) < 1e-12, "{state:?}");
    }
    let row = &outcome.thermo()[0];
    for (k, centre) in [7.5e-3, 1e-3, -2.5e-3].into_iter().enumerate() {
        let told = row[&format!("mid[{}]", k + 1)];
        assert!((told - centre).abs() < 1e-12, "{row:?}");
    }

    // three more words are image flags
    let with_images = data()
        .replace("-5e-3\n", "-5e-3 0 1 -1\n")
        .replace("2 2 0 0 0\n", "2 2 0 0 0 0 0 0\n");
    let directory = fresh_directory("flags");
    fs::write(directory.join("grains.data"), with_images).unwrap();
    let scene = Scene {
        boundary: "p p p".into(),
        ..Scene::open(0.02, vec![])
    };
    let outcome = attempt_in(&Engine::from_environment(), &directory, &scene, &deck, 1).succeeded();
    let position = outcome.first().states[1].position;
    assert!(
        length(sub(position, [1.5e-2, 4.2e-2, -4.5e-2])) < 1e-12,
        "{position:?}"
    );
}

#[test]
fn a_spin_that_a_later_command_made_another_is_told_of() {
    for (words, warned) in [
        (
            &["set atom 1 omegax 30", "set atom 1 shape 0.005 0.003 0.002"][..],
            true,
        ),
        (
            &["set atom 1 omegax 30", "set atom 1 quat_direct 0.6 0 0 0.8"],
            true,
        ),
        (
            &["set atom 1 shape 0.005 0.003 0.002", "set atom 1 omegax 30"],
            false,
        ),
    ] {
        let mut deck = deck("ellipsoid");
        deck.source
            .extend(words.iter().map(|word| word.to_string()));
        let outcome = run("later", &deck, 2).succeeded();
        let said = outcome
            .output
            .matches("particle 1: its angular velocity does not belong to its angular momentum")
            .count();
        // on the screen alone, once
        assert_eq!(said, usize::from(warned), "{words:?}: {}", outcome.output);
    }
}

#[test]
fn moments_of_inertia_that_are_not_those_of_the_shape_are_told_of() {
    for (word, warned) in [
        ("set atom 2 mass 1e-3", true),
        ("set atom 2 inertiax 1e-8", true),
        ("set atom 2 density 4000", false),
    ] {
        let mut deck = deck("ellipsoid");
        deck.fixes = vec![word.into()];
        deck.runs = ["run 5", "run 5"].map(String::from).to_vec();
        let outcome = run("inertia", &deck, 2).succeeded();
        let said = outcome
            .output
            .matches("particle 2 turns as a solid ellipsoid of its mass and shape")
            .count();
        assert_eq!(said, usize::from(warned), "{word}: {}", outcome.output);
    }
}
