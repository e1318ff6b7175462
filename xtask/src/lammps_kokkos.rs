// SPDX-License-Identifier: MIT OR Apache-2.0
//! LAMMPS with its KOKKOS package for the host, as the tests need it: a copy of a release's source tree with few of the
//! package's styles, and Kokkos itself, which Debian takes out of LAMMPS' sources.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{bail, Context, Result};

use crate::lammps::Source;
use crate::process::{ninja, output_of, run_logged};
use crate::progress::say;
use crate::{cache, setup};

/// A package of Python's index whose sources hold those of Kokkos: pip checks the hash.
const CARRIER: &str = "pygenten";
const CARRIER_VERSION: &str = "0.1.5";
const CARRIER_HASH: &str =
    "sha256:e620f05c742905e2db705d875f1cac92ef0ed453f9e6734e9beda26cc0f9cce7";
const KOKKOS_IN_CARRIER: &str = "tpls/kokkos";
pub const KOKKOS_VERSION: &str = "4.7.0";

/// What runs the package's own kernels.
#[derive(Clone, Copy)]
pub enum Backend {
    OpenMp,
    Serial,
}

impl Backend {
    fn name(self) -> &'static str {
        match self {
            Backend::OpenMp => "OpenMP",
            Backend::Serial => "Serial",
        }
    }

    fn kokkos_option(self) -> &'static str {
        match self {
            Backend::OpenMp => "-DKokkos_ENABLE_OPENMP=on",
            Backend::Serial => "-DKokkos_ENABLE_OPENMP=off",
        }
    }
}

/// Files of the package by their names without `_kokkos`, beside those that LAMMPS' CMake names itself: each costs up to half a
/// minute, and without its file a style is the one without the suffix.
pub const KEPT_STYLES: &[&str] = &[
    "atom_vec_atomic",
    "atom_vec_ellipsoid",
    "compute_temp",
    "fix_gravity",
    "fix_minimize",
    "fix_nve_asphere",
    "fix_property_atom",
    "math_special",
    "nbin",
    "npair_copy",
    "npair_skip",
    "npair_trim",
    "region_block",
    "verlet",
];

/// Where the release asks for Kokkos 5.1, and the one place in which it needs it: file, what is there, what takes its place.
const FOR_KOKKOS_4: [(&str, &str, &str); 2] = [
    (
        "cmake/Modules/Packages/KOKKOS.cmake",
        "find_package(Kokkos 5.1.0 ",
        "find_package(Kokkos 4.7.0 ",
    ),
    (
        "src/KOKKOS/kokkos_type.h",
        "hash_type::host_mirror_type",
        "hash_type::HostMirror",
    ),
];

/// Of the tests' time most is LAMMPS' own start: it need not be fast, but built soon.
const CONFIGURATION: &[&str] = &[
    "-DCMAKE_BUILD_TYPE=Release",
    "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG",
    "-DCMAKE_CXX_STANDARD=20",
    "-DBUILD_MPI=on",
    "-DBUILD_OMP=on",
    "-DBUILD_SHARED_LIBS=off",
    "-DBUILD_TOOLS=off",
    "-DPKG_ASPHERE=on",
    "-DPKG_PLUGIN=on",
    "-DPKG_KOKKOS=on",
    "-DEXTERNAL_KOKKOS=on",
    "-DWITH_JPEG=off",
    "-DWITH_PNG=off",
    "-DWITH_FFMPEG=off",
    "-DWITH_CURL=off",
    "-DDOWNLOAD_POTENTIALS=off",
];

/// Whether ellipsoids can be had with KOKKOS there at all.
pub fn has_ellipsoids(lammps: &Source) -> bool {
    lammps
        .src()
        .join("KOKKOS/atom_vec_ellipsoid_kokkos.cpp")
        .is_file()
}

/// What is built, and what it is built from.
pub struct Built {
    pub binary: PathBuf,
    /// Its source tree and its build.
    pub tree: PathBuf,
    pub build: PathBuf,
    /// Where its Kokkos is installed.
    pub kokkos: PathBuf,
}

/// The binary, built when missing.
pub fn binary(lammps: &Source, backend: Backend) -> Result<PathBuf> {
    Ok(built(lammps, backend)?.binary)
}

