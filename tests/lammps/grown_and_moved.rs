// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do forces follow shapes that grow in a run, velocities that a fix prescribes, a wall whose time step changes, and grains that a command moves?

use std::fs;

use crate::harness::{crowd, parse_frames, run, Deck, Engine, Grain, Scene, State};
use crate::shapes::{length, scale, sub, Vector};

const LAW: &str = "hertz 1e7 0.3 tangential mindlin 0.5";

/// Two grains that touch across a periodic boundary only, grown by a fix between list builds: the force is that of a deck that
/// starts with grains of the final size.
#[test]
fn forces_follow_grains_that_grow_across_a_periodic_boundary() {
    let engine = Engine::from_environment();
    let pair = |size: f64| {
        let grain = |x: f64| Grain::new([1.0 * size, 0.7 * size, 0.6 * size], [x, 0.1, 0.2]);
        Scene::periodic(
            [-4.0; 3],
            [4.0; 3],
            vec![grain(-3.1), grain(3.1).turned([0.9, 0.1, 0.3, -0.2])],
        )
    };
    let cutoff = vec![
        "pair_style gran/ellipsoid 4.0".to_string(),
        format!("pair_coeff * * {LAW}"),
    ];
    let deck = |steps: u64, fixes: Vec<String>| Deck {
        integrate: false,
        time_step: 1e-4,
        steps,
        skin: 0.5,
        fixes,
        ..Deck::with_pair(cutoff.clone())
    };
    // The shape that the last step saw was set at the end of the step before.
    let grow = "variable a atom 2.0*1.02^step\nvariable b atom 1.4*1.02^step\nvariable c atom 1.2*1.02^step\n\
        fix grow all set 1 0 group all shape v_a v_b v_c";
    for atom_style in ["ellipsoid", "ellipsoid superellipsoid"] {
        for ranks in [1, 2] {
            let steps = 10;
            let grown = Deck {
                atom_style: atom_style.into(),
                ..deck(steps, grow.lines().map(|l| l.trim().to_string()).collect())
            };
            let outcome = run(&engine, "grown", &pair(1.0), &grown, ranks);
            let size = 1.02f64.powi(steps as i32 - 1);
            let started = Deck {
                atom_style: atom_style.into(),
                ..deck(0, vec![])
            };
            let expected = run(&engine, "large", &pair(size), &started, 1);
            let (a, b) = (
                outcome.last().states[0].force,
                expected.last().states[0].force,
            );
            let error = length(sub(a, b)) / length(b);
            println!("{atom_style}, {ranks} ranks: size {size:.3}: force {a:?}, {error:.1e} from that of grains of this size");
            assert!(
                length(b) > 0.0 && error < 1e-10,
                "{atom_style}, {ranks} ranks"
            );
        }
    }
}

/// Two grains in contact that `fix move rotate` turns as one: nothing slides, and what friction there is comes from the step.
#[test]
fn both_versions_a_turn_prescribed_by_fix_move_leaks_no_friction() {
    let engine = Engine::from_environment();
    let pair = || {
        Scene::open(
            10.0,
            vec![
                Grain::new([1.0, 0.8, 0.5], [0.3, 0.2, 0.1]).turned([0.9, 0.1, 0.3, 0.3]),
                Grain::new([1.0, 0.7, 0.6], [0.42, 0.6, 1.35]).turned([0.5, 0.6, -0.2, 0.4]),
            ],
        )
    };
    let leak = |steps: u64| {
        let deck = Deck {
            integrate: false,
            skin: 0.3,
            time_step: 1.0 / steps as f64,
            fixes: vec![
                "fix turn all move rotate 0 0 0 0.2 0.5 1 1.0".into(),
                "compute c all pair/local p1 p5".into(),
                "compute s all reduce max c_c[1] c_c[2] inputs local".into(),
            ],
            runs: vec![
                "thermo_style custom step c_s[*]".into(),
                "thermo_modify format float %.17g".into(),
                format!("run {steps}"),
            ],
            ..Deck::new(LAW)
        };
        let outcome = run(&engine, &format!("turn_{steps}"), &pair(), &deck, 1);
        let rows = outcome.thermo();
        let last = rows.last().expect("no thermo output");
        last["c_s[2]"] / last["c_s[1]"]
    };
    let (coarse, fine) = (leak(500), leak(2000));
    println!(
        "tangential over normal force after a turn: {coarse:.2e} in 500 steps, {fine:.2e} in 2000"
    );
    // second order: a sixteenth of it at a quarter of the step
    assert!(fine < 2e-5 && fine < coarse / 10.0);
}

