// SPDX-License-Identifier: MIT OR Apache-2.0
//! An ellipsoid and a surface of triangles.
//!
//! The surface acts where its distance from the body's deepest reach is a minimum: on a face, if the deepest point lies
//! over it; on an edge or a corner, if the normal there lies in the cone between the adjacent faces. An edge between
//! coplanar triangles, or at the bottom of a fold, has no such cone and never acts; so a body that lies on any number of
//! coplanar triangles touches once. Both sides of a triangle act; the body's centre decides which.

use super::ellipsoid::Ellipsoid;
use super::interior_point::nearest_normal;
use super::vector::{Symmetric2, Tangent, Vector3};

/// Three corners.
pub type Triangle = [Vector3; 3];

/// Which part of a triangle touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Feature {
    /// Its plane.
    Face,
    /// An edge; the unit vector along it.
    Edge(Vector3),
    /// A corner.
    Corner,
}

/// A contact with a surface of triangles.
#[derive(Clone, Copy, Debug)]
pub struct TriangleContact {
    /// The point of the surface deepest in the body, world frame.
    pub point: Vector3,
    /// Unit normal out of the surface, towards the body.
    pub normal: Vector3,
    /// Penetration > 0.
    pub penetration: f64,
    /// Index of the triangle that stands for the contact.
    pub triangle: usize,
    /// What touches.
    pub feature: Feature,
}

/// Sine of an angle, and share of a length, that count as none.
const TOLERANCE: f64 = 1e-9;

/// Contacts on adjacent triangles whose normals differ by less than this are one, the deepest: the surface is then a
/// smooth one in small flat pieces. Cosine of 3 degrees.
const SMOOTH: f64 = 0.998_629_534_754_573_9;

/// The contacts of a body with centre `centre`, deepest first, appended to `contacts`. The triangles are all those near the
/// body: an edge at which one is missing counts as a free edge.
pub fn touch_triangles(
    body: &Ellipsoid,
    centre: Vector3,
    triangles: &[Triangle],
    contacts: &mut Vec<TriangleContact>,
) {
    let start = contacts.len();
    // Reach of the body along the world axes: most triangles are out of it.
    let reach = [
        Vector3::new(1.0, 0.0, 0.0),
        Vector3::new(0.0, 1.0, 0.0),
        Vector3::new(0.0, 0.0, 1.0),
    ]
    .map(|e| body.support(e).h);
    let near = |t: &Triangle| {
        let position = centre.to_array();
        let corners = t.map(|p| p.to_array());
        (0..3).all(|k| {
            let low = corners.iter().fold(f64::INFINITY, |m, p| m.min(p[k]));
            let high = corners.iter().fold(f64::NEG_INFINITY, |m, p| m.max(p[k]));
            low <= position[k] + reach[k] && high >= position[k] - reach[k]
        })
    };
    for (index, triangle) in triangles.iter().enumerate() {
        if near(triangle) {
            touch_face(body, centre, index, triangle, contacts);
            touch_edges(body, centre, index, triangles, contacts);
            touch_corners(body, centre, index, triangles, contacts);
        }
    }
    contacts[start..].sort_by(|a, b| b.penetration.total_cmp(&a.penetration));
    let size = reach.iter().copied().fold(0.0, f64::max);
    let mut kept = start;
    for k in start..contacts.len() {
        let c = contacts[k];
        let known = contacts[start..kept].iter_mut().find(|d| {
            d.normal.dot(c.normal) > SMOOTH
                && ((d.point - c.point).norm() <= 1e-6 * size
                    || adjacent(&triangles[d.triangle], &triangles[c.triangle]))
        });
        match known {
            // Where the deepest point lies over an edge or a corner, to rounding, the face has it.
            Some(d) if c.feature == Feature::Face && d.feature != Feature::Face => {
                if c.penetration >= d.penetration - TOLERANCE * size {
                    *d = c;
                }
            }
            Some(_) => {}
            None => {
                contacts[kept] = c;
                kept += 1;
            }
        }
    }
    contacts.truncate(kept);
}

