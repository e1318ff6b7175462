// SPDX-License-Identifier: MIT OR Apache-2.0
//! Grains on walls, and grains far from them: all that a call for a wall does in a step, preparation too.

use std::time::Duration;

use ellgran::contact::{Laws, Step};
use ellgran::list::{ParticleArrays, PreparedBy, Rotation, Workspace};
use ellgran::simd::InstructionSet;
use ellgran::vector::Vector3;
use ellgran::walls::{
    compute_wall, compute_wall_in_lanes, End, Mesh, Motion, RecordsInput, ShapeParameters, Side,
    Wall, WallInput, WallOutput,
};

use crate::clock::{since, Clock};
use crate::layer::{grains, Case, Surface, VELOCITY};

fn wall(surface: Surface) -> Wall {
    let mut wall = Wall::new();
    let shape = |radius: f64, point: Vector3, axis: Vector3| ShapeParameters {
        point,
        axis,
        radii: [radius, 0.0],
        bounds: [f64::NEG_INFINITY, f64::INFINITY],
        ends: [End::None; 2],
        side: Side::Inside,
    };
    match surface {
        Surface::Plane => {
            let up = Vector3::new(0.0, 0.0, 1.0);
            wall.add_shape("plane", &shape(0.0, Vector3::ZERO, up))
        }
        Surface::Cylinder(radius) => {
            let (axis, middle) = (Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 0.0, radius));
            wall.add_shape("cylinder", &shape(radius, middle, axis))
        }
        Surface::Mesh(..) => {
            let triangles = surface.triangles().into_iter();
            Mesh::new(triangles.map(|t| t.map(Vector3::from_array)).collect())
                .map(|mesh| wall.add_mesh(mesh))
        }
    }
    .expect("a surface of the table");
    wall
}

pub struct Run<'a> {
    laws: &'a Laws,
    step: &'a Step,
    wall: Wall,
    workspace: Workspace,
    semi_axes: [f64; 3],
    positions: Vec<[f64; 3]>,
    velocities: Vec<[f64; 3]>,
    quaternions: Vec<[f64; 4]>,
    types: Vec<i32>,
    histories: Vec<f64>,
    forces: Vec<[f64; 3]>,
    torques: Vec<[f64; 3]>,
    pub contacts: usize,
}

impl<'a> Run<'a> {
    pub fn new(case: &Case, semi_axes: [f64; 3], laws: &'a Laws, step: &'a Step) -> Self {
        let wall = wall(case.surface);
        let (positions, quaternions) = grains(case, semi_axes);
        let count = positions.len();
        let length = wall.histories(laws).length();
        let mut run = Run {
            laws,
            step,
            wall,
            workspace: Workspace::new(InstructionSet::widest()),
            semi_axes,
            positions,
            velocities: vec![VELOCITY; count],
            quaternions,
            types: vec![1; count],
            histories: vec![0.0; count * length],
            forces: vec![[0.0; 3]; count],
            torques: vec![[0.0; 3]; count],
            contacts: 0,
        };
        for _ in 0..8 {
            run.advance();
        }
        run
    }

    pub fn particles(&self) -> usize {
        self.positions.len()
    }

    pub fn history_bytes(&self) -> usize {
        self.histories.len() / self.particles() * size_of::<f64>()
    }

    pub fn advance(&mut self) -> Duration {
        let started = Clock::now();
        let largest = self.semi_axes.into_iter().fold(0.0, f64::max);
        let positions = &self.positions;
        self.wall.find_near(&Motion::REST, positions.len(), |k| {
            Some((Vector3::from_array(positions[k]), largest))
        });
        let arrays = ParticleArrays {
            owned: positions.len(),
            positions,
            velocities: &self.velocities,
            rotation: Rotation::Velocity(&self.velocities),
            of_step: false,
            changes: &[],
            contact_masses: &[],
            types: &self.types,
            shape: |k| Some((self.semi_axes, self.quaternions[k])),
            identifier: |k| k as i64,
        };
        let (types, set) = (self.laws.types(), self.workspace.instruction_set);
        let mut output = WallOutput {
            acts_on: &|_| true,
            histories: &mut self.histories,
            forces: &mut self.forces,
            torques: &mut self.torques,
        };
        // As the C interface does
        let load = if self.wall.is_taken_in_lanes(self.laws, 1, set, None) {
            self.workspace
                .prepare_chosen_records(&arrays, types, self.wall.near(), PreparedBy::Nobody)
                .expect("the layer is made of ellipsoids");
            let input = RecordsInput {
                laws: self.laws,
                wall_type: 1,
                near: self.workspace.chosen_records(PreparedBy::Nobody),
                masses: None,
                motion: &Motion::REST,
                step: self.step,
                instruction_set: set,
            };
            compute_wall_in_lanes(&mut self.wall, &input, &mut output, None)
        } else {
            self.workspace
                .prepare_chosen(&arrays, types, self.wall.near())
                .expect("the layer is made of ellipsoids");
            let input = WallInput {
                laws: self.laws,
                wall_type: 1,
                near: self.workspace.particles(),
                motion: &Motion::REST,
                step: self.step,
                instruction_set: set,
            };
            compute_wall(&mut self.wall, &input, &mut output, None)
        }
        .expect("no law of the table can break");
        self.contacts = load.contacts;
        since(&started)
    }
}
