// SPDX-License-Identifier: MIT OR Apache-2.0
//! The full neighbour list of grains, by cells, on all cores of the host.

use crate::packing::Grains;

/// Rows of the first `owned` grains: where each begins, and the neighbours.
pub fn full_list(grains: &Grains, owned: usize, skin: f64) -> (Vec<u32>, Vec<u32>) {
    let cells = Cells::of(grains, 2.0 * grains.reach() + skin);
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let each = owned.div_ceil(threads).max(1);
    let parts: Vec<(Vec<u32>, Vec<u32>)> = std::thread::scope(|scope| {
        let cells = &cells;
        let started: Vec<_> = (0..owned)
            .step_by(each)
            .map(|from| {
                scope.spawn(move || {
                    let (mut lengths, mut neighbours) = (Vec::new(), Vec::new());
                    for k in from..(from + each).min(owned) {
                        let before = neighbours.len();
                        cells.neighbours(grains, k, skin, &mut neighbours);
                        lengths.push((neighbours.len() - before) as u32);
                    }
                    (lengths, neighbours)
                })
            })
            .collect();
        started.into_iter().map(|t| t.join().unwrap()).collect()
    });
    let mut starts = vec![0u32];
    let mut neighbours = Vec::new();
    for (lengths, row) in parts {
        for length in lengths {
            starts.push(
                starts[starts.len() - 1]
                    .checked_add(length)
                    .expect("fewer than 2^32 pairs"),
            );
        }
        neighbours.extend(row);
    }
    (starts, neighbours)
}

/// Which grains are in which cell of a grid.
struct Cells {
    low: [f64; 3],
    side: f64,
    count: [usize; 3],
    starts: Vec<u32>,
    members: Vec<u32>,
}

impl Cells {
    fn of(grains: &Grains, side: f64) -> Cells {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in &grains.positions {
            for c in 0..3 {
                low[c] = low[c].min(p[c]);
                high[c] = high[c].max(p[c]);
            }
        }
        let count = core::array::from_fn(|c| ((high[c] - low[c]) / side) as usize + 1);
        let mut cells = Cells {
            low,
            side,
            count,
            starts: vec![0; count.iter().product::<usize>() + 1],
            members: vec![0; grains.positions.len()],
        };
        let of: Vec<usize> = grains
            .positions
            .iter()
            .map(|p| cells.index(cells.place(p)))
            .collect();
        for &cell in &of {
            cells.starts[cell + 1] += 1;
        }
        for k in 1..cells.starts.len() {
            cells.starts[k] += cells.starts[k - 1];
        }
        let mut next = cells.starts.clone();
        for (k, &cell) in of.iter().enumerate() {
            cells.members[next[cell] as usize] = k as u32;
            next[cell] += 1;
        }
        cells
    }

    fn place(&self, p: &[f64; 3]) -> [usize; 3] {
        core::array::from_fn(|c| ((p[c] - self.low[c]) / self.side) as usize)
    }

    fn index(&self, place: [usize; 3]) -> usize {
        (place[2] * self.count[1] + place[1]) * self.count[0] + place[0]
    }

    /// Those that are closer than their largest semi-axes and the skin.
    fn neighbours(&self, grains: &Grains, k: usize, skin: f64, row: &mut Vec<u32>) {
        let reach = |k: usize| grains.semi_axes[k].into_iter().fold(0.0, f64::max);
        let (at, own) = (grains.positions[k], reach(k) + skin);
        let place = self.place(&at);
        let range = |c: usize| place[c].saturating_sub(1)..=(place[c] + 1).min(self.count[c] - 1);
        for z in range(2) {
            for y in range(1) {
                for x in range(0) {
                    let cell = self.index([x, y, z]);
                    let members = self.starts[cell] as usize..self.starts[cell + 1] as usize;
                    for &other in &self.members[members] {
                        let p = grains.positions[other as usize];
                        let square: f64 = (0..3).map(|c| (p[c] - at[c]).powi(2)).sum();
                        let together = own + reach(other as usize);
                        if other as usize != k && square < together * together {
                            row.push(other);
                        }
                    }
                }
            }
        }
    }
}
