// SPDX-License-Identifier: MIT OR Apache-2.0
//! Extreme values in every number that a caller gives: an error that names the particle and the value, or numbers that are
//! finite; and whatever is within all ranges at once is computed.

use std::ptr::{null, null_mut};

use ellgran::c_api::contact::*;
use ellgran::c_api::engine_walls::*;
use ellgran::c_api::law::*;
use ellgran::c_api::particles::*;
use ellgran::c_api::plane::*;
use ellgran::c_api::rigid_wall::*;
use ellgran::c_api::servo::*;
use ellgran::c_api::staged::*;
use ellgran::c_api::status::*;

use crate::scene::*;

const EXTREMES: [f64; 26] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    1e308,
    -1e308,
    1e200,
    -1e200,
    1e155,
    1e100,
    1e60,
    1e45,
    1e30,
    -1e30,
    1e20,
    1e15,
    1e6,
    -1.0,
    0.0,
    -0.0,
    1e-20,
    1e-45,
    1e-200,
    f64::MIN_POSITIVE,
    5e-324,
];

/// Doubles of history of a contact, at most, under the laws here.
const LONGEST: usize = 8;

const DECKS: [&str; 7] = [
    "hertz 1e4 0.3",
    "hertz 1e4 0.3 damping restitution 0.5 tangential mindlin 0.5 displacement rescaled",
    "nfd 1e4 0.3 40 60 tangential tfd 0.4",
    "nfd 1e4 0.3 40 60 tangential tfd 0.4 displacement rescaled conservative no",
    "nfd 1e4 0.3 40 60 tangential mindlin 0.4 displacement incremental unloading first_order limit_force no",
    "lsd 1e4 3 tangential linear 800 2 0.3",
    "nfd 1e4 0.3 40 60 viscosity memory tangential tfd 0.4",
];

/// As a message writes it.
fn text(x: f64) -> String {
    if x == 0.0 || !x.is_finite() || (1e-5..1e16).contains(&x.abs()) {
        format!("{x}")
    } else {
        format!("{x:e}")
    }
}

