// SPDX-License-Identifier: MIT OR Apache-2.0
//! An ellipsoid and a circular cone, of which the cylinder is one, from within or from without.
//!
//! The normal is given by a direction `u` of the cross-section, `n = c u + s a` with the axis `a`, so the search has one
//! angle. From within, the depth behind the tangent plane along `u` is `n.x + h(n) - c R`, `R` the radius at the cone's point
//! and `x` the centre from there; each of its maxima above 0 is a contact: a needle across the axis has two. From without, the
//! separation `n.x - h(n) - c R` has one maximum, as for any two convex bodies.
//!
//! # Example
//! ```
//! use ellgran::geometry::cone::{touch_cone, Cone};
//! use ellgran::geometry::Ellipsoid;
//! use ellgran::vector::Vector3;
//!
//! // A ball of radius 1 cm in a pipe of radius 10 cm about z, 0.1 mm deep in its wall (m).
//! let pipe = Cone::cylinder(Vector3::ZERO, Vector3::new(0.0, 0.0, 1.0), 0.1);
//! let ball = Ellipsoid::new([0.01; 3], [1.0, 0.0, 0.0, 0.0]).expect("an ellipsoid");
//! let centre = Vector3::new(0.0901, 0.0, 0.3);
//! assert!(pipe.has_within(centre));
//! let mut contacts = Vec::new();
//! touch_cone(&ball, centre, &pipe, true, |contact| contacts.push(contact));
//! assert_eq!(contacts.len(), 1);
//! let contact = &contacts[0];
//! assert!((contact.point - Vector3::new(0.1, 0.0, 0.3)).norm() < 1e-12);
//! assert!((contact.normal - Vector3::new(-1.0, 0.0, 0.0)).norm() < 1e-12);
//! assert!((contact.along - 0.3).abs() < 1e-12);
//! ```

use super::convex_body::{ConvexBody, SquaredSupport};
use super::ellipsoid::{Ellipsoid, LARGEST_ASPECT_RATIO};
#[cfg(not(feature = "std"))]
use crate::real::Functions;
use crate::real::Real;
use crate::vector::{Tangent, Vector3};

/// A cone, without ends.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Cone {
    /// A point of the axis, world frame.
    pub point: Vector3,
    /// Unit vector along the axis.
    pub axis: Vector3,
    /// Radius at `point`, > 0.
    pub radius: f64,
    /// By how much the radius grows along the axis; 0 for a cylinder.
    pub slope: f64,
}

impl Cone {
    /// A cylinder about the axis through `point`.
    pub fn cylinder(point: Vector3, axis: Vector3, radius: f64) -> Self {
        Cone {
            point,
            axis,
            radius,
            slope: 0.0,
        }
    }

    /// Way across the axis over the way along the surface's normal, `sqrt(1 + slope^2)`.
    pub(crate) fn stretch(&self) -> f64 {
        (1.0 + self.slope * self.slope).sqrt()
    }

    /// Components of the normal from within to without, across the axis and along it.
    pub(crate) fn normal_components(&self) -> (f64, f64) {
        let c = 1.0 / self.stretch();
        (c, -self.slope * c)
    }

    /// Whether a point is within, nearer to the axis than the surface.
    pub fn has_within(&self, position: Vector3) -> bool {
        let offset = position - self.point;
        let along = self.axis.dot(offset);
        (offset - self.axis * along).norm() <= self.radius + self.slope * along
    }
}

/// A contact with a cone.
#[derive(Clone, Copy, Debug)]
pub struct ConeContact {
    /// The point of the wall deepest in the body, world frame.
    pub point: Vector3,
    /// Unit normal out of the wall, towards the body.
    pub normal: Vector3,
    /// Radius of curvature of the wall around the axis, at the point; along the axis it is straight.
    pub curvature_radius: f64,
    /// How far from the cone's point along the axis.
    pub along: f64,
}

/// Between two directions the search takes the slope of the depth for the cubic with the same ends and rises. The depth has two parts. That
/// of the centre is a sine, of which the cubic is right to 4e-6 over the longest stride (its fourth power over 384). The body's is the length of
/// a vector whose end runs along an ellipse: in a stride the vector changes by a quarter of its length at most, so that it turns by less than
/// about a quarter of a radian. Where a slender body is seen from its side, this is a stride of a quarter of the inverse of its aspect ratio.
const LONGEST_STRIDE: f64 = 0.2;
const LARGEST_CHANGE: f64 = 0.25;
/// No body is more slender than this asks for; rounding may make one seem so.
const SHORTEST_STRIDE: f64 = LARGEST_CHANGE / LARGEST_ASPECT_RATIO;
/// How often an interval is halved in which the cubic has more than one zero. Two maxima that are nearer to each other than what is left, a
/// 64th of it, are taken as one: the depth between them is less by the fourth power of that, some 2e-10 of the support function.
const MOST_HALVINGS: usize = 6;

/// Steps of Newton's method before the directions are tried, the longest of them, and the one that is the last, in radians. After a step of
/// 1e-9 the error is of the order of its square, below rounding, and from 0.5 on each step squares the error: five reach 1e-9, and
/// three more are for starts where it is not yet so. The depth turns with twice the angle at most and is concave for about pi/4 beside a maximum: a
/// step much longer than half of that has left it. Where a bound ends the search, the directions are tried, which find the same.
pub(crate) const MOST_STEPS: usize = 8;
pub(crate) const LONGEST_STEP: f64 = 0.5;
pub(crate) const SHORTEST_STEP: f64 = 1e-9;

