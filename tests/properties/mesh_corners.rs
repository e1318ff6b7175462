// SPDX-License-Identifier: MIT OR Apache-2.0
//! Corners of a mesh at which any number of convex and concave edges meet: does a grain of any shape pass them on any way without a
//! jump of its force and torque? Under the law that takes the curvature as fixed: the other's moment by the curvature ends where an edge's normal
//! stops turning, of which up to 1 % of the force comes at any edge or corner of an ellipsoid.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::faceted_walls::{felt, flat, on_triangles, point, support, turned, Felt};
use crate::support::random::Stream;
use crate::support::scene::{body, laws, Rotation, Vector};
use ellgran::contact::staged::WallSurface;
use ellgran::contact::{prepare_body, Body, Laws};
use ellgran::geometry::facet_shares::{Section, Share, SupportingPlane};
use ellgran::geometry::triangles::{Feature, Triangle, TriangleSearch};
use ellgran::vector::Vector3;

/// Triangles that meet at the origin, each from one ray to the next; rays in the order of their angle.
fn fan(rays: &[[f64; 2]]) -> Vec<Triangle> {
    let end = |[angle, slope]: [f64; 2]| {
        let (sin, cos) = angle.sin_cos();
        point(40.0 * cos, 40.0 * sin, 40.0 * slope)
    };
    (0..rays.len())
        .map(|k| {
            [
                point(0.0, 0.0, 0.0),
                end(rays[k]),
                end(rays[(k + 1) % rays.len()]),
            ]
        })
        .collect()
}

/// Random rays, no two closer than 0.3 or farther apart than 2.6.
fn rays(stream: &mut Stream, count: usize, steepness: f64) -> Vec<[f64; 2]> {
    loop {
        let mut angles: Vec<f64> = (0..count).map(|_| stream.uniform(0.0, TAU)).collect();
        angles.sort_by(f64::total_cmp);
        let is_fit = (0..count).all(|k| {
            let gap = (angles[(k + 1) % count] - angles[k]).rem_euclid(TAU);
            gap > 0.3 && gap < 2.6
        });
        if is_fit {
            let slope = |angle| [angle, stream.uniform(-steepness, steepness)];
            return angles.into_iter().map(slope).collect();
        }
    }
}

/// How many edges of a fan are convex, and how many concave.
fn bends(rays: &[[f64; 2]]) -> [usize; 2] {
    let end = |k: usize| {
        let [angle, slope] = rays[k % rays.len()];
        Vector::new(angle.cos(), angle.sin(), slope)
    };
    let mut counts = [0; 2];
    for k in 0..rays.len() {
        // the volume is positive where the middle one is below the plane through its neighbours
        let volume = end(k).cross(&end(k + 1)).dot(&end(k + 2));
        counts[usize::from(volume > 0.0)] += 1;
    }
    counts
}

fn deepest(b: &Body, wall: &[Triangle]) -> f64 {
    let i = prepare_body(b, None).unwrap();
    let mut search = TriangleSearch::default();
    search.touch(&i.body, i.position, wall);
    let depths = search.contacts().iter().map(|c| c.penetration);
    depths.fold(0.0, f64::max)
}

/// The body over a place, so high that its deepest contact is so deep: let down until it touches.
fn pressed(mut b: Body, wall: &[Triangle], depth: f64) -> Body {
    let mut high = 3.0;
    loop {
        b.position[2] = high - 0.5 * depth;
        if deepest(&b, wall) > 0.0 || high < -2.0 {
            break;
        }
        high -= 0.5 * depth;
    }
    let mut low = high - 2.5 * depth;
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        b.position[2] = middle;
        if deepest(&b, wall) > depth {
            low = middle;
        } else {
            high = middle;
        }
    }
    b
}

struct Way {
    from: Body,
    to: Body,
    middle: Body,
    turn: Vector,
}

impl Way {
    fn at(&self, t: f64) -> Body {
        let mut b = self.middle;
        let (p, q) = (0.5 * t * (t - 1.0), 0.5 * t * (t + 1.0));
        for k in 0..3 {
            b.position[k] = p * self.from.position[k]
                + (1.0 - t * t) * self.middle.position[k]
                + q * self.to.position[k];
        }
        for k in 0..3 {
            b = turned(&b, k, self.turn[k] * t);
        }
        b
    }
}

