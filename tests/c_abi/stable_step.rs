// SPDX-License-Identifier: MIT OR Apache-2.0
//! The time step that all contacts of a scene allow: sums of pairs and walls, extremes, and what is refused.

use std::ptr::{null, null_mut};

use ellgran::c_api::contact::EllgranBody;
use ellgran::c_api::engine_walls::*;
use ellgran::c_api::particles::EllgranParticles;
use ellgran::c_api::stable_step::*;
use ellgran::c_api::status::*;
use ellgran::c_api::stiffness::*;

use crate::scene::*;

const DECKS: [&str; 2] = [
    "nfd 1e4 0.3 40 60 tangential tfd 0.4",
    "nfd 3e4 0.2 90 30 tangential tfd 0.2",
];
const LENGTH: usize = ELLGRAN_STEP_SUMS_LENGTH;

fn none() -> EllgranContactExtremes {
    EllgranContactExtremes {
        size: size_of::<EllgranContactExtremes>(),
        touching_count: 0,
        shortest_collision: 0.0,
        collision_speed: 0.0,
        collision_stiffness: 0.0,
        collision_inverse_mass: 0.0,
        collision_effective_mass: 0.0,
        collision_identifiers: [0; 2],
        collision_types: [0; 2],
        deepest_overlap: 0.0,
        deepest_identifiers: [0; 2],
    }
}

/// Sums and extremes of a list.
fn of_pairs(
    laws: &Laws,
    bodies: &[EllgranBody],
    rows: Vec<Vec<i32>>,
) -> (Vec<f64>, EllgranContactExtremes) {
    let mut arrays = Arrays::new(bodies, bodies.len());
    let mut list = List::new(rows, laws.length());
    let workspace = WorkspaceHandle::new();
    let mut sums = vec![0.0; bodies.len() * LENGTH];
    let mut extremes = none();
    // SAFETY: the arrays are as long as the structs say.
    ok(unsafe {
        ellgran_add_pairs_to_step_sums(
            laws.0,
            workspace.0,
            &arrays.particles(),
            &list.view(true),
            sums.as_mut_ptr(),
            &mut extremes,
        )
    });
    (sums, extremes)
}

fn step_of(sums: &[f64]) -> (f64, i64) {
    let (mut step, mut limiting) = (0.0, 0);
    // SAFETY: as many sums as the count says.
    ok(unsafe {
        ellgran_stable_step(sums.as_ptr(), sums.len() / LENGTH, &mut step, &mut limiting)
    });
    (step, limiting)
}

fn all_near(bodies: &[EllgranBody]) -> Vec<Vec<i32>> {
    List::near(bodies, bodies.len(), 0).rows
}

/// A central impact: the bound is the critical step of the contact.
#[test]
fn two_spheres_and_a_fixed_one() {
    let laws = Laws::new(&DECKS);
    let mut bodies = [sphere_at(0.0), sphere_at(1.99)];
    bodies[1].identifier = 8;
    let critical = |bodies: &[EllgranBody; 2]| {
        let mut out = Untouched::<EllgranContactStiffness>::sized();
        // SAFETY: valid pointers; written on success.
        unsafe {
            ok(ellgran_contact_stiffness(
                laws.0,
                &bodies[0],
                &bodies[1],
                out.pointer(),
            ));
            (*out.pointer()).critical_step
        }
    };
    for fixed in [false, true] {
        if fixed {
            bodies[0].mass = f64::INFINITY;
        }
        let (sums, extremes) = of_pairs(&laws, &bodies, vec![vec![1], vec![]]);
        let (step, limiting) = step_of(&sums);
        assert!((step / critical(&bodies) - 1.0).abs() < 2e-6);
        assert!(!fixed || limiting == 1);
        assert_eq!(sums[..LENGTH].iter().all(|s| *s == 0.0), fixed);
        assert_eq!(extremes.touching_count, 1);
        assert!((extremes.deepest_overlap - 0.01).abs() < 1e-12);
        assert_eq!(extremes.collision_identifiers, [7, 8]);
        assert_eq!(extremes.collision_types, [1, 1]);
    }
    // Both fixed, or apart: nothing limits the step.
    bodies[1].mass = f64::INFINITY;
    let (sums, extremes) = of_pairs(&laws, &bodies, vec![vec![1], vec![]]);
    assert_eq!(step_of(&sums), (f64::INFINITY, -1));
    assert_eq!(extremes.shortest_collision, 0.0);
    bodies[1].position[0] = 3.0;
    let (sums, extremes) = of_pairs(&laws, &bodies, vec![vec![1], vec![]]);
    assert_eq!(step_of(&sums), (f64::INFINITY, -1));
    assert_eq!(
        (extremes.touching_count, extremes.deepest_overlap),
        (0, 0.0)
    );
}

