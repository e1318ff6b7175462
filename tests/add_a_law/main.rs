// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does docs/how-to-add-a-law.md say what is to be done? Its steps are done on a copy of the sources, which is built and asked for
//! the forces of the new laws.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The rooms that one contact needs; without neighbour lists and the C interface there are few kernels to compile.
const ROOMS: [&str; 7] = [
    "contact", "force", "geometry", "message", "real", "simd", "vector",
];

/// One step of the page: where, behind which line of the file (`None`: the file is new), and what.
struct Step {
    file: String,
    after: Option<String>,
    block: String,
}

/// The texts between backticks.
fn quoted(line: &str) -> Vec<&str> {
    line.split('`').skip(1).step_by(2).collect()
}

/// The steps of a section: "New file `F`:" or "In `F`, after `LINE`:", then a block of Rust.
fn steps(page: &str, section: &str) -> Vec<Step> {
    let start = page.find(section).expect("the section is there");
    let rest = &page[start + section.len()..];
    let section = rest.split("\n## ").next().unwrap();
    let mut found = Vec::new();
    let mut lead = "";
    let mut lines = section.lines();
    while let Some(line) = lines.next() {
        if line == "```rust" {
            let block: Vec<&str> = lines.by_ref().take_while(|l| *l != "```").collect();
            let names = quoted(lead);
            found.push(Step {
                file: names[0].into(),
                after: if lead.starts_with("New file ") {
                    None
                } else {
                    assert!(lead.starts_with("In "), "no step leads to a block: {lead}");
                    Some(names[1].into())
                },
                block: block.join("\n") + "\n",
            });
        } else if !line.is_empty() {
            lead = line;
        }
    }
    found
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::write(target, fs::read(entry.path()).unwrap()).unwrap();
        }
    }
}

fn apply(copy: &Path, step: &Step) {
    let path = copy.join(&step.file);
    let Some(after) = &step.after else {
        assert!(!path.exists(), "{} is not new", step.file);
        fs::write(path, &step.block).unwrap();
        return;
    };
    let text = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", step.file));
    let lines: Vec<&str> = text.lines().collect();
    let places: Vec<usize> = (0..lines.len())
        .filter(|k| lines[*k].contains(after.as_str()))
        .collect();
    assert_eq!(places.len(), 1, "{}: lines with '{after}'", step.file);
    let (before, behind) = lines.split_at(places[0] + 1);
    let text = before.join("\n") + "\n" + &step.block + &behind.join("\n") + "\n";
    fs::write(path, text).unwrap();
}

fn repository() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The features and the dependencies of the library, as its manifest has them.
fn dependencies() -> String {
    let manifest = fs::read_to_string(repository().join("Cargo.toml")).unwrap();
    let section = |name: &str| {
        let section = &manifest[manifest.find(name).unwrap()..];
        let end = section.find("\n[").unwrap_or(section.len());
        section[..end].to_owned()
    };
    section("[features]") + "\n" + &section("[dependencies]")
}

/// A package of the copy, with a lock file that has the versions at hand.
fn package(directory: &Path, name: &str, target: &str) {
    // Without checks and debugging information, which take longer to translate than the laws.
    let profile = "[profile.dev]\nopt-level = 1\ndebug = false\ndebug-assertions = false\n";
    let text = format!(
        "[package]\nname = \"{name}\"\nversion = \"0.0.0\"\nedition = \"2021\"\npublish = false\nautolib = false\n\n{target}\n{}\n\n\
         {profile}\n[workspace]\n",
        dependencies()
    );
    fs::write(directory.join("Cargo.toml"), text).unwrap();
    fs::copy(
        repository().join("Cargo.lock"),
        directory.join("Cargo.lock"),
    )
    .unwrap();
}

/// What cargo prints for this package.
fn cargo(directory: &Path, arguments: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO"));
    let built = directory.ancestors().nth(1).unwrap().join("built");
    command
        .args(arguments)
        .args(["--quiet", "--offline", "--manifest-path"])
        .arg(directory.join("Cargo.toml"))
        .arg("--target-dir")
        .arg(built)
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_BUILD_TARGET");
    let output = command.output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}\n{errors}");
    String::from_utf8(output.stdout).unwrap()
}

