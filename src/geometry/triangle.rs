// SPDX-License-Identifier: MIT OR Apache-2.0
//! One triangle seen from a body's centre: where its plane is, what of it is in the body, whether it has a point, and whether it meets or
//! hides another.

use super::ellipsoid::{Ellipsoid, Support};
use super::facet_shares::SupportingPlane;
#[cfg(not(feature = "std"))]
use crate::real::Real;
use crate::vector::{Tangent, Vector2, Vector3};

/// Three corners.
pub type Triangle = [Vector3; 3];

/// Sine of an angle that is taken as zero: far above the rounding of a normal from corners, far below an angle of a real mesh.
pub(super) const TOLERANCE: f64 = 1e-9;

/// Triangles meet where they are closer than this share of the smallest semi-axis: smaller gaps, steps and slivers are
/// taken as flaws of the mesh. Above the rounding of single precision (6e-8 of a coordinate) for meshes up to a hundred
/// times as large as the semi-axis.
pub(super) const MEETING: f64 = 1e-5;

/// A triangle that may touch, with the body's centre as the origin.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct Near {
    pub index: usize,
    pub corners: Triangle,
    /// Towards the body's centre.
    pub normal: Vector3,
    /// Distance of the centre from its plane.
    pub distance: f64,
    /// Another triangle of the same plane, on the way to the one that stands for all that continue one another in it.
    pub plane: usize,
}

impl Near {
    /// No triangle.
    pub(super) const NONE: Near = Near {
        index: 0,
        corners: [Vector3::ZERO; 3],
        normal: Vector3::ZERO,
        distance: 0.0,
        plane: 0,
    };

    /// A triangle, seen from `centre`; `None` for one that is narrower than `meeting`, or not finite.
    pub fn new(index: usize, triangle: &Triangle, centre: Vector3, meeting: f64) -> Option<Near> {
        let corners = triangle.map(|p| p - centre);
        Near::with_normal(index, corners, across(&corners), meeting)
    }

    /// The same of corners from the centre, and what [`across`] says of them.
    #[inline(always)]
    pub fn with_normal(
        index: usize,
        corners: Triangle,
        (across, longest): (Vector3, f64),
        meeting: f64,
    ) -> Option<Near> {
        let twice_area = across.norm_squared().sqrt();
        if !(twice_area > meeting * longest.sqrt() && twice_area.is_finite()) {
            return None;
        }
        let mut normal = across * (1.0 / twice_area);
        let nearest = (0..3).fold(0, |m, k| {
            let closer = corners[k].norm_squared() < corners[m].norm_squared();
            if closer {
                k
            } else {
                m
            }
        });
        let mut distance = -normal.dot(corners[nearest]);
        if distance < 0.0 {
            (normal, distance) = (-normal, -distance);
        }
        Some(Near {
            index,
            corners,
            normal,
            distance,
            plane: 0,
        })
    }

    /// Whether another triangle has the edge between these two corners of this one too, and lies beyond it.
    pub fn is_continued_by(&self, other: &Near, a: Vector3, b: Vector3) -> bool {
        let third = |t: &Near| t.corners.into_iter().find(|p| *p != a && *p != b);
        let across = (b - a).cross(self.normal);
        let side = |p: Vector3| across.dot(p - a);
        let has = |p: Vector3| other.corners.contains(&p);
        has(a)
            && has(b)
            && third(self)
                .zip(third(other))
                .is_some_and(|(p, q)| side(p) * side(q) < 0.0)
    }

