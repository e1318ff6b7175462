// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a restart go on right, or say what is wrong, whatever stands between `read_restart` and the first run?

use std::path::PathBuf;

use crate::harness::{
    attempt_in, between_walls, crowd, fresh_directory, largest_difference, last_lines, Deck,
    Engine, Outcome, Scene,
};

const HALF: u64 = 150;
const LAW: &str = "hertz 1e8 0.3 tangential tfd 0.5";

fn deck(source: &str, fixes: &[String], runs: &[&str]) -> Deck {
    let mut deck = Deck {
        time_step: 1e-5,
        steps: HALF,
        skin: 2e-3,
        fixes: fixes.to_vec(),
        runs: runs.iter().map(|r| r.to_string()).collect(),
        ..Deck::new(LAW)
    };
    if !source.is_empty() {
        deck.source = vec![source.into()];
        deck.pair = vec![];
    }
    deck
}

/// Runs `scene` to the middle and writes a restart file there; the directory, and what becomes of it without interruption.
fn middle(
    engine: &Engine,
    name: &str,
    scene: &Scene,
    fixes: &[String],
    then: &[&str],
) -> (PathBuf, Outcome) {
    let directory = fresh_directory(name);
    let half = format!("run {HALF}");
    let dump =
        "write_dump all custom half.dump id type x y z vx vy vz ix iy iz modify format float %.17g";
    let mut runs = vec![half.as_str(), "write_restart half.restart", dump];
    runs.extend(then);
    runs.push(&half);
    let outcome = attempt_in(engine, directory.clone(), scene, &deck("", fixes, &runs), 1);
    (directory, outcome.succeeded())
}

/// Positions, velocities and torques, in an order that IDs do not decide.
fn by_place(outcome: &Outcome) -> Vec<[f64; 9]> {
    let mut states: Vec<[f64; 9]> = outcome
        .last()
        .states
        .iter()
        .map(|s| {
            let (x, v, t) = (s.position, s.velocity, s.torque);
            [x[0], x[1], x[2], v[0], v[1], v[2], t[0], t[1], t[2]]
        })
        .collect();
    states.sort_by(|a, b| a[0].total_cmp(&b[0]));
    states
}

/// The largest difference of a torque, over the largest torque.
fn apart(one: &Outcome, other: &Outcome) -> f64 {
    let (one, other) = (by_place(one), by_place(other));
    assert_eq!(one.len(), other.len());
    let mut largest = [0.0_f64; 2];
    for (a, b) in one.iter().zip(&other) {
        for k in 6..9 {
            largest[0] = largest[0].max(a[k].abs());
            largest[1] = largest[1].max((a[k] - b[k]).abs());
        }
    }
    assert!(largest[0] > 0.0);
    largest[1] / largest[0]
}

/// What contacts remember is by ID, and the IDs of a file may be given anew before the first run.
#[test]
fn both_versions_friction_goes_on_where_ids_are_given_anew_after_reading() {
    let engine = Engine::from_environment();
    let gone = [
        "group gone id 2 9:11 40",
        "delete_atoms group gone compress no",
    ];
    let scene = crowd(64);
    // The file is written after the deletion, whose IDs are missing in it.
    let directory = fresh_directory("renumbered");
    let half = format!("run {HALF}");
    let mut runs = vec![half.as_str()];
    runs.extend(gone);
    runs.extend([&half, "write_restart half.restart", &half]);
    let whole =
        attempt_in(&engine, directory.clone(), &scene, &deck("", &[], &runs), 1).succeeded();
    for (command, ranks) in [
        ("", 1),
        ("reset_atoms id", 1),
        ("reset_atoms id sort yes", 1),
        ("reset_atoms id sort yes", 4),
    ] {
        let runs: Vec<&str> = [command, &half]
            .into_iter()
            .filter(|r| !r.is_empty())
            .collect();
        let again = deck("read_restart half.restart", &[], &runs);
        let outcome = attempt_in(&engine, directory.clone(), &scene, &again, ranks).succeeded();
        let apart = apart(&whole, &outcome);
        println!("'{command}' on {ranks} ranks: {apart:.1e}");
        assert!(apart < 1e-9, "'{command}' on {ranks} ranks: {apart:e}");
    }
}

