// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does `compute energy/ellipsoid` gather all energies, does its balance close, and does it go on over runs and restarts?

use std::collections::HashMap;
use std::fs;

use crate::energy_balance::cloud;
use crate::harness::{attempt, attempt_in, last_lines, run, Deck, Engine, Grain, Outcome, Scene};
use crate::shapes::{compose, scale, Random};

const LAW: &str = "nfd 3e6 0.3 200 200 tangential tfd 0.5";

/// Columns of the compute, from 0.
const KINETIC: [usize; 2] = [0, 1];
const ELASTIC: [usize; 2] = [2, 3];
const GRAVITY: usize = 4;
const DISSIPATED: [usize; 2] = [5, 6];
const WALLS: usize = 7;
const BOX: usize = 8;
const BROUGHT: usize = 9;
const LEFT_OVER: usize = 10;

type Columns = [f64; 11];

fn columns(row: &HashMap<String, f64>) -> Columns {
    std::array::from_fn(|k| row[&format!("c_balance[{}]", k + 1)])
}

fn all_columns(outcome: &Outcome) -> Vec<Columns> {
    outcome.thermo().iter().map(columns).collect()
}

fn dissipated(c: &Columns) -> f64 {
    DISSIPATED.iter().map(|k| c[*k]).sum()
}

fn energy(c: &Columns) -> f64 {
    KINETIC.iter().chain(&ELASTIC).map(|k| c[*k]).sum::<f64>() + c[GRAVITY]
}

/// The largest departure from closure, over what is dissipated in the end.
fn left_over(all: &[Columns]) -> f64 {
    let most = all.iter().map(|c| c[LEFT_OVER].abs()).fold(0.0, f64::max);
    most / dissipated(all.last().unwrap())
}

/// Grains thrown into a box whose floor shakes and whose lid turns.
fn shaken(steps: u64) -> Deck {
    shaken_with(LAW, steps)
}

fn shaken_with(law: &str, steps: u64) -> Deck {
    Deck {
        fixes: vec![
            "compute balance all energy/ellipsoid".into(),
            "compute moving all ke".into(),
            "compute turning all erotate/asphere".into(),
            "compute energy all pair gran/ellipsoid".into(),
            "fix gravity all gravity 9.81 vector 0 0 -1".into(),
            format!("fix x_walls all wall/gran/ellipsoid {law} xplane 0 0.034"),
            format!("fix y_walls all wall/gran/ellipsoid {law} yplane 0 0.034"),
            format!("fix floor all wall/gran/ellipsoid {law} zplane 0 NULL wiggle z 0.0005 0.01"),
            format!(
                "fix lid all wall/gran/ellipsoid {law} zplane NULL 0.036 rotate 0.017 0.017 0.036 0 0 1 0.05"
            ),
        ],
        time_step: 2e-5,
        steps,
        thermo_every: steps / 4,
        thermo_columns: "step c_balance[*] c_moving c_turning c_energy[*] f_x_walls[*] f_y_walls[*] f_floor[*] f_lid[*] f_gravity".into(),
        skin: 1e-3,
        ..Deck::new(law)
    }
}

fn same(a: &Columns, b: &Columns, tolerance: f64, what: &str) {
    let scale = energy(a).abs() + dissipated(a);
    let apart = (0..LEFT_OVER)
        .map(|k| (a[k] - b[k]).abs() / scale)
        .fold(0.0, f64::max);
    println!("{what}: columns apart by {apart:.1e} of the energy");
    assert!(apart < tolerance, "{what}: {a:?}, {b:?}");
}

#[test]
fn both_versions_a_shaken_packing_in_one_compute() {
    let engine = Engine::from_environment();
    const STEPS: u64 = 3000;
    let one = run(&engine, "balance_shaken", &cloud(), &shaken(STEPS), 1);
    let all = all_columns(&one);
    let last = all.last().unwrap();
    println!(
        "walls did {:.2e} J, {:.2e} J dissipated ({:.2e} by friction), left over {:.1e} of that at most",
        last[WALLS],
        dissipated(last),
        last[DISSIPATED[1]],
        left_over(&all)
    );
    assert!(last[WALLS] > 0.05 * dissipated(last));
    assert!(DISSIPATED.iter().all(|k| last[*k] > 0.1 * dissipated(last)));
    assert!(left_over(&all) < 1e-3);

    // what the outputs of the pair style and of each wall say
    for row in one.thermo() {
        let found = columns(&row);
        let walls = |k: usize| -> f64 {
            ["x_walls", "y_walls", "floor", "lid"]
                .iter()
                .map(|wall| row[&format!("f_{wall}[{k}]")])
                .sum()
        };
        let expected = [
            row["c_moving"],
            row["c_turning"],
            row["c_energy[1]"] + walls(7),
            row["c_energy[2]"] + walls(8),
            row["f_gravity"],
            row["c_energy[5]"] + walls(11),
            row["c_energy[6]"] + walls(12),
            walls(13),
            0.0,
            0.0,
            found[LEFT_OVER],
        ];
        same(&expected, &found, 1e-13, "gathered");
    }
}

