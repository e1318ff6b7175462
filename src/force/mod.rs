// SPDX-License-Identifier: MIT OR Apache-2.0
//! From material constants to laws, and from laws to force (docs/theory.md, sections 2 to 5 and 7). No contact search.

pub mod choice;
pub(crate) mod conservative;
pub(crate) mod contact_begin;
pub mod damping;
pub mod elliptic_integrals;
pub mod hertz_factors;
pub mod law;
pub mod material;
pub mod memory;
pub mod normal;
pub mod parameters;
pub mod rolling;
pub mod spring_bed;
#[cfg(feature = "std")]
pub mod syntax;
pub mod tangential;
pub mod twisting;
pub mod twisting_bed;

pub use choice::Choice;
pub use damping::{Closure, Damping, Unloading, Viscosity};
pub use hertz_factors::Factors;
pub(crate) use law::largest_springs;
pub use law::{LawConstants, LawKinds, PairLaw, Resistance, RollingResistance, TwistingResistance};
pub use material::Material;
pub use memory::MemoryConstants;
pub use normal::{normal_force, NormalConstants, NormalForce, NormalKinds};
pub use parameters::{FactorForm, LawParameters, Normal, ParameterError};
pub use rolling::{rolling_force, Rolling, RollingConstants, RollingForce};
pub use spring_bed::{force_of_springs, Springs, SPRINGS};
pub use tangential::{
    tangential_force, tangential_stiffness, Displacement, Tangential, TangentialConstants,
    TangentialForce, TangentialKinds,
};
pub use twisting::{twisting_torque, TwistSpring, Twisting, TwistingTorque};
