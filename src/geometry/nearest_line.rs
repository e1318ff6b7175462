// SPDX-License-Identifier: MIT OR Apache-2.0
//! In which direction is the surface of a body nearest to a line?

use super::ellipsoid::Ellipsoid;
use super::interior_point::{nearest_normal, normal_towards};
use crate::vector::{Symmetric2, Tangent, Vector2, Vector3};

/// The unit vector `n` across `along` that makes `h(n) - n.y` smallest: from within the body to the surface nearest to the
/// line through `y`. `None` if the line does not pass through the body.
pub(crate) fn nearest_across(body: &Ellipsoid, y: Vector3, along: Vector3) -> Option<Vector3> {
    let outline = Outline::new(body, along);
    let n = nearest_normal(outline.semi_axes, outline.local(y))?;
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
