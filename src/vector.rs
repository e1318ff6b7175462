// SPDX-License-Identifier: MIT OR Apache-2.0
//! Vectors of three and two components, symmetric 2x2 matrices, and the tangent basis of a unit vector.
//!
//! Small own types rather than nalgebra: they are generic over lanes ([`Real`]), and the static library that a user
//! may link with LAMMPS (GPL-2.0-only) then contains no Apache-2.0-only code.
//!
//! # Example
//! ```
//! use ellgran::vector::{Symmetric2, Tangent, Vector2, Vector3};
//!
//! // Curvatures of a saddle (1/m) in a basis of its tangent plane, and the direction of the smaller one.
//! let normal = Vector3::new(0.0, 0.0, 2.0).direction().expect("a vector with a direction");
//! assert!(normal.is_unit() && normal.is_finite());
//! let basis = Tangent::new(normal);
//! assert!((basis.u.cross(basis.v) - normal).norm() < 1e-15);
//! let curvature = Symmetric2::new(3.0, 1.0, -1.0);
//! let (small, large, direction) = curvature.eigen();
//! assert!((small + large - curvature.trace()).abs() < 1e-14);
//! assert!((small * large - curvature.determinant()).abs() < 1e-14);
//! let stretched = curvature.apply(direction);
//! assert!(stretched.scale_add(1.0, direction * -small).dot(direction).abs() < 1e-14);
//! assert!((curvature.shifted(2.0).trace() - 6.0).abs() < 1e-15);
//!
//! // The inverse is the adjugate over the determinant.
//! let back = curvature.adjugate().apply(stretched) * (1.0 / curvature.determinant());
//! assert!((back.u - direction.u).abs() < 1e-14 && (back.v - direction.v).abs() < 1e-14);
//!
//! // To the world and back; a basis that begins with a given direction.
//! let in_world = basis.vector(direction);
//! let components = basis.components(in_world);
//! assert!((components.dot(direction) - 1.0).abs() < 1e-14);
//! let along = Tangent::towards(Vector3::new(1.0, 0.0, 5.0), normal);
//! assert!((along.u - Vector3::new(1.0, 0.0, 0.0)).norm() < 1e-15);
//! assert_eq!(along.components(Vector3::new(2.0, 0.0, 7.0)), Vector2::new(2.0, 0.0));
//!
//! let (a, b) = (Vector3::new(1.0, 2.0, 3.0), Vector3::new(4.0, 5.0, 6.0));
//! assert_eq!(a.componentwise(b), Vector3::new(4.0, 10.0, 18.0));
//! assert_eq!(a.scale_add(2.0, b), Vector3::new(6.0, 9.0, 12.0));
//! assert_eq!(Vector3::select(a.dot(b) > 0.0, a, b), a);
//! assert!((b.normalised().norm_squared() - 1.0).abs() < 1e-15);
//! ```

#[cfg(not(feature = "std"))]
use crate::real::Functions;
use crate::real::Real;
use core::ops::{Add, Mul, Neg, Sub};

/// A vector in world or body axes; the place where it is used says which.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Vector3<T = f64> {
    /// First component.
    pub x: T,
    /// Second component.
    pub y: T,
    /// Third component.
    pub z: T,
}

impl<T: Real> Vector3<T> {
    /// `if_true` where the mask holds, else `if_false`.
    #[inline(always)]
    pub fn select(mask: T::Mask, if_true: Self, if_false: Self) -> Self {
        Vector3::new(
            T::select(mask, if_true.x, if_false.x),
            T::select(mask, if_true.y, if_false.y),
            T::select(mask, if_true.z, if_false.z),
        )
    }
    /// From components.
    #[inline(always)]
    pub fn new(x: T, y: T, z: T) -> Self {
        Vector3 { x, y, z }
    }
    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, b: Self) -> T {
        self.x
            .multiply_add(b.x, self.y.multiply_add(b.y, self.z * b.z))
    }
    /// Vector product.
    #[inline(always)]
    pub fn cross(self, b: Self) -> Self {
        Vector3 {
            x: self.y.multiply_subtract(b.z, self.z * b.y),
            y: self.z.multiply_subtract(b.x, self.x * b.z),
            z: self.x.multiply_subtract(b.y, self.y * b.x),
        }
    }
    /// Component by component.
    #[inline(always)]
    pub fn componentwise(self, b: Self) -> Self {
        Vector3 {
            x: self.x * b.x,
            y: self.y * b.y,
            z: self.z * b.z,
        }
    }
    /// Square of the length.
    #[inline(always)]
    pub fn norm_squared(self) -> T {
        self.dot(self)
    }
    /// Length.
    #[inline(always)]
    pub fn norm(self) -> T {
        self.norm_squared().sqrt()
    }
    /// `self * s + b`.
    #[inline(always)]
    pub fn scale_add(self, s: T, b: Self) -> Self {
        Vector3 {
            x: self.x.multiply_add(s, b.x),
            y: self.y.multiply_add(s, b.y),
            z: self.z.multiply_add(s, b.z),
        }
    }
    /// The same direction with length one; undefined for the null vector.
    #[inline(always)]
    pub fn normalised(self) -> Self {
        self * self.norm_squared().reciprocal_sqrt()
    }
    /// Whether its length is 1, to a few parts in ten million: what a search or a file has left of a unit vector, and
    /// neither zeros nor NaN.
    #[inline(always)]
    pub fn is_unit(self) -> T::Mask {
        let square = self.norm_squared();
        (square - 1.0).abs().less(square.constant(1e-6))
    }
}

