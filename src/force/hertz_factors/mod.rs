// SPDX-License-Identifier: MIT OR Apache-2.0
//! Hertz factors of an elliptical contact: `F1`, `F2`, the axis ratio, and the anisotropy of the tangential compliance.
//!
//! The natural variable of the fitted functions is `w = ln((A+B)^2/(4AB))`; up to B/A = 10 a variable without a logarithm
//! takes half as long. See `fit_coefficients.rs` and its generator `validation/hertz_factors/fit.py`. Precision: 1e-15
//! relative up to B/A = 10, 1e-14 to 6.5e5 (sigma 1e-12), 1e-13 by iteration beyond (checked to B/A = 1e8).
//!
//! # Example
//! ```
//! use ellgran::force::elliptic_integrals::{carlson_rd, ellipse_integrals};
//! use ellgran::force::hertz_factors::{contact_ellipse, exact, fit_variable, fitted, fitted_near, hale, hale_f1, near_variable};
//!
//! // Relative curvatures A = 1/m and B = 4/m: the fit, and its shorter form up to B/A = 10, against the iteration.
//! let (trace, determinant) = (5.0, 4.0);
//! let ellipse = contact_ellipse(4.0);
//! let phi = ellipse.f2.powf(-1.5);
//! let factors = exact(trace, determinant, true);
//! assert!((factors.phi / phi - 1.0).abs() < 1e-12);
//! let whole = fitted(fit_variable(trace, determinant), true);
//! let near = fitted_near(near_variable(trace, determinant), true);
//! assert!((whole.phi / phi - 1.0).abs() < 1e-12 && (near.phi / phi - 1.0).abs() < 1e-12);
//! // Hale's closed form is off by less than a per cent here.
//! let published = hale(trace, determinant, false).expect("B/A is below 25178");
//! assert!((published.phi / phi - 1.0).abs() < 1e-2);
//! assert!((hale_f1(4.0) / ellipse.f1 - 1.0).abs() < 2e-2);
//!
//! // The integrals of the ellipse of axis ratio k give the ratio back: B/A = Bl/(D k^2).
//! let k = ellipse.axis_ratio;
//! let integrals = ellipse_integrals(k);
//! assert!((integrals.d - carlson_rd(0.0, k * k, 1.0) / 3.0).abs() < 1e-15);
//! assert!((integrals.k - integrals.d - integrals.bl).abs() < 1e-14);
//! assert!((integrals.bl / (integrals.d * k * k) - 4.0).abs() < 1e-12);
//! ```

mod fit_coefficients;

use super::elliptic_integrals::{ellipse_integrals, EllipseIntegrals};
#[cfg(not(feature = "std"))]
use crate::real::Functions;
use crate::real::Real;
use fit_coefficients::{NEAR_PHI, NEAR_SIGMA, PHI, Q_MAX, SIGMA, W_MAX};

/// Where the fit near a circle ends, in [`near_variable`]: B/A = 10.
#[doc(hidden)]
pub const NEAR_END: f64 = Q_MAX;

/// Where the fit ends, in [`fit_variable`]: B/A = 6.5e5.
#[doc(hidden)]
pub const FIT_END: f64 = W_MAX;

/// What the force needs at one relative curvature.
#[derive(Clone, Copy, Debug)]
pub struct Factors<T = f64> {
    /// `F2^(-3/2)`, the factor in Hertz' force; 1 for a circle.
    pub phi: T,
    /// `(1/2 - Bl/K) (A+B)/(B-A)`, 1/6 for a circle: the anisotropy of the tangential compliance, and twice
    /// `d ln(phi)/dw`.
    ///
    /// The two are one function because the energy is a minimum over pressures, so that only its explicit dependence on
    /// the curvatures counts: `dU/dA = -F a^2/5`, that is `d ln(U)/d ln(A) = -D/(2K)` and `d ln(U)/d ln(B) = -Bl/(2K)`.
    pub sigma: T,
}

/// The variable of the fit from trace and determinant of the relative curvature matrix: 0 for a circle.
#[inline(always)]
pub fn fit_variable<T: Real>(trace: T, determinant: T) -> T {
    // Rounding may put 4 det a little above trace^2.
    let zero = trace.constant(0.0);
    (trace * trace * (determinant.reciprocal() * 0.25))
        .ln()
        .max(zero)
}

