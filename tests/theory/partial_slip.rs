// SPDX-License-Identifier: MIT OR Apache-2.0
//! TFD, the law of Cattaneo and Mindlin: force, sliding limit, viscous part (section 4), in the published form, `displacement
//! total`, whose memory is the displacement; and the default form, which is the same at a steady normal force.

use crate::support::elliptic::{complete, curvature_ratio};
use crate::support::scene::pair_law;
use ellgran::force::hertz_factors::exact;
use ellgran::force::{normal_force, tangential_force, NormalForce, PairLaw, TangentialForce};
use ellgran::vector::{Symmetric2, Vector2};

const PENETRATION: f64 = 2e-3;
const FRICTION: f64 = 0.4;
const NU: f64 = 0.3;

fn normal(law: &PairLaw, curvature: Symmetric2) -> NormalForce {
    normal_force(
        &law.kinds.normal,
        &law.constants.normal,
        PENETRATION,
        0.0,
        curvature.determinant(),
        &exact(curvature.trace(), curvature.determinant(), true),
        1.0,
    )
}

fn slide(law: &PairLaw, curvature: Symmetric2, xi: Vector2, velocity: Vector2) -> TangentialForce {
    let n = normal(law, curvature);
    tangential_force(
        &law.kinds.tangential,
        &law.constants.tangential,
        (n.force, n.stiffness, 0.0),
        &exact(curvature.trace(), curvature.determinant(), true),
        curvature,
        xi,
        0.0,
        true,
        Vector2::new(0.0, 0.0),
        velocity,
    )
}

fn elastic() -> PairLaw {
    pair_law(&format!(
        "hertz 1e6 {NU} tangential tfd {FRICTION} displacement total"
    ))
}

#[test]
fn equal_spheres_slide_beyond_mu_2_minus_nu_over_2_1_minus_nu_delta() {
    let law = elastic();
    let m = Symmetric2::new(1.0, 0.0, 1.0);
    let f_n = normal(&law, m).force;
    let limit = FRICTION * (2.0 - NU) / (2.0 * (1.0 - NU)) * PENETRATION;
    for x in [1e-6, 0.01, 0.3, 0.7, 0.99, 1.0, 1.5] {
        let (sin, cos) = 0.7f64.sin_cos();
        let t = slide(
            &law,
            m,
            Vector2::new(cos, sin) * (x * limit),
            Vector2::new(0.0, 0.0),
        );
        let wanted = FRICTION * f_n * (1.0 - (1.0 - f64::min(x, 1.0)).powf(1.5));
        let got = t.force.dot(t.force).sqrt();
        assert!(
            (got - wanted).abs() < 1e-12 * wanted.max(1e-3 * f_n),
            "{x}: {got} {wanted}"
        );
        assert!(
            t.force.u < 0.0 && t.force.v < 0.0,
            "against the displacement"
        );
        // On sliding what is remembered stays on the cone.
        let kept = t.memory.dot(t.memory).sqrt();
        assert!((kept - limit * x.min(1.0)).abs() < 1e-12 * limit);
    }
}

#[test]
fn an_ellipse_slides_beyond_mu_kappa_delta_in_each_principal_direction() {
    let law = elastic();
    for axis_ratio in [0.5, 0.1, 0.02] {
        let (k, e) = complete(axis_ratio);
        let d = (k - e) / (1.0 - axis_ratio * axis_ratio);
        let m = Symmetric2::new(1.0, 0.0, curvature_ratio(axis_ratio));
        let f_n = normal(&law, m).force;
        let directions = [Vector2::new(1.0, 0.0), Vector2::new(0.0, 1.0)];
        for (direction, beta) in directions.into_iter().zip([(k - d) / k, d / k]) {
            let kappa = (1.0 - NU * beta) / (1.0 - NU);
            for x in [0.1, 0.6, 0.999] {
                let xi = direction * (x * FRICTION * kappa * PENETRATION);
                let t = slide(&law, m, xi, Vector2::new(0.0, 0.0));
                let wanted = FRICTION * f_n * (1.0 - f64::powf(1.0 - x, 1.5));
                let got = -(t.force.dot(direction));
                assert!(
                    (got / wanted - 1.0).abs() < 1e-10,
                    "b/a {axis_ratio}, {x}: {got} {wanted}"
                );
            }
        }
    }
}

