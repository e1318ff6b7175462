// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is the gap of separated bodies their distance?

use crate::support::brute_force::deepest;
use crate::support::random::Stream;
use crate::support::scene::{body, geometry, vector, Vector};

#[test]
fn gap_is_the_widest_separation_over_all_directions() {
    let mut stream = Stream::new(51);
    for aspect in [3.0, 10.0, 100.0] {
        let (mut worst, mut pairs) = (0.0f64, 0);
        for _ in 0..800 {
            let i = body(stream.semi_axes(aspect), Vector::zeros(), stream.rotation());
            let far = stream.log_uniform(0.05, 4.0);
            let j = body(
                stream.semi_axes(aspect),
                stream.direction() * far,
                stream.rotation(),
            );
            let (f, n) = deepest(&i, &j, 40);
            if f >= -1e-9 {
                continue;
            }
            pairs += 1;
            let g = geometry(&i, &j);
            assert!(!g.touching && g.penetration < 0.0);
            let error = (g.penetration - f).abs();
            worst = worst.max(error);
            assert!(error < 1e-12, "{} {f}: {i:?} {j:?}", g.penetration);
            // The closest points are joined by the normal and apart by the gap.
            let join = vector(g.witness_j) - vector(g.witness_i);
            assert!(
                (join - vector(g.normal) * -g.penetration).norm() < 1e-7,
                "{join:?}"
            );
            assert!((vector(g.normal) - n).norm() < 1e-5);
            let middle = 0.5 * (vector(g.witness_j) + vector(g.witness_i));
            assert!((vector(g.contact_point) - middle).norm() < 1e-7);
        }
        println!(
            "aspect ratio up to {aspect}: gap of {pairs} separated pairs off by up to {worst:.1e}"
        );
        assert!(pairs > 200);
    }
}