/// A wall that wiggles is where its time says, whatever the steps on the way.
#[test]
fn both_versions_a_wiggling_wall_keeps_its_phase() {
    let engine = Engine::from_environment();
    let scene = || {
        let mut scene = Scene::open(5.0, vec![Grain::new([1.0, 1.0, 1.0], [0.0; 3])]);
        scene.boundary = "f f f".into();
        scene
    };
    let deck = |runs: &[&str]| Deck {
        integrate: false,
        time_step: 1e-3,
        fixes: vec![
            "fix w all wall/gran/ellipsoid hertz 1e7 0.3 zplane -0.9 NULL wiggle z 0.05 1.0".into(),
        ],
        runs: runs.iter().map(|r| r.to_string()).collect(),
        ..Deck::new("hertz 1e7 0.3")
    };
    let force = |name: &str, runs: &[&str]| {
        let outcome = run(&engine, name, &scene(), &deck(runs), 1);
        let rows = outcome.thermo();
        assert!(!rows.is_empty());
        outcome
            .output
            .lines()
            .rev()
            .find_map(|l| l.strip_prefix("FORCE "))
            .expect("no force was printed")
            .trim()
            .parse::<f64>()
            .unwrap()
    };
    let show = "print \"FORCE $(f_w[3]:%.17g)\"";
    let column = "thermo_style custom step f_w[3]";
    let plain = force("plain", &[column, "run 400", show]);
    for (name, runs) in [
        (
            "new time step",
            vec![
                column,
                "run 100",
                "timestep 5e-4",
                "run 200",
                "timestep 2e-3",
                "run 100",
                show,
            ],
        ),
        (
            "restart",
            vec![column, "run 100", "write_restart half", "run 300", show],
        ),
        (
            "after restart",
            vec![
                column,
                "run 150",
                "write_restart half.restart",
                "clear",
                "PLUGIN",
                "read_restart half.restart",
                "fix w all wall/gran/ellipsoid hertz 1e7 0.3 zplane -0.9 NULL wiggle z 0.05 1.0",
                "timestep 1e-3",
                "thermo_style custom step f_w[3]",
                "run 250",
                show,
            ],
        ),
    ] {
        let load = format!("plugin load {}", engine.plugin.display());
        let runs: Vec<&str> = runs
            .iter()
            .map(|r| if *r == "PLUGIN" { load.as_str() } else { *r })
            .collect();
        let got = force(&name.replace(' ', "_"), &runs);
        println!("{name}: {got} beside {plain}");
        assert!(
            plain.abs() > 1.0 && (got - plain).abs() < 1e-9 * plain.abs(),
            "{name}"
        );
    }
}

