// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does the Weingarten map have the Gaussian and the mean curvature of the ellipsoid (section 6, last formula)?

use crate::support::random::Stream;
use crate::support::scene::{plain, quaternion, vector};
use ellgran::geometry::{radii_of_curvature, Ellipsoid};
use ellgran::vector::Tangent;

/// Both curvatures at a surface point given in body axes.
fn closed_form(a: [f64; 3], p: [f64; 3]) -> (f64, f64) {
    let s: f64 = (0..3).map(|k| p[k] * p[k] / a[k].powi(4)).sum();
    let product: f64 = a.iter().map(|x| x * x).product();
    let gaussian = 1.0 / (product * s * s);
    let squares: f64 = (0..3).map(|k| a[k] * a[k] - p[k] * p[k]).sum();
    (gaussian, squares / (2.0 * product * s.powf(1.5)))
}

#[test]
fn weingarten_map_has_the_closed_forms_curvatures() {
    let mut stream = Stream::new(1);
    let mut worst = [0.0f64; 2];
    for aspect in [2.0, 10.0, 100.0] {
        for _ in 0..2000 {
            let a = stream.semi_axes(aspect);
            let turn = stream.rotation();
            let body = Ellipsoid::new(a, quaternion(turn)).unwrap();
            let n = plain(stream.direction());
            let support = body.support(n);
            let p = turn.inverse_transform_vector(&vector(support.point));
            let (gaussian, mean) = closed_form(a, [p.x, p.y, p.z]);
            let tangent = Tangent::new(n);
            let v = body.weingarten(&support, &tangent);
            let (k1, k2, _) = v.eigen();
            // The closed form divides by s, which a rounded point of a disc's rim holds to eps (a/b)^2.
            let tolerance = 1e-14 * aspect * aspect;
            let errors = [k1 * k2 / gaussian - 1.0, 0.5 * (k1 + k2) / mean - 1.0];
            for (w, e) in worst.iter_mut().zip(errors) {
                *w = w.max(e.abs());
                assert!(e.abs() < 4.0 * tolerance, "{a:?}: {errors:?}");
            }
            let w = radii_of_curvature(&body, &support, &tangent);
            let product = [
                v.uu * w.uu + v.uv * w.uv - 1.0,
                v.uu * w.uv + v.uv * w.vv,
                v.uv * w.uv + v.vv * w.vv - 1.0,
            ];
            assert!(
                product.iter().all(|x| x.abs() < 1e-13 * aspect * aspect),
                "{product:?}"
            );
        }
    }
    println!(
        "largest relative errors of Gaussian and mean curvature: {:?}",
        worst.map(|w| format!("{w:.1e}"))
    );
}

#[test]
fn at_the_tips_the_radii_are_squares_of_semi_axes_over_the_third() {
    let a = [3.0, 2.0, 0.5];
    let body = Ellipsoid::new(a, [1.0, 0.0, 0.0, 0.0]).unwrap();
    for tip in 0..3 {
        let mut n = [0.0; 3];
        n[tip] = 1.0;
        let n = ellgran::vector::Vector3::from_array(n);
        let w = radii_of_curvature(&body, &body.support(n), &Tangent::new(n));
        let (small, large, _) = w.eigen();
        let mut wanted = [
            a[(tip + 1) % 3].powi(2) / a[tip],
            a[(tip + 2) % 3].powi(2) / a[tip],
        ];
        wanted.sort_by(f64::total_cmp);
        assert!((small / wanted[0] - 1.0).abs() < 1e-14 && (large / wanted[1] - 1.0).abs() < 1e-14);
    }
}
