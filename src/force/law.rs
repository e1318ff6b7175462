// SPDX-License-Identifier: MIT OR Apache-2.0
//! A law resolved before the run: which terms it has, and the constants of a pair of types.
//!
//! # Example
//! ```
//! use ellgran::force::damping::{normal_relaxation_time, restitution_coefficient, tangential_relaxation_numbers};
//! use ellgran::force::syntax::parse;
//! use ellgran::force::{Closure, Material, PairLaw};
//!
//! // Viscoelastic grains: E = 10 MPa, nu = 0.3, viscosities of 1 ms times E1 and E2, friction 0.5.
//! let material = Material {
//!     youngs_modulus: 1e7,
//!     poissons_ratio: 0.3,
//!     shear_viscosity: 1e-3 * 1e7 / 1.3,
//!     bulk_viscosity: 1e-3 * 1e7 / 1.2,
//! };
//! assert!((material.shear_modulus() / 3.846e6 - 1.0).abs() < 1e-3);
//! assert!((material.shear_relaxation_time() - 1e-3).abs() < 1e-15);
//! assert!((material.bulk_relaxation_time() - 1e-3).abs() < 1e-15);
//! assert!((material.normal_compliance() - 0.91e-7).abs() < 1e-20);
//! // Where both relaxation times are the same, each closure gives that time, and so does the tangential direction.
//! for closure in [Closure::Energy, Closure::Surface, Closure::Brilliantov] {
//!     assert!((normal_relaxation_time(&material, closure) - 1e-3).abs() < 1e-12, "{closure:?}");
//! }
//! let (t0, t1) = tangential_relaxation_numbers(&material, Closure::Energy);
//! assert!((t0 - 1e-3).abs() < 1e-15 && (t1 - 0.3e-3).abs() < 1e-15);
//!
//! let words = format!(
//!     "nfd 1e7 0.3 {} {} tangential tfd 0.5",
//!     material.shear_viscosity, material.bulk_viscosity
//! );
//! let (parameters, _) = parse(&words.split(' ').collect::<Vec<_>>())?;
//! let law = PairLaw::resolve(&parameters, &parameters)?;
//! assert!((law.effective_modulus() - 0.5 / material.normal_compliance()).abs() < 1e-6);
//! // G* = G/(2 (2 - nu)) of two bodies of one material.
//! let effective_shear_modulus = material.shear_modulus() / (2.0 * (2.0 - 0.3));
//! assert!((law.effective_shear_modulus() / effective_shear_modulus - 1.0).abs() < 1e-14);
//! assert!((law.normal_relaxation_time() - 1e-3).abs() < 1e-12);
//! assert!((law.tangential_relaxation_time() - 1e-3).abs() < 1e-12);
//! assert!(!law.can_create_energy() && law.describe().contains("tfd"));
//! // Bounds for a contact whose normal stiffness is 100 N/m: the tangential one is at most (2 - 2 nu)/(2 - nu) of it on a circle.
//! let (stiffness, damping) = law.largest_springs(100.0, 1e-3);
//! assert!(stiffness >= 100.0 && damping >= 0.1);
//! assert!(!law.resistance.any());
//!
//! // Elastic grains whose impacts are damped to a coefficient of restitution.
//! let (parameters, _) = parse(&["hertz", "1e7", "0.3", "damping", "restitution", "0.8"])?;
//! let mut law = PairLaw::resolve(&parameters, &parameters)?;
//! law.set_restitution(0.9)?;
//! assert!(law.set_restitution(1.5).is_err());
//! // Without the cut-off: e = exp(-pi z/sqrt(1 - z^2)), z = alpha/sqrt(5).
//! let z = restitution_coefficient(0.9, false) / 5.0f64.sqrt();
//! assert!(((-core::f64::consts::PI * z / (1.0 - z * z).sqrt()).exp() - 0.9).abs() < 1e-14);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::damping::{restitution_coefficient, Damping, Viscosity};
use super::memory::{relaxation, MemoryConstants};
use super::normal::{NormalConstants, NormalKinds};
use super::parameters::{Constant, FactorForm, LawParameters, Normal, ParameterError};
use super::rolling::{Rolling, RollingConstants};
use super::tangential::{self, Tangential, TangentialConstants, TangentialKinds};
use super::twisting::{TwistSpring, Twisting};
use crate::real::Real;
#[cfg(not(feature = "std"))]
use alloc::string::String;

