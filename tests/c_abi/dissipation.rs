// SPDX-License-Identifier: MIT OR Apache-2.0
//! Kinetic, elastic and dissipated energy of bodies that velocity Verlet moves add up, to second order in the time step.

use std::ptr::{null, null_mut};

use ellgran::c_api::contact::EllgranBody;
use ellgran::c_api::neighbour_list::ellgran_compute_pairs;
use ellgran::c_api::particles::{EllgranParticles, EllgranStep};
use ellgran::c_api::rigid_wall::*;
use ellgran::c_api::status::*;
use ellgran::c_api::tallies::{ellgran_tally_following_half_step, EllgranTallies};

use crate::scene::*;

/// Energies at the end, and the work of the wall.
struct Account {
    before: f64,
    kinetic: f64,
    elastic: f64,
    viscous: f64,
    friction: f64,
    wall: f64,
}

impl Account {
    /// Share of what was dissipated by which the sum of all energies is off.
    fn error(&self) -> f64 {
        let now = self.kinetic + self.elastic + self.viscous + self.friction;
        (now - self.before - self.wall).abs() / (self.viscous + self.friction)
    }
}

/// Unit spheres of mass 1.
fn kinetic(bodies: &[EllgranBody]) -> f64 {
    let square = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>();
    bodies
        .iter()
        .map(|b| 0.5 * square(b.velocity) + 0.2 * square(b.angular_velocity))
        .sum()
}

fn kick(bodies: &mut [EllgranBody], arrays: &Arrays, time: f64) {
    for (k, b) in bodies.iter_mut().enumerate() {
        for c in 0..3 {
            b.velocity[c] += time * arrays.forces[k][c];
            b.angular_velocity[c] += time * arrays.torques[k][c] / 0.4;
        }
    }
}

/// What acts on the spheres: each other, or a plane that oscillates.
enum Partner {
    Sphere,
    Plane,
}

const PLANE_SPEED: [f64; 3] = [0.4, 0.0, 0.6];
const PLANE_RATE: f64 = 3.0;

const TIME: f64 = 1.2;
/// Steps of the coarsest run.
const COARSE: usize = 200;
/// The error of a collision depends on where within a step it begins: so many places stand for all.
const PHASES: usize = 16;

/// How the work of forces that are not elastic is reckoned: with the velocities of a call for the whole step, or in two halves, with
/// the loads in an array of all particles or kept by the wall.
#[derive(Clone, Copy, PartialEq)]
enum Work {
    WholeSteps,
    Halves,
    HalvesKeptByWall,
}

/// Root of the mean square of the errors over the phases, and the account of the last.
fn mean_error(law: &str, partner: &Partner, steps: usize, work: Work) -> (f64, Account) {
    let all: Vec<Account> = (0..PHASES)
        .map(|k| run(law, partner, steps, work, k as f64 / PHASES as f64))
        .collect();
    let square = all.iter().map(|a| a.error().powi(2)).sum::<f64>() / PHASES as f64;
    (square.sqrt(), all.into_iter().next_back().unwrap())
}

