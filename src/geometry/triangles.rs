// SPDX-License-Identifier: MIT OR Apache-2.0
//! An ellipsoid and a surface of triangles.
//!
//! The surface acts where its distance from the body's deepest reach is a minimum: on a face, if the deepest point lies
//! over it; on an edge or a corner, if the normal there points away from all triangles that meet at the point. Which
//! triangles meet is a question of place, not of shared corners: a triangle that passes within `MEETING` of a point
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
//! share, and a face beyond a fold ends at the line of its convex edges.
//!
//! What is not continuous: where several such corners lie within one overlap, of which more than `MOST_MIXED` act as faces and edges alone, and by a few per cent
//! where an obtuse face's corner comes into reach. An edge that shares the overlap with something else is taken to hold its normal in
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

use super::box_tree::{BoxTree, Extent};
use super::convex_corner::{self, Support as CornerSupport};
use super::ellipsoid::{Ellipsoid, Support};
use super::facet_shares::{share, Section, Share, ShareMemory, SupportingPlane};
use super::interior_point::nearest_normal;
use super::nearest_line::nearest_across;
use crate::vector::{Tangent, Vector2, Vector3};

/// Three corners.
pub type Triangle = [Vector3; 3];

/// Which part of a triangle touches.
#[derive(Clone, Copy, Debug, PartialEq)]
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
#[derive(Clone, Debug, Default)]
pub struct TriangleSearch {
    contacts: Vec<TriangleContact>,
    near: Vec<Near>,
    boxes: Vec<Extent>,
    tree: BoxTree,
    /// For each of `near` the candidate of its plane, `NOTHING` without one.
    of_plane: Vec<usize>,
    candidates: Vec<Candidate>,
    sections: Vec<Section>,
    /// A candidate and another that cuts its contact.
    cuts: Vec<[usize; 2]>,
    corner: CornerMemory,
    memory: ShareMemory,
}

/// How far around the body triangles are looked at, in its size: where a corner at which convex and concave edges meet comes within,
/// it acts by its convex pieces, and it should do so before it matters.
pub(crate) const REACH: f64 = 1.02;

/// Corners at which convex and concave edges meet, within reach of one body, at most: of a curved surface of many small triangles the
/// pieces of more would reach far beyond their places.
const MOST_MIXED: usize = 3;

/// Sine of an angle that is taken as zero: far above the rounding of a normal from corners, far below an angle of a real mesh.
const TOLERANCE: f64 = 1e-9;

/// Triangles meet where they are closer than this share of the smallest semi-axis: smaller gaps, steps and slivers are
/// taken as flaws of the mesh. Above the rounding of single precision (6e-8 of a coordinate) for meshes up to a hundred
/// times as large as the semi-axis.
pub(super) const MEETING: f64 = 1e-5;

/// Sine of the angle between two faces below which they are taken as one plane. Corners in single precision, as in binary
/// STL files, turn the normal of a triangle by more: such faces are folds, at which the shares of both faces make the force
/// continuous.
const SAME_PLANE: f64 = 1e-8;

/// Cosine of 3 degrees. An edge or a corner whose normal differs by less from that of another contact at the same place is
/// taken as that contact, so that neighbouring triangles do not act twice. A compromise between flaws of meshes and real edges: a
/// corner that is off by a twentieth of an edge turns a normal by as much, and the force of a contact that is left out would have had at most
/// 5 %, the sine, in another direction.
const SAME_NORMAL: f64 = 0.998_629_534_754_573_9;

/// How far towards the middle of a triangle the place is that must be seen from the body's centre where the triangle acts, in distances
/// at which triangles meet: clear of what meets it at its border, and still near.
pub(super) const INSIDE: f64 = 100.0;

/// Triangles of one plane that are looked at each beside each other, at most.
const MOST_JOINED: usize = 32;

/// No index.
const NOTHING: usize = usize::MAX;

/// A triangle that may touch, with the body's centre as the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    index: usize,
    pub(super) corners: Triangle,
    /// Towards the body's centre.
    pub(super) normal: Vector3,
    /// Distance of the centre from its plane.
    pub(super) distance: f64,
    /// Another triangle of the same plane, on the way to the one that stands for all that continue one another in it.
    plane: usize,
}

/// Memory for a corner at which triangles meet.
#[derive(Clone, Debug, Default)]
struct CornerMemory {
    /// Which of `near` meet there.
    meeting: Vec<usize>,
    bounds: Vec<Bound>,
    pieces: Vec<Piece>,
    /// Those of one piece: which bounds, and their normals out of it.
    members: Vec<usize>,
    normals: Vec<Vector3>,
}

