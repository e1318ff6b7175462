// SPDX-License-Identifier: MIT OR Apache-2.0
//! A law resolved before the run: which terms it has, and the constants of a pair of types.

use super::damping::{
    normal_relaxation_time, restitution_coefficient, tangential_relaxation_numbers,
};
use super::parameters::{
    check_restitution, Damping, Displacement, FactorForm, LawParameters, Normal, ParameterError,
    Tangential, Unloading,
};

/// Which terms a law has: the choices that select a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LawKinds {
    /// Linear spring instead of Hertz.
    pub linear: bool,
    /// Hale's factors instead of the exact ones.
    pub hale: bool,
    /// A relaxation time is not zero.
    pub relaxation: bool,
    /// Ting's receding contact.
    pub ting: bool,
    /// Damping with a coefficient of restitution; the only term that reads masses.
    pub restitution: bool,
    /// Attraction is cut off.
    pub limit_force: bool,
    /// The complete gradient of the elastic energy.
    pub conservative: bool,
    /// Tangential law.
    pub tangential: Tangential,
    /// What is kept of the tangential displacement.
    pub displacement: Displacement,
    /// The tangential law has a viscous part.
    pub tangential_viscous: bool,
}

/// The constants of a pair of types.
#[derive(Clone, Copy, Debug)]
pub struct LawConstants<T = f64> {
    /// `4/3 E*` for Hertz; `kn` for the linear spring.
    pub normal_stiffness: T,
    /// `A_n` (time) for a relaxation; `cn` for the linear spring.
    pub normal_damping: T,
    /// `alpha` of [`restitution_coefficient`].
    pub restitution: T,
    /// `mu`.
    pub friction: T,
    /// `kappa0`: the tangential compliance is `C_n (kappa0 - kappa1 beta)`.
    pub kappa0: T,
    /// `kappa1`.
    pub kappa1: T,
    /// `tau0`: `A_t (kappa0 - kappa1 beta) = tau0 - tau1 beta`, time.
    pub tau0: T,
    /// `tau1`.
    pub tau1: T,
    /// `kt` of `linear`.
    pub tangential_stiffness: T,
    /// `ct` of `linear`.
    pub tangential_damping: T,
    /// Share of body `i` in the penetration, `c_i/(c_i + c_j)`.
    pub share_i: T,
}

/// The law of a pair of types `(i, j)`.
#[derive(Clone, Copy, Debug)]
pub struct PairLaw {
    /// Its terms.
    pub kinds: LawKinds,
    /// Its constants.
    pub constants: LawConstants,
    /// The damping that was asked for.
    pub damping: Damping,
}

impl PairLaw {
    /// The law between a body with parameters `i` and one with parameters `j`; twice the same for a pair that was
    /// given as such. Moduli mix in series (`E*`, `G*`, `A_n` weighted by compliance), spring constants too; friction,
    /// restitution and the dashpots of the linear law mix by geometric mean, as in LAMMPS.
    ///
    /// # Errors
    /// Parameters out of range, or laws of different kinds, which cannot be mixed.
    pub fn resolve(i: &LawParameters, j: &LawParameters) -> Result<PairLaw, ParameterError> {
        i.validate()?;
        j.validate()?;
        let same = |p: &LawParameters| {
            (
                (p.normal, p.damping, p.tangential),
                (p.displacement, p.unloading, p.factors),
                (p.conservative, p.limit_force),
                (p.normal == Normal::Nfd).then_some(p.closure),
            )
        };
        if same(i) != same(j) {
            return Err(ParameterError(
                "the laws or keywords of the two types differ and cannot be mixed; give the pair its own coefficients"
                    .into(),
            ));
        }
        let harmonic = |a: f64, b: f64| {
            if a + b > 0.0 {
                2.0 * a * b / (a + b)
            } else {
                0.0
            }
        };
        let geometric = |a: f64, b: f64| if a == b { a } else { (a * b).sqrt() };
        let linear = i.normal == Normal::Lsd;
        let mut c = LawConstants {
            normal_stiffness: harmonic(i.normal_stiffness, j.normal_stiffness),
            normal_damping: geometric(i.normal_damping, j.normal_damping),
            restitution: 0.0,
            friction: geometric(i.friction, j.friction),
            kappa0: 1.0,
            kappa1: 0.0,
            tau0: 0.0,
            tau1: 0.0,
            tangential_stiffness: harmonic(i.tangential_stiffness, j.tangential_stiffness),
            tangential_damping: geometric(i.tangential_damping, j.tangential_damping),
            share_i: 0.5,
        };
        if !linear {
            let (ci, cj) = (
                i.material.normal_compliance(),
                j.material.normal_compliance(),
            );
            c.normal_stiffness = 4.0 / 3.0 / (ci + cj);
            c.share_i = ci / (ci + cj);
            let relaxation = |p: &LawParameters| match (p.normal, p.damping) {
                (Normal::Nfd, _) => normal_relaxation_time(&p.material, p.closure),
                (_, Damping::Relaxation) => p.relaxation_time,
                _ => 0.0,
            };
            c.normal_damping = (relaxation(i) * ci + relaxation(j) * cj) / (ci + cj);
            // Compliances of the two bodies add; each is (1 - nu beta)/G against (1 - nu)/G for the normal one.
            let (gi, gj) = (i.material.shear_modulus(), j.material.shear_modulus());
            let (ni, nj) = (i.material.poissons_ratio, j.material.poissons_ratio);
            let normal = (1.0 - ni) / gi + (1.0 - nj) / gj;
            c.kappa0 = (1.0 / gi + 1.0 / gj) / normal;
            c.kappa1 = (ni / gi + nj / gj) / normal;
            let tangential = |p: &LawParameters| match (p.normal, p.damping) {
                (Normal::Nfd, _) => tangential_relaxation_numbers(&p.material, p.closure),
                // One relaxation time for all deformation: proportional viscosity.
                (_, Damping::Relaxation) => (
                    p.relaxation_time,
                    p.relaxation_time * p.material.poissons_ratio,
                ),
                _ => (0.0, 0.0),
            };
            let (ti, tj) = (tangential(i), tangential(j));
            c.tau0 = (ti.0 / gi + tj.0 / gj) / normal;
            c.tau1 = (ti.1 / gi + tj.1 / gj) / normal;
        }
        if i.damping == Damping::Restitution {
            c.restitution =
                restitution_coefficient(geometric(i.restitution, j.restitution), i.limit_force);
        }
        let tangential_viscous = match i.tangential {
            Tangential::None => false,
            Tangential::Linear => c.tangential_damping > 0.0,
            _ => c.tau0 != 0.0 || c.tau1 != 0.0,
        };
        Ok(PairLaw {
            kinds: LawKinds {
                linear,
                hale: !linear && i.factors == FactorForm::Hale,
                relaxation: c.normal_damping > 0.0,
                ting: !linear && i.unloading == Unloading::Ting,
                restitution: c.restitution > 0.0,
                limit_force: i.limit_force,
                conservative: !linear && i.conservative,
                tangential: if c.friction > 0.0 {
                    i.tangential
                } else {
                    Tangential::None
                },
                displacement: i.displacement,
                tangential_viscous,
            },
            constants: c,
            damping: i.damping,
        })
    }

