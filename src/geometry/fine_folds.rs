// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a body reach narrow faces between a convex edge and a concave one, as there are everywhere on a saddle-shaped surface of many
//! triangles? There faces act by what their own triangles cover, and no edges and corners do: the contact of a body has so many of these
//! edges that none of them supports it alone.

use super::ellipsoid::Ellipsoid;
use super::facet_shares::Share;
use super::lists::{on_heap, InRoom, Lent, List, Lists, OnHeap};
use super::triangle::{sides, Near};
use super::triangle_places::{is_on_line, TrianglePlaces};
#[cfg(not(feature = "std"))]
use crate::real::Real;
use crate::vector::Vector3;
use core::cmp::Ordering;

/// The width of a narrow flat piece (`flat_pieces`), in radii of the ball around the body, at most. Of wider ones few edges and corners are within
/// reach at once.
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

/// The edges of narrow flat pieces that are within reach of one body.
pub(super) struct FineFolds<M: Lists = OnHeap> {
    /// What the convex edges of a plane leave, and the concave ones; by the planes of the triangles.
    left: M::List<[Share; 2]>,
    edges: M::List<Edge>,
    sharp: M::List<Edge>,
}

on_heap!(FineFolds: left edges sharp);

/// An edge within reach: a part of one, where triangles divide it.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Edge {
    ends: [Vector3; 2],
    /// How far along it the place nearest to the body is, and where that is in the frame in which the body is the unit sphere.
    nearest: (f64, Vector3),
    /// Of the triangle of which it is a side.
    plane: usize,
    convex: bool,
}

impl Edge {
    /// Of no triangle.
    pub(super) const NONE: Edge = Edge {
        ends: [Vector3::ZERO; 2],
        nearest: (0.0, Vector3::ZERO),
        plane: 0,
        convex: false,
    };

    /// Whether another is a part of the same edge of the same plane.
    fn is_one_with(&self, other: &Edge) -> bool {
        self.convex == other.convex
            && self.plane == other.plane
            && other.ends.iter().all(|&p| is_on_line(p, self.ends))
    }

    /// By planes, and from the nearest to the body on.
    fn order(&self, other: &Edge) -> Ordering {
        let square = |e: &Edge| e.nearest.1.norm_squared();
        let nearer = || square(self).total_cmp(&square(other));
        self.plane.cmp(&other.plane).then_with(nearer)
    }
}

/// What edges in their order leave, each with its plane. Of an edge of several parts the nearest one counts: it has the body's distance from all of them.
fn each_once<'e>(
    body: &'e Ellipsoid,
    edges: &'e [Edge],
) -> impl Iterator<Item = (&'e Edge, Share)> {
    edges.iter().enumerate().filter_map(|(own, edge)| {
        let mut nearer = edges[..own].iter().rev();
        let is_part = nearer
            .by_ref()
            .take_while(|e| e.plane == edge.plane)
            .any(|e| e.is_one_with(edge));
        (!is_part).then(|| (edge, fade(body, edge)))
    })
}

impl<'m> FineFolds<InRoom<'m>> {
    /// In room of somebody's.
    pub(super) fn in_room(left: &'m mut [[Share; 2]], [edges, sharp]: [&'m mut [Edge]; 2]) -> Self {
        FineFolds {
            left: Lent::new(left),
            edges: Lent::new(edges),
            sharp: Lent::new(sharp),
        }
    }
}

impl<M: Lists> FineFolds<M> {
    /// Whether something did not fit.
    pub(super) fn lacks_room(&self) -> bool {
        self.left.lacks_room() || self.edges.lacks_room() || self.sharp.lacks_room()
    }

