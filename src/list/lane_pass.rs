// SPDX-License-Identifier: MIT OR Apache-2.0
//! A neighbour list in lanes: which pairs may touch, and their contacts a batch at a time.
//!
//! Forces are added up in the order of the list, independent of which pairs were skipped.

use super::batch::{
    run as run_batch, separated_by, Batch, BatchRecords, BatchTallies, Common, Left,
};
use super::batches::{Candidate, LaneBits, Numbers};
use super::candidates::{Bound, Candidates};
use super::contact_records::{contact_point, of_lane, turning_contact};
use super::records::{ParticleRecords, Record, Records, Shapes};
use super::rows::{check_history, ListError, NeighbourRow};
use super::scalar_pass::{Pass, Place};
use super::shapes::{Ellipsoids, Kind, Spheres, Spheroids};
use super::workspace::Workspace;
use crate::contact::couple::{approach, couple, Couple};
use crate::contact::pair::normal_of_spheres_before;
use crate::contact::{HistoryLayout, Laws};
use crate::simd::{Line, Registers, Stage, MOST_LANES};
use crate::tallies::Contribution;
use crate::vector::Vector3;
use core::marker::PhantomData;

/// Batches between the one that is computed and the one whose particles are asked for.
const AHEAD: usize = 2;
/// So many particles ahead an engine's forces and torques are asked for.
const SUMS_AHEAD: usize = 16;
/// Numbers of a line of the cache.
const NUMBERS_OF_LINE: usize = 8;

/// See [`find_candidates`].
struct FindCandidates<'p, 'a, 'b, 'c, K> {
    pass: &'p mut Pass<'a, 'b, 'c>,
    records: &'p [Record],
    shapes: Shapes,
    types: &'p [u32],
    candidates: &'p mut Candidates,
    found: &'p mut Result<(), ListError>,
    kind: PhantomData<K>,
}

impl<K: Kind> Stage for FindCandidates<'_, '_, '_, '_, K> {
    #[inline(always)]
    fn run<S: Registers>(self, registers: S) {
        *self.found = find_candidates::<S, K>(
            self.pass,
            registers,
            (self.records, self.shapes),
            self.types,
            self.candidates,
        );
    }
}

/// See [`contacts`].
struct Contacts<
    'p,
    'a,
    'b,
    'c,
    K,
    const FRICTION: bool,
    const RATE: bool,
    const CONSERVATIVE: bool,
    const RECORD: bool,
> {
    pass: &'p mut Pass<'a, 'b, 'c>,
    particles: &'p mut Records,
    candidates: &'p mut Candidates,
    kind: PhantomData<K>,
}

impl<K: Kind, const F: bool, const V: bool, const C: bool, const P: bool> Stage
    for Contacts<'_, '_, '_, '_, K, F, V, C, P>
{
    #[inline(always)]
    fn run<S: Registers>(self, registers: S) {
        contacts::<S, K, F, V, C, P>(self.pass, registers, self.particles, self.candidates);
    }
}

