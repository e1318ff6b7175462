// SPDX-License-Identifier: MIT OR Apache-2.0
//! The neighbours of one grain that may touch before a grain has moved by half of a margin.

use crate::contacts::{comes_first, direction, Scene};
use crate::one_lane::{vector, vector_of, OneLane};
use crate::shapes::Kind;
use ellgran::contact::history::{cached_normal, forget};
use ellgran::contact::lane_search::separating_planes;

/// The row of one grain in a full neighbour list, and what is remembered of its pairs.
#[derive(Debug)]
pub struct NewRow<'a> {
    /// Indices of the neighbours.
    pub neighbours: &'a [u32],
    /// Written: places in the row of those that may touch. As long as `neighbours`.
    pub candidates: &'a mut [u32],
    /// One state per neighbour. That of a neighbour that cannot touch becomes 0.
    pub states: &'a mut [u32],
    /// [`ellgran::contact::HistoryLayout::length`] doubles per neighbour. The normal of the widest gap is written, the start of the
    /// next search.
    pub histories: &'a mut [f64],
}

/// Selects the candidates of grain `k`: how many there are. `margin` is a length, the sum of the ways of two grains for which
/// they remain valid.
#[inline(always)]
pub fn candidates_of_grain<K: Kind>(
    k: usize,
    scene: &Scene<'_>,
    margin: f64,
    row: &mut NewRow<'_>,
) -> usize {
    let layout = &scene.layout;
    let mut count = 0;
    for (place, &other) in row.neighbours.iter().enumerate() {
        let other = other as usize;
        let [i, j] = if comes_first(scene, k, other) {
            [k, other]
        } else {
            [other, k]
        };
        let (a, b) = (&scene.grains[i], &scene.grains[j]);
        let d = b.centre() - a.centre();
        let reach = K::radius(a) + K::radius(b) + margin;
        let history = &mut row.histories[place * layout.length..(place + 1) * layout.length];
        let mut may_touch = d.norm_squared() < reach * reach;
        if may_touch && !K::SPHERES {
            let start = cached_normal(layout, history).unwrap_or_else(|| direction(d));
            let (apart, widest) = separating_planes(
                OneLane,
                &K::body(a),
                &K::body(b),
                vector(d),
                vector(start),
                margin,
                0,
            );
            may_touch = apart == 0;
            // A pair that touches has its normal.
            if let Some(at) = layout.normal.filter(|_| row.states[place] == 0) {
                history[at..at + 3].copy_from_slice(&vector_of(widest).to_array());
            }
        }
        if may_touch {
            row.candidates[count] = place as u32;
            count += 1;
        } else if row.states[place] != 0 {
            row.states[place] = 0;
            forget(layout, history);
        }
    }
    count
}
