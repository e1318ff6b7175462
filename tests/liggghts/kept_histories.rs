// SPDX-License-Identifier: MIT OR Apache-2.0
//! Histories stay in the library while a neighbour list lasts: are they in LIGGGHTS' own arrays whenever something reads them?
//!
//! LIGGGHTS' own loop, which runs in steps in which the virial is asked for, never leaves any in the library: it says what is right.

use crate::decomposition::{deck, difference};
use crate::harness::{crowd, fresh_directory, run, run_in, Deck, Engine, Scene};

const STEPS: u64 = 300;
/// Neighbour lists of so small a skin do not last ten steps.
const SKIN: f64 = 2e-4;

/// The commands, with our loop or with LIGGGHTS' own.
fn with(ours: bool, fixes: &[&str], runs: &[&str]) -> Deck {
    let mut lines = vec![
        "compute stress all stress/atom".to_string(),
        "compute sum all reduce sum c_stress[1]".into(),
    ];
    lines.extend(fixes.iter().map(|f| (*f).to_string()));
    let mut all = vec![format!("thermo {}", if ours { STEPS } else { 1 })];
    all.extend(runs.iter().map(|r| (*r).to_string()));
    Deck {
        skin: SKIN,
        fixes: lines,
        thermo: if ours { "step ke" } else { "step ke c_sum" }.into(),
        runs: all,
        ..deck(STEPS)
    }
}

fn held_to_their_loop(name: &str, scene: &Scene, fixes: &[&str], runs: &[&str], ranks: usize) {
    let engine = Engine::from_environment();
    let [ours, theirs] = [true, false].map(|ours| {
        let name = format!("kept_{name}_{ranks}_{ours}");
        run(&engine, &name, scene, &with(ours, fixes, runs), ranks)
            .last()
            .clone()
    });
    let apart = difference(&ours, &theirs);
    println!("{name}, {ranks} ranks: velocities apart by {apart:.1e}");
    assert_eq!(ours.states.len(), theirs.states.len(), "{name}");
    assert!(apart < 1e-9, "{name}, {ranks} ranks: {apart:e}");
}

#[test]
fn new_neighbour_lists_find_the_histories() {
    let scene = crowd(64);
    for ranks in [1, 4] {
        held_to_their_loop("lists", &scene, &[], &["run 300"], ranks);
    }
    // each loop in turns within one list
    let turns = &[
        "run 100",
        "thermo_style custom step ke c_sum",
        "thermo 3",
        "run 100",
        "thermo 300",
        "run 100",
    ];
    held_to_their_loop("turns", &scene, &[], turns, 1);
}

#[test]
fn grains_are_deleted_between_runs() {
    let scene = crowd(64);
    let runs = &[
        "run 120 post no",
        "group some id 3 17 40",
        "delete_atoms group some compress no",
        "run 90 pre no every 30 \"variable nothing equal 1\"",
        "run 90",
    ];
    for ranks in [1, 2] {
        held_to_their_loop("deleted", &scene, &[], runs, ranks);
    }
}

#[test]
fn another_pair_style_begins_and_ends() {
    let runs = &[
        "run 120",
        "pair_style gran model nfd tangential tfd surface ellipsoid totalDisplacement on",
        "pair_coeff * *",
        "run 120",
    ];
    held_to_their_loop("style", &crowd(64), &[], runs, 1);
}

/// LIGGGHTS deletes with a pair style what contacts remember: the run after another one says so, once, and no other run does.
#[test]
fn a_pair_style_that_is_given_again_is_warned_of() {
    let engine = Engine::from_environment();
    let again = [
        "pair_style gran model nfd tangential tfd surface ellipsoid",
        "pair_coeff * *",
    ];
    let [first, once] = ["run 120", "run 30"];
    for ranks in [1, 2] {
        for (name, runs, warnings) in [
            ("never", vec![first, once], 0),
            ("before", [&again[..], &[first, once]].concat(), 0),
            ("once", [&[first], &again[..], &[once, once]].concat(), 1),
            (
                "twice",
                [&[first], &again[..], &[once], &again[..], &[once]].concat(),
                2,
            ),
            (
                "frictionless",
                vec![
                    first,
                    "pair_style gran model nfd tangential off surface ellipsoid",
                    "pair_coeff * *",
                    once,
                ],
                0,
            ),
            (
                "restart",
                [&[first], &again[..], &["write_restart now", once]].concat(),
                1,
            ),
        ] {
            let name = format!("again_{name}_{ranks}");
            let outcome = run(&engine, &name, &crowd(64), &with(true, &[], &runs), ranks);
            let found = outcome.output.matches("pair_style was given again");
            assert_eq!(found.count(), warnings, "{name}: {}", outcome.output);
        }
    }
}

