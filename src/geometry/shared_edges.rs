// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which triangles have corners and edges in common? Those whose corners are equal; corners that are only near each other are two. And which corners lie
//! on a side of a triangle that meets its neighbours otherwise than edge to edge?

use super::box_tree::{BoxTree, Extent};
use super::triangle::{across, Triangle};
use super::triangle_places::SAME_PLANE;
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

/// A corner of other triangles on a side of a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hanging {
    pub triangle: usize,
    /// From the triangle's corner of this number on.
    pub side: usize,
    /// How far along it.
    place: f64,
    /// The number of the corner.
    pub corner: usize,
}

/// How near to a side of so much length a corner is on it, in the plane of the triangle and out of it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Margin {
    /// Everywhere the same.
    Distance(f64),
    /// Sines of angles, seen from the farther and from the nearer end of the side.
    Sines { in_plane: f64, across: f64 },
}

/// Where a corner is on a side. In the plane a gap or an overlap that narrow is a flaw of the mesh; out of it the parts of a triangle would not be in one
/// plane any more.
pub(crate) const ON_SIDE: Margin = Margin::Sines {
    in_plane: 1e-6,
    across: SAME_PLANE,
};

impl Margin {
    fn in_plane(&self, length: f64) -> f64 {
        match *self {
            Margin::Distance(most) => most,
            Margin::Sines { in_plane, .. } => in_plane * length,
        }
    }

    fn across(&self, from_nearer_end: f64) -> f64 {
        match *self {
            Margin::Distance(most) => most,
            Margin::Sines { across, .. } => across * from_nearer_end,
        }
    }
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

    /// The corners on sides that no other triangle has, in the order of the triangles, of their sides and along these; each once of a triangle. Triangles
    /// that are no wider than the margin count as none: such are in files to close what is open there. The time goes with `n log n`.
    pub fn hanging(&self, margin: Margin) -> Vec<Hanging> {
        let place = |c: usize| self.corners[c];
        let is_wide = |t: usize| {
            let (across, longest) = across(&self.triangles[t].map(place));
            across.norm_squared().sqrt() > margin.in_plane(longest.sqrt()) * longest.sqrt()
        };
        let is_wide: Vec<bool> = (0..self.triangles.len()).map(is_wide).collect();
        let mut open: Vec<Side> = Vec::new();
        for sides in self.edges() {
            let mut wide = sides.iter().filter(|side| is_wide[side.triangle]);
            if let (Some(side), None) = (wide.next(), wide.next()) {
                open.push(*side);
            }
        }
        let boxes: Vec<Extent> = open
            .iter()
            .map(|s| around(s.ends.map(place), margin))
            .collect();
        let mut tree = BoxTree::<super::lists::OnHeap>::default();
        tree.build(&boxes);
        let mut found = Vec::new();
        for (corner, point) in self.corners.iter().enumerate() {
            if open.is_empty() {
                break;
            }
            tree.visit(&boxes, &Extent::about(point.to_array(), 0.0), |k| {
                let side = &open[k];
                if !side.ends.contains(&corner) && corner != side.third {
                    found.extend(self.on_side(side, corner, margin));
                }
                true
            });
        }
        // What is near to two sides of a triangle is on one of them.
        found.sort_unstable_by_key(|h| [h.triangle, h.corner, h.side]);
        found.dedup_by_key(|h| [h.triangle, h.corner]);
        found.sort_unstable_by(|a, b| {
            let order = [a.triangle, a.side].cmp(&[b.triangle, b.side]);
            order.then(a.place.total_cmp(&b.place))
        });
        found
    }

    fn on_side(&self, side: &Side, corner: usize, margin: Margin) -> Option<Hanging> {
        let own = self.triangles[side.triangle];
        let number = (0..3).find(|m| !side.ends.contains(&own[(m + 2) % 3]))?;
        let [a, b, third] = [0, 1, 2].map(|m| self.corners[own[(number + m) % 3]]);
        let length = (b - a).norm();
        let along = (b - a) * (1.0 / length);
        let way = self.corners[corner] - a;
        let place = along.dot(way);
        let most = margin.in_plane(length);
        if !(place > most && place < length - most) {
            return None;
        }
        let inwards = (third - a) - along * along.dot(third - a);
        let inwards = inwards.direction()?;
        let normal = along.cross(inwards);
        let is_near = inwards.dot(way).abs() <= most
            && normal.dot(way).abs() <= margin.across(place.min(length - place));
        is_near.then_some(Hanging {
            triangle: side.triangle,
            side: number,
            place,
            corner,
        })
    }

    /// Takes the parts of sides between corners that are on them in the place of the whole sides.
    pub fn cut(&mut self, hanging: &[Hanging]) {
        if hanging.is_empty() {
            return;
        }
        let mut parts = Vec::new();
        let mut whole = Vec::new();
        for own in hanging.chunk_by(|a, b| (a.triangle, a.side) == (b.triangle, b.side)) {
            let Hanging { triangle, side, .. } = own[0];
            let [a, b, third] = [0, 1, 2].map(|m| self.triangles[triangle][(side + m) % 3]);
            let part = |a: usize, b: usize| Side {
                ends: [a.min(b), a.max(b)],
                triangle,
                third,
            };
            whole.push(part(a, b));
            let mut from = a;
            for to in own.iter().map(|h| h.corner).chain([b]) {
                parts.push(part(from, to));
                from = to;
            }
        }
        whole.sort_unstable();
        self.sides.retain(|s| whole.binary_search(s).is_err());
        self.sides.extend(parts);
        self.sides.sort_unstable();
    }
}

/// The box in which corners may be on a side.
fn around([a, b]: [Vector3; 2], margin: Margin) -> Extent {
    let length = (b - a).norm();
    let most = margin.in_plane(length).max(margin.across(length));
    let [a, b] = [a, b].map(Vector3::to_array);
    let bound = |best: fn(f64, f64) -> f64| core::array::from_fn(|k| best(a[k], b[k]));
    let extent = Extent {
        low: bound(f64::min),
        high: bound(f64::max),
    };
    // Twice: as far away as both together.
    extent.wider(2.0 * most)
}
