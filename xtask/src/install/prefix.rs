// SPDX-License-Identifier: MIT OR Apache-2.0
//! What an install prefix holds: library, header, pkg-config and CMake files. Needs std alone: the tests of what
//! consumers see include this file, and so try the same layout.

use std::ffi::OsStr;
use std::io::{Error, Result};
use std::path::{Component, Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::{env, fs};

/// The profile of libraries that tests link: the code of a release, built in a fraction of the time.
#[allow(dead_code)] // of xtask itself: tests alone need it
pub const TEST_PROFILE: &str = "consumers";

/// What the templates of packaging/ leave open.
pub struct Package<'a> {
    pub version: &'a str,
    pub description: &'a str,
    /// As rustc prints them: `-lpthread -lm` and so on.
    pub system_libraries: &'a str,
}

/// Where the files go: libraries into `prefix`/`libdir`, the header into `prefix`/include. `libdir` is relative, as `lib64` or
/// `lib/x86_64-linux-gnu`: the prefix can be moved as a whole.
pub struct Place<'a> {
    pub prefix: &'a Path,
    pub libdir: &'a Path,
}

impl<'a> Place<'a> {
    pub fn new(prefix: &'a Path, libdir: &'a Path) -> Result<Self> {
        let plain = |part: Component| matches!(part, Component::Normal(_));
        if libdir.components().count() == 0 || !libdir.components().all(plain) {
            return Err(Error::other(format!(
                "--libdir {}: give it relative to the prefix, as lib64",
                libdir.display()
            )));
        }
        Ok(Place { prefix, libdir })
    }

    /// The usual place of a prefix of one's own.
    pub fn in_lib(prefix: &'a Path) -> Self {
        Place {
            prefix,
            libdir: Path::new("lib"),
        }
    }

    fn lib(&self) -> PathBuf {
        self.prefix.join(self.libdir)
    }

    /// The way from a directory within the one of libraries, `deeper` levels, up to the prefix: `/../..`.
    fn up(&self, deeper: usize) -> String {
        "/..".repeat(self.libdir.components().count() + deeper)
    }
}

/// The version of the binary interface, which names the shared library.
fn abi_version(header: &Path) -> Result<String> {
    let text = fs::read_to_string(header).map_err(|e| naming(header, e))?;
    text.lines()
        .find_map(|line| line.strip_prefix("#define ELLGRAN_ABI_VERSION "))
        .map(|version| version.trim().to_owned())
        .ok_or_else(|| Error::other("ellgran.h has no ELLGRAN_ABI_VERSION"))
}

/// Adds the shared library to a prefix that has the static one, of whose code it is made: `libellgran.so.N`, N the version of
/// the binary interface, `libellgran.so`, which points to it, and a pkg-config file. It shows the functions of the header
/// and nothing else. `compiler` is a C compiler that links for the GNU or LLVM linker.
pub fn add_shared(
    place: &Place,
    root: &Path,
    package: &Package,
    mut compiler: Command,
) -> Result<()> {
    let lib = place.lib();
    let name = format!(
        "libellgran.so.{}",
        abi_version(&place.prefix.join("include").join("ellgran.h"))?
    );
    let exports = root.join("packaging").join("exports.map");
    let option = |name: &str, value: &Path| {
        let mut all = std::ffi::OsString::from(name);
        all.push(value);
        all
    };
    let output = compiler
        .args(["-shared", "-fPIC", "-o"])
        .arg(lib.join(&name))
        .arg(format!("-Wl,-soname,{name}"))
        .arg(option("-Wl,--version-script=", &exports))
        .args(["-Wl,--gc-sections", "-Wl,-z,defs", "-Wl,--whole-archive"])
        .arg(lib.join("libellgran.a"))
        .arg("-Wl,--no-whole-archive")
        .args(package.system_libraries.split_whitespace())
        .stdin(Stdio::null())
        .output()?;
    if !output.status.success() {
        return Err(Error::other(format!(
            "{name} does not link:\n{}",
            String::from_utf8_lossy(&output.stderr)
        )));
    }
    let link = lib.join("libellgran.so");
    let _ = fs::remove_file(&link);
    #[cfg(unix)]
    std::os::unix::fs::symlink(&name, &link).map_err(|e| naming(&link, e))?;
    let templates = root.join("packaging");
    template(
        &templates,
        &lib.join("pkgconfig"),
        "ellgran-shared.pc",
        &[
            ("@VERSION@", package.version),
            ("@DESCRIPTION@", package.description),
            ("@LIBDIR@", &place.libdir.to_string_lossy()),
            ("@UP_TO_PREFIX@", &place.up(1)),
        ],
    )
}

