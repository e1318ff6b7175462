// SPDX-License-Identifier: MIT OR Apache-2.0
//! An ellipsoid and a half-space: the common normal is known, so there is nothing to search.

use super::ellipsoid::{Ellipsoid, Support};
use crate::vector::{Tangent, Vector3};

/// A half-space.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Plane {
    /// A point of the surface, world frame.
    pub point: Vector3,
    /// Unit normal out of the wall, towards the particles, world frame.
    pub normal: Vector3,
}

/// The contact of body `i` with a plane (body `j`).
#[derive(Clone, Copy, Debug)]
pub struct PlaneContact {
    /// From the body to the wall: minus the wall's normal.
    pub normal: Vector3,
    /// Penetration (length); minus the gap when separated.
    pub penetration: f64,
    /// Support of the body towards the wall.
    pub support: Support,
    /// Tangent basis of `normal`.
    pub tangent: Tangent,
}

/// Penetration `h(-m) - m.(x - p)` of a body with centre `x` and the plane through `p` with normal `m`.
///
/// # Example
/// An ellipsoid that stands on its tip, 0.1 deep in the plane z = 0; lengths in any unit:
/// ```
/// use ellgran::geometry::{touch_plane, Ellipsoid, Plane};
/// use ellgran::vector::Vector3;
///
/// let body = Ellipsoid::new([1.0, 1.0, 2.0], [1.0, 0.0, 0.0, 0.0]).expect("semi-axes in range");
/// let floor = Plane { point: Vector3::ZERO, normal: Vector3::new(0.0, 0.0, 1.0) };
/// let found = touch_plane(&body, Vector3::new(0.0, 0.0, 1.9), &floor);
/// assert!((found.penetration - 0.1).abs() < 1e-15);
/// ```
pub fn touch_plane(body: &Ellipsoid, centre: Vector3, plane: &Plane) -> PlaneContact {
    let normal = -plane.normal;
    let support = body.support(normal);
    PlaneContact {
        normal,
        penetration: support.h - plane.normal.dot(centre - plane.point),
        support,
        tangent: Tangent::new(normal),
    }
}
