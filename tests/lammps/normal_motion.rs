// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contact time, greatest overlap and restitution of head-on collisions, against the numbers of theory.

use crate::harness::{run, Deck, Engine, Frame, Grain, Scene};

pub const RADIUS: f64 = 1e-2;
pub const DENSITY: f64 = 2500.0;
pub const MODULUS: f64 = 1e7;
pub const POISSON: f64 = 0.3;

/// Contact time of an elastic Hertz collision, in units of delta_max / v.
pub const HERTZ_TIME: f64 = 2.9432751843247047;

/// Effective mass and k of F = k delta^(3/2) of the two equal spheres below.
pub fn mass_and_stiffness() -> (f64, f64) {
    let mass = Grain {
        density: DENSITY,
        ..Grain::sphere(RADIUS, [0.0; 3])
    }
    .mass()
        / 2.0;
    (
        mass,
        4.0 / 3.0 * MODULUS / (2.0 * (1.0 - POISSON * POISSON)) * (RADIUS / 2.0).sqrt(),
    )
}

pub fn greatest_overlap(speed: f64) -> f64 {
    let (m, k) = mass_and_stiffness();
    (5.0 * m * speed * speed / (4.0 * k)).powf(0.4)
}

pub fn hertz_time(speed: f64) -> f64 {
    HERTZ_TIME * greatest_overlap(speed) / speed
}

pub struct Collision {
    pub restitution: f64,
    /// From first touch to the moment at which the gap opens (delta = 0).
    pub duration: f64,
    pub greatest_overlap: f64,
    pub greatest_force: f64,
}

/// Head-on collision of two equal spheres that just touch at the first step.
pub fn collide(
    engine: &Engine,
    name: &str,
    law: &str,
    speed: f64,
    time_step: f64,
    elastic_times: f64,
) -> Collision {
    collide_watching(engine, name, law, speed, time_step, elastic_times, true)
}

/// Restitution only: no frames in between are written.
pub fn restitution(
    engine: &Engine,
    name: &str,
    law: &str,
    speed: f64,
    time_step: f64,
    elastic_times: f64,
) -> f64 {
    collide_watching(engine, name, law, speed, time_step, elastic_times, false).restitution
}

fn collide_watching(
    engine: &Engine,
    name: &str,
    law: &str,
    speed: f64,
    time_step: f64,
    elastic_times: f64,
    watch: bool,
) -> Collision {
    let grain = |s: f64| Grain {
        density: DENSITY,
        ..Grain::sphere(RADIUS, [s * RADIUS, 0.0, 0.0]).moving([-s * 0.5 * speed, 0.0, 0.0])
    };
    let scene = Scene::open(0.1, vec![grain(-1.0), grain(1.0)]);
    let steps = (elastic_times * hertz_time(speed) / time_step).ceil() as u64;
    let deck = Deck {
        time_step,
        steps,
        dump_every: u64::from(watch),
        skin: 1e-3,
        ..Deck::new(law)
    };
    let outcome = run(engine, name, &scene, &deck, 1);
    let overlap = |f: &Frame| 2.0 * RADIUS - (f.states[1].position[0] - f.states[0].position[0]);
    let rate = |f: &Frame| f.states[1].velocity[0] - f.states[0].velocity[0];
    let last = outcome.last();
    assert!(
        overlap(last) < 0.0 && last.states[1].force[0] == 0.0,
        "{name}: the spheres are still in contact"
    );
    let greatest = |of: &dyn Fn(&Frame) -> f64| {
        if watch {
            vertex(&outcome.frames.iter().map(of).collect::<Vec<_>>())
        } else {
            f64::NAN
        }
    };
    Collision {
        restitution: rate(last) / speed,
        duration: last.step as f64 * time_step + overlap(last) / rate(last),
        greatest_overlap: greatest(&overlap),
        greatest_force: greatest(&|f| f.states[1].force[0]),
    }
}

