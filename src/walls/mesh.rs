// SPDX-License-Identifier: MIT OR Apache-2.0
//! A surface of triangles as a wall. A body meets those whose boxes it meets, however many there are.

use super::bounding_boxes::BoundingBoxes;
use super::plane::flat;
use super::shape::{Search, Shape};
use crate::contact::ranges::LARGEST_COORDINATE;
use crate::contact::staged::WallSurface;
use crate::geometry::triangles::{Feature, Triangle, TriangleContact};
use crate::geometry::Ellipsoid;
use crate::message::Numbers;
use crate::vector::Vector3;

/// Triangles and the boxes around them.
#[derive(Clone, Debug)]
pub struct Mesh {
    triangles: Vec<Triangle>,
    boxes: BoundingBoxes,
}

/// Contacts with the surface of one particle that are remembered.
const REMEMBERED: usize = 8;

impl Mesh {
    /// From the corners of its triangles.
    ///
    /// # Errors
    /// No triangles, more than 2^32, or a corner that is not finite or too far away.
    pub fn new(triangles: Vec<Triangle>) -> Result<Self, String> {
        if triangles.is_empty() {
            return Err("the mesh has no triangles".into());
        }
        if u32::try_from(triangles.len()).is_err() {
            return Err("the mesh has more triangles than 2^32".into());
        }
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
        Ok(Mesh {
            boxes: BoundingBoxes::new(&triangles),
            triangles,
        })
    }

    /// How many triangles there are.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }
}

/// What a contact with triangles is for the law: an edge or a corner is taken as flat.
fn surface(c: &TriangleContact) -> WallSurface {
    let face = WallSurface {
        share: c.share,
        ..flat(c.point, c.normal)
    };
    match c.feature {
        Feature::Face => face,
        Feature::Edge(along) => WallSurface {
            direction: along.cross(c.normal),
            turning_radii: [0.0, f64::INFINITY],
            ..face
        },
        Feature::Corner => WallSurface {
            turning_radii: [0.0; 2],
            ..face
        },
    }
}

impl Shape for Mesh {
    fn remembered(&self) -> usize {
        REMEMBERED
    }

    fn may_touch(&self, centre: Vector3, radius: f64) -> bool {
        let (low, high) = self.boxes.whole();
        let c = centre.to_array();
        !(0..3).any(|k| c[k] + radius < low[k] || c[k] - radius > high[k])
    }

    fn touch(
        &self,
        body: &Ellipsoid,
        centre: Vector3,
        search: &mut Search,
        found: &mut dyn FnMut(WallSurface),
    ) {
        // A little more than the body's own box: triangles that meet within a hundred-thousandth of its size count as joined.
        let margin = 1e-4 * body.smallest_semi_axis();
        let reach = [
            Vector3::new(1.0, 0.0, 0.0),
            Vector3::new(0.0, 1.0, 0.0),
            Vector3::new(0.0, 0.0, 1.0),
        ]
        .map(|e| body.support(e).h + margin);
        let c = centre.to_array();
        let low = core::array::from_fn(|k| c[k] - reach[k]);
        let high = core::array::from_fn(|k| c[k] + reach[k]);
        self.boxes.meeting(low, high, &mut search.near);
        if search.near.is_empty() {
            return;
        }
        search.corners.clear();
        let near = search.near.iter().map(|t| self.triangles[*t as usize]);
        search.corners.extend(near);
        search.triangles.touch(body, centre, &search.corners);
        for contact in search.triangles.contacts() {
            found(surface(contact));
        }
    }

    fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    fn touched_triangle(&self, search: &Search, contact: usize) -> Option<usize> {
        let contact = search.triangles.contacts().get(contact)?;
        Some(search.near[contact.triangle] as usize)
    }
}
