// SPDX-License-Identifier: MIT OR Apache-2.0
//! Many errors in a few numbers, and random numbers that are the same everywhere.

/// Of errors, some of which may not be numbers.
#[derive(Clone, Copy, Debug)]
pub struct Errors {
    /// Root of the mean square of those that are numbers.
    pub rms: f64,
    pub largest: f64,
    pub median: f64,
    /// Share that is no number.
    pub failed: f64,
}

impl Errors {
    pub fn of(values: impl IntoIterator<Item = f64>) -> Errors {
        let mut count = 0;
        let mut sizes: Vec<f64> = values
            .into_iter()
            .inspect(|_| count += 1)
            .filter(|value| value.is_finite())
            .map(f64::abs)
            .collect();
        sizes.sort_by(f64::total_cmp);
        let squares: f64 = sizes.iter().map(|size| size * size).sum();
        Errors {
            rms: (squares / sizes.len().max(1) as f64).sqrt(),
            largest: sizes.last().copied().unwrap_or(f64::NAN),
            median: sizes.get(sizes.len() / 2).copied().unwrap_or(f64::NAN),
            failed: 1.0 - sizes.len() as f64 / f64::from(count.max(1)),
        }
    }
}

/// Congruential.
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        ((self.0 >> 11) as f64) / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A point of the unit sphere in `N` dimensions (three: a direction, four: a turn).
    pub fn on_sphere<const N: usize>(&mut self) -> [f64; N] {
        loop {
            let v: [f64; N] = core::array::from_fn(|_| self.between(-1.0, 1.0));
            let square: f64 = v.iter().map(|x| x * x).sum();
            if square > 0.01 && square < 1.0 {
                return v.map(|x| x / square.sqrt());
            }
        }
    }
}
