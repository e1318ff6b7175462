// SPDX-License-Identifier: MIT OR Apache-2.0
//! The global minimum of `f(n) = h_i(n) + h_j(n) - n.d` by descent from very many directions: slow, and sharing nothing
//! with the library but the definition.

use super::scene::{position, rotation, Vector};
use ellgran::contact::Body;
use nalgebra::{Matrix2, Matrix3, Matrix3x2};

struct Shape {
    turn: Matrix3<f64>,
    semi_axes: Vector,
    matrix: Matrix3<f64>,
}

impl Shape {
    fn new(b: &Body) -> Self {
        let turn = *rotation(b.quaternion).to_rotation_matrix().matrix();
        let semi_axes = Vector::from(b.semi_axes);
        let squares = semi_axes.component_mul(&semi_axes);
        Shape {
            turn,
            semi_axes,
            matrix: turn * Matrix3::from_diagonal(&squares) * turn.transpose(),
        }
    }
    /// `h(n)` and the witness.
    fn support(&self, n: &Vector) -> (f64, Vector) {
        let z = self.semi_axes.component_mul(&self.turn.tr_mul(n));
        let h = z.norm();
        (h, self.turn * self.semi_axes.component_mul(&z) / h)
    }
}

/// Support function of a body.
pub fn support(b: &Body, n: &Vector) -> f64 {
    Shape::new(b).support(n).0
}

/// The point of a body's surface with this outward normal, from the centre.
pub fn witness(b: &Body, n: &Vector) -> Vector {
    Shape::new(b).support(n).1
}

struct Pair {
    i: Shape,
    j: Shape,
    d: Vector,
}

impl Pair {
    fn f(&self, n: &Vector) -> f64 {
        self.i.support(n).0 + self.j.support(n).0 - n.dot(&self.d)
    }

    /// Levenberg's damped Newton: every accepted step goes downhill.
    fn descend(&self, start: Vector) -> (f64, Vector) {
        let mut n = start;
        let mut f = self.f(&n);
        let mut damping = 0.0f64;
        for _ in 0..200 {
            let (hi, si) = self.i.support(&n);
            let (hj, sj) = self.j.support(&n);
            let u = if n.x.abs() < 0.6 {
                Vector::x()
            } else {
                Vector::y()
            };
            let u = (u - n * n.dot(&u)).normalize();
            let t = Matrix3x2::from_columns(&[u, n.cross(&u)]);
            let g = t.transpose() * (si + sj - self.d);
            let curvature = (self.i.matrix - si * si.transpose()) / hi
                + (self.j.matrix - sj * sj.transpose()) / hj;
            let m: Matrix2<f64> = t.transpose() * curvature * t - Matrix2::identity() * f;
            let (mean, radius) = (
                0.5 * m.trace(),
                (0.25 * (m[(0, 0)] - m[(1, 1)]).powi(2) + m[(0, 1)].powi(2)).sqrt(),
            );
            let scale = mean.abs() + radius;
            let least = 1e-13 * scale - (mean - radius);
            let mut moved = 0.0;
            for _ in 0..40 {
                let shifted = m + Matrix2::identity() * damping.max(least);
                let y = shifted
                    .try_inverse()
                    .map_or(g * (-1.0 / scale), |inverse| inverse * -g);
                let y = if y.norm() > 0.5 {
                    y * (0.5 / y.norm())
                } else {
                    y
                };
                let next = (n + t * y).normalize();
                let value = self.f(&next);
                if value < f {
                    moved = y.norm();
                    n = next;
                    f = value;
                    damping *= 0.1;
                    if damping < 1e-12 * scale {
                        damping = 0.0;
                    }
                    break;
                }
                damping = (damping * 8.0).max(1e-3 * scale);
            }
            if moved < 1e-9 {
                break;
            }
        }
        (f, n)
    }
}

/// The smallest `f` found and its direction: minus the gap for bodies apart. `density` scales the number of directions
/// tried (about `9 density`) and of descents.
pub fn deepest(i: &Body, j: &Body, density: usize) -> (f64, Vector) {
    let pair = Pair {
        i: Shape::new(i),
        j: Shape::new(j),
        d: position(j) - position(i),
    };
    let mut starts: Vec<(f64, Vector)> = Vec::new();
    let mut offer = |n: Vector| {
        // Squares of the components of a centre's offset may be too small for double precision.
        if let Some(n) = (n / n.amax()).try_normalize(0.5) {
            // f(-n) = f(n) + 2 n.d
            let n = if n.dot(&pair.d) < 0.0 { -n } else { n };
            starts.push((pair.f(&n), n));
        }
    };
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    for k in 0..density {
        let z = 1.0 - (2 * k + 1) as f64 / density as f64;
        let (sin, cos) = (golden * k as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        let m = Vector::new(r * cos, r * sin, z);
        offer(m);
        for b in [&pair.i, &pair.j] {
            for power in [-2.0, -1.0, 1.0, 2.0] {
                offer(b.turn * b.semi_axes.map(|a| a.powf(power)).component_mul(&m));
            }
        }
    }
    for a in pair.i.turn.column_iter() {
        offer(a.into_owned());
        for b in pair.j.turn.column_iter() {
            offer(b.into_owned());
            offer(a.cross(&b));
        }
    }
    offer(pair.d);
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    // The best, and some of all the others.
    let best = density / 8;
    let every = (starts.len() / best.max(1)).max(1);
    let chosen = starts
        .iter()
        .take(best)
        .chain(starts.iter().skip(best).step_by(every));
    chosen
        .map(|s| pair.descend(s.1))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .expect("there are starts")
}
