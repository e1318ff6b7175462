// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do LAMMPS' styles for a GPU give the trajectories of those for the host, and refuse what they cannot do? Without a GPU: the arrays of
//! KOKKOS are on the host, and the stand-in for NVIDIA's driver runs the kernels (`tests/lammps_on_gpu/plugin`).

use std::cell::RefCell;
use std::path::PathBuf;

use crate::engines::process;
use crate::harness::{
    attempt, between_walls, crowd, last_lines, run, Deck, Engine, Frame, Outcome, Scene, State,
};

const LAW: &str = "nfd 1e7 0.3 200 300 tangential tfd 0.5";

/// Of each of the runs of a deck.
const STEPS: u64 = 120;

/// Of the largest number of a kind in a frame: positions, velocities, angular momenta, quaternions, forces, torques. The kernels add the
/// forces of a grain in another order than lists of the host, which is rounding, 1e-16 of the largest; collisions multiply it.
/// What an adapter does wrong, a velocity of an earlier step or an image without one, is above 1e-6.
const BOUND: f64 = 1e-9;

fn path_from(variable: &str) -> PathBuf {
    process::from_environment(
        variable,
        "these tests drive a LAMMPS with KOKKOS; run them with `cargo xtask test --filter kokkos`",
    )
}

fn with_the_stand_in() -> Engine {
    Engine {
        lammps: path_from("ELLGRAN_TEST_LAMMPS_KOKKOS"),
        words: vec!["-nocite", "-k", "on", "t", "1", "-sf", "kk"],
        plugin: path_from("ELLGRAN_TEST_LAMMPS_GPU_PLUGIN"),
        ..Engine::from_environment()
    }
}

/// Grains that collide under friction and gravity in a periodic box. LAMMPS sorts them now and then.
fn deck(motion: &str) -> Deck {
    Deck {
        newton: false,
        before_data: vec!["atom_modify sort 50 0.0".into()],
        time_step: 1e-5,
        dump_every: STEPS / 2,
        thermo_every: STEPS / 2,
        thermo_columns: "step ke".into(),
        skin: 2e-3,
        integrate: false,
        fixes: vec![
            format!("fix move all nve/ellipsoid {motion}"),
            "fix gravity all gravity 9.81 vector 0.2 0 -1".into(),
        ],
        ..Deck::new(LAW)
    }
}

/// One that goes on without set-up, and one with another time step.
fn three_runs() -> Vec<String> {
    vec![
        format!("run {STEPS}"),
        format!("run {STEPS} pre no"),
        "timestep 0.8e-5".into(),
        format!("run {STEPS}"),
    ]
}

