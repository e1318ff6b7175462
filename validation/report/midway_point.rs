// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contact search by the midway point of two implicit surfaces, as for superquadrics (G.T. Houlsby, Comput. Geotech. 36
//! (2009) 953; A. Podlozhnyuk et al., Comput. Part. Mech. 4 (2017) 101): the point `x` and the factor `m` with
//!
//! ```text
//! grad F_i(x) + m^2 grad F_j(x) = 0 ,   F_i(x) - F_j(x) = 0 ,   F(x) = (x - c).S^-1 (x - c) - 1
//! ```
//!
//! by Newton in four unknowns. The normal is that of the level surfaces at `x`; the overlap is the distance, on the line through
//! `x` along it, between where the line leaves one body and the other.

use ellgran::vector::Vector3;

use crate::contact_search::Pair;
use crate::perram_wertheim::{apply, Symmetric3};

/// The point from the centre of body `i`, and `m`.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    pub x: Vector3,
    pub m: f64,
}

/// Between two spheres of the bodies' volumes.
#[inline(always)]
pub fn cold_start(pair: &Pair) -> Point {
    let (ri, rj) = (pair.volume_radius_i, pair.volume_radius_j);
    Point {
        x: pair.d * (ri / (ri + rj)),
        m: rj / ri,
    }
}

struct Residual {
    at_i: Vector3,
    at_j: Vector3,
    gradient: Vector3,
    difference: f64,
}

impl Residual {
    #[inline(always)]
    fn at(pair: &Pair, p: &Point) -> Residual {
        let y = p.x - pair.d;
        let at_i = apply(&pair.inverse_i, p.x) * 2.0;
        let at_j = apply(&pair.inverse_j, y) * 2.0;
        Residual {
            at_i,
            at_j,
            gradient: at_i + at_j * (p.m * p.m),
            difference: 0.5 * (at_i.dot(p.x) - at_j.dot(y)),
        }
    }

    /// Both parts in units of one.
    #[inline(always)]
    fn size(&self, length: f64) -> f64 {
        (self.gradient.norm_squared() * length * length + self.difference * self.difference).sqrt()
    }
}

/// Normal, overlap and the point; steps of Newton, halved while the residual grows, until one is shorter than the
/// tolerance times the radius.
#[inline(always)]
pub fn search(pair: &Pair, start: Point, tolerance: f64) -> Option<(Vector3, f64, Point)> {
    let length = pair.volume_radius_i;
    let mut p = start;
    let mut r = Residual::at(pair, &p);
    for _ in 0..60 {
        let m2 = p.m * p.m;
        let h: Symmetric3 =
            core::array::from_fn(|k| 2.0 * (pair.inverse_i[k] + m2 * pair.inverse_j[k]));
        let column = r.at_j * (2.0 * p.m);
        let row = r.at_i - r.at_j;
        let (step, dm) = solve4(&h, column, row, r.gradient, r.difference)?;
        let mut t = 1.0;
        let size = r.size(length);
        let mut next;
        loop {
            next = Point {
                x: p.x - step * t,
                m: p.m - dm * t,
            };
            r = Residual::at(pair, &next);
            if r.size(length) <= size * (1.0 - 1e-4 * t) + 1e-14 || t < 1e-6 {
                break;
            }
            t *= 0.5;
        }
        p = next;
        if t == 1.0 && step.norm() < tolerance * length {
            return finish(pair, p, &r);
        }
    }
    None
}

/// Gaussian elimination with pivoting on `[h column; row 0] (x, m) = (a, b)`.
#[inline(always)]
fn solve4(
    h: &Symmetric3,
    column: Vector3,
    row: Vector3,
    a: Vector3,
    b: f64,
) -> Option<(Vector3, f64)> {
    let mut m = [
        [h[0], h[3], h[4], column.x, a.x],
        [h[3], h[1], h[5], column.y, a.y],
        [h[4], h[5], h[2], column.z, a.z],
        [row.x, row.y, row.z, 0.0, b],
    ];
    for k in 0..4 {
        let pivot = (k..4).max_by(|&i, &j| m[i][k].abs().total_cmp(&m[j][k].abs()))?;
        m.swap(k, pivot);
        if m[k][k] == 0.0 {
            return None;
        }
        let top = m[k];
        for row in &mut m[k + 1..] {
            let factor = row[k] / top[k];
            for (entry, above) in row.iter_mut().zip(top).skip(k) {
                *entry -= factor * above;
            }
        }
    }
    let mut x = [0.0; 4];
    for k in (0..4).rev() {
        let known: f64 = (k + 1..4).map(|c| m[k][c] * x[c]).sum();
        x[k] = (m[k][4] - known) / m[k][k];
    }
    Some((Vector3::new(x[0], x[1], x[2]), x[3]))
}

#[inline(always)]
fn finish(pair: &Pair, p: Point, r: &Residual) -> Option<(Vector3, f64, Point)> {
    let n = r.at_i.normalised();
    // Where the line x + t n leaves a body: the root of the quadratic on the side of `sign`.
    let leaves = |inverse: &Symmetric3, from: Vector3, sign: f64| {
        let along = apply(inverse, n);
        let (a, b) = (n.dot(along), from.dot(along));
        let c = from.dot(apply(inverse, from)) - 1.0;
        let root = (b * b - a * c).sqrt();
        // Free of cancellation for the small root.
        if b * sign > 0.0 {
            -c / (b + sign * root)
        } else {
            (-b + sign * root) / a
        }
    };
    let overlap = leaves(&pair.inverse_i, p.x, 1.0) - leaves(&pair.inverse_j, p.x - pair.d, -1.0);
    overlap.is_finite().then_some((n, overlap, p))
}
