// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do walls whose contacts are taken in lanes from the search to the sums give on every instruction set what one contact at a time gives?
//! At each kind of surface, at rest and in motion, in three steps, so that what is remembered counts.

use crate::support::random::Stream;
use crate::support::scene::{laws, parameters, quaternion};
use crate::walls_in_lanes::{
    assert_same, corner, motions_and_changes, random_body, random_change, surfaces, touching,
    Groups,
};
use ellgran::contact::{prepare_body, Body, Laws, Step};
use ellgran::list::{ParticleArrays, PreparedBy, Rotation, Workspace};
use ellgran::simd::InstructionSet;
use ellgran::tallies::Tallies;
use ellgran::vector::Vector3;
use ellgran::walls::{
    compute_wall, compute_wall_in_lanes, End, Motion, RecordsInput, ShapeParameters, Side, Wall,
    WallInput, WallLoad, WallOutput,
};

const STEP: Step = Step {
    time_step: 1e-3,
    advance_history: true,
};

/// What engines hold of grains.
#[derive(Default)]
struct Scene {
    positions: Vec<[f64; 3]>,
    velocities: Vec<[f64; 3]>,
    /// Angular momenta where there are masses.
    rotations: Vec<[f64; 3]>,
    masses: Vec<f64>,
    changes: Vec<[f64; 6]>,
    types: Vec<i32>,
    shapes: Vec<([f64; 3], [f64; 4])>,
    of_step: bool,
}

/// What a scene came to: numbers in groups of one kind, and how many contacts there were.
struct Outcome {
    groups: Groups,
    contacts: usize,
    /// Particles with more than one contact.
    several: usize,
}

impl Scene {
    fn push(&mut self, body: &Body, change: Option<[f64; 6]>) {
        self.positions.push(body.position);
        self.velocities.push(body.velocity);
        self.rotations.push(body.angular_velocity);
        self.types.push(body.particle_type);
        self.shapes.push((body.semi_axes, body.quaternion));
        self.changes.extend(change);
    }

