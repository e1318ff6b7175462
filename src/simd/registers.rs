// SPDX-License-Identifier: MIT OR Apache-2.0
//! The registers of each instruction set: the few operations that the contact law and the search are made of.
//!
//! Intrinsics are called directly where they are safe to call: on a proof of the instruction set that `pulp` hands out,
//! or where the target always has them. Macros, not closures: a closure is not always inlined into the code of the
//! chosen instruction set, and then costs a call and a trip through memory.

/// The most lanes of any instruction set here: two registers of AVX-512.
pub const MOST_LANES: usize = 16;

/// Eight doubles, one cache line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Line(pub [f64; 8]);

impl Line {
    /// All zero.
    pub const ZERO: Line = Line([0.0; 8]);
}

#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
#[cold]
#[inline(never)]
fn too_short() -> ! {
    panic!("fewer numbers than lanes")
}

/// An instruction set: `self`, of size zero, is the proof that the machine has it.
pub trait Registers: Copy {
    /// Numbers in a register.
    const LANES: usize;
    /// A register.
    type Vector: Copy;
    /// The truth of a comparison, one per lane.
    type Mask: Copy;

    /// `value` in every lane.
    fn splat(self, value: f64) -> Self::Vector;
    /// The first numbers, as many as there are lanes.
    fn load(self, numbers: &[f64]) -> Self::Vector;
    /// The reverse of `load`.
    fn store(self, a: Self::Vector, numbers: &mut [f64]);
    /// `a + b`.
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a - b`.
    fn subtract(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a * b`.
    fn multiply(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a * b + c`.
    fn multiply_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
    /// `a * b - c`.
    fn multiply_subtract(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
    /// `c - a * b`.
    fn negative_multiply_add(
        self,
        a: Self::Vector,
        b: Self::Vector,
        c: Self::Vector,
    ) -> Self::Vector;
    /// `1/a` of a normal number whose inverse is one too; error at most one rounding.
    fn reciprocal(self, a: Self::Vector) -> Self::Vector;
    /// `a/b`, with `b` as in `reciprocal`.
    fn divide(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `1/sqrt(a)` of a positive normal number; error at most two roundings.
    fn reciprocal_sqrt(self, a: Self::Vector) -> Self::Vector;
    /// `sqrt(a)` of zero or a positive normal number above 1e-300.
    fn sqrt(self, a: Self::Vector) -> Self::Vector;
    /// The larger; where `a` is NaN, `b`.
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// The smaller; where `a` is NaN, `b`.
    fn min(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a < b`.
    fn less(self, a: Self::Vector, b: Self::Vector) -> Self::Mask;
    /// `a` where the mask holds, else `b`.
    fn select(self, mask: Self::Mask, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Both.
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Either.
    fn or(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// `a` and not `b`.
    fn and_not(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// One bit per lane, the first lane lowest.
    fn bits(self, mask: Self::Mask) -> u32;
    /// Mantissa from 1 up to 2 and exponent of positive normal numbers.
    fn mantissa_and_exponent(self, a: Self::Vector) -> (Self::Vector, Self::Vector);
    /// Entry `k` of the first lines, for `k` from 0 to 7.
    fn columns(self, lines: &[&Line]) -> [Self::Vector; 8];
    /// Brings the cache line of a number closer, if the machine can be told so.
    fn prefetch(self, number: &f64);
    /// The reverse: entry `k` of the first lines is register `k`.
    fn lines(self, columns: [Self::Vector; 8], lines: &mut [Line]);
    /// Adds lane `l` of the registers `a`, as a line, to line `at_a[l]`, and that of `b` to line `at_b[l]`; lane after lane,
    /// so that a line that is named twice gets both.
    fn add_to_lines(
        self,
        a: [Self::Vector; 8],
        at_a: &[u32],
        b: [Self::Vector; 8],
        at_b: &[u32],
        lines: &mut [Line],
    );
    /// The reverse of `bits`.
    fn mask(self, bits: u32) -> Self::Mask;
}

/// Rows of eight columns.
#[cfg(target_arch = "x86_64")]
macro_rules! transposed_eight {
    ($avx:expr, $c:expr) => {{
        let (avx, c) = ($avx, $c);
        // Pairs of columns interleaved, then quarters of registers exchanged twice.
        macro_rules! quarters {
            ($p:expr, $q:expr, $r:expr, $s:expr) => {{
                let (p, q, r, s) = ($p, $q, $r, $s);
                let u0 = avx._mm512_shuffle_f64x2::<0x88>(p, q);
                let u1 = avx._mm512_shuffle_f64x2::<0xdd>(p, q);
                let u2 = avx._mm512_shuffle_f64x2::<0x88>(r, s);
                let u3 = avx._mm512_shuffle_f64x2::<0xdd>(r, s);
                (
                    avx._mm512_shuffle_f64x2::<0x88>(u0, u2),
                    avx._mm512_shuffle_f64x2::<0x88>(u1, u3),
                    avx._mm512_shuffle_f64x2::<0xdd>(u0, u2),
                    avx._mm512_shuffle_f64x2::<0xdd>(u1, u3),
                )
            }};
        }
        let (r0, r2, r4, r6) = quarters!(
            avx._mm512_unpacklo_pd(c[0], c[1]),
            avx._mm512_unpacklo_pd(c[2], c[3]),
            avx._mm512_unpacklo_pd(c[4], c[5]),
            avx._mm512_unpacklo_pd(c[6], c[7])
        );
        let (r1, r3, r5, r7) = quarters!(
            avx._mm512_unpackhi_pd(c[0], c[1]),
            avx._mm512_unpackhi_pd(c[2], c[3]),
            avx._mm512_unpackhi_pd(c[4], c[5]),
            avx._mm512_unpackhi_pd(c[6], c[7])
        );
        (r0, r1, r2, r3, r4, r5, r6, r7)
    }};
}

#[cfg(target_arch = "x86_64")]
impl Registers for pulp::x86::V4 {
    const LANES: usize = 8;
    type Vector = core::arch::x86_64::__m512d;
    type Mask = u8;

    #[inline(always)]
    fn splat(self, value: f64) -> Self::Vector {
        self.avx512f._mm512_set1_pd(value)
    }
    #[inline(always)]
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx512f._mm512_add_pd(a, b)
    }
    #[inline(always)]
    fn subtract(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx512f._mm512_sub_pd(a, b)
    }
    #[inline(always)]
    fn multiply(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx512f._mm512_mul_pd(a, b)
    }
    #[inline(always)]
    fn multiply_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
        self.avx512f._mm512_fmadd_pd(a, b, c)
    }
    #[inline(always)]
    fn multiply_subtract(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
        self.avx512f._mm512_fmsub_pd(a, b, c)
    }
    #[inline(always)]
    fn negative_multiply_add(
        self,
        a: Self::Vector,
        b: Self::Vector,
        c: Self::Vector,
    ) -> Self::Vector {
        self.avx512f._mm512_fnmadd_pd(a, b, c)
    }
    // The divider takes 16 cycles for eight lanes and the root 24, one at a time: an estimate of 14 bits and a
    // polynomial in its error keep the other units busy instead.
    #[inline(always)]
    fn reciprocal(self, a: Self::Vector) -> Self::Vector {
        let one = self.splat(1.0);
        let r = self.avx512f._mm512_rcp14_pd(a);
        let e = self.negative_multiply_add(a, r, one);
        // r (1 + e + e^2 + e^3), e < 2^-14
        let series = self.multiply_add(self.multiply_add(e, e, e), e, e);
        self.multiply_add(r, series, r)
    }
    #[inline(always)]
    fn divide(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.multiply(a, self.reciprocal(b))
    }
    #[inline(always)]
    fn reciprocal_sqrt(self, a: Self::Vector) -> Self::Vector {
        let r = self.avx512f._mm512_rsqrt14_pd(a);
        let e = self.negative_multiply_add(self.multiply(a, r), r, self.splat(1.0));
        // (1 - e)^(-1/2), e < 2^-13
        let series = self.multiply_add(e, self.splat(35.0 / 128.0), self.splat(0.3125));
        let series = self.multiply_add(e, series, self.splat(0.375));
        let series = self.multiply_add(e, series, self.splat(0.5));
        self.multiply_add(self.multiply(r, e), series, r)
    }
    #[inline(always)]
    fn sqrt(self, a: Self::Vector) -> Self::Vector {
        self.multiply(a, self.reciprocal_sqrt(self.max(a, self.splat(1e-300))))
    }
    #[inline(always)]
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx512f._mm512_max_pd(a, b)
    }
    #[inline(always)]
    fn min(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx512f._mm512_min_pd(a, b)
    }
    #[inline(always)]
    fn less(self, a: Self::Vector, b: Self::Vector) -> u8 {
        self.avx512f
            ._mm512_cmp_pd_mask::<{ core::arch::x86_64::_CMP_LT_OQ }>(a, b)
    }
    #[inline(always)]
    fn select(self, mask: u8, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx512f._mm512_mask_blend_pd(mask, b, a)
    }
    #[inline(always)]
    fn and(self, a: u8, b: u8) -> u8 {
        a & b
    }
    #[inline(always)]
    fn or(self, a: u8, b: u8) -> u8 {
        a | b
    }
    #[inline(always)]
    fn and_not(self, a: u8, b: u8) -> u8 {
        a & !b
    }
    #[inline(always)]
    fn bits(self, mask: u8) -> u32 {
        u32::from(mask)
    }
    #[inline(always)]
    fn mantissa_and_exponent(self, a: Self::Vector) -> (Self::Vector, Self::Vector) {
        use core::arch::x86_64::{_MM_MANT_NORM_1_2, _MM_MANT_SIGN_ZERO};
        (
            self.avx512f
                ._mm512_getmant_pd::<_MM_MANT_NORM_1_2, _MM_MANT_SIGN_ZERO>(a),
            self.avx512f._mm512_getexp_pd(a),
        )
    }
    #[inline(always)]
    fn prefetch(self, number: &f64) {
        self.sse
            ._mm_prefetch::<{ core::arch::x86_64::_MM_HINT_T0 }>(
                core::ptr::from_ref(number).cast(),
            );
    }
    #[inline(always)]
    fn columns(self, lines: &[&Line]) -> [Self::Vector; 8] {
        let avx = self.avx512f;
        // Lines k and k+4 share a register of halves: the exchange of halves is done by the loads.
        macro_rules! halves {
            ($at:literal, $k:literal) => {{
                let low: &[[f64; 4]; 2] = pulp::bytemuck::cast_ref(&lines[$k].0);
                let high: &[[f64; 4]; 2] = pulp::bytemuck::cast_ref(&lines[$k + 4].0);
                avx._mm512_insertf64x4::<1>(
                    avx._mm512_castpd256_pd512(pulp::cast(low[$at])),
                    pulp::cast(high[$at]),
                )
            }};
        }
        macro_rules! four {
            ($at:literal) => {{
                let (r0, r1) = (halves!($at, 0), halves!($at, 1));
                let (r2, r3) = (halves!($at, 2), halves!($at, 3));
                // Within each half a 4 x 4 transposition.
                let (t0, t1) = (
                    avx._mm512_unpacklo_pd(r0, r1),
                    avx._mm512_unpackhi_pd(r0, r1),
                );
                let (t2, t3) = (
                    avx._mm512_unpacklo_pd(r2, r3),
                    avx._mm512_unpackhi_pd(r2, r3),
                );
                let low: core::arch::x86_64::__m512i = pulp::cast([0i64, 1, 8, 9, 4, 5, 12, 13]);
                let high: core::arch::x86_64::__m512i = pulp::cast([2i64, 3, 10, 11, 6, 7, 14, 15]);
                (
                    avx._mm512_permutex2var_pd(t0, low, t2),
                    avx._mm512_permutex2var_pd(t1, low, t3),
                    avx._mm512_permutex2var_pd(t0, high, t2),
                    avx._mm512_permutex2var_pd(t1, high, t3),
                )
            }};
        }
        let (c0, c1, c2, c3) = four!(0);
        let (c4, c5, c6, c7) = four!(1);
        [c0, c1, c2, c3, c4, c5, c6, c7]
    }
    #[inline(always)]
    fn lines(self, c: [Self::Vector; 8], lines: &mut [Line]) {
        let rows = transposed_eight!(self.avx512f, c);
        lines[0].0 = pulp::cast(rows.0);
        lines[1].0 = pulp::cast(rows.1);
        lines[2].0 = pulp::cast(rows.2);
        lines[3].0 = pulp::cast(rows.3);
        lines[4].0 = pulp::cast(rows.4);
        lines[5].0 = pulp::cast(rows.5);
        lines[6].0 = pulp::cast(rows.6);
        lines[7].0 = pulp::cast(rows.7);
    }
    #[inline(always)]
    fn add_to_lines(
        self,
        a: [Self::Vector; 8],
        at_a: &[u32],
        b: [Self::Vector; 8],
        at_b: &[u32],
        lines: &mut [Line],
    ) {
        let rows_a = transposed_eight!(self.avx512f, a);
        let rows_b = transposed_eight!(self.avx512f, b);
        macro_rules! lane {
            ($k:tt) => {
                let line = &mut lines[at_a[$k] as usize].0;
                *line = pulp::cast(self.add(pulp::cast(*line), rows_a.$k));
                let line = &mut lines[at_b[$k] as usize].0;
                *line = pulp::cast(self.add(pulp::cast(*line), rows_b.$k));
            };
        }
        lane!(0);
        lane!(1);
        lane!(2);
        lane!(3);
        lane!(4);
        lane!(5);
        lane!(6);
        lane!(7);
    }
    #[inline(always)]
    fn load(self, numbers: &[f64]) -> Self::Vector {
        match numbers.first_chunk::<8>() {
            Some(numbers) => pulp::cast(*numbers),
            None => too_short(),
        }
    }
    #[inline(always)]
    fn store(self, a: Self::Vector, numbers: &mut [f64]) {
        match numbers.first_chunk_mut::<8>() {
            Some(numbers) => *numbers = pulp::cast(a),
            None => too_short(),
        }
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> u8 {
        bits as u8
    }
}

#[cfg(target_arch = "x86_64")]
macro_rules! transposed_four {
    ($avx:expr, $a:expr, $b:expr, $c:expr, $d:expr) => {{
        let avx = $avx;
        let (a, b, c, d) = ($a, $b, $c, $d);
        let (t0, t1) = (avx._mm256_unpacklo_pd(a, b), avx._mm256_unpackhi_pd(a, b));
        let (t2, t3) = (avx._mm256_unpacklo_pd(c, d), avx._mm256_unpackhi_pd(c, d));
        (
            avx._mm256_permute2f128_pd::<0x20>(t0, t2),
            avx._mm256_permute2f128_pd::<0x20>(t1, t3),
            avx._mm256_permute2f128_pd::<0x31>(t0, t2),
            avx._mm256_permute2f128_pd::<0x31>(t1, t3),
        )
    }};
}
#[cfg(target_arch = "x86_64")]
impl Registers for pulp::x86::V3 {
    const LANES: usize = 4;
    type Vector = core::arch::x86_64::__m256d;
    type Mask = core::arch::x86_64::__m256d;

    #[inline(always)]
    fn splat(self, value: f64) -> Self::Vector {
        self.avx._mm256_set1_pd(value)
    }
    #[inline(always)]
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx._mm256_add_pd(a, b)
    }
    #[inline(always)]
    fn subtract(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx._mm256_sub_pd(a, b)
    }
    #[inline(always)]
    fn multiply(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx._mm256_mul_pd(a, b)
    }
    #[inline(always)]
    fn multiply_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
        self.fma._mm256_fmadd_pd(a, b, c)
    }
    #[inline(always)]
    fn multiply_subtract(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
        self.fma._mm256_fmsub_pd(a, b, c)
    }
    #[inline(always)]
    fn negative_multiply_add(
        self,
        a: Self::Vector,
        b: Self::Vector,
        c: Self::Vector,
    ) -> Self::Vector {
        self.fma._mm256_fnmadd_pd(a, b, c)
    }
    #[inline(always)]
    fn reciprocal(self, a: Self::Vector) -> Self::Vector {
        self.avx._mm256_div_pd(self.splat(1.0), a)
    }
    #[inline(always)]
    fn divide(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx._mm256_div_pd(a, b)
    }
    #[inline(always)]
    fn reciprocal_sqrt(self, a: Self::Vector) -> Self::Vector {
        self.reciprocal(self.avx._mm256_sqrt_pd(a))
    }
    #[inline(always)]
    fn sqrt(self, a: Self::Vector) -> Self::Vector {
        self.avx._mm256_sqrt_pd(a)
    }
    #[inline(always)]
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx._mm256_max_pd(a, b)
    }
    #[inline(always)]
    fn min(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx._mm256_min_pd(a, b)
    }
    #[inline(always)]
    fn less(self, a: Self::Vector, b: Self::Vector) -> Self::Mask {
        self.avx
            ._mm256_cmp_pd::<{ core::arch::x86_64::_CMP_LT_OQ }>(a, b)
    }
    #[inline(always)]
    fn select(self, mask: Self::Mask, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx._mm256_blendv_pd(b, a, mask)
    }
    #[inline(always)]
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        self.avx._mm256_and_pd(a, b)
    }
    #[inline(always)]
    fn or(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        self.avx._mm256_or_pd(a, b)
    }
    #[inline(always)]
    fn and_not(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        self.avx._mm256_andnot_pd(b, a)
    }
    #[inline(always)]
    fn bits(self, mask: Self::Mask) -> u32 {
        self.avx._mm256_movemask_pd(mask) as u32
    }
    #[inline(always)]
    fn mantissa_and_exponent(self, a: Self::Vector) -> (Self::Vector, Self::Vector) {
        let (avx, avx2) = (self.avx, self.avx2);
        let bits = avx._mm256_castpd_si256(a);
        let mantissa = avx2._mm256_or_si256(
            avx2._mm256_and_si256(bits, avx._mm256_set1_epi64x(MANTISSA)),
            avx._mm256_set1_epi64x(ONE),
        );
        let exponent = avx2._mm256_or_si256(
            avx2._mm256_srli_epi64::<52>(bits),
            avx._mm256_set1_epi64x(TWO_TO_52),
        );
        (
            avx._mm256_castsi256_pd(mantissa),
            avx._mm256_sub_pd(
                avx._mm256_castsi256_pd(exponent),
                self.splat(4503599627370496.0 + 1023.0),
            ),
        )
    }
    #[inline(always)]
    fn prefetch(self, number: &f64) {
        self.sse
            ._mm_prefetch::<{ core::arch::x86_64::_MM_HINT_T0 }>(
                core::ptr::from_ref(number).cast(),
            );
    }
    #[inline(always)]
    fn columns(self, lines: &[&Line]) -> [Self::Vector; 8] {
        macro_rules! four {
            ($at:literal) => {{
                macro_rules! row {
                    ($k:literal) => {{
                        let halves: &[[f64; 4]; 2] = pulp::bytemuck::cast_ref(&lines[$k].0);
                        pulp::cast(halves[$at])
                    }};
                }
                transposed_four!(self.avx, row!(0), row!(1), row!(2), row!(3))
            }};
        }
        let (c0, c1, c2, c3) = four!(0);
        let (c4, c5, c6, c7) = four!(1);
        [c0, c1, c2, c3, c4, c5, c6, c7]
    }
    #[inline(always)]
    fn lines(self, c: [Self::Vector; 8], lines: &mut [Line]) {
        let (a0, a1, a2, a3) = transposed_four!(self.avx, c[0], c[1], c[2], c[3]);
        let (b0, b1, b2, b3) = transposed_four!(self.avx, c[4], c[5], c[6], c[7]);
        macro_rules! put {
            ($k:literal, $a:expr, $b:expr) => {
                let halves: &mut [[f64; 4]; 2] = pulp::bytemuck::cast_mut(&mut lines[$k].0);
                halves[0] = pulp::cast($a);
                halves[1] = pulp::cast($b);
            };
        }
        put!(0, a0, b0);
        put!(1, a1, b1);
        put!(2, a2, b2);
        put!(3, a3, b3);
    }
    #[inline(always)]
    fn add_to_lines(
        self,
        a: [Self::Vector; 8],
        at_a: &[u32],
        b: [Self::Vector; 8],
        at_b: &[u32],
        lines: &mut [Line],
    ) {
        // Half a line after the other: no more registers than there are.
        macro_rules! half {
            ($half:literal, $k:literal) => {
                let rows_a = transposed_four!(self.avx, a[$k], a[$k + 1], a[$k + 2], a[$k + 3]);
                let rows_b = transposed_four!(self.avx, b[$k], b[$k + 1], b[$k + 2], b[$k + 3]);
                half!(@lane $half, rows_a, rows_b, 0);
                half!(@lane $half, rows_a, rows_b, 1);
                half!(@lane $half, rows_a, rows_b, 2);
                half!(@lane $half, rows_a, rows_b, 3);
            };
            (@lane $half:literal, $a:ident, $b:ident, $k:tt) => {
                let line: &mut [[f64; 4]; 2] =
                    pulp::bytemuck::cast_mut(&mut lines[at_a[$k] as usize].0);
                line[$half] = pulp::cast(self.add(pulp::cast(line[$half]), $a.$k));
                let line: &mut [[f64; 4]; 2] =
                    pulp::bytemuck::cast_mut(&mut lines[at_b[$k] as usize].0);
                line[$half] = pulp::cast(self.add(pulp::cast(line[$half]), $b.$k));
            };
        }
        half!(0, 0);
        half!(1, 4);
    }
    #[inline(always)]
    fn load(self, numbers: &[f64]) -> Self::Vector {
        match numbers.first_chunk::<4>() {
            Some(numbers) => pulp::cast(*numbers),
            None => too_short(),
        }
    }
    #[inline(always)]
    fn store(self, a: Self::Vector, numbers: &mut [f64]) {
        match numbers.first_chunk_mut::<4>() {
            Some(numbers) => *numbers = pulp::cast(a),
            None => too_short(),
        }
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> Self::Mask {
        let avx2 = self.avx2;
        let lanes = self.avx._mm256_setr_epi64x(1, 2, 4, 8);
        let bits = avx2._mm256_and_si256(self.avx._mm256_set1_epi64x(i64::from(bits)), lanes);
        self.avx
            ._mm256_castsi256_pd(avx2._mm256_cmpeq_epi64(bits, lanes))
    }
}