/// The same point of a mesh, which every triangle keeps for itself.
fn same(a: Vector3, b: Vector3, scale: f64) -> bool {
    (a - b).norm_squared() <= (TOLERANCE * scale).powi(2)
}

fn size(t: &Triangle) -> f64 {
    (t[1] - t[0]).norm().max((t[2] - t[0]).norm())
}

fn adjacent(a: &Triangle, b: &Triangle) -> bool {
    let scale = size(a);
    a.iter().any(|p| b.iter().any(|q| same(*p, *q, scale)))
}

fn touch_face(
    body: &Ellipsoid,
    centre: Vector3,
    index: usize,
    t: &Triangle,
    contacts: &mut Vec<TriangleContact>,
) {
    let cross = (t[1] - t[0]).cross(t[2] - t[0]);
    let twice_area = cross.norm();
    if !(twice_area > 0.0) {
        return;
    }
    let mut normal = cross * (1.0 / twice_area);
    let mut distance = normal.dot(centre - t[0]);
    if distance < 0.0 {
        normal = -normal;
        distance = -distance;
    }
    let support = body.support(-normal);
    let penetration = support.h - distance;
    if !(penetration > 0.0) {
        return;
    }
    let point = centre + support.point + normal * penetration;
    let face = cross * (1.0 / twice_area);
    let over = (0..3).all(|k| {
        let (a, b) = (t[k], t[(k + 1) % 3]);
        let edge = b - a;
        let inwards = face.cross(edge);
        inwards.dot(point - a) >= -TOLERANCE * twice_area
    });
    if over {
        contacts.push(TriangleContact {
            point,
            normal,
            penetration,
            triangle: index,
            feature: Feature::Face,
        });
    }
}

/// Unit vector in the plane of the triangle with corners `a`, `b`, `c`, across its edge `a b` (unit `along`), inwards.
fn inwards(a: Vector3, c: Vector3, along: Vector3) -> Option<Vector3> {
    let w = c - a;
    let across = w - along * along.dot(w);
    let length = across.norm();
    (length > 0.0).then(|| across * (1.0 / length))
}

fn touch_edges(
    body: &Ellipsoid,
    centre: Vector3,
    index: usize,
    triangles: &[Triangle],
    contacts: &mut Vec<TriangleContact>,
) {
    let t = &triangles[index];
    let scale = size(t);
    for k in 0..3 {
        let (a, b, c) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
        let length = (b - a).norm();
        if !(length > 0.0) {
            continue;
        }
        let along = (b - a) * (1.0 / length);
        let Some(own) = inwards(a, c, along) else {
            continue;
        };
        let Some(n) = nearest_across(body, a - centre, along) else {
            continue;
        };
        let normal = -n;
        if normal.dot(own) > TOLERANCE {
            continue;
        }
        let support = body.support(n);
        let penetration = support.h - n.dot(a - centre);
        if !(penetration > 0.0) {
            continue;
        }
        let point = centre + support.point - n * penetration;
        let place = along.dot(point - a);
        if place < -TOLERANCE * length || place > (1.0 + TOLERANCE) * length {
            continue;
        }
        let others_agree = triangles.iter().enumerate().all(|(other, q)| {
            if other == index {
                return true;
            }
            let at = |p: Vector3| (0..3).find(|&m| same(q[m], p, scale));
            match (at(a), at(b)) {
                (Some(m), Some(o)) if m != o => {
                    // An edge is looked at from the first of its triangles alone.
                    other > index
                        && inwards(a, q[3 - m - o], along)
                            .is_none_or(|u| normal.dot(u) <= TOLERANCE)
                }
                _ => true,
            }
        });
        if others_agree {
            contacts.push(TriangleContact {
                point: a + along * place,
                normal,
                penetration,
                triangle: index,
                feature: Feature::Edge(along),
            });
        }
    }
}

