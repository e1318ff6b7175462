// SPDX-License-Identifier: MIT OR Apache-2.0
//! What an install prefix holds: library, header, pkg-config and CMake files. Needs std alone: the tests of what
//! consumers see include this file, and so try the same layout.

use std::ffi::OsStr;
use std::io::{Error, Result};
use std::path::Path;
use std::process::{Command, Stdio};
use std::{env, fs};

/// The profile of libraries that tests link: the code of a release, built in a fraction of the time.
pub const TEST_PROFILE: &str = "consumers";

/// What the templates of packaging/ leave open.
pub struct Package<'a> {
    pub version: &'a str,
    pub description: &'a str,
    /// As rustc prints them: `-lpthread -lm` and so on.
    pub system_libraries: &'a str,
}

/// Writes into `prefix` all that a consumer of the static library needs.
pub fn fill(prefix: &Path, root: &Path, library: &Path, package: &Package) -> Result<()> {
    let lib = prefix.join("lib");
    let cmake = lib.join("cmake").join("ellgran");
    let header = root.join("include").join("ellgran.h");
    let templates = root.join("packaging");
    copy(library, &lib, "libellgran.a")?;
    copy(&header, &prefix.join("include"), "ellgran.h")?;
    for (directory, name) in [
        (&lib.join("pkgconfig"), "ellgran.pc"),
        (&cmake, "ellgran-config.cmake"),
        (&cmake, "ellgran-config-version.cmake"),
    ] {
        let template = templates.join(format!("{name}.in"));
        let text = fs::read_to_string(&template).map_err(|e| naming(&template, e))?;
        let list: Vec<&str> = package.system_libraries.split_whitespace().collect();
        let filled = text
            .replace("@VERSION@", package.version)
            .replace("@DESCRIPTION@", package.description)
            .replace("@SYSTEM_LIBRARIES@", package.system_libraries)
            .replace("@SYSTEM_LIBRARIES_LIST@", &list.join(";"));
        fs::create_dir_all(directory).map_err(|e| naming(directory, e))?;
        let file = directory.join(name);
        fs::write(&file, filled).map_err(|e| naming(&file, e))?;
    }
    Ok(())
}

/// The system libraries that rustc says a static link of the crate needs, each once, but for the unwinder. Leaves the library itself, built with
/// [`TEST_PROFILE`], in `target_directory`, under the name of the profile.
pub fn system_libraries(root: &Path, target_directory: &Path) -> Result<String> {
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .current_dir(root)
        .args(["rustc", "--package", "ellgran", "--lib", "--profile"])
        .args([TEST_PROFILE, "--crate-type", "staticlib", "--target-dir"])
        .arg(target_directory)
        // The note is a warning's sibling: quiet cargo would hold it back, colours would hide it.
        .args(["--color", "never", "--", "--print", "native-static-libs"])
        .stdin(Stdio::null())
        .output()?;
    let text = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        return Err(Error::other(format!("the library does not build:\n{text}")));
    }
    text.lines()
        .find_map(|line| line.split_once("native-static-libs:"))
        .map(|(_, list)| each_once(list))
        .ok_or_else(|| Error::other(format!("rustc names no system libraries:\n{text}")))
}

/// The last place of each is kept: a library must follow those that need it. The unwinder of GCC is left out: it has one
/// name in a static link and another in a shared one, and every C compiler's driver adds the right one itself.
fn each_once(list: &str) -> String {
    let words: Vec<&str> = list
        .split_whitespace()
        .filter(|word| *word != "-lgcc_s")
        .collect();
    let last = |k: &usize| !words[k + 1..].contains(&words[*k]);
    let kept: Vec<&str> = (0..words.len()).filter(last).map(|k| words[k]).collect();
    kept.join(" ")
}

fn copy(from: &Path, directory: &Path, name: impl AsRef<OsStr>) -> Result<()> {
    fs::create_dir_all(directory).map_err(|e| naming(directory, e))?;
    fs::copy(from, directory.join(name.as_ref())).map_err(|e| naming(from, e))?;
    Ok(())
}

fn naming(path: &Path, error: Error) -> Error {
    Error::new(error.kind(), format!("{}: {error}", path.display()))
}
