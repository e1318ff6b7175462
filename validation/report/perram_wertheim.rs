// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contact search by the function of J.W. Perram and M.S. Wertheim, J. Comput. Phys. 58 (1985) 409:
//!
//! ```text
//! F = max over 0 < l < 1 of  l (1-l) d.[(1-l) S_i + l S_j]^-1 d
//! ```
//!
//! `sqrt(F)` is the factor by which both bodies must grow, or shrink, to touch; the normal is that of the touching scaled
//! bodies. The overlap along it is `h_i + h_j - n.d = n.d (1/sqrt(F) - 1)`.

use ellgran::vector::Vector3;

use crate::contact_search::Pair;

/// A symmetric matrix as `xx, yy, zz, xy, xz, yz`.
pub type Symmetric3 = [f64; 6];

#[inline(always)]
pub fn apply(m: &Symmetric3, v: Vector3) -> Vector3 {
    Vector3::new(
        m[0] * v.x + m[3] * v.y + m[4] * v.z,
        m[3] * v.x + m[1] * v.y + m[5] * v.z,
        m[4] * v.x + m[5] * v.y + m[2] * v.z,
    )
}

/// The inverse.
#[inline(always)]
fn inverse(m: &Symmetric3) -> Symmetric3 {
    let [xx, yy, zz, xy, xz, yz] = *m;
    let (a, b, c) = (yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy);
    let over = 1.0 / (xx * a + xy * b + xz * c);
    [
        a * over,
        (xx * zz - xz * xz) * over,
        (xx * yy - xy * xy) * over,
        b * over,
        c * over,
        (xy * xz - xx * yz) * over,
    ]
}

/// `m^-1 v`, and the inverse.
#[inline(always)]
pub fn solve(m: &Symmetric3, v: Vector3) -> (Vector3, Symmetric3) {
    let inverse = inverse(m);
    (apply(&inverse, v), inverse)
}

/// Normal, overlap and the parameter `l`: Newton on the derivative, kept between bounds, until its step is shorter than
/// the tolerance.
#[inline(always)]
pub fn search(pair: &Pair, start: f64, tolerance: f64) -> Option<(Vector3, f64, f64)> {
    let (mut low, mut high) = (0.0, 1.0);
    let mut l = start;
    for _ in 0..60 {
        let m: Symmetric3 =
            core::array::from_fn(|k| (1.0 - l) * pair.shape_i[k] + l * pair.shape_j[k]);
        let (u, inverse) = solve(&m, pair.d);
        let (ui, uj) = (apply(&pair.shape_i, u), apply(&pair.shape_j, u));
        let (qi, qj) = (u.dot(ui), u.dot(uj));
        // The derivative of the function, which is concave.
        let slope = (1.0 - l) * (1.0 - l) * qi - l * l * qj;
        if slope > 0.0 {
            low = l;
        } else {
            high = l;
        }
        // du/dl = -M^-1 (S_j - S_i) u.
        let du = -apply(&inverse, uj - ui);
        let curvature = -2.0 * (1.0 - l) * qi - 2.0 * l * qj
            + 2.0 * ((1.0 - l) * (1.0 - l) * du.dot(ui) - l * l * du.dot(uj));
        let mut next = l - slope / curvature;
        // At the end rounding may put the step across a bound.
        if !(next > low && next < high) && (next - l).abs() >= tolerance {
            next = 0.5 * (low + high);
        }
        let moved = (next - l).abs();
        l = next;
        if moved < tolerance {
            let m: Symmetric3 =
                core::array::from_fn(|k| (1.0 - l) * pair.shape_i[k] + l * pair.shape_j[k]);
            let n = solve(&m, pair.d).0.normalised();
            let h = |shape: &Symmetric3| n.dot(apply(shape, n)).sqrt();
            return Some((n, h(&pair.shape_i) + h(&pair.shape_j) - n.dot(pair.d), l));
        }
    }
    None
}
