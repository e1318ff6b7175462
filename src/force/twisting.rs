// SPDX-License-Identifier: MIT OR Apache-2.0
//! Resistance to twisting: a spring, a dashpot and a slider about the normal (docs/theory.md, section 5.1).
//!
//! With the relative angular velocity about the normal, `(omega_i - omega_j).n`, and the angle `theta` that is made of it,
//!
//! ```text
//! T = -(k theta + gamma theta') ,  |k theta| <= T_max ,  |T| <= T_max
//! sds        k, gamma, T_max = mu_twist |F_n|
//! marshall   k = tr(K_t adj S)/4 , gamma = tr(C_t adj S)/4 , T_max = mu |F_n| r
//! ```
//!
//! `marshall` (J.S. Marshall, J. Comput. Phys. 228 (2009) 1541) takes stiffness `K_t`, damping `C_t` and friction `mu` of the
//! tangential law, spread evenly over the contact ellipse. `S` is the matrix of the squares of its semi-axes, `r` the mean distance
//! of its points from its centre. On a circle of radius `a` these are Marshall's `k_t a^2/2`, `gamma_t a^2/2` and `2/3 a`.
//!
//! Of the semi-axes no root of an elliptic integral is needed. Hertz' theory has `a^2 = delta (D/K)/A` and
//! `b^2 = delta (Bl/K)/B`, and `D + Bl = K`: `S = delta (I - Beta) M^-1`, with the matrix `Beta` of the tangential compliance.
//!
//! `lubkin` is in [`super::twisting_bed`].
//!
//! Both the torque and the angle that are held are remembered. The stiffness of `marshall` changes with the contact: the torque stays
//! while it grows, the angle while it shrinks, and neither stores more energy than was there.

use super::choice::choices;
use super::hertz_factors::Factors;
use super::tangential::{compliance_matrix, tangential_stiffness};
use super::{TangentialConstants, TangentialKinds};
#[cfg(not(feature = "std"))]
use crate::real::Real;
use crate::vector::Symmetric2;

choices! {
    /// Resistance to twisting.
    Twisting {
        /// Nothing resists twisting.
        None = 0, "none", ELLGRAN_TWISTING_NONE, [];
        /// The tangential law's stiffness, damping and friction, spread over the contact ellipse.
        Marshall = 1, "marshall", ELLGRAN_TWISTING_MARSHALL, [];
        /// Spring, dashpot and slider, after S. Luding, Granular Matter 10 (2008) 235.
        Sds = 2, "sds", ELLGRAN_TWISTING_SDS, [twisting_stiffness, twisting_damping, twisting_friction];
        /// Partial slip of a twist, after J.L. Lubkin, with the loop of its way back; twist and displacement share one friction. No
        /// cycle creates energy. Only with `tfd` and `displacement hysteretic`.
        Lubkin = 3, "lubkin", ELLGRAN_TWISTING_LUBKIN, [];
    }
}

/// What resists the twist of one contact.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct TwistSpring {
    /// Torque over angle.
    pub stiffness: f64,
    /// Torque over angular velocity.
    pub damping: f64,
    /// Largest torque over normal force, length.
    pub friction: f64,
}

impl TwistSpring {
    /// That of `marshall`: of a contact of this penetration, normal stiffness, curvature matrix and Hertz factors.
    pub fn of_contact_ellipse(
        kinds: &TangentialKinds,
        c: &TangentialConstants,
        penetration: f64,
        normal_stiffness: f64,
        factors: &Factors,
        curvature: Symmetric2,
    ) -> Self {
        let squares = squared_semi_axes(penetration, factors.sigma, curvature);
        let across = squares.adjugate();
        let (stiffness, damping) =
            tangential_stiffness(kinds, c, normal_stiffness, factors, curvature);
        let of =
            |m: Symmetric2| 0.25 * (m.uu * across.uu + 2.0 * m.uv * across.uv + m.vv * across.vv);
        TwistSpring {
            stiffness: of(stiffness),
            damping: of(damping),
            friction: c.friction * mean_radius(squares),
        }
    }
}

/// The matrix with the squares of the semi-axes of the contact ellipse, length^2, in the tangent basis, after Hertz.
pub fn squared_semi_axes(penetration: f64, sigma: f64, curvature: Symmetric2) -> Symmetric2 {
    let a = compliance_matrix(1.0, 1.0, sigma, curvature) * penetration;
    let b = curvature.adjugate() * (1.0 / curvature.determinant());
    // They have the same eigenvectors.
    Symmetric2::new(
        a.uu * b.uu + a.uv * b.uv,
        a.uu * b.uv + a.uv * b.vv,
        a.uv * b.uv + a.vv * b.vv,
    )
}

/// Mean distance of the points of an ellipse from its centre: its circumference over `3 pi`, that by Ramanujan's second formula, which is
/// within 0.041 % of it at any ratio of the semi-axes, and exact for a circle.
pub fn mean_radius(squares: Symmetric2) -> f64 {
    let product = squares.determinant().max(0.0).sqrt();
    let sum = squares.trace();
    // (a + b)^2, and 3 (a - b)^2 over it.
    let both = sum + 2.0 * product;
    let flat = 3.0 * (sum - 2.0 * product).max(0.0) / both.max(1e-300);
    both.sqrt() / 3.0 * (1.0 + flat / (10.0 + (4.0 - flat).max(0.0).sqrt()))
}

/// The torque that resists twisting.
#[derive(Clone, Copy, Debug)]
pub struct TwistingTorque {
    /// All of it, about the normal.
    pub torque: f64,
    /// What the angle makes, without the viscous part.
    pub elastic: f64,
    /// To be remembered: the torque that the spring holds against, and its angle.
    pub held: [f64; 2],
    /// Elastic energy of these.
    pub energy: f64,
}

/// The torque that resists twisting.
///
/// - `held`: what is remembered, the torque that the spring holds against, and its angle; `increment`: the twist of this step.
/// - `velocity`: the relative angular velocity about the normal, of which the viscous part is made.
/// - `passes`: whether time passes. Where none does, as when a run starts, nothing is given up.
pub fn twisting_torque(
    spring: &TwistSpring,
    normal_force: f64,
    held: [f64; 2],
    increment: f64,
    velocity: f64,
    passes: bool,
) -> TwistingTorque {
    let limit = spring.friction * normal_force.max(0.0);
    let [torque, angle] = held;
    let kept = if passes {
        torque
            .abs()
            .min(spring.stiffness * angle.abs())
            .copysign(torque)
    } else {
        torque
    };
    let limited = |torque: f64| torque.max(-limit).min(limit);
    let elastic = limited(kept + spring.stiffness * increment);
    let whole = limited(elastic + spring.damping * velocity);
    let held = match (passes, spring.stiffness > 0.0) {
        (false, _) => held,
        (true, true) => [elastic, elastic / spring.stiffness],
        (true, false) => [0.0; 2],
    };
    TwistingTorque {
        torque: -whole,
        elastic: -elastic,
        held,
        energy: 0.5 * held[0] * held[1],
    }
}
