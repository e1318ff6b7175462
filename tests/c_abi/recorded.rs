// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contacts of a list one by one: their forces are those that acted, and asking for them changes none.

use std::ptr::{null, null_mut};

use ellgran::c_api::contact::*;
use ellgran::c_api::grain_sums::*;
use ellgran::c_api::neighbour_list::*;
use ellgran::c_api::particles::EllgranWorkspace;
use ellgran::c_api::recorded::*;
use ellgran::c_api::status::*;

use crate::scene::*;

const OWNED: usize = 44;

/// All terms of the law, and some of them alone; the linear law; what the lanes do not take.
const DECKS: [[&str; 2]; 5] = [
    [
        "nfd 1e4 0.3 40 60 tangential tfd 0.4",
        "nfd 3e4 0.2 90 30 tangential tfd 0.2",
    ],
    ["hertz 1e4 0.3", "hertz 3e4 0.2"],
    [
        "hertz 1e4 0.3 tangential mindlin 0.4 conservative no",
        "hertz 3e4 0.2 tangential mindlin 0.2 conservative no",
    ],
    ["lsd 3e3 5", "lsd 2e3 8"],
    [
        "hertz 1e4 0.3 tangential mindlin 0.4 factors hale",
        "hertz 3e4 0.2 tangential mindlin 0.2 factors hale",
    ],
];

type Recorded = (
    EllgranContactPlace,
    EllgranContactGeometry,
    EllgranContactForce,
);

fn recorded(workspace: *const EllgranWorkspace) -> Vec<Recorded> {
    let mut place = Untouched::<EllgranContactPlace>::sized();
    let mut geometry = Untouched::<EllgranContactGeometry>::sized();
    let mut force = Untouched::<EllgranContactForce>::sized();
    let (p, g, f) = (place.pointer(), geometry.pointer(), force.pointer());
    // SAFETY: all pointers are valid, and what they point to is written on success.
    unsafe {
        (0..ellgran_recorded_count(workspace))
            .map(|k| {
                ok(ellgran_recorded_contact(workspace, k, p, g, f));
                (*p, *g, *f)
            })
            .collect()
    }
}

struct Run {
    laws: Laws,
    workspace: WorkspaceHandle,
    list: List,
}

impl Run {
    fn new(decks: &[&str; 2], bodies: &[EllgranBody]) -> Run {
        let laws = Laws::new(decks);
        Run {
            list: List::near(bodies, OWNED, laws.length()),
            workspace: WorkspaceHandle::new(),
            laws,
        }
    }

    fn step(&mut self, bodies: &[EllgranBody], unchanged: bool, record: bool) -> Arrays {
        let mut arrays = Arrays::new(bodies, OWNED);
        let (particles, mut view) = (arrays.particles(), self.list.view(true));
        view.unchanged = i32::from(unchanged);
        view.record_contacts = i32::from(record);
        ok(self
            .laws
            .pairs(&self.workspace, &particles, &view, &STEP, null_mut()));
        arrays
    }
}

fn add(target: &mut [f64; 3], v: [f64; 3], sign: f64) {
    for (t, v) in target.iter_mut().zip(v) {
        *t += sign * v;
    }
}

fn largest(vectors: &[[f64; 3]]) -> f64 {
    vectors.iter().flatten().fold(0.0, |m, x| x.abs().max(m))
}

fn apart(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.iter()
        .flatten()
        .zip(b.iter().flatten())
        .fold(0.0, |m, (x, y)| (x - y).abs().max(m))
}