/// A plane of triangles that meet at a corner.
#[derive(Clone, Copy, Debug)]
struct Bound {
    normal: Vector3,
    /// Which of `near`'s planes it is.
    plane: usize,
}

/// A convex part of what lies behind the triangles that meet at a corner.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// Which bounds, and which of them with the normal turned.
    bounds: u64,
    turned: u64,
    /// One of `near` on it.
    near: usize,
}

/// A plane that supports the body.
#[derive(Clone, Copy, Debug)]
struct Candidate {
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
}

impl TriangleSearch {
    /// The contacts of the last call of [`TriangleSearch::touch`], deepest first.
    pub fn contacts(&self) -> &[TriangleContact] {
        &self.contacts
    }

    /// Finds the contacts of a body with centre `centre`. The triangles are all those near the body: an edge at which one is
    /// missing counts as a free edge. A triangle with a corner that is not finite is left out.
    pub fn touch(&mut self, body: &Ellipsoid, centre: Vector3, triangles: &[Triangle]) {
        self.contacts.clear();
        self.candidates.clear();
        let meeting = MEETING * body.smallest_semi_axis();
        self.gather(body, centre, triangles, meeting);
        if self.near.is_empty() {
            return;
        }
        if let Some(mut alone) = self.lone_face(body, meeting) {
            alone.point = alone.point + centre;
            self.contacts.push(alone);
        } else if (self.near.iter()).any(|t| body.support(-t.normal).h > t.distance) {
            self.all_contacts(body, centre, meeting);
        }
    }

    /// The contacts with the triangles that are near.
    fn all_contacts(&mut self, body: &Ellipsoid, centre: Vector3, meeting: f64) {
        self.tree.build(&self.boxes);
        self.join_planes(body.bounding_radius(), meeting);
        self.faces(body, meeting);
        for k in 0..self.near.len() {
            self.edges(body, k, meeting);
            self.corners(body, k, meeting);
        }
        self.mixed_corners(body, meeting);
        self.keep_one_of_each(meeting);
        self.find_cuts(body, meeting);
        let mut cuts = &self.cuts[..];
        for (k, c) in self.candidates.iter().enumerate() {
            let (own, rest) = cuts.split_at(cuts.partition_point(|cut| cut[0] == k));
            cuts = rest;
            let others = own.iter().map(|cut| &self.sections[cut[1]]);
            let share = share(body, &self.sections[k], others, &mut self.memory);
            if share.value > 0.0 {
                self.contacts.push(TriangleContact {
                    point: centre + c.foot,
                    normal: c.plane.normal,
                    penetration: c.penetration,
                    triangle: c.triangle,
                    feature: c.feature,
                    share,
                });
            }
        }
        self.contacts.sort_unstable_by(|a, b| {
            b.penetration
                .total_cmp(&a.penetration)
                .then(a.triangle.cmp(&b.triangle))
        });
    }

    /// The triangles within the body's reach along the world axes and in the ball around it, without slivers. The box of a long triangle
    /// across the axes holds much that is far from the triangle.
    fn gather(&mut self, body: &Ellipsoid, centre: Vector3, all: &[Triangle], meeting: f64) {
        self.near.clear();
        self.boxes.clear();
        let reach = [
            Vector3::new(1.0, 0.0, 0.0),
            Vector3::new(0.0, 1.0, 0.0),
            Vector3::new(0.0, 0.0, 1.0),
        ]
        .map(|e| REACH * body.support(e).h + meeting);
        let own = Extent {
            low: reach.map(|x| -x),
            high: reach,
        };
        // No search looks at a place farther away: deepest points are in the ball, and what hides them is before them.
        let ball = REACH * body.bounding_radius() + 2.0 * INSIDE * meeting;
        for (index, t) in all.iter().enumerate() {
            let corners = t.map(|p| p - centre);
            let axes = corners.map(|p| p.to_array());
            let extent = Extent {
                low: core::array::from_fn(|k| axes.iter().fold(f64::INFINITY, |m, p| m.min(p[k]))),
                high: core::array::from_fn(|k| {
                    axes.iter().fold(f64::NEG_INFINITY, |m, p| m.max(p[k]))
                }),
            };
            if !extent.overlaps(&own) {
                continue;
            }
            let (across, longest) = across(&corners);
            let height = across.dot(corners[0]);
            if height * height > ball * ball * across.norm_squared() {
                continue;
            }
            let Some(unplaced) = Near::with_normal(index, corners, (across, longest), meeting)
            else {
                continue;
            };
            let triangle = Near {
                plane: self.near.len(),
                ..unplaced
            };
            if triangle.has(Vector3::ZERO, ball) {
                self.near.push(triangle);
                self.boxes.push(extent);
            }
        }
    }

