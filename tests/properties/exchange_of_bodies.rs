// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does it matter which body is called `i`?

use crate::support::scene::{
    advance, difference, laws, rounding, rounding_of, size, vector, Memory, Vector,
};
use crate::support::strategies::{deck, touching_pair};
use ellgran::contact::Body;
use proptest::prelude::*;

fn moved(b: &Body, time: f64) -> Body {
    let mut b = *b;
    b.position = (Vector::from(b.position) + Vector::from(b.velocity) * time).into();
    b
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn exchanged_bodies_feel_the_same(
        pair in touching_pair(10.0, 1e-5..0.3),
        (deck_i, deck_j) in prop_oneof![
            deck().prop_map(|d| (d, d)),
            Just(("nfd 1e5 0.3 30 50 tangential tfd 0.3", "nfd 3e4 0.1 10 0 tangential tfd 0.7")),
            Just(("hertz 1e5 0.3 tangential mindlin 0.3", "hertz 3e7 0.5 tangential mindlin 0.7")),
        ],
    ) {
        let laws = laws(&[deck_i, deck_j]);
        let (i, mut j) = (pair.i, pair.j);
        j.particle_type = 2;
        let mut there = Memory::new(&laws);
        let mut back = Memory::new(&laws);
        let size = size(&i, &j);
        let time_step = 1e-3 * pair.penetration;
        for step in 0..4 {
            let (i, j) = (moved(&i, time_step * step as f64), moved(&j, time_step * step as f64));
            if step == 2 {
                // In the middle the engine turns the pair round.
                let mut swapped = Memory::new(&laws);
                swapped.touching = there.touching;
                laws.layout().swap(&there.history, &mut swapped.history);
                back = swapped;
            }
            let a = advance(&laws, &i, &j, time_step, &mut there).expect("touching");
            let b = advance(&laws, &j, &i, time_step, &mut back).expect("touching");
            let error = difference(&a, -b.force, b.torque_j, b.torque_i, size);
            let allowed = rounding(size, a.geometry.penetration, size / pair.radius);
            let error_allowed = rounding_of(deck_i, allowed);
            prop_assert!(error <= error_allowed, "step {step}: {error:e}, allowed {allowed:e}");
            prop_assert!((vector(a.geometry.normal) + vector(b.geometry.normal)).norm() <= allowed);
            prop_assert!((a.contact_point - b.contact_point).norm() <= allowed * size);
            prop_assert!(
                (a.forces.tangential_energy - b.forces.tangential_energy).abs()
                    <= allowed * a.forces.elastic_energy.max(a.forces.tangential_energy)
            );
        }
    }

    #[test]
    fn swapping_a_history_twice_gives_it_back(numbers in prop::collection::vec(-1.0..1.0f64, 7)) {
        let laws = laws(&["hertz 1e5 0.3 tangential mindlin 0.4"]);
        prop_assert_eq!(laws.layout().length, 7);
        let (mut once, mut twice) = (vec![0.0; 7], vec![0.0; 7]);
        laws.layout().swap(&numbers, &mut once);
        laws.layout().swap(&once, &mut twice);
        prop_assert_eq!(&numbers, &twice);
        prop_assert_ne!(&numbers, &once);
    }
}
