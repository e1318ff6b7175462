// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a shape of a wall is, and what describes one.

use crate::contact::staged::WallSurface;
use crate::geometry::triangles::{Triangle, TriangleSearch};
use crate::geometry::Ellipsoid;
use crate::vector::Vector3;
use core::fmt::Debug;

/// A particle in the frame of a wall, before its axes are known.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ball {
    /// Index of the particle.
    pub particle: usize,
    /// Its centre.
    pub centre: Vector3,
    /// Radius of the ball about the centre that contains it.
    pub radius: f64,
}

/// A particle in the frame of a wall.
#[derive(Clone, Copy, Debug)]
pub struct Grain<'a> {
    /// Index of the particle.
    pub particle: usize,
    /// Its shape and axes.
    pub body: &'a Ellipsoid,
    /// Its centre.
    pub centre: Vector3,
}

impl Grain<'_> {
    /// The ball that contains it.
    pub fn ball(&self) -> Ball {
        Ball {
            particle: self.particle,
            centre: self.centre,
            radius: self.body.bounding_radius(),
        }
    }
}

/// What is called with a surface that a particle touches, and the index of the triangle that stands for it; 0 where a shape has
/// no triangles.
pub type Found<'a> = dyn FnMut(&WallSurface, usize) + 'a;

/// A surface that ellipsoids touch, in the frame of its wall.
pub trait Shape: Debug + Send + Sync {
    /// How many contacts of one particle are remembered at most; further ones act and start anew in each step.
    fn remembered(&self) -> usize;

    /// False only if a body within the ball cannot touch; cheap, and true where a number is not finite.
    fn may_touch(&self, ball: &Ball) -> bool;

    /// Marks the balls that may touch. As a function of the shape, so that the loop has no call in it.
    fn mark_near(&self, balls: &[Ball], marks: &mut [bool]) {
        for (ball, mark) in balls.iter().zip(marks) {
            *mark |= self.may_touch(ball);
        }
    }

    /// Calls `found` with the surface at every contact of a body, deepest first where there are several. The velocity of the
    /// surface is that in the frame of the wall: zero unless the shape itself moves.
    fn touch(&self, grain: &Grain<'_>, search: &mut Search, found: &mut Found<'_>);

    /// Its triangles; none for a surface that is not made of them, or that an engine lends.
    fn triangles(&self) -> &[Triangle] {
        &[]
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

impl Side {
    /// Whether a particle is within the shape; `centre_is` says whether its centre is.
    pub(super) fn is_within(self, centre_is: impl FnOnce() -> bool) -> bool {
        match self {
            Side::Inside => true,
            Side::Outside => false,
            Side::OfCentre => centre_is(),
        }
    }

    /// Whether a ball of this radius may touch whose centre lies by `outwards` outside the surface; true for NaN.
    pub(super) fn may_touch(self, outwards: f64, radius: f64) -> bool {
        !match self {
            Side::Inside => outwards <= -radius,
            Side::Outside => outwards >= radius,
            Side::OfCentre => outwards.abs() >= radius,
        }
    }
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
