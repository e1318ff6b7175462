// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is the tangential force never above `mu F_n`?

use crate::support::scene::{advance, laws, Memory, Vector};
use crate::support::strategies::{touching_pair, vector};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn the_tangential_force_stays_in_the_cone_and_in_the_plane(
        pair in touching_pair(20.0, 1e-5..0.3),
        normal in prop::sample::select(vec!["hertz 1e5 0.3", "nfd 1e5 0.3 30 50", "hertz 1e5 0.3 damping restitution 0.4"]),
        tangential in prop::sample::select(vec!["tfd", "mindlin", "linear 1e4 100"]),
        displacement in prop::sample::select(vec!["total", "incremental", "rescaled"]),
        friction in 0.0..2.0f64,
        time_step in (1e-8f64.ln())..0.0,
        motions in prop::collection::vec(vector(10.0), 6),
    ) {
        let laws = laws(&[&format!("{normal} tangential {tangential} {friction} displacement {displacement}")]);
        let mut memory = Memory::new(&laws);
        let mut pair = pair;
        for v in motions {
            pair.j.velocity = v.into();
            pair.i.angular_velocity = Vector::new(v.y, -v.z, v.x).into();
            let f = advance(&laws, &pair.i, &pair.j, time_step.exp(), &mut memory).expect("touching");
            let limit = friction * f.forces.normal_force.max(0.0);
            prop_assert!(
                f.tangential.norm() <= limit * (1.0 + 1e-12),
                "{} above {limit}", f.tangential.norm()
            );
            prop_assert!(f.tangential.dot(&f.normal).abs() <= 1e-12 * limit + 1e-300);
        }
    }

    /// Steady sliding ends on the cone, against the motion.
    #[test]
    fn steady_sliding_reaches_the_limit(
        pair in touching_pair(5.0, 1e-3..0.1),
        tangential in prop::sample::select(vec!["tfd", "mindlin"]),
        friction in 0.05..1.0f64,
    ) {
        let laws = laws(&[&format!("hertz 1e5 0.3 tangential {tangential} {friction}")]);
        let mut memory = Memory::new(&laws);
        let mut pair = pair;
        let n = pair.normal;
        let slide = (Vector::new(0.3, -0.8, 0.5) - n * n.dot(&Vector::new(0.3, -0.8, 0.5))).normalize();
        pair.i.velocity = [0.0; 3];
        pair.i.angular_velocity = [0.0; 3];
        pair.j.angular_velocity = [0.0; 3];
        pair.j.velocity = slide.into();
        let mut last = None;
        for _ in 0..40 {
            last = advance(&laws, &pair.i, &pair.j, pair.penetration, &mut memory);
        }
        let f = last.expect("touching");
        prop_assert!((f.tangential.norm() / (friction * f.forces.normal_force) - 1.0).abs() < 1e-9);
        prop_assert!(f.tangential.dot(&slide) < 0.0);
    }
}