    /// Four steps; the grains move on in between. In lanes the last two go by what the one before has written.
    fn compute(
        &self,
        wall: &mut Wall,
        laws: &Laws,
        motion: &Motion,
        set: InstructionSet,
        in_lanes: bool,
    ) -> Outcome {
        let count = self.positions.len();
        let length = wall.histories(laws).length();
        let mut histories = vec![0.0; count * length];
        let (mut forces, mut torques) = (vec![[0.0; 3]; count], vec![[0.0; 3]; count]);
        let mut workspace = Workspace::new(set);
        let mut positions = self.positions.clone();
        let mut tallies = Tallies::default();
        let mut load = WallLoad::default();
        wall.records_contacts = false;
        wall.keeps_inelastic_loads = true;
        assert!(!in_lanes || wall.is_taken_in_lanes(laws, 1, set, Some(&tallies)));
        for number in 0..4 {
            let masses = (!self.masses.is_empty()).then_some(&self.masses[..]);
            let arrays = ParticleArrays {
                owned: count,
                positions: &positions,
                velocities: &self.velocities,
                rotation: match masses {
                    Some(masses) => Rotation::Momentum(&self.rotations, masses),
                    None => Rotation::Velocity(&self.rotations),
                },
                of_step: self.of_step,
                changes: &self.changes,
                contact_masses: &self.masses,
                types: &self.types,
                shape: |k| Some(self.shapes[k]),
                identifier: |k| k as i64,
            };
            if in_lanes && number > 1 {
                assert!(wall.find_near_again(motion, &positions).is_some());
            } else {
                wall.find_near(motion, count, |k| {
                    let largest = self.shapes[k].0.into_iter().fold(0.0, f64::max);
                    Some((Vector3::from_array(positions[k]), largest))
                });
            }
            let mut output = WallOutput {
                acts_on: &|_| true,
                histories: &mut histories,
                forces: &mut forces,
                torques: &mut torques,
            };
            let types = laws.types();
            load = if in_lanes {
                workspace
                    .prepare_chosen_records(&arrays, types, wall.near(), PreparedBy::Nobody)
                    .unwrap();
                let input = RecordsInput {
                    laws,
                    wall_type: 1,
                    near: workspace.chosen_records(PreparedBy::Nobody),
                    masses,
                    motion,
                    step: &STEP,
                    instruction_set: set,
                };
                compute_wall_in_lanes(wall, &input, &mut output, Some(&mut tallies))
            } else {
                workspace
                    .prepare_chosen(&arrays, types, wall.near())
                    .unwrap();
                let input = WallInput {
                    laws,
                    wall_type: 1,
                    near: workspace.particles(),
                    motion,
                    step: &STEP,
                    instruction_set: set,
                };
                compute_wall(wall, &input, &mut output, Some(&mut tallies))
            }
            .unwrap();
            for (x, v) in positions.iter_mut().zip(&self.velocities) {
                for axis in 0..3 {
                    x[axis] += v[axis] * STEP.time_step;
                }
            }
        }
        let mut groups = vec![
            ("force", forces.concat()),
            ("torque", torques.concat()),
            // The torque of a sphere's load vanishes but for rounding.
            (
                "load",
                [
                    load.force.to_array(),
                    load.torque.to_array(),
                    [load.power; 3],
                ]
                .concat(),
            ),
            ("springs", vec![load.stiffness]),
            ("damping", vec![load.damping]),
            (
                "energies",
                vec![
                    tallies.normal_elastic_energy,
                    tallies.tangential_elastic_energy,
                ],
            ),
            ("virial", tallies.virial.into()),
            ("touching", vec![tallies.touching, tallies.pairs as f64]),
            (
                "forces on parts",
                wall.part_forces()
                    .iter()
                    .flat_map(|f| f.to_array())
                    .collect(),
            ),
        ];
        let [viscous, tangential] = load.inelastic;
        let of_inelastic = [
            viscous.force,
            tangential.force,
            viscous.torque,
            tangential.torque,
        ];
        groups.push((
            "loads of the wall that are not elastic",
            of_inelastic.iter().flat_map(|v| v.to_array()).collect(),
        ));
        let mut loads = wall.touching_loads().to_vec();
        loads.sort_by_key(|l| l.particle);
        // Torques of the loads are angular accelerations where there are momenta, in lanes: the caller does the rest otherwise.
        groups.push((
            "loads",
            loads
                .iter()
                .flat_map(|l| [l.load.viscous_force, l.load.tangential_force].concat())
                .collect(),
        ));
        // Of a wall that moves along itself one contact at a time takes the velocity at the deepest point, lanes at the contact point.
        if self.masses.is_empty() && !motion.along_itself {
            groups.push(("powers of the wall", tallies.wall_powers.into()));
        }
        if self.masses.is_empty() {
            groups.push((
                "torques of loads",
                loads
                    .iter()
                    .flat_map(|l| [l.load.viscous_torque, l.load.tangential_torque].concat())
                    .collect(),
            ));
        }
        let mut several = 0;
        if length > 0 {
            let (layout, of_laws) = (wall.histories(laws), laws.layout());
            let head = layout.record - layout.history;
            let (mut heads, mut own) = (vec![], vec![]);
            for of_particle in histories.chunks_exact(length) {
                several += usize::from(of_particle[0] > 1.0);
                heads.push(of_particle[0]);
                for record in of_particle[1..].chunks_exact(layout.record) {
                    heads.extend(&record[..head]);
                    let at = head + of_laws.memory.unwrap();
                    own.extend(&record[at..at + 3]);
                }
            }
            groups.push(("places and normals", heads));
            groups.push(("memory", own));
        }
        Outcome {
            groups,
            contacts: load.contacts,
            several,
        }
    }

    /// Compares every instruction set with one contact at a time; how many contacts there were, and particles with several of them.
    fn compare(&self, what: &str, wall: &mut Wall, laws: &Laws, motion: &Motion) -> [usize; 2] {
        let one = self.compute(wall, laws, motion, InstructionSet::Scalar, false);
        let sets = InstructionSet::ALL.into_iter();
        for set in sets.filter(|s| *s != InstructionSet::Scalar && s.is_available()) {
            let all = self.compute(wall, laws, motion, set, true);
            let what = format!("{what}, {}", set.name());
            assert_eq!(all.contacts, one.contacts, "{what}");
            assert_same(&what, &all.groups, &one.groups);
        }
        [one.contacts, one.several]
    }
}

