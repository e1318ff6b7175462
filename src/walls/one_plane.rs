// SPDX-License-Identifier: MIT OR Apache-2.0
//! One contact of an ellipsoid with a plane, without what is remembered by a wall.

use crate::contact::couple::{couple, TurningContact};
use crate::contact::history::{cached_normal, forget};
use crate::contact::pair::{checked_factors, contact_with_wall, through_law, HaleRatio};
use crate::contact::{Contact, ContactForces, Laws, OneContact, Particle, Step};
use crate::geometry::plane::PlaneContact;
use crate::geometry::{relative_curvature, touch_plane, Plane};
use crate::vector::{Symmetric2, Vector3};

/// A plane wall and its velocity.
#[derive(Clone, Copy, Debug)]
pub struct MovingPlane {
    /// Where it is.
    pub plane: Plane,
    /// How fast it moves, world frame.
    pub velocity: Vector3,
    /// What its velocity at the step has more than that in the step; read where the particle comes with a change.
    pub velocity_change: Vector3,
}

/// Geometry and motion of a particle at a plane.
fn contact_with_plane(found: &PlaneContact, i: &Particle, wall: &MovingPlane) -> Contact {
    contact_with_wall(
        i,
        &found.support,
        (found.normal, found.tangent),
        found.penetration,
        Symmetric2::new(0.0, 0.0, 0.0),
        [wall.velocity, wall.velocity_change],
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
///
/// # Example
/// ```
/// use ellgran::contact::{prepare_body, Body, Laws, Step};
/// use ellgran::geometry::Plane;
/// use ellgran::vector::Vector3;
/// use ellgran::walls::{geometry_with_plane, one_contact_with_plane, MovingPlane};
///
/// // A ball of 1 mm radius, 10 um deep in a floor.
/// let (parameters, _) = ellgran::force::syntax::parse(&["hertz", "1e7", "0.3"])?;
/// let laws = Laws::new(1, &[Some(parameters)], true)?;
/// let ball = Body {
///     position: [0.0, 0.0, 0.99e-3],
///     quaternion: [1.0, 0.0, 0.0, 0.0],
///     semi_axes: [1e-3; 3],
///     velocity: [0.0; 3],
///     angular_velocity: [0.0; 3],
///     mass: 1e-5,
///     particle_type: 1,
///     identifier: 1,
/// };
/// let ball = prepare_body(&ball, Some(1))?;
/// let floor = MovingPlane {
///     plane: Plane { point: Vector3::ZERO, normal: Vector3::new(0.0, 0.0, 1.0) },
///     velocity: Vector3::ZERO,
///     velocity_change: Vector3::ZERO,
/// };
/// assert!((geometry_with_plane(&ball, &floor, 0.5).penetration - 1e-5).abs() < 1e-15);
/// let (mut touching, mut history) = (false, vec![0.0; laws.layout().length]);
/// let step = Step { time_step: 1e-6, advance_history: true };
/// let (_, forces) = one_contact_with_plane(&laws, &ball, &floor, 1, &step, &mut touching, &mut history)
///     .expect("exact factors")
///     .expect("they touch");
/// let hertz = 4.0 / 3.0 * laws.get(1, 1).effective_modulus() * 1e-3f64.sqrt() * 1e-5f64.powf(1.5);
/// assert!((forces.normal_force / hertz - 1.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
    let mut f = through_law::<true, true, true, true>(
        law, &factors, &x, &layout, history, *touching, before, step,
    );
    if law.resistance.any() {
        let turning = TurningContact::of(&x, x.curvature(), &f);
        couple(law, &turning, &layout, history, *touching, before, step).add_to_first(&mut f);
    }
    *touching = true;
    Ok(Some((
        geometry_with_plane(i, wall, law.constants.share_i),
        f,
    )))
}
