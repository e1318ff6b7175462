// SPDX-License-Identifier: MIT OR Apache-2.0
//! By how much of the law a surface acts on a body, where several divide one contact among them (`facet_shares.rs`).

use crate::vector::Vector3;

/// The share of a plane in a body's contact, and its gradient.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Share {
    /// Between 0 and 1.
    pub value: f64,
    /// Gradient along the body's position, 1/length, world frame.
    pub by_position: Vector3,
    /// Gradient along the body's rotation about its centre, 1/radian, world frame.
    pub by_rotation: Vector3,
}

impl Share {
    /// That of a plane alone.
    pub const WHOLE: Share = Share {
        value: 1.0,
        by_position: Vector3::ZERO,
        by_rotation: Vector3::ZERO,
    };
    /// None of it.
    pub(super) const NONE: Share = Share {
        value: 0.0,
        ..Share::WHOLE
    };
}

impl Share {
    /// A share of a share.
    pub(super) fn times(&self, part: &Share) -> Share {
        let both = |a: Vector3, b: Vector3| a * part.value + b * self.value;
        Share {
            value: self.value * part.value,
            by_position: both(self.by_position, part.by_position),
            by_rotation: both(self.by_rotation, part.by_rotation),
        }
    }

    /// Two parts together.
    pub(super) fn plus(&self, other: &Share) -> Share {
        Share {
            value: self.value + other.value,
            by_position: self.by_position + other.by_position,
            by_rotation: self.by_rotation + other.by_rotation,
        }
    }

    /// What is left of the whole.
    pub(super) fn complement(&self) -> Share {
        Share {
            value: 1.0 - self.value,
            by_position: -self.by_position,
            by_rotation: -self.by_rotation,
        }
    }
}
