// SPDX-License-Identifier: MIT OR Apache-2.0
//! Whether and where a pair touches, and what the law needs of it. What is hidden is public for the kernels in `gpu/`, and no
//! interface for others.

use super::couple::{couple, Couple, TurningContact};
use super::forces::{
    contact_forces, Contact, ContactForces, MotionChange, Surface, TwistedSprings,
};
use super::history::{recall, remember, HistoryLayout, Step, NO_SPRINGS};
use super::particle::{effective_mass, Particle};
use crate::force::{hertz_factors, Factors, PairLaw, TwistingResistance, SPRINGS};
use crate::geometry::{search, ContactSearch, Ellipsoid, Outcome, Support};
use crate::vector::{Symmetric2, Tangent, Vector3};

/// Hale's form broke: the ratio `B/A`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HaleRatio(pub f64);

/// A square of a length below which it has lost its digits: the vector has no direction.
const LEAST_SQUARE: f64 = 1e-290;

/// Two spheres: the closed form.
pub(crate) fn touch_spheres(
    ri: f64,
    rj: f64,
    d: Vector3,
    i: &Ellipsoid,
    j: &Ellipsoid,
) -> ContactSearch {
    let distance = d.norm();
    // Coincident centres have no direction of their own: any one serves, and momentum is kept.
    let normal = if d.norm_squared() > LEAST_SQUARE {
        d * (1.0 / distance)
    } else {
        Vector3::new(1.0, 0.0, 0.0)
    };
    let support = |body: &Ellipsoid, r: f64| Support {
        h: r,
        inverse_h: 1.0 / r,
        point: normal * r,
        local_normal: body.to_body(normal),
    };
    ContactSearch {
        normal,
        penetration: ri + rj - distance,
        support_i: support(i, ri),
        support_j: support(j, rj),
        tangent: Tangent::new(normal),
        deep: false,
        converged: true,
    }
}

/// Hertz factors of one contact in the form that the law asks for.
#[doc(hidden)]
#[inline(always)]
pub fn factors_for(law: &PairLaw, curvature: Symmetric2) -> Factors {
    if !law.kinds.normal.elliptical {
        return Factors {
            phi: 1.0,
            sigma: 0.0,
        };
    }
    let (trace, determinant) = (curvature.trace(), curvature.determinant());
    let sigma = law.kinds.conservative || law.kinds.tangential.law.needs_material();
    if law.kinds.hale {
        // The caller has checked that Hale's form is defined here; if it were not, the exact factors would be used.
        if let Some(f) = hertz_factors::hale(trace, determinant, sigma) {
            return f;
        }
    }
    hertz_factors::exact(trace, determinant, sigma)
}

/// A body at a contact.
#[inline(always)]
fn surface(body: &Particle, support: &Support, tangent: &Tangent) -> Surface {
    Surface {
        h: support.h,
        inverse_h: support.inverse_h,
        witness: tangent.components(support.point),
        weingarten: body.body.weingarten(support, tangent),
        determinant: body.body.shape_determinant(),
        velocity: body.velocity,
        omega: body.omega,
    }
}

/// A pair after the search: geometry and motion for the law.
#[doc(hidden)]
#[inline(always)]
pub fn contact_of(found: &ContactSearch, i: &Particle, j: &Particle) -> Contact {
    let change = match (i.change, j.change) {
        (None, None) => None,
        (of_i, of_j) => {
            let changes = [of_i, of_j].map(|change| change.unwrap_or(MotionChange::NONE));
            Some(MotionChange::between(changes, j.position - i.position))
        }
    };
    let surfaces = [
        surface(i, &found.support_i, &found.tangent),
        surface(j, &found.support_j, &found.tangent),
    ];
    Contact {
        change,
        ..Contact::new(
            (found.normal, found.tangent),
            found.penetration,
            surfaces,
            effective_mass(i.inverse_mass, j.inverse_mass),
        )
    }
}

