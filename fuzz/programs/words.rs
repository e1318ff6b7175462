// SPDX-License-Identifier: MIT OR Apache-2.0
//! What libFuzzer runs.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| ellgran_fuzz::words::run(bytes));
