// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do contacts go on where grains are deleted between two runs? `delete_atoms` gives all others new IDs, if it is not told
//! `compress no`, and contacts are remembered by ID.

use crate::harness::{attempt_in, crowd, fresh_directory, run, Deck, Engine, Grain, Scene};

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

/// A grain that comes between two runs gets the ID of one that is gone, if that was the largest. It has touched nothing yet.
#[test]
fn both_versions_a_new_grain_does_not_remember_what_one_of_its_id_did() {
    let engine = Engine::from_environment();
    let grain = |z: f64| Grain {
        density: 2500.0,
        ..Grain::new([5e-3, 4e-3, 3e-3], [0.0, 0.0, z])
    };
    let scene = Scene::open(
        0.1,
        vec![grain(-2.95e-3), grain(2.95e-3).moving([0.5, 0.0, 0.0])],
    );
    let force = |before: &[&str]| {
        let mut runs = vec![
            "run 20",
            "group two id 2",
            "delete_atoms group two compress no",
        ];
        runs.extend(before);
        runs.extend([
            "create_atoms 1 single 0 0 2.95e-3",
            "group new id 2 3",
            "set group new shape 1e-2 8e-3 6e-3",
            "set group new density 2500",
            "set group new quat 0 0 1 0",
            "run 1",
        ]);
        let deck = Deck {
            time_step: 1e-6,
            steps: 20,
            dump_every: 1,
            skin: 2e-3,
            runs: runs.into_iter().map(String::from).collect(),
            ..Deck::new("hertz 1e8 0.3 tangential tfd 0.5")
        };
        run(&engine, "new_grain", &scene, &deck, 1).last().states[0].force
    };
    // One that is far away takes the ID.
    let [taken, other] = [&[][..], &["create_atoms 1 single 0.05 0.05 0.05"]].map(force);
    println!("{taken:?} {other:?}");
    assert!(other[2] < 0.0);
    assert!((0..3).all(|k| (taken[k] - other[k]).abs() < 1e-9 * other[2].abs()));
}

/// LAMMPS moves atoms to the places of those that it deletes without what a restart file has of their contacts.
#[test]
fn both_versions_grains_deleted_before_the_first_run_of_a_restart() {
    let engine = Engine::from_environment();
    let scene = crowd(64);
    let plain = Deck {
        time_step: 1e-5,
        steps: HALF,
        skin: 2e-3,
        ..Deck::new("hertz 1e8 0.3 tangential tfd 0.5")
    };
    let directory = fresh_directory("deleted_restart");
    let first = Deck {
        runs: vec![format!("run {HALF}"), "write_restart half.restart".into()],
        ..plain.clone()
    };
    attempt_in(&engine, directory.clone(), &scene, &first, 1).succeeded();
    for (before, fits) in [(None, false), (Some("run 0"), true)] {
        let mut runs: Vec<String> = before.into_iter().map(String::from).collect();
        runs.extend([
            format!("group gone id {GONE}"),
            "delete_atoms group gone compress no".into(),
            "run 1".into(),
        ]);
        let again = Deck {
            source: vec!["read_restart half.restart".into()],
            runs,
            ..plain.clone()
        };
        let outcome = attempt_in(&engine, directory.clone(), &scene, &again, 1);
        assert_eq!(outcome.success, fits, "{}", outcome.output);
        assert_eq!(
            outcome
                .output
                .contains("5 atoms were deleted since read_restart"),
            !fits
        );
    }
}
