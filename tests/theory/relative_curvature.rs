// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is the eigenvalue form of the relative curvature the paper's Eq. (5) with four radii and the angle alpha?

use crate::support::random::Stream;
use crate::support::scene::{plain, quaternion, vector};
use ellgran::geometry::{radii_of_curvature, relative_curvature, Ellipsoid};
use ellgran::vector::Tangent;

#[test]
fn equation_5_with_four_radii_and_the_angle_between_the_principal_planes() {
    let mut stream = Stream::new(2);
    let mut worst = 0.0f64;
    for _ in 0..5000 {
        let n = plain(stream.direction());
        let tangent = Tangent::new(n);
        let bodies = [0, 1]
            .map(|_| Ellipsoid::new(stream.semi_axes(8.0), quaternion(stream.rotation())).unwrap());
        let supports = bodies.map(|b| b.support(n));
        // Principal radii R' > R'' of each body and the direction of R', from the inverse Weingarten map.
        let radii = [0, 1].map(|k| {
            let w = radii_of_curvature(&bodies[k], &supports[k], &tangent);
            let (small, large, direction) = w.eigen();
            (large, small, direction)
        });
        let inverse = |k: usize| [1.0 / radii[k].0, 1.0 / radii[k].1];
        let ([c1, c2], [d1, d2]) = (inverse(0), inverse(1));
        let cosine = radii[0].2.dot(radii[1].2);
        let cos_2_alpha = 2.0 * cosine * cosine - 1.0;
        // Johnson (4.5), (4.6): A + B and B - A.
        let sum = 0.5 * (c1 + c2 + d1 + d2);
        let difference = 0.5
            * ((c1 - c2).powi(2) + (d1 - d2).powi(2) + 2.0 * (c1 - c2) * (d1 - d2) * cos_2_alpha)
                .max(0.0)
                .sqrt();
        let (a, b) = (0.5 * (sum - difference), 0.5 * (sum + difference));

        let v = [0, 1].map(|k| bodies[k].weingarten(&supports[k], &tangent));
        let m = (v[0] + v[1]) * 0.5;
        let got = relative_curvature(m, &tangent);
        let error = ((got.a - a).abs()).max((got.b - b).abs()) / b;
        worst = worst.max(error);
        assert!(error < 1e-12, "A {} {a}, B {} {b}", got.a, got.b);
        let effective_radius = 0.5 / (a * b).sqrt();
        assert!((0.5 / m.determinant().sqrt() / effective_radius - 1.0).abs() < 1e-9);

        // The direction of A is tangent, a unit vector, and an eigenvector of M.
        let direction = vector(got.major_direction);
        assert!((direction.norm() - 1.0).abs() < 1e-14 && direction.dot(&vector(n)).abs() < 1e-14);
        let in_plane = tangent.components(got.major_direction);
        let residual = m.apply(in_plane) - in_plane * got.a;
        assert!(residual.dot(residual).sqrt() < 1e-13 * got.b);
    }
    println!("largest error of A and B relative to B: {worst:.1e}");
}

#[test]
fn crossed_cylinder_like_contacts_are_circular() {
    // Two equal needles crossed at a right angle touch in a circle: A = B, whatever their radii of curvature.
    let n = ellgran::vector::Vector3::new(0.0, 0.0, 1.0);
    let quarter = std::f64::consts::FRAC_1_SQRT_2;
    let i = Ellipsoid::new([10.0, 1.0, 1.0], [1.0, 0.0, 0.0, 0.0]).unwrap();
    let j = Ellipsoid::new([10.0, 1.0, 1.0], [quarter, 0.0, 0.0, quarter]).unwrap();
    let tangent = Tangent::new(n);
    let m = (i.weingarten(&i.support(n), &tangent) + j.weingarten(&j.support(n), &tangent)) * 0.5;
    let got = relative_curvature(m, &tangent);
    assert!((got.b / got.a - 1.0).abs() < 1e-14, "{} {}", got.a, got.b);
    assert!((got.b - 0.5 * (1.0 + 0.01)).abs() < 1e-14);
}