impl Vector3<f64> {
    /// The null vector.
    pub const ZERO: Vector3<f64> = Vector3 {
        x: 0.0,
        y: 0.0,
        z: 0.0,
    };
    /// From an array.
    #[inline(always)]
    pub fn from_array(a: [f64; 3]) -> Self {
        Vector3::new(a[0], a[1], a[2])
    }
    /// To an array.
    #[inline(always)]
    pub fn to_array(self) -> [f64; 3] {
        [self.x, self.y, self.z]
    }
    /// Whether all components are finite.
    #[inline(always)]
    pub fn is_finite(self) -> bool {
        // Inf * 0 and NaN * 0 are NaN: one comparison instead of three.
        (self.x + self.y + self.z) * 0.0 == 0.0
    }
    /// The unit vector in the direction of this one; `None` for the null vector and for one that is not finite.
    pub fn direction(self) -> Option<Self> {
        let square = self.norm_squared();
        if square > 1e-280 && square < 1e280 {
            return Some(self * (1.0 / square.sqrt()));
        }
        // In units of its largest component, whose square neither vanishes nor overflows.
        let largest = self.x.abs().max(self.y.abs()).max(self.z.abs());
        if !(largest > 0.0 && self.to_array().iter().all(|x| x.is_finite())) {
            return None;
        }
        let scaled = Vector3::new(self.x / largest, self.y / largest, self.z / largest);
        Some(scaled * (1.0 / scaled.norm()))
    }
}

impl<T: Real> Add for Vector3<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Vector3::new(self.x + b.x, self.y + b.y, self.z + b.z)
    }
}
impl<T: Real> Sub for Vector3<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Vector3::new(self.x - b.x, self.y - b.y, self.z - b.z)
    }
}
impl<T: Real> Neg for Vector3<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Vector3::new(-self.x, -self.y, -self.z)
    }
}
impl<T: Real> Mul<T> for Vector3<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: T) -> Self {
        Vector3::new(self.x * s, self.y * s, self.z * s)
    }
}

/// Components of a tangent vector along the two axes of a [`Tangent`] basis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vector2<T = f64> {
    /// Along `Tangent::u`.
    pub u: T,
    /// Along `Tangent::v`.
    pub v: T,
}

impl<T: Real> Vector2<T> {
    /// From components.
    #[inline(always)]
    pub fn new(u: T, v: T) -> Self {
        Vector2 { u, v }
    }
    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, b: Self) -> T {
        self.u.multiply_add(b.u, self.v * b.v)
    }
}
impl<T: Real> Vector2<T> {
    /// `self * s + b`.
    #[inline(always)]
    pub fn scale_add(self, s: T, b: Self) -> Self {
        Vector2::new(self.u.multiply_add(s, b.u), self.v.multiply_add(s, b.v))
    }
}
impl<T: Real> Add for Vector2<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Vector2::new(self.u + b.u, self.v + b.v)
    }
}
impl<T: Real> Sub for Vector2<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Vector2::new(self.u - b.u, self.v - b.v)
    }
}
impl<T: Real> Mul<T> for Vector2<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: T) -> Self {
        Vector2::new(self.u * s, self.v * s)
    }
}

/// A symmetric 2x2 matrix in a tangent basis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Symmetric2<T = f64> {
    /// First diagonal entry.
    pub uu: T,
    /// Off-diagonal entry.
    pub uv: T,
    /// Second diagonal entry.
    pub vv: T,
}

