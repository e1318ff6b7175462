// SPDX-License-Identifier: MIT OR Apache-2.0
//! A surface of triangles as a wall. A body meets those whose boxes it meets, however many there are.

use super::near_triangles::{NearTriangles, Triangles};
use super::shape::{Ball, Block, Found, Grain, Search, Shape, ShapeInLanes};
use super::triangle_contacts::{place_of, surface};
use crate::contact::ranges::LARGEST_COORDINATE;
use crate::geometry::box_tree::{BoxTree, Extent};
use crate::geometry::edge_to_edge;
use crate::geometry::rounded_corners;
use crate::geometry::triangles::Triangle;
use crate::message::Numbers;
use crate::simd::Line;
use crate::vector::Vector3;

/// Triangles and the boxes around them.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Such as meet edge to edge.
    pub(super) triangles: Vec<Triangle>,
    /// Of which these are parts, where they are not the same.
    whole: Option<Whole>,
    pub(super) boxes: Vec<Extent>,
    pub(super) tree: BoxTree,
    /// How wide the flat piece is of which each triangle is a part.
    pub(super) widths: Vec<f64>,
    /// Of the particles that were looked at.
    near: NearTriangles,
}

/// The triangles of a mesh that were divided.
#[derive(Clone, Debug)]
struct Whole {
    triangles: Vec<Triangle>,
    /// Of each part.
    of_parts: Vec<u32>,
}

/// Contacts with the surface of one particle that are remembered.
pub(super) const REMEMBERED: usize = 8;

impl Mesh {
    /// From the corners of its triangles.
    ///
    /// # Errors
    /// No triangles, more than 2^32, or a corner that is not finite or too far away.
    pub fn new(triangles: Vec<Triangle>) -> Result<Self, String> {
        if triangles.is_empty() {
            return Err("the mesh has no triangles".into());
        }
        check_corners(&triangles)?;
        let (parts, widths) = edge_to_edge::parts_and_widths(&triangles);
        let (triangles, widths, whole) = match parts {
            None => (triangles, widths, None),
            Some(parts) => {
                let corners = parts.iter().map(|p| p.of_triangles(&triangles)).collect();
                let widths = parts.iter().map(|p| widths[p.of]).collect();
                let of_parts = parts.iter().map(|p| p.of as u32).collect();
                let whole = Whole {
                    triangles,
                    of_parts,
                };
                (corners, widths, Some(whole))
            }
        };
        if u32::try_from(triangles.len()).is_err() {
            return Err("the mesh has more triangles than 2^32".into());
        }
        let boxes: Vec<Extent> = triangles.iter().map(around).collect();
        let mut tree = BoxTree::default();
        tree.build(&boxes);
        Ok(Mesh {
            triangles,
            whole,
            boxes,
            tree,
            widths,
            near: NearTriangles::default(),
        })
    }

    /// How many triangles there are.
    pub fn triangle_count(&self) -> usize {
        Shape::triangles(self).len()
    }

    /// Whether the box of a triangle reaches into a box.
    fn has_within(&self, extent: &Extent) -> bool {
        let mut has = false;
        self.tree.visit(&self.boxes, extent, |_| {
            has = true;
            false
        });
        has
    }
}

/// Moves the corners of flat pieces of triangles back to their planes where they were rounded to few digits, as in a file, and returns the
/// largest way that one moved. Corners that are equal stay equal. Of numbers of more than nine decimal digits nothing is known, and nothing moves
/// (docs/theory.md, section 9: rounded corners).
///
/// ```
/// use ellgran::vector::Vector3;
/// use ellgran::walls::flatten_triangles;
///
/// // A square as four triangles about its middle, which the digits of a file have put a little too high.
/// let corner = |x: f64, y: f64| Vector3::new(x, y, 0.0);
/// let middle = Vector3::new(0.5, 0.5, 1e-7);
/// let around = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
/// let mut square = [0, 1, 2, 3].map(|k| [around[k], around[(k + 1) % 4], middle]);
/// let moved = flatten_triangles(&mut square)?;
/// assert!(moved > 1e-8 && moved < 2e-7);
/// let height = |p: Vector3| (p - square[0][0]).dot((square[0][1] - square[0][0]).cross(square[1][1] - square[0][0]));
/// assert!(square.iter().flatten().all(|p| height(*p).abs() < 1e-13));
/// # Ok::<(), String>(())
/// ```
///
/// # Errors
/// A corner that is not finite or too far away; then nothing is changed.
pub fn flatten_triangles(triangles: &mut [Triangle]) -> Result<f64, String> {
    check_corners(triangles)?;
    Ok(match rounded_corners::rounding(triangles) {
        Some(rounding) => rounded_corners::flatten(triangles, rounding),
        None => 0.0,
    })
}