    /// The part in which edges, corners and whole faces act, with its gradients: 1 far from such faces, 0 where a convex and a
    /// concave edge of one are in the body. `width` says how wide the flat piece is of which a triangle is a part, by the triangle's index.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn rest(
        &mut self,
        places: &TrianglePlaces<M>,
        body: &Ellipsoid,
        meeting: f64,
        width: &impl Fn(usize) -> f64,
    ) -> Share {
        let near = &places.near;
        self.edges.clear();
        if near.iter().all(|t| t.plane == near[0].plane) {
            return Share::WHOLE;
        }
        self.find_edges(places, body, meeting, width);
        let is_convex = |e: &Edge| e.convex;
        if self.edges.iter().all(is_convex) || !self.edges.iter().any(is_convex) {
            return Share::WHOLE;
        }
        self.left.set_all(near.len(), [Share::WHOLE; 2]);
        self.edges.sort_with(Edge::order);
        for (edge, own) in each_once(body, &self.edges) {
            let left = &mut self.left[edge.plane][usize::from(!edge.convex)];
            *left = left.times(&own);
        }
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
            .times(&self.far_from_sharp(places, body, meeting));
        part.complement()
    }

    /// The edges of narrow flat pieces at small angles that are within reach.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn find_edges(
        &mut self,
        places: &TrianglePlaces<M>,
        body: &Ellipsoid,
        meeting: f64,
        width: &impl Fn(usize) -> f64,
    ) {
        let near = &places.near;
        let narrow = NARROW * body.bounding_radius();
        for t in near.iter() {
            let unit = t
                .corners
                .map(|p| body.inverse_semi_axes.componentwise(body.to_body(p)));
            for m in 0..3 {
                let next = (m + 1) % 3;
                let Some(nearest) = nearest_within_effect(unit[m], unit[next]) else {
                    continue;
                };
                // No piece is narrower than a triangle of it.
                if t.height() > narrow || width(t.index) > narrow {
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
                        self.edges.push(Edge {
                            ends,
                            nearest,
                            plane: t.plane,
                            convex,
                        });
                    }
                }
            }
        }
    }

    /// Whether a convex and a concave edge of one narrow face meet at a corner; after [`FineFolds::rest`].
    pub fn meet_at(&self, places: &TrianglePlaces<M>, corner: Vector3) -> bool {
        let has_corner = |plane: usize| {
            let mut own = places.near.iter().filter(|t| t.plane == plane);
            own.any(|t| t.corners.contains(&corner))
        };
        // With all of its parts.
        let ends_there = |e: &&Edge| {
            e.ends.contains(&corner) || is_on_line(corner, e.ends) && has_corner(e.plane)
        };
        let is_other = |e: &Edge, q: &Edge| e.convex != q.convex && e.plane == q.plane;
        self.edges
            .iter()
            .filter(ends_there)
            .any(|e| self.edges.iter().filter(ends_there).any(|q| is_other(e, q)))
    }

    /// 1 where no sharp edge is within reach, 0 where one is in the body.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn far_from_sharp(
        &mut self,
        places: &TrianglePlaces<M>,
        body: &Ellipsoid,
        meeting: f64,
    ) -> Share {
        let near = &places.near;
        self.sharp.clear();
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
                    self.sharp.push(Edge {
                        ends,
                        nearest,
                        plane: t.plane,
                        convex: true,
                    });
                }
            }
        }
        let mut far = Share::WHOLE;
        self.sharp.sort_with(Edge::order);
        for (_, own) in each_once(body, &self.sharp) {
            far = far.times(&own);
        }
        far
    }
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

