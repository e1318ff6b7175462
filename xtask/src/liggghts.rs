// SPDX-License-Identifier: MIT OR Apache-2.0
//! LIGGGHTS with our contact models: its source tree, a patched copy, the binary.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{bail, Context, Result};

use crate::library::library;
use crate::process::{ninja, output_of, run_logged};
use crate::progress::say;
use crate::{apt_source, cache, setup, tarball, vtk, workspace};

pub const VERSION: &str = "3.8.0";
const SUITES: [&str; 3] = ["bookworm", "trixie", "sid"];
const SOURCE_VARIABLE: &str = "ELLGRAN_LIGGGHTS_SOURCE";

/// JPEG is left out, so that the same binary comes out everywhere. LIGGGHTS looks for a VTK older than today's: ours is handed to it.
const CONFIGURATION: [&str; 4] = [
    "-DCMAKE_BUILD_TYPE=None",
    "-DCMAKE_DISABLE_FIND_PACKAGE_VTK=on",
    "-DCMAKE_DISABLE_FIND_PACKAGE_JPEG=on",
    // Its CMakeLists.txt asks for a CMake older than new ones will imitate unasked.
    "-DCMAKE_POLICY_VERSION_MINIMUM=3.5",
];

/// How the compiler optimises. Each has a build tree and a binary of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Optimisation {
    /// That of LIGGGHTS' own makefile.
    O2,
    /// For comparisons of speed.
    O3,
}

impl Optimisation {
    pub fn flag(self) -> &'static str {
        match self {
            Optimisation::O2 => "-O2",
            Optimisation::O3 => "-O3",
        }
    }

    /// The sources are older than C++11, and warn by the thousand.
    fn compiler_flags(self) -> String {
        format!(
            "-DCMAKE_CXX_FLAGS={} -funroll-loops -std=gnu++98 -w -fPIC",
            self.flag()
        )
    }

    /// Appended to the names of build tree and binary.
    fn suffix(self) -> &'static str {
        match self {
            Optimisation::O2 => "",
            Optimisation::O3 => "-O3",
        }
    }
}

/// The patched binary, as the makefile of LIGGGHTS optimises it.
pub fn binary() -> Result<PathBuf> {
    binary_with(Optimisation::O2)
}

/// The patched binary. The tree that it is built in is kept, so that a change of ours costs a few files' compilation;
/// the binary is copied out of it, so that another checkout's build does not change it underfoot.
pub fn binary_with(optimisation: Optimisation) -> Result<PathBuf> {
    setup::setup()?;
    let (source, name) = source()?;
    let library = library()?;
    let _lock = cache::lock(&format!("liggghts-build-{name}"))?;
    let home = cache::directory()?.join(format!("liggghts-{name}"));
    let tree = home.join("patched");
    let vtk = vtk::vtk()
        .map_err(|error| {
            say(format!(
                "LIGGGHTS is built without its VTK dumps: {error:#}"
            ))
        })
        .ok();
    let build = home.join(format!(
        "build{}{}",
        optimisation.suffix(),
        if vtk.is_some() { "" } else { "-no-vtk" }
    ));
    fs::create_dir_all(&build)?;
    cache::need_space(&build, 1000)?;
    copy_tree(&source, &tree)?;

    // At paths that stay, or every file would be compiled again for another checkout.
    let ours = home.join("ellgran");
    fs::create_dir_all(&ours)?;
    let header = workspace::root().join("include").join("ellgran.h");
    copy_changed(&header, &ours.join("ellgran.h"))?;
    copy_changed(&library, &ours.join("libellgran.a"))?;

    let installer = workspace::root().join("liggghts-patch").join("install");
    output_of(Command::new("sh").arg(&installer).arg(&tree).arg("--few"))
        .context("the contact models cannot be installed")?;
    if !build.join("liggghts").is_file() {
        say(format!(
            "Building LIGGGHTS {name} with {} in {} (once; 5 minutes on two cores)",
            optimisation.flag(),
            build.display()
        ));
    }
    let mut configure = Command::new("cmake");
    configure
        .arg("-S")
        .arg(tree.join("src"))
        .arg("-B")
        .arg(&build)
        .args(["-G", "Ninja"])
        .args(CONFIGURATION)
        .arg(optimisation.compiler_flags())
        .arg(format!(
            "-DELLGRAN_LIBRARY={}",
            ours.join("libellgran.a").display()
        ))
        .arg(format!("-DELLGRAN_INCLUDE={}", ours.display()));
    if let Some(vtk) = &vtk {
        configure
            .arg(format!("-DELLGRAN_VTK_INCLUDE={}", vtk.include.display()))
            .arg(format!(
                "-DELLGRAN_VTK_LIBRARIES={}",
                vtk.libraries.display()
            ));
    }
    run_logged(&mut configure, &build.join("configure.log"), |_| {})
        .context("LIGGGHTS cannot be configured")?;
    ninja(
        &build,
        &["liggghts_bin"],
        &format!("Building LIGGGHTS {name} with {}", optimisation.flag()),
    )
    .context("LIGGGHTS cannot be built")?;
    let directory = workspace::target_directory()?.join("liggghts");
    fs::create_dir_all(&directory)?;
    let binary = directory.join(format!("liggghts{}", optimisation.suffix()));
    copy_changed(&build.join("liggghts"), &binary)?;
    Ok(binary)
}

