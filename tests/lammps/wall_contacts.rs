// SPDX-License-Identifier: MIT OR Apache-2.0
//! Are the 21 columns of `contacts` the contacts that acted, and the outputs of a wall their sums?

use crate::harness::{
    attempt_in, fresh_directory, last_rows, run, Deck, Engine, Grain, Outcome, Scene,
};
use crate::mesh_walls::{binary, cube};
use crate::moving_walls::load;
use crate::shapes::{
    add, cross, curvature, dot, length, scale, stiffness_of, sub, surface_point, tangents, unit,
    Vector,
};

const GRAVITY: f64 = 98.1;
const RATE: f64 = 10.0;
const STEP: f64 = 2e-5;

/// One row of the local array.
struct Row {
    grain: usize,
    part: usize,
    point: Vector,
    normal: Vector,
    penetration: f64,
    normal_force: f64,
    tangential_force: Vector,
    force: Vector,
    torque: Vector,
    energies: [f64; 2],
}

fn rows(outcome: &Outcome) -> Vec<Row> {
    let row = |r: Vec<f64>| {
        assert_eq!(r.len(), 21);
        let vector = |k: usize| [r[k], r[k + 1], r[k + 2]];
        Row {
            grain: r[0] as usize - 1,
            part: r[1] as usize,
            point: vector(2),
            normal: vector(5),
            penetration: r[8],
            normal_force: r[9],
            tangential_force: vector(10),
            force: vector(13),
            torque: vector(16),
            energies: [r[19], r[20]],
        }
    };
    let all = last_rows(&outcome.directory.join("rows"));
    all.into_iter().map(row).collect()
}

/// Grains that fall onto a wall in motion and touch nothing else.
fn fallen(engine: &Engine, scene: &Scene, law: &str, words: &str, ranks: usize) -> Outcome {
    let columns: Vec<String> = (1..=28).map(|k| format!("f_wall[{k}]")).collect();
    let deck = Deck {
        fixes: vec![
            "neigh_modify exclude group all all".into(),
            format!("fix fall all gravity {GRAVITY} vector 0.8 0 -0.6"),
            format!("fix wall all wall/gran/ellipsoid {law} {words} contacts energies yes"),
        ],
        time_step: STEP,
        steps: 100,
        skin: 1e-3,
        thermo_every: 1,
        thermo_columns: format!("step {}", columns.join(" ")),
        runs: vec![
            "thermo 10000\nrun 4000\nthermo 1".into(),
            "run 100".into(),
            "write_dump all local rows f_wall[*] modify format float %.17g".into(),
        ],
        ..Deck::new(law)
    };
    let directory = fresh_directory("wall_contacts");
    std::fs::write(directory.join("box.stl"), binary(&cube(4))).unwrap();
    attempt_in(engine, directory, scene, &deck, ranks).succeeded()
}

const LAWS: [&str; 3] = [
    "nfd 1e6 0.3 100 100 tangential tfd 0.5 conservative no",
    "nfd 1e6 0.3 100 100 tangential tfd 0.5",
    "hertz 1e6 0.3 damping restitution 0.5 tangential mindlin 0.4 rolling sds 1e3 0.01 0.1 twisting marshall",
];

