// SPDX-License-Identifier: MIT OR Apache-2.0
//! How wide are the flat pieces of a surface of triangles? A flat piece is all that continues a triangle in its plane, beyond edges that triangles
//! share, or share a part of. Its width does not depend on how it is divided into triangles.

use super::shared_edges::{SharedEdges, ON_SIDE};
use super::triangle::{across, Triangle};
use super::triangle_places::SAME_PLANE;
use crate::vector::{Tangent, Vector2, Vector3};

/// For each triangle the least width of the flat piece of which it is a part: the least distance of two parallel lines between which the piece
/// lies. 0 for a triangle without an area. The time goes with `n log n`.
pub(crate) fn widths(triangles: &[Triangle]) -> Vec<f64> {
    let mut surface = SharedEdges::new(triangles);
    let hanging = surface.hanging(ON_SIDE);
    surface.cut(&hanging);
    widths_of(triangles, &surface)
}

/// The same of triangles of a surface whose sides are cut where corners are on them.
pub(crate) fn widths_of(triangles: &[Triangle], surface: &SharedEdges) -> Vec<f64> {
    let normals: Vec<Option<Vector3>> = triangles.iter().map(normal).collect();
    let mut pieces = Pieces::new(triangles.len());
    for sides in surface.edges() {
        for (k, a) in sides.iter().enumerate() {
            for b in &sides[..k] {
                if let (Some(n), Some(m)) = (normals[a.triangle], normals[b.triangle]) {
                    if n.cross(m).norm_squared() <= SAME_PLANE * SAME_PLANE {
                        pieces.join(a.triangle, b.triangle);
                    }
                }
            }
        }
    }
    let mut members: Vec<[usize; 2]> = (0..triangles.len())
        .map(|t| [pieces.first_of(t), t])
        .collect();
    members.sort_unstable();
    let mut widths = vec![0.0; triangles.len()];
    let mut corners = Vec::new();
    for piece in members.chunk_by(|a, b| a[0] == b[0]) {
        let Some(normal) = normals[piece[0][0]] else {
            continue;
        };
        corners.clear();
        corners.extend(piece.iter().flat_map(|[_, t]| surface.triangles[*t]));
        corners.sort_unstable();
        corners.dedup();
        let tangent = Tangent::new(normal);
        // From one of them: the origin may be far away.
        let origin = surface.corners[corners[0]];
        let places = corners
            .iter()
            .map(|c| tangent.components(surface.corners[*c] - origin));
        let width = least_width(&convex_hull(places.collect()));
        for [_, t] in piece {
            widths[*t] = width;
        }
    }
    widths
}

/// The unit normal of a triangle that has an area.
fn normal(triangle: &Triangle) -> Option<Vector3> {
    let (across, _) = across(triangle);
    let twice_area = across.norm();
    (twice_area > 0.0 && twice_area.is_finite()).then(|| across * (1.0 / twice_area))
}

/// Numbers that are joined step by step.
pub(crate) struct Pieces(Vec<usize>);

impl Pieces {
    /// Each by itself.
    pub fn new(count: usize) -> Self {
        Pieces((0..count).collect())
    }

    /// The number that stands for all that `k` is joined with.
    pub fn first_of(&mut self, mut k: usize) -> usize {
        while self.0[k] != k {
            self.0[k] = self.0[self.0[k]];
            k = self.0[k];
        }
        k
    }

    pub fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.first_of(a), self.first_of(b));
        self.0[a.max(b)] = a.min(b);
    }
}

/// Twice the area of the triangle of these three, positive if they go counterclockwise.
fn turn(a: Vector2, b: Vector2, c: Vector2) -> f64 {
    let (b, c) = (b - a, c - a);
    b.u * c.v - b.v * c.u
}

fn length(way: Vector2) -> f64 {
    way.dot(way).sqrt()
}

/// Bits of the whole numbers that [`on_grid`] makes of points: products of two have no more than a number has, and [`turn`] is exact.
const GRID_BITS: f64 = 25.0;

/// Points on a grid of 3e-8 of the largest way between two. Corners that are on one line or equal but for rounding would make hulls of any shape.
fn on_grid(points: &mut [Vector2]) {
    let Some(&origin) = points.first() else {
        return;
    };
    let way = |p: &Vector2| (p.u - origin.u).abs().max((p.v - origin.v).abs());
    let largest = points.iter().map(way).fold(0.0, f64::max);
    let step = (largest.log2().ceil() - GRID_BITS).exp2();
    if !(step > 0.0 && step.is_finite()) {
        return;
    }
    for p in points {
        // Adding 0 makes one zero of both.
        let [u, v] = [p.u - origin.u, p.v - origin.v].map(|x| (x / step).round() * step + 0.0);
        *p = Vector2 { u, v };
    }
}

/// The corners of the convex hull of points, moved to a grid, counterclockwise (A. M. Andrew, Inf. Process. Lett. 9, 216, 1979).
fn convex_hull(mut points: Vec<Vector2>) -> Vec<Vector2> {
    on_grid(&mut points);
    points.sort_unstable_by(|p, q| p.u.total_cmp(&q.u).then(p.v.total_cmp(&q.v)));
    points.dedup();
    let mut hull: Vec<Vector2> = Vec::new();
    for half in 0..2 {
        let from = hull.len();
        for &p in &points {
            while hull.len() > from + 1
                && turn(hull[hull.len() - 2], hull[hull.len() - 1], p) <= 0.0
            {
                hull.pop();
            }
            hull.push(p);
        }
        // The last one begins the other half.
        hull.pop();
        if half == 0 {
            points.reverse();
        }
    }
    hull
}

