// SPDX-License-Identifier: MIT OR Apache-2.0
//! Coefficients of normal damping: the relaxation time `A_n` of NFD by three closures, and the damping that gives a
//! coefficient of restitution (docs/theory.md, sections 3 and 6).

use super::choice::choices;
use super::material::Material;
#[cfg(not(feature = "std"))]
use crate::real::Functions;
#[cfg(not(feature = "std"))]
use crate::real::Real;

choices! {
    /// Damping of the `hertz` normal law.
    Damping {
        /// No damping of the `hertz` law.
        None = 0, "none", ELLGRAN_DAMPING_NONE, [];
        /// Damping that gives central impacts a coefficient of restitution, at any speed.
        Restitution = 1, "restitution", ELLGRAN_DAMPING_RESTITUTION, [restitution];
        /// Damping by a relaxation time A_n: the form of `nfd` with the coefficient given.
        Relaxation = 2, "relaxation", ELLGRAN_DAMPING_RELAXATION, [relaxation_time];
    }

    /// How `A_n` follows from the viscosities (docs/theory.md, section 3).
    Closure {
        /// A_n from the dissipation of the quasi-static strain-rate field.
        Energy = 0, "energy", ELLGRAN_CLOSURE_ENERGY, [];
        /// A_n from the surface strains of Hertz' solution.
        Surface = 1, "surface", ELLGRAN_CLOSURE_SURFACE, [];
        /// A_n after Brilliantov et al. 1996.
        Brilliantov = 2, "brilliantov", ELLGRAN_CLOSURE_BRILLIANTOV, [];
    }

    /// The viscoelastic force while the overlap shrinks.
    Unloading {
        /// Receding contact after Ting: `F_H(max(delta + A_n d(delta)/dt, 0))`, never attractive.
        Ting = 0, "ting", ELLGRAN_UNLOADING_TING, [];
        /// First-order law throughout.
        FirstOrder = 1, "first_order", ELLGRAN_UNLOADING_FIRST_ORDER, [];
    }

    /// To which order in the rate the viscous normal force of `nfd` is right.
    Viscosity {
        /// First order in the rate, with A_n of the closure.
        FirstOrder = 0, "first_order", ELLGRAN_VISCOSITY_FIRST_ORDER, [];
        /// The memory of the solid: exact while the contact grows. Remembers one number per contact, up to three between different
        /// materials.
        Memory = 1, "memory", ELLGRAN_VISCOSITY_MEMORY, [];
    }
}

/// Normal relaxation time `A_n` (time) of one material. All closures give `tau` for `eta_i = tau E_i`.
///
/// `Closure::Brilliantov` diverges for `nu -> 0` and needs `eta1 + eta2 > 0`; see the checks of the parameters.
pub fn normal_relaxation_time(material: &Material, closure: Closure) -> f64 {
    let nu = material.poissons_ratio;
    let e = material.youngs_modulus;
    let (eta1, eta2) = (material.shear_viscosity, material.bulk_viscosity);
    match closure {
        // Dissipation of the quasi-static strain-rate field (D. Goldobin et al., Eur. Phys. J. E 38 (2015) 55): holds
        // for any contact shape.
        Closure::Energy => {
            let s = 1.0 - nu;
            let eta = (2.0 / 3.0 * eta1 * (1.0 - nu + nu * nu)
                + eta2 * (1.0 - 2.0 * nu) * (1.0 - 2.0 * nu))
                / (s * s);
            eta * (1.0 - nu * nu) / e
        }
        // The paper's Eq. (7) with the Hertz surface strains.
        Closure::Surface => (1.0 + nu) * (1.0 - 2.0 * nu) / e * (2.0 * eta2 + eta1 / 3.0),
        // N. Brilliantov et al., Phys. Rev. E 53 (1996) 5382.
        Closure::Brilliantov => {
            if eta1 == 0.0 && eta2 == 0.0 {
                return 0.0;
            }
            let s = 3.0 * eta2 - eta1;
            s * s / (3.0 * eta2 + 2.0 * eta1) * (1.0 - nu * nu) * (1.0 - 2.0 * nu)
                / (3.0 * e * nu * nu)
        }
    }
}