#[test]
fn records_are_what_acted() {
    for decks in &DECKS {
        let mut bodies = random_bodies(11);
        let mut with = Run::new(decks, &bodies);
        let mut without = Run::new(decks, &bodies);
        for step in 0..6 {
            advance(&mut bodies, STEP.time_step);
            // A record every other step, with histories that both kinds of call carry on.
            let record = step % 2 == 1;
            // One contact at a time, from the histories before the step.
            let (touching, history) = (with.list.touching.clone(), with.list.history.clone());
            let a = with.step(&bodies, step > 0, record);
            let b = without.step(&bodies, step > 0, false);
            let scale = largest(&b.forces);
            assert!(scale > 0.0);
            assert!(apart(&a.forces, &b.forces) <= 1e-12 * scale, "{decks:?}");
            assert!(apart(&a.torques, &b.torques) <= 1e-12 * scale, "{decks:?}");
            let all = recorded(with.workspace.0);
            if !record {
                assert!(all.is_empty());
                continue;
            }
            let now: i32 = with.list.touching.iter().flatten().sum();
            assert!(now > 40);
            assert_eq!(all.len(), now as usize);
            let mut sums = Arrays::new(&bodies, OWNED);
            let length = with.laws.length();
            let mut last = (-1, 0);
            for (number, (place, g, f)) in all.iter().enumerate() {
                let (i, j) = (place.i as usize, place.j as usize);
                assert_eq!(with.list.rows[i][place.entry], place.j);
                assert!(last < (place.i, place.entry), "not in the list's order");
                last = (place.i, place.entry);
                add(&mut sums.forces[i], f.force, -1.0);
                add(&mut sums.forces[j], f.force, 1.0);
                add(&mut sums.torques[i], f.torque_i, 1.0);
                add(&mut sums.torques[j], f.torque_j, 1.0);
                for (a, b) in [(place.i, place.j), (place.j, place.i)] {
                    let mut found = -7;
                    // SAFETY: valid pointers.
                    ok(unsafe { ellgran_recorded_find(with.workspace.0, a, b, &mut found) });
                    assert_eq!(found, number as i64);
                }
                alone(
                    &with.laws,
                    [&bodies[i], &bodies[j]],
                    touching[i].get(place.entry).copied().unwrap_or(0),
                    &history[i][place.entry * length..(place.entry + 1) * length],
                    (g, f),
                    scale,
                );
            }
            assert!(apart(&a.forces, &sums.forces) <= 1e-12 * scale, "{decks:?}");
            assert!(apart(&a.torques, &sums.torques) <= 1e-12 * scale);
        }
    }
}

/// The record of a contact is what `ellgran_contact` says of it.
fn alone(
    laws: &Laws,
    [i, j]: [&EllgranBody; 2],
    mut touching: i32,
    history: &[f64],
    (g, f): (&EllgranContactGeometry, &EllgranContactForce),
    scale: f64,
) {
    let mut history = history.to_vec();
    let (a, b) = laws.contact([i, j], &STEP, &mut touching, &mut history);
    let close = |what: &str, x: &[f64], y: &[f64], scale: f64| {
        for (x, y) in x.iter().zip(y) {
            assert!((x - y).abs() <= 1e-9 * scale, "{what}: {x} is not {y}");
        }
    };
    assert_eq!((g.touching, a.touching), (1, 1));
    close("penetration", &[g.penetration], &[a.penetration], 1.0);
    close("normal", &g.normal, &a.normal, 1.0);
    close("contact point", &g.contact_point, &a.contact_point, 10.0);
    close("witness of i", &g.witness_i, &a.witness_i, 10.0);
    close("witness of j", &g.witness_j, &a.witness_j, 10.0);
    close("A", &[g.curvature_a], &[a.curvature_a], 10.0);
    close("B", &[g.curvature_b], &[a.curvature_b], 10.0);
    let along: f64 = (0..3)
        .map(|k| g.major_direction[k] * a.major_direction[k])
        .sum();
    let distinct = a.curvature_b > 1.001 * a.curvature_a;
    assert!(!distinct || (along.abs() - 1.0).abs() < 1e-6, "{along}");
    close("force", &f.force, &b.force, scale);
    close("torque on i", &f.torque_i, &b.torque_i, scale);
    close("torque on j", &f.torque_j, &b.torque_j, scale);
    close("normal force", &[f.normal_force], &[b.normal_force], scale);
    close(
        "tangential force",
        &f.tangential_force,
        &b.tangential_force,
        scale,
    );
    close("displacement", &f.displacement, &b.displacement, 1.0);
    close("rate", &[f.penetration_rate], &[b.penetration_rate], 1.0);
    let energies = |f: &EllgranContactForce| {
        [
            f.elastic_energy,
            f.tangential_energy,
            f.viscous_power,
            f.tangential_power,
        ]
    };
    close("energies and powers", &energies(f), &energies(&b), scale);
    close(
        "contact ellipse",
        &f.contact_semi_axes,
        &b.contact_semi_axes,
        1.0,
    );
}

