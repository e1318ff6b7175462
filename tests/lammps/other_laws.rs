// SPDX-License-Identifier: MIT OR Apache-2.0
//! What becomes of what contacts remember, where they go on under another law? The numbers of another law may be as many, and mean
//! something else: a displacement is no force.

use crate::harness::{attempt_in, fresh_directory, Deck, Engine, Grain, Outcome, Scene};

const HALF: u64 = 200;

/// Two grains that are pressed together, and slide along each other less than friction allows.
fn pressed() -> Scene {
    let mut first = Grain::new([0.5, 0.4, 0.3], [0.0, 0.0, 0.0]);
    first.velocity = [0.02, 0.05, 0.01];
    let second = Grain::new([0.5, 0.4, 0.3], [0.99, 0.05, 0.0]);
    Scene::open(10.0, vec![first, second])
}

/// The state after a run with a law, and the force on the first grain before and after it has got another one.
fn change(engine: &Engine, name: &str, laws: &[&str], through_a_file: bool) -> (Outcome, Outcome) {
    let directory = fresh_directory(name);
    let start = Deck {
        fixes: vec![
            "group first id 1".into(),
            "compute force first reduce sum fx fy fz".into(),
        ],
        time_step: 1e-5,
        steps: HALF,
        thermo_columns: "step c_force[1] c_force[2] c_force[3]".into(),
        runs: vec![format!("run {HALF}"), "write_restart middle.restart".into()],
        ..Deck::new(laws[0])
    };
    let before = attempt_in(engine, directory.clone(), &pressed(), &start, 1);
    assert!(before.success, "{name}:\n{}", before.output);
    let others = laws[1..]
        .iter()
        .flat_map(|law| [format!("pair_coeff * * {law}"), "run 0".into()]);
    let after = if through_a_file {
        let mut runs: Vec<String> = others.collect();
        runs.insert(0, "comm_modify vel yes".into());
        Deck {
            source: vec!["read_restart middle.restart".into()],
            pair: vec![],
            runs,
            ..start
        }
    } else {
        let mut runs = vec![format!("run {HALF}")];
        runs.extend(others);
        Deck { runs, ..start }
    };
    let after = attempt_in(engine, directory, &pressed(), &after, 1);
    assert!(after.success, "{name}:\n{}", after.output);
    (before, after)
}

