// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is the conservative law the gradient of its energy? Finite differences with the whole search in the loop.

use crate::support::random::Stream;
use crate::support::scene::{
    advance_plane, laws, position, quaternion, rotation, touch, wall, Memory, Rotation, Vector,
};
use crate::support::strategies::TouchingPair;
use ellgran::contact::{Body, Laws};

/// Sixth-order central difference with steps of `h`.
fn slope(energy: impl Fn(f64) -> f64, h: f64) -> f64 {
    let d = |k: f64| energy(k * h) - energy(-k * h);
    (45.0 * d(1.0) - 9.0 * d(2.0) + d(3.0)) / (60.0 * h)
}

fn shifted(b: &Body, axis: usize, by: f64) -> Body {
    let mut b = *b;
    b.position[axis] += by;
    b
}

fn turned(b: &Body, axis: usize, by: f64) -> Body {
    let mut b = *b;
    b.quaternion =
        quaternion(Rotation::from_scaled_axis(Vector::ith(axis, by)) * rotation(b.quaternion));
    b
}

fn gradient(of: impl Fn(usize, f64) -> f64, h: f64) -> Vector {
    Vector::from([0, 1, 2].map(|axis| slope(|x| of(axis, x), h)))
}

struct Errors {
    force: f64,
    torque: f64,
    /// Of the Hertz force alone, along the normal.
    without: f64,
}

impl Errors {
    fn none() -> Self {
        Errors {
            force: 0.0,
            torque: 0.0,
            without: 0.0,
        }
    }
    fn join(&mut self, o: Errors) {
        self.force = self.force.max(o.force);
        self.torque = self.torque.max(o.torque);
        self.without = self.without.max(o.without);
    }
    fn show(&self, name: &str) {
        println!(
            "{name}: force off by {:.1e}, torques by {:.1e} of the gradient; without the additional terms {:.1e}",
            self.force, self.torque, self.without
        );
    }
}

/// Force relative to the force, torques relative to the force times the largest semi-axis.
fn pair_errors(laws: &Laws, plain: &Laws, pair: &TouchingPair) -> Errors {
    let (i, j) = (&pair.i, &pair.j);
    let energy = |i: &Body, j: &Body| touch(laws, i, j).expect("touching").forces.elastic_energy;
    // A step of the depth, so that the energy's 5/2 power is resolved; for rotations over the largest semi-axis.
    let h = 0.02 * pair.penetration;
    let arm = i
        .semi_axes
        .iter()
        .chain(&j.semi_axes)
        .fold(0.0f64, |a, b| a.max(*b));
    let force = -gradient(|axis, x| energy(i, &shifted(j, axis, x)), h);
    let torque_i = -gradient(|axis, x| energy(&turned(i, axis, x), j), h / arm);
    let torque_j = -gradient(|axis, x| energy(i, &turned(j, axis, x)), h / arm);
    let f = touch(laws, i, j).expect("touching");
    let p = touch(plain, i, j).expect("touching");
    let scale = f.force.norm();
    let torque = |f: &crate::support::scene::Felt| {
        (f.torque_i - torque_i)
            .norm()
            .max((f.torque_j - torque_j).norm())
            / (scale * arm)
    };
    Errors {
        force: (f.force - force).norm() / scale,
        torque: torque(&f),
        without: ((p.force - force).norm() / scale).max(torque(&p)),
    }
}

fn laws_of(keyword: &str) -> Laws {
    laws(&[
        &format!("hertz 1e6 0.3 conservative {keyword}"),
        &format!("hertz 7e7 0.1 conservative {keyword}"),
    ])
}

#[test]
fn random_pairs_of_two_materials_up_to_aspect_ratio_30() {
    let (complete, plain) = (laws_of("yes"), laws_of("no"));
    for aspect in [2.0, 10.0, 30.0] {
        let mut stream = Stream::new(61);
        let mut worst = Errors::none();
        for _ in 0..60 {
            let shapes = [stream.semi_axes(aspect), stream.semi_axes(aspect)];
            let turns = [stream.rotation(), stream.rotation()];
            let mut pair = TouchingPair::new(shapes, turns, stream.direction(), 0.05);
            pair.j.particle_type = 2;
            if touch(&plain, &pair.i, &pair.j)
                .expect("touching")
                .geometry
                .penetration
                < 0.99 * pair.penetration
            {
                // Thinner than deep: another normal is nearer.
                continue;
            }
            worst.join(pair_errors(&complete, &plain, &pair));
        }
        worst.show(&format!("aspect ratio up to {aspect}"));
        assert!(worst.force < 1e-8 && worst.torque < 1e-8);
        assert!(worst.without > 1e-4, "a test that could not fail");
    }
}

