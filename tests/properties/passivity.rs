// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do friction and viscosity ever give energy? Random collisions with spin, and random cycles of displacement and rotation
//! under load; what each law of the tangential displacement gains at most is printed.

use crate::support::motion::{Motion, Partner, Rigid};
use crate::support::random::Stream;
use crate::support::scene::{laws, Vector};
use crate::support::strategies::TouchingPair;
use ellgran::contact::Body;

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
        let deck = if words.starts_with("nfd") {
            words
                .replace("MODULUS", &format!("{e:e}"))
                .replace("FAST", &format!("{:e}", 0.05 * overlap * e))
                .replace("SLOW", &format!("{:e}", 2.0 * overlap * e))
        } else {
            format!("hertz {e:e} 0.3 {words}")
        };
        let deck = deck.replace("MU", &friction.to_string());
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
        "tangential tfd MU displacement hysteretic",
        "damping relaxation TAU tangential tfd MU displacement hysteretic",
        "damping relaxation TAU tangential mindlin MU displacement rescaled",
        "damping relaxation TAU tangential tfd MU displacement rescaled",
        "damping restitution 0.7 tangential mindlin MU displacement rescaled",
        "tangential mindlin MU twisting marshall",
        "tangential tfd MU displacement hysteretic twisting lubkin",
        "damping relaxation TAU tangential tfd MU displacement hysteretic rolling sds 30 0.3 MU twisting lubkin",
        "damping relaxation TAU tangential tfd MU rolling sds 30 0.3 MU twisting marshall",
        "tangential tfd MU rolling sds 100 0 MU twisting sds 10 0 MU",
        "rolling sds 100 3 MU twisting sds 10 0.3 MU",
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
        "nfd MODULUS 0.3 FAST FAST viscosity memory",
        "nfd MODULUS 0.1 0 FAST viscosity memory",
        "nfd MODULUS 0.45 SLOW 0 viscosity memory",
        "nfd MODULUS 0.1 0 SLOW viscosity memory",
        "nfd MODULUS 0.3 FAST SLOW viscosity memory",
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

/// A smooth random closed curve: a sum of the first harmonics, 0 at its beginning.
struct Loop {
    amplitudes: Vec<[Vector; 2]>,
}

impl Loop {
    fn new(stream: &mut Stream) -> Loop {
        Loop {
            amplitudes: (0..3)
                .map(|_| [0, 1].map(|_| stream.direction() * stream.uniform(0.2, 0.6)))
                .collect(),
        }
    }
    /// Position at `t`, period 1.
    fn at(&self, t: f64) -> Vector {
        let mut sum = Vector::zeros();
        for (k, [a, b]) in self.amplitudes.iter().enumerate() {
            let (sin, cos) = (std::f64::consts::TAU * (k + 1) as f64 * t).sin_cos();
            sum += a * sin + b * (1.0 - cos);
        }
        sum
    }
}

/// How a pair is led around: `j` moves along and across the normal, and turns, on closed curves.
#[derive(Clone, Copy)]
struct Lead {
    /// Aspect ratio of both bodies.
    aspect: f64,
    /// Changes of the penetration, relative to it.
    press: f64,
    /// Displacement across the normal, relative to the penetration.
    slide: f64,
    /// Angle of the rotation of `j`.
    turn: f64,
    /// Period of the cycles over that of the relaxation of the material, for viscous laws.
    period: f64,
    steps: usize,
}

/// The largest work that the contact has given, less what its normal deformation held at the start and holds now, at any
/// time in three equal cycles; in units of the largest tangential energy or, if that is more, 1e-3 of the normal energy.
fn given(words: &str, friction: f64, lead: &Lead, number: usize) -> f64 {
    use crate::support::scene::{advance, Memory, Rotation};
    let mut stream = Stream::new(5);
    let mut most = f64::NEG_INFINITY;
    for _ in 0..number {
        let shapes = [0, 1].map(|_| stream.semi_axes(lead.aspect));
        let turns = [0, 1].map(|_| stream.rotation());
        let smallest = shapes
            .iter()
            .flatten()
            .fold(f64::INFINITY, |a, &b| a.min(b));
        let depth = 0.01 * smallest / lead.aspect;
        let mut pair = TouchingPair::new(shapes, turns, stream.direction(), depth);
        let dt = 1.0 / lead.steps as f64;
        let deck = words
            .replace("MU", &friction.to_string())
            .replace("TAU", &format!("{:e}", 1.0 / lead.period));
        let laws = laws(&[&deck]);
        let n = pair.normal;
        let (moving, turning) = (Loop::new(&mut stream), Loop::new(&mut stream));
        let start = Vector::from(pair.j.position);
        let turn = Rotation::from_quaternion(nalgebra::Quaternion::new(
            pair.j.quaternion[0],
            pair.j.quaternion[1],
            pair.j.quaternion[2],
            pair.j.quaternion[3],
        ));
        let place = |t: f64| {
            let p = moving.at(t);
            let along = n * n.dot(&p);
            let x = start + (along * lead.press + (p - along) * lead.slide) * depth;
            (
                x,
                Rotation::from_scaled_axis(turning.at(t) * lead.turn) * turn,
            )
        };
        let mut memory = Memory::new(&laws);
        let (mut x, mut q) = place(0.0);
        let mut felt = advance(&laws, &pair.i, &pair.j, 1e-12, &mut memory).expect("touching");
        let held = felt.forces.elastic_energy;
        let (mut work, mut tangential, mut worst) = (0.0, 1e-3 * held, f64::NEG_INFINITY);
        for k in 1..=3 * lead.steps {
            let (to, turned) = place(k as f64 * dt);
            let angle = (turned * q.inverse()).scaled_axis();
            pair.j.position = to.into();
            pair.j.quaternion = [turned.w, turned.i, turned.j, turned.k];
            pair.j.velocity = ((to - x) / dt).into();
            pair.j.angular_velocity = (angle / dt).into();
            let Some(now) = advance(&laws, &pair.i, &pair.j, dt, &mut memory) else {
                // Parted: nothing is held any more.
                break;
            };
            work += 0.5 * (felt.force + now.force).dot(&(to - x))
                + 0.5 * (felt.torque_j + now.torque_j).dot(&angle);
            tangential = f64::max(tangential, now.forces.tangential_energy);
            worst = f64::max(
                worst,
                work + now.forces.elastic_energy - held + now.forces.tangential_energy,
            );
            (felt, x, q) = (now, to, turned);
        }
        most = most.max(worst / tangential);
    }
    most
}