#[test]
fn a_turned_tangent_basis_turns_the_force() {
    let law = elastic();
    let (a, b) = (1.0, 40.0);
    let principal = Symmetric2::new(a, 0.0, b);
    let xi = Vector2::new(2e-4, -3e-4);
    let straight = slide(&law, principal, xi, Vector2::new(0.0, 0.0)).force;
    let (sin, cos) = 1.1f64.sin_cos();
    let turned = |x: Vector2| Vector2::new(cos * x.u - sin * x.v, sin * x.u + cos * x.v);
    let m = Symmetric2::new(
        a * cos * cos + b * sin * sin,
        (a - b) * sin * cos,
        a * sin * sin + b * cos * cos,
    );
    let got = slide(&law, m, turned(xi), Vector2::new(0.0, 0.0)).force;
    let off = got - turned(straight);
    assert!(off.dot(off).sqrt() < 1e-12 * straight.dot(straight).sqrt());
    // Anisotropic: not against the displacement.
    assert!(
        (straight.u * xi.v - straight.v * xi.u).abs() > 1e-3 * straight.dot(straight).sqrt() * 3e-4
    );
}

#[test]
fn elastic_energy_is_the_work_of_the_displacement() {
    let law = elastic();
    let m = Symmetric2::new(1.0, 0.0, 9.0);
    let end = Vector2::new(4e-4, 3e-4);
    let steps = 2000;
    let mut work = 0.0;
    for k in 0..steps {
        let at = slide(
            &law,
            m,
            end * ((k as f64 + 0.5) / steps as f64),
            Vector2::new(0.0, 0.0),
        );
        work -= at.force.dot(end) / steps as f64;
    }
    let got = slide(&law, m, end, Vector2::new(0.0, 0.0)).elastic_energy;
    assert!((got / work - 1.0).abs() < 1e-6, "{got} {work}");
}

#[test]
fn the_viscous_part_is_a_t_k_t_v_t() {
    let (eta1, eta2) = (3.0, 5.0);
    let law = pair_law(&format!(
        "nfd 1e6 {NU} {eta1} {eta2} tangential tfd {FRICTION} displacement total"
    ));
    let e = 1e6;
    let (tau1, tau2) = (eta1 * (1.0 + NU) / e, eta2 * 3.0 * (1.0 - 2.0 * NU) / e);
    for axis_ratio in [1.0, 0.3] {
        let (beta_major, ratio) = if axis_ratio < 1.0 {
            let (k, e) = complete(axis_ratio);
            let d = (k - e) / (1.0 - axis_ratio * axis_ratio);
            ((k - d) / k, curvature_ratio(axis_ratio))
        } else {
            (0.5, 1.0)
        };
        let m = Symmetric2::new(1.0, 0.0, ratio);
        let f_n = normal(&law, m).force;
        let cases = [
            (Vector2::new(1.0, 0.0), beta_major),
            (Vector2::new(0.0, 1.0), 1.0 - beta_major),
        ];
        for (direction, beta) in cases {
            let kappa = (1.0 - NU * beta) / (1.0 - NU);
            let limit = FRICTION * kappa * PENETRATION;
            let time = tau1 * (3.0 - beta * (1.0 + 2.0 * NU - 2.0 * NU * NU))
                / (3.0 * (1.0 - beta * NU))
                + tau2 * beta * (1.0 + NU) * (1.0 - 2.0 * NU) / (3.0 * (1.0 - beta * NU));
            for x in [0.0, 0.5, 0.9] {
                let speed = 1e-3 * limit / time;
                let rest = slide(&law, m, direction * (x * limit), Vector2::new(0.0, 0.0));
                let moving = slide(&law, m, direction * (x * limit), direction * speed);
                let got = -((moving.force - rest.force).dot(direction));
                let stiffness = 1.5 * FRICTION * f_n * f64::sqrt(1.0 - x) / limit;
                let wanted = time * stiffness * speed;
                assert!(
                    (got / wanted - 1.0).abs() < 1e-9,
                    "b/a {axis_ratio}, {x}: {got} {wanted}"
                );
            }
        }
    }
}

/// Out, back, beyond sliding on the other side, and out again, at a steady normal force.
#[test]
fn the_default_is_the_published_form_at_a_steady_normal_force() {
    for (words, axis_ratio, direction) in [
        ("hertz 1e6 0.3", 1.0, 0.3f64),
        ("hertz 1e6 0.3", 10.0, 0.0),
        ("hertz 1e6 0.3", 10.0, 0.7),
        ("nfd 1e6 0.3 30 20", 40.0, 1.1),
    ] {
        for tangential in ["tfd", "mindlin"] {
            let deck = format!("{words} tangential {tangential} {FRICTION}");
            let (default, published) = (
                pair_law(&deck),
                pair_law(&format!("{deck} displacement total")),
            );
            let m = Symmetric2::new(1.0, 0.0, axis_ratio);
            let n = normal(&default, m);
            let factors = exact(m.trace(), m.determinant(), true);
            let along = Vector2::new(direction.cos(), direction.sin());
            let none = Vector2::new(0.0, 0.0);
            let (mut kept, mut energy, mut xi) = (none, 0.0, none);
            let steps = 400;
            let path = |k: usize| {
                let t = k as f64 / steps as f64;
                FRICTION * PENETRATION * 2.0 * (5.0 * t).sin() * t
            };
            let mut slid = false;
            for k in 1..=steps {
                let step = along * (path(k) - path(k - 1));
                let call = |law: &PairLaw, memory, remembered| {
                    tangential_force(
                        &law.kinds.tangential,
                        &law.constants.tangential,
                        (n.force, n.stiffness, 0.0),
                        &factors,
                        m,
                        memory,
                        remembered,
                        true,
                        step,
                        step * 10.0,
                    )
                };
                let (a, b) = (call(&default, kept, energy), call(&published, xi, 0.0));
                let apart = a.force - b.force;
                let limit = FRICTION * n.force;
                assert!(
                    apart.dot(apart).sqrt() < 2e-12 * limit,
                    "{deck}, A/B {axis_ratio}, step {k}: {:?} {:?}",
                    a.force,
                    b.force
                );
                assert!((a.elastic_energy - b.elastic_energy).abs() < 2e-12 * limit * PENETRATION);
                slid |= b.force.dot(b.force).sqrt() > limit * (1.0 - 1e-12);
                (kept, energy, xi) = (a.memory, a.elastic_energy, b.memory);
            }
            assert!(slid, "the path never slid");
        }
    }
}

