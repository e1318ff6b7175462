// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contacts in lanes: a batch of pairs through Newton's method, the law and the scatter at once.
//!
//! A lane that misbehaves - a Hessian that is not safely positive, a long step, a deep contact, a minimum not proved to be the
//! global one, a curvature ratio beyond the fit - is handed back, to be taken by the scalar path, which has the safeguards.

use super::batches::{LaneBits, Numbers};
use super::contact::{contact_forces, relative_curvature_matrix, Contact, Remembered};
use super::lanes::Lanes;
use super::particles::Record;
use super::registers::{Line, Registers, MOST_LANES};
use super::shapes::Kind;
use crate::force::hertz_factors::{
    fit_variable, fitted, fitted_near, near_variable, FIT_END, NEAR_END,
};
use crate::force::{Factors, LawConstants, PairLaw};
use crate::geometry::global_minimum::{inscribed_ellipsoid_margin, BodyAtNormal};
use crate::geometry::tangent_model::{TangentModel, TangentPoint};
use crate::geometry::{ConvexBody, SupportInFrame, Symmetric2, Tangent, Vector2, Vector3};
use crate::real::Real;

/// The pairs on their way into the lanes. Lanes beyond the pairs that there are repeat one of them.
pub(super) struct Batch<'a> {
    pub records: &'a [Record],
    /// First particles and second ones, by lane.
    pub i: &'a [u32],
    pub j: &'a [u32],
    pub laws: &'a [&'a PairLaw; MOST_LANES],
    /// Inverse of the effective mass, where a law reads masses.
    pub inverse_effective_mass: &'a [f64; MOST_LANES],
}

/// What the whole pass has in common.
#[derive(Clone, Copy)]
pub(super) struct Common<'a> {
    /// Whether the engine remembers normals.
    pub remembers_normals: bool,
    /// Time over which the history advances.
    pub time: f64,
    /// The law, where there is only one.
    pub only_law: Option<&'a PairLaw>,
    /// Whether energies are asked for.
    pub tally: bool,
    /// Whether the loads that are not elastic are asked for.
    pub loads: bool,
}

/// What the lanes give back, a line per pair, where energies are asked for.
pub(super) struct BatchTallies {
    /// Force on `j`.
    pub forces: [Line; MOST_LANES],
    /// Normal and tangential elastic energy, viscous power, vector between the centres, tangential power.
    pub energies: [Line; MOST_LANES],
    /// Viscous force on `j`, and contact point from the centre of `i`; where loads are asked for.
    pub viscous: [Line; MOST_LANES],
    /// Tangential force on `j` without its viscous part; where loads are asked for.
    pub tangential: [Line; MOST_LANES],
}

impl BatchTallies {
    /// Nothing yet.
    pub const EMPTY: BatchTallies = BatchTallies {
        forces: [Line::ZERO; MOST_LANES],
        energies: [Line::ZERO; MOST_LANES],
        viscous: [Line::ZERO; MOST_LANES],
        tangential: [Line::ZERO; MOST_LANES],
    };
}

/// All that there is to say of the touching pairs of a batch, in lines of eight numbers a pair:
/// - force, torque on `i`, normal force, penetration;
/// - torque on `j`, tangential force, viscous and tangential power;
/// - normal, contact point from the centre of `i`, normal and tangential energy;
/// - displacement, rate, relative curvature matrix, first component of the viscous force;
/// - the tangent basis, the other two components of the viscous force;
/// - tangential memory, stiffness, frictional force.
pub(super) struct BatchRecords(pub [[Line; MOST_LANES]; 6]);

impl BatchRecords {
    /// Nothing yet.
    pub const EMPTY: BatchRecords = BatchRecords([[Line::ZERO; MOST_LANES]; 6]);
}

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

/// References, one by one: a closure is not always inlined.
macro_rules! lines {
    ($records:expr $(, $field:ident)?) => {{
        let r = $records;
        [
            &r[0]$(.$field)?,
            &r[1]$(.$field)?,
            &r[2]$(.$field)?,
            &r[3]$(.$field)?,
            &r[4]$(.$field)?,
            &r[5]$(.$field)?,
            &r[6]$(.$field)?,
            &r[7]$(.$field)?,
            &r[8]$(.$field)?,
            &r[9]$(.$field)?,
            &r[10]$(.$field)?,
            &r[11]$(.$field)?,
            &r[12]$(.$field)?,
            &r[13]$(.$field)?,
            &r[14]$(.$field)?,
            &r[15]$(.$field)?,
        ]
    }};
}

pub(super) use lines;