/// Writes all that a consumer of the static library needs.
pub fn fill(place: &Place, root: &Path, library: &Path, package: &Package) -> Result<()> {
    let lib = place.lib();
    let cmake = lib.join("cmake").join("ellgran");
    let header = root.join("include").join("ellgran.h");
    let templates = root.join("packaging");
    copy(library, &lib, "libellgran.a")?;
    copy(&header, &place.prefix.join("include"), "ellgran.h")?;
    for (directory, name, depth) in [
        (&lib.join("pkgconfig"), "ellgran.pc", 1),
        (&cmake, "ellgran-config.cmake", 2),
        (&cmake, "ellgran-config-version.cmake", 2),
    ] {
        let list: Vec<&str> = package.system_libraries.split_whitespace().collect();
        template(
            &templates,
            directory,
            name,
            &[
                ("@VERSION@", package.version),
                ("@ABI_VERSION@", &abi_version(&header)?),
                ("@DESCRIPTION@", package.description),
                ("@LIBDIR@", &place.libdir.to_string_lossy()),
                ("@UP_TO_PREFIX@", &place.up(depth)),
                ("@SYSTEM_LIBRARIES@", package.system_libraries),
                ("@SYSTEM_LIBRARIES_LIST@", &list.join(";")),
            ],
        )?;
    }
    Ok(())
}

/// Adds the library that starts kernels on a GPU to a prefix that has the static one: `libellgran_gpu.a`, its header, which includes the
/// other, and a pkg-config file. The package for CMake of the static library finds it there.
pub fn add_gpu(place: &Place, root: &Path, library: &Path, package: &Package) -> Result<()> {
    let lib = place.lib();
    let header = root.join("include").join("ellgran_gpu.h");
    copy(library, &lib, "libellgran_gpu.a")?;
    copy(&header, &place.prefix.join("include"), "ellgran_gpu.h")?;
    template(
        &root.join("packaging"),
        &lib.join("pkgconfig"),
        "ellgran-gpu.pc",
        &[
            ("@VERSION@", package.version),
            ("@LIBDIR@", &place.libdir.to_string_lossy()),
            ("@UP_TO_PREFIX@", &place.up(1)),
            ("@SYSTEM_LIBRARIES@", package.system_libraries),
        ],
    )
}

/// Fills in a template of packaging/.
fn template(templates: &Path, directory: &Path, name: &str, values: &[(&str, &str)]) -> Result<()> {
    let template = templates.join(format!("{name}.in"));
    let mut text = fs::read_to_string(&template).map_err(|e| naming(&template, e))?;
    for (word, value) in values {
        text = text.replace(word, value);
    }
    fs::create_dir_all(directory).map_err(|e| naming(directory, e))?;
    let file = directory.join(name);
    fs::write(&file, text).map_err(|e| naming(&file, e))
}

/// The system libraries that rustc says a static link of the crate needs, each once, but for the unwinder. Leaves the library itself, built with
/// [`TEST_PROFILE`], in `target_directory`, under the name of the profile. `target` is another machine's, where it is for one.
#[allow(dead_code)] // of xtask itself: tests alone need it
pub fn system_libraries(
    root: &Path,
    target_directory: &Path,
    target: Option<&str>,
) -> Result<String> {
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    if let Some(target) = target {
        command.env("CARGO_BUILD_TARGET", target);
    }
    let output = command
        .current_dir(root)
        .args(["rustc", "--package", "ellgran", "--lib", "--profile"])
        .args([TEST_PROFILE, "--crate-type", "staticlib", "--target-dir"])
        .arg(target_directory)
        // The note is a warning's sibling: quiet cargo would hold it back, colours would hide it.
        .args(["--color", "never", "--", "--print", "native-static-libs"])
        .stdin(Stdio::null())
        .output()?;
    named_by_rustc(&output)
}

/// Those of a static library that is empty, made in `directory`. The crate and what it uses link no others than the standard library does, so that
/// these are its own too, known in a second: the tests of consumers hold what is installed to [`system_libraries`].
pub fn system_libraries_of_an_empty_library(
    root: &Path,
    directory: &Path,
    target: Option<&str>,
) -> Result<String> {
    fs::create_dir_all(directory).map_err(|e| naming(directory, e))?;
    let mut command = Command::new(env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
    if let Some(target) = target {
        command.args(["--target", target]);
    }
    let output = command
        .current_dir(root)
        .args(["--crate-name", "empty", "--crate-type", "staticlib"])
        .args(["--print", "native-static-libs", "--out-dir"])
        .arg(directory)
        .arg("-")
        .stdin(Stdio::null())
        .output()?;
    named_by_rustc(&output)
}

/// What rustc names on its way to a static library.
fn named_by_rustc(output: &Output) -> Result<String> {
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
