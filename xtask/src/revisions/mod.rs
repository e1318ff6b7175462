// SPDX-License-Identifier: MIT OR Apache-2.0
//! The library of any revision since its C interface has walls of shapes, built beside the one of this checkout, and a program that
//! plays the same scenes to both ([`scene`]): for results ([`trajectories`]) and for times (`bench --against`).

pub mod kinds;
pub mod scene;
pub mod trajectories;

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{bail, Context, Result};

use crate::process::{output_of, run_logged};
use crate::progress::Progress;
use crate::{cache, library, tarball, workspace};

/// A library, and the sources that go with it.
pub struct Revision {
    /// What to call it in a table.
    pub name: String,
    /// `libellgran.a`.
    pub library: PathBuf,
    /// The directory of `include` and `lammps-plugin`.
    pub sources: PathBuf,
}

/// What the build of a library of another revision needs.
const MEGABYTES: u64 = 1500;

impl Revision {
    /// Of this checkout as it is now, with what is not committed.
    pub fn here() -> Result<Self> {
        Ok(Revision {
            name: "this checkout".into(),
            library: library::library()?,
            sources: workspace::root(),
        })
    }

    /// Of a revision by any name that git knows it by. It is built in a directory of its own in the cache, of which the library and the
    /// adapters' sources stay.
    pub fn of(name: &str) -> Result<Self> {
        let commit = format!("{name}^{{commit}}");
        let hash = output_of(git().args([
            "rev-parse",
            "--verify",
            "--quiet",
            "--end-of-options",
            &commit,
        ]))
        .with_context(|| format!("git knows no revision '{name}'"))?;
        let hash = hash.trim();
        let compiler = output_of(Command::new("rustc").arg("--version"))?;
        let flags = std::env::var("RUSTFLAGS").unwrap_or_default();
        let key = cache::key(&[hash, &compiler, &flags]);
        let _lock = cache::lock(&format!("revision-{key}"))?;
        let kept = cache::directory()?.join("revisions").join(&key);
        if !cache::stamp(&kept).is_file() {
            build(hash, &kept)?;
        }
        Ok(Revision {
            name: format!("{} ({name})", &hash[..10.min(hash.len())]),
            library: kept.join("libellgran.a"),
            sources: kept,
        })
    }

    /// The program that plays scenes, compiled against this revision's header.
    pub fn player(&self, directory: &Path) -> Result<PathBuf> {
        let include = self.sources.join("include");
        let header = include.join("ellgran.h");
        let text = fs::read_to_string(&header)
            .with_context(|| format!("cannot read {}", header.display()))?;
        let program = directory.join("player");
        let mut command = Command::new(std::env::var_os("CC").unwrap_or_else(|| "cc".into()));
        command
            // Nothing is fused where one revision's compiler line could differ from another's.
            .args(["-std=c99", "-O2", "-ffp-contract=off"])
            .args(definitions(&text)?)
            .arg("-I")
            .arg(&include)
            .arg(workspace::root().join("xtask/src/revisions/player.c"))
            .arg("-o")
            .arg(&program)
            .arg(&self.library)
            .args(["-lpthread", "-lm"]);
        if cfg!(target_os = "linux") {
            command.arg("-ldl");
        }
        output_of(&mut command).with_context(|| {
            format!(
                "the scenes cannot be played to {}: its C interface is another one",
                self.name
            )
        })?;
        Ok(program)
    }
}

/// What the program has to be told about older headers.
fn definitions(header: &str) -> Result<Vec<&'static str>> {
    if !header.contains("ELLGRAN_INIT") {
        bail!("its C interface is older than structs with sizes (ELLGRAN_INIT): scenes cannot be played to it");
    }
    let mut definitions = Vec::new();
    if !header.contains("particle_type") {
        definitions.extend(["-Dparticle_type=kind", "-Dtypes=kinds"]);
    }
    if !header.contains("ellgran_wall_add_shape(") {
        definitions.push("-DWITHOUT_WALLS");
    } else if !header.contains("ellgran_wall_histories_length(") {
        definitions.push("-Dellgran_wall_histories_length=ellgran_wall_memory_length");
    }
    let particles = header
        .split_once("typedef struct EllgranParticles {")
        .and_then(|(_, rest)| rest.split_once("} EllgranParticles;"));
    if particles.is_some_and(|(fields, _)| fields.contains(" unchanged;")) {
        definitions.push("-DPARTICLES_HAVE_UNCHANGED");
    }
    Ok(definitions)
}

