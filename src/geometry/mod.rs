// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bodies by their support function, the contact search, curvature (docs/theory.md, sections 1 and 7). No force, no allocation.

// Public for the kernels in `gpu/`; no interface for others.
#[doc(hidden)]
pub mod box_tree;
pub mod cone;
pub mod contact_search;
pub(crate) mod convex_body;
pub(crate) mod convex_corner;
pub mod curvature;
#[cfg(feature = "std")]
pub(crate) mod edge_to_edge;
pub mod ellipsoid;
pub mod facet_shares;
pub(crate) mod fine_folds;
#[cfg(feature = "std")]
pub(crate) mod flat_pieces;
#[cfg(feature = "std")]
pub(crate) mod flat_place;
pub(crate) mod global_minimum;
pub(crate) mod interior_point;
pub(crate) mod lists;
pub(crate) mod mixed_corners;
pub(crate) mod nearest_line;
pub mod plane;
#[cfg(test)]
pub(crate) mod random;
#[cfg(feature = "std")]
pub(crate) mod rounded_corners;
pub(crate) mod share;
#[cfg(feature = "std")]
pub(crate) mod shared_edges;
// Public for the kernels in `gpu/`; no interface for others.
#[doc(hidden)]
pub mod small_motion;
pub(crate) mod spheroid;
pub(crate) mod tangent_model;
pub(crate) mod triangle;
pub(crate) mod triangle_places;
pub(crate) mod triangle_room;
pub mod triangles;

pub use contact_search::{search, ContactSearch, Outcome};
// Public for the kernels in `gpu/`; no interface for others.
#[doc(hidden)]
pub use convex_body::{ConvexBody, SupportInFrame};
pub use curvature::{radii_of_curvature, relative_curvature, Curvature};
pub use ellipsoid::{Ellipsoid, ShapeError, Support};
pub use plane::{touch_plane, Plane};
#[doc(hidden)]
pub use spheroid::Spheroid;
