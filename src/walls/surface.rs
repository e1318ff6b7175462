// SPDX-License-Identifier: MIT OR Apache-2.0
//! The parts of a wall that have no memory of their own, as values: what a device has of them.

use super::cone::{ConeWall, ConvexSolid};
use super::plane::PlaneWall;
use super::rim::Rim;
#[cfg(feature = "std")]
use super::shape::Shape;
use super::shape::{Ball, Grain};
use super::sphere::SphereWall;
use super::tip::Tip;
use crate::contact::staged::WallSurface;
#[cfg(feature = "std")]
use core::any::Any;

/// A surface that ellipsoids touch, in the frame of its wall. Each is as long as the longest of them.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
#[repr(C)]
// They are in one array on a device.
#[allow(clippy::large_enum_variant)]
pub enum Surface {
    /// A plane, or a disc of it.
    Plane(PlaneWall),
    /// The side of a cylinder or a cone.
    Cone(ConeWall),
    /// A sphere.
    Sphere(SphereWall),
    /// An edge of a cylinder or a cone.
    Rim(Rim),
    /// The tip of a cone.
    Tip(Tip),
    /// A cylinder or a cone that is closed, from without.
    Solid(ConvexSolid),
}

impl Surface {
    /// A part of a wall, if it has no memory of its own.
    #[cfg(feature = "std")]
    pub(super) fn of(shape: &(dyn Shape + 'static)) -> Option<Surface> {
        let shape: &dyn Any = shape;
        macro_rules! first {
            ($($kind:ident: $type:ty;)*) => {
                $(if let Some(found) = shape.downcast_ref::<$type>() {
                    return Some(Surface::$kind(*found));
                })*
            };
        }
        first! {
            Plane: PlaneWall;
            Cone: ConeWall;
            Sphere: SphereWall;
            Rim: Rim;
            Tip: Tip;
            Solid: ConvexSolid;
        }
        None
    }

    /// False only if a body within the ball cannot touch; true where a number is not finite.
    #[doc(hidden)]
    pub fn is_near(&self, ball: &Ball) -> bool {
        match self {
            Surface::Plane(s) => s.is_near(ball),
            Surface::Cone(s) => s.is_near(ball),
            Surface::Sphere(s) => s.is_near(ball),
            Surface::Rim(s) => s.is_near(ball),
            Surface::Tip(s) => s.is_near(ball),
            Surface::Solid(s) => s.is_near(ball),
        }
    }

    /// Calls `found` with the surface at every contact of a body.
    #[doc(hidden)]
    pub fn contacts(&self, grain: &Grain<'_>, found: impl FnMut(&WallSurface)) {
        match self {
            Surface::Plane(s) => s.contacts(grain, found),
            Surface::Cone(s) => s.contacts(grain, found),
            Surface::Sphere(s) => s.contacts(grain, found),
            Surface::Rim(s) => s.contacts(grain, found),
            Surface::Tip(s) => s.contacts(grain, found),
            Surface::Solid(s) => s.contacts(grain, found),
        }
    }
}
