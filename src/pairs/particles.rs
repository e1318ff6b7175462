// SPDX-License-Identifier: MIT OR Apache-2.0
//! An engine's particle arrays, and what is made of them once a step.

use super::candidates::Candidates;
use super::preparation::{Prepare, Prepared};
use super::ranges;
use super::registers::Line;
use super::shapes::Shapes;
use super::InstructionSet;
use crate::geometry::ellipsoid::{
    rotation_columns, within_range, LARGEST_ASPECT_RATIO, LARGEST_SEMI_AXIS, LEAST_SEMI_AXIS,
};
use crate::geometry::{Ellipsoid, ShapeError, Tangent, Vector3};
use crate::message::{Number, Numbers};

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

/// A prepared particle as the lanes load it: two cache lines, transposed into registers. What they hold depends on the
/// shapes of the list (`shapes.rs`).
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Record {
    /// The position, and some of the shape and its pose.
    pub pose: Line,
    /// The rest of the shape, velocity, and angular velocity.
    pub motion: Line,
}

impl Record {
    /// Nothing yet.
    pub(super) const NONE: Record = Record {
        pose: Line::ZERO,
        motion: Line::ZERO,
    };

    /// Of a particle, for a list of these shapes. The quaternion is of length 1.
    pub(super) fn new(
        shapes: Shapes,
        [x, y, z]: [f64; 3],
        semi_axes: [f64; 3],
        [q0, q1, q2, q3]: [f64; 4],
        [vx, vy, vz]: [f64; 3],
        omega: Vector3,
    ) -> Record {
        let [a, b, c] = semi_axes;
        let w = omega;
        if shapes == Shapes::Ellipsoids {
            return Record {
                pose: Line([x, y, z, q0, q1, q2, q3, a]),
                motion: Line([b, c, vx, vy, vz, w.x, w.y, w.z]),
            };
        }
        let polar = polar_axis(&semi_axes);
        let e = rotation_columns([q0, q1, q2, q3], 2.0)[polar];
        let (a, c) = (semi_axes[polar], semi_axes[(polar + 1) % 3]);
        Record {
            pose: Line([x, y, z, e.x, e.y, e.z, a, c]),
            motion: Line([vx, vy, vz, w.x, w.y, w.z, 1.0 / a, 1.0 / c]),
        }
    }

    /// Centre.
    #[inline(always)]
    pub fn position(&self) -> Vector3 {
        let p = &self.pose.0;
        Vector3::new(p[0], p[1], p[2])
    }

    /// The same particle for the scalar path. Of a spheroid the axis alone is known: any other two serve.
    pub(super) fn particle(&self, shapes: Shapes, kind: u32, inverse_mass: f64) -> Particle {
        let (p, m) = (&self.pose.0, &self.motion.0);
        let (axes, semi_axes, motion) = if shapes == Shapes::Ellipsoids {
            (
                rotation_columns([p[3], p[4], p[5], p[6]], 2.0),
                Vector3::new(p[7], m[0], m[1]),
                [m[2], m[3], m[4], m[5], m[6], m[7]],
            )
        } else {
            let e = Vector3::new(p[3], p[4], p[5]);
            let Tangent { u, v } = Tangent::new(e);
            (
                [u, v, e],
                Vector3::new(p[7], p[7], p[6]),
                [m[0], m[1], m[2], m[3], m[4], m[5]],
            )
        };
        let body = Ellipsoid {
            axes,
            semi_axes,
            inverse_semi_axes: Vector3::new(
                1.0 / semi_axes.x,
                1.0 / semi_axes.y,
                1.0 / semi_axes.z,
            ),
        };
        Particle {
            position: self.position(),
            radius: body.bounding_radius(),
            body,
            velocity: Vector3::new(motion[0], motion[1], motion[2]),
            omega: Vector3::new(motion[3], motion[4], motion[5]),
            inverse_mass,
            kind,
            sphere: body.is_sphere(),
        }
    }
}

/// Index of the axis of revolution of a shape with two equal semi-axes; the last of a sphere.
#[inline(always)]
pub(super) fn polar_axis(&[a, b, c]: &[f64; 3]) -> usize {
    if a == b {
        2
    } else if b == c {
        0
    } else {
        1
    }
}

