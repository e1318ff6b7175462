// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do the decks of examples/liggghts print what their page says, on one rank and on two?

use std::fs;
use std::path::{Path, PathBuf};

use crate::engines::printed::{blocks, page, shell};
use crate::harness::{execute, fresh_directory, last_lines, Engine};

fn examples() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples/liggghts")
}

/// The numbers in a text, whatever stands around them.
fn numbers(text: &str) -> Vec<f64> {
    text.split(|c: char| c.is_whitespace() || "(),:".contains(c))
        .filter_map(|word| word.parse().ok())
        .collect()
}

/// What the page says of a deck of ours.
fn promised(deck: &str) -> Vec<f64> {
    column(deck, 2)
}

fn column(deck: &str, column: usize) -> Vec<f64> {
    let page = page("examples/liggghts/README.md");
    let row = page
        .lines()
        .find(|line| line.starts_with(&format!("| `{deck}` |")))
        .unwrap_or_else(|| panic!("the page has no row for {deck}"));
    numbers(row.split('|').nth(column).unwrap())
}

/// What the deck prints in the line that begins so.
fn printed(engine: &Engine, deck: &str, beginning: &str, ranks: usize) -> Vec<f64> {
    let directory = fresh_directory(&format!("{deck}_{ranks}"));
    copy_examples(&directory);
    let text = fs::read_to_string(directory.join(deck)).unwrap();
    let (success, output) = execute(engine, &directory, &text, ranks);
    assert!(success, "{deck}:\n{}", last_lines(&output));
    let [line] = &lines(&output, beginning)[..] else {
        panic!("{deck}: not one line '{beginning}...'")
    };
    println!("{deck}, {ranks} ranks: {line:?}");
    line.clone()
}

fn copy_examples(directory: &Path) {
    for file in fs::read_dir(examples()).unwrap() {
        let path = file.unwrap().path();
        if path.is_file() {
            fs::copy(&path, directory.join(path.file_name().unwrap())).unwrap();
        }
    }
}

/// The numbers in each line that begins so.
fn lines(output: &str, beginning: &str) -> Vec<Vec<f64>> {
    let lines = output.lines().filter(|line| line.starts_with(beginning));
    lines.map(numbers).collect()
}

#[test]
fn the_collision_ends_as_the_page_says_on_one_rank_and_two() {
    let engine = Engine::from_environment();
    let [one, two] = [1, 2].map(|ranks| printed(&engine, "collision.lig", "grain 1:", ranks));
    let page = promised("collision.lig");
    // velocity of grain 1, after its number and its velocity before
    let (after, said) = (&one[one.len() - 2..], &page[page.len() - 2..]);
    for k in 0..2 {
        assert!((after[k] - said[k]).abs() < 0.6e-4, "{after:?}, {said:?}");
        assert!((after[k] - two[two.len() - 2 + k]).abs() < 1e-12);
    }
}

/// The commands of the page as they are printed. Heaps are chaotic: the number of grains is to be that of the page where none can
/// leave, and means near.
#[test]
#[cfg(unix)]
fn heaps_of_the_printed_commands_end_near_what_the_page_says() {
    let engine = Engine::from_environment();
    let directory = fresh_directory("page");
    let copied = directory.join("examples/liggghts");
    fs::create_dir_all(&copied).unwrap();
    copy_examples(&copied);
    let [block] = &blocks(&page("examples/liggghts/README.md"), "sh")[..] else {
        panic!("not one block")
    };
    let answers = [("liggghts", engine.liggghts.as_path())];
    let output = shell(&directory, block, &answers, &engine.mpirun);
    // ours, LIGGGHTS' own
    let settled = lines(&output, "at rest:");
    assert_eq!(settled.len(), 2, "{settled:?}");
    for (k, settled) in settled.iter().enumerate() {
        let page = column("settling.lig", 2 + k);
        assert_eq!(settled[0], page[0], "grains");
        assert!(
            (settled[1] * 1e3 - page[1]).abs() < 0.1,
            "{settled:?}, {page:?}"
        );
    }
    assert_eq!(
        lines(&output, "grain 1:").len(),
        1,
        "the collision on two ranks"
    );
}

#[test]
fn drum_and_hopper_end_near_what_the_page_says() {
    let engine = Engine::from_environment();
    let drum = printed(&engine, "drum.lig", "after 0.5 s:", 1);
    let page = promised("drum.lig");
    assert_eq!(drum[1], page[0]);
    // mean y; the heap slides back and forth
    assert!((drum[3] * 1e3 - page[2]).abs() < 2.0);
    // within the drum, by the shortest semi-axis
    assert!(drum[2] < 0.0281);
    let hopper = printed(&engine, "hopper.lig", "after 0.15 s:", 1);
    let page = promised("hopper.lig");
    assert!((hopper[1] - page[2]).abs() < 8.0 && (hopper[2] - page[1]).abs() < 8.0);
}
