// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which triangles of a mesh are near each particle? Found once for a place a little larger than the particle needs, and found again when
//! it has left that place.
//!
//! What is kept is right for whatever is in the place, so it does not matter whether a particle has the index that it had.

use crate::geometry::box_tree::{BoxTree, Extent};

/// By this share of a particle's radius its place is larger. A larger one is left more seldom, and has more triangles to look at in each
/// step.
const SPARE: f64 = 0.25;
/// The same where no triangle is near.
const SPARE_WITHOUT: f64 = 2.0;
/// A search may ask for a place that is larger than the particle by this share of its radius.
const MARGIN: f64 = 2e-4;
/// Indices that are no longer in use are kept up to as many as there are in use, and so many more.
const LEAST: usize = 4096;

/// Lists of triangles, by the indices of the particles.
#[derive(Clone, Debug, Default)]
pub(super) struct NearTriangles {
    places: Vec<Place>,
    triangles: Vec<u32>,
    /// How many of them belong to a place.
    used: usize,
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

    /// Whether the box of a triangle reaches into that of a ball of a finite centre and radius. What is found is kept.
    pub fn has_within(
        &mut self,
        particle: usize,
        (centre, radius): ([f64; 3], f64),
        (tree, boxes): (&BoxTree, &[Extent]),
    ) -> bool {
        let needed = Extent::about(centre, radius * (1.0 + MARGIN));
        if self.around(particle, &needed).is_none() {
            self.find(particle, (centre, radius), (tree, boxes));
        }
        let ball = Extent::about(centre, radius);
        let near = self.around(particle, &needed).unwrap_or(&[]);
        near.iter().any(|t| boxes[*t as usize].overlaps(&ball))
    }

    fn find(
        &mut self,
        particle: usize,
        (centre, radius): ([f64; 3], f64),
        (tree, boxes): (&BoxTree, &[Extent]),
    ) {
        if self.places.len() <= particle {
            self.places.resize(particle + 1, Place::NONE);
        }
        self.used -= self.places[particle].count;
        if self.triangles.len() > 2 * self.used + LEAST {
            self.places.fill(Place::NONE);
            self.triangles.clear();
            self.used = 0;
        }
        let from = self.triangles.len();
        for spare in [SPARE_WITHOUT, SPARE] {
            let extent = Extent::about(centre, radius * (1.0 + spare));
            let near = &mut self.triangles;
            near.truncate(from);
            tree.visit(boxes, &extent, |triangle| {
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
        self.triangles[from..].sort_unstable();
        self.used += self.places[particle].count;
    }
}
