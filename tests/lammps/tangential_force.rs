// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does the tangential force of an elliptical contact follow its compliance in both directions, partial slip and viscosity?
//!
//! Two ellipsoids that overlap are held where they are while their velocities stay: every step adds the same tangential
//! displacement, and the force must follow a known curve.

use std::f64::consts::PI;

use crate::harness::{run, Deck, Engine, Grain, Scene};
use crate::shapes::{
    add, cross, dot, elliptic, length, rotate, scale, sub, unrotate, Quaternion, Random, Vector,
};

const MODULUS: f64 = 1e7;
const POISSON: f64 = 0.3;
const SMALL: f64 = 1e-2;

/// Equal ellipsoids one above the other whose contact ellipse has the semi-axes a and b = k a.
struct Stack {
    scene: Scene,
    /// Unit vectors along the major and the minor semi-axis.
    major: Vector,
    minor: Vector,
    normal_force: f64,
    /// Compliances along both.
    compliance: [f64; 2],
    /// Bl/K and D/K.
    beta: [f64; 2],
    /// 2 pi G a C of one body.
    numbers: [f64; 2],
}

fn stack(k: f64, turn: Quaternion) -> Stack {
    let m = 1.0 - k * k;
    let (big_k, big_e) = elliptic(k);
    let (bl, d) = ((big_e - k * k * big_k) / m, (big_k - big_e) / m);
    let ratio = (big_e / (k * k) - big_k) / (big_k - big_e);
    // radii a1^2/a3 and a2^2/a3
    let axes = [SMALL * ratio.sqrt(), SMALL, SMALL];
    let delta = 1e-3 * SMALL;
    let (a, b) = (axes[2] / axes[0].powi(2), axes[2] / axes[1].powi(2));
    let re = 1.0 / (2.0 * (a * b).sqrt());
    let f1 = (4.0 / (PI * m) * k.powf(1.5) * ((big_e / (k * k) - big_k) * (big_k - big_e)).sqrt())
        .cbrt();
    let f2 = 2.0 / PI * k.sqrt() * big_k / f1;
    let normal_force = 4.0 / 3.0 * MODULUS / (2.0 * (1.0 - POISSON * POISSON))
        * re.sqrt()
        * delta.powf(1.5)
        * f2.powf(-1.5);
    let semi_major = (re * delta * f1 * f1 / (f2 * k)).sqrt();
    let shear = MODULUS / (2.0 * (1.0 + POISSON));
    let numbers = [big_k - POISSON * bl, big_k - POISSON * d];
    let up = rotate(turn, [0.0, 0.0, axes[2] - 0.5 * delta]);
    let grain = |s: f64| Grain {
        density: 2500.0,
        ..Grain::new(axes, scale(s, up)).turned(turn)
    };
    Stack {
        scene: Scene::open(0.5, vec![grain(-1.0), grain(1.0)]),
        major: rotate(turn, [1.0, 0.0, 0.0]),
        minor: rotate(turn, [0.0, 1.0, 0.0]),
        normal_force,
        compliance: numbers.map(|n| 2.0 * n / (2.0 * PI * shear * semi_major)),
        beta: [bl / big_k, d / big_k],
        numbers,
    }
}

/// Tangential force on the upper ellipsoid after each step, with both moving apart sideways at `velocity` in all.
fn forces(
    engine: &Engine,
    stack: &Stack,
    law: &str,
    velocity: Vector,
    time_step: f64,
    steps: u64,
) -> Vec<Vector> {
    let mut scene = stack.scene.clone();
    scene.grains[0].velocity = scale(-0.5, velocity);
    scene.grains[1].velocity = scale(0.5, velocity);
    let deck = Deck {
        integrate: false,
        time_step,
        steps,
        dump_every: 1,
        skin: 1e-3,
        ..Deck::new(law)
    };
    let outcome = run(engine, "held", &scene, &deck, 1);
    let normal = cross(stack.major, stack.minor);
    outcome
        .frames
        .iter()
        .map(|f| {
            let force = f.states[1].force;
            assert!(
                (dot(force, normal) / stack.normal_force - 1.0).abs() < 1e-9,
                "normal force {}",
                dot(force, normal)
            );
            // the torque is that of a force at the contact point, halfway: the arm is the same for both bodies
            let (i, j) = (&f.states[0], &f.states[1]);
            let balance = add(
                cross(sub(j.position, i.position), j.force),
                add(i.torque, j.torque),
            );
            assert!(length(balance) < 1e-13 * length(force) * SMALL);
            assert!(
                length(sub(i.torque, j.torque)) < 1e-9 * stack.normal_force * SMALL,
                "the contact point is not halfway"
            );
            sub(force, scale(dot(force, normal), normal))
        })
        .collect()
}

