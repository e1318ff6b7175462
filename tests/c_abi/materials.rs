// SPDX-License-Identifier: MIT OR Apache-2.0
//! What follows from a material and a shape alone: moduli of a pair, volumes, moments of inertia, a law's words.

use std::f64::consts::PI;
use std::ptr::{null, null_mut};

use ellgran::c_api::contact::EllgranBody;
use ellgran::c_api::law::*;
use ellgran::c_api::solid::*;
use ellgran::c_api::staged::*;
use ellgran::c_api::status::*;

use crate::scene::*;

#[track_caller]
fn is_null(status: i32, name: &str) {
    let text = format!("{name} must not be NULL");
    fails(status, ELLGRAN_ERROR_NULL_POINTER, &[&text]);
}

fn close(got: f64, wanted: f64) {
    assert!((got / wanted - 1.0).abs() < 1e-13, "{got} {wanted}");
}

fn mixture(laws: &Laws, i: i32, j: i32) -> EllgranMixture {
    let mut out = Untouched::<EllgranMixture>::sized();
    // SAFETY: the laws live; the output is written on success.
    unsafe {
        ok(ellgran_laws_mixture(laws.0, i, j, out.pointer()));
        *out.pointer()
    }
}

#[test]
fn moduli_and_shares_of_two_materials() {
    let laws = Laws::new(&[
        "nfd 3e6 0.3 200 200 tangential tfd 0.5",
        "nfd 1e7 0.2 100 50 tangential tfd 0.5",
    ]);
    let (ci, cj) = ((1.0 - 0.09) / 3e6, (1.0 - 0.04) / 1e7);
    let (gi, gj) = (3e6 / 2.6, 1e7 / 2.4);
    let m = mixture(&laws, 1, 2);
    close(m.effective_modulus, 1.0 / (ci + cj));
    close(m.effective_shear_modulus, 1.0 / (1.7 / gi + 1.8 / gj));
    close(m.share_i, ci / (ci + cj));
    close(mixture(&laws, 2, 1).share_i, cj / (ci + cj));
    assert!(m.normal_relaxation_time > 0.0 && m.tangential_relaxation_time > 0.0);
    // One relaxation time for all deformation.
    let one = Laws::new(&["hertz 3e6 0.3 damping relaxation 1e-4 tangential tfd 0.5"]);
    let m = mixture(&one, 1, 1);
    close(m.normal_relaxation_time, 1e-4);
    close(m.tangential_relaxation_time, 1e-4);
    let linear = mixture(&Laws::new(&["lsd 7 3"]), 1, 1);
    let of_material = [linear.effective_modulus, linear.normal_relaxation_time];
    assert_eq!((of_material, linear.share_i), ([0.0; 2], 0.5));
    let mut out = Untouched::<EllgranMixture>::sized();
    // SAFETY: pointers are NULL or valid.
    unsafe {
        is_null(ellgran_laws_mixture(null(), 1, 1, out.pointer()), "laws");
        is_null(ellgran_laws_mixture(one.0, 1, 1, null_mut()), "mixture");
        let status = ellgran_laws_mixture(one.0, 1, 2, out.pointer());
        fails(status, ELLGRAN_ERROR_ARGUMENT, &["type_j = 2"]);
    }
    out.check();
}