/// What resists rolling and twisting stores and dissipates too, between grains and at walls that move and turn.
#[test]
fn both_versions_rolling_and_twisting_in_the_balance() {
    let engine = Engine::from_environment();
    for (name, words) in [
        ("rolling", "rolling sds 2e3 0.02 0.2 twisting marshall"),
        ("lubkin", "displacement hysteretic twisting lubkin"),
    ] {
        let deck = shaken_with(&format!("{LAW} {words}"), 3000);
        let one = run(&engine, &format!("balance_{name}"), &cloud(), &deck, 1);
        let all = all_columns(&one);
        println!(
            "{words}: left over {:.1e} of what is dissipated",
            left_over(&all)
        );
        assert!(left_over(&all) < 1e-3);
        let four = run(&engine, &format!("balance_{name}_4"), &cloud(), &deck, 4);
        let (one, four) = (all.last().unwrap(), &all_columns(&four));
        same(one, four.last().unwrap(), 1e-8, "4 ranks");
    }
}

#[test]
fn both_versions_the_balance_goes_on_over_ranks_runs_and_restarts() {
    let engine = Engine::from_environment();
    const STEPS: u64 = 800;
    let one = run(&engine, "balance_1", &cloud(), &shaken(STEPS), 1);
    let one = *all_columns(&one).last().unwrap();
    assert!(one[WALLS].abs() > 0.0 && DISSIPATED.iter().all(|k| one[*k] > 0.0));
    let four = run(&engine, "balance_4", &cloud(), &shaken(STEPS), 4);
    same(&one, all_columns(&four).last().unwrap(), 1e-9, "4 ranks");

    // in two runs, the second of them again from a restart file
    let mut split = shaken(STEPS);
    split.runs = vec![
        format!("run {}", STEPS / 2),
        "write_restart middle.restart".into(),
        format!("run {}", STEPS / 2),
    ];
    let split = run(&engine, "balance_split", &cloud(), &split, 2);
    let in_two = *all_columns(&split).last().unwrap();
    let restarted = Deck {
        pair: vec![],
        source: vec!["read_restart middle.restart".into()],
        steps: STEPS / 2,
        ..shaken(STEPS)
    };
    let restarted = attempt_in(&engine, split.directory, &cloud(), &restarted, 4);
    assert!(restarted.success, "{}", last_lines(&restarted.output));
    let after = *all_columns(&restarted).last().unwrap();
    same(&in_two, &after, 1e-9, "restarted");
    let of_dissipated = (after[LEFT_OVER] - in_two[LEFT_OVER]).abs() / dissipated(&in_two);
    assert!(of_dissipated < 1e-9, "{of_dissipated}");
}

/// What a deck does between two runs is not a fault of the balance.
#[test]
fn both_versions_changes_between_runs_are_no_part_of_the_balance() {
    let engine = Engine::from_environment();
    const STEPS: u64 = 1000;
    let mut deck = shaken(STEPS);
    deck.thermo_columns = "step c_balance[*]".into();
    deck.runs = [
        format!("run {STEPS}"),
        "velocity all set 0 0 0\nunfix lid\ngroup some id 1:8\ndelete_atoms group some compress no".into(),
        format!("run {STEPS}"),
        format!("unfix floor\nfix ground all wall/gran/ellipsoid {LAW} zplane 0 NULL"),
        format!("pair_coeff * * hertz 3e6 0.3 damping restitution 0.7 tangential mindlin 0.5\nrun {STEPS} pre yes post no"),
        format!("run {STEPS} pre no"),
    ]
    .to_vec();
    let all = all_columns(&run(&engine, "balance_changes", &cloud(), &deck, 1));
    println!("left over {:.1e} of what is dissipated", left_over(&all));
    assert!(left_over(&all) < 1e-3);
    // dissipated energies and the work of walls that are gone stay in the sums
    for pair in all.windows(2) {
        assert!(pair[1][DISSIPATED[0]] >= pair[0][DISSIPATED[0]]);
    }
    assert!(all.last().unwrap()[WALLS].abs() > 0.0);
}

