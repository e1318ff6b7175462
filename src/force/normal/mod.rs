// SPDX-License-Identifier: MIT OR Apache-2.0
//! The normal force: one file per law (docs/theory.md, sections 2, 3 and 5; the paper's Eqs (1) to (7)), and the tables of laws
//! and formulas.

mod hertz;
mod lsd;
mod nfd;

use super::choice::resolved_constants;
use super::contact_begin::Begin;
use super::hertz_factors::Factors;
use super::parameters::{LawParameters, Normal};
use crate::real::Real;
#[cfg(not(feature = "std"))]
use alloc::string::String;
pub(super) use hertz::per_power;

// The row of a law is its choice in `parameters.rs` and its type here.
laws! {
    Hertz => hertz::Hertz,
    Nfd => nfd::Nfd,
    Lsd => lsd::Lsd,
}

// The row of a formula is its name and the type that has it: what the kernels choose among. Laws may share one.
formulas! {
    /// `F = k delta^(3/2)`, with the curvatures and with the dampings of `hertz` and `nfd`.
    Hertz => hertz::Hertz,
    /// Linear spring and dashpot.
    Linear => lsd::Lsd,
}

/// How a normal law follows from what is given, before the run.
trait Law {
    /// Its formula.
    const FORMULA: Formula;

    /// What the kernels take from the constants of two types. `mixed` has those constants mixed that the table in
    /// [`super::parameters`] mixes; those of a material are taken from `i` and `j`.
    fn resolve(i: &LawParameters, j: &LawParameters, mixed: &LawParameters) -> Resolved;

    /// The two numbers of one body from which the tangential relaxation times follow
    /// ([`super::damping::tangential_relaxation_numbers`]), time.
    fn tangential_relaxation(_: &LawParameters) -> (f64, f64) {
        (0.0, 0.0)
    }
}

/// A normal law of two types.
pub(super) struct Resolved {
    /// For the kernels.
    pub constants: NormalConstants,
    /// Share of body `i` in the penetration.
    pub share_i: f64,
}

/// The force of a penetration, in lanes. No branches on numbers: [`Real::select`].
trait NormalFormula {
    /// Whether the contact is an ellipse after Hertz: its curvatures are read, Hertz factors are computed, and the
    /// conservative law has its further terms.
    const ELLIPTICAL: bool;

    /// The force, as [`normal_force`] states it, before an attraction is cut off.
    fn force<T: Real>(
        kinds: &NormalKinds,
        c: &NormalConstants<T>,
        penetration: T,
        rate: T,
        determinant: T,
        factors: &Factors<T>,
        effective_mass: T,
    ) -> NormalForce<T>;

    /// Coefficient of the dashpot of a contact that begins to approach, force x time/length, where the normal stiffness is
    /// `stiffness`.
    fn dashpot<T: Real>(
        kinds: &NormalKinds,
        c: &NormalConstants<T>,
        stiffness: T,
        effective_mass: T,
    ) -> T;

    /// The elastic collision of bodies that meet at `speed`. `stiffness` is the normal stiffness at a penetration of 1, and
    /// `inverse_mass` the acceleration of the penetration by a unit force.
    fn collision(stiffness: f64, inverse_mass: f64, speed: f64) -> Collision;

    /// Its terms and constants, for the line that describes a law.
    fn describe(kinds: &NormalKinds, c: &NormalConstants) -> String;
}

/// How long an elastic collision lasts, and how deep it goes.
#[derive(Clone, Copy, Debug)]
pub struct Collision {
    /// From first touch to the end of the contact, time; infinite where nothing can move.
    pub time: f64,
    /// Largest penetration, length; infinite where nothing can move.
    pub penetration: f64,
}

/// The normal force of one contact and what the tangential and the conservative law take from it.
#[derive(Clone, Copy, Debug)]
pub struct NormalForce<T = f64> {
    /// Total normal force, > 0 pushes the bodies apart.
    pub force: T,
    /// Its elastic part `F_H(delta)`.
    pub elastic: T,
    /// `dF_H/d(delta)` at the present contact area (smaller than that of `delta` while a viscous contact recedes): the
    /// inverse `1/C_n` of the normal compliance, force/length.
    pub stiffness: T,
    /// Elastic energy at fixed curvature, `(2/5) F_H delta` (`kn delta^2/2` for the linear spring).
    pub elastic_energy: T,
}

/// Which terms the normal law has: the choices that select a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct NormalKinds {
    /// The formula.
    pub formula: Formula,
    /// Whether the contact is an ellipse after Hertz, whose curvatures are read.
    pub elliptical: bool,
    /// A relaxation time is not zero.
    pub relaxation: bool,
    /// Relaxing parts of `viscosity memory` ([`super::memory`]); 0 for all else.
    pub memory: u32,
    /// Ting's receding contact.
    pub ting: bool,
    /// Damping with a coefficient of restitution; the only term that reads masses.
    pub restitution: bool,
    /// Attraction is cut off.
    pub limit_force: bool,
}

impl NormalKinds {
    /// How the viscous force of a contact begins.
    #[inline(always)]
    pub(crate) fn begin(&self) -> Begin {
        match (self.elliptical, self.restitution) {
            (false, _) => Begin::Jump,
            (true, true) => Begin::FourthRoot,
            (true, false) => Begin::SquareRoot,
        }
    }
}

