// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contacts in lanes: a handful of pairs through Newton's method and the law at once.
//!
//! A lane that misbehaves - a Hessian that is not safely positive, a long step, no descent, a deep contact, a curvature
//! ratio beyond the fit - is handed back, to be taken by the scalar path, which has the safeguards.

use super::contact::{contact_forces, relative_curvature_matrix, Contact, Remembered};
use super::lanes::{Lanes, Registers, MOST_LANES};
use super::particles::Record;
use crate::force::hertz_factors::{fit_variable, fitted, FIT_END};
use crate::force::{Factors, LawConstants, PairLaw};
use crate::geometry::{Ellipsoid, Symmetric2, Tangent, Vector3};
use crate::real::Real;

/// One number for each lane.
pub(super) type Row = [f64; MOST_LANES];
/// A vector for each lane.
pub(super) type Rows3 = [Row; 3];

/// The pairs on their way into the lanes. Lanes beyond the pairs that there are repeat one of them.
pub(super) struct Batch<'a> {
    pub i: [&'a Record; MOST_LANES],
    pub j: [&'a Record; MOST_LANES],
    pub laws: [&'a PairLaw; MOST_LANES],
    /// Where the search starts: a unit vector.
    pub start: Rows3,
    /// 1 where the pair touched at the last step.
    pub continued: Row,
    /// The normal at the last step, where the pair touched then.
    pub before: Rows3,
    /// Tangential memory.
    pub memory: Rows3,
    /// Remembered stiffness.
    pub stiffness: Row,
    /// Time over which the memory advances.
    pub time: f64,
}

/// What became of a lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fate {
    Touching,
    Separated,
    /// To be taken by the scalar path.
    Hard,
}

/// What the lanes give back.
pub(super) struct BatchResult {
    pub fate: [Fate; MOST_LANES],
    pub d: Rows3,
    pub normal: Rows3,
    pub force: Rows3,
    pub torque_i: Rows3,
    pub torque_j: Rows3,
    pub memory: Rows3,
    pub stiffness: Row,
    pub elastic_energy: Row,
    pub tangential_energy: Row,
    /// Viscous and tangential power.
    pub power: Row,
}

impl BatchResult {
    /// Nothing yet.
    pub const EMPTY: BatchResult = BatchResult {
        fate: [Fate::Hard; MOST_LANES],
        d: [[0.0; MOST_LANES]; 3],
        normal: [[0.0; MOST_LANES]; 3],
        force: [[0.0; MOST_LANES]; 3],
        torque_i: [[0.0; MOST_LANES]; 3],
        torque_j: [[0.0; MOST_LANES]; 3],
        memory: [[0.0; MOST_LANES]; 3],
        stiffness: [0.0; MOST_LANES],
        elastic_energy: [0.0; MOST_LANES],
        tangential_energy: [0.0; MOST_LANES],
        power: [0.0; MOST_LANES],
    };
}

const NEWTON_STEPS: usize = 8;

#[inline(always)]
fn load<S: Registers>(simd: S, rows: &Rows3) -> Vector3<Lanes<S>> {
    Vector3::new(
        Lanes::load(simd, &rows[0]),
        Lanes::load(simd, &rows[1]),
        Lanes::load(simd, &rows[2]),
    )
}

#[inline(always)]
fn store<S: Registers>(v: Vector3<Lanes<S>>, rows: &mut Rows3) {
    v.x.store(&mut rows[0]);
    v.y.store(&mut rows[1]);
    v.z.store(&mut rows[2]);
}

/// Centre, bounding radius and shape of one side of the pairs.
#[inline(always)]
fn load_body<S: Registers>(
    simd: S,
    records: &[&Record; MOST_LANES],
) -> (Vector3<Lanes<S>>, Lanes<S>, Ellipsoid<Lanes<S>>) {
    let a = Lanes::all(simd, simd.columns(records, 0));
    let b = Lanes::all(simd, simd.columns(records, 8));
    let semi_axes = Vector3::new(b[5], b[6], b[7]);
    let product = semi_axes.y * semi_axes.z;
    let inverse = semi_axes.x.constant(1.0) / (semi_axes.x * product);
    let body = Ellipsoid {
        axes: [
            Vector3::new(a[4], a[5], a[6]),
            Vector3::new(a[7], b[0], b[1]),
            Vector3::new(b[2], b[3], b[4]),
        ],
        semi_axes,
        inverse_semi_axes: Vector3::new(
            product * inverse,
            semi_axes.x * semi_axes.z * inverse,
            semi_axes.x * semi_axes.y * inverse,
        ),
    };
    (Vector3::new(a[0], a[1], a[2]), a[3], body)
}

macro_rules! load_constants {
    ($simd:expr, $laws:expr, $uniform:expr, $($field:ident),*) => {
        if $uniform {
            let c = &$laws[0].constants;
            LawConstants { $($field: Lanes::splat($simd, c.$field)),* }
        } else {
            LawConstants { $($field: Lanes::load($simd, &$laws.map(|l| l.constants.$field))),* }
        }
    };
}

/// Takes a batch through search and law. All its laws are of the same kinds; `uniform` says that they have the same
/// constants too.
#[inline(always)]
pub(super) fn run<
    S: Registers,
    const FRICTION: bool,
    const RATE: bool,
    const CONSERVATIVE: bool,
>(
    simd: S,
    batch: &Batch<'_>,
    uniform: bool,
    result: &mut BatchResult,
) {
    let kinds = batch.laws[0].kinds;
    let zero = Lanes::splat(simd, 0.0);
    let one = Lanes::splat(simd, 1.0);
    let (centre_i, radius_i, body_i) = load_body(simd, &batch.i);
    let (centre_j, radius_j, body_j) = load_body(simd, &batch.j);
    let d = centre_j - centre_i;
    let size = radius_i + radius_j;
    let determinant_i = body_i.shape_determinant();
    let determinant_j = body_j.shape_determinant();
    let tolerance = size * 1e-13;
    let noise = size * 1e-14;

    let mut n = load(simd, &batch.start);
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
        batch.laws,
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
    let (velocity_i, velocity_j, omega_i, omega_j, effective_mass) = if RATE {
        let a = Lanes::all(simd, simd.columns(&batch.i, 16));
        let b = Lanes::all(simd, simd.columns(&batch.j, 16));
        let sum = a[3] + b[3];
        (
            Vector3::new(a[0], a[1], a[2]),
            Vector3::new(b[0], b[1], b[2]),
            Vector3::new(a[4], a[5], a[6]),
            Vector3::new(b[4], b[5], b[6]),
            // Two frozen bodies need no damping.
            Lanes::select(zero.less(sum), one / sum, zero),
        )
    } else {
        (null, null, null, null, zero)
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
        let continues = zero.less(Lanes::load(simd, &batch.continued));
        let was = load(simd, &batch.before);
        Remembered {
            continued: continues,
            normal: Vector3::new(
                Lanes::select(continues, was.x, n.x),
                Lanes::select(continues, was.y, n.y),
                Lanes::select(continues, was.z, n.z),
            ),
            memory: load(simd, &batch.memory),
            stiffness: Lanes::load(simd, &batch.stiffness),
            time: Lanes::splat(simd, batch.time),
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

    let (mut is_hard, mut is_separated): (Row, Row) = ([0.0; MOST_LANES], [0.0; MOST_LANES]);
    hard.store(&mut is_hard);
    separated.store(&mut is_separated);
    for (fate, (hard, separated)) in result
        .fate
        .iter_mut()
        .zip(is_hard.iter().zip(&is_separated))
    {
        *fate = if *separated > 0.0 {
            Fate::Separated
        } else if *hard > 0.0 {
            Fate::Hard
        } else {
            Fate::Touching
        };
    }
    store(d, &mut result.d);
    store(n, &mut result.normal);
    store(f.force, &mut result.force);
    store(f.torque_i, &mut result.torque_i);
    store(f.torque_j, &mut result.torque_j);
    if FRICTION {
        store(f.memory, &mut result.memory);
        f.stiffness.store(&mut result.stiffness);
    }
    if RATE {
        f.elastic_energy.store(&mut result.elastic_energy);
        f.tangential_energy.store(&mut result.tangential_energy);
        (f.viscous_power + f.tangential_power).store(&mut result.power);
    }
}

/// `V^-1 = adj V (a1 a2 a3)^2/h^4`.
#[inline(always)]
fn inverse<T: Real>(v: Symmetric2<T>, h: T, determinant: T) -> Symmetric2<T> {
    let h2 = h * h;
    v.adjugate() * (determinant / (h2 * h2))
}
