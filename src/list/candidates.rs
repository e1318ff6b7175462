//! The pairs of an engine's list that may touch while the particles move about as they do now.
//!
//! An engine's list holds every pair whose bounding spheres come near; of elongated grains few of these ever touch. Each particle is
//! expected to go on with its velocity for some steps, and is allowed to be elsewhere by a length of its own: fast ones among fast ones by
//! much, those of a bed at rest or of one that moves as a whole by little. A pair whose bodies a plane separates, whatever they do of
//! that, is left out until the steps are over, one of the particles is found where it is not allowed to be, or the list changes. That
//! decides which pairs are looked at, never what a pair's force is.

use super::arrays::{ParticleArrays, ParticleShapes};
use super::batches::Batches;
use super::memory::{reserve, Allocated};
use super::records::{Record, Shapes};
use super::shapes::same;
use crate::geometry::small_motion::{allowed_turn, allowed_turn_per_margin, way_and_turn};
use crate::real::Real;
use crate::simd::{Lanes, Line, Registers, MOST_LANES};
use crate::vector::Vector3;
use core::sync::atomic::{AtomicBool, Ordering};

/// Steps that are expected at first, and at most.
const FIRST_HORIZON: f64 = 24.0;
const LONGEST_HORIZON: f64 = 1e3;
/// What is allowed at first, in steps with the largest velocity relative to a neighbour, and within which it follows the motion.
const FIRST_ALLOWANCE: f64 = 12.0;
const ALLOWANCES: [f64; 2] = [0.25, 1e3];
/// The least velocity for which a particle is allowed anything, in mean smallest semi-axes a step.
const LEAST_VELOCITY: f64 = 2e-6;
/// The largest way that it is allowed, in mean smallest semi-axes.
const LARGEST_WAY: f64 = 0.1;
/// By how much horizon and allowance change at most at once.
const LARGEST_CHANGE: f64 = 4.0;
/// How much more is allowed than the farthest motion needed.
const SPARE: f64 = 1.3;
/// How much more than it turns by in the steps that are expected a particle is allowed to turn: its rotation is bounded from above.
const SPARE_TURN: f64 = 1.1;

/// What it costs to find the candidates, in units of a candidate's computation: per pair of the list, per pair whose
/// bounding spheres come near, and per particle. Only their sum was measured: some 12 units a grain in a drum that turns, of 18 listed
/// pairs and 14 near ones; how it divides is a guess. The best number of steps is flat: it goes with the root of the cost.
const COST_OF_LISTED: f64 = 0.2;
const COST_OF_NEAR: f64 = 0.4;
const COST_OF_PARTICLE: f64 = 3.0;

/// A change that is made at once.
fn limited(change: f64) -> f64 {
    change.clamp(1.0 / LARGEST_CHANGE, LARGEST_CHANGE)
}

/// Where a block of particles is expected and allowed to be, number by number, as the lanes load it.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Expected {
    position: [[f64; MOST_LANES]; 3],
    /// As the engine has it.
    quaternion: [[f64; MOST_LANES]; 4],
    semi_axes: [[f64; MOST_LANES]; 3],
    /// Of a step.
    way: [[f64; MOST_LANES]; 3],
    /// Squares of the way that a particle may be elsewhere, and of the change of its quaternion that is allowed.
    allowed_way: [f64; MOST_LANES],
    allowed_turn: [f64; MOST_LANES],
}

impl Expected {
    const NOTHING: Expected = Expected {
        position: [[0.0; MOST_LANES]; 3],
        quaternion: [[0.0; MOST_LANES]; 4],
        semi_axes: [[0.0; MOST_LANES]; 3],
        way: [[0.0; MOST_LANES]; 3],
        allowed_way: [0.0; MOST_LANES],
        allowed_turn: [0.0; MOST_LANES],
    };
}

