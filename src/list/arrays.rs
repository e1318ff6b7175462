// SPDX-License-Identifier: MIT OR Apache-2.0
//! An engine's particle arrays, and one particle of them checked and prepared.

use crate::contact::forces::MotionChange;
use crate::contact::particle::{angular_velocity, describe, Particle};
use crate::contact::ranges;
use crate::geometry::Ellipsoid;
use crate::message::Number;
use crate::vector::Vector3;

/// Shapes and attitudes of an engine's particles. A function of the particle's index is one.
pub trait ParticleShapes {
    /// Semi-axes and quaternion `(w, x, y, z)` of a particle; `None` for one that is no ellipsoid.
    fn of(&self, k: usize) -> Option<([f64; 3], [f64; 4])>;

    /// Numbers that are read for it, the first and the last, where they are known without being read. An engine that sorts its particles leaves
    /// shapes where they are: they are read in no order that a processor foresees.
    #[inline(always)]
    fn place(&self, _: usize) -> Option<[&f64; 2]> {
        None
    }
}

impl<F: Fn(usize) -> Option<([f64; 3], [f64; 4])>> ParticleShapes for F {
    #[inline(always)]
    fn of(&self, k: usize) -> Option<([f64; 3], [f64; 4])> {
        self(k)
    }
}

/// Borrowed views of an engine's arrays, local particles first, ghosts after them.
pub struct ParticleArrays<'a, S: ParticleShapes, I: Fn(usize) -> i64> {
    /// Number of particles that the caller owns; the others are ghosts.
    pub owned: usize,
    /// Centres.
    pub positions: &'a [[f64; 3]],
    /// Velocities of the centres.
    pub velocities: &'a [[f64; 3]],
    /// Angular velocities in the world frame, or angular momenta.
    pub rotation: Rotation<'a>,
    /// Whether velocities and rotations are those of the step at which the forces are computed; else they are those of the half
    /// step before.
    pub of_step: bool,
    /// What those of the step have more than those of the half step; empty where nobody asks for the latter.
    pub changes: &'a [[f64; 6]],
    /// Masses for effective masses; empty where no law reads them.
    pub contact_masses: &'a [f64],
    /// Types, counted from 1.
    pub types: &'a [i32],
    /// Their shapes and attitudes.
    pub shape: S,
    /// What to call a particle in a message.
    pub identifier: I,
}

/// How fast the particles rotate.
#[derive(Clone, Copy)]
pub enum Rotation<'a> {
    /// Angular velocities in the world frame.
    Velocity(&'a [[f64; 3]]),
    /// Angular momenta in the world frame, of solid ellipsoids of these masses.
    Momentum(&'a [[f64; 3]], &'a [f64]),
}

impl Rotation<'_> {
    /// Angular velocity or momentum of a particle.
    #[inline(always)]
    pub(super) fn of(&self, k: usize) -> [f64; 3] {
        match self {
            Rotation::Velocity(omega) => omega[k],
            Rotation::Momentum(momenta, _) => momenta[k],
        }
    }
}

#[cold]
pub(super) fn no_shape() -> String {
    "it has no shape: every particle must be an ellipsoid".into()
}

#[inline(always)]
fn inverse_contact_mass(mass: Option<&f64>) -> Result<f64, String> {
    match mass {
        None => Ok(0.0),
        Some(&m) => ranges::inverse_mass(m, "contact mass"),
    }
}

/// Checks a particle and prepares it in its place: a particle is large, and its copies would cost more than its numbers.
///
/// # Errors
/// What is wrong with it; then what is in the place is neither of them.
#[inline(always)]
pub(super) fn prepare_one<S: ParticleShapes, I: Fn(usize) -> i64>(
    arrays: &ParticleArrays<'_, S, I>,
    k: usize,
    types: usize,
    particle: &mut Particle,
) -> Result<(), String> {
    particle.position = ranges::position(arrays.positions[k])?;
    let change = arrays.changes.get(k);
    let (mut velocity, mut rotation) = (arrays.velocities[k], arrays.rotation.of(k));
    if let Some(change) = change {
        for axis in 0..3 {
            velocity[axis] -= change[axis];
            rotation[axis] -= change[3 + axis];
        }
    }
    particle.velocity = ranges::velocity(velocity)?;
    let particle_type = arrays.types[k];
    if particle_type < 1 || particle_type as usize > types {
        return Err(format!("type {particle_type} is not between 1 and {types}"));
    }
    particle.particle_type = particle_type as u32;
    let (semi_axes, quaternion) = arrays.shape.of(k).ok_or_else(no_shape)?;
    let body = &mut particle.body;
    *body =
        Ellipsoid::new(semi_axes, quaternion).map_err(|e| describe(e, semi_axes, quaternion))?;
    particle.radius = body.bounding_radius();
    particle.sphere = body.is_sphere();
    particle.omega = match arrays.rotation {
        Rotation::Velocity(_) => ranges::angular_velocity(rotation)?,
        Rotation::Momentum(_, masses) => {
            let l = ranges::vector(rotation, f64::MAX, "angular momentum")?;
            let mass = masses[k];
            if !(ranges::is_mass(mass) && mass.is_finite()) {
                return Err(format!(
                    "mass = {} must be a finite number greater than 0, from {:e} to {:e}",
                    Number(mass),
                    ranges::LEAST_MASS,
                    ranges::LARGEST_MASS
                ));
            }
            let omega = angular_velocity(body, mass, l).to_array();
            ranges::vector(
                omega,
                ranges::LARGEST_VELOCITY,
                "angular velocity (from the angular momentum)",
            )?
        }
    };
    particle.inverse_mass = inverse_contact_mass(arrays.contact_masses.get(k))?;
    particle.change = arrays.of_step.then(|| {
        let [x, y, z, a, b, c] = change.copied().unwrap_or_default();
        let rotation = Vector3::new(a, b, c);
        MotionChange {
            velocity: Vector3::new(x, y, z),
            omega: match arrays.rotation {
                Rotation::Velocity(_) => rotation,
                Rotation::Momentum(_, masses) => angular_velocity(body, masses[k], rotation),
            },
        }
    });
    Ok(())
}
