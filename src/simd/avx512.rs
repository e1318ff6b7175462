// SPDX-License-Identifier: MIT OR Apache-2.0
//! AVX-512: registers of eight numbers. Nothing later than what the first machines with it have (Skylake-X): F, and for
//! `pulp` also CD, VL, DQ and BW.

use super::registers::{too_short, vectors, Line, Registers};

/// Rows of eight columns.
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

/// Numbers of two registers, by their places: those of the second from 8 on.
macro_rules! picked {
    ($set:expr, $a:expr, $b:expr, $places:expr) => {{
        let places: [i64; 8] = $places;
        $set.avx512f
            ._mm512_permutex2var_pd($a, pulp::cast(places), $b)
    }};
}

/// Numbers of three registers: first of the first two, then of the result and the third.
macro_rules! two_of_three {
    ($set:expr, ($a:expr, $b:expr, $c:expr), $first:expr, $then:expr) => {{
        let both = picked!($set, $a, $b, $first);
        picked!($set, both, $c, $then)
    }};
}

impl Registers for pulp::x86::V4 {
    const LANES: usize = 8;
    type Vector = core::arch::x86_64::__m512d;
    type Mask = u8;
    vectors! {
        add(a, b) = avx512f._mm512_add_pd(a, b);
        subtract(a, b) = avx512f._mm512_sub_pd(a, b);
        multiply(a, b) = avx512f._mm512_mul_pd(a, b);
        multiply_add(a, b, c) = avx512f._mm512_fmadd_pd(a, b, c);
        multiply_subtract(a, b, c) = avx512f._mm512_fmsub_pd(a, b, c);
        negative_multiply_add(a, b, c) = avx512f._mm512_fnmadd_pd(a, b, c);
        max(a, b) = avx512f._mm512_max_pd(a, b);
        min(a, b) = avx512f._mm512_min_pd(a, b);
    }

    #[inline(always)]
    fn splat(self, value: f64) -> Self::Vector {
        self.avx512f._mm512_set1_pd(value)
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
    fn column_differences(self, lines: &[&Line], others: &[&Line]) -> [Self::Vector; 8] {
        macro_rules! row {
            ($k:literal) => {
                self.subtract(pulp::cast(lines[$k].0), pulp::cast(others[$k].0))
            };
        }
        let rows = [
            row!(0),
            row!(1),
            row!(2),
            row!(3),
            row!(4),
            row!(5),
            row!(6),
            row!(7),
        ];
        let (c0, c1, c2, c3, c4, c5, c6, c7) = transposed_eight!(self.avx512f, rows);
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
    fn components(self, rows: &[[f64; 3]]) -> [Self::Vector; 3] {
        let Some(rows) = rows.first_chunk::<8>() else {
            too_short()
        };
        let [a, b, c]: [Self::Vector; 3] = pulp::cast(*rows);
        [
            two_of_three!(
                self,
                (a, b, c),
                [0, 3, 6, 9, 12, 15, 0, 0],
                [0, 1, 2, 3, 4, 5, 10, 13]
            ),
            two_of_three!(
                self,
                (a, b, c),
                [1, 4, 7, 10, 13, 0, 0, 0],
                [0, 1, 2, 3, 4, 8, 11, 14]
            ),
            two_of_three!(
                self,
                (a, b, c),
                [2, 5, 8, 11, 14, 0, 0, 0],
                [0, 1, 2, 3, 4, 9, 12, 15]
            ),
        ]
    }
    #[inline(always)]
    fn put_components(self, [x, y, z]: [Self::Vector; 3], rows: &mut [[f64; 3]]) {
        let Some(rows) = rows.first_chunk_mut::<8>() else {
            too_short()
        };
        let lines: [Self::Vector; 3] = [
            two_of_three!(
                self,
                (x, y, z),
                [0, 8, 0, 1, 9, 0, 2, 10],
                [0, 1, 8, 3, 4, 9, 6, 7]
            ),
            two_of_three!(
                self,
                (x, y, z),
                [0, 3, 11, 0, 4, 12, 0, 5],
                [10, 1, 2, 11, 4, 5, 12, 7]
            ),
            two_of_three!(
                self,
                (x, y, z),
                [13, 0, 6, 14, 0, 7, 15, 0],
                [0, 13, 2, 3, 14, 5, 6, 15]
            ),
        ];
        *rows = pulp::cast(lines);
    }
    #[inline(always)]
    fn alternate(self, a: Self::Vector, b: Self::Vector) -> [Self::Vector; 2] {
        [
            picked!(self, a, b, [0, 2, 4, 6, 8, 10, 12, 14]),
            picked!(self, a, b, [1, 3, 5, 7, 9, 11, 13, 15]),
        ]
    }
    #[inline(always)]
    fn in_turns(self, a: Self::Vector, b: Self::Vector) -> [Self::Vector; 2] {
        [
            picked!(self, a, b, [0, 8, 1, 9, 2, 10, 3, 11]),
            picked!(self, a, b, [4, 12, 5, 13, 6, 14, 7, 15]),
        ]
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> u8 {
        bits as u8
    }
}