pub fn built(lammps: &Source, backend: Backend) -> Result<Built> {
    setup::setup()?;
    let spelled = lammps.spelled()?;
    if !has_ellipsoids(lammps) {
        bail!("LAMMPS {spelled} has no atom_style ellipsoid for KOKKOS");
    }
    let kokkos = kokkos(backend)?;
    let mpi = output_of(Command::new("mpicxx").arg("-show"))?;
    let mut parts = CONFIGURATION.to_vec();
    parts.extend(KEPT_STYLES);
    parts.extend(FOR_KOKKOS_4.iter().flat_map(|change| [change.1, change.2]));
    parts.extend([KOKKOS_VERSION, mpi.as_str()]);
    let home = cache::directory()?.join(format!("lammps-{}", lammps.name));
    let tree = home.join(format!("source-kokkos-{}", cache::key(&parts)));
    parts.push(backend.name());
    let build = home.join(format!("build-kokkos-{}", cache::key(&parts)));
    let all = Built {
        binary: build.join("lmp"),
        tree,
        build,
        kokkos,
    };
    let Built {
        binary,
        tree,
        build,
        kokkos,
    } = &all;
    let _lock = cache::lock(&format!("lammps-kokkos-build-{}", lammps.name))?;
    let stamp = cache::stamp(build);
    let title = format!("LAMMPS {spelled} with KOKKOS for {}", backend.name());
    if stamp.is_file() && binary.is_file() {
        say(format!("{title} is in the cache"));
        return Ok(all);
    }
    cache::need_space(&home, 1500)?;
    if !tree.is_dir() {
        few_styles(&lammps.directory, tree, KEPT_STYLES)?;
    }
    fs::create_dir_all(build)?;
    say(format!(
        "Building {title} in {} (once; about 10 minutes on two cores)",
        build.display()
    ));
    let mut configure = Command::new("cmake");
    configure
        .arg("-S")
        .arg(tree.join("cmake"))
        .arg("-B")
        .arg(build)
        .args(["-G", "Ninja"])
        .args(CONFIGURATION)
        .arg(format!("-DCMAKE_PREFIX_PATH={}", kokkos.display()));
    run_logged(&mut configure, &build.join("configure.log"), |_| {})
        .context("LAMMPS with KOKKOS cannot be configured")?;
    ninja(build, &["lmp"], &format!("Building {title}"))
        .context("LAMMPS with KOKKOS cannot be built")?;
    fs::write(&stamp, &spelled)?;
    Ok(all)
}

/// A copy of LAMMPS' source tree, as links to its files, with these of the package's styles alone and for this Kokkos.
pub fn few_styles(source: &Path, target: &Path, kept: &[&str]) -> Result<()> {
    let parent = target.parent().context("a tree needs a parent directory")?;
    let scratch = tempfile::Builder::new()
        .prefix("source-kokkos-")
        .tempdir_in(parent)?;
    let copy = scratch.path().join("source");
    let cmake = fs::read_to_string(source.join("cmake/Modules/Packages/KOKKOS.cmake"))?;
    link_tree(source, &copy, &|path| is_left_out(path, &cmake, kept))?;
    for (file, before, after) in FOR_KOKKOS_4 {
        let path = copy.join(file);
        let text =
            fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
        // A later release may ask for something else: then it is taken as it is.
        if text.contains(before) {
            fs::remove_file(&path)?;
            fs::write(&path, text.replace(before, after))?;
        }
    }
    fs::rename(&copy, target)?;
    Ok(())
}

/// A source of the package, or its header, that neither CMake names nor `kept`.
fn is_left_out(path: &Path, cmake: &str, kept: &[&str]) -> bool {
    let in_package = path
        .parent()
        .is_some_and(|parent| parent.ends_with("src/KOKKOS"));
    let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
        return false;
    };
    let Some((stem, "cpp" | "h")) = name.rsplit_once('.') else {
        return false;
    };
    let Some(style) = stem.strip_suffix("_kokkos") else {
        return false;
    };
    // Headers without a source are what the others include.
    in_package
        && path.with_extension("cpp").is_file()
        && !cmake.contains(&format!("/{stem}.cpp"))
        && !kept.contains(&style)
}

pub fn link_tree(source: &Path, target: &Path, left_out: &dyn Fn(&Path) -> bool) -> Result<()> {
    fs::create_dir_all(target)?;
    for entry in fs::read_dir(source)? {
        let path = entry?.path();
        let copy = target.join(path.file_name().context("a directory entry has a name")?);
        if path.is_dir() {
            link_tree(&path, &copy, left_out)?;
        } else if path.is_file() && !left_out(&path) && fs::hard_link(&path, &copy).is_err() {
            fs::copy(&path, &copy)?;
        }
    }
    Ok(())
}

/// Kokkos, installed in the cache; built when missing.
fn kokkos(backend: Backend) -> Result<PathBuf> {
    let source = kokkos_source()?;
    let home = cache::directory()?.join(format!("kokkos-{KOKKOS_VERSION}"));
    let _lock = cache::lock(&format!("kokkos-build-{KOKKOS_VERSION}"))?;
    let installed = home.join(format!("installed-{}", backend.name()));
    let stamp = cache::stamp(&installed);
    if stamp.is_file() {
        return Ok(installed);
    }
    let build = home.join(format!("build-{}", backend.name()));
    fs::create_dir_all(&build)?;
    let mut configure = configure_kokkos(&source, &build, &installed);
    configure.arg(backend.kokkos_option());
    run_logged(&mut configure, &build.join("configure.log"), |_| {})
        .context("Kokkos cannot be configured")?;
    let title = format!("Building Kokkos {KOKKOS_VERSION} for {}", backend.name());
    ninja(&build, &["install"], &title).context("Kokkos cannot be built")?;
    fs::write(&stamp, KOKKOS_VERSION)?;
    Ok(installed)
}

