// SPDX-License-Identifier: MIT OR Apache-2.0
//! The normal relaxation time `A_n` by the three closures: the numbers of section 3.

use ellgran::force::damping::normal_relaxation_time;
use ellgran::force::{Closure, Material};

const ALL: [Closure; 3] = [Closure::Surface, Closure::Energy, Closure::Brilliantov];

fn material(nu: f64, eta1: f64, eta2: f64) -> Material {
    Material {
        youngs_modulus: 1.0,
        poissons_ratio: nu,
        shear_viscosity: eta1,
        bulk_viscosity: eta2,
    }
}

/// To the six decimals printed.
fn hold(m: Material, wanted: [f64; 3]) {
    for (closure, wanted) in ALL.into_iter().zip(wanted) {
        let got = normal_relaxation_time(&m, closure);
        assert!(
            (got - wanted).abs() <= 0.5000001e-6,
            "{closure:?} of {m:?}: {got}, expected {wanted}"
        );
    }
}

#[test]
fn both_viscosities_nu_0_3() {
    hold(material(0.3, 1.0, 1.0), [1.213333, 1.275238, 1.078519]);
}

#[test]
fn shear_viscosity_alone_nu_0_3() {
    hold(material(0.3, 1.0, 0.0), [0.173333, 0.978095, 0.674074]);
}

/// What the two rows above leave to the bulk viscosity, where a closure is linear; `eta2 (1 - nu^2)(1 - 2 nu)/(E nu^2)` by
/// Brilliantov's.
#[test]
fn bulk_viscosity_alone_nu_0_3() {
    hold(material(0.3, 0.0, 1.0), [1.04, 0.297143, 4.044444]);
}

#[test]
fn without_viscosity_nothing_relaxes() {
    for closure in ALL {
        assert_eq!(
            normal_relaxation_time(&material(0.3, 0.0, 0.0), closure),
            0.0
        );
    }
}

#[test]
fn both_viscosities_nearly_incompressible_nu_0_499() {
    hold(material(0.499, 1.0, 1.0), [0.006995, 1.496022, 0.001609]);
}

#[test]
fn proportional_damping_gives_its_time_by_every_closure() {
    let tau = 0.0123;
    for nu in [-0.3, -0.1, 0.05, 0.2, 0.3, 0.45] {
        let e = 7e6;
        let m = Material {
            youngs_modulus: e,
            poissons_ratio: nu,
            shear_viscosity: tau * e / (1.0 + nu),
            bulk_viscosity: tau * e / (3.0 * (1.0 - 2.0 * nu)),
        };
        for closure in ALL {
            let got = normal_relaxation_time(&m, closure);
            assert!(
                (got / tau - 1.0).abs() < 1e-12,
                "{closure:?}, nu {nu}: {got}"
            );
        }
        assert!((m.shear_relaxation_time() / tau - 1.0).abs() < 1e-14);
        assert!((m.bulk_relaxation_time() / tau - 1.0).abs() < 1e-14);
    }
}

#[test]
fn energy_closure_is_the_first_variation_of_the_effective_modulus() {
    // E* of one body under E1 -> E1 + eta1 s, E2 -> E2 + eta2 s: d ln(E*)/ds = A_n.
    let stiffness = |e1: f64, e2: f64| {
        // From 2G = e1 and K = e2: (1 - nu^2)/E.
        let (g, k) = (0.5 * e1, e2);
        let e = 9.0 * k * g / (3.0 * k + g);
        let nu = (3.0 * k - 2.0 * g) / (2.0 * (3.0 * k + g));
        e / (1.0 - nu * nu)
    };
    for (nu, eta1, eta2) in [
        (0.3, 1.0, 0.0),
        (0.3, 0.0, 1.0),
        (0.1, 2.0, 0.7),
        (0.45, 0.3, 1.1),
    ] {
        let (e1, e2) = (1.0 / (1.0 + nu), 1.0 / (3.0 * (1.0 - 2.0 * nu)));
        let s = 1e-3;
        let d = |n: f64| {
            stiffness(e1 + n * s * eta1, e2 + n * s * eta2).ln()
                - stiffness(e1 - n * s * eta1, e2 - n * s * eta2).ln()
        };
        let slope = (45.0 * d(1.0) - 9.0 * d(2.0) + d(3.0)) / (60.0 * s);
        let got = normal_relaxation_time(&material(nu, eta1, eta2), Closure::Energy);
        assert!((got / slope - 1.0).abs() < 1e-9, "nu {nu}: {got}, {slope}");
    }
}

#[test]
fn surface_and_1996_closures_lose_shear_dissipation_when_incompressible_and_energy_does_not() {
    let m = material(0.499999, 1.0, 0.0);
    assert!(normal_relaxation_time(&m, Closure::Surface) < 1e-5);
    assert!(normal_relaxation_time(&m, Closure::Brilliantov) < 1e-5);
    assert!(normal_relaxation_time(&m, Closure::Energy) > 1.4);
}

#[test]
fn the_1996_closure_diverges_for_vanishing_poissons_ratio() {
    assert!(normal_relaxation_time(&material(1e-4, 1.0, 0.0), Closure::Brilliantov) > 1e6);
}
