// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a wall of its own material act as a very large grain of that material does, and a rigid one as the limit?

use crate::harness::{run, Deck, Engine, Grain, Scene};
use crate::shapes::{length, sub, Random, Vector};

/// An ellipsoid that slides and turns on something at rest, of which the top is at z = 0; position of the lowest point.
fn grain(k: u64) -> Grain {
    let mut random = Random(40 + k);
    let axes = [2e-3, 1.2e-3, 0.8e-3];
    let grain = Grain::new(axes, [0.0; 3]).turned(random.quaternion());
    let low = crate::shapes::surface_point(axes, grain.quaternion, [0.0, 0.0, -1.0]);
    let position = [-low[0], -low[1], -low[2] - 4e-6];
    Grain {
        position,
        density: 2500.0,
        ..grain
    }
    .moving([0.02, -0.01, -0.01])
    .spinning([3.0, -5.0, 2.0])
}

/// Force and torque on the grain after some steps.
fn load(engine: &Engine, name: &str, scene: &Scene, deck: &Deck) -> [Vector; 2] {
    let outcome = run(engine, name, scene, deck, 1);
    let state = &outcome.last().states[0];
    [state.force, state.torque]
}

fn difference(a: &[Vector; 2], b: &[Vector; 2]) -> f64 {
    (0..2)
        .map(|k| length(sub(a[k], b[k])) / length(b[k]))
        .fold(0.0, f64::max)
}

fn on_wall(law: &str, material: &str) -> Deck {
    Deck {
        fixes: vec![format!(
            "fix floor all wall/gran/ellipsoid {law} {material} zplane 0 NULL"
        )],
        time_step: 1e-7,
        steps: 40,
        skin: 1e-4,
        ..Deck::new(law)
    }
}

/// The pair style mixes the two materials of a grain and a ball of a radius of 200 m; the wall must do the same.
#[test]
fn both_versions_a_wall_is_a_very_large_grain_of_its_material() {
    let engine = Engine::from_environment();
    let radius = 200.0;
    for (of_grain, of_wall, rest) in [
        ("hertz 1e7 0.3", "5e6 0.1", "tangential mindlin 0.5"),
        ("hertz 1e7 0.3", "3e8 0.45", "tangential tfd 0.3"),
        ("nfd 1e7 0.3 40 10", "2e7 0.2 5 70", "tangential tfd 0.5"),
        (
            "nfd 1e7 0.3 40 10",
            "4e6 0.4 300 0",
            "tangential mindlin 0.5 closure surface",
        ),
    ] {
        let name = of_grain.split(' ').next().unwrap();
        let law = format!("{of_grain} {rest}");
        for k in 0..3 {
            let mut ball = Grain::sphere(radius, [0.0, 0.0, -radius]);
            ball.kind = 2;
            let mut scene = Scene::open(0.01, vec![grain(k), ball]);
            scene.kinds = 2;
            scene.low = [-1.5 * radius; 3];
            scene.high = [1.5 * radius; 3];
            let between = Deck {
                fixes: vec!["group ball type 2".into(), "fix hold ball freeze".into()],
                time_step: 1e-7,
                steps: 40,
                skin: 1e-4,
                ..Deck::with_pair(vec![
                    "pair_style gran/ellipsoid".into(),
                    format!("pair_coeff 1 1 {law}"),
                    format!("pair_coeff 2 2 {name} {of_wall} {rest}"),
                ])
            };
            let wanted = load(&engine, "material_ball", &scene, &between);
            let deck = on_wall(&law, &format!("material {of_wall}"));
            let alone = Scene::open(0.01, vec![grain(k)]);
            let got = load(&engine, "material_wall", &alone, &deck);
            let same = load(&engine, "material_same", &alone, &on_wall(&law, ""));
            let (off, without) = (difference(&got, &wanted), difference(&same, &wanted));
            println!(
                "{law}, wall {of_wall}: off by {off:.1e}; without the material by {without:.1e}"
            );
            // the ball's curvature, and the rounding of a position at 200 m over the overlap
            assert!(off < 2e-4, "{law}, {of_wall}");
            assert!(without > 0.02);
        }
    }
}

#[test]
fn both_versions_a_rigid_wall_is_the_limit_of_a_hard_one() {
    let engine = Engine::from_environment();
    let alone = Scene::open(0.01, vec![grain(1)]);
    for (law, hard) in [
        ("hertz 1e7 0.3 tangential mindlin 0.5", "0.3"),
        ("nfd 1e7 0.3 40 10 tangential tfd 0.5", "0.3 40 10"),
    ] {
        let rigid = load(
            &engine,
            "material_rigid",
            &alone,
            &on_wall(law, "material rigid"),
        );
        let mut last = f64::INFINITY;
        for factor in [1e1, 1e2, 1e3, 1e4] {
            let words = format!("material {:e} {hard}", 1e7 * factor);
            let got = load(&engine, "material_hard", &alone, &on_wall(law, &words));
            let off = difference(&got, &rigid);
            println!("{law}, wall {factor:e} times as hard: off from rigid by {off:.2e}");
            assert!(off < 0.15 * last, "{law}: not of first order in 1/E");
            last = off;
        }
        assert!(last < 1e-3);
        // A wall of the grain's own material is what a fix without the word has.
        let same = format!("material 1e7 {hard}");
        let same = load(&engine, "material_equal", &alone, &on_wall(law, &same));
        let none = load(&engine, "material_none", &alone, &on_wall(law, ""));
        assert!(difference(&same, &none) < 1e-14);
        assert!(difference(&none, &rigid) > 0.2);
    }
}