/// Grains poured in, and grains that fall off a table and leave through the open boundary below it.
#[test]
fn both_versions_grains_that_come_and_go_bring_and_take_their_energy() {
    let engine = Engine::from_environment();
    for order in ["balance first", "pour first"] {
        let pour = "region top block 0.008 0.026 0.008 0.026 0.03 0.06\nfix pour all pour/ellipsoid 60 1 4711 region top shape one 0.006 0.004 0.004 dens 2500 2500 vel 0 0 0 0 -0.5";
        let gravity = "fix gravity all gravity 9.81 vector 0 0 -1";
        let balance = "compute balance all energy/ellipsoid";
        // a round table: what falls off it leaves the box below
        let table = format!("region table cylinder z 0.017 0.017 0.01 -0.02 0 side out units box\nfix table all wall/gran/ellipsoid {LAW} region table");
        let fixes = if order == "pour first" {
            [gravity, pour, &table, balance]
        } else {
            [balance, gravity, pour, &table]
        };
        let deck = pouring(&fixes, 1000);
        let scene = one_above_an_open_end([0.017, 0.017, 0.0045]);
        let outcome = run(&engine, "balance_pour", &scene, &deck, 1);
        let rows = outcome.thermo();
        let all = all_columns(&outcome);
        let last = rows.last().unwrap();
        println!(
            "{order}: {} poured, {} there; brought {:.2e} J, {:.2e} J dissipated, left over {:.1e} of that at most",
            last["f_pour"],
            last["Atoms"],
            columns(last)[BROUGHT],
            dissipated(all.last().unwrap()),
            left_over(&all)
        );
        assert!(last["f_pour"] > 20.0 && last["Atoms"] < last["f_pour"]);
        assert!(columns(last)[BROUGHT] > dissipated(all.last().unwrap()));
        assert!(left_over(&all) < 1e-3);
    }
}

/// Grains that come from a fix and leave the box below.
fn pouring(fixes: &[&str], thermo_every: u64) -> Deck {
    Deck {
        fixes: fixes.iter().map(|line| line.to_string()).collect(),
        time_step: 2e-5,
        steps: 8000,
        thermo_every,
        thermo_columns: "step atoms f_pour c_balance[*]".into(),
        skin: 1e-3,
        runs: vec!["thermo_modify lost ignore\nrun 8000".into()],
        ..Deck::new(LAW)
    }
}

/// One grain of the cloud, in a box that goes on below.
fn one_above_an_open_end(position: [f64; 3]) -> Scene {
    let mut scene = cloud();
    scene.grains.truncate(1);
    scene.grains[0].position = position;
    scene.low[2] = -0.02;
    scene
}

/// Grains that are inserted, fall freely and leave the box below: velocity Verlet keeps their energy to rounding, and so does the balance.
#[test]
fn both_versions_grains_that_only_fall_leave_nothing_over() {
    let engine = Engine::from_environment();
    let pour = "region top block 0.008 0.026 0.008 0.026 0.03 0.06\nfix pour all pour/ellipsoid 40 1 4711 region top shape one 0.006 0.004 0.004 dens 2500 2500 vel 0 0 0 0 -0.5";
    let gravity = "fix gravity all gravity 9.81 vector 0 0 -1";
    let deck = pouring(
        &[gravity, pour, "compute balance all energy/ellipsoid"],
        100,
    );
    // out of the way of the others
    let mut scene = one_above_an_open_end([0.003, 0.003, 0.0045]);
    // the integrator of this deck turns a grain with an error
    scene.grains[0].angular_momentum = [0.0; 3];
    let outcome = run(&engine, "balance_fall", &scene, &deck, 1);
    let rows = outcome.thermo();
    let last = rows.last().unwrap();
    let all = all_columns(&outcome);
    let largest = |column: usize| all.iter().map(|c| c[column].abs()).fold(0.0, f64::max);
    let (brought, left) = (largest(BROUGHT), largest(LEFT_OVER));
    println!("brought {brought:.2e} J at most, left over {left:.1e} J");
    assert!(last["f_pour"] > 20.0 && last["Atoms"] < last["f_pour"]);
    assert_eq!(dissipated(all.last().unwrap()), 0.0);
    assert!(left < 1e-11 * brought);
}