#[test]
fn volumes_and_moments_of_inertia() {
    let axes = [[3.0, 2.0, 1.0], [0.5, 0.5, 0.5]];
    let masses = [10.0, f64::INFINITY];
    let (mut volumes, mut moments) = ([0.0; 2], [[0.0; 3]; 2]);
    let a = axes.as_ptr().cast();
    // SAFETY: the arrays have two entries.
    unsafe {
        ok(ellgran_volumes(2, a, volumes.as_mut_ptr()));
        let m = moments.as_mut_ptr().cast();
        ok(ellgran_moments_of_inertia(2, a, masses.as_ptr(), m));
        // None of them.
        ok(ellgran_volumes(0, null(), null_mut()));
    }
    close(volumes[0], 8.0 * PI);
    close(volumes[1], PI / 6.0);
    for (got, wanted) in moments[0].iter().zip([10.0, 20.0, 26.0]) {
        close(*got, wanted);
    }
    assert_eq!(moments[1], [f64::INFINITY; 3]);
    let wrong = [[1.0, 1.0, 1.0], [1.0, 0.0, 1.0]];
    let before = volumes;
    // SAFETY: as above, or NULL.
    unsafe {
        let w = wrong.as_ptr().cast();
        let status = ellgran_volumes(2, w, volumes.as_mut_ptr());
        let words = ["ellipsoid 1", "semi-axis = 0"];
        fails(status, ELLGRAN_ERROR_PARTICLE, &words);
        is_null(
            ellgran_volumes(2, null(), volumes.as_mut_ptr()),
            "semi_axes",
        );
        is_null(ellgran_volumes(2, a, null_mut()), "volumes");
        let m = moments.as_mut_ptr().cast();
        let n = masses.as_ptr();
        is_null(ellgran_moments_of_inertia(2, null(), n, m), "semi_axes");
        is_null(ellgran_moments_of_inertia(2, a, null(), m), "masses");
        is_null(ellgran_moments_of_inertia(2, a, n, null_mut()), "moments");
        for mass in [f64::NAN, -1.0, 0.0, 1e51] {
            let status = ellgran_moments_of_inertia(2, a, [1.0, mass].as_ptr(), m);
            let words = ["ellipsoid 1", "mass"];
            fails(status, ELLGRAN_ERROR_PARTICLE, &words);
        }
    }
    assert_eq!(moments[1], [f64::INFINITY; 3]);
    assert_eq!(volumes, before);
}

/// A turned ellipsoid: L = R I R^T omega, and the library's own inverse of that.
#[test]
fn angular_momenta_and_mean_angular_velocities() {
    let half = 0.5f64.sqrt();
    // 90 degrees about z: the body's x axis lies along y.
    let body = EllgranBody {
        quaternion: [half, 0.0, 0.0, half],
        semi_axes: [3.0, 2.0, 1.0],
        mass: 10.0,
        ..sphere_at(0.0)
    };
    let (omega, mut momentum) = ([1.0, 2.0, 3.0], [0.0; 3]);
    // SAFETY: pointers are NULL or valid, for three or four doubles.
    unsafe {
        let l = momentum.as_mut_ptr();
        ok(ellgran_angular_momentum(&body, omega.as_ptr(), l));
        // Moments 10, 20, 26 about the body axes; about the world's x axis that of y.
        for (got, wanted) in momentum.iter().zip([20.0, 20.0, 78.0]) {
            close(*got, wanted);
        }
        is_null(ellgran_angular_momentum(null(), omega.as_ptr(), l), "body");
        is_null(
            ellgran_angular_momentum(&body, null(), l),
            "angular_velocity",
        );
        is_null(
            ellgran_angular_momentum(&body, omega.as_ptr(), null_mut()),
            "angular_momentum",
        );
        let before = *l.cast::<[f64; 3]>();
        for wrong in [f64::NAN, f64::INFINITY, 1e26] {
            fails(
                ellgran_angular_momentum(&body, [0.0, wrong, 0.0].as_ptr(), l),
                ELLGRAN_ERROR_ARGUMENT,
                &["angular velocity"],
            );
        }
        let fixed = EllgranBody {
            mass: f64::INFINITY,
            ..body
        };
        fails(
            ellgran_angular_momentum(&fixed, [0.0; 3].as_ptr(), l),
            ELLGRAN_ERROR_PARTICLE,
            &["fixed body"],
        );
        assert_eq!(*l.cast::<[f64; 3]>(), before);

        let (from, to) = ([1.0, 0.0, 0.0, 0.0], [-half, 0.0, 0.0, -half]);
        let mut found = [0.0; 3];
        let (a, b, f) = (from.as_ptr(), to.as_ptr(), found.as_mut_ptr());
        ok(ellgran_mean_angular_velocity(a, b, 2.0, f));
        close(found[2], 0.25 * PI);
        assert_eq!([found[0].abs(), found[1].abs()], [0.0; 2]);
        is_null(ellgran_mean_angular_velocity(null(), b, 2.0, f), "from");
        is_null(ellgran_mean_angular_velocity(a, null(), 2.0, f), "to");
        is_null(
            ellgran_mean_angular_velocity(a, b, 2.0, null_mut()),
            "angular_velocity",
        );
        // Of any length but zero.
        let [small, large] = [1e-160, 1e160].map(|by| to.map(|c: f64| by * c));
        for scaled in [small, large] {
            ok(ellgran_mean_angular_velocity(a, scaled.as_ptr(), 2.0, f));
            close(*f.add(2), 0.25 * PI);
        }
        fails(
            ellgran_mean_angular_velocity(a, b, 1e-320, f),
            ELLGRAN_ERROR_RESULT,
            &["time = "],
        );
        let zero = [0.0; 4];
        for (to, time, word) in [(zero.as_ptr(), 1.0, "to = (0 0 0 0)"), (b, 0.0, "time = 0")] {
            fails(
                ellgran_mean_angular_velocity(a, to, time, f),
                ELLGRAN_ERROR_ARGUMENT,
                &[word],
            );
        }
    }
}

