// SPDX-License-Identifier: MIT OR Apache-2.0
//! A plane, or a disc of it, as a wall.

use super::shape::{Ball, Grain, Side};
#[cfg(feature = "std")]
use super::shape::{Block, Found, Search, Shape, ShapeInLanes, ShapeParameters, WholePlane};
use crate::contact::staged::WallSurface;
use crate::geometry::share::Share;
use crate::geometry::Plane;
#[cfg(not(feature = "std"))]
use crate::real::Real;
use crate::vector::{Tangent, Vector3};

/// A plane, or a disc of it.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct PlaneWall {
    plane: Plane,
    both_sides: bool,
    /// Radius of the disc about the plane's point; infinite for the whole plane.
    radius: f64,
    /// Any unit vector in it.
    direction: Vector3,
}

impl PlaneWall {
    /// A disc that acts on the side of its normal, or on that of a particle's centre.
    pub(super) fn disc(centre: Vector3, normal: Vector3, radius: f64, both_sides: bool) -> Self {
        PlaneWall {
            plane: Plane {
                point: centre,
                normal,
            },
            both_sides,
            radius,
            direction: Tangent::new(normal).u,
        }
    }

    /// Where the particles are that touch.
    fn side(&self) -> Side {
        if self.both_sides {
            Side::OfCentre
        } else {
            Side::Outside
        }
    }

    /// How deep a body lies behind the plane, on the side of its normal; 0 or less for one that does not reach it.
    pub(super) fn depth(&self, grain: &Grain<'_>) -> f64 {
        let Plane { point, normal } = self.plane;
        grain.body.support(-normal).h - normal.dot(grain.centre - point)
    }

    /// As `Shape::may_touch`.
    #[inline(always)]
    pub(super) fn is_near(&self, ball: &Ball) -> bool {
        let height = self.plane.normal.dot(ball.centre - self.plane.point);
        self.side().may_touch(height, ball.radius)
    }

    /// As `Shape::touch`.
    pub(super) fn contacts(&self, grain: &Grain<'_>, mut found: impl FnMut(&WallSurface)) {
        let Grain { body, centre, .. } = *grain;
        let mut plane = self.plane;
        if self.both_sides && plane.normal.dot(centre - plane.point) < 0.0 {
            plane.normal = -plane.normal;
        }
        let inwards = -plane.normal;
        let support = body.support(inwards);
        let penetration = support.h - plane.normal.dot(centre - plane.point);
        if penetration > 0.0 {
            let point = centre + support.point - inwards * penetration;
            if self.radius == f64::INFINITY || (point - plane.point).norm() <= self.radius {
                found(&flat_along(point, plane.normal, self.direction));
            }
        }
    }
}

#[cfg(feature = "std")]
pub(super) fn add(p: &ShapeParameters, parts: &mut Vec<Box<dyn Shape>>) -> Result<(), String> {
    let normal = if p.side == Side::Outside {
        -p.axis
    } else {
        p.axis
    };
    let both_sides = p.side == Side::OfCentre;
    parts.push(Box::new(PlaneWall::disc(
        p.point,
        normal,
        f64::INFINITY,
        both_sides,
    )));
    Ok(())
}

/// A flat surface with this deepest point and this normal towards the body, at rest.
pub(super) fn flat(point: Vector3, normal: Vector3) -> WallSurface {
    flat_along(point, normal, Tangent::new(normal).u)
}

/// The same, with this unit vector along it.
pub(super) const fn flat_along(point: Vector3, normal: Vector3, direction: Vector3) -> WallSurface {
    WallSurface {
        point,
        normal,
        direction,
        curvatures: [0.0; 2],
        turning_radii: [f64::INFINITY; 2],
        velocity: Vector3::ZERO,
        velocity_change: Vector3::ZERO,
        share: Share::WHOLE,
    }
}

#[cfg(feature = "std")]
impl Shape for PlaneWall {
    fn remembered(&self) -> usize {
        1
    }

    fn may_touch(&self, ball: &Ball) -> bool {
        self.is_near(ball)
    }

    fn may_touch_block(&self, block: &Block) -> bool {
        let normal = self.plane.normal;
        let height = normal.dot(block.centre() - self.plane.point);
        let half = block.half_edges();
        let spread = normal.x.abs() * half.x + normal.y.abs() * half.y + normal.z.abs() * half.z;
        self.side()
            .may_touch_block([height - spread, height + spread], block.radius())
    }

    fn in_lanes(&self) -> Option<ShapeInLanes> {
        let Plane { point, normal } = self.plane;
        (self.radius == f64::INFINITY).then_some(ShapeInLanes::Plane(WholePlane {
            point,
            normal,
            both_sides: self.both_sides,
        }))
    }

    fn touch(&self, grain: &Grain<'_>, _: &mut Search, found: &mut Found<'_>) {
        self.contacts(grain, |surface| found(surface, 0));
    }
}