/// 512 grains on a lattice in a periodic box that shrinks, then shears.
fn sheared(rotated: bool, time_step: f64, squeeze: u64, shear: u64) -> (Scene, Deck) {
    let cell = 6.8e-3;
    let edge = 8.0 * cell;
    let narrow = 0.041;
    let rate = 20.0;
    let mut random = Random(11);
    let mut grains = vec![];
    for k in 0..512 {
        let place = [k % 8, k / 8 % 8, k / 64].map(|c| c as f64 + 0.5);
        let jitter = scale(2e-4, random.direction());
        let position: [f64; 3] = std::array::from_fn(|k| cell * place[k] + jitter[k]);
        let mut grain = Grain {
            density: 2500.0,
            ..Grain::new([3e-3, 2e-3, 2e-3], position).turned(random.quaternion())
        }
        .moving(scale(0.02, random.direction()));
        if rotated {
            // by a third of a turn about the diagonal: x to y, y to z, z to x
            let turn = |v: [f64; 3]| [v[2], v[0], v[1]];
            grain.position = turn(grain.position);
            grain.velocity = turn(grain.velocity);
            grain.quaternion = compose([0.5; 4], grain.quaternion);
        }
        grains.push(grain);
    }
    let scene = Scene::periodic([0.0; 3], [edge; 3], grains);
    // the tilt, the velocity that shears and the coordinate with which it grows
    let (tilt, along, across) = if rotated {
        ("yz", "vy", "z")
    } else {
        ("xy", "vx", "y")
    };
    let (stress, spin) = if rotated { (6, 'x') } else { (4, 'z') };
    let deck = Deck {
        fixes: vec![
            "change_box all triclinic".into(),
            "compute balance all energy/ellipsoid".into(),
            "compute virial all pressure NULL pair".into(),
            "compute flow all temp/deform".into(),
            format!("compute spin all property/atom angmom{spin}"),
            "compute spins all reduce sum c_spin".into(),
            format!("variable power equal -{rate}*(vol*c_virial[{stress}]+c_flow[{stress}])"),
        ],
        runs: vec![
            format!("fix squeeze all deform 1 x final 0 {narrow} y final 0 {narrow} z final 0 {narrow} remap v\nrun {squeeze}\nunfix squeeze"),
            format!("velocity all ramp {along} 0 {} {across} 0 {narrow} sum yes", rate * narrow),
            format!("fix shear all deform 1 {tilt} erate {rate} remap v"),
            format!("fix power all ave/time 1 {shear} {shear} v_power"),
            format!("thermo_style custom step c_balance[*] c_spins f_power v_power\nthermo_modify norm no format float %.17g\nrun {shear}"),
        ],
        thermo_columns: "step c_balance[*] c_spins".into(),
        thermo_every: squeeze.min(shear),
        time_step,
        skin: 1e-3,
        ..Deck::new(LAW)
    };
    (scene, deck)
}

/// The box does the work of the stress: it is stored or dissipated.
#[test]
fn both_versions_the_stress_of_simple_shear_equals_the_power_balance() {
    let engine = Engine::from_environment();
    const SHEAR: u64 = 2500;
    let time_step = 2e-5;
    let (scene, deck) = sheared(false, time_step, SHEAR, SHEAR);
    let outcome = run(&engine, "balance_sheared", &scene, &deck, 1);
    let rows = outcome.thermo();
    let all = all_columns(&outcome);
    let sheared: Vec<_> = rows.iter().filter(|r| r.contains_key("f_power")).collect();
    let (at_first, at_last) = (sheared[0], sheared[sheared.len() - 1]);
    assert_eq!(at_last["Step"] - at_first["Step"], SHEAR as f64);
    let (first, last) = (&columns(at_first), &columns(at_last));
    // LAMMPS' stress has d_x F_y; the power is that of d_y F_x, and the torque is what is between them
    let spun = 20.0 * (at_last["c_spins"] - at_first["c_spins"]);
    let ends = 0.5 * time_step * (at_first["v_power"] - at_last["v_power"]);
    let work = at_last["f_power"] * SHEAR as f64 * time_step + ends - spun;
    let used = energy(last) - energy(first) + dissipated(last) - dissipated(first);
    println!(
        "stress did {work:.5e} J, {used:.5e} J were stored or dissipated: apart by {:.1e}; by the compute {:.5e} J; left over {:.1e} of what is dissipated",
        work / used - 1.0,
        last[BOX] - first[BOX],
        left_over(&all)
    );
    assert!(dissipated(last) - dissipated(first) > 0.5 * used);
    assert!((work / used - 1.0).abs() < 1e-3);
    assert!(left_over(&all) < 1e-3);
}

