// SPDX-License-Identifier: MIT OR Apache-2.0
//! Proofs that a minimum of `f(n) = h_i(n) + h_j(n) - n.d` is the global one, and what the search for the global one goes
//! through.
//!
//! `h_i + h_j` is the support function of the Minkowski sum `K` of the two ellipsoids, and `d` a point of it. A normal `n`
//! where `f` is stationary and equal to `delta` is the foot of a perpendicular from `d` to the surface of `K`, and it is
//! the global minimum exactly when the ball of radius `delta` around `d` lies in `K`.
//!
//! **Two inscribed balls.** The largest ball that lies in an ellipsoid and touches its surface at the point with normal `n`
//! has the radius `a_min^2/h(n)`: from that point, a chord of the ellipsoid in direction `e` has the length
//! `-2 n.e/(h e.S^-1 e)`, one of the ball `-2 r n.e`, and `1/(e.S^-1 e) >= a_min^2`. The sum of two such balls lies in `K`,
//! so that `delta <= a_min,i^2/h_i + a_min,j^2/h_j` is enough.
//!
//! **An inscribed ellipsoid.** With `z = D R^T m` of each body, `h_i h_j >= z_i . O z_j` for every orthogonal `O`: then `K`
//! contains the ellipsoid of the matrix `M^T M`, `M = D_i R_i^T + O D_j R_j^T`. It touches the surface of `K` at `n` too if
//! `O` turns `z_j(n)` into the direction of `z_i(n)`. What freedom is left in `O` makes the part of `M^T M` across `n`
//! `(X + Y)^2`, where `X^2 = h_i W_i` and `Y^2 = h_j W_j`. The ball lies in that ellipsoid if, in the tangent plane,
//!
//! ```text
//! (X + Y)^2 - delta (H I + p p^T/(H - delta))   is positive definite,   H = h_i + h_j ,  p = T^T d
//! ```
//!
//! **Circumscribed ellipsoids.** `K` is the intersection of the ellipsoids with the matrices
//! `S_t = S_i (1 + e^-t) + S_j (1 + e^t)`, whose support function is
//!
//! ```text
//! h_t = H sqrt(1 + sinh^2((t - t_m)/2)/cosh^2(t_m/2)) ,   e^t_m = h_i/h_j
//! ```
//!
//! and so is least, and equal to `H`, at `t = t_m`. Hence the global minimum of `f` is the least distance `g(t)` of `d` from
//! the surfaces of these ellipsoids. That distance has no second minimum to be caught in: it is a root of one
//! monotonic equation. What is left is a function of one variable, of which a value says how small it may be nearby:
//! branch and bound over `t` ends with the global minimum.

use super::ellipsoid::Ellipsoid;
#[cfg(not(feature = "std"))]
use crate::real::Functions;
use crate::real::Real;
use crate::vector::{Symmetric2, Vector2, Vector3};

/// `X`: the square root of `h W`, whose determinant has the square root `root_determinant = a1 a2 a3/h`.
#[inline(always)]
fn square_root<T: Real>(radii: Symmetric2<T>, h: T, root_determinant: T) -> Symmetric2<T> {
    let m = (radii * h).shifted(root_determinant);
    let trace = (m.uu + m.vv).max(h.constant(f64::MIN_POSITIVE));
    m * trace.reciprocal_sqrt()
}

/// One body at a stationary point, for [`inscribed_ellipsoid_margin`].
#[derive(Clone, Copy, Debug)]
pub struct BodyAtNormal<T = f64> {
    /// Support function.
    pub h: T,
    /// Its inverse.
    pub inverse_h: T,
    /// `(a1 a2 a3)^2`.
    pub squared_product: T,
    /// Inverse Weingarten map (radii of curvature) in the tangent basis.
    pub radii: Symmetric2<T>,
}

impl<T: Real> BodyAtNormal<T> {
    /// The square root of the radii of curvature. (No closure: one that the compiler leaves as it is does not have a kernel's
    /// instructions.)
    #[inline(always)]
    fn root_of_radii(&self) -> Symmetric2<T> {
        let root_of_determinant = self.squared_product.sqrt() * self.inverse_h;
        square_root(self.radii, self.h, root_of_determinant)
    }
}