/// Bits of a double: its mantissa, those of 1 and of 2^52.
const MANTISSA: i64 = 0x000f_ffff_ffff_ffff;
const ONE: i64 = 0x3ff0_0000_0000_0000;
#[cfg(target_arch = "x86_64")]
const TWO_TO_52: i64 = 0x4330_0000_0000_0000;

/// Products and sums apart: a fused operation is a library call on a machine that may not have it.
macro_rules! two_roundings {
    () => {
        #[inline(always)]
        fn multiply_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
            self.add(self.multiply(a, b), c)
        }
        #[inline(always)]
        fn multiply_subtract(
            self,
            a: Self::Vector,
            b: Self::Vector,
            c: Self::Vector,
        ) -> Self::Vector {
            self.subtract(self.multiply(a, b), c)
        }
        #[inline(always)]
        fn negative_multiply_add(
            self,
            a: Self::Vector,
            b: Self::Vector,
            c: Self::Vector,
        ) -> Self::Vector {
            self.subtract(c, self.multiply(a, b))
        }
    };
}

#[cfg(target_arch = "x86_64")]
impl Registers for pulp::x86::V1 {
    const LANES: usize = 2;
    type Vector = core::arch::x86_64::__m128d;
    type Mask = core::arch::x86_64::__m128d;

