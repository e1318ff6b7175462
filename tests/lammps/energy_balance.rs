// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is what the outputs call dissipated what was dissipated, by viscosity and by friction?

use std::collections::HashMap;

use crate::decomposition::LAW;
use crate::harness::{attempt_in, crowd, last_lines, run, Deck, Engine, Grain, Outcome, Scene};
use crate::shapes::{scale, Random};

type Row = HashMap<String, f64>;

const WALLS: [&str; 3] = ["x_walls", "y_walls", "floor"];

/// Computes that name all energies; `thermo ke` needs more than one grain.
fn accounts() -> Vec<String> {
    vec![
        "compute moving all ke".into(),
        "compute turning all erotate/asphere".into(),
        "compute energy all pair gran/ellipsoid".into(),
    ]
}

const PAIRS: &str =
    "step c_moving c_turning c_energy[1] c_energy[2] c_energy[3] c_energy[4] c_energy[5] c_energy[6]";

/// The energies of a row.
struct Energies {
    /// Kinetic, elastic and gravitational, less the work of the walls.
    kept: f64,
    viscous: f64,
    friction: f64,
}

impl Energies {
    fn of(row: &Row, walls: &[&str]) -> Energies {
        let get = |name: &str| row.get(name).copied().unwrap_or(0.0);
        let mut e = Energies {
            kept: row["c_moving"]
                + row["c_turning"]
                + row["c_energy[1]"]
                + row["c_energy[2]"]
                + get("f_gravity"),
            viscous: row["c_energy[5]"],
            friction: row["c_energy[6]"],
        };
        let mut dissipated = row["c_energy[3]"];
        for wall in walls {
            let value = |k: usize| row[&format!("f_{wall}[{k}]")];
            assert_eq!(row[&format!("f_{wall}")], value(7) + value(8));
            e.kept += value(7) + value(8) - value(13);
            e.viscous += value(11);
            e.friction += value(12);
            dissipated += value(9);
        }
        let rounding = 1e-12 * (e.viscous.abs() + e.friction.abs() + e.kept.abs());
        assert!(
            (dissipated - e.viscous - e.friction).abs() <= rounding,
            "what is dissipated is not the sum of its parts"
        );
        e
    }

    fn dissipated(&self) -> f64 {
        self.viscous + self.friction
    }
}

fn columns(walls: &[&str]) -> String {
    let mut text = PAIRS.to_string();
    for wall in walls {
        text += &format!(" f_{wall} f_{wall}[*]");
    }
    text
}

/// The largest departure of the sum of all energies from what it was.
fn departure(energies: &[Energies]) -> f64 {
    let sum = |e: &Energies| e.kept + e.dissipated();
    energies
        .iter()
        .map(|e| (sum(e) - sum(&energies[0])).abs())
        .fold(0.0, f64::max)
}

