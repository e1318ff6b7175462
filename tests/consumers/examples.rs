// SPDX-License-Identifier: MIT OR Apache-2.0
//! The programs of examples/: they compile without a warning and print what they say that they print.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use crate::emulator;
use crate::harness::{build, installed, root, scratch, succeed, tool, Language};
use crate::two_grains;

fn source(name: &str) -> PathBuf {
    root().join("examples").join("c").join(name)
}

/// What the comment at the top of a source shows as its output.
fn promised(name: &str) -> String {
    let text = fs::read_to_string(source(name)).expect("an example");
    let lines: Vec<&str> = text
        .lines()
        .skip_while(|line| !line.contains("Prints"))
        .skip_while(|line| !line.trim_start_matches(['*', '/', ' ']).is_empty())
        .take_while(|line| !line.contains("*/") && !line.starts_with("#include"))
        .map(|line| line.trim_start_matches([' ', '/', '*']))
        .filter(|line| !line.is_empty())
        .collect();
    assert!(lines.len() > 3, "{name} shows no output");
    lines.join("\n")
}

/// The same words, and numbers that differ by no more than another compiler's rounding.
fn assert_same(printed: &str, expected: &str, what: &str) {
    let words = |text: &str| -> Vec<String> {
        text.split(|c: char| c.is_whitespace() || "(),".contains(c))
            .filter(|word| !word.is_empty())
            .map(str::to_owned)
            .collect()
    };
    let (left, right) = (words(printed), words(expected));
    let same = left.len() == right.len()
        && left.iter().zip(&right).all(|(a, b)| {
            match (a.parse::<f64>(), b.parse::<f64>()) {
                // Half a unit in the last printed place of the smallest column, or of the fourth digit.
                (Ok(a), Ok(b)) => (a - b).abs() <= 0.002 + 2e-4 * b.abs(),
                _ => a == b,
            }
        });
    assert!(same, "{what}\nprints:\n{printed}\nand not:\n{expected}");
}

fn printed(name: &str, language: Language) -> String {
    let program = scratch(name).join("program");
    succeed(&mut build(language, &source(name), &program, &[]));
    succeed(&mut emulator::program(&program))
}

#[test]
fn two_grains_in_c_and_in_rust() {
    let c = printed("two_grains.c", Language::C99);
    assert_same(&c, &promised("two_grains.c"), "two_grains.c");
    let rust = two_grains::collide().expect("the collision");
    assert_same(&rust, &c, "two_grains.rs");
}

/// With the same libraries as a shared one, in a program without any shared library.
#[test]
#[cfg(target_os = "linux")]
fn two_grains_linked_statically() {
    let program = scratch("static").join("program");
    let mut link = build(
        Language::C99,
        &source("two_grains.c"),
        &program,
        &["-static"],
    );
    succeed(&mut link);
    let text = fs::read(&program).expect("the program");
    let interpreter = b"/ld-linux";
    assert!(
        !text.windows(interpreter.len()).any(|w| w == interpreter),
        "it asks for a dynamic loader"
    );
    let printed = succeed(&mut emulator::program(&program));
    assert_same(&printed, &promised("two_grains.c"), "two_grains.c -static");
}

/// The contact of the C example, by the library linked as pkg-config says.
#[test]
#[cfg(unix)]
fn one_contact_in_fortran() {
    // A compiler for another machine is not asked for.
    if std::env::var_os("CARGO_BUILD_TARGET").is_some() {
        return;
    }
    let Some(gfortran) = tool("gfortran") else {
        return;
    };
    let source = root().join("examples/fortran/one_contact.f90");
    let program = scratch("fortran").join("program");
    let installed = installed();
    succeed(
        Command::new(gfortran)
            .args(["-std=f2018", "-Wall", "-Wextra", "-pedantic", "-Werror"])
            // Where modules would go.
            .current_dir(scratch("fortran modules"))
            .arg(&source)
            .arg("-o")
            .arg(&program)
            .arg(installed.prefix.join("lib").join("libellgran.a"))
            .args(installed.system_libraries.split(' ')),
    );
    let text = succeed(&mut emulator::program(&program));
    let source = fs::read_to_string(source).expect("an example");
    let (_, said) = source.split_once("Prints: ").expect("what it prints");
    assert_same(text.trim(), said.lines().next().unwrap(), "one_contact.f90");
    // The same number as in C.
    let c = fs::read_to_string(root().join("examples/c/one_contact.c")).expect("an example");
    assert!(c.contains(said.lines().next().unwrap()));
}

#[test]
fn neighbour_list_in_cxx() {
    let cxx = printed("neighbour_list.cpp", Language::Cxx11);
    assert_same(&cxx, &promised("neighbour_list.cpp"), "neighbour_list.cpp");
}

#[test]
fn one_contact_in_c() {
    let text = printed("one_contact.c", Language::C99);
    let source = fs::read_to_string(source("one_contact.c")).expect("an example");
    let (_, said) = source.split_once("Prints: ").expect("what it prints");
    assert_same(text.trim(), said.lines().next().unwrap(), "one_contact.c");
}
