// SPDX-License-Identifier: MIT OR Apache-2.0
//! What this driver is to look like.

fn number(name: &str, otherwise: usize) -> usize {
    match std::env::var(name) {
        Ok(text) => text
            .parse()
            .unwrap_or_else(|_| panic!("{name} = {text} is no number")),
        Err(_) => otherwise,
    }
}

/// `ELLGRAN_STAND_IN_DEVICES`: how many GPUs there are.
pub fn devices() -> i32 {
    number("ELLGRAN_STAND_IN_DEVICES", 1) as i32
}

/// `ELLGRAN_STAND_IN_GENERATION`: 60 for sm_60.
pub fn generation() -> i32 {
    number("ELLGRAN_STAND_IN_GENERATION", 90) as i32
}

/// `ELLGRAN_STAND_IN_VERSION`: the CUDA that the driver is of, 12040 for 12.4.
pub fn version() -> i32 {
    number("ELLGRAN_STAND_IN_VERSION", 12_040) as i32
}

/// `ELLGRAN_STAND_IN_MEMORY`: bytes of the memory of a GPU.
pub fn memory() -> usize {
    number("ELLGRAN_STAND_IN_MEMORY", 1 << 30)
}

/// `ELLGRAN_STAND_IN_INIT`: the result of `cuInit`.
pub fn init() -> u32 {
    number("ELLGRAN_STAND_IN_INIT", 0) as u32
}

/// `ELLGRAN_STAND_IN_ASSEMBLER`: the result of the assembler.
pub fn assembler() -> u32 {
    number("ELLGRAN_STAND_IN_ASSEMBLER", 0) as u32
}
