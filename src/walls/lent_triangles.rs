// SPDX-License-Identifier: MIT OR Apache-2.0
//! Triangles that an engine keeps, moves and spreads over its ranks itself: it lends those of a step, and its lists of those near each
//! particle.

use super::mesh::{check_corners, touch_near, REMEMBERED};
use super::shape::{Ball, Found, Grain, Search, Shape};
use crate::contact::ranges::LARGEST_VELOCITY;
use crate::contact::staged::WallSurface;
use crate::geometry::edge_to_edge::{self, Part};
use crate::geometry::flat_pieces;
use crate::geometry::triangles::{barycentric_weights, Triangle};
use crate::message::Numbers;
use crate::vector::Vector3;
use std::sync::OnceLock;

/// The triangles of a step. Its memory is kept from step to step.
#[derive(Clone, Debug, Default)]
pub struct LentTriangles {
    corners: Vec<Triangle>,
    /// Velocities of the corners; empty for triangles at rest.
    velocities: Vec<[Vector3; 3]>,
    /// What those at the step have more; empty where they are the same.
    changes: Vec<[Vector3; 3]>,
    /// Where the list of each particle begins in `near`, and at last where the last one ends.
    starts: Vec<usize>,
    near: Vec<u32>,
    /// Found when a particle first asks; kept while the triangles move as one body.
    surface: OnceLock<Surface>,
}

/// How the triangles are one surface.
#[derive(Clone, Debug)]
struct Surface {
    /// Of each triangle; what a motion of all leaves as it is.
    sizes: Vec<[f64; 4]>,
    /// The triangles in parts that meet edge to edge, where they do not so themselves.
    parts: Option<Parts>,
    /// How wide the flat piece is of which each triangle is a part.
    widths: OnceLock<Vec<f64>>,
}

#[derive(Clone, Debug)]
struct Parts {
    all: Vec<Part>,
    /// Where those of each triangle begin, and at last where the last ones end.
    starts: Vec<u32>,
}

/// By this share of its largest one the sizes of a triangle may change by rounding.
const ROUNDING: f64 = 1e-9;

/// The squares of the sides of a triangle, and of the way to it from the one before.
fn sizes(corners: &[Triangle]) -> impl Iterator<Item = [f64; 4]> + '_ {
    let mut last = corners.first().map_or(Vector3::ZERO, |t| t[0]);
    corners.iter().map(move |&[a, b, c]| {
        let ways = [b - a, c - b, a - c, a - last];
        last = a;
        ways.map(Vector3::norm_squared)
    })
}

impl Surface {
    fn of(corners: &[Triangle]) -> Self {
        let parts = edge_to_edge::parts(corners).map(|all| {
            let starts = (0..=corners.len()).map(|t| all.partition_point(|p| p.of < t) as u32);
            Parts {
                starts: starts.collect(),
                all,
            }
        });
        Surface {
            sizes: sizes(corners).collect(),
            parts,
            widths: OnceLock::new(),
        }
    }

    /// Whether these are the same triangles after a motion of all.
    fn is_of(&self, corners: &[Triangle]) -> bool {
        let equal = |own: &[f64; 4], other: [f64; 4]| {
            let largest = own.iter().fold(0.0f64, |m, x| m.max(*x));
            (own.iter().zip(other)).all(|(x, y)| (x - y).abs() <= ROUNDING * largest)
        };
        self.sizes.len() == corners.len()
            && (self.sizes.iter().zip(sizes(corners))).all(|(own, other)| equal(own, other))
    }
}

