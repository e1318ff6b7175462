// SPDX-License-Identifier: MIT OR Apache-2.0
//! The number that geometry and force are written in: one `f64`, or several in the lanes of a vector register.
//!
//! The contact law is written once, free of branches, over this trait, so that the scalar path and the vectorised
//! path give the same numbers to rounding because they are the same text.

#[cfg(any(target_arch = "nvptx64", test))]
mod device;

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
    /// Whether a mask holds in any lane; `self` only tells which kind of register.
    fn any(self, mask: Self::Mask) -> bool;
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
    // A fused operation is a library call on a baseline x86-64: two roundings are right here. A device has it.
    #[cfg(not(target_arch = "nvptx64"))]
    #[inline(always)]
    fn multiply_add(self, a: f64, b: f64) -> f64 {
        self * a + b
    }
    #[cfg(not(target_arch = "nvptx64"))]
    #[inline(always)]
    fn multiply_subtract(self, a: f64, b: f64) -> f64 {
        self * a - b
    }
    #[cfg(not(target_arch = "nvptx64"))]
    #[inline(always)]
    fn negative_multiply_add(self, a: f64, b: f64) -> f64 {
        b - self * a
    }
    #[cfg(target_arch = "nvptx64")]
    #[inline(always)]
    fn multiply_add(self, a: f64, b: f64) -> f64 {
        core::f64::math::mul_add(self, a, b)
    }
    #[cfg(target_arch = "nvptx64")]
    #[inline(always)]
    fn multiply_subtract(self, a: f64, b: f64) -> f64 {
        core::f64::math::mul_add(self, a, -b)
    }
    #[cfg(target_arch = "nvptx64")]
    #[inline(always)]
    fn negative_multiply_add(self, a: f64, b: f64) -> f64 {
        core::f64::math::mul_add(-self, a, b)
    }
    #[cfg(not(target_arch = "nvptx64"))]
    #[inline(always)]
    fn reciprocal(self) -> f64 {
        1.0 / self
    }
    #[cfg(not(target_arch = "nvptx64"))]
    #[inline(always)]
    fn reciprocal_sqrt(self) -> f64 {
        1.0 / root(self)
    }
    #[cfg(target_arch = "nvptx64")]
    #[inline(always)]
    fn reciprocal(self) -> f64 {
        device::reciprocal(self)
    }
    #[cfg(target_arch = "nvptx64")]
    #[inline(always)]
    fn reciprocal_sqrt(self) -> f64 {
        device::reciprocal_sqrt(self)
    }
    #[inline(always)]
    fn sqrt(self) -> f64 {
        root(self)
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
    fn any(self, mask: bool) -> bool {
        mask
    }
    #[inline(always)]
    fn ln(self) -> f64 {
        logarithm(self)
    }
    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }
}

/// Square root.
#[inline(always)]
fn root(x: f64) -> f64 {
    #[cfg(feature = "std")]
    return f64::sqrt(x);
    #[cfg(all(not(feature = "std"), target_arch = "nvptx64"))]
    return device::sqrt(x);
    #[cfg(all(not(feature = "std"), not(target_arch = "nvptx64")))]
    return libm::sqrt(x);
}

/// Natural logarithm.
#[inline(always)]
fn logarithm(x: f64) -> f64 {
    #[cfg(feature = "std")]
    return f64::ln(x);
    #[cfg(not(feature = "std"))]
    return libm::log(x);
}

/// Functions of an `f64` that `core` lacks, under the names that they have in `std`. [`Real`] has root and logarithm.
#[cfg(not(feature = "std"))]
pub(crate) trait Functions: Sized {
    fn acos(self) -> Self;
    fn acosh(self) -> Self;
    fn asinh(self) -> Self;
    fn cbrt(self) -> Self;
    fn cos(self) -> Self;
    fn cosh(self) -> Self;
    fn exp(self) -> Self;
    fn exp_m1(self) -> Self;
    fn ln_1p(self) -> Self;
    fn sin(self) -> Self;
    fn sinh(self) -> Self;
    fn tanh(self) -> Self;
    fn atan2(self, other: Self) -> Self;
    fn hypot(self, other: Self) -> Self;
    fn powf(self, exponent: Self) -> Self;
    fn powi(self, exponent: i32) -> Self;
    fn rem_euclid(self, other: Self) -> Self;
    fn sin_cos(self) -> (Self, Self);
}

#[cfg(not(feature = "std"))]
impl Functions for f64 {
    fn acos(self) -> f64 {
        libm::acos(self)
    }
    fn acosh(self) -> f64 {
        libm::acosh(self)
    }
    fn asinh(self) -> f64 {
        libm::asinh(self)
    }
    fn cbrt(self) -> f64 {
        libm::cbrt(self)
    }
    fn cos(self) -> f64 {
        libm::cos(self)
    }
    fn cosh(self) -> f64 {
        libm::cosh(self)
    }
    fn exp(self) -> f64 {
        libm::exp(self)
    }
    fn exp_m1(self) -> f64 {
        libm::expm1(self)
    }
    fn ln_1p(self) -> f64 {
        libm::log1p(self)
    }
    fn sinh(self) -> f64 {
        libm::sinh(self)
    }
    fn sin(self) -> f64 {
        libm::sin(self)
    }
    fn tanh(self) -> f64 {
        libm::tanh(self)
    }
    fn atan2(self, other: f64) -> f64 {
        libm::atan2(self, other)
    }
    fn hypot(self, other: f64) -> f64 {
        libm::hypot(self, other)
    }
    fn powf(self, exponent: f64) -> f64 {
        libm::pow(self, exponent)
    }
    fn powi(self, exponent: i32) -> f64 {
        let mut square = self;
        let mut product = 1.0;
        let mut left = exponent.unsigned_abs();
        while left > 0 {
            if left & 1 != 0 {
                product *= square;
            }
            square *= square;
            left >>= 1;
        }
        if exponent < 0 {
            1.0 / product
        } else {
            product
        }
    }
    fn rem_euclid(self, other: f64) -> f64 {
        let rest = libm::fmod(self, other);
        if rest < 0.0 {
            rest + other.abs()
        } else {
            rest
        }
    }
    fn sin_cos(self) -> (f64, f64) {
        libm::sincos(self)
    }
}
