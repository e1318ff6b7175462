// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which numbers a particle, a wall and a step may have.
//!
//! Together with the ranges of the semi-axes ([`crate::geometry::ellipsoid`]) and of the constants of the laws
//! ([`crate::force::parameters`]) they are such that no product in the search and in the law leaves the range of double
//! precision: what is within them has a force. They hold grains of any material in any units of length, mass and time that are
//! within nine powers of ten of a metre, a kilogram and a second.

use crate::message::{Number, Numbers};
use crate::vector::Vector3;
#[cfg(not(feature = "std"))]
use alloc::string::String;

/// Largest size of a coordinate of a centre or of a wall, length.
pub const LARGEST_COORDINATE: f64 = 1e20;
/// Largest size of a component of a velocity (length/time) and of an angular velocity (1/time).
pub const LARGEST_VELOCITY: f64 = 1e25;
/// Longest time step.
pub const LONGEST_TIME_STEP: f64 = 1e15;
/// Smallest and largest mass; a body may also be infinitely heavy.
pub const LEAST_MASS: f64 = 1e-50;
/// See [`LEAST_MASS`].
pub const LARGEST_MASS: f64 = 1e50;
/// Largest size of a component of a remembered tangential displacement.
pub const LARGEST_DISPLACEMENT: f64 = 1e75;
/// Largest size of a component of a remembered tangential force.
pub const LARGEST_TANGENTIAL_FORCE: f64 = 1e140;
/// Largest size of a remembered torque or angle of a twist.
pub const LARGEST_TWIST: f64 = 1e200;
/// Largest size of a remembered energy.
pub const LARGEST_TANGENTIAL_ENERGY: f64 = 1e200;

/// A vector whose components are at most so large.
pub(crate) fn vector(v: [f64; 3], largest: f64, what: &str) -> Result<Vector3, String> {
    if v.iter().all(|x| x.abs() <= largest) {
        return Ok(Vector3::from_array(v));
    }
    let (value, range) = (Numbers(&v), Number(largest));
    Err(if v.iter().all(|x| x.is_finite()) {
        format!(
            "{what} = {value} is out of range: its components must be between -{range} and {range}"
        )
    } else {
        format!("{what} = {value} is not finite")
    })
}

/// A position.
pub(crate) fn position(v: [f64; 3]) -> Result<Vector3, String> {
    vector(v, LARGEST_COORDINATE, "position")
}

/// A velocity.
pub(crate) fn velocity(v: [f64; 3]) -> Result<Vector3, String> {
    vector(v, LARGEST_VELOCITY, "velocity")
}

/// An angular velocity.
pub(crate) fn angular_velocity(v: [f64; 3]) -> Result<Vector3, String> {
    vector(v, LARGEST_VELOCITY, "angular velocity")
}

/// Whether a mass can be, infinite for a fixed body.
#[doc(hidden)]
#[inline(always)]
pub fn is_mass(mass: f64) -> bool {
    (LEAST_MASS..=LARGEST_MASS).contains(&mass) || mass == f64::INFINITY
}

/// The inverse of a mass, which may be infinite.
pub(crate) fn inverse_mass(mass: f64, what: &str) -> Result<f64, String> {
    if is_mass(mass) {
        return Ok(1.0 / mass);
    }
    let mass = Number(mass);
    Err(format!(
        "{what} = {mass} must be greater than 0, from {LEAST_MASS:e} to {LARGEST_MASS:e}, or infinite for a fixed body"
    ))
}
