// SPDX-License-Identifier: MIT OR Apache-2.0
//! Arrays as engines have them: rows, or columns with shapes and attitudes beside them.

use crate::support::{Array, Engine};
use ellgran_gpu::arrays::EllgranGpuVectors;

/// How an engine has its arrays.
#[derive(Clone, Copy, PartialEq)]
pub enum Layout {
    /// One vector after the other.
    Rows,
    /// One column for each component. Semi-axes and quaternion of a grain are in a record of their own, in another order.
    Columns,
}

/// Vectors of all grains.
pub struct Vectors<const N: usize> {
    array: Array<f64>,
    count: usize,
    layout: Layout,
}

impl<const N: usize> Vectors<N> {
    pub fn put(engine: &Engine, layout: Layout, vectors: &[[f64; N]]) -> Self {
        let made = Vectors {
            array: engine.put(&vec![0.0; N * vectors.len()]),
            count: vectors.len(),
            layout,
        };
        made.write(engine, 0, vectors);
        made
    }

    pub fn write(&self, engine: &Engine, first: usize, vectors: &[[f64; N]]) {
        if self.layout == Layout::Rows {
            return engine.write(&self.array, N * first, vectors.as_flattened());
        }
        for c in 0..N {
            let column: Vec<f64> = vectors.iter().map(|v| v[c]).collect();
            engine.write(&self.array, c * self.count + first, &column);
        }
    }

    pub fn read(&self, engine: &Engine) -> Vec<[f64; N]> {
        let all = engine.read(&self.array);
        let at = |k: usize, c: usize| match self.layout {
            Layout::Rows => all[k * N + c],
            Layout::Columns => all[c * self.count + k],
        };
        (0..self.count)
            .map(|k| std::array::from_fn(|c| at(k, c)))
            .collect()
    }

    pub fn vectors(&self) -> EllgranGpuVectors {
        let (per_grain, per_component) = match self.layout {
            Layout::Rows => (N, 1),
            Layout::Columns => (1, self.count),
        };
        EllgranGpuVectors {
            first: self.array.pointer(),
            per_grain,
            per_component,
        }
    }
}

/// Numbers of a record: three semi-axes, a quaternion, and one that is something else.
const RECORD: usize = 8;
const QUATERNION: usize = 3;

/// Shapes and attitudes of all grains.
pub struct Bodies {
    records: Array<f64>,
    /// Of each grain.
    places: Vec<i32>,
    places_there: Array<i32>,
    layout: Layout,
    /// How many records there are.
    pub count: usize,
}

impl Bodies {
    pub fn put(
        engine: &Engine,
        layout: Layout,
        semi_axes: &[[f64; 3]],
        quaternions: &[[f64; 4]],
    ) -> Bodies {
        let grains = semi_axes.len();
        let places: Vec<i32> = match layout {
            Layout::Rows => (0..grains as i32).collect(),
            // Backwards, and some are free.
            Layout::Columns => (0..grains as i32).rev().map(|k| k + k / 4).collect(),
        };
        let count = grains + grains / 4 + 1;
        let made = Bodies {
            records: engine.put(&vec![f64::NAN; RECORD * count]),
            places_there: engine.put(&places),
            places,
            layout,
            count,
        };
        made.write_semi_axes(engine, semi_axes);
        made.write_quaternions(engine, 0, quaternions);
        made
    }

    fn record(&self, k: usize) -> usize {
        RECORD * self.places[k] as usize
    }

    pub fn write_semi_axes(&self, engine: &Engine, semi_axes: &[[f64; 3]]) {
        for (k, axes) in semi_axes.iter().enumerate() {
            engine.write(&self.records, self.record(k), axes);
        }
    }

    /// Of the grains from `first` on.
    pub fn write_quaternions(&self, engine: &Engine, first: usize, quaternions: &[[f64; 4]]) {
        for (k, q) in quaternions.iter().enumerate() {
            engine.write(&self.records, self.record(first + k) + QUATERNION, q);
        }
    }

    pub fn read_quaternions(&self, engine: &Engine) -> Vec<[f64; 4]> {
        let all = engine.read(&self.records);
        let at = |k: usize, c: usize| all[self.record(k) + QUATERNION + c];
        (0..self.places.len())
            .map(|k| std::array::from_fn(|c| at(k, c)))
            .collect()
    }

    fn numbers_from(&self, first: usize) -> EllgranGpuVectors {
        EllgranGpuVectors {
            first: self.records.pointer::<f64>().wrapping_add(first),
            per_grain: RECORD,
            per_component: 1,
        }
    }

    pub fn semi_axes(&self) -> EllgranGpuVectors {
        self.numbers_from(0)
    }

    pub fn quaternions(&self) -> EllgranGpuVectors {
        self.numbers_from(QUATERNION)
    }

    pub fn places(&self) -> *const i32 {
        match self.layout {
            Layout::Rows => core::ptr::null(),
            Layout::Columns => self.places_there.pointer(),
        }
    }
}
