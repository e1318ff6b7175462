// SPDX-License-Identifier: MIT OR Apache-2.0
//! The contact of a pair with its search in single precision, for a GPU that is slow with doubles.
//!
//! - In double precision: the way between the centres, once more support functions and gradient at the normal that was found, one step of
//!   Newton's method from there, the law and the history.
//! - In single precision: the search, which leaves the normal, the curvatures and the inverse of the Hessian; Hertz factors; and the
//!   further terms of the conservative law, which are geometry times the energy.
//!
//! The penetration, a small difference of lengths, so has an error of the second order in what single precision leaves of the normal.
//! Where single precision is not enough to tell, the pair is marked, as is one that the search hands back: it never misses a contact.
//!
//! The law stays in double precision. Its tangential part is a memory, to which each step adds little. In single precision an increment
//! below 6e-8 of it would vanish, and the energy that `displacement rescaled` compares in each step would be given up by as much.

use crate::candidates::Candidate;
use crate::contacts::{direction, factors, forces, part, relative, Outcome, Scene, TOUCHES};
use crate::one_lane::{basis_of, tangential_of, vector, vector_of, OneLane};
use crate::one_single::{
    double, double_matrix, double_tangential, double_vector, single, single_vector, OneSingle,
    Single, Unit,
};
use crate::shapes::Kind;
use crate::terms::ContactLoad;
use ellgran::contact::forces::{EnergyGradient, Surface};
use ellgran::contact::history::cached_normal;
use ellgran::contact::lane_search::{in_more_digits, search_nearly, Found};
use ellgran::contact::Contact;
use ellgran::force::Factors;
use ellgran::geometry::ConvexBody;
use ellgran::vector::{Tangent, Vector2, Vector3};

/// A semi-axis in units of the pair below which powers of it leave single precision.
const LEAST_SEMI_AXIS: f64 = 1e-5;

/// The contact of a pair, as [`crate::contacts::contact_of_pair`] has it in double precision.
#[inline(always)]
pub fn mixed_contact_of_pair<
    K: Kind,
    const FRICTION: bool,
    const RATE: bool,
    const CONSERVATIVE: bool,
>(
    scene: &Scene<'_>,
    candidate: &Candidate,
    state: &mut u32,
    history: &mut [f64],
) -> Option<ContactLoad> {
    let touched = *state & TOUCHES != 0;
    one_pair::<K, FRICTION, RATE, CONSERVATIVE>(scene, candidate, history, touched).noted(state)
}

