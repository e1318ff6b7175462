// SPDX-License-Identifier: MIT OR Apache-2.0
//! The loads of a wall's triangles as a file that ParaView reads.
//!
//! The legacy VTK format, text (W. Schroeder et al., The Visualization Toolkit, appendix on file formats): numbers in it are read
//! back to the same bits. The one VTK writer among Rust's packages is a release candidate, and this form is a few lines.

use super::compute::triangle_normal;
use super::motion::Motion;
use super::wall::TriangleLoad;
use crate::geometry::triangles::Triangle;
use crate::vector::Vector3;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Writes triangles, where the wall is, and their loads: the force on each, its area, normal stress (what presses on it over
/// the area) and shear stress (the component of the force in its plane over the area); stresses of a triangle without area
/// are 0.
///
/// # Errors
/// Names the file and what is wrong.
///
/// # Panics
/// If there are not as many loads as triangles.
pub fn write_triangle_loads(
    path: &Path,
    triangles: &[Triangle],
    motion: &Motion,
    loads: &[TriangleLoad],
) -> Result<(), String> {
    assert_eq!(triangles.len(), loads.len());
    write(path, triangles, motion, loads)
        .map_err(|e| format!("file {} cannot be written: {e}", path.display()))
}

fn write(
    path: &Path,
    triangles: &[Triangle],
    motion: &Motion,
    loads: &[TriangleLoad],
) -> std::io::Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    let out = &mut file;
    let vector = |out: &mut BufWriter<File>, v: Vector3| {
        // -0 is 0
        let [x, y, z] = v.to_array().map(|x| x + 0.0);
        writeln!(out, "{x:e} {y:e} {z:e}")
    };
    let count = triangles.len();
    writeln!(out, "# vtk DataFile Version 3.0")?;
    writeln!(out, "forces and stresses on the triangles of a wall")?;
    writeln!(out, "ASCII\nDATASET POLYDATA\nPOINTS {} double", 3 * count)?;
    for corner in triangles.iter().flatten() {
        vector(out, motion.point_to_world(*corner))?;
    }
    writeln!(out, "POLYGONS {count} {}", 4 * count)?;
    for k in 0..count {
        writeln!(out, "3 {} {} {}", 3 * k, 3 * k + 1, 3 * k + 2)?;
    }
    writeln!(out, "CELL_DATA {count}\nVECTORS force double")?;
    for load in loads {
        vector(out, load.force)?;
    }
    let area = |[a, b, c]: &Triangle| 0.5 * (*b - *a).cross(*c - *a).norm();
    let over = |force: f64, t: &Triangle| {
        let stress = force / area(t);
        if stress.is_finite() {
            stress + 0.0
        } else {
            0.0
        }
    };
    let mut scalars = |name: &str, of: &dyn Fn(&Triangle, &TriangleLoad) -> f64| {
        writeln!(out, "SCALARS {name} double 1\nLOOKUP_TABLE default")?;
        for (t, load) in triangles.iter().zip(loads) {
            writeln!(out, "{:e}", of(t, load))?;
        }
        Ok::<(), std::io::Error>(())
    };
    scalars("area", &|t, _| area(t))?;
    scalars("normal_stress", &|t, load| over(load.pressing, t))?;
    scalars("shear_stress", &|t, load| {
        let normal = motion.to_world(triangle_normal(t));
        let along = load.force - normal * load.force.dot(normal);
        over(along.norm(), t)
    })?;
    file.flush()
}
