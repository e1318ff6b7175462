// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where were the corners of a surface before they were rounded? Many triangles of one plane are no longer in one plane when their corners have the seven
//! digits of an STL file, and each edge between them is a fold. Here the flat pieces are found again, and their corners go back to where their planes
//! meet: a corner of one piece to its plane, of two to the line in which they meet, of three to the point. A corner on a side of a triangle is one of that
//! triangle's piece, too.

use super::shared_edges::{Hanging, Margin, SharedEdges, Side};
use super::triangle::Triangle;
use crate::vector::{Tangent, Vector3};
use std::collections::HashSet;

/// What lies as near to a plane as this share of the largest coordinate is in it, and nothing is left to do.
const EXACT: f64 = 1e-13;

/// Sine of the least angle between planes at which their line, or a line and a plane at which their point is found. Corners would move far along
/// planes that meet at less.
const LEAST_ANGLE: f64 = 1e-3;

/// A corner is in a plane that is not yet fitted to it if it is no farther from it than so many times the rounding.
const NEAR: f64 = 2.0;

/// The part of the shortest edge at a corner by which it may move, at most.
const LARGEST_MOTION: f64 = 0.05;

/// How often planes and corners are fitted to each other.
const ROUNDS: usize = 4;

/// The weight of a corner through which a plane must pass, among those of 1.
const FIXED: f64 = 1e10;

/// How often the plane of a piece that grows is fitted, at most: of one that grows by half each time long before.
const MOST_FITS: usize = 64;

/// No piece.
const NOTHING: usize = usize::MAX;

