// SPDX-License-Identifier: MIT OR Apache-2.0
//! In which direction is the surface of a body nearest to a line?

use super::ellipsoid::Ellipsoid;
use super::interior_point::{nearest_normal, normal_on_other_side, normal_towards};
#[cfg(not(feature = "std"))]
use crate::real::{Functions, Real};
use crate::vector::{Symmetric2, Tangent, Vector2, Vector3};

/// The unit vector `n` across `along` that makes `h(n) - n.y` smallest: from within the body to the surface nearest to the
/// line through `y`. `None` if the line does not pass through the body.
#[cfg_attr(not(feature = "std"), inline(never))]
pub(crate) fn nearest_across(body: &Ellipsoid, y: Vector3, along: Vector3) -> Option<Vector3> {
    let outline = Outline::new(body, along);
    let n = nearest_normal(outline.semi_axes, outline.local(y))?;
    Some(outline.refined(y, n))
}

/// The same to the other side of the body, where the way from there is shortest among those near it; of a line that passes through the body.
#[cfg_attr(not(feature = "std"), inline(never))]
pub(crate) fn nearest_on_other_side(
    body: &Ellipsoid,
    y: Vector3,
    along: Vector3,
) -> Option<Vector3> {
    let outline = Outline::new(body, along);
    let n = normal_on_other_side(outline.semi_axes, outline.local(y))?;
    Some(outline.refined(y, n))
}

/// The same for a line that need not pass through the body: of one beside it `h(n) - n.y` is minus the distance.
pub(crate) fn towards_line(body: &Ellipsoid, y: Vector3, along: Vector3) -> Vector3 {
    let outline = Outline::new(body, along);
    let n = normal_towards(outline.semi_axes, outline.local(y));
    outline.refined(y, n)
}

/// A body's outline along a line: the ellipse of the shape matrix in the two directions across.
struct Outline<'a> {
    body: &'a Ellipsoid,
    along: Vector3,
    basis: Tangent,
    /// The smaller one first, and their directions.
    semi_axes: [f64; 2],
    axes: [Vector2; 2],
}

impl<'a> Outline<'a> {
    fn new(body: &'a Ellipsoid, along: Vector3) -> Self {
        let basis = Tangent::new(along);
        let scaled = |e: Vector3| body.semi_axes.componentwise(body.to_body(e));
        let (p, q) = (scaled(basis.u), scaled(basis.v));
        let matrix = Symmetric2::new(p.norm_squared(), p.dot(q), q.norm_squared());
        let (small, large, minor) = matrix.eigen();
        Outline {
            body,
            along,
            basis,
            semi_axes: [small.sqrt(), large.sqrt()],
            axes: [minor, Vector2::new(-minor.v, minor.u)],
        }
    }

    fn local(&self, y: Vector3) -> [f64; 2] {
        let place = self.basis.components(y);
        self.axes.map(|axis| place.dot(axis))
    }

    /// The normal in the world from that along the outline's axes, whose matrix has lost digits of its minor axis; the support function has
    /// them.
    fn refined(&self, y: Vector3, n: [f64; 2]) -> Vector3 {
        let body = self.body;
        let [minor, major] = self.axes;
        let mut n = self.basis.vector(minor * n[0] + major * n[1]).normalised();
        for _ in 0..3 {
            let t = self.along.cross(n);
            let support = body.support(n);
            let first = t.dot(support.point) - t.dot(y);
            let f = support.h - n.dot(y);
            let scaled = body.semi_axes.componentwise(body.to_body(t));
            let bend = (scaled.norm_squared() - t.dot(support.point).powi(2)) / support.h;
            let second = bend - f;
            if !(second > 0.0) || first.abs() > 0.1 * second {
                break;
            }
            n = (n - t * (first / second)).normalised();
        }
        n
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of slender bodies too the direction is one in which the distance is smallest to the last digits: its slope vanishes, it bends up, and no
    /// direction of many is better.
    #[test]
    fn the_direction_is_that_of_the_smallest_distance() {
        let mut state = 5u64;
        let mut uniform = |low: f64, high: f64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            low + (high - low) * (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let (mut within, mut beside) = (0, 0);
        for _ in 0..400 {
            let semi_axes = [0; 3].map(|_| 10f64.powf(uniform(-3.0, 0.0)));
            let body = Ellipsoid::new(semi_axes, [0; 4].map(|_| uniform(-1.0, 1.0))).unwrap();
            let along = Vector3::from_array([0; 3].map(|_| uniform(-1.0, 1.0))).normalised();
            // The line passes by the surface, within or beside.
            let basis = Tangent::new(along);
            let angle = uniform(0.0, 6.3);
            let towards = basis.u * angle.cos() + basis.v * angle.sin();
            let y = body.support(towards).point * uniform(0.8, 1.2) + along * uniform(-1.0, 1.0);
            let n = match nearest_across(&body, y, along) {
                Some(n) => {
                    within += 1;
                    n
                }
                None => {
                    beside += 1;
                    towards_line(&body, y, along)
                }
            };
            assert!((n.norm() - 1.0).abs() < 1e-14 && n.dot(along).abs() < 1e-14);
            let at = |n: Vector3| body.support(n).h - n.dot(y);
            let t = along.cross(n);
            let slope = t.dot(body.support(n).point - y);
            // One rounding of the direction makes so much of it.
            let stretch = body.semi_axes.componentwise(body.to_body(t)).norm_squared();
            let bend = stretch / body.support(n).h + at(n).abs();
            let allowed = 40.0 * f64::EPSILON * (1.0 + bend + y.norm());
            assert!(
                slope.abs() < allowed,
                "{semi_axes:?}: {slope:e} {allowed:e}"
            );
            for k in 0..200 {
                let angle = 0.0314 * f64::from(k);
                let other = n * angle.cos() + t * angle.sin();
                assert!(at(other) > at(n) - 1e-14, "{semi_axes:?}, {angle}");
            }
        }
        assert!(within > 50 && beside > 50, "{within} {beside}");
    }
}
