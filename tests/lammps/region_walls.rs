// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do the faces, ends, edges, corners and parts of regions push grains as they should? The reference is that of `curved_walls`, the
//! elastic energy of each contact; at an edge, a rim and a corner the penetration is the least over the normals that it has.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::curved_walls::{forces, region};
use crate::engines::curved_walls::{
    ball, cone, errors, flat, tolerance, turned, within, Contact, Surface, Wall,
};
use crate::harness::{Engine, Grain};
use crate::shapes::{
    about, add, cross, dot, length, rotate, scale, sub, surface_point, tangents, unit, unrotate,
    Random, Vector,
};

fn support(g: &Grain, n: Vector) -> f64 {
    let along = unrotate(g.quaternion, n);
    length(std::array::from_fn(|k| g.semi_axes[k] * along[k]))
}

fn largest(g: &Grain) -> f64 {
    g.semi_axes.iter().copied().fold(0.0, f64::max)
}

/// The contact of a grain with an edge along the normal `n`.
fn contact(g: &Grain, n: Vector, depth: f64) -> Contact {
    let point = add(g.position, surface_point(g.semi_axes, g.quaternion, n));
    (depth, n, point)
}

/// The least value of a function of an angle, and where.
fn least(f: &dyn Fn(f64) -> f64) -> (f64, f64) {
    let count = 720;
    let width = TAU / count as f64;
    let at = (0..count).map(|k| k as f64 * width);
    let start = at.min_by(|a, b| f(*a).total_cmp(&f(*b))).unwrap();
    narrowed(f, start - width, start + width)
}

/// The least value between two places with one minimum.
fn narrowed(f: &dyn Fn(f64) -> f64, mut low: f64, mut high: f64) -> (f64, f64) {
    for _ in 0..60 {
        let third = (high - low) / 3.0;
        if f(low + third) < f(high - third) {
            high -= third;
        } else {
            low += third;
        }
    }
    let middle = 0.5 * (low + high);
    (f(middle), middle)
}

/// Across a straight line through `p` along `t`: the normal along which a grain reaches least beyond it, and by how much.
fn across(g: &Grain, p: Vector, t: Vector) -> (f64, Vector) {
    let (u, v) = tangents(t);
    let offset = sub(p, g.position);
    let normal = |angle: f64| add(scale(angle.cos(), u), scale(angle.sin(), v));
    let beyond = |angle: f64| support(g, normal(angle)) - dot(normal(angle), offset);
    let (depth, angle) = least(&beyond);
    (depth, normal(angle))
}

/// A straight edge; `admits` says along which normals out of the wall it pushes.
fn edge(from: Vector, to: Vector, admits: impl Fn(Vector) -> bool + 'static) -> Surface {
    Surface {
        find: Box::new(move |g| {
            let t = unit(sub(to, from));
            let (depth, n) = across(g, from, t);
            let c = contact(g, n, depth);
            let along = dot(t, sub(c.2, from));
            let is_there = (0.0..length(sub(to, from))).contains(&along);
            let touches = depth > 0.0 && is_there && admits(scale(-1.0, n));
            touches.then_some(c).into_iter().collect()
        }),
        bend: Box::new(|_, _, _| 0.0),
    }
}

/// The normals, near those of the grid, at which a function of them has a minimum.
fn minima(f: &dyn Fn(Vector) -> f64) -> Vec<Vector> {
    let (rows, columns) = (60i64, 120i64);
    let direction = |i: i64, j: i64| {
        let t = std::f64::consts::PI * (i as f64 + 0.5) / rows as f64;
        let p = TAU * j as f64 / columns as f64;
        [t.sin() * p.cos(), t.sin() * p.sin(), t.cos()]
    };
    let mut found: Vec<Vector> = vec![];
    for i in 0..rows {
        for j in 0..columns {
            let here = f(direction(i, j));
            let mut around = (-1..=1).flat_map(|u| (-1..=1).map(move |v| (u, v)));
            if !around.all(|(u, v)| here <= f(direction(i + u, j + v))) {
                continue;
            }
            let (mut n, mut best, mut step) = (direction(i, j), here, 0.05);
            while step > 1e-10 {
                let (u, v) = tangents(n);
                let next = (0..8)
                    .map(|k| {
                        let (sin, cos) = (std::f64::consts::FRAC_PI_4 * k as f64).sin_cos();
                        unit(add(n, add(scale(step * cos, u), scale(step * sin, v))))
                    })
                    .min_by(|a, b| f(*a).total_cmp(&f(*b)))
                    .unwrap();
                if f(next) < best {
                    best = f(next);
                    n = next;
                } else {
                    step *= 0.5;
                }
            }
            if found.iter().all(|m| length(sub(*m, n)) > 1e-4) {
                found.push(n);
            }
        }
    }
    found
}

