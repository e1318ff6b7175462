// SPDX-License-Identifier: MIT OR Apache-2.0
//! The laws between all types of a scene, resolved before the run.
//!
//! # Example
//! ```
//! use ellgran::contact::history::Remembers;
//! use ellgran::contact::{ranges, HistoryLayout, Laws, Step};
//! use ellgran::force::syntax::parse;
//!
//! let words = "hertz 1e7 0.3 damping restitution 0.8 tangential tfd 0.5 displacement incremental";
//! let (parameters, _) = parse(&words.split(' ').collect::<Vec<_>>())?;
//! let laws = Laws::new(1, &[Some(parameters)], true)?;
//! assert!(laws.features().friction && laws.features().mass);
//! let harder = laws.with_restitution(&[0.95])?;
//! assert!(harder.get(1, 1).constants.normal.restitution < laws.get(1, 1).constants.normal.restitution);
//! // What a contact has remembered means the same under both.
//! assert!(harder.read_histories_of(&laws));
//! // Without viscosity, a tangential displacement that is kept in all cases can create energy.
//! let (elastic, _) = parse(&"hertz 1e7 0.3 tangential tfd 0.5 displacement incremental".split(' ').collect::<Vec<_>>())?;
//! assert_eq!(Laws::new(1, &[Some(elastic)], true)?.creates_energy(), Some((1, 1)));
//!
//! // Normal, force and energy of 3, 3 and 1 doubles.
//! let remembers = Remembers {
//!     normal: true,
//!     tangential: true,
//!     energy: true,
//!     rests: 0,
//!     springs: false,
//!     rolling: false,
//!     twisting: false,
//!     torques: false,
//! };
//! assert_eq!(HistoryLayout::new(remembers).length, 7);
//! // A history is written for (i, j); that of (j, i) has the opposite normal.
//! let layout = laws.layout();
//! let mut history = vec![0.0; layout.length];
//! let normal = layout.normal.expect("normals are kept");
//! history[normal..normal + 3].copy_from_slice(&[0.0, 0.0, 1.0]);
//! let mut other = history.clone();
//! layout.swap(&history, &mut other);
//! assert_eq!(other[normal + 2], -1.0);
//! // A number that no step can have left is found.
//! let memory = layout.memory.expect("there is friction");
//! history[memory] = f64::NAN;
//! assert_eq!(layout.first_wrong(&history).map(|(place, _)| place), Some(memory));
//!
//! // Time passes for the histories in a step, not where forces are only looked at.
//! let mut step = Step { time_step: 1e-6, advance_history: true };
//! assert_eq!(step.elapsed(), 1e-6);
//! step.advance_history = false;
//! assert_eq!(step.elapsed(), 0.0);
//! assert!(step.time_step < ranges::LONGEST_TIME_STEP);
//! assert!(ranges::is_mass(1e-5) && !ranges::is_mass(0.5 * ranges::LEAST_MASS) && !ranges::is_mass(2.0 * ranges::LARGEST_MASS));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::history::{HistoryLayout, Remembers};
use crate::force::parameters::LARGEST_CONSTANT;
use crate::force::{
    Displacement, LawParameters, PairLaw, ParameterError, RollingResistance, Tangential,
    TwistingResistance,
};
use crate::message::Number;
#[cfg(not(feature = "std"))]
use alloc::vec::Vec;

/// Immutable table of laws; threads may share it.
#[derive(Clone, Debug)]
pub struct Laws {
    types: usize,
    table: Vec<PairLaw>,
    layout: HistoryLayout,
    /// Which terms any pair of types has.
    pub(crate) features: Features,
}

/// The terms that some pair of types has; a kernel without the others serves the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Features {
    /// A tangential law, a resistance to rolling or twisting, or memory of the normal force: a contact remembers more than its
    /// normal.
    pub friction: bool,
    /// A resistance to rolling or twisting.
    pub resistance: bool,
    /// A term that reads velocities, other than friction.
    pub viscous: bool,
    /// The conservative law's additional terms.
    pub conservative: bool,
    /// Relaxing parts of the normal force, or springs of partial slip: a history that only the kernels with records have room for.
    pub memory: bool,
    /// A term that reads masses.
    pub mass: bool,
    /// Hale's factors, which can break.
    pub hale: bool,
}