/// The depth of a body within a cone, behind the tangent plane along `u`, as a function of the angle of `u` with the direction of the
/// centre.
///
/// With the axis `a`, the directions `e1` to the centre and `e2 = a x e1`, and the body's shape matrix `M` (`h^2 = n.M n`) in the frame
/// of these, the square of the support function is a quadratic form of cosine and sine:
/// `Q = uu cos^2 + 2 uv cos sin + vv sin^2 + 2 (bu cos + bv sin) + k`. It is formed, and loses the square of the aspect ratio in
/// digits: as much less moves the angle where the depth is concave ([`DepthInCone::is_concave`]).
#[derive(Clone, Copy)]
pub(crate) struct DepthInCone<T> {
    /// `c` times the distance of the centre from the axis.
    across: T,
    /// `c R - s z`, with `z` the place of the centre along the axis: how far the tangent planes are.
    at_point: T,
    /// Coefficients of `Q`.
    uu: T,
    uv: T,
    vv: T,
    bu: T,
    bv: T,
    k: T,
    /// `a.M n = mu cos + mv sin + mk`.
    mu: T,
    mv: T,
    mk: T,
    /// Components of the normal.
    c: f64,
    s: f64,
}

impl<T: Real> DepthInCone<T> {
    /// Of a body with its centre at this distance from the axis and at `z` along it, from the cone's point; `directions` are those of
    /// the centre and of a quarter turn further.
    #[inline(always)]
    pub fn new<B: ConvexBody<T>>(
        cone: &Cone,
        body: &B,
        (axis, directions): (Vector3<T>, Tangent<T>),
        [distance, z]: [T; 2],
    ) -> Self {
        let (c, s) = cone.normal_components();
        let SquaredSupport {
            constant,
            linear,
            quadratic,
        } = body.squared_support(&body.view(axis, &directions));
        let [mu, mv, mk] = [linear.u * c, linear.v * c, constant * s];
        DepthInCone {
            across: distance * c,
            at_point: -(z * s - c * cone.radius),
            uu: quadratic.uu * (c * c),
            uv: quadratic.uv * (c * c),
            vv: quadratic.vv * (c * c),
            bu: mu * s,
            bv: mv * s,
            k: mk * s,
            mu,
            mv,
            mk,
            c,
            s,
        }
    }

    /// What the axis must be farther from the tangent planes, for the depth to have one maximum in the directions in which the body may
    /// touch. The second derivative with the angle is `c (c t.H t - u.p - distance cos)` with the support point `p` and the Hessian
    /// `H` of the support function, of which `t.H t <= a_max^2/a_min` and `-c u.p = s a.p - h < |s| a_max`.
    #[inline(always)]
    pub fn is_concave(&self, [largest, smallest]: [T; 2]) -> T::Mask {
        let bend = largest * largest / smallest * (self.c * self.c) + largest * self.s.abs();
        bend.less(self.at_point - largest)
    }

    /// `Q` of an angle.
    #[inline(always)]
    fn square(&self, cos: T, sin: T) -> T {
        let first = self.uu.multiply_add(cos, self.bu + self.bu);
        let both = (self.uv + self.uv).multiply_add(cos, self.bv + self.bv);
        let second = self.vv.multiply_add(sin, both);
        cos.multiply_add(first, sin.multiply_add(second, self.k))
    }

    /// The square of the speed of the vector whose length is the support function, with the angle.
    #[inline(always)]
    fn speed_squared(&self, cos: T, sin: T) -> T {
        let both = self.uv * (cos * sin);
        self.uu * (sin * sin) - (both + both) + self.vv * (cos * cos)
    }

    /// How far the centre is from the tangent plane.
    #[inline(always)]
    pub fn height(&self, cos: T) -> T {
        self.across.negative_multiply_add(cos, self.at_point)
    }

    /// The support function towards it.
    #[inline(always)]
    pub fn support(&self, cos: T, sin: T) -> T {
        self.square(cos, sin).sqrt()
    }

    /// Where the deepest point of the wall is along the axis, from the centre.
    #[inline(always)]
    pub fn along(&self, cos: T, sin: T, [height, support]: [T; 2]) -> T {
        let of_body = self
            .mu
            .multiply_add(cos, self.mv.multiply_add(sin, self.mk));
        of_body.multiply_add(support.reciprocal(), (height - support) * self.s)
    }

    /// First and second derivative of the depth with the angle.
    #[inline(always)]
    fn slopes(&self, cos: T, sin: T) -> (T, T) {
        let inverse = self.square(cos, sin).reciprocal_sqrt();
        let difference = self.vv - self.uu;
        let (both, squares) = (cos * sin, cos.multiply_subtract(cos, sin * sin));
        let (bu_sin, bv_sin) = (self.bu * sin, self.bv * sin);
        let first =
            difference.multiply_add(both, self.uv.multiply_add(squares, -bu_sin)) + self.bv * cos;
        let second =
            difference.multiply_subtract(squares, self.uv * both * 4.0) - self.bu * cos - bv_sin;
        let rise = first * inverse;
        (
            self.across.negative_multiply_add(sin, rise),
            rise.negative_multiply_add(rise, second)
                .multiply_subtract(inverse, self.across * cos),
        )
    }

    /// A step of Newton's method: the second derivative, by how much the angle changes, and cosine and sine of the new one.
    #[inline(always)]
    pub fn step(&self, cos: T, sin: T) -> (T, T, [T; 2]) {
        let (first, second) = self.slopes(cos, sin);
        let change = -(first / second);
        let inverse = change
            .multiply_add(change, change.constant(1.0))
            .reciprocal_sqrt();
        let turned = [
            change.negative_multiply_add(sin, cos) * inverse,
            change.multiply_add(cos, sin) * inverse,
        ];
        (second, change, turned)
    }
}

