// SPDX-License-Identifier: MIT OR Apache-2.0
//! Carlson's symmetric elliptic integral `R_D` and what Hertz theory needs of it.

#[cfg(not(feature = "std"))]
use crate::real::Real;

/// `R_D(x, y, z)`, to rounding, for `x, y >= 0`, not both zero, and `z > 0`, by the duplication theorem (B.C. Carlson,
/// Numer. Algorithms 10 (1995) 13; DLMF 19.36.2).
pub fn carlson_rd(mut x: f64, mut y: f64, mut z: f64) -> f64 {
    let mut sum = 0.0;
    let mut factor = 1.0;
    loop {
        let mean = (x + y + 3.0 * z) / 5.0;
        let (dx, dy) = ((mean - x) / mean, (mean - y) / mean);
        // The truncation error of the series is of the sixth power of the largest deviation.
        if dx.abs().max(dy.abs()) < 2e-3 {
            let dz = -(dx + dy) / 3.0;
            let e2 = dx * dy - 6.0 * dz * dz;
            let e3 = (3.0 * dx * dy - 8.0 * dz * dz) * dz;
            let e4 = 3.0 * (dx * dy - dz * dz) * dz * dz;
            let e5 = dx * dy * dz * dz * dz;
            let series = 1.0 - 3.0 / 14.0 * e2 + e3 / 6.0 + 9.0 / 88.0 * e2 * e2
                - 3.0 / 22.0 * e4
                - 9.0 / 52.0 * e2 * e3
                + 3.0 / 26.0 * e5;
            return 3.0 * sum + factor * series / (mean * mean.sqrt());
        }
        let (rx, ry, rz) = (x.sqrt(), y.sqrt(), z.sqrt());
        let lambda = rx * ry + ry * rz + rz * rx;
        sum += factor / (rz * (z + lambda));
        factor *= 0.25;
        x = 0.25 * (x + lambda);
        y = 0.25 * (y + lambda);
        z = 0.25 * (z + lambda);
    }
}

/// The elliptic integrals of a contact ellipse with axis ratio `k = b/a`, `0 < k <= 1`, `m = 1 - k^2`.
#[derive(Clone, Copy, Debug)]
pub struct EllipseIntegrals {
    /// `D = (K - E)/m`.
    pub d: f64,
    /// `Bl = (E - k^2 K)/m = K - D`.
    pub bl: f64,
    /// `K`, the complete integral of the first kind.
    pub k: f64,
}

/// `D`, `Bl` and `K` without cancellation (docs/theory.md, section 2).
pub fn ellipse_integrals(axis_ratio: f64) -> EllipseIntegrals {
    let k2 = axis_ratio * axis_ratio;
    let d = carlson_rd(0.0, k2, 1.0) / 3.0;
    let bl = k2 * carlson_rd(0.0, 1.0, k2) / 3.0;
    EllipseIntegrals { d, bl, k: bl + d }
}