/// A ball pressed between two planes, pushed along them, sticks, rocks and turns. No law of these dissipates.
#[test]
fn both_versions_a_clamped_sphere_dissipates_nothing() {
    let engine = Engine::from_environment();
    let (radius, gap) = (1e-2, 0.99e-2);
    for law in [
        "hertz 1e7 0.3 tangential mindlin 1000",
        "hertz 1e7 0.3 tangential mindlin 1000 displacement incremental",
        "hertz 1e7 0.3 tangential tfd 1000 displacement total",
        "hertz 1e7 0.3 tangential tfd 1000 displacement rescaled",
        "lsd 1e5 0 tangential linear 1e5 0 1000",
    ] {
        let largest = |time_step: f64| {
            let grain = Grain {
                density: 2500.0,
                ..Grain::sphere(radius, [0.0; 3])
            };
            let scene = Scene::open(0.03, vec![grain.moving([0.05, 0.0, 0.0])]);
            let mut fixes = accounts();
            fixes.push(format!(
                "fix floor all wall/gran/ellipsoid {law} zplane {:e} {gap:e}",
                -gap
            ));
            let steps = (4e-3 / time_step).round() as u64;
            let deck = Deck {
                fixes,
                time_step,
                steps,
                thermo_every: steps / 50,
                thermo_columns: columns(&["floor"]),
                skin: 1e-3,
                ..Deck::new(law)
            };
            let outcome = run(&engine, "clamped", &scene, &deck, 1);
            let rows = outcome.thermo();
            let start = rows[0]["c_moving"];
            let stored = rows
                .iter()
                .map(|r| r["f_floor[8]"] / start)
                .fold(0.0, f64::max);
            assert!(stored > 0.4, "{law}: only {stored} is stored");
            let energies: Vec<Energies> =
                rows.iter().map(|r| Energies::of(r, &["floor"])).collect();
            for e in &energies {
                assert_eq!(e.viscous, 0.0, "{law}: no viscosity");
            }
            let friction = energies.iter().map(|e| e.friction.abs() / start);
            (friction.fold(0.0, f64::max), departure(&energies) / start)
        };
        let errors = [8e-6, 4e-6, 2e-6].map(largest);
        println!(
            "{law}: share of the energy said to be dissipated {:.1e} {:.1e} {:.1e}, sum off by {:.1e} {:.1e} {:.1e}",
            errors[0].0, errors[1].0, errors[2].0, errors[0].1, errors[1].1, errors[2].1
        );
        for k in 0..2 {
            assert!(
                errors[k + 1].0 < 0.3 * errors[k].0 || errors[k + 1].0 < 1e-8,
                "{law}: not of second order"
            );
            assert!(
                errors[k + 1].1 < 0.3 * errors[k].1,
                "{law}: not of second order"
            );
        }
        assert!(errors[2].0 < 1e-4, "{law}");
    }
}

const PAIRS_OF_GRAINS: usize = 16;
const COARSE_STEP: f64 = 4e-5;

/// Pairs of grains collide head on, or aside: the sum of all energies departs with the square of the step. The error of one
/// collision depends on where within a step it begins; many pairs, each begun later than the last, stand for all.
#[test]
fn both_versions_a_collision_is_accounted_for_to_second_order() {
    let engine = Engine::from_environment();
    for (law, aside) in [
        ("nfd 1e7 0.3 500 500", 0.0),
        ("nfd 1e7 0.3 500 500 unloading first_order", 0.0),
        ("hertz 1e7 0.3 damping restitution 0.6", 0.0),
        ("lsd 2e4 2", 0.0),
        (
            "nfd 1e7 0.3 500 500 tangential tfd 0.4 displacement rescaled",
            0.6,
        ),
        ("nfd 1e7 0.3 500 500 tangential mindlin 0.4", 0.6),
        ("lsd 2e4 2 tangential linear 1.5e4 1 0.5", 0.6),
    ] {
        let grain = |side: f64, pair: usize| {
            let gap = 1e-5 + pair as f64 / PAIRS_OF_GRAINS as f64 * 0.3 * COARSE_STEP;
            let place = [side * (1.2e-2 + gap), 0.0, 0.04 * pair as f64 - 0.3];
            Grain {
                density: 2500.0,
                ..Grain::new([1.2e-2, 1e-2, 0.8e-2], place)
            }
            .moving([-side * 0.3, side * aside * 0.3, 0.0])
        };
        let grains = (0..PAIRS_OF_GRAINS).flat_map(|k| [grain(-1.0, k), grain(1.0, k)]);
        let scene = Scene::open(0.4, grains.collect());
        let account = |time_step: f64| {
            let steps = (5e-3 / time_step).round() as u64;
            let deck = Deck {
                fixes: accounts(),
                time_step,
                steps,
                thermo_every: 1,
                thermo_columns: PAIRS.into(),
                skin: 1e-3,
                ..Deck::new(law)
            };
            let outcome = run(&engine, "collision_account", &scene, &deck, 1);
            let rows = outcome.thermo();
            assert_eq!(
                rows[rows.len() - 1]["c_energy[4]"],
                0.0,
                "{law}: still in touch"
            );
            let contact = rows.iter().filter(|r| r["c_energy[4]"] > 0.0).count();
            let energies: Vec<Energies> = rows.iter().map(|r| Energies::of(r, &[])).collect();
            let last = &energies[energies.len() - 1];
            assert!(last.viscous > 0.02 * energies[0].kept, "{law}");
            assert_eq!(
                last.friction > 1e-3 * energies[0].kept,
                aside > 0.0,
                "{law}"
            );
            // After the contact, where the error of the sum is not that of the kinetic energy at an instant.
            let error = last.kept + last.dissipated() - energies[0].kept;
            (error.abs() / last.dissipated(), contact)
        };
        let all = [1.0, 0.5, 0.25].map(|share| account(share * COARSE_STEP));
        println!(
            "{law}: the sum is off by {:.1e} {:.1e} {:.1e} of what is dissipated at {} {} {} steps in contact",
            all[0].0, all[1].0, all[2].0, all[0].1, all[1].1, all[2].1
        );
        assert!(
            all[1].0 < 0.4 * all[0].0 && all[2].0 < 0.15 * all[0].0,
            "{law}: not of second order"
        );
        assert!(all[0].0 < 2e-3, "{law}");
    }
}

