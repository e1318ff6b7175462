// SPDX-License-Identifier: MIT OR Apache-2.0
//! An ellipsoid and a surface of triangles.
//!
//! The surface acts where its distance from the body's deepest reach is a minimum: on a face, if the deepest point lies
//! over it; on an edge or a corner, if the normal there points away from all triangles that meet at the point. Which
//! triangles meet is a question of place, not of shared corners: a triangle that passes within `MEETING` of a point
//! meets there, whatever mesh it belongs to and wherever its own corners are. So an edge between coplanar triangles, or one
//! that lies inside another triangle, or at the bottom of a fold, never acts, and a body that lies on any pieces of a
//! plane touches once. Both sides of a triangle act; the body's centre decides which.
//!
//! A face of which the body's deepest point has passed a concave fold goes on acting while the body still overlaps with it,
//! by its share (`facet_shares`): so a contact goes over a fold of any angle without a jump, and many small facets act as
//! the curved surface that they approach. Planes that do not cut each other within the overlap act in full.
//!
//! What is not continuous: where convex edges lie within the same overlap as folds. A face beyond a fold is there taken as
//! going on beyond its convex edges, and an edge that shares the overlap with a face is taken to hold its normal in the
//! gradient of the shares.

use super::ellipsoid::Ellipsoid;
use super::facet_shares::{share, Share, ShareMemory, SupportingPlane};
use super::interior_point::nearest_normal;
use crate::vector::{Symmetric2, Tangent, Vector2, Vector3};

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
    /// The point of the surface, or of the face's plane, deepest in the body, world frame.
    pub point: Vector3,
    /// Unit normal out of the surface, towards the body.
    pub normal: Vector3,
    /// Penetration > 0.
    pub penetration: f64,
    /// Index of the triangle that stands for the contact.
    pub triangle: usize,
    /// What touches.
    pub feature: Feature,
    /// By how much of Hertz' law it acts.
    pub share: Share,
}

/// Contacts of a body with a surface of triangles, and the memory to find them; kept between calls.
#[derive(Clone, Debug, Default)]
pub struct TriangleSearch {
    contacts: Vec<TriangleContact>,
    near: Vec<Near>,
    candidates: Vec<Candidate>,
    planes: Vec<SupportingPlane>,
    memory: ShareMemory,
}

/// Sine of an angle that counts as none.
const TOLERANCE: f64 = 1e-9;

/// Triangles meet where they are closer than this, over the smallest semi-axis: gaps, steps and slivers that are smaller
/// are taken as flaws of the mesh.
const MEETING: f64 = 1e-5;

/// Sine of the angle between two faces below which they are one plane.
const SAME_PLANE: f64 = 1e-8;

/// An edge or a corner whose normal differs from that of a contact at the same place by less is that contact. Cosine of 3
/// degrees.
const SAME_NORMAL: f64 = 0.998_629_534_754_573_9;

/// How far a face beyond a fold may be from the body, over the smallest semi-axis, and still cut the contacts of others: the
/// paraboloids of two faces differ at the fold, by more the longer the body is, and the cut must end before the face counts as
/// far.
const BEYOND: f64 = 1.0;

/// A triangle that may touch, with the body's centre as the origin.
#[derive(Clone, Copy, Debug)]
struct Near {
    index: usize,
    corners: Triangle,
    /// Towards the body's centre.
    normal: Vector3,
    low: [f64; 3],
    high: [f64; 3],
}

/// A plane that may support the body.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    /// As in [`SupportingPlane`].
    plane: SupportingPlane,
    /// The deepest point of the plane, from the body's centre.
    foot: Vector3,
    penetration: f64,
    triangle: usize,
    feature: Feature,
    /// The deepest point belongs to the surface.
    over: bool,
    /// False where the body does not reach the surface, though its plane may cut the contacts of others.
    reached: bool,
}

impl TriangleSearch {
    /// The contacts of the last call of [`TriangleSearch::touch`], deepest first.
    pub fn contacts(&self) -> &[TriangleContact] {
        &self.contacts
    }

