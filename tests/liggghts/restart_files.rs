// SPDX-License-Identifier: MIT OR Apache-2.0
//! Are restart files that older versions of the contact models wrote read for ever, and files of newer ones refused with one
//! clear error?
//!
//! The files are in tests/restart_files: with a plane for a floor, and with a mesh. Those of a new version are made there, before it
//! becomes an older one, by the commands that `write.lig` begins with.
//!
//! Those of format 1 are by the contact models of commit 11dd2ff. LIGGGHTS' restart files are those of a byte order: these are of
//! a little-endian machine.

use std::path::Path;

use crate::engines::restart_files::{differences, directory, kept, write_changed};
use crate::harness::{execute, fresh_directory, last_lines, Engine};

/// Runs one of the two decks in `run`, for the restart file `name`, which `read.lig` takes from `from`; whether that succeeded, and
/// the output.
fn deck(
    engine: &Engine,
    deck: &str,
    run: &Path,
    from: &Path,
    name: &str,
    ranks: usize,
) -> (bool, String) {
    let floor = if name.starts_with("liggghts_mesh") {
        "mesh n_meshes 1 meshes sheet"
    } else {
        "primitive type 1 zplane 0.0"
    };
    std::fs::copy(directory().join("sheet.stl"), run.join("sheet.stl")).unwrap();
    let mut text = format!(
        "variable directory index {}\nvariable name index {name}\nvariable floor index \"{floor}\"\n",
        from.display()
    );
    text += &std::fs::read_to_string(directory().join(deck)).unwrap();
    execute(engine, run, &text, ranks)
}

#[test]
fn restart_files_of_older_versions_are_read() {
    let engine = Engine::from_environment();
    let names = kept("liggghts");
    for version in 1..=3 {
        for floor in ["", "mesh_"] {
            let name = format!("liggghts_{floor}format_{version}");
            assert!(names.contains(&name), "no {name}");
        }
    }
    for name in names {
        for ranks in [1, 2] {
            let run = fresh_directory(&format!("{name}_{ranks}"));
            let (success, output) = deck(&engine, "read.lig", &run, &directory(), &name, ranks);
            assert!(success, "{name}: {}", last_lines(&output));
            let (apart, _) = differences(&run, &name);
            println!("{name} on {ranks} ranks: apart by {apart:.1e}");
            // Contacts amplify the rounding of another order of summation, 200 steps long.
            assert!(apart < 1e-9, "{name} on {ranks} ranks: {apart:e}");
        }
    }
}

#[test]
fn restart_files_of_newer_versions_are_refused() {
    let engine = Engine::from_environment();
    let run = fresh_directory("newer");
    let (success, output) = deck(&engine, "write.lig", &run, &run, "today", 1);
    assert!(success, "{}", last_lines(&output));
    let state = |version: i32| [&version.to_le_bytes()[..], &b"0.1.0"[..]].concat();
    write_changed(&run, "today", &run, &state(3), &state(9));
    let (success, output) = deck(&engine, "read.lig", &run, &run, "today", 2);
    assert!(!success, "a newer file is read");
    let errors: Vec<&str> = output.lines().filter(|l| l.contains("ERROR")).collect();
    assert_eq!(errors.len(), 1, "{errors:?}");
    for word in ["format version 9", "ellgran 0.1.0", "1 to 3", "a later one"] {
        assert!(errors[0].contains(word), "{}", errors[0]);
    }
}
