// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contacts in lanes: a batch of pairs through Newton's method, the law and the scatter at once.
//!
//! A lane in which the search misbehaves or the curvature ratio is beyond the fit is handed back, to be taken by the scalar
//! path, which has the safeguards.

use super::batches::{LaneBits, Numbers};
use super::records::Record;
use super::shapes::{Kind, Side};
use crate::contact::forces::{
    contact_forces, relative_curvature_matrix, Contact, ContactForces, MotionChange, NoBed,
    Remembered, Surface,
};
use crate::contact::history::SPRING_NUMBERS;
use crate::contact::lane_law::{constants_of, factors_for, factors_of_circles};
use crate::contact::lane_search::{search, search_spheres, select3, separating_planes, Found};
use crate::contact::particle::mass_of_inverse;
use crate::force::memory::MOST_PARTS;
use crate::force::{Factors, LawKinds, PairLaw, Springs, TwistingResistance, SPRINGS};
use crate::geometry::{ConvexBody, SupportInFrame};
use crate::real::Real;
use crate::simd::{lines, put, values, Lanes, Line, Registers, MOST_LANES};
use crate::vector::{Symmetric2, Vector3};

/// The pairs on their way into the lanes. Lanes beyond the pairs that there are repeat one of them.
pub(super) struct Batch<'a> {
    pub records: &'a [Record],
    /// First particles and second ones, by lane.
    pub i: &'a [u32],
    pub j: &'a [u32],
    /// The laws of the lanes, where there are several or contacts are recorded.
    pub laws: &'a [&'a PairLaw; MOST_LANES],
    /// The law of all lanes, where they have one.
    pub only_law: Option<&'a PairLaw>,
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
    /// What the motions of the particles have more at the step ([`super::records::line_of_change`]); empty where that is not known.
    pub changes: &'a [Line],
    /// The time step, where forces see velocities of the step.
    pub begin_time: Option<f64>,
    /// Whether energies are asked for.
    pub tally: bool,
    /// Whether the loads that are not elastic are asked for.
    pub loads: bool,
}

/// What the lanes give back, a line per pair, where energies are asked for.
pub(super) struct BatchTallies {
    /// Force on `j`.
    pub forces: [Line; MOST_LANES],
    /// Normal and tangential elastic energy, viscous power, vector between the centres, tangential power, energy that the memory of
    /// the normal force dissipated.
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
/// - tangential memory, stiffness, frictional force, energy that the memory of the normal force dissipated.
pub(super) struct BatchRecords(pub [[Line; MOST_LANES]; 6]);

impl BatchRecords {
    /// Nothing yet.
    pub const EMPTY: BatchRecords = BatchRecords([[Line::ZERO; MOST_LANES]; 6]);
}

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
    let is_unit = n.is_unit();
    select3(is_unit, n, towards)
}

