// SPDX-License-Identifier: MIT OR Apache-2.0
//! Several numbers at a time in the lanes of vector registers: the instruction sets, their registers, and the number that
//! geometry and force see in them. Knows numbers alone.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod instruction_set;
mod lanes;
#[cfg(target_arch = "aarch64")]
mod neon;
#[cfg(any(test, not(any(target_arch = "x86_64", target_arch = "aarch64"))))]
mod portable;
mod registers;
#[cfg(target_arch = "x86_64")]
mod sse2;
#[cfg(test)]
mod tests;
mod twice;

pub use instruction_set::{InstructionSet, ENVIRONMENT_VARIABLE};
pub(crate) use lanes::{lines, put, values};

// Public for this repository's own measurements; no interface for others.
#[doc(hidden)]
pub use instruction_set::Stage;
#[doc(hidden)]
pub use lanes::Lanes;
#[doc(hidden)]
pub use registers::{Line, Registers, MOST_LANES};
