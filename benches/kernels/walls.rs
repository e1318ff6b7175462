// SPDX-License-Identifier: MIT OR Apache-2.0
//! Grains on walls, and grains far from them: all that a call for a wall does in a step, preparation too.

use std::time::Duration;

use ellgran::contact::{Laws, Step};
use ellgran::geometry::Ellipsoid;
use ellgran::list::{ParticleArrays, Rotation, Workspace};
use ellgran::simd::InstructionSet;
use ellgran::vector::Vector3;
use ellgran::walls::{
    compute_wall, compute_wall_in_lanes, End, Mesh, Motion, RecordsInput, ShapeParameters, Side,
    Wall, WallInput, WallOutput,
};

use crate::clock::{since, Clock};
use crate::scene::Random;

/// Distance of neighbours: they do not touch each other.
const SPACING: f64 = 5.0;
const DEPTH: f64 = 0.02;
/// Sides of the triangles of a coarse mesh, and of one whose triangles are as large as grains.
const COARSE: f64 = 2.0 * SPACING;
const FINE: f64 = 2.0;

/// Surfaces on which a square layer of grains lies, in the plane `z = 0` and about the origin.
#[derive(Clone, Copy)]
pub enum Surface {
    Plane,
    /// Lying, of this radius, grains inside: they touch where it is lowest.
    Cylinder(f64),
    /// Squares along a side, and the side of each: two triangles a square.
    Mesh(usize, f64),
}

impl Surface {
    fn wall(self) -> Wall {
        let mut wall = Wall::new();
        let shape = |radius: f64, point: Vector3, axis: Vector3| ShapeParameters {
            point,
            axis,
            radii: [radius, 0.0],
            bounds: [f64::NEG_INFINITY, f64::INFINITY],
            ends: [End::None; 2],
            side: Side::Inside,
        };
        match self {
            Surface::Plane => {
                let up = Vector3::new(0.0, 0.0, 1.0);
                wall.add_shape("plane", &shape(0.0, Vector3::ZERO, up))
            }
            Surface::Cylinder(radius) => {
                let (axis, middle) = (Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 0.0, radius));
                wall.add_shape("cylinder", &shape(radius, middle, axis))
            }
            Surface::Mesh(squares, side) => {
                let at = |k: usize| side * (k as f64 - 0.5 * squares as f64);
                let corner = |i: usize, j: usize| Vector3::new(at(i), at(j), 0.0);
                let triangles = (0..squares * squares)
                    .flat_map(|k| {
                        let (i, j) = (k % squares, k / squares);
                        let [a, b] = [corner(i, j), corner(i + 1, j)];
                        let [c, d] = [corner(i + 1, j + 1), corner(i, j + 1)];
                        [[a, b, c], [a, c, d]]
                    })
                    .collect();
                Mesh::new(triangles).map(|mesh| wall.add_mesh(mesh))
            }
        }
        .expect("a surface of the table");
        wall
    }

    /// Height of the surface.
    fn height(self, y: f64) -> f64 {
        match self {
            Surface::Cylinder(radius) => radius - (radius * radius - y * y).sqrt(),
            _ => 0.0,
        }
    }
}

/// What is timed: a surface, grains along a side of the layer, and whether they lie on it or far above.
pub struct Case {
    pub name: &'static str,
    pub surface: Surface,
    side: usize,
    far: bool,
}

const fn case(name: &'static str, surface: Surface, side: usize, far: bool) -> Case {
    Case {
        name,
        surface,
        side,
        far,
    }
}

pub const CASES: &[Case] = &[
    case("wall, plane", Surface::Plane, 12, false),
    case("wall, cylinder", Surface::Cylinder(300.0), 12, false),
    case(
        "wall, mesh of 98 triangles",
        Surface::Mesh(7, COARSE),
        12,
        false,
    ),
    case(
        "wall, mesh of 100352 triangles",
        Surface::Mesh(224, COARSE),
        12,
        false,
    ),
    case(
        "wall, mesh of triangles as large as grains",
        Surface::Mesh(224, FINE),
        12,
        false,
    ),
    case("wall, far from a plane", Surface::Plane, 256, true),
    case(
        "wall, far from a cylinder",
        Surface::Cylinder(3000.0),
        256,
        true,
    ),
    case(
        "wall, far from a mesh of 100352 triangles",
        Surface::Mesh(224, COARSE),
        256,
        true,
    ),
];

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
        let wall = case.surface.wall();
        let count = case.side * case.side;
        let mut random = Random::new(11);
        let mut quaternions = Vec::with_capacity(count);
        let mut positions = Vec::with_capacity(count);
        for k in 0..count {
            let q: [f64; 4] = core::array::from_fn(|_| 2.0 * random.unit() - 1.0);
            let size = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            let q = q.map(|x| x / size);
            let body = Ellipsoid::new(semi_axes, q).expect("an ellipsoid");
            let reach = body.support(Vector3::new(0.0, 0.0, -1.0)).point.z;
            let place = |n: usize| SPACING * (n as f64 - 0.5 * (case.side - 1) as f64);
            let (x, y) = (place(k % case.side), place(k / case.side));
            let above = if case.far { 10.0 * SPACING } else { -DEPTH };
            positions.push([x, y, case.surface.height(y) - reach + above]);
            quaternions.push(q);
        }
        let length = wall.histories(laws).length();
        let mut run = Run {
            laws,
            step,
            wall,
            workspace: Workspace::new(InstructionSet::widest()),
            semi_axes,
            positions,
            velocities: vec![[1e-3, 2e-3, -1e-3]; count],
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
                .prepare_chosen_records(&arrays, types, self.wall.near())
                .expect("the layer is made of ellipsoids");
            let input = RecordsInput {
                laws: self.laws,
                wall_type: 1,
                near: self.workspace.chosen_records(),
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
