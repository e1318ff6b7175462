// SPDX-License-Identifier: MIT OR Apache-2.0
//! LAMMPS with its KOKKOS package for a GPU of NVIDIA and with the styles of ellgran built in: a binary that needs a driver and MPI where
//! it runs, and nothing else.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{bail, Context, Result};

use crate::lammps::Source;
use crate::lammps_kokkos::{
    configure_kokkos, few_styles, kokkos_source, link_tree, KEPT_STYLES, KOKKOS_VERSION,
};
use crate::process::{ninja_by, run_logged};
use crate::progress::say;
use crate::workspace::root;
use crate::{cache, cuda_toolkit, lammps_kokkos, library, setup};

/// The generation of GPUs that it is for: Hopper.
const ARCHITECTURE: &str = "HOPPER90";
const GENERATION: &str = "sm_90";

/// LAMMPS' own spheres, beside what the tests need: rates are compared with theirs.
const OF_SPHERES: &[&str] = &[
    "atom_vec_sphere",
    "fix_neigh_history",
    "fix_nve_sphere",
    "pair_gran_hooke_history",
];

/// What CUDA 13 has changed since this Kokkos: file, what is there, what takes its place.
const FOR_CUDA_13: [(&str, &str, &str); 3] = [
    (
        "bin/nvcc_wrapper",
        "default_arch=\"sm_70\"",
        "default_arch=\"sm_90\"",
    ),
    (
        "core/src/Cuda/Kokkos_Cuda_Instance.hpp",
        "return cudaGraphAddDependencies(graph, from, to, numDependencies);",
        "return cudaGraphAddDependencies(graph, from, to, nullptr, numDependencies);",
    ),
    (
        "core/src/Cuda/Kokkos_Cuda_Instance.hpp",
        "return cudaMemPrefetchAsync(devPtr, count, dstDevice, m_stream);",
        "return cudaMemPrefetchAsync(devPtr, count, {cudaMemLocationTypeDevice, dstDevice}, 0, m_stream);",
    ),
];

const CONFIGURATION: &[&str] = &[
    "-DCMAKE_BUILD_TYPE=Release",
    "-DCMAKE_CXX_FLAGS_RELEASE=-O2 -DNDEBUG",
    "-DCMAKE_CXX_STANDARD=20",
    "-DBUILD_MPI=on",
    "-DBUILD_OMP=off",
    "-DBUILD_SHARED_LIBS=off",
    "-DBUILD_TOOLS=off",
    "-DPKG_ASPHERE=on",
    "-DPKG_GRANULAR=on",
    "-DPKG_PLUGIN=on",
    "-DPKG_KOKKOS=on",
    "-DEXTERNAL_KOKKOS=on",
    "-DELLGRAN_GPU=on",
    "-DWITH_JPEG=off",
    "-DWITH_PNG=off",
    "-DWITH_FFMPEG=off",
    "-DWITH_CURL=off",
    "-DWITH_GZIP=off",
    "-DDOWNLOAD_POTENTIALS=off",
];

/// The binary, built when missing, and again when the styles or the library have changed.
pub fn binary(lammps: &Source) -> Result<PathBuf> {
    setup::setup()?;
    let spelled = lammps.spelled()?;
    if !lammps_kokkos::has_ellipsoids(lammps) {
        bail!("LAMMPS {spelled} has no atom_style ellipsoid for KOKKOS");
    }
    let toolkit = cuda_toolkit::toolkit()?;
    let kokkos = kokkos(&toolkit)?;
    let library = library::for_gpus()?;
    let kept: Vec<&str> = KEPT_STYLES.iter().chain(OF_SPHERES).copied().collect();
    let mut parts = CONFIGURATION.to_vec();
    parts.extend(&kept);
    parts.extend([KOKKOS_VERSION, ARCHITECTURE]);
    let home = cache::directory()?.join(format!("lammps-{}", lammps.name));
    let tree = home.join(format!("source-kokkos-{}", cache::key(&parts)));
    let places = [toolkit.display().to_string(), kokkos.display().to_string()];
    parts.extend(places.iter().map(String::as_str));
    let build = home.join(format!("build-kokkos-cuda-{}", cache::key(&parts)));
    let _lock = cache::lock(&format!("lammps-kokkos-cuda-build-{}", lammps.name))?;
    let title = format!("LAMMPS {spelled} with KOKKOS for CUDA");
    cache::need_space(&home, 1500)?;
    if !tree.is_dir() {
        few_styles(&lammps.directory, &tree, &kept)?;
    }
    fs::create_dir_all(&build)?;
    say(format!(
        "Building {title} in {} (at first half an hour on two cores)",
        build.display()
    ));
    let mut configure = Command::new("cmake");
    configure
        .arg("-S")
        .arg(tree.join("cmake"))
        .arg("-B")
        .arg(&build)
        .args(["-G", "Ninja"])
        .args(CONFIGURATION)
        .arg(format!("-DCMAKE_PREFIX_PATH={}", kokkos.display()))
        .arg(format!(
            "-DCMAKE_CXX_COMPILER={}",
            kokkos.join("bin/nvcc_wrapper").display()
        ))
        .args(of_toolkit(&toolkit))
        .arg(format!(
            "-DCMAKE_PROJECT_lammps_INCLUDE={}",
            root().join("lammps-plugin/ellgran-builtin.cmake").display()
        ))
        .arg(format!("-DELLGRAN_LIBRARY={}", library.display()))
        .arg(format!(
            "-DELLGRAN_INCLUDE_DIR={}",
            root().join("include").display()
        ));
    with_toolkit(&mut configure, &toolkit);
    run_logged(&mut configure, &build.join("configure.log"), |_| {})
        .context("LAMMPS with KOKKOS for CUDA cannot be configured")?;
    let mut maker = Command::new("ninja");
    with_toolkit(&mut maker, &toolkit);
    ninja_by(maker, &build, &["lmp"], &format!("Building {title}"))
        .context("LAMMPS with KOKKOS for CUDA cannot be built")?;
    Ok(build.join("lmp"))
}