/// Lists that share the pairs, in calls one after the other, and rows with their particles exchanged give the same.
#[test]
fn sums_of_lists_add() {
    let laws = Laws::new(&DECKS);
    let bodies = random_bodies(3);
    let rows = all_near(&bodies);
    let (whole, extremes) = of_pairs(&laws, &bodies, rows.clone());
    assert!(extremes.touching_count > 50);
    let (step, limiting) = step_of(&whole);
    assert!(step > 0.0 && (0..64).contains(&limiting));

    let part = |keep: usize| -> Vec<Vec<i32>> {
        rows.iter()
            .map(|row| {
                row.iter()
                    .copied()
                    .filter(|j| *j as usize % 2 == keep)
                    .collect()
            })
            .collect()
    };
    let (even, a) = of_pairs(&laws, &bodies, part(0));
    let (odd, b) = of_pairs(&laws, &bodies, part(1));
    assert_eq!(a.touching_count + b.touching_count, extremes.touching_count);
    let sum: Vec<f64> = even.iter().zip(&odd).map(|(a, b)| a + b).collect();
    let (of_sum, same) = step_of(&sum);
    assert!((of_sum / step - 1.0).abs() < 1e-9);
    assert_eq!(same, limiting);

    let mut exchanged = vec![vec![]; bodies.len()];
    for (i, row) in rows.iter().enumerate() {
        for j in row {
            exchanged[*j as usize].push(i as i32);
        }
    }
    let (other, b) = of_pairs(&laws, &bodies, exchanged);
    let (of_other, same) = step_of(&other);
    assert!((of_other / step - 1.0).abs() < 1e-6);
    assert_eq!(same, limiting);
    assert!((b.shortest_collision / extremes.shortest_collision - 1.0).abs() < 1e-9);
    assert!((b.deepest_overlap / extremes.deepest_overlap - 1.0).abs() < 1e-9);
}

