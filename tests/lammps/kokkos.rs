// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a LAMMPS with KOKKOS for the host give the trajectories of one without, and say what it cannot do?

use std::path::PathBuf;

use crate::engines::process;
use crate::harness::{
    attempt, attempt_in, between_walls, crowd, execute, fresh_directory, largest_difference,
    last_lines, run, Deck, Engine, Frame, Outcome, Scene,
};
use crate::shapes::{length, sub};

const LAW: &str = "nfd 1e7 0.3 200 300 tangential tfd 0.5 rolling sds 2e3 0.1 0.3";
const STEPS: u64 = 10_000;

/// How LAMMPS is started: with the styles of KOKKOS on one thread, on two, and without its suffix.
const STYLES_OF_KOKKOS: [&str; 7] = ["-nocite", "-k", "on", "t", "1", "-sf", "kk"];
const TWO_THREADS: [&str; 7] = ["-nocite", "-k", "on", "t", "2", "-sf", "kk"];
const NO_SUFFIX: [&str; 5] = ["-nocite", "-k", "on", "t", "1"];

fn lammps_with_kokkos() -> PathBuf {
    process::from_environment(
        "ELLGRAN_TEST_LAMMPS_KOKKOS",
        "these tests drive a LAMMPS with KOKKOS; run them with `cargo xtask test --filter kokkos`",
    )
}

