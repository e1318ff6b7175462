// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is there never attraction, unless it was asked for?

use crate::support::scene::{laws, touch};
use crate::support::strategies::touching_pair;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_attraction_at_any_speed(
        pair in touching_pair(10.0, 1e-5..0.3),
        damping in prop::sample::select(vec![
            "hertz 1e5 0.3 damping restitution 0.1",
            "hertz 1e5 0.3 damping relaxation 0.01 unloading first_order",
            "hertz 1e5 0.3 damping relaxation 0.01",
            "nfd 1e5 0.3 30 50",
            "lsd 1e3 300",
        ]),
        speed in -100.0..100.0f64,
    ) {
        let mut pair = pair;
        pair.i.velocity = [0.0; 3];
        pair.j.velocity = (pair.normal * speed).into();
        let f = touch(&laws(&[damping]), &pair.i, &pair.j).expect("touching");
        prop_assert!(f.forces.normal_force >= 0.0, "{}", f.forces.normal_force);
        // Ting's law needs no cut.
        if damping == "nfd 1e5 0.3 30 50" {
            let free = touch(&laws(&["nfd 1e5 0.3 30 50 limit_force no"]), &pair.i, &pair.j).expect("touching");
            prop_assert_eq!(free.forces.normal_force, f.forces.normal_force);
        }
    }

    #[test]
    fn receding_bodies_attract_when_asked_to(pair in touching_pair(10.0, 1e-5..0.3)) {
        let mut pair = pair;
        pair.i.velocity = [0.0; 3];
        pair.j.velocity = (pair.normal * 100.0).into();
        pair.i.angular_velocity = [0.0; 3];
        pair.j.angular_velocity = [0.0; 3];
        let deck = "hertz 1e5 0.3 damping relaxation 0.1 unloading first_order limit_force no";
        let f = touch(&laws(&[deck]), &pair.i, &pair.j).expect("touching");
        prop_assert!(f.forces.normal_force < 0.0);
    }
}
