// SPDX-License-Identifier: MIT OR Apache-2.0
//! Vectors that are the same in every lane.

use crate::simd::{Lanes, Registers};
use crate::vector::Vector3;

/// One vector in all lanes.
#[inline(always)]
pub(super) fn splat<S: Registers>(registers: S, v: Vector3) -> Vector3<Lanes<S>> {
    Vector3::new(
        Lanes::splat(registers, v.x),
        Lanes::splat(registers, v.y),
        Lanes::splat(registers, v.z),
    )
}
