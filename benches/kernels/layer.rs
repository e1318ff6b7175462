// SPDX-License-Identifier: MIT OR Apache-2.0
//! A layer of grains on a wall, or far above it. Numbers alone, as [`super::packing`].

use super::packing::Random;

/// Distance of neighbours: they do not touch each other.
const SPACING: f64 = 5.0;
const DEPTH: f64 = 0.02;
/// Sides of the triangles of a coarse mesh, and of one whose triangles are as large as grains.
const COARSE: f64 = 2.0 * SPACING;
const FINE: f64 = 2.0;

/// Surfaces on which a square layer of grains lies, in the plane `z = 0` and about the origin.
#[derive(Clone, Copy)]
pub enum Surface {
    Plane,
    /// Lying, of this radius, grains inside: they touch where it is lowest.
    Cylinder(f64),
    /// Squares along a side, and the side of each: two triangles a square.
    Mesh(usize, f64),
}

impl Surface {
    /// Of a mesh: corners of its triangles.
    pub fn triangles(self) -> Vec<[[f64; 3]; 3]> {
        let Surface::Mesh(squares, side) = self else {
            return Vec::new();
        };
        let at = |k: usize| side * (k as f64 - 0.5 * squares as f64);
        let corner = |i: usize, j: usize| [at(i), at(j), 0.0];
        (0..squares * squares)
            .flat_map(|k| {
                let (i, j) = (k % squares, k / squares);
                let [a, b] = [corner(i, j), corner(i + 1, j)];
                let [c, d] = [corner(i + 1, j + 1), corner(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect()
    }

    /// Height of the surface.
    fn height(self, y: f64) -> f64 {
        match self {
            Surface::Cylinder(radius) => radius - (radius * radius - y * y).sqrt(),
            _ => 0.0,
        }
    }
}

/// What is timed: a surface, grains along a side of the layer, and whether they lie on it or far above.
pub struct Case {
    pub name: &'static str,
    pub surface: Surface,
    pub side: usize,
    pub far: bool,
}

const fn case(name: &'static str, surface: Surface, side: usize, far: bool) -> Case {
    Case {
        name,
        surface,
        side,
        far,
    }
}

pub const CASES: &[Case] = &[
    case("wall, plane", Surface::Plane, 12, false),
    case("wall, cylinder", Surface::Cylinder(300.0), 12, false),
    case(
        "wall, mesh of 98 triangles",
        Surface::Mesh(7, COARSE),
        12,
        false,
    ),
    case(
        "wall, mesh of 100352 triangles",
        Surface::Mesh(224, COARSE),
        12,
        false,
    ),
    case(
        "wall, mesh of triangles as large as grains",
        Surface::Mesh(224, FINE),
        12,
        false,
    ),
    case("wall, far from a plane", Surface::Plane, 256, true),
    case(
        "wall, far from a cylinder",
        Surface::Cylinder(3000.0),
        256,
        true,
    ),
    case(
        "wall, far from a mesh of 100352 triangles",
        Surface::Mesh(224, COARSE),
        256,
        true,
    ),
];

/// Velocity of each grain, and its angular velocity.
pub const VELOCITY: [f64; 3] = [1e-3, 2e-3, -1e-3];

/// Positions and quaternions of the grains, turned at random.
pub fn grains(case: &Case, semi_axes: [f64; 3]) -> (Vec<[f64; 3]>, Vec<[f64; 4]>) {
    let mut random = Random::new(11);
    (0..case.side * case.side)
        .map(|k| {
            let q: [f64; 4] = core::array::from_fn(|_| 2.0 * random.unit() - 1.0);
            let size = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            let q = q.map(|x| x / size);
            let place = |n: usize| SPACING * (n as f64 - 0.5 * (case.side - 1) as f64);
            let (x, y) = (place(k % case.side), place(k / case.side));
            let above = if case.far { 10.0 * SPACING } else { -DEPTH };
            let z = case.surface.height(y) + reach_down(semi_axes, q) + above;
            ([x, y, z], q)
        })
        .unzip()
}

/// How far an ellipsoid of a unit quaternion reaches below its centre.
fn reach_down(semi_axes: [f64; 3], [w, x, y, z]: [f64; 4]) -> f64 {
    let up = [
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        1.0 - 2.0 * (x * x + y * y),
    ];
    (0..3)
        .map(|k| (semi_axes[k] * up[k]).powi(2))
        .sum::<f64>()
        .sqrt()
}
