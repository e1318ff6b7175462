// SPDX-License-Identifier: MIT OR Apache-2.0
//! The tangential compliances of an elliptical contact without slip (section 4), read off the law as small-displacement
//! stiffness in the two principal directions.

use crate::support::elliptic::{complete, curvature_ratio};
use crate::support::scene::pair_law;
use ellgran::force::hertz_factors::{contact_ellipse, exact};
use ellgran::force::{normal_force, tangential_force, tangential_stiffness, NormalForce, PairLaw};
use ellgran::vector::{Symmetric2, Vector2};

const PENETRATION: f64 = 1e-3;

struct Elliptical {
    law: PairLaw,
    curvature: Symmetric2,
    normal: NormalForce,
    /// Major semi-axis of the contact ellipse.
    a: f64,
    shear_modulus: f64,
}

/// Two equal bodies pressed together, with the curvatures `A` along u and `B` along v that make this axis ratio.
fn contact(axis_ratio: f64, nu: f64) -> Elliptical {
    let e = 3e6;
    let law = pair_law(&format!(
        "hertz {e} {nu} tangential mindlin 1e9 displacement total"
    ));
    let ratio = if axis_ratio < 1.0 {
        curvature_ratio(axis_ratio)
    } else {
        1.0
    };
    let curvature = Symmetric2::new(0.7, 0.0, 0.7 * ratio);
    let factors = exact(curvature.trace(), curvature.determinant(), true);
    let normal = normal_force(
        &law.kinds.normal,
        &law.constants.normal,
        PENETRATION,
        0.0,
        curvature.determinant(),
        &factors,
        1.0,
    );
    let ellipse = contact_ellipse(ratio);
    let effective_radius = 0.5 / curvature.determinant().sqrt();
    // Eq. (2): a b = Re delta F1^2/F2.
    let ab = effective_radius * PENETRATION * ellipse.f1.powi(2) / ellipse.f2;
    Elliptical {
        law,
        curvature,
        normal,
        a: (ab / ellipse.axis_ratio).sqrt(),
        shear_modulus: e / (2.0 * (1.0 + nu)),
    }
}

impl Elliptical {
    /// Compliance of one of the two equal bodies along the major (u) and the minor (v) semi-axis.
    fn tangential(&self) -> [f64; 2] {
        let small = 1e-6 * PENETRATION;
        let factors = exact(self.curvature.trace(), self.curvature.determinant(), true);
        [Vector2::new(small, 0.0), Vector2::new(0.0, small)].map(|xi| {
            let zero = Vector2::new(0.0, 0.0);
            let t = tangential_force(
                &self.law.kinds.tangential,
                &self.law.constants.tangential,
                (self.normal.force, self.normal.stiffness, 0.0),
                &factors,
                self.curvature,
                zero,
                0.0,
                true,
                xi,
                zero,
            );
            // Against the displacement, and along it: these are principal directions.
            let along = -(t.force.dot(xi)) / small;
            let across = t.force.u * xi.v - t.force.v * xi.u;
            assert!(along > 0.0 && across == 0.0);
            small / (2.0 * along)
        })
    }
    fn in_units_of_one_over_2_pi_g_a(&self, compliance: f64) -> f64 {
        2.0 * std::f64::consts::PI * self.shear_modulus * self.a * compliance
    }
}

fn hold(name: &str, got: f64, wanted: f64, relative: f64) {
    assert!(
        (got / wanted - 1.0).abs() <= relative,
        "{name}: {got:.13}, expected {wanted:.13}"
    );
}

#[test]
fn axis_ratio_2_nu_0_3_gives_1_887744801222_and_1_778331799527() {
    let c = contact(0.5, 0.3);
    let [major, minor] = c.tangential().map(|x| c.in_units_of_one_over_2_pi_g_a(x));
    hold("2 pi G a C_a", major, 1.887744801222, 1e-12);
    hold("2 pi G a C_b", minor, 1.778331799527, 1e-12);
}

#[test]
fn axis_ratio_10_nu_0_3_gives_3_398959432264_and_2_883624084819() {
    let c = contact(0.1, 0.3);
    let [major, minor] = c.tangential().map(|x| c.in_units_of_one_over_2_pi_g_a(x));
    hold("2 pi G a C_a", major, 3.398959432264, 1e-12);
    hold("2 pi G a C_b", minor, 2.883624084819, 1e-12);
}

#[test]
fn a_circle_has_stiffness_8_g_a_over_2_minus_nu_in_every_direction() {
    for nu in [-0.2, 0.0, 0.3, 0.5] {
        let c = contact(1.0, nu);
        for x in c.tangential() {
            hold(
                "1/C",
                1.0 / x,
                8.0 * c.shear_modulus * c.a / (2.0 - nu),
                1e-12,
            );
        }
    }
}

