// SPDX-License-Identifier: MIT OR Apache-2.0
//! The triangles near a body, and what is at a place of theirs: which of them meet there, whether one rises from another or hides it, and
//! whether a normal points away from all.

use super::box_tree::{BoxTree, Extent, Node};
use super::ellipsoid::{Ellipsoid, Support};
use super::lists::{on_heap, InRoom, Lent, List, Lists, OnHeap};
use super::triangle::{across, combine, comes_within, Near, Triangle, MEETING, TOLERANCE};
#[cfg(not(feature = "std"))]
use crate::real::Real;
use crate::vector::Vector3;

/// How far around the body triangles are looked at, in its size: where a corner at which convex and concave edges meet comes within,
/// it acts by its convex pieces, in a part that grows from 0 there (`mixed_corners`): the nearer, the faster and the stronger that pushes.
pub(crate) const REACH: f64 = 1.08;

/// How far from the sides of a triangle the place is that must be seen from the body's centre where the triangle acts, in distances
/// at which triangles meet: clear of what meets it at its border, and still near.
pub(super) const INSIDE: f64 = 100.0;

/// How far from its border the same place is at most, in the tip of a needle.
const MOST_INSIDE: f64 = 1000.0;

/// How far from a side the place is that is asked for what continues a triangle beyond it, in distances at which triangles meet: what only meets the side
/// is not there, and a needle beyond it that is wider than what meets is.
const BESIDE: f64 = 1.5;

/// How far around the body triangles are kept, in its size. No search looks at a place farther away: what meets is within a body's size of it, and what
/// hides it is before it.
const FARTHEST: f64 = REACH + (MOST_INSIDE + INSIDE) * MEETING;

/// Sine of the angle between two faces below which they are taken as one plane. Corners in single precision, as in binary
/// STL files, turn the normal of a triangle by more: such faces are folds, at which the shares of both faces make the force
/// continuous.
pub(super) const SAME_PLANE: f64 = 1e-8;

/// The triangles near a body, from its centre.
pub(super) struct TrianglePlaces<M: Lists = OnHeap> {
    pub near: M::List<Near>,
    /// Of each of them.
    pub boxes: M::List<Extent>,
    /// Of the boxes.
    pub tree: BoxTree<M>,
}

on_heap!(TrianglePlaces: near boxes tree);

impl<'m> TrianglePlaces<InRoom<'m>> {
    /// In room of somebody's.
    pub fn in_room(
        near: &'m mut [Near],
        boxes: &'m mut [Extent],
        nodes: &'m mut [Node],
        order: &'m mut [usize],
    ) -> Self {
        TrianglePlaces {
            near: Lent::new(near),
            boxes: Lent::new(boxes),
            tree: BoxTree {
                nodes: Lent::new(nodes),
                order: Lent::new(order),
            },
        }
    }
}

impl<M: Lists> TrianglePlaces<M> {
    /// Whether something did not fit.
    pub fn lacks_room(&self) -> bool {
        let tree = &self.tree;
        self.near.lacks_room()
            || self.boxes.lacks_room()
            || tree.nodes.lacks_room()
            || tree.order.lacks_room()
    }

    /// The triangles that come into the body or within its reach, without slivers.
    pub fn gather(
        &mut self,
        body: &Ellipsoid,
        centre: Vector3,
        all: impl Iterator<Item = Triangle>,
        meeting: f64,
    ) {
        self.near.clear();
        self.boxes.clear();
        let reach = [
            Vector3::new(1.0, 0.0, 0.0),
            Vector3::new(0.0, 1.0, 0.0),
            Vector3::new(0.0, 0.0, 1.0),
        ]
        .map(|e| FARTHEST * body.support(e).h);
        let own = Extent {
            low: reach.map(|x| -x),
            high: reach,
        };
        for (index, t) in all.enumerate() {
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
            // Where the body is the unit sphere: a vector across the triangle.
            let scaled = body.semi_axes.componentwise(body.to_body(across));
            let square = scaled.norm_squared();
            if height * height > FARTHEST * FARTHEST * square
                || !comes_within(body, &corners, scaled, height * height / square, FARTHEST)
            {
                continue;
            }
            if let Some(triangle) = Near::with_normal(index, corners, (across, longest), meeting) {
                let plane = self.near.len();
                self.near.push(Near { plane, ..triangle });
                self.boxes.push(extent);
            }
        }
    }

