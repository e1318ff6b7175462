// SPDX-License-Identifier: MIT OR Apache-2.0
//! An engine's numbers of one grain, checked and prepared for the contacts of a step.

use crate::shapes::{Grain, GrainChange, Kind};
use ellgran::contact::particle::angular_velocity;
use ellgran::contact::ranges::{is_mass, LARGEST_COORDINATE, LARGEST_VELOCITY};
use ellgran::contact::MotionChange;
use ellgran::geometry::{Ellipsoid, ShapeError};
use ellgran::real::Real;
use ellgran::vector::Vector3;

/// What an engine says of a grain; world frame.
#[derive(Clone, Copy, Debug)]
pub struct EngineGrain {
    /// Centre.
    pub position: [f64; 3],
    /// Velocity of the centre.
    pub velocity: [f64; 3],
    /// Angular momentum about the centre, of a solid ellipsoid.
    pub angular_momentum: [f64; 3],
    /// What velocity and angular momentum of the step have more than those of the half step; zeros where they are those of the half
    /// step.
    pub change: [f64; 6],
    /// Mass of the body.
    pub mass: f64,
    /// Semi-axes.
    pub semi_axes: [f64; 3],
    /// Quaternion `(w, x, y, z)`, body to world.
    pub quaternion: [f64; 4],
    /// Type, counted from 1.
    pub particle_type: u32,
    /// Number of types.
    pub type_count: u32,
}

/// What is wrong with a grain. The number is that of a device's status of the grain, where 0 is a sound one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Fault {
    /// A coordinate that is not finite or beyond [`LARGEST_COORDINATE`].
    Position = 1,
    /// A component of the velocity that is not finite or beyond [`LARGEST_VELOCITY`].
    Velocity = 2,
    /// The same of the angular velocity, from the angular momentum.
    AngularVelocity = 3,
    /// A mass that is not finite or out of range.
    Mass = 4,
    /// A type that is not from 1 to the number of types.
    Type = 5,
    /// A semi-axis out of range.
    SemiAxis = 6,
    /// Semi-axes whose ratio is out of range.
    AspectRatio = 7,
    /// A quaternion that is not finite, or of length zero.
    Quaternion = 8,
    /// A shape of another kind than the scene was prepared for.
    Kind = 9,
    /// It is the image of no grain, or its shape and attitude are nowhere.
    Place = 10,
}

fn within(v: [f64; 3], largest: f64, fault: Fault) -> Result<Vector3, Fault> {
    if v[0].abs() <= largest && v[1].abs() <= largest && v[2].abs() <= largest {
        Ok(Vector3::from_array(v))
    } else {
        Err(fault)
    }
}

fn differences(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The grain, and what its motion has more at the step.
///
/// # Errors
/// The first [`Fault`].
#[inline(always)]
pub fn prepare_grain<K: Kind>(given: &EngineGrain) -> Result<(Grain, GrainChange), Fault> {
    let centre = within(given.position, LARGEST_COORDINATE, Fault::Position)?;
    let [x, y, z, a, b, c] = given.change;
    let velocity = within(
        differences(given.velocity, [x, y, z]),
        LARGEST_VELOCITY,
        Fault::Velocity,
    )?;
    if given.particle_type < 1 || given.particle_type > given.type_count {
        return Err(Fault::Type);
    }
    let (semi_axes, q) = (given.semi_axes, given.quaternion);
    let body = Ellipsoid::new(semi_axes, q).map_err(|wrong| match wrong {
        ShapeError::SemiAxis(_) => Fault::SemiAxis,
        ShapeError::AspectRatio(_) => Fault::AspectRatio,
        ShapeError::Quaternion(_) => Fault::Quaternion,
    })?;
    if !K::takes(semi_axes) {
        return Err(Fault::Kind);
    }
    let mass = given.mass;
    if !(is_mass(mass) && mass.is_finite()) {
        return Err(Fault::Mass);
    }
    let momentum = differences(given.angular_momentum, [a, b, c]);
    let momentum = within(momentum, f64::MAX, Fault::AngularVelocity)?;
    let omega = within(
        angular_velocity(&body, mass, momentum).to_array(),
        LARGEST_VELOCITY,
        Fault::AngularVelocity,
    )?;
    let change = MotionChange {
        velocity: Vector3::new(x, y, z),
        omega: angular_velocity(&body, mass, Vector3::new(a, b, c)),
    };
    let square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    // Engines keep unit quaternions; one whose square has no digits left is as good as none.
    if !(square > 1e-280 && square < 1e280) {
        return Err(Fault::Quaternion);
    }
    let scale = square.reciprocal_sqrt();
    let unit = [q[0] * scale, q[1] * scale, q[2] * scale, q[3] * scale];
    let grain = K::prepare(centre, semi_axes, unit, velocity, omega);
    Ok((grain, change.into()))
}