/// Greatest value of a sampled curve, by the parabola through the three samples about it.
pub fn vertex(samples: &[f64]) -> f64 {
    let k = (1..samples.len() - 1)
        .max_by(|a, b| samples[*a].total_cmp(&samples[*b]))
        .unwrap();
    let (l, m, r) = (samples[k - 1], samples[k], samples[k + 1]);
    let curvature = l - 2.0 * m + r;
    if curvature == 0.0 {
        m
    } else {
        m - (r - l) * (r - l) / (8.0 * curvature)
    }
}

/// `measure(steps per contact)` at 1000, 2000 and 4000 steps: the error to `expected` must fall by `order`, and what remains, after
/// one extrapolation of that order, must be within `tolerance` (relative).
pub fn converge(
    what: &str,
    expected: f64,
    order: i32,
    tolerance: f64,
    measure: impl Fn(f64) -> f64,
) {
    converge_from(1000.0, what, expected, order, tolerance, measure)
}

pub fn converge_from(
    steps: f64,
    what: &str,
    expected: f64,
    order: i32,
    tolerance: f64,
    measure: impl Fn(f64) -> f64,
) {
    let values = [steps, 2.0 * steps, 4.0 * steps].map(&measure);
    let errors = values.map(|v| v / expected - 1.0);
    let weight = 2f64.powi(order);
    let extrapolated = ((weight * values[2] - values[1]) / (weight - 1.0)) / expected - 1.0;
    println!(
        "{what}: expected {expected:.10}; relative error at T/{:.0}, T/{:.0}, T/{:.0}: {:.2e} {:.2e} {:.2e}; extrapolated (order {order}) {:.1e}",
        steps, 2.0 * steps, 4.0 * steps, errors[0], errors[1], errors[2], extrapolated
    );
    assert!(
        extrapolated.abs() < tolerance,
        "{what}: {values:?} tend to {expected} within {extrapolated:e} only"
    );
    if errors[2].abs() > 0.2 * tolerance {
        assert!(
            errors[2].abs() < errors[0].abs() / 2f64.powf(2.0 * order as f64 - 0.7),
            "{what}: errors {errors:?} do not fall with order {order}"
        );
    }
}

/// As `converge`, where force begins or ends with a power of the overlap below one and the order is no whole number: the error
/// must fall between the coarsest and the finest of the three steps, and what remains after one extrapolation of first order be
/// within `tolerance` (relative).
pub fn approach(
    steps: f64,
    what: &str,
    expected: f64,
    tolerance: f64,
    measure: impl Fn(f64) -> f64,
) {
    let errors = [steps, 2.0 * steps, 4.0 * steps].map(|s| measure(s) / expected - 1.0);
    let remains = 2.0 * errors[2] - errors[1];
    println!(
        "{what}: expected {expected:.10}; relative error at T/{:.0}, T/{:.0}, T/{:.0}: {:.2e} {:.2e} {:.2e}; extrapolated {remains:.1e}",
        steps, 2.0 * steps, 4.0 * steps, errors[0], errors[1], errors[2]
    );
    assert!(
        remains.abs() < tolerance,
        "{what}: relative errors {errors:?}"
    );
    assert!(
        errors[2].abs() < (errors[0].abs() / 2.0).max(0.2 * tolerance),
        "{what}: the error does not fall: {errors:?}"
    );
}

#[test]
fn both_versions_hertz_contact_time_and_greatest_overlap() {
    let engine = Engine::from_environment();
    let law = format!("hertz {MODULUS} {POISSON}");
    for speed in [1e-3, 0.1] {
        let (m, k) = mass_and_stiffness();
        let time = 3.218_065_459_719_043 * (m * m / (k * k * speed)).powf(0.2);
        let measure = |steps: f64| collide(&engine, "hertz_time", &law, speed, time / steps, 1.2);
        converge(
            &format!("Hertz contact time at {speed} m/s"),
            time,
            2,
            1e-6,
            |s| measure(s).duration,
        );
        converge(
            &format!("Hertz greatest overlap at {speed} m/s"),
            greatest_overlap(speed),
            2,
            1e-6,
            |s| measure(s).greatest_overlap,
        );
        converge(
            &format!("Hertz restitution at {speed} m/s"),
            1.0,
            2,
            1e-7,
            |s| measure(s).restitution,
        );
    }
}

