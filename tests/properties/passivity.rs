// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do friction and viscosity ever give energy? Random collisions with spin; what each law of the tangential displacement
//! gains at most is printed.

use crate::support::motion::{Motion, Partner, Rigid};
use crate::support::random::Stream;
use crate::support::scene::{laws, Vector};
use crate::support::strategies::TouchingPair;
use ellgran::pairs::Body;

const OVERLAP: f64 = 0.02;

/// A pair about to meet at speed 1.
fn meeting(stream: &mut Stream, aspect: f64) -> (Body, Body, f64) {
    let shapes = [stream.semi_axes(aspect), stream.semi_axes(aspect)];
    let turns = [stream.rotation(), stream.rotation()];
    let n = stream.direction();
    let mut pair = TouchingPair::new(shapes, turns, n, -1e-4);
    for b in [&mut pair.i, &mut pair.j] {
        b.mass = b.semi_axes.iter().product();
        b.angular_velocity = (stream.direction() * stream.uniform(0.0, 1.0)).into();
    }
    pair.j.velocity = (-n + stream.direction() * stream.uniform(0.0, 1.0)).into();
    (pair.i, pair.j, pair.radius)
}

/// Largest gain of energy relative to the initial one, after the collision and at any time in it.
fn gains(words: &str, friction: f64, number: usize, steps: f64) -> [f64; 2] {
    let mut stream = Stream::new(71);
    let mut most = [f64::NEG_INFINITY; 2];
    for _ in 0..number {
        let (i, j, radius) = meeting(&mut stream, 5.0);
        let overlap = OVERLAP * radius;
        let mass = i.mass * j.mass / (i.mass + j.mass);
        let k = 1.25 * mass / overlap.powf(2.5);
        let e = k * 1.5 * 0.91 / (0.5 * radius).sqrt();
        let deck = format!("hertz {e:e} 0.3 {words}").replace("MU", &friction.to_string());
        let laws = laws(&[&deck.replace("TAU", &format!("{:e}", 0.05 * overlap))]);
        let mut motion = Motion::new(
            &laws,
            i,
            Partner::Body(Rigid::new(j)),
            2.94 * overlap / steps,
        );
        let before = motion.energy();
        let mut met = false;
        for _ in 0..(20.0 * steps) as usize {
            motion.step();
            most[1] = most[1].max(motion.energy() / before - 1.0);
            met |= motion.felt.is_some();
            if met && motion.felt.is_none() {
                break;
            }
        }
        most[0] = most[0].max(motion.energy() / before - 1.0);
    }
    most
}

/// The integrator's own error on the same collisions without friction.
fn integrator(number: usize, steps: f64) -> f64 {
    gains("", 0.0, number, steps)[0].abs()
}

#[test]
fn rescaled_displacement_never_gains() {
    let own = integrator(60, 400.0);
    for words in [
        "tangential mindlin MU displacement rescaled",
        "tangential tfd MU displacement rescaled",
        "damping relaxation TAU tangential mindlin MU displacement rescaled",
        "damping relaxation TAU tangential tfd MU displacement rescaled",
        "damping restitution 0.7 tangential mindlin MU displacement rescaled",
    ] {
        for friction in [0.1, 0.5, 10.0] {
            let [after, within] = gains(words, friction, 60, 400.0);
            println!("{words}, mu {friction}: gain after the collision at most {after:.1e}, within it {within:.1e} (integrator {own:.1e})");
            assert!(after <= own + 1e-5, "{words}, mu {friction}: {after:e}");
        }
    }
}

#[test]
fn total_and_incremental_displacement_show_their_gain() {
    for words in [
        "tangential mindlin MU displacement total",
        "tangential mindlin MU displacement incremental",
        "tangential tfd MU displacement total",
        "tangential tfd MU displacement incremental",
    ] {
        for friction in [0.1, 0.5, 10.0] {
            let [after, within] = gains(words, friction, 60, 400.0);
            println!("{words}, mu {friction}: gain after the collision at most {after:.1e}, within it {within:.1e}");
            // These laws do gain; no more than a tangential spring can hold.
            assert!(after < 0.5);
        }
    }
}

#[test]
fn viscosity_alone_dissipates_in_every_collision() {
    for words in [
        "damping relaxation TAU",
        "damping relaxation TAU unloading first_order",
        "damping restitution 0.7",
    ] {
        let [after, within] = gains(words, 0.0, 60, 400.0);
        println!("{words}: gain {after:.1e}, within the collision {within:.1e}");
        assert!(after < 0.0 && within < 1e-5);
    }
}

/// Loading with a tangential displacement, unloading and bringing it back, at rest otherwise: the cycle of Elata and
/// Berryman by hand.
#[test]
fn a_cycle_of_load_and_displacement_gives_no_energy_when_rescaled() {
    use crate::support::scene::{advance, body, Memory, Rotation};
    let cycle = |words: &str| {
        let laws = laws(&[&format!(
            "hertz 1e6 0.3 tangential mindlin 100 displacement {words}"
        )]);
        let mut memory = Memory::new(&laws);
        let i = body([1.0; 3], Vector::zeros(), Rotation::identity());
        let mut j = i;
        let steps = 400;
        let dt = 1.0 / steps as f64;
        let mut work = 0.0;
        // Deep at first; slide out by x; unload to a quarter; slide back; all at this depth.
        let path = [
            (0.01, 0.0, 0.01, 1e-4),
            (0.01, 1e-4, 0.0025, 1e-4),
            (0.0025, 1e-4, 0.0025, 0.0),
        ];
        let mut last = Vector::new(2.0 - 0.01, 0.0, 0.0);
        let mut energy = [0.0; 2];
        for (from_depth, from_slide, to_depth, to_slide) in path {
            for k in 1..=steps {
                let t = k as f64 * dt;
                let depth = from_depth + (to_depth - from_depth) * t;
                let slide = from_slide + (to_slide - from_slide) * t;
                let now = Vector::new(2.0 - depth, slide, 0.0);
                j.position = now.into();
                j.velocity = ((now - last) / dt).into();
                let f = advance(&laws, &i, &j, dt, &mut memory).expect("touching");
                // Work done on the bodies by the tangential force, against it.
                work += f.tangential.dot(&(now - last));
                last = now;
                energy[0] = f.forces.tangential_energy;
                energy[1] = f.forces.elastic_energy;
            }
        }
        (work, energy[0])
    };
    let (work, left) = cycle("rescaled");
    println!("rescaled: the tangential force gives {work:.2e} in the cycle and holds {left:.2e}");
    assert!(work <= 0.0);
    let (work, left) = cycle("incremental");
    println!("incremental: gives {work:.2e} and holds {left:.2e}");
    let (work, left) = cycle("total");
    println!("total: gives {work:.2e} and holds {left:.2e}");
}