/// A body that touches a wall: `support` is that of the body along the normal into the wall, `weingarten` the curvature of the
/// wall and `velocity` its velocity there.
#[doc(hidden)]
pub fn contact_with_wall(
    i: &Particle,
    support: &Support,
    (normal, tangent): (Vector3, Tangent),
    penetration: f64,
    weingarten: Symmetric2,
    [velocity, velocity_change]: [Vector3; 2],
) -> Contact {
    let surfaces = [
        surface(i, support, &tangent),
        Surface::of_wall(weingarten, velocity),
    ];
    let of_wall = MotionChange {
        velocity: velocity_change,
        ..MotionChange::NONE
    };
    Contact {
        change: i
            .change
            .map(|change| MotionChange::between([change, of_wall], Vector3::ZERO)),
        ..Contact::new(
            (normal, tangent),
            penetration,
            surfaces,
            effective_mass(i.inverse_mass, 0.0),
        )
    }
}

/// Whether the plane with normal `n` separates a pair: one evaluation rejects.
#[inline(always)]
fn separates(i: &Particle, j: &Particle, d: Vector3, n: Vector3) -> bool {
    let h = |body: &Ellipsoid| body.semi_axes.componentwise(body.to_body(n)).norm();
    h(&i.body) + h(&j.body) < n.dot(d)
}

/// Whether and where a pair touches, from its cached normal.
#[inline(always)]
fn touch(i: &Particle, j: &Particle, d: Vector3, start: Option<Vector3>) -> Outcome {
    if i.sphere && j.sphere {
        return Outcome::Touching(touch_spheres(i.radius, j.radius, d, &i.body, &j.body));
    }
    if let Some(n) = start {
        if separates(i, j, d, n) {
            return Outcome::Separated(n);
        }
    }
    search(&i.body, &j.body, d, start)
}

/// Whether two bodies touch: the one place where this is decided, one pair at a time.
#[doc(hidden)]
pub enum Pair {
    /// They do.
    Touching(ContactSearch),
    /// They do not.
    Apart {
        /// Unit normal of a plane between the bodies; `None` where their bounding spheres do not meet.
        normal: Option<Vector3>,
        /// Whether the search found it: then it is the start of the next one.
        searched: bool,
    },
}

impl Pair {
    /// Of two bodies; `start` is the normal that the search begins with, if there is one.
    #[inline(always)]
    pub fn of(i: &Particle, j: &Particle, start: Option<Vector3>) -> Pair {
        let d = j.position - i.position;
        let reach = i.radius + j.radius;
        if d.norm_squared() >= reach * reach {
            return Pair::Apart {
                normal: None,
                searched: false,
            };
        }
        match touch(i, j, d, start) {
            Outcome::Touching(found) if found.penetration > 0.0 => Pair::Touching(found),
            Outcome::Touching(found) => Pair::Apart {
                normal: Some(found.normal),
                searched: false,
            },
            Outcome::Separated(normal) => Pair::Apart {
                normal: Some(normal),
                searched: true,
            },
        }
    }
}

/// The law of two bodies that touch as the search found, from what is remembered of them to what is to be remembered, and the
/// couple that resists rolling and twisting, which is not in the forces: the one
/// sequence of geometry, factors, memory and force for single pairs. `cached` is the normal in the history, if there is one.
/// Whether Hale's form holds is for the caller to ask ([`checked_factors`], [`hale_holds`]).
#[doc(hidden)]
#[inline(always)]
#[allow(clippy::too_many_arguments)]
pub fn law_of_pair<const FRICTION: bool, const RATE: bool>(
    law: &PairLaw,
    found: &ContactSearch,
    [i, j]: [&Particle; 2],
    layout: &HistoryLayout,
    history: &mut [f64],
    touched: bool,
    cached: Option<Vector3>,
    step: &Step,
) -> (ContactForces, Couple) {
    let x = contact_of(found, i, j);
    let factors = factors_for(law, x.curvature());
    let before = normal_before(cached, i, j, found.normal, step);
    let f = through_law::<FRICTION, RATE, true, false>(
        law, &factors, &x, layout, history, touched, before, step,
    );
    if !law.resistance.any() {
        return (f, Couple::NONE);
    }
    let turning = TurningContact::of(&x, x.curvature(), &f);
    let couple = couple(law, &turning, layout, history, touched, before, step);
    (f, couple)
}

