// SPDX-License-Identifier: MIT OR Apache-2.0
//! One number of single precision as a register: the search in lanes, for a GPU that is slow with doubles.
//!
//! Lengths are in units of the pair: semi-axes may be as small as 1e-20, and the sixth power of that is none of these numbers.

use crate::one_lane::Number;
use ellgran::simd::{Lanes, Line, Registers};
use ellgran::vector::{Symmetric2, Vector2, Vector3};

/// A register of one number of single precision.
#[derive(Clone, Copy, Debug)]
pub struct OneSingle;

/// A number in it.
pub type Single = Lanes<OneSingle>;

/// Rounds a number that is in the range of these.
#[inline(always)]
pub fn single(x: f64) -> Single {
    Lanes::new(OneSingle, x as f32)
}

/// The same of a vector.
#[inline(always)]
pub fn single_vector(v: Vector3) -> Vector3<Single> {
    Vector3::new(single(v.x), single(v.y), single(v.z))
}

/// The number itself.
#[inline(always)]
pub fn double(x: Single) -> Number {
    crate::one_lane::number(f64::from(x.value))
}

/// The same of a vector.
#[inline(always)]
pub fn double_vector(v: Vector3<Single>) -> Vector3<Number> {
    Vector3::new(double(v.x), double(v.y), double(v.z))
}

/// The same of components in a tangent basis.
#[inline(always)]
pub fn double_tangential(v: Vector2<Single>) -> Vector2<Number> {
    Vector2::new(double(v.u), double(v.v))
}

/// The same of a matrix.
#[inline(always)]
pub fn double_matrix(m: Symmetric2<Single>) -> Symmetric2<Number> {
    Symmetric2::new(double(m.uu), double(m.uv), double(m.vv))
}

/// A unit of length of a pair: a power of two, by which no number is rounded.
#[derive(Clone, Copy)]
pub struct Unit {
    /// The unit.
    pub length: Single,
    /// Its inverse.
    pub inverse: Single,
}

impl Unit {
    /// The least that is greater than the sum of two radii, which are within the range of semi-axes.
    #[inline(always)]
    pub fn of(reach: f64) -> Unit {
        let exponent = (reach.to_bits() >> (f64::MANTISSA_DIGITS - 1)) as i32 - (f64::MAX_EXP - 1);
        let power = |e: i32| {
            let bits = (e + f32::MAX_EXP - 1) << (f32::MANTISSA_DIGITS - 1);
            Lanes::new(OneSingle, f32::from_bits(bits as u32))
        };
        Unit {
            length: power(exponent + 1),
            inverse: power(-(exponent + 1)),
        }
    }
}

/// `a * b + c`.
#[inline(always)]
fn fused(a: f32, b: f32, c: f32) -> f32 {
    #[cfg(target_arch = "nvptx64")]
    return core::f32::math::mul_add(a, b, c);
    #[cfg(not(target_arch = "nvptx64"))]
    return a * b + c;
}

/// Square root. That of a double, rounded, is the same.
#[inline(always)]
fn root(a: f32) -> f32 {
    #[cfg(target_arch = "nvptx64")]
    return core::f32::math::sqrt(a);
    #[cfg(not(target_arch = "nvptx64"))]
    return ellgran::real::Real::sqrt(f64::from(a)) as f32;
}

impl Registers for OneSingle {
    const LANES: usize = 1;
    const DIGITS: u32 = f32::MANTISSA_DIGITS;
    type Vector = f32;
    type Mask = bool;

    /// A constant that is smaller than all of these numbers, or greater, is the one of them that is closest, and not zero.
    #[inline(always)]
    fn splat(self, value: f64) -> f32 {
        let size = value.abs();
        if size > f64::from(f32::MAX) && size < f64::INFINITY {
            f32::MAX.copysign(value as f32)
        } else if size > 0.0 && size < f64::from(f32::MIN_POSITIVE) {
            f32::MIN_POSITIVE.copysign(value as f32)
        } else {
            value as f32
        }
    }
    #[inline(always)]
    fn load(self, numbers: &[f64]) -> f32 {
        numbers[0] as f32
    }
    #[inline(always)]
    fn store(self, a: f32, numbers: &mut [f64]) {
        numbers[0] = f64::from(a);
    }
    #[inline(always)]
    fn add(self, a: f32, b: f32) -> f32 {
        a + b
    }
    #[inline(always)]
    fn subtract(self, a: f32, b: f32) -> f32 {
        a - b
    }
    #[inline(always)]
    fn multiply(self, a: f32, b: f32) -> f32 {
        a * b
    }
    #[inline(always)]
    fn multiply_add(self, a: f32, b: f32, c: f32) -> f32 {
        fused(a, b, c)
    }
    #[inline(always)]
    fn multiply_subtract(self, a: f32, b: f32, c: f32) -> f32 {
        fused(a, b, -c)
    }
    #[inline(always)]
    fn negative_multiply_add(self, a: f32, b: f32, c: f32) -> f32 {
        fused(-a, b, c)
    }
    #[inline(always)]
    fn reciprocal(self, a: f32) -> f32 {
        1.0 / a
    }
    #[inline(always)]
    fn divide(self, a: f32, b: f32) -> f32 {
        a / b
    }
    #[inline(always)]
    fn reciprocal_sqrt(self, a: f32) -> f32 {
        1.0 / root(a)
    }
    #[inline(always)]
    fn sqrt(self, a: f32) -> f32 {
        root(a)
    }
    #[inline(always)]
    fn max(self, a: f32, b: f32) -> f32 {
        if a > b {
            a
        } else {
            b
        }
    }
    #[inline(always)]
    fn min(self, a: f32, b: f32) -> f32 {
        if a < b {
            a
        } else {
            b
        }
    }
    #[inline(always)]
    fn less(self, a: f32, b: f32) -> bool {
        a < b
    }
    #[inline(always)]
    fn select(self, mask: bool, a: f32, b: f32) -> f32 {
        if mask {
            a
        } else {
            b
        }
    }
    #[inline(always)]
    fn mantissa_and_exponent(self, a: f32) -> (f32, f32) {
        const MANTISSA: u32 = (1 << (f32::MANTISSA_DIGITS - 1)) - 1;
        let bits = a.to_bits();
        let exponent = (bits >> (f32::MANTISSA_DIGITS - 1)) as i32 - (f32::MAX_EXP - 1);
        let mantissa = f32::from_bits(bits & MANTISSA | 1f32.to_bits());
        (mantissa, exponent as f32)
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
    fn prefetch(self, _: &f64) {}
    #[inline(always)]
    fn columns(self, lines: &[&Line]) -> [f32; 8] {
        lines[0].0.map(|x| x as f32)
    }
    #[inline(always)]
    fn lines(self, columns: [f32; 8], lines: &mut [Line]) {
        lines[0].0 = columns.map(f64::from);
    }
    #[inline(always)]
    fn add_to_lines(
        self,
        a: [f32; 8],
        at_a: &[u32],
        b: [f32; 8],
        at_b: &[u32],
        lines: &mut [Line],
    ) {
        for (numbers, at) in [(a, at_a[0]), (b, at_b[0])] {
            for (sum, number) in lines[at as usize].0.iter_mut().zip(numbers) {
                *sum += f64::from(number);
            }
        }
    }
}