/// Whether all corners are finite and not too far away.
///
/// # Errors
/// The first that is not.
pub(super) fn check_corners(triangles: &[Triangle]) -> Result<(), String> {
    for (index, corner) in triangles.iter().flatten().enumerate() {
        let p = corner.to_array();
        if !p.iter().all(|x| x.abs() <= LARGEST_COORDINATE) {
            return Err(format!(
                "corner {} of triangle {} of the mesh is at {}: out of range",
                index % 3 + 1,
                index / 3 + 1,
                Numbers(&p)
            ));
        }
    }
    Ok(())
}

pub(super) fn around(triangle: &Triangle) -> Extent {
    let corners = triangle.map(Vector3::to_array);
    let bound = |best: fn(f64, f64) -> f64| {
        core::array::from_fn(|k| best(best(corners[0][k], corners[1][k]), corners[2][k]))
    };
    Extent {
        low: bound(f64::min),
        high: bound(f64::max),
    }
}

/// The contacts of a particle with the triangles that `search.near` names, and which of them stands for each. `width` is that of the flat piece of
/// which a triangle is a part.
pub(super) fn touch_near(
    grain: &Grain<'_>,
    corners: impl Fn(usize) -> Triangle,
    width: impl Fn(usize) -> f64,
    search: &mut Search,
    found: &mut Found<'_>,
) {
    let near = &search.near;
    let corners = near.iter().map(|t| corners(*t as usize));
    let width = |k: usize| width(near[k] as usize);
    (search.triangles).touch_each(grain.body, grain.centre, corners, width);
    for contact in search.triangles.contacts() {
        found(&surface(contact), search.near[contact.triangle] as usize);
    }
}

impl Shape for Mesh {
    fn remembered(&self) -> usize {
        REMEMBERED
    }

    fn may_touch(&self, ball: &Ball) -> bool {
        let c = ball.centre.to_array();
        !(self.tree.extent()).is_none_or(|Extent { low, high }| {
            (0..3).any(|k| c[k] + ball.radius < low[k] || c[k] - ball.radius > high[k])
        })
    }

    fn may_touch_block(&self, block: &Block) -> bool {
        self.has_within(&block.extent())
    }

    /// Within the box of a mesh, which most particles are in a vessel, the triangles tell.
    fn mark_near(&mut self, balls: &[Ball], marks: &mut [bool]) {
        for (ball, mark) in balls.iter().zip(marks) {
            let Ball {
                particle,
                centre,
                radius,
            } = *ball;
            if let Some(reaches) = self.near.plane_reaches(particle, centre, radius) {
                *mark |= reaches;
                continue;
            }
            *mark |= self.may_touch(ball) && {
                let finite = (centre.x + centre.y + centre.z + radius).is_finite();
                let triangles = Triangles {
                    all: &self.triangles,
                    boxes: &self.boxes,
                    tree: &self.tree,
                };
                let ball_of = (centre, radius);
                !finite || self.near.may_reach(particle, ball_of, triangles)
            };
        }
    }

    fn in_lanes(&self) -> Option<ShapeInLanes> {
        Some(ShapeInLanes::PlaneInPlaces)
    }

    fn flat_places(&self) -> &[Line] {
        self.near.flat_places()
    }

    fn touch(&self, grain: &Grain<'_>, search: &mut Search, found: &mut Found<'_>) {
        let extent = place_of(grain);
        search.near.clear();
        if let Some(near) = self.near.around(grain.particle, &extent) {
            let reach_in = |t: &&u32| self.boxes[**t as usize].overlaps(&extent);
            search.near.extend(near.iter().filter(reach_in));
        } else {
            self.tree.visit(&self.boxes, &extent, |triangle| {
                search.near.push(triangle as u32);
                true
            });
            // in the order of the triangles, whatever the tree is
            search.near.sort_unstable();
        }
        if !search.near.is_empty() {
            let width = |triangle: usize| self.widths[triangle];
            let corners = |triangle: usize| self.triangles[triangle];
            match &self.whole {
                None => touch_near(grain, corners, width, search, found),
                Some(whole) => touch_near(grain, corners, width, search, &mut |surface, part| {
                    found(surface, whole.of_parts[part] as usize);
                }),
            }
        }
    }

    fn triangles(&self) -> &[Triangle] {
        match &self.whole {
            None => &self.triangles,
            Some(whole) => &whole.triangles,
        }
    }
}
