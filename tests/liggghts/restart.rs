// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a run that is continued from a restart file go on as if it had not been interrupted, contact history included?

use std::fs;

use crate::decomposition::{deck, difference};
use crate::harness::{crowd, fresh_directory, run_in, Deck, Engine, State};
use crate::mesh_ranks::{on_a_sheet, sheet_deck};
use crate::meshes::sheet;

#[test]
fn a_restarted_run_goes_on() {
    let engine = Engine::from_environment();
    let directory = fresh_directory("restart");
    let scene = crowd(27);
    // A run that goes on in one process sets up anew too: the same steps in the same pieces.
    let whole = Deck {
        runs: vec![
            "run 150".into(),
            "write_restart half".into(),
            "run 150".into(),
        ],
        ..deck(300)
    };
    let through = run_in(&engine, &directory, &scene, &whole, 1);
    let rest = Deck {
        source: vec!["read_restart half".into()],
        runs: vec!["run 150".into()],
        ..deck(300)
    };
    let again = run_in(&engine, &directory, &scene, &rest, 1);
    let apart = difference(again.last(), through.last());
    println!("velocities after the restart apart by {apart:.1e}");
    assert_eq!(again.last().step, 300);
    assert!(apart < 1e-9);
}

/// A file that LIGGGHTS writes while a run goes on has what contacts remember after the forces of its step, as the velocities in it are of that step.
#[test]
fn a_file_of_the_middle_of_a_run_goes_on() {
    let engine = Engine::from_environment();
    let scene = crowd(27);
    for model in [
        "nfd tangential tfd surface ellipsoid",
        "nfd tangential tfd rolling_friction cdt surface ellipsoid",
    ] {
        for (before, after) in [(1, 1), (2, 2), (2, 1)] {
            let directory = fresh_directory("middle");
            let with = |source: &[&str], runs: &[&str]| Deck {
                model: model.into(),
                before: vec![
                    "fix r all property/global coefficientRollingFriction peratomtypepair 1 0.1"
                        .into(),
                ],
                integrator: "ellipsoid",
                source: source.iter().map(|line| line.to_string()).collect(),
                runs: runs.iter().map(|line| line.to_string()).collect(),
                ..deck(300)
            };
            let whole = with(&[], &["restart 150 middle.*", "run 300"]);
            let through = run_in(&engine, &directory, &scene, &whole, before);
            let rest = with(&["read_restart middle.150"], &["run 150"]);
            let again = run_in(&engine, &directory, &scene, &rest, after);
            let apart = difference(again.last(), through.last());
            println!("{model}, {before} ranks, then {after}: velocities apart by {apart:.1e}");
            assert_eq!((again.last().step, through.last().step), (300, 300));
            assert!(apart < 1e-9, "{model}: {apart:e}");
        }
    }
}

/// Grains that slide and roll over the triangles of a mesh, on as many ranks as told before and after the restart.
#[test]
fn a_restart_in_the_middle_of_contacts_with_a_mesh() {
    let engine = Engine::from_environment();
    let directory = fresh_directory("mesh");
    fs::write(directory.join("sheet.stl"), sheet(8)).unwrap();
    let scene = on_a_sheet();
    let first = |ranks: usize| Deck {
        runs: vec![
            "run 120".into(),
            format!("write_restart half{ranks}"),
            "run 80".into(),
        ],
        ..sheet_deck()
    };
    let through = run_in(&engine, &directory, &scene, &first(1), 1);
    let middle = through.frames.iter().find(|f| f.step == 120).unwrap();
    let rubbed = |s: &&State| s.force[0].hypot(s.force[1]) > 0.0;
    assert_eq!(middle.states.iter().filter(rubbed).count(), 4);
    run_in(&engine, &directory, &scene, &first(4), 4);
    for (before, after) in [(1, 1), (4, 1), (1, 4)] {
        let rest = Deck {
            source: vec![format!("read_restart half{before}")],
            runs: vec!["run 80".into()],
            ..sheet_deck()
        };
        let again = run_in(&engine, &directory, &scene, &rest, after);
        let apart = difference(again.last(), through.last());
        println!("written by {before} ranks, read by {after}: velocities apart by {apart:.1e}");
        assert_eq!(again.last().step, 200);
        assert!(apart < 1e-12);
    }
}

/// The same on a plane that moves along itself, and in a wide cylinder that turns.
#[test]
fn a_restart_in_the_middle_of_contacts_with_primitive_walls() {
    let engine = Engine::from_environment();
    for (name, wall) in [
        ("plane", "zplane 0.0 shear x 1.0"),
        ("cylinder", "ycylinder 1000.0 1000.0 0.0 shear z 0.001"),
    ] {
        let directory = fresh_directory(name);
        let whole = Deck {
            before: vec![],
            walls: vec![format!("primitive type 1 {wall}")],
            runs: vec![
                "run 120".into(),
                "write_restart half".into(),
                "run 80".into(),
            ],
            ..sheet_deck()
        };
        let through = run_in(&engine, &directory, &on_a_sheet(), &whole, 1);
        let rest = Deck {
            source: vec!["read_restart half".into()],
            runs: vec!["run 80".into()],
            ..whole
        };
        let again = run_in(&engine, &directory, &on_a_sheet(), &rest, 1);
        let middle = again.first();
        let rubbed = |s: &&State| s.force[0].hypot(s.force[1]) > 0.0;
        let apart = difference(again.last(), through.last());
        println!("{name}: velocities after the restart apart by {apart:.1e}");
        assert_eq!((middle.step, again.last().step), (120, 200));
        assert!(middle.states.iter().filter(rubbed).count() >= 3);
        assert!(apart < 1e-12);
    }
}

