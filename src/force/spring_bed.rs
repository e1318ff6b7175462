// SPDX-License-Identifier: MIT OR Apache-2.0
//! Partial slip with its loop: a bed of springs with Coulomb's limit, `displacement hysteretic` (docs/theory.md, section 4.1).
//!
//! A contact of penetration `d` with the normal force `N(d)` is a bed of independent springs (Jaeger 1995; Popov and Hess 2015). The
//! spring that begins to carry at the penetration `z` has the normal stiffness `N''(z) dz`, a tangential stiffness in proportion, and
//! slides where its tangential force is `mu` times its own normal force. At a steady normal force the sum is the curve of Cattaneo and
//! Mindlin for loading, and Masing's curves for unloading and reloading; where normal and tangential displacement change at once it is
//! what Jaeger found for any history.
//!
//! Here the springs between two edges are one element: a spring and a slider. The edges are `(k/8)^(4/3)` of a reference penetration,
//! by which the corners of the curve are equally far from it at its begin and at its end. The reference is that of first touch, times
//! `2^(4/3)` as often as the contact outgrows it: the edges of the new grid are edges of the old one, and two elements become one. A
//! contact that shrank until two elements are left divides them again. So four to eight elements carry.
//!
//! No cycle gives work: each element is a spring whose force is reduced with its stiffness, merging and dividing elements creates no
//! energy, and what all hold is never more than was remembered and the work done on them.

use super::hertz_factors::Factors;
use super::tangential::{
    within, TangentialConstants, TangentialForce, TangentialKinds, WithoutSlip,
};
use crate::real::Real;
use crate::vector::{Symmetric2, Vector2};

/// Elements of a contact.
pub const SPRINGS: usize = 8;

/// `(k/8)^(2/3)`: roots of the edges over that of the reference penetration.
const EDGES: [f64; SPRINGS + 1] = [
    0.0,
    0.25,
    0.396_850_262_992_049_9,
    0.520_020_955_762_976,
    0.629_960_524_947_436_6,
    0.731_004_434_553_216_5,
    0.825_481_812_223_656_7,
    0.914_826_427_505_742_8,
    1.0,
];

/// By how much the reference penetration grows: `2^(4/3)`, which takes the edge `2 k` to where `k` was.
const GROWTH: f64 = 2.519_842_099_789_746_3;

/// How often it grows or falls in one step at most. After three times all that was there is in the first element.
const MOST_GROWTHS: usize = 3;
const MOST_FALLS: usize = 2;

/// What is remembered of the bed; vectors in the tangent basis or in the world frame.
#[derive(Clone, Copy, Debug)]
pub struct Springs<V, T = f64> {
    /// Force of each element, the first of which begins to carry first. Of the sign of the memory of the other laws: `-1` times
    /// the force on body `j`.
    pub forces: [V; SPRINGS],
    /// The reference penetration; 0 where nothing is remembered.
    pub reference: T,
    /// The penetration at the last step.
    pub penetration: T,
}

/// How stiffness and limit of a bed are spread over its elements. With `r^2 = z/d` at an edge `z`, what the elements up to it have.
pub(super) trait Spread<T> {
    /// Their share in the stiffness.
    fn stiffness(r: T) -> T;
    /// Their share in the limit.
    fn load(r: T) -> T;
    /// The ratio of two stiffnesses of the whole bed, from the root of the ratio of the penetrations.
    fn ratio(root: T) -> T;
}

/// Of the tangential force: the limit goes with the normal force.
pub(super) struct OfForce;

impl<T: Real> Spread<T> for OfForce {
    #[inline(always)]
    fn stiffness(r: T) -> T {
        r
    }
    /// `(3 r - r^3)/2`.
    #[inline(always)]
    fn load(r: T) -> T {
        let one = r.constant(1.0);
        r * (r * r).negative_multiply_add(one * 0.5, one * 1.5)
    }
    #[inline(always)]
    fn ratio(root: T) -> T {
        root
    }
}

/// Shares of the elements in stiffness and in limit; their sums are 1.
pub(super) struct Shares<T> {
    pub stiffness: [T; SPRINGS],
    pub load: [T; SPRINGS],
}

impl<T: Real> Shares<T> {
    /// At a penetration that is at most the reference, but for rounding.
    #[inline(always)]
    fn of<B: Spread<T>>(reference: T, penetration: T) -> Self {
        let zero = penetration.constant(0.0);
        let one = penetration.constant(1.0);
        let least = (reference * 1e-12).max(penetration.constant(1e-300));
        let scale = (reference / penetration.max(least)).sqrt();
        let (mut stiffness, mut load) = ([zero; SPRINGS], [zero; SPRINGS]);
        let (mut resisted, mut carried) = (zero, zero);
        for k in 0..SPRINGS {
            let outer = if k + 1 == SPRINGS {
                one
            } else {
                (scale * EDGES[k + 1]).min(one)
            };
            let (resists, carries) = (B::stiffness(outer), B::load(outer));
            stiffness[k] = resists - resisted;
            load[k] = carries - carried;
            (resisted, carried) = (resists, carries);
        }
        Shares { stiffness, load }
    }
}