    /// Finds the contacts of a body with centre `centre`. The triangles are all those near the body: an edge at which one is
    /// missing counts as a free edge.
    pub fn touch(&mut self, body: &Ellipsoid, centre: Vector3, triangles: &[Triangle]) {
        self.contacts.clear();
        self.candidates.clear();
        let meeting = MEETING * body.smallest_semi_axis();
        self.gather(body, centre, triangles, meeting);
        for k in 0..self.near.len() {
            self.face(body, k, meeting);
            self.edges(body, k, meeting);
            self.corners(body, k, meeting);
        }
        let largest = body.bounding_radius();
        self.candidates.sort_unstable_by(|a, b| {
            b.penetration
                .total_cmp(&a.penetration)
                .then(a.triangle.cmp(&b.triangle))
        });
        let mut kept = 0;
        for k in 0..self.candidates.len() {
            let c = self.candidates[k];
            match self.candidates[..kept]
                .iter_mut()
                .find(|d| same_contact(d, &c, largest, meeting))
            {
                Some(d) => {
                    let reached = d.reached || c.reached;
                    if (c.rank(), c.triangle) < (d.rank(), d.triangle) {
                        *d = c;
                    }
                    d.reached = reached;
                }
                None => {
                    self.candidates[kept] = c;
                    kept += 1;
                }
            }
        }
        self.candidates.truncate(kept);
        self.planes.clear();
        self.planes.extend(self.candidates.iter().map(|c| c.plane));
        for (k, c) in self.candidates.iter().enumerate() {
            if !c.reached {
                continue;
            }
            let share = match kept {
                1 => Share::WHOLE,
                _ => share(body, &self.planes, k, &mut self.memory),
            };
            if share.value > 0.0 {
                self.contacts.push(TriangleContact {
                    point: centre + c.foot,
                    normal: c.plane.normal,
                    penetration: c.penetration,
                    triangle: c.triangle,
                    feature: c.feature,
                    share,
                });
            }
        }
    }

    /// The triangles within the body's reach along the world axes, without slivers.
    fn gather(&mut self, body: &Ellipsoid, centre: Vector3, all: &[Triangle], meeting: f64) {
        self.near.clear();
        let reach = [
            Vector3::new(1.0, 0.0, 0.0),
            Vector3::new(0.0, 1.0, 0.0),
            Vector3::new(0.0, 0.0, 1.0),
        ]
        .map(|e| body.support(e).h + meeting);
        for (index, t) in all.iter().enumerate() {
            let corners = t.map(|p| p - centre);
            let axes = corners.map(|p| p.to_array());
            let low: [f64; 3] =
                core::array::from_fn(|k| axes.iter().fold(f64::INFINITY, |m, p| m.min(p[k])));
            let high: [f64; 3] =
                core::array::from_fn(|k| axes.iter().fold(f64::NEG_INFINITY, |m, p| m.max(p[k])));
            if !(0..3).all(|k| low[k] <= reach[k] && high[k] >= -reach[k]) {
                continue;
            }
            let sides: [Vector3; 3] = core::array::from_fn(|k| corners[(k + 1) % 3] - corners[k]);
            let cross = sides[0].cross(sides[1]);
            let twice_area = cross.norm();
            let longest = sides.iter().map(|e| e.norm()).fold(0.0, f64::max);
            if !(twice_area > meeting * longest) {
                continue;
            }
            let mut normal = cross * (1.0 / twice_area);
            if normal.dot(corners[0]) > 0.0 {
                normal = -normal;
            }
            self.near.push(Near {
                index,
                corners,
                normal,
                low,
                high,
            });
        }
    }