/// The numbers of a kind, of all grains.
type Kind = (&'static str, fn(&State) -> Vec<f64>);
const KINDS: [Kind; 6] = [
    ("positions", |s| s.position.to_vec()),
    ("velocities", |s| s.velocity.to_vec()),
    ("angular momenta", |s| s.angular_momentum.to_vec()),
    ("quaternions", |s| s.quaternion.to_vec()),
    ("forces", |s| s.force.to_vec()),
    ("torques", |s| s.torque.to_vec()),
];

/// The largest difference of the numbers of a kind, over the largest of them.
fn apart(kind: &Kind, a: &Frame, b: &Frame) -> f64 {
    assert_eq!((a.step, a.states.len()), (b.step, b.states.len()));
    let numbers = |frame: &Frame| frame.states.iter().flat_map(kind.1).collect::<Vec<_>>();
    let (a, b) = (numbers(a), numbers(b));
    assert!(a.iter().chain(&b).all(|x| x.is_finite()), "{}", kind.0);
    let largest = b.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    assert!(largest > 0.0, "all {} are 0", kind.0);
    let differences = a.iter().zip(&b).map(|(x, y)| (x - y).abs());
    differences.fold(0.0, f64::max) / largest
}

/// A test in which little touches, or with one neighbour list, sees little.
fn require_action(outcome: &Outcome) {
    let builds: f64 = outcome
        .output
        .lines()
        .filter_map(|line| line.strip_prefix("Neighbor list builds = "))
        .map(|number| number.trim().parse::<f64>().unwrap())
        .sum();
    let states = &outcome.last().states;
    let pushed = states.iter().filter(|s| s.torque.iter().any(|x| *x != 0.0));
    let touching = pushed.count();
    println!(
        "{touching} of {} grains touch, {builds} neighbour lists",
        states.len()
    );
    assert!(4 * touching > states.len(), "{touching}");
    assert!(builds >= 3.0, "{builds}");
}

fn same_trajectories(name: &str, scene: &Scene, deck: &Deck) {
    let host = run(
        &Engine::from_environment(),
        &format!("host_{name}"),
        scene,
        deck,
        1,
    );
    let gpu = run(&with_the_stand_in(), &format!("gpu_{name}"), scene, deck, 1);
    // These styles, not those of KOKKOS for the host.
    for words in [
        "attributes: full, newton off, kokkos_device",
        "images have the velocities of their grains on the GPU",
    ] {
        assert!(gpu.output.contains(words), "{}", last_lines(&gpu.output));
    }
    require_action(&host);
    assert_eq!(host.frames.len(), gpu.frames.len());
    let mut far = vec![];
    for kind in &KINDS {
        let frames = host.frames.iter().zip(&gpu.frames);
        let most = frames.map(|(a, b)| apart(kind, b, a)).fold(0.0, f64::max);
        println!("{name}: {} differ by {most:.1e}", kind.0);
        if most >= BOUND {
            far.push(format!("{} by {most:.1e}", kind.0));
        }
    }
    assert!(far.is_empty(), "{name}: {}", far.join(", "));
}

/// Over neighbour lists, a sort, a run without set-up and another time step; across periodic boundaries.
#[test]
fn the_trajectories_of_a_periodic_box_are_those_of_the_host() {
    for motion in ["velocities step", "velocities half"] {
        let deck = Deck {
            runs: three_runs(),
            ..deck(motion)
        };
        same_trajectories(&motion.replace(' ', "_"), &crowd(216), &deck);
    }
}

/// Planes that wiggle, slide and stand.
#[test]
fn the_trajectories_between_moving_planes_are_those_of_the_host() {
    for motion in ["velocities step", "velocities half"] {
        let mut deck = Deck {
            runs: three_runs(),
            ..deck(motion)
        };
        deck.fixes.extend([
            format!("fix x all wall/gran/ellipsoid {LAW} xplane 0.0 0.096 shear y 0.5"),
            format!("fix low all wall/gran/ellipsoid {LAW} zplane 0.0 NULL wiggle z 1e-3 0.002"),
            "fix high all wall/gran/ellipsoid nfd 2e7 0.3 80 80 tangential tfd 0.3 zplane NULL 0.096".to_string(),
        ]);
        same_trajectories(&motion.replace(' ', "_"), &between_walls(), &deck);
    }
}

/// Cylinders, cones, spheres and regions of them, that turn, move and stand, with their ends; a plane that turns.
#[test]
fn the_trajectories_in_curved_walls_are_those_of_the_host() {
    for motion in ["velocities step", "velocities half"] {
        let mut deck = Deck {
            runs: three_runs(),
            ..deck(motion)
        };
        let wall =
            |name: &str, words: &str| format!("fix {name} all wall/gran/ellipsoid {LAW} {words}");
        deck.fixes.extend([
            wall(
                "drum",
                "shape cylinder point 0.048 0.048 0.048 axis 0 1 0 radius 0.063 bounds -0.048 0.048 ends closed closed side inside \
                 omega 0.048 0.048 0.048 0 1 0 20",
            ),
            wall(
                "ball",
                "shape sphere point 0.036 0.036 -0.021 radius 0.022 side outside velocity 0 0 1",
            ),
            wall(
                "cone",
                "shape cone point -0.03 0.036 0.036 axis 1 0 0 radii 0.02 0 bounds 0 0.038 ends closed closed side outside",
            ),
            format!(
                "region hull sphere 0.048 0.048 0.048 0.074\n{}",
                wall("hull", "region hull wiggle z 1e-3 0.002")
            ),
            wall("floor", "zplane 0.0 NULL omega 0.048 0.048 0 0 0 1 -20"),
        ]);
        let mut scene = between_walls();
        scene.boundary = "f f f".into();
        scene.low[1] -= 0.03;
        scene.high[1] += 0.03;
        same_trajectories(&motion.replace(' ', "_"), &scene, &deck);
    }
}

/// What docs/kokkos.md lists as refused, each with a word of the message.
#[test]
fn what_is_not_on_the_gpu_is_refused() {
    let engine = with_the_stand_in();
    let wrong = RefCell::new(vec![]);
    let refused_on = |ranks: usize, name: &str, deck: Deck, message: &str| {
        let scene = if name.starts_with("wall") {
            between_walls()
        } else {
            crowd(64)
        };
        let outcome = attempt(&engine, name, &scene, &deck, ranks);
        if outcome.success || !outcome.output.contains(message) {
            let said = last_lines(&outcome.output);
            wrong
                .borrow_mut()
                .push(format!("{name}, in place of '{message}':\n{said}"));
        }
    };
    let refused = |name: &str, deck: Deck, message: &str| refused_on(1, name, deck, message);
    let plain = || deck("velocities step");
    let with = |command: &str| {
        let mut deck = plain();
        deck.fixes.push(command.into());
        deck
    };
    let after_a_run = |commands: &[&str]| {
        let mut deck = plain();
        deck.runs = vec!["run 1".into()];
        deck.runs.extend(commands.iter().map(|&c| c.into()));
        deck
    };
    let wall = |words: &str| with(&format!("fix w all wall/gran/ellipsoid {LAW} {words}"));

    let pour = "region top block 0 0.096 0 0.096 0.05 0.096\n\
                fix pour all pour/ellipsoid 60 1 99 region top shape one 0.004 0.003 0.002 dens 2500 2500";
    refused("pour", with(pour), "fix pour/ellipsoid is not on the GPU");
    refused_on(2, "ranks", plain(), "several ranks are not on the GPU");

    refused(
        "wall_block",
        with(&format!(
            "region b block 0.02 0.03 0.02 0.03 -0.03 -0.02 side out\nfix w all wall/gran/ellipsoid {LAW} region b"
        )),
        "made of triangles, are not on the GPU",
    );
    refused(
        "wall_servo",
        wall("zplane -0.01 NULL servo 0 0 1 1.0 0.1"),
        "'servo' is not on the GPU",
    );
    refused(
        "wall_contacts",
        wall("zplane -0.01 NULL contacts"),
        "'contacts' is not on the GPU",
    );

    for style in [
        "contact/ellipsoid/atom",
        "energy/ellipsoid",
        "timestep/ellipsoid",
    ] {
        let message = format!("compute {style} is not on the GPU");
        refused(
            &style.replace('/', "_"),
            with(&format!("compute c all {style}")),
            &message,
        );
    }
    refused(
        "pair_local",
        with("compute c all pair/local eng\ndump c all local 1 c c_c"),
        "Pair style does not support compute pair/local",
    );
    for (column, message) in [
        ("pe", "Energy was not tallied"),
        ("press", "Virial was not tallied"),
    ] {
        let mut deck = plain();
        deck.thermo_columns = format!("step {column}");
        refused(column, deck, message);
    }

    for (name, law, message) in [
        (
            "rolling",
            format!("{LAW} rolling sds 2e3 0.1 0.3"),
            "rolling",
        ),
        (
            "twisting",
            format!("{LAW} twisting sds 2e3 0.1 0.3"),
            "twisting",
        ),
    ] {
        let mut deck = plain();
        deck.pair[1] = format!("pair_coeff * * {law}");
        refused(name, deck, message);
    }

    let motion = "prescribed motion of grains and changes of the box are not on the GPU";
    refused("move", with("fix m all move linear 0 0 0"), motion);
    refused("deform", with("fix d all deform 1 x erate 1.0"), motion);
    let mut group = plain();
    group.before_data.push("suffix kk".into());
    group.fixes[0] = "group some id 1:10\nfix move some nve/ellipsoid".into();
    refused("group", group, "its group must be 'all'");
    let mut without_suffix = plain();
    without_suffix.fixes[0] = "suffix off\nfix move all nve/ellipsoid\nsuffix on".into();
    refused(
        "no_suffix",
        without_suffix,
        "fix nve/ellipsoid without the suffix is not on the GPU",
    );

    refused(
        "restart",
        after_a_run(&["write_restart file"]),
        "restart files are not written on the GPU",
    );
    refused(
        "rerun",
        after_a_run(&[
            "dump states all custom 1 states id type x y z",
            "run 1",
            "undump states",
            "rerun states dump x y z",
        ]),
        "'rerun' is not on the GPU",
    );
    let law = "pair_coeff * * nfd 2e7 0.3 200 300 tangential tfd 0.5";
    refused(
        "other_law",
        after_a_run(&[law, "run 1"]),
        "laws or walls have changed since the last run",
    );
    // The default of `delete_atoms` gives all others new IDs.
    refused(
        "deleted",
        after_a_run(&["group some id 1", "delete_atoms group some", "run 1"]),
        "atoms have been deleted, or have other IDs",
    );
    refused(
        "restart_later",
        with("restart 1000 file"),
        "restart files are not on the GPU",
    );
    refused(
        "other_images",
        after_a_run(&["group some id 1", "delete_atoms group some", "run 1 pre no"]),
        "leave out 'pre no'",
    );

    let mut narrow = plain();
    narrow.skin = 0.02;
    refused("narrow", narrow, "twice the cutoff of the neighbour list");

    let wrong = wrong.into_inner();
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}
