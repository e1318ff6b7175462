// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do closed cylinders and cones push bodies out along the shortest way, by their sides, discs, rims and tips, and no body that is apart? The
//! shortest way out of a convex solid is the least of all normals of the sum of the two support functions; the reference compares values
//! of it, on the whole sphere of normals and where the solid's has folds.

use crate::curved_walls::{contacts, instruction_sets, semi_axes};
use crate::round_edges::Edge;
use crate::support::brute_force::{support, witness};
use crate::support::random::Stream;
use crate::support::scene::{body, laws, rotation, Vector};
use ellgran::contact::Body;
use ellgran::vector::Vector3;
use ellgran::walls::{End, ShapeParameters, Side, Wall};
use std::f64::consts::{FRAC_PI_4, PI, TAU};

const BOUNDS: [f64; 2] = [-0.6, 0.5];

/// A truncated cone about z, with its radii at the two bounds.
struct Solid {
    radii: [f64; 2],
}

impl Solid {
    fn slope(&self) -> f64 {
        (self.radii[1] - self.radii[0]) / (BOUNDS[1] - BOUNDS[0])
    }

    /// Out of the solid's side, at an angle.
    fn side(&self, angle: f64) -> Vector {
        Vector::new(angle.cos(), angle.sin(), -self.slope()).normalize()
    }

    /// How far it reaches along a direction, at which of the two bounds.
    fn support(&self, m: &Vector) -> (f64, usize) {
        let across = m.x.hypot(m.y);
        let [low, high] = [0, 1].map(|k: usize| m.z * BOUNDS[k] + self.radii[k] * across);
        if low > high {
            (low, 0)
        } else {
            (high, 1)
        }
    }

    /// By how much a body has to move along minus this normal out of it to leave the solid.
    fn way_out(&self, b: &Body, n: &Vector) -> f64 {
        support(b, n) + self.support(&-n).0 + n.dot(&Vector::from(b.position))
    }

