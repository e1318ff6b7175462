// SPDX-License-Identifier: MIT OR Apache-2.0
//! How does a wrong deck end? With one message, which itself names what is wrong.

use crate::harness::last_lines;

/// The message of the one `ERROR` that ended a run, on one line; or what is wrong with its end. LAMMPS adds the place in its sources
/// and the last line of the deck: a word of the deck would always be found there, so both are cut off. That a run was not ended
/// by a signal is looked at where it is run.
pub fn message(success: bool, output: &str) -> Result<String, String> {
    if success {
        return Err("the run went on to its end".into());
    }
    let lines: Vec<&str> = output.lines().collect();
    let errors: Vec<usize> = (0..lines.len())
        .filter(|k| lines[*k].starts_with("ERROR"))
        .collect();
    let [first] = errors[..] else {
        let (count, last) = (errors.len(), last_lines(output));
        return Err(format!("{count} lines begin with ERROR, not one:\n{last}"));
    };
    let mut message = String::new();
    for line in &lines[first..] {
        message += line;
        if let Some(place) = source_place(&message) {
            message.truncate(place);
            let words: Vec<&str> = message.split_whitespace().collect();
            return Ok(words.join(" "));
        }
        message.push('\n');
    }
    Err(format!("the message has no end:\n{message}"))
}

/// Where ` (file.cpp:123)` begins, with which messages of LAMMPS end.
fn source_place(text: &str) -> Option<usize> {
    let inside = text.trim_end().strip_suffix(')')?;
    let from = inside.rfind(" (")?;
    let (file, line) = inside[from + 2..].rsplit_once(':')?;
    let is_source = file.ends_with(".cpp") || file.ends_with(".h");
    let is_number = !line.is_empty() && line.bytes().all(|b| b.is_ascii_digit());
    (is_source && is_number).then_some(from)
}

/// Whether the words stand in a message, not as parts of longer words or numbers: 0 is not in 10, nor -1 in -1.5.
pub fn names(message: &str, words: &str) -> bool {
    let bytes = message.as_bytes();
    let is_part = |at: usize| bytes[at].is_ascii_alphanumeric() || bytes[at] == b'_';
    message.match_indices(words).any(|(from, _)| {
        let to = from + words.len();
        let begins = from == 0
            || !is_part(from)
            || !(is_part(from - 1)
                || (b".-+".contains(&bytes[from - 1]) && starts_with_digit(words)));
        let goes_on = |at: usize| {
            is_part(at) || (bytes[at] == b'.' && bytes.get(at + 1).is_some_and(u8::is_ascii_digit))
        };
        let ends = to == bytes.len() || !is_part(to - 1) || !goes_on(to);
        begins && ends
    })
}

fn starts_with_digit(words: &str) -> bool {
    words.as_bytes().first().is_some_and(u8::is_ascii_digit)
}

/// What is wrong with the end of a run that must be refused with a message that names these words; nothing, if all is well.
pub fn fault(name: &str, success: bool, output: &str, words: &[&str]) -> Option<String> {
    match message(success, output) {
        Err(why) => Some(format!("{name}: {why}")),
        Ok(message) => {
            println!("{name}: {message}");
            let lacking: Vec<&&str> = words.iter().filter(|w| !names(&message, w)).collect();
            (!lacking.is_empty()).then(|| format!("{name}: {lacking:?} not named: {message}"))
        }
    }
}

/// The run must have been refused so.
pub fn refused(name: &str, success: bool, output: &str, words: &[&str]) {
    if let Some(fault) = fault(name, success, output, words) {
        panic!("{fault}");
    }
}

#[test]
fn the_words_of_a_deck_do_not_count() {
    let output = "reading\nERROR: Fix wall 10: zplane value\n3.5 must be below hi 1e7 (src/fix_wall.cpp:120)\n\
                  Last input line: fix floor all wall hertz\n                          ^^^^\n";
    let said = message(false, output).unwrap();
    assert_eq!(
        said,
        "ERROR: Fix wall 10: zplane value 3.5 must be below hi 1e7"
    );
    for word in ["zplane", "value 3.5", "hi 1e7", "10", "Fix wall"] {
        assert!(names(&said, word), "{word}");
    }
    for word in ["hertz", "floor", "0", "3", "5", "1", "plane", "fix_wall"] {
        assert!(!names(&said, word), "{word}");
    }
    assert!(message(true, output).is_err());
    assert!(message(false, "no word").is_err());
    assert!(message(false, &output.repeat(2)).is_err());
    assert!(message(false, "ERROR: it broke").is_err());
    assert!(!names("value -1.5", "1.5") && names("value -1.5", "-1.5"));
}