resolved_constants! {
    $
    /// The constants of a pair of types that the normal law reads.
    NormalConstants, normal_constants {
        /// `4/3 E*` for Hertz; `kn` for the linear spring.
        stiffness,
        /// `A_n` (time) for a relaxation; `cn` for the linear spring.
        damping,
        /// `alpha` of [`super::damping::restitution_coefficient`].
        restitution,
    }
}

impl NormalKinds {
    /// The kinds of a formula with these constants and choices.
    pub(super) fn of(law: &LawParameters, formula: Formula, c: &NormalConstants) -> NormalKinds {
        let elliptical = formula.is_elliptical();
        NormalKinds {
            formula,
            elliptical,
            relaxation: c.damping > 0.0,
            memory: 0,
            ting: elliptical && law.unloading == super::damping::Unloading::Ting,
            restitution: c.restitution > 0.0,
            limit_force: law.limit_force,
        }
    }
}

/// Normal force for a penetration `> 0`, its rate (positive while the bodies approach), the determinant of the relative
/// curvature matrix `M`, the Hertz factors at that curvature and the effective mass (read only by damping with a coefficient
/// of restitution; may be infinite on neither side).
#[inline(always)]
pub fn normal_force<T: Real>(
    kinds: &NormalKinds,
    c: &NormalConstants<T>,
    penetration: T,
    rate: T,
    determinant: T,
    factors: &Factors<T>,
    effective_mass: T,
) -> NormalForce<T> {
    let mut result = by_formula(
        kinds,
        c,
        penetration,
        rate,
        determinant,
        factors,
        effective_mass,
    );
    if kinds.limit_force {
        result.force = result.force.max(penetration.constant(0.0));
    }
    result
}

/// What a law is before the run, by its choice.
macro_rules! laws {
    ($($law:ident => $of:ty,)+) => {
        impl Normal {
            /// The formula of its force.
            pub(super) fn formula(self) -> Formula {
                match self { $(Normal::$law => <$of as Law>::FORMULA),+ }
            }

            /// The law of two types.
            pub(super) fn resolve(self, i: &LawParameters, j: &LawParameters, mixed: &LawParameters) -> Resolved {
                match self { $(Normal::$law => <$of as Law>::resolve(i, j, mixed)),+ }
            }

            /// The two numbers of one body from which the tangential relaxation times follow.
            pub(super) fn tangential_relaxation(self, p: &LawParameters) -> (f64, f64) {
                match self { $(Normal::$law => <$of as Law>::tangential_relaxation(p)),+ }
            }
        }
    };
}
use laws;

/// What a formula is in a run, by its name.
macro_rules! formulas {
    ($($(#[$doc:meta])* $formula:ident => $of:ty,)+) => {
        /// The formula of a normal force.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(i32)]
        pub enum Formula {
            $($(#[$doc])* $formula,)+
        }

        #[inline(always)]
        fn by_formula<T: Real>(
            kinds: &NormalKinds,
            c: &NormalConstants<T>,
            penetration: T,
            rate: T,
            determinant: T,
            factors: &Factors<T>,
            effective_mass: T,
        ) -> NormalForce<T> {
            match kinds.formula {
                $(Formula::$formula => <$of as NormalFormula>::force(
                    kinds, c, penetration, rate, determinant, factors, effective_mass,
                )),+
            }
        }

        impl Formula {
            fn is_elliptical(self) -> bool {
                match self { $(Formula::$formula => <$of as NormalFormula>::ELLIPTICAL),+ }
            }

            /// The elastic collision of bodies that meet at `speed`: `stiffness` is the normal stiffness at a penetration of
            /// 1, and `inverse_mass` the acceleration of the penetration by a unit force.
            pub fn collision(self, stiffness: f64, inverse_mass: f64, speed: f64) -> Collision {
                match self {
                    $(Formula::$formula => <$of as NormalFormula>::collision(stiffness, inverse_mass, speed)),+
                }
            }
        }

        impl NormalKinds {
            /// Coefficient of the dashpot of a contact that begins to approach, force x time/length, where the normal
            /// stiffness is `stiffness`.
            #[inline(always)]
            pub fn dashpot<T: Real>(&self, c: &NormalConstants<T>, stiffness: T, effective_mass: T) -> T {
                match self.formula {
                    $(Formula::$formula => <$of as NormalFormula>::dashpot(self, c, stiffness, effective_mass)),+
                }
            }

            /// Terms and constants, for the line that describes a law.
            pub fn describe(&self, c: &NormalConstants) -> String {
                match self.formula { $(Formula::$formula => <$of as NormalFormula>::describe(self, c)),+ }
            }
        }
    };
}
use formulas;

#[cfg(test)]
mod tests {
    use super::*;

    /// A law without relaxation times of its own has none across the normal either.
    #[test]
    fn a_law_that_names_no_tangential_relaxation_has_none() {
        let p = LawParameters {
            normal_damping: 3.0,
            shear_viscosity: 2.0,
            ..LawParameters::default()
        };
        assert_eq!(Normal::Lsd.tangential_relaxation(&p), (0.0, 0.0));
    }
}
