// SPDX-License-Identifier: MIT OR Apache-2.0
//! A dense packing made without an engine, in gentle motion: a face-centred cubic packing of spheres, shaken a little,
//! stretched into ellipsoids and slightly turned.

use ellgran::contact::Laws;
use ellgran::list::Entries;
use ellgran::list::Rotation;
use ellgran::list::{NeighbourRow, NeighbourRows, ParticleArrays, Workspace};

/// Cells of four grains along each direction.
const CELLS: usize = 10;
/// Positions that the motion goes through.
const FRAMES: usize = 16;
/// Amplitude of the motion, in small semi-axes and in radians: a step of some 1e-4, like grains that vibrate in place.
const AMPLITUDE: f64 = 2e-4;
/// How far the neighbour list reaches beyond the touching of bounding spheres.
const SKIN: f64 = 1.1;
pub const TIME_STEP: f64 = 1e-6;

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

struct Frame {
    positions: Vec<[f64; 3]>,
    velocities: Vec<[f64; 3]>,
    rotations: Vec<[f64; 3]>,
    quaternions: Vec<[f64; 4]>,
}

pub struct Scene {
    semi_axes: [f64; 3],
    types: Vec<i32>,
    frames: Vec<Frame>,
    /// The list, row after row: row `k` is `neighbours[starts[k]..starts[k + 1]]`.
    starts: Vec<usize>,
    neighbours: Vec<i32>,
}

impl Scene {
    /// Grains whose neighbours in the lattice stand `spacing` apart before stretching (touching: 2).
    pub fn new(semi_axes: [f64; 3], spacing: f64, type_count: usize) -> Self {
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
        let count = frames[0].positions.len();
        let longest = semi_axes.into_iter().fold(0.0, f64::max);
        let (starts, neighbours) = list(&frames[0].positions, 2.0 * longest * SKIN);
        Scene {
            semi_axes,
            types: (0..count).map(|k| 1 + (k % type_count) as i32).collect(),
            frames,
            starts,
            neighbours,
        }
    }

    pub fn count(&self) -> usize {
        self.types.len()
    }

    pub fn pairs(&self) -> usize {
        self.neighbours.len()
    }

    /// Moves on to the frame of a step and prepares its particles.
    pub fn prepare(&self, laws: &Laws, workspace: &mut Workspace, step: usize, unchanged: bool) {
        let frame = &self.frames[step % FRAMES];
        let arrays = ParticleArrays {
            owned: self.count(),
            positions: &frame.positions,
            velocities: &frame.velocities,
            rotation: Rotation::Velocity(&frame.rotations),
            of_step: false,
            changes: &[],
            contact_masses: &[],
            types: &self.types,
            shape: |k| Some((self.semi_axes, frame.quaternions[k])),
            identifier: |k| k as i64,
        };
        workspace
            .prepare_for_pairs(&arrays, laws, unchanged)
            .expect("the scene is made of ellipsoids");
    }

    /// The list with a history of nothing.
    pub fn rows(&self, laws: &Laws) -> Rows<'_> {
        let length = laws.layout().length;
        Rows {
            scene: self,
            length,
            touching: vec![0; if length > 0 { self.pairs() } else { 0 }],
            history: vec![0.0; length * self.pairs()],
        }
    }
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

/// A scene's neighbour list and the histories of one law.
pub struct Rows<'a> {
    scene: &'a Scene,
    length: usize,
    pub touching: Vec<i32>,
    pub history: Vec<f64>,
}

impl Rows<'_> {
    /// Nothing is remembered any more.
    pub fn forget(&mut self) {
        self.touching.fill(0);
        self.history.fill(0.0);
    }

    /// First and second particle of every pair.
    pub fn all_pairs(&self) -> Vec<(usize, usize)> {
        let mut pairs = Vec::with_capacity(self.scene.pairs());
        for i in 0..self.scene.count() {
            for &j in &self.scene.neighbours[self.scene.starts[i]..self.scene.starts[i + 1]] {
                pairs.push((i, j as usize));
            }
        }
        pairs
    }
}

impl NeighbourRows for Rows<'_> {
    fn count(&self) -> usize {
        self.scene.count()
    }

    #[inline(always)]
    fn row(&mut self, k: usize) -> NeighbourRow<'_> {
        let (from, to) = (self.scene.starts[k], self.scene.starts[k + 1]);
        let flags = if self.length > 0 { from..to } else { 0..0 };
        NeighbourRow {
            central: k,
            neighbours: &self.scene.neighbours[from..to],
            touching: &mut self.touching[flags],
            history: &mut self.history[from * self.length..to * self.length],
        }
    }

    #[inline(always)]
    fn pair(&mut self, central: usize, entry: usize) -> (Option<&mut i32>, &mut [f64]) {
        let at = self.scene.starts[central] + entry;
        (
            self.touching.get_mut(at),
            &mut self.history[at * self.length..(at + 1) * self.length],
        )
    }

    #[inline(always)]
    fn entries(&self) -> Entries {
        Entries::PLAIN
    }
}