/// The contacts of a body with centre `centre`, from within or from without; at most two with a cylinder.
pub fn touch_cone(
    body: &Ellipsoid,
    centre: Vector3,
    cone: &Cone,
    within: bool,
    mut found: impl FnMut(ConeContact),
) {
    let axis = cone.axis;
    let offset = centre - cone.point;
    let height = axis.dot(offset);
    let x = offset - axis * height;
    let reach = body.bounding_radius();
    let distance = x.norm();
    let (c, s) = cone.normal_components();
    // of the centre, behind the tangent plane nearest to it
    let depth = c * (distance - cone.radius) + s * height;
    if within && depth <= -reach || !within && depth >= reach {
        return;
    }
    // The first axis of the cross-section points to the body, where there is such a direction.
    let directions = Tangent::towards(offset, axis);
    let side = if within { 1.0 } else { -1.0 };
    let mut depth = DepthInCone::new(cone, body, (axis, directions), [distance, height]);
    depth.across *= side;
    let search = Search {
        body,
        offset,
        axis,
        basis: [directions.u, directions.v],
        side,
        c,
        s,
        at_point: c * cone.radius,
        depth,
    };
    if within {
        // Behind the tangent plane c u.x + s z + reach > c R: an arc about the body's own direction.
        let least_cosine = (c * cone.radius - s * height - reach) / (c * distance);
        search.deepest_within(least_cosine, |u| found(search.contact(u, cone)));
    } else {
        let u = search.nearest_without(c * distance);
        if search.value(u) < 0.0 {
            found(search.contact(u, cone));
        }
    }
}

/// The function of the angle that is to be greatest.
struct Search<'a> {
    body: &'a Ellipsoid,
    /// The centre from the cone's point.
    offset: Vector3,
    axis: Vector3,
    /// Axes of the cross-section.
    basis: [Vector3; 2],
    /// 1 from within, -1 from without.
    side: f64,
    /// Components of the normal, from within to without, across the axis and along it.
    c: f64,
    s: f64,
    /// What the tangent planes are from the cone's point.
    at_point: f64,
    /// The function is this one from within, and minus this one, with the centre on the other side of the axis, from without. It is used
    /// where maxima are told apart, and not for their places.
    depth: DepthInCone<f64>,
}

/// What is known of an angle.
#[derive(Clone, Copy)]
struct Sample {
    angle: f64,
    cos: f64,
    sin: f64,
    /// First and second derivative of the function.
    first: f64,
    second: f64,
}

