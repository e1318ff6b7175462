// SPDX-License-Identifier: MIT OR Apache-2.0
//! The library's contact search with the tolerance left open: Newton on the support functions, built of the library's own
//! parts, without the safeguards that the library adds for deep overlaps and saddles.

use ellgran::geometry::Ellipsoid;
use ellgran::real::Real;
use ellgran::vector::{Symmetric2, Tangent, Vector3};

use crate::contact_search::Pair;

/// `W` of a body at a support from its Weingarten map.
#[inline(always)]
fn radii<T: Real>(v: Symmetric2<T>, determinant: T, h: T) -> Symmetric2<T> {
    let h2 = h * h;
    v.adjugate() * (determinant / (h2 * h2))
}

/// Overlap at a normal, and the normal after one Newton step.
#[inline(always)]
pub fn step<T: Real>(
    i: &Ellipsoid<T>,
    j: &Ellipsoid<T>,
    d: Vector3<T>,
    n: Vector3<T>,
) -> (T, Vector3<T>) {
    let (si, sj) = (i.support(n), j.support(n));
    let f = si.h + sj.h - n.dot(d);
    let tangent = Tangent::new(n);
    let g = tangent.components(si.point + sj.point - d);
    let sum = radii(i.weingarten(&si, &tangent), i.shape_determinant(), si.h)
        + radii(j.weingarten(&sj, &tangent), j.shape_determinant(), sj.h);
    let hessian = sum.shifted(-f);
    let y = hessian.adjugate().apply(g) * (f.constant(-1.0) / hessian.determinant());
    (f, (n + tangent.vector(y)).normalised())
}

/// Overlap at a normal.
#[inline(always)]
pub fn overlap<T: Real>(i: &Ellipsoid<T>, j: &Ellipsoid<T>, d: Vector3<T>, n: Vector3<T>) -> T {
    i.support(n).h + j.support(n).h - n.dot(d)
}

/// Normal and overlap: steps of Newton until the next one is shorter than `tolerance` (radians). A step is at most half
/// a radian, halved until the overlap does not grow.
#[inline(always)]
pub fn search(pair: &Pair, start: Vector3, tolerance: f64) -> Option<(Vector3, f64)> {
    let (i, j, d) = (&pair.i, &pair.j, pair.d);
    let size = i.bounding_radius() + j.bounding_radius();
    let mut n = start;
    for _ in 0..50 {
        let (f, mut next) = step(i, j, d, n);
        let mut length = (next - n).norm();
        if !(length < 0.5) || overlap(i, j, d, next) > f + 1e-15 * size {
            // Downhill by gradient where Newton is not.
            let (si, sj) = (i.support(n), j.support(n));
            let w = si.point + sj.point - d;
            let w = w - n * n.dot(w);
            let mut t = 0.5 / w.norm().max(1e-300);
            loop {
                next = (n - w * t).normalised();
                if overlap(i, j, d, next) <= f || t * w.norm() < 1e-12 {
                    break;
                }
                t *= 0.5;
            }
            length = (next - n).norm();
        }
        n = next;
        if length < tolerance {
            return Some((n, overlap(i, j, d, n)));
        }
    }
    None
}

/// The direction in which the ray along `d` leaves the sum of the bodies: a start when there is none.
#[inline(always)]
pub fn cold_start(pair: &Pair) -> Vector3 {
    let mut n = solve(pair, 1.0, 1.0);
    for _ in 0..6 {
        let (hi, hj) = (pair.i.support(n).h, pair.j.support(n).h);
        let next = solve(pair, 1.0 / hi, 1.0 / hj);
        let moved = (next - n).norm();
        n = next;
        if moved < 0.02 {
            break;
        }
    }
    n
}

/// Unit vector along `(c_i S_i + c_j S_j)^-1 d`.
#[inline(always)]
fn solve(pair: &Pair, ci: f64, cj: f64) -> Vector3 {
    let m: [f64; 6] = core::array::from_fn(|k| ci * pair.shape_i[k] + cj * pair.shape_j[k]);
    crate::perram_wertheim::solve(&m, pair.d).0.normalised()
}