/// Candidates, and the motions for which they were found.
#[derive(Debug, Default)]
pub(super) struct Candidates {
    pub batches: Batches,
    /// Pairs of the list.
    pub listed: u64,
    /// Particles that have a candidate, in rising order.
    participants: Vec<u32>,
    /// Of which particles a step makes records: of these, and of those that walls have asked for.
    with_record: Vec<bool>,
    asked_for: AskedFor,
    expected: Vec<Expected>,
    /// Of each particle the way that is expected in a step, by how much its support function changes as it turns in the time of a step,
    /// square of the largest velocity relative to a neighbour, -1 without one, and by how much a gap may be another than expected.
    motions: Vec<Line>,
    /// Particles below this index are the caller's own; the list has no pairs of two others.
    owned: usize,
    /// Mean of the smallest semi-axes.
    size: f64,
    /// Steps that are expected; 0 before the first time.
    horizon: f64,
    /// See [`FIRST_ALLOWANCE`].
    allowance: f64,
    /// Steps since the candidates were found.
    steps: u32,
    /// The last of them.
    last: u32,
    /// Lanes that were computed for nothing in the first of them.
    idle: f64,
    /// What finding them cost, in units of a lane's computation.
    cost: f64,
    valid: bool,
}

/// Particles that touch no other, of which somebody else needs records all the same, as walls do: from the next step on they are made with those
/// of the pairs, for all walls at once. Whoever reads the records may ask: hence the atomic types, which cost nothing here.
#[derive(Debug, Default)]
pub(super) struct AskedFor {
    particles: Vec<AtomicBool>,
    any: AtomicBool,
}

impl AskedFor {
    /// For so many particles, none of which anybody has asked for.
    fn start(&mut self, count: usize) {
        self.particles.clear();
        self.particles.resize_with(count, AtomicBool::default);
        *self.any.get_mut() = false;
    }

    /// Asks for one.
    #[inline(always)]
    pub fn ask(&self, particle: usize) {
        if let Some(asked) = self.particles.get(particle) {
            asked.store(true, Ordering::Relaxed);
            self.any.store(true, Ordering::Relaxed);
        }
    }

    /// Adds those that were asked for.
    fn hand_over(&mut self, all: &mut [bool]) {
        if !core::mem::take(self.any.get_mut()) {
            return;
        }
        for (asked, all) in self.particles.iter_mut().zip(all) {
            *all |= core::mem::take(asked.get_mut());
        }
    }
}

/// What a pair may do while the candidates hold.
#[derive(Clone, Copy)]
pub(super) struct Bound {
    /// The way of the second particle relative to the first that is expected.
    closing: Vector3,
    /// By how much more the bodies may come nearer.
    margin: f64,
}

impl Bound {
    /// By how much the bodies come nearer at most.
    #[inline(always)]
    pub fn farthest(&self) -> f64 {
        self.margin + self.closing.norm_squared().sqrt()
    }

    /// As the lanes load it.
    #[inline(always)]
    pub fn line(&self) -> Line {
        let c = self.closing;
        Line([c.x, c.y, c.z, self.margin, 0.0, 0.0, 0.0, 0.0])
    }
}

impl Candidates {
    /// None: the next step looks at the whole list.
    pub fn forget(&mut self) {
        self.valid = false;
    }

    /// Whether there are candidates.
    pub fn are_valid(&self) -> bool {
        self.valid
    }

    /// The candidates, and the particles that have one, in rising order.
    pub fn parts(&mut self) -> (&mut Batches, &[u32]) {
        (&mut self.batches, &self.participants)
    }

    /// Of each particle whether a step makes a record of it, and where to ask for others; `None` where there are no candidates.
    pub fn with_records(&self) -> Option<(&[bool], &AskedFor)> {
        self.valid
            .then_some((&self.with_record[..], &self.asked_for))
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.batches.bytes()
            + self.participants.capacity() * core::mem::size_of::<u32>()
            + self.with_record.capacity()
            + self.asked_for.particles.capacity()
            + self.expected.capacity() * core::mem::size_of::<Expected>()
            + self.motions.capacity() * core::mem::size_of::<Line>()
    }

    /// Whether there are candidates for as many particles.
    pub fn are_for(&self, count: usize) -> bool {
        self.valid && self.motions.len() == count
    }

