// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do contacts go on where grains are deleted between two runs? `delete_atoms` gives all others new IDs, if it is not told
//! `compress no`, and contacts are remembered by ID.

use crate::harness::{crowd, run, Deck, Engine};

const HALF: u64 = 150;
/// Grains of the crowd that are deleted: neither first nor last, so that IDs change on either side of others that are kept.
const GONE: &str = "2 9:11 40";

/// Position and velocity of each grain at the end, in an order that IDs do not decide.
fn end(
    engine: &Engine,
    compress: &str,
    between: &[&str],
    ranks: usize,
    newton: bool,
) -> Vec<[f64; 6]> {
    let mut runs = vec![
        format!("run {HALF}"),
        format!("group gone id {GONE}"),
        format!("delete_atoms group gone compress {compress}"),
    ];
    runs.extend(between.iter().map(|command| command.to_string()));
    runs.push(format!("run {HALF}"));
    let deck = Deck {
        time_step: 1e-5,
        steps: HALF,
        skin: 2e-3,
        newton,
        runs,
        ..Deck::new("hertz 1e8 0.3 tangential tfd 0.5")
    };
    let outcome = run(engine, "deleted_grains", &crowd(64), &deck, ranks);
    let mut grains: Vec<[f64; 6]> = outcome
        .last()
        .states
        .iter()
        .map(|s| {
            let (x, v) = (s.position, s.velocity);
            [x[0], x[1], x[2], v[0], v[1], v[2]]
        })
        .collect();
    grains.sort_by(|a, b| a[0].total_cmp(&b[0]));
    grains
}

#[test]
fn both_versions_remember_contacts_where_grains_are_deleted() {
    let engine = Engine::from_environment();
    let kept = end(&engine, "no", &[], 1, true);
    assert_eq!(kept.len(), 59);
    for (between, ranks, newton) in [
        (&[][..], 1, true),
        (&[][..], 2, true),
        (&[][..], 2, false),
        // Grains go to other ranks, and those that are gone leave IDs to others twice.
        (
            &["write_restart middle.restart", "delete_atoms group gone"][..],
            4,
            true,
        ),
    ] {
        let renumbered = end(&engine, "yes", between, ranks, newton);
        assert_eq!(renumbered.len(), kept.len());
        let largest = |first: usize| {
            let all = kept.iter().flat_map(|g| &g[first..first + 3]);
            all.fold(0.0f64, |most, x| most.max(x.abs()))
        };
        for first in [0, 3] {
            let scale = largest(first);
            for (a, b) in renumbered.iter().zip(&kept) {
                for c in first..first + 3 {
                    assert!(
                        (a[c] - b[c]).abs() < 1e-11 * scale,
                        "{ranks} ranks, {between:?}: {a:?} {b:?}"
                    );
                }
            }
        }
    }
}