/// The variable of the fit near a circle: `((sqrt(B) - sqrt(A))/(sqrt(B) + sqrt(A)))^2`, 0 for a circle.
#[inline(always)]
pub fn near_variable<T: Real>(trace: T, determinant: T) -> T {
    let twice = determinant.sqrt() * 2.0;
    (trace - twice) * (trace + twice).reciprocal()
}

/// The fitted factors for B/A up to 10, in lanes. `sigma` only where it is asked for.
#[inline(always)]
pub fn fitted_near<T: Real>(q: T, with_sigma: bool) -> Factors<T> {
    let (phi, sigma) = if with_sigma {
        polynomials(&NEAR_PHI, &NEAR_SIGMA, q)
    } else {
        (polynomials(&NEAR_PHI, &NEAR_PHI, q).0, q.constant(0.0))
    };
    Factors { phi, sigma }
}

/// The fitted factors for `0 <= w <= 12`, in lanes; beyond, the value at the end (the caller tests `w`). `sigma` only where
/// it is asked for.
#[inline(always)]
pub fn fitted<T: Real>(w: T, with_sigma: bool) -> Factors<T> {
    let x = w.min(w.constant(W_MAX)) * (2.0 / W_MAX) - 1.0;
    let (phi, sigma) = if with_sigma {
        polynomials(&PHI, &SIGMA, x)
    } else {
        (polynomials(&PHI, &PHI, x).0, x.constant(0.0))
    };
    Factors { phi, sigma }
}

/// Two polynomials at once, even and odd powers apart: four chains of half the length, none of which waits for another.
#[inline(always)]
fn polynomials<T: Real, const N: usize>(p: &[f64; N], q: &[f64; N], x: T) -> (T, T) {
    let square = x * x;
    let last = N - 1 - N % 2;
    let (mut p_odd, mut q_odd) = (x.constant(p[last]), x.constant(q[last]));
    let (mut p_even, mut q_even) = if N % 2 == 1 {
        (x.constant(p[N - 1]), x.constant(q[N - 1]))
    } else {
        (x.constant(0.0), x.constant(0.0))
    };
    let mut k = last;
    // Not an iterator and not an array of sums: these would go through memory.
    while k > 1 {
        k -= 2;
        p_odd = p_odd.multiply_add(square, x.constant(p[k]));
        q_odd = q_odd.multiply_add(square, x.constant(q[k]));
        p_even = p_even.multiply_add(square, x.constant(p[k + 1]));
        q_even = q_even.multiply_add(square, x.constant(q[k + 1]));
    }
    p_even = p_even.multiply_add(square, x.constant(p[0]));
    q_even = q_even.multiply_add(square, x.constant(q[0]));
    (p_odd.multiply_add(x, p_even), q_odd.multiply_add(x, q_even))
}

/// The factors for any curvature, one contact: the fit, and iteration beyond it.
#[inline(always)]
pub fn exact(trace: f64, determinant: f64, with_sigma: bool) -> Factors {
    let q = near_variable(trace, determinant);
    if q <= Q_MAX {
        return fitted_near(q, with_sigma);
    }
    let w = fit_variable(trace, determinant);
    if w <= W_MAX {
        fitted(w, with_sigma)
    } else {
        beyond_fit(w)
    }
}

/// Curvature ratio `ln(B/A)` from the fit's variable.
fn log_ratio(w: f64) -> f64 {
    2.0 * (0.5 * w).exp().acosh()
}

#[cold]
fn beyond_fit(w: f64) -> Factors {
    let l = log_ratio(w);
    let (shape, integrals) = iterate(l);
    Factors {
        phi: shape.f2.powf(-1.5),
        sigma: (integrals.d - integrals.bl) / (2.0 * integrals.k) / (0.5 * l).tanh(),
    }
}

/// The contact ellipse's shape and the two Hertz factors.
#[derive(Clone, Copy, Debug)]
pub struct ContactEllipse {
    /// Axis ratio `b/a <= 1`.
    pub axis_ratio: f64,
    /// `F1`: `a b = Re delta F1^2 / F2`.
    pub f1: f64,
    /// `F2`: `F = 4/3 E* sqrt(Re) delta^(3/2) F2^(-3/2)`.
    pub f2: f64,
}

