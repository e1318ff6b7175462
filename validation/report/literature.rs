// SPDX-License-Identifier: MIT OR Apache-2.0
//! Hertz' elliptical contact as the literature simplifies it. Each function gives `phi`, the force over that of a circular
//! contact of the same Gaussian curvature, for a ratio `B/A >= 1` of relative curvatures:
//!
//! ```text
//! F = 4/3 E* sqrt(Re) delta^(3/2) phi ,   Re = 1/(2 sqrt(A B))
//! ```

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

/// `phi` from the axis ratio `a/b >= 1` and the complete elliptic integrals of the modulus `sqrt(1 - (b/a)^2)`; exact where
/// they are (K.L. Johnson, Contact Mechanics, 4.2; B.J. Hamrock and D. Brewe write it as
/// `delta = K [ (9/(2 E R)) (F/(pi k E'))^2 ]^(1/3)`).
#[inline(always)]
fn from_integrals(ratio: f64, elongation: f64, k: f64, e: f64) -> f64 {
    let circular = (2.0 * e * ratio.sqrt() / (1.0 + ratio)).sqrt();
    FRAC_PI_2 * elongation * circular / (k * k.sqrt())
}

/// L.C. Hale, Principles and Techniques for Designing Precision Machines (1999), as Q.J. Zheng et al., Powder Technol. 248
/// (2013) 25, use it. No number beyond `B/A` = 25178.
#[inline(always)]
pub fn hale(ratio: f64) -> f64 {
    let f2 = 1.0 - (ratio.powf(0.0684) - 1.0).powf(1.531);
    f2.powf(-1.5)
}

/// D.E. Brewe and B.J. Hamrock, J. Lubr. Technol. 99 (1977) 485: fits by regression.
#[inline(always)]
pub fn brewe_hamrock(ratio: f64) -> f64 {
    let elongation = 1.0339 * ratio.powf(0.6360);
    let e = 1.0003 + 0.5968 / ratio;
    let k = 1.5277 + 0.6023 * ratio.ln();
    from_integrals(ratio, elongation, k, e)
}

/// B.J. Hamrock and D. Brewe, J. Lubr. Technol. 105 (1983) 171.
#[inline(always)]
pub fn hamrock_brewe(ratio: f64) -> f64 {
    const Q: f64 = FRAC_PI_2 - 1.0;
    let elongation = ratio.powf(FRAC_2_PI);
    from_integrals(
        ratio,
        elongation,
        FRAC_PI_2 + Q * ratio.ln(),
        1.0 + Q / ratio,
    )
}

/// J.-F. Antoine et al., J. Tribol. 128 (2006) 660, for the axis ratio; the integrals by C. Hastings' polynomials
/// (M. Abramowitz and I. Stegun, Handbook of Mathematical Functions, 17.3.34 and 17.3.36, error 2e-8).
#[inline(always)]
pub fn antoine(ratio: f64) -> f64 {
    let log = ratio.ln();
    let x = (log * std::f64::consts::LOG10_E).powi(2);
    let above =
        1.0 + x * (0.402_274_36 + x * (3.749_175_2e-2 + x * (7.485_576_1e-4 + x * 2.166_702_8e-6)));
    let below =
        1.0 + x * (0.426_788_78 + x * (4.260_540_1e-2 + x * (9.078_692_2e-4 + x * 2.786_892_7e-6)));
    let power = 2.0 / 3.0 * above / below * log;
    let elongation = power.exp();
    let m1 = 1.0 / (elongation * elongation);
    let log_m1 = -2.0 * power;
    let k = 1.386_294_361_12
        + m1 * (0.096_663_442_59
            + m1 * (0.035_900_923_83 + m1 * (0.037_425_637_13 + m1 * 0.014_511_962_12)))
        - log_m1
            * (0.5
                + m1 * (0.124_985_935_97
                    + m1 * (0.068_802_485_76 + m1 * (0.033_283_553_46 + m1 * 0.004_417_870_12))));
    let e = 1.0
        + m1 * (0.443_251_414_63
            + m1 * (0.062_606_012_20 + m1 * (0.047_573_835_46 + m1 * 0.017_365_064_51)))
        - log_m1
            * m1
            * (0.249_983_683_10
                + m1 * (0.092_001_800_37 + m1 * (0.040_696_975_26 + m1 * 0.005_264_496_39)));
    from_integrals(ratio, elongation, k, e)
}

/// The complete integral `K` for the axis ratio `k = b/a`, and `s = (K - E)/K`, by the arithmetic-geometric mean.
#[inline(always)]
pub fn arithmetic_geometric_mean(axis_ratio: f64) -> (f64, f64) {
    let (mut a, mut g) = (1.0, axis_ratio);
    let mut s = 0.5 * (1.0 - axis_ratio * axis_ratio);
    let mut weight = 0.5;
    for _ in 0..12 {
        let c = 0.5 * (a - g);
        (a, g) = (0.5 * (a + g), (a * g).sqrt());
        weight *= 2.0;
        s += weight * c * c;
        if c.abs() < 1e-8 * a {
            // The next difference is of the order of c^2.
            break;
        }
    }
    (FRAC_PI_2 / a, s)
}

/// Newton for `ln(b/a)` with the integrals by the arithmetic-geometric mean, so many steps from
/// Hamrock and Brewe's `b/a = (A/B)^(2/pi)`.
#[inline(always)]
pub fn iterated(ratio: f64, steps: usize) -> f64 {
    let wanted = ratio.ln();
    let mut log = -FRAC_2_PI * wanted;
    for _ in 0..steps {
        let axis_ratio = log.exp();
        let k2 = axis_ratio * axis_ratio;
        let m = 1.0 - k2;
        let (_, s) = arithmetic_geometric_mean(axis_ratio);
        // B/A = (E/k^2 - K)/(K - E), both over K.
        if m < 1e-3 {
            // Both differences vanish at the circle: B/A = k^(-3/2) to second order.
            log = -wanted / 1.5;
            continue;
        }
        let (over, under) = ((m - s) / k2, s);
        // With e = E/K: de/dm = [ e - 1 - e (e/k^2 - 1)/1 ]/(2 m), from dE/dm = (E-K)/(2m), dK/dm = (E/k^2 - K)/(2m).
        let e = 1.0 - s;
        let de = ((e - 1.0) - e * (e / k2 - 1.0)) / (2.0 * m);
        let d_over = (de * k2 + e) / (k2 * k2);
        let slope = -2.0 * k2 * (d_over / over + de / under);
        log = (log - ((over / under).ln() - wanted) / slope).min(0.0);
    }
    let axis_ratio = log.exp();
    let (k, s) = arithmetic_geometric_mean(axis_ratio);
    from_integrals(ratio, 1.0 / axis_ratio, k, k * (1.0 - s))
}
