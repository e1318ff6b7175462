// SPDX-License-Identifier: MIT OR Apache-2.0
//! Corners at which convex edges meet concave ones. What lies behind the triangles there is the union of convex pieces, each
//! the part behind the planes of one triangle and of all that it lies behind; and the body's support by each piece is continuous
//! as it moves. So are the shares of the supports, whichever the pieces are.

use super::box_tree::Extent;
use super::convex_corner::{self, Support};
use super::ellipsoid::Ellipsoid;
use super::fine_folds::FineFolds;
use super::lists::{on_heap, InRoom, Lent, List, Lists, OnHeap};
use super::triangle::{sides, Near, TOLERANCE};
use super::triangle_places::{TrianglePlaces, REACH};
#[cfg(not(feature = "std"))]
use crate::real::Real;
use crate::vector::Vector3;

/// Corners at which convex and concave edges meet, within reach of one body, at most: the pieces of more would reach far beyond their
/// places. Those of narrow triangles are left to `fine_folds`.
const MOST: usize = 3;

/// Such a corner, the one that was gathered last.
pub(super) struct MixedCorner<M: Lists = OnHeap> {
    /// Which of `near` meet there.
    meeting: M::List<usize>,
    bounds: M::List<Bound>,
    pieces: M::List<Piece>,
    /// Those of one piece: which bounds, and their normals out of it.
    members: M::List<usize>,
    normals: M::List<Vector3>,
}

on_heap!(MixedCorner: meeting bounds pieces members normals);

/// A plane of triangles that meet at a corner.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Bound {
    normal: Vector3,
    /// Which of `near`'s planes it is.
    plane: usize,
}

/// A convex part of what lies behind the triangles that meet at a corner.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Piece {
    /// Which bounds, and which of them with the normal turned.
    bounds: u64,
    turned: u64,
    /// One of `near` on it.
    near: usize,
}

impl Bound {
    /// Of no triangle.
    pub(super) const NONE: Bound = Bound {
        normal: Vector3::ZERO,
        plane: 0,
    };
}

impl Piece {
    /// Of no triangle.
    pub(super) const NONE: Piece = Piece {
        bounds: 0,
        turned: 0,
        near: 0,
    };
}

impl<'m> MixedCorner<InRoom<'m>> {
    /// In room of somebody's.
    pub(super) fn in_room(
        [meeting, members]: [&'m mut [usize]; 2],
        bounds: &'m mut [Bound],
        pieces: &'m mut [Piece],
        normals: &'m mut [Vector3],
    ) -> Self {
        MixedCorner {
            meeting: Lent::new(meeting),
            bounds: Lent::new(bounds),
            pieces: Lent::new(pieces),
            members: Lent::new(members),
            normals: Lent::new(normals),
        }
    }
}

/// Which of the triangles at a corner show the body's centre the side that is the inner one of those it sees: bits, in the order of `all`. The surface
/// has the side of the triangle nearest to the centre, and of two as near of that whose plane is farther, as one sees a roof from before its front.
/// An edge that more than two triangles share passes no side on, and what is not reached counts as seen from before.
#[cfg_attr(not(feature = "std"), inline(never))]
fn seen_from_behind(near: &[Near], all: &[usize], apex: Vector3) -> u64 {
    if all.len() > 64 {
        return 0;
    }
    let far = |k: usize| near[k].nearest_distance_squared();
    let mut first = 0;
    for m in 1..all.len() {
        let (here, best) = (far(all[m]), far(all[first]));
        let margin = TOLERANCE * best;
        let is_farther_plane = near[all[m]].distance > near[all[first]].distance;
        if here < best - margin || here <= best + margin && is_farther_plane {
            first = m;
        }
    }
    // The side of an edge from the apex on which a triangle that has it lies, by its normal.
    let side = |t: &Near, end: Vector3| {
        let along = t.normal.cross(end - apex);
        t.corners
            .iter()
            .find(|z| **z != apex && **z != end)
            .map(|z| along.dot(*z - apex) > 0.0)
    };
    let has = |k: usize, end: Vector3| near[k].corners.contains(&end);
    let (mut reached, mut back) = (1u64 << first, 0u64);
    loop {
        let before = reached;
        for m in (0..all.len()).filter(|m| before >> m & 1 == 1) {
            let t = &near[all[m]];
            if !t.corners.contains(&apex) {
                continue;
            }
            for end in t.corners.into_iter().filter(|z| *z != apex) {
                let mut others =
                    (0..all.len()).filter(|&o| o != m && has(all[o], apex) && has(all[o], end));
                let (Some(o), None) = (others.next(), others.next()) else {
                    continue;
                };
                if reached >> o & 1 == 0 {
                    reached |= 1 << o;
                    let turned = side(t, end) == side(&near[all[o]], end);
                    back |= u64::from((back >> m & 1 == 1) != turned) << o;
                }
            }
        }
        if reached == before {
            return back;
        }
    }
}

impl<M: Lists> MixedCorner<M> {
    /// Whether something did not fit.
    pub(super) fn lacks_room(&self) -> bool {
        self.meeting.lacks_room()
            || self.bounds.lacks_room()
            || self.pieces.lacks_room()
            || self.members.lacks_room()
            || self.normals.lacks_room()
    }

