// SPDX-License-Identifier: MIT OR Apache-2.0
//! The LAMMPS plugin, built against one LAMMPS.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{bail, Context, Result};

use crate::lammps::Source;
use crate::library::library;
use crate::process::{ninja, run_logged};
use crate::revisions::Revision;
use crate::{cache, setup, workspace};

/// Needs the engine's headers only, not its binary.
pub fn plugin(lammps: &Source) -> Result<PathBuf> {
    let title = format!("Building the plugin for LAMMPS {}", lammps.spelled()?);
    setup::setup()?;
    for_headers(&lammps.src(), &lammps.name, &title, &library()?, &[])
}

/// For the LAMMPS that these headers describe; `name` is the key of what is built. `definitions` for CMake name compilers and MPI,
/// where they are not those on the path.
pub fn for_headers(
    headers: &Path,
    name: &str,
    title: &str,
    library: &Path,
    definitions: &[(&str, PathBuf)],
) -> Result<PathBuf> {
    let build = workspace::target_directory()?
        .join("lammps-plugin")
        .join(name);
    let sources = workspace::root();
    let from = From {
        sources: &sources,
        library,
        headers,
    };
    built(&from, &build, name, title, definitions)
}

/// The same of another revision, beside its library in the cache.
pub fn of_revision(lammps: &Source, revision: &Revision) -> Result<PathBuf> {
    let headers = lammps.src();
    let from = From {
        sources: &revision.sources,
        library: &revision.library,
        headers: &headers,
    };
    let build = revision.sources.join("plugin").join(&lammps.name);
    let title = format!("Building the plugin of {}", revision.name);
    built(&from, &build, &lammps.name, &title, &[])
}

/// What a plugin is built from: the directory of `lammps-plugin` and `include`, the core, and the engine's headers.
struct From<'a> {
    sources: &'a Path,
    library: &'a Path,
    headers: &'a Path,
}

fn built(
    from: &From,
    build: &Path,
    name: &str,
    title: &str,
    definitions: &[(&str, PathBuf)],
) -> Result<PathBuf> {
    let source = from.sources.join("lammps-plugin");
    let _lock = cache::lock(&format!("lammps-plugin-{name}"))?;
    forget_other_sources(build, &source)?;
    std::fs::create_dir_all(build)?;
    let mut configure = Command::new("cmake");
    configure
        .arg("-S")
        .arg(&source)
        .arg("-B")
        .arg(build)
        .args(["-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release"])
        .arg(define("LAMMPS_SOURCE_DIR", from.headers))
        .arg(define("ELLGRAN_LIBRARY", from.library))
        .arg(define("ELLGRAN_INCLUDE_DIR", &from.sources.join("include")));
    for (name, value) in definitions {
        configure.arg(define(name, value));
    }
    run_logged(&mut configure, &build.join("configure.log"), |_| {})
        .context("the plugin cannot be configured")?;
    ninja(build, &[], title).context("the plugin cannot be built")?;
    let plugin = build.join("ellgranplugin.so");
    if !plugin.is_file() {
        bail!("the build left no {}", plugin.display());
    }
    Ok(plugin)
}

/// Removes what CMake has configured for sources in another place, a checkout that has been moved or one for a single use: it refuses
/// to go on from that.
pub fn forget_other_sources(build: &Path, source: &Path) -> Result<()> {
    let Ok(cache) = fs::read_to_string(build.join("CMakeCache.txt")) else {
        return Ok(());
    };
    let home = cache
        .lines()
        .find_map(|line| line.strip_prefix("CMAKE_HOME_DIRECTORY:INTERNAL="));
    if home.is_some_and(|home| Path::new(home) != source) {
        fs::remove_dir_all(build)?;
    }
    Ok(())
}

pub fn define(name: &str, path: &Path) -> String {
    format!("-D{name}={}", path.display())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A checkout that has been moved builds.
    #[test]
    fn what_was_configured_for_another_place_is_forgotten() {
        let directory = tempfile::tempdir().unwrap();
        let build = directory.path().join("build");
        let configured = |home: &str| {
            fs::create_dir_all(&build).unwrap();
            let cache = format!("A:STRING=b\nCMAKE_HOME_DIRECTORY:INTERNAL={home}\n");
            fs::write(build.join("CMakeCache.txt"), cache).unwrap();
            forget_other_sources(&build, Path::new("/here")).unwrap();
            build.exists()
        };
        assert!(configured("/here"));
        assert!(!configured("/there"));
        assert!(forget_other_sources(&build, Path::new("/here")).is_ok());
    }

    /// Whether a header has a line that tells LAMMPS' build of a style.
    fn registers_style(header: &Path) -> bool {
        let kinds = ["PairStyle(", "FixStyle(", "ComputeStyle(", "CommandStyle("];
        let text = fs::read_to_string(header).unwrap();
        text.lines()
            .any(|line| kinds.iter().any(|kind| line.starts_with(kind)))
    }

    /// Built into LAMMPS, the styles are the same files as in the plugin, without what loads the plugin.
    #[test]
    fn both_ways_of_building_have_all_files() {
        let directory = workspace::root().join("lammps-plugin");
        let words = |name: &str| -> Vec<String> {
            let text = fs::read_to_string(directory.join(name)).unwrap();
            let separates = |c: char| c.is_whitespace() || "()\"/".contains(c);
            text.split(separates).map(str::to_owned).collect()
        };
        let list = "ellgran-sources.cmake";
        let (sources, built_in) = (words(list), words("ellgran-builtin.cmake"));
        for file in ["CMakeLists.txt", "ellgran-builtin.cmake"] {
            assert!(words(file).iter().any(|word| word == list), "{file}");
        }
        let mut seen = 0;
        for entry in fs::read_dir(&directory).unwrap() {
            let name = entry.unwrap().file_name().to_string_lossy().into_owned();
            let only_plugin = [
                "borrowed_headers.cpp",
                "ellgran_lammps_interface.cpp",
                "ellgran_plugin.cpp",
            ];
            if name.ends_with(".cpp") && !only_plugin.contains(&name.as_str()) {
                assert!(sources.contains(&name), "{list} lacks {name}");
                seen += 1;
            } else if name.ends_with(".h") && registers_style(&directory.join(&name)) {
                assert!(
                    built_in.contains(&name),
                    "ellgran-builtin.cmake lacks {name}"
                );
            }
        }
        assert!(seen > 10, "{seen}");
    }
}
