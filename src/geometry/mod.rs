// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bodies by their support function, the contact search, curvature (docs/theory.md, sections 1 and 7). No force, no allocation.

pub mod box_tree;
pub mod cone;
pub mod contact_search;
pub mod convex_body;
pub mod curvature;
pub mod ellipsoid;
pub mod facet_shares;
pub mod global_minimum;
pub mod interior_point;
pub mod plane;
pub mod spheroid;
pub mod tangent_model;
pub mod triangles;

pub use contact_search::{search, ContactSearch, Outcome};
pub use convex_body::{ConvexBody, SupportInFrame};
pub use curvature::{radii_of_curvature, relative_curvature, Curvature};
pub use ellipsoid::{Ellipsoid, ShapeError, Support};
pub use plane::{touch_plane, Plane};
pub use spheroid::Spheroid;