impl Features {
    fn of(table: &[PairLaw]) -> Features {
        let any = |f: &dyn Fn(&PairLaw) -> bool| table.iter().any(f);
        Features {
            friction: any(&|l| {
                l.kinds.tangential.any() || l.resistance.any() || l.kinds.normal.memory > 0
            }),
            resistance: any(&|l| l.resistance.any()),
            viscous: any(&|l| l.kinds.normal.relaxation || l.kinds.normal.restitution),
            conservative: any(&|l| l.kinds.conservative),
            memory: any(&|l| l.kinds.normal.memory > 0 || l.kinds.tangential.has_springs()),
            mass: any(&|l| l.kinds.normal.restitution),
            hale: any(&|l| l.kinds.hale),
        }
    }
}

impl Laws {
    /// From the parameters of `types * types` ordered pairs, row by row; `None` where a pair was not given. `I J` may
    /// be given as either; a pair not given is mixed from `I I` and `J J`.
    ///
    /// `cached_normal` keeps the last normal of a contact in its history (three doubles), the start of the next
    /// search. Scenes of spheres alone do without and lose nothing.
    ///
    /// # Errors
    /// A missing type, parameters out of range, or laws that cannot be mixed; the message names the types.
    ///
    /// # Panics
    /// If the slice is not `types * types` long.
    ///
    /// # Example
    /// Soft grains of type 1 and hard ones of type 2 (pressures in Pa); friction between the two is given, all else is mixed:
    /// ```
    /// use ellgran::contact::Laws;
    /// use ellgran::force::syntax::parse;
    ///
    /// let (soft, _) = parse(&["hertz", "1e6", "0.3", "tangential", "mindlin", "0.5"])?;
    /// let (hard, _) = parse(&["hertz", "1e9", "0.2", "tangential", "mindlin", "0.3"])?;
    /// let laws = Laws::new(2, &[Some(soft), None, None, Some(hard)], true)?;
    /// let compliance = |e: f64, nu: f64| (1.0 - nu * nu) / e;
    /// let expected = 1.0 / (compliance(1e6, 0.3) + compliance(1e9, 0.2));
    /// assert!((laws.get(1, 2).effective_modulus() / expected - 1.0).abs() < 1e-14);
    ///
    /// let laws = laws.with_friction(&[0.5, 0.9, 0.9, 0.3])?;
    /// assert_eq!(laws.get(2, 1).constants.tangential.friction, 0.9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(
        types: usize,
        parameters: &[Option<LawParameters>],
        cached_normal: bool,
    ) -> Result<Laws, ParameterError> {
        assert_eq!(parameters.len(), types * types);
        let given = |i: usize, j: usize| parameters[i * types + j].or(parameters[j * types + i]);
        let own = |i: usize| {
            given(i, i).ok_or_else(|| {
                ParameterError(format!("no coefficients are given for type {}", i + 1))
            })
        };
        let mut table = Vec::with_capacity(types * types);
        for i in 0..types {
            for j in 0..types {
                let law = match given(i, j) {
                    Some(p) => PairLaw::resolve(&p, &p),
                    None => PairLaw::resolve(&own(i)?, &own(j)?),
                };
                table.push(
                    law.map_err(|e| ParameterError(format!("types {} and {}: {e}", i + 1, j + 1)))?,
                );
            }
        }
        let features = Features::of(&table);
        let remembers = |displacement: Displacement| {
            let some = |l: &PairLaw| {
                l.kinds.tangential.any() && l.kinds.tangential.displacement == displacement
            };
            table.iter().any(some)
        };
        let hysteretic = remembers(Displacement::Hysteretic);
        let energy = remembers(Displacement::Rescaled) || hysteretic;
        let some = |f: &dyn Fn(&PairLaw) -> bool| table.iter().any(f);
        let mut layout = HistoryLayout::new(Remembers {
            normal: cached_normal,
            tangential: features.friction,
            energy,
            rests: table
                .iter()
                .map(|l| l.kinds.normal.memory as usize)
                .max()
                .unwrap_or(0),
            springs: hysteretic,
            rolling: some(&|l| l.resistance.rolling != RollingResistance::None),
            twisting: some(&|l| {
                !matches!(
                    l.resistance.twisting,
                    TwistingResistance::None | TwistingResistance::OfSprings
                )
            }),
            torques: some(&|l| l.resistance.twisting == TwistingResistance::OfSprings),
        });
        layout.of_displacements = remembers(Displacement::Total);
        Ok(Laws {
            types,
            table,
            layout,
            features,
        })
    }

    /// Whether what contacts remember under other laws means the same under these: it stands in the same places, and no pair of types
    /// takes a displacement for a force.
    #[cfg(feature = "std")]
    pub fn read_histories_of(&self, other: &Laws) -> bool {
        let of_displacement = |law: &PairLaw| {
            let tangential = law.kinds.tangential;
            tangential
                .any()
                .then_some(tangential.displacement == Displacement::Total)
        };
        let alike = |(a, b): (&PairLaw, &PairLaw)| match (of_displacement(a), of_displacement(b)) {
            (Some(a), Some(b)) => a == b,
            // Without friction the memory is zero.
            _ => true,
        };
        let apart_from_kinds = |layout: HistoryLayout| HistoryLayout {
            of_displacements: false,
            ..layout
        };
        self.types == other.types
            && apart_from_kinds(self.layout) == apart_from_kinds(other.layout)
            && self.table.iter().zip(&other.table).all(alike)
    }

    /// The same laws with other coefficients of friction, `types * types` of them, row by row: for engines that give
    /// friction per pair of types and all else per type. A pair with 0 has no tangential law; one that had none keeps none.
    /// The layout of the history stays.
    ///
    /// # Errors
    /// A coefficient that is negative or not finite; the message names the types.
    ///
    /// # Panics
    /// If the slice is not `types * types` long.
    pub fn with_friction(&self, friction: &[f64]) -> Result<Laws, ParameterError> {
        assert_eq!(friction.len(), self.table.len());
        let mut laws = self.clone();
        for (k, (law, &mu)) in laws.table.iter_mut().zip(friction).enumerate() {
            if !(0.0..=LARGEST_CONSTANT).contains(&mu) {
                let (i, j) = (k / self.types + 1, k % self.types + 1);
                return Err(ParameterError(format!(
                    "types {i} and {j}: friction = {} must be at least 0 and at most {LARGEST_CONSTANT:e}",
                    Number(mu)
                )));
            }
            law.constants.tangential.friction = mu;
            if mu == 0.0 {
                law.kinds.tangential.law = Tangential::None;
                if matches!(
                    law.resistance.twisting,
                    TwistingResistance::OfContactEllipse | TwistingResistance::OfSprings
                ) {
                    law.resistance.twisting = TwistingResistance::None;
                }
            }
        }
        laws.features = Features::of(&laws.table);
        Ok(laws)
    }

    /// The same laws with coefficients of restitution, `types * types` of them, row by row: for engines that give
    /// restitution per pair of types and all else per type. Only for laws with `damping restitution`.
    ///
    /// # Errors
    /// A coefficient that is not above 0 and at most 1, or laws with another damping; the message names the types.
    ///
    /// # Panics
    /// If the slice is not `types * types` long.
    pub fn with_restitution(&self, restitution: &[f64]) -> Result<Laws, ParameterError> {
        assert_eq!(restitution.len(), self.table.len());
        let mut laws = self.clone();
        for (k, (law, &e)) in laws.table.iter_mut().zip(restitution).enumerate() {
            let (i, j) = (k / self.types + 1, k % self.types + 1);
            law.set_restitution(e)
                .map_err(|e| ParameterError(format!("types {i} and {j}: {e}")))?;
        }
        laws.features = Features::of(&laws.table);
        Ok(laws)
    }

    /// The first pair of types whose law can create energy while nothing in it dissipates any
    /// ([`PairLaw::can_create_energy`]), counted from 1.
    pub fn creates_energy(&self) -> Option<(usize, usize)> {
        let k = self.table.iter().position(PairLaw::can_create_energy)?;
        Some((k / self.types + 1, k % self.types + 1))
    }

    /// Number of types.
    pub fn types(&self) -> usize {
        self.types
    }

    /// The law between two types, counted from 1.
    ///
    /// # Panics
    /// For a type out of range.
    #[inline(always)]
    pub fn get(&self, type_i: usize, type_j: usize) -> &PairLaw {
        &self.table[(type_i - 1) * self.types + (type_j - 1)]
    }

    /// The layout of a contact's history.
    pub fn layout(&self) -> HistoryLayout {
        self.layout
    }

    /// The terms that some pair of types has.
    pub fn features(&self) -> Features {
        self.features
    }
}

#[cfg(feature = "std")]
impl Laws {
    /// Where the law between two types, counted from 1, stands among all; [`Laws::at`] gives it.
    #[inline(always)]
    pub(crate) fn index(&self, type_i: u32, type_j: u32) -> u32 {
        (type_i - 1) * self.types as u32 + (type_j - 1)
    }

    /// The law that stands there.
    ///
    /// # Panics
    /// For a place that [`Laws::index`] has not given.
    #[inline(always)]
    pub(crate) fn at(&self, index: u32) -> &PairLaw {
        &self.table[index as usize]
    }
}