fn git() -> Command {
    let mut command = Command::new("git");
    command.current_dir(workspace::root());
    command
}

/// Leaves library, header and the plugin's sources of a commit in `kept`.
fn build(commit: &str, kept: &Path) -> Result<()> {
    let parent = kept.parent().context("the cache has a place for it")?;
    fs::create_dir_all(parent)?;
    cache::need_space(parent, MEGABYTES)?;
    let scratch = tempfile::Builder::new()
        .prefix("build-")
        .tempdir_in(parent)?;
    let (archive, tree) = (scratch.path().join("tree.tar"), scratch.path().join("tree"));
    output_of(
        git()
            .args(["archive", "--format=tar", "-o"])
            .arg(&archive)
            .arg(commit),
    )?;
    tarball::unpack(&archive, &tree, &[])?;
    let target = scratch.path().join("target");
    let progress = Progress::start(format!("Building the library of {}", &commit[..10]));
    let mut cargo = workspace::cargo();
    cargo
        .current_dir(&tree)
        .args([
            "build",
            "--locked",
            "--release",
            "--package",
            "ellgran",
            "--lib",
        ])
        .arg("--target-dir")
        .arg(&target)
        .env_remove("CARGO_BUILD_TARGET");
    let result = run_logged(&mut cargo, &parent.join("build.log"), |_| {});
    match &result {
        Ok(()) => progress.finish(),
        Err(_) => progress.clear(),
    }
    result.context("the library of that revision cannot be built")?;
    if kept.exists() {
        fs::remove_dir_all(kept)?;
    }
    fs::create_dir_all(kept)?;
    fs::copy(
        target.join("release").join("libellgran.a"),
        kept.join("libellgran.a"),
    )?;
    for name in ["include", "lammps-plugin"] {
        fs::rename(tree.join(name), kept.join(name))?;
    }
    fs::write(cache::stamp(kept), commit)?;
    Ok(())
}

/// Output of the program, a scene given as a file.
fn play(player: &Path, instruction_set: &str, words: &[&OsStr]) -> Result<Vec<u8>> {
    let output = Command::new(player)
        .args(words)
        .env("ELLGRAN_INSTRUCTION_SET", instruction_set)
        .stdin(std::process::Stdio::null())
        .output()
        .with_context(|| format!("cannot start {}", player.display()))?;
    if !output.status.success() {
        bail!(
            "{}",
            String::from_utf8_lossy(&output.stderr)
                .trim()
                .trim_start_matches("player: ")
        );
    }
    Ok(output.stdout)
}

/// The program for the library that the tests of consumers link.
#[cfg(test)]
pub fn test_player(directory: &Path) -> PathBuf {
    use crate::install::prefix::{system_libraries, TEST_PROFILE};
    let target = workspace::target_directory().unwrap().join(TEST_PROFILE);
    // The command of those tests to the letter: nothing is built twice.
    system_libraries(&workspace::root(), &target, None).unwrap();
    let here = Revision {
        name: "this checkout".into(),
        library: target.join(TEST_PROFILE).join("libellgran.a"),
        sources: workspace::root(),
    };
    here.player(directory).unwrap()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn older_headers_are_told_to_the_program() {
        let old = "#define ELLGRAN_INIT(T)\nint32_t kind;\nellgran_wall_add_shape(\nellgran_wall_memory_length(";
        let names = definitions(old).unwrap();
        assert!(names.contains(&"-Dtypes=kinds"));
        assert!(names.contains(&"-Dellgran_wall_histories_length=ellgran_wall_memory_length"));
        let now = fs::read_to_string(workspace::root().join("include/ellgran.h")).unwrap();
        assert_eq!(definitions(&now).unwrap(), ["-DPARTICLES_HAVE_UNCHANGED"]);
        assert!(definitions("int32_t kind;").is_err());
    }
}