/// b = (3/2) A (k/m)^(2/5) v^(1/5); restitution when the contact ends at delta = 0, at F = 0, and with Ting's unloading.
const NFD_TABLE: [(f64, Option<f64>, Option<f64>, f64); 7] = [
    (
        0.01,
        Some(0.988544818656846),
        Some(0.988547439642729),
        0.9885734333,
    ),
    (0.05, None, None, 0.9449344576),
    (
        0.1,
        Some(0.892147587290229),
        Some(0.892858875506553),
        0.8946592491,
    ),
    (0.2, None, None, 0.8063105029),
    (
        0.5,
        Some(0.573824628664949),
        Some(0.595251501135127),
        0.6115915092,
    ),
    (
        1.0,
        Some(0.331164810466641),
        Some(0.393930603229873),
        0.4201625166,
    ),
    (2.0, None, None, 0.2398232521),
];

/// LAMMPS hands out velocities of the half step: a viscous force that is there at once makes the error first order.
const VISCOUS_ORDER: i32 = 1;

#[test]
fn both_versions_nfd_restitution() {
    let engine = Engine::from_environment();
    let (m, k) = mass_and_stiffness();
    let speed: f64 = 0.1;
    for (b, at_no_overlap, at_no_force, ting) in NFD_TABLE {
        let relaxation = b / 1.5 / ((k / m).powf(0.4) * speed.powf(0.2));
        // proportional viscosities: every closure gives this relaxation time
        let (shear, bulk) = (
            relaxation * MODULUS / (1.0 + POISSON),
            relaxation * MODULUS / (3.0 * (1.0 - 2.0 * POISSON)),
        );
        let endings = [
            ("unloading first_order limit_force no", at_no_overlap),
            ("unloading first_order limit_force yes", at_no_force),
            ("unloading ting", Some(ting)),
        ];
        for (words, expected) in endings {
            let Some(expected) = expected else { continue };
            let law = format!("nfd {MODULUS} {POISSON} {shear:e} {bulk:e} {words}");
            let times = 1.3 + 4.0 * b;
            approach(
                2000.0,
                &format!("nfd b {b}, {words}"),
                expected,
                5e-6,
                |s| restitution(&engine, "nfd", &law, speed, hertz_time(speed) / s, times),
            );
        }
    }
}

/// The closures turn viscosities into the relaxation times of the table for E = 1, eta1 = 1, eta2 = 1 or 0.
#[test]
fn both_versions_closures_give_the_relaxation_time_of_theory() {
    let engine = Engine::from_environment();
    let speed: f64 = 0.1;
    let eta = 300.0;
    let table = [
        (
            0.3,
            1.0,
            [
                ("surface", 1.213333333333),
                ("energy", 1.275238095238),
                ("brilliantov", 1.0785185185),
            ],
        ),
        (
            0.3,
            0.0,
            [
                ("surface", 0.173333333333),
                ("energy", 0.978095238095),
                ("brilliantov", 0.674074074074),
            ],
        ),
        (
            0.499,
            1.0,
            [
                ("surface", 0.006995),
                ("energy", 1.496022),
                ("brilliantov", 0.001609),
            ],
        ),
    ];
    for (poisson, bulk, closures) in table {
        for (closure, time) in closures {
            let relaxation = time * eta / MODULUS;
            let step = hertz_time(speed) / 500.0;
            let a = restitution(
                &engine,
                "closure_nfd",
                &format!(
                    "nfd {MODULUS} {poisson} {eta} {} closure {closure}",
                    bulk * eta
                ),
                speed,
                step,
                2.0,
            );
            let b = restitution(
                &engine,
                "closure_hertz",
                &format!("hertz {MODULUS} {poisson} damping relaxation {relaxation:e}"),
                speed,
                step,
                2.0,
            );
            let difference = (a - b).abs();
            println!("closure {closure}, nu {poisson}, eta2/eta1 {bulk}: restitution {:.9}, of A_n = {time} eta1/E {:.9}", a, b);
            assert!(
                a < 0.99995 && difference < 1e-7,
                "{closure}: {difference:e}"
            );
        }
    }
}

