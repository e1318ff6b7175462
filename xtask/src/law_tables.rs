// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the tables of laws in src/force give to the C interface, as plain items that cbindgen can read: it expands no macros.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{bail, Context, Result};
use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// The constants of all choices, and the struct of all parameters.
pub fn c_items(root: &Path) -> Result<String> {
    let force = root.join("src/force");
    let read = |name: &str| -> Result<TokenStream> {
        let path = force.join(name);
        let text =
            fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
        text.parse()
            .map_err(|error| anyhow::anyhow!("{name}: {error}"))
    };
    let parameters = read("parameters.rs")?;
    let mut items = String::new();
    constants(&mut items, group_after(&parameters, &["choices", "!"])?)?;
    for family in ["damping.rs", "tangential.rs", "rolling.rs", "twisting.rs"] {
        constants(&mut items, group_after(&read(family)?, &["choices", "!"])?)?;
    }
    let body = group_after(&parameters, &["macro_rules", "!", "with_parameters"])?;
    // `($callback:ident) => { $callback! { the table } };`
    let transcriber = group_after(&body, &["=", ">"])?;
    structure(&mut items, group_after(&transcriber, &["callback", "!"])?)?;
    Ok(items)
}

/// The words of all choices of all families, without `none`.
#[cfg(test)]
pub fn words(root: &Path) -> Result<Vec<String>> {
    let mut words = Vec::new();
    for name in [
        "parameters.rs",
        "damping.rs",
        "tangential.rs",
        "rolling.rs",
        "twisting.rs",
    ] {
        let text = fs::read_to_string(root.join("src/force").join(name))?;
        let tokens = text
            .parse()
            .map_err(|error| anyhow::anyhow!("{name}: {error}"))?;
        for choice in rows(group_after(&tokens, &["choices", "!"])?) {
            let Some(TokenTree::Group(table)) = choice.tokens.last() else {
                bail!("a choice without a table");
            };
            for row in rows(table.stream()) {
                let [_, _, _, _, word, ..] = &row.tokens[..] else {
                    bail!("a row without a word");
                };
                words.push(word.to_string().trim_matches('"').to_string());
            }
        }
    }
    words.retain(|word| word != "none");
    Ok(words)
}

/// The content of the braces that follow these tokens.
fn group_after(tokens: &TokenStream, before: &[&str]) -> Result<TokenStream> {
    let tokens: Vec<TokenTree> = tokens.clone().into_iter().collect();
    for k in 0..tokens.len().saturating_sub(before.len()) {
        let here = tokens[k..].iter().map(TokenTree::to_string);
        if here.zip(before).all(|(token, wanted)| token == *wanted) {
            if let TokenTree::Group(group) = &tokens[k + before.len()] {
                if group.delimiter() == Delimiter::Brace {
                    return Ok(group.stream());
                }
            }
        }
    }
    bail!("no braces after `{}`", before.join(" "))
}

/// A row up to its semicolon, or a block with what stands before it: its attributes, and the other tokens.
struct Row {
    attributes: TokenStream,
    tokens: Vec<TokenTree>,
}

fn rows(table: TokenStream) -> Vec<Row> {
    let (mut rows, mut attributes, mut tokens) = (Vec::new(), Vec::new(), Vec::new());
    let mut input = table.into_iter().peekable();
    while let Some(token) = input.next() {
        let ends = match &token {
            TokenTree::Punct(p) if p.as_char() == '#' && tokens.is_empty() => {
                attributes.push(token);
                attributes.extend(input.next());
                continue;
            }
            TokenTree::Punct(p) => p.as_char() == ';',
            TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
            _ => false,
        };
        tokens.push(token);
        if ends {
            rows.push(Row {
                attributes: attributes.drain(..).collect(),
                tokens: std::mem::take(&mut tokens),
            });
        }
    }
    rows
}

/// `Variant = number, "word", C_CONSTANT, [...];` of each choice.
fn constants(items: &mut String, choices: TokenStream) -> Result<()> {
    for choice in rows(choices) {
        let Some(TokenTree::Group(table)) = choice.tokens.last() else {
            bail!("a choice without a table");
        };
        for row in rows(table.stream()) {
            let [_, _, number, _, _, _, name, ..] = &row.tokens[..] else {
                bail!("a row of choices is `Variant = number, \"word\", C_CONSTANT, [...];`");
            };
            writeln!(
                items,
                "{} pub const {name}: i32 = {number};",
                row.attributes
            )?;
        }
    }
    Ok(())
}

/// The table of parameters: its comment, `choices { }`, `switches { }`, `constants { }`, `later_choices { }`,
/// `later_constants { }`, `latest_choices { }`.
fn structure(items: &mut String, table: TokenStream) -> Result<()> {
    let blocks = rows(table);
    let [choices, switches, constants, later_choices, later_constants, latest_choices] =
        &blocks[..]
    else {
        bail!("the table of parameters has choices, switches and constants, and choices and constants that came later");
    };
    writeln!(
        items,
        "{} #[repr(C)] pub struct EllgranLawParameters {{\n\
         /// `sizeof(EllgranLawParameters)`; `ELLGRAN_INIT` sets it.\npub size: size_t,",
        choices.attributes
    )?;
    for (block, kind) in [
        (choices, "i32"),
        (switches, "i32"),
        (constants, "f64"),
        (later_choices, "i32"),
        (later_constants, "f64"),
        (latest_choices, "i32"),
    ] {
        let Some(TokenTree::Group(fields)) = block.tokens.last() else {
            bail!("a block of parameters without its fields");
        };
        for row in rows(fields.stream()) {
            let name = row.tokens.first().context("a parameter without a name")?;
            writeln!(items, "{} pub {name}: {kind},", row.attributes)?;
        }
    }
    items.push_str("/// Not used; 0.\npub reserved: i32,}\n");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::c_items;
    use crate::workspace;

    #[test]
    fn a_row_of_each_table_becomes_an_item() {
        let items = c_items(&workspace::root()).unwrap();
        for item in [
            "pub const ELLGRAN_NORMAL_HERTZ: i32 = 0;",
            "pub const ELLGRAN_TANGENTIAL_LINEAR: i32 = 3;",
            "pub const ELLGRAN_CLOSURE_BRILLIANTOV: i32 = 2;",
            "pub normal: i32,",
            "pub limit_force: i32,",
            "pub tangential_damping: f64,",
            "pub twisting: i32,",
            "pub twisting_friction: f64,",
            "pub const ELLGRAN_TWISTING_MARSHALL: i32 = 1;",
        ] {
            assert!(items.contains(item), "{item}\n{items}");
        }
    }
}
