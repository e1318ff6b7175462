// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tests of the Python module, in virtual environments of the cache, against the shared library of this checkout.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Result;

use crate::progress::say;
use crate::python_environment::Environment;
use crate::workspace::root;
use crate::{install, mpi, process};

#[derive(clap::Args)]
pub struct Options {
    /// Run only the tests whose name contains this
    #[arg(long)]
    filter: Option<String>,
    /// Print what the vectorised law costs beside the C call, in place of the tests
    #[arg(long)]
    cost: bool,
}

/// A LAMMPS binary and the plugin built for it.
pub type Engine<'a> = (&'a Path, &'a Path);

/// `cargo xtask python`
pub fn python(options: &Options) -> Result<()> {
    if options.cost {
        let prefix = library()?;
        let interpreter = environment("requirements.txt")?;
        let script = directory().join("benchmarks").join("cost_of_arrays.py");
        return process::run_open(in_environment(&interpreter, prefix.path()).arg(script));
    }
    run(options.filter.as_deref(), None)
}

/// All tests; those that run a deck need an engine, and say so where there is none.
pub fn test(engine: Option<Engine>) -> Result<()> {
    run(None, engine)
}

/// What the tests run in: its name, empty for the one that there must be; how to get its interpreter; the tests.
type Surroundings = (
    &'static str,
    fn() -> Result<PathBuf>,
    &'static [&'static str],
);

const SURROUNDINGS: [Surroundings; 3] = [
    ("the oldest Python and numpy", oldest, &["tests"]),
    (
        "OVITO",
        || environment("requirements-ovito.txt"),
        &["tests/test_pictures.py", "tests/test_wall_outputs.py"],
    ),
    ("", || environment("requirements.txt"), &["tests"]),
];

fn run(filter: Option<&str>, engine: Option<Engine>) -> Result<()> {
    let prefix = library()?;
    for (title, interpreter, tests) in SURROUNDINGS {
        // pytest fails where a filter leaves nothing.
        if title == "OVITO" && filter.is_some_and(|words| !words.contains("ovito")) {
            continue;
        }
        let interpreter = match interpreter() {
            Ok(interpreter) => interpreter,
            // Not to be had for every Python and every machine.
            Err(error) if !title.is_empty() => {
                say(format!("NOT TESTED: Python with {title}: {error:#}"));
                continue;
            }
            Err(error) => return Err(error),
        };
        let mut command = in_environment(&interpreter, prefix.path());
        command
            .args(["-m", "pytest", "-q", "-p", "no:cacheprovider"])
            .args(tests.iter().map(|file| directory().join(file)));
        if let Some(words) = filter {
            command.args(["-k", words]);
        }
        if let Some((lammps, plugin)) = engine {
            command
                .env("ELLGRAN_TEST_LAMMPS", lammps)
                .env("ELLGRAN_TEST_LAMMPS_PLUGIN", plugin);
            mpi::let_ranks_share_cores(&mut command)?;
        }
        process::run_open(&mut command)?;
    }
    Ok(())
}

fn directory() -> PathBuf {
    root().join("python")
}

/// The oldest Python that the package takes with the oldest numpy that it takes; with a newer Python where the oldest is not to be had.
fn oldest() -> Result<PathBuf> {
    let file = directory().join("tests").join("requirements-oldest.txt");
    match oldest_python() {
        Some(python) => Ok(Environment::pinned_for(&python, &file)?.program("python")),
        None => {
            say(format!(
                "NOT TESTED: Python {OLDEST}, which is not on PATH: the oldest numpy is tried with the Python that is there"
            ));
            Ok(Environment::pinned(&file)?.program("python"))
        }
    }
}

/// What `requires-python` in pyproject.toml says.
const OLDEST: &str = "3.9";

/// On PATH, or among those that pyenv keeps. A launcher that finds none of them, as pyenv leaves, does not answer.
fn oldest_python() -> Option<PathBuf> {
    let name = format!("python{OLDEST}");
    let home = std::env::var_os("HOME").map(|home| PathBuf::from(home).join(".pyenv"));
    let pyenv = std::env::var_os("PYENV_ROOT").map(PathBuf::from).or(home);
    let kept = pyenv.and_then(|root| std::fs::read_dir(root.join("versions")).ok());
    let kept = kept.into_iter().flatten().flatten();
    process::find_program(&name)
        .into_iter()
        .chain(kept.map(|version| version.path().join("bin").join(&name)))
        .find(|python| {
            process::output_of(Command::new(python).args(["-c", "import ensurepip, venv"])).is_ok()
        })
}

/// A prefix with the shared library of this checkout.
pub fn library() -> Result<tempfile::TempDir> {
    let prefix = tempfile::tempdir()?;
    install::with_shared(prefix.path())?;
    Ok(prefix)
}

fn in_environment(interpreter: &Path, prefix: &Path) -> Command {
    let mut command = Command::new(interpreter);
    command
        .current_dir(directory())
        .env("ELLGRAN_LIBRARY", prefix.join("lib").join("libellgran.so"))
        .env("ELLGRAN_INCLUDE", root().join("include"))
        .env("PYTHONPATH", directory())
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("PYTHONWARNINGS", "error::DeprecationWarning:ellgran");
    command
}

/// The interpreter of a virtual environment with the packages that a file in python/tests names.
fn environment(requirements: &str) -> Result<PathBuf> {
    let file = directory().join("tests").join(requirements);
    Ok(Environment::pinned(&file)?.program("python"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_python_is_that_of_the_package() {
        let text = std::fs::read_to_string(directory().join("pyproject.toml")).unwrap();
        let line = format!("requires-python = \">={OLDEST}\"");
        assert!(
            text.lines().any(|l| l == line),
            "pyproject.toml lacks {line}"
        );
    }

    #[test]
    fn the_oldest_numpy_is_that_of_the_package() {
        let tried = directory().join("tests").join("requirements-oldest.txt");
        let tried = std::fs::read_to_string(tried).unwrap();
        let version = tried
            .lines()
            .find_map(|l| l.strip_prefix("numpy=="))
            .unwrap();
        let series = version.rsplit_once('.').unwrap().0;
        let package = std::fs::read_to_string(directory().join("pyproject.toml")).unwrap();
        assert!(
            package.contains(&format!("\"numpy>={series}\"")),
            "{series}"
        );
    }
}
