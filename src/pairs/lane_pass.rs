// SPDX-License-Identifier: MIT OR Apache-2.0
//! A neighbour list in lanes: which pairs may touch, which of these a plane separates, and the contacts a batch at a time.
//!
//! The order in which forces are added up is that of the list, whatever was left out on the way.

use super::batch::{run as run_batch, separated_by, Batch, BatchResult, Common};
use super::candidates::{Candidate, Candidates};
use super::instruction_set::Stage;
use super::neighbour_list::{NeighbourRow, NeighbourRows, Pass, Place};
use super::particles::{Record, Records, Workspace};
use super::registers::{Line, Registers, MOST_LANES};
use super::tallies::Contribution;
use crate::geometry::Vector3;

/// Steps towards a separating plane when the candidates are chosen.
const IMPROVEMENTS: usize = 2;
/// Pairs between the one that is loaded and the one whose memory is asked for.
const AHEAD: usize = 16;
/// Marks a candidate that this step rejected.
const REJECTED: u32 = u32::MAX;

/// See [`Pass::find_candidates`].
struct FindCandidates<'p, 'a, 'b, 'c, R: NeighbourRows> {
    pass: &'p mut Pass<'a, 'b, 'c, R>,
    records: &'p [Record],
    candidates: &'p mut Candidates,
}

impl<R: NeighbourRows> Stage for FindCandidates<'_, '_, '_, '_, R> {
    #[inline(always)]
    fn run<S: Registers>(self, registers: S) {
        self.pass
            .find_candidates(registers, self.records, self.candidates);
    }
}

/// See [`Pass::reject`].
struct Reject<'p, 'a, 'b, 'c, R: NeighbourRows> {
    pass: &'p mut Pass<'a, 'b, 'c, R>,
    records: &'p [Record],
    candidates: &'p mut Candidates,
}

impl<R: NeighbourRows> Stage for Reject<'_, '_, '_, '_, R> {
    #[inline(always)]
    fn run<S: Registers>(self, registers: S) {
        self.pass.reject(registers, self.records, self.candidates);
    }
}

/// See [`Pass::contacts`].
struct Contacts<
    'p,
    'a,
    'b,
    'c,
    R: NeighbourRows,
    const FRICTION: bool,
    const RATE: bool,
    const CONSERVATIVE: bool,
    const SPHERES: bool,
> {
    pass: &'p mut Pass<'a, 'b, 'c, R>,
    particles: &'p mut Records,
    candidates: &'p Candidates,
}

impl<R: NeighbourRows, const F: bool, const V: bool, const C: bool, const B: bool> Stage
    for Contacts<'_, '_, '_, '_, R, F, V, C, B>
{
    #[inline(always)]
    fn run<S: Registers>(self, registers: S) {
        self.pass
            .contacts::<S, F, V, C, B>(registers, self.particles, self.candidates);
    }
}

