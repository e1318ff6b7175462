// SPDX-License-Identifier: MIT OR Apache-2.0
//! The project's pages, and a shell that runs their blocks as they are printed.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

#[path = "../pages.rs"]
mod pages;

pub use pages::*;

/// A file of the repository by its path from there.
pub fn page(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
    fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// What `sh` prints when it runs this block in a directory and every command succeeds. `cargo xtask path WORDS` answers with the path
/// that `answers` has beside the words; `mpirun` is this program.
#[cfg(unix)]
pub fn shell(directory: &Path, block: &str, answers: &[(&str, &Path)], mpirun: &Path) -> String {
    use std::os::unix::fs::PermissionsExt;
    let tools = directory.join("tools");
    let _ = fs::remove_dir_all(&tools);
    fs::create_dir_all(&tools).unwrap();
    let cases: String = answers
        .iter()
        .map(|(words, path)| format!("\"xtask path {words}\") echo '{}';;\n", path.display()))
        .collect();
    let script = |name: &str, text: String| {
        let path = tools.join(name);
        fs::write(&path, format!("#!/bin/sh\n{text}")).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    };
    script(
        "cargo",
        format!(
            "case \"$*\" in\n{cases}*) echo \"cargo $*: not expected here\" >&2; exit 1;;\nesac\n"
        ),
    );
    if mpirun.is_absolute() {
        // Not a link: MPICH's looks for its helpers beside the path by which it was called.
        script("mpirun", format!("exec '{}' \"$@\"\n", mpirun.display()));
    }
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path: Vec<PathBuf> = std::iter::once(tools)
        .chain(std::env::split_paths(&path))
        .collect();
    let output = super::process::with_several_ranks(&mut Command::new("sh"))
        .args(["-ec", block])
        .current_dir(directory)
        .env("PATH", std::env::join_paths(path).unwrap())
        .output()
        .expect("a shell");
    let text = String::from_utf8_lossy(&output.stdout).into_owned()
        + &String::from_utf8_lossy(&output.stderr);
    let last = super::process::last_lines(&text);
    assert!(output.status.success(), "{block}\n{last}");
    text
}
