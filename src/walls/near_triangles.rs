// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which triangles of a mesh are near each particle? Found once for a place a little larger than the particle needs, and found again when
//! it has left that place. Where the surface is nothing but a plane there, that is kept, too.
//!
//! What is kept is right for whatever is in the place, so it does not matter whether a particle has the index that it had.

use super::triangle_contacts::{reach_of_ball, InBall, MARGIN};
use crate::geometry::box_tree::{BoxTree, Extent};
use crate::geometry::flat_place::FlatPlace;
use crate::geometry::triangle::{Near, Triangle};
use crate::geometry::triangle_places::REACH;
use crate::simd::Line;
use crate::vector::Vector3;

/// By this share of a particle's radius its place is larger. A larger one is left more seldom, and has more triangles to look at in each
/// step: per step the search costs in proportion to `1/s`, the triangles of a surface to `(1 + s)^2`, a sum that is flat about its least value: were
/// 0.25 the best `s`, half and twice of it would cost 15 and 17 % more.
const SPARE: f64 = 0.25;
/// The same where no triangle is near, and a larger place has none to look at: the search is then repeated after a way of two radii, which in a
/// dense flow is after thousands of steps.
const SPARE_WITHOUT: f64 = 2.0;
/// Indices that are no longer in use are kept up to as many as there are in use, and so many more, a page of 16 KiB of them, so that few
/// particles do not have all places found anew again and again.
const LEAST: usize = 4096;

/// Where a mesh is no plane.
pub(super) const NOT_FLAT: Line = Line(FlatPlace::NONE);

/// Lists of triangles, by the indices of the particles.
#[derive(Clone, Debug, Default)]
pub(super) struct NearTriangles {
    places: Vec<Place>,
    /// The balls in them in which the mesh is a plane, as numbers of [`FlatPlace`]; [`NOT_FLAT`] where it is none.
    flat: Vec<Line>,
    triangles: Vec<u32>,
    /// How many of them belong to a place.
    used: usize,
    /// Memory of the search for planes.
    memory: Vec<Near>,
}

/// The triangles of a mesh, in a tree by their boxes.
#[derive(Clone, Copy)]
pub(super) struct Triangles<'a> {
    pub(super) all: &'a [Triangle],
    pub(super) boxes: &'a [Extent],
    pub(super) tree: &'a BoxTree,
}

#[derive(Clone, Copy, Debug)]
struct Place {
    extent: Extent,
    from: usize,
    count: usize,
}

impl Place {
    /// That contains nothing.
    const NONE: Place = Place {
        extent: Extent {
            low: [f64::INFINITY; 3],
            high: [f64::NEG_INFINITY; 3],
        },
        from: 0,
        count: 0,
    };
}

impl NearTriangles {
    /// The triangles whose boxes reach into the place of a particle, in ascending order, if that contains `extent`.
    pub fn around(&self, particle: usize, extent: &Extent) -> Option<&[u32]> {
        let place = self.places.get(particle)?;
        let inside = place.extent.contains(extent);
        inside.then(|| &self.triangles[place.from..place.from + place.count])
    }

    /// Where the mesh is a plane, by the indices of the particles, of those that were looked at: numbers of
    /// [`FlatPlace`].
    pub fn flat_places(&self) -> &[Line] {
        &self.flat
    }

    /// Whether the plane that the mesh is to all that a ball holds comes into the ball, if it is one there and that is known. Not of a ball
    /// of which a number is not finite.
    #[inline(always)]
    pub fn plane_reaches(&self, particle: usize, centre: Vector3, radius: f64) -> Option<bool> {
        let flat = FlatPlace::of(self.flat.get(particle)?.0);
        let height = flat.height_of(centre, radius)?;
        Some(height.abs() < reach_of_ball(radius))
    }

    /// Whether triangles may reach into a ball of a finite centre and radius. What is found is kept.
    pub fn may_reach(
        &mut self,
        particle: usize,
        (centre, radius): (Vector3, f64),
        triangles: Triangles<'_>,
    ) -> bool {
        if let Some(reaches) = self.plane_reaches(particle, centre, radius) {
            return reaches;
        }
        let needed = Extent::about(centre.to_array(), radius * (REACH + MARGIN));
        let place = self.places.get(particle);
        let was_plane = self.flat.get(particle).is_some_and(|f| *f != NOT_FLAT);
        // A plane is worth looking for it again.
        if was_plane || place.is_none_or(|p| !p.extent.contains(&needed)) {
            self.find(particle, (centre, radius), triangles);
            // A call that is repeated gets the same answer.
            if let Some(reaches) = self.plane_reaches(particle, centre, radius) {
                return reaches;
            }
        }
        let ball = InBall::new(centre, radius);
        let near = self.around(particle, &needed).unwrap_or(&[]);
        near.iter().any(|t| {
            let t = *t as usize;
            triangles.boxes[t].overlaps(&ball.extent) && ball.may_have(&triangles.all[t])
        })
    }

    fn find(
        &mut self,
        particle: usize,
        (centre, radius): (Vector3, f64),
        triangles: Triangles<'_>,
    ) {
        if self.places.len() <= particle {
            self.places.resize(particle + 1, Place::NONE);
            self.flat.resize(particle + 1, NOT_FLAT);
        }
        self.used -= self.places[particle].count;
        if self.triangles.len() > 2 * self.used + LEAST {
            self.places.fill(Place::NONE);
            self.flat.fill(NOT_FLAT);
            self.triangles.clear();
            self.used = 0;
        }
        let from = self.triangles.len();
        for spare in [SPARE_WITHOUT, SPARE] {
            let extent = Extent::about(centre.to_array(), radius * (1.0 + spare));
            let near = &mut self.triangles;
            near.truncate(from);
            triangles.tree.visit(triangles.boxes, &extent, |triangle| {
                near.push(triangle as u32);
                true
            });
            let count = near.len() - from;
            self.places[particle] = Place {
                extent,
                from,
                count,
            };
            if count == 0 {
                break;
            }
        }
        // In the order of the triangles, whatever the tree is.
        let near = &mut self.triangles[from..];
        near.sort_unstable();
        self.used += near.len();
        let mut flat = None;
        if !near.is_empty() {
            let corners = near.iter().map(|t| triangles.all[*t as usize]);
            let reach = radius * (1.0 + SPARE);
            flat = FlatPlace::find(centre, reach, corners, &mut self.memory);
        }
        self.flat[particle] = flat.map_or(NOT_FLAT, |place| Line(place.numbers()));
    }
}
