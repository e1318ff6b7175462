// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a shape of a wall is, and what describes one.

use crate::contact::staged::WallSurface;
use crate::geometry::triangles::{Triangle, TriangleSearch};
use crate::geometry::Ellipsoid;
use crate::vector::Vector3;
use core::fmt::Debug;

/// A surface that ellipsoids touch, in the frame of its wall.
pub trait Shape: Debug + Send + Sync {
    /// How many contacts of one particle are remembered at most; further ones act and start anew in each step.
    fn remembered(&self) -> usize;

    /// False only if a body within the ball about `centre` cannot touch; cheap, and true where a number is not finite.
    fn may_touch(&self, centre: Vector3, radius: f64) -> bool;

    /// Calls `found` with the surface at every contact of a body, deepest first where there are several. The surface is at
    /// rest.
    fn touch(
        &self,
        body: &Ellipsoid,
        centre: Vector3,
        search: &mut Search,
        found: &mut dyn FnMut(WallSurface),
    );

    /// Its triangles; none for a surface that is not made of them.
    fn triangles(&self) -> &[Triangle] {
        &[]
    }

    /// Which of its triangles stands for a contact that the last call of [`Shape::touch`] found, counted from the first.
    fn touched_triangle(&self, _: &Search, _contact: usize) -> Option<usize> {
        None
    }
}

/// Memory for the searches of all shapes, kept between calls.
#[derive(Debug, Default)]
pub struct Search {
    /// Contacts with triangles.
    pub triangles: TriangleSearch,
    /// Triangles near a body, by their index in the mesh.
    pub near: Vec<u32>,
    /// Their corners.
    pub corners: Vec<Triangle>,
}

/// On which side of a surface the particles are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// On the side of a particle's centre.
    OfCentre,
    /// Within the shape; for a plane, on the side of its normal.
    Inside,
    /// Outside the shape; for a plane, on the side opposite to its normal.
    Outside,
}

/// How a cylinder or cone ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Nowhere, or where another part goes on: the surface has no edge there.
    None,
    /// In an edge: particles pass through, and over the edge.
    Open,
    /// In a flat disc.
    Closed,
}

/// What describes the shapes of the table. What a shape does not need is not read.
#[derive(Clone, Copy, Debug)]
pub struct ShapeParameters {
    /// A point of a plane, the centre of a sphere, a point of the axis of a cylinder or a cone.
    pub point: Vector3,
    /// Normal of a plane, axis of a cylinder or a cone; unit vector.
    pub axis: Vector3,
    /// Radius of a sphere or a cylinder, the first; those of a cone at its two bounds.
    pub radii: [f64; 2],
    /// Where a cylinder or a cone begins and ends, along the axis from `point`.
    pub bounds: [f64; 2],
    /// How it ends there.
    pub ends: [End; 2],
    /// Where the particles are.
    pub side: Side,
}
