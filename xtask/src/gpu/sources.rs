// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the PTX is made from: one number for all of it.
//!
//! Comments, tests, and what needs `std` do not count: a change of them makes the same PTX.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{anyhow, Context, Result};
use proc_macro2::{Delimiter, TokenStream, TokenTree};
use sha2::{Digest, Sha256};

use crate::workspace::root;

/// Crates whose modules count, by their first files.
const CRATES: [&str; 3] = ["src/lib.rs", "gpu/kernels/src/lib.rs", "gpu/ptx/src/lib.rs"];
/// Files that count as they are.
const FILES: [&str; 6] = [
    "gpu/core/Cargo.toml",
    "gpu/kernels/Cargo.toml",
    "gpu/ptx/Cargo.toml",
    "gpu/ptx/Cargo.lock",
    "gpu/ptx/rust-toolchain.toml",
    "gpu/ptx/.cargo/config.toml",
];

/// SHA-256 of the sources, in hexadecimal.
pub fn hash() -> Result<String> {
    let mut text = String::new();
    for name in FILES {
        text += &read(&root().join(name))?;
    }
    for name in CRATES {
        module(&root().join(name), &mut text)?;
    }
    let digest = Sha256::digest(text.as_bytes());
    Ok(digest.iter().map(|byte| format!("{byte:02x}")).collect())
}

fn read(path: &Path) -> Result<String> {
    fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))
}

/// A file of Rust, then the files of its modules.
fn module(path: &Path, text: &mut String) -> Result<()> {
    let tokens: TokenStream = read(path)?
        .parse()
        .map_err(|error| anyhow!("{}: {error}", path.display()))?;
    let mut modules = Vec::new();
    items(tokens, text, &mut modules);
    for name in modules {
        module(&file_of(path, &name)?, text)?;
    }
    Ok(())
}

/// Where the module `name` of the file at `path` is.
fn file_of(path: &Path, name: &str) -> Result<PathBuf> {
    let directory = path.parent().context("a file is in a directory")?;
    let stem = path.file_stem().unwrap_or_default();
    let directory = if stem == "lib" || stem == "mod" {
        directory.to_owned()
    } else {
        directory.join(stem)
    };
    [format!("{name}.rs"), format!("{name}/mod.rs")]
        .map(|file| directory.join(file))
        .into_iter()
        .find(|file| file.is_file())
        .with_context(|| format!("{}: no file of the module {name}", path.display()))
}

/// Whether an attribute says that its item is not in the PTX.
fn leaves_out(attribute: &str) -> bool {
    attribute == "cfg(test)"
        || attribute == "cfg(feature=\"std\")"
        || attribute.starts_with("cfg(all(feature=\"std\",")
        || attribute.starts_with("cfg(all(test,")
        || attribute.starts_with("cfg(all(doctest,")
}

/// The tokens that count, and the modules in files of their own.
fn items(tokens: TokenStream, text: &mut String, modules: &mut Vec<String>) {
    let mut tokens = tokens.into_iter().peekable();
    let mut left_out = false;
    let mut before: [String; 2] = Default::default();
    while let Some(token) = tokens.next() {
        // An attribute: `#`, perhaps `!`, and brackets.
        if matches!(&token, TokenTree::Punct(p) if p.as_char() == '#') {
            let mut inner = false;
            if matches!(tokens.peek(), Some(TokenTree::Punct(p)) if p.as_char() == '!') {
                tokens.next();
                inner = true;
            }
            if let Some(TokenTree::Group(group)) = tokens.next() {
                let mut attribute = String::new();
                items(group.stream(), &mut attribute, &mut Vec::new());
                let attribute = attribute.replace(' ', "");
                left_out |= !inner && leaves_out(&attribute);
                let says_nothing = attribute.starts_with("doc") || attribute.starts_with("allow(");
                if !says_nothing && !left_out {
                    *text += &attribute;
                }
            }
            continue;
        }
        let ends = match &token {
            TokenTree::Punct(p) => p.as_char() == ';' || (p.as_char() == ',' && left_out),
            TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
            _ => false,
        };
        let now = match &token {
            TokenTree::Group(_) => String::new(),
            other => other.to_string(),
        };
        if now == ";" && before[0] == "mod" && !left_out {
            modules.push(before[1].clone());
        }
        if !left_out {
            if let TokenTree::Group(group) = &token {
                *text += "(";
                items(group.stream(), text, modules);
                *text += ")";
            } else {
                *text += &now;
                *text += " ";
            }
        }
        let [_, last] = before;
        before = [last, now];
        if ends {
            left_out = false;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> (String, Vec<String>) {
        let (mut found, mut modules) = (String::new(), Vec::new());
        items(text.parse().unwrap(), &mut found, &mut modules);
        (found, modules)
    }

    #[test]
    fn comments_tests_and_std_do_not_count() {
        let plain = of("pub mod a; fn f() -> f64 { 1.0 }");
        assert_eq!(plain.1, ["a"]);
        let more = of(
            "//! About.\n/// More.\npub mod a;\n#[cfg(feature = \"std\")]\npub mod b;\n\
             #[cfg(feature = \"std\")] fn g() { 2.0 }\nfn f() -> f64 { // One.\n 1.0 }\n\
             #[cfg(test)]\nmod tests { fn t() {} }",
        );
        assert_eq!(plain, more);
        assert_ne!(plain.0, of("pub mod a; fn f() -> f64 { 1.5 }").0);
        assert_ne!(plain.0, of("#[inline] pub mod a; fn f() -> f64 { 1.0 }").0);
    }

    #[test]
    fn a_hash_is_found() {
        assert_eq!(hash().unwrap().len(), 64);
    }
}