/// A number of a body by its place.
type Field = (&'static str, usize, fn(&mut EllgranBody) -> &mut [f64]);

const FIELDS: [Field; 6] = [
    ("position", 3, |b| &mut b.position),
    ("quaternion", 4, |b| &mut b.quaternion),
    ("semi_axes", 3, |b| &mut b.semi_axes),
    ("velocity", 3, |b| &mut b.velocity),
    ("angular_velocity", 3, |b| &mut b.angular_velocity),
    ("mass", 1, |b| core::slice::from_mut(&mut b.mass)),
];

fn pair_of(shape: [f64; 3]) -> [EllgranBody; 2] {
    let body = |x: f64, identifier: i64| EllgranBody {
        semi_axes: shape,
        quaternion: [0.9, 0.1, -0.2, 0.3],
        velocity: [-0.1 * x, 0.2, 0.1 * x],
        angular_velocity: [0.1, -0.2, 0.3],
        identifier,
        ..sphere_at(x)
    };
    [body(0.0, 1234), body(1.4, 5678)]
}

const SHAPES: [[f64; 3]; 3] = [[1.0, 0.9, 0.8], [0.9, 0.9, 1.1], [0.95; 3]];

/// Both bodies with each of their numbers replaced by each extreme value, and what was replaced.
fn spoiled(mut each: impl FnMut(&str, f64, usize, [EllgranBody; 2])) {
    for shape in SHAPES {
        for (name, length, field) in FIELDS {
            for k in 0..length {
                for x in EXTREMES {
                    for which in 0..2 {
                        let mut bodies = pair_of(shape);
                        field(&mut bodies[which])[k] = x;
                        each(name, x, which, bodies);
                    }
                }
            }
        }
    }
}

#[track_caller]
fn check_message(status: i32, x: f64, which: usize, what: &str) {
    let message = message();
    if status == ELLGRAN_ERROR_PARTICLE {
        let name = ["particle 1234", "particle 5678"][which];
        assert!(message.contains(name), "{what}: {message}");
        // A ratio of semi-axes or a squared length is named with all of them.
        assert!(message.contains(&text(x)), "{what}: {x:e}: {message}");
        assert!(message.len() < 250, "{what}: {message}");
    }
}

fn numbers_of_force(f: &EllgranContactForce) -> Vec<f64> {
    let mut all = vec![
        f.normal_force,
        f.penetration_rate,
        f.elastic_energy,
        f.tangential_energy,
        f.viscous_power,
        f.tangential_power,
    ];
    for v in [
        f.force,
        f.torque_i,
        f.torque_j,
        f.tangential_force,
        f.displacement,
    ] {
        all.extend(v);
    }
    all.extend(f.contact_semi_axes);
    all
}

fn numbers_of_geometry(g: &EllgranContactGeometry) -> Vec<f64> {
    let mut all = vec![g.penetration, g.curvature_a, g.curvature_b];
    for v in [
        g.normal,
        g.contact_point,
        g.witness_i,
        g.witness_j,
        g.major_direction,
    ] {
        all.extend(v);
    }
    all
}

#[track_caller]
fn finite(numbers: &[f64], what: &str) {
    assert!(numbers.iter().all(|x| x.is_finite()), "{what}: {numbers:?}");
}

/// Statuses 0 and others.
#[derive(Default, Debug)]
struct Count([usize; 2]);

/// The outputs of a call for one contact: as they were after a failure, finite after success.
struct One {
    touching: i32,
    history: [f64; LONGEST],
    geometry: Untouched<EllgranContactGeometry>,
    force: Untouched<EllgranContactForce>,
}

impl One {
    fn new(touching: i32, history: [f64; LONGEST]) -> One {
        One {
            touching,
            history,
            geometry: Untouched::sized(),
            force: Untouched::sized(),
        }
    }

    #[track_caller]
    fn check(
        mut self,
        status: i32,
        length: usize,
        given: (i32, [f64; LONGEST]),
        what: &str,
    ) -> usize {
        if status != ELLGRAN_SUCCESS {
            assert_ne!(status, ELLGRAN_ERROR_PANIC, "{what}: {}", message());
            self.geometry.check();
            self.force.check();
            let bits = |h: [f64; LONGEST]| h.map(f64::to_bits);
            assert_eq!(
                (self.touching, bits(self.history)),
                (given.0, bits(given.1)),
                "{what}"
            );
            return 1;
        }
        // SAFETY: written on success.
        let (g, f) = unsafe { (*self.geometry.pointer(), *self.force.pointer()) };
        finite(&numbers_of_geometry(&g), what);
        finite(&numbers_of_force(&f), what);
        assert_eq!(g.touching, i32::from(g.penetration > 0.0), "{what}");
        if length > 0 {
            assert_eq!(g.touching, self.touching, "{what}");
            if self.touching != 0 {
                finite(&self.history[..length], what);
            }
        }
        0
    }
}

fn contact(
    laws: &Laws,
    [i, j]: &[EllgranBody; 2],
    step: &EllgranStep,
    given: (i32, [f64; LONGEST]),
    what: &str,
) -> (i32, usize) {
    let mut one = One::new(given.0, given.1);
    // SAFETY: all pointers are valid.
    let status = unsafe {
        ellgran_contact(
            laws.0,
            i,
            j,
            step,
            &mut one.touching,
            one.history.as_mut_ptr(),
            one.geometry.pointer(),
            one.force.pointer(),
        )
    };
    (status, one.check(status, laws.length(), given, what))
}

fn contact_plane(
    laws: &Laws,
    i: &EllgranBody,
    plane: &EllgranPlane,
    step: &EllgranStep,
    given: (i32, [f64; LONGEST]),
    what: &str,
) -> (i32, usize) {
    let mut one = One::new(given.0, given.1);
    // SAFETY: all pointers are valid.
    let status = unsafe {
        ellgran_contact_plane(
            laws.0,
            i,
            plane,
            1,
            step,
            &mut one.touching,
            one.history.as_mut_ptr(),
            one.geometry.pointer(),
            one.force.pointer(),
        )
    };
    (status, one.check(status, laws.length(), given, what))
}

const PLANE: EllgranPlane = EllgranPlane {
    size: size_of::<EllgranPlane>(),
    point: [0.0, 0.0, -0.7],
    normal: [0.0, 0.1, 1.0],
    velocity: [0.1, 0.2, 0.3],
    velocity_change: [0.0; 3],
};

/// A contact that has lasted, of whatever layout.
const LASTED: (i32, [f64; LONGEST]) = (1, [1.0, 0.0, 0.0, 0.0, 1e-3, -1e-3, 10.0, 0.0]);

#[test]
fn bodies_of_one_contact() {
    for deck in DECKS {
        let laws = Laws::new(&[deck]);
        let mut count = Count::default();
        spoiled(|name, x, which, bodies| {
            let what = format!("{deck}: {name} {x:e}");
            for given in [(0, [0.0; LONGEST]), LASTED] {
                let (status, failed) = contact(&laws, &bodies, &STEP, given, &what);
                check_message(status, x, which, &what);
                count.0[failed] += 1;
                if which == 0 {
                    let (status, failed) =
                        contact_plane(&laws, &bodies[0], &PLANE, &STEP, given, &what);
                    check_message(status, x, which, &what);
                    count.0[failed] += 1;
                }
            }
            let mut geometry = Untouched::<EllgranContactGeometry>::sized();
            let [i, j] = &bodies;
            // SAFETY: all pointers are valid.
            let status =
                unsafe { ellgran_contact_geometry(null(), i, j, null(), geometry.pointer()) };
            if status == ELLGRAN_SUCCESS {
                // SAFETY: written on success.
                finite(&numbers_of_geometry(unsafe { &*geometry.pointer() }), &what);
            } else {
                check_message(status, x, which, &what);
                geometry.check();
            }
        });
        assert!(count.0.iter().all(|n| *n > 500), "{count:?}");
    }
}

#[test]
fn everything_else_of_one_contact() {
    for deck in DECKS {
        let laws = Laws::new(&[deck]);
        let bodies = pair_of(SHAPES[0]);
        for x in EXTREMES {
            let step = EllgranStep {
                time_step: x,
                ..STEP
            };
            let what = format!("{deck}: time_step {x:e}");
            let (status, _) = contact(&laws, &bodies, &step, LASTED, &what);
            assert!(status == 0 || message().contains(&text(x)), "{}", message());
            contact_plane(&laws, &bodies[0], &PLANE, &step, LASTED, &what);
            for k in 0..laws.length() {
                let what = format!("{deck}: history[{k}] {x:e}");
                let mut given = LASTED;
                given.1[k] = x;
                let (status, _) = contact(&laws, &bodies, &STEP, given, &what);
                if status != 0 {
                    let (place, value) = (format!("value {k}"), text(x));
                    let words = ["particle 1234", "particle 5678", &place, &value];
                    fails(status, ELLGRAN_ERROR_HISTORY, &words);
                }
                contact_plane(&laws, &bodies[0], &PLANE, &STEP, given, &what);
                // Of a contact that begins nothing is remembered: nothing is read.
                given.0 = 0;
                ok(contact(&laws, &bodies, &STEP, given, &what).0);
            }
            for k in 0..9 {
                let what = format!("{deck}: plane {k} {x:e}");
                let mut plane = PLANE;
                [&mut plane.point, &mut plane.normal, &mut plane.velocity][k / 3][k % 3] = x;
                let (status, _) = contact_plane(&laws, &bodies[0], &plane, &STEP, LASTED, &what);
                if status != 0 {
                    fails(status, ELLGRAN_ERROR_ARGUMENT, &["plane", &text(x)]);
                }
            }
        }
    }
}

#[test]
fn directions_of_any_length() {
    let laws = Laws::new(&[DECKS[1]]);
    let force = |plane: EllgranPlane, quaternion: [f64; 4]| {
        let mut body = pair_of(SHAPES[0])[0];
        body.quaternion = quaternion;
        let mut one = One::new(0, [0.0; LONGEST]);
        // SAFETY: all pointers are valid.
        ok(unsafe {
            ellgran_contact_plane(
                laws.0,
                &body,
                &plane,
                1,
                &STEP,
                &mut one.touching,
                one.history.as_mut_ptr(),
                null_mut(),
                one.force.pointer(),
            )
        });
        assert_eq!(one.touching, 1);
        // SAFETY: written on success.
        unsafe { (*one.force.pointer()).force }
    };
    let q = [0.9, 0.1, -0.2, 0.3];
    let expected = force(PLANE, q);
    for scale in [
        1e-300, 1e-200, 1e-140, 1e-60, 7.0, 1e60, 1e141, 1e200, 1e307,
    ] {
        let longer = EllgranPlane {
            normal: PLANE.normal.map(|x| x * scale),
            ..PLANE
        };
        for found in [force(longer, q), force(PLANE, q.map(|x| x * scale))] {
            for k in 0..3 {
                let error = (found[k] - expected[k]).abs();
                assert!(error <= 1e-12 * expected[2].abs(), "{scale:e}: {error:e}");
            }
        }
    }
}

/// A list of one pair that touches, one that does not, and another.
struct Scene {
    arrays: Arrays,
    list: List,
    workspace: WorkspaceHandle,
}

impl Scene {
    fn new(laws: &Laws, bodies: &[EllgranBody; 2]) -> Scene {
        let shape = bodies[1]
            .semi_axes
            .map(|a| if a > 0.0 && a < 1e3 { a } else { 1.0 });
        let more = [2.8, 9.0].map(|x| EllgranBody {
            semi_axes: shape,
            ..sphere_at(x)
        });
        let all = [bodies[0], bodies[1], more[0], more[1]];
        Scene {
            arrays: Arrays::new(&all, 4),
            list: List::new(vec![vec![1, 2, 3], vec![2, 3], vec![3]], laws.length()),
            workspace: WorkspaceHandle::new(),
        }
    }

    /// Status, and whether all that was written is finite; after a failure nothing may be.
    fn call(&mut self, laws: &Laws, step: &EllgranStep, unchanged: i32, what: &str) -> i32 {
        let before = (
            self.arrays.forces.clone(),
            self.arrays.torques.clone(),
            self.list.touching.clone(),
            self.list.history.clone(),
        );
        let (particles, mut view) = (self.arrays.particles(), self.list.view(true));
        view.unchanged = unchanged;
        let mut tallies = no_tallies();
        let status = laws.pairs(&self.workspace, &particles, &view, step, &mut tallies);
        let forces = [&self.arrays.forces[..], &self.arrays.torques]
            .concat()
            .concat();
        let bits = |rows: &[Vec<f64>]| -> Vec<u64> {
            rows.iter().flatten().map(|x| x.to_bits()).collect()
        };
        if status == ELLGRAN_SUCCESS {
            finite(&forces, what);
            for (touching, history) in self.list.touching.iter().zip(&self.list.history) {
                let length = laws.length();
                for (k, _) in touching.iter().enumerate().filter(|(_, t)| **t != 0) {
                    finite(&history[k * length..(k + 1) * length], what);
                }
            }
            finite(
                &[
                    tallies.viscous_dissipation,
                    tallies.tangential_work,
                    tallies.frictional_dissipation,
                    tallies.dissipated_energy,
                    tallies.normal_elastic_energy,
                    tallies.tangential_elastic_energy,
                    tallies.touching_count,
                ],
                what,
            );
            finite(&tallies.virial, what);
        } else {
            assert_ne!(status, ELLGRAN_ERROR_PANIC, "{what}: {}", message());
            assert_eq!(forces, [before.0, before.1].concat().concat(), "{what}");
            assert_eq!(self.list.touching, before.2, "{what}");
            assert_eq!(bits(&self.list.history), bits(&before.3), "{what}");
        }
        status
    }
}

/// Run for every instruction set by `instruction_sets`.
#[test]
fn lists() {
    for deck in DECKS {
        let laws = Laws::new(&[deck]);
        let mut count = Count::default();
        spoiled(|name, x, which, bodies| {
            let what = format!("{deck}: {name} {x:e}");
            // In a new list, and from one step to the next of an old one.
            let mut scene = Scene::new(&laws, &bodies);
            let status = scene.call(&laws, &STEP, 0, &what);
            check_message(status, x, which, &what);
            count.0[usize::from(status != 0)] += 1;
            let mut scene = Scene::new(&laws, &pair_of(bodies[1 - which].semi_axes));
            ok(scene.call(&laws, &STEP, 0, &what));
            let spoiled = Scene::new(&laws, &bodies).arrays;
            scene.arrays = Arrays {
                forces: scene.arrays.forces.clone(),
                torques: scene.arrays.torques.clone(),
                ..spoiled
            };
            let status = scene.call(&laws, &STEP, 1, &what);
            check_message(status, x, which, &what);
        });
        assert!(count.0.iter().all(|n| *n > 200), "{count:?}");
        let length = laws.length();
        for shape in SHAPES {
            for x in EXTREMES {
                for k in 0..length {
                    let what = format!("{deck}: history[{k}] {x:e}");
                    let mut scene = Scene::new(&laws, &pair_of(shape));
                    scene.list.touching[0][0] = 1;
                    scene.list.history[0][..length].copy_from_slice(&LASTED.1[..length]);
                    scene.list.history[0][k] = x;
                    let status = scene.call(&laws, &STEP, 0, &what);
                    if status != 0 {
                        let (place, value) = (format!("value {k}"), text(x));
                        let words = ["particle 1234", "particle 5678", &place, &value];
                        fails(status, ELLGRAN_ERROR_HISTORY, &words);
                    } else {
                        assert!(k < 3 || x.abs() <= [1e140, 1e200][k / 6], "{what}");
                    }
                }
                let step = EllgranStep {
                    time_step: x,
                    ..STEP
                };
                let mut scene = Scene::new(&laws, &pair_of(shape));
                let what = format!("{deck}: time_step {x:e}");
                let status = scene.call(&laws, &step, 0, &what);
                assert!(status == 0 || message().contains(&text(x)), "{}", message());
            }
        }
    }
}

#[test]
fn momenta_and_masses() {
    for deck in DECKS {
        let laws = Laws::new(&[deck]);
        for x in EXTREMES {
            for spoil in [0, 1, 2] {
                let what = format!("{deck}: {spoil} {x:e}");
                let mut scene = Scene::new(&laws, &pair_of(SHAPES[0]));
                let mut momenta = [[0.1, 0.2, -0.1]; 4];
                let mut masses = [1.0; 4];
                let mut contact_masses = [1.0; 4];
                match spoil {
                    0 => momenta[1][1] = x,
                    1 => masses[1] = x,
                    _ => contact_masses[1] = x,
                }
                let mut particles = scene.arrays.particles();
                particles.angular_velocities = null();
                particles.angular_momenta = momenta.as_ptr().cast();
                particles.masses = masses.as_ptr();
                particles.contact_masses = contact_masses.as_ptr();
                let view = scene.list.view(true);
                let status = laws.pairs(&scene.workspace, &particles, &view, &STEP, null_mut());
                let forces = [&scene.arrays.forces[..], &scene.arrays.torques]
                    .concat()
                    .concat();
                finite(&forces, &what);
                if status == 0 {
                    finite(&scene.list.history.concat(), &what);
                } else {
                    fails(status, ELLGRAN_ERROR_PARTICLE, &["particle 5678"]);
                    assert!(forces.iter().all(|f| *f == 0.0), "{what}");
                }
            }
        }
    }
}

/// A number between powers of ten, each as likely.
fn power(random: &mut Random, least: f64, most: f64) -> f64 {
    10f64.powf(random.between(least, most))
}

/// Two bodies, laws and a step from all over the ranges, and often at their ends.
fn anything(random: &mut Random) -> (String, [EllgranBody; 2], EllgranStep) {
    let end = |random: &mut Random, most: f64| {
        if random.between(0.0, 1.0) < 0.3 {
            most
        } else {
            random.between(-most, most)
        }
    };
    let size = end(random, 19.99);
    let mut bodies = [sphere_at(0.0); 2];
    for (k, body) in bodies.iter_mut().enumerate() {
        let own = (size + random.between(-3.0, 3.0)).clamp(-19.9, 19.9);
        let spread = random.between(0.0, 5.9);
        let clamp = |x: f64| 10f64.powf(x.clamp(-19.9, 19.9));
        body.semi_axes = [
            clamp(own),
            clamp(own - spread),
            clamp(own - spread * random.between(0.0, 1.0)),
        ];
        body.quaternion = random.vector(-1.0, 1.0);
        let speed = end(random, 24.7);
        body.velocity = random.vector::<3>(-1.0, 1.0).map(|v| v * 10f64.powf(speed));
        let spin = end(random, 24.7);
        body.angular_velocity = random.vector::<3>(-1.0, 1.0).map(|w| w * 10f64.powf(spin));
        body.mass = 10f64.powf(end(random, 49.9));
        body.identifier = 1234 + k as i64;
    }
    // From coincident to just apart.
    let reach = bodies.map(|b| b.semi_axes.into_iter().fold(0.0, f64::max));
    let far = random.between(0.0, 1.0).powi(3) * (reach[0] + reach[1]);
    bodies[1].position = random
        .vector::<3>(-1.0, 1.0)
        .map(|x| (x * far).clamp(-1e20, 1e20));
    let step = EllgranStep {
        size: size_of::<EllgranStep>(),
        time_step: 10f64.powf(end(random, 14.9)),
        advance_history: 1,
    };
    let mut constant = || 10f64.powf(end(random, 49.9));
    let (e, eta1, eta2, mu, kt, ct) = (
        constant(),
        constant(),
        constant(),
        constant(),
        constant(),
        constant(),
    );
    let displacement = ["total", "incremental", "rescaled"][(far.to_bits() % 3) as usize];
    let deck = match far.to_bits() % 8 {
        0 => format!("hertz {e:e} 0.3 tangential tfd {mu:e} displacement {displacement}"),
        1 => format!("hertz {e:e} 0.3 damping restitution 0.1 tangential mindlin {mu:e} displacement {displacement}"),
        2 => format!("nfd {e:e} 0.2 {eta1:e} {eta2:e} tangential tfd {mu:e} displacement {displacement}"),
        3 => format!("nfd {e:e} 0.49 {eta1:e} {eta2:e} unloading first_order limit_force no"),
        4 => format!("lsd {e:e} {eta1:e} tangential linear {kt:e} {ct:e} {mu:e} displacement {displacement}"),
        6 => format!("nfd {e:e} 0.2 {eta1:e} {eta2:e} viscosity memory tangential tfd {mu:e} displacement {displacement}"),
        5 => format!("hertz {e:e} 0 damping relaxation 1e20 tangential mindlin {mu:e} displacement {displacement}"),
        _ => format!("nfd {e:e} 0.2 {eta1:e} {eta2:e} conservative no tangential mindlin {mu:e} displacement {displacement}"),
    };
    (deck, bodies, step)
}

#[test]
fn contacts_at_the_ends_of_all_ranges() {
    let mut random = Random(77);
    let mut touching = 0;
    for _ in 0..4000 {
        let (deck, bodies, step) = anything(&mut random);
        let what = format!("{deck}: {bodies:?} {step:?}");
        let laws = Laws::new(&[&deck]);
        let mut given = (0, [0.0; LONGEST]);
        for _ in 0..3 {
            let mut one = One::new(given.0, given.1);
            let (g, f) = (one.geometry.pointer(), one.force.pointer());
            let [i, j] = &bodies;
            let (t, h): (*mut i32, *mut f64) = (&mut one.touching, one.history.as_mut_ptr());
            // SAFETY: all pointers are valid.
            let status = unsafe { ellgran_contact(laws.0, i, j, &step, t, h, g, f) };
            assert_eq!(status, ELLGRAN_SUCCESS, "{}: {what}", message());
            given = (one.touching, one.history);
            touching += given.0;
            one.check(status, laws.length(), given, &what);
        }
        let plane = EllgranPlane {
            size: size_of::<EllgranPlane>(),
            point: random
                .vector::<3>(-1.0, 1.0)
                .map(|x| x * power(&mut random, -20.0, 19.7)),
            normal: random.vector(-1.0, 1.0),
            velocity: bodies[1].velocity,
            velocity_change: bodies[1].velocity_change,
        };
        let (status, _) =
            contact_plane(&laws, &bodies[0], &plane, &step, (0, [0.0; LONGEST]), &what);
        assert_eq!(status, ELLGRAN_SUCCESS, "{}: {what}", message());
    }
    assert!(touching > 1000, "{touching}");
}

/// Run for every instruction set by `instruction_sets`.
#[test]
fn lists_at_the_ends_of_all_ranges() {
    let mut random = Random(78);
    let mut touching = 0;
    for k in 0..3000 {
        let (deck, mut bodies, step) = anything(&mut random);
        if k % 3 > 0 {
            // The closed forms of spheres and of grains of revolution.
            for body in &mut bodies {
                body.semi_axes[1] = body.semi_axes[0];
                if k % 3 == 2 {
                    body.semi_axes[2] = body.semi_axes[0];
                }
            }
        }
        let laws = Laws::new(&[&deck]);
        let what = format!("{deck}: {bodies:?} {step:?}");
        let mut scene = Scene {
            arrays: Arrays::new(&bodies, 2),
            list: List::new(vec![vec![1]], laws.length()),
            workspace: WorkspaceHandle::new(),
        };
        for unchanged in [0, 1, 1] {
            let status = scene.call(&laws, &step, unchanged, &what);
            assert_eq!(status, ELLGRAN_SUCCESS, "{}: {what}", message());
            touching += scene.list.touching.iter().flatten().sum::<i32>();
        }
    }
    assert!(touching > 500, "{touching}");
}

struct Staged(*mut EllgranStagedContact);

impl Drop for Staged {
    fn drop(&mut self) {
        // SAFETY: made by ellgran_staged_new and not used again.
        unsafe { ellgran_staged_free(self.0) }
    }
}

#[test]
fn stages() {
    let mut staged = null_mut();
    // SAFETY: valid for writes.
    ok(unsafe { ellgran_staged_new(&mut staged) });
    let staged = Staged(staged);
    let [i, j] = pair_of(SHAPES[0]);
    let (mut geometry, mut normal) = (Untouched::<EllgranStagedGeometry>::sized(), [0.0; 3]);
    let g = geometry.pointer();
    // SAFETY: all pointers are valid, here and below.
    let pair =
        |n: &mut [f64; 3]| unsafe { ellgran_staged_pair(staged.0, &i, &j, 0.5, n.as_mut_ptr(), g) };
    ok(pair(&mut normal));
    for deck in [DECKS[1], DECKS[2], DECKS[4]] {
        let laws = Laws::new(&[deck]);
        for x in EXTREMES {
            let what = format!("{deck}: {x:e}");
            let mut force = Untouched::<EllgranContactForce>::sized();
            let f = force.pointer();
            let status = unsafe { ellgran_staged_normal(staged.0, laws.0, 1, 1, x, f) };
            let reads_mass = deck.contains("restitution");
            if status == 0 {
                finite(&numbers_of_force(unsafe { &*f }), &what);
                assert!(!reads_mass || (0.0..=1e50).contains(&x), "{what}");
            } else {
                fails(
                    status,
                    ELLGRAN_ERROR_ARGUMENT,
                    &["effective_mass", &text(x)],
                );
                assert!(reads_mass);
                force.check();
            }
            for place in 0..10 {
                let mut history = EllgranStagedHistory {
                    size: size_of::<EllgranStagedHistory>(),
                    friction: 0.4,
                    touched: 1,
                    normal,
                };
                let mut memory = [1e-3, -1e-3, 2e-3, 1e-3];
                let mut step = STEP;
                let mut mass = 1.0;
                match place {
                    0..3 => memory[place] = x,
                    3..6 => history.normal[place - 3] = x,
                    6 => history.friction = x,
                    7 => step.time_step = x,
                    9 if laws.length() > 6 => memory[3] = x,
                    _ => mass = x,
                }
                let given = memory;
                for call in [ellgran_staged_tangential, ellgran_staged_forces] {
                    let mut force = Untouched::<EllgranContactForce>::sized();
                    let (f, m) = (force.pointer(), memory.as_mut_ptr());
                    let status =
                        unsafe { call(staged.0, laws.0, 1, 1, mass, &step, &history, m, f) };
                    if status == 0 {
                        finite(&numbers_of_force(unsafe { &*f }), &what);
                        finite(&memory, &what);
                    } else {
                        assert!(message().contains(&text(x)), "{place}: {}", message());
                        force.check();
                        assert_eq!(memory.map(f64::to_bits), given.map(f64::to_bits));
                    }
                    memory = given;
                }
            }
        }
    }
    for x in EXTREMES {
        for k in 0..3 {
            let mut start = [1.0, 0.0, 0.0];
            start[k] = x;
            ok(pair(&mut start));
            finite(&start, "cached normal");
        }
    }
}

#[test]
fn walls() {
    let [body, _] = pair_of(SHAPES[0]);
    let workspace = WorkspaceHandle::new();
    // One number of a wall is extreme: an error that shows it, or contacts that are finite.
    let check = |wall: &WallHandle, status: i32, x: f64, what: &str| {
        if status != 0 {
            assert_ne!(status, ELLGRAN_ERROR_PANIC, "{what}: {}", message());
            assert!(message().contains(&text(x)), "{what} {x:e}: {}", message());
            return;
        }
        let mut arrays = Arrays::new(&[body], 1);
        let particles = arrays.particles();
        // SAFETY: all pointers are valid.
        unsafe {
            ok(ellgran_find_wall_contacts(
                workspace.0,
                wall.0,
                &particles,
                null(),
                0,
                null(),
                0,
                null(),
            ));
            for k in 0..ellgran_wall_found_count(wall.0) {
                let mut found = Untouched::<EllgranFoundWallContact>::sized();
                ok(ellgran_wall_found(wall.0, k, found.pointer()));
                let c = *found.pointer();
                for v in [c.point, c.velocity] {
                    finite(&v, &format!("{what} {x:e}"));
                }
            }
        }
    };
    let add = |given: EllgranWallShape, x: f64, what: &str| {
        let wall = WallHandle::new();
        // SAFETY: all pointers are valid.
        let status = unsafe { ellgran_wall_add_shape(wall.0, &given) };
        check(&wall, status, x, what);
    };
    let triangles = [
        [[-5.0, -5.0, -0.7], [5.0, -5.0, -0.7], [0.0, 5.0, -0.7]],
        [[0.0, 5.0, -0.7], [5.0, -5.0, -0.7], [5.0, 5.0, -0.6]],
    ];
    for x in EXTREMES {
        for k in 0..6 {
            let mut given = [[0.0, 0.0, -0.7], [0.0, 0.1, 1.0]];
            given[k / 3][k % 3] = x;
            let [point, axis] = given;
            for name in [c"plane", c"cylinder"] {
                let one = EllgranWallShape {
                    point,
                    axis,
                    radii: [0.9, 0.0],
                    ..shape(name)
                };
                add(one, x, name.to_str().unwrap());
            }
        }
        for name in [c"cylinder", c"sphere"] {
            let one = EllgranWallShape {
                radii: [x, 0.0],
                ..shape(name)
            };
            add(one, x, "radius");
        }
        for k in 0..36 {
            let (mut corners, mut velocities) = (triangles, [[[0.0; 3]; 3]; 2]);
            let given = if k < 18 {
                &mut corners
            } else {
                &mut velocities
            };
            given[k % 18 / 9][k / 3 % 3][k % 3] = x;
            let wall = WallHandle::new();
            let (starts, near) = ([0, 2], [0, 1]);
            let lent = EllgranLentTriangles {
                size: size_of::<EllgranLentTriangles>(),
                count: 2,
                corners: corners.as_ptr().cast(),
                velocities: velocities.as_ptr().cast(),
                particle_count: 1,
                near_starts: starts.as_ptr(),
                near: near.as_ptr(),
                velocity_changes: velocities.as_ptr().cast(),
            };
            // SAFETY: all pointers are valid.
            let status = unsafe { ellgran_wall_lend_triangles(wall.0, &lent) };
            check(&wall, status, x, "triangles");
        }
    }
}

#[test]
fn surfaces_of_walls() {
    let mut staged = null_mut();
    // SAFETY: all pointers are valid, here and below.
    ok(unsafe { ellgran_staged_new(&mut staged) });
    let staged = Staged(staged);
    let [body, _] = pair_of(SHAPES[0]);
    let laws = Laws::new(&[DECKS[2]]);
    for x in EXTREMES {
        for k in 0..23 {
            let what = format!("wall {k} {x:e}");
            let mut wall = EllgranWallSurface {
                size: size_of::<EllgranWallSurface>(),
                point: [0.0, 0.0, -0.7],
                normal: [0.0, 0.0, 1.0],
                direction: [1.0, 0.0, 0.0],
                curvatures: [0.0, -0.1],
                turning_radii: [f64::INFINITY, -10.0],
                velocity: [0.0; 3],
                others_share: 0.3,
                others_share_by_position: [0.0, 0.1, 0.0],
                others_share_by_rotation: [0.0; 3],
                velocity_change: [0.0; 3],
            };
            match k {
                0..3 => wall.point[k] = x,
                3..6 => wall.normal[k - 3] = x,
                6..9 => wall.direction[k - 6] = x,
                9..11 => wall.curvatures[k - 9] = x,
                11..13 => wall.turning_radii[k - 11] = x,
                13..16 => wall.velocity[k - 13] = x,
                16 => wall.others_share = x,
                17..20 => wall.others_share_by_position[k - 17] = x,
                _ => wall.others_share_by_rotation[k - 20] = x,
            }
            let mut geometry = Untouched::<EllgranStagedGeometry>::sized();
            let g = geometry.pointer();
            let status = unsafe { ellgran_staged_wall(staged.0, &body, &wall, 0.5, g) };
            if status != 0 {
                // A normal may turn so far that the given direction lies along it.
                let along = (3..6).contains(&k) && message().contains("direction = (1 0 0)");
                let value = if along { "wall".into() } else { text(x) };
                fails(status, ELLGRAN_ERROR_ARGUMENT, &["wall", &value]);
                geometry.check();
                continue;
            }
            if unsafe { (*g).touching } == 0 {
                continue;
            }
            let mut force = Untouched::<EllgranContactForce>::sized();
            let f = force.pointer();
            let history = EllgranStagedHistory {
                size: size_of::<EllgranStagedHistory>(),
                friction: 0.4,
                touched: 0,
                normal: [0.0; 3],
            };
            let mut memory = [0.0; 4];
            let m = memory.as_mut_ptr();
            let status = unsafe {
                ellgran_staged_forces(staged.0, laws.0, 1, 1, 1.0, &STEP, &history, m, f)
            };
            if status == 0 {
                finite(&numbers_of_force(unsafe { &*f }), &what);
                finite(&memory, &what);
            } else {
                fails(status, ELLGRAN_ERROR_RESULT, &["particle 1234"]);
            }
        }
    }
}

#[test]
fn constants_of_the_laws() {
    type Constant = fn(&mut EllgranLawParameters) -> &mut f64;
    let constants: [Constant; 11] = [
        |p| &mut p.youngs_modulus,
        |p| &mut p.poissons_ratio,
        |p| &mut p.shear_viscosity,
        |p| &mut p.bulk_viscosity,
        |p| &mut p.relaxation_time,
        |p| &mut p.restitution,
        |p| &mut p.normal_stiffness,
        |p| &mut p.normal_damping,
        |p| &mut p.friction,
        |p| &mut p.tangential_stiffness,
        |p| &mut p.tangential_damping,
    ];
    let bodies = pair_of(SHAPES[0]);
    for deck in DECKS
        .into_iter()
        .chain(["hertz 1e4 0.3 damping relaxation 0.1"])
    {
        for x in EXTREMES {
            for constant in constants {
                let mut p = parse(deck);
                *constant(&mut p) = x;
                let mut laws = null_mut();
                // SAFETY: one type, one pair.
                let status = unsafe { ellgran_laws_new(1, &p, &1, 0, &mut laws) };
                if status != 0 {
                    fails(status, ELLGRAN_ERROR_LAW, &[&text(x)]);
                    assert!(message().len() < 250, "{}", message());
                    continue;
                }
                let laws = Laws(laws);
                let what = format!("{deck}: {x:e}");
                let (status, _) = contact(&laws, &bodies, &STEP, (0, [0.0; LONGEST]), &what);
                assert_eq!(status, 0, "{what}: {}", message());
            }
        }
    }
}

/// What is left of the place of a centre on an oblique axis is rounding, which may lie along the axis. The force is across it: along it
/// nothing changes.
#[test]
fn a_grain_on_the_axis_of_an_oblique_cylinder() {
    let laws = Laws::new(&[DECKS[0]]);
    let workspace = WorkspaceHandle::new();
    let along = |k: u32| 1e-2 * f64::from(k) - 1.16082763671875;
    let mut given = shape(c"cylinder");
    given.point = [-0.72161865234375; 3];
    given.axis = [1.0; 3];
    given.radii = [1.0; 2];
    given.side = ELLGRAN_SIDE_OUTSIDE;
    let wall = WallHandle::new();
    ok(unsafe { ellgran_wall_add_shape(wall.0, &given) });
    let mut histories = wall.histories(&laws, 1);
    for k in 0..100 {
        let mut bodies = [sphere_at(0.0)];
        bodies[0].position = [along(k); 3];
        // A sphere is the same in all directions.
        bodies[0].semi_axes = if k % 2 == 0 {
            [1.1, 1.0, 0.9]
        } else {
            [1.1; 3]
        };
        let mut arrays = Arrays::new(&bodies, 1);
        let particles = arrays.particles();
        let mut load = NO_LOAD;
        ok(unsafe {
            ellgran_compute_wall(
                laws.0,
                workspace.0,
                wall.0,
                &particles,
                null(),
                0,
                1,
                null(),
                histories.as_mut_ptr(),
                &STEP,
                &mut load,
                null_mut(),
            )
        });
        let [x, y, z] = load.force;
        let size = (x * x + y * y + z * z).sqrt();
        let of_axis = (x + y + z).abs() / 3.0_f64.sqrt();
        assert!(of_axis <= 1e-9 * size, "{:?} {load:?}", along(k));
        assert!(size > 0.0, "{load:?}");
    }
}

#[test]
fn a_servo_under_loads_of_any_size() {
    let sizes = [0.0, 1e-300, 1.0, 1e300, f64::MAX];
    let mut servo = EllgranServo {
        size: size_of::<EllgranServo>(),
        target: 0.0,
        gain: 1.0,
        largest_speed: 1e3,
        steady_velocity: 0.0,
        velocity: 0.0,
    };
    for target in sizes {
        for force in [f64::MIN, 0.0, 1.0, f64::MAX] {
            for stiffness in sizes {
                for damping in sizes {
                    for time_step in [1e-300, 1.0, f64::MAX] {
                        servo.target = target;
                        ok(unsafe {
                            ellgran_servo_follow(&mut servo, force, stiffness, damping, time_step)
                        });
                        let given = (force, stiffness, damping, time_step);
                        assert!(servo.velocity.abs() <= 1e3, "{servo:?} {given:?}");
                        assert!(servo.steady_velocity.abs() <= 1e3, "{servo:?} {given:?}");
                    }
                }
            }
        }
    }
}
