// SPDX-License-Identifier: MIT OR Apache-2.0
//! Walls: rigid surfaces made of parts of any shape, in motion or at rest, against all particles in one call.
//!
//! A shape finds the places where an ellipsoid touches it ([`Shape`], one file each, named in the table `SHAPES`); all
//! else is common: the wall's frame and its motion (`motion.rs`), what is remembered of a contact from step to step
//! (`histories.rs`), the contacts of all particles (`contacts.rs`), and their force, torque and energies, unless an engine's own contact
//! model computes these: in lanes (`lane_pass.rs`) or contact by contact (`compute.rs`).

mod compute;
mod cone;
mod cone_in_lanes;
mod contacts;
mod grain_sums;
mod histories;
mod lane_pass;
mod lent_triangles;
mod lone_contacts;
mod mesh;
mod motion;
mod near_triangles;
mod one_plane;
mod periodic;
mod plane;
mod recalled;
mod rim;
mod servo;
mod shape;
mod shape_words;
mod sphere;
mod step_sums;
pub mod stl;
mod tip;
mod touching_loads;
mod triangle_file;
mod wall;

pub use compute::{compute_wall, WallError, WallInput, WallOutput};
pub use contacts::{Contacts, FoundContact, Frame, Places, StagedInWorld};
pub use histories::{WallHistoryLayout, WrongHistory};
pub use lane_pass::{compute_wall_in_lanes, RecordsInput};
pub use lent_triangles::LentTriangles;
pub use mesh::Mesh;
pub use motion::Motion;
pub use one_plane::{geometry_with_plane, one_contact_with_plane, MovingPlane};
pub use periodic::{MissingImage, PeriodicBox};
pub use servo::{Servo, ServoLoad};
pub use shape::{
    Ball, Block, ConeSide, End, Found, Grain, Search, Shape, ShapeInLanes, ShapeParameters, Side,
    WholePlane,
};
use shape_words::words_of;
pub use shape_words::{ShapeWords, SHAPE_SYNTAX};
pub use step_sums::WallMasses;
pub use touching_loads::TouchingLoad;
pub use triangle_file::write_triangle_loads;
pub use wall::{RecordedWallContact, TriangleLoad, Wall, WallLoad};

/// Adds the parts of a shape, or says what is wrong.
type Constructor = fn(&ShapeParameters, &mut Vec<Box<dyn Shape>>) -> Result<(), String>;

/// A new shape is a row here and its file.
const SHAPES: [(&str, Constructor); 4] = [
    ("plane", plane::add),
    ("cylinder", cone::add_cylinder),
    ("cone", cone::add_cone),
    ("sphere", sphere::add),
];

/// Whether a shape of this name has an axis; a name that is not known has none.
pub(crate) fn shape_has_axis(name: &str) -> bool {
    SHAPES.iter().any(|(known, _)| *known == name) && words_of(name).contains(&"axis")
}

/// The constructor of a name, or what there is.
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
