// SPDX-License-Identifier: MIT OR Apache-2.0
//! The circular edge where a cylinder or a cone ends.
//!
//! As an edge of a mesh it acts where the body is deepest along it, with the normal across it along which the body is least
//! deep, if that normal points away from the surfaces that end there. Where a surface goes over into the edge, place, normal
//! and curvature are the same.
//!
//! Such places are found from those beside them, whether or not the tangent there passes through the body: from inside of the circle the
//! tangents of a part of it as short as the root of the depth do.

use super::plane::flat;
use super::shape::{Ball, Grain};
#[cfg(feature = "std")]
use super::shape::{Block, Found, Search, Shape};
use crate::contact::staged::WallSurface;
use crate::geometry::nearest_line::towards_line;
use crate::geometry::Ellipsoid;
#[cfg(not(feature = "std"))]
use crate::real::{Functions, Real};
use crate::vector::{Tangent, Vector3};

/// The circular edge of a cylinder or a cone.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Rim {
    centre: Vector3,
    axis: Vector3,
    radius: f64,
    /// Directions of the surfaces that end here, from the edge inwards, along radius and axis; of one alone, twice.
    surfaces: [[f64; 2]; 2],
}

/// Sine of an angle that counts as none: ten times the rounding of a normal at the largest aspect ratio, 1000, whose square is lost in digits
/// (1e6 times 1e-16). An edge that acts at such an angle beyond its surface pushes as the surface does.
const TOLERANCE: f64 = 1e-9;
/// Places that are tried along the edge, at least and at most. Eight more for each time that the body is longer than thick leave a quarter of the
/// smallest semi-axis between two of them on an edge that is at most twice the largest long in the body: much less than the body is
/// thick. At most 512, which aspect ratio 62 has.
const LEAST_PLACES: usize = 16;
const MOST_PLACES: usize = 512;

impl Rim {
    /// The circle about `axis`, with the directions of the surfaces that end in it.
    pub(super) fn new(
        centre: Vector3,
        axis: Vector3,
        radius: f64,
        surfaces: [[f64; 2]; 2],
    ) -> Self {
        let unit = |d: [f64; 2]| {
            let length = d[0].hypot(d[1]);
            [d[0] / length, d[1] / length]
        };
        Rim {
            centre,
            axis,
            radius,
            surfaces: surfaces.map(unit),
        }
    }
}

#[cfg(feature = "std")]
impl Rim {
    /// Its middle and its radius.
    pub(super) fn circle(&self) -> (Vector3, f64) {
        (self.centre, self.radius)
    }
}

/// What a body does to the edge at one place.
pub(super) struct Place {
    normal: Vector3,
    point: Vector3,
    /// Along the radius, outwards.
    radial: Vector3,
    /// How deep the tangent is in the body; less than 0 beside it.
    pub depth: f64,
    /// How far ahead along the edge's tangent the body is deepest.
    ahead: f64,
}

impl Place {
    /// Whether the edge itself is in the body. One that is less thick than the tangent is deep may be apart from it.
    fn is_in(&self, body: &Ellipsoid) -> bool {
        let seen = body
            .inverse_semi_axes
            .componentwise(body.to_body(self.point));
        seen.norm_squared() < 1.0
    }
}

