// SPDX-License-Identifier: MIT OR Apache-2.0
//! Grains, and their steps by the library's lists.

use ellgran::contact::{Laws, Step};
use ellgran::list::{
    compute_pairs, Accumulators, Entries, NeighbourRow, NeighbourRows, ParticleArrays, Rotation,
    Workspace,
};
use ellgran::motion::{finish_step, start_step, Bodies, BodyArrays, Extrapolation, Selection};
use ellgran::simd::InstructionSet;
use ellgran::tallies::Tallies;

pub const TIME_STEP: f64 = 2e-5;

pub const STEP: Step = Step {
    time_step: TIME_STEP,
    advance_history: true,
};

/// Splitmix64.
struct Stream(u64);

impl Stream {
    fn uniform(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        low + (high - low) * (((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64)
    }
    fn vector(&mut self, size: f64) -> [f64; 3] {
        std::array::from_fn(|_| self.uniform(-size, size))
    }
}

/// What a step changes.
#[derive(Clone)]
pub struct Motion {
    pub positions: Vec<[f64; 3]>,
    pub velocities: Vec<[f64; 3]>,
    pub angular_momenta: Vec<[f64; 3]>,
    pub quaternions: Vec<[f64; 4]>,
    /// What an extrapolation writes.
    pub changes: Vec<[f64; 6]>,
    pub loads_before: Vec<[f64; 6]>,
}

pub struct Scene {
    pub motion: Motion,
    pub semi_axes: Vec<[f64; 3]>,
    pub masses: Vec<f64>,
    pub types: Vec<i32>,
    pub forces: Vec<[f64; 3]>,
    pub torques: Vec<[f64; 3]>,
    /// Whether velocities are extrapolated to the step.
    pub of_step: bool,
}

/// Half of a neighbour list, each pair once, and what is remembered.
pub struct Lists {
    pub starts: Vec<usize>,
    pub neighbours: Vec<i32>,
    pub touching: Vec<i32>,
    pub histories: Vec<f64>,
    pub length: usize,
    workspace: Workspace,
}

struct Rows<'a> {
    starts: &'a [usize],
    neighbours: &'a [i32],
    touching: &'a mut [i32],
    histories: &'a mut [f64],
    length: usize,
}

impl NeighbourRows for Rows<'_> {
    fn count(&self) -> usize {
        self.starts.len() - 1
    }
    fn row(&mut self, k: usize) -> NeighbourRow<'_> {
        let (from, to) = (self.starts[k], self.starts[k + 1]);
        NeighbourRow {
            central: k,
            neighbours: &self.neighbours[from..to],
            touching: &mut self.touching[from..to],
            history: &mut self.histories[from * self.length..to * self.length],
        }
    }
    fn pair(&mut self, central: usize, entry: usize) -> (Option<&mut i32>, &mut [f64]) {
        let at = self.starts[central] + entry;
        (
            Some(&mut self.touching[at]),
            &mut self.histories[at * self.length..(at + 1) * self.length],
        )
    }
    fn entries(&self) -> Entries {
        Entries::PLAIN
    }
}

struct Shapes<'a> {
    semi_axes: &'a [[f64; 3]],
    quaternions: &'a mut [[f64; 4]],
}

impl Bodies for Shapes<'_> {
    fn shape(&self, k: usize) -> Option<([f64; 3], [f64; 4])> {
        Some((self.semi_axes[k], self.quaternions[k]))
    }
    fn turn(&mut self, k: usize, quaternion: [f64; 4]) {
        self.quaternions[k] = quaternion;
    }
}

const ALL: Selection<'static> = Selection {
    groups: &[],
    bits: 0,
};

impl Scene {
    /// Grains near the points of a cubic lattice, which overlap.
    fn new(spacing: f64, shape: impl Fn(usize, f64) -> [f64; 3]) -> Scene {
        const EDGE: usize = 5;
        let mut stream = Stream(20);
        let count = EDGE * EDGE * EDGE;
        let mut scene = Scene {
            motion: Motion {
                positions: Vec::new(),
                velocities: Vec::new(),
                angular_momenta: Vec::new(),
                quaternions: Vec::new(),
                changes: vec![[0.0; 6]; count],
                loads_before: vec![[f64::INFINITY; 6]; count],
            },
            semi_axes: Vec::new(),
            masses: vec![4.0; count],
            types: vec![1; count],
            forces: vec![[0.0; 3]; count],
            torques: vec![[0.0; 3]; count],
            of_step: false,
        };
        for k in 0..count {
            let place = [k % EDGE, k / EDGE % EDGE, k / EDGE / EDGE];
            let shift = stream.vector(0.06 * spacing);
            let m = &mut scene.motion;
            m.positions.push(std::array::from_fn(|c| {
                spacing * place[c] as f64 + shift[c]
            }));
            m.velocities.push(stream.vector(1.0));
            m.angular_momenta.push(stream.vector(1.0));
            let q: [f64; 4] = std::array::from_fn(|_| stream.uniform(-1.0, 1.0));
            let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            m.quaternions.push(q.map(|x| x / length));
            scene.semi_axes.push(shape(k, stream.uniform(0.9, 1.1)));
        }
        scene
    }

