// SPDX-License-Identifier: MIT OR Apache-2.0
//! Hale's closed form on request: as far off as the theory says, and refused where it breaks.

use ellgran::force::hertz_factors::{contact_ellipse, exact, hale, hale_f1};

fn error_in_force(ratio: f64) -> f64 {
    hale(1.0 + ratio, ratio, false)
        .expect("within Hale's range")
        .phi
        / exact(1.0 + ratio, ratio, false).phi
        - 1.0
}

#[test]
fn hales_error_in_force_is_that_of_section_2() {
    // The digits of the table: +0.3 %, +0.5 %, +0.003 %, +0.9 %, +25 %, +334 %.
    for (ratio, wanted, half_digit) in [
        (1.5, 0.003, 0.0005),
        (2.0, 0.005, 0.0005),
        (10.0, 0.00003, 0.000005),
        (100.0, 0.009, 0.0005),
        (1e3, 0.25, 0.005),
        (1e4, 3.34, 0.005),
    ] {
        let error = error_in_force(ratio);
        println!("B/A = {ratio}: {:.4} %", 100.0 * error);
        assert!(
            (error - wanted).abs() <= half_digit,
            "B/A = {ratio}: {error}"
        );
    }
    assert!(error_in_force(1.0).abs() < 1e-12);
}

#[test]
fn hales_f1_and_f2_are_the_printed_powers() {
    for ratio in [1.5, 2.0, 10.0, 1e3, 2e4] {
        let f1: f64 = 1.0 - (f64::powf(ratio, 0.0602) - 1.0).powf(1.456);
        let f2: f64 = 1.0 - (f64::powf(ratio, 0.0684) - 1.0).powf(1.531);
        assert!((hale_f1(ratio) - f1).abs() < 1e-14);
        let phi = hale(1.0 + ratio, ratio, false).unwrap().phi;
        assert!(
            (phi / f2.powf(-1.5) - 1.0).abs() < 1e-11 / f2,
            "B/A = {ratio}"
        );
    }
}

#[test]
fn hales_form_is_refused_beyond_25178_12() {
    assert!(hale(1.0 + 25178.12, 25178.12, false).is_some());
    assert!(hale(1.0 + 25178.13, 25178.13, false).is_none());
    for ratio in [3e4, 1e6, 1e8] {
        assert!(hale(1.0 + ratio, ratio, false).is_none());
    }
}

#[test]
fn hales_f1_passes_through_zero_at_100114_8() {
    assert!(hale_f1(100114.7) > 0.0 && hale_f1(100114.9) < 0.0);
}

#[test]
fn a_ratio_below_one_by_rounding_is_a_circle_and_no_nan() {
    let f = hale(2.0, 1.0 + f64::EPSILON, true).unwrap();
    assert_eq!(f.phi, 1.0);
    assert_eq!(hale_f1(1.0 - f64::EPSILON), 1.0);
}

#[test]
fn hales_ellipse_is_not_the_exact_one() {
    // e^2 ~ 1 - (A/B)^(4/3), Eq. (3): at B/A = 10 the axis ratio is 3 % off.
    let axis_ratio = 10f64.powf(-2.0 / 3.0);
    let off = axis_ratio / contact_ellipse(10.0).axis_ratio - 1.0;
    assert!((off + 0.0308).abs() < 1e-3, "{off}");
}
