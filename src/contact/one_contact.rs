// SPDX-License-Identifier: MIT OR Apache-2.0
//! One contact at a time: geometry, force, torques, history in and out. The same functions as the neighbour list's, so
//! that both give the same numbers.
//!
//! # Example
//! ```
//! use ellgran::contact::one_contact::one_contact_or_gap;
//! use ellgran::contact::stability::{rayleigh_time, ContactStiffness};
//! use ellgran::contact::{prepare_body, Body, Laws, Step};
//!
//! let (parameters, _) = ellgran::force::syntax::parse(&["hertz", "1e7", "0.3"])?;
//! let laws = Laws::new(1, &[Some(parameters)], true)?;
//! let step = Step { time_step: 1e-6, advance_history: true };
//! // Grains of semi-axes 2, 1, 1 mm side by side, their long axes along x (m, kg).
//! let grain = |z: f64| Body {
//!     position: [0.0, 0.0, z],
//!     quaternion: [1.0, 0.0, 0.0, 0.0],
//!     semi_axes: [2e-3, 1e-3, 1e-3],
//!     velocity: [0.0; 3],
//!     angular_velocity: [0.0; 3],
//!     mass: 2e-5,
//!     particle_type: 1,
//!     identifier: 1,
//! };
//! let prepared = |z: f64| prepare_body(&grain(z), Some(laws.types()));
//! let (mut touching, mut history) = (false, vec![0.0; laws.layout().length]);
//! let (geometry, forces) =
//!     one_contact_or_gap(&laws, &prepared(0.0)?, &prepared(2.1e-3)?, &step, &mut touching, &mut history)
//!         .expect("exact factors");
//! assert!(forces.is_none() && (geometry.penetration + 0.1e-3).abs() < 1e-15);
//! let (geometry, forces) =
//!     one_contact_or_gap(&laws, &prepared(0.0)?, &prepared(1.99e-3)?, &step, &mut touching, &mut history)
//!         .expect("exact factors");
//! assert!(touching && forces.is_some_and(|forces| forces.force.z > 0.0));
//! // A = 1/(2 4 mm) + 1/(2 4 mm), B = 1/(2 1 mm) + 1/(2 1 mm): the ellipse is longer along the grains.
//! assert!((geometry.curvature_a - 250.0).abs() < 1e-9 && (geometry.curvature_b - 1000.0).abs() < 1e-9);
//! let [a, b] = geometry.contact_semi_axes();
//! assert!(a > b && geometry.major_direction.x.abs() > 0.999);
//! // Grains that are apart have no springs.
//! assert_eq!(ContactStiffness::NONE.critical_step, f64::INFINITY);
//! // Rayleigh's time, of a wave around the least semi-axis of the solid grain.
//! let density = 2e-5 / (4.0 / 3.0 * core::f64::consts::PI * 2e-9);
//! let shear_modulus = 1e7 / 2.6;
//! let time = core::f64::consts::PI * 1e-3 * f64::sqrt(density / shear_modulus) / (0.1631 * 0.3 + 0.8766);
//! assert!((rayleigh_time(&parameters, &prepared(0.0)?) / time - 1.0).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::forces::{relative_curvature_matrix, ContactForces};
use super::history::{cached_normal, forget, Step};
use super::laws::Laws;
use super::pair::{contact_of, hale_holds, law_of_pair, touch_spheres, HaleRatio, Pair};
use super::particle::Particle;
use crate::force::hertz_factors::contact_ellipse;
use crate::geometry::contact_search::gap;
use crate::geometry::{relative_curvature, ContactSearch};
#[cfg(not(feature = "std"))]
use crate::real::Real;
use crate::vector::Vector3;

/// Geometry of a pair, touching or not.
#[derive(Clone, Copy, Debug)]
pub struct OneContact {
    /// Whether the penetration is greater than zero.
    pub touching: bool,
    /// Penetration; minus the gap when separated.
    pub penetration: f64,
    /// Unit normal from `i` to `j`.
    pub normal: Vector3,
    /// Contact point (midway across the gap by the same share when separated), world frame.
    pub contact_point: Vector3,
    /// Witness point on `i`, world frame.
    pub witness_i: Vector3,
    /// Witness point on `j`, world frame.
    pub witness_j: Vector3,
    /// Relative curvature `A`.
    pub curvature_a: f64,
    /// Relative curvature `B >= A`.
    pub curvature_b: f64,
    /// Unit vector along the major semi-axis of the contact ellipse.
    pub major_direction: Vector3,
}

impl OneContact {
    /// Semi-axes `a >= b` of the contact ellipse at the elastic force of Hertz, length: `a b = Re delta F1^2/F2` (the paper's
    /// Eq. (2), corrected), `Re = 1/(2 sqrt(A B))`. Only of bodies that touch, and of no meaning with a law that reads no
    /// curvatures.
    pub fn contact_semi_axes(&self) -> [f64; 2] {
        let e = contact_ellipse(self.curvature_b / self.curvature_a);
        let effective_radius = 0.5 / (self.curvature_a * self.curvature_b).sqrt();
        let product = effective_radius * self.penetration * e.f1 * e.f1 / e.f2;
        let a = (product / e.axis_ratio).sqrt();
        [a, a * e.axis_ratio]
    }
}

