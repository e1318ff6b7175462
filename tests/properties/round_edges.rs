// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where open cylinders and cones end, are the contacts those with the side and those with the two rims, all of them and no other? A rim
//! acts where a body is deepest along it. The reference looks for these places on a fine division of the circle, and for the normal at
//! each on a fine division of the normals across.

use crate::curved_walls::{are_same, contacts, instruction_sets, lying, semi_axes, Place, Surface};
use crate::support::brute_force::witness;
use crate::support::random::Stream;
use crate::support::scene::{body, laws, rotation, Vector};
use ellgran::contact::Body;
use ellgran::vector::Vector3;
use ellgran::walls::{End, ShapeParameters, Side, Wall};
use nalgebra::Matrix3;
use std::f64::consts::{PI, TAU};

/// A circle about z in which a surface ends.
pub struct Edge {
    pub height: f64,
    pub radius: f64,
    /// The surface's unit direction from the edge on, along radius and z.
    pub inwards: [f64; 2],
}

/// What a body does to the edge's tangent at one place.
pub struct Tangent {
    /// How deep it is in the body, by its shortest way out.
    pub depth: f64,
    /// How far ahead along it the body reaches out on that way.
    ahead: f64,
    /// That way.
    normal: Vector,
    radial: Vector,
    /// Whether the edge itself is in the body: below 1.
    inside: f64,
}

impl Edge {
    pub fn at(&self, b: &Body, angle: f64) -> Tangent {
        let (sin, cos) = angle.sin_cos();
        let radial = Vector::new(cos, sin, 0.0);
        let along = Vector::new(-sin, cos, 0.0);
        let from_centre =
            radial * self.radius + Vector::z() * self.height - Vector::from(b.position);
        let turn = rotation(b.quaternion);
        let image =
            turn.to_rotation_matrix().matrix() * Matrix3::from_diagonal(&b.semi_axes.into());
        let scaled = [image.tr_mul(&radial), image.tr_mul(&Vector::z())];
        let place = [from_centre.dot(&radial), from_centre.z];
        let depth = |normal: f64| {
            let (s, c) = normal.sin_cos();
            (scaled[0] * c + scaled[1] * s).norm() - (place[0] * c + place[1] * s)
        };
        let rise = |normal: f64| {
            let (s, c) = normal.sin_cos();
            let (v, w) = (scaled[0] * c + scaled[1] * s, scaled[1] * c - scaled[0] * s);
            v.dot(&w) / v.norm() - (place[1] * c - place[0] * s)
        };
        let width = TAU / 720.0;
        let least = (0..720)
            .map(|k| f64::from(k) * width)
            .min_by(|a, b| depth(*a).total_cmp(&depth(*b)))
            .unwrap();
        let (low, high) = bisected(least - width, least + width, |angle| rise(angle) < 0.0);
        let (s, c) = (0.5 * (low + high)).sin_cos();
        let normal = radial * c + Vector::z() * s;
        let seen = turn.inverse() * from_centre;
        Tangent {
            depth: depth(0.5 * (low + high)),
            ahead: along.dot(&(witness(b, &normal) - from_centre)),
            normal,
            radial,
            inside: (0..3).map(|k| (seen[k] / b.semi_axes[k]).powi(2)).sum(),
        }
    }

    /// Depths and normals out of the body of its contacts with a body; `None` where one is about to appear or to vanish.
    fn contacts(&self, b: &Body) -> Option<Vec<(f64, Vector)>> {
        let reach = b.semi_axes.into_iter().fold(0.0, f64::max);
        let aside = b.position[0].hypot(b.position[1]) - self.radius;
        if aside.hypot(b.position[2] - self.height) > reach {
            return Some(vec![]);
        }
        let count = 4000;
        let start = b.position[1].atan2(b.position[0]) - PI;
        let at = |k: usize| start + TAU * (k as f64 + 0.37) / count as f64;
        let mut found = vec![];
        // not where the edge is out of reach
        let ahead = |k: usize| {
            let (sin, cos) = at(k).sin_cos();
            let place = Vector::new(cos, sin, 0.0) * self.radius + Vector::z() * self.height;
            let is_near = (place - Vector::from(b.position)).norm() < 1.1 * reach;
            is_near.then(|| self.at(b, at(k)).ahead)
        };
        let mut before = ahead(0);
        for k in 1..=count {
            let here = ahead(k);
            let is_between = before.is_some_and(|a| a > 0.0) && here.is_some_and(|a| a <= 0.0);
            if is_between {
                let is_behind = |angle: f64| self.at(b, angle).ahead > 0.0;
                let (low, high) = bisected(at(k - 1), at(k), is_behind);
                let place = self.at(b, 0.5 * (low + high));
                // else the shortest way out jumps there from one side of the body to the other
                if place.ahead.abs() < 1e-9 && place.depth > -1e-9 && place.inside < 1.0 + 1e-9 {
                    let [p, q] = [low - 1e-5, high + 1e-5].map(|angle| self.at(b, angle).ahead);
                    let m = -place.normal;
                    let over = m.dot(&place.radial) * self.inwards[0] + m.z * self.inwards[1];
                    let is_clear = p - q > 1e-6 * self.radius
                        && over.abs() > 1e-6
                        && place.depth > 1e-9
                        && place.inside < 1.0 - 1e-9;
                    if !is_clear {
                        return None;
                    }
                    if over < 0.0 {
                        found.push((place.depth, place.normal));
                    }
                }
            }
            before = here;
        }
        Some(found)
    }
}

