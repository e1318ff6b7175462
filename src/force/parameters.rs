// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a user chooses and gives for one pair of types: words, constants, defaults, ranges, mixing, and numbers in C.

use super::choice::{choices, Choice};
use super::damping::{Closure, Damping, Unloading, Viscosity};
use super::material::Material;
use super::rolling::Rolling;
use super::tangential::{Displacement, Tangential};
use super::twisting::Twisting;
use crate::message::Number;
#[cfg(not(feature = "std"))]
use crate::real::Real;
#[cfg(not(feature = "std"))]
use alloc::string::String;
#[cfg(not(feature = "std"))]
use alloc::vec::Vec;

/// Smallest modulus and normal stiffness, in any unit.
pub const LEAST_CONSTANT: f64 = 1e-50;
/// Largest of any constant but a relaxation time, in any unit: forces of bodies within their ranges then stay within double
/// precision.
pub const LARGEST_CONSTANT: f64 = 1e50;
/// Longest relaxation time of `damping relaxation`.
pub const LONGEST_RELAXATION_TIME: f64 = 1e20;

choices! {
    /// Normal law.
    Normal {
        /// Normal law: elastic, from E and nu, with damping if asked for.
        Hertz = 0, "hertz", ELLGRAN_NORMAL_HERTZ, [youngs_modulus, poissons_ratio];
        /// Normal law: viscoelastic, from E, nu, eta1, eta2 and a closure.
        Nfd = 1, "nfd", ELLGRAN_NORMAL_NFD, [youngs_modulus, poissons_ratio, shear_viscosity, bulk_viscosity];
        /// Normal law: linear spring and dashpot, for comparison.
        Lsd = 2, "lsd", ELLGRAN_NORMAL_LSD, [normal_stiffness, normal_damping];
    }

    /// The form of the Hertz factors.
    FactorForm {
        /// Hertz factors exact to 1e-13.
        Exact = 0, "exact", ELLGRAN_FACTORS_EXACT, [];
        /// Hale's closed form of the Hertz factors, the paper's Eq. (4), to reproduce the paper.
        Hale = 1, "hale", ELLGRAN_FACTORS_HALE, [];
    }
}

