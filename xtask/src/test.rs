// SPDX-License-Identifier: MIT OR Apache-2.0
//! Everything that must hold before a change lands, in order, the first failure being the last word.

use std::path::PathBuf;
use std::process::Command;
use std::time::{Duration, Instant};

use anyhow::Result;

use crate::lammps_kokkos::Backend;
use crate::process::run_open;
use crate::progress::{human_time, say};
use crate::workspace::{cargo, root};
use crate::{
    aarch64, bench, demo, gpu, header, install, lammps, lammps_kokkos, lammps_on_stand_in,
    liggghts, mpi, other_systems, plugin, python, report, rooms, rust_target, setup, shown, site,
    validate, vtk, wheel,
};

#[derive(clap::Args)]
pub struct Options {
    /// Leave out what needs an engine
    #[arg(long)]
    quick: bool,
    /// Run only the tests whose name contains this, and none of the other checks
    #[arg(long)]
    filter: Option<String>,
}

/// What clippy is told to check, a run for each. `--all-targets` leaves out the tests that `cargo test` leaves out, and
/// leaves them out even where they are named beside it, so these have a run of their own.
pub const LINTED: [&[&str]; 2] = [
    &["--all-targets"],
    &["--test", "lammps", "--test", "liggghts", "--test", "wheel"],
];

