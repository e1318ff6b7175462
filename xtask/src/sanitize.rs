// SPDX-License-Identifier: MIT OR Apache-2.0
//! Memory and undefined behaviour: the C interface in Miri and under AddressSanitizer, C and C++ programs under AddressSanitizer and
//! UndefinedBehaviorSanitizer, LAMMPS with the plugin in valgrind, and coverage-guided fuzzing. Not part of `cargo xtask test`: it takes a
//! nightly compiler, and minutes. What fuzzing finds becomes a seed, which `cargo test` runs on a stable compiler.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use anyhow::{bail, Context, Result};

use crate::process::{find_program, output_of, run_logged, run_open, run_visible};
use crate::progress::{human_time, say};
use crate::workspace::{cargo, root, target_directory};
use crate::{lammps, plugin, setup};

/// Tests of the C interface that Miri ends within minutes: those of pointers, of structs that grow, and of lists that change. What adds
/// numbers for long is left out: Miri is some thousand times slower than a processor.
const IN_MIRI: [&str; 5] = [
    "growing",
    "list_changes",
    "lists::shapes_in_an_array_of_structures",
    "null_pointers",
    "what_is_not_recorded_is_said",
];

/// Bytes of the longest input.
const LONGEST_INPUT: usize = 2048;
/// Seconds that an input may take, some thousand times what it does: more is a hang.
const LONGEST_TIME: usize = 20;

#[derive(clap::Args)]
pub struct Options {
    /// These parts alone; then what one of them needs must be there
    #[arg(long, value_enum, value_delimiter = ',', value_name = "PARTS")]
    only: Vec<Part>,
    /// For each fuzzed entry, on one core
    #[arg(long, default_value_t = 2.0)]
    minutes: f64,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Part {
    /// The C interface in Miri
    Miri,
    /// The C interface under AddressSanitizer, and C and C++ programs that link it
    Address,
    /// LAMMPS with the plugin in valgrind
    Valgrind,
    /// The entries of fuzz/ on any bytes
    Fuzz,
}

impl Part {
    const ALL: [Part; 4] = [Part::Miri, Part::Address, Part::Valgrind, Part::Fuzz];

    fn title(self) -> &'static str {
        match self {
            Part::Miri => "the C interface in Miri",
            Part::Address => "the C interface and its programs under sanitizers",
            Part::Valgrind => "LAMMPS with the plugin in valgrind",
            Part::Fuzz => "the C interface on any bytes",
        }
    }

    /// Installs what the part needs, where that can be had.
    fn provide(self) -> Result<()> {
        match self {
            Part::Miri => nightly(&["miri", "rust-src"]).map(|_| ()),
            Part::Address => nightly(&[]).map(|_| ()),
            Part::Valgrind => setup::valgrind(),
            Part::Fuzz => nightly(&[]).and_then(|_| cargo_fuzz()),
        }
    }

    /// What was done, in a line.
    fn run(self, options: &Options) -> Result<String> {
        match self {
            Part::Miri => miri(),
            Part::Address => address(),
            Part::Valgrind => valgrind(),
            Part::Fuzz => fuzz(options),
        }
    }
}

/// Fails at the first finding. A part whose tools are not to be had is skipped, and said, unless it is asked for by name.
pub fn sanitize(options: &Options) -> Result<()> {
    setup::setup()?;
    let mut summary: Vec<(Option<Duration>, &str, String)> = Vec::new();
    for part in Part::ALL {
        let title = part.title();
        if !(options.only.is_empty() || options.only.contains(&part)) {
            summary.push((None, title, "not asked for".into()));
            continue;
        }
        say(format!("== {title}"));
        if let Err(why) = part.provide() {
            if !options.only.is_empty() {
                return Err(why);
            }
            say(format!("SKIPPED: {title}: {why:#}"));
            summary.push((None, title, format!("SKIPPED: {why:#}")));
            continue;
        }
        let started = Instant::now();
        let done = part.run(options)?;
        summary.push((Some(started.elapsed()), title, done));
    }
    say("== summary");
    for (time, title, done) in summary {
        let time = time.map_or("-".into(), human_time);
        say(format!("{time:>14}  {title}: {done}"));
    }
    Ok(())
}

