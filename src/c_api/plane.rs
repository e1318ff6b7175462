// SPDX-License-Identifier: MIT OR Apache-2.0
//! A plane, as calls for one contact are given it.

use super::growing::growing;
use super::status::{Failure, ELLGRAN_ERROR_ARGUMENT};
use crate::contact::ranges::{self, LARGEST_COORDINATE, LARGEST_VELOCITY};
use crate::geometry::Plane;
use crate::message::Numbers;
use crate::vector::Vector3;
use crate::walls::MovingPlane;

/// A plane wall: a half-space.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranPlane {
    /// `sizeof(EllgranPlane)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// A point of its surface; components up to 1e20.
    pub point: [f64; 3],
    /// Normal out of the wall, towards the particles; any length but zero.
    pub normal: [f64; 3],
    /// Velocity; components up to 1e25.
    pub velocity: [f64; 3],
    /// What the velocity at the step has more than `velocity`; read where the body's are those of the step. Components up to 1e25.
    pub velocity_change: [f64; 3],
}

growing!(EllgranPlane, velocity: [f64; 3]);

impl EllgranPlane {
    /// As the library takes it. Public for the border of `gpu/driver`; no interface for others.
    #[doc(hidden)]
    pub fn to_core(self) -> Result<MovingPlane, Failure> {
        let fail = |what| Failure::new(ELLGRAN_ERROR_ARGUMENT, what);
        let normal = Vector3::from_array(self.normal)
            .direction()
            .ok_or_else(|| {
                fail(format!(
                    "plane: normal = {} has no direction",
                    Numbers(&self.normal)
                ))
            })?;
        Ok(MovingPlane {
            plane: Plane {
                point: ranges::vector(self.point, LARGEST_COORDINATE, "plane: point")
                    .map_err(fail)?,
                normal,
            },
            velocity: ranges::vector(self.velocity, LARGEST_VELOCITY, "plane: velocity")
                .map_err(fail)?,
            velocity_change: ranges::vector(
                self.velocity_change,
                LARGEST_VELOCITY,
                "plane: velocity_change",
            )
            .map_err(fail)?,
        })
    }
}
