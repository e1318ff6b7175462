// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does LIGGGHTS' own `make auto` take the patch? Its makefile runs here as `make auto` runs it, as far as objects that need what the
//! patch adds; `cargo xtask liggghts-make-auto` builds the whole.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::engines::process::from_environment;
use crate::harness::fresh_directory;
use crate::vtk;

const REPOSITORY: &str = env!("CARGO_MANIFEST_DIR");

/// The untouched tree, copied and patched, with the lists that `make auto` begins with, and its directory of objects.
fn patched() -> PathBuf {
    let source = from_environment(
        "ELLGRAN_TEST_LIGGGHTS_SOURCE",
        "a source tree of LIGGGHTS, which is copied; `cargo xtask path liggghts-source` prints one",
    );
    let tree = fresh_directory("tree");
    let succeeds = |command: &mut Command| {
        let output = command.output().unwrap();
        assert!(output.status.success(), "{command:?}: {output:?}");
    };
    succeeds(
        Command::new("cp")
            .arg("-R")
            .arg(source.join("src"))
            .arg(&tree),
    );
    succeeds(
        Command::new("sh")
            .arg(Path::new(REPOSITORY).join("liggghts-patch/install"))
            .arg(&tree)
            .arg("--few"),
    );
    let src = tree.join("src");
    for what in ["style", "models"] {
        succeeds(
            Command::new("bash")
                .args(["Make.sh", what])
                .current_dir(&src),
        );
    }
    fs::create_dir(src.join("Obj_auto")).unwrap();
    for name in ["Makefile.package", "Makefile.package.settings"] {
        fs::copy(
            src.join(format!("{name}.empty")),
            src.join("Obj_auto").join(name),
        )
        .unwrap();
    }
    src
}

/// Whether the objects came about, and what was said.
fn make(src: &Path, objects: &str, words: &[String]) -> (bool, String) {
    let _ = fs::remove_file(src.join("MAKE/Makefile.auto.options"));
    let output = Command::new("make")
        .args(["-f", "../MAKE/Makefile.auto", "EXE=../lmp_auto", "SHFLAGS="])
        .arg(format!("OBJ={objects}"))
        .args(words)
        .args(objects.split(' '))
        .current_dir(src.join("Obj_auto"))
        .env_remove("MAKEFLAGS")
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned()
        + &String::from_utf8_lossy(&output.stderr);
    (output.status.success(), text)
}

#[test]
fn objects_of_the_patch() {
    let src = patched();
    // its tests link the library: an empty one will do
    let library = src.join("libempty.a");
    fs::write(&library, "!<arch>\n").unwrap();
    let given = [
        format!("ELLGRAN_LIBRARY={}", library.display()),
        format!("ELLGRAN_INCLUDE={REPOSITORY}/include"),
    ];
    let nowhere = "ELLGRAN_VTK_INCLUDE=/nowhere".to_string();

    let (done, said) = make(&src, "ellgran_commands.o", &given[1..]);
    assert!(!done && said.contains("ELLGRAN_LIBRARY=''"), "{said}");
    let (done, said) = make(&src, "ellgran_commands.o", &given[..1]);
    assert!(!done && said.contains("ELLGRAN_INCLUDE=''"), "{said}");

    // a fresh tree, as it comes: Makefile.user is written and wants VTK, which is not there
    let mut words = given.to_vec();
    words.push(nowhere);
    let (done, said) = make(&src, "ellgran_commands.o", &words);
    assert!(done, "{said}");
    if !Path::new("/usr/include").read_dir().unwrap().any(|entry| {
        entry
            .unwrap()
            .file_name()
            .to_string_lossy()
            .starts_with("vtk")
    }) {
        assert!(said.contains("built without its VTK dumps"), "{said}");
        assert!(!said.contains("LAMMPS_VTK"), "{said}");
    }
    assert!(said.contains("SUPERQUADRIC_ACTIVE_FLAG"), "{said}");

    let Some(include) = vtk::headers() else {
        return;
    };
    let mut words = given.to_vec();
    words.push(format!("ELLGRAN_VTK_INCLUDE={}", include.display()));
    let (done, said) = make(&src, "dump_vtk.o", &words);
    assert!(done && said.contains("-DLAMMPS_VTK"), "{said}");
}
