// SPDX-License-Identifier: MIT OR Apache-2.0
//! Are the exact Hertz factors those of the theory's table and of the high-precision reference?

use crate::support::elliptic::complete;
use crate::support::golden::factors;
use ellgran::force::elliptic_integrals::ellipse_integrals;
use ellgran::force::hertz_factors::{contact_ellipse, exact};

fn close(name: &str, got: f64, wanted: f64, relative: f64) {
    assert!(
        (got - wanted).abs() <= relative * wanted.abs(),
        "{name}: {got:.17e}, expected {wanted:.17e}, off by {:.1e}",
        got / wanted - 1.0
    );
}

/// `B/A`, `b/a`, `F1`, `F2`, `F2^(-3/2)`: section 2.
const TABLE: [[f64; 5]; 9] = [
    [1.0, 1.0, 1.0, 1.0, 1.0],
    [
        1.5,
        0.7632987856063925,
        0.9977295650013222,
        0.9977244179685665,
        1.003423108152866,
    ],
    [
        2.0,
        0.6305957014280997,
        0.9934356943739903,
        0.9933927956074030,
        1.009993295678464,
    ],
    [
        10.0,
        0.2222495192462214,
        0.9370983326076421,
        0.9333297892052033,
        1.109040251656140,
    ],
    [
        100.0,
        0.0549840180571188,
        0.8146742208202625,
        0.7859964734012586,
        1.435056842599645,
    ],
    [
        1e3,
        0.0147335131549467,
        0.6921302119816318,
        0.6256870231392840,
        2.020525232921036,
    ],
    [
        1e4,
        0.0041248573583856,
        0.5830806036759311,
        0.4822339122269940,
        2.986162091172529,
    ],
    [
        1e6,
        0.0003459500384477,
        0.4090732435245900,
        0.2708028588316798,
        7.096106628944819,
    ],
    [
        1e8,
        0.0000304491289708,
        0.2846913203262498,
        0.1454288155209082,
        18.03118626022830,
    ],
];

#[test]
fn table_of_section_2_by_iteration() {
    for [ratio, axis_ratio, f1, f2, phi] in TABLE {
        let e = contact_ellipse(ratio);
        // The last column of b/a at 1e8 has twelve significant digits.
        close("b/a", e.axis_ratio, axis_ratio, 2e-12);
        close("F1", e.f1, f1, 1e-12);
        close("F2", e.f2, f2, 1e-12);
        close("F2^(-3/2)", e.f2.powf(-1.5), phi, 1e-12);
    }
}

#[test]
fn table_of_section_2_as_the_force_uses_it() {
    for [ratio, .., phi] in TABLE {
        close("phi", exact(1.0 + ratio, ratio, false).phi, phi, 1e-12);
        // Any unit of length.
        close(
            "phi",
            exact(1e-6 * (1.0 + ratio), 1e-12 * ratio, false).phi,
            phi,
            1e-12,
        );
    }
}

#[test]
fn high_precision_reference_from_1_to_1e8_within_1e_12() {
    let mut worst = [0.0f64; 5];
    for row in factors() {
        let e = contact_ellipse(row.ratio);
        // Trace and determinant in doubles hold the ratio only to rounding: near a circle that does not matter, the
        // factors being flat there.
        let f = exact(1.0 + row.ratio, row.ratio, true);
        let anisotropy = (row.ratio - 1.0) / (row.ratio + 1.0);
        let errors = [
            e.axis_ratio / row.axis_ratio - 1.0,
            e.f1 / row.f1 - 1.0,
            e.f2 / row.f2 - 1.0,
            f.phi / row.phi - 1.0,
            // Bl/K, which is what the compliance is made of.
            (0.5 - f.sigma * anisotropy) / row.beta_major - 1.0,
        ];
        for (w, e) in worst.iter_mut().zip(errors) {
            *w = w.max(e.abs());
        }
        for (name, error) in ["b/a", "F1", "F2", "phi", "Bl/K"].iter().zip(errors) {
            // Bl/K falls to 1e-2 at 1e8: 1e-12 of K there.
            let most = if *name == "Bl/K" {
                1e-12 / row.beta_major
            } else {
                1e-12
            };
            assert!(
                error.abs() <= most,
                "{name} at B/A = {}: {error:e}",
                row.ratio
            );
        }
    }
    println!(
        "largest relative errors of b/a, F1, F2, phi, Bl/K: {:?}",
        worst.map(|w| format!("{w:.1e}"))
    );
}

#[test]
fn a_ratio_below_one_by_rounding_is_a_circle() {
    let f = exact(2.0, 1.0 + f64::EPSILON, true);
    close("phi", f.phi, 1.0, 1e-14);
    close("sigma", f.sigma, 1.0 / 6.0, 1e-11);
}

#[test]
fn near_a_circle_f1_and_f2_fall_as_the_square_of_the_logarithm_over_72() {
    for l in [0.003, 0.01, 0.03] {
        let e = contact_ellipse(f64::exp(l));
        let wanted = l * l / 72.0;
        // The next term is of the fourth power.
        assert!(
            ((1.0 - e.f1) / wanted - 1.0).abs() < 0.1 * l * l + 1e-9 / l,
            "F1 at {l}"
        );
        assert!(
            ((1.0 - e.f2) / wanted - 1.0).abs() < 0.1 * l * l + 1e-9 / l,
            "F2 at {l}"
        );
    }
}

/// Carlson's forms against the arithmetic-geometric mean: nearly no digit is lost, at any stage of the duplication.
#[test]
fn the_complete_integrals_to_rounding() {
    for step in 0..400 {
        let axis_ratio = 10f64.powf(-0.02 * f64::from(step));
        let got = ellipse_integrals(axis_ratio);
        let (k, e) = complete(axis_ratio);
        close("K", got.k, k, 2e-15);
        // The differences of K and E lose digits at a circle.
        if axis_ratio < 0.5 {
            let m = 1.0 - axis_ratio * axis_ratio;
            close("D", got.d, (k - e) / m, 5e-15);
            close("Bl", got.bl, (e - axis_ratio * axis_ratio * k) / m, 5e-15);
        }
    }
}
