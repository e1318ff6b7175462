// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contacts with walls for an engine's own contact model: the same as in the call that computes their forces, with triangles that the
//! engine lends.

use std::ptr::{null, null_mut};

use ellgran::c_api::contact::*;
use ellgran::c_api::engine_walls::*;
use ellgran::c_api::law::ellgran_laws_memory_offset;
use ellgran::c_api::particles::EllgranParticles;
use ellgran::c_api::rigid_wall::*;
use ellgran::c_api::staged::*;
use ellgran::c_api::status::*;

use crate::scene::*;

const LAW: &str = "nfd 1e4 0.3 40 60 tangential tfd 0.4";

/// A floor of two triangles at z = -0.9.
const FLOOR: [[[f64; 3]; 3]; 2] = [
    [[-9.0, -9.0, -0.9], [9.0, -9.0, -0.9], [9.0, 9.0, -0.9]],
    [[-9.0, -9.0, -0.9], [9.0, 9.0, -0.9], [-9.0, 9.0, -0.9]],
];

fn lent(starts: &[usize], near: &[u32]) -> EllgranLentTriangles {
    EllgranLentTriangles {
        size: size_of::<EllgranLentTriangles>(),
        count: 2,
        corners: FLOOR.as_ptr().cast(),
        velocities: null(),
        particle_count: starts.len() - 1,
        near_starts: starts.as_ptr(),
        near: near.as_ptr(),
        velocity_changes: null(),
    }
}

/// Three grains that slide over the floor, the last one out of reach.
fn grains() -> [EllgranBody; 3] {
    let mut all = [-3.0, 1.0, 4.0].map(sphere_at);
    for (k, body) in all.iter_mut().enumerate() {
        body.semi_axes = [1.2, 1.0, 0.95];
        body.velocity = [0.3, -0.2, -0.1];
        body.angular_velocity = [0.1, 0.2 * k as f64, -0.3];
    }
    all[2].position[2] = 0.5;
    all
}

fn far(memory: &[f64]) -> bool {
    memory.iter().all(|m| *m == 0.0)
}