    /// Whether each edge that comes into the body belongs to two triangles: then they have no border there.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn is_joined_in(&self, body: &Ellipsoid) -> bool {
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

    /// Joins triangles that continue one another in one plane; what follows asks of places.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn join_planes(&mut self, largest: f64, meeting: f64) {
        let TrianglePlaces { near, boxes, tree } = self;
        tree.build(boxes);
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

    /// The triangle of a plane, as far as it is near, that comes nearest to a place of it, and its point there, in the measure of the plane's section with
    /// the body.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn nearest_in_plane(
        &self,
        plane: usize,
        body: &Ellipsoid,
        support: &Support,
        place: Vector3,
    ) -> (usize, Vector3) {
        let mut best = (f64::INFINITY, plane, place);
        for (k, t) in self.near.iter().enumerate() {
            if t.plane == plane {
                let (point, square) = t.nearest_and_way(body, support, place);
                if square < best.0 {
                    best = (square, k, point);
                }
            }
        }
        (best.1, best.2)
    }

    /// Whether a plane goes on from its point nearest to a place beyond it, which one of its triangles has: beyond a side from which another triangle rises, and at a
    /// corner beyond no other one. Sides within the plane are none.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn goes_on_beyond(&self, own: usize, point: Vector3, place: Vector3, meeting: f64) -> bool {
        let t = &self.near[own];
        if !t.corners.contains(&point) {
            return self.folds_up(own, point, meeting);
        }
        let mut ends = false;
        self.tree.visit(
            &self.boxes,
            &Extent::about(point.to_array(), meeting),
            |k| {
                ends = self.near[k].plane == t.plane && self.ends_at(k, point, place, meeting);
                !ends
            },
        );
        !ends
    }

    /// Whether a place in the plane of a triangle is beyond a side of it that begins at a corner and is one of the plane's, from which no triangle rises.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn ends_at(&self, own: usize, corner: Vector3, place: Vector3, meeting: f64) -> bool {
        let t = &self.near[own];
        let is_there = |z: &Vector3| (*z - corner).norm_squared() <= meeting * meeting;
        let Some(m) = t.corners.iter().position(is_there) else {
            return false;
        };
        let from = t.corners[m];
        let sides = [t.corners[(m + 1) % 3], t.corners[(m + 2) % 3]];
        (0..2).any(|k| {
            let (along, inwards) = (sides[k] - from, sides[1 - k] - from);
            let mut out = t.normal.cross(along);
            if out.dot(inwards) > 0.0 {
                out = -out;
            }
            let length = along.norm();
            let beside = from + along * (INSIDE * meeting / length).min(0.5);
            out.dot(place - from) > 0.0
                && !self.goes_on_in_plane(own, beside + out * (BESIDE * meeting / length), meeting)
                && !self.folds_up(own, beside, meeting)
        })
    }

    /// Whether another triangle of the same plane is at a point of it.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn goes_on_in_plane(&self, own: usize, point: Vector3, meeting: f64) -> bool {
        let plane = self.near[own].plane;
        let mut goes_on = false;
        let place = Extent::about(point.to_array(), meeting);
        self.tree.visit(&self.boxes, &place, |k| {
            let q = &self.near[k];
            goes_on = k != own && q.plane == plane && q.has(point, meeting);
            !goes_on
        });
        goes_on
    }

    /// Whether another triangle rises from the plane of this one at a point of its border, on the side of the body.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn folds_up(&self, own: usize, point: Vector3, meeting: f64) -> bool {
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

    /// Whether another triangle comes between the body's centre and a point of this one, of whose plane all that is near lies behind it. So the faces
    /// of a block, seen from within, do not act on a body that lies across its edges.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn is_hidden(&self, own: usize, point: Vector3, meeting: f64) -> bool {
        let t = &self.near[own];
        let inwards = combine(&t.corners, [1.0 / 3.0; 3]) - point;
        let (twice_area, longest) = across(&t.corners);
        // Of the middle, from the longest side.
        let height = twice_area.norm() / (3.0 * longest.sqrt());
        let length = inwards.norm();
        let meetings = (INSIDE * length / height).clamp(INSIDE, MOST_INSIDE);
        let seen = point + inwards * (meetings * meeting / length).min(1.0);
        let way = Extent {
            low: seen.to_array().map(|x| x.min(0.0)),
            high: seen.to_array().map(|x| x.max(0.0)),
        };
        let mut hidden = false;
        self.tree.visit(&self.boxes, &way, |k| {
            let q = &self.near[k];
            hidden = k != own
                && q.stands_before(t, seen, meeting)
                && (self.near.iter()).all(|p| p.plane != t.plane || q.is_before(p, meeting));
            !hidden
        });
        hidden
    }

    /// Whether a normal at a point points away from all triangles that meet there.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn is_outermost(&self, normal: Vector3, point: Vector3, meeting: f64) -> bool {
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

    /// Whether the body's centre is before one of the triangles that meet at a point and all of them are behind that one: so it is before an edge or a corner
    /// that stands out towards it, and not on the other side, where a fold stands out.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn stands_out(&self, point: Vector3, meeting: f64) -> bool {
        let mut stands_out = false;
        let place = Extent::about(point.to_array(), meeting);
        self.tree.visit(&self.boxes, &place, |k| {
            let q = &self.near[k];
            stands_out = q.has(point, meeting) && self.is_outermost(q.normal, point, meeting);
            !stands_out
        });
        stands_out
    }

    /// Where a side of a flat piece ends that begins at a corner with this part of it, as far as triangles of the plane are near.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn end_of_side(&self, plane: usize, [from, to]: [Vector3; 2]) -> Vector3 {
        let mut end = to;
        for t in self.near.iter().filter(|t| t.plane == plane) {
            for corner in t.corners {
                let is_farther = (corner - end).dot(to - from) > 0.0;
                if is_farther && is_on_line(corner, [from, to]) {
                    end = corner;
                }
            }
        }
        end
    }

    /// Visits the triangles that pass the middle of an edge.
    pub fn visit_edge(&self, [a, b]: [Vector3; 2], meeting: f64, mut found: impl FnMut(usize)) {
        let place = Extent::about(((a + b) * 0.5).to_array(), meeting);
        self.tree.visit(&self.boxes, &place, |k| {
            found(k);
            true
        });
    }

    /// Whether another triangle of the same plane continues this one beyond an edge: that is none.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn is_within_plane(&self, own: usize, a: Vector3, b: Vector3) -> bool {
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

