// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do cylinders, cones, spheres and blocks push grains as they should? The reference is that of `tests/support/engines/curved_walls.rs`.

use crate::engines::curved_walls::{
    ball, cone, energy, errors, flat, shapes, surface, tolerance, touching_once, touching_twice,
    Wall, AXIS_Z, MODULUS, POISSON,
};
use crate::harness::{kinetic_energy, run, Deck, Engine, Grain, Scene};
use crate::shapes::{add, dot, scale, sub, unit, Random, Vector};

fn region(words: &str) -> Vec<String> {
    vec![format!("region place {words}")]
}

fn walls() -> Vec<Wall> {
    let wall = |name, commands: Vec<String>, words: &str, surfaces| Wall {
        name,
        commands,
        words: words.into(),
        surfaces,
    };
    let mut walls = vec![
        wall("in a cylinder", vec![], "zcylinder 1", vec![cone(0.0, 1.0)]),
        wall(
            "on a cylinder",
            vec![],
            "zcylinder 1",
            vec![cone(0.0, -1.0)],
        ),
        wall(
            "in a cylinder's region",
            region("cylinder z 0 0 1 -8 8"),
            "region place",
            vec![cone(0.0, 1.0)],
        ),
        wall(
            "on a cylinder's region",
            region("cylinder z 0 0 1 -8 8 side out"),
            "region place",
            vec![cone(0.0, -1.0)],
        ),
        wall(
            "in a cone",
            region("cone z 0 0 0.4 2.2 -2 4"),
            "region place",
            vec![cone(0.3, 1.0)],
        ),
        wall(
            "on a cone",
            region("cone z 0 0 0.4 2.2 -2 4 side out"),
            "region place",
            vec![cone(0.3, -1.0)],
        ),
        wall(
            "in a sphere",
            region("sphere 0 0 0 1"),
            "region place",
            vec![ball(1.0)],
        ),
        wall(
            "on a sphere",
            region("sphere 0 0 0 1 side out"),
            "region place",
            vec![ball(-1.0)],
        ),
        wall(
            "in a block",
            region("block -1 1 -1 1 INF INF"),
            "region place",
            (0..4)
                .map(|k: usize| {
                    let sign = if k.is_multiple_of(2) { -1.0 } else { 1.0 };
                    surface(move |p| sign * p[k / 2] - 1.0, flat)
                })
                .collect(),
        ),
        wall(
            "on a region's plane",
            region("plane 0 0 -1 1 2 2"),
            "region place",
            vec![surface(
                |p| -dot(add(p, AXIS_Z), [1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0]),
                flat,
            )],
        ),
    ];
    walls.extend(shapes());
    walls
}

fn forces(engine: &Engine, wall: &Wall, grains: &[Grain], name: &str) -> Vec<(Vector, Vector)> {
    let scene = Scene::open(10.0, grains.to_vec());
    let mut fixes = vec!["neigh_modify exclude group all all".to_string()];
    fixes.extend(wall.commands.iter().cloned());
    fixes.push(format!(
        "fix wall all wall/gran/ellipsoid hertz {MODULUS} {POISSON} {}",
        wall.words
    ));
    let deck = Deck {
        fixes,
        before_data: vec![],
        time_step: 1e-9,
        ..Deck::new(&format!("hertz {MODULUS} {POISSON}"))
    };
    let outcome = run(engine, name, &scene, &deck, 1);
    let states = &outcome.last().states;
    states.iter().map(|s| (s.force, s.torque)).collect()
}

#[test]
fn both_versions_force_and_torque_are_those_of_the_deepest_places() {
    let engine = Engine::from_environment();
    let mut random = Random(12);
    for wall in walls() {
        let mut grains = touching_once(&wall, &mut random);
        if wall.name.starts_with("in a") {
            grains.extend(touching_twice(&mut random));
        }
        let name = format!("curved_{}", wall.name.replace([' ', '\''], "_"));
        let found = forces(&engine, &wall, &grains, &name);
        let (worst, most) = errors(&wall, &grains, &found);
        let tolerance = tolerance(&wall);
        assert!(
            worst.iter().all(|e| *e < tolerance),
            "{}: {worst:?}",
            wall.name
        );
        if wall.name.starts_with("in a") {
            assert!(most >= 2, "{}: no grain touches twice", wall.name);
        }
    }
}

/// A grain thrown at a wall without dissipation leaves with its energy, to second order in the time step.
#[test]
fn both_versions_elastic_bounces_keep_their_energy() {
    let engine = Engine::from_environment();
    for wall in walls() {
        let grain = touching_once(&wall, &mut Random(5))[3].clone();
        let pull = if wall.name.starts_with("in ") {
            1.0
        } else {
            -1.0
        };
        let out = if wall.name.contains("plane") {
            [-1.0 / 3.0, -2.0 / 3.0, -2.0 / 3.0]
        } else {
            scale(pull, unit([grain.position[0], grain.position[1], 0.0]))
        };
        let depth = energy(&grain, &wall);
        assert_eq!(depth.1, 1);
        // at rest in the wall first: what it stores it gives back
        let mass = grain.mass();
        let grain = Grain {
            position: sub(grain.position, scale(0.01, out)),
            ..grain
        };
        let speed = (8.0 * depth.0 / mass).sqrt();
        let grain = grain
            .moving(scale(speed, out))
            .spinning([3.0 * speed, -2.0 * speed, speed]);
        let time = 0.02 / speed;
        let error = |steps: f64| {
            let mut fixes = wall.commands.clone();
            fixes.push(format!(
                "fix wall all wall/gran/ellipsoid hertz {MODULUS} {POISSON} {}",
                wall.words
            ));
            let mut total = (3.0 * steps) as u64;
            loop {
                let deck = Deck {
                    fixes: fixes.clone(),
                    time_step: time / steps,
                    steps: total,
                    ..Deck::new(&format!("hertz {MODULUS} {POISSON}"))
                };
                let scene = Scene::open(10.0, vec![grain.clone()]);
                let outcome = run(&engine, "curved_bounce", &scene, &deck, 1);
                let (first, last) = (&outcome.first().states[0], &outcome.last().states[0]);
                assert_ne!(first.velocity, last.velocity, "{}: no bounce", wall.name);
                if last.force == [0.0; 3] {
                    return kinetic_energy(&grain, last) / kinetic_energy(&grain, first) - 1.0;
                }
                total += steps as u64;
                assert!(total < 100 * steps as u64, "{}: it stays", wall.name);
            }
        };
        let (coarse, fine) = (error(1000.0), error(4000.0));
        println!("{}: energy {coarse:+.1e}, {fine:+.1e}", wall.name);
        // Of a cone the law leaves out that the curvature changes along it.
        let limit = if wall.name.contains("cone") {
            1e-4
        } else {
            1e-5
        };
        assert!(coarse.abs() < 1e-4 && fine.abs() < limit, "{}", wall.name);
    }
}
