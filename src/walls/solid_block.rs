// SPDX-License-Identifier: MIT OR Apache-2.0
//! A block from without: its faces, edges and corners as triangles, and what they do not know of a body that is deep in it.

use super::deep_in_solid::{minima_of_arc, minima_of_point, overlap, shortest_way_out, Convex};
use super::mesh::Mesh;
use super::shape::{Ball, Block, Found, Grain, Search, Shape, ShapeInLanes};
use super::triangle_contacts::surface;
use crate::geometry::nearest_line::towards_line;
use crate::geometry::share::Share;
use crate::geometry::triangles::{Feature, Triangle, TriangleContact};
use crate::message::Numbers;
use crate::simd::Line;
use crate::vector::Vector3;
use core::f64::consts::FRAC_PI_2;

/// A block along the axes of its wall, from without. Triangles act on both sides, by that of a body's centre; a body whose centre is in the block,
/// or that touches none of them and is in it all the same, goes out the shortest way.
#[derive(Clone, Debug)]
pub(super) struct SolidBlock {
    pub(super) mesh: Mesh,
    low: [f64; 3],
    high: [f64; 3],
}

/// A face, an edge or a corner.
pub(super) struct BlockPlace {
    feature: Feature,
    /// A point of it.
    point: Vector3,
}

impl SolidBlock {
    /// Between two corners.
    ///
    /// # Errors
    /// Corners that are not in order, or out of range.
    pub fn new(low: [f64; 3], high: [f64; 3]) -> Result<Self, String> {
        if !(0..3).all(|k| low[k] < high[k]) {
            return Err(format!(
                "a block from {} to {} has no inside",
                Numbers(&low),
                Numbers(&high)
            ));
        }
        let mut triangles = vec![];
        for face in 0..6 {
            let axis = face / 2;
            let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
            let corner = |m: usize| {
                let mut p = low;
                p[axis] = if face % 2 == 0 { low[axis] } else { high[axis] };
                p[b] = if m == 1 || m == 2 { high[b] } else { low[b] };
                p[c] = if m >= 2 { high[c] } else { low[c] };
                Vector3::from_array(p)
            };
            triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(corner)));
        }
        Ok(SolidBlock {
            mesh: Mesh::new(triangles)?,
            low,
            high,
        })
    }

    /// Whether a point is in the block or on its surface.
    fn has(&self, p: Vector3) -> bool {
        let p = p.to_array();
        (0..3).all(|k| self.low[k] <= p[k] && p[k] <= self.high[k])
    }

    /// Its bound along an axis, the upper one or the lower one.
    fn bound(&self, axis: usize, upper: bool) -> f64 {
        if upper {
            self.high[axis]
        } else {
            self.low[axis]
        }
    }

    /// The contact of a body that is deep in it.
    fn deep(&self, grain: &Grain<'_>, found: &mut Found<'_>) {
        let Some((normal, penetration, place)) = shortest_way_out(self, grain) else {
            return;
        };
        // The deepest point of the body, moved along the normal to the solid, and there to the place itself.
        let foot = grain.centre + grain.body.support(-normal).point + normal * penetration;
        let point = match place.feature {
            Feature::Face => foot,
            Feature::Edge(along) => place.point + along * along.dot(foot - place.point),
            Feature::Corner => place.point,
        };
        let n = normal.to_array();
        let axis = (0..3).fold(0, |m, k| if n[k].abs() > n[m].abs() { k } else { m });
        let triangle = 4 * axis + if n[axis] > 0.0 { 2 } else { 0 };
        let contact = TriangleContact {
            point,
            normal,
            penetration,
            triangle,
            feature: place.feature,
            share: Share::WHOLE,
        };
        found(&surface(&contact), triangle);
    }
}

/// The unit vector along an axis, or against it.
fn unit(axis: usize, upper: bool) -> Vector3 {
    let mut e = [0.0; 3];
    e[axis] = if upper { 1.0 } else { -1.0 };
    Vector3::from_array(e)
}

impl Convex for SolidBlock {
    type Place = BlockPlace;

