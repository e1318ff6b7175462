// SPDX-License-Identifier: MIT OR Apache-2.0
//! The contact search in lanes: a plane between two bodies, or where they touch.
//!
//! A lane that misbehaves - a Hessian that is not safely positive, a long step, a deep contact, a minimum not proved to be the
//! global one - is handed back, to be taken by the scalar path, which has the safeguards.

use crate::geometry::curvature::inverse_weingarten;
use crate::geometry::global_minimum::{inscribed_ellipsoid_margin, BodyAtNormal};
use crate::geometry::tangent_model::{TangentModel, TangentPoint};
use crate::geometry::{ConvexBody, SupportInFrame};
use crate::real::Real;
use crate::simd::{Lanes, Registers};
use crate::vector::{Symmetric2, Tangent, Vector2, Vector3};

/// Steps towards the widest gap when the candidates are chosen: the first along the line between the witnesses where
/// there is a gap, which helps from far away, the others Newton's.
const IMPROVEMENTS: usize = 6;
/// Square of a step that widens a gap by so little that it is the last.
const SHORT_STEP: f64 = 1e-5;
/// Newton steps before a lane is hard.
const NEWTON_STEPS: usize = 6;
/// Square of the step that the first one is compared with: a first step of 1e-7 is the last.
const STEP_BEFORE: f64 = 1e-8;

/// What the digits of the numbers make of the tests of the search.
struct Bounds {
    /// Square of what may be left after the last Newton step. With steps s and then t the error goes as e -> (t/s^2) e^2, so
    /// that t^3/s^2 is left after t.
    settled: f64,
    /// Square of that correction. It mends normal, witnesses and penetration; the curvature is left off by about this share,
    /// times the square of the aspect ratio at most.
    largest_correction: f64,
    /// A first step may be bent (see [`minimise`]) and be the last where its sixth power times the fourth power of the aspect ratio is less than
    /// this, the square of what it leaves.
    bent: f64,
    /// What a determinant must be of the square of its trace, at least, for a Hessian that is safely positive.
    definite: f64,
    /// The same for a proof of the global minimum.
    proof: f64,
    /// By how much the minimum may seem to be above the value that it was searched from, as a share of the bodies' sizes.
    rise: f64,
    /// Rounding of a value, as a share of the largest semi-axes.
    unknown: f64,
}

impl Bounds {
    const DOUBLE: Bounds = Bounds {
        settled: 1e-30,
        largest_correction: 1e-26,
        bent: 1e-28,
        definite: 1e-11,
        proof: 1e-12,
        rise: 1e-13,
        unknown: 0.0,
    };
    /// A gradient has a rounding of the size of the bodies, over the radius of curvature a step of 1e-7 times the square of the aspect
    /// ratio: what is left is for [`in_more_digits`].
    const SINGLE: Bounds = Bounds {
        settled: 1e-8,
        largest_correction: 1e-8,
        // A step that is short enough would leave the range of these numbers.
        bent: 0.0,
        definite: 1e-5,
        proof: 1e-5,
        rise: 2e-6,
        unknown: 1e-6,
    };

    #[inline(always)]
    fn of<S: Registers>() -> Bounds {
        if S::DIGITS < f64::MANTISSA_DIGITS {
            Bounds::SINGLE
        } else {
            Bounds::DOUBLE
        }
    }
}