const LEADS: [(&str, Lead); 6] = [
    (
        "pressed and displaced",
        Lead {
            aspect: 1.0,
            press: 0.3,
            slide: 0.3,
            turn: 0.0,
            period: 1.0,
            steps: 4000,
        },
    ),
    (
        "far beyond sliding",
        Lead {
            aspect: 1.0,
            press: 0.3,
            slide: 3.0,
            turn: 0.0,
            period: 1.0,
            steps: 4000,
        },
    ),
    (
        "displaced at a steady load, ellipses",
        Lead {
            aspect: 6.0,
            press: 0.0,
            slide: 0.2,
            turn: 0.0,
            period: 1.0,
            steps: 4000,
        },
    ),
    (
        "pressed and displaced, ellipses",
        Lead {
            aspect: 6.0,
            press: 0.3,
            slide: 0.3,
            turn: 0.0,
            period: 1.0,
            steps: 4000,
        },
    ),
    (
        "turned, ellipses",
        Lead {
            aspect: 6.0,
            press: 0.1,
            slide: 0.2,
            turn: 1e-4,
            period: 1.0,
            steps: 4000,
        },
    ),
    (
        "vibrated slowly",
        Lead {
            aspect: 3.0,
            press: 0.02,
            slide: 0.3,
            turn: 0.0,
            period: 300.0,
            steps: 4000,
        },
    ),
];

/// What the path gives as its steps become ever shorter. Until sliding begins the curve of `tfd` bends, and trapezoids fall
/// short of the work put in by the square of the step: such a surplus must fall so when the steps are halved.
fn given_in_the_limit(words: &str, friction: f64, lead: &Lead) -> f64 {
    let coarse = given(words, friction, lead, 4);
    if coarse < NOTHING {
        return coarse;
    }
    let half = Lead {
        steps: 2 * lead.steps,
        ..*lead
    };
    let fine = given(words, friction, &half, 4);
    let limit = (4.0 * fine - coarse) / 3.0;
    println!("{words}, mu {friction}: {coarse:.2e}, at half the step {fine:.2e}, in the limit {limit:.1e}");
    assert!(
        fine < coarse / 3.5,
        "{words}, mu {friction}: {coarse:e}, {fine:e}: no error of the step"
    );
    limit
}

/// Of the largest energy held; rounding and the trapezoids of the other laws.
const NOTHING: f64 = 2e-6;

/// No path of displacement and rotation, closed or not, takes more work out of a contact than went in.
#[test]
fn random_cycles_give_no_work_by_default() {
    for (name, lead) in &LEADS {
        for words in [
            "hertz 1e6 0.3 tangential tfd MU",
            "hertz 1e6 0.3 tangential mindlin MU",
            "hertz 1e6 0.3 tangential linear 1e4 0 MU",
            "hertz 1e6 0.3 damping relaxation TAU tangential tfd MU",
            "hertz 1e6 0.3 damping relaxation TAU unloading first_order tangential tfd MU",
            "hertz 1e6 0.3 damping relaxation TAU tangential mindlin MU",
            "nfd 1 0.1 0 TAU viscosity memory tangential tfd MU",
            "nfd 1 0.45 TAU 0 viscosity memory tangential mindlin MU",
            "nfd 1 0.3 0 0.1 viscosity memory tangential tfd MU",
            "nfd 1 0.3 3 0.01 viscosity memory tangential tfd MU",
        ] {
            for friction in [0.1, 0.5, 10.0] {
                let most = given_in_the_limit(words, friction, lead);
                println!("{name}: {words}, mu {friction}: at most {most:.1e}");
                assert!(most < NOTHING, "{name}: {words}, mu {friction}: {most:e}");
            }
        }
    }
}

/// The other forms do give work, and a memory that falls with the stiffness alone would on ellipses.
#[test]
fn the_published_form_gives_work() {
    for (lead, least) in [(0, 1e-2), (2, 6e-4), (3, 1e-2)] {
        let (name, lead) = &LEADS[lead];
        let words = "hertz 1e6 0.3 tangential tfd MU displacement total";
        let most = given(words, 0.5, lead, 4);
        println!("{name}: {words}: at most {most:.1e}");
        assert!(most > least, "{name}: {most:e}");
    }
}
