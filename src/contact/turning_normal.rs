// SPDX-License-Identifier: MIT OR Apache-2.0
//! The normal at a curved wall, at its edges and corners, turns as the body moves, and the elastic energy changes with it: what the
//! complete gradient of the energy has more there. A plane holds the normal where it is.

use super::forces::{Contact, ContactForces};
use crate::force::conservative::{
    additional_torque, body_gradient, curvature_gradient, normal_response, BodyAtContact,
    BodyGradient, NormalResponse,
};
use crate::force::Factors;
use crate::real::Real;
use crate::vector::{Symmetric2, Vector2};

/// Share of the body's own radius of curvature below which the second derivative of the gap does not fall: at zero the body fits the
/// cavity, and the contact is anywhere. What the bound of a deep overlap leaves, which ends at 0.95 of the radius
/// (`force/conservative.rs`): the normal turns at most 20 times as far as the body.
const LEAST_SHARE: f64 = 0.05;

/// What turns at a wall: the body, and the derivative of the energy with the normal, divided by the energy.
#[derive(Clone, Copy)]
pub(super) struct TurningNormal<T> {
    body: BodyAtContact<T>,
    gamma: Vector2<T>,
}

impl<T: Real> TurningNormal<T> {
    /// At a contact with this curvature and these factors, `sigma` among them.
    #[inline(always)]
    pub fn of(x: &Contact<T>, curvature: Symmetric2<T>, factors: &Factors<T>) -> Self {
        let body = x.i.for_gradient();
        let gamma = body_gradient(curvature_gradient(curvature, factors), &body).gamma;
        TurningNormal { body, gamma }
    }

    /// `lambda` of the conservative law where the normal turns in one direction alone; `radius` is how far behind the contact the
    /// surface turns with the body.
    #[inline(always)]
    pub fn response_along(&self, direction: Vector2<T>, radius: T, penetration: T) -> Vector2<T> {
        let own = direction.dot(self.body.inverse_weingarten.apply(direction));
        let second = own + radius - penetration;
        let floor = own * LEAST_SHARE;
        let second = T::select(
            second.less(floor.constant(0.0)),
            second.min(-floor),
            second.max(floor),
        );
        direction * (direction.dot(self.gamma) / second)
    }

    /// The same where it turns in both directions, about radii that are not negative.
    #[inline(always)]
    pub fn response_around(&self, along: Vector2<T>, radii: [T; 2], penetration: T) -> Vector2<T> {
        let wall = along_and_across(along, radii);
        normal_response(self.body.inverse_weingarten + wall, penetration, self.gamma).lambda
    }

    /// Adds what a response makes of this elastic energy.
    #[inline(always)]
    pub fn add(
        &self,
        x: &Contact<T>,
        lambda: Vector2<T>,
        elastic_energy: T,
        f: &mut ContactForces<T>,
    ) {
        let zero = elastic_energy.constant(0.0);
        let none = BodyGradient {
            gamma: Vector2::new(zero, zero),
            twist: zero,
        };
        let (t, m) = additional_torque(&self.body, &none, &NormalResponse::exactly(lambda));
        f.force = f.force - x.tangent.vector(lambda) * elastic_energy;
        f.torque_i = f.torque_i - (x.tangent.vector(t) + x.normal * m) * elastic_energy;
    }
}

impl TurningNormal<f64> {
    /// `lambda` in the directions in which the wall lets the normal turn: `along` and across it, with the radii about which it does;
    /// infinite for a direction in which it does not.
    pub fn response(&self, along: Vector2, radii: [f64; 2], penetration: f64) -> Vector2 {
        let across = Vector2::new(-along.v, along.u);
        match radii.map(f64::is_finite) {
            [true, true] if radii.iter().any(|r| *r < 0.0) => {
                // A cavity turns the normal the other way.
                let radii = self.body.inverse_weingarten + along_and_across(along, radii);
                let (_, _, direction) = radii.shifted(-penetration).eigen();
                let beside = Vector2::new(-direction.v, direction.u);
                self.response_in(radii, direction, penetration)
                    + self.response_in(radii, beside, penetration)
            }
            [true, true] => self.response_around(along, radii, penetration),
            [true, false] => self.response_along(along, radii[0], penetration),
            [false, true] => self.response_along(across, radii[1], penetration),
            [false, false] => Vector2::new(0.0, 0.0),
        }
    }

    /// Along a direction of an eigenvector of `radii`, those of body and wall together.
    fn response_in(&self, radii: Symmetric2, direction: Vector2, penetration: f64) -> Vector2 {
        let own = direction.dot(self.body.inverse_weingarten.apply(direction));
        let both = direction.dot(radii.apply(direction));
        self.response_along(direction, both - own, penetration)
    }
}

/// The symmetric matrix with these eigenvalues along a direction and across it.
#[inline(always)]
pub(super) fn along_and_across<T: Real>(along: Vector2<T>, values: [T; 2]) -> Symmetric2<T> {
    let (u, v) = (along.u, along.v);
    let [a, b] = values;
    Symmetric2::new(
        a * u * u + b * v * v,
        (a - b) * u * v,
        a * v * v + b * u * u,
    )
}
