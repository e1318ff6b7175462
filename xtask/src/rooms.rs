// SPDX-License-Identifier: MIT OR Apache-2.0
//! The rooms of the library: which of them may use which, as the table in ARCHITECTURE.md says, and no circle between files.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use anyhow::{anyhow, bail, Context, Result};
use proc_macro2::{Delimiter, TokenStream, TokenTree};

use crate::progress::say;
use crate::workspace;

/// Fails on the first use of one room by another that the table does not allow, and on a circle between files.
pub fn check() -> Result<()> {
    let root = workspace::root();
    let drawing = fs::read_to_string(root.join("ARCHITECTURE.md"))?;
    let files = read_files(&root.join("src"))?;
    let found = faults(&allowed(&drawing)?, &files);
    if !found.is_empty() {
        bail!(
            "the sources and the table of rooms in ARCHITECTURE.md differ\n{}",
            found.join("\n")
        );
    }
    say("no file uses a room that ARCHITECTURE.md does not allow, and there is no circle between files");
    Ok(())
}

/// A module as its file has it: `list::batch`; `list` for `list/mod.rs`.
type Module = Vec<String>;

/// Modules and their sources.
type Files = BTreeMap<Module, String>;

/// Room by room the rooms that it may use.
type Arrows = BTreeMap<String, BTreeSet<String>>;

/// The rows of the table whose first column names something in `src`: `` | `src/list/` | ... | `contact`, `simd` | ``.
fn allowed(drawing: &str) -> Result<Arrows> {
    let mut arrows = Arrows::new();
    for line in drawing.lines() {
        let columns: Vec<&str> = line.split('|').map(str::trim).collect();
        let Some(room) = columns.get(1).and_then(|c| c.strip_prefix("`src/")) else {
            continue;
        };
        let room = room.trim_end_matches('`').trim_end_matches('/');
        let uses = columns
            .get(3)
            .with_context(|| format!("ARCHITECTURE.md: {room} has no column of what it uses"))?;
        let uses = uses.split('`').skip(1).step_by(2).map(str::to_owned);
        arrows.insert(room.trim_end_matches(".rs").to_owned(), uses.collect());
    }
    if arrows.is_empty() {
        return Err(anyhow!("ARCHITECTURE.md has no table of rooms"));
    }
    Ok(arrows)
}

fn read_files(directory: &Path) -> Result<Files> {
    let mut files = Files::new();
    let mut open = vec![(directory.to_owned(), Module::new())];
    while let Some((directory, module)) = open.pop() {
        for entry in fs::read_dir(&directory)? {
            let path = entry?.path();
            let name = path.file_stem().unwrap_or_default().to_string_lossy();
            let mut inner = module.clone();
            if path.is_dir() || !matches!(&*name, "mod" | "lib") {
                inner.push(name.into_owned());
            }
            if path.is_dir() {
                open.push((path, inner));
            } else if path.extension().is_some_and(|e| e == "rs") {
                files.insert(inner, fs::read_to_string(&path)?);
            }
        }
    }
    Ok(files)
}

/// What is against the drawing, in words.
fn faults(allowed: &Arrows, files: &Files) -> Vec<String> {
    let mut found = Vec::new();
    let mut arrows: BTreeMap<Module, BTreeSet<Module>> = BTreeMap::new();
    for (module, text) in files {
        let Ok(tokens) = text.parse::<TokenStream>() else {
            found.push(format!("src/{}: no Rust", module.join("/")));
            continue;
        };
        let Some(room) = module.first() else {
            // lib.rs names the rooms.
            continue;
        };
        if !allowed.contains_key(room) {
            found.push(format!("{room} is not in the table of rooms"));
        }
        for path in paths(tokens) {
            let Some(target) = file_of(&path, module, files) else {
                continue;
            };
            if target[0] != *room && !allowed.get(room).is_some_and(|a| a.contains(&target[0])) {
                found.push(format!(
                    "{} uses {}: {room} must not use {}",
                    module.join("::"),
                    target.join("::"),
                    target[0]
                ));
            }
            // A room's own file names its files.
            let names_its_files = target.len() > module.len() && target.starts_with(module);
            if target != *module && !names_its_files {
                arrows.entry(module.clone()).or_default().insert(target);
            }
        }
    }
    let mut done = BTreeSet::new();
    for module in arrows.keys() {
        let mut way = Vec::new();
        if let Some(circle) = circle(module, &arrows, &mut way, &mut done) {
            // Named once, not again from each of its files.
            done.extend(way);
            let names: Vec<String> = circle.iter().map(|m| m.join("::")).collect();
            found.push(format!("a circle: {}", names.join(" -> ")));
        }
    }
    found.dedup();
    found
}