pub(crate) fn geometry_of(
    found: &ContactSearch,
    i: &Particle,
    j: &Particle,
    share_i: f64,
) -> OneContact {
    let m = relative_curvature_matrix(
        i.body.weingarten(&found.support_i, &found.tangent),
        j.body.weingarten(&found.support_j, &found.tangent),
    );
    let curvature = relative_curvature(m, &found.tangent);
    let witness_i = i.position + found.support_i.point;
    OneContact {
        touching: found.penetration > 0.0,
        penetration: found.penetration,
        normal: found.normal,
        contact_point: witness_i - found.normal * (found.penetration * share_i),
        witness_i,
        witness_j: j.position - found.support_j.point,
        curvature_a: curvature.a,
        curvature_b: curvature.b,
        major_direction: curvature.major_direction,
    }
}

/// Geometry of two bodies that a plane is known to separate, to rounding at least: they do not touch. Without its normal the
/// bounding spheres do not meet.
fn geometry_apart(i: &Particle, j: &Particle, share_i: f64, normal: Option<Vector3>) -> OneContact {
    let d = j.position - i.position;
    // Not zero: it is longer than the semi-axes.
    let normal = normal
        .or(d.direction())
        .unwrap_or(Vector3::new(1.0, 0.0, 0.0));
    let mut found = if i.sphere && j.sphere {
        touch_spheres(i.radius, j.radius, d, &i.body, &j.body)
    } else {
        gap(&i.body, &j.body, d, normal)
    };
    found.penetration = found.penetration.min(0.0);
    geometry_of(&found, i, j, share_i)
}

/// Geometry of two ellipsoids, touching or not; `start` is the last normal, a unit vector, if there is one.
pub fn geometry(i: &Particle, j: &Particle, share_i: f64, start: Option<Vector3>) -> OneContact {
    match Pair::of(i, j, start) {
        Pair::Touching(found) => geometry_of(&found, i, j, share_i),
        Pair::Apart { normal, .. } => geometry_apart(i, j, share_i, normal),
    }
}

/// One contact of two ellipsoids: `None` when they do not touch. `touching` and `history` are those of the pair
/// (length [`super::HistoryLayout::length`]) and are written.
///
/// # Errors
/// Only with `factors hale`, before anything is written.
pub fn one_contact(
    laws: &Laws,
    i: &Particle,
    j: &Particle,
    step: &Step,
    touching: &mut bool,
    history: &mut [f64],
) -> Result<Option<(OneContact, ContactForces)>, HaleRatio> {
    compute(laws, i, j, step, touching, history).map(|contact| contact.ok())
}

/// The same, with the geometry of a pair that does not touch too.
///
/// # Errors
/// As [`one_contact`].
pub fn one_contact_or_gap(
    laws: &Laws,
    i: &Particle,
    j: &Particle,
    step: &Step,
    touching: &mut bool,
    history: &mut [f64],
) -> Result<(OneContact, Option<ContactForces>), HaleRatio> {
    Ok(match compute(laws, i, j, step, touching, history)? {
        Ok((geometry, forces)) => (geometry, Some(forces)),
        Err(normal) => {
            let share_i = laws
                .get(i.particle_type as usize, j.particle_type as usize)
                .constants
                .share_i;
            (geometry_apart(i, j, share_i, normal), None)
        }
    })
}

/// A contact, or the normal of a plane between the bodies where one is known.
type ContactOrPlane = Result<(OneContact, ContactForces), Option<Vector3>>;

fn compute(
    laws: &Laws,
    i: &Particle,
    j: &Particle,
    step: &Step,
    touching: &mut bool,
    history: &mut [f64],
) -> Result<ContactOrPlane, HaleRatio> {
    let layout = laws.layout();
    let law = laws.get(i.particle_type as usize, j.particle_type as usize);
    let cached = cached_normal(&layout, history);
    let found = match Pair::of(i, j, cached) {
        Pair::Touching(found) => found,
        Pair::Apart { normal, searched } => {
            if let (Some(at), Some(n)) = (layout.normal.filter(|_| searched), normal) {
                history[at..at + 3].copy_from_slice(&n.to_array());
            }
            if *touching {
                *touching = false;
                forget(&layout, history);
            }
            return Ok(Err(normal));
        }
    };
    if law.kinds.hale {
        hale_holds(contact_of(&found, i, j).curvature())?;
    }
    let (mut f, couple) = law_of_pair::<true, true>(
        law,
        &found,
        [i, j],
        &layout,
        history,
        *touching,
        cached,
        step,
    );
    couple.add_to(&mut f);
    *touching = true;
    Ok(Ok((geometry_of(&found, i, j, law.constants.share_i), f)))
}