/// Where a condition ends that holds at the first of two angles.
fn bisected(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> (f64, f64) {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    (low, high)
}

/// A body that is by a part of its smallest semi-axis beyond a place of an edge, with a normal there between that of the surface on one side
/// and that on the other.
fn touching(edge: &Edge, stream: &mut Stream) -> Body {
    let size = stream.log_uniform(0.02, 0.6);
    let axes = semi_axes(stream).map(|a| a * size);
    let (sin, cos) = stream.uniform(0.0, TAU).sin_cos();
    let radial = Vector::new(cos, sin, 0.0);
    let (s, c) = stream.uniform(-1.7, 1.7).sin_cos();
    let [r, z] = edge.inwards;
    let n = radial * (r * c - z * s) + Vector::z() * (z * c + r * s);
    let turn = lying(axes, radial.cross(&Vector::z()), stream);
    let mut b = body(axes, Vector::zeros(), turn);
    let smallest = axes.into_iter().fold(f64::INFINITY, f64::min);
    let place = radial * edge.radius + Vector::z() * edge.height;
    let depth = smallest * stream.log_uniform(1e-6, 0.1);
    b.position = (place + n * depth - witness(&b, &n)).into();
    b
}

#[test]
fn rims_act_where_bodies_are_deepest_along_them() {
    let laws = laws(&["hertz 1e5 0.3"]);
    let mut stream = Stream::new(6);
    let bounds = [-0.3, 0.4];
    for slope in [0.0f64, 0.3, -0.5, 2.0] {
        let radius = |z: f64| 1.0 + slope * z;
        let name = if slope == 0.0 { "cylinder" } else { "cone" };
        let mut wall = Wall::new();
        let parameters = ShapeParameters {
            point: Vector3::ZERO,
            axis: Vector3::new(0.0, 0.0, 1.0),
            radii: bounds.map(radius),
            bounds,
            ends: [End::Open; 2],
            side: Side::OfCentre,
        };
        wall.add_shape(name, &parameters).unwrap();
        wall.records_contacts = true;
        let length = slope.hypot(1.0);
        let edges = [(bounds[0], 1.0), (bounds[1], -1.0)].map(|(height, up)| Edge {
            height,
            radius: radius(height),
            inwards: [up * slope / length, up / length],
        });
        let mut counts = [0; 6];
        for k in 0..400 {
            let b = touching(&edges[k % 2], &mut stream);
            let [x, y, z] = b.position;
            let place = Place {
                surface: Surface::Cone { slope },
                within: x.hypot(y) <= radius(z),
            };
            let Some(mut expected) = place.contacts_between(&b, bounds) else {
                continue;
            };
            let [Some(low), Some(high)] = [0, 1].map(|k: usize| edges[k].contacts(&b)) else {
                continue;
            };
            expected.extend(low.into_iter().chain(high));
            expected.sort_by(|a, b| b.0.total_cmp(&a.0));
            for set in instruction_sets() {
                let found = contacts(&mut wall, &laws, &b, set);
                assert!(
                    are_same(&found, &expected),
                    "{name} of slope {slope}, {}: {found:?} where {expected:?} is expected, {b:?}",
                    set.name()
                );
            }
            counts[expected.len()] += 1;
        }
        println!("{name} of slope {slope}: {counts:?} poses by their contacts");
        assert!(counts[1] > 150 && counts[2] > 5, "{slope}: {counts:?}");
    }
}
