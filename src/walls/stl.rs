// SPDX-License-Identifier: MIT OR Apache-2.0
//! Triangles from STL files, binary or ASCII.

use crate::geometry::triangles::Triangle;
use crate::vector::Vector3;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Reads the triangles of a file; which of the two forms it has is seen from its content. Normals in it are not used.
///
/// # Errors
/// Names the file and what is wrong.
pub fn read(path: &Path) -> Result<Vec<Triangle>, String> {
    let fail = |what: String| format!("STL file {}: {what}", path.display());
    let file = File::open(path).map_err(|e| fail(e.to_string()))?;
    let mut file = BufReader::new(file);
    let not_stl = |e: std::io::Error| fail(format!("not an STL file, or cut short: {e}"));
    let triangles = stl_io::create_stl_reader(&mut file).map_err(not_stl)?;
    triangles
        .map(|triangle| {
            let triangle = triangle.map_err(not_stl)?;
            Ok(triangle.vertices.map(|v| {
                let [x, y, z]: [f32; 3] = v.into();
                Vector3::new(x.into(), y.into(), z.into())
            }))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
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
}
