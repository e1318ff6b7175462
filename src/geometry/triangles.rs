// SPDX-License-Identifier: MIT OR Apache-2.0
//! An ellipsoid and a surface of triangles.
//!
//! The surface acts where its distance from the body's deepest reach is a minimum: on a face, if the deepest point lies
//! over it; on an edge or a corner, if the normal there points away from all triangles that meet at the point, and where
//! that of the shortest way out of the body does not, as with more than half of a thin body past an edge, by the way to the
//! body's other side. Which triangles meet is a question of place, not of shared corners: a triangle that passes within `MEETING` of a point
//! meets there, whatever mesh it belongs to and wherever its own corners are. So an edge between coplanar triangles, or one
//! that lies inside another triangle, or at the bottom of a fold, never acts, and a body that lies on any pieces of a
//! plane touches once. Both sides of a triangle act; the body's centre decides which.
//!
//! A face of which the body's deepest point has passed a concave fold goes on acting while a part of it is in the body, by
//! its share (`facet_shares`): so a contact goes over a fold of any angle without a jump, and many small facets act as the
//! curved surface that they approach. Faces cut each other's contacts where they meet.
//!
//! The deepest point of a long body across a block's edge can lie over a face that the body does not reach, or of which it is on the
//! other side. So a face acts if a part of its plane's triangles is in the body, and if no other triangle hides it from the body's centre.
//!
//! The time goes with `n log n` of the triangles near the body: what meets at a place is asked of a tree of boxes.
//!
//! At a corner where convex edges meet concave ones, as in a saddle, a face or an edge does not end where its triangles do. There
//! the convex pieces act of which the corner is the union, as far as they go: a ridge beyond the corner goes on acting by its
//! share, and a face beyond a fold ends at the line of its convex edges. They act as far as edges of the corner are in the body: a body on one face
//! alone feels its plane.
//!
//! Of a surface of many narrow triangles that is shaped as a saddle, or uneven, nearly all corners are of that kind, and a body has many of them within its
//! contact. Where a narrow flat piece, of one triangle or more, has a convex and a concave edge at small angles within reach, and no sharp edge is, the faces alone act, each by
//! the part of its section that its own triangles cover (`fine_folds`). These parts sum to the whole, so the surface acts once, as the curved one that it
//! approaches.
//!
//! What is not continuous: corners of wide triangles at which convex and concave edges meet, in few ways, most of them of bodies that lie deeper than a
//! twentieth of their smallest semi-axis, and where more than three such corners are in the body; narrow pieces at angles of more than 15 degrees; and a
//! body whose centre is nearly at an uneven surface, where a face may be hidden from it by another. An edge that shares the
//! overlap with something else is taken to hold its normal in
//! the gradient of the shares: the force is continuous for that, but not exactly the gradient of the energy.
//!
//! # Example
//! ```
//! use ellgran::geometry::facet_shares::{share, Section, Share, ShareMemory, SupportingPlane};
//! use ellgran::geometry::triangles::{barycentric_weights, Feature, TriangleSearch};
//! use ellgran::geometry::Ellipsoid;
//! use ellgran::vector::Vector3;
//!
//! // A ball of radius 1 m, 1 cm deep in a triangle of the floor.
//! let ball = Ellipsoid::new([1.0; 3], [1.0, 0.0, 0.0, 0.0]).expect("an ellipsoid");
//! let centre = Vector3::new(0.0, 0.0, 0.99);
//! let floor = [
//!     Vector3::new(-3.0, -3.0, 0.0),
//!     Vector3::new(3.0, -3.0, 0.0),
//!     Vector3::new(0.0, 6.0, 0.0),
//! ];
//! let mut search = TriangleSearch::default();
//! search.touch(&ball, centre, &[floor]);
//! let [contact] = search.contacts() else { panic!("one contact") };
//! assert_eq!(contact.feature, Feature::Face);
//! assert!((contact.penetration - 0.01).abs() < 1e-14);
//! assert!((contact.normal - Vector3::new(0.0, 0.0, 1.0)).norm() < 1e-14);
//! assert_eq!(contact.share.value, Share::WHOLE.value);
//! // It lies in the middle of the triangle.
//! let weights = barycentric_weights(&floor, contact.point);
//! assert!(weights.iter().all(|weight| (weight - 1.0 / 3.0).abs() < 1e-14));
//!
//! // In a right angle of two planes each cuts nothing of the other's contact while the overlaps are apart.
//! let up = SupportingPlane { point: contact.point - centre, normal: Vector3::new(0.0, 0.0, 1.0) };
//! let side = SupportingPlane { point: Vector3::new(0.99, 0.0, 0.0), normal: Vector3::new(-1.0, 0.0, 0.0) };
//! let sections = [up, side].map(|plane| Section::new(&ball, &plane));
//! assert!(!sections[0].is_cut_by(&sections[1]));
//! let whole = share(&ball, &sections[0], sections[1..].iter(), &mut ShareMemory::default());
//! assert_eq!(whole.value, 1.0);
//! ```

use super::box_tree::Extent;
use super::convex_corner::Support as CornerSupport;
use super::ellipsoid::{Ellipsoid, Support};
use super::facet_shares::{share, Section, Share, ShareMemory, SupportingPlane};
use super::fine_folds::FineFolds;
#[cfg(feature = "std")]
use super::flat_pieces;
use super::interior_point::{nearest_normal, normal_on_other_side};
use super::lists::{on_heap, List, Lists, OnHeap};
use super::mixed_corners::MixedCorner;
use super::nearest_line::{nearest_across, nearest_on_other_side};
use super::triangle::{Near, MEETING, TOLERANCE};
use super::triangle_places::{is_within_reach, TrianglePlaces, SAME_PLANE};
#[cfg(not(feature = "std"))]
use crate::real::Real;
use crate::vector::Vector3;

pub use super::triangle::{barycentric_weights, Triangle};

/// Which part of a triangle touches.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub enum Feature {
    /// Its plane.
    Face,
    /// An edge; the unit vector along it.
    Edge(Vector3),
    /// A corner.
    Corner,
}

/// A contact with a surface of triangles.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct TriangleContact {
    /// The point of the surface, or of the face's plane, deepest in the body, world frame.
    pub point: Vector3,
    /// Unit normal out of the surface, towards the body.
    pub normal: Vector3,
    /// Penetration > 0.
    pub penetration: f64,
    /// Index of the triangle that stands for the contact.
    pub triangle: usize,
    /// What touches.
    pub feature: Feature,
    /// By how much of Hertz' law it acts.
    pub share: Share,
}

