// SPDX-License-Identifier: MIT OR Apache-2.0
//! Force and torques of one contact, and its history.
//!
//! A pair goes through the search of the lanes and the law ([`contact_of_pair`]). One that this search hands back (a deep
//! contact, a minimum without proof, a curvature ratio beyond the fit) is marked, and taken by [`marked_contact_of_pair`],
//! which has every safeguard and needs kilobytes of memory a thread.

use crate::candidates::Candidate;
use crate::one_lane::{basis_of, matrix_of, tangential_of, vector, vector_of, OneLane};
use crate::shapes::{Grain, GrainChange, Kind};
use crate::terms::ContactLoad;
use ellgran::contact::history::{cached_normal, forget};
use ellgran::contact::lane_search::{search, search_spheres, Found};
use ellgran::contact::pair::{law_of_pair, normal_of_spheres_before, through_law, Pair};
use ellgran::contact::particle::effective_mass;
use ellgran::contact::{Contact, ContactForces, HistoryLayout, MotionChange, Step};
use ellgran::force::hertz_factors::{
    fit_variable, fitted, fitted_near, near_variable, FIT_END, NEAR_END,
};
use ellgran::force::{Factors, LawKinds, PairLaw};
use ellgran::geometry::{ConvexBody, SupportInFrame};
use ellgran::real::Real;
use ellgran::simd::{Lanes, Registers};
use ellgran::vector::{Symmetric2, Vector3};

use crate::one_lane::Number;
use ellgran::contact::forces::{relative_curvature_matrix, Surface};

/// Of a pair's state: it touches.
pub const TOUCHES: u32 = 1;

/// What all threads read.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// Prepared grains, ghosts included.
    pub grains: &'a [Grain],
    /// What their motion has more at the step; empty where velocities are those of the half step.
    pub changes: &'a [GrainChange],
    /// Their types, counted from 1.
    pub types: &'a [u32],
    /// Inverses of their masses for effective masses; empty where no law reads masses.
    pub inverse_masses: &'a [f64],
    /// Their identifiers in the engine, which a ghost shares with its grain: of a pair, the grain with the lower one comes first.
    pub identifiers: &'a [i32],
    /// The laws of all pairs of types, row by row. None of them has `factors hale`, or resists rolling or
    /// twisting.
    pub laws: &'a [PairLaw],
    /// Number of types.
    pub type_count: u32,
    /// The layout of a pair's history.
    pub layout: HistoryLayout,
    /// Time step, and whether histories advance.
    pub step: Step,
}

impl Scene<'_> {
    #[inline(always)]
    pub(crate) fn law(&self, candidate: &Candidate) -> &PairLaw {
        &self.laws[candidate.law as usize]
    }

    /// What the motion of a grain has more at the step, for a law that asks for it: a viscous one, or one with friction, of which the mean
    /// stiffness over the step counts then.
    #[inline(always)]
    pub(crate) fn change(&self, law: &PairLaw, k: usize) -> Option<MotionChange> {
        let kinds = &law.kinds;
        let asks = kinds.normal.relaxation || kinds.normal.restitution || kinds.tangential.any();
        self.changes
            .get(k)
            .filter(|_| asks)
            .map(GrainChange::motion)
    }

    /// Two grains, the one with the lower identifier first.
    #[inline(always)]
    pub fn in_order(&self, k: usize, other: usize) -> [usize; 2] {
        if comes_first(self.identifiers, k, other) {
            [k, other]
        } else {
            [other, k]
        }
    }

    #[inline(always)]
    fn inverse_mass(&self, k: usize) -> f64 {
        self.inverse_masses.get(k).copied().unwrap_or(0.0)
    }
}

/// Force on a grain, and torque about its centre; world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Load {
    /// Force.
    pub force: Vector3,
    /// Torque.
    pub torque: Vector3,
}

impl Load {
    /// Nothing.
    pub const NONE: Load = Load {
        force: Vector3::ZERO,
        torque: Vector3::ZERO,
    };
}

/// What became of a pair.
// It is never in memory.
#[allow(clippy::large_enum_variant)]
pub(crate) enum Outcome {
    Apart,
    Marked,
    Touching(ContactForces),
}

impl Outcome {
    /// The load, and the state that goes with it; `None`, and the state as it was, where the pair is marked.
    #[inline(always)]
    pub(crate) fn noted(self, state: &mut u32) -> Option<ContactLoad> {
        match self {
            Outcome::Marked => None,
            Outcome::Apart => {
                *state = 0;
                Some(ContactLoad::NONE)
            }
            Outcome::Touching(f) => {
                *state = TOUCHES;
                Some(f.into())
            }
        }
    }
}