/// Grains thrown into a box.
pub fn cloud() -> Scene {
    let mut random = Random(7);
    let cell = 8.5e-3;
    let mut grains = vec![];
    for k in 0..64 {
        let place = [k % 4, k / 4 % 4, k / 16].map(|c| c as f64 + 0.5);
        let grain = Grain {
            density: 2500.0,
            ..Grain::new([2e-3, 2e-3, 4e-3], scale(cell, place)).turned(random.quaternion())
        };
        let mut velocity = scale(0.3, random.direction());
        velocity[2] -= 0.5;
        grains.push(grain.moving(velocity));
    }
    Scene {
        boundary: "f f f".into(),
        ..Scene::periodic([0.0; 3], [4.0 * cell, 4.0 * cell, 0.1], grains)
    }
}

fn box_of(law: &str, time_step: f64, time: f64, motion: &str) -> Deck {
    let steps = (time / time_step).round() as u64;
    let mut fixes = accounts();
    fixes.extend([
        "fix gravity all gravity 9.81 vector 0 0 -1".into(),
        format!("fix x_walls all wall/gran/ellipsoid {law} xplane 0 0.034"),
        format!("fix y_walls all wall/gran/ellipsoid {law} yplane 0 0.034"),
        format!("fix floor all wall/gran/ellipsoid {law} zplane 0 NULL {motion}"),
    ]);
    Deck {
        fixes,
        time_step,
        steps,
        thermo_every: steps / 20,
        thermo_columns: columns(&WALLS) + " f_gravity",
        skin: 1e-3,
        ..Deck::new(law)
    }
}

fn energies(outcome: &Outcome) -> Vec<Energies> {
    let rows = outcome.thermo();
    rows.iter().map(|r| Energies::of(r, &WALLS)).collect()
}

/// Contacts of these grains last 0.8 ms or more: 40 steps of 20 us.
const HEAP_STEP: f64 = 2e-5;

#[test]
fn both_versions_a_settling_heap_is_in_balance() {
    let engine = Engine::from_environment();
    for law in [
        "nfd 3e6 0.3 200 200 tangential tfd 0.5 displacement rescaled",
        "nfd 3e6 0.3 200 200 tangential tfd 0.5 displacement total",
        "hertz 3e6 0.3 tangential mindlin 0.5",
        "hertz 3e6 0.3 damping restitution 0.7 tangential mindlin 0.5 displacement incremental",
        "lsd 1.2e3 0.06 tangential linear 800 0.03 0.5",
    ] {
        let balance = |time_step: f64| {
            let deck = box_of(law, time_step, 0.1, "");
            let all = energies(&run(&engine, "heap", &cloud(), &deck, 1));
            let last = &all[all.len() - 1];
            assert!(last.dissipated() > 0.3 * all[0].kept.abs(), "{law}");
            assert!(last.friction > 0.0, "{law}");
            assert_eq!(
                last.viscous > 0.0,
                !law.starts_with("hertz 3e6 0.3 tangential")
            );
            for pair in all.windows(2) {
                assert!(
                    pair[1].viscous >= pair[0].viscous,
                    "{law}: viscosity gives energy"
                );
            }
            (
                departure(&all) / last.dissipated(),
                last.viscous,
                last.friction,
            )
        };
        let (coarse, fine) = (balance(HEAP_STEP), balance(0.5 * HEAP_STEP));
        println!(
            "{law}: the sum departs by {:.1e} of what is dissipated, {:.1e} at half the step; viscous {:.3e} J, friction {:.3e} J",
            coarse.0, fine.0, coarse.1, coarse.2
        );
        assert!(coarse.0 < 1e-3, "{law}");
        assert!(fine.0 < 0.5 * coarse.0 || fine.0 < 2e-4, "{law}");
    }
}