/// The change of force and torque, in the largest force on the way, that is left between two places of the way closer and closer to
/// each other; `None` if the body is too deep in the wall somewhere.
fn jump(laws: &Laws, wall: &[Triangle], way: &Way, deep: f64) -> Option<f64> {
    let count = 200;
    let (mut from, mut to) = (-1.0, 1.0);
    let mut largest = 0.0f64;
    let mut left = 0.0;
    for level in 0..4 {
        let place = |k: usize| from + (to - from) * k as f64 / count as f64;
        if level == 0 && (0..=count).any(|k| deepest(&way.at(place(k)), wall) > deep) {
            return None;
        }
        let felt: Vec<Felt> = (0..=count)
            .map(|k| on_triangles(laws, &way.at(place(k)), wall))
            .collect();
        largest = felt.iter().fold(largest, |m, f| m.max(f.force.norm()));
        // the largest semi-axis is 1
        let change = |k: usize| {
            let [a, b] = [&felt[k], &felt[k + 1]];
            (a.force - b.force).norm().max((a.torque - b.torque).norm())
        };
        let worst = (0..count)
            .max_by(|a, b| change(*a).total_cmp(&change(*b)))
            .unwrap();
        left = change(worst);
        (from, to) = (place(worst), place(worst + 1));
    }
    Some(left / largest)
}

/// Overlaps in the smallest semi-axis, from and to.
const SHALLOW: [f64; 2] = [0.005, 0.03];
const DEEP: [f64; 2] = [0.05, 0.3];

/// A random way over a corner, and how deep a body may be on it.
fn way_over(
    stream: &mut Stream,
    wall: &[Triangle],
    steepness: f64,
    is_ball: bool,
    [least_depth, most_depth]: [f64; 2],
) -> (Way, f64) {
    let axes = if is_ball {
        [1.0; 3]
    } else {
        stream.semi_axes(5.0)
    };
    let least = axes.iter().copied().fold(1.0, f64::min);
    let turn = stream.rotation();
    let depth = stream.uniform(least_depth, most_depth) * least;
    let s = support(axes, turn, -Vector::z());
    let over = |[x, y]: [f64; 2]| {
        let b = body(axes, Vector::new(x - s.x, y - s.y, 0.0), turn);
        pressed(b, wall, depth)
    };
    let reach = (2.0 * depth).sqrt() + steepness;
    let [p, q] = [0, 1].map(|_| {
        let (sin, cos) = stream.uniform(0.0, TAU).sin_cos();
        let r = reach * stream.uniform(0.2, 1.0);
        [r * cos, r * sin]
    });
    let middle = [0, 1].map(|_| stream.uniform(-0.3, 0.3) * reach);
    let way = Way {
        from: over(p),
        to: over(q),
        middle: over(middle),
        turn: stream.direction() * stream.uniform(0.0, 0.05),
    };
    (way, 2.0 * most_depth * least)
}

fn steepness(rays: &[[f64; 2]]) -> f64 {
    rays.iter().fold(0.0f64, |m, r| m.max(r[1].abs()))
}

/// What is left on a random way over a corner.
fn passed(
    laws: &Laws,
    stream: &mut Stream,
    rays: &[[f64; 2]],
    is_ball: bool,
    depths: [f64; 2],
) -> Option<f64> {
    let wall = fan(rays);
    let (way, deep) = way_over(stream, &wall, steepness(rays), is_ball, depths);
    jump(laws, &wall, &way, deep)
}

/// Of these triangles the one whose plane holds all that a body touches, if it lies on one face alone, clear of its edges.
fn lone_face(b: &Body, wall: &[Triangle]) -> Option<Triangle> {
    let i = prepare_body(b, None).unwrap();
    let mut search = TriangleSearch::default();
    let mut lone = None;
    for t in wall {
        search.touch(&i.body, i.position, &[*t]);
        let [found] = search.contacts() else {
            continue;
        };
        if found.feature != Feature::Face || lone.is_some() {
            return None;
        }
        let section = |point: Vector3, normal: Vector3| {
            let point = point - i.position;
            Section::new(&i.body, &SupportingPlane { point, normal })
        };
        let own = section(found.point, found.normal);
        for k in 0..3 {
            let [from, to, across] = [0, 1, 2].map(|m| t[(k + m) % 3]);
            let inwards = found.normal.cross(to - from).normalised();
            let turned = if inwards.dot(across - from) < 0.0 {
                -inwards
            } else {
                inwards
            };
            if own.is_cut_by(&section(from, turned)) {
                return None;
            }
        }
        lone = Some(*t);
    }
    lone
}