/// Pairs on their way to the candidates, in the order of the list.
struct Pending<'a> {
    waiting: [Candidate; MOST_PENDING],
    /// What the engine remembers of them.
    history: [[f64; HistoryLayout::LONGEST]; MOST_PENDING],
    /// Bits of pairs that touched: they are candidates in any case, for their history ends when the contact does.
    touched: u32,
    /// The lane in which a separating plane is looked for, or [`NO_LANE`].
    lane: [u8; MOST_PENDING],
    count: usize,
    /// Of the lanes.
    i: [&'a Record; MOST_LANES],
    j: [&'a Record; MOST_LANES],
    start: [Line; MOST_LANES],
    bounds: [Line; MOST_LANES],
    lanes: usize,
}

/// Room for pairs that touched between those that may be apart.
const MOST_PENDING: usize = u32::BITS as usize;
/// For a pair that touched no plane is looked for.
const NO_LANE: u8 = u8::MAX;

impl<'a> Pending<'a> {
    fn new(any: &'a Record) -> Self {
        let nowhere = Candidate {
            entry: 0,
            i: 0,
            j: 0,
            law: 0,
        };
        Pending {
            waiting: [nowhere; MOST_PENDING],
            history: [[0.0; HistoryLayout::LONGEST]; MOST_PENDING],
            touched: 0,
            lane: [NO_LANE; MOST_PENDING],
            count: 0,
            i: [any; MOST_LANES],
            j: [any; MOST_LANES],
            start: [Line::ZERO; MOST_LANES],
            bounds: [Line::ZERO; MOST_LANES],
            lanes: 0,
        }
    }

    /// Whether there is room for one more.
    #[inline(always)]
    fn is_full(&self, lanes: usize) -> bool {
        self.lanes == lanes || self.count == MOST_PENDING
    }

    #[inline(always)]
    fn push<K: Kind>(
        &mut self,
        pair: Candidate,
        (i, j): (&'a Record, &'a Record),
        bound: Bound,
        touched: bool,
        history: &[f64],
        normal: Option<usize>,
    ) {
        let k = self.count;
        self.count = k + 1;
        self.waiting[k] = pair;
        // One by one: a copy of unknown length is a call.
        for (to, from) in self.history[k].iter_mut().zip(history) {
            *to = *from;
        }
        self.touched |= u32::from(touched) << k;
        // Of spheres no search looks at the normals: whatever is remembered, that between the centres is one.
        if touched && !K::SPHERES {
            self.lane[k] = NO_LANE;
            return;
        }
        let lane = self.lanes;
        self.lanes = lane + 1;
        self.lane[k] = lane as u8;
        self.i[lane] = i;
        self.j[lane] = j;
        self.bounds[lane] = bound.line();
        // No unit vector stands for the direction between the centres.
        let start = &mut self.start[lane].0;
        if K::SPHERES {
            let n = (j.position() - i.position()).direction();
            start[..3].copy_from_slice(&n.unwrap_or(Vector3::new(1.0, 0.0, 0.0)).to_array());
            return;
        }
        match normal {
            Some(at) => start[..3].copy_from_slice(&history[at..at + 3]),
            None => start[..3].fill(0.0),
        }
    }
}

/// The whole list on the workspace's instruction set.
pub(super) fn in_lanes<const FRICTION: bool, const RATE: bool, const RECORD: bool>(
    mut pass: Pass<'_, '_, '_>,
    workspace: &mut Workspace,
) -> Result<u64, ListError> {
    if workspace.records.records.is_empty() {
        return Ok(0);
    }
    match workspace.records.shapes {
        // The conservative law adds nothing to a force between spheres.
        Shapes::Spheres => of_kind::<Spheres, FRICTION, RATE, false, RECORD>(&mut pass, workspace)?,
        Shapes::Spheroids => {
            of_kind::<Spheroids, FRICTION, RATE, true, RECORD>(&mut pass, workspace)?;
        }
        Shapes::Ellipsoids => {
            of_kind::<Ellipsoids, FRICTION, RATE, true, RECORD>(&mut pass, workspace)?;
        }
    }
    Ok(pass.deep_contacts)
}

/// With the closed form of one kind of shape.
fn of_kind<
    K: Kind,
    const FRICTION: bool,
    const RATE: bool,
    const CONSERVATIVE: bool,
    const RECORD: bool,
>(
    pass: &mut Pass<'_, '_, '_>,
    workspace: &mut Workspace,
) -> Result<(), ListError> {
    let set = workspace.instruction_set;
    let (particles, candidates) = (&mut workspace.records, &mut workspace.candidates);
    if !candidates.are_valid() {
        let mut found = Ok(());
        set.run(FindCandidates {
            pass: &mut *pass,
            records: &particles.records[..],
            shapes: particles.shapes,
            types: &particles.types,
            candidates: &mut *candidates,
            found: &mut found,
            kind: PhantomData::<K>,
        });
        found?;
    }
    if let Some(t) = pass.tallies.as_deref_mut() {
        t.pairs += candidates.listed;
    }
    candidates.batches.advanced();
    set.run(Contacts::<K, FRICTION, RATE, CONSERVATIVE, RECORD> {
        pass: &mut *pass,
        particles,
        candidates,
        kind: PhantomData,
    });
    Ok(())
}

/// Goes through the whole list for pairs that may touch while the particles go on as they are expected and allowed to. It reads every
/// entry, and so finds those that name no particle.
#[inline(always)]
fn find_candidates<S: Registers, K: Kind>(
    pass: &mut Pass<'_, '_, '_>,
    registers: S,
    (records, shapes): (&[Record], Shapes),
    types: &[u32],
    candidates: &mut Candidates,
) -> Result<(), ListError> {
    let entries = pass.rows.entries();
    let (laws, layout) = (pass.laws, pass.layout);
    let length = layout.length;
    candidates.expect(records, shapes, pass.step.time_step);
    for row in 0..pass.rows.count() {
        let NeighbourRow {
            central,
            neighbours,
            ..
        } = pass.rows.row(row);
        let others = neighbours.iter().filter_map(|named| entries.index(*named));
        candidates.meet(central, others);
    }
    candidates.allow();
    candidates.batches.begin(S::LANES, layout, !K::SPHERES);
    let (mut listed, mut looked_at) = (0, 0);
    let mut pending = Pending::new(&records[0]);
    for row in 0..pass.rows.count() {
        let NeighbourRow {
            central,
            neighbours,
            touching,
            history,
        } = pass.rows.row(row);
        listed += neighbours.len();
        let i = &records[central];
        let (centre, radius) = (i.position(), K::radius(i));
        for (entry, &named) in neighbours.iter().enumerate() {
            let Some(other) = entries.index(named) else {
                continue;
            };
            let Some(j) = records.get(other).filter(|_| other != central) else {
                return Err(ListError::Entry {
                    central,
                    place: entry,
                    entry: named,
                });
            };
            let d = j.position() - centre;
            let bound = candidates.bound(central, other);
            let reach = radius + K::radius(j) + bound.farthest();
            let touched = touching.get(entry).is_some_and(|t| *t != 0);
            // What is no number is looked at.
            let far = d.norm_squared() >= reach * reach;
            if far && !touched {
                continue;
            }
            let pair = Candidate {
                entry: entry as u32,
                i: central as u32,
                j: other as u32,
                law: laws.index(types[central], types[other]),
            };
            let history = history
                .get(entry * length..(entry + 1) * length)
                .unwrap_or(&[]);
            if touched {
                check_history(&layout, history, central, other)?;
            }
            pending.push::<K>(pair, (i, j), bound, touched, history, layout.normal);
            looked_at += 1;
            if pending.is_full(S::LANES) {
                settle::<S, K>(registers, &mut pending, laws, candidates);
            }
        }
    }
    if pending.count > 0 {
        settle::<S, K>(registers, &mut pending, laws, candidates);
    }
    candidates.end(listed, looked_at);
    Ok(())
}

/// Search, law and scatter of the candidates.
#[inline(always)]
fn contacts<
    S: Registers,
    K: Kind,
    const FRICTION: bool,
    const RATE: bool,
    const CONSERVATIVE: bool,
    const RECORD: bool,
>(
    pass: &mut Pass<'_, '_, '_>,
    registers: S,
    particles: &mut Records,
    candidates: &mut Candidates,
) {
    let Records {
        records,
        types,
        inverse_masses,
        changes,
        of_step,
        sums,
        shapes,
        places: _,
    } = particles;
    let shapes = *shapes;
    let records = &records[..];
    let laws = pass.laws;
    let common = Common {
        remembers_normals: pass.layout.normal.is_some(),
        time: pass.step.elapsed(),
        changes,
        begin_time: of_step.then_some(pass.step.time_step),
        tally: pass.tallies.is_some(),
        loads: pass
            .tallies
            .as_deref()
            .is_some_and(|t| t.inelastic_loads.is_some()),
    };
    let mut batch_laws = [laws.get(1, 1); MOST_LANES];
    let mut inverse_effective_mass = [0.0; MOST_LANES];
    let mut tallies = BatchTallies::EMPTY;
    let mut lines = BatchRecords::EMPTY;
    let single = ParticleRecords {
        records,
        types,
        inverse_masses,
        changes,
        elsewhere: None,
        of_step: *of_step,
        shapes,
    };
    let (batches, participants) = candidates.parts();
    let mut waiting = participants.iter();
    for number in 0..batches.count() {
        for of_line in batches.numbers_of(number + 1).chunks(NUMBERS_OF_LINE) {
            registers.prefetch(&of_line[0]);
        }
        let only_law = batches.common_law(number).map(|law| laws.at(law));
        match only_law {
            // Those that record look each law up.
            Some(law) if RECORD => batch_laws = [law; MOST_LANES],
            Some(_) => {}
            None => {
                for (own, law) in batch_laws.iter_mut().zip(batches.laws_of(number)) {
                    *own = laws.at(*law);
                }
            }
        }
        let (i, j, bits, mut numbers) = batches.batch(number);
        if let Some(ahead) = j.get(AHEAD * S::LANES..(AHEAD + 1) * S::LANES) {
            for &k in ahead {
                let record = &records[k as usize];
                registers.prefetch(&record.pose.0[0]);
                registers.prefetch(&record.motion.0[0]);
                registers.prefetch(&sums[k as usize].0[0]);
                if let Some(change) = changes.get(k as usize) {
                    registers.prefetch(&change.0[0]);
                }
            }
        }
        let j = &j[..S::LANES];
        if !inverse_masses.is_empty() {
            for k in 0..S::LANES {
                inverse_effective_mass[k] =
                    inverse_masses[i[k] as usize] + inverse_masses[j[k] as usize];
            }
        }
        let batch = Batch {
            records,
            i,
            j,
            laws: &batch_laws,
            only_law,
            inverse_effective_mass: &inverse_effective_mass,
        };
        let last = (RECORD && laws.features().resistance)
            .then(|| LastStep::of::<S>(pass.layout.normal, *bits, &numbers));
        let left = run_batch::<S, K, FRICTION, RATE, CONSERVATIVE, RECORD>(
            registers,
            &batch,
            *bits,
            &mut numbers,
            &common,
            sums,
            &mut tallies,
            &mut lines,
        );
        bits.touching = left.touching as u16 | bits.touching & left.hard as u16;
        if RATE && common.tally {
            tally(pass, &batch, left.touching, &tallies, common.time);
        }
        let mut couples = None;
        if let Some(last) = last {
            couples = Some(resist(
                pass,
                &batch,
                S::LANES,
                &left,
                &last,
                &mut numbers,
                &lines,
                sums,
                single,
            ));
        }
        if RECORD {
            for lane in (0..S::LANES).filter(|lane| left.touching >> lane & 1 != 0) {
                let couple = couples.as_ref().map(|c| &c[lane]);
                record(
                    pass,
                    batches.pair(number, lane),
                    lane,
                    &lines,
                    couple,
                    single,
                );
            }
        }
        let mut hard = left.hard;
        while hard != 0 {
            let lane = hard.trailing_zeros() as usize;
            hard &= hard - 1;
            let pair = batches.pair(number, lane);
            batches.write_one(pass.rows, number, lane);
            scalar_pair::<FRICTION, RATE>(pass, pair, single);
            batches.read_one(pass.rows, number, lane);
        }
        // While they are still close, and the arithmetic of the next batch hides the way to the engine's arrays.
        let whole = batches.whole_below(number);
        while let Some(&k) = waiting.as_slice().first().filter(|k| **k < whole) {
            add_sum(pass, sums, k as usize);
            waiting.next();
            if let Some(&ahead) = waiting.as_slice().get(SUMS_AHEAD) {
                if let Some(force) = pass.accumulators.forces.get(ahead as usize) {
                    registers.prefetch(&force[0]);
                    registers.prefetch(&pass.accumulators.torques[ahead as usize][0]);
                }
            }
        }
    }
    for &k in waiting {
        add_sum(pass, sums, k as usize);
    }
}

/// Energies and virial of a batch.
fn tally(
    pass: &mut Pass<'_, '_, '_>,
    batch: &Batch<'_>,
    touching: u32,
    tallies: &BatchTallies,
    time: f64,
) {
    let Some(t) = pass.tallies.as_deref_mut() else {
        return;
    };
    for k in 0..MOST_LANES {
        if touching >> k & 1 == 0 {
            continue;
        }
        let (e, f) = (&tallies.energies[k].0, &tallies.forces[k].0);
        let (v, r) = (&tallies.viscous[k].0, &tallies.tangential[k].0);
        t.add(
            batch.i[k] as usize,
            Some(batch.j[k] as usize),
            (batch.j[k] as usize) < pass.accumulators.reaction_below,
            &Contribution {
                normal_energy: e[0],
                tangential_energy: e[1],
                works: [time * e[2], time * e[6]],
                relaxed: e[7],
                d: Vector3::new(e[3], e[4], e[5]),
                force: Vector3::new(f[0], f[1], f[2]),
                viscous_force: Vector3::new(v[0], v[1], v[2]),
                tangential_force: Vector3::new(r[0], r[1], r[2]),
                contact_point: Vector3::new(v[3], v[4], v[5]),
                wall_velocity: Vector3::ZERO,
            },
            None,
        );
    }
}

/// A touching pair in full.
fn record(
    pass: &mut Pass<'_, '_, '_>,
    pair: Candidate,
    lane: usize,
    lines: &BatchRecords,
    couple: Option<&Couple>,
    single: ParticleRecords<'_>,
) {
    let (i, j) = (pair.i as usize, pair.j as usize);
    let law = pass
        .laws
        .get(single.types[i] as usize, single.types[j] as usize);
    if let Some(recorded) = pass.recorded.as_deref_mut() {
        let place = (i, j, pair.entry as usize);
        let centre = single.records[i].position();
        let mut contact = of_lane(place, lane, lines, law, centre);
        if let Some(couple) = couple {
            couple.add_to(&mut contact.forces);
        }
        recorded.push(contact);
    }
}

/// What is overwritten by a batch and still needed by what resists rolling and twisting.
struct LastStep {
    /// Lanes that touched.
    touching: u32,
    /// The normals then, where they are remembered.
    normals: Option<[Vector3; MOST_LANES]>,
}

impl LastStep {
    /// `of_engine` says whether normals are remembered from step to step, or are those of the search alone.
    fn of<S: Registers>(of_engine: Option<usize>, bits: LaneBits, numbers: &Numbers<'_>) -> Self {
        let normals = of_engine.and(numbers.layout.normal).map(|at| {
            core::array::from_fn(|lane| {
                let number = |k: usize| numbers.get(at + k, S::LANES)[lane % S::LANES];
                Vector3::new(number(0), number(1), number(2))
            })
        });
        LastStep {
            touching: u32::from(bits.touching),
            normals,
        }
    }
}

/// What resists rolling and twisting, of the touching pairs of a batch one by one: after the lanes have found contact and force. The
/// lanes of a scene without it know nothing of it.
#[allow(clippy::too_many_arguments)]
fn resist(
    pass: &mut Pass<'_, '_, '_>,
    batch: &Batch<'_>,
    lanes: usize,
    left: &Left,
    last: &LastStep,
    numbers: &mut Numbers<'_>,
    lines: &BatchRecords,
    sums: &mut [Line],
    single: ParticleRecords<'_>,
) -> [Couple; MOST_LANES] {
    let mut couples = [Couple::NONE; MOST_LANES];
    let layout = numbers.layout;
    let remembered = layout.resistance()..layout.length;
    for lane in 0..lanes {
        let bit = 1 << lane;
        if left.touching & bit == 0 {
            // A hard pair has what it had until the scalar path takes it.
            if last.touching & bit != 0 && left.hard & bit == 0 {
                for k in remembered.clone() {
                    numbers.get_mut(k, lanes)[lane] = 0.0;
                }
            }
            continue;
        }
        let law = batch.laws[lane];
        if !law.resistance.any() {
            continue;
        }
        let (i, j) = (batch.i[lane] as usize, batch.j[lane] as usize);
        let mut turning = turning_contact(lane, lines);
        let [vi, wi] = single.records[i].velocities(single.shapes);
        let [vj, wj] = single.records[j].velocities(single.shapes);
        let d = single.records[j].position() - single.records[i].position();
        let arm = contact_point(lane, lines);
        turning.omega = [wi, wj];
        turning.rate = approach(turning.normal, [arm, arm - d], [vi, vj], [wi, wj]);
        if single.of_step {
            turning.omega_change = single.change(j).omega - single.change(i).omega;
        }
        let before = match &last.normals {
            Some(normals) => normals[lane],
            None if [i, j]
                .iter()
                .all(|k| single.records[*k].is_sphere(single.shapes))
                && pass.step.advance_history =>
            {
                normal_of_spheres_before(d, vj - vi, turning.normal, pass.step)
            }
            None => turning.normal,
        };
        let mut history = [0.0; HistoryLayout::LONGEST];
        for k in remembered.clone() {
            history[k] = numbers.get(k, lanes)[lane];
        }
        let touched = last.touching & bit != 0;
        let found = couple(
            law,
            &turning,
            &layout,
            &mut history,
            touched,
            before,
            pass.step,
        );
        for k in remembered.clone() {
            numbers.get_mut(k, lanes)[lane] = history[k];
        }
        let torque = found.torque().to_array();
        for (axis, t) in torque.into_iter().enumerate() {
            sums[i].0[3 + axis] += t;
            sums[j].0[3 + axis] -= t;
        }
        pass.tally_couple(i, j, &found);
        couples[lane] = found;
    }
    couples
}

/// One pair with every safeguard.
#[cold]
fn scalar_pair<const FRICTION: bool, const RATE: bool>(
    pass: &mut Pass<'_, '_, '_>,
    pair: Candidate,
    single: ParticleRecords<'_>,
) {
    let place = Place {
        entry: pair.entry as usize,
        i: pair.i as usize,
        j: pair.j as usize,
    };
    let (i, j) = (single.particle(place.i), single.particle(place.j));
    pass.one_pair::<FRICTION, RATE>(place, &i, &j);
}

/// Hands the sum of a particle to the engine's arrays and clears it.
#[inline(always)]
fn add_sum(pass: &mut Pass<'_, '_, '_>, sums: &mut [Line], k: usize) {
    let a = &mut *pass.accumulators;
    let sum = &mut sums[k].0;
    if k < a.reaction_below {
        let (force, torque) = (&mut a.forces[k], &mut a.torques[k]);
        for axis in 0..3 {
            force[axis] += sum[axis];
            torque[axis] += sum[3 + axis];
        }
    }
    *sum = Line::ZERO.0;
}

/// Makes candidates of the pending pairs that touched, and of those that no plane separates.
#[inline(always)]
fn settle<S: Registers, K: Kind>(
    registers: S,
    pending: &mut Pending<'_>,
    laws: &Laws,
    candidates: &mut Candidates,
) {
    let looked_at = (1u32 << pending.lanes) - 1;
    let apart = if K::SPHERES || looked_at == 0 {
        0
    } else {
        let Pending {
            i,
            j,
            start,
            bounds,
            ..
        } = &mut *pending;
        separated_by::<S, K>(registers, i, j, start, bounds, !looked_at) & looked_at
    };
    let batches = &mut candidates.batches;
    for k in 0..pending.count {
        let touched = pending.touched >> k & 1 != 0;
        let start = match pending.start.get(usize::from(pending.lane[k])) {
            Some(_) if apart >> pending.lane[k] & 1 != 0 => continue,
            Some(Line([x, y, z, ..])) => [*x, *y, *z],
            // No unit vector stands for the direction between the centres.
            None => [0.0; 3],
        };
        let pair = pending.waiting[k];
        // A batch has one kind of law.
        let other_kinds = laws.types() > 1
            && batches
                .last()
                .is_some_and(|last| laws.at(last.law).kinds != laws.at(pair.law).kinds);
        batches.push(pair, touched, &pending.history[k], start, other_kinds);
    }
    pending.touched = 0;
    pending.count = 0;
    pending.lanes = 0;
}
