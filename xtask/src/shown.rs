// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which public items of the Rust interface does no example show? Examples are the doc tests of `src`, the Rust of README.md, and
//! examples/rust. An item is shown where its name is in the code of one: a function or type by its name, a method as `.name` or
//! `Type::name`, an associated constant as `Type::NAME`. A type is also shown where a function that is shown takes or gives it, or
//! where it is a public field of a type that is shown.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use anyhow::{bail, Context, Result};
use syn::{Attribute, ImplItem, Item, Meta, UseTree, Visibility};

use crate::progress::say;
use crate::workspace;

/// Modules and items without an example, and why users do without.
const NOT_FOR_USERS: &[(&str, &str)] = &[
    (
        "c_api",
        "the C interface: its header documents it, examples/c show it",
    ),
    (
        "real",
        "what the numbers in lanes can do: for laws, docs/how-to-add-a-law.md",
    ),
    ("simd::lanes", "the same numbers over registers"),
    (
        "simd::registers",
        "what an instruction set gives: docs/how-to-add-an-instruction-set.md",
    ),
    (
        "contact::forces",
        "the law in lanes: `one_contact`, lists and walls call it",
    ),
    ("contact::lane_search", "the search in lanes: lists call it"),
    ("contact::pair", "what `one_contact` is made of"),
    ("geometry::convex_body", "what the searches ask of a body"),
    ("geometry::spheroid", "the body of the lanes for spheroids"),
    (
        "geometry::small_motion",
        "how long candidates of lists and walls stay valid",
    ),
    ("list::records", "particles as the lanes load them"),
    (
        "walls::lane_pass",
        "what a call for a wall does in lanes, which `is_taken_in_lanes` tells",
    ),
    (
        "geometry::ellipsoid::AxesInBody",
        "an ellipsoid in the frame of a contact, for the searches",
    ),
    (
        "list::workspace::Workspace::prepare_chosen_records",
        "for a wall in lanes",
    ),
    (
        "list::workspace::Workspace::chosen_records",
        "for a wall in lanes",
    ),
    (
        "walls::motion::Motion::seen_from_wall",
        "a step of a wall in its own frame: `compute_wall` takes it",
    ),
    (
        "walls::motion::Motion::surface_to_world",
        "the way back from that frame",
    ),
    (
        "walls::shape",
        "what a new shape answers: docs/how-to-add-a-wall.md",
    ),
];

/// Fails where a public item is in no example.
pub fn check() -> Result<()> {
    let root = workspace::root();
    let interface = Interface::read(&root.join("src"))?;
    let mut code = interface.examples.clone();
    code += &rust_of_markdown(&fs::read_to_string(root.join("README.md"))?);
    for entry in fs::read_dir(root.join("examples/rust"))? {
        code += &fs::read_to_string(entry?.path())?;
    }
    let missing = interface.not_in(&code);
    if !missing.is_empty() {
        bail!(
            "{} public items are in no example (a doc test, README.md, examples/rust):\n{}",
            missing.len(),
            missing.join("\n")
        );
    }
    say(format!(
        "all {} public items are in an example",
        interface.items.len()
    ));
    Ok(())
}

/// A public item: where it is, and how an example would have it.
#[derive(Debug, PartialEq)]
struct Shown {
    path: String,
    /// One of these is in the code.
    by: Vec<String>,
    /// The types that come with it: those of its signature or of its public fields.
    with: BTreeSet<String>,
}

#[derive(Default)]
struct Interface {
    items: Vec<Shown>,
    examples: String,
    /// Public types, whose methods are public too.
    types: BTreeSet<String>,
    /// Methods and associated items: the type, and the item.
    methods: Vec<(String, Shown)>,
}

impl Interface {
    fn read(source: &Path) -> Result<Self> {
        let mut interface = Interface::default();
        interface.file(&source.join("lib.rs"), source, &[], None)?;
        let types = std::mem::take(&mut interface.types);
        let methods = std::mem::take(&mut interface.methods).into_iter();
        let of_types = methods.filter(|(name, _)| types.contains(name));
        interface.items.extend(of_types.map(|(_, item)| item));
        interface.items.retain(|item| is_for_users(&item.path));
        Ok(interface)
    }

