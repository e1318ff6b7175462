// SPDX-License-Identifier: MIT OR Apache-2.0
//! The common normal and the penetration of two ellipsoids: the global minimum over unit vectors `n` of
//!
//! ```text
//! f(n) = h_i(n) + h_j(n) - n.d ,   d = x_j - x_i
//! ```
//!
//! (THEORY, section 1). `f < 0` for any single `n` proves that the bodies do not touch, so a neighbour pair is
//! rejected by one evaluation with the normal remembered from the last step. A touching pair costs about two Newton
//! steps in the tangent plane from that normal. What plain Newton gets wrong (it runs into maxima and saddles for
//! elongated bodies) is caught by a shifted Hessian, a limited step and backtracking; a contact deeper than half the
//! smallest radius of curvature or a quarter of the bodies' thickness, where `f` has several minima, is searched from many
//! starts every time.

use super::ellipsoid::{Ellipsoid, Support};
use super::vector::{Symmetric2, Tangent, Vector2, Vector3};

/// A pair that touches.
#[derive(Clone, Copy, Debug)]
pub struct ContactSearch {
    /// Unit normal from body `i` to body `j`, world frame.
    pub normal: Vector3,
    /// Penetration (length, > 0): the smallest translation that separates the bodies, along the normal. Absolute error
    /// a few roundings of the size of the bodies. Negative only from [`closest`]: minus the gap.
    pub penetration: f64,
    /// Support of body `i` for `normal`; its witness is `x_i + support_i.point`.
    pub support_i: Support,
    /// Support of body `j` for `normal`; its witness (outward normal `-normal`) is `x_j - support_j.point`.
    pub support_j: Support,
    /// Tangent basis of the normal.
    pub tangent: Tangent,
    /// Whether the slower search from many starts was used.
    pub many_starts: bool,
    /// Whether the gradient reached rounding; if not, this is the best point of the safeguarded search.
    pub converged: bool,
}

/// Answer of [`search`].
#[derive(Clone, Copy, Debug)]
pub enum Outcome {
    /// The plane with this unit normal separates the bodies: remember it for the next step.
    Separated(Vector3),
    /// The bodies touch.
    Touching(ContactSearch),
}

const MOST_STEPS: usize = 80;
const LARGEST_STEP: f64 = 0.5;
/// Starts that are evaluated, not descended from, in the search from many starts, per body frame.
const LATTICE: usize = 32;
const BEST_STARTS: usize = 8;

struct Pair<'a> {
    i: &'a Ellipsoid,
    j: &'a Ellipsoid,
    d: Vector3,
    /// Sum of the largest semi-axes: the scale of rounding errors in `f` and its gradient.
    size: f64,
    determinant_i: f64,
    determinant_j: f64,
}

#[derive(Clone, Copy)]
struct Point {
    n: Vector3,
    f: f64,
    support_i: Support,
    support_j: Support,
}

struct Minimum {
    at: Point,
    tangent: Tangent,
    converged: bool,
    /// Smaller eigenvalue of `W_i + W_j`: the smallest combined radius of curvature at the contact.
    smallest_radius: f64,
}

enum Descent {
    Separated(Vector3),
    Minimum(Minimum),
}