/// Bits of the pairs that a plane separates by more than a margin, also once `j` has gone a way relative to `i`: `bounds` begin with that
/// way and the margin. `lines` begin with a normal to look at first; one that is no unit vector stands for the direction between the
/// centres. Leaves there the normals with the widest gaps. No others are looked at for the pairs of `stay` alone.
#[inline(always)]
pub(super) fn separated_by<S: Registers, K: Kind>(
    registers: S,
    i: &[&Record; MOST_LANES],
    j: &[&Record; MOST_LANES],
    lines: &mut [Line; MOST_LANES],
    bounds: &[Line; MOST_LANES],
    stay: u32,
) -> u32 {
    let (i, j) = (K::load(registers, i), K::load(registers, j));
    let d = j.centre - i.centre;
    let n = starts(registers, lines, d);
    let b = Lanes::all(registers, registers.columns(&lines!(bounds)));
    let bounds = (b[3], Vector3::new(b[0], b[1], b[2]));
    let (apart, best) = separating_planes(registers, &i.body, &j.body, d, n, bounds, stay);
    let zero = Lanes::splat(registers, 0.0);
    put(
        registers,
        [best.x, best.y, best.z, zero, zero, zero, zero, zero],
        lines,
    );
    apart
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
    let kinds = match batch.only_law {
        Some(law) => &law.kinds,
        None => &batch.laws[0].kinds,
    };
    let zero = Lanes::splat(registers, 0.0);
    let i = K::load(registers, &records_of!(batch.records, batch.i, S::LANES));
    let j = K::load(registers, &records_of!(batch.records, batch.j, S::LANES));
    let d = j.centre - i.centre;
    let start = match numbers.layout.normal {
        Some(at) => vector(registers, numbers, at),
        None => Vector3::new(zero, zero, zero),
    };
    let found = if K::SPHERES {
        search_spheres(registers, &i.body, &j.body, d)
    } else {
        search(registers, &i.body, &j.body, d, start)
    };
    let Some(found) = found else {
        return none_touches::<S, FRICTION>(registers, bits, numbers, 0);
    };
    let curvature = relative_curvature_matrix(found.weingarten_i, found.weingarten_j);
    let (factors, beyond) = factors::<S, K>(
        registers,
        kinds,
        curvature,
        found.separated,
        FRICTION || CONSERVATIVE && kinds.conservative,
    );
    let mut hard = registers.or(found.hard, beyond);
    if RECORD && numbers.layout.torques.is_some() {
        let twisted = registers.mask(with_twisted_springs(batch.laws));
        hard = registers.or(hard, registers.and_not(twisted, found.separated));
        let present = registers.mask(u32::from(bits.present));
        let hard = registers.bits(registers.and(hard, present));
        let apart = registers.bits(registers.and(found.separated, present));
        // All that touch are for the scalar path: nothing of the law would be used.
        if (hard | apart) == u32::from(bits.present) {
            if let Some(at) = numbers.layout.normal {
                let of_hard = registers.mask(hard);
                put_vector(numbers, at, select3(of_hard, start, found.normal));
            }
            return none_touches::<S, FRICTION>(registers, bits, numbers, hard);
        }
    }
    let constants = constants_of(registers, batch.laws, batch.only_law);
    let effective_mass = if RATE && kinds.normal.restitution {
        mass_of_inverse(Lanes::load(registers, batch.inverse_effective_mass))
    } else {
        zero
    };
    let mut x = contact_of(&found, &i, &j, effective_mass);
    let viscous = kinds.normal.relaxation || kinds.normal.restitution || kinds.tangential.viscous;
    if RATE && (viscous || FRICTION) {
        // The mean of the tangential stiffness over the step asks for it too.
        if let Some(time) = common.begin_time {
            x.begin_time = Some(Lanes::splat(registers, time));
        }
        // An elastic law reads the velocities of the half step alone, but a record has the rate of the step.
        if FRICTION && (viscous || RECORD) && !common.changes.is_empty() {
            x.change = Some(relative_change(
                registers,
                &records_of!(common.changes, batch.i, S::LANES),
                &records_of!(common.changes, batch.j, S::LANES),
                i.centre,
            ));
        }
    }
    let remembered = if FRICTION {
        recall::<S, K, RECORD>(registers, bits, numbers, common, start, &found, (&i, &j))
    } else {
        Remembered::nothing(registers.no_lane(), found.normal)
    };
    // A scene whose laws have such is computed by the kernel that records.
    let springs_before = if FRICTION && RECORD {
        springs(registers, numbers, registers.mask(u32::from(bits.touching)))
    } else {
        None
    };
    let mut springs = springs_before;
    let f = if RECORD {
        let held = springs.as_mut();
        contact_forces::<Lanes<S>, LaneSprings<S>, FRICTION, RATE, CONSERVATIVE, false>(
            kinds,
            &constants,
            &factors,
            curvature,
            &x,
            &remembered,
            held,
        )
    } else {
        contact_forces::<Lanes<S>, NoBed, FRICTION, RATE, CONSERVATIVE, false>(
            kinds,
            &constants,
            &factors,
            curvature,
            &x,
            &remembered,
            None,
        )
    };

    // Lanes without a pair of their own go along; nothing of them is used.
    let present = registers.mask(u32::from(bits.present));
    let hard = registers.and(hard, present);
    let touching = registers.and_not(present, registers.or(found.separated, hard));
    let force = scatter(registers, batch, touching, &f, sums);
    let left = Left {
        touching: registers.bits(touching),
        hard: registers.bits(hard),
    };
    remember::<S, FRICTION, RECORD>(
        numbers,
        (touching, hard),
        left.hard != 0,
        start,
        &remembered,
        &x,
        &f,
    );
    if let (Some(before), Some(now)) = (springs_before, springs) {
        remember_springs(numbers, (touching, hard), &before, &now);
    }
    if RECORD {
        record(registers, &x, curvature, &f, lines);
    }
    if RATE && common.tally {
        tally(registers, d, force, &f, common.loads, tallies);
    }
    left
}

