// SPDX-License-Identifier: MIT OR Apache-2.0
//! Particles against walls.

pub mod planes;

pub use planes::{
    compute_planes, geometry_with_plane, one_contact_with_plane, MovingPlane, PlanesError,
    WallArrays,
};
