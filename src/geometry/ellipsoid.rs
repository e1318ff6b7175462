// SPDX-License-Identifier: MIT OR Apache-2.0
//! An ellipsoid by its support function.
//!
//! With `R` the rotation from body to world and `D = diag(a1, a2, a3)` the semi-axes, the shape matrix is
//! `S = R D^2 R^T`. It is never formed: `h = |D R^T n|` and `S n / h = R D (D R^T n) / h` have an error of the order
//! of rounding times the largest semi-axis, while the formed matrix loses a factor of the aspect ratio more.
//!
//! # Example
//! ```
//! use ellgran::geometry::ellipsoid::{LARGEST_ASPECT_RATIO, LARGEST_SEMI_AXIS, LEAST_SEMI_AXIS};
//! use ellgran::geometry::{Ellipsoid, ShapeError};
//! use ellgran::vector::{Tangent, Vector3};
//!
//! // A grain of 2 x 1 x 1 mm (semi-axes in m), turned by 90 degrees about z: its long axis lies along y.
//! let turn = [0.5f64.sqrt(), 0.0, 0.0, 0.5f64.sqrt()];
//! let grain = Ellipsoid::new([2e-3, 1e-3, 1e-3], turn).expect("an ellipsoid");
//! let volume = 4.0 / 3.0 * core::f64::consts::PI * 2e-9;
//! assert!((grain.volume() / volume - 1.0).abs() < 1e-14);
//! // Moments about the body axes, m (b^2 + c^2)/5, of 10 mg (kg m^2).
//! let inertia = grain.moments_of_inertia(1e-5);
//! assert!((inertia.x / (1e-5 * 2e-6 / 5.0) - 1.0).abs() < 1e-14);
//! assert!((grain.squares_across().y / 5e-6 - 1.0).abs() < 1e-14);
//! assert_eq!((grain.bounding_radius(), grain.smallest_semi_axis()), (2e-3, 1e-3));
//! assert!(!grain.is_sphere());
//! let long_axis = grain.to_world(Vector3::new(1.0, 0.0, 0.0));
//! assert!((long_axis - Vector3::new(0.0, 1.0, 0.0)).norm() < 1e-15);
//! assert!((grain.to_body(long_axis).x - 1.0).abs() < 1e-15);
//!
//! // The tip: 2 mm from the centre, curvature a/b^2 in all directions, radius of curvature 0.5 mm.
//! let n = Vector3::new(0.0, 1.0, 0.0);
//! let tip = grain.support(n);
//! assert!((tip.h / 2e-3 - 1.0).abs() < 1e-14 && (tip.point - n * 2e-3).norm() < 1e-17);
//! let curvature = grain.weingarten(&tip, &Tangent::new(n));
//! assert!((curvature.uu / 2e3 - 1.0).abs() < 1e-13 && (curvature.vv / 2e3 - 1.0).abs() < 1e-13);
//! assert!((grain.inscribed_radius(&tip) / 0.5e-3 - 1.0).abs() < 1e-13);
//! // det V = h^4/(a1 a2 a3)^2.
//! let determinant = tip.h.powi(4) / grain.shape_determinant();
//! assert!((curvature.determinant() / determinant - 1.0).abs() < 1e-13);
//!
//! // What can be no grain.
//! for (semi_axes, wrong) in [
//!     ([0.5 * LEAST_SEMI_AXIS; 3], ShapeError::SemiAxis(0.5 * LEAST_SEMI_AXIS)),
//!     ([2.0 * LARGEST_SEMI_AXIS; 3], ShapeError::SemiAxis(2.0 * LARGEST_SEMI_AXIS)),
//!     ([4.0 * LARGEST_ASPECT_RATIO, 1.0, 1.0], ShapeError::AspectRatio(4.0 * LARGEST_ASPECT_RATIO)),
//! ] {
//!     assert_eq!(Ellipsoid::new(semi_axes, turn).unwrap_err(), wrong);
//! }
//! ```

use super::convex_body::{ConvexBody, SquaredSupport, SupportInFrame};
use crate::real::Real;
use crate::vector::{Symmetric2, Tangent, Vector2, Vector3};

