// SPDX-License-Identifier: MIT OR Apache-2.0
//! The kinds of shape that a kernel is made for: how the lanes load them, and the closed form that they have.

use super::records::Record;
use crate::geometry::ellipsoid::rotation_columns;
use crate::geometry::{ConvexBody, Ellipsoid, Spheroid};
use crate::real::Real;
use crate::simd::{lines, Lanes, Registers, MOST_LANES};
use crate::vector::Vector3;

/// One side of the pairs: centre, shape and motion.
pub(crate) struct Side<S: Registers, K: Kind> {
    pub centre: Vector3<Lanes<S>>,
    pub body: K::Body<S>,
    pub velocity: Vector3<Lanes<S>>,
    pub omega: Vector3<Lanes<S>>,
}

/// A kind of shape that a kernel is made for.
pub(crate) trait Kind: Sized {
    /// Whether the closed form of spheres serves.
    const SPHERES: bool;
    /// The form of the others.
    type Body<S: Registers>: ConvexBody<Lanes<S>>;
    /// From records.
    fn load<S: Registers>(registers: S, records: &[&Record; MOST_LANES]) -> Side<S, Self>;
    /// Lanes whose body is a sphere.
    fn round<S: Registers>(registers: S, body: &Self::Body<S>) -> S::Mask;
    /// Radius of the bounding sphere.
    fn radius(record: &Record) -> f64;
    /// The inverse inertia of solid bodies of these masses, times a torque in the world frame.
    fn response<S: Registers>(
        body: &Self::Body<S>,
        mass: Lanes<S>,
        torque: Vector3<Lanes<S>>,
    ) -> Vector3<Lanes<S>>;
}

/// Spheres alone. Their records are those of spheroids.
pub(crate) struct Spheres;
/// Spheroids, and spheres among them. The records are
/// `[position, axis, polar and equatorial semi-axis] [velocity, angular velocity, inverses of the two]`.
pub(crate) struct Spheroids;
/// Any shapes. The records are
/// `[position, unit quaternion w x y z, first semi-axis] [second and third semi-axis, velocity, angular velocity]`.
pub(crate) struct Ellipsoids;

/// Where two finite numbers are the same.
#[inline(always)]
pub(super) fn same<S: Registers>(registers: S, a: Lanes<S>, b: Lanes<S>) -> S::Mask {
    let different = registers.or(a.less(b), b.less(a));
    registers.and_not(a.less(a.constant(f64::INFINITY)), different)
}

impl Kind for Spheroids {
    const SPHERES: bool = false;
    type Body<S: Registers> = Spheroid<Lanes<S>>;

    #[inline(always)]
    fn load<S: Registers>(registers: S, records: &[&Record; MOST_LANES]) -> Side<S, Self> {
        let a = Lanes::all(registers, registers.columns(&lines!(records, pose)));
        let b = Lanes::all(registers, registers.columns(&lines!(records, motion)));
        Side {
            centre: Vector3::new(a[0], a[1], a[2]),
            body: Spheroid {
                axis: Vector3::new(a[3], a[4], a[5]),
                polar: a[6],
                equatorial: a[7],
                inverse_polar: b[6],
                inverse_equatorial: b[7],
            },
            velocity: Vector3::new(b[0], b[1], b[2]),
            omega: Vector3::new(b[3], b[4], b[5]),
        }
    }
    #[inline(always)]
    fn round<S: Registers>(registers: S, body: &Self::Body<S>) -> S::Mask {
        same(registers, body.polar, body.equatorial)
    }
    #[inline(always)]
    fn radius(record: &Record) -> f64 {
        record.pose.0[6].max(record.pose.0[7])
    }
    #[inline(always)]
    fn response<S: Registers>(
        body: &Self::Body<S>,
        mass: Lanes<S>,
        torque: Vector3<Lanes<S>>,
    ) -> Vector3<Lanes<S>> {
        let (polar, equatorial) = (body.polar * body.polar, body.equatorial * body.equatorial);
        let across = (mass * (polar + equatorial)).reciprocal() * 5.0;
        let along = (mass * equatorial).reciprocal() * 2.5;
        body.axis
            .scale_add(body.axis.dot(torque) * (along - across), torque * across)
    }
}

impl Kind for Spheres {
    const SPHERES: bool = true;
    type Body<S: Registers> = Spheroid<Lanes<S>>;

    #[inline(always)]
    fn load<S: Registers>(registers: S, records: &[&Record; MOST_LANES]) -> Side<S, Self> {
        let side = Spheroids::load(registers, records);
        Side {
            centre: side.centre,
            body: side.body,
            velocity: side.velocity,
            omega: side.omega,
        }
    }
    #[inline(always)]
    fn round<S: Registers>(registers: S, body: &Self::Body<S>) -> S::Mask {
        Spheroids::round(registers, body)
    }
    #[inline(always)]
    fn radius(record: &Record) -> f64 {
        record.pose.0[7]
    }
    #[inline(always)]
    fn response<S: Registers>(
        body: &Self::Body<S>,
        mass: Lanes<S>,
        torque: Vector3<Lanes<S>>,
    ) -> Vector3<Lanes<S>> {
        Spheroids::response(body, mass, torque)
    }
}

impl Kind for Ellipsoids {
    const SPHERES: bool = false;
    type Body<S: Registers> = Ellipsoid<Lanes<S>>;

    #[inline(always)]
    fn load<S: Registers>(registers: S, records: &[&Record; MOST_LANES]) -> Side<S, Self> {
        let a = Lanes::all(registers, registers.columns(&lines!(records, pose)));
        let b = Lanes::all(registers, registers.columns(&lines!(records, motion)));
        let semi_axes = Vector3::new(a[7], b[0], b[1]);
        let product = semi_axes.y * semi_axes.z;
        let inverse = (semi_axes.x * product).reciprocal();
        Side {
            centre: Vector3::new(a[0], a[1], a[2]),
            body: Ellipsoid {
                axes: rotation_columns([a[3], a[4], a[5], a[6]], a[0].constant(2.0)),
                semi_axes,
                inverse_semi_axes: Vector3::new(
                    product * inverse,
                    semi_axes.x * semi_axes.z * inverse,
                    semi_axes.x * semi_axes.y * inverse,
                ),
            },
            velocity: Vector3::new(b[2], b[3], b[4]),
            omega: Vector3::new(b[5], b[6], b[7]),
        }
    }
    #[inline(always)]
    fn round<S: Registers>(registers: S, body: &Self::Body<S>) -> S::Mask {
        let a = body.semi_axes;
        registers.and(same(registers, a.x, a.y), same(registers, a.y, a.z))
    }
    #[inline(always)]
    fn radius(record: &Record) -> f64 {
        let [a, b, c] = [record.pose.0[7], record.motion.0[0], record.motion.0[1]];
        a.max(b).max(c)
    }
    #[inline(always)]
    fn response<S: Registers>(
        body: &Self::Body<S>,
        mass: Lanes<S>,
        torque: Vector3<Lanes<S>>,
    ) -> Vector3<Lanes<S>> {
        let a = body.semi_axes;
        let (x, y, z) = (a.x * a.x, a.y * a.y, a.z * a.z);
        let (yz, xz, xy) = (y + z, x + z, x + y);
        let inverse = (mass * yz * xz * xy).reciprocal() * 5.0;
        let inverse_inertia = Vector3::new(xz * xy * inverse, yz * xy * inverse, yz * xz * inverse);
        body.to_world(inverse_inertia.componentwise(body.to_body(torque)))
    }
}
