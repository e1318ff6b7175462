// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is the motion on a mesh the same on four ranks as on one, where grains and moving triangles change rank in mid-contact?

use std::fs;
use std::path::Path;

use crate::decomposition::difference;
use crate::harness::{
    fresh_directory, run_in, Deck, Engine, Grain, Outcome, Scene, State, ELASTIC,
};
use crate::meshes::{sheet, HALF};
use crate::shapes::{length, sub, Random, Vector};

/// Acceleration that presses the grains on the sheet.
pub const WEIGHT: f64 = 200.0;

/// Four grains on a sheet of 128 triangles, too far apart to touch: two slide, two roll about their axis of symmetry. The
/// first goes over the corner where four ranks meet.
pub fn on_a_sheet() -> Scene {
    let grain = |axes: Vector, x: f64, y: f64| Grain {
        density: 2500.0,
        ..Grain::new(axes, [x, y, axes[2]])
    };
    let needle = [8e-3, 2e-3, 2e-3];
    let disc = [1e-3, 3e-3, 3e-3];
    Scene {
        low: [-0.07, -0.07, -0.02],
        high: [0.07, 0.07, 0.02],
        ..Scene::open(
            1.0,
            vec![
                grain([4e-3, 3e-3, 2e-3], -0.005, -0.0045).moving([3.0, 2.7, 0.0]),
                grain([2e-3, 6e-3, 1.5e-3], 0.03, 0.006).moving([0.3, -3.0, 0.0]),
                grain(needle, -0.05, 0.0015)
                    .moving([0.0, -1.0, 0.0])
                    .spinning([1.0 / 2e-3, 0.0, 0.0]),
                grain(disc, -0.03, 0.005)
                    .moving([0.0, -4.0, 0.0])
                    .spinning([4.0 / 3e-3, 0.0, 0.0]),
            ],
        )
    }
}

pub fn sheet_deck() -> Deck {
    Deck {
        time_step: 1e-5,
        steps: 300,
        dump_every: 5,
        materials: vec![[1e7, 0.3, 100.0, 100.0]],
        before: vec!["fix sheet all mesh/surface file sheet.stl type 1".into()],
        walls: vec!["mesh n_meshes 1 meshes sheet".into()],
        fixes: vec![format!("fix weight all gravity {WEIGHT} vector 0 0 -1")],
        ..Deck::new(ELASTIC, 0.5)
    }
}

fn on_ranks(engine: &Engine, scene: &Scene, deck: &Deck, mesh: &str, ranks: usize) -> Outcome {
    let directory = fresh_directory(&format!("{ranks}"));
    fs::write(directory.join("sheet.stl"), mesh).unwrap();
    run_in(engine, &directory, scene, deck, ranks)
}

/// Largest difference of velocities over the largest velocity, in all frames; and of forces.
fn apart(a: &Outcome, b: &Outcome) -> (f64, f64) {
    assert_eq!(a.frames.len(), b.frames.len());
    let mut worst = (0.0f64, 0.0f64);
    for (p, q) in a.frames.iter().zip(&b.frames) {
        assert_eq!(p.step, q.step);
        worst.0 = worst.0.max(difference(p, q));
        let largest = q.states.iter().map(|s| length(s.force)).fold(0.0, f64::max);
        for (s, t) in p.states.iter().zip(&q.states) {
            worst.1 = worst.1.max(length(sub(s.force, t.force)) / largest);
        }
    }
    worst
}

/// How many grains changed the quarter of the sheet that their rank has, while the sheet pushed them.
fn crossings(scene: &Scene, outcome: &Outcome) -> usize {
    let quarter = |s: &State| (s.position[0] > 0.0, s.position[1] > 0.0);
    (0..scene.grains.len())
        .filter(|&k| {
            let pushed = |s: &State| s.force[2] + WEIGHT * scene.grains[k].mass() > 0.0;
            outcome.frames.windows(2).any(|w| {
                let [a, b] = [&w[0].states[k], &w[1].states[k]];
                quarter(a) != quarter(b) && pushed(a) && pushed(b)
            })
        })
        .count()
}

