// SPDX-License-Identifier: MIT OR Apache-2.0
//! A body and an infinite convex corner: the planes that bound it all pass through one point.

use super::ellipsoid::Ellipsoid;
use super::interior_point::nearest_normal;
use super::nearest_line::nearest_across;
#[cfg(not(feature = "std"))]
use crate::real::Real;
use crate::vector::Vector3;

/// What of a convex corner supports a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Support {
    /// The plane of this index.
    Plane(usize),
    /// The line of two planes: the unit vector along it, out of the body the unit normal, the deepest point.
    Line {
        along: Vector3,
        normal: Vector3,
        foot: Vector3,
    },
    /// The point that all planes have in common, with the unit normal out of the body.
    Apex { normal: Vector3 },
}

/// Where the corner behind all these planes through `apex`, of which `normals` point out of it, supports a body about the origin;
/// `None` if it does not reach it.
#[cfg_attr(not(feature = "std"), inline(never))]
pub(super) fn support(body: &Ellipsoid, apex: Vector3, normals: &[Vector3]) -> Option<Support> {
    // what lies on a plane counts as behind it: planes, lines and the apex go over into each other
    let margin = 1e-12 * body.bounding_radius();
    let is_behind = |foot: Vector3, own: &[usize]| {
        normals
            .iter()
            .enumerate()
            .all(|(k, n)| own.contains(&k) || n.dot(foot - apex) <= margin)
    };
    for (k, &n) in normals.iter().enumerate() {
        let deepest = body.support(-n);
        let penetration = deepest.h + n.dot(apex);
        if !(penetration > 0.0) {
            return None;
        }
        if is_behind(deepest.point + n * penetration, &[k]) {
            return Some(Support::Plane(k));
        }
    }
    for (j, &b) in normals.iter().enumerate() {
        for (i, &a) in normals[..j].iter().enumerate() {
            let across = a.cross(b);
            let square = across.norm_squared();
            if !(square > 1e-20) {
                continue;
            }
            let along = across * (1.0 / square.sqrt());
            let Some(normal) = nearest_across(body, apex, along) else {
                continue;
            };
            let g = a.dot(b);
            let (p, q) = (-normal.dot(a), -normal.dot(b));
            let least = -1e-12 * square;
            if p - g * q < least || q - g * p < least {
                continue;
            }
            let deepest = body.support(normal);
            let foot = apex + along * along.dot(deepest.point - apex);
            if deepest.h > normal.dot(apex) && is_behind(foot, &[i, j]) {
                return Some(Support::Line {
                    along,
                    normal,
                    foot,
                });
            }
        }
    }
    let local = body.to_body(apex).to_array();
    let n = nearest_normal(body.semi_axes.to_array(), local)?;
    let normal = body.to_world(Vector3::from_array(n)).normalised();
    Some(Support::Apex { normal })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;

    /// One, two or three planes: the normal out of the body is the one, of all in the cone of the planes' normals, along which the body has
    /// the least way out.
    #[test]
    fn the_support_is_the_shortest_way_out_of_the_corner() {
        let mut random = Random::new(23);
        // Nothing, planes, lines, the apex.
        let mut kinds = [0; 4];
        for k in 0..1500 {
            let semi_axes = [0; 3].map(|_| random.uniform(0.7, 1.0));
            let body = Ellipsoid::new(semi_axes, random.quaternion()).unwrap();
            let mean = random.direction();
            let count = 1 + k % 3;
            let normals: Vec<Vector3> = (0..count)
                .map(|_| (mean + random.direction() * 0.9).normalised())
                .collect();
            let volume = normals[0].cross(normals[count / 2]).dot(normals[count - 1]);
            if count == 3 && volume.abs() < 0.05 || count == 2 && normals[0].dot(normals[1]) > 0.95
            {
                continue;
            }
            let beside = random.direction();
            let deepest = body.support(-mean).point;
            let apex = deepest + mean * random.uniform(-0.05, 0.25) + beside * 0.3;
            let way_out = |u: Vector3| body.support(u).h - u.dot(apex);
            let mut least = f64::INFINITY;
            let parts = 60;
            for a in 0..=parts {
                for b in 0..=parts - a {
                    let weights = [a, b, parts - a - b].map(f64::from);
                    if (count..3).any(|m| weights[m] > 0.0) {
                        continue;
                    }
                    let sum = (normals.iter().zip(weights))
                        .fold(Vector3::ZERO, |sum, (n, w)| sum - *n * w);
                    least = least.min(way_out(sum.normalised()));
                }
            }
            let scene = format!("{body:?} {apex:?} {normals:?}");
            let Some(support) = support(&body, apex, &normals) else {
                assert!(least < 1e-3, "{least}: {scene}");
                kinds[0] += 1;
                continue;
            };
            let (normal, foot) = match support {
                Support::Plane(k) => {
                    kinds[1] += 1;
                    let deepest = body.support(-normals[k]);
                    let depth = deepest.h + normals[k].dot(apex);
                    (-normals[k], deepest.point + normals[k] * depth)
                }
                Support::Line {
                    along,
                    normal,
                    foot,
                } => {
                    kinds[2] += 1;
                    assert!(normal.dot(along).abs() < 1e-9, "{scene}");
                    let on_planes = normals.iter().filter(|n| n.dot(along).abs() < 1e-9);
                    assert_eq!(on_planes.count(), 2, "{scene}");
                    (normal, foot)
                }
                Support::Apex { normal } => {
                    kinds[3] += 1;
                    (normal, apex)
                }
            };
            let found = way_out(normal);
            assert!(
                found > 0.0 && found < least + 1e-12,
                "{found} {least}: {scene}"
            );
            assert!(found > least - 1e-3, "{found} {least}: {scene}");
            assert!((normal.norm() - 1.0).abs() < 1e-12);
            // On the surface of the corner, on the way out from the deepest point.
            let behind = normals.iter().map(|n| n.dot(foot - apex));
            assert!(behind.fold(f64::NEG_INFINITY, f64::max) < 1e-9, "{scene}");
            assert!((normal.dot(foot - apex)).abs() < 1e-9, "{scene}");
            let apart = body.support(normal).point - normal * found - foot;
            assert!(apart.norm() < 1e-8, "{apart:?} {support:?}: {scene}");
        }
        println!("{kinds:?}");
        assert!(kinds.iter().all(|count| *count > 50), "{kinds:?}");
    }
}
