// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do scenes of LAMMPS' granular test suite, and the spinning spheres of Chung and Ooi, made by the decks of validation/single_grains,
//! end as their closed forms say?

use std::f64::consts::PI;
use std::path::Path;

use crate::harness::{execute, fresh_directory, last_lines, Engine};

/// Runs a deck of validation/single_grains; what it printed, and the last frame of its dump, if it writes one.
fn run_deck(name: &str, deck: &str, variables: &[(&str, String)]) -> (String, Vec<[f64; 12]>) {
    let engine = Engine::from_environment();
    let mut text = format!("variable plugin index {}\n", engine.plugin.display());
    for (variable, value) in variables {
        text += &format!("variable {variable} index \"{value}\"\n");
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("validation/single_grains");
    text += &std::fs::read_to_string(folder.join(deck)).unwrap();
    let directory = fresh_directory(name);
    let (success, output) = execute(&engine, &directory, &text, 1);
    assert!(success, "{}", last_lines(&output));
    let dump = std::fs::read_to_string(directory.join("grains.dump")).unwrap_or_default();
    let last = dump.rsplit("ITEM: ATOMS").next().unwrap_or_default();
    let grains = last
        .lines()
        .skip(1)
        .map(|line| {
            let numbers: Vec<f64> = line
                .split_whitespace()
                .map(|word| word.parse().unwrap())
                .collect();
            numbers.try_into().expect("twelve numbers a grain")
        })
        .collect();
    (output, grains)
}

/// Grains at the end of `few_grains.lmp`: position, velocity, force, angular momentum.
fn few_grains(name: &str, variables: &[(&str, String)]) -> Vec<[f64; 12]> {
    run_deck(name, "few_grains.lmp", variables).1
}

fn word(text: &str) -> String {
    text.to_string()
}

/// A linear contact of this mass and stiffness, whose collisions end with this restitution.
fn linear(mass: f64, stiffness: f64, restitution: f64) -> String {
    let l = restitution.ln();
    let damping = -2.0 * l * (mass * stiffness).sqrt() / PI.hypot(l);
    format!("lsd {stiffness:e} {damping:e}")
}

const MASS: f64 = PI / 6.0;
const INERTIA: f64 = 0.1 * MASS;

/// dem03: equal ones, pressed symmetrically but for their weight, swing about their rest in two modes: apart, and together.
#[test]
fn two_spheres_pressed_between_planes_are_a_linear_system() {
    let (k, g, d, ceiling) = (1e3, 9.81, 1e-3, 1.8e-3);
    let mass = 1e4 * PI / 6.0 * d * d * d;
    let time: f64 = 2e-3;
    let grains = few_grains(
        "stack",
        &[
            ("law", format!("lsd {k} 0")),
            ("planes", word("1")),
            ("wall", format!("zplane 0 {ceiling}")),
            ("wide", word("0.005")),
            ("gravity", g.to_string()),
            ("grains", word("2")),
            ("place", word("0 0 0.45e-3")),
            ("place2", word("0 0 1.35e-3")),
            ("axes", format!("{d} {d} {d}")),
            ("axes2", format!("{d} {d} {d}")),
            ("density", word("1e4")),
            ("density2", word("1e4")),
            ("step", word("2.5e-7")),
            ("steps", word("8000")),
            ("every", word("8000")),
        ],
    );
    // The square of the frequency is k/m together and 3 k/m apart; without weight they rest (ceiling + d)/6 from the middle.
    let together = -g * mass / k * (1.0 - ((k / mass).sqrt() * time).cos());
    let rest = (ceiling + d) / 6.0;
    let apart = rest + (0.45e-3 - rest) * ((3.0 * k / mass).sqrt() * time).cos();
    for (grain, side) in grains.iter().zip([-1.0, 1.0]) {
        let wanted = 0.5 * ceiling + together + side * apart;
        println!("{:.12e}, wanted {wanted:.12e}", grain[2]);
        // Of the overlap in the beginning; a step four times as long is off by 1.3e-4.
        assert!((grain[2] - wanted).abs() < 5e-5 * 1e-4, "{grain:?}");
    }
}

/// dem05 and dem09: gross sliding, by tangential velocity and by spin.
#[test]
fn impacts_that_slide_end_as_the_impulse_says() {
    let (friction, restitution) = (0.4, 0.8);
    let slid = friction * (1.0 + restitution);
    for (name, along, spin) in [("oblique", 8.0, 0.0), ("spinning", 0.0, 20.0)] {
        let grains = few_grains(
            name,
            &[
                (
                    "law",
                    format!("hertz 1e8 0.3 damping restitution {restitution} tangential mindlin {friction}"),
                ),
                ("planes", word("1")),
                ("velocity", format!("{along} 0 -1")),
                ("spin", format!("0 {} 0", INERTIA * spin)),
                ("step", word("2e-6")),
                ("steps", word("8000")),
                ("every", word("8000")),
            ],
        );
        let [.., vx, _, vz, fx, fy, fz, _, ly, _] = grains[0];
        assert_eq!([fx, fy, fz], [0.0; 3], "still in contact");
        let turned = ly / INERTIA;
        println!("{name}: {vx:.6} along, {vz:.6} up, spin {turned:.6}");
        // A spin towards x drives the sphere along x; a velocity along x is braked.
        let sign = if spin > 0.0 { 1.0 } else { -1.0 };
        assert!((vz - restitution).abs() < 1e-3 * restitution);
        assert!((vx - (along + sign * slid)).abs() < 0.01 * slid);
        assert!((turned - (spin - sign * 5.0 * slid)).abs() < 0.01 * 5.0 * slid);
    }
}

/// dem07.
#[test]
fn rolling_resistance_stops_a_spin_at_a_constant_rate() {
    let (gravity, resistance, k) = (10.0, 0.1, 1e4);
    let grains = few_grains(
        "rolling",
        &[
            (
                "law",
                format!("{} rolling sds 1000 0 {resistance}", linear(MASS, k, 0.5)),
            ),
            ("planes", word("1")),
            ("place", format!("0 0 {:e}", 0.5 - MASS * gravity / k)),
            ("spin", format!("0 {} 0", INERTIA * 5.0)),
            ("gravity", gravity.to_string()),
            ("step", word("2e-4")),
            ("steps", word("2000")),
            ("every", word("2000")),
        ],
    );
    let turned = grains[0][10] / INERTIA;
    println!("{turned:.6}, wanted 3");
    // The spring of rolling takes mu_r m g/k of the way first.
    assert!((turned - 3.0).abs() < 1e-3 * 5.0);
}

/// Tests 6 and 8 of Chung and Ooi: the spin makes the point move at ten times the impact speed.
#[test]
fn spinning_spheres_rebound_from_a_plane_and_from_a_large_sphere() {
    let (friction, restitution, radius, down, spin) = (0.4, 0.5, 0.1, 0.2, -20.0);
    for partner in ["plane", "large"] {
        let (output, _) = run_deck(
            partner,
            "impact.lmp",
            &[
                ("partner", word(partner)),
                (
                    "law",
                    format!("hertz 7e10 0.33 damping restitution {restitution} tangential tfd {friction}"),
                ),
                ("down", down.to_string()),
                ("spin", spin.to_string()),
                ("step", word("1e-6")),
                ("steps", word("2500")),
            ],
        );
        let last = output
            .lines()
            .take_while(|line| !line.starts_with("Loop time"))
            .last()
            .unwrap();
        let numbers: Vec<f64> = last
            .split_whitespace()
            .map(|word| word.parse().unwrap())
            .collect();
        let [_, _, force, along, up, turned] = numbers[..] else {
            panic!("{last}")
        };
        println!("{partner}: {along:.6} along, {up:.6} up, spin {turned:.6}");
        assert_eq!(force, 0.0, "still in contact");
        let slid = friction * (1.0 + restitution) * down;
        assert!((up - restitution * down).abs() < 1e-3 * down);
        // The damped normal force is there before the displacement that friction needs.
        assert!((along + slid).abs() < 0.02 * slid);
        assert!((turned - (spin + 2.5 * slid / radius)).abs() < 0.02 * 2.5 * slid / radius);
    }
}
