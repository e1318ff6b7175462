// SPDX-License-Identifier: MIT OR Apache-2.0
//! NEON, which every AArch64 has: registers of two numbers.

use super::registers::{masks, too_short, vectors, Line, Registers, MANTISSA, ONE};

impl Registers for pulp::aarch64::Neon {
    const LANES: usize = 2;
    type Vector = core::arch::aarch64::float64x2_t;
    type Mask = core::arch::aarch64::uint64x2_t;
    vectors! {
        add(a, b) = neon.vaddq_f64(a, b);
        subtract(a, b) = neon.vsubq_f64(a, b);
        multiply(a, b) = neon.vmulq_f64(a, b);
        // The addend comes first here.
        multiply_add(a, b, c) = neon.vfmaq_f64(c, a, b);
        negative_multiply_add(a, b, c) = neon.vfmsq_f64(c, a, b);
        divide(a, b) = neon.vdivq_f64(a, b);
        sqrt(a) = neon.vsqrtq_f64(a);
    }
    masks! {
        and(a, b) = neon.vandq_u64(a, b);
        or(a, b) = neon.vorrq_u64(a, b);
        and_not(a, b) = neon.vbicq_u64(a, b);
    }

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
    fn multiply_subtract(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
        self.neon.vfmaq_f64(self.neon.vnegq_f64(c), a, b)
    }
    #[inline(always)]
    fn reciprocal(self, a: Self::Vector) -> Self::Vector {
        self.neon.vdivq_f64(self.splat(1.0), a)
    }
    #[inline(always)]
    fn reciprocal_sqrt(self, a: Self::Vector) -> Self::Vector {
        self.reciprocal(self.neon.vsqrtq_f64(a))
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