#[test]
fn what_is_not_recorded_is_said() {
    let bodies = random_bodies(11);
    let mut run = Run::new(&DECKS[0], &bodies);
    let w = run.workspace.0;
    let mut place = Untouched::<EllgranContactPlace>::sized();
    let mut number = -5;
    // SAFETY: the pointers are NULL or valid.
    unsafe {
        let p = place.pointer();
        let (g, f) = (null_mut(), null_mut());
        assert_eq!(ellgran_recorded_count(null()), 0);
        assert_eq!(ellgran_recorded_count(w), 0);
        ok(ellgran_recorded_find(w, 0, 1, &mut number));
        assert_eq!(number, -1);
        fails(
            ellgran_recorded_contact(w, 0, p, g, f),
            ELLGRAN_ERROR_ARGUMENT,
            &["number = 0", "0 recorded"],
        );
        run.step(&bodies, false, true);
        let count = ellgran_recorded_count(w);
        assert!(count > 40);
        let wrong = count.to_string();
        fails(
            ellgran_recorded_contact(w, count, p, g, f),
            ELLGRAN_ERROR_ARGUMENT,
            &[&wrong, "number"],
        );
        place.check();
        // Nothing asked for is nothing written.
        ok(ellgran_recorded_contact(w, 0, null_mut(), g, f));
        for (i, j) in [(-1, 0), (0, i32::MAX), (0, 0)] {
            ok(ellgran_recorded_find(w, i, j, &mut number));
            assert_eq!(number, -1);
        }
        let missing = ELLGRAN_ERROR_NULL_POINTER;
        fails(
            ellgran_recorded_contact(null(), 0, p, g, f),
            missing,
            &["workspace"],
        );
        fails(
            ellgran_recorded_find(null(), 0, 1, &mut number),
            missing,
            &["workspace"],
        );
        fails(
            ellgran_recorded_find(w, 0, 1, null_mut()),
            missing,
            &["number"],
        );
        // A call that fails leaves none: they would be those of another step.
        let mut broken = bodies.clone();
        broken[3].quaternion = [0.0; 4];
        let mut arrays = Arrays::new(&broken, OWNED);
        let (particles, mut view) = (arrays.particles(), run.list.view(true));
        view.record_contacts = 1;
        let status = ellgran_compute_pairs(run.laws.0, w, &particles, &view, &STEP, null_mut());
        fails(status, ELLGRAN_ERROR_PARTICLE, &["1003"]);
        assert_eq!(ellgran_recorded_count(w), 0);
        // Nor does one without laws.
        run.step(&bodies, false, true);
        assert_eq!(ellgran_recorded_count(w), count);
        let status = ellgran_compute_pairs(null(), w, &particles, &view, &STEP, null_mut());
        fails(status, missing, &["laws"]);
        assert_eq!(ellgran_recorded_count(w), 0);
    }
}

/// Of each particle: how many it touches, fabric and stress from the records; ghosts only with `newton`.
#[test]
fn grain_sums_are_those_of_the_records() {
    let bodies = random_bodies(11);
    let mut run = Run::new(&DECKS[0], &bodies);
    let mut arrays = run.step(&bodies, false, true);
    let particles = arrays.particles();
    for newton in [0, 1] {
        let mut expected = vec![[0.0; ELLGRAN_GRAIN_SUMS_LENGTH]; bodies.len()];
        for (place, g, f) in recorded(run.workspace.0) {
            for (k, sign) in [(place.i as usize, -1.0), (place.j as usize, 1.0)] {
                if newton == 0 && k >= OWNED {
                    continue;
                }
                let row = &mut expected[k];
                row[0] += 1.0;
                for (at, [a, b]) in [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]]
                    .into_iter()
                    .enumerate()
                {
                    let arm = |c: usize| g.contact_point[c] - bodies[k].position[c];
                    row[2 + at] += g.normal[a] * g.normal[b];
                    row[8 + at] += 0.5 * sign * (arm(a) * f.force[b] + arm(b) * f.force[a]);
                }
            }
        }
        assert!(newton == 0 || expected[OWNED..].iter().any(|row| row[0] > 0.0));
        let mut found = vec![[0.0; ELLGRAN_GRAIN_SUMS_LENGTH]; bodies.len()];
        let sums = found.as_mut_ptr().cast();
        let workspace = run.workspace.0;
        ok(unsafe { ellgran_add_recorded_to_grain_sums(workspace, &particles, newton, sums) });
        let size = expected
            .iter()
            .flatten()
            .fold(0.0, |m: f64, x| m.max(x.abs()));
        for (a, b) in expected.iter().flatten().zip(found.iter().flatten()) {
            assert!((a - b).abs() <= 1e-13 * size, "{a}, {b}");
        }
        for (handle, p, s, name) in [
            (null(), &particles as *const _, sums, "workspace"),
            (workspace.cast_const(), null(), sums, "particles"),
            (workspace.cast_const(), &particles, null_mut(), "sums"),
        ] {
            let status = unsafe { ellgran_add_recorded_to_grain_sums(handle, p, newton, s) };
            let said = format!("{name} must not be NULL");
            fails(status, ELLGRAN_ERROR_NULL_POINTER, &[&said]);
        }
        let mut fewer = particles;
        (fewer.count, fewer.owned_count) = (3, 3);
        let status = unsafe { ellgran_add_recorded_to_grain_sums(workspace, &fewer, newton, sums) };
        fails(status, ELLGRAN_ERROR_ARGUMENT, &["count = 3"]);
    }
    let status = unsafe { ellgran_add_wall_recorded_to_grain_sums(null(), 0, null_mut()) };
    fails(
        status,
        ELLGRAN_ERROR_NULL_POINTER,
        &["wall must not be NULL"],
    );
}
