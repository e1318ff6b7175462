// SPDX-License-Identifier: MIT OR Apache-2.0
//! The C and C++ examples under AddressSanitizer, its leak check and UndefinedBehaviorSanitizer; and programs that are
//! wrong, to see that these are on.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::harness::{build, compiler, fail, lacking, root, run, scratch, succeed, Language};

const FLAGS: [&str; 3] = [
    "-g",
    "-fsanitize=address,undefined",
    "-fno-sanitize-recover=all",
];

fn sanitized(program: &Path) -> Command {
    let mut command = Command::new(program);
    command.env("ASAN_OPTIONS", "detect_leaks=1:abort_on_error=0");
    command
}

/// A directory for the test, if the compiler has the sanitizers.
fn available(language: Language, name: &str) -> Option<PathBuf> {
    let directory = scratch(name);
    let source = directory.join("empty.c");
    std::fs::write(&source, "int main() { return 0; }\n").expect("a source");
    let program = directory.join("empty");
    let mut command = compiler(language);
    command.args(FLAGS).arg(&source).arg("-o").arg(&program);
    if language == Language::C99 {
        command.arg("-Wno-strict-prototypes");
    }
    let works =
        run(&mut command).status.success() && run(&mut sanitized(&program)).status.success();
    if !works {
        lacking("a compiler with -fsanitize=address,undefined is missing");
    }
    works.then_some(directory)
}

fn examples_pass(language: Language, name: &str) {
    let Some(directory) = available(language, &format!("sanitized {name}")) else {
        return;
    };
    let source = root().join("examples").join("c").join(name);
    let program = directory.join("program");
    succeed(&mut build(language, &source, &program, &FLAGS));
    succeed(&mut sanitized(&program));
}

#[test]
fn the_c_example_is_clean() {
    examples_pass(Language::C99, "two_grains.c");
}

#[test]
fn the_cxx_example_is_clean() {
    examples_pass(Language::Cxx11, "neighbour_list.cpp");
}

fn is_caught(name: &str, report: &str) {
    let Some(directory) = available(Language::C99, &format!("sanitized {name}")) else {
        return;
    };
    let source = root().join("tests/consumers/sanitizer").join(name);
    let program = directory.join("program");
    succeed(&mut build(Language::C99, &source, &program, &FLAGS));
    let text = fail(&mut sanitized(&program));
    assert!(text.contains(report), "{text}");
}

#[test]
fn an_overflow_is_caught() {
    is_caught("overflow.c", "AddressSanitizer: heap-buffer-overflow");
}

#[test]
#[cfg(target_os = "linux")]
fn a_leak_of_the_librarys_memory_is_caught() {
    is_caught("leak.c", "LeakSanitizer: detected memory leaks");
}
