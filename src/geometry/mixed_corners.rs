// SPDX-License-Identifier: MIT OR Apache-2.0
//! Corners at which convex edges meet concave ones. What lies behind the triangles there is the union of convex pieces, each
//! the part behind the planes of one triangle and of all that it lies behind; and the body's support by each piece is continuous
//! as it moves. So are the shares of the supports, whichever the pieces are.
//!
//! A corner acts by its pieces as far as its edges are in the body, and by the triangles' own faces, edges and corners for the rest. Whether a triangle bounds
//! pieces or has one is a matter of the side that it shows the body's centre.

use super::box_tree::Extent;
use super::convex_corner::{self, Support};
use super::ellipsoid::Ellipsoid;
use super::fine_folds::FineFolds;
use super::lists::{on_heap, InRoom, Lent, List, Lists, OnHeap};
use super::share::Share;
use super::triangle::{sides, Near, TOLERANCE};
use super::triangle_places::{TrianglePlaces, REACH};
#[cfg(not(feature = "std"))]
use crate::real::Real;
use crate::vector::Vector3;

/// Corners at which convex and concave edges meet, within reach of one body, at most: the pieces of more would reach far beyond their
/// places. Those of narrow triangles are left to `fine_folds`.
const MOST: usize = 3;

/// Up to which square of its distance, where the body is the unit sphere, a corner may act by its convex pieces alone, and from which on it does not. Outside of
/// the body the faces, edges and corners of the triangles say nearly the same, so that the part changes where that hardly matters.
const EFFECT: [f64; 2] = [1.02 * 1.02, REACH * REACH];

/// How deep an edge of the corner is in the body where the corner acts by its convex pieces alone, as a part of how deep the triangles are.
const SHALLOW: f64 = 0.2;

/// A corner within reach.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReachedCorner {
    apex: Vector3,
    /// The part in which its convex pieces act: 0 where it comes into reach, and where none of its edges is in the body.
    part: Share,
}

/// The corners within reach, those that act by the largest parts, the largest first; one more than may act together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reached {
    corners: [ReachedCorner; MOST + 1],
    count: usize,
}

impl Default for Reached {
    fn default() -> Self {
        Reached::NONE
    }
}

impl Reached {
    const NONE: Reached = Reached {
        corners: [ReachedCorner {
            apex: Vector3::ZERO,
            part: Share::NONE,
        }; MOST + 1],
        count: 0,
    };

    fn has(&self, apex: Vector3) -> bool {
        self.corners[..self.count].iter().any(|c| c.apex == apex)
    }

    /// Puts a corner in its place; false if there are too many in the body, where none acts by its pieces.
    fn add(&mut self, new: ReachedCorner) -> bool {
        let all = &mut self.corners;
        let place = (0..self.count).find(|k| all[*k].part.value < new.part.value);
        let place = place.unwrap_or(self.count);
        if place <= MOST {
            self.count = (self.count + 1).min(MOST + 1);
            all[place..self.count].rotate_right(1);
            all[place] = new;
        }
        self.count <= MOST || all[MOST].part.value < 1.0
    }

    /// The part of a whole in which only the first corners act by their convex pieces, so many of them, and the others by the triangles' own faces, edges
    /// and corners. So the force is continuous where corners come into reach, also where they become too many.
    pub fn part_of_first(&self, count: usize, whole: &Share) -> Share {
        if self.count == 0 {
            return *whole;
        }
        let part = |k: usize| match k {
            0 => Share::WHOLE,
            _ if k > self.count => Share::NONE,
            _ => self.corners[k - 1].part,
        };
        let own = part(count).minus(&part(count + 1));
        let own = match count {
            0 => own.plus(&part(MOST + 1)),
            _ => own,
        };
        own.times(whole)
    }

    /// Where one of them is.
    pub fn apex(&self, k: usize) -> Vector3 {
        self.corners[k].apex
    }

    /// How many of them may act together.
    pub fn most(&self) -> usize {
        self.count.min(MOST)
    }
}

/// Such a corner, the one that was gathered last.
pub(super) struct MixedCorner<M: Lists = OnHeap> {
    /// Which of `near` meet there.
    meeting: M::List<usize>,
    bounds: M::List<Bound>,
    pieces: M::List<Piece>,
    /// Those of one piece: which bounds, and their normals out of it.
    members: M::List<usize>,
    normals: M::List<Vector3>,
    /// How deep the flat pieces are in the body, by the planes of the triangles.
    depths: M::List<Share>,
    /// Whether a flat piece has more than one triangle.
    is_divided: bool,
    /// Those within reach.
    pub reached: Reached,
}

