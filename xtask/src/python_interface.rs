// SPDX-License-Identifier: MIT OR Apache-2.0
//! python/ellgran/_interface.py: what include/ellgran.h declares, for Python's ctypes.

use std::fmt::Write as _;

use anyhow::{bail, Context, Result};

const HEAD: &str = r#"# SPDX-License-Identifier: MIT OR Apache-2.0
"""What ellgran.h declares: constants, structs, and the types of the functions.

Generated from include/ellgran.h, do not edit; `cargo xtask header` writes it.
"""
import ctypes
from typing import Any, Dict, List, Tuple

"#;

/// The module's text for this header.
pub fn python_interface(header: &str) -> Result<String> {
    let code = without_comments(header)?;
    let mut text = String::from(HEAD);
    for line in code.lines() {
        let Some(definition) = line.strip_prefix("#define ") else {
            continue;
        };
        // A macro with arguments, or without a value, is no constant.
        if let Some((name, value)) = definition.split_once(' ') {
            if !name.contains('(') && name.starts_with("ELLGRAN_") {
                let _: i64 = value
                    .trim()
                    .parse()
                    .with_context(|| format!("#define {name} is not an integer"))?;
                writeln!(text, "{name} = {}", value.trim())?;
            }
        }
    }
    let code: String = code
        .lines()
        .filter(|line| !line.starts_with('#'))
        .flat_map(|line| [line, "\n"])
        .collect();
    let mut rest = code.as_str();
    while let Some(start) = rest.find("typedef struct ") {
        rest = &rest[start + "typedef struct ".len()..];
        let end = rest.find([';', '{']).context("a struct without end")?;
        if rest.as_bytes()[end] == b';' {
            // Opaque: only pointers to it are passed.
            continue;
        }
        let name = rest[..end].trim();
        let close = rest.find('}').context("a struct without end")?;
        structure(&mut text, name, &rest[end + 1..close])?;
        rest = &rest[close..];
    }
    text += "\n\n#: Result and argument types by function.\nFUNCTIONS: Dict[str, Tuple[Any, List[Any]]] = {\n";
    for statement in code.split(';') {
        // What stands before the first function of a file: the begin of `extern "C"`.
        let statement = statement.rsplit('{').next().unwrap_or(statement);
        if let Some((head, arguments)) = statement.split_once('(') {
            function(&mut text, head.trim(), arguments.trim())?;
        }
    }
    text += "}\n";
    Ok(text)
}

fn without_comments(text: &str) -> Result<String> {
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("/*") {
        out += before;
        rest = after.split_once("*/").context("a comment without end")?.1;
    }
    out += rest;
    Ok(out)
}

fn structure(text: &mut String, name: &str, fields: &str) -> Result<()> {
    write!(
        text,
        "\n\nclass {name}(ctypes.Structure):\n    _fields_ = [\n"
    )?;
    for field in fields.split(';').map(str::trim).filter(|f| !f.is_empty()) {
        let (declared, length) = match field.split_once('[') {
            None => (field, None),
            Some((declared, length)) => (declared, Some(length.trim_end_matches(']'))),
        };
        let at = declared
            .rfind([' ', '*'])
            .with_context(|| format!("{name}: a field without a type: {field}"))?;
        let (kind, field_name) = declared.split_at(at + 1);
        let kind = python_type(kind).with_context(|| format!("{name}: {field}"))?;
        let array = length.map_or(String::new(), |n| format!(" * {n}"));
        writeln!(text, "        (\"{field_name}\", {kind}{array}),")?;
    }
    *text += "    ]\n";
    Ok(())
}

fn function(text: &mut String, head: &str, arguments: &str) -> Result<()> {
    let Some(at) = head.rfind([' ', '*']) else {
        return Ok(());
    };
    let (kind, name) = head.split_at(at + 1);
    if !name.starts_with("ellgran_") {
        return Ok(());
    }
    let result = match kind.split_whitespace().collect::<String>().as_str() {
        "void" => "None",
        "constchar*" => "ctypes.c_char_p",
        _ => python_type(kind).with_context(|| name.to_owned())?,
    };
    let mut types = Vec::new();
    let arguments = arguments.trim_end_matches(')');
    for argument in arguments.split(',').map(str::trim) {
        if argument == "void" {
            continue;
        }
        let end = argument
            .rfind([' ', '*'])
            .with_context(|| format!("{name}: an argument without a type: {argument}"))?;
        types.push(python_type(&argument[..=end]).with_context(|| name.to_owned())?);
    }
    writeln!(text, "    \"{name}\": ({result}, [{}]),", types.join(", "))?;
    Ok(())
}

fn python_type(c: &str) -> Result<&'static str> {
    if c.contains('*') {
        return Ok("ctypes.c_void_p");
    }
    Ok(match c.trim() {
        "double" => "ctypes.c_double",
        "int32_t" => "ctypes.c_int32",
        "int64_t" => "ctypes.c_int64",
        "uint32_t" => "ctypes.c_uint32",
        "uint8_t" => "ctypes.c_uint8",
        "size_t" => "ctypes.c_size_t",
        other => bail!("xtask/src/python_interface.rs knows no ctypes name for '{other}'"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_structs_and_functions_are_declared() {
        let header = "#define ELLGRAN_H\n#define ELLGRAN_TWO 2\n#define ELLGRAN_INIT(T) 1\n\
            typedef struct Opaque Opaque;\n/* } */\ntypedef struct S {\n size_t size;\n double x[3];\n \
            const double *const *p;\n} S;\nextern \"C\" {\nconst char *ellgran_name(void);\n\
            int32_t ellgran_do(const struct S *s,\n double y);\nvoid ellgran_free(struct S *s);\n}";
        let text = python_interface(header).unwrap();
        for part in [
            "\nELLGRAN_TWO = 2\n",
            "class S(ctypes.Structure):",
            "(\"x\", ctypes.c_double * 3),\n        (\"p\", ctypes.c_void_p),",
            "\"ellgran_name\": (ctypes.c_char_p, []),",
            "\"ellgran_do\": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_double]),",
            "\"ellgran_free\": (None, [ctypes.c_void_p]),",
        ] {
            assert!(text.contains(part), "{part}\n{text}");
        }
        assert!(!text.contains("INIT") && !text.contains("Opaque"));
    }

    #[test]
    fn a_type_that_is_not_known_is_named() {
        let error = python_interface("int32_t ellgran_f(float x);").unwrap_err();
        assert!(format!("{error:#}").contains("'float'"));
    }
}