impl Search<'_> {
    /// Calls `found` with each direction, of a cosine with that of the centre that is at least so much, in which the depth has a maximum
    /// above 0.
    fn deepest_within(&self, least_cosine: f64, mut found: impl FnMut(Vector3)) {
        if self.depth.is_concave(self.body.extreme_semi_axes()) {
            if let Some(u) = self.only_maximum(least_cosine) {
                if self.value(u) > 0.0 {
                    found(u);
                }
                return;
            }
        }
        // on the axis, of no size and no sign: all around
        let cosine = if least_cosine.is_nan() {
            -1.0
        } else {
            least_cosine
        };
        self.maxima(cosine.clamp(-1.0, 1.0).acos(), |angle| {
            let u = self.direction(angle);
            if self.value(u) > 0.0 {
                found(u);
            }
        });
    }

    /// The direction of the greatest separation from the cone, `c` times the distance of the centre from the axis away.
    fn nearest_without(&self, across: f64) -> Vector3 {
        let [largest, smallest] = self.body.extreme_semi_axes();
        let differ = largest - smallest;
        // No direction gains more by the support function than the semi-axes differ, so that of the greatest separation has a cosine with
        // that of the centre of at least 1 - differ/across. There the second derivative is negative, where it is `c (u.p - c t.H t -
        // distance cos)` with the support point `p` and the Hessian `H`, as in `is_concave`: at most `largest + differ - across`.
        if across > largest + differ {
            let half = (1.0 - differ / across).acos();
            return self.direction(self.maximum([-half, half], 0.0));
        }
        let half = if self.s == 0.0 || across >= differ {
            // Within a quarter turn: in a cylinder the body reaches as far against a direction as along it. A little more, so that a maximum
            // there has two sides: all around the axis it has one at either end.
            core::f64::consts::FRAC_PI_2 + 1e-6
        } else {
            core::f64::consts::PI
        };
        let mut best: Option<(Vector3, f64)> = None;
        self.maxima(half, |angle| {
            let u = self.direction(angle);
            let value = self.value(u);
            if best.is_none_or(|(_, other)| value > other) {
                best = Some((u, value));
            }
        });
        // Where all directions are alike, by a sphere about a point of the axis, any one serves.
        best.map_or(self.basis[0], |(u, _)| u)
    }

    fn direction(&self, angle: f64) -> Vector3 {
        let (sin, cos) = angle.sin_cos();
        self.basis[0] * cos + self.basis[1] * sin
    }

    /// From within to without.
    fn normal(&self, u: Vector3) -> Vector3 {
        u * self.c + self.axis * self.s
    }

    /// From within `n.x + h(n) - c R`, from without `n.x - h(n) - c R`.
    fn value(&self, u: Vector3) -> f64 {
        let n = self.normal(u);
        let scaled = self.body.semi_axes.componentwise(self.body.to_body(n));
        n.dot(self.offset) - self.at_point + self.side * scaled.norm()
    }

    fn sample(&self, angle: f64, [cos, sin]: [f64; 2]) -> Sample {
        let (first, second) = self.depth.slopes(cos, sin);
        Sample {
            angle,
            cos,
            sin,
            first: self.side * first,
            second: self.side * second,
        }
    }

    fn sample_at(&self, angle: f64) -> Sample {
        let (sin, cos) = angle.sin_cos();
        self.sample(angle, [cos, sin])
    }

    /// How far the next angle may be from one at which the vector whose length is the support function is so long, and changes so fast; its
    /// second derivative is no longer than `bend`.
    fn stride(support: f64, speed: f64, bend: f64) -> f64 {
        // the root of |v'| t + |v''| t^2/2 = change
        let change = LARGEST_CHANGE * support;
        let stride = 2.0 * change / (speed + (speed * speed + 2.0 * bend * change).sqrt());
        // a length that rounding left no digits of makes it 0 or no number
        if stride > SHORTEST_STRIDE {
            stride.min(LONGEST_STRIDE)
        } else {
            SHORTEST_STRIDE
        }
    }

    /// Calls `found` with every maximum between minus this angle and this one.
    fn maxima(&self, half: f64, mut found: impl FnMut(f64)) {
        let bend = (self.depth.uu + self.depth.vv).sqrt();
        let [largest, smallest] = self.body.extreme_semi_axes();
        // From without there is one maximum in a body that is not deep, and any stride shows it. Of a body that is not slender the
        // shortest stride serves everywhere, which costs less than to ask for each.
        let shortest = if self.side < 0.0 {
            LONGEST_STRIDE
        } else {
            Self::stride(smallest, self.c * largest, bend)
        };
        let is_even = shortest > 0.5 * LONGEST_STRIDE;
        let (turn_sin, turn_cos) = shortest.sin_cos();
        let first = self.sample_at(-half);
        let mut left = first;
        while left.angle < half {
            let Sample { cos, sin, .. } = left;
            let stride = if is_even {
                shortest
            } else {
                let speed = self.depth.speed_squared(cos, sin).max(0.0).sqrt();
                Self::stride(self.depth.support(cos, sin), speed, bend)
            };
            let next = left.angle + stride;
            let right = if next < half && is_even {
                let turned = [
                    cos * turn_cos - sin * turn_sin,
                    sin * turn_cos + cos * turn_sin,
                ];
                self.sample(next, turned)
            } else if next < half {
                self.sample_at(next)
            } else if half == core::f64::consts::PI {
                // The same direction, so that a maximum there lies on one side of it.
                Sample {
                    angle: half,
                    ..first
                }
            } else {
                self.sample_at(half)
            };
            self.maxima_between([left, right], &mut found);
            left = right;
        }
    }

    /// The maxima of an interval.
    #[inline(always)]
    fn maxima_between(&self, interval: [Sample; 2], found: &mut impl FnMut(f64)) {
        let (changes, is_peak) = Self::changes_of_slope(&interval);
        if changes > 1 {
            self.maxima_of_halves(interval, found);
        } else if is_peak {
            found(self.peak_between(&interval));
        }
    }

    /// How often the slope may change its sign in an interval, and whether it rises at its beginning alone. A cubic has at most as many zeros as
    /// its control points change their sign (Bernstein's form).
    #[inline(always)]
    fn changes_of_slope([left, right]: &[Sample; 2]) -> (usize, bool) {
        let third = (right.angle - left.angle) / 3.0;
        let rises = [
            left.first,
            left.first + third * left.second,
            right.first - third * right.second,
            right.first,
        ]
        .map(|slope| slope > 0.0);
        let changes = rises.windows(2).filter(|pair| pair[0] != pair[1]).count();
        (changes, rises[0] && !rises[3])
    }

    /// The maximum of an interval with one.
    fn peak_between(&self, [left, right]: &[Sample; 2]) -> f64 {
        // from the zero of the chord of the slopes
        let share = left.first / (left.first - right.first);
        let start = left.angle + (right.angle - left.angle) * share;
        self.maximum([left.angle, right.angle], start)
    }

    /// The maxima of an interval in which the slope may change its sign more than once, which seldom is. Halves that are left are kept in
    /// an array: a function that calls itself has no bound on its memory that a device could know.
    #[inline(never)]
    fn maxima_of_halves(&self, interval: [Sample; 2], found: &mut impl FnMut(f64)) {
        // Of each number of halvings one is left at most, beside the one that is looked at.
        let mut left_over = [(interval, 0); MOST_HALVINGS + 1];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let (interval, halvings) = left_over[count];
            let (changes, is_peak) = Self::changes_of_slope(&interval);
            if changes > 1 && halvings < MOST_HALVINGS {
                let [left, right] = interval;
                let middle = self.sample_at(0.5 * (left.angle + right.angle));
                left_over[count] = ([middle, right], halvings + 1);
                left_over[count + 1] = ([left, middle], halvings + 1);
                count += 2;
            } else if is_peak {
                found(self.peak_between(&interval));
            }
        }
    }

    /// First and second derivative with the angle, in a direction of the cross-section.
    fn slopes(&self, u: Vector3) -> (f64, f64) {
        let t = self.axis.cross(u);
        let support = self.body.support(self.normal(u));
        // n' = c t and n'' = -c u; t.H t = |D R^T t|^2/h - (t.p)^2/h of the Hessian H of h, p its gradient.
        let along = t.dot(support.point);
        let scaled = self.body.semi_axes.componentwise(self.body.to_body(t));
        let bend = self.c * (scaled.norm_squared() - along * along) / support.h;
        (
            self.c * (t.dot(self.offset) + self.side * along),
            self.c * (self.side * (bend - u.dot(support.point)) - u.dot(self.offset)),
        )
    }

    /// The maximum between two angles, at the first of which the function rises: Newton's method from an angle, and bisection where it leaves
    /// the bracket.
    fn maximum(&self, [mut low, mut high]: [f64; 2], mut angle: f64) -> f64 {
        for _ in 0..60 {
            let (first, second) = self.slopes(self.direction(angle));
            if first > 0.0 {
                low = angle;
            } else {
                high = angle;
            }
            let newton = angle - first / second;
            let converging = second < 0.0 && newton > low && newton < high;
            let next = if converging {
                newton
            } else {
                0.5 * (low + high)
            };
            let change = (next - angle).abs();
            angle = next;
            // the error that such a step of Newton's leaves is beneath rounding
            if change < if converging { SHORTEST_STEP } else { 1e-14 } {
                break;
            }
        }
        angle
    }

    /// The maximum of a depth that is concave in the directions whose cosine with that of the centre is at least so much, by Newton's
    /// method from that of the centre; `None` where it has not settled, or elsewhere.
    fn only_maximum(&self, least_cosine: f64) -> Option<Vector3> {
        let (mut cos, mut sin) = (1.0, 0.0);
        for _ in 0..MOST_STEPS {
            let (second, change, turned) = self.depth.step(cos, sin);
            if !(second < 0.0 && change.abs() < LONGEST_STEP) {
                return None;
            }
            [cos, sin] = turned;
            // the error that such a step of Newton's leaves is beneath rounding
            if change.abs() < SHORTEST_STEP {
                let u = self.basis[0] * cos + self.basis[1] * sin;
                return (cos >= least_cosine).then_some(u);
            }
        }
        None
    }

    fn contact(&self, u: Vector3, cone: &Cone) -> ConeContact {
        let n = self.normal(u);
        let deepest = self.offset + self.body.support(n * self.side).point;
        let on_wall = deepest - n * (n.dot(deepest) - self.at_point);
        let along = self.axis.dot(on_wall);
        ConeContact {
            point: cone.point + on_wall,
            normal: n * -self.side,
            curvature_radius: (cone.radius + cone.slope * along) / self.c,
            along,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;

    fn contacts(body: &Ellipsoid, centre: Vector3, radius: f64) -> Vec<ConeContact> {
        let cylinder = Cone::cylinder(Vector3::ZERO, Vector3::new(0.0, 0.0, 1.0), radius);
        let mut all = vec![];
        let within = cylinder.has_within(centre);
        touch_cone(body, centre, &cylinder, within, |c| all.push(c));
        all
    }

    /// Bodies small and large beside the cone: with one maximum, which Newton's method finds, and with more.
    #[test]
    fn the_contacts_are_the_maxima_of_all_directions() {
        let mut state = 3u64;
        let mut uniform = |low: f64, high: f64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            low + (high - low) * (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let axis = Vector3::new(0.0, 0.6, 0.8);
        let basis = Tangent::new(axis);
        let (mut alone, mut touching) = (0, 0);
        for _ in 0..600 {
            let semi_axes = [0; 3].map(|_| uniform(0.2, 1.0));
            let body = Ellipsoid::new(semi_axes, [0; 4].map(|_| uniform(-1.0, 1.0))).unwrap();
            let cone = Cone {
                slope: uniform(-0.5, 0.5).max(0.0),
                ..Cone::cylinder(Vector3::ZERO, axis, uniform(1.2, 8.0))
            };
            let along = uniform(-0.5, 0.5);
            let radius = cone.radius + cone.slope * along;
            let outwards = basis.vector(crate::vector::Vector2::new(0.8, -0.6));
            let off_axis = (radius - uniform(0.0, 1.0)).max(0.0);
            let centre = axis * along + outwards * off_axis;
            let c = 1.0 / (1.0 + cone.slope * cone.slope).sqrt();
            let depth = |angle: f64| {
                let u = basis.u * angle.cos() + basis.v * angle.sin();
                let n = (u - axis * cone.slope) * c;
                n.dot(centre) - c * cone.radius + body.support(n).h
            };
            let step = core::f64::consts::TAU / 2000.0;
            let mut expected = vec![];
            for k in 0..2000 {
                let [a, b, c] = [-1.0, 0.0, 1.0].map(|d| depth((f64::from(k) + d) * step));
                let top = b - 0.125 * (a - c).powi(2) / (a - 2.0 * b + c);
                if b >= a && b > c && top > 0.0 {
                    expected.push(top);
                }
            }
            let mut found = vec![];
            touch_cone(&body, centre, &cone, true, |contact| {
                let n = contact.normal;
                found.push(body.support(-n).h - n.dot(centre - contact.point));
            });
            expected.sort_by(f64::total_cmp);
            found.sort_by(f64::total_cmp);
            assert_eq!(found.len(), expected.len(), "{found:?} {expected:?}");
            for (a, b) in found.iter().zip(&expected) {
                // What a parabola through three directions leaves at this step.
                assert!((a - b).abs() < 1e-7, "{found:?} {expected:?}");
            }
            touching += usize::from(!found.is_empty());
            alone += usize::from(off_axis > 5.0);
        }
        assert!(touching > 300 && alone > 50, "{touching} {alone}");
    }

    /// The depth as a function of the angle against the support function, its slopes against differences, and where they say that it has one
    /// maximum against all directions.
    #[test]
    fn the_depth_in_a_cone_and_its_slopes() {
        let axis = Vector3::new(0.48, 0.6, 0.64);
        let basis = Tangent::new(axis);
        let quaternion = [0.7, -0.3, 0.5, 0.2];
        let body = Ellipsoid::new([0.3, 0.9, 0.5], quaternion).unwrap();
        let mut concave = [0, 0];
        for slope in [0.0, 0.4, -0.3] {
            for (radius, off_axis, along) in [(2.0, 1.4, 0.3), (9.0, 8.4, -0.2), (40.0, 39.6, 0.1)]
            {
                let cone = Cone {
                    slope,
                    ..Cone::cylinder(Vector3::ZERO, axis, radius)
                };
                let centre = axis * along + basis.u * off_axis;
                let depth = DepthInCone::new(&cone, &body, (axis, basis), [off_axis, along]);
                let c = 1.0 / (1.0 + slope * slope).sqrt();
                let normal = |angle: f64| {
                    let u = basis.u * angle.cos() + basis.v * angle.sin();
                    (u - axis * slope) * c
                };
                let of = |angle: f64| {
                    let n = normal(angle);
                    body.support(n).h - (c * radius - n.dot(centre))
                };
                let mut bends_down = true;
                for k in 0..40 {
                    let angle = 0.157 * f64::from(k);
                    let (sin, cos) = angle.sin_cos();
                    let n = normal(angle);
                    let support = body.support(n);
                    let (height, h) = (depth.height(cos), depth.support(cos, sin));
                    assert!((h - support.h).abs() < 1e-13);
                    assert!((height - (c * radius - n.dot(centre))).abs() < 1e-12 * radius);
                    // Of the wall, where the body is deepest behind it.
                    let place = support.point + n * (height - h);
                    let found = depth.along(cos, sin, [height, h]);
                    assert!((found - axis.dot(place)).abs() < 1e-12 * radius);
                    let step = 1e-3;
                    let [before, now, after] = [-step, 0.0, step].map(|by| of(angle + by));
                    let (first, second) = depth.slopes(cos, sin);
                    let allowed = 1e-5 * radius;
                    assert!((first - (after - before) / (2.0 * step)).abs() < allowed);
                    let bend = (after - 2.0 * now + before) / (step * step);
                    assert!((second - bend).abs() < allowed, "{second} {bend}");
                    let (_, change, [next_cos, next_sin]) = depth.step(cos, sin);
                    assert!((change * second + first).abs() < 1e-12 * radius);
                    let turned = angle + change.atan();
                    assert!((next_cos - turned.cos()).abs() < 1e-12);
                    assert!((next_sin - turned.sin()).abs() < 1e-12);
                    let root = |angle: f64| {
                        // Of the vector as long as the support function.
                        let b = body.to_body(normal(angle));
                        Vector3::new(0.3 * b.x, 0.9 * b.y, 0.5 * b.z)
                    };
                    let speed = (root(angle + step) - root(angle - step)) * (0.5 / step);
                    let found = depth.speed_squared(cos, sin);
                    assert!((found - speed.dot(speed)).abs() < 1e-5);
                    // Where the body may touch it bends down, if so it is said.
                    bends_down &= height > h.max(0.9) || second < 0.0;
                }
                let said = depth.is_concave([0.9, 0.3]);
                assert!(bends_down || !said);
                concave[usize::from(said)] += 1;
            }
        }
        assert!(concave[0] > 0 && concave[1] > 0, "{concave:?}");
    }

    /// Beside the wall, and so deep that the body reaches across the axis.
    #[test]
    fn the_contact_from_without_is_the_greatest_separation() {
        let mut random = Random::new(11);
        let axis = Vector3::new(0.0, 0.6, 0.8);
        let basis = Tangent::new(axis);
        let (mut across, mut touching, mut apart) = (0, 0, 0);
        for k in 0..900 {
            let semi_axes = [0; 3].map(|_| random.of_any_size(0.05, 1.0));
            let body = Ellipsoid::new(semi_axes, random.quaternion()).unwrap();
            let cone = Cone {
                slope: if k % 3 == 0 {
                    0.0
                } else {
                    random.uniform(-0.5, 0.5)
                },
                ..Cone::cylinder(Vector3::ZERO, axis, random.of_any_size(0.05, 3.0))
            };
            let along = random.uniform(-0.3, 0.3);
            let radius = cone.radius + cone.slope * along;
            if radius < 0.02 {
                continue;
            }
            let turn = random.uniform(0.0, core::f64::consts::TAU);
            let outwards = basis.u * turn.cos() + basis.v * turn.sin();
            let off_axis = radius + random.uniform(0.0, 1.0).powi(3) * body.bounding_radius();
            let centre = axis * along + outwards * off_axis;
            let c = 1.0 / (1.0 + cone.slope * cone.slope).sqrt();
            let separation = |angle: f64| {
                let u = basis.u * angle.cos() + basis.v * angle.sin();
                let n = (u - axis * cone.slope) * c;
                n.dot(centre) - c * cone.radius - body.support(n).h
            };
            // All around, and closely around the best.
            let best = |(middle, half): (f64, f64)| {
                let angles = (0..=400).map(|m| middle + half * (f64::from(m) / 200.0 - 1.0));
                angles.max_by(|a, b| separation(*a).total_cmp(&separation(*b)))
            };
            let first = best((0.0, core::f64::consts::PI)).unwrap();
            let second = best((first, 0.016)).unwrap();
            let expected = separation(best((second, 1e-4)).unwrap());
            let mut found = vec![];
            touch_cone(&body, centre, &cone, false, |contact| {
                let n = contact.normal;
                found.push(n.dot(centre - contact.point) - body.support(-n).h);
            });
            let scene = format!("{body:?} {cone:?} {centre:?}");
            if expected < 0.0 {
                assert_eq!(found.len(), 1, "{expected}: {scene}");
                assert!(
                    (found[0] - expected).abs() < 1e-9,
                    "{found:?} {expected}: {scene}"
                );
                let reaches = off_axis < body.support(outwards).h;
                across += usize::from(reaches);
                touching += usize::from(!reaches);
            } else {
                assert!(found.is_empty(), "{expected} {found:?}: {scene}");
                apart += 1;
            }
        }
        println!("{across} across the axis, {touching} beside it, {apart} apart");
        assert!(across > 100 && touching > 100 && apart > 100);
    }

    /// With the centre on the axis a maximum may lie a quarter turn from the first direction.
    #[test]
    fn a_body_about_the_axis_of_a_rod() {
        let rod = Cone::cylinder(Vector3::ZERO, Vector3::new(0.0, 0.0, 1.0), 0.05);
        for semi_axes in [[0.3, 0.1, 0.2], [0.1, 0.3, 0.2]] {
            let body = Ellipsoid::new(semi_axes, [1.0, 0.0, 0.0, 0.0]).unwrap();
            let mut found = vec![];
            touch_cone(&body, Vector3::ZERO, &rod, false, |c| found.push(c));
            assert_eq!(found.len(), 1);
            let n = found[0].normal;
            let penetration = body.support(-n).h - n.dot(-found[0].point);
            assert!((penetration - 0.15).abs() < 1e-14, "{penetration}");
        }
    }

    #[test]
    fn a_point_is_within_a_cone_or_not() {
        let cone = Cone {
            slope: 0.5,
            ..Cone::cylinder(
                Vector3::new(1.0, 2.0, 3.0),
                Vector3::new(0.0, 0.0, 1.0),
                1.0,
            )
        };
        for (along, radius) in [(0.0, 1.0), (1.0, 1.5), (-1.0, 0.5)] {
            let at = |off: f64| cone.has_within(Vector3::new(1.0 + off, 2.0, 3.0 + along));
            assert!(at(0.99 * radius) && !at(1.01 * radius));
        }
    }

    /// Slender bodies that lie on the wall, in scenes of any size. A long side may be less round than the wall.
    #[test]
    fn slender_bodies_on_the_wall_in_any_units() {
        let mut random = Random::new(17);
        let axis = Vector3::new(0.48, -0.6, 0.64);
        let basis = Tangent::new(axis);
        let (mut twice, mut touching) = (0, 0);
        for k in 0..360 {
            let unit = [1.0, 1e-2, 1e2][k % 3];
            let short = [0; 2].map(|_| random.of_any_size(0.02, 0.4));
            let cone = Cone {
                slope: if k % 2 == 0 {
                    0.0
                } else {
                    random.uniform(-0.5, 0.5)
                },
                point: axis * (unit * random.uniform(-3.0, 3.0)),
                axis,
                radius: unit * random.of_any_size(1.05, 1.0 / short[0]).max(1.05),
            };
            let c = 1.0 / (1.0 + cone.slope * cone.slope).sqrt();
            // Across the axis, tilted a little in both directions.
            let outwards = basis.u * 0.6 - basis.v * 0.8;
            let sideways = axis.cross(outwards);
            let tilted =
                sideways + outwards * random.uniform(-0.2, 0.2) + axis * random.uniform(-0.2, 0.2);
            let long = tilted.normalised();
            let across = Tangent::towards(outwards, long);
            let semi_axes = [1.0, short[0], short[1]].map(|a| a * unit);
            let mut body = Ellipsoid::new(semi_axes, [1.0, 0.0, 0.0, 0.0]).unwrap();
            body.axes = [long, across.u, across.v];
            let along = unit * random.uniform(0.0, 2.0) * cone.slope.signum();
            let wall = cone.radius + cone.slope * along;
            let h = body.support(outwards).h;
            let off_axis = (wall - h * random.uniform(0.3, 1.05)).max(0.0);
            let centre = cone.point + axis * along + outwards * off_axis;
            let depth = |angle: f64| {
                let u = outwards * angle.cos() + sideways * angle.sin();
                let n = (u - axis * cone.slope) * c;
                body.support(n).h - (c * cone.radius - n.dot(centre - cone.point))
            };
            let mut found = vec![];
            touch_cone(&body, centre, &cone, true, |contact| {
                let u = -contact.normal;
                found.push(u.dot(sideways).atan2(u.dot(outwards)));
            });
            let scene = format!("{body:?} {cone:?} {centre:?} {found:?}");
            for &angle in &found {
                let value = depth(angle);
                let rounding = 1e-13 * (unit + cone.radius);
                assert!(value > -rounding, "{scene}");
                for beside in [-1e-4, 1e-4] {
                    assert!(depth(angle + beside) <= value + rounding, "{scene}");
                }
            }
            let step = core::f64::consts::TAU / 3000.0;
            let values: Vec<f64> = (0..3000).map(|k| depth(f64::from(k) * step)).collect();
            let mut expected = 0;
            for k in 0..3000 {
                let [before, here, after] = [2999, 0, 1].map(|d| values[(k + d) % 3000]);
                if here >= before && here > after && here > 1e-9 * unit {
                    expected += 1;
                    let angle = k as f64 * step;
                    let apart = |other: &f64| (0.5 * (other - angle)).sin().abs();
                    assert!(
                        found.iter().any(|a| apart(a) < 2.0 * step),
                        "{angle}: {scene}"
                    );
                }
            }
            touching += usize::from(expected > 0);
            twice += usize::from(expected > 1);
        }
        println!("{twice} of {touching} touch at two places");
        assert!(twice > 60 && touching > twice + 60);
    }

    /// A long body on the wall of a cylinder, a little less round than the wall: it touches at two places beside the middle.
    #[test]
    fn two_maxima_in_one_stride_are_told_apart() {
        let mut random = Random::new(7);
        let mut nearest = f64::INFINITY;
        for _ in 0..400 {
            let b = random.of_any_size(0.02, 0.1);
            let depth = random.uniform(0.001, 0.05) * b;
            let y = 1.0 - b + depth;
            let more = random.of_any_size(1e-6, 0.2);
            let difference = b * y * (1.0 + more);
            let body = Ellipsoid::new([(difference + b * b).sqrt(), b, b], [1.0, 0.0, 0.0, 0.0]);
            // Where h' = y sin t, h^2 = b^2 + (a^2 - b^2) sin^2 t.
            let square = y * y * (difference + b * b) / (difference * (difference + y * y));
            let angle = (1.0 - square).sqrt().asin();
            let found = contacts(&body.unwrap(), Vector3::new(0.0, y, 0.0), 1.0);
            let stride = 0.2 / 64.0;
            if angle < stride {
                assert!((1..=2).contains(&found.len()), "{angle}");
                continue;
            }
            assert_eq!(found.len(), 2, "{angle}: {found:?}");
            nearest = nearest.min(angle);
            for (contact, sign) in found.iter().zip([-1.0, 1.0]) {
                // The first direction is that of the centre, the second a quarter turn further.
                let place = contact.point.x.atan2(contact.point.y);
                assert!((place.abs() - angle).abs() < 1e-8, "{place} {angle}");
                assert!(place * sign * found[1].point.x > 0.0);
            }
        }
        assert!(nearest < 0.005);
    }

    #[test]
    fn a_sphere_in_a_cone_touches_the_nearest_side() {
        let sphere = Ellipsoid::new([0.1; 3], [1.0, 0.0, 0.0, 0.0]).unwrap();
        // radius 1 - z/2: the normal out of the wall is -(2, 0, 1)/sqrt(5)
        let cone = Cone {
            slope: -0.5,
            ..Cone::cylinder(Vector3::ZERO, Vector3::new(0.0, 0.0, 1.0), 1.0)
        };
        let (c, s) = (2.0 / 5f64.sqrt(), 1.0 / 5f64.sqrt());
        let place = Vector3::new(0.8, 0.0, 0.4);
        for (within, depth, side) in [(true, 0.09, -1.0), (false, 0.08, 1.0)] {
            let normal = Vector3::new(c, 0.0, s) * side;
            let mut all = vec![];
            touch_cone(&sphere, place + normal * depth, &cone, within, |x| {
                all.push(x)
            });
            assert_eq!(all.len(), 1);
            assert!((all[0].normal - normal).norm() < 1e-12);
            assert!((all[0].point - place).norm() < 1e-12);
            assert!((all[0].along - 0.4).abs() < 1e-12);
            assert!((all[0].curvature_radius - 0.8 / c).abs() < 1e-12);
        }
    }

    #[test]
    fn a_sphere_touches_once_on_either_side() {
        let sphere = Ellipsoid::new([0.1; 3], [1.0, 0.0, 0.0, 0.0]).unwrap();
        let inner = contacts(&sphere, Vector3::new(0.95, 0.0, 3.0), 1.0);
        assert_eq!(inner.len(), 1);
        assert!((inner[0].point - Vector3::new(1.0, 0.0, 3.0)).norm() < 1e-12);
        assert!((inner[0].normal - Vector3::new(-1.0, 0.0, 0.0)).norm() < 1e-12);
        let outer = contacts(&sphere, Vector3::new(1.05, 0.0, 3.0), 1.0);
        assert_eq!(outer.len(), 1);
        assert!((outer[0].normal - Vector3::new(1.0, 0.0, 0.0)).norm() < 1e-12);
        assert!(contacts(&sphere, Vector3::new(0.5, 0.0, 0.0), 1.0).is_empty());
    }

    #[test]
    fn a_needle_across_the_axis_touches_twice() {
        let needle = Ellipsoid::new([1.001, 0.05, 0.05], [1.0, 0.0, 0.0, 0.0]).unwrap();
        let both = contacts(&needle, Vector3::ZERO, 1.0);
        assert_eq!(both.len(), 2);
        for c in &both {
            assert!((c.point.x.abs() - 1.0).abs() < 1e-12 && c.point.y.abs() < 1e-9);
        }
        // In a wide cylinder, on its long side: both ends, or the middle if the side is rounder than the wall.
        let flat = Ellipsoid::new([0.05, 0.001, 0.001], [1.0, 0.0, 0.0, 0.0]).unwrap();
        let lying = contacts(&flat, Vector3::new(0.0, 0.9988, 0.0), 1.0);
        assert_eq!(lying.len(), 2, "{lying:?}");
        let round = Ellipsoid::new([0.02, 0.001, 0.001], [1.0, 0.0, 0.0, 0.0]).unwrap();
        assert_eq!(
            contacts(&round, Vector3::new(0.0, 0.9991, 0.0), 1.0).len(),
            1
        );
        // Off the axis: each tip beyond the wall counts, though the wall beside the centre is far.
        let off = contacts(&needle, Vector3::new(0.0, 0.3, 0.0), 1.0);
        assert_eq!(off.len(), 2);
    }
}