/// All that is given for a pair of types: what is chosen, by name in Rust and by number in C; what is switched on or off; and
/// the constants. A row of the constants is the field with its value where it is not given, the symbol of the decks, the name
/// for messages, the range, and how the constants of two types mix. The order is that of the fields in C, where what is new
/// comes last: hence the blocks of what came later. `cargo xtask header` reads this table too.
macro_rules! with_parameters {
    ($callback:ident) => {
        $callback! {
            /// The laws and constants of one pair of types; for a pair given as I J both bodies are of this material. Plain
            /// data: may be copied and stored in restart files. Consistent units. Moduli and `normal_stiffness` are from 1e-50
            /// to 1e50, the other constants at most 1e50, a relaxation time at most 1e20.
            choices {
                /// Normal law, ELLGRAN_NORMAL_*.
                normal: Normal = Hertz;
                /// Damping of the `hertz` law, ELLGRAN_DAMPING_*.
                damping: Damping = None;
                /// Tangential law, ELLGRAN_TANGENTIAL_*.
                tangential: Tangential = None;
                /// How the relaxation times of `nfd` follow from the viscosities, ELLGRAN_CLOSURE_*.
                closure: Closure = Energy;
                /// Receding contact of a law with a relaxation time, ELLGRAN_UNLOADING_*.
                unloading: Unloading = Ting;
                /// Form of the Hertz factors, ELLGRAN_FACTORS_*.
                factors: FactorForm = Exact;
                /// What is kept of the tangential displacement, ELLGRAN_DISPLACEMENT_*.
                displacement: Displacement = Rescaled;
            }
            switches {
                /// Whether force and torques are the complete gradient of the elastic energy (docs/theory.md, section 7); else
                /// the force acts along the normal alone.
                conservative = true;
                /// Whether an attractive normal force is cut off.
                limit_force = true;
            }
            constants {
                /// Young's modulus E, pressure.
                youngs_modulus = 0.0, "E", "Young's modulus E", POSITIVE, each_its_own;
                /// Poisson's ratio nu.
                poissons_ratio = 0.0, "nu", "Poisson's ratio nu", POISSONS_RATIO, each_its_own;
                /// Shear viscosity eta1, pressure x time.
                shear_viscosity = 0.0, "eta1", "shear viscosity eta1", NOT_NEGATIVE, each_its_own;
                /// Bulk viscosity eta2, pressure x time.
                bulk_viscosity = 0.0, "eta2", "bulk viscosity eta2", NOT_NEGATIVE, each_its_own;
                /// A_n of `damping relaxation`, time.
                relaxation_time = 0.0, "A_n", "relaxation time A_n", RELAXATION_TIME, each_its_own;
                /// e of `damping restitution`.
                restitution = 1.0, "e", "coefficient of restitution e", RESTITUTION, geometric_mean;
                /// kn of `lsd`, force/length.
                normal_stiffness = 0.0, "kn", "normal stiffness kn", POSITIVE, in_series;
                /// cn of `lsd`, force x time/length.
                normal_damping = 0.0, "cn", "normal damping cn", NOT_NEGATIVE, geometric_mean;
                /// Coefficient of friction mu.
                friction = 0.0, "mu", "coefficient of friction mu", NOT_NEGATIVE, geometric_mean;
                /// kt of `tangential linear`, force/length.
                tangential_stiffness = 0.0, "kt", "tangential stiffness kt", NOT_NEGATIVE, in_series;
                /// ct of `tangential linear`, force x time/length.
                tangential_damping = 0.0, "ct", "tangential damping ct", NOT_NEGATIVE, geometric_mean;
            }
            later_choices {
                /// Resistance to rolling, ELLGRAN_ROLLING_*.
                rolling: Rolling = None;
                /// Resistance to twisting, ELLGRAN_TWISTING_*.
                twisting: Twisting = None;
            }
            later_constants {
                /// k_roll of `rolling sds`, force/length.
                rolling_stiffness = 0.0, "k_roll", "rolling stiffness k_roll", NOT_NEGATIVE, geometric_mean;
                /// gamma_roll of `rolling sds`, force x time/length.
                rolling_damping = 0.0, "gamma_roll", "rolling damping gamma_roll", NOT_NEGATIVE, geometric_mean;
                /// Coefficient of rolling friction mu_roll of `rolling sds`.
                rolling_friction = 0.0, "mu_roll", "coefficient of rolling friction mu_roll", NOT_NEGATIVE, geometric_mean;
                /// k_twist of `twisting sds`, torque (per radian).
                twisting_stiffness = 0.0, "k_twist", "twisting stiffness k_twist", NOT_NEGATIVE, geometric_mean;
                /// gamma_twist of `twisting sds`, torque x time.
                twisting_damping = 0.0, "gamma_twist", "twisting damping gamma_twist", NOT_NEGATIVE, geometric_mean;
                /// mu_twist of `twisting sds`, length: the largest torque over the normal force.
                twisting_friction = 0.0, "mu_twist", "twisting friction mu_twist", NOT_NEGATIVE, geometric_mean;
            }
            latest_choices {
                /// To which order in the rate the normal force of `nfd` is right, ELLGRAN_VISCOSITY_*.
                viscosity: Viscosity = FirstOrder;
            }
        }
    };
}
pub(crate) use with_parameters;

