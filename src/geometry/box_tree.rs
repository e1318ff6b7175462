// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which of many boxes overlap a box? A tree of boxes within boxes: built in `n log n`, asked in the logarithm of the
//! number of boxes and in proportion to the answers, for boxes of any sizes.

use super::lists::{on_heap, List, Lists, OnHeap};

/// A box along the world axes.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Extent {
    /// Its least coordinates.
    pub low: [f64; 3],
    /// Its greatest.
    pub high: [f64; 3],
}

impl Extent {
    /// Of nothing.
    pub(crate) const NONE: Extent = Extent {
        low: [f64::INFINITY; 3],
        high: [f64::NEG_INFINITY; 3],
    };

    /// That of a point and everything within `margin` of it along each axis.
    pub(crate) fn about(point: [f64; 3], margin: f64) -> Self {
        Extent {
            low: point.map(|x| x - margin),
            high: point.map(|x| x + margin),
        }
    }

    /// Larger by `margin` on every side.
    pub(crate) fn wider(self, margin: f64) -> Self {
        Extent {
            low: self.low.map(|x| x - margin),
            high: self.high.map(|x| x + margin),
        }
    }

    /// Whether two have a point in common.
    pub(crate) fn overlaps(&self, other: &Extent) -> bool {
        // Without a branch, which would often be mispredicted.
        let along = |k: usize| (self.low[k] <= other.high[k]) & (self.high[k] >= other.low[k]);
        along(0) & along(1) & along(2)
    }

    /// Whether another lies within.
    pub fn contains(&self, other: &Extent) -> bool {
        let along = |k: usize| (self.low[k] <= other.low[k]) & (self.high[k] >= other.high[k]);
        along(0) & along(1) & along(2)
    }

    fn include(&mut self, other: &Extent) {
        for k in 0..3 {
            self.low[k] = self.low[k].min(other.low[k]);
            self.high[k] = self.high[k].max(other.high[k]);
        }
    }
}

/// The tree; its memory is kept when it is built again.
pub(crate) struct BoxTree<M: Lists = OnHeap> {
    /// Each before all that it contains.
    pub(crate) nodes: M::List<Node>,
    pub(crate) order: M::List<usize>,
}

on_heap!(BoxTree: nodes order);

/// A box about several, of a tree.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Node {
    extent: Extent,
    /// The first node that is not within this one.
    next: usize,
    /// What of `order` a node without further nodes has; empty in the others.
    from: usize,
    to: usize,
}

impl Node {
    /// That has no boxes.
    pub(crate) const NONE: Node = Node {
        extent: Extent::NONE,
        next: 0,
        from: 0,
        to: 0,
    };
}

impl<M: Lists> BoxTree<M> {
    /// Makes the tree of these boxes, which are from then on known by their index.
    pub(crate) fn build(&mut self, boxes: &[Extent]) {
        self.nodes.clear();
        self.order.clear();
        self.order.add_all(0..boxes.len());
        if !boxes.is_empty() {
            divide::<M>(&mut self.nodes, &mut self.order, 0, boxes);
        }
    }

    /// The box around all; `None` without any.
    pub(crate) fn extent(&self) -> Option<&Extent> {
        self.nodes.first().map(|node| &node.extent)
    }

    /// Calls `found` with the index of each box that overlaps `extent`, until it answers false. `boxes` are those of `build`.
    pub(crate) fn visit(
        &self,
        boxes: &[Extent],
        extent: &Extent,
        found: impl FnMut(usize) -> bool,
    ) {
        visit(&self.nodes, &self.order, boxes, extent, found);
    }
}

/// The same of the parts of a tree.
pub(crate) fn visit(
    nodes: &[Node],
    order: &[usize],
    boxes: &[Extent],
    extent: &Extent,
    mut found: impl FnMut(usize) -> bool,
) {
    let mut k = 0;
    while let Some(node) = nodes.get(k) {
        if !node.extent.overlaps(extent) {
            k = node.next;
            continue;
        }
        for &index in &order[node.from..node.to] {
            if boxes[index].overlaps(extent) && !found(index) {
                return;
            }
        }
        k += 1;
    }
}

