// SPDX-License-Identifier: MIT OR Apache-2.0
//! Several numbers at a time in the lanes of vector registers: the instruction sets, and which of them the neighbour-list path
//! runs on, chosen when a workspace is made and never in a step. Knows numbers alone.

#[cfg(all(feature = "std", target_arch = "x86_64"))]
mod avx2;
#[cfg(all(feature = "std", target_arch = "x86_64"))]
mod avx512;
mod lanes;
#[cfg(all(feature = "std", target_arch = "aarch64"))]
mod neon;
#[cfg(any(
    test,
    not(feature = "std"),
    not(any(target_arch = "x86_64", target_arch = "aarch64"))
))]
mod portable;
mod registers;
mod rows;
#[cfg(all(feature = "std", target_arch = "x86_64"))]
mod sse2;
#[cfg(test)]
mod tests;
mod twice;

pub(crate) use lanes::{lines, put, values};
pub(crate) use rows::{
    components, double_components, first_numbers, put_components, put_double_components,
};
use twice::Twice;

// Public for this repository's own measurements; no interface for others.
#[doc(hidden)]
pub use lanes::Lanes;
#[doc(hidden)]
pub use registers::{Line, Registers, MOST_LANES};

/// The environment variable that forces a choice: the name of a set.
///
/// # Example
/// ```
/// use ellgran::simd::{InstructionSet, ENVIRONMENT_VARIABLE};
///
/// std::env::set_var(ENVIRONMENT_VARIABLE, "scalar");
/// assert_eq!(InstructionSet::choose()?, InstructionSet::Scalar);
/// # Ok::<(), String>(())
/// ```
pub const ENVIRONMENT_VARIABLE: &str = "ELLGRAN_INSTRUCTION_SET";

// The sets that not every machine of a target has: the name, the target, and the type of pulp that proves that the machine has
// the set, for which the set's file implements `Registers`. Widest last.
instruction_sets! {
    /// Registers of four numbers, with fused multiply-add (x86-64-v3).
    Avx2 = "avx2", "x86_64", pulp::x86::V3;
    /// Registers of eight numbers (x86-64-v4).
    Avx512 = "avx512", "x86_64", pulp::x86::V4;
}

/// A piece of work that is compiled for each instruction set.
#[doc(hidden)]
pub trait Stage {
    /// Does it.
    fn run<S: Registers>(self, registers: S);
}

/// Counts the lanes.
struct CountLanes<'a>(&'a mut usize);

impl Stage for CountLanes<'_> {
    #[inline(always)]
    fn run<S: Registers>(self, _: S) {
        *self.0 = S::LANES;
    }
}

/// What `pulp` calls with the instructions of a set turned on.
#[cfg_attr(not(all(feature = "std", target_arch = "x86_64")), allow(dead_code))]
struct InLanes<S, T> {
    registers: S,
    stage: T,
}

#[cfg(feature = "std")]
impl<S: Registers, T: Stage> pulp::NullaryFnOnce for InLanes<S, T> {
    type Output = ();
    #[inline(always)]
    fn call(self) {
        self.stage.run(self.registers)
    }
}

