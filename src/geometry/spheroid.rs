// SPDX-License-Identifier: MIT OR Apache-2.0
//! An ellipsoid of revolution: its axis is all there is to its pose.
//!
//! With the axis `e`, the polar semi-axis `a` along it and the equatorial `c` across, everything is a polynomial in the
//! components of `e` in the frame of the direction, `s = n.e` and `t = T^T e`, since `S = c^2 I + (a^2 - c^2) e e^T`:
//!
//! ```text
//! h^2 = a^2 s^2 + c^2 t.t       witness  h n + T t (a^2 - c^2) s/h
//! V/h = (s^2 + t'.t')/c^2 + t t/a^2  in the diagonal,  (1/a^2 - 1/c^2) tu tv  beside it (t' the other component)
//! ```
//!
//! written with `1 - tu^2 = s^2 + tv^2`, so that every diagonal entry is a sum of squares and nothing cancels, however
//! slender or flat the body is.

use super::convex_body::{ConvexBody, SquaredSupport, SupportInFrame};
use crate::real::Real;
use crate::vector::{Symmetric2, Tangent, Vector2, Vector3};

/// Shape and axis of a spheroid; the centre is kept apart.
#[derive(Clone, Copy, Debug)]
pub struct Spheroid<T = f64> {
    /// Unit vector along the axis of revolution, world frame; either sense.
    pub axis: Vector3<T>,
    /// Semi-axis along it, > 0, length.
    pub polar: T,
    /// Semi-axis across it, > 0, length.
    pub equatorial: T,
    /// `1/polar`.
    pub inverse_polar: T,
    /// `1/equatorial`.
    pub inverse_equatorial: T,
}

/// The axis in the frame of a direction.
#[derive(Clone, Copy, Debug)]
pub struct AxisInFrame<T = f64> {
    /// `n.e`.
    along: T,
    /// `T^T e`.
    across: Vector2<T>,
}

impl<T: Real> Spheroid<T> {
    /// `a^2 - c^2`, without cancellation.
    #[inline(always)]
    fn difference(&self) -> T {
        (self.polar - self.equatorial) * (self.polar + self.equatorial)
    }

    #[inline(always)]
    fn square(&self, view: &AxisInFrame<T>) -> T {
        let (s, t) = (view.along * self.polar, view.across * self.equatorial);
        s.multiply_add(s, t.dot(t))
    }
}

impl<T: Real> ConvexBody<T> for Spheroid<T> {
    type View = AxisInFrame<T>;

    #[inline(always)]
    fn view(&self, n: Vector3<T>, tangent: &Tangent<T>) -> AxisInFrame<T> {
        AxisInFrame {
            along: n.dot(self.axis),
            across: tangent.components(self.axis),
        }
    }

    #[inline(always)]
    fn squared_support(&self, view: &AxisInFrame<T>) -> SquaredSupport<T> {
        let (s, t) = (view.along, view.across);
        let difference = self.difference();
        let c = self.equatorial * self.equatorial;
        // Newton's method alone uses these: the rounding of a flat body's rim does no harm.
        let (u, v) = (difference * t.u, difference * t.v);
        SquaredSupport {
            constant: self.square(view),
            linear: Vector2::new(u * s, v * s),
            quadratic: Symmetric2::new(u.multiply_add(t.u, c), u * t.v, v.multiply_add(t.v, c)),
        }
    }

    #[inline(always)]
    fn support_in_frame(&self, view: &AxisInFrame<T>) -> SupportInFrame<T> {
        let square = self.square(view);
        let inverse_h = square.reciprocal_sqrt();
        SupportInFrame {
            h: square * inverse_h,
            inverse_h,
            witness: view.across * (self.difference() * view.along * inverse_h),
        }
    }

    #[inline(always)]
    fn weingarten_in_frame(&self, view: &AxisInFrame<T>, h: T) -> Symmetric2<T> {
        let (s, t) = (view.along, view.across);
        let polar = self.inverse_polar * self.inverse_polar * h;
        let equatorial = self.inverse_equatorial * self.inverse_equatorial * h;
        let (ss, uu, vv) = (s * s, t.u * t.u, t.v * t.v);
        Symmetric2::new(
            polar.multiply_add(uu, equatorial * (ss + vv)),
            (polar - equatorial) * (t.u * t.v),
            polar.multiply_add(vv, equatorial * (ss + uu)),
        )
    }

    #[inline(always)]
    fn inscribed_radius(&self, inverse_h: T) -> T {
        let least = self.polar.min(self.equatorial);
        least * least * inverse_h
    }

    #[inline(always)]
    fn squared_product(&self) -> T {
        let p = self.polar * self.equatorial * self.equatorial;
        p * p
    }