/// Contacts of a body with a surface of triangles, and the memory to find them; kept between calls.
pub struct TriangleSearch<M: Lists = OnHeap> {
    pub(super) contacts: M::List<TriangleContact>,
    pub(super) places: TrianglePlaces<M>,
    /// For each of `near` the candidate of its plane, `NOTHING` without one.
    pub(super) of_plane: M::List<usize>,
    pub(super) candidates: M::List<Candidate>,
    pub(super) sections: M::List<Section>,
    /// A candidate and another that cuts its contact.
    pub(super) cuts: M::List<[usize; 2]>,
    pub(super) corner: MixedCorner<M>,
    pub(super) fine: FineFolds<M>,
    /// For each of `near` the contact of its plane by what its triangles cover, `NOTHING` without one.
    pub(super) covered: M::List<usize>,
    pub(super) memory: ShareMemory<M>,
}

on_heap!(TriangleSearch: contacts places of_plane candidates sections cuts corner fine covered memory);

/// Cosine of 3 degrees. An edge or a corner whose normal differs by less from that of another contact at the same place is
/// taken as that contact, so that neighbouring triangles do not act twice. A compromise between flaws of meshes and real edges: a
/// corner that is off by a twentieth of an edge turns a normal by as much, and the force of a contact that is left out would have had at most
/// 5 %, the sine, in another direction.
const SAME_NORMAL: f64 = 0.998_629_534_754_573_9;

/// Two triangles give the penetration of an edge that they share to rounding. What differs by less than this share of the distance at which triangles
/// meet is as deep: then the first of the triangles stands for the contact, or rounding would choose whose velocity and material it has.
const SAME_DEPTH: f64 = 1e-5;

/// Triangles of one plane that are looked at each beside each other, at most.
const MOST_JOINED: usize = 32;

/// A contact of less is none. Rounding leaves shares of 1e-15 where there are none, and each would take a place among the contacts of which
/// a history is kept.
const LEAST_SHARE: f64 = 1e-12;

/// No index.
const NOTHING: usize = usize::MAX;

/// No index, of a plane that does not act: it does not go on beyond its border, or not at one of the corners at which convex and concave edges meet.
const ASKED: usize = NOTHING - 1;

/// No index, of a plane that another triangle hides.
const HIDDEN: usize = ASKED - 1;

/// A plane that supports the body.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Candidate {
    /// As in [`SupportingPlane`].
    plane: SupportingPlane,
    /// The deepest point of the plane, from the body's centre.
    foot: Vector3,
    penetration: f64,
    triangle: usize,
    feature: Feature,
    /// The deepest point belongs to the surface.
    over: bool,
    /// One of `near` in its plane, of a face.
    near: usize,
    /// An edge or a corner by the way to the body's other side: only where nothing that it is a part of is left by a shorter one.
    is_other: bool,
}

impl<M: Lists> TriangleSearch<M> {
    /// The contacts of the last call of [`TriangleSearch::touch`], deepest first.
    pub fn contacts(&self) -> &[TriangleContact] {
        &self.contacts
    }

    /// Finds the contacts of a body with centre `centre`. The triangles are all those near the body: an edge at which one is
    /// missing counts as a free edge. A triangle with a corner that is not finite is left out. Of a flat piece of the surface that goes on beyond
    /// what is near, the triangles to a distance of the body's largest semi-axis belong to them: its width decides how the edges of a narrow one act.
    #[cfg(feature = "std")]
    pub fn touch(&mut self, body: &Ellipsoid, centre: Vector3, triangles: &[Triangle]) {
        let widths = core::cell::OnceCell::new();
        let width = |index: usize| widths.get_or_init(|| flat_pieces::widths(triangles))[index];
        self.touch_each(body, centre, triangles.iter().copied(), width);
    }

    /// The same of triangles one after the other, and how wide the flat piece is of which each is a part ([`super::flat_pieces`]), by its number
    /// among them.
    pub(crate) fn touch_each(
        &mut self,
        body: &Ellipsoid,
        centre: Vector3,
        triangles: impl Iterator<Item = Triangle>,
        width: impl Fn(usize) -> f64,
    ) {
        self.contacts.clear();
        self.candidates.clear();
        let meeting = MEETING * body.smallest_semi_axis();
        self.places.gather(body, centre, triangles, meeting);
        if self.places.near.is_empty() || self.places.lacks_room() {
            return;
        }
        if let Some(mut alone) = self.lone_face(body, meeting) {
            alone.point = alone.point + centre;
            self.contacts.push(alone);
        } else if (self.places.near.iter()).any(|t| body.support(-t.normal).h > t.distance) {
            self.all_contacts(body, centre, meeting, &width);
        }
    }

