// SPDX-License-Identifier: MIT OR Apache-2.0
//! The kernels of `gpu/` as PTX: made with the pinned nightly, taken by NVIDIA's assembler, and held to their sources.

mod assembler;
mod bench;
mod names;
mod pack;
mod page;
mod sources;

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{bail, Context, Result};

use crate::process::{find_program, output_of, run_open};
use crate::progress::say;
use crate::workspace::{root, target_directory};

#[derive(clap::Args)]
pub struct Options {
    /// Write nothing: fail where what is made differs from what is committed
    #[arg(long)]
    check: bool,
    /// Time whole steps of packings on the GPU of this machine
    #[arg(long, conflicts_with = "check")]
    bench: bool,
    /// Put what times and tests the kernels into a directory, for a machine with a GPU and without a compiler
    #[arg(long, value_name = "DIRECTORY", conflicts_with_all = ["check", "bench"])]
    pack: Option<PathBuf>,
    /// Put LAMMPS for a GPU and its scenes there as well (half an hour on two cores)
    #[arg(long, requires = "pack")]
    lammps: bool,
}

/// What is committed: the features of `gpu/ptx` of which the compiler makes a module each, and what it makes of them.
const MODULES: [(&str, &str); 4] = [
    ("grains", "gpu/ptx/ellgran.ptx"),
    ("walls", "gpu/ptx/ellgran_walls.ptx"),
    ("meshes", "gpu/ptx/ellgran_meshes.ptx"),
    ("tallies", "gpu/ptx/ellgran_tallies.ptx"),
];
const PAGE: &str = "docs/gpu.md";
/// What was measured on a GPU.
const RESULTS: &str = "docs/bench/gpu/whole_step.csv";

/// The first lines of the committed PTX.
fn head(hash: &str) -> String {
    format!(
        "// SPDX-License-Identifier: MIT OR Apache-2.0\n\
         // Made by `cargo xtask gpu`; not to be edited.\n\
         // Sources: {hash}\n"
    )
}

/// Makes the PTX and the page about it, or compares them.
pub fn gpu(options: &Options) -> Result<()> {
    if options.bench {
        return bench::bench();
    }
    if let Some(directory) = &options.pack {
        return pack::pack(directory, options.lammps);
    }
    let head = head(&sources::hash()?);
    let made = |feature| Ok(head.clone() + &names::without_places(&build(feature)?)?);
    let modules: Vec<String> = MODULES
        .iter()
        .map(|(feature, _)| made(feature))
        .collect::<Result<_>>()?;
    let figures = assembler::figures(&modules)?;
    let results = fs::read_to_string(root().join(RESULTS)).unwrap_or_default();
    let page = page::page(&figures, &results);
    let names = MODULES.iter().map(|(_, name)| *name).chain([PAGE]);
    for (name, text) in names.zip(modules.iter().chain([&page])) {
        let path = root().join(name);
        if !options.check {
            fs::write(&path, text)?;
            say(format!("wrote {}", path.display()));
        } else if fs::read_to_string(&path).ok().as_ref() == Some(text) {
            say(format!("{name} is what the sources make"));
        } else {
            bail!("{name} differs from what the sources make: run `cargo xtask gpu`");
        }
    }
    Ok(())
}

/// Whether the committed PTX is of the present sources. Needs no nightly.
pub fn check_sources() -> Result<()> {
    let head = head(&sources::hash()?);
    for (_, name) in MODULES {
        let committed =
            fs::read_to_string(root().join(name)).with_context(|| format!("no {name}"))?;
        if !committed.starts_with(&head) {
            bail!(
                "{name} is not of the present sources: run `cargo xtask gpu`, which takes some minutes and installs the nightly that \
                 gpu/ptx/rust-toolchain.toml names"
            );
        }
        say(format!("{name} is of the present sources"));
    }
    // A dependency more or less in the core is one more or less there.
    let manifest = root().join("gpu/ptx/Cargo.toml");
    let mut cargo = crate::workspace::cargo();
    cargo
        .args([
            "metadata",
            "--locked",
            "--format-version",
            "1",
            "--manifest-path",
        ])
        .arg(&manifest);
    output_of(&mut cargo).context("gpu/ptx/Cargo.lock is not of the present manifests: run `cargo update --workspace` in gpu/ptx")?;
    Ok(())
}

/// The toolchain that `gpu/ptx/rust-toolchain.toml` names.
fn toolchain() -> Result<String> {
    let file = fs::read_to_string(root().join("gpu/ptx/rust-toolchain.toml"))?;
    file.lines()
        .find_map(|line| line.strip_prefix("channel = \""))
        .and_then(|rest| rest.strip_suffix('"'))
        .map(str::to_owned)
        .context("gpu/ptx/rust-toolchain.toml names no channel")
}

/// The PTX of the sources with a feature.
fn build(feature: &str) -> Result<String> {
    let rustup = find_program("rustup").context(
        "rustup, which installs the pinned nightly, is not there: see https://rustup.rs",
    )?;
    let toolchain = toolchain()?;
    let installed = output_of(Command::new(&rustup).args(["toolchain", "list"]))?;
    if !installed.lines().any(|line| line.starts_with(&toolchain)) {
        say(format!("installing {toolchain}"));
    }
    run_open(
        Command::new(&rustup)
            .args(["toolchain", "install", &toolchain, "--profile", "minimal"])
            .args([
                "-c",
                "rust-src",
                "-c",
                "llvm-bitcode-linker",
                "-c",
                "llvm-tools",
            ]),
    )?;
    let target: PathBuf = target_directory()?.join("ptx");
    let mut cargo = Command::new(&rustup);
    cargo
        .args(["run", &toolchain, "cargo", "build", "--release", "--locked"])
        .args(["--features", feature])
        .arg("--target-dir")
        .arg(&target)
        .current_dir(root().join("gpu/ptx"));
    // Set by `cargo run` for xtask itself, or for builds of the host.
    for (name, _) in std::env::vars_os() {
        let text = name.to_string_lossy();
        let of_cargo = text.starts_with("CARGO") && text != "CARGO_HOME";
        if of_cargo || text.starts_with("RUSTC") || text == "RUSTFLAGS" {
            cargo.env_remove(&name);
        }
    }
    cargo.env_remove("RUSTUP_TOOLCHAIN");
    run_open(&mut cargo)?;
    let made = target.join("nvptx64-nvidia-cuda/release/ellgran_ptx.ptx");
    fs::read_to_string(&made).with_context(|| format!("cannot read {}", made.display()))
}
