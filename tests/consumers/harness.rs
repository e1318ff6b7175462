// SPDX-License-Identifier: MIT OR Apache-2.0
//! An install prefix, compilers, and programs that are run.

use std::collections::BTreeSet;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;

use crate::prefix::{self, Place};

pub const STRICT: [&str; 4] = ["-Wall", "-Wextra", "-pedantic", "-Werror"];

pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

pub fn header() -> String {
    fs::read_to_string(root().join("include").join("ellgran.h")).expect("include/ellgran.h")
}

/// The header without its comments.
pub fn declarations() -> String {
    let header = header();
    let mut text = String::new();
    let mut rest = header.as_str();
    while let Some((before, after)) = rest.split_once("/*") {
        text.push_str(before);
        rest = after.split_once("*/").map_or("", |(_, rest)| rest);
    }
    text + rest
}

/// The functions of the header.
pub fn declared_functions() -> BTreeSet<String> {
    declarations()
        .split('(')
        .filter_map(|before| before.rsplit([' ', '*', '\n']).next())
        .filter(|name| name.starts_with("ellgran_"))
        .map(str::to_owned)
        .collect()
}

/// An empty directory of this test's own.
pub fn scratch(name: &str) -> PathBuf {
    let directory = temporary().join(name);
    let _ = fs::remove_dir_all(&directory);
    fs::create_dir_all(&directory).expect("a directory for the test");
    directory
}

fn temporary() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("consumers")
}

pub struct Installed {
    pub prefix: PathBuf,
    /// As rustc prints them but for the unwinder, whatever the packaging files say.
    pub system_libraries: String,
}

/// The prefix under test: the one that ELLGRAN_TEST_PREFIX names (`cargo xtask test` installs it), or one made here.
pub fn installed() -> &'static Installed {
    static INSTALLED: OnceLock<Installed> = OnceLock::new();
    INSTALLED.get_or_init(|| {
        // Beside the directory of the running tests: cargo keeps that one locked for others.
        let target = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name(prefix::TEST_PROFILE);
        let system_libraries =
            prefix::system_libraries(root(), &target, None).expect("the static library");
        let prefix = match std::env::var_os("ELLGRAN_TEST_PREFIX") {
            Some(prefix) => prefix.into(),
            None => install_and_move(&target, &system_libraries),
        };
        Installed {
            prefix,
            system_libraries,
        }
    })
}

/// A prefix must work wherever it is moved to.
fn install_and_move(target: &Path, system_libraries: &str) -> PathBuf {
    let first = scratch("first prefix");
    let built = match std::env::var_os("CARGO_BUILD_TARGET") {
        Some(triple) => target.join(triple),
        None => target.to_owned(),
    };
    let library = built.join(prefix::TEST_PROFILE).join("libellgran.a");
    let package = prefix::Package {
        version: env!("CARGO_PKG_VERSION"),
        description: env!("CARGO_PKG_DESCRIPTION"),
        system_libraries,
    };
    prefix::fill(&Place::in_lib(&first), root(), &library, &package).expect("an install prefix");
    let moved = temporary().join("prefix");
    let _ = fs::remove_dir_all(&moved);
    fs::rename(first, &moved).expect("the prefix moves");
    moved
}

/// The text that a file of the prefix holds.
pub fn installed_text(path: &str) -> String {
    let file = installed().prefix.join(path);
    fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()))
}

/// A program, if it is on this machine. Where all tools are promised (`cargo xtask test` installs them), its lack is a
/// failure; else it is said, past the test harness that would keep it to itself.
pub fn tool(name: &str) -> Option<PathBuf> {
    let found = std::env::var_os("PATH").and_then(|path| {
        std::env::split_paths(&path)
            .map(|directory| directory.join(name))
            .find(|candidate| candidate.is_file())
    });
    if found.is_none() {
        lacking(&format!("{name} is missing"));
    }
    found
}

pub fn lacking(what: &str) {
    let says = |name: &str, value: &str| std::env::var(name).is_ok_and(|v| v == value);
    assert!(
        !says("CI", "true") && !says("ELLGRAN_REQUIRE_TOOLS", "1"),
        "{what}, and must be there under CI=true or ELLGRAN_REQUIRE_TOOLS=1"
    );
    let test = std::thread::current().name().unwrap_or("test").to_owned();
    // In one piece: other tests write too.
    let line =
        format!("\nNOT TESTED: {test}: {what} (`cargo xtask test` installs what is needed)\n");
    let _ = std::io::stderr().write_all(line.as_bytes());
}

#[derive(Clone, Copy, PartialEq)]
pub enum Language {
    C99,
    Cxx11,
}

/// The compiler that the `cc` crate finds.
pub fn compiler(language: Language) -> Command {
    static HOST: OnceLock<String> = OnceLock::new();
    let host = HOST.get_or_init(|| {
        let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
        succeed(Command::new(rustc).arg("-vV"))
            .lines()
            .find_map(|line| line.strip_prefix("host: ").map(str::to_owned))
            .expect("rustc -vV names its host")
    });
    let mut command = cc::Build::new()
        .cpp(language == Language::Cxx11)
        .opt_level(1)
        .target(
            std::env::var("CARGO_BUILD_TARGET")
                .as_deref()
                .unwrap_or(host),
        )
        .host(host)
        .out_dir(temporary())
        .cargo_metadata(false)
        .get_compiler()
        .to_command();
    command.arg(match language {
        Language::C99 => "-std=c99",
        Language::Cxx11 => "-std=c++11",
    });
    command.args(STRICT);
    command
}

/// Compiles a source against the prefix and links the library.
pub fn build(language: Language, source: &Path, program: &Path, flags: &[&str]) -> Command {
    let installed = installed();
    let mut command = compiler(language);
    command
        .args(flags)
        .arg("-I")
        .arg(installed.prefix.join("include"))
        .arg(source)
        .arg("-o")
        .arg(program)
        .arg(installed.prefix.join("lib").join("libellgran.a"))
        .args(installed.system_libraries.split(' '));
    command
}

pub fn run(command: &mut Command) -> Output {
    command
        .stdin(Stdio::null())
        .output()
        .unwrap_or_else(|e| panic!("{command:?}: {e}"))
}

/// Standard output of a program that must succeed.
pub fn succeed(command: &mut Command) -> String {
    let output = run(command);
    assert!(
        output.status.success(),
        "{:?} {:?}: {}\n{}{}",
        command.get_program(),
        command.get_args().collect::<Vec<_>>(),
        output.status,
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// Both streams of a program that must fail.
pub fn fail(command: &mut Command) -> String {
    let output = run(command);
    let text = [output.stdout, output.stderr]
        .map(|bytes| String::from_utf8_lossy(&bytes).into_owned())
        .concat();
    assert!(
        !output.status.success(),
        "{command:?} must fail, and says\n{text}"
    );
    text
}
