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
/// Square of what may be left after the last Newton step. With steps s and then t the error goes as e -> (t/s^2) e^2, so
/// that t^3/s^2 is left after t.
const SETTLED: f64 = 1e-30;
/// Square of the step that the first one is compared with: a first step of 1e-7 is the last.
const STEP_BEFORE: f64 = 1e-8;
/// Square of that correction. It mends normal, witnesses and penetration; the curvature is left off by about this share,
/// times the square of the aspect ratio at most.
const LARGEST_CORRECTION: f64 = 1e-26;

/// Bits of the pairs that a plane separates by more than `margin`: the one of their start normal `n`, or one of those that
/// `IMPROVEMENTS` steps lead to; and the normals with the widest gaps. No steps are taken for the pairs of `stay` alone.
#[inline(always)]
pub fn separating_planes<S: Registers, B: ConvexBody<Lanes<S>>>(
    registers: S,
    i: &B,
    j: &B,
    d: Vector3<Lanes<S>>,
    mut n: Vector3<Lanes<S>>,
    margin: f64,
    stay: u32,
) -> (u32, Vector3<Lanes<S>>) {
    let zero = Lanes::splat(registers, 0.0);
    let margin = Lanes::splat(registers, margin);
    let mut apart = 0;
    let mut open = (1u32 << S::LANES) - 1;
    let mut best = n;
    let mut widest = zero.constant(f64::NEG_INFINITY);
    for left in (0..=IMPROVEMENTS).rev() {
        let ((h_i, point_i), (h_j, point_j)) = (i.support_in_world(n), j.support_in_world(n));
        let gap = n.dot(d) - h_i - h_j;
        apart |= registers.bits(margin.less(gap));
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
    let definite = registers.and((trace * trace * 1e-11).less(determinant), zero.less(trace));
    (change, change.dot(change), definite)
}

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
    let zero = Lanes::splat(registers, 0.0);
    let one = Lanes::splat(registers, 1.0);
    let base = Tangent::new(start);
    let model = TangentModel::new(i, j, d, start, &base);
    let at = model.at_base();
    let first = at.value;
    let apart = first.less(zero);
    if registers.all(apart) {
        return None;
    }
    let (y, mut hard, active) = minimise(registers, &model, at, apart);
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
    let change = inverse_hessian.apply(g) * (zero - one);
    let penetration = change.dot(g).multiply_add(one * 0.5, f);
    let converged = change
        .dot(change)
        .less(Lanes::splat(registers, LARGEST_CORRECTION));
    let size = support_i.h + support_j.h;
    let falling = penetration.less(first + size * 1e-13);

    // Deeper than half the smallest radius of curvature, Hertz' law ends: the scalar path counts such contacts.
    let twice = penetration * 2.0;
    let remaining = radii.shifted(-twice);
    let shallow = registers.and(
        zero.less(remaining.determinant()),
        zero.less(remaining.trace()),
    );
    // Any start may lead to a minimum that is not the global one: the scalar path searches where this one is not proved to be.
    let balls = i.inscribed_radius(support_i.inverse_h) + j.inscribed_radius(support_j.inverse_h);
    let mut proved = penetration.less(balls);
    let open = registers.and_not(
        registers.and(shallow, zero.less(penetration)),
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
    let separated = registers.or(apart, registers.and_not(penetration.less(zero), hard));
    support_i = moved(&support_i, radii_i, change);
    support_j = moved(&support_j, radii_j, change);
    Some(Found {
        normal: select3(apart, start, n + tangent.vector(change)),
        tangent: Tangent {
            u: n.scale_add(-change.u, tangent.u),
            v: n.scale_add(-change.v, tangent.v),
        },
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

/// Newton's method over the tangent plane: where it ends, the lanes in which it leads astray, and those in which it has not
/// ended. Lanes `apart` do not take part.
#[inline(always)]
fn minimise<S: Registers>(
    registers: S,
    model: &TangentModel<Lanes<S>>,
    mut at: TangentPoint<Lanes<S>>,
    apart: S::Mask,
) -> (Vector2<Lanes<S>>, S::Mask, S::Mask) {
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
        let moving = (last * last * SETTLED).less(square * square * square);
        active = registers.and(active, moving);
        last = square;
        step += 1;
        if registers.none(active) || step == NEWTON_STEPS {
            break;
        }
        at = model.at(y);
    }
    (y, hard, active)
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
        (trace * trace * 1e-12).less(margin.determinant()),
        penetration.constant(0.0).less(trace),
    )
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
