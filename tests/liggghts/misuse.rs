// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does everything that cannot be right stop with a message that names it?

use crate::harness::{attempt, last_lines, Deck, Engine, Grain, Scene, ELASTIC};

fn pair() -> Scene {
    let grain = |z: f64| Grain {
        density: 2500.0,
        ..Grain::new([5e-3, 4e-3, 3e-3], [0.0, 0.0, z])
    };
    Scene::open(0.1, vec![grain(-2.9e-3), grain(2.9e-3)])
}

fn refuse(name: &str, deck: Deck, words: &[&str]) {
    refuse_scene(name, &pair(), deck, words);
}

fn refuse_scene(name: &str, scene: &Scene, deck: Deck, words: &[&str]) {
    let engine = Engine::from_environment();
    let outcome = attempt(&engine, name, scene, &deck, 1);
    let output = outcome.output.to_lowercase();
    assert!(!outcome.success, "{name} was accepted");
    for word in words {
        assert!(
            output.contains(&word.to_lowercase()),
            "{name}: no '{word}' in\n{}",
            last_lines(&outcome.output)
        );
    }
}

fn plain() -> Deck {
    Deck {
        steps: 1,
        ..Deck::new(ELASTIC, 0.5)
    }
}

#[test]
fn another_blockiness() {
    refuse(
        "blockiness",
        Deck {
            before: vec!["set atom 2 blockiness 3 2".into()],
            ..plain()
        },
        &["particle 2", "blockiness 3 2"],
    );
}

/// LIGGGHTS itself refuses an axis of zero, but not one that is no number.
#[test]
fn axes_that_are_none() {
    let mut scene = pair();
    scene.grains[1].semi_axes[2] = f64::NAN;
    refuse_scene("nan", &scene, plain(), &["particle 2", "NaN"]);
    scene.grains[1].semi_axes[2] = 0.0;
    refuse_scene("zero", &scene, plain(), &["Invalid shape"]);
}

#[test]
fn a_missing_constant() {
    for (fix, name) in [
        ("viscosityShear", "viscosityShear"),
        ("viscosityBulk", "viscosityBulk"),
        ("youngsModulus", "youngsModulus"),
        ("coefficientFriction", "coefficientFriction"),
    ] {
        refuse(
            fix,
            Deck {
                fixes: vec![format!("unfix {fix}")],
                ..plain()
            },
            &[name],
        );
    }
}

#[test]
fn a_negative_viscosity() {
    refuse(
        "negative",
        Deck {
            materials: vec![[1e7, 0.3, -1.0, 0.0]],
            ..plain()
        },
        &["viscosityShear", "-1"],
    );
}

#[test]
fn atoms_that_are_spheres() {
    refuse(
        "spheres",
        Deck {
            atom_style: "sphere".into(),
            ..plain()
        },
        &["atom_style superquadric"],
    );
}

#[test]
fn the_engines_own_walls() {
    refuse(
        "wall",
        Deck {
            walls: vec!["primitive type 1 zplane -0.05".into()],
            wall_fix: "wall/gran".into(),
            ..plain()
        },
        &["wall/gran/ellipsoid"],
    );
}

#[test]
fn energies_that_are_not_there() {
    for word in ["computeElasticPotential", "computeDissipatedEnergy"] {
        refuse(
            word,
            Deck {
                settings: format!("{word} on"),
                ..plain()
            },
            &[word, "not available"],
        );
    }
}

#[test]
fn tfd_without_nfd() {
    refuse(
        "tfd",
        Deck {
            model: "hertz tangential tfd surface ellipsoid".into(),
            ..plain()
        },
        &["tangential tfd needs model nfd"],
    );
}