/// The records of particles, one by one: no array of references is ever in memory.
macro_rules! records_of {
    ($records:expr, $indices:expr, $lanes:expr) => {{
        let (records, indices) = ($records, $indices);
        macro_rules! record {
            ($k:literal) => {
                &records[indices[if $k < $lanes { $k } else { 0 }] as usize]
            };
        }
        [
            record!(0),
            record!(1),
            record!(2),
            record!(3),
            record!(4),
            record!(5),
            record!(6),
            record!(7),
            record!(8),
            record!(9),
            record!(10),
            record!(11),
            record!(12),
            record!(13),
            record!(14),
            record!(15),
        ]
    }};
}

/// The start normals that the lines begin with, where they are unit vectors, else the directions of `d`, else, for coincident
/// centres, any.
#[inline(always)]
fn starts<S: Registers>(
    registers: S,
    lines: &[Line; MOST_LANES],
    d: Vector3<Lanes<S>>,
) -> Vector3<Lanes<S>> {
    let c = Lanes::all(registers, registers.columns(&lines!(lines)));
    let n = Vector3::new(c[0], c[1], c[2]);
    let tiny = d.x.constant(1e-290);
    let square = d.norm_squared();
    let mut towards = d * square.max(tiny).reciprocal_sqrt();
    towards.x = Lanes::select(square.less(tiny), d.x.constant(1.0), towards.x);
    let is_unit = (n.norm_squared() - 1.0).abs().less(d.x.constant(1e-6));
    Vector3::new(
        Lanes::select(is_unit, n.x, towards.x),
        Lanes::select(is_unit, n.y, towards.y),
        Lanes::select(is_unit, n.z, towards.z),
    )
}

