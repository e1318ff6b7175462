// SPDX-License-Identifier: MIT OR Apache-2.0
//! The pairs of an engine's list that may touch before the particles have moved by a given length.
//!
//! An engine's list holds every pair whose bounding spheres come near; of elongated grains few of these ever touch. A
//! pair whose bodies a plane separates by more than the margin is left out until one of the particles has moved by half
//! of it, or the list changes. That decides which pairs are looked at, never what a pair's force is.

use super::arrays::{ParticleArrays, ParticleShapes};
use super::batches::Batches;
use super::memory::{reserve, Allocated};
use super::shapes::same;
use crate::geometry::small_motion::{
    allowed_turn, allowed_turn_per_margin, allowed_way, way_and_turn,
};
use crate::real::Real;
use crate::simd::{components, lines, Lanes, Line, Registers, MOST_LANES};

/// The margin in units of the mean smallest semi-axis: where it begins, and within which it follows the motion.
const FIRST_MARGIN: f64 = 0.01;
const SMALLEST_MARGIN: f64 = 0.001;
const LARGEST_MARGIN: f64 = 0.2;
/// By how much it changes at most at once.
const LARGEST_CHANGE: f64 = 4.0;

/// What it costs to find the candidates, in units of a candidate's computation: per pair of the list, per pair whose
/// bounding spheres come near, and per particle. Only their sum was measured, once (12 units a grain in a dense packing of
/// aspect ratio 2); how it divides is a guess. The best margin is flat: it goes with the root of the cost.
const COST_OF_LISTED: f64 = 0.25;
const COST_OF_NEAR: f64 = 0.75;
const COST_OF_PARTICLE: f64 = 2.0;

/// Candidates, and the poses for which they were found.
#[derive(Debug, Default)]
pub(super) struct Candidates {
    pub batches: Batches,
    /// Pairs of the list.
    pub listed: u64,
    /// Particles that have a candidate, in rising order.
    participants: Vec<u32>,
    takes_part: Vec<bool>,
    /// Position, quaternion as the engine has it, square of the change of the quaternion that is allowed.
    poses: Vec<Line>,
    /// Semi-axes.
    shapes: Vec<[f64; 3]>,
    /// Length, the same for all pairs.
    pub margin: f64,
    /// In units of the mean smallest semi-axis; 0 before the first time.
    relative_margin: f64,
    /// Steps since the candidates were found.
    steps: u32,
    /// When to look again whether the margin is too wide.
    next_look: u32,
    /// Lanes that were computed for nothing in the first of them.
    idle: f64,
    /// What finding them cost, in units of a lane's computation.
    cost: f64,
    valid: bool,
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

    /// Of each particle whether it has a candidate; `None` where there are no candidates.
    pub fn takes_part(&self) -> Option<&[bool]> {
        self.valid.then_some(&self.takes_part[..])
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.batches.bytes()
            + self.participants.capacity() * core::mem::size_of::<u32>()
            + self.takes_part.capacity()
            + self.poses.capacity() * core::mem::size_of::<Line>()
            + self.shapes.capacity() * core::mem::size_of::<[f64; 3]>()
    }

    /// Whether there are candidates for as many particles.
    pub fn are_for(&self, count: usize) -> bool {
        self.valid && self.poses.len() == count
    }

    /// Of the particles from `first` on: those that have the same shape and have moved by no more than half of the margin since the
    /// candidates were found, and those that take part in a candidate. `shapes` are semi-axes, quaternion and anything.
    #[inline(always)]
    pub fn hold_for<S: Registers>(
        &self,
        registers: S,
        first: usize,
        count: usize,
        x: [Lanes<S>; 3],
        shapes: &[Lanes<S>; 8],
    ) -> (u32, u32) {
        let poses = &self.poses[first..];
        let mut last = [Line::ZERO; MOST_LANES];
        let p = if let Some(poses) = poses.first_chunk::<MOST_LANES>() {
            registers.columns(&lines!(poses))
        } else {
            last[..count].copy_from_slice(&poses[..count]);
            registers.columns(&lines!(&last))
        };
        let p = Lanes::all(registers, p);
        let a = components(registers, &self.shapes[first..], count);
        let q = [shapes[3], shapes[4], shapes[5], shapes[6]];
        let (moved, turned) = way_and_turn([p[0], p[1], p[2]], x, [p[3], p[4], p[5], p[6]], q);
        // Not a number holds for nothing.
        let farthest = moved.constant(self.farthest());
        let near = registers.and(moved.less(farthest), turned.less(p[7]));
        let same = registers.and(
            same(registers, shapes[0], a[0]),
            registers.and(
                same(registers, shapes[1], a[1]),
                same(registers, shapes[2], a[2]),
            ),
        );
        let mut take_part = 0;
        for (lane, takes_part) in self.takes_part[first..first + count].iter().enumerate() {
            take_part |= u32::from(*takes_part) << lane;
        }
        (registers.bits(registers.and(near, same)), take_part)
    }