    /// The contacts with the triangles that are near.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn all_contacts(
        &mut self,
        body: &Ellipsoid,
        centre: Vector3,
        meeting: f64,
        width: &impl Fn(usize) -> f64,
    ) {
        self.places.join_planes(body.bounding_radius(), meeting);
        self.covered.clear();
        let rest = self.fine.rest(&self.places, body, meeting, width);
        if rest.value < 1.0 {
            self.covered_faces(body, meeting, &rest.complement());
        }
        if rest.value > 0.0 {
            self.whole_contacts(body, meeting, &rest);
        }
        for contact in self.contacts.iter_mut() {
            contact.point = contact.point + centre;
        }
        self.contacts.sort_with(|a, b| {
            b.penetration
                .total_cmp(&a.penetration)
                .then(a.triangle.cmp(&b.triangle))
        });
    }

    /// Faces, edges and corners, by a part of their shares.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn whole_contacts(&mut self, body: &Ellipsoid, meeting: f64, part: &Share) {
        (self.corner).find(&self.places, body, meeting, &self.fine);
        for count in 0..=self.corner.reached.most() {
            let own = self.corner.reached.part_of_first(count, part);
            if own.value > 0.0 {
                self.contacts_with(body, meeting, count, &own);
            }
        }
    }

    /// The same, of which so many corners within reach act by their convex pieces.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn contacts_with(&mut self, body: &Ellipsoid, meeting: f64, mixed: usize, part: &Share) {
        self.candidates.clear();
        self.faces(body, meeting);
        for k in 0..self.places.near.len() {
            self.edges(body, k, meeting);
            self.corners(body, k, meeting);
        }
        for k in 0..mixed {
            let apex = self.corner.reached.apex(k);
            if self.corner.gather(&self.places, apex, meeting) {
                self.act_at_corner(body, apex);
            }
        }
        self.forget_asked();
        if self.candidates.lacks_room() {
            return;
        }
        self.keep_one_of_each(meeting);
        self.find_cuts(body, meeting);
        let earlier = self.contacts.len();
        let mut cuts = &self.cuts[..];
        for (k, c) in self.candidates.iter().enumerate() {
            let (own, rest) = cuts.split_at(cuts.partition_point(|cut| cut[0] == k));
            cuts = rest;
            let others = own.iter().map(|cut| &self.sections[cut[1]]);
            let share = share(body, &self.sections[k], others, &mut self.memory).times(part);
            if share.value > LEAST_SHARE {
                let found = TriangleContact {
                    point: c.foot,
                    normal: c.plane.normal,
                    penetration: c.penetration,
                    triangle: c.triangle,
                    feature: c.feature,
                    share,
                };
                // What acts by two parts is one contact.
                match self.contacts[..earlier]
                    .iter_mut()
                    .find(|c| is_one(c, &found, meeting))
                {
                    Some(own) => own.share = own.share.plus(&share),
                    None => self.contacts.push(found),
                }
            }
        }
    }

    /// The planes of faces, each by the part of its section that its triangles cover, and that by a part.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn covered_faces(&mut self, body: &Ellipsoid, meeting: f64, part: &Share) {
        let places = &self.places;
        self.covered.set_all(places.near.len(), NOTHING);
        self.of_plane.set_all(places.near.len(), NOTHING);
        for t in places.near.iter() {
            let support = body.support(-t.normal);
            let penetration = support.h - t.distance;
            if !(penetration > 0.0 && t.is_in_section(body, &support, penetration)) {
                continue;
            }
            let foot = support.point + t.normal * penetration;
            // A plane is hidden or not as a whole.
            if self.of_plane[t.plane] == NOTHING {
                let middle = Vector3::ZERO;
                let (k, point) = places.nearest_in_plane(t.plane, body, &support, middle);
                self.of_plane[t.plane] = match places.is_hidden(k, point, meeting) {
                    true => HIDDEN,
                    false => t.plane,
                };
            }
            if self.of_plane[t.plane] == HIDDEN {
                continue;
            }
            let plane = SupportingPlane {
                point: t.corners[0],
                normal: t.normal,
            };
            let own = Section::new(body, &plane);
            let borders = t.borders().map(|border| Section::new(body, &border));
            let share = share(body, &own, borders.iter(), &mut self.memory).times(part);
            if !(share.value > LEAST_SHARE) {
                continue;
            }
            let known = &mut self.covered[t.plane];
            if let Some(contact) = self.contacts.get_mut(*known) {
                contact.share = contact.share.plus(&share);
            } else {
                *known = self.contacts.len();
                self.contacts.push(TriangleContact {
                    point: foot,
                    normal: t.normal,
                    penetration,
                    triangle: t.index,
                    feature: Feature::Face,
                    share,
                });
            }
        }
    }

    /// The one contact, its point from the body's centre, where all triangles near the body are of one plane and the body is within the
    /// borders of one of them, or of several that continue one another: the quick way to what the others find there.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn lone_face(&self, body: &Ellipsoid, meeting: f64) -> Option<TriangleContact> {
        let (first, others) = self.places.near.split_first()?;
        let largest = body.bounding_radius();
        if !others
            .iter()
            .all(|q| q.is_in_plane_of(first, largest, SAME_PLANE))
        {
            return None;
        }
        let contact = |t: &Near, is_lone: &dyn Fn(&Support, Vector3) -> bool| {
            let support = body.support(-t.normal);
            let penetration = support.h - t.distance;
            let foot = support.point + t.normal * penetration;
            (penetration > 0.0 && is_lone(&support, foot)).then_some(TriangleContact {
                point: foot,
                normal: t.normal,
                penetration,
                triangle: t.index,
                feature: Feature::Face,
                share: Share::WHOLE,
            })
        };
        let in_one = |t: &Near| {
            contact(t, &|support, foot| {
                t.borders_are_clear(body, support, foot, meeting)
            })
        };
        if let Some(found) = self.places.near.iter().find_map(in_one) {
            return Some(found);
        }
        if others.is_empty()
            || self.places.near.len() > MOST_JOINED
            || !self.places.is_joined_in(body)
        {
            return None;
        }
        self.places.near.iter().find_map(|t| {
            contact(t, &|support, foot| {
                let middle = support.point * (t.distance * support.inverse_h);
                // Both places are in the section, which has no border: so all of it is covered, and the foot continues what is reached.
                let unit = body.inverse_semi_axes.componentwise(body.to_body(foot));
                unit.norm_squared() <= 1.0
                    && t.has(foot, meeting)
                    && self.places.near.iter().any(|q| q.has(middle, meeting))
            })
        })
    }

    /// The planes of faces on which the body lies, or on a part of which it lies beyond a fold.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn faces(&mut self, body: &Ellipsoid, meeting: f64) {
        self.of_plane.set_all(self.places.near.len(), NOTHING);
        for own in 0..self.places.near.len() {
            let mut k = own;
            let t = &self.places.near[k];
            let known = self.candidates.get(self.of_plane[t.plane]);
            if known.is_some_and(|c| c.over) {
                continue;
            }
            let is_known = known.is_some();
            let normal = t.normal;
            let support = body.support(-normal);
            let penetration = support.h - t.distance;
            if !(penetration > 0.0) {
                continue;
            }
            let foot = support.point + normal * penetration;
            let over = self.places.boxes[k].overlaps(&Extent::about(foot.to_array(), meeting))
                && t.has(foot, meeting);
            let reaches = |q: &Near| q.is_in_section(body, &support, penetration);
            let point = if over {
                let reached = reaches(t)
                    || self
                        .places
                        .near
                        .iter()
                        .any(|q| q.plane == t.plane && reaches(q));
                if !reached {
                    continue;
                }
                foot
            } else {
                if is_known || self.of_plane[t.plane] == ASKED || !reaches(t) {
                    continue;
                }
                self.of_plane[t.plane] = ASKED;
                let plane = t.plane;
                let point;
                (k, point) = self.places.nearest_in_plane(plane, body, &support, foot);
                if !self.places.goes_on_beyond(k, point, foot, meeting) {
                    continue;
                }
                point
            };
            let t = &self.places.near[k];
            if self.places.is_hidden(k, point, meeting) {
                continue;
            }
            // Of a place outside of the body what hides it may be outside, too: a part of the plane that is in it must be seen.
            let unit = body.inverse_semi_axes.componentwise(body.to_body(point));
            let is_seen = |m: usize| {
                let q = &self.places.near[m];
                q.plane == t.plane
                    && reaches(q)
                    && !self.places.is_hidden(
                        m,
                        q.nearest_to(body, &support, Vector3::ZERO),
                        meeting,
                    )
            };
            if unit.norm_squared() > 1.0 && !(0..self.places.near.len()).any(is_seen) {
                continue;
            }
            let candidate = Candidate {
                plane: SupportingPlane { point, normal },
                foot,
                penetration,
                triangle: t.index,
                feature: Feature::Face,
                over,
                near: k,
                is_other: false,
            };
            let place = &mut self.of_plane[t.plane];
            match self.candidates.get_mut(*place) {
                Some(known) => *known = candidate,
                None => {
                    *place = self.candidates.len();
                    self.candidates.push(candidate);
                }
            }
        }
        self.forget_asked();
    }

    /// Leaves no plane [`ASKED`].
    fn forget_asked(&mut self) {
        for place in self.of_plane.iter_mut().filter(|place| **place == ASKED) {
            *place = NOTHING;
        }
    }

    #[cfg_attr(not(feature = "std"), inline(never))]
    fn edges(&mut self, body: &Ellipsoid, k: usize, meeting: f64) {
        let t = self.places.near[k];
        let unit = t
            .corners
            .map(|p| body.inverse_semi_axes.componentwise(body.to_body(p)));
        for m in 0..3 {
            let (a, b, c) = (t.corners[m], t.corners[(m + 1) % 3], t.corners[(m + 2) % 3]);
            if !is_within_reach(unit[m], unit[(m + 1) % 3]) || self.places.is_within_plane(k, a, b)
            {
                continue;
            }
            let length = (b - a).norm();
            let along = (b - a) * (1.0 / length);
            let Some(nearest) = nearest_across(body, a, along) else {
                continue;
            };
            for is_other in [false, true] {
                let way = if is_other {
                    nearest_on_other_side(body, a, along)
                } else {
                    Some(nearest)
                };
                let Some(n) = way else {
                    break;
                };
                let normal = -n;
                if normal.dot(c - a) > TOLERANCE * (c - a).norm() {
                    continue;
                }
                let support = body.support(n);
                let penetration = support.h - n.dot(a);
                if !(penetration > 0.0) {
                    break;
                }
                let place = along.dot(support.point - a);
                if place < -meeting || place > length + meeting {
                    break;
                }
                let point = a + along * place;
                if self.places.is_outermost(normal, point, meeting)
                    && (!is_other || self.places.stands_out(point, meeting))
                {
                    let feature = Feature::Edge(along);
                    self.add_point(normal, point, penetration, feature, k, is_other);
                    break;
                }
            }
        }
    }

    #[cfg_attr(not(feature = "std"), inline(never))]
    fn corners(&mut self, body: &Ellipsoid, k: usize, meeting: f64) {
        let t = self.places.near[k];
        for corner in t.corners {
            let local = body.to_body(corner).to_array();
            let semi_axes = body.semi_axes.to_array();
            let Some(nearest) = nearest_normal(semi_axes, local) else {
                continue;
            };
            for is_other in [false, true] {
                let way = if is_other {
                    normal_on_other_side(semi_axes, local)
                } else {
                    Some(nearest)
                };
                let Some(n) = way else {
                    break;
                };
                let n = body.to_world(Vector3::from_array(n)).normalised();
                let normal = -n;
                let away = t.corners.iter().all(|z| {
                    let way = *z - corner;
                    normal.dot(way) <= TOLERANCE * way.norm()
                });
                if away
                    && self.places.is_outermost(normal, corner, meeting)
                    && (!is_other || self.places.stands_out(corner, meeting))
                {
                    let penetration = body.support(n).h - n.dot(corner);
                    if penetration > 0.0 {
                        self.add_point(normal, corner, penetration, Feature::Corner, k, is_other);
                    }
                    break;
                }
            }
        }
    }

    /// Puts the supports by the convex pieces of the corner gathered last in the place of what the triangles' planes say.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn act_at_corner(&mut self, body: &Ellipsoid, apex: Vector3) {
        let TriangleSearch {
            places,
            candidates,
            corner,
            of_plane,
            ..
        } = self;
        let places = &*places;
        let acting = corner.supports(places, body, apex, |support, near| {
            let (normal, foot, feature) = match support {
                // as the plane of a face, below
                CornerSupport::Plane(_) => return,
                CornerSupport::Line {
                    along,
                    normal,
                    foot,
                } => (normal, foot, Feature::Edge(along)),
                CornerSupport::Apex { normal } => (normal, apex, Feature::Corner),
            };
            let penetration = body.support(normal).h - normal.dot(apex);
            candidates.push(Candidate::at_point(
                -normal,
                foot,
                penetration,
                feature,
                &places.near[near],
                near,
            ));
        });
        for (m, (plane, k)) in corner.planes(places).enumerate() {
            let known = candidates.get_mut(of_plane[plane]);
            if acting >> m & 1 == 0 {
                match known {
                    Some(known) if known.over => (),
                    Some(known) => known.triangle = NOTHING,
                    None => of_plane[plane] = ASKED,
                }
            } else if of_plane[plane] == NOTHING {
                let t = &places.near[k];
                let support = body.support(-t.normal);
                let penetration = support.h - t.distance;
                let foot = support.point + t.normal * penetration;
                of_plane[plane] = candidates.len();
                candidates.push(Candidate {
                    plane: SupportingPlane {
                        point: apex,
                        normal: t.normal,
                    },
                    foot,
                    penetration,
                    triangle: t.index,
                    feature: Feature::Face,
                    over: false,
                    near: k,
                    is_other: false,
                });
            }
        }
    }

    /// An edge or a corner that touches.
    fn add_point(
        &mut self,
        normal: Vector3,
        point: Vector3,
        penetration: f64,
        feature: Feature,
        near: usize,
        is_other: bool,
    ) {
        let triangle = &self.places.near[near];
        let candidate = Candidate::at_point(normal, point, penetration, feature, triangle, near);
        self.candidates.push(Candidate {
            is_other,
            ..candidate
        });
    }

    /// Leaves out edges and corners by the way to the body's other side where a plane, an edge or a corner that meets them is left by a shorter way.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn leave_longer_ways(&mut self, reach: f64) {
        for k in 0..self.candidates.len() {
            let c = self.candidates[k];
            let is_shorter = |d: &Candidate| {
                let apart = d.foot - c.foot;
                d.triangle != NOTHING
                    && d.penetration < c.penetration
                    && (d.plane.normal.dot(apart).abs() <= reach
                        || c.plane.normal.dot(apart).abs() <= reach)
            };
            if c.is_other && self.candidates.iter().any(is_shorter) {
                self.candidates[k].triangle = NOTHING;
            }
        }
    }

    /// Leaves one of several candidates for one contact: an edge or a corner beneath the deepest point of a face, or two that
    /// triangles have in common.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn keep_one_of_each(&mut self, meeting: f64) {
        let is_whole = |c: &Candidate| c.feature == Feature::Face && c.triangle != NOTHING;
        if self.candidates.iter().all(is_whole) {
            return;
        }
        let reach = 3.0 * meeting;
        self.leave_longer_ways(reach);
        self.candidates
            .sort_with(|a, b| a.foot.x.total_cmp(&b.foot.x).then(a.order(b)));
        for k in 0..self.candidates.len() {
            let c = self.candidates[k];
            for other in k + 1..self.candidates.len() {
                let d = self.candidates[other];
                if d.foot.x - c.foot.x > reach || self.candidates[k].triangle == NOTHING {
                    break;
                }
                let faces = c.feature == Feature::Face && d.feature == Feature::Face;
                if !faces
                    && d.triangle != NOTHING
                    && c.plane.normal.dot(d.plane.normal) > SAME_NORMAL
                    && (c.foot - d.foot).norm_squared() <= reach * reach
                {
                    let loser = if c.stands_for(&d, SAME_DEPTH * meeting) {
                        other
                    } else {
                        k
                    };
                    self.candidates[loser].triangle = NOTHING;
                }
            }
        }
        self.candidates.retain(|c| c.triangle != NOTHING);
        self.of_plane.fill(NOTHING);
        for (k, c) in self.candidates.iter().enumerate() {
            if c.feature == Feature::Face {
                self.of_plane[self.places.near[c.near].plane] = k;
            }
        }
    }

    /// Which candidates cut each other's contacts: faces that meet, and edges and corners with everything.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn find_cuts(&mut self, body: &Ellipsoid, meeting: f64) {
        let TriangleSearch {
            places: TrianglePlaces { near, boxes, tree },
            of_plane,
            candidates,
            sections,
            cuts,
            ..
        } = self;
        sections.clear();
        sections.add_all(candidates.iter().map(|c| Section::new(body, &c.plane)));
        cuts.clear();
        let mut cut = |c: usize, d: usize, meet: &dyn Fn() -> bool| {
            let [one, other] = [[c, d], [d, c]].map(|[c, d]| sections[c].is_cut_by(&sections[d]));
            if (one || other) && meet() {
                cuts.add_all(one.then_some([c, d]));
                cuts.add_all(other.then_some([d, c]));
            }
        };
        for (k, t) in near.iter().enumerate() {
            let c = of_plane[t.plane];
            if c == NOTHING || candidates.len() == 1 {
                continue;
            }
            tree.visit(boxes, &boxes[k].wider(meeting), |other| {
                let q = &near[other];
                let d = of_plane[q.plane];
                if other < k && d != NOTHING && d != c {
                    cut(c, d, &|| t.meets(q, meeting));
                }
                true
            });
        }
        for (c, point) in candidates.iter().enumerate() {
            if point.feature == Feature::Face {
                continue;
            }
            for (d, other) in candidates.iter().enumerate() {
                if d < c || other.feature == Feature::Face {
                    cut(c, d, &|| true);
                }
            }
        }
        cuts.sort();
        cuts.dedup();
    }
}

