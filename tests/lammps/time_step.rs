// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does `compute timestep/ellipsoid` say the step that the contacts of a scene allow, and does a run warn of a longer one?

use std::f64::consts::PI;

use crate::engines::pressed::{pressed, CELL};
use crate::harness::{attempt, run, Deck, Engine, Grain, Outcome, Scene};
use crate::shapes::{scale, Random};

const WARNING: &str = "the largest with which the contacts that exist now are stable";

fn values(outcome: &Outcome) -> Vec<[f64; 5]> {
    outcome
        .thermo()
        .iter()
        .map(|row| std::array::from_fn(|k| row[&format!("c_step[{}]", k + 1)]))
        .collect()
}

fn asks(law: &str) -> Deck {
    Deck {
        fixes: vec!["compute step all timestep/ellipsoid".into()],
        thermo_columns: "step pe ke c_step[*]".into(),
        thermo_every: 1,
        skin: 1e-3,
        time_step: 1e-7,
        ..Deck::new(law)
    }
}

/// The box of the pressed grains.
fn in_a_box(law: &str, side: usize) -> Deck {
    let mut deck = asks(law);
    let edge = side as f64 * CELL;
    for axis in ["x", "y", "z"] {
        deck.fixes.push(format!(
            "fix {axis}walls all wall/gran/ellipsoid {law} {axis}plane 0 {edge}"
        ));
    }
    deck
}

/// Hertz' stiffness of two spheres, and of one on a wall.
#[test]
fn both_versions_spheres_and_a_wall() {
    let engine = Engine::from_environment();
    let (e, nu, radius, overlap) = (1e7, 0.3, 1e-3, 1e-6);
    let modulus = e / (2.0 * (1.0 - nu * nu));
    let mass = 1000.0 * 4.0 / 3.0 * PI * f64::powi(radius, 3);
    let law = format!("hertz {e} {nu}");

    let pair = Scene::open(
        0.01,
        vec![
            Grain::sphere(radius, [0.0; 3]),
            Grain::sphere(radius, [0.0, 0.0, 2.0 * radius - overlap]),
        ],
    );
    let [step, collision, for_error, deepest, atom] =
        values(&run(&engine, "step_pair", &pair, &asks(&law), 1))[0];
    let stiffness = 2.0 * modulus * (0.5 * radius * overlap).sqrt();
    let expected = 2.0 / (2.0 * stiffness / mass).sqrt();
    assert!((step / expected - 1.0).abs() < 1e-5, "{step} {expected}");
    assert!((deepest / (overlap / radius) - 1.0).abs() < 1e-6);
    assert!(atom == 1.0 || atom == 2.0, "{atom}");
    // at rest: the collision whose greatest depth this is
    let speed =
        (8.0 / 15.0 * modulus * (0.5 * radius).sqrt() * overlap.powf(2.5) * 4.0 / mass).sqrt();
    let expected = 2.943_275_1 * overlap / speed;
    assert!(
        (collision / expected - 1.0).abs() < 1e-5,
        "{collision} {expected}"
    );
    assert!(for_error < step && for_error > collision / 200.0);

    // on a wall, moving towards it
    let speed = 0.1;
    let ball = Grain::sphere(radius, [0.0, 0.0, radius - overlap]).moving([0.0, 0.0, -speed]);
    let mut deck = asks(&law);
    deck.fixes.push(format!(
        "fix floor all wall/gran/ellipsoid {law} zplane 0 NULL"
    ));
    let [step, collision, _, _, atom] = values(&run(
        &engine,
        "step_wall",
        &Scene::open(0.01, vec![ball]),
        &deck,
        1,
    ))[0];
    let stiffness = 2.0 * modulus * (radius * overlap).sqrt();
    let expected = 2.0 / (stiffness / mass).sqrt();
    assert!((step / expected - 1.0).abs() < 1e-5, "{step} {expected}");
    let deepest = (1.25 * mass * speed * speed / (4.0 / 3.0 * modulus * radius.sqrt())).powf(0.4);
    let expected = 2.943_275_1 * deepest / speed;
    assert!(
        (collision / expected - 1.0).abs() < 1e-3,
        "{collision} {expected}"
    );
    assert_eq!(atom, 1.0);

    // nothing touches
    let apart = Scene::open(
        0.01,
        vec![
            Grain::sphere(radius, [0.0; 3]),
            Grain::sphere(radius, [0.0, 0.0, 2.5 * radius]),
        ],
    );
    let none = values(&run(&engine, "step_none", &apart, &asks(&law), 1))[0];
    assert!(
        none[..3].iter().all(|v| *v == f64::INFINITY) && none[3..] == [0.0; 2],
        "{none:?}"
    );

    // a frozen grain has no share in the motion
    let mut deck = asks(&law);
    deck.fixes
        .extend(["group first id 1".into(), "fix still first freeze".into()]);
    let frozen = values(&run(&engine, "step_frozen", &pair, &deck, 1))[0];
    let stiffness = 2.0 * modulus * (0.5 * radius * overlap).sqrt();
    let expected = 2.0 / (stiffness / mass).sqrt();
    assert!(
        (frozen[0] / expected - 1.0).abs() < 1e-5,
        "{frozen:?} {expected}"
    );
    assert_eq!(frozen[4], 2.0);
}

