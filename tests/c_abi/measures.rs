// SPDX-License-Identifier: MIT OR Apache-2.0
//! Gaps and energies in batches, stiffness of a contact, time of a collision: they are what the contact itself says.

use std::ptr::{null, null_mut};

use ellgran::c_api::contact::EllgranBody;
use ellgran::c_api::status::*;
use ellgran::c_api::stiffness::*;
use ellgran::c_api::without_history::*;

use crate::scene::*;

const DECKS: [&str; 2] = [
    "nfd 1e4 0.3 40 60 tangential tfd 0.4",
    "nfd 3e4 0.2 90 30 tangential tfd 0.2",
];

fn all_pairs(count: i32) -> Vec<[i32; 2]> {
    (0..count)
        .flat_map(|i| (i + 1..count).map(move |j| [i, j]))
        .collect()
}

#[test]
fn gaps_and_energies_are_those_of_single_contacts() {
    let bodies = random_bodies(3);
    let laws = Laws::new(&DECKS);
    let workspace = WorkspaceHandle::new();
    let mut arrays = Arrays::new(&bodies, bodies.len());
    let particles = arrays.particles();
    let pairs = all_pairs(bodies.len() as i32);
    let (mut gaps, mut energies) = (vec![0.0; pairs.len()], vec![-1.0; pairs.len()]);
    let mut normals = vec![[0.0; 3]; pairs.len()];
    let p = pairs.as_ptr().cast();
    // SAFETY: the arrays have an entry, or three, for each pair.
    unsafe {
        let n = normals.as_mut_ptr().cast();
        let (w, count) = (workspace.0, pairs.len());
        ok(ellgran_pair_gaps(
            w,
            &particles,
            count,
            p,
            gaps.as_mut_ptr(),
            n,
        ));
        let with_normals = gaps.clone();
        ok(ellgran_pair_gaps(
            w,
            &particles,
            count,
            p,
            gaps.as_mut_ptr(),
            null_mut(),
        ));
        assert_eq!(gaps, with_normals);
        let e = energies.as_mut_ptr();
        ok(ellgran_pair_energies(laws.0, w, &particles, count, p, e));
        // No pairs at all.
        ok(ellgran_pair_gaps(
            w,
            &particles,
            0,
            null(),
            null_mut(),
            null_mut(),
        ));
    }
    let mut touching = 0;
    for (k, [i, j]) in pairs.iter().enumerate() {
        let (i, j) = (&bodies[*i as usize], &bodies[*j as usize]);
        let (mut touches, mut history) = (0, vec![0.0; laws.length()]);
        let (g, f) = laws.contact([i, j], &STEP, &mut touches, &mut history);
        touching += g.touching;
        assert!((gaps[k] + g.penetration).abs() < 1e-12);
        for (a, b) in normals[k].iter().zip(g.normal) {
            assert!((a - b).abs() < 1e-6, "{:?} {:?}", normals[k], g.normal);
        }
        let apart = (energies[k] - f.elastic_energy).abs();
        assert!(apart <= 1e-11 * f.elastic_energy, "{apart}");
    }
    assert!(touching > 30);
}

#[test]
fn wrong_pairs_are_named() {
    let bodies = random_bodies(3);
    let workspace = WorkspaceHandle::new();
    let laws = Laws::new(&DECKS);
    let mut arrays = Arrays::new(&bodies, bodies.len());
    let particles = arrays.particles();
    let mut out = Untouched::<[f64; 2]>::new();
    // SAFETY: the arrays have two entries; NULL is refused.
    unsafe {
        let (w, o) = (workspace.0, out.pointer().cast::<f64>());
        for (second, words) in [
            ([64, 3], ["pairs[1]", "particle 64"]),
            ([2, -1], ["pairs[1]", "particle -1"]),
            ([5, 5], ["pairs[1]", "5 twice"]),
        ] {
            let pairs = [[0, 1], second];
            let p = pairs.as_ptr().cast();
            fails(
                ellgran_pair_gaps(w, &particles, 2, p, o, null_mut()),
                ELLGRAN_ERROR_ARGUMENT,
                &words,
            );
            fails(
                ellgran_pair_energies(laws.0, w, &particles, 2, p, o),
                ELLGRAN_ERROR_ARGUMENT,
                &words,
            );
        }
        let missing = ELLGRAN_ERROR_NULL_POINTER;
        let (n, pair) = (null_mut(), [0, 1]);
        let p = pair.as_ptr();
        let gaps = [
            (
                ellgran_pair_gaps(null_mut(), &particles, 1, p, o, n),
                "workspace",
            ),
            (ellgran_pair_gaps(w, null(), 1, p, o, n), "particles"),
            (ellgran_pair_gaps(w, &particles, 1, null(), o, n), "pairs"),
            (ellgran_pair_gaps(w, &particles, 1, p, n, n), "gaps"),
        ];
        assert!(gaps.iter().all(|(status, _)| *status == missing));
        fails(
            ellgran_pair_energies(null(), w, &particles, 1, p, o),
            missing,
            &["laws"],
        );
        fails(
            ellgran_pair_energies(laws.0, w, &particles, 1, p, n),
            missing,
            &["energies"],
        );
    }
    out.check();
}