/// Shape and pose of an ellipsoid; the centre is kept apart, since only differences of centres matter.
#[derive(Clone, Copy, Debug)]
pub struct Ellipsoid<T = f64> {
    /// Body axes as unit vectors in the world frame: the columns of the rotation.
    pub axes: [Vector3<T>; 3],
    /// Semi-axes along them, > 0, length.
    pub semi_axes: Vector3<T>,
    /// Their inverses, 1/length.
    pub inverse_semi_axes: Vector3<T>,
}

/// Smallest and largest semi-axis, length. The sixth power of their ratio must be far within double precision.
pub const LEAST_SEMI_AXIS: f64 = 1e-20;
/// See [`LEAST_SEMI_AXIS`].
pub const LARGEST_SEMI_AXIS: f64 = 1e20;
/// Largest over smallest semi-axis. Curvatures at one point differ by its square, and the determinant of their matrix, which
/// loses as many digits, must stay greater than zero.
pub const LARGEST_ASPECT_RATIO: f64 = 1e6;

/// What is wrong with a shape or a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShapeError {
    /// A semi-axis that is not between [`LEAST_SEMI_AXIS`] and [`LARGEST_SEMI_AXIS`].
    SemiAxis(f64),
    /// A largest over a smallest semi-axis greater than [`LARGEST_ASPECT_RATIO`].
    AspectRatio(f64),
    /// A quaternion with an entry that is not finite, or of length zero; the value is its squared length.
    Quaternion(f64),
}

/// The support function and the witness of one body for one direction.
#[derive(Clone, Copy, Debug)]
pub struct Support<T = f64> {
    /// `h(n) = max n.(p - x)` over the surface, length.
    pub h: T,
    /// `1/h`.
    pub inverse_h: T,
    /// The surface point with outward normal `n`, from the centre, world frame.
    pub point: Vector3<T>,
    /// `R^T n`: the direction in body axes.
    pub local_normal: Vector3<T>,
}

impl Ellipsoid<f64> {
    /// From semi-axes (length, along the body axes) and a quaternion `(w, x, y, z)`, body to world.
    ///
    /// The quaternion is normalised here, so that one that drifted is as good as a unit one.
    ///
    /// # Errors
    /// [`ShapeError`] with the offending value.
    #[inline]
    pub fn new(semi_axes: [f64; 3], quaternion: [f64; 4]) -> Result<Self, ShapeError> {
        for a in semi_axes {
            if !(LEAST_SEMI_AXIS..=LARGEST_SEMI_AXIS).contains(&a) {
                return Err(ShapeError::SemiAxis(a));
            }
        }
        let [a, b, c] = semi_axes;
        let ratio = a.max(b).max(c) / a.min(b).min(c);
        if ratio > LARGEST_ASPECT_RATIO {
            return Err(ShapeError::AspectRatio(ratio));
        }
        let quaternion = within_range(quaternion)?;
        let [w, x, y, z] = quaternion;
        let length = w * w + x * x + y * y + z * z;
        Ok(Ellipsoid {
            axes: rotation_columns(quaternion, 2.0 / length),
            semi_axes: Vector3::from_array(semi_axes),
            inverse_semi_axes: Vector3::from_array(semi_axes.map(|a| 1.0 / a)),
        })
    }

    /// Volume.
    pub fn volume(&self) -> f64 {
        let a = self.semi_axes;
        4.0 / 3.0 * core::f64::consts::PI * a.x * a.y * a.z
    }

    /// Sums of the squares of the two semi-axes across each body axis, length^2: five times the principal moments of inertia
    /// of a solid ellipsoid over its mass.
    pub fn squares_across(&self) -> Vector3 {
        let a = self.semi_axes;
        let (x, y, z) = (a.x * a.x, a.y * a.y, a.z * a.z);
        Vector3::new(y + z, x + z, x + y)
    }

    /// Principal moments of inertia of a solid ellipsoid about its body axes, mass x length^2.
    pub fn moments_of_inertia(&self, mass: f64) -> Vector3 {
        self.squares_across() * (0.2 * mass)
    }

    /// The largest semi-axis: radius of the bounding sphere.
    pub fn bounding_radius(&self) -> f64 {
        let a = self.semi_axes;
        a.x.max(a.y).max(a.z)
    }

