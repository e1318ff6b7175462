// SPDX-License-Identifier: MIT OR Apache-2.0
//! Random numbers of the tests inside the library, the same in each run.

use crate::vector::Vector3;

/// A linear congruential generator (Knuth's constants).
pub(crate) struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Random(seed)
    }

    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A number whose logarithm is uniform.
    pub fn of_any_size(&mut self, low: f64, high: f64) -> f64 {
        self.uniform(low.ln(), high.ln()).exp()
    }

    /// Any quaternion that is no rotation of nothing.
    pub fn quaternion(&mut self) -> [f64; 4] {
        loop {
            let q = [0; 4].map(|_| self.uniform(-1.0, 1.0));
            if q.iter().map(|c| c * c).sum::<f64>() > 0.1 {
                return q;
            }
        }
    }

    /// A unit vector.
    pub fn direction(&mut self) -> Vector3 {
        loop {
            let v = Vector3::from_array([0; 3].map(|_| self.uniform(-1.0, 1.0)));
            if v.norm() > 0.1 {
                return v.normalised();
            }
        }
    }
}