#[test]
fn grains_cross_triangles_and_ranks_in_contact() {
    let engine = Engine::from_environment();
    let scene = on_a_sheet();
    let deck = sheet_deck();
    let one = on_ranks(&engine, &scene, &deck, &sheet(8), 1);
    let four = on_ranks(&engine, &scene, &deck, &sheet(8), 4);
    assert!(
        four.output.contains("2 by 2 by 1 MPI processor grid"),
        "the ranks do not meet in the middle of the sheet"
    );
    let (velocities, forces) = apart(&four, &one);
    let crossed = crossings(&scene, &one);
    println!(
        "{crossed} of 4 grains went from rank to rank in contact; four ranks and one apart by {velocities:.1e} in velocities, {forces:.1e} in forces"
    );
    assert_eq!(crossed, 4);
    // nothing but the wall acts: not a rounding may differ by more than the order of a sum
    assert!(velocities < 1e-13 && forces < 1e-12);
}

#[test]
fn triangles_of_a_turning_mesh_change_rank() {
    let engine = Engine::from_environment();
    let mut scene = on_a_sheet();
    for grain in &mut scene.grains {
        grain.velocity = [0.0; 3];
        grain.angular_momentum = [0.0; 3];
    }
    // on the way that the sheet turns, shortly before another rank
    for (grain, [x, y]) in scene.grains.iter_mut().zip([
        [-0.0025, -0.00225],
        [0.024, -0.002],
        [0.002, -0.015],
        [-0.024, 0.002],
    ]) {
        grain.position = [x, y, grain.semi_axes[2]];
    }
    let mut deck = sheet_deck();
    // a quarter of a turn; the corners of the sheet stay in the box
    deck.time_step = 2e-5;
    deck.steps = 150;
    deck.fixes.push(
        "fix turn all move/mesh mesh sheet rotate origin 0. 0. 0. axis 0. 0. 1. period 0.012"
            .into(),
    );
    scene.low = [-0.09, -0.09, -0.02];
    scene.high = [0.09, 0.09, 0.02];
    let one = on_ranks(&engine, &scene, &deck, &sheet(8), 1);
    let four = on_ranks(&engine, &scene, &deck, &sheet(8), 4);
    assert!(four.output.contains("2 by 2 by 1 MPI processor grid"));
    let (velocities, forces) = apart(&four, &one);
    let dragged = one
        .last()
        .states
        .iter()
        .filter(|s| length(s.velocity) > 0.05)
        .count();
    println!("{dragged} of 4 grains dragged along; four ranks and one apart by {velocities:.1e} in velocities, {forces:.1e} in forces");
    assert_eq!(dragged, 4);
    assert!(velocities < 1e-12 && forces < 1e-11);
}

#[test]
fn a_mesh_goes_on_across_periodic_boundaries() {
    let engine = Engine::from_environment();
    let mut scene = on_a_sheet();
    // each leaves over another side; the first over a corner of the box
    for (grain, [x, y]) in scene.grains.iter_mut().zip([
        [0.057, 0.0575],
        [0.03, -0.056],
        [-0.03, -0.0588],
        [0.0, -0.055],
    ]) {
        grain.position[0] = x;
        grain.position[1] = y;
    }
    scene.low = [-HALF, -HALF, -0.02];
    scene.high = [HALF, HALF, 0.02];
    scene.boundary = "p p f".into();
    let mesh = sheet_deck();
    let plane = Deck {
        before: vec![],
        walls: vec!["primitive type 1 zplane 0.0".into()],
        ..sheet_deck()
    };
    let resting = on_ranks(&engine, &scene, &plane, "", 1);
    let out = resting
        .last()
        .states
        .iter()
        .filter(|s| s.position[..2].iter().any(|x| x.abs() > HALF))
        .count();
    for ranks in [1, 4] {
        let outcome = on_ranks(&engine, &scene, &mesh, &sheet(8), ranks);
        let (velocities, forces) = apart(&outcome, &resting);
        println!("{out} of 4 grains left the box; mesh on {ranks} ranks and plane apart by {velocities:.1e} in velocities, {forces:.1e} in forces");
        assert_eq!(out, 4);
        assert!(velocities < 1e-9 && forces < 1e-9);
    }
}

