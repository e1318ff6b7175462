// SPDX-License-Identifier: MIT OR Apache-2.0
//! The particles as the lanes load them, and the simplest closed form that serves all their shapes.

use super::arrays::{no_shape, prepare_one, ParticleArrays, ParticleShapes};
use super::memory::{reserve, Allocated};
use crate::contact::forces::MotionChange;
use crate::contact::particle::{describe, Particle};
use crate::geometry::ellipsoid::{rotation_columns, within_range};
use crate::geometry::Ellipsoid;
use crate::simd::Line;
use crate::vector::{Tangent, Vector3};

/// The simplest form that serves all shapes of a list.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Shapes {
    /// Three semi-axes the same.
    Spheres,
    /// Two of them the same: an axis of revolution.
    Spheroids,
    /// Any.
    #[default]
    Ellipsoids,
}

impl Shapes {
    /// Of one shape.
    #[inline(always)]
    pub fn of([a, b, c]: &[f64; 3]) -> Shapes {
        match (a == b, b == c, a == c) {
            (true, true, _) => Shapes::Spheres,
            (false, false, false) => Shapes::Ellipsoids,
            _ => Shapes::Spheroids,
        }
    }

    /// Of all particles. One without a shape, which the preparation refuses, does not count.
    pub fn of_all<A: ParticleShapes, I: Fn(usize) -> i64>(
        arrays: &ParticleArrays<'_, A, I>,
    ) -> Shapes {
        let mut shapes = Shapes::Spheres;
        for k in 0..arrays.positions.len() {
            if let Some((a, _)) = arrays.shape.of(k) {
                shapes = shapes.max(Shapes::of(&a));
            }
            if shapes == Shapes::Ellipsoids {
                break;
            }
        }
        shapes
    }
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

    /// Velocity and angular velocity, in a list of these shapes.
    pub fn velocities(&self, shapes: Shapes) -> [Vector3; 2] {
        let m = &self.motion.0[if shapes == Shapes::Ellipsoids { 2 } else { 0 }..];
        [
            Vector3::new(m[0], m[1], m[2]),
            Vector3::new(m[3], m[4], m[5]),
        ]
    }

    /// Whether it is a sphere, in a list of these shapes.
    pub fn is_sphere(&self, shapes: Shapes) -> bool {
        let (p, m) = (&self.pose.0, &self.motion.0);
        match shapes {
            Shapes::Spheres => true,
            Shapes::Spheroids => p[6] == p[7],
            Shapes::Ellipsoids => p[7] == m[0] && m[0] == m[1],
        }
    }

    /// The same particle for the scalar path. Of a spheroid the axis alone is known: any other two serve.
    pub(super) fn particle(
        &self,
        shapes: Shapes,
        particle_type: u32,
        inverse_mass: f64,
        change: Option<MotionChange>,
    ) -> Particle {
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
            change,
            inverse_mass,
            particle_type,
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

/// Particles prepared for the lanes.
#[derive(Debug, Default)]
pub(super) struct Records {
    pub records: Vec<Record>,
    pub types: Vec<u32>,
    /// Empty where no law reads masses.
    pub inverse_masses: Vec<f64>,
    /// What the motions at the step have more than those of the records, which are then those of the half step ([`line_of_change`]); empty
    /// where nobody asks for the latter.
    pub changes: Vec<Line>,
    /// Whether forces see velocities of the step.
    pub of_step: bool,
    /// Force and torque of this step, zero between steps.
    pub sums: Vec<Line>,
    /// What the records are made for.
    pub shapes: Shapes,
    /// Of chosen particles, where their records stand among those that were made for the pairs, or [`OWN`]; empty where all are here.
    pub places: Vec<u32>,
}

/// In [`Records::places`]: the record stands here.
pub(super) const OWN: u32 = u32::MAX;

impl Records {
    /// For `count` particles of these shapes, of which there are at most `most`.
    pub fn make_room<S: ParticleShapes, I: Fn(usize) -> i64>(
        &mut self,
        arrays: &ParticleArrays<'_, S, I>,
        shapes: Shapes,
        count: usize,
        allocated: Allocated,
    ) {
        let most = arrays.positions.len();
        let with_masses = !arrays.contact_masses.is_empty();
        let with_changes = !arrays.changes.is_empty();
        self.of_step = arrays.of_step;
        self.shapes = shapes;
        // What was there is overwritten: only places that are new are filled.
        if self.records.capacity() < count {
            self.records.clear();
            reserve(&mut self.records, most, allocated);
        }
        self.records.resize(count, Record::NONE);
        self.types.resize(count, 0);
        self.inverse_masses
            .resize(if with_masses { count } else { 0 }, 0.0);
        let changes = if with_changes { count } else { 0 };
        if self.changes.capacity() < changes {
            self.changes.clear();
            reserve(&mut self.changes, most, allocated);
        }
        self.changes.resize(changes, Line::ZERO);
        self.places.clear();
    }

    /// To be read; those that stand elsewhere among the records `of_pairs`.
    ///
    /// # Panics
    /// Some stand elsewhere, and nothing is said of where.
    pub fn view<'a>(&'a self, of_pairs: Option<&'a Records>) -> ParticleRecords<'a> {
        let elsewhere = of_pairs.filter(|_| !self.places.is_empty());
        assert!(
            self.places.is_empty() || elsewhere.is_some(),
            "records that stand with those of the pairs are asked for without them"
        );
        ParticleRecords {
            records: &self.records,
            types: &self.types,
            inverse_masses: &self.inverse_masses,
            changes: &self.changes,
            elsewhere: elsewhere.map(|all| Elsewhere {
                records: &all.records,
                changes: &all.changes,
                places: &self.places,
            }),
            of_step: self.of_step,
            shapes: self.shapes,
        }
    }

    pub fn bytes(&self) -> usize {
        self.records.capacity() * core::mem::size_of::<Record>()
            + self.types.capacity() * core::mem::size_of::<u32>()
            + self.inverse_masses.capacity() * core::mem::size_of::<f64>()
            + self.changes.capacity() * core::mem::size_of::<Line>()
            + self.sums.capacity() * core::mem::size_of::<Line>()
            + self.places.capacity() * core::mem::size_of::<u32>()
    }
}

/// Records of particles, to be read.
#[derive(Clone, Copy, Debug)]
pub struct ParticleRecords<'a> {
    /// Shape, pose and motion.
    pub(crate) records: &'a [Record],
    /// Types, counted from 1.
    pub(crate) types: &'a [u32],
    /// Empty where no law reads masses.
    pub(crate) inverse_masses: &'a [f64],
    /// Empty where the motion of the step is that of the half step, or not known.
    pub(crate) changes: &'a [Line],
    /// The records and changes that are read instead of those above.
    pub(super) elsewhere: Option<Elsewhere<'a>>,
    /// Whether forces see velocities of the step.
    pub(crate) of_step: bool,
    /// What the records are made for.
    pub(crate) shapes: Shapes,
}

/// Records of other particles too, among which some stand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Elsewhere<'a> {
    records: &'a [Record],
    changes: &'a [Line],
    /// [`Records::places`].
    places: &'a [u32],
}

