// SPDX-License-Identifier: MIT OR Apache-2.0
//! Grains at curved walls: the reference is the elastic energy of all places at which the grain's surface is deepest in the wall, found on
//! a grid of that surface; force and torque are its differences.

use std::cell::Cell;

use super::scene::Grain;
use super::shapes::{
    about, add, compose, cross, curvature, dot, length, normalise, rotate, scale, stiffness_of,
    sub, tangents, unit, unrotate, Quaternion, Random, Vector,
};

pub const MODULUS: f64 = 1e7;
pub const POISSON: f64 = 0.3;

/// A wall: where a grain touches it, and the curvature of its surface there.
pub struct Wall {
    pub name: &'static str,
    /// Commands before the fix, and its words after the law.
    pub commands: Vec<String>,
    pub words: String,
    /// Several surfaces act each by itself.
    pub surfaces: Vec<Surface>,
}

/// How deep a grain touches, its outward normal there, and its point that is deepest.
pub type Contact = (f64, Vector, Vector);
type Find = Box<dyn Fn(&Grain) -> Vec<Contact>>;
/// Curvature of the wall at a point of it where it meets this outward normal of a grain, along a direction: positive where the wall bulges.
type Bend = Box<dyn Fn(Vector, Vector, Vector) -> f64>;

pub struct Surface {
    pub find: Find,
    pub bend: Bend,
}

/// From the depth of a point in the wall, and its curvature at a point along a direction.
pub fn surface(
    depth: impl Fn(Vector) -> f64 + 'static,
    bend: impl Fn(Vector, Vector) -> f64 + 'static,
) -> Surface {
    within(depth, bend, |_| true)
}

/// The part of a surface whose points are told.
pub fn within(
    depth: impl Fn(Vector) -> f64 + 'static,
    bend: impl Fn(Vector, Vector) -> f64 + 'static,
    is_there: impl Fn(Vector) -> bool + 'static,
) -> Surface {
    Surface {
        find: Box::new(move |g| {
            let mut found = deepest(g, &depth);
            found.retain(|(depth, n, point)| is_there(sub(*point, scale(*depth, *n))));
            found
        }),
        bend: Box::new(move |p, _, t| bend(p, t)),
    }
}

pub fn grain_point(g: &Grain, w: Vector) -> Vector {
    let scaled = std::array::from_fn(|k| g.semi_axes[k] * w[k]);
    add(g.position, rotate(g.quaternion, scaled))
}

/// Depths and outward normals of the grain where it is locally deepest in a surface.
fn deepest(g: &Grain, depth: &dyn Fn(Vector) -> f64) -> Vec<Contact> {
    let depth = |w: Vector| depth(grain_point(g, w));
    let (rows, columns) = (60i64, 120i64);
    let direction = |i: i64, j: i64| {
        let t = std::f64::consts::PI * (i as f64 + 0.5) / rows as f64;
        let p = std::f64::consts::TAU * j as f64 / columns as f64;
        [t.sin() * p.cos(), t.sin() * p.sin(), t.cos()]
    };
    let mut found: Vec<Contact> = vec![];
    for i in 0..rows {
        for j in 0..columns {
            let here = depth(direction(i, j));
            let mut around = (-1..=1).flat_map(|u| (-1..=1).map(move |v| (u, v)));
            if !around.all(|(u, v)| here >= depth(direction(i + u, j + v))) {
                continue;
            }
            let Some(w) = climbed(&depth, direction(i, j)) else {
                continue;
            };
            let deep = depth(w);
            if deep > 0.0 {
                let local = std::array::from_fn(|k| w[k] / g.semi_axes[k]);
                let normal = unit(rotate(g.quaternion, local));
                let point = grain_point(g, w);
                let known = |c: &Contact| length(sub(c.2, point)) < 1e-4 * length(g.semi_axes);
                if !found.iter().any(known) {
                    found.push((deep, normal, point));
                }
            }
        }
    }
    found
}

