// SPDX-License-Identifier: MIT OR Apache-2.0
//! Complete elliptic integrals by the arithmetic-geometric mean, for comparison with the library's Carlson forms.

/// `K` and `E` for the complementary modulus `k'` (the axis ratio `b/a` of a contact ellipse).
pub fn complete(axis_ratio: f64) -> (f64, f64) {
    let (mut a, mut g) = (1.0, axis_ratio);
    let mut sum = 0.5 * (1.0 - axis_ratio * axis_ratio);
    let mut weight = 0.5;
    while (a - g).abs() > 1e-16 * a {
        let (mean, difference) = (0.5 * (a + g), 0.5 * (a - g));
        g = (a * g).sqrt();
        a = mean;
        weight *= 2.0;
        sum += weight * difference * difference;
        if difference == 0.0 || weight > 1e6 {
            break;
        }
    }
    let k = std::f64::consts::FRAC_PI_2 / a;
    (k, k * (1.0 - sum))
}

/// `B/A` of the contact whose ellipse has this axis ratio (Johnson, Contact Mechanics, Eq. (4.28)).
pub fn curvature_ratio(axis_ratio: f64) -> f64 {
    let (k, e) = complete(axis_ratio);
    (e / (axis_ratio * axis_ratio) - k) / (k - e)
}
