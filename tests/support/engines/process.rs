// SPDX-License-Identifier: MIT OR Apache-2.0
//! One run of an engine: where, on how many ranks, for how long at the most.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Ten times what the longest run takes on a machine with nothing else to do.
const TIME_LIMIT: Duration = Duration::from_secs(300);

/// Lets a rank write into a file of its own. What a rank writes just before it ends all others can be lost on its way through the launcher.
const INTO_ITS_OWN_FILE: &str =
    r#"exec "$@" >"rank.${PMI_RANK:-${OMPI_COMM_WORLD_RANK:-$$}}" 2>&1"#;

/// The path that `variable` of the environment names; `hint` says what else gives it.
pub fn from_environment(variable: &str, hint: &str) -> PathBuf {
    std::env::var_os(variable)
        .unwrap_or_else(|| panic!("{variable} is not set: {hint}"))
        .into()
}

/// A clean directory of this name under the build directory; another one for each engine and test.
pub fn fresh_directory(engine: &str, name: &str) -> PathBuf {
    let test = std::thread::current()
        .name()
        .unwrap_or("main")
        .replace("::", ".");
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join(engine)
        .join(test)
        .join(name);
    let _ = fs::remove_dir_all(&directory);
    fs::create_dir_all(&directory).expect("cannot create a directory for the run");
    directory
}

/// Runs `deck` in `directory` on `ranks` ranks of `program`; whether it succeeded, and everything it wrote on its streams. A program that
/// a signal ends has crashed, which no test allows.
pub fn execute(
    program: &Path,
    arguments: &[&str],
    mpirun: &Path,
    directory: &Path,
    deck: &str,
    ranks: usize,
) -> (bool, String) {
    fs::write(directory.join("in.deck"), deck).unwrap();
    for file in files_of_ranks(directory) {
        fs::remove_file(file).unwrap();
    }
    // ranks that wait keep a core busy: one run on several ranks at a time
    static SEVERAL_RANKS: Mutex<()> = Mutex::new(());
    let _alone = (ranks > 1).then(|| SEVERAL_RANKS.lock().unwrap_or_else(|e| e.into_inner()));
    let mut command = if ranks == 1 {
        Command::new(program)
    } else {
        let mut command = Command::new(mpirun);
        command.arg("-n").arg(ranks.to_string());
        command.args(["sh", "-c", INTO_ITS_OWN_FILE, "sh"]);
        command.arg(program);
        command
    };
    let output = fs::File::create(directory.join("output")).unwrap();
    let errors = output.try_clone().unwrap();
    let mut child = with_several_ranks(&mut command)
        .args(["-in", "in.deck", "-log", "none"])
        .args(arguments)
        .current_dir(directory)
        .stdin(Stdio::null())
        .stdout(Stdio::from(output))
        .stderr(Stdio::from(errors))
        .spawn()
        .unwrap_or_else(|e| {
            panic!(
                "cannot start {}: {e}",
                command.get_program().to_string_lossy()
            )
        });
    let started = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break Some(status);
        }
        if started.elapsed() > TIME_LIMIT {
            let _ = child.kill();
            let _ = child.wait();
            break None;
        }
        std::thread::sleep(Duration::from_millis(
            if started.elapsed().as_millis() < 200 {
                2
            } else {
                20
            },
        ));
    };
    let text: String = std::iter::once(directory.join("output"))
        .chain(files_of_ranks(directory))
        .map(|file| String::from_utf8_lossy(&fs::read(file).unwrap()).into_owned())
        .collect();
    match status {
        // Launchers of several ranks turn the signal of one into a status above 128.
        Some(status) if status.code().is_none_or(|code| code > 128) => panic!(
            "{} crashed in {} ({status}); its last words:\n{}",
            program.display(),
            directory.display(),
            last_lines(&text)
        ),
        Some(status) => (status.success(), text),
        None => panic!(
            "{} ran longer than {TIME_LIMIT:?} in {}; its last words:\n{}",
            program.display(),
            directory.display(),
            last_lines(&text)
        ),
    }
}

/// What the ranks of the last run in this directory wrote, rank after rank.
fn files_of_ranks(directory: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = fs::read_dir(directory)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.file_stem().is_some_and(|stem| stem == "rank"))
        .collect();
    files.sort();
    files
}

/// The environment of a program that starts several ranks, or is one.
pub fn with_several_ranks(command: &mut Command) -> &mut Command {
    command
        .env("OMP_NUM_THREADS", "1")
        // Open MPI refuses root and more ranks than cores unless told; other launchers ignore these
        .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
        .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
        .env("OMPI_MCA_rmaps_base_oversubscribe", "1")
        .env("OMPI_MCA_mpi_yield_when_idle", "1")
}

pub fn last_lines(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    lines[lines.len().saturating_sub(25)..].join("\n")
}