impl<'a> ParticleRecords<'a> {
    /// How many particles.
    #[inline(always)]
    pub(crate) fn count(&self) -> usize {
        self.records.len()
    }

    /// The record of a particle.
    #[inline(always)]
    pub(crate) fn record(&self, k: usize) -> &'a Record {
        match &self.elsewhere {
            Some(all) if all.places[k] != OWN => &all.records[all.places[k] as usize],
            _ => &self.records[k],
        }
    }

    /// What its motion has more at the step, as the lanes load it; `None` where the motion of the step is that of the half step, or not known.
    #[inline(always)]
    pub(crate) fn line_of_change(&self, k: usize) -> Option<&'a Line> {
        match &self.elsewhere {
            Some(all) if all.places[k] != OWN => all.changes.get(all.places[k] as usize),
            _ => self.changes.get(k),
        }
    }

    /// A particle for the scalar path.
    pub(crate) fn particle(&self, k: usize) -> Particle {
        let inverse_mass = self.inverse_masses.get(k).copied().unwrap_or(0.0);
        let change = self.of_step.then(|| self.change(k));
        self.record(k)
            .particle(self.shapes, self.types[k], inverse_mass, change)
    }

    /// What the motion of a particle has more at the step.
    pub(super) fn change(&self, k: usize) -> MotionChange {
        let [x, y, z, a, b, c, ..] = self.line_of_change(k).map_or([0.0; 8], |line| line.0);
        let at_origin = MotionChange {
            velocity: Vector3::new(x, y, z),
            omega: Vector3::new(a, b, c),
        };
        MotionChange {
            velocity: at_origin.at(self.record(k).position()),
            ..at_origin
        }
    }
}

/// One particle for the lanes: its record, what its motion has more at the step, its type, and the inverse of its mass.
pub(super) fn prepare_record<S: ParticleShapes, I: Fn(usize) -> i64>(
    arrays: &ParticleArrays<'_, S, I>,
    k: usize,
    types: usize,
    shapes: Shapes,
) -> Result<(Record, Line, u32, f64), String> {
    let mut p = Particle::NONE;
    prepare_one(arrays, k, types, &mut p)?;
    let x = arrays.positions[k];
    let (a, q) = arrays.shape.of(k).ok_or_else(no_shape)?;
    let q = within_range(q).map_err(|e| describe(e, a, q))?;
    let s = 1.0 / q.iter().map(|q| q * q).sum::<f64>().sqrt();
    let record = Record::new(
        shapes,
        x,
        a,
        q.map(|q| q * s),
        p.velocity.to_array(),
        p.omega,
    );
    let change = line_of_change(p.change.unwrap_or(MotionChange::NONE), p.position);
    Ok((record, change, p.particle_type, p.inverse_mass))
}

/// What the motion of a particle at `position` has more at the step, as the lanes load it: as of a rigid body in space, the velocity of its point
/// at the origin of coordinates, then the angular velocity. The difference of two lines is then the relative motion of two particles. Rounding
/// is that of the coordinates, which positions have anyway.
pub(super) fn line_of_change(change: MotionChange, position: Vector3) -> Line {
    let (v, w) = (change.at(-position), change.omega);
    Line([v.x, v.y, v.z, w.x, w.y, w.z, 0.0, 0.0])
}
