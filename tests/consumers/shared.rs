// SPDX-License-Identifier: MIT OR Apache-2.0
//! The shared library: what it shows, and programs in C, of pkg-config and CMake, and in Python that use it.

#![cfg(target_os = "linux")]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use crate::emulator;
use crate::harness::{
    compiler, declared_functions, installed, root, scratch, succeed, tool, Language,
};
use crate::prefix::{self, Place};

/// A prefix with both libraries.
fn shared() -> &'static Path {
    static PREFIX: OnceLock<PathBuf> = OnceLock::new();
    PREFIX.get_or_init(|| {
        let directory = scratch("shared-prefix");
        install(&Place::in_lib(&directory));
        directory
    })
}

/// Both libraries.
fn install(place: &Place) {
    let library = installed().prefix.join("lib").join("libellgran.a");
    let package = prefix::Package {
        version: env!("CARGO_PKG_VERSION"),
        description: env!("CARGO_PKG_DESCRIPTION"),
        system_libraries: &installed().system_libraries,
    };
    prefix::fill(place, root(), &library, &package).expect("an install prefix");
    prefix::add_shared(place, root(), &package, compiler(Language::C99)).expect("a shared library");
}

/// A program that finds the library where it was linked.
fn run(program: &Path) -> String {
    succeed(emulator::program(program).env("LD_LIBRARY_PATH", shared().join("lib")))
}

fn is_the_overlap(text: &str) {
    let expected = format!("ellgran {}: 1 0.5", env!("CARGO_PKG_VERSION"));
    assert!(text.starts_with(&expected), "{text}");
}

#[test]
fn it_shows_the_functions_of_the_header_and_no_others() {
    let Some(nm) = tool("nm") else {
        return;
    };
    let library = shared().join("lib/libellgran.so");
    let text = succeed(
        Command::new(nm)
            .args(["-D", "--defined-only", "--format=posix"])
            .arg(library),
    );
    let shown: BTreeSet<&str> = text
        .lines()
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    let declared = declared_functions();
    let declared: BTreeSet<&str> = declared.iter().map(String::as_str).collect();
    assert!(declared.len() > 15);
    assert_eq!(shown, declared);
}

#[test]
fn its_name_is_that_of_the_binary_interface() {
    let Some(readelf) = tool("readelf") else {
        return;
    };
    let library = shared().join("lib/libellgran.so");
    let text = succeed(Command::new(readelf).arg("-d").arg(library));
    let name = format!(
        "libellgran.so.{}",
        ellgran::c_api::version::ELLGRAN_ABI_VERSION
    );
    let line = text.lines().find(|line| line.contains("SONAME"));
    assert!(line.is_some_and(|l| l.contains(&name)), "{text}");
}

#[test]
fn a_pkg_config_project_links_it() {
    let Some(pkg_config) = tool("pkg-config") else {
        return;
    };
    let flags = succeed(
        Command::new(pkg_config)
            .args(["--cflags", "--libs", "ellgran-shared"])
            .env("PKG_CONFIG_PATH", shared().join("lib/pkgconfig")),
    );
    let program = scratch("shared pkg-config").join("program");
    succeed(
        compiler(Language::C99)
            .arg(root().join("tests/consumers/cmake/from_c.c"))
            .arg("-o")
            .arg(&program)
            .args(flags.split_whitespace()),
    );
    is_the_overlap(&run(&program));
    // It does need the library.
    crate::harness::fail(emulator::program(&program).env_remove("LD_LIBRARY_PATH"));
}

/// A system may have its libraries deeper in the prefix, as Debian has.
#[test]
fn projects_find_both_libraries_in_another_directory() {
    let (Some(pkg_config), Some(cmake)) = (tool("pkg-config"), tool("cmake")) else {
        return;
    };
    let directory = scratch("another-libdir");
    let libdir = Path::new("lib/this-machine");
    install(&Place::new(&directory, libdir).expect("a relative directory"));
    let lib = directory.join(libdir);
    let source = root().join("tests/consumers/cmake");
    let run = |program: &Path| {
        is_the_overlap(&succeed(
            emulator::program(program).env("LD_LIBRARY_PATH", &lib),
        ));
    };
    for name in ["ellgran", "ellgran-shared"] {
        let flags = succeed(
            Command::new(&pkg_config)
                .args(["--cflags", "--libs", name])
                .env("PKG_CONFIG_PATH", lib.join("pkgconfig")),
        );
        let program = directory.join(name);
        succeed(
            compiler(Language::C99)
                .arg(source.join("from_c.c"))
                .arg("-o")
                .arg(&program)
                .args(flags.split_whitespace()),
        );
        run(&program);
    }
    for target in ["ellgran::ellgran", "ellgran::shared"] {
        let build = directory.join(target.replace(':', "_"));
        let mut configure = Command::new(&cmake);
        configure.arg("-S").arg(&source).arg("-B").arg(&build);
        configure.arg(format!("-DELLGRAN_TARGET={target}"));
        let package = lib.join("cmake/ellgran");
        configure.arg(format!("-Dellgran_DIR={}", package.display()));
        for (variable, language) in [("C", Language::C99), ("CXX", Language::Cxx11)] {
            let found = compiler(language);
            let name = found.get_program().to_string_lossy();
            configure.arg(format!("-DCMAKE_{variable}_COMPILER={name}"));
        }
        succeed(&mut configure);
        succeed(Command::new(&cmake).arg("--build").arg(&build));
        run(&build.join("from_c"));
    }
}

#[test]
fn a_directory_outside_the_prefix_is_refused() {
    for libdir in ["/usr/lib", "../lib", ""] {
        let refused = Place::new(Path::new("prefix"), Path::new(libdir)).err();
        let said = refused.map(|error| error.to_string()).unwrap_or_default();
        assert!(said.contains("relative to the prefix"), "{libdir}: {said}");
    }
}

#[test]
fn a_cmake_project_links_it() {
    let Some(cmake) = tool("cmake") else {
        return;
    };
    let build = scratch("shared cmake");
    let mut configure = Command::new(&cmake);
    configure
        .arg("-S")
        .arg(root().join("tests/consumers/cmake"))
        .arg("-B")
        .arg(&build)
        .arg("-DELLGRAN_TARGET=ellgran::shared")
        .arg(format!("-DCMAKE_PREFIX_PATH={}", shared().display()));
    for (variable, language) in [("C", Language::C99), ("CXX", Language::Cxx11)] {
        let found = compiler(language);
        let name = found.get_program().to_string_lossy();
        configure.arg(format!("-DCMAKE_{variable}_COMPILER={name}"));
    }
    succeed(&mut configure);
    succeed(Command::new(&cmake).arg("--build").arg(&build));
    for program in ["from_c", "from_cxx"] {
        is_the_overlap(&run(&build.join(program)));
    }
}

#[test]
fn python_loads_it() {
    // A library for another machine is none for this one's Python.
    if std::env::var_os("CARGO_BUILD_TARGET").is_some() {
        return;
    }
    let Some(python) = tool("python3") else {
        return;
    };
    let text = succeed(
        Command::new(python)
            .arg(root().join("examples/python/overlap.py"))
            .arg(shared().join("lib/libellgran.so")),
    );
    is_the_overlap(&text);
}
