// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do the plugin's sources compile for a LAMMPS that was built otherwise than the one of the tests: without MPI, with identifiers of 64 bits?

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::engines::process::from_environment;

/// The stubs that LAMMPS has in place of MPI take what is sent as it was before MPI-3: not const.
#[test]
fn both_versions_without_mpi_and_with_long_identifiers() {
    let headers: PathBuf = from_environment(
        "ELLGRAN_TEST_LAMMPS_HEADERS",
        "these tests need LAMMPS' headers; run them with `cargo xtask test`",
    );
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let plugin = root.join("lammps-plugin");
    let list = std::fs::read_to_string(plugin.join("ellgran-sources.cmake")).unwrap();
    // Those for a GPU need KOKKOS.
    let (list, _) = list.split_once("set(ELLGRAN_DEVICE_STYLE_SOURCES").unwrap();
    let of_list = list.split_whitespace().map(|word| word.trim_matches(')'));
    let mut sources: Vec<&str> = of_list.filter(|word| word.ends_with(".cpp")).collect();
    sources.extend(["ellgran_lammps_interface.cpp", "ellgran_plugin.cpp"]);
    assert!(sources.len() > 20, "{sources:?}");
    for source in sources {
        let output = Command::new("c++")
            .args(["-std=c++17", "-fsyntax-only", "-DLAMMPS_BIGBIG", "-I"])
            .arg(root.join("include"))
            .arg("-isystem")
            .arg(&headers)
            .arg("-isystem")
            .arg(headers.join("STUBS"))
            .arg(plugin.join(source))
            .output()
            .expect("c++");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{source}:\n{said}");
    }
}
