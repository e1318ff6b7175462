// SPDX-License-Identifier: MIT OR Apache-2.0
//! One contact at a time: geometry, force, torques, history in and out. The same functions as the neighbour list's, so
//! that both give the same numbers.

use super::contact::{contact_forces, relative_curvature_matrix, ContactForces};
use super::laws::Laws;
use super::neighbour_list::{
    cached_normal, contact_of, factors_for, forget, hale_holds, normal_before, recall, remember,
    touch, touch_spheres,
};
use super::particles::{describe, Particle, ParticleError};
use super::planes::{contact_with_plane, plane_forces, MovingPlane};
use super::ranges;
use super::Step;
use crate::geometry::contact_search::gap;
use crate::geometry::{
    relative_curvature, touch_plane, ContactSearch, Ellipsoid, Outcome, Vector3,
};

/// A body of one contact. World frame.
#[derive(Clone, Copy, Debug)]
pub struct Body {
    /// Centre.
    pub position: [f64; 3],
    /// Rotation from body to world, `(w, x, y, z)`; normalised here.
    pub quaternion: [f64; 4],
    /// Semi-axes along the body axes.
    pub semi_axes: [f64; 3],
    /// Velocity of the centre.
    pub velocity: [f64; 3],
    /// Angular velocity.
    pub angular_velocity: [f64; 3],
    /// Mass, read by damping with a coefficient of restitution; infinite for a fixed body.
    pub mass: f64,
    /// Type, counted from 1.
    pub kind: i32,
    /// What to call it in a message.
    pub identifier: i64,
}

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

/// Checks a body and prepares it.
///
/// # Errors
/// Names the body and the value.
pub fn prepare_body(body: &Body, types: Option<usize>) -> Result<Particle, ParticleError> {
    let fail = |what: String| ParticleError {
        identifier: body.identifier,
        what,
    };
    let mut inverse_mass = 0.0;
    if let Some(types) = types {
        if body.kind < 1 || body.kind as usize > types {
            return Err(fail(format!(
                "type {} is not between 1 and {types}",
                body.kind
            )));
        }
        inverse_mass = ranges::inverse_mass(body.mass, "mass").map_err(fail)?;
    }
    let shape = Ellipsoid::new(body.semi_axes, body.quaternion)
        .map_err(|e| fail(describe(e, body.semi_axes, body.quaternion)))?;
    Ok(Particle {
        position: ranges::position(body.position).map_err(fail)?,
        radius: shape.bounding_radius(),
        body: shape,
        velocity: ranges::velocity(body.velocity).map_err(fail)?,
        omega: ranges::angular_velocity(body.angular_velocity).map_err(fail)?,
        inverse_mass,
        kind: body.kind.max(0) as u32,
        sphere: shape.is_sphere(),
    })
}

pub(super) fn geometry_of(
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

/// Whether two bodies touch: the one place where the calls for one contact decide it.
enum Pair {
    Touching(ContactSearch),
    Apart {
        /// Unit normal of a plane between the bodies.
        normal: Vector3,
        /// Whether the search found it: then it is the start of the next one.
        searched: bool,
    },
}

impl Pair {
    fn of(i: &Particle, j: &Particle, start: Option<Vector3>) -> Pair {
        let d = j.position - i.position;
        let reach = i.radius + j.radius;
        if d.norm_squared() >= reach * reach {
            // Not zero: it is longer than the semi-axes.
            let normal = d.direction().unwrap_or(Vector3::new(1.0, 0.0, 0.0));
            return Pair::Apart {
                normal,
                searched: false,
            };
        }
        match touch(i, j, d, start) {
            Outcome::Touching(found) if found.penetration > 0.0 => Pair::Touching(found),
            Outcome::Touching(found) => Pair::Apart {
                normal: found.normal,
                searched: false,
            },
            Outcome::Separated(normal) => Pair::Apart {
                normal,
                searched: true,
            },
        }
    }
}

/// Geometry of two bodies that a plane is known to separate, to rounding at least: they do not touch.
fn geometry_apart(i: &Particle, j: &Particle, share_i: f64, normal: Vector3) -> OneContact {
    let d = j.position - i.position;
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

/// Geometry of an ellipsoid and a plane.
pub fn geometry_with_plane(i: &Particle, wall: &MovingPlane, share_i: f64) -> OneContact {
    let found = touch_plane(&i.body, i.position, &wall.plane);
    let x = contact_with_plane(&found, i, wall);
    let curvature = relative_curvature(
        relative_curvature_matrix(x.weingarten_i, x.weingarten_j),
        &found.tangent,
    );
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

/// Hale's form broke: the ratio `B/A`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HaleRatio(pub f64);

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
            let share_i = laws.get(i.kind as usize, j.kind as usize).constants.share_i;
            (geometry_apart(i, j, share_i, normal), None)
        }
    })
}

/// A contact, or the normal of a plane between the bodies.
type ContactOrPlane = Result<(OneContact, ContactForces), Vector3>;

fn compute(
    laws: &Laws,
    i: &Particle,
    j: &Particle,
    step: &Step,
    touching: &mut bool,
    history: &mut [f64],
) -> Result<ContactOrPlane, HaleRatio> {
    let layout = laws.layout();
    let law = laws.get(i.kind as usize, j.kind as usize);
    let d = j.position - i.position;
    let cached = cached_normal(&layout, history);
    let found = match Pair::of(i, j, cached) {
        Pair::Touching(found) => found,
        Pair::Apart { normal, searched } => {
            if let Some(at) = layout.normal.filter(|_| searched) {
                history[at..at + 3].copy_from_slice(&normal.to_array());
            }
            if *touching {
                *touching = false;
                forget(&layout, history);
            }
            return Ok(Err(normal));
        }
    };
    let x = contact_of(&found, i, j);
    let curvature = relative_curvature_matrix(x.weingarten_i, x.weingarten_j);
    if law.kinds.hale {
        hale_holds(curvature).map_err(HaleRatio)?;
    }
    let factors = factors_for(law, curvature.trace(), curvature.determinant());
    let before = normal_before(cached, i, j, d, found.normal, step);
    let remembered = recall(&layout, history, *touching, step, found.normal, before);
    let f = contact_forces::<f64, true, true, true, false>(
        &law.kinds,
        &law.constants,
        &factors,
        curvature,
        &x,
        &remembered,
    );
    remember(&layout, history, found.normal, &f);
    *touching = true;
    Ok(Ok((geometry_of(&found, i, j, law.constants.share_i), f)))
}

/// One contact of an ellipsoid and a plane; otherwise like [`one_contact`].
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
    let law = laws.get(i.kind as usize, wall_type);
    let x = contact_with_plane(&found, i, wall);
    if law.kinds.hale {
        hale_holds(relative_curvature_matrix(x.weingarten_i, x.weingarten_j)).map_err(HaleRatio)?;
    }
    let before = cached_normal(&layout, history).unwrap_or(found.normal);
    let remembered = recall(&layout, history, *touching, step, found.normal, before);
    let f = plane_forces(law, &x, &remembered);
    remember(&layout, history, found.normal, &f);
    *touching = true;
    Ok(Some((
        geometry_with_plane(i, wall, law.constants.share_i),
        f,
    )))
}
