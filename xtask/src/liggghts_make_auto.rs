// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does LIGGGHTS' own build, `make auto`, take the patch, do the same as the binary that we build, and give the tree back? A copy of the
//! tree is patched, built as a user would, run on a deck beside our binary, and stripped of the patch.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{ensure, Context, Result};

use crate::process::{jobs, output_of, run_logged};
use crate::progress::{say, Progress};
use crate::{library, liggghts, vtk, workspace};

pub fn whole() -> Result<()> {
    let ours = liggghts::binary()?;
    let source = liggghts::source_tree()?;
    let directory = workspace::target_directory()?.join("liggghts-make-auto");
    if directory.exists() {
        fs::remove_dir_all(&directory)?;
    }
    fs::create_dir_all(&directory)?;
    let tree = directory.join("tree");
    output_of(Command::new("cp").arg("-a").arg(&source).arg(&tree))?;

    install(&tree, "--few")?;
    let mut make = Command::new("make");
    make.arg(format!("-j{}", jobs()))
        .arg("auto")
        .arg(format!("ELLGRAN_LIBRARY={}", library::library()?.display()))
        .arg(format!(
            "ELLGRAN_INCLUDE={}",
            workspace::root().join("include").display()
        ));
    match vtk::vtk() {
        Ok(vtk) => {
            make.arg(format!("ELLGRAN_VTK_INCLUDE={}", vtk.include.display()))
                .arg(format!("ELLGRAN_VTK_LIBRARIES={}", vtk.libraries.display()));
        }
        Err(error) => say(format!("without VTK: {error:#}")),
    }
    let log = directory.join("make.log");
    let mut progress = Progress::start("make auto");
    let mut compiled = 0;
    run_logged(make.current_dir(tree.join("src")), &log, |line| {
        compiled += usize::from(line.contains(" -c ../"));
        progress.update(None, &format!("{compiled} objects"));
    })?;
    progress.finish();

    let theirs = tree.join("src/lmp_auto");
    let [a, b] = [("by make auto", &theirs), ("by us", &ours)].map(|(name, binary)| {
        collision(&directory.join(name.replace(' ', "_")), binary).context(name)
    });
    let (a, b) = (a?, b?);
    ensure!(
        a.len() == b.len() && a.len() > 1000,
        "the decks wrote different tables"
    );
    let apart = a
        .iter()
        .zip(&b)
        .map(|(a, b)| (a - b).abs() / b.abs().max(1e-3))
        .fold(0.0, f64::max);
    say(format!(
        "examples/liggghts/collision.lig with both binaries: {} numbers, apart by {apart:.1e} at most",
        a.len()
    ));
    ensure!(apart < 1e-9, "the two binaries differ");

    output_of(
        Command::new("make")
            .arg("clean-all")
            .current_dir(tree.join("src")),
    )?;
    install(&tree, "--remove")?;
    let (before, after) = (files(&source)?, files(&tree)?);
    for (name, bytes) in &before {
        ensure!(
            after.get(name) == Some(bytes),
            "{} is not as it was",
            name.display()
        );
    }
    let left: Vec<_> = after
        .keys()
        .filter(|name| !before.contains_key(*name))
        .collect();
    say(format!(
        "the patch is out: all {} files are as they were; LIGGGHTS' build left {left:?}",
        before.len()
    ));
    for name in left {
        ensure!(
            !name.to_string_lossy().contains("ellgran"),
            "{} was left behind",
            name.display()
        );
    }
    Ok(())
}

fn install(tree: &Path, word: &str) -> Result<()> {
    let installer = workspace::root().join("liggghts-patch/install");
    output_of(Command::new("sh").arg(installer).arg(tree).arg(word))?;
    Ok(())
}

/// The numbers that the deck writes.
fn collision(directory: &Path, binary: &Path) -> Result<Vec<f64>> {
    fs::create_dir_all(directory)?;
    for name in ["collision.lig", "materials.lig"] {
        let from = workspace::root().join("examples/liggghts").join(name);
        fs::copy(from, directory.join(name))?;
    }
    output_of(
        Command::new(binary)
            .args(["-in", "collision.lig"])
            .current_dir(directory),
    )?;
    Ok(fs::read_to_string(directory.join("collision.dat"))?
        .split_whitespace()
        .filter_map(|word| word.parse().ok())
        .collect())
}

/// Every file below, by its path from there.
fn files(top: &Path) -> Result<BTreeMap<PathBuf, Vec<u8>>> {
    let mut found = BTreeMap::new();
    let mut directories = vec![top.to_path_buf()];
    while let Some(directory) = directories.pop() {
        for entry in fs::read_dir(&directory)? {
            let path = entry?.path();
            if path.is_symlink() {
                continue;
            }
            if path.is_dir() {
                directories.push(path);
            } else {
                found.insert(path.strip_prefix(top)?.to_path_buf(), fs::read(&path)?);
            }
        }
    }
    Ok(found)
}
