// SPDX-License-Identifier: MIT OR Apache-2.0
//! Force, displacement and energy of a tangential spring by closed forms, and what partial slip on an ellipse gives up where it turns
//! (docs/theory.md, section 4).

use crate::support::scene::pair_law;
use ellgran::force::hertz_factors::exact;
use ellgran::force::tangential::{largest_tangential_stiffness, tangential_stiffness};
use ellgran::force::{normal_force, tangential_force, PairLaw, TangentialForce, TwistSpring};
use ellgran::vector::{Symmetric2, Vector2};

const DEPTH: f64 = 2e-3;
const NU: f64 = 0.3;
const NONE: Vector2 = Vector2 { u: 0.0, v: 0.0 };

/// A contact of this depth that is displaced; it remembers a vector and its energy.
struct Held {
    law: PairLaw,
    curvature: Symmetric2,
    memory: Vector2,
    energy: f64,
}

impl Held {
    fn new(words: &str, curvature: Symmetric2) -> Held {
        Held {
            law: pair_law(words),
            curvature,
            memory: NONE,
            energy: 0.0,
        }
    }

    fn normal(&self) -> (f64, f64, f64) {
        let m = self.curvature;
        let (kinds, constants) = (&self.law.kinds.normal, &self.law.constants.normal);
        let factors = exact(m.trace(), m.determinant(), true);
        let n = normal_force(kinds, constants, DEPTH, 0.0, m.determinant(), &factors, 1.0);
        (n.force, n.stiffness, 0.0)
    }

    fn by(&mut self, increment: Vector2, velocity: Vector2) -> TangentialForce {
        let t = self.evaluate(increment, velocity, true);
        (self.memory, self.energy) = (t.memory, t.elastic_energy);
        t
    }

    fn evaluate(&self, increment: Vector2, velocity: Vector2, passes: bool) -> TangentialForce {
        let m = self.curvature;
        tangential_force(
            &self.law.kinds.tangential,
            &self.law.constants.tangential,
            self.normal(),
            &exact(m.trace(), m.determinant(), true),
            m,
            self.memory,
            self.energy,
            passes,
            increment,
            velocity,
        )
    }
}

fn is(found: Vector2, wanted: Vector2) -> bool {
    let apart = found - wanted;
    apart.dot(apart).sqrt() < 1e-12 * wanted.dot(wanted).sqrt().max(1e-300)
}

/// A constant spring of 5000 with a dashpot of 3: `F = k xi`, `E = k xi^2/2`, up to Coulomb's limit.
#[test]
fn a_linear_spring() {
    for displacement in ["rescaled", "total", "incremental"] {
        let words =
            format!("hertz 1e6 {NU} tangential linear 5e3 3 0.4 displacement {displacement}");
        let mut held = Held::new(&words, Symmetric2::new(1.0, 0.0, 1.0));
        let limit = 0.4 * held.normal().0;
        let direction = Vector2::new(0.6, 0.8);
        let way = 0.25 * limit / 5e3;
        for k in 1..=2 {
            let t = held.by(direction * way, NONE);
            let way = way * f64::from(k);
            assert!(is(t.force, direction * (-5e3 * way)));
            assert!(is(t.displacement, direction * way));
            assert!((t.elastic_energy / (0.5 * 5e3 * way * way) - 1.0).abs() < 1e-12);
        }
        let t = held.by(NONE, direction * (0.1 * limit / 3.0));
        assert!(is(t.elastic_force, direction * (-0.5 * limit)));
        assert!(is(t.force, direction * (-0.6 * limit)));
        // It slides, with what the spring can hold at most.
        let t = held.by(direction * (way * 10.0), direction);
        assert!(is(t.force, direction * -limit) && is(t.elastic_force, direction * -limit));
        assert!(is(t.displacement, direction * (limit / 5e3)));
        assert!((t.elastic_energy / (0.5 * limit * limit / 5e3) - 1.0).abs() < 1e-12);
    }
}