fn with_kokkos(words: &[&'static str]) -> Engine {
    Engine {
        lammps: lammps_with_kokkos(),
        words: words.to_vec(),
        ..Engine::from_environment()
    }
}

/// How many threads of a backend LAMMPS may have: one where it is built for Serial alone.
fn has_threads() -> bool {
    let output = std::process::Command::new(lammps_with_kokkos())
        .arg("-h")
        .output()
        .expect("lmp -h");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let line = text
        .lines()
        .find(|line| line.starts_with("KOKKOS package API:"));
    line.expect("a LAMMPS with KOKKOS").contains("OpenMP")
}

/// Grains that collide under friction, viscosity and gravity with one another, with planes and with a cylinder.
fn deck(steps: u64) -> Deck {
    Deck {
        time_step: 1e-5,
        steps,
        dump_every: 500,
        thermo_every: 500,
        thermo_columns: "step pe ke c_energy[1] c_energy[2] c_energy[3] c_contacts[3] c_contacts[4] f_x[10] f_z[10]".into(),
        skin: 2e-3,
        integrate: false,
        fixes: vec![
            "fix move all nve/ellipsoid".into(),
            "fix gravity all gravity 9.81 vector 0.2 0 -1".into(),
            format!("fix x all wall/gran/ellipsoid {LAW} xplane -0.01 0.11"),
            format!("fix z all wall/gran/ellipsoid {LAW} zplane -0.01 0.11 wiggle z 1e-3 0.02"),
            format!("fix round all wall/gran/ellipsoid {LAW} ycylinder 0.14"),
            "compute energy all energy/ellipsoid".into(),
            "compute contacts all pair gran/ellipsoid".into(),
        ],
        ..Deck::new(LAW)
    }
}

fn of_frames(a: &Frame, b: &Frame) -> f64 {
    assert_eq!(a.step, b.step);
    assert_eq!(a.states.len(), b.states.len());
    let (positions, velocities) = largest_difference(a, b);
    let mut largest = positions.max(velocities);
    for (s, r) in a.states.iter().zip(&b.states) {
        // A force has no scale of its own: that of the stiffest contact here is some newtons.
        largest = largest
            .max(length(sub(s.force, r.force)))
            .max(length(sub(s.torque, r.torque)))
            .max(length(sub(s.angular_momentum, r.angular_momentum)));
        for (x, y) in s.quaternion.iter().zip(&r.quaternion) {
            largest = largest.max((x - y).abs());
        }
    }
    largest
}

/// The largest difference of any number of any frame, and of the sums in the thermo output, each over its largest value.
fn difference(a: &Outcome, b: &Outcome) -> f64 {
    assert_eq!(a.frames.len(), b.frames.len());
    assert!(!a.frames.is_empty());
    let frames = a.frames.iter().zip(&b.frames);
    let mut largest = frames.map(|(x, y)| of_frames(x, y)).fold(0.0, f64::max);
    let (rows, others) = (a.thermo(), b.thermo());
    assert_eq!(rows.len(), others.len());
    assert!(!rows.is_empty());
    for name in rows[0].keys() {
        let scale = rows.iter().map(|row| row[name].abs()).fold(0.0, f64::max);
        for (x, y) in rows.iter().zip(&others) {
            largest = largest.max((x[name] - y[name]).abs() / scale.max(1e-30));
        }
    }
    largest
}

/// A test that sees no contacts, or sees none of the walls, sees nothing.
fn require_contacts(outcome: &Outcome) {
    let rows = outcome.thermo();
    let most = |name: &str| rows.iter().map(|row| row[name]).fold(0.0, f64::max);
    let dissipated = rows.last().unwrap()["c_contacts[3]"];
    println!(
        "{} pairs in contact at once, {} at the walls, {dissipated:.2e} J dissipated",
        most("c_contacts[4]"),
        most("f_x[10]") + most("f_z[10]")
    );
    assert!(most("c_contacts[4]") > 10.0);
    assert!(most("f_x[10]") > 0.0 && most("f_z[10]") > 0.0);
    assert!(dissipated > 0.0);
}

#[test]
fn the_trajectories_are_those_without_kokkos() {
    let reference = Engine::from_environment();
    let scene = between_walls();
    let mut ways = vec![
        (1, STEPS, &STYLES_OF_KOKKOS[..]),
        (2, STEPS, &STYLES_OF_KOKKOS[..]),
    ];
    if has_threads() {
        // Threads that wait for one another are slow where something else has their core.
        ways.push((1, STEPS / 10, &TWO_THREADS[..]));
    }
    for (ranks, steps, words) in ways {
        let name = format!("{ranks}_ranks_{}_threads", words[4]);
        let plain = run(
            &reference,
            &format!("plain_{name}"),
            &scene,
            &deck(steps),
            ranks,
        );
        if steps == STEPS {
            require_contacts(&plain);
        }
        let outcome = run(&with_kokkos(words), &name, &scene, &deck(steps), ranks);
        for words in ["pair gran/ellipsoid/kk, perpetual", "KOKKOS mode"] {
            assert!(outcome.output.contains(words), "{}", outcome.output);
        }
        let apart = difference(&outcome, &plain);
        println!("{name}, {steps} steps: {apart:.1e}");
        assert!(apart < 1e-10, "{name}: {apart:e}");
    }
}

/// On one and two ranks, with newton on and off, across periodic boundaries: grains and their histories change ranks. Also where
/// LAMMPS' own lists and sorting are set to those of KOKKOS.
#[test]
fn the_trajectories_of_a_periodic_box_are_those_without_kokkos() {
    let reference = Engine::from_environment();
    let scene = crowd(64);
    let full_list = "-pk kokkos neigh full newton off sort device";
    for (ranks, newton, package) in [
        (1, false, ""),
        (2, true, ""),
        (2, false, ""),
        (2, false, full_list),
    ] {
        let periodic = Deck {
            newton,
            fixes: vec!["fix move all nve/ellipsoid".into()],
            thermo_columns: "step pe ke".into(),
            ..deck(STEPS / 2)
        };
        let what = format!("{ranks} ranks, newton {newton} {package}");
        let name = what.replace([' ', ','], "_");
        let plain = run(
            &reference,
            &format!("plain_{name}"),
            &scene,
            &periodic,
            ranks,
        );
        let words: Vec<&str> = STYLES_OF_KOKKOS
            .into_iter()
            .chain(package.split_whitespace())
            .collect();
        let outcome = run(&with_kokkos(&words), &name, &scene, &periodic, ranks);
        let apart = difference(&outcome, &plain);
        println!("{what}: {apart:.1e}");
        assert!(apart < 1e-10, "{what}: {apart:e}");
    }
}

/// Styles without the suffix, and LAMMPS' own integrators, in a run with KOKKOS.
#[test]
fn styles_without_the_suffix_work_beside_those_of_kokkos() {
    let reference = Engine::from_environment();
    let scene = between_walls();
    let plain = run(&reference, "plain", &scene, &deck(2000), 1);
    let unsuffixed = Deck {
        before_data: vec!["suffix off".into()],
        ..deck(2000)
    };
    let kokkos = with_kokkos(&STYLES_OF_KOKKOS);
    let outcome = run(&kokkos, "unsuffixed", &scene, &unsuffixed, 1);
    assert!(
        outcome.output.contains("pair gran/ellipsoid, perpetual"),
        "{}",
        outcome.output
    );
    let apart = difference(&outcome, &plain);
    println!("styles without the suffix: {apart:.1e}");
    assert!(apart < 1e-10, "{apart:e}");

    // The integrator of LAMMPS rounds differently under KOKKOS, and collisions make more of it.
    let asphere = |steps| {
        let mut deck = deck(steps);
        deck.fixes[0] = "fix move all nve/asphere".into();
        deck
    };
    for (ranks, law_has_memory) in [(1, true), (2, true), (2, false)] {
        let mut mine = asphere(300);
        if !law_has_memory {
            mine.pair[1] = "pair_coeff * * hertz 1e7 0.3".into();
        }
        let plain = run(
            &reference,
            &format!("asphere_plain_{ranks}_{law_has_memory}"),
            &scene,
            &mine,
            ranks,
        );
        let kokkos = with_kokkos(&STYLES_OF_KOKKOS);
        let outcome = run(
            &kokkos,
            &format!("asphere_{ranks}_{law_has_memory}"),
            &scene,
            &mine,
            ranks,
        );
        let apart = difference(&outcome, &plain);
        println!("nve/asphere, {ranks} ranks, history {law_has_memory}: {apart:.1e}");
        assert!(apart < 1e-10, "nve/asphere, {ranks} ranks: {apart:e}");
    }
}

/// Runs to the middle in one LAMMPS, writes a restart file there and goes on from it in another.
fn through_a_file(name: &str, engines: [&Engine; 2], ranks: [usize; 2], scene: &Scene) -> Outcome {
    let first = Deck {
        runs: vec![
            format!("run {}", STEPS / 2),
            "write_restart middle.restart".into(),
        ],
        ..deck(STEPS / 2)
    };
    let outcome = run(engines[0], name, scene, &first, ranks[0]);
    let second = Deck {
        pair: vec![],
        source: vec!["read_restart middle.restart".into()],
        ..deck(STEPS / 2)
    };
    let outcome = attempt_in(engines[1], outcome.directory, scene, &second, ranks[1]);
    assert!(outcome.success, "{}", last_lines(&outcome.output));
    outcome
}

#[test]
fn restart_files_go_on_with_and_without_kokkos() {
    let plain = Engine::from_environment();
    let kokkos = with_kokkos(&STYLES_OF_KOKKOS);
    let scene = between_walls();
    for ranks in [1, 2] {
        let reference = through_a_file(
            &format!("plain_{ranks}"),
            [&plain, &plain],
            [ranks; 2],
            &scene,
        );
        require_contacts(&reference);
        for (name, engines) in [
            ("both", [&kokkos, &kokkos]),
            ("to_kokkos", [&plain, &kokkos]),
            ("from_kokkos", [&kokkos, &plain]),
        ] {
            let outcome = through_a_file(&format!("{name}_{ranks}"), engines, [ranks; 2], &scene);
            let apart = difference(&outcome, &reference);
            println!("{name}, {ranks} ranks: {apart:.1e}");
            assert!(apart < 1e-10, "{name}, {ranks} ranks: {apart:e}");
        }
    }
}

/// The page's own deck: grains that are poured into a box, and their energies.
#[test]
fn grains_are_inserted_as_without_kokkos() {
    let text = |engine: &Engine| {
        format!(
            "plugin load {}\nunits si\natom_style ellipsoid\nboundary p p f\ncomm_modify vel yes\nneighbor 1e-3 bin\n\
             region box block 0 0.04 0 0.04 0 0.08\ncreate_box 1 box\n\
             pair_style gran/ellipsoid 0.012\npair_coeff 1 1 {LAW}\n\
             region bottom block 0 0.04 0 0.04 0 0.03\n\
             create_ellipsoids 1 4711 region bottom number 60 shape one 0.003 0.002 0.002 dens 2500 2500\n\
             region top block 0 0.04 0 0.04 0.045 0.08\n\
             fix gravity all gravity 9.81 vector 0 0 -1\nfix move all nve/ellipsoid\n\
             fix pour all pour/ellipsoid 60 1 99 region top shape one 0.004 0.003 0.002 dens 2500 2500\n\
             fix floor all wall/gran/ellipsoid {LAW} zplane 0 0.08\n\
             compute contacts all pair gran/ellipsoid\n\
             compute quaternion all property/atom quatw quati quatj quatk\n\
             dump frames all custom 1000 frames id type xu yu zu vx vy vz fx fy fz tqx tqy tqz angmomx angmomy angmomz \
             c_quaternion[1] c_quaternion[2] c_quaternion[3] c_quaternion[4]\n\
             dump_modify frames sort id format float %.17g\n\
             thermo_style custom step atoms pe ke c_contacts[3] c_contacts[4]\nthermo_modify norm no format float %.17g lost error\n\
             thermo 1000\ntimestep 2e-5\nrun 5000\n",
            engine.plugin.display()
        )
    };
    let outcome = |name: &str, engine: &Engine, ranks: usize| {
        let directory = fresh_directory(&format!("{name}_{ranks}"));
        let (success, output) = execute(engine, &directory, &text(engine), ranks);
        Outcome::read(directory, success, output).succeeded()
    };
    let (plain, kokkos) = (Engine::from_environment(), with_kokkos(&STYLES_OF_KOKKOS));
    for ranks in [1, 2] {
        let reference = outcome("plain", &plain, ranks);
        let rows = reference.thermo();
        println!("{} grains", rows.last().unwrap()["Atoms"]);
        assert!(rows[0]["Atoms"] >= 60.0 && rows.last().unwrap()["Atoms"] > 100.0);
        let apart = difference(&outcome("kokkos", &kokkos, ranks), &reference);
        println!("{ranks} ranks: {apart:.1e}");
        assert!(apart < 1e-10, "{ranks} ranks: {apart:e}");
    }
}

/// LAMMPS 4 Jul 2026 gives images the velocities of others where KOKKOS packs its messages itself.
#[test]
fn wrong_velocities_of_images_stop_the_run() {
    for (ranks, comm) in [(1, "host"), (1, "device"), (2, "device")] {
        let mut words = STYLES_OF_KOKKOS.to_vec();
        words.extend(["-pk", "kokkos", "comm", comm]);
        let periodic = Deck {
            fixes: vec!["fix move all nve/ellipsoid".into()],
            thermo_columns: "step pe ke".into(),
            ..deck(100)
        };
        let name = format!("{ranks}_{comm}");
        let message = "use 'package kokkos comm no'";
        let outcome = attempt(&with_kokkos(&words), &name, &crowd(64), &periodic, ranks);
        assert!(!outcome.success, "{name}");
        assert!(
            outcome.output.contains(message),
            "{name}: {}",
            last_lines(&outcome.output)
        );
    }
}

/// What cannot work says so.
#[test]
fn a_wrong_start_or_deck_is_refused() {
    let scene = between_walls();
    let refused = |engine: &Engine, name: &str, deck: &Deck, message: &str| {
        let outcome = attempt(engine, name, &scene, deck, 1);
        assert!(!outcome.success, "{name} was not refused");
        assert!(
            outcome.output.contains(message),
            "{name}: {}",
            last_lines(&outcome.output)
        );
    };

    // A LAMMPS with the package, which is not in use.
    let off = with_kokkos(&["-nocite"]);
    let mut pair = deck(1);
    pair.pair[0] = "pair_style gran/ellipsoid/kk".into();
    refused(
        &off,
        "pair",
        &pair,
        "style gran/ellipsoid/kk needs LAMMPS to run with KOKKOS: start it with '-k on'",
    );
    let mut wall = deck(1);
    wall.fixes[2] = format!("fix x all wall/gran/ellipsoid/kk {LAW} xplane -0.03 0.125");
    refused(
        &off,
        "wall",
        &wall,
        "style wall/gran/ellipsoid/kk needs LAMMPS to run with KOKKOS",
    );
    let mut integrator = deck(1);
    integrator.fixes[0] = "fix move all nve/ellipsoid/kk".into();
    refused(
        &off,
        "integrator",
        &integrator,
        "style nve/ellipsoid/kk needs LAMMPS to run with KOKKOS",
    );

    // A LAMMPS without the package does not know these styles.
    let without = Engine::from_environment();
    refused(
        &without,
        "without_pair",
        &pair,
        "Unrecognized pair style 'gran/ellipsoid/kk'",
    );
    refused(
        &without,
        "without_fix",
        &integrator,
        "Unrecognized fix style 'nve/ellipsoid/kk'",
    );

    // Messages of the styles, and those of LAMMPS.
    let kokkos = with_kokkos(&STYLES_OF_KOKKOS);
    let mut law = deck(1);
    law.pair[1] = "pair_coeff * * hertzian 1e7 0.3".into();
    refused(&kokkos, "law", &law, "hertzian");
    let mut turns_nothing = deck(1);
    turns_nothing.fixes[0] = "fix move all nve".into();
    refused(
        &kokkos,
        "nve",
        &turns_nothing,
        "it moves grains but does not turn them",
    );
    refused(
        &with_kokkos(&NO_SUFFIX),
        "atom_style",
        &deck(1),
        "KOKKOS package requires a Kokkos-enabled atom_style",
    );
}
