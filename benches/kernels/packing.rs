// SPDX-License-Identifier: MIT OR Apache-2.0
//! A dense packing made without an engine, in gentle motion: a face-centred cubic packing of spheres, shaken a little,
//! stretched into ellipsoids and slightly turned. Numbers alone: `cargo xtask bench --against` plays it to other revisions.

/// Cells of four grains along each direction.
const CELLS: usize = 10;
/// Positions that the motion goes through.
const FRAMES: usize = 16;
/// Amplitude of the motion, in small semi-axes and in radians: a step of some 1e-4, like grains that vibrate in place.
const AMPLITUDE: f64 = 2e-4;
/// How far the neighbour list reaches beyond the touching of bounding spheres.
const SKIN: f64 = 1.1;
pub const TIME_STEP: f64 = 1e-6;
/// Spacing of touching neighbours, 2 where nothing overlaps.
pub const DENSE: f64 = 1.98;
/// Spacing at which bounding spheres overlap and grains do not.
pub const APART: f64 = 2.1;

/// Congruential, so that every machine sees the same packing.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Random(seed)
    }
    pub fn unit(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        ((self.0 >> 11) as f64) / (1u64 << 53) as f64
    }
    fn vector(&mut self) -> [f64; 3] {
        core::array::from_fn(|_| 2.0 * self.unit() - 1.0)
    }
}

/// Where the grains are and how they move in one step.
#[derive(Clone)]
pub struct Frame {
    pub positions: Vec<[f64; 3]>,
    pub velocities: Vec<[f64; 3]>,
    pub rotations: Vec<[f64; 3]>,
    pub quaternions: Vec<[f64; 4]>,
}

pub struct Packing {
    pub semi_axes: [f64; 3],
    pub frames: Vec<Frame>,
    /// Half a neighbour list, row after row: row `k` is `neighbours[starts[k]..starts[k + 1]]`.
    pub starts: Vec<usize>,
    pub neighbours: Vec<i32>,
}

impl Packing {
    /// Grains whose neighbours in the lattice stand `spacing` apart before stretching (touching: 2).
    pub fn new(semi_axes: [f64; 3], spacing: f64) -> Self {
        let mut random = Random::new(3);
        let cell = spacing * 2f64.sqrt();
        let mut frames: Vec<Frame> = (0..FRAMES)
            .map(|_| Frame {
                positions: Vec::new(),
                velocities: Vec::new(),
                rotations: Vec::new(),
                quaternions: Vec::new(),
            })
            .collect();
        let basis = [
            [0.0, 0.0, 0.0],
            [0.5, 0.5, 0.0],
            [0.5, 0.0, 0.5],
            [0.0, 0.5, 0.5],
        ];
        for index in 0..CELLS.pow(3) {
            let corner = [index % CELLS, index / CELLS % CELLS, index / CELLS / CELLS];
            for place in basis {
                let (shaken, turned) = (random.vector(), random.vector());
                let (along, about) = (random.vector(), random.vector());
                for (number, frame) in frames.iter_mut().enumerate() {
                    let phase = std::f64::consts::TAU * number as f64 / FRAMES as f64;
                    let moved = AMPLITUDE * phase.sin();
                    let speed =
                        AMPLITUDE * phase.cos() * std::f64::consts::TAU / FRAMES as f64 / TIME_STEP;
                    frame.positions.push(core::array::from_fn(|k| {
                        let lattice = (corner[k] as f64 + place[k]) * cell + 0.012 * shaken[k];
                        lattice * semi_axes[k] + moved * along[k]
                    }));
                    frame.velocities.push(along.map(|x| speed * x));
                    frame.rotations.push(about.map(|x| speed * x));
                    let half: [f64; 3] =
                        core::array::from_fn(|k| 0.005 * turned[k] + 0.5 * moved * about[k]);
                    frame.quaternions.push([1.0, half[0], half[1], half[2]]);
                }
            }
        }
        let longest = semi_axes.into_iter().fold(0.0, f64::max);
        let (starts, neighbours) = list(&frames[0].positions, 2.0 * longest * SKIN);
        Packing {
            semi_axes,
            frames,
            starts,
            neighbours,
        }
    }

    pub fn count(&self) -> usize {
        self.frames[0].positions.len()
    }
}

/// Types in turns, so many.
pub fn types(count: usize, type_count: usize) -> Vec<i32> {
    (0..count).map(|k| 1 + (k % type_count) as i32).collect()
}

/// Half a neighbour list of all pairs closer than `reach`.
fn list(positions: &[[f64; 3]], reach: f64) -> (Vec<usize>, Vec<i32>) {
    let mut starts = vec![0];
    let mut neighbours = Vec::new();
    for (i, a) in positions.iter().enumerate() {
        for (j, b) in positions.iter().enumerate().skip(i + 1) {
            let square: f64 = (0..3).map(|k| (b[k] - a[k]).powi(2)).sum();
            if square < reach * reach {
                neighbours.push(j as i32);
            }
        }
        starts.push(neighbours.len());
    }
    (starts, neighbours)
}
