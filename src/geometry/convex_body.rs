// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the contact search and the law need of a body in the frame of a direction, apart from the closed form of its shape.

use crate::real::Real;
use crate::vector::{Symmetric2, Tangent, Vector2, Vector3};

/// A convex body by its support function.
pub trait ConvexBody<T: Real>: Copy {
    /// The axes of a frame `(u, v, n)` as the body sees them.
    type View: Copy;

    /// Of the unit vector `n` and its tangent basis.
    fn view(&self, n: Vector3<T>, tangent: &Tangent<T>) -> Self::View;
    /// The square of the support function over the tangent plane.
    fn squared_support(&self, view: &Self::View) -> SquaredSupport<T>;
    /// Support function and witness.
    fn support_in_frame(&self, view: &Self::View) -> SupportInFrame<T>;
    /// The Weingarten map at the witness, 1/length, in the tangent basis; `h` is the support function there.
    fn weingarten_in_frame(&self, view: &Self::View, h: T) -> Symmetric2<T>;
    /// Radius of the largest ball in the body that touches its surface at the witness where the support function has the
    /// inverse `inverse_h`.
    fn inscribed_radius(&self, inverse_h: T) -> T;
    /// `(a1 a2 a3)^2`, which makes `det V = h^4 / (a1 a2 a3)^2`.
    fn squared_product(&self) -> T;
    /// Support function and witness, from the centre, in the world frame.
    fn support_in_world(&self, n: Vector3<T>) -> (T, Vector3<T>);
    /// The largest semi-axis and the smallest.
    fn extreme_semi_axes(&self) -> [T; 2];
    /// Radius of a body that is a sphere, and its inverse.
    fn radius_of_sphere(&self) -> (T, T);
}

/// The support function and the witness of one body in the frame of one direction.
#[derive(Clone, Copy, Debug)]
pub struct SupportInFrame<T = f64> {
    /// `h(n)`, length: the part of the witness along `n`, from the centre.
    pub h: T,
    /// `1/h`.
    pub inverse_h: T,
    /// Its other part, in the tangent basis: the gradient of `h` on the sphere of directions.
    pub witness: Vector2<T>,
}

/// The square of the support function of one body over the tangent plane of one normal, `q(y) = c + 2 b.y + y.A y`
/// (`tangent_model.rs`).
#[derive(Clone, Copy, Debug)]
pub struct SquaredSupport<T> {
    /// `h^2` at the base, length^2.
    pub constant: T,
    /// `b`.
    pub linear: Vector2<T>,
    /// `A`.
    pub quadratic: Symmetric2<T>,
}