/// The circle that is entered from a module, if there is one.
fn circle(
    module: &Module,
    arrows: &BTreeMap<Module, BTreeSet<Module>>,
    way: &mut Vec<Module>,
    done: &mut BTreeSet<Module>,
) -> Option<Vec<Module>> {
    if let Some(from) = way.iter().position(|m| m == module) {
        let mut circle = way[from..].to_vec();
        circle.push(module.clone());
        return Some(circle);
    }
    if !done.contains(module) {
        way.push(module.clone());
        for next in arrows.get(module).into_iter().flatten() {
            if let Some(circle) = circle(next, arrows, way, done) {
                return Some(circle);
            }
        }
        way.pop();
        done.insert(module.clone());
    }
    None
}

/// The file in which a path from `module` ends. A name that a room's `mod.rs` hands on is in the file that defines it.
fn file_of(path: &[String], module: &Module, files: &Files) -> Option<Module> {
    let mut at = match path[0].as_str() {
        "crate" => Module::new(),
        _ => module.clone(),
    };
    let levels = path.iter().take_while(|name| *name == "super").count();
    at.truncate(at.len().saturating_sub(levels));
    let mut rest = &path[levels.max(1)..];
    while let Some((name, others)) = rest.split_first() {
        let mut inner = at.clone();
        inner.push(name.clone());
        if !files.keys().any(|m| m.starts_with(&inner)) {
            break;
        }
        (at, rest) = (inner, others);
    }
    if at.is_empty() {
        return None;
    }
    let Some(name) = rest.first() else {
        return Some(at);
    };
    // Through the names that `mod.rs` hands on.
    if !files
        .keys()
        .any(|m| m.len() > at.len() && m.starts_with(&at))
    {
        return Some(at);
    }
    let tokens = files.get(&at)?.parse::<TokenStream>().ok()?;
    let handed_on = use_items(tokens)
        .into_iter()
        .find(|p| p.last() == Some(name) && p.len() > 1);
    match handed_on {
        Some(path) => {
            let mut inner = at.clone();
            inner.push(path[0].clone());
            Some(if files.contains_key(&inner) {
                inner
            } else {
                at
            })
        }
        None => Some(at),
    }
}

/// The paths that begin with `crate`, `self` or `super`, wherever they stand, tests left out.
fn paths(tokens: TokenStream) -> Vec<Vec<String>> {
    let mut all = Vec::new();
    walk(tokens, &mut |path| {
        if matches!(path[0].as_str(), "crate" | "self" | "super") && path.len() > 1 {
            all.push(path);
        }
    });
    all
}

/// The paths of all `use` items that begin with neither of these, as those of a `mod.rs` do.
fn use_items(tokens: TokenStream) -> Vec<Vec<String>> {
    let mut all = Vec::new();
    walk(tokens, &mut |path| all.push(path));
    all
}

/// Every path `a::b::c`, with those of `a::{b, c::d}` one by one.
fn walk(tokens: TokenStream, found: &mut impl FnMut(Vec<String>)) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut k = 0;
    while k < tokens.len() {
        if is_test(&tokens[k..]) {
            // The attribute and the module that follows it.
            k += tokens[k..]
                .iter()
                .position(|t| matches!(t, TokenTree::Group(g) if g.delimiter() == Delimiter::Brace))
                .map_or(tokens.len(), |body| body + 1);
            continue;
        }
        match &tokens[k] {
            TokenTree::Ident(_) => k = path(&tokens, k, Vec::new(), found),
            TokenTree::Group(group) => {
                walk(group.stream(), found);
                k += 1;
            }
            _ => k += 1,
        }
    }
}

