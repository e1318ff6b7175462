// SPDX-License-Identifier: MIT OR Apache-2.0
//! From within a body, in which direction is its surface nearest to a line?

use super::ellipsoid::Ellipsoid;
use super::interior_point::nearest_normal;
use crate::vector::{Symmetric2, Tangent, Vector2, Vector3};

/// The unit vector `n` across `along` that makes `h(n) - n.y` smallest: from within the body to the surface nearest to the
/// line through `y`. `None` if the line does not pass through the body.
pub(crate) fn nearest_across(body: &Ellipsoid, y: Vector3, along: Vector3) -> Option<Vector3> {
    let basis = Tangent::new(along);
    // The body's outline along the line is the ellipse of the shape matrix in the two directions across.
    let scaled = |e: Vector3| body.semi_axes.componentwise(body.to_body(e));
    let (p, q) = (scaled(basis.u), scaled(basis.v));
    let outline = Symmetric2::new(p.norm_squared(), p.dot(q), q.norm_squared());
    let (small, large, minor) = outline.eigen();
    let place = basis.components(y);
    let minor_axis = minor;
    let major_axis = Vector2::new(-minor.v, minor.u);
    let local = [place.dot(minor_axis), place.dot(major_axis)];
    let n = nearest_normal([small.sqrt(), large.sqrt()], local)?;
    let mut n = basis
        .vector(minor_axis * n[0] + major_axis * n[1])
        .normalised();
    // The outline's matrix has lost digits of its minor axis; the support function has them.
    for _ in 0..3 {
        let t = along.cross(n);
        let support = body.support(n);
        let first = t.dot(support.point) - t.dot(y);
        let f = support.h - n.dot(y);
        let bend = (scaled(t).norm_squared() - t.dot(support.point).powi(2)) / support.h;
        let second = bend - f;
        if !(second > 0.0) || first.abs() > 0.1 * second {
            break;
        }
        n = (n - t * (first / second)).normalised();
    }
    Some(n)
}