/// What single calls give for the grains flat side on flat side, however they lie when they are given.
#[test]
fn limits_of_two_grains() {
    let laws = Laws::new(&DECKS);
    let lying = |semi_axes: [f64; 3], particle_type: i32| EllgranBody {
        semi_axes,
        particle_type,
        ..sphere_at(0.0)
    };
    let (i, mut j) = (lying([2.0, 1.5, 1.0], 1), lying([1.2, 1.0, 0.8], 2));
    let (mut time, mut deepest) = (0.0, 0.0);
    let mut out = Untouched::<EllgranContactStiffness>::sized();
    let turned = EllgranBody {
        position: [7.0, 8.0, 9.0],
        quaternion: [0.3, 0.4, -0.5, 0.6],
        semi_axes: [1.0, 2.0, 1.5],
        ..i
    };
    let other = EllgranBody {
        semi_axes: [0.8, 1.2, 1.0],
        ..j
    };
    let limits = |speed: f64| {
        let (mut collision, mut critical) = (0.0, 0.0);
        // SAFETY: all pointers are valid.
        ok(unsafe {
            ellgran_two_grain_limits(
                laws.0,
                &turned,
                &other,
                speed,
                &mut collision,
                &mut critical,
            )
        });
        [collision, critical]
    };
    // SAFETY: all pointers are valid; the struct is written on success.
    unsafe {
        for (speed, least) in [(1e-3, 0.008), (0.5, 0.0)] {
            j.position = [0.0, 0.0, 1.79];
            let d = &mut deepest;
            ok(ellgran_collision(laws.0, &i, &j, speed, &mut time, d));
            assert!(deepest < 0.45 && (deepest > 0.008) == (least == 0.0));
            j.position[2] = 1.8 - deepest.max(0.008);
            ok(ellgran_contact_stiffness(laws.0, &i, &j, out.pointer()));
            let critical = (*out.pointer()).critical_step;
            for (got, wanted) in limits(speed).into_iter().zip([time, critical]) {
                assert!((got / wanted - 1.0).abs() < 1e-9, "{speed}: {got} {wanted}");
            }
        }
        // No law holds deeper than a quarter of the distance.
        j.position[2] = 0.75 * 1.8;
        ok(ellgran_contact_stiffness(laws.0, &i, &j, out.pointer()));
        let critical = (*out.pointer()).critical_step;
        assert!((limits(1e6)[1] / critical - 1.0).abs() < 1e-9);
        // At rest the least overlap serves.
        j.position[2] = 1.8 - 0.008;
        ok(ellgran_contact_stiffness(laws.0, &i, &j, out.pointer()));
        let critical = (*out.pointer()).critical_step;
        let [collision, found] = limits(0.0);
        assert_eq!(collision, f64::INFINITY);
        assert!((found / critical - 1.0).abs() < 1e-9);

        let (mut t, mut c) = (0.0, 0.0);
        for speed in [-1.0, f64::NAN, f64::INFINITY] {
            fails(
                ellgran_two_grain_limits(laws.0, &i, &j, speed, &mut t, &mut c),
                ELLGRAN_ERROR_ARGUMENT,
                &["speed", &speed.to_string()],
            );
        }
        for (status, word) in [
            (
                ellgran_two_grain_limits(null(), &i, &j, 1.0, &mut t, &mut c),
                "laws",
            ),
            (
                ellgran_two_grain_limits(laws.0, null(), &j, 1.0, &mut t, &mut c),
                "i",
            ),
            (
                ellgran_two_grain_limits(laws.0, &i, null(), 1.0, &mut t, &mut c),
                "j",
            ),
            (
                ellgran_two_grain_limits(laws.0, &i, &j, 1.0, null_mut(), &mut c),
                "collision_time",
            ),
            (
                ellgran_two_grain_limits(laws.0, &i, &j, 1.0, &mut t, null_mut()),
                "critical_step",
            ),
        ] {
            assert_eq!(status, ELLGRAN_ERROR_NULL_POINTER, "{word}");
        }
    }
}