/// From a place up to a maximum, by Newton's method: the values alone tell its place to the root of their rounding, of which a slender
/// grain's curvature there makes far more. Along a saddle that a long grain has where its side touches, between its two ends, the way
/// goes on by its rise; a search that only compares values may stop there. `None` where it comes to no maximum.
fn climbed(depth: &dyn Fn(Vector) -> f64, start: Vector) -> Option<Vector> {
    let h = 1e-3;
    let (mut w, mut longest) = (start, 0.1);
    for _ in 0..100 {
        let (u, v) = tangents(w);
        let turned = |s: f64, t: f64| unit(add(w, add(scale(s, u), scale(t, v))));
        let at = |s: f64, t: f64| depth(turned(s, t));
        // differences of fourth order
        let slope = |f: &dyn Fn(f64) -> f64| {
            (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h)
        };
        let (p, q) = (slope(&|s| at(s, 0.0)), slope(&|t| at(0.0, t)));
        let here = at(0.0, 0.0);
        let uu = (at(h, 0.0) + at(-h, 0.0) - 2.0 * here) / (h * h);
        let vv = (at(0.0, h) + at(0.0, -h) - 2.0 * here) / (h * h);
        let uv = (at(h, h) + at(-h, -h) - at(h, -h) - at(-h, h)) / (4.0 * h * h);
        // the main directions of the bend, that of the larger one first
        let (mean, aside) = (0.5 * (uu + vv), (0.5 * (uu - vv)).hypot(uv));
        let angle = 0.5 * (2.0 * uv).atan2(uu - vv);
        let (sin, cos) = angle.sin_cos();
        let mut step = [0.0; 2];
        for (bend, e) in [(mean + aside, [cos, sin]), (mean - aside, [-sin, cos])] {
            let along = e[0] * p + e[1] * q;
            let newton = -along / bend;
            let by = if bend < 0.0 && newton.abs() < longest {
                newton
            } else {
                longest.copysign(along)
            };
            step = [step[0] + by * e[0], step[1] + by * e[1]];
        }
        // differences of so wide a step do not tell a smaller bend from none
        let is_maximum = mean + aside < 1e-5 * (mean - aside);
        if is_maximum && step[0].hypot(step[1]) < 1e-8 {
            return Some(turned(step[0], step[1]));
        }
        let next = turned(step[0], step[1]);
        // rounding of the depth
        if depth(next) > here - 1e-15 {
            w = next;
        } else {
            longest *= 0.5;
            if longest < 1e-10 {
                return None;
            }
        }
    }
    None
}

fn contacts(g: &Grain, surface: &Surface) -> Vec<Contact> {
    (surface.find)(g)
}

/// What the reference knows of a contact.
struct Part {
    energy: f64,
    force: f64,
    /// Which share of the product of the grain's curvatures the cavity leaves: at 0 the grain fits it, and two deepest places become one.
    left: f64,
}

fn parts(g: &Grain, wall: &Wall) -> Vec<Part> {
    let modulus = MODULUS / (2.0 * (1.0 - POISSON * POISSON));
    let mut all = vec![];
    for surface in &wall.surfaces {
        for (depth, n, point) in contacts(g, surface) {
            let (u, v) = tangents(n);
            let body = curvature(g.semi_axes, g.quaternion, n, u, v);
            let on_wall = sub(point, scale(depth, n));
            let bend = |t: Vector| (surface.bend)(on_wall, n, t);
            let (uu, vv) = (bend(u), bend(v));
            let diagonal = bend(unit(add(u, v)));
            let other = [uu, diagonal - 0.5 * (uu + vv), vv];
            let both: [f64; 3] = std::array::from_fn(|k| body[k] + other[k]);
            let product = |m: [f64; 3]| m[0] * m[2] - m[1] * m[1];
            let force = stiffness_of(modulus, both.map(|c| 0.5 * c)) * depth.powf(1.5);
            all.push(Part {
                energy: 0.4 * force * depth,
                force,
                left: product(both) / product(body),
            });
        }
    }
    all
}

/// Elastic energy and number of contacts.
pub fn energy(g: &Grain, wall: &Wall) -> (f64, usize) {
    let all = parts(g, wall);
    (all.iter().map(|p| p.energy).sum(), all.len())
}

/// The law bounds how far the normal turns where less than a twentieth is left of the grain's radius of curvature (`docs/theory.md`); a
/// little more, for the penetration.
const LEAST_LEFT: f64 = 0.06;