macro_rules! law_parameters {
    (
        $(#[$about:meta])*
        choices { $( $(#[$choice_doc:meta])* $choice:ident: $type:ident = $default:ident; )+ }
        switches { $( $(#[$switch_doc:meta])* $switch:ident = $on:literal; )+ }
        constants {
            $( $(#[$doc:meta])*
            $constant:ident = $value:literal, $symbol:literal, $name:literal, $range:ident, $mixing:ident; )+
        }
        later_choices {
            $( $(#[$later_choice_doc:meta])*
            $later_choice:ident: $later_type:ident = $later_default:ident; )+
        }
        later_constants {
            $( $(#[$later_doc:meta])*
            $later:ident = $later_value:literal, $later_symbol:literal, $later_name:literal, $later_range:ident,
            $later_mixing:ident; )+
        }
        latest_choices {
            $( $(#[$latest_choice_doc:meta])*
            $latest_choice:ident: $latest_type:ident = $latest_default:ident; )+
        }
    ) => {
        law_parameters! {
            @all
            $(#[$about])*
            choices {
                $( $(#[$choice_doc])* $choice: $type = $default; )+
                $( $(#[$later_choice_doc])* $later_choice: $later_type = $later_default; )+
                $( $(#[$latest_choice_doc])* $latest_choice: $latest_type = $latest_default; )+
            }
            switches { $( $(#[$switch_doc])* $switch = $on; )+ }
            constants {
                $( $(#[$doc])* $constant = $value, $symbol, $name, $range, $mixing; )+
                $( $(#[$later_doc])* $later = $later_value, $later_symbol, $later_name, $later_range, $later_mixing; )+
            }
        }
    };
    (
        @all
        $(#[$about:meta])*
        choices { $( $(#[$choice_doc:meta])* $choice:ident: $type:ident = $default:ident; )+ }
        switches { $( $(#[$switch_doc:meta])* $switch:ident = $on:literal; )+ }
        constants {
            $( $(#[$doc:meta])*
            $constant:ident = $value:literal, $symbol:literal, $name:literal, $range:ident, $mixing:ident; )+
        }
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct LawParameters {
            $( $(#[$choice_doc])* pub $choice: $type, )+
            $( $(#[$switch_doc])* pub $switch: bool, )+
            $( $(#[$doc])* pub $constant: f64, )+
        }

        impl Default for LawParameters {
            /// Elastic, frictionless, conservative, no attraction, a tangential displacement that creates no energy; constants
            /// zero (not valid until they are given).
            fn default() -> Self {
                LawParameters {
                    $( $choice: $type::$default, )+
                    $( $switch: $on, )+
                    $( $constant: $value, )+
                }
            }
        }

        /// The keywords of a deck; the first chooses the normal law.
        pub(super) const KEYWORDS: &[Keyword] = &[
            $( Keyword {
                name: stringify!($choice),
                words: || $type::ALL.iter().map(|c| c.word()).collect(),
                choose: |p, word| {
                    p.$choice = $type::of_word(word)?;
                    Some(p.$choice.constants())
                },
            }, )+
            $( Keyword {
                name: stringify!($switch),
                words: || YES_NO.to_vec(),
                choose: |p, word| {
                    p.$switch = YES_NO.iter().position(|w| *w == word)? == 0;
                    Some(&[])
                },
            }, )+
        ];

        /// The constants.
        pub(super) const CONSTANTS: &[Constant] = &[
            $( Constant {
                field: stringify!($constant),
                symbol: $symbol,
                name: $name,
                range: &$range,
                of: |p| &mut p.$constant,
            }, )+
        ];

        impl LawParameters {
            /// The constants that the choices ask for, by name.
            fn asked_for(&self) -> impl Iterator<Item = &'static str> {
                [$( self.$choice.constants(), )+].into_iter().flatten().copied()
            }

            /// The constants of a contact of two types, each mixed as the table says, with the choices of `i`. Constants of a
            /// material are those of `i`: a law takes them from each body.
            pub(super) fn mixed(i: &Self, j: &Self) -> Self {
                LawParameters {
                    $( $constant: $mixing(i.$constant, j.$constant), )+
                    ..*i
                }
            }

            /// What is chosen and switched, without the constants.
            pub(super) fn without_constants(&self) -> Self {
                LawParameters {
                    $( $constant: $value, )+
                    ..*self
                }
            }
        }
    };
}
with_parameters!(law_parameters);

const YES_NO: [&str; 2] = ["yes", "no"];

/// A keyword of a deck.
pub(super) struct Keyword {
    /// The keyword, which is the field's name.
    pub name: &'static str,
    /// The words that can follow.
    pub words: fn() -> Vec<&'static str>,
    /// Takes a word; the constants that follow it, `None` for another word.
    pub choose: fn(&mut LawParameters, &str) -> Option<&'static [&'static str]>,
}

/// A constant that a user gives.
pub(super) struct Constant {
    /// The field's name.
    pub field: &'static str,
    /// The symbol of the decks.
    pub symbol: &'static str,
    /// What to call it in a message.
    name: &'static str,
    range: &'static Range,
    /// The field.
    pub of: fn(&mut LawParameters) -> &mut f64,
}

impl Constant {
    /// The constant of a field.
    ///
    /// # Panics
    /// If a table of choices names a field that there is not.
    pub(super) fn named(field: &str) -> &'static Constant {
        let found = CONSTANTS.iter().find(|c| c.field == field);
        found.unwrap_or_else(|| panic!("{field} is not in the table of constants"))
    }

    pub(super) fn check(&self, value: f64) -> Result<(), ParameterError> {
        check(
            (self.range.holds)(value),
            self.name,
            value,
            &(self.range.says)(),
        )
    }
}

/// Which values a constant may have.
struct Range {
    holds: fn(f64) -> bool,
    /// What it must be.
    says: fn() -> String,
}

const POSITIVE: Range = Range {
    holds: |x| (LEAST_CONSTANT..=LARGEST_CONSTANT).contains(&x),
    says: || {
        format!("a finite number greater than 0, from {LEAST_CONSTANT:e} to {LARGEST_CONSTANT:e}")
    },
};
const NOT_NEGATIVE: Range = Range {
    holds: |x| (0.0..=LARGEST_CONSTANT).contains(&x),
    says: || format!("a finite number, 0 or greater, at most {LARGEST_CONSTANT:e}"),
};
const POISSONS_RATIO: Range = Range {
    holds: |x| x > -1.0 && x <= 0.5,
    says: || "greater than -1 and at most 0.5".into(),
};
const RELAXATION_TIME: Range = Range {
    holds: |x| (0.0..=LONGEST_RELAXATION_TIME).contains(&x),
    says: || format!("a finite number, 0 or greater, at most {LONGEST_RELAXATION_TIME:e}"),
};
const RESTITUTION: Range = Range {
    holds: |x| x > 0.0 && x <= 1.0,
    says: || "greater than 0 and at most 1".into(),
};

/// A constant of a material: a law takes it from each body.
fn each_its_own(i: f64, _: f64) -> f64 {
    i
}

/// Two springs in series, as of one body each: harmonic mean.
fn in_series(i: f64, j: f64) -> f64 {
    if i + j > 0.0 {
        2.0 * i * j / (i + j)
    } else {
        0.0
    }
}

/// Geometric mean.
fn geometric_mean(i: f64, j: f64) -> f64 {
    if i == j {
        i
    } else {
        (i * j).sqrt()
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
impl core::error::Error for ParameterError {}

fn check(holds: bool, name: &str, value: f64, range: &str) -> Result<(), ParameterError> {
    if holds {
        Ok(())
    } else {
        let value = Number(value);
        Err(ParameterError(format!("{name} = {value} must be {range}")))
    }
}

/// The words of those choices for which something holds, for messages.
pub(super) fn words_of<C: Choice>(holds: impl Fn(C) -> bool) -> String {
    let words: Vec<&str> = C::ALL
        .iter()
        .filter(|c| holds(**c))
        .map(|c| c.word())
        .collect();
    words.join(" or ")
}

impl Normal {
    /// Whether the law has the elastic constants of a material.
    pub fn has_material(self) -> bool {
        self.constants().contains(&"youngs_modulus")
    }
}

impl LawParameters {
    /// The material, of use with `hertz` and `nfd`.
    pub fn material(&self) -> Material {
        Material {
            youngs_modulus: self.youngs_modulus,
            poissons_ratio: self.poissons_ratio,
            shear_viscosity: self.shear_viscosity,
            bulk_viscosity: self.bulk_viscosity,
        }
    }

    /// Checks the range of every constant that the chosen laws use, and that the laws go together.
    ///
    /// # Errors
    /// The first constant out of range, by name and value.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let mut copy = *self;
        for field in self.asked_for() {
            let constant = Constant::named(field);
            constant.check(*(constant.of)(&mut copy))?;
        }
        self.check_combination().map_err(ParameterError)
    }

    /// Whether `viscosity memory` goes with the rest.
    fn check_memory(&self) -> Result<(), String> {
        let word = self.viscosity.word();
        if self.normal != Normal::Nfd {
            return Err(format!(
                "viscosity {word} goes with {}, whose two viscosities it needs; not with {}",
                Normal::Nfd.word(),
                self.normal.word()
            ));
        }
        if self.closure != Closure::Energy {
            return Err(format!(
                "viscosity {word} has no closure, it follows from the two viscosities: closure {} goes with 'viscosity {}'",
                self.closure.word(),
                Viscosity::FirstOrder.word()
            ));
        }
        if self.unloading != Unloading::Ting {
            return Err(format!(
                "viscosity {word} has a receding contact of its own: unloading {} goes with 'viscosity {}'",
                self.unloading.word(),
                Viscosity::FirstOrder.word()
            ));
        }
        Ok(())
    }

    /// Whether the laws go together.
    fn check_combination(&self) -> Result<(), String> {
        let normal = self.normal.word();
        if self.tangential.needs_material() && !self.normal.has_material() {
            let others = words_of(|t: Tangential| t != Tangential::None && !t.needs_material());
            return Err(format!(
                "tangential {} needs the elastic constants of {}; with {normal} use 'tangential {others}'",
                self.tangential.word(),
                words_of(Normal::has_material)
            ));
        }
        if self.displacement == Displacement::Hysteretic && self.tangential != Tangential::Tfd {
            return Err(format!(
                "displacement {} goes with 'tangential {}', whose partial slip it follows back; not with '{}'",
                self.displacement.word(),
                Tangential::Tfd.word(),
                self.tangential.word()
            ));
        }
        if self.twisting == Twisting::Lubkin && self.displacement != Displacement::Hysteretic {
            return Err(format!(
                "twisting {} shares the friction of the springs of 'tangential {} displacement {}': give these too, or use 'twisting {}'",
                self.twisting.word(),
                Tangential::Tfd.word(),
                Displacement::Hysteretic.word(),
                Twisting::Marshall.word(),
            ));
        }
        if self.normal == Normal::Nfd
            && self.closure == Closure::Brilliantov
            && self.poissons_ratio == 0.0
        {
            return Err(
                "Poisson's ratio nu = 0 must be different from 0 with closure brilliantov, which divides by it"
                    .into(),
            );
        }
        if self.normal != Normal::Hertz && self.damping != Damping::None {
            return Err(format!(
                "damping {} goes with hertz; {normal} has its own",
                self.damping.word()
            ));
        }
        if self.viscosity == Viscosity::Memory {
            self.check_memory()?;
        }
        if self.twisting == Twisting::Marshall && self.tangential == Tangential::None {
            return Err(format!(
                "twisting {} has the stiffness, the damping and the friction of the tangential law: give 'tangential {}' too, \
                 or use 'twisting {}', which has its own",
                self.twisting.word(),
                words_of(|t: Tangential| t != Tangential::None),
                words_of(|t: Twisting| !t.constants().is_empty()),
            ));
        }
        if self.factors == FactorForm::Hale && self.conservative && self.normal.has_material() {
            return Err(
                "factors hale needs 'conservative no': the derivative of Hale's form is singular at a circular \
                 contact"
                    .into(),
            );
        }
        Ok(())
    }
}