fn force(outcome: &Outcome) -> [f64; 3] {
    let rows = outcome.thermo();
    let last = rows.last().unwrap();
    ["c_force[1]", "c_force[2]", "c_force[3]"].map(|column| last[column])
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// Whether it says so, over the ends of lines.
fn says(outcome: &Outcome, what: &str) -> bool {
    let words: Vec<&str> = outcome.output.split_whitespace().collect();
    words.join(" ").contains(what)
}

fn is_warned_of(outcome: &Outcome) -> bool {
    says(
        outcome,
        "contacts that exist start with no tangential displacement",
    )
}

fn is_warned_of_types(outcome: &Outcome) -> bool {
    says(
        outcome,
        "their contacts start with no tangential displacement",
    )
}

/// What is left of the tangential force, as a part of it: nothing but this where nothing is kept.
fn assert_left(what: &str, left: f64, kept: bool, nothing: f64) {
    if kept {
        assert!((left - 1.0).abs() < 0.2, "{what}: {left}");
    } else {
        assert!(left < nothing, "{what}: {left}");
    }
}

const NORMAL: &str = "hertz 1e7 0.3";
const TOTAL: &str = "hertz 1e7 0.3 tangential mindlin 5.0 displacement total";
const INCREMENTAL: &str = "hertz 1e7 0.3 tangential mindlin 5.0 displacement incremental";
const RESCALED: &str = "hertz 1e7 0.3 tangential mindlin 5.0";
const PARTIAL_SLIP: &str = "hertz 1e7 0.3 tangential tfd 5.0 displacement total";
/// As many numbers as the next one.
const ROLLING: &str =
    "hertz 1e7 0.3 tangential mindlin 5.0 displacement total rolling sds 1e5 0 0.5";
const TWISTING: &str = "hertz 1e7 0.3 tangential mindlin 5.0 twisting marshall";

/// Numbers that mean something else are not read, and a warning says so; those that mean the same are.
#[test]
fn both_versions_no_law_takes_for_its_own_what_another_remembered() {
    let engine = Engine::from_environment();

    for through_a_file in [false, true] {
        let changed = |name: &str, laws: &[&str]| {
            let name = format!("other_laws_{name}_{through_a_file}");
            change(&engine, &name, laws, through_a_file)
        };
        for (name, laws, kept) in [
            ("force", [TOTAL, INCREMENTAL], false),
            ("displacement", [INCREMENTAL, TOTAL], false),
            ("way", [ROLLING, TWISTING], false),
            ("torque", [TWISTING, ROLLING], false),
            ("same", [TOTAL, TOTAL], true),
            ("energy", [RESCALED, RESCALED], true),
            ("slip", [TOTAL, PARTIAL_SLIP], true),
        ] {
            let (before, after) = changed(name, &[laws[0], laws[1]]);
            let (_, without) = changed("frictionless", &[laws[0], NORMAL]);
            let tangential = distance(force(&before), force(&without));
            let normal = distance(force(&without), [0.0; 3]);
            assert!(tangential > 1e-3 * normal, "{name}: {tangential} {normal}");
            let left = distance(force(&after), force(&without)) / tangential;
            println!("{name}: {left}");
            assert_eq!(is_warned_of(&after), !kept, "{name}: {}", after.output);
            assert_left(name, left, kept, 1e-12);
        }
    }
}

/// A grain that is pressed against a wall, and slides along it less than friction allows.
fn pressed_on_a_wall() -> Scene {
    let mut grain = Grain::new([0.5, 0.4, 0.3], [0.0, 0.0, 0.295]);
    grain.velocity = [0.05, 0.02, -0.02];
    Scene::open(10.0, vec![grain])
}

/// After a restart a wall with another law: the force on it when the file was written, and when a run goes on from it.
fn change_wall(engine: &Engine, name: &str, laws: [&str; 2]) -> (Outcome, Outcome) {
    let directory = fresh_directory(name);
    let wall = |law: &str| format!("fix floor all wall/gran/ellipsoid {law} zplane 0 NULL");
    let start = Deck {
        fixes: vec![wall(laws[0])],
        time_step: 1e-5,
        steps: HALF,
        thermo_columns: "step f_floor[14] f_floor[15] f_floor[16]".into(),
        runs: vec![format!("run {HALF}"), "write_restart middle.restart".into()],
        ..Deck::new(NORMAL)
    };
    let before = attempt_in(engine, directory.clone(), &pressed_on_a_wall(), &start, 1);
    assert!(before.success, "{name}:\n{}", before.output);
    let after = Deck {
        source: vec!["read_restart middle.restart".into()],
        pair: vec![],
        fixes: vec![wall(laws[1])],
        runs: vec!["comm_modify vel yes".into(), "run 0".into()],
        ..start
    };
    let after = attempt_in(engine, directory, &pressed_on_a_wall(), &after, 1);
    assert!(after.success, "{name}:\n{}", after.output);
    (before, after)
}

fn force_on_wall(outcome: &Outcome) -> [f64; 3] {
    let rows = outcome.thermo();
    let last = rows.last().unwrap();
    ["f_floor[14]", "f_floor[15]", "f_floor[16]"].map(|column| last[column])
}

/// A restart file has the law of a wall: what was remembered under it is read where it means the same, and a warning says so where not.
#[test]
fn both_versions_after_a_restart_no_wall_takes_for_its_own_what_another_remembered() {
    let engine = Engine::from_environment();
    for (name, laws, kept) in [
        ("force", [TOTAL, INCREMENTAL], false),
        ("displacement", [INCREMENTAL, TOTAL], false),
        ("way", [ROLLING, TWISTING], false),
        ("torque", [TWISTING, ROLLING], false),
        ("longer", [TOTAL, RESCALED], false),
        ("same", [TOTAL, TOTAL], true),
        ("energy", [RESCALED, RESCALED], true),
        ("slip", [TOTAL, PARTIAL_SLIP], true),
    ] {
        let (before, after) = change_wall(&engine, &format!("wall_{name}"), laws);
        let then = force_on_wall(&before);
        let tangential = then[0].hypot(then[1]);
        assert!(tangential > 1e-3 * then[2].abs(), "{name}: {then:?}");
        let now = force_on_wall(&after);
        let left = now[0].hypot(now[1]) / tangential;
        println!("{name}: {left}");
        assert!((now[2] / then[2] - 1.0).abs() < 1e-9, "{name}: {now:?}");
        assert_eq!(is_warned_of(&after), !kept, "{name}: {}", after.output);
        assert_left(name, left, kept, 1e-12);
    }
}

/// The laws of two types, and whether contacts remember the same under both.
const CHANGES_OF_TYPE: [(&str, [&str; 2], bool); 4] = [
    ("force", [TOTAL, INCREMENTAL], false),
    ("displacement", [INCREMENTAL, TOTAL], false),
    ("slip", [TOTAL, PARTIAL_SLIP], true),
    ("same", [INCREMENTAL, INCREMENTAL], true),
];

/// Two grains in the middle of the box, of two types: the pair of both types, and that of the second, have the second law.
fn of_two_types() -> Scene {
    let mut scene = pressed();
    scene.kinds = 2;
    for (grain, x) in scene.grains.iter_mut().zip([-0.495, 0.495]) {
        grain.position[0] = x;
    }
    scene
}

fn two_laws(laws: [&str; 2]) -> Vec<String> {
    vec![
        "pair_style gran/ellipsoid".into(),
        format!("pair_coeff 1 1 {}", laws[0]),
        format!("pair_coeff * 2 {}", laws[1]),
    ]
}

fn deck_of_two_types(ranks: usize, newton: bool) -> Deck {
    Deck {
        newton,
        before_data: vec!["processors 2 1 1".into(); ranks - 1],
        fixes: vec![
            "group first id 1".into(),
            "compute force first reduce sum fx fy fz".into(),
        ],
        time_step: 1e-5,
        steps: HALF,
        thermo_columns: "step c_force[1] c_force[2] c_force[3]".into(),
        ..Deck::new("")
    }
}

/// Two grains whose law `set type` changes, since it is that of another type: what follows is what the new law makes of them, and not of
/// what the old one remembered. A run without set-up is refused.
#[test]
fn both_versions_no_type_takes_for_its_own_what_another_remembered() {
    let engine = Engine::from_environment();
    for (ranks, newton) in [(1, true), (2, true), (2, false)] {
        let go_on = |name: &str, laws: [&str; 2], commands: &[&str]| {
            let mut runs = vec![format!("run {HALF}")];
            runs.extend(commands.iter().map(|command| command.to_string()));
            let deck = Deck {
                pair: two_laws(laws),
                runs,
                ..deck_of_two_types(ranks, newton)
            };
            let directory = fresh_directory(&format!("{name}_{ranks}_{newton}"));
            attempt_in(&engine, directory, &of_two_types(), &deck, ranks)
        };
        for (name, laws, kept) in CHANGES_OF_TYPE {
            let before = go_on("before", laws, &["run 0"]);
            let without = go_on(
                "without",
                [laws[0], NORMAL],
                &["set type 1 type 2", "run 0"],
            );
            let tangential = distance(force(&before), force(&without));
            let normal = distance(force(&without), [0.0; 3]);
            assert!(tangential > 1e-3 * normal, "{name}: {tangential} {normal}");
            for changed in ["type 1", "atom 2"] {
                let what = format!("{name}, {changed}, {ranks} ranks, newton {newton}");
                let set = format!("set {changed} type 2");
                let after = go_on("after", laws, &[&set, "run 0"]);
                assert!(after.success, "{what}:\n{}", after.output);
                let left = distance(force(&after), force(&without)) / tangential;
                println!("{what}: {left}");
                let warned = is_warned_of_types(&after);
                assert_eq!(warned, !kept, "{what}: {}", after.output);
                // Rounding of the normal force, which is the larger one.
                assert_left(&what, left, kept, 1e-10);
                let at_once = go_on("at_once", laws, &[&set, "run 1 pre no"]);
                let words = "atoms have got another type";
                let refused = !at_once.success && at_once.output.contains(words);
                assert_eq!(refused, !kept, "{what}: {}", at_once.output);
                assert_eq!(at_once.success, kept, "{what}: {}", at_once.output);
            }
        }
    }
}

/// A restart file has the types under whose laws contacts remember what they do: `set type` before the first run that follows is seen.
#[test]
fn both_versions_after_a_restart_no_type_takes_for_its_own_what_another_remembered() {
    let engine = Engine::from_environment();
    for (ranks, newton) in [(1, true), (2, true), (2, false)] {
        for (name, laws, kept) in CHANGES_OF_TYPE {
            let directory = fresh_directory(&format!("file_{name}_{ranks}_{newton}"));
            let start = Deck {
                pair: two_laws(laws),
                runs: vec![format!("run {HALF}"), "write_restart middle.restart".into()],
                ..deck_of_two_types(ranks, newton)
            };
            let scene = of_two_types();
            let before = attempt_in(&engine, directory.clone(), &scene, &start, ranks);
            assert!(before.success, "{name}:\n{}", before.output);
            let go_on = |pair: Vec<String>, commands: &[&str]| {
                let mut runs = vec!["comm_modify vel yes".to_string()];
                runs.extend(commands.iter().map(|command| command.to_string()));
                let rest = Deck {
                    source: vec!["read_restart middle.restart".into()],
                    pair,
                    runs,
                    ..deck_of_two_types(ranks, newton)
                };
                let after = attempt_in(&engine, directory.clone(), &scene, &rest, ranks);
                assert!(after.success, "{name}:\n{}", after.output);
                after
            };
            let frictionless = vec![format!("pair_coeff * * {NORMAL}")];
            let without = force(&go_on(frictionless, &["run 0"]));
            let tangential = distance(force(&before), without);
            assert!(tangential > 1e-3 * distance(without, [0.0; 3]), "{name}");
            for changed in ["type 1", "atom 2"] {
                let what = format!("{name}, {changed}, {ranks} ranks, newton {newton}");
                let set = format!("set {changed} type 2");
                let after = go_on(vec![], &[&set, "run 0"]);
                let left = distance(force(&after), without) / tangential;
                println!("{what}: {left}");
                assert_eq!(
                    is_warned_of_types(&after),
                    !kept,
                    "{what}: {}",
                    after.output
                );
                assert_left(&what, left, kept, 1e-10);
                // What is written again before the first run is of the new types.
                let again = go_on(vec![], &[&set, "write_restart again.restart", "run 0"]);
                let left_again = distance(force(&again), without) / tangential;
                assert!((left - left_again).abs() < 1e-10, "{what}: {left_again}");
            }
        }
    }
}

/// A fix may change types while a run goes on: with the next list, and not before it.
#[test]
fn no_type_that_a_fix_gives_takes_for_its_own_what_another_remembered() {
    let engine = Engine::from_environment();
    for (ranks, newton) in [(1, true), (2, true), (2, false)] {
        let go_on = |name: &str, laws: [&str; 2], lists: &str, changes: bool| {
            let last = HALF + 1;
            let mut runs = vec![
                format!("neigh_modify every 1 delay 0 {lists}"),
                "variable type atom 1+(id==1)*(step>=200)".to_string(),
            ];
            if changes {
                runs.push("fix change all set 200 0 group all type v_type".into());
            }
            runs.push(format!("run {last}"));
            let deck = Deck {
                pair: two_laws(laws),
                runs,
                steps: last,
                ..deck_of_two_types(ranks, newton)
            };
            let directory = fresh_directory(&format!("{name}_{ranks}_{newton}"));
            attempt_in(&engine, directory, &of_two_types(), &deck, ranks)
        };
        for (name, laws, kept) in CHANGES_OF_TYPE {
            let what = format!("{name}, {ranks} ranks, newton {newton}");
            let before = go_on("before", laws, "check no", false);
            let without = force(&go_on("without", [laws[0], NORMAL], "check no", true));
            let tangential = distance(force(&before), without);
            let listed = go_on("listed", laws, "check no", true);
            assert!(listed.success, "{what}:\n{}", listed.output);
            // One step adds to a new contact a two-hundredth of what there was.
            let left = distance(force(&listed), without) / tangential;
            println!("{what}: {left}");
            assert_eq!(
                is_warned_of_types(&listed),
                !kept,
                "{what}: {}",
                listed.output
            );
            assert_left(&what, left, kept, 0.02);
            let between = go_on("between", laws, "check yes", true);
            assert_eq!(between.success, kept, "{what}: {}", between.output);
            let words = "between two neighbour lists";
            assert_eq!(
                between.output.contains(words),
                !kept,
                "{what}: {}",
                between.output
            );
        }
    }
}
