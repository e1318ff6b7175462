// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do contacts go on where `replicate` copies grains in mid-run? A periodic box beside itself goes on as the box alone, in every copy. LIGGGHTS itself
//! begins the friction of copies anew, and mixes up that of contacts across the boundary.

use crate::harness::{attempt, crowd, fresh_directory, run, Deck, Engine, Frame, Scene};
use crate::shapes::{length, scale, sub};

const HALF: u64 = 150;

/// Most grains touch others, across the boundary too.
fn dense() -> Scene {
    let mut scene = crowd(27);
    for grain in &mut scene.grains {
        grain.semi_axes = scale(1.2, grain.semi_axes);
    }
    scene
}

fn deck(model: &str, integrator: &'static str, between: &[String]) -> Deck {
    let mut runs = vec![format!("run {HALF}")];
    runs.extend(between.iter().cloned());
    runs.push(format!("run {HALF}"));
    Deck {
        model: model.into(),
        time_step: 1e-5,
        steps: HALF,
        integrator,
        runs,
        ..Deck::new([1e8, 0.3, 0.0, 0.0], 0.5)
    }
}

fn replicate(scene: &Scene, times: [usize; 3]) -> String {
    let side = scene.high[0];
    let [x, y, z] = times;
    format!("replicate {x} {y} {z} offset {side} {side} {side} shift 0 0 0")
}

/// The largest difference of velocities from those of the original, over the largest of them.
fn apart(copies: &Frame, alone: &Frame) -> f64 {
    let largest = (alone.states.iter()).fold(0.0f64, |m, s| m.max(length(s.velocity)));
    let pairs = (copies.states.iter()).zip(alone.states.iter().cycle());
    pairs.fold(0.0f64, |m, (a, b)| {
        m.max(length(sub(a.velocity, b.velocity)))
    }) / largest
}

#[test]
fn copies_and_originals_go_on_as_the_box_alone() {
    let engine = Engine::from_environment();
    let ellipsoids = dense();
    let mut spheres = dense();
    for grain in &mut spheres.grains {
        grain.semi_axes = [1.3e-2; 3];
    }
    let nfd = "nfd tangential tfd surface ellipsoid";
    let hertz = "hertz tangential history surface ellipsoid";
    let of_spheres = "nfd tangential tfd surface default";
    for (scene, model, integrator, style) in [
        (&ellipsoids, nfd, "ellipsoid", "superquadric"),
        (&ellipsoids, hertz, "superquadric", "superquadric"),
        (&spheres, of_spheres, "", "sphere"),
    ] {
        let end = |between: &[String]| {
            let deck = Deck {
                atom_style: style.into(),
                ..deck(model, integrator, between)
            };
            run(&engine, "replicated", scene, &deck, 1).last().clone()
        };
        let alone = end(&[]);
        let ways = [
            ("twice along x", vec![replicate(scene, [2, 1, 1])], 2),
            ("along y and z", vec![replicate(scene, [1, 2, 3])], 6),
            (
                "after another command that reads the list",
                vec!["write_restart r".into(), replicate(scene, [2, 1, 1])],
                2,
            ),
        ];
        for (what, between, copies) in ways {
            let end = end(&between);
            assert_eq!(end.states.len(), copies * scene.grains.len());
            let apart = apart(&end, &alone);
            println!("{model}, {what}: apart by {apart:.1e}");
            assert!(apart < 1e-10, "{model}, {what}: {apart:e}");
        }
    }
}

/// LIGGGHTS gives copies the IDs of other grains where several processors hold some, and where IDs have gaps.
#[test]
fn grains_of_one_id_are_refused() {
    let engine = Engine::from_environment();
    let scene = dense();
    let copies = replicate(&scene, [2, 1, 1]);
    let gap = ["group gone id 3", "delete_atoms group gone compress no"].map(String::from);
    for (what, between, ranks) in [
        ("ranks", vec![copies.clone()], 2),
        ("gap", [&gap[..], std::slice::from_ref(&copies)].concat(), 1),
    ] {
        let deck = deck(
            "nfd tangential tfd surface ellipsoid",
            "ellipsoid",
            &between,
        );
        let outcome = attempt(&engine, what, &scene, &deck, ranks);
        assert!(!outcome.success, "{what}");
        assert!(
            outcome.output.contains("two particles have the ID"),
            "{what}: {}",
            outcome.output
        );
    }
}

/// LIGGGHTS itself crashed: of copies, what the file has of each grain is not there to be read.
#[test]
fn copies_of_a_restart_file_are_refused_before_the_first_run() {
    let engine = Engine::from_environment();
    let scene = dense();
    let file = fresh_directory("file").join("r");
    let written = [format!("write_restart {}", file.display())];
    let plain = deck(
        "nfd tangential tfd surface ellipsoid",
        "ellipsoid",
        &written,
    );
    run(&engine, "written", &scene, &plain, 1);
    let with = |runs: &[String]| Deck {
        source: vec![format!("read_restart {}", file.display())],
        runs: runs.to_vec(),
        ..plain.clone()
    };
    let copies = replicate(&scene, [2, 1, 1]);
    let outcome = attempt(
        &engine,
        "at_once",
        &scene,
        &with(&[copies.clone(), "run 1".into()]),
        1,
    );
    assert!(!outcome.success);
    assert!(
        outcome
            .output
            .contains("replicate command must come after first 'run'"),
        "{}",
        outcome.output
    );
    let later = ["run 0".into(), copies, format!("run {HALF}")];
    let [alone, copied] = [&later[2..], &later[..]]
        .map(|runs| run(&engine, "later", &scene, &with(runs), 1).last().clone());
    let apart = apart(&copied, &alone);
    println!("apart by {apart:.1e}");
    assert!(apart < 1e-10, "{apart:e}");
}
