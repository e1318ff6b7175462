// SPDX-License-Identifier: MIT OR Apache-2.0
//! Prepared grains, and the kinds of shape that kernels are made for.

use crate::one_lane::{number, OneLane};
use ellgran::contact::{MotionChange, Particle};
use ellgran::geometry::ellipsoid::rotation_columns;
use ellgran::geometry::{ConvexBody, Ellipsoid, Spheroid};
use ellgran::real::Real;
use ellgran::simd::{Lanes, Registers};
use ellgran::vector::{Tangent, Vector3};

/// A grain as the kernels load it, two cache lines. What they hold depends on the kind of shape that a scene is prepared for.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Grain {
    /// Centre. Then of spheres and spheroids the unit vector of the axis, polar and equatorial semi-axis; of ellipsoids the unit
    /// quaternion `(w, x, y, z)` and the first semi-axis. World frame.
    pub pose: [f64; 8],
    /// Of spheres and spheroids: velocity, angular velocity, inverses of the two semi-axes. Of ellipsoids: second and third
    /// semi-axis, velocity, angular velocity. World frame.
    pub motion: [f64; 8],
}

impl Grain {
    /// Nothing yet.
    pub const NONE: Grain = Grain {
        pose: [0.0; 8],
        motion: [0.0; 8],
    };

    /// Centre.
    #[inline(always)]
    pub fn centre(&self) -> Vector3 {
        Vector3::new(self.pose[0], self.pose[1], self.pose[2])
    }
}

/// What the motion of a grain has more at the step than at the half step: a device reads two numbers at once.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(16))]
pub struct GrainChange {
    /// Of the velocity, then of the angular velocity; world frame.
    values: [f64; 6],
}

impl GrainChange {
    /// For the functions of a contact.
    #[inline(always)]
    pub fn motion(&self) -> MotionChange {
        let [x, y, z, a, b, c] = self.values;
        MotionChange {
            velocity: Vector3::new(x, y, z),
            omega: Vector3::new(a, b, c),
        }
    }
}

impl From<MotionChange> for GrainChange {
    #[inline(always)]
    fn from(change: MotionChange) -> Self {
        let (v, w) = (change.velocity, change.omega);
        GrainChange {
            values: [v.x, v.y, v.z, w.x, w.y, w.z],
        }
    }
}

/// A kind of shape that a kernel is made for.
pub trait Kind {
    /// Whether the closed form of spheres serves.
    const SPHERES: bool;
    /// The closed form of the others, in the lane of a register.
    type Body<S: Registers>: ConvexBody<Lanes<S>>;
    /// Whether a shape is of this kind.
    fn takes(semi_axes: [f64; 3]) -> bool;
    /// A grain of these semi-axes, unit quaternion `(w, x, y, z)`, velocity and angular velocity.
    fn prepare(
        centre: Vector3,
        semi_axes: [f64; 3],
        quaternion: [f64; 4],
        velocity: Vector3,
        omega: Vector3,
    ) -> Grain;
    /// Its shape, its lengths in units of which `unit` is one and has the inverse `per_unit`.
    fn body_in<S: Registers>(
        registers: S,
        grain: &Grain,
        unit: Lanes<S>,
        per_unit: Lanes<S>,
    ) -> Self::Body<S>;
    /// Its shape.
    #[inline(always)]
    fn body(grain: &Grain) -> Self::Body<OneLane> {
        Self::body_in(OneLane, grain, number(1.0), number(1.0))
    }
    /// Radius of the bounding sphere.
    fn radius(grain: &Grain) -> f64;
    /// Whether it is a sphere.
    fn is_sphere(grain: &Grain) -> bool;
    /// Its velocity and its angular velocity.
    fn motion(grain: &Grain) -> (Vector3, Vector3);
    /// The same grain for the functions of one contact. Of a spheroid the axis alone is known: any other two serve.
    fn particle(grain: &Grain, particle_type: u32, inverse_mass: f64) -> Particle;
}