/// Two unit spheres without slip: `k = 4 G a/(2 - nu)`.
#[test]
fn the_energy_of_mindlins_spring() {
    let shear_modulus = 1e6 / (2.0 * (1.0 + NU));
    let stiffness = 4.0 * shear_modulus * (0.5 * DEPTH).sqrt() / (2.0 - NU);
    for displacement in ["rescaled", "total", "incremental"] {
        let words = format!("hertz 1e6 {NU} tangential mindlin 0.4 displacement {displacement}");
        let mut held = Held::new(&words, Symmetric2::new(1.0, 0.0, 1.0));
        let limit = 0.4 * held.normal().0;
        let way = 0.3 * limit / stiffness;
        for k in 1..=2 {
            let t = held.by(Vector2::new(0.0, way), NONE);
            let way = way * f64::from(k);
            assert!((t.force.v / (-stiffness * way) - 1.0).abs() < 1e-9, "{t:?}");
            assert!((t.displacement.v / way - 1.0).abs() < 1e-9);
            assert!((t.elastic_energy / (0.5 * stiffness * way * way) - 1.0).abs() < 1e-9);
        }
    }
}

/// Where no time passes the force is the same again, viscous part and all, below sliding and beyond.
#[test]
fn the_dashpot_acts_where_no_time_passes() {
    let mut held = Held::new(
        "nfd 1e6 0.3 30 20 tangential tfd 0.4",
        Symmetric2::new(1.0, 0.0, 1.0),
    );
    let limit = 0.4 * held.normal().0;
    let velocity = Vector2::new(0.3, 0.1);
    for (way, slides) in [(1e-5, false), (1e-4, false), (1e-2, true)] {
        let t = held.by(Vector2::new(way, 0.0), velocity);
        let again = held.evaluate(NONE, velocity, false);
        let apart = again.force - t.force;
        assert!(apart.dot(apart).sqrt() < 1e-7 * limit);
        let viscous = t.force - t.elastic_force;
        assert_eq!(viscous.dot(viscous).sqrt() < 1e-12 * limit, slides, "{way}");
    }
}

/// A step in which partial slip turns to the more compliant direction of an ellipse: what the contact remembers grows by the work of the force, and
/// what it would hold had it been loaded along one line is more.
#[test]
fn partial_slip_that_turns_gives_up_its_surplus() {
    // The contact is longer along u, and more compliant.
    let curvature = Symmetric2::new(1.0, 0.0, 30.0);
    let words = "hertz 1e6 0.45 tangential tfd 0.4";
    let fresh = || Held::new(words, curvature);
    let (limit, stiffness) = (0.4 * fresh().normal().0, fresh().normal().1);
    let factors = exact(curvature.trace(), curvature.determinant(), true);
    let c = fresh().law;
    let (kinds, constants) = (&c.kinds.tangential, &c.constants.tangential);
    let (k, _) = tangential_stiffness(kinds, constants, stiffness, &factors, curvature);
    assert!(k.uu < 0.9 * k.vv && k.uv == 0.0);
    let displacement = |zeta: Vector2| Vector2::new(zeta.u / k.uu, zeta.v / k.vv);
    for s in [0.3, 0.6, 0.9] {
        for angle in [0.3f64, 0.8, 1.3] {
            let (sin, cos) = angle.sin_cos();
            let zeta = Vector2::new(sin, cos) * (1.5 * limit * s);
            let step = displacement(Vector2::new(cos, -sin) * (1.5 * limit * 1e-5));
            let mut held = fresh();
            let before = held.by(displacement(zeta), NONE);
            let after = held.by(step, NONE);
            let work = -0.5 * (before.force + after.force).dot(step);
            let grown = after.elastic_energy - before.elastic_energy;
            let open = (grown - work).abs() / before.elastic_energy;
            let along_a_line = fresh().by(displacement(zeta) + step, NONE).elastic_energy;
            let surplus = (along_a_line - before.elastic_energy - work) / before.elastic_energy;
            println!("s {s}, angle {angle}: surplus {surplus:.1e}, open {open:.1e}");
            assert!(open < 1e-9, "{s}, {angle}: {open:e}");
            assert!(surplus > 1e-8, "{s}, {angle}: {surplus:e}");
        }
    }
}

