// SPDX-License-Identifier: MIT OR Apache-2.0
//! How several planes that support one body divide its contact among them.
//!
//! At a concave fold a body may lie on two planes at once. Hertz' law of both in full counts the overlap near the fold
//! twice, and that of one alone jumps where the other takes over. So each plane acts by its share. To second order the
//! overlap with plane `c` is a paraboloid cap, of depth `delta (1 - r^2)` over the unit disc when lengths in the plane are
//! measured by the body's curvature. The other planes cut from the disc what lies behind them. The share `w` is what is left
//! of the disc, weighed with `(1 - r^2) r`, the depth times the slope of the cap.
//!
//! - The elastic energy is the sum of `w U` over the planes, `U` that of Hertz on the whole plane, so force and torque are
//!   continuous and keep energy. Beside the law's own terms times `w` they are `-U grad w`, of which the gradient stands here.
//! - A plane that no other one cuts has `w = 1`, and planes that continue one another, cut along any line, sum to one:
//!   a flat surface is the plane in whatever pieces it comes.
//! - The weight makes many facets the curved surface: for a sphere of radius `R` in a cylinder of radius `Rc`,
//!   `e = R/Rc`, it gives `(1-e)^(-1/2) (2/pi) E(e)` times the energy on a plane (`E` the complete elliptic integral) where
//!   Hertz' law of the cylinder has `(1-e)^(-1/4) F2^(-3/2)`: equal to first order in `e`, 0.03 % apart at `e = 0.1`. The
//!   depth alone as the weight would be `1 + 5 e/12` instead of `1 + e/4`, the area alone `1 + e/8`.

use super::convex_body::ConvexBody;
use super::ellipsoid::Ellipsoid;
use crate::vector::{Symmetric2, Tangent, Vector3};
use core::f64::consts::{PI, TAU};

/// A plane that supports a body, with the body's centre as the origin.
#[derive(Clone, Copy, Debug)]
pub struct SupportingPlane {
    /// A point of the plane near the contact, from the body's centre.
    pub point: Vector3,
    /// Unit normal out of the wall, towards the body.
    pub normal: Vector3,
}

/// The share of a plane in a body's contact, and its gradient.
#[derive(Clone, Copy, Debug)]
pub struct Share {
    /// Between 0 and 1.
    pub value: f64,
    /// Gradient along the body's position, 1/length, world frame.
    pub by_position: Vector3,
    /// Gradient along the body's rotation about its centre, 1/radian, world frame.
    pub by_rotation: Vector3,
}

impl Share {
    /// That of a plane alone.
    pub const WHOLE: Share = Share {
        value: 1.0,
        by_position: Vector3::ZERO,
        by_rotation: Vector3::ZERO,
    };
    const NONE: Share = Share {
        value: 0.0,
        ..Share::WHOLE
    };
}

/// Memory for [`share`].
#[derive(Clone, Debug, Default)]
pub struct ShareMemory {
    lines: Vec<Line>,
    arcs: Vec<[f64; 2]>,
}

/// A number and its gradients along the body's position and rotation.
#[derive(Clone, Copy, Debug)]
struct Sloped {
    value: f64,
    position: Vector3,
    rotation: Vector3,
}

impl Sloped {
    fn new(value: f64, position: Vector3, rotation: Vector3) -> Self {
        Sloped {
            value,
            position,
            rotation,
        }
    }
    /// `value`, whose derivatives along `a` and `b` are `da` and `db`.
    fn of(value: f64, (a, da): (Sloped, f64), (b, db): (Sloped, f64)) -> Self {
        Sloped {
            value,
            position: a.position.scale_add(da, b.position * db),
            rotation: a.rotation.scale_add(da, b.rotation * db),
        }
    }
    fn plus(self, b: Sloped) -> Self {
        Sloped::of(self.value + b.value, (self, 1.0), (b, 1.0))
    }
    fn times(self, b: Sloped) -> Self {
        Sloped::of(self.value * b.value, (self, b.value), (b, self.value))
    }
    fn over(self, b: Sloped) -> Self {
        let value = self.value / b.value;
        Sloped::of(value, (self, 1.0 / b.value), (b, -value / b.value))
    }
    fn scaled(self, s: f64) -> Self {
        Sloped::of(self.value * s, (self, s), (self, 0.0))
    }
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        Sloped::of(root, (self, 0.5 / root), (self, 0.0))
    }
}

