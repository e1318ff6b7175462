// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a servo wall hold the force that it is given, whatever the material, the time step, the ranks and a restart?

use std::fs;

use crate::harness::{
    attempt_in, fresh_directory, largest_difference, run, Deck, Engine, Grain, Scene,
};
use crate::mesh_walls::{binary, square};
use crate::shapes::Random;

const LAW: &str = "nfd 3e6 0.3 200 200 tangential tfd 0.4";

/// Forty grains in a box from -0.018 to 0.018 in x and y, above z = 0.
fn packing() -> Scene {
    let mut random = Random(23);
    let grains = (0..48)
        .map(|k| {
            let place = [k % 4, k / 4 % 4, k / 16].map(f64::from);
            Grain {
                density: 2500.0,
                ..Grain::new(
                    [4e-3, 2.5e-3, 2.5e-3],
                    [
                        -0.0132 + 8.8e-3 * place[0],
                        -0.0132 + 8.8e-3 * place[1],
                        0.0045 + 8.8e-3 * place[2],
                    ],
                )
            }
            .turned(random.quaternion())
        })
        .collect();
    Scene::open(0.05, grains)
}

/// The box, and a lid with these words.
fn boxed(lid: &str, steps: u64) -> Deck {
    Deck {
        fixes: vec![
            format!("fix x all wall/gran/ellipsoid {LAW} xplane -0.018 0.018"),
            format!("fix y all wall/gran/ellipsoid {LAW} yplane -0.018 0.018"),
            format!("fix floor all wall/gran/ellipsoid {LAW} zplane 0 NULL"),
            format!("fix lid all wall/gran/ellipsoid {LAW} {lid}"),
        ],
        time_step: 2e-5,
        steps,
        skin: 1e-3,
        thermo_every: 100,
        thermo_columns: "step f_lid[6] f_lid[16] f_lid[23] f_lid[26] f_lid[27] f_lid[28]".into(),
        ..Deck::new(LAW)
    }
}

/// One ball between a floor and a lid that presses: the force is the target, whatever the stiffness, the viscosity and the time
/// step, without a word about the gain, and it comes to it without hammering.
#[test]
fn both_versions_a_lid_presses_one_ball() {
    let engine = Engine::from_environment();
    let force = 0.5;
    for (law, time_step) in [
        ("hertz 1e5 0.3 damping restitution 0.5", 1e-5),
        ("hertz 1e9 0.3 damping restitution 0.5", 1e-7),
        ("nfd 3e6 0.3 20 20", 2e-5),
        ("nfd 3e6 0.3 3000 3000", 1e-5),
        ("lsd 1e4 1", 1e-5),
    ] {
        let ball = Grain {
            density: 2500.0,
            ..Grain::sphere(5e-3, [0.0, 0.0, 5e-3])
        };
        // ten times as long as the lid takes to its place, and as the ball swings
        let steps = 90_000;
        let deck = Deck {
            fixes: vec![
                format!("fix floor all wall/gran/ellipsoid {law} zplane 0 NULL"),
                format!("fix lid all wall/gran/ellipsoid {law} zplane NULL 0.01001 servo 0 0 -1 {force} 0.1"),
            ],
            time_step,
            steps,
            skin: 1e-3,
            thermo_every: 10,
            thermo_columns: "step f_lid[23] f_lid[27] f_lid[28]".into(),
            ..Deck::new(law)
        };
        let outcome = run(
            &engine,
            "servo_ball",
            &Scene::open(0.02, vec![ball]),
            &deck,
            1,
        );
        let forces: Vec<f64> = outcome.thermo().iter().map(|r| r["f_lid[27]"]).collect();
        let last = forces[forces.len() - 1];
        let highest = forces.iter().copied().fold(0.0, f64::max);
        println!(
            "{law}: {last} N of {force} N, highest {highest:.3} N, lid at {:.3e} m",
            outcome.thermo().last().unwrap()["f_lid[23]"]
        );
        assert!((last / force - 1.0).abs() < 1e-4, "{law}: {last}");
        assert!(highest < 2.0 * force, "{law}: {highest}");
    }
}

