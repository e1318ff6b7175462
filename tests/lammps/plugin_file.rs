// SPDX-License-Identifier: MIT OR Apache-2.0
//! The plugin as a file: does it refuse another LAMMPS, export one symbol, and load a second time?

use std::fs;
use std::process::Command;

use crate::harness::{execute, fresh_directory, Engine};

/// Version text of the LAMMPS under test, e.g. `4 Jul 2026`.
fn version(engine: &Engine) -> String {
    let output = Command::new(&engine.lammps)
        .arg("-h")
        .output()
        .expect("cannot run LAMMPS");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let line = text
        .lines()
        .find(|l| l.contains("Simulator - "))
        .expect("no version in the help of LAMMPS")
        .to_string();
    let version = line.rsplit(" - ").next().unwrap();
    // development and stable releases carry a suffix
    version
        .split_whitespace()
        .take(3)
        .collect::<Vec<_>>()
        .join(" ")
}

/// The same plugin with the year of its version changed stands for one that was built for another LAMMPS.
#[test]
fn both_versions_plugin_of_another_lammps_is_refused() {
    let engine = Engine::from_environment();
    let directory = fresh_directory("other");
    let here = version(&engine);
    let year = here.rsplit(' ').next().unwrap();
    let other = format!("{}{}", here.strip_suffix(year).unwrap(), "1999");
    let mut bytes = fs::read(&engine.plugin).expect("cannot read the plugin");
    let mut changed = 0;
    for k in 0..bytes.len() - here.len() {
        if &bytes[k..k + here.len()] == here.as_bytes() {
            bytes[k..k + here.len()].copy_from_slice(other.as_bytes());
            changed += 1;
        }
    }
    assert!(
        changed > 0,
        "'{here}' is not in the plugin: it does not know what it was built for"
    );
    let file = directory.join("otherplugin.so");
    fs::write(&file, bytes).unwrap();
    let deck = format!("plugin load {}\natom_style ellipsoid\nregion box block 0 1 0 1 0 1\ncreate_box 1 box\npair_style gran/ellipsoid\n", file.display());
    let (success, output) = execute(&engine, &directory, &deck, 1);
    println!(
        "{}",
        output
            .lines()
            .filter(|l| l.contains("1999"))
            .collect::<Vec<_>>()
            .join("\n")
    );
    assert!(
        !success,
        "a plugin of {other} was taken by {here}:\n{output}"
    );
    assert!(
        output.lines().any(|l| l.contains("ERROR"))
            && output.contains(&here)
            && output.contains(&other),
        "{output}"
    );
}

#[test]
fn both_versions_plugin_exports_one_symbol() {
    let engine = Engine::from_environment();
    let output = Command::new("nm")
        .args(["-D", "--defined-only"])
        .arg(&engine.plugin)
        .output()
        .expect("cannot run nm");
    let text = String::from_utf8_lossy(&output.stdout);
    let names: Vec<&str> = text
        .lines()
        .filter_map(|l| l.split_whitespace().last())
        .collect();
    println!("exported: {names:?}");
    assert_eq!(names, ["lammpsplugin_init"]);
}

#[test]
fn both_versions_plugin_loads_again_after_clear_and_unload() {
    let engine = Engine::from_environment();
    let directory = fresh_directory("again");
    let plugin = engine.plugin.display();
    let use_it = "atom_style ellipsoid\ncomm_modify vel yes\nregion box block -9 9 -9 9 -9 9\ncreate_box 1 box\n\
                  create_atoms 1 single 0 0 0\ncreate_atoms 1 single 1 1 1\nset group all shape 4 3 2\nset group all density 1000\n\
                  pair_style gran/ellipsoid\npair_coeff * * hertz 1e7 0.3 tangential tfd 0.5\nfix move all nve/asphere\nrun 2 post no\n";
    let deck = format!(
        "plugin load {plugin}\n{use_it}clear\nplugin load {plugin}\n{use_it}clear\n\
         plugin load {plugin}\nplugin unload pair gran/ellipsoid\nplugin load {plugin}\n{use_it}print 'came to the end'\n"
    );
    let (success, output) = execute(&engine, &directory, &deck, 1);
    assert!(
        success && output.lines().any(|l| l == "came to the end"),
        "{output}"
    );
}

/// Each arithmetic operation of the lanes is one instruction. Where the compiler leaves a function without the kernel's instruction set
/// as it is, its operations become calls of functions that are in the file by their names.
#[test]
fn no_arithmetic_of_the_lanes_is_a_call() {
    let engine = Engine::from_environment();
    let output = Command::new("nm")
        .arg("-C")
        .arg(&engine.plugin)
        .output()
        .expect("cannot run nm");
    let output = String::from_utf8_lossy(&output.stdout);
    let operations = ["::_mm_", "::_mm256_", "::_mm512_", "core_arch::arm"];
    let (mut of_library, mut calls) = (0, vec![]);
    for line in output.lines() {
        of_library += usize::from(line.contains("ellgran::list::"));
        if operations.iter().any(|word| line.contains(word)) {
            calls.push(line);
        }
    }
    assert!(of_library > 10, "the plugin has no names of functions");
    assert!(calls.is_empty(), "{calls:#?}");
}
