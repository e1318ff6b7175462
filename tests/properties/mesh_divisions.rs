// SPDX-License-Identifier: MIT OR Apache-2.0
//! One surface divided into more triangles, all in the planes of the former ones: does a grain on it feel the same?

use crate::faceted_walls::{on_triangles, support, Felt};
use crate::mesh_corners::{loaded, surface};
use crate::support::random::Stream;
use crate::support::scene::{body, laws, Rotation, Vector};
use ellgran::contact::{Body, Laws};
use ellgran::geometry::triangles::Triangle;
use ellgran::vector::Vector3;
use ellgran::walls::flatten_triangles;

/// Each triangle as four by the middles of its edges, which are exactly those of its neighbours.
fn divided(wall: &[Triangle]) -> Vec<Triangle> {
    wall.iter()
        .flat_map(|&[a, b, c]| {
            let [p, q, r] = [(a, b), (b, c), (c, a)].map(|(from, to)| (from + to) * 0.5);
            [[a, p, r], [p, b, q], [r, q, c], [p, q, r]]
        })
        .collect()
}

/// As a file has it.
pub fn in_single_precision(wall: &[Triangle]) -> Vec<Triangle> {
    let single = |x: f64| f64::from(x as f32);
    let rounded = |p: Vector3| Vector3::from_array(p.to_array().map(single));
    wall.iter().map(|t| t.map(rounded)).collect()
}

/// By how much the force differs from another, in its own size, and the torque, by the body's.
pub fn difference(found: &Felt, expected: &Felt) -> f64 {
    let force = (found.force - expected.force).norm();
    force.max((found.torque - expected.torque).norm()) / expected.force.norm()
}

/// The law of the grains here.
pub fn law() -> Laws {
    laws(&["hertz 1e7 0.3 conservative no"])
}

/// Grains of any shape on uneven floors of triangles from a seventh of a grain's radius to four of them, and from nearly flat to steep.
pub fn visit_floors(seed: u64, mut found: impl FnMut(f64, f64, &[Triangle], &Body)) {
    let laws = law();
    let mut stream = Stream::new(seed);
    for size in [0.15, 0.3, 0.45, 0.7, 1.0, 2.0, 4.0] {
        for rough in [0.02, 0.1, 0.4] {
            for case in 0..5 {
                let axes = match case % 2 {
                    0 => [1.0; 3],
                    _ => stream.semi_axes(5.0),
                };
                let least = axes.iter().copied().fold(1.0, f64::min);
                let turn: Rotation = stream.rotation();
                let depth = stream.log_uniform(1e-3, 3e-2) * least;
                let squares = ((6.0 / size) as usize + 4).min(12);
                let height = |s: &mut Stream, _: f64, _: f64| rough * size * s.uniform(-1.0, 1.0);
                let wall = surface(&mut stream, squares, size, height);
                let s = support(axes, turn, -Vector::z());
                let [x, y] = [0, 1].map(|_| stream.uniform(-size, size));
                let over = body(axes, Vector::new(x - s.x, y - s.y, 0.0), turn);
                let b = loaded(&laws, over, &wall, 0.1 + rough * size, depth);
                found(size, rough, &wall, &b);
            }
        }
    }
}

/// Where convex and concave edges meet, a division by four or sixteen changed the force by a large part of it: the width of the triangles, and
/// how much of an edge was a triangle's side, decided how they act.
#[test]
fn a_finer_division_changes_nothing() {
    let (mut worst, mut count) = (0.0f64, 0);
    let law = law();
    visit_floors(91, |size, rough, wall, b| {
        let felt = |wall: &[Triangle]| on_triangles(&law, b, wall);
        let whole = felt(wall);
        let fine = divided(wall);
        for finer in [divided(&fine), fine] {
            let own = difference(&felt(&finer), &whole);
            assert!(own < 1e-9, "{own} on triangles of {size}, rough by {rough}");
            worst = worst.max(own);
            count += 1;
        }
    });
    println!("{count} divisions change the force by up to {worst:.1e} of it");
}

/// The same in single precision, as in an STL file: each edge between the small triangles is a fold then, and where such folds met the edges of the
/// surface the force could be many times too large.
#[test]
fn rounding_of_a_fine_division_changes_nothing() {
    let (mut worst, mut count) = (0.0f64, 0);
    let law = law();
    visit_floors(93, |size, rough, wall, b| {
        let felt = |wall: &[Triangle]| on_triangles(&law, b, wall);
        let coarse = in_single_precision(wall);
        let mut fine = in_single_precision(&divided(&divided(wall)));
        let moved = flatten_triangles(&mut fine).expect("corners in range");
        assert!(moved > 0.0 && moved < 0.02 * size, "{moved}");
        let own = difference(&felt(&fine), &felt(&coarse));
        println!("{own:.1e} on triangles of {size}, rough by {rough}");
        worst = worst.max(own);
        count += 1;
    });
    println!("{count} floors in single precision change the force by up to {worst:.1e} of it");
    assert!(worst < 1e-5);
}
