// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a user chooses and gives for one pair of types, and the checks of its ranges.

use super::material::Material;
use crate::message::Number;

/// Smallest modulus and normal stiffness, in any unit.
pub const LEAST_CONSTANT: f64 = 1e-50;
/// Largest of any constant but a relaxation time, in any unit: forces of bodies within their ranges then stay within double
/// precision.
pub const LARGEST_CONSTANT: f64 = 1e50;
/// Longest relaxation time of `damping relaxation`.
pub const LONGEST_RELAXATION_TIME: f64 = 1e20;

/// Normal law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Normal {
    /// Elastic, from `E` and `nu`; with `Damping` if asked for.
    Hertz,
    /// Viscoelastic, from `E`, `nu`, `eta1`, `eta2` and a closure.
    Nfd,
    /// Linear spring and dashpot, for comparison.
    Lsd,
}

/// Damping of the `hertz` normal law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damping {
    /// None.
    None,
    /// A coefficient of restitution of central impacts, at any speed.
    Restitution,
    /// A relaxation time `A_n`: the NFD form with the coefficient given.
    Relaxation,
}

/// How `A_n` follows from the viscosities (docs/theory.md, section 3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closure {
    /// Dissipation of the quasi-static strain-rate field.
    Energy,
    /// Surface strains of Hertz' solution.
    Surface,
    /// Brilliantov et al. 1996.
    Brilliantov,
}

/// The viscoelastic force while the overlap shrinks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unloading {
    /// `F_H(max(delta + A_n d(delta)/dt, 0))`: the contact area of the receding contact; never attractive.
    Ting,
    /// The first-order law throughout.
    FirstOrder,
}

/// Tangential law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tangential {
    /// No tangential force, no tangential history.
    None,
    /// Partial slip after Cattaneo and Mindlin, with the compliance of the contact ellipse.
    Tfd,
    /// The no-slip stiffness of the contact ellipse up to the Coulomb limit.
    Mindlin,
    /// A constant stiffness and damping up to the Coulomb limit.
    Linear,
}

/// What is kept of the tangential displacement while the contact grows and shrinks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Displacement {
    /// The displacement `xi` since first touch; force `F(xi)` at the stiffness of now: the published form. It can create
    /// energy: what was loaded while the contact was shallow gives more when it is unloaded while it is deep.
    Total,
    /// The force: `dF = k_t(delta) d xi`. It can create energy: what was loaded while the contact was deep gives more when it
    /// is unloaded while it is shallow.
    Incremental,
    /// The force, reduced where the contact would otherwise hold more energy than it took, as with the stiffness while the
    /// contact shrinks: no cycle creates energy (see [`super::tangential`]). The same as `Total` while the normal force is
    /// steady. The default.
    Rescaled,
}

/// The form of the Hertz factors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FactorForm {
    /// Exact to 1e-13.
    Exact,
    /// Hale's closed form, the paper's Eq. (4), to reproduce the paper.
    Hale,
}

/// The laws and constants of one pair of types. For a pair given as `I J`, both bodies are of this material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LawParameters {
    /// Normal law.
    pub normal: Normal,
    /// Damping of the `hertz` law.
    pub damping: Damping,
    /// Closure of `nfd`.
    pub closure: Closure,
    /// Receding contact of a law with a relaxation time.
    pub unloading: Unloading,
    /// Tangential law.
    pub tangential: Tangential,
    /// What is kept of the tangential displacement.
    pub displacement: Displacement,
    /// Form of the Hertz factors.
    pub factors: FactorForm,
    /// Whether force and torques are the complete gradient of the elastic energy (docs/theory.md, section 7).
    pub conservative: bool,
    /// Whether an attractive normal force is cut off.
    pub limit_force: bool,
    /// Material, of use with `hertz` and `nfd`.
    pub material: Material,
    /// `A_n` of `damping relaxation`, time.
    pub relaxation_time: f64,
    /// `e` of `damping restitution`.
    pub restitution: f64,
    /// `kn` of `lsd`, force/length.
    pub normal_stiffness: f64,
    /// `cn` of `lsd`, force x time/length.
    pub normal_damping: f64,
    /// Coefficient of friction `mu`.
    pub friction: f64,
    /// `kt` of `linear`, force/length.
    pub tangential_stiffness: f64,
    /// `ct` of `linear`, force x time/length.
    pub tangential_damping: f64,
}

