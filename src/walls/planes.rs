// SPDX-License-Identifier: MIT OR Apache-2.0
//! Plane walls: all owned particles against a few half-spaces.

use crate::contact::history::{cached_normal, forget};
use crate::contact::pair::{
    checked_factors, contact_with_wall, factors_for, hale_holds, through_law, HaleRatio,
};
use crate::contact::{Contact, ContactForces, Laws, OneContact, Particle, Step};
use crate::geometry::plane::PlaneContact;
use crate::geometry::{relative_curvature, touch_plane, Plane};
use crate::tallies::{Contribution, Tallies};
use crate::vector::{Symmetric2, Vector3};

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
    contact_with_wall(
        i,
        &found.support,
        (found.normal, found.tangent),
        found.penetration,
        Symmetric2::new(0.0, 0.0, 0.0),
        wall.velocity,
    )
}

/// Geometry of an ellipsoid and a plane.
pub fn geometry_with_plane(i: &Particle, wall: &MovingPlane, share_i: f64) -> OneContact {
    let found = touch_plane(&i.body, i.position, &wall.plane);
    let x = contact_with_plane(&found, i, wall);
    let curvature = relative_curvature(x.curvature(), &found.tangent);
    let witness_i = i.position + found.support.point;
    OneContact {
        touching: found.penetration > 0.0,
        penetration: found.penetration,
        normal: found.normal,
        contact_point: witness_i - found.normal * (found.penetration * share_i),
        witness_i,
        witness_j: witness_i - found.normal * found.penetration,
        curvature_a: curvature.a,
        curvature_b: curvature.b,
        major_direction: curvature.major_direction,
    }
}

/// One contact of an ellipsoid and a plane; otherwise like [`crate::contact::one_contact()`].
///
/// # Errors
/// Only with `factors hale`, before anything is written.
pub fn one_contact_with_plane(
    laws: &Laws,
    i: &Particle,
    wall: &MovingPlane,
    wall_type: usize,
    step: &Step,
    touching: &mut bool,
    history: &mut [f64],
) -> Result<Option<(OneContact, ContactForces)>, HaleRatio> {
    let layout = laws.layout();
    let found = touch_plane(&i.body, i.position, &wall.plane);
    if found.penetration <= 0.0 {
        if *touching {
            *touching = false;
            forget(&layout, history);
        }
        return Ok(None);
    }
    let law = laws.get(i.particle_type as usize, wall_type);
    let x = contact_with_plane(&found, i, wall);
    let factors = checked_factors(law, x.curvature())?;
    let before = cached_normal(&layout, history).unwrap_or(found.normal);
    let f = through_law::<true, true, true, true>(
        law, &factors, &x, &layout, history, *touching, before, step,
    );
    *touching = true;
    Ok(Some((
        geometry_with_plane(i, wall, law.constants.share_i),
        f,
    )))
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
                    if found.penetration > 0.0
                        && laws.get(i.particle_type as usize, wall_type).kinds.hale
                    {
                        let x = contact_with_plane(&found, i, wall);
                        hale_holds(x.curvature())
                            .map_err(|HaleRatio(ratio)| PlanesError::Hale { i: index, ratio })?;
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
            let law = laws.get(i.particle_type as usize, wall_type);
            let x = contact_with_plane(&found, i, wall);
            let before = cached_normal(&layout, history).unwrap_or(found.normal);
            let factors = factors_for(law, x.curvature());
            let touched = *touching != 0;
            let f = through_law::<true, true, true, true>(
                law, &factors, &x, &layout, history, touched, before, step,
            );
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
                            step.elapsed() * f.viscous_power,
                            step.elapsed() * f.tangential_power,
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