/// Whether a point is on the line through two others, up to rounding.
pub(super) fn is_on_line(point: Vector3, [from, to]: [Vector3; 2]) -> bool {
    let (way, own) = (to - from, point - from);
    let longest = way.norm_squared().max(own.norm_squared());
    own.cross(way).norm_squared() <= SAME_PLANE * SAME_PLANE * way.norm_squared() * longest
}

/// Whether a way between two points, in the frame in which the body is the unit sphere, comes into the body or close to it.
#[cfg_attr(not(feature = "std"), inline(never))]
pub(super) fn is_within_reach(a: Vector3, b: Vector3) -> bool {
    let way = b - a;
    let length = way.norm_squared();
    let place = if length > 0.0 {
        (-a.dot(way) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (a + way * place).norm_squared() < 1.0 + 1e-3
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;
    use crate::geometry::triangle::MEETING;

    /// All that come into the body or within its reach; none farther than that, but for what is clear of the distance at which triangles meet.
    #[test]
    fn what_is_gathered_is_what_is_near() {
        let mut random = Random::new(12);
        let (mut kept, mut left_out) = (0, 0);
        for _ in 0..300 {
            let size = random.of_any_size(0.01, 100.0);
            let semi_axes = [0; 3].map(|_| size * random.of_any_size(0.1, 1.0));
            let body = Ellipsoid::new(semi_axes, random.quaternion()).unwrap();
            let meeting = MEETING * body.smallest_semi_axis();
            let centre = random.direction() * (3.0 * size);
            let all: Vec<Triangle> = (0..20)
                .map(|_| {
                    let middle = centre + random.direction() * (size * random.uniform(0.0, 2.0));
                    let reach = size * random.of_any_size(0.1, 3.0);
                    [0; 3].map(|_| middle + random.direction() * reach)
                })
                .collect();
            let mut places = TrianglePlaces::default();
            places.gather(&body, centre, all.iter().copied(), meeting);
            assert_eq!(places.near.len(), places.boxes.len());
            for (k, t) in all.iter().enumerate() {
                let Some(near) = Near::new(k, t, centre, meeting) else {
                    continue;
                };
                let is_kept = places.near.iter().any(|q| q.index == k);
                let unit = near
                    .corners
                    .map(|p| body.inverse_semi_axes.componentwise(body.to_body(p)));
                let of_ball = Near::new(k, &unit, Vector3::ZERO, 0.0).unwrap();
                assert!(is_kept || !of_ball.has(Vector3::ZERO, REACH - 1e-9));
                let far = FARTHEST + 1e-9;
                assert!(
                    !is_kept || of_ball.has(Vector3::ZERO, far),
                    "{body:?} {centre:?} {t:?}"
                );
                kept += usize::from(is_kept);
                left_out += usize::from(!is_kept);
            }
            for (k, near) in places.near.iter().enumerate() {
                assert_eq!(near.plane, k);
            }
        }
        assert!(kept > 1000 && left_out > 1000, "{kept} {left_out}");
    }

    /// Triangles of a plane that meet stand for one another, in whatever order they come; those of another plane do not.
    #[test]
    fn triangles_that_continue_one_another_are_one_plane() {
        let at = |x: f64, y: f64| Vector3::new(x, y, 0.1 * y);
        let strip = |k: usize, gap: f64| {
            let x = -0.8 + 0.4 * k as f64 + gap;
            [
                [at(x, 0.0), at(x + 0.4, 0.0), at(x, 0.5)],
                [at(x + 0.4, 0.0), at(x + 0.4, 0.5), at(x, 0.5)],
            ]
        };
        let body = Ellipsoid::new([1.0; 3], [1.0, 0.0, 0.0, 0.0]).unwrap();
        let meeting = MEETING;
        let planes = |all: &[Triangle]| {
            let mut places = TrianglePlaces::default();
            places.gather(
                &body,
                Vector3::new(0.0, 0.25, 0.5),
                all.iter().copied(),
                meeting,
            );
            places.join_planes(1.0, meeting);
            places.near.iter().map(|t| t.plane).collect::<Vec<_>>()
        };
        let joined: Vec<Triangle> = (0..4).flat_map(|k| strip(k, 0.0)).collect();
        assert_eq!(planes(&joined), vec![0; 8]);
        let order = [5, 0, 7, 2, 6, 1, 4, 3];
        let mixed: Vec<Triangle> = order.iter().map(|k| joined[*k]).collect();
        assert_eq!(planes(&mixed), vec![0; 8]);
        // The last strips apart from the others.
        let parted: Vec<Triangle> = (0..4)
            .flat_map(|k| strip(k, if k > 1 { 0.01 } else { 0.0 }))
            .collect();
        assert_eq!(planes(&parted), vec![0, 0, 0, 0, 4, 4, 4, 4]);
        let mut bent = joined.clone();
        bent[0][2].z += 1e-3;
        assert_eq!(planes(&bent), vec![0, 1, 1, 1, 1, 1, 1, 1]);
    }
}