fn ratios() -> [(f64, Option<[f64; 2]>); 3] {
    [
        (0.5, Some([1.887744801222, 1.778331799527])),
        (0.1, Some([3.398959432264, 2.883624084819])),
        (0.9, None),
    ]
}

#[test]
fn both_versions_compliance_of_the_contact_ellipse_in_both_directions() {
    let engine = Engine::from_environment();
    let mut random = Random(31);
    for (k, expected) in ratios() {
        let s = stack(k, random.quaternion());
        if let Some(expected) = expected {
            assert!(
                (s.numbers[0] - expected[0]).abs() < 2e-12
                    && (s.numbers[1] - expected[1]).abs() < 2e-12
            );
        }
        for (direction, c, name) in [
            (s.major, s.compliance[0], "major"),
            (s.minor, s.compliance[1], "minor"),
        ] {
            for displacement in ["total", "incremental", "rescaled"] {
                let law = format!(
                    "hertz {MODULUS} {POISSON} tangential mindlin 1e6 displacement {displacement}"
                );
                let (speed, step) = (1e-3, 1e-5);
                let got = forces(&engine, &s, &law, scale(speed, direction), step, 10);
                assert!(
                    length(got[0]) < 1e-12 * s.normal_force,
                    "a force before anything moved"
                );
                let error = (1..=10)
                    .map(|n| {
                        let wanted = -(n as f64) * speed * step / c;
                        length(sub(got[n], scale(wanted, direction))) / wanted.abs()
                    })
                    .fold(0.0, f64::max);
                println!("a/b {:.2}, 2 pi G a C {:.12} {:.12}, along the {name} axis, {displacement}: error of the force {error:.1e}", 1.0 / k, s.numbers[0], s.numbers[1]);
                assert!(error < 1e-9);
            }
        }
    }
}

/// mu F_n [1 - (1 - s)^(3/2)] along each principal direction, and along the force that there would be without slip in between.
#[test]
fn both_versions_partial_slip_curve() {
    let engine = Engine::from_environment();
    let mut random = Random(32);
    let friction = 0.4;
    for (k, _) in ratios() {
        let s = stack(k, random.quaternion());
        for angle in [0.0f64, 0.5, 1.0, PI / 2.0] {
            let parts = [angle.cos(), angle.sin()];
            let velocity = add(scale(parts[0], s.major), scale(parts[1], s.minor));
            let law = format!("hertz {MODULUS} {POISSON} tangential tfd {friction}");
            let limit = friction * s.normal_force;
            let largest = 1.5 * limit * s.compliance[0];
            let (speed, steps) = (1e-3, 60u64);
            let step = 1.4 * largest / speed / steps as f64;
            let got = forces(&engine, &s, &law, scale(speed, velocity), step, steps);
            let mut error = 0.0f64;
            let mut slid = 0;
            for (n, force) in got.iter().enumerate() {
                let xi = n as f64 * speed * step;
                let free = add(
                    scale(xi * parts[0] / s.compliance[0], s.major),
                    scale(xi * parts[1] / s.compliance[1], s.minor),
                );
                let share = length(free) / (1.5 * limit);
                if share > 1.0 && angle != 0.0 && (angle - PI / 2.0).abs() > 1e-12 {
                    // sliding askew to the axes turns the remembered displacement: only its size is known here
                    error = error.max((length(*force) / limit - 1.0).abs());
                } else {
                    let size = limit * (1.0 - (1.0 - share.min(1.0)).powf(1.5));
                    let wanted = if share == 0.0 {
                        [0.0; 3]
                    } else {
                        scale(-size / length(free), free)
                    };
                    error = error.max(length(sub(*force, wanted)) / limit);
                }
                slid += usize::from(share > 1.0);
            }
            println!("a/b {:.2}, {angle:.2} rad from the major axis: error {error:.1e} of mu F_n, {slid} of {steps} steps sliding", 1.0 / k);
            assert!(error < 1e-9 && slid > 5);
        }
    }
}

