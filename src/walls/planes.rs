// SPDX-License-Identifier: MIT OR Apache-2.0
//! Plane walls: all owned particles against a few half-spaces.

use super::contact::{contact_forces, relative_curvature_matrix, Contact};
use super::laws::Laws;
use super::neighbour_list::{cached_normal, factors_for, forget, hale_holds, recall, remember};
use super::particles::{effective_mass, Particle};
use super::tallies::{Contribution, Tallies};
use super::{ContactForces, Step};
use crate::force::PairLaw;
use crate::geometry::plane::PlaneContact;
use crate::geometry::{touch_plane, Plane, Symmetric2, Vector2, Vector3};

/// A plane wall and its velocity.
#[derive(Clone, Copy, Debug)]
pub struct MovingPlane {
    /// Where it is.
    pub plane: Plane,
    /// How fast it moves, world frame.
    pub velocity: Vector3,
}

/// What the caller lends for the walls of one kind.
pub struct WallArrays<'a> {
    /// Whether the wall acts on a particle.
    pub acts_on: &'a dyn Fn(usize) -> bool,
    /// One flag per owned particle and wall.
    pub touching: &'a mut [i32],
    /// History per owned particle and wall.
    pub history: &'a mut [f64],
    /// Forces of the owned particles, added to.
    pub forces: &'a mut [[f64; 3]],
    /// Torques of the owned particles, added to.
    pub torques: &'a mut [[f64; 3]],
    /// Force on each wall, added to; empty when not asked for.
    pub wall_forces: &'a mut [[f64; 3]],
}

/// Why the walls were not computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlanesError {
    /// Hale's form broke at a contact.
    Hale {
        /// The particle's index.
        i: usize,
        /// `B/A`.
        ratio: f64,
    },
    /// A history of a touching particle that holds a number which no call has written.
    History {
        /// The particle's index.
        i: usize,
        /// Place in the contact's history.
        place: usize,
        /// What stands there.
        value: f64,
    },
}

/// Geometry and motion of a particle at a plane.
pub(super) fn contact_with_plane(
    found: &PlaneContact,
    i: &Particle,
    wall: &MovingPlane,
) -> Contact {
    Contact {
        normal: found.normal,
        tangent: found.tangent,
        penetration: found.penetration,
        h_i: found.support.h,
        inverse_h_i: found.support.inverse_h,
        witness_i: found.tangent.components(found.support.point),
        weingarten_i: i.body.weingarten(&found.support, &found.tangent),
        determinant_i: i.body.shape_determinant(),
        h_j: 1.0,
        inverse_h_j: 1.0,
        witness_j: Vector2::new(0.0, 0.0),
        weingarten_j: Symmetric2::new(0.0, 0.0, 0.0),
        determinant_j: 1.0,
        velocity_i: i.velocity,
        velocity_j: wall.velocity,
        omega_i: i.omega,
        omega_j: Vector3::ZERO,
        effective_mass: effective_mass(i.inverse_mass, 0.0),
        inverse_hessian: None,
    }
}

/// The law of one contact with a plane.
pub(super) fn plane_forces(
    law: &PairLaw,
    x: &Contact,
    remembered: &super::contact::Remembered,
) -> ContactForces {
    let curvature = relative_curvature_matrix(x.weingarten_i, x.weingarten_j);
    let factors = factors_for(law, curvature.trace(), curvature.determinant());
    contact_forces::<f64, true, true, true, true>(
        &law.kinds,
        &law.constants,
        &factors,
        curvature,
        x,
        remembered,
    )
}

/// All owned particles against all planes. Contacts with the wall follow the law of the particle's type and `wall_type`.
///
/// # Errors
/// Before any force is written.
pub fn compute_planes(
    laws: &Laws,
    particles: &[Particle],
    wall_type: usize,
    walls: &[MovingPlane],
    arrays: &mut WallArrays<'_>,
    step: &Step,
    mut tallies: Option<&mut Tallies<'_>>,
) -> Result<(), PlanesError> {
    let layout = laws.layout();
    let length = layout.length;
    if laws.features().hale {
        for (index, i) in particles.iter().enumerate() {
            if (arrays.acts_on)(index) {
                for wall in walls {
                    let found = touch_plane(&i.body, i.position, &wall.plane);
                    if found.penetration > 0.0 && laws.get(i.kind as usize, wall_type).kinds.hale {
                        let x = contact_with_plane(&found, i, wall);
                        hale_holds(relative_curvature_matrix(x.weingarten_i, x.weingarten_j))
                            .map_err(|ratio| PlanesError::Hale { i: index, ratio })?;
                    }
                }
            }
        }
    }
    for (slot, _) in (arrays.touching.iter().enumerate()).filter(|(_, touching)| **touching != 0) {
        let i = slot / walls.len();
        if (arrays.acts_on)(i) {
            let history = &arrays.history[slot * length..(slot + 1) * length];
            if let Some((place, value)) = layout.first_wrong(history) {
                return Err(PlanesError::History { i, place, value });
            }
        }
    }
    if let Some(t) = tallies.as_deref_mut() {
        t.start_step();
    }
    for (index, i) in particles.iter().enumerate() {
        if !(arrays.acts_on)(index) {
            continue;
        }
        for (w, wall) in walls.iter().enumerate() {
            let slot = index * walls.len() + w;
            let mut none_touching = 0;
            let touching = match arrays.touching.get_mut(slot) {
                Some(t) => t,
                None => &mut none_touching,
            };
            let history = &mut arrays.history[slot * length..(slot + 1) * length];
            let reach = wall.plane.normal.dot(i.position - wall.plane.point);
            let found = if reach >= i.radius {
                None
            } else {
                Some(touch_plane(&i.body, i.position, &wall.plane)).filter(|f| f.penetration > 0.0)
            };
            let Some(found) = found else {
                if *touching != 0 {
                    *touching = 0;
                    forget(&layout, history);
                }
                continue;
            };
            let law = laws.get(i.kind as usize, wall_type);
            let x = contact_with_plane(&found, i, wall);
            let before = cached_normal(&layout, history).unwrap_or(found.normal);
            let remembered = recall(&layout, history, *touching != 0, step, found.normal, before);
            let f = plane_forces(law, &x, &remembered);
            remember(&layout, history, found.normal, &f);
            *touching = 1;
            for (target, v) in [
                (&mut arrays.forces[index], -f.force),
                (&mut arrays.torques[index], f.torque_i),
            ] {
                target[0] += v.x;
                target[1] += v.y;
                target[2] += v.z;
            }
            if let Some(target) = arrays.wall_forces.get_mut(w) {
                target[0] += f.force.x;
                target[1] += f.force.y;
                target[2] += f.force.z;
            }
            if let Some(t) = tallies.as_deref_mut() {
                t.pairs += 1;
                t.add(
                    index,
                    None,
                    true,
                    &Contribution {
                        normal_energy: f.elastic_energy,
                        tangential_energy: f.tangential_energy,
                        works: [
                            remembered.time * f.viscous_power,
                            remembered.time * f.tangential_power,
                        ],
                        d: f.contact_point,
                        force: f.force,
                        viscous_force: f.viscous_force,
                        tangential_force: f.frictional_force,
                        contact_point: f.contact_point,
                        wall_velocity: wall.velocity,
                    },
                );
            }
        }
    }
    Ok(())
}
