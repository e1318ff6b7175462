// SPDX-License-Identifier: MIT OR Apache-2.0
//! Are the particles that may touch a wall the same whether they are looked at in blocks or one by one? Blocks of particles that lie
//! next to each other, and of particles that do not; every kind of surface; no particle that touches is left out.

use crate::support::random::Stream;
use crate::support::scene::{body, laws, Vector};
use crate::walls_in_lanes::surfaces;
use ellgran::contact::{prepare_body, Step};
use ellgran::simd::InstructionSet;
use ellgran::vector::Vector3;
use ellgran::walls::{compute_wall, Motion, Wall, WallInput, WallOutput};

/// Of blocks of 64, some and a part of one.
const PARTICLES: usize = 400;
/// The surfaces are a dozen wide; behind them is near, too.
const REACH: f64 = 8.0;

/// Centres and semi-axes: clusters of `together` particles.
fn particles(stream: &mut Stream, together: usize) -> Vec<([f64; 3], [f64; 3])> {
    let mut corner = [0.0; 3];
    (0..PARTICLES)
        .map(|k| {
            if k % together == 0 {
                corner = [0; 3].map(|_| stream.uniform(-REACH, REACH));
            }
            let centre = corner.map(|c| c + stream.uniform(-0.5, 0.5));
            let semi_axes = [0; 3].map(|_| stream.uniform(0.2, 1.0));
            (centre, semi_axes)
        })
        .collect()
}

fn near(wall: &mut Wall, particles: &[([f64; 3], [f64; 3])]) -> Vec<usize> {
    let largest = |a: &[f64; 3]| a.iter().copied().fold(0.0, f64::max);
    let of = |k: usize| {
        let (centre, semi_axes) = &particles[k];
        Some((Vector3::from_array(*centre), largest(semi_axes)))
    };
    wall.find_near(&Motion::REST, particles.len(), of).to_vec()
}

#[test]
fn blocks_find_what_single_particles_find() {
    let mut stream = Stream::new(20131);
    for (name, mut wall) in surfaces() {
        let (mut all, mut found) = (0, 0);
        for together in [1, 40, 64, 200] {
            let particles = particles(&mut stream, together);
            let together = near(&mut wall, &particles);
            let alone: Vec<usize> = (0..PARTICLES)
                .filter(|k| !near(&mut wall, &particles[*k..=*k]).is_empty())
                .collect();
            assert_eq!(together, alone, "{name}");
            all += PARTICLES;
            found += together.len();
        }
        println!("{name}: {found} of {all} particles may touch");
        assert!(0 < found && found < all, "{name}: {found} of {all}");
    }
}

/// A particle whose numbers are not finite is near every wall, so that it is refused and not forgotten, wherever the others of its
/// block are.
#[test]
fn what_is_not_finite_is_looked_at() {
    for (name, mut wall) in surfaces() {
        let alone = |wall: &mut Wall, centre: Vector3, radius: f64| {
            let near = wall.find_near(&Motion::REST, 1, |_| Some((centre, radius)));
            !near.is_empty()
        };
        let places = [0.0, 1e3].map(|c| Vector3::new(c, c, c));
        let far = places
            .into_iter()
            .find(|place| !alone(&mut wall, *place, 0.1))
            .expect("a place far from the wall");
        for (centre, radius) in [
            (Vector3::new(f64::NAN, 0.0, 0.0), 0.1),
            (Vector3::new(0.0, f64::INFINITY, 0.0), f64::NAN),
            (far, f64::NAN),
        ] {
            assert!(
                alone(&mut wall, centre, radius),
                "{name}, {centre:?}, {radius}"
            );
            let near = wall.find_near(&Motion::REST, 100, |k| {
                Some(if k == 70 {
                    (centre, radius)
                } else {
                    (far, 0.1)
                })
            });
            assert_eq!(near, [70], "{name}, {centre:?}, {radius}");
        }
    }
}

/// The whole call leaves out no contact: forces of all particles together are those of each alone.
#[test]
fn no_contact_is_left_out() {
    let laws = laws(&["nfd 1e5 0.3 10 10 tangential tfd 0.3"]);
    let step = Step {
        time_step: 1e-3,
        advance_history: true,
    };
    let mut stream = Stream::new(77);
    for (name, mut wall) in surfaces() {
        let particles = particles(&mut stream, 30);
        let bodies: Vec<_> = particles
            .iter()
            .map(|(centre, semi_axes)| {
                let body = body(*semi_axes, Vector::from(*centre), stream.rotation());
                prepare_body(&body, Some(1)).unwrap()
            })
            .collect();
        let length = wall.histories(&laws).length();
        let mut compute = |range: core::ops::Range<usize>| {
            let near = near(&mut wall, &particles[range.clone()]);
            let chosen: Vec<_> = near.iter().map(|k| bodies[range.start + k]).collect();
            let mut forces = vec![[0.0; 3]; range.len()];
            let mut torques = forces.clone();
            compute_wall(
                &mut wall,
                &WallInput {
                    laws: &laws,
                    wall_type: 1,
                    near: &chosen,
                    motion: &Motion::REST,
                    step: &step,
                    instruction_set: InstructionSet::Scalar,
                },
                &mut WallOutput {
                    acts_on: &|_| true,
                    histories: &mut vec![0.0; range.len() * length],
                    forces: &mut forces,
                    torques: &mut torques,
                },
                None,
            )
            .unwrap();
            forces
        };
        let together = compute(0..PARTICLES);
        let alone: Vec<_> = (0..PARTICLES).flat_map(|k| compute(k..k + 1)).collect();
        assert_eq!(together, alone, "{name}");
        assert!(together.iter().any(|f| *f != [0.0; 3]), "{name}");
    }
}