#[test]
fn stiffness_of_the_circular_contact() {
    let laws = Laws::new(&[
        "hertz 1e4 0.3 tangential tfd 0.4",
        "hertz 3e4 0.2 tangential tfd 0.4",
    ]);
    let mut staged = null_mut();
    let (mut j, mut cached) = (sphere_at(1.9), [0.0; 3]);
    j.particle_type = 2;
    let mut geometry = Untouched::<EllgranStagedGeometry>::sized();
    let (mut radius, mut normal, mut tangential) = (0.0, -1.0, -1.0);
    let m = mixture(&laws, 1, 2);
    // SAFETY: pointers are NULL or valid.
    unsafe {
        ok(ellgran_staged_new(&mut staged));
        let (n, t) = (&raw mut normal, &raw mut tangential);
        let status = ellgran_staged_circular_stiffness(staged, laws.0, 1, 2, n, t);
        fails(status, ELLGRAN_ERROR_ARGUMENT, &["do not touch"]);
        let i = sphere_at(0.0);
        let g = geometry.pointer();
        ok(ellgran_staged_pair(
            staged,
            &i,
            &j,
            0.5,
            cached.as_mut_ptr(),
            g,
        ));
        ok(ellgran_staged_circular_stiffness(
            staged, laws.0, 1, 2, n, t,
        ));
        ok(ellgran_staged_equivalent_radius(staged, &mut radius));
        let z = null_mut();
        is_null(
            ellgran_staged_circular_stiffness(null(), laws.0, 1, 2, n, t),
            "staged",
        );
        is_null(
            ellgran_staged_circular_stiffness(staged, null(), 1, 2, n, t),
            "laws",
        );
        is_null(
            ellgran_staged_circular_stiffness(staged, laws.0, 1, 2, z, t),
            "normal",
        );
        is_null(
            ellgran_staged_circular_stiffness(staged, laws.0, 1, 2, n, z),
            "tangential",
        );
        ellgran_staged_free(staged);
    }
    let root = (radius * 0.1f64).sqrt();
    close(normal, 4.0 / 3.0 * m.effective_modulus * root);
    close(tangential, 8.0 * m.effective_shear_modulus * root);
}

#[test]
fn without_words_the_message_has_all_that_can_be_given() {
    let mut out = Untouched::<EllgranLawParameters>::sized();
    let words = [
        "hertz E nu | nfd E nu eta1 eta2 | lsd kn cn",
        "damping none | restitution e | relaxation A_n",
        "tangential none | tfd mu | mindlin mu | linear kt ct mu",
        "conservative yes | no",
    ];
    fails(
        parse_status("", null_mut(), out.pointer()),
        ELLGRAN_ERROR_LAW,
        &words,
    );
    out.check();
}
