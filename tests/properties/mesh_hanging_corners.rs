// SPDX-License-Identifier: MIT OR Apache-2.0
//! Meshes whose triangles do not meet edge to edge, as many programs write them: corners of some lie on sides of others. Does a grain feel what it
//! feels on the same surface in few triangles that do, in double precision, and in the single precision of a file?

use crate::faceted_walls::Felt;
use crate::mesh_corners::loaded;
use crate::mesh_divisions::{difference, in_single_precision, law, visit_floors};
use crate::support::random::Stream;
use crate::support::scene::{body, vector, Rotation, Vector};
use ellgran::contact::{prepare_body, Body, Laws, Step};
use ellgran::geometry::triangles::Triangle;
use ellgran::simd::InstructionSet;
use ellgran::vector::Vector3;
use ellgran::walls::{compute_wall, flatten_triangles, Mesh, Motion, Wall, WallInput, WallOutput};
use std::iter::empty;

fn felt_at(wall: &mut Wall, laws: &Laws, b: &Body) -> Felt {
    let largest = b.semi_axes.iter().copied().fold(0.0, f64::max);
    let centre = Vector3::from_array(b.position);
    let near = wall.find_near(&Motion::REST, 1, |_| Some((centre, largest)));
    let near: Vec<_> = near
        .iter()
        .map(|_| prepare_body(b, None).unwrap())
        .collect();
    let (mut forces, mut torques) = ([[0.0; 3]], [[0.0; 3]]);
    let length = wall.histories(laws).length();
    let load = compute_wall(
        wall,
        &WallInput {
            laws,
            wall_type: 1,
            near: &near,
            motion: &Motion::REST,
            step: &Step {
                time_step: 1e-9,
                advance_history: true,
            },
            instruction_set: InstructionSet::Scalar,
        },
        &mut WallOutput {
            acts_on: &|_| true,
            histories: &mut vec![0.0; length],
            forces: &mut forces,
            torques: &mut torques,
        },
        None,
    )
    .unwrap();
    Felt {
        energy: 0.0,
        force: vector(Vector3::from_array(forces[0])),
        torque: vector(Vector3::from_array(torques[0])),
        contacts: load.contacts,
    }
}

/// On a mesh, and on triangles that an engine lends, all of them near.
fn on_surface(laws: &Laws, b: &Body, triangles: &[Triangle]) -> [Felt; 2] {
    let mut mesh = Wall::new();
    mesh.add_mesh(Mesh::new(triangles.to_vec()).expect("corners in range"));
    assert_eq!(mesh.triangles().count(), triangles.len());
    let mut lent = Wall::new();
    let near: Vec<u32> = (0..triangles.len() as u32).collect();
    let all = lent.lent_triangles();
    all.set(
        triangles.iter().copied(),
        empty(),
        empty(),
        &[0, near.len()],
        &near,
    )
    .expect("corners in range");
    [mesh, lent].map(|mut wall| felt_at(&mut wall, laws, b))
}

/// The place on an edge that is the same from both of its ends.
fn on_edge(a: Vector3, b: Vector3, steps: u32, of: u32) -> Vector3 {
    let [p, q] = [a, b].map(Vector3::to_array);
    let (a, b, steps) = if p < q {
        (a, b, steps)
    } else {
        (b, a, of - steps)
    };
    match steps {
        0 => a,
        _ if steps == of => b,
        _ => a + (b - a) * (f64::from(steps) / f64::from(of)),
    }
}