#[test]
fn both_versions_damping_restitution_at_any_speed() {
    let engine = Engine::from_environment();
    for e in [0.9, 0.5] {
        for speed in [1e-3, 1e-2, 0.1] {
            let law = format!("hertz {MODULUS} {POISSON} damping restitution {e} limit_force no");
            approach(
                4000.0,
                &format!("damping restitution {e} at {speed} m/s"),
                e,
                5e-6,
                |s| {
                    restitution(
                        &engine,
                        "restitution",
                        &law,
                        speed,
                        hertz_time(speed) / s,
                        3.0,
                    )
                },
            );
        }
    }
}

/// The default: no attraction. Spheres, and ellipsoids end on end and side on side, whose contact is an ellipse.
#[test]
fn both_versions_damping_restitution_without_attraction() {
    let engine = Engine::from_environment();
    for e in [0.9, 0.3, 0.05] {
        let law = format!("hertz {MODULUS} {POISSON} damping restitution {e}");
        for speed in [1e-2, 0.1] {
            approach(
                4000.0,
                &format!("damping restitution {e} at {speed} m/s, no attraction"),
                e,
                2e-5,
                |s| {
                    restitution(
                        &engine,
                        "restitution",
                        &law,
                        speed,
                        hertz_time(speed) / s,
                        6.0,
                    )
                },
            );
        }
        for semi_axes in [[1e-2, 1e-2, 4e-3], [5e-3, 1.2e-2, 7e-3]] {
            let speed = 0.1;
            let grain = |s: f64| Grain {
                density: DENSITY,
                ..Grain::new(semi_axes, [s * semi_axes[0], 0.0, 0.0]).moving([
                    -s * 0.5 * speed,
                    0.0,
                    0.0,
                ])
            };
            let scene = Scene::open(0.1, vec![grain(-1.0), grain(1.0)]);
            // As many steps as in a collision of the spheres. Its time goes with the power 2/5 of mass over stiffness, and the
            // stiffness with the root of the effective radius b c/(2 a).
            let [a, b, c] = semi_axes;
            let mass = a * b * c / RADIUS.powi(3);
            let time = hertz_time(speed) * (mass / (b * c / (a * RADIUS)).sqrt()).powf(0.4);
            approach(
                4000.0,
                &format!("damping restitution {e} of {semi_axes:?}"),
                e,
                2e-5,
                |s| {
                    let deck = Deck {
                        time_step: time / s,
                        steps: (6.0 * s) as u64,
                        skin: 1e-3,
                        ..Deck::new(&law)
                    };
                    let outcome = run(&engine, "restitution", &scene, &deck, 1);
                    let last = outcome.last();
                    assert_eq!(last.states[1].force, [0.0; 3], "still in contact");
                    (last.states[1].velocity[0] - last.states[0].velocity[0]) / speed
                },
            );
        }
    }
}

#[test]
fn both_versions_lsd_restitution() {
    let engine = Engine::from_environment();
    let (m, _) = mass_and_stiffness();
    for z in [0.05, 0.3] {
        let kn: f64 = 1e4;
        let cn = 2.0 * z * (m * kn).sqrt();
        let law = format!("lsd {kn:e} {cn:e} limit_force no");
        let expected = (-std::f64::consts::PI * z / (1.0 - z * z).sqrt()).exp();
        let time = std::f64::consts::PI / (kn / m * (1.0 - z * z)).sqrt();
        for speed in [1e-2, 0.1] {
            converge(
                &format!("lsd z {z} at {speed} m/s"),
                expected,
                VISCOUS_ORDER,
                2e-5,
                |s| {
                    restitution(
                        &engine,
                        "lsd",
                        &law,
                        speed,
                        time / s,
                        1.5 * time / hertz_time(speed),
                    )
                },
            );
        }
    }
}

