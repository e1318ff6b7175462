// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do elastic frictionless collisions of ellipsoids keep their energy, and do they run backwards?

use crate::harness::{
    angular_momentum, kinetic_energy, linear_momentum, run, Deck, Engine, Frame, Grain, Outcome,
    Scene,
};
use crate::shapes::{
    about, add, compose, cross, dot, effective_mass, hertz_stiffness, length, normalise, rotate,
    scale, sub, surface_point, unit, unrotate, Quaternion, Vector,
};

const MODULUS: f64 = 1e7;
const POISSON: f64 = 0.3;
const SMALL: f64 = 1e-2;

struct Collision {
    name: String,
    scene: Scene,
    /// Hertz contact time with the effective mass at the contact.
    time: f64,
    stiffness: f64,
    depth: f64,
}

/// Outward normal at the surface point whose coordinates are (c a_1, s a_2, sqrt(1 - c^2 - s^2) a_3).
fn normal_at(a: Vector, c: f64, s: f64) -> Vector {
    let point = [c * a[0], s * a[1], (1.0 - c * c - s * s).sqrt() * a[2]];
    unit(std::array::from_fn(|k| point[k] / (a[k] * a[k])))
}

/// Turns `from` onto `to`.
fn turn_onto(from: Vector, to: Vector) -> Quaternion {
    let axis = cross(from, to);
    let q = [1.0 + dot(from, to), axis[0], axis[1], axis[2]];
    if q[0] < 1e-9 {
        about([1.0, 0.0, 0.0], std::f64::consts::PI)
    } else {
        normalise(q)
    }
}

/// Two ellipsoids that just touch off centre, tilted and twisted against each other, approaching along the common normal
/// fast enough to overlap by `share` of the small semi-axis.
fn collision(
    aspect: f64,
    place: (f64, f64),
    other: (f64, f64),
    twist: f64,
    share: f64,
    name: &str,
) -> Collision {
    let a = [aspect * SMALL, 1.3 * SMALL, SMALL];
    let b = [0.9 * aspect * SMALL, SMALL, 1.2 * SMALL];
    let world = about([0.4, -0.2, 0.7], 0.8);
    let n = rotate(world, normal_at(a, place.0, place.1));
    let mut j = turn_onto(normal_at(b, other.0, other.1), scale(-1.0, n));
    j = compose(about(n, twist), j);
    let (arm_i, arm_j) = (
        surface_point(a, world, n),
        surface_point(b, j, scale(-1.0, n)),
    );
    let mut first = Grain {
        density: 2500.0,
        ..Grain::new(a, scale(-1.0, arm_i)).turned(world)
    };
    let mut second = Grain {
        density: 2500.0,
        ..Grain::new(b, scale(-1.0, arm_j)).turned(j)
    };
    let mass = effective_mass(
        [
            (first.mass(), a, world, arm_i),
            (second.mass(), b, j, arm_j),
        ],
        n,
    );
    let stiffness = hertz_stiffness(
        MODULUS / (2.0 * (1.0 - POISSON * POISSON)),
        (a, world),
        (b, j),
        n,
    );
    let depth = share * SMALL;
    let speed = (4.0 * stiffness * depth.powf(2.5) / (5.0 * mass)).sqrt();
    // centre of mass at rest; a part of the approach goes across the normal
    let across = unit(cross(n, [0.3, 0.5, -0.8]));
    let relative = add(scale(-speed, n), scale(0.3 * speed, across));
    let total = first.mass() + second.mass();
    first.velocity = scale(-second.mass() / total, relative);
    second.velocity = scale(first.mass() / total, relative);
    let time = 2.9432751843247047 * depth / speed;
    let name = format!("{name}, aspect {aspect}, overlap {:.1} %", 100.0 * share);
    Collision {
        name,
        scene: Scene::open(8.0 * aspect * SMALL, vec![first, second]),
        time,
        stiffness,
        depth,
    }
}