    /// The one contact, its point from the body's centre, where all triangles near the body are of one plane and the body is within the
    /// borders of one of them, or of several that continue one another: the quick way to what the others find there.
    fn lone_face(&self, body: &Ellipsoid, meeting: f64) -> Option<TriangleContact> {
        let (first, others) = self.near.split_first()?;
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
        if let Some(found) = self.near.iter().find_map(in_one) {
            return Some(found);
        }
        if others.is_empty() || self.near.len() > MOST_JOINED || !self.is_joined_in(body) {
            return None;
        }
        self.near.iter().find_map(|t| {
            contact(t, &|support, foot| {
                let middle = support.point * (t.distance * support.inverse_h);
                // Both places are in the section, which has no border: so all of it is covered, and the foot continues what is reached.
                let unit = body.inverse_semi_axes.componentwise(body.to_body(foot));
                unit.norm_squared() <= 1.0
                    && t.has(foot, meeting)
                    && self.near.iter().any(|q| q.has(middle, meeting))
            })
        })
    }

    /// Whether each edge that comes into the body belongs to two triangles: then they have no border there.
    fn is_joined_in(&self, body: &Ellipsoid) -> bool {
        let is_shared =
            |t: &Near, a: Vector3, b: Vector3| self.near.iter().any(|q| t.is_continued_by(q, a, b));
        self.near.iter().all(|t| {
            let unit = t
                .corners
                .map(|p| body.inverse_semi_axes.componentwise(body.to_body(p)));
            (0..3).all(|m| {
                let next = (m + 1) % 3;
                !is_within_reach(unit[m], unit[next]) || is_shared(t, t.corners[m], t.corners[next])
            })
        })
    }

    /// Joins triangles that continue one another in one plane.
    fn join_planes(&mut self, largest: f64, meeting: f64) {
        let TriangleSearch {
            near, boxes, tree, ..
        } = self;
        for k in 0..near.len() {
            tree.visit(boxes, &boxes[k].wider(meeting), |other| {
                if other < k && near[k].is_in_plane_of(&near[other], largest, SAME_PLANE) {
                    let (a, b) = (first_of(near, k), first_of(near, other));
                    near[a.max(b)].plane = a.min(b);
                }
                true
            });
        }
        for k in 0..near.len() {
            near[k].plane = first_of(near, k);
        }
    }

    /// The planes of faces on which the body lies, or on a part of which it lies beyond a fold.
    fn faces(&mut self, body: &Ellipsoid, meeting: f64) {
        self.of_plane.clear();
        self.of_plane.resize(self.near.len(), NOTHING);
        for k in 0..self.near.len() {
            let t = &self.near[k];
            let known = self.of_plane[t.plane];
            if known != NOTHING && self.candidates[known].over {
                continue;
            }
            let normal = t.normal;
            let support = body.support(-normal);
            let penetration = support.h - t.distance;
            if !(penetration > 0.0) {
                continue;
            }
            let foot = support.point + normal * penetration;
            let over = self.boxes[k].overlaps(&Extent::about(foot.to_array(), meeting))
                && t.has(foot, meeting);
            let point = if over {
                let reaches = |q: &Near| q.is_in_section(body, &support, penetration);
                let reached =
                    reaches(t) || self.near.iter().any(|q| q.plane == t.plane && reaches(q));
                if !reached || self.is_hidden(k, foot, meeting) {
                    continue;
                }
                foot
            } else {
                if known != NOTHING || !t.is_in_section(body, &support, penetration) {
                    continue;
                }
                let point = t.nearest_to(body, &support, foot);
                if !self.folds_up(k, point, meeting) || self.is_hidden(k, point, meeting) {
                    continue;
                }
                point
            };
            let candidate = Candidate {
                plane: SupportingPlane { point, normal },
                foot,
                penetration,
                triangle: t.index,
                feature: Feature::Face,
                over,
                near: k,
            };
            if known == NOTHING {
                self.of_plane[t.plane] = self.candidates.len();
                self.candidates.push(candidate);
            } else {
                self.candidates[known] = candidate;
            }
        }
    }