/// Which terms a law has: the choices that select a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct LawKinds {
    /// Of the normal law.
    pub normal: NormalKinds,
    /// Hale's factors instead of the exact ones.
    pub hale: bool,
    /// The complete gradient of the elastic energy.
    pub conservative: bool,
    /// Of the tangential law.
    pub tangential: TangentialKinds,
}

/// The constants of a pair of types.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct LawConstants<T = f64> {
    /// Of the normal law.
    pub normal: NormalConstants<T>,
    /// Of its memory.
    pub memory: MemoryConstants<T>,
    /// Of the tangential law.
    pub tangential: TangentialConstants<T>,
    /// Share of body `i` in the penetration, `c_i/(c_i + c_j)`.
    pub share_i: T,
}

/// What resists rolling and twisting.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Resistance {
    /// Resistance to rolling.
    pub rolling: RollingResistance,
    /// Resistance to twisting.
    pub twisting: TwistingResistance,
}

/// What resists rolling. No `Option`, whose layout differs from compiler to compiler: a device reads laws as the host lays them out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub enum RollingResistance {
    /// Nothing.
    #[default]
    None,
    /// `sds`: these constants.
    Given(RollingConstants),
}

/// What resists twisting.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub enum TwistingResistance {
    /// Nothing.
    #[default]
    None,
    /// `marshall`: that of the tangential law and the present contact ellipse.
    OfContactEllipse,
    /// `sds`: these constants.
    Given(TwistSpring),
    /// `lubkin`: by the springs of the tangential law, whose friction it shares.
    OfSprings,
}

impl Resistance {
    fn of(mixed: &LawParameters, friction: bool) -> Self {
        Resistance {
            rolling: match mixed.rolling {
                Rolling::None => RollingResistance::None,
                Rolling::Sds => RollingResistance::Given(RollingConstants {
                    stiffness: mixed.rolling_stiffness,
                    damping: mixed.rolling_damping,
                    friction: mixed.rolling_friction,
                }),
            },
            twisting: match mixed.twisting {
                Twisting::Marshall if friction => TwistingResistance::OfContactEllipse,
                Twisting::Lubkin if friction => TwistingResistance::OfSprings,
                Twisting::None | Twisting::Marshall | Twisting::Lubkin => TwistingResistance::None,
                Twisting::Sds => TwistingResistance::Given(TwistSpring {
                    stiffness: mixed.twisting_stiffness,
                    damping: mixed.twisting_damping,
                    friction: mixed.twisting_friction,
                }),
            },
        }
    }

    /// Whether anything resists.
    #[inline(always)]
    pub fn any(&self) -> bool {
        self.rolling != RollingResistance::None || self.twisting != TwistingResistance::None
    }

    fn describe(&self) -> String {
        let mut text = String::new();
        if let RollingResistance::Given(c) = &self.rolling {
            text += &format!(
                " rolling sds k_roll {} gamma_roll {} mu_roll {}",
                c.stiffness, c.damping, c.friction
            );
        }
        match &self.twisting {
            TwistingResistance::None => {}
            TwistingResistance::OfContactEllipse => text += " twisting marshall",
            TwistingResistance::OfSprings => text += " twisting lubkin",
            TwistingResistance::Given(c) => {
                text += &format!(
                    " twisting sds k_twist {} gamma_twist {} mu_twist {}",
                    c.stiffness, c.damping, c.friction
                );
            }
        }
        text
    }
}

/// The law of a pair of types `(i, j)`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct PairLaw {
    /// Its terms.
    pub kinds: LawKinds,
    /// Its constants.
    pub constants: LawConstants,
    /// What resists rolling and twisting. Not among the terms: it is computed a contact at a time, after them.
    pub resistance: Resistance,
    /// The damping that was asked for.
    pub damping: Damping,
    /// `E*`, pressure; 0 for a law without a material.
    effective_modulus: f64,
    /// `G*`, pressure; 0 for a law without a material.
    effective_shear_modulus: f64,
}

