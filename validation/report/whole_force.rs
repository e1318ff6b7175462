// SPDX-License-Identifier: MIT OR Apache-2.0
//! Hertz' force in contacts of given pairs, by another way than the library's: shape matrices formed, Newton from the normal of
//! Perram and Wertheim, curvatures from the Hessian of the support function, integrals by the arithmetic-geometric mean.
//!
//! Input: a line of 20 numbers per pair (semi-axes, position, quaternion of each body). Output: a line per touching pair.

use std::fmt::Write;
use std::path::Path;

use nalgebra::{Matrix2, Matrix3, Matrix3x2, Vector2};

use crate::literature;
use crate::support::perram_wertheim::contact_function;
use crate::support::scene::{body, position, rotation, Vector};
use crate::Outcome;
use ellgran::contact::Body;

pub fn run(directory: &Path, pairs: &Path, effective_modulus: f64) -> Outcome {
    let mut table = String::from("pair,fx,fy,fz,overlap_over_radius,curvature_ratio\n");
    for (number, line) in std::fs::read_to_string(pairs)?.lines().enumerate() {
        let x: Vec<f64> = line.split(',').map(str::parse).collect::<Result<_, _>>()?;
        if x.len() != 20 {
            return Err(format!("{} numbers, not 20: {line}", x.len()).into());
        }
        let of = |at: usize| {
            body(
                [x[at], x[at + 1], x[at + 2]],
                Vector::new(x[at + 3], x[at + 4], x[at + 5]),
                rotation([x[at + 6], x[at + 7], x[at + 8], x[at + 9]]),
            )
        };
        let (i, j) = (of(0), of(10));
        if contact_function(&i, &j) >= 1.0 {
            continue;
        }
        let found = hertz(&i, &j, effective_modulus);
        writeln!(
            table,
            "{number},{:e},{:e},{:e},{:.3e},{:.4}",
            found.force.x, found.force.y, found.force.z, found.depth, found.ratio
        )?;
    }
    std::fs::write(directory.join("whole-force-reference.csv"), table)?;
    Ok(())
}

struct Hertz {
    /// On `j`.
    force: Vector,
    /// Overlap over the effective radius of curvature.
    depth: f64,
    /// `B/A`.
    ratio: f64,
}

fn shape(b: &Body) -> Matrix3<f64> {
    let r = rotation(b.quaternion).to_rotation_matrix();
    let a = Vector::from(b.semi_axes);
    r.matrix() * Matrix3::from_diagonal(&a.component_mul(&a)) * r.matrix().transpose()
}

/// Any two unit vectors across `n`.
fn across(n: &Vector) -> Matrix3x2<f64> {
    let u = n.cross(&Vector::ith(n.iamin(), 1.0)).normalize();
    Matrix3x2::from_columns(&[u, n.cross(&u)])
}

fn hertz(i: &Body, j: &Body, effective_modulus: f64) -> Hertz {
    let (si, sj) = (shape(i), shape(j));
    let d = position(j) - position(i);
    let size = d.norm();
    // Perram and Wertheim's normal, by bisection.
    let (mut low, mut high) = (0.0, 1.0);
    let solve = |l: f64| -> Vector {
        let m: Matrix3<f64> = si * (1.0 - l) + sj * l;
        m.try_inverse().unwrap_or_else(Matrix3::identity) * d
    };
    for _ in 0..50 {
        let l: f64 = 0.5 * (low + high);
        let u = solve(l);
        if (1.0 - l).powi(2) * u.dot(&(si * u)) > l * l * u.dot(&(sj * u)) {
            low = l;
        } else {
            high = l;
        }
    }
    let mut n = solve(0.5 * (low + high)).normalize();
    let h = |s: &Matrix3<f64>, n: &Vector| n.dot(&(s * n)).sqrt();
    let hessian = |s: &Matrix3<f64>, n: &Vector| -> Matrix3<f64> {
        let (h, p) = (h(s, n), s * n);
        s / h - p * p.transpose() / (h * h * h)
    };
    let overlap = |n: &Vector| h(&si, n) + h(&sj, n) - n.dot(&d);
    for _ in 0..30 {
        let t = across(&n);
        let g: Vector2<f64> = t.transpose() * (si * n / h(&si, &n) + sj * n / h(&sj, &n) - d);
        let w: Matrix2<f64> = t.transpose() * (hessian(&si, &n) + hessian(&sj, &n)) * t;
        let step = (w - Matrix2::identity() * overlap(&n))
            .try_inverse()
            .unwrap_or_else(Matrix2::zeros)
            * g;
        n = (n - t * step).normalize();
        if g.norm() < 1e-15 * size {
            break;
        }
    }
    let t = across(&n);
    let curvature = |s: &Matrix3<f64>| -> Matrix2<f64> {
        let w: Matrix2<f64> = t.transpose() * hessian(s, &n) * t;
        w.try_inverse().unwrap_or_else(Matrix2::zeros)
    };
    let m = (curvature(&si) + curvature(&sj)) * 0.5;
    let eigenvalues = m.symmetric_eigenvalues();
    let (a, b) = (eigenvalues.min(), eigenvalues.max());
    let radius = 0.5 / (a * b).sqrt();
    let delta = overlap(&n);
    let force = 4.0 / 3.0
        * effective_modulus
        * radius.sqrt()
        * delta.max(0.0).powf(1.5)
        * literature::iterated((b / a).max(1.0), 5);
    Hertz {
        force: n * force,
        depth: delta / radius,
        ratio: b / a,
    }
}