/// Beside corners of any kind, in the body's own size from its surface to 2 % outside. Lines in which planes meet on a face, and which are no edges of the mesh,
/// acted there as edges.
#[test]
fn a_grain_on_one_face_beside_a_corner_feels_its_plane() {
    let laws = laws(&["hertz 1e7 0.3 conservative yes"]);
    let mut stream = Stream::new(89);
    let (mut alone, mut worst) = (0, 0.0f64);
    for case in 0..1500 {
        let rays = rays(&mut stream, 3 + case % 6, [0.02, 0.1, 0.4][case / 6 % 3]);
        let wall = fan(&rays);
        let (way, _) = way_over(&mut stream, &wall, steepness(&rays), case % 4 == 0, SHALLOW);
        for k in 0..41 {
            let b = way.at(0.05 * k as f64 - 1.0);
            let i = prepare_body(&b, None).unwrap();
            let apex = i.body.to_body(-i.position);
            let unit = i.body.inverse_semi_axes.componentwise(apex).norm();
            if !(unit > 1.0 && unit < 1.02) {
                continue;
            }
            let Some(face) = lone_face(&b, &wall) else {
                continue;
            };
            let [whole, plane] = [&wall[..], &[face][..]].map(|wall| on_triangles(&laws, &b, wall));
            let off = (whole.force - plane.force).norm() / plane.force.norm();
            assert!(off < 1e-9, "case {case}, place {k}: off by {off:.1e}");
            worst = worst.max(off);
            alone += 1;
        }
    }
    println!("{alone} grains on one face alone, off its plane's force by {worst:.1e}");
    assert!(alone > 300);
}

/// Two ridges and two valleys at any angles. What is left of a change in 4e-10 of the way is rounding and the root of the way.
#[test]
fn a_grain_passes_a_saddle_without_a_jump() {
    let laws = laws(&["hertz 1e7 0.3 conservative no"]);
    let mut stream = Stream::new(67);
    let (mut worst, mut ways) = (0.0f64, 0);
    for case in 0..600 {
        let steepness = [0.02, 0.1, 0.4][case % 3];
        let rays: Vec<[f64; 2]> = (0..4)
            .map(|k| {
                let angle = FRAC_PI_2 * k as f64 + stream.uniform(-0.3, 0.3);
                let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                [angle, sign * steepness * stream.uniform(0.2, 1.0)]
            })
            .collect();
        if let Some(left) = passed(&laws, &mut stream, &rays, case % 2 == 0, SHALLOW) {
            ways += 1;
            assert!(left < 1e-3, "case {case}: {left:.1e}");
            worst = worst.max(left);
        }
    }
    println!("{ways} ways, the largest jump is {worst:.1e} of the force");
    assert!(ways > 400);
}

/// Fans of 3 to 7 triangles: all convex and all concave ones without a jump, and mixed ones but for a few; some of any kind where a body lies deep
/// (docs/theory.md says why).
#[test]
fn a_grain_passes_any_corner_on_any_way() {
    let laws = laws(&["hertz 1e7 0.3 conservative no"]);
    let mut stream = Stream::new(61);
    for (depths, cases, allowed) in [
        (SHALLOW, 1500, [0.0, 0.005, 0.002]),
        (DEEP, 400, [0.03, 0.06, 0.04]),
    ] {
        let mut left: [Vec<f64>; 3] = Default::default();
        for case in 0..cases {
            let steepness = [0.02, 0.1, 0.4][case / 5 % 3];
            let rays = rays(&mut stream, 3 + case % 5, steepness);
            let kind = match bends(&rays) {
                [_, 0] => 0,
                [0, _] => 1,
                _ => 2,
            };
            left[kind].extend(passed(&laws, &mut stream, &rays, case % 4 == 0, depths));
        }
        let shares = [1e-3, 0.1].map(|least| {
            let above = |all: &Vec<f64>| all.iter().filter(|x| **x > least).count();
            left.each_ref()
                .map(|all| above(all) as f64 / all.len() as f64)
        });
        println!(
            "overlaps {depths:?}: {:?} ways, convex, concave and mixed; jumps of more than 0.1 % in {:.3?} of them, of more than 10 % in {:.3?}",
            left.each_ref().map(Vec::len),
            shares[0],
            shares[1]
        );
        assert!(left.iter().all(|all| all.len() > 30));
        assert!(shares[0][0] <= allowed[0] && shares[0][1] <= allowed[0]);
        assert!(shares[0][2] < allowed[1] && shares[1][2] < allowed[2]);
    }
}

