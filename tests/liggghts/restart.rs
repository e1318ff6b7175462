// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a run that is continued from a restart file go on as if it had not been interrupted, contact history included?

use crate::decomposition::{crowd, deck, difference};
use crate::harness::{fresh_directory, run_in, Deck, Engine};

#[test]
fn a_restarted_run_goes_on() {
    let engine = Engine::from_environment();
    let directory = fresh_directory("restart");
    let scene = crowd(3);
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