/// A face near one end of the box acts on a sphere near the other as Hertz' law says: a mesh has images, in both directions.
#[test]
fn a_face_acts_on_grains_across_the_boundary() {
    let engine = Engine::from_environment();
    let (radius, overlap, from_end) = (6e-3f64, 5e-4f64, 5e-3);
    // The plane of the sheet becomes one across x.
    let face = |x: f64| {
        let lines = sheet(2);
        let turned = lines.lines().map(|line| {
            let Some(corner) = line.trim().strip_prefix("vertex ") else {
                return line.to_owned();
            };
            let [y, z, _] = corner.split(' ').collect::<Vec<_>>()[..] else {
                panic!("{line}")
            };
            format!("vertex {x:e} {y} {z}")
        });
        turned.collect::<Vec<_>>().join("\n") + "\n"
    };
    let modulus = ELASTIC[0] / (2.0 * (1.0 - ELASTIC[1] * ELASTIC[1]));
    let hertz = 4.0 / 3.0 * modulus * radius.sqrt() * overlap.powf(1.5);
    for end in [-1.0, 1.0] {
        let position = [-end * (HALF - radius + from_end + overlap), 1e-3, 2e-3];
        let mut scene = Scene::open(HALF, vec![Grain::sphere(radius, position)]);
        scene.boundary = "p f f".into();
        let deck = Deck {
            time_step: 1e-9,
            ..sheet_deck()
        };
        for ranks in [1, 2] {
            let outcome = on_ranks(
                &engine,
                &scene,
                &deck,
                &face(end * (HALF - from_end)),
                ranks,
            );
            let [force, ..] = outcome.first().states[0].force;
            assert!(
                (force / (end * hertz) - 1.0).abs() < 1e-6,
                "{end}, {ranks} ranks: {force}"
            );
        }
    }
}

/// The hopper of the examples, with grains thrown in. Grains that collide make the rounding of a sum grow, whatever the cause: the
/// same scene on one rank, moved by 1e-13 m, shows by how much.
#[test]
fn a_hopper_differs_no_more_than_if_it_was_touched() {
    let engine = Engine::from_environment();
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/liggghts/hopper.stl");
    let mesh = fs::read_to_string(example).unwrap();
    let mut random = Random(3);
    let mut grains = vec![];
    for k in 0..36 {
        let place = [k % 3, k / 3 % 3, k / 9].map(f64::from);
        let position = [
            -8.7e-3 + 8.7e-3 * place[0],
            -8.6e-3 + 8.6e-3 * place[1],
            -2e-3 + 8.5e-3 * place[2],
        ];
        let grain = Grain {
            density: 2500.0,
            ..Grain::new([4e-3, 2e-3, 2e-3], position)
        };
        grains.push(
            grain
                .turned(random.quaternion())
                .moving([0.0, 0.0, -1.0 - 0.5 * place[2]]),
        );
    }
    let scene = Scene {
        low: [-0.03, -0.03, -0.06],
        high: [0.03, 0.03, 0.06],
        ..Scene::open(1.0, grains)
    };
    let mut moved = scene.clone();
    for grain in &mut moved.grains {
        grain.position[0] += 1e-13;
    }
    let deck = Deck {
        time_step: 2e-5,
        steps: 700,
        dump_every: 50,
        fixes: vec!["fix weight all gravity 9.81 vector 0 0 -1".into()],
        ..sheet_deck()
    };
    let one = on_ranks(&engine, &scene, &deck, &mesh, 1);
    let directory = fresh_directory("moved");
    fs::write(directory.join("sheet.stl"), &mesh).unwrap();
    let shifted = run_in(&engine, &directory, &moved, &deck, 1);
    let four = on_ranks(&engine, &scene, &deck, &mesh, 4);
    for ((p, q), r) in one.frames.iter().zip(&four.frames).zip(&shifted.frames) {
        println!(
            "step {}: four ranks {:.1e}, one rank moved by 1e-13 m {:.1e}",
            p.step,
            difference(q, p),
            difference(r, p)
        );
    }
    let met = one
        .last()
        .states
        .iter()
        .filter(|s| s.velocity[0].hypot(s.velocity[1]) > 0.05)
        .count();
    println!("{met} of 36 grains were turned aside");
    assert!(met > 18);
    let [ranks, moved] = [&four, &shifted].map(|o| difference(o.last(), one.last()));
    assert!(ranks < moved && moved < 1e-6);
}