/// Force and torque by central differences of fourth order. The rounding of a slender grain's depth asks for a wide step, which must
/// be small beside the grain's least radius as well, where it is deep. `None` where two places are about to become one, or one comes or
/// goes within the step: a second deepest place has a depth when it appears, and the energy jumps.
pub fn reference(g: &Grain, wall: &Wall, depth: f64) -> Option<(Vector, Vector)> {
    let here = parts(g, wall);
    let count = here.len();
    let is_smooth = Cell::new(here.iter().all(|p| p.left > LEAST_LEFT));
    let energy_of = |g: &Grain| {
        let (sum, places) = energy(g, wall);
        is_smooth.set(is_smooth.get() && places == count);
        sum
    };
    let smallest = g.semi_axes.iter().copied().fold(f64::INFINITY, f64::min);
    let h = 0.05 * depth.min(0.05 * smallest);
    let largest = g.semi_axes.iter().copied().fold(0.0, f64::max);
    let slope = |change: &dyn Fn(f64) -> Grain, h: f64| {
        let difference = |h: f64| energy_of(&change(h)) - energy_of(&change(-h));
        (difference(2.0 * h) - 8.0 * difference(h)) / (12.0 * h)
    };
    let axis = |k: usize| std::array::from_fn(|m| if m == k { 1.0 } else { 0.0 });
    let force = std::array::from_fn(|k| {
        let moved = |s: f64| Grain {
            position: add(g.position, scale(s, axis(k))),
            ..g.clone()
        };
        slope(&moved, h)
    });
    let torque = std::array::from_fn(|k| {
        let turned = |s: f64| {
            g.clone()
                .turned(normalise(compose(about(axis(k), s), g.quaternion)))
        };
        slope(&turned, h / largest)
    });
    is_smooth.get().then_some((force, torque))
}

pub const AXIS_Z: Vector = [0.0, 0.0, 1.0];

fn across(p: Vector) -> f64 {
    p[0].hypot(p[1])
}

fn circumferential(p: Vector, t: Vector) -> f64 {
    let around = cross(AXIS_Z, scale(1.0 / across(p), [p[0], p[1], 0.0]));
    dot(around, t).powi(2)
}

pub fn flat(_: Vector, _: Vector) -> f64 {
    0.0
}

/// A cone about z of radius 1 at 0, growing by `slope`; `sign` 1 from within, -1 from without.
pub fn cone(slope: f64, sign: f64) -> Surface {
    let c = 1.0 / (1.0 + slope * slope).sqrt();
    surface(
        move |p| sign * c * (across(p) - 1.0 - slope * p[2]),
        move |p, t| -sign * c / (1.0 + slope * p[2]) * circumferential(p, t),
    )
}

pub fn ball(sign: f64) -> Surface {
    surface(move |p| sign * (length(p) - 1.0), move |_, _| -sign)
}

pub fn turned(q: Quaternion, of: Surface) -> Surface {
    let Surface { find, bend } = of;
    let back = [q[0], -q[1], -q[2], -q[3]];
    Surface {
        find: Box::new(move |g| {
            let seen = Grain {
                position: unrotate(q, g.position),
                quaternion: normalise(compose(back, g.quaternion)),
                ..g.clone()
            };
            let to_world = |(depth, n, p): Contact| (depth, rotate(q, n), rotate(q, p));
            find(&seen).into_iter().map(to_world).collect()
        }),
        bend: Box::new(move |p, n, t| bend(unrotate(q, p), unrotate(q, n), unrotate(q, t))),
    }
}

/// The words of a shape about the axis that `q` turns z to, of another length than 1.
pub fn shape_about(q: Quaternion, name: &str, words: &str) -> String {
    let [x, y, z] = rotate(q, [0.0, 0.0, 2.5]);
    format!("shape {name} axis {x:.17e} {y:.17e} {z:.17e} {words}")
}

/// A wall of each shape of the library, by its name.
pub fn shapes() -> Vec<Wall> {
    let wall = |name, words: &str, surfaces| Wall {
        name,
        commands: vec![],
        words: words.into(),
        surfaces,
    };
    // A needle along x still lies across it.
    let tilted = about([1.0, 0.0, 0.0], 0.4);
    let inclined = about([0.6, -0.8, 0.3], 0.5);
    vec![
        wall(
            "in a tilted cylinder",
            &shape_about(tilted, "cylinder", "radius 1 side inside"),
            vec![turned(tilted, cone(0.0, 1.0))],
        ),
        wall(
            "on an inclined cone",
            &shape_about(inclined, "cone", "radii 0.4 2.2 bounds -2 4 side outside"),
            vec![turned(inclined, cone(0.3, -1.0))],
        ),
        wall(
            "in a tilted cone",
            &shape_about(tilted, "cone", "radii 0.4 2.2 bounds -2 4 side inside"),
            vec![turned(tilted, cone(0.3, 1.0))],
        ),
        wall(
            "on a shape's sphere",
            "shape sphere radius 1",
            vec![ball(-1.0)],
        ),
        wall(
            "in a shape's sphere",
            "shape sphere radius 1 side inside",
            vec![ball(1.0)],
        ),
        wall(
            "on a shape's plane",
            "shape plane point 0 0 -1 axis 1 2 2 side inside",
            vec![surface(
                |p| -dot(add(p, AXIS_Z), [1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0]),
                flat,
            )],
        ),
    ]
}