/// The lanes whose springs resist a twist too, one bit each: no lanes have that.
#[inline(always)]
fn with_twisted_springs(laws: &[&PairLaw; MOST_LANES]) -> u32 {
    laws.iter().enumerate().fold(0, |bits, (lane, law)| {
        let twists = law.resistance.twisting == TwistingResistance::OfSprings;
        bits | u32::from(twists) << lane
    })
}

/// Hertz factors, and the lanes that are beyond their fit. Lanes `apart` are not asked for.
#[inline(always)]
fn factors<S: Registers, K: Kind>(
    registers: S,
    kinds: &LawKinds,
    curvature: Symmetric2<Lanes<S>>,
    apart: S::Mask,
    with_sigma: bool,
) -> (Factors<Lanes<S>>, S::Mask) {
    if K::SPHERES {
        return (factors_of_circles(registers, kinds), registers.no_lane());
    }
    factors_for(registers, kinds, curvature, apart, with_sigma)
}

/// Geometry and motion for the law.
#[inline(always)]
fn contact_of<S: Registers, K: Kind>(
    found: &Found<S>,
    i: &Side<S, K>,
    j: &Side<S, K>,
    effective_mass: Lanes<S>,
) -> Contact<Lanes<S>> {
    let surfaces = [
        surface(i, &found.support_i, found.weingarten_i),
        surface(j, &found.support_j, found.weingarten_j),
    ];
    Contact {
        inverse_hessian: Some(found.inverse_hessian),
        ..Contact::new(
            (found.normal, found.tangent),
            // A separated or hard lane computes nothing that is used, but must not make a trap of it.
            found.penetration.max(effective_mass.constant(1e-300)),
            surfaces,
            effective_mass,
        )
    }
}

/// What the motions of `j` relative to `i` have more at the step, the velocities at these centres of `i`.
#[inline(always)]
fn relative_change<S: Registers>(
    registers: S,
    changes_i: &[&Line; MOST_LANES],
    changes_j: &[&Line; MOST_LANES],
    centre: Vector3<Lanes<S>>,
) -> MotionChange<Lanes<S>> {
    let c = Lanes::all(
        registers,
        registers.column_differences(changes_j, changes_i),
    );
    let at_origin = MotionChange {
        velocity: Vector3::new(c[0], c[1], c[2]),
        omega: Vector3::new(c[3], c[4], c[5]),
    };
    MotionChange {
        velocity: at_origin.at(centre),
        ..at_origin
    }
}

#[inline(always)]
fn surface<S: Registers, K: Kind>(
    side: &Side<S, K>,
    support: &SupportInFrame<Lanes<S>>,
    weingarten: Symmetric2<Lanes<S>>,
) -> Surface<Lanes<S>> {
    Surface {
        h: support.h,
        inverse_h: support.inverse_h,
        witness: support.witness,
        weingarten,
        determinant: side.body.squared_product(),
        velocity: side.velocity,
        omega: side.omega,
    }
}

