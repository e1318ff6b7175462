// SPDX-License-Identifier: MIT OR Apache-2.0
//! Triangles from STL files, binary or ASCII.

use super::mesh::flatten_triangles;
use crate::geometry::triangles::Triangle;
use crate::vector::Vector3;
use std::fs;
use std::io::Cursor;
use std::path::Path;

/// Bytes at the beginning of a binary file: a text of any content, and the number of triangles.
const HEAD: usize = 84;

/// Reads the triangles of a file; which of the two forms it has is seen from its content. Normals in it are not used, and all solids of
/// an ASCII file count. Flat pieces of many triangles, which rounding of the corners has left uneven, are flat again.
///
/// # Errors
/// Names the file and what is wrong.
pub fn read(path: &Path) -> Result<Vec<Triangle>, String> {
    let fail = |what: String| format!("STL file {}: {what}", path.display());
    let bytes = fs::read(path).map_err(|e| fail(e.to_string()))?;
    let mut file = Cursor::new(one_solid(bytes));
    let not_stl = |e: std::io::Error| fail(format!("not an STL file, or cut short: {e}"));
    let triangles = stl_io::create_stl_reader(&mut file).map_err(not_stl)?;
    let triangles: Result<Vec<Triangle>, String> = triangles
        .map(|triangle| {
            let triangle = triangle.map_err(not_stl)?;
            Ok(triangle.vertices.map(|v| {
                let [x, y, z]: [f32; 3] = v.into();
                Vector3::new(x.into(), y.into(), z.into())
            }))
        })
        .collect();
    let mut triangles = triangles?;
    flatten_triangles(&mut triangles).map_err(fail)?;
    Ok(triangles)
}

/// The file as `stl_io` wants it: that takes each file which begins with "solid" for ASCII, stops behind the first solid of one, and
/// knows its words in small letters alone.
fn one_solid(mut bytes: Vec<u8>) -> Vec<u8> {
    let begins_so = bytes
        .get(..5)
        .is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    if !begins_so {
        return bytes;
    }
    // No text has a zero byte, and the number of triangles has one up to 2^24 of them.
    let head = &bytes[..bytes.len().min(HEAD)];
    if head.contains(&0) || is_as_long_as_it_says(&bytes) {
        bytes[0] = b' ';
        return bytes;
    }
    bytes.make_ascii_lowercase();
    let mut text = b"solid one\n".to_vec();
    text.reserve(bytes.len());
    let mut ends = false;
    for line in bytes.split(|byte| *byte == b'\n') {
        let mut words = line
            .split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty());
        match words.next() {
            None => {}
            Some(b"solid") => ends = false,
            Some(b"endsolid") => ends = true,
            Some(_) => {
                ends = false;
                text.extend_from_slice(line);
                text.push(b'\n');
            }
        }
    }
    if ends {
        text.extend_from_slice(b"endsolid one\n");
    }
    text
}

/// Whether a file is as long as a binary one is that has the number of triangles in its head.
fn is_as_long_as_it_says(bytes: &[u8]) -> bool {
    let Some(count) = bytes.get(HEAD - 4..HEAD).and_then(|b| b.try_into().ok()) else {
        return false;
    };
    bytes.len() as u64 == HEAD as u64 + 50 * u64::from(u32::from_le_bytes(count))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;
    use std::io::Write;

    /// What `read` says to a file with these bytes.
    fn said(name: &str, bytes: &[u8]) -> Result<usize, String> {
        let path = std::env::temp_dir().join(format!("ellgran-{}-{name}.stl", std::process::id()));
        File::create(&path).unwrap().write_all(bytes).unwrap();
        let read = read(&path);
        std::fs::remove_file(&path).unwrap();
        read.map(|triangles| triangles.len())
    }

    /// A binary file that says `count` triangles and has one.
    fn binary(count: u32) -> Vec<u8> {
        let mut bytes = vec![0; 80];
        bytes.extend(count.to_le_bytes());
        for value in [
            0.0f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0,
        ] {
            bytes.extend(value.to_le_bytes());
        }
        bytes.extend([0, 0]);
        bytes
    }

    /// The number in the head of a file that comes from anyone is not believed: no memory is taken for it.
    #[test]
    fn a_file_that_says_more_than_it_has() {
        assert_eq!(said("whole", &binary(1)), Ok(1));
        for (name, bytes) in [
            ("many", binary(u32::MAX)),
            ("short", binary(1)[..100].to_vec()),
            ("empty", Vec::new()),
            (
                "ascii",
                b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n".to_vec(),
            ),
        ] {
            let error = said(name, &bytes).unwrap_err();
            assert!(
                error.contains("cut short") && error.contains(name),
                "{error}"
            );
        }
    }

    /// One triangle as text.
    const FACET: &str = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";

    /// Each form in which programs write their files, with the number of triangles.
    #[test]
    fn files_as_programs_write_them() {
        let mut begins_as_text = binary(1);
        begins_as_text[..18].copy_from_slice(b"solid made by hand");
        assert_eq!(said("binary-solid", &begins_as_text), Ok(1));
        // a head that is padded, and text of the length that the next four letters say
        begins_as_text[18..80].fill(b' ');
        assert_eq!(said("binary-padded", &begins_as_text), Ok(1));
        let two = format!("solid a\n{FACET}endsolid a\n\nsolid b\n{FACET}{FACET}endsolid b\n");
        assert_eq!(said("two-solids", two.as_bytes()), Ok(3));
        for (name, text) in [
            (
                "capitals",
                format!("solid a\n{FACET}endsolid a\n").to_uppercase(),
            ),
            ("nameless", format!("solid\n{FACET}endsolid\n")),
            (
                "returns",
                format!("solid a\n{FACET}endsolid a\n").replace('\n', "\r\n"),
            ),
            ("indented", format!("solid a\n  {FACET}  endsolid")),
        ] {
            assert_eq!(said(name, text.as_bytes()), Ok(1), "{name}");
        }
        let cut = format!("solid a\n{FACET}endsolid a\nsolid b\n{FACET}");
        let error = said("second-cut", cut.as_bytes()).unwrap_err();
        assert!(error.contains("cut short"), "{error}");
    }
}
