// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do solid regions hold grains that begin deep in them, or with their centres in them? The reference is the shortest way out, the least over all
//! normals of the sum of the two support functions.

use crate::curved_walls::{forces, region};
use crate::engines::curved_walls::Wall;
use crate::harness::{Engine, Grain};
use crate::shapes::{dot, length, scale, sub, surface_point, unit, unrotate, Random, Vector};

/// How far a solid reaches along a direction, from the origin, and where it does.
type Farthest = fn(Vector) -> Vector;

fn of_block(n: Vector) -> Vector {
    std::array::from_fn(|k| if n[k] > 0.0 { 1.0 } else { -1.0 })
}

/// The farther of two circles about z, of these radii at -1 and 1.
fn of_circles(n: Vector, radii: [f64; 2]) -> Vector {
    let across = n[0].hypot(n[1]).max(1e-300);
    let at = |k: usize| {
        let r = radii[k] / across;
        [n[0] * r, n[1] * r, 2.0 * k as f64 - 1.0]
    };
    let [low, high] = [at(0), at(1)];
    if dot(low, n) > dot(high, n) {
        low
    } else {
        high
    }
}

fn of_cylinder(n: Vector) -> Vector {
    of_circles(n, [1.0, 1.0])
}

fn of_cone(n: Vector) -> Vector {
    of_circles(n, [1.0, 0.4])
}

fn support(g: &Grain, n: Vector) -> f64 {
    let along = unrotate(g.quaternion, n);
    length(std::array::from_fn(|k| g.semi_axes[k] * along[k]))
}

/// How deep a grain is, along a normal out of the solid.
fn depth_along(g: &Grain, farthest: Farthest, n: Vector) -> f64 {
    support(g, n) + dot(n, sub(farthest(n), g.position))
}

#[test]
fn both_versions_solids_hold_deep_grains() {
    let engine = Engine::from_environment();
    let mut random = Random(31);
    let mut directions: Vec<Vector> = (0..8000).map(|_| random.direction()).collect();
    for k in 0..3 {
        for sign in [-1.0, 1.0] {
            let mut n = [0.0; 3];
            n[k] = sign;
            directions.push(n);
        }
    }
    for (name, words, farthest) in [
        (
            "block",
            "block -1 1 -1 1 -1 1 side out",
            of_block as Farthest,
        ),
        ("cylinder", "cylinder z 0 0 1 -1 1 side out", of_cylinder),
        ("cone", "cone z 0 0 1 0.4 -1 1 side out", of_cone),
    ] {
        let grains: Vec<Grain> = (0..1000)
            .map(|_| {
                let axes = [0; 3].map(|_| random.between(0.1, 0.4));
                let n = unit(random.direction());
                let g = Grain::new(axes, [0.0; 3]).turned(random.quaternion());
                let smallest = axes.into_iter().fold(f64::INFINITY, f64::min);
                let depth = smallest * random.between(0.05, 2.5);
                let reach = surface_point(axes, g.quaternion, scale(-1.0, n));
                let position = sub(sub(farthest(n), reach), scale(depth, n));
                Grain { position, ..g }
            })
            .collect();
        let wall = Wall {
            name: "solid",
            commands: region(words),
            words: "region place".into(),
            surfaces: vec![],
        };
        let found = forces(&engine, &wall, &grains, &format!("deep_in_{name}"));
        let (mut deep, mut within) = (0, 0);
        for (g, (force, _)) in grains.iter().zip(&found) {
            let depths = directions.iter().map(|n| depth_along(g, farthest, *n));
            let depth = depths.fold(f64::INFINITY, f64::min);
            let smallest = g.semi_axes.into_iter().fold(f64::INFINITY, f64::min);
            assert!(length(*force) > 0.0, "{name}: no contact of {g:?}");
            let is_within = directions
                .iter()
                .all(|n| dot(*n, sub(farthest(*n), g.position)) > 0.0);
            if is_within {
                // With its centre in the solid it goes out, and not by a way that leads through: deep forces are at an angle with the normal.
                let along = unit(*force);
                let leaves = directions.iter().filter(|n| dot(**n, along) > 0.0);
                let ways = leaves.map(|n| depth_along(g, farthest, *n) / dot(*n, along));
                let way = ways.fold(f64::INFINITY, f64::min);
                assert!(
                    way < 3.0 * depth,
                    "{name}: {way} of {depth}, {force:?} on {g:?}"
                );
            }
            deep += usize::from(depth > 0.6 * smallest && !is_within);
            within += usize::from(is_within);
        }
        println!("{name}: {deep} deep grains, {within} with their centres within");
        assert!(deep > 100 && within > 100, "{name}: {deep} {within}");
    }
}
