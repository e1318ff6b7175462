// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which lanes touch a part of a wall in one place, and what is its surface there? A plane, a cylinder or a cone from within, a mesh in the places
//! where it is a plane.

use super::cone_in_lanes::TouchedInLanes;
use super::motion::Motion;
use super::near_triangles::NOT_FLAT;
use super::shape::{Ball, Shape, ShapeInLanes, WholePlane};
use crate::contact::vectors_in_lanes::splat;
use crate::contact::Step;
use crate::geometry::flat_place::FlatPlace;
use crate::geometry::ConvexBody;
use crate::list::shapes::{Kind, Side as SideOfPairs};
use crate::list::ParticleRecords;
use crate::real::Real;
use crate::simd::{put, Lanes, Line, Registers, MOST_LANES};
use crate::vector::{Tangent, Vector3};

/// What the search is given.
pub(super) struct SearchInput<'a> {
    /// The particles that may touch, and their indices.
    pub(super) near: ParticleRecords<'a>,
    pub(super) indices: &'a [usize],
    pub(super) motion: &'a Motion,
    pub(super) step: &'a Step,
}

impl SearchInput<'_> {
    /// The ball that contains a particle, in the frame of the wall.
    #[inline(always)]
    pub(super) fn ball<K: Kind>(&self, near: usize) -> Ball {
        let record = self.near.record(near);
        Ball {
            particle: self.indices[near],
            centre: self.motion.point_to_wall(record.position()),
            radius: K::radius(record),
        }
    }
}

/// What the lanes find of a part.
pub(super) struct FoundInLanes<S: Registers> {
    /// Bits of those that touch it.
    pub(super) touching: u32,
    /// Bits of those that may touch it, and are to be searched one by one; none of them is among the former.
    pub(super) unsure: u32,
    /// Its surface, where one of the former is.
    pub(super) surface: SurfaceInLanes<S>,
}

/// The surface that each lane touches, in the frame of the world.
pub(super) struct SurfaceInLanes<S: Registers> {
    /// Normal out of the wall.
    pub(super) outwards: Vector3<Lanes<S>>,
    /// How far the centre lies from the plane that touches the surface.
    pub(super) height: Lanes<S>,
    /// A principal direction.
    pub(super) direction: Vector3<Lanes<S>>,
    /// Curvatures along it and across.
    pub(super) curvatures: [Lanes<S>; 2],
    /// Radii with which it turns with the body's motion, along and across; infinite where it does not.
    pub(super) turning_radii: [Lanes<S>; 2],
    /// The normal in the frame of the wall.
    pub(super) outwards_in_wall: Vector3<Lanes<S>>,
}

impl<S: Registers> SurfaceInLanes<S> {
    /// Flat ones.
    #[inline(always)]
    pub(super) fn flat(
        registers: S,
        outwards: Vector3<Lanes<S>>,
        height: Lanes<S>,
        outwards_in_wall: Vector3<Lanes<S>>,
    ) -> Self {
        let zero = Lanes::splat(registers, 0.0);
        SurfaceInLanes {
            outwards,
            height,
            direction: Tangent::new(outwards).u,
            curvatures: [zero; 2],
            turning_radii: [zero.constant(f64::INFINITY); 2],
            outwards_in_wall,
        }
    }

    /// Cylinders or cones from within.
    #[inline(always)]
    fn around(registers: S, touched: &TouchedInLanes<S>, motion: &Motion) -> Self {
        let radius = -touched.radius;
        SurfaceInLanes {
            outwards: touched.outwards,
            height: touched.height,
            direction: touched.direction,
            curvatures: [radius.reciprocal(), radius.constant(0.0)],
            turning_radii: [radius, radius.constant(f64::INFINITY)],
            outwards_in_wall: to_wall(registers, motion, touched.outwards),
        }
    }

    /// From lines that [`SurfaceInLanes::put`] has written. The second has but a flat surface's numbers where it is not asked for, and no normal
    /// in the frame of the wall.
    #[inline(always)]
    pub(super) fn read(registers: S, [a, b]: &[[&Line; MOST_LANES]; 2], with_second: bool) -> Self {
        let a = Lanes::all(registers, registers.columns(a));
        let (zero, infinite) = (a[0].constant(0.0), a[0].constant(f64::INFINITY));
        let b = if with_second {
            Lanes::all(registers, registers.columns(b))
        } else {
            [zero, zero, infinite, infinite, zero, zero, zero, zero]
        };
        SurfaceInLanes {
            outwards: Vector3::new(a[0], a[1], a[2]),
            height: a[3],
            direction: Vector3::new(a[4], a[5], a[6]),
            curvatures: [b[0], b[1]],
            turning_radii: [b[2], b[3]],
            outwards_in_wall: Vector3::new(b[4], b[5], b[6]),
        }
    }

