// SPDX-License-Identifier: MIT OR Apache-2.0
//! Virtual environments of Python, and what is installed in them from the package index. One of AArch64 runs in an emulator.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::aarch64_python::Interpreter;
use crate::process::{output_of, run_logged};
use crate::progress::{say, Progress};
use crate::{cache, setup};

/// A virtual environment in the cache.
pub struct Environment {
    directory: PathBuf,
    /// What runs its programs, where they are of AArch64.
    emulated: Option<Interpreter>,
    _lock: cache::Lock,
}

impl Environment {
    /// The one of this name, with the newest of each of `requirements` that the index has. Where the index cannot be reached,
    /// what was installed before serves.
    pub fn with(name: &str, requirements: &[&str]) -> Result<Self> {
        setup::python()?;
        let lock = cache::lock(&format!("python-{name}"))?;
        let directory = cache::directory()?.join(format!("python-{name}"));
        let environment = Environment {
            directory,
            emulated: None,
            _lock: lock,
        };
        // One of a Python that is gone does not run.
        if output_of(environment.python().arg("-c").arg("import pip")).is_err() {
            output_of(
                Command::new("python3")
                    .args(["-m", "venv", "--clear"])
                    .arg(&environment.directory),
            )?;
        }
        environment.install(requirements)?;
        Ok(environment)
    }

    /// The same of AArch64, on a machine that is none.
    pub fn of_aarch64_with(name: &str, requirements: &[&str]) -> Result<Self> {
        let interpreter = Interpreter::had()?;
        let lock = cache::lock(&format!("python-aarch64-{name}"))?;
        let directory = cache::directory()?.join(format!("python-aarch64-{name}"));
        let environment = Environment {
            directory,
            emulated: Some(interpreter),
            _lock: lock,
        };
        if output_of(environment.python().arg("-c").arg("import pip")).is_err() {
            let _ = std::fs::remove_dir_all(&environment.directory);
            if let Some(interpreter) = &environment.emulated {
                interpreter.make_environment(&environment.directory)?;
            }
        }
        environment.install(requirements)?;
        Ok(environment)
    }

    /// The one with exactly what a requirements file names, wheels alone; made anew for another file or another Python.
    pub fn pinned(requirements: &Path) -> Result<Self> {
        setup::python()?;
        Self::pinned_for(Path::new("python3"), requirements)
    }

    /// The same for another Python than the one of this machine.
    pub fn pinned_for(python: &Path, requirements: &Path) -> Result<Self> {
        let wanted = std::fs::read_to_string(requirements)
            .with_context(|| format!("cannot read {}", requirements.display()))?;
        let version = output_of(Command::new(python).args([
            "-c",
            "import sys, sysconfig; print(sys.version, sys.executable, sysconfig.get_platform())",
        ]))?;
        let name = format!("python-{}", cache::key(&[&wanted, &version]));
        let lock = cache::lock(&name)?;
        let directory = cache::directory()?.join(&name);
        let stamp = cache::stamp(&directory);
        let environment = Environment {
            directory,
            emulated: None,
            _lock: lock,
        };
        if stamp.is_file() && environment.program("python").exists() {
            return Ok(environment);
        }
        cache::need_space(&cache::directory()?, 1500)?;
        let log = cache::directory()?.join(format!("{name}.log"));
        let mut progress =
            Progress::start(format!("Installing what {} names", requirements.display()));
        let made = run_logged(
            Command::new(python)
                .args(["-m", "venv", "--clear"])
                .arg(&environment.directory),
            &log,
            |_| (),
        )
        .and_then(|()| {
            run_logged(
                environment
                    .python()
                    .args(["-m", "pip", "install", "--only-binary", ":all:"])
                    .args(["--disable-pip-version-check", "--requirement"])
                    .arg(requirements),
                &log,
                |line| progress.update(None, line),
            )
        });
        match made {
            Ok(()) => progress.finish(),
            Err(error) => {
                progress.clear();
                return Err(error);
            }
        }
        std::fs::write(stamp, "")?;
        Ok(environment)
    }

    fn install(&self, requirements: &[&str]) -> Result<()> {
        let stamp = self.directory.join("installed");
        let wanted = requirements.join("\n");
        let before = std::fs::read_to_string(&stamp).is_ok_and(|text| text == wanted);
        let mut progress = Progress::start(format!("Installing {}", requirements.join(", ")));
        let mut pip = self.python();
        pip.args(["-m", "pip", "install", "--upgrade", "--no-input"])
            .arg("--disable-pip-version-check")
            .args(requirements);
        let result = run_logged(&mut pip, &self.directory.join("pip.log"), |line| {
            progress.update(None, line)
        });
        match result {
            Ok(()) => {
                progress.finish();
                std::fs::write(&stamp, wanted)?;
                Ok(())
            }
            Err(error) if before => {
                progress.clear();
                say(format!("using what was installed before: {error:#}"));
                Ok(())
            }
            Err(error) => {
                progress.clear();
                Err(error).context("pip cannot install")
            }
        }
    }

    pub fn python(&self) -> Command {
        self.command("python")
    }

    /// A program of the environment, which finds the others there.
    pub fn command(&self, name: &str) -> Command {
        let mut command = self.run(&self.program(name));
        let programs = std::iter::once(self.directory.join("bin"));
        let path = std::env::var_os("PATH").unwrap_or_default();
        let path = std::env::join_paths(programs.chain(std::env::split_paths(&path)));
        if let Ok(path) = path {
            command.env("PATH", path);
        }
        command
    }

    /// A program of the environment's machine.
    pub fn run(&self, program: &Path) -> Command {
        match &self.emulated {
            Some(interpreter) => interpreter.command(program),
            None => Command::new(program),
        }
    }

    pub fn program(&self, name: &str) -> PathBuf {
        self.directory.join("bin").join(name)
    }

    /// The emulator's root for libraries.
    pub fn emulator_root(&self) -> Result<&Path> {
        let interpreter = self.emulated.as_ref();
        Ok(interpreter.context("no emulated environment")?.root())
    }

    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// Version of an installed package.
    pub fn version(&self, package: &str) -> Result<String> {
        let script = format!("import importlib.metadata as m; print(m.version('{package}'))");
        Ok(output_of(self.python().args(["-c", &script]))?
            .trim()
            .to_string())
    }

    /// Where packages lie.
    pub fn packages(&self) -> Result<PathBuf> {
        let script = "import sysconfig; print(sysconfig.get_path('platlib'))";
        Ok(output_of(self.python().args(["-c", script]))?.trim().into())
    }
}
