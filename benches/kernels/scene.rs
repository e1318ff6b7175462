// SPDX-License-Identifier: MIT OR Apache-2.0
//! A packing as an engine has it: types, a neighbour list, histories.

use ellgran::contact::Laws;
use ellgran::list::Entries;
use ellgran::list::Rotation;
use ellgran::list::{NeighbourRow, NeighbourRows, ParticleArrays, Workspace};

use crate::packing::{types, Packing};

pub struct Scene {
    packing: Packing,
    types: Vec<i32>,
}

impl Scene {
    /// A packing with types in turns.
    pub fn new(semi_axes: [f64; 3], spacing: f64, type_count: usize) -> Self {
        let packing = Packing::new(semi_axes, spacing);
        Scene {
            types: types(packing.count(), type_count),
            packing,
        }
    }

    pub fn count(&self) -> usize {
        self.types.len()
    }

    pub fn pairs(&self) -> usize {
        self.packing.neighbours.len()
    }

    /// Moves on to the frame of a step and prepares its particles.
    pub fn prepare(&self, laws: &Laws, workspace: &mut Workspace, step: usize, unchanged: bool) {
        let frame = &self.packing.frames[step % self.packing.frames.len()];
        let arrays = ParticleArrays {
            owned: self.count(),
            positions: &frame.positions,
            velocities: &frame.velocities,
            rotation: Rotation::Velocity(&frame.rotations),
            of_step: false,
            changes: &[],
            contact_masses: &[],
            types: &self.types,
            shape: |k| Some((self.packing.semi_axes, frame.quaternions[k])),
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
            for &j in &self.scene.packing.neighbours
                [self.scene.packing.starts[i]..self.scene.packing.starts[i + 1]]
            {
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
        let (from, to) = (
            self.scene.packing.starts[k],
            self.scene.packing.starts[k + 1],
        );
        let flags = if self.length > 0 { from..to } else { 0..0 };
        NeighbourRow {
            central: k,
            neighbours: &self.scene.packing.neighbours[from..to],
            touching: &mut self.touching[flags],
            history: &mut self.history[from * self.length..to * self.length],
        }
    }

    #[inline(always)]
    fn pair(&mut self, central: usize, entry: usize) -> (Option<&mut i32>, &mut [f64]) {
        let at = self.scene.packing.starts[central] + entry;
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
