// SPDX-License-Identifier: MIT OR Apache-2.0
//! An engine's particle arrays, and what is made of them once a step.

use super::InstructionSet;
use crate::geometry::{Ellipsoid, ShapeError, Vector3};

/// Borrowed views of an engine's arrays, local particles first, ghosts after them.
pub struct ParticleArrays<'a, S: Fn(usize) -> Option<([f64; 3], [f64; 4])>, I: Fn(usize) -> i64> {
    /// Number of particles that the caller owns; the others are ghosts.
    pub owned: usize,
    /// Centres.
    pub positions: &'a [[f64; 3]],
    /// Velocities of the centres.
    pub velocities: &'a [[f64; 3]],
    /// Angular velocities in the world frame, or angular momenta.
    pub rotation: Rotation<'a>,
    /// Masses for effective masses; empty where no law reads them.
    pub contact_masses: &'a [f64],
    /// Types, counted from 1.
    pub types: &'a [i32],
    /// Semi-axes and quaternion `(w, x, y, z)` of a particle; `None` for one that is no ellipsoid.
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

/// A particle that cannot be: which, what, and the value.
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
impl std::error::Error for ParticleError {}

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
    /// Inverse of the mass for effective masses.
    pub inverse_mass: f64,
    /// Type, counted from 1.
    pub kind: u32,
    /// Whether it is a sphere.
    pub sphere: bool,
}

/// A prepared particle as the lanes load it: three cache lines, transposed into registers eight doubles at a time.
///
/// `[position, radius, axes, semi-axes | velocity, inverse mass, angular velocity, 0]`
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Record(pub [f64; 24]);

impl From<&Particle> for Record {
    #[inline(always)]
    fn from(p: &Particle) -> Self {
        let (x, a, v, w) = (p.position, p.body.semi_axes, p.velocity, p.omega);
        let [e, f, g] = p.body.axes;
        Record([
            x.x,
            x.y,
            x.z,
            p.radius,
            e.x,
            e.y,
            e.z,
            f.x,
            f.y,
            f.z,
            g.x,
            g.y,
            g.z,
            a.x,
            a.y,
            a.z,
            v.x,
            v.y,
            v.z,
            p.inverse_mass,
            w.x,
            w.y,
            w.z,
            0.0,
        ])
    }
}

/// Memory that one thread of calls keeps from step to step; grows only when the number of particles does.
#[derive(Debug)]
pub struct Workspace {
    particles: Vec<Particle>,
    records: Vec<Record>,
    /// The walls of the last call.
    pub walls: Vec<super::MovingPlane>,
    /// What the pairs are computed on.
    pub instruction_set: InstructionSet,
    /// Contacts so far that took the slow search from many starts.
    pub many_starts: u64,
}

impl Workspace {
    /// An empty workspace for an instruction set.
    pub fn new(instruction_set: InstructionSet) -> Self {
        Workspace {
            particles: Vec::new(),
            records: Vec::new(),
            walls: Vec::new(),
            instruction_set,
            many_starts: 0,
        }
    }

    /// Checks and prepares all particles.
    ///
    /// # Errors
    /// The first particle with a position, velocity or angular velocity that is not finite, a shape or pose that is
    /// none, or a type out of range.
    pub fn prepare<S: Fn(usize) -> Option<([f64; 3], [f64; 4])>, I: Fn(usize) -> i64>(
        &mut self,
        arrays: &ParticleArrays<'_, S, I>,
        types: usize,
    ) -> Result<(), ParticleError> {
        self.particles.clear();
        self.particles.reserve(arrays.positions.len());
        self.records.clear();
        let in_lanes = self.instruction_set != InstructionSet::Scalar;
        if in_lanes {
            self.records.reserve(arrays.positions.len());
        }
        for k in 0..arrays.positions.len() {
            let particle = prepare_one(arrays, k, types).map_err(|what| ParticleError {
                identifier: (arrays.identifier)(k),
                what,
            })?;
            if in_lanes {
                self.records.push(Record::from(&particle));
            }
            self.particles.push(particle);
        }
        Ok(())
    }