/// Bits of the pairs that a plane separates by more than `margin`, also once `j` has gone the way `closing` relative to `i`: the plane of
/// their start normal `n`, or one of those that `IMPROVEMENTS` steps lead to; and the normals with the widest gaps. No steps are taken for
/// the pairs of `stay` alone.
#[inline(always)]
pub fn separating_planes<S: Registers, B: ConvexBody<Lanes<S>>>(
    registers: S,
    i: &B,
    j: &B,
    d: Vector3<Lanes<S>>,
    mut n: Vector3<Lanes<S>>,
    (margin, closing): (Lanes<S>, Vector3<Lanes<S>>),
    stay: u32,
) -> (u32, Vector3<Lanes<S>>) {
    let zero = Lanes::splat(registers, 0.0);
    let mut apart = 0;
    let mut open = (1u32 << S::LANES) - 1;
    let mut best = n;
    let mut widest = zero.constant(f64::NEG_INFINITY);
    for left in (0..=IMPROVEMENTS).rev() {
        let ((h_i, point_i), (h_j, point_j)) = (i.support_in_world(n), j.support_in_world(n));
        let gap = n.dot(d) - h_i - h_j;
        apart |= registers.bits(margin.less(gap + n.dot(closing).min(zero)));
        best = select3(widest.less(gap), n, best);
        widest = widest.max(gap);
        open &= !(apart | stay);
        if open == 0 || left == 0 {
            break;
        }
        // Between the witnesses of overlapping projections there is no way out of the bodies.
        let between = d - point_i - point_j;
        let square = between.norm_squared();
        let longer = d.norm_squared() * 1e-20;
        let leads = registers.and(longer.less(square), zero.less(gap));
        let along = between * square.max(longer).reciprocal_sqrt();
        let (newton, square, sound) = newton_step(registers, i, j, d, n);
        // A gap as wide as it gets.
        open &= !registers.bits(registers.and(sound, square.less(square.constant(SHORT_STEP))));
        n = if left == IMPROVEMENTS {
            select3(leads, along, select3(sound, newton, n))
        } else {
            select3(sound, newton, select3(leads, along, n))
        };
    }
    (apart, best)
}

/// The normal that one step of Newton's method leads to, half a radian away at most, the square of the whole step, and
/// where it can be trusted.
#[inline(always)]
fn newton_step<S: Registers, B: ConvexBody<Lanes<S>>>(
    registers: S,
    i: &B,
    j: &B,
    d: Vector3<Lanes<S>>,
    n: Vector3<Lanes<S>>,
) -> (Vector3<Lanes<S>>, Lanes<S>, S::Mask) {
    let tiny = d.x.constant(1e-290);
    let base = Tangent::new(n);
    let at = TangentModel::new(i, j, d, n, &base).at_base();
    let (change, square, definite) = newton_change(registers, &at);
    let shorter = (square.max(tiny).reciprocal_sqrt() * 0.5).min(tiny.constant(1.0));
    let turned = n + base.vector(change * shorter);
    let length = turned.norm_squared().max(tiny);
    (turned * length.reciprocal_sqrt(), square, definite)
}

/// Newton's step in the tangent plane, its square, and where the Hessian is safely positive.
#[inline(always)]
fn newton_change<S: Registers>(
    registers: S,
    at: &TangentPoint<Lanes<S>>,
) -> (Vector2<Lanes<S>>, Lanes<S>, S::Mask) {
    let zero = at.value.constant(0.0);
    let (trace, determinant) = (at.hessian.trace(), at.hessian.determinant());
    let change = at.hessian.adjugate().apply(at.gradient) * (zero - determinant.reciprocal());
    let least = trace * trace * Bounds::of::<S>().definite;
    let definite = registers.and(least.less(determinant), zero.less(trace));
    (change, change.dot(change), definite)
}

/// Square of a step from numbers with fewer digits that is too long. What it leaves of the normal goes with it.
const LONG_STEP: f64 = 1e-9;

/// What the search leaves for the law.
pub struct Found<S: Registers> {
    /// Unit normal from `i` to `j`.
    pub normal: Vector3<Lanes<S>>,
    /// Its tangent basis.
    pub tangent: Tangent<Lanes<S>>,
    /// Penetration; negative where they do not touch.
    pub penetration: Lanes<S>,
    /// Support function and witness of `i`.
    pub support_i: SupportInFrame<Lanes<S>>,
    /// The same of `j`, for the same normal.
    pub support_j: SupportInFrame<Lanes<S>>,
    /// Weingarten map of `i`.
    pub weingarten_i: Symmetric2<Lanes<S>>,
    /// Weingarten map of `j`.
    pub weingarten_j: Symmetric2<Lanes<S>>,
    /// `(W_i + W_j - delta I)^-1`.
    pub inverse_hessian: Symmetric2<Lanes<S>>,
    /// Pairs that do not touch.
    pub separated: S::Mask,
    /// Pairs that the scalar path is to look at.
    pub hard: S::Mask,
}