/// A triangle with each side in so many parts.
fn in_parts([a, b, c]: Triangle, parts: u32) -> Vec<Triangle> {
    let at = |i: u32, j: u32| match (i, j, parts - i - j) {
        (i, 0, _) => on_edge(a, b, i, parts),
        (0, j, _) => on_edge(a, c, j, parts),
        (_, j, 0) => on_edge(b, c, j, parts),
        (i, j, _) => {
            let share = |k: u32| f64::from(k) / f64::from(parts);
            a + (b - a) * share(i) + (c - a) * share(j)
        }
    };
    let cells = (0..parts).flat_map(|i| (0..parts - i).map(move |j| (i, j)));
    cells
        .flat_map(|(i, j)| {
            let lower = [at(i, j), at(i + 1, j), at(i, j + 1)];
            let upper =
                (i + j + 2 <= parts).then(|| [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            [Some(lower), upper].into_iter().flatten()
        })
        .collect()
}

/// Each triangle with its sides in one to four parts, whatever its neighbours have.
fn unevenly_divided(stream: &mut Stream, wall: &[Triangle]) -> Vec<Triangle> {
    let parts = |s: &mut Stream| s.uniform(1.0, 5.0) as u32;
    wall.iter()
        .flat_map(|t| in_parts(*t, parts(stream)))
        .collect()
}

/// Of corners on one side, how near they may be to each other, as a part of its length: from nearer ones on to a corner opposite go needles, which the
/// search leaves out or sees as an edge.
const APART: f64 = 0.01;

/// Where a triangle is cut.
#[derive(Clone, Copy, PartialEq)]
enum Cuts {
    /// From its longest side, near the middle, to the corner opposite.
    Across,
    /// From any side, from a tenth of it on: into needles.
    IntoNeedles,
}

/// Some triangles cut from a side to the corner opposite, some of the parts again, and so on.
fn cut_anywhere(stream: &mut Stream, wall: &[Triangle], cuts: Cuts) -> Vec<Triangle> {
    let mut left: Vec<(Triangle, u32)> = wall.iter().map(|t| (*t, 0)).collect();
    let mut corners: Vec<Vector3> = wall.iter().flatten().copied().collect();
    let mut all = Vec::new();
    while let Some((t, times)) = left.pop() {
        if times == 4 || stream.uniform(0.0, 1.0) < 0.4 {
            all.push(t);
            continue;
        }
        let length = |m: &usize| (t[(m + 2) % 3] - t[(m + 1) % 3]).norm();
        let longest = (0..3).max_by(|m, n| length(m).total_cmp(&length(n)));
        let (side, shares) = match cuts {
            Cuts::Across => (longest.expect("three sides"), [0.35, 0.65]),
            Cuts::IntoNeedles => (stream.uniform(0.0, 3.0) as usize % 3, [0.1, 0.9]),
        };
        let [a, b, c] = [0, 1, 2].map(|m| t[(side + m) % 3]);
        let least = APART * (c - b).norm();
        let is_free = |p: &Vector3| corners.iter().all(|q| (*q - *p).norm() > least);
        let between = (0..20)
            .map(|_| b + (c - b) * stream.uniform(shares[0], shares[1]))
            .find(is_free);
        let Some(between) = between else {
            all.push(t);
            continue;
        };
        corners.push(between);
        left.push(([a, b, between], times + 1));
        left.push(([a, between, c], times + 1));
    }
    all
}

/// Rows along a line, each in two triangles, and the same in bricks whose joints are not those of the rows beside them; turned about the vertical, up to 0.3 radii
/// wide or up to two.
fn rows_and_bricks(stream: &mut Stream, width: f64, rough: f64) -> [Vec<Triangle>; 2] {
    let rows = ((4.0 / width) as usize).clamp(4, 24);
    let (sin, cos) = stream.uniform(0.0, 6.0).sin_cos();
    let away = [0; 2].map(|_| stream.uniform(-0.5, 0.5));
    let profile: Vec<[f64; 2]> = (0..=rows)
        .map(|k| {
            let x = k as f64 - 0.5 * rows as f64 + stream.uniform(-0.2, 0.2);
            [width * x, rough * width * stream.uniform(-1.0, 1.0)]
        })
        .collect();
    let at = |k: usize, y: f64| {
        let [x, z] = profile[k];
        Vector3::new(cos * x - sin * y + away[0], sin * x + cos * y + away[1], z)
    };
    let rectangle = |k: usize, y: [f64; 2]| {
        let [a, b, c, d] = [at(k, y[0]), at(k + 1, y[0]), at(k + 1, y[1]), at(k, y[1])];
        [[a, b, c], [a, c, d]]
    };
    let mut all = [Vec::new(), Vec::new()];
    for k in 0..rows {
        all[0].extend(rectangle(k, [-4.0, 4.0]));
        let length = width * stream.uniform(0.7, 3.0);
        let mut from = -4.0;
        let mut to = from + length * stream.uniform(0.2, 1.0);
        while from < 4.0 {
            all[1].extend(rectangle(k, [from, to.min(4.0)]));
            (from, to) = (to, to + length);
        }
    }
    all
}

/// The height of the thinnest triangle over its longest side.
fn thinnest(wall: &[Triangle]) -> f64 {
    let of = |t: &Triangle| {
        let side = |m: usize| (t[(m + 1) % 3] - t[m]).norm();
        let longest = (0..3).map(side).fold(0.0, f64::max);
        (t[1] - t[0]).cross(t[2] - t[0]).norm() / (longest * longest)
    };
    wall.iter().map(of).fold(1.0, f64::min)
}

/// Grains on rows of bricks, and on the rows.
fn visit_bricks(seed: u64, mut found: impl FnMut(&Laws, &Body, &[Triangle], &[Triangle])) {
    let laws = law();
    let mut stream = Stream::new(seed);
    for width in [0.15, 0.3, 0.45, 0.7, 1.0, 2.0] {
        for rough in [0.02, 0.1, 0.4] {
            for case in 0..5 {
                let axes = match case % 2 {
                    0 => [1.0; 3],
                    _ => stream.semi_axes(5.0),
                };
                let least = axes.iter().copied().fold(1.0, f64::min);
                let turn: Rotation = stream.rotation();
                let depth = stream.log_uniform(1e-3, 3e-2) * least;
                let [rows, bricks] = rows_and_bricks(&mut stream, width, rough);
                let [x, y] = [0, 1].map(|_| stream.uniform(-width, width));
                let over = body(axes, Vector::new(x, y, 0.0), turn);
                let b = loaded(&laws, over, &rows, 0.1 + rough * width, depth);
                found(&laws, &b, &rows, &bricks);
            }
        }
    }
}

/// Of edges at smaller angles, in radians, the corners do not always find back to their planes from single precision.
const LEAST_FOLD: f64 = 0.002;

/// All scenes: a grain, a surface, and the same with corners on sides.
fn visit_all(seed: u64, mut found: impl FnMut(&str, &Laws, &Body, &[Triangle], &[Triangle])) {
    let law = law();
    let mut stream = Stream::new(seed + 1);
    visit_floors(seed, |_, _, wall, b| {
        let finer = unevenly_divided(&mut stream, wall);
        found("in one to four parts", &law, b, wall, &finer);
        let finer = cut_anywhere(&mut stream, wall, Cuts::Across);
        found("cut anywhere", &law, b, wall, &finer);
        let finer = cut_anywhere(&mut stream, wall, Cuts::IntoNeedles);
        found("cut into needles", &law, b, wall, &finer);
    });
    visit_bricks(seed + 2, |laws, b, rows, bricks| {
        found("bricks", laws, b, rows, bricks);
    });
}

/// Whether the force on a surface changes at once where the grain goes up or down by so much, as it may where more than three wide triangles meet at a
/// corner, with convex and concave edges: there rounding decides.
fn is_at_jump(laws: &Laws, b: &Body, wall: &[Triangle], by: f64) -> bool {
    let [below, above] = [-by, by].map(|by| {
        let mut moved = *b;
        moved.position[2] += by;
        let [mesh, _] = on_surface(laws, &moved, wall);
        mesh
    });
    difference(&below, &above) > 1e-3
}

#[test]
fn corners_on_sides_of_other_triangles_change_nothing() {
    let (mut worst, mut count, mut jumps) = (0.0f64, 0, 0);
    let mut with_needles = 0;
    for seed in [101, 501, 601] {
        visit_all(seed, |kind, laws, b, wall, finer| {
            with_needles += usize::from(thinnest(finer) < 0.005);
            if is_at_jump(laws, b, wall, 1e-9) {
                jumps += 1;
                return;
            }
            let [mesh, lent] = on_surface(laws, b, wall);
            // 0 where the grain only comes near.
            let apart = (mesh.force - lent.force).norm();
            assert!(apart <= 1e-12 * mesh.force.norm());
            for own in on_surface(laws, b, finer) {
                let own = difference(&own, &mesh);
                if own > 1e-9 {
                    println!("{own:.1e} {kind}");
                }
                worst = worst.max(own);
                count += 1;
            }
        });
    }
    println!(
        "{count} divisions change the force by up to {worst:.1e} of it; {jumps} others at jumps; {with_needles} surfaces with triangles 200 times as long as wide"
    );
    assert!(worst < 1e-9 && 50 * jumps < count, "{worst} {jumps}");
    assert!(with_needles > 100);
}

/// The least angle of edges at which two triangles meet.
fn least_fold(wall: &[Triangle]) -> f64 {
    let normal = |t: &Triangle| (t[1] - t[0]).cross(t[2] - t[0]).normalised();
    let mut least = f64::INFINITY;
    for (k, t) in wall.iter().enumerate() {
        for q in &wall[..k] {
            let sine = normal(t).cross(normal(q)).norm();
            if t.iter().filter(|p| q.contains(p)).count() == 2 && sine > 1e-6 {
                least = least.min(sine);
            }
        }
    }
    least
}

/// The undivided surface has the corners where the reading of the file has put them. Those of planes that meet at small angles go far, and such as would go
/// farther than a twentieth of an edge stay where they were and leave their planes uneven.
#[test]
fn nor_in_the_single_precision_of_a_file() {
    let (mut worst, mut count, mut farthest) = (0.0f64, 0, 0.0f64);
    let (mut jumps, mut flat) = (0, 0);
    for seed in [103, 301] {
        visit_all(seed, |kind, laws, b, wall, finer| {
            if least_fold(wall) < LEAST_FOLD {
                flat += 1;
                return;
            }
            let mut read = in_single_precision(finer);
            let moved = flatten_triangles(&mut read).expect("corners in range");
            farthest = farthest.max(moved);
            let place = |p: Vector3| {
                let mut all = finer.iter().flatten().zip(read.iter().flatten());
                *all.find(|(given, _)| **given == p).expect("a corner").1
            };
            let whole: Vec<Triangle> = wall.iter().map(|t| t.map(place)).collect();
            if is_at_jump(laws, b, &whole, 1e-7) {
                jumps += 1;
                return;
            }
            let [expected, _] = on_surface(laws, b, &whole);
            for own in on_surface(laws, b, &read) {
                let own = difference(&own, &expected);
                if own > 1e-5 {
                    println!("{own:.1e} {kind}");
                }
                worst = worst.max(own);
                count += 1;
            }
        });
    }
    println!(
        "{count} divisions change the force by up to {worst:.1e} of it, corners moved by {farthest:.1e}; {jumps} others at jumps, {flat} with edges of \
         less than {LEAST_FOLD}"
    );
    assert!(worst < 1e-5 && 50 * jumps < count, "{worst} {jumps}");
}