    /// Of the particles from `first` on: those that have the same shape and are where they are allowed to be, and those of which records are
    /// made. `shapes` are semi-axes, quaternion and anything.
    #[inline(always)]
    pub fn hold_for<S: Registers>(
        &self,
        registers: S,
        first: usize,
        count: usize,
        x: [Lanes<S>; 3],
        shapes: &[Lanes<S>; 8],
    ) -> (u32, u32) {
        let (block, lane) = (first / MOST_LANES, first % MOST_LANES);
        let e = &self.expected[block];
        let [x0, w, a] = [&e.position, &e.way, &e.semi_axes];
        let steps = Lanes::splat(registers, f64::from(self.steps));
        let column = ColumnsFrom { registers, lane };
        let expected = [
            column.of(&w[0]).multiply_add(steps, column.of(&x0[0])),
            column.of(&w[1]).multiply_add(steps, column.of(&x0[1])),
            column.of(&w[2]).multiply_add(steps, column.of(&x0[2])),
        ];
        let q = [shapes[3], shapes[4], shapes[5], shapes[6]];
        let [q0, q1, q2, q3] = &e.quaternion;
        let before = [column.of(q0), column.of(q1), column.of(q2), column.of(q3)];
        let (moved, turned) = way_and_turn(expected, x, before, q);
        // Not a number holds for nothing.
        let near = registers.and(
            moved.less(column.of(&e.allowed_way)),
            turned.less(column.of(&e.allowed_turn)),
        );
        let same = registers.and(
            same(registers, shapes[0], column.of(&a[0])),
            registers.and(
                same(registers, shapes[1], column.of(&a[1])),
                same(registers, shapes[2], column.of(&a[2])),
            ),
        );
        let mut has_records = 0;
        for (lane, with_record) in self.with_record[first..first + count].iter().enumerate() {
            has_records |= u32::from(*with_record) << lane;
        }
        (registers.bits(registers.and(near, same)), has_records)
    }

    /// Whether a record is made of a particle.
    #[inline(always)]
    pub fn has_record(&self, particle: usize) -> bool {
        self.with_record.get(particle).is_some_and(|t| *t)
    }

    /// One step more with these candidates, in which records are made of what was asked for too; whether they are for it.
    pub fn count_step(&mut self) -> bool {
        self.asked_for.hand_over(&mut self.with_record);
        self.steps = self.steps.saturating_add(1);
        if self.steps == 1 {
            self.idle = self.batches.idle() as f64;
            // Beyond twice the best number of steps, those are fewer that are expected next.
            let enough = (2.0 * self.cost / self.idle.max(1.0)) as u32;
            self.last = (self.horizon as u32).min(enough).max(1);
        }
        self.steps <= self.last
    }

    /// How much longer it would pay to go on than these candidates would have served.
    ///
    /// More steps and more freedom let more pairs in that do not touch, in proportion, and last longer, in proportion: together they
    /// cost least where the candidates cost as much to find as those pairs do while they last.
    fn best_change(&self, served: f64) -> f64 {
        let lanes = self.idle.max(1.0) * served;
        limited((self.cost / lanes).sqrt())
    }

    fn adapt(&mut self, horizon: f64, allowance: f64) {
        self.horizon = horizon.clamp(1.0, LONGEST_HORIZON);
        self.allowance = allowance.clamp(ALLOWANCES[0], ALLOWANCES[1]);
    }

    /// Lets horizon and allowance follow the motion, all of which were as expected to the end.
    pub fn adapt_at_end<S: ParticleShapes, I: Fn(usize) -> i64>(
        &mut self,
        arrays: &ParticleArrays<'_, S, I>,
    ) {
        let last = f64::from(self.last);
        let best = self.best_change(last);
        let used = self.share_used(arrays) * best;
        // Between enough and more than that by what is to spare, it stays.
        let needed = (SPARE * used).min(used.max(1.0));
        self.adapt(last * best, self.allowance * limited(needed));
    }

    /// The same where a particle has left the place that it was allowed.
    ///
    /// It may be one of many that were struck, or the first of all: the candidates would have served between these steps and the last.
    pub fn adapt_when_left(&mut self) {
        let (steps, last) = (f64::from(self.steps), f64::from(self.last));
        let served = (steps * last).sqrt();
        let next = served * self.best_change(served);
        self.adapt(next, self.allowance * limited(next / steps));
    }

