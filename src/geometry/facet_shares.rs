// SPDX-License-Identifier: MIT OR Apache-2.0
//! How several planes that support one body divide its contact among them.
//!
//! At a concave fold a body may lie on two planes at once. Hertz' law of both in full counts the overlap near the fold
//! twice, and that of one alone jumps where the other takes over. So each plane acts by its share: the part of its section
//! with the body that the other planes leave it, weighed.
//!
//! - **The section** of an ellipsoid with a plane is an ellipse. With the ellipsoid mapped to the unit sphere, plane `c` is
//!   the plane `m_c . u = p_c` (`m_c` a unit vector, `p_c = 1 - delta/h`), the section a disc of radius `sqrt(1 - p_c^2)`, and
//!   plane `k` cuts it along a chord, at `(p_k - g p_c)/sqrt((1 - p_c^2)(1 - g^2))` of the radius from the centre,
//!   `g = m_c . m_k`. Both planes have the chord in common, and a plane, an edge or a triangle that misses the ellipsoid
//!   misses the discs: the share of a face vanishes before the face is out of reach.
//! - **The weight** is `15/(4 pi) (1 - r^2) r (1 + beta cos 2 theta)` over the unit disc, the depth times the slope of the cap
//!   beyond the plane, whose integral is 1. `theta` is the angle from the section's longer axis, and `beta` (see
//!   `anisotropy`) makes many facets the curved surface.
//! - The elastic energy is the sum of `w U` over the planes, `U` that of Hertz on the whole plane, so force and torque are
//!   continuous and keep energy. Beside the law's own terms times `w` they are `-U grad w`, of which the gradient stands here.
//! - A plane that no other one cuts has `w = 1`, and planes that continue one another, cut along any line, sum to one:
//!   a flat surface is the plane in whatever pieces it comes.

use super::ellipsoid::Ellipsoid;
use super::lists::{on_heap, InRoom, Lent, List, Lists, OnHeap};
pub use super::share::Share;
#[cfg(not(feature = "std"))]
use crate::real::{Functions, Real};
use crate::vector::{Tangent, Vector3};
use core::f64::consts::{PI, TAU};

/// A plane that supports a body, with the body's centre as the origin.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct SupportingPlane {
    /// A point of the plane near the contact, from the body's centre.
    pub point: Vector3,
    /// Unit normal out of the wall, towards the body.
    pub normal: Vector3,
}

/// Memory for [`share`].
pub struct ShareMemory<M: Lists = OnHeap> {
    lines: M::List<Line>,
    arcs: M::List<[f64; 2]>,
}

on_heap!(ShareMemory: lines arcs);

impl<'m> ShareMemory<InRoom<'m>> {
    /// In room of somebody's.
    pub(super) fn in_room(lines: &'m mut [Line], arcs: &'m mut [[f64; 2]]) -> Self {
        ShareMemory {
            lines: Lent::new(lines),
            arcs: Lent::new(arcs),
        }
    }
}

impl<M: Lists> ShareMemory<M> {
    /// Whether something did not fit.
    pub(super) fn lacks_room(&self) -> bool {
        self.lines.lacks_room() || self.arcs.lacks_room()
    }
}

/// Lines that are within this of each other all over the unit disc are the same. Planes of a mesh whose angle is small meet in a line that is
/// rounded off by up to the accuracy of a double over that angle.
const SAME_LINE: f64 = 1e-9;

/// A plane in the frame in which the body is the unit sphere.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Section {
    /// Out of the body, world frame.
    normal: Vector3,
    /// Support function and witness along it.
    h: f64,
    witness: Vector3,
    /// Unit normal in the sphere's frame, the body's axes scaled by the semi-axes.
    m: Vector3,
    /// Distance from the sphere's centre: 1 where the plane touches.
    p: f64,
    /// Squared radius of the section.
    square: f64,
}

