// SPDX-License-Identifier: MIT OR Apache-2.0
//! Many pairs in one call: what the calls for one contact give, to the last bit.

use std::ptr::{null, null_mut};

use ellgran::c_api::contact::*;
use ellgran::c_api::many_contacts::*;
use ellgran::c_api::status::*;
use ellgran::c_api::stiffness::*;

use crate::scene::*;

const DECKS: [&str; 2] = [
    "nfd 1e4 0.3 40 60 tangential tfd 0.4",
    "nfd 3e4 0.2 90 30 tangential tfd 0.2",
];
/// Reads masses, remembers nothing but a normal.
const RESTITUTION: [&str; 2] = [
    "hertz 1e4 0.3 damping restitution 0.7",
    "hertz 3e4 0.2 damping restitution 0.9",
];
const LINEAR: [&str; 2] = [
    "lsd 1e4 3 tangential linear 5e3 2 0.4",
    "lsd 2e4 5 tangential linear 5e3 2 0.2",
];
const RESISTED: [&str; 2] = [
    "hertz 1e4 0.3 tangential mindlin 0.4 rolling sds 500 1 0.1 twisting marshall",
    "hertz 3e4 0.2 tangential mindlin 0.2 rolling sds 200 2 0.2 twisting marshall",
];

fn all_pairs(count: i32) -> Vec<[i32; 2]> {
    (0..count)
        .flat_map(|i| (i + 1..count).map(move |j| [i, j]))
        .collect()
}

/// Each field by its name, its array, and how many numbers a contact has in it.
macro_rules! columns {
    ($($name:ident $length:literal),* $(,)?) => {
        #[derive(Default)]
        struct Columns { $($name: Vec<[f64; $length]>),* }

        impl Columns {
            fn new(count: usize) -> Columns {
                Columns { $($name: vec![[-1.0; $length]; count]),* }
            }

            fn pointers(&mut self) -> EllgranContactArrays {
                EllgranContactArrays {
                    size: size_of::<EllgranContactArrays>(),
                    $($name: self.$name.as_mut_ptr().cast()),*
                }
            }

            #[track_caller]
            fn are(&self, k: usize, g: &EllgranContactGeometry, f: &EllgranContactForce) {
                let one = Columns::of(g, f);
                $(assert_eq!(
                    self.$name[k].map(f64::to_bits), one.$name[0].map(f64::to_bits), concat!(stringify!($name), " of {}"), k
                );)*
            }
        }

        const NO_ARRAYS: EllgranContactArrays = EllgranContactArrays {
            size: size_of::<EllgranContactArrays>(),
            $($name: null_mut()),*
        };
    };
}

columns! {
    penetration 1, normal 3, contact_point 3, witness_i 3, witness_j 3, curvatures 2, major_direction 3,
    contact_semi_axes 2, force 3, torque_i 3, torque_j 3, normal_force 1, tangential_force 3, displacement 3,
    penetration_rate 1, elastic_energy 1, tangential_energy 1, viscous_force 3, frictional_force 3, viscous_power 1,
    tangential_power 1, frictional_couple 3, viscous_couple 3,
}

impl Columns {
    fn of(g: &EllgranContactGeometry, f: &EllgranContactForce) -> Columns {
        Columns {
            penetration: vec![[g.penetration]],
            normal: vec![g.normal],
            contact_point: vec![g.contact_point],
            witness_i: vec![g.witness_i],
            witness_j: vec![g.witness_j],
            curvatures: vec![[g.curvature_a, g.curvature_b]],
            major_direction: vec![g.major_direction],
            contact_semi_axes: vec![f.contact_semi_axes],
            force: vec![f.force],
            torque_i: vec![f.torque_i],
            torque_j: vec![f.torque_j],
            normal_force: vec![[f.normal_force]],
            tangential_force: vec![f.tangential_force],
            displacement: vec![f.displacement],
            penetration_rate: vec![[f.penetration_rate]],
            elastic_energy: vec![[f.elastic_energy]],
            tangential_energy: vec![[f.tangential_energy]],
            viscous_force: vec![f.viscous_force],
            frictional_force: vec![f.frictional_force],
            viscous_power: vec![[f.viscous_power]],
            tangential_power: vec![[f.tangential_power]],
            frictional_couple: vec![f.frictional_couple],
            viscous_couple: vec![f.viscous_couple],
        }
    }
}

