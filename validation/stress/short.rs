// SPDX-License-Identifier: MIT OR Apache-2.0
//! A few seconds of `cargo xtask stress`: nothing is wrong, what is out of range is refused, and a run goes on where it stopped.

#[allow(dead_code)]
mod block;
#[allow(dead_code)]
mod counts;
mod families;
mod materials;
mod refusals;
#[allow(dead_code)]
mod run;
#[allow(dead_code)]
mod stability;
#[path = "../../tests/support/mod.rs"]
mod support;

use counts::State;
use families::Family;
use run::{go_on, Length};

const SEED: u64 = 77;

fn ran(state: &mut State, pairs: u64) {
    go_on(state, Length::Pairs(pairs), 1, None, |_, _| ()).unwrap();
}

fn new() -> State {
    let nowhere = std::path::Path::new("/nonexistent/state");
    State::begin(nowhere, SEED).unwrap()
}

#[test]
fn no_pair_is_wrong() {
    let mut state = new();
    ran(&mut state, 8_000);
    assert_eq!(state.families.len(), Family::ALL.len());
    for (name, counts) in &state.families {
        println!(
            "{name}: {} touching, {} at rounding",
            counts.touching, counts.at_rounding
        );
        assert!(counts.findings.is_empty(), "{name}: {:#?}", counts.findings);
        // Twice as many as pairs where all touch in both steps.
        assert!(counts.touching > counts.pairs, "{name}: {counts:?}");
        assert!(counts.by_brute_force > 0);
    }
}

#[test]
fn what_is_out_of_range_is_refused_by_name_and_value() {
    let refusals = refusals::Refusals::run(SEED);
    assert!(refusals.wrong.is_empty(), "{:#?}", refusals.wrong);
    assert!(refusals.tried > 200, "{}", refusals.tried);
    assert!(refusals.words.len() >= 6, "{:#?}", refusals.words);
}

#[test]
fn a_run_goes_on_where_it_stopped() {
    let directory = tempfile();
    let file = directory.join("state.json");
    let mut whole = new();
    ran(&mut whole, 3_000);
    let mut first = new();
    ran(&mut first, 1_000);
    first.write(&file).unwrap();
    let mut second = State::begin(&file, SEED).unwrap();
    assert_eq!(second.pairs(), first.pairs());
    ran(&mut second, 3_000);
    let by_set = &second.pairs_by_instruction_set;
    assert_eq!(by_set.len(), support::list::instruction_sets().count());
    for (set, pairs) in by_set {
        assert_eq!(*pairs, whole.pairs(), "{set}");
    }
    for (name, counts) in &whole.families {
        let other = &second.families[name];
        assert_eq!(counts.pairs, other.pairs);
        assert_eq!(counts.touching, other.touching);
        assert_eq!(counts.random_sample, other.random_sample);
        assert_eq!(counts.worst_sample, other.worst_sample);
    }
    let other_seed = State::begin(&file, SEED + 1).unwrap_err().to_string();
    assert!(other_seed.contains("seed 77"), "{other_seed}");
    std::fs::remove_dir_all(directory).unwrap();
}

fn tempfile() -> std::path::PathBuf {
    let name = format!("ellgran-stress-{}", std::process::id());
    let directory = std::env::temp_dir().join(name);
    std::fs::create_dir_all(&directory).unwrap();
    directory
}

/// Small motions are stable up to the critical step and not beyond, whatever the damping and the masses; and no collision gains
/// energy to speak of with the advised step.
#[test]
fn steps_are_stable_as_far_as_is_advised() {
    for case in stability::Case::all().step_by(7) {
        let steps = case.measure();
        let small = steps.critical_found / steps.critical;
        assert!((0.98..1.02).contains(&small), "{case:?}: {steps:?}");
        assert!(steps.gain <= stability::GAIN, "{case:?}: {steps:?}");
    }
}
