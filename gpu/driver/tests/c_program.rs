// SPDX-License-Identifier: MIT OR Apache-2.0
//! The example in C, compiled and linked with the static library alone, and with a driver that the loader finds by its name.

#![cfg(target_os = "linux")]

mod support;

use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// The static library, which cargo has built beside the tests: the newest, of those for other choices of packages.
fn static_library() -> PathBuf {
    let tests = std::env::current_exe().unwrap();
    let all = std::fs::read_dir(tests.parent().unwrap()).unwrap();
    let libraries = all.map(|entry| entry.unwrap().path()).filter(|path| {
        let name = path.file_name().unwrap().to_string_lossy();
        name.starts_with("libellgran_gpu-") && name.ends_with(".a")
    });
    let made = |path: &PathBuf| path.metadata().unwrap().modified().unwrap();
    libraries.max_by_key(made).expect("libellgran_gpu.a")
}

/// The line of the example that says what it prints.
fn promised(source: &Path) -> String {
    let text = std::fs::read_to_string(source).unwrap();
    let line = text
        .lines()
        .find(|l| l.starts_with(" * velocities after: ("));
    line.unwrap().trim_start_matches([' ', '*']).to_owned()
}

#[test]
fn two_grains_collide_as_on_the_host() {
    let place = tempfile::tempdir().unwrap();
    let driver = place.path().join("libcuda.so.1");
    std::fs::copy(support::stand_in(), &driver).unwrap();
    std::os::unix::fs::symlink(&driver, place.path().join("libcuda.so")).unwrap();
    let source = root().join("examples/c/gpu_two_grains.c");
    let program = place.path().join("gpu_two_grains");
    let linked = Command::new("cc")
        .args(["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror"])
        .arg("-I")
        .arg(root().join("include"))
        .arg("-I")
        .arg(root().join("gpu/stand_in_driver/include"))
        .arg(&source)
        .arg(static_library())
        .arg("-L")
        .arg(place.path())
        .args(["-lcuda", "-lm", "-lpthread", "-ldl", "-o"])
        .arg(&program)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&linked.stderr);
    assert!(linked.status.success(), "{said}");
    let output = Command::new(&program)
        .env_remove("ELLGRAN_GPU_DRIVER")
        .env("LD_LIBRARY_PATH", place.path())
        .output()
        .unwrap();
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        output.status.success(),
        "{printed}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert_eq!(printed.trim(), promised(&source));
    // The same line begins what the example on the host promises.
    let host = promised(&root().join("examples/c/two_grains.c"));
    assert!(host.starts_with(printed.trim()), "{host}");
}