/// The line along which another plane cuts the unit disc: `(cos angle, sin angle).x <= distance` is what it leaves.
#[derive(Clone, Copy, Debug)]
struct Line {
    distance: Sloped,
    angle: Sloped,
    sin: f64,
    cos: f64,
}

/// The share of plane `own` of `planes` in the contact of `body`; its own penetration must be greater than 0. A plane of
/// which another is in front over the whole contact has the share 0. Two planes of `planes` may not be the same.
pub fn share(
    body: &Ellipsoid,
    planes: &[SupportingPlane],
    own: usize,
    memory: &mut ShareMemory,
) -> Share {
    let plane = &planes[own];
    let (wall, normal) = (plane.normal, -plane.normal);
    let support = body.support(normal);
    let (h, s) = (support.h, support.point);
    let depth = h + wall.dot(plane.point);
    if !(depth > 0.0) {
        return Share::NONE;
    }
    let tangent = Tangent::new(normal);
    let v = body.weingarten(&support, &tangent);
    let determinant = body.squared_product() / (h * h * h * h);
    let w = v.adjugate() * determinant;
    // x = l y sqrt(2 depth) with y in the unit disc, l l^T = w
    let l11 = w.uu.sqrt();
    let l21 = w.uv / l11;
    let l22 = (determinant / w.uu).sqrt();
    let root = (2.0 * depth).sqrt();
    memory.lines.clear();
    let mut slopes: Option<Slopes> = None;
    for (index, other) in planes.iter().enumerate() {
        if index == own {
            continue;
        }
        let n = other.normal;
        let cut = tangent.components(n) * -1.0;
        let reach = n.dot(s + wall * depth - other.point);
        let (au, av) = (l11.mul_add(cut.u, l21 * cut.v), l22 * cut.v);
        let size = au.hypot(av) * root;
        if reach >= size {
            continue;
        }
        if reach <= -size {
            return Share::NONE;
        }
        let known = slopes.get_or_insert_with(|| {
            Slopes::new(
                body,
                normal,
                &tangent,
                (h, s),
                (depth, wall),
                (w, determinant),
            )
        });
        let ds = known.rotation_of_witness(body, n);
        let across = n.dot(wall);
        let reach = Sloped::new(reach, n - wall * across, ds + known.h.rotation * across);
        let au = Sloped::of(au, (known.l11, cut.u), (known.l21, cut.v));
        let av = known.l22.scaled(cut.v);
        let square = au.times(au).plus(av.times(av));
        let length = square.sqrt();
        let angle = Sloped::of(
            av.value.atan2(au.value),
            (av, au.value / square.value),
            (au, -av.value / square.value),
        );
        memory.lines.push(Line {
            distance: reach.over(length.times(known.root)),
            angle,
            cos: au.value / length.value,
            sin: av.value / length.value,
        });
    }
    if memory.lines.is_empty() {
        return Share::WHOLE;
    }
    remaining(&memory.lines, &mut memory.arcs)
}

/// What of a cap depends on the body's pose.
struct Slopes {
    normal: Vector3,
    h: Sloped,
    s: Vector3,
    root: Sloped,
    l11: Sloped,
    l21: Sloped,
    l22: Sloped,
}

/// `S a` of the body's shape matrix.
fn shape_times(body: &Ellipsoid, a: Vector3) -> Vector3 {
    let axes = body.semi_axes;
    body.to_world(axes.componentwise(axes.componentwise(body.to_body(a))))
}

