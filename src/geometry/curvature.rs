// SPDX-License-Identifier: MIT OR Apache-2.0
//! Relative curvature of two surfaces at their contact (docs/theory.md, section 1; the paper's Eq. (5) in one tangent basis).
//!
//! # Example
//! ```
//! use ellgran::geometry::curvature::inverse_weingarten;
//! use ellgran::geometry::{radii_of_curvature, relative_curvature, Ellipsoid};
//! use ellgran::vector::{Symmetric2, Tangent, Vector3};
//!
//! // The belly of a grain of semi-axes 2, 1, 1 mm: radii of curvature a^2/b = 4 mm along it and 1 mm around it.
//! let grain = Ellipsoid::new([2e-3, 1e-3, 1e-3], [1.0, 0.0, 0.0, 0.0]).expect("an ellipsoid");
//! let n = Vector3::new(0.0, 0.0, 1.0);
//! let (support, tangent) = (grain.support(n), Tangent::towards(Vector3::new(1.0, 0.0, 0.0), n));
//! let radii = radii_of_curvature(&grain, &support, &tangent);
//! assert!((radii.uu / 4e-3 - 1.0).abs() < 1e-13 && (radii.vv / 1e-3 - 1.0).abs() < 1e-13);
//! let weingarten = grain.weingarten(&support, &tangent);
//! let same = inverse_weingarten(weingarten, 1.0 / support.h, grain.shape_determinant());
//! assert!((same.uu / radii.uu - 1.0).abs() < 1e-13);
//!
//! // On a plane the relative curvatures are half of the grain's: A = 125/m along it, B = 500/m around it.
//! let half = Symmetric2::new(0.5 * weingarten.uu, 0.5 * weingarten.uv, 0.5 * weingarten.vv);
//! let found = relative_curvature(half, &tangent);
//! assert!((found.a / 125.0 - 1.0).abs() < 1e-13 && (found.b / 500.0 - 1.0).abs() < 1e-13);
//! assert!((found.major_direction.x.abs() - 1.0).abs() < 1e-14);
//! ```

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