/// A corner that sticks out.
fn corner(p: Vector, admits: impl Fn(Vector) -> bool + 'static) -> Surface {
    Surface {
        find: Box::new(move |g| {
            let offset = sub(p, g.position);
            if length(offset) > largest(g) {
                return vec![];
            }
            let beyond = |n: Vector| support(g, n) - dot(n, offset);
            let mut all = minima(&beyond);
            all.retain(|n| beyond(*n) > 0.0 && admits(scale(-1.0, *n)));
            all.into_iter().map(|n| contact(g, n, beyond(n))).collect()
        }),
        bend: Box::new(|_, _, _| 0.0),
    }
}

/// A circle about z at a height; `admits` is asked with the parts of a normal out of the wall along radius and axis. Seen from outside of
/// the circle it is that of a disc, from inside each of its places is a line.
fn rim(height: f64, radius: f64, admits: impl Fn(f64, f64) -> bool + 'static) -> Surface {
    let axis = [0.0, 0.0, 1.0];
    Surface {
        find: Box::new(move |g| {
            let offset = sub(scale(height, axis), g.position);
            let aside = g.position[0].hypot(g.position[1]) - radius;
            if aside.hypot(offset[2]) > largest(g) {
                return vec![];
            }
            let disc = |n: Vector| support(g, n) + radius * n[0].hypot(n[1]) - dot(n, offset);
            let place = |angle: f64| {
                let radial = [angle.cos(), angle.sin(), 0.0];
                let p = add(scale(radius, radial), scale(height, axis));
                let (depth, n) = across(g, p, cross(axis, radial));
                (depth, n, -dot(n, radial))
            };
            let mut found: Vec<Contact> = minima(&disc)
                .into_iter()
                .filter(|n| disc(*n) > 0.0 && admits(n[0].hypot(n[1]), -n[2]))
                .filter(|n| n[0].hypot(n[1]) > 1e-6)
                // no other normal across the rim there is shorter
                .filter(|n| place((-n[1]).atan2(-n[0])).0 > 0.999 * disc(*n))
                .map(|n| contact(g, n, disc(n)))
                .collect();
            // From inside the rim acts where it is deepest in the grain, which may be at both ends of a needle. The depth is that of the
            // tangent, which may pass through the grain beside the rim: at a contact the grain is deepest at the rim itself.
            let near = g.position[1].atan2(g.position[0]);
            let (count, width) = (64, 1.0 / 64.0);
            let at = |k: i32| near - 0.5 + f64::from(k) * width;
            let depths: Vec<f64> = (0..=count).map(|k| place(at(k)).0).collect();
            for k in 1..count {
                let [before, here, after] = [-1, 0, 1].map(|m| depths[(k + m) as usize]);
                if here < before || here <= after {
                    continue;
                }
                let (_, angle) = narrowed(&|a| -place(a).0, at(k - 1), at(k + 1));
                let (depth, n, out) = place(angle);
                let c = contact(g, n, depth);
                let ahead = dot(c.2, [-angle.sin(), angle.cos(), 0.0]);
                let is_there = ahead.abs() < 1e-4 * largest(g);
                if depth > 0.0 && out < -1e-6 && is_there && admits(out, -n[2]) {
                    found.push(c);
                }
            }
            found
        }),
        bend: Box::new(move |p, n, t| {
            let radial = unit([p[0], p[1], 0.0]);
            let along = dot(cross(axis, radial), t);
            -dot(n, radial) / radius * along * along
        }),
    }
}

