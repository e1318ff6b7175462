// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which instruction set the neighbour-list path runs on: chosen when a workspace is made, never in a step.

use super::registers::Registers;
use super::twice::Twice;

/// A piece of work that is compiled for each instruction set.
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
#[cfg(target_arch = "x86_64")]
struct InLanes<S, T> {
    registers: S,
    stage: T,
}

#[cfg(target_arch = "x86_64")]
impl<S: Registers, T: Stage> pulp::NullaryFnOnce for InLanes<S, T> {
    type Output = ();
    #[inline(always)]
    fn call(self) {
        self.stage.run(self.registers)
    }
}

/// An instruction set for the lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InstructionSet {
    /// One number at a time; any machine.
    Scalar,
    /// Registers of two numbers, which every machine has (SSE2 on x86-64, NEON on AArch64).
    Baseline,
    /// Registers of four numbers, with fused multiply-add (x86-64-v3).
    Avx2,
    /// Registers of eight numbers (x86-64-v4).
    Avx512,
}

/// The environment variable that forces a choice: `scalar`, `baseline`, `avx2` or `avx512`.
pub const ENVIRONMENT_VARIABLE: &str = "ELLGRAN_INSTRUCTION_SET";

impl InstructionSet {
    /// All of them, widest last.
    pub const ALL: [InstructionSet; 4] = [
        InstructionSet::Scalar,
        InstructionSet::Baseline,
        InstructionSet::Avx2,
        InstructionSet::Avx512,
    ];

    /// Its name, as the environment variable takes it.
    pub fn name(self) -> &'static str {
        match self {
            InstructionSet::Scalar => "scalar",
            InstructionSet::Baseline => "baseline",
            InstructionSet::Avx2 => "avx2",
            InstructionSet::Avx512 => "avx512",
        }
    }

    /// Runs a stage on this instruction set. `Scalar`, and a set that the machine does not have, run it on `Baseline`.
    #[doc(hidden)]
    #[inline]
    pub fn run<T: Stage>(self, stage: T) {
        #[cfg(target_arch = "x86_64")]
        {
            use pulp::x86::{V1, V3, V4};
            if self == InstructionSet::Avx512 {
                if let Some(registers) = V4::try_new() {
                    return registers.vectorize(InLanes {
                        registers: Twice(registers),
                        stage,
                    });
                }
            }
            if self == InstructionSet::Avx2 {
                if let Some(registers) = V3::try_new() {
                    return registers.vectorize(InLanes {
                        registers: Twice(registers),
                        stage,
                    });
                }
            }
            // Every machine of this target has it.
            let registers = V1::try_new().expect("SSE2 is part of x86-64");
            stage.run(Twice(registers))
        }
        #[cfg(target_arch = "aarch64")]
        {
            let registers = pulp::aarch64::Neon::try_new().expect("NEON is part of AArch64");
            stage.run(Twice(registers))
        }
        #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
        stage.run(Twice(super::portable::Portable))
    }

    /// Pairs that are computed at a time: two registers of them, interleaved to hide latency.
    pub fn lanes(self) -> usize {
        let mut lanes = 1;
        if self != InstructionSet::Scalar {
            self.run(CountLanes(&mut lanes));
        }
        lanes
    }

    /// Whether this machine has it.
    pub fn is_available(self) -> bool {
        match self {
            InstructionSet::Scalar | InstructionSet::Baseline => true,
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => pulp::x86::V3::try_new().is_some(),
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => pulp::x86::V4::try_new().is_some(),
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
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
    pub fn choose() -> Result<Self, String> {
        Self::named_by(std::env::var_os(ENVIRONMENT_VARIABLE).as_deref())
    }

    /// The choice of a value of the environment variable; the widest where it is not set or empty.
    fn named_by(value: Option<&std::ffi::OsStr>) -> Result<Self, String> {
        let Some(value) = value.filter(|v| !v.is_empty()) else {
            return Ok(Self::widest());
        };
        let wanted = Self::ALL
            .into_iter()
            .find(|s| value == s.name())
            .ok_or_else(|| {
                format!(
                    "{ENVIRONMENT_VARIABLE} = {value:?} must be scalar, baseline, avx2 or avx512"
                )
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

#[cfg(test)]
mod tests {
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
