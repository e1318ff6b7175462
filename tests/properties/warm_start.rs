// SPDX-License-Identifier: MIT OR Apache-2.0
//! Along a trajectory, does the search from the remembered normal find what the search from nothing finds?

use crate::support::random::Stream;
use crate::support::scene::{
    advance, body, laws, quaternion, rotation, size, touch, Memory, Rotation, Vector,
};

/// Random pairs fly through each other, turning, from apart through deep overlap to apart.
fn fly(aspect: f64, seed: u64, flights: usize) -> (usize, usize, f64) {
    let laws = laws(&["hertz 1e6 0.3"]);
    let mut stream = Stream::new(seed);
    let (mut steps, mut different, mut worst) = (0, 0, 0.0f64);
    for _ in 0..flights {
        let i = body(stream.semi_axes(aspect), Vector::zeros(), stream.rotation());
        let mut j = body(stream.semi_axes(aspect), Vector::zeros(), stream.rotation());
        let direction = stream.direction();
        let miss = stream.direction() * stream.uniform(0.0, 0.3);
        let spin = stream.direction() * stream.uniform(0.0, 0.02);
        let mut memory = Memory::new(&laws);
        let mut turn = rotation(j.quaternion);
        for k in 0..150 {
            let along = 1.5 * (1.0 - 2.0 * k as f64 / 149.0);
            j.position = (direction * along + miss).into();
            turn = Rotation::from_scaled_axis(spin) * turn;
            j.quaternion = quaternion(turn);
            let warm = advance(&laws, &i, &j, 1e-3, &mut memory);
            let cold = touch(&laws, &i, &j);
            steps += 1;
            let depth =
                |f: Option<crate::support::scene::Felt>| f.map_or(0.0, |f| f.geometry.penetration);
            assert_eq!(warm.is_some(), cold.is_some(), "{i:?} {j:?}");
            let (warm, cold) = (depth(warm), depth(cold));
            if (warm - cold).abs() > 1e-9 * warm.max(cold) + 64.0 * f64::EPSILON * size(&i, &j) {
                different += 1;
                worst = worst.max((warm - cold).abs() / warm.max(cold));
            }
        }
    }
    (steps, different, worst)
}

#[test]
fn warm_equals_cold_for_aspect_ratios_up_to_10() {
    let (steps, different, worst) = fly(10.0, 31, 80);
    println!("aspect ratio up to 10: {different} of {steps} steps differ, by up to {worst:.1e}");
    assert_eq!(different, 0);
}

#[test]
fn warm_equals_cold_for_aspect_ratios_up_to_100() {
    let (steps, different, worst) = fly(100.0, 32, 80);
    println!("aspect ratio up to 100: {different} of {steps} steps differ, by up to {worst:.1e}");
    assert_eq!(different, 0);
}

#[test]
fn warm_equals_cold_for_aspect_ratios_up_to_1000() {
    let (steps, different, worst) = fly(1000.0, 33, 40);
    println!("aspect ratio up to 1000: {different} of {steps} steps differ, by up to {worst:.1e}");
    assert_eq!(different, 0);
}
