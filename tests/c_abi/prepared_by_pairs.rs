// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a call for the pairs has prepared serves a wall: the same forces and histories, to the bit.

use std::ptr::{null, null_mut};

use ellgran::c_api::contact::*;
use ellgran::c_api::law::ellgran_laws_history_length;
use ellgran::c_api::neighbour_list::ellgran_compute_pairs;
use ellgran::c_api::particles::{EllgranParticles, EllgranWorkspace};
use ellgran::c_api::rigid_wall::*;

use crate::scene::*;

const LAW: &str = "nfd 1e4 0.3 40 60 tangential tfd 0.4";

/// Grains in a row on a floor at z = -0.9, each in touch with the next but the last two, which stand alone.
fn grains(semi_axes: [f64; 3], of_step: bool) -> Vec<EllgranBody> {
    let places = [-9.0, -7.1, -5.2, -3.3, -1.4, 0.5, 2.4, 4.3, 6.2, 11.0, 16.0];
    let mut all: Vec<_> = places.map(sphere_at).into();
    for (k, body) in all.iter_mut().enumerate() {
        let turn = 0.2 * k as f64;
        body.semi_axes = semi_axes;
        body.quaternion = [1.0, turn, 0.1, 0.3 - turn];
        body.velocity = [0.3, -0.2, -0.1 * k as f64];
        body.angular_velocity = [0.1, 0.2 * k as f64, -0.3];
        body.velocities_of_step = i64::from(of_step);
        body.velocity_change = [0.01, 0.02, 0.03 * k as f64];
        body.angular_velocity_change = [0.04, -0.01 * k as f64, 0.02];
    }
    all
}

/// Who is named as having prepared the particles.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Named {
    Nobody,
    TheOwn,
    Another,
}

/// Forces, torques and histories with the floor in so many steps, after the pairs of each.
fn run(
    bodies: &[EllgranBody],
    named: Named,
    disturb: impl Fn(usize, &mut Arrays),
) -> (Vec<[f64; 3]>, Vec<[f64; 3]>, Vec<f64>) {
    let laws = Laws::new(&[LAW]);
    let (of_pairs, of_wall) = (WorkspaceHandle::new(), WorkspaceHandle::new());
    let of_wall = match named {
        Named::Another => &of_wall,
        _ => &of_pairs,
    };
    let wall = WallHandle::plane([0.0, 0.0, -0.9], [0.0, 0.0, 1.0]);
    let count = bodies.len();
    let mut histories = wall.histories(&laws, count);
    // SAFETY: the laws are valid.
    let length = unsafe { ellgran_laws_history_length(laws.0) };
    let mut list = List::near(bodies, count, length as usize);
    let mut bodies = bodies.to_vec();
    let (mut forces, mut torques) = (Vec::new(), Vec::new());
    for number in 0..4 {
        let mut arrays = Arrays::new(&bodies, count);
        let particles = arrays.particles();
        let mut view = list.view(true);
        view.unchanged = i32::from(number > 0);
        // SAFETY: all pointers are valid.
        ok(unsafe {
            ellgran_compute_pairs(laws.0, of_pairs.0, &particles, &view, &STEP, null_mut())
        });
        arrays.forces.fill([0.0; 3]);
        arrays.torques.fill([0.0; 3]);
        disturb(number, &mut arrays);
        let particles = EllgranParticles {
            unchanged: i64::from(number > 0),
            prepared_by: match named {
                Named::Nobody => null::<EllgranWorkspace>(),
                _ => of_pairs.0,
            },
            ..arrays.particles()
        };
        // SAFETY: all pointers are valid.
        ok(unsafe {
            ellgran_compute_wall(
                laws.0,
                of_wall.0,
                wall.0,
                &particles,
                null(),
                0,
                1,
                &REST,
                histories.as_mut_ptr(),
                &STEP,
                null_mut(),
                null_mut(),
            )
        });
        forces.append(&mut arrays.forces);
        torques.append(&mut arrays.torques);
        for body in &mut bodies {
            for axis in 0..3 {
                body.position[axis] += STEP.time_step * body.velocity[axis];
                body.quaternion[axis] += 1e-3;
            }
        }
    }
    (forces, torques, histories)
}

#[test]
fn forces_with_a_wall_are_the_same() {
    for semi_axes in [[1.0; 3], [1.2, 1.0, 1.0], [1.2, 1.0, 0.95]] {
        for of_step in [false, true] {
            let bodies = grains(semi_axes, of_step);
            let alone = run(&bodies, Named::Nobody, |_, _| {});
            assert!(alone.0[..11].iter().filter(|f| f[2] > 0.0).count() > 6);
            for named in [Named::TheOwn, Named::Another] {
                let found = run(&bodies, named, |_, _| {});
                assert_eq!(found, alone, "{semi_axes:?}, {of_step}, {named:?}");
            }
        }
    }
}

/// The promise that nothing has changed since is kept by the caller: what was prepared is used, which an orientation shows that is
/// another all the same. Of a particle elsewhere, or with another velocity, nothing is.
#[test]
fn what_was_prepared_is_used_where_place_and_velocity_are_the_same() {
    let bodies = grains([1.2, 1.0, 0.95], true);
    let before = run(&bodies, Named::Nobody, |_, _| {});
    let turned = |_: usize, arrays: &mut Arrays| arrays.quaternions.fill([1.0, 0.5, 0.0, 0.0]);
    let now = run(&bodies, Named::Another, turned);
    // Those that stand alone take part in no pair: nothing is prepared of them before the wall has asked for it.
    for k in 0..9 {
        assert_eq!(now.0[k], before.0[k]);
    }
    for k in 9..11 {
        assert_ne!(now.0[k], before.0[k]);
    }
    let turned_later = |number: usize, arrays: &mut Arrays| {
        if number > 0 {
            turned(number, arrays);
        }
    };
    assert_eq!(run(&bodies, Named::Another, turned_later), before);
    let moved = |number: usize, arrays: &mut Arrays| {
        turned(number, arrays);
        for (x, v) in arrays.positions.iter_mut().zip(&mut arrays.velocities) {
            if [0, 2].contains(&number) {
                x[2] -= 1e-9;
            } else {
                v[0] += 1e-9;
            }
        }
    };
    let alone = run(&bodies, Named::Nobody, moved);
    assert_eq!(run(&bodies, Named::Another, moved), alone);
}

/// Records of step velocities do not serve a call that has those of the half step, nor the other way round.
#[test]
fn other_kinds_of_velocities_are_prepared_again() {
    let bodies = grains([1.2, 1.0, 1.0], true);
    let without = |_: usize, arrays: &mut Arrays| arrays.velocity_changes.clear();
    let alone = run(&bodies, Named::Nobody, without);
    assert_eq!(run(&bodies, Named::Another, without), alone);
}
