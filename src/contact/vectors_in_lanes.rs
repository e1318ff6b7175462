// SPDX-License-Identifier: MIT OR Apache-2.0
//! Vectors in lanes: the same in every lane, or to each its own.

use crate::simd::{Lanes, Registers, MOST_LANES};
use crate::vector::Vector3;

/// One vector in all lanes.
#[inline(always)]
pub(crate) fn splat<S: Registers>(registers: S, v: Vector3) -> Vector3<Lanes<S>> {
    Vector3::new(
        Lanes::splat(registers, v.x),
        Lanes::splat(registers, v.y),
        Lanes::splat(registers, v.z),
    )
}

/// One number of all lanes.
pub(crate) type Column = [f64; MOST_LANES];
/// A vector of all lanes.
pub(crate) type Columns = [Column; 3];

/// The vectors of all lanes.
#[inline(always)]
pub(crate) fn load<S: Registers>(registers: S, columns: &Columns) -> Vector3<Lanes<S>> {
    Vector3::new(
        Lanes::load(registers, &columns[0]),
        Lanes::load(registers, &columns[1]),
        Lanes::load(registers, &columns[2]),
    )
}

/// Writes the vector of one lane.
#[inline(always)]
pub(crate) fn put_in_lane(columns: &mut Columns, lane: usize, v: Vector3) {
    columns[0][lane] = v.x;
    columns[1][lane] = v.y;
    columns[2][lane] = v.z;
}