/// By how much the coordinates of these triangles may be off, if they are as in an STL file, with at most nine decimal digits: by two units in the last
/// place that single precision has of the largest one, for programs that also compute in it, or by one unit of the last decimal digit where that is more.
/// Of fewer than six digits the sixth counts. `None` where a number has more digits, or none is other than 0: then nothing is known of rounding.
pub(crate) fn rounding(triangles: &[Triangle]) -> Option<f64> {
    let all = || triangles.iter().flatten().flat_map(|p| p.to_array());
    let largest = all().fold(0.0f64, |m, x| m.max(x.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    let mut most = 6;
    for x in all() {
        most = most.max(digits(x));
        if most > 9 {
            return None;
        }
    }
    let unit = 10f64.powi(largest.log10().floor() as i32 + 1 - most);
    Some(unit.max(largest * 2.0 * f64::from(f32::EPSILON)))
}

/// How many decimal digits a number has at least, which is of single precision or else of double.
fn digits(x: f64) -> i32 {
    let single = x as f32;
    let written = if f64::from(single) == x {
        format!("{single:e}")
    } else {
        format!("{x:e}")
    };
    let mantissa = written.split('e').next().unwrap_or_default();
    mantissa.bytes().filter(u8::is_ascii_digit).count() as i32
}

/// Moves the corners of flat pieces of two and more triangles, and of one that has others' corners on its sides, back to their planes, where they are off by no more than `rounding`. Corners that are equal
/// stay equal. A corner of more than three flat pieces stays, and their planes go through it, as far as they can. The largest way that a corner moved. The
/// time goes with `n log n`.
pub(crate) fn flatten(triangles: &mut [Triangle], rounding: f64) -> f64 {
    let mut surface = SharedEdges::new(triangles);
    let hanging = surface.hanging(Margin::Distance(NEAR * rounding));
    surface.cut(&hanging);
    let pieces = Pieces::find(&surface, &hanging, rounding);
    let given = surface.corners.clone();
    let mut is_fixed = vec![false; given.len()];
    for (corner, own) in pieces.of_corners.iter().enumerate() {
        is_fixed[corner] = own.len() > 3;
    }
    let shortest = shortest_edges(&surface);
    for _ in 0..ROUNDS {
        let planes: Vec<Plane> = (pieces.corners.iter())
            .map(|own| Plane::through(&given, own, &is_fixed))
            .collect();
        let mut all_fit = true;
        for (corner, own) in pieces.of_corners.iter().enumerate() {
            let most = LARGEST_MOTION * shortest[corner];
            match moved(
                given[corner],
                own.iter().map(|k| &planes[*k]),
                most,
                pieces.exact,
            ) {
                Some(place) if !is_fixed[corner] => surface.corners[corner] = place,
                Some(_) => {}
                None => {
                    surface.corners[corner] = given[corner];
                    all_fit &= is_fixed[corner];
                    is_fixed[corner] = true;
                }
            }
        }
        if all_fit {
            break;
        }
    }
    for (triangle, corners) in triangles.iter_mut().zip(&surface.triangles) {
        *triangle = corners.map(|c| surface.corners[c]);
    }
    (given.iter().zip(&surface.corners))
        .map(|(p, q)| (*q - *p).norm())
        .fold(0.0, f64::max)
}

/// The length of the shortest edge at each corner.
fn shortest_edges(surface: &SharedEdges) -> Vec<f64> {
    let mut shortest = vec![f64::INFINITY; surface.corners.len()];
    for side in surface.edges().filter_map(<[Side]>::first) {
        let [a, b] = side.ends.map(|c| surface.corners[c]);
        for end in side.ends {
            shortest[end] = shortest[end].min((b - a).norm());
        }
    }
    shortest
}

/// The place nearest to a point at which planes meet, if it is no farther than `most` and there is one; the point itself where it is `exact`
/// enough on all of them.
fn moved<'p>(
    point: Vector3,
    planes: impl Iterator<Item = &'p Plane> + Clone,
    most: f64,
    exact: f64,
) -> Option<Vector3> {
    if planes
        .clone()
        .all(|plane| plane.height(point).abs() <= exact)
    {
        return Some(point);
    }
    let mut place = point;
    // Along the planes that were met so far.
    let mut across: [Option<Vector3>; 3] = [None; 3];
    for plane in planes.clone() {
        let height = plane.height(place);
        let met = across.iter().flatten();
        let way = met.fold(plane.normal, |way, n| way - *n * n.dot(way));
        let sine = way.norm();
        if sine < LEAST_ANGLE {
            if height.abs() > exact {
                return None;
            }
            continue;
        }
        let way = way * (1.0 / sine);
        place = place - way * (height / sine);
        if let Some(free) = across.iter_mut().find(|n| n.is_none()) {
            *free = Some(way);
        }
    }
    let meets_all = planes
        .clone()
        .all(|plane| plane.height(place).abs() <= exact);
    (meets_all && (place - point).norm() <= most).then_some(place)
}

#[derive(Clone, Copy, Debug)]
struct Plane {
    point: Vector3,
    normal: Vector3,
}

impl Plane {
    fn of(corners: [Vector3; 3]) -> Option<Self> {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).direction()?;
        Some(Plane { point: a, normal })
    }

    fn height(&self, p: Vector3) -> f64 {
        self.normal.dot(p - self.point)
    }

    /// The plane nearest to points, by the squares of their heights, from one that is nearly it.
    fn nearest(&self, points: impl Iterator<Item = (Vector3, f64)> + Clone) -> Self {
        let mut plane = *self;
        // The second time what rounding of the first has left.
        for _ in 0..2 {
            let (mut sum, mut weight) = (Vector3::ZERO, 0.0);
            for (p, own) in points.clone() {
                sum = sum + (p - plane.point) * own;
                weight += own;
            }
            let middle = plane.point + sum * (1.0 / weight);
            let tangent = Tangent::new(plane.normal);
            let [mut uu, mut uv, mut vv, mut uh, mut vh] = [0.0; 5];
            for (p, own) in points.clone() {
                let place = tangent.components(p - middle);
                let height = plane.normal.dot(p - middle);
                uu += own * place.u * place.u;
                uv += own * place.u * place.v;
                vv += own * place.v * place.v;
                uh += own * place.u * height;
                vh += own * place.v * height;
            }
            let determinant = uu * vv - uv * uv;
            plane.point = middle;
            // Points of one line leave the plane as it is about that line.
            if determinant > 1e-20 * (uu + vv) * (uu + vv) {
                let [u, v] = [uh * vv - vh * uv, vh * uu - uh * uv].map(|x| x / determinant);
                let normal = plane.normal - tangent.u * u - tangent.v * v;
                plane.normal = normal.direction().unwrap_or(plane.normal);
            }
        }
        plane
    }

    /// The plane nearest to corners; through those that are fixed.
    fn through(places: &[Vector3], corners: &PieceCorners, is_fixed: &[bool]) -> Self {
        let weighted = corners.all.iter().map(|&c| {
            let weight = if is_fixed[c] { FIXED } else { 1.0 };
            (places[c], weight)
        });
        corners.plane.nearest(weighted)
    }
}

