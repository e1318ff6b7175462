// SPDX-License-Identifier: MIT OR Apache-2.0
//! A hilly floor of triangles, each a flat piece, with convex and concave edges, and the same floor in many more triangles, which meet edge to edge or not.

// Each test target takes what it needs.
#![allow(dead_code)]

pub type Triangle = [[f64; 3]; 3];

/// Squares of this size about the origin, each of two triangles, so many in a row, with corners that are up to twice this height off the plane z = 0.
pub fn hills(row: i32, size: f64, height: f64) -> Vec<Triangle> {
    let half = row / 2;
    let at = |i: i32, j: i32| {
        let steps = (7 * i + 11 * j + 3 * i * j).rem_euclid(5) - 2;
        [
            size * f64::from(i),
            size * f64::from(j),
            height * f64::from(steps),
        ]
    };
    (-half..row - half)
        .flat_map(|i| (-half..row - half).map(move |j| (i, j)))
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

/// Each triangle as sixteen.
pub fn divided(triangles: &[Triangle]) -> Vec<Triangle> {
    let middle =
        |a: [f64; 3], b: [f64; 3]| -> [f64; 3] { std::array::from_fn(|k| 0.5 * (a[k] + b[k])) };
    let in_four = |t: &Triangle| {
        let [a, b, c] = *t;
        let [p, q, r] = [middle(a, b), middle(b, c), middle(c, a)];
        [[a, p, r], [p, b, q], [r, q, c], [p, q, r]]
    };
    let four: Vec<Triangle> = triangles.iter().flat_map(in_four).collect();
    four.iter().flat_map(in_four).collect()
}

/// Each triangle with its sides in two, three or four parts, so that corners lie on sides of its neighbours.
pub fn unevenly_divided(triangles: &[Triangle]) -> Vec<Triangle> {
    // The same from both ends of a side.
    let on = |a: [f64; 3], b: [f64; 3], steps: usize, of: usize| -> [f64; 3] {
        let (a, b, steps) = if a < b {
            (a, b, steps)
        } else {
            (b, a, of - steps)
        };
        match steps {
            0 => a,
            _ if steps == of => b,
            _ => std::array::from_fn(|k| a[k] + (b[k] - a[k]) * steps as f64 / of as f64),
        }
    };
    let in_parts = |(number, t): (usize, &Triangle)| {
        let ([a, b, c], parts) = (*t, 2 + number % 3);
        let at = move |i: usize, j: usize| {
            // Along the row from one side to the other.
            let [from, to] = [on(a, c, j, parts), on(b, c, j, parts)];
            match parts - j {
                0 => c,
                row => on(from, to, i, row),
            }
        };
        let cells = (0..parts).flat_map(move |j| (0..parts - j).map(move |i| (i, j)));
        cells.flat_map(move |(i, j)| {
            let lower = [at(i, j), at(i + 1, j), at(i, j + 1)];
            let upper = [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let both = [Some(lower), (i + j + 2 <= parts).then_some(upper)];
            both.into_iter().flatten()
        })
    };
    triangles.iter().enumerate().flat_map(in_parts).collect()
}

/// Grains on the floor, as their semi-axes, and where they are: spheres of a radius of 2.5 squares, and ellipsoids within them.
pub fn grains_on(size: f64) -> Vec<([f64; 3], [f64; 3])> {
    (0..40)
        .map(|k| {
            let radius = 2.5 * size;
            let axes = match k % 2 {
                0 => [radius; 3],
                _ => [radius, 0.8 * radius, 0.93 * radius],
            };
            let x = size * (0.078 * f64::from(k) - 1.5);
            let y = size * (f64::from(k * 7 % 11) / 11.0 - 0.5);
            let z = axes[2] + size * (0.12 * f64::from(k * 3 % 7) / 7.0 - 0.1);
            (axes, [x, y, z])
        })
        .collect()
}
