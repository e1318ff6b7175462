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
