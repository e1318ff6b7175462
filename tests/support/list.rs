// SPDX-License-Identifier: MIT OR Apache-2.0
//! Many separate pairs as one neighbour list, on an instruction set of choice.

use super::brute_force::support;
use super::scene::{position, Vector};
use ellgran::contact::{Body, Laws, Step};
use ellgran::list::Rotation;
use ellgran::list::{compute_pairs, NeighbourRow, NeighbourRows, ParticleArrays, Workspace};
use ellgran::list::{Accumulators, Entries};
use ellgran::simd::InstructionSet;

/// The instruction sets of this machine.
pub fn instruction_sets() -> impl Iterator<Item = InstructionSet> {
    InstructionSet::ALL
        .iter()
        .copied()
        .filter(|set| set.is_available())
}

/// `h_i(n) + h_j(n) - n.d`.
pub fn overlap(i: &Body, j: &Body, n: &Vector) -> f64 {
    support(i, n) + support(j, n) - n.dot(&(position(j) - position(i)))
}

/// What a list remembers of pairs that stay; their bodies may move.
pub struct PairList<'a> {
    laws: &'a Laws,
    workspace: Workspace,
    rows: Rows,
    steps: usize,
    /// On the bodies of the last step, `i` and `j` of each pair in turn.
    pub forces: Vec<[f64; 3]>,
    /// The torques on them.
    pub torques: Vec<[f64; 3]>,
}

struct Rows {
    /// Row `k` has particle `2 k` and its neighbour `2 k + 1`.
    neighbours: Vec<i32>,
    touching: Vec<i32>,
    history: Vec<f64>,
    length: usize,
}

impl NeighbourRows for Rows {
    fn count(&self) -> usize {
        self.neighbours.len()
    }
    fn row(&mut self, k: usize) -> NeighbourRow<'_> {
        NeighbourRow {
            central: 2 * k,
            neighbours: &self.neighbours[k..=k],
            touching: &mut self.touching[k..=k],
            history: &mut self.history[k * self.length..(k + 1) * self.length],
        }
    }
    fn pair(&mut self, central: usize, _: usize) -> (Option<&mut i32>, &mut [f64]) {
        let k = central / 2;
        (
            self.touching.get_mut(k),
            &mut self.history[k * self.length..(k + 1) * self.length],
        )
    }
    fn entries(&self) -> Entries {
        Entries::PLAIN
    }
}

impl<'a> PairList<'a> {
    /// Of so many pairs of which nothing is remembered.
    pub fn new(laws: &'a Laws, set: InstructionSet, pairs: usize) -> Self {
        let length = laws.layout().length;
        PairList {
            laws,
            workspace: Workspace::new(set),
            rows: Rows {
                neighbours: (0..pairs as i32).map(|k| 2 * k + 1).collect(),
                touching: vec![0; pairs],
                history: vec![0.0; pairs * length],
                length,
            },
            steps: 0,
            forces: Vec::new(),
            torques: Vec::new(),
        }
    }

    /// Whether a pair touches, and what is remembered of it.
    pub fn remembered(&self, pair: usize) -> (bool, &[f64]) {
        let length = self.rows.length;
        let history = &self.rows.history[pair * length..(pair + 1) * length];
        (self.rows.touching[pair] != 0, history)
    }

    /// One step of a microsecond: the penetration of each pair that touches, by the normal that the list found.
    pub fn step(&mut self, pairs: &[(Body, Body)]) -> Vec<Option<f64>> {
        let step = Step {
            time_step: 1e-6,
            advance_history: true,
        };
        self.advance(pairs, &step).unwrap();
        let at = self.laws.layout().normal.expect("normals are remembered");
        pairs
            .iter()
            .enumerate()
            .map(|(k, (i, j))| {
                let (touching, history) = self.remembered(k);
                let n = &history[at..at + 3];
                touching.then(|| overlap(i, j, &Vector::new(n[0], n[1], n[2]).normalize()))
            })
            .collect()
    }

    /// One step; what is wrong with a body, if anything, in the library's words.
    pub fn advance(&mut self, pairs: &[(Body, Body)], step: &Step) -> Result<(), String> {
        assert_eq!(pairs.len(), self.rows.neighbours.len());
        let bodies: Vec<&Body> = pairs.iter().flat_map(|(i, j)| [i, j]).collect();
        let of = |what: fn(&Body) -> [f64; 3]| bodies.iter().map(|b| what(b)).collect::<Vec<_>>();
        let (positions, velocities) = (of(|b| b.position), of(|b| b.velocity));
        let spins = of(|b| b.angular_velocity);
        let masses: Vec<f64> = bodies.iter().map(|b| b.mass).collect();
        let types: Vec<i32> = bodies.iter().map(|b| b.particle_type).collect();
        let arrays = ParticleArrays {
            owned: bodies.len(),
            positions: &positions,
            velocities: &velocities,
            rotation: Rotation::Velocity(&spins),
            of_step: false,
            changes: &[],
            contact_masses: &masses,
            types: &types,
            shape: |k: usize| Some((bodies[k].semi_axes, bodies[k].quaternion)),
            identifier: |k: usize| bodies[k].identifier,
        };
        self.workspace
            .prepare_for_pairs(&arrays, self.laws, self.steps > 0)
            .map_err(|e| e.to_string())?;
        self.steps += 1;
        self.forces = vec![[0.0; 3]; bodies.len()];
        self.torques = self.forces.clone();
        let mut accumulators = Accumulators {
            forces: &mut self.forces,
            torques: &mut self.torques,
            reaction_below: bodies.len(),
            owned: bodies.len(),
        };
        let (rows, workspace) = (&mut self.rows, &mut self.workspace);
        compute_pairs(self.laws, workspace, rows, step, &mut accumulators, None)
            .map_err(|e| format!("{e:?}"))?;
        Ok(())
    }
}