impl Section {
    /// Of no plane.
    pub(super) const NONE: Section = Section {
        normal: Vector3::ZERO,
        h: 0.0,
        witness: Vector3::ZERO,
        m: Vector3::ZERO,
        p: 0.0,
        square: 0.0,
    };

    /// That of a plane.
    #[cfg_attr(not(feature = "std"), inline(never))]
    pub fn new(body: &Ellipsoid, plane: &SupportingPlane) -> Self {
        let normal = -plane.normal;
        let support = body.support(normal);
        let h = support.h;
        let p = normal.dot(plane.point) / h;
        let below = (h + plane.normal.dot(plane.point)) / h;
        Section {
            normal,
            h,
            witness: support.point,
            m: body.semi_axes.componentwise(support.local_normal) * support.inverse_h,
            p,
            square: below * (1.0 + p),
        }
    }

    /// Whether another plane cuts into this section.
    pub fn is_cut_by(&self, other: &Section) -> bool {
        let (reach, sine) = self.chord(other);
        reach < sine * self.square.max(0.0).sqrt()
    }

    /// The distance of the chord from the section's centre, in radii of the sphere and times the sine of the angle between the
    /// planes; and that sine. Rounding of nearly parallel planes moves the chord alike in both sections, so that
    /// it does not show in the sum over both.
    fn chord(&self, other: &Section) -> (f64, f64) {
        let apart = (other.m - self.m).norm_squared();
        let g = self.m.dot(other.m);
        // 1 - g, without cancellation where g is near 1
        let less = if g > 0.0 { 0.5 * apart } else { 1.0 - g };
        (
            (other.p - self.p) + less * self.p,
            (less * (2.0 - less)).max(0.0).sqrt(),
        )
    }

    /// The gradient of `p` along the body's rotation.
    fn p_by_rotation(&self) -> Vector3 {
        self.h_by_rotation() * (-self.p / self.h)
    }

    fn h_by_rotation(&self) -> Vector3 {
        self.witness.cross(self.normal)
    }
}

/// The line along which another plane cuts the unit disc: `(cos angle, sin angle).x <= distance` is what it leaves.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Line {
    distance: f64,
    distance_by_position: Vector3,
    distance_by_rotation: Vector3,
    angle_by_rotation: Vector3,
    angle: f64,
    sin: f64,
    cos: f64,
    /// Where the part of it that is left begins and ends, from its middle.
    from: f64,
    to: f64,
}

/// The share of a plane in the contact of `body`, of which these others cut its section; its own penetration must be greater
/// than 0. A plane of which another is in front over the whole section has the share 0. No other may be the same plane.
#[cfg_attr(not(feature = "std"), inline(never))]
pub fn share<'a, M: Lists>(
    body: &Ellipsoid,
    own: &Section,
    others: impl Iterator<Item = &'a Section>,
    memory: &mut ShareMemory<M>,
) -> Share {
    if !(own.square > 0.0) {
        return Share::NONE;
    }
    let frame = Tangent::new(own.m);
    let radius = own.square.sqrt();
    let stretched = |b: Vector3| body.to_world(body.semi_axes.componentwise(b));
    memory.lines.clear();
    memory.arcs.clear();
    for other in others {
        let g = own.m.dot(other.m);
        let (reach, sine) = own.chord(other);
        let size = sine * radius;
        if reach >= size {
            continue;
        }
        if reach <= -size {
            return Share::NONE;
        }
        let direction = frame.components(other.m - own.m);
        let length = direction.u.hypot(direction.v);
        let (cos, sin) = (direction.u / length, direction.v / length);
        let across = stretched(frame.v * cos - frame.u * sin);
        let by_other = 1.0 / size;
        let by_cosine = (reach * g / (sine * sine) - own.p) * by_other;
        let by_own = (reach * own.p / own.square - g) * by_other;
        let cosine_by_rotation = (other.witness.cross(own.normal) - own.h_by_rotation() * g)
            * (1.0 / own.h)
            + (own.witness.cross(other.normal) - other.h_by_rotation() * g) * (1.0 / other.h);
        memory.lines.push(Line {
            distance: reach / size,
            distance_by_position: other.normal * (-by_other / other.h)
                - own.normal * (by_own / own.h),
            distance_by_rotation: other.p_by_rotation() * by_other
                + own.p_by_rotation() * by_own
                + cosine_by_rotation * by_cosine,
            angle_by_rotation: across
                .cross(other.normal * (1.0 / other.h) - own.normal * (g / own.h))
                * (1.0 / sine),
            angle: sin.atan2(cos),
            sin,
            cos,
            from: 0.0,
            to: 0.0,
        });
    }
    if memory.lines.is_empty() {
        return Share::WHOLE;
    }
    if !cut(memory) {
        return Share::NONE;
    }
    remaining(&Anisotropy::new(body, own, &frame), memory)
}

