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

    /// So many times it.
    pub(super) fn scaled(&self, factor: f64) -> Share {
        Share {
            value: self.value * factor,
            by_position: self.by_position * factor,
            by_rotation: self.by_rotation * factor,
        }
    }

    /// A part of another.
    pub(super) fn over(&self, other: &Share) -> Share {
        let ratio = self.value / other.value;
        Share {
            value: ratio,
            by_position: (self.by_position - other.by_position * ratio) * (1.0 / other.value),
            by_rotation: (self.by_rotation - other.by_rotation * ratio) * (1.0 / other.value),
        }
    }

    /// From 0 to 1 where it goes from 0 to 1, with an even slope.
    pub(super) fn smoothed(&self) -> Share {
        let t = self.value.clamp(0.0, 1.0);
        let slope = 6.0 * t * (1.0 - t);
        Share {
            value: t * t * (3.0 - 2.0 * t),
            by_position: self.by_position * slope,
            by_rotation: self.by_rotation * slope,
        }
    }

    /// What is left of a part without another.
    pub(super) fn minus(&self, other: &Share) -> Share {
        Share {
            value: self.value - other.value,
            by_position: self.by_position - other.by_position,
            by_rotation: self.by_rotation - other.by_rotation,
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

#[cfg(all(test, feature = "std"))]
mod tests {
    use super::*;

    #[test]
    fn products_sums_and_complements_with_their_gradients() {
        let v = Vector3::new;
        let a = Share {
            value: 0.25,
            by_position: v(1.0, 2.0, -3.0),
            by_rotation: v(0.5, -1.0, 4.0),
        };
        let b = Share {
            value: 0.5,
            by_position: v(8.0, -4.0, 2.0),
            by_rotation: v(-2.0, 6.0, 1.0),
        };
        let same = |found: Share, value: f64, by_position: Vector3, by_rotation: Vector3| {
            assert_eq!(found.value, value);
            assert_eq!(found.by_position, by_position);
            assert_eq!(found.by_rotation, by_rotation);
        };
        same(a.times(&b), 0.125, v(2.5, 0.0, -1.0), v(-0.25, 1.0, 2.25));
        same(a.plus(&b), 0.75, v(9.0, -2.0, -1.0), v(-1.5, 5.0, 5.0));
        same(a.complement(), 0.75, v(-1.0, -2.0, 3.0), v(-0.5, 1.0, -4.0));
    }

    #[test]
    fn ratios_multiples_and_differences_with_their_gradients() {
        let at = |x: f64| Share {
            value: x * x,
            by_position: Vector3::new(2.0 * x, 0.0, 0.0),
            by_rotation: Vector3::new(0.0, -2.0 * x, 0.0),
        };
        let cube = |x: f64| Share {
            value: x * x * x + 1.0,
            by_position: Vector3::new(3.0 * x * x, 0.0, 0.0),
            by_rotation: Vector3::new(0.0, -3.0 * x * x, 0.0),
        };
        type Of<'a> = &'a dyn Fn(f64) -> Share;
        let all: [Of; 4] = [
            &|x| at(x).over(&cube(x)),
            &|x| at(x).scaled(0.4),
            &|x| at(x).minus(&cube(x)),
            &|x| at(x).smoothed(),
        ];
        let h = 1e-5;
        for of in all {
            for x in [0.2, 0.6, 0.9] {
                let slope = (of(x + h).value - of(x - h).value) / (2.0 * h);
                assert!((of(x).by_position.x - slope).abs() < 1e-8);
                assert!((of(x).by_rotation.y + slope).abs() < 1e-8);
            }
        }
        assert_eq!(at(0.5).scaled(-1.0).smoothed().value, 0.0);
        let full = at(1.5).smoothed();
        assert_eq!((full.value, full.by_position), (1.0, Vector3::ZERO));
    }
}