/// Whether two contacts are the same plane's.
fn is_one(one: &TriangleContact, other: &TriangleContact, meeting: f64) -> bool {
    (one.feature == Feature::Face) == (other.feature == Feature::Face)
        && (one.normal - other.normal).norm_squared() <= SAME_PLANE * SAME_PLANE
        && (one.point - other.point).norm_squared() <= meeting * meeting
}

impl Candidate {
    /// Of no triangle.
    pub(super) const NONE: Candidate = Candidate {
        plane: SupportingPlane {
            point: Vector3::ZERO,
            normal: Vector3::ZERO,
        },
        foot: Vector3::ZERO,
        penetration: 0.0,
        triangle: NOTHING,
        feature: Feature::Face,
        over: false,
        near: 0,
        is_other: false,
    };

    /// An edge or a corner: `normal` out of the surface, through `point`.
    fn at_point(
        normal: Vector3,
        point: Vector3,
        penetration: f64,
        feature: Feature,
        triangle: &Near,
        near: usize,
    ) -> Candidate {
        Candidate {
            plane: SupportingPlane { point, normal },
            foot: point,
            penetration,
            triangle: triangle.index,
            feature,
            over: true,
            near,
            is_other: false,
        }
    }

    /// Whether this one stands for a contact of which there is another candidate, as deep as that if within a distance.
    fn stands_for(&self, other: &Candidate, distance: f64) -> bool {
        let is_as_deep = (self.penetration - other.penetration).abs() <= distance;
        let penetration = if is_as_deep {
            other.penetration
        } else {
            self.penetration
        };
        let even = Candidate {
            penetration,
            ..*self
        };
        even.order(other).is_lt()
    }

