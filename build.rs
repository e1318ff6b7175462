// SPDX-License-Identifier: MIT OR Apache-2.0
// Without this a change of any file, a test or a page, would build the library anew.
fn main() {
    println!("cargo::rerun-if-changed=build.rs");
}