/// Newton's method from the start normals in the tangent plane, and one evaluation at its end; `None` where the planes of
/// the start normals separate all pairs.
#[inline(always)]
pub fn search<S: Registers, B: ConvexBody<Lanes<S>>>(
    registers: S,
    i: &B,
    j: &B,
    d: Vector3<Lanes<S>>,
    start: Vector3<Lanes<S>>,
) -> Option<Found<S>> {
    search_to::<true, S, B>(registers, i, j, d, start)
}

/// The same without the last step, which [`in_more_digits`] takes: with normal, tangent basis and supports as they were before it.
#[inline(always)]
pub fn search_nearly<S: Registers, B: ConvexBody<Lanes<S>>>(
    registers: S,
    i: &B,
    j: &B,
    d: Vector3<Lanes<S>>,
    start: Vector3<Lanes<S>>,
) -> Option<Found<S>> {
    search_to::<false, S, B>(registers, i, j, d, start)
}

#[inline(always)]
fn search_to<const LAST_STEP: bool, S: Registers, B: ConvexBody<Lanes<S>>>(
    registers: S,
    i: &B,
    j: &B,
    d: Vector3<Lanes<S>>,
    start: Vector3<Lanes<S>>,
) -> Option<Found<S>> {
    let bounds = Bounds::of::<S>();
    let zero = Lanes::splat(registers, 0.0);
    let one = Lanes::splat(registers, 1.0);
    let base = Tangent::new(start);
    let model = TangentModel::new(i, j, d, start, &base);
    let at = model.at_base();
    let first = at.value;
    // Values above this are not known to be less than none.
    let least = if bounds.unknown > 0.0 {
        (i.extreme_semi_axes()[0] + j.extreme_semi_axes()[0]) * -bounds.unknown
    } else {
        zero
    };
    let apart = first.less(least);
    if registers.all(apart) {
        return None;
    }
    let extremes = [i.extreme_semi_axes(), j.extreme_semi_axes()];
    let (y, mut hard, active) = minimise(registers, &model, at, apart, extremes);
    // Whatever is still active did not converge.
    hard = registers.or(hard, active);
    let n = (start + base.vector(y)) * (y.dot(y) + 1.0).reciprocal_sqrt();

    let tangent = Tangent::new(n);
    let (view_i, view_j) = (i.view(n, &tangent), j.view(n, &tangent));
    let mut support_i = i.support_in_frame(&view_i);
    let mut support_j = j.support_in_frame(&view_j);
    let (along, across) = (n.dot(d), tangent.components(d));
    let f = support_i.h + support_j.h - along;
    let g = support_i.witness + support_j.witness - across;
    let weingarten_i = i.weingarten_in_frame(&view_i, support_i.h);
    let weingarten_j = j.weingarten_in_frame(&view_j, support_j.h);
    let radii_i = inverse_weingarten(weingarten_i, support_i.inverse_h, i.squared_product());
    let radii_j = inverse_weingarten(weingarten_j, support_j.inverse_h, j.squared_product());
    let radii = radii_i + radii_j;
    // What is left of the gradient moves the normal and the witnesses by no more than this; the curvature stays.
    let hessian = radii.shifted(-f);
    let inverse_hessian = hessian.adjugate() * hessian.determinant().reciprocal();
    let (change, penetration) = last_step(inverse_hessian, f, g);
    let converged = change
        .dot(change)
        .less(Lanes::splat(registers, bounds.largest_correction));
    let size = support_i.h + support_j.h;
    let falling = penetration.less(first + size * bounds.rise);

    // Deeper than half the smallest radius of curvature, Hertz' law ends: the scalar path counts such contacts.
    let twice = penetration * 2.0;
    let remaining = radii.shifted(-twice);
    let shallow = registers.and(
        zero.less(remaining.determinant()),
        zero.less(remaining.trace()),
    );
    // Any start may lead to a minimum that is not the global one: the scalar path searches where this one is not proved to be.
    let balls = i.inscribed_radius(support_i.inverse_h) + j.inscribed_radius(support_j.inverse_h);
    // The plane with this normal has the value `f`; what the last step makes of it is for numbers with more digits to say.
    let (value, most) = if bounds.unknown > 0.0 {
        (f, f - least)
    } else {
        (penetration, penetration)
    };
    let mut proved = most.less(balls);
    let open = registers.and_not(
        registers.and(shallow, least.less(value)),
        registers.or(registers.or(apart, hard), proved),
    );
    if registers.any(open) {
        let at = |support: &SupportInFrame<Lanes<S>>, squared_product, radii| BodyAtNormal {
            h: support.h,
            inverse_h: support.inverse_h,
            squared_product,
            radii,
        };
        let positive = is_global_minimum(
            registers,
            &at(&support_i, i.squared_product(), radii_i),
            &at(&support_j, j.squared_product(), radii_j),
            penetration,
            across,
        );
        proved = registers.or(proved, registers.and(positive, zero.less(along)));
    }
    // Without a start there is no normal.
    let started = (one * 0.5).less(start.norm_squared());
    let sound = registers.and(
        registers.and(converged, falling),
        registers.and(registers.and(shallow, proved), started),
    );
    hard = registers.or(hard, registers.not(sound));
    let separated = registers.or(apart, registers.and_not(value.less(least), hard));
    let (mut normal, mut basis) = (n, tangent);
    if LAST_STEP {
        support_i = moved(&support_i, radii_i, change);
        support_j = moved(&support_j, radii_j, change);
        normal = select3(apart, start, n + tangent.vector(change));
        basis = turned(n, &tangent, change);
    }
    Some(Found {
        normal,
        tangent: basis,
        penetration,
        support_i,
        support_j,
        weingarten_i,
        weingarten_j,
        inverse_hessian,
        separated,
        hard: registers.and_not(hard, separated),
    })
}

