// SPDX-License-Identifier: MIT OR Apache-2.0
//! What pkg-config and CMake say of an installed library, and what is said of the system's libraries.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use crate::emulator;
use crate::harness::{
    compiler, fail, header, installed, installed_text, root, scratch, succeed, tool, Language,
};
use crate::pages::all_blocks;

#[test]
fn the_installed_header_is_the_committed_one() {
    assert_eq!(installed_text("include/ellgran.h"), header());
}

#[test]
fn nothing_is_left_open_in_the_packaging_files() {
    for path in [
        "lib/pkgconfig/ellgran.pc",
        "lib/cmake/ellgran/ellgran-config.cmake",
        "lib/cmake/ellgran/ellgran-config-version.cmake",
    ] {
        let text = installed_text(path);
        assert!(!text.contains('@'), "{path}:\n{text}");
        let prefix = installed().prefix.display().to_string();
        assert!(!text.contains(&prefix), "{path} cannot be moved:\n{text}");
    }
}

fn libraries(list: &str) -> BTreeSet<&str> {
    list.split(|c: char| c.is_whitespace() || c == ';')
        .filter(|word| word.starts_with("-l") && *word != "-lellgran")
        .collect()
}

#[test]
fn the_system_libraries_are_those_that_rustc_names() {
    let expected = libraries(&installed().system_libraries);
    assert!(expected.len() > 1, "{expected:?}");
    let pc = installed_text("lib/pkgconfig/ellgran.pc");
    let line = pc.lines().find_map(|l| l.strip_prefix("Libs: "));
    assert_eq!(
        libraries(line.expect("Libs")),
        expected,
        "ellgran.pc against rustc"
    );
    let cmake = installed_text("lib/cmake/ellgran/ellgran-config.cmake");
    let list = cmake
        .split_once("INTERFACE_LINK_LIBRARIES \"")
        .and_then(|(_, rest)| rest.split_once('"'))
        .map(|(list, _)| list);
    assert_eq!(
        libraries(list.expect("INTERFACE_LINK_LIBRARIES")),
        expected,
        "ellgran-config.cmake against rustc"
    );
}

/// The fenced block that follows "System libraries:".
#[test]
#[cfg(target_os = "linux")]
fn the_page_names_the_same_system_libraries() {
    let page = fs::read_to_string(root().join("docs/library.md")).expect("docs/library.md");
    let (_, after) = page
        .split_once("System libraries:")
        .expect("docs/library.md: 'System libraries:'");
    assert_eq!(
        libraries(&all_blocks(after)[0].text),
        libraries(&installed().system_libraries),
        "docs/library.md against rustc"
    );
}

#[test]
fn a_pkg_config_project() {
    let Some(pkg_config) = tool("pkg-config") else {
        return;
    };
    let ask = |words: &[&str]| {
        succeed(
            Command::new(&pkg_config)
                .args(words)
                .arg("ellgran")
                .env("PKG_CONFIG_PATH", installed().prefix.join("lib/pkgconfig")),
        )
    };
    assert_eq!(ask(&["--modversion"]).trim(), env!("CARGO_PKG_VERSION"));
    let program = scratch("pkg-config").join("program");
    succeed(
        compiler(Language::C99)
            .arg(root().join("tests/consumers/cmake/from_c.c"))
            .arg("-o")
            .arg(&program)
            .args(ask(&["--cflags", "--libs"]).split_whitespace()),
    );
    prints_the_overlap(&program);
}

fn prints_the_overlap(program: &Path) {
    let text = succeed(&mut emulator::program(program));
    let expected = format!("ellgran {}: 1 0.5", env!("CARGO_PKG_VERSION"));
    assert!(text.starts_with(&expected), "{text}");
}

fn configure(cmake: &Path, build: &Path, version: &str) -> Command {
    let mut command = Command::new(cmake);
    command
        .arg("-S")
        .arg(root().join("tests/consumers/cmake"))
        .arg("-B")
        .arg(build)
        .arg(format!("-DWANTED_VERSION={version}"))
        .arg(format!(
            "-DCMAKE_PREFIX_PATH={}",
            installed().prefix.display()
        ));
    for (variable, language) in [("C", Language::C99), ("CXX", Language::Cxx11)] {
        let found = compiler(language);
        let name = found.get_program().to_string_lossy();
        command.arg(format!("-DCMAKE_{variable}_COMPILER={name}"));
    }
    command
}

#[test]
fn a_cmake_project() {
    let Some(cmake) = tool("cmake") else {
        return;
    };
    let build = scratch("cmake");
    let (series, _) = env!("CARGO_PKG_VERSION")
        .rsplit_once('.')
        .expect("a version");
    succeed(&mut configure(&cmake, &build, series));
    succeed(Command::new(&cmake).arg("--build").arg(&build));
    prints_the_overlap(&build.join("from_c"));
    prints_the_overlap(&build.join("from_cxx"));
}

#[test]
fn cmake_refuses_another_version() {
    let Some(cmake) = tool("cmake") else {
        return;
    };
    for version in ["0.0.1", "0.99", "99.0"] {
        let text = fail(&mut configure(&cmake, &scratch("cmake refuses"), version));
        assert!(text.contains(env!("CARGO_PKG_VERSION")), "{text}");
    }
}
