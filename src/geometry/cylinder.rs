// SPDX-License-Identifier: MIT OR Apache-2.0
//! An ellipsoid and a circular cylinder, from within or from without.
//!
//! The normal is a direction `u` of the cross-section, so the search has one angle. From within, the distance of the
//! body's points from the axis along `u` is `rho(u) = u.x + h(u)`; each of its maxima beyond the radius is a contact: a
//! needle across the axis has two. From without, the separation `n.d - h(n) - R` has one maximum, as for any two convex
//! bodies.

use super::ellipsoid::Ellipsoid;
use super::vector::Vector3;

/// A cylinder.
#[derive(Clone, Copy, Debug)]
pub struct Cylinder {
    /// A point of the axis, world frame.
    pub point: Vector3,
    /// Unit vector along the axis.
    pub axis: Vector3,
    /// Radius.
    pub radius: f64,
}

/// A contact with a cylinder.
#[derive(Clone, Copy, Debug)]
pub struct CylinderContact {
    /// The point of the wall deepest in the body, world frame.
    pub point: Vector3,
    /// Unit normal out of the wall, towards the body.
    pub normal: Vector3,
    /// Whether the body is within.
    pub within: bool,
}

const DIRECTIONS: usize = 64;

/// The contacts of a body with centre `centre`; at most two.
pub fn touch_cylinder(
    body: &Ellipsoid,
    centre: Vector3,
    cylinder: &Cylinder,
    mut found: impl FnMut(CylinderContact),
) {
    let axis = cylinder.axis;
    let offset = centre - cylinder.point;
    let x = offset - axis * axis.dot(offset);
    let reach = body.bounding_radius();
    let distance = x.norm();
    let within = distance <= cylinder.radius;
    if within && distance + reach <= cylinder.radius
        || !within && distance - reach >= cylinder.radius
    {
        return;
    }
    let basis = super::Tangent::new(axis);
    let direction = |angle: f64| basis.u * angle.cos() + basis.v * angle.sin();
    // From without, n = -u: h(-u) - u.x is to be smallest, u.x - h largest.
    let side = if within { 1.0 } else { -1.0 };
    let value = |angle: f64| {
        let u = direction(angle);
        u.dot(x) + side * body.support(u).h
    };
    let slopes = |angle: f64| {
        let u = direction(angle);
        let t = axis.cross(u);
        let support = body.support(u);
        let first = t.dot(x) + side * t.dot(support.point);
        // Along the circle h'' = t.H t - h, and t.H t from the support of t: t.S t/h - (t.s)^2/h.
        let local = body.semi_axes.componentwise(body.to_body(t));
        let bend = (local.norm_squared() - t.dot(support.point).powi(2)) / support.h;
        (first, side * (bend - support.h) - u.dot(x))
    };
    let step = core::f64::consts::TAU / DIRECTIONS as f64;
    let mut values = [0.0; DIRECTIONS];
    for (k, v) in values.iter_mut().enumerate() {
        *v = value(k as f64 * step);
    }
    for k in 0..DIRECTIONS {
        let (before, after) = (
            values[(k + DIRECTIONS - 1) % DIRECTIONS],
            values[(k + 1) % DIRECTIONS],
        );
        // Ties: the later of two equals.
        if !(values[k] >= before && values[k] > after) {
            continue;
        }
        // The slope changes its sign between the neighbours.
        let (mut low, mut high) = ((k as f64 - 1.0) * step, (k as f64 + 1.0) * step);
        let mut angle = k as f64 * step;
        for _ in 0..60 {
            let (first, second) = slopes(angle);
            if first > 0.0 {
                low = angle;
            } else {
                high = angle;
            }
            let newton = angle - first / second;
            let next = if second < 0.0 && newton > low && newton < high {
                newton
            } else {
                0.5 * (low + high)
            };
            let change = (next - angle).abs();
            angle = next;
            if change < 1e-15 {
                break;
            }
        }
        let u = direction(angle);
        let depth = if within {
            value(angle) - cylinder.radius
        } else {
            cylinder.radius - value(angle)
        };
        if depth > 0.0 {
            let deepest = offset + body.support(u * side).point;
            found(CylinderContact {
                point: cylinder.point + axis * axis.dot(deepest) + u * cylinder.radius,
                normal: u * -side,
                within,
            });
        }
        if !within {
            // One contact: the others are no maxima of a separation between convex bodies.
            let best = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            if values[k] == best {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn contacts(body: &Ellipsoid, centre: Vector3, radius: f64) -> Vec<CylinderContact> {
        let cylinder = Cylinder {
            point: Vector3::ZERO,
            axis: Vector3::new(0.0, 0.0, 1.0),
            radius,
        };
        let mut all = vec![];
        touch_cylinder(body, centre, &cylinder, |c| all.push(c));
        all
    }

    #[test]
    fn a_sphere_touches_once_on_either_side() {
        let sphere = Ellipsoid::new([0.1; 3], [1.0, 0.0, 0.0, 0.0]).unwrap();
        let inner = contacts(&sphere, Vector3::new(0.95, 0.0, 3.0), 1.0);
        assert_eq!(inner.len(), 1);
        assert!((inner[0].point - Vector3::new(1.0, 0.0, 3.0)).norm() < 1e-12);
        assert!((inner[0].normal - Vector3::new(-1.0, 0.0, 0.0)).norm() < 1e-12);
        let outer = contacts(&sphere, Vector3::new(1.05, 0.0, 3.0), 1.0);
        assert_eq!(outer.len(), 1);
        assert!((outer[0].normal - Vector3::new(1.0, 0.0, 0.0)).norm() < 1e-12);
        assert!(contacts(&sphere, Vector3::new(0.5, 0.0, 0.0), 1.0).is_empty());
    }

    #[test]
    fn a_needle_across_the_axis_touches_twice() {
        let needle = Ellipsoid::new([1.001, 0.05, 0.05], [1.0, 0.0, 0.0, 0.0]).unwrap();
        let both = contacts(&needle, Vector3::ZERO, 1.0);
        assert_eq!(both.len(), 2);
        for c in &both {
            assert!((c.point.x.abs() - 1.0).abs() < 1e-12 && c.point.y.abs() < 1e-9);
        }
        // Off the axis: each tip beyond the wall counts, though the wall beside the centre is far.
        let off = contacts(&needle, Vector3::new(0.0, 0.3, 0.0), 1.0);
        assert_eq!(off.len(), 2);
    }
}
