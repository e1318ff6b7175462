// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contacts in lanes: a handful of pairs through Newton's method and the law at once.
//!
//! A lane that misbehaves - a Hessian that is not safely positive, a long step, no descent, a deep contact, a curvature
//! ratio beyond the fit - is handed back, to be taken by the scalar path, which has the safeguards.

use super::contact::{
    contact_forces, relative_curvature_matrix, Contact, ContactForces, Remembered,
};
use super::lanes::{Lanes, MOST_LANES};
use super::particles::Particle;
use crate::force::hertz_factors::{fit_variable, fitted, FIT_END};
use crate::force::{Factors, LawConstants, PairLaw};
use crate::geometry::{Ellipsoid, Symmetric2, Tangent, Vector3};
use crate::real::Real;
use pulp::Simd;

/// One pair on its way into a lane.
#[derive(Clone, Copy)]
pub(super) struct Candidate<'a> {
    pub i: &'a Particle,
    pub j: &'a Particle,
    pub d: Vector3,
    /// Where the search starts; a unit vector.
    pub start: Vector3,
    pub law: &'a PairLaw,
    pub remembered: Remembered,
}

/// What became of a lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fate {
    Touching,
    Separated,
    /// To be taken by the scalar path.
    Hard,
}

/// What a lane gives back.
#[derive(Clone, Copy)]
pub(super) struct LaneResult {
    pub fate: Fate,
    pub normal: Vector3,
    pub forces: ContactForces,
}

impl LaneResult {
    /// Nothing yet.
    pub const EMPTY: LaneResult = LaneResult {
        fate: Fate::Hard,
        normal: Vector3::ZERO,
        forces: ContactForces {
            force: Vector3::ZERO,
            torque_i: Vector3::ZERO,
            torque_j: Vector3::ZERO,
            normal_force: 0.0,
            tangential_force: Vector3::ZERO,
            contact_point: Vector3::ZERO,
            memory: Vector3::ZERO,
            displacement: Vector3::ZERO,
            stiffness: 0.0,
            rate: 0.0,
            elastic_energy: 0.0,
            tangential_energy: 0.0,
            viscous_power: 0.0,
            tangential_power: 0.0,
        },
    };
}

type Row = [f64; MOST_LANES];

const NEWTON_STEPS: usize = 8;

macro_rules! load_vector {
    ($simd:expr, $lanes:expr, $of:expr) => {{
        let (mut x, mut y, mut z): (Row, Row, Row) = ([0.0; 8], [0.0; 8], [0.0; 8]);
        for (k, c) in $lanes.iter().enumerate() {
            let v: Vector3 = $of(c);
            x[k] = v.x;
            y[k] = v.y;
            z[k] = v.z;
        }
        Vector3::new(
            Lanes::load($simd, &x),
            Lanes::load($simd, &y),
            Lanes::load($simd, &z),
        )
    }};
}

macro_rules! load_scalar {
    ($simd:expr, $lanes:expr, $of:expr) => {{
        let mut x: Row = [0.0; 8];
        for (k, c) in $lanes.iter().enumerate() {
            x[k] = $of(c);
        }
        Lanes::load($simd, &x)
    }};
}

macro_rules! load_body {
    ($simd:expr, $lanes:expr, $body:ident) => {
        Ellipsoid {
            axes: [
                load_vector!($simd, $lanes, |c: &Candidate| c.$body.body.axes[0]),
                load_vector!($simd, $lanes, |c: &Candidate| c.$body.body.axes[1]),
                load_vector!($simd, $lanes, |c: &Candidate| c.$body.body.axes[2]),
            ],
            semi_axes: load_vector!($simd, $lanes, |c: &Candidate| c.$body.body.semi_axes),
            inverse_semi_axes: load_vector!($simd, $lanes, |c: &Candidate| c
                .$body
                .body
                .inverse_semi_axes),
        }
    };
}

macro_rules! load_constants {
    ($simd:expr, $lanes:expr, $uniform:expr, $($field:ident),*) => {
        if $uniform {
            let c = &$lanes[0].law.constants;
            LawConstants { $($field: Lanes::splat($simd, c.$field)),* }
        } else {
            LawConstants { $($field: load_scalar!($simd, $lanes, |c: &Candidate| c.law.constants.$field)),* }
        }
    };
}