/// Spheres alone.
#[derive(Clone, Copy, Debug)]
pub struct Spheres;
/// Spheroids, and spheres among them.
#[derive(Clone, Copy, Debug)]
pub struct Spheroids;
/// Any ellipsoids.
#[derive(Clone, Copy, Debug)]
pub struct Ellipsoids;

fn particle<K: Kind>(
    grain: &Grain,
    axes: [Vector3; 3],
    semi_axes: Vector3,
    particle_type: u32,
    inverse_mass: f64,
) -> Particle {
    let body = Ellipsoid {
        axes,
        semi_axes,
        inverse_semi_axes: Vector3::new(1.0 / semi_axes.x, 1.0 / semi_axes.y, 1.0 / semi_axes.z),
    };
    let (velocity, omega) = K::motion(grain);
    Particle {
        position: grain.centre(),
        radius: body.bounding_radius(),
        body,
        velocity,
        omega,
        change: None,
        inverse_mass,
        particle_type,
        sphere: body.is_sphere(),
    }
}

impl Kind for Spheroids {
    const SPHERES: bool = false;
    type Body<S: Registers> = Spheroid<Lanes<S>>;

    #[inline(always)]
    fn takes([a, b, c]: [f64; 3]) -> bool {
        a == b || b == c || a == c
    }
    #[inline(always)]
    fn prepare(
        x: Vector3,
        semi_axes: [f64; 3],
        quaternion: [f64; 4],
        v: Vector3,
        w: Vector3,
    ) -> Grain {
        // The semi-axis that stands apart, the last of a sphere.
        let [a, b, c] = semi_axes;
        let axes = rotation_columns(quaternion, 2.0);
        let (e, polar, equatorial) = if a == b {
            (axes[2], c, a)
        } else if b == c {
            (axes[0], a, b)
        } else {
            (axes[1], b, c)
        };
        Grain {
            pose: [x.x, x.y, x.z, e.x, e.y, e.z, polar, equatorial],
            motion: [v.x, v.y, v.z, w.x, w.y, w.z, 1.0 / polar, 1.0 / equatorial],
        }
    }
    #[inline(always)]
    fn body_in<S: Registers>(
        registers: S,
        grain: &Grain,
        unit: Lanes<S>,
        per_unit: Lanes<S>,
    ) -> Spheroid<Lanes<S>> {
        let (p, m) = (&grain.pose, &grain.motion);
        let number = |x: &[f64]| Lanes::load(registers, x);
        Spheroid {
            axis: Vector3::new(number(&p[3..]), number(&p[4..]), number(&p[5..])),
            polar: number(&p[6..]) * per_unit,
            equatorial: number(&p[7..]) * per_unit,
            inverse_polar: number(&m[6..]) * unit,
            inverse_equatorial: number(&m[7..]) * unit,
        }
    }
    #[inline(always)]
    fn radius(grain: &Grain) -> f64 {
        grain.pose[6].max(grain.pose[7])
    }
    #[inline(always)]
    fn is_sphere(grain: &Grain) -> bool {
        grain.pose[6] == grain.pose[7]
    }
    #[inline(always)]
    fn motion(grain: &Grain) -> (Vector3, Vector3) {
        let m = &grain.motion;
        (
            Vector3::new(m[0], m[1], m[2]),
            Vector3::new(m[3], m[4], m[5]),
        )
    }
    fn particle(grain: &Grain, particle_type: u32, inverse_mass: f64) -> Particle {
        let p = &grain.pose;
        let e = Vector3::new(p[3], p[4], p[5]);
        let Tangent { u, v } = Tangent::new(e);
        let semi_axes = Vector3::new(p[7], p[7], p[6]);
        particle::<Self>(grain, [u, v, e], semi_axes, particle_type, inverse_mass)
    }
}

