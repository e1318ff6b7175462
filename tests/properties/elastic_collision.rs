// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does an elastic, frictionless collision keep its energy to the integrator's order, and run backwards to its start?

use crate::support::motion::{Motion, Partner, Rigid};
use crate::support::scene::{body, laws, position, rotation, wall, Vector};
use crate::support::strategies::TouchingPair;
use ellgran::contact::{Body, Laws};

struct Setting {
    i: Body,
    j: Body,
    contact_time: f64,
    deck: String,
}

/// Two needles, tilted, twisted and off centre, that meet at speed 1 and overlap by about `overlap` of the small
/// semi-axis.
fn setting(aspect: f64, overlap: f64) -> Setting {
    let shapes = [[aspect, 1.0, 1.0], [aspect, 0.8, 1.2]];
    let turns = [
        rotation([0.9, 0.2, 0.3, -0.1]),
        rotation([0.5, -0.6, 0.2, 0.5]),
    ];
    let n = Vector::new(0.3, 0.9, -0.2).normalize();
    let mut pair = TouchingPair::new(shapes, turns, n, -1e-6);
    pair.i.mass = aspect;
    pair.j.mass = aspect;
    pair.j.velocity = (-n + Vector::new(0.1, 0.0, 0.15)).into();
    pair.i.angular_velocity = [0.02, 0.0, 0.01];
    // delta_max = (5 m v^2/(4 k))^(2/5), with the radius of curvature 1 for the stiffness: an estimate.
    let mass = 0.5 * aspect;
    let k = 1.25 * mass / overlap.powf(2.5);
    let e = k * 1.5 * (1.0 - 0.09);
    Setting {
        i: pair.i,
        j: pair.j,
        contact_time: 2.94 * overlap,
        deck: format!("hertz {e:e} 0.3"),
    }
}

/// Relative error of the energy after the collision, and the largest overlap.
fn collide(s: &Setting, laws: &Laws, steps: f64) -> (f64, f64) {
    let mut motion = Motion::new(
        laws,
        s.i,
        Partner::Body(Rigid::new(s.j)),
        s.contact_time / steps,
    );
    let before = motion.energy();
    let mut deepest = 0.0f64;
    let mut met = false;
    for _ in 0..(10.0 * steps) as usize {
        motion.step();
        match &motion.felt {
            Some(f) => {
                met = true;
                deepest = deepest.max(f.geometry.penetration);
            }
            None if met => break,
            None => {}
        }
    }
    assert!(met && motion.felt.is_none(), "they met and parted");
    ((motion.energy() / before - 1.0).abs(), deepest)
}

#[test]
fn energy_is_kept_to_the_square_of_the_step() {
    for aspect in [2.0, 10.0, 30.0] {
        for overlap in [1e-3, 1e-2, 5e-2] {
            let s = setting(aspect, overlap);
            let complete = laws(&[&s.deck]);
            let plain = laws(&[&format!("{} conservative no", s.deck)]);
            let errors = [200.0, 1000.0].map(|steps| collide(&s, &complete, steps));
            let without = [200.0, 1000.0].map(|steps| collide(&s, &plain, steps));
            println!(
                "aspect ratio {aspect}, overlap {:.1e}: energy off by {:.1e} at T/200, {:.1e} at T/1000; conservative no {:.1e}, {:.1e}",
                errors[1].1, errors[0].0, errors[1].0, without[0].0, without[1].0
            );
            assert!(errors[0].0 < 5e-6 && errors[1].0 < 5e-7);
            // The law's own error does not fall with the step.
            assert!(without[1].0 > 10.0 * errors[1].0);
            assert!(without[1].0 > 0.2 * without[0].0);
        }
    }
}

#[test]
fn energy_of_a_collision_with_a_plane_is_kept() {
    for aspect in [2.0, 10.0] {
        let n = Vector::z();
        let mut i = body(
            [aspect, 1.0, 0.8],
            Vector::zeros(),
            rotation([0.9, 0.2, 0.3, -0.1]),
        );
        i.position = (n * (crate::support::brute_force::support(&i, &n) + 1e-6)).into();
        i.mass = aspect;
        i.velocity = [0.1, 0.0, -1.0];
        let overlap: f64 = 0.02;
        let e = 1.25 * aspect / overlap.powf(2.5) * 1.5 * 0.91;
        let run = |keyword: &str, steps: f64| {
            let laws = laws(&[&format!("hertz {e:e} 0.3 conservative {keyword}")]);
            let mut motion = Motion::new(&laws, i, Partner::Wall(wall(n)), 2.94 * overlap / steps);
            let before = motion.energy();
            assert!(motion.collide(10 * steps as usize));
            (motion.energy() / before - 1.0).abs()
        };
        let (coarse, fine, without) = (run("yes", 200.0), run("yes", 1000.0), run("no", 1000.0));
        println!("aspect ratio {aspect} on a plane: {coarse:.1e} at T/200, {fine:.1e} at T/1000; conservative no {without:.1e}");
        assert!(coarse < 5e-6 && fine < 5e-7 && without > 10.0 * fine);
    }
}

#[test]
fn energy_within_the_contact_oscillates_with_the_square_of_the_step() {
    let s = setting(5.0, 1e-2);
    let laws = laws(&[&s.deck]);
    let largest = |steps: f64| {
        let mut motion = Motion::new(
            &laws,
            s.i,
            Partner::Body(Rigid::new(s.j)),
            s.contact_time / steps,
        );
        let before = motion.energy();
        let mut worst = 0.0f64;
        for _ in 0..(0.8 * steps) as usize {
            motion.step();
            worst = worst.max((motion.energy() / before - 1.0).abs());
        }
        worst
    };
    let (coarse, fine) = (largest(200.0), largest(800.0));
    println!("within the contact: {coarse:.1e} at T/200, {fine:.1e} at T/800");
    assert!(
        coarse / fine > 12.0 && coarse / fine < 20.0,
        "{}",
        coarse / fine
    );
}

#[test]
fn reversed_velocities_return_to_the_start() {
    for aspect in [2.0, 10.0] {
        let s = setting(aspect, 1e-2);
        let laws = laws(&[&s.deck]);
        let mut motion = Motion::new(
            &laws,
            s.i,
            Partner::Body(Rigid::new(s.j)),
            s.contact_time / 300.0,
        );
        let steps = 500;
        for _ in 0..steps {
            motion.step();
        }
        motion.reverse();
        for _ in 0..steps {
            motion.step();
        }
        let Partner::Body(j) = &motion.j else {
            unreachable!()
        };
        let back = (position(&j.body) - position(&s.j)).norm()
            + (position(&motion.i.body) - position(&s.i)).norm();
        println!("aspect ratio {aspect}: {back:.1e} from the start");
        assert!(back < 1e-9);
    }
}