/// A plane of which only a part is there; `outwards` 0: on the side of each grain's centre.
fn face(
    point: Vector,
    normal: Vector,
    outwards: f64,
    is_there: impl Fn(Vector) -> bool + Clone + 'static,
) -> Surface {
    Surface {
        find: Box::new(move |g| {
            let side = if outwards != 0.0 {
                outwards
            } else {
                dot(normal, sub(g.position, point)).signum()
            };
            // of a solid a grain does not see the faces behind those that it is in front of
            if dot(normal, sub(g.position, point)) * side <= 0.0 && outwards == 1.0 {
                return vec![];
            }
            if dot(normal, sub(g.position, point)).abs() > largest(g) {
                return vec![];
            }
            let depth = move |p: Vector| -side * dot(normal, sub(p, point));
            (within(depth, flat, is_there.clone()).find)(g)
        }),
        bend: Box::new(|_, _, _| 0.0),
    }
}

/// A grain whose surface is by a 50th of its least radius of curvature beyond a point of a wall, along a normal out of the wall there.
pub fn touching(aspect: f64, place: Vector, out: Vector, random: &mut Random) -> Grain {
    let largest = 0.25;
    let axes = [largest, largest / aspect, largest / (0.5 * aspect).max(1.0)];
    let grain = Grain::new(axes, [0.0; 3]).turned(random.quaternion());
    let n = scale(-1.0, unit(out));
    let depth = 0.02 * axes[1] * axes[1] / largest;
    let point = surface_point(axes, grain.quaternion, n);
    Grain {
        position: sub(add(place, scale(depth, n)), point),
        ..grain
    }
}

/// Places on a wall, with a normal out of it.
type Places = Box<dyn Fn(&mut Random) -> (Vector, Vector)>;

fn places(of: impl Fn(&mut Random) -> (Vector, Vector) + 'static) -> Places {
    Box::new(of)
}

pub const EDGES: [f64; 3] = [1.0, 0.8, 0.6];

/// Faces, edges and corners of a block about the origin; without the upper z face it is a thin shell.
pub fn block(closed: bool) -> Vec<Surface> {
    let mut surfaces = vec![];
    let unit_of =
        |k: usize, s: f64| -> Vector { std::array::from_fn(|c| if c == k { s } else { 0.0 }) };
    for k in 0..6usize {
        let (axis, sign) = (k / 2, if k % 2 == 0 { -1.0 } else { 1.0 });
        if !closed && k == 5 {
            continue;
        }
        let inside = move |p: Vector| (0..3).all(|c| c == axis || p[c].abs() <= EDGES[c]);
        surfaces.push(face(
            unit_of(axis, sign * EDGES[axis]),
            unit_of(axis, sign),
            if closed { 1.0 } else { 0.0 },
            inside,
        ));
    }
    for axis in 0..3usize {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        for (s, t) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            let mut from = [0.0; 3];
            from[axis] = -EDGES[axis];
            from[b] = s * EDGES[b];
            from[c] = t * EDGES[c];
            let mut to = from;
            to[axis] = EDGES[axis];
            // the border of an open face pushes towards both sides of the face that ends there
            let is_border = !closed && axis != 2 && from[2] > 0.0;
            surfaces.push(edge(from, to, move |m| {
                if is_border {
                    m[2] > 0.0
                } else {
                    s * m[b] > 0.0 && t * m[c] > 0.0
                }
            }));
        }
    }
    for k in 0..8usize {
        let sign: Vector = std::array::from_fn(|c| if k >> c & 1 == 0 { -1.0 } else { 1.0 });
        if !closed && sign[2] > 0.0 {
            continue;
        }
        let p = std::array::from_fn(|c| sign[c] * EDGES[c]);
        surfaces.push(corner(p, move |m| (0..3).all(|c| sign[c] * m[c] > 0.0)));
    }
    surfaces
}

/// The curved side between two heights, `sign` as of `cone`; 0: on the side of each grain's centre.
fn side(slope: f64, low: f64, high: f64, sign: f64) -> Surface {
    let of = move |sign: f64| {
        let Surface { find, bend } = cone(slope, sign);
        let there = move |g: &Grain| {
            let is_within = g.position[0].hypot(g.position[1]) < 1.0 + slope * g.position[2];
            if sign < 0.0 && is_within {
                return vec![];
            }
            let mut found = find(g);
            found.retain(|(depth, n, p)| (low..=high).contains(&sub(*p, scale(*depth, *n))[2]));
            found
        };
        (there, bend)
    };
    if sign != 0.0 {
        let (find, bend) = of(sign);
        return Surface {
            find: Box::new(find),
            bend,
        };
    }
    let ((within, bend), (outside, _)) = (of(1.0), of(-1.0));
    let is_within =
        move |g: &Grain| g.position[0].hypot(g.position[1]) < 1.0 + slope * g.position[2];
    Surface {
        find: Box::new(move |g| if is_within(g) { within(g) } else { outside(g) }),
        // the sign of the curvature that `cone` has from within
        bend: Box::new(move |p, n, t| {
            let from_within = dot(n, [p[0], p[1], 0.0]) > 0.0;
            if from_within {
                bend(p, n, t)
            } else {
                -bend(p, n, t)
            }
        }),
    }
}