    fn face(&mut self, body: &Ellipsoid, k: usize, meeting: f64) {
        let t = &self.near[k];
        let normal = t.normal;
        let support = body.support(-normal);
        let penetration = support.h + normal.dot(t.corners[0]);
        let slack = BEYOND * body.smallest_semi_axis();
        if !(penetration > -slack) {
            return;
        }
        let foot = support.point + normal * penetration;
        // the point of the triangle that is deepest beneath the body's paraboloid
        let tangent = Tangent::new(-normal);
        let curvature = body.weingarten(&support, &tangent);
        let scale = Root::of(curvature);
        let place = |p: Vector3| scale.apply(tangent.components(p - foot));
        let deepest = nearest_to_origin(t.corners.map(place));
        let point = combine(&t.corners, deepest);
        let aside = place(point);
        let depth = penetration - 0.5 * aside.dot(aside);
        let over = (point - foot).norm_squared() <= meeting * meeting;
        if !over && !self.folds_up(k, point, meeting) {
            return;
        }
        self.candidates.push(Candidate {
            plane: SupportingPlane { point, normal },
            foot,
            penetration,
            triangle: self.near[k].index,
            feature: Feature::Face,
            over,
            reached: penetration > 0.0 && (over || depth > 0.0),
        });
    }

    /// Whether another triangle rises from the plane of this one at a point of its border, on the side of the body.
    fn folds_up(&self, own: usize, point: Vector3, meeting: f64) -> bool {
        let t = &self.near[own];
        self.near.iter().enumerate().any(|(k, q)| {
            let above = |normal: Vector3, corners: &Triangle| {
                corners.iter().any(|z| {
                    let way = *z - point;
                    normal.dot(way) > TOLERANCE * way.norm() + f64::MIN_POSITIVE
                })
            };
            let nowhere_below = |normal: Vector3, corners: &Triangle| {
                corners.iter().all(|z| {
                    let way = *z - point;
                    normal.dot(way) >= -(TOLERANCE * way.norm() + meeting)
                })
            };
            k != own
                && q.box_has(point, meeting)
                && above(t.normal, &q.corners)
                && above(q.normal, &t.corners)
                && nowhere_below(q.normal, &t.corners)
                && q.has(point, meeting)
        })
    }

    /// Whether a normal at a point points away from all triangles that meet there.
    fn is_outermost(&self, normal: Vector3, point: Vector3, meeting: f64) -> bool {
        self.near.iter().all(|q| {
            let away = q.corners.iter().all(|z| {
                let way = *z - point;
                normal.dot(way) <= TOLERANCE * way.norm()
            });
            away || !q.box_has(point, meeting) || !q.has(point, meeting)
        })
    }

    fn edges(&mut self, body: &Ellipsoid, k: usize, meeting: f64) {
        let t = self.near[k];
        for m in 0..3 {
            let (a, b, c) = (t.corners[m], t.corners[(m + 1) % 3], t.corners[(m + 2) % 3]);
            let length = (b - a).norm();
            let along = (b - a) * (1.0 / length);
            let Some(n) = nearest_across(body, a, along) else {
                continue;
            };
            let normal = -n;
            if normal.dot(c - a) > TOLERANCE * (c - a).norm() {
                continue;
            }
            let support = body.support(n);
            let penetration = support.h - n.dot(a);
            if !(penetration > 0.0) {
                continue;
            }
            let place = along.dot(support.point - a);
            if place < -meeting || place > length + meeting {
                continue;
            }
            let point = a + along * place;
            if self.is_outermost(normal, point, meeting) {
                self.candidates.push(Candidate {
                    plane: SupportingPlane { point, normal },
                    foot: point,
                    penetration,
                    triangle: t.index,
                    feature: Feature::Edge(along),
                    over: true,
                    reached: true,
                });
            }
        }
    }

    fn corners(&mut self, body: &Ellipsoid, k: usize, meeting: f64) {
        let t = self.near[k];
        for corner in t.corners {
            let local = body.to_body(corner).to_array();
            let Some(n) = nearest_normal(body.semi_axes.to_array(), local) else {
                continue;
            };
            let n = body.to_world(Vector3::from_array(n)).normalised();
            let normal = -n;
            let penetration = body.support(n).h - n.dot(corner);
            if penetration > 0.0 && self.is_outermost(normal, corner, meeting) {
                self.candidates.push(Candidate {
                    plane: SupportingPlane {
                        point: corner,
                        normal,
                    },
                    foot: corner,
                    penetration,
                    triangle: t.index,
                    feature: Feature::Corner,
                    over: true,
                    reached: true,
                });
            }
        }
    }
}