    /// What is sorted first of two candidates.
    fn order(&self, other: &Candidate) -> core::cmp::Ordering {
        let rank = |c: &Candidate| match c.feature {
            Feature::Face if c.over => 0,
            Feature::Face => 1,
            Feature::Edge(_) => 2,
            Feature::Corner => 3,
        };
        rank(self)
            .cmp(&rank(other))
            .then(other.penetration.total_cmp(&self.penetration))
            .then(self.triangle.cmp(&other.triangle))
            .then(self.near.cmp(&other.near))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;

    fn touch(body: &Ellipsoid, centre: Vector3, triangles: &[Triangle]) -> Vec<TriangleContact> {
        let mut search = TriangleSearch::default();
        search.touch(body, centre, triangles);
        search.contacts().to_vec()
    }

    fn sheet(cells: usize, half: f64) -> Vec<Triangle> {
        let at = |i: usize, j: usize| {
            let x = |k: usize| half * (2.0 * k as f64 / cells as f64 - 1.0);
            Vector3::new(x(i), x(j), 0.0)
        };
        let mut all = vec![];
        for i in 0..cells {
            for j in 0..cells {
                let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                all.push([a, b, c]);
                all.push([a, c, d]);
            }
        }
        all
    }

    #[test]
    fn the_quick_way_finds_what_the_others_find() {
        let mut state = 1u64;
        let mut uniform = |low: f64, high: f64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            low + (high - low) * (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let (mut quick, mut touching) = (0, 0);
        for (cells, holes, deepest) in [
            (1, 0.0, 0.5),
            (2, 0.0, 0.5),
            (5, 0.0, 0.5),
            (5, 0.1, 1.5),
            (9, 0.03, 1.5),
        ] {
            let whole = sheet(cells, 1.0);
            for _ in 0..3000 {
                let mut sheet = whole.clone();
                sheet.retain(|_| uniform(0.0, 1.0) >= holes);
                let axes = [uniform(0.05, 0.6), uniform(0.05, 0.6), uniform(0.05, 0.6)];
                let q = [0; 4].map(|_| uniform(-1.0, 1.0));
                let body = Ellipsoid::new(axes, q).unwrap();
                let h = body.support(Vector3::new(0.0, 0.0, -1.0)).h;
                let depth = uniform(-0.1, deepest) * body.smallest_semi_axis();
                let place = [uniform(-1.2, 1.2), uniform(-1.2, 1.2)];
                let centre = Vector3::new(place[0], place[1], h - depth);
                let mut search = TriangleSearch::default();
                search.touch(&body, centre, &sheet);
                let found = search.contacts().to_vec();
                let meeting = MEETING * body.smallest_semi_axis();
                let widths = flat_pieces::widths(&sheet);
                quick += usize::from(search.lone_face(&body, meeting).is_some());
                search.contacts.clear();
                search.candidates.clear();
                search.all_contacts(&body, centre, meeting, &|k| widths[k]);
                let others = search.contacts().to_vec();
                touching += usize::from(!others.is_empty());
                assert_eq!(
                    format!("{found:?}"),
                    format!("{others:?}"),
                    "{body:?} {centre:?}"
                );
            }
        }
        println!("{quick} of {touching} by the quick way");
        assert!(quick > 2000 && touching > quick + 500);
    }

    #[test]
    fn a_flat_sheet_touches_once_wherever_the_body_lies() {
        for cells in [1, 4, 48] {
            let sheet = sheet(cells, 1.0);
            for axes in [[0.3, 0.3, 0.3], [0.3, 0.1, 0.01], [0.3, 0.01, 0.01]] {
                for q in [
                    [1.0, 0.0, 0.0, 0.0],
                    [0.9, 0.3, 0.1, 0.2],
                    [0.7, 0.0, 0.7, 0.0],
                ] {
                    let body = Ellipsoid::new(axes, q).unwrap();
                    let down = Vector3::new(0.0, 0.0, -1.0);
                    let h = body.support(down).h;
                    for (x, y) in [(0.0, 0.0), (0.123, 0.217), (0.25, 0.1), (0.25, -0.25)] {
                        // the deepest point over (x, y)
                        let s = body.support(down).point;
                        let centre = Vector3::new(x - s.x, y - s.y, 0.98 * h);
                        let contacts = touch(&body, centre, &sheet);
                        assert_eq!(
                            contacts.len(),
                            1,
                            "{cells} {axes:?} {q:?} {x} {y}: {contacts:?}"
                        );
                        let c = contacts[0];
                        assert!((c.penetration - 0.02 * h).abs() < 1e-12);
                        assert!((c.normal - Vector3::new(0.0, 0.0, 1.0)).norm() < 1e-7);
                        assert_eq!(c.feature, Feature::Face);
                    }
                }
            }
        }
    }

    /// Of the triangles that have an edge or a corner in common the first stands for the contact, whatever rounding makes of their penetrations.
    #[test]
    fn rounding_does_not_choose_among_the_triangles_of_an_edge() {
        let mut random = Random::new(41);
        let (mut edges, mut corners) = (0, 0);
        for _ in 0..400 {
            let turn = Ellipsoid::new([1.0; 3], random.quaternion()).unwrap();
            let away = random.direction() * 7.0;
            let at = |x: f64, y: f64, z: f64| turn.to_world(Vector3::new(x, y, z)) + away;
            // A roof, of which the ridge has a corner that is lower than the straight line by nothing or by a little.
            let bend = random.uniform(-0.1, 0.1);
            let (top, front, back) = (at(0.0, bend, 0.0), at(0.0, -3.0, -0.2), at(0.0, 3.1, -0.3));
            let mut roof = vec![];
            for (x, [one, other]) in [
                (-2.9, [[front, top], [top, back]]),
                (3.3, [[top, front], [back, top]]),
            ] {
                let eaves = at(x, 0.2, -1.3);
                roof.extend([one, other].map(|[a, b]| [a, b, eaves]));
            }
            let semi_axes = [0; 3].map(|_| random.uniform(0.3, 1.0));
            let body = Ellipsoid::new(semi_axes, random.quaternion()).unwrap();
            let up = turn.to_world(Vector3::new(0.0, 0.0, 1.0));
            let height = body.support(-up).h - 0.01;
            let along = random.uniform(-1.0, 1.0);
            let found = touch(
                &body,
                at(0.0, along, -0.08 * along.abs()) + up * height,
                &roof,
            );
            for contact in found {
                match contact.feature {
                    Feature::Face => continue,
                    Feature::Edge(_) => edges += 1,
                    Feature::Corner => corners += 1,
                }
                let first = roof.iter().position(|t| {
                    Near::new(0, t, contact.point, 0.0)
                        .unwrap()
                        .has(Vector3::ZERO, 1e-6)
                });
                assert_eq!(Some(contact.triangle), first);
            }
        }
        assert!(edges > 100 && corners > 10, "{edges} {corners}");
    }

    #[test]
    fn edges_and_corners_of_a_block_are_passed_without_a_jump() {
        // The block x < 0, z < 0 seen from above: top face and side face.
        let p = |x: f64, y: f64, z: f64| Vector3::new(x, y, z);
        let block = vec![
            [p(0.0, -5.0, 0.0), p(0.0, 5.0, 0.0), p(-5.0, 5.0, 0.0)],
            [p(0.0, -5.0, 0.0), p(-5.0, 5.0, 0.0), p(-5.0, -5.0, 0.0)],
            [p(0.0, -5.0, 0.0), p(0.0, -5.0, -5.0), p(0.0, 5.0, 0.0)],
            [p(0.0, 5.0, 0.0), p(0.0, -5.0, -5.0), p(0.0, 5.0, -5.0)],
        ];
        let body = Ellipsoid::new([0.5, 0.2, 0.1], [0.9, 0.1, 0.4, 0.1]).unwrap();
        let h = body.support(Vector3::new(0.0, 0.0, -1.0)).h;
        let mut last: Option<TriangleContact> = None;
        let mut seen_edge = false;
        for k in 0..2000 {
            let x = -1.0 + 2.0 * k as f64 / 2000.0;
            let contacts = touch(&body, p(x, 0.3, 0.99 * h), &block);
            assert!(contacts.len() <= 1, "{x}: {contacts:?}");
            let now = contacts.first().copied();
            if let (Some(a), Some(b)) = (last, now) {
                assert!((a.penetration - b.penetration).abs() < 2e-3 * h);
                assert!((a.normal - b.normal).norm() < 0.1);
            }
            if let (Some(a), None) = (last, now) {
                assert!(a.penetration < 2e-3 * h, "lost at {x}: {a:?}");
            }
            seen_edge |= matches!(now.map(|c| c.feature), Some(Feature::Edge(_)));
            last = now;
        }
        assert!(seen_edge && last.is_none());
    }

    #[test]
    fn a_fold_acts_on_both_sides_and_not_at_its_bottom() {
        let p = |x: f64, y: f64, z: f64| Vector3::new(x, y, z);
        // Floor z = 0 and wall x = 0, the body in the quadrant x > 0, z > 0.
        let fold = vec![
            [p(0.0, -5.0, 0.0), p(5.0, -5.0, 0.0), p(0.0, 5.0, 0.0)],
            [p(5.0, -5.0, 0.0), p(5.0, 5.0, 0.0), p(0.0, 5.0, 0.0)],
            [p(0.0, -5.0, 0.0), p(0.0, 5.0, 0.0), p(0.0, 5.0, 5.0)],
            [p(0.0, -5.0, 0.0), p(0.0, 5.0, 5.0), p(0.0, -5.0, 5.0)],
        ];
        let body = Ellipsoid::new([0.2; 3], [1.0, 0.0, 0.0, 0.0]).unwrap();
        let contacts = touch(&body, p(0.19, 0.4, 0.18), &fold);
        assert_eq!(contacts.len(), 2, "{contacts:?}");
        assert!((contacts[0].penetration - 0.02).abs() < 1e-12);
        assert!((contacts[1].penetration - 0.01).abs() < 1e-12);
    }

    /// A cube of half a side 1, each face in so many pieces along each side, turned.
    fn cube(pieces: usize, axes: &[Vector3; 3]) -> Vec<Triangle> {
        let world = |p: [f64; 3]| axes[0] * p[0] + axes[1] * p[1] + axes[2] * p[2];
        let mut all = vec![];
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let at = |i: usize, j: usize| {
                    let place = |k: usize| 2.0 * k as f64 / pieces as f64 - 1.0;
                    let mut p = [side; 3];
                    p[(axis + 1) % 3] = place(i);
                    p[(axis + 2) % 3] = place(j);
                    world(p)
                };
                for i in 0..pieces {
                    for j in 0..pieces {
                        let (a, b) = (at(i, j), at(i + 1, j));
                        let (c, d) = (at(i + 1, j + 1), at(i, j + 1));
                        all.extend([[a, b, c], [d, a, c]]);
                    }
                }
            }
        }
        all
    }