/// cargo of the nightly toolchain, with these components.
fn nightly(components: &[&str]) -> Result<Command> {
    if find_program("rustup").is_none() {
        bail!("there is no rustup here, which would have the nightly compiler that this needs");
    }
    let installed =
        output_of(Command::new("rustup").args(["+nightly", "component", "list", "--installed"]))
            .context("there is no nightly toolchain: rustup toolchain install nightly")?;
    let missing: Vec<&str> = components
        .iter()
        .copied()
        .filter(|component| !installed.lines().any(|line| line.starts_with(component)))
        .collect();
    if !missing.is_empty() {
        run_visible(
            Command::new("rustup")
                .args(["+nightly", "component", "add"])
                .args(&missing),
        )
        .with_context(|| format!("the nightly toolchain lacks {}", missing.join(", ")))?;
    }
    let mut command = Command::new("rustup");
    command
        .args(["run", "nightly", "cargo"])
        .current_dir(root())
        // Those of the compiler that runs us.
        .env_remove("CARGO")
        .env_remove("RUSTC")
        .env_remove("RUSTUP_TOOLCHAIN");
    Ok(command)
}

/// Installs cargo-fuzz, if it is not there.
fn cargo_fuzz() -> Result<()> {
    if find_program("cargo-fuzz").is_some() {
        return Ok(());
    }
    // It starts compilers and no more: it need not be fast.
    run_visible(cargo().args(["install", "--debug", "--locked", "cargo-fuzz"]))
        .context("cargo-fuzz is missing, and could not be installed")
}

fn log(name: &str) -> Result<PathBuf> {
    Ok(target_directory()?
        .join("sanitize")
        .join(format!("{name}.log")))
}

/// Runs tests, shown as they end; how many passed.
fn tests(command: &mut Command, name: &str) -> Result<usize> {
    let mut passed = 0;
    run_logged(command, &log(name)?, |line| {
        if line.starts_with("test ") {
            eprintln!("{line}");
        }
        if let Some(counts) = line.strip_prefix("test result: ok. ") {
            let count = counts.split(' ').next().and_then(|n| n.parse().ok());
            passed += count.unwrap_or(0_usize);
        }
    })?;
    if passed == 0 {
        bail!("no test was run");
    }
    Ok(passed)
}

/// The scalar path: Miri has no AVX.
fn miri() -> Result<String> {
    let passed = tests(
        nightly(&[])?
            .args(["miri", "test", "--package", "ellgran"])
            .args(["--test", "c_abi", "--"])
            .args(IN_MIRI)
            .env("ELLGRAN_INSTRUCTION_SET", "scalar")
            .env(
                "MIRIFLAGS",
                "-Zmiri-env-forward=ELLGRAN_INSTRUCTION_SET -Zmiri-strict-provenance",
            )
            .env("CARGO_TARGET_DIR", target_directory()?.join("miri")),
        "miri",
    )?;
    Ok(format!("{passed} tests, no undefined behaviour"))
}

fn host() -> Result<String> {
    let version = output_of(Command::new("rustc").arg("-vV"))?;
    let host = version.lines().find_map(|line| line.strip_prefix("host: "));
    Ok(host.context("rustc -vV names no host")?.to_owned())
}

/// The static library among what cargo built, by its messages.
fn static_library(messages: &str) -> Option<PathBuf> {
    let artifacts = messages
        .lines()
        .filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok())
        .filter(|message| message["target"]["name"] == "ellgran");
    let files = artifacts.flat_map(|m| m["filenames"].as_array().cloned().unwrap_or_default());
    files
        .filter_map(|file| file.as_str().map(PathBuf::from))
        .find(|file| file.extension().is_some_and(|e| e == "a"))
}

/// Three ways: the library and the tests that call it as C does, all compiled with the sanitizer; a C and a C++ program that link the library
/// so compiled; and C and C++ programs, compiled with both sanitizers, that link the library as users have it
/// (tests/consumers/sanitizer.rs).
fn address() -> Result<String> {
    let (host, target) = (host()?, target_directory()?.join("address"));
    let of_tests = || -> Result<Command> {
        let mut command = nightly(&[])?;
        command
            .args(["test", "--package", "ellgran", "--target", &host])
            .args(["--test", "c_abi", "--test", "fuzz_seeds"])
            .env("RUSTFLAGS", "-Zsanitizer=address")
            .env("ASAN_OPTIONS", "detect_leaks=1")
            .env("CARGO_TARGET_DIR", &target);
        Ok(command)
    };
    let passed = tests(&mut of_tests()?, "address")?;
    // Built already: cargo says where.
    let said = output_of(of_tests()?.args(["--no-run", "--message-format=json"]))?;
    let library = static_library(&said).context("cargo names no library for C")?;
    let programs = [("cc", "two_grains.c"), ("c++", "neighbour_list.cpp")];
    for (compiler, source) in programs {
        let program = target.join(source).with_extension("out");
        run_open(
            Command::new(compiler)
                .args(["-g", "-O1", "-fsanitize=address,undefined"])
                .args(["-fno-sanitize-recover=all", "-I"])
                .arg(root().join("include"))
                .arg(root().join("examples/c").join(source))
                .arg("-o")
                .arg(&program)
                .arg(&library)
                .args(["-lm", "-lpthread", "-ldl"]),
        )?;
        output_of(Command::new(&program).env("ASAN_OPTIONS", "detect_leaks=1"))?;
    }
    let as_installed = tests(
        cargo()
            .args(["test", "--package", "ellgran", "--test", "consumers"])
            .args(["--", "sanitizer"])
            .env("ELLGRAN_REQUIRE_TOOLS", "1"),
        "consumers",
    )?;
    Ok(format!(
        "{passed} tests and {} programs with the library compiled for AddressSanitizer, {as_installed} tests of programs that link it as \
         installed, no error",
        programs.len()
    ))
}

