// SPDX-License-Identifier: MIT OR Apache-2.0
//! Reciprocals and roots of an `f64` on a GPU of NVIDIA, to a unit in the last place, of normal numbers.
//!
//! The compiler's own are rounded right for every number there is: each is some twenty instructions and a call for the rare cases, and
//! a reciprocal root is two of them. Here the machine's approximation, of 20 bits at least (PTX ISA 8.7, sections 9.7.3.13 and 9.7.3.20),
//! is refined with fused operations.

#[cfg(target_arch = "nvptx64")]
fn fused(a: f64, b: f64, c: f64) -> f64 {
    core::f64::math::mul_add(a, b, c)
}
#[cfg(not(target_arch = "nvptx64"))]
fn fused(a: f64, b: f64, c: f64) -> f64 {
    f64::mul_add(a, b, c)
}

/// `1/x` from an approximation: Newton's method twice, the second time with the square of the first error.
#[inline(always)]
fn refined_reciprocal(x: f64, near: f64) -> f64 {
    let error = fused(-x, near, 1.0);
    let nearer = fused(near, fused(error, error, error), near);
    fused(nearer, fused(-x, nearer, 1.0), nearer)
}

/// `1/sqrt(x)` from an approximation: Halley's method, whose error is of third order in that of the approximation.
#[inline(always)]
fn refined_reciprocal_sqrt(x: f64, near: f64) -> f64 {
    let error = fused(-(x * near), near, 1.0);
    fused(fused(0.375, error, 0.5), error * near, near)
}

/// `sqrt(x)` from `1/sqrt(x)`: a step of Newton's method takes its rounding away. Of zero, zero.
#[inline(always)]
fn root_from_reciprocal(x: f64, reciprocal: f64) -> f64 {
    let near = x * reciprocal;
    let root = fused(0.5 * reciprocal, fused(-near, near, x), near);
    if x == 0.0 {
        x
    } else {
        root
    }
}

// The one `unsafe` of the library outside its C interface.
#[cfg(target_arch = "nvptx64")]
#[allow(unsafe_code)]
mod instructions {
    unsafe extern "C" {
        #[link_name = "llvm.nvvm.rcp.approx.ftz.d"]
        fn rcp_approx(x: f64) -> f64;
        #[link_name = "llvm.nvvm.rsqrt.approx.d"]
        fn rsqrt_approx(x: f64) -> f64;
    }

    #[inline(always)]
    pub fn near_reciprocal(x: f64) -> f64 {
        // SAFETY: one instruction from a register to a register, which every device of the target has.
        unsafe { rcp_approx(x) }
    }

    #[inline(always)]
    pub fn near_reciprocal_sqrt(x: f64) -> f64 {
        // SAFETY: as above.
        unsafe { rsqrt_approx(x) }
    }
}

/// `1/x` of a normal number whose inverse is one too.
#[cfg(target_arch = "nvptx64")]
#[inline(always)]
pub fn reciprocal(x: f64) -> f64 {
    refined_reciprocal(x, instructions::near_reciprocal(x))
}

/// `1/sqrt(x)` of a positive normal number.
#[cfg(target_arch = "nvptx64")]
#[inline(always)]
pub fn reciprocal_sqrt(x: f64) -> f64 {
    refined_reciprocal_sqrt(x, instructions::near_reciprocal_sqrt(x))
}

/// `sqrt(x)` of zero or a positive normal number.
#[cfg(target_arch = "nvptx64")]
#[inline(always)]
pub fn sqrt(x: f64) -> f64 {
    root_from_reciprocal(x, reciprocal_sqrt(x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// As wrong as the machine's approximations may be: 20 bits are right.
    fn off() -> impl Strategy<Value = f64> {
        -1.0 / (1 << 20) as f64..1.0 / (1 << 20) as f64
    }

    /// Units in the last place between two numbers.
    fn units(a: f64, b: f64) -> u64 {
        a.to_bits().abs_diff(b.to_bits())
    }

    proptest! {
        #[test]
        fn reciprocals(mantissa in 1.0..2.0f64, exponent in -1000..1000i32, off in off()) {
            let x = mantissa * 2f64.powi(exponent);
            let near = (1.0 + off) / x;
            for x in [x, -x] {
                prop_assert!(units(refined_reciprocal(x, near * x.signum()), 1.0 / x) <= 1);
            }
        }

        #[test]
        fn roots(mantissa in 1.0..4.0f64, exponent in -500..500i32, off in off()) {
            let x = mantissa * 4f64.powi(exponent);
            let reciprocal = refined_reciprocal_sqrt(x, (1.0 + off) / x.sqrt());
            // Of the exact one: its square times x is 1, of which `fused` knows the rest.
            let error = fused(reciprocal * x, reciprocal, -1.0).abs();
            prop_assert!(error < 4.0 * f64::EPSILON, "{x:e}: {error:e}");
            prop_assert!(units(root_from_reciprocal(x, reciprocal), x.sqrt()) <= 1);
        }
    }

    #[test]
    fn a_root_of_zero() {
        assert_eq!(root_from_reciprocal(0.0, f64::INFINITY), 0.0);
        assert!(root_from_reciprocal(-1.0, f64::NAN).is_nan());
    }
}
