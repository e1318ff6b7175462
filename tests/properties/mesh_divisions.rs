// SPDX-License-Identifier: MIT OR Apache-2.0
//! One surface divided into more triangles, all in the planes of the former ones: does a grain on it feel the same?

use crate::faceted_walls::{on_triangles, support};
use crate::mesh_corners::{loaded, surface};
use crate::support::random::Stream;
use crate::support::scene::{body, laws, Vector};
use ellgran::geometry::triangles::Triangle;

/// Each triangle as four by the middles of its edges, which are exactly those of its neighbours.
fn divided(wall: &[Triangle]) -> Vec<Triangle> {
    wall.iter()
        .flat_map(|&[a, b, c]| {
            let [p, q, r] = [(a, b), (b, c), (c, a)].map(|(from, to)| (from + to) * 0.5);
            [[a, p, r], [p, b, q], [r, q, c], [p, q, r]]
        })
        .collect()
}

#[test]
fn scratch_division() {
    let laws = laws(&["hertz 1e7 0.3 conservative no"]);
    for size in [0.15, 0.3, 0.45, 0.7, 1.0, 2.0, 4.0] {
        for rough in [0.02, 0.05, 0.1] {
            let mut stream = Stream::new(91);
            let mut worst = [0.0f64; 3];
            let mut over = [0; 3];
            let count = 60;
            for case in 0..count {
                let axes = if case % 2 == 0 { [1.0; 3] } else { stream.semi_axes(5.0) };
                let least = axes.iter().copied().fold(1.0, f64::min);
                let turn = stream.rotation();
                let depth = stream.log_uniform(1e-3, 3e-2) * least;
                let squares = (6.0 / size) as usize + 4;
                let wall = surface(&mut stream, squares.min(16), size, |s, _, _| rough * size * s.uniform(-1.0, 1.0));
                let fine = divided(&wall);
                let finer = divided(&fine);
                let single: Vec<Triangle> = finer.iter().map(|t| t.map(|p| ellgran::vector::Vector3::new(p.x as f32 as f64, p.y as f32 as f64, p.z as f32 as f64))).collect();
                let s = support(axes, turn, -Vector::z());
                let [x, y] = [0, 1].map(|_| stream.uniform(-size, size));
                let b = body(axes, Vector::new(x - s.x, y - s.y, 0.0), turn);
                let b = loaded(&laws, b, &wall, depth);
                let f = on_triangles(&laws, &b, &wall);
                for (k, w) in [&fine, &finer, &single].into_iter().enumerate() {
                    let d = on_triangles(&laws, &b, w);
                    let e = (d.force - f.force).norm() / f.force.norm();
                    worst[k] = worst[k].max(e);
                    over[k] += usize::from(e > 1e-3);
                    if k < 2 && e > 1e-3 {
                        println!("case {case} axes {axes:?} depth {depth} e {e} k {k}");
                        let i = ellgran::contact::prepare_body(&b, None).unwrap();
                        for w in [&wall, w] {
                            let mut search = ellgran::geometry::triangles::TriangleSearch::default();
                            search.touch(&i.body, i.position, w);
                            for c in search.contacts() { println!("  {:?} {:.4e} share {:.3e} n {:.3} {:.3} p {:.3} {:.3} {:.3}", std::mem::discriminant(&c.feature), c.penetration, c.share.value, c.normal.x, c.normal.y, (c.point - i.position).x, (c.point-i.position).y, (c.point-i.position).z); }
                            println!("  --");
                        }
                    }
                }
            }
            println!("size {size} rough {rough}: fine {:.1e} ({}) finer {:.1e} ({}) single {:.1e} ({})", worst[0], over[0], worst[1], over[1], worst[2], over[2]);
        }
    }
}