/// CMake for a Kokkos as LAMMPS needs it, with what runs its kernels still to be named.
pub fn configure_kokkos(source: &Path, build: &Path, installed: &Path) -> Command {
    let mut configure = Command::new("cmake");
    configure
        .arg("-S")
        .arg(source)
        .arg("-B")
        .arg(build)
        .args(["-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release"])
        .args(["-DCMAKE_CXX_STANDARD=20", "-DCMAKE_INSTALL_LIBDIR=lib"])
        // As LAMMPS sets it.
        .arg("-DKokkos_ENABLE_IMPL_VIEW_LEGACY=on")
        .arg("-DKokkos_ENABLE_SERIAL=on")
        .arg(format!("-DCMAKE_INSTALL_PREFIX={}", installed.display()));
    configure
}

/// Its source tree in the cache, fetched when missing. An error says why it cannot be had.
pub fn kokkos_source() -> Result<PathBuf> {
    setup::python()?;
    let _lock = cache::lock(&format!("kokkos-source-{KOKKOS_VERSION}"))?;
    let home = cache::directory()?.join(format!("kokkos-{KOKKOS_VERSION}"));
    let source = home.join("source");
    if source.is_dir() {
        return Ok(source);
    }
    fs::create_dir_all(&home)?;
    let scratch = tempfile::Builder::new()
        .prefix("download-")
        .tempdir_in(&home)?;
    fetch(scratch.path()).context("the sources of Kokkos cannot be had")?;
    fs::rename(scratch.path().join("kokkos"), &source)?;
    Ok(source)
}

/// Leaves `kokkos` in `directory`.
fn fetch(directory: &Path) -> Result<()> {
    say(format!("Fetching Kokkos {KOKKOS_VERSION}"));
    let environment = directory.join("environment");
    output_of(
        Command::new("python3")
            .args(["-m", "venv"])
            .arg(&environment),
    )?;
    let requirements = directory.join("requirements");
    fs::write(
        &requirements,
        format!("{CARRIER}=={CARRIER_VERSION} --hash={CARRIER_HASH}\n"),
    )?;
    output_of(
        Command::new(environment.join("bin/python"))
            .args(["-m", "pip", "download", "--quiet", "--no-deps"])
            .args(["--disable-pip-version-check", "--no-binary", CARRIER])
            .arg("--dest")
            .arg(directory)
            .arg("--require-hashes")
            .arg("--requirement")
            .arg(&requirements),
    )?;
    let kokkos = directory.join("kokkos");
    fs::create_dir(&kokkos)?;
    let levels = 1 + KOKKOS_IN_CARRIER.split('/').count();
    output_of(
        Command::new("tar")
            .args(["--extract", "--no-same-owner", "--file"])
            .arg(directory.join(format!("{CARRIER}-{CARRIER_VERSION}.tar.gz")))
            .arg(format!("--strip-components={levels}"))
            .arg("--directory")
            .arg(&kokkos)
            .arg(format!("{CARRIER}-{CARRIER_VERSION}/{KOKKOS_IN_CARRIER}")),
    )?;
    if !kokkos.join("core/src/Kokkos_Core.hpp").is_file() {
        bail!("{CARRIER} {CARRIER_VERSION} has no Kokkos in {KOKKOS_IN_CARRIER}");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_has_few_styles_and_the_original_stays() {
        let directory = tempfile::tempdir().unwrap();
        let source = directory.path().join("source");
        let package = source.join("src/KOKKOS");
        fs::create_dir_all(&package).unwrap();
        fs::create_dir_all(source.join("cmake/Modules/Packages")).unwrap();
        for name in [
            "comm_kokkos.cpp",
            "comm_kokkos.h",
            "fix_shake_kokkos.cpp",
            "fix_shake_kokkos.h",
            "pair_kokkos.h",
            "verlet_kokkos.cpp",
            "verlet_kokkos.h",
        ] {
            fs::write(package.join(name), name).unwrap();
        }
        let types = "typedef hash_type::host_mirror_type host_hash_type;";
        fs::write(package.join("kokkos_type.h"), types).unwrap();
        let cmake = source.join("cmake/Modules/Packages/KOKKOS.cmake");
        fs::write(
            &cmake,
            "find_package(Kokkos 5.1.0 REQUIRED)\n${D}/comm_kokkos.cpp",
        )
        .unwrap();
        let copy = directory.path().join("copy");
        few_styles(&source, &copy, KEPT_STYLES).unwrap();
        let mut names: Vec<String> = fs::read_dir(copy.join("src/KOKKOS"))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        assert_eq!(
            names,
            [
                "comm_kokkos.cpp",
                "comm_kokkos.h",
                "kokkos_type.h",
                "pair_kokkos.h",
                "verlet_kokkos.cpp",
                "verlet_kokkos.h"
            ]
        );
        let read = |path: PathBuf| fs::read_to_string(path).unwrap();
        assert!(read(copy.join("src/KOKKOS/kokkos_type.h")).contains("::HostMirror "));
        assert!(read(copy.join("cmake/Modules/Packages/KOKKOS.cmake")).contains("4.7.0"));
        assert_eq!(read(package.join("kokkos_type.h")), types);
        assert!(read(cmake).contains("5.1.0"));
    }
}
