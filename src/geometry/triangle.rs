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

    /// The square of how far it is from the body's centre.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn nearest_distance_squared(&self) -> f64 {
        let tangent = Tangent::new(self.normal);
        let place = self.corners.map(|c| tangent.components(c));
        combine(&self.corners, nearest_to_origin(place)).norm_squared()
    }

    /// Whether the way from the body's centre to a point of another triangle passes through this one, and that other lies behind
    /// this one's plane as a whole. A larger one, on which this one stands, goes on in front of it.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn stands_before(&self, other: &Near, seen: Vector3, meeting: f64) -> bool {
        let depth = -(self.normal.dot(seen) + self.distance);
        depth > TOLERANCE * seen.norm()
            && self.is_before(other, meeting)
            && self.has(seen * (self.distance / (self.distance + depth)), meeting)
    }

    /// Whether another triangle lies behind the plane of this one as a whole.
    pub fn is_before(&self, other: &Near, meeting: f64) -> bool {
        let height = |p: Vector3| self.normal.dot(p) + self.distance;
        other.corners.iter().all(|&p| height(p) <= meeting)
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

    /// The same, and the square of the way there in that measure.
    pub fn nearest_and_way(
        &self,
        body: &Ellipsoid,
        support: &Support,
        foot: Vector3,
    ) -> (Vector3, f64) {
        let (weights, way) = self.nearest(body, support, foot);
        (combine(&self.corners, weights), way.dot(way))
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

/// Whether a triangle comes into a body so many times as large about the origin. Where the body is the unit sphere, `across` is a vector across the
/// triangle, and `square` the square of the distance of its plane.
#[cfg_attr(not(feature = "std"), inline(never))]
pub(super) fn comes_within(
    body: &Ellipsoid,
    corners: &Triangle,
    across: Vector3,
    square: f64,
    times: f64,
) -> bool {
    let frame = Tangent::new(across.normalised());
    let place =
        corners.map(|p| frame.components(body.inverse_semi_axes.componentwise(body.to_body(p))));
    let weights = nearest_to_origin(place);
    let nearest = place[0] * weights[0] + place[1] * weights[1] + place[2] * weights[2];
    nearest.dot(nearest) + square <= times * times
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;

    fn v(x: f64, y: f64, z: f64) -> Vector3 {
        Vector3::new(x, y, z)
    }

    fn near(corners: Triangle) -> Near {
        Near::new(7, &corners, Vector3::ZERO, 1e-9).unwrap()
    }

    /// A triangle of sides of the order of 1, no sliver.
    fn random_triangle(random: &mut Random, middle: Vector3) -> Triangle {
        loop {
            let corners = [0; 3].map(|_| middle + random.direction() * random.uniform(0.2, 1.0));
            let (across, longest) = across(&corners);
            if across.norm() > 0.3 * longest {
                return corners;
            }
        }
    }

    /// The point of a triangle nearest to another, of those on its corners, sides and within.
    fn closest(t: &Triangle, p: Vector3) -> Vector3 {
        let mut all = t.to_vec();
        for k in 0..3 {
            let (a, side) = (t[k], t[(k + 1) % 3] - t[k]);
            let share = side.dot(p - a) / side.norm_squared();
            if (0.0..=1.0).contains(&share) {
                all.push(a + side * share);
            }
        }
        let weights = barycentric_weights(t, p);
        if weights.iter().all(|w| *w >= 0.0) {
            all.push(combine(t, weights));
        }
        let distance = |q: &Vector3| (*q - p).norm();
        let order = |a: &Vector3, b: &Vector3| distance(a).total_cmp(&distance(b));
        all.into_iter().min_by(order).unwrap()
    }

    #[test]
    fn a_triangle_from_the_body() {
        let centre = v(0.5, 0.25, 2.0);
        let floor = [v(0.0, 0.0, 1.0), v(4.0, 0.0, 1.0), v(0.0, 2.0, 1.0)];
        for turned in [floor, [floor[1], floor[0], floor[2]]] {
            let t = Near::new(7, &turned, centre, 1e-5).unwrap();
            assert!((t.normal - v(0.0, 0.0, 1.0)).norm() < 1e-15);
            assert!((t.distance - 1.0).abs() < 1e-15);
            assert_eq!((t.index, t.plane), (7, 0));
            assert_eq!(t.corners, turned.map(|p| p - centre));
            let below = Near::new(7, &turned, v(0.5, 0.25, -2.0), 1e-5).unwrap();
            assert!((below.normal - v(0.0, 0.0, -1.0)).norm() < 1e-15);
            assert!((below.distance - 3.0).abs() < 1e-15);
            // Twice the area over the longest side.
            assert!((t.height() - 8.0 / 20f64.sqrt()).abs() < 1e-14);
        }
        // The distance is that of the nearest corner: the others are so far that they have lost nine digits.
        let n = v(0.6, 0.0, 0.8);
        let corner = v(-0.3, 0.2, -0.4);
        let long = [
            corner,
            corner + v(0.8, 0.0, -0.6) * 1e9,
            corner + v(0.0, 1e9, 0.0),
        ];
        for k in 0..3 {
            let turned = [long[k], long[(k + 1) % 3], long[(k + 2) % 3]];
            let t = Near::new(0, &turned, Vector3::ZERO, 1e-5).unwrap();
            assert!((t.distance - 0.5).abs() < 1e-14 && (t.normal - n).norm() < 1e-14);
        }
        // Slivers as narrow as what is taken for nothing, and what is no triangle.
        let sliver = |height: f64| [v(0.0, 0.0, 0.0), v(5.0, 0.0, 0.0), v(2.0, height, 0.0)];
        assert!(Near::new(0, &sliver(0.9e-3), centre, 1e-3).is_none());
        assert!(Near::new(0, &sliver(1.1e-3), centre, 1e-3).is_some());
        for bad in [f64::NAN, f64::INFINITY] {
            let corners = [v(bad, 0.0, 0.0), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0)];
            assert!(Near::new(0, &corners, centre, 1e-3).is_none());
        }
    }

    /// The vector across has its length and direction whichever corner is first, of a long triangle too.
    #[test]
    fn across_a_triangle() {
        let corners = [v(1.0, 2.0, 3.0), v(1e6, 2.0, 3.0), v(5e5, 2.5, 3.0)];
        for k in 0..3 {
            let turned = [corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]];
            let (across, longest) = across(&turned);
            assert!((across - v(0.0, 0.0, 0.5 * (1e6 - 1.0))).norm() < 1e-9);
            assert_eq!(longest, (1e6 - 1.0) * (1e6 - 1.0));
        }
        let triangle = [v(0.0, 0.0, 2.0), v(3.0, 0.0, 2.0), v(0.0, 2.0, 2.0)];
        for (radius, comes) in [(1.51, true), (1.49, false)] {
            for centre in [v(9.0, 5.0, 3.5), v(9.0, 5.0, 0.5)] {
                assert_eq!(plane_comes_into(&triangle, centre, radius), comes);
            }
        }
        assert!(plane_comes_into(
            &[v(1.0, 0.0, 0.0); 3],
            v(9.0, 0.0, 0.0),
            1.0
        ));
    }

    #[test]
    fn before_and_behind_a_plane() {
        let normal = v(0.0, 0.0, 1.0);
        let point = v(1.0, 1.0, 1.0);
        let at = |z: [f64; 3]| {
            let corners = [v(1.0, 1.0, z[0]), v(3.0, 1.0, z[1]), v(1.0, 4.0, z[2])];
            sides(normal, point, &corners)
        };
        assert_eq!(at([1.0, 1.0, 1.0]), [false, false]);
        assert_eq!(at([1.0, 1.5, 1.0]), [true, false]);
        assert_eq!(at([1.0, 1.0, 0.5]), [false, true]);
        assert_eq!(at([1.0, 1.5, 0.5]), [true, true]);
        // Of an angle that is taken as zero, and of one that is not: 2 and 3 away.
        assert_eq!(at([1.0, 1.0 + 1.9e-9, 1.0 - 2.9e-9]), [false, false]);
        assert_eq!(at([1.0, 1.0 + 2.1e-9, 1.0 - 3.1e-9]), [true, true]);
    }

    #[test]
    fn a_neighbour_continues_a_triangle_beyond_their_edge() {
        let [a, b] = [v(0.0, 0.0, -1.0), v(0.0, 1.0, -1.0)];
        let own = near([v(-1.0, 0.3, -1.0), a, b]);
        let beyond = near([a, b, v(2.0, 0.5, -1.0)]);
        let beside = near([b, v(-2.0, 0.6, -1.0), a]);
        assert!(own.is_continued_by(&beyond, a, b) && own.is_continued_by(&beyond, b, a));
        assert!(beyond.is_continued_by(&own, a, b));
        assert!(!own.is_continued_by(&beside, a, b));
        let elsewhere = near([a, v(0.0, 2.0, -1.0), v(2.0, 0.5, -1.0)]);
        assert!(!own.is_continued_by(&elsewhere, a, b));
        let elsewhere = near([v(0.0, 2.0, -1.0), b, v(2.0, 0.5, -1.0)]);
        assert!(!own.is_continued_by(&elsewhere, a, b));
    }

    /// Against the nearest of the points on corners, sides and within.
    #[test]
    fn what_a_triangle_has_is_what_is_near_its_nearest_point() {
        let mut random = Random::new(3);
        let mut counts = [0; 2];
        for _ in 0..2000 {
            let t = random_triangle(&mut random, v(0.2, -0.4, 1.5));
            let p = v(0.2, -0.4, 1.5) + random.direction() * random.uniform(0.0, 1.5);
            let distance = (closest(&t, p) - p).norm();
            let own = near(t);
            assert!(own.has(p, distance * 1.0001 + 1e-12));
            assert!(!own.has(p, distance * 0.9999 - 1e-12) || distance < 1e-9);
            let weights = barycentric_weights(&t, p);
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            // The foot of the perpendicular.
            let foot = combine(&t, weights) - p;
            for side in [t[1] - t[0], t[2] - t[0]] {
                assert!(foot.dot(side).abs() < 1e-12);
            }
            counts[usize::from(weights.iter().all(|w| *w > 0.0))] += 1;
        }
        assert!(counts[0] > 500 && counts[1] > 200, "{counts:?}");
        let line = [v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(2.0, 0.0, 0.0)];
        assert_eq!(barycentric_weights(&line, v(0.3, 1.0, 0.0)), [1.0 / 3.0; 3]);
        let weights = nearest_to_origin([Vector2::new(2.0, 1.0); 3]);
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-15);
    }

    /// Sections of a body with the plane of a triangle: what of it is in the body, and whether its borders are.
    #[test]
    fn a_triangle_and_the_section_of_its_plane() {
        let mut random = Random::new(8);
        let (mut within, mut clear, mut outside) = (0, 0, 0);
        for _ in 0..2000 {
            let semi_axes = [0; 3].map(|_| random.of_any_size(0.2, 1.0));
            let body = Ellipsoid::new(semi_axes, random.quaternion()).unwrap();
            let normal = random.direction();
            let support = body.support(-normal);
            let penetration = support.h * random.uniform(0.01, 0.6);
            let tangent = Tangent::new(normal);
            let foot = support.point + normal * penetration;
            let size = random.of_any_size(0.1, 4.0);
            let order = [[0.0, 2.1, 4.2], [4.2, 2.1, 0.0]][random.uniform(0.0, 2.0) as usize];
            let corners = order.map(|angle: f64| {
                let angle = angle + random.uniform(-0.8, 0.8);
                let r = size * random.uniform(0.5, 1.0);
                foot + tangent.u * (r * angle.cos() - 0.3 * size) + tangent.v * (r * angle.sin())
            });
            let t = near(corners);
            assert!((t.normal - normal).norm() < 1e-9);
            assert!((t.distance - (support.h - penetration)).abs() < 1e-12);
            // In the frame in which the body is the unit ball.
            let unit = |p: Vector3| body.inverse_semi_axes.componentwise(body.to_body(p));
            let of_ball = corners.map(unit);
            let nearest = closest(&of_ball, Vector3::ZERO);
            let is_in = nearest.norm() < 1.0;
            assert_eq!(t.is_in_section(&body, &support, penetration), is_in);
            let found = unit(t.nearest_to(&body, &support, Vector3::ZERO));
            assert!((found - nearest).norm() < 1e-9);
            let found = unit(t.nearest_to(&body, &support, foot));
            assert!((found - closest(&of_ball, unit(foot))).norm() < 1e-9);
            // The triangle has all of the section, and the foot, if no side of it comes into the body, and its inner part is there.
            let margin = size * random.uniform(0.0, 0.05);
            let border: Vec<Vector3> = (0..500)
                .map(|m| border_of_section(&body, &t, 0.004 * core::f64::consts::PI * f64::from(m)))
                .collect();
            let sides = (0..3).all(|k| {
                let (a, b, c) = (corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
                let mut out = (b - a).cross(normal).normalised();
                out = if out.dot(c - a) > 0.0 { -out } else { out };
                let reach = border.iter().map(|p| out.dot(*p));
                let reach = reach.fold(f64::NEG_INFINITY, f64::max);
                let room = out.dot(a);
                // What the directions leave out.
                let allowed = 1e-4;
                if (room - margin - reach).abs() < allowed {
                    return t.borders_are_clear(&body, &support, foot, margin);
                }
                room - margin > reach && room - margin > out.dot(foot)
            });
            assert_eq!(
                t.borders_are_clear(&body, &support, foot, margin),
                sides,
                "{body:?} {corners:?}"
            );
            clear += usize::from(sides);
            within += usize::from(is_in && !sides);
            outside += usize::from(!is_in);
        }
        println!("{clear} clear, {within} in part, {outside} outside");
        assert!(clear > 120 && within > 200 && outside > 50);
    }

    /// A point of the border of the section.
    fn border_of_section(body: &Ellipsoid, t: &Near, angle: f64) -> Vector3 {
        let m = body.semi_axes.componentwise(body.to_body(t.normal));
        let frame = Tangent::new(m.normalised());
        let p = -t.distance / m.norm();
        let e = m.normalised() * p
            + (frame.u * angle.cos() + frame.v * angle.sin()) * (1.0 - p * p).sqrt();
        body.to_world(body.semi_axes.componentwise(e))
    }

    #[test]
    fn the_borders_leave_what_the_triangle_covers() {
        let mut random = Random::new(4);
        for _ in 0..300 {
            let t = random_triangle(&mut random, v(0.2, -0.4, 1.5));
            let own = near(t);
            let tangent = Tangent::new(own.normal);
            let middle = (t[0] + t[1] + t[2]) * (1.0 / 3.0);
            let p = middle
                + tangent.u * random.uniform(-1.0, 1.0)
                + tangent.v * random.uniform(-1.0, 1.0);
            let is_covered = barycentric_weights(&t, p).iter().all(|w| *w > 0.0);
            let borders = own.borders();
            for border in &borders {
                assert!(border.normal.dot(own.normal).abs() < 1e-12);
                assert!((border.normal.norm() - 1.0).abs() < 1e-12);
                let on_it = |q: &&Vector3| border.normal.dot(**q - border.point).abs() < 1e-12;
                assert_eq!(t.iter().filter(on_it).count(), 2);
            }
            let is_left = borders.iter().all(|b| b.normal.dot(p - b.point) > 0.0);
            assert_eq!(is_left, is_covered, "{t:?} {p:?}");
        }
    }

    #[test]
    fn what_hides_another_stands_before_it() {
        let wall = |x: f64| near([v(x, -1.0, -1.0), v(x, 1.0, -1.0), v(x, 0.0, 1.5)]);
        let [front, back] = [wall(1.0), wall(2.0)];
        let seen = v(2.0, 0.2, -0.4);
        assert!(front.stands_before(&back, seen, 1e-6));
        assert!(!back.stands_before(&front, v(1.0, 0.1, -0.2), 1e-6));
        // The way to this one passes beside it.
        assert!(!front.stands_before(&back, v(2.0, 2.1, -0.2), 1e-6));
        assert!(front.stands_before(&back, v(2.0, 0.0, 2.9), 1e-6));
        assert!(!front.stands_before(&back, v(2.0, 0.0, 3.1), 1e-6));
        // One that comes out before its plane, and one that stands on it.
        let through = near([v(0.5, 0.0, -3.0), v(3.0, 0.5, 0.0), v(3.0, -0.5, 0.0)]);
        assert!(!front.stands_before(&through, v(3.0, 0.0, 0.0), 1e-6));
        let behind = near([v(1.0, 0.0, -0.5), v(3.0, 0.5, 0.0), v(3.0, -0.5, 0.0)]);
        assert!(front.stands_before(&behind, v(3.0, 0.0, 0.0), 1e-6));
        let a_little = near([
            v(1.0 - 1e-5, 0.0, -0.5),
            v(3.0, 0.5, 0.0),
            v(3.0, -0.5, 0.0),
        ]);
        assert!(front.stands_before(&a_little, v(3.0, 0.0, 0.0), 2e-5));
        assert!(!front.stands_before(&a_little, v(3.0, 0.0, 0.0), 0.5e-5));
        // A place at an angle with its plane that is taken as zero is not behind it.
        let large = near([v(1.0, -30.0, -30.0), v(1.0, 30.0, -30.0), v(1.0, 0.0, 60.0)]);
        let beyond = near([v(2.0, 1.0, 0.0), v(2.0, 2.0, 0.0), v(2.0, 1.0, 1.0)]);
        assert!(!large.stands_before(&beyond, v(1.0 + 5e-9, 10.0, 0.0), 1e-6));
        assert!(large.stands_before(&beyond, v(1.0 + 2e-8, 10.0, 0.0), 1e-6));
        // A place of its own plane is not behind it.
        assert!(!front.stands_before(&behind, v(1.0, 0.0, -0.5), 1e-6));
    }

    #[test]
    fn triangles_of_one_plane() {
        let floor = near([v(0.0, 0.0, -1.0), v(1.0, 0.0, -1.0), v(0.0, 1.0, -1.0)]);
        let shifted = |dz: f64, slope: f64| {
            near([
                v(-1.0, 0.0, -1.0 + dz - slope),
                v(0.0, 0.0, -1.0 + dz),
                v(0.0, 1.0, -1.0 + dz),
            ])
        };
        let is_one = |t: &Near| t.is_in_plane_of(&floor, 1.0, 1e-8);
        assert!(is_one(&shifted(0.0, 0.0)) && is_one(&shifted(0.9e-12, 0.0)));
        assert!(!is_one(&shifted(1.5e-12, 0.0)) && !is_one(&shifted(-1.5e-12, 0.0)));
        assert!(is_one(&shifted(0.0, 0.8e-8)) && !is_one(&shifted(0.0, 1.2e-8)));
        assert!(shifted(1.5e-12, 0.0).is_in_plane_of(&floor, 2.0, 1e-8));
    }

    /// At corners, and where a side passes through the other, against the distance of many points of one from the other.
    #[test]
    fn triangles_meet_where_they_are_near() {
        let mut random = Random::new(6);
        let mut counts = [0; 2];
        let margin = 1e-3;
        for k in 0..1200 {
            let one = random_triangle(&mut random, v(0.0, 0.0, 2.0));
            let beside = random.direction() * random.uniform(0.0, 1.5);
            let mut other = random_triangle(&mut random, v(0.0, 0.0, 2.0) + beside);
            if k % 3 == 0 {
                // A corner on a side, a corner or a face of the first, or a little beside it.
                let weights = match k % 9 {
                    0 => [0.3, 0.7, 0.0],
                    3 => [0.0, 0.0, 1.0],
                    _ => [0.2, 0.5, 0.3],
                };
                let gap = random.direction() * (margin * random.uniform(0.1, 1.9));
                let shift = combine(&one, weights) + gap - other[k % 2];
                other = other.map(|p| p + shift);
            }
            let [a, b] = [near(one), near(other)];
            let expected = {
                let corners = |t: &Triangle, q: &Triangle| {
                    q.iter().any(|p| (closest(t, *p) - *p).norm() <= margin)
                };
                let passes = |t: &Triangle, q: &Triangle| {
                    let normal = across(t).0.normalised();
                    (0..3).any(|m| {
                        let (from, to) = (q[m], q[(m + 1) % 3]);
                        let heights = [from, to].map(|p| normal.dot(p - t[0]));
                        let share = heights[0] / (heights[0] - heights[1]);
                        let place = from + (to - from) * share;
                        heights[0] * heights[1] < 0.0
                            && (closest(t, place) - place).norm() <= margin
                    })
                };
                corners(&one, &other)
                    || corners(&other, &one)
                    || passes(&one, &other)
                    || passes(&other, &one)
            };
            assert_eq!(a.meets(&b, margin), expected, "{one:?} {other:?}");
            assert_eq!(b.meets(&a, margin), expected);
            counts[usize::from(expected)] += 1;
        }
        assert!(counts[0] > 300 && counts[1] > 300, "{counts:?}");
    }
}
