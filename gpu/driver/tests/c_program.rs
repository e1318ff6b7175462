// SPDX-License-Identifier: MIT OR Apache-2.0
//! The example in C, built against an installed library as pkg-config and CMake say, and run with a driver that the loader finds by its name.

#![cfg(target_os = "linux")]

#[path = "../../../xtask/src/install/prefix.rs"]
#[allow(dead_code)]
mod prefix;
mod support;

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

fn source() -> PathBuf {
    root().join("examples/c/gpu_two_grains.c")
}

/// The static library, which cargo has built beside the tests: the newest, of those for other choices of packages.
fn static_library() -> PathBuf {
    let tests = std::env::current_exe().unwrap();
    let all = fs::read_dir(tests.parent().unwrap()).unwrap();
    let libraries = all.map(|entry| entry.unwrap().path()).filter(|path| {
        let name = path.file_name().unwrap().to_string_lossy();
        name.starts_with("libellgran_gpu-") && name.ends_with(".a")
    });
    let made = |path: &PathBuf| path.metadata().unwrap().modified().unwrap();
    libraries.max_by_key(made).expect("libellgran_gpu.a")
}

/// What the page says of the system's libraries, which the tests of consumers hold against what rustc says.
fn system_libraries() -> String {
    let page = fs::read_to_string(root().join("docs/library.md")).unwrap();
    let (_, block) = page.split_once("```text\n").expect("a block of libraries");
    block.lines().next().unwrap().to_owned()
}

/// A prefix with the libraries, and the driver in a directory of its own.
struct Installed {
    place: tempfile::TempDir,
}

impl Installed {
    fn new() -> Self {
        let place = tempfile::tempdir().unwrap();
        let drivers = place.path().join("driver");
        fs::create_dir(&drivers).unwrap();
        let driver = drivers.join("libcuda.so.1");
        fs::copy(support::stand_in(), &driver).unwrap();
        std::os::unix::fs::symlink(&driver, drivers.join("libcuda.so")).unwrap();
        let package = prefix::Package {
            version: env!("CARGO_PKG_VERSION"),
            description: "",
            system_libraries: &system_libraries(),
        };
        let prefix = place.path().join("prefix");
        let at = prefix::Place::in_lib(&prefix);
        // What stands for the library of the host is not linked: the other one has all of it.
        let empty = place.path().join("empty.a");
        fs::write(&empty, "!<arch>\n").unwrap();
        prefix::fill(&at, root(), &empty, &package).unwrap();
        prefix::add_gpu(&at, root(), &static_library(), &package).unwrap();
        Installed { place }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.place.path().join(name)
    }

    /// Where the driver's header is.
    fn driver_header() -> PathBuf {
        root().join("gpu/stand_in_driver/include")
    }

    /// Runs the program, which is to print what its source promises.
    fn collide(&self, program: &Path) {
        let printed = succeed(
            Command::new(program)
                .env_remove("ELLGRAN_GPU_DRIVER")
                .env("LD_LIBRARY_PATH", self.path("driver")),
        );
        assert_eq!(printed.trim(), promised(&source()));
        // The same line begins what the example on the host promises.
        let host = promised(&root().join("examples/c/two_grains.c"));
        assert!(host.starts_with(printed.trim()), "{host}");
    }
}

/// The line of the example that says what it prints.
fn promised(source: &Path) -> String {
    let text = fs::read_to_string(source).unwrap();
    let line = text
        .lines()
        .find(|l| l.starts_with(" * velocities after: ("));
    line.unwrap().trim_start_matches([' ', '*']).to_owned()
}

fn succeed(command: &mut Command) -> String {
    let output = command
        .output()
        .unwrap_or_else(|e| panic!("{command:?}: {e}"));
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}\n{printed}{said}");
    printed
}

/// Whether a tool is there. `cargo xtask test` installs all of them, and says that they must be.
fn is_there(tool: &str) -> bool {
    let there = Command::new(tool).arg("--version").output().is_ok();
    let must_be = std::env::var_os("ELLGRAN_REQUIRE_TOOLS").is_some();
    assert!(there || !must_be, "{tool} is missing");
    if !there {
        eprintln!("NOT TESTED: {tool} is missing (`cargo xtask test` installs what is needed)");
    }
    there
}

#[test]
fn two_grains_collide_as_on_the_host() {
    if !is_there("pkg-config") {
        return;
    }
    let installed = Installed::new();
    let ask = |words: &[&str]| {
        succeed(
            Command::new("pkg-config")
                .args(words)
                .arg("ellgran-gpu")
                .env("PKG_CONFIG_PATH", installed.path("prefix/lib/pkgconfig")),
        )
    };
    assert_eq!(ask(&["--modversion"]).trim(), env!("CARGO_PKG_VERSION"));
    let program = installed.path("gpu_two_grains");
    succeed(
        Command::new("cc")
            .args(["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror"])
            .arg("-I")
            .arg(Installed::driver_header())
            .arg(source())
            .args(ask(&["--cflags", "--libs"]).split_whitespace())
            .arg("-L")
            .arg(installed.path("driver"))
            .args(["-lcuda", "-o"])
            .arg(&program),
    );
    installed.collide(&program);
}

#[test]
fn a_cmake_project() {
    if !is_there("cmake") {
        return;
    }
    let installed = Installed::new();
    let build = installed.path("build");
    let define = |name: &str, value: &OsStr| {
        let mut all = std::ffi::OsString::from(format!("-D{name}="));
        all.push(value);
        all
    };
    succeed(
        Command::new("cmake")
            .arg("-S")
            .arg(root().join("gpu/driver/tests/cmake"))
            .arg("-B")
            .arg(&build)
            .arg(define(
                "CMAKE_PREFIX_PATH",
                installed.path("prefix").as_os_str(),
            ))
            .arg(define(
                "SOURCE",
                source().canonicalize().unwrap().as_os_str(),
            ))
            .arg(define(
                "CUDA_INCLUDE",
                Installed::driver_header()
                    .canonicalize()
                    .unwrap()
                    .as_os_str(),
            ))
            .arg(define(
                "CUDA_DRIVER",
                installed.path("driver/libcuda.so").as_os_str(),
            )),
    );
    succeed(Command::new("cmake").arg("--build").arg(&build));
    installed.collide(&build.join("gpu_two_grains"));
}