/// What is remembered of the pairs; of those that did not touch at the last step, nothing.
#[inline(always)]
fn recall<S: Registers, K: Kind, const RESTS: bool>(
    registers: S,
    bits: LaneBits,
    numbers: &Numbers<'_>,
    common: &Common<'_>,
    start: Vector3<Lanes<S>>,
    found: &Found<S>,
    (i, j): (&Side<S, K>, &Side<S, K>),
) -> Remembered<Lanes<S>> {
    let n = found.normal;
    let Some(at) = numbers.layout.memory else {
        return Remembered::nothing(registers.no_lane(), n);
    };
    let zero = Lanes::splat(registers, 0.0);
    let time = Lanes::splat(registers, common.time);
    let continues = registers.mask(u32::from(bits.touching));
    let was = if common.remembers_normals {
        start
    } else {
        // For two spheres the last normal follows from the motion.
        let before = j.centre - i.centre - (j.velocity - i.velocity) * time;
        let square = before.norm_squared().max(zero.constant(1e-290));
        let before = before * square.reciprocal_sqrt();
        if K::SPHERES {
            before
        } else {
            let spheres = registers.and(K::round(registers, &i.body), K::round(registers, &j.body));
            select3(spheres, before, n)
        }
    };
    let memory = vector(registers, numbers, at);
    let energy = match numbers.layout.energy {
        Some(at) => number(registers, numbers, at),
        None => zero,
    };
    Remembered {
        // A scene whose laws have such memory is computed by the kernel that records.
        rests: if RESTS {
            Some(rests(registers, numbers, continues))
        } else {
            None
        },
        ..Remembered::of(continues, n, (was, memory, energy), time)
    }
}

/// The penetrations of rest that are remembered of pairs that go on.
#[inline(always)]
fn rests<S: Registers>(
    registers: S,
    numbers: &Numbers<'_>,
    continues: S::Mask,
) -> [Lanes<S>; MOST_PARTS] {
    let zero = Lanes::splat(registers, 0.0);
    let mut rests = [zero; MOST_PARTS];
    if let Some(at) = numbers.layout.rests {
        for (k, rest) in rests.iter_mut().enumerate() {
            if k < numbers.layout.rest_count {
                *rest = Lanes::select(continues, number(registers, numbers, at + k), zero);
            }
        }
    }
    rests
}

/// Springs of partial slip in lanes, world frame.
type LaneSprings<S> = Springs<Vector3<Lanes<S>>, Lanes<S>>;

/// The springs that are remembered of pairs that go on, where the layout has such.
#[inline(always)]
fn springs<S: Registers>(
    registers: S,
    numbers: &Numbers<'_>,
    continues: S::Mask,
) -> Option<LaneSprings<S>> {
    let at = numbers.layout.springs?;
    let zero = Lanes::splat(registers, 0.0);
    let null = Vector3::new(zero, zero, zero);
    let mut forces = [null; SPRINGS];
    for (k, force) in forces.iter_mut().enumerate() {
        *force = select3(continues, vector(registers, numbers, at + 3 * k), null);
    }
    let [reference, penetration] = [0, 1].map(|k| number(registers, numbers, at + 3 * SPRINGS + k));
    Some(Springs {
        forces,
        reference: Lanes::select(continues, reference, zero),
        penetration: Lanes::select(continues, penetration, zero),
    })
}

/// Writes them; of a hard pair those before.
#[inline(always)]
fn remember_springs<S: Registers>(
    numbers: &mut Numbers<'_>,
    (touching, hard): (S::Mask, S::Mask),
    before: &LaneSprings<S>,
    now: &LaneSprings<S>,
) {
    let Some(at) = numbers.layout.springs else {
        return;
    };
    let zero = now.reference.constant(0.0);
    let null = Vector3::new(zero, zero, zero);
    for k in 0..SPRINGS {
        let force = select3(touching, now.forces[k], null);
        put_vector(numbers, at + 3 * k, select3(hard, before.forces[k], force));
    }
    let penetrations = [
        (before.reference, now.reference),
        (before.penetration, now.penetration),
    ];
    for (k, (before, now)) in penetrations.into_iter().enumerate() {
        let now = Lanes::select(touching, now, zero);
        put_number(
            numbers,
            at + 3 * SPRINGS + k,
            Lanes::select(hard, before, now),
        );
    }
}

/// Adds forces and torques of the touching pairs to the sums of their particles; the forces on `j`.
#[inline(always)]
fn scatter<S: Registers>(
    registers: S,
    batch: &Batch<'_>,
    touching: S::Mask,
    f: &ContactForces<Lanes<S>>,
    sums: &mut [Line],
) -> Vector3<Lanes<S>> {
    let zero = Lanes::splat(registers, 0.0);
    let null = Vector3::new(zero, zero, zero);
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
    force
}