    /// How much of what they are allowed the farthest motion has used up.
    fn share_used<S: ParticleShapes, I: Fn(usize) -> i64>(
        &self,
        arrays: &ParticleArrays<'_, S, I>,
    ) -> f64 {
        let steps = f64::from(self.steps);
        let mut largest: f64 = 0.0;
        for (k, x) in arrays.positions.iter().enumerate() {
            let Some((_, q)) = arrays.shape.of(k) else {
                continue;
            };
            let (e, lane) = (&self.expected[k / MOST_LANES], k % MOST_LANES);
            let expected = [0, 1, 2].map(|c| e.position[c][lane] + steps * e.way[c][lane]);
            let before = e.quaternion.map(|q| q[lane]);
            let (moved, turned) = way_and_turn(expected, *x, before, q);
            let shares = [moved / e.allowed_way[lane], turned / e.allowed_turn[lane]];
            largest = largest.max(shares[0]).max(shares[1]);
        }
        largest.min(1.0).sqrt()
    }

    /// Begins anew for these particles, where they are.
    pub fn begin<S: ParticleShapes, I: Fn(usize) -> i64>(
        &mut self,
        arrays: &ParticleArrays<'_, S, I>,
        allocated: Allocated,
    ) {
        self.valid = false;
        self.batches.allocated = allocated;
        let count = arrays.positions.len();
        self.motions.clear();
        reserve(&mut self.motions, count, allocated);
        self.motions.resize(count, Line::ZERO);
        let blocks = count.div_ceil(MOST_LANES);
        self.expected.clear();
        reserve(&mut self.expected, blocks, allocated);
        self.expected.resize(blocks, Expected::NOTHING);
        let mut sum = 0.0;
        for (k, x) in arrays.positions.iter().enumerate() {
            // They were checked before.
            let (a, q) = arrays
                .shape
                .of(k)
                .unwrap_or(([1.0; 3], [1.0, 0.0, 0.0, 0.0]));
            sum += a[0].min(a[1]).min(a[2]);
            let (e, lane) = (&mut self.expected[k / MOST_LANES], k % MOST_LANES);
            let pairs = [(&mut e.position, x), (&mut e.semi_axes, &a)];
            for (columns, values) in pairs {
                for (column, value) in columns.iter_mut().zip(values) {
                    column[lane] = *value;
                }
            }
            for (column, value) in e.quaternion.iter_mut().zip(q) {
                column[lane] = value;
            }
        }
        if self.horizon == 0.0 {
            (self.horizon, self.allowance) = (FIRST_HORIZON, FIRST_ALLOWANCE);
        }
        // A whole number, as the steps are.
        self.horizon = self.horizon.round();
        self.steps = 0;
        self.owned = arrays.owned;
        self.size = sum / count.max(1) as f64;
    }

    /// The motions that are expected of the particles, in steps of this time.
    pub fn expect(&mut self, records: &[Record], shapes: Shapes, time_step: f64) {
        for (k, (record, motion)) in records.iter().zip(&mut self.motions).enumerate() {
            let [v, omega] = record.velocities(shapes);
            let way = (v * time_step).to_array();
            let (e, lane) = (&mut self.expected[k / MOST_LANES], k % MOST_LANES);
            for (to, way) in e.way.iter_mut().zip(way) {
                to[lane] = way;
            }
            let [a, b, c] = e.semi_axes.map(|a| a[lane]);
            // The support function of a body that turns by an angle changes by at most the angle times this.
            let spread = a.max(b).max(c) - a.min(b).min(c);
            let turn = omega.norm_squared().sqrt() * (time_step * spread).abs();
            let [x, y, z] = way;
            *motion = Line([x, y, z, turn, -1.0, 0.0, 0.0, 0.0]);
        }
    }

    /// Of a particle and its neighbours, the largest velocity of one relative to the other.
    #[inline(always)]
    pub fn meet(&mut self, particle: usize, others: impl Iterator<Item = usize>) {
        let Some(Line([x, y, z, _, largest, ..])) = self.motions.get(particle).copied() else {
            return;
        };
        let mut own = largest;
        for other in others {
            if let Some(Line([u, v, w, _, largest, ..])) = self.motions.get_mut(other) {
                let (u, v, w) = (*u - x, *v - y, *w - z);
                let square = u * u + v * v + w * w;
                *largest = largest.max(square);
                own = own.max(square);
            }
        }
        self.motions[particle].0[4] = own;
    }