    #[inline(always)]
    fn support_in_world(&self, n: Vector3<T>) -> (T, Vector3<T>) {
        let s = n.dot(self.axis);
        let across = n - self.axis * s;
        let (along, c) = (s * self.polar, self.equatorial * self.equatorial);
        let square = along.multiply_add(along, across.norm_squared() * c);
        let inverse_h = square.reciprocal_sqrt();
        let point = self
            .axis
            .scale_add(along * self.polar * inverse_h, across * (c * inverse_h));
        (square * inverse_h, point)
    }

    #[inline(always)]
    fn extreme_semi_axes(&self) -> [T; 2] {
        let (a, b) = (self.polar, self.equatorial);
        [a.max(b), a.min(b)]
    }

    #[inline(always)]
    fn radius_of_sphere(&self) -> (T, T) {
        (self.equatorial, self.inverse_equatorial)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Ellipsoid;

    fn directions() -> impl Iterator<Item = Vector3> {
        // The pole and the rim, and in between.
        (0..40).map(|k| {
            let (a, b) = (f64::from(k) * 0.7, f64::from(k) * 1.3 + 0.2);
            Vector3::new(a.cos() * b.sin(), a.sin() * b.sin(), b.cos()).normalised()
        })
    }

    /// The same body with its axis along each of the three body axes, against the ellipsoid.
    #[test]
    fn a_spheroid_is_an_ellipsoid() {
        for (polar, equatorial) in [(2.0, 1.0), (1.0, 2.0), (1.3, 1.3), (50.0, 1.0), (1.0, 50.0)] {
            for polar_axis in 0..3 {
                let mut semi_axes = [equatorial; 3];
                semi_axes[polar_axis] = polar;
                let ellipsoid = Ellipsoid::new(semi_axes, [0.8, 0.3, -0.4, 0.5]).unwrap();
                let spheroid = Spheroid {
                    axis: ellipsoid.axes[polar_axis],
                    polar,
                    equatorial,
                    inverse_polar: 1.0 / polar,
                    inverse_equatorial: 1.0 / equatorial,
                };
                let pole = spheroid.axis;
                let rim = Tangent::new(pole).u;
                for n in directions().chain([pole, -pole, rim]) {
                    let tangent = Tangent::new(n);
                    compare(&spheroid, &ellipsoid, n, &tangent, polar.max(equatorial));
                }
            }
        }
    }

    fn compare(a: &Spheroid, b: &Ellipsoid, n: Vector3, tangent: &Tangent, size: f64) {
        let ratio = size / a.polar.min(a.equatorial);
        let near = |x: f64, y: f64, tolerance: f64| {
            assert!(
                (x - y).abs() <= tolerance,
                "{x} {y} {tolerance:e} {n:?} {a:?}"
            );
        };
        let (view_a, view_b) = (a.view(n, tangent), b.view(n, tangent));
        let (s, r) = (a.support_in_frame(&view_a), b.support_in_frame(&view_b));
        near(s.h, r.h, 1e-15 * size);
        // A rotation of the normal by rounding moves the witness by the radius of curvature, up to ratio * size.
        let moved = 2e-15 * ratio * size;
        near(s.witness.u, r.witness.u, moved);
        near(s.witness.v, r.witness.v, moved);
        let (va, vb) = (
            a.weingarten_in_frame(&view_a, s.h),
            b.weingarten_in_frame(&view_b, r.h),
        );
        // Each entry to rounding times the geometric mean of the diagonal entries.
        let tolerance = 4e-15 * ratio;
        near(va.uu, vb.uu, tolerance * vb.uu);
        near(va.vv, vb.vv, tolerance * vb.vv);
        near(va.uv, vb.uv, tolerance * (vb.uu * vb.vv).sqrt());
        let radius = ConvexBody::inscribed_radius(b, r.inverse_h);
        near(
            ConvexBody::inscribed_radius(a, s.inverse_h),
            radius,
            tolerance * radius,
        );
        near(
            a.squared_product(),
            b.squared_product(),
            1e-15 * b.squared_product(),
        );
        let ((ha, pa), (hb, pb)) = (a.support_in_world(n), b.support_in_world(n));
        near(ha, hb, 1e-15 * size);
        near((pa - pb).norm(), 0.0, 3.0 * moved);
        let (qa, qb) = (a.squared_support(&view_a), b.squared_support(&view_b));
        let square = 2e-15 * size * size;
        near(qa.constant, qb.constant, square);
        near(qa.linear.u, qb.linear.u, square);
        near(qa.linear.v, qb.linear.v, square);
        near(qa.quadratic.uu, qb.quadratic.uu, square);
        near(qa.quadratic.uv, qb.quadratic.uv, square);
        near(qa.quadratic.vv, qb.quadratic.vv, square);
    }
}
