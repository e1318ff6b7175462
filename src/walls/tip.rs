// SPDX-License-Identifier: MIT OR Apache-2.0
//! The point in which a cone ends whose radius becomes 0.
//!
//! As a corner of a mesh it acts with the normal along which a body that contains it is least deep, if that normal points away from the whole
//! of the side. Where the side goes over into it, place and normal are the same.

use super::plane::flat;
use super::shape::{Ball, Grain};
#[cfg(feature = "std")]
use super::shape::{Block, Found, Search, Shape};
use crate::contact::staged::WallSurface;
use crate::geometry::interior_point::normal_towards;
#[cfg(not(feature = "std"))]
use crate::real::Real;
use crate::vector::Vector3;

/// The tip of a cone.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Tip {
    point: Vector3,
    /// Along the axis, out of the cone.
    out: Vector3,
    /// By how much the radius grows away from the tip, > 0.
    slope: f64,
}

/// Sine of an angle that counts as none, as at a rim.
const TOLERANCE: f64 = 1e-9;

impl Tip {
    pub(super) fn new(point: Vector3, out: Vector3, slope: f64) -> Self {
        Tip { point, out, slope }
    }

    fn is_far(&self, centre: Vector3, radius: f64) -> bool {
        (centre - self.point).norm_squared() >= radius * radius
    }

    /// How deep it is in a body, less than 0 beside it, and the surface that it is to the body, if the normal points away from the side.
    pub(super) fn place(&self, grain: &Grain<'_>) -> Option<(f64, WallSurface)> {
        let Grain { body, centre, .. } = *grain;
        let offset = self.point - centre;
        let n = normal_towards(body.semi_axes.to_array(), body.to_body(offset).to_array());
        let n = body.to_world(Vector3::from_array(n)).normalised();
        let along = -n.dot(self.out);
        let across = (n + self.out * along).norm();
        let surface = WallSurface {
            turning_radii: [0.0; 2],
            ..flat(self.point, -n)
        };
        let depth = body.support(n).h - n.dot(offset);
        // of all lines of the side the nearest to the normal
        let is_away = across * self.slope <= along + TOLERANCE * (1.0 + self.slope);
        is_away.then_some((depth, surface))
    }

    /// As `Shape::may_touch`.
    #[inline(always)]
    pub(super) fn is_near(&self, ball: &Ball) -> bool {
        !self.is_far(ball.centre, ball.radius)
    }

    /// As `Shape::touch`.
    pub(super) fn contacts(&self, grain: &Grain<'_>, mut found: impl FnMut(&WallSurface)) {
        if let Some((_, surface)) = self.place(grain).filter(|(depth, _)| *depth > 0.0) {
            found(&surface);
        }
    }
}

#[cfg(feature = "std")]
impl Tip {
    /// Where it is.
    pub(super) fn point(&self) -> Vector3 {
        self.point
    }
}

#[cfg(feature = "std")]
impl Shape for Tip {
    fn remembered(&self) -> usize {
        1
    }

    fn may_touch(&self, ball: &Ball) -> bool {
        self.is_near(ball)
    }

    fn may_touch_block(&self, block: &Block) -> bool {
        !self.is_far(block.centre(), block.radius() + block.half_edges().norm())
    }

    fn touch(&self, grain: &Grain<'_>, _: &mut Search, found: &mut Found<'_>) {
        self.contacts(grain, |surface| found(surface, 0));
    }
}