    /// Whether the triangle passes within `margin` of a point.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn has(&self, p: Vector3, margin: f64) -> bool {
        let tangent = Tangent::new(self.normal);
        let place = self.corners.map(|c| tangent.components(c - p));
        let nearest = combine(&self.corners, nearest_to_origin(place));
        (nearest - p).norm_squared() <= margin * margin
    }

    /// Whether the way from the body's centre to a point of another triangle passes through this one, and that other lies behind
    /// this one's plane as a whole. A larger one, on which this one stands, goes on in front of it.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn stands_before(&self, other: &Near, seen: Vector3, meeting: f64) -> bool {
        let height = |p: Vector3| self.normal.dot(p) + self.distance;
        let depth = -height(seen);
        depth > TOLERANCE * seen.norm()
            && other.corners.iter().all(|&p| height(p) <= meeting)
            && self.has(seen * (self.distance / (self.distance + depth)), meeting)
    }

    /// Whether two triangles that meet are of one plane, up to an angle of this sine.
    pub fn is_in_plane_of(&self, other: &Near, largest: f64, sine: f64) -> bool {
        (self.normal - other.normal).norm_squared() <= sine * sine
            && self.corners.iter().any(|p| {
                let height = other.normal.dot(*p) + other.distance;
                height.abs() <= 1e-12 * largest
            })
    }

    /// Whether the body's deepest point and all of the plane's section with it are within the borders of the triangle, by more than
    /// `meeting`.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn borders_are_clear(
        &self,
        body: &Ellipsoid,
        support: &Support,
        foot: Vector3,
        meeting: f64,
    ) -> bool {
        // The middle of the section, and the square by which it is smaller than that through the body's centre.
        let shrink = self.distance * support.inverse_h;
        let middle = support.point * shrink;
        let size = 1.0 - shrink * shrink;
        (0..3).all(|k| {
            let (from, to, across) = (
                self.corners[k],
                self.corners[(k + 1) % 3],
                self.corners[(k + 2) % 3],
            );
            let Some(mut out) = (to - from).cross(self.normal).direction() else {
                return false;
            };
            if out.dot(across - from) > 0.0 {
                out = -out;
            }
            let scaled = body.semi_axes.componentwise(body.to_body(out));
            let along = out.dot(support.point);
            let square = size * (scaled.norm_squared() - along * along);
            let room = out.dot(from) - meeting;
            room > out.dot(foot) && room > out.dot(middle) + square.max(0.0).sqrt()
        })
    }

    /// Its least height.
    pub fn height(&self) -> f64 {
        let (across, longest) = across(&self.corners);
        (across.norm_squared() / longest).sqrt()
    }

    /// The planes through its sides across it, which leave of its own plane what it covers.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn borders(&self) -> [SupportingPlane; 3] {
        core::array::from_fn(|k| {
            let [from, to, across] = [0, 1, 2].map(|m| self.corners[(k + m) % 3]);
            let inwards = self.normal.cross(to - from).normalised();
            let normal = if inwards.dot(across - from) < 0.0 {
                -inwards
            } else {
                inwards
            };
            SupportingPlane {
                point: from,
                normal,
            }
        })
    }

    /// Whether a part of the triangle is in the body.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn is_in_section(&self, body: &Ellipsoid, support: &Support, penetration: f64) -> bool {
        let below = penetration * support.inverse_h;
        let (_, nearest) = self.nearest(body, support, Vector3::ZERO);
        nearest.dot(nearest) < below * (2.0 - below)
    }

    /// The point of the triangle nearest to a point of its plane in the measure of the plane's section with the body.
    pub fn nearest_to(&self, body: &Ellipsoid, support: &Support, foot: Vector3) -> Vector3 {
        combine(&self.corners, self.nearest(body, support, foot).0)
    }

    /// The weights of that point, and its place from `middle` where the body is the unit sphere, along the plane.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn nearest(&self, body: &Ellipsoid, support: &Support, middle: Vector3) -> ([f64; 3], Vector2) {
        let m = body.semi_axes.componentwise(support.local_normal) * support.inverse_h;
        let frame = Tangent::new(m);
        let place = self.corners.map(|p| {
            let unit = body.to_body(p - middle);
            frame.components(body.inverse_semi_axes.componentwise(unit))
        });
        let weights = nearest_to_origin(place);
        let nearest = place[0] * weights[0] + place[1] * weights[1] + place[2] * weights[2];
        (weights, nearest)
    }

    /// Whether two triangles come within `margin` of each other: at a corner of one, or where a side of one passes through the
    /// other.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn meets(&self, other: &Near, margin: f64) -> bool {
        let touches = |t: &Near, q: &Near| {
            let heights = q.corners.map(|p| t.normal.dot(p) + t.distance);
            (0..3).any(|k| {
                if heights[k].abs() <= margin && t.has(q.corners[k], margin) {
                    return true;
                }
                let next = (k + 1) % 3;
                if heights[k] * heights[next] >= 0.0 {
                    return false;
                }
                let place = heights[k] / (heights[k] - heights[next]);
                t.has(
                    q.corners[k] + (q.corners[next] - q.corners[k]) * place,
                    margin,
                )
            })
        };
        touches(self, other) || touches(other, self)
    }
}

