// SPDX-License-Identifier: MIT OR Apache-2.0
//! A wall of planes takes its contacts in lanes from the search to the sums. A wall that records its contacts does not, and must give the
//! same: forces, histories, loads, energies, and the work of both half steps, over several steps in which contacts begin, move from
//! plane to plane and end.

use crate::scene::{
    advance, fails, no_tallies, ok, random_bodies, shape, Arrays, Laws, WallHandle,
    WorkspaceHandle, NO_LOAD, REST, STEP,
};
use ellgran::c_api::contact::EllgranBody;
use ellgran::c_api::particles::EllgranParticles;
use ellgran::c_api::rigid_wall::*;
use ellgran::c_api::status::ELLGRAN_ERROR_HISTORY;
use ellgran::c_api::tallies::EllgranTallies;
use std::ptr::{null, null_mut};

const STEPS: usize = 40;
/// Share of the largest number of its kind by which a result may be off: rounding of deep contacts, summed up over the steps.
const TOLERANCE: f64 = 1e-11;

/// Planes, each a point and a normal.
fn wall(planes: &[([f64; 3], [f64; 3])], side: i32) -> WallHandle {
    let wall = WallHandle::new();
    for (point, axis) in planes {
        let plane = EllgranWallShape {
            point: *point,
            axis: *axis,
            side,
            ..shape(c"plane")
        };
        ok(unsafe { ellgran_wall_add_shape(wall.0, &plane) });
    }
    wall
}

/// What one way of taking the contacts needs from step to step.
struct Way {
    wall: WallHandle,
    workspace: WorkspaceHandle,
    histories: Vec<f64>,
    tallies: EllgranTallies,
    /// Whether the call is told that the particles are those of the call before.
    tells_unchanged: bool,
    steps: usize,
}

impl Way {
    fn new(wall: WallHandle, laws: &Laws, particles: usize, one_by_one: bool) -> Way {
        ok(unsafe { ellgran_wall_record_contacts(wall.0, one_by_one.into()) });
        ok(unsafe { ellgran_wall_keep_inelastic_loads(wall.0, 1) });
        Way {
            histories: wall.histories(laws, particles),
            wall,
            workspace: WorkspaceHandle::new(),
            tallies: no_tallies(),
            tells_unchanged: !one_by_one,
            steps: 0,
        }
    }

    /// All that a step gives, in groups of one kind.
    fn step(
        &mut self,
        laws: &Laws,
        scene: &mut Scene,
        motion: &EllgranWallMotion,
    ) -> Vec<(&'static str, Vec<f64>)> {
        let mut particles = scene.particles();
        // Shapes change after the first step.
        particles.unchanged = (self.tells_unchanged && self.steps > 1).into();
        self.steps += 1;
        let mut load = NO_LOAD;
        let t = &mut self.tallies;
        unsafe {
            ok(ellgran_compute_wall(
                laws.0,
                self.workspace.0,
                self.wall.0,
                &particles,
                null(),
                0,
                1,
                motion,
                self.histories.as_mut_ptr(),
                &STEP,
                &mut load,
                t,
            ));
        }
        let works = vec![t.viscous_dissipation, t.tangential_work];
        ok(unsafe { ellgran_wall_tally_following_half_step(self.wall.0, &particles, &STEP, t) });
        let mut part_forces = vec![];
        for part in 0..scene.planes {
            let mut force = [0.0; 3];
            ok(unsafe { ellgran_wall_part_force(self.wall.0, part, force.as_mut_ptr()) });
            part_forces.extend(force);
        }
        vec![
            ("forces", scene.arrays.forces.concat()),
            ("torques", scene.arrays.torques.concat()),
            ("histories", self.histories.clone()),
            ("force on the wall", load.force.into()),
            ("torque on the wall", load.torque.into()),
            ("forces on the parts", part_forces),
            ("springs", vec![load.stiffness]),
            ("dashpots", vec![load.damping]),
            ("power", vec![load.power]),
            (
                "counts",
                vec![
                    load.contact_count as f64,
                    t.touching_count,
                    t.pair_count as f64,
                ],
            ),
            ("virial", t.virial.into()),
            ("normal energy", vec![t.normal_elastic_energy]),
            ("tangential energy", vec![t.tangential_elastic_energy]),
            ("powers on the wall", t.wall_powers.into()),
            ("works before the half step", works),
            ("works", vec![t.viscous_dissipation, t.tangential_work]),
        ]
    }
}