    /// Allows each particle to be elsewhere than expected by some steps with that velocity, and to turn as it does; one without neighbours
    /// to be anywhere.
    pub fn allow(&mut self) {
        let least = LEAST_VELOCITY * self.size;
        let most = LARGEST_WAY * self.size;
        let met = |motion: &Line| (motion.0[4] >= 0.0).then_some(motion.0[4].sqrt());
        let count = self.motions.iter().filter_map(met).count().max(1);
        let mean = self.motions.iter().filter_map(met).sum::<f64>() / count as f64;
        for (k, motion) in self.motions.iter_mut().enumerate() {
            let (e, lane) = (&mut self.expected[k / MOST_LANES], k % MOST_LANES);
            let Some(mut velocity) = met(motion) else {
                e.allowed_way[lane] = f64::INFINITY;
                e.allowed_turn[lane] = f64::INFINITY;
                continue;
            };
            // What others that are not the caller's do to it is not in the list.
            if k >= self.owned {
                velocity = velocity.max(mean);
            }
            let way = (self.allowance * (least + velocity)).min(most);
            let turn = SPARE_TURN * self.horizon * motion.0[3] + way;
            motion.0[5] = way + turn;
            e.allowed_way[lane] = way * way;
            let q = e.quaternion.map(|q| q[lane]);
            let per_margin = allowed_turn_per_margin(e.semi_axes.map(|a| a[lane]), q);
            let of_quarter = 4.0 * turn;
            e.allowed_turn[lane] = allowed_turn(per_margin, of_quarter * of_quarter, &q);
        }
    }

    /// What two particles may do.
    #[inline(always)]
    pub fn bound(&self, i: usize, j: usize) -> Bound {
        let (i, j) = (&self.motions[i].0, &self.motions[j].0);
        let way = Vector3::new(j[0] - i[0], j[1] - i[1], j[2] - i[2]);
        Bound {
            closing: way * self.horizon,
            margin: i[5] + j[5],
        }
    }

    /// Ends what [`Candidates::begin`] began, once all pairs of a list of this length are there, of which so many were near
    /// enough to be looked at.
    pub fn end(&mut self, listed: usize, near: usize) {
        self.listed = listed as u64;
        self.cost = COST_OF_LISTED * listed as f64
            + COST_OF_NEAR * near as f64
            + COST_OF_PARTICLE * self.motions.len() as f64;
        self.batches.reserve(listed);
        self.batches.end();
        self.participants.clear();
        self.with_record.clear();
        self.with_record.resize(self.motions.len(), false);
        for k in self.batches.particles() {
            self.with_record[k as usize] = true;
        }
        self.participants.reserve(self.motions.len());
        self.participants.extend(
            self.with_record
                .iter()
                .enumerate()
                .filter(|(_, with_record)| **with_record)
                .map(|(k, _)| k as u32),
        );
        self.asked_for.start(self.motions.len());
        self.valid = true;
    }
}

/// Loads numbers of a block of particles from one of them on.
#[derive(Clone, Copy)]
struct ColumnsFrom<S> {
    registers: S,
    lane: usize,
}

impl<S: Registers> ColumnsFrom<S> {
    #[inline(always)]
    fn of(self, column: &[f64; MOST_LANES]) -> Lanes<S> {
        Lanes::load(self.registers, &column[self.lane..])
    }
}

#[cfg(test)]
mod tests {
    use super::super::{
        compute_pairs, Accumulators, Entries, NeighbourRow, NeighbourRows, ParticleArrays,
        Rotation, Workspace,
    };
    use crate::contact::{Laws, Step};
    use crate::force::syntax;
    use crate::simd::InstructionSet;

    const COUNT: usize = 9;

    /// Every pair, without histories.
    struct AllPairs(Vec<i32>);