/// Finds what the lines leave of each other and which arcs of the circle they take; false if they leave nothing of the disc.
#[cfg_attr(not(feature = "std"), inline(never))]
fn cut<M: Lists>(memory: &mut ShareMemory<M>) -> bool {
    let ShareMemory { lines, arcs, .. } = memory;
    let mut kept = 0;
    for next in 0..lines.len() {
        let mut line = lines[next];
        let p = line.distance;
        let half = p.acos();
        let start = (line.angle - half).rem_euclid(TAU);
        let end = start + 2.0 * half;
        arcs.push([start, end.min(TAU)]);
        if end > TAU {
            arcs.push([0.0, end - TAU]);
        }
        line.to = ((1.0 - p) * (1.0 + p)).sqrt();
        line.from = -line.to;
        let mut still = 0;
        for k in 0..kept {
            let mut other = lines[k];
            if !line.cut_beside(&mut other) {
                return false;
            }
            if other.from < other.to {
                lines[still] = other;
                still += 1;
            }
        }
        let is_left = line.from < line.to;
        if kept > 0 && still == 0 && !is_left {
            // None of them has a part in the border of what is left, which is not the whole disc: that is nothing.
            return false;
        }
        kept = still;
        if is_left {
            lines[kept] = line;
            kept += 1;
        }
    }
    lines.truncate(kept);
    true
}

impl Line {
    /// Of no plane.
    pub(super) const NONE: Line = Line {
        distance: 0.0,
        distance_by_position: Vector3::ZERO,
        distance_by_rotation: Vector3::ZERO,
        angle_by_rotation: Vector3::ZERO,
        angle: 0.0,
        sin: 0.0,
        cos: 0.0,
        from: 0.0,
        to: 0.0,
    };

    /// Takes away from this line and an earlier one what each cuts off the other; false if they leave nothing. Of two that are the same the
    /// earlier one stays.
    ///
    /// Planes that share a line, as the faces at a straight edge of a mesh, cut a section along one line. Where two such lines cross is a matter of
    /// rounding, and three would leave parts that close no border.
    fn cut_beside(&mut self, earlier: &mut Line) -> bool {
        let sin = earlier.sin * self.cos - earlier.cos * self.sin;
        let cos = earlier.cos * self.cos + earlier.sin * self.sin;
        let room = earlier.distance - self.distance * cos;
        if sin.abs() < SAME_LINE && room.abs() < SAME_LINE {
            self.to = self.from;
            return cos > 0.0;
        }
        if sin.abs() < 1e-14 {
            // They do not cross: of two that leave the same side the one stays that is farther in, of others both.
            if room < 0.0 {
                self.to = self.from;
            }
            if self.distance - earlier.distance * cos < 0.0 {
                earlier.to = earlier.from;
            }
            return true;
        }
        // One point of both, for each in its own measure: their parts meet there.
        let own = room / sin;
        let others = own * cos - self.distance * sin;
        if sin > 0.0 {
            self.to = self.to.min(own);
            earlier.from = earlier.from.max(others);
        } else {
            self.from = self.from.max(own);
            earlier.to = earlier.to.min(others);
        }
        true
    }
}