/// Pairs on their way to the test for a separating plane.
struct Pending<'a> {
    i: [&'a Record; MOST_LANES],
    j: [&'a Record; MOST_LANES],
    start: [Line; MOST_LANES],
    count: usize,
}

impl<'a> Pending<'a> {
    fn new(any: &'a Record) -> Self {
        Pending {
            i: [any; MOST_LANES],
            j: [any; MOST_LANES],
            start: [Line::ZERO; MOST_LANES],
            count: 0,
        }
    }

    /// `start`: a normal, or anything else for the direction between the centres.
    #[inline(always)]
    fn push(&mut self, i: &'a Record, j: &'a Record, start: Option<&[f64]>) {
        let k = self.count;
        self.i[k] = i;
        self.j[k] = j;
        let line = &mut self.start[k].0;
        match start {
            // One by one: a copy of unknown length is a call.
            Some(n) => {
                line[0] = n[0];
                line[1] = n[1];
                line[2] = n[2];
            }
            None => line[..3].fill(0.0),
        }
        self.count = k + 1;
    }

    /// Bits of the pairs that are apart. Lanes beyond the pairs hold what was there before.
    #[inline(always)]
    fn separated<S: Registers>(&mut self, registers: S, margin: f64, improvements: usize) -> u32 {
        let s = &self.start;
        let start = [&s[0], &s[1], &s[2], &s[3], &s[4], &s[5], &s[6], &s[7]];
        self.count = 0;
        separated_by(registers, &self.i, &self.j, start, margin, improvements)
    }
}

impl<R: NeighbourRows> Pass<'_, '_, '_, R> {
    /// The whole list on the workspace's instruction set.
    pub(super) fn in_lanes<const FRICTION: bool, const RATE: bool, const CONSERVATIVE: bool>(
        mut self,
        workspace: &mut Workspace,
    ) -> u64 {
        let set = workspace.instruction_set;
        let (particles, candidates) = (&mut workspace.records, &mut workspace.candidates);
        if particles.records.is_empty() {
            return 0;
        }
        let pass = &mut self;
        if !candidates.are_valid() {
            let records = &particles.records[..];
            set.run(FindCandidates {
                pass: &mut *pass,
                records,
                candidates: &mut *candidates,
            });
        }
        if let Some(t) = pass.tallies.as_deref_mut() {
            t.pairs += candidates.listed;
        }
        set.run(Reject {
            pass: &mut *pass,
            records: &particles.records,
            candidates: &mut *candidates,
        });
        if candidates.spheres {
            // The conservative law adds nothing to a force between spheres.
            set.run(Contacts::<R, FRICTION, RATE, false, true> {
                pass: &mut *pass,
                particles: &mut *particles,
                candidates,
            });
        } else {
            set.run(Contacts::<R, FRICTION, RATE, CONSERVATIVE, false> {
                pass: &mut *pass,
                particles: &mut *particles,
                candidates,
            });
        }
        pass.add_sums(particles, candidates);
        self.many_starts
    }

    /// Goes through the whole list for pairs that may touch before the particles have moved by the margin.
    #[inline(always)]
    fn find_candidates<S: Registers>(
        &mut self,
        registers: S,
        records: &[Record],
        candidates: &mut Candidates,
    ) {
        let entries = self.rows.entries();
        let layout = self.layout;
        let length = layout.length;
        let margin = candidates.margin;
        let spheres = records.iter().all(Record::is_sphere);
        candidates.spheres = spheres;
        let nowhere = Candidate {
            entry: 0,
            i: 0,
            j: 0,
        };
        let listed = (0..self.rows.count())
            .map(|row| self.rows.row(row).neighbours.len())
            .sum();
        candidates.reserve(listed);
        let mut waiting = [nowhere; MOST_LANES];
        let mut stay = 0u32;
        let mut pending = Pending::new(&records[0]);
        for row in 0..self.rows.count() {
            let NeighbourRow {
                central,
                neighbours,
                touching,
                history,
            } = self.rows.row(row);
            let i = &records[central];
            let (centre, radius) = (i.position(), i.radius());
            for (entry, &named) in neighbours.iter().enumerate() {
                let Some(other) = entries.index(named) else {
                    continue;
                };
                let j = &records[other];
                let d = j.position() - centre;
                let reach = radius + j.radius() + margin;
                let touched = touching.get(entry).is_some_and(|t| *t != 0);
                let near = d.norm_squared() < reach * reach;
                if !near && !touched {
                    continue;
                }
                let candidate = Candidate {
                    entry: entry as u32,
                    i: central as u32,
                    j: other as u32,
                };
                if spheres {
                    candidates.pairs.push(candidate);
                    continue;
                }
                // One that touched is looked at in any case: its history ends when it ends.
                stay |= u32::from(touched) << pending.count;
                waiting[pending.count] = candidate;
                let start = layout
                    .normal
                    .map(|at| &history[entry * length + at..entry * length + at + 3]);
                pending.push(i, j, start);
                if pending.count == S::LANES {
                    let apart = pending.separated(registers, margin, IMPROVEMENTS) & !stay;
                    stay = 0;
                    for (k, &candidate) in waiting[..S::LANES].iter().enumerate() {
                        if apart >> k & 1 == 0 {
                            candidates.pairs.push(candidate);
                        }
                    }
                }
            }
        }
        let left = pending.count;
        if left > 0 {
            let apart = pending.separated(registers, margin, IMPROVEMENTS) & !stay;
            for (k, &candidate) in waiting[..left].iter().enumerate() {
                if apart >> k & 1 == 0 {
                    candidates.pairs.push(candidate);
                }
            }
        }
        candidates.end();
    }

    /// Leaves in `near` the candidates that touched at the last step or that no plane at hand separates.
    #[inline(always)]
    fn reject<S: Registers>(
        &mut self,
        registers: S,
        records: &[Record],
        candidates: &mut Candidates,
    ) {
        let layout = self.layout;

        let Candidates {
            pairs,
            near,
            spheres,
            ..
        } = candidates;
        near.clear();
        let mut places = [0usize; MOST_LANES];
        let mut pending = Pending::new(&records[0]);
        for (number, c) in pairs.iter().enumerate() {
            if let Some(c) = pairs.get(number + AHEAD) {
                if let Some(first) = self.rows.pair(c.i as usize, c.entry as usize).1.first() {
                    registers.prefetch(first);
                }
            }
            let (touching, history) = self.rows.pair(c.i as usize, c.entry as usize);
            let (i, j) = (&records[c.i as usize], &records[c.j as usize]);
            let touched = touching.as_ref().is_some_and(|t| **t != 0);
            if *spheres {
                let reach = i.pose.0[7] + j.pose.0[7];
                let d = j.position() - i.position();
                if d.norm_squared() < reach * reach {
                    near.push(number as u32);
                } else if let Some(touching) = touching.filter(|_| touched) {
                    *touching = 0;
                    super::neighbour_list::forget(&layout, history);
                }
                continue;
            }
            if !touched {
                places[pending.count] = near.len();
                let start = layout.normal.map(|at| &history[at..at + 3]);
                pending.push(i, j, start);
            }
            near.push(number as u32);
            if pending.count == S::LANES {
                let apart = pending.separated(registers, 0.0, 0);
                for (k, &place) in places[..S::LANES].iter().enumerate() {
                    if apart >> k & 1 != 0 {
                        near[place] = REJECTED;
                    }
                }
            }
        }
        let left = pending.count;
        if left > 0 {
            let apart = pending.separated(registers, 0.0, 0);
            for (k, &place) in places[..left].iter().enumerate() {
                if apart >> k & 1 != 0 {
                    near[place] = REJECTED;
                }
            }
        }
    }

    /// Search, law and scatter of what is near.
    #[inline(always)]
    fn contacts<
        S: Registers,
        const FRICTION: bool,
        const RATE: bool,
        const CONSERVATIVE: bool,
        const SPHERES: bool,
    >(
        &mut self,
        registers: S,
        particles: &mut Records,
        candidates: &Candidates,
    ) {
        let Records {
            records,
            types,
            inverse_masses,
            sums,
        } = particles;
        let laws = self.laws;
        let layout = self.layout;
        let one_type = laws.types() == 1;
        let common = Common {
            layout,
            time: if self.step.advance_history {
                self.step.time_step
            } else {
                0.0
            },
            only_law: one_type.then(|| laws.get(1, 1)),
            tally: self.tallies.is_some(),
        };
        let mut batch = Batch {
            i: [&records[0]; MOST_LANES],
            j: [&records[0]; MOST_LANES],
            laws: [laws.get(1, 1); MOST_LANES],
            history: [Line::ZERO; MOST_LANES],
            continued: Line::ZERO,
            inverse_effective_mass: Line::ZERO,
        };
        let mut result = BatchResult::EMPTY;
        let mut places = [Place {
            entry: 0,
            i: 0,
            j: 0,
        }; MOST_LANES];
        let single = Single {
            records,
            types,
            inverse_masses,
        };
        let mut open = Open {
            particle: 0,
            sum: Line::ZERO,
        };
        let near = &candidates.near[..];
        let mut next = 0;
        loop {
            let mut count = 0;
            while count < S::LANES && next < near.len() {
                let number = near[next];
                if let Some(ahead) = near.get(next + AHEAD).filter(|n| **n != REJECTED) {
                    let c = candidates.pairs[*ahead as usize];
                    if let Some(first) = self.rows.pair(c.i as usize, c.entry as usize).1.first() {
                        registers.prefetch(first);
                    }
                    registers.prefetch(&records[c.j as usize].pose.0[0]);
                    registers.prefetch(&records[c.j as usize].motion.0[0]);
                }
                next += 1;
                if number == REJECTED {
                    continue;
                }
                let c = candidates.pairs[number as usize];
                let place = Place {
                    entry: c.entry as usize,
                    i: c.i as usize,
                    j: c.j as usize,
                };
                let (touching, history) = self.rows.pair(place.i, place.entry);
                let touched = touching.is_some_and(|t| *t != 0);
                if !SPHERES {
                    // Without a normal from the last step the search begins with the safeguards. It is read from where
                    // it is remembered: a line just written would have to be waited for.
                    let known = layout.normal.is_some() && {
                        let n = &*history;
                        let square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
                        (square - 1.0).abs() < 1e-6
                    };
                    if !known {
                        self.scalar_pair::<FRICTION, RATE, CONSERVATIVE>(place, single);
                        continue;
                    }
                }
                if !one_type {
                    let law = laws.get(types[place.i] as usize, types[place.j] as usize);
                    if count > 0 && batch.laws[0].kinds != law.kinds {
                        // A batch has one kind of law; this pair begins the next.
                        next -= 1;
                        break;
                    }
                    batch.laws[count] = law;
                }
                batch.i[count] = &records[place.i];
                batch.j[count] = &records[place.j];
                batch.history[count] = line_of(history);
                if FRICTION {
                    batch.continued.0[count] = f64::from(u8::from(touched));
                }
                if let (Some(a), Some(b)) =
                    (inverse_masses.get(place.i), inverse_masses.get(place.j))
                {
                    batch.inverse_effective_mass.0[count] = a + b;
                }
                places[count] = place;
                count += 1;
            }
            if count == 0 {
                break;
            }
            // The last pair fills the lanes that are left over; its copies are not used.
            for k in count..S::LANES {
                batch.i[k] = batch.i[count - 1];
                batch.j[k] = batch.j[count - 1];
                batch.laws[k] = batch.laws[count - 1];
                batch.history[k] = batch.history[count - 1];
            }
            run_batch::<S, FRICTION, RATE, CONSERVATIVE, SPHERES>(
                registers,
                &batch,
                &common,
                &mut result,
            );
            self.finish::<FRICTION, RATE>(&places[..count], &result, sums, &mut open, common.time);
            let mut hard = result.hard & ((1 << count) - 1);
            while hard != 0 {
                let place = places[hard.trailing_zeros() as usize];
                hard &= hard - 1;
                self.scalar_pair::<FRICTION, RATE, CONSERVATIVE>(place, single);
            }
        }
        add(&mut sums[open.particle], &open.sum);
    }

    /// Scatter of a batch, the hard lanes apart.
    #[inline(always)]
    fn finish<const FRICTION: bool, const RATE: bool>(
        &mut self,
        places: &[Place],
        result: &BatchResult,
        sums: &mut [Line],
        open: &mut Open,
        time: f64,
    ) {
        let layout = self.layout;
        let aside = result.hard | result.separated;
        for (k, &place) in places.iter().enumerate() {
            if aside >> k & 1 != 0 {
                if result.separated >> k & 1 != 0 {
                    let n = &result.history[k].0;
                    let normal = layout.normal.map(|_| Vector3::new(n[0], n[1], n[2]));
                    self.separated(place, normal);
                }
                continue;
            }
            let (touching, history) = self.memory(place);
            if let Some(t) = touching {
                *t = 1;
            }
            copy(&result.history[k], history);
            // Consecutive pairs mostly have the same first particle: its sum stays at hand.
            if open.particle != place.i {
                add(&mut sums[open.particle], &open.sum);
                *open = Open {
                    particle: place.i,
                    sum: result.on_i[k],
                };
            } else {
                add(&mut open.sum, &result.on_i[k]);
            }
            let reaction = place.j < self.accumulators.reaction_below;
            if reaction {
                add(&mut sums[place.j], &result.on_j[k]);
            }
            if RATE {
                if let Some(t) = self.tallies.as_deref_mut() {
                    let (e, f) = (&result.energies[k].0, &result.on_j[k].0);
                    t.add(
                        place.i,
                        Some(place.j),
                        reaction,
                        &Contribution {
                            normal_energy: e[0],
                            tangential_energy: e[1],
                            work: time * e[2],
                            d: Vector3::new(e[3], e[4], e[5]),
                            force: Vector3::new(f[0], f[1], f[2]),
                        },
                    );
                }
            }
        }
    }

    /// One pair with every safeguard.
    #[cold]
    fn scalar_pair<const FRICTION: bool, const RATE: bool, const CONSERVATIVE: bool>(
        &mut self,
        place: Place,
        single: Single<'_>,
    ) {
        let (i, j) = (single.particle(place.i), single.particle(place.j));
        let d = j.position - i.position;
        let reach = i.radius + j.radius;
        if d.norm_squared() < reach * reach {
            self.one_pair::<FRICTION, RATE, CONSERVATIVE>(place, &i, &j, d);
        } else {
            self.separated(place, None);
        }
    }

    /// Hands the sums of this step to the engine's arrays and clears them.
    #[inline(always)]
    fn add_sums(&mut self, particles: &mut Records, candidates: &Candidates) {
        let a = &mut *self.accumulators;
        for &k in candidates.participants() {
            let k = k as usize;
            let sum = &mut particles.sums[k].0;
            if k < a.reaction_below {
                let (force, torque) = (&mut a.forces[k], &mut a.torques[k]);
                for axis in 0..3 {
                    force[axis] += sum[axis];
                    torque[axis] += sum[3 + axis];
                }
            }
            *sum = Line::ZERO.0;
        }
    }
}

