// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is the penetration the global minimum of `f(n)` over all directions, the smallest translation that separates?

use crate::support::brute_force::deepest;
use crate::support::random::Stream;
use crate::support::scene::{body, laws, size, touch, Vector};
use ellgran::contact::Body;

/// Moves `j` along the line of centres until the bodies overlap by `depth` (bisection on the brute-force answer, coarse).
fn at_depth(i: &Body, mut j: Body, direction: Vector, depth: f64) -> Body {
    let (mut low, mut high) = (0.0, size(i, &j));
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        j.position = (direction * middle).into();
        if deepest(i, &j, 16).0 > depth {
            low = middle;
        } else {
            high = middle;
        }
    }
    j
}

struct Tally {
    wrong: usize,
    pairs: usize,
    /// Largest excess of the penetration found over the brute-force one, relative to it.
    excess: f64,
    unnoticed: usize,
}

/// Counts pairs whose penetration exceeds the brute-force minimum.
fn count(pairs: impl Iterator<Item = (Body, Body)>, density: usize) -> Tally {
    let laws = laws(&["hertz 1e6 0.3"]);
    let mut tally = Tally {
        wrong: 0,
        pairs: 0,
        excess: 0.0,
        unnoticed: 0,
    };
    for (i, j) in pairs {
        let found = touch(&laws, &i, &j).map(|f| f.geometry.penetration);
        let (wanted, _) = deepest(&i, &j, density);
        tally.pairs += 1;
        let Some(found) = found else {
            assert!(
                wanted < 1e-12 * size(&i, &j),
                "a contact of {wanted} was missed: {i:?} {j:?}"
            );
            continue;
        };
        let slack = 1e-9 * wanted.abs() + 64.0 * f64::EPSILON * size(&i, &j);
        if found > wanted + slack {
            tally.wrong += 1;
            tally.excess = tally.excess.max(found / wanted - 1.0);
        } else if found < wanted - slack {
            // The brute force was beaten.
            tally.unnoticed += 1;
        }
    }
    tally
}

impl Tally {
    fn show(&self, name: &str) {
        println!(
            "{name}: {} of {} not the global minimum (up to {:.1e} too deep); brute force beaten {} times",
            self.wrong, self.pairs, self.excess, self.unnoticed
        );
    }
}

fn random_pairs(
    seed: u64,
    number: usize,
    aspect: f64,
    depth: [f64; 2],
) -> impl Iterator<Item = (Body, Body)> {
    let mut stream = Stream::new(seed);
    (0..number).map(move |_| {
        let i = body(stream.semi_axes(aspect), Vector::zeros(), stream.rotation());
        let j = body(stream.semi_axes(aspect), Vector::zeros(), stream.rotation());
        let smallest = i
            .semi_axes
            .iter()
            .chain(&j.semi_axes)
            .fold(f64::INFINITY, |a, b| a.min(*b));
        let depth = smallest * stream.uniform(depth[0], depth[1]);
        let j = at_depth(&i, j, stream.direction(), depth);
        (i, j)
    })
}

#[test]
fn aspect_ratio_up_to_10_any_depth() {
    let mut stream = Stream::new(21);
    let pairs = (0..1500).map(move |_| {
        let i = body(stream.semi_axes(10.0), Vector::zeros(), stream.rotation());
        let turn = stream.rotation();
        let distance = stream.uniform(0.0, 1.5);
        let j = body(stream.semi_axes(10.0), stream.direction() * distance, turn);
        (i, j)
    });
    let tally = count(pairs, 160);
    tally.show("aspect ratio up to 10, any depth");
    assert_eq!(tally.wrong, 0);
}

#[test]
fn aspect_ratio_up_to_100_up_to_a_tenth_of_the_small_axis() {
    let tally = count(random_pairs(22, 1000, 100.0, [0.0, 0.1]), 200);
    tally.show("aspect ratio up to 100, depth up to 0.1 of the smallest semi-axis");
    assert_eq!(tally.wrong, 0);
}

#[test]
fn aspect_ratio_up_to_100_deep() {
    let tally = count(random_pairs(23, 1000, 100.0, [0.1, 0.9]), 200);
    tally.show("aspect ratio up to 100, depth 0.1 to 0.9 of the smallest semi-axis");
    assert_eq!(tally.wrong, 0);
}

#[test]
fn coincident_centres() {
    for aspect in [10.0, 100.0, 1000.0] {
        let mut stream = Stream::new(24);
        let pairs = (0..800).map(move |_| {
            let i = body(stream.semi_axes(aspect), Vector::zeros(), stream.rotation());
            let j = body(stream.semi_axes(aspect), Vector::zeros(), stream.rotation());
            (i, j)
        });
        let tally = count(pairs, 160);
        tally.show(&format!("coincident centres, aspect ratio up to {aspect}"));
        assert_eq!(tally.wrong, 0);
    }
}
