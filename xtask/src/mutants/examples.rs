// SPDX-License-Identifier: MIT OR Apache-2.0
//! The examples of the documentation as one program of tests: rustdoc would compile each with the library, mutant by mutant.

use std::fs;
use std::path::Path;

use anyhow::Result;

/// All examples of the files below a folder.
pub fn examples_of(folder: &Path) -> Result<String> {
    let mut files = Vec::new();
    collect(folder, &mut files)?;
    files.sort();
    let mut text = String::new();
    for (number, example) in files.iter().flat_map(|file| examples(file)).enumerate() {
        text += &test(number, &example);
    }
    Ok(text)
}

/// The texts of the files, not the files.
fn collect(folder: &Path, texts: &mut Vec<String>) -> Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, texts)?;
        } else if path.extension().is_some_and(|e| e == "rs") {
            texts.push(fs::read_to_string(&path)?);
        }
    }
    Ok(())
}

/// What stands between fences that name no other language, in comments that document.
fn examples(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut open: Option<(bool, String)> = None;
    for line in text.lines() {
        let line = line.trim_start();
        let documents = line.strip_prefix("//!").or(line.strip_prefix("///"));
        let Some(line) = documents else {
            open = None;
            continue;
        };
        let line = line.strip_prefix(' ').unwrap_or(line);
        if let Some(language) = line.trim_start().strip_prefix("```") {
            open = match open {
                None => Some((matches!(language, "" | "rust"), String::new())),
                Some((runs, example)) => {
                    found.extend(runs.then_some(example));
                    None
                }
            };
        } else if let Some((_, example)) = &mut open {
            // Hidden lines.
            let line = if line == "#" { "" } else { line };
            *example += line.strip_prefix("# ").unwrap_or(line);
            *example += "\n";
        }
    }
    found
}

/// As rustdoc has it: one that ends with `Ok` returns a result.
fn test(number: usize, example: &str) -> String {
    let (result, end) = if example.contains("\nOk::<") {
        (" -> Result<(), impl std::fmt::Debug>", ".unwrap()")
    } else {
        ("", "")
    };
    format!("#[test]\nfn example_{number}() {{\nfn run(){result} {{\n{example}}}\nrun(){end}\n}}\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn examples_are_found_and_become_tests() {
        let text = "//! Words.\n//! ```\n//! # use a::b;\n//! assert!(b());\n//! # Ok::<(), ()>(())\n//! ```\n//! ```text\n//! x\n//! ```\n";
        let found = examples(text);
        assert_eq!(found, ["use a::b;\nassert!(b());\nOk::<(), ()>(())\n"]);
        assert!(syn::parse_file(&test(0, &found[0])).is_ok());
    }
}