/// What an edge leaves, from 0 where it has all its effect to 1 where it has none.
#[cfg_attr(not(feature = "std"), inline(never))]
fn fade(body: &Ellipsoid, edge: &Edge) -> Share {
    let ([from, to], (place, nearest)) = (edge.ends, edge.nearest);
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

#[cfg(test)]
mod tests {
    use super::super::flat_pieces::widths;
    use super::super::triangle::{Triangle, MEETING};
    use super::*;
    use crate::geometry::random::Random;

    /// Strips along y, each of two triangles, between lines at these places of x and z.
    fn strips(profile: &[[f64; 2]]) -> Vec<Triangle> {
        let at = |[x, z]: [f64; 2], y: f64| Vector3::new(x, y, z);
        profile
            .windows(2)
            .flat_map(|pair| {
                let [a, b] = [pair[0], pair[1]];
                let corners = [at(a, -6.0), at(b, -6.0), at(b, 6.0), at(a, 6.0)];
                [
                    [corners[0], corners[1], corners[2]],
                    [corners[0], corners[2], corners[3]],
                ]
            })
            .enumerate()
            .map(|(k, t)| [t[k % 3], t[(k + 1) % 3], t[(k + 2) % 3]])
            .collect()
    }

    /// A narrow strip from the origin on, horizontal: at its left end the surface falls away by an angle, at its right end it rises by
    /// another. Degrees; one that is negative makes the other kind of edge.
    fn step(width: f64, fall: f64, rise: f64) -> Vec<[f64; 2]> {
        vec![
            [-1.0, -fall.to_radians().tan()],
            [0.0, 0.0],
            [width, 0.0],
            [width + 1.0, rise.to_radians().tan()],
        ]
    }

    fn rest(
        body: &Ellipsoid,
        centre: Vector3,
        triangles: &[Triangle],
    ) -> (Share, FineFolds, TrianglePlaces) {
        let meeting = MEETING * body.smallest_semi_axis();
        let mut places = TrianglePlaces::default();
        places.gather(body, centre, triangles.iter().copied(), meeting);
        places.join_planes(body.bounding_radius(), meeting);
        let mut fine = FineFolds::default();
        let widths = widths(triangles);
        let share = fine.rest(&places, body, meeting, &|index| widths[index]);
        (share, fine, places)
    }

    fn ball() -> Ellipsoid {
        Ellipsoid::new([1.0; 3], [1.0, 0.0, 0.0, 0.0]).unwrap()
    }

    /// What an edge leaves of a ball of radius 1 whose centre is so far from it.
    fn left(square: f64) -> f64 {
        let t = ((square - 1.02) / 0.02).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    }

    #[test]
    fn a_narrow_face_acts_by_both_of_its_edges() {
        let mut random = Random::new(2);
        let mut between = 0;
        for k in 0..400 {
            let width = random.uniform(0.1, 0.4);
            let wall = strips(&step(width, 8.0, 10.0));
            // In the ball, near its surface, or beyond it.
            let distance = [random.uniform(0.9, 1.0), random.uniform(1.005, 1.025)][k % 2];
            let x = width * random.uniform(-0.2, 1.2);
            let centre = Vector3::new(x, 0.3, (distance * distance - x * x).sqrt());
            let squares = [x, x - width].map(|x| x * x + centre.z * centre.z);
            let expected = 1.0 - (1.0 - left(squares[0])) * (1.0 - left(squares[1]));
            let (found, ..) = rest(&ball(), centre, &wall);
            assert!(
                (found.value - expected).abs() < 1e-11,
                "{found:?} {expected}"
            );
            between += usize::from(expected > 0.0 && expected < 1.0);
        }
        assert!(between > 40, "{between}");
    }

    /// Wide faces, edges of one kind and large angles; and a sharp edge within reach.
    #[test]
    fn where_edges_and_corners_act_as_elsewhere() {
        let over = |width: f64, fall: f64, rise: f64| {
            let centre = Vector3::new(0.5 * width, 0.3, 0.95);
            rest(&ball(), centre, &strips(&step(width, fall, rise)))
                .0
                .value
        };
        assert_eq!(over(0.2, 8.0, 10.0), 0.0);
        assert_eq!(over(0.48, 8.0, 10.0), 0.0);
        assert_eq!(over(0.52, 8.0, 10.0), 1.0);
        assert_eq!(over(0.2, 14.5, 14.5), 0.0);
        assert_eq!(over(0.2, 15.5, 8.0), 1.0);
        assert_eq!(over(0.2, 8.0, 15.5), 1.0);
        assert_eq!(over(0.2, 8.0, -10.0), 1.0);
        assert_eq!(over(0.2, -8.0, 10.0), 1.0);
        let flat = over(0.2, 0.0, 0.0);
        assert_eq!(flat, 1.0);
        // Edges out of reach.
        let wall = strips(&step(0.2, 8.0, 10.0));
        let far = Vector3::new(0.1, 0.3, 1.03);
        assert_eq!(rest(&ball(), far, &wall).0.value, 1.0);
        // Of a body twice as large, faces twice as wide.
        let large = Ellipsoid::new([2.0; 3], [1.0, 0.0, 0.0, 0.0]).unwrap();
        for (width, value) in [(0.95, 0.0), (1.05, 1.0)] {
            let wall = strips(&step(width, 8.0, 10.0));
            let centre = Vector3::new(0.5 * width, 0.3, 1.8);
            assert_eq!(rest(&large, centre, &wall).0.value, value);
        }
        // What rises beyond the right end in other pieces has no edge in common with the face.
        let mut pieces = wall[..4].to_vec();
        let at = |m: usize, y: f64| {
            Vector3::new(step(0.2, 8.0, 10.0)[m][0], y, step(0.2, 8.0, 10.0)[m][1])
        };
        for [from, to] in [[-6.0, 1.0], [1.0, 6.0]] {
            pieces.push([at(2, from), at(3, from), at(3, to)]);
            pieces.push([at(2, from), at(3, to), at(2, to)]);
        }
        let centre = Vector3::new(0.1, 0.3, 0.95);
        assert_eq!(rest(&ball(), centre, &wall).0.value, 0.0);
        assert_eq!(rest(&ball(), centre, &pieces).0.value, 1.0);
    }

    /// A surface of a narrow face, a wide one and an edge at which it falls by so many degrees, which may lie at the end of what has an effect.
    fn before_an_edge(degrees: f64, place: f64) -> Vec<Triangle> {
        let fall = (10f64 - degrees).to_radians().tan();
        let rise = 10f64.to_radians().tan();
        let mut profile = step(0.2, 8.0, 10.0);
        profile[3] = [place, (place - 0.2) * rise];
        profile.push([place + 1.0, profile[3][1] + fall]);
        strips(&profile)
    }

    #[test]
    fn a_sharp_edge_within_reach_brings_back_what_acts_elsewhere() {
        let centre = Vector3::new(0.3, 0.3, 0.9);
        let of = |degrees: f64, place: f64| {
            rest(&ball(), centre, &before_an_edge(degrees, place))
                .0
                .value
        };
        assert_eq!(of(44.5, 0.6), 0.0);
        assert_eq!(of(45.5, 0.6), 1.0);
        assert_eq!(of(60.0, 0.6), 1.0);
        // One that rises is no such edge.
        assert_eq!(of(-60.0, 0.6), 0.0);
        for place in [0.94, 0.96, 0.965, 0.97, 0.98, 1.0] {
            let height = (place - 0.2) * 10f64.to_radians().tan();
            let square = (place - centre.x).powi(2) + (height - centre.z).powi(2);
            let expected = 1.0 - left(square);
            let found = of(60.0, place);
            assert!(
                (found - expected).abs() < 1e-11,
                "{place}: {found} {expected}"
            );
        }
    }

    /// Gradients along the body's motion and rotation, of an ellipsoid, with a sharp edge and without.
    #[test]
    fn the_gradients_are_those_of_the_part() {
        let mut random = Random::new(9);
        let mut between = 0;
        for k in 0..600 {
            let semi_axes = [0; 3].map(|_| random.uniform(0.7, 1.0));
            let body = Ellipsoid::new(semi_axes, random.quaternion()).unwrap();
            let wall = if k % 2 == 0 {
                strips(&step(0.15, 8.0, 10.0))
            } else {
                before_an_edge(60.0, random.uniform(0.5, 1.0))
            };
            let h = body.support(Vector3::new(0.0, 0.0, -1.0)).h;
            let far = [1.0, random.uniform(1.0, 1.02)][k % 2];
            let centre = Vector3::new(random.uniform(0.0, 0.3), 0.3, h * far);
            let found = rest(&body, centre, &wall).0;
            between += usize::from(found.value > 0.0 && found.value < 1.0);
            let h = 1e-6;
            for e in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vector3::from_array) {
                let moved = |by: f64| rest(&body, centre + e * by, &wall).0.value;
                let turned = |angle: f64| {
                    let mut body = body;
                    body.axes = body.axes.map(|a| {
                        let along = e * e.dot(a);
                        along + (a - along) * angle.cos() + e.cross(a) * angle.sin()
                    });
                    rest(&body, centre, &wall).0.value
                };
                for (slope, difference) in [
                    (found.by_position.dot(e), moved(h) - moved(-h)),
                    (found.by_rotation.dot(e), turned(h) - turned(-h)),
                ] {
                    let expected = difference / (2.0 * h);
                    assert!(
                        (slope - expected).abs() < 0.02 + 1e-4 * expected.abs(),
                        "{slope} {expected} of {body:?} {centre:?}"
                    );
                }
            }
        }
        println!("{between} in between");
        assert!(between > 50);
    }

    /// At the tip of a fan whose rays rise and fall in turn, edges of both kinds of each face meet; of a bowl, of one kind.
    #[test]
    fn edges_of_both_kinds_meet_at_a_saddle() {
        let fan = |height: &dyn Fn(u32) -> f64| -> Vec<Triangle> {
            let ray = |k: u32| {
                let angle = core::f64::consts::TAU * f64::from(k % 8) / 8.0;
                Vector3::new(0.4 * angle.cos(), 0.4 * angle.sin(), height(k % 8))
            };
            (0..8)
                .map(|k| [Vector3::ZERO, ray(k), ray(k + 1)])
                .collect()
        };
        let centre = Vector3::new(0.01, 0.02, 0.98);
        let saddle = fan(&|k| if k % 4 == 0 { 0.01 } else { -0.005 });
        let (share, fine, places) = rest(&ball(), centre, &saddle);
        assert_eq!(share.value, 0.0);
        assert!(fine.meet_at(&places, -centre));
        assert!(!fine.meet_at(&places, saddle[1][1] - centre));
        let bowl = fan(&|_| 0.01);
        let (share, fine, places) = rest(&ball(), centre, &bowl);
        assert_eq!(share.value, 1.0);
        assert!(!fine.meet_at(&places, -centre));
    }
}