/// Where no time passes nothing slips and nothing is given up, on whatever cone: what a run remembers when it ends is there
/// when the next one starts, whose first forces have other velocities.
#[test]
fn nothing_is_forgotten_where_no_time_passes() {
    let m = Symmetric2::new(80.0, 10.0, 300.0);
    let factors = exact(m.trace(), m.determinant(), true);
    for words in ["tfd", "mindlin"] {
        for displacement in ["rescaled", "total", "incremental"] {
            let law = pair_law(&format!(
                "hertz 1e6 {NU} tangential {words} {FRICTION} displacement {displacement}"
            ));
            let n = normal(&law, m);
            let call = |n: &NormalForce, memory, energy, passes, step| {
                tangential_force(
                    &law.kinds.tangential,
                    &law.constants.tangential,
                    (n.force, n.stiffness, 0.0),
                    &factors,
                    m,
                    memory,
                    energy,
                    passes,
                    step,
                    Vector2::new(0.0, 0.0),
                )
            };
            let none = Vector2::new(0.0, 0.0);
            let mut t = call(&n, none, 0.0, true, none);
            for k in 0..20 {
                // in a curve, so that the compliance along it changes
                let angle = 0.1 * k as f64;
                let step = Vector2::new(angle.cos(), angle.sin()) * (0.05 * FRICTION * PENETRATION);
                t = call(&n, t.memory, t.elastic_energy, true, step);
            }
            let again = call(&n, t.memory, t.elastic_energy, false, none);
            let less = NormalForce {
                force: 0.2 * n.force,
                ..n
            };
            let slid = call(&less, t.memory, t.elastic_energy, false, none);
            let apart = again.force - t.force;
            assert!(
                apart.dot(apart).sqrt() < 1e-13 * FRICTION * n.force,
                "{words} {displacement}"
            );
            for held in [again, slid] {
                let moved = held.memory - t.memory;
                assert_eq!(moved.dot(moved), 0.0, "{words} {displacement}");
                if displacement == "rescaled" {
                    assert_eq!(held.elastic_energy, t.elastic_energy, "{words}");
                }
            }
            // A smaller cone holds the force all the same.
            let limit = FRICTION * less.force;
            assert!(slid.force.dot(slid.force).sqrt() < limit * (1.0 + 1e-14));
        }
    }
}

/// The same of a contact that slides: rounding of its normal force must not give it back a viscous part, which goes with the root of what
/// is left to Coulomb's limit.
#[test]
fn without_time_what_slides_is_not_viscous() {
    let law = pair_law("nfd 1e6 0.3 2e2 2e2 tangential tfd 0.4");
    let m = Symmetric2::new(1.0, 0.2, 3.0);
    let n = normal(&law, m);
    let velocity = Vector2::new(3.0, -1.0);
    let rounding = 1e-8;
    let call = |part: f64, memory, energy, passes, step| {
        tangential_force(
            &law.kinds.tangential,
            &law.constants.tangential,
            (n.force * part, n.stiffness, rounding),
            &exact(m.trace(), m.determinant(), true),
            m,
            memory,
            energy,
            passes,
            step,
            velocity,
        )
    };
    let none = Vector2::new(0.0, 0.0);
    let slid = call(1.0, none, 0.0, true, Vector2::new(1.0, 0.3));
    assert_eq!(slid.force, slid.elastic_force);
    for part in [1.0 - 0.5 * rounding, 1.0, 1.0 + 0.5 * rounding] {
        let again = call(part, slid.memory, slid.elastic_energy, false, none);
        let viscous = again.force + again.elastic_force * -1.0;
        assert!(viscous.dot(viscous).sqrt() < 1e-12 * n.force, "{part}");
    }
}
