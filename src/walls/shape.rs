// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a shape of a wall is, and what describes one.

#[cfg(feature = "std")]
use super::motion::Motion;
#[cfg(feature = "std")]
use crate::contact::staged::WallSurface;
#[cfg(feature = "std")]
use crate::geometry::box_tree::Extent;
use crate::geometry::cone::Cone;
#[cfg(feature = "std")]
use crate::geometry::triangles::{Triangle, TriangleSearch};
use crate::geometry::Ellipsoid;
#[cfg(feature = "std")]
use crate::simd::Line;
use crate::vector::Vector3;
#[cfg(feature = "std")]
use core::any::Any;
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

/// Some particles in the frame of a wall: a box about their centres, and the largest of their radii.
#[cfg(feature = "std")]
#[derive(Clone, Copy, Debug)]
pub struct Block {
    low: Vector3,
    high: Vector3,
    radius: f64,
    /// Whether all numbers are finite.
    finite: bool,
}

#[cfg(feature = "std")]
impl Block {
    /// Without particles.
    pub(super) const EMPTY: Block = Block {
        low: Vector3 {
            x: f64::INFINITY,
            y: f64::INFINITY,
            z: f64::INFINITY,
        },
        high: Vector3 {
            x: f64::NEG_INFINITY,
            y: f64::NEG_INFINITY,
            z: f64::NEG_INFINITY,
        },
        radius: 0.0,
        finite: true,
    };

    /// With particles that have to be looked at one by one.
    pub(super) const UNKNOWN: Block = Block {
        finite: false,
        ..Block::EMPTY
    };

    /// Together with another.
    pub(super) fn with(&self, other: &Block) -> Self {
        let (a, b) = (self, other);
        let (low, high) = (a.low, a.high);
        Block {
            low: Vector3::new(low.x.min(b.low.x), low.y.min(b.low.y), low.z.min(b.low.z)),
            high: Vector3::new(
                high.x.max(b.high.x),
                high.y.max(b.high.y),
                high.z.max(b.high.z),
            ),
            radius: a.radius.max(b.radius),
            finite: a.finite && b.finite,
        }
    }

    /// Of some particles.
    pub(super) fn of(balls: &[Ball]) -> Self {
        // The smaller of two as the processor has it, which does not ask for numbers that are none.
        let less = |a: f64, b: f64| if a < b { a } else { b };
        let more = |a: f64, b: f64| if a > b { a } else { b };
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        // Not finite where one of the numbers is not.
        let (mut radius, mut sum) = (0.0, 0.0);
        for ball in balls {
            let x = ball.centre.to_array();
            for k in 0..3 {
                low[k] = less(x[k], low[k]);
                high[k] = more(x[k], high[k]);
            }
            radius = more(ball.radius, radius);
            sum += x[0] + x[1] + x[2] + ball.radius;
        }
        Block {
            low: Vector3::from_array(low),
            high: Vector3::from_array(high),
            radius,
            finite: f64::is_finite(sum),
        }
    }

    /// Of particles with these centres in the world, none with a radius greater than this one.
    pub(super) fn of_centres(centres: &[[f64; 3]], radius: f64) -> Self {
        let less = |a: f64, b: f64| if a < b { a } else { b };
        let more = |a: f64, b: f64| if a > b { a } else { b };
        // Four centres at a time, number by number: the loop then needs no lanes of its own.
        let (mut low, mut high) = ([f64::INFINITY; 12], [f64::NEG_INFINITY; 12]);
        let mut sums = [0.0; 12];
        let (fours, rest) = centres.as_chunks::<4>();
        for four in fours {
            let numbers = four.as_flattened();
            for k in 0..12 {
                low[k] = less(numbers[k], low[k]);
                high[k] = more(numbers[k], high[k]);
                sums[k] += numbers[k];
            }
        }
        for centre in rest {
            for k in 0..3 {
                low[k] = less(centre[k], low[k]);
                high[k] = more(centre[k], high[k]);
                sums[k] += centre[k];
            }
        }
        for four in 1..4 {
            for k in 0..3 {
                low[k] = less(low[3 * four + k], low[k]);
                high[k] = more(high[3 * four + k], high[k]);
            }
        }
        let sum = sums.iter().sum::<f64>() + radius;
        Block {
            low: Vector3::new(low[0], low[1], low[2]),
            high: Vector3::new(high[0], high[1], high[2]),
            radius,
            finite: f64::is_finite(sum),
        }
    }

    /// A block in the world in the frame of a wall: a box about it.
    pub(super) fn seen_from_wall(&self, motion: &Motion) -> Self {
        let Some([x, y, z]) = motion.axes else {
            return Block {
                low: self.low - motion.displacement,
                high: self.high - motion.displacement,
                ..*self
            };
        };
        let (centre, half) = (motion.point_to_wall(self.centre()), self.half_edges());
        let spread = |a: Vector3| a.x.abs() * half.x + a.y.abs() * half.y + a.z.abs() * half.z;
        let half = Vector3::new(spread(x), spread(y), spread(z));
        Block {
            low: centre - half,
            high: centre + half,
            ..*self
        }
    }

    /// The largest radius; less than 0 for a block without particles, NaN for one in which a number is not finite.
    pub(super) fn radius_or_none(&self) -> f64 {
        if self.can_be_asked() {
            self.radius
        } else if self.finite {
            -1.0
        } else {
            f64::NAN
        }
    }

