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
