// SPDX-License-Identifier: MIT OR Apache-2.0
//! Force and torque of the contacts of one grain with a wall of surfaces that have no memory of their own, and their histories.

use crate::contacts::{law_of_types, Load, Scene};
use crate::shapes::Kind;
use ellgran::contact::Particle;
use ellgran::force::PairLaw;
use ellgran::vector::Vector3;
use ellgran::walls::one_particle::{ParticleLoad, TooLittleRoom, WallInMotion};
use ellgran::walls::{Ball, Motion, Surface, WallHistoryLayout};

/// What is wrong with a grain that has more contacts with a wall than a thread has room for: beside
/// [`Fault`](crate::preparation::Fault).
pub const TOO_MANY_CONTACTS: u32 = 11;

/// A wall.
#[derive(Clone, Copy, Debug)]
pub struct MovingWall<'a> {
    /// Its parts.
    pub surfaces: &'a [Surface],
    /// Where it is and how it moves.
    pub motion: Motion,
    /// How the histories of a grain with it are laid out.
    pub layout: WallHistoryLayout,
    /// Its type, counted from 1.
    pub wall_type: u32,
}

/// The numbers of a [`Motion`], as a device takes them.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct WallMotion {
    /// See [`Motion`].
    pub origin: Vector3,
    /// See [`Motion`].
    pub displacement: Vector3,
    /// See [`Motion`]; read where `has_turned`.
    pub axes: [Vector3; 3],
    /// See [`Motion`].
    pub velocity: Vector3,
    /// See [`Motion`].
    pub angular_velocity: Vector3,
    /// See [`Motion`].
    pub velocity_change: Vector3,
    /// See [`Motion`].
    pub angular_velocity_change: Vector3,
    /// 1 where there are axes.
    pub has_turned: u32,
    /// See [`Motion`]; 1 for yes.
    pub along_itself: u32,
}

impl From<&Motion> for WallMotion {
    fn from(m: &Motion) -> Self {
        WallMotion {
            origin: m.origin,
            displacement: m.displacement,
            axes: m.axes.unwrap_or([Vector3::ZERO; 3]),
            velocity: m.velocity,
            angular_velocity: m.angular_velocity,
            velocity_change: m.velocity_change,
            angular_velocity_change: m.angular_velocity_change,
            has_turned: u32::from(m.axes.is_some()),
            along_itself: u32::from(m.along_itself),
        }
    }
}

impl From<&WallMotion> for Motion {
    #[inline(always)]
    fn from(m: &WallMotion) -> Self {
        Motion {
            origin: m.origin,
            displacement: m.displacement,
            axes: if m.has_turned != 0 {
                Some(m.axes)
            } else {
                None
            },
            velocity: m.velocity,
            angular_velocity: m.angular_velocity,
            velocity_change: m.velocity_change,
            angular_velocity_change: m.angular_velocity_change,
            along_itself: m.along_itself != 0,
        }
    }
}

/// One function for all kinds of grains: it is long, and few grains come here.
#[inline(never)]
fn load_of_particle(
    wall: &WallInMotion<'_>,
    surfaces: &[Surface],
    law: &PairLaw,
    i: &Particle,
    histories: &mut [f64],
) -> Result<ParticleLoad, TooLittleRoom> {
    wall.load_by_surfaces(surfaces, law, i, histories)
}

/// Load of grain `k` by a wall. `state` is the number of its contacts at the last step, and written; `histories` are the grain's own with
/// this wall, as its layout says.
///
/// # Errors
/// More contacts than there is room for. Nothing is written then.
#[inline(always)]
pub fn contacts_with_wall<K: Kind>(
    k: usize,
    scene: &Scene<'_>,
    wall: &MovingWall<'_>,
    state: &mut u32,
    histories: &mut [f64],
) -> Result<Load, TooLittleRoom> {
    let grain = &scene.grains[k];
    let wall_now = WallInMotion {
        motion: &wall.motion,
        layout: wall.layout,
        of_laws: scene.layout,
        step: scene.step,
    };
    let ball = Ball {
        particle: k,
        centre: wall.motion.point_to_wall(grain.centre()),
        radius: K::radius(grain),
    };
    // Most grains are far from a wall.
    if !wall.surfaces.iter().any(|s| s.is_near(&ball)) {
        if *state != 0 {
            *state = 0;
            wall_now.forget(histories);
        }
        return Ok(Load::NONE);
    }
    let mass = scene.inverse_masses.get(k).copied().unwrap_or(0.0);
    let mut i = K::particle(grain, scene.types[k], mass);
    let law = &scene.laws[law_of_types(i.particle_type, wall.wall_type, scene.type_count)];
    i.change = scene.change(law, k);
    let load = load_of_particle(&wall_now, wall.surfaces, law, &i, histories)?;
    *state = load.contacts as u32;
    Ok(Load {
        force: load.force,
        torque: load.torque,
    })
}