    /// The smallest semi-axis.
    pub fn smallest_semi_axis(&self) -> f64 {
        let a = self.semi_axes;
        a.x.min(a.y).min(a.z)
    }

    /// Whether the three semi-axes are the same number.
    pub fn is_sphere(&self) -> bool {
        let a = self.semi_axes;
        a.x == a.y && a.y == a.z
    }
}

/// A quaternion of the same rotation whose squared length is a normal number; the same one where its own is.
pub(crate) fn within_range(q: [f64; 4]) -> Result<[f64; 4], ShapeError> {
    let square: f64 = q.iter().map(|q| q * q).sum();
    if square > 1e-280 && square < 1e280 {
        return Ok(q);
    }
    let largest = q.iter().fold(0.0f64, |m, q| m.max(q.abs()));
    if !(largest > 0.0 && q.iter().all(|q| q.is_finite())) {
        return Err(ShapeError::Quaternion(square));
    }
    Ok(q.map(|q| q / largest))
}

/// The columns of the rotation of a quaternion `(w, x, y, z)`; `scale` is 2 over its squared length.
#[doc(hidden)]
#[inline(always)]
pub fn rotation_columns<T: Real>([w, x, y, z]: [T; 4], scale: T) -> [Vector3<T>; 3] {
    let one = w.constant(1.0);
    let (x2, y2, z2) = (x * scale, y * scale, z * scale);
    let (wx, wy, wz) = (w * x2, w * y2, w * z2);
    let (yy, zz) = (y * y2, z * z2);
    [
        Vector3::new(
            one - yy - zz,
            x.multiply_add(y2, wz),
            x.multiply_subtract(z2, wy),
        ),
        Vector3::new(
            x.multiply_subtract(y2, wz),
            x.negative_multiply_add(x2, one - zz),
            y.multiply_add(z2, wx),
        ),
        Vector3::new(
            x.multiply_add(z2, wy),
            y.multiply_subtract(z2, wx),
            x.negative_multiply_add(x2, one - yy),
        ),
    ]
}

impl<T: Real> Ellipsoid<T> {
    /// A world vector in body axes.
    #[inline(always)]
    pub fn to_body(&self, w: Vector3<T>) -> Vector3<T> {
        Vector3::new(
            self.axes[0].dot(w),
            self.axes[1].dot(w),
            self.axes[2].dot(w),
        )
    }

    /// A vector in body axes in the world frame.
    #[inline(always)]
    pub fn to_world(&self, b: Vector3<T>) -> Vector3<T> {
        self.axes[0].scale_add(b.x, self.axes[1].scale_add(b.y, self.axes[2] * b.z))
    }

    /// Support function and witness for the unit vector `n`.
    #[inline(always)]
    pub fn support(&self, n: Vector3<T>) -> Support<T> {
        let local_normal = self.to_body(n);
        let z = self.semi_axes.componentwise(local_normal);
        let square = z.norm_squared();
        let inverse_h = square.reciprocal_sqrt();
        let h = square * inverse_h;
        let point = self.to_world(self.semi_axes.componentwise(z) * inverse_h);
        Support {
            h,
            inverse_h,
            point,
            local_normal,
        }
    }

    /// The Weingarten map (curvature, 1/length) at the surface point with normal `n`, in the tangent basis: the
    /// level-set form `V = h T^T S^-1 T`, a Gram matrix, hence positive and free of cancellation.
    ///
    /// Its eigenvalues are the principal curvatures. The inverse Weingarten map of docs/theory.md, section 1, is its inverse;
    /// `det V = h^4 / (a1 a2 a3)^2`.
    #[inline(always)]
    pub fn weingarten(&self, support: &Support<T>, tangent: &Tangent<T>) -> Symmetric2<T> {
        let view = self.view_from(support.local_normal, tangent);
        self.weingarten_in_frame(&view, support.h)
    }

    #[inline(always)]
    fn view_from(&self, local_normal: Vector3<T>, tangent: &Tangent<T>) -> AxesInBody<T> {
        let u = self.to_body(tangent.u);
        AxesInBody {
            n: local_normal,
            u,
            // v = n x u, in body axes as well.
            v: local_normal.cross(u),
        }
    }

