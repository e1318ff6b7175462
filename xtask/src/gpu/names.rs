// SPDX-License-Identifier: MIT OR Apache-2.0
//! Names of functions in the PTX that do not depend on where it was made: the compiler's have a number in them that follows from the
//! directory of the checkout.

use std::collections::BTreeMap;

use anyhow::{bail, Result};

/// What follows the name of a function in those of its parameters.
const PARAMETER: &str = "_param_";

fn is_of_a_name(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_' || c == '$'
}

/// The same PTX with the path of each function in the place of the compiler's name for it, `a_b_c` for `a::b::c`.
///
/// # Errors
/// Two functions of one path, and a name that is none of Rust.
pub fn without_places(ptx: &str) -> Result<String> {
    let mut functions: BTreeMap<String, String> = BTreeMap::new();
    let mut result = String::with_capacity(ptx.len());
    let mut rest = ptx;
    while let Some(start) = rest.find(is_of_a_name) {
        let (before, from) = rest.split_at(start);
        let (word, after) = from.split_at(from.find(|c| !is_of_a_name(c)).unwrap_or(from.len()));
        result.push_str(before);
        if word.starts_with("_R") {
            let (name, parameter) = word.split_at(word.find(PARAMETER).unwrap_or(word.len()));
            result.push_str(&path_of(name, &mut functions)?);
            result.push_str(parameter);
        } else {
            result.push_str(word);
        }
        rest = after;
    }
    result.push_str(rest);
    Ok(result)
}

/// The path that stands for a name; `functions` has those so far, with their names.
fn path_of(name: &str, functions: &mut BTreeMap<String, String>) -> Result<String> {
    let Ok(demangled) = rustc_demangle::try_demangle(name) else {
        bail!("{name} in the PTX is not a name that rustc gives");
    };
    // Without the number of the directory.
    let path = format!("{demangled:#}");
    let words: Vec<&str> = path
        .split(|c| !is_of_a_name(c))
        .filter(|word| !word.is_empty())
        .collect();
    let path = words.join("_");
    let known = functions.entry(path.clone()).or_insert(name.to_owned());
    if known != name {
        bail!("{known} and {name} in the PTX are both {path}");
    }
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::without_places;

    /// One function as two checkouts name it, with its parameters, beside what is no name of a function.
    #[test]
    fn the_directory_leaves_no_trace() {
        let of = |number: &str| {
            let name = format!("_RNvNtNtCs{number}_12ellgran_core8geometry14contact_search6search");
            format!(
                ".func {name}\n\t.param .b64 {name}_param_0,\n\tld.param.b64 %rd1, [{name}_param_0];\n\tmov.f64 %fd1, 0d3FF0000000000000;\n"
            )
        };
        let name = "ellgran_core_geometry_contact_search_search";
        let expected = format!(
            ".func {name}\n\t.param .b64 {name}_param_0,\n\tld.param.b64 %rd1, [{name}_param_0];\n\tmov.f64 %fd1, 0d3FF0000000000000;\n"
        );
        for number in ["KKlrFuODBF", "1ETbQhOl0eI"] {
            assert_eq!(without_places(&of(number)).unwrap(), expected);
        }
        let both = of("KKlrFuODBF") + &of("1ETbQhOl0eI");
        let message = without_places(&both).unwrap_err().to_string();
        assert!(message.contains("are both"), "{message}");
    }
}
