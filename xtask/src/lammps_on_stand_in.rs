// SPDX-License-Identifier: MIT OR Apache-2.0
//! LAMMPS' styles for a GPU as a plugin for a LAMMPS with KOKKOS for the host, with the stand-in for NVIDIA's driver: for tests.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{bail, Context, Result};

use crate::lammps::Source;
use crate::lammps_kokkos::Built;
use crate::plugin::{define, forget_other_sources};
use crate::process::{ninja, output_of, run_logged, run_visible};
use crate::{cache, workspace};

/// Needs what `lammps` was built from: its headers, those of its Kokkos, and what CMake has written for it.
pub fn plugin(source: &Source, lammps: &Built) -> Result<PathBuf> {
    let (library, stand_in) = libraries()?;
    let build = workspace::target_directory()?
        .join("lammps-on-stand-in")
        .join(&source.name);
    let sources = workspace::root().join("tests/lammps_on_gpu/plugin");
    let _lock = cache::lock(&format!("lammps-on-stand-in-{}", source.name))?;
    forget_other_sources(&build, &sources)?;
    std::fs::create_dir_all(&build)?;
    let mut configure = Command::new("cmake");
    configure
        .arg("-S")
        .arg(&sources)
        .arg("-B")
        .arg(&build)
        .args(["-G", "Ninja"])
        .arg(define("LAMMPS_SOURCE_DIR", &lammps.tree.join("src")))
        .arg(define("LAMMPS_BUILD_DIR", &lammps.build))
        .arg(define("CMAKE_PREFIX_PATH", &lammps.kokkos))
        .arg(define("ELLGRAN_LIBRARY", &library))
        .arg(define("ELLGRAN_STAND_IN", &stand_in));
    run_logged(&mut configure, &build.join("configure.log"), |_| {})
        .context("the plugin with the styles for a GPU cannot be configured")?;
    let title = format!(
        "Building the styles for a GPU for LAMMPS {}",
        source.spelled()?
    );
    ninja(&build, &[], &title).context("the plugin with the styles for a GPU cannot be built")?;
    let plugin = build.join("ellgrangpustyles.so");
    if !plugin.is_file() {
        bail!("the build left no {}", plugin.display());
    }
    Ok(plugin)
}

/// `libellgran_gpu.a` and the stand-in as the tests of the interface for GPUs have them: after those nothing is compiled.
fn libraries() -> Result<(PathBuf, PathBuf)> {
    let tests = || {
        let mut cargo = workspace::cargo();
        cargo.args(["test", "--workspace", "--no-run", "--test", "statuses"]);
        cargo
    };
    run_visible(&mut tests())?;
    let messages = output_of(tests().args(["--quiet", "--message-format=json"]))?;
    let library = made(&messages, "ellgran_gpu", ".a")?;
    let stand_in = made(
        &messages,
        "ellgran_gpu_stand_in",
        std::env::consts::DLL_SUFFIX,
    )?;
    Ok((library, stand_in))
}

/// The file with this ending that cargo says it has made for a library.
fn made(messages: &str, library: &str, ending: &str) -> Result<PathBuf> {
    let artifacts = messages
        .lines()
        .filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok())
        .filter(|message| message["reason"] == "compiler-artifact");
    for message in artifacts.filter(|message| message["target"]["name"] == library) {
        let files = message["filenames"].as_array().into_iter().flatten();
        let mut found = files
            .filter_map(|file| file.as_str())
            .filter(|file| file.ends_with(ending));
        if let Some(file) = found.next() {
            return Ok(Path::new(file).to_owned());
        }
    }
    bail!("cargo names no {library} that ends in {ending}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_of_a_library_is_found_among_cargos_messages() {
        let messages = r#"{"reason":"build-script-executed"}
            {"reason":"compiler-artifact","target":{"name":"other"},"filenames":["/t/libother.a"]}
            {"reason":"compiler-artifact","target":{"name":"one"},"filenames":["/t/libone.rlib","/t/libone-1.a"]}"#;
        let found = made(messages, "one", ".a").unwrap();
        assert_eq!(found, Path::new("/t/libone-1.a"));
        for (library, ending) in [("one", ".so"), ("two", ".a")] {
            let error = made(messages, library, ending).unwrap_err().to_string();
            assert!(error.contains(library) && error.contains(ending), "{error}");
        }
    }
}
