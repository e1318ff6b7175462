// SPDX-License-Identifier: MIT OR Apache-2.0
//! What does someone see who builds the plugin for a LAMMPS that has changed what the plugin uses?

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::engines::process::from_environment;
use crate::harness::fresh_directory;

/// What the compiler says of ellgran_lammps_interface.cpp, where `first` holds headers that stand before LAMMPS' own.
fn compile(first: &Path) -> (bool, String) {
    let headers: PathBuf = from_environment(
        "ELLGRAN_TEST_LAMMPS_HEADERS",
        "these tests need LAMMPS' headers; run them with `cargo xtask test`",
    );
    let output = Command::new("mpicxx")
        .args(["-std=c++17", "-fsyntax-only", "-DLAMMPS_SMALLBIG", "-I"])
        .arg(first)
        .arg("-isystem")
        .arg(headers)
        .arg(
            Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("lammps-plugin/ellgran_lammps_interface.cpp"),
        )
        .output()
        .expect("mpicxx");
    (
        output.status.success(),
        String::from_utf8_lossy(&output.stderr).into_owned(),
    )
}

#[test]
fn both_versions_a_changed_interface_is_named() {
    let directory = fresh_directory("headers");
    let (fits, said) = compile(&directory);
    assert!(fits, "{said}");

    let headers = PathBuf::from(std::env::var_os("ELLGRAN_TEST_LAMMPS_HEADERS").unwrap());
    for (header, before, after, named) in [
        (
            "pair.h",
            "transfer_history(double *, double *, int, int)",
            "transfer_history(double *, int, int)",
            "Pair::transfer_history",
        ),
        (
            "neigh_list.h",
            "int *numneigh;",
            "long *numneigh;",
            "NeighList::numneigh",
        ),
        (
            "fix_neigh_history.h",
            "int **firstflag;",
            "int **firstflags;",
            "FixNeighHistory::firstflag",
        ),
        (
            "modify.h",
            "FixCreatorMap *fix_map;",
            "FixCreatorMap *fixes;",
            "Modify::fix_map",
        ),
    ] {
        let text = fs::read_to_string(headers.join(header)).expect(header);
        assert!(text.contains(before), "{header} has no {before}");
        let changed = directory.join(header);
        fs::write(&changed, text.replace(before, after)).unwrap();
        let (fits, said) = compile(&directory);
        fs::remove_file(&changed).unwrap();
        assert!(
            !fits && said.contains(&format!("this LAMMPS has changed {named}, ")),
            "{header}: {said}"
        );
    }
}