/// Where CMake finds it, and the runtime as a part of the binary.
fn of_toolkit(toolkit: &Path) -> [String; 2] {
    [
        format!("-DCUDAToolkit_ROOT={}", toolkit.display()),
        format!(
            "-DCUDA_cudart_LIBRARY={}",
            toolkit.join("lib/libcudart_static.a").display()
        ),
    ]
}

/// What the compiler's wrapper of Kokkos looks at.
fn with_toolkit(command: &mut Command, toolkit: &Path) {
    let mut path = toolkit.join("bin").into_os_string();
    if let Some(before) = std::env::var_os("PATH") {
        path.push(":");
        path.push(before);
    }
    command.env("PATH", path).env("CUDA_ROOT", toolkit);
}

/// Kokkos for CUDA, installed in the cache; built when missing.
fn kokkos(toolkit: &Path) -> Result<PathBuf> {
    let original = kokkos_source()?;
    let mut parts = vec![KOKKOS_VERSION, ARCHITECTURE];
    let place = toolkit.display().to_string();
    parts.push(&place);
    parts.extend(FOR_CUDA_13.iter().flat_map(|change| [change.1, change.2]));
    let home = cache::directory()?.join(format!("kokkos-{KOKKOS_VERSION}"));
    let key = cache::key(&parts);
    let _lock = cache::lock(&format!("kokkos-build-{KOKKOS_VERSION}"))?;
    let installed = home.join(format!("installed-cuda-{key}"));
    let stamp = cache::stamp(&installed);
    if stamp.is_file() {
        return Ok(installed);
    }
    let source = home.join(format!("source-cuda-{key}"));
    if !source.is_dir() {
        let scratch = tempfile::Builder::new()
            .prefix("source-cuda-")
            .tempdir_in(&home)?;
        let copy = scratch.path().join("source");
        link_tree(&original, &copy, &|_| false)?;
        for (file, before, after) in FOR_CUDA_13 {
            change(&copy.join(file), before, after)?;
        }
        fs::rename(&copy, &source)?;
    }
    let build = home.join(format!("build-cuda-{key}"));
    fs::create_dir_all(&build)?;
    let mut configure = configure_kokkos(&source, &build, &installed);
    configure
        .arg("-DKokkos_ENABLE_CUDA=on")
        .arg(format!("-DKokkos_ARCH_{ARCHITECTURE}=on"))
        .arg(format!(
            "-DCMAKE_CXX_COMPILER={}",
            source.join("bin/nvcc_wrapper").display()
        ))
        .args(of_toolkit(toolkit));
    with_toolkit(&mut configure, toolkit);
    run_logged(&mut configure, &build.join("configure.log"), |_| {})
        .context("Kokkos for CUDA cannot be configured")?;
    let title = format!("Building Kokkos {KOKKOS_VERSION} for CUDA, {GENERATION}");
    let mut maker = Command::new("ninja");
    with_toolkit(&mut maker, toolkit);
    ninja_by(maker, &build, &["install"], &title).context("Kokkos for CUDA cannot be built")?;
    fs::write(&stamp, KOKKOS_VERSION)?;
    Ok(installed)
}

/// In a copy of which the files are links to the original.
fn change(path: &Path, before: &str, after: &str) -> Result<()> {
    let text =
        fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    if !text.contains(before) {
        bail!("{} has no '{before}'", path.display());
    }
    let permissions = fs::metadata(path)?.permissions();
    fs::remove_file(path)?;
    fs::write(path, text.replace(before, after))?;
    fs::set_permissions(path, permissions)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_stays_in_the_copy() {
        let directory = tempfile::tempdir().unwrap();
        let original = directory.path().join("original");
        fs::create_dir(&original).unwrap();
        fs::write(original.join("file"), "one two").unwrap();
        let copy = directory.path().join("copy");
        link_tree(&original, &copy, &|_| false).unwrap();
        change(&copy.join("file"), "two", "three").unwrap();
        let read = |path: PathBuf| fs::read_to_string(path).unwrap();
        assert_eq!(read(copy.join("file")), "one three");
        assert_eq!(read(original.join("file")), "one two");
        let error = change(&copy.join("file"), "two", "three").unwrap_err();
        assert!(error.to_string().contains("no 'two'"), "{error}");
    }
}