    /// Its length, and the normal out of the body.
    fn shortest_way_out(&self, b: &Body) -> (f64, Vector) {
        let value = |n: Vector| self.way_out(b, &n);
        let mut least = (f64::INFINITY, Vector::z());
        let mut offer = |n: Vector| {
            if value(n) < least.0 {
                least = (value(n), n);
            }
        };
        offer(Vector::z());
        offer(-Vector::z());
        // along the circle of the side's normals
        let width = TAU / 720.0;
        let of_side = |angle: f64| value(-self.side(angle));
        let values: Vec<f64> = (0..720).map(|k| of_side(f64::from(k) * width)).collect();
        for k in 0..720 {
            let [before, here, after] = [719, 720, 721].map(|m| values[(k + m) % 720]);
            if here > before || here > after {
                continue;
            }
            let [mut low, mut high] = [-1.0, 1.0].map(|d| (k as f64 + d) * width);
            for _ in 0..80 {
                let third = (high - low) / 3.0;
                if of_side(low + third) < of_side(high - third) {
                    high -= third;
                } else {
                    low += third;
                }
            }
            offer(-self.side(0.5 * (low + high)));
        }
        // on the whole sphere, down from the least of each neighbourhood
        let (rows, columns) = (60i64, 120i64);
        let direction = |i: i64, j: i64| {
            let (t, p) = (
                PI * (i as f64 + 0.5) / rows as f64,
                TAU * j as f64 / columns as f64,
            );
            Vector::new(t.sin() * p.cos(), t.sin() * p.sin(), t.cos())
        };
        let places = (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
        let grid: Vec<f64> = places
            .clone()
            .map(|(i, j)| value(direction(i, j)))
            .collect();
        let on_grid = |i: i64, j: i64| match i {
            0..60 => grid[(i * columns + j.rem_euclid(columns)) as usize],
            _ => f64::INFINITY,
        };
        for (i, j) in places {
            let mut around = (-1..=1).flat_map(|u| (-1..=1).map(move |v| (u, v)));
            if !around.all(|(u, v)| on_grid(i, j) <= on_grid(i + u, j + v)) {
                continue;
            }
            let (mut n, mut best) = (direction(i, j), on_grid(i, j));
            let (mut step, mut turn) = (0.05, 0.0);
            while step > 1e-8 {
                let aside = if n.x.abs() < 0.6 {
                    Vector::x()
                } else {
                    Vector::y()
                };
                let u = n.cross(&aside).normalize();
                let v = n.cross(&u);
                // other directions each time: across a fold few lead down
                turn += 0.3;
                let (next, at) = (0..8)
                    .map(|k| {
                        let (sin, cos) = (FRAC_PI_4 * f64::from(k) + turn).sin_cos();
                        let m = (n + u * (step * cos) + v * (step * sin)).normalize();
                        (value(m), m)
                    })
                    .min_by(|a, b| a.0.total_cmp(&b.0))
                    .unwrap();
                if next < best {
                    (best, n) = (next, at);
                } else {
                    step *= 0.7;
                }
            }
            offer(n);
        }
        least
    }

    /// Whether the edge that acts along a normal out of a body lies past the middle of it, so that the edge's own shortest way out of the body
    /// is another one. An edge does not know that the solid behind it is in the way.
    fn is_past_the_middle(&self, b: &Body, (depth, n): &(f64, Vector)) -> bool {
        let across = n.x.hypot(n.y);
        let is_of_face = across < 1e-6 || (-n.z - self.side(0.0).z).abs() < 1e-6;
        let end = self.support(&-n).1;
        let edge = Edge {
            height: BOUNDS[end],
            radius: self.radii[end],
            inwards: [0.0; 2],
        };
        let own = if edge.radius > 0.0 {
            edge.at(b, (-n.y).atan2(-n.x)).depth
        } else {
            way_out_of_point(b, Vector::z() * edge.height)
        };
        !is_of_face && own < depth - 1e-9
    }

    /// A body that is by a part of its smallest semi-axis beyond a place of the surface, along a normal there, or before it.
    fn touching(&self, stream: &mut Stream) -> Body {
        let size = stream.log_uniform(0.02, 0.6);
        let axes = semi_axes(stream).map(|a| a * size);
        let (angle, part) = (stream.uniform(0.0, TAU), stream.uniform(0.0, 1.0));
        let radial = Vector::new(angle.cos(), angle.sin(), 0.0);
        let [low, high] = self.radii;
        let (place, m) = match stream.uniform(0.0, 10.0) as usize {
            0..3 => {
                let z = BOUNDS[0] + part * (BOUNDS[1] - BOUNDS[0]);
                let place = radial * (low + part * (high - low)) + Vector::z() * z;
                (place, self.side(angle))
            }
            3 => {
                let end = usize::from(stream.uniform(0.0, 1.0) < 0.5);
                let place = radial * (self.radii[end] * part) + Vector::z() * BOUNDS[end];
                (place, Vector::z() * BOUNDS[end].signum())
            }
            // of a rim or a tip
            _ => {
                let m = stream.direction();
                let end = self.support(&m).1;
                let radial = Vector::new(m.x, m.y, 0.0).normalize();
                (radial * self.radii[end] + Vector::z() * BOUNDS[end], m)
            }
        };
        let mut b = body(axes, Vector::zeros(), stream.rotation());
        let smallest = axes.into_iter().fold(f64::INFINITY, f64::min);
        let side = stream.uniform(-0.2, 1.0).signum();
        let depth = side * smallest * stream.log_uniform(1e-4, 0.1);
        b.position = (place - m * depth - witness(&b, &-m)).into();
        b
    }
}

/// From a place in a body to its surface.
fn way_out_of_point(b: &Body, place: Vector) -> f64 {
    let y = rotation(b.quaternion).inverse() * (place - Vector::from(b.position));
    let nearest = |t: f64| {
        let of_axis = |k: usize| {
            let square = b.semi_axes[k].powi(2);
            square * y[k] / (t + square)
        };
        Vector::new(of_axis(0), of_axis(1), of_axis(2))
    };
    let is_inside = |p: Vector| (0..3).map(|k| (p[k] / b.semi_axes[k]).powi(2)).sum::<f64>() < 1.0;
    let smallest = b.semi_axes.into_iter().fold(f64::INFINITY, f64::min);
    let (mut low, mut high) = (-smallest * smallest, 0.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if is_inside(nearest(middle)) {
            high = middle;
        } else {
            low = middle;
        }
    }
    (nearest(high) - y).norm()
}

#[test]
fn closed_solids_push_along_the_shortest_way_out() {
    let laws = laws(&["hertz 1e5 0.3"]);
    let mut stream = Stream::new(7);
    for radii in [
        [1.0, 1.0],
        [0.02, 0.02],
        [0.7, 1.3],
        [0.3, 1.0],
        [1.0, 0.02],
        [0.0, 1.0],
        [1.0, 0.0],
        [0.0, 0.2],
    ] {
        let solid = Solid { radii };
        let mut wall = Wall::new();
        let parameters = ShapeParameters {
            point: Vector3::ZERO,
            axis: Vector3::new(0.0, 0.0, 1.0),
            radii,
            bounds: BOUNDS,
            ends: [End::Closed; 2],
            side: Side::Outside,
        };
        let name = if radii[0] == radii[1] {
            "cylinder"
        } else {
            "cone"
        };
        wall.add_shape(name, &parameters).unwrap();
        wall.records_contacts = true;
        let (mut counts, mut past) = ([0; 2], 0);
        for _ in 0..400 {
            let b = solid.touching(&mut stream);
            let shortest = solid.shortest_way_out(&b);
            let least = shortest.0;
            // what the reference leaves at a fold
            let rounding = 1e-7;
            if least.abs() < rounding {
                continue;
            }
            if least > 0.0 && solid.is_past_the_middle(&b, &shortest) {
                past += 1;
                continue;
            }
            for set in instruction_sets() {
                let found = contacts(&mut wall, &laws, &b, set);
                // its own normal's, and no longer than the reference's
                let is_shortest = |(depth, n): &(f64, Vector)| {
                    *depth < least + rounding && (solid.way_out(&b, n) - depth).abs() < 1e-9
                };
                let is_right = if least > 0.0 {
                    found.len() == 1 && is_shortest(&found[0])
                } else {
                    found.is_empty()
                };
                assert!(
                    is_right,
                    "{name} {radii:?}, {}: {found:?} where {least:e} is expected, {b:?}",
                    set.name()
                );
            }
            counts[usize::from(least > 0.0)] += 1;
        }
        println!("{name} {radii:?}: {counts:?} poses apart and touching, {past} past the middle");
        assert!(past < 20, "{radii:?}: {past}");
        assert!(
            counts.iter().all(|count| *count > 30),
            "{radii:?}: {counts:?}"
        );
    }
}
