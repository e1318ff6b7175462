// SPDX-License-Identifier: MIT OR Apache-2.0
//! Force and torque of the contact of one grain with a plane wall, and its history.

use crate::contacts::{law_of_types, Load, Scene};
use crate::shapes::Kind;
use ellgran::contact::history::{cached_normal, forget};
use ellgran::contact::pair::{contact_with_wall, factors_for, through_law};
use ellgran::geometry::{touch_plane, Plane};
use ellgran::vector::{Symmetric2, Vector3};

/// A plane wall.
#[derive(Clone, Copy, Debug)]
pub struct MovingPlane {
    /// Where it is.
    pub plane: Plane,
    /// How fast it moves, world frame.
    pub velocity: Vector3,
    /// What that at the step has more; read where forces see velocities of the step.
    pub velocity_change: Vector3,
    /// Its type, counted from 1.
    pub wall_type: u32,
}

/// Load of grain `k` by a plane. `state` is 1 where it touched at the last step, and written; `history` is the grain's own with
/// this wall, [`ellgran::contact::HistoryLayout::length`] doubles.
#[inline(always)]
pub fn contact_with_plane<
    K: Kind,
    const FRICTION: bool,
    const RATE: bool,
    const CONSERVATIVE: bool,
>(
    k: usize,
    scene: &Scene<'_>,
    wall: &MovingPlane,
    state: &mut u32,
    history: &mut [f64],
) -> Load {
    let layout = &scene.layout;
    let mass = scene.inverse_masses.get(k).copied().unwrap_or(0.0);
    let mut i = K::particle(&scene.grains[k], scene.types[k], mass);
    let found = touch_plane(&i.body, i.position, &wall.plane);
    if !(found.penetration > 0.0) {
        if *state != 0 {
            *state = 0;
            forget(layout, history);
        }
        return Load::NONE;
    }
    let law = &scene.laws[law_of_types(i.particle_type, wall.wall_type, scene.type_count)];
    i.change = scene.change(law, k);
    let x = contact_with_wall(
        &i,
        &found.support,
        (found.normal, found.tangent),
        found.penetration,
        Symmetric2::new(0.0, 0.0, 0.0),
        [wall.velocity, wall.velocity_change],
    );
    let factors = factors_for(law, x.curvature());
    let before = cached_normal(layout, history).unwrap_or(found.normal);
    let f = through_law::<FRICTION, RATE, CONSERVATIVE, true>(
        law,
        &factors,
        &x,
        layout,
        history,
        *state != 0,
        before,
        &scene.step,
    );
    *state = 1;
    Load {
        force: -f.force,
        torque: f.torque_i,
    }
}
