// SPDX-License-Identifier: MIT OR Apache-2.0
//! The common normal and the penetration of two ellipsoids: the global minimum over unit vectors `n` of
//!
//! ```text
//! f(n) = h_i(n) + h_j(n) - n.d ,   d = x_j - x_i
//! ```
//!
//! (docs/theory.md, section 1). `f < 0` for any single `n` proves that the bodies do not touch, so a neighbour pair is
//! rejected by one evaluation with the normal remembered from the last step. A touching pair costs about two Newton
//! steps in the tangent plane from that normal. What plain Newton gets wrong (it runs into maxima and saddles for
//! elongated bodies) is caught by a shifted Hessian, a limited step and backtracking. Whether the minimum that is found is
//! the global one does not depend on the way to it: it is proved, or the global one is searched for
//! (`global_minimum.rs`).

use super::curvature::radii_of_curvature;
use super::ellipsoid::{Ellipsoid, Support};
use super::global_minimum::{inscribed_ellipsoid_margin, BodyAtNormal, Circumscribed};
#[cfg(not(feature = "std"))]
use crate::real::Real;
use crate::vector::{Symmetric2, Tangent, Vector2, Vector3};

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
    /// Whether the contact is deeper than Hertz' law allows: than half the smallest combined radius of curvature, or so
    /// deep that the slow search for the global minimum was needed.
    pub deep: bool,
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

/// Newton steps of one descent, at most. Measured on 4000 random pairs at each of aspect ratio 2, 10, 100 and 1000 and
/// overlaps of 1, 5 and 30 % of the thin axis, from no known normal: 3.8 to 5.7 steps on average, 12 or fewer in 99 %, 108
/// at most. The long ones follow the curved valley of two slender bodies.
const MOST_STEPS: usize = 400;
/// Longest step in the tangent plane: it turns the normal by at most 27 degrees. Any value from 0.25 to 1 changes the mean
/// number of steps by less than 1 % (same measurement).
const LARGEST_STEP: f64 = 0.5;
/// Share of the decrease along the slope that a step must reach (Armijo's condition; Nocedal and Wright, Numerical
/// Optimization, section 3.1, recommend this value).
const SUFFICIENT_DECREASE: f64 = 1e-4;
/// Ratio of the eigenvalues of the Hessian below which the smaller one is taken as lost in rounding: some thousand roundings
/// of the larger one.
const LEAST_DEFINITE: f64 = 1e-12;
/// A Newton step after one of this length changes nothing any more: the error of the next is of the order of its square,
/// 1e-22, times the aspect ratio squared at most.
const SETTLED_STEP: f64 = 1e-11;
/// Intervals of the search for the global minimum, at most. More are wanted only by pairs of aspect ratio 100 and beyond,
/// deeper than the radius of their tips or rims; then what is left is searched at the resolution that was reached.
const MOST_INTERVALS: usize = 512;
/// So many at most are divided into three.
const MOST_DIVIDED: usize = MOST_INTERVALS / 3;
/// The search for the global minimum ends when no other direction can be better by more than this share of the best
/// minimum. Between minima that close, force and energy differ by as little, so that a change from one to the other does
/// not show.
const RESOLUTION: f64 = 1e-6;
/// Minima that one search can hold; the same measurement finds 3 at most.
const MOST_MINIMA: usize = 32;

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
    /// Whether the gradient reached rounding.
    stationary: bool,
    /// Whether it did where the Hessian is safely positive.
    converged: bool,
    /// `W_i` and `W_j`.
    radii: [Symmetric2; 2],
}

/// The minima that a search for the global one has come to.
struct Minima {
    best: Minimum,
    normals: [Vector3; MOST_MINIMA],
    count: usize,
    /// Cosine of the angle that tells two of them apart.
    near: f64,
}