/// Bits of the pairs that a plane separates by more than `margin`: the one of their start normal, or one of those that
/// `IMPROVEMENTS` steps lead to. `lines` begin with a normal; one that is no unit vector stands for the
/// direction between the centres. Leaves there the normals with the widest gaps. No steps are taken for the pairs of
/// `stay` alone.
#[inline(always)]
pub(super) fn separated_by<S: Registers, K: Kind>(
    registers: S,
    i: &[&Record; MOST_LANES],
    j: &[&Record; MOST_LANES],
    lines: &mut [Line; MOST_LANES],
    margin: f64,
    stay: u32,
) -> u32 {
    let (i, j) = (K::load(registers, i), K::load(registers, j));
    let d = j.centre - i.centre;
    let mut n = starts(registers, lines, d);
    let zero = Lanes::splat(registers, 0.0);
    let margin = Lanes::splat(registers, margin);
    let mut apart = 0;
    let mut open = (1u32 << S::LANES) - 1;
    let mut best = n;
    let mut widest = zero.constant(f64::NEG_INFINITY);
    for left in (0..=IMPROVEMENTS).rev() {
        let ((h_i, point_i), (h_j, point_j)) =
            (i.body.support_in_world(n), j.body.support_in_world(n));
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
        let (newton, square, sound) = newton_step(registers, &i.body, &j.body, d, n);
        // A gap as wide as it gets.
        open &= !registers.bits(registers.and(sound, square.less(square.constant(SHORT_STEP))));
        n = if left == IMPROVEMENTS {
            select3(leads, along, select3(sound, newton, n))
        } else {
            select3(sound, newton, select3(leads, along, n))
        };
    }
    put(
        registers,
        [best.x, best.y, best.z, zero, zero, zero, zero, zero],
        lines,
    );
    apart
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

macro_rules! load_constants {
    ($registers:expr, $laws:expr, $only:expr, $($field:ident),*) => {
        if let Some(law) = $only {
            let c = &law.constants;
            LawConstants { $($field: Lanes::splat($registers, c.$field)),* }
        } else {
            LawConstants {
                $($field: {
                    let mut numbers = [0.0; MOST_LANES];
                    for k in 0..S::LANES {
                        numbers[k] = $laws[k].constants.$field;
                    }
                    Lanes::load($registers, &numbers)
                }),*
            }
        }
    };
}

/// What the search leaves for the law.
struct Found<S: Registers> {
    normal: Vector3<Lanes<S>>,
    tangent: Tangent<Lanes<S>>,
    penetration: Lanes<S>,
    support_i: SupportInFrame<Lanes<S>>,
    support_j: SupportInFrame<Lanes<S>>,
    weingarten_i: Symmetric2<Lanes<S>>,
    weingarten_j: Symmetric2<Lanes<S>>,
    inverse_hessian: Symmetric2<Lanes<S>>,
    separated: S::Mask,
    hard: S::Mask,
}

/// Newton's method from the start normals in the tangent plane, and one evaluation at its end; `None` where the planes of
/// the start normals separate all pairs.
#[inline(always)]
fn search<S: Registers, B: ConvexBody<Lanes<S>>>(
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
    let mut at = model.at_base();
    let first = at.value;
    let apart = first.less(zero);
    if registers.bits(apart) == (1u32 << S::LANES) - 1 {
        return None;
    }
    let mut y = Vector2::new(zero, zero);
    let mut hard = zero.less(zero);
    let mut active = registers.and_not(zero.less(one), apart);
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
        if registers.bits(active) == 0 || step == NEWTON_STEPS {
            break;
        }
        at = model.at(y);
    }
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
    let radii_i = inverse(weingarten_i, support_i.inverse_h, i.squared_product());
    let radii_j = inverse(weingarten_j, support_j.inverse_h, j.squared_product());
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
    if registers.bits(open) != 0 {
        let at = |support: &SupportInFrame<Lanes<S>>, squared_product, radii| BodyAtNormal {
            h: support.h,
            inverse_h: support.inverse_h,
            squared_product,
            radii,
        };
        let margin = inscribed_ellipsoid_margin(
            &at(&support_i, i.squared_product(), radii_i),
            &at(&support_j, j.squared_product(), radii_j),
            penetration,
            across,
        );
        let trace = margin.trace();
        let positive = registers.and(
            (trace * trace * 1e-12).less(margin.determinant()),
            zero.less(trace),
        );
        proved = registers.or(proved, registers.and(positive, zero.less(along)));
    }
    // Without a start there is no normal.
    let started = (one * 0.5).less(start.norm_squared());
    let sound = registers.and(
        registers.and(converged, falling),
        registers.and(registers.and(shallow, proved), started),
    );
    hard = registers.or(hard, registers.and_not(zero.less(one), sound));
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
fn search_spheres<S: Registers, B: ConvexBody<Lanes<S>>>(
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
    if registers.bits(separated) == (1u32 << S::LANES) - 1 {
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
fn select3<S: Registers>(
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

/// Bits of the lanes that need more.
pub(super) struct Left {
    /// Pairs that touch.
    pub touching: u32,
    /// Pairs for the scalar path.
    pub hard: u32,
}

/// Takes a batch through search and law: forces and torques onto the `sums`, what is remembered into the `numbers`. All
/// its laws are of the same kinds. What a hard pair had remembered stays as it was.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
pub(super) fn run<
    S: Registers,
    K: Kind,
    const FRICTION: bool,
    const RATE: bool,
    const CONSERVATIVE: bool,
    const RECORD: bool,
>(
    registers: S,
    batch: &Batch<'_>,
    bits: LaneBits,
    numbers: &mut Numbers<'_>,
    common: &Common<'_>,
    sums: &mut [Line],
    tallies: &mut BatchTallies,
    lines: &mut BatchRecords,
) -> Left {
    let kinds = match common.only_law {
        Some(law) => &law.kinds,
        None => &batch.laws[0].kinds,
    };
    let layout = numbers.layout;
    let zero = Lanes::splat(registers, 0.0);
    let one = Lanes::splat(registers, 1.0);
    let i = K::load(registers, &records_of!(batch.records, batch.i, S::LANES));
    let j = K::load(registers, &records_of!(batch.records, batch.j, S::LANES));
    let d = j.centre - i.centre;
    let null = Vector3::new(zero, zero, zero);
    let start = match layout.normal {
        Some(at) => vector(registers, numbers, at),
        None => null,
    };
    let present = registers.mask(u32::from(bits.present));
    let found = if K::SPHERES {
        search_spheres(registers, &i.body, &j.body, d)
    } else {
        search(registers, &i.body, &j.body, d, start)
    };
    let Some(found) = found else {
        return all_apart::<S, FRICTION>(registers, bits, numbers);
    };
    let n = found.normal;
    let mut hard = found.hard;

    let curvature = relative_curvature_matrix(found.weingarten_i, found.weingarten_j);
    let factors = if K::SPHERES {
        Factors {
            phi: one,
            sigma: one * (if kinds.linear { 0.0 } else { 1.0 / 6.0 }),
        }
    } else if kinds.linear {
        Factors {
            phi: one,
            sigma: zero,
        }
    } else {
        let (trace, determinant) = (curvature.trace(), curvature.determinant());
        let q = near_variable(trace, determinant);
        let near = registers.or(q.less(zero.constant(NEAR_END)), found.separated);
        if registers.bits(near) == (1u32 << S::LANES) - 1 {
            fitted_near(q, FRICTION || CONSERVATIVE)
        } else {
            let w = fit_variable(trace, determinant);
            let beyond = zero.constant(FIT_END).less(w);
            hard = registers.or(hard, registers.and_not(beyond, found.separated));
            fitted(w, FRICTION || CONSERVATIVE)
        }
    };
    let constants = load_constants!(
        registers,
        batch.laws,
        common.only_law,
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
    let effective_mass = if RATE && kinds.restitution {
        let inverse = Lanes::load(registers, batch.inverse_effective_mass);
        // Two frozen bodies need no damping.
        Lanes::select(
            zero.less(inverse),
            inverse.max(one * 1e-300).reciprocal(),
            zero,
        )
    } else {
        zero
    };
    let x = Contact {
        normal: n,
        tangent: found.tangent,
        // A separated or hard lane computes nothing that is used, but must not make a trap of it.
        penetration: found.penetration.max(zero.constant(1e-300)),
        h_i: found.support_i.h,
        inverse_h_i: found.support_i.inverse_h,
        witness_i: found.support_i.witness,
        weingarten_i: found.weingarten_i,
        determinant_i: i.body.squared_product(),
        h_j: found.support_j.h,
        inverse_h_j: found.support_j.inverse_h,
        witness_j: found.support_j.witness,
        weingarten_j: found.weingarten_j,
        determinant_j: j.body.squared_product(),
        velocity_i: i.velocity,
        velocity_j: j.velocity,
        omega_i: i.omega,
        omega_j: j.omega,
        effective_mass,
        inverse_hessian: Some(found.inverse_hessian),
    };
    let time = Lanes::splat(registers, common.time);
    let remembered = match layout.memory {
        Some(at) if FRICTION => {
            let continues = registers.mask(u32::from(bits.touching));
            let was = if common.remembers_normals {
                start
            } else {
                // For two spheres the last normal follows from the motion.
                let before = d - (j.velocity - i.velocity) * time;
                let square = before.norm_squared().max(zero.constant(1e-290));
                let before = before * square.reciprocal_sqrt();
                if K::SPHERES {
                    before
                } else {
                    let spheres =
                        registers.and(K::round(registers, &i.body), K::round(registers, &j.body));
                    select3(spheres, before, n)
                }
            };
            Remembered {
                continued: continues,
                normal: select3(continues, was, n),
                memory: select3(continues, vector(registers, numbers, at), null),
                energy: match layout.energy {
                    Some(at) => Lanes::select(continues, number(registers, numbers, at), zero),
                    None => zero,
                },
                time,
            }
        }
        _ => Remembered {
            continued: one.less(zero),
            normal: n,
            memory: null,
            energy: zero,
            time: zero,
        },
    };
    let f = contact_forces::<Lanes<S>, FRICTION, RATE, CONSERVATIVE, false>(
        kinds,
        &constants,
        &factors,
        curvature,
        &x,
        &remembered,
    );

    let hard = registers.and(hard, present);
    let touching = registers.and_not(present, registers.or(found.separated, hard));
    let force = select3(touching, f.force, null);
    let torque_i = select3(touching, f.torque_i, null);
    let torque_j = select3(touching, f.torque_j, null);
    registers.add_to_lines(
        values([
            zero - force.x,
            zero - force.y,
            zero - force.z,
            torque_i.x,
            torque_i.y,
            torque_i.z,
            zero,
            zero,
        ]),
        batch.i,
        values([
            force.x, force.y, force.z, torque_j.x, torque_j.y, torque_j.z, zero, zero,
        ]),
        batch.j,
        sums,
    );
    // Lanes without a pair of their own go along; nothing of them is used.
    let left = Left {
        touching: registers.bits(touching),
        hard: registers.bits(hard),
    };
    if left.hard == 0 {
        if let Some(at) = layout.normal {
            put_vector(numbers, at, n);
        }
    } else if let Some(at) = layout.normal {
        put_vector(numbers, at, select3(hard, start, n));
    }
    if let Some(at) = layout.memory.filter(|_| FRICTION) {
        let mut memory = select3(touching, f.memory, null);
        if left.hard != 0 {
            memory = select3(hard, remembered.memory, memory);
        }
        put_vector(numbers, at, memory);
        if let Some(at) = layout.energy {
            let mut energy = Lanes::select(touching, f.tangential_energy, zero);
            energy = Lanes::select(hard, remembered.energy, energy);
            put_number(numbers, at, energy);
        }
    }
    if RECORD {
        let world = |a: Vector3<Lanes<S>>, b: Vector3<Lanes<S>>, c: Lanes<S>, e: Lanes<S>| {
            [a.x, a.y, a.z, b.x, b.y, b.z, c, e]
        };
        let (t, m) = (&found.tangent, curvature);
        let all = [
            world(f.force, f.torque_i, f.normal_force, x.penetration),
            world(
                f.torque_j,
                f.tangential_force,
                f.viscous_power,
                f.tangential_power,
            ),
            world(n, f.contact_point, f.elastic_energy, f.tangential_energy),
            [
                f.displacement.x,
                f.displacement.y,
                f.displacement.z,
                f.rate,
                m.uu,
                m.uv,
                m.vv,
                f.viscous_force.x,
            ],
            world(t.u, t.v, f.viscous_force.y, f.viscous_force.z),
            [
                f.memory.x,
                f.memory.y,
                f.memory.z,
                f.stiffness,
                f.frictional_force.x,
                f.frictional_force.y,
                f.frictional_force.z,
                zero,
            ],
        ];
        for (numbers, lines) in all.into_iter().zip(&mut lines.0) {
            put(registers, numbers, lines);
        }
    }
    if RATE && common.tally {
        put(
            registers,
            [force.x, force.y, force.z, zero, zero, zero, zero, zero],
            &mut tallies.forces,
        );
        put(
            registers,
            [
                f.elastic_energy,
                f.tangential_energy,
                f.viscous_power,
                d.x,
                d.y,
                d.z,
                f.tangential_power,
                zero,
            ],
            &mut tallies.energies,
        );
        if common.loads {
            let (v, p, t) = (f.viscous_force, f.contact_point, f.frictional_force);
            put(
                registers,
                [v.x, v.y, v.z, p.x, p.y, p.z, zero, zero],
                &mut tallies.viscous,
            );
            put(
                registers,
                [t.x, t.y, t.z, zero, zero, zero, zero, zero],
                &mut tallies.tangential,
            );
        }
    }
    left
}

/// No pair touches: no tangential part any more.
#[inline(always)]
fn all_apart<S: Registers, const FRICTION: bool>(
    registers: S,
    bits: LaneBits,
    numbers: &mut Numbers<'_>,
) -> Left {
    if let Some(at) = numbers.layout.memory {
        if FRICTION && bits.touching != 0 {
            let zero = Lanes::splat(registers, 0.0);
            put_vector(numbers, at, Vector3::new(zero, zero, zero));
            if let Some(at) = numbers.layout.energy {
                put_number(numbers, at, zero);
            }
        }
    }
    Left {
        touching: 0,
        hard: 0,
    }
}

#[inline(always)]
fn number<S: Registers>(registers: S, numbers: &Numbers<'_>, k: usize) -> Lanes<S> {
    Lanes::load(registers, numbers.get(k, S::LANES))
}

#[inline(always)]
fn vector<S: Registers>(registers: S, numbers: &Numbers<'_>, k: usize) -> Vector3<Lanes<S>> {
    Vector3::new(
        number(registers, numbers, k),
        number(registers, numbers, k + 1),
        number(registers, numbers, k + 2),
    )
}

#[inline(always)]
fn put_number<S: Registers>(numbers: &mut Numbers<'_>, k: usize, a: Lanes<S>) {
    a.store(numbers.get_mut(k, S::LANES));
}

#[inline(always)]
fn put_vector<S: Registers>(numbers: &mut Numbers<'_>, k: usize, v: Vector3<Lanes<S>>) {
    put_number(numbers, k, v.x);
    put_number(numbers, k + 1, v.y);
    put_number(numbers, k + 2, v.z);
}

#[inline(always)]
fn values<S: Registers>(v: [Lanes<S>; 8]) -> [S::Vector; 8] {
    [
        v[0].value, v[1].value, v[2].value, v[3].value, v[4].value, v[5].value, v[6].value,
        v[7].value,
    ]
}

#[inline(always)]
pub(super) fn put<S: Registers>(registers: S, v: [Lanes<S>; 8], lines: &mut [Line; MOST_LANES]) {
    registers.lines(values(v), lines);
}

/// `V^-1 = adj V (a1 a2 a3)^2/h^4`.
#[inline(always)]
fn inverse<T: Real>(v: Symmetric2<T>, inverse_h: T, determinant: T) -> Symmetric2<T> {
    let square = inverse_h * inverse_h;
    v.adjugate() * (determinant * (square * square))
}