    /// One step more with these candidates.
    pub fn count_step(&mut self) {
        self.steps = self.steps.saturating_add(1);
        if self.steps == 1 {
            self.idle = self.batches.idle() as f64;
            self.next_look = if self.relative_margin > SMALLEST_MARGIN {
                (2.0 * self.cost / self.idle.max(1.0)) as u32 + 1
            } else {
                u32::MAX
            };
        }
    }

    /// Lets the margin follow the motion, which has used up this share of it since the candidates were found.
    ///
    /// A wider margin lets more pairs in that do not touch, in proportion, and lasts longer, in proportion: together they
    /// cost least where the candidates cost as much to find as those pairs do while they last.
    pub fn adapt(&mut self, share: f64) {
        let lanes = self.idle.max(1.0) * f64::from(self.steps.max(1));
        let best = (self.cost * share / lanes).sqrt();
        self.relative_margin = (self.relative_margin
            * best.clamp(1.0 / LARGEST_CHANGE, LARGEST_CHANGE))
        .clamp(SMALLEST_MARGIN, LARGEST_MARGIN);
    }

    /// Whether the margin has shown to be far wider than it should be, so that the candidates are better found anew; it is
    /// then narrower.
    pub fn should_be_fewer<S: ParticleShapes, I: Fn(usize) -> i64>(
        &mut self,
        arrays: &ParticleArrays<'_, S, I>,
    ) -> bool {
        if self.steps < self.next_look {
            return false;
        }
        let before = self.relative_margin;
        let share = self.share_used(arrays);
        self.adapt(share);
        if self.relative_margin < 0.5 * before {
            return true;
        }
        self.relative_margin = before;
        self.next_look = self.steps.saturating_mul(2);
        false
    }

    /// How much of the margin the farthest motion has used up.
    fn share_used<S: ParticleShapes, I: Fn(usize) -> i64>(
        &self,
        arrays: &ParticleArrays<'_, S, I>,
    ) -> f64 {
        let farthest = self.farthest();
        let mut largest: f64 = 0.0;
        for (k, (x, pose)) in arrays.positions.iter().zip(&self.poses).enumerate() {
            let Some((_, q)) = arrays.shape.of(k) else {
                continue;
            };
            let (moved, turned) = motion(&pose.0, x, &q);
            largest = largest.max(moved / farthest).max(turned / pose.0[7]);
        }
        largest.min(1.0).sqrt()
    }

    /// Square of the way that a particle may move.
    #[inline(always)]
    fn farthest(&self) -> f64 {
        allowed_way(self.margin)
    }

    /// Begins anew for these particles: the margin, and the poses.
    pub fn begin<S: ParticleShapes, I: Fn(usize) -> i64>(
        &mut self,
        arrays: &ParticleArrays<'_, S, I>,
        allocated: Allocated,
    ) {
        self.valid = false;
        self.batches.allocated = allocated;
        self.poses.clear();
        reserve(&mut self.poses, arrays.positions.len(), allocated);
        self.shapes.clear();
        self.shapes.reserve(arrays.positions.len());
        let mut sum = 0.0;
        for (k, x) in arrays.positions.iter().enumerate() {
            // They were checked before.
            let (a, q) = arrays
                .shape
                .of(k)
                .unwrap_or(([1.0; 3], [1.0, 0.0, 0.0, 0.0]));
            self.shapes.push(a);
            let least = a[0].min(a[1]).min(a[2]);
            sum += least;
            self.poses.push(Line([
                x[0],
                x[1],
                x[2],
                q[0],
                q[1],
                q[2],
                q[3],
                allowed_turn_per_margin(a, q),
            ]));
        }
        if self.relative_margin == 0.0 {
            self.relative_margin = FIRST_MARGIN;
        }
        self.steps = 0;
        self.margin = self.relative_margin * sum / arrays.positions.len().max(1) as f64;
        let square = self.margin * self.margin;
        for pose in &mut self.poses {
            pose.0[7] = allowed_turn(pose.0[7], square, &pose.0[3..7]);
        }
    }

    /// Ends what [`Candidates::begin`] began, once all pairs of a list of this length are there, of which so many were near
    /// enough to be looked at.
    pub fn end(&mut self, listed: usize, near: usize) {
        self.listed = listed as u64;
        self.cost = COST_OF_LISTED * listed as f64
            + COST_OF_NEAR * near as f64
            + COST_OF_PARTICLE * self.poses.len() as f64;
        self.batches.reserve(listed);
        self.batches.end();
        self.participants.clear();
        self.takes_part.clear();
        self.takes_part.resize(self.poses.len(), false);
        for k in self.batches.particles() {
            self.takes_part[k as usize] = true;
        }
        self.participants.reserve(self.poses.len());
        self.participants.extend(
            self.takes_part
                .iter()
                .enumerate()
                .filter(|(_, takes_part)| **takes_part)
                .map(|(k, _)| k as u32),
        );
        self.valid = true;
    }
}

/// Squares of the way from a pose and of the change of its quaternion.
#[inline(always)]
fn motion(p: &[f64; 8], x: &[f64; 3], q: &[f64; 4]) -> (f64, f64) {
    let &[px, py, pz, w, i, j, k, _] = p;
    way_and_turn([px, py, pz], *x, [w, i, j, k], *q)
}