/// No corner pushes with much more than its triangles do, each by itself. Planes that went on beyond their convex edges pushed with many times as much in
/// rare poses.
#[test]
fn no_corner_pushes_with_more_than_its_triangles() {
    let laws = laws(&["hertz 1e7 0.3 conservative yes"]);
    let mut stream = Stream::new(97);
    let (mut poses, mut above) = (0, [0; 3]);
    for case in 0..600 {
        let steepness = [0.1, 0.4, 1.0][case / 6 % 3];
        let rays = rays(&mut stream, 3 + case % 6, steepness);
        let wall = fan(&rays);
        let depths = [SHALLOW, DEEP][case / 18 % 2];
        let (way, _) = way_over(&mut stream, &wall, steepness, case % 4 == 0, depths);
        for k in 0..41 {
            let b = way.at(0.05 * k as f64 - 1.0);
            let force = |wall: &[Triangle]| on_triangles(&laws, &b, wall).force.norm();
            let whole = force(&wall);
            let alone: f64 = wall.iter().map(|t| force(&[*t])).sum();
            let least = b.semi_axes.iter().copied().fold(f64::INFINITY, f64::min);
            // Of a face that is left just now hardly anything is felt, and little more where it is shared.
            let little = 1e7 * least.powi(2) * 1e-3 * depths[0].powf(1.5);
            poses += usize::from(alone > 0.0);
            for (count, times) in above.iter_mut().zip([3.0, 30.0, 1000.0]) {
                *count += usize::from(whole > times * (alone + little));
            }
        }
    }
    println!("of {poses} poses {above:?} with more than 3, 30 and 1000 times the force of their triangles alone");
    assert!(poses > 20_000);
    assert!(above[0] * 2000 < poses && above[1] * 10_000 < poses && above[2] == 0);
}

/// A surface of squares about the origin, each as two triangles by either diagonal, with corners that are off their places by a fifth of a square.
pub fn surface(
    stream: &mut Stream,
    squares: usize,
    size: f64,
    mut height: impl FnMut(&mut Stream, f64, f64) -> f64,
) -> Vec<Triangle> {
    let row = squares + 1;
    let corners: Vec<_> = (0..row * row)
        .map(|k| {
            let [x, y] = [k / row, k % row]
                .map(|m| size * (m as f64 - 0.5 * squares as f64 + stream.uniform(-0.2, 0.2)));
            point(x, y, height(stream, x, y))
        })
        .collect();
    (0..squares * squares)
        .flat_map(|k| {
            let (i, j) = (k / squares, k % squares);
            let at = |i: usize, j: usize| corners[i * row + j];
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            if stream.uniform(0.0, 1.0) < 0.5 {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, b, d], [b, c, d]]
            }
        })
        .collect()
}

/// The body over a place of a surface about z = 0 that is so high at most, so high that its energy is that on a plane at this depth.
pub fn loaded(laws: &Laws, b: Body, wall: &[Triangle], highest: f64, depth: f64) -> Body {
    let energy = |b: &Body, wall: &[Triangle]| on_triangles(laws, b, wall).energy;
    let i = prepare_body(&b, None).unwrap();
    let h = i.body.support(point(0.0, 0.0, -1.0)).h;
    let at = |z: f64| {
        let mut b = b;
        b.position[2] = z;
        b
    };
    let plane = [
        point(-9.0, -9.0, 0.0),
        point(9.0, -9.0, 0.0),
        point(0.0, 18.0, 0.0),
    ];
    let whole = energy(&at(h - depth), &[plane]);
    let (mut low, mut high) = (h - highest, h + highest);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if energy(&at(middle), wall) > whole {
            low = middle;
        } else {
            high = middle;
        }
    }
    at(low)
}