/// Memory that one thread of calls keeps from step to step; grows only when the number of particles or of pairs does.
#[derive(Debug)]
pub struct Workspace {
    particles: Vec<Particle>,
    /// For the lanes.
    pub(super) records: Records,
    /// Pairs that may touch.
    pub(super) candidates: Candidates,
    /// The walls of the last call.
    pub walls: Vec<super::MovingPlane>,
    /// What the pairs are computed on.
    pub instruction_set: InstructionSet,
    /// Whether histories stay here from step to step, until [`Workspace::write_history`] or a changed list.
    pub keeps_history: bool,
    /// Whether [`super::compute_pairs`] records every touching pair.
    pub records_contacts: bool,
    /// The touching pairs of the last call that recorded them; none after one that did not.
    pub contacts: super::ContactRecords,
    /// Whether the rows of the list were looked through since the list changed.
    pub(super) list_is_known: bool,
    /// Contacts so far that were deeper than Hertz' law allows ([`crate::geometry::ContactSearch::deep`]).
    pub deep_contacts: u64,
    /// Is told of large memory just allocated, with its length in bytes.
    pub allocated: Allocated,
}

/// See [`Workspace::allocated`].
pub type Allocated = fn(*const u8, usize);

/// Room for `length` entries, of which the caller is told before it is touched.
pub(super) fn reserve<T>(vector: &mut Vec<T>, length: usize, allocated: Allocated) {
    let before = vector.capacity();
    vector.reserve(length.saturating_sub(vector.len()));
    if vector.capacity() != before {
        allocated(vector.as_ptr().cast(), vector.capacity() * size_of::<T>());
    }
}

/// Particles prepared for the lanes.
#[derive(Debug, Default)]
pub(super) struct Records {
    pub records: Vec<Record>,
    pub types: Vec<u32>,
    /// Empty where no law reads masses.
    pub inverse_masses: Vec<f64>,
    /// Force and torque of this step, zero between steps.
    pub sums: Vec<Line>,
    /// What the records are made for.
    pub shapes: Shapes,
}

impl Records {
    fn bytes(&self) -> usize {
        self.records.capacity() * core::mem::size_of::<Record>()
            + self.types.capacity() * core::mem::size_of::<u32>()
            + self.inverse_masses.capacity() * core::mem::size_of::<f64>()
            + self.sums.capacity() * core::mem::size_of::<Line>()
    }
}

impl Workspace {
    /// An empty workspace for an instruction set.
    pub fn new(instruction_set: InstructionSet) -> Self {
        Workspace {
            particles: Vec::new(),
            records: Records::default(),
            candidates: Candidates::default(),
            walls: Vec::new(),
            instruction_set,
            keeps_history: false,
            records_contacts: false,
            contacts: super::ContactRecords::default(),
            list_is_known: false,
            deep_contacts: 0,
            allocated: |_, _| (),
        }
    }

    /// Checks and prepares all particles, for one contact at a time.
    ///
    /// # Errors
    /// The first particle with a position, velocity, angular velocity or mass out of range ([`ranges`]), a shape or pose that
    /// is none, or a type out of range.
    pub fn prepare<S: Fn(usize) -> Option<([f64; 3], [f64; 4])>, I: Fn(usize) -> i64>(
        &mut self,
        arrays: &ParticleArrays<'_, S, I>,
        types: usize,
    ) -> Result<(), ParticleError> {
        self.particles.clear();
        self.particles.reserve(arrays.positions.len());
        for k in 0..arrays.positions.len() {
            let particle = prepare_one(arrays, k, types).map_err(|what| ParticleError {
                identifier: (arrays.identifier)(k),
                what,
            })?;
            self.particles.push(particle);
        }
        Ok(())
    }