fn cases() -> Vec<Collision> {
    let mut cases = vec![];
    for share in [1e-3, 1e-2, 5e-2] {
        for aspect in [2.0, 5.0, 10.0, 30.0] {
            cases.push(collision(
                aspect,
                (0.3, 0.2),
                (-0.2, 0.3),
                0.5,
                share,
                "tilted and twisted",
            ));
            cases.push(collision(
                aspect,
                (0.6, 0.0),
                (0.5, 0.1),
                1.3,
                share,
                "off centre",
            ));
        }
    }
    cases
}

fn kinetic(scene: &Scene, frame: &Frame) -> f64 {
    scene
        .grains
        .iter()
        .zip(&frame.states)
        .map(|(g, s)| kinetic_energy(g, s))
        .sum()
}

fn apart(frame: &Frame) -> bool {
    frame.states.iter().all(|s| s.force == [0.0; 3])
}

fn play(
    engine: &Engine,
    scene: &Scene,
    deck: Deck,
    time: f64,
    steps_in_contact: f64,
    contact_times: f64,
) -> Outcome {
    let small = scene
        .grains
        .iter()
        .flat_map(|g| g.semi_axes)
        .fold(f64::INFINITY, f64::min);
    let deck = Deck {
        time_step: time / steps_in_contact,
        steps: (contact_times * steps_in_contact) as u64,
        thermo_every: 1,
        skin: 0.1 * small,
        ..deck
    };
    run(engine, "conservation", scene, &deck, 1)
}

struct Balance {
    /// Relative change of the kinetic energy from before to after the contact.
    energy: f64,
    /// Largest relative departure of kinetic plus stored energy at any step.
    on_the_way: f64,
    momentum: f64,
    spin: f64,
    greatest_overlap: f64,
}

/// Until the bodies are apart again.
fn balance(engine: &Engine, c: &Collision, deck: Deck, steps_in_contact: f64) -> Balance {
    let deck = Deck {
        thermo_columns: "step pe ke erot".into(),
        ..deck
    };
    let deck = Deck {
        fixes: vec!["compute turning all erotate/asphere".into()],
        thermo_columns: deck.thermo_columns.replace("erot", "c_turning"),
        ..deck
    };
    let mut contact_times = 1.6;
    loop {
        let outcome = play(
            engine,
            &c.scene,
            deck.clone(),
            c.time,
            steps_in_contact,
            contact_times,
        );
        let (first, last) = (outcome.first(), outcome.last());
        if !apart(last) {
            contact_times *= 1.6;
            assert!(contact_times < 60.0, "{}: the bodies do not part", c.name);
            continue;
        }
        let start = kinetic(&c.scene, first);
        assert!(
            length(sub(last.states[0].velocity, first.states[0].velocity)) > 0.0,
            "{}: no collision",
            c.name
        );
        let rows = outcome.thermo();
        let total =
            |r: &std::collections::HashMap<String, f64>| r["PotEng"] + r["KinEng"] + r["c_turning"];
        let stored = rows.iter().map(|r| r["PotEng"]).fold(0.0, f64::max);
        let speed = c
            .scene
            .grains
            .iter()
            .map(|g| g.mass() * length(g.velocity))
            .sum::<f64>();
        let extent: f64 = c.scene.grains[0].semi_axes[0];
        return Balance {
            energy: kinetic(&c.scene, last) / start - 1.0,
            on_the_way: rows
                .iter()
                .map(|r| (total(r) / start - 1.0).abs())
                .fold(0.0, f64::max),
            momentum: length(linear_momentum(&c.scene.grains, last)) / speed,
            spin: length(sub(
                angular_momentum(&c.scene.grains, last),
                angular_momentum(&c.scene.grains, first),
            )) / (speed * extent),
            greatest_overlap: (2.5 * stored / c.stiffness).powf(0.4),
        };
    }
}

fn ours(conservative: &str) -> Deck {
    Deck::new(&format!(
        "hertz {MODULUS} {POISSON} conservative {conservative}"
    ))
}