    /// On a face, an edge or a corner of a cube, with its normal in the cone of those of the faces: one contact, there.
    #[test]
    fn a_cube_is_touched_once_where_the_body_was_put() {
        let mut random = Random::new(41);
        let mut counts = [0; 3];
        for k in 0..900 {
            let pieces = 1 + k / 3 % 3;
            let axes = Ellipsoid::new([1.0; 3], random.quaternion()).unwrap().axes;
            let wall = cube(pieces, &axes);
            let semi_axes = [0; 3].map(|_| random.uniform(0.3, 0.8));
            let body = Ellipsoid::new(semi_axes, random.quaternion()).unwrap();
            // How many faces meet where it touches, which are those of the first axes.
            let faces = 1 + k % 3;
            let mut place = [0; 3].map(|_| random.uniform(-0.95, 0.95));
            if k % 5 == 0 {
                // On the borders of the pieces.
                place = [2.0 * (pieces / 2) as f64 / pieces as f64 - 1.0; 3];
            }
            let mut normal = [0.0; 3];
            for m in 0..faces {
                place[m] = if random.uniform(0.0, 1.0) < 0.5 {
                    -1.0
                } else {
                    1.0
                };
                normal[m] = place[m] * random.uniform(0.1, 1.0);
            }
            let world = |p: [f64; 3]| axes[0] * p[0] + axes[1] * p[1] + axes[2] * p[2];
            if place.iter().filter(|x| x.abs() == 1.0).count() > faces {
                continue;
            }
            let (point, normal) = (world(place), world(normal).normalised());
            let depth = random.uniform(0.001, 0.01) * body.smallest_semi_axis();
            let centre = point - normal * depth - body.support(-normal).point;
            let contacts = touch(&body, centre, &wall);
            let scene = format!("{faces} {place:?} {body:?} {centre:?}: {contacts:?}");
            assert_eq!(contacts.len(), 1, "{scene}");
            let found = &contacts[0];
            assert!((found.penetration - depth).abs() < 1e-12, "{scene}");
            assert!((found.normal - normal).norm() < 1e-6, "{scene}");
            assert!((found.point - point).norm() < 1e-6, "{scene}");
            assert!(found.share.value > 1.0 - 1e-12, "{scene}");
            let kind = match found.feature {
                Feature::Face => 1,
                Feature::Edge(_) => 2,
                Feature::Corner => 3,
            };
            // An edge of the cube has corners of the pieces on it.
            let is_either = k % 5 == 0 && faces == 2 && kind == 3;
            assert!(kind == faces || is_either, "{scene}");
            counts[faces - 1] += 1;
        }
        assert!(counts.iter().all(|count| *count > 100), "{counts:?}");
    }

