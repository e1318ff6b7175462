// SPDX-License-Identifier: MIT OR Apache-2.0
//! A sphere as a wall: a bowl from within, a ball from without.
//!
//! From within, each local maximum of the distance of the body's surface from the sphere's centre, beyond the radius, is a
//! contact; an ellipsoid has one or two. With `x` the body's centre from that of the sphere, along the body's axes, they are
//! `s_k = x_k a_k^2/(l - a_k^2)` from the body's centre, `l` a root of `sum (x_k a_k/(l - a_k^2))^2 = 1`: the one beyond the
//! square of the largest semi-axis is the farthest point, and the first one below it, where the sum rises, the other maximum. Between the
//! squares of the largest two, that is: below the square of a second axis the distance grows along this axis. A lens, whose largest
//! two are equal, has one maximum.

use super::plane::flat;
use super::shape::{Ball, Grain, Side};
#[cfg(feature = "std")]
use super::shape::{Block, Found, Search, Shape, ShapeParameters};
use crate::contact::staged::WallSurface;
#[cfg(feature = "std")]
use crate::geometry::ellipsoid::{LARGEST_SEMI_AXIS, LEAST_SEMI_AXIS};
use crate::geometry::{search, Ellipsoid, Outcome};
#[cfg(feature = "std")]
use crate::message::Number;
#[cfg(not(feature = "std"))]
use crate::real::{Functions, Real};
use crate::vector::Vector3;

/// A sphere.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct SphereWall {
    centre: Vector3,
    radius: f64,
    side: Side,
}

#[cfg(feature = "std")]
pub(super) fn add(p: &ShapeParameters, parts: &mut Vec<Box<dyn Shape>>) -> Result<(), String> {
    let radius = p.radii[0];
    if !(LEAST_SEMI_AXIS..=LARGEST_SEMI_AXIS).contains(&radius) {
        return Err(format!(
            "sphere: radius = {} must be greater than 0, from {LEAST_SEMI_AXIS:e} to {LARGEST_SEMI_AXIS:e}",
            Number(radius)
        ));
    }
    parts.push(Box::new(SphereWall {
        centre: p.point,
        radius,
        side: p.side,
    }));
    Ok(())
}

impl SphereWall {
    fn surface_at(&self, outwards: Vector3, within: bool) -> WallSurface {
        let signed = if within { -self.radius } else { self.radius };
        let normal = if within { -outwards } else { outwards };
        WallSurface {
            curvatures: [1.0 / signed; 2],
            turning_radii: [signed; 2],
            ..flat(self.centre + outwards * self.radius, normal)
        }
    }

    /// As `Shape::may_touch`.
    #[inline(always)]
    pub(super) fn is_near(&self, ball: &Ball) -> bool {
        let outwards = (ball.centre - self.centre).norm() - self.radius;
        self.side.may_touch(outwards, ball.radius)
    }

    /// As `Shape::touch`.
    pub(super) fn contacts(&self, grain: &Grain<'_>, mut found: impl FnMut(&WallSurface)) {
        let Grain { body, centre, .. } = *grain;
        let x = centre - self.centre;
        if self.side.is_within(|| x.norm() <= self.radius) {
            for point in farthest(body, x).into_iter().flatten() {
                let distance = point.norm();
                if distance > self.radius {
                    found(&self.surface_at(point * (1.0 / distance), true));
                }
            }
            return;
        }
        let outwards = if body.is_sphere() {
            x.direction()
        } else {
            let r = Vector3::new(self.radius, self.radius, self.radius);
            let i = 1.0 / self.radius;
            let ball = Ellipsoid {
                axes: [
                    Vector3::new(1.0, 0.0, 0.0),
                    Vector3::new(0.0, 1.0, 0.0),
                    Vector3::new(0.0, 0.0, 1.0),
                ],
                semi_axes: r,
                inverse_semi_axes: Vector3::new(i, i, i),
            };
            match search(body, &ball, -x, None) {
                Outcome::Touching(contact) if contact.penetration > 0.0 => Some(-contact.normal),
                _ => None,
            }
        };
        if let Some(outwards) = outwards {
            found(&self.surface_at(outwards, false));
        }
    }
}

#[cfg(feature = "std")]
impl Shape for SphereWall {
    fn remembered(&self) -> usize {
        2
    }

    fn may_touch(&self, ball: &Ball) -> bool {
        self.is_near(ball)
    }

    fn may_touch_block(&self, block: &Block) -> bool {
        let spread = block.half_edges().norm();
        let distances = block.distances(block.centre() - self.centre, spread);
        let outwards = distances.map(|distance| distance - self.radius);
        self.side.may_touch_block(outwards, block.radius())
    }

    fn touch(&self, grain: &Grain<'_>, _: &mut Search, found: &mut Found<'_>) {
        self.contacts(grain, |surface| found(surface, 0));
    }
}