/// The law of a touching pair, from what is remembered of it to what is to be remembered. `touched` says whether it touched at
/// the last step, `before` which normal it had then.
#[doc(hidden)]
#[inline(always)]
#[allow(clippy::too_many_arguments)]
pub fn through_law<
    const FRICTION: bool,
    const RATE: bool,
    const CONSERVATIVE: bool,
    const WALL: bool,
>(
    law: &PairLaw,
    factors: &Factors,
    x: &Contact,
    layout: &HistoryLayout,
    history: &mut [f64],
    touched: bool,
    before: Vector3,
    step: &Step,
) -> ContactForces {
    let remembered = recall(layout, history, touched, step, x.normal, before);
    let x = &Contact {
        begin_time: x.change.map(|_| step.time_step),
        ..*x
    };
    let mut springs = layout.springs_of(history);
    if !touched {
        springs = springs.map(|_| NO_SPRINGS);
    }
    let (kinds, c, m) = (&law.kinds, &law.constants, x.curvature());
    let f = if let (TwistingResistance::OfSprings, Some(springs), Some(mut torques)) = (
        law.resistance.twisting,
        &mut springs,
        layout.torques_of(history),
    ) {
        if !touched {
            torques = [0.0; SPRINGS];
        }
        let torques = &mut torques;
        let mut held = TwistedSprings { springs, torques };
        let f = contact_forces::<f64, _, FRICTION, RATE, CONSERVATIVE, WALL>(
            kinds,
            c,
            factors,
            m,
            x,
            &remembered,
            Some(&mut held),
        );
        layout.write_torques(history, Some(torques));
        f
    } else {
        contact_forces::<f64, _, FRICTION, RATE, CONSERVATIVE, WALL>(
            kinds,
            c,
            factors,
            m,
            x,
            &remembered,
            springs.as_mut(),
        )
    };
    remember(layout, history, x.normal, &f);
    layout.write_springs(history, springs.as_ref());
    f
}

/// The normal at the last step. For two spheres it follows from the motion, so that they need not remember it.
#[inline(always)]
fn normal_before(
    cached: Option<Vector3>,
    i: &Particle,
    j: &Particle,
    now: Vector3,
    step: &Step,
) -> Vector3 {
    match cached {
        Some(n) => n,
        None if i.sphere && j.sphere => {
            normal_of_spheres_before(j.position - i.position, j.velocity - i.velocity, now, step)
        }
        None => now,
    }
}

/// Of two spheres, from the way between their centres and their relative velocity.
#[doc(hidden)]
#[inline(always)]
pub fn normal_of_spheres_before(
    d: Vector3,
    velocity: Vector3,
    now: Vector3,
    step: &Step,
) -> Vector3 {
    if !step.advance_history {
        return now;
    }
    let before = d - velocity * step.time_step;
    if before.norm_squared() > LEAST_SQUARE {
        before.normalised()
    } else {
        now
    }
}

/// Hertz factors, unless the law asks for Hale's form and it breaks here.
pub(crate) fn checked_factors(law: &PairLaw, curvature: Symmetric2) -> Result<Factors, HaleRatio> {
    if law.kinds.hale {
        hale_holds(curvature)?;
    }
    Ok(factors_for(law, curvature))
}

/// Whether Hale's form has a force at this curvature; else the ratio `B/A`.
#[doc(hidden)]
pub fn hale_holds(curvature: Symmetric2) -> Result<(), HaleRatio> {
    match hertz_factors::hale(curvature.trace(), curvature.determinant(), false) {
        Some(_) => Ok(()),
        None => {
            let (a, b, _) = curvature.eigen();
            Err(HaleRatio(b / a))
        }
    }
}
