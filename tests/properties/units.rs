// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do results scale with the units of length, mass and time as their dimensions say?

use crate::support::scene::{advance, difference, laws, rounding, rounding_of, size, Memory};
use crate::support::strategies::{touching_pair, TouchingPair};
use proptest::prelude::*;

/// A law with every kind of term; its constants in units of length, mass and time.
fn decks(l: f64, m: f64, t: f64) -> [String; 5] {
    let pressure = m / (l * t * t);
    let viscosity = pressure * t;
    let e = 1e5 * pressure;
    [
        format!(
            "nfd {e:e} 0.3 {:e} {:e} tangential tfd 0.3",
            30.0 * viscosity,
            50.0 * viscosity
        ),
        format!(
            "nfd {e:e} 0.3 {:e} {:e} viscosity memory tangential tfd 0.3",
            30.0 * viscosity,
            500.0 * viscosity
        ),
        format!("hertz {e:e} 0.3 damping restitution 0.6 tangential mindlin 0.4"),
        format!(
            "hertz {e:e} 0.2 damping relaxation {:e} tangential tfd 0.5 displacement incremental",
            1e-3 * t
        ),
        format!(
            "lsd {:e} {:e} tangential linear {:e} {:e} 0.3",
            1e3 * m / (t * t),
            3.0 * m / t,
            800.0 * m / (t * t),
            2.0 * m / t
        ),
    ]
}

fn scaled(pair: &TouchingPair, l: f64, m: f64, t: f64) -> TouchingPair {
    let mut pair = pair.clone();
    for b in [&mut pair.i, &mut pair.j] {
        b.semi_axes = b.semi_axes.map(|x| x * l);
        b.position = b.position.map(|x| x * l);
        b.velocity = b.velocity.map(|x| x * l / t);
        b.angular_velocity = b.angular_velocity.map(|x| x / t);
        b.mass *= m;
    }
    pair
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn units_of_length_mass_and_time(
        pair in touching_pair(10.0, 1e-5..0.8),
        which in 0usize..5,
        powers in prop::array::uniform3(-9.0..9.0f64),
    ) {
        let [l, m, t] = powers.map(|p| 10f64.powf(p));
        let feel = |l: f64, m: f64, t: f64| {
            let laws = laws(&[&decks(l, m, t)[which]]);
            let pair = scaled(&pair, l, m, t);
            let mut memory = Memory::new(&laws);
            let time_step = 1e-3 * pair.penetration * t;
            advance(&laws, &pair.i, &pair.j, time_step, &mut memory).expect("touching");
            advance(&laws, &pair.i, &pair.j, time_step, &mut memory).expect("touching")
        };
        let (a, b) = (feel(1.0, 1.0, 1.0), feel(l, m, t));
        let force = m * l / (t * t);
        let size = size(&pair.i, &pair.j);
        let error = difference(
            &a,
            b.force / force,
            b.torque_i / (force * l),
            b.torque_j / (force * l),
            size,
        );
        // Another rounding of every coordinate; near the depth where the normal is lost, more of it.
        let depth = a.geometry.penetration / pair.radius;
        let allowed = rounding(size, a.geometry.penetration, size / pair.radius) / (1.0 - depth.min(0.99));
        let error_allowed = rounding_of(&decks(1.0, 1.0, 1.0)[which], allowed);
        prop_assert!(error <= error_allowed, "{error:e}, allowed {allowed:e}");
        let energy = force * l;
        prop_assert!((b.forces.elastic_energy / energy / a.forces.elastic_energy - 1.0).abs() <= 4.0 * allowed);
    }
}