/// Constants of LIGGGHTS' rolling models.
const OF_ROLLING: [&str; 2] = [
    "fix rolling all property/global coefficientRollingFriction peratomtypepair 1 0.5",
    "fix damping all property/global coefficientRollingViscousDamping peratomtypepair 1 0.0",
];

/// Models of which contacts remember equally many values: before and after a restart, and whether these mean the same.
const EQUALLY_MANY: [(&str, &str, bool); 4] = [
    ("nfd rolling_friction epsd", "nfd tangential history", false),
    ("nfd tangential history", "nfd rolling_friction epsd", false),
    ("nfd tangential history", "hertz tangential history", true),
    ("nfd tangential tfd", "nfd tangential tfd", true),
];

fn is_warned_of(output: &str, who: &str) -> bool {
    output.lines().any(|line| {
        line.contains(who) && line.contains("contacts remember something else")
            || line.contains(who) && line.contains("contacts of grains remember something else")
    })
}

/// A wall with other models after a restart does not take a torque for a displacement: what is remembered begins anew, as under another ID, and a
/// warning says so.
#[test]
fn after_a_restart_no_wall_takes_for_its_own_what_another_remembered() {
    let engine = Engine::from_environment();
    for (kind, wall) in [
        ("plane", "primitive type 1 zplane 0.0"),
        ("mesh", "mesh n_meshes 1 meshes sheet"),
    ] {
        for (before, after, kept) in EQUALLY_MANY {
            let what = format!("{kind}, {before} to {after}");
            let directory = fresh_directory(&format!("wall_{kind}"));
            fs::write(directory.join("sheet.stl"), sheet(8)).unwrap();
            let with = |models: &str, id: &str, source: &[&str], runs: &[&str]| {
                let lines = |words: &[&str]| words.iter().map(|w| w.to_string()).collect();
                let models = format!("{models} surface ellipsoid");
                let mut fixes = sheet_deck().fixes;
                fixes.push(format!(
                    "fix {id} all wall/gran/ellipsoid model {models} {wall}"
                ));
                let deck = Deck {
                    model: models,
                    before: [sheet_deck().before, lines(&OF_ROLLING)].concat(),
                    walls: vec![],
                    fixes,
                    source: lines(source),
                    runs: lines(runs),
                    ..sheet_deck()
                };
                run_in(&engine, &directory, &on_a_sheet(), &deck, 1)
            };
            with(before, "floor", &[], &["run 120", "write_restart half"]);
            let [again, anew] =
                ["floor", "other"].map(|id| with(after, id, &["read_restart half"], &["run 0"]));
            let forces =
                |states: &[State]| states.iter().flat_map(|s| s.force).collect::<Vec<f64>>();
            let (now, without) = (forces(&again.last().states), forces(&anew.last().states));
            assert!(without.iter().any(|f| *f != 0.0), "{what}");
            assert_eq!(now == without, !kept, "{what}:\n{now:?}\n{without:?}");
            let warned = is_warned_of(&again.output, "Fix floor");
            assert_eq!(warned, !kept, "{what}: {}", again.output);
        }
    }
}

/// The same of the grains' contacts with one another. `pair_style` given again forgets, which shows what is right.
#[test]
fn after_a_restart_no_pair_takes_for_its_own_what_another_remembered() {
    let engine = Engine::from_environment();
    for ranks in [1, 2] {
        for (before, after, kept) in EQUALLY_MANY {
            let what = format!("{before} to {after}, {ranks} ranks");
            let directory = fresh_directory("pairs");
            let with = |models: &str, runs: Vec<String>| Deck {
                model: format!("{models} surface ellipsoid"),
                before: OF_ROLLING.map(String::from).to_vec(),
                fixes: [
                    vec![
                        "compute turning all property/atom tqx tqy tqz".into(),
                        [
                            "compute largest all reduce max fx fy fz",
                            "c_turning[1] c_turning[2] c_turning[3]",
                        ]
                        .join(" "),
                    ],
                    (1..=6)
                        .map(|k| format!("variable largest{k} equal c_largest[{k}]"))
                        .collect(),
                ]
                .concat(),
                thermo: (1..=6).fold("step".into(), |line, k| line + &format!(" v_largest{k}")),
                runs,
                ..deck(300)
            };
            let first = with(before, vec!["run 150".into(), "write_restart half".into()]);
            run_in(&engine, &directory, &crowd(27), &first, ranks);
            let again = vec![
                "run 0".into(),
                format!("pair_style gran model {after} surface ellipsoid"),
                "pair_coeff * *".into(),
                "run 0".into(),
            ];
            let rest = Deck {
                source: vec!["read_restart half".into()],
                ..with(after, again)
            };
            let rest = run_in(&engine, &directory, &crowd(27), &rest, ranks);
            let rows = rest.thermo();
            assert_eq!(rows.len(), 2, "{what}: {}", rest.output);
            assert_eq!(rows[0].len(), 7, "{what}: {}", rest.output);
            let differ = rows[0].iter().any(|(column, now)| {
                let without = rows[1][column];
                (now - without).abs() > 1e-9 * without.abs()
            });
            assert_eq!(differ, kept, "{what}: {rows:?}");
            let warned = is_warned_of(&rest.output, "pair_style");
            assert_eq!(warned, !kept, "{what}: {}", rest.output);
        }
    }
}
