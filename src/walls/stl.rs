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