#[test]
fn both_versions_elastic_collisions_keep_their_energy() {
    let engine = Engine::from_environment();
    let mut wrong = vec![];
    println!(
        "relative energy error after the collision (largest on the way) at T/200, T/500, T/1000"
    );
    for c in cases() {
        let b = [200.0, 500.0, 1000.0].map(|steps| balance(&engine, &c, ours("yes"), steps));
        println!(
            "{}: reached {:.2} of the overlap; {:+.1e} ({:.0e})  {:+.1e} ({:.0e})  {:+.1e} ({:.0e}); momentum {:.0e}, angular {:.0e}",
            c.name,
            b[2].greatest_overlap / c.depth,
            b[0].energy,
            b[0].on_the_way,
            b[1].energy,
            b[1].on_the_way,
            b[2].energy,
            b[2].on_the_way,
            b[2].momentum,
            b[2].spin
        );
        let falls = b[2].on_the_way < b[0].on_the_way / 15.0;
        if !(b[0].energy.abs() <= 5e-6 && b[2].energy.abs() <= 5e-7 && falls) {
            wrong.push(format!(
                "{}: {:e} at T/200, {:e} at T/1000",
                c.name, b[0].energy, b[2].energy
            ));
        }
        if !(b[2].momentum < 1e-13 && b[2].spin < 1e-13) {
            wrong.push(format!(
                "{}: momentum {:e}, angular momentum {:e}",
                c.name, b[2].momentum, b[2].spin
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn both_versions_reversed_velocities_return_to_the_start() {
    let engine = Engine::from_environment();
    for c in cases() {
        if c.depth < 5e-3 * SMALL {
            continue;
        }
        let forward = play(&engine, &c.scene, ours("yes"), c.time, 1000.0, 1.3);
        let mut back = c.scene.clone();
        for (g, s) in back.grains.iter_mut().zip(&forward.last().states) {
            g.position = s.position;
            g.quaternion = s.quaternion;
            g.velocity = scale(-1.0, s.velocity);
            g.angular_momentum = scale(-1.0, s.angular_momentum);
        }
        let returned = play(&engine, &back, ours("yes"), c.time, 1000.0, 1.3);
        let (mut place, mut speed, mut pose) = (0.0f64, 0.0f64, 0.0f64);
        for (g, s) in c.scene.grains.iter().zip(&returned.last().states) {
            place = place.max(length(sub(s.position, g.position)) / c.depth);
            speed = speed.max(length(add(s.velocity, g.velocity)) / length(g.velocity));
            let axis = rotate(s.quaternion, unrotate(g.quaternion, [0.6, 0.8, 0.0]));
            pose = pose.max(length(sub(axis, [0.6, 0.8, 0.0])) * g.semi_axes[0] / c.depth);
        }
        println!("{}: back to the start within {place:.1e} of the overlap, pose {pose:.1e}, velocities {speed:.1e}", c.name);
        assert!(place < 1e-4 && pose < 1e-4 && speed < 1e-4, "{}", c.name);
    }
}

/// Three laws on the same collisions: ours, ours without the gradient's own terms, and the built-in superellipsoid style.
#[test]
fn other_laws_do_not_keep_energy_whatever_the_step() {
    let engine = Engine::from_environment();
    let modulus = MODULUS / (2.0 * (1.0 - POISSON * POISSON));
    let built_in = || {
        Deck {
        atom_style: "ellipsoid superellipsoid".into(),
        newton: false,
        load_plugin: false,
        ..Deck::with_pair(vec![
            "pair_style granular/superellipsoid".into(),
            format!(
                "pair_coeff * * hertz {:e} 0.0 tangential linear_history 0.0 0.0 0.0 damping mass_velocity",
                4.0 / 3.0 * modulus
            ),
        ])
    }
    };
    println!("relative energy error after the collision at T/200 and T/1000");
    let (mut largest, mut compared) = ([0.0f64; 3], 0);
    let mut steady = [0usize; 2];
    for c in cases() {
        let laws = [ours("yes"), ours("no"), built_in()];
        let errors: Vec<[f64; 2]> = laws
            .into_iter()
            .map(|deck| {
                [200.0, 1000.0].map(|steps| balance(&engine, &c, deck.clone(), steps).energy)
            })
            .collect();
        println!(
            "{}: conservative yes {:+.1e} {:+.1e}; conservative no {:+.1e} {:+.1e}; granular/superellipsoid {:+.1e} {:+.1e}",
            c.name, errors[0][0], errors[0][1], errors[1][0], errors[1][1], errors[2][0], errors[2][1]
        );
        compared += 1;
        for k in 0..3 {
            largest[k] = largest[k].max(errors[k][1].abs());
        }
        for k in 1..3 {
            if (errors[k][0] / errors[k][1] - 1.0).abs() < 0.2 {
                steady[k - 1] += 1;
            }
        }
        if c.depth > 0.04 * SMALL {
            for k in 1..3 {
                assert!(
                    errors[k][1].abs() > 100.0 * errors[0][1].abs(),
                    "{}: law {k}",
                    c.name
                );
            }
        }
    }
    println!(
        "largest at T/1000: conservative yes {:.1e}, conservative no {:.1e}, granular/superellipsoid {:.1e}; of {compared} collisions the error is the same within a fifth at both steps in {} and {}",
        largest[0], largest[1], largest[2], steady[0], steady[1]
    );
    assert!(largest[0] < 5e-7);
    assert!(largest[1] > 1e-3 && largest[2] > 1e-3);
    assert!(largest[1] > 1000.0 * largest[0] && largest[2] > 1000.0 * largest[0]);
}

/// Many collisions at once: the energy of an elastic gas of ellipsoids has no trend, and without the gradient's own terms it has one.
#[test]
fn both_versions_an_elastic_gas_keeps_its_energy() {
    let engine = Engine::from_environment();
    let scene = crate::harness::crowd(64);
    let drift = |conservative: &str, time_step: f64| {
        let steps = (0.02 / time_step).round() as u64;
        let deck = Deck {
            time_step,
            steps,
            thermo_every: steps / 200,
            thermo_columns: "step pe ke c_turning".into(),
            fixes: vec!["compute turning all erotate/asphere".into()],
            skin: 2e-3,
            ..Deck::new(&format!("hertz 1e8 0.3 conservative {conservative}"))
        };
        let outcome = run(&engine, "elastic_gas", &scene, &deck, 1);
        let total: Vec<f64> = outcome
            .thermo()
            .iter()
            .map(|r| r["PotEng"] + r["KinEng"] + r["c_turning"])
            .collect();
        let last = total[total.len() - 1] / total[0] - 1.0;
        (
            last,
            total
                .iter()
                .map(|e| (e / total[0] - 1.0).abs())
                .fold(0.0, f64::max),
        )
    };
    let (coarse, fine) = (drift("yes", 4e-6), drift("yes", 1e-6));
    let (other_coarse, other_fine) = (drift("no", 4e-6), drift("no", 1e-6));
    println!(
        "elastic gas, relative change of the energy (largest) at 4 us and 1 us: conservative yes {:+.1e} ({:.1e}) {:+.1e} ({:.1e}); no {:+.1e} ({:.1e}) {:+.1e} ({:.1e})",
        coarse.0, coarse.1, fine.0, fine.1, other_coarse.0, other_coarse.1, other_fine.0, other_fine.1
    );
    assert!(
        fine.1 < 0.15 * coarse.1,
        "the error does not fall with the square of the step"
    );
    assert!(fine.1 < 1e-4 && other_fine.1 > 20.0 * fine.1);
}

/// A dense packing of elastic grains with friction, pressed together and slowly stirred, for 0.16 s. Each contact carries a
/// tangential displacement while its normal force vibrates. The published form gains from that for ever, as much at half the
/// step; the default loses what slides and never gains.
#[test]
fn both_versions_an_elastic_frictional_packing_gains_no_energy() {
    let engine = Engine::from_environment();
    let mut scene = crate::harness::crowd(64);
    for g in &mut scene.grains {
        g.semi_axes = [1.32e-2, 1.26e-2, 1.23e-2];
        // nearer to the places of a lattice: little slides
        let cell = 2.4e-2;
        g.position = g.position.map(|x| {
            let place = ((x / cell).floor() + 0.5) * cell;
            0.98 * (place + 0.5 * (x - place))
        });
        g.velocity = scale(0.2, g.velocity);
        g.angular_momentum = [0.0; 3];
    }
    scene.high = scale(0.98, scene.high);
    let energies = |displacement: &str, time_step: f64| {
        let deck = Deck {
            time_step,
            steps: (0.16 / time_step).round() as u64,
            thermo_every: (5e-4 / time_step).round() as u64,
            thermo_columns: "step pe ke c_turning".into(),
            fixes: vec!["compute turning all erotate/asphere".into()],
            skin: 2e-3,
            ..Deck::new(&format!(
                "hertz 1e7 0.3 tangential tfd 1 displacement {displacement}"
            ))
        };
        let outcome = run(&engine, "frictional_packing", &scene, &deck, 1);
        let warned = outcome.output.matches("can create energy").count();
        let rows = outcome.thermo();
        let moving: Vec<f64> = rows.iter().map(|r| r["KinEng"] + r["c_turning"]).collect();
        let total: Vec<f64> = rows
            .iter()
            .zip(&moving)
            .map(|(r, m)| r["PotEng"] + m)
            .collect();
        let most = total
            .windows(2)
            .map(|e| e[1] / e[0] - 1.0)
            .fold(f64::MIN, f64::max);
        let end = total.len() - 1;
        println!(
            "displacement {displacement}, step {time_step:e}: energy after 0.16 s {:.4} times that at the start, kinetic {:.1} times; most gained in 0.5 ms {most:.1e}",
            total[end] / total[0],
            moving[end] / moving[0]
        );
        (
            total[end] / total[0],
            total[end / 2] / total[0],
            most,
            warned,
        )
    };
    let (published, at_half, _, warnings) = energies("total", 1e-5);
    let (finer, ..) = energies("total", 5e-6);
    assert!(
        published > 1.03 && published > at_half + 0.01,
        "{published}"
    );
    assert!(
        (finer - published).abs() < 0.2 * (published - 1.0),
        "{published} {finer}: an error of the step, not of the law"
    );
    let (left, _, most, warned) = energies("rescaled", 1e-5);
    assert!(most < 1e-5 && left < 1.0, "{left} {most:e}");
    assert_eq!((warned, warnings), (0, 1));
}

/// Needles pressed against each other side by side, end to end and across, all at once, for many steps.
#[test]
fn both_versions_a_crowd_of_needles_stays_finite() {
    let engine = Engine::from_environment();
    for aspect in [10.0, 30.0] {
        let mut scene = crate::harness::crowd(125);
        for (k, g) in scene.grains.iter_mut().enumerate() {
            let thin = 0.03 / aspect;
            g.semi_axes = [0.03, thin, thin];
            // a third exactly parallel, a third exactly across
            let quarter = about([0.0, 0.0, 1.0], std::f64::consts::FRAC_PI_2);
            g.quaternion = [crate::shapes::IDENTITY, quarter, g.quaternion][k % 3];
            g.angular_momentum = [0.0; 3];
        }
        let deck = Deck {
            time_step: 1e-6,
            steps: 5000,
            thermo_every: 100,
            thermo_columns: "step pe ke c_turning c_energy[3] c_energy[4]".into(),
            fixes: vec![
                "compute turning all erotate/asphere".into(),
                "compute energy all pair gran/ellipsoid".into(),
            ],
            skin: 2e-3,
            ..Deck::new("nfd 1e8 0.3 500 500 tangential tfd 0.4")
        };
        let outcome = run(&engine, "needles", &scene, &deck, 1);
        let rows = outcome.thermo();
        let total = |k: usize| {
            rows[k]["PotEng"] + rows[k]["KinEng"] + rows[k]["c_turning"] + rows[k]["c_energy[3]"]
        };
        let last = rows.len() - 1;
        let contacts: f64 = rows.iter().map(|r| r["c_energy[4]"]).sum();
        println!(
            "needles of aspect {aspect}: {contacts} contacts seen at {} moments, energy account off by {:.1e}, {:.0} % dissipated",
            rows.len(),
            total(last) / total(0) - 1.0,
            100.0 * rows[last]["c_energy[3]"] / total(0)
        );
        assert!(contacts > 100.0);
        assert!(
            (total(last) / total(0) - 1.0).abs() < 0.03,
            "aspect {aspect}"
        );
        let finite = outcome.last().states.iter().all(|s| {
            s.position
                .iter()
                .chain(&s.velocity)
                .chain(&s.angular_momentum)
                .all(|x| x.is_finite())
        });
        assert!(finite, "aspect {aspect}: a state is not finite");
    }
}