/// A run without set-up goes on with what the walls knew of the grains, but for what commands have changed before it: shapes, and who is in
/// the group.
#[test]
fn both_versions_walls_see_what_commands_change_before_a_run_without_set_up() {
    let engine = Engine::from_environment();
    let mut scene = Scene::open(
        10.0,
        vec![
            Grain::new([0.5, 0.4, 0.3], [0.0, 0.0, 0.295]),
            Grain::new([0.5, 0.4, 0.3], [2.0, 0.0, 0.35]),
        ],
    );
    scene.kinds = 2;
    scene.grains[1].kind = 2;
    let forces = |wall: &str, command: &str, last: &str| {
        let deck = Deck {
            integrate: false,
            time_step: 1e-6,
            steps: 12,
            skin: 0.5,
            fixes: vec![
                "fix move all nve/noforce".into(),
                "group heavy id 1".into(),
                format!("fix floor heavy wall/gran/ellipsoid {LAW} {wall}"),
            ],
            runs: [
                &["run 10".to_string()],
                &command.lines().map(String::from).collect::<Vec<_>>()[..],
                &[last.to_string()],
            ]
            .concat(),
            ..Deck::with_pair(vec![
                "pair_style gran/ellipsoid 4.0".into(),
                format!("pair_coeff * * {LAW}"),
            ])
        };
        let outcome = run(&engine, "before_a_run", &scene, &deck, 1);
        let states = &outcome.last().states;
        [states[0].force, states[1].force]
    };
    for wall in ["zplane 0 NULL", "shape sphere point 0 0 -50 radius 50"] {
        for (command, touches) in [
            ("group heavy clear\ngroup heavy id 2", [false, false]),
            (
                "group heavy id 2\nset type 2 shape 1.0 0.8 0.8",
                [true, true],
            ),
            ("set type 1 shape 1.0 0.8 0.5", [false, false]),
        ] {
            let [with, without] = ["run 2", "run 2 pre no"].map(|last| forces(wall, command, last));
            assert_eq!(with.map(|f| length(f) > 0.0), touches, "{wall}, {command}");
            for (a, b) in with.iter().zip(&without) {
                let apart = length(sub(*a, *b));
                assert!(apart <= 1e-9 * length(*a), "{wall}, {command}: {a:?} {b:?}");
            }
        }
    }
}

/// A command between two runs may turn or move grains: the normal that a contact remembers is then one from which no velocity led to the
/// present one, and the velocity of friction's viscous part must not be taken as if one had. Forces when a run starts are the same when it
/// starts again.
#[test]
fn both_versions_forces_of_grains_that_were_turned_between_runs_are_the_same_twice() {
    let engine = Engine::from_environment();
    let mut scene = crowd(27);
    for grain in &mut scene.grains {
        grain.position = scale(0.85, grain.position);
    }
    scene.high = scale(0.85, scene.high);
    let written = |file: &str| {
        format!("write_dump all custom {file} id xu yu zu fx fy fz tqx tqy tqz modify sort id format float %.17g")
    };
    for (name, law) in [
        ("friction", "nfd 1e7 0.3 200 200 tangential tfd 0.5"),
        (
            "rolling",
            "hertz 1e7 0.3 tangential linear 1e4 1.0 0.5 rolling sds 1e3 0.1 0.1 twisting sds 1e-2 1e-5 0.01",
        ),
        (
            "springs",
            "nfd 1e7 0.3 200 200 tangential tfd 0.5 displacement hysteretic twisting lubkin",
        ),
    ] {
        for (jump, command) in [
            ("turned", "displace_atoms all rotate 0.03 0.03 0.03 0 1 1 90"),
            ("moved", "displace_atoms all random 3e-4 3e-4 3e-4 4711"),
            ("set", "set group all quat 1 2 3 35"),
        ] {
            let deck = Deck {
                skin: 2e-3,
                time_step: 1e-5,
                fixes: vec![format!(
                    "fix floor all wall/gran/ellipsoid {law} shape sphere point 0.03 0.03 0.03 radius 0.02 side outside"
                )],
                runs: vec![
                    "run 60".into(),
                    command.into(),
                    "run 0".into(),
                    written("once"),
                    "run 0".into(),
                    written("twice"),
                ],
                ..Deck::new(law)
            };
            let outcome = run(&engine, &format!("{jump}_{name}"), &scene, &deck, 1);
            let [a, b] = ["once", "twice"].map(|file| {
                let text = fs::read_to_string(outcome.directory.join(file)).unwrap();
                parse_frames(&text).pop().expect("no frame was written")
            });
            let largest = |of: fn(&State) -> Vector| {
                let size = a.states.iter().map(|s| length(of(s))).fold(0.0, f64::max);
                let apart = a.states.iter().zip(&b.states);
                let apart = apart.map(|(a, b)| length(sub(of(a), of(b))));
                (apart.fold(0.0, f64::max) / size, size)
            };
            let (force, torque) = (largest(|s| s.force), largest(|s| s.torque));
            println!("{name}, {jump}: forces {:.1e}, torques {:.1e} apart", force.0, torque.0);
            assert!(force.1 > 0.1 && torque.1 > 1e-4, "{name}, {jump}: nothing acts");
            assert!(force.0 < 1e-10 && torque.0 < 1e-10, "{name}, {jump}");
        }
    }
}