    /// Thin bodies that lie across an edge of a cube, up to twice as deep as they are thin: the shortest way out along the normals between both faces. Without
    /// the way to the other side of the body those were lost of which more than half was past the edge.
    #[test]
    fn an_edge_keeps_a_body_that_is_deeper_than_half_of_it() {
        let mut random = Random::new(43);
        let mut counts = [0; 3];
        for k in 0..4000 {
            let axes = Ellipsoid::new([1.0; 3], random.quaternion()).unwrap().axes;
            let wall = cube(1 + k % 2, &axes);
            let thin = random.of_any_size(0.01, 0.2);
            let mut semi_axes = [0.3 * random.uniform(0.3, 1.0), 0.3, 0.3 * thin];
            semi_axes.rotate_left(k % 3);
            let body = Ellipsoid::new(semi_axes, random.quaternion()).unwrap();
            let edge = axes[0] + axes[1];
            let normal = |angle: f64| axes[0] * angle.cos() + axes[1] * angle.sin();
            let at = random.uniform(0.0, 1.57);
            let least_axis = body.smallest_semi_axis();
            let deep = random.uniform(0.05, 2.0) * least_axis;
            let point = edge + axes[2] * random.uniform(-0.3, 0.3);
            let centre = point - normal(at) * deep - body.support(-normal(at)).point;
            // The shortest way and where it is between the faces.
            let way =
                |angle: f64| body.support(-normal(angle)).h + normal(angle).dot(edge - centre);
            let parts = 4000;
            let angle = |m: i32| std::f64::consts::FRAC_PI_2 * f64::from(m) / f64::from(parts);
            let m = (0..=parts)
                .min_by(|a, b| way(angle(*a)).total_cmp(&way(angle(*b))))
                .unwrap();
            let (mut low, mut high) = (angle((m - 1).max(0)), angle((m + 1).min(parts)));
            for _ in 0..100 {
                let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
                if way(a) < way(b) {
                    high = b;
                } else {
                    low = a;
                }
            }
            let shortest = way(low).min(way(0.0)).min(way(angle(parts)));
            let outside = (0..2)
                .map(|m| axes[m].dot(centre) - 1.0)
                .fold(f64::MIN, f64::max);
            // Where the way starts, which of a body that is nearly past and lies aslant is not in it any more.
            let turned = normal(low);
            let along = axes[2].dot(body.support(-turned).point + centre);
            let start = edge + axes[2] * along - centre;
            let unit = body.inverse_semi_axes.componentwise(body.to_body(start));
            if !(unit.norm() < 1.0 && outside > 0.01 * least_axis) {
                continue;
            }
            let found = touch(&body, centre, &wall);
            let scene = format!("{k} {body:?} {centre:?} {shortest}: {found:?}");
            let depths = found.iter().map(|c| c.penetration);
            let kept = depths.fold(f64::INFINITY, f64::min);
            assert!(
                (kept - shortest).abs() < 1e-9 * body.bounding_radius(),
                "{scene}"
            );
            counts[usize::from(m > 0 && m < parts)] += 1;
            counts[2] += usize::from(shortest > 0.95 * least_axis);
        }
        println!("{counts:?}");
        assert!(counts.iter().all(|count| *count > 100), "{counts:?}");
    }

    fn ball() -> Ellipsoid {
        Ellipsoid::new([1.0; 3], [1.0, 0.0, 0.0, 0.0]).unwrap()
    }

