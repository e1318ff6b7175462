// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does the force begin at zero, and once?

use crate::support::scene::{advance, laws, pair_law, position, touch, Memory};
use crate::support::strategies::touching_pair;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Approach along the normal through first touch: nothing before it, and forces that vanish with the overlap as
    /// their law says (to the power 3/2 without damping, 1/2 with a relaxation time, 1/4 with a restitution).
    #[test]
    fn forces_vanish_with_the_penetration(
        pair in touching_pair(20.0, 1e-4..1e-3),
        (deck, power) in prop::sample::select(vec![
            ("hertz 1e5 0.3", 1.5),
            ("hertz 1e5 0.3 tangential tfd 0.3", 1.5),
            ("nfd 1e5 0.3 30 50", 0.5),
            ("nfd 1e5 0.3 30 50 tangential tfd 0.3", 0.5),
            ("hertz 1e5 0.3 damping restitution 0.5", 0.25),
            ("hertz 1e5 0.3 damping restitution 0.5 tangential mindlin 0.3", 0.25),
        ]),
    ) {
        let laws = laws(&[deck]);
        let law = pair_law(deck);
        let mut approaching = pair.clone();
        approaching.i.velocity = [0.0; 3];
        approaching.j.velocity = (-pair.normal).into();
        let at = |fraction: f64| {
            let mut j = approaching.j;
            // From `penetration` deep to `penetration * fraction` deep (negative: apart).
            j.position = (position(&j) + pair.normal * (pair.penetration * (1.0 - fraction))).into();
            advance(&laws, &approaching.i, &j, 0.0, &mut Memory::new(&laws)).map(|f| {
                (f.force.norm(), f.torque_i.norm().max(f.torque_j.norm()))
            })
        };
        for fraction in [-1.0, -1e-2, -1e-4] {
            prop_assert!(at(fraction).is_none(), "apart by {fraction}");
        }
        let (force, torque) = at(1.0).expect("touching");
        let mut last = force;
        for exponent in 1..=4 {
            let fraction = 10f64.powi(-exponent);
            let (f, t) = at(fraction).expect("touching");
            prop_assert!(f.is_finite() && f < last);
            let bound = 1.5 * fraction.powf(power);
            prop_assert!(f <= bound * force, "{f} at {fraction} of {force}, law {:?}", law.kinds);
            prop_assert!(t <= 2.0 * bound * torque.max(1e-3 * force));
            last = f;
        }
    }

    #[test]
    fn touching_changes_once_on_the_way_in(pair in touching_pair(20.0, 1e-3..0.3)) {
        let laws = laws(&["hertz 1e5 0.3"]);
        let mut changes = 0;
        let mut before = false;
        for k in -20..=20 {
            let mut j = pair.j;
            let fraction = k as f64 / 20.0;
            j.position = (position(&j) + pair.normal * (pair.penetration * (1.0 - fraction - 0.01))).into();
            let now = touch(&laws, &pair.i, &j).is_some();
            changes += i32::from(now != before);
            before = now;
        }
        prop_assert!(before && changes == 1, "{changes} changes");
    }
}
