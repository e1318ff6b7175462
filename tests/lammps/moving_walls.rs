// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do grains follow walls that move and turn, over any ranks and restarts?

use crate::harness::{
    attempt_in, largest_difference, last_lines, run, Deck, Engine, Frame, Grain, Scene,
};
use crate::shapes::{dot, rotate, Random};

const LAW: &str = "nfd 1e6 0.3 20 20 tangential tfd 0.5";
const PERIOD: f64 = 0.4;

/// Forty grains in a drum about x of radius 0.03, ends at -0.02 and 0.02.
fn load() -> Scene {
    let mut random = Random(7);
    let grains = (0..40)
        .map(|k| {
            let place = [k % 4, k / 4 % 5, k / 20].map(|c| c as f64);
            Grain {
                density: 2500.0,
                ..Grain::new(
                    [4e-3, 2.5e-3, 2e-3],
                    [
                        -0.0135 + 9e-3 * place[0],
                        -0.018 + 9e-3 * place[1],
                        -0.013 + 9e-3 * place[2],
                    ],
                )
            }
            .turned(random.quaternion())
        })
        .collect();
    Scene::open(0.04, grains)
}

/// The three ways of a deck to the same turning drum.
fn drums() -> [(&'static str, Vec<String>); 3] {
    let rotate = format!("rotate 0 0 0 1 0 0 {PERIOD}");
    let cylinder = "cylinder x 0 0 0.03 -0.02 0.02";
    [
        (
            "cylinder and planes",
            vec![
                format!("fix shell all wall/gran/ellipsoid {LAW} xcylinder 0.03 {rotate}"),
                format!("fix ends all wall/gran/ellipsoid {LAW} xplane -0.02 0.02 {rotate}"),
            ],
        ),
        (
            "region",
            vec![
                format!("region drum {cylinder}"),
                format!("fix shell all wall/gran/ellipsoid {LAW} region drum {rotate}"),
            ],
        ),
        (
            "region that turns",
            vec![
                format!("variable angle equal 2*PI*step*dt/{PERIOD}"),
                format!("region drum {cylinder} rotate v_angle 0 0 0 1 0 0"),
                format!("fix shell all wall/gran/ellipsoid {LAW} region drum"),
            ],
        ),
    ]
}

fn deck(walls: &[String], steps: u64) -> Deck {
    let mut fixes = walls.to_vec();
    fixes.push("fix fall all gravity 9.81 vector 0 0 -1".into());
    Deck {
        fixes,
        time_step: 2e-5,
        steps,
        skin: 1e-3,
        ..Deck::new(LAW)
    }
}

fn aside(frame: &Frame) -> f64 {
    let sum: f64 = frame.states.iter().map(|s| s.position[1]).sum();
    sum / frame.states.len() as f64
}

#[test]
fn both_versions_a_turning_drum_is_the_same_in_all_words_and_on_all_ranks() {
    let engine = Engine::from_environment();
    let scene = load();
    let mut first: Option<Frame> = None;
    for (name, walls) in drums() {
        let outcome = run(&engine, "drum", &scene, &deck(&walls, 2500), 1);
        let last = outcome.last().clone();
        let side = aside(&last);
        println!("{name}: mean y {side:.6}");
        for s in &last.states {
            let [x, y, z] = s.position;
            assert!(
                x.abs() < 0.02 && y.hypot(z) < 0.03,
                "{name}: a grain has left"
            );
        }
        assert!(
            side.abs() > 1e-3,
            "{name}: the load does not lean to the side: {side}"
        );
        let spread = run(&engine, "drum_ranks", &scene, &deck(&walls, 800), 4);
        let alone = run(&engine, "drum_alone", &scene, &deck(&walls, 800), 1);
        let (position, velocity) = largest_difference(spread.last(), alone.last());
        println!("{name}: four ranks beside one: position {position:.1e}, velocity {velocity:.1e}");
        assert!(position < 1e-9 && velocity < 1e-6, "{name}");
        if let Some(first) = &first {
            let (position, _) = largest_difference(alone.last(), first);
            println!("{name}: beside the first: {position:.1e}");
            assert!(position < 1e-6, "{name}");
        } else {
            first = Some(alone.last().clone());
        }
    }
}

#[test]
fn both_versions_a_turning_drum_goes_on_after_a_restart() {
    let engine = Engine::from_environment();
    let scene = load();
    for (name, walls) in drums() {
        let whole = Deck {
            runs: vec!["run 700".into(), "run 700".into()],
            ..deck(&walls, 1400)
        };
        let whole = run(&engine, "drum_whole", &scene, &whole, 1);
        let half = Deck {
            runs: vec!["run 700".into(), "write_restart middle.restart".into()],
            ..deck(&walls, 700)
        };
        let half = run(&engine, "drum_half", &scene, &half, 1);
        let second = Deck {
            pair: vec![],
            source: vec!["read_restart middle.restart".into()],
            ..deck(&walls, 700)
        };
        // onto more ranks: what is remembered goes along
        let restarted = attempt_in(&engine, half.directory, &scene, &second, 2);
        assert!(restarted.success, "{}", last_lines(&restarted.output));
        let (position, velocity) = largest_difference(restarted.last(), whole.last());
        println!("{name}: restart beside two runs: {position:.1e}, {velocity:.1e}");
        assert!(position < 1e-9 && velocity < 1e-6, "{name}");
    }
}

/// A grain that is carried around by a plate keeps its place on it: nothing creeps, and friction turns with the plate.
#[test]
fn both_versions_a_turntable_carries_a_grain() {
    let engine = Engine::from_environment();
    let (rate, place, half_axis) = (2.0 * std::f64::consts::PI / PERIOD, 0.02, 4e-3);
    let law = "nfd 1e6 0.3 200 200 tangential tfd 0.9";
    let grain = Grain {
        density: 2500.0,
        ..Grain::new([6e-3, 5e-3, half_axis], [place, 0.0, half_axis - 2e-5])
    }
    .moving([0.0, rate * place, 0.0])
    .spinning([0.0, 0.0, rate]);
    // two turns
    let steps = 40_000;
    let time_step = 2.0 * PERIOD / steps as f64;
    let deck = Deck {
        fixes: vec![
            format!(
                "fix table all wall/gran/ellipsoid {law} zplane 0 NULL rotate 0 0 0 0 0 1 {PERIOD}"
            ),
            "fix fall all gravity 19.62 vector 0 0 -1".into(),
        ],
        time_step,
        steps,
        dump_every: steps / 8,
        skin: 1e-3,
        ..Deck::new(law)
    };
    let outcome = run(
        &engine,
        "turntable",
        &Scene::open(0.05, vec![grain]),
        &deck,
        1,
    );
    let settled = &outcome.frames[4];
    let last = outcome.last();
    let on_table = |f: &Frame| {
        let (sin, cos) = (rate * f.step as f64 * time_step).sin_cos();
        let [x, y, _] = f.states[0].position;
        let axis = rotate(f.states[0].quaternion, [1.0, 0.0, 0.0]);
        let turned = dot(axis, [cos, sin, 0.0]);
        ([cos * x + sin * y, cos * y - sin * x], turned)
    };
    let ((a, _), (b, turned)) = (on_table(settled), on_table(last));
    let moved = (b[0] - a[0]).hypot(b[1] - a[1]);
    let out = (b[0] - place).hypot(b[1]);
    println!("in the second turn it moved by {moved:.1e} m, from its place {out:.1e} m; axis along the table {turned:.9}");
    assert!(moved < 1e-7 && out < 1e-4 && turned > 1.0 - 1e-6);
}