impl Pair<'_> {
    #[inline(always)]
    fn evaluate(&self, n: Vector3) -> Point {
        let support_i = self.i.support(n);
        let support_j = self.j.support(n);
        Point {
            n,
            f: support_i.h + support_j.h - n.dot(self.d),
            support_i,
            support_j,
        }
    }

    /// `W_i + W_j` in the tangent basis.
    #[inline(always)]
    fn radii(&self, at: &Point, tangent: &Tangent) -> Symmetric2 {
        let inverse = |body: &Ellipsoid, support: &Support, determinant: f64| {
            let h2 = support.h * support.h;
            body.weingarten(support, tangent).adjugate() * (determinant / (h2 * h2))
        };
        inverse(self.i, &at.support_i, self.determinant_i)
            + inverse(self.j, &at.support_j, self.determinant_j)
    }

    /// Safeguarded Newton from `n`; with `stop_when_separated` it ends at the first separating plane.
    fn descend(&self, start: Vector3, stop_when_separated: bool) -> Descent {
        let mut at = self.evaluate(start);
        let tolerance = 4.0 * f64::EPSILON * self.size;
        let mut last_step = f64::INFINITY;
        let mut escapes = 0;
        for _ in 0..MOST_STEPS {
            if stop_when_separated && at.f < 0.0 {
                return Descent::Separated(at.n);
            }
            let tangent = Tangent::new(at.n);
            let w = at.support_i.point + at.support_j.point - self.d;
            let g = tangent.components(w);
            let radii = self.radii(&at, &tangent);
            let hessian = radii.shifted(-at.f);
            let (smaller, larger, direction) = eigen_of_any_sign(hessian);
            let settled = g.dot(g) <= tolerance * tolerance || last_step < 1e-11;
            let definite = smaller > 1e-12 * larger.abs();
            // Flat along one direction as far as rounding can tell: a ring of equal minima.
            let valley = !definite && larger > 0.0 && smaller.abs() <= 1e-12 * larger;
            if settled && (definite || valley || escapes > 3) {
                return Descent::Minimum(Minimum {
                    at,
                    tangent,
                    converged: definite,
                    smallest_radius: smaller_eigenvalue(radii),
                });
            }
            let mut y;
            if definite {
                let inverse = 1.0 / hessian.determinant();
                y = hessian.adjugate().apply(g) * -inverse;
            } else {
                // Newton's step along each eigenvector with the curvature made positive: still downhill.
                let scale = larger.abs().max(smaller.abs()).max(f64::MIN_POSITIVE);
                let along =
                    |e: Vector2, value: f64| e * (-g.dot(e) / value.abs().max(1e-3 * scale));
                let other = Vector2::new(-direction.v, direction.u);
                y = along(direction, smaller) + along(other, larger);
                last_step = f64::INFINITY;
                if valley {
                    // Nothing to gain along the valley: what is left is the way across.
                    let gain = g.dot(direction) * g.dot(direction) / (1e-3 * scale);
                    if gain <= f64::EPSILON * self.size {
                        last_step = g.dot(other).abs() / larger;
                    }
                } else if g.dot(direction).abs() < 0.05 * smaller.abs() || settled {
                    // A maximum or a saddle: leave it along the direction of negative curvature.
                    let sign = if g.dot(direction) > 0.0 { -1.0 } else { 1.0 };
                    y = y + direction * (0.2 * sign);
                    escapes += 1;
                }
            }
            let length = y.dot(y).sqrt();
            if !(length > 0.0) {
                y = Vector2::new(0.0, 0.0);
            } else if length > LARGEST_STEP {
                y = y * (LARGEST_STEP / length);
            }
            let slope = g.dot(y);
            let floor = 8.0 * f64::EPSILON * (self.size + at.f.abs());
            let mut t = 1.0;
            let mut next = self.evaluate((at.n + tangent.vector(y)).normalised());
            while !(next.f <= at.f + 1e-4 * t * slope.min(0.0) + floor) && t > 1e-9 {
                t *= 0.5;
                next = self.evaluate((at.n + tangent.vector(y * t)).normalised());
            }
            if definite && t == 1.0 {
                last_step = length;
            }
            at = next;
        }
        let tangent = Tangent::new(at.n);
        let smallest_radius = smaller_eigenvalue(self.radii(&at, &tangent));
        Descent::Minimum(Minimum {
            at,
            tangent,
            converged: false,
            smallest_radius,
        })
    }

    /// The minimum that a descent from `n` ends in, separated or not.
    fn settle(&self, n: Vector3) -> Minimum {
        match self.descend(n, false) {
            Descent::Minimum(m) => m,
            // Not reached: such a descent does not stop at a separating plane.
            Descent::Separated(n) => Minimum {
                at: self.evaluate(n),
                tangent: Tangent::new(n),
                converged: false,
                smallest_radius: 0.0,
            },
        }
    }

    /// The point where the ray along `d` leaves the Minkowski sum: one limit from any start, exact at tangency.
    fn ray_start(&self) -> Option<Vector3> {
        let mut n = solve_shape_sum(self.i, self.j, 1.0, 1.0, self.d)?;
        let mut ratio = 1.0;
        for _ in 0..6 {
            let at = self.evaluate(n);
            let next = at.support_i.h / at.support_j.h;
            n = solve_shape_sum(
                self.i,
                self.j,
                1.0 / at.support_i.h,
                1.0 / at.support_j.h,
                self.d,
            )?;
            if (next - ratio).abs() < 0.02 * next {
                break;
            }
            ratio = next;
        }
        Some(n)
    }

    /// Keeps the smaller of two minima.
    fn better(best: Option<Minimum>, other: Minimum) -> Option<Minimum> {
        match best {
            Some(b) if b.at.f <= other.at.f => Some(b),
            _ => Some(other),
        }
    }

    /// Minima from the best of a few hundred directions: the axes of both bodies, the cross products of their axes,
    /// and lattices in world axes and stretched to each body, all signed towards `d`.
    fn many_starts(&self, stop_when_separated: bool) -> Descent {
        let mut best = [(f64::INFINITY, Vector3::ZERO); BEST_STARTS];
        let mut offer = |n: Vector3| {
            // In units of its largest component: it may be a length, in any unit.
            let largest = n.x.abs().max(n.y.abs()).max(n.z.abs());
            if !(largest > 0.0 && largest < f64::INFINITY) {
                return;
            }
            let n = (n * (1.0 / largest)).normalised();
            let n = if n.dot(self.d) < 0.0 { -n } else { n };
            let f = self.evaluate(n).f;
            if f < best[BEST_STARTS - 1].0 {
                // Not two starts in one valley floor next to each other.
                if let Some(k) = best.iter().position(|b| b.1.dot(n) > 0.9998) {
                    if f < best[k].0 {
                        best[k] = (f, n);
                    }
                } else {
                    best[BEST_STARTS - 1] = (f, n);
                }
                best.sort_by(|a, b| a.0.total_cmp(&b.0));
            }
        };
        offer(self.d);
        for a in self.i.axes.into_iter().chain(self.j.axes) {
            offer(a);
        }
        for a in self.i.axes {
            for b in self.j.axes {
                let n = a.cross(b);
                // Parallel axes have none.
                if n.norm_squared() > 1e-24 {
                    offer(n);
                }
            }
        }
        for k in 0..LATTICE {
            // Fibonacci lattice on the sphere.
            let z = 1.0 - (2 * k + 1) as f64 / LATTICE as f64;
            let radius = (1.0 - z * z).sqrt();
            let (sin, cos) = (2.399963229728653 * k as f64).sin_cos();
            let m = Vector3::new(radius * cos, radius * sin, z);
            offer(m);
            for body in [self.i, self.j] {
                let a = body.semi_axes;
                let scaled =
                    |s: f64| Vector3::new(m.x * a.x.powf(s), m.y * a.y.powf(s), m.z * a.z.powf(s));
                offer(body.to_world(scaled(-1.0)));
                offer(body.to_world(scaled(-2.0)));
                offer(body.to_world(scaled(1.0)));
            }
        }
        let mut result: Option<Minimum> = None;
        for (f, n) in best {
            if f.is_finite() {
                match self.descend(n, stop_when_separated) {
                    Descent::Separated(n) => return Descent::Separated(n),
                    Descent::Minimum(m) => result = Self::better(result, m),
                }
            }
        }
        match result {
            Some(m) => Descent::Minimum(m),
            None => self.descend(Vector3::new(1.0, 0.0, 0.0), stop_when_separated),
        }
    }

    fn cold(&self, stop_when_separated: bool) -> Descent {
        let length = self.d.norm();
        let mut result = None;
        if length > 1e-12 * self.size {
            let along_d = self.d * (1.0 / length);
            for start in self.ray_start().into_iter().chain([along_d]) {
                match self.descend(start, stop_when_separated) {
                    Descent::Separated(n) => return Descent::Separated(n),
                    Descent::Minimum(m) => result = Self::better(result, m),
                }
            }
        }
        match result {
            Some(m)
                if m.at.f < 0.1 * self.i.smallest_semi_axis().min(self.j.smallest_semi_axis()) =>
            {
                Descent::Minimum(m)
            }
            Some(m) => match self.many_starts(stop_when_separated) {
                Descent::Minimum(other) => match Self::better(Some(m), other) {
                    Some(b) => Descent::Minimum(b),
                    None => Descent::Separated(along_any(self.d)),
                },
                separated => separated,
            },
            None => self.many_starts(stop_when_separated),
        }
    }

    fn found(&self, m: Minimum, many_starts: bool) -> ContactSearch {
        ContactSearch {
            normal: m.at.n,
            penetration: m.at.f,
            support_i: m.at.support_i,
            support_j: m.at.support_j,
            tangent: m.tangent,
            many_starts,
            converged: m.converged,
        }
    }

    fn finish(&self, mut m: Minimum) -> Outcome {
        let mut many = false;
        // Beyond half the smallest radius of curvature, or a quarter of the way through the bodies, f has several minima,
        // and the one that a contact followed through the steps need not be the least any more.
        let through = self.i.chord(&m.at.support_i) + self.j.chord(&m.at.support_j);
        if m.at.f > 0.5 * m.smallest_radius
            || m.at.f > 0.25 * through
            || m.at.n.dot(self.d) < 0.0
            || !m.converged
        {
            many = true;
            match self.many_starts(true) {
                Descent::Separated(n) => return Outcome::Separated(n),
                Descent::Minimum(other) => {
                    if other.at.f < m.at.f {
                        m = other;
                    }
                }
            }
        }
        Outcome::Touching(self.found(m, many))
    }
}