on_heap!(MixedCorner: meeting bounds pieces members normals depths is_divided reached);

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
        depths: &'m mut [Share],
    ) -> Self {
        MixedCorner {
            meeting: Lent::new(meeting),
            bounds: Lent::new(bounds),
            pieces: Lent::new(pieces),
            members: Lent::new(members),
            normals: Lent::new(normals),
            depths: Lent::new(depths),
            is_divided: false,
            reached: Reached::NONE,
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
            || self.depths.lacks_room()
    }

    /// Finds the corners within reach of the body.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn find(
        &mut self,
        places: &TrianglePlaces<M>,
        body: &Ellipsoid,
        meeting: f64,
        fine: &FineFolds<M>,
    ) {
        self.reached.count = 0;
        let near = &places.near;
        if near.iter().all(|t| t.plane == near[0].plane) {
            return;
        }
        self.is_divided = near.iter().enumerate().any(|(k, t)| t.plane != k);
        let ball = EFFECT[1] * body.bounding_radius() * body.bounding_radius();
        let mut depths = Depths::default();
        for k in 0..near.len() {
            for apex in near[k].corners {
                if apex.norm_squared() > ball {
                    continue;
                }
                let unit = body.inverse_semi_axes.componentwise(body.to_body(apex));
                let square = unit.norm_squared();
                if !(square < EFFECT[1]) || self.reached.has(apex) {
                    continue;
                }
                let is_other = |q: usize| q < k && near[q].corners.contains(&apex);
                if self.meet(places, apex, meeting, is_other) {
                    continue;
                }
                let planes = self.meeting.iter().map(|&q| near[q].plane);
                if planes.clone().all(|plane| plane == near[k].plane) {
                    continue;
                }
                let mut deepest = 0.0f64;
                self.visit_edges(places, body, apex, |_, depth| {
                    deepest = depth;
                    depth
                });
                if !(deepest > 0.0)
                    || fine.meet_at(places, apex)
                    || !self.is_mixed(places, apex, meeting)
                {
                    continue;
                }
                let part = self.part(places, body, apex, square, deepest, &mut depths);
                if !self.reached.add(ReachedCorner { apex, part }) {
                    return;
                }
            }
        }
    }

    /// Visits the edges that end at the corner whose triangles were found last: the deepest place of each in the body, and how deep it is. Only such as
    /// are deeper than 0, and than what `found` returned last. An edge that triangles divide is visited as a whole.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn visit_edges(
        &self,
        places: &TrianglePlaces<M>,
        body: &Ellipsoid,
        apex: Vector3,
        mut found: impl FnMut(Vector3, f64) -> f64,
    ) {
        let unit = |p: Vector3| body.inverse_semi_axes.componentwise(body.to_body(p));
        let from = unit(apex);
        let mut least = 0.0;
        for &k in self.meeting.iter() {
            let t = &places.near[k];
            if !t.corners.contains(&apex) {
                continue;
            }
            for &end in t.corners.iter().filter(|p| **p != apex) {
                let whole = match self.is_divided {
                    true => places.end_of_side(t.plane, [apex, end]),
                    false => end,
                };
                let way = unit(whole) - from;
                let place = (-from.dot(way) / way.norm_squared()).clamp(0.0, 1.0);
                let depth = 1.0 - (from + way * place).norm_squared();
                let continues = |&q: &usize| {
                    let q = &places.near[q];
                    q.plane == t.plane && t.is_continued_by(q, apex, end)
                };
                if depth > least && !self.meeting.iter().any(continues) {
                    least = found(apex + (whole - apex) * place, depth);
                }
            }
        }
    }

    /// The part in which the corner gathered last acts by its convex pieces: not where a body lies on one of its faces alone, which then is a plane.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn part(
        &mut self,
        places: &TrianglePlaces<M>,
        body: &Ellipsoid,
        apex: Vector3,
        square: f64,
        deepest: f64,
        depths: &mut Depths,
    ) -> Share {
        let mut part = Share::WHOLE;
        if deepest < SHALLOW * depths.most(places, body) {
            let full = depths
                .of_all(places, body, &mut self.depths)
                .scaled(SHALLOW);
            // An edge that rounding alone has put into the body.
            if !(full.value > 0.0) {
                return Share::NONE;
            }
            let mut left = Share::WHOLE;
            self.visit_edges(places, body, apex, |place, _| {
                let own = depth_of(body, place).over(&full).smoothed();
                left = left.times(&own.complement());
                0.0
            });
            part = left.complement();
        }
        if square > EFFECT[0] {
            let mut within = depth_of(body, apex);
            within.value = EFFECT[1] - square;
            part = part.times(&within.scaled(1.0 / (EFFECT[1] - EFFECT[0])).smoothed());
        }
        part
    }

    /// Finds the convex pieces at a corner of [`MixedCorner::find`]; false if there is no more to it than the triangles' own faces, edges and corners say.
    pub fn gather(&mut self, places: &TrianglePlaces<M>, apex: Vector3, meeting: f64) -> bool {
        self.meet(places, apex, meeting, |_| false);
        self.divide(places, apex, meeting)
    }

    /// Finds the triangles that meet at a corner, or whether one of them stands for it.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn meet(
        &mut self,
        places: &TrianglePlaces<M>,
        apex: Vector3,
        meeting: f64,
        stands: impl Fn(usize) -> bool,
    ) -> bool {
        let all = &mut self.meeting;
        all.clear();
        let mut one_stands = false;
        let place = Extent::about(apex.to_array(), meeting);
        places.tree.visit(&places.boxes, &place, |k| {
            one_stands = stands(k);
            if !one_stands && places.near[k].has(apex, meeting) {
                all.push(k);
            }
            !one_stands
        });
        all.sort();
        one_stands
    }

    /// Whether convex and concave edges meet at the corner whose triangles were found last: if not, there is no more to it than the triangles' own faces,
    /// edges and corners say.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn is_mixed(&mut self, places: &TrianglePlaces<M>, apex: Vector3, meeting: f64) -> bool {
        let MixedCorner {
            meeting: all,
            members,
            ..
        } = self;
        let near = &places.near;
        let of_plane = |k: usize| near[k].plane;
        if all.iter().all(|&k| of_plane(k) == of_plane(all[0])) {
            return false;
        }
        members.clear();
        members.add_all((all.iter().copied()).filter(|&k| !places.is_hidden(k, apex, meeting)));
        let sides = |k: usize, q: usize| sides(near[k].normal, apex, &near[q].corners);
        let others = |k: usize| members.iter().filter(move |&&q| of_plane(q) != of_plane(k));
        // Some two must rise from each other. A face of a block of which the body's centre is on the inner side does not.
        let is_concave = |&k: &usize| {
            let mut others = others(k);
            others.any(|&q| sides(k, q)[0] && sides(q, k)[0])
        };
        let is_convex = |&k: &usize| {
            all.iter()
                .any(|&q| of_plane(q) != of_plane(k) && !sides(q, k)[0])
        };
        members.iter().any(is_concave) && members.iter().any(is_convex)
    }

    /// Finds the convex pieces of the triangles that meet at a corner.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn divide(&mut self, places: &TrianglePlaces<M>, apex: Vector3, meeting: f64) -> bool {
        let MixedCorner {
            meeting: all,
            bounds,
            pieces,
            ..
        } = self;
        bounds.clear();
        pieces.clear();
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
        if bounds.len() > 64 {
            return false;
        }
        for (place, &k) in all.iter().enumerate() {
            if back >> place & 1 == 1 || places.is_hidden(k, apex, meeting) {
                continue;
            }
            let t = &places.near[k];
            let (whole, passing) = piece_of(places, all, bounds, k, apex);
            for m in 0..3 {
                let [u, v] = [t.corners[m] - apex, t.corners[(m + 1) % 3] - apex];
                let (lu, lv) = (u.norm(), v.norm());
                if !(lu > meeting && lv > meeting && u.cross(v).norm() > TOLERANCE * lu * lv) {
                    continue;
                }
                // The planes that pass through the triangle divide it: each part is behind other ones.
                let (u, v) = (u * (1.0 / lu), v * (1.0 / lv));
                let passes = |m: usize| passing >> m & 1 == 1;
                let mut from = 0.0;
                while from < 1.0 {
                    let mut to = 1.0f64;
                    for (_, b) in bounds.iter().enumerate().filter(|(m, _)| passes(*m)) {
                        let (p, q) = (b.normal.dot(u), b.normal.dot(v));
                        let place = p / (p - q);
                        let is_between = p * q < 0.0 && p.abs().min(q.abs()) > TOLERANCE;
                        if is_between && place > from + TOLERANCE {
                            to = to.min(place);
                        }
                    }
                    let middle = 0.5 * (from + to);
                    let way = u * (1.0 - middle) + v * middle;
                    let mut piece = whole;
                    for (m, b) in bounds.iter().enumerate().filter(|(m, _)| passes(*m)) {
                        piece.bounds |= u64::from(b.normal.dot(way) < 0.0) << m;
                    }
                    if !pieces.iter().any(|q| q.bounds & !piece.bounds == 0) {
                        pieces.push(piece);
                    }
                    from = to;
                }
            }
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
            ..
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

/// How deep the triangles near a body are in it, which is asked for at a few corners only.
#[derive(Default)]
struct Depths {
    most: Option<f64>,
    of_all: Option<Share>,
}

impl Depths {
    /// No less than that of all.
    fn most<M: Lists>(&mut self, places: &TrianglePlaces<M>, body: &Ellipsoid) -> f64 {
        *self.most.get_or_insert_with(|| {
            let mut least = 1.0f64;
            for t in places.near.iter() {
                least = least.min(t.distance * body.support(t.normal).inverse_h);
            }
            let count = places.near.len() as f64;
            (1.0 - least * least) * count.sqrt().sqrt()
        })
    }

    /// About that of the deepest, with an even slope where another becomes the deepest. A flat piece counts once, however many triangles it has.
    fn of_all<M: Lists>(
        &mut self,
        places: &TrianglePlaces<M>,
        body: &Ellipsoid,
        of_pieces: &mut M::List<Share>,
    ) -> Share {
        *self.of_all.get_or_insert_with(|| {
            of_pieces.set_all(places.near.len(), Share::NONE);
            for t in places.near.iter() {
                let support = body.support(-t.normal);
                let depth = depth_of(body, t.nearest_to(body, &support, Vector3::ZERO));
                let piece = &mut of_pieces[t.plane];
                if depth.value > piece.value {
                    *piece = depth;
                }
            }
            let mut sum = Share::NONE;
            for depth in of_pieces.iter().filter(|depth| depth.value > 0.0) {
                let second = depth.times(depth);
                sum = sum.plus(&second.times(&second));
            }
            if !(sum.value > 0.0) {
                return Share::NONE;
            }
            let root = sum.value.sqrt().sqrt();
            Share {
                value: root,
                ..sum.scaled(0.25 * root / sum.value)
            }
        })
    }
}

/// How deep a place is in the body, 1 in its centre and 0 at its surface, with its gradients.
#[cfg_attr(not(feature = "std"), inline(never))]
fn depth_of(body: &Ellipsoid, place: Vector3) -> Share {
    let unit = body.inverse_semi_axes.componentwise(body.to_body(place));
    // along the place, of which the body moves the other way
    let outwards = body.to_world(body.inverse_semi_axes.componentwise(unit)) * 2.0;
    Share {
        value: 1.0 - unit.norm_squared(),
        by_position: outwards,
        by_rotation: place.cross(outwards),
    }
}

/// The convex piece of one of the triangles at a corner: behind the triangle's plane and all that it lies behind. And the planes that pass through it.
#[cfg_attr(not(feature = "std"), inline(never))]
fn piece_of<M: Lists>(
    places: &TrianglePlaces<M>,
    all: &[usize],
    bounds: &[Bound],
    k: usize,
    apex: Vector3,
) -> (Piece, u64) {
    let t = &places.near[k];
    let mut piece = Piece {
        bounds: 0,
        turned: 0,
        near: k,
    };
    let mut passing = 0;
    for (m, b) in bounds.iter().enumerate() {
        let bit = 1u64 << m;
        if b.plane == t.plane {
            piece.bounds |= bit;
            continue;
        }
        let [before, behind] = sides(b.normal, apex, &t.corners);
        if before && behind {
            passing |= bit;
        } else if !before {
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
    (piece, passing)
}