/// Newton's step from a normal where the value is `f` and the gradient `g`, and the value that it leads to.
#[inline(always)]
fn last_step<T: Real>(inverse_hessian: Symmetric2<T>, f: T, g: Vector2<T>) -> (Vector2<T>, T) {
    let change = inverse_hessian.apply(g) * f.constant(-1.0);
    (change, change.dot(g).multiply_add(f.constant(0.5), f))
}

/// A contact that numbers with fewer digits have led to, with its normal, its penetration and its witnesses in these: one step of
/// Newton's method, for which value and gradient are those of the bodies `i` and `j`, here as they are. The Weingarten maps, in the
/// tangent basis [`Tangent::new`] of the normal, and the inverse of the Hessian stay as they were found. A pair is hard where the step is long,
/// and where it alone says that they do not touch; separated where the plane with the given normal separates it.
#[inline(always)]
pub fn in_more_digits<S: Registers, B: ConvexBody<Lanes<S>>>(
    registers: S,
    i: &B,
    j: &B,
    d: Vector3<Lanes<S>>,
    normal: Vector3<Lanes<S>>,
    [weingarten_i, weingarten_j]: [Symmetric2<Lanes<S>>; 2],
    inverse_hessian: Symmetric2<Lanes<S>>,
) -> Found<S> {
    let zero = Lanes::splat(registers, 0.0);
    let n = normal.normalised();
    let tangent = Tangent::new(n);
    let support_i = i.support_in_frame(&i.view(n, &tangent));
    let support_j = j.support_in_frame(&j.view(n, &tangent));
    let f = support_i.h + support_j.h - n.dot(d);
    let g = support_i.witness + support_j.witness - tangent.components(d);
    let (change, penetration) = last_step(inverse_hessian, f, g);
    let long = Lanes::splat(registers, LONG_STEP);
    let separated = f.less(zero);
    let known = registers.and(change.dot(change).less(long), zero.less(penetration));
    let hard = registers.and_not(registers.not(known), separated);
    let radii_i = inverse_weingarten(weingarten_i, support_i.inverse_h, i.squared_product());
    let radii_j = inverse_weingarten(weingarten_j, support_j.inverse_h, j.squared_product());
    Found {
        normal: n + tangent.vector(change),
        tangent: turned(n, &tangent, change),
        penetration,
        support_i: moved(&support_i, radii_i, change),
        support_j: moved(&support_j, radii_j, change),
        weingarten_i,
        weingarten_j,
        inverse_hessian,
        separated,
        hard,
    }
}