/// The enumeration of the sets, and what depends on which of them there are.
macro_rules! instruction_sets {
    ($($(#[$doc:meta])* $set:ident = $name:literal, $target:literal, $token:ty;)+) => {
        /// An instruction set for the lanes.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum InstructionSet {
            /// One number at a time; any machine.
            Scalar,
            /// Registers of two numbers, which every machine has (SSE2 on x86-64, NEON on AArch64).
            Baseline,
            $($(#[$doc])* $set,)+
        }

        impl InstructionSet {
            /// All of them, widest last.
            pub const ALL: [InstructionSet; 2 + [$($name),+].len()] =
                [InstructionSet::Scalar, InstructionSet::Baseline, $(InstructionSet::$set),+];

            /// Its name, as the environment variable takes it.
            pub fn name(self) -> &'static str {
                match self {
                    InstructionSet::Scalar => "scalar",
                    InstructionSet::Baseline => "baseline",
                    $(InstructionSet::$set => $name,)+
                }
            }

            /// Whether this machine has it.
            pub fn is_available(self) -> bool {
                $(
                    #[cfg(all(feature = "std", target_arch = $target))]
                    if self == InstructionSet::$set {
                        return <$token>::try_new().is_some();
                    }
                )+
                matches!(self, InstructionSet::Scalar | InstructionSet::Baseline)
            }

            /// Runs a stage on this instruction set. `Scalar`, and a set that the machine does not have, run it on `Baseline`.
            #[doc(hidden)]
            #[inline]
            pub fn run<T: Stage>(self, stage: T) {
                // Kernels take most of the time of a compilation: tests that need none do without (`cargo xtask mutants`).
                if cfg!(ellgran_without_lanes) {
                    panic!("compiled without lanes");
                }
                #[cfg(not(ellgran_without_lanes))]
                self.run_in_lanes(stage)
            }

            #[cfg(not(ellgran_without_lanes))]
            #[inline]
            fn run_in_lanes<T: Stage>(self, stage: T) {
                $(
                    #[cfg(all(feature = "std", target_arch = $target))]
                    if self == InstructionSet::$set {
                        if let Some(registers) = <$token>::try_new() {
                            return registers.vectorize(InLanes {
                                registers: Twice(registers),
                                stage,
                            });
                        }
                    }
                )+
                run_on_baseline(stage)
            }
        }
    };
}
use instruction_sets;

/// Runs a stage on the set that every machine of the target has.
#[inline]
fn run_on_baseline<T: Stage>(stage: T) {
    #[cfg(all(feature = "std", target_arch = "x86_64"))]
    let registers = pulp::x86::V1::try_new().expect("SSE2 is part of x86-64");
    #[cfg(all(feature = "std", target_arch = "aarch64"))]
    let registers = pulp::aarch64::Neon::try_new().expect("NEON is part of AArch64");
    #[cfg(not(all(feature = "std", any(target_arch = "x86_64", target_arch = "aarch64"))))]
    let registers = portable::Portable;
    stage.run(Twice(registers))
}

impl InstructionSet {
    /// Pairs that are computed at a time: two registers of them, interleaved to hide latency.
    pub fn lanes(self) -> usize {
        let mut lanes = 1;
        if self != InstructionSet::Scalar {
            self.run(CountLanes(&mut lanes));
        }
        lanes
    }

    /// The widest that this machine has.
    pub fn widest() -> Self {
        *Self::ALL
            .iter()
            .rfind(|s| s.is_available())
            .unwrap_or(&InstructionSet::Baseline)
    }

    /// The choice of the environment variable, or the widest where it is not set or empty.
    ///
    /// # Errors
    /// An unknown name, or a set that this machine does not have.
    #[cfg(feature = "std")]
    pub fn choose() -> Result<Self, String> {
        Self::named_by(std::env::var_os(ENVIRONMENT_VARIABLE).as_deref())
    }

    /// The choice of a value of the environment variable; the widest where it is not set or empty.
    #[cfg(feature = "std")]
    fn named_by(value: Option<&std::ffi::OsStr>) -> Result<Self, String> {
        let Some(value) = value.filter(|v| !v.is_empty()) else {
            return Ok(Self::widest());
        };
        let wanted = Self::ALL
            .into_iter()
            .find(|s| value == s.name())
            .ok_or_else(|| {
                let names = Self::ALL.map(Self::name).join(", ");
                format!("{ENVIRONMENT_VARIABLE} = {value:?} must be one of {names}")
            })?;
        if wanted.is_available() {
            Ok(wanted)
        } else {
            Err(format!(
                "{ENVIRONMENT_VARIABLE} = {} but this machine does not have it",
                wanted.name()
            ))
        }
    }
}

#[cfg(all(test, feature = "std"))]
mod which_set {
    use super::InstructionSet;
    use std::ffi::OsStr;

    #[test]
    fn an_empty_variable_is_none() {
        let widest = InstructionSet::widest();
        assert_eq!(InstructionSet::named_by(None), Ok(widest));
        assert_eq!(InstructionSet::named_by(Some(OsStr::new(""))), Ok(widest));
        let scalar = InstructionSet::named_by(Some(OsStr::new("scalar")));
        assert_eq!(scalar, Ok(InstructionSet::Scalar));
        let wrong = InstructionSet::named_by(Some(OsStr::new("sse"))).unwrap_err();
        assert!(wrong.contains("\"sse\""), "{wrong}");
    }
}