/// The corners of a piece.
struct PieceCorners {
    all: Vec<usize>,
    /// Near to all of them.
    plane: Plane,
}

/// The flat pieces of more corners than those of one triangle.
struct Pieces {
    corners: Vec<PieceCorners>,
    /// The pieces that each corner is one of, the largest first.
    of_corners: Vec<Vec<usize>>,
    /// Up to which height a corner is in a plane.
    exact: f64,
}

impl Pieces {
    fn find(surface: &SharedEdges, hanging: &[Hanging], rounding: f64) -> Self {
        let count = surface.triangles.len();
        let at = |t: usize| surface.triangles[t].map(|c| surface.corners[c]);
        let neighbours = Neighbours::new(surface, rounding);
        let largest = surface.corners.iter().flat_map(|p| p.to_array());
        let exact = EXACT * largest.fold(0.0f64, |m, x| m.max(x.abs()));
        // From the largest on: its plane is known best.
        let area = |t: usize| {
            let [a, b, c] = at(t);
            (b - a).cross(c - a).norm()
        };
        let areas: Vec<f64> = (0..count).map(area).collect();
        let mut seeds: Vec<usize> = (0..count).collect();
        seeds.sort_by(|&a, &b| areas[b].total_cmp(&areas[a]));
        let mut piece_of = vec![NOTHING; count];
        let mut pieces: Vec<PieceCorners> = Vec::new();
        for seed in seeds {
            let Some(plane) = Plane::of(at(seed)).filter(|_| piece_of[seed] == NOTHING) else {
                continue;
            };
            let number = pieces.len();
            let mut own = Grown {
                members: vec![seed],
                corners: Vec::new(),
                has: HashSet::new(),
                plane,
            };
            own.add_corners(surface, hanging, seed);
            piece_of[seed] = number;
            own.grow(surface, hanging, &neighbours, rounding, |t| {
                let is_free = piece_of[t] == NOTHING;
                if is_free {
                    piece_of[t] = number;
                }
                is_free
            });
            if own.members.len() > 1 || own.corners.len() > 3 {
                pieces.push(PieceCorners {
                    all: own.corners,
                    plane: own.plane,
                });
            } else {
                piece_of[seed] = NOTHING;
            }
        }
        let mut of_corners = vec![Vec::new(); surface.corners.len()];
        let mut by_size: Vec<usize> = (0..pieces.len()).collect();
        by_size.sort_by_key(|&k| core::cmp::Reverse(pieces[k].all.len()));
        for k in by_size {
            for &c in &pieces[k].all {
                of_corners[c].push(k);
            }
        }
        Pieces {
            corners: pieces,
            of_corners,
            exact,
        }
    }
}

/// A piece that grows.
struct Grown {
    members: Vec<usize>,
    /// Each once.
    corners: Vec<usize>,
    has: HashSet<usize>,
    plane: Plane,
}