#[test]
fn near_circular_contacts() {
    let (complete, plain) = (laws_of("yes"), laws_of("no"));
    let mut stream = Stream::new(62);
    let mut worst = Errors::none();
    for hair in [0.0, 1e-12, 1e-9, 1e-6, 1e-3] {
        for k in 0..10 {
            // Tip to tip, both of revolution but for a hair: A = B but for a hair.
            let tip = 0.5 + 0.1 * k as f64;
            let shapes = [[1.0, 1.0 + hair, tip], [0.8 - hair, 0.8, 1.1]];
            let n = stream.direction();
            let up = Rotation::rotation_between(&Vector::z(), &n).unwrap_or_default();
            let spin = Rotation::from_axis_angle(&Vector::z_axis(), stream.uniform(0.0, 6.0));
            let mut pair = TouchingPair::new(shapes, [up, up * spin], n, 0.05);
            pair.j.particle_type = 2;
            worst.join(pair_errors(&complete, &plain, &pair));
            // Spheres but for a hair, in any direction.
            let round = [
                [1.0, 1.0 + hair, 1.0 - hair],
                [0.7, 0.7 - hair, 0.7 + 0.5 * hair],
            ];
            let mut pair =
                TouchingPair::new(round, [stream.rotation(), stream.rotation()], n, 0.05);
            pair.j.particle_type = 2;
            worst.join(pair_errors(&complete, &plain, &pair));
            // Crossed at a right angle.
            let quarter = Rotation::from_axis_angle(&Vector::z_axis(), std::f64::consts::FRAC_PI_2);
            let needle = [1.0, 0.3, 0.3 + hair];
            let mut pair = TouchingPair::new([needle, needle], [up, up * quarter], n, 0.05);
            pair.j.particle_type = 2;
            worst.join(pair_errors(&complete, &plain, &pair));
        }
    }
    worst.show("near-circular contacts");
    assert!(worst.force < 1e-8 && worst.torque < 1e-8);
}

#[test]
fn ellipsoid_and_plane() {
    let laws = laws(&["hertz 1e6 0.3"]);
    let plain = crate::support::scene::laws(&["hertz 1e6 0.3 conservative no"]);
    for aspect in [2.0, 10.0, 30.0] {
        let mut stream = Stream::new(63);
        let mut worst = Errors::none();
        for _ in 0..60 {
            let n = stream.direction();
            let plane = wall(n);
            // A pair with a huge sphere would have nearly the same radii; the smallest radius of the body alone counts.
            let shape = stream.semi_axes(aspect);
            let turn = stream.rotation();
            let own = TouchingPair::new([shape, shape], [turn, turn], -n, 0.05);
            let mut i = own.i;
            let h = crate::support::brute_force::support(&i, &n);
            let delta = 0.5 * own.penetration;
            i.position = (n * (h - delta)).into();
            let feel = |laws: &Laws, i: &Body| {
                advance_plane(laws, i, &plane, 0.0, &mut Memory::new(laws)).expect("touching")
            };
            let energy = |i: &Body| feel(&laws, i).forces.elastic_energy;
            let step = 0.02 * delta;
            // On i: the opposite of the force on the wall.
            let force = gradient(|axis, x| energy(&shifted(&i, axis, x)), step);
            let torque = -gradient(|axis, x| energy(&turned(&i, axis, x)), step);
            let (f, p) = (feel(&laws, &i), feel(&plain, &i));
            let scale = f.force.norm();
            worst.join(Errors {
                force: (f.force - force).norm() / scale,
                torque: (f.torque_i - torque).norm() / scale,
                without: (p.torque_i - torque).norm() / scale,
            });
            assert!(position(&i).norm() > 0.0);
        }
        worst.show(&format!("ellipsoid and plane, aspect ratio up to {aspect}"));
        assert!(worst.force < 1e-8 && worst.torque < 1e-8);
        assert!(worst.without > 1e-5, "a test that could not fail");
    }
}