    /// The corners within reach of the body, each by a triangle that has it, and how many; none if there are more than [`MOST`], which then act
    /// by the faces, edges and corners of the triangles alone.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn find(
        &mut self,
        places: &TrianglePlaces<M>,
        body: &Ellipsoid,
        meeting: f64,
        fine: &FineFolds<M>,
    ) -> ([(usize, Vector3); MOST], usize) {
        let mut found = [(0, Vector3::ZERO); MOST];
        let mut count = 0;
        for k in 0..places.near.len() {
            for apex in places.near[k].corners {
                let unit = body.inverse_semi_axes.componentwise(body.to_body(apex));
                let is_near = unit.norm_squared() < REACH * REACH;
                if is_near && self.gather(places, k, apex, meeting) && !fine.meet_at(apex) {
                    if count == MOST {
                        return (found, 0);
                    }
                    found[count] = (k, apex);
                    count += 1;
                }
            }
        }
        (found, count)
    }

    /// Finds the convex pieces at a corner; false if there is no more to it than the triangles' own faces, edges and corners say, or
    /// if an earlier triangle has this corner as well.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn gather(
        &mut self,
        places: &TrianglePlaces<M>,
        own: usize,
        apex: Vector3,
        meeting: f64,
    ) -> bool {
        let MixedCorner {
            meeting: all,
            bounds,
            pieces,
            ..
        } = self;
        all.clear();
        bounds.clear();
        pieces.clear();
        let mut is_first = true;
        let place = Extent::about(apex.to_array(), meeting);
        places.tree.visit(&places.boxes, &place, |k| {
            let q = &places.near[k];
            is_first = k >= own || !q.corners.contains(&apex);
            if is_first && q.has(apex, meeting) {
                all.push(k);
            }
            is_first
        });
        if !is_first {
            return false;
        }
        all.sort();
        let back = seen_from_behind(&places.near, all, apex);
        for (place, &k) in all.iter().enumerate() {
            let t = &places.near[k];
            if bounds.iter().all(|b| b.plane != t.plane) {
                let is_back = back >> place & 1 == 1;
                bounds.push(Bound {
                    normal: if is_back { -t.normal } else { t.normal },
                    plane: t.plane,
                });
            }
        }
        if bounds.len() < 2 || bounds.len() > 64 {
            return false;
        }
        for (place, &k) in all.iter().enumerate() {
            let t = &places.near[k];
            if back >> place & 1 == 1 || places.is_hidden(k, apex, meeting) {
                continue;
            }
            let mut piece = Piece {
                bounds: 0,
                turned: 0,
                near: k,
            };
            for (m, b) in bounds.iter().enumerate() {
                let bit = 1u64 << m;
                if b.plane == t.plane {
                    piece.bounds |= bit;
                    continue;
                }
                let [before, behind] = sides(b.normal, apex, &t.corners);
                if before && behind {
                    continue;
                }
                if !before {
                    piece.bounds |= bit;
                } else {
                    // a neighbour of which the body's centre is on the other side
                    let shares = |q: &Near| {
                        t.corners
                            .iter()
                            .any(|z| *z != apex && q.corners.contains(z))
                    };
                    let mut others = all
                        .iter()
                        .map(|q| &places.near[*q])
                        .filter(|q| q.plane == b.plane);
                    if others.any(|q| shares(q) && !sides(t.normal, apex, &q.corners)[0]) {
                        piece.bounds |= bit;
                        piece.turned |= bit;
                    }
                }
            }
            pieces.push(piece);
        }
        // Some two must rise from each other. A face of a block of which the body's centre is on the inner side does not.
        let rises = |p: &Piece, q: &Piece| {
            let (t, q) = (&places.near[p.near], &places.near[q.near]);
            sides(t.normal, apex, &q.corners)[0]
        };
        let is_concave = |k: usize| {
            let p = &pieces[k];
            pieces[..k].iter().any(|q| rises(p, q) && rises(q, p))
        };
        if !(1..pieces.len()).any(is_concave) {
            return false;
        }
        // of two of which one lies within the other, the larger one is enough
        let mut kept = 0;
        for k in 0..pieces.len() {
            let p = pieces[k];
            let is_within = |q: &Piece| q.bounds & !p.bounds == 0;
            let is_larger = |q: &Piece| is_within(q) && q.bounds != p.bounds;
            if !pieces[k..].iter().any(is_larger) && !pieces[..kept].iter().any(is_within) {
                pieces[kept] = p;
                kept += 1;
            }
        }
        pieces.truncate(kept);
        kept > 1 && pieces.iter().any(|p| p.bounds.count_ones() > 1)
    }

    /// Tells how the body is supported by each convex piece of the corner gathered last, along a line or at the corner, with a triangle of the
    /// piece; the planes that support it are the bits of what is returned, in the order of [`MixedCorner::planes`].
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn supports(
        &mut self,
        places: &TrianglePlaces<M>,
        body: &Ellipsoid,
        apex: Vector3,
        mut found: impl FnMut(Support, usize),
    ) -> u64 {
        let MixedCorner {
            meeting: all,
            bounds,
            pieces,
            members,
            normals,
        } = self;
        // the planes that act, by bound
        let mut acting = 0u64;
        for piece in pieces.iter() {
            normals.clear();
            members.clear();
            members.add_all((0..bounds.len()).filter(|m| piece.bounds >> m & 1 == 1));
            normals.add_all(members.iter().map(|&m| {
                if piece.turned >> m & 1 == 1 {
                    -bounds[m].normal
                } else {
                    bounds[m].normal
                }
            }));
            let Some(support) = convex_corner::support(body, apex, normals) else {
                continue;
            };
            match support {
                Support::Plane(m) => acting |= 1 << members[m],
                Support::Line { along, foot, .. } => {
                    // beyond the other end of the triangles' own edge it is for the corner there to say
                    let way = foot - apex;
                    let is_beyond = all.iter().any(|&q| {
                        places.near[q].corners.iter().any(|z| {
                            let side = *z - apex;
                            let ahead = side.dot(way);
                            side.cross(along).norm() <= TOLERANCE * side.norm()
                                && ahead > 0.0
                                && ahead >= side.norm_squared()
                        })
                    });
                    if !is_beyond {
                        found(support, piece.near);
                    }
                }
                Support::Apex { .. } => found(support, piece.near),
            }
        }
        acting
    }

    /// The planes of its triangles, and one triangle of each.
    pub fn planes<'a>(
        &'a self,
        places: &'a TrianglePlaces<M>,
    ) -> impl Iterator<Item = (usize, usize)> + 'a {
        self.bounds.iter().filter_map(|bound| {
            let of_plane = |k: &&usize| places.near[**k].plane == bound.plane;
            Some((bound.plane, *self.meeting.iter().find(of_plane)?))
        })
    }
}