/// A contact of `s` steps in `time`; grains of type 2 move freely, the others by these commands.
fn moved_by(commands: &[&str], e: f64, time: f64, s: f64) -> Deck {
    let free = ["group free type 2", "fix move free nve/asphere"];
    let law = format!("hertz {MODULUS} {POISSON} damping restitution {e} limit_force no");
    Deck {
        integrate: false,
        fixes: free.iter().chain(commands).map(|c| c.to_string()).collect(),
        time_step: time / s,
        steps: (2.0 * s) as u64,
        skin: 1e-3,
        ..Deck::new(&law)
    }
}

/// A frozen partner counts as infinitely heavy, also while `fix move` moves it: the restitution stays what was asked for. Without `fix freeze` its own
/// mass counts, and a warning says so.
#[test]
fn both_versions_restitution_against_a_grain_that_is_held() {
    let engine = Engine::from_environment();
    let (e, speed) = (0.6, 0.1);
    let heavy = Grain {
        density: DENSITY,
        ..Grain::sphere(RADIUS, [-RADIUS, 0.0, 0.0])
    };
    let mut light = Grain {
        density: DENSITY,
        ..Grain::sphere(RADIUS, [RADIUS, 0.0, 0.0]).moving([-speed, 0.0, 0.0])
    };
    light.kind = 2;
    let scene = Scene::open(0.1, vec![heavy, light]);
    let time = hertz_time(speed) * 2f64.powf(0.4);
    let warning = "count with their own mass in 'damping restitution'";
    let moving = "fix along wall move linear 0.05 0 0";
    for (name, command, wall_speed) in [("frozen", "", 0.0), ("moved", moving, 0.05)] {
        let approaching = speed + wall_speed;
        let what = format!("restitution against a grain that is {name}");
        let duration = time * (approaching / speed).powf(-0.2);
        let commands = ["group wall type 1", "fix still wall freeze", command];
        approach(4000.0, &what, e, 2e-5, |s| {
            let deck = moved_by(&commands, e, duration, s);
            let outcome = run(&engine, name, &scene, &deck, 1);
            let [wall, grain] = [0, 1].map(|k| outcome.last().states[k].velocity[0]);
            assert_eq!(wall, wall_speed, "the velocity of the grain that is {name}");
            assert!(!outcome.output.contains(warning), "{name}: a warning");
            (grain - wall) / approaching
        });
    }
    for command in [moving, ""] {
        let deck = moved_by(&["group wall type 1", command], e, time, 500.0);
        let outcome = run(&engine, "held_by_no_freeze", &scene, &deck, 1);
        let told = outcome.output.matches(warning).count();
        assert_eq!(told, 1, "'{command}' alone: {}", outcome.output);
    }
}

/// The mass of a rigid body counts, not that of the grain that touches: a pair glued together meets a single sphere.
#[test]
fn both_versions_restitution_of_a_rigid_body() {
    let engine = Engine::from_environment();
    let (e, speed) = (0.6, 0.1);
    let grain = |x: f64| Grain {
        density: DENSITY,
        ..Grain::sphere(RADIUS, [x * RADIUS, 0.0, 0.0])
    };
    let mut single = grain(1.0).moving([-speed, 0.0, 0.0]);
    single.kind = 2;
    let scene = Scene::open(0.1, vec![grain(-1.0), grain(-3.0), single]);
    // effective mass 2m m/(2m + m) in place of m/2
    let time = hertz_time(speed) * (4.0f64 / 3.0).powf(0.4);
    approach(4000.0, "restitution of a rigid body", e, 2e-5, |s| {
        let body = [
            "group body type 1",
            "neigh_modify exclude group body body",
            "fix glue body rigid single",
        ];
        let deck = moved_by(&body, e, time, s);
        let outcome = run(&engine, "rigid", &scene, &deck, 1);
        let v = |k: usize| outcome.last().states[k].velocity[0];
        assert!((v(0) - v(1)).abs() < 1e-12 * speed, "the body is not rigid");
        (v(2) - v(0)) / speed
    });
}
