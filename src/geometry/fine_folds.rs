// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a body reach narrow faces between a convex edge and a concave one, as there are everywhere on a saddle-shaped surface of many
//! triangles? There faces act by what their own triangles cover, and no edges and corners do: the contact of a body has so many of these
//! edges that none of them supports it alone.

use super::ellipsoid::Ellipsoid;
use super::facet_shares::Share;
use super::lists::{on_heap, InRoom, Lent, List, Lists, OnHeap};
use super::triangle::{sides, Near};
use super::triangle_places::TrianglePlaces;
#[cfg(not(feature = "std"))]
use crate::real::Real;
use crate::vector::Vector3;

/// The height of a narrow triangle, in radii of the ball around the body, at most. Of wider ones few edges and corners are within reach at
/// once.
const NARROW: f64 = 0.5;

/// Cosine of 15 degrees. Where the normals of two faces differ by more, a body that touches their edge is so deep in the planes of both that their
/// own forces, to which friction is in proportion, are a small part of the whole.
const GENTLE: f64 = 0.965_925_826_289_068_3;

/// Cosine of 45 degrees. Where a sharper convex edge is within reach, edges and corners act as elsewhere.
const SHARP: f64 = core::f64::consts::FRAC_1_SQRT_2;

/// Up to which square of the distance, where the body is the unit sphere, an edge has all its effect, and from which on none. So nothing is
/// left of what edges and corners do there when the edge comes into the body. Within what is looked at
/// (`triangle_places::REACH`).
const EFFECT: [f64; 2] = [1.02, 1.04];

/// The edges of narrow triangles that are within reach of one body.
pub(super) struct FineFolds<M: Lists = OnHeap> {
    /// What the convex edges of a plane leave, and the concave ones; by the planes of the triangles.
    left: M::List<[Share; 2]>,
    edges: M::List<Edge>,
}

on_heap!(FineFolds: left edges);

#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Edge {
    ends: [Vector3; 2],
    plane: usize,
    convex: bool,
}

impl Edge {
    /// Of no triangle.
    pub(super) const NONE: Edge = Edge {
        ends: [Vector3::ZERO; 2],
        plane: 0,
        convex: false,
    };
}

impl<'m> FineFolds<InRoom<'m>> {
    /// In room of somebody's.
    pub(super) fn in_room(left: &'m mut [[Share; 2]], edges: &'m mut [Edge]) -> Self {
        FineFolds {
            left: Lent::new(left),
            edges: Lent::new(edges),
        }
    }
}

impl<M: Lists> FineFolds<M> {
    /// Whether something did not fit.
    pub(super) fn lacks_room(&self) -> bool {
        self.left.lacks_room() || self.edges.lacks_room()
    }