/// An engine that computes each contact with the library's own stages gets what the library computes for all of them.
#[test]
fn found_contacts_and_their_stages_are_the_whole_call() {
    let laws = Laws::new(&[LAW]);
    let workspace = WorkspaceHandle::new();
    let (own, engine) = (WallHandle::new(), WallHandle::new());
    let speed = [0.5, 0.1, 0.0];
    let velocities = [[speed; 3]; 2];
    let triangles = EllgranLentTriangles {
        velocities: velocities.as_ptr().cast(),
        ..lent(&[0, 2, 4, 6], &[0, 1, 0, 1, 0, 1])
    };
    let moving = EllgranWallMotion {
        velocity: speed,
        ..REST
    };
    // The library's own walls keep the displacement, the engine's triangles are where they are.
    // SAFETY: all pointers are valid, here and below.
    let (length, at) = unsafe {
        ok(ellgran_wall_add_triangles(own.0, 2, FLOOR.as_ptr().cast()));
        ok(ellgran_wall_lend_triangles(engine.0, &triangles));
        (4, ellgran_laws_memory_offset(laws.0) as usize)
    };
    let mut histories = own.histories(&laws, 3);
    // SAFETY: valid.
    let per_particle = unsafe { ellgran_wall_found_histories_length(engine.0, length) };
    let mut remembered = vec![0.0; 3 * per_particle];
    let mut staged = null_mut();
    // SAFETY: valid for writes.
    ok(unsafe { ellgran_staged_new(&mut staged) });
    let mut bodies = grains();
    let mut went_on = 0;
    for step in 0..20 {
        let mut arrays = Arrays::new(&bodies, 3);
        let particles = arrays.particles();
        let mut load = NO_LOAD;
        // SAFETY: all pointers are valid.
        unsafe {
            ok(ellgran_compute_wall(
                laws.0,
                workspace.0,
                own.0,
                &particles,
                null(),
                0,
                1,
                &moving,
                histories.as_mut_ptr(),
                &STEP,
                &mut load,
                null_mut(),
            ));
            ok(ellgran_find_wall_contacts(
                workspace.0,
                engine.0,
                &particles,
                null(),
                0,
                null(),
                length,
                remembered.as_ptr(),
            ));
            assert_eq!(load.contact_count, 2);
            assert_eq!(ellgran_wall_found_count(engine.0), 2);
            for k in 0..2 {
                let mut found = Untouched::<EllgranFoundWallContact>::sized();
                let mut geometry = Untouched::<EllgranStagedGeometry>::sized();
                let mut force = Untouched::<EllgranContactForce>::sized();
                ok(ellgran_wall_found(engine.0, k, found.pointer()));
                let c = *found.pointer();
                assert_eq!((c.particle, c.part, c.is_forgotten), (k, 0, 0));
                assert_eq!(c.touched, i32::from(step > 0));
                went_on += c.touched;
                ok(ellgran_staged_found(
                    staged,
                    engine.0,
                    k,
                    0.5,
                    geometry.pointer(),
                ));
                let history = EllgranStagedHistory {
                    size: size_of::<EllgranStagedHistory>(),
                    friction: 0.4,
                    touched: c.touched,
                    normal: c.last_normal,
                };
                ok(ellgran_staged_forces(
                    staged,
                    laws.0,
                    1,
                    1,
                    1.0,
                    &STEP,
                    &history,
                    c.history,
                    force.pointer(),
                ));
                let f = *force.pointer();
                for (a, b) in arrays.forces[k].iter().zip(f.force) {
                    assert!((a + b).abs() < 1e-9 * f.normal_force, "{step} {k}: {a} {b}");
                }
                for (own, expected) in c.velocity.iter().zip(speed) {
                    assert!((own - expected).abs() < 1e-12);
                }
                assert!((c.point[2] + 0.9).abs() < 1e-12 && f.normal_force > 0.0);
            }
            ok(ellgran_remember_wall_contacts(
                engine.0,
                3,
                null(),
                0,
                remembered.as_mut_ptr(),
            ));
        }
        // The tangential histories of both: behind count, part, point and normal.
        for k in 0..2 {
            let one = &histories[k * histories.len() / 3..][8 + at..][..length];
            let other = &remembered[k * per_particle..][8..][..length];
            for (a, b) in one.iter().zip(other) {
                assert!((a - b).abs() < 1e-9, "{step}: {one:?} {other:?}");
            }
            assert!(other.iter().any(|x| *x != 0.0));
        }
        assert!(far(&remembered[2 * per_particle..]));
        for body in &mut bodies {
            for m in 0..3 {
                body.position[m] += STEP.time_step * body.velocity[m];
            }
        }
    }
    assert_eq!(went_on, 2 * 19);
    // What is no longer near is no longer remembered, but where the wall does not act.
    for body in &mut bodies {
        body.position[2] += 5.0;
    }
    let masks = [1, 2, 1];
    let mut arrays = Arrays::new(&bodies, 3);
    // SAFETY: all pointers are valid.
    unsafe {
        ok(ellgran_find_wall_contacts(
            workspace.0,
            engine.0,
            &arrays.particles(),
            masks.as_ptr(),
            1,
            null(),
            length,
            remembered.as_ptr(),
        ));
        assert_eq!(ellgran_wall_found_count(engine.0), 0);
        let r = remembered.as_mut_ptr();
        ok(ellgran_remember_wall_contacts(
            engine.0,
            3,
            masks.as_ptr(),
            1,
            r,
        ));
        ellgran_staged_free(staged);
    }
    assert!(far(&remembered[..per_particle]) && !far(&remembered[per_particle..2 * per_particle]));
}

#[track_caller]
fn is_null(status: i32, name: &str) {
    let words = format!("{name} must not be NULL");
    fails(status, ELLGRAN_ERROR_NULL_POINTER, &[&words]);
}

