// SPDX-License-Identifier: MIT OR Apache-2.0
//! A register of numbers: the contact law's [`Real`] in the lanes of whatever instruction set was chosen.

use super::particles::Record;
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

/// An instruction set that can turn records of particles into registers.
pub trait Registers: Simd {
    /// Entries `start..start + 8` of the first records, one register per entry.
    fn columns(self, records: &[&Record; MOST_LANES], start: usize) -> [Self::f64s; 8];
}

// Macros, not closures: a closure is not always inlined into the code of the chosen instruction set, and then costs a
// call and a trip through memory.
#[cfg(target_arch = "x86_64")]
impl Registers for pulp::x86::V4 {
    #[inline(always)]
    fn columns(self, records: &[&Record; MOST_LANES], start: usize) -> [Self::f64s; 8] {
        let avx = self.avx512f;
        macro_rules! row {
            ($k:literal) => {
                pulp::cast(Self::as_simd_f64s(&records[$k].0[start..start + 8]).0[0])
            };
        }
        // Pairs of rows interleaved, then quarters of registers exchanged twice.
        macro_rules! quarters {
            ($a:expr, $b:expr, $c:expr, $d:expr) => {{
                let u0 = avx._mm512_shuffle_f64x2::<0x88>($a, $b);
                let u1 = avx._mm512_shuffle_f64x2::<0xdd>($a, $b);
                let u2 = avx._mm512_shuffle_f64x2::<0x88>($c, $d);
                let u3 = avx._mm512_shuffle_f64x2::<0xdd>($c, $d);
                (
                    pulp::cast(avx._mm512_shuffle_f64x2::<0x88>(u0, u2)),
                    pulp::cast(avx._mm512_shuffle_f64x2::<0x88>(u1, u3)),
                    pulp::cast(avx._mm512_shuffle_f64x2::<0xdd>(u0, u2)),
                    pulp::cast(avx._mm512_shuffle_f64x2::<0xdd>(u1, u3)),
                )
            }};
        }
        let (r0, r1, r2, r3) = (row!(0), row!(1), row!(2), row!(3));
        let (r4, r5, r6, r7) = (row!(4), row!(5), row!(6), row!(7));
        let (c0, c2, c4, c6) = quarters!(
            avx._mm512_unpacklo_pd(r0, r1),
            avx._mm512_unpacklo_pd(r2, r3),
            avx._mm512_unpacklo_pd(r4, r5),
            avx._mm512_unpacklo_pd(r6, r7)
        );
        let (c1, c3, c5, c7) = quarters!(
            avx._mm512_unpackhi_pd(r0, r1),
            avx._mm512_unpackhi_pd(r2, r3),
            avx._mm512_unpackhi_pd(r4, r5),
            avx._mm512_unpackhi_pd(r6, r7)
        );
        [c0, c1, c2, c3, c4, c5, c6, c7]
    }
}

#[cfg(target_arch = "x86_64")]
impl Registers for pulp::x86::V3 {
    #[inline(always)]
    fn columns(self, records: &[&Record; MOST_LANES], start: usize) -> [Self::f64s; 8] {
        let avx = self.avx;
        macro_rules! four {
            ($start:expr) => {{
                macro_rules! row {
                    ($k:literal) => {
                        pulp::cast(Self::as_simd_f64s(&records[$k].0[$start..$start + 4]).0[0])
                    };
                }
                let (a, b, c, d) = (row!(0), row!(1), row!(2), row!(3));
                let (t0, t1) = (avx._mm256_unpacklo_pd(a, b), avx._mm256_unpackhi_pd(a, b));
                let (t2, t3) = (avx._mm256_unpacklo_pd(c, d), avx._mm256_unpackhi_pd(c, d));
                (
                    pulp::cast(avx._mm256_permute2f128_pd::<0x20>(t0, t2)),
                    pulp::cast(avx._mm256_permute2f128_pd::<0x20>(t1, t3)),
                    pulp::cast(avx._mm256_permute2f128_pd::<0x31>(t0, t2)),
                    pulp::cast(avx._mm256_permute2f128_pd::<0x31>(t1, t3)),
                )
            }};
        }
        let (c0, c1, c2, c3) = four!(start);
        let (c4, c5, c6, c7) = four!(start + 4);
        [c0, c1, c2, c3, c4, c5, c6, c7]
    }
}

impl<S: Simd> Lanes<S> {
    /// Registers as numbers.
    #[inline(always)]
    pub fn all(simd: S, v: [S::f64s; 8]) -> [Self; 8] {
        [
            Lanes { simd, value: v[0] },
            Lanes { simd, value: v[1] },
            Lanes { simd, value: v[2] },
            Lanes { simd, value: v[3] },
            Lanes { simd, value: v[4] },
            Lanes { simd, value: v[5] },
            Lanes { simd, value: v[6] },
            Lanes { simd, value: v[7] },
        ]
    }
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
