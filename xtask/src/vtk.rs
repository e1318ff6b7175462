// SPDX-License-Identifier: MIT OR Apache-2.0
//! VTK's headers and the few of its libraries that LIGGGHTS' dumps need, out of Debian's packages, in the cache. The package of the
//! headers wants 240 others, a Java and an MPI of its own among them: nothing is installed, and no rights are needed.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{bail, Context, Result};

use crate::apt_source::Packages;
use crate::process::output_of;
use crate::progress::say;
use crate::{cache, workspace};

const HEADERS: &str = "libvtk9-dev";

/// A VTK as the build of LIGGGHTS takes it.
pub struct Vtk {
    /// `.../include/vtk-9.1`: its name ends as the names of the libraries do.
    pub include: PathBuf,
    pub libraries: PathBuf,
}

/// Fetched once; an error says why there is none here.
pub fn vtk() -> Result<Vtk> {
    let _lock = cache::lock("vtk")?;
    let home = cache::directory()?;
    let place = home.join(format!("vtk-{}", std::env::consts::ARCH));
    if !cache::stamp(&place).is_file() {
        cache::need_space(&home, 400)?;
        let scratch = tempfile::Builder::new().prefix("vtk-").tempdir_in(&home)?;
        fetch(scratch.path()).context("VTK cannot be had")?;
        if place.exists() {
            fs::remove_dir_all(&place)?;
        }
        fs::create_dir(&place)?;
        for part in ["include", "lib"] {
            fs::rename(scratch.path().join(part), place.join(part))?;
        }
        fs::write(cache::stamp(&place), "")?;
    }
    Ok(Vtk {
        include: headers(&place.join("include"))?,
        libraries: place.join("lib"),
    })
}

/// Leaves `include/vtk-9.N` and `lib` in `directory`.
fn fetch(directory: &Path) -> Result<()> {
    let packages = Packages::of_this_system()?;
    let root = directory.join("root");
    say(format!(
        "Fetching VTK: {HEADERS} and what LIGGGHTS needs of its libraries"
    ));
    let runtime = packages
        .depends(HEADERS)?
        .into_iter()
        .find(|name| name.starts_with("libvtk9."))
        .with_context(|| format!("{HEADERS} depends on no libvtk9.N"))?;
    for name in [HEADERS, &runtime] {
        packages.unpack(name, &root)?;
    }
    let found = headers(&root.join("usr/include"))?;
    let suffix = suffix(&found)?;
    let wanted = wanted_libraries(&suffix)?;
    // Of the libraries that these need, those which this system lacks; they may need others.
    let mut fetched = BTreeSet::new();
    let needed = loop {
        let mut needed = BTreeSet::new();
        let mut missing = BTreeSet::new();
        let directories = library_directories(&root)?;
        for name in &wanted {
            let file = directories
                .iter()
                .map(|directory| directory.join(name))
                .find(|path| path.is_file())
                .with_context(|| format!("{runtime} has no {name}"))?;
            let shown = output_of(
                Command::new("ldd")
                    .arg(&file)
                    .env("LD_LIBRARY_PATH", std::env::join_paths(&directories)?)
                    .env("LC_ALL", "C"),
            )?;
            // libvtkX-9.1.so leads to libvtkX-9.1.so.1, the name that programs ask for
            if let (Ok(next), Some(directory)) = (fs::read_link(&file), file.parent()) {
                needed.insert(directory.join(next));
            }
            needed.insert(file);
            for (soname, path) in dependencies(&shown) {
                match path {
                    Some(path) if path.starts_with(&root) => _ = needed.insert(path),
                    Some(_) => {}
                    None => _ = missing.insert(soname),
                }
            }
        }
        let packages_missing: Vec<String> = missing.iter().map(|name| package_of(name)).collect();
        if packages_missing.is_empty() {
            break needed;
        }
        for name in packages_missing {
            if !fetched.insert(name.clone()) {
                bail!("package {name} does not bring the library that it is named after");
            }
            packages.unpack(&name, &root)?;
        }
    };
    let libraries = directory.join("lib");
    fs::create_dir(&libraries)?;
    for file in needed {
        let name = file.file_name().context("a library without a name")?;
        // what a name leads to, under that name
        fs::copy(&file, libraries.join(name))?;
    }
    let name = found.file_name().context("headers without a name")?;
    fs::create_dir(directory.join("include"))?;
    fs::rename(&found, directory.join("include").join(name))?;
    Ok(())
}

