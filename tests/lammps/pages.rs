// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do the commands run that the pages print, and do they give the numbers beside them?

use std::fs;
use std::path::Path;

use crate::engines::dump::tables;
use crate::engines::printed::{blocks, page, shell};
use crate::harness::{execute, fresh_directory, last_lines, Engine};

/// Three grains of two types one above the other, in contact, within the walls that the page builds.
const GRAINS: &str = "
units si
atom_style ellipsoid
boundary f f f
comm_modify vel yes
neighbor 0.001 bin
region box block -0.2 0.2 -0.2 0.2 -0.2 0.2
create_box 2 box
create_atoms 1 single 0 0 0.05
create_atoms 2 single 0 0 0.0695
create_atoms 1 single 0 0 0.089
set group all shape 0.019 0.019 0.0198
set group all density 2500
fix integrate all nve/asphere
timestep 1e-6
";
/// For the wall that reads a file: one triangle, far from the grains.
const TRIANGLE: &str = "solid paddle
facet normal 0 0 1
outer loop
vertex 100 0 0
vertex 120 0 0
vertex 100 20 0
endloop
endfacet
endsolid paddle
";
const LAW: &str = "
pair_style gran/ellipsoid
pair_coeff * * nfd 1e7 0.3 400 400 tangential tfd 0.5
";

/// The blocks of a section one after the other, then some steps; a law of the pairs stands before them if they have none.
#[test]
fn both_versions_the_blocks_of_the_reference_page_run() {
    let engine = Engine::from_environment();
    let page = page("lammps-plugin/README.md");
    let plugin = engine.plugin.to_str().expect("a path in UTF-8");
    let mut ran = 0;
    for (number, section) in page.split("\n## ").enumerate() {
        let blocks = blocks(section, "lammps");
        if blocks.is_empty() {
            continue;
        }
        let commands = blocks
            .join("\n")
            .replace("build-plugin/ellgranplugin.so", plugin);
        let deck = if commands.contains("plugin load") {
            format!("{commands}\n{GRAINS}{LAW}")
        } else if commands.contains("pair_style") {
            format!("plugin load {plugin}\n{GRAINS}\n{commands}\n")
        } else {
            format!("plugin load {plugin}\n{GRAINS}{LAW}\n{commands}\n")
        };
        let directory = fresh_directory(&format!("section_{number}"));
        fs::write(directory.join("paddle.stl"), TRIANGLE).unwrap();
        let (success, output) = execute(&engine, &directory, &(deck + "run 5\n"), 1);
        assert!(success, "{commands}\n{}", last_lines(&output));
        ran += blocks.len();
    }
    assert!(ran >= 6, "{ran} blocks");
}

/// The rows of the table, by the deck that the page shows.
#[test]
fn both_versions_the_restitution_of_the_tutorial() {
    let engine = Engine::from_environment();
    let page = page("docs/tutorials/calibrate.md");
    let rows: Vec<(&str, Vec<f64>)> = page
        .lines()
        .filter_map(|line| {
            let (law, values) = line.strip_prefix("| `")?.split_once("` |")?;
            let values = values.split('|').map(str::trim).filter(|w| !w.is_empty());
            Some((law, values.map(|w| w.parse().expect("a number")).collect()))
        })
        .collect();
    assert!(rows.len() >= 4, "{rows:?}");
    let deck = crate::engines::printed::page("examples/lammps/restitution.lmp");
    for (number, (law, expected)) in rows.iter().enumerate() {
        let deck = format!(
            "variable plugin index {}\nvariable law index \"{law}\"\n{deck}",
            engine.plugin.display()
        );
        let directory = fresh_directory(&format!("restitution_{number}"));
        let (success, output) = execute(&engine, &directory, &deck, 1);
        assert!(success, "{law}\n{}", last_lines(&output));
        let line = output
            .lines()
            .find_map(|line| line.strip_prefix("restitution at 0.1, 0.3, 1, 3 m/s: "))
            .unwrap_or_else(|| panic!("{law}: no line of restitution"));
        let found: Vec<f64> = line
            .split_whitespace()
            .map(|word| word.parse().expect("a number"))
            .collect();
        println!("{law}: {found:?}");
        assert_eq!(found.len(), expected.len());
        for (a, b) in found.iter().zip(expected) {
            // one unit of the last digit that is printed
            assert!((a - b).abs() < 1.5e-4, "{law}: {found:?}, {expected:?}");
        }
        assert!(!output.contains("WARNING"), "{law}");
    }
}