fn disc(height: f64, up: f64, radius: f64, outwards: f64) -> Surface {
    face([0.0, 0.0, height], [0.0, 0.0, up], outwards, move |p| {
        p[0].hypot(p[1]) < radius
    })
}

fn around(random: &mut Random) -> (Vector, Vector) {
    let (sin, cos) = random.between(0.0, TAU).sin_cos();
    ([cos, sin, 0.0], [-sin, cos, 0.0])
}

/// A place on a rim, with a normal at an angle from the radius towards z between the two.
fn on_rim(height: f64, radius: f64, least: f64, most: f64) -> Places {
    places(move |random| {
        let (radial, _) = around(random);
        let (sin, cos) = random.between(least, most).sin_cos();
        let place = add(scale(radius, radial), [0.0, 0.0, height]);
        (place, add(scale(cos, radial), [0.0, 0.0, sin]))
    })
}

fn cases() -> Vec<(Wall, Vec<Places>)> {
    let wall = |name, commands: Vec<String>, words: &str, surfaces| Wall {
        name,
        commands,
        words: words.into(),
        surfaces,
    };
    let on_face = |axis: usize, sign: f64, out: f64| {
        places(move |random| {
            let mut p: Vector = std::array::from_fn(|c| EDGES[c] * random.between(-0.5, 0.5));
            p[axis] = sign * EDGES[axis];
            let mut n = [0.0; 3];
            n[axis] = out * sign;
            (p, n)
        })
    };
    let on_edge = |axis: usize| {
        places(move |random| {
            let mut sign: Vector = std::array::from_fn(|_| random.between(-1.0, 1.0).signum());
            sign[axis] = random.between(-0.5, 0.5);
            let n = std::array::from_fn(|c| {
                if c == axis {
                    0.0
                } else {
                    sign[c] * random.between(0.3, 1.0)
                }
            });
            (std::array::from_fn(|c| sign[c] * EDGES[c]), n)
        })
    };
    let on_corner = places(|random| {
        let sign: Vector = std::array::from_fn(|_| random.between(-1.0, 1.0).signum());
        let n = std::array::from_fn(|c| sign[c] * random.between(0.4, 1.0));
        (std::array::from_fn(|c| sign[c] * EDGES[c]), n)
    });
    // over the border of a wall without a lid, from both of its sides
    let on_border = places(|random| {
        let p = [random.between(-0.5, 0.5), EDGES[1], EDGES[2]];
        let out = random.between(0.2, std::f64::consts::PI - 0.2);
        (p, [0.0, out.cos(), out.sin()])
    });
    let on_side = |slope: f64, low: f64, high: f64, out: f64| {
        places(move |random| {
            let (radial, _) = around(random);
            let z = random.between(low, high);
            let p = add(scale(1.0 + slope * z, radial), [0.0, 0.0, z]);
            (p, scale(out, add(radial, [0.0, 0.0, -slope])))
        })
    };
    let on_disc = |height: f64, radius: f64, out: f64| {
        places(move |random| {
            let (radial, _) = around(random);
            let place = scale(radius * random.between(0.0, 0.6), radial);
            (add(place, [0.0, 0.0, height]), [0.0, 0.0, out])
        })
    };
    let on_ball = |out: f64| {
        places(move |random| {
            let n = random.direction();
            (n, scale(out, n))
        })
    };
    let cylinder = |y: bool, words: &str| {
        region(&format!(
            "cylinder {} 0 0 1 -0.7 0.9 {words}",
            if y { "y" } else { "z" }
        ))
    };
    // surfaces of a closed cylinder and a closed cone, from outside
    let outside = |slope: f64, low: f64, high: f64| {
        let (a, b) = (1.0 + slope * low, 1.0 + slope * high);
        vec![
            side(slope, low, high, -1.0),
            disc(low, -1.0, a, 1.0),
            disc(high, 1.0, b, 1.0),
            // out along the radius and away from both the side and the disc
            rim(low, a, move |r, z| r * slope + z < 0.0 && r > 0.0),
            rim(high, b, move |r, z| r * slope + z > 0.0 && r > 0.0),
        ]
    };
    let tilt = 0.3f64.atan();
    // about x and about y: as about z, turned
    let [about_x, about_y] = [
        about([0.0, 1.0, 0.0], FRAC_PI_2),
        about([1.0, 0.0, 0.0], -FRAC_PI_2),
    ];
    let lying = |name, words: &str, q, out| {
        let wall = wall(
            name,
            vec![],
            words,
            vec![turned(q, side(0.0, -8.0, 8.0, 0.0))],
        );
        let of_z = on_side(0.0, -3.0, 3.0, out);
        let turned = places(move |random| {
            let (p, out) = of_z(random);
            (rotate(q, p), rotate(q, out))
        });
        (wall, vec![turned])
    };
    vec![
        lying("in an x cylinder", "xcylinder 1", about_x, -1.0),
        lying("on a y cylinder", "ycylinder 1", about_y, 1.0),
        lying("in a y cylinder", "ycylinder 1", about_y, -1.0),
        (
            wall(
                "on a block",
                region("block -1 1 -0.8 0.8 -0.6 0.6 side out"),
                "region place",
                block(true),
            ),
            vec![
                on_face(0, -1.0, 1.0),
                on_face(1, 1.0, 1.0),
                on_face(2, 1.0, 1.0),
                on_edge(0),
                on_edge(1),
                on_edge(2),
                on_corner,
            ],
        ),
        (
            wall(
                "on a block without a lid",
                region("block -1 1 -0.8 0.8 -0.6 0.6 open 6"),
                "region place",
                block(false),
            ),
            vec![on_face(0, -1.0, 1.0), on_face(2, -1.0, 1.0), on_border],
        ),
        (
            wall(
                "in a block without a lid",
                region("block -1 1 -0.8 0.8 -0.6 0.6 open 6"),
                "region place",
                block(false),
            ),
            vec![on_face(0, 1.0, -1.0), on_face(2, -1.0, -1.0)],
        ),
        (
            wall(
                "on a closed cylinder",
                cylinder(false, "side out"),
                "region place",
                outside(0.0, -0.7, 0.9),
            ),
            vec![
                on_side(0.0, -0.4, 0.6, 1.0),
                on_disc(-0.7, 1.0, -1.0),
                on_disc(0.9, 1.0, 1.0),
                on_rim(0.9, 1.0, 0.2, FRAC_PI_2 - 0.2),
                on_rim(-0.7, 1.0, 0.2 - FRAC_PI_2, -0.2),
            ],
        ),
        (
            wall(
                "in a closed cylinder",
                cylinder(false, ""),
                "region place",
                vec![
                    side(0.0, -0.7, 0.9, 1.0),
                    disc(-0.7, -1.0, 1.0, -1.0),
                    disc(0.9, 1.0, 1.0, -1.0),
                ],
            ),
            vec![
                on_side(0.0, -0.3, 0.5, -1.0),
                on_disc(-0.7, 1.0, 1.0),
                on_disc(0.9, 1.0, -1.0),
            ],
        ),
        (
            wall(
                "on a cylinder with an opening",
                cylinder(false, "open 2"),
                "region place",
                vec![
                    side(0.0, -0.7, 0.9, 0.0),
                    disc(-0.7, -1.0, 1.0, 0.0),
                    rim(0.9, 1.0, |_, z| z > 0.0),
                    rim(-0.7, 1.0, |r, z| z < 0.0 && r > 0.0),
                ],
            ),
            vec![
                on_side(0.0, -0.3, 0.5, -1.0),
                on_side(0.0, -0.3, 0.5, 1.0),
                on_disc(-0.7, 1.0, 1.0),
                on_disc(-0.7, 1.0, -1.0),
                // over the opening's edge, from outside and from inside
                on_rim(0.9, 1.0, 0.3, FRAC_PI_2 - 0.2),
                on_rim(0.9, 1.0, FRAC_PI_2 + 0.2, FRAC_PI_2 + 1.0),
            ],
        ),
        (
            wall(
                "on a closed cone",
                region("cone z 0 0 0.7 1.3 -1 1 side out"),
                "region place",
                outside(0.3, -1.0, 1.0),
            ),
            vec![
                on_side(0.3, -0.6, 0.6, 1.0),
                on_disc(-1.0, 0.7, -1.0),
                on_disc(1.0, 1.3, 1.0),
                on_rim(1.0, 1.3, 0.2 - tilt, FRAC_PI_2 - 0.2),
                on_rim(-1.0, 0.7, 0.2 - FRAC_PI_2, -0.2 - tilt),
            ],
        ),
        (
            wall(
                "in a closed cone",
                region("cone z 0 0 0.7 1.3 -1 1"),
                "region place",
                vec![
                    side(0.3, -1.0, 1.0, 1.0),
                    disc(-1.0, -1.0, 0.7, -1.0),
                    disc(1.0, 1.0, 1.3, -1.0),
                ],
            ),
            vec![
                on_side(0.3, -0.6, 0.6, -1.0),
                on_disc(-1.0, 0.7, 1.0),
                on_disc(1.0, 1.3, -1.0),
            ],
        ),
        (
            wall(
                "on a sphere",
                region("sphere 0 0 0 1 side out"),
                "region place",
                vec![ball(-1.0)],
            ),
            vec![on_ball(1.0)],
        ),
        (
            wall(
                "in a sphere",
                region("sphere 0 0 0 1"),
                "region place",
                vec![ball(1.0)],
            ),
            vec![on_ball(-1.0)],
        ),
        (
            wall(
                "in a funnel",
                region("cone z 0 0 0.7 1.3 -1 1 open 1 open 2"),
                "region place",
                vec![
                    side(0.3, -1.0, 1.0, 0.0),
                    rim(1.0, 1.3, |r, z| 0.3 * r + z > 0.0),
                    rim(-1.0, 0.7, |r, z| 0.3 * r + z < 0.0),
                ],
            ),
            vec![
                on_side(0.3, -0.6, 0.6, -1.0),
                on_side(0.3, -0.6, 0.6, 1.0),
                on_rim(1.0, 1.3, 0.3 - tilt, FRAC_PI_2 - 0.2),
                on_rim(-1.0, 0.7, -FRAC_PI_2 - 0.8, -FRAC_PI_2 - 0.2),
            ],
        ),
    ]
}