    /// A file of a module, whose own modules lie in `directory`; `names` are those that are public elsewhere, where the module is not.
    fn file(
        &mut self,
        file: &Path,
        directory: &Path,
        module: &[String],
        names: Option<&BTreeSet<String>>,
    ) -> Result<()> {
        let text =
            fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))?;
        let parsed =
            syn::parse_file(&text).with_context(|| format!("{} is no Rust", file.display()))?;
        self.examples += &code_of(&parsed.attrs);
        self.items(&parsed.items, directory, module, names)
    }

    fn items(
        &mut self,
        items: &[Item],
        directory: &Path,
        module: &[String],
        names: Option<&BTreeSet<String>>,
    ) -> Result<()> {
        let path = module.join("::");
        let exported: Vec<_> = items
            .iter()
            .filter_map(|item| match item {
                Item::Use(item) if is_public(&item.vis) => Some(&item.tree),
                _ => None,
            })
            .collect();
        for item in items {
            let (attributes, visibility, name, is_type) = match item {
                Item::Fn(i) => (&i.attrs, &i.vis, i.sig.ident.to_string(), false),
                Item::Struct(i) => (&i.attrs, &i.vis, i.ident.to_string(), true),
                Item::Enum(i) => (&i.attrs, &i.vis, i.ident.to_string(), true),
                Item::Trait(i) => (&i.attrs, &i.vis, i.ident.to_string(), false),
                Item::Type(i) => (&i.attrs, &i.vis, i.ident.to_string(), false),
                Item::Const(i) => (&i.attrs, &i.vis, i.ident.to_string(), false),
                Item::Static(i) => (&i.attrs, &i.vis, i.ident.to_string(), false),
                Item::Mod(i) if !is_for_tests(&i.attrs) => {
                    self.module(i, directory, module, names, &exported)?;
                    continue;
                }
                Item::Impl(i) if i.trait_.is_none() => {
                    self.examples += &code_of(&i.attrs);
                    if let syn::Type::Path(of) = &*i.self_ty {
                        let of = of.path.segments.last().map(|s| s.ident.to_string());
                        self.methods_of(&of.unwrap_or_default(), &i.items, &path);
                    }
                    continue;
                }
                _ => continue,
            };
            self.examples += &code_of(attributes);
            let public = is_public(visibility) && !is_hidden(attributes);
            if !public || names.is_some_and(|names| !names.contains(&name)) {
                continue;
            }
            if is_type {
                self.types.insert(name.clone());
            }
            self.items.push(Shown {
                path: format!("{path}::{name}"),
                by: vec![name],
                with: match item {
                    Item::Fn(i) => words(&i.sig),
                    Item::Struct(i) => public_fields(i),
                    Item::Enum(i) => words(&i.variants),
                    Item::Type(i) => words(&i.ty),
                    _ => BTreeSet::new(),
                },
            });
        }
        Ok(())
    }

    fn module(
        &mut self,
        item: &syn::ItemMod,
        directory: &Path,
        module: &[String],
        names: Option<&BTreeSet<String>>,
        exported: &[&UseTree],
    ) -> Result<()> {
        let name = item.ident.to_string();
        let mut inner = module.to_vec();
        inner.push(name.clone());
        // What is public of a private module is what the module above exports from it.
        let from_above = if is_public(&item.vis) {
            names.cloned()
        } else {
            let mut found = BTreeSet::new();
            exported
                .iter()
                .for_each(|tree| export(tree, &name, &mut found));
            if let Some(names) = names {
                found.retain(|one| names.contains(one));
            }
            Some(found)
        };
        self.examples += &code_of(&item.attrs);
        if let Some((_, items)) = &item.content {
            return self.items(items, &directory.join(&name), &inner, from_above.as_ref());
        }
        let flat = directory.join(format!("{name}.rs"));
        let file = if flat.is_file() {
            flat
        } else {
            directory.join(&name).join("mod.rs")
        };
        self.file(&file, &directory.join(&name), &inner, from_above.as_ref())
    }

    fn methods_of(&mut self, of: &str, items: &[ImplItem], path: &str) {
        for item in items {
            let (attributes, visibility, name, method) = match item {
                ImplItem::Fn(i) => (&i.attrs, &i.vis, &i.sig.ident, i.sig.receiver().is_some()),
                ImplItem::Const(i) => (&i.attrs, &i.vis, &i.ident, false),
                _ => continue,
            };
            let with = match item {
                ImplItem::Fn(i) => words(&i.sig),
                _ => BTreeSet::new(),
            };
            self.examples += &code_of(attributes);
            if !is_public(visibility) || is_hidden(attributes) {
                continue;
            }
            let mut by = vec![format!("{of}::{name}")];
            if method {
                by.push(format!(".{name}"));
            }
            let path = format!("{path}::{of}::{name}");
            self.methods
                .push((of.to_string(), Shown { path, by, with }));
        }
    }

    /// The items that a code does not have.
    fn not_in(&self, code: &str) -> Vec<String> {
        let named = |item: &Shown| item.by.iter().any(|name| has(code, name));
        let mut shown: Vec<bool> = self.items.iter().map(named).collect();
        // The types that come with what is shown, and those that come with these.
        loop {
            let known = self.items.iter().zip(&shown).filter(|(_, shown)| **shown);
            let come: BTreeSet<&String> = known.flat_map(|(item, _)| &item.with).collect();
            let comes = |item: &Shown| !item.by[0].contains("::") && come.contains(&item.by[0]);
            let before = shown.clone();
            for (shown, item) in shown.iter_mut().zip(&self.items) {
                *shown |= comes(item);
            }
            if shown == before {
                break;
            }
        }
        let missing = self.items.iter().zip(&shown).filter(|(_, shown)| !**shown);
        let missing: BTreeSet<String> = missing.map(|(item, _)| item.path.clone()).collect();
        missing.into_iter().collect()
    }
}