#[test]
fn every_instruction_set_gives_what_one_contact_at_a_time_gives() {
    let full = laws(&["nfd 1e3 0.3 0.5 0.5 tangential tfd 0.5"]);
    let elastic = laws(&["hertz 1e3 0.3 conservative yes"]);
    let two = laws(&[
        "hertz 1e3 0.3 damping restitution 0.7 tangential mindlin 0.5 displacement rescaled",
        "hertz 3e3 0.2 damping restitution 0.5 tangential mindlin 0.2 displacement rescaled",
    ]);
    // Terms that the lanes do not take together.
    let [of_first, of_second] = [
        "hertz 1e3 0.3 damping restitution 0.7 tangential mindlin 0.5",
        "nfd 3e3 0.2 0.5 0.5 tangential tfd 0.2",
    ]
    .map(|words| Some(parameters(words)));
    let kinds = Laws::new(2, &[of_first, of_second, None, of_second], true).unwrap();
    let scenes = [
        ("full law", full),
        ("elastic", elastic),
        ("two types", two),
        ("two kinds", kinds),
    ];
    let mut stream = Stream::new(3301);
    let [mut contacts, mut several] = [0; 2];
    for (surface, mut wall) in surfaces() {
        for (case, (name, laws)) in scenes.iter().enumerate() {
            for (motion, with_changes) in &motions_and_changes() {
                let with_changes = *with_changes;
                let types = laws.types();
                wall.records_contacts = true;
                let spheroids = case == 1;
                let mut grains = vec![];
                let has_corner = corner(surface, &mut stream).is_some();
                for least in 1..=1 + usize::from(has_corner) {
                    grains.extend(touching(&mut wall, motion, (types, least), || {
                        let mut body = random_body(&mut stream, types);
                        if spheroids {
                            body.semi_axes[2] = body.semi_axes[1];
                        }
                        if least > 1 {
                            let place = corner(surface, &mut stream).unwrap();
                            body.position = motion.point_to_world(place).to_array();
                        }
                        (body, prepare_body(&body, Some(types)).unwrap())
                    }));
                }
                let mut scene = Scene {
                    of_step: with_changes,
                    ..Scene::default()
                };
                for body in &grains {
                    let change = with_changes.then(|| {
                        let change = random_change(&mut stream);
                        let [v, w] = [change.velocity, change.omega].map(|v| v.to_array());
                        [v[0], v[1], v[2], w[0], w[1], w[2]]
                    });
                    scene.push(body, change);
                    if types > 1 {
                        scene.masses.push(stream.uniform(0.5, 2.0));
                    }
                }
                let what = format!("{surface}, {name}");
                let counts = scene.compare(&what, &mut wall, laws, motion);
                println!("{what}: {counts:?} contacts, particles with several");
                contacts += counts[0];
                several += counts[1];
            }
        }
    }
    assert!(contacts > 3000 && several > 100, "{contacts} {several}");
}

/// Grains of aspect ratios up to 30 at a corner of two planes.
#[test]
fn slender_grains_in_a_corner_are_pushed_by_both_planes() {
    const PARTICLES: usize = 300;
    let laws = laws(&[
        "nfd 1e3 0.3 0.5 0.5 tangential tfd 0.5",
        "nfd 3e3 0.2 0.1 0.1 tangential tfd 0.2",
    ]);
    let mut stream = Stream::new(3302);
    for spheroids in [true, false] {
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
        let mut scene = Scene::default();
        for k in 0..PARTICLES {
            let [a, b, c] = stream.semi_axes(30.0);
            // At one plane, the other, or both
            let away = [0; 2].map(|_| stream.uniform(0.1, 1.0));
            let place = [[away[0], 9.0], [9.0, away[1]], away][k % 3];
            let body = Body {
                semi_axes: if spheroids { [a, b, b] } else { [a, b, c] },
                quaternion: quaternion(stream.rotation()),
                position: [place[0], 0.3 * k as f64, place[1]],
                velocity: [0; 3].map(|_| stream.uniform(-1.0, 1.0)),
                angular_velocity: [0; 3].map(|_| stream.uniform(-1.0, 1.0)),
                particle_type: 1 + k as i32 % 2,
                mass: 1.0,
                identifier: 1,
            };
            scene.push(&body, None);
        }
        let counts = scene.compare("corner", &mut wall, &laws, &Motion::REST);
        assert!(counts[0] > PARTICLES / 3 && counts[1] > PARTICLES / 20);
    }
}

/// A grain that belongs outside a cylinder or a cone is pushed out from however deep within: the lanes find those that one contact at a
/// time finds.
#[test]
fn grains_deep_within_what_they_belong_outside_of() {
    let laws = laws(&["hertz 1e3 0.3"]);
    for name in ["cylinder", "cone"] {
        let mut wall = Wall::new();
        let parameters = ShapeParameters {
            point: Vector3::ZERO,
            axis: Vector3::new(0.0, 0.0, 1.0),
            radii: [6.0, 4.0],
            bounds: [-20.0, 20.0],
            ends: [End::None; 2],
            side: Side::Outside,
        };
        wall.add_shape(name, &parameters).unwrap();
        let mut stream = Stream::new(5);
        let mut scene = Scene::default();
        for k in 0..40 {
            let mut body = random_body(&mut stream, 1);
            body.position = [0.15 * f64::from(k), 0.1, 0.2];
            scene.push(&body, None);
        }
        let [contacts, _] = scene.compare(name, &mut wall, &laws, &Motion::REST);
        assert!(contacts >= 30, "{name}: {contacts}");
    }
}