/// Bounds of the tangential stiffness for the stable step: that of the axes, and of a constant spring its own.
#[test]
fn the_largest_tangential_stiffness() {
    let curvature = Symmetric2::new(1.0, 0.0, 30.0);
    let of = |words: &str, normal_stiffness: f64| {
        let law = pair_law(words);
        let (kinds, constants) = (&law.kinds.tangential, &law.constants.tangential);
        let factors = exact(curvature.trace(), curvature.determinant(), true);
        let (k, d) = tangential_stiffness(kinds, constants, normal_stiffness, &factors, curvature);
        let most = largest_tangential_stiffness(kinds, constants, normal_stiffness);
        ([k.uu.max(k.vv), d.uu.max(d.vv)], [most.0, most.1])
    };
    let (axes, most) = of("hertz 1e6 0.3 tangential linear 5e3 3 0.4", 1e4);
    assert_eq!((axes, most), ([5e3, 3.0], [5e3, 3.0]));
    for words in ["hertz 1e6 0.3", "hertz 1e6 0.3 tangential linear 5e3 3 0"] {
        assert_eq!(of(words, 1e4), ([0.0; 2], [0.0; 2]));
    }
    for words in ["mindlin 0.4", "tfd 0.4"] {
        let (axes, most) = of(&format!("nfd 1e6 0.3 30 20 tangential {words}"), 1e4);
        for (axis, most) in axes.into_iter().zip(most) {
            assert!(
                axis > 0.0 && axis <= most && most < 2.0 * axis,
                "{axis} {most}"
            );
        }
    }
}

/// The spring of `twisting marshall` in any tangent basis: a quarter of `k_a b^2 + k_b a^2` for the semi-axes `a` and `b`.
#[test]
fn marshalls_spring_is_the_same_in_any_basis() {
    let ratio = 30.0;
    let law = pair_law("nfd 1e6 0.3 30 20 tangential mindlin 0.4");
    let (kinds, constants) = (&law.kinds.tangential, &law.constants.tangential);
    let at = |angle: f64| {
        let (s, c) = angle.sin_cos();
        let m = Symmetric2::new(
            c * c + ratio * s * s,
            (1.0 - ratio) * c * s,
            s * s + ratio * c * c,
        );
        let factors = exact(m.trace(), m.determinant(), true);
        TwistSpring::of_contact_ellipse(kinds, constants, DEPTH, 1e4, &factors, m)
    };
    let aligned = at(0.0);
    let m = Symmetric2::new(1.0, 0.0, ratio);
    let factors = exact(m.trace(), m.determinant(), true);
    let (k, d) = tangential_stiffness(kinds, constants, 1e4, &factors, m);
    let e = ellgran::force::hertz_factors::contact_ellipse(ratio);
    let product = 0.5 / ratio.sqrt() * DEPTH * e.f1 * e.f1 / e.f2;
    let (long, short) = (product / e.axis_ratio, product * e.axis_ratio);
    let wanted = |of: Symmetric2| 0.25 * (of.uu * short + of.vv * long);
    assert!((aligned.stiffness / wanted(k) - 1.0).abs() < 1e-8);
    assert!((aligned.damping / wanted(d) - 1.0).abs() < 1e-8);
    for angle in [0.3, 0.8, 1.5, 2.5] {
        let turned = at(angle);
        assert!((turned.stiffness / aligned.stiffness - 1.0).abs() < 1e-10);
        assert!((turned.damping / aligned.damping - 1.0).abs() < 1e-10);
        assert!((turned.friction / aligned.friction - 1.0).abs() < 1e-10);
    }
}