impl Default for LawParameters {
    /// Elastic, frictionless, conservative, no attraction, a tangential displacement that creates no energy; constants zero
    /// (not valid until they are given).
    fn default() -> Self {
        LawParameters {
            normal: Normal::Hertz,
            damping: Damping::None,
            closure: Closure::Energy,
            unloading: Unloading::Ting,
            tangential: Tangential::None,
            displacement: Displacement::Rescaled,
            factors: FactorForm::Exact,
            conservative: true,
            limit_force: true,
            material: Material {
                youngs_modulus: 0.0,
                poissons_ratio: 0.0,
                shear_viscosity: 0.0,
                bulk_viscosity: 0.0,
            },
            relaxation_time: 0.0,
            restitution: 1.0,
            normal_stiffness: 0.0,
            normal_damping: 0.0,
            friction: 0.0,
            tangential_stiffness: 0.0,
            tangential_damping: 0.0,
        }
    }
}

/// A constant out of range, words that do not go together, or a form that breaks. The text names the constant and the
/// value.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterError(pub String);

impl core::fmt::Display for ParameterError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(&self.0)
    }
}
impl std::error::Error for ParameterError {}

fn check(holds: bool, name: &str, value: f64, range: &str) -> Result<(), ParameterError> {
    if holds {
        Ok(())
    } else {
        let value = Number(value);
        Err(ParameterError(format!("{name} = {value} must be {range}")))
    }
}

fn positive(name: &str, value: f64) -> Result<(), ParameterError> {
    check(
        (LEAST_CONSTANT..=LARGEST_CONSTANT).contains(&value),
        name,
        value,
        &format!("a finite number greater than 0, from {LEAST_CONSTANT:e} to {LARGEST_CONSTANT:e}"),
    )
}

fn not_negative(name: &str, value: f64) -> Result<(), ParameterError> {
    check(
        (0.0..=LARGEST_CONSTANT).contains(&value),
        name,
        value,
        &format!("a finite number, 0 or greater, at most {LARGEST_CONSTANT:e}"),
    )
}

/// A coefficient of restitution in its range.
pub(super) fn check_restitution(e: f64) -> Result<(), ParameterError> {
    check(
        e > 0.0 && e <= 1.0,
        "coefficient of restitution e",
        e,
        "greater than 0 and at most 1",
    )
}

impl LawParameters {
    /// Checks the range of every constant that the chosen laws use, and that the laws go together.
    ///
    /// # Errors
    /// The first constant out of range, by name and value.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let m = &self.material;
        match self.normal {
            Normal::Hertz | Normal::Nfd => {
                positive("Young's modulus E", m.youngs_modulus)?;
                check(
                    m.poissons_ratio > -1.0 && m.poissons_ratio <= 0.5,
                    "Poisson's ratio nu",
                    m.poissons_ratio,
                    "greater than -1 and at most 0.5",
                )?;
            }
            Normal::Lsd => {
                positive("normal stiffness kn", self.normal_stiffness)?;
                not_negative("normal damping cn", self.normal_damping)?;
                if matches!(self.tangential, Tangential::Tfd | Tangential::Mindlin) {
                    return Err(ParameterError(
                        "tangential tfd and mindlin need the elastic constants of hertz or nfd; with lsd use \
                         'tangential linear kt ct mu'"
                            .into(),
                    ));
                }
            }
        }
        if self.normal == Normal::Nfd {
            not_negative("shear viscosity eta1", m.shear_viscosity)?;
            not_negative("bulk viscosity eta2", m.bulk_viscosity)?;
            if self.closure == Closure::Brilliantov {
                check(
                    m.poissons_ratio != 0.0,
                    "Poisson's ratio nu",
                    m.poissons_ratio,
                    "different from 0 with closure brilliantov, which divides by it",
                )?;
            }
        }
        if self.normal != Normal::Hertz && self.damping != Damping::None {
            return Err(ParameterError(
                "damping restitution and damping relaxation go with hertz; nfd and lsd have their own".into(),
            ));
        }
        match self.damping {
            Damping::None => {}
            Damping::Restitution => check_restitution(self.restitution)?,
            Damping::Relaxation => check(
                (0.0..=LONGEST_RELAXATION_TIME).contains(&self.relaxation_time),
                "relaxation time A_n",
                self.relaxation_time,
                &format!("a finite number, 0 or greater, at most {LONGEST_RELAXATION_TIME:e}"),
            )?,
        }
        if self.tangential != Tangential::None {
            not_negative("coefficient of friction mu", self.friction)?;
        }
        if self.tangential == Tangential::Linear {
            not_negative("tangential stiffness kt", self.tangential_stiffness)?;
            not_negative("tangential damping ct", self.tangential_damping)?;
        }
        if self.factors == FactorForm::Hale && self.conservative && self.normal != Normal::Lsd {
            return Err(ParameterError(
                "factors hale needs 'conservative no': the derivative of Hale's form is singular at a circular \
                 contact"
                    .into(),
            ));
        }
        Ok(())
    }
}
