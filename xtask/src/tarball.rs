// SPDX-License-Identifier: MIT OR Apache-2.0
//! A source tarball as a directory: unpacked without what no build reads, whole or not at all.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{bail, Context, Result};

use crate::process::output_of;
use crate::progress::Progress;

/// Unpacks into `target`, which must not exist; `left_out` are top-level directories of the source tree.
/// `target` appears with its last file in it, so a run that is cut short leaves none.
pub fn unpack(tarball: &Path, target: &Path, left_out: &[&str]) -> Result<()> {
    let parent = target
        .parent()
        .context("a source tree needs a parent directory")?;
    fs::create_dir_all(parent)?;
    let scratch = tempfile::Builder::new()
        .prefix("unpack-")
        .tempdir_in(parent)?;
    let progress = Progress::start(format!("Unpacking {}", file_name(tarball)));
    let mut command = Command::new("tar");
    command
        .arg("--extract")
        .arg("--no-same-owner")
        .arg("--directory")
        .arg(scratch.path())
        .args(["--anchored", "--no-wildcards-match-slash"]);
    for name in left_out {
        // With and without a top directory, which has a version in its name: LAMMPS' tarballs come in both shapes.
        for top in ["", "./", "*-*/", "./*-*/"] {
            command.arg(format!("--exclude={top}{name}/*"));
        }
    }
    command.arg("--file").arg(tarball);
    output_of(&mut command)?;
    let tree = top(scratch.path())?;
    fs::rename(&tree, target)
        .with_context(|| format!("cannot move {} to {}", tree.display(), target.display()))?;
    progress.finish();
    Ok(())
}

/// The directory that holds `src`: the unpacked one itself or its only subdirectory.
fn top(unpacked: &Path) -> Result<PathBuf> {
    let mut candidates = vec![unpacked.to_path_buf()];
    for entry in fs::read_dir(unpacked)? {
        candidates.push(entry?.path());
    }
    match candidates.iter().find(|path| path.join("src").is_dir()) {
        Some(path) => Ok(path.clone()),
        None => bail!("the tarball holds no directory src"),
    }
}

fn file_name(path: &Path) -> String {
    path.file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn packed(prefix: &str) -> (tempfile::TempDir, PathBuf) {
        let directory = tempfile::tempdir().unwrap();
        let tree = directory.path().join("in").join(prefix);
        for file in ["src/atom.cpp", "src/doc/kept.h", "doc/manual.txt"] {
            let file = tree.join(file);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(file, "x").unwrap();
        }
        let tarball = directory.path().join("source.tar");
        let names: &[&str] = if prefix.is_empty() {
            &["src", "doc"]
        } else {
            &["."]
        };
        output_of(
            Command::new("tar")
                .arg("-cf")
                .arg(&tarball)
                .arg("-C")
                .arg(directory.path().join("in"))
                .args(names),
        )
        .unwrap();
        (directory, tarball)
    }

    #[test]
    fn both_shapes_of_tarball_give_the_same_tree() {
        for prefix in ["", "engine-1.0"] {
            let (directory, tarball) = packed(prefix);
            let target = directory.path().join("out").join("source");
            unpack(&tarball, &target, &["doc"]).unwrap();
            assert!(target.join("src/atom.cpp").is_file(), "{prefix:?}");
            assert!(target.join("src/doc/kept.h").is_file(), "{prefix:?}");
            assert!(!target.join("doc/manual.txt").exists(), "{prefix:?}");
            // A scratch directory that stays would fill the cache.
            assert_eq!(
                fs::read_dir(directory.path().join("out")).unwrap().count(),
                1
            );
        }
    }
}
