// SPDX-License-Identifier: MIT OR Apache-2.0
//! Aspect ratio 1000: how many digits does the support function keep, and do touching needles keep their contact?

use crate::support::random::Stream;
use crate::support::scene::{body, laws, plain, quaternion, touch, Rotation, Vector};
use crate::support::strategies::TouchingPair;
use ellgran::geometry::Ellipsoid;

/// Double-double product and sum, enough for a support function to 1e-25.
#[derive(Clone, Copy)]
struct Twice(f64, f64);

impl Twice {
    fn product(a: f64, b: f64) -> Twice {
        let p = a * b;
        Twice(p, a.mul_add(b, -p))
    }
    fn plus(self, o: Twice) -> Twice {
        let s = self.0 + o.0;
        let v = s - self.0;
        let e = (self.0 - (s - v)) + (o.0 - v) + self.1 + o.1;
        let hi = s + e;
        Twice(hi, e - (hi - s))
    }
    fn times(self, o: Twice) -> Twice {
        let Twice(p, e) = Twice::product(self.0, o.0);
        let e = e + self.0 * o.1 + self.1 * o.0;
        let hi = p + e;
        Twice(hi, e - (hi - p))
    }
}

#[test]
fn support_function_of_aspect_ratio_1000_keeps_its_digits() {
    let mut stream = Stream::new(41);
    let mut worst = 0.0f64;
    for _ in 0..20_000 {
        let a = stream.semi_axes(1000.0);
        let shape = Ellipsoid::new(a, quaternion(stream.rotation())).unwrap();
        // Any direction, and directions close to a body axis's normal plane, where the small axes matter.
        let n = stream.direction();
        let axis = crate::support::scene::vector(shape.axes[0]);
        let n = if stream.uniform(0.0, 1.0) < 0.5 {
            (n - axis * (n.dot(&axis) * (1.0 - stream.log_uniform(1e-6, 1.0)))).normalize()
        } else {
            n
        };
        let h = shape.support(plain(n)).h;
        // h^2 = sum of (a_k axis_k . n)^2, with the same rounded axes, in double-double.
        let mut square = Twice(0.0, 0.0);
        for (axis, a) in shape.axes.iter().zip(a) {
            let dot = Twice::product(axis.x, n.x)
                .plus(Twice::product(axis.y, n.y))
                .plus(Twice::product(axis.z, n.z));
            let z = dot.times(Twice(a, 0.0));
            square = square.plus(z.times(z));
        }
        // h - sqrt(square) = (h^2 - square)/(2 h).
        let Twice(hi, lo) = Twice::product(h, h).plus(Twice(-square.0, -square.1));
        worst = worst.max(((hi + lo) / (2.0 * h)).abs());
    }
    println!(
        "aspect ratio 1000: error of h up to {:.2} roundings of the largest semi-axis",
        worst / f64::EPSILON
    );
    // Formed as a matrix it would be a thousand.
    assert!(worst <= 2.0 * f64::EPSILON);
}

#[test]
fn contacts_of_aspect_ratio_1000_are_found_where_they_were_made() {
    let mut stream = Stream::new(42);
    let laws = laws(&["hertz 1e6 0.3"]);
    let (mut worst, mut elsewhere, number) = (0.0f64, 0, 4000);
    for _ in 0..number {
        let shapes = [stream.semi_axes(1000.0), stream.semi_axes(1000.0)];
        let turns = [stream.rotation(), stream.rotation()];
        let depth = stream.log_uniform(1e-3, 0.3);
        let pair = TouchingPair::new(shapes, turns, stream.direction(), depth);
        if pair.penetration < 1e-11 {
            // Finer than coordinates of this size can tell.
            continue;
        }
        let f = touch(&laws, &pair.i, &pair.j).unwrap_or_else(|| panic!("{pair:?}"));
        let error = f.geometry.penetration - pair.penetration;
        if error < -1e-13 {
            // Deeper than the body is thin: another normal is nearer.
            elsewhere += 1;
            continue;
        }
        worst = worst.max(error.abs());
    }
    println!("aspect ratio 1000: penetration off by up to {worst:.1e} of the largest semi-axis; {elsewhere} of {number} have a nearer normal");
    assert!(worst < 1e-14);
    assert!(elsewhere * 4 < number);
}

#[test]
fn parallel_needles_of_aspect_ratio_1000() {
    let laws = laws(&["hertz 1e6 0.3"]);
    let a = [1.0, 1e-3, 1e-3];
    let turn = Rotation::from_scaled_axis(Vector::new(0.3, -0.8, 0.5));
    for (direction, reach) in [(Vector::x(), 2.0), (Vector::y(), 2e-3)] {
        for depth in [1e-3, 0.1, 0.9] {
            let small = if reach > 1.0 { 1e-6 } else { 1e-3 };
            let delta = depth * small;
            let i = body(a, Vector::zeros(), turn);
            let j = body(a, turn * direction * (reach - delta), turn);
            let f = touch(&laws, &i, &j).expect("touching");
            assert!(
                (f.geometry.penetration / delta - 1.0).abs() < 1e-6,
                "{}",
                f.geometry.penetration
            );
            let apart = body(a, turn * direction * (reach + delta), turn);
            assert!(touch(&laws, &i, &apart).is_none());
        }
    }
}