    /// Whether another triangle rises from the plane of this one at a point of its border, on the side of the body.
    fn folds_up(&self, own: usize, point: Vector3, meeting: f64) -> bool {
        let t = &self.near[own];
        let above = |normal: Vector3, corners: &Triangle| {
            corners.iter().any(|z| {
                let way = *z - point;
                normal.dot(way) > TOLERANCE * way.norm() + f64::MIN_POSITIVE
            })
        };
        let nowhere_below = |normal: Vector3, corners: &Triangle| {
            corners.iter().all(|z| {
                let way = *z - point;
                normal.dot(way) >= -(TOLERANCE * way.norm() + meeting)
            })
        };
        let mut rises = false;
        let place = Extent::about(point.to_array(), meeting);
        self.tree.visit(&self.boxes, &place, |k| {
            let q = &self.near[k];
            rises = k != own
                && above(t.normal, &q.corners)
                && above(q.normal, &t.corners)
                && nowhere_below(q.normal, &t.corners)
                && q.has(point, meeting);
            !rises
        });
        rises
    }

    /// Whether another triangle comes between the body's centre and a point of this one, all of which lies behind it. So the faces
    /// of a block, seen from within, do not act on a body that lies across its edges.
    fn is_hidden(&self, own: usize, point: Vector3, meeting: f64) -> bool {
        let t = &self.near[own];
        let inwards = combine(&t.corners, [1.0 / 3.0; 3]) - point;
        let seen = point + inwards * (INSIDE * meeting / inwards.norm()).min(1.0);
        let way = Extent {
            low: seen.to_array().map(|x| x.min(0.0)),
            high: seen.to_array().map(|x| x.max(0.0)),
        };
        let mut hidden = false;
        self.tree.visit(&self.boxes, &way, |k| {
            hidden = k != own && self.near[k].stands_before(t, seen, meeting);
            !hidden
        });
        hidden
    }

    /// Whether a normal at a point points away from all triangles that meet there.
    fn is_outermost(&self, normal: Vector3, point: Vector3, meeting: f64) -> bool {
        let mut outermost = true;
        let place = Extent::about(point.to_array(), meeting);
        self.tree.visit(&self.boxes, &place, |k| {
            let q = &self.near[k];
            let away = q.corners.iter().all(|z| {
                let way = *z - point;
                normal.dot(way) <= TOLERANCE * way.norm()
            });
            outermost = away || !q.has(point, meeting);
            outermost
        });
        outermost
    }

    fn edges(&mut self, body: &Ellipsoid, k: usize, meeting: f64) {
        let t = self.near[k];
        let unit = t
            .corners
            .map(|p| body.inverse_semi_axes.componentwise(body.to_body(p)));
        for m in 0..3 {
            let (a, b, c) = (t.corners[m], t.corners[(m + 1) % 3], t.corners[(m + 2) % 3]);
            if !is_within_reach(unit[m], unit[(m + 1) % 3]) || self.is_within_plane(k, a, b) {
                continue;
            }
            let length = (b - a).norm();
            let along = (b - a) * (1.0 / length);
            let Some(n) = nearest_across(body, a, along) else {
                continue;
            };
            let normal = -n;
            if normal.dot(c - a) > TOLERANCE * (c - a).norm() {
                continue;
            }
            let support = body.support(n);
            let penetration = support.h - n.dot(a);
            if !(penetration > 0.0) {
                continue;
            }
            let place = along.dot(support.point - a);
            if place < -meeting || place > length + meeting {
                continue;
            }
            let point = a + along * place;
            if self.is_outermost(normal, point, meeting) {
                self.add_point(normal, point, penetration, Feature::Edge(along), k);
            }
        }
    }

    /// Whether another triangle of the same plane continues this one beyond an edge: that is none.
    fn is_within_plane(&self, own: usize, a: Vector3, b: Vector3) -> bool {
        let t = &self.near[own];
        let mut is_within = false;
        let place = Extent::about(((a + b) * 0.5).to_array(), 0.0);
        self.tree.visit(&self.boxes, &place, |k| {
            let q = &self.near[k];
            is_within = q.plane == t.plane && t.is_continued_by(q, a, b);
            !is_within
        });
        is_within
    }

    fn corners(&mut self, body: &Ellipsoid, k: usize, meeting: f64) {
        let t = self.near[k];
        for corner in t.corners {
            let local = body.to_body(corner).to_array();
            let Some(n) = nearest_normal(body.semi_axes.to_array(), local) else {
                continue;
            };
            let n = body.to_world(Vector3::from_array(n)).normalised();
            let normal = -n;
            let away = t.corners.iter().all(|z| {
                let way = *z - corner;
                normal.dot(way) <= TOLERANCE * way.norm()
            });
            if !away {
                continue;
            }
            let penetration = body.support(n).h - n.dot(corner);
            if penetration > 0.0 && self.is_outermost(normal, corner, meeting) {
                self.add_point(normal, corner, penetration, Feature::Corner, k);
            }
        }
    }