    fn farthest(&self, n: Vector3) -> Vector3 {
        let n = n.to_array();
        Vector3::from_array(core::array::from_fn(|k| self.bound(k, n[k] > 0.0)))
    }

    /// By a face, as most bodies beside a block are, or by an edge. Corners are asked with their normals.
    fn is_apart(&self, grain: &Grain<'_>) -> bool {
        let is_between = |n: Vector3| overlap(self, grain, n).dot(n) <= 0.0;
        let mut faces = (0..3).flat_map(|axis| [false, true].map(|upper| unit(axis, upper)));
        if faces.any(is_between) {
            return true;
        }
        (0..12).any(|edge| {
            let axis = edge / 4;
            let mut sides = [false; 3];
            sides[(axis + 1) % 3] = edge & 1 != 0;
            sides[(axis + 2) % 3] = edge & 2 != 0;
            let point = Vector3::from_array(core::array::from_fn(|k| self.bound(k, sides[k])));
            is_between(-towards_line(
                grain.body,
                point - grain.centre,
                unit(axis, true),
            ))
        })
    }

    fn nearest(&self, p: Vector3) -> Option<Vector3> {
        let x = p.to_array();
        let on_it = core::array::from_fn(|k| x[k].clamp(self.low[k], self.high[k]));
        (!self.has(p)).then(|| Vector3::from_array(on_it))
    }

    fn offer_normals(&self, grain: &Grain<'_>, offer: &mut dyn FnMut(Vector3, BlockPlace)) -> bool {
        let corner = |x: bool, y: bool, z: bool| {
            Vector3::new(self.bound(0, x), self.bound(1, y), self.bound(2, z))
        };
        for axis in 0..3 {
            let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
            for upper in [false, true] {
                let place = |feature, point| BlockPlace { feature, point };
                offer(
                    unit(axis, upper),
                    place(Feature::Face, corner(upper, upper, upper)),
                );
                for beside in [false, true] {
                    let mut sides = [false; 3];
                    (sides[b], sides[c]) = (upper, beside);
                    let point = corner(sides[0], sides[1], sides[2]);
                    let along = unit(axis, true);
                    let normals = [unit(b, upper), unit(c, beside)];
                    minima_of_arc(grain, point, normals, FRAC_PI_2, |n| {
                        offer(n, place(Feature::Edge(along), point));
                    });
                }
            }
        }
        for k in 0..8 {
            let point = corner(k & 1 != 0, k & 2 != 0, k & 4 != 0);
            minima_of_point(grain, point, |n| {
                let feature = Feature::Corner;
                offer(n, BlockPlace { feature, point });
            });
        }
        true
    }
}

impl Shape for SolidBlock {
    fn remembered(&self) -> usize {
        self.mesh.remembered()
    }

    fn may_touch(&self, ball: &Ball) -> bool {
        let c = ball.centre.to_array();
        !(0..3).any(|k| c[k] + ball.radius < self.low[k] || c[k] - ball.radius > self.high[k])
    }

    fn may_touch_block(&self, block: &Block) -> bool {
        let own = crate::geometry::box_tree::Extent {
            low: self.low,
            high: self.high,
        };
        own.overlaps(&block.extent())
    }

    fn mark_near(&mut self, balls: &[Ball], marks: &mut [bool]) {
        self.mesh.mark_near(balls, marks);
        for (ball, mark) in balls.iter().zip(marks) {
            *mark |= self.has(ball.centre);
        }
    }

    fn in_lanes(&self) -> Option<ShapeInLanes> {
        self.mesh.in_lanes()
    }

    fn flat_places(&self) -> &[Line] {
        self.mesh.flat_places()
    }

    fn solid_box(&self) -> Option<[Vector3; 2]> {
        Some([self.low, self.high].map(Vector3::from_array))
    }

    fn touch(&self, grain: &Grain<'_>, search: &mut Search, found: &mut Found<'_>) {
        let mut touches = false;
        if !self.has(grain.centre) {
            self.mesh.touch(grain, search, &mut |surface, triangle| {
                touches = true;
                found(surface, triangle);
            });
        }
        if !touches {
            self.deep(grain, found);
        }
    }

    fn triangles(&self) -> &[Triangle] {
        self.mesh.triangles()
    }
}