    /// Whether a shape may be asked about it; particles whose numbers are not finite are looked at one by one.
    pub(super) fn can_be_asked(&self) -> bool {
        self.finite && self.low.x <= self.high.x
    }

    /// Middle of the box about the centres.
    pub fn centre(&self) -> Vector3 {
        (self.low + self.high) * 0.5
    }

    /// Half of its edges.
    pub fn half_edges(&self) -> Vector3 {
        (self.high - self.low) * 0.5
    }

    /// Bounds of the distances of the centres from a place, or, where the vector from there to the middle is given across an axis, from the
    /// axis. `spread` is how far a centre may be from the middle, likewise.
    pub(super) fn distances(&self, to_middle: Vector3, spread: f64) -> [f64; 2] {
        // |o + d|^2 = |o|^2 + 2 o.d + |d|^2, the parts of d each at their ends
        let (square, half) = (to_middle.norm_squared(), self.half_edges());
        let o = to_middle;
        let along = o.x.abs() * half.x + o.y.abs() * half.y + o.z.abs() * half.z;
        let least = (square - 2.0 * along).max(0.0).sqrt();
        let most = (square + 2.0 * along + spread * spread).sqrt();
        [least.max(square.sqrt() - spread), most]
    }

    /// The largest radius.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The box that contains all of the particles.
    pub(super) fn extent(&self) -> Extent {
        Extent {
            low: self.low.to_array(),
            high: self.high.to_array(),
        }
        .wider(self.radius)
    }
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
#[cfg(feature = "std")]
pub type Found<'a> = dyn FnMut(&WallSurface, usize) + 'a;

/// A surface that ellipsoids touch, in the frame of its wall.
#[cfg(feature = "std")]
pub trait Shape: Any + Debug + Send + Sync {
    /// How many contacts of one particle are remembered at most; further ones act and start anew in each step.
    fn remembered(&self) -> usize;

    /// False only if a body within the ball cannot touch; cheap, and true where a number is not finite.
    fn may_touch(&self, ball: &Ball) -> bool;

    /// False only if none of the particles of a block can touch. Some shapes look at the particles' indices: true unless it is said.
    fn may_touch_block(&self, _: &Block) -> bool {
        true
    }

    /// Marks the balls that may touch. As a function of the shape, so that the loop has no call in it. A shape may keep what it finds.
    fn mark_near(&mut self, balls: &[Ball], marks: &mut [bool]) {
        for (ball, mark) in balls.iter().zip(marks) {
            *mark |= self.may_touch(ball);
        }
    }

    /// Calls `found` with the surface at every contact of a body, deepest first where there are several. The velocity of the
    /// surface is that in the frame of the wall: zero unless the shape itself moves.
    fn touch(&self, grain: &Grain<'_>, search: &mut Search, found: &mut Found<'_>);

    /// Whether its surface may move in the frame of the wall.
    fn moves(&self) -> bool {
        false
    }

    /// What it is, if lanes can find its contacts.
    fn in_lanes(&self) -> Option<ShapeInLanes> {
        None
    }

    /// The places in which it is a plane to all that touches there, on the side of each body's centre: numbers of `geometry/flat_place.rs` in its
    /// frame, by the indices of the particles, of those that were looked at; of a [`ShapeInLanes::PlaneInPlaces`] alone.
    fn flat_places(&self) -> &[Line] {
        &[]
    }

    /// Least and largest coordinates of the box, in its frame, that it fills, where it is solid: bodies whose centres are there are in none of
    /// these places.
    fn solid_box(&self) -> Option<[Vector3; 2]> {
        None
    }

    /// Its triangles; none for a surface that is not made of them, or that an engine lends.
    fn triangles(&self) -> &[Triangle] {
        &[]
    }
}

/// A shape of which lanes find the contacts.
#[derive(Clone, Copy, Debug)]
pub enum ShapeInLanes {
    /// A plane.
    Plane(WholePlane),
    /// A cylinder or a cone.
    Cone(ConeSide),
    /// To some particles it is a plane ([`Shape::flat_places`]), to others anything.
    PlaneInPlaces,
}

/// A plane without an end.
#[derive(Clone, Copy, Debug)]
pub struct WholePlane {
    /// A point of it.
    pub point: Vector3,
    /// Its unit normal, towards the particles.
    pub normal: Vector3,
    /// Whether it acts on both sides, each on the particles whose centres are there.
    pub both_sides: bool,
}

/// Memory for the searches of all shapes, kept between calls.
#[cfg(feature = "std")]
#[derive(Debug, Default)]
pub struct Search {
    /// Contacts with triangles.
    pub triangles: TriangleSearch,
    /// Triangles near a body, by their index in the mesh.
    pub near: Vec<u32>,
}

/// A cylinder or a cone between two planes across its axis, without its ends.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct ConeSide {
    /// The surface.
    pub cone: Cone,
    /// Where it begins and ends along the axis, from the cone's point.
    pub bounds: [f64; 2],
    /// Where the particles are.
    pub side: Side,
}

/// On which side of a surface the particles are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
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
        self.may_touch_block([outwards; 2], radius)
    }

    /// Whether one of several balls may touch whose centres lie by at least the first number, and by at most the second, outside it.
    pub(super) fn may_touch_block(self, [least, most]: [f64; 2], radius: f64) -> bool {
        let (is_within, is_outside) = (most <= -radius, least >= radius);
        !match self {
            Side::Inside => is_within,
            Side::Outside => is_outside,
            Side::OfCentre => is_within || is_outside,
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
