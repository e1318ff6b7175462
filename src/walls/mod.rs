// SPDX-License-Identifier: MIT OR Apache-2.0
//! Walls: rigid surfaces made of parts of any shape, in motion or at rest, against all particles in one call.
//!
//! A shape finds the places where an ellipsoid touches it ([`Shape`], one file each, named in the table of `table.rs`); all
//! else is common: the wall's frame and its motion (`motion.rs`), what is remembered of a contact from step to step
//! (`memory.rs`), force, torque and energies (`compute.rs`).

mod bounding_boxes;
mod compute;
mod cone;
mod memory;
mod mesh;
mod motion;
mod plane;
pub mod planes;
mod rim;
mod servo;
mod shape;
mod sphere;
pub mod stl;
mod table;
mod triangle_file;
mod wall;

pub use compute::{compute_wall, WallError, WallInput, WallOutput};
pub use memory::MemoryLayout;
pub use mesh::Mesh;
pub use motion::Motion;
pub use planes::{
    compute_planes, geometry_with_plane, one_contact_with_plane, MovingPlane, PlanesError,
    WallArrays,
};
pub use servo::{Servo, ServoLoad};
pub use shape::{End, Shape, ShapeParameters, Side};
pub use triangle_file::write_triangle_loads;
pub use wall::{RecordedWallContact, TriangleLoad, Wall, WallLoad};
