// SPDX-License-Identifier: MIT OR Apache-2.0
//! Triangles that an engine keeps, moves and spreads over its ranks itself: it lends those of a step, and its lists of those near each
//! particle.

use super::mesh::{check_corners, touch_near, REMEMBERED};
use super::shape::{Ball, Found, Grain, Search, Shape};
use crate::contact::ranges::LARGEST_VELOCITY;
use crate::contact::staged::WallSurface;
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
    widths: OnceLock<Widths>,
}

/// How wide the flat piece is of which each triangle is a part.
#[derive(Clone, Debug)]
struct Widths {
    of_triangles: Vec<f64>,
    /// Of each triangle; what a motion of all leaves as it is.
    sizes: Vec<[f64; 4]>,
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

impl Widths {
    fn of(corners: &[Triangle]) -> Self {
        Widths {
            of_triangles: flat_pieces::widths(corners),
            sizes: sizes(corners).collect(),
        }
    }

    fn are_of(&self, corners: &[Triangle]) -> bool {
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
        let widths = self.widths.get();
        if widths.is_some_and(|w| checked.is_err() || !w.are_of(&self.corners)) {
            self.widths.take();
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
        search.near.clear();
        search.near.extend_from_slice(self.near(grain.particle));
        let corners = &self.corners;
        let width = |triangle: usize| {
            let widths = self.widths.get_or_init(|| Widths::of(corners));
            widths.of_triangles[triangle]
        };
        touch_near(grain, corners, width, search, &mut |surface, triangle| {
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
        });
    }
}