impl Minima {
    fn new(best: Minimum, thinness: f64) -> Self {
        Minima {
            normals: [best.at.n; MOST_MINIMA],
            count: 1,
            // A tenth of the angle between the flat sides of a disc.
            near: 1.0 - 0.005 * thinness * thinness,
            best,
        }
    }

    /// Whether none of them is in this direction, or opposite to it, and there is room for one more.
    fn are_without(&self, n: Vector3) -> bool {
        let known = &self.normals[..self.count];
        self.count < MOST_MINIMA && !known.iter().any(|k| k.dot(n).abs() > self.near)
    }

    /// One more, the best if it is less by more than rounding.
    fn add(&mut self, m: Minimum, rounding: f64) {
        if self.count < MOST_MINIMA {
            self.normals[self.count] = m.at.n;
            self.count += 1;
        }
        if m.at.f < self.best.at.f - rounding {
            self.best = m;
        }
    }
}

/// A step of a descent where the Hessian is not safely positive.
struct IndefiniteStep {
    /// In the tangent plane.
    y: Vector2,
    /// In a valley that has no slope: the length of the step across it. Infinite elsewhere.
    across: f64,
    /// Whether it leaves a maximum or a saddle.
    escape: bool,
}

// One lives on the stack of a search: a box would be an allocation in a step.
#[allow(clippy::large_enum_variant)]
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

    /// `W_i` and `W_j` in the tangent basis.
    #[inline(always)]
    fn radii(&self, at: &Point, tangent: &Tangent) -> [Symmetric2; 2] {
        [
            radii_of_curvature(self.i, &at.support_i, tangent),
            radii_of_curvature(self.j, &at.support_j, tangent),
        ]
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
            let hessian = (radii[0] + radii[1]).shifted(-at.f);
            let (smaller, larger, direction) = eigen_of_any_sign(hessian);
            let settled = g.dot(g) <= tolerance * tolerance || last_step < SETTLED_STEP;
            let definite = smaller > LEAST_DEFINITE * larger.abs();
            if settled && (definite || is_valley(smaller, larger) || escapes > 3) {
                return Descent::Minimum(Minimum {
                    at,
                    tangent,
                    stationary: true,
                    converged: definite,
                    radii,
                });
            }
            let mut y;
            if definite {
                let inverse = 1.0 / hessian.determinant();
                y = hessian.adjugate().apply(g) * -inverse;
            } else {
                let indefinite = self.indefinite_step(g, (smaller, larger, direction), settled);
                y = indefinite.y;
                last_step = indefinite.across;
                escapes += i32::from(indefinite.escape);
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
            while !(next.f <= at.f + SUFFICIENT_DECREASE * t * slope.min(0.0) + floor) && t > 1e-9 {
                t *= 0.5;
                next = self.evaluate((at.n + tangent.vector(y * t)).normalised());
            }
            if definite && t == 1.0 {
                last_step = length;
            }
            at = next;
        }
        let tangent = Tangent::new(at.n);
        Descent::Minimum(Minimum {
            radii: self.radii(&at, &tangent),
            at,
            tangent,
            stationary: false,
            converged: false,
        })
    }

    /// A step downhill where the Hessian, of these eigenvalues and the eigenvector of the smaller one, is not safely positive.
    #[cold]
    fn indefinite_step(
        &self,
        g: Vector2,
        (smaller, larger, direction): (f64, f64, Vector2),
        settled: bool,
    ) -> IndefiniteStep {
        // Newton's step along each eigenvector with the curvature made positive: still downhill. A small curvature is taken as it
        // is: a larger one would follow a long valley in thousands of steps.
        let scale = larger.abs().max(smaller.abs()).max(f64::MIN_POSITIVE);
        let other = Vector2::new(-direction.v, direction.u);
        let slope = g.dot(direction);
        let across = other * (-g.dot(other) / larger.abs().max(1e-3 * scale));
        let length = (slope.abs() / smaller.abs().max(f64::MIN_POSITIVE)).min(LARGEST_STEP);
        let mut step = IndefiniteStep {
            y: across - direction * length.copysign(slope),
            across: f64::INFINITY,
            escape: false,
        };
        if is_valley(smaller, larger) {
            // How curved it is along the valley is lost in rounding: the slope alone says what could be gained there.
            if slope.abs() * LARGEST_STEP <= 4.0 * f64::EPSILON * self.size {
                // Nothing: what is left is the way across.
                step.y = across;
                step.across = g.dot(other).abs() / larger;
            }
        } else if slope.abs() < 0.05 * smaller.abs() || settled {
            // A maximum or a saddle: leave it along the direction of negative curvature.
            let sign = if slope > 0.0 { -1.0 } else { 1.0 };
            step.y = step.y + direction * (0.2 * sign);
            step.escape = true;
        }
        step
    }

    /// The minimum that a descent from `n` ends in, separated or not.
    fn settle(&self, n: Vector3) -> Minimum {
        match self.descend(n, false) {
            Descent::Minimum(m) => m,
            // Not reached: such a descent does not stop at a separating plane.
            Descent::Separated(n) => Minimum {
                at: self.evaluate(n),
                tangent: Tangent::new(n),
                stationary: false,
                converged: false,
                radii: [Symmetric2::default(); 2],
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

    /// Whether a minimum is proved to be the global one.
    fn is_proved(&self, m: &Minimum) -> bool {
        let at = &m.at;
        let balls = self.i.inscribed_radius(&at.support_i) + self.j.inscribed_radius(&at.support_j);
        m.stationary && (at.f <= balls || self.inscribed_ellipsoid_proves(m))
    }

    fn inscribed_ellipsoid_proves(&self, m: &Minimum) -> bool {
        let at = &m.at;
        if !(m.at.n.dot(self.d) > 0.0) {
            return false;
        }
        let body = |support: &Support, squared_product: f64, radii: Symmetric2| BodyAtNormal {
            h: support.h,
            inverse_h: support.inverse_h,
            squared_product,
            radii,
        };
        let margin = inscribed_ellipsoid_margin(
            &body(&at.support_i, self.determinant_i, m.radii[0]),
            &body(&at.support_j, self.determinant_j, m.radii[1]),
            at.f,
            m.tangent.components(self.d),
        );
        let trace = margin.trace();
        trace > 0.0 && margin.determinant() > 1e-12 * trace * trace
    }

    /// The global minimum, by branch and bound over the circumscribed ellipsoids; `best` is a minimum that is known.
    ///
    /// All intervals of one round have the same width, and are divided into three, so that the middle third has the ellipsoid of the
    /// whole, until none of them can hold a direction that is better by more than [`RESOLUTION`], or there are too many of them. Every
    /// dip of the distance that is left is descended into.
    fn global(&self, best: Minimum, stop_when_separated: bool) -> Descent {
        let mut around = Circumscribed::new(self.i, self.j, self.d);
        let distance = self.d.norm();
        let floor = 8.0 * f64::EPSILON * self.size;
        let mut minima = Minima::new(best, self.thinness());
        let [low, high] = around.range();
        let mut width = high - low;
        // Their middles, and the distances of the ellipsoids there.
        let mut intervals = [[0.5 * (low + high), f64::NAN]; MOST_INTERVALS];
        let mut count = 1;
        let mut whole = [[0.0; 2]; MOST_DIVIDED];
        loop {
            let divided = count;
            whole[..divided].copy_from_slice(&intervals[..divided]);
            let first_round = intervals[0][1].is_nan();
            if !first_round {
                width /= 3.0;
            }
            let mut resolved = true;
            count = 0;
            around.start_anew();
            for [middle, known] in &whole[..divided] {
                let thirds = [
                    [middle - width, f64::NAN],
                    [*middle, *known],
                    [middle + width, f64::NAN],
                ];
                let parts = if first_round {
                    &thirds[1..2]
                } else {
                    &thirds[..]
                };
                for &[middle, mut here] in parts {
                    if here.is_nan() {
                        let foot = around.foot(middle);
                        here = foot.distance;
                        if self.evaluate(foot.normal).f < minima.best.at.f - floor {
                            match self.descend(foot.normal, stop_when_separated) {
                                Descent::Separated(n) => return Descent::Separated(n),
                                Descent::Minimum(m) => minima.add(m, floor),
                            }
                            if self.is_proved(&minima.best) {
                                return Descent::Minimum(minima.best);
                            }
                        }
                    }
                    let least = minima.best.at.f;
                    // h_i + h_j of any direction that is better than the best is less than this.
                    let most = least.max(0.0) + distance;
                    let excess = most * Circumscribed::excess(middle, width);
                    if here - excess < least {
                        intervals[count] = [middle, here];
                        count += 1;
                        resolved &= excess < RESOLUTION * least;
                    }
                }
            }
            if resolved || count > MOST_DIVIDED || !(width > 1e-12) {
                break;
            }
        }
        for k in 0..count {
            let beside = |other: usize| {
                let near = (intervals[other][0] - intervals[k][0]).abs() < 1.5 * width;
                near && intervals[other][1] < intervals[k][1]
            };
            if (k > 0 && beside(k - 1)) || (k + 1 < count && beside(k + 1)) {
                continue;
            }
            let n = around.foot(intervals[k][0]).normal;
            if minima.are_without(n) {
                match self.descend(n, stop_when_separated) {
                    Descent::Separated(n) => return Descent::Separated(n),
                    Descent::Minimum(m) => minima.add(m, floor),
                }
            }
        }
        Descent::Minimum(minima.best)
    }

    /// The smallest semi-axis over the size.
    fn thinness(&self) -> f64 {
        self.i.smallest_semi_axis().min(self.j.smallest_semi_axis()) / self.size
    }

    fn cold(&self, stop_when_separated: bool) -> Descent {
        let length = self.d.norm();
        let mut result = None;
        if length > 1e-12 * self.size {
            let along_d = self.d * (1.0 / length);
            for start in self.ray_start().into_iter().chain([along_d]) {
                match self.descend(start, stop_when_separated) {
                    Descent::Separated(n) => return Descent::Separated(n),
                    Descent::Minimum(m) if self.is_proved(&m) => return Descent::Minimum(m),
                    Descent::Minimum(m) => result = Self::better(result, m),
                }
            }
        }
        match result {
            Some(m) => Descent::Minimum(m),
            None => {
                let n = Circumscribed::new(self.i, self.j, self.d).foot(0.0).normal;
                self.descend(n, stop_when_separated)
            }
        }
    }

    fn found(&self, m: Minimum, deep: bool) -> ContactSearch {
        ContactSearch {
            normal: m.at.n,
            penetration: m.at.f,
            support_i: m.at.support_i,
            support_j: m.at.support_j,
            tangent: m.tangent,
            deep,
            converged: m.converged,
        }
    }

    fn finish(&self, mut m: Minimum) -> Outcome {
        let mut deep = m.at.f > 0.5 * smaller_eigenvalue(m.radii[0] + m.radii[1]);
        if !self.is_proved(&m) {
            deep = true;
            match self.global(m, true) {
                Descent::Separated(n) => return Outcome::Separated(n),
                Descent::Minimum(other) => m = other,
            }
        }
        Outcome::Touching(self.found(m, deep))
    }
}

/// Flat along one direction as far as rounding can tell: a ring of equal minima.
fn is_valley(smaller: f64, larger: f64) -> bool {
    larger > 0.0 && smaller.abs() <= LEAST_DEFINITE * larger
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
/// `d` is the vector from the centre of `i` to that of `j`. `start` is the normal found at the last step (any length but
/// zero), or `None`: it makes the search faster and does not change what is found. Never fails; of several equal minima one
/// is taken.
///
/// # Example
/// Two needles of half length 3 and radius 1 (any unit of length), side by side, 1.9 apart:
/// ```
/// use ellgran::geometry::{search, Ellipsoid, Outcome};
/// use ellgran::vector::Vector3;
///
/// let needle = Ellipsoid::new([3.0, 1.0, 1.0], [1.0, 0.0, 0.0, 0.0])?;
/// let Outcome::Touching(contact) = search(&needle, &needle, Vector3::new(0.0, 1.9, 0.0), None) else {
///     panic!("they overlap by 0.1");
/// };
/// assert!((contact.penetration - 0.1).abs() < 1e-14);
/// assert!((contact.normal.y - 1.0).abs() < 1e-14);
/// # Ok::<(), ellgran::geometry::ShapeError>(())
/// ```
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
///
/// # Example
/// ```
/// use ellgran::geometry::contact_search::closest;
/// use ellgran::geometry::Ellipsoid;
/// use ellgran::vector::Vector3;
///
/// // Two spheres of radius 1 m whose centres are 2.5 m apart: a gap of 0.5 m is a penetration of -0.5 m.
/// let sphere = Ellipsoid::new([1.0; 3], [1.0, 0.0, 0.0, 0.0]).expect("an ellipsoid");
/// let found = closest(&sphere, &sphere, Vector3::new(0.0, 2.5, 0.0), None);
/// assert!((found.penetration + 0.5).abs() < 1e-14);
/// assert!((found.normal - Vector3::new(0.0, 1.0, 0.0)).norm() < 1e-14);
/// ```
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;

    /// About y.
    fn turned(semi_axes: [f64; 3], angle: f64) -> Ellipsoid {
        let (sin, cos) = (0.5 * angle).sin_cos();
        Ellipsoid::new(semi_axes, [cos, 0.0, sin, 0.0]).unwrap()
    }

    /// Deeper than half of the smaller of both radii of curvature, which add up as matrices.
    #[test]
    fn a_contact_is_deep_by_its_smaller_radius() {
        let sphere = turned([1.0; 3], 0.0);
        let needle = turned([3.0, 1.0, 1.0], 0.0);
        let across = turned([3.0, 1.0, 1.0], 0.3);
        let x = Vector3::new(1.0, 0.0, 0.0);
        let y = Vector3::new(0.0, 1.0, 0.0);
        for (j, direction, reach, limit) in [
            (&sphere, x, 2.0, 1.0),
            // Tip on tip: twice 1/3.
            (&needle, x, 6.0, 1.0 / 3.0),
            // Side by side, 9 and 1 in the principal directions, which are 0.3 apart: 10 - 8 cos 0.3.
            (&across, y, 2.0, 5.0 - 4.0 * 0.3f64.cos()),
        ] {
            let i = if reach == 2.0 && j.is_sphere() {
                &sphere
            } else {
                &needle
            };
            for (penetration, deep) in [(0.99 * limit, false), (1.01 * limit, true)] {
                let d = direction * (reach - penetration);
                let Outcome::Touching(found) = search(i, j, d, None) else {
                    panic!("they overlap by {penetration}");
                };
                assert!((found.penetration - penetration).abs() < 1e-12);
                assert_eq!(found.deep, deep, "{limit}: {penetration}");
            }
        }
    }

    #[test]
    fn the_shape_matrices_map_it_to_the_distance() {
        let i = Ellipsoid::new([3.0, 1.0, 0.5], [0.5, -0.3, 0.7, 0.2]).unwrap();
        let j = Ellipsoid::new([0.4, 2.0, 1.5], [0.1, 0.8, -0.2, 0.4]).unwrap();
        let d = Vector3::new(0.3, -0.7, 0.4);
        for (ci, cj) in [(1.0, 1.0), (0.2, 3.0)] {
            let n = solve_shape_sum(&i, &j, ci, cj, d).unwrap();
            let times = |body: &Ellipsoid| {
                let support = body.support(n);
                // S n = h times the point of the support function.
                support.point * support.h
            };
            let back = times(&i) * ci + times(&j) * cj;
            let back = back * (1.0 / back.norm());
            assert!((n.norm() - 1.0).abs() < 1e-14);
            assert!((back - d * (1.0 / d.norm())).norm() < 1e-12);
        }
    }

    /// Directions all around.
    fn directions(count: u32) -> impl Iterator<Item = Vector3> {
        (0..count).map(move |k| {
            let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(count);
            let (sin, cos) = (2.399_963 * f64::from(k)).sin_cos();
            let r = (1.0 - z * z).sqrt();
            Vector3::new(r * cos, r * sin, z)
        })
    }

    fn random_body(random: &mut Random, thinnest: f64) -> Ellipsoid {
        let mut semi_axes = [0; 3].map(|_| random.of_any_size(thinnest, 1.0));
        if random.uniform(0.0, 1.0) < 0.5 {
            // Discs and needles.
            semi_axes[0] = semi_axes[1];
        }
        Ellipsoid::new(semi_axes, random.quaternion()).unwrap()
    }

    /// Bodies deep in one another, which have several minima: none is less than the one that is found, from whatever start, and none that
    /// is less than one which is taken as proved.
    #[test]
    fn no_minimum_is_less_than_the_one_that_is_found_or_proved() {
        let mut random = Random::new(31);
        let (mut several, mut proved, mut not_proved, mut searched) = (0, 0, 0, 0);
        for _ in 0..250 {
            let [i, j] = [0; 2].map(|_| random_body(&mut random, 0.02));
            let d = random.direction() * random.uniform(0.02, 0.7);
            let p = pair(&i, &j, d);
            let rounding = 1e-12 * p.size;
            let minima: Vec<Minimum> = directions(60).map(|n| p.settle(n)).collect();
            let least = minima.iter().map(|m| m.at.f).fold(f64::INFINITY, f64::min);
            let most = minima.iter().map(|m| m.at.f).fold(least, f64::max);
            several += usize::from(most > 1.01 * least.abs());
            for m in &minima {
                let is_proved = m.at.f > 0.0 && p.is_proved(m);
                assert!(
                    !is_proved || m.at.f <= least + rounding,
                    "{i:?} {j:?} {d:?}"
                );
                proved += usize::from(is_proved);
                not_proved += usize::from(!is_proved);
            }
            if least < rounding {
                assert!(
                    least > -rounding || matches!(search(&i, &j, d, None), Outcome::Separated(_))
                );
                continue;
            }
            let worst = minima
                .into_iter()
                .max_by(|a, b| a.at.f.total_cmp(&b.at.f))
                .unwrap();
            let starts = [None, Some(worst.at.n), Some(d), Some(random.direction())];
            for start in starts {
                let Outcome::Touching(found) = search(&i, &j, d, start) else {
                    panic!("they overlap by {least}: {i:?} {j:?} {d:?}");
                };
                let allowed = least * (1.0 + RESOLUTION) + rounding;
                assert!(
                    found.penetration <= allowed,
                    "{found:?} {least}: {i:?} {j:?} {d:?}"
                );
                let f = p.evaluate(found.normal).f;
                assert!((found.penetration - f).abs() <= rounding);
            }
            if let Descent::Minimum(m) = p.global(worst, false) {
                assert!(m.at.f <= least * (1.0 + RESOLUTION) + rounding);
                searched += 1;
            }
        }
        println!(
            "{several} with several minima, {proved} proved, {not_proved} not, {searched} searched"
        );
        assert!(several > 50 && proved > 3000 && not_proved > 1000 && searched > 100);
    }

    /// A contact that is not deep is proved at once, found from any start, and where the bodies were put.
    #[test]
    fn shallow_contacts_are_found_where_they_were_made_and_are_not_deep() {
        let mut random = Random::new(37);
        let (mut by_the_ray, mut proved) = (0, 0);
        for _ in 0..400 {
            let [i, j] = [0; 2].map(|_| random_body(&mut random, 0.03));
            let n = random.direction();
            let [s_i, s_j] = [&i, &j].map(|b| b.support(n));
            let touching = s_i.point + s_j.point;
            let tangent = Tangent::new(n);
            let radii =
                radii_of_curvature(&i, &s_i, &tangent) + radii_of_curvature(&j, &s_j, &tangent);
            let radius = smaller_eigenvalue(radii);
            let penetration = 0.02 * radius;
            let d = touching - n * penetration;
            for start in [
                None,
                Some(n),
                Some((n + random.direction() * 0.3).normalised()),
            ] {
                let Outcome::Touching(found) = search(&i, &j, d, start) else {
                    panic!("{i:?} {j:?} {d:?}");
                };
                assert!((found.penetration - penetration).abs() < 1e-11, "{found:?}");
                assert!((found.normal - n).norm() < 1e-6 && found.converged);
                assert!(!found.deep, "{found:?} {i:?} {j:?} {d:?}");
            }
            // Most of those that are as deep as Hertz' law allows are proved too.
            let d = touching - n * (0.4 * radius);
            if let Outcome::Touching(found) = search(&i, &j, d, Some(n)) {
                proved += usize::from(!found.deep);
            }
            let d = touching + n * penetration;
            let apart = closest(&i, &j, d, None);
            assert!((apart.penetration + penetration).abs() < 1e-11 && !apart.deep);
            assert!((apart.normal - n).norm() < 1e-6);
            // Where the bodies touch the ray leads to the normal, most often in a few steps.
            let ray = pair(&i, &j, touching).ray_start().unwrap();
            by_the_ray += usize::from(ray.dot(n) > 0.99);
        }
        println!("{by_the_ray} of 400 by the ray, {proved} proved");
        assert!(by_the_ray > 350 && proved > 330);
    }

    /// Minima are the same up to a tenth of the angle between the flat sides of a disc, and to the sign; no more than there is room for.
    #[test]
    fn minima_that_are_told_apart() {
        let sphere = turned([1.0; 3], 0.0);
        let d = Vector3::new(0.0, 0.0, 1.0);
        let p = pair(&sphere, &sphere, d);
        let disc = turned([1.0, 1.0, 0.1], 0.0);
        assert!((pair(&sphere, &disc, d).thinness() - 0.05).abs() < 1e-15);
        assert!((pair(&disc, &sphere, d).thinness() - 0.05).abs() < 1e-15);
        let at = |angle: f64, f: f64| {
            let mut m = p.settle(d);
            m.at.n = Vector3::new(angle.sin(), 0.0, angle.cos());
            m.at.f = f;
            m
        };
        let n = |angle: f64| at(angle, 1.0).at.n;
        let mut minima = Minima::new(at(0.0, 1.0), 0.5);
        assert!(!minima.are_without(n(0.049)) && minima.are_without(n(0.051)));
        assert!(!minima.are_without(-n(0.049)) && minima.are_without(-n(0.051)));
        minima.add(at(1.0, 2.0), 1e-3);
        assert_eq!(minima.best.at.f, 1.0);
        assert!(!minima.are_without(n(1.02)) && minima.are_without(n(0.5)));
        minima.add(at(0.5, 0.9995), 1e-3);
        assert_eq!(minima.best.at.f, 1.0);
        minima.add(at(0.7, 0.9985), 1e-3);
        assert_eq!(minima.best.at.f, 0.9985);
        for k in 0..MOST_MINIMA + 3 {
            assert_eq!(minima.count, (4 + k).min(MOST_MINIMA));
            assert_eq!(minima.are_without(n(1.5)), 4 + k < MOST_MINIMA);
            minima.add(at(0.7, 1.5), 1e-3);
        }
        minima.add(at(0.7, 0.5), 1e-3);
        assert_eq!(minima.best.at.f, 0.5);
    }
}