/// Newton's method over the tangent plane: where it ends, the lanes in which it leads astray, and those in which it has not
/// ended. Lanes `apart` do not take part. `extremes` are the largest and the smallest semi-axis of both bodies.
///
/// The normal of the last step is close: mostly one step is the last once it is bent, as the third derivatives at its beginning say (the method of
/// Chebyshev), and what it leaves goes with its third power, times the square of the aspect ratio at most.
#[inline(always)]
fn minimise<S: Registers>(
    registers: S,
    model: &TangentModel<Lanes<S>>,
    mut at: TangentPoint<Lanes<S>>,
    apart: S::Mask,
    extremes: [[Lanes<S>; 2]; 2],
) -> (Vector2<Lanes<S>>, S::Mask, S::Mask) {
    let bounds = Bounds::of::<S>();
    let zero = Lanes::splat(registers, 0.0);
    let one = Lanes::splat(registers, 1.0);
    let mut y = Vector2::new(zero, zero);
    let mut hard = registers.no_lane();
    let mut active = registers.not(apart);
    let mut step = 0;
    let mut last = Lanes::splat(registers, STEP_BEFORE);
    loop {
        let (change, square, definite) = newton_change(registers, &at);
        let good = registers.and(definite, square.less(one * 0.25));
        hard = registers.or(hard, registers.and_not(active, good));
        active = registers.and(active, good);
        y = Vector2::new(
            Lanes::select(active, y.u + change.u, y.u),
            Lanes::select(active, y.v + change.v, y.v),
        );
        let cube = square * square * square;
        let moving = (last * last * bounds.settled).less(cube);
        active = registers.and(active, moving);
        if step == 0 && bounds.bent > 0.0 && registers.any(active) {
            let [i, j] = extremes;
            let short = registers.and(
                is_short(cube, i, bounds.bent),
                is_short(cube, j, bounds.bent),
            );
            let bend = solved(&at, model.bend_at_base(y));
            let bent = registers.and(active, short);
            y = Vector2::new(
                Lanes::select(bent, y.u + bend.u, y.u),
                Lanes::select(bent, y.v + bend.v, y.v),
            );
            active = registers.and_not(active, bent);
        }
        last = square;
        step += 1;
        if registers.none(active) || step == NEWTON_STEPS {
            break;
        }
        at = model.at(y);
    }
    (y, hard, active)
}

/// Where the sixth power of a step is short for a body with these extreme semi-axes.
#[inline(always)]
fn is_short<S: Registers>(
    cube: Lanes<S>,
    [most, least]: [Lanes<S>; 2],
    bound: f64,
) -> <Lanes<S> as Real>::Mask {
    let (most, least) = (most * most, least * least);
    (cube * (most * most)).less(least * least * bound)
}

/// Minus the inverse of the Hessian times a vector.
#[inline(always)]
fn solved<T: Real>(at: &TangentPoint<T>, v: Vector2<T>) -> Vector2<T> {
    let minus_inverse = at.hessian.determinant().reciprocal() * -at.value.constant(1.0);
    at.hessian.adjugate().apply(v) * minus_inverse
}

/// Where an ellipsoid inside the Minkowski sum proves the minimum to be the global one.
#[inline(always)]
fn is_global_minimum<S: Registers>(
    registers: S,
    i: &BodyAtNormal<Lanes<S>>,
    j: &BodyAtNormal<Lanes<S>>,
    penetration: Lanes<S>,
    across: Vector2<Lanes<S>>,
) -> S::Mask {
    let margin = inscribed_ellipsoid_margin(i, j, penetration, across);
    let trace = margin.trace();
    registers.and(
        (trace * trace * Bounds::of::<S>().proof).less(margin.determinant()),
        penetration.constant(0.0).less(trace),
    )
}