/// LAMMPS does not move what a file holds for fixes with the atoms, nor make some for new ones, until the first run.
#[test]
fn both_versions_atoms_that_are_not_those_of_the_file_are_refused() {
    let engine = Engine::from_environment();
    let scene = crowd(64);
    let (directory, whole) = middle(&engine, "moved_after_reading", &scene, &[], &[]);
    std::fs::write(
        directory.join("more.data"),
        scene_of_one(&scene).ellipsoid_data("ellipsoid"),
    )
    .unwrap();
    let read = format!("read_dump half.dump {HALF} x y z vx vy vz ix iy iz timestep no");
    let add = "read_data more.data add append";
    let moved = "moved between processors";
    for (command, before, ranks, words) in [
        (read.as_str(), "", 1, None),
        (&read, "", 4, Some(moved)),
        (&read, "run 0", 4, None),
        (add, "", 1, Some("1 atoms were added since read_restart")),
        (add, "run 0", 4, None),
    ] {
        let half = format!("run {HALF}");
        let runs: Vec<&str> = [before, command, &half]
            .into_iter()
            .filter(|r| !r.is_empty())
            .collect();
        let again = deck("read_restart half.restart", &[], &runs);
        let run = || attempt_in(&engine, directory.clone(), &scene, &again, ranks);
        let what = format!("{before} {command} on {ranks} ranks");
        match words {
            Some(words) => {
                let outcome = run();
                assert!(!outcome.success, "{what}");
                for words in [words, "say 'run 0'"] {
                    let last = last_lines(&outcome.output);
                    assert!(outcome.output.contains(words), "{what}: {last}");
                }
            }
            None => {
                let outcome = run();
                assert!(outcome.success, "{what}: {}", last_lines(&outcome.output));
                if command == add {
                    continue;
                }
                let apart = apart(&whole, &outcome);
                println!("{what}: {apart:.1e}");
                assert!(apart < 1e-9, "{what}: {apart:e}");
            }
        }
    }
}

/// Under `pair_style hybrid`, given again, the style does not know how many atoms the file has: their IDs tell.
#[test]
fn both_versions_atoms_deleted_under_hybrid_are_found_by_their_ids() {
    let engine = Engine::from_environment();
    let pair = [
        "pair_style hybrid/overlay gran/ellipsoid zero 0.01".to_string(),
        format!("pair_coeff * * gran/ellipsoid {LAW}"),
        "pair_coeff * * zero".into(),
    ];
    let half = format!("run {HALF}");
    let directory = fresh_directory("deleted_under_hybrid");
    let mut first = deck("", &[], &[&half, "write_restart half.restart"]);
    first.pair = pair.to_vec();
    attempt_in(&engine, directory.clone(), &crowd(64), &first, 1).succeeded();
    for (before, fits) in [("", false), ("run 0", true)] {
        let delete = [
            "group gone id 2",
            "delete_atoms group gone compress no",
            "run 1",
        ];
        let runs: Vec<&str> = [before]
            .into_iter()
            .chain(delete)
            .filter(|r| !r.is_empty())
            .collect();
        let mut again = deck("read_restart half.restart", &[], &runs);
        again.pair = pair.to_vec();
        let outcome = attempt_in(&engine, directory.clone(), &crowd(64), &again, 1);
        assert_eq!(outcome.success, fits, "{}", last_lines(&outcome.output));
        assert_eq!(
            outcome.output.contains("or deleted, since read_restart"),
            !fits
        );
    }
}

/// One small grain in a corner of the box, where none of the crowd is.
fn scene_of_one(scene: &Scene) -> Scene {
    let mut one = scene.clone();
    one.grains.truncate(1);
    let grain = &mut one.grains[0];
    grain.semi_axes = [1e-5; 3];
    grain.position = [0, 1, 2].map(|k| scene.low[k] + 1e-4 * (scene.high[k] - scene.low[k]));
    one
}

fn floor(motion: &str) -> Vec<String> {
    vec![
        "fix g all gravity 9.81 vector 0.3 0 -1".into(),
        // So soft that contacts last over the whole run
        format!(
            "fix w all wall/gran/ellipsoid hertz 1e6 0.3 tangential tfd 0.5 zplane 0 NULL {motion}"
        ),
        "fix lid all wall/gran/ellipsoid hertz 1e8 0.3 zplane NULL 0.5".into(),
    ]
}

/// LAMMPS gives a fix the state of the file each time that it is made before the first run, and after that never.
#[test]
fn both_versions_a_wall_that_is_made_again_takes_the_state_of_the_file_until_the_first_run() {
    let engine = Engine::from_environment();
    let scene = between_walls();
    let again = ["unfix w", &floor("")[1].clone()];
    let half = format!("run {HALF}");
    let (directory, whole) = middle(&engine, "made_again", &scene, &floor(""), &[]);
    let (_, anew) = middle(&engine, "made_anew", &scene, &floor(""), &again);
    let resumed = |runs: &[&str]| {
        let again = deck("read_restart half.restart", &floor(""), runs);
        attempt_in(&engine, directory.clone(), &scene, &again, 1).succeeded()
    };
    let of_file = resumed(&[again[0], again[1], &half]);
    let after_run = resumed(&["run 0", again[0], again[1], &half]);
    let figures = [
        apart(&whole, &of_file),
        apart(&anew, &after_run),
        apart(&whole, &anew),
    ];
    println!(
        "state of the file {:.1e}, none {:.1e}; apart {:.1e}",
        figures[0], figures[1], figures[2]
    );
    assert!(
        figures[0] < 1e-9 && figures[1] < 1e-9 && figures[2] > 1e-4,
        "{figures:?}"
    );
}