/// The matrix that proves, if it is positive definite and `n.d > 0`, that a stationary point `n` of `f` with the value
/// `penetration` is the global minimum; otherwise nothing is known. Length^2; `across` is `T^T d`.
#[inline(always)]
pub fn inscribed_ellipsoid_margin<T: Real>(
    i: &BodyAtNormal<T>,
    j: &BodyAtNormal<T>,
    penetration: T,
    across: Vector2<T>,
) -> Symmetric2<T> {
    let s = i.root_of_radii() + j.root_of_radii();
    let total = i.h + j.h;
    let tilt = across * (total - penetration).reciprocal();
    let square = Symmetric2::new(
        s.uu.multiply_add(s.uu, s.uv * s.uv),
        s.uv * (s.uu + s.vv),
        s.vv.multiply_add(s.vv, s.uv * s.uv),
    );
    let product = Symmetric2::new(
        across.u.multiply_add(tilt.u, total),
        across.u * tilt.v,
        across.v.multiply_add(tilt.v, total),
    );
    Symmetric2::new(
        square.uu - penetration * product.uu,
        square.uv - penetration * product.uv,
        square.vv - penetration * product.vv,
    )
}

/// The foot of the shortest perpendicular from `d` to the surface of a circumscribed ellipsoid.
#[derive(Clone, Copy, Debug)]
pub struct Foot {
    /// Its length, negative where `d` is outside. Absolute error: rounding times the square of the largest semi-axis over the
    /// support function.
    pub distance: f64,
    /// Normal of that ellipsoid at the foot; unit vector.
    pub normal: Vector3,
}

/// The ellipsoids around the Minkowski sum of two.
pub struct Circumscribed<'a> {
    i: &'a Ellipsoid,
    j: &'a Ellipsoid,
    d: Vector3,
    /// `S_i` and `S_j`.
    shapes: [Matrix; 2],
    /// The principal axes of the ellipsoid that was asked for last, as columns: those of the next, which is most often a near one, are
    /// found from them in fewer rotations.
    axes: Matrix,
}

/// Rows of a symmetric 3x3 matrix.
type Matrix = [[f64; 3]; 3];

const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// `S` of a body.
fn shape(body: &Ellipsoid) -> Matrix {
    let mut m = [[0.0; 3]; 3];
    for (axis, a) in body.axes.iter().zip(body.semi_axes.to_array()) {
        let e = axis.to_array();
        for (row, er) in m.iter_mut().zip(e) {
            for (entry, ec) in row.iter_mut().zip(e) {
                *entry += a * a * er * ec;
            }
        }
    }
    m
}

/// A symmetric matrix along other axes, the columns of `v`.
fn along(v: &Matrix, m: &Matrix) -> Matrix {
    let mut product = [[0.0; 3]; 3];
    for r in 0..3 {
        for c in 0..3 {
            product[r][c] = m[r][0] * v[0][c] + m[r][1] * v[1][c] + m[r][2] * v[2][c];
        }
    }
    let mut turned = [[0.0; 3]; 3];
    for r in 0..3 {
        for c in r..3 {
            let entry = v[0][r] * product[0][c] + v[1][r] * product[1][c] + v[2][r] * product[2][c];
            turned[r][c] = entry;
            turned[c][r] = entry;
        }
    }
    turned
}