/// What is left on random ways over such surfaces, of which `height` makes one; triangles of 0.3 to 2 radii of a contact.
fn passed_surfaces(
    stream: &mut Stream,
    ways: usize,
    mut height: impl FnMut(&mut Stream, f64) -> Box<dyn Fn(&mut Stream, f64, f64) -> f64>,
) -> Vec<f64> {
    let laws = laws(&["hertz 1e7 0.3 conservative no"]);
    let mut left = vec![];
    for case in 0..ways {
        let axes = if case % 4 == 0 {
            [1.0; 3]
        } else {
            stream.semi_axes(5.0)
        };
        let least = axes.iter().copied().fold(1.0, f64::min);
        let turn = stream.rotation();
        let depth = stream.log_uniform(1e-3, 3e-2) * least;
        let radius = (2.0 * depth).sqrt();
        let size = [0.3, 0.6, 1.0, 2.0][case % 4] * radius;
        let height = height(stream, size);
        let wall = surface(stream, 12, size, height);
        let s = support(axes, turn, -Vector::z());
        let reach = 0.5 * size.max(radius);
        let [from, to, middle] = [0, 1, 2].map(|_| {
            let [x, y] = [0, 1].map(|_| stream.uniform(-reach, reach));
            let b = body(axes, Vector::new(x - s.x, y - s.y, 0.0), turn);
            loaded(&laws, b, &wall, 0.1, depth)
        });
        let way = Way {
            from,
            to,
            middle,
            turn: stream.direction() * stream.uniform(0.0, 0.02),
        };
        left.extend(jump(&laws, &wall, &way, 0.2 * least));
    }
    left
}

/// Of saddle-shaped surfaces of many triangles all corners have convex and concave edges. All ways over them had a jump, by
/// up to half of the force, where edges and corners acted as well.
#[test]
fn a_grain_passes_a_saddle_of_many_triangles_without_a_jump() {
    let left = passed_surfaces(&mut Stream::new(71), 16, |stream, _| {
        let [a, b] = [0, 1].map(|_| stream.log_uniform(4.0, 40.0));
        let (sin, cos) = stream.uniform(0.0, TAU).sin_cos();
        Box::new(move |_, x, y| {
            let (u, v) = (x * cos + y * sin, y * cos - x * sin);
            0.5 * (u * u / a - v * v / b)
        })
    });
    let worst = left.iter().copied().fold(0.0, f64::max);
    println!(
        "{} ways, the largest jump is {worst:.1e} of the force",
        left.len()
    );
    assert!(left.len() == 16 && worst < 1e-6);
}

/// The same of a plane of which each corner is off by up to a fiftieth of a triangle.
#[test]
fn a_grain_passes_an_uneven_floor_without_a_jump() {
    let left = passed_surfaces(&mut Stream::new(73), 16, |_, size| {
        Box::new(move |stream, _, _| 0.02 * size * stream.uniform(-1.0, 1.0))
    });
    let worst = left.iter().copied().fold(0.0, f64::max);
    println!(
        "{} ways, the largest jump is {worst:.1e} of the force",
        left.len()
    );
    assert!(left.len() == 16 && worst < 1e-6);
}