    /// The corners at which convex edges meet concave ones. What lies behind the triangles there is the union of convex pieces, each
    /// the part behind the planes of one triangle and of all that it lies behind; and the body's support by each piece is continuous
    /// as it moves. So are the shares of the supports, whichever the pieces are.
    fn mixed_corners(&mut self, body: &Ellipsoid, meeting: f64) {
        let mut memory = core::mem::take(&mut self.corner);
        let mut found = [(0, Vector3::ZERO); MOST_MIXED];
        let mut count = 0;
        for k in 0..self.near.len() {
            for apex in self.near[k].corners {
                let unit = body.inverse_semi_axes.componentwise(body.to_body(apex));
                if unit.norm_squared() < REACH * REACH
                    && self.gather_corner(k, apex, meeting, &mut memory)
                {
                    if count == MOST_MIXED {
                        self.corner = memory;
                        return;
                    }
                    found[count] = (k, apex);
                    count += 1;
                }
            }
        }
        for &(k, apex) in &found[..count] {
            if self.gather_corner(k, apex, meeting, &mut memory) {
                self.act_at_corner(body, apex, &mut memory);
            }
        }
        self.corner = memory;
    }

    /// Finds the convex pieces at a corner; false if there is no more to it than the triangles' own faces, edges and corners say, or
    /// if an earlier triangle has this corner as well.
    fn gather_corner(
        &self,
        own: usize,
        apex: Vector3,
        meeting: f64,
        memory: &mut CornerMemory,
    ) -> bool {
        let CornerMemory {
            meeting: all,
            bounds,
            pieces,
            ..
        } = memory;
        all.clear();
        bounds.clear();
        pieces.clear();
        let mut is_first = true;
        let place = Extent::about(apex.to_array(), meeting);
        self.tree.visit(&self.boxes, &place, |k| {
            let q = &self.near[k];
            is_first = k >= own || !q.corners.contains(&apex);
            if is_first && q.has(apex, meeting) {
                all.push(k);
            }
            is_first
        });
        if !is_first {
            return false;
        }
        all.sort_unstable();
        for &k in all.iter() {
            let t = &self.near[k];
            if bounds.iter().all(|b| b.plane != t.plane) {
                bounds.push(Bound {
                    normal: t.normal,
                    plane: t.plane,
                });
            }
        }
        if bounds.len() < 2 || bounds.len() > 64 {
            return false;
        }
        for &k in all.iter() {
            let t = &self.near[k];
            if self.is_hidden(k, apex, meeting) {
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
                        .map(|q| &self.near[*q])
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
            let (t, q) = (&self.near[p.near], &self.near[q.near]);
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

    /// Puts the supports of a corner's convex pieces in the place of what the triangles' planes say.
    fn act_at_corner(&mut self, body: &Ellipsoid, apex: Vector3, memory: &mut CornerMemory) {
        let CornerMemory {
            meeting: all,
            bounds,
            pieces,
            members,
            normals,
        } = memory;
        // the planes that act, by bound
        let mut acting = 0u64;
        for piece in pieces.iter() {
            normals.clear();
            members.clear();
            members.extend((0..bounds.len()).filter(|m| piece.bounds >> m & 1 == 1));
            normals.extend(members.iter().map(|&m| {
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
                CornerSupport::Plane(m) => acting |= 1 << members[m],
                CornerSupport::Line {
                    along,
                    normal,
                    foot,
                } => {
                    let penetration = body.support(normal).h - normal.dot(apex);
                    // beyond the other end of the triangles' own edge it is for the corner there to say
                    let way = foot - apex;
                    let is_beyond = all.iter().any(|&q| {
                        self.near[q].corners.iter().any(|z| {
                            let side = *z - apex;
                            let ahead = side.dot(way);
                            side.cross(along).norm() <= TOLERANCE * side.norm()
                                && ahead > 0.0
                                && ahead >= side.norm_squared()
                        })
                    });
                    if !is_beyond {
                        self.candidates.push(Candidate {
                            plane: SupportingPlane {
                                point: foot,
                                normal: -normal,
                            },
                            foot,
                            penetration,
                            triangle: self.near[piece.near].index,
                            feature: Feature::Edge(along),
                            over: true,
                            near: piece.near,
                        });
                    }
                }
                CornerSupport::Apex { normal } => {
                    let penetration = body.support(normal).h - normal.dot(apex);
                    self.add_point(-normal, apex, penetration, Feature::Corner, piece.near);
                }
            }
        }
        for (m, bound) in bounds.iter().enumerate() {
            let known = self.of_plane[bound.plane];
            if acting >> m & 1 == 0 {
                if known != NOTHING && !self.candidates[known].over {
                    self.candidates[known].triangle = NOTHING;
                }
            } else if known == NOTHING {
                let Some(&k) = all.iter().find(|&&k| self.near[k].plane == bound.plane) else {
                    continue;
                };
                let t = &self.near[k];
                let support = body.support(-t.normal);
                let penetration = support.h - t.distance;
                let foot = support.point + t.normal * penetration;
                self.of_plane[bound.plane] = self.candidates.len();
                self.candidates.push(Candidate {
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
    ) {
        self.candidates.push(Candidate {
            plane: SupportingPlane { point, normal },
            foot: point,
            penetration,
            triangle: self.near[near].index,
            feature,
            over: true,
            near,
        });
    }

    /// Leaves one of several candidates for one contact: an edge or a corner beneath the deepest point of a face, or two that
    /// triangles have in common.
    fn keep_one_of_each(&mut self, meeting: f64) {
        let is_whole = |c: &Candidate| c.feature == Feature::Face && c.triangle != NOTHING;
        if self.candidates.iter().all(is_whole) {
            return;
        }
        let reach = 3.0 * meeting;
        self.candidates
            .sort_unstable_by(|a, b| a.foot.x.total_cmp(&b.foot.x).then(a.order(b)));
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
                    let loser = if c.order(&d).is_lt() { other } else { k };
                    self.candidates[loser].triangle = NOTHING;
                }
            }
        }
        self.candidates.retain(|c| c.triangle != NOTHING);
        self.of_plane.fill(NOTHING);
        for (k, c) in self.candidates.iter().enumerate() {
            if c.feature == Feature::Face {
                self.of_plane[self.near[c.near].plane] = k;
            }
        }
    }

    /// Which candidates cut each other's contacts: faces that meet, and edges and corners with everything.
    fn find_cuts(&mut self, body: &Ellipsoid, meeting: f64) {
        let TriangleSearch {
            near,
            boxes,
            tree,
            of_plane,
            candidates,
            sections,
            cuts,
            ..
        } = self;
        sections.clear();
        sections.extend(candidates.iter().map(|c| Section::new(body, &c.plane)));
        cuts.clear();
        let mut cut = |c: usize, d: usize, meet: &dyn Fn() -> bool| {
            let [one, other] = [[c, d], [d, c]].map(|[c, d]| sections[c].is_cut_by(&sections[d]));
            if (one || other) && meet() {
                cuts.extend(one.then_some([c, d]));
                cuts.extend(other.then_some([d, c]));
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
        cuts.sort_unstable();
        cuts.dedup();
    }
}

/// The triangle that stands for all that continue one another in the plane of this one.
fn first_of(near: &mut [Near], mut k: usize) -> usize {
    while near[k].plane != k {
        let next = near[near[k].plane].plane;
        near[k].plane = next;
        k = next;
    }
    k
}

/// Whether a triangle comes before a plane through a point of it, and behind it.
fn sides(normal: Vector3, point: Vector3, corners: &Triangle) -> [bool; 2] {
    let mut found = [false; 2];
    for z in corners {
        let way = *z - point;
        let height = normal.dot(way);
        let least = TOLERANCE * way.norm() + f64::MIN_POSITIVE;
        found[0] |= height > least;
        found[1] |= height < -least;
    }
    found
}

/// Whether a way between two points, in the frame in which the body is the unit sphere, comes into the body or close to it.
fn is_within_reach(a: Vector3, b: Vector3) -> bool {
    let way = b - a;
    let length = way.norm_squared();
    let place = if length > 0.0 {
        (-a.dot(way) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (a + way * place).norm_squared() < 1.0 + 1e-3
}

impl Candidate {
    /// Which of two candidates for one contact stands for it: the smaller.
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

/// A vector across a triangle, as long as twice its area, and the square of its longest side.
#[inline(always)]
fn across(corners: &Triangle) -> (Vector3, f64) {
    let sides: [Vector3; 3] = core::array::from_fn(|k| corners[(k + 1) % 3] - corners[k]);
    // The two shorter sides: of a long triangle the third has lost digits.
    let lengths = sides.map(|e| e.norm_squared());
    let longest = (0..3).fold(0, |m, k| if lengths[k] > lengths[m] { k } else { m });
    let across = sides[(longest + 1) % 3].cross(sides[(longest + 2) % 3]);
    (across, lengths[longest])
}

/// Whether the plane of a triangle comes into a ball; true of one that has no plane.
pub(crate) fn plane_comes_into(triangle: &Triangle, centre: Vector3, radius: f64) -> bool {
    let corners = triangle.map(|p| p - centre);
    let (across, _) = across(&corners);
    let height = across.dot(corners[0]);
    !(height * height > radius * radius * across.norm_squared())
}

impl Near {
    /// A triangle, seen from `centre`; `None` for one that is narrower than `meeting`, or not finite.
    pub(super) fn new(
        index: usize,
        triangle: &Triangle,
        centre: Vector3,
        meeting: f64,
    ) -> Option<Near> {
        let corners = triangle.map(|p| p - centre);
        Near::with_normal(index, corners, across(&corners), meeting)
    }

    /// The same of corners from the centre, and what [`across`] says of them.
    #[inline(always)]
    fn with_normal(
        index: usize,
        corners: Triangle,
        (across, longest): (Vector3, f64),
        meeting: f64,
    ) -> Option<Near> {
        let twice_area = across.norm_squared().sqrt();
        if !(twice_area > meeting * longest.sqrt() && twice_area.is_finite()) {
            return None;
        }
        let mut normal = across * (1.0 / twice_area);
        let nearest = (0..3).fold(0, |m, k| {
            let closer = corners[k].norm_squared() < corners[m].norm_squared();
            if closer {
                k
            } else {
                m
            }
        });
        let mut distance = -normal.dot(corners[nearest]);
        if distance < 0.0 {
            (normal, distance) = (-normal, -distance);
        }
        Some(Near {
            index,
            corners,
            normal,
            distance,
            plane: 0,
        })
    }

    /// Whether another triangle has the edge between these two corners of this one too, and lies beyond it.
    pub(super) fn is_continued_by(&self, other: &Near, a: Vector3, b: Vector3) -> bool {
        let third = |t: &Near| t.corners.into_iter().find(|p| *p != a && *p != b);
        let across = (b - a).cross(self.normal);
        let side = |p: Vector3| across.dot(p - a);
        let has = |p: Vector3| other.corners.contains(&p);
        has(a)
            && has(b)
            && third(self)
                .zip(third(other))
                .is_some_and(|(p, q)| side(p) * side(q) < 0.0)
    }

    /// Whether the triangle passes within `margin` of a point.
    pub(super) fn has(&self, p: Vector3, margin: f64) -> bool {
        let tangent = Tangent::new(self.normal);
        let place = self.corners.map(|c| tangent.components(c - p));
        let nearest = combine(&self.corners, nearest_to_origin(place));
        (nearest - p).norm_squared() <= margin * margin
    }

    /// Whether the way from the body's centre to a point of another triangle passes through this one, and that other lies behind
    /// this one's plane as a whole. A larger one, on which this one stands, goes on in front of it.
    fn stands_before(&self, other: &Near, seen: Vector3, meeting: f64) -> bool {
        let height = |p: Vector3| self.normal.dot(p) + self.distance;
        let depth = -height(seen);
        depth > TOLERANCE * seen.norm()
            && other.corners.iter().all(|&p| height(p) <= meeting)
            && self.has(seen * (self.distance / (self.distance + depth)), meeting)
    }

    /// Whether two triangles that meet are of one plane, up to an angle of this sine.
    pub(super) fn is_in_plane_of(&self, other: &Near, largest: f64, sine: f64) -> bool {
        (self.normal - other.normal).norm_squared() <= sine * sine
            && self.corners.iter().any(|p| {
                let height = other.normal.dot(*p) + other.distance;
                height.abs() <= 1e-12 * largest
            })
    }

    /// Whether the body's deepest point and all of the plane's section with it are within the borders of the triangle, by more than
    /// `meeting`.
    fn borders_are_clear(
        &self,
        body: &Ellipsoid,
        support: &Support,
        foot: Vector3,
        meeting: f64,
    ) -> bool {
        // The middle of the section, and the square by which it is smaller than that through the body's centre.
        let shrink = self.distance * support.inverse_h;
        let middle = support.point * shrink;
        let size = 1.0 - shrink * shrink;
        (0..3).all(|k| {
            let (from, to, across) = (
                self.corners[k],
                self.corners[(k + 1) % 3],
                self.corners[(k + 2) % 3],
            );
            let Some(mut out) = (to - from).cross(self.normal).direction() else {
                return false;
            };
            if out.dot(across - from) > 0.0 {
                out = -out;
            }
            let scaled = body.semi_axes.componentwise(body.to_body(out));
            let along = out.dot(support.point);
            let square = size * (scaled.norm_squared() - along * along);
            let room = out.dot(from) - meeting;
            room > out.dot(foot) && room > out.dot(middle) + square.max(0.0).sqrt()
        })
    }

    /// Whether a part of the triangle is in the body.
    fn is_in_section(&self, body: &Ellipsoid, support: &Support, penetration: f64) -> bool {
        let below = penetration * support.inverse_h;
        let (_, nearest) = self.nearest(body, support, Vector3::ZERO);
        nearest.dot(nearest) < below * (2.0 - below)
    }

    /// The point of the triangle nearest to a point of its plane in the measure of the plane's section with the body.
    fn nearest_to(&self, body: &Ellipsoid, support: &Support, foot: Vector3) -> Vector3 {
        combine(&self.corners, self.nearest(body, support, foot).0)
    }

    /// The weights of that point, and its place from `middle` where the body is the unit sphere, along the plane.
    fn nearest(&self, body: &Ellipsoid, support: &Support, middle: Vector3) -> ([f64; 3], Vector2) {
        let m = body.semi_axes.componentwise(support.local_normal) * support.inverse_h;
        let frame = Tangent::new(m);
        let place = self.corners.map(|p| {
            let unit = body.to_body(p - middle);
            frame.components(body.inverse_semi_axes.componentwise(unit))
        });
        let weights = nearest_to_origin(place);
        let nearest = place[0] * weights[0] + place[1] * weights[1] + place[2] * weights[2];
        (weights, nearest)
    }

    /// Whether two triangles come within `margin` of each other: at a corner of one, or where a side of one passes through the
    /// other.
    fn meets(&self, other: &Near, margin: f64) -> bool {
        let touches = |t: &Near, q: &Near| {
            let heights = q.corners.map(|p| t.normal.dot(p) + t.distance);
            (0..3).any(|k| {
                if heights[k].abs() <= margin && t.has(q.corners[k], margin) {
                    return true;
                }
                let next = (k + 1) % 3;
                if heights[k] * heights[next] >= 0.0 {
                    return false;
                }
                let place = heights[k] / (heights[k] - heights[next]);
                t.has(
                    q.corners[k] + (q.corners[next] - q.corners[k]) * place,
                    margin,
                )
            })
        };
        touches(self, other) || touches(other, self)
    }
}

fn combine(corners: &Triangle, weights: [f64; 3]) -> Vector3 {
    corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2]
}

/// Barycentric coordinates of a point in the plane of a triangle: the weights of the corners of which it is the mean. A third each
/// where the corners are on a line.
pub fn barycentric_weights(t: &Triangle, p: Vector3) -> [f64; 3] {
    let (u, v, w) = (t[1] - t[0], t[2] - t[0], p - t[0]);
    let (uu, uv, vv) = (u.norm_squared(), u.dot(v), v.norm_squared());
    let determinant = uu * vv - uv * uv;
    if !(determinant > 0.0) {
        return [1.0 / 3.0; 3];
    }
    let (a, b) = (w.dot(u), w.dot(v));
    let second = (a * vv - b * uv) / determinant;
    let third = (b * uu - a * uv) / determinant;
    [1.0 - second - third, second, third]
}

/// Weights of the corners of a triangle in the plane at its point nearest to the origin.
fn nearest_to_origin(corners: [Vector2; 3]) -> [f64; 3] {
    let cross = |a: Vector2, b: Vector2| a.u * b.v - a.v * b.u;
    let parts: [f64; 3] =
        core::array::from_fn(|k| cross(corners[(k + 1) % 3], corners[(k + 2) % 3]));
    let whole = parts[0] + parts[1] + parts[2];
    if whole != 0.0 && parts.iter().all(|p| p / whole >= 0.0) {
        return parts.map(|p| p / whole);
    }
    let mut best = (f64::INFINITY, [1.0, 0.0, 0.0]);
    for k in 0..3 {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        let side = b - a;
        let length = side.dot(side);
        let share = if length > 0.0 {
            (-(a.dot(side)) / length).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let point = a + side * share;
        let distance = point.dot(point);
        if distance < best.0 {
            let mut weights = [0.0; 3];
            weights[k] = 1.0 - share;
            weights[(k + 1) % 3] = share;
            best = (distance, weights);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

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
                quick += usize::from(search.lone_face(&body, meeting).is_some());
                search.contacts.clear();
                search.candidates.clear();
                search.all_contacts(&body, centre, meeting);
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
}
