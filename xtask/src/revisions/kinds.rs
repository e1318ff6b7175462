// SPDX-License-Identifier: MIT OR Apache-2.0
//! Scenes and laws of the kernel benchmark, as numbers and words.

#[path = "../../../benches/kernels/cases.rs"]
pub mod cases;
#[path = "../../../benches/kernels/layer.rs"]
pub mod layer;
#[path = "../../../benches/kernels/packing.rs"]
pub mod packing;
