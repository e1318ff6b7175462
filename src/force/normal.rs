// SPDX-License-Identifier: MIT OR Apache-2.0
//! The normal force: Hertz, NFD, LSD (docs/theory.md, sections 2, 3 and 5; the paper's Eqs (1) to (7)).

use super::hertz_factors::Factors;
use super::law::{LawConstants, LawKinds};
use crate::real::Real;

/// The normal force of one contact and what the tangential and the conservative law take from it.
#[derive(Clone, Copy, Debug)]
pub struct NormalForce<T = f64> {
    /// Total normal force, > 0 pushes the bodies apart.
    pub force: T,
    /// Its elastic part `F_H(delta)`.
    pub elastic: T,
    /// `dF_H/d(delta)` at the contact area of now (smaller than that of `delta` while a viscous contact recedes): the
    /// inverse `1/C_n` of the normal compliance, force/length.
    pub stiffness: T,
    /// Elastic energy at fixed curvature, `(2/5) F_H delta` (`kn delta^2/2` for the linear spring).
    pub elastic_energy: T,
}

/// Normal force for a penetration `> 0`, its rate (positive while the bodies approach), trace and determinant of the
/// relative curvature matrix `M`, the Hertz factors at that curvature and the effective mass (read only by damping
/// with a coefficient of restitution; may be infinite on neither side).
#[inline(always)]
pub fn normal_force<T: Real>(
    kinds: &LawKinds,
    c: &LawConstants<T>,
    penetration: T,
    rate: T,
    determinant: T,
    factors: &Factors<T>,
    effective_mass: T,
) -> NormalForce<T> {
    let zero = penetration.constant(0.0);
    let mut result = if kinds.linear {
        let elastic = c.normal_stiffness * penetration;
        NormalForce {
            force: elastic + c.normal_damping * rate,
            elastic,
            stiffness: c.normal_stiffness,
            elastic_energy: elastic * penetration * 0.5,
        }
    } else {
        // F_H = c g delta^(3/2),  g = sqrt(Re) phi = 2^(-1/2) det(M)^(-1/4) phi.
        let per_power = c.normal_stiffness
            * factors.phi
            * (determinant.sqrt().reciprocal_sqrt() * core::f64::consts::FRAC_1_SQRT_2);
        let root = penetration.sqrt();
        let slope = per_power * root;
        let elastic = slope * penetration;
        let mut result = NormalForce {
            force: elastic,
            elastic,
            stiffness: slope * 1.5,
            elastic_energy: elastic * penetration * 0.4,
        };
        if kinds.relaxation {
            result.force = elastic + c.normal_damping * result.stiffness * rate;
            if kinds.ting {
                // The receding contact has the area of a smaller penetration.
                let receding = rate.less(zero);
                let effective = c.normal_damping.multiply_add(rate, penetration).max(zero);
                let slope = per_power * effective.sqrt();
                result.force = T::select(receding, slope * effective, result.force);
                result.stiffness = T::select(receding, slope * 1.5, result.stiffness);
            }
        }
        if kinds.restitution {
            result.force = result.force
                + c.restitution * (effective_mass * per_power).sqrt() * root.sqrt() * rate;
        }
        result
    };
    if kinds.limit_force {
        result.force = result.force.max(zero);
    }
    result
}
