// SPDX-License-Identifier: MIT OR Apache-2.0
//! A body that lies so deep in a convex solid that its surfaces, edges and corners, each by itself, do not know it any more.
//!
//! An edge acts along the normal by which its line is least deep in the body. Of a body that is thin beside its depth that way may lead through the
//! solid. Among the ways that lead out of it there is still a shortest: with `n` out of the solid the depth is `h(n) + h_s(n) - n.x`, by the
//! support functions of body and solid and the place of the body's centre, and the shortest way is its least value over all `n`. While one
//! surface alone acts it is that surface's depth, so that the force goes on where a body gets deeper than the others can tell. A block asks where its
//! triangles find nothing, or where the body's centre is in it; a closed cylinder or cone also where what acts is deep, since that may be the longer way.

use super::shape::Grain;
use crate::geometry::interior_point::normal_towards;
use crate::vector::Vector3;

/// Share of the smallest semi-axis below which nothing is deep. Edges and corners lose bodies from two thirds of it on.
pub(super) const DEEP: f64 = 0.3;
/// Tries to find a plane that a body does not reach behind as far as that, after which the normals are looked at.
const MOST_TRIES: usize = 16;
/// Directions that are tried along an arc of normals, and around a circle.
const ALONG_ARC: usize = 32;
const AROUND: usize = 64;
/// Halvings of the angle between two of them: to rounding.
const HALVINGS: usize = 55;

/// A convex solid; normals are unit vectors that point out of it.
pub(super) trait Convex {
    /// Which of its places a normal belongs to.
    type Place;

    /// The point of the solid that is farthest along a direction; not finite where there is none.
    fn farthest(&self, n: Vector3) -> Vector3;

