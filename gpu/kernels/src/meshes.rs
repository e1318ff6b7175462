// SPDX-License-Identifier: MIT OR Apache-2.0
//! Force and torque of the contacts of one grain with a wall of which parts are triangles, and their histories.
//!
//! Most grains are far from a wall: those that are not are found first, and then each of these takes a thread that has room for the search. Few of
//! them have so many triangles near that they need larger room.

use crate::contacts::{law_of_types, Load, Scene};
use crate::shapes::{Ellipsoids, Kind, Spheroids};
use ellgran::walls::one_particle::{TooLittleRoom, WallInMotion};
use ellgran::walls::parts::{LentRoom, Parts, Room};
use ellgran::walls::{Ball, Motion, WallHistoryLayout};

/// What is wrong with a grain that has more triangles near than a thread has room for: beside
/// [`Fault`](crate::preparation::Fault).
pub const TOO_MANY_TRIANGLES: u32 = 12;

/// Triangles near a grain, at most.
pub const MOST_TRIANGLES: usize = 512;
/// Faces, edges and corners that support a grain, at most.
pub const MOST_SUPPORTS: usize = 512;

/// Room for most grains.
pub type SmallRoom = Room<32, 48, 256>;
/// Room for any.
pub type LargeRoom = Room<MOST_TRIANGLES, MOST_SUPPORTS, 4096>;

/// Of the counts of a call: grains that are near the wall.
pub const NEAR: usize = 0;
/// Those of them that need large room.
pub const CROWDED: usize = 1;
/// Number of counts.
pub const COUNTS: usize = 2;

/// A wall.
#[derive(Clone, Copy, Debug)]
pub struct MovingMesh<'a> {
    /// Its parts.
    pub parts: Parts<'a>,
    /// Where it is and how it moves.
    pub motion: Motion,
    /// How the histories of a grain with it are laid out.
    pub layout: WallHistoryLayout,
    /// Its type, counted from 1.
    pub wall_type: u32,
}

impl MovingMesh<'_> {
    #[inline(always)]
    fn now(&self, scene: &Scene<'_>) -> WallInMotion<'_> {
        WallInMotion {
            motion: &self.motion,
            layout: self.layout,
            of_laws: scene.layout,
            step: scene.step,
        }
    }
}

/// Whether grain `k` may touch a wall. Of one that may not all is forgotten: `state` is the number of its contacts at the last step, `histories`
/// are its own with this wall.
#[inline(always)]
pub fn is_near_mesh<K: Kind>(
    k: usize,
    scene: &Scene<'_>,
    wall: &MovingMesh<'_>,
    state: &mut u32,
    histories: &mut [f64],
) -> bool {
    let grain = &scene.grains[k];
    let ball = Ball {
        particle: k,
        centre: wall.motion.point_to_wall(grain.centre()),
        radius: K::radius(grain),
    };
    let is_near = wall.parts.are_near(&ball);
    if !is_near && *state != 0 {
        *state = 0;
        wall.now(scene).forget(histories);
    }
    is_near
}

/// Load of grain `k` by a wall. `state` is the number of its contacts at the last step, and written; `histories` are the grain's own with
/// this wall, as its layout says. One function for all kinds of grains and rooms: it is long.
///
/// # Errors
/// There is too little room. Nothing is written then.
#[inline(never)]
pub fn contacts_with_mesh(
    k: usize,
    scene: &Scene<'_>,
    are_ellipsoids: bool,
    wall: &MovingMesh<'_>,
    room: LentRoom<'_>,
    state: &mut u32,
    histories: &mut [f64],
) -> Result<Load, TooLittleRoom> {
    let mass = scene.inverse_masses.get(k).copied().unwrap_or(0.0);
    let (grain, particle_type) = (&scene.grains[k], scene.types[k]);
    let mut i = if are_ellipsoids {
        Ellipsoids::particle(grain, particle_type, mass)
    } else {
        Spheroids::particle(grain, particle_type, mass)
    };
    let law = &scene.laws[law_of_types(particle_type, wall.wall_type, scene.type_count)];
    i.change = scene.change(law, k);
    let now = wall.now(scene);
    let load = now.load_by_parts(&wall.parts, law, &i, room, histories)?;
    *state = load.contacts as u32;
    Ok(Load {
        force: load.force,
        torque: load.torque,
    })
}