/// A sphere on a plane, whose type is told for each contact.
#[test]
fn a_wall() {
    let laws = Laws::new(&DECKS);
    let mut arrays = Arrays::new(&[sphere_at(0.99)], 1);
    let wall = WallHandle::plane([0.0; 3], [1.0, 0.0, 0.0]);
    let workspace = WorkspaceHandle::new();
    let p: EllgranParticles = arrays.particles();
    // SAFETY: the arrays are as long as the structs say.
    let find = || unsafe {
        ok(ellgran_find_wall_contacts(
            workspace.0,
            wall.0,
            &p,
            null(),
            0,
            &REST,
            0,
            null(),
        ));
        ellgran_wall_found_count(wall.0)
    };
    let step = |wall_type: i32| {
        assert_eq!(find(), 1);
        let mut sums = vec![0.0; LENGTH];
        let mut extremes = none();
        // SAFETY: as above.
        ok(unsafe {
            ellgran_add_wall_to_step_sums(
                laws.0,
                workspace.0,
                wall.0,
                &p,
                &wall_type,
                sums.as_mut_ptr(),
                &mut extremes,
            )
        });
        assert_eq!(extremes.collision_identifiers, [7, 0]);
        assert_eq!(extremes.collision_types, [1, wall_type]);
        step_of(&sums).0
    };
    // The plane is a fixed sphere of infinite radius.
    let mut plane = sphere_at(-1e6);
    plane.semi_axes = [1e6; 3];
    plane.mass = f64::INFINITY;
    for wall_type in [1, 2] {
        plane.particle_type = wall_type;
        let mut out = Untouched::<EllgranContactStiffness>::sized();
        // SAFETY: valid pointers; written on success.
        let expected = unsafe {
            ok(ellgran_contact_stiffness(
                laws.0,
                &sphere_at(0.99),
                &plane,
                out.pointer(),
            ));
            (*out.pointer()).critical_step
        };
        assert!((step(wall_type) / expected - 1.0).abs() < 1e-5);
    }
    find();
    let mut sums = vec![0.0; LENGTH];
    for wall_type in [0, 3] {
        // SAFETY: as above.
        fails(
            unsafe {
                ellgran_add_wall_to_step_sums(
                    laws.0,
                    workspace.0,
                    wall.0,
                    &p,
                    &wall_type,
                    sums.as_mut_ptr(),
                    null_mut(),
                )
            },
            ELLGRAN_ERROR_ARGUMENT,
            &["wall_types", &format!("type {wall_type}")],
        );
    }
    // Contacts that were found with other particles.
    let other = WorkspaceHandle::new();
    // SAFETY: as above.
    fails(
        unsafe {
            ellgran_add_wall_to_step_sums(
                laws.0,
                other.0,
                wall.0,
                &p,
                &1,
                sums.as_mut_ptr(),
                null_mut(),
            )
        },
        ELLGRAN_ERROR_ARGUMENT,
        &["ellgran_find_wall_contacts"],
    );
    assert!(sums.iter().all(|s| *s == 0.0));
}

#[test]
fn a_step_for_an_error() {
    let laws = Laws::new(&DECKS);
    let bodies = [sphere_at(0.0), sphere_at(1.99)];
    let (_, extremes) = of_pairs(&laws, &bodies, vec![vec![1], vec![]]);
    let ask = |extremes: &EllgranContactExtremes, error: f64| {
        let mut step = 0.0;
        // SAFETY: valid pointers.
        ok(unsafe { ellgran_step_for_error(laws.0, extremes, error, &mut step) });
        step
    };
    let [rough, fine] = [1e-2, 1e-4].map(|error| ask(&extremes, error));
    assert!(fine > 0.0 && fine < rough && rough < extremes.shortest_collision / 4.0);
    assert_eq!(ask(&none(), 1e-3), f64::INFINITY);
    let mut step = Untouched::<f64>::new();
    for error in [0.0, 1e-7, 0.6, f64::NAN, -1.0] {
        // SAFETY: valid pointers.
        fails(
            unsafe { ellgran_step_for_error(laws.0, &extremes, error, step.pointer()) },
            ELLGRAN_ERROR_ARGUMENT,
            &["error", "1e-6"],
        );
    }
    let mut wrong = extremes;
    wrong.collision_types[1] = 3;
    // SAFETY: valid pointers.
    fails(
        unsafe { ellgran_step_for_error(laws.0, &wrong, 1e-3, step.pointer()) },
        ELLGRAN_ERROR_ARGUMENT,
        &["collision_types", "type 3"],
    );
    wrong = extremes;
    wrong.collision_speed = f64::NAN;
    // SAFETY: valid pointers.
    fails(
        unsafe { ellgran_step_for_error(laws.0, &wrong, 1e-3, step.pointer()) },
        ELLGRAN_ERROR_ARGUMENT,
        &["NaN"],
    );
    step.check();
}

