// SPDX-License-Identifier: MIT OR Apache-2.0
//! A rigid wall: its parts, and the memory that its calls keep.

use super::memory::MemoryLayout;
use super::mesh::Mesh;
use super::motion::Motion;
use super::shape::{Search, Shape, ShapeParameters};
use super::table::constructor;
use crate::contact::staged::WallSurface;
use crate::contact::{ContactForces, Laws};
use crate::geometry::triangles::Triangle;
use crate::vector::Vector3;

/// Parts that move as one, and what is kept between calls so that a step allocates nothing.
#[derive(Debug, Default)]
pub struct Wall {
    pub(super) parts: Vec<Box<dyn Shape>>,
    pub(super) search: Search,
    /// Contacts of one particle: the part and its surface.
    pub(super) found: Vec<(usize, WallSurface)>,
    /// What was remembered of them at the last step.
    pub(super) before: Vec<f64>,
    /// Particles that may touch.
    pub(super) near: Vec<usize>,
    /// Force on each part in the last call, world frame.
    pub(super) part_forces: Vec<Vector3>,
    /// The contacts of the last call.
    pub(super) contacts: Vec<RecordedWallContact>,
    /// Whether a call records its contacts.
    pub records_contacts: bool,
    /// Of each of `found`, the triangle that stands for it, counted over all parts, and its normal.
    pub(super) found_triangles: Vec<Option<(usize, Vector3)>>,
    /// What acted on each triangle in the last call that recorded it.
    pub(super) triangle_loads: Vec<TriangleLoad>,
    /// Whether a call records the loads of triangles.
    pub records_triangles: bool,
}

/// What the particles do to one triangle.
#[derive(Clone, Copy, Debug, Default)]
pub struct TriangleLoad {
    /// Force on the triangle, world frame.
    pub force: Vector3,
    /// Sum of the forces that press on its plane, each from the side of its particle: pressure on the two sides adds up.
    pub pressing: f64,
}

/// What the particles do to a wall in one call.
#[derive(Clone, Copy, Debug, Default)]
pub struct WallLoad {
    /// Force on the wall, world frame.
    pub force: Vector3,
    /// Torque on the wall about [`Motion::centre`], world frame.
    pub torque: Vector3,
    /// Power that the particles give to the wall by its motion: force times velocity and torque times angular velocity.
    pub power: f64,
    /// Number of contacts.
    pub contacts: usize,
    /// Sum over the contacts of a bound of the stiffness, force/length ([`crate::force::PairLaw::largest_springs`]): the wall
    /// feels at most that in any direction in which it is displaced.
    pub stiffness: f64,
    /// The same of the damping, force x time/length.
    pub damping: f64,
}

/// One contact as it acted.
#[derive(Clone, Copy, Debug)]
pub struct RecordedWallContact {
    /// Index of the particle.
    pub particle: usize,
    /// Index of the wall's part.
    pub part: usize,
    /// Unit normal out of the wall, towards the particle, world frame.
    pub normal: Vector3,
    /// Contact point, world frame.
    pub point: Vector3,
    /// Penetration > 0.
    pub penetration: f64,
    /// Force on the particle and torque about its centre, normal and tangential force and energies, world frame; forces in it
    /// are those on the wall, torques those on the particle.
    pub forces: ContactForces,
}

impl Wall {
    /// A wall without parts.
    pub fn new() -> Self {
        Wall::default()
    }

    /// Adds the parts of a shape of the table ([`Shape`]).
    ///
    /// # Errors
    /// An unknown name, or parameters that do not make such a shape.
    pub fn add_shape(&mut self, name: &str, parameters: &ShapeParameters) -> Result<(), String> {
        let make = constructor(name)?;
        let mut parts = vec![];
        make(parameters, &mut parts)?;
        self.parts.append(&mut parts);
        Ok(())
    }

    /// Adds a surface of triangles.
    pub fn add_mesh(&mut self, mesh: Mesh) {
        self.parts.push(Box::new(mesh));
    }

    /// How many parts there are.
    pub fn part_count(&self) -> usize {
        self.parts.len()
    }

    /// How the memory of a particle is laid out.
    pub fn memory(&self, laws: &Laws) -> MemoryLayout {
        let records = self.parts.iter().map(|p| p.remembered()).sum();
        MemoryLayout::new(laws.layout(), records)
    }

    /// Finds the particles that may touch: those of which `of` gives the centre and the largest semi-axis. Of the others it
    /// gives `None`.
    pub fn find_near(
        &mut self,
        motion: &Motion,
        particles: usize,
        of: impl Fn(usize) -> Option<(Vector3, f64)>,
    ) -> &[usize] {
        self.near.clear();
        self.near.reserve(particles);
        for k in 0..particles {
            if let Some((centre, radius)) = of(k) {
                let centre = motion.point_to_wall(centre);
                if self.parts.iter().any(|p| p.may_touch(centre, radius)) {
                    self.near.push(k);
                }
            }
        }
        &self.near
    }

    /// The particles that [`Wall::find_near`] found.
    pub fn near(&self) -> &[usize] {
        &self.near
    }

    /// Force on each part in the last call, world frame.
    pub fn part_forces(&self) -> &[Vector3] {
        &self.part_forces
    }

    /// The triangles of all parts, one part after the other, in the frame of the wall.
    pub fn triangles(&self) -> impl Iterator<Item = &Triangle> {
        self.parts.iter().flat_map(|p| p.triangles())
    }

    /// What acted on each of the triangles in the last call, if it recorded that; else empty.
    pub fn triangle_loads(&self) -> &[TriangleLoad] {
        &self.triangle_loads
    }

    /// The contacts of the last call, if it recorded them.
    pub fn contacts(&self) -> &[RecordedWallContact] {
        &self.contacts
    }
}
