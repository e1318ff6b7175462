// SPDX-License-Identifier: MIT OR Apache-2.0
//! Grains that press on each other and on the walls of their box, as both engines get them.

use super::scene::{Grain, Scene};
use super::shapes::{scale, Random};

/// The edge of the cubic cell of each grain.
pub const CELL: f64 = 1e-2;

/// So many grains along each edge of a box of planes through the origin, of two sizes and some motion, that touch their neighbours and the
/// walls.
pub fn pressed(side: usize, speed: f64) -> Scene {
    let mut random = Random(11);
    let mut grains = vec![];
    for k in 0..side.pow(3) {
        let place = [k % side, k / side % side, k / side / side].map(|c| c as f64 + 0.5);
        let mut axes = [5.3e-3, 5.1e-3, 5e-3];
        axes.rotate_left(k % 3);
        grains.push(
            Grain {
                density: if k % 4 == 0 { 2500.0 } else { 1000.0 },
                ..Grain::new(axes, scale(CELL, place)).turned(random.quaternion())
            }
            .moving(scale(speed, random.direction())),
        );
    }
    let edge = side as f64 * CELL;
    Scene {
        boundary: "f f f".into(),
        ..Scene::periodic([-CELL; 3], [edge + CELL; 3], grains)
    }
}