/// They hold the histories between runs.
#[test]
fn pages_of_another_size_keep_the_histories() {
    let engine = Engine::from_environment();
    let scene = crowd(64);
    for ranks in [1, 2] {
        let [changed, plain] = ["one 3000 page 60000", "one 2000 page 100000"].map(|pages| {
            let change = format!("neigh_modify {pages}");
            let runs = ["run 120", &change, "run 30", &change, "run 150"];
            let name = format!("kept_pages_{ranks}_{}", pages.len());
            run(&engine, &name, &scene, &with(true, &[], &runs), ranks)
                .last()
                .clone()
        });
        let apart = difference(&changed, &plain);
        println!("pages, {ranks} ranks: velocities apart by {apart:.1e}");
        assert!(apart < 1e-12, "{ranks} ranks: {apart:e}");
    }
}

/// A file that is written in the middle of a run, while the library has the histories.
#[test]
fn a_restart_file_of_the_middle_of_a_run_has_them() {
    let engine = Engine::from_environment();
    let scene = crowd(64);
    for ranks in [1, 4] {
        let [ours, theirs] = [true, false].map(|ours| {
            let directory = fresh_directory(&format!("kept_restart_{ranks}_{ours}"));
            let last = |deck: &Deck| {
                run_in(&engine, &directory, &scene, deck, ranks)
                    .last()
                    .clone()
            };
            let through = last(&with(ours, &[], &["restart 150 middle.*", "run 300"]));
            let mut rest = with(ours, &[], &["run 150"]);
            rest.source = vec!["read_restart middle.150".into()];
            [through, last(&rest)]
        });
        for (what, k) in [("through", 0), ("restarted", 1)] {
            let apart = difference(&ours[k], &theirs[k]);
            println!("{what}, {ranks} ranks: velocities apart by {apart:.1e}");
            assert_eq!((ours[k].step, theirs[k].step), (300, 300));
            assert!(apart < 1e-9, "{what}, {ranks} ranks: {apart:e}");
        }
    }
}

/// Heat flows through the contacts whose flags are set in the histories, in each step.
#[test]
fn heat_flows_through_the_contacts_of_the_step() {
    let engine = Engine::from_environment();
    let scene = crowd(64);
    let fixes = &[
        "fix k all property/global thermalConductivity peratomtype 50.",
        "fix c all property/global thermalCapacity peratomtype 0.01",
        "fix f all heat/gran/conduction initial_temperature 300. contact_area constant 1e-6",
        "run 0",
        "set atom 1*32 property/atom Temp 900.",
        "variable square atom f_Temp*f_Temp",
        "compute y all reduce sum v_square",
        "fix squares all ave/time 7 1 7 c_y file squares.txt",
    ];
    let squares = [true, false].map(|ours| {
        let directory = fresh_directory(&format!("kept_heat_{ours}"));
        run_in(
            &engine,
            &directory,
            &scene,
            &with(ours, fixes, &["run 300"]),
            1,
        );
        let text = std::fs::read_to_string(directory.join("squares.txt")).unwrap();
        let rows = text.lines().filter(|line| !line.starts_with('#'));
        let value = |row: &str| {
            row.split_whitespace()
                .nth(1)
                .unwrap()
                .parse::<f64>()
                .unwrap()
        };
        rows.map(value).collect::<Vec<_>>()
    });
    assert!(squares[0].len() > 40);
    let (first, last) = (squares[0][0], squares[0][squares[0].len() - 1]);
    println!("squares of temperatures: {first} to {last}");
    assert!(last < 0.999 * first, "nothing flows: {first} to {last}");
    for (ours, theirs) in squares[0].iter().zip(&squares[1]) {
        assert!((ours - theirs).abs() < 1e-6 * theirs, "{ours} {theirs}");
    }
}

/// LIGGGHTS gives images of grains their shapes when it builds neighbour lists. A run without set-up goes on with the list of the one before it: its
/// contacts across boundaries and ranks are those of the grains as commands have left them.
#[test]
fn images_have_the_shapes_that_commands_set_before_a_run_without_set_up() {
    let engine = Engine::from_environment();
    let mut scene = crowd(64);
    scene.boundary = "p p p".into();
    let command = "set group some shape 0.0125 0.0095 0.0085";
    for (ranks, total) in [(1, "on"), (2, "off"), (2, "on")] {
        let forces = |last: &str| {
            let mut deck = with(true, &["group some id < 33"], &["run 120", command, last]);
            deck.settings = format!("totalDisplacement {total}");
            deck.skin = 4e-3;
            deck.steps = 121;
            let name = format!("images_{ranks}_{total}_{}", last.len());
            let outcome = run(&engine, &name, &scene, &deck, ranks);
            let states = &outcome.last().states;
            states.iter().flat_map(|s| s.force).collect::<Vec<f64>>()
        };
        let [set_up, at_once] = ["run 1", "run 1 pre no"].map(forces);
        let largest = set_up.iter().fold(0.0f64, |most, f| most.max(f.abs()));
        let apart = set_up.iter().zip(&at_once).map(|(a, b)| (a - b).abs());
        let apart = apart.fold(0.0, f64::max) / largest;
        println!("{ranks} ranks, {total}: forces apart by {apart:.1e}");
        // Without set-up the step begins with the forces of the old shapes. With old images this is 0.9.
        assert!(largest > 0.0 && apart < 0.05, "{ranks}, {total}: {apart:e}");
    }
}
