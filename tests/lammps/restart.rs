// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a restart in the middle of contacts go on as if nothing had happened, with coefficients and history from the file?

use crate::decomposition::LAW;
use crate::harness::{
    attempt_in, crowd, largest_difference, last_lines, run, Deck, Engine, Grain, Outcome, Scene,
};

const HALF: u64 = 150;

fn deck(law: &str) -> Deck {
    Deck {
        time_step: 1e-5,
        steps: HALF,
        skin: 2e-3,
        ..Deck::new(law)
    }
}

/// Runs to the middle, writes a restart file there, then starts anew from the file.
fn through_a_file(
    engine: &Engine,
    name: &str,
    law: &str,
    ranks: [usize; 2],
    newton: bool,
) -> Outcome {
    let scene = crowd(64);
    let mut first = Deck {
        newton,
        ..deck(law)
    };
    first.runs = vec![format!("run {HALF}"), "write_restart middle.restart".into()];
    let outcome = run(engine, name, &scene, &first, ranks[0]);
    let touching = outcome
        .last()
        .states
        .iter()
        .filter(|s| s.force != [0.0; 3])
        .count();
    assert!(
        touching >= 6,
        "only {touching} grains are in contact in the middle"
    );
    let second = Deck {
        newton,
        pair: vec![],
        source: vec!["read_restart middle.restart".into()],
        ..deck(law)
    };
    let outcome = attempt_in(engine, outcome.directory, &scene, &second, ranks[1]);
    assert!(outcome.success, "{}", last_lines(&outcome.output));
    outcome
}

/// Two runs in one process: LAMMPS computes the forces anew between them, as after a restart.
fn in_two_runs(engine: &Engine, name: &str, law: &str) -> Outcome {
    let two = Deck {
        runs: vec![format!("run {HALF}"), format!("run {HALF}")],
        ..deck(law)
    };
    run(engine, name, &crowd(64), &two, 1)
}

fn report(what: &str, a: &Outcome, b: &Outcome) -> f64 {
    assert_eq!(a.last().step, b.last().step);
    let (positions, velocities) = largest_difference(a.last(), b.last());
    println!("{what}: positions {positions:.1e}, velocities {velocities:.1e}");
    positions.max(velocities)
}

/// Forces without rates: a restart, or a second `run`, is as good as no interruption at all.
#[test]
fn both_versions_restart_in_the_middle_of_contacts() {
    let engine = Engine::from_environment();
    for (tangential, ranks, newton) in [
        ("mindlin 0.5", [1, 1], true),
        ("tfd 0.5", [1, 1], true),
        ("tfd 0.5", [1, 4], true),
        ("tfd 0.5", [4, 1], false),
        ("mindlin 0.5 displacement incremental", [1, 1], true),
        ("tfd 0.5 displacement total", [1, 1], true),
        ("tfd 0.5 displacement hysteretic", [1, 1], true),
        ("tfd 0.5 displacement hysteretic", [4, 1], false),
    ] {
        let law = format!("hertz 1e8 0.3 tangential {tangential}");
        let whole = run(
            &engine,
            "restart_whole",
            &crowd(64),
            &Deck {
                steps: 2 * HALF,
                ..deck(&law)
            },
            1,
        );
        let restarted = through_a_file(&engine, "restart_elastic", &law, ranks, newton);
        let two = in_two_runs(&engine, "restart_elastic_two_runs", &law);
        let what = format!("{tangential}, ranks {ranks:?}, newton {newton}");
        let apart = report(
            &format!("{what}, restart beside one run"),
            &restarted,
            &whole,
        );
        let split = report(&format!("{what}, two runs beside one run"), &two, &whole);
        assert!(
            apart < 1e-11 && split < 1e-11,
            "{what}: {apart:e}, {split:e}"
        );
    }
}

/// `pair_style hybrid` keeps no coefficients of its styles: they are among the settings of this style, and `pair_coeff` without a
/// law takes them.
#[test]
fn both_versions_restart_under_hybrid() {
    let engine = Engine::from_environment();
    let law = "nfd 1e7 0.3 200 200 tangential tfd 0.5";
    let hybrid = |coefficients: &str| {
        vec![
            "pair_style hybrid gran/ellipsoid".to_string(),
            format!("pair_coeff * * gran/ellipsoid {coefficients}"),
        ]
    };
    let first = |runs: &[&str]| Deck {
        pair: hybrid(law),
        runs: runs.iter().map(|r| r.to_string()).collect(),
        ..deck(law)
    };
    let half = format!("run {HALF}");
    let two = run(
        &engine,
        "hybrid_two_runs",
        &crowd(64),
        &first(&[&half, &half]),
        1,
    );
    for (name, pair, words) in [
        ("without a law", hybrid("")[1..].to_vec(), &[][..]),
        ("with the law", hybrid(law)[1..].to_vec(), &[]),
        ("all anew", hybrid(law), &[]),
        ("no pair_coeff", vec![], &["coeff"]),
        ("another style, no law", hybrid(""), &["pair_coeff", "law"]),
    ] {
        let middle = run(
            &engine,
            "hybrid",
            &crowd(64),
            &first(&[&half, "write_restart middle.restart"]),
            1,
        );
        let second = Deck {
            pair,
            source: vec!["read_restart middle.restart".into()],
            ..deck(law)
        };
        let outcome = attempt_in(&engine, middle.directory, &crowd(64), &second, 1);
        if words.is_empty() {
            assert!(outcome.success, "{name}: {}", last_lines(&outcome.output));
            assert!(report(name, &outcome, &two) < 1e-9, "{name}");
        } else {
            assert!(!outcome.success, "{name}");
            let error = &outcome.output[outcome.output.find("ERROR").unwrap()..];
            assert!(words.iter().all(|w| error.contains(w)), "{name}: {error}");
        }
    }
}