    /// Bounds of the stiffness (force/length) and of the damping (force x time/length) of a contact in any direction, friction
    /// without slip included: the normal stiffness that it has, times what the tangential compliance `C_n (kappa0 - kappa1 beta)`,
    /// `beta` from 0 to 1, can make of it. The effective mass is read by `damping restitution` alone.
    pub fn largest_springs(&self, normal_stiffness: f64, effective_mass: f64) -> (f64, f64) {
        let (k, c) = (&self.kinds, &self.constants);
        let normal_damping = if k.linear {
            c.normal_damping
        } else if k.relaxation {
            c.normal_damping * normal_stiffness
        } else if k.restitution {
            c.restitution * (effective_mass * normal_stiffness / 1.5).sqrt()
        } else {
            0.0
        };
        let (stiffness, damping) = match k.tangential {
            Tangential::None => (0.0, 0.0),
            Tangential::Linear => (c.tangential_stiffness, c.tangential_damping),
            Tangential::Tfd | Tangential::Mindlin => {
                let least = c.kappa0.min(c.kappa0 - c.kappa1);
                let viscous = c.tau0.max(c.tau0 - c.tau1).max(0.0);
                (
                    normal_stiffness / least,
                    normal_stiffness * viscous / (least * least),
                )
            }
        };
        (normal_stiffness.max(stiffness), normal_damping.max(damping))
    }

    /// Another coefficient of restitution.
    ///
    /// # Errors
    /// A coefficient that is not above 0 and at most 1, or a law that is not `hertz` with `damping restitution`.
    pub fn set_restitution(&mut self, e: f64) -> Result<(), ParameterError> {
        if self.damping != Damping::Restitution {
            return Err(ParameterError(
                "the law has no 'damping restitution', which goes with hertz".into(),
            ));
        }
        check_restitution(e)?;
        self.constants.restitution = restitution_coefficient(e, self.kinds.limit_force);
        self.kinds.restitution = self.constants.restitution > 0.0;
        Ok(())
    }

    /// Whether a cycle of normal and tangential displacement can give work while nothing in the law takes any: a tangential
    /// law whose stiffness changes with the contact, with another `displacement` than `rescaled`, and no viscosity.
    pub fn can_create_energy(&self) -> bool {
        let k = &self.kinds;
        matches!(k.tangential, Tangential::Tfd | Tangential::Mindlin)
            && k.displacement != Displacement::Rescaled
            && !k.relaxation
            && !k.restitution
            && !k.tangential_viscous
    }

    /// One line: the terms and the constants.
    pub fn describe(&self) -> String {
        let (k, c) = (&self.kinds, &self.constants);
        let mut text = if k.linear {
            format!("lsd kn {} cn {}", c.normal_stiffness, c.normal_damping)
        } else {
            format!("hertz E* {}", 0.75 * c.normal_stiffness)
        };
        if !k.linear && k.relaxation {
            let unloading = if k.ting { "ting" } else { "first_order" };
            text += &format!(" A_n {} unloading {unloading}", c.normal_damping);
        }
        if k.restitution {
            text += &format!(" restitution alpha {}", c.restitution);
        }
        match k.tangential {
            Tangential::None => {}
            Tangential::Tfd => text += &format!(" tfd mu {}", c.friction),
            Tangential::Mindlin => text += &format!(" mindlin mu {}", c.friction),
            Tangential::Linear => {
                text += &format!(
                    " linear kt {} ct {} mu {}",
                    c.tangential_stiffness, c.tangential_damping, c.friction
                );
            }
        }
        if k.tangential != Tangential::None {
            text += match k.displacement {
                Displacement::Total => " displacement total",
                Displacement::Incremental => " displacement incremental",
                Displacement::Rescaled => "",
            };
        }
        if k.hale {
            text += " factors hale";
        }
        if k.conservative {
            text += " conservative";
        }
        text
    }
}