/// `beta (cos 2 t, sin 2 t)` of the weight in the frame of a section, `t` the angle of the longer axis, and its gradients along
/// the body's rotation.
struct Anisotropy {
    value: [f64; 2],
    by_rotation: [Vector3; 2],
}

impl Anisotropy {
    fn new(body: &Ellipsoid, own: &Section, frame: &Tangent) -> Self {
        let axes = body.semi_axes;
        let scaled = [frame.u, frame.v].map(|b| axes.componentwise(b));
        let [uu, vv] = scaled.map(|b| b.norm_squared());
        let uv = scaled[0].dot(scaled[1]);
        let inverse = 1.0 / (uu + vv);
        let shape = [(uu - vv) * inverse, 2.0 * uv * inverse];
        let ratio = 2.0 * (axes.x / own.h) * (axes.y * axes.z * inverse);
        let (factor, slope) = anisotropy(ratio);
        // The frame moves with the section without turning in it: its vectors change along `m` alone.
        let turned = scaled.map(|b| body.to_world(b).cross(own.normal) * (1.0 / own.h));
        let along = axes.componentwise(own.m);
        let tilt = scaled.map(|b| b.dot(along));
        let uu_by = turned[0] * (-2.0 * tilt[0]);
        let vv_by = turned[1] * (-2.0 * tilt[1]);
        let uv_by = turned[0] * -tilt[1] - turned[1] * tilt[0];
        let trace_by = (uu_by + vv_by) * inverse;
        let ratio_by = (own.h_by_rotation() * (1.0 / own.h) + trace_by) * -ratio;
        let by_rotation = [
            (uu_by - vv_by) * inverse - trace_by * shape[0],
            uv_by * (2.0 * inverse) - trace_by * shape[1],
        ];
        Anisotropy {
            value: shape.map(|s| s * factor),
            by_rotation: core::array::from_fn(|k| {
                by_rotation[k] * factor + ratio_by * (slope * shape[k])
            }),
        }
    }
}

/// `beta (A + B)/(B - A)` of the weight and its derivative along `x = 2 sqrt(A B)/(A + B)`, from 0 (slender) to 1 (round);
/// `A <= B` are the body's principal curvatures at the contact.
///
/// To first order in its curvature a fine tiling of a curved surface has the energy of Hertz on that surface if the second
/// moments of the weight along and across are `(3 -+ 2 x' sigma)/14`, `x' = (B - A)/(A + B)`, with `sigma` the function
/// that is twice the logarithmic derivative of Hertz' factor (docs/theory.md, section 2): `beta = -(4/3) sigma x'`. What
/// stands here for `sigma` is within 1 % up to B/A = 1e4 and within 7 % up to 1e6.
fn anisotropy(x: f64) -> (f64, f64) {
    let x = x.min(1.0);
    let q = (1.0 - x) / (1.0 + x);
    let bottom = 1.0 / (1.0 - 0.8 * q);
    let last = 0.012 * q * q * bottom;
    let sigma = 1.0 / 6.0 + q * (4.0 / 27.0 + last);
    let slope = 4.0 / 27.0 + last * (3.0 + 0.8 * q * bottom);
    let factor = -4.0 / 3.0;
    (
        factor * sigma,
        factor * slope * -2.0 / ((1.0 + x) * (1.0 + x)),
    )
}