    /// Checks and prepares the particles `chosen` alone, in that order.
    ///
    /// # Errors
    /// As [`Workspace::prepare`].
    pub fn prepare_chosen<S: Fn(usize) -> Option<([f64; 3], [f64; 4])>, I: Fn(usize) -> i64>(
        &mut self,
        arrays: &ParticleArrays<'_, S, I>,
        types: usize,
        chosen: &[usize],
    ) -> Result<(), ParticleError> {
        self.particles.clear();
        self.particles.reserve(arrays.positions.len());
        for &k in chosen {
            let particle = prepare_one(arrays, k, types).map_err(|what| ParticleError {
                identifier: (arrays.identifier)(k),
                what,
            })?;
            self.particles.push(particle);
        }
        Ok(())
    }

    /// Prepares the particles for the pairs of a neighbour list: all of them, or, where the list is `unchanged` since the
    /// last call and no particle has moved far since then, those that have a neighbour near enough to touch.
    ///
    /// `unchanged` says that particles, their order, the list and its histories are those of the last call; else what is kept
    /// here and was not written is lost.
    ///
    /// # Errors
    /// As [`Workspace::prepare`]. A particle that cannot touch any other is checked for a finite pose in every call, for
    /// the rest when the list changes.
    pub fn prepare_for_pairs<S: Fn(usize) -> Option<([f64; 3], [f64; 4])>, I: Fn(usize) -> i64>(
        &mut self,
        arrays: &ParticleArrays<'_, S, I>,
        laws: &super::Laws,
        unchanged: bool,
    ) -> Result<(), ParticleError> {
        let types = laws.types();
        self.list_is_known &= unchanged;
        if !self.works_in_lanes(laws) {
            return self.prepare(arrays, types);
        }
        let count = arrays.positions.len();
        let with_masses = !arrays.contact_masses.is_empty();
        let same_masses = with_masses != self.records.inverse_masses.is_empty();
        let mut outcome = Prepared::default();
        if !unchanged {
            // Of another list: there is no place any more for what was kept.
            self.candidates.batches.discard();
        }
        if unchanged && same_masses {
            let mut hold = self.candidates.are_for(count);
            if hold {
                self.candidates.count_step();
                hold = !self.candidates.should_be_fewer(arrays);
            }
            if hold {
                self.instruction_set.run(Prepare {
                    arrays,
                    candidates: Some(&self.candidates),
                    types,
                    records: &mut self.records,
                    outcome: &mut outcome,
                });
                hold = !outcome.moved;
                if !hold {
                    self.candidates.adapt(1.0);
                }
            }
            // Batches are made of pairs of one kind of law.
            if hold && !outcome.types_changed {
                return named(arrays, outcome);
            }
            outcome = Prepared::default();
        }
        self.candidates.forget();
        let r = &mut self.records;
        r.shapes = Shapes::of_all(arrays);
        r.records.clear();
        reserve(&mut r.records, count, self.allocated);
        r.records.resize(count, Record::NONE);
        r.types.clear();
        r.types.resize(count, 0);
        r.inverse_masses.clear();
        if with_masses {
            r.inverse_masses.resize(count, 0.0);
        }
        self.instruction_set.run(Prepare {
            arrays,
            candidates: None,
            types,
            records: &mut *r,
            outcome: &mut outcome,
        });
        named(arrays, outcome)?;
        r.sums.clear();
        reserve(&mut r.sums, count, self.allocated);
        r.sums.resize(count, Line::ZERO);
        self.candidates.begin(arrays, self.allocated);
        Ok(())
    }

    /// Whether the pairs under these laws are taken in lanes. Hale's form breaks where the exact one does not, and is not
    /// in the lanes.
    pub(super) fn works_in_lanes(&self, laws: &super::Laws) -> bool {
        self.instruction_set != InstructionSet::Scalar && !laws.features().hale
    }

    /// Whether the list's own histories are behind those that are kept here.
    pub fn has_unwritten_history(&self) -> bool {
        self.candidates.batches.are_unwritten()
    }

    /// Doubles that the list of the last call remembers of a pair.
    pub fn kept_history_length(&self) -> usize {
        self.candidates.batches.written_length()
    }