/// Names and times of the steps so far, and what failed of those that no other step needs.
struct Steps {
    done: Vec<(&'static str, Duration)>,
    failed: Vec<(&'static str, anyhow::Error)>,
}

impl Steps {
    /// A step whose result others need: its failure ends the run.
    fn run<T>(&mut self, name: &'static str, step: impl FnOnce() -> Result<T>) -> Result<T> {
        let result = self.timed(name, step);
        if result.is_err() {
            self.summary();
            self.say_failures();
            say(format!("FAILED: {name}"));
        }
        result
    }

    /// A step that no other needs. The run goes on after its failure, so that one run tells everything that fails.
    fn check(&mut self, name: &'static str, step: impl FnOnce() -> Result<()>) {
        if let Err(error) = self.timed(name, step) {
            say(format!("FAILED: {name}: {error:#}"));
            self.failed.push((name, error));
        }
    }

    fn timed<T>(&mut self, name: &'static str, step: impl FnOnce() -> Result<T>) -> Result<T> {
        say(format!("== {name}"));
        let started = Instant::now();
        let result = step();
        self.done.push((name, started.elapsed()));
        result
    }

    fn say_failures(&self) {
        for (name, error) in &self.failed {
            say(format!("FAILED: {name}: {error:#}"));
        }
    }

    fn end(self) -> Result<()> {
        self.summary();
        self.say_failures();
        match self.failed.len() {
            0 => {
                say("all steps passed");
                Ok(())
            }
            1 => anyhow::bail!("one step failed"),
            count => anyhow::bail!("{count} steps failed"),
        }
    }

    fn summary(&self) {
        say("== summary");
        for (name, time) in &self.done {
            say(format!("{:>14}  {name}", human_time(*time)));
        }
    }
}

pub fn test(options: &Options) -> Result<()> {
    let mut steps = Steps {
        done: Vec::new(),
        failed: Vec::new(),
    };
    those_of(options, &mut steps)?;
    steps.end()
}

fn those_of(options: &Options, steps: &mut Steps) -> Result<()> {
    let filter: Vec<&str> = options.filter.as_deref().into_iter().collect();
    steps.run("tools and headers", || {
        setup::setup()?;
        setup::fortran()
    })?;
    if options.filter.is_none() {
        steps.run("format", || {
            run_open(cargo().args(["fmt", "--all", "--check"]))
        })?;
        steps.run("lints", || {
            LINTED.iter().try_for_each(|targets| {
                let mut clippy = cargo();
                clippy.args(["clippy", "--workspace"]).args(*targets);
                run_open(clippy.args(["--", "-Dwarnings"]))
            })
        })?;
        let lacking = steps.run(
            "lints for Windows and macOS",
            other_systems::those_installed,
        )?;
        for target in lacking {
            say(format!(
                "NOT TESTED: {target}: rustc cannot compile for it here; `cargo xtask other-systems` installs what it needs and looks"
            ));
        }
        steps.check("documentation", || {
            run_open(
                cargo()
                    .args(["doc", "--workspace", "--no-deps"])
                    .env("RUSTDOCFLAGS", "-Dwarnings"),
            )
        });
        steps.check("C header", || header::header(true));
        steps.check("rooms", rooms::check);
        steps.check("examples of public items", shown::check);
        steps.check("kernels for GPUs", gpu::check_sources);
        documentation_site(steps)?;
    }
    let prefix = tempfile::tempdir()?;
    let mut core = cargo();
    // The word after `--`: as an argument of cargo it would also build the tests of packages that have them switched off.
    core.args(["test", "--workspace", "--no-fail-fast", "--"])
        .args(&filter)
        // setup() has installed them: their lack is a failure.
        .env("ELLGRAN_REQUIRE_TOOLS", "1");
    if options.filter.is_none() {
        steps.run("install", || install::into(prefix.path()))?;
        core.env("ELLGRAN_TEST_PREFIX", prefix.path());
    }
    steps.check("core, C and CMake consumers", || run_open(&mut core));
    if options.filter.is_none() {
        steps.check("ten million steps of free rotation", || {
            let one = "free_rotation::energy_has_no_drift_in_ten_million_steps";
            run_open(test_program("theory").args(["--", "--ignored", one]))
        });
        steps.check("bench, quick kernels", || {
            let output = tempfile::tempdir()?;
            bench::quick_kernels(output.path())
        });
        steps.check("report, quick, without engines", || {
            let output = tempfile::tempdir()?;
            report::quick(output.path(), false)
        });
        full_problem(steps);
        if options.quick {
            steps.check("Python", || python::test(None));
        }
    }
    if !options.quick {
        if options.filter.is_none() {
            on_aarch64(steps)?;
        }
        engines(steps, &filter)?;
    }
    Ok(())
}

/// Left out, and said, where Python's packages for it are not to be had.
fn full_problem(steps: &mut Steps) {
    let name = "the theory against the full problem";
    if !cfg!(target_os = "linux") {
        say(format!(
            "NOT TESTED: {name}: the shared library is made on Linux"
        ));
        return;
    }
    match validate::environment() {
        Ok(environment) => steps.check(name, || validate::check(environment)),
        Err(why) => say(format!("NOT TESTED: {name}: {why:#}")),
    }
}

/// Made in any case; the look through a browser is left out, and said, where none is to be had.
fn documentation_site(steps: &mut Steps) -> Result<()> {
    let output = tempfile::tempdir()?;
    let pages = output.path().join("site");
    // Without pages there is nothing to look at, and the run goes on.
    let mut built = false;
    steps.check("documentation site", || {
        site::build(&pages)?;
        built = true;
        Ok(())
    });
    if !built {
        return Ok(());
    }
    let mut browser = None;
    steps.run("browser", || {
        browser = Some(site::browser());
        Ok(())
    })?;
    match browser {
        Some(Ok(browser)) => steps.check("documentation site in the browser", || {
            site::check(&pages, &browser, None)
        }),
        Some(Err(why)) => say(format!(
            "NOT TESTED: the documentation site in a browser: {why:#}"
        )),
        None => {}
    }
    Ok(())
}

/// Left out, and said, where its compilers are not to be had: they are no part of what a user needs. A test does not change
/// which targets this machine's Rust has; `cargo xtask aarch64` does.
fn on_aarch64(steps: &mut Steps) -> Result<()> {
    if std::env::consts::ARCH == "aarch64" {
        return Ok(());
    }
    let mut lacking = None;
    steps.run("compilers and emulator for AArch64", || {
        lacking = if rust_target::is_installed(aarch64::TARGET)? {
            aarch64::prepare().err().map(|e| format!("{e:#}"))
        } else {
            Some("rustc cannot compile for it here; `cargo xtask aarch64` installs what it needs and tests it".into())
        };
        Ok(())
    })?;
    match lacking {
        Some(why) => say(format!("NOT TESTED: AArch64: {why}")),
        None => steps.check("core, C and CMake consumers on AArch64", aarch64::quick),
    }
    Ok(())
}

fn engines(steps: &mut Steps, filter: &[&str]) -> Result<()> {
    let newest = steps.run("LAMMPS", || {
        let source = lammps::source()?;
        let headers = source.src();
        Ok((
            source.binary()?,
            plugin::plugin(&source)?,
            source.name,
            headers,
        ))
    })?;
    let oldest = steps.run("the oldest supported LAMMPS", || {
        let source = lammps::source_of(lammps::OLDEST)?;
        let headers = source.src();
        Ok((
            source.binary()?,
            plugin::plugin(&source)?,
            source.name,
            headers,
        ))
    })?;
    // Where only the oldest release can be had, what needs a newer one is left out, and said.
    let only_oldest = oldest.2 == newest.2;
    if only_oldest {
        say("only the oldest supported LAMMPS is to be had here: the tests that need a newer one are left out");
    }
    let newest_filter = if only_oldest {
        &["both_versions"]
    } else {
        filter
    };
    steps.check("through LAMMPS", || {
        run_open(
            with_engine(test_program("lammps"), &newest)?
                .args(["--", "--skip", KOKKOS_TESTS, "--skip", GPU_TESTS])
                .args(newest_filter),
        )
    });
    with_kokkos(steps, &newest, filter)?;
    let both = filter.is_empty() || filter.iter().any(|word| word.contains("both_versions"));
    if both && oldest.2 != newest.2 {
        steps.check("through the oldest supported LAMMPS", || {
            run_open(with_engine(test_program("lammps"), &oldest)?.args(["--", "both_versions"]))
        });
    }
    if cfg!(target_os = "linux") {
        let directory = tempfile::tempdir()?;
        let wheel = steps.run("wheel", || {
            wheel::build(directory.path(), wheel::Target::ThisMachine)
        })?;
        steps.check("through the wheel", || {
            run_open(
                with_engine(test_program("wheel"), &oldest)?
                    .env("ELLGRAN_TEST_WHEEL", &wheel)
                    .arg("--")
                    .args(filter),
            )
        });
    }
    if root().join("tests").join("liggghts").is_dir() {
        let liggghts = steps.run("LIGGGHTS", liggghts::binary)?;
        let vtk = vtk::vtk().map(|vtk| vtk.include);
        if let Err(error) = &vtk {
            say(format!("NOT TESTED: LIGGGHTS' VTK dumps: {error:#}"));
        }
        steps.check("through LIGGGHTS", || {
            run_open(
                with_engine(test_program("liggghts"), &newest)?
                    .env("ELLGRAN_TEST_LIGGGHTS", &liggghts)
                    .env("ELLGRAN_TEST_LIGGGHTS_SOURCE", liggghts::source_tree()?)
                    .env("ELLGRAN_TEST_LIGGGHTS_VTK", vtk.unwrap_or("no".into()))
                    .arg("--")
                    .args(filter),
            )
        });
    }
    if filter.is_empty() {
        steps.check("Python", || python::test(Some((&newest.0, &newest.1))));
        steps.check("bench, quick, through both engines", || {
            let output = tempfile::tempdir()?;
            bench::quick_scene(output.path())
        });
        steps.check("report, quick, through both engines", || {
            let output = tempfile::tempdir()?;
            report::quick(output.path(), true)
        });
        steps.check("demo", || {
            let output = tempfile::tempdir()?;
            demo::run(demo::Which::Lammps, output.path())
        });
        if root().join("examples").join("liggghts").is_dir() {
            steps.check("demo through LIGGGHTS", || {
                let output = tempfile::tempdir()?;
                demo::run(demo::Which::Liggghts, output.path())
            });
        }
    }
    Ok(())
}

/// Module of the tests that need a LAMMPS with KOKKOS.
const KOKKOS_TESTS: &str = "kokkos::";

/// Module of the tests that need the styles for a GPU besides.
const GPU_TESTS: &str = "styles_for_a_gpu::";

/// Left out, and said, where no release with ellipsoids in KOKKOS is to be had, or no Kokkos.
fn with_kokkos(steps: &mut Steps, newest: &Engine, filter: &[&str]) -> Result<()> {
    let named = |word: &&str| word.contains("kokkos") || word.contains("gpu");
    if !filter.is_empty() && !filter.iter().any(named) {
        return Ok(());
    }
    let source = lammps::source()?;
    let lacking = if lammps_kokkos::has_ellipsoids(&source) {
        lammps_kokkos::kokkos_source().err()
    } else {
        Some(anyhow::anyhow!(
            "LAMMPS {} has no atom_style ellipsoid for it",
            source.spelled()?
        ))
    };
    if let Some(why) = lacking {
        say(format!("NOT TESTED: LAMMPS with KOKKOS: {why:#}"));
        return Ok(());
    }
    let lammps = steps.run("LAMMPS with KOKKOS", || {
        lammps_kokkos::built(&source, Backend::OpenMp)
    })?;
    steps.check("through LAMMPS with KOKKOS", || {
        run_open(
            with_engine(test_program("lammps"), newest)?
                .env("ELLGRAN_TEST_LAMMPS_KOKKOS", &lammps.binary)
                .args(["--", KOKKOS_TESTS]),
        )
    });
    styles_for_a_gpu(steps, newest, &source, &lammps);
    Ok(())
}

/// Without a GPU. Its plugin takes what linkers of Linux alone can do.
fn styles_for_a_gpu(
    steps: &mut Steps,
    newest: &Engine,
    source: &lammps::Source,
    lammps: &lammps_kokkos::Built,
) {
    if !cfg!(target_os = "linux") {
        say("NOT TESTED: LAMMPS' styles for a GPU: their plugin is built on Linux");
        return;
    }
    steps.check("LAMMPS' styles for a GPU, without one", || {
        let plugin = lammps_on_stand_in::plugin(source, lammps)?;
        run_open(
            with_engine(test_program("lammps"), newest)?
                .env("ELLGRAN_TEST_LAMMPS_KOKKOS", &lammps.binary)
                .env("ELLGRAN_TEST_LAMMPS_GPU_PLUGIN", plugin)
                .args(["--", GPU_TESTS]),
        )
    });
}

/// One program of the tests.
fn test_program(name: &str) -> Command {
    let mut command = cargo();
    // Of the workspace, as the core's tests: with the features of one package alone the library would be compiled once more.
    command.args(["test", "--workspace", "--test", name]);
    command
}

/// Binary, plugin, name, headers.
type Engine = (PathBuf, PathBuf, String, PathBuf);

fn with_engine(mut command: Command, (binary, plugin, _, headers): &Engine) -> Result<Command> {
    command
        .env("ELLGRAN_TEST_LAMMPS", binary)
        .env("ELLGRAN_TEST_LAMMPS_PLUGIN", plugin)
        .env("ELLGRAN_TEST_LAMMPS_HEADERS", headers)
        .env("ELLGRAN_TEST_MPIRUN", mpi::mpirun()?);
    mpi::let_ranks_share_cores(&mut command)?;
    Ok(command)
}