/// The points of a body, whose centre is at `x`, at which the distance from the origin is a local maximum; the farthest first.
fn farthest(body: &Ellipsoid, x: Vector3) -> [Option<Vector3>; 2] {
    let a = body.semi_axes.to_array();
    let p = body.to_body(x).to_array();
    let largest = body.bounding_radius();
    let is_largest = |k: usize| a[k] == largest;
    // With m = l - largest^2 no difference of near numbers is left but in the axes' own squares.
    let gap = |k: usize| (largest - a[k]) * (largest + a[k]);
    let sums = |m: f64| {
        let (mut value, mut slope) = (-1.0, 0.0);
        for k in 0..3 {
            if p[k] != 0.0 {
                let bottom = m + gap(k);
                let term = (a[k] * p[k] / bottom).powi(2);
                value += term;
                slope -= 2.0 * term / bottom;
            }
        }
        (value, slope)
    };
    let world = |s: [f64; 3]| x + body.to_world(Vector3::from_array(s));
    let at = |m: f64| world(core::array::from_fn(|k| p[k] * a[k] * a[k] / (m + gap(k))));
    let along = (0..3)
        .filter(|&k| is_largest(k))
        .map(|k| p[k] * p[k])
        .sum::<f64>()
        .sqrt();
    let start = largest * along;
    if start == 0.0 {
        // On the plane of symmetry: the others alone may reach the root, else the two tips are alike.
        let others: f64 = (0..3)
            .filter(|&k| !is_largest(k))
            .map(|k| (a[k] * p[k] / gap(k)).powi(2))
            .sum();
        if others <= 1.0 {
            let mut s: [f64; 3] = core::array::from_fn(|k| {
                if is_largest(k) {
                    0.0
                } else {
                    p[k] * a[k] * a[k] / gap(k)
                }
            });
            let first = (0..3).find(|&k| is_largest(k)).unwrap_or(0);
            s[first] = largest * (1.0 - others).sqrt();
            let one = world(s);
            if (0..3).filter(|&k| is_largest(k)).count() > 1 {
                // A disc or a ball that is concentric touches all around; any point serves.
                return [Some(one), None];
            }
            s[first] = -s[first];
            return [Some(one), Some(world(s))];
        }
    }
    // The sum falls and is convex right of its last pole: Newton's method from the left rises to the root.
    let mut m = start.max(f64::MIN_POSITIVE.max(1e-14 * largest * largest));
    for _ in 0..200 {
        let (value, slope) = sums(m);
        let step = -value / slope;
        if !(step > 1e-15 * m) {
            break;
        }
        m += step;
    }
    // Left of it, down to the next pole, the sum is convex too, and Newton's method falls from the right to the root where it
    // rises, if there is one.
    let next = (0..3)
        .filter(|&k| !is_largest(k))
        .map(gap)
        .fold(f64::INFINITY, f64::min);
    let is_alone = (0..3).filter(|&k| is_largest(k)).count() == 1;
    let mut below = -start;
    let mut other = None;
    if is_alone && start > 0.0 {
        for _ in 0..200 {
            if !(below > -next) {
                break;
            }
            let (value, slope) = sums(below);
            if !(slope > 0.0) {
                break;
            }
            let step = value / slope;
            if !(step > 1e-15 * below.abs()) {
                other = Some(at(below));
                break;
            }
            below -= step;
        }
    }
    [Some(at(m)), other]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Local maxima of the distance on a grid of the body's surface.
    fn maxima(body: &Ellipsoid, x: Vector3) -> Vec<f64> {
        let (rows, columns) = (400, 800);
        let a = body.semi_axes.to_array();
        let distance = |i: i64, j: i64| {
            let t = std::f64::consts::PI * (i as f64 + 0.5) / rows as f64;
            let p = std::f64::consts::TAU * j as f64 / columns as f64;
            let local = [
                a[0] * t.sin() * p.cos(),
                a[1] * t.sin() * p.sin(),
                a[2] * t.cos(),
            ];
            (x + body.to_world(Vector3::from_array(local))).norm()
        };
        let mut all = vec![];
        for i in 0..rows {
            for j in 0..columns {
                let here = distance(i, j);
                let around = (-1..=1).flat_map(|u| (-1..=1).map(move |v| (u, v)));
                if around
                    .filter(|w| *w != (0, 0))
                    .all(|(u, v)| here >= distance(i + u, j + v))
                {
                    all.push(here);
                }
            }
        }
        all.sort_by(|a, b| b.total_cmp(a));
        all.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        all
    }

    #[test]
    fn the_maxima_are_those_of_a_grid() {
        let body = |axes| Ellipsoid::new(axes, [0.9, 0.1, 0.4, 0.1]).unwrap();
        for (axes, place) in [
            ([1.0, 0.5, 0.3], [0.3, 0.2, 0.1]),
            ([1.0, 0.1, 0.1], [0.02, 0.3, 0.1]),
            ([0.3, 0.2, 1.0], [0.0, 0.0, 1.0]),
            ([1.0, 0.9, 0.2], [0.05, 0.02, 2.0]),
            ([1.0, 0.6, 0.3], [3.0, 0.4, 0.2]),
        ] {
            let body = body(axes);
            // along the body's own axes, so that symmetric places are symmetric
            let x = body.to_world(Vector3::from_array(place));
            let found: Vec<f64> = farthest(&body, x)
                .into_iter()
                .flatten()
                .map(|p| p.norm())
                .collect();
            let grid = maxima(&body, x);
            assert_eq!(
                found.len(),
                grid.len(),
                "{axes:?} {place:?}: {found:?} {grid:?}"
            );
            for (a, b) in found.iter().zip(&grid) {
                assert!(
                    (a - b).abs() < 1e-3 && a > &(b - 1e-9),
                    "{found:?} {grid:?}"
                );
            }
        }
    }
}