    #[inline(always)]
    fn splat(self, value: f64) -> Self::Vector {
        self.sse2._mm_set1_pd(value)
    }
    #[inline(always)]
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.sse2._mm_add_pd(a, b)
    }
    #[inline(always)]
    fn subtract(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.sse2._mm_sub_pd(a, b)
    }
    #[inline(always)]
    fn multiply(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.sse2._mm_mul_pd(a, b)
    }
    two_roundings!();
    #[inline(always)]
    fn reciprocal(self, a: Self::Vector) -> Self::Vector {
        self.sse2._mm_div_pd(self.splat(1.0), a)
    }
    #[inline(always)]
    fn divide(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.sse2._mm_div_pd(a, b)
    }
    #[inline(always)]
    fn reciprocal_sqrt(self, a: Self::Vector) -> Self::Vector {
        self.reciprocal(self.sse2._mm_sqrt_pd(a))
    }
    #[inline(always)]
    fn sqrt(self, a: Self::Vector) -> Self::Vector {
        self.sse2._mm_sqrt_pd(a)
    }
    #[inline(always)]
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.sse2._mm_max_pd(a, b)
    }
    #[inline(always)]
    fn min(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.sse2._mm_min_pd(a, b)
    }
    #[inline(always)]
    fn less(self, a: Self::Vector, b: Self::Vector) -> Self::Mask {
        self.sse2._mm_cmplt_pd(a, b)
    }
    #[inline(always)]
    fn select(self, mask: Self::Mask, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        let sse2 = self.sse2;
        sse2._mm_or_pd(sse2._mm_and_pd(mask, a), sse2._mm_andnot_pd(mask, b))
    }
    #[inline(always)]
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        self.sse2._mm_and_pd(a, b)
    }
    #[inline(always)]
    fn or(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        self.sse2._mm_or_pd(a, b)
    }
    #[inline(always)]
    fn and_not(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        self.sse2._mm_andnot_pd(b, a)
    }
    #[inline(always)]
    fn bits(self, mask: Self::Mask) -> u32 {
        self.sse2._mm_movemask_pd(mask) as u32
    }
    #[inline(always)]
    fn mantissa_and_exponent(self, a: Self::Vector) -> (Self::Vector, Self::Vector) {
        let sse2 = self.sse2;
        let bits = sse2._mm_castpd_si128(a);
        let mantissa = sse2._mm_or_si128(
            sse2._mm_and_si128(bits, sse2._mm_set1_epi64x(MANTISSA)),
            sse2._mm_set1_epi64x(ONE),
        );
        let exponent = sse2._mm_or_si128(
            sse2._mm_srli_epi64::<52>(bits),
            sse2._mm_set1_epi64x(TWO_TO_52),
        );
        (
            sse2._mm_castsi128_pd(mantissa),
            sse2._mm_sub_pd(
                sse2._mm_castsi128_pd(exponent),
                self.splat(4503599627370496.0 + 1023.0),
            ),
        )
    }
    #[inline(always)]
    fn prefetch(self, number: &f64) {
        self.sse
            ._mm_prefetch::<{ core::arch::x86_64::_MM_HINT_T0 }>(
                core::ptr::from_ref(number).cast(),
            );
    }
    #[inline(always)]
    fn columns(self, lines: &[&Line]) -> [Self::Vector; 8] {
        let a: &[[f64; 2]; 4] = pulp::bytemuck::cast_ref(&lines[0].0);
        let b: &[[f64; 2]; 4] = pulp::bytemuck::cast_ref(&lines[1].0);
        macro_rules! pair {
            ($k:literal) => {{
                let (a, b) = (pulp::cast(a[$k]), pulp::cast(b[$k]));
                (
                    self.sse2._mm_unpacklo_pd(a, b),
                    self.sse2._mm_unpackhi_pd(a, b),
                )
            }};
        }
        let ((c0, c1), (c2, c3)) = (pair!(0), pair!(1));
        let ((c4, c5), (c6, c7)) = (pair!(2), pair!(3));
        [c0, c1, c2, c3, c4, c5, c6, c7]
    }
    #[inline(always)]
    fn lines(self, c: [Self::Vector; 8], lines: &mut [Line]) {
        let [a, b, ..] = lines else { too_short() };
        let a: &mut [[f64; 2]; 4] = pulp::bytemuck::cast_mut(&mut a.0);
        let b: &mut [[f64; 2]; 4] = pulp::bytemuck::cast_mut(&mut b.0);
        macro_rules! pair {
            ($k:literal) => {
                a[$k] = pulp::cast(self.sse2._mm_unpacklo_pd(c[2 * $k], c[2 * $k + 1]));
                b[$k] = pulp::cast(self.sse2._mm_unpackhi_pd(c[2 * $k], c[2 * $k + 1]));
            };
        }
        pair!(0);
        pair!(1);
        pair!(2);
        pair!(3);
    }
    #[inline(always)]
    fn add_to_lines(
        self,
        a: [Self::Vector; 8],
        at_a: &[u32],
        b: [Self::Vector; 8],
        at_b: &[u32],
        lines: &mut [Line],
    ) {
        macro_rules! quarter {
            ($k:literal, $at:expr, $row:expr) => {
                let line: &mut [[f64; 2]; 4] = pulp::bytemuck::cast_mut(&mut lines[$at as usize].0);
                line[$k] = pulp::cast(self.add(pulp::cast(line[$k]), $row));
            };
            ($k:literal) => {
                let (sse2, a0, a1) = (self.sse2, a[2 * $k], a[2 * $k + 1]);
                let (b0, b1) = (b[2 * $k], b[2 * $k + 1]);
                quarter!($k, at_a[0], sse2._mm_unpacklo_pd(a0, a1));
                quarter!($k, at_b[0], sse2._mm_unpacklo_pd(b0, b1));
                quarter!($k, at_a[1], sse2._mm_unpackhi_pd(a0, a1));
                quarter!($k, at_b[1], sse2._mm_unpackhi_pd(b0, b1));
            };
        }
        quarter!(0);
        quarter!(1);
        quarter!(2);
        quarter!(3);
    }
    #[inline(always)]
    fn load(self, numbers: &[f64]) -> Self::Vector {
        match numbers.first_chunk::<2>() {
            Some(numbers) => pulp::cast(*numbers),
            None => too_short(),
        }
    }
    #[inline(always)]
    fn store(self, a: Self::Vector, numbers: &mut [f64]) {
        match numbers.first_chunk_mut::<2>() {
            Some(numbers) => *numbers = pulp::cast(a),
            None => too_short(),
        }
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> Self::Mask {
        let bits = i64::from(bits);
        let all = |bit: i64| -(bit & 1);
        self.sse2
            ._mm_castsi128_pd(self.sse2._mm_set_epi64x(all(bits >> 1), all(bits)))
    }
}

