// SPDX-License-Identifier: MIT OR Apache-2.0
//! AVX2 with fused multiply-add: registers of four numbers.

use super::registers::{masks, too_short, vectors, Line, Registers, MANTISSA, ONE, TWO_TO_52};

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
impl Registers for pulp::x86::V3 {
    const LANES: usize = 4;
    type Vector = core::arch::x86_64::__m256d;
    type Mask = core::arch::x86_64::__m256d;
    vectors! {
        add(a, b) = avx._mm256_add_pd(a, b);
        subtract(a, b) = avx._mm256_sub_pd(a, b);
        multiply(a, b) = avx._mm256_mul_pd(a, b);
        multiply_add(a, b, c) = fma._mm256_fmadd_pd(a, b, c);
        multiply_subtract(a, b, c) = fma._mm256_fmsub_pd(a, b, c);
        negative_multiply_add(a, b, c) = fma._mm256_fnmadd_pd(a, b, c);
        divide(a, b) = avx._mm256_div_pd(a, b);
        sqrt(a) = avx._mm256_sqrt_pd(a);
        max(a, b) = avx._mm256_max_pd(a, b);
        min(a, b) = avx._mm256_min_pd(a, b);
    }
    masks! {
        and(a, b) = avx._mm256_and_pd(a, b);
        or(a, b) = avx._mm256_or_pd(a, b);
        and_not(a, b) = avx._mm256_andnot_pd(b, a);
    }

    #[inline(always)]
    fn splat(self, value: f64) -> Self::Vector {
        self.avx._mm256_set1_pd(value)
    }
    #[inline(always)]
    fn reciprocal(self, a: Self::Vector) -> Self::Vector {
        self.avx._mm256_div_pd(self.splat(1.0), a)
    }
    #[inline(always)]
    fn reciprocal_sqrt(self, a: Self::Vector) -> Self::Vector {
        self.reciprocal(self.avx._mm256_sqrt_pd(a))
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
    fn components(self, rows: &[[f64; 3]]) -> [Self::Vector; 3] {
        let Some(rows) = rows.first_chunk::<4>() else {
            too_short()
        };
        let avx = self.avx;
        // x0 y0 z0 x1, y1 z1 x2 y2, z2 x3 y3 z3
        let [a, b, c]: [Self::Vector; 3] = pulp::cast(*rows);
        let p = avx._mm256_blend_pd::<0b1100>(a, b);
        let q = avx._mm256_permute2f128_pd::<0x21>(a, c);
        let r = avx._mm256_blend_pd::<0b1100>(b, c);
        [
            avx._mm256_shuffle_pd::<0b1010>(p, q),
            avx._mm256_shuffle_pd::<0b0101>(p, r),
            avx._mm256_shuffle_pd::<0b1010>(q, r),
        ]
    }
    #[inline(always)]
    fn put_components(self, [x, y, z]: [Self::Vector; 3], rows: &mut [[f64; 3]]) {
        let Some(rows) = rows.first_chunk_mut::<4>() else {
            too_short()
        };
        let avx = self.avx;
        let p = avx._mm256_unpacklo_pd(x, y);
        let q = avx._mm256_shuffle_pd::<0b1010>(z, x);
        let r = avx._mm256_unpackhi_pd(y, z);
        let lines: [Self::Vector; 3] = [
            avx._mm256_permute2f128_pd::<0x20>(p, q),
            avx._mm256_blend_pd::<0b1100>(r, p),
            avx._mm256_permute2f128_pd::<0x31>(q, r),
        ];
        *rows = pulp::cast(lines);
    }
    #[inline(always)]
    fn alternate(self, a: Self::Vector, b: Self::Vector) -> [Self::Vector; 2] {
        let avx = self.avx;
        let low = avx._mm256_permute2f128_pd::<0x20>(a, b);
        let high = avx._mm256_permute2f128_pd::<0x31>(a, b);
        [
            avx._mm256_unpacklo_pd(low, high),
            avx._mm256_unpackhi_pd(low, high),
        ]
    }
    #[inline(always)]
    fn in_turns(self, a: Self::Vector, b: Self::Vector) -> [Self::Vector; 2] {
        let avx = self.avx;
        let (low, high) = (avx._mm256_unpacklo_pd(a, b), avx._mm256_unpackhi_pd(a, b));
        [
            avx._mm256_permute2f128_pd::<0x20>(low, high),
            avx._mm256_permute2f128_pd::<0x31>(low, high),
        ]
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