    impl NeighbourRows for AllPairs {
        fn count(&self) -> usize {
            COUNT
        }
        fn row(&mut self, k: usize) -> NeighbourRow<'_> {
            NeighbourRow {
                central: k,
                neighbours: &self.0[k + 1..],
                touching: &mut [],
                history: &mut [],
            }
        }
        fn pair(&mut self, _: usize, _: usize) -> (Option<&mut i32>, &mut [f64]) {
            (None, &mut [])
        }
        fn entries(&self) -> Entries {
            Entries::PLAIN
        }
    }

    /// Spheroids in a row, a little apart from each other, `steps` steps of which are moved by `motion`: how often candidates were found,
    /// and the sum of the forces' sizes in the last step.
    fn row_of_grains(
        set: InstructionSet,
        steps: usize,
        motion: impl Fn(usize, &mut [[f64; 3]; COUNT]) -> [[f64; 3]; COUNT],
    ) -> (usize, f64) {
        let (parameters, _) = syntax::parse(&["hertz", "1e7", "0.3"]).unwrap();
        let laws = Laws::new(1, &[Some(parameters)], false).unwrap();
        let mut positions = core::array::from_fn(|k| [1.5 * k as f64, 0.0, 0.0]);
        let mut rows = AllPairs((0..COUNT as i32).collect());
        let mut workspace = Workspace::new(set);
        let (mut found, mut sum) = (0, 0.0);
        for step in 0..steps {
            let velocities = motion(step, &mut positions);
            let particles = ParticleArrays {
                owned: COUNT,
                positions: &positions,
                velocities: &velocities,
                rotation: Rotation::Velocity(&[[0.0; 3]; COUNT]),
                of_step: false,
                changes: &[],
                contact_masses: &[],
                types: &[1; COUNT],
                shape: |_: usize| Some(([0.7, 0.7, 1.0], [1.0, 0.0, 0.0, 0.0])),
                identifier: |k| k as i64 + 1,
            };
            workspace
                .prepare_for_pairs(&particles, &laws, step > 0)
                .unwrap();
            let (mut forces, mut torques) = ([[0.0; 3]; COUNT], [[0.0; 3]; COUNT]);
            let mut accumulators = Accumulators {
                forces: &mut forces,
                torques: &mut torques,
                reaction_below: COUNT,
                owned: COUNT,
            };
            let step = Step {
                time_step: 1.0,
                advance_history: true,
            };
            compute_pairs(
                &laws,
                &mut workspace,
                &mut rows,
                &step,
                &mut accumulators,
                None,
            )
            .unwrap();
            found += usize::from(workspace.candidates.steps == 0);
            sum = forces.iter().flatten().map(|f: &f64| f.abs()).sum();
        }
        (found, sum)
    }

    fn in_lanes() -> impl Iterator<Item = InstructionSet> {
        InstructionSet::ALL
            .into_iter()
            .filter(|set| *set != InstructionSet::Scalar && set.is_available())
    }

    /// A bed that moves as a whole by many grains' sizes, faster and faster by little: most steps look through no list.
    #[test]
    fn grains_that_go_together_are_looked_at_rarely() {
        for set in in_lanes() {
            let (found, sum) = row_of_grains(set, 400, |step, positions| {
                let v = [0.0, 2.0 + 1e-8 * step as f64, 0.0];
                for x in positions.iter_mut() {
                    x[1] += v[1];
                }
                [v; COUNT]
            });
            assert!(found <= 40 && sum == 0.0, "{set:?}: {found} {sum}");
        }
    }

    /// Grains that vibrate in place, each by itself: none goes on with its velocity for long, and few steps look through the list.
    #[test]
    fn grains_that_vibrate_in_place_are_looked_at_rarely() {
        const RATE: f64 = 0.1;
        for set in in_lanes() {
            let (found, sum) = row_of_grains(set, 1000, |step, positions| {
                let mut velocities = [[0.0; 3]; COUNT];
                for (k, x) in positions.iter_mut().enumerate() {
                    let amplitude = 1e-4 * (1 + k % 3) as f64;
                    let (sine, cosine) = (RATE * step as f64 + k as f64).sin_cos();
                    x[0] = 1.5 * k as f64 + amplitude * sine;
                    velocities[k][0] = RATE * amplitude * cosine;
                }
                velocities
            });
            assert!(found <= 40 && sum == 0.0, "{set:?}: {found} {sum}");
        }
    }

    /// One that comes with a velocity that it does not say touches in the step in which it arrives.
    #[test]
    fn a_grain_that_comes_unexpectedly_is_seen() {
        for set in in_lanes() {
            for arrives in [1, 7, 60, 199] {
                let (found, sum) = row_of_grains(set, arrives + 1, |step, positions| {
                    if step == arrives {
                        positions[4][0] += 0.15;
                    }
                    [[0.0; 3]; COUNT]
                });
                assert!(found >= 2 && sum > 0.0, "{set:?} {arrives}: {found} {sum}");
            }
        }
    }
}
