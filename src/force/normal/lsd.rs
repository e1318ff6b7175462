// SPDX-License-Identifier: MIT OR Apache-2.0
//! `lsd`: a linear spring and dashpot, `F = kn delta + cn d(delta)/dt` (docs/theory.md, section 5).

use super::super::hertz_factors::Factors;
use super::super::parameters::LawParameters;
use super::{
    Collision, Formula, Law, NormalConstants, NormalForce, NormalFormula, NormalKinds, Resolved,
};
use crate::real::Real;
#[cfg(not(feature = "std"))]
use alloc::string::String;

pub(super) struct Lsd;

impl Law for Lsd {
    const FORMULA: Formula = Formula::Linear;

    fn resolve(_: &LawParameters, _: &LawParameters, mixed: &LawParameters) -> Resolved {
        Resolved {
            constants: NormalConstants {
                stiffness: mixed.normal_stiffness,
                damping: mixed.normal_damping,
                restitution: 0.0,
            },
            share_i: 0.5,
        }
    }
}

impl NormalFormula for Lsd {
    const ELLIPTICAL: bool = false;

    #[inline(always)]
    fn force<T: Real>(
        _: &NormalKinds,
        c: &NormalConstants<T>,
        penetration: T,
        rate: T,
        _: T,
        _: &Factors<T>,
        _: T,
    ) -> NormalForce<T> {
        let elastic = c.stiffness * penetration;
        NormalForce {
            force: elastic + c.damping * rate,
            elastic,
            stiffness: c.stiffness,
            elastic_energy: elastic * penetration * 0.5,
        }
    }

    #[inline(always)]
    fn dashpot<T: Real>(_: &NormalKinds, c: &NormalConstants<T>, _: T, _: T) -> T {
        c.damping
    }

    /// Half an oscillation.
    fn collision(stiffness: f64, inverse_mass: f64, speed: f64) -> Collision {
        let frequency = (inverse_mass * stiffness).sqrt();
        Collision {
            time: core::f64::consts::PI / frequency,
            penetration: speed / frequency,
        }
    }

    fn describe(_: &NormalKinds, c: &NormalConstants) -> String {
        format!("lsd kn {} cn {}", c.stiffness, c.damping)
    }
}
