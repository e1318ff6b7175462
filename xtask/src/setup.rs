// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which tools and headers are missing on this machine, and the one command that installs them.

use std::process::{Command, Stdio};

use anyhow::{bail, Result};

use crate::process::{find_program, output_of, run_visible};
use crate::progress::say;

/// A tool or header, and the Debian package that brings it.
struct Need {
    what: &'static str,
    package: &'static str,
    present: fn() -> bool,
}

const NEEDS: &[Need] = &[
    Need {
        what: "g++",
        package: "g++",
        present: || find_program("g++").is_some(),
    },
    Need {
        what: "make",
        package: "make",
        present: || find_program("make").is_some(),
    },
    Need {
        what: "cmake",
        package: "cmake",
        present: || find_program("cmake").is_some(),
    },
    Need {
        what: "ninja",
        package: "ninja-build",
        present: || find_program("ninja").is_some(),
    },
    Need {
        what: "xz",
        package: "xz-utils",
        present: || find_program("xz").is_some(),
    },
    Need {
        what: "pkg-config",
        package: "pkg-config",
        present: || find_program("pkg-config").is_some(),
    },
    Need {
        what: "mpicc and mpi.h",
        package: "libmpich-dev",
        present: mpi_compiles,
    },
    Need {
        what: "mpirun",
        package: "mpich",
        present: || find_program("mpirun").is_some(),
    },
];

/// To build and run C and C++ programs of AArch64 on another machine.
const AARCH64_NEEDS: &[Need] = &[
    Need {
        what: "aarch64-linux-gnu-g++",
        package: "g++-aarch64-linux-gnu",
        present: || find_program("aarch64-linux-gnu-g++").is_some(),
    },
    Need {
        what: "qemu-aarch64",
        package: "qemu-user",
        present: || find_program("qemu-aarch64").is_some(),
    },
];

/// To make virtual environments.
const PYTHON_NEEDS: &[Need] = &[Need {
    what: "python3 with venv and pip",
    package: "python3-venv",
    present: python_makes_environments,
}];

/// To build the example in Fortran.
const FORTRAN_NEEDS: &[Need] = &[Need {
    what: "gfortran",
    package: "gfortran",
    present: || find_program("gfortran").is_some(),
}];

/// To look for errors of memory in an engine.
const VALGRIND_NEEDS: &[Need] = &[Need {
    what: "valgrind",
    package: "valgrind",
    present: || find_program("valgrind").is_some(),
}];

/// To draw shaded pictures.
const RENDERER_NEEDS: &[Need] = &[
    Need {
        what: "povray",
        package: "povray",
        present: || find_program("povray").is_some(),
    },
    Need {
        what: "cwebp and img2webp",
        package: "webp",
        present: || find_program("cwebp").is_some() && find_program("img2webp").is_some(),
    },
];

/// To look at the documentation site's pages.
const BROWSER_NEEDS: &[Need] = &[Need {
    what: "a browser without a screen",
    package: "chromium-headless-shell",
    present: crate::site::has_browser,
}];

/// Installs what is missing as root; otherwise fails with the command for the user to run.
pub fn setup() -> Result<()> {
    provide(NEEDS)
}

/// The same for the cross compiler and the emulator.
pub fn aarch64() -> Result<()> {
    provide(AARCH64_NEEDS)
}

/// The same for Python and its virtual environments.
pub fn python() -> Result<()> {
    provide(PYTHON_NEEDS)
}

/// The same for Fortran.
pub fn fortran() -> Result<()> {
    provide(FORTRAN_NEEDS)
}

/// The same for valgrind.
pub fn valgrind() -> Result<()> {
    provide(VALGRIND_NEEDS)
}

/// The same for the renderer.
pub fn renderer() -> Result<()> {
    provide(RENDERER_NEEDS)
}

/// The same for the browser.
pub fn browser() -> Result<()> {
    provide(BROWSER_NEEDS)
}

fn provide(needs: &[Need]) -> Result<()> {
    let missing: Vec<&Need> = needs.iter().filter(|need| !(need.present)()).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let names: Vec<&str> = missing.iter().map(|need| need.what).collect();
    let mut packages: Vec<&str> = missing.iter().map(|need| need.package).collect();
    if is_open_mpi() {
        // A second MPI beside the one that is there would mix compilers of one with the launcher of the other.
        for package in &mut packages {
            *package = match *package {
                "libmpich-dev" => "libopenmpi-dev",
                "mpich" => "openmpi-bin",
                other => other,
            };
        }
    }
    let names = names.join(", ");
    let packages = packages.join(" ");
    if find_program("apt-get").is_none() {
        bail!("missing: {names}. There is no apt-get here: install them with this system's own packages (in Debian they are in: {packages})");
    }
    if !is_root() {
        bail!("missing: {names}. Run\n  sudo apt-get update && sudo apt-get install -y --no-install-recommends {packages}\nand start again");
    }
    say(format!("missing: {names}; installing {packages}"));
    run_visible(apt_get().arg("update"))?;
    run_visible(
        apt_get()
            .args(["install", "-y", "--no-install-recommends"])
            .args(packages.split(' ')),
    )?;
    match needs.iter().find(|need| !(need.present)()) {
        None => Ok(()),
        Some(need) => bail!(
            "{} is still missing after {} was installed",
            need.what,
            need.package
        ),
    }
}

fn apt_get() -> Command {
    let mut command = Command::new("apt-get");
    command.env("DEBIAN_FRONTEND", "noninteractive");
    command
}

fn is_root() -> bool {
    output_of(Command::new("id").arg("-u")).is_ok_and(|text| text.trim() == "0")
}

/// mpicc may be there without its headers, so something is compiled.
fn mpi_compiles() -> bool {
    find_program("mpicxx").is_some()
        && Command::new("mpicc")
            .args(["-E", "-include", "mpi.h", "-x", "c", "/dev/null"])
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .is_ok_and(|status| status.success())
}

/// Debian ships python3 without what `python3 -m venv` copies.
fn python_makes_environments() -> bool {
    output_of(Command::new("python3").args(["-c", "import ensurepip, venv"])).is_ok()
}

fn is_open_mpi() -> bool {
    // `--showme` is Open MPI's wrapper's own word; mpich's passes it on to the compiler, which refuses it.
    output_of(Command::new("mpicc").arg("--showme:version")).is_ok()
        || output_of(Command::new("mpirun").arg("--version"))
            .is_ok_and(|text| text.contains("Open MPI") || text.contains("OpenRTE"))
}
