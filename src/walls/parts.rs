// SPDX-License-Identifier: MIT OR Apache-2.0
//! The parts of a wall of which some are triangles, as values: what a device has of them.

use super::shape::{Ball, Grain};
use super::surface::Surface;
use super::touched::{Touched, NO_CONTACT};
use super::triangle_contacts::{place_of, InBall};
use crate::geometry::box_tree::{visit, Extent, Node};
use crate::geometry::lists::{InRoom, Lent, List};
use crate::geometry::triangle_room::TriangleRoom;
use crate::geometry::triangles::{Triangle, TriangleContact, TriangleSearch};
#[cfg(not(feature = "std"))]
use alloc::vec::Vec;

/// Contacts of one particle with a wall that has triangles that are remembered, at most.
#[doc(hidden)]
pub const MOST_RECORDS: usize = 64;

/// A part of a wall.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
#[repr(C)]
// They are in one array on a device.
#[allow(clippy::large_enum_variant)]
pub enum Part {
    /// One without triangles.
    Surface(Surface),
    /// Triangles: those from the first number up to the second, and where the nodes of their tree are.
    Triangles([u64; 2], [u64; 2]),
}

/// All that a device has of the parts of a wall.
#[doc(hidden)]
#[derive(Clone, Debug, Default)]
pub struct OwnParts {
    /// The parts, in their order.
    pub parts: Vec<Part>,
    /// The triangles of all of them.
    pub triangles: Vec<Triangle>,
    /// Of each triangle.
    pub boxes: Vec<Extent>,
    /// How wide the flat piece is of which each triangle is a part.
    pub widths: Vec<f64>,
    /// Of the trees of all meshes.
    pub nodes: Vec<Node>,
    /// Those of the triangles that belong to a node, by their numbers within the mesh.
    pub order: Vec<usize>,
}

/// The same, lent.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct Parts<'a> {
    /// See [`OwnParts`].
    pub parts: &'a [Part],
    /// See [`OwnParts`].
    pub triangles: &'a [Triangle],
    /// See [`OwnParts`].
    pub boxes: &'a [Extent],
    /// See [`OwnParts`].
    pub widths: &'a [f64],
    /// See [`OwnParts`].
    pub nodes: &'a [Node],
    /// See [`OwnParts`].
    pub order: &'a [usize],
}

/// Room for what is found of one particle: of `N` triangles near it, `C` faces, edges and corners, `K` pairs of them.
#[doc(hidden)]
#[derive(Clone, Debug)]
#[repr(C)]
pub struct Room<const N: usize, const C: usize, const K: usize> {
    search: TriangleRoom<N, C, K>,
    /// Numbers of triangles whose boxes are near: these may be many more.
    near: [[u32; 8]; N],
    contacts: [Touched; C],
    taken: [bool; MOST_RECORDS],
}

impl<const N: usize, const C: usize, const K: usize> Room<N, C, K> {
    /// With nothing in it.
    pub const EMPTY: Self = Room {
        search: TriangleRoom::EMPTY,
        near: [[0; 8]; N],
        contacts: [NO_CONTACT; C],
        taken: [false; MOST_RECORDS],
    };

    /// Lends it to the search of one particle.
    #[inline(always)]
    pub fn lend(&mut self) -> LentRoom<'_> {
        LentRoom {
            search: SearchInRoom {
                triangles: self.search.search(),
                near: Lent::new(self.near.as_flattened_mut()),
            },
            contacts: &mut self.contacts,
            taken: &mut self.taken,
        }
    }
}

/// Room of any size.
#[doc(hidden)]
pub struct LentRoom<'m> {
    pub(super) search: SearchInRoom<'m>,
    pub(super) contacts: &'m mut [Touched],
    pub(super) taken: &'m mut [bool],
}

/// A search among triangles.
pub(super) struct SearchInRoom<'m> {
    triangles: TriangleSearch<InRoom<'m>>,
    near: Lent<'m, u32>,
}

/// The triangles of one part.
#[derive(Clone, Copy)]
struct OnePart<'a> {
    triangles: &'a [Triangle],
    boxes: &'a [Extent],
    widths: &'a [f64],
    nodes: &'a [Node],
    order: &'a [usize],
}

impl<'a> Parts<'a> {
    #[inline(always)]
    fn one(&self, of: &[u64; 2], nodes: &[u64; 2]) -> OnePart<'a> {
        let [from, to] = of.map(|k| k as usize);
        let [first, end] = nodes.map(|k| k as usize);
        OnePart {
            triangles: &self.triangles[from..to],
            boxes: &self.boxes[from..to],
            widths: &self.widths[from..to],
            nodes: &self.nodes[first..end],
            order: &self.order[from..to],
        }
    }

    /// False only if a body within the ball cannot touch; true where a number is not finite.
    #[inline(always)]
    pub fn are_near(&self, ball: &Ball) -> bool {
        let c = ball.centre;
        if !(c.x + c.y + c.z + ball.radius).is_finite() {
            return true;
        }
        let place = InBall::new(c, ball.radius);
        self.parts.iter().any(|part| match part {
            Part::Surface(surface) => surface.is_near(ball),
            Part::Triangles(of, nodes) => self.one(of, nodes).comes_into(&place),
        })
    }
}

impl OnePart<'_> {
    fn comes_into(&self, place: &InBall) -> bool {
        let mut comes = false;
        visit(self.nodes, self.order, self.boxes, &place.extent, |k| {
            comes = place.may_have(&self.triangles[k]);
            !comes
        });
        comes
    }
}

impl SearchInRoom<'_> {
    /// The contacts of a body with the triangles of a part.
    pub(super) fn touch(
        &mut self,
        parts: &Parts<'_>,
        (of, nodes): (&[u64; 2], &[u64; 2]),
        grain: &Grain<'_>,
    ) -> &[TriangleContact] {
        let part = parts.one(of, nodes);
        let near = &mut self.near;
        near.clear();
        let place = place_of(grain);
        visit(part.nodes, part.order, part.boxes, &place, |k| {
            near.push(k as u32);
            true
        });
        // in the order of the triangles, whatever the tree is
        near.sort();
        let near = &*near;
        let corners = near.iter().map(|&k| part.triangles[k as usize]);
        let width = |k: usize| part.widths[near[k] as usize];
        (self.triangles).touch_each(grain.body, grain.centre, corners, width);
        self.triangles.contacts()
    }

    /// Whether something did not fit in this search, or in one before.
    pub(super) fn lacks_room(&self) -> bool {
        self.near.lacks_room() || self.triangles.lacks_room()
    }
}