impl Rim {
    /// Calls `found` with each place within `reach` of the body in which it is deepest along the edge, or nearest to it where it is beside
    /// the tangent, by no more than `gap`, if the normal points away from the surfaces.
    pub(super) fn places(
        &self,
        grain: &Grain<'_>,
        reach: f64,
        gap: f64,
        mut found: impl FnMut(&Place),
    ) {
        let Grain { body, centre, .. } = *grain;
        let offset = centre - self.centre;
        let x = offset - self.axis * self.axis.dot(offset);
        let distance = x.norm();
        let Tangent { u, v } = Tangent::towards(offset, self.axis);
        let basis = [u, v];
        // the arc of the edge within the body's reach
        let square = offset.norm_squared() + self.radius * self.radius - reach * reach;
        let cosine = square / (2.0 * distance * self.radius);
        if cosine >= 1.0 {
            return;
        }
        let half = if cosine.is_nan() {
            core::f64::consts::PI
        } else {
            cosine.max(-1.0).acos()
        };
        let slenderness = reach / body.smallest_semi_axis();
        let count = (LEAST_PLACES + (8.0 * slenderness) as usize).min(MOST_PLACES);
        let step = 2.0 * half / count as f64;
        let at = |k: usize| -half + (k as f64 - 0.5) * step;
        let place = |angle: f64| self.place(body, offset, &basis, angle);
        // Half a step beyond either end of the arc, or once around.
        let is_whole = half == core::f64::consts::PI;
        let steps = if is_whole { count } else { count + 1 };
        let first = place(at(0));
        let mut before = (first.ahead, first.depth);
        for k in 1..=steps {
            let here = if is_whole && k == steps {
                (first.ahead, first.depth)
            } else {
                let here = place(at(k));
                (here.ahead, here.depth)
            };
            // Behind a contact the body is deepest ahead, and beyond it behind. The depth changes with the angle by the way ahead at most,
            // and that is less than two of the reach.
            if before.1 > -gap - 2.0 * reach * step && before.0 > 0.0 && here.0 <= 0.0 {
                let (mut low, mut high) = (at(k - 1), at(k));
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if place(middle).ahead > 0.0 {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                let deepest = place(0.5 * (low + high));
                let (out, along) = self.components(&deepest);
                let outermost = |[r, a]: &[f64; 2]| out * r + along * a <= TOLERANCE;
                // else the normal jumps there, in the middle of the body
                let is_still = deepest.ahead.abs() <= 1e-9 * body.bounding_radius();
                if is_still && self.surfaces.iter().all(outermost) {
                    found(&deepest);
                }
            }
            before = here;
        }
    }

    /// Of the normal, along the radius and along the axis.
    fn components(&self, place: &Place) -> (f64, f64) {
        (place.normal.dot(place.radial), place.normal.dot(self.axis))
    }

    pub(super) fn surface_at(&self, grain: &Grain<'_>, place: &Place) -> WallSurface {
        let (out, _) = self.components(place);
        WallSurface {
            direction: self.axis.cross(place.radial),
            curvatures: [out / self.radius, 0.0],
            turning_radii: [self.radius / out, 0.0],
            ..flat(grain.centre + place.point, place.normal)
        }
    }

    fn place(&self, body: &Ellipsoid, offset: Vector3, basis: &[Vector3; 2], angle: f64) -> Place {
        let (sin, cos) = angle.sin_cos();
        let radial = basis[0] * cos + basis[1] * sin;
        let tangent = self.axis.cross(radial);
        // from the body's centre
        let point = radial * self.radius - offset;
        let n = towards_line(body, point, tangent);
        let support = body.support(n);
        Place {
            normal: -n,
            point,
            radial,
            depth: support.h - n.dot(point),
            ahead: tangent.dot(support.point - point),
        }
    }

    /// As `Shape::may_touch`.
    #[inline(always)]
    pub(super) fn is_near(&self, ball: &Ball) -> bool {
        let Ball { centre, radius, .. } = *ball;
        let offset = centre - self.centre;
        let along = self.axis.dot(offset);
        let across = (offset - self.axis * along).norm() - self.radius;
        !(across * across + along * along >= radius * radius)
    }

    /// As `Shape::touch`.
    pub(super) fn contacts(&self, grain: &Grain<'_>, mut found: impl FnMut(&WallSurface)) {
        let ball = grain.ball();
        if self.is_near(&ball) {
            self.places(grain, ball.radius, 0.0, |place| {
                if place.depth > 0.0 && place.is_in(grain.body) {
                    found(&self.surface_at(grain, place));
                }
            });
        }
    }
}

#[cfg(feature = "std")]
impl Shape for Rim {
    fn remembered(&self) -> usize {
        2
    }

    fn may_touch(&self, ball: &Ball) -> bool {
        self.is_near(ball)
    }

    fn may_touch_block(&self, block: &Block) -> bool {
        let radius = block.radius() + block.half_edges().norm();
        self.may_touch(&Ball {
            particle: 0,
            centre: block.centre(),
            radius,
        })
    }

    fn touch(&self, grain: &Grain<'_>, _: &mut Search, found: &mut Found<'_>) {
        self.contacts(grain, |surface| found(surface, 0));
    }
}