/// The untouched source tree.
pub fn source_tree() -> Result<PathBuf> {
    Ok(source()?.0)
}

/// The untouched source tree and the name of what is built from it.
fn source() -> Result<(PathBuf, String)> {
    if let Some(own) = std::env::var_os(SOURCE_VARIABLE).filter(|value| !value.is_empty()) {
        let directory = PathBuf::from(&own)
            .canonicalize()
            .with_context(|| format!("{SOURCE_VARIABLE}={}", own.to_string_lossy()))?;
        if !directory.join("src/version_liggghts.txt").is_file() {
            bail!(
                "{SOURCE_VARIABLE}={}: no src/version_liggghts.txt there; the top directory of a LIGGGHTS source tree is wanted",
                directory.display()
            );
        }
        let name = format!("own-{}", cache::key(&[&directory.to_string_lossy()]));
        return Ok((directory, name));
    }
    let directory = fetched().with_context(|| {
        format!("the LIGGGHTS source cannot be had through apt; name a source tree of LIGGGHTS-PUBLIC {VERSION} with {SOURCE_VARIABLE}=/path/to/LIGGGHTS")
    })?;
    Ok((directory, VERSION.to_string()))
}

fn fetched() -> Result<PathBuf> {
    let _lock = cache::lock("liggghts-source")?;
    let home = cache::directory()?;
    let directory = home.join(format!("liggghts-{VERSION}")).join("source");
    if directory.is_dir() {
        return Ok(directory);
    }
    cache::need_space(&home, 500)?;
    let package = apt_source::find_in("liggghts", VERSION, &SUITES)?
        .with_context(|| format!("Debian has no LIGGGHTS {VERSION} in {}", SUITES.join(", ")))?;
    let download = tempfile::Builder::new()
        .prefix("download-")
        .tempdir_in(&home)?;
    let tarball = package.download(download.path())?;
    tarball::unpack(&tarball, &directory, &["doc", "examples"])?;
    Ok(directory)
}

/// Files that are newer in the source, or missing in the copy.
fn copy_tree(source: &Path, copy: &Path) -> Result<()> {
    fs::create_dir_all(copy)?;
    output_of(
        Command::new("cp")
            .args(["-a", "-u"])
            .arg(source.join("."))
            .arg(copy),
    )?;
    Ok(())
}

/// Keeps the date of a file that is the same, and with it what was built from it.
fn copy_changed(from: &Path, to: &Path) -> Result<()> {
    let new = fs::read(from).with_context(|| format!("cannot read {}", from.display()))?;
    if fs::read(to).is_ok_and(|old| old == new) {
        return Ok(());
    }
    // Under another name first: a binary that is running cannot be written, but can be replaced.
    let fresh = to.with_extension("new");
    fs::copy(from, &fresh).with_context(|| format!("cannot write {}", fresh.display()))?;
    fs::rename(&fresh, to)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unchanged_file_keeps_its_date() {
        let directory = tempfile::tempdir().unwrap();
        let (from, to) = (directory.path().join("a"), directory.path().join("b.txt"));
        fs::write(&from, "one").unwrap();
        copy_changed(&from, &to).unwrap();
        let old = std::time::SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(1_000_000);
        fs::File::options()
            .append(true)
            .open(&to)
            .unwrap()
            .set_modified(old)
            .unwrap();
        copy_changed(&from, &to).unwrap();
        assert_eq!(fs::metadata(&to).unwrap().modified().unwrap(), old);
        fs::write(&from, "two").unwrap();
        copy_changed(&from, &to).unwrap();
        assert_eq!(fs::read_to_string(&to).unwrap(), "two");
        assert!(fs::metadata(&to).unwrap().modified().unwrap() > old);
    }
}