    /// Whether one of the normals that are known beforehand shows that body and solid are apart.
    fn is_apart(&self, grain: &Grain<'_>) -> bool;

    /// The point of the solid nearest to another; `None` of one that is in it.
    fn nearest(&self, p: Vector3) -> Option<Vector3>;

    /// Offers normals and their places, the one of the shortest way out among them; false where it knows that body and solid are apart.
    fn offer_normals(&self, grain: &Grain<'_>, offer: &mut dyn FnMut(Vector3, Self::Place))
        -> bool;
}

/// From the deepest point of the body, against `n`, to that of the solid.
pub(super) fn overlap<S: Convex>(solid: &S, grain: &Grain<'_>, n: Vector3) -> Vector3 {
    solid.farthest(n) - grain.centre - grain.body.support(-n).point
}

/// The normal, the depth and the place of the shortest way out of a solid; `None` for a body that is apart from it or not deep in it, as most are
/// that are asked about.
pub(super) fn shortest_way_out<S: Convex>(
    solid: &S,
    grain: &Grain<'_>,
) -> Option<(Vector3, f64, S::Place)> {
    let least_depth = DEEP * grain.body.smallest_semi_axis();
    let towards = |p: Vector3| (grain.centre - p).direction();
    if let Some(mut n) = solid.nearest(grain.centre).and_then(towards) {
        for _ in 0..MOST_TRIES {
            let w = overlap(solid, grain, n);
            // Along any normal a body is at least as deep as along that of the shortest way.
            if w.dot(n) <= least_depth {
                return None;
            }
            // Chung and Wang: the direction mirrored at the plane across the overlap.
            let Some(way) = w.direction() else { break };
            n = (n - way * (2.0 * n.dot(way))).normalised();
        }
    }
    if solid.is_apart(grain) {
        return None;
    }
    let mut least: Option<(Vector3, f64, S::Place)> = None;
    let mut reaches = true;
    let may_overlap = solid.offer_normals(grain, &mut |n, place| {
        let depth = overlap(solid, grain, n).dot(n);
        reaches &= depth > least_depth;
        if depth.is_finite() && least.as_ref().is_none_or(|(_, other, _)| depth < *other) {
            least = Some((n, depth, place));
        }
    });
    least.filter(|_| may_overlap && reaches)
}

/// Calls `found` with each normal between two unit vectors across each other, `from` and `to`, along which the depth of the point `p` has a minimum.
pub(super) fn minima_of_arc(
    grain: &Grain<'_>,
    p: Vector3,
    [from, across]: [Vector3; 2],
    angle: f64,
    mut found: impl FnMut(Vector3),
) {
    let offset = p - grain.centre;
    let normal = |a: f64| from * a.cos() + across * a.sin();
    let rises = |a: f64| {
        let turned = across * a.cos() - from * a.sin();
        turned.dot(offset - grain.body.support(-normal(a)).point) > 0.0
    };
    let step = angle / ALONG_ARC as f64;
    let mut before = rises(0.0);
    for k in 1..=ALONG_ARC {
        let here = rises(k as f64 * step);
        if !before && here {
            let (mut low, mut high) = ((k - 1) as f64 * step, k as f64 * step);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if rises(middle) {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            found(normal(0.5 * (low + high)));
        }
        before = here;
    }
}

/// A circle in which two smooth surfaces of a solid of revolution meet.
pub(super) struct Circle {
    pub centre: Vector3,
    pub axis: Vector3,
    /// Two unit vectors across the axis and each other.
    pub basis: [Vector3; 2],
    pub radius: f64,
    /// Normals of the two surfaces, along the radius and along the axis.
    pub normals: [[f64; 2]; 2],
}

impl Circle {
    /// Calls `found` with normals between those of the two surfaces along which the depth has a minimum, and the direction of the radius there.
    pub fn minima(&self, grain: &Grain<'_>, mut found: impl FnMut(Vector3, Vector3)) {
        let [a, b] = self.normals;
        let angle = (a[0] * b[0] + a[1] * b[1]).clamp(-1.0, 1.0).acos();
        let step = core::f64::consts::TAU / AROUND as f64;
        let radial = |turn: f64| self.basis[0] * turn.cos() + self.basis[1] * turn.sin();
        // The least deep normal there, and whether the depth rises with the turn.
        let at = |turn: f64| {
            let u = radial(turn);
            let world = |[r, z]: [f64; 2]| u * r + self.axis * z;
            let (from, to) = (world(a), world(b));
            let across = (to - from * from.dot(to)).normalised();
            let p = self.centre + u * self.radius;
            let way = |n: Vector3| p - grain.centre - grain.body.support(-n).point;
            let mut least: Option<(f64, Vector3)> = None;
            minima_of_arc(grain, p, [from, across], angle, |n| {
                let depth = way(n).dot(n);
                if least.is_none_or(|(other, _)| depth < other) {
                    least = Some((depth, n));
                }
            });
            least.map(|(_, n)| (n, self.axis.cross(u).dot(way(n)) > 0.0))
        };
        let mut before = at(0.0);
        for k in 1..=AROUND {
            let here = at(k as f64 * step);
            if let (Some((_, false)), Some((_, true))) = (before, here) {
                let (mut low, mut high) = ((k - 1) as f64 * step, k as f64 * step);
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (low + high);
                    match at(middle) {
                        Some((_, true)) => high = middle,
                        _ => low = middle,
                    }
                }
                if let Some((n, _)) = at(high) {
                    found(n, radial(high));
                }
            } else if let Some((n, _)) = here {
                // Where the arc has no minimum a little further: near enough.
                found(n, radial(k as f64 * step));
            }
            before = here;
        }
    }
}

/// Calls `found` with the normals along which the depth of a point in the body may have a minimum: to the nearest place of the body's surface, and to that
/// on the other side of its thinnest axis.
pub(super) fn minima_of_point(grain: &Grain<'_>, p: Vector3, mut found: impl FnMut(Vector3)) {
    let body = grain.body;
    let (a, y) = (
        body.semi_axes.to_array(),
        body.to_body(p - grain.centre).to_array(),
    );
    let mut offer = |n: [f64; 3]| {
        if let Some(n) = Vector3::from_array(n).direction() {
            found(-body.to_world(n));
        }
    };
    let first = normal_towards(a, y);
    offer(first);
    let least = (0..3).fold(0, |m, k| if a[k] < a[m] { k } else { m });
    let gap = |k: usize| (a[k] - a[least]) * (a[k] + a[least]);
    let narrowest = (0..3)
        .filter(|k| *k != least)
        .map(gap)
        .fold(f64::INFINITY, f64::min);
    if y[least] == 0.0 {
        let mut mirrored = first;
        mirrored[least] = -mirrored[least];
        offer(mirrored);
        return;
    }
    // As in `normal_towards`, between the pole at 0 and the next one below it: the sum is convex there, and the minimum is the root near 0.
    let bottom = |k: usize, s: f64| s + if k == least { 0.0 } else { gap(k) };
    let term = |k: usize, s: f64| (a[k] * y[k] / bottom(k, s)).powi(2);
    let slope = |s: f64| (0..3).map(|k| -term(k, s) / bottom(k, s)).sum::<f64>();
    let value = |s: f64| (0..3).map(|k| term(k, s)).sum::<f64>() - 1.0;
    let between = |mut low: f64, mut high: f64, is_high: &dyn Fn(f64) -> bool| {
        for _ in 0..2 * HALVINGS {
            let middle = 0.5 * (low + high);
            if is_high(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        low
    };
    let lowest = between(-narrowest, 0.0, &|s| slope(s) > 0.0);
    if lowest < 0.0 && value(lowest) < 0.0 {
        let s = between(lowest, 0.0, &|s| value(s) > 0.0);
        offer(core::array::from_fn(|k| y[k] / bottom(k, s)));
    }
}