/// The law that the page gives to those who have one coefficient alone is one that the table holds to it.
#[test]
fn the_one_coefficient_of_the_tutorial() {
    let page = page("docs/tutorials/calibrate.md");
    let blocks = blocks(&page, "text");
    assert_eq!(blocks.len(), 1);
    let law = blocks[0]
        .strip_prefix("pair_coeff 1 1 ")
        .expect("a law")
        .trim_end();
    assert!(page.contains(&format!("| `{law}` |")), "{law}");
}

/// The line that the tutorial adds to the deck of the README.
#[test]
fn both_versions_the_columns_of_the_tutorial() {
    let engine = Engine::from_environment();
    let deck = &blocks(&page("README.md"), "lammps")[0];
    let names = &blocks(&page("docs/tutorials/spheres_to_ellipsoids.md"), "lammps")[0];
    let (before, after) = deck.split_once("timestep").expect("timestep");
    let after = after.replace("run 20000", "run 5");
    let plugin = engine.plugin.display();
    let deck = format!("variable plugin index {plugin}\n{before}{names}timestep{after}");
    let directory = fresh_directory("columns");
    let (success, output) = execute(&engine, &directory, &deck, 1);
    assert!(success, "{}", last_lines(&output));
    let dump = fs::read_to_string(directory.join("grains.dump")).unwrap();
    let columns = tables(&dump).expect("a dump").remove(0).columns;
    assert_eq!(
        columns[5..],
        ["quatw", "quati", "quatj", "quatk", "shapex", "shapey", "shapez"]
    );
}

/// Shell blocks that run a deck from source. `cargo xtask path` answers what this test was given.
#[test]
#[cfg(unix)]
fn both_versions_the_shell_blocks_run() {
    let engine = Engine::from_environment();
    let directory = fresh_directory("shell");
    let examples = directory.join("examples/lammps");
    fs::create_dir_all(&examples).unwrap();
    let collision = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/lammps/collision.lmp");
    // The second is a deck of one's own.
    for copy in [examples.join("collision.lmp"), directory.join("deck.lmp")] {
        fs::copy(&collision, copy).unwrap();
    }
    let answers = [
        ("lammps", engine.lammps.as_path()),
        ("lammps-plugin", engine.plugin.as_path()),
    ];
    let mut ran = 0;
    for name in ["docs/start.md", "examples/lammps/README.md"] {
        for block in blocks(&page(name), "sh") {
            if block.contains("-in ") && !block.contains("pip install") {
                let output = shell(&directory, &block, &answers, &engine.mpirun);
                // Both run the same deck, whose line of the log another page shows.
                for log in blocks(&page("lammps-plugin/README.md"), "text") {
                    let line = log.trim_end();
                    if line.starts_with("time step ") {
                        assert!(output.contains(line), "{line}\n{}", last_lines(&output));
                        ran += 1;
                    }
                }
            }
        }
    }
    assert_eq!(ran, 2);
}

/// The commands with which one builds by hand, up to where the compiler would be at work for minutes: what is built into LAMMPS has all
/// styles.
#[test]
#[cfg(unix)]
fn the_configuring_commands_run() {
    use std::os::unix::fs::symlink;
    let engine = Engine::from_environment();
    let headers = std::env::var_os("ELLGRAN_TEST_LAMMPS_HEADERS")
        .expect("run these tests with `cargo xtask test`");
    let lammps = Path::new(&headers).parent().expect("the top of LAMMPS");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let directory = fresh_directory("configured");
    for name in ["lammps-plugin", "include"] {
        symlink(root.join(name), directory.join(name)).unwrap();
    }
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    symlink(target, directory.join("target")).unwrap();
    let mut ran = 0;
    for block in blocks(&page("lammps-plugin/README.md"), "sh") {
        for command in block.replace("\\\n", " ").lines() {
            if command.starts_with("cmake -S") {
                let command = format!("LAMMPS={}\n{command}", lammps.display());
                shell(&directory, &command, &[], &engine.mpirun);
                ran += 1;
            }
        }
    }
    assert_eq!(ran, 2);
    assert!(directory.join("build-plugin/CMakeCache.txt").is_file());
    for (list, headers) in [
        ("pair", vec!["pair_gran_ellipsoid.h"]),
        (
            "fix",
            vec![
                "fix_wall_gran_ellipsoid.h",
                "fix_nve_ellipsoid.h",
                "fix_pour_ellipsoid.h",
                "fix_nve_asphere.h",
            ],
        ),
        (
            "compute",
            vec![
                "compute_contact_ellipsoid_atom.h",
                "compute_energy_ellipsoid.h",
            ],
        ),
        ("command", vec!["create_ellipsoids.h"]),
    ] {
        let file = directory.join(format!("build-lammps/styles/style_{list}.h"));
        let text = fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        for header in headers {
            assert!(text.contains(header), "{} lacks {header}", file.display());
        }
    }
}