impl Grown {
    /// Those of a triangle, and those on its sides.
    fn add_corners(&mut self, surface: &SharedEdges, hanging: &[Hanging], triangle: usize) {
        let from = hanging.partition_point(|h| h.triangle < triangle);
        let here = hanging[from..]
            .iter()
            .take_while(|h| h.triangle == triangle);
        let all = (surface.triangles[triangle].into_iter()).chain(here.map(|h| h.corner));
        for corner in all {
            if self.has.insert(corner) {
                self.corners.push(corner);
            }
        }
    }

    /// Adds what continues it in its plane, which is fitted to all of it again each time that it has grown by half. `take` says whether a triangle is of no piece, and
    /// takes it.
    fn grow(
        &mut self,
        surface: &SharedEdges,
        hanging: &[Hanging],
        neighbours: &Neighbours,
        rounding: f64,
        mut take: impl FnMut(usize) -> bool,
    ) {
        let is_in = |plane: &Plane, t: usize| {
            let corners = surface.triangles[t].map(|c| surface.corners[c]);
            corners
                .iter()
                .all(|p| plane.height(*p).abs() <= NEAR * rounding)
        };
        for _ in 0..MOST_FITS {
            let before = self.members.len();
            let enough = before + before / 2 + 1;
            let mut next = 0;
            while next < self.members.len() && self.members.len() < enough {
                for t in neighbours.of(self.members[next]) {
                    if is_in(&self.plane, t) && take(t) {
                        self.members.push(t);
                        self.add_corners(surface, hanging, t);
                    }
                }
                next += 1;
            }
            if self.members.len() == before {
                return;
            }
            let points = self.corners.iter().map(|&c| (surface.corners[c], 1.0));
            self.plane = self.plane.nearest(points);
        }
    }
}

/// The triangles that continue each one beyond its edges, as pairs of it and another, in their order.
struct Neighbours {
    pairs: Vec<[usize; 2]>,
    /// Where those of each triangle begin.
    starts: Vec<usize>,
}

impl Neighbours {
    /// Beyond edges that two triangles share that are not folded onto each other. Of more than two at an edge those without a width count as none.
    fn new(surface: &SharedEdges, rounding: f64) -> Self {
        let mut pairs = Vec::with_capacity(3 * surface.triangles.len());
        for sides in surface.edges() {
            // The way from the edge to the corner that is no end of it.
            let across = |side: &Side| {
                let [a, b] = side.ends.map(|c| surface.corners[c]);
                let (along, way) = ((b - a).normalised(), surface.corners[side.third] - a);
                way - along * along.dot(way)
            };
            let is_sliver = |side: &Side| across(side).norm() <= rounding;
            let (one, other) = match *sides {
                [one, other] => (one, other),
                [_, _, _, ..] => {
                    let mut wide = sides.iter().filter(|side| !is_sliver(side));
                    match (wide.next(), wide.next(), wide.next()) {
                        (Some(one), Some(other), None) => (*one, *other),
                        _ => continue,
                    }
                }
                _ => continue,
            };
            let is_beyond = across(&one).dot(across(&other)) < 0.0;
            if one.triangle == other.triangle
                || !(is_beyond || is_sliver(&one) || is_sliver(&other))
            {
                continue;
            }
            pairs.push([one.triangle, other.triangle]);
            pairs.push([other.triangle, one.triangle]);
        }
        pairs.sort_unstable();
        pairs.dedup();
        let mut starts = vec![0; surface.triangles.len() + 1];
        for [own, _] in &pairs {
            starts[own + 1] += 1;
        }
        for k in 0..surface.triangles.len() {
            starts[k + 1] += starts[k];
        }
        Neighbours { pairs, starts }
    }

