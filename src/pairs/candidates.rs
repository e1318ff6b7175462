// SPDX-License-Identifier: MIT OR Apache-2.0
//! The pairs of an engine's list that may touch before the particles have moved by a given length.
//!
//! An engine's list holds every pair whose bounding spheres come near; of elongated grains few of these ever touch. A
//! pair whose bodies a plane separates by more than the margin is left out until one of the particles has moved by half
//! of it, or the list changes. That decides which pairs are looked at, never what a pair's force is.

use super::batches::Batches;
use super::particles::{reserve, Allocated, ParticleArrays};
use super::registers::Line;

/// The margin in units of the mean smallest semi-axis: where it begins, and within which it follows the motion.
const FIRST_MARGIN: f64 = 0.03;
const SMALLEST_MARGIN: f64 = 0.01;
const LARGEST_MARGIN: f64 = 0.2;
/// Steps that candidates should last: with fewer the margin doubles, with four times as many it halves.
const FEW_STEPS: u32 = 25;

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

    /// Particles that have a candidate.
    pub fn participants(&self) -> &[u32] {
        &self.participants
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

    /// Whether a particle has the same shape and has moved by no more than half of the margin since the candidates were
    /// found, and whether it takes part in a candidate.
    #[inline(always)]
    pub fn hold_for(&self, k: usize, x: &[f64; 3], a: &[f64; 3], q: &[f64; 4]) -> (bool, bool) {
        let p = &self.poses[k].0;
        let (dx, dy, dz) = (x[0] - p[0], x[1] - p[1], x[2] - p[2]);
        let moved = dx * dx + dy * dy + dz * dz;
        let (d0, d1, d2, d3) = (q[0] - p[3], q[1] - p[4], q[2] - p[5], q[3] - p[6]);
        let turned = d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3;
        // Not a number holds for nothing.
        let farthest = self.margin * self.margin * (1.0 / 16.0);
        (
            moved <= farthest && turned <= p[7] && *a == self.shapes[k],
            self.takes_part[k],
        )
    }

    /// Lets the margin follow the motion.
    pub fn count_step(&mut self, hold: bool) {
        self.steps = self.steps.saturating_add(1);
        if !hold && self.steps < FEW_STEPS {
            self.relative_margin = (self.relative_margin * 2.0).min(LARGEST_MARGIN);
        } else if !hold && self.steps > 4 * FEW_STEPS {
            self.relative_margin = (self.relative_margin * 0.5).max(SMALLEST_MARGIN);
        }
    }

    /// Begins anew for these particles: the margin, and the poses.
    pub fn begin<S: Fn(usize) -> Option<([f64; 3], [f64; 4])>, I: Fn(usize) -> i64>(
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
            let (a, q) = (arrays.shape)(k).unwrap_or(([1.0; 3], [1.0, 0.0, 0.0, 0.0]));
            self.shapes.push(a);
            let least = a[0].min(a[1]).min(a[2]);
            sum += least;
            // The support function of a body that turns by an angle changes by at most the angle times this.
            let spread = a[0].max(a[1]).max(a[2]) - least;
            // A rotation by an angle t changes a quaternion of length L by 2 L sin(t/4): t <= 2.1 |change|/L up to t = 1.
            let length = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
            self.poses.push(Line([
                x[0],
                x[1],
                x[2],
                q[0],
                q[1],
                q[2],
                q[3],
                length / (4.0 * 2.1 * spread).powi(2),
            ]));
        }
        if self.relative_margin == 0.0 {
            self.relative_margin = FIRST_MARGIN;
        }
        self.steps = 0;
        self.margin = self.relative_margin * sum / arrays.positions.len().max(1) as f64;
        let square = self.margin * self.margin;
        for pose in &mut self.poses {
            // At most a rotation by one radian; a sphere may turn as it likes.
            let limit = pose.0[7];
            pose.0[7] = if limit.is_finite() {
                let length: f64 = pose.0[3..7].iter().map(|q| q * q).sum();
                (limit * square).min(length * 0.2)
            } else {
                f64::INFINITY
            };
        }
    }

    /// Ends what [`Candidates::begin`] began, once all pairs of a list of this length are there.
    pub fn end(&mut self, listed: usize) {
        self.listed = listed as u64;
        self.batches.reserve(listed);
        self.participants.clear();
        self.takes_part.clear();
        self.takes_part.resize(self.poses.len(), false);
        for pair in self.batches.pairs() {
            self.takes_part[pair.i as usize] = true;
            self.takes_part[pair.j as usize] = true;
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
