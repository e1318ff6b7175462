// SPDX-License-Identifier: MIT OR Apache-2.0
//! Are grains that `fix insert/stream` holds back and releases what LIGGGHTS' own spheres are?

use std::fs;
use std::path::Path;

use crate::harness::{fresh_directory, run_in, Deck, Engine, Grain, Outcome, Scene, ELASTIC};
use crate::meshes::sheet;
use crate::shapes::{length, sub};

/// Four spheres that fly up into a stream of spheres, which is held until it passes a square at z = 3 cm.
fn stream(ours: bool, omega: &str, ranks: usize) -> Outcome {
    let words = if omega.is_empty() {
        "at_rest"
    } else {
        "spinning"
    };
    let directory = fresh_directory(&format!("stream_{ours}_{words}_{ranks}"));
    stream_in(&directory, ours, omega, ranks, |_| {})
}

fn stream_in(
    directory: &Path,
    ours: bool,
    omega: &str,
    ranks: usize,
    change: impl Fn(&mut Deck),
) -> Outcome {
    let bullets = [
        [0.0113, 0.0071],
        [-0.0127, 0.0083],
        [-0.0097, -0.0113],
        [0.0131, -0.0079],
    ];
    let scene = Scene {
        low: [-0.07; 3],
        high: [0.07; 3],
        ..Scene::open(
            1.0,
            bullets
                .map(|[x, y]| Grain {
                    density: 2500.0,
                    ..Grain::sphere(5e-3, [x, y, 0.018]).moving([0.2, 0.3, 4.0])
                })
                .to_vec(),
        )
    };
    let (style, template) = if ours {
        ("superquadric", "superquadric 15485863 atom_type 1 density constant 2500 shape constant 0.003 0.003 0.003 blockiness constant 2. 2.")
    } else {
        (
            "sphere",
            "sphere 15485863 atom_type 1 density constant 2500 radius constant 0.003",
        )
    };
    let mut deck = Deck {
        model: format!("nfd tangential tfd surface {}", if ours { "ellipsoid" } else { "default" }),
        atom_style: style.into(),
        before: vec!["fix face all mesh/surface/planar file gate.stl type 1".into()],
        fixes: vec![
            format!("fix t all particletemplate/{template}"),
            "fix pd all particledistribution/discrete 15485867 1 t 1.0".into(),
            format!(
                "fix ins all insert/stream seed 32452843 distributiontemplate pd nparticles 150 particlerate 1000000 \
                 overlapcheck yes vel constant 0 0 -1.5 {omega} insertion_face face extrude_length 0.02"
            ),
        ],
        time_step: 1e-5,
        steps: 600,
        ..Deck::new([1e7, 0.3, 50.0, 50.0], 0.5)
    };
    change(&mut deck);
    // the square at the height of the gate
    fs::write(
        directory.join("gate.stl"),
        sheet(1).replace(" 0\n", " 3e-2\n"),
    )
    .unwrap();
    run_in(&Engine::from_environment(), directory, &scene, &deck, ranks)
}

#[test]
fn a_stream_holds_and_releases_spheres_as_the_engines_own() {
    for (omega, spin) in [
        ("", [0.0; 3]),
        ("omega constant 30 0 100", [30.0, 0.0, 100.0]),
    ] {
        for ranks in [1, 2] {
            let [ours, theirs] = [true, false].map(|ours| stream(ours, omega, ranks));
            let pairs = || ours.last().states.iter().zip(&theirs.last().states);
            assert_eq!(ours.last().states.len(), theirs.last().states.len());
            assert!(ours.last().states.len() > 50);
            // grains that were released, and of the four those that something turned
            let released = theirs.last().states[4..]
                .iter()
                .filter(|s| s.angular_velocity == spin && s.position[2] < 0.0295)
                .count();
            let hit = theirs.last().states[..4]
                .iter()
                .filter(|s| length(s.angular_velocity) > 10.0)
                .count();
            let largest = pairs().fold(0.0f64, |m, (_, b)| m.max(length(b.angular_velocity)));
            let spins = pairs().fold(0.0f64, |m, (a, b)| {
                m.max(length(sub(a.angular_velocity, b.angular_velocity)))
            });
            let velocities = pairs().fold(0.0f64, |m, (a, b)| {
                m.max(length(sub(a.velocity, b.velocity)))
            });
            println!(
                "omega '{omega}', {ranks} ranks: {released} released, {hit} hit; spins apart by {spins:.1e} of {largest:.1e}, velocities by {velocities:.1e}"
            );
            assert!(released > 0 && hit > 0);
            // LIGGGHTS places a superquadric by a bounding radius that is larger than a sphere's by 1e-4
            assert!(spins < 1e-3 * largest && velocities < 1e-2);
        }
    }
}

/// LIGGGHTS itself released them one step earlier, and those of the file's step it neither held nor released.
#[test]
fn a_stream_goes_on_from_a_restart_file() {
    let gravity = "fix g all gravity 9.81 vector 0 0 -1";
    for ours in [true, false] {
        let end = |source: &[&str], runs: &[&str], ranks: usize| {
            let directory = fresh_directory("restarted").parent().unwrap().join("files");
            fs::create_dir_all(&directory).unwrap();
            let outcome = stream_in(&directory, ours, "omega constant 30 0 100", ranks, |deck| {
                deck.source = source.iter().map(|word| (*word).to_string()).collect();
                // whose forces do not depend on velocities, those of the half step among them
                deck.materials = vec![ELASTIC];
                // before the insertion, which looks for it
                deck.before.push(format!("timestep {:e}", deck.time_step));
                deck.fixes.push(gravity.into());
                deck.runs = runs.iter().map(|word| (*word).to_string()).collect();
            });
            outcome.last().clone()
        };
        // Grains come in the first step, and the first of them is hit after 50: LIGGGHTS moves those that are hit where a run begins.
        for (steps, ranks) in [(1, 1), (50, 1), (50, 2)] {
            let whole = end(&[], &["run 600"], ranks);
            let released = (whole.states[4..].iter()).filter(|s| s.position[2] < 0.0295);
            assert!(released.count() > 10);
            assert!(whole.states.len() > 50);
            let (first, later) = (format!("run {steps}"), format!("run {}", 600 - steps));
            end(&[], &[&first, "write_restart file"], ranks);
            let rest = end(&["read_restart file"], &[&later], ranks);
            assert_eq!(rest.states.len(), whole.states.len());
            let pairs = || rest.states.iter().zip(&whole.states);
            let velocities = pairs().fold(0.0f64, |m, (a, b)| {
                m.max(length(sub(a.velocity, b.velocity)))
            });
            let places = pairs().fold(0.0f64, |m, (a, b)| {
                m.max(length(sub(a.position, b.position)))
            });
            println!("ours {ours}, file of step {steps}, {ranks} ranks: velocities apart by {velocities:.1e}, places by {places:.1e}");
            assert!(velocities < 1e-8 && places < 1e-10);
        }
    }
}