/// Where the law of two types is among those of all pairs of types.
#[inline(always)]
pub(crate) fn law_of_types(i: u32, j: u32, type_count: u32) -> usize {
    (i.wrapping_sub(1) * type_count).wrapping_add(j.wrapping_sub(1)) as usize
}

#[inline(always)]
pub(crate) fn comes_first(identifiers: &[i32], k: usize, other: usize) -> bool {
    identifiers[k] <= identifiers[other]
}

/// The contact of a pair, the first grain of which has the lower identifier; `None` where it is marked, and state and history are left
/// as they were. `FRICTION`, `RATE` and `CONSERVATIVE` say which terms the laws of the scene have at all, as for
/// [`ellgran::contact::forces::contact_forces`].
#[inline(always)]
pub fn contact_of_pair<
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

/// What [`contact_of_pair`] has marked.
pub fn marked_contact_of_pair<K: Kind>(
    scene: &Scene<'_>,
    candidate: &Candidate,
    state: &mut u32,
    history: &mut [f64],
) -> ContactLoad {
    let touched = *state & TOUCHES != 0;
    match forces_with_safeguards::<K>(scene, candidate, history, touched) {
        None => {
            *state = 0;
            ContactLoad::NONE
        }
        Some(f) => {
            *state = TOUCHES;
            f.into()
        }
    }
}

/// A pair that does not touch remembers the normal of a plane between the bodies, and nothing else.
#[inline(always)]
pub(crate) fn part(
    layout: &HistoryLayout,
    history: &mut [f64],
    touched: bool,
    normal: Option<Vector3>,
) {
    if let (Some(at), Some(n)) = (layout.normal, normal) {
        history[at..at + 3].copy_from_slice(&n.to_array());
    }
    if touched {
        forget(layout, history);
    }
}

/// The pair as the lanes take it.
#[inline(always)]
fn one_pair<K: Kind, const FRICTION: bool, const RATE: bool, const CONSERVATIVE: bool>(
    scene: &Scene<'_>,
    candidate: &Candidate,
    history: &mut [f64],
    touched: bool,
) -> Outcome {
    let layout = &scene.layout;
    let [i, j] = candidate.pair();
    // All is read before anything is decided by it: a device waits once.
    let (a, b) = (&scene.grains[i], &scene.grains[j]);
    let cached = cached_normal(layout, history);
    let d = b.centre() - a.centre();
    let (body_a, body_b) = (K::body(a), K::body(b));
    let found = if K::SPHERES {
        search_spheres(OneLane, &body_a, &body_b, vector(d))
    } else {
        let start = cached.unwrap_or_else(|| direction(d));
        search(OneLane, &body_a, &body_b, vector(d), vector(start))
    };
    let Some(found) = found else {
        part(layout, history, touched, None);
        return Outcome::Apart;
    };
    if found.hard {
        return Outcome::Marked;
    }
    if found.separated || !(found.penetration.value > 0.0) {
        part(layout, history, touched, Some(vector_of(found.normal)));
        return Outcome::Apart;
    }
    let law = scene.law(candidate);
    let curvature = relative(&found);
    let Some(factors) = factors(
        OneLane,
        &law.kinds,
        K::SPHERES,
        curvature,
        FRICTION || CONSERVATIVE,
    ) else {
        return Outcome::Marked;
    };
    Outcome::Touching(forces::<K, FRICTION, RATE, CONSERVATIVE>(
        scene,
        candidate,
        d,
        &found,
        [&body_a, &body_b],
        &Factors {
            phi: factors.phi.value,
            sigma: factors.sigma.value,
        },
        cached,
        history,
        touched,
    ))
}

/// The law of a pair that touches as was found.
#[inline(always)]
pub(crate) fn forces<K: Kind, const FRICTION: bool, const RATE: bool, const CONSERVATIVE: bool>(
    scene: &Scene<'_>,
    candidate: &Candidate,
    d: Vector3,
    found: &Found<OneLane>,
    bodies: [&K::Body<OneLane>; 2],
    factors: &Factors,
    cached: Option<Vector3>,
    history: &mut [f64],
    touched: bool,
) -> ContactForces {
    let [i, j] = candidate.pair();
    let (a, b) = (&scene.grains[i], &scene.grains[j]);
    let (layout, law) = (&scene.layout, scene.law(candidate));
    let x = contact_of::<K>(scene, law, [i, j], found, bodies);
    let before = match cached {
        Some(n) => n,
        None if K::SPHERES || (K::is_sphere(a) && K::is_sphere(b)) => {
            normal_of_spheres_before(d, x.j.velocity - x.i.velocity, x.normal, &scene.step)
        }
        None => x.normal,
    };
    through_law::<FRICTION, RATE, CONSERVATIVE, false>(
        law,
        factors,
        &x,
        layout,
        history,
        touched,
        before,
        &scene.step,
    )
}

