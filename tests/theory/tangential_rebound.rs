// SPDX-License-Identifier: MIT OR Apache-2.0
//! Oblique impact on a plane without slip (section 6): the library's stiffness in the equations of motion,
//! `displacement incremental`, integrated finely.

use crate::integrate::until;
use crate::support::scene::pair_law;
use ellgran::force::hertz_factors::exact;
use ellgran::force::{normal_force, tangential_force};
use ellgran::vector::{Symmetric2, Vector2};

/// `v_t'/v_t` of a contact whose tangential velocity obeys `m_t v_t' = -F_t`, and the `kappa` of the contact.
fn rebound(nu: f64, inverse_tangential_mass: f64) -> f64 {
    let deck = format!("hertz 1e6 {nu} tangential mindlin 1e30 displacement incremental");
    let law = pair_law(&deck);
    let curvature = Symmetric2::new(0.5, 0.0, 0.5);
    let factors = exact(curvature.trace(), curvature.determinant(), true);
    let normal = |y: &[f64; 4]| {
        normal_force(
            &law.kinds.normal,
            &law.constants.normal,
            y[0].max(0.0),
            y[1],
            curvature.determinant(),
            &factors,
            1.0,
        )
    };
    // [delta, delta_dot, v_t, remembered force]: the force is that remembered, and grows by the stiffness.
    let rate = |y: &[f64; 4]| {
        let n = normal(y);
        let zero = Vector2::new(0.0, 0.0);
        let tangential = |memory: f64, increment: f64| {
            let t = tangential_force(
                &law.kinds.tangential,
                &law.constants.tangential,
                (n.force, n.stiffness, 0.0),
                &factors,
                curvature,
                Vector2::new(memory, 0.0),
                0.0,
                true,
                Vector2::new(increment, 0.0),
                zero,
            );
            t.force.u
        };
        // A reversible spring: the Coulomb limit is far away but for the very ends, where there is no overlap.
        let force = if y[0] > 0.0 {
            tangential(y[3], 0.0)
        } else {
            0.0
        };
        let stiffness = if y[0] > 0.0 {
            -tangential(0.0, 1.0)
        } else {
            0.0
        };
        [
            y[1],
            -n.force,
            force * inverse_tangential_mass,
            stiffness * y[2],
        ]
    };
    let v: f64 = 0.1;
    let k = normal(&[1.0, 0.0, 0.0, 0.0]).force;
    let span = 3.3 / (k * k * v).powf(0.2);
    let (_, end) = until(rate, |_, y| y[0], [0.0, v, 1.0, 0.0], span, 20_000);
    end[2]
}

fn kappa(nu: f64) -> f64 {
    (2.0 - nu) / (2.0 * (1.0 - nu))
}

fn closed_form(l: f64) -> f64 {
    let pi = std::f64::consts::PI;
    (pi * (0.01 + 1.2 * l).sqrt()).cos() / (0.1 * pi).cos()
}

#[test]
fn solid_sphere_nu_0_3_rebounds_with_0_954847528103() {
    let got = rebound(0.3, 3.5);
    println!("{got:.13}");
    assert!((got.abs() - 0.954847528103).abs() < 1e-11, "{got:.13}");
    assert!((got - closed_form(3.5 / kappa(0.3))).abs() < 1e-11);
}

#[test]
fn solid_sphere_nu_0_25_rebounds_with_exactly_1() {
    let got = rebound(0.25, 3.5);
    println!("{got:.13}");
    assert!((got.abs() - 1.0).abs() < 1e-11, "{got:.13}");
}

#[test]
fn any_mass_ratio_rebounds_with_the_cosine() {
    for nu in [0.0, 0.2, 0.5] {
        for inverse_mass in [0.5, 1.0, 2.0, 3.5, 5.0] {
            let got = rebound(nu, inverse_mass);
            let wanted = closed_form(inverse_mass / kappa(nu));
            assert!(
                (got - wanted).abs() < 1e-11,
                "nu {nu}, 1/m_t {inverse_mass}: {got} {wanted}"
            );
        }
    }
}