/// The identifiers of a piece of source.
fn words(of: &impl quote::ToTokens) -> BTreeSet<String> {
    let text = of.to_token_stream().to_string();
    let separates = |c: char| !(c.is_alphanumeric() || c == '_');
    text.split(separates)
        .filter(|word| word.starts_with(char::is_uppercase))
        .map(str::to_owned)
        .collect()
}

fn public_fields(item: &syn::ItemStruct) -> BTreeSet<String> {
    let fields = item.fields.iter().filter(|field| is_public(&field.vis));
    fields.flat_map(|field| words(&field.ty)).collect()
}

fn is_for_users(path: &str) -> bool {
    let within = |of: &str| path == of || path.starts_with(&format!("{of}::"));
    !NOT_FOR_USERS.iter().any(|(one, _)| within(one))
}

/// Whether a name is there as a whole word.
fn has(code: &str, name: &str) -> bool {
    let part_of_a_word = |c: char| c.is_alphanumeric() || c == '_';
    code.match_indices(name).any(|(at, _)| {
        let before = code[..at].chars().next_back();
        let after = code[at + name.len()..].chars().next();
        let begins = name.starts_with('.') || !before.is_some_and(part_of_a_word);
        begins && !after.is_some_and(part_of_a_word)
    })
}

fn is_public(visibility: &Visibility) -> bool {
    matches!(visibility, Visibility::Public(_))
}

fn is_for_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let Meta::List(list) = &attribute.meta else {
            return false;
        };
        list.path.is_ident("cfg") && list.tokens.to_string() == "test"
    })
}

fn is_hidden(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        Meta::List(list) => list.path.is_ident("doc") && list.tokens.to_string() == "hidden",
        _ => false,
    })
}

/// The names that a `pub use` takes from a module.
fn export(tree: &UseTree, module: &str, names: &mut BTreeSet<String>) {
    match tree {
        UseTree::Path(path) if path.ident == module => leaves(&path.tree, names),
        UseTree::Path(path) if path.ident == "self" => export(&path.tree, module, names),
        UseTree::Group(group) => group
            .items
            .iter()
            .for_each(|item| export(item, module, names)),
        _ => {}
    }
}