impl<T: Real> Symmetric2<T> {
    /// From entries.
    #[inline(always)]
    pub fn new(uu: T, uv: T, vv: T) -> Self {
        Symmetric2 { uu, uv, vv }
    }
    /// Trace.
    #[inline(always)]
    pub fn trace(self) -> T {
        self.uu + self.vv
    }
    /// Determinant.
    #[inline(always)]
    pub fn determinant(self) -> T {
        self.uu.multiply_subtract(self.vv, self.uv * self.uv)
    }
    /// Adjugate: the inverse times the determinant.
    #[inline(always)]
    pub fn adjugate(self) -> Self {
        Symmetric2::new(self.vv, -self.uv, self.uu)
    }
    /// Matrix times vector.
    #[inline(always)]
    pub fn apply(self, x: Vector2<T>) -> Vector2<T> {
        Vector2::new(
            self.uu.multiply_add(x.u, self.uv * x.v),
            self.uv.multiply_add(x.u, self.vv * x.v),
        )
    }
    /// Adds `s` to the diagonal.
    #[inline(always)]
    pub fn shifted(self, s: T) -> Self {
        Symmetric2::new(self.uu + s, self.uv, self.vv + s)
    }
}
impl<T: Real> Add for Symmetric2<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Symmetric2::new(self.uu + b.uu, self.uv + b.uv, self.vv + b.vv)
    }
}
impl<T: Real> Mul<T> for Symmetric2<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: T) -> Self {
        Symmetric2::new(self.uu * s, self.uv * s, self.vv * s)
    }
}

impl Symmetric2<f64> {
    /// Eigenvalues, smaller first, and the unit eigenvector of the smaller. For a multiple of the identity the
    /// eigenvector is the first axis. The smaller one is `determinant / larger`, which keeps its digits.
    pub fn eigen(self) -> (f64, f64, Vector2<f64>) {
        let mean = 0.5 * (self.uu + self.vv);
        let half_difference = 0.5 * (self.uu - self.vv);
        let radius = half_difference.hypot(self.uv);
        let larger = mean + radius;
        let smaller = if larger > 0.0 && mean > 0.0 {
            self.determinant() / larger
        } else {
            mean - radius
        };
        // The eigenvector of the larger is (cos t, sin t) with tan 2t = 2 uv / (uu - vv).
        let (sin, cos) = (0.5 * self.uv.atan2(half_difference)).sin_cos();
        let direction = if radius > 0.0 {
            Vector2::new(-sin, cos)
        } else {
            Vector2::new(1.0, 0.0)
        };
        (smaller, larger, direction)
    }
}

/// A right-handed orthonormal basis `(u, v, n)` of a unit vector `n`: `u x v = n`.
#[derive(Clone, Copy, Debug)]
pub struct Tangent<T = f64> {
    /// First tangent axis.
    pub u: Vector3<T>,
    /// Second tangent axis.
    pub v: Vector3<T>,
}

impl Tangent {
    /// With `u` along the part of `direction` across the unit vector `n`; any where that part is nothing or rounding.
    pub fn towards(direction: Vector3, n: Vector3) -> Self {
        let across = |v: Vector3| v - n * n.dot(v);
        let first = across(direction);
        let u = if first.norm_squared() > 1e-4 * direction.norm_squared() {
            first.direction()
        } else {
            // Of a vector along `n` rounding is left, which may lie along `n` too.
            let again = first.direction().map(across);
            again
                .filter(|u| u.norm_squared() > 0.25)
                .and_then(Vector3::direction)
        };
        match u {
            Some(u) => Tangent { u, v: n.cross(u) },
            None => Tangent::new(n),
        }
    }
}

impl<T: Real> Tangent<T> {
    /// Free of branches and of cancellation for every `n` (Duff et al., J. Comput. Graph. Tech. 6 (2017) 1).
    #[inline(always)]
    pub fn new(n: Vector3<T>) -> Self {
        let one = n.x.constant(1.0);
        let sign = T::select(n.z.less(n.z.constant(0.0)), -one, one);
        let a = -(one / (sign + n.z));
        let b = n.x * n.y * a;
        Tangent {
            u: Vector3::new(one + sign * n.x * n.x * a, sign * b, -(sign * n.x)),
            v: Vector3::new(b, sign + n.y * n.y * a, -n.y),
        }
    }
    /// Components of a world vector along `u` and `v`.
    #[inline(always)]
    pub fn components(&self, w: Vector3<T>) -> Vector2<T> {
        Vector2::new(self.u.dot(w), self.v.dot(w))
    }
    /// The world vector with these components.
    #[inline(always)]
    pub fn vector(&self, t: Vector2<T>) -> Vector3<T> {
        self.u.scale_add(t.u, self.v * t.v)
    }
}
