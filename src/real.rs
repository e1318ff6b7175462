// SPDX-License-Identifier: MIT OR Apache-2.0
//! The number that geometry and force are written in: one `f64`, or several in the lanes of a vector register.
//!
//! The contact law is written once, free of branches, over this trait, so that the scalar path and the vectorised
//! path give the same numbers to rounding because they are the same text.

use core::ops::{Add, Div, Mul, Neg, Sub};

/// A real number, or a register of them. Mixed operations with `f64` broadcast the constant.
pub trait Real:
    Copy
    + Add<Self, Output = Self>
    + Add<f64, Output = Self>
    + Sub<Self, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<Self, Output = Self>
    + Mul<f64, Output = Self>
    + Div<Self, Output = Self>
    + Neg<Output = Self>
{
    /// The truth of a comparison, one per lane.
    type Mask: Copy;

    /// `value` in every lane; `self` only tells which kind of register.
    fn constant(self, value: f64) -> Self;
    /// `self * a + b`; fused where the instruction set has it.
    fn multiply_add(self, a: Self, b: Self) -> Self;
    /// `self * a - b`; fused where the instruction set has it.
    fn multiply_subtract(self, a: Self, b: Self) -> Self;
    /// `b - self * a`; fused where the instruction set has it.
    fn negative_multiply_add(self, a: Self, b: Self) -> Self;
    /// `1/self` of a normal number whose inverse is one too.
    fn reciprocal(self) -> Self;
    /// `1/sqrt(self)` of a positive normal number.
    fn reciprocal_sqrt(self) -> Self;
    /// Square root of zero or a positive normal number.
    fn sqrt(self) -> Self;
    /// The larger of two; where `self` is NaN, `other`.
    fn max(self, other: Self) -> Self;
    /// The smaller of two; where `self` is NaN, `other`.
    fn min(self, other: Self) -> Self;
    /// `self < other`.
    fn less(self, other: Self) -> Self::Mask;
    /// `if_true` where the mask holds, else `if_false`.
    fn select(mask: Self::Mask, if_true: Self, if_false: Self) -> Self;
    /// Natural logarithm of a positive, normal number.
    fn ln(self) -> Self;
    /// Absolute value.
    #[inline(always)]
    fn abs(self) -> Self {
        self.max(-self)
    }
}

impl Real for f64 {
    type Mask = bool;

    #[inline(always)]
    fn constant(self, value: f64) -> f64 {
        value
    }
    // A fused operation is a library call on a baseline x86-64: two roundings are right here.
    #[inline(always)]
    fn multiply_add(self, a: f64, b: f64) -> f64 {
        self * a + b
    }
    #[inline(always)]
    fn multiply_subtract(self, a: f64, b: f64) -> f64 {
        self * a - b
    }
    #[inline(always)]
    fn negative_multiply_add(self, a: f64, b: f64) -> f64 {
        b - self * a
    }
    #[inline(always)]
    fn reciprocal(self) -> f64 {
        1.0 / self
    }
    #[inline(always)]
    fn reciprocal_sqrt(self) -> f64 {
        1.0 / f64::sqrt(self)
    }
    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn max(self, other: f64) -> f64 {
        if self > other {
            self
        } else {
            other
        }
    }
    #[inline(always)]
    fn min(self, other: f64) -> f64 {
        if self < other {
            self
        } else {
            other
        }
    }
    #[inline(always)]
    fn less(self, other: f64) -> bool {
        self < other
    }
    #[inline(always)]
    fn select(mask: bool, if_true: f64, if_false: f64) -> f64 {
        if mask {
            if_true
        } else {
            if_false
        }
    }
    #[inline(always)]
    fn ln(self) -> f64 {
        f64::ln(self)
    }
    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }
}