/// The tangent basis of the normal that a small change leads to.
#[inline(always)]
fn turned<T: Real>(n: Vector3<T>, tangent: &Tangent<T>, change: Vector2<T>) -> Tangent<T> {
    Tangent {
        u: n.scale_add(-change.u, tangent.u),
        v: n.scale_add(-change.v, tangent.v),
    }
}

/// Support function and witness for the normal and the basis that a small change of the normal leads to.
#[inline(always)]
fn moved<T: Real>(
    support: &SupportInFrame<T>,
    radii: Symmetric2<T>,
    change: Vector2<T>,
) -> SupportInFrame<T> {
    let witness = support.witness;
    SupportInFrame {
        h: witness
            .u
            .multiply_add(change.u, witness.v.multiply_add(change.v, support.h)),
        inverse_h: support.inverse_h,
        witness: change.scale_add(-support.h, witness + radii.apply(change)),
    }
}

/// Two spheres: the closed form.
#[inline(always)]
pub fn search_spheres<S: Registers, B: ConvexBody<Lanes<S>>>(
    registers: S,
    i: &B,
    j: &B,
    d: Vector3<Lanes<S>>,
) -> Option<Found<S>> {
    let zero = Lanes::splat(registers, 0.0);
    let square = d.norm_squared();
    let least = Lanes::splat(registers, 1e-290);
    let normal = d * square.max(least).reciprocal_sqrt();
    let ((r_i, curvature_i), (r_j, curvature_j)) = (i.radius_of_sphere(), j.radius_of_sphere());
    let penetration = r_i + r_j - square.sqrt();
    let separated = penetration.less(zero);
    if registers.all(separated) {
        return None;
    }
    let none = Vector2::new(zero, zero);
    Some(Found {
        normal,
        tangent: Tangent::new(normal),
        penetration,
        support_i: SupportInFrame {
            h: r_i,
            inverse_h: curvature_i,
            witness: none,
        },
        support_j: SupportInFrame {
            h: r_j,
            inverse_h: curvature_j,
            witness: none,
        },
        weingarten_i: Symmetric2::new(curvature_i, zero, curvature_i),
        weingarten_j: Symmetric2::new(curvature_j, zero, curvature_j),
        // The conservative law, which alone asks for it, adds nothing.
        inverse_hessian: Symmetric2::new(zero, zero, zero),
        separated,
        // Coincident centres have no direction.
        hard: square.less(least),
    })
}

#[inline(always)]
pub(crate) fn select3<S: Registers>(
    mask: S::Mask,
    a: Vector3<Lanes<S>>,
    b: Vector3<Lanes<S>>,
) -> Vector3<Lanes<S>> {
    Vector3::new(
        Lanes::select(mask, a.x, b.x),
        Lanes::select(mask, a.y, b.y),
        Lanes::select(mask, a.z, b.z),
    )
}

#[cfg(all(test, feature = "std"))]
mod tests {
    use super::*;
    use crate::geometry::random::Random;
    use crate::geometry::Ellipsoid;
    use crate::simd::{InstructionSet, Stage, MOST_LANES};

    /// Two bodies that touch with this normal, from the centre of `i` to that of `j`.
    struct Touching {
        i: Ellipsoid,
        j: Ellipsoid,
        d: Vector3,
        normal: Vector3,
        aspect_ratio: f64,
    }

    fn touching(random: &mut Random, most_slender: f64) -> Touching {
        let mut body = || {
            let long = random.of_any_size(1.0, most_slender);
            let wide =
                [1.0, random.uniform(1.0, long)][usize::from(random.uniform(0.0, 1.0) > 0.5)];
            let axes =
                [[long, wide, 1.0], [1.0, long, long]][usize::from(random.uniform(0.0, 1.0) > 0.7)];
            (Ellipsoid::new(axes, random.quaternion()).unwrap(), long)
        };
        let ((i, a), (j, b)) = (body(), body());
        let normal = random.direction();
        let aspect_ratio = f64::max(a, b);
        // Far from half the smallest radius of curvature.
        let penetration = 1e-3 / aspect_ratio;
        let d = i.support(normal).point + j.support(normal).point - normal * penetration;
        Touching {
            i,
            j,
            d,
            normal,
            aspect_ratio,
        }
    }