fn along_any(d: Vector3) -> Vector3 {
    if d.norm() > 0.0 {
        d.normalised()
    } else {
        Vector3::new(1.0, 0.0, 0.0)
    }
}

/// Of a positive definite matrix, without the eigenvector.
#[inline(always)]
fn smaller_eigenvalue(m: Symmetric2) -> f64 {
    let half_difference = 0.5 * (m.uu - m.vv);
    let radius = (half_difference * half_difference + m.uv * m.uv).sqrt();
    m.determinant() / (0.5 * m.trace() + radius)
}

/// Eigenvalues (smaller, larger) and the unit eigenvector of the smaller, for a matrix that may be indefinite.
#[inline(always)]
fn eigen_of_any_sign(m: Symmetric2) -> (f64, f64, Vector2) {
    let trace = m.trace();
    let determinant = m.determinant();
    // The common case first, without a root: safely positive definite.
    if trace > 0.0 && determinant > 1e-11 * trace * trace {
        return (determinant / trace, trace, Vector2::new(1.0, 0.0));
    }
    m.eigen()
}

/// The unit vector along `(c_i S_i + c_j S_j)^-1 d`.
fn solve_shape_sum(i: &Ellipsoid, j: &Ellipsoid, ci: f64, cj: f64, d: Vector3) -> Option<Vector3> {
    let mut m = [[0.0f64; 3]; 3];
    for (body, c) in [(i, ci), (j, cj)] {
        let a = body.semi_axes.to_array();
        for (axis, a) in body.axes.iter().zip(a) {
            let e = axis.to_array();
            for (row, er) in m.iter_mut().zip(e) {
                for (entry, ec) in row.iter_mut().zip(e) {
                    *entry += c * a * a * er * ec;
                }
            }
        }
    }
    let row = |k: usize| Vector3::from_array(m[k]);
    // Columns of the adjugate of a symmetric matrix are cross products of its rows; the determinant only scales.
    let n = row(1).cross(row(2)) * d.x + row(2).cross(row(0)) * d.y + row(0).cross(row(1)) * d.z;
    let length = n.norm();
    (length > 0.0 && length.is_finite()).then(|| n * (1.0 / length))
}

