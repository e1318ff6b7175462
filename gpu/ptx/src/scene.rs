// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a thread reads of the scene that a kernel is called with, and what it adds to what all kernels share: notes and loads.

use crate::memory::{Here, Own, OwnVectors};
use core::sync::atomic::{AtomicU32, Ordering};
use ellgran::contact::history::Remembers;
use ellgran::contact::{HistoryLayout, Step};
use ellgran::vector::Vector3;
use ellgran::walls::WallHistoryLayout;
use ellgran_kernels::arguments::SceneArguments;
use ellgran_kernels::contacts::Scene;

/// Leaves a note. Many threads may leave the same one.
#[inline(always)]
pub(crate) fn note(notes: &[AtomicU32], which: usize) {
    notes[which].store(1, Ordering::Relaxed);
}

#[inline(always)]
pub(crate) fn is_noted(notes: &[AtomicU32], which: usize) -> bool {
    notes[which].load(Ordering::Relaxed) != 0
}

/// What all threads of a contact kernel read; `friction` says whether histories have a tangential part.
#[inline(always)]
pub(crate) fn scene_of(arrays: &SceneArguments<Here>, friction: bool) -> Scene<'_> {
    Scene {
        grains: arrays.grains.all(),
        changes: arrays.changes.all(),
        types: arrays.types.all(),
        inverse_masses: arrays.inverse_masses.all(),
        identifiers: arrays.identifiers.all(),
        laws: arrays.laws.all(),
        type_count: arrays.type_count,
        layout: HistoryLayout::new(Remembers {
            normal: arrays.cached_normal != 0,
            tangential: friction,
            energy: arrays.rescaled != 0,
            ..Remembers::default()
        }),
        step: Step {
            time_step: arrays.time_step,
            advance_history: arrays.advance_history != 0,
        },
    }
}

/// How what a scene remembers of a grain and a wall is laid out.
#[inline(always)]
pub(crate) fn wall_layout(scene: &Scene<'_>, records: u32) -> WallHistoryLayout {
    // Without a tangential part nothing is remembered.
    let history = scene.layout.memory.map_or(0, |_| scene.layout.length);
    WallHistoryLayout::new(history, records as usize)
}

/// Adds to the vector of a grain.
#[inline(always)]
pub(crate) fn add(vectors: &mut OwnVectors<3>, own: &Own, added: Vector3) {
    let before = Vector3::from_array(vectors.read(own));
    vectors.write(own, (before + added).to_array());
}