#[cfg(target_arch = "aarch64")]
impl Registers for pulp::aarch64::Neon {
    const LANES: usize = 2;
    type Vector = core::arch::aarch64::float64x2_t;
    type Mask = core::arch::aarch64::uint64x2_t;

    #[inline(always)]
    fn splat(self, value: f64) -> Self::Vector {
        self.neon.vdupq_n_f64(value)
    }
    #[inline(always)]
    fn load(self, numbers: &[f64]) -> Self::Vector {
        match numbers.first_chunk::<2>() {
            Some(numbers) => pulp::cast(*numbers),
            None => too_short(),
        }
    }
    #[inline(always)]
    fn store(self, a: Self::Vector, numbers: &mut [f64]) {
        match numbers.first_chunk_mut::<2>() {
            Some(numbers) => *numbers = pulp::cast(a),
            None => too_short(),
        }
    }
    #[inline(always)]
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.neon.vaddq_f64(a, b)
    }
    #[inline(always)]
    fn subtract(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.neon.vsubq_f64(a, b)
    }
    #[inline(always)]
    fn multiply(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.neon.vmulq_f64(a, b)
    }
    // The addend comes first here.
    #[inline(always)]
    fn multiply_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
        self.neon.vfmaq_f64(c, a, b)
    }
    #[inline(always)]
    fn multiply_subtract(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
        self.neon.vfmaq_f64(self.neon.vnegq_f64(c), a, b)
    }
    #[inline(always)]
    fn negative_multiply_add(
        self,
        a: Self::Vector,
        b: Self::Vector,
        c: Self::Vector,
    ) -> Self::Vector {
        self.neon.vfmsq_f64(c, a, b)
    }
    #[inline(always)]
    fn reciprocal(self, a: Self::Vector) -> Self::Vector {
        self.neon.vdivq_f64(self.splat(1.0), a)
    }
    #[inline(always)]
    fn divide(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.neon.vdivq_f64(a, b)
    }
    #[inline(always)]
    fn reciprocal_sqrt(self, a: Self::Vector) -> Self::Vector {
        self.reciprocal(self.neon.vsqrtq_f64(a))
    }
    #[inline(always)]
    fn sqrt(self, a: Self::Vector) -> Self::Vector {
        self.neon.vsqrtq_f64(a)
    }
    // FMAX gives NaN for a NaN on either side, FMAXNM never: all sets give what is on the right.
    #[inline(always)]
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.select(self.less(b, a), a, b)
    }
    #[inline(always)]
    fn min(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.select(self.less(a, b), a, b)
    }
    #[inline(always)]
    fn less(self, a: Self::Vector, b: Self::Vector) -> Self::Mask {
        self.neon.vcltq_f64(a, b)
    }
    #[inline(always)]
    fn select(self, mask: Self::Mask, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.neon.vbslq_f64(mask, a, b)
    }
    #[inline(always)]
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        self.neon.vandq_u64(a, b)
    }
    #[inline(always)]
    fn or(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        self.neon.vorrq_u64(a, b)
    }
    #[inline(always)]
    fn and_not(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        self.neon.vbicq_u64(a, b)
    }
    #[inline(always)]
    fn bits(self, mask: Self::Mask) -> u32 {
        let neon = self.neon;
        (neon.vgetq_lane_u64::<0>(mask) & 1 | neon.vgetq_lane_u64::<1>(mask) & 2) as u32
    }
    #[inline(always)]
    fn mantissa_and_exponent(self, a: Self::Vector) -> (Self::Vector, Self::Vector) {
        let neon = self.neon;
        let bits = neon.vreinterpretq_u64_f64(a);
        let mantissa = neon.vorrq_u64(
            neon.vandq_u64(bits, neon.vdupq_n_u64(MANTISSA as u64)),
            neon.vdupq_n_u64(ONE as u64),
        );
        let exponent = neon.vcvtq_f64_u64(neon.vshrq_n_u64::<52>(bits));
        (
            neon.vreinterpretq_f64_u64(mantissa),
            self.subtract(exponent, self.splat(1023.0)),
        )
    }
    // Rust has no stable intrinsic for it here.
    #[inline(always)]
    fn prefetch(self, _: &f64) {}
    #[inline(always)]
    fn columns(self, lines: &[&Line]) -> [Self::Vector; 8] {
        let a: &[[f64; 2]; 4] = pulp::bytemuck::cast_ref(&lines[0].0);
        let b: &[[f64; 2]; 4] = pulp::bytemuck::cast_ref(&lines[1].0);
        macro_rules! pair {
            ($k:literal) => {{
                let (a, b) = (pulp::cast(a[$k]), pulp::cast(b[$k]));
                (self.neon.vzip1q_f64(a, b), self.neon.vzip2q_f64(a, b))
            }};
        }
        let ((c0, c1), (c2, c3)) = (pair!(0), pair!(1));
        let ((c4, c5), (c6, c7)) = (pair!(2), pair!(3));
        [c0, c1, c2, c3, c4, c5, c6, c7]
    }
    #[inline(always)]
    fn lines(self, c: [Self::Vector; 8], lines: &mut [Line]) {
        let [a, b, ..] = lines else { too_short() };
        let a: &mut [[f64; 2]; 4] = pulp::bytemuck::cast_mut(&mut a.0);
        let b: &mut [[f64; 2]; 4] = pulp::bytemuck::cast_mut(&mut b.0);
        macro_rules! pair {
            ($k:literal) => {
                a[$k] = pulp::cast(self.neon.vzip1q_f64(c[2 * $k], c[2 * $k + 1]));
                b[$k] = pulp::cast(self.neon.vzip2q_f64(c[2 * $k], c[2 * $k + 1]));
            };
        }
        pair!(0);
        pair!(1);
        pair!(2);
        pair!(3);
    }
    #[inline(always)]
    fn add_to_lines(
        self,
        a: [Self::Vector; 8],
        at_a: &[u32],
        b: [Self::Vector; 8],
        at_b: &[u32],
        lines: &mut [Line],
    ) {
        macro_rules! quarter {
            ($k:literal, $at:expr, $row:expr) => {
                let line: &mut [[f64; 2]; 4] = pulp::bytemuck::cast_mut(&mut lines[$at as usize].0);
                line[$k] = pulp::cast(self.add(pulp::cast(line[$k]), $row));
            };
            ($k:literal) => {
                let (neon, a0, a1) = (self.neon, a[2 * $k], a[2 * $k + 1]);
                let (b0, b1) = (b[2 * $k], b[2 * $k + 1]);
                quarter!($k, at_a[0], neon.vzip1q_f64(a0, a1));
                quarter!($k, at_b[0], neon.vzip1q_f64(b0, b1));
                quarter!($k, at_a[1], neon.vzip2q_f64(a0, a1));
                quarter!($k, at_b[1], neon.vzip2q_f64(b0, b1));
            };
        }
        quarter!(0);
        quarter!(1);
        quarter!(2);
        quarter!(3);
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> Self::Mask {
        let all = |bit: u32| 0u64.wrapping_sub(u64::from(bit & 1));
        pulp::cast([all(bits), all(bits >> 1)])
    }
}

