// SPDX-License-Identifier: MIT OR Apache-2.0
//! Grains within a cylinder or a cone, in lanes: where the depth of each has one maximum (`geometry/cone.rs`), and it touches.

use super::motion::Motion;
use super::shape::{ConeSide, Side};
use crate::contact::vectors_in_lanes::splat;
use crate::geometry::cone::{Cone, DepthInCone, LONGEST_STEP, MOST_STEPS, SHORTEST_STEP};
use crate::geometry::ConvexBody;
use crate::real::Real;
use crate::simd::{Lanes, Registers};
use crate::vector::{Tangent, Vector3};

/// By how much of the largest semi-axis a body may be apart that is taken for touching; more than rounding at any aspect ratio.
const MARGIN: f64 = 1e-9;

/// What the lanes find.
pub(super) struct TouchedInLanes<S: Registers> {
    /// Lanes that touch, in one place, or are apart by rounding.
    pub touching: S::Mask,
    /// Lanes that may touch, and are to be searched one by one.
    pub unsure: S::Mask,
    /// Normal out of the wall, towards the body.
    pub outwards: Vector3<Lanes<S>>,
    /// How far the centre lies from the plane that touches the surface.
    pub height: Lanes<S>,
    /// A unit vector around the axis.
    pub direction: Vector3<Lanes<S>>,
    /// Radius of curvature around the axis.
    pub radius: Lanes<S>,
}

impl ConeSide {
    /// The same, where the wall is.
    pub(super) fn in_world(&self, motion: &Motion) -> ConeSide {
        let cone = &self.cone;
        ConeSide {
            cone: Cone {
                point: motion.point_to_world(cone.point),
                axis: motion.to_world(cone.axis),
                ..*cone
            },
            ..*self
        }
    }

    /// Where bodies with these centres touch it, all in the frame of the world.
    #[inline(always)]
    pub(super) fn touch<S: Registers, B: ConvexBody<Lanes<S>>>(
        &self,
        registers: S,
        centre: Vector3<Lanes<S>>,
        body: &B,
    ) -> TouchedInLanes<S> {
        let zero = Lanes::splat(registers, 0.0);
        let one = Lanes::splat(registers, 1.0);
        let (cone, axis) = (&self.cone, splat(registers, self.cone.axis));
        let offset = centre - splat(registers, cone.point);
        let z = axis.dot(offset);
        let across = offset - axis * z;
        let square = across.norm_squared().max(zero.constant(1e-300));
        let inverse = square.reciprocal_sqrt();
        let distance = square * inverse;
        let towards_centre = across * inverse;
        let directions = Tangent {
            u: towards_centre,
            v: axis.cross(towards_centre),
        };
        let depth = DepthInCone::new(cone, body, (axis, directions), [distance, z]);
        let extremes = body.extreme_semi_axes();
        let [largest, _] = extremes;
        let nearest = depth.height(one);
        // A body that belongs outside is pushed out from however deep within, as one contact at a time does it.
        let near = match self.side {
            Side::Outside => registers.not(registers.no_lane()),
            Side::Inside | Side::OfCentre => nearest.less(largest),
        };
        let mut within = match self.side {
            Side::Inside => registers.not(registers.no_lane()),
            Side::Outside => registers.no_lane(),
            Side::OfCentre => distance.less(z * cone.slope + cone.radius),
        };
        within = registers.and(within, depth.is_concave(extremes));

        let (mut cos, mut sin) = (one, zero);
        let mut unsound = registers.not(registers.and(within, near));
        let mut settled = registers.no_lane();
        for _ in 0..MOST_STEPS {
            let (second, change, turned) = depth.step(cos, sin);
            [cos, sin] = turned;
            let size = change.abs();
            let sound = registers.and(second.less(zero), size.less(one.constant(LONGEST_STEP)));
            unsound = registers.or(unsound, registers.not(sound));
            // The error that such a step of Newton's leaves is beneath rounding.
            settled = size.less(one.constant(SHORTEST_STEP));
            if registers.all(registers.or(settled, unsound)) {
                break;
            }
        }
        unsound = registers.or(unsound, registers.not(settled));
        // Concave only in the directions in which it may touch.
        unsound = registers.or(unsound, largest.less(depth.height(cos)));

        let height = depth.height(cos);
        let support = depth.support(cos, sin);
        let along = z + depth.along(cos, sin, [height, support]);
        let radius = (along * cone.slope + cone.radius) * self.cone.stretch();
        let on_surface = registers.and(
            registers.not(registers.or(
                along.less(zero.constant(self.bounds[0])),
                zero.constant(self.bounds[1]).less(along),
            )),
            zero.less(radius),
        );
        let u = directions.u * cos + directions.v * sin;
        let (c, s) = cone.normal_components();
        let (c, s) = (one.constant(c), one.constant(s));
        // The law finds out which do: the square from which this support comes has lost digits.
        let touching = height.less(largest.multiply_add(one.constant(MARGIN), support));
        let touching = registers.and(touching, on_surface);
        TouchedInLanes {
            touching: registers.and_not(touching, unsound),
            unsure: registers.and(near, unsound),
            outwards: -(u * c + axis * s),
            height,
            direction: directions.v * cos - directions.u * sin,
            radius,
        }
    }
}