/// `alpha` in the damping force `alpha sqrt(m k) delta^(1/4) v` on `F = k delta^(3/2)` (Y. Tsuji et al., Powder Technol. 71
/// (1992) 239) that gives a central impact the coefficient of restitution `e`, `0 < e <= 1`, at any speed, mass and
/// stiffness. With `limit_force` the force is cut off where it would attract, and the impact ends there; without, it ends at
/// `delta = 0`.
///
/// With `y = delta^(5/4)` as coordinate, `v dv/dy` is that of a damped linear oscillator of damping ratio
/// `z = alpha/sqrt(5)`. It passes `y = 0` with `e = exp(-pi z/sqrt(1 - z^2))`. The force is zero before, where
/// `e = exp(-2 z A(z))` with `A = acos(z)/sqrt(1 - z^2)` for `z < 1`, `acosh(z)/sqrt(z^2 - 1)` for `z > 1` and 1 between: every
/// `e > 0` has its `z`. Both are solved to rounding: of `alpha`, 4e-15 of it (`tests/theory/restitution.rs`, against
/// `validation/restitution/`).
pub fn restitution_coefficient(e: f64, limit_force: bool) -> f64 {
    let l = -e.ln();
    if !limit_force {
        return 5.0f64.sqrt() * l / core::f64::consts::PI.hypot(l);
    }
    // 2 z A(z) = l by Newton: the left side rises from 0 with slope pi and is concave, so that the steps from l/pi rise to the
    // root and never pass it.
    let mut z = l / core::f64::consts::PI;
    for _ in 0..60 {
        let (a, slope) = oscillator_phase(z);
        let step = (l - 2.0 * z * a) / (2.0 * (a + z * slope));
        z += step;
        if step.abs() <= 4e-16 * z {
            break;
        }
    }
    5.0f64.sqrt() * z
}

/// `A(z) = acos(z)/sqrt(1 - z^2)`, continued analytically beyond 1, and its derivative.
fn oscillator_phase(z: f64) -> (f64, f64) {
    let off = z - 1.0;
    let square = off.abs() * (z + 1.0);
    let a = if off < 0.0 {
        z.acos() / square.sqrt()
    } else if off > 0.0 {
        (off + square.sqrt()).ln_1p() / square.sqrt()
    } else {
        1.0
    };
    // (1 - z^2) A' = z A - 1, which cancels near 1.
    let slope = if off.abs() < 1e-4 {
        -1.0 / 3.0 + 4.0 / 15.0 * off
    } else {
        (1.0 - z * a) / (off * (z + 1.0))
    };
    (a, slope)
}

/// The two numbers from which the tangential relaxation times follow: `A_t = (t0 - t1 beta)/(1 - nu beta)`, with
/// `beta = Bl/K` along the major and `D/K` along the minor semi-axis of the contact ellipse.
///
/// `Closure::Energy`: the tangential load's own strain-rate energy (docs/theory.md, section 4). The other closures: the authors'
/// own `A_t = eta1/(2G) = tau1`.
pub fn tangential_relaxation_numbers(material: &Material, closure: Closure) -> (f64, f64) {
    let nu = material.poissons_ratio;
    let tau1 = material.shear_relaxation_time();
    let tau2 = material.bulk_relaxation_time();
    match closure {
        Closure::Energy => (
            tau1,
            (tau1 * (1.0 + 2.0 * nu - 2.0 * nu * nu) - tau2 * (1.0 + nu) * (1.0 - 2.0 * nu)) / 3.0,
        ),
        Closure::Surface | Closure::Brilliantov => (tau1, tau1 * nu),
    }
}