#[test]
fn both_versions_a_shaken_packing_is_in_balance() {
    let engine = Engine::from_environment();
    for (law, motion) in [
        (
            "nfd 3e6 0.3 200 200 tangential tfd 0.5 displacement rescaled",
            "wiggle z 0.0005 0.01",
        ),
        ("hertz 3e6 0.3 tangential mindlin 0.5", "shear x 0.2"),
    ] {
        let deck = box_of(law, HEAP_STEP, 0.1, motion);
        let outcome = run(&engine, "shaken", &cloud(), &deck, 1);
        let rows = outcome.thermo();
        let work = rows[rows.len() - 1]["f_floor[13]"];
        let all = energies(&outcome);
        let last = &all[all.len() - 1];
        let share = departure(&all) / last.dissipated();
        println!("{law} {motion}: the floor did {work:.2e} J of work, {:.2e} J are dissipated, the sum departs by {share:.1e} of that", last.dissipated());
        assert!(work.abs() > 0.05 * last.dissipated(), "{law}");
        assert!(share < 1e-3, "{law}");
    }
}

/// The sums are the same on several ranks, with newton on and off; a run that is split or restarted goes on with them.
#[test]
fn both_versions_dissipation_does_not_depend_on_ranks_and_goes_on() {
    let engine = Engine::from_environment();
    const HALF: u64 = 100;
    let deck = |newton: bool| Deck {
        newton,
        fixes: accounts(),
        time_step: 1e-5,
        steps: 2 * HALF,
        thermo_every: HALF,
        thermo_columns: PAIRS.into(),
        skin: 2e-3,
        ..Deck::new(LAW)
    };
    let last = |outcome: &Outcome| {
        let rows = outcome.thermo();
        let e = Energies::of(&rows[rows.len() - 1], &[]);
        [e.viscous, e.friction]
    };
    let scene = crowd(64);
    let reference = last(&run(&engine, "dissipated_1", &scene, &deck(true), 1));
    assert!(reference[0] > 0.0 && reference[1] > 0.0);
    let apart = |other: [f64; 2]| {
        (0..2)
            .map(|k| (other[k] / reference[k] - 1.0).abs())
            .fold(0.0, f64::max)
    };
    for (ranks, newton) in [(1, false), (2, true), (2, false), (4, true), (4, false)] {
        let outcome = run(&engine, "dissipated_n", &scene, &deck(newton), ranks);
        let difference = apart(last(&outcome));
        println!("{ranks} ranks, newton {newton}: {difference:.1e}");
        assert!(difference < 1e-8, "{ranks} ranks, newton {newton}");
    }

    // LAMMPS evaluates forces anew when a run starts, with other velocities: the motion differs a little.
    let mut split = deck(true);
    split.runs = vec![
        format!("run {HALF}"),
        "write_restart middle.restart".into(),
        format!("run {HALF}"),
    ];
    let split = run(&engine, "dissipated_split", &scene, &split, 2);
    let in_two = last(&split);
    let restarted = Deck {
        pair: vec![],
        source: vec!["read_restart middle.restart".into()],
        steps: HALF,
        ..deck(true)
    };
    let restarted = attempt_in(&engine, split.directory, &scene, &restarted, 4);
    assert!(restarted.success, "{}", last_lines(&restarted.output));
    let after_restart = last(&restarted);
    println!(
        "split {:.1e}; restarted against split {:.1e}",
        apart(in_two),
        (0..2)
            .map(|k| (after_restart[k] / in_two[k] - 1.0).abs())
            .fold(0.0, f64::max)
    );
    assert!(apart(in_two) < 2e-2);
    for k in 0..2 {
        assert!((after_restart[k] / in_two[k] - 1.0).abs() < 1e-8);
    }
}
