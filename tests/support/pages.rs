// SPDX-License-Identifier: MIT OR Apache-2.0
//! The fenced blocks of the project's pages, for whatever runs them as they are printed.

// Each that runs blocks takes what it needs.
#![allow(dead_code)]

/// A fenced block of a page.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// The words behind the fence.
    pub language: String,
    /// What stands between the fences; the indent that a list gives to the block is taken away.
    pub text: String,
    /// The last heading before the block.
    pub heading: String,
}

/// All fenced blocks of a page, in order.
pub fn all_blocks(page: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let (mut open, mut heading): (Option<(Block, usize)>, &str) = (None, "");
    for line in page.lines() {
        let indent = line.len() - line.trim_start().len();
        match (&mut open, line.trim_start().strip_prefix("```")) {
            (None, Some(language)) => {
                let block = Block {
                    language: language.to_owned(),
                    text: String::new(),
                    heading: heading.to_owned(),
                };
                open = Some((block, indent));
            }
            (None, None) if line.starts_with('#') => heading = line.trim_start_matches('#').trim(),
            (None, None) => (),
            (Some(_), Some(_)) => blocks.extend(open.take().map(|(block, _)| block)),
            (Some((block, outside)), None) => {
                block.text += &line[indent.min(*outside)..];
                block.text.push('\n');
            }
        }
    }
    assert!(open.is_none(), "a block without an end: {open:?}");
    blocks
}

/// The text of the blocks fenced under this language.
pub fn blocks(page: &str, language: &str) -> Vec<String> {
    let all = all_blocks(page).into_iter();
    all.filter(|block| block.language == language)
        .map(|block| block.text)
        .collect()
}

/// Lines that begin a block of code by four spaces in place of a fence, which nothing finds. (In a list, code is indented further.)
pub fn unfenced_code(page: &str) -> Vec<&str> {
    let (mut fenced, mut blank) = (false, true);
    page.lines()
        .filter(|line| {
            let fence = line.trim_start().starts_with("```");
            fenced ^= fence;
            let begins = blank && line.starts_with("    ") && !line.starts_with("     ");
            blank = line.trim().is_empty();
            !fenced && !fence && begins
        })
        .collect()
}

#[test]
fn both_versions_blocks_are_read_as_they_are_shown() {
    let page = "# A\n```sh\nls  # x\n  cd\n```\n- b\n\n  ```lammps\n  units si\n\n  run 1\n  ```\n\n    code\n";
    let read = all_blocks(page);
    assert_eq!(read.len(), 2);
    assert_eq!(
        (read[0].heading.as_str(), read[0].text.as_str()),
        ("A", "ls  # x\n  cd\n")
    );
    assert_eq!(blocks(page, "lammps"), ["units si\n\nrun 1\n"]);
    assert_eq!(unfenced_code(page), ["    code"]);
}
