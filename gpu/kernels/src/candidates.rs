// SPDX-License-Identifier: MIT OR Apache-2.0
//! The pairs of one grain that may touch before a grain has moved by half of a margin.
//!
//! A full neighbour list has each pair of owned grains twice. One of the two rows keeps it ([`keeps`]): its contact is computed
//! once, for both grains, and remembered there. Such a pair that may touch is a candidate, and has a number.

use crate::contacts::{comes_first, direction, Scene};
use crate::one_lane::{vector, vector_of, OneLane};
use crate::shapes::Kind;
use ellgran::contact::history::{cached_normal, forget};
use ellgran::contact::lane_search::separating_planes;
use ellgran::simd::Lanes;
use ellgran::vector::Vector3;

/// A candidate, with all that can be said of the pair before its contact is computed: a device reads it at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C, align(16))]
pub struct Candidate {
    /// The grain with the lower identifier, which is the first of the pair, and the other one.
    pub grains: [u32; 2],
    /// Its entry in the neighbour list, counted over all rows.
    pub entry: u32,
    /// Its law among those of all pairs of types.
    pub law: u32,
}

impl Candidate {
    /// Indices of its grains.
    #[inline(always)]
    pub fn pair(&self) -> [usize; 2] {
        self.grains.map(|k| k as usize)
    }
}

/// Whether the row of the owned grain `k` keeps its pair with `other`: the row of the one with the lower identifier does, and of a grain
/// and a ghost the only one.
#[inline(always)]
pub fn keeps(identifiers: &[i32], owned: usize, k: usize, other: usize) -> bool {
    other >= owned || comes_first(identifiers, k, other)
}

/// The row of one grain in a full neighbour list, and what is remembered of its pairs.
#[derive(Debug)]
pub struct NewRow<'a> {
    /// Indices of the neighbours.
    pub neighbours: &'a [u32],
    /// Written: places in the row of the candidates. As long as `neighbours`.
    pub places: &'a mut [u32],
    /// One state per neighbour. That of a neighbour that cannot touch becomes 0.
    pub states: &'a mut [u32],
    /// [`ellgran::contact::HistoryLayout::length`] doubles per neighbour. The normal of the widest gap is written, the start of the
    /// next search.
    pub histories: &'a mut [f64],
}

/// Selects the candidates that the row of grain `k` keeps: how many there are. `owned` is the number of rows, and `margin` a length, the
/// sum of the ways of two grains for which candidates remain valid.
#[inline(always)]
pub fn candidates_of_grain<K: Kind>(
    k: usize,
    scene: &Scene<'_>,
    owned: usize,
    margin: f64,
    row: &mut NewRow<'_>,
) -> usize {
    let layout = &scene.layout;
    let mut count = 0;
    for (place, &other) in row.neighbours.iter().enumerate() {
        let other = other as usize;
        if !keeps(scene.identifiers, owned, k, other) {
            continue;
        }
        let [i, j] = scene.in_order(k, other);
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
                // However they move within it.
                (Lanes::splat(OneLane, margin), vector(Vector3::ZERO)),
                0,
            );
            may_touch = apart == 0;
            // A pair that touches has its normal.
            if let Some(at) = layout.normal.filter(|_| row.states[place] == 0) {
                history[at..at + 3].copy_from_slice(&vector_of(widest).to_array());
            }
        }
        if may_touch {
            row.places[count] = place as u32;
            count += 1;
        } else if row.states[place] != 0 {
            row.states[place] = 0;
            forget(layout, history);
        }
    }
    count
}
