// SPDX-License-Identifier: MIT OR Apache-2.0
//! The function of the contact search over the tangent plane of one normal, exactly and without vectors of three
//! components.
//!
//! Write a direction as `m = n + T y`, with `T` a tangent basis of the unit vector `n`. The support function is of first
//! degree, so that `f(m/|m|) = F(y)/rho`, `rho^2 = 1 + y.y`, with
//!
//! ```text
//! F(y) = sqrt(q_i) + sqrt(q_j) - n.d - (T^T d).y ,   q(y) = |D R^T (n + T y)|^2 = c + 2 b.y + y.A y
//! ```
//!
//! A body enters through six numbers. Newton's method for `f` then costs a third of what it costs on the sphere.

use super::convex_body::{ConvexBody, SquaredSupport};
use crate::real::Real;
use crate::vector::{Symmetric2, Tangent, Vector2, Vector3};

/// `F`, its gradient and the Hessian of `f` at one `y`.
#[derive(Clone, Copy, Debug)]
pub struct TangentPoint<T> {
    /// `F(y)`; `f` times `sqrt(1 + y.y)`.
    pub value: T,
    /// `sqrt(1 + y.y)` times the gradient of `f`: zero where `f` is stationary.
    pub gradient: Vector2<T>,
    /// Its derivative, up to terms that vanish with the gradient.
    pub hessian: Symmetric2<T>,
}

/// Two bodies around one normal.
#[derive(Clone, Copy, Debug)]
pub struct TangentModel<T> {
    i: SquaredSupport<T>,
    j: SquaredSupport<T>,
    /// `n.d`.
    along: T,
    /// `T^T d`.
    across: Vector2<T>,
}

impl<T: Real> TangentModel<T> {
    /// Of bodies `i` and `j`, with `d` from the centre of `i` to that of `j`, around the unit vector `n`.
    #[inline(always)]
    pub fn new<B: ConvexBody<T>>(
        i: &B,
        j: &B,
        d: Vector3<T>,
        n: Vector3<T>,
        tangent: &Tangent<T>,
    ) -> Self {
        TangentModel {
            i: i.squared_support(&i.view(n, tangent)),
            j: j.squared_support(&j.view(n, tangent)),
            along: n.dot(d),
            across: tangent.components(d),
        }
    }

    /// At the base, `y = 0`.
    #[inline(always)]
    pub fn at_base(&self) -> TangentPoint<T> {
        let (h_i, gradient_i, hessian_i) = body_at_base(&self.i);
        let (h_j, gradient_j, hessian_j) = body_at_base(&self.j);
        let value = h_i + h_j - self.along;
        TangentPoint {
            value,
            gradient: gradient_i + gradient_j - self.across,
            hessian: (hessian_i + hessian_j).shifted(-value),
        }
    }

    /// Half the second derivative of the gradient at the base, twice along `y`: by what the gradient differs from its tangent there, up to
    /// the third order, where `y` is Newton's step from the base.
    #[inline(always)]
    pub fn bend_at_base(&self, y: Vector2<T>) -> Vector2<T> {
        bend_of_body(&self.i, y) + bend_of_body(&self.j, y)
    }

    /// At `y`.
    #[inline(always)]
    pub fn at(&self, y: Vector2<T>) -> TangentPoint<T> {
        let one = y.u.constant(1.0);
        let (h_i, gradient_i, hessian_i) = body_at(&self.i, y);
        let (h_j, gradient_j, hessian_j) = body_at(&self.j, y);
        let value = h_i + h_j - self.along - self.across.dot(y);
        let inverse = (y.dot(y) + one).reciprocal();
        let scale = value * inverse;
        let turned = y * (scale * inverse);
        let h = (hessian_i + hessian_j).shifted(-scale);
        TangentPoint {
            value,
            gradient: y.scale_add(-scale, gradient_i + gradient_j - self.across),
            hessian: Symmetric2::new(
                turned.u.multiply_add(y.u, h.uu),
                turned.u.multiply_add(y.v, h.uv),
                turned.v.multiply_add(y.v, h.vv),
            ),
        }
    }
}

/// `h`, and gradient and Hessian of `sqrt(q)`.
#[inline(always)]
fn body_at<T: Real>(body: &SquaredSupport<T>, y: Vector2<T>) -> (T, Vector2<T>, Symmetric2<T>) {
    let half_slope = body.linear + body.quadratic.apply(y);
    let square = (body.linear + half_slope).dot(y) + body.constant;
    root(body, square, half_slope)
}

/// The same at `y = 0`.
#[inline(always)]
fn body_at_base<T: Real>(body: &SquaredSupport<T>) -> (T, Vector2<T>, Symmetric2<T>) {
    root(body, body.constant, body.linear)
}

/// The same of the support function of one body: with its gradient `g` and Hessian `H`, `-(2 (g.y) H y + (y.H y) g)/(2 h)`.
#[inline(always)]
fn bend_of_body<T: Real>(body: &SquaredSupport<T>, y: Vector2<T>) -> Vector2<T> {
    let (_, gradient, hessian) = body_at_base(body);
    let turned = hessian.apply(y);
    let minus = body.constant.reciprocal_sqrt() * -body.constant.constant(1.0);
    let along = gradient.dot(y) * minus;
    let across = turned.dot(y) * minus * 0.5;
    turned.scale_add(along, gradient * across)
}