/// A deck's own servo: the velocity of a wall, or the target of another, by a variable that reads the force on that wall.
#[test]
fn both_versions_a_variable_knows_the_force_on_its_own_wall() {
    let engine = Engine::from_environment();
    let law = "lsd 1e4 1";
    for (name, motion, expected) in [
        ("velocity", "velocity 0 0 v_speed", 0.5),
        // The target is a third of the force and two thirds of 0.6.
        ("target", "servo 0 0 -1 v_target 0.01", 0.6),
    ] {
        let ball = Grain {
            density: 2500.0,
            ..Grain::sphere(5e-3, [0.0, 0.0, 5e-3])
        };
        let deck = Deck {
            fixes: vec![
                "variable speed equal -0.01+0.02*f_lid[16]".into(),
                "variable target equal 0.4+f_lid[16]/3".into(),
                format!("fix floor all wall/gran/ellipsoid {law} zplane 0 NULL"),
                format!("fix lid all wall/gran/ellipsoid {law} zplane NULL 0.01001 {motion}"),
            ],
            time_step: 1e-5,
            steps: 20_000,
            skin: 1e-3,
            thermo_every: 100,
            thermo_columns: "step f_floor[16] f_lid[16] f_lid[10] f_lid[23]".into(),
            ..Deck::new(law)
        };
        let scene = Scene::open(0.02, vec![ball]);
        let one = run(&engine, "own_force", &scene, &deck, 1);
        let last = one.thermo().last().unwrap().clone();
        println!("{name}: {last:?}");
        assert!(
            (last["f_lid[16]"] / expected - 1.0).abs() < 1e-3,
            "{name}: {last:?}"
        );
        assert!((last["f_floor[16]"] / -expected - 1.0).abs() < 1e-3);
        assert_eq!(last["f_lid[10]"], 1.0);
        let two = run(&engine, "own_force", &scene, &deck, 2);
        assert!(largest_difference(one.last(), two.last()).0 < 1e-9);
    }
}

/// A plane, a stress by an area, variables and a mesh press a packing: each holds its force to 1 %.
#[test]
fn both_versions_lids_of_all_kinds_hold_their_force() {
    let engine = Engine::from_environment();
    let area = 0.036 * 0.036;
    let force = 2000.0 * area;
    let lid: Vec<_> = square(2, 0.0, 3)
        .iter()
        .map(|t| t.map(|[x, y, z]| [0.02 * x, 0.02 * y, z]))
        .collect();
    for (name, words, before) in [
        (
            "force",
            format!("zplane NULL 0.03 servo 0 0 -1 {force} 0.2"),
            vec![],
        ),
        (
            "stress",
            format!("zplane NULL 0.03 servo 0 0 -2 2000 0.2 area {area}"),
            vec![],
        ),
        (
            "variables",
            "zplane NULL 0.03 servo 0 0 -1 v_stress 0.2 area v_area".into(),
            vec![
                "variable stress equal ramp(2000,2000)+0*c_moving".to_string(),
                format!("variable area equal {area}+0*f_floor[3]"),
                "compute moving all ke".into(),
            ],
        ),
        (
            "mesh",
            format!("mesh lid.stl move 0 0 0.03 servo 0 0 -1 {force} 0.2"),
            vec![],
        ),
    ] {
        let mut deck = boxed(&words, 10_000);
        deck.fixes.extend(before);
        let directory = fresh_directory(&format!("servo_{name}"));
        fs::write(directory.join("lid.stl"), binary(&lid)).unwrap();
        let outcome = attempt_in(&engine, directory, &packing(), &deck, 1).succeeded();
        let rows = outcome.thermo();
        let settled = &rows[rows.len() - 20..];
        let off = settled
            .iter()
            .map(|r| (r["f_lid[27]"] / force - 1.0).abs())
            .fold(0.0, f64::max);
        let last = rows.last().unwrap();
        println!(
            "{name}: off by {off:.1e} in the last fifth, lid at {:.4e} m",
            last["f_lid[23]"]
        );
        assert!(off < 0.01, "{name}");
        assert!((last["f_lid[28]"] / force - 1.0).abs() < 1e-12);
        assert_eq!(last["f_lid[16]"], last["f_lid[27]"], "the force of the fix");
        assert!(last["f_lid[23]"] < -1e-4, "{name}: nothing was pressed");
    }
}