#[test]
fn both_versions_a_rotated_shear_is_the_same() {
    let engine = Engine::from_environment();
    let last = |rotated: bool, ranks: usize| {
        let (scene, deck) = sheared(rotated, 2e-5, 1500, 300);
        let outcome = run(&engine, "balance_rotated", &scene, &deck, ranks);
        *all_columns(&outcome).last().unwrap()
    };
    let (as_is, rotated) = (last(false, 1), last(true, 2));
    assert!(as_is[ELASTIC[1]] > 0.0 && as_is[BOX] > 0.0);
    same(&as_is, &rotated, 1e-7, "rotated");
}

#[test]
fn both_versions_wrong_words_of_the_compute() {
    let engine = Engine::from_environment();
    let nph = "unfix move\nfix move all nph/asphere x 0 0 1";
    let periodic = "ppp";
    for (commands, boundary, pair, expected) in [
        ("group some id 1\ncompute balance some energy/ellipsoid", "fff", "", "group some must be all"),
        ("compute balance all energy/ellipsoid pe", "fff", "", "unexpected word 'pe'"),
        ("compute balance all energy/ellipsoid", "fff", "pair_style zero 0.01\npair_coeff * *", "the pair style is 'zero'"),
        ("compute balance all energy/ellipsoid", "fff", "pair_style hybrid/scaled 0.5 gran/ellipsoid\npair_coeff * * gran/ellipsoid hertz 1e7 0.3", "hybrid/scaled"),
        ("compute balance all energy/ellipsoid\nfix press all press/berendsen x 0 0 1", periodic, "", "fix press of style press/berendsen changes the box"),
        (&format!("compute balance all energy/ellipsoid\n{nph}"), periodic, "", "fix move of style nph/asphere changes the box"),
        ("compute balance all energy/ellipsoid\nfix deform all deform 1 x erate 1 remap x", periodic, "", "needs 'remap v'"),
        ("compute balance all energy/ellipsoid\nfix deform all deform 1 x erate 1 remap v\nfix pull all gravity 1 vector 0 0 -1", periodic, "", "fix pull of style gravity does not move along"),
        ("compute balance all energy/ellipsoid\nfix floor all wall/gran/ellipsoid hertz 1e7 0.3 zplane 0 NULL\nfix deform all deform 1 x erate 1 remap v", "ppf", "", "fix floor of style wall/gran/ellipsoid does not move along"),
        ("compute balance all energy/ellipsoid\nunfix balance_ENERGY_BALANCE", "fff", "", "define the compute again"),
    ] {
        let mut scene = cloud();
        scene.boundary = boundary.chars().map(String::from).collect::<Vec<_>>().join(" ");
        let mut deck = Deck {
            fixes: vec![commands.into()],
            skin: 1e-3,
            time_step: 1e-6,
            steps: 1,
            ..Deck::new(LAW)
        };
        if !pair.is_empty() {
            deck.pair = vec![pair.into()];
        }
        let outcome = attempt(&engine, "balance_misuse", &scene, &deck, 1);
        assert!(!outcome.success, "{commands}");
        assert!(
            outcome.output.contains(expected) && outcome.output.contains("ERROR: Compute energy/ellipsoid balance"),
            "{commands}: {}",
            last_lines(&outcome.output)
        );
    }
    let mut off = Deck {
        fixes: vec![
            "compute balance all energy/ellipsoid\nfix deform all deform 1 x erate 1 remap v"
                .into(),
        ],
        newton: false,
        skin: 1e-3,
        ..Deck::new(LAW)
    };
    off.time_step = 1e-6;
    let mut scene = cloud();
    scene.boundary = "p p p".into();
    let outcome = attempt(&engine, "balance_newton", &scene, &off, 1);
    assert!(!outcome.success && outcome.output.contains("newton on"));
}

#[test]
fn both_versions_without_the_compute_a_restart_file_with_it_is_read() {
    let engine = Engine::from_environment();
    let mut first = shaken(200);
    first.runs = vec!["run 200\nwrite_restart kept.restart".into()];
    let first = run(&engine, "balance_kept", &cloud(), &first, 1);
    assert!(fs::metadata(first.directory.join("kept.restart")).is_ok());
    let second = Deck {
        fixes: vec![],
        pair: vec![],
        thermo_columns: "step pe".into(),
        source: vec!["read_restart kept.restart".into()],
        ..shaken(200)
    };
    let second = attempt_in(&engine, first.directory, &cloud(), &second, 1);
    assert!(second.success, "{}", last_lines(&second.output));
}
