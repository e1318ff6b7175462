// SPDX-License-Identifier: MIT OR Apache-2.0
//! Relative curvature of two surfaces at their contact (docs/theory.md, section 1; the paper's Eq. (5) in one tangent basis).

use super::ellipsoid::{Ellipsoid, Support};
use crate::real::Real;
use crate::vector::{Symmetric2, Tangent, Vector3};

/// `M = (W_i^-1 + W_j^-1) / 2` in principal axes.
#[derive(Clone, Copy, Debug)]
pub struct Curvature {
    /// Smaller relative curvature `A`, 1/length, along the major semi-axis of the contact ellipse.
    pub a: f64,
    /// Larger relative curvature `B >= A`, 1/length.
    pub b: f64,
    /// Unit world vector along the major semi-axis of the contact ellipse; any tangent vector when `A = B`.
    pub major_direction: Vector3,
}

/// `A`, `B` and the direction of `A` from `M` in a tangent basis.
pub fn relative_curvature(m: Symmetric2, tangent: &Tangent) -> Curvature {
    let (a, b, direction) = m.eigen();
    Curvature {
        a: a.min(b),
        b,
        major_direction: tangent.vector(direction),
    }
}

/// The inverse `W` (radii of curvature, length) of a Weingarten map `V`: `adj V (a1 a2 a3)^2 / h^4`, without cancellation.
/// `inverse_h` is `1/h`, `squared_product` is `(a1 a2 a3)^2`.
#[inline(always)]
pub fn inverse_weingarten<T: Real>(
    weingarten: Symmetric2<T>,
    inverse_h: T,
    squared_product: T,
) -> Symmetric2<T> {
    let square = inverse_h * inverse_h;
    weingarten.adjugate() * (squared_product * (square * square))
}

/// The inverse Weingarten map of an ellipsoid at a support, in the tangent basis. By a quotient, where
/// [`inverse_weingarten`] has the inverse of `h` at hand.
#[inline(always)]
pub fn radii_of_curvature(body: &Ellipsoid, support: &Support, tangent: &Tangent) -> Symmetric2 {
    let h2 = support.h * support.h;
    body.weingarten(support, tangent).adjugate() * (body.shape_determinant() / (h2 * h2))
}