/// A wall goes on with the motion of the file. Another motion begins when it is given: it has not gone on since the file's fix was made.
#[test]
fn both_versions_a_wall_with_another_motion_after_reading_is_not_displaced() {
    let engine = Engine::from_environment();
    let scene = between_walls();
    let show = "print \"PLACE $(f_w[21]:%.17g) $(f_w[22]:%.17g) $(f_w[23]:%.17g)\"";
    let column = "thermo_style custom step f_w[21] f_w[22] f_w[23]";
    let half = format!("run {HALF}");
    let time = HALF as f64 * 1e-5;
    let place = |output: &str| -> Vec<f64> {
        let line = output.lines().rev().find_map(|l| l.strip_prefix("PLACE "));
        let words = line.expect("no place was printed").split_whitespace();
        words.map(|w| w.parse().unwrap()).collect()
    };
    let variable = "variable v equal -0.01";
    let warning = "had another motion";
    let wiggle = |amplitude: f64, time: f64| {
        amplitude * (1.0 - (2.0 * std::f64::consts::PI * time / 0.01).cos())
    };
    for (before, after, expected, warns) in [
        ("", "velocity 0 0 -0.01", -0.01 * time, false),
        (
            "velocity 0 0 -0.01",
            "velocity 0 0 -0.01",
            -0.02 * time,
            false,
        ),
        (
            "velocity 0 0 -0.01",
            "velocity 0 0 -0.03",
            -0.03 * time,
            true,
        ),
        ("velocity 0 0 -0.01", "", 0.0, true),
        ("velocity 0 0 -0.01", "velocity 0 0 v_v", -0.01 * time, true),
        ("velocity 0 0 v_v", "velocity 0 0 v_v", -0.02 * time, false),
        (
            "shear x 0.1",
            "wiggle z 1e-5 0.01",
            wiggle(1e-5, time),
            false,
        ),
        (
            "wiggle z 1e-5 0.01",
            "wiggle z 1e-5 0.01",
            wiggle(1e-5, 2.0 * time),
            false,
        ),
        (
            "wiggle z 1e-5 0.01",
            "wiggle z 2e-5 0.01",
            wiggle(2e-5, time),
            true,
        ),
        (
            "omega 0 0 0 0 0 1 2.0",
            "omega 0 0 0 0 0 1 3.0 velocity 0 0 -0.01",
            -0.01 * time,
            true,
        ),
        // Grains are far from the lid that presses: it moves with its largest speed.
        (
            "servo 0 0 1 1e6 0.01",
            "shear x 0.1 servo 0 0 1 1e6 0.01",
            0.02 * time,
            false,
        ),
        (
            "servo 0 0 1 1e6 0.01",
            "servo 0 0 1 2e6 0.01",
            0.02 * time,
            false,
        ),
        ("servo 0 0 1 1e6 0.01", "", 0.0, true),
    ] {
        let mut fixes = floor(before);
        fixes.insert(0, variable.into());
        let (directory, _) = middle(&engine, "other_motion", &scene, &fixes, &[]);
        let mut fixes = floor(after);
        fixes.insert(0, variable.into());
        let again = deck("read_restart half.restart", &fixes, &[column, &half, show]);
        let outcome = attempt_in(&engine, directory, &scene, &again, 1).succeeded();
        let at = place(&outcome.output);
        let what = format!("'{before}', then '{after}'");
        println!("{what}: {at:?}, expected {expected:e}");
        assert!(
            (at[2] - expected).abs() < 1e-9 * time.max(expected.abs()),
            "{what}: {at:?}"
        );
        assert_eq!(outcome.output.contains(warning), warns, "{what}");
    }
}

/// The motion of the file goes on where its words are the same, to the last digits of what it was.
#[test]
fn both_versions_a_wall_that_turned_another_way_forgets_its_contacts() {
    let engine = Engine::from_environment();
    let scene = between_walls();
    let half = format!("run {HALF}");
    let turning = floor("omega 0 0 0 0 0 1 20.0");
    let other = floor("omega 0 0 0 0 0 1 10.0");
    let (directory, whole) = middle(&engine, "turned", &scene, &turning, &[]);
    // The same wall without a file: made anew between two runs.
    let (_, anew) = middle(
        &engine,
        "turned_anew",
        &scene,
        &turning,
        &["unfix w", &other[1].clone()],
    );
    let resumed = |fixes: &[String]| {
        let again = deck("read_restart half.restart", fixes, &[&half]);
        attempt_in(&engine, directory.clone(), &scene, &again, 1).succeeded()
    };
    let (same, differs) = (resumed(&turning), resumed(&other));
    let figures = [
        apart(&whole, &same),
        apart(&anew, &differs),
        apart(&whole, &anew),
    ];
    println!(
        "the same motion {:.1e}, another {:.1e}; apart {:.1e}",
        figures[0], figures[1], figures[2]
    );
    assert!(
        figures[0] < 1e-9 && figures[1] < 1e-9 && figures[2] > 1e-4,
        "{figures:?}"
    );
    assert!(largest_difference(same.last(), whole.last()).1 < 1e-9);
}