/// A vector across a triangle, as long as twice its area, and the square of its longest side.
#[inline(always)]
pub(super) fn across(corners: &Triangle) -> (Vector3, f64) {
    let sides: [Vector3; 3] = core::array::from_fn(|k| corners[(k + 1) % 3] - corners[k]);
    // The two shorter sides: of a long triangle the third has lost digits.
    let lengths = sides.map(|e| e.norm_squared());
    let longest = (0..3).fold(0, |m, k| if lengths[k] > lengths[m] { k } else { m });
    let across = sides[(longest + 1) % 3].cross(sides[(longest + 2) % 3]);
    (across, lengths[longest])
}

/// Whether the plane of a triangle comes into a ball; true of one that has no plane.
pub(crate) fn plane_comes_into(triangle: &Triangle, centre: Vector3, radius: f64) -> bool {
    let corners = triangle.map(|p| p - centre);
    let (across, _) = across(&corners);
    let height = across.dot(corners[0]);
    !(height * height > radius * radius * across.norm_squared())
}

/// Whether a triangle comes before a plane through a point of it, and behind it.
#[cfg_attr(not(feature = "std"), inline(never))]
pub(super) fn sides(normal: Vector3, point: Vector3, corners: &Triangle) -> [bool; 2] {
    let mut found = [false; 2];
    for z in corners {
        let way = *z - point;
        let height = normal.dot(way);
        let least = TOLERANCE * way.norm() + f64::MIN_POSITIVE;
        found[0] |= height > least;
        found[1] |= height < -least;
    }
    found
}

pub(super) fn combine(corners: &Triangle, weights: [f64; 3]) -> Vector3 {
    corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2]
}

/// Barycentric coordinates of a point in the plane of a triangle: the weights of the corners of which it is the mean. A third each
/// where the corners are on a line.
pub fn barycentric_weights(t: &Triangle, p: Vector3) -> [f64; 3] {
    let (u, v, w) = (t[1] - t[0], t[2] - t[0], p - t[0]);
    let (uu, uv, vv) = (u.norm_squared(), u.dot(v), v.norm_squared());
    let determinant = uu * vv - uv * uv;
    if !(determinant > 0.0) {
        return [1.0 / 3.0; 3];
    }
    let (a, b) = (w.dot(u), w.dot(v));
    let second = (a * vv - b * uv) / determinant;
    let third = (b * uu - a * uv) / determinant;
    [1.0 - second - third, second, third]
}

/// Weights of the corners of a triangle in the plane at its point nearest to the origin.
fn nearest_to_origin(corners: [Vector2; 3]) -> [f64; 3] {
    let cross = |a: Vector2, b: Vector2| a.u * b.v - a.v * b.u;
    let parts: [f64; 3] =
        core::array::from_fn(|k| cross(corners[(k + 1) % 3], corners[(k + 2) % 3]));
    let whole = parts[0] + parts[1] + parts[2];
    if whole != 0.0 && parts.iter().all(|p| p / whole >= 0.0) {
        return parts.map(|p| p / whole);
    }
    let mut best = (f64::INFINITY, [1.0, 0.0, 0.0]);
    for k in 0..3 {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        let side = b - a;
        let length = side.dot(side);
        let share = if length > 0.0 {
            (-(a.dot(side)) / length).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let point = a + side * share;
        let distance = point.dot(point);
        if distance < best.0 {
            let mut weights = [0.0; 3];
            weights[k] = 1.0 - share;
            weights[(k + 1) % 3] = share;
            best = (distance, weights);
        }
    }
    best.1
}