fn divide<M: Lists>(
    nodes: &mut M::List<Node>,
    order: &mut [usize],
    start: usize,
    boxes: &[Extent],
) {
    let mut extent = boxes[order[0]];
    for &index in order.iter() {
        extent.include(&boxes[index]);
    }
    let own = nodes.len();
    nodes.push(Node {
        extent,
        next: 0,
        from: start,
        to: start,
    });
    let count = order.len();
    if count <= M::LEAF {
        nodes[own].to = start + count;
    } else {
        let middle = |index: usize, k: usize| boxes[index].low[k] + boxes[index].high[k];
        let spread = |k: usize| {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for &index in order.iter() {
                low = low.min(middle(index, k));
                high = high.max(middle(index, k));
            }
            high - low
        };
        let spreads = [spread(0), spread(1), spread(2)];
        let axis = (0..3)
            .max_by(|a, b| spreads[*a].total_cmp(&spreads[*b]))
            .unwrap_or(0);
        let half = count / 2;
        order.select_nth_unstable_by(half, |a, b| {
            middle(*a, axis).total_cmp(&middle(*b, axis)).then(a.cmp(b))
        });
        let (left, right) = order.split_at_mut(half);
        divide::<M>(nodes, left, start, boxes);
        divide::<M>(nodes, right, start + half, boxes);
    }
    nodes[own].next = nodes.len();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_found_is_what_overlaps() {
        let mut state = 1u64;
        let mut number = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let mut some = |size: f64| {
            let low = [number(), number(), number()];
            let wide = [number(), number(), number()];
            Extent {
                low,
                high: core::array::from_fn(|k| low[k] + size * wide[k]),
            }
        };
        let mut tree: BoxTree = BoxTree::default();
        for count in [0, 1, 4, 5, 300] {
            let mut boxes: Vec<Extent> = (0..count).map(|_| some(0.1)).collect();
            boxes.extend((0..count / 100).map(|_| some(1.0)));
            boxes.extend_from_within(..count / 3);
            tree.build(&boxes);
            for _ in 0..50 {
                let extent = some(0.3);
                let mut found = vec![];
                tree.visit(&boxes, &extent, |k| {
                    found.push(k);
                    true
                });
                found.sort_unstable();
                let all: Vec<usize> = (0..boxes.len())
                    .filter(|&k| boxes[k].overlaps(&extent))
                    .collect();
                assert_eq!(found, all);
            }
        }
    }

    /// Along each axis alone two boxes may be apart, and one may reach beyond the other, on either side.
    #[test]
    fn boxes_overlap_and_contain_along_all_axes() {
        let whole = Extent {
            low: [0.0; 3],
            high: [1.0; 3],
        };
        for axis in 0..3 {
            for (low, high, overlaps, contains) in [
                (0.2, 0.7, true, true),
                (0.0, 1.0, true, true),
                (-0.1, 0.5, true, false),
                (0.5, 1.1, true, false),
                (-0.5, 1.5, true, false),
                (1.0, 1.2, true, false),
                (-0.2, 0.0, true, false),
                (1.1, 1.2, false, false),
                (-0.2, -0.1, false, false),
            ] {
                let mut other = Extent {
                    low: [0.3; 3],
                    high: [0.6; 3],
                };
                (other.low[axis], other.high[axis]) = (low, high);
                let what = format!("{low} to {high} along {axis}");
                assert_eq!(whole.overlaps(&other), overlaps, "{what}");
                assert_eq!(other.overlaps(&whole), overlaps, "{what}");
                assert_eq!(whole.contains(&other), contains, "{what}");
            }
        }
    }
}