#[test]
fn contacts_are_those_of_single_calls_to_the_last_bit() {
    for decks in [DECKS, RESTITUTION, LINEAR, RESISTED] {
        let mut bodies = random_bodies(3);
        let laws = Laws::new(&decks);
        let workspace = WorkspaceHandle::new();
        let pairs = all_pairs(bodies.len() as i32);
        let (count, length) = (pairs.len(), laws.length());
        let mut touching = vec![0; count];
        let mut history = vec![0.0; count * length];
        let mut columns = Columns::new(count);
        let mut own: Vec<(i32, Vec<f64>)> = vec![(0, vec![0.0; length]); count];
        let mut contacts = 0;
        for _ in 0..3 {
            let mut arrays = Arrays::new(&bodies, bodies.len());
            let particles = arrays.particles();
            // SAFETY: the arrays have their entries for each pair.
            ok(unsafe {
                ellgran_pair_contacts(
                    laws.0,
                    workspace.0,
                    &particles,
                    &STEP,
                    count,
                    pairs.as_ptr().cast(),
                    touching.as_mut_ptr(),
                    history.as_mut_ptr(),
                    &columns.pointers(),
                )
            });
            for (k, [i, j]) in pairs.iter().enumerate() {
                let (touches, numbers) = &mut own[k];
                let pair = [*i, *j].map(|k| &bodies[k as usize]);
                let (g, f) = laws.contact(pair, &STEP, touches, numbers);
                columns.are(k, &g, &f);
                assert_eq!(touching[k], *touches);
                let kept = &history[k * length..(k + 1) * length];
                assert!(kept
                    .iter()
                    .zip(&*numbers)
                    .all(|(a, b)| a.to_bits() == b.to_bits()));
                contacts += g.touching;
            }
            advance(&mut bodies, STEP.time_step);
        }
        assert!(contacts > 90);
    }
}

#[test]
fn what_is_not_wanted_may_be_null() {
    let bodies = random_bodies(3);
    let laws = Laws::new(&["hertz 1e4 0.3", "hertz 1e4 0.3"]);
    let pairs = all_pairs(bodies.len() as i32);
    let workspace = WorkspaceHandle::new();
    let mut arrays = Arrays::new(&bodies, bodies.len());
    let particles = arrays.particles();
    let (mut touching, mut history) =
        (vec![0; pairs.len()], vec![0.0; pairs.len() * laws.length()]);
    let mut all = Columns::new(pairs.len());
    let mut forces = vec![[0.0; 3]; pairs.len()];
    // SAFETY: the arrays have their entries for each pair.
    unsafe {
        for wanted in [
            all.pointers(),
            EllgranContactArrays {
                force: forces.as_mut_ptr().cast(),
                ..NO_ARRAYS
            },
            NO_ARRAYS,
        ] {
            touching.fill(0);
            history.fill(0.0);
            ok(ellgran_pair_contacts(
                laws.0,
                workspace.0,
                &particles,
                &STEP,
                pairs.len(),
                pairs.as_ptr().cast(),
                touching.as_mut_ptr(),
                history.as_mut_ptr(),
                &wanted,
            ));
        }
        // No pairs at all.
        ok(ellgran_pair_contacts(
            laws.0,
            workspace.0,
            &particles,
            &STEP,
            0,
            null(),
            null_mut(),
            null_mut(),
            &NO_ARRAYS,
        ));
    }
    assert_eq!(forces, all.force);
}