/// Any error, and any block of memory to which no pointer is left, fails. Nothing is suppressed.
fn valgrind() -> Result<String> {
    let source = lammps::source()?;
    let (program, plugin) = (source.binary()?, plugin::plugin(&source)?);
    let directory = tempfile::tempdir()?;
    let variable = |name: &str, value: PathBuf| {
        ["-var".into(), name.into(), value.display().to_string()] as [String; 3]
    };
    let deck = "tests/sanitize/pairs_walls_mesh_insertion.lmp";
    run_open(
        Command::new("valgrind")
            .args(["--error-exitcode=9", "--keep-debuginfo=yes"])
            .args(["--leak-check=full", "--errors-for-leak-kinds=definite"])
            .args(["--show-leak-kinds=definite", "--num-callers=30"])
            .arg(program)
            .args(["-nocite", "-log", "none", "-in"])
            .arg(root().join(deck))
            .args(variable("plugin", plugin))
            .args(variable("stl", root().join("examples/lammps/paddle.stl")))
            .env("OMP_NUM_THREADS", "1")
            .current_dir(directory.path()),
    )?;
    Ok(format!(
        "{deck}, no error and no lost memory, nothing suppressed"
    ))
}

/// The programs of fuzz/, by name.
fn entries(directory: &Path) -> Result<Vec<String>> {
    let mut names = Vec::new();
    for file in fs::read_dir(directory.join("programs"))? {
        let path = file?.path();
        let name = path.file_stem().context("a program without a name")?;
        names.push(name.to_string_lossy().into_owned());
    }
    names.sort();
    Ok(names)
}

/// New inputs go to fuzz/corpus, findings to fuzz/artifacts.
fn fuzz(options: &Options) -> Result<String> {
    let directory = root().join("fuzz");
    let (mut inputs, mut times) = (0, 0);
    let names = entries(&directory)?;
    for name in &names {
        let (corpus, seeds) = (
            directory.join("corpus").join(name),
            directory.join("seeds").join(name),
        );
        fs::create_dir_all(&corpus)?;
        say(format!("fuzzing {name}"));
        let mut command = nightly(&[])?;
        command
            .args(["fuzz", "run", "--fuzz-dir"])
            .arg(&directory)
            .arg(name)
            .args([&corpus, &seeds])
            .args(["--", "-print_final_stats=1"])
            .arg(format!("-timeout={LONGEST_TIME}"))
            .arg(format!("-max_len={LONGEST_INPUT}"))
            .arg(format!("-max_total_time={}", seconds(options)));
        let mut executed = 0_u64;
        run_logged(&mut command, &log(name)?, |line| {
            if let Some(count) = line.strip_prefix("stat::number_of_executed_units:") {
                executed = count.trim().parse().unwrap_or(0);
            }
        })
        .with_context(|| found(&directory, name))?;
        say(format!("  {executed} inputs in {} s", seconds(options)));
        inputs += executed;
        times += seconds(options);
    }
    Ok(format!(
        "{} entries, {inputs} inputs in {times} s, no finding",
        names.len()
    ))
}

fn seconds(options: &Options) -> u64 {
    (60.0 * options.minutes).ceil() as u64
}

fn found(directory: &Path, name: &str) -> String {
    format!(
        "a finding may be in {}. `ELLGRAN_FUZZ_SHOW=1 cargo +nightly fuzz run {name} FILE` says what it is. Mend it, and put the file \
         among those of {}, which `cargo test --test fuzz_seeds` runs",
        directory.join("artifacts").join(name).display(),
        directory.join("seeds").join(name).display()
    )
}