/// The copy after the steps of these sections, and the files of the sources that they changed.
fn changed_copy(name: &str, sections: &[&str]) -> (PathBuf, BTreeSet<String>) {
    let page = fs::read_to_string(repository().join("docs/how-to-add-a-law.md")).unwrap();
    let directory = PathBuf::from(env!("CARGO_TARGET_TMPDIR"))
        .join("add_a_law")
        .join(name);
    let _ = fs::remove_dir_all(&directory);
    copy(&repository().join("src"), &directory.join("src"));
    fs::copy(repository().join("README.md"), directory.join("README.md")).unwrap();
    let mut files = BTreeSet::new();
    for section in sections {
        for step in steps(&page, section) {
            apply(&directory, &step);
            files.insert(step.file);
        }
    }
    (directory, files)
}

const NORMAL: &str = "\n## A normal law";
const TANGENTIAL: &str = "\n## A tangential law";

#[test]
fn a_normal_law_is_three_files_and_a_tangential_one_is_one() {
    let page = fs::read_to_string(repository().join("docs/how-to-add-a-law.md")).unwrap();
    let files = |section: &str| -> BTreeSet<String> {
        steps(&page, section).into_iter().map(|s| s.file).collect()
    };
    assert_eq!(files(NORMAL).len(), 3, "{:?}", files(NORMAL));
    assert_eq!(files(TANGENTIAL).len(), 1, "{:?}", files(TANGENTIAL));
}

/// Every room, the neighbour lists in lanes and the C interface included.
#[test]
fn the_whole_library_takes_the_laws_of_the_page() {
    let (copy, _) = changed_copy("library", &[NORMAL, TANGENTIAL]);
    package(&copy, "ellgran", "[lib]\npath = \"src/lib.rs\"\n");
    cargo(&copy, &["check", "--lib"]);
}

#[test]
fn the_laws_of_the_page_have_their_forces() {
    let (copy, _) = changed_copy("contact", &[NORMAL, TANGENTIAL]);
    let rooms: String = ROOMS
        .iter()
        .map(|room| {
            let path = ["/mod.rs", ".rs"]
                .map(|end| copy.join("src").join(format!("{room}{end}")))
                .into_iter()
                .find(|path| path.is_file())
                .expect("the room is there");
            format!("#[path = {path:?}]\npub mod {room};\n")
        })
        .collect();
    let program = format!(
        "#![allow(dead_code, unused_imports)]\n{rooms}\n{}",
        include_str!("forces.rs")
    );
    fs::write(copy.join("forces.rs"), program).unwrap();
    let target = "[[bin]]\nname = \"forces\"\npath = \"forces.rs\"\n";
    package(&copy, "forces", target);
    let printed = cargo(&copy, &["run"]);
    let numbers: Vec<f64> = printed
        .split_whitespace()
        .map(|word| word.parse().unwrap_or_else(|_| panic!("{printed}")))
        .collect();
    let [force, energy, time, slipping, sliding] = numbers[..] else {
        panic!("{printed}");
    };
    let near = |got: f64, wanted: f64| {
        assert!(
            (got / wanted - 1.0).abs() < 1e-12,
            "{got} {wanted}\n{printed}"
        );
    };
    // Two unit spheres that overlap by 0.01, kq = 7000.
    near(force, 7000.0 * 1e-4);
    near(energy, 7000.0 * 1e-6 / 3.0);
    // Both of mass 1 at speed 0.1: the deepest penetration is (3 m v^2/(2 kq))^(1/3), m = 1/2.
    let deepest = (1.5f64 * 0.5 * 0.01 / 7000.0).cbrt();
    near(time, 2.804_364_210_650_908 * deepest / 0.1);
    // At half of the displacement at which all slides, and beyond it, over Coulomb's limit.
    near(slipping, 0.75);
    near(sliding, 1.0);
}