#[test]
fn both_versions_faces_ends_edges_and_corners_push_as_the_energy_says() {
    let engine = Engine::from_environment();
    let mut random = Random(21);
    let mut faults = vec![];
    for (wall, places) in cases() {
        let mut grains = vec![];
        for place in &places {
            // fixed ones, and random ones in between
            let drawn: [f64; 4] = std::array::from_fn(|_| 30f64.powf(random.uniform()));
            for aspect in [1.0, 3.0, 5.0, 10.0, 30.0].into_iter().chain(drawn) {
                let (p, out) = place(&mut random);
                grains.push(touching(aspect, p, out, &mut random));
            }
        }
        let name = format!("region_{}", wall.name.replace(' ', "_"));
        let found = forces(&engine, &wall, &grains, &name);
        let (worst, most) = errors(&wall, &grains, &found);
        println!("{}: {worst:?}, up to {most} contacts", wall.name);
        // Of a rim the law leaves out that its curvature changes with the normal.
        let has_rim = ["on a closed", "opening", "funnel"];
        let tolerance = if has_rim.iter().any(|word| wall.name.contains(word)) {
            1e-3
        } else {
            tolerance(&wall)
        };
        if worst.iter().any(|e| e.is_nan() || *e > tolerance) {
            faults.push(format!("{}: {worst:?}", wall.name));
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Used where a wall is the same in other words.
pub fn apart(a: &[(Vector, Vector)], b: &[(Vector, Vector)]) -> f64 {
    let most = b.iter().map(|s| length(s.0)).fold(0.0, f64::max);
    let difference = |(s, t): (&(Vector, Vector), &(Vector, Vector))| {
        length(sub(s.0, t.0)).max(length(sub(s.1, t.1)))
    };
    a.iter().zip(b).map(difference).fold(0.0, f64::max) / most
}

/// Grains beside a ball and a block, within or outside of each: some touch one of the two, some both.
fn beside_ball_and_block(within_ball: bool, within_block: bool) -> Vec<Grain> {
    let mut random = Random(8);
    let mut grains = vec![];
    let signs = [within_ball, within_block].map(|inside| if inside { -1.0 } else { 1.0 });
    let is_in = |p: Vector| (length(p) < 1.0, p[0].abs() < 0.8);
    while grains.len() < 24 {
        let aspect = [1.0, 3.0, 10.0, 30.0][grains.len() % 4];
        let n = random.direction();
        let (p, out) = if grains.len() % 2 == 0 {
            (n, scale(signs[0], n))
        } else {
            let x = 0.8 * n[0].signum();
            let p = [x, 1.5 * n[1], 1.5 * n[2]];
            (p, [signs[1] * x.signum(), 0.0, 0.0])
        };
        let grain = touching(aspect, p, out, &mut random);
        if is_in(grain.position) == (within_ball, within_block) {
            grains.push(grain);
        }
    }
    // where the two meet: as deep in one as in the other
    let place = [0.8, 0.6, 0.0];
    let normals = [scale(signs[0], place), [signs[1], 0.0, 0.0]];
    for radius in [0.05, 0.1] {
        // the centre is by less than the radius from both
        let gap = radius - 1e-4;
        let x = 0.8 + gap * normals[1][0];
        let from_centre = 1.0 + gap * signs[0];
        let y = (from_centre * from_centre - x * x).sqrt();
        grains.push(Grain::sphere(radius, [x, y, 0.0]));
    }
    grains
}

/// An *intersect*, and a *union* with *side out*, are walls made of the surfaces of their parts.
#[test]
fn both_versions_regions_of_several_parts_are_their_surfaces() {
    let engine = Engine::from_environment();
    let slab = "block -0.8 0.8 INF INF INF INF";
    for (name, parts, whole, inside) in [
        (
            "intersect",
            ["sphere 0 0 0 1".to_string(), slab.to_string()],
            "intersect 2 a b",
            (true, true),
        ),
        (
            "intersect with a part outside",
            ["sphere 0 0 0 1 side out".into(), slab.into()],
            "intersect 2 a b",
            (false, true),
        ),
        (
            "union with side out",
            ["sphere 0 0 0 1".into(), "plane 0.8 0 0 -1 0 0".into()],
            "union 2 a b side out",
            (false, false),
        ),
        (
            "union within a union",
            ["sphere 0 0 0 1".into(), "plane 0.8 0 0 -1 0 0".into()],
            "union 2 c b side out",
            (false, false),
        ),
    ] {
        let mut grains = beside_ball_and_block(inside.0, inside.1);
        if whole.starts_with("union") {
            // beyond the one plane of it
            grains.retain(|g| g.position[0] > 0.0);
        }
        let mut commands: Vec<String> = parts
            .iter()
            .zip(["a", "b"])
            .map(|(words, id)| format!("region {id} {words}"))
            .collect();
        commands.push("region c union 2 a a".into());
        commands.push(format!("region place {whole}"));
        let wall = |commands: Vec<String>, words: &str| Wall {
            name: "parts",
            commands,
            words: words.into(),
            surfaces: vec![],
        };
        let one = wall(commands.clone(), "region place");
        let mut with_first = commands;
        with_first.push("fix first all wall/gran/ellipsoid hertz 1e7 0.3 region a".into());
        if whole.contains(" c ") {
            // its ball counts twice
            with_first.push("fix again all wall/gran/ellipsoid hertz 1e7 0.3 region a".into());
        }
        // outside of a union is outside of each of its parts
        if whole.contains("side out") {
            for words in &mut with_first[..2] {
                *words += " side out";
            }
        }
        let two = wall(with_first, "region b");
        let place = format!("parts_{}", name.replace(' ', "_"));
        let [one, two] = [one, two].map(|wall| forces(&engine, &wall, &grains, &place));
        let gap = apart(&one, &two);
        println!("{name}: {} grains, apart by {gap:.1e}", grains.len());
        assert!(two.iter().all(|f| length(f.0) > 0.0), "{name}");
        assert!(gap < 1e-12, "{name}: {gap:e}");
    }
}