#[test]
fn both_versions_the_columns_of_contacts_add_up_to_loads_and_outputs() {
    let engine = Engine::from_environment();
    let scene = load();
    let turn = "rotate 0 0 0 1 0 0";
    let period = 2.0 * std::f64::consts::PI / RATE;
    let walls = [
        (
            "drum",
            format!("shape cylinder axis 1 0 0 radius 0.028 bounds -0.02 0.02 ends closed closed side inside {turn} {period:.17}"),
        ),
        (
            "mesh",
            format!("mesh box.stl scale 0.024 velocity 0.05 -0.1 0.02 {turn} {period:.17}"),
        ),
    ];
    for ((name, words), ranks) in walls.iter().zip([4, 1]) {
        for law in LAWS {
            let outcome = fallen(&engine, &scene, law, words, ranks);
            let all = rows(&outcome);
            let states = &outcome.last().states;
            let count = states.len();
            let mut contacts = vec![0; count];
            let mut sums = vec![([0.0; 3], [0.0; 3]); count];
            for row in &all {
                contacts[row.grain] += 1;
                let (force, torque) = &mut sums[row.grain];
                *force = add(*force, row.force);
                *torque = add(*torque, row.torque);
            }
            let twice = contacts.iter().filter(|c| **c > 1).count();
            let largest = sums.iter().map(|s| length(s.0)).fold(0.0, f64::max);
            let reach = 4e-3;
            let mut worst = 0.0f64;
            for ((state, grain), (force, torque)) in states.iter().zip(&scene.grains).zip(&sums) {
                let weight = scale(GRAVITY * grain.mass(), [0.8, 0.0, -0.6]);
                let off = [
                    length(sub(sub(state.force, weight), *force)),
                    length(sub(state.torque, *torque)) / reach,
                ];
                worst = worst.max(off[0].max(off[1]) / largest);
            }
            println!(
                "{name}, {law}: {} contacts, {twice} grains with several: sums off by {worst:.1e}",
                all.len()
            );
            assert!(all.len() > 10 && twice > 2, "{name}, {law}");
            assert!(worst < 1e-12, "{name}, {law}: {worst:e}");

            // parts of each row
            let exact = law.contains("conservative no");
            let mut of_rows = [0.0f64; 3];
            for row in &all {
                let state = &states[row.grain];
                let tangential = row.tangential_force;
                let parts = add(scale(row.normal_force, row.normal), tangential);
                let turning = cross(sub(row.point, state.position), row.force);
                let size = length(row.force).max(1e-3 * largest);
                of_rows[0] = of_rows[0]
                    .max((length(row.normal) - 1.0).abs())
                    .max(dot(row.normal, tangential).abs() / size);
                if exact {
                    of_rows[1] = of_rows[1].max(length(sub(parts, row.force)) / size);
                    of_rows[2] = of_rows[2].max(length(sub(turning, row.torque)) / (size * reach));
                }
                assert!(row.penetration > 0.0 && row.energies[0] > 0.0 && row.energies[1] >= 0.0);
                assert!((1..=5).contains(&row.part), "{}", row.part);
            }
            println!("  normals, forces and torques of each off by {of_rows:?}");
            assert!(
                of_rows.iter().all(|e| *e < 1e-12),
                "{name}, {law}: {of_rows:?}"
            );
            let spun = all
                .iter()
                .filter(|r| length(r.tangential_force) > 0.01 * length(r.force));
            assert!(spun.count() > 5, "{name}, {law}: hardly any friction");

            // outputs of the wall
            let thermo = outcome.thermo();
            let last = thermo.last().unwrap();
            let value = |row: &std::collections::HashMap<String, f64>, k: usize| {
                row[&format!("f_wall[{k}]")]
            };
            let vector = |k: usize| [value(last, k), value(last, k + 1), value(last, k + 2)];
            let (force, torque) = (vector(14), vector(17));
            let about = vector(21);
            let mut expected = ([0.0; 3], [0.0; 3]);
            for (state, (f, t)) in states.iter().zip(&sums) {
                expected.0 = sub(expected.0, *f);
                let arm = cross(sub(state.position, about), *f);
                expected.1 = sub(expected.1, add(arm, *t));
            }
            let total: f64 = sums.iter().map(|s| length(s.0)).sum();
            let off = [
                length(sub(force, expected.0)) / total,
                length(sub(torque, expected.1)) / (total * 0.03),
            ];
            let power = -(dot(force, vector(24)) + RATE * torque[0]);
            let off_power = (value(last, 20) - power).abs() / (total * 0.03 * RATE);
            let energies: [f64; 2] =
                std::array::from_fn(|k| all.iter().map(|r| r.energies[k]).sum::<f64>());
            println!("  force and torque on the wall off by {off:?}, power by {off_power:.1e}");
            assert!(
                off.iter().all(|e| *e < 1e-12) && off_power < 1e-12,
                "{name}, {law}"
            );
            assert_eq!(value(last, 10), all.len() as f64);
            for k in 0..2 {
                let gap = (value(last, 7 + k) - energies[k]).abs();
                assert!(gap <= 1e-12 * (energies[0] + energies[1]), "{name}, {law}");
            }

            // The work of a step is its length times the mean of the powers at its ends: the wall's velocities are steady.
            let mut gaps = 0.0f64;
            let mut most = 0.0f64;
            let steps = thermo.windows(2);
            for pair in steps.filter(|p| p[1]["Step"] == p[0]["Step"] + 1.0) {
                let work = value(&pair[1], 13) - value(&pair[0], 13);
                // about the moved point the velocities and loads of the wall turn alike
                let mean = 0.5 * (value(&pair[0], 20) + value(&pair[1], 20));
                gaps = gaps.max((work / STEP - mean).abs());
                most = most.max(mean.abs());
            }
            println!(
                "  power beside the slope of the work: off by {:.1e}",
                gaps / most
            );
            assert!(
                most > 0.0 && gaps < 1e-9 * most,
                "{name}, {law}: {gaps:e} of {most:e}"
            );
        }
    }
}

