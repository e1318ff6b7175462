// SPDX-License-Identifier: MIT OR Apache-2.0
//! A body prepared for its contacts: shape, pose and motion, checked.

use super::forces::MotionChange;
use super::ranges;
use crate::geometry::ellipsoid::{LARGEST_ASPECT_RATIO, LARGEST_SEMI_AXIS, LEAST_SEMI_AXIS};
use crate::geometry::{Ellipsoid, ShapeError};
use crate::message::{Number, Numbers};
use crate::real::Real;
use crate::vector::Vector3;
#[cfg(not(feature = "std"))]
use alloc::string::String;

/// Invalid particle input: which particle, which quantity, and its value.
#[derive(Clone, Debug, PartialEq)]
pub struct ParticleError {
    /// Identifier of the particle.
    pub identifier: i64,
    /// What is wrong, with the value.
    pub what: String,
}

impl core::fmt::Display for ParticleError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "particle {}: {}", self.identifier, self.what)
    }
}
impl core::error::Error for ParticleError {}

/// A particle prepared for the contacts of one step.
#[derive(Clone, Copy, Debug)]
pub struct Particle {
    /// Centre.
    pub position: Vector3,
    /// Radius of the bounding sphere.
    pub radius: f64,
    /// Shape and pose.
    pub body: Ellipsoid,
    /// Velocity of the centre.
    pub velocity: Vector3,
    /// Angular velocity, world frame.
    pub omega: Vector3,
    /// What the motion at the step has more, where forces are to see velocities of the step.
    pub change: Option<MotionChange>,
    /// Inverse of the mass for effective masses.
    pub inverse_mass: f64,
    /// Type, counted from 1.
    pub particle_type: u32,
    /// Whether it is a sphere.
    pub sphere: bool,
}

impl Particle {
    /// A place for a particle: a unit sphere at rest, without a type.
    pub(crate) const NONE: Particle = {
        let zero = Vector3::ZERO;
        let ones = Vector3 {
            x: 1.0,
            y: 1.0,
            z: 1.0,
        };
        Particle {
            position: zero,
            radius: 1.0,
            body: Ellipsoid {
                axes: [
                    Vector3 { x: 1.0, ..zero },
                    Vector3 { y: 1.0, ..zero },
                    Vector3 { z: 1.0, ..zero },
                ],
                semi_axes: ones,
                inverse_semi_axes: ones,
            },
            velocity: zero,
            omega: zero,
            change: None,
            inverse_mass: 0.0,
            particle_type: 0,
            sphere: true,
        }
    };
}

/// A body of one contact. World frame.
#[derive(Clone, Copy, Debug)]
pub struct Body {
    /// Centre.
    pub position: [f64; 3],
    /// Rotation from body to world, `(w, x, y, z)`; normalised here.
    pub quaternion: [f64; 4],
    /// Semi-axes along the body axes.
    pub semi_axes: [f64; 3],
    /// Velocity of the centre.
    pub velocity: [f64; 3],
    /// Angular velocity.
    pub angular_velocity: [f64; 3],
    /// Mass, read by damping with a coefficient of restitution; infinite for a fixed body.
    pub mass: f64,
    /// Type, counted from 1.
    pub particle_type: i32,
    /// What to call it in a message.
    pub identifier: i64,
}

/// Checks a body and prepares it.
///
/// # Errors
/// Names the body and the value.
pub fn prepare_body(body: &Body, types: Option<usize>) -> Result<Particle, ParticleError> {
    let fail = |what: String| ParticleError {
        identifier: body.identifier,
        what,
    };
    let mut inverse_mass = 0.0;
    if let Some(types) = types {
        if body.particle_type < 1 || body.particle_type as usize > types {
            return Err(fail(format!(
                "type {} is not between 1 and {types}",
                body.particle_type
            )));
        }
        inverse_mass = ranges::inverse_mass(body.mass, "mass").map_err(fail)?;
    }
    let shape = Ellipsoid::new(body.semi_axes, body.quaternion)
        .map_err(|e| fail(describe(e, body.semi_axes, body.quaternion)))?;
    Ok(Particle {
        position: ranges::position(body.position).map_err(fail)?,
        radius: shape.bounding_radius(),
        body: shape,
        velocity: ranges::velocity(body.velocity).map_err(fail)?,
        omega: ranges::angular_velocity(body.angular_velocity).map_err(fail)?,
        change: None,
        inverse_mass,
        particle_type: body.particle_type.max(0) as u32,
        sphere: shape.is_sphere(),
    })
}

/// Says what is wrong with a shape, with the value.
pub fn describe(error: ShapeError, semi_axes: [f64; 3], quaternion: [f64; 4]) -> String {
    match error {
        ShapeError::SemiAxis(a) => format!(
            "semi-axis = {} must be a finite number greater than 0, from {LEAST_SEMI_AXIS:e} to {LARGEST_SEMI_AXIS:e} \
             (semi-axes {})",
            Number(a),
            Numbers(&semi_axes)
        ),
        ShapeError::AspectRatio(ratio) => format!(
            "the largest of the semi-axes {} is {} times the smallest: it may be {LARGEST_ASPECT_RATIO:e} times",
            Numbers(&semi_axes),
            Number(ratio)
        ),
        ShapeError::Quaternion(_) => format!(
            "quaternion (w x y z) = {} must be finite and not zero",
            Numbers(&quaternion)
        ),
    }
}

/// Angular velocity of a solid ellipsoid with angular momentum `l`, both in the world frame.
pub fn angular_velocity(body: &Ellipsoid, mass: f64, l: Vector3) -> Vector3 {
    response_to_torque(body, mass)(l)
}

/// Angular momentum of a solid ellipsoid with angular velocity `omega`, both in the world frame.
pub fn angular_momentum(body: &Ellipsoid, mass: f64, omega: Vector3) -> Vector3 {
    let inertia = body.moments_of_inertia(mass);
    body.to_world(inertia.componentwise(body.to_body(omega)))
}

/// The inverse inertia of a solid ellipsoid of this mass, as a function of a torque or an angular momentum, world frame.
pub(crate) fn response_to_torque(body: &Ellipsoid, mass: f64) -> impl Fn(Vector3) -> Vector3 + '_ {
    let five_over_mass = 5.0 / mass;
    let across = body.squares_across();
    let inverse_inertia = Vector3::new(
        five_over_mass / across.x,
        five_over_mass / across.y,
        five_over_mass / across.z,
    );
    move |torque| body.to_world(inverse_inertia.componentwise(body.to_body(torque)))
}

/// `m_i m_j/(m_i + m_j)` from inverse masses; 0 for two frozen bodies, which need no damping.
#[inline(always)]
pub fn effective_mass(inverse_i: f64, inverse_j: f64) -> f64 {
    mass_of_inverse(inverse_i + inverse_j)
}

/// The effective mass from the sum of the inverse masses, in lanes too.
#[inline(always)]
pub(crate) fn mass_of_inverse<T: Real>(sum: T) -> T {
    let zero = sum.constant(0.0);
    // No trap where the sum is zero; no mass is as large.
    let mass = sum.max(zero.constant(1e-300)).reciprocal();
    T::select(zero.less(sum), mass, zero)
}
