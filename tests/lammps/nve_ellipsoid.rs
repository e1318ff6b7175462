// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does `fix nve/ellipsoid` move grains as `fix nve/asphere` does in small steps, and turn free ones exactly in any step?

use crate::harness::{attempt, crowd, largest_difference, run, Deck, Engine, Frame, Grain, Scene};
use crate::shapes::{length, sub, Random};

fn moved_by(integrator: &str, deck: Deck) -> Deck {
    Deck {
        integrate: false,
        fixes: vec![format!("fix move all {integrator}")],
        ..deck
    }
}

/// Spinning grains of every kind of shape that never meet.
fn spinning() -> Scene {
    let mut random = Random(15);
    let shapes = [
        [0.3, 0.3, 0.3],
        [0.5, 0.2, 0.2],
        [0.2, 0.4, 0.2],
        [0.4, 0.4, 0.1],
        [0.5, 0.35, 0.2],
    ];
    let grains = (0..40)
        .map(|k| {
            let place = [
                3.0 * (k % 4) as f64 - 4.5,
                3.0 * (k / 4 % 4) as f64 - 4.5,
                3.0 * (k / 16) as f64 - 4.5,
            ];
            let w = random.direction().map(|x| 4.0 * x);
            Grain::new(shapes[k % shapes.len()], place)
                .turned(random.quaternion())
                .spinning(w)
        })
        .collect();
    Scene::open(8.0, grains)
}

/// Largest difference of two attitudes, whose quaternions may differ in sign.
fn attitudes(a: &Frame, b: &Frame) -> f64 {
    let pairs = a.states.iter().zip(&b.states);
    pairs.fold(0.0f64, |worst, (a, b)| {
        let gap = |sign: f64| {
            (0..4).fold(0.0f64, |g, k| {
                g.max((a.quaternion[k] - sign * b.quaternion[k]).abs())
            })
        };
        worst.max(gap(1.0).min(gap(-1.0)))
    })
}

#[test]
fn both_versions_free_grains_turn_exactly_in_any_step() {
    let engine = Engine::from_environment();
    let scene = spinning();
    let after = |integrator: &str, steps: u64| {
        let deck = Deck {
            time_step: 1.0 / steps as f64,
            steps,
            ..Deck::new("hertz 1e7 0.3")
        };
        let name = format!("free_{}_{steps}", integrator.replace('/', "_"));
        run(&engine, &name, &scene, &moved_by(integrator, deck), 1)
    };
    let fine = after("nve/ellipsoid", 10_000);
    for steps in [5, 100, 1000] {
        let error = attitudes(after("nve/ellipsoid", steps).last(), fine.last());
        println!("{steps} steps: attitudes differ by {error:.1e}");
        assert!(error < 1e-12, "{steps} steps: {error:e}");
    }
    // LAMMPS' own integrator comes to the same attitudes as its step falls, with its second order.
    let [coarse, finer] =
        [2000, 4000].map(|steps| attitudes(after("nve/asphere", steps).last(), fine.last()));
    println!("nve/asphere: {coarse:.1e} in 2000 steps, {finer:.1e} in 4000");
    assert!(finer < 1e-4 && coarse / finer > 3.5 && coarse / finer < 4.5);
}

