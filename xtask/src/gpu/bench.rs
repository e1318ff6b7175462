// SPDX-License-Identifier: MIT OR Apache-2.0
//! Whole steps on a GPU: the packings of the benchmark of engines, and the program that times them.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};

use crate::bench::lammps_run::Lammps;
use crate::bench::packing::{Kind, Packing};
use crate::process::output_of;
use crate::progress::say;
use crate::workspace::root;

/// A packing, as the scenes of `cargo xtask bench` are, with the numbers of its copies in each direction, and the margin of candidates in
/// parts of the smallest semi-axis: wide where grains are fast, or their ends.
pub(super) struct Timed {
    pub(super) name: &'static str,
    kind: Kind,
    lattice: [usize; 3],
    copies: &'static str,
    margin: &'static str,
}

pub(super) const TIMED: [Timed; 4] = [
    Timed {
        name: "dense",
        kind: Kind::Dense,
        lattice: [16, 16, 16],
        copies: "1,2,3,6,10,13",
        margin: "0.02",
    },
    Timed {
        name: "needles",
        kind: Kind::Needles,
        lattice: [16, 8, 8],
        copies: "2,5",
        margin: "0.2",
    },
    Timed {
        name: "mixture",
        kind: Kind::Mixture,
        lattice: [18, 18, 18],
        copies: "2,5",
        margin: "0.02",
    },
    Timed {
        name: "gas",
        kind: Kind::Gas,
        lattice: [16, 16, 16],
        copies: "2,5,10",
        margin: "0.2",
    },
];

/// The program that times a packing, and its words.
pub(super) fn words(timed: &Timed, file: &Path) -> [String; 5] {
    let file = file.display().to_string();
    [
        file,
        "--copies".into(),
        timed.copies.into(),
        "--margin".into(),
        timed.margin.into(),
    ]
}

/// Makes the packings, and times them on the GPU of this machine.
pub fn bench() -> Result<()> {
    let directory = root().join("bench-output/gpu");
    packings(&directory)?;
    let mut results = String::new();
    for timed in &TIMED {
        let file = directory.join(timed.name).with_extension("data");
        let output = output_of(
            Command::new("cargo")
                .args(["bench", "-p", "ellgran-gpu", "--bench", "whole_step", "--"])
                .args(words(timed, &file))
                .env("ELLGRAN_TEST_GPU_DRIVER", driver())
                .env("ELLGRAN_GPU_DRIVER", driver())
                .current_dir(root()),
        )?;
        print!("{output}");
        // What it is about, and the names of the columns, once.
        let skipped = if results.is_empty() { 0 } else { 2 };
        for line in output.lines().skip(skipped) {
            results += line;
            results.push('\n');
        }
    }
    let to = directory.join("whole_step.csv");
    fs::write(&to, results).with_context(|| format!("cannot write {}", to.display()))?;
    say(format!(
        "results are in {}; docs/gpu.md shows those in docs/bench/gpu",
        to.display()
    ));
    Ok(())
}

/// NVIDIA's driver.
fn driver() -> std::ffi::OsString {
    std::env::var_os("ELLGRAN_GPU_DRIVER").unwrap_or_else(|| "libcuda.so.1".into())
}

/// The packings, as files of a directory.
pub(super) fn packings(directory: &Path) -> Result<Lammps> {
    fs::create_dir_all(directory)
        .with_context(|| format!("cannot make {}", directory.display()))?;
    let lammps = Lammps::prepare()?;
    for timed in &TIMED {
        let packing = Packing {
            kind: timed.kind,
            lattice: timed.lattice,
            spheres: false,
        };
        let to = directory.join(timed.name).with_extension("data");
        let made = packing.file(&lammps)?;
        fs::copy(&made, &to).with_context(|| format!("cannot write {}", to.display()))?;
    }
    Ok(lammps)
}
