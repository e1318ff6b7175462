// SPDX-License-Identifier: MIT OR Apache-2.0
//! Into which triangles must those of a surface be divided so that all of them meet edge to edge? Where corners of some lie on sides of others, as many
//! programs write meshes, the search for contacts would not see that an edge is one: there a triangle is divided from such corners to those opposite to them.

use super::flat_pieces;
use super::shared_edges::{Hanging, SharedEdges, ON_SIDE};
use super::triangle::Triangle;
use core::ops::Range;

/// A part of a triangle, or a whole one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    /// Of which.
    pub of: usize,
    /// Whose corners its own are: three of each triangle in their order.
    corners: [usize; 3],
}

impl Part {
    /// With the corners of these triangles.
    pub(crate) fn of_triangles(&self, all: &[Triangle]) -> Triangle {
        self.corners.map(|k| all[k / 3][k % 3])
    }
}

/// The parts of triangles that meet edge to edge, in the order of the triangles and with their sense; `None` if the triangles do so themselves. The time
/// goes with `n log n`.
pub(crate) fn parts(triangles: &[Triangle]) -> Option<Vec<Part>> {
    let surface = SharedEdges::new(triangles);
    let hanging = surface.hanging(ON_SIDE);
    parts_of(&surface, &hanging)
}

/// The same of a surface with these corners on sides of its triangles.
fn parts_of(surface: &SharedEdges, hanging: &[Hanging]) -> Option<Vec<Part>> {
    if hanging.is_empty() {
        return None;
    }
    let mut first = vec![0; surface.corners.len()];
    for (k, corner) in surface.triangles.as_flattened().iter().enumerate() {
        first[*corner] = k;
    }
    let mut all = Vec::with_capacity(surface.triangles.len() + hanging.len());
    let mut rest = hanging;
    for (of, own) in surface.triangles.iter().enumerate() {
        let (here, others) = rest.split_at(rest.partition_point(|h| h.triangle == of));
        rest = others;
        let mut from = 0;
        let chains = [0, 1, 2].map(|side| {
            let count = here[from..].partition_point(|h| h.side == side);
            from += count;
            from - count..from
        });
        divide(surface, here, (*own, chains), |corners| {
            // Its own corners, where they are that.
            let number = |c: usize| match own.iter().position(|o| *o == c) {
                Some(m) => 3 * of + m,
                None => first[c],
            };
            all.push(Part {
                of,
                corners: corners.map(number),
            });
        });
    }
    Some(all)
}

/// Both [`parts`] and the widths of [`flat_pieces`].
pub(crate) fn parts_and_widths(triangles: &[Triangle]) -> (Option<Vec<Part>>, Vec<f64>) {
    let mut surface = SharedEdges::new(triangles);
    let hanging = surface.hanging(ON_SIDE);
    let parts = parts_of(&surface, &hanging);
    surface.cut(&hanging);
    (parts, flat_pieces::widths_of(triangles, &surface))
}

