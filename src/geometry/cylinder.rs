// SPDX-License-Identifier: MIT OR Apache-2.0
//! An ellipsoid and a circular cylinder, from within or from without.
//!
//! The normal is a direction `u` of the cross-section, so the search has one angle. From within, the distance of the
//! body's points from the axis along `u` is `rho(u) = u.x + h(u)`; each of its maxima beyond the radius is a contact: a
//! needle across the axis has two. From without, the separation `n.d - h(n) - R` has one maximum, as for any two convex
//! bodies.

use super::ellipsoid::Ellipsoid;
use crate::vector::{Tangent, Vector3};

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

/// Directions that are tried over the whole circle, and over the smallest arc.
const MOST_DIRECTIONS: usize = 64;
const LEAST_DIRECTIONS: usize = 16;

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
    // The first axis of the cross-section points to the body, where there is such a direction.
    let first_axis = if distance > 0.0 {
        x * (1.0 / distance)
    } else {
        Tangent::new(axis).u
    };
    let search = Search {
        body,
        x,
        axis,
        basis: [first_axis, axis.cross(first_axis)],
        side: if within { 1.0 } else { -1.0 },
    };
    // Beyond the wall u.x + reach > R: an arc about the body's own direction. From without, the direction of the greatest
    // separation is within a quarter turn of it.
    let half = if within {
        ((cylinder.radius - reach) / distance)
            .clamp(-1.0, 1.0)
            .acos()
    } else {
        core::f64::consts::FRAC_PI_2
    };
    let share = half / core::f64::consts::PI;
    let count = LEAST_DIRECTIONS + (share * (MOST_DIRECTIONS - LEAST_DIRECTIONS) as f64) as usize;
    let step = 2.0 * half / count as f64;
    let mut values = [0.0; MOST_DIRECTIONS + 2];
    // One more at either end, so that each place has two neighbours.
    search.sample(-half - 0.5 * step, step, &mut values[..count + 2]);
    let mut best: Option<(f64, f64)> = None;
    for k in 1..=count {
        // Of two equals the later.
        if !(values[k] >= values[k - 1] && values[k] > values[k + 1]) {
            continue;
        }
        // the top of the parabola through the three
        let [before, at, after] = [values[k - 1], values[k], values[k + 1]];
        let aside = 0.5 * (before - after) / (before - 2.0 * at + after);
        let angle = search.maximum(-half + (k as f64 - 0.5) * step, aside * step, step);
        let value = search.value(angle);
        if within {
            if value > cylinder.radius {
                found(search.contact(angle, offset, cylinder));
            }
        } else if best.is_none_or(|(_, v)| value > v) {
            best = Some((angle, value));
        }
    }
    if let Some((angle, value)) = best {
        if value < cylinder.radius {
            found(search.contact(angle, offset, cylinder));
        }
    }
}

/// The function of the angle that is to be greatest.
struct Search<'a> {
    body: &'a Ellipsoid,
    /// The centre from the axis.
    x: Vector3,
    axis: Vector3,
    /// Axes of the cross-section.
    basis: [Vector3; 2],
    /// 1 from within, -1 from without.
    side: f64,
}

impl Search<'_> {
    fn direction(&self, angle: f64) -> Vector3 {
        let (sin, cos) = angle.sin_cos();
        self.basis[0] * cos + self.basis[1] * sin
    }

    /// From within `u.x + h(u)`, from without `u.x - h(u)`.
    fn value(&self, angle: f64) -> f64 {
        let u = self.direction(angle);
        let scaled = self.body.semi_axes.componentwise(self.body.to_body(u));
        u.dot(self.x) + self.side * scaled.norm()
    }

    /// `value` at equal steps from an angle on, to the digits that a search for a bracket needs.
    fn sample(&self, start: f64, step: f64, values: &mut [f64]) {
        let scaled = self
            .basis
            .map(|e| self.body.semi_axes.componentwise(self.body.to_body(e)));
        let along = self.basis.map(|e| e.dot(self.x));
        let squares = scaled.map(|p| p.norm_squared());
        let mixed = 2.0 * scaled[0].dot(scaled[1]);
        let ((mut sin, mut cos), (step_sin, step_cos)) = (start.sin_cos(), step.sin_cos());
        for value in values {
            let square = cos * cos * squares[0] + cos * sin * mixed + sin * sin * squares[1];
            *value = cos * along[0] + sin * along[1] + self.side * square.max(0.0).sqrt();
            (sin, cos) = (
                sin * step_cos + cos * step_sin,
                cos * step_cos - sin * step_sin,
            );
        }
    }

    /// First and second derivative.
    fn slopes(&self, angle: f64) -> (f64, f64) {
        let u = self.direction(angle);
        let t = self.axis.cross(u);
        let support = self.body.support(u);
        let along = t.dot(support.point);
        // Along the circle h'' = t.H t - h, and t.H t = |D R^T t|^2/h - (t.s)^2/h.
        let scaled = self.body.semi_axes.componentwise(self.body.to_body(t));
        let bend = (scaled.norm_squared() - along * along) / support.h;
        (
            t.dot(self.x) + self.side * along,
            self.side * (bend - support.h) - u.dot(self.x),
        )
    }

    /// The maximum within a step of an angle, perhaps so far aside of it: Newton's method, and bisection where it leaves the
    /// bracket.
    fn maximum(&self, start: f64, aside: f64, step: f64) -> f64 {
        let (mut low, mut high) = (start - step, start + step);
        let mut angle = start + aside;
        for _ in 0..60 {
            let (first, second) = self.slopes(angle);
            if first > 0.0 {
                low = angle;
            } else {
                high = angle;
            }
            let newton = angle - first / second;
            let converging = second < 0.0 && newton > low && newton < high;
            let next = if converging {
                newton
            } else {
                0.5 * (low + high)
            };
            let change = (next - angle).abs();
            angle = next;
            // the error that such a step of Newton's leaves is beneath rounding
            if change < if converging { 1e-9 } else { 1e-14 } {
                break;
            }
        }
        angle
    }

    fn contact(&self, angle: f64, offset: Vector3, cylinder: &Cylinder) -> CylinderContact {
        let u = self.direction(angle);
        let deepest = offset + self.body.support(u * self.side).point;
        CylinderContact {
            point: cylinder.point + self.axis * self.axis.dot(deepest) + u * cylinder.radius,
            normal: u * -self.side,
            within: self.side > 0.0,
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
        // In a wide cylinder, on its long side: both ends, or the middle if the side is rounder than the wall.
        let flat = Ellipsoid::new([0.05, 0.001, 0.001], [1.0, 0.0, 0.0, 0.0]).unwrap();
        let lying = contacts(&flat, Vector3::new(0.0, 0.9988, 0.0), 1.0);
        assert_eq!(lying.len(), 2, "{lying:?}");
        let round = Ellipsoid::new([0.02, 0.001, 0.001], [1.0, 0.0, 0.0, 0.0]).unwrap();
        assert_eq!(
            contacts(&round, Vector3::new(0.0, 0.9991, 0.0), 1.0).len(),
            1
        );
        // Off the axis: each tip beyond the wall counts, though the wall beside the centre is far.
        let off = contacts(&needle, Vector3::new(0.0, 0.3, 0.0), 1.0);
        assert_eq!(off.len(), 2);
    }
}