fn leaves(tree: &UseTree, names: &mut BTreeSet<String>) {
    match tree {
        UseTree::Name(name) => {
            names.insert(name.ident.to_string());
        }
        UseTree::Rename(rename) => {
            names.insert(rename.ident.to_string());
        }
        UseTree::Path(path) => leaves(&path.tree, names),
        UseTree::Group(group) => group.items.iter().for_each(|item| leaves(item, names)),
        UseTree::Glob(_) => {}
    }
}

/// The code blocks of a comment.
fn code_of(attributes: &[Attribute]) -> String {
    let mut text = String::new();
    for attribute in attributes {
        let Meta::NameValue(value) = &attribute.meta else {
            continue;
        };
        if let syn::Expr::Lit(syn::ExprLit {
            lit: syn::Lit::Str(line),
            ..
        }) = &value.value
        {
            if value.path.is_ident("doc") {
                text += &line.value();
                text.push('\n');
            }
        }
    }
    blocks(&text, |language| {
        language.is_empty() || language.starts_with("rust") || language == "should_panic"
    })
}

fn rust_of_markdown(text: &str) -> String {
    blocks(text, |language| language.starts_with("rust"))
}

fn blocks(text: &str, wanted: impl Fn(&str) -> bool) -> String {
    let mut code = String::new();
    // The language of the block that is open.
    let mut open: Option<String> = None;
    for line in text.lines() {
        match (line.trim().strip_prefix("```"), &open) {
            (Some(language), None) => open = Some(language.trim().to_string()),
            (Some(_), Some(_)) => open = None,
            (None, Some(language)) if wanted(language) => {
                code += line;
                code.push('\n');
            }
            _ => {}
        }
    }
    code
}

#[cfg(test)]
mod tests {
    use super::*;

    fn missing(sources: &[(&str, &str)]) -> Vec<String> {
        let directory = tempfile::tempdir().unwrap();
        for (name, text) in sources {
            let path = directory.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        let interface = Interface::read(directory.path()).unwrap();
        interface.not_in(&interface.examples)
    }

    #[test]
    fn every_public_item_is_in_an_example() {
        check().unwrap();
    }

    #[test]
    fn an_item_is_shown_by_its_own_example_or_another_ones() {
        let shown = "pub mod a;\n/// ```\n/// crate::a::f(1);\n/// let b = B::new();\n/// b.size();\n/// ```\npub struct B;\n\
                     impl B { pub fn new() -> B { B } pub fn size(&self) {} pub fn other(&self) {} fn own(&self) {} }";
        let file = (
            "a.rs",
            "pub fn f(x: i32) {}\npub fn g() {}\npub(crate) fn h() {}\n",
        );
        assert_eq!(missing(&[("lib.rs", shown), file]), ["::B::other", "a::g"]);
    }

    #[test]
    fn a_type_is_shown_with_what_takes_or_has_it() {
        let lib = "/// ```\n/// f();\n/// ```\npub fn f() -> Result<A, E> {}\npub struct A { pub b: B, c: C }\npub struct B;\npub struct C;\n\
                   pub enum E { One(D) }\npub struct D;\nimpl D { pub fn d(&self) {} }";
        assert_eq!(missing(&[("lib.rs", lib)]), ["::C", "::D::d"]);
    }

    #[test]
    fn of_a_private_module_only_what_is_exported_counts() {
        let lib = "mod a;\npub use a::{f, C};\n";
        let file = (
            "a/mod.rs",
            "pub fn f() {}\npub fn g() {}\npub struct C;\nimpl C { pub const N: usize = 1; }\npub struct D;\nimpl D { pub fn d(&self) {} }\n\
             #[cfg(test)] mod tests { pub fn t() {} }",
        );
        assert_eq!(
            missing(&[("lib.rs", lib), file]),
            ["a::C", "a::C::N", "a::f"]
        );
    }

    #[test]
    fn text_and_other_languages_are_no_examples() {
        let lib = "/// f() in words\n/// ```text\n/// f()\n/// ```\npub fn f() {}\n/// ```\n/// fine();\n/// ```\npub fn fine() {}\n";
        assert_eq!(missing(&[("lib.rs", lib)]), ["::f"]);
        assert_eq!(
            rust_of_markdown("```c\nf();\n```\n```rust\ng();\n```\n"),
            "g();\n"
        );
    }
}