#[test]
fn stiffnesses_and_collisions_are_those_of_single_calls() {
    let bodies = random_bodies(5);
    // The first reads no masses for its forces.
    for decks in [DECKS, RESTITUTION] {
        let laws = Laws::new(&decks);
        let workspace = WorkspaceHandle::new();
        let mut arrays = Arrays::new(&bodies, bodies.len());
        let particles = arrays.particles();
        let pairs = all_pairs(bodies.len() as i32);
        let count = pairs.len();
        let (mut normal, mut damping, mut step) =
            (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
        let (mut tangential, mut tangential_damping) =
            (vec![[0.0; 2]; count], vec![[0.0; 2]; count]);
        let speeds: Vec<f64> = (0..count).map(|k| 0.1 + k as f64).collect();
        let (mut times, mut depths) = (vec![0.0; count], vec![0.0; count]);
        let stiffness = EllgranStiffnessArrays {
            size: size_of::<EllgranStiffnessArrays>(),
            normal_stiffness: normal.as_mut_ptr(),
            tangential_stiffness: tangential.as_mut_ptr().cast(),
            normal_damping: damping.as_mut_ptr(),
            tangential_damping: tangential_damping.as_mut_ptr().cast(),
            critical_step: step.as_mut_ptr(),
        };
        let p = pairs.as_ptr().cast();
        // SAFETY: the arrays have their entries for each pair.
        unsafe {
            let w = workspace.0;
            ok(ellgran_pair_stiffnesses(
                laws.0, w, &particles, count, p, &stiffness,
            ));
            ok(ellgran_pair_collisions(
                laws.0,
                w,
                &particles,
                count,
                p,
                speeds.as_ptr(),
                times.as_mut_ptr(),
                depths.as_mut_ptr(),
            ));
        }
        for (k, [i, j]) in pairs.iter().enumerate() {
            let (i, j) = (&bodies[*i as usize], &bodies[*j as usize]);
            let mut out = Untouched::<EllgranContactStiffness>::sized();
            let (mut time, mut depth) = (0.0, 0.0);
            // SAFETY: all pointers are valid; the struct is written on success.
            let s = unsafe {
                ok(ellgran_contact_stiffness(laws.0, i, j, out.pointer()));
                ok(ellgran_collision(
                    laws.0, i, j, speeds[k], &mut time, &mut depth,
                ));
                *out.pointer()
            };
            assert_eq!(
                (normal[k], damping[k]),
                (s.normal_stiffness, s.normal_damping)
            );
            assert_eq!(tangential[k], s.tangential_stiffness);
            assert_eq!(tangential_damping[k], s.tangential_damping);
            assert_eq!(step[k], s.critical_step);
            assert_eq!((times[k], depths[k]), (time, depth));
        }
    }
}

#[test]
fn rayleigh_times_are_those_of_single_calls() {
    let mut bodies = random_bodies(5);
    bodies[20].mass = 1.0;
    let parameters = DECKS.map(parse);
    let mut arrays = Arrays::new(&bodies, bodies.len());
    let particles = arrays.particles();
    let mut times = vec![0.0; bodies.len()];
    // SAFETY: as many parameters as types, as many times as particles.
    unsafe {
        ok(ellgran_rayleigh_times(
            2,
            parameters.as_ptr(),
            &particles,
            times.as_mut_ptr(),
        ));
        for (body, time) in bodies.iter().zip(&times) {
            let mut one = 0.0;
            ok(ellgran_rayleigh_time(
                &parameters[body.particle_type as usize - 1],
                body,
                &mut one,
            ));
            assert_eq!(*time, one);
        }
        fails(
            ellgran_rayleigh_times(1, parameters.as_ptr(), &particles, times.as_mut_ptr()),
            ELLGRAN_ERROR_PARTICLE,
            &["particle 1001", "type 2"],
        );
    }
}

#[test]
fn what_is_wrong_is_named() {
    let bodies = random_bodies(3);
    let laws = Laws::new(&DECKS);
    let workspace = WorkspaceHandle::new();
    let mut arrays = Arrays::new(&bodies, bodies.len());
    let good = arrays.particles();
    let pairs = [[0, 1], [5, 64]];
    let length = laws.length();
    let (mut touching, mut history) = (vec![0; 2], vec![0.0; 2 * length]);
    let mut forces = Untouched::<[[f64; 3]; 2]>::new();
    let wanted = EllgranContactArrays {
        force: forces.pointer().cast(),
        ..NO_ARRAYS
    };
    let p = pairs.as_ptr().cast();
    // SAFETY: the arrays have their entries for each pair; NULL is refused.
    unsafe {
        let (l, w, t, h) = (
            laws.0,
            workspace.0,
            touching.as_mut_ptr(),
            history.as_mut_ptr(),
        );
        let missing = ELLGRAN_ERROR_NULL_POINTER;
        let call = |l, w, particles, step, p, t, h, a| {
            ellgran_pair_contacts(l, w, particles, step, 2, p, t, h, a)
        };
        fails(
            call(l, w, &good, &STEP, p, t, h, &wanted),
            ELLGRAN_ERROR_ARGUMENT,
            &["pairs[1]", "64"],
        );
        for (status, word) in [
            (call(null(), w, &good, &STEP, p, t, h, &wanted), "laws"),
            (
                call(l, null_mut(), &good, &STEP, p, t, h, &wanted),
                "workspace",
            ),
            (call(l, w, null(), &STEP, p, t, h, &wanted), "particles"),
            (call(l, w, &good, null(), p, t, h, &wanted), "step"),
            (call(l, w, &good, &STEP, null(), t, h, &wanted), "pairs"),
            (
                call(l, w, &good, &STEP, p, null_mut(), h, &wanted),
                "touching",
            ),
            (
                call(l, w, &good, &STEP, p, t, null_mut(), &wanted),
                "history",
            ),
            (call(l, w, &good, &STEP, p, t, h, null()), "arrays"),
        ] {
            assert_eq!(status, missing, "{word}");
        }
        forces.check();

        // The second contact has a history that no call has written: the first is computed.
        let pairs = [[0, 1], [21, 22]];
        let p = pairs.as_ptr().cast();
        *t.add(1) = 1;
        *h.add(2 * length - 1) = f64::NAN;
        fails(
            call(l, w, &good, &STEP, p, t, h, &wanted),
            ELLGRAN_ERROR_HISTORY,
            &["pairs[1]", "particle 1021", "particle 1022", "NaN"],
        );

        let speeds = [1.0, -2.0];
        let mut times = [0.0; 2];
        let (s, o) = (speeds.as_ptr(), times.as_mut_ptr());
        fails(
            ellgran_pair_collisions(l, w, &good, 2, p, s, o, null_mut()),
            ELLGRAN_ERROR_ARGUMENT,
            &["speeds[1] = -2"],
        );
    }
    arrays.masses[22] = -1.0;
    let wrong = arrays.particles();
    let pair = [21, 22];
    let none = EllgranStiffnessArrays {
        size: size_of::<EllgranStiffnessArrays>(),
        normal_stiffness: null_mut(),
        tangential_stiffness: null_mut(),
        normal_damping: null_mut(),
        tangential_damping: null_mut(),
        critical_step: null_mut(),
    };
    // SAFETY: all pointers are valid.
    fails(
        unsafe { ellgran_pair_stiffnesses(laws.0, workspace.0, &wrong, 1, pair.as_ptr(), &none) },
        ELLGRAN_ERROR_PARTICLE,
        &["particle 1022", "mass = -1"],
    );
}