/// Moves the spheres over a time; `phase`: share of a coarse step by which they begin before or after the others.
fn run(law: &str, partner: &Partner, steps: usize, work: Work, phase: f64) -> Account {
    let laws = Laws::new(&[law]);
    let workspace = WorkspaceHandle::new();
    let mut bodies = match partner {
        Partner::Sphere => vec![sphere_at(-1.0), sphere_at(1.0)],
        Partner::Plane => vec![sphere_at(0.0)],
    };
    bodies[0].velocity = [0.5, 0.4, -0.1];
    bodies[0].angular_velocity = [0.1, 0.2, -0.5];
    if let Partner::Plane = partner {
        bodies[0].position[2] = 1.0;
        bodies[0].velocity = [0.3, 0.2, -0.5];
    }
    for c in 0..3 {
        bodies[0].position[c] -= phase * TIME / COARSE as f64 * bodies[0].velocity[c];
    }
    let time_step = TIME / steps as f64;
    let count = bodies.len();
    let mut list = List::near(&bodies, count, laws.length());
    let plane = WallHandle::plane([0.0; 3], [0.0, 0.0, 1.0]);
    let mut memory = plane.histories(&laws, count);
    let mut loads = vec![[0.0; 12]; count];
    let mut tallies = no_tallies();
    if work == Work::Halves {
        tallies.inelastic_loads = loads.as_mut_ptr().cast();
    }
    let keeps = (work == Work::HalvesKeptByWall).into();
    // SAFETY: the wall is valid.
    ok(unsafe { ellgran_wall_keep_inelastic_loads(plane.0, keeps) });
    let before = kinetic(&bodies);
    let mut wall = 0.0;
    for n in 0..=steps {
        let step = EllgranStep {
            time_step,
            advance_history: (n > 0) as i32,
            ..STEP
        };
        let mut arrays = Arrays::new(&bodies, count);
        arrays.forces.fill([0.0; 3]);
        arrays.torques.fill([0.0; 3]);
        let particles = arrays.particles();
        // The plane starts at z = 0 and moves by its speed over the rate, as a sine.
        let phase = PLANE_RATE * n as f64 * time_step;
        let velocity = PLANE_SPEED.map(|v| v * phase.cos());
        let motion = EllgranWallMotion {
            displacement: PLANE_SPEED.map(|v| v / PLANE_RATE * phase.sin()),
            velocity,
            ..REST
        };
        let mut load = NO_LOAD;
        // SAFETY: all arrays live to the end of the step.
        ok(unsafe {
            match partner {
                Partner::Sphere => ellgran_compute_pairs(
                    laws.0,
                    workspace.0,
                    &particles,
                    &list.view(true),
                    &step,
                    &mut tallies,
                ),
                Partner::Plane => ellgran_compute_wall(
                    laws.0,
                    workspace.0,
                    plane.0,
                    &particles,
                    null(),
                    0,
                    1,
                    &motion,
                    memory.as_mut_ptr(),
                    &step,
                    &mut load,
                    &mut tallies,
                ),
            }
        });
        let share = if n == 0 || n == steps { 0.5 } else { 1.0 };
        wall -= share * time_step * load.power;
        if n > 0 {
            kick(&mut bodies, &arrays, 0.5 * time_step);
        }
        if n == steps {
            break;
        }
        kick(&mut bodies, &arrays, 0.5 * time_step);
        if work != Work::WholeSteps {
            let mut now = Arrays::new(&bodies, count);
            let step = EllgranStep {
                advance_history: 1,
                ..step
            };
            // SAFETY: as above.
            ok(unsafe {
                if work == Work::Halves {
                    ellgran_tally_following_half_step(&now.particles(), &step, &mut tallies)
                } else {
                    let now = now.particles();
                    ellgran_wall_tally_following_half_step(plane.0, &now, &step, &mut tallies)
                }
            });
        }
        advance(&mut bodies, time_step);
    }
    Account {
        before,
        kinetic: kinetic(&bodies),
        elastic: tallies.normal_elastic_energy + tallies.tangential_elastic_energy,
        viscous: tallies.viscous_dissipation,
        friction: tallies.frictional_dissipation,
        wall,
    }
}

#[test]
fn energies_add_up_to_second_order() {
    for (law, viscous) in [
        ("hertz 200 0.3 damping relaxation 0.02", true),
        ("hertz 200 0.3 tangential mindlin 0.3", false),
        (
            "nfd 200 0.3 3 3 tangential tfd 0.3 displacement rescaled",
            true,
        ),
        (
            "nfd 200 0.3 3 3 tangential tfd 0.3 displacement total",
            true,
        ),
        (
            "hertz 200 0.3 damping restitution 0.7 tangential mindlin 0.3 displacement incremental",
            true,
        ),
        ("lsd 100 1 tangential linear 60 0.5 0.3", true),
        ("nfd 200 0.3 3 9 viscosity memory tangential tfd 0.3", true),
    ] {
        for (name, partner) in [("sphere", Partner::Sphere), ("plane", Partner::Plane)] {
            let all = [1, 4, 16].map(|k| mean_error(law, &partner, k * COARSE, Work::Halves));
            let errors = [0, 1, 2].map(|k| all[k].0);
            let last = &all[2].1;
            let one_velocity = mean_error(law, &partner, COARSE, Work::WholeSteps).0;
            println!(
                "{law}, {name}: off by {:.1e} {:.1e} {:.1e} of what is dissipated ({:.3} and {:.3} of {:.3}); {one_velocity:.1e} with one velocity a step",
                errors[0], errors[1], errors[2], last.viscous, last.friction, last.before
            );
            assert_eq!(last.viscous > 1e-3 * last.before, viscous, "{law}, {name}");
            assert!(
                errors[1] < 0.2 * errors[0] && errors[2] < 0.03 * errors[0],
                "{law}, {name}: not of second order"
            );
            assert!(errors[0] < 1e-2, "{law}, {name}");
            assert!(
                one_velocity > 3.0 * errors[0],
                "{law}, {name}: no better than first order"
            );
            if law.contains("tangential") {
                assert!(last.friction > 1e-3 * last.before, "{law}, {name}");
            }
        }
    }
}