/// File names of the libraries that the installed makefiles link.
fn wanted_libraries(suffix: &str) -> Result<Vec<String>> {
    let path = workspace::root().join("liggghts-patch/src/ellgran.cmake");
    let text = fs::read_to_string(&path)?;
    let names = library_names(&text)
        .with_context(|| format!("{} names no libraries of VTK", path.display()))?;
    Ok(names
        .iter()
        .map(|name| format!("libvtk{name}{suffix}.so"))
        .collect())
}

/// The words of `FOREACH(name ...)`.
fn library_names(cmake: &str) -> Option<Vec<String>> {
    let list = cmake.split_once("FOREACH(name ")?.1.split_once(')')?.0;
    Some(list.split_whitespace().map(str::to_string).collect())
}

/// The one directory `vtk-9.N` below.
fn headers(include: &Path) -> Result<PathBuf> {
    fs::read_dir(include)?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .find(|path| path.join("vtkVersion.h").is_file())
        .with_context(|| format!("no VTK headers in {}", include.display()))
}

/// `-9.1` of `vtk-9.1`.
fn suffix(headers: &Path) -> Result<String> {
    headers
        .file_name()
        .and_then(|name| name.to_str()?.strip_prefix("vtk"))
        .map(str::to_string)
        .with_context(|| format!("{} does not say its version", headers.display()))
}

/// Where packages put libraries: `usr/lib` and its subdirectory of the architecture.
fn library_directories(root: &Path) -> Result<Vec<PathBuf>> {
    let mut directories = Vec::new();
    for top in ["usr/lib", "lib"] {
        let Ok(entries) = fs::read_dir(root.join(top)) else {
            continue;
        };
        for entry in entries {
            let path = entry?.path();
            let name = path.to_string_lossy().into_owned();
            if path.is_dir() && name.ends_with("-linux-gnu") {
                directories.push(path);
            }
        }
        directories.push(root.join(top));
    }
    Ok(directories)
}

/// Names and places, of what `ldd` prints; no place for a library that was not found.
fn dependencies(shown: &str) -> Vec<(String, Option<PathBuf>)> {
    shown
        .lines()
        .filter_map(|line| {
            let (name, rest) = line.trim().split_once(" => ")?;
            let place = rest.split(" (").next()?.trim();
            let path = place.starts_with('/').then(|| PathBuf::from(place));
            Some((name.to_string(), path))
        })
        .collect()
}

/// Debian's name for the package of a shared library: `libtbb.so.12` is in `libtbb12`, `liblz4.so.1` in `liblz4-1`.
fn package_of(soname: &str) -> String {
    let (name, version) = soname.split_once(".so.").unwrap_or((soname, ""));
    let hyphen = if name.ends_with(|c: char| c.is_ascii_digit()) {
        "-"
    } else {
        ""
    };
    format!("{name}{hyphen}{version}").to_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packages_are_named_after_their_libraries() {
        assert_eq!(package_of("libtbb.so.12"), "libtbb12");
        assert_eq!(package_of("liblz4.so.1"), "liblz4-1");
        assert_eq!(
            package_of("libdouble-conversion.so.3"),
            "libdouble-conversion3"
        );
    }

    #[test]
    fn found_and_missing_libraries_are_told_apart() {
        let shown = "\tlinux-vdso.so.1 (0x00007ffe)\n\
                     \tlibtbb.so.12 => not found\n\
                     \tlibz.so.1 => /lib/x86_64-linux-gnu/libz.so.1 (0x00007f1)\n\
                     \t/lib64/ld-linux-x86-64.so.2 (0x00007f2)\n";
        assert_eq!(
            dependencies(shown),
            [
                ("libtbb.so.12".to_string(), None),
                (
                    "libz.so.1".to_string(),
                    Some(PathBuf::from("/lib/x86_64-linux-gnu/libz.so.1"))
                ),
            ]
        );
    }

    /// The two makefiles that the installer adds link the same libraries.
    #[test]
    fn both_builds_link_the_same_libraries() {
        let of = |file: &str| {
            fs::read_to_string(workspace::root().join("liggghts-patch/src").join(file)).unwrap()
        };
        let cmake = library_names(&of("ellgran.cmake")).unwrap();
        assert!(cmake.contains(&"IOParallelXML".to_string()));
        let make = of("ellgran.make");
        let list = make.split_once("$(foreach name,").unwrap().1;
        let list = list.split_once(",-lvtk").unwrap().0.replace('\\', " ");
        assert_eq!(cmake, list.split_whitespace().collect::<Vec<_>>());
    }
}
