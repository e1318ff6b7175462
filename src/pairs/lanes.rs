// SPDX-License-Identifier: MIT OR Apache-2.0
//! A register of numbers: the contact law's [`Real`] in the lanes of whatever instruction set was chosen.

use crate::real::Real;
use core::ops::{Add, Div, Mul, Neg, Sub};
use pulp::Simd;

/// The most lanes of any instruction set here (AVX-512).
pub const MOST_LANES: usize = 8;

/// One register. `simd` is of size zero: the proof that the instruction set is there.
#[derive(Clone, Copy)]
pub struct Lanes<S: Simd> {
    simd: S,
    value: S::f64s,
}

impl<S: Simd> Lanes<S> {
    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(simd: S, value: f64) -> Self {
        Lanes {
            simd,
            value: simd.splat_f64s(value),
        }
    }
    /// The first lanes of a row.
    #[inline(always)]
    pub fn load(simd: S, row: &[f64; MOST_LANES]) -> Self {
        Lanes {
            simd,
            value: S::as_simd_f64s(row).0[0],
        }
    }
    /// Writes the first lanes of a row.
    #[inline(always)]
    pub fn store(self, row: &mut [f64; MOST_LANES]) {
        S::as_mut_simd_f64s(row).0[0] = self.value;
    }
    /// The smallest lane.
    #[inline(always)]
    pub fn smallest(self) -> f64 {
        self.simd.reduce_min_f64s(self.value)
    }
    /// The largest lane.
    #[inline(always)]
    pub fn largest(self) -> f64 {
        self.simd.reduce_max_f64s(self.value)
    }
}

macro_rules! operation {
    ($trait:ident, $method:ident, $function:ident) => {
        impl<S: Simd> $trait for Lanes<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Lanes {
                    simd: self.simd,
                    value: self.simd.$function(self.value, other.value),
                }
            }
        }
    };
}
operation!(Add, add, add_f64s);
operation!(Sub, sub, sub_f64s);
operation!(Mul, mul, mul_f64s);
operation!(Div, div, div_f64s);

macro_rules! operation_with_constant {
    ($trait:ident, $method:ident) => {
        impl<S: Simd> $trait<f64> for Lanes<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                $trait::$method(self, Lanes::splat(self.simd, other))
            }
        }
    };
}
operation_with_constant!(Add, add);
operation_with_constant!(Sub, sub);
operation_with_constant!(Mul, mul);

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Lanes {
            simd: self.simd,
            value: self.simd.neg_f64s(self.value),
        }
    }
}

impl<S: Simd> Real for Lanes<S> {
    type Mask = S::m64s;

    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        Lanes::splat(self.simd, value)
    }
    #[inline(always)]
    fn multiply_add(self, a: Self, b: Self) -> Self {
        Lanes {
            simd: self.simd,
            value: self.simd.mul_add_f64s(self.value, a.value, b.value),
        }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Lanes {
            simd: self.simd,
            value: self.simd.sqrt_f64s(self.value),
        }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Lanes {
            simd: self.simd,
            value: self.simd.max_f64s(self.value, other.value),
        }
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Lanes {
            simd: self.simd,
            value: self.simd.min_f64s(self.value, other.value),
        }
    }
    #[inline(always)]
    fn less(self, other: Self) -> S::m64s {
        self.simd.less_than_f64s(self.value, other.value)
    }
    #[inline(always)]
    fn select(mask: S::m64s, if_true: Self, if_false: Self) -> Self {
        Lanes {
            simd: if_true.simd,
            value: if_true
                .simd
                .select_f64s(mask, if_true.value, if_false.value),
        }
    }
    /// Relative error 4e-16 for arguments from 1 to 1e300: exponent and mantissa apart, then the series of the inverse
    /// hyperbolic tangent.
    #[inline(always)]
    fn ln(self) -> Self {
        let simd = self.simd;
        let bits = simd.transmute_u64s_f64s(self.value);
        let exponent_bits = simd.and_u64s(bits, simd.splat_u64s(0x7ff0_0000_0000_0000));
        let mantissa_bits = simd.or_u64s(
            simd.and_u64s(bits, simd.splat_u64s(0x000f_ffff_ffff_ffff)),
            simd.splat_u64s(0x3ff0_0000_0000_0000),
        );
        // The biased exponent as a number: shifted to bit 32 of the mantissa of 2^52.
        let shifted: S::u64s = pulp::bytemuck::cast(simd.wrapping_dyn_shr_u32s(
            pulp::bytemuck::cast::<S::u64s, S::u32s>(exponent_bits),
            simd.splat_u32s(20),
        ));
        let magic = simd.or_u64s(shifted, simd.splat_u64s(0x4330_0000_0000_0000));
        let number = |value: S::f64s| Lanes { simd, value };
        let two_to_52 = 4503599627370496.0;
        let exponent =
            (number(simd.transmute_f64s_u64s(magic)) - two_to_52) * (1.0 / 4294967296.0) - 1023.0;
        let mantissa = number(simd.transmute_f64s_u64s(mantissa_bits));
        let high = mantissa.constant(core::f64::consts::SQRT_2).less(mantissa);
        let mantissa = Self::select(high, mantissa * 0.5, mantissa);
        let exponent = Self::select(high, exponent + 1.0, exponent);
        let s = (mantissa - 1.0) / (mantissa + 1.0);
        let z = s * s;
        let mut series = z.constant(1.0 / 23.0);
        for k in (1..11).rev() {
            series = series.multiply_add(z, z.constant(1.0 / (2 * k + 1) as f64));
        }
        let tail = s * z * series;
        exponent.multiply_add(exponent.constant(core::f64::consts::LN_2), (tail + s) * 2.0)
    }
}