#[test]
fn pointers_and_values() {
    let wall = WallHandle::new();
    let workspace = WorkspaceHandle::new();
    let mut arrays = Arrays::new(&grains(), 3);
    let particles = arrays.particles();
    let (p, w) = (&particles as *const _, workspace.0);
    let argument = ELLGRAN_ERROR_ARGUMENT;
    let mut found = Untouched::<EllgranFoundWallContact>::sized();
    let mut geometry = Untouched::<EllgranStagedGeometry>::sized();
    let mut staged = null_mut();
    // SAFETY: pointers are NULL or valid.
    unsafe {
        ok(ellgran_staged_new(&mut staged));
        let good = lent(&[0, 2], &[0, 1]);
        is_null(ellgran_wall_lend_triangles(null_mut(), &good), "wall");
        is_null(ellgran_wall_lend_triangles(wall.0, null()), "triangles");
        type Change = fn(&mut EllgranLentTriangles);
        let lost: [(&str, Change); 3] = [
            ("corners", |t| t.corners = null()),
            ("near_starts", |t| t.near_starts = null()),
            ("near", |t| t.near = null()),
        ];
        for (name, lose) in lost {
            let mut wrong = good;
            lose(&mut wrong);
            is_null(ellgran_wall_lend_triangles(wall.0, &wrong), name);
        }
        for (starts, near, word) in [
            ([0, 2], [0, 2], "triangle 2 of 2"),
            ([2, 0], [0, 1], "near_starts"),
        ] {
            let wrong = lent(&starts, &near);
            fails(
                ellgran_wall_lend_triangles(wall.0, &wrong),
                argument,
                &[word],
            );
        }
        ok(ellgran_wall_lend_triangles(wall.0, &good));
        assert_eq!(ellgran_wall_part_count(wall.0), 1);
        assert_eq!(ellgran_wall_found_histories_length(null(), 4), 0);
        assert_eq!(ellgran_wall_found_histories_length(wall.0, 0), 0);
        let length = 3 * ellgran_wall_found_histories_length(wall.0, 4);
        let mut histories = vec![0.0; length];
        let find = |w, wall, p, m| ellgran_find_wall_contacts(w, wall, p, null(), 0, null(), 4, m);
        let m: *const f64 = histories.as_ptr();
        is_null(find(null_mut(), wall.0, p, m), "workspace");
        is_null(find(w, null_mut(), p, m), "wall");
        is_null(find(w, wall.0, null(), m), "particles");
        is_null(find(w, wall.0, p, null()), "histories");
        histories[0] = 0.5;
        fails(
            find(w, wall.0, p, histories.as_ptr()),
            ELLGRAN_ERROR_HISTORY,
            &["particle 7", "0.5"],
        );
        histories[0] = 0.0;
        assert_eq!(ellgran_wall_found_count(wall.0), 0);
        ok(find(w, wall.0, p, histories.as_ptr()));
        assert_eq!(ellgran_wall_found_count(null()), 0);
        assert_eq!(ellgran_wall_found_count(wall.0), 1);
        is_null(ellgran_wall_found(null_mut(), 0, found.pointer()), "wall");
        is_null(ellgran_wall_found(wall.0, 0, null_mut()), "found");
        fails(
            ellgran_wall_found(wall.0, 1, found.pointer()),
            argument,
            &["index = 1", "1 contacts"],
        );
        let g = geometry.pointer();
        is_null(
            ellgran_staged_found(null_mut(), wall.0, 0, 0.5, g),
            "staged",
        );
        is_null(ellgran_staged_found(staged, null(), 0, 0.5, g), "wall");
        is_null(
            ellgran_staged_found(staged, wall.0, 0, 0.5, null_mut()),
            "geometry",
        );
        fails(
            ellgran_staged_found(staged, wall.0, 0, 1.5, g),
            argument,
            &["share_i = 1.5"],
        );
        fails(
            ellgran_staged_found(staged, wall.0, 3, 0.5, g),
            argument,
            &["index = 3"],
        );
        let r = histories.as_mut_ptr();
        let remember = |wall, count, m| ellgran_remember_wall_contacts(wall, count, null(), 0, m);
        is_null(remember(null(), 3, r), "wall");
        is_null(remember(wall.0, 3, null_mut()), "histories");
        fails(remember(wall.0, 0, r), argument, &["owned_count = 0"]);
        assert!(far(&histories));
        ok(remember(wall.0, 3, r));
        assert_eq!(histories[0], 1.0);
        ellgran_staged_free(staged);
    }
    found.check();
    geometry.check();
}

/// `unchanged` of the particles speaks of the calls that compute forces: a search for an engine neither goes by it nor disturbs it.
#[test]
fn a_search_with_other_masks_stays_apart_from_forces() {
    let laws = Laws::new(&[LAW]);
    let workspace = WorkspaceHandle::new();
    let wall = WallHandle::plane([0.0, 0.0, -0.9], [0.0, 0.0, 1.0]);
    let mut bodies = grains();
    bodies[2].position[2] = 0.0;
    let mut histories = wall.histories(&laws, 3);
    let (of_forces, of_search) = ([1, 1, 0], [0, 0, 1]);
    let mut forces = |unchanged: i64| {
        let mut arrays = Arrays::new(&bodies, 3);
        let particles = EllgranParticles {
            unchanged,
            ..arrays.particles()
        };
        // SAFETY: all pointers are valid.
        ok(unsafe {
            ellgran_compute_wall(
                laws.0,
                workspace.0,
                wall.0,
                &particles,
                of_forces.as_ptr(),
                1,
                1,
                &REST,
                histories.as_mut_ptr(),
                &STEP,
                null_mut(),
                null_mut(),
            )
        });
        [0, 1, 2].map(|k| arrays.forces[k][2] > 0.0)
    };
    let found = |unchanged: i64| {
        let mut arrays = Arrays::new(&bodies, 3);
        let particles = EllgranParticles {
            unchanged,
            ..arrays.particles()
        };
        let mut contact = Untouched::<EllgranFoundWallContact>::sized();
        // SAFETY: all pointers are valid.
        unsafe {
            ok(ellgran_find_wall_contacts(
                workspace.0,
                wall.0,
                &particles,
                of_search.as_ptr(),
                1,
                null(),
                0,
                null(),
            ));
            assert_eq!(ellgran_wall_found_count(wall.0), 1);
            ok(ellgran_wall_found(wall.0, 0, contact.pointer()));
            (*contact.pointer()).particle
        }
    };
    assert_eq!(forces(0), [true, true, false]);
    for unchanged in [0, 1] {
        assert_eq!(found(unchanged), 2);
        assert_eq!(forces(1), [true, true, false]);
    }
}