#[inline(always)]
fn root<T: Real>(
    body: &SquaredSupport<T>,
    square: T,
    half_slope: Vector2<T>,
) -> (T, Vector2<T>, Symmetric2<T>) {
    let inverse = square.reciprocal_sqrt();
    let gradient = half_slope * inverse;
    let a = body.quadratic;
    let hessian = Symmetric2::new(
        gradient.u.negative_multiply_add(gradient.u, a.uu),
        gradient.u.negative_multiply_add(gradient.v, a.uv),
        gradient.v.negative_multiply_add(gradient.v, a.vv),
    );
    (square * inverse, gradient, hessian * inverse)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Ellipsoid;

    /// Against the support function itself, for directions far from the base.
    #[test]
    fn the_model_is_exact() {
        let i = Ellipsoid::new([3.0, 0.7, 1.1], [0.9, 0.3, -0.2, 0.1]).unwrap();
        let j = Ellipsoid::new([0.4, 2.0, 0.9], [0.2, -0.5, 0.7, 0.4]).unwrap();
        let d = Vector3::new(1.3, -0.4, 0.8);
        let n = Vector3::new(0.3, -0.5, 0.81).normalised();
        let tangent = Tangent::new(n);
        let model = TangentModel::new(&i, &j, d, n, &tangent);
        let f = |y: Vector2| {
            let m = (n + tangent.vector(y)).normalised();
            i.support(m).h + j.support(m).h - m.dot(d)
        };
        for y in [
            Vector2::new(0.0, 0.0),
            Vector2::new(0.4, -0.2),
            Vector2::new(-1.5, 2.5),
        ] {
            let at = model.at(y);
            let rho = (1.0 + y.dot(y)).sqrt();
            assert!((at.value / rho - f(y)).abs() < 1e-14 * 5.0, "{y:?}");
            let step = 1e-5;
            for (along, gradient) in [
                (Vector2::new(step, 0.0), at.gradient.u),
                (Vector2::new(0.0, step), at.gradient.v),
            ] {
                let difference = (f(y + along) - f(y - along)) / (2.0 * step);
                assert!((gradient / rho - difference).abs() < 1e-9, "{y:?}");
            }
        }
        // Along Newton's step from the base, whose length decides, the gradient is known up to the third order.
        let at_base = model.at_base();
        let inverse = at_base.hessian.adjugate() * (1.0 / at_base.hessian.determinant());
        let newton = inverse.apply(at_base.gradient) * -1.0;
        let left = |share: f64| {
            // The same bodies, with a gradient at the base that is shorter by this.
            let shorter = TangentModel {
                across: model.across + at_base.gradient * (1.0 - share),
                ..model
            };
            let y = newton * share;
            let gradient = shorter.at(y).gradient - shorter.bend_at_base(y);
            gradient.dot(gradient).sqrt()
        };
        let [large, small] = [left(1e-2), left(1e-3)];
        assert!(
            large > 0.0 && small < 1.5e-3 * large && small > 0.5e-3 * large,
            "{large:e} {small:e}"
        );
        // Newton's method ends where the gradient does; there the Hessian is the gradient's derivative.
        let mut y = Vector2::new(0.1, -0.1);
        for _ in 0..60 {
            let at = model.at(y);
            y = y + at.hessian.adjugate().apply(at.gradient) * (-1.0 / at.hessian.determinant());
        }
        let at = model.at(y);
        assert!(
            at.gradient.dot(at.gradient) < 1e-28 && y.dot(y) > 1e-3,
            "{y:?}"
        );
        let step = 1e-5;
        for (along, row) in [
            (Vector2::new(step, 0.0), (at.hessian.uu, at.hessian.uv)),
            (Vector2::new(0.0, step), (at.hessian.uv, at.hessian.vv)),
        ] {
            let difference =
                (model.at(y + along).gradient - model.at(y - along).gradient) * (0.5 / step);
            assert!(
                (difference.u - row.0).abs() < 1e-8,
                "{difference:?} {row:?}"
            );
            assert!(
                (difference.v - row.1).abs() < 1e-8,
                "{difference:?} {row:?}"
            );
        }
        // The Hessian of f at the base, where y = 0: that of the sphere, the gradient's part apart.
        let at = model.at_base();
        let general = model.at(Vector2::new(0.0, 0.0));
        assert_eq!(at.value, general.value);
        assert_eq!(at.gradient, general.gradient);
        assert_eq!(at.hessian, general.hessian);
        let step = 1e-4;
        let (u, v) = (Vector2::new(step, 0.0), Vector2::new(0.0, step));
        let second =
            |a: Vector2| (f(a) - 2.0 * f(Vector2::new(0.0, 0.0)) + f(a * -1.0)) / (step * step);
        let mixed = (f(u + v) - f(u - v) - f(v - u) + f((u + v) * -1.0)) / (4.0 * step * step);
        assert!((at.hessian.uu - second(u)).abs() < 1e-6);
        assert!((at.hessian.vv - second(v)).abs() < 1e-6);
        assert!((at.hessian.uv - mixed).abs() < 1e-6);
    }
}