/// Writes what is to be remembered; of a hard pair what it had remembered.
#[inline(always)]
fn remember<S: Registers, const FRICTION: bool, const RESTS: bool>(
    numbers: &mut Numbers<'_>,
    (touching, hard): (S::Mask, S::Mask),
    any_hard: bool,
    start: Vector3<Lanes<S>>,
    remembered: &Remembered<Lanes<S>>,
    x: &Contact<Lanes<S>>,
    f: &ContactForces<Lanes<S>>,
) {
    let layout = numbers.layout;
    let zero = x.penetration.constant(0.0);
    if let Some(at) = layout.normal {
        let normal = if any_hard {
            select3(hard, start, x.normal)
        } else {
            x.normal
        };
        put_vector(numbers, at, normal);
    }
    if let Some(at) = layout.memory.filter(|_| FRICTION) {
        let mut memory = select3(touching, f.memory, Vector3::new(zero, zero, zero));
        if any_hard {
            memory = select3(hard, remembered.memory, memory);
        }
        put_vector(numbers, at, memory);
        if let Some(at) = layout.energy {
            let mut energy = Lanes::select(touching, f.tangential_energy, zero);
            energy = Lanes::select(hard, remembered.energy, energy);
            put_number(numbers, at, energy);
        }
        if let (true, Some(at), Some(before)) = (RESTS, layout.rests, remembered.rests) {
            for (k, (rest, before)) in f.rests.into_iter().zip(before).enumerate() {
                if k < layout.rest_count {
                    let rest = Lanes::select(touching, rest, zero);
                    put_number(numbers, at + k, Lanes::select(hard, before, rest));
                }
            }
        }
    }
}

/// All that there is to say of the contacts.
#[inline(always)]
fn record<S: Registers>(
    registers: S,
    x: &Contact<Lanes<S>>,
    curvature: Symmetric2<Lanes<S>>,
    f: &ContactForces<Lanes<S>>,
    lines: &mut BatchRecords,
) {
    let world = |a: Vector3<Lanes<S>>, b: Vector3<Lanes<S>>, c: Lanes<S>, e: Lanes<S>| {
        [a.x, a.y, a.z, b.x, b.y, b.z, c, e]
    };
    let (t, m, n) = (&x.tangent, curvature, x.normal);
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
            f.relaxed_energy,
        ],
    ];
    for (numbers, lines) in all.into_iter().zip(&mut lines.0) {
        put(registers, numbers, lines);
    }
}

/// What the sums of a call are made of; `force` is that on `j`, zero where a pair does not touch.
#[inline(always)]
fn tally<S: Registers>(
    registers: S,
    d: Vector3<Lanes<S>>,
    force: Vector3<Lanes<S>>,
    f: &ContactForces<Lanes<S>>,
    loads: bool,
    tallies: &mut BatchTallies,
) {
    let zero = Lanes::splat(registers, 0.0);
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
            f.relaxed_energy,
        ],
        &mut tallies.energies,
    );
    if loads {
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

/// No pair touches, but for those that are `hard`: no tangential part any more of the others.
#[inline(always)]
fn none_touches<S: Registers, const FRICTION: bool>(
    registers: S,
    bits: LaneBits,
    numbers: &mut Numbers<'_>,
    hard: u32,
) -> Left {
    if let Some(at) = numbers.layout.memory {
        if FRICTION && u32::from(bits.touching) & !hard != 0 {
            let layout = numbers.layout;
            forget(registers, numbers, at, 3, hard);
            if let Some(at) = layout.energy {
                forget(registers, numbers, at, 1, hard);
            }
            if let Some(at) = layout.rests {
                forget(registers, numbers, at, layout.rest_count, hard);
            }
            if let Some(at) = layout.springs {
                forget(registers, numbers, at, SPRING_NUMBERS, hard);
            }
        }
    }
    Left { touching: 0, hard }
}

/// Makes zero of some numbers of the pairs that are not `hard`.
#[inline(always)]
fn forget<S: Registers>(
    registers: S,
    numbers: &mut Numbers<'_>,
    first: usize,
    count: usize,
    hard: u32,
) {
    let zero = Lanes::splat(registers, 0.0);
    for k in first..first + count {
        let kept = if hard == 0 {
            zero
        } else {
            Lanes::select(registers.mask(hard), number(registers, numbers, k), zero)
        };
        put_number(numbers, k, kept);
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