/// The weight over what the lines leave of the unit disc.
#[cfg_attr(not(feature = "std"), inline(never))]
fn remaining<M: Lists>(anisotropy: &Anisotropy, memory: &mut ShareMemory<M>) -> Share {
    let ShareMemory { lines, arcs, .. } = memory;
    let mut share = Share::NONE;
    // The weights' parts with 1, cos 2 theta and sin 2 theta, times 2 pi.
    let (mut round, mut even, mut odd) = (0.0, 0.0, 0.0);
    let weight = 15.0 / (4.0 * PI);
    for line in lines.iter() {
        let (cos, sin) = (
            line.cos * line.cos - line.sin * line.sin,
            2.0 * line.cos * line.sin,
        );
        let p = line.distance;
        let at = |s: f64| {
            let square = p * p + s * s;
            let r = square.sqrt();
            let inverse = if p == 0.0 {
                0.0
            } else {
                p * p * (s / p.abs()).asinh()
            };
            // integrals along the line of p^2/r, r, r^3, s/r, s r, s r^3
            let first = 0.5 * (s * r + inverse);
            let third = 0.25 * s * r * square + 0.75 * p * p * first;
            let cube = r * square;
            [inverse, first, third, r, cube / 3.0, cube * square / 5.0]
        };
        let (a, b) = (at(line.from), at(line.to));
        let [j0, j1, j3, k1, k3, k5]: [f64; 6] = core::array::from_fn(|k| b[k] - a[k]);
        // over the triangle from the centre to the line, by cos and sin of twice the angle from the line's normal
        let own_round = p * (2.5 * j1 - 1.5 * j3);
        let own_even = p * (5.0 * j0 - 3.0 * p * p * j1) - own_round;
        let own_odd = p * p * (5.0 * k1 - 3.0 * k3);
        round += own_round;
        even += own_even * cos - own_odd * sin;
        odd += own_even * sin + own_odd * cos;
        // along the line, by the same
        let e = anisotropy.value[0] * cos + anisotropy.value[1] * sin;
        let o = anisotropy.value[1] * cos - anisotropy.value[0] * sin;
        let moved = (j1 - j3) * (1.0 - e) + 2.0 * e * (j0 - p * p * j1) + 2.0 * o * p * (k1 - k3);
        let turned = (k3 - k5) * (1.0 - e)
            + 2.0 * e * p * p * (k1 - k3)
            + 2.0 * o * p * (j1 - j0 - j3 + p * p * j1);
        share.by_position = share.by_position + line.distance_by_position * (weight * moved);
        share.by_rotation = share.by_rotation + line.distance_by_rotation * (weight * moved)
            - line.angle_by_rotation * (weight * turned);
    }
    arcs.sort_with(|a, b| a[0].total_cmp(&b[0]));
    let mut free = |from: f64, to: f64| {
        if to > from {
            let (a, b) = ((2.0 * from).sin_cos(), (2.0 * to).sin_cos());
            round += to - from;
            even += 0.5 * (b.0 - a.0);
            odd += 0.5 * (a.1 - b.1);
        }
    };
    let mut end = 0.0f64;
    for [a, b] in arcs.iter() {
        free(end, *a);
        end = end.max(*b);
    }
    free(end, TAU);
    let [e, o] = anisotropy.value;
    share.value = ((round + e * even + o * odd) / TAU).clamp(0.0, 1.0);
    share.by_rotation = share.by_rotation
        + anisotropy.by_rotation[0] * (even / TAU)
        + anisotropy.by_rotation[1] * (odd / TAU);
    share
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force::hertz_factors;
    use crate::geometry::radii_of_curvature;
    use crate::geometry::random::Random;
    use crate::vector::Vector2;

    /// A body, the plane whose share is asked for, and others.
    #[derive(Clone, Debug)]
    struct Scene {
        body: Ellipsoid,
        own: SupportingPlane,
        others: Vec<SupportingPlane>,
    }

    impl Scene {
        /// The others pass through points of the plane's section, or a little beside it.
        fn random(random: &mut Random) -> Scene {
            let semi_axes = [0; 3].map(|_| random.uniform(0.3, 1.0));
            let body = Ellipsoid::new(semi_axes, random.quaternion()).unwrap();
            let normal = random.direction();
            let distance = body.support(-normal).h * random.uniform(0.4, 0.98);
            let own = SupportingPlane {
                point: -normal * distance,
                normal,
            };
            let mut scene = Scene {
                body,
                own,
                others: vec![],
            };
            let (middle, [u, v]) = scene.ellipse();
            for _ in 0..1 + (random.uniform(0.0, 4.0) as usize) {
                let (angle, r) = (random.uniform(0.0, TAU), random.uniform(0.0, 1.2));
                let point = middle + u * (r * angle.cos()) + v * (r * angle.sin());
                let side = random.direction();
                let other = SupportingPlane {
                    point,
                    normal: (normal * random.uniform(0.0, 3.0) + side).normalised(),
                };
                scene.others.push(other);
            }
            scene
        }

        /// The section: its middle and two conjugate semi-diameters.
        fn ellipse(&self) -> (Vector3, [Vector3; 2]) {
            let support = self.body.support(-self.own.normal);
            let shrink = -self.own.normal.dot(self.own.point) / support.h;
            let m = self.body.semi_axes.componentwise(support.local_normal);
            let tangent = Tangent::new(m.normalised());
            let size = (1.0 - shrink * shrink).sqrt();
            let diameters = [tangent.u, tangent.v]
                .map(|b| self.body.to_world(self.body.semi_axes.componentwise(b)) * size);
            (support.point * shrink, diameters)
        }

        fn found(&self) -> Share {
            let own = Section::new(&self.body, &self.own);
            let others: Vec<_> = (self.others.iter())
                .map(|plane| Section::new(&self.body, plane))
                .collect();
            share(&self.body, &own, others.iter(), &mut ShareMemory::default())
        }

        /// The weight over what of the section is before all other planes: by the angle in sums, along each radius exactly.
        fn expected(&self) -> f64 {
            let (middle, [u, v]) = self.ellipse();
            let normal = -self.own.normal;
            let support = self.body.support(normal);
            let tangent = Tangent::new(normal);
            let (smaller, larger, _) = radii_of_curvature(&self.body, &support, &tangent).eigen();
            let sum = smaller + larger;
            let (factor, _) = anisotropy(2.0 * (smaller * larger).sqrt() / sum);
            let beta = factor * (larger - smaller) / sum;
            let longest = 0.5 * (2.0 * u.dot(v)).atan2(u.norm_squared() - v.norm_squared());
            let count = 20_000;
            let mut whole = 0.0;
            for k in 0..count {
                let angle = TAU * (f64::from(k) + 0.5) / f64::from(count);
                let ray = u * angle.cos() + v * angle.sin();
                let (mut from, mut to) = (0.0f64, 1.0f64);
                for plane in &self.others {
                    let height = plane.normal.dot(middle - plane.point);
                    let rise = plane.normal.dot(ray);
                    if rise > 0.0 {
                        from = from.max(-height / rise);
                    } else {
                        to = to.min(-height / rise);
                    }
                }
                let upto = |r: f64| r.powi(3) / 3.0 - r.powi(5) / 5.0;
                let part = (upto(to) - upto(from.min(1.0))).max(0.0) * f64::from(to > from);
                whole += part * (1.0 + beta * (2.0 * (angle - longest)).cos());
            }
            15.0 / (4.0 * PI) * whole * TAU / f64::from(count)
        }

        /// The body elsewhere, the planes where they are.
        fn moved(&self, by: Vector3) -> Scene {
            let mut moved = self.clone();
            for plane in moved.others.iter_mut().chain([&mut moved.own]) {
                plane.point = plane.point - by;
            }
            moved
        }

        /// The body turned about an axis of the world.
        fn turned(&self, axis: Vector3, angle: f64) -> Scene {
            let mut turned = self.clone();
            turned.body.axes = self.body.axes.map(|e| {
                let along = axis * axis.dot(e);
                along + (e - along) * angle.cos() + axis.cross(e) * angle.sin()
            });
            turned
        }

        fn check(&self) -> f64 {
            let found = self.found();
            let expected = self.expected();
            assert!(
                (found.value - expected).abs() < 5e-5,
                "{} is not {expected}: {self:?}",
                found.value
            );
            let step = 1e-5;
            for e in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vector3::from_array) {
                let slope = |of: &dyn Fn(f64) -> Scene| {
                    (of(step).found().value - of(-step).found().value) / (2.0 * step)
                };
                let by_position = slope(&|h| self.moved(e * h));
                let by_rotation = slope(&|h| self.turned(e, h));
                let allowed = 2e-5 * (1.0 + by_position.abs() + by_rotation.abs());
                let apart = [
                    found.by_position.dot(e) - by_position,
                    found.by_rotation.dot(e) - by_rotation,
                ];
                assert!(
                    apart.iter().all(|d| d.abs() < allowed),
                    "{apart:?} of {by_position} and {by_rotation}: {self:?}"
                );
            }
            found.value
        }
    }

    /// Shares and their gradients against the integral of the weight, for up to four other planes at any angle.
    #[test]
    fn a_share_is_the_weight_of_what_the_other_planes_leave() {
        let mut random = Random::new(5);
        let (mut parts, mut nothing, mut whole) = (0, 0, 0);
        for _ in 0..200 {
            let scene = Scene::random(&mut random);
            let value = scene.check();
            parts += usize::from(value > 0.0 && value < 1.0);
            nothing += usize::from(value == 0.0);
            whole += usize::from(value == 1.0);
            let own = Section::new(&scene.body, &scene.own);
            let (middle, [u, v]) = scene.ellipse();
            for plane in &scene.others {
                let least = plane.normal.dot(middle - plane.point)
                    - Vector2::new(plane.normal.dot(u), plane.normal.dot(v))
                        .dot(Vector2::new(plane.normal.dot(u), plane.normal.dot(v)))
                        .sqrt();
                let other = Section::new(&scene.body, plane);
                assert_eq!(own.is_cut_by(&other), least < 0.0, "{scene:?} {plane:?}");
            }
        }
        println!("{parts} parts, {nothing} nothing, {whole} whole");
        assert!(parts > 100 && nothing > 20 && whole > 2);
    }

    /// The sine of the angle has lost most of its digits in the product of the normals.
    #[test]
    fn planes_at_a_very_small_angle_divide_the_contact() {
        let body = Ellipsoid::new([0.5, 1.0, 0.7], [1.0, 0.0, 0.0, 0.0]).unwrap();
        for slope in [1e-6, -1e-7] {
            let plane = |slope: f64| SupportingPlane {
                point: Vector3::new(0.1, 0.0, -0.6),
                normal: Vector3::new(slope, 0.0, 1.0).normalised(),
            };
            let of = |own: f64, other: f64| Scene {
                body,
                own: plane(own),
                others: vec![plane(other)],
            };
            let (one, other) = (of(0.0, slope), of(slope, 0.0));
            for scene in [&one, &other] {
                assert!((scene.found().value - scene.expected()).abs() < 5e-5);
            }
            let sum = one.found().value + other.found().value;
            assert!((sum - 1.0).abs() < 1e-6, "{sum}");
        }
    }

    /// Lines of a section that are parallel, or the same.
    #[test]
    fn parallel_lines_leave_a_strip_or_nothing() {
        let at = |x: f64, slope: f64| SupportingPlane {
            point: Vector3::new(x, 0.0, -0.8),
            normal: Vector3::new(slope, 0.0, 1.0).normalised(),
        };
        let of = |others: &[SupportingPlane]| Scene {
            body: Ellipsoid::new([1.0; 3], [1.0, 0.0, 0.0, 0.0]).unwrap(),
            own: SupportingPlane {
                point: Vector3::new(0.0, 0.0, -0.8),
                normal: Vector3::new(0.0, 0.0, 1.0),
            },
            others: others.to_vec(),
        };
        let alone = of(&[at(-0.2, 1.0)]).check();
        for others in [
            vec![at(-0.2, 1.0), at(-0.2, 1.0)],
            vec![at(-0.2, 1.0), at(-0.4, 1.0)],
            vec![at(-0.4, 1.0), at(-0.2, 1.0)],
            vec![at(-0.4, 2.0), at(-0.2, 1.0), at(-0.3, 1.0)],
        ] {
            assert!((of(&others).found().value - alone).abs() < 1e-14);
        }
        for strip in [
            [at(-0.2, 1.0), at(0.3, -1.0)],
            [at(0.3, -0.5), at(-0.2, 2.0)],
            [at(0.1, 1.0), at(0.3, -1.0)],
        ] {
            assert!(of(&strip).check() > 0.0);
        }
        for nothing in [
            [at(0.2, 1.0), at(-0.3, -1.0)],
            [at(-0.3, -1.0), at(0.2, 1.0)],
            [at(0.1, 1.0), at(0.1, -1.0)],
        ] {
            assert!(of(&nothing).found().value < 1e-15);
        }
    }

    /// Planes through one line, as the faces at a straight edge of a mesh: rounding of their normals changes no share.
    #[test]
    fn planes_through_one_line_have_one_share_each() {
        let mut random = Random::new(11);
        let mut parts = 0;
        for _ in 0..300 {
            let mut scene = Scene::random(&mut random);
            let (middle, [u, v]) = scene.ellipse();
            let angle = random.uniform(0.0, TAU);
            let along = (u * angle.cos() + v * angle.sin()).normalised();
            let point = middle + u * random.uniform(-0.5, 0.5) + v * random.uniform(-0.5, 0.5);
            let across = along.cross(scene.own.normal);
            let side = if random.uniform(0.0, 1.0) < 0.5 {
                1.0
            } else {
                -1.0
            };
            // On one side of the plane, or on both of them.
            let one_side = random.uniform(0.0, 1.0) < 0.5;
            scene.others = (0..2 + random.uniform(0.0, 4.0) as usize)
                .map(|_| {
                    let least = if one_side { 0.02 } else { -0.5 };
                    let slope = side * random.uniform(least, 0.5);
                    SupportingPlane {
                        point: point + along * random.uniform(-1.0, 1.0),
                        normal: (scene.own.normal + across * slope).normalised(),
                    }
                })
                .collect();
            let value = scene.found().value;
            let expected = scene.expected();
            assert!(
                (value - expected).abs() < 5e-5,
                "{value} is not {expected}: {scene:?}"
            );
            parts += usize::from(value > 0.0 && value < 1.0);
            for _ in 0..20 {
                let mut rounded = scene.clone();
                for plane in rounded.others.iter_mut().chain([&mut rounded.own]) {
                    plane.normal = plane.normal + random.direction() * 1e-15;
                    plane.point = plane.point + random.direction() * 1e-15;
                }
                let other = rounded.found().value;
                assert!(
                    (other - value).abs() < 1e-9,
                    "{other} is not {value}: {rounded:?}"
                );
            }
        }
        assert!(parts > 100, "{parts}");
    }

    #[test]
    fn the_weight_follows_hertz_factors() {
        for (ratio, bound) in [
            (1.0, 1e-14),
            (4.0, 5e-3),
            (1e2, 5e-3),
            (1e4, 1e-2),
            (1e6, 7e-2),
        ] {
            let trace: f64 = 1.0 + ratio;
            let sigma = hertz_factors::exact(trace, ratio, true).sigma;
            let x = 2.0 * ratio.sqrt() / trace;
            let (factor, slope) = anisotropy(x);
            let apart = factor / (-4.0 / 3.0 * sigma) - 1.0;
            println!("B/A {ratio:e}: apart by {apart:.1e}");
            assert!(apart.abs() < bound, "{ratio}");
            let h = 1e-5 * x;
            let centre = x - 2.0 * h;
            let difference = (anisotropy(centre + h).0 - anisotropy(centre - h).0) / (2.0 * h);
            assert!((difference / anisotropy(centre).1 - 1.0).abs() < 1e-6);
            assert!(slope > 0.0);
        }
    }
}