#[inline(always)]
fn select<T: Real>(mask: T::Mask, a: Vector2<T>, b: Vector2<T>) -> Vector2<T> {
    Vector2::new(T::select(mask, a.u, b.u), T::select(mask, a.v, b.v))
}

/// Least share that is divided by. An element of less carries nothing.
pub(super) const LEAST_SHARE: f64 = 1e-30;

impl<T: Real> Springs<Vector2<T>, T> {
    /// The bed of a contact of this penetration, before it is moved: what left the contact has taken its force with it. Returns the
    /// shares of its elements. Where no time `passes` the elements stay what they are: the contact is as deep as it was but for rounding.
    #[inline(always)]
    pub(super) fn follow<B: Spread<T>>(&mut self, penetration: T, passes: T::Mask) -> Shares<T> {
        let zero = penetration.constant(0.0);
        let one = penetration.constant(1.0);
        let none = Vector2::new(zero, zero);
        let reference = T::select(zero.less(self.reference), self.reference, penetration);
        let before = T::select(zero.less(self.penetration), self.penetration, penetration);
        let (mut forces, mut reference) = (self.forces, reference);
        let deepest = T::select(passes, penetration, zero);
        for _ in 0..MOST_GROWTHS {
            let outgrown = reference.less(deepest);
            let mut merged = [none; SPRINGS];
            for (both, two) in merged.iter_mut().zip(forces.chunks_exact(2)) {
                *both = two[0] + two[1];
            }
            for (force, both) in forces.iter_mut().zip(merged) {
                *force = select(outgrown, both, *force);
            }
            reference = T::select(outgrown, reference * GROWTH, reference);
        }
        reference = T::select(reference.less(deepest), penetration, reference);

        let was = Shares::of::<B>(reference, before);
        let mut now = Shares::of::<B>(reference, penetration);
        // The stiffness of an element goes with its share and that of the bed.
        let stiffer = B::ratio((penetration / before.max(penetration * 1e-12)).sqrt());
        for ((force, share), share_before) in
            forces.iter_mut().zip(now.stiffness).zip(was.stiffness)
        {
            let kept = share * stiffer / share_before.max(one * LEAST_SHARE);
            *force = *force * kept.min(one);
        }

        for _ in 0..MOST_FALLS {
            // Only the first two elements carry.
            let least = T::select(passes, penetration * (GROWTH * GROWTH), reference);
            let shrank = least.less(reference);
            let finer = T::select(shrank, reference * (1.0 / GROWTH), reference);
            let shares = Shares::of::<B>(finer, penetration);
            let old = forces;
            for k in 0..SPRINGS / 2 {
                let both = shares.stiffness[2 * k] + shares.stiffness[2 * k + 1];
                let inner =
                    old[k] * (shares.stiffness[2 * k] / both.max(one * LEAST_SHARE)).min(one);
                forces[2 * k] = select(shrank, inner, old[2 * k]);
                forces[2 * k + 1] = select(shrank, old[k] + inner * -one, old[2 * k + 1]);
            }
            reference = finer;
            now = shares;
        }
        *self = Springs {
            forces,
            reference,
            penetration,
        };
        now
    }

    /// Elastic energy of the elements: each is a spring with its share of the stiffness.
    #[inline(always)]
    pub(super) fn energy(&self, without_slip: &WithoutSlip<T>, shares: &Shares<T>) -> T {
        let mut energy = self.penetration.constant(0.0);
        for (&force, &share) in self.forces.iter().zip(&shares.stiffness) {
            let share = share.max(self.penetration.constant(LEAST_SHARE));
            energy = energy + without_slip.double_energy(force) * 0.5 / share;
        }
        energy
    }

    #[inline(always)]
    pub(super) fn force(&self) -> Vector2<T> {
        let mut sum = self.forces[0];
        for f in &self.forces[1..] {
            sum = sum + *f;
        }
        sum
    }
}

/// The part of the whole limit below which an element sticks, that has this share in the stiffness and this one in the limit. One that slides is on its
/// limit but for rounding, at the next evaluation too. The share in the limit of a narrow element at the rim is a small difference: what
/// `rounding` leaves in it goes with its width, as its share in the stiffness does.
#[inline(always)]
pub(super) fn sticks_below<T: Real>(stiffness: T, load: T, rounding: T) -> T {
    let of_shares = stiffness * rounding * 4.0 + 1e-15;
    load * (1.0 - 1e-9) - of_shares
}

