// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rolling and twisting: are spheres resisted as by LAMMPS' own `pair_style granular` and `fix wall/gran`, do ranks and restarts agree, and
//! does the balance of energies close?

use crate::harness::{
    attempt_in, crowd, largest_difference, last_lines, run, Deck, Engine, Frame, Grain, Outcome,
    Scene,
};
use crate::shapes::{inertia, length, scale, sub, Vector};

const MODULUS: f64 = 1e8;
const POISSON: f64 = 0.3;
const RADIUS: f64 = 1e-3;

/// Two spheres of different size that overlap by this, with these velocities and angular velocities.
fn two(overlap: f64, speed: f64, spins: [Vector; 2]) -> Scene {
    let (r, s) = (RADIUS, 0.7 * RADIUS);
    let mut grains = vec![
        Grain::sphere(r, [0.0; 3]).moving([speed, 0.0, 0.0]),
        Grain::sphere(s, [r + s - overlap, 0.0, 0.0]).moving([-speed, 0.0, 0.0]),
    ];
    for (grain, spin) in grains.iter_mut().zip(spins) {
        grain.density = 2500.0;
        *grain = grain.clone().spinning(spin);
    }
    Scene::open(0.01, grains)
}

fn settings(deck: Deck, fixes: &[String]) -> Deck {
    Deck {
        time_step: 1e-7,
        steps: 600,
        dump_every: 20,
        skin: 2e-4,
        fixes: fixes.to_vec(),
        ..deck
    }
}

/// Angular velocities of spheres in a frame of either engine style.
fn spins(scene: &Scene, frame: &Frame) -> Vec<Vector> {
    scene
        .grains
        .iter()
        .zip(&frame.states)
        .map(|(g, s)| {
            if s.angular_velocity == [0.0; 3] {
                scale(1.0 / inertia(g.mass(), g.semi_axes)[0], s.angular_momentum)
            } else {
                s.angular_velocity
            }
        })
        .collect()
}

/// Largest difference of torques and of angular velocities in all frames, relative to the largest.
fn apart(scene: &Scene, ours: &Outcome, theirs: &Outcome) -> f64 {
    assert_eq!(ours.frames.len(), theirs.frames.len());
    let (mut torque, mut most_torque, mut spin, mut most_spin) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    for (a, b) in ours.frames.iter().zip(&theirs.frames) {
        for (s, t) in a.states.iter().zip(&b.states) {
            torque = torque.max(length(sub(s.torque, t.torque)));
            most_torque = most_torque.max(length(t.torque));
        }
        for (s, t) in spins(scene, a).into_iter().zip(spins(scene, b)) {
            spin = spin.max(length(sub(s, t)));
            most_spin = most_spin.max(length(t));
        }
    }
    assert!(most_torque > 0.0 && most_spin > 0.0);
    let first = &spins(scene, ours.first())[0];
    let last = &spins(scene, ours.last())[0];
    let turned = length(sub(*first, *last)) / most_spin;
    println!(
        "  torques apart by {:.1e}, angular velocities by {:.1e}; these changed by {turned:.2}",
        torque / most_torque,
        spin / most_spin
    );
    assert!(turned > 0.01, "nothing was resisted");
    (torque / most_torque).max(spin / most_spin)
}

fn hertz(rest: &str) -> [Deck; 2] {
    [
        Deck::new(&format!("hertz {MODULUS} {POISSON} {rest}")),
        Deck::built_in_spheres(vec![
            "pair_style granular".into(),
            format!("pair_coeff * * hertz/material {MODULUS} 0.0 {POISSON} tangential linear_nohistory 0.0 0.0 {rest}"),
        ]),
    ]
}

fn compare(name: &str, scene: &Scene, decks: [Deck; 2]) -> f64 {
    let engine = Engine::from_environment();
    println!("{name}");
    let [ours, theirs] = decks;
    let ours = run(&engine, &format!("{name}_ours"), scene, &ours, 1);
    let theirs = run(&engine, &format!("{name}_granular"), scene, &theirs, 1);
    apart(scene, &ours, &theirs)
}

/// Spheres in collision roll on one another, in a plane, so that what is remembered turns in it alone: spring and dashpot below the limit,
/// and a slider without a dashpot.
#[test]
fn both_versions_spheres_roll_as_in_granular() {
    let scene = two(5e-6, 0.05, [[0.0, 0.0, 40.0], [0.0, 0.0, 25.0]]);
    for (name, words) in [
        ("roll_spring", "rolling sds 2e4 0.2 10"),
        ("roll_slider", "rolling sds 2e4 0 0.05"),
    ] {
        let decks = hertz(words).map(|deck| settings(deck, &[]));
        let apart = compare(name, &scene, decks);
        assert!(apart < 1e-10, "{name}: {apart:e}");
    }
}

#[test]
fn both_versions_spheres_twist_as_in_granular() {
    let scene = two(5e-6, 0.05, [[60.0, 0.0, 0.0], [-20.0, 0.0, 0.0]]);
    for (name, words) in [
        ("twist_spring", "twisting sds 0.05 1e-7 1"),
        ("twist_slider", "twisting sds 0.05 0 1e-5"),
    ] {
        let decks = hertz(words).map(|deck| settings(deck, &[]));
        let apart = compare(name, &scene, decks);
        assert!(apart < 1e-10, "{name}: {apart:e}");
    }
}