/// Without history and rates: penetration, normal, force, point and energy from the grain's pose and the planes of a block.
#[test]
fn both_versions_the_columns_of_contacts_are_the_geometry() {
    let engine = Engine::from_environment();
    let scene = load();
    let law = "hertz 1e6 0.3 damping none tangential mindlin 0.5 conservative no";
    let planes: [(Vector, Vector); 6] = [
        ([0.0, 0.0, -0.02], [0.0, 0.0, 1.0]),
        ([0.0, 0.0, 0.04], [0.0, 0.0, -1.0]),
        ([0.0, -0.025, 0.0], unit([0.0, 1.0, 0.3])),
        ([0.0, 0.025, 0.0], unit([0.0, -1.0, 0.3])),
        ([0.02, 0.0, 0.0], unit([-1.0, 0.0, 0.5])),
        ([-0.02, 0.0, 0.0], unit([1.0, 0.0, 0.2])),
    ];
    let words = planes.map(|([x, y, z], [a, b, c])| {
        format!("shape plane point {x} {y} {z} axis {a:.17} {b:.17} {c:.17} side inside")
    });
    let outcome = fallen(&engine, &scene, law, &words.join(" "), 1);
    let all = rows(&outcome);
    let states = &outcome.last().states;
    let modulus = 1e6 / (2.0 * (1.0 - 0.3 * 0.3));
    let mut worst = [0.0f64; 5];
    let mut parts = [0; 6];
    for row in &all {
        let (grain, state) = (&scene.grains[row.grain], &states[row.grain]);
        parts[row.part - 1] += 1;
        let (point, normal) = planes[row.part - 1];
        let n = scale(-1.0, normal);
        let low = surface_point(grain.semi_axes, state.quaternion, n);
        let depth = dot(n, sub(add(state.position, low), point));
        let (u, v) = tangents(n);
        let half = curvature(grain.semi_axes, state.quaternion, n, u, v).map(|x| 0.5 * x);
        let stiffness = stiffness_of(modulus, half);
        let on_grain = add(state.position, low);
        // between the surfaces of the two
        let along = dot(n, sub(on_grain, row.point)) / depth;
        let aside = sub(sub(on_grain, row.point), scale(along * depth, n));
        assert!((0.0..=1.0).contains(&along), "{along}");
        let errors = [
            length(sub(row.normal, normal)),
            (row.penetration / depth - 1.0).abs(),
            length(aside) / 4e-3,
            (row.normal_force / (stiffness * depth.powf(1.5)) - 1.0).abs(),
            (row.energies[0] / (0.4 * stiffness * depth.powf(2.5)) - 1.0).abs(),
        ];
        for (w, e) in worst.iter_mut().zip(errors) {
            *w = w.max(e);
        }
    }
    println!(
        "{} contacts with the planes {parts:?}: normal {:.1e}, penetration {:.1e}, point {:.1e}, force {:.1e}, energy {:.1e}",
        all.len(), worst[0], worst[1], worst[2], worst[3], worst[4]
    );
    assert!(parts.iter().filter(|count| **count > 0).count() >= 3);
    assert!(worst.iter().all(|e| *e < 1e-8), "{worst:?}");
}

/// A grain that has left the group of a wall, and comes back to it, has no friction of its earlier contact.
#[test]
fn both_versions_a_grain_that_comes_back_to_the_group_remembers_nothing() {
    let engine = Engine::from_environment();
    let law = "hertz 1e7 0.3 tangential mindlin 0.5";
    let grain = Grain::sphere(1.0, [0.0, 0.0, 0.999]).moving([1.0, 0.0, 0.0]);
    let runs = [
        "run 100",
        "group held clear",
        "run 1",
        "group held id 1",
        "run 0",
    ];
    let deck = Deck {
        fixes: vec![
            "group held id 1".into(),
            format!("fix floor held wall/gran/ellipsoid {law} zplane 0 NULL"),
        ],
        runs: runs.iter().map(|line| line.to_string()).collect(),
        time_step: 1e-5,
        thermo_every: 100,
        thermo_columns: "step f_floor[10] f_floor[14]".into(),
        ..Deck::new(law)
    };
    let outcome = run(
        &engine,
        "group_of_wall",
        &Scene::open(10.0, vec![grain]),
        &deck,
        1,
    );
    let rows = outcome.thermo();
    let held = rows.iter().find(|r| r["Step"] == 100.0).unwrap();
    let last = rows.last().unwrap();
    println!(
        "friction {} before, {} after",
        held["f_floor[14]"], last["f_floor[14]"]
    );
    assert!(held["f_floor[14]"] > 0.0);
    assert_eq!((last["f_floor[10]"], last["f_floor[14]"]), (1.0, 0.0));
}