#[test]
fn stiffness_and_time_of_a_collision() {
    let laws = Laws::new(&DECKS);
    let (i, mut j) = (sphere_at(0.0), sphere_at(1.99));
    let mut out = Untouched::<EllgranContactStiffness>::sized();
    let (mut time, mut deepest) = (0.0, 0.0);
    // SAFETY: all pointers are valid; the struct is written on success.
    unsafe {
        ok(ellgran_contact_stiffness(laws.0, &i, &j, out.pointer()));
        let s = *out.pointer();
        // Two equal spheres of E 1e4, nu 0.3: 2 E* sqrt(R/2 delta), E* = E/(2 (1 - nu^2)).
        let expected = 1e4 / (1.0 - 0.09) * f64::sqrt(0.5 * 0.01);
        assert!((s.normal_stiffness / expected - 1.0).abs() < 1e-12);
        // Mindlin: k_t/k_n = 2 (1 - nu)/(2 - nu), whatever the direction.
        for k in s.tangential_stiffness {
            assert!((k / s.normal_stiffness - 1.4 / 1.7).abs() < 1e-6, "{k}");
        }
        assert!(s.normal_damping > 0.0 && s.tangential_damping[0] > 0.0);
        assert!(s.critical_step > 0.0 && s.critical_step < 2.0 / (2.0 * expected).sqrt());
        ok(ellgran_collision(
            laws.0,
            &i,
            &j,
            0.5,
            &mut time,
            &mut deepest,
        ));
        // 2.87 (m^2/(R E*^2 v))^(1/5) with the effective radius, mass and modulus.
        let modulus: f64 = 1e4 / (2.0 * 0.91);
        let hertz = 2.8683 * (0.25 / (0.5 * modulus * modulus * 0.5)).powf(0.2);
        assert!((time / hertz - 1.0).abs() < 1e-3, "{time} {hertz}");
        assert!((time * 0.5 / deepest - 2.943_275_184_324_7).abs() < 1e-6);

        j.position[0] = 3.0;
        ok(ellgran_contact_stiffness(laws.0, &i, &j, out.pointer()));
        let apart = *out.pointer();
        assert_eq!(apart.normal_stiffness, 0.0);
        assert_eq!(apart.critical_step, f64::INFINITY);
        // The grains may be apart: they will meet as they are.
        let mut later = 0.0;
        ok(ellgran_collision(
            laws.0,
            &i,
            &j,
            0.5,
            &mut later,
            null_mut(),
        ));
        assert!((later / time - 1.0).abs() < 1e-9);

        for speed in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            fails(
                ellgran_collision(laws.0, &i, &j, speed, &mut time, null_mut()),
                ELLGRAN_ERROR_ARGUMENT,
                &["speed", &speed.to_string()],
            );
        }
        let missing = ELLGRAN_ERROR_NULL_POINTER;
        let o = out.pointer();
        for (status, word) in [
            (ellgran_contact_stiffness(null(), &i, &j, o), "laws"),
            (ellgran_contact_stiffness(laws.0, null(), &j, o), "i"),
            (ellgran_contact_stiffness(laws.0, &i, null(), o), "j"),
            (
                ellgran_contact_stiffness(laws.0, &i, &j, null_mut()),
                "stiffness",
            ),
            (
                ellgran_collision(laws.0, &i, &j, 1.0, null_mut(), null_mut()),
                "time",
            ),
            (ellgran_rayleigh_time(null(), &i, &mut time), "parameters"),
            (
                ellgran_rayleigh_time(&parse(DECKS[0]), null(), &mut time),
                "grain",
            ),
            (
                ellgran_rayleigh_time(&parse(DECKS[0]), &i, null_mut()),
                "time",
            ),
        ] {
            assert_eq!(status, missing, "{word}");
        }
    }
}

#[test]
fn the_time_of_a_wave_through_a_grain() {
    // Sand: 65 GPa, nu 0.25, 2650 kg/m^3, 1 mm across its thin axis.
    let mut grain = sphere_at(0.0);
    grain.semi_axes = [2e-3, 1e-3, 5e-4];
    grain.mass = 2650.0 * 4.0 / 3.0 * std::f64::consts::PI * 1e-9;
    let mut time = 0.0;
    // SAFETY: all pointers are valid.
    ok(unsafe { ellgran_rayleigh_time(&parse("hertz 65e9 0.25"), &grain, &mut time) });
    // Wave of shear sqrt(G/rho) = 3132.1 m/s, Rayleigh's 0.917375 of it.
    let speed = (65e9f64 / 2.5 / 2650.0).sqrt() * (0.1631 * 0.25 + 0.8766);
    assert!(
        (time * speed / (std::f64::consts::PI * 5e-4) - 1.0).abs() < 1e-12,
        "{time:e}"
    );
    // SAFETY: as above.
    ok(unsafe { ellgran_rayleigh_time(&parse("lsd 60 0"), &grain, &mut time) });
    assert_eq!(time, f64::INFINITY);
}