/// A saddle-shaped surface of many triangles is the curved wall that it approaches: its edges and corners pushed a grain up to three times
/// over.
#[test]
fn many_triangles_of_a_saddle_are_the_saddle() {
    let laws = laws(&["hertz 1e7 0.3 conservative yes"]);
    let mut stream = Stream::new(79);
    let depth = 0.01;
    let ball = body(
        [1.0; 3],
        Vector::new(0.0, 0.0, 1.0 - depth),
        Rotation::identity(),
    );
    for (a, b) in [(8.0, 8.0), (40.0, 40.0), (20.0, 10.0)] {
        let curved = WallSurface {
            direction: point(1.0, 0.0, 0.0),
            curvatures: [-1.0 / a, 1.0 / b],
            turning_radii: [-a, b],
            ..flat(point(0.0, 0.0, 0.0), point(0.0, 0.0, 1.0), Share::WHOLE)
        };
        let whole = felt(&laws, &ball, std::iter::once(curved)).force.z;
        for (cells, limit) in [(0.3, 0.003), (0.6, 0.008), (1.0, 0.02)] {
            let size = cells * (2.0f64 * depth).sqrt();
            let mut worst = 0.0f64;
            for _ in 0..10 {
                let off = [0, 1].map(|_| stream.uniform(-0.5, 0.5) * size);
                let mut wall = surface(&mut stream, 24, size, |_, _, _| 0.0);
                for p in wall.iter_mut().flatten() {
                    (p.x, p.y) = (p.x + off[0], p.y + off[1]);
                    p.z = 0.5 * (p.x * p.x / a - p.y * p.y / b);
                }
                let force = on_triangles(&laws, &ball, &wall).force.z;
                worst = worst.max((force / whole - 1.0).abs());
            }
            println!("radii {a} and {b}, triangles of {cells} contacts: force off by {worst:.1e}");
            assert!(worst < limit);
        }
    }
}

/// Where the triangles of a fine mesh come into reach, and within it, force and torque are the gradient of one energy.
#[test]
fn force_and_torque_at_a_fine_saddle_are_the_gradient_of_one_energy() {
    let laws = laws(&["hertz 1e7 0.3 conservative yes"]);
    let mut stream = Stream::new(83);
    // Two ridges and two valleys, of triangles as wide as a third of the grain.
    let slopes = [0.02, -0.02, 0.02, -0.02];
    let rays: Vec<[f64; 2]> = (0..4).map(|k| [FRAC_PI_2 * k as f64, slopes[k]]).collect();
    let smaller = |t: Triangle| t.map(|p| p * 0.015);
    let corner: Vec<Triangle> = fan(&rays).into_iter().map(smaller).collect();
    let (mut worst, mut parts) = ([0.0f64; 2], 0);
    for case in 0..240 {
        let axes = [[1.0, 1.0, 1.0], [1.0, 0.7, 0.6]][case / 2 % 2];
        let turn = stream.rotation();
        let depth = 0.002;
        let s = support(axes, turn, -Vector::z());
        let is_within = case % 2 == 1;
        let (wall, place) = if is_within {
            let wall = surface(&mut stream, 12, 0.05, |_, x, y| 0.05 * (x * x - y * y));
            (wall, [0, 1].map(|_| stream.uniform(-0.1, 0.1)))
        } else {
            let (sin, cos) = (FRAC_PI_2 * (case / 4) as f64 + stream.uniform(-0.1, 0.1)).sin_cos();
            let r = stream.uniform(0.1, 0.25);
            (corner.clone(), [r * cos, r * sin])
        };
        let at = body(axes, Vector::new(place[0] - s.x, place[1] - s.y, 0.0), turn);
        let b = loaded(&laws, at, &wall, 0.1, depth);
        let now = on_triangles(&laws, &b, &wall);
        parts += usize::from(now.contacts > 1);
        let h = 2e-3 * depth;
        let energy = |b: &Body| on_triangles(&laws, b, &wall).energy;
        let slope = |f: &dyn Fn(f64) -> Body| {
            let d = |k: f64| energy(&f(k * h)) - energy(&f(-k * h));
            -(45.0 * d(1.0) - 9.0 * d(2.0) + d(3.0)) / (60.0 * h)
        };
        let force = Vector::from([0, 1, 2].map(|k| {
            slope(&|by| {
                let mut b = b;
                b.position[k] += by;
                b
            })
        }));
        let torque = Vector::from([0, 1, 2].map(|k| slope(&|by| turned(&b, k, by))));
        let error = (force - now.force).norm().max((torque - now.torque).norm()) / now.force.norm();
        let kind = &mut worst[usize::from(is_within)];
        *kind = kind.max(error);
    }
    println!(
        "{parts} of 240 on several planes; off the gradient by {:.1e} where it comes into reach, {:.1e} within",
        worst[0], worst[1]
    );
    assert!(parts > 150 && worst[0] < 1e-7 && worst[1] < 1e-7);
}