#[inline(always)]
fn one_pair<K: Kind, const FRICTION: bool, const RATE: bool, const CONSERVATIVE: bool>(
    scene: &Scene<'_>,
    candidate: &Candidate,
    history: &mut [f64],
    touched: bool,
) -> Outcome {
    let layout = &scene.layout;
    let [i, j] = candidate.pair();
    let (a, b) = (&scene.grains[i], &scene.grains[j]);
    let cached = cached_normal(layout, history);
    let d = b.centre() - a.centre();
    let reach = K::radius(a) + K::radius(b);
    let unit = Unit::of(reach);
    let body = |grain| K::body_in(OneSingle, grain, unit.length, unit.inverse);
    let singles = [body(a), body(b)];
    let smallest = |body: &K::Body<OneSingle>| body.extreme_semi_axes()[1].value;
    let least = single(LEAST_SEMI_AXIS).value;
    if !(smallest(&singles[0]) > least && smallest(&singles[1]) > least) {
        return Outcome::Marked;
    }
    let start = cached.unwrap_or_else(|| direction(d));
    let way = single_vector(d) * unit.inverse;
    let nearly = search_nearly(
        OneSingle,
        &singles[0],
        &singles[1],
        way,
        single_vector(start),
    );
    let Some(nearly) = nearly else {
        part(layout, history, touched, None);
        return Outcome::Apart;
    };
    if nearly.hard {
        return Outcome::Marked;
    }
    if nearly.separated {
        let normal = vector_of(double_vector(nearly.normal));
        part(layout, history, touched, Some(normal));
        return Outcome::Apart;
    }
    let (body_a, body_b) = (K::body(a), K::body(b));
    let found = in_more_digits(
        OneLane,
        &body_a,
        &body_b,
        vector(d),
        double_vector(nearly.normal),
        [nearly.weingarten_i, nearly.weingarten_j].map(|m| double_matrix(m * unit.inverse)),
        double_matrix(nearly.inverse_hessian * unit.inverse),
    );
    if found.hard {
        return Outcome::Marked;
    }
    if found.separated {
        part(layout, history, touched, Some(vector_of(found.normal)));
        return Outcome::Apart;
    }
    // The curvature at the normal that the last step led to, from which that of slender bodies differs.
    let nearly = at_normal::<K>(nearly, [&singles[0], &singles[1]], &found);
    let found = Found {
        weingarten_i: double_matrix(nearly.weingarten_i * unit.inverse),
        weingarten_j: double_matrix(nearly.weingarten_j * unit.inverse),
        ..found
    };
    let kinds = &scene.law(candidate).kinds;
    let with_sigma = FRICTION || CONSERVATIVE;
    let Some(factors) = factors(OneSingle, kinds, false, relative(&nearly), with_sigma) else {
        return Outcome::Marked;
    };
    // The terms of the conservative law have a precision of their own. Found first, they are all that waits for the rest of the law.
    let gradient = (CONSERVATIVE && kinds.conservative)
        .then(|| gradient::<K>(&nearly, [&singles[0], &singles[1]], &factors, unit));
    let mut forces = forces::<K, FRICTION, RATE, false>(
        scene,
        candidate,
        d,
        &found,
        [&body_a, &body_b],
        &Factors {
            phi: double(factors.phi).value,
            sigma: double(factors.sigma).value,
        },
        cached,
        history,
        touched,
    );
    if let Some(gradient) = gradient {
        let (normal, tangent) = (vector_of(found.normal), basis_of(found.tangent));
        gradient.add_to(normal, &tangent, &mut forces);
    }
    Outcome::Touching(forces)
}

/// Two bodies at the normal and in the tangent basis of a contact.
#[inline(always)]
fn at_normal<K: Kind>(
    nearly: Found<OneSingle>,
    [i, j]: [&K::Body<OneSingle>; 2],
    found: &Found<OneLane>,
) -> Found<OneSingle> {
    let (normal, basis) = (vector_of(found.normal), basis_of(found.tangent));
    let normal = single_vector(normal);
    let tangent = Tangent {
        u: single_vector(basis.u),
        v: single_vector(basis.v),
    };
    let (view_i, view_j) = (i.view(normal, &tangent), j.view(normal, &tangent));
    let (support_i, support_j) = (i.support_in_frame(&view_i), j.support_in_frame(&view_j));
    Found {
        normal,
        tangent,
        support_i,
        support_j,
        weingarten_i: i.weingarten_in_frame(&view_i, support_i.h),
        weingarten_j: j.weingarten_in_frame(&view_j, support_j.h),
        ..nearly
    }
}

/// How the elastic energy changes with the pose.
#[inline(always)]
fn gradient<K: Kind>(
    nearly: &Found<OneSingle>,
    bodies: [&K::Body<OneSingle>; 2],
    factors: &Factors<Single>,
    unit: Unit,
) -> EnergyGradient {
    // It reads no motion.
    let zero = single(0.0);
    let still = Vector3::new(zero, zero, zero);
    let supports = [&nearly.support_i, &nearly.support_j];
    let weingarten = [nearly.weingarten_i, nearly.weingarten_j];
    let surface = |k: usize| Surface {
        h: supports[k].h,
        inverse_h: supports[k].inverse_h,
        witness: supports[k].witness,
        weingarten: weingarten[k],
        determinant: bodies[k].squared_product(),
        velocity: still,
        omega: still,
    };
    let x = Contact {
        inverse_hessian: Some(nearly.inverse_hessian),
        ..Contact::new(
            (nearly.normal, nearly.tangent),
            nearly.penetration,
            [surface(0), surface(1)],
            zero,
        )
    };
    let g = x.energy_gradient::<false>(x.curvature(), factors);
    let tangential = |v: Vector2<Single>| tangential_of(double_tangential(v));
    let torque = |(across, along)| (tangential(across), double(along).value);
    EnergyGradient {
        lambda: tangential(g.lambda * unit.inverse),
        torque_i: torque(g.torque_i),
        torque_j: torque(g.torque_j),
    }
}
