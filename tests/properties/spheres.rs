// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do spheres feel the closed form, and near-spheres nearly so?

use crate::support::scene::{body, laws, touch, Rotation, Vector};
use crate::support::strategies::{direction, turn};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn two_spheres_follow_hertz(
        radii in prop::array::uniform2(0.01..1.0f64),
        direction in direction(),
        turns in prop::array::uniform2(turn()),
        depth in (1e-6f64.ln())..(0.3f64.ln()),
        moduli in prop::array::uniform2(1e4..1e9f64),
        ratios in prop::array::uniform2(-0.5..0.5f64),
    ) {
        let [ri, rj] = radii;
        let delta = depth.exp() * ri.min(rj);
        let decks = [0, 1].map(|k| format!("hertz {:e} {:e}", moduli[k], ratios[k]));
        let laws = laws(&[&decks[0], &decks[1]]);
        let i = body([ri; 3], Vector::zeros(), turns[0]);
        let mut j = body([rj; 3], direction * (ri + rj - delta), turns[1]);
        j.particle_type = 2;
        let f = touch(&laws, &i, &j).expect("touching");
        let rounding = 8.0 * f64::EPSILON * (ri + rj) / delta;
        let compliance: f64 = (0..2).map(|k| (1.0 - ratios[k] * ratios[k]) / moduli[k]).sum();
        let re = ri * rj / (ri + rj);
        let wanted = 4.0 / 3.0 / compliance * re.sqrt() * delta.powf(1.5);
        prop_assert!((f.force - direction * wanted).norm() <= (2.0 * rounding + 1e-13) * wanted);
        prop_assert!(f.torque_i.norm().max(f.torque_j.norm()) <= 1e-13 * wanted * (ri + rj));
        prop_assert!((f.geometry.penetration / delta - 1.0).abs() <= rounding);
        prop_assert!((f.geometry.curvature_a * 2.0 * re - 1.0).abs() < 1e-13);
        prop_assert!((f.geometry.curvature_b * 2.0 * re - 1.0).abs() < 1e-13);
        prop_assert!((f.forces.elastic_energy / (0.4 * wanted * delta) - 1.0).abs() <= 3.0 * rounding + 1e-13);
    }

    /// The sphere's own path and the general one meet.
    #[test]
    fn a_hair_from_a_sphere(
        hair in prop::array::uniform3(-1e-9..1e-9f64),
        direction in direction(),
        turn in turn(),
        depth in 1e-3..0.3f64,
    ) {
        let laws = laws(&["hertz 1e6 0.3"]);
        let j = body([1.0; 3], direction * (2.0 - depth), Rotation::identity());
        let round = touch(&laws, &body([1.0; 3], Vector::zeros(), turn), &j).expect("touching");
        let near = touch(&laws, &body(hair.map(|h| 1.0 + h), Vector::zeros(), turn), &j).expect("touching");
        prop_assert!((round.force - near.force).norm() < 2e-8 / depth * round.force.norm());
        prop_assert!((round.torque_i - near.torque_i).norm() < 2e-8 * round.force.norm());
    }
}
