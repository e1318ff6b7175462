// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which numbers a particle, a wall and a step may have.
//!
//! Together with the ranges of the semi-axes ([`crate::geometry::ellipsoid`]) and of the constants of the laws
//! ([`crate::force::parameters`]) they are such that no product in the search and in the law leaves the range of double
//! precision: what is within them has a force. They hold grains of any material in any units of length, mass and time that are
//! within nine powers of ten of a metre, a kilogram and a second.
//!
//! # Example
//! ```
//! use ellgran::contact::ranges::{
//!     LARGEST_COORDINATE, LARGEST_DISPLACEMENT, LARGEST_TANGENTIAL_ENERGY, LARGEST_TANGENTIAL_FORCE, LARGEST_TWIST,
//!     LARGEST_VELOCITY,
//! };
//! use ellgran::contact::{prepare_body, Body, Laws};
//! use ellgran::force::parameters::{LARGEST_CONSTANT, LEAST_CONSTANT, LONGEST_RELAXATION_TIME};
//! use ellgran::force::syntax::parse;
//!
//! // A body that has left the range of coordinates or velocities is refused, before a force overflows.
//! let body = |x: f64, v: f64| Body {
//!     position: [x, 0.0, 0.0],
//!     quaternion: [1.0, 0.0, 0.0, 0.0],
//!     semi_axes: [1.0; 3],
//!     velocity: [v, 0.0, 0.0],
//!     angular_velocity: [0.0; 3],
//!     mass: 1.0,
//!     particle_type: 1,
//!     identifier: 1,
//! };
//! assert!(prepare_body(&body(LARGEST_COORDINATE, LARGEST_VELOCITY), None).is_ok());
//! assert!(prepare_body(&body(2.0 * LARGEST_COORDINATE, 0.0), None).is_err());
//! assert!(prepare_body(&body(0.0, 2.0 * LARGEST_VELOCITY), None).is_err());
//!
//! // So is a history that no step can have left, as of a damaged restart file.
//! let refused = |words: &str, place: usize, value: f64| -> Result<bool, Box<dyn std::error::Error>> {
//!     let (parameters, _) = parse(&words.split(' ').collect::<Vec<_>>())?;
//!     let layout = Laws::new(1, &[Some(parameters)], false)?.layout();
//!     let mut history = vec![0.0; layout.length];
//!     history[place] = value;
//!     Ok(layout.first_wrong(&history).is_some())
//! };
//! // Without normals these begin with the memory: a force, then its energy; or a displacement; or a torque and an angle.
//! let rescaled = "hertz 1e7 0.3 tangential tfd 0.5";
//! assert!(refused(rescaled, 0, 2.0 * LARGEST_TANGENTIAL_FORCE)? && !refused(rescaled, 0, 1.0)?);
//! assert!(refused(rescaled, 3, 2.0 * LARGEST_TANGENTIAL_ENERGY)?);
//! let total = "hertz 1e7 0.3 tangential tfd 0.5 displacement total";
//! assert!(refused(total, 0, 2.0 * LARGEST_DISPLACEMENT)?);
//! let twisting = "hertz 1e7 0.3 twisting sds 1e-2 0 1e-4";
//! assert!(refused(twisting, 0, 2.0 * LARGEST_TWIST)?);
//!
//! // And constants of a law.
//! let modulus = |e: f64| parse(&["hertz", &e.to_string(), "0.3"]);
//! assert!(modulus(0.5 * LEAST_CONSTANT).is_err() && modulus(2.0 * LARGEST_CONSTANT).is_err());
//! let relaxation = (2.0 * LONGEST_RELAXATION_TIME).to_string();
//! assert!(parse(&["hertz", "1e7", "0.3", "damping", "relaxation", &relaxation]).is_err());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

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
