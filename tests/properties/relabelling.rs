// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does it matter how the axes of a body are called, or how its rotation is written?

use crate::support::scene::{
    advance, difference, laws, quaternion, rotation, rounding, rounding_of, size, Felt, Memory,
    Rotation, Vector,
};
use crate::support::strategies::{deck, touching_pair, TouchingPair};
use ellgran::contact::Body;
use nalgebra::Matrix3;
use proptest::prelude::*;

/// The same body with its axes renamed: all 24 rotations of the cube.
fn renamed(b: &Body, which: usize) -> Body {
    let permutations = [
        [0, 1, 2],
        [1, 2, 0],
        [2, 0, 1],
        [0, 2, 1],
        [2, 1, 0],
        [1, 0, 2],
    ];
    let order = permutations[which % 6];
    let signs = which / 6 % 4;
    let column = |k: usize| {
        let sign = if signs >> k & 1 == 1 { -1.0 } else { 1.0 };
        Vector::ith(order[k], sign)
    };
    let (u, v) = (column(0), column(1));
    let m = Matrix3::from_columns(&[u, v, u.cross(&v)]);
    let turn = Rotation::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(m));
    Body {
        semi_axes: order.map(|k| b.semi_axes[k]),
        quaternion: quaternion(rotation(b.quaternion) * turn),
        ..*b
    }
}

fn twice(pair: &TouchingPair, i: &Body, j: &Body, deck: &str) -> Felt {
    let laws = laws(&[deck]);
    let mut memory = Memory::new(&laws);
    let time_step = 1e-3 * pair.penetration;
    advance(&laws, i, j, time_step, &mut memory).expect("touching");
    advance(&laws, i, j, time_step, &mut memory).expect("touching")
}

fn hold(
    pair: &TouchingPair,
    i: &Body,
    j: &Body,
    deck: &str,
    exactly: bool,
) -> Result<(), TestCaseError> {
    let a = twice(pair, &pair.i, &pair.j, deck);
    let b = twice(pair, i, j, deck);
    let size = size(i, j);
    let allowed = if exactly {
        0.0
    } else {
        rounding_of(
            deck,
            rounding(size, a.geometry.penetration, size / pair.radius),
        )
    };
    let error = difference(&a, b.force, b.torque_i, b.torque_j, size);
    prop_assert!(error <= allowed, "{error:e}, allowed {allowed:e}");
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn renamed_axes(
        pair in touching_pair(10.0, 1e-5..0.3),
        deck in deck(),
        which in prop::array::uniform2(0usize..24),
    ) {
        let (i, j) = (renamed(&pair.i, which[0]), renamed(&pair.j, which[1]));
        hold(&pair, &i, &j, deck, false)?;
    }

    #[test]
    fn q_and_minus_q(pair in touching_pair(30.0, 1e-6..0.3), deck in deck()) {
        let mut i = pair.i;
        i.quaternion = i.quaternion.map(|q| -q);
        hold(&pair, &i, &pair.j, deck, true)?;
    }

    #[test]
    fn slightly_unnormalised_quaternions(
        pair in touching_pair(10.0, 1e-5..0.3),
        deck in deck(),
        factors in prop::array::uniform2(0.9..1.1f64),
    ) {
        let (mut i, mut j) = (pair.i, pair.j);
        i.quaternion = i.quaternion.map(|q| q * factors[0]);
        j.quaternion = j.quaternion.map(|q| q * factors[1]);
        hold(&pair, &i, &j, deck, false)?;
    }
}
