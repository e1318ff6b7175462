// SPDX-License-Identifier: MIT OR Apache-2.0
//! Are restart files of older versions of the plugin read for ever, and files of newer ones refused with one clear error?
//!
//! The files are in tests/restart_files; the newest is made there with the oldest LAMMPS that is supported (a newer LAMMPS reads the
//! files of an older one), by
//!
//! ```sh
//! lmp -in write.lmp -var plugin ellgranplugin.so -var name lammps_format_N
//! ```
//!
//! `lammps_format_1` is by the plugin of commit 11dd2ff. LAMMPS' restart files are those of a byte order: these are of a
//! little-endian machine.

use std::path::Path;

use crate::engines::restart_files::{differences, directory, kept, write_changed};
use crate::harness::{execute, fresh_directory, last_lines, Engine};

/// Goes on from the restart file `name` in `from`; whether that succeeded, and the output.
fn go_on(engine: &Engine, run: &Path, from: &Path, name: &str, ranks: usize) -> (bool, String) {
    go_on_with("nve/asphere", engine, run, from, name, ranks)
}

fn go_on_with(
    integrator: &str,
    engine: &Engine,
    run: &Path,
    from: &Path,
    name: &str,
    ranks: usize,
) -> (bool, String) {
    let mut deck = String::new();
    for (variable, value) in [
        ("integrator", integrator.into()),
        ("plugin", engine.plugin.display().to_string()),
        ("directory", from.display().to_string()),
        ("name", name.into()),
    ] {
        deck += &format!("variable {variable} index {value}\n");
    }
    deck += &std::fs::read_to_string(directory().join("read.lmp")).unwrap();
    execute(engine, run, &deck, ranks)
}

#[test]
fn both_versions_restart_files_of_older_versions_are_read() {
    let engine = Engine::from_environment();
    let names = kept("lammps");
    assert_eq!(
        names,
        [
            "lammps_format_1",
            "lammps_format_2",
            "lammps_format_3",
            "lammps_format_4",
            "lammps_format_5",
            "lammps_format_6",
            "lammps_format_7",
            "lammps_format_8"
        ]
    );
    for name in names {
        for ranks in [1, 2] {
            let run = fresh_directory(&format!("{name}_{ranks}"));
            let (success, output) = go_on(&engine, &run, &directory(), &name, ranks);
            assert!(success, "{name}: {}", last_lines(&output));
            let (apart, work) = differences(&run, &name);
            println!(
                "{name} on {ranks} ranks: apart by {apart:.1e}, work of the wall by {work:.1e}"
            );
            // Contacts amplify the rounding of another order of summation, 200 steps long.
            assert!(apart < 1e-9, "{name} on {ranks} ranks: {apart:e}");
            // The work of a wall was integrated to first order by the plugins that wrote formats 1 and 2.
            let older = name.ends_with(['1', '2']);
            let most = if older { 1e-4 } else { 1e-9 };
            assert!(work < most, "{name} on {ranks} ranks: work {work:e}");
        }
    }
}

/// None of these files has values of `fix nve/ellipsoid`: it begins as a new one. What is left is the error of the velocities of the half
/// step, with which the files' dumps were computed.
#[test]
fn both_versions_older_restart_files_are_read_with_velocities_of_the_step() {
    let engine = Engine::from_environment();
    for name in kept("lammps") {
        let run = fresh_directory(&name);
        let (success, output) = go_on_with("nve/ellipsoid", &engine, &run, &directory(), &name, 1);
        assert!(success, "{name}: {}", last_lines(&output));
        let apart = differences(&run, &name).0;
        println!("{name}: apart by {apart:.1e}");
        assert!(apart > 1e-9 && apart < 2e-2, "{name}: {apart:e}");
    }
}

#[test]
fn both_versions_restart_files_of_newer_versions_are_refused() {
    let engine = Engine::from_environment();
    let pair = |version: i32| [*b"GELR", version.to_le_bytes()].concat();
    let wall = |version: f64| (-version).to_le_bytes().to_vec();
    for (what, from, to, words) in [
        (
            "pair",
            pair(2),
            pair(9),
            &["format version 9", "ellgran 0.1.0", "1 to 2", "a later one"][..],
        ),
        (
            "wall",
            wall(2.0),
            wall(9.0),
            &[
                "fix wall/gran/ellipsoid floor",
                "format version 9",
                "1 to 8",
            ],
        ),
        (
            "damaged",
            pair(2),
            [*b"GEL?", [0; 4]].concat(),
            &["byte order", "write_data"],
        ),
    ] {
        let run = fresh_directory(what);
        write_changed(&directory(), "lammps_format_2", &run, &from, &to);
        let (success, output) = go_on(&engine, &run, &run, "lammps_format_2", 2);
        assert!(!success, "{what} is read");
        let errors: Vec<&str> = output.lines().filter(|l| l.contains("ERROR")).collect();
        assert_eq!(errors.len(), 1, "{what}: {errors:?}");
        let error = errors[0].to_lowercase();
        assert!(
            words.iter().all(|w| error.contains(w)),
            "{what}: {}",
            errors[0]
        );
    }
}