#[test]
fn both_versions_colliding_grains_move_as_with_lammps_own_integrator() {
    let engine = Engine::from_environment();
    let scene = crowd(64);
    let law = crate::decomposition::LAW;
    let after = |name: &str, integrator: &str, step: f64, ranks: usize| {
        let deck = Deck {
            time_step: step,
            steps: (3e-3 / step).round() as u64,
            skin: 2e-3,
            ..Deck::new(law)
        };
        run(
            &engine,
            &format!("collide_{name}"),
            &scene,
            &moved_by(integrator, deck),
            ranks,
        )
    };
    let ours = after("ours", "nve/ellipsoid", 1e-5, 1);
    let changed = scene
        .grains
        .iter()
        .zip(&ours.last().states)
        .filter(|(g, s)| length(sub(s.velocity, g.velocity)) > 1e-2 * length(g.velocity))
        .count();
    assert!(changed > 25, "only {changed} grains have collided");

    let four = after("four", "nve/ellipsoid", 1e-5, 4);
    let (positions, velocities) = largest_difference(four.last(), ours.last());
    println!("four ranks: {positions:.1e}, {velocities:.1e}");
    assert!(positions < 1e-9 && velocities < 1e-9);

    // With the same velocities for the forces the two differ by the error of the other's rotation, which is of second order.
    let differences = [1e-5, 5e-6].map(|step| {
        let ours = after(
            &format!("ours_{step}"),
            "nve/ellipsoid velocities half",
            step,
            1,
        );
        let theirs = after(&format!("theirs_{step}"), "nve/asphere", step, 1);
        largest_difference(ours.last(), theirs.last()).0
    });
    println!("against nve/asphere: {differences:?}");
    assert!(differences[0] < 1e-5 && differences[0] / differences[1] > 2.5);
}

#[test]
fn both_versions_spheres_move_to_rounding_as_with_lammps_own_integrator() {
    let engine = Engine::from_environment();
    let mut scene = crowd(64);
    for grain in &mut scene.grains {
        grain.semi_axes = [grain.semi_axes[1]; 3];
    }
    let after = |integrator: &str| {
        let deck = Deck {
            time_step: 1e-5,
            steps: 300,
            skin: 2e-3,
            ..Deck::new(crate::decomposition::LAW)
        };
        let name = format!("balls_{}", integrator.replace(['/', ' '], "_"));
        run(&engine, &name, &scene, &moved_by(integrator, deck), 1)
    };
    // LAMMPS' own leaves the velocities of the half step to the forces.
    let (ours, theirs) = (after("nve/ellipsoid velocities half"), after("nve/asphere"));
    let (positions, velocities) = largest_difference(ours.last(), theirs.last());
    println!("positions {positions:.1e}, velocities {velocities:.1e}");
    assert!(positions < 1e-9 && velocities < 1e-9);
}

#[test]
fn both_versions_a_group_moves_and_the_others_stay() {
    let engine = Engine::from_environment();
    let scene = spinning();
    let deck = Deck {
        integrate: false,
        fixes: vec![
            "group some id 1:7".into(),
            "fix move some nve/ellipsoid".into(),
        ],
        time_step: 1e-2,
        steps: 20,
        ..Deck::new("hertz 1e7 0.3")
    };
    let outcome = run(&engine, "group_of_seven", &scene, &deck, 1);
    for (k, (a, b)) in outcome
        .first()
        .states
        .iter()
        .zip(&outcome.last().states)
        .enumerate()
    {
        let moved = a.quaternion != b.quaternion;
        assert_eq!(moved, k < 7, "grain {}", k + 1);
    }
}

#[test]
fn both_versions_what_it_cannot_move_is_refused() {
    let engine = Engine::from_environment();
    let scene = spinning();
    let refused = |name: &str, deck: Deck, said: &str| {
        let outcome = attempt(&engine, &format!("nve_{name}"), &scene, &deck, 1);
        let text = outcome
            .output
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ");
        assert!(!outcome.success, "{name} went on to its end");
        assert!(
            text.contains("ERROR") && text.contains(said),
            "{name}:\n{}",
            outcome.output
        );
    };
    let plain = || Deck {
        steps: 3,
        ..Deck::new("hertz 1e7 0.3")
    };
    refused(
        "word",
        moved_by("nve/ellipsoid fast", plain()),
        "unknown word 'fast'",
    );
    refused(
        "velocities",
        moved_by("nve/ellipsoid velocities full", plain()),
        "'velocities full' must be 'velocities step' or 'velocities half'",
    );
    let mut fast = moved_by("nve/ellipsoid", plain());
    fast.fixes.push("set atom 3 angmom 0 0 1e9".into());
    refused("fast", fast, "particle 3: it would turn by");
    let mut point = moved_by("nve/ellipsoid", plain());
    point.fixes.push("set atom 4 shape 0 0 0".into());
    refused("point", point, "particle 4");
}
