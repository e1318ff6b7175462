// SPDX-License-Identifier: MIT OR Apache-2.0
//! One number as a register: the search in lanes, for a machine whose threads are the lanes.

use ellgran::real::Real;
use ellgran::simd::{Lanes, Line, Registers};
use ellgran::vector::{Symmetric2, Tangent, Vector2, Vector3};

/// A register of one number, with the operations that [`f64`] has as [`Real`].
#[derive(Clone, Copy, Debug)]
pub struct OneLane;

/// A number in it.
pub type Number = Lanes<OneLane>;

/// Puts a number, and vectors and matrices of numbers, into the lane.
#[inline(always)]
pub fn number(x: f64) -> Number {
    Lanes::new(OneLane, x)
}

/// The same of a vector.
#[inline(always)]
pub fn vector(v: Vector3) -> Vector3<Number> {
    Vector3::new(number(v.x), number(v.y), number(v.z))
}

/// Takes a vector out of the lane.
#[inline(always)]
pub fn vector_of(v: Vector3<Number>) -> Vector3 {
    Vector3::new(v.x.value, v.y.value, v.z.value)
}

/// The same of components in a tangent basis.
#[inline(always)]
pub fn tangential_of(v: Vector2<Number>) -> Vector2 {
    Vector2::new(v.u.value, v.v.value)
}

/// The same of a matrix.
#[inline(always)]
pub fn matrix_of(m: Symmetric2<Number>) -> Symmetric2 {
    Symmetric2::new(m.uu.value, m.uv.value, m.vv.value)
}

/// The same of a basis.
#[inline(always)]
pub fn basis_of(t: Tangent<Number>) -> Tangent {
    Tangent {
        u: vector_of(t.u),
        v: vector_of(t.v),
    }
}

impl Registers for OneLane {
    const LANES: usize = 1;
    type Vector = f64;
    type Mask = bool;

    #[inline(always)]
    fn splat(self, value: f64) -> f64 {
        value
    }
    #[inline(always)]
    fn load(self, numbers: &[f64]) -> f64 {
        numbers[0]
    }
    #[inline(always)]
    fn store(self, a: f64, numbers: &mut [f64]) {
        numbers[0] = a;
    }
    #[inline(always)]
    fn add(self, a: f64, b: f64) -> f64 {
        a + b
    }
    #[inline(always)]
    fn subtract(self, a: f64, b: f64) -> f64 {
        a - b
    }
    #[inline(always)]
    fn multiply(self, a: f64, b: f64) -> f64 {
        a * b
    }
    #[inline(always)]
    fn multiply_add(self, a: f64, b: f64, c: f64) -> f64 {
        Real::multiply_add(a, b, c)
    }
    #[inline(always)]
    fn multiply_subtract(self, a: f64, b: f64, c: f64) -> f64 {
        Real::multiply_subtract(a, b, c)
    }
    #[inline(always)]
    fn negative_multiply_add(self, a: f64, b: f64, c: f64) -> f64 {
        Real::negative_multiply_add(a, b, c)
    }
    #[inline(always)]
    fn reciprocal(self, a: f64) -> f64 {
        Real::reciprocal(a)
    }
    #[inline(always)]
    fn divide(self, a: f64, b: f64) -> f64 {
        a / b
    }
    #[inline(always)]
    fn reciprocal_sqrt(self, a: f64) -> f64 {
        Real::reciprocal_sqrt(a)
    }
    #[inline(always)]
    fn sqrt(self, a: f64) -> f64 {
        Real::sqrt(a)
    }
    #[inline(always)]
    fn max(self, a: f64, b: f64) -> f64 {
        Real::max(a, b)
    }
    #[inline(always)]
    fn min(self, a: f64, b: f64) -> f64 {
        Real::min(a, b)
    }
    #[inline(always)]
    fn less(self, a: f64, b: f64) -> bool {
        a < b
    }
    #[inline(always)]
    fn select(self, mask: bool, a: f64, b: f64) -> f64 {
        Real::select(mask, a, b)
    }
    #[inline(always)]
    fn and(self, a: bool, b: bool) -> bool {
        a & b
    }
    #[inline(always)]
    fn or(self, a: bool, b: bool) -> bool {
        a | b
    }
    #[inline(always)]
    fn and_not(self, a: bool, b: bool) -> bool {
        a & !b
    }
    #[inline(always)]
    fn bits(self, mask: bool) -> u32 {
        u32::from(mask)
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> bool {
        bits & 1 != 0
    }
    #[inline(always)]
    fn mantissa_and_exponent(self, a: f64) -> (f64, f64) {
        const MANTISSA: u64 = (1 << (f64::MANTISSA_DIGITS - 1)) - 1;
        let bits = a.to_bits();
        let exponent = (bits >> (f64::MANTISSA_DIGITS - 1)) as i32 - (f64::MAX_EXP - 1);
        let mantissa = f64::from_bits(bits & MANTISSA | 1f64.to_bits());
        (mantissa, f64::from(exponent))
    }
    #[inline(always)]
    fn prefetch(self, _: &f64) {}
    #[inline(always)]
    fn columns(self, lines: &[&Line]) -> [f64; 8] {
        lines[0].0
    }
    #[inline(always)]
    fn lines(self, columns: [f64; 8], lines: &mut [Line]) {
        lines[0].0 = columns;
    }
    #[inline(always)]
    fn add_to_lines(
        self,
        a: [f64; 8],
        at_a: &[u32],
        b: [f64; 8],
        at_b: &[u32],
        lines: &mut [Line],
    ) {
        for (numbers, at) in [(a, at_a[0]), (b, at_b[0])] {
            for (sum, number) in lines[at as usize].0.iter_mut().zip(numbers) {
                *sum += number;
            }
        }
    }
}