#[test]
fn both_versions_ranks_and_restarts_change_nothing() {
    let engine = Engine::from_environment();
    let lid = "zplane NULL 0.027 servo 0 0 -1 0.1 0.2";
    let steps = 1600;
    let mut whole = boxed(lid, steps);
    whole.runs = vec![
        format!("run {}", steps / 2),
        "write_restart middle.restart".into(),
        format!("run {}", steps / 2),
    ];
    let directory = fresh_directory("servo_restart");
    let scene = packing();
    let one = attempt_in(&engine, directory.clone(), &scene, &whole, 1).succeeded();
    let lid_of = |rows: &[std::collections::HashMap<String, f64>]| {
        let row = rows.last().unwrap();
        [row["f_lid[23]"], row["f_lid[26]"], row["f_lid[27]"]]
    };
    let wanted = lid_of(&one.thermo());
    assert!(
        wanted[1].abs() < 0.2,
        "the lid is still on its way to the grains"
    );
    let mut again = boxed(lid, steps / 2);
    again.source = vec!["read_restart middle.restart".into()];
    again.pair.clear();
    let again = attempt_in(&engine, directory, &scene, &again, 1).succeeded();
    let four = run(&engine, "servo_ranks", &scene, &whole, 4);
    for (name, outcome) in [("restart", &again), ("four ranks", &four)] {
        let (position, velocity) = largest_difference(outcome.last(), one.last());
        let got = lid_of(&outcome.thermo());
        println!(
            "{name}: grains off by {position:.1e} m, {velocity:.1e} m/s; lid {got:?} for {wanted:?}"
        );
        assert!(position < 1e-9 && velocity < 1e-6, "{name}");
        assert!((got[0] - wanted[0]).abs() < 1e-9, "{name}");
        assert!((got[2] / wanted[2] - 1.0).abs() < 1e-4, "{name}");
    }
}

/// The work of a servo wall closes the balance of energies.
#[test]
fn both_versions_the_work_of_a_servo_wall_is_in_the_balance() {
    let engine = Engine::from_environment();
    let off = |time_step: f64| {
        let mut deck = boxed(
            "zplane NULL 0.027 servo 0 0 -1 2.5 0.2",
            (0.06 / time_step) as u64,
        );
        deck.time_step = time_step;
        deck.thermo_every = deck.steps / 20;
        deck.fixes.extend([
            "compute moving all ke".to_string(),
            "compute turning all erotate/asphere".into(),
            "compute energy all pair gran/ellipsoid".into(),
            "variable lost equal c_energy[3]+f_x[9]+f_y[9]+f_floor[9]+f_lid[9]".into(),
            "variable sum equal c_moving+c_turning+c_energy[1]+c_energy[2]+f_x+f_y+f_floor+f_lid+v_lost-f_lid[13]".into(),
        ]);
        deck.thermo_columns = "step v_sum v_lost f_lid[13]".into();
        let outcome = run(&engine, "servo_energy", &packing(), &deck, 1);
        let rows = outcome.thermo();
        let last = rows.last().unwrap();
        let off = (last["v_sum"] - rows[0]["v_sum"]) / last["v_lost"];
        println!(
            "step {time_step:e}: work {:.3e} J, dissipated {:.3e} J, off by {off:+.1e} of it",
            last["f_lid[13]"], last["v_lost"]
        );
        off.abs()
    };
    assert!(off(1e-5) < 1e-3);
}