/// Two lanes as the compiler makes them, on any machine.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

impl Registers for Portable {
    const LANES: usize = 2;
    type Vector = [f64; 2];
    type Mask = [bool; 2];

    #[inline(always)]
    fn splat(self, value: f64) -> [f64; 2] {
        [value; 2]
    }
    #[inline(always)]
    fn add(self, a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
        [a[0] + b[0], a[1] + b[1]]
    }
    #[inline(always)]
    fn subtract(self, a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
        [a[0] - b[0], a[1] - b[1]]
    }
    #[inline(always)]
    fn multiply(self, a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
        [a[0] * b[0], a[1] * b[1]]
    }
    two_roundings!();
    #[inline(always)]
    fn reciprocal(self, a: [f64; 2]) -> [f64; 2] {
        [1.0 / a[0], 1.0 / a[1]]
    }
    #[inline(always)]
    fn divide(self, a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
        [a[0] / b[0], a[1] / b[1]]
    }
    #[inline(always)]
    fn reciprocal_sqrt(self, a: [f64; 2]) -> [f64; 2] {
        [1.0 / a[0].sqrt(), 1.0 / a[1].sqrt()]
    }
    #[inline(always)]
    fn sqrt(self, a: [f64; 2]) -> [f64; 2] {
        [a[0].sqrt(), a[1].sqrt()]
    }
    #[inline(always)]
    fn max(self, a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
        use crate::real::Real;
        [Real::max(a[0], b[0]), Real::max(a[1], b[1])]
    }
    #[inline(always)]
    fn min(self, a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
        use crate::real::Real;
        [Real::min(a[0], b[0]), Real::min(a[1], b[1])]
    }
    #[inline(always)]
    fn less(self, a: [f64; 2], b: [f64; 2]) -> [bool; 2] {
        [a[0] < b[0], a[1] < b[1]]
    }
    #[inline(always)]
    fn select(self, mask: [bool; 2], a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
        [
            if mask[0] { a[0] } else { b[0] },
            if mask[1] { a[1] } else { b[1] },
        ]
    }
    #[inline(always)]
    fn and(self, a: [bool; 2], b: [bool; 2]) -> [bool; 2] {
        [a[0] & b[0], a[1] & b[1]]
    }
    #[inline(always)]
    fn or(self, a: [bool; 2], b: [bool; 2]) -> [bool; 2] {
        [a[0] | b[0], a[1] | b[1]]
    }
    #[inline(always)]
    fn and_not(self, a: [bool; 2], b: [bool; 2]) -> [bool; 2] {
        [a[0] & !b[0], a[1] & !b[1]]
    }
    #[inline(always)]
    fn bits(self, mask: [bool; 2]) -> u32 {
        u32::from(mask[0]) | u32::from(mask[1]) << 1
    }
    #[inline(always)]
    fn mantissa_and_exponent(self, a: [f64; 2]) -> ([f64; 2], [f64; 2]) {
        let mantissa = |x: f64| f64::from_bits(x.to_bits() & MANTISSA as u64 | ONE as u64);
        let exponent = |x: f64| (x.to_bits() >> 52) as i32 as f64 - 1023.0;
        (
            [mantissa(a[0]), mantissa(a[1])],
            [exponent(a[0]), exponent(a[1])],
        )
    }
    #[inline(always)]
    fn prefetch(self, _: &f64) {}
    #[inline(always)]
    fn columns(self, lines: &[&Line]) -> [[f64; 2]; 8] {
        core::array::from_fn(|k| [lines[0].0[k], lines[1].0[k]])
    }
    #[inline(always)]
    fn lines(self, c: [[f64; 2]; 8], lines: &mut [Line]) {
        for (k, c) in c.iter().enumerate() {
            lines[0].0[k] = c[0];
            lines[1].0[k] = c[1];
        }
    }
    #[inline(always)]
    fn add_to_lines(
        self,
        a: [[f64; 2]; 8],
        at_a: &[u32],
        b: [[f64; 2]; 8],
        at_b: &[u32],
        lines: &mut [Line],
    ) {
        for lane in 0..2 {
            for (columns, at) in [(&a, at_a[lane]), (&b, at_b[lane])] {
                for (sum, column) in lines[at as usize].0.iter_mut().zip(columns) {
                    *sum += column[lane];
                }
            }
        }
    }
    #[inline(always)]
    fn load(self, numbers: &[f64]) -> [f64; 2] {
        [numbers[0], numbers[1]]
    }
    #[inline(always)]
    fn store(self, a: [f64; 2], numbers: &mut [f64]) {
        numbers[..2].copy_from_slice(&a);
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> [bool; 2] {
        [bits & 1 != 0, bits & 2 != 0]
    }
}

/// Two registers side by side, so that one of them computes while the other waits.
#[derive(Clone, Copy, Debug)]
pub struct Twice<S>(pub S);

/// The registers of one side.
macro_rules! side {
    ($v:ident, $k:literal) => {
        [
            $v[0][$k], $v[1][$k], $v[2][$k], $v[3][$k], $v[4][$k], $v[5][$k], $v[6][$k], $v[7][$k],
        ]
    };
}
macro_rules! twice {
    ($($name:ident($($arg:ident),*);)*) => {$(
        #[inline(always)]
        fn $name(self, $($arg: Self::Vector),*) -> Self::Vector {
            [self.0.$name($($arg[0]),*), self.0.$name($($arg[1]),*)]
        }
    )*};
}

impl<S: Registers> Registers for Twice<S> {
    const LANES: usize = 2 * S::LANES;
    type Vector = [S::Vector; 2];
    type Mask = [S::Mask; 2];