/// sqrt(1 - s) A_t/C v on top of the elastic part, with A_t of the energy closure in both directions, and Coulomb's limit of the sum.
#[test]
fn both_versions_viscous_part_of_the_tangential_force() {
    let engine = Engine::from_environment();
    let mut random = Random(33);
    let friction = 0.4;
    for (shear, bulk) in [(500.0, 0.0), (0.0, 500.0), (300.0, 200.0)] {
        let times = [
            shear * (1.0 + POISSON) / MODULUS,
            bulk * 3.0 * (1.0 - 2.0 * POISSON) / MODULUS,
        ];
        for (k, _) in ratios() {
            let s = stack(k, random.quaternion());
            for (axis, direction) in [s.major, s.minor].into_iter().enumerate() {
                let beta = s.beta[axis];
                let base = 3.0 * (1.0 - beta * POISSON);
                let relaxation = times[0]
                    * (3.0 - beta * (1.0 + 2.0 * POISSON - 2.0 * POISSON * POISSON))
                    / base
                    + times[1] * beta * (1.0 + POISSON) * (1.0 - 2.0 * POISSON) / base;
                let limit = friction * s.normal_force;
                let c = s.compliance[axis];
                // the viscous part alone would be a third of the limit
                let speed = limit * c / (3.0 * relaxation);
                let steps = 40u64;
                let step = 1.5 * limit * c / speed / 30.0;
                let law =
                    format!("nfd {MODULUS} {POISSON} {shear} {bulk} tangential tfd {friction}");
                let got = forces(&engine, &s, &law, scale(speed, direction), step, steps);
                let error = got
                    .iter()
                    .enumerate()
                    .map(|(n, force)| {
                        let share = (n as f64 / 30.0).min(1.0);
                        let wanted = limit * (1.0 - (1.0 - share).powf(1.5))
                            + (1.0 - share).sqrt() * relaxation / c * speed;
                        length(sub(*force, scale(-wanted.min(limit), direction))) / limit
                    })
                    .fold(0.0, f64::max);
                println!("eta {shear} {bulk}, a/b {:.2}, axis {axis}: A_t {relaxation:.4e}, error {error:.1e} of mu F_n", 1.0 / k);
                assert!(error < 1e-7);
            }
        }
    }
}

/// A loaded contact that turns as a rigid whole, about the normal and askew to it, keeps its force in its own frame.
///
/// `fix rigid` hands out velocities made with the places of the full step, where free grains have those of the half step, which
/// the law counts on. A turn about the normal or across it then leaves an error of second order, a turn askew one of first order:
/// a displacement of half a step's turn times the distance between the centres for every radian.
#[test]
fn both_versions_memory_turns_with_the_pair() {
    let engine = Engine::from_environment();
    let mut random = Random(34);
    let s = stack(0.5, random.quaternion());
    let normal = cross(s.major, s.minor);
    let loading = add(scale(0.8e-2, s.major), scale(-0.6e-2, s.minor));
    let law = format!("hertz {MODULUS} {POISSON} tangential mindlin 1e6 displacement incremental");
    for (name, axis) in [
        ("about the normal", normal),
        ("about the major axis", s.major),
        ("askew", add(normal, add(s.major, scale(0.5, s.minor)))),
    ] {
        let error = |steps: u64| {
            let mut scene = s.scene.clone();
            scene.grains[0].velocity = scale(-0.5, loading);
            scene.grains[1].velocity = scale(0.5, loading);
            // one radian in a second, whatever the number of steps
            let spin = scale(1.0 / length(axis), axis);
            let mut runs = vec![
                "run 10".to_string(),
                format!("timestep {:e}", 1.0 / steps as f64),
            ];
            for (k, g) in scene.grains.iter().enumerate() {
                let v = cross(spin, g.position);
                let l = g.clone().spinning(spin).angular_momentum;
                runs.push(format!(
                    "set atom {} vx {:e} vy {:e} vz {:e} angmom {:e} {:e} {:e}",
                    k + 1,
                    v[0],
                    v[1],
                    v[2],
                    l[0],
                    l[1],
                    l[2]
                ));
            }
            runs.push("fix whole all rigid single".into());
            runs.push(format!("run {steps}"));
            let deck = Deck {
                integrate: false,
                time_step: 1e-5,
                steps: 10,
                dump_every: 10,
                skin: 1e-2,
                runs,
                ..Deck::new(&law)
            };
            let outcome = run(&engine, "turning", &scene, &deck, 1);
            let before = &outcome.frames[1];
            let after = outcome.last();
            assert_eq!((before.step, after.step), (10, 10 + steps));
            let (q, p) = (before.states[1].quaternion, after.states[1].quaternion);
            let turned = length(sub(rotate(p, unrotate(q, s.major)), s.major))
                + length(sub(rotate(p, unrotate(q, s.minor)), s.minor));
            assert!(turned > 0.5, "the pair has not turned");
            let carried = rotate(p, unrotate(q, before.states[1].force));
            let sideways = sub(
                before.states[1].force,
                scale(dot(before.states[1].force, normal), normal),
            );
            assert!(length(sideways) > 1e-3 * s.normal_force);
            length(sub(after.states[1].force, carried)) / length(sideways)
        };
        let errors = [error(5000), error(10000), error(20000)];
        println!("turned by a radian {name}: force off by {:.1e} {:.1e} {:.1e} of its tangential part in 5000, 10000, 20000 steps", errors[0], errors[1], errors[2]);
        let (falls, most) = if name == "askew" {
            (0.3, 0.5)
        } else {
            (0.1, 1e-4)
        };
        assert!(
            errors[2] < most && (errors[2] < falls * errors[0] || errors[2] < 1e-8),
            "{name}"
        );
    }
}