    /// Forgets the particles; keeps the memory.
    pub fn clear(&mut self) {
        self.particles.clear();
        self.records.clear();
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.particles.capacity() * core::mem::size_of::<Particle>()
            + self.records.capacity() * core::mem::size_of::<Record>()
    }

    /// The prepared particles.
    pub fn particles(&self) -> &[Particle] {
        &self.particles
    }

    /// The prepared particles for the lanes; none on the scalar path.
    pub fn records(&self) -> &[Record] {
        &self.records
    }
}

fn prepare_one<S: Fn(usize) -> Option<([f64; 3], [f64; 4])>, I: Fn(usize) -> i64>(
    arrays: &ParticleArrays<'_, S, I>,
    k: usize,
    types: usize,
) -> Result<Particle, String> {
    let position = finite(arrays.positions[k], "position")?;
    let velocity = finite(arrays.velocities[k], "velocity")?;
    let kind = arrays.types[k];
    if kind < 1 || kind as usize > types {
        return Err(format!("type {kind} is not between 1 and {types}"));
    }
    let (semi_axes, quaternion) =
        (arrays.shape)(k).ok_or("it has no shape: every particle must be an ellipsoid")?;
    let body =
        Ellipsoid::new(semi_axes, quaternion).map_err(|e| describe(e, semi_axes, quaternion))?;
    let omega = match arrays.rotation {
        Rotation::Velocity(w) => finite(w[k], "angular velocity")?,
        Rotation::Momentum(l, masses) => {
            let l = finite(l[k], "angular momentum")?;
            let mass = masses[k];
            if !(mass > 0.0 && mass.is_finite()) {
                return Err(format!(
                    "mass = {mass} must be a finite number greater than 0"
                ));
            }
            angular_velocity(&body, mass, l)
        }
    };
    let inverse_mass = match arrays.contact_masses.get(k) {
        None => 0.0,
        // An infinite mass is a frozen body.
        Some(&m) if m > 0.0 => 1.0 / m,
        Some(m) => return Err(format!("contact mass = {m} must be greater than 0")),
    };
    Ok(Particle {
        position,
        radius: body.bounding_radius(),
        body,
        velocity,
        omega,
        inverse_mass,
        kind: kind as u32,
        sphere: body.is_sphere(),
    })
}

fn finite(v: [f64; 3], what: &str) -> Result<Vector3, String> {
    let vector = Vector3::from_array(v);
    if vector.is_finite() {
        Ok(vector)
    } else {
        Err(format!(
            "{what} = ({} {} {}) is not finite",
            v[0], v[1], v[2]
        ))
    }
}

/// Says what is wrong with a shape, with the value.
pub fn describe(error: ShapeError, semi_axes: [f64; 3], quaternion: [f64; 4]) -> String {
    match error {
        ShapeError::SemiAxis(a) => format!(
            "semi-axis = {a} must be a finite number greater than 0, from 1e-45 to 1e45 (semi-axes {} {} {})",
            semi_axes[0], semi_axes[1], semi_axes[2]
        ),
        ShapeError::Quaternion(_) => format!(
            "quaternion (w x y z) = ({} {} {} {}) is not a rotation",
            quaternion[0], quaternion[1], quaternion[2], quaternion[3]
        ),
    }
}

/// Angular velocity of a solid ellipsoid with angular momentum `l`, both in the world frame.
pub fn angular_velocity(body: &Ellipsoid, mass: f64, l: Vector3) -> Vector3 {
    let a = body.semi_axes;
    let (x, y, z) = (a.x * a.x, a.y * a.y, a.z * a.z);
    let five_over_mass = 5.0 / mass;
    let inverse_inertia = Vector3::new(
        five_over_mass / (y + z),
        five_over_mass / (x + z),
        five_over_mass / (x + y),
    );
    body.to_world(inverse_inertia.componentwise(body.to_body(l)))
}

/// `m_i m_j/(m_i + m_j)` from inverse masses; 0 for two frozen bodies, which need no damping.
#[inline(always)]
pub fn effective_mass(inverse_i: f64, inverse_j: f64) -> f64 {
    let sum = inverse_i + inverse_j;
    if sum > 0.0 {
        1.0 / sum
    } else {
        0.0
    }
}
