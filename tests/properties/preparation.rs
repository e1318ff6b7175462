// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is a particle that was prepared in lanes the one that is prepared alone? On every instruction set, from angular velocities and from
//! angular momenta, with and without velocities of the step, and with quaternions and semi-axes that the lanes hand back.

use crate::support::list::instruction_sets;
use crate::support::random::Stream;
use ellgran::contact::Particle;
use ellgran::list::{ParticleArrays, Rotation, Workspace};
use ellgran::simd::InstructionSet;
use ellgran::vector::Vector3;

const PARTICLES: usize = 45;
/// Rounding of the axes, and of an angular velocity from a momentum.
const TOLERANCE: f64 = 4e-15;

struct Scene {
    positions: Vec<[f64; 3]>,
    velocities: Vec<[f64; 3]>,
    spins: Vec<[f64; 3]>,
    masses: Vec<f64>,
    contact_masses: Vec<f64>,
    types: Vec<i32>,
    shapes: Vec<([f64; 3], [f64; 4])>,
    changes: Vec<[f64; 6]>,
}

impl Scene {
    fn new(stream: &mut Stream) -> Self {
        let mut vectors = || -> Vec<[f64; 3]> {
            (0..PARTICLES)
                .map(|_| [0; 3].map(|_| stream.uniform(-2.0, 2.0)))
                .collect()
        };
        let (positions, velocities, spins) = (vectors(), vectors(), vectors());
        let mut numbers = |low: f64, high: f64| -> Vec<f64> {
            (0..PARTICLES).map(|_| stream.uniform(low, high)).collect()
        };
        let (masses, mut contact_masses) = (numbers(0.1, 3.0), numbers(0.1, 3.0));
        contact_masses[7] = f64::INFINITY;
        let mut shapes: Vec<_> = (0..PARTICLES)
            .map(|_| {
                let a = [0; 3].map(|_| stream.uniform(0.2, 1.0));
                (a, [0; 4].map(|_| stream.uniform(-1.0, 1.0)))
            })
            .collect();
        // A sphere, a spheroid, and a quaternion whose square is no number.
        shapes[3].0 = [0.5; 3];
        shapes[4].0 = [0.5, 0.9, 0.9];
        shapes[11].1 = shapes[11].1.map(|q| q * 1e-170);
        Scene {
            positions,
            velocities,
            spins,
            masses,
            contact_masses,
            types: (0..PARTICLES).map(|k| 1 + k as i32 % 3).collect(),
            shapes,
            changes: (0..PARTICLES)
                .map(|_| [0; 6].map(|_| stream.uniform(-0.1, 0.1)))
                .collect(),
        }
    }

    /// The particles, prepared on an instruction set.
    fn prepared(&self, set: InstructionSet, case: Case, chosen: &[usize]) -> Vec<Particle> {
        let rotation = if case.momenta {
            Rotation::Momentum(&self.spins, &self.masses)
        } else {
            Rotation::Velocity(&self.spins)
        };
        let arrays = ParticleArrays {
            owned: PARTICLES,
            positions: &self.positions,
            velocities: &self.velocities,
            rotation,
            of_step: case.of_step,
            changes: if case.changes { &self.changes } else { &[] },
            contact_masses: if case.masses {
                &self.contact_masses
            } else {
                &[]
            },
            types: &self.types,
            shape: |k| Some(self.shapes[k]),
            identifier: |k| k as i64,
        };
        let mut workspace = Workspace::new(set);
        workspace.prepare_chosen(&arrays, 3, chosen).unwrap();
        workspace.particles().to_vec()
    }
}

#[derive(Clone, Copy, Debug)]
struct Case {
    momenta: bool,
    changes: bool,
    of_step: bool,
    masses: bool,
}

fn vectors(p: &Particle) -> Vec<(&'static str, Vector3)> {
    let mut all = vec![
        ("position", p.position),
        ("first axis", p.body.axes[0]),
        ("second axis", p.body.axes[1]),
        ("third axis", p.body.axes[2]),
        ("semi-axes", p.body.semi_axes),
        ("inverse semi-axes", p.body.inverse_semi_axes),
        ("velocity", p.velocity),
        ("angular velocity", p.omega),
    ];
    if let Some(change) = p.change {
        all.push(("change of velocity", change.velocity));
        all.push(("change of angular velocity", change.omega));
    }
    all
}

#[test]
fn lanes_prepare_what_is_prepared_alone() {
    let mut stream = Stream::new(314);
    let scene = Scene::new(&mut stream);
    let chosen: Vec<usize> = (0..PARTICLES).filter(|k| k % 5 != 2).collect();
    for bits in 0..16 {
        let case = Case {
            momenta: bits & 1 != 0,
            changes: bits & 2 != 0,
            of_step: bits & 4 != 0,
            masses: bits & 8 != 0,
        };
        // Velocities of the step are given by their changes.
        if case.changes != case.of_step {
            continue;
        }
        let expected = scene.prepared(InstructionSet::Scalar, case, &chosen);
        assert_eq!(expected.len(), chosen.len());
        for set in instruction_sets() {
            let found = scene.prepared(set, case, &chosen);
            assert_eq!(found.len(), chosen.len());
            for ((k, e), f) in chosen.iter().zip(&expected).zip(&found) {
                let what = |name: &str| format!("{name} of {k}, {case:?}, {set:?}");
                assert_eq!(e.radius, f.radius, "{}", what("radius"));
                assert_eq!(e.inverse_mass, f.inverse_mass, "{}", what("mass"));
                assert_eq!(e.particle_type, f.particle_type, "{}", what("type"));
                assert_eq!(e.sphere, f.sphere, "{}", what("sphere"));
                let (e, f) = (vectors(e), vectors(f));
                assert_eq!(e.len(), f.len(), "{}", what("change"));
                for ((name, e), (_, f)) in e.into_iter().zip(f) {
                    let off = (e - f).norm() / e.norm();
                    assert!(off <= TOLERANCE, "{}: off by {off:e}", what(name));
                }
            }
        }
    }
}

/// The message is that of one particle alone, wherever among the lanes it is.
#[test]
fn what_cannot_be_prepared_is_named() {
    let mut stream = Stream::new(315);
    let chosen: Vec<usize> = (0..PARTICLES).rev().collect();
    for wrong in [0, 1, 6, PARTICLES - 1] {
        let mut scene = Scene::new(&mut stream);
        scene.contact_masses[wrong] = -1.0;
        let arrays = ParticleArrays {
            owned: PARTICLES,
            positions: &scene.positions,
            velocities: &scene.velocities,
            rotation: Rotation::Velocity(&scene.spins),
            of_step: false,
            changes: &[],
            contact_masses: &scene.contact_masses,
            types: &scene.types,
            shape: |k| Some(scene.shapes[k]),
            identifier: |k| 1000 + k as i64,
        };
        for set in instruction_sets() {
            let mut workspace = Workspace::new(set);
            let error = workspace.prepare_chosen(&arrays, 3, &chosen).unwrap_err();
            assert_eq!(error.identifier, 1000 + wrong as i64);
            assert!(error.what.contains("contact mass = -1"), "{}", error.what);
            assert!(workspace.particles().is_empty());
        }
    }
}