    /// Radius of the largest ball in the ellipsoid that touches its surface at the witness: `a_min^2/h`.
    #[inline(always)]
    pub fn inscribed_radius(&self, support: &Support<T>) -> T {
        self.inscribed_radius_at(support.inverse_h)
    }

    #[inline(always)]
    fn inscribed_radius_at(&self, inverse_h: T) -> T {
        let a = self.semi_axes;
        let least = a.x.min(a.y).min(a.z);
        least * least * inverse_h
    }

    /// `(a1 a2 a3)^2`.
    #[inline(always)]
    pub fn shape_determinant(&self) -> T {
        let p = self.semi_axes.x * self.semi_axes.y * self.semi_axes.z;
        p * p
    }
}

/// The axes of a frame in body axes.
#[derive(Clone, Copy, Debug)]
pub struct AxesInBody<T = f64> {
    n: Vector3<T>,
    u: Vector3<T>,
    v: Vector3<T>,
}

impl<T: Real> ConvexBody<T> for Ellipsoid<T> {
    type View = AxesInBody<T>;

    #[inline(always)]
    fn view(&self, n: Vector3<T>, tangent: &Tangent<T>) -> AxesInBody<T> {
        self.view_from(self.to_body(n), tangent)
    }

    #[inline(always)]
    fn squared_support(&self, view: &AxesInBody<T>) -> SquaredSupport<T> {
        let a = self.semi_axes;
        let z = a.componentwise(view.n);
        let z_u = a.componentwise(view.u);
        let z_v = a.componentwise(view.v);
        SquaredSupport {
            constant: z.norm_squared(),
            linear: Vector2::new(z.dot(z_u), z.dot(z_v)),
            quadratic: Symmetric2::new(z_u.norm_squared(), z_u.dot(z_v), z_v.norm_squared()),
        }
    }

    #[inline(always)]
    fn support_in_frame(&self, view: &AxesInBody<T>) -> SupportInFrame<T> {
        let a = self.semi_axes;
        let z = a.componentwise(view.n);
        let square = z.norm_squared();
        let inverse_h = square.reciprocal_sqrt();
        let y = a.componentwise(z);
        SupportInFrame {
            h: square * inverse_h,
            inverse_h,
            witness: Vector2::new(y.dot(view.u), y.dot(view.v)) * inverse_h,
        }
    }

    #[inline(always)]
    fn weingarten_in_frame(&self, view: &AxesInBody<T>, h: T) -> Symmetric2<T> {
        let inverse = self.inverse_semi_axes;
        let u = view.u.componentwise(inverse);
        let v = view.v.componentwise(inverse);
        Symmetric2::new(u.norm_squared(), u.dot(v), v.norm_squared()) * h
    }

    #[inline(always)]
    fn inscribed_radius(&self, inverse_h: T) -> T {
        self.inscribed_radius_at(inverse_h)
    }

    #[inline(always)]
    fn squared_product(&self) -> T {
        self.shape_determinant()
    }

    #[inline(always)]
    fn support_in_world(&self, n: Vector3<T>) -> (T, Vector3<T>) {
        let support = self.support(n);
        (support.h, support.point)
    }

    #[inline(always)]
    fn extreme_semi_axes(&self) -> [T; 2] {
        let a = self.semi_axes;
        [a.x.max(a.y).max(a.z), a.x.min(a.y).min(a.z)]
    }

    #[inline(always)]
    fn radius_of_sphere(&self) -> (T, T) {
        (self.semi_axes.x, self.inverse_semi_axes.x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_has_three_equal_semi_axes() {
        let turn = [1.0, 0.0, 0.0, 0.0];
        for (semi_axes, is) in [
            ([2.0, 2.0, 2.0], true),
            ([2.0, 2.0, 1.0], false),
            ([2.0, 1.0, 2.0], false),
            ([1.0, 2.0, 2.0], false),
            ([1.0, 2.0, 3.0], false),
        ] {
            let body = Ellipsoid::new(semi_axes, turn).unwrap();
            assert_eq!(body.is_sphere(), is, "{semi_axes:?}");
        }
    }
}
