// SPDX-License-Identifier: MIT OR Apache-2.0
//! A scene in the words that player.c reads.

use std::fmt::{Display, Write};

use super::kinds::{layer, packing::Frame};

/// A surface of a wall that is no mesh.
#[derive(Clone)]
pub struct Shape {
    pub name: &'static str,
    pub point: [f64; 3],
    pub axis: [f64; 3],
    pub radii: [f64; 2],
    pub bounds: [f64; 2],
}

/// Grains, walls and laws, and how they are played. Lengths in m, masses in kg, times in s.
#[derive(Clone)]
pub struct Scene {
    /// The words of each type's law.
    pub laws: Vec<String>,
    pub normals_are_kept: bool,
    /// 0 without a wall.
    pub wall_type: i32,
    pub shapes: Vec<Shape>,
    pub triangles: Vec<[[f64; 3]; 3]>,
    /// Type, semi-axes and mass of each grain.
    pub grains: Vec<(i32, [f64; 3], f64)>,
    pub frames: Vec<Frame>,
    /// Neighbours of each grain, each pair once.
    pub rows: Vec<Vec<i32>>,
    pub time_step: f64,
    /// Acceleration towards the origin over the distance from it, 1/s^2.
    pub pull: f64,
    /// Energies and virials of each grain are asked for.
    pub tallied: bool,
    /// Nothing is remembered from one step to the next.
    pub cold: bool,
    /// Touching pairs are computed by one call each.
    pub single: bool,
}

impl Scene {
    pub fn pairs(&self) -> usize {
        self.rows.iter().map(Vec::len).sum()
    }

    /// Decimals that are read back bit for bit.
    pub fn text(&self) -> String {
        let mut text = String::new();
        line(&mut text, "types", [self.laws.len()]);
        for law in &self.laws {
            line(&mut text, "law", [law]);
        }
        line(
            &mut text,
            "normals_are_kept",
            [i32::from(self.normals_are_kept)],
        );
        line(&mut text, "wall_type", [self.wall_type]);
        line(&mut text, "shapes", [self.shapes.len()]);
        for shape in &self.shapes {
            let Shape {
                name,
                point,
                axis,
                radii,
                bounds,
            } = shape;
            line(
                &mut text,
                name,
                point.iter().chain(axis).chain(radii).chain(bounds),
            );
        }
        line(&mut text, "triangles", [self.triangles.len()]);
        for corners in &self.triangles {
            line(&mut text, "", corners.as_flattened());
        }
        line(&mut text, "grains", [self.grains.len()]);
        for (grain_type, semi_axes, mass) in &self.grains {
            let numbers = [f64::from(*grain_type)];
            line(&mut text, "", numbers.iter().chain(semi_axes).chain([mass]));
        }
        line(&mut text, "frames", [self.frames.len()]);
        for frame in &self.frames {
            for k in 0..self.grains.len() {
                let moving = frame.positions[k].iter().chain(&frame.velocities[k]);
                line(
                    &mut text,
                    "",
                    moving
                        .chain(&frame.rotations[k])
                        .chain(&frame.quaternions[k]),
                );
            }
        }
        line(&mut text, "pairs", [self.pairs()]);
        for row in &self.rows {
            let length = [row.len() as i32];
            line(&mut text, "", length.iter().chain(row));
        }
        line(&mut text, "time_step", [self.time_step]);
        line(&mut text, "pull", [self.pull]);
        for (name, on) in [
            ("tallied", self.tallied),
            ("cold", self.cold),
            ("single", self.single),
        ] {
            line(&mut text, name, [i32::from(on)]);
        }
        text
    }
}

fn line<T: Display>(text: &mut String, name: &str, values: impl IntoIterator<Item = T>) {
    text.push_str(name);
    for value in values {
        write!(text, " {value}").expect("a string takes all that is written");
    }
    text.push('\n');
}

/// The surface of a layer of the kernel benchmark.
pub fn surface(surface: layer::Surface) -> (Vec<Shape>, Vec<[[f64; 3]; 3]>) {
    let endless = [f64::NEG_INFINITY, f64::INFINITY];
    let shape = |name, radius: f64, axis| Shape {
        name,
        point: [0.0, 0.0, radius],
        axis,
        radii: [radius, 0.0],
        bounds: endless,
    };
    match surface {
        layer::Surface::Plane => (vec![shape("plane", 0.0, [0.0, 0.0, 1.0])], Vec::new()),
        layer::Surface::Cylinder(radius) => {
            (vec![shape("cylinder", radius, [1.0, 0.0, 0.0])], Vec::new())
        }
        layer::Surface::Mesh(..) => (Vec::new(), surface.triangles()),
    }
}