/// Grains of growing aspect ratio that overlap with the wall by a little, approached from a side of their own.
pub fn touching_once(wall: &Wall, random: &mut Random) -> Vec<Grain> {
    let from_within = wall.name.starts_with("in ");
    [1.0f64, 2.0, 5.0, 30.0]
        .iter()
        .flat_map(|aspect| [*aspect; 2])
        .map(|aspect| loop {
            let largest = 0.25;
            let axes = [largest, largest / aspect, largest / (0.5 * aspect).max(1.0)];
            // from a plane, not along it
            let sideways = if wall.name.contains("plane") {
                0.3
            } else {
                1.0
            };
            let direction = unit([
                random.between(-sideways, sideways),
                random.between(0.3, 1.0),
                random.between(-0.2, 0.2),
            ]);
            let grain = Grain::new(axes, [0.0; 3]).turned(random.quaternion());
            let overlap = 0.02 * axes[1] * axes[1] / largest;
            let at = |s: f64| Grain {
                position: add([0.0, 0.0, 0.3], scale(s, direction)),
                ..grain.clone()
            };
            let depth = |s: f64| {
                let g = at(s);
                let of = |x: &Surface| contacts(&g, x).iter().map(|c| c.0).fold(0.0, f64::max);
                wall.surfaces.iter().map(of).fold(0.0, f64::max)
            };
            // depth grows from the first to the second
            let (mut apart, mut deep) = match (from_within, wall.name.contains("plane")) {
                (true, _) => (0.4, 1.6),
                (false, true) => (4.0, -4.0),
                (false, false) => (2.0, 1.0),
            };
            for _ in 0..30 {
                let middle = 0.5 * (apart + deep);
                if depth(middle) > overlap {
                    deep = middle;
                } else {
                    apart = middle;
                }
            }
            // Of a thin blade the grid may see nothing at the end: then another one.
            let touching = at(deep);
            if energy(&touching, wall).1 > 0 {
                break touching;
            }
        })
        .collect()
}

/// Needles that lean on opposite sides.
pub fn touching_twice(random: &mut Random) -> Vec<Grain> {
    [3.0f64, 10.0, 30.0]
        .iter()
        .map(|aspect| {
            let axes = [1.001, 1.0 / aspect, 0.8 / aspect];
            let tilt = about(
                [random.between(-1.0, 1.0), random.between(-1.0, 1.0), 0.3],
                1e-3,
            );
            Grain::new(axes, [2e-4, 1e-4, 0.0]).turned(tilt)
        })
        .collect()
}

/// By how much forces and torques on grains are off the reference, over the force of a contact and that times the largest semi-axis; how
/// many places a grain touches at most.
pub fn errors(wall: &Wall, grains: &[Grain], found: &[(Vector, Vector)]) -> ([f64; 2], usize) {
    let (mut worst, mut most, mut left_out) = ([0.0f64; 2], 0, 0);
    for (g, &(force, torque)) in grains.iter().zip(found) {
        let depth = wall
            .surfaces
            .iter()
            .flat_map(|s| contacts(g, s))
            .map(|c| c.0)
            .fold(f64::INFINITY, f64::min);
        let count = energy(g, wall).1;
        assert!(count > 0, "{}: a grain does not touch", wall.name);
        most = most.max(count);
        let Some((expected_force, expected_torque)) = reference(g, wall, depth) else {
            println!(
                "{}: axes {:?}, two contacts are nearly one",
                wall.name, g.semi_axes
            );
            left_out += 1;
            continue;
        };
        let size = length(expected_force);
        let largest = g.semi_axes.iter().copied().fold(0.0, f64::max);
        // where two contacts balance, of one of them
        let of_one = parts(g, wall).iter().map(|p| p.force).fold(0.0, f64::max);
        let scale = size.max(of_one);
        let errors = [
            length(sub(force, expected_force)) / scale,
            length(sub(torque, expected_torque)) / (scale * largest),
        ];
        println!(
            "{}: axes {:?}, {count} contacts: force {:.1e}, torque {:.1e}",
            wall.name, g.semi_axes, errors[0], errors[1]
        );
        worst = [worst[0].max(errors[0]), worst[1].max(errors[1])];
    }
    assert!(left_out <= 1, "{}: {left_out} grains left out", wall.name);
    (worst, most)
}

/// What they may be off. Of a cone the law leaves out that the curvature changes along it: up to 6e-5 of these grains.
pub fn tolerance(wall: &Wall) -> f64 {
    if wall.name.contains("cone") {
        1e-4
    } else {
        1e-5
    }
}