/// The direction of a vector; any where it has none.
#[inline(always)]
pub(crate) fn direction(d: Vector3) -> Vector3 {
    if d.norm_squared() > 1e-290 {
        d.normalised()
    } else {
        Vector3::new(1.0, 0.0, 0.0)
    }
}

#[inline(always)]
pub(crate) fn relative<S: Registers>(found: &Found<S>) -> Symmetric2<Lanes<S>> {
    relative_curvature_matrix(found.weingarten_i, found.weingarten_j)
}

/// Hertz factors from the fits; `None` beyond them.
#[inline(always)]
pub(crate) fn factors<S: Registers>(
    registers: S,
    kinds: &LawKinds,
    spheres: bool,
    curvature: Symmetric2<Lanes<S>>,
    with_sigma: bool,
) -> Option<Factors<Lanes<S>>> {
    let number = |x: f64| Lanes::splat(registers, x);
    if spheres || !kinds.normal.elliptical {
        let sigma = if kinds.normal.elliptical {
            1.0 / 6.0
        } else {
            0.0
        };
        return Some(Factors {
            phi: number(1.0),
            sigma: number(sigma),
        });
    }
    let (trace, determinant) = (curvature.trace(), curvature.determinant());
    let q = near_variable(trace, determinant);
    if registers.any(q.less(number(NEAR_END))) {
        return Some(fitted_near(q, with_sigma));
    }
    let w = fit_variable(trace, determinant);
    let beyond = registers.any(number(FIT_END).less(w));
    (!beyond).then(|| fitted(w, with_sigma))
}

/// Geometry and motion for the law.
#[inline(always)]
fn contact_of<K: Kind>(
    scene: &Scene<'_>,
    law: &PairLaw,
    [i, j]: [usize; 2],
    found: &Found<OneLane>,
    [body_a, body_b]: [&K::Body<OneLane>; 2],
) -> Contact {
    let surface = |k: usize,
                   body: &K::Body<OneLane>,
                   support: &SupportInFrame<Number>,
                   weingarten: Symmetric2<Number>| {
        let (velocity, omega) = K::motion(&scene.grains[k]);
        Surface {
            h: support.h.value,
            inverse_h: support.inverse_h.value,
            witness: tangential_of(support.witness),
            weingarten: matrix_of(weingarten),
            determinant: body.squared_product().value,
            velocity,
            omega,
        }
    };
    Contact {
        normal: vector_of(found.normal),
        tangent: basis_of(found.tangent),
        penetration: found.penetration.value,
        i: surface(i, body_a, &found.support_i, found.weingarten_i),
        j: surface(j, body_b, &found.support_j, found.weingarten_j),
        effective_mass: effective_mass(scene.inverse_mass(i), scene.inverse_mass(j)),
        inverse_hessian: Some(matrix_of(found.inverse_hessian)),
        change: match (scene.change(law, i), scene.change(law, j)) {
            (Some(of_i), Some(of_j)) => {
                let d = scene.grains[j].centre() - scene.grains[i].centre();
                Some(MotionChange::between([of_i, of_j], d))
            }
            _ => None,
        },
        begin_time: None,
    }
}

/// The pair as a single contact takes it.
pub(crate) fn forces_with_safeguards<K: Kind>(
    scene: &Scene<'_>,
    candidate: &Candidate,
    history: &mut [f64],
    touched: bool,
) -> Option<ContactForces> {
    let (layout, law) = (&scene.layout, scene.law(candidate));
    let [i, j] = candidate.pair();
    let particle = |k: usize| {
        let mut p = K::particle(&scene.grains[k], scene.types[k], scene.inverse_mass(k));
        p.change = scene.change(law, k);
        p
    };
    let (a, b) = (particle(i), particle(j));
    let cached = cached_normal(layout, history);
    match Pair::of(&a, &b, cached) {
        Pair::Apart { normal, searched } => {
            part(layout, history, touched, normal.filter(|_| searched));
            None
        }
        Pair::Touching(found) => {
            // Nothing resists rolling or twisting: the couple is none.
            let (forces, _) = law_of_pair::<true, true>(
                law,
                &found,
                [&a, &b],
                layout,
                history,
                touched,
                cached,
                &scene.step,
            );
            Some(forces)
        }
    }
}