/// What a wall keeps of the particles that touch it gives the work that an array of all particles gives, to rounding: with
/// angular velocities here, with angular momenta in the tests of LAMMPS.
#[test]
fn a_wall_keeps_the_loads_of_those_that_touch() {
    for law in [
        "nfd 200 0.3 3 3 tangential tfd 0.3 displacement rescaled",
        "hertz 200 0.3 damping restitution 0.7 tangential mindlin 0.3 rolling sds 5 1 0.2",
        "nfd 200 0.3 3 9 viscosity memory tangential tfd 0.3",
    ] {
        for phase in [0.0, 0.4] {
            let [array, kept, whole] = [Work::Halves, Work::HalvesKeptByWall, Work::WholeSteps]
                .map(|work| run(law, &Partner::Plane, COARSE, work, phase));
            assert!(array.viscous > 1e-3 * array.before);
            for (a, b) in [
                (array.viscous, kept.viscous),
                (array.friction, kept.friction),
            ] {
                assert!((a - b).abs() <= 1e-13 * array.before, "{law}: {a} and {b}");
            }
            assert_ne!(array.viscous, whole.viscous);
        }
    }
}

/// What a wall keeps of a particle that is no longer there is refused; a call of the wall without tallies keeps nothing.
#[test]
fn a_load_of_a_particle_that_is_gone() {
    let laws = Laws::new(&["nfd 200 0.3 3 3 tangential tfd 0.3"]);
    let workspace = WorkspaceHandle::new();
    let plane = WallHandle::plane([0.0; 3], [0.0, 0.0, 1.0]);
    let mut body = sphere_at(0.0);
    body.position[2] = 0.99;
    let mut arrays = Arrays::new(&[body], 1);
    let particles = arrays.particles();
    let mut memory = plane.histories(&laws, 1);
    let mut tallies = no_tallies();
    let nobody = EllgranParticles {
        owned_count: 0,
        ..particles
    };
    // SAFETY: the arrays live to the end of the test.
    unsafe {
        ok(ellgran_wall_keep_inelastic_loads(plane.0, 1));
        let mut compute = |tallies: *mut EllgranTallies| {
            ok(ellgran_compute_wall(
                laws.0,
                workspace.0,
                plane.0,
                &particles,
                null(),
                0,
                1,
                null(),
                memory.as_mut_ptr(),
                &STEP,
                null_mut(),
                tallies,
            ));
        };
        compute(&mut tallies);
        let tally = |p: &EllgranParticles, tallies: *mut EllgranTallies| {
            ellgran_wall_tally_following_half_step(plane.0, p, &STEP, tallies)
        };
        fails(
            tally(&nobody, &mut tallies),
            ELLGRAN_ERROR_ARGUMENT,
            &["owned_count = 0: the wall keeps a load of the particle with index 0"],
        );
        ok(tally(&particles, &mut tallies));
        compute(null_mut());
        ok(tally(&nobody, &mut tallies));
        fails(
            tally(&particles, null_mut()),
            ELLGRAN_ERROR_NULL_POINTER,
            &["tallies"],
        );
        fails(
            ellgran_wall_tally_following_half_step(null(), &particles, &STEP, &mut tallies),
            ELLGRAN_ERROR_NULL_POINTER,
            &["wall"],
        );
        fails(
            ellgran_wall_keep_inelastic_loads(null_mut(), 1),
            ELLGRAN_ERROR_NULL_POINTER,
            &["wall"],
        );
    }
}

/// Without a step that passes there is no work; what is missing is named.
#[test]
fn half_steps_that_add_nothing() {
    let mut arrays = Arrays::new(&[sphere_at(0.0)], 1);
    let particles = arrays.particles();
    let mut loads = [[1.0; 12]];
    let mut tallies = no_tallies();
    let add = |p: *const EllgranParticles, s: *const EllgranStep, t: *mut EllgranTallies| {
        // SAFETY: pointers are NULL or valid.
        unsafe { ellgran_tally_following_half_step(p, s, t) }
    };
    let null_pointer = |status: i32, name: &str| {
        fails(
            status,
            ELLGRAN_ERROR_NULL_POINTER,
            &[&format!("{name} must not be NULL")],
        );
    };
    null_pointer(add(&particles, &STEP, &mut tallies), "inelastic_loads");
    tallies.inelastic_loads = loads.as_mut_ptr().cast();
    null_pointer(add(null(), &STEP, &mut tallies), "particles");
    null_pointer(add(&particles, null(), &mut tallies), "step");
    null_pointer(add(&particles, &STEP, null_mut()), "tallies");
    let without = EllgranParticles {
        velocities: null(),
        ..particles
    };
    null_pointer(add(&without, &STEP, &mut tallies), "velocities");
    let many = EllgranParticles {
        owned_count: 2,
        ..particles
    };
    fails(
        add(&many, &STEP, &mut tallies),
        ELLGRAN_ERROR_ARGUMENT,
        &["owned_count = 2 is greater than count = 1"],
    );
    let standing = EllgranStep {
        advance_history: 0,
        ..STEP
    };
    ok(add(&particles, &standing, &mut tallies));
    assert_eq!(
        (tallies.viscous_dissipation, tallies.tangential_work),
        (0.0, 0.0)
    );
}