/// Tangential force of `displacement hysteretic`; the arguments are those of [`tangential_force`](super::tangential_force), and
///
/// - `rounding`: read in each call;
/// - `penetration` > 0;
/// - `memory`: the sum of the remembered forces, returned where no time passes;
/// - `springs`: what is remembered, in the tangent basis; written.
///
/// # Example
/// Two balls of radius 1 cm, 10 micrometres deep in one another, slide by two micrometres and one back: there the force is less than on the
/// way out, though nothing slid as a whole (SI units).
/// ```
/// use ellgran::force::syntax::parse;
/// use ellgran::force::{force_of_springs, hertz_factors, normal_force, PairLaw, Springs, SPRINGS};
/// use ellgran::vector::{Symmetric2, Vector2};
///
/// let words = "hertz 1e7 0.3 tangential tfd 0.5 displacement hysteretic";
/// let (parameters, _) = parse(&words.split(' ').collect::<Vec<_>>())?;
/// let law = PairLaw::resolve(&parameters, &parameters)?;
/// let (kinds, constants) = (&law.kinds, &law.constants);
/// let curvature = Symmetric2::new(100.0, 0.0, 100.0);
/// let factors = hertz_factors::exact(curvature.trace(), curvature.determinant(), true);
/// let (depth, det) = (1e-5, curvature.determinant());
/// let n = normal_force(&kinds.normal, &constants.normal, depth, 0.0, det, &factors, 1.0);
///
/// let none = Vector2::new(0.0, 0.0);
/// let mut springs = Springs { forces: [none; SPRINGS], reference: 0.0, penetration: 0.0 };
/// let (mut memory, mut energy) = (none, 0.0);
/// let mut slide = |by: f64| {
///     let t = force_of_springs(
///         &kinds.tangential, &constants.tangential, (n.force, n.stiffness, 0.0), &factors, curvature, depth,
///         &mut springs, memory, energy, true, Vector2::new(by, 0.0), none,
///     );
///     (memory, energy) = (t.memory, t.elastic_energy);
///     -t.force.u
/// };
/// let out = slide(1e-6);
/// let farthest = slide(1e-6);
/// let back = slide(-1e-6);
/// assert!(farthest < 0.5 * n.force);
/// assert!(0.0 < back && back < 0.98 * out);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[inline(always)]
#[allow(clippy::too_many_arguments)]
pub fn force_of_springs<T: Real>(
    kinds: &TangentialKinds,
    c: &TangentialConstants<T>,
    (normal_force, normal_stiffness, rounding): (T, T, T),
    factors: &Factors<T>,
    curvature: Symmetric2<T>,
    penetration: T,
    springs: &mut Springs<Vector2<T>, T>,
    memory: Vector2<T>,
    remembered_energy: T,
    passes: T::Mask,
    increment: Vector2<T>,
    velocity: Vector2<T>,
) -> TangentialForce<T> {
    let zero = normal_force.constant(0.0);
    let one = normal_force.constant(1.0);
    let tiny = normal_force.constant(1e-300);
    let least = normal_force.constant(1e-290);
    let limit = c.friction * normal_force.max(zero);
    let without_slip = WithoutSlip::of_ellipse(c, factors, curvature, normal_stiffness);

    let mut bed = *springs;
    let shares = bed.follow::<OfForce>(penetration, passes);
    // The present contact may hold more at these forces than it took: its ellipse turned or changed.
    let holds = bed
        .energy(&without_slip, &shares)
        .max(tiny)
        .min(one * 1e300);
    let ratio = remembered_energy / holds;
    let ratio = T::select(passes, ratio.min(one).max(zero), one);
    let moved = without_slip.stiffness.apply(increment);
    let mut sticking = zero;
    for k in 0..SPRINGS {
        let trial = moved.scale_add(shares.stiffness[k], bed.forces[k] * ratio);
        let carries = limit * shares.load[k];
        let square = trial.dot(trial);
        let inverse = square.max(least).reciprocal_sqrt();
        let size = square * inverse;
        let over = carries.less(size);
        bed.forces[k] = trial * T::select(over, carries * inverse, one);
        let sticks = size.less(limit * sticks_below(shares.stiffness[k], shares.load[k], rounding));
        sticking = sticking + T::select(sticks, shares.stiffness[k], zero);
    }
    let elastic = bed.force();
    let mut force = elastic;
    if kinds.viscous {
        let sticking_stiffness = normal_stiffness * sticking;
        let viscous =
            without_slip.viscous_force(c, factors, curvature, sticking_stiffness, velocity);
        force = within(limit, force + viscous);
    }
    let energy = bed.energy(&without_slip, &shares);
    for k in 0..SPRINGS {
        springs.forces[k] = select(passes, bed.forces[k], springs.forces[k]);
    }
    springs.reference = T::select(passes, bed.reference, springs.reference);
    springs.penetration = T::select(passes, penetration, springs.penetration);
    TangentialForce {
        force: force * -one,
        elastic_force: elastic * -one,
        memory: select(passes, elastic, memory),
        displacement: without_slip.displacement(elastic),
        elastic_energy: T::select(passes, energy, remembered_energy),
    }
}