/// Divides a triangle with corners on its sides, which are those of the ranges, from one near the middle of its longest side that has some to the corner
/// opposite, and so on.
fn divide(
    surface: &SharedEdges,
    hanging: &[Hanging],
    triangle: ([usize; 3], [Range<usize>; 3]),
    mut found: impl FnMut([usize; 3]),
) {
    let mut left = vec![triangle];
    while let Some((corners, chains)) = left.pop() {
        let places = corners.map(|c| surface.corners[c]);
        let length = |m: usize| (places[(m + 1) % 3] - places[m]).norm_squared();
        let sides = (0..3).filter(|m| !chains[*m].is_empty());
        let Some(side) = sides.max_by(|m, n| length(*m).total_cmp(&length(*n))) else {
            found(corners);
            continue;
        };
        let [a, b, c] = [0, 1, 2].map(|m| corners[(side + m) % 3]);
        let [on, beyond, before] = [0, 1, 2].map(|m| chains[(side + m) % 3].clone());
        let middle = (places[side] + places[(side + 1) % 3]) * 0.5;
        let way = |k: &usize| (surface.corners[hanging[*k].corner] - middle).norm_squared();
        let nearest = (on.clone()).min_by(|k, n| way(k).total_cmp(&way(n)));
        let cut = nearest.unwrap_or(on.start);
        let between = hanging[cut].corner;
        left.push(([between, b, c], [cut + 1..on.end, beyond, 0..0]));
        left.push(([a, between, c], [on.start..cut, 0..0, before]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;
    use crate::vector::Vector3;

    fn area(t: &Triangle) -> Vector3 {
        (t[1] - t[0]).cross(t[2] - t[0]) * 0.5
    }

    /// Of how many edges only one triangle is a part.
    fn open_edges(triangles: &[Triangle]) -> usize {
        let surface = SharedEdges::new(triangles);
        let count = surface.edges().filter(|sides| sides.len() == 1).count();
        count
    }

    fn of(triangles: &[Triangle]) -> Vec<Triangle> {
        let parts = parts(triangles).expect("corners on sides");
        parts.iter().map(|p| p.of_triangles(triangles)).collect()
    }

    /// A tetrahedron of which each side is divided in its own way, at the same or at other places of its edges: the parts leave no edge open, have
    /// the areas of the triangles, and their directions.
    #[test]
    fn all_parts_meet_edge_to_edge() {
        let mut random = Random::new(5);
        for case in 0..200 {
            let tip = [0; 4].map(|_| random.direction() * random.uniform(1.0, 2.0));
            let away = random.direction() * 50.0;
            let at = |k: usize| tip[k] + away;
            // Places of an edge that do not depend on its sense.
            let on = |a: usize, b: usize, share: f64| {
                let (a, b, share) = if a < b {
                    (a, b, share)
                } else {
                    (b, a, 1.0 - share)
                };
                at(a) + (at(b) - at(a)) * share
            };
            let mut triangles = Vec::new();
            for [a, b, c] in [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]] {
                let share = [0.5, 0.25, 0.75, 0.5][random.uniform(0.0, 4.0) as usize];
                match random.uniform(0.0, 3.0) as u32 {
                    0 => triangles.push([at(a), at(b), at(c)]),
                    1 => {
                        let m = on(a, b, share);
                        triangles.extend([[at(a), m, at(c)], [m, at(b), at(c)]]);
                    }
                    _ => {
                        let [p, q, r] = [(a, b), (b, c), (c, a)].map(|(a, b)| on(a, b, share));
                        let [a, b, c] = [a, b, c].map(at);
                        triangles.extend([[a, p, r], [p, b, q], [r, q, c], [p, q, r]]);
                    }
                }
            }
            let before = open_edges(&triangles);
            if before == 0 {
                assert!(parts(&triangles).is_none());
                continue;
            }
            let own = parts(&triangles).expect("corners on sides");
            assert_eq!(open_edges(&of(&triangles)), 0, "{case}");
            assert!(own.windows(2).all(|w| w[0].of <= w[1].of));
            for (k, t) in triangles.iter().enumerate() {
                let here = own.iter().filter(|p| p.of == k);
                let areas = here.map(|p| area(&p.of_triangles(&triangles)));
                let (mut sum, mut size) = (Vector3::ZERO, 0.0);
                for own in areas {
                    (sum, size) = (sum + own, size + own.norm());
                    assert!(own.dot(area(t)) > 0.0);
                }
                assert!((sum - area(t)).norm() < 1e-12);
                assert!((size - area(t).norm()).abs() < 1e-12);
            }
        }
    }

    /// One large triangle beside many: none of its parts is without an area, and each has one of the many beside it.
    #[test]
    fn a_large_triangle_beside_a_thousand() {
        let at = |k: f64, y: f64| Vector3::new(k / 1000.0, y, 0.3 * y.max(0.0));
        let mut triangles = vec![[at(0.0, 0.0), at(1000.0, 0.0), at(700.0, -1.0)]];
        triangles.extend((0..1000).map(|k| {
            let k = f64::from(k);
            [at(k + 1.0, 0.0), at(k, 0.0), at(k + 0.5, 0.001)]
        }));
        let all = of(&triangles);
        assert_eq!(all.len(), 2000);
        assert!(all.iter().all(|t| area(t).norm() > 1e-8));
        assert_eq!(open_edges(&all), 2 + 2 * 1000);
    }

    /// What meets edge to edge stays, and so does what has corners near to a side and not on it, or on its ends. A triangle without an area that closes the
    /// place of a corner on a side counts as none.
    #[test]
    fn what_counts_as_on_a_side() {
        let at = |x: f64, y: f64, z: f64| Vector3::new(x, y, z);
        let beside = |hanging: Vector3, closed: bool| {
            let (a, b) = (at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0));
            let mut all = vec![
                [a, b, at(0.5, 1.0, 0.2)],
                [hanging, a, at(0.2, -1.0, 0.1)],
                [b, hanging, at(0.8, -1.0, 0.1)],
            ];
            if closed {
                all.push([a, hanging, b]);
            }
            parts(&all).map(|all| all.len())
        };
        for closed in [false, true] {
            let count = if closed { 5 } else { 4 };
            assert_eq!(beside(at(0.3, 0.0, 0.0), closed), Some(count));
            assert_eq!(beside(at(0.3, 0.0, 1e-9), closed), Some(count));
            assert_eq!(beside(at(0.3, 5e-7, 1e-7), closed), Some(count));
        }
        for off in [at(0.3, 0.0, 1e-8), at(0.3, 1e-5, 2e-6), at(5e-7, 0.0, 0.0)] {
            assert_eq!(beside(off, false), None, "{off:?}");
        }
    }
}
