// SPDX-License-Identifier: MIT OR Apache-2.0
//! SSE2, which every x86-64 has: registers of two numbers.

use super::registers::{
    masks, too_short, two_roundings, vectors, Line, Registers, MANTISSA, ONE, TWO_TO_52,
};

impl Registers for pulp::x86::V1 {
    const LANES: usize = 2;
    type Vector = core::arch::x86_64::__m128d;
    type Mask = core::arch::x86_64::__m128d;
    vectors! {
        add(a, b) = sse2._mm_add_pd(a, b);
        subtract(a, b) = sse2._mm_sub_pd(a, b);
        multiply(a, b) = sse2._mm_mul_pd(a, b);
        divide(a, b) = sse2._mm_div_pd(a, b);
        sqrt(a) = sse2._mm_sqrt_pd(a);
        max(a, b) = sse2._mm_max_pd(a, b);
        min(a, b) = sse2._mm_min_pd(a, b);
    }
    masks! {
        and(a, b) = sse2._mm_and_pd(a, b);
        or(a, b) = sse2._mm_or_pd(a, b);
        and_not(a, b) = sse2._mm_andnot_pd(b, a);
    }

    #[inline(always)]
    fn splat(self, value: f64) -> Self::Vector {
        self.sse2._mm_set1_pd(value)
    }
    two_roundings!();
    #[inline(always)]
    fn reciprocal(self, a: Self::Vector) -> Self::Vector {
        self.sse2._mm_div_pd(self.splat(1.0), a)
    }
    #[inline(always)]
    fn reciprocal_sqrt(self, a: Self::Vector) -> Self::Vector {
        self.reciprocal(self.sse2._mm_sqrt_pd(a))
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
    fn components(self, rows: &[[f64; 3]]) -> [Self::Vector; 3] {
        let Some(rows) = rows.first_chunk::<2>() else {
            too_short()
        };
        let sse2 = self.sse2;
        // x0 y0, z0 x1, y1 z1
        let [a, b, c]: [Self::Vector; 3] = pulp::cast(*rows);
        [
            sse2._mm_shuffle_pd::<0b10>(a, b),
            sse2._mm_shuffle_pd::<0b01>(a, c),
            sse2._mm_shuffle_pd::<0b10>(b, c),
        ]
    }
    #[inline(always)]
    fn put_components(self, [x, y, z]: [Self::Vector; 3], rows: &mut [[f64; 3]]) {
        let Some(rows) = rows.first_chunk_mut::<2>() else {
            too_short()
        };
        let sse2 = self.sse2;
        let lines: [Self::Vector; 3] = [
            sse2._mm_unpacklo_pd(x, y),
            sse2._mm_shuffle_pd::<0b10>(z, x),
            sse2._mm_unpackhi_pd(y, z),
        ];
        *rows = pulp::cast(lines);
    }
    #[inline(always)]
    fn alternate(self, a: Self::Vector, b: Self::Vector) -> [Self::Vector; 2] {
        let sse2 = self.sse2;
        [sse2._mm_unpacklo_pd(a, b), sse2._mm_unpackhi_pd(a, b)]
    }
    #[inline(always)]
    fn in_turns(self, a: Self::Vector, b: Self::Vector) -> [Self::Vector; 2] {
        self.alternate(a, b)
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> Self::Mask {
        let bits = i64::from(bits);
        let all = |bit: i64| -(bit & 1);
        self.sse2
            ._mm_castsi128_pd(self.sse2._mm_set_epi64x(all(bits >> 1), all(bits)))
    }
}
