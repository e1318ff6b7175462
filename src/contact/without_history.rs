// SPDX-License-Identifier: MIT OR Apache-2.0
//! What depends on where two bodies are and on nothing else: their gap, and their elastic energy.

use super::laws::Laws;
use super::pair::{checked_factors, contact_of, touch_spheres, HaleRatio, Pair};
use super::particle::Particle;
use crate::force::normal_force;
use crate::geometry::contact_search::closest;
use crate::vector::Vector3;

/// Gap of two bodies, minus the penetration where they overlap, and the unit normal from `i` to `j` along which it is measured.
///
/// # Example
/// The tips of two needles, 0.1 apart; lengths in any unit:
/// ```
/// use ellgran::contact::{prepare_body, without_history::gap, Body};
///
/// let needle = |x: f64| Body {
///     position: [x, 0.0, 0.0],
///     quaternion: [1.0, 0.0, 0.0, 0.0],
///     semi_axes: [5.0, 1.0, 1.0],
///     velocity: [0.0; 3],
///     angular_velocity: [0.0; 3],
///     mass: 1.0,
///     particle_type: 1,
///     identifier: 1,
/// };
/// let (distance, normal) = gap(&prepare_body(&needle(0.0), Some(1))?, &prepare_body(&needle(10.1), Some(1))?);
/// assert!((distance - 0.1).abs() < 1e-12 && (normal.x - 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn gap(i: &Particle, j: &Particle) -> (f64, Vector3) {
    let d = j.position - i.position;
    let found = if i.sphere && j.sphere {
        touch_spheres(i.radius, j.radius, d, &i.body, &j.body)
    } else {
        closest(&i.body, &j.body, d, None)
    };
    (-found.penetration, found.normal)
}

/// Elastic energy of the normal deformation of two bodies; 0 where they do not touch.
///
/// # Errors
/// Only with `factors hale`.
pub fn elastic_energy(laws: &Laws, i: &Particle, j: &Particle) -> Result<f64, HaleRatio> {
    let Pair::Touching(found) = Pair::of(i, j, None) else {
        return Ok(0.0);
    };
    let law = laws.get(i.particle_type as usize, j.particle_type as usize);
    let x = contact_of(&found, i, j);
    let m = x.curvature();
    let factors = checked_factors(law, m)?;
    let (kinds, constants) = (&law.kinds.normal, &law.constants.normal);
    let determinant = m.determinant();
    let normal = normal_force(
        kinds,
        constants,
        x.penetration,
        0.0,
        determinant,
        &factors,
        x.effective_mass,
    );
    Ok(normal.elastic_energy)
}