/// At a steady overlap, with a constant tangential stiffness: there the two laws are the same.
#[test]
fn both_versions_spheres_twist_as_marshall_says() {
    let scene = two(5e-6, 0.0, [[60.0, 0.0, 0.0], [-20.0, 0.0, 0.0]]);
    let held = ["fix held all setforce 0 0 0".to_string()];
    for (name, kt, ct, mu) in [
        ("marshall_spring", 2e4, 0.02, 100.0),
        ("marshall_slider", 2e4, 0.0, 0.3),
    ] {
        let (kn, cn) = (1e4, 0.04);
        let decks = [
            Deck::new(&format!(
                "lsd {kn} {cn} tangential linear {kt} {ct} {mu} twisting marshall"
            )),
            Deck::built_in_spheres(vec![
                "pair_style granular".into(),
                format!(
                    "pair_coeff * * hooke {kn} {cn} tangential linear_history {kt} {} {mu} twisting marshall damping velocity",
                    ct / cn
                ),
            ]),
        ]
        .map(|deck| settings(deck, &held));
        let apart = compare(name, &scene, decks);
        assert!(apart < 1e-10, "{name}: {apart:e}");
    }
}

/// A sphere that lies on a plane and rolls in a direction that is not along an axis.
#[test]
fn both_versions_a_sphere_on_a_plane_rolls_as_with_wall_gran() {
    let mut grain = Grain::sphere(RADIUS, [0.0, 0.0, RADIUS - 2e-6]);
    grain.density = 2500.0;
    let scene = Scene::open(0.01, vec![grain.spinning([30.0, 50.0, 0.0])]);
    for (name, words) in [
        ("wall_spring", "rolling sds 2e4 0.2 10"),
        ("wall_slider", "rolling sds 2e4 0 0.05"),
    ] {
        let [mut ours, mut theirs] = hertz("").map(|deck| settings(deck, &[]));
        ours.fixes = vec![format!(
            "fix floor all wall/gran/ellipsoid hertz {MODULUS} {POISSON} {words} zplane 0 NULL"
        )];
        theirs.fixes = vec![format!(
            "fix floor all wall/gran granular hertz/material {MODULUS} 0.0 {POISSON} tangential linear_nohistory 0.0 0.0 {words} zplane 0 NULL"
        )];
        let apart = compare(name, &scene, [ours, theirs]);
        assert!(apart < 1e-10, "{name}: {apart:e}");
    }
}

fn crowded(law: &str, steps: u64) -> Deck {
    Deck {
        time_step: 1e-5,
        steps,
        skin: 2e-3,
        ..Deck::new(law)
    }
}

/// Ranks, with Newton's third law for ghosts and without, a restart file in the middle and a split run: as one run on one rank.
#[test]
fn both_versions_ranks_and_restarts() {
    let engine = Engine::from_environment();
    goes_on(
        &engine,
        "roll",
        "mindlin 0.5",
        "rolling sds 1e5 0 0.1 twisting marshall",
    );
    goes_on(
        &engine,
        "lubkin",
        "tfd 0.5 displacement hysteretic",
        "twisting lubkin",
    );
}

fn goes_on(engine: &Engine, name: &str, tangential: &str, resistance: &str) {
    let none = format!("hertz 1e8 0.3 tangential {tangential}");
    let law = &*format!("{none} {resistance}");
    let named = |what: &str| format!("{name}_{what}");
    const HALF: u64 = 150;
    let scene = crowd(64);
    let whole = run(engine, &named("whole"), &scene, &crowded(law, 2 * HALF), 1);
    let without = run(
        engine,
        &named("without"),
        &scene,
        &crowded(&none, 2 * HALF),
        1,
    );
    let (_, changed) = largest_difference(whole.last(), without.last());
    assert!(changed > 1e-4, "nothing was resisted: {changed:e}");
    let check = |what: &str, other: &Outcome| {
        let (positions, velocities) = largest_difference(other.last(), whole.last());
        println!("{what}: positions {positions:.1e}, velocities {velocities:.1e}");
        assert!(positions.max(velocities) < 1e-11, "{what}");
    };
    for newton in [true, false] {
        let deck = Deck {
            newton,
            ..crowded(law, 2 * HALF)
        };
        let two = run(engine, &named("ranks"), &scene, &deck, 2);
        check(&format!("two ranks, newton {newton}"), &two);
    }
    let mut first = crowded(law, HALF);
    first.runs = vec![
        format!("run {HALF}"),
        "write_restart middle.restart".into(),
        format!("run {HALF}"),
    ];
    let split = run(engine, &named("split"), &scene, &first, 1);
    check("split", &split);
    let second = Deck {
        pair: vec![],
        source: vec!["read_restart middle.restart".into()],
        ..crowded(law, HALF)
    };
    let restarted = attempt_in(engine, split.directory, &scene, &second, 2);
    assert!(restarted.success, "{}", last_lines(&restarted.output));
    check("restarted on two ranks", &restarted);
}
