// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which triangles may a particle touch, and what is a contact with them for the law?

use super::plane::flat;
use super::shape::Grain;
use crate::contact::staged::WallSurface;
use crate::geometry::box_tree::Extent;
use crate::geometry::triangle::plane_comes_into;
use crate::geometry::triangle_places::REACH;
use crate::geometry::triangles::{Feature, Triangle, TriangleContact};
use crate::vector::Vector3;

/// A search may ask for a place that is larger than the particle by this share of its radius: twice the margin within which triangles count as
/// joined ([`place_of`]), for rounding.
pub(super) const MARGIN: f64 = 2e-4;

/// The radius in which triangles are looked for by the ball around a particle.
#[inline(always)]
pub(super) fn reach_of_ball(radius: f64) -> f64 {
    radius * (1.0 + MARGIN)
}

/// What may reach into a ball.
#[derive(Clone, Copy, Debug)]
pub(super) struct InBall {
    pub(super) extent: Extent,
    centre: Vector3,
    reach: f64,
}

impl InBall {
    /// Of a ball.
    #[inline(always)]
    pub(super) fn new(centre: Vector3, radius: f64) -> Self {
        InBall {
            extent: Extent::about(centre.to_array(), radius),
            centre,
            reach: reach_of_ball(radius),
        }
    }

    /// Whether a triangle whose box overlaps that of the ball may.
    #[inline(always)]
    pub(super) fn may_have(&self, triangle: &Triangle) -> bool {
        plane_comes_into(triangle, self.centre, self.reach)
    }
}

/// The box in which triangles are looked at for a body. More than the body's own: corners act from a little outside, and triangles that meet
/// within a hundred-thousandth of its size count as joined.
#[inline(always)]
pub(super) fn place_of(grain: &Grain<'_>) -> Extent {
    let body = grain.body;
    let margin = 1e-4 * body.smallest_semi_axis();
    let reach = [
        Vector3::new(1.0, 0.0, 0.0),
        Vector3::new(0.0, 1.0, 0.0),
        Vector3::new(0.0, 0.0, 1.0),
    ]
    .map(|e| REACH * body.support(e).h + margin);
    let c = grain.centre.to_array();
    Extent {
        low: core::array::from_fn(|k| c[k] - reach[k]),
        high: core::array::from_fn(|k| c[k] + reach[k]),
    }
}

/// What a contact with triangles is for the law: an edge or a corner is taken as flat.
pub(super) fn surface(c: &TriangleContact) -> WallSurface {
    let face = WallSurface {
        share: c.share,
        ..flat(c.point, c.normal)
    };
    match c.feature {
        Feature::Face => face,
        Feature::Edge(along) => WallSurface {
            direction: along.cross(c.normal),
            turning_radii: [0.0, f64::INFINITY],
            ..face
        },
        Feature::Corner => WallSurface {
            turning_radii: [0.0; 2],
            ..face
        },
    }
}