/// The least width of a convex polygon: one of the two lines goes along an edge, and the other through the corner farthest from it, which goes on around
/// the polygon as the edge does (M. E. Houle and G. T. Toussaint, IEEE Trans. Pattern Anal. Mach. Intell. 10, 761, 1988). 0 for fewer than three corners.
fn least_width(hull: &[Vector2]) -> f64 {
    let count = hull.len();
    if count < 3 {
        return 0.0;
    }
    let edge = |k: usize| [hull[k], hull[(k + 1) % count]];
    let height = |[a, b]: [Vector2; 2], m: usize| turn(a, b, hull[m % count]);
    let mut farthest = 1;
    (0..count)
        .map(|k| {
            let own = edge(k);
            // At most once around: for rounding.
            for _ in 0..count {
                if height(own, farthest + 1) > height(own, farthest) {
                    farthest = (farthest + 1) % count;
                } else {
                    break;
                }
            }
            height(own, farthest) / length(own[1] - own[0])
        })
        .fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;

    fn at(u: f64, v: f64) -> Vector2 {
        Vector2 { u, v }
    }

    #[test]
    fn the_width_of_a_convex_hull_is_the_least_over_all_directions() {
        let mut random = Random::new(3);
        for case in 0..200 {
            let count = 3 + case % 40;
            let points: Vec<Vector2> = (0..count)
                .map(|_| at(random.uniform(-1.0, 1.0), random.uniform(-0.3, 0.3)))
                .collect();
            let found = least_width(&convex_hull(points.clone()));
            // Of all pairs of points, the width across the line through them.
            let mut expected = f64::INFINITY;
            for (k, &p) in points.iter().enumerate() {
                for &q in &points[..k] {
                    let heights = points.iter().map(|&r| turn(p, q, r) / length(q - p));
                    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |m, h| {
                        (m.0.min(h), m.1.max(h))
                    });
                    expected = expected.min(high - low);
                }
            }
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
        assert_eq!(least_width(&convex_hull(vec![at(0.0, 0.0); 5])), 0.0);
        let line = (0..5).map(|k| at(f64::from(k), 2.0 * f64::from(k)));
        assert_eq!(least_width(&convex_hull(line.collect())), 0.0);
    }

    /// A triangle with corners on its sides that are off by rounding, and some twice.
    #[test]
    fn corners_on_the_sides_of_a_convex_hull_are_none() {
        let mut random = Random::new(4);
        for case in 0..2000 {
            let [a, b, c] =
                [0; 3].map(|_| at(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)));
            let expected = least_width(&convex_hull(vec![a, b, c]));
            let mut points = vec![a, b, c];
            for (a, b) in [(a, b), (b, c), (c, a)] {
                for _ in 0..case % 7 {
                    let between = a + (b - a) * random.uniform(0.0, 1.0);
                    points.push(between);
                    points.push(between * (1.0 + f64::EPSILON));
                }
            }
            let found = least_width(&convex_hull(points));
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
    }

    /// A strip 0.3 wide in many triangles, which bends by 10 degrees, with a square beside the bend.
    #[test]
    fn a_piece_is_as_wide_however_it_is_divided() {
        let bend = 10f64.to_radians();
        let place = |x: f64, y: f64| {
            let beyond = x.max(0.0);
            Vector3::new(
                x.min(0.0) + beyond * bend.cos(),
                y,
                5000.0 + beyond * bend.sin(),
            )
        };
        let mut triangles: Vec<Triangle> = Vec::new();
        let mut rectangle = |[x0, x1]: [f64; 2], [y0, y1]: [f64; 2], [m, n]: [u32; 2]| {
            for (i, j) in (0..m).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let x = |i: u32| x0 + (x1 - x0) * f64::from(i) / f64::from(m);
                let y = |j: u32| y0 + (y1 - y0) * f64::from(j) / f64::from(n);
                let [a, b, c, d] = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]]
                    .map(|[i, j]| place(x(i), y(j)));
                triangles.push([a, b, c]);
                triangles.push([c, d, a]);
            }
        };
        rectangle([-0.3, 0.0], [0.0, 4.0], [2, 16]);
        rectangle([0.0, 1.0], [0.0, 4.0], [4, 16]);
        let widths = widths(&triangles);
        for (k, width) in widths.iter().enumerate() {
            let expected = if k < 64 { 0.3 } else { 1.0 };
            assert!((width - expected).abs() < 1e-6, "{k} {width}");
        }
    }

    #[test]
    fn triangles_without_an_area_or_a_neighbour() {
        let p = |x: f64, y: f64| Vector3::new(x, y, 0.0);
        let triangles = [
            [p(0.0, 0.0), p(4.0, 0.0), p(2.0, 1.0)],
            [p(0.0, 0.0), p(1.0, 0.0), p(3.0, 0.0)],
            // In the same plane, without an edge in common.
            [p(0.0, 0.0), p(-4.0, 0.0), p(-2.0, -2.0)],
        ];
        assert_eq!(widths(&triangles), [1.0, 0.0, 2.0]);
    }
}
