// SPDX-License-Identifier: MIT OR Apache-2.0
//! A hierarchy of bounding boxes: which of many triangles may meet a box.

use crate::geometry::triangles::Triangle;
use crate::vector::Vector3;

/// Boxes along the axes, each around two others or around a few triangles.
#[derive(Clone, Debug)]
pub(super) struct BoundingBoxes {
    nodes: Vec<Node>,
    /// Indices of triangles, those of a leaf side by side.
    order: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    low: [f64; 3],
    high: [f64; 3],
    /// Of a leaf, where its triangles begin in `order`; else the second child. The first child is the next node.
    next: u32,
    /// Triangles of a leaf; 0 for a box around two others.
    count: u32,
}

const LEAF: usize = 4;
/// Halving 2^32 triangles ends before.
const DEPTH: usize = 64;

impl BoundingBoxes {
    pub(super) fn new(triangles: &[Triangle]) -> Self {
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        let mut boxes = BoundingBoxes {
            nodes: Vec::with_capacity(triangles.len()),
            order: Vec::new(),
        };
        let end = order.len();
        boxes.build(triangles, &mut order, 0, end);
        boxes.order = order;
        boxes
    }

    fn build(&mut self, triangles: &[Triangle], order: &mut [u32], from: usize, to: usize) {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for t in &order[from..to] {
            for p in triangles[*t as usize].map(Vector3::to_array) {
                for k in 0..3 {
                    low[k] = low[k].min(p[k]);
                    high[k] = high[k].max(p[k]);
                }
            }
        }
        let place = self.nodes.len();
        let count = to - from;
        self.nodes.push(Node {
            low,
            high,
            next: from as u32,
            count: count as u32,
        });
        if count <= LEAF {
            return;
        }
        let size = |k: usize| high[k] - low[k];
        let axis = (1..3).fold(0, |best, k| if size(k) > size(best) { k } else { best });
        let middle = |t: u32| -> f64 {
            let corners = triangles[t as usize].map(|p| p.to_array()[axis]);
            corners.iter().sum()
        };
        let half = count / 2;
        order[from..to].select_nth_unstable_by(half, |a, b| middle(*a).total_cmp(&middle(*b)));
        self.build(triangles, order, from, from + half);
        let second = self.nodes.len() as u32;
        self.build(triangles, order, from + half, to);
        self.nodes[place].next = second;
        self.nodes[place].count = 0;
    }

    /// Indices of the triangles whose leaves meet a box, in the order of the triangles.
    pub(super) fn meeting(&self, low: [f64; 3], high: [f64; 3], found: &mut Vec<u32>) {
        found.clear();
        if self.nodes.is_empty() {
            return;
        }
        let mut stack = [0u32; DEPTH];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let place = stack[depth];
            let node = &self.nodes[place as usize];
            if !(0..3).all(|k| node.low[k] <= high[k] && node.high[k] >= low[k]) {
                continue;
            }
            if node.count > 0 {
                let from = node.next as usize;
                found.extend_from_slice(&self.order[from..from + node.count as usize]);
            } else {
                stack[depth] = node.next;
                stack[depth + 1] = place + 1;
                depth += 2;
            }
        }
        found.sort_unstable();
    }

    /// The box around all, or an empty one.
    pub(super) fn whole(&self) -> ([f64; 3], [f64; 3]) {
        self.nodes
            .first()
            .map_or(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |n| {
                (n.low, n.high)
            })
    }
}
