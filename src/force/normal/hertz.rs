// SPDX-License-Identifier: MIT OR Apache-2.0
//! `hertz`: the elastic force of an elliptical contact, `F = 4/3 E* sqrt(Re) phi delta^(3/2)`, and its dampings
//! (docs/theory.md, sections 2, 3 and 6).

use super::super::damping::{restitution_coefficient, Damping};
use super::super::hertz_factors::Factors;
use super::super::parameters::LawParameters;
use super::{
    Collision, Formula, Law, NormalConstants, NormalForce, NormalFormula, NormalKinds, Resolved,
};
#[cfg(not(feature = "std"))]
use crate::real::Functions;
use crate::real::Real;
#[cfg(not(feature = "std"))]
use alloc::string::String;

/// `T v/delta_max` of an elastic Hertzian collision, `(4/5) sqrt(pi) Gamma(2/5)/Gamma(9/10)` (Landau and Lifshitz, Theory of
/// Elasticity, section 9).
const HERTZ_TIME: f64 = 2.943_275_1;

pub(super) struct Hertz;

/// The law of two materials: their compliances add, and relaxation times are weighted by them.
pub(super) fn by_compliance(
    i: &LawParameters,
    j: &LawParameters,
    relaxation_time: fn(&LawParameters) -> f64,
) -> Resolved {
    let ci = i.material().normal_compliance();
    let cj = j.material().normal_compliance();
    Resolved {
        constants: NormalConstants {
            stiffness: 4.0 / 3.0 / (ci + cj),
            damping: (relaxation_time(i) * ci + relaxation_time(j) * cj) / (ci + cj),
            restitution: 0.0,
        },
        share_i: ci / (ci + cj),
    }
}

impl Law for Hertz {
    const FORMULA: Formula = Formula::Hertz;

    fn resolve(i: &LawParameters, j: &LawParameters, mixed: &LawParameters) -> Resolved {
        let mut law = by_compliance(i, j, |p| match p.damping {
            Damping::Relaxation => p.relaxation_time,
            Damping::None | Damping::Restitution => 0.0,
        });
        if i.damping == Damping::Restitution {
            law.constants.restitution = restitution_coefficient(mixed.restitution, i.limit_force);
        }
        law
    }

    fn tangential_relaxation(p: &LawParameters) -> (f64, f64) {
        match p.damping {
            // One relaxation time for all deformation: proportional viscosity.
            Damping::Relaxation => (p.relaxation_time, p.relaxation_time * p.poissons_ratio),
            Damping::None | Damping::Restitution => (0.0, 0.0),
        }
    }
}

/// `c g`, with which `F_H = c g delta^(3/2)`: `g = sqrt(Re) phi = 2^(-1/2) det(M)^(-1/4) phi`, `c = 4/3 E*`.
#[inline(always)]
pub(in crate::force) fn per_power<T: Real>(
    stiffness: T,
    determinant: T,
    factors: &Factors<T>,
) -> T {
    stiffness
        * factors.phi
        * (determinant.sqrt().reciprocal_sqrt() * core::f64::consts::FRAC_1_SQRT_2)
}

impl NormalFormula for Hertz {
    const ELLIPTICAL: bool = true;

    #[inline(always)]
    fn force<T: Real>(
        kinds: &NormalKinds,
        c: &NormalConstants<T>,
        penetration: T,
        rate: T,
        determinant: T,
        factors: &Factors<T>,
        effective_mass: T,
    ) -> NormalForce<T> {
        let zero = penetration.constant(0.0);
        let per_power = per_power(c.stiffness, determinant, factors);
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
            result.force = elastic + c.damping * result.stiffness * rate;
            if kinds.ting {
                // The receding contact has the area of a smaller penetration.
                let receding = rate.less(zero);
                let effective = c.damping.multiply_add(rate, penetration).max(zero);
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
    }

    #[inline(always)]
    fn dashpot<T: Real>(
        kinds: &NormalKinds,
        c: &NormalConstants<T>,
        stiffness: T,
        effective_mass: T,
    ) -> T {
        if kinds.relaxation {
            c.damping * stiffness
        } else if kinds.restitution {
            c.restitution * (effective_mass * stiffness * (1.0 / 1.5)).sqrt()
        } else {
            stiffness.constant(0.0)
        }
    }

    fn collision(stiffness: f64, inverse_mass: f64, speed: f64) -> Collision {
        // F = k delta^(3/2), and dF/d(delta) at 1 is 3/2 k.
        let k = stiffness / 1.5;
        let deepest = (1.25 * speed * speed / (inverse_mass * k)).powf(0.4);
        Collision {
            time: HERTZ_TIME * deepest / speed,
            penetration: deepest,
        }
    }

    fn describe(kinds: &NormalKinds, c: &NormalConstants) -> String {
        let mut text = format!("hertz E* {}", 0.75 * c.stiffness);
        if kinds.relaxation {
            let unloading = if kinds.ting { "ting" } else { "first_order" };
            text += &format!(" A_n {} unloading {unloading}", c.damping);
        }
        if kinds.restitution {
            text += &format!(" restitution alpha {}", c.restitution);
        }
        text
    }
}