    pub fn spheres() -> Scene {
        Scene::new(1.9, |_, s| [s; 3])
    }
    /// Needles and discs.
    pub fn spheroids() -> Scene {
        Scene::new(1.7, |k, s| match k % 4 {
            0 => [1.6 * s, 0.8 * s, 0.8 * s],
            1 => [0.8 * s, 1.6 * s, 0.8 * s],
            2 => [0.8 * s, 0.8 * s, 1.6 * s],
            _ => [s, s, 0.6 * s],
        })
    }
    pub fn spheres_and_spheroids() -> Scene {
        Scene::new(1.8, |k, s| match k % 2 {
            0 => [s; 3],
            _ => [1.4 * s, 0.8 * s, 0.8 * s],
        })
    }
    pub fn ellipsoids() -> Scene {
        Scene::new(1.75, |k, s| {
            let mut a = [1.4 * s, 0.8 * s, s];
            a.rotate_left(k % 3);
            a
        })
    }
    /// Whose rims are deep in each other.
    pub fn flat_discs() -> Scene {
        Scene::new(1.5, |_, s| [s, s, 0.1 * s])
    }
    pub fn flat_blocks() -> Scene {
        Scene::new(1.5, |_, s| [s, 1.2 * s, 0.1 * s])
    }
    /// Two that touch.
    pub fn pair() -> Scene {
        let mut scene = Scene::ellipsoids();
        let m = &mut scene.motion;
        m.positions = vec![[0.0; 3], [1.2, 0.7, 0.5]];
        m.velocities.truncate(2);
        m.angular_momenta.truncate(2);
        m.quaternions.truncate(2);
        scene.semi_axes.truncate(2);
        scene.masses.truncate(2);
        scene.types.truncate(2);
        scene.forces.truncate(2);
        scene.torques.truncate(2);
        scene
    }

    pub fn count(&self) -> usize {
        self.masses.len()
    }

    /// Pairs whose bounding spheres are less than a unit apart.
    pub fn are_neighbours(&self, i: usize, j: usize) -> bool {
        let (a, b) = (&self.motion.positions[i], &self.motion.positions[j]);
        let distance = (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt();
        let largest = |k: usize| self.semi_axes[k].iter().copied().fold(0.0, f64::max);
        i != j && distance < largest(i) + largest(j) + 1.0
    }

    pub fn lists(&self, laws: &Laws) -> Lists {
        let mut starts = vec![0];
        let mut neighbours = Vec::new();
        for i in 0..self.count() {
            let row = (i + 1..self.count()).filter(|&j| self.are_neighbours(i, j));
            neighbours.extend(row.map(|j| j as i32));
            starts.push(neighbours.len());
        }
        let length = laws.layout().length;
        Lists {
            starts,
            touching: vec![0; neighbours.len()],
            histories: vec![0.0; neighbours.len() * length],
            neighbours,
            length,
            workspace: Workspace::new(InstructionSet::choose().unwrap()),
        }
    }

    fn arrays(&mut self) -> BodyArrays<'_, Shapes<'_>> {
        let m = &mut self.motion;
        BodyArrays {
            positions: &mut m.positions,
            velocities: &mut m.velocities,
            angular_momenta: &mut m.angular_momenta,
            forces: &self.forces,
            torques: &self.torques,
            masses: &self.masses,
            bodies: Shapes {
                semi_axes: &self.semi_axes,
                quaternions: &mut m.quaternions,
            },
            extrapolation: self.of_step.then_some(Extrapolation {
                changes: &mut m.changes,
                loads_before: &mut m.loads_before,
                step_ratio: 1.0,
            }),
        }
    }

    /// What velocities have more than those of the half step; nothing where they are these.
    pub fn changes(&self) -> &[[f64; 6]] {
        if self.of_step {
            &self.motion.changes
        } else {
            &[]
        }
    }

    pub fn start_step(&mut self) {
        let set = InstructionSet::choose().unwrap();
        start_step(set, &mut self.arrays(), ALL, TIME_STEP).unwrap();
    }

    pub fn finish_step(&mut self) {
        let set = InstructionSet::choose().unwrap();
        finish_step(set, &mut self.arrays(), ALL, TIME_STEP);
    }

    /// The present forces; `unchanged` says that the lists are those of the last call.
    pub fn forces_in_lanes(&mut self, laws: &Laws, lists: &mut Lists, unchanged: bool) {
        self.forces_and_tallies(laws, lists, unchanged, None);
    }

    /// The same, with what is asked for.
    pub fn forces_and_tallies(
        &mut self,
        laws: &Laws,
        lists: &mut Lists,
        unchanged: bool,
        tallies: Option<&mut Tallies<'_>>,
    ) {
        let m = &self.motion;
        let arrays = ParticleArrays {
            owned: self.count(),
            positions: &m.positions,
            velocities: &m.velocities,
            rotation: Rotation::Momentum(&m.angular_momenta, &self.masses),
            of_step: self.of_step,
            changes: self.changes(),
            contact_masses: &self.masses,
            types: &self.types,
            shape: |k: usize| Some((self.semi_axes[k], m.quaternions[k])),
            identifier: |k: usize| k as i64 + 1,
        };
        let workspace = &mut lists.workspace;
        workspace
            .prepare_for_pairs(&arrays, laws, unchanged)
            .unwrap();
        self.forces.fill([0.0; 3]);
        self.torques.fill([0.0; 3]);
        let count = self.masses.len();
        let mut accumulators = Accumulators {
            forces: &mut self.forces,
            torques: &mut self.torques,
            reaction_below: count,
            owned: count,
        };
        let mut rows = Rows {
            starts: &lists.starts,
            neighbours: &lists.neighbours,
            touching: &mut lists.touching,
            histories: &mut lists.histories,
            length: lists.length,
        };
        compute_pairs(
            laws,
            workspace,
            &mut rows,
            &STEP,
            &mut accumulators,
            tallies,
        )
        .unwrap();
    }
}