impl LentTriangles {
    /// Takes the triangles of a step in place of those before. Particle `k` is near the triangles `near[starts[k]..starts[k + 1]]`;
    /// particles beyond the end of `starts` are near none. `velocities` are those of the corners, or empty, and `changes` what those at
    /// the step have more, or empty.
    ///
    /// # Errors
    /// A corner or a velocity that is not finite or too large, or lists that do not fit the triangles; then there are none.
    pub fn set(
        &mut self,
        corners: impl Iterator<Item = Triangle>,
        velocities: impl Iterator<Item = [Vector3; 3]>,
        changes: impl Iterator<Item = [Vector3; 3]>,
        starts: &[usize],
        near: &[u32],
    ) -> Result<(), String> {
        let LentTriangles {
            corners: own,
            velocities: own_velocities,
            changes: own_changes,
            ..
        } = self;
        own.clear();
        own.extend(corners);
        own_velocities.clear();
        own_velocities.extend(velocities);
        own_changes.clear();
        own_changes.extend(changes);
        self.starts.clear();
        self.starts.extend_from_slice(starts);
        self.near.clear();
        self.near.extend_from_slice(near);
        let checked = self.check();
        let surface = self.surface.get();
        if surface.is_some_and(|s| checked.is_err() || !s.is_of(&self.corners)) {
            self.surface.take();
        }
        if checked.is_err() {
            self.starts.clear();
        }
        checked
    }

    fn check(&self) -> Result<(), String> {
        check_corners(&self.corners)?;
        let fast = |v: &Vector3| !v.to_array().iter().all(|x| x.abs() <= LARGEST_VELOCITY);
        let mut all = self.velocities.iter().chain(&self.changes).flatten();
        if let Some(v) = all.find(|v| fast(v)) {
            return Err(format!(
                "a corner of the triangles moves with {}: out of range",
                Numbers(&v.to_array())
            ));
        }
        let rises = self.starts.windows(2).all(|w| w[0] <= w[1]);
        if !rises || self.starts.last().is_some_and(|end| *end > self.near.len()) {
            return Err("near_starts must not fall, nor exceed the length of near".into());
        }
        let count = self.corners.len();
        match self.near.iter().find(|t| **t as usize >= count) {
            Some(t) => Err(format!("near names triangle {t} of {count}")),
            None => Ok(()),
        }
    }

    fn near(&self, particle: usize) -> &[u32] {
        match self.starts.get(particle..particle + 2) {
            Some(ends) => &self.near[ends[0]..ends[1]],
            None => &[],
        }
    }
}

impl Shape for LentTriangles {
    fn remembered(&self) -> usize {
        REMEMBERED
    }

    fn moves(&self) -> bool {
        !(self.velocities.is_empty() && self.changes.is_empty())
    }

    fn may_touch(&self, ball: &Ball) -> bool {
        !self.near(ball.particle).is_empty()
    }

