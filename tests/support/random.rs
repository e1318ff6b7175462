// SPDX-License-Identifier: MIT OR Apache-2.0
//! A seeded stream of numbers, for tests that count: the same cases every time, on every machine.

use super::scene::{Rotation, Vector};

/// Splitmix64.
pub struct Stream(u64);

impl Stream {
    pub fn new(seed: u64) -> Self {
        Stream(seed)
    }
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }
    /// Uniform in `[low, high)`.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.next() >> 11) as f64 / (1u64 << 53) as f64)
    }
    /// Log-uniform in `[low, high)`, both positive.
    pub fn log_uniform(&mut self, low: f64, high: f64) -> f64 {
        self.uniform(low.ln(), high.ln()).exp()
    }
    pub fn direction(&mut self) -> Vector {
        let z = self.uniform(-1.0, 1.0);
        let (sin, cos) = self.uniform(0.0, std::f64::consts::TAU).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vector::new(r * cos, r * sin, z)
    }
    /// Uniform over rotations (K. Shoemake).
    pub fn rotation(&mut self) -> Rotation {
        let u = self.uniform(0.0, 1.0);
        let (s1, c1) = self.uniform(0.0, std::f64::consts::TAU).sin_cos();
        let (s2, c2) = self.uniform(0.0, std::f64::consts::TAU).sin_cos();
        let (a, b) = ((1.0 - u).sqrt(), u.sqrt());
        super::scene::rotation([b * c2, a * s1, a * c1, b * s2])
    }
    /// Semi-axes with the largest 1 and the others log-uniform down to `1/aspect`; in any order.
    pub fn semi_axes(&mut self, aspect: f64) -> [f64; 3] {
        let mut a = [
            1.0,
            self.log_uniform(1.0 / aspect, 1.0),
            self.log_uniform(1.0 / aspect, 1.0),
        ];
        a.rotate_left((self.next() % 3) as usize);
        a
    }
}
