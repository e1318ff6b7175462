// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do force and torques of random pairs agree with the high-precision reference of `validation/reference`?

use std::fmt::Write as _;
use std::fs;

use crate::harness::{
    data, execute, fresh_directory, last_lines, parse_frames, Deck, Engine, Frame, Grain, Scene,
};
use crate::shapes::{length, sub, Vector};
use crate::support::golden::{pairs, GoldenPair, Wrench};

const TOLERANCE: f64 = 1e-9;

fn array(v: crate::support::scene::Vector) -> Vector {
    [v[0], v[1], v[2]]
}

/// Who loops over the pairs: ours, where it can, or LIGGGHTS' own, which the stresses of a step call for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Loop {
    Ours,
    Its,
}

/// All pairs in one process, `clear` between them.
fn frames(
    pairs: &[GoldenPair],
    name: &str,
    (model, settings): (&str, &str),
    by: Loop,
) -> Vec<Frame> {
    let engine = Engine::from_environment();
    let directory = fresh_directory(name);
    let mut text = String::new();
    for (k, pair) in pairs.iter().enumerate() {
        let grains = [&pair.i, &pair.j]
            .map(|b| Grain {
                kind: b.particle_type as usize,
                density: 1.0,
                ..Grain::new(b.semi_axes, b.position).turned(b.quaternion)
            })
            .to_vec();
        let scene = Scene::open(8.0, grains);
        fs::write(
            directory.join(format!("{k}.data")),
            data(&scene, "superquadric"),
        )
        .unwrap();
        let (fixes, thermo) = match by {
            Loop::Ours => (vec![], "step ke"),
            Loop::Its => (
                vec![
                    "compute stress all stress/atom".into(),
                    "compute sum all reduce sum c_stress[1]".into(),
                ],
                "step ke c_sum",
            ),
        };
        let deck = Deck {
            fixes,
            thermo: thermo.into(),
            model: model.into(),
            settings: settings.into(),
            materials: pair.materials.map(|[e, nu]| [e, nu, 0.0, 0.0]).to_vec(),
            skin: 0.1,
            time_step: 1e-12,
            ..Deck::new([0.0; 4], 0.5)
        };
        writeln!(
            text,
            "clear\n{}",
            deck.text(&scene, &format!("{k}.data"), &format!("{k}.frame"))
        )
        .unwrap();
    }
    let (success, output) = execute(&engine, &directory, &text, 1);
    assert!(
        success,
        "LIGGGHTS failed in {}:\n{}",
        directory.display(),
        last_lines(&output)
    );
    (0..pairs.len())
        .map(|k| {
            let text = fs::read_to_string(directory.join(format!("{k}.frame"))).unwrap();
            parse_frames(&text).pop().expect("no frame was written")
        })
        .collect()
}

fn hold(aspect: usize) {
    let pairs = pairs(aspect);
    let along: fn(&GoldenPair) -> Wrench = |p| p.hertz;
    let ours = "nfd tangential tfd surface ellipsoid";
    let complete: fn(&GoldenPair) -> Wrench = |p| p.conservative;
    let hertz = "hertz tangential history surface ellipsoid";
    for (model, settings, by, of) in [
        (ours, "conservative off", Loop::Ours, along),
        (ours, "conservative on", Loop::Ours, complete),
        (ours, "conservative on", Loop::Its, complete),
        (hertz, "", Loop::Its, along),
    ] {
        let name = format!("{aspect} {model} {settings} {by:?}").replace(' ', "_");
        let frames = frames(&pairs, &name, (model, settings), by);
        let (mut worst, mut largest, mut failures) = (0.0f64, 0.0f64, vec![]);
        for (pair, frame) in pairs.iter().zip(&frames) {
            let wrench = of(pair);
            let [i, j] = [&frame.states[0], &frame.states[1]];
            let (f, ti, tj) = (
                array(wrench.force),
                array(wrench.torque_i),
                array(wrench.torque_j),
            );
            let size = length(f);
            let arm = [pair.i.semi_axes, pair.j.semi_axes]
                .concat()
                .into_iter()
                .fold(0.0, f64::max);
            let extent = [pair.i.position, pair.j.position]
                .concat()
                .into_iter()
                .fold(arm, |m, x| m.max(x.abs()));
            let allowed = TOLERANCE.max(8.0 * f64::EPSILON * extent / pair.penetration);
            let torque = |got: Vector, wanted: Vector| {
                length(sub(got, wanted)) / length(wanted).max(1e-3 * size * arm)
            };
            let error = (length(sub(j.force, f)) / size)
                .max(torque(i.torque, ti))
                .max(torque(j.torque, tj));
            worst = worst.max(error / allowed);
            if allowed == TOLERANCE {
                largest = largest.max(error);
            }
            if !(error <= allowed) {
                failures.push(format!(
                    "case {}: {error:.2e}, allowed {allowed:.2e}",
                    pair.case
                ));
            }
        }
        println!(
            "{} pairs of aspect ratio up to {aspect}, {model} {settings}, {by:?} loop: largest error {largest:.1e} where rounding permits {TOLERANCE:.0e}; largest share of the allowance {worst:.2}",
            pairs.len()
        );
        assert!(failures.is_empty(), "{}", failures.join("\n"));
    }
}

#[test]
fn golden_pairs_aspect_10() {
    hold(10);
}

#[test]
fn golden_pairs_aspect_100() {
    hold(100);
}

#[test]
fn golden_pairs_aspect_1000() {
    hold(1000);
}
