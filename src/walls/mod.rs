// SPDX-License-Identifier: MIT OR Apache-2.0
//! Walls: rigid surfaces made of parts of any shape, in motion or at rest, against all particles in one call.
//!
//! A shape finds the places where an ellipsoid touches it ([`Shape`], one file each, named in the table `SHAPES`); all
//! else is common: the wall's frame and its motion (`motion.rs`), what is remembered of a contact from step to step
//! (`histories.rs`), the contacts of all particles (`contacts.rs`), and their force, torque and energies, unless an engine's own contact
//! model computes these: in lanes (`lane_pass.rs`) or contact by contact (`compute.rs`).

#[cfg(feature = "std")]
mod compute;
mod cone;
#[cfg(feature = "std")]
mod cone_in_lanes;
mod contact_history;
#[cfg(feature = "std")]
mod contacts;
#[cfg(feature = "std")]
mod deep_in_solid;
#[cfg(feature = "std")]
mod grain_sums;
mod histories;
#[cfg(feature = "std")]
mod lane_pass;
#[cfg(feature = "std")]
mod lent_triangles;
#[cfg(feature = "std")]
mod lone_contacts;
#[cfg(feature = "std")]
mod mesh;
mod motion;
#[cfg(feature = "std")]
mod near_triangles;
// Public for the kernels in `gpu/`; no interface for others.
#[doc(hidden)]
pub mod one_particle;
#[cfg(feature = "std")]
mod one_plane;
#[cfg(feature = "std")]
mod part_in_lanes;
// Public for the kernels in `gpu/`; no interface for others.
#[doc(hidden)]
pub mod parts;
#[cfg(feature = "std")]
mod periodic;
mod plane;
#[cfg(feature = "std")]
mod recalled;
mod rim;
#[cfg(feature = "std")]
mod servo;
mod shape;
#[cfg(feature = "std")]
mod shape_words;
#[cfg(feature = "std")]
mod solid_block;
mod sphere;
#[cfg(feature = "std")]
mod step_sums;
#[cfg(feature = "std")]
pub mod stl;
mod surface;
mod tip;
mod touched;
#[cfg(feature = "std")]
mod touching_loads;
mod triangle_contacts;
#[cfg(feature = "std")]
mod triangle_file;
#[cfg(feature = "std")]
mod wall;

#[cfg(feature = "std")]
pub use compute::{compute_wall, WallError, WallInput, WallOutput};
#[cfg(feature = "std")]
pub use contacts::{Contacts, FoundContact, Frame, Places, StagedInWorld};
pub use histories::{WallHistoryLayout, WrongHistory};
#[cfg(feature = "std")]
pub use lane_pass::{compute_wall_in_lanes, RecordsInput};
#[cfg(feature = "std")]
pub use lent_triangles::LentTriangles;
#[cfg(feature = "std")]
pub use mesh::{flatten_triangles, Mesh};
pub use motion::Motion;
#[cfg(feature = "std")]
pub use one_plane::{geometry_with_plane, one_contact_with_plane, MovingPlane};
#[cfg(feature = "std")]
pub use periodic::{MissingImage, PeriodicBox};
#[cfg(feature = "std")]
pub use servo::{Servo, ServoLoad};
pub use shape::{Ball, ConeSide, End, Grain, ShapeParameters, Side, WholePlane};
#[cfg(feature = "std")]
pub use shape::{Block, Found, Search, Shape, ShapeInLanes};
#[cfg(feature = "std")]
use shape_words::words_of;
#[cfg(feature = "std")]
pub use shape_words::{ShapeWords, SHAPE_SYNTAX};
#[cfg(feature = "std")]
pub use step_sums::WallMasses;
#[doc(hidden)]
pub use surface::Surface;
#[cfg(feature = "std")]
pub use touching_loads::TouchingLoad;
#[cfg(feature = "std")]
pub use triangle_file::write_triangle_loads;
#[cfg(feature = "std")]
pub use wall::{ForceAndTorque, RecordedWallContact, TriangleLoad, Wall, WallLoad};

/// Adds the parts of a shape, or says what is wrong.
#[cfg(feature = "std")]
type Constructor = fn(&ShapeParameters, &mut Vec<Box<dyn Shape>>) -> Result<(), String>;

/// A new shape is a row here and its file.
#[cfg(feature = "std")]
const SHAPES: [(&str, Constructor); 4] = [
    ("plane", plane::add),
    ("cylinder", cone::add_cylinder),
    ("cone", cone::add_cone),
    ("sphere", sphere::add),
];

/// Whether a shape of this name has an axis; a name that is not known has none.
#[cfg(feature = "std")]
pub(crate) fn shape_has_axis(name: &str) -> bool {
    SHAPES.iter().any(|(known, _)| *known == name) && words_of(name).contains(&"axis")
}

/// The constructor of a name, or what there is.
#[cfg(feature = "std")]
fn constructor(name: &str) -> Result<Constructor, String> {
    SHAPES
        .iter()
        .find(|(known, _)| *known == name)
        .map(|(_, make)| *make)
        .ok_or_else(|| {
            let names: Vec<&str> = SHAPES.iter().map(|(known, _)| *known).collect();
            format!("wall shape '{name}' is not one of {}", names.join(", "))
        })
}

#[cfg(feature = "std")]
impl Wall {
    /// Adds the parts of a shape of the table ([`Shape`]).
    ///
    /// # Errors
    /// An unknown name, or parameters that do not make such a shape.
    pub fn add_shape(&mut self, name: &str, parameters: &ShapeParameters) -> Result<(), String> {
        let make = constructor(name)?;
        let mut parts = vec![];
        make(parameters, &mut parts)?;
        self.parts.append(&mut parts);
        Ok(())
    }
}
