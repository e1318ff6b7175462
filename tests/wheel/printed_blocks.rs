// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do the blocks that the pages print for those who install by pip run as they are printed?

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;

use crate::deck::deck;
use crate::engines::printed::{blocks, page, shell};
use crate::stock::{fresh_directory, stock_alone, wheel};

/// Where `pip` and `lmp` are those of the environment, with a deck and the wheel beside. What is installed stays: `pip` finds it there.
#[test]
fn they_run_as_they_are_printed() {
    let stock = stock_alone();
    let programs = stock.program("lmp");
    let programs = programs.parent().expect("a directory of programs");
    let directory = fresh_directory("blocks");
    fs::write(directory.join("deck.lmp"), deck(200)).unwrap();
    fs::create_dir(directory.join("wheel-output")).unwrap();
    let file = wheel();
    let name = file.file_name().expect("a file");
    symlink(&file, directory.join("wheel-output").join(name)).unwrap();

    let (mut shells, mut scripts) = (0, 0);
    for name in ["docs/start.md", "docs/install.md", "python/README.md"] {
        let text = page(name);
        for block in blocks(&text, "sh") {
            if !block.contains("lmp -in") || block.contains("cargo xtask path") {
                continue;
            }
            // The wheel under test is that of the command.
            let block = block.replace("cargo xtask wheel\n", "");
            let block = format!("PATH={}:$PATH\n{block}", programs.display());
            let output = shell(&directory, &block, &[], Path::new("mpirun"));
            assert!(
                output.contains("Loaded 1 plugins from") && output.contains("Total wall time"),
                "{name}: {block}\n{output}"
            );
            shells += 1;
        }
        for block in blocks(&text, "python") {
            let run = stock.python(&directory, &block);
            let output = String::from_utf8_lossy(&run.stdout);
            assert!(
                run.status.success() && output.contains("Loop time of"),
                "{name}: {block}\n{output}{}",
                String::from_utf8_lossy(&run.stderr)
            );
            scripts += 1;
        }
    }
    assert_eq!((shells, scripts), (4, 1));
}