    #[inline(always)]
    fn splat(self, value: f64) -> Self::Vector {
        [self.0.splat(value); 2]
    }
    twice! {
        add(a, b);
        subtract(a, b);
        multiply(a, b);
        multiply_add(a, b, c);
        multiply_subtract(a, b, c);
        negative_multiply_add(a, b, c);
        reciprocal(a);
        divide(a, b);
        reciprocal_sqrt(a);
        sqrt(a);
        max(a, b);
        min(a, b);
    }
    #[inline(always)]
    fn less(self, a: Self::Vector, b: Self::Vector) -> Self::Mask {
        [self.0.less(a[0], b[0]), self.0.less(a[1], b[1])]
    }
    #[inline(always)]
    fn select(self, mask: Self::Mask, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        [
            self.0.select(mask[0], a[0], b[0]),
            self.0.select(mask[1], a[1], b[1]),
        ]
    }
    #[inline(always)]
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        [self.0.and(a[0], b[0]), self.0.and(a[1], b[1])]
    }
    #[inline(always)]
    fn or(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        [self.0.or(a[0], b[0]), self.0.or(a[1], b[1])]
    }
    #[inline(always)]
    fn and_not(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        [self.0.and_not(a[0], b[0]), self.0.and_not(a[1], b[1])]
    }
    #[inline(always)]
    fn bits(self, mask: Self::Mask) -> u32 {
        self.0.bits(mask[0]) | self.0.bits(mask[1]) << S::LANES
    }
    #[inline(always)]
    fn mantissa_and_exponent(self, a: Self::Vector) -> (Self::Vector, Self::Vector) {
        let (m0, e0) = self.0.mantissa_and_exponent(a[0]);
        let (m1, e1) = self.0.mantissa_and_exponent(a[1]);
        ([m0, m1], [e0, e1])
    }
    #[inline(always)]
    fn prefetch(self, number: &f64) {
        self.0.prefetch(number);
    }
    #[inline(always)]
    fn columns(self, lines: &[&Line]) -> [Self::Vector; 8] {
        let (a, b) = (self.0.columns(lines), self.0.columns(&lines[S::LANES..]));
        [
            [a[0], b[0]],
            [a[1], b[1]],
            [a[2], b[2]],
            [a[3], b[3]],
            [a[4], b[4]],
            [a[5], b[5]],
            [a[6], b[6]],
            [a[7], b[7]],
        ]
    }
    #[inline(always)]
    fn lines(self, c: [Self::Vector; 8], lines: &mut [Line]) {
        self.0.lines(side!(c, 0), lines);
        self.0.lines(side!(c, 1), &mut lines[S::LANES..]);
    }
    #[inline(always)]
    fn add_to_lines(
        self,
        a: [Self::Vector; 8],
        at_a: &[u32],
        b: [Self::Vector; 8],
        at_b: &[u32],
        lines: &mut [Line],
    ) {
        self.0
            .add_to_lines(side!(a, 0), at_a, side!(b, 0), at_b, lines);
        let (at_a, at_b) = (&at_a[S::LANES..], &at_b[S::LANES..]);
        self.0
            .add_to_lines(side!(a, 1), at_a, side!(b, 1), at_b, lines);
    }
    #[inline(always)]
    fn load(self, numbers: &[f64]) -> Self::Vector {
        [self.0.load(numbers), self.0.load(&numbers[S::LANES..])]
    }
    #[inline(always)]
    fn store(self, a: Self::Vector, numbers: &mut [f64]) {
        self.0.store(a[0], numbers);
        self.0.store(a[1], &mut numbers[S::LANES..]);
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> Self::Mask {
        [
            self.0.mask(bits & ((1 << S::LANES) - 1)),
            self.0.mask(bits >> S::LANES),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pairs::instruction_set::{InstructionSet, Stage};
    use crate::pairs::lanes::Lanes;
    use crate::real::Real;

    fn sixteen(numbers: [f64; 8]) -> [f64; MOST_LANES] {
        // The upper eight in another order.
        core::array::from_fn(|k| numbers[if k < 8 { k } else { 3 * k % 8 }])
    }

    /// Everything that a register does, against single numbers.
    struct Check;

    impl Stage for Check {
        fn run<S: Registers>(self, registers: S) {
            let a = sixteen([1.5, 3e-7, 12.25, 7e99, 1.0, 2.0, 1e-120, 0.3]);
            let b = sixteen([-2.0, 4e-7, 12.25, 5e98, 3.0, -7.0, 2e-120, 0.2]);
            let c = sixteen([0.5, -1e-13, 2.0, 1e99, 1e-3, 4.0, 1e-200, 0.1]);
            let [x, y, z] = [&a, &b, &c].map(|numbers| Lanes::load(registers, numbers));
            let check = |what: &str, found: Lanes<S>, expected: &dyn Fn(f64, f64, f64) -> f64| {
                let mut line = [0.0; MOST_LANES];
                found.store(&mut line);
                for k in 0..S::LANES {
                    let wanted = expected(a[k], b[k], c[k]);
                    assert!(
                        (line[k] - wanted).abs() <= 8e-16 * wanted.abs(),
                        "{what}: {} and {wanted}",
                        line[k]
                    );
                }
            };
            check("sum", x + y, &|x, y, _| x + y);
            check("difference", x - z, &|x, _, z| x - z);
            check("product", x * y, &|x, y, _| x * y);
            check("quotient", x / y, &|x, y, _| x / y);
            check("negative", -x, &|x, _, _| -x);
            check("root", x.sqrt(), &|x, _, _| x.sqrt());
            check("root of zero", x.constant(0.0).sqrt(), &|_, _, _| 0.0);
            check("inverse", y.reciprocal(), &|_, y, _| 1.0 / y);
            check("inverse root", x.reciprocal_sqrt(), &|x, _, _| {
                1.0 / x.sqrt()
            });
            check("larger", Real::max(x, y), &|x, y, _| f64::max(x, y));
            check("smaller", Real::min(x, y), &|x, y, _| f64::min(x, y));
            check(
                "number for NaN",
                Real::max(x.constant(f64::NAN), y),
                &|_, y, _| y,
            );
            let not_a_number = Real::max(y, y.constant(f64::NAN));
            assert_eq!(
                registers.bits(not_a_number.less(y.constant(f64::INFINITY))),
                0,
                "NaN for NaN"
            );
            // With or without a rounding in between.
            let tolerant =
                |what: &str, found: Lanes<S>, expected: &dyn Fn(f64, f64, f64) -> (f64, f64)| {
                    let mut line = [0.0; MOST_LANES];
                    found.store(&mut line);
                    for k in 0..S::LANES {
                        let (wanted, scale) = expected(a[k], b[k], c[k]);
                        assert!((line[k] - wanted).abs() <= 4e-16 * scale, "{what}");
                    }
                };
            let size = |x: f64, y: f64, z: f64| (x * y).abs() + z.abs();
            tolerant("x y + z", x.multiply_add(y, z), &|x, y, z| {
                (x * y + z, size(x, y, z))
            });
            tolerant("x y - z", x.multiply_subtract(y, z), &|x, y, z| {
                (x * y - z, size(x, y, z))
            });
            tolerant("z - x y", x.negative_multiply_add(y, z), &|x, y, z| {
                (z - x * y, size(x, y, z))
            });
            let above_one = Real::max(x, x.constant(1.0));
            tolerant("logarithm", above_one.ln(), &|x, _, _| {
                (x.max(1.0).ln(), x.max(1.0).ln().abs() + 1e-300)
            });

            let less = x.less(y);
            check("choice", Lanes::select(less, x, z), &|x, y, z| {
                if x < y {
                    x
                } else {
                    z
                }
            });
            let other = z.less(x);
            let bits = |k: fn(bool, bool) -> bool| {
                (0..S::LANES).fold(0u32, |bits, lane| {
                    let (p, q) = (a[lane] < b[lane], c[lane] < a[lane]);
                    bits | u32::from(k(p, q)) << lane
                })
            };
            assert_eq!(
                registers.bits(registers.and(less, other)),
                bits(|p, q| p & q)
            );
            assert_eq!(
                registers.bits(registers.or(less, other)),
                bits(|p, q| p | q)
            );
            assert_eq!(
                registers.bits(registers.and_not(less, other)),
                bits(|p, q| p & !q)
            );

            let mut lines = [Line::ZERO; MOST_LANES];
            for (k, line) in lines.iter_mut().enumerate() {
                line.0 = core::array::from_fn(|entry| (10 * k + entry) as f64);
            }
            let refs: [&Line; MOST_LANES] = core::array::from_fn(|k| &lines[k]);
            let columns = registers.columns(&refs);
            for (entry, column) in columns.into_iter().enumerate() {
                let mut line = [0.0; MOST_LANES];
                registers.store(column, &mut line);
                for (lane, number) in line[..S::LANES].iter().enumerate() {
                    assert_eq!(*number, (10 * lane + entry) as f64);
                }
            }
            let mut back = [Line::ZERO; MOST_LANES];
            registers.lines(columns, &mut back);
            assert_eq!(back[..S::LANES], lines[..S::LANES]);

            let at_a = [3, 1, 3, 0, 2, 5, 5, 5, 1, 1, 1, 0, 4, 4, 2, 2];
            let at_b = [0, 3, 3, 2, 1, 1, 4, 5, 5, 1, 2, 3, 4, 2, 2, 0];
            let mut sums = [Line([0.5; 8]); 6];
            let mut expected = sums;
            let twice = columns.map(|c| registers.add(c, c));
            registers.add_to_lines(columns, &at_a, twice, &at_b, &mut sums);
            for lane in 0..S::LANES {
                for entry in 0..8 {
                    expected[at_a[lane] as usize].0[entry] += lines[lane].0[entry];
                    expected[at_b[lane] as usize].0[entry] += 2.0 * lines[lane].0[entry];
                }
            }
            assert_eq!(sums, expected);

            for bits in 0..1 << S::LANES {
                assert_eq!(registers.bits(registers.mask(bits)), bits);
            }
            let numbers: Vec<f64> = (0..=MOST_LANES as i32).map(f64::from).collect();
            let mut copy = [-1.0; MOST_LANES + 1];
            registers.store(registers.load(&numbers[1..]), &mut copy[1..]);
            assert_eq!(copy[1..=S::LANES], numbers[1..=S::LANES]);
            assert!(copy[S::LANES + 1..].iter().all(|n| *n == -1.0));
        }
    }

    #[test]
    fn registers_do_what_numbers_do() {
        Check.run(Portable);
        for set in InstructionSet::ALL {
            if set.is_available() {
                set.run(Check);
            }
        }
    }
}