#[test]
fn both_versions_the_same_on_any_number_of_ranks() {
    let engine = Engine::from_environment();
    let law = "nfd 1e6 0.3 20 20 tangential tfd 0.5";
    let scene = pressed(4, 0.05);
    let deck = |newton| Deck {
        newton,
        steps: 50,
        thermo_every: 50,
        time_step: 2e-6,
        ..in_a_box(law, 4)
    };
    let one = values(&run(&engine, "step_1", &scene, &deck(true), 1));
    println!("{one:?}");
    assert!(one.len() == 2 && one.iter().flatten().all(|v| v.is_finite() && *v > 0.0));
    for (ranks, newton) in [(4, true), (4, false), (1, false)] {
        let name = format!("step_{ranks}_{newton}");
        let other = values(&run(&engine, &name, &scene, &deck(newton), ranks));
        for (at, (a, b)) in one.iter().zip(&other).enumerate() {
            for (k, (a, b)) in a.iter().zip(b).enumerate() {
                // ghosts have velocities of the half step once there was one
                let tolerance = if at == 1 && (k == 1 || k == 2) {
                    1e-3
                } else {
                    1e-9
                };
                assert!(
                    (a / b - 1.0).abs() < tolerance,
                    "{name}, value {}: {a} {b}",
                    k + 1
                );
            }
        }
    }
}

/// Grains in the densest packing, pressed in a periodic box, drawn out along one axis.
fn lattice(stretch: [f64; 3]) -> Scene {
    let mut random = Random(5);
    let cells = 3;
    let edge = 2.0 * 2f64.sqrt() * 1e-3 * (1.0 - 1e-4);
    let mut grains = vec![];
    for k in 0..cells * cells * cells * 4 {
        let (cell, place) = (k / 4, k % 4);
        let corner = [cell % cells, cell / cells % cells, cell / cells / cells].map(|c| c as f64);
        let inside = [[0.0; 3], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5], [0.5, 0.5, 0.0]][place];
        let position = std::array::from_fn(|a| edge * stretch[a] * (corner[a] + inside[a] + 0.25));
        // a thousandth of the overlap in the time of a contact
        grains.push(
            Grain::new(scale(1e-3, stretch), position).moving(scale(2e-6, random.direction())),
        );
    }
    Scene::periodic([0.0; 3], stretch.map(|s| s * edge * cells as f64), grains)
}

/// With nine tenths of the advised step a pressed packing stays as calm as it was; it blows up with a quarter more than the advised one
/// without friction, with twice that with friction, which dissipates what the step creates for a while.
#[test]
fn below_the_advised_step_a_packing_stays_and_well_above_it_blows_up() {
    let engine = Engine::from_environment();
    for (name, law, stretch, factor) in [
        ("elastic", "hertz 1e7 0.3", [1.0; 3], 1.25),
        (
            "viscous",
            "nfd 1e7 0.3 100 100 tangential tfd 0.5",
            [2.0, 1.0, 1.0],
            2.0,
        ),
    ] {
        let scene = lattice(stretch);
        let with = |factor: f64, step: f64, steps: u64| {
            let deck = Deck {
                time_step: factor * step,
                steps,
                thermo_every: steps.max(1),
                skin: 2e-4,
                fixes: vec![
                    "compute step all timestep/ellipsoid".into(),
                    "compute turning all erotate/asphere".into(),
                ],
                thermo_columns: "step pe ke c_turning c_step[*]".into(),
                ..Deck::new(law)
            };
            attempt(&engine, &format!("step_{name}_{factor}"), &scene, &deck, 1)
        };
        let step = values(&with(1.0, 1e-9, 0).succeeded())[0][0];
        let motion = |outcome: &Outcome| {
            let rows = outcome.thermo();
            let of =
                |row: &std::collections::HashMap<String, f64>| row["KinEng"] + row["c_turning"];
            of(rows.last().unwrap()) / of(&rows[0])
        };
        let below = with(0.9, step, 2000).succeeded();
        assert!(!below.output.contains(WARNING), "{name}");
        let kept = motion(&below);
        let above = with(factor, step, 400);
        assert_eq!(above.output.matches(WARNING).count(), 1, "{name}");
        // Grains that fly end the run in the middle.
        let grown = if above.success {
            motion(&above)
        } else {
            f64::INFINITY
        };
        println!("{name}: step {step:.3e}, motion times {kept:.2} at 0.9 of it, times {grown:.1e} at {factor}");
        assert!(kept < 3.0, "{name}: {kept}");
        assert!(grown > 1e4, "{name}: {grown}");
    }
}

/// Once for a step, however many runs.
#[test]
fn both_versions_a_longer_step_is_warned_of_once() {
    let engine = Engine::from_environment();
    let law = "nfd 1e6 0.3 20 20 tangential tfd 0.5";
    let scene = pressed(2, 0.0);
    let step = values(&run(
        &engine,
        "step_warned_ask",
        &scene,
        &in_a_box(law, 2),
        1,
    ))[0][0];
    let with = |factor: f64| {
        let deck = Deck {
            time_step: factor * step,
            runs: vec!["run 1".into(), "run 1".into(), "run 1 pre no".into()],
            ..in_a_box(law, 2)
        };
        let outcome = run(&engine, &format!("step_warned_{factor}"), &scene, &deck, 2);
        outcome.output.matches(WARNING).count()
    };
    assert_eq!(with(0.9), 0);
    assert_eq!(with(1.1), 1);
}