impl PairLaw {
    /// The law between a body with parameters `i` and one with parameters `j`; twice the same for a pair that was
    /// given as such. Moduli mix in series (`E*`, `G*`, `A_n` weighted by compliance), the other constants as the table in
    /// [`super::parameters`] says: spring constants in series; friction, restitution and dashpots by geometric mean, as in
    /// LAMMPS.
    ///
    /// # Errors
    /// Parameters out of range, or laws of different kinds, which cannot be mixed.
    pub fn resolve(i: &LawParameters, j: &LawParameters) -> Result<PairLaw, ParameterError> {
        i.validate()?;
        j.validate()?;
        let chosen = |p: &LawParameters| LawParameters {
            // Of no meaning to the others.
            closure: if p.normal == Normal::Nfd {
                p.closure
            } else {
                LawParameters::default().closure
            },
            ..p.without_constants()
        };
        if chosen(i) != chosen(j) {
            return Err(ParameterError(
                "the laws or keywords of the two types differ and cannot be mixed; give the pair its own coefficients"
                    .into(),
            ));
        }
        let mixed = LawParameters::mixed(i, j);
        let mut normal = i.normal.resolve(i, j, &mixed);
        let mut memory = (0, MemoryConstants::NONE);
        if i.viscosity == Viscosity::Memory {
            let found = relaxation(&i.material(), &j.material());
            if found.parts > 0 {
                normal.constants.damping = found.dashpot_time;
                memory = (found.parts as u32, found.constants);
            }
        }
        let constants = LawConstants {
            normal: normal.constants,
            memory: memory.1,
            tangential: tangential_constants(i, j, &mixed),
            share_i: normal.share_i,
        };
        let mut kinds = NormalKinds::of(i, i.normal.formula(), &constants.normal);
        kinds.memory = memory.0;
        kinds.relaxation |= kinds.memory > 0;
        let (effective_modulus, effective_shear_modulus) = effective_moduli(i, j);
        let c = &constants.tangential;
        Ok(PairLaw {
            kinds: LawKinds {
                normal: kinds,
                hale: kinds.elliptical && i.factors == FactorForm::Hale,
                conservative: kinds.elliptical && i.conservative,
                tangential: TangentialKinds {
                    law: if c.friction > 0.0 {
                        i.tangential
                    } else {
                        Tangential::None
                    },
                    displacement: i.displacement,
                    viscous: if i.tangential.needs_material() {
                        c.tau0 != 0.0 || c.tau1 != 0.0
                    } else {
                        i.tangential != Tangential::None && c.damping > 0.0
                    },
                },
            },
            constants,
            resistance: Resistance::of(&mixed, constants.tangential.friction > 0.0),
            damping: i.damping,
            effective_modulus,
            effective_shear_modulus,
        })
    }

    /// Bounds of the stiffness (force/length) and of the damping (force x time/length) of a contact in any direction, friction
    /// without slip included: the normal stiffness that it has, times what the tangential compliance `C_n (kappa0 - kappa1 beta)`,
    /// `beta` from 0 to 1, can make of it. The effective mass is read by `damping restitution` alone.
    pub fn largest_springs(&self, normal_stiffness: f64, effective_mass: f64) -> (f64, f64) {
        largest_springs(
            &self.kinds,
            &self.constants,
            normal_stiffness,
            effective_mass,
        )
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
        Constant::named("restitution").check(e)?;
        let c = &mut self.constants.normal;
        c.restitution = restitution_coefficient(e, self.kinds.normal.limit_force);
        self.kinds.normal.restitution = c.restitution > 0.0;
        Ok(())
    }

    /// Whether a cycle of normal and tangential displacement can give work while nothing in the law takes any: a tangential
    /// law whose stiffness changes with the contact, with another `displacement` than `rescaled`, and no viscosity.
    pub fn can_create_energy(&self) -> bool {
        let normal = &self.kinds.normal;
        self.kinds.tangential.can_create_energy() && !normal.relaxation && !normal.restitution
    }

    /// `E*`, pressure: `1/E* = (1 - nu_i^2)/E_i + (1 - nu_j^2)/E_j`; 0 for a law without a material.
    pub fn effective_modulus(&self) -> f64 {
        self.effective_modulus
    }

    /// `G*`, pressure: `1/G* = (2 - nu_i)/G_i + (2 - nu_j)/G_j`; 0 for a law without a material.
    pub fn effective_shear_modulus(&self) -> f64 {
        self.effective_shear_modulus
    }