/// Eigenvalues of a symmetric matrix by Jacobi's rotations, which are added to those of `v`: its columns become the eigenvectors where
/// `m` is along them.
fn eigen(mut m: Matrix, v: &mut Matrix) -> [f64; 3] {
    for _ in 0..12 {
        let off = m[0][1] * m[0][1] + m[0][2] * m[0][2] + m[1][2] * m[1][2];
        let trace = m[0][0] + m[1][1] + m[2][2];
        if !(off > 1e-36 * trace * trace) {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let r = 3 - p - q;
            if m[p][q] == 0.0 {
                continue;
            }
            let half = 0.5 * (m[q][q] - m[p][p]) / m[p][q];
            let t = half.signum() / (half.abs() + (half * half + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            let change = t * m[p][q];
            m[p][p] -= change;
            m[q][q] += change;
            m[p][q] = 0.0;
            m[q][p] = 0.0;
            let (rp, rq) = (m[r][p], m[r][q]);
            m[r][p] = c * rp - s * rq;
            m[p][r] = m[r][p];
            m[r][q] = s * rp + c * rq;
            m[q][r] = m[r][q];
            for row in v.iter_mut() {
                let (a, b) = (row[p], row[q]);
                row[p] = c * a - s * b;
                row[q] = s * a + c * b;
            }
        }
    }
    [m[0][0], m[1][1], m[2][2]]
}

impl<'a> Circumscribed<'a> {
    /// Of bodies `i` and `j`, with `d` from the centre of `i` to that of `j`.
    pub fn new(i: &'a Ellipsoid, j: &'a Ellipsoid, d: Vector3) -> Self {
        Circumscribed {
            i,
            j,
            d,
            shapes: [shape(i), shape(j)],
            axes: IDENTITY,
        }
    }

    /// Forgets the axes of the ellipsoid that was asked for last, with what rounding has made of them.
    pub fn start_anew(&mut self) {
        self.axes = IDENTITY;
    }

    /// The range of `t` in which every direction has its own.
    pub fn range(&self) -> [f64; 2] {
        let (i, j) = (self.i, self.j);
        [
            (i.smallest_semi_axis() / j.bounding_radius()).ln(),
            (i.bounding_radius() / j.smallest_semi_axis()).ln(),
        ]
    }

    /// The least distance of `d` from the surface of the ellipsoid `t`, and where.
    pub fn foot(&mut self, t: f64) -> Foot {
        let growth = t.exp();
        let factors = [1.0 + 1.0 / growth, 1.0 + growth];
        let m = core::array::from_fn(|r| {
            core::array::from_fn(|c| {
                factors[0] * self.shapes[0][r][c] + factors[1] * self.shapes[1][r][c]
            })
        });
        let values = eigen(along(&self.axes, &m), &mut self.axes);
        let vectors = self.axes;
        let d = self.d.to_array();
        let least = values[0].min(values[1]).min(values[2]);
        // Along each principal axis: d, d over the semi-axis, least square over the square.
        let mut along = [0.0; 3];
        let mut z = [0.0; 3];
        let mut r = [0.0; 3];
        for k in 0..3 {
            along[k] = vectors[0][k] * d[0] + vectors[1][k] * d[1] + vectors[2][k] * d[2];
            r[k] = least / values[k];
            z[k] = along[k].abs() / values[k].sqrt();
            if r[k] == 1.0 {
                // In the plane across the shortest axis the foot may be on either side: choose one.
                z[k] = z[k].max(1e-17);
                let sign = if along[k] < 0.0 { -1.0 } else { 1.0 };
                along[k] = sign * z[k] * values[k].sqrt();
            }
        }
        // The foot is y_k/(1 - mu/s_k), mu <= least; with sigma = 1 - mu/least it is on the surface where
        // F = sum z_k^2/(1 - r_k (1 - sigma))^2 is 1. F^(-1/2) is concave and increasing in sigma: Newton's method from below
        // stays below.
        let mut sigma = 0.0f64;
        for k in 0..3 {
            sigma = sigma.max((z[k] - (1.0 - r[k])) / r[k]);
        }
        for _ in 0..100 {
            let (mut f, mut slope) = (0.0, 0.0);
            for k in 0..3 {
                let inverse = 1.0 / (1.0 - r[k] + r[k] * sigma);
                let square = (z[k] * inverse) * (z[k] * inverse);
                f += square;
                slope += square * inverse * r[k];
            }
            // psi = F^(-1/2), psi' = F^(-3/2) slope.
            let step = (f.sqrt() - 1.0) * f / slope;
            if !(step > 1e-15 * sigma) {
                break;
            }
            sigma += step;
        }
        let mu = least * (1.0 - sigma);
        let mut normal = Vector3::ZERO;
        for k in 0..3 {
            let inverse = 1.0 / (1.0 - r[k] + r[k] * sigma);
            let component = along[k] / values[k] * inverse;
            let axis = Vector3::new(vectors[0][k], vectors[1][k], vectors[2][k]);
            normal = axis.scale_add(component, normal);
        }
        let length = normal.norm();
        Foot {
            distance: mu * length,
            normal: normal * (1.0 / length),
        }
    }

    /// By how much `h_t`, with `t` in the middle of an interval of this width, may exceed `H` in a direction whose own
    /// `t_m` is in the interval, as a share of `H`.
    pub fn excess(middle: f64, width: f64) -> f64 {
        let nearest = (middle.abs() - 0.5 * width).max(0.0);
        let ratio = (0.25 * width).sinh() / (0.5 * nearest).cosh();
        let square = ratio * ratio;
        square / ((1.0 + square).sqrt() + 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::radii_of_curvature;
    use crate::vector::Tangent;

    fn direction(k: u32) -> Vector3 {
        let (a, b) = (f64::from(k) * 0.7, f64::from(k) * 1.3 + 0.2);
        Vector3::new(a.cos() * b.sin(), a.sin() * b.sin(), b.cos()).normalised()
    }

    fn bodies(k: u32) -> [Ellipsoid; 2] {
        let q = direction(3 * k + 1);
        let shapes = [
            ([2.0, 1.0, 0.7], [0.3, 1.0, 1.0]),
            ([1.0, 1.0, 0.05], [1.0, 1.0, 0.02]),
            ([1.0, 0.1, 0.1], [0.2, 3.0, 0.2]),
            ([1.0, 1.0, 1.0], [1.0, 0.01, 0.01]),
        ];
        let (a, b) = shapes[k as usize % 4];
        [
            Ellipsoid::new(a, [0.5, q.x, q.y, q.z]).unwrap(),
            Ellipsoid::new(b, [-0.3, q.y, q.z, q.x]).unwrap(),
        ]
    }

    /// The ball of the radius `a_min^2/h` lies in the ellipsoid, and one a little larger does not.
    #[test]
    fn the_largest_ball_at_a_point_of_the_surface() {
        for k in 0..40 {
            let body = bodies(k)[(k / 4) as usize % 2];
            let n = direction(k + 5);
            let support = body.support(n);
            let radius = body.inscribed_radius(&support);
            let outside = |radius: f64, m: Vector3| {
                let x = body.to_body(support.point + (m - n) * radius);
                x.componentwise(body.inverse_semi_axes).norm_squared() - 1.0
            };
            for m in (0..300).map(direction) {
                assert!(outside(radius, m) < 1e-9, "{body:?} {n:?} {m:?}");
            }
            // The chord along the shortest axis is where it ends.
            let shortest = (0..3)
                .min_by(|a, b| {
                    let a_of = |k: usize| body.semi_axes.to_array()[k];
                    a_of(*a).total_cmp(&a_of(*b))
                })
                .unwrap();
            let e = body.axes[shortest];
            let m = n - e * (2.0 * n.dot(e));
            if n.dot(e).abs() > 0.05 {
                assert!(outside(1.001 * radius, m) > 0.0, "{body:?} {n:?}");
            }
        }
    }

    /// Where the matrix is positive definite, no direction has a smaller value; and it is, up to well beyond the two balls.
    #[test]
    fn the_inscribed_ellipsoid_proves_no_more_than_is_true() {
        let (mut proved, mut beyond) = (0, 0);
        for k in 0..400 {
            let [i, j] = bodies(k);
            let n = direction(k * 7 + 3);
            let tangent = Tangent::new(n);
            let (s_i, s_j) = (i.support(n), j.support(n));
            let balls = i.inscribed_radius(&s_i) + j.inscribed_radius(&s_j);
            let penetration = balls * (0.5 + 0.05 * f64::from(k % 60));
            let d = s_i.point + s_j.point - n * penetration;
            let at = |body: &Ellipsoid, s: &super::super::Support| BodyAtNormal {
                h: s.h,
                inverse_h: s.inverse_h,
                squared_product: body.shape_determinant(),
                radii: radii_of_curvature(body, s, &tangent),
            };
            let (b_i, b_j) = (at(&i, &s_i), at(&j, &s_j));
            let m = inscribed_ellipsoid_margin(&b_i, &b_j, penetration, tangent.components(d));
            if !(n.dot(d) > 0.0 && m.trace() > 0.0 && m.determinant() > 0.0) {
                continue;
            }
            proved += 1;
            beyond += usize::from(penetration > balls);
            for other in (0..3000).map(direction) {
                let f = i.support(other).h + j.support(other).h - other.dot(d);
                assert!(f > penetration - 1e-12, "{i:?} {j:?} {n:?} {other:?}");
            }
        }
        assert!(proved > 100 && beyond > 50, "{proved} {beyond}");
    }

    /// The support functions of the circumscribed ellipsoids, and the distance from their surfaces.
    #[test]
    fn the_circumscribed_ellipsoids() {
        for k in 0..40 {
            let [i, j] = bodies(k);
            let d = direction(k + 9) * (0.1 * f64::from(k % 5));
            let mut around = Circumscribed::new(&i, &j, d);
            let [low, high] = around.range();
            for step in 0..9 {
                let t = low + (high - low) * f64::from(step) / 8.0;
                let foot = around.foot(t);
                let h = |m: Vector3| {
                    let (a, b) = (i.support(m).h, j.support(m).h);
                    (a * a * (1.0 + (-t).exp()) + b * b * (1.0 + t.exp())).sqrt()
                };
                let at_foot = h(foot.normal) - foot.normal.dot(d);
                assert!((at_foot - foot.distance).abs() < 1e-9, "{i:?} {j:?} {t}");
                for m in (0..500).map(direction) {
                    assert!(h(m) - m.dot(d) > foot.distance - 1e-9, "{i:?} {j:?} {t}");
                    let (a, b) = (i.support(m).h, j.support(m).h);
                    let own = (a / b).ln();
                    assert!(own > low - 1e-12 && own < high + 1e-12);
                    let excess = Circumscribed::excess(t, 2.0 * (t - own).abs());
                    assert!(h(m) >= (a + b) * (1.0 - 1e-12));
                    assert!(h(m) <= (a + b) * (1.0 + excess) * (1.0 + 1e-12));
                }
            }
        }
    }
}