impl Kind for Spheres {
    const SPHERES: bool = true;
    type Body<S: Registers> = Spheroid<Lanes<S>>;

    #[inline(always)]
    fn takes([a, b, c]: [f64; 3]) -> bool {
        a == b && b == c
    }
    #[inline(always)]
    fn prepare(x: Vector3, a: [f64; 3], q: [f64; 4], v: Vector3, w: Vector3) -> Grain {
        Spheroids::prepare(x, a, q, v, w)
    }
    #[inline(always)]
    fn body_in<S: Registers>(
        registers: S,
        grain: &Grain,
        unit: Lanes<S>,
        per_unit: Lanes<S>,
    ) -> Spheroid<Lanes<S>> {
        Spheroids::body_in(registers, grain, unit, per_unit)
    }
    #[inline(always)]
    fn radius(grain: &Grain) -> f64 {
        grain.pose[7]
    }
    #[inline(always)]
    fn is_sphere(_: &Grain) -> bool {
        true
    }
    #[inline(always)]
    fn motion(grain: &Grain) -> (Vector3, Vector3) {
        Spheroids::motion(grain)
    }
    fn particle(grain: &Grain, particle_type: u32, inverse_mass: f64) -> Particle {
        Spheroids::particle(grain, particle_type, inverse_mass)
    }
}

impl Kind for Ellipsoids {
    const SPHERES: bool = false;
    type Body<S: Registers> = Ellipsoid<Lanes<S>>;

    #[inline(always)]
    fn takes(_: [f64; 3]) -> bool {
        true
    }
    #[inline(always)]
    fn prepare(x: Vector3, [a, b, c]: [f64; 3], q: [f64; 4], v: Vector3, w: Vector3) -> Grain {
        Grain {
            pose: [x.x, x.y, x.z, q[0], q[1], q[2], q[3], a],
            motion: [b, c, v.x, v.y, v.z, w.x, w.y, w.z],
        }
    }
    #[inline(always)]
    fn body_in<S: Registers>(
        registers: S,
        grain: &Grain,
        _: Lanes<S>,
        per_unit: Lanes<S>,
    ) -> Ellipsoid<Lanes<S>> {
        let (p, m) = (&grain.pose, &grain.motion);
        let number = |x: &[f64]| Lanes::load(registers, x);
        let (a, b, c) = (
            number(&p[7..]) * per_unit,
            number(m) * per_unit,
            number(&m[1..]) * per_unit,
        );
        let inverse = (a * b * c).reciprocal();
        let quaternion = [
            number(&p[3..]),
            number(&p[4..]),
            number(&p[5..]),
            number(&p[6..]),
        ];
        Ellipsoid {
            axes: rotation_columns(quaternion, Lanes::splat(registers, 2.0)),
            semi_axes: Vector3::new(a, b, c),
            inverse_semi_axes: Vector3::new(b * c * inverse, a * c * inverse, a * b * inverse),
        }
    }

    #[inline(always)]
    fn radius(grain: &Grain) -> f64 {
        grain.pose[7].max(grain.motion[0]).max(grain.motion[1])
    }
    #[inline(always)]
    fn is_sphere(grain: &Grain) -> bool {
        grain.pose[7] == grain.motion[0] && grain.motion[0] == grain.motion[1]
    }
    #[inline(always)]
    fn motion(grain: &Grain) -> (Vector3, Vector3) {
        let m = &grain.motion;
        (
            Vector3::new(m[2], m[3], m[4]),
            Vector3::new(m[5], m[6], m[7]),
        )
    }
    fn particle(grain: &Grain, particle_type: u32, inverse_mass: f64) -> Particle {
        let p = &grain.pose;
        let axes = rotation_columns([p[3], p[4], p[5], p[6]], 2.0);
        let semi_axes = Vector3::new(p[7], grain.motion[0], grain.motion[1]);
        particle::<Self>(grain, axes, semi_axes, particle_type, inverse_mass)
    }
}