    /// `A_n`, time: the ratio of dashpot and spring while the bodies approach, slowly where the law has memory; 0 for a law that has
    /// none, as for damping by a coefficient of restitution and for a law without a material.
    pub fn normal_relaxation_time(&self) -> f64 {
        if self.kinds.normal.elliptical {
            self.constants.normal.damping + self.constants.memory.relaxing_time()
        } else {
            0.0
        }
    }

    /// `A_t` of a circular contact, time: the ratio of tangential dashpot and spring without slip; 0 without a tangential law,
    /// and for one that does not take its stiffness from the material.
    pub fn tangential_relaxation_time(&self) -> f64 {
        let c = &self.constants.tangential;
        if self.kinds.tangential.law.needs_material() {
            (c.tau0 - 0.5 * c.tau1) / (c.kappa0 - 0.5 * c.kappa1)
        } else {
            0.0
        }
    }

    /// One line: the terms and the constants.
    pub fn describe(&self) -> String {
        let (k, c) = (&self.kinds, &self.constants);
        let normal = NormalConstants {
            damping: c.normal.damping + c.memory.relaxing_time(),
            ..c.normal
        };
        let mut text = k.normal.describe(&normal);
        if k.normal.memory > 0 {
            text += &format!(" memory A_n at once {}", c.normal.damping);
            for p in &c.memory.parts()[..k.normal.memory as usize] {
                text += &format!(" + {} in {}", p.share * p.ratio / p.rate, 1.0 / p.rate);
            }
        }
        text += &tangential::describe(&k.tangential, &c.tangential);
        if k.hale {
            text += " factors hale";
        }
        if k.conservative {
            text += " conservative";
        }
        text + &self.resistance.describe()
    }
}

/// The tangential compliances of two bodies add; each is `(1 - nu beta)/G` against `(1 - nu)/G` for the normal one. Without a
/// material the compliance is not read.
fn tangential_constants(
    i: &LawParameters,
    j: &LawParameters,
    mixed: &LawParameters,
) -> TangentialConstants {
    let mut c = TangentialConstants {
        friction: mixed.friction,
        kappa0: 1.0,
        kappa1: 0.0,
        tau0: 0.0,
        tau1: 0.0,
        stiffness: mixed.tangential_stiffness,
        damping: mixed.tangential_damping,
    };
    if i.normal.has_material() {
        let (gi, gj) = (i.material().shear_modulus(), j.material().shear_modulus());
        let (ni, nj) = (i.poissons_ratio, j.poissons_ratio);
        let normal = (1.0 - ni) / gi + (1.0 - nj) / gj;
        c.kappa0 = (1.0 / gi + 1.0 / gj) / normal;
        c.kappa1 = (ni / gi + nj / gj) / normal;
        let (ti, tj) = (
            i.normal.tangential_relaxation(i),
            j.normal.tangential_relaxation(j),
        );
        c.tau0 = (ti.0 / gi + tj.0 / gj) / normal;
        c.tau1 = (ti.1 / gi + tj.1 / gj) / normal;
    }
    c
}

/// `E*` and `G*`.
fn effective_moduli(i: &LawParameters, j: &LawParameters) -> (f64, f64) {
    if !i.normal.has_material() {
        return (0.0, 0.0);
    }
    let (mi, mj) = (i.material(), j.material());
    (
        1.0 / (mi.normal_compliance() + mj.normal_compliance()),
        1.0 / ((2.0 - mi.poissons_ratio) / mi.shear_modulus()
            + (2.0 - mj.poissons_ratio) / mj.shear_modulus()),
    )
}
/// See [`PairLaw::largest_springs`].
#[inline(always)]
pub(crate) fn largest_springs<T: Real>(
    kinds: &LawKinds,
    c: &LawConstants<T>,
    normal_stiffness: T,
    effective_mass: T,
) -> (T, T) {
    let mut normal_damping = kinds
        .normal
        .dashpot(&c.normal, normal_stiffness, effective_mass);
    let mut fastest = normal_stiffness;
    if kinds.normal.memory > 0 {
        let (spring, dashpot) = c.memory.springs_and_dashpots(kinds.normal.memory as usize);
        fastest = spring.multiply_add(normal_stiffness, fastest);
        normal_damping = dashpot.multiply_add(normal_stiffness, normal_damping);
    }
    let (stiffness, damping) = tangential::largest_tangential_stiffness(
        &kinds.tangential,
        &c.tangential,
        normal_stiffness,
    );
    (fastest.max(stiffness), normal_damping.max(damping))
}
