// SPDX-License-Identifier: MIT OR Apache-2.0
//! include/ellgran.h and include/ellgran_gpu.h, written from the Rust sources, and Python's declarations, written from the first; and all
//! of them checked.

use std::fs;
use std::path::Path;

use anyhow::{anyhow, bail, Context, Result};

use crate::law_tables::c_items;
use crate::progress::say;
use crate::python_interface::python_interface;
use crate::workspace;

pub fn header(check: bool) -> Result<()> {
    let root = workspace::root();
    let directory = tempfile::tempdir()?;
    let tables = directory.path().join("law_tables.rs");
    fs::write(&tables, c_items(&root)?)?;
    let generated = generate(&root, Some(&tables))?;
    let of_gpu = generate(&root.join("gpu/driver"), None)?;
    let files = [
        (
            "python/ellgran/_interface.py",
            python_interface(&generated)?,
            "src/c_api",
        ),
        ("include/ellgran.h", generated, "src/c_api"),
        ("include/ellgran_gpu.h", of_gpu, "gpu/driver/src"),
    ];
    for (name, text, source) in files {
        let path = root.join(name);
        if check {
            let committed = fs::read_to_string(&path)
                .with_context(|| format!("cannot read {}", path.display()))?;
            if let Some(difference) = first_difference(&committed, &text) {
                bail!("{name} has drifted from {source}: run `cargo xtask header`\n{difference}");
            }
            say(format!("{name} is what {source} says"));
        } else {
            if let Some(directory) = path.parent() {
                fs::create_dir_all(directory)?;
            }
            fs::write(&path, text)?;
            say(format!("wrote {}", path.display()));
        }
    }
    Ok(())
}

/// The header of a crate, by the `cbindgen.toml` beside its manifest, with the items of one more source.
fn generate(of: &Path, with: Option<&Path>) -> Result<String> {
    let config = cbindgen::Config::from_file(of.join("cbindgen.toml"))
        .map_err(|error| anyhow!("{}/cbindgen.toml: {error}", of.display()))?;
    let mut builder = cbindgen::Builder::new();
    if let Some(source) = with {
        builder = builder.with_src(source);
    }
    let bindings = builder
        .with_crate(of)
        .with_config(config)
        .generate()
        .with_context(|| format!("cbindgen cannot read {}", of.display()))?;
    let mut bytes = Vec::new();
    bindings.write(&mut bytes);
    Ok(String::from_utf8(bytes)?)
}

fn first_difference(committed: &str, generated: &str) -> Option<String> {
    let mut left = committed.lines();
    let mut right = generated.lines();
    for number in 1.. {
        match (left.next(), right.next()) {
            (None, None) => break,
            (a, b) if a == b => {}
            (a, b) => {
                return Some(format!(
                    "line {number}\n  committed: {}\n  generated: {}",
                    a.unwrap_or("(end of file)"),
                    b.unwrap_or("(end of file)")
                ));
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::first_difference;

    #[test]
    fn the_first_differing_line_is_named() {
        assert_eq!(first_difference("a\nb\n", "a\nb\n"), None);
        let difference = first_difference("a\nb\n", "a\nc\n").unwrap();
        assert!(difference.contains("line 2") && difference.contains("generated: c"));
        assert!(first_difference("a\n", "a\nb\n")
            .unwrap()
            .contains("committed: (end of file)"));
    }
}
