// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a surface of triangles go on where a box that repeats does? A wall has no periodic images: what a particle across the boundary
//! is to touch must be among the triangles.

use super::motion::Motion;
use super::wall::Wall;
use crate::geometry::box_tree::{BoxTree, Extent};
use crate::geometry::triangles::Triangle;
use crate::vector::Vector3;

/// A surface goes on where it comes as near to its image as this share of the particles' reach: the triangles of a round surface that goes
/// on need not be those of its image, and one that reaches beyond the box by nearly the reach serves all but the last of it.
const NEAR: f64 = 0.1;

/// A box along the world axes, which repeats in some of them.
#[derive(Clone, Copy, Debug)]
pub struct PeriodicBox {
    /// Its least coordinates.
    pub low: [f64; 3],
    /// Its greatest.
    pub high: [f64; 3],
    /// Whether it repeats along each axis.
    pub is_periodic: [bool; 3],
}

/// Where a surface ends at the boundary of a box that repeats.
#[derive(Clone, Copy, Debug)]
pub struct MissingImage {
    /// The axis along which the box repeats.
    pub axis: usize,
    /// The triangle whose image is missing, numbered as [`Wall::triangles`] gives them.
    pub triangle: usize,
    /// A place beyond the boundary, within the reach of particles in the box, where the image would be.
    pub place: Vector3,
}

impl Wall {
    /// The first place within `reach` of a box where the periodic image of a triangle in the box is not a part of the surface: a
    /// particle of that largest semi-axis touches nothing there, and what it touches on the other side of the box. `None` where the surface goes on, or does not
    /// come near the boundary.
    ///
    /// ```
    /// # use ellgran::vector::Vector3;
    /// # use ellgran::walls::{Mesh, MissingImage, Motion, PeriodicBox, Wall};
    /// // A floor of two triangles, in a box of length 2 along x.
    /// let floor = |end: f64| -> Result<Option<MissingImage>, String> {
    ///     let corner = |x: f64, y: f64| Vector3::new(x * end, 10.0 * y, 0.0);
    ///     let (a, b, c, d) = (corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0));
    ///     let mut wall = Wall::new();
    ///     wall.add_mesh(Mesh::new(vec![[a, b, c], [a, c, d]])?);
    ///     let domain = PeriodicBox {
    ///         low: [-1.0; 3],
    ///         high: [1.0; 3],
    ///         is_periodic: [true, false, false],
    ///     };
    ///     Ok(wall.missing_image(&Motion::REST, &domain, 0.1))
    /// };
    /// let missing = floor(1.0)?.expect("it ends where the box does");
    /// assert_eq!(missing.axis, 0);
    /// assert!(missing.place.x.abs() > 1.0);
    /// assert!(floor(1.1)?.is_none());
    /// # Ok::<(), String>(())
    /// ```
    pub fn missing_image(
        &self,
        motion: &Motion,
        domain: &PeriodicBox,
        reach: f64,
    ) -> Option<MissingImage> {
        let PeriodicBox {
            low,
            high,
            is_periodic,
        } = *domain;
        if !(reach > 0.0) || !is_periodic.contains(&true) {
            return None;
        }
        let triangles: Vec<Triangle> = self
            .triangles()
            .map(|t| t.map(|corner| motion.point_to_world(corner)))
            .collect();
        let surface = Surface::of(&triangles);
        for axis in (0..3).filter(|k| is_periodic[*k]) {
            let length = high[axis] - low[axis];
            // What lies within the reach of one end is to be beyond the other.
            let ends = [
                (low[axis], low[axis] + reach, length),
                (high[axis] - reach, high[axis], -length),
            ];
            for (from, to, shift) in ends {
                let mut near = Extent {
                    low: [f64::NEG_INFINITY; 3],
                    high: [f64::INFINITY; 3],
                };
                for k in (0..3).filter(|k| is_periodic[*k]) {
                    (near.low[k], near.high[k]) = (low[k] - reach, high[k] + reach);
                }
                (near.low[axis], near.high[axis]) = (from, to);
                for (index, triangle) in triangles.iter().enumerate() {
                    if !surface.boxes[index].overlaps(&near) {
                        continue;
                    }
                    let part = cut(triangle, &near);
                    if part.is_empty() {
                        continue;
                    }
                    let sum = part.iter().fold(Vector3::ZERO, |sum, p| sum + *p);
                    let middle = sum * (1.0 / part.len() as f64);
                    for point in part.iter().copied().chain([middle]) {
                        let mut image = point.to_array();
                        image[axis] += shift;
                        let place = Vector3::from_array(image);
                        if !surface.comes_near(place, NEAR * reach) {
                            return Some(MissingImage {
                                axis,
                                triangle: index,
                                place,
                            });
                        }
                    }
                }
            }
        }
        None
    }
}

struct Surface<'a> {
    triangles: &'a [Triangle],
    boxes: Vec<Extent>,
    tree: BoxTree,
}

impl<'a> Surface<'a> {
    fn of(triangles: &'a [Triangle]) -> Self {
        let boxes: Vec<Extent> = triangles.iter().map(super::mesh::around).collect();
        let mut tree = BoxTree::default();
        tree.build(&boxes);
        Surface {
            triangles,
            boxes,
            tree,
        }
    }

    /// Whether a triangle is within `distance` of a point.
    fn comes_near(&self, point: Vector3, distance: f64) -> bool {
        let mut found = false;
        let extent = Extent::about(point.to_array(), distance);
        self.tree.visit(&self.boxes, &extent, |index| {
            found = distance_squared(point, &self.triangles[index]) <= distance * distance;
            !found
        });
        found
    }
}

/// The corners of the part of a triangle that is in a box (I. Sutherland and G. Hodgman, Communications of the ACM 17, 32 (1974)).
fn cut(triangle: &Triangle, extent: &Extent) -> Vec<Vector3> {
    let mut polygon = triangle.to_vec();
    for k in 0..3 {
        for (bound, sign) in [(extent.low[k], 1.0), (extent.high[k], -1.0)] {
            if !bound.is_finite() {
                continue;
            }
            let depth = |p: Vector3| sign * (p.to_array()[k] - bound);
            let mut inside = Vec::with_capacity(polygon.len() + 1);
            for (a, b) in (0..polygon.len()).map(|n| (polygon[n], polygon[(n + 1) % polygon.len()]))
            {
                let (before, after) = (depth(a), depth(b));
                if before >= 0.0 {
                    inside.push(a);
                }
                if (before >= 0.0) != (after >= 0.0) {
                    inside.push(a + (b - a) * (before / (before - after)));
                }
            }
            polygon = inside;
        }
    }
    polygon
}

/// The square of the distance of a point from a triangle.
fn distance_squared(point: Vector3, triangle: &Triangle) -> f64 {
    let [a, b, c] = triangle.map(|corner| corner - point);
    let normal = (b - a).cross(c - a);
    let sides = [(a, b), (b, c), (c, a)];
    let square = normal.norm_squared();
    if square > 0.0 && sides.iter().all(|(p, q)| p.cross(*q).dot(normal) >= 0.0) {
        let height = a.dot(normal);
        return height * height / square;
    }
    (sides.iter())
        .map(|(p, q)| {
            let side = *q - *p;
            let length = side.norm_squared();
            let share = if length > 0.0 {
                (-p.dot(side) / length).clamp(0.0, 1.0)
            } else {
                0.0
            };
            (*p + side * share).norm_squared()
        })
        .fold(f64::INFINITY, f64::min)
}