/// Exact `b/a`, `F1`, `F2` for a ratio `B/A >= 1` by Newton in `ln(b/a)` (Johnson, Contact Mechanics, 4.2, in
/// Carlson's form): relative error below 1e-13 for `B/A` from 1 to 1e8. A ratio below 1 is taken as 1.
///
/// # Example
/// A circle has `F1 = F2 = 1`, and an ellipse is the longer the more the curvatures differ:
/// ```
/// use ellgran::force::hertz_factors::contact_ellipse;
///
/// let circle = contact_ellipse(1.0);
/// assert!((circle.f1 - 1.0).abs() < 1e-13 && (circle.f2 - 1.0).abs() < 1e-13);
/// let ellipse = contact_ellipse(25.0);
/// // Near (A/B)^(2/3) = 0.117.
/// assert!(ellipse.axis_ratio > 0.117 && ellipse.axis_ratio < 0.15);
/// ```
pub fn contact_ellipse(ratio: f64) -> ContactEllipse {
    iterate(ratio.max(1.0).ln()).0
}

fn iterate(l: f64) -> (ContactEllipse, EllipseIntegrals) {
    // Near a circle b/a = exp(-2L/3).
    let mut log_k = if l < 0.5 {
        -2.0 / 3.0 * l
    } else {
        -2.0 / core::f64::consts::PI * l
    };
    let mut integrals = ellipse_integrals(log_k.exp());
    for _ in 0..50 {
        let k2 = (2.0 * log_k).exp();
        // B/A = R_D(0,1,k^2)/R_D(0,k^2,1) = Bl/(k^2 D).
        let residual = (integrals.bl / (k2 * integrals.d)).ln() - l;
        // d ln(Bl)/d ln k and d ln(D)/d ln k from dK/dk = (E - k^2 K)/..., written in Bl and D.
        let slope = log_ratio_slope(k2, &integrals);
        let step = residual / slope;
        log_k = (log_k - step).min(0.0);
        integrals = ellipse_integrals(log_k.exp());
        if step.abs() < 1e-15 * (1.0 + log_k.abs()) {
            break;
        }
    }
    let k = log_k.exp();
    let f1 = (4.0 / core::f64::consts::PI * (k * integrals.bl * integrals.d).sqrt()).cbrt();
    let f2 = 2.0 / core::f64::consts::PI * k.sqrt() * integrals.k / f1;
    (
        ContactEllipse {
            axis_ratio: k,
            f1,
            f2,
        },
        integrals,
    )
}

/// `d ln(B/A) / d ln k`, with `B/A = Bl/(k^2 D)`.
fn log_ratio_slope(k2: f64, e: &EllipseIntegrals) -> f64 {
    let m = 1.0 - k2;
    if m < 0.05 {
        // Power series at the circle: the closed form divides by m. Newton needs no more.
        return -1.5 - 0.05 * m;
    }
    // With E = Bl + k^2 D:  dK/dm = Bl/(2 k^2),  dE/dm = -D/2 (both DLMF 19.4.1),  D = (K-E)/m,  Bl = K - D.
    let dk = e.bl / (2.0 * k2);
    let de = -0.5 * e.d;
    let dd = (dk - de - e.d) / m;
    let dbl = dk - dd;
    // d/d ln k = -2 k^2 d/dm.
    -2.0 * k2 * (dbl / e.bl - dd / e.d) - 2.0
}

/// Hale's closed form, the paper's Eq. (4): `None` where it breaks (`F2 <= 0`, that is `B/A` above
/// 25178.12, where the force would be infinite or NaN). `sigma` is exact: Hale gives none, and the derivative of his form is
/// singular at a circle (the conservative law refuses it).
pub fn hale(trace: f64, determinant: f64, with_sigma: bool) -> Option<Factors> {
    let w = fit_variable(trace, determinant);
    let l = log_ratio(w);
    let f2 = hale_f2(l);
    if f2 <= 0.0 {
        return None;
    }
    Some(Factors {
        phi: f2.powf(-1.5),
        sigma: if with_sigma {
            exact(trace, determinant, true).sigma
        } else {
            0.0
        },
    })
}

/// Hale's `F1` for a ratio `B/A >= 1` (Eq. (4)); passes through zero at 100114.8.
pub fn hale_f1(ratio: f64) -> f64 {
    1.0 - (ratio.max(1.0).powf(0.0602) - 1.0).powf(1.456)
}

fn hale_f2(log_ratio: f64) -> f64 {
    1.0 - (0.0684 * log_ratio.max(0.0)).exp_m1().powf(1.531)
}