/// The unit vector `n` across `along` that makes `h(n) - n.y` smallest: from within the body to the surface nearest to the
/// line through `y`. `None` if the line does not pass through the body.
fn nearest_across(body: &Ellipsoid, y: Vector3, along: Vector3) -> Option<Vector3> {
    let basis = Tangent::new(along);
    // The body's outline along the line is the ellipse of the shape matrix in the two directions across.
    let scaled = |e: Vector3| body.semi_axes.componentwise(body.to_body(e));
    let (p, q) = (scaled(basis.u), scaled(basis.v));
    let outline = Symmetric2::new(p.norm_squared(), p.dot(q), q.norm_squared());
    let (small, large, minor) = outline.eigen();
    let place = basis.components(y);
    let minor_axis = minor;
    let major_axis = super::Vector2::new(-minor.v, minor.u);
    let local = [place.dot(minor_axis), place.dot(major_axis)];
    let n = nearest_normal([small.sqrt(), large.sqrt()], local)?;
    let mut n = basis
        .vector(minor_axis * n[0] + major_axis * n[1])
        .normalised();
    // The outline's matrix has lost digits of its minor axis; the support function has them.
    for _ in 0..3 {
        let t = along.cross(n);
        let support = body.support(n);
        let first = t.dot(support.point) - t.dot(y);
        let f = support.h - n.dot(y);
        let bend = (scaled(t).norm_squared() - t.dot(support.point).powi(2)) / support.h;
        let second = bend - f;
        if !(second > 0.0) || first.abs() > 0.1 * second {
            break;
        }
        n = (n - t * (first / second)).normalised();
    }
    Some(n)
}

