// SPDX-License-Identifier: MIT OR Apache-2.0
//! Are the messages that the pages quote those of the sources?
//!
//! A page writes `...` for what differs from case to case. What stands between must be in a source as it is printed.

use std::fs;

use crate::process::output_of;
use crate::workspace::root;

/// Page and heading of each table of messages.
const TABLES: [(&str, &str); 3] = [
    ("lammps-plugin/README.md", "## Troubleshooting"),
    ("liggghts-patch/README.md", "## Messages"),
    ("docs/troubleshooting.md", "## cargo xtask"),
];

/// How the messages begin that the engines print themselves.
const OF_ENGINES: [&str; 11] = [
    "Unrecognized pair style",
    "Open of file",
    "Unknown command",
    "Lost atoms",
    "Ignoring load of pair style",
    "Cannot reset timestep with time-dependent fix",
    "Cannot use reset_atoms id",
    "All pair coeffs are not set",
    "Invalid shape in Atoms section",
    "Could not locate a fix/property",
    "mesh neighbor list overflow",
];

/// Who speaks, which the sources print from a variable.
const CALLERS: [&str; 4] = [
    "Pair gran/ellipsoid",
    "Fix wall/gran/ellipsoid",
    "Fix pour/ellipsoid",
    "create_ellipsoids",
];

/// All sources, with the pieces of each string put together.
fn sources() -> String {
    let patterns = [
        "src/*.rs",
        "xtask/src/*.rs",
        "lammps-plugin/*.cpp",
        "lammps-plugin/*.h",
        "lammps-plugin/*.txt",
        "liggghts-patch/src/*",
        "python/*.py",
    ];
    let list = output_of(
        std::process::Command::new("git")
            .arg("ls-files")
            .args(patterns)
            .current_dir(root()),
    )
    .expect("git");
    let mut whole = String::new();
    for file in list
        .lines()
        .filter(|file| !file.ends_with("quoted_messages.rs"))
    {
        let text = fs::read_to_string(root().join(file)).expect(file);
        // C++ and Python go on in another string, Rust after a backslash at the end of the line.
        let mut pieces = text.split('"').peekable();
        while let Some(piece) = pieces.next() {
            whole += piece;
            match pieces.peek() {
                Some(gap) if gap.trim().is_empty() && !gap.is_empty() => {
                    pieces.next();
                }
                Some(_) => whole.push('"'),
                None => {}
            }
        }
        whole.push('\n');
    }
    whole.split("\\\n").map(str::trim_start).collect::<String>()
}

/// The messages of a table: what the first cell of each row has as code.
fn messages(page: &str, heading: &str) -> Vec<String> {
    let (_, section) = page.split_once(heading).expect(heading);
    section
        .lines()
        .skip(1)
        .take_while(|line| !line.starts_with("## "))
        .filter(|line| line.starts_with("| `"))
        .flat_map(|line| {
            let cell = line[2..].split(" | ").next().unwrap_or_default();
            cell.split('`').skip(1).step_by(2).map(str::to_string)
        })
        .collect()
}

/// What of a message the source must have.
fn fixed_parts(message: &str) -> Vec<&str> {
    let punctuation: &[char] = &[' ', ':', ',', '=', '\''];
    message
        .split("...")
        .map(|part| {
            let caller = CALLERS.iter().find_map(|c| part.strip_prefix(c));
            caller.unwrap_or(part).trim_matches(punctuation)
        })
        .filter(|part| part.len() > 3)
        .collect()
}

#[test]
fn every_quoted_message_is_in_a_source() {
    let sources = sources();
    let mut faults = Vec::new();
    let mut seen = Vec::new();
    for (page, heading) in TABLES {
        let text = fs::read_to_string(root().join(page)).expect(page);
        for message in messages(&text, heading) {
            let of_an_engine = OF_ENGINES.iter().any(|begin| message.starts_with(begin));
            for part in fixed_parts(&message) {
                if !of_an_engine && !sources.contains(part) {
                    faults.push(format!("{page}: no source has '{part}' of '{message}'"));
                }
            }
            seen.push(message);
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(seen.len() > 60, "{}", seen.len());
    for begin in OF_ENGINES {
        assert!(
            seen.iter().any(|message| message.starts_with(begin)),
            "no page has: {begin}"
        );
    }
}

#[test]
fn the_parts_of_a_message() {
    assert_eq!(
        fixed_parts("Pair gran/ellipsoid: particle ... has semi-axes ..."),
        ["particle", "has semi-axes"]
    );
    let page = "# a\n## b\n| m | c |\n|---|---|\n| `x ... y`, `z` | no `w` |\n## c\n| `v` | |\n";
    assert_eq!(messages(page, "## b"), ["x ... y", "z"]);
}
