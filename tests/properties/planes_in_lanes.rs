// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do planes that are taken in lanes from the search to the sums give on every instruction set what one contact at a time gives? All
//! that a step makes of them is compared in the tests of the C interface, on the widest set.

use crate::support::random::Stream;
use crate::support::scene::{laws, quaternion};
use ellgran::contact::{Laws, Step};
use ellgran::list::{ParticleArrays, Rotation, Workspace};
use ellgran::simd::InstructionSet;
use ellgran::vector::Vector3;
use ellgran::walls::{
    compute_planes, compute_wall, End, Motion, PlaneInput, ShapeParameters, Side, Wall, WallInput,
    WallOutput,
};

const PARTICLES: usize = 300;
const STEP: Step = Step {
    time_step: 1e-3,
    advance_history: true,
};

/// Grains of aspect ratios up to 30 on both sides of a corner, with two types in turn.
struct Scene {
    positions: Vec<[f64; 3]>,
    velocities: Vec<[f64; 3]>,
    types: Vec<i32>,
    shapes: Vec<([f64; 3], [f64; 4])>,
}

impl Scene {
    fn new(stream: &mut Stream, spheroids: bool) -> Scene {
        let mut scene = Scene {
            positions: vec![],
            velocities: vec![],
            types: vec![],
            shapes: vec![],
        };
        for k in 0..PARTICLES {
            let [a, b, c] = stream.semi_axes(30.0);
            let axes = if spheroids { [a, b, b] } else { [a, b, c] };
            scene.shapes.push((axes, quaternion(stream.rotation())));
            // At one plane, the other, or both
            let away = [0; 2].map(|_| stream.uniform(0.1, 1.0));
            let place = [[away[0], 9.0], [9.0, away[1]], away][k % 3];
            scene.positions.push([place[0], 0.3 * k as f64, place[1]]);
            let velocity = [0; 3].map(|_| stream.uniform(-1.0, 1.0));
            scene.velocities.push(velocity);
            scene.types.push(1 + k as i32 % 2);
        }
        scene
    }

    /// Forces and torques of two steps, the number of contacts, and how many particles touch both planes.
    fn compute(&self, set: InstructionSet, laws: &Laws, in_lanes: bool) -> (Vec<f64>, [usize; 2]) {
        let mut wall = Wall::new();
        for axis in [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]] {
            let plane = ShapeParameters {
                point: Vector3::ZERO,
                axis: Vector3::from_array(axis),
                radii: [0.0; 2],
                bounds: [0.0; 2],
                ends: [End::None; 2],
                side: Side::Inside,
            };
            wall.add_shape("plane", &plane).unwrap();
        }
        assert!(
            set == InstructionSet::Scalar
                || wall.is_taken_in_lanes(laws, 1, &Motion::REST, set, None)
        );
        let arrays = ParticleArrays {
            owned: PARTICLES,
            positions: &self.positions,
            velocities: &self.velocities,
            rotation: Rotation::Velocity(&self.velocities),
            of_step: false,
            changes: &[],
            contact_masses: &[],
            types: &self.types,
            shape: |k| Some(self.shapes[k]),
            identifier: |k| k as i64,
        };
        let length = wall.histories(laws).length();
        let mut histories = vec![0.0; PARTICLES * length];
        let (mut forces, mut torques) = (vec![[0.0; 3]; PARTICLES], vec![[0.0; 3]; PARTICLES]);
        let mut workspace = Workspace::new(set);
        let mut contacts = 0;
        for _ in 0..2 {
            wall.find_near(&Motion::REST, PARTICLES, |k| {
                let largest = self.shapes[k].0.into_iter().fold(0.0, f64::max);
                Some((Vector3::from_array(self.positions[k]), largest))
            });
            let mut output = WallOutput {
                acts_on: &|_| true,
                histories: &mut histories,
                forces: &mut forces,
                torques: &mut torques,
            };
            let (types, motion, step) = (laws.types(), &Motion::REST, &STEP);
            let load = if in_lanes {
                workspace
                    .prepare_chosen_records(&arrays, types, wall.near())
                    .unwrap();
                let input = PlaneInput {
                    laws,
                    wall_type: 1,
                    near: workspace.chosen_records(),
                    masses: None,
                    motion,
                    step,
                    instruction_set: set,
                };
                compute_planes(&mut wall, &input, &mut output, None)
            } else {
                workspace
                    .prepare_chosen(&arrays, types, wall.near())
                    .unwrap();
                let input = WallInput {
                    laws,
                    wall_type: 1,
                    near: workspace.particles(),
                    motion,
                    step,
                    instruction_set: set,
                };
                compute_wall(&mut wall, &input, &mut output, None)
            };
            contacts = load.unwrap().contacts;
        }
        let several = histories.chunks_exact(length).filter(|h| h[0] > 1.0);
        let counts = [contacts, several.count()];
        ([forces.concat(), torques.concat()].concat(), counts)
    }
}

#[test]
fn every_instruction_set_gives_what_one_contact_at_a_time_gives() {
    let mut stream = Stream::new(3301);
    let laws = laws(&[
        "nfd 1e3 0.3 0.5 0.5 tangential tfd 0.5",
        "nfd 3e3 0.2 0.1 0.1 tangential tfd 0.2",
    ]);
    for spheroids in [true, false] {
        let scene = Scene::new(&mut stream, spheroids);
        let (expected, counts) = scene.compute(InstructionSet::Scalar, &laws, false);
        println!("{counts:?} contacts, particles that touch both planes");
        assert!(counts[0] > PARTICLES / 3 && counts[1] > PARTICLES / 20);
        let largest = expected.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let sets = InstructionSet::ALL.into_iter();
        for set in sets.filter(|s| *s != InstructionSet::Scalar && s.is_available()) {
            let (found, same) = scene.compute(set, &laws, true);
            assert_eq!(same, counts, "{}", set.name());
            for (a, b) in found.iter().zip(&expected) {
                let apart = (a - b).abs();
                assert!(apart <= 1e-11 * largest, "{}: {a} and {b}", set.name());
            }
        }
    }
}