fn touch_corners(
    body: &Ellipsoid,
    centre: Vector3,
    index: usize,
    triangles: &[Triangle],
    contacts: &mut Vec<TriangleContact>,
) {
    let t = &triangles[index];
    let scale = size(t);
    let in_cone = |normal: Vector3, q: &Triangle, m: usize| {
        (1..3).all(|o| {
            let edge = q[(m + o) % 3] - q[m];
            normal.dot(edge) <= TOLERANCE * edge.norm()
        })
    };
    for k in 0..3 {
        let corner = t[k];
        let local = body.to_body(corner - centre).to_array();
        let Some(n) = nearest_normal(body.semi_axes.to_array(), local) else {
            continue;
        };
        let n = body.to_world(Vector3::from_array(n)).normalised();
        let normal = -n;
        let penetration = body.support(n).h - n.dot(corner - centre);
        if !(penetration > 0.0) || !in_cone(normal, t, k) {
            continue;
        }
        let others_agree = triangles.iter().enumerate().all(|(other, q)| {
            if other == index {
                return true;
            }
            match (0..3).find(|&m| same(q[m], corner, scale)) {
                Some(m) => other > index && in_cone(normal, q, m),
                None => true,
            }
        });
        if others_agree {
            contacts.push(TriangleContact {
                point: corner,
                normal,
                penetration,
                triangle: index,
                feature: Feature::Corner,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(cells: usize, half: f64) -> Vec<Triangle> {
        let at = |i: usize, j: usize| {
            let x = |k: usize| half * (2.0 * k as f64 / cells as f64 - 1.0);
            Vector3::new(x(i), x(j), 0.0)
        };
        let mut all = vec![];
        for i in 0..cells {
            for j in 0..cells {
                let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                all.push([a, b, c]);
                all.push([a, c, d]);
            }
        }
        all
    }

    #[test]
    fn a_flat_sheet_touches_once_wherever_the_body_lies() {
        for cells in [1, 4, 48] {
            let sheet = sheet(cells, 1.0);
            for axes in [[0.3, 0.3, 0.3], [0.3, 0.1, 0.01], [0.3, 0.01, 0.01]] {
                for q in [
                    [1.0, 0.0, 0.0, 0.0],
                    [0.9, 0.3, 0.1, 0.2],
                    [0.7, 0.0, 0.7, 0.0],
                ] {
                    let body = Ellipsoid::new(axes, q).unwrap();
                    let down = Vector3::new(0.0, 0.0, -1.0);
                    let h = body.support(down).h;
                    for (x, y) in [(0.0, 0.0), (0.123, 0.217), (0.25, 0.1), (0.25, -0.25)] {
                        // the deepest point over (x, y)
                        let s = body.support(down).point;
                        let centre = Vector3::new(x - s.x, y - s.y, 0.98 * h);
                        let mut contacts = vec![];
                        touch_triangles(&body, centre, &sheet, &mut contacts);
                        assert_eq!(
                            contacts.len(),
                            1,
                            "{cells} {axes:?} {q:?} {x} {y}: {contacts:?}"
                        );
                        let c = contacts[0];
                        assert!((c.penetration - 0.02 * h).abs() < 1e-12);
                        assert!((c.normal - Vector3::new(0.0, 0.0, 1.0)).norm() < 1e-7);
                        assert_eq!(c.feature, Feature::Face);
                    }
                }
            }
        }
    }

    #[test]
    fn edges_and_corners_of_a_block_are_passed_without_a_jump() {
        // The block x < 0, z < 0 seen from above: top face and side face.
        let p = |x: f64, y: f64, z: f64| Vector3::new(x, y, z);
        let block = vec![
            [p(0.0, -5.0, 0.0), p(0.0, 5.0, 0.0), p(-5.0, 5.0, 0.0)],
            [p(0.0, -5.0, 0.0), p(-5.0, 5.0, 0.0), p(-5.0, -5.0, 0.0)],
            [p(0.0, -5.0, 0.0), p(0.0, -5.0, -5.0), p(0.0, 5.0, 0.0)],
            [p(0.0, 5.0, 0.0), p(0.0, -5.0, -5.0), p(0.0, 5.0, -5.0)],
        ];
        let body = Ellipsoid::new([0.5, 0.2, 0.1], [0.9, 0.1, 0.4, 0.1]).unwrap();
        let h = body.support(Vector3::new(0.0, 0.0, -1.0)).h;
        let mut last: Option<TriangleContact> = None;
        let mut seen_edge = false;
        for k in 0..2000 {
            let x = -1.0 + 2.0 * k as f64 / 2000.0;
            let mut contacts = vec![];
            touch_triangles(&body, p(x, 0.3, 0.99 * h), &block, &mut contacts);
            assert!(contacts.len() <= 1, "{x}: {contacts:?}");
            let now = contacts.first().copied();
            if let (Some(a), Some(b)) = (last, now) {
                assert!((a.penetration - b.penetration).abs() < 2e-3 * h);
                assert!((a.normal - b.normal).norm() < 0.1);
            }
            if let (Some(a), None) = (last, now) {
                assert!(a.penetration < 2e-3 * h, "lost at {x}: {a:?}");
            }
            seen_edge |= matches!(now.map(|c| c.feature), Some(Feature::Edge(_)));
            last = now;
        }
        assert!(seen_edge && last.is_none());
    }

    #[test]
    fn a_fold_acts_on_both_sides_and_not_at_its_bottom() {
        let p = |x: f64, y: f64, z: f64| Vector3::new(x, y, z);
        // Floor z = 0 and wall x = 0, the body in the quadrant x > 0, z > 0.
        let fold = vec![
            [p(0.0, -5.0, 0.0), p(5.0, -5.0, 0.0), p(0.0, 5.0, 0.0)],
            [p(5.0, -5.0, 0.0), p(5.0, 5.0, 0.0), p(0.0, 5.0, 0.0)],
            [p(0.0, -5.0, 0.0), p(0.0, 5.0, 0.0), p(0.0, 5.0, 5.0)],
            [p(0.0, -5.0, 0.0), p(0.0, 5.0, 5.0), p(0.0, -5.0, 5.0)],
        ];
        let body = Ellipsoid::new([0.2; 3], [1.0, 0.0, 0.0, 0.0]).unwrap();
        let mut contacts = vec![];
        touch_triangles(&body, p(0.19, 0.4, 0.18), &fold, &mut contacts);
        assert_eq!(contacts.len(), 2, "{contacts:?}");
        assert!((contacts[0].penetration - 0.02).abs() < 1e-12);
        assert!((contacts[1].penetration - 0.01).abs() < 1e-12);
    }
}