    /// Writes them, those of lanes that do not touch too.
    #[inline(always)]
    pub(super) fn put(&self, registers: S, [a, b]: &mut [[Line; MOST_LANES]; 2]) {
        let zero = self.height.constant(0.0);
        let (n, d, w) = (self.outwards, self.direction, self.outwards_in_wall);
        let first = [n.x, n.y, n.z, self.height, d.x, d.y, d.z, zero];
        put(registers, first, a);
        let ([c, e], [r, t]) = (self.curvatures, self.turning_radii);
        put(registers, [c, e, r, t, w.x, w.y, w.z, zero], b);
    }
}

impl ShapeInLanes {
    /// The same, where the wall is.
    pub(super) fn in_world(&self, motion: &Motion) -> ShapeInLanes {
        match self {
            ShapeInLanes::Plane(plane) => ShapeInLanes::Plane(WholePlane {
                point: motion.point_to_world(plane.point),
                normal: motion.to_world(plane.normal),
                ..*plane
            }),
            ShapeInLanes::Cone(side) => ShapeInLanes::Cone(side.in_world(motion)),
            // Its places are known in its own frame.
            ShapeInLanes::PlaneInPlaces => *self,
        }
    }

    /// Whether its surfaces turn with a body's motion.
    pub(super) fn turns(&self) -> bool {
        matches!(self, ShapeInLanes::Cone(_))
    }

    /// Which of so many lanes, from this one of those that may touch, touch it; `self` is where the wall is, `shape` the part.
    #[inline(always)]
    pub(super) fn find<S: Registers, K: Kind>(
        &self,
        registers: S,
        shape: &dyn Shape,
        input: &SearchInput<'_>,
        (first, present): (usize, usize),
        side: &SideOfPairs<S, K>,
    ) -> FoundInLanes<S> {
        let all = (1u32 << present) - 1;
        match self {
            ShapeInLanes::Plane(plane) => {
                let (touching, behind, height) = plane.touch::<S, K>(registers, side);
                let one = Lanes::splat(registers, 1.0);
                let sign = Lanes::select(registers.mask(behind), -one, one);
                let n = splat(registers, plane.normal) * sign;
                let w = splat(registers, input.motion.to_wall(plane.normal)) * sign;
                FoundInLanes {
                    touching: touching & all,
                    unsure: 0,
                    surface: SurfaceInLanes::flat(registers, n, height, w),
                }
            }
            ShapeInLanes::Cone(cone) => {
                let touched = cone.touch(registers, side.centre, &side.body);
                FoundInLanes {
                    touching: registers.bits(touched.touching) & all,
                    unsure: registers.bits(touched.unsure) & all,
                    surface: SurfaceInLanes::around(registers, &touched, input.motion),
                }
            }
            ShapeInLanes::PlaneInPlaces => {
                let places = shape.flat_places();
                let mut lines = [&NOT_FLAT; MOST_LANES];
                for (line, particle) in lines.iter_mut().zip(&input.indices[first..][..present]) {
                    if let Some(place) = places.get(*particle) {
                        *line = place;
                    }
                }
                let place = FlatPlace::of(Lanes::all(registers, registers.columns(&lines)));
                let centre = point_to_wall(registers, input.motion, side.centre);
                let [radius, _] = side.body.extreme_semi_axes();
                let (room, way) = (place.room(radius), place.way_to(centre));
                let has_room = registers.and(
                    (radius.constant(0.0)).less(room),
                    way.norm_squared().less(room * room),
                );
                let mut known = registers.bits(has_room) & all;
                if let Some([low, high]) = shape.solid_box() {
                    known &= !registers.bits(is_within(registers, centre, low, high));
                }
                let height = place.height_after(way);
                let zero = height.constant(0.0);
                let behind = height.less(zero);
                let one = height.constant(1.0);
                let w = place.normal * Lanes::select(behind, -one, one);
                let n = to_world(registers, input.motion, w);
                let height = height.abs();
                let (support, _) = side.body.support_in_world(n);
                let touching = registers.bits(height.less(support)) & known;
                let mut unsure = 0;
                let mut unknown = all & !known;
                while unknown != 0 {
                    let lane = unknown.trailing_zeros();
                    unknown &= unknown - 1;
                    let ball = input.ball::<K>(first + lane as usize);
                    unsure |= u32::from(shape.may_touch(&ball)) << lane;
                }
                FoundInLanes {
                    touching,
                    unsure,
                    surface: SurfaceInLanes::flat(registers, n, height, w),
                }
            }
        }
    }
}

