// SPDX-License-Identifier: MIT OR Apache-2.0
//! Two lanes as the compiler makes them, on any machine.

use super::registers::{two_roundings, Line, Registers, MANTISSA, ONE};
use crate::real::Real;

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
        [Real::max(a[0], b[0]), Real::max(a[1], b[1])]
    }
    #[inline(always)]
    fn min(self, a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
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