    /// Edges of two fins, or that of one and a floor: they divide the contact where their parts of it overlap.
    #[test]
    fn edges_and_faces_near_each_other_divide_the_contact() {
        let fin = |x: f64| {
            [
                Vector3::new(x, -5.0, 0.0),
                Vector3::new(x, 5.0, 0.0),
                Vector3::new(x, 0.0, -5.0),
            ]
        };
        let centre = Vector3::new(0.0, 0.3, 0.96);
        // The planes through the edges cut each other's contacts halfway between them.
        for (apart, least, most) in [(0.03, 0.5, 0.65), (0.1, 0.65, 0.95), (0.25, 1.0, 1.0)] {
            let found = touch(&ball(), centre, &[fin(-apart), fin(apart)]);
            assert_eq!(found.len(), 2, "{found:?}");
            for c in &found {
                assert!(matches!(c.feature, Feature::Edge(_)));
                assert!((least..=most).contains(&c.share.value), "{found:?}");
            }
            let [one, other] = [found[0].share.value, found[1].share.value];
            assert!((one - other).abs() < 1e-9, "{found:?}");
        }
        for side in [-1.0, 1.0] {
            let floor = [
                Vector3::new(-0.02 * side, -9.0, 0.0),
                Vector3::new(-0.02 * side, 9.0, 0.0),
                Vector3::new(9.0 * side, 0.0, 0.0),
            ];
            let found = touch(&ball(), centre, &[fin(-0.08 * side), floor]);
            assert_eq!(found.len(), 2, "{found:?}");
            assert_eq!(found[0].feature, Feature::Face);
            assert!(matches!(found[1].feature, Feature::Edge(_)));
            let shares = [found[0].share.value, found[1].share.value];
            assert!(shares.iter().all(|share| *share < 0.97), "{shares:?}");
            assert!((1.0..1.5).contains(&(shares[0] + shares[1])), "{shares:?}");
        }
    }

    /// Two faces of a valley, whose planes cut each other's contacts, with a gap between them and without.
    #[test]
    fn faces_that_do_not_meet_do_not_cut_each_other() {
        let rise = 0.1;
        let valley = |gap: f64| {
            let side = |sign: f64| {
                // Across the axes of the world, so that the boxes of both sides overlap.
                let at = |x: f64, y: f64| {
                    Vector3::new(0.8 * sign * x - 0.6 * y, 0.6 * sign * x + 0.8 * y, rise * x)
                };
                [at(gap, -9.0), at(gap, 9.0), at(9.0, 0.0)]
            };
            [side(-1.0), side(1.0)]
        };
        let centre = Vector3::new(0.0, 0.0, 0.96 * (1.0 + rise * rise).sqrt());
        for (gap, share) in [(0.0, 0.5), (1e-3, 1.0)] {
            let found = touch(&ball(), centre, &valley(gap));
            assert_eq!(found.len(), 2, "{found:?}");
            for c in &found {
                assert_eq!(c.feature, Feature::Face);
                assert!((c.penetration - 0.04).abs() < 1e-12);
                let is_cut = c.share.value < 0.95;
                assert_eq!(is_cut, share < 1.0, "{gap}: {found:?}");
            }
        }
    }

    /// Uneven sheets with straight edges, axes that are rounded in another way: the same force up to an overlap of 0.4 of the smallest semi-axis.
    /// Of a body whose centre is nearly at the surface rounding decides which faces are hidden by others.
    #[test]
    fn rounding_of_the_axes_changes_no_force() {
        let mut random = Random::new(77);
        for (cells, height, waves) in [
            (24, 0.15, [1.3, 1.0]),
            (12, 0.3, [1.0, 1.0]),
            (40, 0.1, [2.0, 2.3]),
        ] {
            let surface = |x: f64, y: f64| height * (waves[0] * x).sin() * (waves[1] * y).cos();
            let all: Vec<Triangle> = sheet(cells, 4.2)
                .iter()
                .map(|t| t.map(|p| Vector3::new(p.x, p.y, surface(p.x, p.y))))
                .collect();
            let mut touching = 0;
            for k in 0..150 {
                let depth = [0.02, 0.1, 0.4][k % 3];
                let semi_axes = [0; 3].map(|_| random.uniform(0.3, 1.0));
                let quaternion = random.quaternion();
                let body = Ellipsoid::new(semi_axes, quaternion).unwrap();
                let (x, y) = (random.uniform(-2.5, 2.5), random.uniform(-2.5, 2.5));
                let low = body.support(Vector3::new(0.0, 0.0, -1.0));
                let z = surface(x, y) + low.h - depth * body.smallest_semi_axis();
                let centre = Vector3::new(x - low.point.x, y - low.point.y, z);
                let force = |n: usize| {
                    let mut quaternion = quaternion;
                    quaternion[n % 4] *= 1.0 + 1e-15 * (n as f64 - 2.0);
                    let body = Ellipsoid::new(semi_axes, quaternion).unwrap();
                    let contacts = touch(&body, centre, &all);
                    contacts.iter().fold(Vector3::ZERO, |sum, c| {
                        sum + c.normal * (c.share.value * c.penetration.powf(1.5))
                    })
                };
                let first = force(2);
                touching += usize::from(first.norm() > 0.0);
                for n in [0, 1, 3, 4, 5] {
                    let apart = (force(n) - first).norm();
                    assert!(
                        apart <= 1e-9 * first.norm(),
                        "{apart:e} of {first:?}: {body:?} {centre:?}"
                    );
                }
            }
            assert!(touching > 100, "{touching}");
        }
    }

    /// Where a narrow face comes within reach the plane of another acts by two parts, in one contact.
    #[test]
    fn a_plane_acts_once_where_a_narrow_face_is_near() {
        let fall = 8f64.to_radians();
        let (sin, cos) = fall.sin_cos();
        let profile = [
            [-9.0 * cos, -9.0 * sin],
            [0.0, 0.0],
            [0.02, 0.0],
            [1.02, 0.15],
        ];
        let wall: Vec<Triangle> = profile
            .windows(2)
            .flat_map(|pair| {
                let at = |[x, z]: [f64; 2], y: f64| Vector3::new(x, y, z);
                let (a, b) = (at(pair[0], -6.0), at(pair[1], -6.0));
                let (c, d) = (at(pair[1], 6.0), at(pair[0], 6.0));
                [[a, b, c], [a, c, d]]
            })
            .collect();
        let normal = Vector3::new(-sin, 0.0, cos);
        let foot = Vector3::new(-0.2 * cos, 0.3, -0.2 * sin);
        let centre = foot + normal * 0.99;
        let mut search = TriangleSearch::default();
        search.touch(&ball(), centre, &wall);
        let meeting = MEETING;
        let widths = flat_pieces::widths(&wall);
        let rest = (search.fine).rest(&search.places, &ball(), meeting, &|k| widths[k]);
        assert!(rest.value > 0.1 && rest.value < 0.9, "{rest:?}");
        let [found] = search.contacts() else {
            panic!("{:?}", search.contacts());
        };
        assert!((found.share.value - 1.0).abs() < 1e-12, "{found:?}");
        assert!((found.penetration - 0.01).abs() < 1e-12 && (found.normal - normal).norm() < 1e-12);
    }
}
