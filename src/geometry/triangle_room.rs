// SPDX-License-Identifier: MIT OR Apache-2.0
//! Room for the lists of a search among triangles, of a size that is known before: what a device sets aside.

use super::box_tree::{Extent, Node};
use super::facet_shares::{Line, Section, ShareMemory};
use super::fine_folds::{Edge, FineFolds};
use super::lists::{InRoom, Lent};
use super::mixed_corners::{Bound, MixedCorner, Piece};
use super::share::Share;
use super::triangle::Near;
use super::triangle_places::TrianglePlaces;
use super::triangles::{Candidate, Feature, TriangleContact, TriangleSearch};
use crate::vector::Vector3;

/// Room for a search of which `N` triangles are near the body, `C` faces, edges and corners support it, and `K` pairs of these cut each
/// other. The numbers in it may be any; all zeros are room, too.
#[doc(hidden)]
#[derive(Clone, Debug)]
#[repr(C)]
pub struct TriangleRoom<const N: usize, const C: usize, const K: usize> {
    near: [Near; N],
    boxes: [Extent; N],
    node: [Node; 1],
    order: [usize; N],
    of_plane: [usize; N],
    covered: [usize; N],
    left: [[Share; 2]; N],
    edges: [[Edge; 2]; N],
    sharp: [[Edge; 2]; N],
    meeting: [usize; N],
    members: [usize; N],
    bounds: [Bound; N],
    pieces: [[Piece; 2]; N],
    normals: [Vector3; N],
    depths: [Share; N],
    candidates: [Candidate; C],
    sections: [Section; C],
    contacts: [TriangleContact; C],
    lines: [Line; C],
    arcs: [[[f64; 2]; 2]; C],
    cuts: [[usize; 2]; K],
}

impl<const N: usize, const C: usize, const K: usize> TriangleRoom<N, C, K> {
    /// With nothing in it.
    pub const EMPTY: Self = TriangleRoom {
        near: [Near::NONE; N],
        boxes: [Extent::NONE; N],
        node: [Node::NONE; 1],
        order: [0; N],
        of_plane: [0; N],
        covered: [0; N],
        left: [[Share::WHOLE; 2]; N],
        edges: [[Edge::NONE; 2]; N],
        sharp: [[Edge::NONE; 2]; N],
        meeting: [0; N],
        members: [0; N],
        bounds: [Bound::NONE; N],
        pieces: [[Piece::NONE; 2]; N],
        normals: [Vector3::ZERO; N],
        depths: [Share::NONE; N],
        candidates: [Candidate::NONE; C],
        sections: [Section::NONE; C],
        contacts: [TriangleContact {
            point: Vector3::ZERO,
            normal: Vector3::ZERO,
            penetration: 0.0,
            triangle: 0,
            feature: Feature::Face,
            share: Share::WHOLE,
        }; C],
        lines: [Line::NONE; C],
        arcs: [[[0.0; 2]; 2]; C],
        cuts: [[0; 2]; K],
    };

    /// A search in it.
    #[inline(always)]
    pub fn search(&mut self) -> TriangleSearch<InRoom<'_>> {
        TriangleSearch {
            contacts: Lent::new(&mut self.contacts),
            places: TrianglePlaces::in_room(
                &mut self.near,
                &mut self.boxes,
                &mut self.node,
                &mut self.order,
            ),
            of_plane: Lent::new(&mut self.of_plane),
            candidates: Lent::new(&mut self.candidates),
            sections: Lent::new(&mut self.sections),
            cuts: Lent::new(&mut self.cuts),
            corner: MixedCorner::in_room(
                [&mut self.meeting, &mut self.members],
                &mut self.bounds,
                self.pieces.as_flattened_mut(),
                &mut self.normals,
                &mut self.depths,
            ),
            fine: FineFolds::in_room(
                &mut self.left,
                [&mut self.edges, &mut self.sharp].map(|list| list.as_flattened_mut()),
            ),
            covered: Lent::new(&mut self.covered),
            memory: ShareMemory::in_room(&mut self.lines, self.arcs.as_flattened_mut()),
        }
    }
}

impl TriangleSearch<InRoom<'_>> {
    /// Whether the last search, or one before, had too little room: its contacts count for nothing.
    pub(crate) fn lacks_room(&self) -> bool {
        use super::lists::List;
        self.contacts.lacks_room()
            || self.places.lacks_room()
            || self.of_plane.lacks_room()
            || self.candidates.lacks_room()
            || self.sections.lacks_room()
            || self.cuts.lacks_room()
            || self.corner.lacks_room()
            || self.fine.lacks_room()
            || self.covered.lacks_room()
            || self.memory.lacks_room()
    }
}