    fn splat3<S: Registers>(registers: S, v: Vector3) -> Vector3<Lanes<S>> {
        crate::contact::vectors_in_lanes::splat(registers, v)
    }

    fn splat_body<S: Registers>(registers: S, body: &Ellipsoid) -> Ellipsoid<Lanes<S>> {
        Ellipsoid {
            axes: body.axes.map(|axis| splat3(registers, axis)),
            semi_axes: splat3(registers, body.semi_axes),
            inverse_semi_axes: splat3(registers, body.inverse_semi_axes),
        }
    }

    /// Searches from normals that are off by an angle, in as many directions as there are lanes: how many lanes are hard, and the largest error of
    /// the normals of the others.
    struct FromAside<'a> {
        pair: &'a Touching,
        angle: f64,
        hard: &'a mut u32,
        error: &'a mut f64,
    }

    impl Stage for FromAside<'_> {
        fn run<S: Registers>(self, registers: S) {
            let FromAside { pair, angle, .. } = self;
            let tangent = Tangent::new(pair.normal);
            let mut starts = [[0.0; MOST_LANES]; 3];
            for lane in 0..S::LANES {
                let (sin, cos) =
                    (0.3 + std::f64::consts::TAU * lane as f64 / S::LANES as f64).sin_cos();
                let aside = tangent.vector(Vector2::new(cos, sin)) * angle;
                let start = (pair.normal + aside).normalised().to_array();
                for (row, x) in starts.iter_mut().zip(start) {
                    row[lane] = x;
                }
            }
            let [x, y, z] = [0, 1, 2].map(|k| Lanes::load(registers, &starts[k]));
            let (i, j) = (
                splat_body(registers, &pair.i),
                splat_body(registers, &pair.j),
            );
            let d = splat3(registers, pair.d);
            let found = search(registers, &i, &j, d, Vector3::new(x, y, z)).expect("they touch");
            assert_eq!(registers.bits(found.separated), 0);
            let hard = registers.bits(found.hard);
            *self.hard = hard.count_ones();
            let normal = [found.normal.x, found.normal.y, found.normal.z].map(|x| {
                let mut line = [0.0; MOST_LANES];
                x.store(&mut line);
                line
            });
            *self.error = (0..S::LANES)
                .filter(|lane| hard >> lane & 1 == 0)
                .map(|lane| {
                    (Vector3::new(normal[0][lane], normal[1][lane], normal[2][lane]) - pair.normal)
                        .norm()
                })
                .fold(0.0, f64::max);
        }
    }

    /// A first step as long as one that is bent may be, and ones that are a little longer and much shorter: as exact as from the normal itself, and
    /// none for the scalar path.
    #[test]
    fn one_bent_step_is_enough() {
        let mut random = Random::new(20);
        for most_slender in [1.2, 3.0, 30.0, 300.0] {
            for _ in 0..400 {
                let pair = touching(&mut random, most_slender);
                let square = pair.aspect_ratio * pair.aspect_ratio;
                let longest = (Bounds::DOUBLE.bent / (square * square)).powf(1.0 / 6.0);
                for set in InstructionSet::ALL
                    .into_iter()
                    .filter(|set| set.is_available())
                {
                    let from = |angle: f64| {
                        let (mut hard, mut error) = (0, 0.0);
                        set.run(FromAside {
                            pair: &pair,
                            angle,
                            hard: &mut hard,
                            error: &mut error,
                        });
                        (hard, error)
                    };
                    let (_, rounding) = from(0.0);
                    for share in [0.01, 0.3, 0.99, 1.01, 3.0] {
                        let (hard, error) = from(share * longest);
                        // Of more slender ones rounding alone makes some.
                        assert!(
                            hard == 0 || most_slender > 30.0,
                            "aspect ratio {}",
                            pair.aspect_ratio
                        );
                        let allowed = 4.0 * rounding + 1e-15 * square;
                        assert!(
                            error <= allowed,
                            "aspect ratio {}, {share} of the longest: {error:e}, {rounding:e}",
                            pair.aspect_ratio
                        );
                    }
                }
            }
        }
    }
}