    fn touch(&self, grain: &Grain<'_>, search: &mut Search, found: &mut Found<'_>) {
        let corners = &self.corners;
        let surface = self.surface.get_or_init(|| Surface::of(corners));
        let width = |triangle: usize| {
            let widths = surface.widths.get_or_init(|| flat_pieces::widths(corners));
            widths[triangle]
        };
        let near = self.near(grain.particle);
        search.near.clear();
        let mut found = |surface: &WallSurface, triangle: usize| {
            let [velocity, velocity_change] = [&self.velocities, &self.changes].map(|all| {
                all.get(triangle).map_or(Vector3::ZERO, |v| {
                    let [a, b, c] = barycentric_weights(&self.corners[triangle], surface.point);
                    v[0] * a + v[1] * b + v[2] * c
                })
            });
            found(
                &WallSurface {
                    velocity,
                    velocity_change,
                    ..*surface
                },
                triangle,
            );
        };
        let Some(parts) = &surface.parts else {
            search.near.extend_from_slice(near);
            let corners = |triangle: usize| corners[triangle];
            return touch_near(grain, corners, width, search, &mut found);
        };
        for t in near {
            let t = *t as usize;
            search.near.extend(parts.starts[t]..parts.starts[t + 1]);
        }
        let corners = |part: usize| parts.all[part].of_triangles(corners);
        let width = |part: usize| width(parts.all[part].of);
        touch_near(grain, corners, width, search, &mut |surface, part| {
            found(surface, parts.all[part].of);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::super::mesh::Mesh;
    use super::*;
    use crate::geometry::Ellipsoid;
    use core::iter::empty;

    /// A square with a corner in the middle of the longest side of its first triangle, bent along that side.
    fn bent() -> [Triangle; 3] {
        let at = |x: f64, y: f64| Vector3::new(x, y, 0.1 * x.max(0.0));
        [
            [at(0.0, -2.0), at(0.0, 2.0), at(-3.0, 0.0)],
            [at(0.0, -2.0), at(3.0, 0.0), at(0.0, 0.0)],
            [at(0.0, 0.0), at(3.0, 0.0), at(0.0, 2.0)],
        ]
    }

    /// The triangle that a ball of radius 1 touches deepest that is a hundredth deep at a place.
    fn touched(shape: &dyn Shape, x: f64, y: f64) -> usize {
        let body = Ellipsoid::new([1.0; 3], [1.0, 0.0, 0.0, 0.0]).unwrap();
        let normal = Vector3::new(if x > 0.0 { -0.1 } else { 0.0 }, 0.0, 1.0).normalised();
        let grain = Grain {
            particle: 0,
            body: &body,
            centre: Vector3::new(x, y, 0.1 * x.max(0.0)) + normal * 0.99,
        };
        let mut all = Vec::new();
        shape.touch(&grain, &mut Search::default(), &mut |surface, triangle| {
            all.push((surface.point, triangle));
        });
        assert!(!all.is_empty());
        all[0].1
    }

    fn set(lent: &mut LentTriangles, all: &[Triangle], lists: (&[usize], &[u32])) {
        let all = all.iter().copied();
        lent.set(all, empty(), empty(), lists.0, lists.1).unwrap();
    }

    const PLACES: [(f64, f64, usize); 4] = [
        (-1.0, 0.3, 0),
        (-1.0, -0.3, 0),
        (1.0, -0.3, 1),
        (1.0, 0.3, 2),
    ];

    #[test]
    fn contacts_are_with_the_triangles_that_were_given() {
        let mesh = Mesh::new(bent().to_vec()).unwrap();
        assert_eq!(Shape::triangles(&mesh), bent());
        assert_eq!(mesh.triangle_count(), 3);
        assert_eq!(mesh.triangles.len(), 4);
        let mut lent = LentTriangles::default();
        set(&mut lent, &bent(), (&[0, 3], &[0, 1, 2]));
        for (x, y, expected) in PLACES {
            assert_eq!(touched(&mesh, x, y), expected);
            assert_eq!(touched(&lent, x, y), expected);
        }
    }

    /// At once, also where the lists stay as they are.
    #[test]
    fn other_triangles_are_divided_anew() {
        let [a, b, c] = bent();
        for (order, names) in [([2, 0, 1], [1, 2, 0]), ([1, 2, 0], [2, 0, 1])] {
            let mut lent = LentTriangles::default();
            set(&mut lent, &[a, b, c], (&[0, 3], &[0, 1, 2]));
            touched(&lent, 1.0, 0.3);
            assert!(lent.surface.get().is_some());
            let others: [Triangle; 3] = order.map(|k: usize| bent()[k]);
            set(&mut lent, &others, (&[0, 3], &[0, 1, 2]));
            for (x, y, expected) in PLACES {
                assert_eq!(touched(&lent, x, y), names[expected]);
            }
        }
        // And those that only move stay as they are.
        let mut lent = LentTriangles::default();
        set(&mut lent, &[a, b, c], (&[0, 3], &[0, 1, 2]));
        touched(&lent, 1.0, 0.3);
        for step in 0..100 {
            let by = Vector3::new(0.1, 0.2, -0.3) * step as f64;
            let near: &[u32] = if step % 5 == 0 {
                &[2, 1, 0]
            } else {
                &[0, 1, 2]
            };
            let moved = bent().map(|t| t.map(|p| p + by));
            set(&mut lent, &moved, (&[0, 3], near));
            assert!(lent.surface.get().is_some());
        }
    }
}