    /// The pairs of which histories are kept, by central particle and place in its row.
    pub fn kept_pairs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.candidates.batches.pairs()
    }

    /// Forgets the list of the last call and what is kept of it.
    pub fn forget_list(&mut self) {
        self.candidates.batches.discard();
        self.clear();
    }

    /// Brings the histories of the list of the last call up to date.
    pub fn write_history<R: super::NeighbourRows>(&mut self, rows: &mut R) {
        self.candidates.batches.write(rows);
    }

    /// Forgets the particles; keeps the memory.
    pub fn clear(&mut self) {
        self.particles.clear();
        self.records.records.clear();
        self.candidates.forget();
        self.list_is_known = false;
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.particles.capacity() * core::mem::size_of::<Particle>()
            + self.records.bytes()
            + self.candidates.bytes()
            + self.contacts.bytes()
    }

    /// The particles prepared one at a time.
    pub fn particles(&self) -> &[Particle] {
        &self.particles
    }
}

/// The failure, with the name of its particle.
fn named<S: Fn(usize) -> Option<([f64; 3], [f64; 4])>, I: Fn(usize) -> i64>(
    arrays: &ParticleArrays<'_, S, I>,
    outcome: Prepared,
) -> Result<(), ParticleError> {
    match outcome.failure {
        None => Ok(()),
        Some((k, what)) => Err(ParticleError {
            identifier: (arrays.identifier)(k),
            what,
        }),
    }
}

/// One particle for the lanes: its record, type, and the inverse of its mass.
pub(super) fn prepare_record<S: Fn(usize) -> Option<([f64; 3], [f64; 4])>, I: Fn(usize) -> i64>(
    arrays: &ParticleArrays<'_, S, I>,
    k: usize,
    types: usize,
    shapes: Shapes,
) -> Result<(Record, u32, f64), String> {
    let p = prepare_one(arrays, k, types)?;
    let (x, v) = (arrays.positions[k], arrays.velocities[k]);
    let (a, q) = (arrays.shape)(k).ok_or_else(no_shape)?;
    let q = within_range(q).map_err(|e| describe(e, a, q))?;
    let s = 1.0 / q.iter().map(|q| q * q).sum::<f64>().sqrt();
    let record = Record::new(shapes, x, a, q.map(|q| q * s), v, p.omega);
    Ok((record, p.kind, p.inverse_mass))
}

#[cold]
fn no_shape() -> String {
    "it has no shape: every particle must be an ellipsoid".into()
}

#[inline(always)]
fn inverse_contact_mass(mass: Option<&f64>) -> Result<f64, String> {
    match mass {
        None => Ok(0.0),
        Some(&m) => ranges::inverse_mass(m, "contact mass"),
    }
}

fn prepare_one<S: Fn(usize) -> Option<([f64; 3], [f64; 4])>, I: Fn(usize) -> i64>(
    arrays: &ParticleArrays<'_, S, I>,
    k: usize,
    types: usize,
) -> Result<Particle, String> {
    let position = ranges::position(arrays.positions[k])?;
    let velocity = ranges::velocity(arrays.velocities[k])?;
    let kind = arrays.types[k];
    if kind < 1 || kind as usize > types {
        return Err(format!("type {kind} is not between 1 and {types}"));
    }
    let (semi_axes, quaternion) = (arrays.shape)(k).ok_or_else(no_shape)?;
    let body =
        Ellipsoid::new(semi_axes, quaternion).map_err(|e| describe(e, semi_axes, quaternion))?;
    let omega = match arrays.rotation {
        Rotation::Velocity(w) => ranges::angular_velocity(w[k])?,
        Rotation::Momentum(l, masses) => {
            let l = ranges::vector(l[k], f64::MAX, "angular momentum")?;
            let mass = masses[k];
            if !(ranges::is_mass(mass) && mass.is_finite()) {
                return Err(format!(
                    "mass = {} must be a finite number greater than 0, from {:e} to {:e}",
                    Number(mass),
                    ranges::LEAST_MASS,
                    ranges::LARGEST_MASS
                ));
            }
            let omega = angular_velocity(&body, mass, l).to_array();
            ranges::vector(
                omega,
                ranges::LARGEST_VELOCITY,
                "angular velocity (from the angular momentum)",
            )?
        }
    };
    let inverse_mass = inverse_contact_mass(arrays.contact_masses.get(k))?;
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
            "quaternion (w x y z) = {} is not a rotation",
            Numbers(&quaternion)
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