/// Takes `lanes` - exactly as many as the instruction set has, the last repeated to fill - through search and law.
///
/// All lanes have laws of the same kinds; `uniform` says that they have the same constants too.
#[inline(always)]
pub(super) fn run<S: Simd, const FRICTION: bool, const RATE: bool, const CONSERVATIVE: bool>(
    simd: S,
    lanes: &[Candidate<'_>],
    uniform: bool,
    results: &mut [LaneResult; MOST_LANES],
) {
    let kinds = lanes[0].law.kinds;
    let zero = Lanes::splat(simd, 0.0);
    let one = Lanes::splat(simd, 1.0);
    let body_i = load_body!(simd, lanes, i);
    let body_j = load_body!(simd, lanes, j);
    let d = load_vector!(simd, lanes, |c: &Candidate| c.d);
    let size = load_scalar!(simd, lanes, |c: &Candidate| c.i.radius + c.j.radius);
    let determinant_i = body_i.shape_determinant();
    let determinant_j = body_j.shape_determinant();
    let tolerance = size * 1e-13;
    let noise = size * 1e-14;

    let mut n = load_vector!(simd, lanes, |c: &Candidate| c.start);
    // 1 where the lane is still on its way; 1 where it is hard.
    let mut active = one;
    let mut hard = zero;
    let mut separated = zero;
    let mut last = Lanes::splat(simd, f64::INFINITY);
    let mut step = 0;
    let (support_i, support_j, tangent, weingarten_i, weingarten_j, penetration, radii) = loop {
        let support_i = body_i.support(n);
        let support_j = body_j.support(n);
        let f = support_i.h + support_j.h - n.dot(d);
        let tangent = Tangent::new(n);
        let w = support_i.point + support_j.point - d;
        let g = tangent.components(w);
        let weingarten_i = body_i.weingarten(&support_i, &tangent);
        let weingarten_j = body_j.weingarten(&support_j, &tangent);
        let radii = inverse(weingarten_i, support_i.h, determinant_i)
            + inverse(weingarten_j, support_j.h, determinant_j);

        // No descent: not where Newton should be trusted.
        let rising = Lanes::select((last + noise).less(f), active, zero);
        hard = hard.max(rising);
        let apart = Lanes::select(f.less(zero), active, zero);
        separated = separated.max(apart);
        let moving = Lanes::select((tolerance * tolerance).less(g.dot(g)), active, zero);
        active = moving.min(one - hard).min(one - separated);
        last = f;
        if active.largest() == 0.0 || step == NEWTON_STEPS {
            break (
                support_i,
                support_j,
                tangent,
                weingarten_i,
                weingarten_j,
                f,
                radii,
            );
        }
        step += 1;

        let hessian = radii.shifted(-f);
        let trace = hessian.trace();
        let determinant = hessian.determinant();
        let definite = (trace * trace * 1e-11).less(determinant);
        let y = hessian.adjugate().apply(g) * (-one / determinant);
        let length = y.dot(y);
        let good = Lanes::select(definite, one, zero)
            .min(Lanes::select(zero.less(trace), one, zero))
            .min(Lanes::select(length.less(one * 0.25), one, zero));
        hard = hard.max(active.min(one - good));
        active = active.min(good);
        let next = (n + tangent.vector(y)).normalised();
        let moves = zero.less(active);
        n = Vector3::new(
            Lanes::select(moves, next.x, n.x),
            Lanes::select(moves, next.y, n.y),
            Lanes::select(moves, next.z, n.z),
        );
    };
    // Whatever is still active did not converge.
    hard = hard.max(active);
    // Deep contacts have several minima, and a normal against d is not the least of them.
    let mean = radii.trace() * 0.5;
    let half_difference = (radii.uu - radii.vv) * 0.5;
    let radius = (half_difference * half_difference + radii.uv * radii.uv).sqrt();
    let smallest = radii.determinant() / (mean + radius);
    let through = body_i.chord(&support_i) + body_j.chord(&support_j);
    let deep = Lanes::select(
        (smallest * 0.5).min(through * 0.25).less(penetration),
        one,
        zero,
    )
    .max(Lanes::select(n.dot(d).less(zero), one, zero));
    hard = hard.max(deep).min(one - separated);

    let curvature = relative_curvature_matrix(weingarten_i, weingarten_j);
    let factors = if kinds.linear {
        Factors {
            phi: one,
            sigma: zero,
        }
    } else {
        let w = fit_variable(curvature.trace(), curvature.determinant());
        let beyond = Lanes::select(Lanes::splat(simd, FIT_END).less(w), one, zero);
        hard = hard.max(beyond).min(one - separated);
        fitted(w, FRICTION || CONSERVATIVE)
    };
    let constants = load_constants!(
        simd,
        lanes,
        uniform,
        normal_stiffness,
        normal_damping,
        restitution,
        friction,
        kappa0,
        kappa1,
        tau0,
        tau1,
        tangential_stiffness,
        tangential_damping,
        share_i
    );
    let null = Vector3::new(zero, zero, zero);
    let (velocity_i, velocity_j, omega_i, omega_j) = if RATE {
        (
            load_vector!(simd, lanes, |c: &Candidate| c.i.velocity),
            load_vector!(simd, lanes, |c: &Candidate| c.j.velocity),
            load_vector!(simd, lanes, |c: &Candidate| c.i.omega),
            load_vector!(simd, lanes, |c: &Candidate| c.j.omega),
        )
    } else {
        (null, null, null, null)
    };
    let effective_mass = if kinds.restitution {
        load_scalar!(simd, lanes, |c: &Candidate| {
            super::particles::effective_mass(c.i.inverse_mass, c.j.inverse_mass)
        })
    } else {
        zero
    };
    let x = Contact {
        normal: n,
        tangent,
        // A separated or hard lane computes nothing that is used, but must not make a trap of it.
        penetration: penetration.max(zero.constant(1e-300)),
        d,
        h_i: support_i.h,
        s_i: support_i.point,
        weingarten_i,
        determinant_i,
        h_j: support_j.h,
        s_j: support_j.point,
        weingarten_j,
        determinant_j,
        velocity_i,
        velocity_j,
        omega_i,
        omega_j,
        effective_mass,
    };
    let remembered = if FRICTION {
        let continued = load_scalar!(simd, lanes, |c: &Candidate| c.remembered.continued as u8
            as f64);
        let was = load_vector!(simd, lanes, |c: &Candidate| c.remembered.normal);
        let continues = zero.less(continued);
        Remembered {
            continued: continues,
            normal: Vector3::new(
                Lanes::select(continues, was.x, n.x),
                Lanes::select(continues, was.y, n.y),
                Lanes::select(continues, was.z, n.z),
            ),
            memory: load_vector!(simd, lanes, |c: &Candidate| c.remembered.memory),
            stiffness: load_scalar!(simd, lanes, |c: &Candidate| c.remembered.stiffness),
            time: Lanes::splat(simd, lanes[0].remembered.time),
        }
    } else {
        Remembered {
            continued: one.less(zero),
            normal: n,
            memory: null,
            stiffness: zero,
            time: zero,
        }
    };
    let f = contact_forces::<Lanes<S>, FRICTION, RATE, CONSERVATIVE, false>(
        &kinds,
        &constants,
        &factors,
        curvature,
        &x,
        &remembered,
    );

    let mut rows = [[0.0; MOST_LANES]; 2];
    hard.store(&mut rows[0]);
    separated.store(&mut rows[1]);
    for k in 0..lanes.len() {
        results[k].fate = if rows[1][k] > 0.0 {
            Fate::Separated
        } else if rows[0][k] > 0.0 {
            Fate::Hard
        } else {
            Fate::Touching
        };
    }
    macro_rules! store_vector {
        ($value:expr, $($target:tt)+) => {{
            let v = $value;
            let mut rows = [[0.0; MOST_LANES]; 3];
            v.x.store(&mut rows[0]);
            v.y.store(&mut rows[1]);
            v.z.store(&mut rows[2]);
            for k in 0..lanes.len() {
                results[k].$($target)+ = Vector3::new(rows[0][k], rows[1][k], rows[2][k]);
            }
        }};
    }
    macro_rules! store_scalar {
        ($value:expr, $($target:tt)+) => {{
            let mut row = [0.0; MOST_LANES];
            $value.store(&mut row);
            for k in 0..lanes.len() {
                results[k].$($target)+ = row[k];
            }
        }};
    }
    store_vector!(n, normal);
    store_vector!(f.force, forces.force);
    store_vector!(f.torque_i, forces.torque_i);
    store_vector!(f.torque_j, forces.torque_j);
    if FRICTION {
        store_vector!(f.memory, forces.memory);
        store_scalar!(f.stiffness, forces.stiffness);
    }
    if RATE {
        store_scalar!(f.elastic_energy, forces.elastic_energy);
        store_scalar!(f.tangential_energy, forces.tangential_energy);
        store_scalar!(f.viscous_power, forces.viscous_power);
        store_scalar!(f.tangential_power, forces.tangential_power);
    }
}

/// `V^-1 = adj V (a1 a2 a3)^2/h^4`.
#[inline(always)]
fn inverse<T: Real>(v: Symmetric2<T>, h: T, determinant: T) -> Symmetric2<T> {
    let h2 = h * h;
    v.adjugate() * (determinant / (h2 * h2))
}
