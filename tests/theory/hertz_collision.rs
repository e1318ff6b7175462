// SPDX-License-Identifier: MIT OR Apache-2.0
//! The elastic collision: largest penetration and contact time of `m delta'' = -k delta^(3/2)` (section 6).

use crate::integrate::until;
use crate::support::scene::pair_law;
use ellgran::force::hertz_factors::exact;
use ellgran::force::normal_force;

struct Collision {
    k: f64,
    m: f64,
    v: f64,
}

impl Collision {
    fn largest(&self) -> f64 {
        (5.0 * self.m * self.v * self.v / (4.0 * self.k)).powf(0.4)
    }
}

/// An elliptical contact, `B/A = 5`.
fn rate_of(m: f64) -> (f64, impl Fn(&[f64; 2]) -> [f64; 2]) {
    let law = pair_law("hertz 1e7 0.3");
    let (trace, determinant) = (12.0, 20.0);
    let force = move |y: &[f64; 2]| {
        let factors = exact(trace, determinant, true);
        normal_force(
            &law.kinds.normal,
            &law.constants.normal,
            y[0].max(0.0),
            y[1],
            determinant,
            &factors,
            m,
        )
        .force
    };
    let k = force(&[1.0, 0.0]);
    (k, move |y: &[f64; 2]| [y[1], -force(y) / m])
}

fn run(m: f64, v: f64) -> (Collision, [f64; 2], f64) {
    let (k, rate) = rate_of(m);
    let c = Collision { k, m, v };
    let span = 3.0 * c.largest() / v;
    let (_, deepest) = until(&rate, |_, y| y[1], [0.0, v], span, 20_000);
    let (time, end) = until(&rate, |_, y| y[0], [0.0, v], span, 20_000);
    (c, [deepest[0], end[1]], time)
}

#[test]
fn stiffness_is_that_of_eq_1() {
    let (k, _) = rate_of(1.0);
    let effective = 1e7 / (2.0 * (1.0 - 0.09));
    let re = 0.5 / 20f64.sqrt();
    let ratio: f64 = 5.0;
    let f2 = ellgran::force::hertz_factors::contact_ellipse(ratio).f2;
    // A + B = 12, A B = 20: A = 2, B = 10.
    let wanted = 4.0 / 3.0 * effective * re.sqrt() * f2.powf(-1.5);
    assert!((k / wanted - 1.0).abs() < 1e-13, "{k} {wanted}");
}

#[test]
fn largest_penetration_is_5_m_v2_over_4_k_to_the_2_fifths() {
    for (m, v) in [(0.3, 0.1), (2e-6, 4.0)] {
        let (c, [deepest, _], _) = run(m, v);
        assert!(
            (deepest / c.largest() - 1.0).abs() < 1e-12,
            "{deepest} {}",
            c.largest()
        );
    }
}

#[test]
fn contact_time_is_3_2180654597190431_and_2_9432751843247047_delta_max_over_v() {
    for (m, v) in [(0.3, 0.1), (2e-6, 4.0)] {
        let (c, [_, rebound], time) = run(m, v);
        let first = time / (m * m / (c.k * c.k * v)).powf(0.2);
        let second = time * v / c.largest();
        println!("contact time coefficients {first:.15} {second:.15}");
        assert!(
            (first / 3.218_065_459_719_043 - 1.0).abs() < 1e-12,
            "{first:.16}"
        );
        assert!(
            (second / 2.943_275_184_324_704_7 - 1.0).abs() < 1e-12,
            "{second:.16}"
        );
        assert!((rebound / v + 1.0).abs() < 1e-12, "elastic: {rebound}");
    }
}