    /// The part in which edges, corners and whole faces act, with its gradients: 1 far from such faces, 0 where a convex and a
    /// concave edge of one are in the body.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn rest(&mut self, places: &TrianglePlaces<M>, body: &Ellipsoid, meeting: f64) -> Share {
        let near = &places.near;
        self.edges.clear();
        if near.iter().all(|t| t.plane == near[0].plane) {
            return Share::WHOLE;
        }
        self.left.set_all(near.len(), [Share::WHOLE; 2]);
        self.act(places, body, meeting);
        let mut rest = Share::WHOLE;
        for [convex, concave] in self.left.iter() {
            if convex.value < 1.0 && concave.value < 1.0 {
                let both = convex.complement().times(&concave.complement());
                rest = rest.times(&both.complement());
            }
        }
        if rest.value == 1.0 {
            return rest;
        }
        let part = rest
            .complement()
            .times(&far_from_sharp(places, body, meeting));
        part.complement()
    }

    /// What the edges of narrow triangles leave.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn act(&mut self, places: &TrianglePlaces<M>, body: &Ellipsoid, meeting: f64) {
        let near = &places.near;
        let width = NARROW * body.bounding_radius();
        for t in near.iter() {
            let unit = t
                .corners
                .map(|p| body.inverse_semi_axes.componentwise(body.to_body(p)));
            for m in 0..3 {
                let next = (m + 1) % 3;
                let Some(nearest) = nearest_within_effect(unit[m], unit[next]) else {
                    continue;
                };
                if t.height() > width {
                    break;
                }
                let ends = [t.corners[m], t.corners[next]];
                let mut kinds = [false; 2];
                places.visit_edge(ends, meeting, |other| {
                    let q = &near[other];
                    if q.plane != t.plane && has_edge(q, ends) {
                        let [before, behind] = sides(t.normal, ends[0], &q.corners);
                        let is_gentle = t.normal.dot(q.normal) > GENTLE;
                        kinds[0] |= behind && is_gentle;
                        kinds[1] |= before && is_gentle;
                    }
                });
                for (kind, convex) in [(0, true), (1, false)] {
                    if kinds[kind] {
                        let left = &mut self.left[t.plane];
                        left[kind] = left[kind].times(&fade(body, ends, nearest));
                        self.edges.push(Edge {
                            ends,
                            plane: t.plane,
                            convex,
                        });
                    }
                }
            }
        }
    }

    /// Whether a convex and a concave edge of one narrow face meet at a corner; after [`FineFolds::rest`].
    pub fn meet_at(&self, corner: Vector3) -> bool {
        let ends_there = |e: &&Edge| e.ends.contains(&corner);
        let is_other = |e: &Edge, q: &Edge| e.convex != q.convex && e.plane == q.plane;
        self.edges
            .iter()
            .filter(ends_there)
            .any(|e| self.edges.iter().filter(ends_there).any(|q| is_other(e, q)))
    }
}

/// 1 where no sharp edge is within reach, 0 where one is in the body.
#[cfg_attr(not(feature = "std"), inline(never))]
fn far_from_sharp<M: Lists>(places: &TrianglePlaces<M>, body: &Ellipsoid, meeting: f64) -> Share {
    let near = &places.near;
    let mut far = Share::WHOLE;
    for (k, t) in near.iter().enumerate() {
        let unit = t
            .corners
            .map(|p| body.inverse_semi_axes.componentwise(body.to_body(p)));
        for m in 0..3 {
            let next = (m + 1) % 3;
            let Some(nearest) = nearest_within_effect(unit[m], unit[next]) else {
                continue;
            };
            let ends = [t.corners[m], t.corners[next]];
            let mut is_sharp = false;
            places.visit_edge(ends, meeting, |other| {
                let q = &near[other];
                if other != k && has_edge(q, ends) {
                    let behind = sides(t.normal, ends[0], &q.corners)[1];
                    is_sharp |= behind && t.normal.dot(q.normal) < SHARP;
                }
            });
            if is_sharp {
                far = far.times(&fade(body, ends, nearest));
            }
        }
    }
    far
}

fn has_edge(t: &Near, ends: [Vector3; 2]) -> bool {
    ends.iter().all(|end| t.corners.contains(end))
}

/// How far along a way between two points, in the frame in which the body is the unit sphere, the place nearest to the body is, and where
/// that is, if an edge has an effect there.
fn nearest_within_effect(from: Vector3, to: Vector3) -> Option<(f64, Vector3)> {
    let way = to - from;
    let place = (-from.dot(way) / way.norm_squared()).clamp(0.0, 1.0);
    let nearest = from + way * place;
    (nearest.norm_squared() < EFFECT[1]).then_some((place, nearest))
}

/// What an edge leaves, from 0 where it has all its effect to 1 where it has none; with its place nearest to the body.
#[cfg_attr(not(feature = "std"), inline(never))]
fn fade(body: &Ellipsoid, [from, to]: [Vector3; 2], (place, nearest): (f64, Vector3)) -> Share {
    let width = EFFECT[1] - EFFECT[0];
    let t = ((nearest.norm_squared() - EFFECT[0]) / width).max(0.0);
    let slope = 6.0 * t * (1.0 - t) / width;
    // along the place of the edge, of which the body moves the other way
    let outwards = body.to_world(body.inverse_semi_axes.componentwise(nearest)) * (2.0 * slope);
    Share {
        value: t * t * (3.0 - 2.0 * t),
        by_position: -outwards,
        by_rotation: outwards.cross(from + (to - from) * place),
    }
}
