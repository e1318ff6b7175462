// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do the fitted factors join the iterated ones, and is the gradient's function the derivative of the force's?

use crate::support::elliptic::{complete, curvature_ratio};
use crate::support::golden::factors;
use ellgran::force::hertz_factors::{
    contact_ellipse, exact, fit_variable, fitted, fitted_near, near_variable,
};

/// End of the fit in `w = ln((A+B)^2/(4AB))`.
const END: f64 = 12.0;
/// B/A where the fit without a logarithm ends.
const NEAR_END: f64 = 10.0;

/// Trace and determinant of a curvature matrix with this `w`.
fn at(w: f64) -> (f64, f64) {
    (1.0, 0.25 * (-w).exp())
}

/// `B/A` from `w`.
fn ratio(w: f64) -> f64 {
    (2.0 * (0.5 * w).exp().acosh()).exp()
}

#[test]
fn fit_and_iteration_agree_to_1e_12_where_the_fit_holds() {
    let mut worst = 0.0f64;
    for k in 1..=600 {
        let w = END * k as f64 / 600.0;
        let phi = fitted(w, false).phi;
        let error = phi / contact_ellipse(ratio(w)).f2.powf(-1.5) - 1.0;
        worst = worst.max(error.abs());
        assert!(error.abs() < 1e-12, "w = {w}: {error:e}");
    }
    println!("largest relative difference of fitted and iterated phi: {worst:.1e}");
}

#[test]
fn no_jump_at_the_end_of_the_fit() {
    for distance in [1e-9, 1e-12, 1e-14] {
        let before = exact(at(END - distance).0, at(END - distance).1, true);
        let after = exact(at(END + distance).0, at(END + distance).1, true);
        // d ln(phi)/dw = sigma/2 there.
        let change = 0.5 * before.sigma * 2.0 * distance;
        assert!((after.phi / before.phi - 1.0 - change).abs() < 1e-13 + 1e-3 * change);
        assert!((after.sigma - before.sigma).abs() < 2e-12 + distance);
    }
}

#[test]
fn both_fits_agree_where_the_one_without_a_logarithm_ends() {
    let mut worst = [0.0f64; 2];
    for k in 0..=200 {
        let ratio = NEAR_END * (1.0 - 1e-3 * k as f64);
        let (trace, determinant) = (1.0 + ratio, ratio);
        let near = fitted_near(near_variable(trace, determinant), true);
        let far = fitted(fit_variable(trace, determinant), true);
        let apart = [near.phi / far.phi - 1.0, near.sigma / far.sigma - 1.0].map(f64::abs);
        assert!(apart[0] < 1e-14 && apart[1] < 1e-12, "{ratio}: {apart:?}");
        for (w, a) in worst.iter_mut().zip(apart) {
            *w = w.max(a);
        }
    }
    println!("largest relative differences of phi and sigma: {worst:?}");
}

#[test]
fn no_jump_where_the_fit_without_a_logarithm_ends() {
    for distance in [1e-9, 1e-12, 1e-14] {
        let at = |ratio: f64| exact(1.0 + ratio, ratio, true);
        let before = at(NEAR_END * (1.0 - distance));
        let after = at(NEAR_END * (1.0 + distance));
        // d ln(phi) = sigma/2 dw, and dw = (B - A)/(B + A) d ln(B/A).
        let anisotropy = (NEAR_END - 1.0) / (NEAR_END + 1.0);
        let change = before.sigma * anisotropy * distance;
        assert!((after.phi / before.phi - 1.0 - change).abs() < 1e-14 + 1e-3 * change);
        assert!((after.sigma / before.sigma - 1.0).abs() < 1e-12 + distance);
    }
}

#[test]
fn the_fit_without_a_logarithm_is_exact_to_rounding() {
    let near = |ratio: f64| fitted_near(near_variable(1.0 + ratio, ratio), true);
    let mut worst = [0.0f64; 3];
    for k in 0..=400 {
        let ratio = NEAR_END.powf(k as f64 / 400.0);
        // The iteration's own error is as large.
        let error = near(ratio).phi * contact_ellipse(ratio).f2.powf(1.5) - 1.0;
        assert!(error.abs() < 4e-15, "phi at B/A = {ratio}: {error:e}");
        worst[0] = worst[0].max(error.abs());
    }
    for row in factors().iter().filter(|row| row.ratio <= NEAR_END) {
        let (r, f) = (row.ratio, near(row.ratio));
        let error = f.phi / row.phi - 1.0;
        assert!(error.abs() < 1e-15, "phi at B/A = {r}: {error:e}");
        worst[1] = worst[1].max(error.abs());
        // Bl/K is 1/2 less a sixth of this at least, and known to rounding.
        let anisotropy = (r - 1.0) / (r + 1.0);
        let error = f.sigma * anisotropy - (0.5 - row.beta_major);
        assert!(
            error.abs() < 2e-16 + 1e-15 * anisotropy,
            "sigma at B/A = {r}: {error:e}"
        );
        if anisotropy > 0.1 {
            worst[2] = worst[2].max((error / (f.sigma * anisotropy)).abs());
        }
    }
    println!("largest relative errors of phi (two references) and of sigma: {worst:?}");
}

#[test]
fn sigma_is_twice_the_derivative_of_ln_phi() {
    // Sixth-order differences of the iterated factors, which know nothing of the fit.
    let ln_phi = |w: f64| -1.5 * contact_ellipse(ratio(w)).f2.ln();
    let mut worst = 0.0f64;
    for k in 1..=130 {
        let w = 0.1 * k as f64;
        let h = 0.02_f64.min(0.2 * w);
        let d = |n: f64| ln_phi(w + n * h) - ln_phi(w - n * h);
        let derivative = (45.0 * d(1.0) - 9.0 * d(2.0) + d(3.0)) / (60.0 * h);
        let (trace, determinant) = at(w);
        let error = exact(trace, determinant, true).sigma - 2.0 * derivative;
        worst = worst.max(error.abs());
        assert!(error.abs() < 1e-10, "w = {w}: {error:e}");
    }
    println!("largest difference of sigma and its finite difference: {worst:.1e}");
}

#[test]
fn sigma_is_the_anisotropy_of_the_compliance() {
    for axis_ratio in [0.9, 0.5, 0.2, 0.1, 0.05, 0.01, 1e-3] {
        let (k, e) = complete(axis_ratio);
        let m = 1.0 - axis_ratio * axis_ratio;
        let d = (k - e) / m;
        let ratio = curvature_ratio(axis_ratio);
        let wanted = (d - 0.5 * k) / k * (ratio + 1.0) / (ratio - 1.0);
        let got = exact(1.0 + ratio, ratio, true).sigma;
        assert!(
            (got - wanted).abs() < 1e-11,
            "b/a = {axis_ratio}: {got} {wanted}"
        );
    }
}

#[test]
fn at_a_circle_phi_is_1_and_sigma_a_sixth() {
    let f = exact(2.0, 1.0, true);
    assert!((f.phi - 1.0).abs() < 1e-14, "{}", f.phi - 1.0);
    assert!((f.sigma - 1.0 / 6.0).abs() < 1e-12, "{}", f.sigma);
}
