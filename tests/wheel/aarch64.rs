// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does the wheel for AArch64 run beside that machine's stock LAMMPS, and move the grains as this machine does? In an emulator,
//! which cannot start the script `lmp`: that would start a program of AArch64 itself. So the script's module says what it
//! would set, and its program is started with that.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::deck::{deck, difference, frames};
use crate::engines::process::{execute, from_environment, last_lines};
use crate::stock::{fresh_directory, from_source};

const HINT: &str = "`cargo xtask aarch64` makes it";
const STEPS: u32 = 4000;

/// The README's deck, with orientations that are arithmetic of the identifiers: LAMMPS' random ones depend on whether a `char` has a
/// sign, which it has on x86-64 and has not on AArch64.
fn same_deck(steps: u32) -> String {
    let random = "set type 1 quat/random 4711";
    let text = deck(steps);
    assert!(text.contains(random));
    text.replace(
        random,
        "variable ax atom id%7-3\n\
         variable ay atom id%5-2\n\
         variable az atom id%3+1\n\
         variable turn atom (37*id)%360\n\
         set type 1 quat v_ax v_ay v_az v_turn",
    )
}

/// A virtual environment of AArch64 with LAMMPS and the wheel.
fn environment() -> PathBuf {
    from_environment("ELLGRAN_TEST_AARCH64_ENVIRONMENT", HINT)
}

fn emulated(program: &Path) -> Command {
    let mut command = Command::new("qemu-aarch64");
    command.arg(program).env("OMP_NUM_THREADS", "1");
    command
}

fn succeed(command: &mut Command) -> String {
    let Output {
        status,
        stdout,
        stderr,
    } = command.output().expect("cannot run the emulator");
    let said = String::from_utf8_lossy(&stdout).into_owned();
    assert!(
        status.success(),
        "{command:?}: {status}\n{}{}",
        last_lines(&said),
        String::from_utf8_lossy(&stderr)
    );
    said
}

fn python(directory: &Path, script: &str) -> String {
    succeed(
        emulated(&environment().join("bin/python"))
            .args(["-c", script])
            .current_dir(directory),
    )
}

#[test]
#[ignore = "needs the wheel for AArch64 and a Python of it: `cargo xtask aarch64 --wheel` has them"]
fn the_deck_moves_on_aarch64_as_on_this_machine() {
    let stock = fresh_directory("stock");
    fs::write(stock.join("in.deck"), same_deck(STEPS)).unwrap();
    let said = python(
        &stock,
        "import os, platform, lammps.executable as e\n\
         assert platform.machine() == 'aarch64'\n\
         for name in ('LAMMPS_PLUGIN_PATH', 'LD_LIBRARY_PATH'): print(os.environ[name])\n\
         print(e.ROOT_DIR)\n",
    );
    let [plugins, libraries, root] = said.lines().collect::<Vec<_>>()[..] else {
        panic!("{said}");
    };
    let output = succeed(
        emulated(&Path::new(root).join("lmp"))
            .args(["-in", "in.deck", "-log", "none", "-nocite"])
            .env("LAMMPS_PLUGIN_PATH", plugins)
            .env("LD_LIBRARY_PATH", libraries)
            .current_dir(&stock),
    );
    assert!(output.contains("Loaded 1 plugins"), "{output}");

    let from_python = fresh_directory("python");
    fs::write(from_python.join("in.deck"), same_deck(2000)).unwrap();
    python(
        &from_python,
        "from lammps import lammps\n\
         l = lammps(cmdargs=['-log', 'none', '-nocite'])\n\
         l.file('in.deck')\n\
         assert ['pair', 'gran/ellipsoid'] in l.available_plugins()\n\
         l.close()\n",
    );

    let (lammps, plugin) = from_source();
    let here = fresh_directory("here");
    let text = format!("plugin load {}\n{}", plugin.display(), same_deck(STEPS));
    let (success, output) = execute(&lammps, &["-nocite"], Path::new(""), &here, &text, 1);
    assert!(success, "{}", last_lines(&output));

    let (there, here) = (frames(&stock), frames(&here));
    assert_eq!((there.len(), there[0].len()), (3, 250));
    assert_eq!(
        difference(&there[..2].to_vec(), &frames(&from_python)),
        0.0,
        "lmp and Python"
    );
    let moved = difference(&there[..1].to_vec(), &there[2..].to_vec());
    let largest = difference(&there, &here);
    println!("grains moved by up to {moved}, AArch64 and this machine differ by up to {largest:e}");
    assert!(moved > 1e-3);
    // The lanes sum in another order, and collisions multiply what rounding differs by.
    assert!(largest < 1e-9, "{largest:e}");
}
