// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a contact keep linear and angular momentum?

use crate::support::scene::{advance, force_scale, laws, position, size, Memory};
use crate::support::strategies::{deck, touching_pair, vector};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    /// The force on `i` is the opposite of that on `j`, so the torques must balance the couple of the two.
    #[test]
    fn torques_about_any_point_sum_to_zero(
        pair in touching_pair(30.0, 1e-6..0.3),
        deck in deck(),
        point in vector(2.0),
        time_step in 1e-7..1e-3f64,
    ) {
        let laws = laws(&[deck]);
        let mut memory = Memory::new(&laws);
        for _ in 0..3 {
            // The second and third time with a history.
            let Some(f) = advance(&laws, &pair.i, &pair.j, time_step, &mut memory) else {
                return Err(TestCaseError::fail("not touching"));
            };
            let about = |x: &ellgran::contact::Body| position(x) - point;
            let sum = about(&pair.i).cross(&-f.force)
                + f.torque_i
                + about(&pair.j).cross(&f.force)
                + f.torque_j;
            let scale = force_scale(&f) * (size(&pair.i, &pair.j) + point.norm());
            // The torque of the complete gradient balances where the normal is stationary: to rounding over the radius.
            let sharpness = size(&pair.i, &pair.j) / pair.radius;
            prop_assert!(
                sum.norm() <= 4.0 * f64::EPSILON * (16.0 + sharpness) * scale,
                "sum of torques {:e} of {:e}", sum.norm(), scale
            );
        }
    }
}