/// Whether `#[cfg(test)] mod` stands here.
fn is_test(tokens: &[TokenTree]) -> bool {
    let [TokenTree::Punct(hash), TokenTree::Group(group), TokenTree::Ident(word), ..] = tokens
    else {
        return false;
    };
    let attribute: String = group.stream().to_string().split_whitespace().collect();
    hash.as_char() == '#' && attribute == "cfg(test)" && word == "mod"
}

/// Takes the path that begins with the identifier at `k`, and says where it ends.
fn path(
    tokens: &[TokenTree],
    mut k: usize,
    mut before: Vec<String>,
    found: &mut impl FnMut(Vec<String>),
) -> usize {
    while let Some(TokenTree::Ident(name)) = tokens.get(k) {
        before.push(name.to_string());
        k += 1;
        let colons =
            |at: usize| matches!(tokens.get(at), Some(TokenTree::Punct(p)) if p.as_char() == ':');
        if !(colons(k) && colons(k + 1)) {
            found(before);
            return k;
        }
        k += 2;
    }
    match tokens.get(k) {
        Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace => {
            let inner: Vec<TokenTree> = group.stream().into_iter().collect();
            let mut at = 0;
            while at < inner.len() {
                at = match &inner[at] {
                    TokenTree::Ident(word) if word == "self" => {
                        found(before.clone());
                        at + 1
                    }
                    TokenTree::Ident(_) => path(&inner, at, before.clone(), found),
                    _ => at + 1,
                };
            }
            k + 1
        }
        // Generic arguments, a star, a macro.
        _ => {
            found(before);
            k
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{allowed, faults, Files};

    const DRAWING: &str = "\
| room | question | uses |
|---|---|---|
| `src/number.rs` | what is a number | |
| `src/low/` | what is below | `number` |
| `src/high/` | what is above | `low`, `number` |
";

    fn files(sources: &[(&str, &str)]) -> Files {
        let module = |name: &str| name.split("::").map(str::to_owned).collect();
        (sources.iter())
            .map(|(name, text)| (module(name), (*text).to_owned()))
            .collect()
    }

    fn found(sources: &[(&str, &str)]) -> Vec<String> {
        faults(&allowed(DRAWING).unwrap(), &files(sources))
    }

    const GOOD: &[(&str, &str)] = &[
        ("number", "pub struct Number;"),
        ("low", "pub mod a; mod b; pub use a::A;"),
        ("low::a", "pub struct A(crate::number::Number);"),
        (
            "low::b",
            "use super::a::A; #[cfg(test)] mod tests { use crate::high::c::C; }",
        ),
        ("high", "pub mod c;"),
        ("high::c", "use crate::{low::A, number::{self, Number}};"),
    ];

    #[test]
    fn what_the_table_allows_is_no_fault() {
        assert_eq!(found(GOOD), Vec::<String>::new());
    }

    #[test]
    fn an_arrow_against_the_table_is_named() {
        for wrong in [
            "use crate::high::c::C;",
            "fn f() -> crate::high::c::C { crate::high::c::C }",
            "use crate::{number, high::c};",
            "macro_rules! m { () => { super::super::high::c::C }; }",
        ] {
            let mut sources = GOOD.to_vec();
            sources[3].1 = wrong;
            let found = found(&sources);
            assert_eq!(
                found,
                ["low::b uses high::c: low must not use high"],
                "{wrong}"
            );
        }
    }

    #[test]
    fn a_circle_between_files_is_named() {
        for wrong in [
            "use super::b::B;",
            "use crate::low::b;",
            "type T = super::b::B;",
        ] {
            let mut sources = GOOD.to_vec();
            sources[2].1 = wrong;
            assert_eq!(
                found(&sources),
                ["a circle: low::a -> low::b -> low::a"],
                "{wrong}"
            );
        }
    }

    #[test]
    fn a_circle_through_a_name_handed_on_is_named() {
        let mut sources = GOOD.to_vec();
        sources[3].1 = "use super::A;";
        sources[2].1 = "use super::b::B;";
        assert_eq!(found(&sources), ["a circle: low::a -> low::b -> low::a"]);
    }

    #[test]
    fn a_room_that_is_not_drawn_is_named() {
        let mut sources = GOOD.to_vec();
        sources.push(("attic", "pub struct Attic;"));
        assert_eq!(found(&sources), ["attic is not in the table of rooms"]);
    }

    #[test]
    fn the_library_is_as_drawn() {
        super::check().unwrap();
    }
}