#[test]
fn any_ellipse_has_the_complete_integrals_compliances() {
    for axis_ratio in [0.9, 0.7, 0.3, 0.05, 0.01, 1e-3, 1e-4] {
        for nu in [0.0, 0.3, 0.5] {
            let c = contact(axis_ratio, nu);
            let (k, e) = complete(axis_ratio);
            let d = (k - e) / (1.0 - axis_ratio * axis_ratio);
            let [major, minor] = c.tangential().map(|x| c.in_units_of_one_over_2_pi_g_a(x));
            hold("2 pi G a C_a", major, k - nu * (k - d), 1e-11);
            hold("2 pi G a C_b", minor, k - nu * d, 1e-11);
        }
    }
}

#[test]
fn the_normal_stiffness_is_that_of_a_flat_elliptical_punch() {
    // dF/d(delta) at fixed curvature = 2 pi G a/((1 - nu) K), two bodies in series: half of it.
    for axis_ratio in [1.0, 0.5, 0.1, 0.01] {
        let c = contact(axis_ratio, 0.3);
        let (k, _) = complete(axis_ratio);
        let wanted = std::f64::consts::PI * c.shear_modulus * c.a / (0.7 * k);
        hold("1/C_n", c.normal.stiffness, wanted, 1e-11);
    }
}

#[test]
fn the_mean_of_kappa_is_the_circles_for_every_ellipse() {
    for nu in [0.0, 0.25, 0.3, 0.5] {
        let wanted = (2.0 - nu) / (2.0 * (1.0 - nu));
        for axis_ratio in [1.0, 0.8, 0.5, 0.1, 0.01, 1e-3] {
            let c = contact(axis_ratio, nu);
            let normal = 0.5 / c.normal.stiffness;
            let [major, minor] = c.tangential().map(|x| x / normal);
            hold(
                "(kappa_a + kappa_b)/2",
                0.5 * (major + minor),
                wanted,
                1e-12,
            );
        }
    }
}

/// What a servo and the advice on the step take for the stiffest and the most viscous that a contact can be: no ellipse exceeds it, and the
/// stiffness of the thinnest comes near it. The bound of the damping is up to 2.25 times what there is, since the least compliance and the largest
/// viscosity are not those of one ellipse.
#[test]
fn the_largest_springs_bound_every_ellipse_and_no_more() {
    for nu in [-0.5, -0.2, 0.0, 0.3, 0.49] {
        for viscosities in ["1e3 0", "0 1e3", "1e3 2e3"] {
            let law = pair_law(&format!("nfd 3e6 {nu} {viscosities} tangential tfd 0.5"));
            let normal_stiffness = 2.0;
            let (stiffest, most_viscous) = law.largest_springs(normal_stiffness, 1.0);
            let (_, of_normal) = pair_law(&format!("nfd 3e6 {nu} {viscosities}"))
                .largest_springs(normal_stiffness, 1.0);
            let (mut stiffness, mut damping) = (normal_stiffness, of_normal);
            for axis_ratio in [1.0, 0.9, 0.5, 0.1, 1e-2, 1e-4, 1e-8] {
                let ratio = if axis_ratio < 1.0 {
                    curvature_ratio(axis_ratio)
                } else {
                    1.0
                };
                let curvature = Symmetric2::new(0.7, 0.0, 0.7 * ratio);
                let factors = exact(curvature.trace(), curvature.determinant(), true);
                let (k, c) = tangential_stiffness(
                    &law.kinds.tangential,
                    &law.constants.tangential,
                    normal_stiffness,
                    &factors,
                    curvature,
                );
                assert!(k.uv == 0.0 && c.uv.abs() < 1e-12 * most_viscous);
                stiffness = stiffness.max(k.uu).max(k.vv);
                damping = damping.max(c.uu).max(c.vv);
            }
            let name = format!("nu {nu}, viscosities {viscosities}");
            assert!(
                stiffness <= stiffest * (1.0 + 1e-12),
                "{name}: {stiffness} {stiffest}"
            );
            assert!(
                stiffest <= 1.05 * stiffness,
                "{name}: {stiffness} {stiffest}"
            );
            assert!(
                damping <= most_viscous * (1.0 + 1e-12),
                "{name}: {damping} {most_viscous}"
            );
            assert!(
                most_viscous <= 2.3 * damping,
                "{name}: {damping} {most_viscous}"
            );
        }
    }
}