/// The sum of the particle whose row is being gone through.
struct Open {
    particle: usize,
    sum: Line,
}

/// Where the particles of a single pair are read.
#[derive(Clone, Copy)]
struct Single<'a> {
    records: &'a [Record],
    types: &'a [u32],
    inverse_masses: &'a [f64],
}

impl Single<'_> {
    fn particle(&self, k: usize) -> super::particles::Particle {
        let inverse_mass = self.inverse_masses.get(k).copied().unwrap_or(0.0);
        self.records[k].particle(self.types[k], inverse_mass)
    }
}

/// A history in a line. Lengths are written out: a copy of unknown length is a call, and one of single doubles is waited
/// for when the line is loaded.
#[inline(always)]
fn line_of(history: &[f64]) -> Line {
    if let Ok(&[a, b, c, d, e, f]) = <&[f64; 6]>::try_from(history) {
        return Line([a, b, c, d, e, f, 0.0, 0.0]);
    }
    if let Ok(&[a, b, c]) = <&[f64; 3]>::try_from(history) {
        return Line([a, b, c, 0.0, 0.0, 0.0, 0.0, 0.0]);
    }
    let mut line = Line::ZERO;
    for (l, h) in line.0.iter_mut().zip(history) {
        *l = *h;
    }
    line
}

/// The reverse of [`line_of`].
#[inline(always)]
fn copy(line: &Line, history: &mut [f64]) {
    if let Ok(history) = <&mut [f64; 6]>::try_from(&mut *history) {
        let &[a, b, c, d, e, f, ..] = &line.0;
        *history = [a, b, c, d, e, f];
        return;
    }
    for (h, l) in history.iter_mut().zip(&line.0) {
        *h = *l;
    }
}

#[inline(always)]
fn add(sum: &mut Line, line: &Line) {
    for (s, l) in sum.0.iter_mut().zip(&line.0) {
        *s += l;
    }
}