    fn of(&self, triangle: usize) -> impl Iterator<Item = usize> + '_ {
        let [from, to] = [triangle, triangle + 1].map(|k| self.starts[k]);
        self.pairs[from..to].iter().map(|pair| pair[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;

    /// As a file has it.
    fn in_single_precision(triangles: &[Triangle]) -> Vec<Triangle> {
        let single = |x: f64| f64::from(x as f32);
        let rounded = |p: Vector3| Vector3::from_array(p.to_array().map(single));
        triangles.iter().map(|t| t.map(rounded)).collect()
    }

    /// As a file of text has it that gives so many digits of each number.
    fn in_digits(triangles: &[Triangle], digits: usize) -> Vec<Triangle> {
        let read = |x: f64| format!("{x:.*e}", digits - 1).parse().unwrap();
        let rounded = |p: Vector3| Vector3::from_array(p.to_array().map(read));
        triangles.iter().map(|t| t.map(rounded)).collect()
    }

    /// Each triangle as four, three times.
    fn divided(mut triangles: Vec<Triangle>) -> Vec<Triangle> {
        for _ in 0..3 {
            triangles = (triangles.iter())
                .flat_map(|&[a, b, c]| {
                    let [p, q, r] = [(a, b), (b, c), (c, a)].map(|(from, to)| (from + to) * 0.5);
                    [[a, p, r], [p, b, q], [r, q, c], [p, q, r]]
                })
                .collect();
        }
        triangles
    }

    /// The sides of a block of any size and direction, far from the origin.
    fn block(random: &mut Random) -> Vec<Triangle> {
        let q = random.quaternion();
        let frame = super::super::Ellipsoid::new([1.0; 3], q).unwrap();
        let size = [0; 3].map(|_| random.uniform(0.3, 3.0));
        let middle = Vector3::new(random.uniform(-9.0, 9.0), random.uniform(-9.0, 9.0), 4.0);
        let corner = |k: usize| {
            let own = core::array::from_fn(|m| size[m] * (f64::from((k >> m & 1) as u32) - 0.5));
            middle + frame.to_world(Vector3::from_array(own))
        };
        let sides = [
            [0, 1, 3, 2],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 3, 7, 6],
            [0, 2, 6, 4],
            [1, 3, 7, 5],
        ];
        let triangles = |s: &[usize; 4]| {
            let [a, b, c, d] = s.map(corner);
            [[a, b, c], [a, c, d]]
        };
        sides.iter().flat_map(triangles).collect()
    }

    /// The largest height of a corner of a triangle over the plane of one beside it, where the same of the exact surface is nothing.
    fn unevenness(triangles: &[Triangle], exact: &[Triangle]) -> f64 {
        let surface = SharedEdges::new(triangles);
        let mut most = 0.0f64;
        for sides in surface.edges() {
            let &[one, other] = sides else { continue };
            let highest = |all: &[Triangle]| {
                let plane = Plane::of(all[one.triangle]).unwrap();
                let heights = all[other.triangle].map(|p| plane.height(p).abs());
                heights.into_iter().fold(0.0, f64::max)
            };
            if highest(exact) < 1e-12 {
                most = most.max(highest(triangles));
            }
        }
        most
    }

    #[test]
    fn the_sides_of_a_block_are_flat_again() {
        let mut random = Random::new(31);
        for case in 0..30 {
            let exact = divided(block(&mut random));
            let mut rounded = match case % 3 {
                0 => in_single_precision(&exact),
                digits => in_digits(&exact, 5 + digits),
            };
            let before = unevenness(&rounded, &exact);
            let largest = rounding(&rounded).expect("few digits");
            let moved = flatten(&mut rounded, largest);
            let after = unevenness(&rounded, &exact);
            assert!(before > 1e-8 && after < 1e-13, "{before} {after}");
            assert!(moved > 0.0 && moved < 4.0 * largest, "{moved} {largest}");
            for (own, other) in rounded.iter().zip(&exact) {
                for (p, q) in own.iter().zip(other) {
                    assert!((*p - *q).norm() < 4.0 * largest);
                }
            }
        }
    }

    /// A surface of divided triangles, of which six meet at each corner: the corners stay, and each plane goes through its three.
    #[test]
    fn corners_of_many_flat_pieces_stay() {
        let mut random = Random::new(37);
        let heights: Vec<f64> = (0..36).map(|_| random.uniform(-0.3, 0.3)).collect();
        let at = |i: usize, j: usize| Vector3::new(i as f64, j as f64, heights[6 * i + j]);
        let exact: Vec<Triangle> = (0..25)
            .flat_map(|k| {
                let (i, j) = (k / 5, k % 5);
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect();
        let fine = divided(exact.clone());
        let mut rounded = in_single_precision(&fine);
        let largest = rounding(&rounded).expect("single precision");
        flatten(&mut rounded, largest);
        let after = unevenness(&rounded, &fine);
        assert!(after < 1e-13, "{after}");
        // Those that are not at the border.
        let inner = |p: &&Vector3| p.x > 0.5 && p.x < 4.5 && p.y > 0.5 && p.y < 4.5;
        for corner in in_single_precision(&exact).iter().flatten().filter(inner) {
            assert!(rounded.iter().flatten().any(|p| p == corner));
        }
    }

    /// What was flat stays as it is to the last bit, and so does a surface that is curved.
    #[test]
    fn nothing_moves_that_was_not_rounded() {
        let mut random = Random::new(41);
        let mut whole = divided(block(&mut random));
        let before = whole.clone();
        assert_eq!(rounding(&whole), None);
        assert_eq!(flatten(&mut whole, 1e-5), 0.0);
        assert_eq!(whole, before);
        let q = random.quaternion();
        let frame = super::super::Ellipsoid::new([1.0; 3], q).unwrap();
        let ring = |k: usize, z: f64| {
            let (sin, cos) = (core::f64::consts::TAU * k as f64 / 300.0).sin_cos();
            frame.to_world(Vector3::new(cos, sin, z))
        };
        // The two triangles of a facet are a flat piece, and move with it.
        let facets = (0..300).flat_map(|k| {
            let [a, b, c, d] = [
                ring(k, 0.0),
                ring(k + 1, 0.0),
                ring(k + 1, 0.2),
                ring(k, 0.2),
            ];
            [[a, b, c], [a, c, d]]
        });
        let exact: Vec<Triangle> = facets.collect();
        let rounded = in_single_precision(&exact);
        let mut flat = rounded.clone();
        let largest = rounding(&rounded).expect("single precision");
        let moved = flatten(&mut flat, largest);
        let [before, after] = [&rounded, &flat].map(|all| unevenness(all, &exact));
        assert!(
            moved < 10.0 * largest && before > 1e-9 && after < 1e-14,
            "{moved} {before} {after}"
        );
    }

    #[test]
    fn how_exact_the_numbers_of_a_file_are() {
        let with = |x: f64| {
            [[
                Vector3::new(1.0, 0.5, 0.0),
                Vector3::new(x, 0.0, 0.0),
                Vector3::ZERO,
            ]]
        };
        let single = 2.0 * f64::from(f32::EPSILON);
        for (x, expected) in [
            (2.0, Some(1e-5)),
            (0.25, Some(1e-5)),
            (123.456, Some(1e-3)),
            (-1.234567, Some(1e-6)),
            (0.12345678, Some(single.max(1e-7))),
            (f64::from(core::f32::consts::FRAC_1_SQRT_2), Some(single)),
            (core::f64::consts::FRAC_1_SQRT_2, None),
        ] {
            let found = rounding(&with(x));
            let is_close = match (found, expected) {
                (Some(found), Some(expected)) => (found / expected - 1.0).abs() < 1e-12,
                _ => found == expected,
            };
            assert!(is_close, "{x}: {found:?} {expected:?}");
        }
        assert_eq!(rounding(&[[Vector3::ZERO; 3]]), None);
    }
}
