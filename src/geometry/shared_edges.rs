// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which triangles have corners and edges in common? Those whose corners are equal; corners that are only near each other are two.

use super::triangle::Triangle;
use crate::vector::Vector3;

/// A surface of triangles with each of its corners once.
pub(crate) struct SharedEdges {
    /// The places of the corners.
    pub corners: Vec<Vector3>,
    /// The numbers of the corners of each triangle.
    pub triangles: Vec<[usize; 3]>,
    /// The sides of all triangles, those of one edge behind each other.
    sides: Vec<Side>,
}

/// A side of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Side {
    /// The numbers of its ends, the smaller one first.
    pub ends: [usize; 2],
    pub triangle: usize,
    /// The number of the corner that is no end.
    pub third: usize,
}

impl SharedEdges {
    /// Of triangles with finite corners. The time goes with `n log n`.
    pub fn new(triangles: &[Triangle]) -> Self {
        let place = |k: usize| triangles[k / 3][k % 3].to_array();
        let mut order: Vec<usize> = (0..3 * triangles.len()).collect();
        order.sort_unstable_by(|&a, &b| {
            // Adding 0 makes one zero of both.
            let keys = place(a).into_iter().zip(place(b));
            keys.map(|(x, y)| (x + 0.0).total_cmp(&(y + 0.0)))
                .find(|o| o.is_ne())
                .unwrap_or(core::cmp::Ordering::Equal)
        });
        let mut corners: Vec<Vector3> = Vec::new();
        let mut own = vec![[0; 3]; triangles.len()];
        for k in order {
            let corner = triangles[k / 3][k % 3];
            if corners.last() != Some(&corner) {
                corners.push(corner);
            }
            own[k / 3][k % 3] = corners.len() - 1;
        }
        let mut sides: Vec<Side> = (0..3 * triangles.len())
            .map(|k| {
                let (triangle, m) = (k / 3, k % 3);
                let [a, b, third] = [0, 1, 2].map(|n| own[triangle][(m + n) % 3]);
                Side {
                    ends: [a.min(b), a.max(b)],
                    triangle,
                    third,
                }
            })
            .collect();
        sides.sort_unstable();
        SharedEdges {
            corners,
            triangles: own,
            sides,
        }
    }

    /// The sides at each edge.
    pub fn edges(&self) -> impl Iterator<Item = &[Side]> {
        self.sides.chunk_by(|a, b| a.ends == b.ends)
    }
}
