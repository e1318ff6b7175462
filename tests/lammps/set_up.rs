// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does the log, when a run starts, say what a user would otherwise find out too late, and no more than can be read?

use crate::harness::{attempt, Deck, Engine, Grain, Outcome, Scene};

const LAW: &str = "hertz 1e7 0.3";

fn grains(densities: &[f64]) -> Scene {
    let mut scene = Scene::open(
        10.0,
        (0..densities.len())
            .map(|k| Grain::new([0.5, 0.4, 0.3], [3.0 * k as f64 - 4.0, 0.0, 0.0]))
            .collect(),
    );
    for (k, density) in densities.iter().enumerate() {
        scene.grains[k].density = *density;
        scene.grains[k].kind = k + 1;
    }
    scene.kinds = densities.len();
    scene
}

fn started(name: &str, scene: &Scene, deck: &Deck) -> Outcome {
    let outcome = attempt(&Engine::from_environment(), name, scene, deck, 1);
    assert!(outcome.success, "{name}:\n{}", outcome.output);
    outcome
}

/// LAMMPS breaks long warnings into lines.
fn on_one_line(outcome: &Outcome) -> String {
    outcome
        .output
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
}

#[test]
fn both_versions_masses_that_cannot_be_meant_are_warned_of() {
    let scene = grains(&[2500.0, 2600.0]);
    let warning = |name: &str, scene: &Scene, commands: &[&str]| {
        let deck = Deck {
            fixes: commands.iter().map(|c| c.to_string()).collect(),
            ..Deck::new(LAW)
        };
        let text = on_one_line(&started(name, scene, &deck));
        println!("{name}: {}", text.contains("WARNING"));
        text
    };
    let fine = warning("plausible", &scene, &[]);
    assert!(!fine.contains("WARNING"), "{fine}");

    let never = warning(
        "never_set",
        &scene,
        &[
            "create_atoms 2 single 0.0 4.0 0.0",
            "group new id 3",
            "set group new shape 1.0 0.8 0.6",
            "set type 2 mass 1.0",
        ],
    );
    assert!(never.contains("type 2 has a mass of exactly 1"), "{never}");
    assert!(never.contains("'set type N density ...'"), "{never}");

    let too_early = warning(
        "density_before_shape",
        &scene,
        &[
            "set type 2 shape 0.0 0.0 0.0",
            "set type 2 density 2500",
            "set type 2 shape 1e-3 1e-3 1e-3",
        ],
    );
    assert!(
        too_early.contains("density that is set before the shape becomes the mass"),
        "{too_early}"
    );

    let apart = warning("far_apart", &grains(&[0.1, 2500.0]), &[]);
    assert!(apart.contains("differ by a factor of 2.5e+04"), "{apart}");
}

#[test]
fn both_versions_the_log_shows_twenty_laws_at_the_most() {
    let kinds = 30;
    let scene = grains(&vec![2500.0; kinds]);
    let mut pair = vec!["pair_style gran/ellipsoid".to_string()];
    for kind in 1..=kinds {
        pair.push(format!("pair_coeff {kind} {kind} hertz {kind}e6 0.3"));
    }
    let mut wide = scene.clone();
    wide.low = [-200.0; 3];
    wide.high = [200.0; 3];
    let outcome = started("many_types", &wide, &Deck::with_pair(pair));
    let lines = outcome
        .output
        .lines()
        .filter(|line| line.contains("hertz E*"))
        .count();
    assert_eq!(lines, 20, "{}", outcome.output);
    assert!(
        outcome
            .output
            .contains("and 445 more pairs of types (10 given, 435 mixed)"),
        "{}",
        outcome.output
    );
}

#[test]
fn both_versions_a_deck_without_friction_warns_of_no_history() {
    let scene = grains(&[2500.0]);
    let deck = Deck {
        runs: vec![
            "run 0".into(),
            "pair_coeff * * hertz 1e7 0.3".into(),
            "set type 1 shape 1.0 1.0 1.0".into(),
            "run 0".into(),
        ],
        ..Deck::new("hertz 1e7 0.3")
    };
    let text = on_one_line(&started("no_history", &scene, &deck));
    assert!(!text.contains("WARNING"), "{text}");
}

/// The limits stand in the log, and a step or a viscosity beyond them is warned of before it ends as `Lost atoms`.
#[test]
fn both_versions_a_time_step_that_is_too_long_is_warned_of() {
    let scene = grains(&[2500.0]);
    let text = |name: &str, law: &str, step: f64, speed: f64| {
        let mut scene = scene.clone();
        scene.grains[0].velocity = [speed, 0.0, 0.0];
        let deck = Deck {
            time_step: step,
            ..Deck::new(law)
        };
        on_one_line(&started(name, &scene, &deck))
    };
    // Semi-axes 0.5, 0.4, 0.3: Rayleigh's time is 0.0261 (G 3.846e6, density 2500, r 0.3).
    let fine = text("a_short_step", LAW, 1e-4, 1.0);
    assert!(!fine.contains("WARNING"), "{fine}");
    assert!(fine.contains("Rayleigh time 0.02596 (type 1)"), "{fine}");
    assert!(fine.contains("shortest collision"), "{fine}");
    let at_rest = text("at_rest", LAW, 1e-4, 0.0);
    assert!(at_rest.contains("nothing moves yet"), "{at_rest}");

    let coarse = text("a_coarse_step", LAW, 1e-2, 1.0);
    assert!(coarse.contains("fewer than 10 time steps"), "{coarse}");
    let long = text("a_long_step", LAW, 1.0, 0.0);
    assert!(
        long.contains("with which a contact of types 1 and 1 is still stable"),
        "{long}"
    );
    // What the step allows without viscosity it does not with much of it.
    let viscous = text("a_viscosity", "nfd 1e7 0.3 1e8 1e8", 1e-4, 1.0);
    assert!(viscous.contains("is still stable"), "{viscous}");
}