fn pair<'a>(i: &'a Ellipsoid, j: &'a Ellipsoid, d: Vector3) -> Pair<'a> {
    Pair {
        i,
        j,
        d,
        size: i.bounding_radius() + j.bounding_radius(),
        determinant_i: i.shape_determinant(),
        determinant_j: j.shape_determinant(),
    }
}

/// Whether bodies `i` and `j` touch, and where.
///
/// `d` is the vector from the centre of `i` to that of `j`. `start` is the normal found at the last step (any length
/// but zero), `None` when there is none. Never fails: for coincident centres and deep overlap the slower search from
/// many starts decides; of several equal minima one is taken.
pub fn search(i: &Ellipsoid, j: &Ellipsoid, d: Vector3, start: Option<Vector3>) -> Outcome {
    let pair = pair(i, j, d);
    let descent = match start {
        Some(n) => pair.descend(n.normalised(), true),
        None => pair.cold(true),
    };
    match descent {
        Descent::Separated(n) => Outcome::Separated(n),
        Descent::Minimum(m) => pair.finish(m),
    }
}

/// Like [`search`], but follows a separated pair to the plane of widest separation: penetration < 0 is minus the gap,
/// and the supports give the closest points.
pub fn closest(i: &Ellipsoid, j: &Ellipsoid, d: Vector3, start: Option<Vector3>) -> ContactSearch {
    match search(i, j, d, start) {
        Outcome::Touching(found) => found,
        Outcome::Separated(n) => gap(i, j, d, n),
    }
}

/// The plane of widest separation of two bodies which the plane with the unit normal `n` separates: the penetration is minus
/// the gap.
///
/// Where `f < 0` it has one minimum only, and a descent from there does not leave it; any other start may end in a minimum
/// with `f > 0`, which long bodies have beside each other.
pub fn gap(i: &Ellipsoid, j: &Ellipsoid, d: Vector3, n: Vector3) -> ContactSearch {
    let pair = pair(i, j, d);
    let from_plane = pair.settle(n);
    if from_plane.converged {
        return pair.found(from_plane, false);
    }
    let best = match pair.cold(false) {
        Descent::Minimum(other) if other.at.f < from_plane.at.f => other,
        _ => from_plane,
    };
    pair.found(best, false)
}