impl WholePlane {
    /// Lanes that touch it, those behind it, and the heights of the centres above it.
    #[inline(always)]
    pub(super) fn touch<S: Registers, K: Kind>(
        &self,
        registers: S,
        side: &SideOfPairs<S, K>,
    ) -> (u32, u32, Lanes<S>) {
        let normal = splat(registers, self.normal);
        let height = normal.dot(side.centre - splat(registers, self.point));
        let (support, _) = side.body.support_in_world(normal);
        let (behind, height) = if self.both_sides {
            let behind = height.less(height.constant(0.0));
            (registers.bits(behind), height.abs())
        } else {
            (0, height)
        };
        (registers.bits(height.less(support)), behind, height)
    }
}

/// Whether points are in a box or on its surface.
#[inline(always)]
fn is_within<S: Registers>(
    registers: S,
    p: Vector3<Lanes<S>>,
    low: Vector3,
    high: Vector3,
) -> S::Mask {
    let (low, high) = (splat(registers, low), splat(registers, high));
    let mut outside = registers.or(p.x.less(low.x), high.x.less(p.x));
    outside = registers.or(outside, registers.or(p.y.less(low.y), high.y.less(p.y)));
    outside = registers.or(outside, registers.or(p.z.less(low.z), high.z.less(p.z)));
    registers.not(outside)
}

/// A vector of each lane in the frame of a wall that has turned, and back.
pub(super) struct Axes<S: Registers>([Vector3<Lanes<S>>; 3]);

impl<S: Registers> Axes<S> {
    /// Of a wall; `None` where it has not turned.
    #[inline(always)]
    pub(super) fn of(registers: S, motion: &Motion) -> Option<Self> {
        let [x, y, z] = motion.axes?;
        Some(Axes([
            splat(registers, x),
            splat(registers, y),
            splat(registers, z),
        ]))
    }

    #[inline(always)]
    pub(super) fn to_wall(&self, v: Vector3<Lanes<S>>) -> Vector3<Lanes<S>> {
        let [x, y, z] = &self.0;
        Vector3::new(x.dot(v), y.dot(v), z.dot(v))
    }

    #[inline(always)]
    pub(super) fn to_world(&self, v: Vector3<Lanes<S>>) -> Vector3<Lanes<S>> {
        let [x, y, z] = &self.0;
        x.scale_add(v.x, y.scale_add(v.y, *z * v.z))
    }
}

/// A vector of the world in the frame of a wall ([`Motion::to_wall`]).
#[inline(always)]
fn to_wall<S: Registers>(registers: S, motion: &Motion, v: Vector3<Lanes<S>>) -> Vector3<Lanes<S>> {
    match Axes::of(registers, motion) {
        None => v,
        Some(axes) => axes.to_wall(v),
    }
}

/// And back ([`Motion::to_world`]).
#[inline(always)]
fn to_world<S: Registers>(
    registers: S,
    motion: &Motion,
    v: Vector3<Lanes<S>>,
) -> Vector3<Lanes<S>> {
    match Axes::of(registers, motion) {
        None => v,
        Some(axes) => axes.to_world(v),
    }
}

/// A point of the world in the frame of a wall ([`Motion::point_to_wall`]).
#[inline(always)]
fn point_to_wall<S: Registers>(
    registers: S,
    motion: &Motion,
    p: Vector3<Lanes<S>>,
) -> Vector3<Lanes<S>> {
    match motion.axes {
        None => p - splat(registers, motion.displacement),
        Some(_) => {
            let from_centre = p - splat(registers, motion.centre());
            to_wall(registers, motion, from_centre) + splat(registers, motion.origin)
        }
    }
}
