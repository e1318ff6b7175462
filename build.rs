// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which tables of reference numbers do the tests find? The published crate holds the small ones.

use std::path::Path;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(reference_pairs)");
    let table = "validation/reference/pairs_aspect_10.csv";
    if Path::new(table).is_file() {
        println!("cargo::rustc-cfg=reference_pairs");
    }
}