/// A half-step velocity that is no number, or out of range, is an error that names the particle, also where no friction reads it: the
/// dissipated energies would be no numbers. Nothing is written then.
#[test]
fn changes_of_velocities_that_cannot_be() {
    for friction in ["", " tangential tfd 0.3"] {
        for (value, word) in [
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
            (f64::NEG_INFINITY, "-inf"),
            (1e26, "1e26"),
        ] {
            for component in 0..6 {
                let what = format!("'{friction}' {value:e} {component}");
                refused_change(
                    &format!("nfd 200 0.3 3 3{friction}"),
                    value,
                    word,
                    component,
                    &what,
                );
            }
        }
    }
}

fn refused_change(law: &str, value: f64, word: &str, component: usize, what: &str) {
    let laws = Laws::new(&[law]);
    let workspace = WorkspaceHandle::new();
    let plane = WallHandle::plane([0.0; 3], [0.0, 0.0, 1.0]);
    let mut bodies = [sphere_at(0.0), sphere_at(1.9)];
    for (body, identifier) in bodies.iter_mut().zip([1234, 5678]) {
        body.position[2] = 0.99;
        body.velocity = [0.1 * (1.0 - body.position[0]), 0.2, -0.3];
        body.velocities_of_step = 1;
        body.identifier = identifier;
    }
    let mut arrays = Arrays::new(&bodies, 2);
    let mut list = List::new(vec![vec![1], vec![]], laws.length());
    let mut memory = plane.histories(&laws, 2);
    let mut loads = [[0.0; 12]; 2];
    let mut tallies = no_tallies();
    tallies.inelastic_loads = loads.as_mut_ptr().cast();
    let mut of_wall = no_tallies();
    let mut call = |arrays: &mut Arrays, after: bool| {
        let (particles, view) = (arrays.particles(), list.view(true));
        let of_list = if after {
            // SAFETY: the arrays live to the end of the call.
            unsafe { ellgran_tally_following_half_step(&particles, &STEP, &mut tallies) }
        } else {
            laws.pairs(&workspace, &particles, &view, &STEP, &mut tallies)
        };
        let text = message();
        // SAFETY: the arrays live to the end of the call.
        let of_wall = unsafe {
            ok(ellgran_wall_keep_inelastic_loads(plane.0, 1));
            if after {
                ellgran_wall_tally_following_half_step(plane.0, &particles, &STEP, &mut of_wall)
            } else {
                ellgran_compute_wall(
                    laws.0,
                    workspace.0,
                    plane.0,
                    &particles,
                    null(),
                    0,
                    1,
                    null(),
                    memory.as_mut_ptr(),
                    &STEP,
                    null_mut(),
                    &mut of_wall,
                )
            }
        };
        [(of_list, text), (of_wall, message())]
    };
    let refuses = |results: [(i32, String); 2]| {
        let quantity = ["velocity", "angular velocity"][component / 3];
        for (status, text) in results {
            assert_eq!(status, ELLGRAN_ERROR_PARTICLE, "{what}: {text}");
            for part in ["particle 5678", quantity, word.trim_start_matches('-')] {
                assert!(text.contains(part), "{what}: {text}");
            }
        }
    };
    arrays.velocity_changes[1][component] = value;
    let before = (arrays.forces.clone(), arrays.torques.clone());
    refuses(call(&mut arrays, false));
    assert_eq!(
        (&arrays.forces, &arrays.torques),
        (&before.0, &before.1),
        "{what}"
    );
    arrays.velocity_changes[1][component] = 0.0;
    for after in [false, true] {
        for (status, text) in call(&mut arrays, after) {
            assert_eq!(status, ELLGRAN_SUCCESS, "{what}: {text}");
        }
    }
    arrays.velocity_changes[1][component] = value;
    refuses(call(&mut arrays, true));
    for sums in [&tallies, &of_wall] {
        assert!(sums.viscous_dissipation > 0.0 && sums.tangential_work.is_finite());
    }
}