#[test]
fn wrong_arguments_are_named_and_nothing_is_written() {
    let laws = Laws::new(&DECKS);
    let bodies = [sphere_at(0.0), sphere_at(1.99)];
    let workspace = WorkspaceHandle::new();
    let (l, w) = (laws.0, workspace.0);
    let mut sums = vec![0.0; 2 * LENGTH];
    let s = sums.as_mut_ptr();
    let mut extremes = none();
    let e: *mut _ = &mut extremes;
    let call = |change: &dyn Fn(&mut Arrays, &mut List), status: i32, words: &[&str]| {
        let mut arrays = Arrays::new(&bodies, 2);
        let mut list = List::new(vec![vec![1], vec![]], laws.length());
        change(&mut arrays, &mut list);
        // SAFETY: the arrays are as long as the structs say.
        fails(
            unsafe {
                ellgran_add_pairs_to_step_sums(l, w, &arrays.particles(), &list.view(true), s, e)
            },
            status,
            words,
        );
    };
    call(
        &|a, _| a.masses[1] = 0.0,
        ELLGRAN_ERROR_PARTICLE,
        &["particle 7", "mass = 0"],
    );
    call(
        &|a, _| a.masses[1] = f64::NAN,
        ELLGRAN_ERROR_PARTICLE,
        &["particle 7", "mass = NaN"],
    );
    call(
        &|a, _| a.types[0] = 3,
        ELLGRAN_ERROR_PARTICLE,
        &["particle 7", "type 3"],
    );
    call(
        &|_, l| l.rows[0][0] = 5,
        ELLGRAN_ERROR_ARGUMENT,
        &["particle 5"],
    );
    call(
        &|_, l| l.rows[0][0] = 0,
        ELLGRAN_ERROR_ARGUMENT,
        &["the row itself"],
    );
    call(
        &|_, l| l.central[0] = 9,
        ELLGRAN_ERROR_ARGUMENT,
        &["central", "9"],
    );

    // Of a particle that is not fixed by its contact mass.
    for wrong in [f64::NAN, -1.0, 0.0, f64::NEG_INFINITY] {
        let masses = [1.0, wrong];
        let mut arrays = Arrays::new(&bodies, 2);
        let mut list = List::new(vec![vec![1], vec![]], laws.length());
        let particles = EllgranParticles {
            contact_masses: masses.as_ptr(),
            ..arrays.particles()
        };
        // SAFETY: as above.
        fails(
            unsafe { ellgran_add_pairs_to_step_sums(l, w, &particles, &list.view(true), s, e) },
            ELLGRAN_ERROR_PARTICLE,
            &["particle 7", "contact mass"],
        );
    }

    let mut arrays = Arrays::new(&bodies, 2);
    let mut list = List::new(vec![vec![1], vec![]], laws.length());
    let (p, v) = (arrays.particles(), list.view(true));
    let (mut step, mut limiting) = (Untouched::<f64>::new(), Untouched::<i64>::new());
    // SAFETY: pointers are NULL or valid.
    unsafe {
        // One after the other: the message is that of the last call.
        let null_is = |status: i32, word: &str| fails(status, ELLGRAN_ERROR_NULL_POINTER, &[word]);
        let (n, step_at) = (null_mut(), step.pointer());
        null_is(
            ellgran_add_pairs_to_step_sums(null(), w, &p, &v, s, e),
            "laws",
        );
        null_is(
            ellgran_add_pairs_to_step_sums(l, null_mut(), &p, &v, s, e),
            "workspace",
        );
        null_is(
            ellgran_add_pairs_to_step_sums(l, w, null(), &v, s, e),
            "particles",
        );
        null_is(
            ellgran_add_pairs_to_step_sums(l, w, &p, null(), s, e),
            "list",
        );
        null_is(ellgran_add_pairs_to_step_sums(l, w, &p, &v, n, e), "sums");
        null_is(
            ellgran_add_wall_to_step_sums(l, w, null(), &p, null(), s, e),
            "wall",
        );
        null_is(ellgran_stable_step(null(), 1, step_at, null_mut()), "sums");
        null_is(ellgran_stable_step(s, 1, n, null_mut()), "step");
        null_is(ellgran_step_for_error(l, null(), 1e-3, step_at), "extremes");
        null_is(ellgran_step_for_error(l, e, 1e-3, n), "step");
        assert!(sums.iter().all(|x| *x == 0.0));
        assert_eq!(extremes.touching_count, 0);
        sums[LENGTH + 3] = f64::NAN;
        fails(
            ellgran_stable_step(sums.as_ptr(), 2, step.pointer(), limiting.pointer()),
            ELLGRAN_ERROR_ARGUMENT,
            &["sums[1][3]", "NaN"],
        );
    }
    step.check();
    limiting.check();
}
