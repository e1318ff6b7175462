// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the law needs in lanes beside the geometry: its constants, and Hertz' factors.

use crate::force::hertz_factors::{
    fit_variable, fitted, fitted_near, near_variable, FIT_END, NEAR_END,
};
use crate::force::memory::memory_constants;
use crate::force::normal::normal_constants;
use crate::force::tangential::tangential_constants;
use crate::force::{
    Factors, LawConstants, LawKinds, MemoryConstants, NormalConstants, PairLaw, TangentialConstants,
};
use crate::real::Real;
use crate::simd::{Lanes, Registers, MOST_LANES};
use crate::vector::Symmetric2;

/// A number of the law in each lane.
macro_rules! load_constant {
    ($registers:expr, $laws:expr, $only:expr, $($field:ident).+) => {
        if let Some(law) = $only {
            Lanes::splat($registers, law.constants.$($field).+)
        } else {
            let mut numbers = [0.0; MOST_LANES];
            for k in 0..S::LANES {
                numbers[k] = $laws[k].constants.$($field).+;
            }
            Lanes::load($registers, &numbers)
        }
    };
}

/// The constants of a part of the law, whose name and whose fields come last.
macro_rules! load_part {
    ($registers:expr, $laws:expr, $only:expr, $part:ident, $name:ident, $($field:ident),+) => {
        $name { $($field: load_constant!($registers, $laws, $only, $part.$field)),+ }
    };
}

macro_rules! load_constants {
    ($registers:expr, $laws:expr, $only:expr) => {
        LawConstants {
            normal: normal_constants!(load_part, $registers, $laws, $only, normal,),
            memory: memory_constants!(load_part, $registers, $laws, $only, memory,),
            tangential: tangential_constants!(load_part, $registers, $laws, $only, tangential,),
            share_i: load_constant!($registers, $laws, $only, share_i),
        }
    };
}

/// The constants of the laws of all lanes; `only` is the law of all, where there is one.
#[inline(always)]
pub(crate) fn constants_of<S: Registers>(
    registers: S,
    laws: &[&PairLaw; MOST_LANES],
    only: Option<&PairLaw>,
) -> LawConstants<Lanes<S>> {
    load_constants!(registers, laws, only)
}

/// Hertz factors where contacts are circles, or taken as such.
#[inline(always)]
pub(crate) fn factors_of_circles<S: Registers>(
    registers: S,
    kinds: &LawKinds,
) -> Factors<Lanes<S>> {
    let one = Lanes::splat(registers, 1.0);
    let sigma = if kinds.normal.elliptical {
        1.0 / 6.0
    } else {
        0.0
    };
    Factors {
        phi: one,
        sigma: one * sigma,
    }
}

/// Hertz factors of curvatures, and the lanes that are beyond their fit. Lanes `apart` are not asked for.
#[inline(always)]
pub(crate) fn factors_for<S: Registers>(
    registers: S,
    kinds: &LawKinds,
    curvature: Symmetric2<Lanes<S>>,
    apart: S::Mask,
    with_sigma: bool,
) -> (Factors<Lanes<S>>, S::Mask) {
    let none = registers.no_lane();
    if !kinds.normal.elliptical {
        return (factors_of_circles(registers, kinds), none);
    }
    let one = Lanes::splat(registers, 1.0);
    let (trace, determinant) = (curvature.trace(), curvature.determinant());
    let q = near_variable(trace, determinant);
    let near = registers.or(q.less(one.constant(NEAR_END)), apart);
    if registers.all(near) {
        return (fitted_near(q, with_sigma), none);
    }
    let w = fit_variable(trace, determinant);
    let beyond = registers.and_not(one.constant(FIT_END).less(w), apart);
    (fitted(w, with_sigma), beyond)
}