/// A data file has grains and their motion, and no history: without friction and viscosity nothing else is needed.
#[test]
fn both_versions_go_on_from_a_data_file() {
    let engine = Engine::from_environment();
    let law = "hertz 1e7 0.3";
    let whole = run(
        &engine,
        "data_whole",
        &crowd(64),
        &Deck {
            steps: 2 * HALF,
            ..deck(law)
        },
        1,
    );
    let first = Deck {
        runs: vec![format!("run {HALF}"), "write_data middle.data".into()],
        ..deck(law)
    };
    let first = run(&engine, "data", &crowd(64), &first, 4);
    let second = Deck {
        source: vec![
            "read_data middle.data".into(),
            format!("reset_timestep {HALF}"),
        ],
        ..deck(law)
    };
    let outcome = attempt_in(&engine, first.directory, &crowd(64), &second, 1);
    assert!(outcome.success, "{}", last_lines(&outcome.output));
    assert!(report("data file beside one run", &outcome, &whole) < 1e-9);
}

#[test]
fn both_versions_restart_with_viscous_forces_and_other_ranks() {
    let engine = Engine::from_environment();
    viscous_restart(&engine, LAW);
}

/// The penetrations of rest are in the file.
#[test]
fn both_versions_restart_with_the_memory_of_the_normal_force() {
    let engine = Engine::from_environment();
    viscous_restart(
        &engine,
        "nfd 1e8 0.2 2e3 2e5 viscosity memory tangential tfd 0.5",
    );
}

fn viscous_restart(engine: &Engine, law: &str) {
    // with rates the force that LAMMPS computes anew has the velocity of the full step; a second `run` does the same
    let two = in_two_runs(engine, "restart_two_runs", law);
    for (ranks, newton) in [
        ([1, 1], true),
        ([1, 4], true),
        ([4, 1], true),
        ([4, 4], false),
    ] {
        let restarted = through_a_file(engine, "restart_viscous", law, ranks, newton);
        let what = format!(
            "{law}, written by {} and read by {} ranks, newton {newton}",
            ranks[0], ranks[1]
        );
        assert!(report(&what, &restarted, &two) < 1e-9, "{what}");
    }
    let whole = run(
        engine,
        "restart_viscous_whole",
        &crowd(64),
        &Deck {
            steps: 2 * HALF,
            ..deck(law)
        },
        1,
    );
    let difference = report(
        "one run beside two runs (the velocity at which LAMMPS starts a run)",
        &whole,
        &two,
    );
    assert!(difference < 1e-3);
}

/// A ball that slides and then sticks on a wall, with the restart while its tangential spring is loaded.
#[test]
fn both_versions_restart_on_a_wall() {
    let engine = Engine::from_environment();
    let ball = Grain {
        density: 2500.0,
        ..Grain::new([0.012, 0.01, 0.011], [0.0, 0.0, 0.00999]).moving([0.02, 0.01, -0.05])
    };
    let scene = Scene::open(0.1, vec![ball]);
    for (normal, tangential) in [
        ("hertz 1e7 0.3", "mindlin 0.5"),
        ("hertz 1e7 0.3", "tfd 0.5"),
        ("nfd 1e7 0.2 10 1e3 viscosity memory", "tfd 0.5"),
        // Between two materials the history is longer.
        (
            "nfd 1e7 0.2 10 1e3 viscosity memory",
            "tfd 0.5 material 5e6 0.25 50 300",
        ),
        (
            "nfd 4e6 0.2 10 1e3 viscosity memory",
            "tfd 0.5 material rigid",
        ),
    ] {
        let law = format!("{normal} tangential {tangential}");
        let wall = |runs: &[&str]| Deck {
            fixes: vec![format!(
                "fix floor all wall/gran/ellipsoid {law} zplane 0.0 NULL"
            )],
            time_step: 4e-6,
            steps: 300,
            skin: 1e-3,
            runs: runs.iter().map(|s| s.to_string()).collect(),
            ..Deck::new("hertz 1e7 0.3")
        };
        // With rates a second `run` begins as a restart does.
        let whole: &[&str] = if normal.contains("nfd") {
            &["run 300", "run 300"]
        } else {
            &["run 600"]
        };
        let whole = run(&engine, "wall_whole", &scene, &wall(whole), 1);
        let first = run(
            &engine,
            "wall_restart",
            &scene,
            &wall(&["run 300", "write_restart middle.restart"]),
            1,
        );
        let force = first.last().states[0].force;
        assert!(
            force[2] > 0.0 && force[0] != 0.0,
            "no contact in the middle: {force:?}"
        );
        let second = Deck {
            pair: vec![],
            source: vec!["read_restart middle.restart".into()],
            ..wall(&[])
        };
        let restarted = attempt_in(&engine, first.directory, &scene, &second, 1);
        assert!(restarted.success, "{}", last_lines(&restarted.output));
        println!("force in the middle {force:?}");
        assert!(
            report(
                &format!("wall, {tangential}, restart beside one run"),
                &restarted,
                &whole
            ) < 1e-9
        );
    }
}