struct Scene {
    arrays: Arrays,
    /// Where these are given instead of angular velocities.
    momenta: Option<Vec<[f64; 3]>>,
    planes: usize,
}

impl Scene {
    fn particles(&mut self) -> EllgranParticles {
        self.arrays.forces.fill([0.0; 3]);
        self.arrays.torques.fill([0.0; 3]);
        let mut particles = self.arrays.particles();
        if let Some(momenta) = &self.momenta {
            particles.angular_velocities = null();
            particles.angular_momenta = momenta.as_ptr().cast();
        }
        particles
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shapes {
    Spheres,
    Spheroids,
    /// Any, after a step in which all are spheroids.
    Triaxial,
}

fn bodies(shapes: Shapes, momenta: bool, of_step: bool) -> Vec<EllgranBody> {
    let mut bodies = random_bodies(4711);
    for (k, body) in bodies.iter_mut().enumerate() {
        let [a, b, c] = body.semi_axes;
        match shapes {
            Shapes::Spheres => body.semi_axes = [a; 3],
            Shapes::Spheroids => body.semi_axes = [[a, b, b], [a, b, a], [a, a, c]][k % 3],
            Shapes::Triaxial => {}
        }
        if momenta && !body.mass.is_finite() {
            body.mass = 3.0;
        }
        body.velocities_of_step = of_step.into();
        body.velocity_change = body.velocity.map(|v| 0.03 * v + 0.01);
        body.angular_velocity_change = body.angular_velocity.map(|w| 0.05 * w - 0.02);
    }
    bodies
}

#[test]
fn lanes_give_what_one_contact_after_the_other_gives() {
    let below = -0.95;
    let z = [0.0, 0.0, 1.0];
    let corner = [
        ([below, 0.0, 0.0], [1.0, 0.0, 0.0]),
        ([0.0, below, 0.0], [0.0, 1.0, 0.0]),
        ([0.0, 0.0, below], z),
    ];
    let tilted = [([0.0, 0.0, -0.4], [0.0, -0.28, 0.96])];
    let high = [([0.0, 0.0, -0.75], z)];
    let walls: [(&str, &[_], i32); 5] = [
        ("floor", &corner[2..], ELLGRAN_SIDE_INSIDE),
        (
            "floor that nearly all of a layer touch",
            &high,
            ELLGRAN_SIDE_INSIDE,
        ),
        ("tilted floor", &tilted, ELLGRAN_SIDE_INSIDE),
        ("sheet", &[([0.0, 0.0, 1.05], z)], ELLGRAN_SIDE_OF_CENTRE),
        ("corner", &corner, ELLGRAN_SIDE_INSIDE),
    ];
    let laws = [
        vec!["nfd 200 0.3 3 3 tangential tfd 0.3 displacement rescaled"; 2],
        vec!["nfd 200 0.3 3 3 tangential tfd 0.1 conservative yes"; 2],
        vec!["hertz 200 0.3 damping restitution 0.7 tangential mindlin 0.3"; 2],
        vec![
            "nfd 200 0.3 3 3 tangential tfd 0.3",
            "nfd 500 0.2 1 1 tangential tfd 0.6",
        ],
        vec!["nfd 200 0.3 3 3"; 2],
        // Not in lanes: both ways are the same one.
        vec!["nfd 200 0.3 3 3 tangential tfd 0.3 rolling sds 30 1 0.2"; 2],
    ];
    let motions = [
        REST,
        EllgranWallMotion {
            velocity: [0.2, -0.1, 0.3],
            velocity_change: [-0.05, 0.04, 0.03],
            ..REST
        },
    ];
    let mut variant = 0;
    let (mut contacts, mut multiple) = (0.0, 0);
    for (name, planes, side) in walls {
        for words in &laws {
            for motion in motions {
                for shapes in [Shapes::Spheres, Shapes::Spheroids, Shapes::Triaxial] {
                    // Every combination of these two comes with each of the others in turn.
                    variant += 1;
                    let (momenta, of_step) = (variant % 2 == 0, variant / 2 % 2 == 0);
                    let what = format!(
                        "{name}, {}, {shapes:?}, momenta {momenta}, of step {of_step}, moving {}",
                        words[0],
                        motion.velocity != [0.0; 3]
                    );
                    let law = Laws::new(words);
                    let mut bodies = bodies(shapes, momenta, of_step);
                    let count = bodies.len();
                    let mut ways = [false, true]
                        .map(|one_by_one| Way::new(wall(planes, side), &law, count, one_by_one));
                    let mut motion = motion;
                    for step in 0..STEPS {
                        let mut now = bodies.clone();
                        if shapes == Shapes::Triaxial && step == 0 {
                            now.iter_mut().for_each(|b| b.semi_axes[2] = b.semi_axes[1]);
                        }
                        let mut scene = Scene {
                            arrays: Arrays::new(&now, count),
                            momenta: momenta.then(|| {
                                let of =
                                    |b: &EllgranBody| b.angular_velocity.map(|w| 0.4 * w * b.mass);
                                now.iter().map(of).collect()
                            }),
                            planes: planes.len(),
                        };
                        let [a, b] = ways
                            .each_mut()
                            .map(|way| way.step(&law, &mut scene, &motion));
                        let force = b[0].1.iter().fold(0.0f64, |m, x| m.max(x.abs()));
                        for ((group, a), (_, b)) in a.iter().zip(&b) {
                            // What nothing makes is there by rounding: with lengths and times of 1, of the size of the forces.
                            let largest = b.iter().fold(force, |m, x| m.max(x.abs()));
                            for (a, b) in a.iter().zip(b) {
                                assert!(
                                    (a - b).abs() <= TOLERANCE * largest,
                                    "{what}, step {step}: {group} {a:e} and {b:e}"
                                );
                            }
                        }
                        contacts += b[9].1[0];
                        if let Some(length) = ways[0].histories.len().checked_div(count) {
                            let rows = ways[0].histories.chunks_exact(length.max(1));
                            multiple += rows.filter(|row| row[0] > 1.0).count();
                        }
                        advance(&mut bodies, STEP.time_step);
                        for (x, v) in motion.displacement.iter_mut().zip(motion.velocity) {
                            *x += STEP.time_step * v;
                        }
                    }
                }
            }
        }
    }
    println!("{contacts} contacts, {multiple} times a particle at several planes");
    assert!(contacts > 1e4 && multiple > 1000);
}

/// A history that no call has written is an error before anything is written, for a particle at one plane and at several.
#[test]
fn wrong_histories_are_found_before_anything_is_written() {
    let laws = Laws::new(&["nfd 200 0.3 3 3 tangential tfd 0.3"]);
    let x = ([-0.9, 0.0, 0.0], [1.0, 0.0, 0.0]);
    let z = ([0.0, 0.0, -0.9], [0.0, 0.0, 1.0]);
    for planes in [vec![z], vec![x, z]] {
        for (place, value) in [(0, 0.5), (0, f64::NAN), (1, 3.0), (12, 1e150)] {
            let wall = wall(&planes, ELLGRAN_SIDE_INSIDE);
            let workspace = WorkspaceHandle::new();
            let mut arrays = Arrays::new(
                &[crate::scene::sphere_at(5.0), crate::scene::sphere_at(0.0)],
                2,
            );
            let mut histories = wall.histories(&laws, 2);
            let length = histories.len() / 2;
            let mut compute = |histories: &mut Vec<f64>| {
                arrays.forces.fill([0.0; 3]);
                let particles = arrays.particles();
                let status = unsafe {
                    ellgran_compute_wall(
                        laws.0,
                        workspace.0,
                        wall.0,
                        &particles,
                        null(),
                        0,
                        1,
                        null(),
                        histories.as_mut_ptr(),
                        &STEP,
                        null_mut(),
                        null_mut(),
                    )
                };
                (status, arrays.forces.clone())
            };
            ok(compute(&mut histories).0);
            assert_eq!(histories[length], planes.len() as f64);
            histories[length + place] = value;
            let before = histories.clone();
            let (status, forces) = compute(&mut histories);
            fails(
                status,
                ELLGRAN_ERROR_HISTORY,
                &["particle 7", "history", "wall"],
            );
            assert_eq!(forces, [[0.0; 3]; 2]);
            let same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits();
            assert!(histories.iter().zip(&before).all(same));
        }
    }
}