impl Candidate {
    /// Which of two candidates for one contact stands for it: the smaller.
    fn rank(&self) -> u8 {
        match self.feature {
            Feature::Face if self.over => 0,
            Feature::Face => 1,
            Feature::Edge(_) => 2,
            Feature::Corner => 3,
        }
    }
}

/// Whether two candidates are one contact: the same plane, or an edge or a corner beneath the deepest point of a face.
fn same_contact(a: &Candidate, b: &Candidate, largest: f64, meeting: f64) -> bool {
    let faces = a.feature == Feature::Face && b.feature == Feature::Face;
    let cosine = a.plane.normal.dot(b.plane.normal);
    if !faces && cosine > SAME_NORMAL && (a.foot - b.foot).norm() <= 3.0 * meeting {
        return true;
    }
    let apart = a.plane.normal.dot(a.plane.point - b.plane.point);
    cosine > 0.0
        && (a.plane.normal - b.plane.normal).norm() <= SAME_PLANE
        && apart.abs() <= 1e-12 * largest
}

impl Near {
    fn box_has(&self, p: Vector3, margin: f64) -> bool {
        let p = p.to_array();
        (0..3).all(|k| self.low[k] - margin <= p[k] && self.high[k] + margin >= p[k])
    }

    /// Whether the triangle passes within `margin` of a point.
    fn has(&self, p: Vector3, margin: f64) -> bool {
        let tangent = Tangent::new(self.normal);
        let place = self.corners.map(|c| tangent.components(c - p));
        let nearest = combine(&self.corners, nearest_to_origin(place));
        (nearest - p).norm_squared() <= margin * margin
    }
}

fn combine(corners: &Triangle, weights: [f64; 3]) -> Vector3 {
    corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2]
}

/// A square root `l` of a positive matrix, `l^T l`: lengths of `l x` are those of the matrix.
struct Root {
    uu: f64,
    uv: f64,
    vv: f64,
}

impl Root {
    fn of(m: Symmetric2) -> Self {
        let uu = m.uu.sqrt();
        Root {
            uu,
            uv: m.uv / uu,
            vv: (m.determinant() / m.uu).max(0.0).sqrt(),
        }
    }
    fn apply(&self, x: Vector2) -> Vector2 {
        Vector2::new(self.uu * x.u + self.uv * x.v, self.vv * x.v)
    }
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

/// The unit vector `n` across `along` that makes `h(n) - n.y` smallest: from within the body to the surface nearest to the
/// line through `y`. `None` if the line does not pass through the body.
pub(crate) fn nearest_across(body: &Ellipsoid, y: Vector3, along: Vector3) -> Option<Vector3> {
    let basis = Tangent::new(along);
    // The body's outline along the line is the ellipse of the shape matrix in the two directions across.
    let scaled = |e: Vector3| body.semi_axes.componentwise(body.to_body(e));
    let (p, q) = (scaled(basis.u), scaled(basis.v));
    let outline = Symmetric2::new(p.norm_squared(), p.dot(q), q.norm_squared());
    let (small, large, minor) = outline.eigen();
    let place = basis.components(y);
    let minor_axis = minor;
    let major_axis = Vector2::new(-minor.v, minor.u);
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

#[cfg(test)]
mod tests {
    use super::*;

    fn touch(body: &Ellipsoid, centre: Vector3, triangles: &[Triangle]) -> Vec<TriangleContact> {
        let mut search = TriangleSearch::default();
        search.touch(body, centre, triangles);
        search.contacts().to_vec()
    }

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
                        let contacts = touch(&body, centre, &sheet);
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
            let contacts = touch(&body, p(x, 0.3, 0.99 * h), &block);
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
        let contacts = touch(&body, p(0.19, 0.4, 0.18), &fold);
        assert_eq!(contacts.len(), 2, "{contacts:?}");
        assert!((contacts[0].penetration - 0.02).abs() < 1e-12);
        assert!((contacts[1].penetration - 0.01).abs() < 1e-12);
    }
}
