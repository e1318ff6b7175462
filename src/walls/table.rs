// SPDX-License-Identifier: MIT OR Apache-2.0
//! The shapes of walls by their names.

use super::shape::{Shape, ShapeParameters};
use super::{cone, plane, sphere};

/// Adds the parts of a shape, or says what is wrong.
pub(super) type Constructor = fn(&ShapeParameters, &mut Vec<Box<dyn Shape>>) -> Result<(), String>;

/// A new shape is a row here and its file.
pub(super) const SHAPES: [(&str, Constructor); 4] = [
    ("plane", plane::add),
    ("cylinder", cone::add_cylinder),
    ("cone", cone::add_cone),
    ("sphere", sphere::add),
];

/// The constructor of a name, or what there is.
pub(super) fn constructor(name: &str) -> Result<Constructor, String> {
    SHAPES
        .iter()
        .find(|(known, _)| *known == name)
        .map(|(_, make)| *make)
        .ok_or_else(|| {
            let names: Vec<&str> = SHAPES.iter().map(|(known, _)| *known).collect();
            format!("wall shape '{name}' is not one of {}", names.join(", "))
        })
}
