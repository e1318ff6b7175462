// SPDX-License-Identifier: MIT OR Apache-2.0
//! Are the particles that may touch a wall the same whether they are looked at in blocks or one by one? Blocks of particles that lie
//! next to each other, and of particles that do not; every kind of surface; no particle that touches is left out.

use crate::support::random::Stream;
use crate::support::scene::{body, laws, Vector};
use crate::walls_in_lanes::{motions, surfaces};
use ellgran::contact::{prepare_body, Laws, Particle, Step};
use ellgran::simd::InstructionSet;
use ellgran::vector::Vector3;
use ellgran::walls::{compute_wall, Mesh, Motion, Wall, WallInput, WallOutput};

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

/// A step of particles, and of the bodies that they are, at a wall at rest: those that may touch, the forces on all, and how many contacts
/// there are.
fn step_at(
    wall: &mut Wall,
    laws: &Laws,
    particles: &[([f64; 3], [f64; 3])],
    bodies: &[Particle],
) -> (Vec<usize>, Vec<[f64; 3]>, usize) {
    let near = near(wall, particles);
    let chosen: Vec<_> = near.iter().map(|k| bodies[*k]).collect();
    let mut forces = vec![[0.0; 3]; particles.len()];
    let length = wall.histories(laws).length();
    let load = compute_wall(
        wall,
        &WallInput {
            laws,
            wall_type: 1,
            near: &chosen,
            motion: &Motion::REST,
            step: &Step {
                time_step: 1e-3,
                advance_history: true,
            },
            instruction_set: InstructionSet::Scalar,
        },
        &mut WallOutput {
            acts_on: &|_| true,
            histories: &mut vec![0.0; particles.len() * length],
            forces: &mut forces,
            torques: &mut vec![[0.0; 3]; particles.len()],
        },
        None,
    )
    .unwrap();
    (near, forces, load.contacts)
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

/// Where particles are the same ones that have moved on, their centres alone are looked at: the same are found, also those whose centres are
/// not finite.
#[test]
fn particles_that_have_moved_are_found_again() {
    let mut stream = Stream::new(20132);
    for ((name, mut wall), (_, mut other)) in surfaces().into_iter().zip(surfaces()) {
        for mut motion in motions() {
            let mut particles = particles(&mut stream, 64);
            let largest = |a: &[f64; 3]| a.iter().copied().fold(0.0, f64::max);
            for round in 0..6 {
                let of = |k: usize| {
                    let (centre, semi_axes) = &particles[k];
                    // One block of which none takes part.
                    let place = Vector3::from_array(*centre);
                    (k / 64 != 2).then(|| (place, largest(semi_axes)))
                };
                let positions: Vec<[f64; 3]> = particles.iter().map(|p| p.0).collect();
                let expected = other.find_near(&motion, PARTICLES, of);
                if round == 0 {
                    let first = wall.find_near(&motion, PARTICLES, of);
                    assert_eq!(first, expected, "{name}");
                }
                let again = wall.find_near_again(&motion, &positions);
                assert_eq!(again, Some(expected), "{name}, round {round}");
                assert_eq!(wall.find_near_again(&motion, &positions[1..]), None);
                for (k, (centre, _)) in particles.iter_mut().enumerate() {
                    *centre = centre.map(|x| x + stream.uniform(-0.3, 0.3));
                    if round == 4 && k == 100 {
                        *centre = [0.0, f64::NAN, 0.0];
                    }
                }
                motion.displacement = motion.displacement + motion.velocity * 0.5;
            }
        }
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

/// A rough surface of many triangles of several sizes.
fn hills() -> Wall {
    let cells = 24;
    let at = |i: usize, j: usize| {
        let place = |k: usize| REACH * (2.0 * (k as f64 / cells as f64).powf(1.5) - 1.0);
        let (x, y) = (place(i), place(j));
        Vector3::new(x, y, 0.3 * (2.0 * x).sin() * (1.5 * y).cos())
    };
    let cell = |k: usize| {
        let (i, j) = (k / cells, k % cells);
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    let triangles: Vec<_> = (0..cells * cells).flat_map(cell).collect();
    let mut wall = Wall::new();
    wall.add_mesh(Mesh::new(triangles).unwrap());
    wall
}

/// A mesh keeps which of its triangles are near a particle. Particles that move a little in each step, some of them far at a time, that
/// take each other's indices, and grow, touch what they touch where nothing is kept, to the last digit.
#[test]
fn what_a_mesh_keeps_changes_nothing() {
    let laws = laws(&["hertz 1e5 0.3"]);
    let mut stream = Stream::new(4711);
    let mut particles: Vec<([f64; 3], [f64; 3])> = (0..60)
        .map(|_| {
            let [x, y] = [0; 2].map(|_| stream.uniform(-REACH, REACH));
            let semi_axes = [0; 3].map(|_| stream.uniform(0.2, 1.0));
            ([x, y, stream.uniform(-1.5, 1.5)], semi_axes)
        })
        .collect();
    let turn = stream.rotation();
    let forces = |wall: &mut Wall, particles: &[([f64; 3], [f64; 3])]| {
        let body_of = |(centre, semi_axes): &([f64; 3], [f64; 3])| {
            let body = body(*semi_axes, Vector::from(*centre), turn);
            prepare_body(&body, Some(1)).unwrap()
        };
        let bodies: Vec<_> = particles.iter().map(body_of).collect();
        step_at(wall, &laws, particles, &bodies)
    };
    let mut kept = hills();
    let mut contacts = 0;
    for round in 0..400 {
        for (centre, semi_axes) in &mut particles {
            for x in centre.iter_mut() {
                *x += stream.uniform(-0.05, 0.05);
            }
            if stream.uniform(0.0, 1.0) < 0.01 {
                centre[0] = stream.uniform(-REACH, REACH);
            }
            if stream.uniform(0.0, 1.0) < 0.01 {
                *semi_axes = [0; 3].map(|_| stream.uniform(0.2, 1.5));
            }
        }
        if round % 7 == 0 {
            particles.reverse();
        }
        let with = forces(&mut kept, &particles);
        if round % 5 == 0 {
            let again = forces(&mut kept, &particles);
            assert_eq!(again, with, "repeated in round {round}");
            // What is near may be more: a place that is kept for long is larger than a new one.
            let (_, acting, count) = forces(&mut hills(), &particles);
            assert_eq!((with.1, with.2), (acting, count), "round {round}");
            contacts += count;
        }
    }
    println!("{contacts} contacts");
    assert!(contacts > 1000);
}

/// The whole call leaves out no contact: forces of all particles together are those of each alone.
#[test]
fn no_contact_is_left_out() {
    let laws = laws(&["nfd 1e5 0.3 10 10 tangential tfd 0.3"]);
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
        let mut compute = |range: core::ops::Range<usize>| {
            step_at(&mut wall, &laws, &particles[range.clone()], &bodies[range]).1
        };
        let together = compute(0..PARTICLES);
        let alone: Vec<_> = (0..PARTICLES).flat_map(|k| compute(k..k + 1)).collect();
        assert_eq!(together, alone, "{name}");
        assert!(together.iter().any(|f| *f != [0.0; 3]), "{name}");
    }
}
