// SPDX-License-Identifier: MIT OR Apache-2.0
//! Resistance to rolling: a spring, a dashpot and a slider along the way that the contact travels over the bodies
//! (docs/theory.md, section 5.1).
//!
//! Two bodies that roll on one another without slip, with the relative angular velocity `w = omega_i - omega_j`, move their
//! contact over their surfaces with the velocity `v = K^-1 (w x n)`, `K` the sum of the two curvature matrices (D.J. Montana,
//! Int. J. Robotics Res. 7(3) (1988) 17). For spheres that is `R w x n` with `R = R_i R_j/(R_i + R_j)`, the rolling velocity of Y. Wang,
//! F. Alonso-Marroquin and W.W. Guo (Particuology 23 (2015) 49) and of LAMMPS. With the way `xi` that is made of it,
//!
//! ```text
//! sds       F = -(k xi + gamma v) ,  |k xi| <= mu |F_n| ,  |F| <= mu |F_n|
//! ```
//!
//! `F` acts on no centre: it is the force that resists the rolling per length that the contact travels, which is what a
//! coefficient of rolling friction means. Its torque `n x K^-1 F` on `i`, and the opposite on `j`, has the power
//! `F.v`. The stiffness is constant, so that no cycle gives work.

use super::choice::choices;
#[cfg(not(feature = "std"))]
use crate::real::Real;
use crate::vector::Vector2;

choices! {
    /// Resistance to rolling.
    Rolling {
        /// Nothing resists rolling.
        None = 0, "none", ELLGRAN_ROLLING_NONE, [];
        /// Spring, dashpot and slider, after S. Luding, Granular Matter 10 (2008) 235.
        Sds = 1, "sds", ELLGRAN_ROLLING_SDS, [rolling_stiffness, rolling_damping, rolling_friction];
    }
}

/// The constants of `rolling sds`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct RollingConstants {
    /// `k_roll`, force/length.
    pub stiffness: f64,
    /// `gamma_roll`, force x time/length.
    pub damping: f64,
    /// `mu_roll`.
    pub friction: f64,
}

/// The force that resists rolling, in the tangent basis.
#[derive(Clone, Copy, Debug)]
pub struct RollingForce {
    /// All of it.
    pub force: Vector2,
    /// What the way makes, without the viscous part.
    pub elastic: Vector2,
    /// The way to be remembered, length.
    pub way: Vector2,
    /// Elastic energy of that way.
    pub energy: f64,
}

/// The force that resists rolling.
///
/// - `way`: what is remembered, carried into the present tangent basis; `increment`: what the contact travelled in this step.
/// - `velocity`: the rolling velocity, of which the viscous part is made.
/// - `passes`: whether time passes. Where none does, as when a run starts, nothing is given up.
pub fn rolling_force(
    c: &RollingConstants,
    normal_force: f64,
    way: Vector2,
    increment: Vector2,
    velocity: Vector2,
    passes: bool,
) -> RollingForce {
    let limit = c.friction * normal_force.max(0.0);
    // Without a spring there is nothing to remember.
    let trial = if c.stiffness > 0.0 {
        way + increment
    } else {
        Vector2::new(0.0, 0.0)
    };
    let spring = trial * c.stiffness;
    let clip = shortened(spring, limit);
    let elastic = spring * clip;
    let whole = elastic + velocity * c.damping;
    let way = if passes { trial * clip } else { way };
    RollingForce {
        force: whole * -shortened(whole, limit),
        elastic: elastic * -1.0,
        way,
        energy: 0.5 * c.stiffness * way.dot(way),
    }
}

/// What a vector is multiplied with to be no longer than `most`.
fn shortened(v: Vector2, most: f64) -> f64 {
    let size = v.dot(v).sqrt();
    if size > most {
        most / size
    } else {
        1.0
    }
}