impl Slopes {
    fn new(
        body: &Ellipsoid,
        normal: Vector3,
        tangent: &Tangent,
        (h, s): (f64, Vector3),
        (depth, wall): (f64, Vector3),
        (w, determinant): (Symmetric2, f64),
    ) -> Self {
        let none = Vector3::ZERO;
        let h = Sloped::new(h, none, s.cross(normal));
        let mut slopes = Slopes {
            normal,
            h,
            s,
            root: Sloped::new(2.0 * depth, wall * -2.0, h.rotation * 2.0).sqrt(),
            l11: h,
            l21: h,
            l22: h,
        };
        // W = T^T (S - s s^T) T / h, and S turns with the body.
        let (u, v) = (tangent.u, tangent.v);
        let (su, sv) = (shape_times(body, u), shape_times(body, v));
        let (du, dv) = (
            slopes.rotation_of_witness(body, u),
            slopes.rotation_of_witness(body, v),
        );
        let (s_u, s_v) = (s.dot(u), s.dot(v));
        let inverse = 1.0 / h.value;
        let entry = |value: f64, turned: Vector3, products: Vector3| {
            let rotation = (turned - products - h.rotation * value) * inverse;
            Sloped::new(value, none, rotation)
        };
        let uu = entry(w.uu, su.cross(u) * 2.0, du * (2.0 * s_u));
        let uv = entry(w.uv, sv.cross(u) + su.cross(v), du * s_v + dv * s_u);
        let determinant = Sloped::new(
            determinant,
            none,
            h.rotation * (-4.0 * determinant * inverse),
        );
        slopes.l11 = uu.sqrt();
        slopes.l21 = uv.over(slopes.l11);
        slopes.l22 = determinant.over(uu).sqrt();
        slopes
    }

    /// The gradient along the body's rotation of `a.s`, `s` the witness from the centre.
    fn rotation_of_witness(&self, body: &Ellipsoid, a: Vector3) -> Vector3 {
        let inverse = 1.0 / self.h.value;
        let turned = self.s.cross(a) - self.normal.cross(shape_times(body, a)) * inverse;
        turned - self.h.rotation * (self.s.dot(a) * inverse)
    }
}

/// `(15/4 pi) (1 - r^2) r` over what the lines leave of the unit disc; over the whole disc it is 1.
fn remaining(lines: &[Line], arcs: &mut Vec<[f64; 2]>) -> Share {
    let mut share = Share::NONE;
    arcs.clear();
    for (index, line) in lines.iter().enumerate() {
        let p = line.distance.value;
        // what the line takes of the circle
        let half = p.acos();
        let start = (line.angle.value - half).rem_euclid(TAU);
        let end = start + 2.0 * half;
        arcs.push([start, end.min(TAU)]);
        if end > TAU {
            arcs.push([0.0, end - TAU]);
        }
        // what the others leave of the line, by the way s along it from the point nearest to the disc's centre
        let reach = (1.0 - p * p).sqrt();
        let (mut from, mut to) = (-reach, reach);
        for (other, l) in lines.iter().enumerate() {
            if other == index {
                continue;
            }
            let sin = l.sin * line.cos - l.cos * line.sin;
            let cos = l.cos * line.cos + l.sin * line.sin;
            let room = l.distance.value - p * cos;
            if sin.abs() < 1e-14 {
                if room < 0.0 || room == 0.0 && cos > 0.0 && other < index {
                    to = from;
                }
            } else if sin > 0.0 {
                to = to.min(room / sin);
            } else {
                from = from.max(room / sin);
            }
        }
        if !(from < to) {
            continue;
        }
        let at = |s: f64| {
            let square = p * p + s * s;
            let r = square.sqrt();
            let logarithm = if p == 0.0 {
                0.0
            } else {
                p * p * (s / p.abs()).asinh()
            };
            // integrals along the line of r, r^3, r s, r^3 s
            let first = 0.5 * (s * r + logarithm);
            let third = 0.25 * s * r * square + 0.75 * p * p * first;
            let cube = r * square;
            (first, third, cube / 3.0, cube * square / 5.0)
        };
        let (a, b) = (at(from), at(to));
        let (first, third) = (b.0 - a.0, b.1 - a.1);
        share.value += p * (2.5 * first - 1.5 * third) / TAU;
        let weight = 15.0 / (4.0 * PI);
        let moved = weight * (first - third);
        let turned = -weight * ((b.2 - a.2) - (b.3 - a.3));
        let (d, angle) = (&line.distance, &line.angle);
        share.by_position = share.by_position + d.position * moved + angle.position * turned;
        share.by_rotation = share.by_rotation + d.rotation * moved + angle.rotation * turned;
    }
    arcs.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut free, mut end) = (0.0, 0.0f64);
    for [a, b] in arcs.iter() {
        free += (a - end).max(0.0);
        end = end.max(*b);
    }
    free += (TAU - end).max(0.0);
    share.value = (share.value + free / TAU).clamp(0.0, 1.0);
    share
}
